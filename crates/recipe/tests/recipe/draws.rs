//! Purpose: draws follow their laws, depend on (recipe, seed, index) alone and stay put when other keys are edited.

use std::collections::{BTreeMap, BTreeSet};

use base::{Natural, Parameter, Stream};
use optical_bench::parameters::LampParameters;
use optical_bench::split::Split;
use rand::RngExt;
use recipe::{Distribution, Recipe, Scene, Subject, differences};

/// Draws in each test of a law.
const DRAWS: u64 = 40_000;
/// Chance that a right program fails any one statistical test here; about 20 of them are made.
const ALPHA: f64 = 1e-5;

const REAL: Parameter = Parameter {
    group: "test",
    name: "x",
    min: -1e6,
    max: 1e6,
    default: 0.0,
    integer: false,
    doc: "",
    source: "",
    natural: Natural::Fixed,
    conditions: &[],
};
const COUNT: Parameter = Parameter { min: 0.0, max: 40.0, integer: true, ..REAL };

fn wood() -> Recipe {
    Recipe::load("wood").expect("embedded")
}

/// A recipe of each subject.
fn subjects() -> [Recipe; 4] {
    let name = |name| if name == "mesh" { "mesh-small" } else { name };
    Subject::NAMES.map(|subject| Recipe::load(name(subject)).expect("embedded"))
}

fn draws(distribution: &Distribution, parameter: &Parameter) -> Vec<f64> {
    (0..DRAWS).map(|i| distribution.draw(parameter, Stream::root(0).child("test.x").index(i))).collect()
}

/// Kolmogorov and Smirnov: the largest distance of the empirical from the given distribution function.
fn follows(distribution: &Distribution, parameter: &Parameter, below: impl Fn(f64) -> f64) {
    let mut sorted = draws(distribution, parameter);
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let distance = sorted.iter().enumerate().map(|(i, x)| {
        let p = below(*x);
        (p - i as f64 / n).max((i + 1) as f64 / n - p)
    });
    let distance = distance.fold(0.0, f64::max);
    let critical = ((2.0 / ALPHA).ln() / (2.0 * n)).sqrt();
    assert!(distance < critical, "{distribution:?}: distance {distance}, critical {critical}");
}

/// Pearson: the squared deviations of counts from their expectations; `critical` is the 1 - ALPHA quantile.
fn chi_square(observed: &[f64], shares: &[f64], critical: f64) {
    let n: f64 = observed.iter().sum();
    let statistic: f64 = observed.iter().zip(shares).map(|(o, p)| (o - n * p).powi(2) / (n * p)).sum();
    assert!(statistic < critical, "{observed:?}: {statistic}, critical {critical}");
}

