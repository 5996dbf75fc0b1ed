//! Studies: models of transport side by side and the instrument against theory, as tables, JSON and pictures.
//!
//! - [`point`]: a point of light on wood, the ellipses that it makes
//! - [`lines`]: a line of light on fifteen media, where it comes out
//! - [`profile`]: one profile of a recipe's sample
//! - [`instrument`]: triangulation, sensor, speckle, laser
//! - [`packs`]: one blister pack of each defect
//!
//! A study of light inside matter walks [`Model::ALL`], that of a point [`compared_model::ComparedModel::all`]; a model that refuses a question
//! stands in it with its reason.

pub mod compared_model;
pub mod ellipse;
mod fit;
pub mod instrument;
pub mod lines;
pub mod media;
pub mod packs;
pub mod point;
pub mod profile;

use image::RgbImage;
use serde_json::{Value, json};

use crate::transport::answer::{Answer, Estimate, Question};
use crate::transport::model::{Model, ModelError};
use crate::transport::path::Effort;
use crate::transport::stack::Stack;

/// What a study has found.
#[derive(Debug, Clone)]
pub struct Report {
    /// A table for the terminal.
    pub table: String,
    /// Everything, with standard errors.
    pub json: Value,
    /// The same as a picture.
    pub picture: RgbImage,
}

/// How far a study is.
#[derive(Debug, Clone, Copy)]
pub enum Step<'a> {
    /// A model is asked about something.
    Asks(&'a str),
    /// So many photons more are done, or so many repeats.
    Done(u64),
}

/// Whoever wants to know.
pub type Watch<'a> = &'a (dyn Fn(Step) + Sync);

/// Asks a model, and tells who watches.
fn ask(
    model: Model,
    what: &str,
    (stack, question): (&Stack, &Question),
    effort: Effort,
    watch: Watch,
) -> Result<Answer, ModelError> {
    asks(model.name(), what, watch);
    model.ask(stack, question, effort, &|photons| watch(Step::Done(photons)))
}

/// Tells who watches that somebody is asked.
fn asks(name: &str, what: &str, watch: Watch) {
    watch(Step::Asks(&format!("{name} about {what}")));
}

/// Photons of a study that asks each model `times` times.
fn photons(effort: Effort, times: u64) -> u64 {
    Model::ALL.into_iter().filter(|model| model.walks()).count() as u64 * times * effort.walked()
}

/// The head of every study's document.
fn head(study: &str, effort: Effort) -> Value {
    json!({
        "schema_version": 1,
        "program": format!("gen {}", env!("CARGO_PKG_VERSION")),
        "study": study,
        "effort": { "photons": effort.walked(), "seed": effort.seed },
    })
}

/// A number with its error where it has one.
fn told(estimate: Estimate, digits: usize) -> String {
    let Estimate { value, error } = estimate;
    // What rounds to nothing has no sign.
    let value = if value.abs() < 0.5 * libm::pow(0.1, digits as f64) { 0.0 } else { value };
    if error > 0.0 { format!("{value:.digits$}+-{error:.digits$}") } else { format!("{value:.digits$}") }
}
