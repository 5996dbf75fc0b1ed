//! Draws with correlations and with low discrepancy: their laws, and what they leave as it is.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;
use crate::distribution::tests::{DrawLaw, chance};

/// Every form of distribution; in class `b` the waist is a number and the tilt has another form.
const BASE: &str = "
name: pairs
subject: wood
unstated: fixed
laser:
  wavelength_nm: {truncated: {of: {normal: {mean: 660, sd: 3}}, min: 658, max: 675}}
  waist_mm: {uniform: [0.08, 0.13]}
  linewidth_nm: {log_uniform: [0.3, 1.2]}
  power_mw: {truncated: {of: {lognormal: {median: 50, log_sd: 0.5}}, min: 30}}
camera:
  tilt_deg: {normal: {mean: 25, sd: 0.2}}
  blur_um: {lognormal: {median: 2.5, log_sd: 0.4}}
  f_number: {choice: {values: [4, 2.8, 2], weights: [1, 3, 0]}}
exposure: {prnu: {uniform: [0.005, 0.015]}}
knots: {sound_count: {uniform: [1, 4]}, dead_count: {normal: {mean: 0.5, sd: 1}}}
classes:
  a: {share: 3}
  b: {share: 1, laser: {waist_mm: 0.1}, camera: {tilt_deg: {uniform: [24, 26]}}}
";
const PAIRS: &str = "
correlations:
  - {keys: [laser.waist_mm, laser.linewidth_nm], spearman: -0.6}
  - {keys: [laser.linewidth_nm, camera.tilt_deg], spearman: 0.3}
  - {keys: [camera.blur_um, laser.wavelength_nm], spearman: 0.8}
  - {keys: [laser.power_mw, camera.blur_um], spearman: 0.5}
";
const LOW: &str = "sampling: low_discrepancy\n";

fn parse(text: &str) -> Recipe {
    Recipe::parse("test", text).unwrap_or_else(|error| panic!("{error}"))
}

fn draws(recipe: &Recipe, seed: u64, index: u64) -> BTreeMap<String, f64> {
    recipe.draw(seed, index).draws().into_iter().collect()
}

/// Draws of `samples` samples by class, then by path.
fn by_class(recipe: &Recipe, seed: u64, samples: u64) -> BTreeMap<String, BTreeMap<String, Vec<f64>>> {
    let mut all: BTreeMap<String, BTreeMap<String, Vec<f64>>> = BTreeMap::new();
    for index in 0..samples {
        let scene = recipe.draw(seed, index);
        let class = all.entry(scene.class.clone()).or_default();
        scene.draws().into_iter().for_each(|(path, value)| class.entry(path).or_default().push(value));
    }
    all
}

/// Each key keeps the law that the recipe declares, whatever it is correlated with and however samples are laid out.
#[test]
#[ignore = "long"]
fn marginals_are_the_declared_laws() {
    // About 160 tests a layout.
    const ALPHA: f64 = 1e-8;
    for text in [format!("{BASE}{PAIRS}"), format!("{BASE}{LOW}"), format!("{BASE}{PAIRS}{LOW}")] {
        let recipe = parse(&text);
        let mut tested = 0;
        for (class, columns) in by_class(&recipe, 3, 5400) {
            for (parameter, _) in recipe.draw(0, 0).values() {
                let path = parameter.path();
                let law = recipe.distribution(&class, &path).expect("declared").law(parameter);
                let p = chance(&law, &columns[&path]);
                assert!(p > ALPHA, "{path} in {class}: chance {p:e}");
                tested += usize::from(!matches!(law, DrawLaw::Fixed(_)));
            }
            assert!(columns["laser.waist_mm"].len() > 1300);
        }
        assert_eq!(tested, 10 + 9);
    }
}

/// Every number of every built-in recipe follows the law that it declares, in each class by itself. Numbers that boards
/// of one log have in common are one draw: of each log the first board counts.
#[test]
fn every_built_in_recipe_draws_by_its_laws() {
    let names: Vec<&str> = Recipe::embedded().map(|built_in| built_in.name).collect();
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while let Some(name) = names.get(next.fetch_add(1, Ordering::Relaxed)) {
                    draws_by_its_laws(name);
                }
            });
        }
    });
}

