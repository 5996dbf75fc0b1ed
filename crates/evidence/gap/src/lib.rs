//! How far two sides are apart, as a classifier sees it: a two-sample test by classification (Friedman 2003; Lopez-Paz
//! and Oquab 2017).
//!
//! **Model.** A network is trained to tell windows of the real scans from windows of the simulated ones
//! ([`network.py`](network.py), [windows](GapSide)). Parts (scans, or blocks of one scan) are dealt
//! to K folds; the windows of each fold are judged by a network that has seen none of it. With k_c right answers of n_c
//! in part c
//!
//! ```text
//! p_side = sum_c k_c / sum_c n_c,     accuracy = (p_sim + p_real) / 2
//! ```
//!
//! which is 0.5 in the mean where both sides are of one law, and at most 1. It is a lower bound: another network may
//! see more.
//!
//! **Interval.** Windows of a part are not independent, so parts are what varies. The variance of a ratio of sums over
//! m parts (Cochran 1977, 6.4), never less than that of independent windows (with one right and one wrong answer added,
//! Laplace), and Student's quantile with the degrees of freedom of Welch (1947):
//!
//! ```text
//! v_side = max(m/(m-1) sum_c (k_c - p n_c)^2 / n^2,  p'(1-p')/n),      p' = (k + 1) / (n + 2)
//! accuracy -+ t_f sqrt(v_sim + v_real) / 2,      f = (v_sim + v_real)^2 / (v_sim^2/(m_sim-1) + v_real^2/(m_real-1))
//! ```
//!
//! cut to 0 and 1. It does the work of a bootstrap over parts, whose percentiles are too close together for the two to
//! ten scans that there are: of two scans it has three values. It leaves out that networks of two folds share most of
//! their training data (Bengio and Grandvalet 2004), so it is a little short.
//!
//! **Control.** The same code on the real side alone, whose parts are dealt to two halves: what 0.5 looks like here.
//!
//! **Limits.** What was split by blocks of one scan tells that scan from the other side, and with it the object and the
//! draw of its bench: two scans of one recipe are then apart too.

mod process;
mod windows;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};

use crate::process::train;
use crate::windows::{GUARD_PX, GapWindow, LIGHT_MAPS, WINDOW_SIDE_PX, by_part, evenly};
use dataset::Fault;

pub use crate::process::GapStop;
pub use crate::windows::{GapPart, GapSide};

/// Most folds.
const MOST_FOLDS: usize = 5;
/// Least windows of a side. With them the standard error of the accuracy of independent windows is 0.056 at 0.5.
const LEAST_WINDOWS: usize = 40;
/// Least windows of each half of the control.
const LEAST_CONTROL_WINDOWS: usize = 20;
/// Least parts of a side, and of each half of the control: one to train on and one to judge.
const LEAST_PARTS: usize = 2;
/// Pitches further apart than this are noted [1].
const PITCH_TOLERANCE: f64 = 0.01;
/// Seed of the order in which parts are dealt.
const DEAL_SEED: u64 = 0x0005_eed0_f6a9;

/// Accuracy of a classifier on windows that it has not seen.
#[derive(Debug, Clone, PartialEq)]
pub struct GapAccuracy {
    /// Mean of the shares of both sides that are taken for what they are [1].
    pub accuracy: f64,
    /// Ends of its 95 % interval [1].
    pub interval: [f64; 2],
    /// That share of the simulated and of the real side, or of the halves of the control [1].
    pub shares: [f64; 2],
    /// Windows of each.
    pub windows: usize,
    /// Scans or blocks of each.
    pub parts: [usize; 2],
    /// What parts are, of each.
    pub part: [GapPart; 2],
    /// Folds.
    pub folds: usize,
}

/// How far two sides are apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// Simulated from real.
    pub found: GapAccuracy,
    /// One half of the real side from the other; `None` where it has too few windows for that.
    pub control: Option<GapAccuracy>,
    /// Maps that the classifier sees.
    pub maps: Vec<&'static str>,
    /// What is good to know of this result.
    pub notes: Vec<String>,
    /// Version of torch, on which the last digits depend.
    pub torch: String,
}

