//! Keys that are fitted, and what a recipe says of them beforehand.
//!
//! A key is handled by its **score** u: with F the distribution function of its draws and G that of the standard normal
//! law, its value is F^-1(G(u)). Beforehand all scores are then independent standard normal numbers, whatever the
//! recipe's distributions are, and no value leaves the bounds of its distribution.

use base::Parameter;
use numerics::chance::{normal_below, normal_quantile};
use recipe::{Distribution, Recipe};

/// Sections that describe the bench.
const BENCH: [&str; 5] = ["motion", "laser", "camera", "exposure", "speckle"];
/// Sections that describe matter.
const MATTER: [&str; 6] = ["media", "moisture", "material", "film", "foil", "tablet"];
/// Whether a section describes the bench, not matter.
pub(crate) fn is_of_bench(section: &str) -> bool {
    BENCH.contains(&section)
}

/// Scores farther away than this are not asked for.
pub(crate) const MOST_SCORE: f64 = 3.5;

/// A key that is fitted.
#[derive(Debug, Clone)]
pub struct FitKey {
    /// Path in the recipe: `laser.waist_mm`.
    pub path: String,
    /// Its declaration.
    pub parameter: &'static Parameter,
    /// What the recipe draws it from.
    pub prior: Distribution,
    /// Whether it belongs to the bench, which all scans have in common.
    pub is_bench: bool,
}

impl FitKey {
    /// The value at a score.
    pub fn value(&self, score: f64) -> f64 {
        self.prior.quantile(self.parameter, normal_below(score.clamp(-MOST_SCORE, MOST_SCORE)))
    }

