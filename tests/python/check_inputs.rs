//! What `gen check` is given: a model with its weights and its sidecar, a dataset that has what the model looks at, and
//! numbers of it that mean something.

use crate::models::{CHANNEL, json, model, needs_onnxruntime, patches, planks, run};
use serde_json::Value;
use sha2::{Digest, Sha256};
use test_support::program::{Place, Sample};

/// Digital numbers of another depth are other units: a model that looks at them is refused unless its sidecar says so;
/// one that looks at heights alone does not care.
#[test]
fn another_bit_depth_is_refused() {
    needs_onnxruntime();
    let place = Place::with(&[["\nexposure:", "\nexposure:\n  bits: 12"]]);
    place.make("planks", "--n 1");
    let segment = |channel: &str| format!("task: segment\nchannels: [{channel}]\nclasses: [clear, rot]");
    for channel in ["scatter", "reflectance"] {
        let refused = run(&place, "pixel_sign.onnx", &segment(channel), "");
        for words in
            ["takes digital numbers of 8 bits, the dataset has them of 12", "`bits: 12`", "exposure: {bits: 8}"]
        {
            assert!(refused.code == 1 && refused.err.contains(words), "'{words}' is not in: {}", refused.err);
        }
        let told = run(&place, "pixel_sign.onnx", &format!("{}\nbits: 12", segment(channel)), "");
        assert_eq!((told.code, told.err.as_str()), (0, ""));
    }
    assert_eq!(run(&place, "pixel_sign.onnx", &segment("range"), "").code, 0);
}

/// Without images of labels there is nothing to hold pixels to, which is told at once; samples and objects have their
/// classes in the tables.
#[test]
fn a_dataset_without_label_images_is_told() {
    needs_onnxruntime();
    let place = Place::with(&[
        ["png: [range, reflectance, scatter, label]", "png: [scatter]"],
        ["exr: [range, reflectance, scatter, label, instance]", "exr: []"],
        ["truth_maps: true", "truth_maps: false"],
    ]);
    place.make("planks", "--n 2");
    for task in ["segment", "classify_pixels\nwindow_px: 8"] {
        let told = run(&place, "pixel_sign.onnx", &format!("task: {task}\n{CHANNEL}\nclasses: [clear, rot]"), "");
        let words =
            "the dataset has no images of `label` to hold it to; write `output: {png: [..., label]}` in the recipe";
        assert!(told.code == 1 && told.err.contains(words), "'{words}' is not in: {}", told.err);
    }
    let head = place.json("planks/dataset.json");
    let classes: Vec<&str> =
        head["classes"].as_array().expect("names").iter().filter_map(|name| name.as_str()).collect();
    let samples = format!(
        "task: classify_samples\n{CHANNEL}\nclasses: [{{name: a, of: [{}]}}, {{name: b, of: [{}]}}]",
        classes[0],
        classes[1..].join(", ")
    );
    assert_eq!(run(&place, "mean_sign.onnx", &samples, "").code, 0);
}

/// A sidecar that names a dataset of the same draws is told on standard error, with what to do; one that names another
/// is not.
#[test]
fn samples_of_the_training_are_told() {
    let place = planks();
    let head = place.json("planks/dataset.json");
    let family = head["recipe"]["canonical"]["family"].as_str().expect("a family");
    let hash = head["recipe"]["hash"].as_str().expect("a hash");
    let told = |seed: u64, rest: &str, arguments: &str| {
        let sidecar = format!("{}\ntrained_on: {{family: {family}, seed: {seed}{rest}}}", patches());
        let run = run(&place, "mean_sign.onnx", &sidecar, arguments);
        assert_eq!(run.code, 0, "{}", run.err);
        run.err
    };
    let same = format!(", recipe_hash: \"{hash}\"");
    assert!(told(0, &same, "").contains("note: the sidecar says that the model was trained on family"));
    assert!(told(0, "", "--split test").contains("check it on a dataset of another --seed"));
    assert_eq!((told(0, &same, "--split test"), told(1, "", "")), (String::new(), String::new()));
}

/// An EXR file that broke off is named with its sample, not the table beside it.
#[test]
fn a_broken_exr_is_named() {
    needs_onnxruntime();
    let place = Place::with(&[["png: [range, reflectance, scatter, label]", "png: [label]"]]);
    place.make("planks", "--n 1");
    let sidecar = format!("task: segment\n{CHANNEL}\nclasses: [clear, rot]");
    let name = place.tree("planks").into_keys().find(|name| name.ends_with(".exr")).expect("it has EXR files");
    let path = format!("planks/{name}");
    let whole = std::fs::read(place.path(&path)).expect("it is there");
    let told = |wanted: &str| {
        let told = run(&place, "pixel_sign.onnx", &sidecar, "");
        let start = format!("gen: {path}: sample 0: ");
        assert!(told.code == 1 && told.err.starts_with(&start) && told.err.contains(wanted), "{}", told.err);
        assert!(told.err.contains("; `gen validate` says what is damaged"), "{}", told.err);
    };
    place.write(&path, &whole[..whole.len() / 2]);
    told("");
    std::fs::remove_file(place.path(&path)).expect("it is ours");
    told("No such file");
}

