//! Correlations: pairs of keys that rise and fall together, while each keeps the distribution that the recipe gives it.
//!
//! **Model.** A Gaussian copula (Nelsen 2006, *An Introduction to Copulas*). Each key of a pair has a normal score of
//! its own, z; the scores are mixed, and each mixture is turned into a number of the key's distribution by its quantile
//! function:
//!
//! ```text
//! x_i = F_i^-1(Phi(y_i)),    y = L z,    L L^T = R,    R_ij = 2 sin(pi rho_ij / 6),    R_ii = 1
//! ```
//!
//! rho is Spearman's rank correlation, which no choice of units or rising functions changes: what the recipe writes is
//! what the draws have, whatever the two distributions are (Pearson 1907). Pairs that are not written have R_ij = 0.
//! Each row of L has length 1, so every y is standard normal and every x has its own law exactly: bounds, checks at the
//! ends of distributions and the tests of `gen validate` hold as without a correlation. L is Cholesky's, keys in the
//! order of their paths; the first of several keeps its own score.
//!
//! **Why a copula and not distributions that depend on another key** (`{given: ...}`). Such a key has no distribution
//! of its own: its bounds, the share of draws within them, its law for validation and the curve of the report would all
//! follow from another key, and from further ones in chains, which may not close. One number for a pair says what
//! measurements of matter mostly say (wider rings have less latewood), and composes. What comes in kinds (if decayed,
//! then dark) is what classes are for.
//!
//! **Limits.** Monotone dependence alone: no threshold, no scatter that grows along a key, and in the far tails two
//! keys are independent (a Gaussian copula has no tail dependence for |rho| < 1). Keys on a scale alone: ranks of
//! counts and choices have ties, and their Spearman correlation would not be the one that is written. A pair acts in
//! the classes in which both keys have a continuous distribution; in others each key is drawn as if the pair were not
//! there.

use std::collections::{BTreeMap, BTreeSet};

use base::Parameter;
use serde_json::{Value as Json, json};

use super::class::SampleClass;
use super::distribution::Distribution;
use super::keys::alternatives::ALTERNATIVES;
use super::keys::{self, SECTIONS};
use super::subject::Subject;
use yaml::{TextPosition, YamlNode, YamlReader, YamlValue, clipped_text, nearest_spelling, number_text};

/// The key of a recipe that holds them.
pub(super) const CORRELATIONS: &str = "correlations";
/// What it is about.
pub(super) const CORRELATIONS_DOC: &str = "\
Pairs of keys that rise and fall together, each with Spearman's rank correlation; each key keeps its own distribution.";

/// What is left of a variance below which a key follows from the others [1].
const MIN_VARIANCE: f64 = 1e-10;
/// Most keys that hang together for which a remedy of a single pair is looked for.
const MAX_KEYS_OF_REMEDY: usize = 16;

/// A pair of keys.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Correlation {
    /// Paths of two parameters, the first in order first.
    pub keys: [String; 2],
    /// Spearman's rank correlation, between -1 and 1 [1].
    pub spearman: f64,
}

/// A pair, and where the recipe has it.
pub(super) struct WrittenPair {
    place: TextPosition,
    pair: Correlation,
}

impl WrittenPair {
    /// A pair that no recipe writes and that can be together with those that are.
    pub fn of_nature(pair: Correlation) -> Self {
        Self { place: TextPosition::START, pair }
    }

    /// Whether it has the key at `path`.
    pub fn has(&self, path: &str) -> bool {
        self.pair.keys.iter().any(|key| key == path)
    }
}

/// For each key of a class that is correlated, the keys whose normal scores its own is mixed from, each with its
/// weight: rows of L.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct ScoreMixture(BTreeMap<String, Vec<(String, f64)>>);

impl ScoreMixture {
    /// What the normal score of `key` is mixed from; `None` where it is correlated with nothing.
    pub fn of(&self, key: &str) -> Option<&[(String, f64)]> {
        self.0.get(key).map(Vec::as_slice)
    }
}

