//! Anchoring of speckle to the object: which row of which pattern a pixel sees.
//!
//! A point of the object at the scan position y shows the pattern's row y * rows per mm, so the pattern moves with the
//! object's image, 0.673 rows a profile on the default bench. Each tile of columns reads the pattern at another offset,
//! along the motion and along the line, and at a new one each time the pattern repeats: at one offset along the line
//! all tiles would share the spectrum of one pattern, a comb at multiples of 1 / [`TILE`]. The height of a point gives
//! its coordinate in the stack of patterns when it passes the line; in window row k it has moved on by (k - centre)
//! rows, which [`Boiling`] turns into diameters of the pupil. Between two patterns of the stack the points change over
//! one after the other, evenly.

use std::sync::Arc;

use super::boiling::Boiling;
use super::contrast::pixel_contrast;
use super::pupil::TILE;
use super::stack::{PatternCache, PatternStack, STACK_PATTERNS};
use base::mix;
use optical_bench::parameters::Bench;
use optical_bench::settings::SpeckleLaw;

/// Rows over which points change from one pattern of the stack to the next, one after the other [px].
const TRANSITION_ROWS: usize = 64;

/// -ln 10^-12.
const RARE_EXPONENT: f64 = 27.6;
/// By how much fewer equal modes patterns are taken to have than their contrast says [1].
const UNEQUAL_MODES: f64 = 1.5;
/// Steps until a root is found to six digits.
const NEWTON_STEPS: usize = 8;

/// Speckle of one sample.
#[derive(Debug, Clone)]
pub(crate) struct AnchoredSpeckle {
    stack: Arc<PatternStack>,
    /// Factor on the patterns, for light from the surface and from below [1].
    pub scale: [f32; 2],
    /// What the patterns are taken to exceed once in 10^12, over their mean [1].
    rare: [f32; 2],
    /// Resulting contrast in one pixel, of light from the surface and from below [1].
    pub contrast: [f32; 2],
    /// Movement of the pattern with the object [px/mm].
    rows_per_mm: f64,
    /// Height at which stacks start at their first pattern [mm].
    height: f64,
    boiling: Boiling,
    key: u64,
}

/// What determines the speckle of a sample besides its bench.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpeckleConditions {
    /// Grain L = lambda times the working f-number [px].
    pub grain: f64,
    /// Movement of the image with the object [px/mm].
    pub rows_per_mm: f64,
    /// Height of the object [mm].
    pub height: f64,
    /// Contrast that paths of different length below the surface leave [1].
    pub paths: f64,
    /// Travel of the image over the sensor while the shutter is open [px].
    pub travel: f64,
}

impl AnchoredSpeckle {
    /// For a bench; `key` belongs to the sample.
    pub fn new(bench: &Bench, conditions: &SpeckleConditions, law: SpeckleLaw, cache: &PatternCache, key: u64) -> Self {
        let (speckle, grain) = (&bench.speckle, conditions.grain);
        // The number of equal independent patterns with that contrast is 1 / C^2.
        let below = speckle.volume_patterns / (conditions.paths * conditions.paths);
        let patterns = [speckle.surface_patterns, below];
        let stack =
            if speckle.strength > 0.0 { cache.get(grain, law, patterns) } else { Arc::new(PatternStack::even(law)) };
        let own = pixel_contrast(stack.grain(), law, 0.0);
        let developed = pixel_contrast(grain, law, conditions.travel) * speckle.strength;
        let contrast = patterns.map(|n| developed / n.sqrt());
        let scale = [0, 1].map(|i| (contrast[i] / own * (stack.looks()[i] as f64).sqrt()) as f32);
        let rare = stack.looks().map(|looks| rare_excess(own / (looks as f64).sqrt(), RARE_EXPONENT) as f32);
        Self {
            stack,
            scale,
            rare,
            contrast: contrast.map(|c| c as f32),
            rows_per_mm: conditions.rows_per_mm,
            height: conditions.height,
            boiling: Boiling::new(bench),
            key,
        }
    }

    /// Factor on light from the surface and from below that speckle is taken to exceed once in 10^12, where that from
    /// below keeps `most` times the contrast of the patterns [1].
    pub fn brightest(&self, most: f32) -> [f32; 2] {
        let [surface, volume] = [0, 1].map(|i| self.scale[i] * self.rare[i]);
        [1.0 + surface, 1.0 + most * volume]
    }

    /// Speckle of tile `tile` around the point `point` (x, z) [mm] of the laser plane when the object has moved by
    /// `scan_position` [mm]; `rows_aside` reads the pattern at another row [px].
    pub fn tile(&self, tile: usize, point: [f64; 2], scan_position: f64, rows_aside: usize) -> TileSpeckle<'_> {
        let pupil = STACK_PATTERNS as f64 / 2.0;
        let (fine, period) = (self.stack.fine(), self.stack.rows());
        let base = (scan_position * self.rows_per_mm * fine as f64).round() as i64 + (rows_aside * fine) as i64;
        let (repeat, key) = (base.div_euclid(period as i64), mix(self.key ^ mix(tile as u64)));
        let offset = |repeat: i64| {
            let drawn = mix(key ^ repeat as u64);
            [(drawn % period as u64) as usize, (drawn >> (u64::BITS - TILE.ilog2())) as usize]
        };
        let start = (pupil * self.boiling.rise(point[1] - self.height)).rem_euclid(STACK_PATTERNS as f64);
        TileSpeckle {
            stack: &self.stack,
            row: base.rem_euclid(period as i64) as usize,
            offsets: [-1, 0, 1].map(|next| offset(repeat + next)),
            // Whole periods of the stack keep it above 0.
            start: (start + (64 * STACK_PATTERNS) as f64) as f32,
            patterns_per_row: (pupil * self.boiling.diameters(point, [0.0, 1.0 / self.rows_per_mm])) as f32,
            per_fine: 1.0 / (TRANSITION_ROWS * fine) as f32,
        }
    }
}

