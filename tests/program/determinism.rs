//! `gen` writes the same bytes whatever threads, parts and shards make them, and a sample depends on its index alone.

use std::collections::BTreeMap;
use std::fs;
use std::time::SystemTime;

use test_support::program::{FRAMES, Place, SPECKLE, assert_same, tree};

#[test]
#[ignore = "long"]
fn threads_change_nothing() {
    for place in Place::of_each_subject(&[FRAMES, SPECKLE]) {
        place.make("one", "--n 8 --samples-per-shard 3 --threads 1");
        place.make("two", "--n 8 --samples-per-shard 3 --threads 2");
        place.make("five", "--n 8 --samples-per-shard 3 --threads 5");
        let one = place.tree("one");
        // Three shards, of which each has tables, frames and a manifest; eight samples; head and card.
        assert!(one.len() >= 3 * 3 + 8 + 2, "{:?}", one.keys());
        assert_same(&one, &place.tree("two"), "2 threads");
        assert_same(&one, &place.tree("five"), "5 threads");
    }
}

#[test]
fn parts_that_run_at_once_make_what_one_run_makes() {
    let place = Place::with(&[FRAMES, SPECKLE]);
    place.make("alone", "--n 14 --samples-per-shard 2");
    let order = "--recipe tiny.yaml --out shared --n 14 --samples-per-shard 2 --threads 1 --part";
    let parts: Vec<_> =
        (0..3).map(|k| place.command(&format!("{order} {k}/3")).spawn().expect("the program starts")).collect();
    for part in parts {
        let output = part.wait_with_output().expect("the part ends");
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && text.contains("dataset of 14 samples"), "{text}");
    }
    assert_same(&place.tree("alone"), &place.tree("shared"), "three parts at once");
}

