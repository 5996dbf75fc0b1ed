//! `gen check` where something is not as it should be: each fault is told with place and remedy, nothing panics,
//! and what was found is lost for no fault that comes after it.

use std::io::Write;
use std::process::Stdio;

use crate::models::{CHANNEL, model, patches, planks, run};
use test_support::program::Place;

/// Whatever cannot be used is told with its place and a remedy.
#[test]
fn faults_name_the_remedy() {
    let place = planks();
    let sidecar = format!("task: classify_samples\n{CHANNEL}\nclasses: [{{name: a, of: []}}, {{name: b, of: []}}]");
    let pixels = format!("task: classify_pixels\n{CHANNEL}\nwindow_px: [8, 8]\nclasses: [clear, rot]");
    let three = pixels.replace("[clear, rot]", "[clear, rot, dead_knot]");
    let twice = pixels.replace("[{name", "[{name: range}, {name");
    let large = pixels.replace("[8, 8]", "[500, 500]");
    std::fs::create_dir(place.path("empty")).expect("the folder is ours");
    for (name, sidecar, arguments, words) in [
        ("truncated.onnx", &pixels, "", "truncated.onnx: it is no usable model"),
        ("nothing.onnx", &pixels, "", "there is no such model; name an ONNX file with --model"),
        ("mean_sign.onnx", &sidecar, "", "it has no samples of the model's classes"),
        ("mean_sign.onnx", &three, "", "it answers in the shape 64 x 2, not 64 x 3; list as many classes"),
        ("mean_sign.onnx", &twice, "", "takes any x 1 x any x any, the sidecar gives any x 2 x 8 x 8"),
        ("mean_sign.onnx", &large, "", "no patches of it lie inside the images"),
        (
            "fixed.onnx",
            &pixels.replace("[8, 8]", "[9, 8]"),
            "",
            "takes 4 x 1 x 8 x 8, the sidecar gives any x 1 x 9 x 8",
        ),
        ("not_a_number.onnx", &pixels, "", "it answers NaN"),
        ("mean_sign.onnx", &format!("{pixels}\noutput: probabilities"), "", "no probabilities; write `output: logits`"),
        ("mean_sign.onnx", &format!("{pixels}\noutput_name: z"), "", "it has no output `z`; give one of y"),
        ("mean_sign.onnx", &pixels, "--split validation", "no samples of the split `validation`; give --split all"),
        ("mean_sign.onnx", &large, "--batch 65536", "takes more than 4 GiB; give a smaller --batch"),
        ("mean_sign.onnx", &pixels, "--slice exposure.tim_us", "did you mean `exposure.time_us`?"),
        ("mean_sign.onnx", &pixels.replace("clear", "cleer"), "", "did you mean `clear`?"),
    ] {
        let run = run(&place, name, sidecar, arguments);
        // What the arguments ask of this model and dataset cannot be had: they are unusable.
        let code = if arguments.contains("--batch") || arguments.contains("--slice") { 2 } else { 1 };
        assert!(run.code == code && run.err.contains(words), "{name} {arguments}: '{words}' is not in: {}", run.err);
        assert_eq!(run.out, "", "{name} {arguments}");
    }
    let command = format!("--model {} --sidecar side.yaml", model("mean_sign.onnx"));
    for (arguments, code, words) in [
        (format!("check empty {command}"), 1, "holds no dataset.json"),
        (format!("check planks --model {}", model("mean_sign.onnx")), 1, "there is no sidecar beside it ("),
        (
            format!("check planks --model {} --sidecar no.yaml", model("mean_sign.onnx")),
            1,
            "no.yaml: the sidecar cannot be read",
        ),
        (format!("check planks {command} --min-accuracy 95"), 2, "no share from 0 to 1"),
        (format!("check planks {command} --batch 0"), 2, "0 is not in"),
        (format!("check planks {command} --threads 0"), 2, "use 1 or more"),
    ] {
        let run = place.run(&arguments);
        assert!(run.code == code && run.err.contains(words), "gen {arguments}: '{words}' is not in: {}", run.err);
        assert!(run.err.matches("name the folder of a dataset").count() <= 1, "{}", run.err);
    }
}

