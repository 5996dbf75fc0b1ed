//! Report of a check: a table for people and JSON for programs.

use std::fmt::Write;

use output_schema::DatasetHead;
use serde_json::{Value, json};

use super::CheckOptions;
use super::accuracy::Accuracy;
use super::metrics::{CONFIDENCE_BINS, ClassificationMetrics};
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
#[derive(Debug, Clone, Copy, PartialEq)]
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
                "accuracy": share.value(), "low": share.interval()[0], "high": share.interval()[1], "right": share.right,
                "of": share.of, "samples": share.samples, "effective": share.effective(),
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
                "low": i as f64 / CONFIDENCE_BINS as f64, "high": (i + 1) as f64 / CONFIDENCE_BINS as f64, "count": bin.count,
                "confidence": mean(bin.confidence), "accuracy": mean(bin.right as f64),
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
            "model": { "path": self.options.model.display().to_string(), "sha256": self.model_sha256, "sidecar_sha256": self.sidecar_sha256 },
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
            "timing": {
                "seconds": self.timing.seconds, "model_seconds": self.timing.model_seconds, "batch": self.timing.batch,
            },
        })
    }

    /// The tables.
    pub fn table(&self) -> String {
        let mut text = String::new();
        let mut line = |words: String| {
            text.push_str(words.trim_end());
            text.push('\n');
        };
        let samples = format!("{} {} of {} samples", self.share.of, self.counted(), self.samples);
        line(format!(
            "{} on {}, split {}: {samples}",
            self.options.model.display(),
            self.options.dir.display(),
            self.split()
        ));
        if self.left_out > 0 {
            line(format!("left out, of no class of the model or more than enough: {}", self.left_out));
        }
        let [low, high] = self.share.interval();
        line(format!(
            "accuracy {:.4} (95 %: {low:.4} to {high:.4}, as sure as {:.0} independent {})",
            self.accuracy(),
            self.share.effective(),
            self.counted()
        ));
        let number = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.4}"));
        line(format!(
            "mean recall {}, calibration error {}",
            number(self.metrics.balanced_accuracy()),
            number(self.metrics.calibration_error())
        ));
        if self.sidecar.task == ModelTask::Segment {
            line(format!("mean intersection over union {}", number(self.metrics.mean_iou())));
        }
        line(String::new());
        let name = |name: &str| name.chars().take(MAX_NAME_LETTERS).collect::<String>();
        line(format!(
            "{:MAX_NAME_LETTERS$} {:>10} {:>10} {:>9} {:>9} {:>9} {:>9}",
            "class", "true", "guessed", "precision", "recall", "F1", "IoU"
        ));
        for (class, figures) in self.sidecar.classes.iter().zip(self.metrics.classes()) {
            let shares = [figures.precision, figures.recall, figures.f1, figures.iou].map(number);
            let [precision, recall, f1, iou] = shares;
            let counts = format!("{:>10} {:>10}", figures.support, figures.guessed);
            line(format!("{:MAX_NAME_LETTERS$} {counts} {precision:>9} {recall:>9} {f1:>9} {iou:>9}", name(class)));
        }
        line(String::new());
        line("rows are the truth, columns the guesses".into());
        let mut header = format!("{:MAX_NAME_LETTERS$}", "");
        // Writing to a string cannot fail.
        self.sidecar.classes.iter().for_each(|class| _ = write!(header, " {:>10.10}", class));
        line(header);
        for (class, counts) in self.sidecar.classes.iter().zip(self.metrics.confusion()) {
            let mut row = format!("{:MAX_NAME_LETTERS$}", name(class));
            counts.iter().for_each(|count| _ = write!(row, " {count:>10}"));
            line(row);
        }
        line(String::new());
        line(format!("{:MAX_NAME_LETTERS$} {:>10} {:>10} {:>10}", "confidence", "count", "mean", "accuracy"));
        for (i, bin) in self.metrics.bins().iter().enumerate().filter(|(_, bin)| bin.count > 0) {
            let span =
                format!("{:.1} to {:.1}", i as f64 / CONFIDENCE_BINS as f64, (i + 1) as f64 / CONFIDENCE_BINS as f64);
            let n = bin.count as f64;
            line(format!(
                "{span:MAX_NAME_LETTERS$} {:>10} {:>10.4} {:>10.4}",
                bin.count,
                bin.confidence / n,
                bin.right as f64 / n
            ));
        }
        for slice in &self.slices {
            line(String::new());
            line(format!("{:28} {:>8} {:>10} {:>10}  95 %", slice.path, "samples", self.counted(), "accuracy"));
            for SliceGroup { span, share } in &slice.groups {
                let span = span.map_or("none".into(), |[from, to]| format!("{} to {}", short(from), short(to)));
                let [low, high] = share.interval();
                let accuracy = number(share.value());
                line(format!("{span:28} {:>8} {:>10} {accuracy:>10}  {low:.4} to {high:.4}", share.samples, share.of));
            }
        }
        if !self.worst.is_empty() {
            line(String::new());
            line("most confidently wrong".into());
        }
        for wrong in self.worst.iter().take(MAX_LISTED_ERRORS) {
            let [truth, guess] = [wrong.truth, wrong.guess].map(|class| &self.sidecar.classes[class]);
            let [row, col] = wrong.window.first;
            line(format!(
                "  sample {}, row {row}, column {col}: {truth} taken for {guess}, {:.4}",
                wrong.index, wrong.confidence
            ));
        }
        text
    }
}

/// A number with four digits.
fn short(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let digits = (3 - libm::log10(value.abs().max(1e-3)).floor() as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}
