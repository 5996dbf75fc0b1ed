//! Compositing: light of several lines added up in the windows of a tile.
//!
//! Lines are drawn in windows of their own, where a Gaussian is stepped from its middle, and moved by whole rows to
//! where the tile's windows lie ([`SecondaryLight::windows`]). What falls outside of both is lost.

use multiversion::multiversion;

use super::electrons::{Scratch, Window};
use super::line_image::{add_beyond, add_transmitted_beyond, draw_transmitted};
use crate::optics::light::{ROWS, Reflection, ScanLine, SecondaryLight, WindowNeed};
use crate::optics::speckle::TILE;
use numerics::lanes::exp;

/// Standard deviations beyond which an image is left out.
const REACH_SIGMAS: f32 = 5.0;

/// Puts the windows of `scratch` where those of a tile lie; the first one holds the line alone.
pub fn stand(secondary: &SecondaryLight, tile: usize, scratch: &mut Scratch) {
    let (need, start) = (secondary.needs[tile], tile * TILE);
    if need == WindowNeed::Line {
        return;
    }
    let Scratch { windows, spare, used, .. } = scratch;
    *used = if need == WindowNeed::Two { 2 } else { 1 };
    let places = [0, 1].map(|number| load_rows(&secondary.windows[number], start));
    if windows[0].first_row != places[0] {
        std::mem::swap(&mut windows[0], spare);
        windows[0].darken();
        windows[0].first_row = places[0];
        windows[1].first_row = places[1];
        windows[1].darken();
        add_shifted(spare, &mut windows[..*used], &[], 1.0);
    } else {
        windows[1].first_row = places[1];
        windows[1].darken();
    }
}

/// Adds what lies beside the line to `scratch`, whose first window holds the line of `own` alone; `neighbours` are what
/// a row of a window each looks at.
pub fn composite(
    own: &ScanLine,
    neighbours: &[&ScanLine; ROWS],
    secondary: &SecondaryLight,
    tile: usize,
    scratch: &mut Scratch,
) {
    if secondary.needs[tile] == WindowNeed::Line {
        return;
    }
    let start = tile * TILE;
    let drawn = scratch.windows[0].first_row;
    stand(secondary, tile, scratch);
    let Scratch { windows, spare, used, .. } = scratch;
    let windows = &mut windows[..*used];
    for window in windows.iter_mut() {
        add_beyond(own, neighbours, start, &drawn, window);
    }
    let line = &secondary.transmitted;
    if line.columns.start < start + TILE && line.columns.end > start {
        let neighbours =
            neighbours.map(|other| other.secondary.as_ref().map_or(line, |secondary| &secondary.transmitted));
        draw_transmitted(line, &neighbours, start, spare);
        add_shifted(spare, windows, &line.metal[start..start + TILE], 1.0);
        for window in windows.iter_mut() {
            add_transmitted_beyond(line, &neighbours, start, &spare.first_row, window);
        }
    }
    for reflection in secondary.tile(tile) {
        add_reflection(reflection, start, windows);
    }
}

/// Adds mirror images in the film's own surface, which per-line models leave to the surface as they do the line's own
/// glare; what foil shows is theirs.
pub(crate) fn add_surface_reflections(secondary: &SecondaryLight, tile: usize, windows: &mut [Window]) {
    for reflection in secondary.tile(tile).iter().filter(|reflection| !reflection.in_foil) {
        add_reflection(reflection, tile * TILE, windows);
    }
}

fn load_rows(rows: &[i32], start: usize) -> [i32; TILE] {
    std::array::from_fn(|c| rows[start + c])
}

/// Adds `share` of the light of one window to others, row by row of the sensor; what comes from below counts as light
/// from the surface in columns of `metal`.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(crate) fn add_shifted(from: &Window, to: &mut [Window], metal: &[bool], share: f32) {
    for window in to.iter_mut() {
        let off = |c: usize| from.first_row[c] - window.first_row[c];
        let mut start = 0;
        while start < TILE {
            // Neighbours that move alike are added together.
            let alike = |c: usize| off(c) == off(start) && metal.get(c) == metal.get(start);
            let end = (start + 1..TILE).find(|&c| !alike(c)).unwrap_or(TILE);
            let (off, rows) = (off(start), ROWS as i32);
            let columns = start..end;
            for k in (-off).max(0)..(rows - off).min(rows) {
                let (k, there) = (k as usize, (k + off) as usize);
                let surface = from.surface[k][columns.clone()].iter().zip(&from.volume[k][columns.clone()]);
                let lit = &mut window.surface[there][columns.clone()];
                if metal.get(start).is_some_and(|&metal| metal) {
                    for (sum, (surface, volume)) in lit.iter_mut().zip(surface) {
                        *sum += share * surface + share * volume;
                    }
                } else {
                    for ((sum, below), (surface, volume)) in
                        lit.iter_mut().zip(&mut window.volume[there][columns.clone()]).zip(surface)
                    {
                        *sum += share * surface;
                        *below += share * volume;
                    }
                }
            }
            start = end;
        }
    }
}

/// Adds an image; light that a film sends out from below its surface.
fn add_reflection(reflection: &Reflection, start: usize, windows: &mut [Window]) {
    let column = reflection.column - start;
    let reach = REACH_SIGMAS * reflection.variance.sqrt();
    for window in windows {
        let middle = reflection.row - window.first_row[column] as f32;
        let (low, high) = ((middle - reach).ceil().max(0.0), (middle + reach).floor().min(ROWS as f32 - 1.0));
        if low > high {
            continue;
        }
        let light = image_rows(reflection, middle);
        for k in low as usize..high as usize + 1 {
            window.volume[k][column] += light[k];
        }
    }
}

/// Light of an image about `middle` in all rows of a window.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn image_rows(reflection: &Reflection, middle: f32) -> [f32; ROWS] {
    let (scale, variance) = (reflection.peak(), reflection.variance);
    let mut light = [0.0f32; ROWS];
    for k in 0..ROWS {
        let d = k as i32 as f32 - middle;
        light[k] = scale * exp(-0.5 * d * d / variance);
    }
    light
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two images, one of them in foil, models that follow light through packs get the one in the film's surface
    /// alone, and the kernel both.
    #[test]
    fn what_foil_shows_is_drawn_once() {
        let image = |in_foil: bool| Reflection { column: 3, row: 22.0, variance: 4.0, electrons: 1000.0, in_foil };
        let secondary = SecondaryLight { reflections: vec![image(false), image(true)], ..SecondaryLight::default() };
        let light = |add: &dyn Fn(&mut [Window])| {
            let mut windows = [Window::default()];
            add(&mut windows);
            windows[0].volume.iter().map(|row| row[3]).sum::<f32>()
        };
        let one = light(&|windows| add_surface_reflections(&secondary, 0, windows));
        let both = light(&|windows| secondary.tile(0).iter().for_each(|image| add_reflection(image, 0, windows)));
        assert!((one - 1000.0).abs() < 5.0 && (both - 2000.0).abs() < 10.0, "{one} and {both}");
    }
}
