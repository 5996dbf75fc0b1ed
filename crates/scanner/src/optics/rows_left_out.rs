//! Rows of a window that are left out: how much light can fall on them.
//!
//! Where a tile shows nothing but a line, the rows about it are drawn alone. Light of width j in a pixel d rows from the line's middle is
//! source_j(column) G_j(d) exit_j(column, row); of the rows left out, d is no less than that of the nearest, and the exit no more than
//! the greatest of the tile there. Speckle multiplies it by a number that is exceeded once in 10^12. Whether a pixel with that much light
//! could be read as a peak is for the digitiser to say, which knows the noise ([`super::digitise`]).

use std::ops::Range;

use multiversion::multiversion;

use super::gaussian_stepper::NARROW_VARIANCE;
use super::mixed_columns::MixedColumn;
use super::row::Row;
use super::speckle::TILE;
use super::window::{CENTRE, load, window_start};
use numerics::lanes::exp;
use transport::kernel::BASIS;

/// Greatest exit of each width in each tile of a row; fills `all`.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(crate) fn find_greatest_exits(row: &Row, all: &mut Vec<[f32; BASIS]>) {
    all.clear();
    all.extend(
        (0..row.centre.len()).step_by(TILE).map(|start| row.exit.each_ref().map(|exit| greatest(load(exit, start)))),
    );
}

/// Greatest magnitude; that of NaN is above all.
#[inline(always)]
fn greatest(values: &[f32; TILE]) -> f32 {
    // As whole numbers, whose order is that of positive floats: extremes of floats are not vector code.
    f32::from_bits(values.iter().fold(0, |most, value| most.max(value.to_bits() & 0x7fff_ffff)))
}

/// A bound on the light in a column's pixels that lie outside the rows `drawn`, of a line that is one Gaussian across and what spreads from it
/// [e-]: light of each width leaves there by `exits` at most, and speckle makes it no brighter than `brightest`, from the surface and from
/// below.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(crate) fn light_beyond(
    own: &Row,
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
    light
}

/// Height of a Gaussian of `variance`, `away` or further from its middle [1/px]; of a narrow one, which whole rows may miss, at least as much.
#[inline(always)]
fn height(away: f32, variance: f32) -> f32 {
    let (away, v) = (away.max(0.0), variance.max(NARROW_VARIANCE));
    0.398_942_3 / v.sqrt() * exp(-0.5 * away * away / v)
}

/// Raises bounds of mixed columns, at `centre` in their tile, to those of the neighbours whose light they take row by row.
pub(crate) fn mix_bounds(mixed: &[MixedColumn], first: usize, centre: &[f32; TILE], light: &mut [f32; TILE]) {
    let own = *light;
    for m in mixed {
        let (column, beside) = (m.column - first, m.beside.wrapping_sub(first));
        if let Some(other) = centre.get(beside).filter(|other| window_start(**other) == window_start(centre[column])) {
            debug_assert!(other.is_finite());
            light[column] = own[column].max(own[beside]);
        }
    }
}
