//! The keys that are swept, and their values: two ends and a middle.
//!
//! The middle is the median of what the recipe draws. The ends are 5 and 95 % of that, or of the key's natural
//! variation ([`base::Natural`]) where this reaches further: a recipe that holds a key leaves out what instruments
//! differ in. Natural variation is declared about the default. About another middle it is moved there, in the same
//! ratio where the key is a positive number, else by the same step.

use base::{Natural, Parameter};
use optical_bench::parameters::Bench;
use recipe::{Change, Distribution, Recipe};

use crate::check::CheckError;
use yaml::nearest_spelling;

/// Shares of draws below the ends and the middle.
const SHARES: [f64; 3] = [0.05, 0.5, 0.95];

/// A key with the values that are asked.
#[derive(Debug, Clone, PartialEq)]
pub struct SweptKey {
    /// Path in the recipe: `laser.waist_mm`.
    pub path: String,
    /// Rising: the ends and the middle, or the middle and one end where the other is the middle.
    pub values: Vec<f64>,
    /// Which of them is the middle.
    pub middle: usize,
    /// What the recipe draws it from 5 to 95 %.
    pub drawn: [f64; 2],
    /// Whether it is of the bench, which can be held as it is.
    pub is_bench: bool,
    bounds: [f64; 2],
}

/// The keys, and those that are left out.
#[derive(Debug, Clone, Default)]
pub struct SweptKeys {
    /// In the order of the recipe's sections.
    pub keys: Vec<SweptKey>,
    /// Keys that vary and are not asked, each with the reason.
    pub left_out: Vec<(String, String)>,
}

impl SweptKeys {
    /// Values of all keys.
    pub fn values(&self) -> u64 {
        self.keys.iter().map(|key| key.values.len() as u64).sum()
    }
}

/// 5, 50 and 95 % of a distribution.
fn three(parameter: &Parameter, distribution: &Distribution) -> [f64; 3] {
    SHARES.map(|share| distribution.quantile(parameter, share))
}

/// Ends of a key's natural variation about a middle; the middle itself where the key does not vary.
fn natural_ends(parameter: &Parameter, middle: f64) -> [f64; 2] {
    if parameter.natural == Natural::Fixed {
        return [middle; 2];
    }
    let [low, _, high] = three(parameter, &Distribution::natural(parameter));
    let usual = parameter.default;
    let moved = |end: f64| if low > 0.0 && usual > 0.0 { end * middle / usual } else { end + middle - usual };
    let whole = |end: f64| if parameter.integer { end.round() } else { end };
    [low, high].map(|end| whole(moved(end)).clamp(parameter.min, parameter.max))
}

impl SweptKey {
    fn new(parameter: &'static Parameter, distribution: &Distribution) -> Self {
        let [low, middle, high] = three(parameter, distribution);
        let (min, max) = distribution.bounds(parameter);
        let [least, greatest] = natural_ends(parameter, middle);
        let mut values = vec![low.min(least), middle, high.max(greatest)];
        values.dedup();
        Self {
            path: parameter.path(),
            middle: values.iter().position(|value| *value == middle).unwrap_or(0),
            values,
            drawn: [low, high],
            is_bench: Bench::SECTIONS.contains(&parameter.group),
            bounds: [min, max],
        }
    }

    /// The recipe with the key at a value, all else as it is drawn.
    ///
    /// # Errors
    /// What the recipe refuses the value for.
    pub fn at(&self, recipe: &Recipe, value: f64) -> Result<Recipe, CheckError> {
        if (self.bounds[0]..=self.bounds[1]).contains(&value) {
            return Ok(recipe.with_values([(self.path.as_str(), value)]));
        }
        let what = |what: String| CheckError::Argument(format!("{} = {value}: {what}", self.path));
        let change: Change = format!("{}={value}", self.path).parse().map_err(|e: String| what(e))?;
        recipe.changed(&[change]).map_err(|e| what(e.to_string()))
    }
}

/// Why a key is not asked; `None` where it is.
fn reason(recipe: &Recipe, key: &SweptKey) -> Option<String> {
    if recipe.is_changed_by_class(&key.path) {
        return Some("classes give it distributions of their own: it is what samples are told by".into());
    }
    key.values.iter().find_map(|value| match key.at(recipe, *value) {
        Err(refused) => {
            let text = refused.to_string();
            // The first line counts the faults, the second has the first of them.
            text.lines().nth(1).or(text.lines().next()).map(str::to_owned)
        }
        Ok(changed) => changed.notes().iter().find(|note| note.contains(&key.path)).cloned(),
    })
}

/// The keys to sweep: those that are named, else every key that varies.
///
/// # Errors
/// Every name at fault in a line, what is wrong with it and what to do; or that there is nothing to sweep.
pub fn sweep_keys(recipe: &Recipe, named: &[String]) -> Result<SweptKeys, Vec<String>> {
    let mut found = SweptKeys::default();
    let all = || recipe.parameters().map(|(parameter, distribution)| SweptKey::new(parameter, distribution));
    if named.is_empty() {
        for key in all().filter(|key| key.values.len() > 1) {
            match reason(recipe, &key) {
                None => found.keys.push(key),
                Some(reason) if key.drawn[0] < key.drawn[1] => found.left_out.push((key.path, reason)),
                // What the recipe neither draws nor has a place for is no news.
                Some(_) => {}
            }
        }
        if found.keys.is_empty() {
            let remedy = "give keys a distribution, for instance --set 'laser.waist_mm={uniform: [0.05, 0.2]}'";
            return Err(vec![format!("the recipe varies no key that can be swept; {remedy}")]);
        }
        return Ok(found);
    }
    let mut faults = Vec::new();
    for name in named {
        let Some(key) = all().find(|key| key.path == *name) else {
            let paths: Vec<String> = recipe.parameters().map(|(parameter, _)| parameter.path()).collect();
            let near = nearest_spelling(name, paths.iter().map(String::as_str));
            let remedy = near
                .map_or("`gen schema recipe-reference` lists them".into(), |near| format!("did you mean `{near}`?"));
            let subject = recipe.subject().name();
            faults.push(format!("`{name}`: no key of a recipe about {subject} that is drawn has this name; {remedy}"));
            continue;
        };
        if found.keys.iter().any(|known| known.path == *name) {
            faults.push(format!("`{name}`: it is named twice; name it once"));
        } else if let Some(reason) = reason(recipe, &key) {
            faults.push(format!("`{name}`: {reason}; leave it out"));
        } else if key.values.len() < 2 {
            let remedy = format!("give it a distribution: --set '{name}={{uniform: [a, b]}}'");
            faults.push(format!("`{name}`: it has one value alone, and no ends; {remedy}"));
        } else {
            found.keys.push(key);
        }
    }
    if faults.is_empty() { Ok(found) } else { Err(faults) }
}
