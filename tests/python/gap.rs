//! What `make gap` counts: its statistics against closed forms, published values and simulation, and its answers where
//! nothing differs, where much does, and where datasets do not belong together.

use std::path::Path;
use std::process::Output;

use crate::scripts::interpreter;
use test_support::program::Place;

const WOOD: &str = include_str!("../../recipes/gap/wood.yaml");

/// Python's text in a folder, with python/gap.py to import.
fn statistics(place: &Place, text: &str) -> Output {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("python");
    place.write("asked.py", format!("import sys; sys.path.insert(0, {folder:?})\nimport gap, numpy as np\n{text}"));
    interpreter().current_dir(place.path("")).arg("asked.py").output().expect("python starts")
}

/// The numbers that it prints, a line each.
fn numbers(place: &Place, text: &str) -> Vec<f64> {
    let run = statistics(place, text);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let told = String::from_utf8_lossy(&run.stdout).into_owned();
    told.split_whitespace().map(|word| word.parse().unwrap_or_else(|_| panic!("{word} in {told}"))).collect()
}

fn near(found: f64, wanted: f64, within: f64) {
    assert!((found - wanted).abs() <= within, "{found}, not {wanted} +- {within}");
}

/// Student's quantiles from printed tables (three decimals), Clopper and Pearson's bound in its closed form for none
/// and as published for 3 of 10 (0.6525), the sign test, and the interval of one answer a sample, whose standard error
/// is that of a mean.
#[test]
fn statistics_are_those_of_the_books() {
    let place = Place::new();
    let told = numbers(
        &place,
        "print(*map(gap.student, (4, 9, 39, 1000)))\n\
         print(gap.most_share(0, 20), gap.most_share(3, 10), gap.most_share(7, 7))\n\
         print(gap.sign_test(0, 6), gap.sign_test(3, 3), gap.sign_test(0, 0))\n\
         before, after = np.ones((1, 40), bool), np.ones((1, 40), bool)\n\
         after[0, :8] = False; before[0, 38:] = False\n\
         loss = gap.accuracy_lost(before, after, np.arange(40))\n\
         print(loss.mean, loss.low, loss.high, loss.lost, loss.gained)\n\
         same = gap.accuracy_lost(before, before, np.arange(40))\n\
         print(same.mean, same.low, same.high)",
    );
    for (found, table) in told.iter().zip([2.776, 2.262, 2.023, 1.962]) {
        near(*found, table, 0.002);
    }
    near(told[4], 1.0 - 0.025_f64.powf(1.0 / 20.0), 1e-9);
    near(told[5], 0.6525, 5e-5);
    assert_eq!(told[6..10], [1.0, 2.0 / 64.0, 1.0, 1.0]);
    // Eight of forty lost, two gained: mean 0.15, mean square 0.25.
    let error = ((0.25 - 0.15_f64.powi(2)) / 39.0).sqrt();
    near(told[10], 0.15, 1e-12);
    near(told[11], 0.15 - 2.0227 * error, 1e-4);
    near(told[12], 0.15 + 2.0227 * error, 1e-4);
    assert_eq!(told[13..15], [8.0, 2.0]);
    // Nothing differs, and forty samples cannot say that nothing ever would.
    let most = 1.0 - 0.025_f64.powf(1.0 / 40.0);
    assert_eq!(told[15], 0.0);
    near(told[16], -most, 1e-9);
    near(told[17], most, 1e-9);
}