impl Correlation {
    /// Correlation of the normal scores [1].
    fn of_scores(&self) -> f64 {
        pearson(self.spearman)
    }

    /// The pair as a recipe writes it.
    pub fn json(&self) -> Json {
        json!({ "keys": self.keys, "spearman": self.spearman })
    }
}

/// Pearson's correlation of two normal numbers whose rank correlation is `spearman` (Pearson 1907).
fn pearson(spearman: f64) -> f64 {
    2.0 * libm::sin(std::f64::consts::PI / 6.0 * spearman)
}

/// The inverse of [`pearson`].
fn spearman(pearson: f64) -> f64 {
    6.0 / std::f64::consts::PI * libm::asin((pearson / 2.0).clamp(-0.5, 0.5))
}

/// What a list of pairs may be, as JSON Schema.
pub(super) fn schema() -> Json {
    let pair = json!({
        "type": "object",
        "required": ["keys", "spearman"],
        "additionalProperties": false,
        "properties": {
            "keys": {
                "description": "Paths of two keys that are drawn on a scale, for instance camera.tilt_deg.",
                "type": "array", "items": { "type": "string" }, "minItems": 2, "maxItems": 2, "uniqueItems": true,
            },
            "spearman": {
                "description": "Rank correlation of their draws.",
                "type": "number", "exclusiveMinimum": -1, "exclusiveMaximum": 1,
            },
        },
    });
    json!({ "description": CORRELATIONS_DOC, "type": ["array", "null"], "items": pair })
}

/// Reads the pairs at `node`; faults are noted, and pairs with one left out.
pub(super) fn read(yaml: &mut YamlReader, node: &YamlNode, subject: Option<Subject>) -> Vec<WrittenPair> {
    const FORM: &str = "a list of `{keys: [KEY, KEY], spearman: RHO}`";
    let entries = match &node.value {
        YamlValue::Nothing => &[],
        _ => yaml.list(node, CORRELATIONS, FORM).unwrap_or_default(),
    };
    let mut pairs: Vec<WrittenPair> = Vec::new();
    for entry in entries {
        let mut map = yaml.mapping(entry, CORRELATIONS);
        let (at_keys, at_spearman) = (map.take(yaml, "keys"), map.take(yaml, "spearman"));
        let is_map = matches!(entry.value, YamlValue::Map(_) | YamlValue::Nothing);
        map.close(yaml, &["keys", "spearman"], &|_| None);
        for (name, found) in [("keys", at_keys), ("spearman", at_spearman)] {
            if found.is_none() && is_map {
                yaml.fault(entry.place, &format!("{CORRELATIONS}.{name}"), "is missing", format!("give {FORM}"));
            }
        }
        let keys = at_keys.and_then(|node| two_keys(yaml, node, subject));
        let spearman = at_spearman.and_then(|node| rank_correlation(yaml, node));
        let (Some(keys), Some(spearman)) = (keys, spearman) else { continue };
        if let Some(first) = pairs.iter().find(|known| known.pair.keys == keys) {
            let [a, b] = &keys;
            let problem = format!("`{a}` and `{b}` are a pair in line {} already", first.place.line);
            yaml.fault(entry.place, CORRELATIONS, problem, "remove one of them");
            continue;
        }
        pairs.push(WrittenPair { place: entry.place, pair: Correlation { keys, spearman } });
    }
    pairs
}

/// The pairs, in the order of their keys.
pub(super) fn sorted(pairs: &[WrittenPair]) -> Vec<Correlation> {
    let mut pairs: Vec<_> = pairs.iter().map(|written| written.pair.clone()).collect();
    pairs.sort_by(|a, b| a.keys.cmp(&b.keys));
    pairs
}