#[test]
fn two_runs_of_everything_at_once_share_the_work() {
    let place = Place::with(&[]);
    place.make("alone", "--n 8 --samples-per-shard 1");
    let order = "--recipe tiny.yaml --out shared --n 8 --samples-per-shard 1 --threads 1";
    let runs: Vec<_> = (0..2).map(|_| place.command(order).spawn().expect("the program starts")).collect();
    for run in runs {
        let output = run.wait_with_output().expect("the run ends");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    assert_same(&place.tree("alone"), &place.tree("shared"), "two runs at once");
}

#[test]
#[ignore = "long"]
fn more_samples_extend_a_dataset() {
    Place::of_each_subject(&[FRAMES]).iter().for_each(grows);
}

fn grows(place: &Place) {
    // The third shard is cut short by the eighth sample, and made again.
    place.make("grown", "--n 8 --samples-per-shard 3");
    let short = place.samples("grown");
    place.make("grown", "--n 16 --samples-per-shard 3");
    place.make("whole", "--n 16 --samples-per-shard 3");
    assert_same(&place.tree("grown"), &place.tree("whole"), "8 samples, then 16");
    let long = place.samples("whole");
    assert_eq!((short.len(), long.len()), (8, 16));
    for (index, sample) in &short {
        assert!(*sample == long[index], "sample {index} of 8 is not sample {index} of 16");
        assert!(!sample.exr.is_empty());
    }
    // Fewer samples than there are change nothing.
    let before = place.tree("grown");
    place.make("grown", "--n 5 --samples-per-shard 3");
    assert_same(&before, &place.tree("grown"), "5 samples of 16");
}

/// Guards the number that is asked for: it rules, whoever began the dataset with whatever number, and what is made is
/// said before.
#[test]
fn the_number_asked_for_rules() {
    let place = Place::with(&[]);
    let begin = "--recipe tiny.yaml --n 400 --samples-per-shard 2 --part";
    // A part without a shard begins a dataset and makes nothing.
    let of_none = |out: &str| place.done(&format!("{begin} 250/300 --out {out}"));
    let manifests =
        |out: &str| -> Vec<String> { place.tree(out).into_keys().filter(|name| name.starts_with("shards/")).collect() };
    let samples = |out: &str| place.json(&format!("{out}/dataset.json"))["samples"].clone();

    place.done(&format!("{begin} 1/200 --out some"));
    let estimate = place.done("--recipe tiny.yaml --n 3 --out some --estimate").out;
    assert!(estimate.contains("begun  with 400 samples"), "{estimate}");
    let told = place.done("--recipe tiny.yaml --n 3 --out some").err;
    for words in ["begun with 400 samples", "-n 3 asks", "2 are made now", "396 are left", "-n 400 makes all"] {
        assert!(told.contains(words), "no `{words}` in {told}");
    }
    assert_eq!(
        (manifests("some"), samples("some")),
        (vec!["shards/00000.json".into(), "shards/00001.json".into()], 400.into())
    );
    let told = place.done("--recipe tiny.yaml --n 3 --out some --events --json");
    assert!(
        told.err.contains("\"event\":\"larger\"") && told.out.contains("\"left_samples\": 396"),
        "{}{}",
        told.err,
        told.out
    );
    let told = place.done("--recipe tiny.yaml --n 3 --out some").err;
    assert!(told.contains("all that is asked for is there; dataset of 400 samples, 396 of them"), "{told}");

    // Nothing is made: the dataset is the one of the smaller number.
    of_none("none");
    let told = place.done("--recipe tiny.yaml --n 3 --out none").err;
    assert!(told.contains("begun with 400 samples in shards of 2") && told.contains("begun anew"), "{told}");
    place.make("three", "--n 3 --samples-per-shard 2");
    assert_same(&place.tree("none"), &place.tree("three"), "begun anew with three samples");
    // One of many parts knows nothing of the others.
    of_none("part");
    let told = place.done("--recipe tiny.yaml --n 3 --out part --part 1/2").err;
    assert!(told.contains("396 are left") && samples("part") == 400 && manifests("part").len() == 1, "{told}");

    // Somebody else's document asks for a hundred million.
    of_none("foreign");
    let mut head = place.json("foreign/dataset.json");
    (head["samples"], head["samples_per_shard"], head["shards"]) = (100_000_000.into(), 1000.into(), 100_000.into());
    place.write("foreign/dataset.json", format!("{head:#}\n"));
    let told = place.done("--recipe foreign --n 3").err;
    assert!(told.contains("begun with 100000000 samples") && samples("foreign") == 3, "{told}");
    assert_eq!(place.samples("foreign").len(), 3);
}

/// A dataset keeps the size of its shards from its first finished shard on, not before.
#[test]
fn shards_have_another_size_while_none_is_made() {
    let place = Place::with(&[]);
    place.done("--recipe tiny.yaml --n 8 --samples-per-shard 4 --part 2/3 --out set");
    place.make("set", "--n 8 --samples-per-shard 3");
    place.make("threes", "--n 8 --samples-per-shard 3");
    assert_same(&place.tree("set"), &place.tree("threes"), "begun anew in shards of three");
    let refused = place.run("--recipe tiny.yaml --n 8 --samples-per-shard 2 --out set");
    refused.refused(&["samples_per_shard: 3 -> 2", "from its first finished shard on"]);
}

#[test]
fn shards_of_any_size_hold_the_same_samples() {
    let place = Place::with(&[]);
    place.make("twos", "--n 7 --samples-per-shard 2");
    place.make("fives", "--n 7 --samples-per-shard 5");
    assert_eq!(fs::read_dir(place.path("twos/shards")).expect("shards").count(), 4);
    assert_eq!(fs::read_dir(place.path("fives/shards")).expect("shards").count(), 2);
    assert!(place.samples("twos") == place.samples("fives"));
}

#[test]
fn seeds_are_seeds_and_zero_is_the_one_unsaid() {
    let place = Place::with(&[]);
    place.make("unsaid", "--n 3");
    place.make("zero", "--n 3 --seed 0");
    place.make("one", "--n 3 --seed 1");
    place.make("last", "--n 1 --seed 18446744073709551615");
    assert_same(&place.tree("unsaid"), &place.tree("zero"), "seed 0");
    let (zero, one) = (place.samples("zero"), place.samples("one"));
    for index in 0..3 {
        assert!(zero[&index].text("id") != one[&index].text("id"));
        let (a, b) = (zero[&index].draws(), one[&index].draws());
        let differing = a.iter().filter(|(name, value)| b[*name] != **value).count();
        assert!(differing > 30, "{differing} of {} numbers differ", a.len());
        assert!(zero[&index].image("range") != one[&index].image("range"));
    }
    assert_eq!(place.json("last/dataset.json")["seed"], u64::MAX);
}

#[test]
fn a_changed_key_leaves_every_other_number() {
    let place = Place::with(&[]);
    place.make("old", "--n 6");
    let power = ["power_mw: 50", "power_mw: 80"];
    let waist = ["waist_mm: {uniform: [0.08, 0.13]}", "waist_mm: {uniform: [0.1, 0.2]}"];
    // A class's own key changes its samples alone.
    let reach = ["reach_mm: {uniform: [3, 8]}", "reach_mm: {uniform: [4, 9]}"];
    for (change, key) in [(power, "laser.power_mw"), (waist, "laser.waist_mm"), (reach, "rot.reach_mm")] {
        let other = Place::with(&[change]);
        other.make("new", "--n 6");
        let (old, new) = (place.samples("old"), other.samples("new"));
        let mut changed = 0;
        for (index, sample) in &old {
            let (a, b) = (sample.draws(), new[index].draws());
            assert!(a.len() > 60 && a.keys().eq(b.keys()), "{} numbers", a.len());
            let names: Vec<_> = a.iter().filter(|(name, value)| b[*name] != **value).map(|(name, _)| *name).collect();
            assert!(names.is_empty() || names == [key], "sample {index}: {names:?}");
            let alike = ["class", "split"].map(|c| sample.columns[c] == new[index].columns[c]);
            assert_eq!(alike, [true; 2], "sample {index}");
            changed += names.len();
        }
        assert!(if key == "rot.reach_mm" { (1..6).contains(&changed) } else { changed == 6 }, "{key}: {changed}");
    }
}

#[test]
fn the_same_command_again_touches_no_file() {
    let place = Place::with(&[FRAMES]);
    let first = place.make("set", "--n 5 --samples-per-shard 2");
    assert!(first.err.contains("5 samples in 3 shards made"), "{}", first.err);
    let (bytes, times) = (place.tree("set"), times(&place));
    let again = place.make("set", "--n 5 --samples-per-shard 2");
    assert!(again.err.contains("nothing to do"), "{}", again.err);
    assert_same(&bytes, &place.tree("set"), "again");
    assert_eq!(times, self::times(&place));
}

/// When each file was written, and its number on the disk.
fn times(place: &Place) -> BTreeMap<String, (SystemTime, u64)> {
    use std::os::unix::fs::MetadataExt;
    let root = place.path("set");
    let of = |name: &String| fs::metadata(root.join(name)).expect("the file is there");
    tree(&root)
        .into_keys()
        .map(|name| (name.clone(), (of(&name).modified().expect("a time"), of(&name).ino())))
        .collect()
}
