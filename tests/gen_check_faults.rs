//! `gen check` where something is not as it should be: each fault is told with place and remedy, nothing panics.

mod check_support;
mod gen_support;

use check_support::{CHANNEL, model, planks, run};
use gen_support::Place;

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
        assert!(run.code == 1 && run.err.contains(words), "{name} {arguments}: '{words}' is not in: {}", run.err);
        assert_eq!(run.out, "", "{name} {arguments}");
    }
    let command = format!("--model {} --sidecar side.yaml", model("mean_sign.onnx"));
    for (arguments, code, words) in [
        (format!("check empty {command}"), 1, "holds no dataset.json"),
        (format!("check planks --model {}", model("mean_sign.onnx")), 1, "mean_sign.yaml: the sidecar cannot be read"),
        (format!("check planks {command} --min-accuracy 95"), 2, "no share from 0 to 1"),
        (format!("check planks {command} --batch 0"), 2, "0 is not in"),
        (format!("check planks {command} --threads 0"), 2, "use 1 or more"),
    ] {
        let run = place.run(&arguments);
        assert!(run.code == code && run.err.contains(words), "gen {arguments}: '{words}' is not in: {}", run.err);
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