fn rank_correlation(yaml: &mut YamlReader, node: &YamlNode) -> Option<f64> {
    const ALLOWED: &str = "a number between -1 and 1, both left out";
    let path = format!("{CORRELATIONS}.spearman");
    let spearman = yaml.number(node, &path, ALLOWED)?;
    if spearman.abs() < 1.0 {
        return Some(spearman);
    }
    let whole = if spearman.abs() == 1.0 { ": one key would follow from the other" } else { "" };
    let problem = format!("{} is out of range{whole}", number_text(spearman));
    yaml.refuse(node.place, &path, problem, format!("give {ALLOWED}"))
}

/// Two different keys, in order.
fn two_keys(yaml: &mut YamlReader, node: &YamlNode, subject: Option<Subject>) -> Option<[String; 2]> {
    const ALLOWED: &str = "two keys that are drawn, for instance [camera.tilt_deg, camera.distance_mm]";
    let path = format!("{CORRELATIONS}.keys");
    let entries = yaml.list(node, &path, ALLOWED)?;
    let [a, b] = entries else {
        return yaml.refuse(node.place, &path, format!("is a list of {}", entries.len()), format!("give {ALLOWED}"));
    };
    let found = [a, b].map(|node| key(yaml, node, &path, subject));
    let [Some(a), Some(b)] = found else { return None };
    if a == b {
        return yaml.refuse(node.place, &path, format!("names `{a}` twice"), format!("give {ALLOWED}"));
    }
    Some(if a < b { [a, b] } else { [b, a] })
}

/// The path of a parameter on a scale.
fn key(yaml: &mut YamlReader, node: &YamlNode, path: &str, subject: Option<Subject>) -> Option<String> {
    let name = yaml.text(node, path, "the path of a key, for instance camera.tilt_deg")?;
    let Some(parameter) = keys::parameter(subject, name) else {
        let problem = format!("`{}` is no key that is drawn", clipped_text(name));
        return yaml.refuse(node.place, path, problem, meant(subject, name));
    };
    if parameter.integer {
        let problem = format!("`{name}` is a count, whose ranks have ties");
        let remedy = "correlate a key on a scale, or give each kind of sample a class";
        return yaml.refuse(node.place, path, problem, remedy);
    }
    Some(name.to_owned())
}

/// What to give in place of `name`, which is no parameter of `subject`.
fn meant(subject: Option<Subject>, name: &str) -> String {
    let (section, last) = name.rsplit_once('.').unwrap_or(("", name));
    if keys::settings(None).any(|setting| setting.path == name) {
        return "it is the same for all samples: name two keys that are drawn".to_owned();
    }
    if let Some(alternative) = ALTERNATIVES.iter().find(|known| known.section == section && known.name == last) {
        let of: Vec<_> = alternative.of.iter().map(|key| format!("`{section}.{key}`")).collect();
        return format!("it stands for {}: name that", of.join(" and "));
    }
    if SECTIONS.iter().any(|known| known.path == name) {
        return format!("it is a section: name a key of it, for instance `{name}.KEY`");
    }
    let named: Vec<_> = keys::parameters(subject).filter(|parameter| parameter.name == last).collect();
    if let [parameter] = named.as_slice() {
        return format!("did you mean `{}`?", parameter.path());
    }
    if let Some(home) = keys::home(subject, last, &[]).filter(|_| keys::parameter(None, name).is_some()) {
        return home;
    }
    let paths: Vec<_> = keys::parameters(subject).map(Parameter::path).collect();
    let near = nearest_spelling(name, paths.iter().map(String::as_str));
    near.map_or_else(
        || "give the path of a key with its section, for instance `camera.tilt_deg`".to_owned(),
        |near| format!("did you mean `{near}`?"),
    )
}

