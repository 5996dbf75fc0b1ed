//! Plots of a comparison: distributions, correlations and power spectra of both sides on one page.

use image::{Rgb, RgbImage};

use super::distribution::EmpiricalDistribution;
use super::noise::ScanDirection;
use super::power_spectrum::SpectrumPoint;
use super::{Comparison, ScanStatistics};
use drawing::chart::{Axis, Chart, Series};
use drawing::{Area, INK, MARGIN, Page};

/// Size of a plot [px].
const PLOT_PX: (u32, u32) = (400, 270);
/// Height of the heading [px].
const HEADING_PX: u32 = 44;
/// Bars of a histogram.
const HISTOGRAM_BARS: usize = 60;
/// Colours of the two sides.
const SIDE_COLOURS: [Rgb<u8>; 2] = [Rgb([200, 80, 20]), Rgb([20, 90, 160])];

impl Comparison {
    /// The page of plots.
    pub fn page(&self) -> RgbImage {
        let sides = [&self.sim, &self.real];
        let mut charts = vec![
            histogram(sides, "Range noise along the line", self.thousandth(), |side| &side.noise_sample),
            histogram(sides, "Reflectance, unsaturated", "DN", |side| &side.light_sample),
            histogram(sides, "Speckle contrast of patches", "", |side| &side.contrast_sample),
        ];
        for (i, direction) in ScanDirection::BOTH.into_iter().enumerate() {
            charts.push(lags(sides, &format!("Correlation of range noise, {}", direction.describe()), move |side| {
                &side.noise_correlation[i]
            }));
        }
        charts.push(lags(sides, "Correlation of reflectance, along the line", |side| &side.grain[0]));
        for (i, direction) in ScanDirection::BOTH.into_iter().enumerate() {
            charts.push(spectrum(sides, &format!("Power of heights, {}", direction.describe()), i, self.thousandth()));
        }
        let widths = histogram(sides, "Width of the laser line", "px", |side| &side.width_sample);
        let across = || lags(sides, "Correlation of reflectance, across profiles", |side| &side.grain[1]);
        charts.push(widths.or_else(across));
        let (width, height) = (3 * (PLOT_PX.0 + MARGIN) + MARGIN, HEADING_PX + 3 * (PLOT_PX.1 + MARGIN) + MARGIN);
        let mut page = Page::new(width, height);
        for (i, (side, colour)) in sides.into_iter().zip(SIDE_COLOURS).enumerate() {
            let y = 18 + 16 * i as u32;
            page.line(
                (f64::from(MARGIN), f64::from(y) - 4.0),
                (f64::from(MARGIN) + 24.0, f64::from(y) - 4.0),
                colour,
                2,
            );
            let scans = if side.frames == 1 { "1 scan".into() } else { format!("{} scans", side.frames) };
            page.words_in(MARGIN + 32, y, &format!("{}, {scans}", side.name), colour);
        }
        for (i, chart) in charts.into_iter().enumerate() {
            let place =
                (MARGIN + i as u32 % 3 * (PLOT_PX.0 + MARGIN), HEADING_PX + i as u32 / 3 * (PLOT_PX.1 + MARGIN));
            match chart {
                Some(chart) => {
                    chart.draw(&mut page, Area { left: place.0, top: place.1, width: PLOT_PX.0, height: PLOT_PX.1 })
                }
                None => page.words(place.0, place.1 + 12, "(neither side has it)"),
            }
        }
        page.0
    }
}

fn series(points: Vec<(f64, f64)>, side: usize) -> Series {
    let points = points.into_iter().map(|(x, y)| (x, y, 0.0)).collect();
    Series { name: String::new(), colour: SIDE_COLOURS[side], points, joined: true }
}

