//! `gen check` as its users run it, with models whose answers a line of arithmetic foretells
//! (python/make_check_models.py).

use std::path::Path;

use crate::models::{CHANNEL, json, needs_onnxruntime, planks, run};
use crate::scripts::interpreter;
use parquet::record::Field;
use serde_json::{Value, json};
use test_support::program::{self, Place, Sample};

/// Measured Scatter of a sample [DN], NaN where missing, and its columns.
fn scatter(sample: &Sample) -> (usize, Vec<f64>) {
    let (cols, _, numbers) = sample.image("scatter");
    (cols as usize, numbers.into_iter().map(|n| if n == 0 { f64::NAN } else { f64::from(n) }).collect())
}

/// Mean over a window of (Scatter - 600) / 300, 0 where missing: what mean_sign sees.
fn mean(sample: &Sample, first: [i64; 2], size: [i64; 2]) -> f64 {
    let (cols, map) = scatter(sample);
    let rows = (map.len() / cols) as i64;
    let mut sum = 0.0;
    for row in first[0]..first[0] + size[0] {
        for col in first[1]..first[1] + size[1] {
            let inside = (0..rows).contains(&row) && (0..cols as i64).contains(&col);
            let value = if inside { map[row as usize * cols + col as usize] } else { f64::NAN };
            sum += if value.is_nan() { 0.0 } else { (value - 600.0) / 300.0 };
        }
    }
    sum / (size[0] * size[1]) as f64
}

/// Whole samples: what the model says of each is what the arithmetic says, down to confusion, confidence and slices.
#[test]
fn samples_are_judged_as_by_hand() {
    let place = planks();
    let samples = place.samples("planks");
    let names: Vec<String> = place.json("planks/dataset.json")["classes"]
        .as_array()
        .expect("names")
        .iter()
        .map(|name| name.as_str().expect("a name").into())
        .collect();
    let of = |keep: &dyn Fn(&String) -> bool| names.iter().filter(|n| keep(n)).cloned().collect::<Vec<_>>().join(", ");
    let (first, rest) = (of(&|n| *n == names[0]), of(&|n| *n != names[0]));
    let sidecar =
        format!("task: classify_samples\n{CHANNEL}\nclasses: [{{name: a, of: [{first}]}}, {{name: b, of: [{rest}]}}]");
    let found = json(&place, "mean_sign.onnx", &sidecar, "--slice physics.scatter_dark_dn");
    let (mut confusion, mut confidences) = ([[0, 0], [0, 0]], Vec::new());
    for sample in samples.values() {
        let Field::Long(class) = sample.columns["class"] else { panic!("no class") };
        let m = mean(sample, [0, 0], [48, 64]);
        let (truth, guess) = (usize::from(class != 0), usize::from(m < 0.0));
        confusion[truth][guess] += 1;
        if truth != guess {
            confidences.push(1.0 / (1.0 + (-8.0 * m.abs()).exp()));
        }
    }
    assert_eq!(found["confusion"], json!(confusion));
    let right = confusion[0][0] + confusion[1][1];
    assert_eq!((&found["accuracy"]["right"], &found["accuracy"]["of"]), (&json!(right), &json!(6)));
    confidences.sort_by(|a, b| b.total_cmp(a));
    let worst = found["worst"].as_array().expect("a list");
    assert_eq!(worst.len(), confidences.len());
    for (wrong, confidence) in worst.iter().zip(confidences) {
        assert!((wrong["confidence"].as_f64().expect("a number") - confidence).abs() < 1e-5, "{wrong}: {confidence}");
    }
    let groups = found["slices"][0]["groups"].as_array().expect("groups");
    assert_eq!(groups.iter().map(|group| group["of"].as_u64().expect("a count")).sum::<u64>(), 6);
}

/// Whether two documents say the same but for the last digits of onnxruntime's sums.
fn alike(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            a.iter().zip(b).all(|((i, a), (j, b))| i == j && alike(a, b)) && a.len() == b.len()
        }
        (Value::Array(a), Value::Array(b)) => a.iter().zip(b).all(|(a, b)| alike(a, b)) && a.len() == b.len(),
        (Value::Number(a), Value::Number(b)) if a.is_f64() && b.is_f64() => {
            (a.as_f64().unwrap_or(0.0) - b.as_f64().unwrap_or(1.0)).abs() < 1e-6
        }
        _ => a == b,
    }
}

