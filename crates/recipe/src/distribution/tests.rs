//! Quantiles against the laws, for random distributions of every form.

use super::*;
use crate::constraints::needs;
use crate::keys;
use exact::{UnitHistogram, kolmogorov_smirnov, likelihood_ratio, likelihood_ratio_chance};

/// How one number is drawn.
pub(crate) enum DrawLaw {
    /// Always the same.
    Fixed(f64),
    /// One of some numbers, ascending, each with its chance above 0; the chances sum to 1.
    Discrete(Vec<(f64, f64)>),
    /// Any number between two, with the distribution function: 0 at the smallest, 1 at the largest.
    Continuous { min: f64, max: f64, cdf: Box<dyn Fn(f64) -> f64> },
}

impl Distribution {
    /// The law of [`Self::draw`] for `parameter`.
    ///
    /// A draw is a sample, rounded where the parameter is a count, that was made again until it lay within the bounds:
    /// so the law is that of the samples, cut at the bounds.
    pub(crate) fn law(&self, parameter: &Parameter) -> DrawLaw {
        let (min, max) = self.bounds(parameter);
        if min >= max {
            return DrawLaw::Fixed(min);
        }
        let of = self.untruncated();
        let mut cells = match of.weighed(parameter.integer) {
            Some(cells) => cells,
            None if parameter.integer => {
                let count = |i: u64| min + i as f64;
                let chance = |k: f64| of.mass(k - 0.5, k + 0.5, 0.5);
                (0..=(max - min) as u64).map(|i| (count(i), chance(count(i)))).collect()
            }
            None => {
                assert!(self.is_on_a_scale(parameter));
                let (of, inside) = (of.clone(), of.mass(min, max, 0.0));
                let below = Box::new(move |x: f64| (of.mass(min, x, 0.0) / inside).clamp(0.0, 1.0));
                return DrawLaw::Continuous { min, max, cdf: below };
            }
        };
        assert!(!self.is_on_a_scale(parameter));
        // The sum takes the sign from -0.
        cells.iter_mut().for_each(|cell| cell.0 += 0.0);
        cells.retain(|(value, chance)| (min..=max).contains(value) && *chance > 0.0);
        cells.sort_by(|a, b| a.0.total_cmp(&b.0));
        cells.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 += next.1;
            }
            same
        });
        let sum: f64 = cells.iter().map(|cell| cell.1).sum();
        match cells.as_slice() {
            [(value, _)] => DrawLaw::Fixed(*value),
            _ => DrawLaw::Discrete(cells.into_iter().map(|(value, chance)| (value, chance / sum)).collect()),
        }
    }
}

const REAL: Parameter = Parameter {
    group: "test",
    name: "x",
    min: -20.0,
    max: 30.0,
    default: 0.0,
    integer: false,
    doc: "",
    source: "",
    natural: Natural::Fixed,
    conditions: &[],
};
const COUNT: Parameter = Parameter { min: 0.0, max: 25.0, integer: true, ..REAL };

/// Random distributions of every form, of which at least 1 % lies within the bounds, with their parameters.
fn every_form(seed: u64) -> Vec<(Distribution, Parameter)> {
    let mut rng = Stream::root(seed).child("forms").rng();
    let mut number = |min: f64, max: f64| between(min, max, &mut rng);
    let mut all = Vec::new();
    for parameter in [REAL, COUNT] {
        let whole = |x: f64| if parameter.integer { x.round() } else { x };
        let mut ends = |from: f64, to: f64| {
            let (a, b) = (whole(number(from, to)), whole(number(from, to)));
            (a.min(b), a.max(b))
        };
        let least = if parameter.integer { 1.0 } else { 1e-3 };
        let (min, max) = ends(parameter.min, parameter.max);
        let uniform = Distribution::Uniform { min, max };
        let (min, max) = ends(least, parameter.max);
        let log_uniform = Distribution::LogUniform { min, max };
        let cut = ends(parameter.min, parameter.max);
        let normal = Distribution::Normal { mean: number(-5.0, 20.0), sd: number(0.1, 12.0) };
        let lognormal = Distribution::Lognormal { median: number(0.5, 20.0), log_sd: number(0.05, 2.0) };
        let values: Vec<f64> = (0..7).map(|_| whole(number(parameter.min, parameter.max))).collect();
        let weights = (0..7).map(|i| if i == 3 { 0.0 } else { number(0.0, 3.0) }).collect();
        let choice = Distribution::Choice { values, weights };
        let plain = [Distribution::Fixed(3.0), uniform, log_uniform, normal, lognormal, choice];
        for of in plain {
            let (min, max) = cut;
            let truncated = Distribution::Truncated { of: Box::new(of.clone()), min, max };
            all.extend([of, truncated].map(|form| (form, parameter)));
        }
    }
    all.retain(|(form, parameter)| form.chance_inside(parameter) >= MIN_CHANCE);
    all
}