    /// The score of a value: the middle of scores that have it.
    pub fn score(&self, value: f64) -> f64 {
        let below = |level: f64| {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if self.prior.quantile(self.parameter, middle) < level {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            0.5 * (low + high)
        };
        let step = 1e-12 * value.abs().max(1e-12);
        let share = 0.5 * (below(value - step) + below(value + step));
        normal_quantile(share.clamp(1e-6, 1.0 - 1e-6)).clamp(-MOST_SCORE, MOST_SCORE)
    }
}

/// Whether a distribution can draw more than one number.
pub(crate) fn is_spread(distribution: &Distribution, parameter: &'static Parameter) -> bool {
    let (min, max) = distribution.bounds(parameter);
    min < max
}

/// Whether a recipe states a distribution of the key that can draw more than one number.
fn is_sought(recipe: &Recipe, key: &FitKey) -> bool {
    recipe.is_stated(&key.path) && is_spread(&key.prior, key.parameter)
}

/// A key of a recipe with what it is drawn from.
fn key((parameter, distribution): (&'static Parameter, &Distribution)) -> FitKey {
    FitKey { path: parameter.path(), parameter, prior: distribution.clone(), is_bench: is_of_bench(parameter.group) }
}

/// Every key whose distribution is the same for all classes and goes with no other's.
pub(crate) fn free_keys(recipe: &Recipe) -> impl Iterator<Item = FitKey> {
    keys_that_are_free(recipe, &[])
}

/// The same, where scans of these classes are told apart, and one of them that changes a key leaves it to the others.
fn keys_that_are_free(recipe: &Recipe, classes: &[String]) -> impl Iterator<Item = FitKey> {
    let is_free = move |path: &str| !recipe.is_correlated(path) && !is_changed(recipe, path, classes);
    recipe.parameters().map(key).filter(move |key| is_free(&key.path))
}

/// Whether classes leave nothing of a key to be fitted: a class changes it, or each of those that scans are of.
fn is_changed(recipe: &Recipe, path: &str, classes: &[String]) -> bool {
    let is_changed_by = |name: &String| recipe.of_class(name).is_some_and(|class| class.is_changed_by_class(path));
    recipe.is_changed_by_class(path) && classes.iter().all(is_changed_by)
}

/// The keys to fit: those that are named, else every key of bench and matter that the recipe states a distribution of.
/// What varies by nature alone is drawn anew for each scan. `classes` are those that scans are of, where that is told.
///
/// # Errors
/// Every name at fault in a line, what is wrong with it and what to do; or that there is nothing to fit.
pub fn fit_keys(recipe: &Recipe, named: &[String], classes: &[String]) -> Result<Vec<FitKey>, Vec<String>> {
    if named.is_empty() {
        let of_light = |key: &FitKey| key.is_bench || MATTER.contains(&key.parameter.group);
        let free = keys_that_are_free(recipe, classes);
        let found: Vec<FitKey> = free.filter(|key| of_light(key) && is_sought(recipe, key)).collect();
        if found.is_empty() {
            let problem = "the recipe states no distribution of bench and matter that all classes have: there is \
                nothing to fit";
            let remedy = "give those that you don't know one that holds all you believe in, for instance \
                          --set 'laser.waist_mm={log_uniform: [0.03, 0.3]}'";
            return Err(vec![format!("{problem}; {remedy}")]);
        }
        return Ok(found);
    }
    let (mut found, mut faults) = (Vec::<FitKey>::new(), Vec::new());
    for name in named {
        let mut fault = |problem: &str, remedy: &str| faults.push(format!("`{name}`: {problem}; {remedy}"));
        let Some((parameter, distribution)) = recipe.parameters().find(|(parameter, _)| parameter.path() == *name)
        else {
            let all: Vec<String> = recipe.parameters().map(|(parameter, _)| parameter.path()).collect();
            let near = yaml::nearest_spelling(name, all.iter().map(String::as_str));
            let problem = format!("no key of a recipe about {} that is drawn has this name", recipe.subject().name());
            let remedy = match near {
                Some(near) => format!("did you mean `{near}`?"),
                None => "`gen schema recipe-reference` lists them".into(),
            };
            fault(&problem, &remedy);
            continue;
        };
        if found.iter().any(|known| known.path == *name) {
            fault("it is named twice", "name it once");
        } else if !recipe.is_stated(name) && is_spread(distribution, parameter) {
            let set = format!("--set '{name}={{uniform: [a, b]}}'");
            let remedy = format!("state what you believe: {set}");
            fault("the recipe does not state it, so that it varies by nature from scan to scan", &remedy);
        } else if recipe.is_correlated(name) {
            let remedy = "take its pair out of `correlations`";
            fault("it is correlated with another key, and keys are fitted as independent ones", remedy);
        } else if is_changed(recipe, name, classes) {
            let remedy = "give --set classes with a class that does not, or leave the key out";
            fault("a class gives it a distribution of its own", remedy);
        } else if !is_spread(distribution, parameter) {
            let set = format!("--set '{name}={{uniform: [a, b]}}'");
            let remedy = format!("give it a distribution that holds all you believe in: {set}");
            fault("the recipe gives it one value, which leaves nothing to fit", &remedy);
        } else {
            found.push(key((parameter, distribution)));
        }
    }
    if faults.is_empty() { Ok(found) } else { Err(faults) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What varies by nature is no key to fit: it is drawn anew for each scan.
    #[test]
    fn natural_numbers_are_nuisance() {
        let text = "name: a\nsubject: sawtooth\nlaser: {power_mw: {uniform: [30, 80]}}\nclasses: {a: {share: 1}}\n";
        let recipe = Recipe::parse("test", text).unwrap_or_else(|error| panic!("{error}"));
        let paths = |named: &[String]| -> Result<Vec<String>, Vec<String>> {
            Ok(fit_keys(&recipe, named, &[])?.into_iter().map(|key| key.path).collect())
        };
        assert_eq!(paths(&[]), Ok(vec!["laser.power_mw".to_owned()]));
        let faults = paths(&["laser.waist_mm".to_owned()]).expect_err("it is not stated");
        assert!(faults[0].contains("varies by nature from scan to scan") && faults[0].contains("--set"), "{faults:?}");
        let value = |index: u64| recipe.draw(0, index).bench.laser.waist_mm;
        assert_ne!(value(0), value(1));
    }

    /// A key that some classes change is one to fit where the scans of another class, which leaves it, are told apart.
    #[test]
    fn classes_that_are_told_apart_leave_keys() {
        let text = "name: a\nsubject: wood\nunstated: fixed\nlaser: {power_mw: {uniform: [30, 80]}}\n\
                    media: {gloss: {uniform: [0.1, 0.6]}}\n\
                    classes: {plate: {share: 1, media: {gloss: 0}}, wood: {share: 1}}\n";
        let recipe = Recipe::parse("test", text).unwrap_or_else(|error| panic!("{error}"));
        let paths = |classes: &[&str]| -> Vec<String> {
            let classes: Vec<String> = classes.iter().map(|name| (*name).to_owned()).collect();
            fit_keys(&recipe, &[], &classes).expect("some").into_iter().map(|key| key.path).collect()
        };
        assert_eq!(paths(&[]), ["laser.power_mw"]);
        assert_eq!(paths(&["plate"]), ["laser.power_mw"]);
        assert_eq!(paths(&["plate", "wood"]), ["laser.power_mw", "media.gloss"]);
        assert!(fit_keys(&recipe, &["media.gloss".to_owned()], &["plate".to_owned()]).is_err());
        let wood = recipe.of_class("wood").expect("a class");
        assert_eq!((wood.classes().len(), wood.classes()[0].share), (1, 1.0));
        assert!(recipe.of_class("stone").is_none());
    }
}
