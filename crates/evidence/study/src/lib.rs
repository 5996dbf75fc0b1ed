//! Studies: models of transport side by side and the instrument against theory, as tables, JSON and pictures.
//!
//! - [`point`]: point spread on wood, ellipses of equal light
//! - [`lines`]: line spread of fifteen media
//! - [`profile`]: Scatter along one profile of a recipe's sample
//! - [`instrument`]: triangulation, sensor, speckle, laser
//! - [`packs`]: Range and Scatter of blister packs, one of each defect
//!
//! A study of light inside matter asks [`Model::ALL`], that of a point [`compared_model::ComparedModel::all`]; a model
//! that refuses a question is listed with its reason.

pub mod compared_model;
mod ellipse;
pub mod instrument;
pub mod lines;
pub mod packs;
pub mod point;
mod poisson_fit;
pub mod profile;

use image::RgbImage;
use serde_json::{Value, json};

use crate::instrument::Figure;
use reference::model::Model;
use reference::path::Effort;
use transport::answer::{Answer, Estimate, Question};
use transport::stack::Stack;

/// Result of a study.
#[derive(Debug, Clone)]
pub struct StudyReport {
    /// A table for the terminal.
    pub table: String,
    /// All numbers, with standard errors.
    pub json: Value,
    /// Charts and maps of the numbers.
    pub picture: RgbImage,
    /// Measured numbers beside theory, of studies of the instrument: what its tests hold.
    pub figures: Vec<Figure>,
}

/// What a study reports while it runs.
#[derive(Debug, Clone, Copy)]
pub enum StudyEvent<'a> {
    /// A model is asked about something.
    Asks(&'a str),
    /// So many photons or repeats more are done.
    Done(u64),
}

/// Receives the events of a study.
pub type StudyProgress<'a> = &'a (dyn Fn(StudyEvent) + Sync);

/// Asks a model, and reports how far it is.
fn ask(
    model: Model,
    what: &str,
    (stack, question): (&Stack, &Question),
    effort: Effort,
    progress: StudyProgress,
) -> Result<Answer, String> {
    announce(model.name(), what, progress);
    model.ask(stack, question, effort, &|photons| progress(StudyEvent::Done(photons)))
}

/// Reports that a model is asked about something.
fn announce(name: &str, what: &str, progress: StudyProgress) {
    progress(StudyEvent::Asks(&format!("{name} about {what}")));
}

/// Photons of a study that asks each model `times` times.
fn total_photons(effort: Effort, times: u64) -> u64 {
    Model::ALL.into_iter().filter(|model| model.walks()).count() as u64 * times * effort.walked()
}

/// The head of every study's document.
fn document_head(study: &str) -> Value {
    json!({
        "schema_version": 1,
        "program": format!("gen {}", env!("CARGO_PKG_VERSION")),
        "study": study,
    })
}

/// The head of the document of a study that walks photons.
fn photon_document(study: &str, effort: Effort) -> Value {
    let mut document = document_head(study);
    document["effort"] = json!({ "photons": effort.walked(), "seed": effort.seed });
    document
}

/// A number with its error where it has one.
fn describe(estimate: Estimate, digits: usize) -> String {
    let Estimate { value, error } = estimate;
    // What rounds to nothing has no sign.
    let value = if value.abs() < 0.5 * libm::pow(0.1, digits as f64) { 0.0 } else { value };
    if error > 0.0 { format!("{value:.digits$}+-{error:.digits$}") } else { format!("{value:.digits$}") }
}
