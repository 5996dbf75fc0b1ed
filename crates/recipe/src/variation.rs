//! Variation: what becomes of the numbers that a recipe does not state.
//!
//! **Model.** By default (`unstated: drawn`) each of them is drawn from what it does between good installations
//! ([`base::Natural`]), if it has an effect in some class. With `unstated: fixed` it stays at its default. What is off
//! stays off either way.
//!
//! **What is stated comes first.** Where natural numbers and stated ones cannot go together (a thin tablet, and the
//! band of a usual one), natural ones go back to their defaults until they can, the last declared ones first. So a
//! recipe is at fault only where it would be with `unstated: fixed`.
//!
//! **Correlations** that nature has ([`CORRELATED`]) hold between two numbers that both vary by nature, unless a pair
//! of the recipe has one of them.

use std::collections::{BTreeMap, BTreeSet};

use base::{Natural, Parameter, words};
use yaml::YamlReader;

use super::class::SampleClass;
use super::constraints::{self, RecipeObject, needs};
use super::correlation::{Correlation, WrittenPair};
use super::distribution::Distribution;
use super::groups::GroupSizes;
use super::keys;

/// The key of a recipe that says it.
pub(super) const UNSTATED: &str = "unstated";
/// What it is about.
pub(super) const UNSTATED_DOC: &str = "\
What becomes of numbers that the recipe does not state: `drawn`, each as it varies between good installations, or \
`fixed`, \
all at their defaults.";

words! {
    /// What becomes of numbers that a recipe does not state.
    Unstated {
        /// They are drawn from their natural distributions.
        Drawn = "drawn",
        /// They stay at their defaults.
        Fixed = "fixed",
    }
}

/// Pairs of numbers that go together by nature, the first in order first, with Spearman's rank correlation [1].
///
/// Wide rings have less latewood (docs/theory/wood.md). Denser wood scatters more and has a higher index; wide openings
/// and pockets are deep and long; a laser of poor beam quality has a wide waist; coarse rolls leave foil rough both
/// ways: these strengths are estimates [M].
const CORRELATED: [(&str, &str, f64); 7] = [
    ("cracks.depth_mm", "cracks.width_mm", 0.6),
    ("foil.roughness_across", "foil.roughness_along", 0.5),
    ("inclusions.length_mm", "inclusions.width_mm", 0.6),
    ("laser.m_squared", "laser.waist_mm", 0.4),
    ("log.latewood_share", "log.ring_width_mm", -0.6),
    ("media.clear_n_eff", "media.earlywood_k_per_mm", 0.5),
    ("media.earlywood_k_per_mm", "media.earlywood_sigma_i_per_mm", 0.5),
];

/// The numbers of a recipe by how they come to their values.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Variation {
    /// Paths that the top level states.
    pub stated: BTreeSet<String>,
    /// Paths that vary by nature.
    pub natural: BTreeSet<String>,
}

/// How many numbers of a recipe's samples vary, and why.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct VariationCount {
    /// Vary as the recipe states.
    pub stated: usize,
    /// Vary by nature.
    pub natural: usize,
    /// Vary by nature elsewhere and have one value here.
    pub held: usize,
    /// Paths of those among them that move what classes are told by: matter, and what a defect of a class looks like.
    pub telling: Vec<String>,
}

/// Most paths that a sentence names.
const NAMED: usize = 6;
/// Groups of matter.
const MATTER: [&str; 5] = ["media", "tablet", "film", "foil", "material"];

impl VariationCount {
    /// How many vary, in words.
    pub fn told(&self) -> String {
        let Self { stated, natural, held, .. } = self;
        format!("{stated} numbers vary as the recipe states, {natural} by nature; {held} more that could are fixed")
    }

    /// What is said of those that classes are told by; `None` where none is fixed.
    pub fn warning(&self) -> Option<String> {
        let paths: Vec<_> = self.telling.iter().take(NAMED).map(|path| format!("`{path}`")).collect();
        let more = match self.telling.len() - paths.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        (!paths.is_empty()).then(|| {
            format!(
                "classes are told by what moves with {}{more}, which the recipe fixes; give distributions, or \
                 `{UNSTATED}: drawn` and no value",
                paths.join(", ")
            )
        })
    }
}

