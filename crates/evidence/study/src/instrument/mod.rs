//! Studies of the instrument: frames and maps of the simulator, measured and compared with theory.
//!
//! - [`triangulation`]: Range on flat targets
//! - [`sensor`]: photon transfer, dark noise, rows that stand out
//! - [`speckle`]: contrast, law, correlation and movement of the pattern, and what it does to the line's centre
//! - [`laser`]: width of the line over height, evenness along it, electrons a column
//!
//! Each is done some independent times, with noise, fixed pattern and speckle drawn anew. A figure is the mean over
//! these repeats, its standard error comes from their spread, and Student's t tests whether it differs from theory; the
//! significance level is divided by the number of figures of the table (Bonferroni).

mod centroid;
mod closed_forms;
pub mod laser;
mod layout;
pub mod sensor;
mod significance;
pub mod speckle;
mod speckle_theory;
pub(crate) mod targets;
pub mod triangulation;

use rayon::prelude::*;
use serde_json::{Value, json};

use super::{StudyEvent, StudyProgress, document_head};
use transport::answer::Estimate;

/// Probability that any figure of a table is marked although all of them are right.
pub const ALPHA: f64 = 0.01;

/// Default number of repeats.
pub const REPEATS: u64 = 16;

/// How often a study is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Trials {
    /// Independent repeats, at least 2.
    pub repeats: u64,
    /// Seed of all chance.
    pub seed: u64,
}

/// A measured number beside the expected one.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name, with the unit.
    pub name: String,
    /// Mean over repeats and its standard error.
    pub measured: Estimate,
    /// Value of the theory.
    pub theory: f64,
    /// Probability of a difference at least as large if theory is right [1].
    pub p_value: f64,
}

impl Figure {
    /// A distance of Kolmogorov and Smirnov between `n` independent draws and a law.
    fn distance(name: impl Into<String>, distance: f64, n: usize) -> Self {
        let measured = Estimate::exact(distance);
        Self { name: name.into(), measured, theory: 0.0, p_value: significance::kolmogorov(distance, n as f64) }
    }

    /// Difference from theory in standard errors.
    fn z(&self) -> f64 {
        let off = self.measured.value - self.theory;
        if off == 0.0 { 0.0 } else { off / self.measured.error }
    }

    /// Whether the difference is insignificant in a table of `many` figures.
    pub fn holds(&self, many: usize) -> bool {
        self.p_value >= ALPHA / many as f64
    }
}

/// How many figures of a table hold.
fn holding(figures: &[Figure]) -> usize {
    figures.iter().filter(|figure| figure.holds(figures.len())).count()
}

/// The table for the terminal and the picture; `notes` are written below it.
fn table(title: &str, trials: Trials, figures: &[Figure], notes: &[&str]) -> String {
    let wide = figures.iter().map(|figure| figure.name.len()).max().unwrap_or(0);
    let mut text = format!("{title}: {} repeats, seed {}\n", trials.repeats, trials.seed);
    text += &format!("  {:wide$} {:>11} {:>11} {:>10} {:>6}\n", "", "measured", "theory", "std error", "z");
    for figure in figures {
        let Estimate { value, error } = figure.measured;
        // Two digits of the error.
        let digits = if error > 0.0 { (1.0 - libm::log10(error).floor()).clamp(0.0, 7.0) as usize } else { 4 };
        let mark = if figure.holds(figures.len()) { "" } else { "  OFF" };
        text += &if error > 0.0 {
            format!(
                "  {:wide$} {value:>11.digits$} {:>11.digits$} {error:>10.digits$} {:>6.1}{mark}\n",
                figure.name,
                figure.theory,
                figure.z()
            )
        } else {
            format!(
                "  {:wide$} {value:>11.digits$} {:>11} {:>10} {:>6}{mark}\n",
                figure.name,
                "",
                "",
                describe(figure.p_value)
            )
        };
    }
    text += &format!(
        "{} of {} figures hold at alpha = {ALPHA} for all of them together (Student's t, Bonferroni)\n",
        holding(figures),
        figures.len()
    );
    for note in notes {
        text += &format!("{note}\n");
    }
    text
}

/// A p-value in few letters.
fn describe(p_value: f64) -> String {
    if p_value < 5e-4 { "p<.001".into() } else { format!("p {p_value:.2}") }
}

/// The head of a study's document, and its figures.
fn document(study: &str, trials: Trials, figures: &[Figure]) -> Value {
    let each = |figure: &Figure| {
        json!({
            "name": figure.name, "measured": figure.measured, "theory": figure.theory,
            "chance": figure.p_value, "holds": figure.holds(figures.len()),
        })
    };
    let mut document = document_head(study);
    document["trials"] = json!({ "repeats": trials.repeats, "seed": trials.seed });
    document["alpha"] = json!(ALPHA);
    document["figures"] = figures.iter().map(each).collect();
    document
}

/// What each repeat of a study has measured.
struct Repeats<T>(Vec<T>);

impl<T: Send> Repeats<T> {
    /// Runs `one` for every repeat and reports each.
    fn run(trials: Trials, progress: StudyProgress, one: impl Fn(u64) -> T + Sync) -> Self {
        let done = |repeat| {
            let found = one(repeat);
            progress(StudyEvent::Done(1));
            found
        };
        Self((0..trials.repeats).into_par_iter().map(done).collect())
    }

    /// Mean and standard error of a number.
    fn estimate(&self, number: impl Fn(&T) -> f64) -> Estimate {
        Estimate::of(self.0.iter().map(&number))
    }

    /// A number beside its theory.
    fn figure(&self, name: impl Into<String>, number: impl Fn(&T) -> f64, theory: f64) -> Figure {
        let mut figure = Figure { name: name.into(), measured: self.estimate(number), theory, p_value: 1.0 };
        figure.p_value = significance::student(figure.z(), self.0.len() as f64 - 1.0);
        figure
    }
}

/// Mean and variance [unit, unit^2].
fn mean_and_variance(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    (mean, values.map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a thousand tables of right figures one in a hundred is called off; a figure that is five errors off always
    /// is.
    #[test]
    fn right_figures_hold_and_wrong_ones_do_not() {
        let mut rng = base::Stream::root(3).child("figures").rng();
        let mut draws = || Repeats((0..16).map(|_| base::normal(&mut rng)).collect::<Vec<f64>>());
        let off = (0..1000)
            .filter(|_| {
                let figures: Vec<_> = (0..10).map(|_| draws().figure("", |draw| *draw, 0.0)).collect();
                holding(&figures) < figures.len()
            })
            .count();
        // Binomial: 10 expected, standard deviation 3.1.
        assert!((1..24).contains(&off), "{off} of 1000 tables");
        let figures: Vec<_> = (0..10).map(|_| draws().figure("", |draw| *draw, 3.0)).collect();
        assert_eq!(holding(&figures), 0);
    }
}