/// The same of one recipe.
fn draws_by_its_laws(name: &str) {
    // Some 30 000 tests, most of them of numbers that never vary.
    const ALPHA: f64 = 1e-10;
    let recipe = Recipe::load(name).expect("built in");
    let mut columns: BTreeMap<String, Vec<Vec<f64>>> = BTreeMap::new();
    for index in (0..6000).map(|place| place * recipe.boards_per_log()) {
        let scene = recipe.draw(0, index);
        let values = scene.values();
        let columns = columns.entry(scene.class.clone()).or_insert_with(|| vec![Vec::new(); values.len()]);
        columns.iter_mut().zip(values).for_each(|(column, (_, value))| column.push(value));
    }
    assert_eq!(columns.len(), recipe.classes().len(), "{name}");
    for (class, columns) in columns {
        for ((parameter, _), numbers) in recipe.draw(0, 0).values().into_iter().zip(columns) {
            let path = parameter.path();
            let law = recipe.distribution(&class, &path).expect("declared").law(parameter);
            if let DrawLaw::Continuous { min, max, .. } = law {
                assert!(numbers.iter().all(|x| (min..=max).contains(x)), "{name}, {path} in {class}");
            }
            let p = chance(&law, &numbers);
            assert!(p > ALPHA, "{name}, {path} in {class}: chance {p:e}");
        }
    }
}

/// Spearman's correlation of numbers without ties.
fn spearman(a: &[f64], b: &[f64]) -> f64 {
    let ranks = |numbers: &[f64]| {
        let mut order: Vec<usize> = (0..numbers.len()).collect();
        order.sort_by(|i, j| numbers[*i].total_cmp(&numbers[*j]));
        let mut ranks = vec![0.0; numbers.len()];
        order.iter().enumerate().for_each(|(rank, i)| ranks[*i] = rank as f64);
        ranks
    };
    let n = a.len() as f64;
    let squares: f64 = ranks(a).iter().zip(ranks(b)).map(|(x, y)| (x - y) * (x - y)).sum();
    1.0 - 6.0 * squares / (n * (n * n - 1.0))
}

/// How far a rank correlation of `n` pairs is from `rho` in standard errors, by Fisher's z, of which the square of the
/// error is (1 + rho^2 / 2) / (n - 3) (Bonett and Wright 2000).
fn errors(found: f64, rho: f64, n: usize) -> f64 {
    (found.atanh() - rho.atanh()) / ((1.0 + 0.5 * rho * rho) / (n as f64 - 3.0)).sqrt()
}

#[test]
fn pairs_have_the_rank_correlation_that_is_written() {
    for text in [format!("{BASE}{PAIRS}"), format!("{BASE}{PAIRS}{LOW}")] {
        let columns = by_class(&parse(&text), 1, 6000);
        let class = &columns["a"];
        let known = [
            ("laser.waist_mm", "laser.linewidth_nm", -0.6),
            ("laser.linewidth_nm", "camera.tilt_deg", 0.3),
            ("camera.blur_um", "laser.wavelength_nm", 0.8),
            ("laser.power_mw", "camera.blur_um", 0.5),
            // Not written: independent.
            ("laser.waist_mm", "camera.tilt_deg", 0.0),
            ("laser.power_mw", "laser.wavelength_nm", 0.0),
            ("exposure.prnu", "camera.tilt_deg", 0.0),
            ("laser.waist_mm", "camera.blur_um", 0.0),
        ];
        for (a, b, rho) in known {
            let found = spearman(&class[a], &class[b]);
            let off = errors(found, rho, class[a].len());
            println!("{a} {b}: {found:.3} for {rho}, {off:.2} standard errors of {} samples", class[a].len());
            assert!(off.abs() < 4.0, "{a} and {b}: {found} for {rho}, {off} standard errors");
        }
        // Where the waist is a number its pair idles, and the other pair of that key acts on.
        let class = &columns["b"];
        let found = spearman(&class["laser.linewidth_nm"], &class["camera.tilt_deg"]);
        assert!(errors(found, 0.3, class["camera.tilt_deg"].len()).abs() < 4.0, "{found}");
        assert!(class["laser.waist_mm"].iter().all(|waist| *waist == 0.1));
    }
}

