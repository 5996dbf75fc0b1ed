//! Balance: statistics of a dataset against its recipe: classes, splits, and every drawn number.
//!
//! | what | how it is drawn | test |
//! |---|---|---|
//! | classes | a rotation by index | the counts are exactly those of the rotation over the same indices; over all indices below n none is farther from its share of n than 2 + log_phi(n) |
//! | splits | by rank within each class | the counts in each class are exactly those of the ranks of the same indices; over all indices below n none is two samples or more from its share of its class |
//! | numbers of a continuous law | each sample by itself | Kolmogorov and Smirnov |
//! | numbers of a discrete law | each sample by itself | exact binomial for two, likelihood-ratio chi-square for more |
//! | numbers that never vary | | equal |
//!
//! Where samples in a row are one group (boards of one log), classes and splits are those of groups, with the bounds of as many
//! samples for each; of a number that is drawn for a group the first sample counts.
//!
//! Classes that draw a number alike are tested together. All chances are adjusted by Holm's rule, so that [`ALPHA`] bounds
//! the chance that a dataset drawn as declared has any fault of these kinds.

use serde::Serialize;

use super::finding::{Code, Finding};
use super::sample_counts::{DeclaredLaws, LawCounts, SampleCounts, classes_of};
use numerics::chance::{DrawLaw, binomial, holm, kolmogorov_smirnov, likelihood_ratio, likelihood_ratio_chance};

/// Chance that a dataset which was drawn as declared is faulted for any of its statistics.
pub const ALPHA: f64 = 1e-6;
/// A split is nearer to its share of the samples of a class, in every prefix of them: two sequences by rank, each within one
/// sample of its share (Beatty 1926), one counted in what the other leaves.
const SPLIT_BOUND: f64 = 2.0;
/// Where faults of statistics lie: in no single file.
const PLACE: &str = "data/*.parquet";

/// Samples of one class.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClassCount {
    /// Its name.
    pub class: String,
    /// Its share [1].
    pub share: f64,
    /// Rows that say it.
    pub samples: u64,
    /// Rows whose index the recipe gives to it.
    pub drawn: u64,
}

/// Samples of one class in one split.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SplitCount {
    /// The split.
    pub split: String,
    /// The class.
    pub class: String,
    /// Share of the class that the split has [1].
    pub share: f64,
    /// Rows that say both.
    pub samples: u64,
    /// Rows whose index the recipe gives to both.
    pub drawn: u64,
}

/// One test.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BalanceTest {
    /// The number.
    pub of: String,
    /// The classes that it is about; empty for all.
    pub classes: Vec<String>,
    /// `binomial`, `kolmogorov-smirnov`, `chi-square` or `fixed`.
    pub test: &'static str,
    /// Samples.
    pub samples: u64,
    /// A count, the largest distance of the distribution functions, G, or the samples that differ.
    pub statistic: f64,
    /// Samples with a number that is never drawn.
    pub impossible: u64,
    /// Upper bound of the chance of such a statistic or a more extreme one.
    pub p: f64,
    /// The same, adjusted for the number of tests.
    pub adjusted_p: f64,
}

/// Statistics of a dataset.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BalanceStatistics {
    /// Chance of a false alarm for the whole dataset.
    pub alpha: f64,
    /// Rows that were counted.
    pub samples: u64,
    /// By class.
    pub classes: Vec<ClassCount>,
    /// Farthest that a class may be from its share of the samples; null where samples are missing.
    pub class_bound: Option<f64>,
    /// By class, then by split.
    pub splits: Vec<SplitCount>,
    /// How near a split is to its share of each class; null where samples are missing.
    pub split_bound: Option<f64>,
    /// Drawn numbers.
    pub tests: Vec<BalanceTest>,
}

/// The statistics of what was counted, and what is wrong with them; `samples` is how many the dataset should have.
pub(super) fn judge(tally: &SampleCounts, samples: u64) -> (BalanceStatistics, Vec<Finding>) {
    let declared = tally.declared;
    let mut faults = Vec::new();
    // Groups follow the bounds of samples, and the samples of the last one may be missing.
    let group = declared.group as f64;
    let of_samples = |of_groups: f64| group * of_groups + group - 1.0;
    let class_bound =
        (tally.samples == samples && samples > 0).then(|| of_samples(discrepancy(samples.div_ceil(declared.group))));
    let classes = classes(tally, class_bound, &mut faults);
    let split_bound = class_bound.map(|_| of_samples(SPLIT_BOUND));
    let splits = splits(tally, split_bound, &mut faults);
    let (mut tests, mut firsts) = (Vec::new(), Vec::new());
    for (parameter, tallies) in declared.parameters.iter().zip(&tally.parameters) {
        for (place, (law, numbers)) in parameter.laws.iter().zip(tallies).enumerate() {
            if numbers.samples > 0 {
                let (test, statistic, p) = test(law, numbers);
                tests.push(BalanceTest {
                    of: parameter.path.clone(),
                    classes: classes_of(declared, parameter, place),
                    test,
                    samples: numbers.samples,
                    statistic,
                    impossible: numbers.impossible,
                    p,
                    adjusted_p: p,
                });
                firsts.push(numbers.first);
            }
        }
    }
    let adjusted = holm(&tests.iter().map(|test| test.p).collect::<Vec<_>>());
    for ((test, adjusted), first) in tests.iter_mut().zip(adjusted).zip(firsts) {
        test.adjusted_p = adjusted;
        if adjusted < ALPHA {
            faults.push(fault(test, first));
        }
    }
    let samples = tally.samples;
    (BalanceStatistics { alpha: ALPHA, samples, classes, class_bound, splits, split_bound, tests }, faults)
}