/// Notes a fault of each pair of which one key is drawn for more samples than the other: the one is drawn before the
/// other is there. `of` says for what a key is drawn, and the key that makes it so, where one does.
pub(super) fn refuse_across(
    yaml: &mut YamlReader,
    pairs: &[WrittenPair],
    of: impl Fn(&str) -> (&'static str, Option<&'static str>),
) {
    for WrittenPair { place, pair } in pairs {
        let [a, b] = &pair.keys;
        let ((for_a, why_a), (for_b, why_b)) = (of(a), of(b));
        if let Some(why) = why_a.or(why_b).filter(|_| for_a != for_b) {
            let problem = format!("`{a}` is drawn once for {for_a} and `{b}` once for {for_b}");
            yaml.fault(*place, CORRELATIONS, problem, format!("correlate keys of one of both, or remove `{why}`"));
        }
    }
}

/// Mixtures of the scores for each of `classes`; pairs without an effect and pairs that cannot be together are noted as
/// faults.
pub(super) fn mixtures(
    yaml: &mut YamlReader,
    pairs: &[WrittenPair],
    subject: Option<Subject>,
    base: &BTreeMap<String, Distribution>,
    classes: &[SampleClass],
) -> Vec<ScoreMixture> {
    let keys: BTreeSet<&String> = pairs.iter().flat_map(|written| &written.pair.keys).collect();
    let is_drawn = |class: &SampleClass, path: &String| {
        let distribution = class.overrides.get(path).or_else(|| base.get(path));
        keys::parameter(subject, path).zip(distribution).is_some_and(|(parameter, own)| own.is_on_a_scale(parameter))
    };
    // By class, the keys that are drawn on a scale there.
    let drawn: Vec<BTreeSet<&String>> =
        classes.iter().map(|class| keys.iter().copied().filter(|key| is_drawn(class, key)).collect()).collect();
    let acts =
        |drawn: &BTreeSet<&String>, written: &WrittenPair| written.pair.keys.iter().all(|key| drawn.contains(key));
    for written in pairs {
        // What a key with a fault of its own would draw is open.
        let open = classes.is_empty() || written.pair.keys.iter().any(|key| yaml.has_fault_of(key));
        if open || drawn.iter().any(|drawn| acts(drawn, written)) {
            continue;
        }
        let [a, b] = &written.pair.keys;
        let never = [a, b].into_iter().find(|key| !drawn.iter().any(|drawn| drawn.contains(key)));
        let problem = match never {
            Some(key) => format!("has no effect: `{key}` is fixed or a choice in every class"),
            None => format!("has no effect: no class draws both `{a}` and `{b}`"),
        };
        let remedy = match never {
            Some(key) => format!("give `{key}` a distribution on a scale, for instance `uniform`, or remove the pair"),
            None => "give one class distributions of both, or remove the pair".to_owned(),
        };
        yaml.fault(written.place, CORRELATIONS, problem, remedy);
    }
    let mut told = BTreeSet::new();
    let mut all = Vec::new();
    for drawn in &drawn {
        let active: Vec<_> = pairs.iter().filter(|written| acts(drawn, written)).collect();
        let mut mixture = ScoreMixture::default();
        for keys in connected(&active) {
            let inside: Vec<_> =
                active.iter().copied().filter(|written| keys.contains(&written.pair.keys[0])).collect();
            let matrix = ScoreMatrix::new(keys, &inside);
            match factor(&matrix.entries) {
                Some(rows) => mixture.0.extend(matrix.weights(&rows)),
                None if told.insert(matrix.keys.clone()) => matrix.refuse(yaml, &inside),
                None => {}
            }
        }
        all.push(mixture);
    }
    all
}

/// The keys of `pairs` that hang together, in groups, each in order.
fn connected(pairs: &[&WrittenPair]) -> Vec<Vec<String>> {
    let mut groups: Vec<BTreeSet<String>> = Vec::new();
    for written in pairs {
        let own: BTreeSet<String> = written.pair.keys.iter().cloned().collect();
        let (joined, apart): (Vec<_>, Vec<_>) = groups.into_iter().partition(|group| !group.is_disjoint(&own));
        groups = apart;
        groups.push(joined.into_iter().flatten().chain(own).collect());
    }
    groups.into_iter().map(|group| group.into_iter().collect()).collect()
}

