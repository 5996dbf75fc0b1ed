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
//! Noise is measured with second differences as in [`super::noise`], here as the standard deviation of those within
//! `EDGE_DEVIATIONS` (4) robust deviations: steps of digital numbers then don't show. Noise of Reflectance and Scatter
//! is measured apart where Reflectance is below and above its median, since light noise rises with light and dark noise
//! does not. What all pixels of a profile (or column) have in common is the deviation of the means of such differences
//! over that of single pixels, with the factor by which independent pixels would lower it.

use super::noise::{EDGE_DEVIATIONS, NoiseCorrelation, ScanDirection, SecondDifferences};
use super::power_spectrum::PowerSpectrum;
use super::speckle::{CONTRAST_SIDE_PX, CORRELATION_SIDE_PX, SATURATED_DN, SpeckleCorrelation, contrast, patches};
use super::{RangeUnit, ScanMaps, line_width};

/// Shares below which values lie that stand for a histogram.
const QUANTILES: [(f64, &str); 5] = [(0.05, "p05"), (0.25, "p25"), (0.5, "p50"), (0.75, "p75"), (0.95, "p95")];
/// Lags of the correlations that are taken [px].
const LAGS: [usize; 3] = [1, 2, 3];
/// Fewest numbers from which a statistic is taken.
const FEWEST: usize = 24;
/// Distance of the quartiles of the standard normal law.
const QUARTILES: f64 = 1.348_979_500_392_163_5;
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
    fn push(
        &mut self,
        key: impl Into<String>,
        name: impl Into<String>,
        unit: &'static str,
        law: SummaryLaw,
        number: Option<f64>,
    ) {
        let scaled = number.filter(|number| number.is_finite()).map(|number| law.scaled(number));
        self.list.push(SummaryStatistic { key: key.into(), name: name.into(), unit, law, scaled });
    }

    /// What is missing, and how it lies.
    fn shares(&mut self, maps: &ScanMaps, ignored: Option<&[bool]>, counted: usize) {
        let (cols, rows) = (maps.cols, maps.rows);
        let is_ignored = |i: usize| ignored.is_some_and(|ignored| ignored[i]);
        let is_missing = |i: usize| maps.range[i].is_nan() && !is_ignored(i);
        let missing = (0..maps.range.len()).filter(|&i| is_missing(i)).count();
        let share = (counted > 0).then(|| missing as f64 / counted as f64);
        self.push("missing_share", "missing heights", "1", SummaryLaw::Share, share);
        for direction in ScanDirection::BOTH {
            let (lines, length, start) = match direction {
                ScanDirection::Along => (rows, cols, cols),
                ScanDirection::Across => (cols, rows, 1),
            };
            let mut runs = 0_usize;
            for line in 0..lines {
                let mut before = false;
                for place in 0..length {
                    let now = is_missing(line * start + place * direction.step(cols));
                    runs += usize::from(now && !before);
                    before = now;
                }
            }
            let mean = (runs > 0).then(|| missing as f64 / runs as f64);
            self.push(
                format!("missing_run_{}", direction.key()),
                format!("mean run of missing heights {}", direction.describe()),
                "px",
                SummaryLaw::Positive,
                mean,
            );
        }
    }

    /// Heights: spread, noise, its correlation, spectrum.
    fn range(&mut self, maps: &ScanMaps, seconds: &[SecondDifferences; 2]) {
        let mut heights: Vec<f32> = maps.range.iter().filter(|z| z.is_finite()).map(|&z| z as f32).collect();
        let [low, high] = [0.05, 0.95].map(|share| quantile(&mut heights, share));
        let spread = low.zip(high).map(|(low, high)| high - low);
        let unit = if maps.unit == RangeUnit::Mm { "mm" } else { "px" };
        self.push("height_spread", "heights, 5 to 95 %", unit, SummaryLaw::Positive, spread);
        for (direction, second) in ScanDirection::BOTH.into_iter().zip(seconds) {
            let noise: Vec<f32> = second.map.iter().copied().filter(|d| d.is_finite()).collect();
            let total = noise.len();
            let found = trimmed_deviation(noise);
            self.push(
                format!("range_noise_{}", direction.key()),
                format!("range noise {}", direction.describe()),
                self.unit,
                SummaryLaw::Positive,
                found.map(|found| found.deviation),
            );
            let edges = found.map(|found| found.beyond as f64 / total as f64);
            self.push(
                format!("edge_share_{}", direction.key()),
                format!("edges {}", direction.describe()),
                "1",
                SummaryLaw::Share,
                edges,
            );
        }
        for (i, direction) in ScanDirection::BOTH.into_iter().enumerate() {
            let mut correlation = NoiseCorrelation::default();
            correlation.add(maps, &seconds[1 - i], direction);
            for lag in LAGS {
                self.push(
                    format!("range_correlation_{}_{lag}", direction.key()),
                    format!("correlation of range noise {}, lag {lag}", direction.describe()),
                    "1",
                    SummaryLaw::Correlation,
                    correlation.at(lag),
                );
            }
        }
        for (direction, second) in ScanDirection::BOTH.into_iter().zip(seconds) {
            let mut spectrum = PowerSpectrum::default();
            spectrum.add(maps, direction, second);
            let points = spectrum.points();
            for (from, to, word) in [(0, 2, "low"), (2, 7, "middle")] {
                let power = points
                    .get(from..to)
                    .map(|points| (points.iter().map(|point| point.power).sum::<f64>() / points.len() as f64).sqrt());
                self.push(
                    format!("range_spectrum_{word}_{}", direction.key()),
                    format!("root of the heights' power {}, {word} frequencies", direction.describe()),
                    self.unit,
                    SummaryLaw::Positive,
                    power,
                );
            }
        }
        let heights: Vec<f32> = maps.range.iter().map(|&z| (1000.0 * z) as f32).collect();
        self.common(&heights, maps, "range", "Range");
    }

    /// Reflectance: saturation, histogram, noise, speckle.
    fn light(&mut self, maps: &ScanMaps, seconds: &[SecondDifferences; 2]) {
        let light: Vec<f32> = match &maps.reflectance {
            Some(light) => {
                light.iter().zip(&maps.range).map(|(&dn, z)| if z.is_nan() { f32::NAN } else { dn }).collect()
            }
            None => Vec::new(),
        };
        let measured = light.iter().filter(|dn| dn.is_finite()).count();
        let full = light.iter().filter(|dn| **dn >= SATURATED_DN).count();
        let saturated = (measured > 0).then(|| full as f64 / measured as f64);
        self.push("saturated_share", "saturated reflectance", "1", SummaryLaw::Share, saturated);
        let mut part: Vec<f32> = light.iter().copied().filter(|dn| *dn < SATURATED_DN).collect();
        let least = quantile(&mut part, 0.002);
        self.push("reflectance_floor", "least reflectance (0.2 %)", "DN", SummaryLaw::Positive, least);
        for (share, word) in QUANTILES {
            let dn = quantile(&mut part, share);
            let name = format!("unsaturated reflectance, {}", word.replace('p', "percentile ").replace(" 0", " "));
            self.push(format!("reflectance_{word}"), name, "DN", SummaryLaw::Positive, dn);
        }
        let middle = quantile(&mut part, 0.5);
        let open: Vec<f32> = light.iter().map(|&dn| if dn >= SATURATED_DN { f32::NAN } else { dn }).collect();
        self.noise_by_light(&open, &open, middle, maps, "reflectance", "reflectance");
        self.common(&open, maps, "reflectance", "Reflectance");
        let contrasts: Vec<f32> =
            patches(maps, seconds, CONTRAST_SIDE_PX).iter().map(|patch| contrast(patch)).collect();
        let share =
            (measured > 0).then(|| (contrasts.len() * CONTRAST_SIDE_PX * CONTRAST_SIDE_PX) as f64 / measured as f64);
        self.push("patch_share", "level patches without saturation", "1", SummaryLaw::Share, share);
        let mut contrasts = if contrasts.len() < FEWEST { Vec::new() } else { contrasts };
        for (share, word) in [(0.1, "p10"), (0.5, "p50"), (0.9, "p90")] {
            let found = quantile(&mut contrasts, share);
            let name = format!("speckle contrast, percentile {}", &word[1..]);
            self.push(format!("contrast_{word}"), name, "1", SummaryLaw::Positive, found);
        }
        let mut grain = [SpeckleCorrelation::default(); 2];
        let large = patches(maps, seconds, CORRELATION_SIDE_PX);
        for patch in &large {
            ScanDirection::BOTH.into_iter().zip(&mut grain).for_each(|(direction, sums)| sums.add(patch, direction));
        }
        for (direction, sums) in ScanDirection::BOTH.into_iter().zip(&grain) {
            for lag in &LAGS[..2] {
                let found = sums.at(*lag).filter(|_| large.len() >= FEWEST);
                self.push(
                    format!("grain_{}_{lag}", direction.key()),
                    format!("correlation of reflectance {}, lag {lag}", direction.describe()),
                    "1",
                    SummaryLaw::Correlation,
                    found,
                );
            }
        }
    }

    /// Scatter: histogram, noise, and how it goes with Reflectance.
    fn scatter(&mut self, maps: &ScanMaps) {
        let scatter: Vec<f32> = match &maps.scatter {
            Some(light) => {
                light.iter().zip(&maps.range).map(|(&dn, z)| if z.is_nan() { f32::NAN } else { dn }).collect()
            }
            None => Vec::new(),
        };
        let mut part: Vec<f32> = scatter.iter().copied().filter(|dn| dn.is_finite()).collect();
        for (share, word) in QUANTILES {
            let dn = quantile(&mut part, share).map(|dn| dn.max(0.5));
            let name = format!("scatter, {}", word.replace('p', "percentile ").replace(" 0", " "));
            self.push(format!("scatter_{word}"), name, "DN", SummaryLaw::Positive, dn);
        }
        let light = maps.reflectance.as_deref().unwrap_or_default();
        let mut open: Vec<f32> = light
            .iter()
            .zip(&scatter)
            .filter(|(dn, s)| **dn < SATURATED_DN && s.is_finite())
            .map(|(dn, _)| *dn)
            .collect();
        let middle = quantile(&mut open, 0.5);
        self.noise_by_light(&scatter, light, middle, maps, "scatter", "scatter");
        self.common(&scatter, maps, "scatter", "Scatter");
        let line = law_of_light(light, &scatter);
        for (number, key, name, law) in [
            (
                line.map(|line| line[0]),
                "scatter_at_light",
                "scatter over reflectance at its mean",
                SummaryLaw::Positive,
            ),
            (line.map(|line| line[1]), "scatter_slope", "slope of ln scatter over ln reflectance", SummaryLaw::Plain),
            (line.map(|line| line[2]), "scatter_rest", "spread of ln scatter about that line", SummaryLaw::Positive),
        ] {
            self.push(key, name, "1", law, number);
        }
    }

    /// The laser line on the sensor, where frames were kept.
    fn line(&mut self, maps: &ScanMaps) {
        const MOST_COLUMNS: usize = 4096;
        let (mut widths, mut sigmas) = (Vec::new(), Vec::new());
        let (mut darks, mut dark_noise) = (Vec::new(), Vec::new());
        for exposure in &maps.exposures {
            let (cols, rows) = (exposure.cols, exposure.dn.len() / exposure.cols.max(1));
            for x in (0..cols).step_by(cols.div_ceil(MOST_COLUMNS).max(1)) {
                let column: Vec<u8> = (0..rows).map(|y| exposure.dn[y * cols + x]).collect();
                if let Some(width) = line_width::full_width(&column) {
                    widths.push(width);
                    sigmas.extend(line_width::line_deviation(&column, width));
                }
                let mut sorted = column;
                sorted.sort_unstable();
                // Half of the rows lie beside the line.
                let at = |share: f64| sorted.get((share * sorted.len() as f64) as usize).map(|&dn| f64::from(dn));
                if let (Some(low), Some(middle)) = (at(0.1), at(0.4)) {
                    darks.push(middle as f32);
                    dark_noise.push((middle - low) as f32);
                }
            }
        }
        let mean = |numbers: &[f32]| {
            (!numbers.is_empty()).then(|| numbers.iter().map(|&x| f64::from(x)).sum::<f64>() / numbers.len() as f64)
        };
        let (width, sigma) = (quantile(&mut widths, 0.5), quantile(&mut sigmas, 0.5));
        self.push("line_width", "laser line's full width at half maximum", "px", SummaryLaw::Positive, width);
        self.push("line_sigma", "laser line's standard deviation", "px", SummaryLaw::Positive, sigma);
        self.push("frame_dark", "dark level of frames", "DN", SummaryLaw::Positive, mean(&darks));
        let spread = mean(&dark_noise).map(|dn| dn.max(0.02));
        self.push("frame_dark_spread", "dark level of frames, 10 to 40 %", "DN", SummaryLaw::Positive, spread);
    }

    /// Noise of a map where `light` is below and above `middle`, in both directions.
    fn noise_by_light(
        &mut self,
        map: &[f32],
        light: &[f32],
        middle: Option<f64>,
        maps: &ScanMaps,
        key: &str,
        name: &str,
    ) {
        for direction in ScanDirection::BOTH {
            let mut halves: [Vec<f32>; 2] = Default::default();
            if let Some(middle) = middle {
                second_differences(map, maps, direction, |i, second| {
                    halves[usize::from(f64::from(light[i]) > middle)].push(second);
                });
            }
            for (half, word) in halves.into_iter().zip(["dim", "bright"]) {
                let found = trimmed_deviation(half).map(|found| found.deviation.max(0.02));
                self.push(
                    format!("{key}_noise_{}_{word}", direction.key()),
                    format!("noise of {name} {}, {word} half", direction.describe()),
                    "DN",
                    SummaryLaw::Positive,
                    found,
                );
            }
        }
    }

    /// What pixels of a line have in common: of profiles by differences across them, of columns by those along the
    /// line.
    fn common(&mut self, map: &[f32], maps: &ScanMaps, key: &str, name: &str) {
        for (direction, word, words) in
            [(ScanDirection::Across, "profiles", "a profile"), (ScanDirection::Along, "columns", "a column")]
        {
            let (cols, rows) = (maps.cols, maps.rows);
            let lines = if direction == ScanDirection::Across { rows } else { cols };
            let mut all = Vec::new();
            let mut places = Vec::new();
            second_differences(map, maps, direction, |i, second| {
                all.push(second);
                places.push(if direction == ScanDirection::Across { i / cols } else { i % cols });
            });
            let ratio = trimmed_deviation(all.clone()).and_then(|found| {
                let mut sums = vec![(0.0, 0_usize); lines];
                for (&place, &second) in places.iter().zip(&all) {
                    if f64::from((second - found.middle).abs()) <= EDGE_DEVIATIONS * found.robust {
                        sums[place].0 += f64::from(second - found.middle);
                        sums[place].1 += 1;
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
            self.push(
                format!("{key}_common_{word}"),
                format!("noise of {name} that {words} has in common, over that of independent pixels"),
                "1",
                SummaryLaw::Positive,
                ratio,
            );
        }
    }
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
