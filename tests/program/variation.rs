//! What varies: told by the commands, written in the table of samples, and fixed in datasets that older programs began.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use parquet::record::Field;
use serde_json::{Value, json};
use test_support::program::Place;

/// A first recipe of packs, small enough to render some.
const PACKS: &str = "\
name: few
subject: blister
scan: {columns: 128, profiles: 96}
motion: {step_mm: 0.184}
rigs: 3
samples_per_batch: 2
pack: {width_mm: 11.5, length_mm: 16, columns: 1, rows: 1, lead_in_mm: 1}
tablet: {length_mm: 6, width_mm: 6, thickness_mm: 3, band_mm: 2, mu_a_per_mm: {log_uniform: [0.002, 0.01]}}
classes: {sound: {share: 1}, missing: {share: 1, defects: {missing: 1}}}
output: {exr: [], truth_maps: false}
";

/// How many numbers vary by nature, and how many could.
fn numbers(place: &Place, word: &str) -> [u64; 2] {
    let rig: Value = serde_json::from_str(&place.done(&format!("rig few.yaml {word} --json")).out).expect("JSON");
    ["natural", "fixed"].map(|name| rig["variation"][name].as_u64().expect("a count"))
}

/// Each command says how many numbers vary, and which are fixed that classes are told by.
#[test]
fn commands_say_how_many_numbers_vary() {
    let place = Place::new();
    place.write("few.yaml", PACKS);
    let ([natural, left], [none, held_numbers]) = (numbers(&place, ""), numbers(&place, "--set unstated=fixed"));
    assert!(
        natural > 30 && none == 0 && held_numbers == natural + left,
        "{natural} and {left}, {none} and {held_numbers}"
    );
    let told = format!(" numbers vary as the recipe states, {natural} by nature");
    let fixed = "`tablet.sigma_per_mm`";
    for command in ["rig few.yaml", "preview --recipe few.yaml"] {
        let drawn = place.done(command).err;
        assert!(drawn.contains(&told) && !drawn.contains(fixed), "{command}: {drawn}");
        let held = place.done(&format!("{command} --set unstated=fixed")).err;
        assert!(held.contains(&format!("{held_numbers} more that could are fixed")) && held.contains(fixed), "{held}");
    }
    let estimate = place.done("--recipe few.yaml --n 12 --estimate --set splits.by=[rig]").out;
    assert!(
        estimate.contains(&told) && estimate.contains("splits part no rigs: 4 to train (33.3 % of 80.0)"),
        "{estimate}"
    );
}

/// The table of samples says which instrument and batch a sample has; their numbers are the same in all of it.
#[test]
fn the_table_says_rig_and_batch() {
    let place = Place::new();
    place.write("few.yaml", PACKS);
    let made = place.done("--recipe few.yaml --n 12 --out set").err;
    assert!(made.contains("splits part no batches: "), "{made}");
    let mut values: BTreeMap<(&str, i64), BTreeSet<String>> = BTreeMap::new();
    let samples = place.samples("set");
    for (index, sample) in &samples {
        let whole = |name: &str| match &sample.columns[name] {
            Field::Long(number) => Some(*number),
            _ => None,
        };
        assert_eq!((whole("log_number"), whole("batch")), (None, Some(index / 2)));
        let rig = whole("rig").expect("a rig");
        assert!(rig < 3);
        let draws = sample.draws();
        for (group, number, path) in [("rig", rig, "laser.power_mw"), ("batch", index / 2, "film.sigma_per_mm")] {
            values.entry((group, number)).or_default().insert(format!("{}", draws[path]));
        }
    }
    assert!(values.len() == 9 && values.values().all(|values| values.len() == 1), "{values:?}");
    place.done("validate set");
    let page = test_support::pages::page(&place, "set", "");
    assert!(page.contains("numbers vary as the recipe states"), "the report says it too");
}

/// A dataset that an older program began means what its numbers are at their defaults.
#[test]
fn older_datasets_hold_what_is_not_stated() {
    let place = Place::new();
    place.write("few.yaml", PACKS.replace("rigs: 3\nsamples_per_batch: 2\n", "unstated: fixed\n"));
    place.done("--recipe few.yaml --n 1 --out set");
    let mut head = place.json("set/dataset.json");
    let text = head["recipe"]["text"].as_str().expect("a text").replace("unstated: fixed\n", "");
    head["recipe"]["text"] = text.into();
    let write = |head: &Value| fs::write(place.path("set/dataset.json"), format!("{head:#}")).expect("written");
    write(&head);
    place.run("recipe show set").refused(&["means something else"]);
    head["schema_version"] = json!([1, 7]);
    write(&head);
    let shown = place.done("recipe show set --json").out;
    let canonical: Value = serde_json::from_str(&shown).expect("JSON");
    assert_eq!(canonical["film"]["sigma_per_mm"], json!(12.0));
}