/// Of 600 simulated comparisons of 40 boards with 20 answers each, which are lost by whole boards as often as singly,
/// the interval holds the truth in 95 %. Fewer than 533 come by chance once in ten thousand where it holds it in 93 %,
/// which 40 samples of a skewed law are granted; an interval that took answers of one board as independent holds it in
/// fewer.
#[test]
fn intervals_hold_the_loss_of_alike_answers() {
    let place = Place::new();
    let told = numbers(
        &place,
        "rng, held, naive = np.random.default_rng(1), 0, 0\n\
         sample = np.repeat(np.arange(40), 20)\n\
         for _ in range(600):\n    \
             share = np.where(rng.random(40) < 0.3, rng.random(40) * 0.4, 0.0)\n    \
             after = rng.random((1, 800)) >= share[sample]\n    \
             before = np.ones((1, 800), bool)\n    \
             loss = gap.accuracy_lost(before, after, sample)\n    \
             held += loss.low <= 0.3 * 0.2 <= loss.high\n    \
             loss = gap.accuracy_lost(before, after, np.arange(800))\n    \
             naive += loss.low <= 0.3 * 0.2 <= loss.high\n\
         print(held, naive)",
    );
    println!("{} of 600 intervals hold the loss, {} of those of independent answers", told[0], told[1]);
    assert!(told[0] >= 533.0, "{told:?}");
    assert!(told[1] < 533.0, "{told:?}");
}

fn run(place: &Place, arguments: &str) -> Output {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("python/gap.py");
    let mut command = interpreter();
    command.current_dir(place.path("")).arg(script).args(arguments.split_whitespace());
    command.output().expect("python starts")
}

/// The numbers of a row of a table, by its first cell.
fn row<'a>(told: &'a str, first: &str) -> Vec<&'a str> {
    let start = format!("| {first} |");
    let line = told.lines().find(|line| line.starts_with(&start)).unwrap_or_else(|| panic!("no row {first} in {told}"));
    line.split('|').map(str::trim).collect()
}

/// Boards that differ in nothing lose nothing, though no interval is empty; boards by the thesis' model are found to
/// differ. What the reference would say is not asked here, because it is slow: a dataset of the kernel says that it is
/// the reference's.
#[test]
fn a_loss_is_found_where_there_is_one_and_only_there() {
    let place = Place::new();
    place.write("gap.yaml", WOOD);
    let make = |name: &str, more: &str| {
        place.done(&format!("--recipe gap.yaml --samples-per-shard 4 --out {name} {more}"));
    };
    make("train", "--n 60 --seed 1");
    make("kernel", "--n 12 --seed 5");
    make("thesis", "--n 12 --seed 5 --set transport=thesis");
    make("path", "--n 12 --seed 5");
    let asked = "--task wood --train train --kernel kernel --trainings 2 --epochs 6 --patches 1500 --asked 300";
    let refused = |arguments: &str, words: &[&str]| {
        let output = run(&place, arguments);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && !told.contains("Traceback"), "{arguments}: {told}");
        assert!(words.iter().all(|word| told.contains(word)), "{arguments}: {told}");
    };
    refused(&format!("{asked} --path path"), &["path was rendered by `transport: kernel`", "--path takes"]);
    let claimed = |name: &str, model: &str| {
        let mut head = place.json(&format!("{name}/dataset.json"));
        head["recipe"]["canonical"]["transport"] = serde_json::json!({"model": model, "photons_per_profile": 1000});
        place.write(&format!("{name}/dataset.json"), head.to_string());
    };
    claimed("path", "path");
    let output = run(&place, &format!("{asked} --path path --control thesis"));
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{told}{}", String::from_utf8_lossy(&output.stderr));
    let none = row(&told, "the reference");
    let most = 100.0 * (1.0 - 0.025_f64.powf(1.0 / 12.0));
    assert_eq!((none[3], none[4]), ("+0.00", format!("-{most:.2} to +{most:.2}").as_str()), "{told}");
    let thesis = row(&told, "`transport: thesis`");
    assert_ne!((thesis[3], thesis[5]), ("+0.00", "0, 0"), "{told}");
    assert!(told.contains("not decided by so few samples"), "{told}");
    refused("--task wood --train kernel --kernel kernel --path path", &["seed 5 in common", "another --seed"]);
    make("others", "--n 12 --seed 6");
    claimed("others", "path");
    refused(&format!("{asked} --path others"), &["kernel and others differ in seed", "one recipe, --seed"]);
    make("fewer", "--n 8 --seed 5");
    claimed("fewer", "path");
    refused(&format!("{asked} --path fewer"), &["other samples", "the same --n"]);
}