/// Correlations of the normal scores of keys that hang together.
struct ScoreMatrix {
    keys: Vec<String>,
    /// [keys, keys], symmetric, 1 on the diagonal.
    entries: Vec<Vec<f64>>,
}

impl ScoreMatrix {
    fn new(keys: Vec<String>, pairs: &[&WrittenPair]) -> Self {
        let mut matrix = Self { entries: vec![vec![0.0; keys.len()]; keys.len()], keys };
        (0..matrix.keys.len()).for_each(|i| matrix.entries[i][i] = 1.0);
        for written in pairs {
            let [i, j] = matrix.places(&written.pair);
            (matrix.entries[i][j], matrix.entries[j][i]) = (written.pair.of_scores(), written.pair.of_scores());
        }
        matrix
    }

    fn places(&self, pair: &Correlation) -> [usize; 2] {
        [0, 1].map(|side| self.keys.iter().position(|key| *key == pair.keys[side]).unwrap_or(0))
    }

    /// The rows of a factor by key, without what is 0.
    fn weights(&self, rows: &[Vec<f64>]) -> BTreeMap<String, Vec<(String, f64)>> {
        let row = |row: &[f64]| {
            let terms = self.keys.iter().zip(row).filter(|(_, weight)| **weight != 0.0);
            terms.map(|(key, weight)| (key.clone(), *weight)).collect()
        };
        self.keys.iter().zip(rows).map(|(key, weights)| (key.clone(), row(weights))).collect()
    }

    /// Notes that the pairs cannot be together: at the written pair that has to change least for it, or at the last; a
    /// pair that is not written can be what is missing.
    fn refuse(&self, yaml: &mut YamlReader, pairs: &[&WrittenPair]) {
        let Some(last) = pairs.last() else { return };
        let written = |at: [usize; 2]| pairs.iter().find(|pair| self.places(&pair.pair) == at);
        let nearest = |is_written: bool| {
            let size = if self.keys.len() <= MAX_KEYS_OF_REMEDY { self.keys.len() } else { 0 };
            let all = (0..size).flat_map(|j| (0..j).map(move |i| [i, j]));
            let ranges =
                all.filter(|at| written(*at).is_some() == is_written).filter_map(|at| Some((at, self.range(at)?)));
            let far = |([i, j], [low, high]): &([usize; 2], [f64; 2])| {
                let now = spearman(self.entries[*i][*j]);
                (low - now).max(now - high)
            };
            ranges.min_by(|a, b| far(a).total_cmp(&far(b)))
        };
        let said = |[low, high]: [f64; 2]| format!("`spearman` from {} to {}", number_text(low), number_text(high));
        let (mut of, mut place, mut remedies) = ("it".to_owned(), last.place, Vec::new());
        if let Some((at, range)) = nearest(true)
            && let Some(WrittenPair { place: its_place, pair }) = written(at)
        {
            of = format!("{} of `{}` and `{}`", number_text(pair.spearman), pair.keys[0], pair.keys[1]);
            place = *its_place;
            remedies.push(format!("give this pair {}", said(range)));
        }
        if let Some(([i, j], range)) = nearest(false) {
            remedies.push(format!("give `{}` and `{}` a pair too, {}", self.keys[i], self.keys[j], said(range)));
        }
        if remedies.is_empty() {
            let factor = number_text(self.common_factor());
            remedies.push(format!("multiply `spearman` of each of them by {factor} or less"));
        }
        let names: Vec<_> = self.keys.iter().map(|key| format!("`{key}`")).collect();
        let names = if names.len() > 6 { format!("{} and others", names[..5].join(", ")) } else { names.join(", ") };
        let problem = format!("{of} cannot be together with the other pairs of {names}: no numbers have all of them");
        yaml.fault(place, CORRELATIONS, problem, remedies.join(", or "));
    }