/// What speckle of this contrast exceeds with a chance of exp(-`exponent`) at most, over its mean of 1 [1].
///
/// The mean of an intensity over pixels and looks is nearly a gamma variate of shape k = 1 / C^2 (Goodman 2007, 4.4),
/// which exceeds x with a chance of no more than exp(-k (x - 1 - ln x)) (Chernoff). Its tail falls like that of its
/// brightest mode, which is brighter than the modes of a gamma variate: k is taken to be less by [`UNEQUAL_MODES`], an
/// assumption that is tested to chances of 10^-4, and by the greatest of 30 million pixels.
fn rare_excess(contrast: f64, exponent: f64) -> f64 {
    let exponent = exponent * UNEQUAL_MODES * contrast * contrast;
    // Newton's steps from above: the function is convex.
    let mut x = 1.0 + 2.0 * (exponent + exponent.sqrt());
    for _ in 0..NEWTON_STEPS {
        x -= (x - 1.0 - libm::log(x) - exponent) / (1.0 - 1.0 / x).max(1e-9);
    }
    x - 1.0
}

/// The speckle of one tile in one exposure.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TileSpeckle<'a> {
    stack: &'a PatternStack,
    /// Fine row of the pattern on the line.
    row: usize,
    /// Offset into the pattern in the repeat before, in this one and in the next [fine rows, columns].
    offsets: [[usize; 2]; 3],
    /// Stack coordinate on the line, and its growth from row to row [1, 1/px].
    start: f32,
    /// Its growth from row to row [1/px].
    patterns_per_row: f32,
    /// Share of a step of the stack from one fine row to the next [1].
    per_fine: f32,
}

impl TileSpeckle<'_> {
    /// The pattern less its mean of 1, `rows` of the window behind the line, at most one period of it: for light from
    /// the surface and from below.
    #[inline(always)]
    pub fn row(&self, rows: i64) -> [&[f32; TILE]; 2] {
        let (fine, period) = (self.stack.fine(), self.stack.rows());
        // One period ahead, so that it is above 0.
        let row = (self.row + period).wrapping_add_signed(-(rows as isize) * fine as isize);
        let (repeat, row) = if row < period {
            (0, row)
        } else if row < 2 * period {
            (1, row - period)
        } else {
            (2, row - 2 * period)
        };
        let ramp = if row < TRANSITION_ROWS * fine { row } else { row - TRANSITION_ROWS * fine };
        let pattern = (self.start + self.patterns_per_row * rows as f32 + ramp as f32 * self.per_fine) as usize;
        let [down, right] = self.offsets[repeat];
        let fine_row = row + down;
        self.stack.at(pattern % STACK_PATTERNS, if fine_row < period { fine_row } else { fine_row - period }, right)
    }
}

#[cfg(test)]
mod tests {
    use base::Stream;

    use super::*;

    /// Patterns of all kinds exceed the bound for a chance no more often than that, and none the bound for 1 in 10^12.
    #[test]
    #[ignore = "long"]
    fn patterns_stay_below_their_bounds() {
        let (mut nearest, mut pixels) = (0.0f64, 0usize);
        for (number, grain) in [0.12, 0.2, 0.33, 0.6, 1.0, 2.3, 5.0].into_iter().enumerate() {
            for law in [SpeckleLaw::Exponential, SpeckleLaw::Rayleigh] {
                for looks in [[1, 1], [2, 4]] {
                    let stack = PatternStack::new(grain, law, looks, Stream::root(number as u64));
                    let own = pixel_contrast(stack.grain(), law, 0.0);
                    for which in [0, 1] {
                        let contrast = own / (looks[which] as f64).sqrt();
                        let chances = [1e-3, 1e-4];
                        let bounds = chances.map(|chance: f64| rare_excess(contrast, -libm::log(chance)));
                        let (mut above, mut most, mut count) = ([0usize; 2], 0.0f64, 0usize);
                        for pattern in 0..8 {
                            for row in 0..stack.rows() as i64 {
                                for value in stack.row(4 * pattern, row)[which].map(f64::from) {
                                    most = most.max(value);
                                    (0..2).for_each(|i| above[i] += usize::from(value > bounds[i]));
                                }
                            }
                            count += stack.rows() * TILE;
                        }
                        let said = format!("{law:?}, grain {grain} px, {} looks", looks[which]);
                        for (above, chance) in above.into_iter().zip(chances) {
                            let share = above as f64 / count as f64;
                            assert!(share <= chance, "{said}: {share} of {count} above the bound for {chance}");
                        }
                        let bound = rare_excess(contrast, RARE_EXPONENT);
                        assert!(most < bound, "{said}: {most} of {count} above {bound}");
                        nearest = nearest.max(most / bound);
                        pixels += count;
                    }
                }
            }
        }
        println!("greatest of {pixels} pixels {nearest:.2} of its bound");
        assert!(nearest > 0.3, "bounds are far: {nearest}");
    }
}
