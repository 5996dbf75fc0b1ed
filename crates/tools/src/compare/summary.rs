//! Summary statistics of a scan: one vector of numbers, the same for a real scan and a simulated one, in scales in
//! which their scatter from scan to scan is nearly normal. What fitting a recipe compares.
//!
//! | law | number x is kept as | why |
//! |---|---|---|
//! | positive | ln x | deviations and widths scatter by a factor |
//! | share | ln((x + e) / (1 - x + e)), e half a pixel | shares near 0 and 1 scatter less than those between |
//! | correlation | artanh x (Fisher 1915) | so do correlations near 1 |
//! | plain | x | |
//!
//! Noise is measured with second differences as in `noise`, here as the standard deviation of those within
//! `EDGE_DEVIATIONS` (4) robust deviations: steps of digital numbers then don't show. Noise of Reflectance and Scatter
//! is measured apart where Reflectance is below and above its median, since light noise rises with light and dark noise
//! does not. What all pixels of a profile (or column) have in common is the deviation of the means of such differences
//! over that of single pixels, with the factor by which independent pixels would lower it.

use super::distribution::QUARTILES;
use super::noise::{EDGE_DEVIATIONS, NoiseCorrelation, ScanDirection, SecondDifferences};
use super::power_spectrum::PowerSpectrum;
use super::speckle::{CONTRAST_SIDE_PX, CORRELATION_SIDE_PX, SATURATED_DN, SpeckleCorrelation, contrast, patches};
use super::{ScanMaps, SensorFrame, line_width};

/// Percentiles that stand for a histogram [%].
const PERCENTS: [u8; 5] = [5, 25, 50, 75, 95];
/// Lags of the correlations that are taken [px].
const LAGS: [usize; 3] = [1, 2, 3];
/// Fewest numbers from which a statistic is taken.
const FEWEST: usize = 24;
/// Smallest number of a positive statistic, under every step of an instrument.
const LEAST: f64 = 1e-6;

/// The scale in which a statistic is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SummaryLaw {
    /// A positive number: its logarithm.
    Positive,
    /// A share of this many things: its logit.
    Share,
    /// A correlation: its inverse hyperbolic tangent.
    Correlation,
    /// The number itself.
    Plain,
}

/// One statistic of a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct SummaryStatistic {
    /// What it is, as a key: `range_noise_along`.
    pub key: String,
    /// What it is, in words.
    pub name: String,
    /// Unit, `1` for none.
    pub unit: &'static str,
    /// How [`Self::scaled`] follows from the number.
    pub law: SummaryLaw,
    /// The number in the scale of its law; `None` where the scan does not tell it.
    pub scaled: Option<f64>,
}

/// Half of a pixel's share of a scan, which keeps logits finite; the same for all scans, so that sizes don't matter.
const HALF_PIXEL: f64 = 1e-5;

impl SummaryLaw {
    fn scaled(self, number: f64) -> f64 {
        match self {
            Self::Positive => libm::log(number.max(LEAST)),
            Self::Share => libm::log((number + HALF_PIXEL) / (1.0 - number + HALF_PIXEL)),
            Self::Correlation => libm::atanh(number.clamp(-0.999, 0.999)),
            Self::Plain => number,
        }
    }

    /// The number of which this is the scaled one.
    pub fn number(self, scaled: f64) -> f64 {
        match self {
            Self::Positive => libm::exp(scaled),
            Self::Share => {
                let odds = libm::exp(scaled);
                ((odds * (1.0 + HALF_PIXEL) - HALF_PIXEL) / (1.0 + odds)).clamp(0.0, 1.0)
            }
            Self::Correlation => libm::tanh(scaled),
            Self::Plain => scaled,
        }
    }
}

impl SummaryStatistic {
    /// The number in its unit; `None` where the scan does not tell it.
    pub fn number(&self) -> Option<f64> {
        self.scaled.map(|scaled| self.law.number(scaled))
    }
}

/// The statistics of a scan, always the same ones in the same order. Pixels that `ignored` (`[rows, cols]`) marks are
/// left out, as if the scan had ended there; they count neither as measured nor as missing.
pub fn summary(maps: &ScanMaps, ignored: Option<&[bool]>) -> Vec<SummaryStatistic> {
    let mut list = SummaryList { list: Vec::with_capacity(96), unit: maps.unit.thousandth() };
    let whole;
    let (maps, counted) = match ignored {
        Some(ignored) => {
            whole = maps.without(ignored);
            (&whole, ignored.iter().filter(|ignored| !**ignored).count())
        }
        None => (maps, maps.range.len()),
    };
    list.shares(maps, ignored, counted);
    let seconds = ScanDirection::BOTH.map(|direction| SecondDifferences::new(maps, direction));
    list.range(maps, &seconds);
    list.light(maps, &seconds);
    list.scatter(maps);
    list.line(maps);
    list.list
}

