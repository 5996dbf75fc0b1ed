//! Distributions of one number: the forms, how they are read and sampled, where they can reach, how much falls in a
//! range, the law of the draws and its quantiles.
//!
//! | form | density or chance | source |
//! |---|---|---|
//! | fixed v | always v | |
//! | uniform [a, b] | 1 / (b - a) | |
//! | log_uniform [a, b] | 1 / (x ln(b / a)) | Hamming 1970: the prior of a scale |
//! | normal (m, s) | exp(-(x - m)^2 / 2 s^2) / (s sqrt(2 pi)) | Gauss; polar method of Marsaglia and Bray 1964 |
//! | lognormal (m, s) | normal of ln x about ln m | Limpert, Stahel, Abbt 2001: m is the median |
//! | choice (v, w) | w_i / sum w for v_i | |
//!
//! Every draw is made again until it lies within the bounds of [`Distribution::bounds`]. Normal and lognormal are cut
//! at eight standard deviations, beyond which one of 10^15 draws would lie, so that each distribution has bounds on
//! which the checks between parameters can rely. Counts: the continuous forms are rounded to the nearest whole number;
//! uniform and log-uniform reach half a number further first, so that a uniform count takes each of its numbers equally
//! often.
//!
//! [`Distribution::quantile`] draws the same law in another way: it turns one number u of [0, 1] into the one below
//! which the share u of the draws lies (Devroye 1986, *Non-Uniform Random Variate Generation*, II.2), cut at the bounds
//! without a draw again. With F the distribution function of the form it is F^-1(F(min) + u (F(max) - F(min))). It
//! rises with u, which correlations ([`super::correlation`]) and low-discrepancy sampling ([`super::sampling`]) rest
//! on. Both ways have one law, and not the same numbers.
//!
//! A new form is a variant of [`Distribution`] with draw, quantile, bounds and mass, and a row of `FORMS`.
//! `schema.rs` has its arguments, `canonical.rs` its canonical form. `every_form` of the tests holds its quantile to
//! its law.

use base::{Natural, Parameter, Stream, normal};
use rand::{Rng, RngExt};

use super::keys::unit;
use numerics::chance::{normal_below, normal_quantile};
use yaml::{Mapping, NumberRange, YamlNode, YamlReader, YamlValue, clipped_text, nearest_spelling, number_text};

/// Cut of normal and lognormal [standard deviations].
const CUT_SD: f64 = 8.0;
/// Least chance that a draw lies within the bounds; below it the recipe is at fault.
const MIN_CHANCE: f64 = 0.01;
/// Draws before the nearest bound is taken; with the least chance that happens once in 10^43 samples.
const MAX_ATTEMPTS: usize = 10_000;

/// Largest magnitude of an argument that the parameter's own range does not bound.
const MAX_ARGUMENT: f64 = 1e9;
/// Largest standard deviation of a logarithm: a factor of e^20 = 5e8 is beyond every parameter's range.
const MAX_LOG_SD: f64 = 20.0;
/// Most values of a choice.
const MAX_VALUES: usize = 1000;

/// A form of distributions as people meet it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Form {
    /// Its key.
    pub key: &'static str,
    /// How it is written.
    pub example: &'static str,
    /// What it draws.
    pub law: &'static str,
    /// Where it comes from.
    pub source: &'static str,
}

/// Every form; a plain number is the seventh.
pub(super) const FORMS: [Form; 6] = [
    Form {
        key: "uniform",
        example: "{uniform: [a, b]}",
        law: "p(x) = 1 / (b - a) on [a, b]; counts: every whole number of [a, b] with equal chance",
        source: "",
    },
    Form {
        key: "log_uniform",
        example: "{log_uniform: [a, b]}",
        law: "p(x) = 1 / (x ln(b / a)) on [a, b], 0 < a",
        source: "Hamming 1970",
    },
    Form {
        key: "normal",
        example: "{normal: {mean: m, sd: s}}",
        law: "p(x) = exp(-(x - m)^2 / 2 s^2) / (s sqrt(2 pi)), cut at 8 s",
        source: "Marsaglia and Tsang 2000",
    },
    Form {
        key: "lognormal",
        example: "{lognormal: {median: m, log_sd: s}}",
        law: "ln x is normal with mean ln m and standard deviation s, cut at 8 s",
        source: "Limpert, Stahel and Abbt 2001",
    },
    Form {
        key: "choice",
        example: "{choice: {values: [v, ...], weights: [w, ...]}}",
        law: "v_i with chance w_i / sum w; without weights all alike",
        source: "",
    },
    Form {
        key: "truncated",
        example: "{truncated: {of: {...}, min: a, max: b}}",
        law: "another form, drawn again until it lies in [a, b]; a missing end is the parameter's own",
        source: "",
    },
];

