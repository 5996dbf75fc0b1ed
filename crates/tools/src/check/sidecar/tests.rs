use serde_json::json;

use super::*;

/// A dataset of boards with two classes of samples, PNG of range and scatter, EXR of reflectance.
fn head() -> DatasetHead {
    let head = json!({
        "format": "sheetlight-dataset", "schema_version": [1, 2], "generator": { "name": "gen", "version": "0" },
        "target": "any", "recipe": { "name": "r", "text": "", "hash": "", "canonical": {} }, "seed": 0, "samples": 4,
        "samples_per_shard": 2, "shards": 2, "classes": ["sound", "rotten"], "subject": "wood",
        "pixel_classes": ["background", "clear", "sound_knot", "dead_knot", "rot"], "label_values": [0, 1, 2, 3, 4],
        "splits": { "train": 0.8, "validation": 0.1, "test": 0.1 },
        "images": { "cols": 64, "rows": 48, "png": ["range", "scatter", "label"], "exr": ["reflectance"],
            "truth_maps": false, "stack_every": null, "sensor_cols": 64, "sensor_rows": 100,
            "range": "calibrated", "bits": 8 },
        "parameters": [], "physics": [],
    });
    serde_json::from_value(head).expect("it is a head")
}

fn faults(text: &str) -> String {
    Sidecar::parse("m.yaml", text, &head()).expect_err("it has faults").to_string()
}

const KNOTS: &str = "
task: classify_pixels
channels:
  - {name: scatter, mean: 900, sd: 400.5}
  - {name: range, relative: true, missing: -1}
window_px: [32, 16]
size_px: 8
layout: nhwc
output: probabilities
output_name: scores
patches_per_class: 50
classes: [clear, {name: knot, of: [sound_knot, dead_knot]}, {name: never, of: []}]
";

#[test]
fn every_key_is_read() {
    let found = Sidecar::parse("m.yaml", KNOTS, &head()).expect("it is right");
    let channel =
        |name: &str, mean, sd, missing, relative| InputChannel { name: name.into(), mean, sd, missing, relative };
    let wanted = Sidecar {
        task: ModelTask::Pixels,
        channels: vec![channel("scatter", 900.0, 400.5, 0.0, false), channel("range", 0.0, 1.0, -1.0, true)],
        window: Some([32, 16]),
        size: [8, 8],
        layout: Layout::Nhwc,
        output: OutputKind::Probabilities,
        output_name: Some("scores".into()),
        patches_per_class: 50,
        classes: vec!["clear".into(), "knot".into(), "never".into()],
        truth: vec![None, Some(0), Some(1), Some(1), None],
        trained_on: None,
    };
    assert_eq!(found, wanted);
}

/// What is not said: the whole image at its own size, logits, channels first.
#[test]
fn defaults_are_those_of_most_models() {
    let text = "task: classify_samples\nchannels: [reflectance]\nclasses: [rotten, sound]";
    let found = Sidecar::parse("m.yaml", text, &head()).expect("it is right");
    assert_eq!(
        (found.window, found.size, found.layout, found.output),
        (None, [48, 64], Layout::Nchw, OutputKind::Logits)
    );
    assert_eq!((found.truth, found.patches_per_class), (vec![Some(1), Some(0)], 1000));
    let text = "task: segment\nchannels: [scatter]\nwindow_px: [10, 20]\nclasses: [clear, rot]";
    let found = Sidecar::parse("m.yaml", text, &head()).expect("it is right");
    assert_eq!((found.window, found.size), (Some([10, 20]), [10, 20]));
}