/// Windows of two sides, ready to be learned from.
#[derive(Debug)]
pub struct GapJob<'w> {
    found: GapExperiment<'w>,
    control: Option<GapExperiment<'w>>,
    maps: Vec<&'static str>,
    notes: Vec<String>,
}

/// Two sides of as many windows, of which each part is dealt to a fold.
#[derive(Debug)]
struct GapExperiment<'w> {
    sides: [Vec<(&'w GapWindow, usize)>; 2],
    part: [GapPart; 2],
    folds: usize,
}

impl<'w> GapJob<'w> {
    /// Deals the windows of both sides, which are called `names`.
    ///
    /// # Errors
    /// Where there are too few windows, or too few parts of them.
    pub fn new(sim: &'w GapSide, real: &'w GapSide, names: [&Path; 2]) -> Result<Self, Fault> {
        let mut notes = Vec::new();
        let sides = [sim, real];
        for (side, path) in sides.into_iter().zip(names) {
            if side.windows.len() < LEAST_WINDOWS {
                let what = format!(
                    "it has {} windows of {WINDOW_SIDE_PX} x {WINDOW_SIDE_PX} px that are measured for at least one \
                        half, \
                     --gap needs {LEAST_WINDOWS}",
                    side.windows.len()
                );
                return Err(Fault::at(path, what, "give more or larger scans (--scans), or leave --gap away"));
            }
        }
        let most = sim.windows.len().min(real.windows.len());
        let chosen = sides.map(|side| evenly(side.windows.len(), most).map(|i| &side.windows[i]).collect::<Vec<_>>());
        let part = sides.map(GapSide::part);
        for i in 0..2 {
            let parts = by_part(&chosen[i], part[i]).len();
            // Forty windows are ten blocks, but may be of one scan.
            if parts < LEAST_PARTS {
                let what = format!("all of its windows are of {parts} {}, --gap needs {LEAST_PARTS}", part[i].name());
                let remedy = "give more scans in which the laser line is seen, or that one alone, or leave --gap away";
                return Err(Fault::at(names[i], what, remedy));
            }
            if part[i] == GapPart::Block {
                notes.push(format!(
                    "{}: of one scan --gap cannot tell what is of the instrument and what of this object; two scans \
                        or more \
                     are split by scan",
                    names[i].display()
                ));
            }
        }
        for (i, way) in ["along the line", "across profiles"].into_iter().enumerate() {
            if let [Some(a), Some(b)] = sides.map(|side| side.pitch_mm()[i])
                && (a - b).abs() > PITCH_TOLERANCE * a.max(b)
            {
                let what = "windows of as many pixels show pieces of other sizes, which alone can tell the sides apart";
                notes.push(format!("the pitch {way} is {a:.4} mm in SIM and {b:.4} mm in REAL: {what}"));
            }
        }
        let mut maps = vec!["range"];
        for (i, name) in LIGHT_MAPS.into_iter().enumerate() {
            match sides.map(|side| side.windows.iter().all(|window| window.light[i].is_some())) {
                [true, true] => maps.push(name),
                [false, false] => {}
                [is_in_sim, _] => {
                    let [lacking, having] = if is_in_sim { ["REAL", "SIM"] } else { ["SIM", "REAL"] };
                    notes.push(format!("--gap leaves {name} of {having} out, for not all of {lacking} has it"));
                }
            }
        }
        let control = control(real);
        if control.is_none() {
            let what = format!("two halves of {LEAST_CONTROL_WINDOWS} windows in {LEAST_PARTS} parts each");
            notes.push(format!("--gap has no control: REAL is too small for {what}"));
        }
        let found = GapExperiment::new(chosen, part);
        Ok(Self { found, control, maps, notes })
    }

    /// Networks that are to be trained.
    pub fn folds(&self) -> u64 {
        self.experiments().map(|experiment| experiment.folds as u64).sum()
    }

    /// Trains with the program `python`, calls `folds` with 1 after each network, and judges.
    ///
    /// # Errors
    /// Where Python or a package is missing, fails, or was stopped.
    pub fn run(self, python: &Path, stop: &GapStop, folds: &dyn Fn(u64)) -> Result<Gap, Fault> {
        let (mut numbers, mut experiments, mut counts, mut before) = (Vec::new(), Vec::new(), Vec::new(), 0);
        for experiment in self.experiments() {
            let windows =
                || experiment.sides.iter().enumerate().flat_map(|(label, side)| side.iter().map(move |w| (label, w)));
            let count = windows().count();
            experiments.push(json!({
                "window": (before..before + count).collect::<Vec<_>>(),
                "label": windows().map(|(label, _)| label).collect::<Vec<_>>(),
                "fold": windows().map(|(_, (_, fold))| fold).collect::<Vec<_>>(),
                "folds": experiment.folds,
            }));
            windows().for_each(|(_, (window, _))| self.append(window, &mut numbers));
            before += count;
            counts.push(count);
        }
        let channels: Vec<&str> = self.maps.iter().copied().chain(["mask"]).collect();
        let job = json!({ "side_px": WINDOW_SIDE_PX, "channels": channels, "experiments": experiments });
        let (scores, torch) = train(python, &job, &numbers, &counts, stop, folds)?;
        let judged: Vec<_> =
            self.experiments().zip(&scores).map(|(experiment, scores)| experiment.judge(scores)).collect();
        let mut judged = judged.into_iter();
        let Some(found) = judged.next() else {
            return Err(Fault::at(python, "it gave no answer", "run the same command again"));
        };
        Ok(Gap { found, control: judged.next(), maps: self.maps, notes: self.notes, torch })
    }

    fn experiments(&self) -> impl Iterator<Item = &GapExperiment<'w>> {
        [Some(&self.found), self.control.as_ref()].into_iter().flatten()
    }

    /// The numbers of a window as the script reads them; 0 where missing, as the mask tells.
    fn append(&self, window: &GapWindow, numbers: &mut Vec<f32>) {
        numbers.extend(window.range.iter().map(|z| if z.is_nan() { 0.0 } else { *z }));
        for (name, light) in LIGHT_MAPS.iter().zip(&window.light) {
            if self.maps.contains(name) {
                numbers.extend(light.iter().flatten());
            }
        }
        numbers.extend(window.range.iter().map(|z| f32::from(u8::from(!z.is_nan()))));
    }
}

