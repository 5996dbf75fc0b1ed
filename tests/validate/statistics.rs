//! Purpose: statistics of rows alarm where draws, classes or splits are not those of the recipe, and only there.

use dataset::validate::{ALPHA, BalanceStatistics, Code, DeclaredLaws, Finding, RowNumbers, statistics};
use procedural::Stream;
use rand::RngExt;
use recipe::Recipe;
use sheetlight::generate::declared;

/// Rows of a dataset as the program draws them; nothing is rendered.
fn rows(recipe: &Recipe, seed: u64, samples: u64) -> Vec<RowNumbers> {
    let class = |name: &str| recipe.classes().iter().position(|class| class.name == name);
    let row = |index| {
        let scene = recipe.draw(seed, index);
        RowNumbers {
            index,
            split: scene.split.name().into(),
            class: class(&scene.class).expect("a class of the recipe"),
            numbers: scene.values().into_iter().map(|(_, value)| value).collect(),
        }
    };
    (0..samples).map(row).collect()
}

fn small() -> Recipe {
    Recipe::load("wood-small").expect("built in")
}

/// What is found after `change` of every row of a small dataset.
fn after(samples: u64, change: impl Fn(&mut RowNumbers)) -> (BalanceStatistics, Vec<Finding>) {
    let recipe = small();
    let mut all = rows(&recipe, 3, samples);
    all.iter_mut().for_each(change);
    statistics(&declared(&recipe, 3), all.into_iter(), samples)
}

/// Place of a parameter among the numbers.
fn place(path: &str) -> usize {
    let declared = declared(&small(), 3);
    declared.parameters.iter().position(|parameter| parameter.path == path).expect("a parameter of wood")
}

/// The parameters that are found to be drawn otherwise.
fn otherwise(faults: &[Finding]) -> Vec<&str> {
    assert!(faults.iter().all(|fault| fault.code == Code::DistributionDiffers), "{faults:?}");
    let mut names: Vec<&str> = faults.iter().filter_map(|found| found.fault.place.split(", ").nth(1)).collect();
    names.dedup();
    names
}

#[test]
fn no_recipe_alarms() {
    // 8000 draws of each built-in recipe; a false alarm of any comes once in 10^5 programs.
    for name in Recipe::embedded().map(|recipe| recipe.name) {
        let recipe = Recipe::load(name).expect("built in");
        let samples = 8000;
        let (found, faults) = statistics(&declared(&recipe, 0), rows(&recipe, 0, samples).into_iter(), samples);
        assert!(faults.is_empty(), "{name}: {faults:?}");
        assert_eq!((found.samples, found.alpha), (samples, ALPHA));
        assert_eq!(found.classes.iter().map(|class| class.samples).sum::<u64>(), samples);
        assert!(found.tests.len() >= recipe.draw(0, 0).values().len(), "{name}: a number has no test");
        assert_eq!(found.splits.len(), 3 * found.classes.len());
        let whole = found.splits.iter().map(|split| split.samples).sum::<u64>() == samples;
        assert!(whole && found.splits.iter().all(|split| split.samples == split.drawn), "{name}: {:?}", found.splits);
        assert!(found.class_bound.is_some());
    }
}

#[test]
fn boards_of_one_log_do_not_alarm() {
    // Numbers that five boards have in common are one draw, not five, and their log is one unit of classes and splits.
    let text =
        include_str!("../../recipes/wood-stem.yaml").replace("source: stem", "source: stem\n  boards_per_log: 5");
    let recipe = Recipe::parse("logs", &text).expect("a recipe");
    assert_eq!(recipe.boards_per_log(), 5);
    for seed in 0..6 {
        let samples = 400 + 417 * seed;
        let all = rows(&recipe, seed, samples);
        let (_, faults) = statistics(&declared(&recipe, seed), all.iter().cloned(), samples);
        assert!(faults.is_empty(), "seed {seed}: {faults:?}");
        // A board in another split than the others of its log is told.
        let strayed = all.into_iter().map(|row| match row.index {
            7 => RowNumbers { split: if row.split == "train" { "test" } else { "train" }.into(), ..row },
            _ => row,
        });
        let (_, faults) = statistics(&declared(&recipe, seed), strayed, samples);
        assert!(
            faults.iter().all(|fault| fault.code == Code::SplitBalance) && faults.len() == 2,
            "seed {seed}: {faults:?}"
        );
    }
}