/// The keys of [`FORMS`].
pub(super) fn form_keys() -> [&'static str; FORMS.len()] {
    FORMS.map(|form| form.key)
}

/// A distribution of one number, its arguments checked.
#[derive(Debug, Clone, PartialEq)]
pub enum Distribution {
    /// Always the same number.
    Fixed(f64),
    /// Even between two numbers; for counts, every whole number with equal chance.
    Uniform {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// Even in the logarithm.
    LogUniform {
        /// Smallest, above 0.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// Gaussian.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation, 0 or more.
        sd: f64,
    },
    /// Gaussian in the logarithm.
    Lognormal {
        /// Median, above 0.
        median: f64,
        /// Standard deviation of the natural logarithm, 0 or more.
        log_sd: f64,
    },
    /// Some numbers with their weights.
    Choice {
        /// The numbers, at least one.
        values: Vec<f64>,
        /// Their weights, 0 or more, not all 0.
        weights: Vec<f64>,
    },
    /// Another distribution, drawn again until it lies between two numbers.
    Truncated {
        /// The other distribution, not truncated itself.
        of: Box<Distribution>,
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
}

impl Distribution {
    /// What `parameter` is drawn from by nature ([`Natural`]); always its default where that does not vary.
    pub fn natural(parameter: &Parameter) -> Self {
        match parameter.natural {
            Natural::Fixed => Self::Fixed(parameter.default),
            Natural::Uniform { min, max } => Self::Uniform { min, max },
            Natural::LogUniform { min, max } => Self::LogUniform { min, max },
            Natural::Normal { mean, sd } => {
                let [min, max] = [-1.0, 1.0].map(|side| mean + side * Natural::CUT_SD * sd);
                Self::Truncated { of: Box::new(Self::Normal { mean, sd }), min, max }
            }
            Natural::OneOf(values) => Self::Choice { values: values.to_vec(), weights: vec![1.0; values.len()] },
        }
    }

    /// The law of `factor` times what this one draws; the factor is above 0.
    pub(super) fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Fixed(value) => Self::Fixed(value * factor),
            Self::Uniform { min, max } => Self::Uniform { min: min * factor, max: max * factor },
            Self::LogUniform { min, max } => Self::LogUniform { min: min * factor, max: max * factor },
            Self::Normal { mean, sd } => Self::Normal { mean: mean * factor, sd: sd * factor },
            Self::Lognormal { median, log_sd } => Self::Lognormal { median: median * factor, log_sd },
            Self::Choice { values, weights } => {
                Self::Choice { values: values.into_iter().map(|value| value * factor).collect(), weights }
            }
            Self::Truncated { of, min, max } => {
                Self::Truncated { of: Box::new(of.scaled(factor)), min: min * factor, max: max * factor }
            }
        }
    }

    /// A draw for `parameter` from the start of `stream`, within [`Self::bounds`].
    pub fn draw(&self, parameter: &Parameter, stream: Stream) -> f64 {
        let (min, max) = self.bounds(parameter);
        let mut rng = stream.rng();
        for _ in 0..MAX_ATTEMPTS {
            let value = self.sample(parameter.integer, &mut rng);
            if (min..=max).contains(&value) {
                return value;
            }
        }
        min
    }

    /// The number for `parameter` below which the share `u`, from 0 to 1, of the draws lies: of discrete laws the first
    /// value up to which more than that share lies. It rises with `u` and stays within [`Self::bounds`].
    pub fn quantile(&self, parameter: &Parameter, u: f64) -> f64 {
        let (min, max) = self.bounds(parameter);
        if min >= max {
            return min;
        }
        let of = self.untruncated();
        if let Some(mut cells) = of.weighed(parameter.integer) {
            cells.retain(|(value, _)| (min..=max).contains(value));
            cells.sort_by(|a, b| a.0.total_cmp(&b.0));
            let weights: Vec<f64> = cells.iter().map(|cell| cell.1).collect();
            // The sum takes the sign from -0.
            return cells.get(pick(&weights, u)).map_or(min, |cell| cell.0 + 0.0);
        }
        let half = if parameter.integer { 0.5 } else { 0.0 };
        let value = of.quantile_between(min - half, max + half, half, u);
        let value = if parameter.integer { value.round() + 0.0 } else { value };
        value.clamp(min, max)
    }

