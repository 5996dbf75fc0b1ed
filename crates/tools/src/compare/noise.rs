//! Noise of heights from second differences, without knowing the surface.
//!
//! z[i-1] - 2 z[i] + z[i+1] takes away every plane, and where columns stand at places x that the file tells, so does
//! a z[i-1] - z[i] + c z[i+1] with a and c from the places, which is divided by sqrt(a^2 + 1 + c^2) in place of
//! sqrt(6). Of white noise with deviation s it has the deviation sqrt(6) s. What is left of a curved surface, and of
//! noise that is alike in neighbours, is in it too: noise with the correlations r1 and r2 at one and two pixels counts
//! as s sqrt(1 - (4 r1 - r2) / 3). Differences beyond `EDGE_DEVIATIONS` robust deviations are edges of the object and
//! are counted apart.
//!
//! **Interpolated heights** have no noise of their own: what was resampled onto another grid lies on the line between
//! its neighbours, or repeats one of them, and second differences tell the interpolation. So it is where heights have
//! steps more than twice as coarse as their noise. Both are found by exact means (`is_noise_told`), and no noise is
//! told then.
//!
//! The correlation along one direction is that of second differences across the other: such a difference mixes no
//! neighbours along the first, so the surface goes and the correlation stays.

use super::ScanMaps;
use super::distribution::EmpiricalDistribution;

/// From how many robust deviations a second difference is an edge.
pub(crate) const EDGE_DEVIATIONS: f64 = 4.0;
/// Lags of correlations [px].
pub(crate) const NOISE_LAGS: usize = 9;
/// Share of heights exactly on the line between their neighbours from which on noise is not told [1]. Of noise s in
/// steps q it is q / (6.14 s) nearly, so a third for steps of 2 s.
const MOST_IN_LINE: f64 = 1.0 / 3.0;
/// Longest period of interpolated heights that is looked for [px].
const MOST_PERIOD: usize = 8;
/// How much more heights of one place in a period may lie in line, or repeat their neighbour, than those of another
/// [1].
const MOST_BETWEEN_PHASES: f64 = 0.5;
/// Fewest heights of a place in a period that tell something.
const FEWEST_OF_A_PHASE: u32 = 100;
/// Most second differences of a frame that enter its sample; more are left out evenly.
const MAX_SAMPLED_DIFFERENCES: usize = 200_000;

/// A direction of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScanDirection {
    /// Along the laser line: from column to column.
    Along,
    /// Across profiles: from row to row.
    Across,
}

impl ScanDirection {
    /// Both.
    pub(crate) const BOTH: [Self; 2] = [Self::Along, Self::Across];

    /// Key in documents.
    pub fn key(self) -> &'static str {
        match self {
            Self::Along => "along",
            Self::Across => "across",
        }
    }

    /// In words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Along => "along the line",
            Self::Across => "across profiles",
        }
    }

    /// Lines of a frame in this direction, pixels of each, and index step to the next line.
    pub(super) fn lines(self, frame: &ScanMaps) -> (usize, usize, usize) {
        match self {
            Self::Along => (frame.rows, frame.cols, frame.cols),
            Self::Across => (frame.cols, frame.rows, 1),
        }
    }

    /// Index step to the next pixel.
    pub(super) fn step(self, cols: usize) -> usize {
        match self {
            Self::Along => 1,
            Self::Across => cols,
        }
    }
}

/// Second differences of one frame in one direction.
#[derive(Debug, Clone)]
pub struct SecondDifferences {
    /// One for each pixel `[rows, cols]`, divided by sqrt(6) [um]; NaN where a neighbour is missing.
    pub map: Vec<f32>,
    /// Some of them, no two from the same pixel.
    pub sample: EmpiricalDistribution,
    /// Middle of the sample [um].
    pub middle: f32,
    /// Robust deviation of the sample [um].
    pub deviation: f32,
}