/// By Denjoy and Koksma, how far the golden-ratio rotation is from any share of its first `n` steps at most.
fn discrepancy(n: u64) -> f64 {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    2.0 + libm::log(n as f64) / libm::log(golden)
}

fn classes(tally: &SampleCounts, bound: Option<f64>, faults: &mut Vec<Finding>) -> Vec<ClassCount> {
    let counted = tally.declared.classes.iter().zip(&tally.classes);
    let classes: Vec<ClassCount> = counted
        .map(|((class, share), &[samples, drawn])| ClassCount { class: class.clone(), share: *share, samples, drawn })
        .collect();
    let expected = |class: &ClassCount| class.share * tally.samples as f64;
    for class in &classes {
        let ClassCount { class: name, share, samples, drawn } = class;
        let far = bound.is_some_and(|bound| (*samples as f64 - expected(class)).abs() > bound);
        if samples != drawn || far {
            let share = format!("a share of {share} is {:.1} of {}", expected(class), tally.samples);
            let what = format!("{samples} samples are of class {name}, the recipe gives it {drawn}; {share}");
            faults.push(Finding::new(Code::ClassBalance, PLACE, what));
        }
    }
    classes
}

/// Each split within each class.
fn splits(tally: &SampleCounts, bound: Option<f64>, faults: &mut Vec<Finding>) -> Vec<SplitCount> {
    let declared: &DeclaredLaws = tally.declared;
    let mut all = Vec::new();
    for (((class, _), &[of_class, _]), counts) in declared.classes.iter().zip(&tally.classes).zip(&tally.splits) {
        for ((split, share), &[samples, drawn]) in declared.splits.iter().zip(counts) {
            let expected = share * of_class as f64;
            let far = bound.is_some_and(|bound| (samples as f64 - expected).abs() >= bound);
            if samples != drawn || far {
                let share = format!("a share of {share} is {expected:.1} of {of_class}");
                let what = format!(
                    "{samples} samples of class {class} are in {split}, the recipe puts {drawn} there; {share}"
                );
                faults.push(Finding::new(Code::SplitBalance, PLACE, what));
            }
            let (split, class) = (split.clone(), class.clone());
            all.push(SplitCount { split, class, share: *share, samples, drawn });
        }
    }
    all
}

/// Name, statistic and chance; a number that is never drawn has no chance at all.
fn test(law: &DrawLaw, numbers: &LawCounts) -> (&'static str, f64, f64) {
    let (name, statistic, p) = match law {
        DrawLaw::Fixed(_) => ("fixed", numbers.impossible as f64, 1.0),
        DrawLaw::Discrete(cells) => {
            let chances: Vec<f64> = cells.iter().map(|cell| cell.1).collect();
            let n: u64 = numbers.cells.iter().sum();
            match (numbers.cells.as_slice(), chances.as_slice()) {
                (&[first, _], &[share, _]) => ("binomial", first as f64, binomial(n, first, share)),
                (counts, chances) => {
                    let statistic = likelihood_ratio(counts, chances);
                    ("chi-square", statistic, likelihood_ratio_chance(statistic, chances.len()))
                }
            }
        }
        DrawLaw::Continuous { .. } => {
            let (samples, distance) = numbers.grid.as_ref().map_or((0, 0.0), |grid| (grid.samples(), grid.distance()));
            ("kolmogorov-smirnov", distance, kolmogorov_smirnov(samples, distance))
        }
    };
    (name, statistic, if numbers.impossible > 0 { 0.0 } else { p })
}

fn fault(test: &BalanceTest, first: Option<(u64, f64)>) -> Finding {
    let BalanceTest { of, classes, test: name, samples, statistic, p, adjusted_p, .. } = test;
    let within = if classes.is_empty() { String::new() } else { format!(" in {}", classes.join(", ")) };
    let chance = format!("chance {p:.1e}, {adjusted_p:.1e} among all tests");
    let what = match first {
        Some((index, value)) => {
            let others = test.impossible - 1;
            let more = if others > 0 { format!("; {others} samples more") } else { String::new() };
            format!("sample {index} has {value}, which the recipe never draws{within}{more}")
        }
        None => format!("{name} {statistic:.4} of {samples} samples{within}; {chance}"),
    };
    Finding::new(Code::DistributionDiffers, format!("{PLACE}, {of}"), what)
}