    /// Smallest and largest draw for `parameter`.
    pub fn bounds(&self, parameter: &Parameter) -> (f64, f64) {
        let (min, max) = self.reach();
        let whole = |x: f64| if parameter.integer { x.round() } else { x };
        (whole(min).max(parameter.min), whole(max).min(parameter.max))
    }

    /// Chance that a sample for `parameter` lies in its range, and between the bounds where truncated.
    pub(crate) fn chance_inside(&self, parameter: &Parameter) -> f64 {
        let half = if parameter.integer { 0.5 } else { 0.0 };
        match self {
            Self::Truncated { of, min, max } => {
                of.mass(min.max(parameter.min) - half, max.min(parameter.max) + half, half)
            }
            other => other.mass(parameter.min - half, parameter.max + half, half),
        }
    }

    /// The only numbers that can come out, where they are few.
    pub fn values(&self) -> Option<Vec<f64>> {
        match self {
            Self::Fixed(value) => Some(vec![*value]),
            Self::Choice { values, .. } => Some(values.clone()),
            Self::Truncated { of, min, max } => {
                of.values().map(|all| all.into_iter().filter(|value| (min..=max).contains(&value)).collect())
            }
            _ => None,
        }
    }

    /// One sample before any bound is asked.
    fn sample(&self, count: bool, rng: &mut impl Rng) -> f64 {
        let half = if count { 0.5 } else { 0.0 };
        let value = match self {
            Self::Fixed(value) => *value,
            Self::Uniform { min, max } => between(min - half, max + half, rng),
            Self::LogUniform { min, max } => libm::exp(between(libm::log(min - half), libm::log(max + half), rng)),
            Self::Normal { mean, sd } => mean + sd * normal(rng),
            Self::Lognormal { median, log_sd } => median * libm::exp(log_sd * normal(rng)),
            Self::Choice { values, weights } => values[pick(weights, rng.random())],
            Self::Truncated { of, .. } => of.sample(count, rng),
        };
        if count { value.round() } else { value }
    }

    /// The sample of a form on a scale below which the share `u` of those from `low` to `high` lies; `half` as in
    /// [`Self::mass`].
    fn quantile_between(&self, low: f64, high: f64, half: f64, u: f64) -> f64 {
        let even = |from: f64, to: f64| from + (to - from) * u;
        match self {
            Self::Uniform { min, max } => even(low.max(min - half), high.min(max + half)),
            Self::LogUniform { min, max } => {
                libm::exp(even(libm::log(low.max(min - half)), libm::log(high.min(max + half))))
            }
            Self::Normal { mean, sd } => mean + sd * score_between((low - mean) / sd, (high - mean) / sd, u),
            Self::Lognormal { median, log_sd } => {
                let score = |x: f64| if x > 0.0 { libm::log(x / median) / log_sd } else { f64::NEG_INFINITY };
                median * libm::exp(log_sd * score_between(score(low), score(high), u))
            }
            Self::Truncated { .. } | Self::Fixed(_) | Self::Choice { .. } => low,
        }
    }

    /// The distribution without its cuts, where it is truncated: the bounds have them.
    fn untruncated(&self) -> &Self {
        match self {
            Self::Truncated { of, .. } => of,
            other => other,
        }
    }

    /// Smallest and largest sample that counts.
    fn reach(&self) -> (f64, f64) {
        match self {
            Self::Fixed(value) => (*value, *value),
            Self::Uniform { min, max } | Self::LogUniform { min, max } => (*min, *max),
            Self::Normal { mean, sd } => (mean - CUT_SD * sd, mean + CUT_SD * sd),
            Self::Lognormal { median, log_sd } => {
                (median * libm::exp(-CUT_SD * log_sd), median * libm::exp(CUT_SD * log_sd))
            }
            Self::Choice { values, weights } => {
                let possible = values.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
                possible.fold((f64::MAX, f64::MIN), |(min, max), (value, _)| (min.min(*value), max.max(*value)))
            }
            Self::Truncated { of, min, max } => {
                let (low, high) = of.reach();
                (low.max(*min), high.min(*max))
            }
        }
    }