/// The sidecar is found beside the model by any of its endings; of two nobody knows which is meant.
#[test]
fn sidecars_are_found_beside_the_model() {
    let place = planks();
    std::fs::copy(model("mean_sign.onnx"), place.path("m.onnx")).expect("a copy");
    let check = "check planks --model m.onnx --split all";
    let json =
        "{\"task\": \"classify_pixels\", \"channels\": [{\"name\": \"scatter\", \"mean\": 600}], \"window_px\": 8,
        \"patches_per_class\": 5, \"classes\": [\"clear\", \"rot\"]}";
    for (name, text) in [("m.json", json), ("m.yml", patches().as_str()), ("m.yaml", patches().as_str())] {
        place.write(name, text);
        assert_eq!(place.done(check).err, "");
        std::fs::remove_file(place.path(name)).expect("it is ours");
    }
    let none = place.run(check);
    for words in ["m.onnx: there is no sidecar beside it (m.yaml, m.yml, m.json)", "name it with --sidecar"] {
        assert!(none.code == 1 && none.err.contains(words), "'{words}' is not in: {}", none.err);
    }
    place.write("m.json", json);
    place.write("m.yaml", patches());
    let two = place.run(check);
    for words in ["m.yaml and m.json lie beside it", "--sidecar"] {
        assert!(two.code == 1 && two.err.contains(words), "'{words}' is not in: {}", two.err);
    }
    place.done(&format!("{check} --sidecar m.json"));
}

/// A model's sum goes on over the weights that lie beside it, so that another training never takes the place of one
/// whose graph is the same.
#[test]
fn weights_in_other_files_are_of_the_model() {
    let place = planks();
    let mut right = Vec::new();
    for (folder, sign) in [("first", 1.0_f32), ("second", -1.0)] {
        std::fs::create_dir(place.path(folder)).expect("a folder");
        std::fs::copy(model("external.onnx"), place.path(folder).join("m.onnx")).expect("a copy");
        let weights = [4.0 * sign, -4.0 * sign].map(f32::to_le_bytes).concat();
        place.write(&format!("{folder}/external.data"), &weights);
        place.write("side.yaml", patches());
        let command = format!("check planks --model {folder}/m.onnx --sidecar side.yaml --split all --json --save");
        let found: Value = serde_json::from_str(&place.done(&command).out).expect("it prints JSON");
        right.push(found["accuracy"]["right"].as_u64().expect("a count"));
        let all = [std::fs::read(model("external.onnx")).expect("it is there"), weights].concat();
        let sum: String = Sha256::digest(&all).iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(found["model"]["sha256"], sum.as_str(), "cat m.onnx external.data | sha256sum");
    }
    assert_ne!(right[0], right[1], "the weights say what is answered");
    let kept = place.tree("planks/reports").into_keys().filter(|name| name.ends_with(".json"));
    assert_eq!(kept.collect::<Vec<_>>(), ["check-m-all-2.json", "check-m-all.json"]);
}

/// The width of knots is drawn for boards without knots too, where it means nothing: they are a group of their own.
#[test]
fn numbers_of_what_is_not_there_are_none() {
    let place = planks();
    let sidecar =
        format!("task: segment\n{CHANNEL}\nclasses: [clear, {{name: bad, of: [sound_knot, dead_knot, rot]}}]");
    let samples = place.samples("planks");
    let without = |counts: &[&str]| {
        let is_none = |sample: &&Sample| counts.iter().all(|path| sample.draws()[path] == 0.0);
        samples.values().filter(is_none).count() as u64
    };
    let cases = [
        ("knots.width_mm", without(&["knots.sound_count", "knots.dead_count"])),
        ("media.dead_knot_mu_a_ratio", without(&["knots.dead_count"])),
        ("rot.severity", without(&["rot.reach_mm"])),
        ("rot.reach_mm", 0),
    ];
    assert!(
        (1..6).contains(&cases[0].1) && (1..6).contains(&cases[2].1),
        "six boards have knots and rot, some of them"
    );
    for (path, without) in cases {
        let found = json(&place, "pixel_sign.onnx", &sidecar, &format!("--slice {path}"));
        let groups = found["slices"][0]["groups"].as_array().expect("groups");
        let none = groups.iter().find(|group| group["from"].is_null());
        assert_eq!(none.map_or(0, |group| group["samples"].as_u64().expect("a count")), without, "{path}");
        assert_eq!(groups.iter().map(|group| group["samples"].as_u64().expect("a count")).sum::<u64>(), 6, "{path}");
    }
}