/// Halves of the real side; `None` where they are too small.
fn control(real: &GapSide) -> Option<GapExperiment<'_>> {
    let part = real.control_part();
    let parts = by_part(&real.windows.iter().collect::<Vec<_>>(), part);
    let place = dealt(parts.keys().copied());
    let mut halves = [Vec::new(), Vec::new()];
    for (number, windows) in &parts {
        halves[place[number] % 2].extend(windows.iter().copied());
    }
    let most = halves[0].len().min(halves[1].len());
    let halves = halves.map(|half| evenly(half.len(), most).map(|i| half[i]).collect::<Vec<_>>());
    let is_enough =
        |half: &Vec<&GapWindow>| half.len() >= LEAST_CONTROL_WINDOWS && by_part(half, part).len() >= LEAST_PARTS;
    halves.iter().all(is_enough).then(|| GapExperiment::new(halves, [part; 2]))
}

/// Each of these numbers with its place in an order that depends on how many there are alone. Sides of as many scans
/// are dealt alike: scans of one object on both sides, or even the same ones, come into one fold.
fn dealt(numbers: impl Iterator<Item = usize>) -> BTreeMap<usize, usize> {
    let numbers: Vec<usize> = numbers.collect();
    let mut order: Vec<usize> = (0..numbers.len()).collect();
    order.sort_by_key(|&i| (mixed(DEAL_SEED ^ i as u64), i));
    order.iter().enumerate().map(|(place, &i)| (numbers[i], place)).collect()
}