/// Every fault at once, each with line, key and remedy.
#[test]
fn faults_come_together() {
    let text = "
task: classify_pixel
chanels: [scatter]
channels: [{name: scater}, {name: scatter, sd: 0}]
window_px: [0, 4]
classes: [clear, clear, {name: knot, of: [sound_not, clear]}]
";
    let told = faults(text);
    for words in [
        "m.yaml:2:7: task: `classify_pixel` is unknown; did you mean `classify_pixels`?",
        "m.yaml:3:1: chanels: `chanels` is no key of a sidecar; did you mean `channels`?",
        "`scater` is unknown; did you mean `scatter`?",
        "channels[1].sd: 0 is out of range",
        "m.yaml:5:13: window_px: 0 is out of range",
    ] {
        assert!(told.contains(words), "'{words}' is not in:\n{told}");
    }
    let told =
        faults("task: segment\nchannels: [scatter]\nclasses: [clear, clear, {name: knot, of: [sound_not, clear]}]");
    for words in [
        "classes[1]: `clear` stands here twice",
        "the dataset has no class `sound_not`; did you mean `sound_knot`? its classes of pixels are background, clear",
        "`clear` belongs to classes[1] already; name it under one class",
    ] {
        assert!(told.contains(words), "'{words}' is not in:\n{told}");
    }
}

#[test]
fn what_the_dataset_lacks_is_told() {
    let mut head = head();
    head.images.png.retain(|name| name != "scatter");
    let told = Sidecar::parse("m.yaml", KNOTS, &head).expect_err("scatter is missing").to_string();
    assert!(told.contains("the dataset has no images of `scatter`; write `output: {png: [..., scatter]}`"), "{told}");
    let told = faults("task: classify_samples\nchannels: [scatter]\nclasses: [clear, rotten]");
    assert!(told.contains("its classes of samples are sound, rotten"), "{told}");
}

/// Where a sidecar names what the model was trained on, samples of the same draws are told: another seed or family has
/// others, and so have the splits test and validation of the very dataset.
#[test]
fn samples_of_the_training_are_told() {
    let base = "task: classify_samples\nchannels: [scatter]\nclasses: [rotten, sound]\n";
    let mut checked = head();
    checked.recipe.canonical = json!({ "family": "wood" });
    (checked.recipe.hash, checked.seed) = ("ab".into(), 7);
    let told = |trained: &str, split| {
        let found = Sidecar::parse("m.yaml", &format!("{base}{trained}"), &checked).expect("it is right");
        found.trained_on.and_then(|trained| trained.shared_draws(&checked, split))
    };
    let (test, train) = (Some(optical_bench::split::Split::Test), Some(optical_bench::split::Split::Train));
    assert_eq!(told("", None), None);
    for other in ["{family: pine, seed: 7}", "{family: wood, seed: 8}"] {
        assert_eq!(told(&format!("trained_on: {other}"), None), None, "{other}");
    }
    let same = "trained_on: {family: wood, seed: 7, recipe_hash: \"ab\"}";
    assert_eq!(told(same, test), None);
    assert!(told(same, train).is_some_and(|what| what.contains("holds the samples of the training")));
    assert!(told(same, None).is_some_and(|what| what.contains("on a dataset of another --seed")));
    for other in ["trained_on: {family: wood, seed: 7}", "trained_on: {family: wood, seed: 7, recipe_hash: \"cd\"}"] {
        assert!(told(other, test).is_some_and(|what| what.contains("alike where the recipes agree")), "{other}");
    }
    let wrong = format!("{base}trained_on: {{family: 3, sed: 7, recipe_hash: 12}}");
    let wrong = faults(&wrong);
    for words in ["trained_on.family", "did you mean `seed`", "trained_on.recipe_hash"] {
        assert!(wrong.contains(words), "'{words}' is not in:\n{wrong}");
    }
    assert!(faults(&format!("{base}trained_on: wood")).contains("trained_on: {family: wood, seed: 0}"));
}

/// Millimetres never become sensor rows without a word: the sidecar says so, or the dataset is refused.
#[test]
fn units_are_held_to_the_dataset() {
    let mut rows = head();
    rows.images.range = "uncalibrated".into();
    let sidecar = |channel: &str| format!("task: classify_samples\nchannels: [{channel}]\nclasses: [rotten, sound]");
    for channel in ["range", "{name: range, sd: 2}", "{name: range, unit: mm}"] {
        assert!(Sidecar::parse("m.yaml", &sidecar(channel), &head()).is_ok(), "{channel}");
        let told = Sidecar::parse("m.yaml", &sidecar(channel), &rows).expect_err(channel).to_string();
        assert!(
            told.contains("takes `range` in mm, the dataset has it in px") && told.contains("`unit: px`"),
            "{told}"
        );
    }
    let own = sidecar("{name: range, unit: px}, {name: scatter, unit: DN}");
    assert!(Sidecar::parse("m.yaml", &own, &rows).is_ok());
    let told = Sidecar::parse("m.yaml", &own, &head()).expect_err("it has millimetres").to_string();
    assert!(told.contains("takes `range` in px, the dataset has it in mm; write `unit: mm`"), "{told}");
    assert!(faults(&sidecar("{name: scatter, unit: mm}")).contains("takes `scatter` in mm"));
}