    /// Share of the samples from `low` to `high`; `half` is how far uniform and log-uniform reach beyond their ends.
    fn mass(&self, low: f64, high: f64, half: f64) -> f64 {
        let inside = |x: f64| if (low..=high).contains(&x) { 1.0 } else { 0.0 };
        match self {
            Self::Fixed(value) => inside(*value),
            Self::Uniform { min, max } => overlap(min - half, max + half, low, high),
            Self::LogUniform { min, max } => {
                let ln = |x: f64| libm::log(x.max(f64::MIN_POSITIVE));
                overlap(ln(min - half), ln(max + half), ln(low), ln(high))
            }
            Self::Normal { mean, sd: 0.0 } => inside(*mean),
            Self::Normal { mean, sd } => normal_below((high - mean) / sd) - normal_below((low - mean) / sd),
            Self::Lognormal { median, log_sd: 0.0 } => inside(*median),
            Self::Lognormal { median, log_sd } => {
                let below = |x: f64| if x > 0.0 { normal_below(libm::log(x / median) / log_sd) } else { 0.0 };
                below(high) - below(low)
            }
            Self::Choice { values, weights } => {
                let total: f64 = weights.iter().sum();
                values.iter().zip(weights).map(|(value, weight)| inside(*value) * weight).sum::<f64>() / total
            }
            Self::Truncated { of, min, max } => of.mass(low.max(*min), high.min(*max), half),
        }
    }

    /// Whether draws for `parameter` lie on a scale: they are neither counts, nor always the same, nor a choice.
    pub fn is_on_a_scale(&self, parameter: &Parameter) -> bool {
        let (min, max) = self.bounds(parameter);
        min < max && !parameter.integer && !matches!(self.untruncated(), Self::Choice { .. })
    }

    /// Whether draws are best seen in a logarithmic scale.
    pub fn is_log(&self) -> bool {
        matches!(self.untruncated(), Self::LogUniform { .. } | Self::Lognormal { .. })
    }

    /// The numbers of a choice with their weights; `None` where it is none.
    fn weighed(&self, count: bool) -> Option<Vec<(f64, f64)>> {
        match self {
            Self::Choice { values, weights } => {
                let whole = |value: f64| if count { value.round() } else { value };
                Some(values.iter().map(|value| whole(*value)).zip(weights.iter().copied()).collect())
            }
            _ => None,
        }
    }
}

/// Even between `min` and `max`.
fn between(min: f64, max: f64, rng: &mut impl Rng) -> f64 {
    min + (max - min) * rng.random::<f64>()
}

/// The normal score below which the share `u` of those from `low` to `high` lies. It is looked for from the nearer end,
/// where shares have all their digits.
fn score_between(low: f64, high: f64, u: f64) -> f64 {
    let below = |low: f64, high: f64, u: f64| {
        let (from, to) = (normal_below(low), normal_below(high));
        from + u * (to - from)
    };
    let share = below(low, high, u);
    if share <= 0.5 { normal_quantile(share) } else { -normal_quantile(below(-high, -low, 1.0 - u)) }
}

/// Index into `weights` at the share `u` in [0, 1) of their sum; never one of weight 0.
fn pick(weights: &[f64], u: f64) -> usize {
    let mut rest = u * weights.iter().sum::<f64>();
    for (i, weight) in weights.iter().enumerate() {
        rest -= weight;
        if rest < 0.0 {
            return i;
        }
    }
    // Rounding can leave a last crumb of the sum, which belongs to the last weight that is not 0.
    weights.iter().rposition(|weight| *weight > 0.0).unwrap_or(0)
}

/// Share of [min, max] that [low, high] covers; a single point counts as a whole.
fn overlap(min: f64, max: f64, low: f64, high: f64) -> f64 {
    let (from, to) = (min.max(low), max.min(high));
    match (from <= to, max > min) {
        (false, _) => 0.0,
        (true, false) => 1.0,
        (true, true) => (to - from) / (max - min),
    }
}

/// The numbers that a parameter may take.
pub(super) fn range(parameter: &Parameter) -> NumberRange {
    NumberRange { min: parameter.min, max: parameter.max, whole: parameter.integer, unit: unit(parameter.name) }
}

