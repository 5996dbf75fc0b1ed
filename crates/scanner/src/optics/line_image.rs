//! Image of the line on the sensor: the inner loops, one tile of columns at a time.
//!
//! For each fixed width j the line spread along the rows is source_j(column) G_j(row) exit_j(column, row), where the
//! source stands under the laser and the exit in the row of the specimen that this sensor row looks at
//! ([`super::gaussian_stepper`]). docs/performance.md counts operations and bytes.

use multiversion::multiversion;

use super::gaussian_stepper::{CompositeLine, GaussianStepper, UNIT_EXIT, add_line};
use super::laser::LineProfile;
use super::row::{Row, TransmittedLine};
use super::speckle::TILE;
use super::window::{CENTRE, ROWS, Window, load};
use transport::kernel::{BASIS, SPREAD_MM};

/// How the line of a row is drawn.
#[derive(Debug, Clone, Copy)]
pub struct LineShape<'a> {
    /// Sensor row of its middle, a column of the tile [px].
    pub centre: &'a [f32; TILE],
    /// Variance on top of the row's own [px^2].
    pub blur: f32,
    /// What it is across, where that is more than one Gaussian.
    pub profile: Option<&'a LineProfile>,
}

/// Light that the surface throws back, and where the windows lie; darkens the volume.
#[inline(always)]
pub(crate) fn surface_line(
    own: &Row,
    start: usize,
    line: &LineShape<'_>,
    variance: &[f32; TILE],
    window: &mut Window,
) -> [f32; TILE] {
    let phase = place(line.centre, window);
    let source = load(&own.surface_light, start);
    let (exit, rows) = (|_| &UNIT_EXIT, window.drawn.clone());
    match line.profile {
        None => add_line(&phase, variance, source, exit, own.defocus_radius_of(start), &rows, &mut window.surface),
        Some(profile) => {
            let composite = CompositeLine { own, start, profile, mixture: profile.mixture(None) };
            composite.add(&phase, variance, source, exit, &rows, &mut window.surface);
        }
    }
    phase
}

/// Puts a dark window about lines at `centre`; the distance from each line to the window's middle row [px].
#[inline(always)]
fn place(centre: &[f32; TILE], window: &mut Window) -> [f32; TILE] {
    let mut phase = [0.0f32; TILE];
    for c in 0..TILE {
        let whole = centre[c].floor();
        phase[c] = whole - centre[c];
        window.first_row[c] = whole as i32 - CENTRE as i32;
    }
    window.darken();
    phase
}

/// Draws the line of `own` and what `neighbours`, a row of the window each, let out of its light.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn draw(own: &Row, neighbours: &[&Row; ROWS], start: usize, line: &LineShape<'_>, window: &mut Window) {
    let rows_per_mm = load(&own.spread_rows_per_mm, start);
    let mut variance = *load(&own.variance, start);
    for c in 0..TILE {
        variance[c] += line.blur;
    }
    let phase = surface_line(own, start, line, &variance, window);
    let rows = window.drawn.clone();
    for j in 0..BASIS {
        let source = load(&own.source[j], start);
        if source.iter().all(|&s| s == 0.0) {
            continue;
        }
        let shift = load(&own.shift[j], start);
        let (mut wide, mut place) = (variance, phase);
        for c in 0..TILE {
            let sigma = SPREAD_MM[j] * rows_per_mm[c];
            wide[c] += sigma * sigma;
            place[c] -= shift[c];
        }
        let exit = |k: usize| neighbours[k].leaves(j, start, k > CENTRE);
        match line.profile {
            None => add_line(&place, &wide, source, exit, own.defocus_radius_of(start), &rows, &mut window.volume),
            Some(profile) => {
                let composite = CompositeLine { own, start, profile, mixture: profile.mixture(Some(j)) };
                composite.add(&place, &wide, source, exit, &rows, &mut window.volume);
            }
        }
    }
}

/// Draws the line that is seen through a film in a window of its own.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(crate) fn draw_transmitted(transmitted: &TransmittedLine, start: usize, window: &mut Window) {
    let phase = place(load(&transmitted.centre, start), window);
    let (rows_per_mm, variance) = (load(&transmitted.rows_per_mm, start), load(&transmitted.variance, start));
    for j in 0..BASIS {
        let source = load(&transmitted.source[j], start);
        if source.iter().all(|&s| s == 0.0) {
            continue;
        }
        let mut wide = *variance;
        for c in 0..TILE {
            let sigma = SPREAD_MM[j] * rows_per_mm[c];
            wide[c] += sigma * sigma;
        }
        GaussianStepper::new(&phase, &wide).add(source, |_| &UNIT_EXIT, &(0..ROWS), &mut window.volume);
    }
}