/// All keys that are in no pair draw the same bits, and so do classes in which a pair idles; class, split and stream
/// stay too.
#[test]
fn a_correlation_leaves_all_other_draws_as_they_were() {
    for layout in ["", LOW] {
        let pair = "correlations: [{keys: [laser.waist_mm, exposure.prnu], spearman: 0.7}]\n";
        let before = parse(&format!("{BASE}{layout}"));
        let after = parse(&format!("{BASE}{pair}{layout}"));
        assert_ne!(before.hash(), after.hash());
        let mut moved = 0;
        for index in 0..300 {
            let (old, new) = (before.draw(7, index), after.draw(7, index));
            assert_eq!((&old.class, old.split, old.stream), (&new.class, new.split, new.stream));
            let changed: Vec<_> =
                old.draws().into_iter().zip(new.draws()).filter(|(a, b)| a != b).map(|(a, _)| a.0).collect();
            if old.class == "b" {
                assert!(changed.is_empty(), "{changed:?}");
            } else {
                assert!(changed.iter().all(|path| ["laser.waist_mm", "exposure.prnu"].contains(&path.as_str())));
                moved += changed.len();
            }
        }
        assert!(moved > 200, "{moved}");
    }
}

/// Editing one key, or one correlation, leaves the points of others where they were.
#[test]
fn low_discrepancy_is_of_each_key_alone() {
    let whole = parse(&format!("{BASE}{LOW}"));
    let fixed = parse(&format!("{BASE}{LOW}").replace("prnu: {uniform: [0.005, 0.015]}", "prnu: 0.01"));
    let wider = parse(
        &format!("{BASE}{LOW}").replace("waist_mm: {uniform: [0.08, 0.13]}", "waist_mm: {uniform: [0.08, 0.18]}"),
    );
    let kin = parse(&format!("{BASE}{LOW}").replace("name: pairs", "name: other\nfamily: pairs"));
    for index in (0..200).rev() {
        let old = draws(&whole, 2, index);
        assert_eq!(draws(&kin, 2, index), old);
        for (recipe, key) in [(&fixed, "exposure.prnu"), (&wider, "laser.waist_mm")] {
            let new = draws(recipe, 2, index);
            assert!(old.iter().all(|(path, value)| path == key || new[path] == *value), "{key} {index}");
        }
        let share = |draws: &BTreeMap<String, f64>, width: f64| (draws["laser.waist_mm"] - 0.08) / width;
        if whole.class_of(2, index).name == "a" {
            assert!((share(&old, 0.05) - share(&draws(&wider, 2, index), 0.10)).abs() < 1e-12);
        }
        // Two classes, two seeds and two families have nothing in common.
        assert_ne!(draws(&whole, 3, index)["exposure.prnu"], old["exposure.prnu"]);
    }
    let columns = by_class(&whole, 2, 400);
    let shared = |of: &str| columns[of]["exposure.prnu"].iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert!(shared("a").iter().all(|bits| !shared("b").contains(bits)));
    // The last sample that there is can be drawn too.
    parse(&format!("{BASE}{PAIRS}{LOW}")).draw(u64::MAX, u64::MAX);
}

/// In every prefix of every class each part of a key's range has its share, within the number of binary digits 1 of the
/// samples.
#[test]
fn every_prefix_of_a_class_covers_each_key_evenly() {
    let recipe = parse(&format!("{BASE}{LOW}"));
    for (class, columns) in by_class(&recipe, 5, 1500) {
        for (parameter, _) in recipe.draw(0, 0).values() {
            let path = parameter.path();
            match recipe.distribution(&class, &path).expect("declared").law(parameter) {
                DrawLaw::Fixed(_) => {}
                DrawLaw::Continuous { cdf, .. } => {
                    let mut below = 0;
                    for (n, x) in (1u32..).zip(&columns[&path]) {
                        below += u32::from(cdf(*x) < 0.3);
                        let far = (f64::from(below) - 0.3 * f64::from(n)).abs();
                        assert!(far <= f64::from(n.count_ones()), "{path} in {class}: {far} of {n}");
                    }
                }
                DrawLaw::Discrete(cells) => {
                    for (value, share) in cells {
                        let mut count = 0;
                        for (n, x) in (1u32..).zip(&columns[&path]) {
                            count += u32::from(*x == value);
                            let far = (f64::from(count) - share * f64::from(n)).abs();
                            // A value has two ends.
                            assert!(far <= 2.0 * f64::from(n.count_ones()), "{path} {value} in {class}: {far} of {n}");
                        }
                    }
                }
            }
        }
    }
}

/// Whether a sample is one of a choice.
type ChosenScene = fn(&Scene) -> bool;

