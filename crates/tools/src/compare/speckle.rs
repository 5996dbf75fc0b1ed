//! Speckle contrast and speckle correlation of reflectance, in small patches that are flat, whole and not saturated.
//!
//! Contrast is the standard deviation over the mean (Goodman 2007, chapter 2): 1 for one fully developed pattern, less
//! where a pixel averages several. Texture of the surface adds to it, so it is an upper bound of speckle. Patches with
//! a saturated pixel are left out, which prefers dark ones where much is saturated: compare frames that are saturated
//! alike.
//!
//! The mean of a patch is taken out before correlating; what that takes from the covariance, s^2 / n in white noise, is
//! put back, so that white noise has none.

use super::ScanMaps;
use super::noise::{ScanDirection, SecondDifferences};

/// Side of patches for contrast [px]: small, so that bright and dark parts alike have unsaturated ones.
pub(crate) const CONTRAST_SIDE_PX: usize = 4;
/// Side of patches for correlation [px].
pub(crate) const CORRELATION_SIDE_PX: usize = 8;
/// Lags of the correlation in patches, 0 among them [px].
pub(crate) const SPECKLE_LAGS: usize = 5;
/// A digital number that means saturation [DN].
pub(crate) const SATURATED_DN: f32 = 255.0;

/// Reflectance of every flat, whole, unsaturated patch of `side`, patch after patch `[side, side]` [DN].
pub fn patches(frame: &ScanMaps, seconds: &[SecondDifferences; 2], side: usize) -> Vec<Vec<f32>> {
    let Some(light) = &frame.reflectance else { return Vec::new() };
    let (cols, rows) = (frame.cols, frame.rows);
    let flat = |i: usize| {
        let edge = |second: &SecondDifferences| second.map[i].is_finite() && !second.is_noise(second.map[i]);
        frame.range[i].is_finite() && light[i] > 0.0 && light[i] < SATURATED_DN && !seconds.iter().any(edge)
    };
    let mut found = Vec::new();
    for top in (0..(rows + 1).saturating_sub(side)).step_by(side) {
        for left in (0..(cols + 1).saturating_sub(side)).step_by(side) {
            let places = || (0..side * side).map(|k| (top + k / side) * cols + left + k % side);
            if places().all(flat) {
                found.push(places().map(|i| light[i]).collect());
            }
        }
    }
    found
}

/// Standard deviation over mean of numbers [1].
pub fn contrast(patch: &[f32]) -> f32 {
    let (mean, variance) = moments(patch);
    (variance.sqrt() / mean) as f32
}

/// Mean and unbiased variance.
fn moments(numbers: &[f32]) -> (f64, f64) {
    let n = numbers.len() as f64;
    let mean = numbers.iter().map(|&x| f64::from(x)).sum::<f64>() / n;
    let squares = numbers.iter().map(|&x| (f64::from(x) - mean) * (f64::from(x) - mean)).sum::<f64>();
    (mean, squares / (n - 1.0))
}

/// Sums for correlations in patches.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct SpeckleCorrelation {
    variance: f64,
    covariance: [f64; SPECKLE_LAGS],
}

impl SpeckleCorrelation {
    /// Adds a patch of side [`CORRELATION_SIDE_PX`]; patches of different brightness count alike.
    pub fn add(&mut self, patch: &[f32], direction: ScanDirection) {
        let side = CORRELATION_SIDE_PX;
        let (mean, variance) = moments(patch);
        let of = |i: usize| f64::from(patch[i]) - mean;
        let n = (side * side) as f64;
        for (lag, sum) in self.covariance.iter_mut().enumerate() {
            let pairs = |i: &usize| match direction {
                ScanDirection::Along => i % side + lag < side,
                ScanDirection::Across => i / side + lag < side,
            };
            let products: Vec<f64> =
                (0..side * side).filter(pairs).map(|i| of(i) * of(i + lag * direction.step(side))).collect();
            let taken = if lag == 0 { variance - variance * (n - 1.0) / n } else { variance / n };
            *sum += (products.iter().sum::<f64>() / products.len() as f64 + taken) / (mean * mean);
        }
        self.variance += variance / (mean * mean);
    }

    /// Correlation at a lag [1]; `None` where there was no patch, or none with any contrast.
    pub fn at(&self, lag: usize) -> Option<f64> {
        let covariance = self.covariance.get(lag)?;
        (self.variance > 0.0).then(|| covariance / self.variance)
    }
}

#[cfg(test)]
mod tests {
    use base::Stream;
    use rand::RngExt;

