//! Statistics of one side of a comparison, over all of its scans.
//!
//! A new statistic is a function of one scan in a file of its own, its sums here, its rows in `comparison.rs`. What
//! `gen fit` fits by is a line of `summary.rs`, with the scale in which it scatters nearly normally.

use super::distribution::EmpiricalDistribution;
use super::line_width::{full_width, line_deviation};
use super::noise::{NOISE_LAGS, NoiseCorrelation, ScanDirection, SecondDifferences, is_noise_told};
use super::power_spectrum::{PowerSpectrum, SpectrumPoint};
use super::speckle::{
    CONTRAST_SIDE_PX, CORRELATION_SIDE_PX, SATURATED_DN, SPECKLE_LAGS, SpeckleCorrelation, contrast, patches,
};
use super::{RangeUnit, ScanMaps, SensorFrame};

/// Most numbers of Scatter of a scan that enter its sample; more are left out evenly.
const MAX_SAMPLED_SCATTER: usize = 10_000;

/// Sums over frames.
#[derive(Clone, Default)]
pub struct StatisticsBuilder {
    name: String,
    part: String,
    frames: u64,
    unit: Option<RangeUnit>,
    size: (usize, usize),
    pitch_mm: [Option<f64>; 2],
    ends: Option<[f64; 2]>,
    pixels: u64,
    missing: u64,
    measured: u64,
    unused: Vec<String>,
    untold: [u64; 2],
    edges: [[u64; 2]; 2],
    /// How often each digital number occurs; empty before the first.
    light: Vec<u64>,
    scatter: Vec<f32>,
    noise: [Vec<f32>; 2],
    correlation: [NoiseCorrelation; 2],
    contrast: Vec<f32>,
    grain: [SpeckleCorrelation; 2],
    spectrum: [PowerSpectrum; 2],
    widths: Vec<f32>,
    sigmas: Vec<f32>,
}

/// One side of a comparison. Pairs are along the laser line and across profiles.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ScanStatistics {
    /// What it is called.
    pub name: String,
    /// Which pixels of its scans count, in words.
    pub part: String,
    /// Scans.
    pub frames: u64,
    /// What Range is in the first scan; `None` where there is none. Noise is given in thousandths of it [um or mpx].
    pub unit: Option<RangeUnit>,
    /// What its files hold and nothing here is made from, by name.
    pub unused: Vec<String>,
    /// Columns and profiles of the first scan; 0 where there is none.
    pub size: (usize, usize),
    /// Distance between columns and between profiles of the first scan, where it says so [mm].
    pub pitch_mm: [Option<f64>; 2],
    /// Lowest and highest height [mm or px].
    pub ends: Option<[f64; 2]>,
    /// Share of pixels without a height [1].
    pub missing: Option<f64>,
    /// Least digital number beside a height [DN].
    pub least_reflectance: Option<f64>,
    /// Share of heights whose reflectance is 255 [1].
    pub saturated: Option<f64>,
    /// Robust deviation of heights from second differences, of scans that tell it [um or mpx].
    pub noise: [Option<f64>; 2],
    /// Scans that do not tell it: their heights are interpolated, repeated, or in steps that hide it.
    pub untold: [u64; 2],
    /// Share of second differences that are edges, not noise [1].
    pub edges: [Option<f64>; 2],
    /// Correlation of the noise of heights at lags 0, 1, ... px [1].
    pub noise_correlation: [Vec<f64>; 2],
    /// Correlation of reflectance in patches at lags 0, 1, ... px [1].
    pub grain: [Vec<f64>; 2],
    /// Power spectrum of heights.
    pub spectrum: [Vec<SpectrumPoint>; 2],
    /// Second differences along the line, as deviations, edges left out [um or mpx].
    pub noise_sample: EmpiricalDistribution,
    /// Reflectance beside heights, each digital number as often as in ten thousand of them, saturated ones left out
    /// [DN].
    pub light_sample: EmpiricalDistribution,
    /// Scatter beside heights, at most ten thousand numbers of each scan [DN].
    pub scatter_sample: EmpiricalDistribution,
    /// Contrast of each patch [1].
    pub contrast_sample: EmpiricalDistribution,
    /// Full width of the laser line, column by column [px].
    pub width_sample: EmpiricalDistribution,
    /// Its standard deviation, column by column [px].
    pub sigma_sample: EmpiricalDistribution,
}