/// A dataset without the channel, a newer one, and a library that is none or not there.
#[test]
fn what_is_not_there_is_told() {
    let place = planks();
    place.write("side.yaml", format!("task: segment\n{CHANNEL}\nclasses: [clear, rot]"));
    let arguments = format!("check planks --split all --sidecar side.yaml --model {}", model("pixel_sign.onnx"));
    place.write("no.so", "nothing");
    for library in ["/nowhere/libonnxruntime.so", "no.so"] {
        let output = place.command(&arguments).env("ORT_DYLIB_PATH", library).output().expect("it starts");
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        for words in ["ORT_DYLIB_PATH names no onnxruntime library", library, "pip install onnxruntime"] {
            assert!(output.status.code() == Some(1) && told.contains(words), "'{words}' is not in: {told}");
        }
        assert!(!told.contains("panicked"), "{told}");
    }
    let head = std::fs::read_to_string(place.path("planks/dataset.json")).expect("it is there");
    let newer = head.replacen("\"schema_version\": [\n    1,", "\"schema_version\": [\n    9,", 1);
    assert_ne!(newer, head, "the version is not where it was");
    place.write("planks/dataset.json", newer);
    let run = place.run(&arguments);
    assert!(run.code == 1 && run.err.contains("newer than 1.x that this program reads"), "{}", run.err);
    let without = Place::with(&[
        ["png: [range, reflectance, scatter, label]", "png: [range, label]"],
        ["exr: [range, reflectance, scatter, label, instance]", "exr: []"],
        ["truth_maps: true", "truth_maps: false"],
    ]);
    without.make("planks", "--n 1");
    without.write("side.yaml", format!("task: segment\n{CHANNEL}\nclasses: [clear, rot]"));
    let run = without.run(&arguments);
    assert!(
        run.code == 1 && run.err.contains("the dataset has no images of `scatter`; write `output: {png:"),
        "{}",
        run.err
    );
}

/// A dataset of sensor rows is refused to a model of millimetres.
#[test]
fn units_are_told() {
    let place = Place::with(&[["\n  window_rows: 7", "\n  range: uncalibrated\n  window_rows: 7"]]);
    place.make("planks", "--n 1");
    let sidecar = "task: segment\nchannels: [{name: range}]\nclasses: [clear, rot]";
    let run = run(&place, "mean_sign.onnx", sidecar, "");
    assert!(
        run.code == 1 && run.err.contains("the model takes `range` in mm, the dataset has it in px; "),
        "{}",
        run.err
    );
}

/// Pictures of an earlier run stay until there are others.
#[test]
fn earlier_pictures_stay_until_there_are_others() {
    let place = planks();
    assert_eq!(run(&place, "mean_sign.onnx", &patches(), "--out wrong --worst 2").code, 0);
    let first = place.tree("wrong");
    assert_eq!(first.len(), 3);
    assert_eq!(run(&place, "truncated.onnx", &patches(), "--out wrong").code, 1);
    assert!(place.tree("wrong") == first, "a model that cannot be opened takes nothing away");
    place.write("wrong/wrong-notes.png", "a file of somebody's");
    assert_eq!(run(&place, "mean_sign.onnx", &patches(), "--out wrong --worst 1").code, 0);
    assert_eq!(place.tree("wrong").len(), 3, "a picture, the document, and what is nobody's to remove");
}