/// Tests of laws over all classes, over a split and over every second stretch of 16 samples: none is near
/// an alarm. 400 tests, so that the least of them is below 10^-8 with a chance of 4 in 10^6.
#[test]
#[ignore = "long"]
fn choices_of_samples_pass_the_tests_of_laws() {
    let recipe = parse(&format!("{BASE}{PAIRS}{LOW}"));
    let keys = ["laser.linewidth_nm", "exposure.prnu", "laser.power_mw", "camera.f_number", "knots.sound_count"];
    let (mut least, mut tests) = (1.0f64, 0);
    for seed in 0..16 {
        let scenes: Vec<(Scene, BTreeMap<String, f64>)> = (0..1000)
            .map(|index| {
                let scene = recipe.draw(seed, index);
                let draws = scene.draws().into_iter().collect();
                (scene, draws)
            })
            .collect();
        let choices: [(&str, ChosenScene); 5] = [
            ("all", |_| true),
            ("train", |scene| scene.split == Split::Train),
            ("test", |scene| scene.split == Split::Test),
            ("stretches", |scene| scene.index / 16 % 2 == 1),
            ("every fourth", |scene| scene.index % 4 == 2),
        ];
        for (parameter, _) in scenes[0].0.values() {
            let path = parameter.path();
            if !keys.contains(&path.as_str()) {
                continue;
            }
            let law = recipe.distribution("a", &path).expect("declared").law(parameter);
            for (name, chosen) in choices {
                let chosen = scenes.iter().filter(|(scene, _)| chosen(scene));
                let numbers: Vec<f64> = chosen.map(|(_, draws)| draws[&path]).collect();
                let p = chance(&law, &numbers);
                (least, tests) = (least.min(p), tests + 1);
                assert!(p > 1e-8, "{path} of {name}, seed {seed}: chance {p:e}");
            }
        }
    }
    assert_eq!(tests, 16 * 5 * 5);
    println!("least chance of {tests} tests: {least:.1e}");
}

/// What does not use the two ways of drawing has the canonical form that it had, and draws the same with the default
/// written.
#[test]
fn recipes_without_them_keep_hash_and_draws() {
    let plain = parse(BASE);
    for absent in ["sampling", "correlations"] {
        assert!(plain.canonical().get(absent).is_none());
    }
    for same in ["sampling: independent\n", "correlations: []\n", "correlations:\n"] {
        let written = parse(&format!("{BASE}{same}"));
        assert_eq!(written.hash(), plain.hash());
        assert_eq!(written.draw(1, 5), plain.draw(1, 5));
    }
    // Given on the command line they mean the same.
    let changes =
        ["sampling=low_discrepancy", "correlations=[{keys: [camera.blur_um, laser.waist_mm], spearman: 0.25}]"];
    let changes = changes.map(|change| change.parse().expect("a change"));
    let changed =
        Recipe::parse_changed("test", BASE, &crate::asset_source::AssetSource::BuiltIn, &changes).expect("good");
    let pair = "correlations: [{keys: [laser.waist_mm, camera.blur_um], spearman: 0.25}]\n";
    assert_eq!(changed.hash(), parse(&format!("{BASE}{pair}{LOW}")).hash());
    let told = crate::differences(&plain.canonical_json(), &changed.canonical_json());
    assert!(told.len() == 2 && told[1] == "sampling: nothing -> \"low_discrepancy\"", "{told:?}");
    for text in [format!("{BASE}{LOW}"), format!("{BASE}{PAIRS}{LOW}")] {
        let recipe = parse(&text);
        let again = parse(&recipe.canonical_json());
        assert_eq!((again.hash(), again.canonical_json()), (recipe.hash(), recipe.canonical_json()));
        assert_eq!(again.draw(4, 9), recipe.draw(4, 9));
        assert_ne!(recipe.hash(), plain.hash());
    }
}

/// What bounds cut off is what the normal distribution has beyond them, weighted by the classes' shares.
#[test]
fn bounds_cut_off_what_lies_beyond() {
    let recipe = parse(&BASE.replace("b: {share: 1,", "b: {share: 1, knots: {dead_count: 1},"));
    let expected = [
        ("knots.dead_count", 0.75 * normal_below(-1.0)),
        ("laser.power_mw", normal_below(f64::ln(30.0 / 50.0) / 0.5)),
        ("laser.wavelength_nm", normal_below(-2.0 / 3.0) + normal_below(-5.0)),
    ];
    let found = recipe.cut_off();
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (key, share) in expected {
        assert!((found[key] - share).abs() < 1.0e-6, "{key}: {} and not {share}", found[key]);
    }
    assert_eq!(parse(&(BASE.to_string() + LOW)).cut_off().len(), 3);
}