/// Reflectance and Scatter of another depth are other numbers; Range is not.
#[test]
fn bits_are_held_to_the_dataset() {
    let mut twelve = head();
    twelve.images.bits = 12;
    let sidecar = |rest: &str| format!("task: classify_samples\nchannels: {rest}\nclasses: [rotten, sound]");
    for (rest, of_eight, of_twelve) in [
        ("[scatter]", true, false),
        ("[range, reflectance]", true, false),
        ("[scatter]\nbits: 8", true, false),
        ("[scatter]\nbits: 12", false, true),
        ("[scatter]\nbits: 10", false, false),
        ("[range]", true, true),
    ] {
        for (head, fits) in [(head(), of_eight), (twelve.clone(), of_twelve)] {
            let read = Sidecar::parse("m.yaml", &sidecar(rest), &head);
            assert_eq!(read.is_ok(), fits, "{rest} for {} bits", head.images.bits);
        }
    }
    let told = Sidecar::parse("m.yaml", &sidecar("[scatter]"), &twelve).expect_err("8 are not 12").to_string();
    assert!(told.contains("m.yaml:2:1: channels: the model takes digital numbers of 8 bits"), "{told}");
    assert!(faults(&sidecar("[scatter]\nbits: 12")).contains("m.yaml:3:1: bits: the model takes"));
}

/// Labels are needed where pixels are asked about, as PNG or EXR.
#[test]
fn labels_are_needed_for_pixels() {
    let mut head = head();
    head.images.png.retain(|name| name != "label");
    let told = Sidecar::parse("m.yaml", KNOTS, &head).expect_err("no labels").to_string();
    assert!(told.contains("task: the dataset has no images of `label`"), "{told}");
    head.images.exr.push("label".into());
    assert!(Sidecar::parse("m.yaml", KNOTS, &head).is_ok());
}

#[test]
fn what_cannot_be_meant_is_told() {
    for (text, words) in [
        ("", "a sidecar is a map with task"),
        ("[1]", "the file is a list"),
        ("task: segment", "channels: is missing"),
        ("task: classify_objects\nchannels: [scatter]\nclasses: [clear, rot]", "patches need a window"),
        ("task: segment\nchannels: []\nclasses: [clear, rot]", "channels: is empty"),
        ("task: segment\nchannels: [scatter]\nclasses: [clear]", "has 1 entries; list 2 to 254"),
        ("task: segment\nchannels: [scatter]\nclasses: [clear, 5]", "classes[1]"),
        ("task: segment\nchannels: [scatter]\nclasses: [clear, {name: rot}]", "classes[1].of: is missing"),
        ("task: segment\nchannels: [3]\nclasses: [clear, rot]", "channels[0]"),
        ("task: segment\nchannels: [scatter]\nwindow_px: all\nclasses: [clear, rot]", "`window_px: whole`"),
        ("task: segment\nchannels: [scatter]\nsize_px: [1, 2, 3]\nclasses: [clear, rot]", "size_px: [rows, columns]"),
        ("task: segment\nsd: 3\nchannels: [scatter]\nclasses: [clear, rot]", "`sd` belongs in an entry of `channels`"),
        (
            "task: segment\npatches_per_class: 9\nchannels: [scatter]\nclasses: [clear, rot]",
            "m.yaml:2:20: patches_per_class: has no effect in `segment`",
        ),
        (
            "task: classify_samples\npatches_per_class: 9\nchannels: [scatter]\nclasses: [sound, rotten]",
            "has no effect in `classify_samples`, which asks about all that there is; leave it out",
        ),
        ("task: [", "m.yaml:1"),
    ] {
        let told = faults(text);
        assert!(told.contains(words), "'{words}' is not in:\n{told}");
    }
}
