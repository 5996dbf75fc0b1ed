//! What a sweep found: keys by what they cost, as a table for people and JSON for programs.

use recipe::Recipe;
use serde_json::{Value, json};

use super::cost::{CostVerdict, EndCost, share};
use super::{SampleAnswers, SweepOptions, SweptKey, SweptKeys};
use crate::check::{TriedModel, short};

/// Value of `format` in the document.
const DOCUMENT_FORMAT: &str = "sheetlight-sweep";
/// Version of the document's layout.
const SCHEMA_VERSION: u32 = 1;

/// What a key costs.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyCost {
    /// The key.
    pub key: SweptKey,
    /// Mean over samples of the share of right answers at each value; `None` where no sample had any.
    pub accuracies: Vec<Option<f64>>,
    /// Its ends.
    pub ends: Vec<EndCost>,
}

/// What was found.
#[derive(Debug, Clone)]
pub struct Sweep {
    /// Name of the recipe.
    pub recipe: String,
    /// SHA-256 of its canonical form.
    pub recipe_hash: String,
    /// The model, as it was named.
    pub model: String,
    /// SHA-256 of model and sidecar, hexadecimal.
    pub sha256: [String; 2],
    /// What the model does.
    pub task: &'static str,
    /// Seed.
    pub seed: u64,
    /// Samples at each value.
    pub samples: u64,
    /// Keys, those that cost most first.
    pub keys: Vec<KeyCost>,
    /// Keys that vary and were not asked, each with the reason.
    pub left_out: Vec<(String, String)>,
}

impl KeyCost {
    fn new(key: SweptKey, answers: &[Vec<SampleAnswers>], keys: usize) -> Self {
        let accuracy = |answers: &Vec<SampleAnswers>| {
            let shares: Vec<f64> = answers.iter().filter_map(share).collect();
            (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64)
        };
        let ends = (0..key.values.len()).filter(|&i| i != key.middle);
        let ends = ends.map(|i| EndCost::new(key.values[i], &answers[key.middle], &answers[i], keys)).collect();
        Self { accuracies: answers.iter().map(accuracy).collect(), ends, key }
    }

    /// The end that costs more.
    pub fn worse(&self) -> &EndCost {
        self.ends.iter().max_by(|a, b| a.cost.total_cmp(&b.cost)).expect("a swept key has an end")
    }

    /// What to do about it; nothing where no cost was seen.
    pub fn advice(&self) -> Option<String> {
        let worse = self.worse();
        if worse.verdict() == CostVerdict::NotSeen {
            return None;
        }
        let key = &self.key;
        let [first, last] = [key.values[0], key.values[key.values.len() - 1]];
        let is_drawn = key.drawn[0] <= first && key.drawn[1] >= last;
        let train = match is_drawn {
            true => "the recipe varies it as far: train longer, or on more samples".to_owned(),
            false => {
                format!("vary it in the recipe, {{uniform: [{}, {}]}}, and train again", short(first), short(last))
            }
        };
        let hold = format!(", or hold it near {} on the rig", short(key.values[key.middle]));
        Some(format!("{}: {train}{}", key.path, if key.is_bench { &hold } else { "" }))
    }
}

impl Sweep {
    pub(super) fn new(
        recipe: &Recipe,
        keys: &SweptKeys,
        tried: &TriedModel,
        options: &SweepOptions,
        answers: Vec<(SweptKey, Vec<Vec<SampleAnswers>>)>,
    ) -> Self {
        let count = answers.len();
        let mut found: Vec<KeyCost> =
            answers.into_iter().map(|(key, answers)| KeyCost::new(key, &answers, count)).collect();
        found.sort_by(|a, b| b.worse().cost.total_cmp(&a.worse().cost));
        Self {
            recipe: recipe.name().to_owned(),
            recipe_hash: recipe.hash(),
            model: options.check.model.display().to_string(),
            sha256: [tried.sha256.clone(), tried.sidecar_sha256.clone()],
            task: tried.sidecar.task.name(),
            seed: options.check.seed,
            samples: options.samples,
            keys: found,
            left_out: keys.left_out.clone(),
        }
    }

    /// The document.
    pub fn json(&self) -> Value {
        let end = |end: &EndCost| {
            json!({
                "value": end.value, "cost": end.cost, "low": end.interval[0], "high": end.interval[1],
                "joint_low": end.joint_low, "samples": end.samples,
            })
        };
        let key = |cost: &KeyCost| {
            json!({
                "key": cost.key.path, "values": cost.key.values, "accuracies": cost.accuracies,
                "middle": cost.key.middle, "ends": cost.ends.iter().map(end).collect::<Vec<_>>(),
                "worse": end(cost.worse()), "verdict": cost.worse().verdict().name(), "advice": cost.advice(),
            })
        };
        let left_out = |(key, reason): &(String, String)| json!({ "key": key, "reason": reason });
        let [model, sidecar] = &self.sha256;
        json!({
            "format": DOCUMENT_FORMAT,
            "schema_version": SCHEMA_VERSION,
            "model": { "path": self.model, "sha256": model, "sidecar_sha256": sidecar },
            "recipe": { "name": self.recipe, "hash": self.recipe_hash },
            "task": self.task,
            "seed": self.seed,
            "samples": self.samples,
            "keys": self.keys.iter().map(key).collect::<Vec<_>>(),
            "left_out": self.left_out.iter().map(left_out).collect::<Vec<_>>(),
        })
    }

    /// The table, and what to do.
    pub fn table(&self) -> String {
        let mut lines = vec![
            format!("{} on {}: {} samples at each value, seed {}", self.model, self.recipe, self.samples, self.seed),
            format!(
                "{:<34} {:>28}  {:>20}  {:>7}  {:<18} verdict",
                "key", "values", "accuracies", "cost", "95 % for the key"
            ),
        ];
        for cost in &self.keys {
            let values: Vec<String> = cost.key.values.iter().map(|value| short(*value)).collect();
            let shares = cost.accuracies.iter().map(|share| share.map_or("-".into(), |share| format!("{share:.3}")));
            let shares: Vec<String> = shares.collect();
            let worse = cost.worse();
            let interval = worse.interval.map(|end| format!("{end:.3}")).join(" to ");
            lines.push(format!(
                "{:<34} {:>28}  {:>20}  {:>7.3}  {interval:<18} {}",
                cost.key.path,
                values.join(" "),
                shares.join(" "),
                worse.cost,
                worse.verdict().name()
            ));
        }
        let advice: Vec<String> = self.keys.iter().filter_map(KeyCost::advice).collect();
        if !advice.is_empty() {
            lines.push("\nwhat to do, the most costly first:".into());
        }
        lines.extend(advice.into_iter().map(|advice| format!("  {advice}")));
        if !self.left_out.is_empty() {
            lines.push("\nvary, and were not asked:".into());
        }
        lines.extend(self.left_out.iter().map(|(key, reason)| format!("  {key}: {reason}")));
        lines.join("\n") + "\n"
    }
}
