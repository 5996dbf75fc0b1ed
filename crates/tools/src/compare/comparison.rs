//! Comparison of two sides: a table for people and JSON for programs.

use std::fmt::Write;

use serde_json::{Map, Value, json};

use super::ScanStatistics;
use super::distribution::{DistributionDistance, EmpiricalDistribution};
use super::noise::ScanDirection;

/// What stands in place of noise that interpolated heights do not tell.
const UNTOLD: &str = "can't be told";

/// Version of the document's layout.
const SCHEMA_VERSION: u32 = 1;

/// Two sides.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The simulated one, as a rule.
    pub sim: ScanStatistics,
    /// The real one, as a rule.
    pub real: ScanStatistics,
}

/// How far the two sides lie apart in one statistic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatisticDistance {
    /// What is compared.
    pub name: &'static str,
    /// Unit of the numbers; `1` for pure ones.
    pub unit: &'static str,
    /// The distance; `None` where one side lacks the numbers.
    pub distance: Option<DistributionDistance>,
}

impl Comparison {
    /// Name of the unit of noise.
    pub(super) fn thousandth(&self) -> &'static str {
        self.sim.unit.or(self.real.unit).unwrap_or_default().thousandth()
    }

    /// The distance of each pair of samples.
    pub fn distances(&self) -> [StatisticDistance; 6] {
        let of = |name, unit, sample: fn(&ScanStatistics) -> &EmpiricalDistribution| {
            let distance = sample(&self.sim).distance(sample(&self.real));
            StatisticDistance { name, unit, distance }
        };
        [
            of("range noise", self.thousandth(), |side| &side.noise_sample),
            of("reflectance", "DN", |side| &side.light_sample),
            of("scatter", "DN", |side| &side.scatter_sample),
            of("speckle contrast", "1", |side| &side.contrast_sample),
            of("line width", "px", |side| &side.width_sample),
            of("line sigma", "px", |side| &side.sigma_sample),
        ]
    }

    /// The table.
    pub fn table(&self) -> String {
        let sides = [&self.sim, &self.real];
        let mut text = String::new();
        // Writing to a string cannot fail.
        let mut line = |name: &str, words: [String; 2]| {
            let _ = writeln!(text, "{name:44}{:>24}{:>24}", words[0], words[1]);
        };
        line("", sides.map(|side| short(&side.name)));
        line("pixels that count", sides.map(|side| side.part.clone()));
        line("scans", sides.map(|side| side.frames.to_string()));
        line("columns x profiles", sides.map(|side| format!("{} x {}", side.size.0, side.size.1)));
        let thousandth = self.thousandth();
        let unit = self.sim.unit.or(self.real.unit).unwrap_or_default().name();
        let pitch = |mm: Option<f64>| mm.map_or("-".into(), |mm| format!("{mm:.4}"));
        let pitches = |[col, row]: [Option<f64>; 2]| format!("{}, {}", pitch(col), pitch(row));
        line("pitch along the line, across profiles [mm]", sides.map(|side| pitches(side.pitch_mm)));
        let ends = |ends: Option<[f64; 2]>| ends.map_or("-".into(), |[low, high]| format!("{low:.3} to {high:.3}"));
        line(&format!("heights [{unit}]"), sides.map(|side| ends(side.ends)));
        let percent = |share: Option<f64>| number(share.map(|share| 100.0 * share), 2);
        line("missing heights [%]", sides.map(|side| percent(side.missing)));
        line("least reflectance beside a height [DN]", sides.map(|side| number(side.least_reflectance, 0)));
        line("saturated reflectance [%]", sides.map(|side| percent(side.saturated)));
        let three = |sample: &EmpiricalDistribution, digits: usize| {
            sample.deciles().map_or("-".into(), |numbers| numbers.map(|n| format!("{n:.digits$}")).join(" / "))
        };
        let lag_1 = |list: &[f64]| number(list.get(1).copied(), 3);
        line("scatter at heights, p10 / p50 / p90 [DN]", sides.map(|side| three(&side.scatter_sample, 0)));
        for (i, direction) in ScanDirection::BOTH.into_iter().enumerate() {
            let direction = direction.describe();
            let told = |side: &ScanStatistics| match side.noise[i] {
                None if side.untold[i] > 0 => UNTOLD.into(),
                noise => number(noise, 2),
            };
            line(&format!("range noise, {direction} [{thousandth}]"), sides.map(told));
            if sides.iter().any(|side| side.untold[i] > 0) {
                let count = |side: &ScanStatistics| format!("{} of {}", side.untold[i], side.frames);
                line(&format!("  interpolated, {direction} [scans]"), sides.map(count));
            }
            line(&format!("  edges left out, {direction} [%]"), sides.map(|side| percent(side.edges[i])));
            line(&format!("  lag-1 correlation, {direction}"), sides.map(|side| lag_1(&side.noise_correlation[i])));
        }
        line("speckle contrast of patches, p10 / p50 / p90", sides.map(|side| three(&side.contrast_sample, 2)));
        for (i, direction) in ScanDirection::BOTH.into_iter().enumerate() {
            let name = format!("  lag-1 correlation, {}", direction.describe());
            line(&name, sides.map(|side| lag_1(&side.grain[i])));
        }
        line("laser line width, p10 / p50 / p90 [px]", sides.map(|side| three(&side.width_sample, 2)));
        line("laser line sigma, p10 / p50 / p90 [px]", sides.map(|side| three(&side.sigma_sample, 2)));
        let _ = writeln!(text, "\n{:20}{:>10}{:>10}{:>24}{:>28}", "apart", "KS", "p", "Wasserstein-1", "numbers");
        for StatisticDistance { name, unit, distance } in self.distances() {
            let Some(d) = distance else { continue };
            let apart = format!("{:.4} {}", d.wasserstein, if unit == "1" { "" } else { unit });
            let p = if d.p < 1e-4 { "< 0.0001".into() } else { format!("{:.4}", d.p) };
            let counts = format!("{} and {}", d.counts[0], d.counts[1]);
            let _ = writeln!(text, "{name:20}{:>10.4}{p:>10}{:>24}{counts:>28}", d.ks, apart.trim());
        }
        for side in sides.into_iter().filter(|side| !side.unused.is_empty()) {
            let _ = writeln!(text, "not used of {}: {}", side.name, side.unused.join(", "));
        }
        text
    }

    /// The document.
    pub fn json(&self) -> Value {
        let distance = |d: DistributionDistance| -> Value {
            json!({ "ks": d.ks, "p_if_independent": d.p, "wasserstein": d.wasserstein, "counts": d.counts })
        };
        let entry = |StatisticDistance { name, unit, distance: found }: StatisticDistance| {
            let key = if unit == "1" { name.to_string() } else { format!("{name} {unit}") };
            (key.replace(' ', "_").to_lowercase(), found.map_or(Value::Null, distance))
        };
        let distances: Map<String, Value> = self.distances().into_iter().map(entry).collect();
        json!({
            "schema_version": SCHEMA_VERSION,
            "program": format!("gen {}", env!("CARGO_PKG_VERSION")),
            "sim": side(&self.sim),
            "real": side(&self.real),
            "distances": distances,
        })
    }
}