/// Where a report cannot be kept is told before the work; where it cannot be kept after it, it is printed and judged.
#[test]
fn a_report_that_cannot_be_kept_is_printed() {
    let place = planks();
    place.write("planks/reports", "no folder");
    let early = run(&place, "truncated.onnx", &patches(), "--save");
    assert!(early.code == 1 && early.err.contains("or check without --save"), "{}", early.err);
    std::fs::remove_file(place.path("planks/reports")).expect("the file is ours");
    std::fs::create_dir_all(place.path("planks/reports/check-mean_sign-all.json")).expect("a folder in the way");
    let late = run(&place, "mean_sign.onnx", &patches(), "--save");
    assert!(
        late.code == 1 && late.err.contains("cannot write planks/reports/check-mean_sign-all.json"),
        "{}",
        late.err
    );
    assert!(late.out.contains("accuracy 0."), "{}", late.out);
    let below = run(&place, "mean_sign.onnx", &patches(), "--save --min-accuracy 1");
    assert!(below.code == 3 && below.err.contains("cannot write") && below.err.contains("is below"), "{}", below.err);
}

/// A kept report is replaced by that of the same model and split alone.
#[test]
fn kept_reports_never_replace_others() {
    let place = planks();
    let kept = || {
        let names = place.tree("planks/reports").into_keys().filter(|name| name.ends_with(".json"));
        names.collect::<Vec<_>>()
    };
    for arguments in ["--save", "--save --worst 1", "--save --split test"] {
        assert_eq!(run(&place, "mean_sign.onnx", &patches(), arguments).code, 0);
    }
    assert_eq!(kept(), ["check-mean_sign-all.json", "check-mean_sign-test.json"]);
    assert_eq!(place.json("planks/reports/check-mean_sign-all.json")["worst"].as_array().map(Vec::len), Some(1));
    let first = std::fs::read(place.path("planks/reports/check-mean_sign-all.json")).expect("it is there");
    std::fs::create_dir(place.path("other")).expect("a folder");
    std::fs::copy(model("fixed.onnx"), place.path("other/mean_sign.onnx")).expect("a copy");
    let command = "check planks --model other/mean_sign.onnx --sidecar side.yaml --split all --save --worst 2";
    for _ in 0..2 {
        let told = place.done(command).err;
        assert!(told.contains("kept as planks/reports/check-mean_sign-all-2.json"), "{told}");
        assert!(told.contains("check-mean_sign-all.json is of another model by that name, and stays"), "{told}");
    }
    assert_eq!(kept(), ["check-mean_sign-all-2.json", "check-mean_sign-all.json", "check-mean_sign-test.json"]);
    assert!(std::fs::read(place.path("planks/reports/check-mean_sign-all.json")).is_ok_and(|now| now == first));
    let pictures =
        place.tree("planks/reports").into_keys().filter(|name| name.starts_with("check-mean_sign-all-wrong-"));
    assert_eq!(pictures.count(), 1);
}

/// The sums are of the dataset before the work: one that changes meanwhile is told, and what is kept counts as stale.
#[test]
fn a_dataset_that_changes_meanwhile_is_told() {
    let place = planks();
    let arguments = format!("check planks --model {} --sidecar - --split all --save", model("mean_sign.onnx"));
    let mut running = place.command(&arguments).stdin(Stdio::piped()).spawn().expect("the program starts");
    let manifest = std::fs::read_to_string(place.path("planks/shards/00000.json")).expect("a manifest");
    let mut sidecar = running.stdin.take().expect("a pipe");
    // More than a pipe holds: it is taken once the program reads the sidecar, with the sums of before behind it.
    sidecar.write_all(&b"# mean and sign\n".repeat(1 << 14)).expect("the program reads the sidecar");
    place.write("planks/shards/00000.json", format!("{manifest}\n"));
    sidecar.write_all(patches().as_bytes()).expect("the sidecar can be written");
    drop(sidecar);
    let output = running.wait_with_output().expect("the program ends");
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && told.contains("the dataset changed while it was checked"), "{told}");
    let kept = place.json("planks/reports/check-mean_sign-all.json")["manifests_sha256"].clone();
    place.write("planks/shards/00000.json", manifest);
    assert_eq!(run(&place, "mean_sign.onnx", &patches(), "--save").code, 0);
    assert_eq!(place.json("planks/reports/check-mean_sign-all.json")["manifests_sha256"], kept, "the sum of before");
}