    /// The rank correlations that the keys at two places may have beside all others, rounded inwards; `None` where
    /// there are none.
    ///
    /// Given the other keys, the two have the variances s_a and s_b, and without a correlation of their own the
    /// covariance -c: the matrix is positive semi-definite where |r - c| is at most sqrt(s_a s_b) (Schur's complement).
    fn range(&self, [a, b]: [usize; 2]) -> Option<[f64; 2]> {
        let others: Vec<_> = (0..self.keys.len()).filter(|k| *k != a && *k != b).collect();
        let inner: Vec<Vec<f64>> =
            others.iter().map(|i| others.iter().map(|j| self.entries[*i][*j]).collect()).collect();
        let lower = factor(&inner)?;
        let solved = |of: usize| {
            let mut y: Vec<f64> = Vec::new();
            for (row, k) in lower.iter().zip(&others) {
                let rest = self.entries[of][*k] - row.iter().zip(&y).map(|(weight, y)| weight * y).sum::<f64>();
                let pivot = row[y.len()];
                y.push(if pivot > 0.0 { rest / pivot } else { 0.0 });
            }
            y
        };
        let (at_a, at_b) = (solved(a), solved(b));
        let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
        let (left_a, left_b) = (1.0 - dot(&at_a, &at_a), 1.0 - dot(&at_b, &at_b));
        if left_a < MIN_VARIANCE || left_b < MIN_VARIANCE {
            return None;
        }
        let (middle, half) = (dot(&at_a, &at_b), (left_a * left_b).sqrt());
        let (low, high) = (spearman(middle - half), spearman(middle + half));
        for steps in [1e2, 1e4] {
            let rounded = [
                ((low * steps).ceil() / steps).max(1.0 / steps - 1.0),
                ((high * steps).floor() / steps).min(1.0 - 1.0 / steps),
            ];
            if rounded[0] <= rounded[1] {
                return Some(rounded.map(|end| end + 0.0));
            }
        }
        None
    }

    /// By how much all rank correlations are to be multiplied, rounded down.
    fn common_factor(&self) -> f64 {
        let fits = |share: f64| {
            let lower = |r: f64| if r == 1.0 { 1.0 } else { pearson(share * spearman(r)) };
            let entries: Vec<Vec<f64>> =
                self.entries.iter().map(|row| row.iter().map(|r| lower(*r)).collect()).collect();
            factor(&entries).is_some()
        };
        (1..100).rev().map(|share| f64::from(share) / 100.0).find(|share| fits(*share)).unwrap_or(0.0)
    }
}

/// Cholesky's lower factor of a symmetric matrix with 1 on its diagonal, each row of length 1; `None` where it is not
/// positive semi-definite. A key that follows from those before it has 0 on the diagonal.
fn factor(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for (i, entries) in matrix.iter().enumerate() {
        let mut row = vec![0.0; matrix.len()];
        for j in 0..i {
            let rest = entries[j] - (0..j).map(|k| row[k] * rows[j][k]).sum::<f64>();
            if rows[j][j] > 0.0 {
                row[j] = rest / rows[j][j];
            } else if rest.abs() > MIN_VARIANCE.sqrt() {
                return None;
            }
        }
        let left = 1.0 - row.iter().map(|weight| weight * weight).sum::<f64>();
        if left < -MIN_VARIANCE {
            return None;
        }
        row[i] = if left > MIN_VARIANCE { left.sqrt() } else { 0.0 };
        let length = row.iter().map(|weight| weight * weight).sum::<f64>().sqrt();
        row.iter_mut().for_each(|weight| *weight /= length);
        rows.push(row);
    }
    Some(rows)
}

#[cfg(test)]
mod tests;
