//! Report of a check: a table for people and JSON for programs.

use std::fmt::Write;

use output_schema::DatasetHead;
use serde::Serialize;
use serde_json::{Value, json};

use super::CheckOptions;
use super::accuracy::Accuracy;
use super::metrics::{CONFIDENCE_BINS, CalibrationBin, ClassificationMetrics};
use super::misclassified::Misclassification;
use super::sidecar::{ModelTask, Sidecar};
use super::slices::SliceGroup;

/// Value of `format` in the document.
const DOCUMENT_FORMAT: &str = "sheetlight-check";
/// Version of the document's layout.
const SCHEMA_VERSION: u32 = 1;
/// Wrong answers that the table lists.
const MAX_LISTED_ERRORS: usize = 5;
/// Longest name of a class in the table [letters].
const MAX_NAME_LETTERS: usize = 18;

/// Accuracy by one number.
#[derive(Debug, Clone, PartialEq)]
pub struct AccuracySlice {
    /// Path of the number.
    pub path: String,
    /// Its groups, by number.
    pub groups: Vec<SliceGroup>,
}

/// How long it took.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CheckTiming {
    /// All of it but loading the model [s].
    pub seconds: f64,
    /// Within the model [s].
    pub model_seconds: f64,
    /// Windows in a batch.
    pub batch: usize,
}

/// What a check found.
#[derive(Debug, Clone)]
pub struct CheckReport {
    /// Options of the check.
    pub options: CheckOptions,
    /// The dataset.
    pub head: DatasetHead,
    /// Description of the model.
    pub sidecar: Sidecar,
    /// SHA-256 of the model with its external weights, hexadecimal.
    pub model_sha256: String,
    /// SHA-256 of the sidecar, hexadecimal.
    pub sidecar_sha256: String,
    /// Samples with at least one window.
    pub samples: u64,
    /// Samples, objects or pixels that were not, for want of a class or because there were enough.
    pub left_out: u64,
    /// Shards that are not finished.
    pub unfinished: u64,
    /// Right guesses.
    pub share: Accuracy,
    /// Number of each sample, with its right guesses and its guesses.
    pub answers: Vec<(u64, [u64; 2])>,
    /// Every count.
    pub metrics: ClassificationMetrics,
    /// Accuracy by numbers.
    pub slices: Vec<AccuracySlice>,
    /// The most confidently wrong answers.
    pub worst: Vec<Misclassification>,
    /// How long it took.
    pub timing: CheckTiming,
}

impl CheckReport {
    /// Share of right guesses [1].
    pub fn accuracy(&self) -> f64 {
        self.share.value().unwrap_or(0.0)
    }