impl SecondDifferences {
    /// Of a frame; NaN deviation where it has no three neighbours.
    pub fn new(frame: &ScanMaps, direction: ScanDirection) -> Self {
        let (cols, rows, step) = (frame.cols, frame.rows, direction.step(frame.cols));
        let inner = |x: usize, y: usize| match direction {
            ScanDirection::Along => x > 0 && x + 1 < cols,
            ScanDirection::Across => y > 0 && y + 1 < rows,
        };
        let scale = 1000.0 / 6.0_f64.sqrt();
        let places = frame.x.as_deref().filter(|_| direction == ScanDirection::Along);
        let mut map = vec![f32::NAN; cols * rows];
        // Every third, so that none shares pixels with the next.
        let mut apart = Vec::new();
        for y in 0..rows {
            for x in 0..cols {
                if !inner(x, y) {
                    continue;
                }
                let i = y * cols + x;
                let heights = [frame.range[i - step], frame.range[i], frame.range[i + step]];
                let second = match places {
                    Some(x) => 1000.0 * uneven_second([x[i - 1], x[i], x[i + 1]], heights),
                    None => scale * (heights[0] - 2.0 * heights[1] + heights[2]),
                } as f32;
                map[i] = second;
                let place = if direction == ScanDirection::Along { x } else { y };
                if place % 3 == 1 && second.is_finite() {
                    apart.push(second);
                }
            }
        }
        let keep = apart.len().div_ceil(MAX_SAMPLED_DIFFERENCES).max(1);
        let sample = EmpiricalDistribution::new(apart.into_iter().step_by(keep).collect());
        let middle = sample.quantile(0.5).map_or(f32::NAN, |q| q as f32);
        let deviation = sample.robust_deviation().map_or(f32::NAN, |q| q as f32);
        Self { map, sample, middle, deviation }
    }

    /// Whether a second difference is noise: there, and no edge.
    pub(crate) fn is_noise(&self, second: f32) -> bool {
        (second - self.middle).abs() <= EDGE_DEVIATIONS as f32 * self.deviation
    }
}

/// Second difference of three heights at places along the line, with the deviation of one of them [mm]; NaN where
/// places are not in order.
fn uneven_second(x: [f64; 3], z: [f64; 3]) -> f64 {
    let (before, after) = (x[1] - x[0], x[2] - x[1]);
    if before * after <= 0.0 {
        return f64::NAN;
    }
    let (a, c) = (after / (before + after), before / (before + after));
    (a * z[0] - z[1] + c * z[2]) / (a * a + 1.0 + c * c).sqrt()
}

/// Whether second differences of a frame tell noise: not where its heights are interpolated or repeated in that
/// direction, or have steps that hide it. True of a frame without three neighbours.
pub(super) fn is_noise_told(frame: &ScanMaps, direction: ScanDirection) -> bool {
    let (cols, step) = (frame.cols, direction.step(frame.cols));
    let place = |i: usize| if direction == ScanDirection::Along { i % cols } else { i / cols };
    let length = if direction == ScanDirection::Along { cols } else { frame.rows };
    // Place, second difference, first difference, and what rounding to single precision may leave of the second [mm or
    // px].
    let differences = || {
        let inner = (0..frame.range.len()).filter(|&i| place(i) > 0 && place(i) + 1 < length);
        inner.filter_map(|i| {
            let [before, here, after] = [i - step, i, i + step].map(|i| frame.range[i]);
            let second = (before - 2.0 * here + after).abs();
            let rounding = 2.0 * f64::from(f32::EPSILON) * before.abs().max(here.abs()).max(after.abs());
            second.is_finite().then(|| (place(i), second, (here - before).abs(), rounding))
        })
    };
    let (all, in_line) = differences().fold((0_u64, 0_u64), |(all, in_line), (_, second, _, rounding)| {
        (all + 1, in_line + u64::from(second <= rounding))
    });
    if in_line as f64 > MOST_IN_LINE * all as f64 {
        return false;
    }
    // Interpolated heights that were rounded to steps leave their line by one step.
    let beyond = differences().filter(|(_, second, _, rounding)| second > rounding);
    let least = beyond.map(|(_, second, ..)| second).fold(f64::INFINITY, f64::min);
    let differ = |counts: &[[u32; 2]]| {
        let known = counts.iter().filter(|[_, all]| *all >= FEWEST_OF_A_PHASE);
        let shares = known.map(|[near, all]| f64::from(*near) / f64::from(*all));
        let [low, high] = shares.fold([1.0, 0.0], |[low, high]: [f64; 2], share| [low.min(share), high.max(share)]);
        high - low > MOST_BETWEEN_PHASES
    };
    !(2..=MOST_PERIOD).any(|period| {
        let (mut lines, mut repeats) = (vec![[0; 2]; period], vec![[0; 2]; period]);
        for (place, second, first, rounding) in differences() {
            for (counts, is_near) in
                [(&mut lines, second <= rounding.max(least * (1.0 + 1e-6))), (&mut repeats, first <= rounding)]
            {
                let [near, all] = &mut counts[place % period];
                (*near, *all) = (*near + u32::from(is_near), *all + 1);
            }
        }
        differ(&lines) || differ(&repeats)
    })
}