/// Statistics so far.
struct SummaryList {
    list: Vec<SummaryStatistic>,
    /// Thousandth of Range's unit.
    unit: &'static str,
}

impl SummaryList {
    fn push(&mut self, key: String, name: String, unit: &'static str, law: SummaryLaw, number: Option<f64>) {
        let scaled = number.filter(|number| number.is_finite()).map(|number| law.scaled(number));
        self.list.push(SummaryStatistic { key, name, unit, law, scaled });
    }

    fn positive(&mut self, key: impl Into<String>, name: impl Into<String>, unit: &'static str, number: Option<f64>) {
        self.push(key.into(), name.into(), unit, SummaryLaw::Positive, number);
    }

    fn share(&mut self, key: impl Into<String>, name: impl Into<String>, number: Option<f64>) {
        self.push(key.into(), name.into(), "1", SummaryLaw::Share, number);
    }

    fn correlation(&mut self, key: String, name: String, number: Option<f64>) {
        self.push(key, name, "1", SummaryLaw::Correlation, number);
    }

    /// These percentiles of numbers, none below `least`.
    fn percentiles(&mut self, of: (&str, &str, &'static str), percents: &[u8], numbers: &mut [f32], least: f64) {
        let (key, name, unit) = of;
        for percent in percents {
            let found = quantile(numbers, f64::from(*percent) / 100.0).map(|number| number.max(least));
            self.positive(format!("{key}_p{percent:02}"), format!("{name}, percentile {percent}"), unit, found);
        }
    }

    /// What is missing, and how it lies.
    fn shares(&mut self, maps: &ScanMaps, ignored: Option<&[bool]>, counted: usize) {
        let is_ignored = |i: usize| ignored.is_some_and(|ignored| ignored[i]);
        let is_missing = |i: usize| maps.range[i].is_nan() && !is_ignored(i);
        let missing = (0..maps.range.len()).filter(|&i| is_missing(i)).count();
        let share = (counted > 0).then(|| missing as f64 / counted as f64);
        self.share("missing_share", "missing heights", share);
        for direction in ScanDirection::BOTH {
            let (lines, length, start) = direction.lines(maps);
            let is_missing = |line: usize, place: usize| is_missing(line * start + place * direction.step(maps.cols));
            let begins =
                |line: usize, place: usize| is_missing(line, place) && (place == 0 || !is_missing(line, place - 1));
            let runs: usize = (0..lines).map(|line| (0..length).filter(|&place| begins(line, place)).count()).sum();
            let (key, way) = (direction.key(), direction.describe());
            let mean = (runs > 0).then(|| missing as f64 / runs as f64);
            self.positive(format!("missing_run_{key}"), format!("mean run of missing heights {way}"), "px", mean);
        }
    }

    /// Heights: spread, noise, its correlation, spectrum.
    fn range(&mut self, maps: &ScanMaps, seconds: &[SecondDifferences; 2]) {
        let mut heights: Vec<f32> = maps.range.iter().filter(|z| z.is_finite()).map(|&z| z as f32).collect();
        let [low, high] = [0.05, 0.95].map(|share| quantile(&mut heights, share));
        let spread = low.zip(high).map(|(low, high)| high - low);
        self.positive("height_spread", "heights, 5 to 95 %", maps.unit.name(), spread);
        for (direction, second) in ScanDirection::BOTH.into_iter().zip(seconds) {
            let (key, way) = (direction.key(), direction.describe());
            let noise: Vec<f32> = second.map.iter().copied().filter(|d| d.is_finite()).collect();
            let total = noise.len();
            let found = trimmed_deviation(noise);
            let deviation = found.map(|found| found.deviation);
            self.positive(format!("range_noise_{key}"), format!("range noise {way}"), self.unit, deviation);
            let edges = found.map(|found| found.beyond as f64 / total as f64);
            self.share(format!("edge_share_{key}"), format!("edges {way}"), edges);
        }
        for (i, direction) in ScanDirection::BOTH.into_iter().enumerate() {
            let (key, way) = (direction.key(), direction.describe());
            let mut correlation = NoiseCorrelation::default();
            correlation.add(maps, &seconds[1 - i], direction);
            for lag in LAGS {
                let name = format!("correlation of range noise {way}, lag {lag}");
                self.correlation(format!("range_correlation_{key}_{lag}"), name, correlation.at(lag));
            }
        }
        for (direction, second) in ScanDirection::BOTH.into_iter().zip(seconds) {
            let (key, way) = (direction.key(), direction.describe());
            let mut spectrum = PowerSpectrum::default();
            spectrum.add(maps, direction, second);
            let points = spectrum.points();
            for (from, to, word) in [(0, 2, "low"), (2, 7, "middle")] {
                let power = points
                    .get(from..to)
                    .map(|points| (points.iter().map(|point| point.power).sum::<f64>() / points.len() as f64).sqrt());
                let name = format!("root of the heights' power {way}, {word} frequencies");
                self.positive(format!("range_spectrum_{word}_{key}"), name, self.unit, power);
            }
        }
        let heights: Vec<f32> = maps.range.iter().map(|&z| (1000.0 * z) as f32).collect();
        self.common(&heights, maps, "Range");
    }

    /// Reflectance: saturation, histogram, noise, speckle.
    fn light(&mut self, maps: &ScanMaps, seconds: &[SecondDifferences; 2]) {
        let light = at_heights(maps.reflectance.as_deref(), maps);
        let measured = light.iter().filter(|dn| dn.is_finite()).count();
        let full = light.iter().filter(|dn| **dn >= SATURATED_DN).count();
        let saturated = (measured > 0).then(|| full as f64 / measured as f64);
        self.share("saturated_share", "saturated reflectance", saturated);
        let mut part: Vec<f32> = light.iter().copied().filter(|dn| *dn < SATURATED_DN).collect();
        self.positive("reflectance_floor", "least reflectance (0.2 %)", "DN", quantile(&mut part, 0.002));
        self.percentiles(("reflectance", "unsaturated reflectance", "DN"), &PERCENTS, &mut part, LEAST);
        let middle = quantile(&mut part, 0.5);
        let open: Vec<f32> = light.iter().map(|&dn| if dn >= SATURATED_DN { f32::NAN } else { dn }).collect();
        self.noise_by_light(&open, &open, middle, maps, "reflectance");
        self.common(&open, maps, "Reflectance");
        let mut contrasts: Vec<f32> =
            patches(maps, seconds, CONTRAST_SIDE_PX).iter().map(|patch| contrast(patch)).collect();
        let level = contrasts.len() * CONTRAST_SIDE_PX * CONTRAST_SIDE_PX;
        let share = (measured > 0).then(|| level as f64 / measured as f64);
        self.share("patch_share", "level patches without saturation", share);
        if contrasts.len() < FEWEST {
            contrasts.clear();
        }
        self.percentiles(("contrast", "speckle contrast", "1"), &[10, 50, 90], &mut contrasts, LEAST);
        let mut grain = [SpeckleCorrelation::default(); 2];
        let large = patches(maps, seconds, CORRELATION_SIDE_PX);
        for patch in &large {
            ScanDirection::BOTH.into_iter().zip(&mut grain).for_each(|(direction, sums)| sums.add(patch, direction));
        }
        for (direction, sums) in ScanDirection::BOTH.into_iter().zip(&grain) {
            let (key, way) = (direction.key(), direction.describe());
            for lag in &LAGS[..2] {
                let found = sums.at(*lag).filter(|_| large.len() >= FEWEST);
                let name = format!("correlation of reflectance {way}, lag {lag}");
                self.correlation(format!("grain_{key}_{lag}"), name, found);
            }
        }
    }

    /// Scatter: histogram, noise, and how it goes with Reflectance.
    fn scatter(&mut self, maps: &ScanMaps) {
        let scatter = at_heights(maps.scatter.as_deref(), maps);
        let mut part: Vec<f32> = scatter.iter().copied().filter(|dn| dn.is_finite()).collect();
        self.percentiles(("scatter", "scatter", "DN"), &PERCENTS, &mut part, 0.5);
        let light = maps.reflectance.as_deref().unwrap_or_default();
        let is_open = |(dn, s): &(&f32, &f32)| **dn < SATURATED_DN && s.is_finite();
        let mut open: Vec<f32> = light.iter().zip(&scatter).filter(is_open).map(|(dn, _)| *dn).collect();
        let middle = quantile(&mut open, 0.5);
        self.noise_by_light(&scatter, light, middle, maps, "scatter");
        self.common(&scatter, maps, "Scatter");
        let line = law_of_light(light, &scatter);
        let [level, slope, rest] = [0, 1, 2].map(|i| line.map(|line| line[i]));
        self.positive("scatter_at_light", "scatter over reflectance at its mean", "1", level);
        let name = "slope of ln scatter over ln reflectance";
        self.push("scatter_slope".into(), name.into(), "1", SummaryLaw::Plain, slope);
        self.positive("scatter_rest", "spread of ln scatter about that line", "1", rest);
    }

    /// The laser line on the sensor, where frames were kept.
    fn line(&mut self, maps: &ScanMaps) {
        let (mut widths, mut sigmas) = (Vec::new(), Vec::new());
        let (mut darks, mut dark_noise) = (Vec::new(), Vec::new());
        for mut column in maps.exposures.iter().flat_map(SensorFrame::columns) {
            if let Some(width) = line_width::full_width(&column) {
                widths.push(width);
                sigmas.extend(line_width::line_deviation(&column, width));
            }
            column.sort_unstable();
            // Half of the rows lie beside the line.
            let at = |share: f64| column.get((share * column.len() as f64) as usize).map(|&dn| f64::from(dn));
            if let (Some(low), Some(middle)) = (at(0.1), at(0.4)) {
                darks.push(middle as f32);
                dark_noise.push((middle - low) as f32);
            }
        }
        let mean = |numbers: &[f32]| {
            (!numbers.is_empty()).then(|| numbers.iter().map(|&x| f64::from(x)).sum::<f64>() / numbers.len() as f64)
        };
        self.positive("line_width", "laser line's full width at half maximum", "px", quantile(&mut widths, 0.5));
        self.positive("line_sigma", "laser line's standard deviation", "px", quantile(&mut sigmas, 0.5));
        self.positive("frame_dark", "dark level of frames", "DN", mean(&darks));
        let spread = mean(&dark_noise).map(|dn| dn.max(0.02));
        self.positive("frame_dark_spread", "dark level of frames, 10 to 40 %", "DN", spread);
    }

    /// Noise of a map where `light` is below and above `middle`, in both directions.
    fn noise_by_light(&mut self, map: &[f32], light: &[f32], middle: Option<f64>, maps: &ScanMaps, name: &str) {
        for direction in ScanDirection::BOTH {
            let (key, way) = (direction.key(), direction.describe());
            let mut halves: [Vec<f32>; 2] = Default::default();
            if let Some(middle) = middle {
                second_differences(map, maps, direction, |i, second| {
                    halves[usize::from(f64::from(light[i]) > middle)].push(second);
                });
            }
            for (half, word) in halves.into_iter().zip(["dim", "bright"]) {
                let found = trimmed_deviation(half).map(|found| found.deviation.max(0.02));
                let words = format!("noise of {name} {way}, {word} half");
                self.positive(format!("{name}_noise_{key}_{word}"), words, "DN", found);
            }
        }
    }

    /// What pixels of a line have in common: of profiles by differences across them, of columns by those along the
    /// line.
    fn common(&mut self, map: &[f32], maps: &ScanMaps, name: &str) {
        for (direction, word, words) in
            [(ScanDirection::Across, "profiles", "a profile"), (ScanDirection::Along, "columns", "a column")]
        {
            let is_across = direction == ScanDirection::Across;
            let lines = if is_across { maps.rows } else { maps.cols };
            let mut all = Vec::new();
            second_differences(map, maps, direction, |i, second| {
                all.push((if is_across { i / maps.cols } else { i % maps.cols }, second));
            });
            let ratio = trimmed_deviation(all.iter().map(|(_, second)| *second).collect()).and_then(|found| {
                let mut sums = vec![(0.0, 0_usize); lines];
                for &(line, second) in &all {
                    if f64::from((second - found.middle).abs()) <= EDGE_DEVIATIONS * found.robust {
                        sums[line].0 += f64::from(second - found.middle);
                        sums[line].1 += 1;
                    }
                }
                let means: Vec<f64> = sums
                    .iter()
                    .filter(|(_, n)| *n >= FEWEST)
                    .map(|(sum, n)| sum / (*n as f64).sqrt() / found.deviation.max(1e-3))
                    .collect();
                (means.len() >= FEWEST)
                    .then(|| (means.iter().map(|mean| mean * mean).sum::<f64>() / means.len() as f64).sqrt())
            });
            let key = format!("{}_common_{word}", name.to_lowercase());
            let words = format!("noise of {name} that {words} has in common, over that of independent pixels");
            self.positive(key, words, "1", ratio);
        }
    }
}

/// A map where there are heights, NaN elsewhere; empty where the scan has no such map.
fn at_heights(map: Option<&[f32]>, maps: &ScanMaps) -> Vec<f32> {
    let known = |(&dn, z): (&f32, &f64)| if z.is_nan() { f32::NAN } else { dn };
    map.map_or(Vec::new(), |map| map.iter().zip(&maps.range).map(known).collect())
}

/// Deviation of numbers without those far away.
#[derive(Debug, Clone, Copy)]
struct TrimmedDeviation {
    middle: f32,
    /// From the quartiles.
    robust: f64,
    /// Standard deviation about the middle of those within the limit.
    deviation: f64,
    /// How many lie beyond.
    beyond: usize,
}

/// `None` of few numbers.
fn trimmed_deviation(mut numbers: Vec<f32>) -> Option<TrimmedDeviation> {
    if numbers.len() < FEWEST {
        return None;
    }
    let [low, middle, high] = [0.25, 0.5, 0.75].map(|share| quantile(&mut numbers, share).unwrap_or(0.0));
    // Steps of a digital number may leave nothing between the quartiles.
    let robust = ((high - low) / QUARTILES).max(0.25);
    let mut sum = (0.0, 0_usize);
    for &x in &numbers {
        let apart = f64::from(x) - middle;
        if apart.abs() <= EDGE_DEVIATIONS * robust {
            sum = (sum.0 + apart * apart, sum.1 + 1);
        }
    }
    let deviation = (sum.0 / sum.1.max(1) as f64).sqrt();
    Some(TrimmedDeviation { middle: middle as f32, robust, deviation, beyond: numbers.len() - sum.1 })
}

/// Calls `found` with place and second difference over sqrt(6) of each pixel whose neighbours in `direction` are there.
fn second_differences(map: &[f32], maps: &ScanMaps, direction: ScanDirection, mut found: impl FnMut(usize, f32)) {
    let (cols, rows, step) = (maps.cols, maps.rows, direction.step(maps.cols));
    let (xs, ys) = match direction {
        ScanDirection::Along => (1..cols.saturating_sub(1), 0..rows),
        ScanDirection::Across => (0..cols, 1..rows.saturating_sub(1)),
    };
    if map.is_empty() {
        return;
    }
    let norm = 1.0 / 6.0_f32.sqrt();
    for y in ys {
        for x in xs.clone() {
            let i = y * cols + x;
            let second = (map[i - step] - 2.0 * map[i] + map[i + step]) * norm;
            if second.is_finite() {
                found(i, second);
            }
        }
    }
}

/// ln of mean scatter over mean light, slope of ln scatter over ln light, and deviation about that line.
fn law_of_light(light: &[f32], scatter: &[f32]) -> Option<[f64; 3]> {
    let pairs: Vec<[f64; 2]> = light
        .iter()
        .zip(scatter)
        .filter(|(dn, s)| **dn > 0.0 && **dn < SATURATED_DN && **s > 0.0)
        .map(|(&dn, &s)| [libm::log(f64::from(dn)), libm::log(f64::from(s))])
        .collect();
    if pairs.len() < FEWEST {
        return None;
    }
    let n = pairs.len() as f64;
    let [x, y] = [0, 1].map(|k| pairs.iter().map(|pair| pair[k]).sum::<f64>() / n);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for pair in &pairs {
        let (a, b) = (pair[0] - x, pair[1] - y);
        (xx, xy, yy) = (xx + a * a, xy + a * b, yy + b * b);
    }
    let slope = if xx > 0.0 { xy / xx } else { 0.0 };
    let rest = ((yy - slope * xy).max(0.0) / n).sqrt();
    Some([libm::exp(y - x), slope, rest.max(1e-3)])
}

/// Quantile, linear between the two numbers beside it, with whole numbers spread evenly over their step; puts the
/// numbers in another order. `None` of none.
fn quantile(numbers: &mut [f32], share: f64) -> Option<f64> {
    let place = share * (numbers.len().checked_sub(1)? as f64);
    let (i, part) = (place.floor() as usize, place.fract());
    let (_, low, above) = numbers.select_nth_unstable_by(i, f32::total_cmp);
    let low = *low;
    let high = above.iter().copied().min_by(f32::total_cmp).unwrap_or(low);
    // Of a tie of whole numbers, the share below says where in its step the quantile lies.
    if low.fract() == 0.0 {
        let below = numbers.iter().filter(|x| **x < low).count() as f64;
        let here = numbers.iter().filter(|x| **x == low).count() as f64;
        return Some(f64::from(low) - 0.5 + (place + 0.5 - below) / here);
    }
    Some(f64::from(low) + part * f64::from(high - low))
}