/// Densities of two samples on common bars, from the least 0.5 % to the largest.
fn histogram(
    sides: [&ScanStatistics; 2],
    title: &str,
    unit: &str,
    pick: fn(&ScanStatistics) -> &EmpiricalDistribution,
) -> Option<Chart> {
    let samples = sides.map(pick);
    let ends = |share| samples.iter().filter_map(move |sample| sample.quantile(share)).collect::<Vec<f64>>();
    let low = ends(0.005).into_iter().reduce(f64::min)?;
    let high = ends(0.995).into_iter().reduce(f64::max)?;
    let wide = if high > low { (high - low) / HISTOGRAM_BARS as f64 } else { 1.0 / HISTOGRAM_BARS as f64 };
    let mut most = 0.0_f64;
    let mut all = Vec::new();
    for (side, sample) in samples.into_iter().enumerate().filter(|(_, sample)| !sample.numbers().is_empty()) {
        // Of the mid-distribution, so that steps of an instrument do not beat with the bars.
        let edge = |i: usize| low + i as f64 * wide;
        let density = |i: usize| (sample.share(edge(i + 1)) - sample.share(edge(i))) / wide;
        let densities: Vec<f64> = (0..HISTOGRAM_BARS).map(density).collect();
        most = densities.iter().copied().fold(most, f64::max);
        // Both edges of each bar, so that the line is the outline of the bars.
        let outline = densities.iter().enumerate().flat_map(|(i, &d)| [(edge(i), d), (edge(i + 1), d)]);
        all.push(series(outline.collect(), side));
    }
    let words = if unit.is_empty() { "contrast".to_string() } else { format!("[{unit}]") };
    let share = if unit.is_empty() { "density".to_string() } else { format!("density [1/{unit}]") };
    let x = Axis::even(&words, low, low + HISTOGRAM_BARS as f64 * wide);
    let y = Axis::even(&share, 0.0, most * 1.05);
    let apart = samples[0].distance(samples[1]);
    let apart = apart.map_or(String::new(), |apart| format!("KS {:.3}, W1 {:.3}", apart.ks, apart.wasserstein));
    Some(Chart { title: title.into(), x, y, series: all, foot: (apart, INK) })
}

fn lags<'a>(
    sides: [&'a ScanStatistics; 2],
    title: &str,
    pick: impl Fn(&'a ScanStatistics) -> &'a Vec<f64>,
) -> Option<Chart> {
    let lists = sides.map(pick);
    let longest = lists.iter().map(|list| list.len()).max().filter(|count| *count > 1)?;
    let points = |list: &[f64]| list.iter().enumerate().map(|(lag, r)| (lag as f64, *r)).collect::<Vec<_>>();
    let least = lists.iter().flat_map(|list| list.iter()).copied().fold(0.0, f64::min);
    Some(Chart {
        title: title.into(),
        x: Axis::even("lag [px]", 0.0, (longest - 1) as f64),
        y: Axis::even("correlation", if least < -0.02 { (least * 5.0).floor() / 5.0 } else { 0.0 }, 1.0),
        series: lists.iter().enumerate().map(|(side, list)| series(points(list), side)).collect(),
        foot: (String::new(), INK),
    })
}

fn spectrum(sides: [&ScanStatistics; 2], title: &str, way: usize, unit: &str) -> Option<Chart> {
    let lists = sides.map(|side| &side.spectrum[way]);
    let powers = || lists.iter().flat_map(|list| list.iter()).map(|point| point.power).filter(|power| *power > 0.0);
    let (low, high) = (powers().reduce(f64::min)?, powers().reduce(f64::max)?);
    let decade = |power: f64| libm::log10(power);
    let ends = (libm::pow(10.0, decade(low).floor()), libm::pow(10.0, decade(high).floor() + 1.0));
    let curve = |list: &[SpectrumPoint]| list.iter().map(|point| (point.frequency, point.power)).collect();
    Some(Chart {
        title: title.into(),
        x: Axis::even("frequency [cycles/px]", 0.0, 0.5),
        y: Axis::log(&format!("power [{unit}^2 per cycle/px]"), ends.0, ends.1),
        series: lists.into_iter().enumerate().map(|(side, list)| series(curve(list), side)).collect(),
        foot: (String::new(), INK),
    })
}