impl StatisticsBuilder {
    /// For frames that have a name together.
    pub fn new(name: &str) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// Says which pixels of the frames count, in words.
    #[must_use]
    pub fn of_part(self, part: &str) -> Self {
        Self { part: part.into(), ..self }
    }

    /// Adds a frame without the pixels that `ignored` marks, `[rows, cols]`: they count neither as measured nor as
    /// missing.
    pub fn add_part(&mut self, frame: &ScanMaps, ignored: &[bool]) {
        self.add(&frame.without(ignored));
        let left_out = ignored.iter().filter(|ignored| **ignored).count() as u64;
        (self.pixels, self.missing) = (self.pixels - left_out, self.missing - left_out);
    }

    /// Adds a frame.
    pub fn add(&mut self, frame: &ScanMaps) {
        for name in &frame.unused {
            if !self.unused.contains(name) {
                self.unused.push(name.clone());
            }
        }
        for column in frame.exposures.iter().flat_map(SensorFrame::columns) {
            if let Some(width) = full_width(&column) {
                self.widths.push(width);
                self.sigmas.extend(line_deviation(&column, width));
            }
        }
        if frame.range.is_empty() {
            return;
        }
        if self.frames == 0 {
            self.pitch_mm = [frame.col_mm, frame.row_mm];
            (self.size, self.unit) = ((frame.cols, frame.rows), Some(frame.unit));
        }
        self.frames += 1;
        self.pixels += frame.range.len() as u64;
        self.missing += frame.range.iter().filter(|z| !z.is_finite()).count() as u64;
        for &z in frame.range.iter().filter(|z| z.is_finite()) {
            let [low, high] = self.ends.unwrap_or([z; 2]);
            self.ends = Some([low.min(z), high.max(z)]);
        }
        if let Some(scatter) = &frame.scatter {
            let beside = || scatter.iter().zip(&frame.range).filter(|(_, z)| z.is_finite()).map(|(dn, _)| *dn);
            let keep = beside().count().div_ceil(MAX_SAMPLED_SCATTER).max(1);
            self.scatter.extend(beside().step_by(keep));
        }
        if let Some(light) = &frame.reflectance {
            self.light.resize(256, 0);
            for (&dn, _) in light.iter().zip(&frame.range).filter(|(_, z)| z.is_finite()) {
                self.light[dn.round() as u8 as usize] += 1;
                self.measured += 1;
            }
        }
        let seconds = ScanDirection::BOTH.map(|direction| SecondDifferences::new(frame, direction));
        for (i, second) in seconds.iter().enumerate() {
            if is_noise_told(frame, ScanDirection::BOTH[i]) {
                let all = second.sample.numbers();
                let noise: Vec<f32> = all.iter().copied().filter(|&d| second.is_noise(d)).collect();
                self.edges[i][0] += (all.len() - noise.len()) as u64;
                self.edges[i][1] += all.len() as u64;
                self.noise[i].extend(noise);
            } else {
                self.untold[i] += 1;
            }
            // Along the line by differences across, and the other way round.
            self.correlation[1 - i].add(frame, second, ScanDirection::BOTH[1 - i]);
        }
        self.contrast.extend(patches(frame, &seconds, CONTRAST_SIDE_PX).iter().map(|patch| contrast(patch)));
        for patch in patches(frame, &seconds, CORRELATION_SIDE_PX) {
            ScanDirection::BOTH
                .into_iter()
                .zip(&mut self.grain)
                .for_each(|(direction, correlation)| correlation.add(&patch, direction));
        }
        for ((direction, spectrum), second) in ScanDirection::BOTH.into_iter().zip(&mut self.spectrum).zip(&seconds) {
            spectrum.add(frame, direction, second);
        }
    }