    /// What is counted: patches, or pixels.
    fn counted(&self) -> &'static str {
        if self.sidecar.task == ModelTask::Segment { "pixels" } else { self.sidecar.task.units() }
    }

    /// Name of the split, or `all`.
    pub fn split(&self) -> &'static str {
        self.options.split.map_or("all", |split| split.name())
    }

    /// The document; `pictures` are the names of the files of the worst answers.
    pub fn json(&self, pictures: &[String]) -> Value {
        let share = |share: &Accuracy| {
            json!({
                "accuracy": share.value(), "low": share.interval()[0], "high": share.interval()[1],
                "right": share.right, "of": share.of, "samples": share.samples, "effective": share.effective(),
            })
        };
        let names = self.sidecar.classes.iter();
        let classes = names.zip(self.metrics.classes()).map(|(name, class)| {
            json!({
                "name": name, "support": class.support, "guessed": class.guessed, "precision": class.precision,
                "recall": class.recall, "f1": class.f1, "iou": class.iou,
            })
        });
        let bins = self.metrics.bins().iter().enumerate().map(|(i, bin)| {
            let mean = |sum: f64| (bin.count > 0).then(|| sum / bin.count as f64);
            json!({
                "low": i as f64 / CONFIDENCE_BINS as f64, "high": (i + 1) as f64 / CONFIDENCE_BINS as f64,
                "count": bin.count, "confidence": mean(bin.confidence), "accuracy": mean(bin.right as f64),
            })
        });
        let group = |group: &SliceGroup| {
            let mut value = share(&group.share);
            value["from"] = json!(group.span.map(|span| span[0]));
            value["to"] = json!(group.span.map(|span| span[1]));
            value
        };
        let slices = self
            .slices
            .iter()
            .map(|slice| json!({ "column": slice.path, "groups": slice.groups.iter().map(group).collect::<Vec<_>>() }));
        let worst = self.worst.iter().enumerate().map(|(i, wrong)| {
            json!({
                "index": wrong.index, "id": wrong.id, "first": wrong.window.first, "size": wrong.window.size,
                "truth": self.sidecar.classes[wrong.truth], "guess": self.sidecar.classes[wrong.guess],
                "confidence": wrong.confidence, "picture": pictures.get(i),
            })
        });
        let head = &self.head;
        json!({
            "format": DOCUMENT_FORMAT,
            "schema_version": SCHEMA_VERSION,
            "model": { "path": self.options.model.display().to_string(), "sha256": self.model_sha256,
                "sidecar_sha256": self.sidecar_sha256 },
            "dataset": {
                "path": self.options.dir.display().to_string(), "recipe": head.recipe.name,
                "recipe_hash": head.recipe.hash, "seed": head.seed, "subject": head.subject,
                "unfinished_shards": self.unfinished,
            },
            "split": self.split(),
            "task": self.sidecar.task.name(),
            "seed": self.options.seed,
            "counted": self.counted(),
            "samples": self.samples,
            "left_out": self.left_out,
            "accuracy": share(&self.share),
            "balanced_accuracy": self.metrics.balanced_accuracy(),
            "mean_iou": self.metrics.mean_iou(),
            "classes": classes.collect::<Vec<_>>(),
            "confusion": self.metrics.confusion(),
            "calibration": { "error": self.metrics.calibration_error(), "bins": bins.collect::<Vec<_>>() },
            "slices": slices.collect::<Vec<_>>(),
            "worst": worst.collect::<Vec<_>>(),
            "timing": self.timing,
        })
    }

    /// The tables.
    pub fn table(&self) -> String {
        let tables = [self.summary(), self.class_table(), self.confusion_table(), self.calibration_table()];
        let slices = self.slices.iter().map(|slice| self.slice_table(slice));
        let tables = tables.into_iter().chain(slices).chain([self.worst_lines()]).filter(|lines| !lines.is_empty());
        let text = |lines: Vec<String>| lines.iter().map(|line| format!("{}\n", line.trim_end())).collect::<String>();
        tables.map(text).collect::<Vec<_>>().join("\n")
    }

    /// What was asked of which model, and the figures over all.
    fn summary(&self) -> Vec<String> {
        let (model, dir, split) = (self.options.model.display(), self.options.dir.display(), self.split());
        let counted = self.counted();
        let mut lines =
            vec![format!("{model} on {dir}, split {split}: {} {counted} of {} samples", self.share.of, self.samples)];
        if self.left_out > 0 {
            lines.push(format!("left out, of no class of the model or more than enough: {}", self.left_out));
        }
        let [low, high] = self.share.interval();
        let effective = self.share.effective();
        lines.push(format!(
            "accuracy {:.4} (95 %: {low:.4} to {high:.4}, as sure as {effective:.0} independent {counted})",
            self.accuracy()
        ));
        let [recall, error] = [self.metrics.balanced_accuracy(), self.metrics.calibration_error()].map(four);
        lines.push(format!("mean recall {recall}, calibration error {error}"));
        if self.sidecar.task == ModelTask::Segment {
            lines.push(format!("mean intersection over union {}", four(self.metrics.mean_iou())));
        }
        lines
    }

    /// Counts and shares of each class.
    fn class_table(&self) -> Vec<String> {
        let mut lines = vec![format!(
            "{:MAX_NAME_LETTERS$} {:>10} {:>10} {:>9} {:>9} {:>9} {:>9}",
            "class", "true", "guessed", "precision", "recall", "F1", "IoU"
        )];
        for (class, figures) in self.sidecar.classes.iter().zip(self.metrics.classes()) {
            let [precision, recall, f1, iou] = [figures.precision, figures.recall, figures.f1, figures.iou].map(four);
            let counts = format!("{:>10} {:>10}", figures.support, figures.guessed);
            lines.push(format!(
                "{:MAX_NAME_LETTERS$} {counts} {precision:>9} {recall:>9} {f1:>9} {iou:>9}",
                clipped(class)
            ));
        }
        lines
    }

    /// How often each class was taken for each.
    fn confusion_table(&self) -> Vec<String> {
        let mut header = format!("{:MAX_NAME_LETTERS$}", "");
        // Writing to a string cannot fail.
        self.sidecar.classes.iter().for_each(|class| _ = write!(header, " {:>10.10}", class));
        let mut lines = vec!["rows are the truth, columns the guesses".into(), header];
        for (class, counts) in self.sidecar.classes.iter().zip(self.metrics.confusion()) {
            let mut row = format!("{:MAX_NAME_LETTERS$}", clipped(class));
            counts.iter().for_each(|count| _ = write!(row, " {count:>10}"));
            lines.push(row);
        }
        lines
    }

    /// Accuracy of answers by their confidence.
    fn calibration_table(&self) -> Vec<String> {
        let header = format!("{:MAX_NAME_LETTERS$} {:>10} {:>10} {:>10}", "confidence", "count", "mean", "accuracy");
        let bins = self.metrics.bins().iter().enumerate().filter(|(_, bin)| bin.count > 0);
        let line = |(i, bin): (usize, &CalibrationBin)| {
            let [low, high] = [i, i + 1].map(|end| end as f64 / CONFIDENCE_BINS as f64);
            let (span, n) = (format!("{low:.1} to {high:.1}"), bin.count as f64);
            let [mean, accuracy] = [bin.confidence / n, bin.right as f64 / n];
            format!("{span:MAX_NAME_LETTERS$} {:>10} {mean:>10.4} {accuracy:>10.4}", bin.count)
        };
        std::iter::once(header).chain(bins.map(line)).collect()
    }

    /// Accuracy by a number.
    fn slice_table(&self, slice: &AccuracySlice) -> Vec<String> {
        let header = format!("{:28} {:>8} {:>10} {:>10}  95 %", slice.path, "samples", self.counted(), "accuracy");
        let line = |SliceGroup { span, share }: &SliceGroup| {
            let span = span.map_or("none".into(), |[from, to]| format!("{} to {}", short(from), short(to)));
            let [low, high] = share.interval();
            let accuracy = four(share.value());
            format!("{span:28} {:>8} {:>10} {accuracy:>10}  {low:.4} to {high:.4}", share.samples, share.of)
        };
        std::iter::once(header).chain(slice.groups.iter().map(line)).collect()
    }

    /// The most confidently wrong answers; nothing where none is wrong.
    fn worst_lines(&self) -> Vec<String> {
        let line = |wrong: &Misclassification| {
            let [truth, guess] = [wrong.truth, wrong.guess].map(|class| &self.sidecar.classes[class]);
            let ([row, col], index) = (wrong.window.first, wrong.index);
            let confidence = wrong.confidence;
            format!("  sample {index}, row {row}, column {col}: {truth} taken for {guess}, {confidence:.4}")
        };
        let header = (!self.worst.is_empty()).then(|| "most confidently wrong".into());
        header.into_iter().chain(self.worst.iter().take(MAX_LISTED_ERRORS).map(line)).collect()
    }
}

/// A share with four decimals; a dash for none.
fn four(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:.4}"))
}

/// The begin of a name, as wide as its column.
fn clipped(name: &str) -> String {
    name.chars().take(MAX_NAME_LETTERS).collect()
}

/// A number with four digits.
pub(crate) fn short(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let digits = (3 - libm::log10(value.abs().max(1e-3)).floor() as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}
