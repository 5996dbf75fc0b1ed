//! Grey scale of measured maps in 8 bits: one for a whole dataset, never for an image, written down so that it can be
//! undone.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::picture_options::PictureOptions;
use super::sample::ExportSample;
use super::source::{ExportProgress, ExportSource};
use dataset::Fault;

/// Samples that a scale is found from.
const MAX_SCALE_SAMPLES: u64 = 64;
/// Share of pixels beyond each end of a scale found from samples [1].
const CLIPPED_SHARE: f64 = 0.001;
/// Heights are counted in hundredths [1/mm or 1/px].
const BINS_PER_UNIT: f64 = 100.0;
/// Grey levels of a map with 8 bits that mean something: 0 means missing.
const GREY_LEVELS: f64 = 254.0;

/// What grey levels of one map mean: `offset + scale * g` for g of 1 to 255; 0 is missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MapScale {
    /// Value at grey level 0 of the line [mm, px or DN].
    pub offset: f64,
    /// A step [mm, px or DN].
    pub scale: f64,
}

impl MapScale {
    /// From `low` at level 1 to `high` at level 255.
    pub fn between([low, high]: [f64; 2]) -> Self {
        // A map of one value still has steps.
        let scale = if high > low { (high - low) / GREY_LEVELS } else { 1.0 };
        Self { offset: low - scale, scale }
    }

    /// The grey level of a value.
    pub fn level(self, value: f64) -> u8 {
        // Casts of floats saturate.
        ((value - self.offset) / self.scale).round().clamp(1.0, 255.0) as u8
    }
}

/// The scales of a dataset.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MapScales {
    /// The maps that are shown, in the order of channels, each with its scale.
    maps: Vec<(&'static str, MapScale)>,
}

impl MapScales {
    /// The scales that the user gave, else from 64 finished samples spread over all that are, whatever is exported:
    /// from the thousandth smallest to the thousandth largest value of pixels that show the object. Reflectance has 8
    /// bits as a rule and then stays as it is.
    ///
    /// # Errors
    /// Where these samples are damaged, or no pixel shows the object.
    pub(super) fn of(source: &ExportSource, given: &PictureOptions, progress: ExportProgress) -> Result<Self, Fault> {
        let maps = given.image.maps();
        let unknown: Vec<&str> = [("range", given.range_ends), ("scatter", given.scatter_ends)]
            .into_iter()
            .filter(|(name, ends)| ends.is_none() && maps.contains(name))
            .map(|(name, _)| name)
            .collect();
        let mut counts: BTreeMap<&str, BTreeMap<i64, u64>> = BTreeMap::new();
        if !unknown.is_empty() {
            let mut images = unknown.clone();
            images.extend(Some("label").filter(|label| source.has(label)));
            let work = |sample: &ExportSample| {
                let labels = source.has("label").then(|| sample.grey("label")).transpose()?.map(|grey| grey.numbers());
                unknown.iter().map(|name| histogram(sample, name, labels.as_deref())).collect::<Result<Vec<_>, _>>()
            };
            let take = |found: Vec<Vec<(i64, u64)>>| {
                for (name, bins) in unknown.iter().zip(found) {
                    let counts = counts.entry(name).or_default();
                    bins.into_iter().for_each(|(bin, count)| *counts.entry(bin).or_default() += count);
                }
            };
            source.spread(MAX_SCALE_SAMPLES, &images, work, take, progress)?;
        }
        let scaling = |name: &'static str| {
            let found = |unit: f64| {
                let ends = counts.get(name).and_then(ends).map(|ends| ends.map(|end| end / unit));
                ends.ok_or_else(|| {
                    let what =
                        format!("no pixel of the samples that the ends of {name} are found from shows the object");
                    Fault::at(source.root(), what, format!("give them with --{name}-ends LOW,HIGH"))
                })
            };
            let ends = match name {
                "range" => given.range_ends.map_or_else(|| found(BINS_PER_UNIT), Ok)?,
                "scatter" => given.scatter_ends.map_or_else(|| found(1.0), Ok)?,
                _ => [1.0, f64::from(source.head().images.most_dn()).max(255.0)],
            };
            Ok((name, MapScale::between(ends)))
        };
        Ok(Self { maps: maps.iter().copied().map(scaling).collect::<Result<_, Fault>>()? })
    }

    /// The scales, channel by channel.
    pub(super) fn channels(&self) -> impl Iterator<Item = (&'static str, MapScale)> + '_ {
        self.maps.iter().copied()
    }

    /// For documents: what grey levels of the maps mean.
    pub(super) fn json(&self, range_unit: &str) -> Value {
        let one = |(map, MapScale { offset, scale }): (&str, MapScale)| {
            let unit = if map == "range" { range_unit } else { "DN" };
            json!({"map": map, "offset": offset, "scale": scale, "unit": unit, "missing": 0})
        };
        Value::Array(self.channels().map(one).collect())
    }
}

