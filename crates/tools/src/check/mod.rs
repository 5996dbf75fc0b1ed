//! Evaluation of a trained model: any ONNX classifier or segmenter over a split, compared with the labels.
//!
//! ```text
//! Sidecar + tables -> EvaluationPlan -> BatchReader (decode, cut, normalise) -> Model -> predictions
//!     -> ClassificationMetrics, slices, misclassifications -> CheckReport
//! ```
//!
//! `accuracy`, `metrics`, `slices`, `sampling`, `window`, `prediction` and `evaluation_plan`
//! are plain functions of numbers. Only `model` and `onnxruntime` know onnxruntime, `external_data` knows the files
//! that a model names, and `split_samples` those of a dataset. docs/guide/check.md says what is measured.

mod accuracy;
mod batches;
mod evaluation_plan;
mod external_data;
mod metrics;
mod misclassified;
mod model;
mod onnxruntime;
mod prediction;
mod report;
mod run;
mod sampling;
mod sidecar;
mod slices;
mod split_samples;
mod trained_on;
mod window;

use std::path::{Path, PathBuf};

use output_schema::DatasetHead;

pub use report::CheckReport;
pub(crate) use report::short;
pub use run::{TriedModel, check, try_model};
pub use sidecar::Sidecar;

use dataset::Fault;
use optical_bench::split::Split;
use yaml::{YamlFaults, nearest_spelling};

/// What to check, and with what.
#[derive(Debug, Clone)]
pub struct CheckOptions {
    /// The dataset.
    pub dir: PathBuf,
    /// The ONNX file.
    pub model: PathBuf,
    /// The sidecar; `None` for the file of the model's name beside it that ends in one of `sidecar::ENDINGS`.
    pub sidecar: Option<PathBuf>,
    /// One split; `None` for all.
    pub split: Option<Split>,
    /// Numbers to slice by; empty for those of `DEFAULT_SLICES` that the dataset varies.
    pub slices: Vec<String>,
    /// Windows in a batch; `None` for as many as fit `DEFAULT_BATCH_BYTES`, at most `MAX_DEFAULT_BATCH`.
    pub batch: Option<usize>,
    /// Threads of the model, and as many for reading.
    pub threads: usize,
    /// Seed of drawn pixels.
    pub seed: u64,
    /// How many of the worst answers are kept.
    pub worst: usize,
    /// Whether pictures of them are drawn.
    pub pictures: bool,
}

/// Whether a sample lacks something, by the values of the numbers that say so; `None` for one that the dataset does not
/// have.
pub type IsLacking = Box<dyn Fn(&[Option<f64>]) -> bool>;

/// What a drawn number describes, where some samples lack it: the width of knots says nothing of a board without knots.
pub struct SampleTest {
    /// Paths of the drawn numbers that say whether a sample has it.
    pub deciders: Vec<&'static str>,
    /// Whether a sample lacks it, by their values.
    pub is_lacking: IsLacking,
}

/// Says what the number at a path describes; `None` where no sample lacks it.
pub type SampleTests<'a> = &'a dyn Fn(&DatasetHead, &str) -> Option<SampleTest>;

/// Default slices: knot width, film pigment, exposure time.
pub(crate) const DEFAULT_SLICES: [&str; 3] = ["knots.width_mm", "film.sigma_per_mm", "exposure.time_us"];
/// Most windows in a batch by default.
pub(crate) const MAX_DEFAULT_BATCH: usize = 64;
/// Size of a batch's input by default [bytes].
pub(crate) const DEFAULT_BATCH_BYTES: usize = 64 << 20;

/// Why a check cannot be done.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// The sidecar has faults.
    #[error(transparent)]
    Sidecar(#[from] YamlFaults),
    /// A file or folder is not as it should be.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// The samples show nothing of the model's classes.
    #[error(transparent)]
    Nothing(Fault),
    /// onnxruntime is not there.
    #[error("{0}")]
    Library(String),
    /// An argument fits nothing in the dataset or the model.
    #[error("{0}")]
    Argument(String),
}

impl CheckError {
    fn at(place: &Path, what: String, remedy: &str) -> Self {
        Fault::at(place, what, remedy.to_owned()).into()
    }

    fn nothing(place: &Path, what: String, remedy: &str) -> Self {
        Self::Nothing(Fault::at(place, what, remedy.to_owned()))
    }
}

/// Paths of the numbers to slice by, as tables have them.
fn slice_paths(asked: &[String], head: &DatasetHead) -> Result<Vec<String>, CheckError> {
    let drawn = head.parameters.iter().map(|number| number.path());
    let derived = head.physics.iter().map(|number| format!("physics.{}", number.path()));
    let known: Vec<String> = drawn.chain(derived).collect();
    if asked.is_empty() {
        return Ok(DEFAULT_SLICES.map(String::from).into_iter().filter(|path| known.contains(path)).collect());
    }
    let find = |path: &String| {
        let found = known.iter().find(|known| *known == path || known.strip_prefix("physics.") == Some(path));
        found.cloned().ok_or_else(|| {
            let meant = nearest_spelling(path, known.iter().map(String::as_str));
            let meant = meant.map_or(String::new(), |meant| format!("did you mean `{meant}`? "));
            let remedy = "drawn numbers are group.key, derived ones physics.key; output_schema/README.md and \
                dataset.json list them";
            CheckError::Argument(format!("--slice {path}: the dataset has no such number; {meant}{remedy}"))
        })
    };
    asked.iter().map(find).collect()
}
