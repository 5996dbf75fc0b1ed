//! Robustness of a model: what each key of a recipe costs it, at the ends of the key's range.
//!
//! ```text
//! recipe -> keys with two ends and a middle -> fresh samples at each -> check -> answers by sample
//!        -> paired differences -> cost with its interval, ranked -> what to hold fixed, or to vary
//! ```
//!
//! Samples of one number are alike at all values of a key but for that key: a recipe draws each key from a stream of
//! its own. So what a value costs is the mean of differences within samples, and what samples have in common falls out.
//! Samples are made by who calls; nothing is rendered here. What was answered is kept on disk value by value.

mod cost;
mod keys;
mod report;

use std::collections::BTreeMap;
use std::path::PathBuf;

use dataset::Fault;
use dataset::kept_lines::{KeptKind, KeptLines};
use recipe::Recipe;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::check::{CheckError, CheckOptions, CheckReport, TriedModel, check};
pub use cost::{CostVerdict, EndCost};
pub use keys::{SweptKey, SweptKeys, sweep_keys};
pub use report::{KeyCost, Sweep};

/// What is kept while a sweep runs.
const KIND: KeptKind = KeptKind {
    kind: "sheetlight sweep",
    key: "sweep",
    refusals: [
        "it keeps the answers of another sweep (recipe, keys, model, seed or samples differ)",
        "it keeps no answers of a sweep",
    ],
};

/// How a model is swept.
#[derive(Debug, Clone)]
pub struct SweepOptions {
    /// How it is checked; the folder is where samples are made, again and again.
    pub check: CheckOptions,
    /// Samples at each value.
    pub samples: u64,
    /// Where answers are kept.
    pub store: PathBuf,
}

/// Right answers and answers of a sample.
pub type SampleAnswers = [u64; 2];

/// What a model answered at one value of a key.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct KeptAnswers {
    key: String,
    value: f64,
    answers: Vec<SampleAnswers>,
}

/// Makes samples of a recipe in the folder of [`SweepOptions::check`], in place of those that were there.
pub type MakeSamples<'a> = &'a dyn Fn(&Recipe) -> Result<(), Fault>;

/// Sweeps a model, which `tried` has opened, over `keys` of a recipe. `kept` is told of samples whose answers an
/// earlier run has kept.
///
/// # Errors
/// Where model, samples or the kept file are not as they should be.
pub fn sweep(
    recipe: &Recipe,
    keys: &SweptKeys,
    tried: &TriedModel,
    options: &SweepOptions,
    make: MakeSamples,
    kept: &dyn Fn(u64),
) -> Result<Sweep, CheckError> {
    let asked: Vec<_> = keys.keys.iter().map(|key| json!([key.path, key.values])).collect();
    let what = json!({
        "version": env!("CARGO_PKG_VERSION"), "recipe_hash": recipe.hash(), "seed": options.check.seed,
        "samples": options.samples, "model": tried.sha256, "sidecar": tried.sidecar_sha256, "keys": asked,
    });
    let (mut lines, before) = KeptLines::open::<KeptAnswers>(&options.store, &KIND, &what)?;
    let known: BTreeMap<(&str, u64), &KeptAnswers> =
        before.iter().map(|kept| ((kept.key.as_str(), kept.value.to_bits()), kept)).collect();
    let mut found = Vec::new();
    for key in &keys.keys {
        let mut answers = Vec::new();
        for &value in &key.values {
            if let Some(before) = known.get(&(key.path.as_str(), value.to_bits())) {
                kept(before.answers.len() as u64);
                answers.push(before.answers.clone());
                continue;
            }
            make(&key.at(recipe, value)?)?;
            let now = KeptAnswers { key: key.path.clone(), value, answers: asked_of(options)? };
            lines.keep(std::slice::from_ref(&now))?;
            answers.push(now.answers);
        }
        found.push((key.clone(), answers));
    }
    Ok(Sweep::new(recipe, keys, tried, options, found))
}

/// What the model answers of the samples that are there; nothing where they show nothing of its classes.
fn asked_of(options: &SweepOptions) -> Result<Vec<SampleAnswers>, CheckError> {
    let mut answers = vec![[0; 2]; options.samples as usize];
    match check(&options.check, &|_, _| None, &|_, _| ()) {
        Err(CheckError::Nothing(_)) => {}
        report => {
            let CheckReport { answers: of_samples, .. } = report?;
            of_samples.into_iter().for_each(|(index, of_sample)| answers[index as usize] = of_sample);
        }
    }
    Ok(answers)
}