/// Fills what the top level does not state; the paths of what varies by nature then come back.
pub(super) fn fill(
    yaml: &YamlReader,
    unstated: Unstated,
    object: RecipeObject,
    parameters: &mut BTreeMap<String, Distribution>,
) -> BTreeSet<String> {
    let own = keys::parameters(object.subject).filter(|parameter| parameter.natural != Natural::Fixed);
    let open = own.filter(|parameter| unstated == Unstated::Drawn && !parameters.contains_key(&parameter.path()));
    let mut natural: BTreeMap<String, f64> = open.map(|parameter| (parameter.path(), parameter.default)).collect();
    for parameter in keys::parameters(object.subject) {
        parameters.entry(parameter.path()).or_insert_with(|| {
            let varies = natural.contains_key(&parameter.path());
            if varies { Distribution::natural(parameter) } else { Distribution::Fixed(parameter.default) }
        });
    }
    let idle = constraints::without_effect(RecipeObject { parameters, ..object });
    for path in idle {
        if let Some(default) = natural.remove(&path) {
            parameters.insert(path, Distribution::Fixed(default));
        }
    }
    let refuses =
        |parameters: &BTreeMap<_, _>| !constraints::refused(yaml, RecipeObject { parameters, ..object }).is_empty();
    if !refuses(parameters) {
        return natural.into_keys().collect();
    }
    // All at their defaults; then whole sections vary again, and of those that cannot each number that can.
    let open: Vec<&Parameter> = keys::parameters(object.subject).filter(|p| natural.contains_key(&p.path())).collect();
    let mut kept = parameters.clone();
    kept.extend(natural.into_iter().map(|(path, default)| (path, Distribution::Fixed(default))));
    let mut varied = BTreeSet::new();
    let mut vary = |some: &[&Parameter]| {
        let mut tried = kept.clone();
        tried.extend(some.iter().map(|parameter| (parameter.path(), Distribution::natural(parameter))));
        let fits = !refuses(&tried);
        if fits {
            kept = tried;
            varied.extend(some.iter().map(|parameter| parameter.path()));
        }
        fits
    };
    // What is at fault without any is no matter of these.
    if vary(&[]) {
        for section in open.chunk_by(|a, b| a.group == b.group) {
            if !vary(section) {
                section.iter().for_each(|parameter| {
                    vary(&[parameter]);
                });
            }
        }
    }
    *parameters = kept;
    varied
}

impl Variation {
    /// The pairs of [`CORRELATED`] that hold beside those that the recipe has.
    pub fn correlated(
        &self,
        written: &[WrittenPair],
        groups: &GroupSizes,
        classes: &[SampleClass],
    ) -> Vec<WrittenPair> {
        let is_open = |key: &str| self.natural.contains(key) && !written.iter().any(|written| written.has(key));
        let keeps = |class: &SampleClass, key: &str| !class.overrides.contains_key(key);
        let holds = |(a, b, _): &&(&str, &str, f64)| {
            is_open(a)
                && is_open(b)
                && groups.level(a) == groups.level(b)
                && classes.iter().any(|class| keeps(class, a) && keeps(class, b))
        };
        let pair = |(a, b, spearman): &(&str, &str, f64)| {
            WrittenPair::of_nature(Correlation { keys: [*a, *b].map(str::to_owned), spearman: *spearman })
        };
        CORRELATED.iter().filter(holds).map(pair).collect()
    }

    /// Counts the numbers of `parameters` and of classes.
    pub fn count(&self, object: RecipeObject) -> VariationCount {
        let idle: BTreeSet<String> = constraints::without_effect(object).into_iter().collect();
        let mut count = VariationCount::default();
        for parameter in keys::parameters(object.subject) {
            let path = parameter.path();
            let own =
                |class: &SampleClass| class.overrides.get(&path).or_else(|| object.parameters.get(&path)).cloned();
            let mut values: Vec<_> = object.classes.iter().map(own).collect();
            values.dedup();
            let is_one = matches!(values.as_slice(), [Some(Distribution::Fixed(_))]);
            if self.natural.contains(&path) {
                count.natural += 1;
            } else if !is_one {
                count.stated += 1;
            } else if parameter.natural != Natural::Fixed && !idle.contains(&path) {
                count.held += 1;
                if MATTER.contains(&parameter.group) || told_apart(parameter, object.classes) {
                    count.telling.push(path);
                }
            }
        }
        count
    }
}

/// Whether a class has what the number describes and others have not.
fn told_apart(parameter: &Parameter, classes: &[SampleClass]) -> bool {
    let deciders = parameter.conditions.iter().flat_map(|condition| needs::deciders(condition.need));
    deciders.into_iter().any(|path| classes.iter().any(|class| class.overrides.contains_key(path)))
}

#[cfg(test)]
mod tests;