/// Drawn pixels are as many of each class, of that class, and judged by the window around them; neither batch nor
/// threads change anything, the seed does.
#[test]
fn patches_are_balanced_and_repeat() {
    let place = planks();
    let samples = place.samples("planks");
    let sidecar = format!(
        "task: classify_pixels\n{CHANNEL}\nwindow_px: [6, 5]\npatches_per_class: 100\n\
         classes: [clear, {{name: knot, of: [sound_knot, dead_knot]}}]"
    );
    let ask = |arguments: &str| {
        let mut found = json(&place, "mean_sign.onnx", &sidecar, arguments);
        found.as_object_mut().expect("a document").remove("timing");
        found
    };
    let found = ask("--worst 1000");
    // A hundred of each class, shared evenly among the boards that show it, where as many windows lie inside.
    let mut counts = [0, 0];
    for (class, labels) in [[1, 1], [2, 3]].into_iter().enumerate() {
        let images = samples.values().map(|sample| sample.image("label").2);
        let shows = |image: &Vec<u16>| image.iter().any(|label| labels.contains(label));
        let showing: Vec<Vec<u16>> = images.filter(shows).collect();
        for (rank, image) in (0_usize..).zip(&showing) {
            let wanted = (rank + 1) * 100 / showing.len() - rank * 100 / showing.len();
            let inside = |i: usize| (3..46).contains(&(i / 64)) && (2..62).contains(&(i % 64));
            counts[class] += wanted.min((0..64 * 48).filter(|&i| inside(i) && labels.contains(&image[i])).count());
        }
    }
    let supports: Vec<_> = found["classes"].as_array().expect("classes").iter().map(|c| c["support"].clone()).collect();
    assert_eq!(supports, counts);
    assert!(counts[0] == 100 && counts[1] > 0, "{counts:?}");
    let worst = found["worst"].as_array().expect("a list");
    let wrong = (counts[0] + counts[1]) as u64 - found["accuracy"]["right"].as_u64().expect("a count");
    assert!(worst.len() as u64 == wrong && wrong > 0, "{wrong} wrong");
    for wrong in worst {
        let sample = &samples[&wrong["index"].as_i64().expect("a number")];
        let first = [0, 1].map(|i| wrong["first"][i].as_i64().expect("a number"));
        let m = mean(sample, first, [6, 5]);
        let (cols, _, labels) = sample.image("label");
        // The pixel is the first behind the middle of an even side.
        let label = labels[((first[0] + 3) * i64::from(cols) + first[1] + 2) as usize];
        assert_eq!(wrong["truth"], if label == 1 { "clear" } else { "knot" }, "label {label}");
        assert_eq!(wrong["guess"], if m > 0.0 { "clear" } else { "knot" }, "mean {m}");
        let confidence = 1.0 / (1.0 + (-8.0 * m.abs()).exp());
        assert!((wrong["confidence"].as_f64().expect("a number") - confidence).abs() < 1e-5, "{wrong}: {confidence}");
    }
    for same in ["--batch 1", "--batch 7 --threads 1", "--batch 4096 --threads 3"] {
        let other = ask(&format!("--worst 1000 {same}"));
        assert!(alike(&other, &found), "{same}: {other} {found}");
    }
    assert_ne!(ask("--worst 1000 --seed 1")["worst"], found["worst"]);
}

/// Every pixel that has a class of the model is counted once, whether cut whole or in tiles that reach over the border,
/// and with a threshold on Scatter the counts are those of the images.
#[test]
fn segments_are_counted_by_pixel() {
    let place = planks();
    let (mut confusion, mut without) = ([[0_u64; 2]; 2], 0);
    for sample in place.samples("planks").values() {
        let (_, map) = scatter(sample);
        for (value, label) in map.into_iter().zip(sample.image("label").2) {
            let Some(truth) = [None, Some(0), Some(1), Some(1), Some(1)][usize::from(label)] else {
                without += 1;
                continue;
            };
            // Missing is 0 after normalisation, and of two equal numbers the first counts.
            confusion[truth][usize::from(value < 600.0)] += 1;
        }
    }
    let classes = "classes: [clear, {name: bad, of: [sound_knot, dead_knot, rot]}]";
    for window in ["", "window_px: [20, 24]", "window_px: [48, 64]"] {
        let found = json(&place, "pixel_sign.onnx", &format!("task: segment\n{CHANNEL}\n{window}\n{classes}"), "");
        assert_eq!(found["confusion"], json!(confusion), "{window}");
        assert!(found["left_out"] == without && without > 0, "{window}: {} of {without} left out", found["left_out"]);
        let [[a, b], [c, _]] = confusion;
        let iou = found["classes"][0]["iou"].as_f64().expect("a number");
        assert!((iou - a as f64 / (a + b + c) as f64).abs() < 1e-12);
    }
}