/// Reads the number or distribution at `node`; faults are noted and give `None`.
pub(super) fn distribution(
    yaml: &mut YamlReader,
    node: &YamlNode,
    path: &str,
    parameter: &Parameter,
) -> Option<Distribution> {
    let range = range(parameter);
    let distribution = DistributionReader { yaml: &mut *yaml, range }.distribution(node, path, false)?;
    let chance = distribution.chance_inside(parameter);
    if chance < MIN_CHANCE {
        let problem = format!("only {:.2} % of its draws lie where they may", 100.0 * chance);
        return yaml.refuse(node.place, path, problem, format!("at least 1 % must; `{path}` is {range}"));
    }
    Some(distribution)
}

/// Reads the arguments of one distribution within `range`.
struct DistributionReader<'w, 't> {
    yaml: &'w mut YamlReader<'t>,
    range: NumberRange,
}

impl DistributionReader<'_, '_> {
    fn distribution(&mut self, node: &YamlNode, path: &str, nested: bool) -> Option<Distribution> {
        let range = self.range;
        let all_forms = || format!("{} or one of {{{}: ...}}", range, form_keys().join(": ...}, {"));
        match &node.value {
            YamlValue::Map(entries) => match entries.as_slice() {
                [(key, arguments)] => {
                    let path = format!("{path}.{}", clipped_text(&key.name));
                    match key.name.as_str() {
                        "uniform" => self.pair(arguments, &path).map(|(min, max)| Distribution::Uniform { min, max }),
                        "log_uniform" => self.log_uniform(arguments, &path),
                        "normal" => self.normal(arguments, &path),
                        "lognormal" => self.lognormal(arguments, &path),
                        "choice" => self.choice(arguments, &path),
                        "truncated" if !nested => self.truncated(arguments, &path),
                        "truncated" => {
                            let remedy = "truncate once, between the larger `min` and the smaller `max`";
                            self.yaml.refuse(key.place, &path, "truncates a truncated distribution", remedy)
                        }
                        unknown => {
                            let meant =
                                nearest_spelling(unknown, form_keys()).map(|form| format!("did you mean `{form}`? "));
                            let remedy = format!("{}give {}", meant.unwrap_or_default(), all_forms());
                            self.yaml.refuse(key.place, &path, "is no distribution", remedy)
                        }
                    }
                }
                _ => {
                    let problem = format!("is a map of {} keys, and a distribution has one", entries.len());
                    self.yaml.refuse(node.place, path, problem, format!("give {}", all_forms()))
                }
            },
            YamlValue::Number(_) | YamlValue::Text(_) => {
                self.yaml.number_in(node, path, self.range).map(Distribution::Fixed)
            }
            _ => self.yaml.refuse_kind(node, path, &all_forms()),
        }
    }

    /// `[min, max]`.
    fn pair(&mut self, node: &YamlNode, path: &str) -> Option<(f64, f64)> {
        let allowed = format!("[smallest, largest], each {}", self.range);
        let ends = self.yaml.list(node, path, &allowed)?;
        let [min, max] = ends else {
            return self.yaml.refuse(
                node.place,
                path,
                format!("is a list of {}", ends.len()),
                format!("give {allowed}"),
            );
        };
        let least = self.yaml.number_in(min, path, self.range);
        let most = self.yaml.number_in(max, path, self.range);
        self.ordered(node, path, least?, most?)
    }

    fn ordered(&mut self, node: &YamlNode, path: &str, min: f64, max: f64) -> Option<(f64, f64)> {
        if min <= max {
            return Some((min, max));
        }
        let problem = format!("smallest {} is over largest {}", number_text(min), number_text(max));
        self.yaml.refuse(node.place, path, problem, "swap them")
    }

    fn log_uniform(&mut self, node: &YamlNode, path: &str) -> Option<Distribution> {
        let (min, max) = self.pair(node, path)?;
        if min > 0.0 {
            return Some(Distribution::LogUniform { min, max });
        }
        let problem = format!("begins at {}", number_text(min));
        self.yaml.refuse(node.place, path, problem, "begin above 0, or take `uniform`")
    }

    fn normal(&mut self, node: &YamlNode, path: &str) -> Option<Distribution> {
        let [mean, sd] = self.arguments(node, path, [("mean", -MAX_ARGUMENT), ("sd", 0.0)])?;
        Some(Distribution::Normal { mean, sd })
    }

