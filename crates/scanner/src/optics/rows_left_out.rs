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

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use transport::kernel::SPREAD_MM;

    use super::super::window::{MIN_VARIANCE, ROWS};
    use super::*;

    /// The bound of each column holds over the sum of its Gaussians in all rows left out, wherever the line lies in its row, and is met where all exits
    /// are the greatest; a mixed column has that of the brighter of both where it takes the other's light.
    #[test]
    fn lines_are_below_the_bound() {
        let mut rng = procedural::Stream::root(3).rng();
        let mut even = |from: f32, to: f32| from + (to - from) * rng.random::<f32>();
        let mut nearest = 0.0f32;
        for _ in 0..200 {
            let mut column = |from: f32, to: f32| (0..TILE).map(|_| even(from, to)).collect::<Vec<f32>>();
            let mut row = Row { spread_mm: SPREAD_MM, ..Row::default() };
            (row.centre, row.variance) = (column(40.0, 60.0), column(MIN_VARIANCE, 9.0));
            (row.spread_rows_per_mm, row.surface_light) = (column(3.0, 20.0), column(0.0, 100.0));
            row.source = std::array::from_fn(|_| column(0.0, 100.0));
            row.shift = std::array::from_fn(|_| column(-1.0, 1.0));
            let exits: [f32; BASIS] = std::array::from_fn(|_| even(0.0, 1.0));
            let brightest = [even(1.0, 9.0), even(1.0, 9.0)];
            let drawn = CENTRE - 2 * even(2.0, 6.0) as usize..CENTRE + 2 * even(2.0, 6.0) as usize;
            let mut light = light_beyond(&row, 0, &drawn, &exits, brightest);
            for c in 0..TILE {
                for k in (0..drawn.start).chain(drawn.end..ROWS) {
                    let off = (window_start(row.centre[c]) + k as i32) as f32 - row.centre[c];
                    let height = |d: f32, v: f32| 0.398_942_3 / v.sqrt() * libm::expf(-0.5 * d * d / v);
                    let mut sum = brightest[0] * row.surface_light[c] * height(off, row.variance[c]);
                    for j in 0..BASIS {
                        let sigma = SPREAD_MM[j] * row.spread_rows_per_mm[c];
                        let of = height(off - row.shift[j][c], row.variance[c] + sigma * sigma);
                        sum += brightest[1] * row.source[j][c] * exits[j] * of;
                    }
                    assert!(sum <= light[c] * 1.000_01, "column {c}, row {k}: {sum} above {}", light[c]);
                    nearest = nearest.max(sum / light[c]);
                }
            }
            let before = light;
            (row.centre[7], row.centre[8], row.centre[9]) = (50.2, 50.9, 130.0);
            let mixed = [(7, 8), (8, 7), (9, 8), (TILE - 1, TILE)];
            let mixed = mixed.map(|(column, beside)| MixedColumn { column, beside, share: 0.3 });
            mix_bounds(&mixed, 0, load(&row.centre, 0), &mut light);
            let both = before[7].max(before[8]);
            assert_eq!((light[7], light[8], &light[9..]), (both, both, &before[9..]));
        }
        assert!(nearest > 0.9, "the bound is {nearest} from being met");
    }
}