/// Two outputs, probabilities, channels last, and EXR where a channel has no PNG.
#[test]
fn other_habits_of_models_are_read() {
    needs_onnxruntime();
    let place = Place::with(&[["png: [range, reflectance, scatter, label]", "png: [scatter, label]"]]);
    place.make("planks", "--n 2");
    let sidecar = "task: classify_pixels
channels: [{name: scatter, mean: 600, sd: 300}, {name: reflectance, mean: 100, sd: 50}]
window_px: [8, 8]
size_px: [4, 4]
layout: nhwc
output: probabilities
output_name: scores
patches_per_class: 20
classes: [clear, {name: knot, of: [sound_knot, dead_knot]}]";
    let found = json(&place, "two_outputs.onnx", sidecar, "");
    assert!(found["accuracy"]["of"].as_u64().is_some_and(|n| n >= 20), "{found}");
    let wrong = run(&place, "two_outputs.onnx", &sidecar.replace("output_name: scores", ""), "");
    assert!(wrong.code == 1 && wrong.err.contains("2 outputs: label, scores; name the one"), "{}", wrong.err);
    let wrong = run(&place, "two_outputs.onnx", &sidecar.replace("scores", "label"), "");
    assert!(wrong.code == 1 && wrong.err.contains("`label` is no tensor of float32"), "{}", wrong.err);
}

/// A model that takes four at once gets four, the last of them filled up; objects of packs are pockets by their worst
/// state.
#[test]
fn objects_of_packs_are_judged_in_fixed_batches() {
    needs_onnxruntime();
    let [_, place, ..] = Place::of_each_subject(&[]);
    place.make("planks", "--n 5");
    let sidecar = "task: classify_objects
channels: [{name: scatter, mean: 600, sd: 300}]
window_px: 24
size_px: 8
classes: [pocket, {name: faulty, of: [missing, broken, chipped, cracked, capped, foreign_tablet, wrong_coat, double]}]";
    let found = json(&place, "fixed.onnx", sidecar, "");
    let mut counts = [0, 0];
    for sample in place.samples("planks").values() {
        let Field::ListInternal(objects) = &sample.columns["objects"] else { panic!("no objects") };
        for object in objects.elements() {
            let Field::Group(object) = object else { panic!("no struct") };
            let number = |name: &str| match object.get_column_iter().find(|(key, _)| *key == name) {
                Some((_, Field::Long(n))) => *n,
                Some((_, Field::Int(n))) => i64::from(*n),
                other => panic!("{name}: {other:?}"),
            };
            if number("within") == 0 {
                match number("state") {
                    6 => counts[0] += 1,
                    7..=14 => counts[1] += 1,
                    _ => {}
                }
            }
        }
    }
    assert_eq!([0, 1].map(|i| found["classes"][i]["support"].as_u64().expect("a count")), counts);
    assert!(counts[0] > 0, "no pocket is seen");
    let wrong = run(&place, "fixed.onnx", sidecar, "--batch 8");
    assert!(wrong.code == 2 && wrong.err.contains("--batch 8: the model takes 4 at once"), "{}", wrong.err);
}

/// Pictures and document lie in the folder, an earlier folder is renewed, and others are left alone; the accuracy
/// decides the exit status.
#[test]
fn reports_are_written_and_accuracy_is_demanded() {
    let place = planks();
    let sidecar =
        format!("task: segment\n{CHANNEL}\nclasses: [clear, {{name: bad, of: [sound_knot, dead_knot, rot]}}]");
    let done = run(&place, "pixel_sign.onnx", &sidecar, "--out wrong --worst 3 --min-accuracy 0");
    assert_eq!((done.code, done.err.as_str()), (0, ""));
    for words in ["accuracy 0.", "precision", "confidence", "most confidently wrong", "exposure.time_us"] {
        assert!(done.out.contains(words), "'{words}' is not in: {}", done.out);
    }
    let document = place.json("wrong/check.json");
    assert_eq!(document["worst"].as_array().map(Vec::len), Some(3));
    let picture = image::open(place.path("wrong").join(document["worst"][0]["picture"].as_str().expect("a name")));
    assert!(picture.expect("it is a picture").width() > 300);
    let below = run(&place, "pixel_sign.onnx", &sidecar, "--out wrong --worst 1 --min-accuracy 1");
    assert!(below.code == 3 && below.err.contains("is below --min-accuracy 1"), "{} {}", below.code, below.err);
    assert!(below.out.contains("accuracy 0."), "{}", below.out);
    assert_eq!(place.tree("wrong").len(), 2, "one picture and the document");
    let other = run(&place, "pixel_sign.onnx", &sidecar, "--out planks");
    assert!(other.code == 2 && other.err.contains("it holds other things; give a new folder"), "{}", other.err);
}

/// The models that are committed are those that their script makes.
#[test]
fn models_are_those_of_the_script() {
    needs_onnxruntime();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let made = Place::new();
    let mut python = interpreter();
    let run = python.arg(root.join("python/make_check_models.py")).arg(made.path(".")).output().expect("python starts");
    let told = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{told}\nif a package is missing: make venv");
    let (made, mut committed) = (made.tree("."), program::tree(&root.join("tests/models")));
    // Beside them lie the networks that train_baseline.py trained; those are tests/python/baselines.rs' affair.
    committed.retain(|name, _| made.contains_key(name));
    assert!(!made.is_empty());
    program::assert_same(&made, &committed, "python/make_check_models.py and tests/models");
}