    fn lognormal(&mut self, node: &YamlNode, path: &str) -> Option<Distribution> {
        let [median, log_sd] = self.arguments(node, path, [("median", 1.0 / MAX_ARGUMENT), ("log_sd", 0.0)])?;
        if log_sd > MAX_LOG_SD {
            let problem = format!("{} is out of range", number_text(log_sd));
            let remedy = format!("`log_sd` is in natural logarithms, at most {MAX_LOG_SD}");
            return self.yaml.refuse(node.place, &format!("{path}.log_sd"), problem, remedy);
        }
        Some(Distribution::Lognormal { median, log_sd })
    }

    fn choice(&mut self, node: &YamlNode, path: &str) -> Option<Distribution> {
        let range = self.range;
        let mut section = self.yaml.mapping(node, path);
        let values = self.list(&mut section, "values", range);
        if values.is_none() {
            self.yaml.fault(node.place, path, "has no `values`", format!("give a list, each {range}"));
        }
        let weights =
            self.list(&mut section, "weights", NumberRange { min: 0.0, max: MAX_ARGUMENT, whole: false, unit: "" });
        self.close(section, &["values", "weights"]);
        let values = values??;
        let weights = weights.unwrap_or_else(|| Some(vec![1.0; values.len()]))?;
        let problem = if values.is_empty() || values.len() > MAX_VALUES {
            format!("has {} values", values.len())
        } else if weights.len() != values.len() {
            format!("has {} values and {} weights", values.len(), weights.len())
        } else if weights.iter().sum::<f64>() <= 0.0 {
            "has weights that sum to 0".to_owned()
        } else {
            return Some(Distribution::Choice { values, weights });
        };
        let remedy = format!("give 1 to {MAX_VALUES} values, and as many weights, not all 0, or none");
        self.yaml.refuse(node.place, path, problem, remedy)
    }

    fn truncated(&mut self, node: &YamlNode, path: &str) -> Option<Distribution> {
        let range = self.range;
        let mut section = self.yaml.mapping(node, path);
        let bound = |reader: &mut Self, section: &mut Mapping, name: &str, otherwise: f64| match section
            .take(reader.yaml, name)
        {
            Some(bound) => reader.yaml.number_in(bound, &section.path_of(name), range),
            None => Some(otherwise),
        };
        let min = bound(self, &mut section, "min", range.min);
        let max = bound(self, &mut section, "max", range.max);
        let inner = section.take(self.yaml, "of");
        self.close(section, &["of", "min", "max"]);
        let Some(inner) = inner else {
            return self.yaml.refuse(node.place, path, "has no `of`", "give the distribution to truncate");
        };
        let wide = NumberRange { min: -MAX_ARGUMENT, max: MAX_ARGUMENT, ..range };
        let of =
            DistributionReader { yaml: &mut *self.yaml, range: wide }.distribution(inner, &format!("{path}.of"), true);
        let (min, max) = self.ordered(node, path, min?, max?)?;
        Some(Distribution::Truncated { of: Box::new(of?), min, max })
    }

    /// Two numbers by name, each from a least one up.
    fn arguments(&mut self, node: &YamlNode, path: &str, names: [(&str, f64); 2]) -> Option<[f64; 2]> {
        let mut section = self.yaml.mapping(node, path);
        let [first, second] = names.map(|(name, min)| {
            let path = section.path_of(name);
            let range = NumberRange { min, max: MAX_ARGUMENT, whole: false, unit: self.range.unit };
            match section.take(self.yaml, name) {
                Some(argument) => self.yaml.number_in(argument, &path, range),
                None => self.yaml.refuse(node.place, &path, "is missing", format!("give {range}")),
            }
        });
        self.close(section, &names.map(|(name, _)| name));
        Some([first?, second?])
    }

    /// The list `name` of `section`: `None` where there is none, `Some(None)` where it is at fault.
    fn list(&mut self, section: &mut Mapping, name: &str, range: NumberRange) -> Option<Option<Vec<f64>>> {
        let path = section.path_of(name);
        let node = section.take(self.yaml, name)?;
        let Some(entries) = self.yaml.list(node, &path, &format!("a list, each {range}")) else { return Some(None) };
        let numbers: Vec<_> = entries.iter().map(|entry| self.yaml.number_in(entry, &path, range)).collect();
        Some(numbers.into_iter().collect())
    }

    fn close(&mut self, section: Mapping, known: &[&str]) {
        section.close(self.yaml, known, &|_| None);
    }
}

#[cfg(test)]
pub(crate) mod tests;