#[test]
fn chances_are_never_too_small() {
    // 400 small datasets of other seeds: for each number by itself, a chance below alpha comes in a share alpha of them at
    // most, within 9 standard errors of independent tests, and for continuous ones in about that share. Tests of one set
    // depend on each other, some as much as to double the error: 4.5 of those are left (false once in 10^5).
    const SETS: u64 = 400;
    // A choice of three, for a chi-square.
    let three = "blur_um: {choice: {values: [1.5, 2, 4], weights: [1, 5, 2]}}";
    let text = include_str!("../../recipes/wood-small.yaml").replace("blur_um: {uniform: [1.5, 4]}", three);
    let recipes = [small(), Recipe::parse("three lenses", &text).expect("a recipe")];
    let sets = recipes.iter().flat_map(|recipe| (0..SETS / 2).map(move |seed| (recipe, seed)));
    let all: Vec<BalanceStatistics> = sets
        .map(|(recipe, seed)| statistics(&declared(recipe, seed), rows(recipe, seed, 60).into_iter(), 60).0)
        .collect();
    for (kind, is_sharp) in [("kolmogorov-smirnov", true), ("binomial", false), ("chi-square", false)] {
        for alpha in [0.01, 0.05, 0.1] {
            let chances = all.iter().flat_map(|set| set.tests.iter().filter(|test| test.test == kind));
            let (mut below, mut tests) = (0.0, 0.0);
            for test in chances {
                tests += 1.0;
                below += f64::from(u8::from(test.p < alpha));
            }
            let (mean, error) = (tests * alpha, (tests * alpha * (1.0 - alpha)).sqrt());
            assert!(tests > 0.0 && below < mean + 9.0 * error, "{kind}, alpha {alpha}: {below} of {tests}");
            assert!(!is_sharp || below > mean - 9.0 * error, "{kind}, alpha {alpha}: only {below} of {tests}");
        }
    }
}

#[test]
fn a_shifted_mean_is_found() {
    let tilt = place("camera.tilt_deg");
    let (_, faults) = after(2000, |row| row.numbers[tilt] += 0.05);
    assert_eq!(otherwise(&faults), ["camera.tilt_deg"]);
    // A quarter of a standard deviation of 0.2 is too little for 50 samples.
    assert!(after(50, |row| row.numbers[tilt] += 0.05).1.is_empty());
}

#[test]
fn a_wrong_scale_is_found() {
    let tilt = place("camera.tilt_deg");
    let (_, faults) = after(2000, |row| row.numbers[tilt] = 25.0 + 1.5 * (row.numbers[tilt] - 25.0));
    assert_eq!(otherwise(&faults), ["camera.tilt_deg"]);
}

#[test]
fn cut_tails_are_found() {
    let power = place("laser.linewidth_nm");
    // The uppermost fifth of a range that is even in the logarithm, drawn again by folding it back.
    let (_, faults) = after(2000, |row| {
        if row.numbers[power] > 0.9 {
            row.numbers[power] *= 0.5;
        }
    });
    assert_eq!(otherwise(&faults), ["laser.linewidth_nm"]);
}

#[test]
fn wrong_weights_are_found() {
    let edge = place("rot.edge");
    // One in four of one side goes to the other.
    let (found, faults) = after(2000, |row| {
        if row.index.is_multiple_of(4) {
            row.numbers[edge] = 1.0;
        }
    });
    assert_eq!(otherwise(&faults), ["rot.edge"]);
    let test = found.tests.iter().find(|test| test.of == "rot.edge").expect("it is tested");
    assert_eq!((test.test, test.samples, test.impossible), ("binomial", 2000, 0));
}

#[test]
fn swapped_columns_are_found() {
    let [row_noise, column] = [place("exposure.row_noise_dn"), place("exposure.row_pattern_dn")];
    let (_, faults) = after(500, |row| row.numbers.swap(row_noise, column));
    assert_eq!(otherwise(&faults), ["exposure.row_noise_dn", "exposure.row_pattern_dn"]);
}

#[test]
fn numbers_that_are_never_drawn_are_found() {
    let [power, count, tilt] = ["laser.power_mw", "knots.sound_count", "board.twist_deg"].map(place);
    for (parameter, value) in [(power, 51.0), (count, 1.5), (tilt, 0.3), (tilt, f64::NAN)] {
        let (_, faults) = after(100, |row| {
            if row.index == 17 {
                row.numbers[parameter] = value;
            }
        });
        assert_eq!(faults.len(), 1, "{faults:?}");
        assert!(faults[0].fault.what.contains("sample 17 has"), "{faults:?}");
    }
}

#[test]
fn classes_are_exactly_those_of_the_rotation() {
    // One sample of another class among 1000 keeps every share within its bound, and is found.
    let recipe = small();
    let mut all = rows(&recipe, 3, 1000);
    let clear: usize = 0;
    let row = all.iter_mut().find(|row| row.class != clear).expect("another class");
    *row = RowNumbers { class: clear, numbers: row.numbers.clone(), ..row.clone() };
    let (_, faults) = statistics(&declared(&recipe, 3), all.into_iter(), 1000);
    assert_eq!(faults.iter().filter(|fault| fault.code == Code::ClassBalance).count(), 2, "{faults:?}");
}