/// Sums for correlations at lags 0 to [`NOISE_LAGS`] - 1, over pairs of which both are noise.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct NoiseCorrelation([[f64; 3]; NOISE_LAGS]);

impl NoiseCorrelation {
    /// Adds the pairs along `direction` of second differences across the other direction.
    pub fn add(&mut self, frame: &ScanMaps, second: &SecondDifferences, direction: ScanDirection) {
        let value = |i: usize| second.map[i] - second.middle;
        for (lag, sums) in self.0.iter_mut().enumerate() {
            let (to_x, to_y) = match direction {
                ScanDirection::Along => (frame.cols.saturating_sub(lag), frame.rows),
                ScanDirection::Across => (frame.cols, frame.rows.saturating_sub(lag)),
            };
            for y in 0..to_y {
                for x in 0..to_x {
                    let i = y * frame.cols + x;
                    let j = i + lag * direction.step(frame.cols);
                    if second.is_noise(second.map[i]) && second.is_noise(second.map[j]) {
                        let (a, b) = (f64::from(value(i)), f64::from(value(j)));
                        sums[0] += a * b;
                        sums[1] += a * a;
                        sums[2] += b * b;
                    }
                }
            }
        }
    }

    /// Correlation at each lag [1]; `None` where there are no pairs, or no noise.
    pub fn at(&self, lag: usize) -> Option<f64> {
        let [ab, aa, bb] = *self.0.get(lag)?;
        (aa > 0.0 && bb > 0.0).then(|| ab / (aa * bb).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use base::{Stream, normal};

    use super::*;

    /// A tilted, gently curved surface under noise of one deviation [mm] that is a moving sum along the line.
    fn frame(name: &str, deviation: f64, weight: f64) -> ScanMaps {
        let (cols, rows) = (300, 200);
        let mut rng = Stream::root(11).child(name).rng();
        let mut range = Vec::new();
        for y in 0..rows {
            let mut last = normal(&mut rng);
            for x in 0..cols {
                let next = normal(&mut rng);
                let noise = (next + weight * last) / (1.0 + weight * weight).sqrt();
                last = next;
                range.push(0.02 * x as f64 - 0.05 * y as f64 + 1e-6 * (x * x) as f64 + deviation * noise);
            }
        }
        ScanMaps { name: name.into(), cols, rows, range, ..ScanMaps::default() }
    }

    fn correlation(frame: &ScanMaps, direction: ScanDirection) -> NoiseCorrelation {
        let other = if direction == ScanDirection::Along { ScanDirection::Across } else { ScanDirection::Along };
        let mut correlation = NoiseCorrelation::default();
        correlation.add(frame, &SecondDifferences::new(frame, other), direction);
        correlation
    }

    /// White noise of 15 um on a slope is found in both directions; so is its lack of correlation.
    #[test]
    fn white_noise_is_found() {
        let frame = frame("white", 0.015, 0.0);
        for direction in ScanDirection::BOTH {
            let second = SecondDifferences::new(&frame, direction);
            // The interquartile range of n numbers has a relative standard error of 1.167 / sqrt(n); alpha 1e-4.
            let n = second.sample.numbers().len() as f64;
            let error = 3.9 * 1.167 / n.sqrt();
            assert!((f64::from(second.deviation) / 15.0 - 1.0).abs() < error, "{direction:?}: {}", second.deviation);
            let found = correlation(&frame, direction);
            assert!((found.at(0).expect("there is noise") - 1.0).abs() < 1e-12);
            for lag in 1..NOISE_LAGS {
                // Second differences of one column are alike (-2/3, 1/6): 1 + 2 (4/9 + 1/36) = 35/18 times the variance
                // 1/n of the mean of n products.
                let error = 3.9 * (35.0 / 18.0_f64 / (300.0 * 200.0)).sqrt() * 1.02;
                let r = found.at(lag).expect("there is noise");
                assert!(r.abs() < error, "{direction:?}, lag {lag}: {r} +- {error}");
            }
        }
    }

    /// A moving sum 1, w has the correlation w / (1 + w^2) along the line and none across; its deviation along the line
    /// counts as s sqrt(1 - 4 r1 / 3).
    #[test]
    fn moving_sums_have_their_correlation() {
        let w = 0.5;
        let r1 = w / (1.0 + w * w);
        let frame = frame("moving", 0.01, w);
        let error = 3.9 * (35.0 / 18.0_f64 * 2.0 / (300.0 * 200.0)).sqrt();
        let along = correlation(&frame, ScanDirection::Along);
        let (one, two) = (along.at(1).expect("there is noise"), along.at(2).expect("there is noise"));
        assert!((one - r1).abs() < error && two.abs() < error, "{one} and {two} +- {error}");
        let across = correlation(&frame, ScanDirection::Across).at(1).expect("there is noise");
        assert!(across.abs() < error, "{across} +- {error}");
        let expected = 10.0 * (1.0 - 4.0 * r1 / 3.0).sqrt();
        let found = f64::from(SecondDifferences::new(&frame, ScanDirection::Along).deviation);
        assert!((found / expected - 1.0).abs() < 3.9 * 1.167 * 1.5 / 20_000_f64.sqrt(), "{found}, not {expected}");
    }

    /// Heights of white noise on a slope, put on a grid of other places by a law, in steps [mm]; 0 for none.
    fn resampled(law: impl Fn(f64, &dyn Fn(usize) -> f64) -> f64, ratio: f64, step: f64) -> ScanMaps {
        let whole = frame("resampled", 0.015, 0.0);
        let cols = ((whole.cols - 1) as f64 * ratio) as usize;
        let at = |i: usize| {
            let line = &whole.range[i / cols * whole.cols..][..whole.cols];
            let height = law((i % cols) as f64 / ratio, &|x| line[x]);
            if step > 0.0 { (height / step).round() * step } else { height }
        };
        let range = (0..cols * whole.rows).map(at).collect();
        ScanMaps { cols, range, ..whole }
    }

    /// The whole kind of heights whose noise cannot be told: interpolated or repeated ones at whole ratios and others,
    /// as they are, in single precision, in steps; and steps coarser than the noise. Noise in fine steps, on a grid of
    /// its own, is told, and so is that across the interpolation.
    #[test]
    fn interpolated_heights_tell_no_noise() {
        let linear = |x: f64, z: &dyn Fn(usize) -> f64| {
            let i = x as usize;
            z(i) + (x - i as f64) * (z(i + 1) - z(i))
        };
        let nearest = |x: f64, z: &dyn Fn(usize) -> f64| z((x + 0.499) as usize);
        let single =
            |frame: ScanMaps| ScanMaps { range: frame.range.iter().map(|&z| f64::from(z as f32)).collect(), ..frame };
        let mut untold = Vec::new();
        for step in [0.0, 0.001] {
            for ratio in [2.0, 3.0, 4.0, 5.0, 8.0] {
                untold.push((format!("linear {ratio}, {step}"), resampled(linear, ratio, step)));
                untold.push((format!("nearest {ratio}, {step}"), resampled(nearest, ratio, step)));
            }
        }
        for ratio in [2.0, 3.0] {
            untold.push((format!("single {ratio}"), single(resampled(linear, ratio, 0.0))));
        }
        untold.push(("3.7".into(), resampled(linear, 3.7, 0.0)));
        untold.push(("coarse steps".into(), resampled(linear, 1.0, 0.1)));
        let level = ScanMaps { range: vec![20.0; 6000], cols: 100, rows: 60, ..ScanMaps::default() };
        untold.push(("level".into(), level));
        for (name, frame) in &untold {
            assert!(!is_noise_told(frame, ScanDirection::Along), "{name}");
        }
        assert!(is_noise_told(&untold[0].1, ScanDirection::Across));
        // Steps of a sixteenth, a half and all of the noise.
        for step in [0.0, 0.001, 0.0075, 0.015] {
            let frame = resampled(linear, 1.0, step);
            assert!(ScanDirection::BOTH.iter().all(|way| is_noise_told(&frame, *way)), "{step}");
            assert!(is_noise_told(&single(frame), ScanDirection::Along), "{step}");
        }
        for empty in [ScanMaps::default(), ScanMaps { cols: 1, rows: 1, range: vec![1.0], ..ScanMaps::default() }] {
            assert!(is_noise_told(&empty, ScanDirection::Along) && is_noise_told(&empty, ScanDirection::Across));
        }
    }

    /// On uneven places a plane goes all the same, and white noise has its deviation: by columns the slope would be
    /// noise.
    #[test]
    fn places_along_the_line_are_used() {
        let (cols, rows) = (300, 200);
        let mut rng = Stream::root(11).child("places").rng();
        let x = |i: usize| {
            let column = i % cols;
            0.1 * column as f64 + if column.is_multiple_of(2) { 0.04 } else { 0.0 }
        };
        let places: Vec<f64> = (0..cols * rows).map(x).collect();
        let range = places.iter().map(|x| 0.8 * x + 0.015 * normal(&mut rng)).collect();
        let frame = ScanMaps { cols, rows, range, x: Some(places), ..ScanMaps::default() };
        let found = |frame: &ScanMaps| SecondDifferences::new(frame, ScanDirection::Along).deviation;
        // As above; alpha 1e-4.
        let error = 3.9 * 1.167 / 20_000_f32.sqrt();
        assert!((found(&frame) / 15.0 - 1.0).abs() < error, "{}", found(&frame));
        assert!(found(&ScanMaps { x: None, ..frame.clone() }) > 25.0);
        let turned: Vec<f64> = (0..cols * rows).map(|i| -x(i)).collect();
        assert!((found(&ScanMaps { x: Some(turned), ..frame.clone() }) / found(&frame) - 1.0).abs() < 1e-6);
        let still = ScanMaps { x: Some(vec![1.0; cols * rows]), ..frame };
        assert!(found(&still).is_nan());
    }

    /// Edges of the object and missing pixels do not change what is found.
    #[test]
    fn edges_and_gaps_stay_out() {
        let mut frame = frame("edges", 0.015, 0.0);
        let plain = f64::from(SecondDifferences::new(&frame, ScanDirection::Along).deviation);
        for (i, z) in frame.range.iter_mut().enumerate() {
            match i % 300 {
                100..150 => *z += 5.0,
                200..230 => *z = f64::NAN,
                _ => {}
            }
        }
        let second = SecondDifferences::new(&frame, ScanDirection::Along);
        assert!((f64::from(second.deviation) / plain - 1.0).abs() < 0.05, "{} for {plain}", second.deviation);
        assert!(!second.is_noise(second.map[100]) && !second.is_noise(second.map[200]) && second.map[200].is_nan());
        let r = correlation(&frame, ScanDirection::Along).at(1).expect("there is noise");
        assert!(r.abs() < 0.04, "{r}");
        let empty = ScanMaps { range: vec![f64::NAN; 60_000], ..frame };
        assert!(SecondDifferences::new(&empty, ScanDirection::Along).deviation.is_nan());
        assert_eq!(correlation(&empty, ScanDirection::Along).at(1), None);
    }
}