/// What numbers of a stored map mean: `offset + scale * n`.
pub(super) fn physical_scale(sample: &ExportSample, map: &str) -> Result<[f64; 2], Fault> {
    if map == "range" { sample.range_scale() } else { Ok([0.0, 1.0]) }
}

/// How many pixels that show the object have each value of a map: whole DN, hundredths of a millimetre or of a row.
fn histogram(sample: &ExportSample, map: &str, labels: Option<&[u16]>) -> Result<Vec<(i64, u64)>, Fault> {
    let [offset, scale] = physical_scale(sample, map)?;
    let numbers = sample.grey(map)?.numbers();
    let mut pixels = vec![0_u64; 1 << 16];
    match labels {
        Some(labels) => {
            let shown = numbers.iter().zip(labels).filter(|(_, label)| **label > 0);
            shown.for_each(|(n, _)| pixels[usize::from(*n)] += 1);
        }
        None => numbers.iter().for_each(|n| pixels[usize::from(*n)] += 1),
    }
    let mut bins: Vec<(i64, u64)> = Vec::new();
    // 0 is missing.
    for (n, &count) in pixels.iter().enumerate().skip(1).filter(|(_, count)| **count > 0) {
        let value = offset + scale * n as f64;
        let bin = if map == "range" { (BINS_PER_UNIT * value).round() } else { value } as i64;
        match bins.last_mut() {
            Some((last, counted)) if *last == bin => *counted += count,
            _ => bins.push((bin, count)),
        }
    }
    Ok(bins)
}

fn is_past(passed: &mut u64, count: u64, beyond: u64) -> bool {
    *passed += count;
    *passed > beyond
}

/// The values with a share of [`CLIPPED_SHARE`] below the one and above the other.
fn ends(counts: &BTreeMap<i64, u64>) -> Option<[f64; 2]> {
    let all: u64 = counts.values().sum();
    let beyond = (CLIPPED_SHARE * all as f64) as u64;
    let mut passed = 0;
    let low = counts.iter().find(|(_, count)| is_past(&mut passed, **count, beyond))?;
    passed = 0;
    let high = counts.iter().rev().find(|(_, count)| is_past(&mut passed, **count, beyond))?;
    Some([*low.0 as f64, *high.0 as f64])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Levels are undone to half a step, ends are ends, and 0 stays free for missing.
    #[test]
    fn a_scale_can_be_undone() {
        let scaling = MapScale::between([20.0, 30.0]);
        for value in [20.0, 20.01, 24.3, 29.99, 30.0] {
            let level = scaling.level(value);
            let back = scaling.offset + scaling.scale * f64::from(level);
            assert!(level > 0 && (back - value).abs() <= 0.5 * scaling.scale + 1e-12, "{value}: {level}, {back}");
        }
        assert_eq!([19.0, 31.0].map(|value| scaling.level(value)), [1, 255]);
        let same = MapScale::between([1.0, 255.0]);
        assert!((1..=255).all(|n: u8| same.level(f64::from(n)) == n), "a scale of 1 changes nothing");
    }

    #[test]
    fn ends_leave_a_thousandth_out() {
        let counts = BTreeMap::from([(-5, 1), (0, 1), (1, 1996), (2, 1), (9, 1)]);
        assert_eq!(ends(&counts), Some([1.0, 1.0]));
        assert_eq!(ends(&BTreeMap::from([(3, 10), (4, 10)])), Some([3.0, 4.0]));
        assert_eq!(ends(&BTreeMap::new()), None);
    }
}