#[test]
fn a_rotation_that_loses_its_shares_is_found() {
    // The first 200 samples of one class: what rows say is what the wrong rotation says, and beyond the bound of 21.
    let recipe = small();
    let samples = 10_000;
    let mut all = rows(&recipe, 3, samples);
    let mut wrong: DeclaredLaws = declared(&recipe, 3);
    all.iter_mut().filter(|row| row.index < 200).for_each(|row| row.class = 0);
    let own = recipe.clone();
    let class = move |index: u64| {
        let class = own.class_of(3, index);
        own.classes().iter().position(|known| known.name == class.name).expect("a class")
    };
    wrong.class_of = Box::new(move |index| if index < 200 { 0 } else { class(index) });
    let (found, faults) = statistics(&wrong, all.into_iter(), samples);
    let classes = faults.iter().filter(|fault| fault.code == Code::ClassBalance).count();
    assert!(classes >= 1 && found.classes.iter().all(|class| class.samples == class.drawn), "{faults:?}");
    let bound = found.class_bound.expect("nothing is missing");
    assert!((21.0..22.0).contains(&bound), "{bound}");
}

#[test]
fn splits_that_are_drawn_otherwise_are_found() {
    // Half as much for testing as declared.
    let codes =
        |faults: Vec<Finding>| faults.into_iter().map(|fault| fault.code).collect::<std::collections::BTreeSet<_>>();
    let (_, faults) = after(2000, |row| {
        if row.split == "test" && row.index % 2 == 0 {
            row.split = "train".into();
        }
    });
    assert_eq!(codes(faults), [Code::SplitBalance].into());
    // The right shares, but all rot in one split.
    let recipe = small();
    let mut all = rows(&recipe, 3, 2000);
    let rot = recipe.classes().iter().position(|class| class.name == "rot").expect("a class");
    let mut held: Vec<usize> = (0..all.len()).filter(|&i| all[i].class == rot && all[i].split != "train").collect();
    let mut other: Vec<usize> = (0..all.len()).filter(|&i| all[i].class != rot && all[i].split == "train").collect();
    while let (Some(a), Some(b)) = (held.pop(), other.pop()) {
        let split = std::mem::replace(&mut all[a].split, "train".into());
        all[b].split = split;
    }
    let (found, faults) = statistics(&declared(&recipe, 3), all.into_iter(), 2000);
    let whole =
        |name: &str| found.splits.iter().filter(|split| split.split == name).map(|split| split.samples).sum::<u64>();
    assert!((whole("train") as f64 / 2000.0 - 0.8).abs() < 0.01, "the shares are right");
    assert!(faults.iter().any(|found| found.fault.what.contains("of class rot")), "{faults:?}");
    assert_eq!(codes(faults), [Code::SplitBalance].into());
}

/// A sample that changes sides keeps every share within chance, and is found; so is a program that puts too many samples on one
/// side, although rows say what it gives.
#[test]
fn splits_are_exactly_those_of_the_ranks() {
    let recipe = small();
    let mut all = rows(&recipe, 3, 1000);
    let train = all.iter().position(|row| row.class == 0 && row.split == "train").expect("there is one");
    all[train].split = "test".into();
    let (found, faults) = statistics(&declared(&recipe, 3), all.clone().into_iter(), 1000);
    assert_eq!(faults.iter().filter(|fault| fault.code == Code::SplitBalance).count(), 2, "{faults:?}");
    assert_eq!(found.split_bound, Some(2.0));
    // Samples that are not there yet are missed on both sides.
    all[train].split = "train".into();
    let (found, faults) = statistics(&declared(&recipe, 3), all.iter().take(700).cloned(), 1000);
    assert!(faults.is_empty() && found.split_bound.is_none(), "{faults:?}");
    let mut wrong = declared(&recipe, 3);
    let own = recipe.clone();
    wrong.split_of = Box::new(move |index| if index.is_multiple_of(5) { 0 } else { own.split_of(3, index) as usize });
    let moved = |mut row: RowNumbers| {
        if row.index.is_multiple_of(5) {
            row.split = "train".into();
        }
        row
    };
    let (found, faults) = statistics(&wrong, all.into_iter().map(moved), 1000);
    assert!(found.splits.iter().all(|split| split.samples == split.drawn), "{:?}", found.splits);
    let codes: Vec<Code> = faults.iter().map(|fault| fault.code).collect();
    assert!(!codes.is_empty() && codes.iter().all(|code| *code == Code::SplitBalance), "{faults:?}");
}

#[test]
fn a_thinned_dataset_is_found() {
    // Who keeps the bright samples alone, and numbers them anew, keeps neither the laws nor the rotation.
    let recipe = small();
    let exposure = place("exposure.time_us");
    let mut kept = rows(&recipe, 3, 3000);
    kept.retain(|row| row.numbers[exposure] > 38.0);
    (0..).zip(&mut kept).for_each(|(index, row)| row.index = index);
    let samples = kept.len() as u64;
    let (_, faults) = statistics(&declared(&recipe, 3), kept.into_iter(), samples);
    assert!(faults.iter().any(|found| found.fault.place.ends_with("exposure.time_us")), "{faults:?}");
}

#[test]
fn the_order_of_rows_does_not_matter() {
    let recipe = small();
    let mut all = rows(&recipe, 5, 300);
    let first = statistics(&declared(&recipe, 5), all.clone().into_iter(), 300);
    let mut rng = Stream::root(9).rng();
    for i in (1..all.len()).rev() {
        all.swap(i, rng.random_range(0..=i));
    }
    assert_eq!(statistics(&declared(&recipe, 5), all.into_iter(), 300), first);
}
