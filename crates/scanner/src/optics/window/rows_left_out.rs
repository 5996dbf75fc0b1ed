//! Rows of a window that are left out: how much light can fall on them.
//!
//! Where a tile shows nothing but a line, the rows about it are drawn alone. Light of width j in a pixel d rows from
//! the line's middle is source_j(column) G_j(d) exit_j(column, row); of the rows left out, d is no less than that of
//! the nearest, and the exit no more than the greatest of the tile there. Speckle multiplies it by a number that is
//! hardly ever exceeded ([`AnchoredSpeckle::brightest`](crate::optics::speckle::AnchoredSpeckle::brightest)). Whether a
//! pixel with that much light could be read as a peak is for the digitiser to say, which knows the noise.

use std::ops::Range;

use multiversion::multiversion;

use super::gaussian_stepper::NARROW_VARIANCE;
use crate::optics::light::{CENTRE, MixedColumn, ScanLine, greater, load, window_start};
use crate::optics::speckle::TILE;
use numerics::lanes::exp;
use transport::kernel::BASIS;

/// What Gaussians that are stepped from row to row have at most of what they should [1].
const STEPPED: f32 = 1.000_2;

/// A bound on the light in a column's pixels that lie outside the rows `drawn`, of a line that is one Gaussian across
/// and what spreads from it [e-]. Light of each width leaves there by `exits` at most, and speckle makes it no
/// brighter than `brightest`, from the surface and from below.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(crate) fn light_beyond(
    own: &ScanLine,
    start: usize,
    drawn: &Range<usize>,
    exits: &[f32; BASIS],
    brightest: [f32; 2],
) -> [f32; TILE] {
    // The line's centre lies up to a row behind the window's middle row.
    let away = (CENTRE + 1 - drawn.start).min(drawn.end - CENTRE - 1) as f32;
    let (variance, rows_per_mm) = (load(&own.variance, start), load(&own.spread_rows_per_mm, start));
    let surface = load(&own.surface_light, start);
    let mut light = [0.0f32; TILE];
    for c in 0..TILE {
        light[c] = brightest[0] * surface[c].abs() * height(away, variance[c]);
    }
    for j in 0..BASIS {
        let (source, shift) = (load(&own.source[j], start), load(&own.shift[j], start));
        if source.iter().all(|&source| source == 0.0) {
            continue;
        }
        let (factor, spread) = (brightest[1] * exits[j], own.spread_mm[j]);
        for c in 0..TILE {
            let sigma = spread * rows_per_mm[c];
            let away = away - shift[c].abs();
            light[c] += factor * source[c].abs() * height(away, variance[c] + sigma * sigma);
        }
    }
    light.map(|light| light * STEPPED)
}

/// Height of a Gaussian of `variance`, `away` or further from its middle [1/px]; of a narrow one, which whole rows may
/// miss, at least as much.
#[inline(always)]
fn height(away: f32, variance: f32) -> f32 {
    let (away, v) = (away.max(0.0), variance.max(NARROW_VARIANCE));
    0.398_942_3 / v.sqrt() * exp(-0.5 * away * away / v)
}

/// Raises bounds of mixed columns, at `centre` in their tile, to those of the neighbours whose light they take row by
/// row.
pub(crate) fn mix_bounds(mixed: &[MixedColumn], first: usize, centre: &[f32; TILE], light: &mut [f32; TILE]) {
    let own = *light;
    for m in mixed {
        let (column, beside) = (m.column - first, m.beside.wrapping_sub(first));
        if centre.get(beside).is_some_and(|other| window_start(*other) == window_start(centre[column])) {
            light[column] = greater(own[column], own[beside]);
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use transport::kernel::SPREAD_MM;

    use super::super::gaussian_stepper::GaussianStepper;
    use super::*;
    use crate::optics::light::{MIN_VARIANCE, ROWS, UNIT_EXIT};

    /// The bound of each column holds over its Gaussians as they are drawn in all rows left out, wherever the line lies
    /// in its row, and is met where all exits are the greatest; a mixed column has that of the brighter of both where
    /// it takes the other's light.
    #[test]
    fn lines_are_below_the_bound() {
        let mut rng = base::Stream::root(3).rng();
        let mut even = |from: f32, to: f32| from + (to - from) * rng.random::<f32>();
        let mut nearest = 0.0f32;
        for _ in 0..200 {
            let mut column = |from: f32, to: f32| (0..TILE).map(|_| even(from, to)).collect::<Vec<f32>>();
            let mut line = ScanLine { spread_mm: SPREAD_MM, ..ScanLine::default() };
            (line.centre, line.variance) = (column(40.0, 60.0), column(MIN_VARIANCE, 9.0));
            (line.spread_rows_per_mm, line.surface_light) = (column(3.0, 20.0), column(0.0, 100.0));
            line.source = std::array::from_fn(|_| column(0.0, 100.0));
            line.shift = std::array::from_fn(|_| column(-1.0, 1.0));
            let exits: [f32; BASIS] = std::array::from_fn(|_| even(0.0, 1.0));
            let brightest = [even(1.0, 9.0), even(1.0, 9.0)];
            let drawn = CENTRE - 2 * even(2.0, 6.0) as usize..CENTRE + 2 * even(2.0, 6.0) as usize;
            let mut light = light_beyond(&line, 0, &drawn, &exits, brightest);
            let phase: [f32; TILE] = std::array::from_fn(|c| line.centre[c].floor() - line.centre[c]);
            let mut window = [[0.0f32; TILE]; ROWS];
            let mut add = |factor: f32, source: &[f32], shift: Option<&[f32]>, spread: f32| {
                let place = std::array::from_fn(|c| phase[c] - shift.map_or(0.0, |shift| shift[c]));
                let wide = std::array::from_fn(|c| line.variance[c] + (spread * line.spread_rows_per_mm[c]).powi(2));
                let light = std::array::from_fn(|c| factor * source[c]);
                GaussianStepper::new(&place, &wide).add(&light, |_| &UNIT_EXIT, &(0..ROWS), &mut window);
            };
            add(brightest[0], &line.surface_light, None, 0.0);
            for j in 0..BASIS {
                add(brightest[1] * exits[j], &line.source[j], Some(&line.shift[j]), SPREAD_MM[j]);
            }
            for k in (0..drawn.start).chain(drawn.end..ROWS) {
                for c in 0..TILE {
                    assert!(window[k][c] <= light[c], "column {c}, row {k}: {} above {}", window[k][c], light[c]);
                    nearest = nearest.max(window[k][c] / light[c]);
                }
            }
            let before = light;
            (line.centre[7], line.centre[8], line.centre[9]) = (50.2, 50.9, 130.0);
            let mixed = [(7, 8), (8, 7), (9, 8), (TILE - 1, TILE)];
            let mixed = mixed.map(|(column, beside)| MixedColumn { column, beside, share: 0.3 });
            mix_bounds(&mixed, 0, load(&line.centre, 0), &mut light);
            let both = before[7].max(before[8]);
            assert_eq!((light[7], light[8], &light[9..]), (both, both, &before[9..]));
        }
        assert!(nearest > 0.9, "the bound is {nearest} from being met");
        assert!(greater(1.0, -f32::NAN).is_nan() && greater(f32::NAN, 9.0).is_nan() && greater(-3.0, 2.0) == 3.0);
    }
}