    use super::*;

    /// Fully developed speckle: exponential numbers, `looks` of them averaged, `alike` neighbours along the line added
    /// up.
    fn frame(name: &str, looks: usize, alike: usize) -> ScanMaps {
        let (cols, rows) = (160, 160);
        let mut rng = Stream::root(5).child(name).rng();
        let mut light = Vec::new();
        for _ in 0..rows {
            let mut draw = || (0..looks).map(|_| -libm::log(1.0 - rng.random::<f64>())).sum::<f64>() / looks as f64;
            let line: Vec<f64> = (0..cols + alike).map(|_| draw()).collect();
            light.extend((0..cols).map(|x| 10.0 * (line[x..x + alike].iter().sum::<f64>() / alike as f64) as f32));
        }
        let range = vec![1.0; cols * rows];
        ScanMaps { name: name.into(), cols, rows, range, reflectance: Some(light), ..ScanMaps::default() }
    }

    fn seconds(frame: &ScanMaps) -> [SecondDifferences; 2] {
        ScanDirection::BOTH.map(|direction| SecondDifferences::new(frame, direction))
    }

    /// The mean square contrast of m looks is 1/m.
    #[test]
    fn contrast_falls_with_the_root_of_looks() {
        for looks in [4, 16] {
            let frame = frame("looks", looks, 1);
            let patches = patches(&frame, &seconds(&frame), CORRELATION_SIDE_PX);
            assert_eq!(patches.len(), 400);
            let squares = |patch: &Vec<f32>| f64::from(contrast(patch)).powi(2);
            let found = patches.iter().map(squares).sum::<f64>() / patches.len() as f64 * looks as f64;
            // s^2 / mean^2 of 64 gamma numbers with m looks: bias of order 1/64 of 1/m; standard error of the variance
            // sqrt((2 + 6/m) / 25600) about 1.2 %, alpha 1e-4.
            assert!((found - 1.0).abs() < 3.9 * 0.012 + 2.0 / 64.0, "{looks} looks: {found}");
        }
    }

    /// White speckle has no correlation; a mean of two neighbours has 1/2 at lag 1 along the line, and none across.
    #[test]
    fn grain_has_its_correlation() {
        for (alike, expected) in [(1, 0.0), (2, 0.5)] {
            let frame = frame("grain", 8, alike);
            let mut grain = [SpeckleCorrelation::default(); 2];
            for patch in patches(&frame, &seconds(&frame), CORRELATION_SIDE_PX) {
                ScanDirection::BOTH
                    .into_iter()
                    .zip(&mut grain)
                    .for_each(|(direction, correlation)| correlation.add(&patch, direction));
            }
            let [along, across] = grain.map(|grain| grain.at(1).expect("there are patches"));
            assert!((grain[0].at(0).expect("there are patches") - 1.0).abs() < 1e-9);
            // 22400 pairs, neighbours alike: a standard error of 0.0095; the correction is exact for white noise and
            // leaves (1 - r) r / 16 otherwise; alpha 1e-4.
            let error = 3.9 * 0.0095;
            assert!((along - expected).abs() < error, "along {along}, not {expected}");
            assert!(across.abs() < error, "across {across}");
        }
    }

    /// Patches with a saturated, a missing or a dark pixel, or an edge, are left out.
    #[test]
    fn patches_are_flat_and_whole() {
        let whole = frame("whole", 4, 1);
        let mut rng = Stream::root(5).child("height").rng();
        let rough = whole.range.iter().map(|z| z + 0.01 * base::normal(&mut rng)).collect();
        let whole = ScanMaps { range: rough, ..whole };
        let count = |frame: &ScanMaps| patches(frame, &seconds(frame), CONTRAST_SIDE_PX).len();
        let all = count(&whole);
        // Normal noise passes the limit of edges in 6e-5 of pixels.
        assert!(all > 1580, "{all} of 1600");
        for (light, height) in [(Some(255.0), None), (Some(0.0), None), (None, Some(f64::NAN)), (None, Some(9.0))] {
            let mut frame = whole.clone();
            if let (Some(light), Some(map)) = (light, &mut frame.reflectance) {
                map[0] = light;
            }
            frame.range[0] = height.unwrap_or(frame.range[0]);
            assert_eq!(count(&frame), all - 1, "{light:?} {height:?}");
        }
        assert!(patches(&ScanMaps { reflectance: None, ..whole.clone() }, &seconds(&whole), 4).is_empty());
    }
}
