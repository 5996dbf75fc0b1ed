//! Greatest numbers of a row in each tile of columns, from which follows how bright a line can be far from its middle.

use multiversion::multiversion;

use super::row::{Row, TileExtremes};
use super::speckle::TILE;
use super::window::{MIN_VARIANCE, load};
use transport::kernel::BASIS;

/// Those of each tile of a row; fills `all`.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(crate) fn find(row: &Row, all: &mut Vec<TileExtremes>) {
    all.clear();
    for start in (0..row.centre.len()).step_by(TILE) {
        let widths = |fields: &[Vec<f32>; BASIS]| std::array::from_fn(|j| greatest(load(&fields[j], start)));
        all.push(TileExtremes {
            spread_mm: row.spread_mm,
            variance: greatest(load(&row.variance, start)),
            rows_per_mm: greatest(load(&row.rows_per_mm, start)),
            surface_light: greatest(load(&row.surface_light, start)),
            source: widths(&row.source),
            shift: widths(&row.shift),
            exit: widths(&row.exit),
        });
    }
}

/// Greatest magnitude; that of NaN is above all.
#[inline(always)]
fn greatest(values: &[f32; TILE]) -> f32 {
    // As whole numbers, whose order is that of positive floats: extremes of floats are not vector code.
    f32::from_bits(values.iter().fold(0, |most, value| most.max(value.to_bits() & 0x7fff_ffff)))
}

impl TileExtremes {
    /// A bound on the light in pixels `away` rows or further from the line's centre, where it leaves by no more than the exits of
    /// `others` [e-]: each width's Gaussian falls away from its middle.
    pub(crate) fn light_beyond(&self, away: f32, others: &[f32; BASIS]) -> f32 {
        let spread = |j: usize| {
            let sigma = self.spread_mm[j] * self.rows_per_mm;
            self.source[j] * others[j] * tail(away - self.shift[j], self.variance + sigma * sigma)
        };
        self.surface_light * tail(away, self.variance) + (0..BASIS).map(spread).sum::<f32>()
    }

    /// Raises `most` to the exits of this tile.
    pub(crate) fn raise(&self, most: &mut [f32; BASIS]) {
        for (most, exit) in most.iter_mut().zip(self.exit) {
            *most = most.max(exit);
        }
    }
}

/// Greatest height of Gaussians of a variance up to `widest`, `away` or further from their middle [1/px].
fn tail(away: f32, widest: f32) -> f32 {
    let away = away.max(0.0);
    // Wider Gaussians are higher there, up to a standard deviation of the distance.
    let v = widest.min(away * away).max(MIN_VARIANCE);
    0.398_942_3 / v.sqrt() * libm::expf(-0.5 * away * away / v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use transport::kernel::SPREAD_MM;

    /// The bound holds over the sum of the Gaussians of any column, and is met where all columns are alike.
    #[test]
    fn lines_are_below_the_bound() {
        let mut rng = procedural::Stream::root(3).rng();
        let mut even = |from: f32, to: f32| from + (to - from) * rand::RngExt::random::<f32>(&mut rng);
        let mut nearest = 0.0f32;
        for round in 0..300 {
            let alike = round % 3 == 0;
            let extremes = TileExtremes {
                spread_mm: SPREAD_MM,
                variance: even(0.1, 9.0),
                rows_per_mm: even(3.0, 20.0),
                surface_light: even(0.0, 100.0),
                source: std::array::from_fn(|_| even(0.0, 100.0)),
                shift: std::array::from_fn(|_| even(0.0, 1.0)),
                exit: std::array::from_fn(|_| even(0.0, 1.0)),
            };
            let away = even(3.0, 14.0);
            let bound = extremes.light_beyond(away, &extremes.exit);
            for _ in 0..50 {
                let mut part = |most: f32| if alike { most } else { most * even(0.0, 1.0) };
                let (variance, rows_per_mm) = (part(extremes.variance).max(MIN_VARIANCE), part(extremes.rows_per_mm));
                let at = away + if alike { 0.0 } else { part(5.0) };
                let height = |d: f32, v: f32| 0.398_942_3 / v.sqrt() * libm::expf(-0.5 * d * d / v);
                let mut light = part(extremes.surface_light) * height(at, variance);
                for j in 0..BASIS {
                    let sigma = SPREAD_MM[j] * rows_per_mm;
                    let share = part(extremes.source[j]) * part(extremes.exit[j]);
                    light += share * height(at - part(extremes.shift[j]), variance + sigma * sigma);
                }
                assert!(light <= bound * 1.000_01, "{light} above {bound}, {away} rows away");
                nearest = nearest.max(light / bound);
            }
        }
        assert!(nearest > 0.5, "the bound is {nearest} from being met");
    }
}