    /// What the sums say.
    pub fn statistics(self) -> ScanStatistics {
        let share = |part: u64, of: u64| (of > 0).then(|| part as f64 / of as f64);
        let least = self.light.iter().enumerate().skip(1).find(|(_, count)| **count > 0);
        let saturated = self.light.get(SATURATED_DN as usize).and_then(|count| share(*count, self.measured));
        let [along, across] = self.noise.map(EmpiricalDistribution::new);
        let [scatter_sample, contrast_sample, width_sample, sigma_sample] =
            [self.scatter, self.contrast, self.widths, self.sigmas].map(EmpiricalDistribution::new);
        ScanStatistics {
            name: self.name,
            part: self.part,
            frames: self.frames,
            unit: self.unit,
            size: self.size,
            pitch_mm: self.pitch_mm,
            ends: self.ends,
            missing: share(self.missing, self.pixels),
            least_reflectance: least.map(|(dn, _)| dn as f64),
            saturated,
            noise: [along.robust_deviation(), across.robust_deviation()],
            unused: self.unused,
            untold: self.untold,
            edges: self.edges.map(|[edges, all]| share(edges, all)),
            noise_correlation: self.correlation.map(|sums| (0..NOISE_LAGS).map_while(|lag| sums.at(lag)).collect()),
            grain: self.grain.map(|sums| (0..SPECKLE_LAGS).map_while(|lag| sums.at(lag)).collect()),
            spectrum: self.spectrum.map(|spectrum| spectrum.points()),
            noise_sample: along,
            light_sample: light_sample(&self.light),
            scatter_sample,
            contrast_sample,
            width_sample,
            sigma_sample,
        }
    }
}