/// Share of the normal distribution below z, by Simpson's rule on its density.
fn normal_below(z: f64) -> f64 {
    const STEPS: usize = 400;
    let h = z / STEPS as f64;
    let density = |x: f64| (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let weight = |i: usize| if i == 0 || i == STEPS { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
    0.5 + (0..=STEPS).map(|i| weight(i) * density(i as f64 * h)).sum::<f64>() * h / 3.0
}

#[test]
fn continuous_laws_hold() {
    follows(&Distribution::Uniform { min: -2.0, max: 5.0 }, &REAL, |x| (x + 2.0) / 7.0);
    follows(&Distribution::LogUniform { min: 0.1, max: 30.0 }, &REAL, |x| (x / 0.1).ln() / 300f64.ln());
    follows(&Distribution::Normal { mean: 3.0, sd: 2.0 }, &REAL, |x| normal_below((x - 3.0) / 2.0));
    follows(&Distribution::Lognormal { median: 2.0, log_sd: 0.5 }, &REAL, |x| normal_below((x / 2.0).ln() / 0.5));
    let half = Parameter { min: 0.0, ..REAL };
    follows(&Distribution::Normal { mean: 0.0, sd: 1.0 }, &half, |x| 2.0 * normal_below(x) - 1.0);
    let of = Box::new(Distribution::Normal { mean: 0.0, sd: 1.0 });
    let (low, high) = (normal_below(-1.0), normal_below(0.5));
    follows(&Distribution::Truncated { of, min: -1.0, max: 0.5 }, &REAL, |x| (normal_below(x) - low) / (high - low));
    let of = Box::new(Distribution::LogUniform { min: 1.0, max: 100.0 });
    follows(&Distribution::Truncated { of, min: 2.0, max: 8.0 }, &REAL, |x| (x / 2.0).ln() / 4f64.ln());
}

#[test]
fn moments_are_those_of_the_formulas() {
    let cases = [
        (Distribution::Uniform { min: 2.0, max: 8.0 }, 5.0, 3.0),
        (Distribution::LogUniform { min: 1.0, max: std::f64::consts::E }, std::f64::consts::E - 1.0, 0.242_035_6),
        (Distribution::Normal { mean: -4.0, sd: 1.5 }, -4.0, 2.25),
        (Distribution::Lognormal { median: 1.0, log_sd: 0.4 }, 0.08f64.exp(), 0.16f64.exp() * (0.16f64.exp() - 1.0)),
        (Distribution::Choice { values: vec![0.0, 10.0], weights: vec![3.0, 1.0] }, 2.5, 18.75),
    ];
    for (distribution, mean, variance) in cases {
        let draws = draws(&distribution, &REAL);
        let n = draws.len() as f64;
        let found = draws.iter().sum::<f64>() / n;
        let spread = draws.iter().map(|x| (x - found).powi(2)).sum::<f64>() / n;
        // Five standard errors of the mean; 5 % of the variance is as much for the heaviest tail here.
        assert!((found - mean).abs() < 5.0 * (variance / n).sqrt(), "{distribution:?}: mean {found}, not {mean}");
        assert!((spread / variance - 1.0).abs() < 0.05, "{distribution:?}: variance {spread}, not {variance}");
    }
}

#[test]
fn counts_have_the_chances_of_their_laws() {
    let tally = |distribution: &Distribution, values: &[f64]| -> Vec<f64> {
        let draws = draws(distribution, &COUNT);
        let counts: Vec<_> = values.iter().map(|value| draws.iter().filter(|x| *x == value).count() as f64).collect();
        assert_eq!(counts.iter().sum::<f64>(), DRAWS as f64, "{distribution:?} draws something else");
        counts
    };
    // Quantiles of chi-square at 1 - 1e-5: 19.51, 23.03, 25.90, 28.47 for 1 to 4 degrees of freedom.
    let even = tally(&Distribution::Uniform { min: 1.0, max: 4.0 }, &[1.0, 2.0, 3.0, 4.0]);
    chi_square(&even, &[0.25; 4], 25.90);
    let ln = |a: f64, b: f64| (b / a).ln() / 7f64.ln();
    let log = tally(&Distribution::LogUniform { min: 1.0, max: 3.0 }, &[1.0, 2.0, 3.0]);
    chi_square(&log, &[ln(0.5, 1.5), ln(1.5, 2.5), ln(2.5, 3.5)], 23.03);
    let choice = Distribution::Choice { values: vec![0.0, 3.0, 7.0], weights: vec![1.0, 0.0, 2.0] };
    chi_square(&tally(&choice, &[0.0, 7.0]), &[1.0 / 3.0, 2.0 / 3.0], 19.51);
    let of = Box::new(Distribution::Normal { mean: 2.0, sd: 1.0 });
    let normal = tally(&Distribution::Truncated { of, min: 1.0, max: 3.0 }, &[1.0, 2.0, 3.0]);
    let bins = [-1.5, -0.5, 0.5, 1.5].map(normal_below);
    let inside = bins[3] - bins[0];
    chi_square(&normal, &[1, 2, 3].map(|i| (bins[i] - bins[i - 1]) / inside), 23.03);
}

#[test]
fn draws_stay_within_bounds_and_bounds_within_the_range() {
    for recipe in subjects() {
        for index in 0..500 {
            let scene = recipe.draw(3, index);
            let declared = declared(&scene);
            for ((path, value), parameter) in scene.draws().iter().zip(declared) {
                let (min, max) = recipe.distribution(&scene.class, path).expect("declared").bounds(parameter);
                let inside = parameter.min <= min && min <= *value && *value <= max && max <= parameter.max;
                assert!(inside, "{path} = {value}");
                assert!(!parameter.integer || value.fract() == 0.0, "{path} = {value}");
            }
        }
    }
}

/// The declarations in the order of [`Scene::draws`].
fn declared(scene: &Scene) -> Vec<&'static Parameter> {
    let b = &scene.bench;
    let light = [b.exposure.values(), b.speckle.values(), b.lamps.values()].concat();
    let bench = [b.motion.values(), b.laser.values(), b.camera.values(), light];
    bench.into_iter().flatten().chain(scene.plan.values()).map(|(parameter, _)| parameter).collect()
}

/// These numbers may change only together with the version of the generator.
#[test]
fn values_are_stable() {
    let forms = [
        Distribution::Uniform { min: 0.0, max: 1.0 },
        Distribution::LogUniform { min: 1.0, max: 100.0 },
        Distribution::Normal { mean: 0.0, sd: 1.0 },
        Distribution::Lognormal { median: 1.0, log_sd: 1.0 },
        Distribution::Choice { values: vec![1.0, 2.0, 3.0], weights: vec![1.0, 1.0, 1.0] },
    ];
    let drawn = forms.map(|form| format!("{:.12}", form.draw(&REAL, Stream::root(0).child("test.x"))));
    assert_eq!(drawn, ["0.020192787437", "1.097452102535", "-0.165354353759", "0.847593302994", "1.000000000000"]);
}

#[test]
fn a_draw_depends_on_recipe_seed_and_index_alone() {
    let (a, b) = (wood(), wood());
    let backwards: Vec<_> = (0..50).rev().map(|index| b.draw(0, index)).collect();
    for (index, scene) in (0..50).zip(backwards.iter().rev()) {
        assert_eq!(a.draw(0, index), *scene);
    }
    // Seed 0 is a seed like any other, and the last index is an index.
    assert_ne!(a.draw(0, 0).draws(), a.draw(1, 0).draws());
    assert_eq!(a.draw(u64::MAX, u64::MAX), b.draw(u64::MAX, u64::MAX));
}

#[test]
#[ignore = "long"]
fn editing_one_key_leaves_every_other_draw() {
    subjects().iter().for_each(editing_keys_of);
}

fn editing_keys_of(before: &Recipe) {
    let scenes: Vec<_> = (0..12).map(|index| before.draw(5, index)).collect();
    let (mut refused, declared) = (0, declared(&scenes[0]));
    let all = declared.len();
    for parameter in declared {
        let value = match parameter.path().as_str() {
            "rot.edge" => 1.0,
            "wane.edge" => -1.0,
            "exposure.shot_noise" | "speckle.strength" => 0.5,
            "tablet.shape" | "foil.rolled_along_line" => 1.0,
            "pack.columns" | "pack.rows" => 2.0,
            // What still fits together: fewer, smaller or closer pockets, a larger card.
            "pack.pitch_x_mm" => 18.9,
            "pack.pitch_y_mm" => 18.7,
            "pack.width_mm" => 99.0,
            "pack.length_mm" => 59.0,
            "tablet.length_mm" | "tablet.width_mm" => 10.8,
            "material.gloss" | "material.matte" => 0.01,
            _ if parameter.integer => (parameter.min + 3.0).min(parameter.max),
            _ if parameter.default == parameter.max => {
                parameter.default - 0.013 * (parameter.max - parameter.min).min(10.0)
            }
            _ => parameter.default + 0.013 * (parameter.max - parameter.default).min(10.0),
        };
        let mut edited: serde_json::Value = serde_json::from_str(&before.canonical_json()).expect("JSON");
        edited[parameter.group][parameter.name] = value.into();
        let after = match Recipe::parse("edited", &edited.to_string()) {
            Ok(after) => after,
            // A number that does nothing beside the others is refused, and named.
            Err(error) => {
                let told = error.to_string();
                assert!(told.contains("no effect") && told.contains(&parameter.path()), "{told}");
                refused += usize::from(parameter.group != LampParameters::GROUP);
                continue;
            }
        };
        assert_ne!(after.hash(), before.hash(), "{}", parameter.path());
        let mut changed = false;
        for old in &scenes {
            let new = after.draw(5, old.index);
            assert_eq!((&new.class, new.split, new.stream), (&old.class, old.split, old.stream));
            assert_ne!(new.id, old.id);
            for ((path, new), (_, old)) in new.draws().iter().zip(old.draws()) {
                if *path == parameter.path() {
                    changed |= *new != old;
                } else {
                    assert_eq!(*new, old, "editing {} changed {path}", parameter.path());
                }
            }
        }
        assert!(changed, "editing {} changed nothing", parameter.path());
    }
    // Recipes have no lamps unless they say so.
    let all = all - LampParameters::PARAMETERS.len();
    assert!(3 * refused < all, "{refused} of {all} numbers are idle");
}

#[test]
fn every_prefix_is_balanced() {
    for (recipe, seed) in subjects().iter().flat_map(|recipe| [0, 1, u64::MAX].map(|seed| (recipe, seed))) {
        let mut counts = BTreeMap::new();
        for index in 0..10_000u64 {
            *counts.entry(recipe.class_of(seed, index).name.clone()).or_insert(0.0) += 1.0;
            let n = (index + 1) as f64;
            // Denjoy and Koksma: two for each term of n's Zeckendorf sum, of which there are at most log_phi(n) / 2 +
            // 1.
            let bound = 2.0 + n.ln() / ((1.0 + 5f64.sqrt()) / 2.0).ln();
            for class in recipe.classes() {
                let count: f64 = counts.get(&class.name).copied().unwrap_or(0.0);
                assert!((count - n * class.share).abs() <= bound, "{} of {n} are {}", count, class.name);
            }
        }
    }
}

/// Classes and splits are counted as a walk over the samples counts them, for as many samples as there can be, and
/// where boards of a log stay together.
#[test]
fn counts_are_those_of_a_walk() {
    let mut rng = Stream::root(5).rng();
    for recipe in subjects().into_iter().chain([Recipe::load("wood-log").expect("embedded")]) {
        for _ in 0..20 {
            let (seed, samples) = (rng.random(), rng.random_range(0..700));
            let mut walked = vec![[0; 3]; recipe.classes().len()];
            for index in 0..samples {
                let class = &recipe.class_of(seed, index).name;
                let number = recipe.classes().iter().position(|known| known.name == *class).expect("it is one of them");
                walked[number][recipe.split_of(seed, index) as usize] += 1;
            }
            assert_eq!(recipe.class_counts(seed, samples), walked, "{} {seed} {samples}", recipe.name());
        }
        let most: u64 = recipe.class_counts(1, u64::MAX).into_iter().flatten().sum();
        assert_eq!(most, u64::MAX, "{}", recipe.name());
    }
}

/// In every prefix of a dataset each class is split by its shares, within two samples.
#[test]
fn splits_are_balanced_in_every_prefix_of_every_class() {
    assert_eq!(Split::ALL.map(|split| split as usize), [0, 1, 2]);
    for (recipe, seed) in subjects().iter().flat_map(|recipe| [0, 1, u64::MAX].map(|seed| (recipe, seed))) {
        let mut counts: BTreeMap<String, [f64; 3]> = BTreeMap::new();
        for index in 0..3000 {
            let scene = recipe.draw(seed, index);
            let counts = counts.entry(scene.class).or_default();
            counts[scene.split as usize] += 1.0;
            let n: f64 = counts.iter().sum();
            for (count, share) in counts.iter().zip([0.8, 0.1, 0.1]) {
                assert!((count - n * share).abs() < 2.0, "{} {seed}: {counts:?} of {index}", recipe.name());
            }
        }
    }
    // Of few samples, each class is in each split as soon as its share allows it.
    let small = Recipe::load("wood-small").expect("embedded");
    let tested: BTreeSet<String> =
        (0..85).map(|index| small.draw(0, index)).filter(|scene| scene.split == Split::Test).map(|s| s.class).collect();
    assert_eq!(tested.len(), 5, "{tested:?}");
}

/// Classes and their shares decide about splits, nothing else of a recipe.
#[test]
fn splits_ignore_what_is_no_class() {
    let before = Recipe::load("wood-small").expect("embedded");
    let edit = |key: &str, to: serde_json::Value| {
        let mut edited: serde_json::Value = serde_json::from_str(&before.canonical_json()).expect("JSON");
        *edited.pointer_mut(key).expect("a key") = to;
        Recipe::parse("edited", &edited.to_string()).unwrap_or_else(|error| panic!("{error}"))
    };
    let splits = |recipe: &Recipe| (0..400).map(|index| recipe.draw(0, index).split).collect::<Vec<_>>();
    let same = [edit("/camera/f_number", 4.into()), edit("/output/truth_maps", false.into())];
    same.iter().for_each(|after| assert_eq!(splits(after), splits(&before)));
    assert_ne!(splits(&edit("/classes/rot/share", 0.5.into())), splits(&before));
}

/// Two recipes have no sample in common for the same seed, unless they say that they are one family.
#[test]
fn recipes_of_other_names_draw_other_numbers() {
    let load = |name: &str| Recipe::load(name).expect("embedded");
    let small = load("wood-small");
    let draws = |recipe: &Recipe, index: u64| -> Vec<(String, f64)> {
        let all = recipe.draw(0, index).draws();
        let varies = |path: &str| {
            let class = &recipe.class_of(0, index).name;
            !matches!(recipe.distribution(class, path), Some(Distribution::Fixed(_)) | None)
        };
        all.into_iter().filter(|(path, _)| varies(path)).collect()
    };
    for other in ["wood-train", "wood"].map(load) {
        for index in 0..100 {
            let (a, b) = (draws(&small, index), draws(&other, index));
            let alike = a.iter().filter(|draw| b.contains(draw)).count();
            // Counts and choices meet by chance; numbers on a scale do not.
            assert!(4 * alike < a.len(), "{} {index}: {alike} of {}", other.name(), a.len());
            assert_ne!(small.draw(0, index).stream, other.draw(0, index).stream);
        }
    }
    let text = small.text();
    let renamed = Recipe::parse("renamed", &text.replacen("name: wood-small", "name: mine", 1)).expect("good");
    assert_eq!((renamed.family(), small.family()), ("mine", "wood-small"));
    assert_ne!(renamed.draw(0, 0).draws(), small.draw(0, 0).draws());
    let kin = text.replacen("name: wood-small", "name: mine\nfamily: wood-small", 1);
    let kin = Recipe::parse("kin", &kin).expect("good");
    for index in 0..20 {
        let (a, b) = (kin.draw(0, index), small.draw(0, index));
        assert_eq!((a.draws(), a.class, a.split, a.stream), (b.draws(), b.class, b.split, b.stream));
        assert_ne!(a.id, b.id);
    }
}

#[test]
fn ids_are_unique_and_uuids_of_version_5() {
    let recipes = [wood(), Recipe::load("wood-small").expect("embedded")];
    let mut ids = BTreeSet::new();
    for recipe in &recipes {
        for seed in 0..3 {
            for index in 0..1000 {
                let id = recipe.draw(seed, index).id;
                assert_eq!(uuid::Uuid::parse_str(&id).expect("a UUID").get_version_num(), 5);
                assert!(ids.insert(id));
            }
        }
    }
}

#[test]
fn the_hash_follows_the_meaning() {
    let parse = |text: &str| Recipe::parse("test", text).unwrap_or_else(|error| panic!("{error}"));
    let one = parse(
        "name: a\nsubject: wood\nunstated: fixed\nclasses: {b: {share: 1}, a: {share: 3, camera: {tilt_deg: 25}}}\n",
    );
    let same = parse(
        "# the same\nclasses:\n  a: {share: 0.75}\n  b: {share: 2.5e-1}\ncamera: {tilt_deg: 25.0}\nsubject: \
            'wood'\nname: a\nunstated: fixed\n",
    );
    assert_eq!(one.hash(), same.hash());
    assert_eq!(one.hash().len(), 64);
    assert!(differences(&one.canonical_json(), &same.canonical_json()).is_empty());
    let other = parse(
        "name: a\nsubject: wood\nunstated: fixed\n\
         classes: {b: {share: 1}, a: {share: 3}}\ncamera: {tilt_deg: {uniform: [20, 30]}}\n",
    );
    assert_ne!(one.hash(), other.hash());
    let found = differences(&one.canonical_json(), &other.canonical_json());
    assert_eq!(found, [r#"camera.tilt_deg: 25.0 -> {"uniform":[20.0,30.0]}"#]);
    for recipe in [wood(), one] {
        let again = parse(&recipe.canonical_json());
        assert_eq!((again.hash(), again.canonical_json()), (recipe.hash(), recipe.canonical_json()));
    }
}