/// A number that looks random (the finaliser of splitmix64).
fn mixed(number: u64) -> u64 {
    let mut z = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl<'w> GapExperiment<'w> {
    /// Deals the parts of two sides, which have at least two each, to as many folds as possible.
    fn new(sides: [Vec<&'w GapWindow>; 2], part: [GapPart; 2]) -> Self {
        let parts = [0, 1].map(|i| by_part(&sides[i], part[i]));
        let folds = parts.iter().map(BTreeMap::len).fold(MOST_FOLDS, usize::min);
        let sides = [0, 1].map(|i| {
            let place = dealt(parts[i].keys().copied());
            sides[i].iter().map(|&window| (window, place[&window.part(part[i])] % folds)).collect()
        });
        Self { sides, part, folds }
    }

    /// Judges the scores of its windows, of which more than 0.5 means the second side.
    fn judge(&self, scores: &[f64]) -> GapAccuracy {
        let (first, second) = scores.split_at(self.sides[0].len().min(scores.len()));
        let tallies = [0, 1].map(|i| {
            let mut parts: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
            for ((window, _), score) in self.sides[i].iter().zip([first, second][i]) {
                let [right, of] = parts.entry(window.part(self.part[i])).or_default();
                *of += 1.0;
                *right += f64::from(u8::from((*score > 0.5) == (i == 1)));
            }
            parts.into_values().collect::<Vec<_>>()
        });
        let [sim, real] = tallies.each_ref().map(|parts| share(parts));
        let accuracy = 0.5 * (sim.value + real.value);
        let variance = sim.variance + real.variance;
        let freedom = variance * variance / (sim.variance.powi(2) / sim.freedom + real.variance.powi(2) / real.freedom);
        let half = 0.5 * student_quantile(freedom) * variance.sqrt();
        GapAccuracy {
            accuracy,
            interval: [(accuracy - half).max(0.0), (accuracy + half).min(1.0)],
            shares: [sim.value, real.value],
            windows: self.sides[0].len(),
            parts: tallies.each_ref().map(Vec::len),
            part: self.part,
            folds: self.folds,
        }
    }
}

/// A share of right answers and how well it is known.
struct Share {
    value: f64,
    variance: f64,
    freedom: f64,
}

/// The share of parts with `[right, all]` answers each.
fn share(parts: &[[f64; 2]]) -> Share {
    let [right, n] = parts.iter().fold([0.0; 2], |[right, n], part| [right + part[0], n + part[1]]);
    let (value, m) = (right / n, parts.len() as f64);
    let between = m / (m - 1.0) * parts.iter().map(|[k, of]| (k - value * of).powi(2)).sum::<f64>() / (n * n);
    let smoothed = (right + 1.0) / (n + 2.0);
    Share { value, variance: between.max(smoothed * (1.0 - smoothed) / n), freedom: m - 1.0 }
}

/// 97.5 % quantile of Student's law with `freedom` degrees of freedom, at least 1. With t = sqrt(f) tan(a) its density
/// is proportional to cos(a)^(f-1), which Simpson's rule sums.
fn student_quantile(freedom: f64) -> f64 {
    const STEPS: usize = 4000;
    // Beyond it the law is the normal one to 0.1 %.
    let freedom = freedom.clamp(1.0, 2000.0);
    let step = std::f64::consts::FRAC_PI_2 / STEPS as f64;
    let density = |i: usize| libm::pow(libm::cos(i as f64 * step).max(0.0), freedom - 1.0);
    let pairs: Vec<f64> =
        (0..STEPS / 2).map(|pair| density(2 * pair) + 4.0 * density(2 * pair + 1) + density(2 * pair + 2)).collect();
    let wanted = 0.95 * pairs.iter().sum::<f64>();
    let mut sum = 0.0;
    for (pair, area) in pairs.iter().enumerate() {
        if sum + area >= wanted {
            let angle = (2.0 * pair as f64 + 2.0 * (wanted - sum) / area) * step;
            return freedom.sqrt() * libm::tan(angle);
        }
        sum += area;
    }
    f64::INFINITY
}

impl Gap {
    /// What was compared with what.
    fn rows(&self) -> impl Iterator<Item = (&'static str, &GapAccuracy)> {
        [("SIM from REAL", Some(&self.found)), ("halves of REAL", self.control.as_ref())]
            .into_iter()
            .filter_map(|(name, found)| found.map(|found| (name, found)))
    }

    /// The lines of the table.
    pub fn table(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:20}{:>10}{:>20}{:>14}{:>28}", "classifier", "accuracy", "95 %", "windows", "parts");
        for (name, found) in self.rows() {
            let [low, high] = found.interval.map(|end| format!("{end:.3}"));
            let windows = format!("2 x {}", found.windows);
            let parts = describe_parts(found);
            let ends = format!("{low} to {high}");
            let _ = writeln!(text, "{name:20}{:>10.3}{ends:>20}{windows:>14}{parts:>28}", found.accuracy);
        }
        text
    }

    /// The object of the document.
    pub fn json(&self) -> Value {
        let accuracy = |found: &GapAccuracy, sides: [&str; 2]| {
            let pair = |values: [Value; 2]| -> Value {
                sides.iter().map(|side| side.to_string()).zip(values).collect::<serde_json::Map<_, _>>().into()
            };
            let split = [0, 1].map(|i| json!({ "by": found.part[i].name(), "parts": found.parts[i] }));
            json!({
                "accuracy": found.accuracy,
                "low": found.interval[0],
                "high": found.interval[1],
                "right_share": pair(found.shares.map(|share| json!(share))),
                "windows_per_side": found.windows,
                "split": pair(split),
                "folds": found.folds,
            })
        };
        let mut found = accuracy(&self.found, ["sim", "real"]);
        found["control"] =
            self.control.as_ref().map_or(Value::Null, |control| accuracy(control, ["first_half", "second_half"]));
        found["maps"] = json!(self.maps);
        found["window_px"] = json!(WINDOW_SIDE_PX);
        found["guard_px"] = json!(GUARD_PX);
        found["torch"] = json!(self.torch);
        found["notes"] = json!(self.notes);
        found
    }
}

/// Parts of both sides in words.
fn describe_parts(found: &GapAccuracy) -> String {
    let [first, second] = found.part;
    let [a, b] = found.parts;
    if first == second {
        format!("{a} and {b} {}s", first.name())
    } else {
        format!("{a} {}s, {b} {}s", first.name(), second.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::windows::tests::scan;
    use tools::compare::ScanMaps;

    fn side(scans: usize, cols: usize, rows: usize) -> GapSide {
        let mut side = GapSide::new(scans);
        (0..scans).for_each(|_| side.add(&scan(cols, rows, |_, _| 0.0), None));
        side
    }

    fn job<'w>(sim: &'w GapSide, real: &'w GapSide) -> Result<GapJob<'w>, Fault> {
        GapJob::new(sim, real, [Path::new("sim"), Path::new("real")])
    }

    /// Tables of Student's law (Abramowitz and Stegun 26.10), and the normal one for many degrees of freedom.
    #[test]
    fn student_is_the_published_one() {
        for (freedom, quantile) in
            [(1.0, 12.706), (2.0, 4.303), (5.0, 2.571), (14.0, 2.145), (120.0, 1.980), (1e9, 1.961)]
        {
            let found = student_quantile(freedom);
            assert!((found / quantile - 1.0).abs() < 4e-4, "{found}, not {quantile}");
        }
        assert!(student_quantile(1.5) < student_quantile(1.0) && student_quantile(1.5) > student_quantile(2.0));
    }

    /// Parts of as many windows: the standard error is that of their mean, here sqrt(var / m) of 0.2, 0.4, 0.6, 0.8.
    #[test]
    fn parts_are_what_varies() {
        let found = share(&[[20.0, 100.0], [40.0, 100.0], [60.0, 100.0], [80.0, 100.0]]);
        assert!((found.value - 0.5).abs() < 1e-12 && (found.variance - 0.2 / 3.0 / 4.0).abs() < 1e-12);
        // Where all are right, what independent windows would leave open stays open.
        let all = share(&[[50.0, 50.0], [50.0, 50.0]]);
        assert!(all.value == 1.0 && (all.variance - 101.0 / 102.0 / 102.0 / 100.0).abs() < 1e-12, "{}", all.variance);
    }

    /// No part is in two folds, every fold has parts of both sides, and scans of the same number are dealt alike.
    #[test]
    fn folds_take_whole_parts() {
        let (sim, real) = (side(7, 128, 64), side(1, 400, 320));
        for experiment in job(&sim, &real).expect("there is enough").experiments() {
            for (i, side) in experiment.sides.iter().enumerate() {
                let mut fold_of: BTreeMap<usize, usize> = BTreeMap::new();
                for (window, fold) in side {
                    assert_eq!(fold_of.entry(window.part(experiment.part[i])).or_insert(*fold), fold);
                }
                let mut folds: Vec<usize> = fold_of.into_values().collect();
                folds.sort_unstable();
                folds.dedup();
                assert_eq!(folds, (0..experiment.folds).collect::<Vec<_>>());
            }
        }
        let twice = side(7, 128, 64);
        let same = job(&sim, &twice).expect("there is enough");
        let folds =
            same.found.sides.each_ref().map(|side| side.iter().map(|(w, fold)| (w.scan, *fold)).collect::<Vec<_>>());
        assert_eq!(folds[0], folds[1]);
    }

    /// A classifier that knows all is right, one that always says the same is at 0.5, and one that errs everywhere is
    /// at 0.
    #[test]
    fn scores_are_judged() {
        let (sim, real) = (side(4, 128, 96), side(5, 128, 96));
        let found = job(&sim, &real).expect("there is enough").found;
        let count = found.sides[0].len();
        assert_eq!((count, found.sides[1].len(), found.folds), (48, 48, 4));
        let judged = |sim: f64, real: f64| found.judge(&[vec![sim; count], vec![real; count]].concat());
        let right = judged(0.1, 0.9);
        assert!(
            right.accuracy == 1.0 && right.interval[1] == 1.0 && (0.9..1.0).contains(&right.interval[0]),
            "{right:?}"
        );
        let same = judged(0.7, 0.7);
        assert_eq!((same.accuracy, same.shares, same.parts), (0.5, [0.0, 1.0], [4, 5]));
        assert!(same.interval[0] < 0.5 && same.interval[1] > 0.5, "{same:?}");
        assert_eq!(judged(0.9, 0.1).accuracy, 0.0);
    }

    /// Too few windows or parts are refused with the number that is needed; what else is to be known is noted.
    #[test]
    fn small_sides_are_refused() {
        let enough = side(4, 128, 96);
        let refused = |few: &GapSide| job(&enough, few).map(|_| ()).expect_err("it is too small").to_string();
        let told = refused(&side(4, 64, 64));
        assert!(told.starts_with("real: it has 16 windows of 32 x 32 px") && told.contains("--gap needs 40"), "{told}");
        let mut lone = GapSide::new(4);
        (0..3).for_each(|_| lone.add(&scan(128, 96, |_, _| f64::NAN), None));
        lone.add(&scan(256, 256, |_, _| 0.0), None);
        let told = refused(&lone);
        assert!(told.contains("all of its windows are of 1 scan, --gap needs 2; give more scans"), "{told}");
        let mut dark = scan(400, 320, |_, _| 0.0);
        (dark.reflectance, dark.col_mm) = (None, Some(0.2));
        let mut other = GapSide::new(1);
        other.add(&dark, None);
        let mut pitched = enough.clone();
        pitched.add(&ScanMaps { col_mm: Some(0.1), ..scan(128, 96, |_, _| 0.0) }, None);
        let noted = job(&pitched, &other).expect("there is enough");
        for words in [
            "the pitch along the line is 0.1000 mm in SIM and 0.2000 mm in REAL",
            "reflectance of SIM out",
            "of one scan",
        ] {
            assert!(noted.notes.iter().any(|note| note.contains(words)), "{words}: {:?}", noted.notes);
        }
        assert_eq!((noted.maps.as_slice(), noted.control.is_some()), (["range"].as_slice(), true));
    }
}