/// Unsaturated reflectance as a sample of at most ten thousand numbers.
fn light_sample(counts: &[u64]) -> EmpiricalDistribution {
    const MAX_SAMPLE: u64 = 10_000;
    let counts = counts.get(1..SATURATED_DN as usize).unwrap_or_default();
    let all: u64 = counts.iter().sum();
    let keep = all.div_ceil(MAX_SAMPLE).max(1);
    let mut passed = 0;
    let mut numbers = Vec::new();
    for (dn, count) in (1_u16..).zip(counts) {
        let before = passed / keep;
        passed += count;
        numbers.extend((before..passed / keep).map(|_| f32::from(dn)));
    }
    EmpiricalDistribution::new(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::ScanRegion;
    use crate::compare::power_spectrum::FREQUENCIES;

    /// Shares by hand: two of eight missing, one of six saturated, the least number that has a height.
    #[test]
    fn shares_by_hand() {
        let mut range = vec![1.0; 8];
        range[0] = f64::NAN;
        range[5] = f64::NAN;
        let reflectance = Some(vec![9.0, 255.0, 30.0, 21.0, 254.0, 0.0, 22.0, 254.4]);
        range[6] = -2.5;
        let scatter = Some(vec![9e9, 40.0, 50.0, 60.0, 70.0, 9e9, 80.0, 90.0]);
        let (col_mm, row_mm) = (Some(0.1), Some(0.2));
        let frame = ScanMaps { cols: 4, rows: 2, col_mm, row_mm, range, reflectance, scatter, ..ScanMaps::default() };
        let mut builder = StatisticsBuilder::new("by hand");
        builder.add(&frame);
        let found = builder.statistics();
        assert_eq!(
            (found.missing, found.saturated, found.least_reflectance),
            (Some(0.25), Some(1.0 / 6.0), Some(21.0))
        );
        assert_eq!(found.light_sample.numbers(), [21.0, 22.0, 30.0, 254.0, 254.0]);
        assert_eq!((found.frames, found.size), (1, (4, 2)));
        assert_eq!((found.contrast_sample.deciles(), found.width_sample.deciles()), (None, None));
        assert_eq!((found.pitch_mm, found.ends), ([Some(0.1), Some(0.2)], Some([-2.5, 1.0])));
        assert_eq!(found.scatter_sample.numbers(), [40.0, 50.0, 60.0, 70.0, 80.0, 90.0]);
        assert_eq!(found.scatter_sample.deciles().map(|[_, middle, _]| middle), Some(65.0));
    }

    /// Pixels that don't count are neither measured nor missing, and leave no noise; their light counts nowhere.
    #[test]
    fn a_part_is_counted_alone() {
        let height = |i: usize| if i % 80 < 40 { ((i * 7919) % 101) as f64 * 0.001 } else { ((i * 7919) % 89) as f64 };
        let range: Vec<f64> = (0..80 * 60).map(|i| if i % 7 == 0 { f64::NAN } else { height(i) }).collect();
        let reflectance = Some((0..80 * 60).map(|i| if i % 80 < 40 { 100.0 } else { 9.0 }).collect());
        let frame = ScanMaps { cols: 80, rows: 60, range, reflectance, ..ScanMaps::default() };
        let mut half = frame.clone();
        let region = ScanRegion { left: 0, top: 0, columns: 40, profiles: 60 };
        let inside = half.cut_to(None, Some(region), None).expect("it lies inside");
        assert_eq!(inside, Some(vec![false; 40 * 60]));
        let of = |frame: &ScanMaps, ignored: &[bool]| {
            let mut builder = StatisticsBuilder::new("part");
            builder.add_part(frame, ignored);
            ScanStatistics { size: (0, 0), ..builder.statistics() }
        };
        let ignored: Vec<bool> = (0..80 * 60).map(|i| i % 80 >= 40).collect();
        assert_eq!(of(&frame, &ignored).missing, of(&half, &[]).missing);
        assert_eq!(of(&frame, &ignored).light_sample, of(&half, &[]).light_sample);
        assert_eq!(of(&frame, &ignored).least_reflectance, Some(100.0));
        assert_eq!((of(&frame, &[]).least_reflectance, of(&frame, &ignored).ends), (Some(9.0), of(&half, &[]).ends));
        let nothing = of(&frame, &[true; 80 * 60]);
        assert_eq!((nothing.missing, nothing.noise, nothing.ends), (None, [None; 2], None));
        for (left, columns) in [(41, 40), (usize::MAX, 2)] {
            let beyond = ScanRegion { left, columns, ..region };
            assert!(half.cut_to(None, Some(beyond), None).is_err());
        }
    }

    /// A frame twice is what it is once; nothing at all says nothing.
    #[test]
    fn frames_add_up() {
        let height = |i: usize| libm::sin(i as f64 * 0.7) * 0.01 + ((i * 7919) % 101) as f64 * 0.0003;
        let light = |i: usize| 100.0 + ((i * 7919) % 97) as f32;
        let range: Vec<f64> = (0..96 * 80).map(height).collect();
        let reflectance = Some((0..96 * 80).map(light).collect());
        let column = [0, 0, 0, 0, 50, 100, 50, 0, 0, 0];
        let exposures = vec![crate::compare::SensorFrame { cols: 1, profile: None, dn: column.to_vec() }];
        let frame = ScanMaps { cols: 96, rows: 80, range, reflectance, exposures, ..ScanMaps::default() };
        let of = |times: usize| {
            let mut builder = StatisticsBuilder::new("n");
            (0..times).for_each(|_| builder.add(&frame));
            builder.statistics()
        };
        let (once, twice) = (of(1), of(2));
        assert_eq!((twice.frames, twice.missing, twice.saturated), (2, Some(0.0), Some(0.0)));
        assert_eq!([&once, &twice].map(|side| side.width_sample.deciles()), [Some([2.0; 3]); 2]);
        let same = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(1.0);
        for way in [0, 1] {
            assert!(same(once.noise[way].expect("noise"), twice.noise[way].expect("noise")));
            for (a, b) in once.noise_correlation[way].iter().zip(&twice.noise_correlation[way]) {
                assert!(same(*a, *b));
            }
            for (a, b) in once.spectrum[way].iter().zip(&twice.spectrum[way]) {
                assert!(same(a.power, b.power));
            }
            assert_eq!((once.noise_correlation[way].len(), once.spectrum[way].len()), (NOISE_LAGS, FREQUENCIES));
        }
        assert_eq!(of(0), ScanStatistics { name: "n".into(), ..ScanStatistics::default() });
    }
}