#[test]
fn quantiles_are_the_inverse_of_the_law() {
    let (mut continuous, mut discrete) = (0, 0);
    for (form, parameter) in (0..300).flat_map(every_form) {
        let (min, max) = form.bounds(&parameter);
        let mut last = f64::MIN;
        for step in 0..=50 {
            let u = f64::from(step) / 50.0;
            let x = form.quantile(&parameter, u);
            assert!((min..=max).contains(&x) && x >= last, "{form:?}: {x} at {u}, {last} before");
            last = x;
            match form.law(&parameter) {
                DrawLaw::Fixed(value) => assert_eq!(x, value, "{form:?}"),
                DrawLaw::Continuous { cdf, .. } => {
                    // An x off by its own rounding changes F by that times the density; at most 1 % of a form is left
                    // by its cuts.
                    let near = 4.0 * f64::EPSILON * x.abs().max(1.0);
                    let slack = 1e-12 + (cdf(x + near) - cdf(x - near)).abs();
                    assert!((cdf(x) - u).abs() <= slack, "{form:?}: {} below {x}, for {u}", cdf(x));
                    continuous += 1;
                }
                DrawLaw::Discrete(cells) => {
                    assert!(x.to_bits() != (-0.0f64).to_bits(), "{form:?}");
                    let below: f64 = cells.iter().filter(|cell| cell.0 < x).map(|cell| cell.1).sum();
                    let own = cells.iter().find(|cell| cell.0 == x).unwrap_or_else(|| panic!("{form:?}: {x}")).1;
                    assert!(below - 1e-12 <= u && u <= below + own + 1e-12, "{form:?}: {x} at {u}");
                    discrete += 1;
                }
            }
        }
    }
    assert!(continuous > 50_000 && discrete > 50_000, "{continuous} {discrete}");
}

/// The chance that numbers are as far from a law as these.
pub(crate) fn chance(law: &DrawLaw, numbers: &[f64]) -> f64 {
    match law {
        DrawLaw::Fixed(value) => f64::from(numbers.iter().all(|x| x == value)),
        DrawLaw::Continuous { cdf, .. } => {
            let mut histogram = UnitHistogram::default();
            numbers.iter().for_each(|x| histogram.add(cdf(*x)));
            kolmogorov_smirnov(histogram.samples(), histogram.distance())
        }
        DrawLaw::Discrete(cells) => {
            let count = |cell: &(f64, f64)| numbers.iter().filter(|x| **x == cell.0).count() as u64;
            let counts: Vec<u64> = cells.iter().map(count).collect();
            assert_eq!(counts.iter().sum::<u64>(), numbers.len() as u64, "numbers that are never drawn");
            let chances: Vec<f64> = cells.iter().map(|cell| cell.1).collect();
            likelihood_ratio_chance(likelihood_ratio(&counts, &chances), cells.len())
        }
    }
}

/// 4000 quantiles at independent numbers follow the law, as draws do.
#[test]
fn quantiles_and_draws_have_one_law() {
    // Some 130 tests of two ways.
    const ALPHA: f64 = 1e-8;
    for (form, parameter) in (0..6).flat_map(every_form) {
        let law = form.law(&parameter);
        let key = |i: u64| Stream::root(9).child("test.x").index(i);
        let drawn: Vec<f64> = (0..4000).map(|i| form.draw(&parameter, key(i)) + 0.0).collect();
        let quantiles: Vec<f64> = (0..4000).map(|i| form.quantile(&parameter, key(i).rng().random())).collect();
        for numbers in [drawn, quantiles] {
            let p = chance(&law, &numbers);
            assert!(p > ALPHA, "{form:?}: chance {p:e}");
        }
    }
}

/// A natural distribution lies where the parameter may, can be the default, and is read again from its canonical form.
#[test]
fn natural_distributions_are_in_range_and_can_be_the_default() {
    let mut varied = 0;
    for parameter in keys::parameters(None) {
        let (path, natural) = (parameter.path(), Distribution::natural(parameter));
        let (low, high) = natural.bounds(parameter);
        assert!((low..=high).contains(&parameter.default), "{path}: {low} to {high}, default {}", parameter.default);
        let ends = parameter.natural.ends();
        assert_eq!(ends.unwrap_or([parameter.default; 2]), [low, high], "{path}");
        if ends.is_some() {
            varied += 1;
            assert!(low < high, "{path} does not vary");
            assert!(!natural.is_log() || low > 0.0, "{path}");
        }
        if let Natural::OneOf(values) = parameter.natural {
            assert!(values.is_sorted(), "{path}");
        }
    }
    assert!(varied > 180, "{varied} of them vary");
}

/// What is off by default stays off: an amount of 0 that others need to mean something does not vary.
#[test]
fn what_is_off_by_default_does_not_vary() {
    let needs = || keys::parameters(None).flat_map(|parameter| parameter.conditions).map(|condition| condition.need);
    let mut amounts: Vec<_> = needs().flat_map(needs::deciders).collect();
    amounts.sort_unstable();
    amounts.dedup();
    let off = |path: &&str| keys::parameter(None, path).is_some_and(|parameter| parameter.default == 0.0);
    for path in amounts.into_iter().filter(off).filter(|path| *path != "tablet.shape") {
        let natural = keys::parameter(None, path).map(|parameter| parameter.natural);
        assert_eq!(natural, Some(Natural::Fixed), "{path}");
    }
    let counts = keys::parameters(None).filter(|parameter| parameter.group == "defects" && parameter.integer);
    counts.for_each(|count| assert_eq!(count.natural, Natural::Fixed, "{}", count.name));
}