fn side(side: &ScanStatistics) -> Value {
    let pair = |values: [Value; 2]| -> Value {
        let keys = ScanDirection::BOTH.into_iter().map(|direction| direction.key().to_string());
        keys.zip(values).collect::<Map<_, _>>().into()
    };
    let three = |sample: &EmpiricalDistribution| {
        sample.deciles().map(|[p10, p50, p90]| json!({ "p10": p10, "p50": p50, "p90": p90 }))
    };
    let unit = side.unit.unwrap_or_default();
    let thousandth = unit.thousandth();
    json!({
        "name": side.name,
        "part": side.part,
        "unused": side.unused,
        "scans": side.frames,
        "columns": side.size.0,
        "profiles": side.size.1,
        "pitch_mm": pair(side.pitch_mm.map(|mm| json!(mm))),
        (format!("heights_{}", unit.name())): side.ends,
        "missing_share": side.missing,
        "least_reflectance_dn": side.least_reflectance,
        "saturated_share": side.saturated,
        "scatter_dn": three(&side.scatter_sample),
        (format!("range_noise_{thousandth}")): pair(side.noise.map(|n| json!(n))),
        "interpolated_scans": pair(side.untold.map(|n| json!(n))),
        "edge_share": pair(side.edges.map(|n| json!(n))),
        "range_noise_correlation": pair(side.noise_correlation.clone().map(|list| json!(list))),
        "speckle_contrast": three(&side.contrast_sample),
        "speckle_correlation": pair(side.grain.clone().map(|list| json!(list))),
        "line_width_px": three(&side.width_sample),
        "line_sigma_px": three(&side.sigma_sample),
        "range_spectrum": pair(side.spectrum.clone().map(|points| {
            let frequencies: Vec<f64> = points.iter().map(|point| point.frequency).collect();
            let powers: Vec<f64> = points.iter().map(|point| point.power).collect();
            json!({ "cycles_per_px": frequencies, (format!("{thousandth}2_px")): powers })
        })),
    })
}

fn number(value: Option<f64>, digits: usize) -> String {
    // Adding 0 takes the sign off a rounded -0.
    let rounded = |value: f64| (value * 1e3).round() / 1e3 + 0.0;
    value.map_or("-".into(), |value| format!("{:.digits$}", rounded(value)))
}

/// A name that fits into its column: its end, where file names differ.
pub(super) fn short(name: &str) -> String {
    const MAX_LETTERS: usize = 22;
    let count = name.chars().count();
    if count <= MAX_LETTERS {
        name.into()
    } else {
        format!("..{}", name.chars().skip(count - MAX_LETTERS + 2).collect::<String>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What was not measured is a dash in the table and null in the document, and no distance is made up.
    #[test]
    fn unknown_is_told_as_unknown() {
        let real =
            ScanStatistics { name: "a name that is far too long for its column".into(), ..ScanStatistics::default() };
        let comparison = Comparison { sim: ScanStatistics::default(), real };
        let table = comparison.table();
        assert_eq!(table.lines().next(), Some(format!("{:>92}", ".. long for its column").as_str()), "{table}");
        assert!(!table.contains("NaN") && table.lines().all(|line| line.chars().count() <= 92), "{table}");
        let json = comparison.json();
        assert_eq!((&json["sim"]["missing_share"], &json["distances"]["range_noise_um"]), (&Value::Null, &Value::Null));
        assert!(comparison.page().width() > 0);
    }
}
