//! The recipe of `dataset.json` cannot be drawn again: it does not load, or another program wrote the dataset. Both are
//! told by [`expected::head`](crate::validate::expected), which compares all that the recipe gives.

use super::{RESTORE, Rule};

pub(super) const RECIPE_DIFFERS: Rule = Rule {
    meaning: "The recipe in `dataset.json` does not load, or means something else than it did.",
    remedy: RESTORE,
};
pub(super) const WRITER_DIFFERS: Rule = Rule {
    meaning: "Another version of the program, or one for another target, wrote the dataset: its draws cannot be \
        compared.",
    remedy: "validate with the program version and target that the message names",
};
