//! What a model was trained on, where its sidecar says so, and whether the samples that it is checked on are those of
//! the training or alike.

use output_schema::DatasetHead;

use optical_bench::split::Split;

/// The dataset of whose split `train` a model was made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TrainedOn {
    /// Family of its recipe.
    pub family: String,
    /// Seed.
    pub seed: u64,
    /// Hash of its recipe, where that is known.
    pub recipe_hash: Option<String>,
}

impl TrainedOn {
    /// Why a split of a dataset (all of it for `None`) says little of other samples, and what to do; `None` where it
    /// was not drawn as the training was.
    ///
    /// Sample i of two datasets of one family and seed draws the same random numbers. Whether it lies in the same split
    /// follows from classes and shares, so another recipe may have samples of the training in its split test.
    pub fn shared_draws(&self, head: &DatasetHead, split: Option<Split>) -> Option<String> {
        let Self { family, seed, recipe_hash } = self;
        if head.recipe.canonical["family"].as_str() != Some(family) || head.seed != *seed {
            return None;
        }
        let is_same = recipe_hash.as_ref() == Some(&head.recipe.hash);
        let samples = match split {
            Some(Split::Test | Split::Validation) if is_same => return None,
            _ if is_same => "the split holds the samples of the training",
            _ => "its samples are those of the training, or alike where the recipes agree",
        };
        Some(format!(
            "the sidecar says that the model was trained on family `{family}` with seed {seed}, whose random numbers \
                this dataset has \
             too: {samples}; check it on a dataset of another --seed"
        ))
    }
}
