//! Purpose: `gen transport` answers what a medium file asks, with errors, and refuses what it cannot use by line and
//! key.

use std::fs;

use serde_json::Value;
use test_support::program::{Place, Run};

/// A folder with the example media of the repository.
fn place() -> Place {
    let place = Place::new();
    for (name, text) in examples() {
        place.write(&name, text);
    }
    place
}

fn examples() -> Vec<(String, String)> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/media");
    let files = fs::read_dir(folder).expect("recipes/media").map(|entry| entry.expect("an entry").path());
    let yaml = files.filter(|path| path.extension().is_some_and(|end| end == "yaml"));
    let read = |path: std::path::PathBuf| {
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        (name, fs::read_to_string(&path).expect("a text"))
    };
    yaml.map(read).collect()
}

fn json(run: &Run) -> Value {
    serde_json::from_str(&run.out).unwrap_or_else(|error| panic!("{error}: {}", run.out))
}

fn number(value: &Value) -> (f64, f64) {
    (value["value"].as_f64().expect("a value"), value["error"].as_f64().expect("an error"))
}

/// An answer that is known to be poor says so, in the document and in words; others and other models do not.
#[test]
fn an_answer_in_doubt_says_so() {
    let place = place();
    let layer = "layers: [{n: 1.14, mu_a_per_mm: 0.57, fibres: {sigma_i_per_mm: 0.39, sigma_c_per_mm: 1.25, \
                 azimuth_deg: -7, dive_deg: 13, dispersion_deg: DISPERSED}}]\nquestion: {view_tilt_deg: 27}\n";
    place.write("straight.yaml", layer.replace("DISPERSED", "3.1"));
    place.write("tangled.yaml", layer.replace("DISPERSED", "8"));
    place.write("weak.yaml", layer.replace("DISPERSED", "8").replace("1.25", "0.25"));
    let asked = |medium: &str, model: &str| {
        place.done(&format!("transport --medium {medium}.yaml --model {model} --photons 200 --out said.json"))
    };
    for (medium, what) in [("straight", "fibres lie along the motion"), ("weak", "matter scatters less than")] {
        let run = asked(medium, "kernel");
        let words = place.json("said.json")["in_doubt"].as_str().expect("words").to_owned();
        assert!(words.contains(what) && run.err.contains(&words), "{words}: {}", run.err);
        assert!(run.err.contains("`--model path`"), "{}", run.err);
    }
    for (medium, model) in [("straight", "path"), ("tangled", "kernel"), ("clear-wood", "kernel")] {
        let run = asked(medium, model);
        assert!(place.json("said.json")["in_doubt"].is_null() && !run.err.contains("in doubt"), "{}", run.err);
    }
}

/// `gen rig` tells it of the matter of a sample that the kernel answers for.
#[test]
fn a_rig_with_light_in_doubt_says_so() {
    let place = place();
    let steep = "wood-small --set camera.tilt_deg=";
    let pack = "blister-small --set film.sigma_per_mm=0.2 --set foil.roughness_across=";
    for (asked, expected) in [
        (format!("{steep}75"), None),
        (format!("{pack}0.7 --set foil.roughness_along=0.05"), Some("is in doubt: clear film is sealed to foil")),
        (format!("{pack}0.7 --set foil.roughness_along=0.05 --set transport=path"), None),
        (format!("{pack}0.3"), None),
    ] {
        let run = place.run(&format!("rig {asked}"));
        let words = expected.unwrap_or("in doubt");
        assert!(run.code == 0 && run.err.contains(words) == expected.is_some(), "{asked}: {}", run.err);
    }
}

/// Van de Hulst's slab through the command: within 3.5 standard errors of the published numbers, and energy closes.
#[test]
fn a_published_value_comes_out() {
    let place = place();
    let run = place.done("transport --medium van-de-hulst.yaml --model path --photons 200000 --seed 3");
    assert_eq!(run.err, "", "standard error is for people at a terminal");
    let document = json(&run);
    let answer = &document["answer"];
    for (key, truth) in [("reflectance", 0.09739), ("transmittance", 0.66096), ("unscattered", (-2f64).exp())] {
        let (value, error) = number(&answer[key]);
        assert!(error > 0.0 && error < 0.002, "{key}: error {error}");
        assert!((value - truth).abs() < 3.5 * error, "{key}: {value} +- {error} against {truth}");
    }
    let absorbed: f64 = answer["absorbed"].as_array().expect("layers").iter().map(|layer| number(layer).0).sum();
    let sum = answer["specular"].as_f64().expect("a number")
        + number(&answer["reflectance"]).0
        + number(&answer["transmittance"]).0
        + absorbed;
    assert!((sum - 1.0).abs() < 1e-6, "energy {sum}");
    let keys: Vec<_> = document.as_object().expect("a map").keys().collect();
    assert_eq!(keys, ["schema_version", "program", "model", "effort", "medium", "question", "in_doubt", "answer"]);
    assert_eq!(document["effort"]["photons"], 200_064, "whole batches of 128");
}

/// Every example is read; what is shown as understood is a medium of the same meaning; and the first lines say what it
/// is.
#[test]
fn examples_are_understood() {
    let place = place();
    let examples = examples();
    assert!(examples.len() >= 6);
    for (name, text) in examples {
        for word in ["# ", "# Source: ", "# Published: |# Known: "] {
            assert!(word.split('|').any(|word| text.contains(word)), "{name} has no `{word}`");
        }
        let one = json(&place.done(&format!("transport --medium {name} --model path --photons 128")));
        let mut again = one["medium"].clone();
        again["question"] = one["question"].clone();
        place.write("again.yaml", again.to_string());
        let other = json(&place.done("transport --medium again.yaml --model path --photons 128"));
        for key in ["medium", "question"] {
            assert_eq!(one[key], other[key], "{name}");
        }
    }
}

/// Every example is built in too: by its name, and where its file is missing, which is told.
#[test]
fn examples_are_built_in() {
    let (beside, bare) = (place(), Place::new());
    for (name, _) in examples() {
        let ask = |name: &str| format!("transport --medium {name} --model path --photons 128");
        let file = beside.done(&ask(&name));
        let stem = name.trim_end_matches(".yaml");
        let built_in = bare.done(&ask(stem));
        assert_eq!((file.out.as_str(), built_in.err.as_str()), (built_in.out.as_str(), ""), "{name}");
        let missing = bare.done(&ask(&format!("recipes/media/{name}")));
        assert!(missing.out == file.out && missing.err.contains("the built-in medium"), "{}", missing.err);
    }
}

/// Bytes are the same for one thread and for two, on standard output and in a file; another seed gives others.
#[test]
fn bytes_follow_from_medium_and_effort() {
    let place = place();
    let ask = "transport --medium clear-wood.yaml --model path --photons 2000";
    let one = place.done(&format!("{ask} --threads 1")).out;
    assert_eq!(one, place.done(&format!("{ask} --threads 2")).out);
    let run = place.done(&format!("{ask} --out answer.json"));
    assert_eq!(run.out, "");
    assert!(run.err.contains("diffusely reflected"), "{}", run.err);
    assert_eq!(one.as_bytes(), fs::read(place.path("answer.json")).expect("it is there"));
    assert_ne!(one, place.done(&format!("{ask} --seed 1")).out);
    let left: Vec<_> = place.tree("").into_keys().filter(|name| name.contains("tmp")).collect();
    assert!(left.is_empty(), "{left:?}");
}

/// The kernel answers clear wood as the table of docs/theory/physics.md says, without errors, and refuses layers.
#[test]
fn the_kernel_answers_what_it_knows() {
    let place = place();
    let document = json(&place.done("transport --medium clear-wood.yaml --model kernel"));
    assert_eq!(document["effort"], Value::Null);
    let (r, error) = number(&document["answer"]["reflectance"]);
    assert!((r - 0.746).abs() < 0.012 && error == 0.0, "{r} +- {error}");
    let run = place.run("transport --medium mcml-three-layers.yaml --model kernel");
    assert_eq!(run.code, 1);
    assert!(run.err.contains("the kernel knows half spaces") && run.err.contains("--model path"), "{}", run.err);
}

/// The kernel answers pockets and flanges of blister packs: energy closes, a film on foil is brighter near the line
/// than one over a deep pocket. Diffusion refuses foil.
#[test]
fn the_kernel_answers_films() {
    let place = place();
    let ask =
        |name: &str| json(&place.done(&format!("transport --medium {name}.yaml --model kernel")))["answer"].clone();
    let [empty, sealed] = [ask("white-pvc-over-air-over-foil"), ask("sealed-flange")];
    let row = |answer: &Value, row: usize| number(&answer["line"][40 + row]).0;
    for answer in [&empty, &sealed] {
        let absorbed: f64 = answer["absorbed"].as_array().expect("layers").iter().map(|layer| number(layer).0).sum();
        let sum = answer["specular"].as_f64().expect("a number") + number(&answer["reflectance"]).0 + absorbed;
        assert!((sum - 1.0).abs() < 1e-5, "energy {sum}");
    }
    assert!(row(&sealed, 2) > 1.2 * row(&empty, 2), "{} and {}", row(&sealed, 2), row(&empty, 2));
    let run = place.run("transport --medium sealed-flange.yaml --model diffusion");
    assert!(run.code == 1 && run.err.contains("foil") && run.err.contains("path"), "{}", run.err);
}

/// A wrong medium is answered with line, column, key and remedy; all faults at once.
#[test]
fn faults_name_line_and_key() {
    let place = Place::new();
    let layer = "n: 1.4, mu_a_per_mm: 0.1";
    let cases: [(String, &[&str]); 26] = [
        (String::new(), &["m.yaml:1:1", "empty"]),
        ("layers: []".into(), &["m.yaml:1:9: layers: has 0 layers", "1 to 64"]),
        ("layers: 3".into(), &["m.yaml:1:9: layers: is a number", "list"]),
        ("n_above: 1".into(), &["layers: is missing"]),
        ("layers: [3]".into(), &["layers[0]: is a number", "map"]),
        (format!("layers:\n  - {{{layer}, thickness_mm: 0}}"), &["m.yaml:2:", "thickness_mm: 0 is out of range"]),
        (format!("layers:\n  - {{{layer}, thickness_mm: -1}}"), &["thickness_mm: -1 is out of range", "mm"]),
        (format!("layers:\n  - {{{layer}, thickness_mm: .inf}}"), &["thickness_mm: is inf", "finite"]),
        (format!("layers:\n  - {{{layer}}}\n  - {{{layer}}}"), &["m.yaml:2:", "layers[0].thickness_mm: is missing"]),
        ("layers: [{n: .nan, mu_a_per_mm: 0}]".into(), &["layers[0].n: is NaN", "1 to 4"]),
        ("layers: [{n: 0.5, mu_a_per_mm: 0}]".into(), &["layers[0].n: 0.5 is out of range"]),
        ("layers: [{n: 1.4}]".into(), &["layers[0].mu_a_per_mm: is missing"]),
        ("layers: [{n: 1.4, mu_a: 1}]".into(), &["`mu_a` is no key", "mu_a_per_mm"]),
        (format!("layers: [{{{layer}, isotropic: {{mu_s_per_mm: -2}}}}]"), &["isotropic.mu_s_per_mm: -2"]),
        (format!("layers: [{{{layer}, isotropic: {{mu_s_per_mm: 2, g: 1}}}}]"), &["isotropic.g: 1 is out of range"]),
        (
            format!("layers: [{{{layer}, isotropic: {{mu_s_per_mm: 2}}, tensor: {{mu_s_per_mm: [1, 1, 1]}}}}]"),
            &["layers[0].tensor: is a second law", "remove the others"],
        ),
        (format!("layers: [{{{layer}, tensor: {{mu_s_per_mm: [1, 2]}}}}]"), &["mu_s_per_mm: has 2 entries", "three"]),
        (
            format!("layers: [{{{layer}, fibres: {{sigma_i_per_mm: 1, sigma_c_per_mm: 1, g2: 0, turn: mirror}}}}]"),
            &["fibres.turn: stands beside `g2`", "remove one"],
        ),
        (
            format!("layers: [{{{layer}, fibres: {{sigma_i_per_mm: 1, sigma_c_per_mm: 1, turn: miror}}}}]"),
            &["`miror` is unknown", "did you mean `mirror`"],
        ),
        (
            format!("layers: [{{{layer}}}]\nquestion: {{diffuse: true, incidence_deg: 0}}"),
            &["m.yaml:2:", "question.diffuse: stands beside `incidence_deg`"],
        ),
        (format!("layers: [{{{layer}, coat: 2}}]"), &["layers[0].coat: 2 is out of range"]),
        (format!("layers: [{{{layer}}}]\nbelow: {{}}"), &["m.yaml:2:", "below.foil: is missing", "n_below"]),
        (
            format!("layers: [{{{layer}}}]\nbelow: {{foil: {{reflectance: 0.9, roughness: 0.2}}}}"),
            &["below.foil.roughness: is a number", "two numbers"],
        ),
        (
            format!("layers: [{{{layer}}}]\nn_below: 1\nbelow: {{foil: {{reflectance: 1, roughness: [1, 1]}}}}"),
            &["m.yaml:2:", "n_below: stands beside `below`", "remove one"],
        ),
        (format!("layers: [{{{layer}}}]\nquestion: {{rows: 1e9}}"), &["question.rows", "2000"]),
        (format!("layers: [{{{layer}}}]\nisotropic: {{g: 0}}"), &["`isotropic` belongs in an entry of `layers`"]),
    ];
    for (text, words) in cases {
        place.write("m.yaml", &text);
        let run = place.run("transport --medium m.yaml --model path --photons 128");
        assert_eq!((run.code, run.out.as_str()), (1, ""), "{text}");
        for word in words {
            assert!(run.err.contains(word), "no `{word}` for\n{text}\nin\n{}", run.err);
        }
    }
    place.write("m.yaml", "layers:\n  - {n: 9, mu_a_per_mm: -1}\nn_below: x\n");
    let run = place.run("transport --medium m.yaml --model path");
    assert!(run.err.contains("m.yaml has 3 faults"), "{}", run.err);
}

/// Bad arguments and places: refused with a reason and a remedy before any photon is walked.
#[test]
fn what_cannot_be_done_is_said() {
    let place = place();
    let refused = |arguments: &str, code: i32, words: &[&str]| {
        let run = place.run(arguments);
        assert_eq!((run.code, run.out.as_str()), (code, ""), "gen {arguments}\n{}", run.err);
        for word in words {
            assert!(run.err.contains(word), "gen {arguments}: no `{word}` in\n{}", run.err);
        }
    };
    let much = "transport --medium clear-wood.yaml --model path --photons 1000000000";
    refused("transport --medium clear-wood.yaml --model oracle", 2, &["oracle", "path", "kernel"]);
    refused("transport --medium clear-wood.yaml --model path --photons 0", 2, &["--photons", "0"]);
    refused("transport --medium nowhere.yaml --model path", 1, &["nowhere.yaml", "recipes/media"]);
    refused(&format!("{much} --out no/such/folder.json"), 1, &["no folder no/such", "--out"]);
    refused(&format!("{much} --out ."), 1, &["--out"]);
    refused(&format!("{much} --threads 0"), 2, &["--threads 0"]);
    let help = place.done("transport --help").out;
    assert!(help.contains("Examples:") && help.contains("recipes/media/README.md"), "{help}");
}

/// The reference blurs the line spread by the line's width and leaves the point spread alone.
#[test]
fn the_line_has_its_width() {
    let place = Place::new();
    let ask = |line: f64| {
        let layer = "{n: 1, mu_a_per_mm: 5, isotropic: {mu_s_per_mm: 50}}";
        let question = format!("{{line_sd_mm: {line}, row_mm: 0.02, rows: 200, cell_mm: 0.05, cells: 20, angles: 0}}");
        place.write("m.yaml", format!("layers: [{layer}]\nquestion: {question}\n"));
        json(&place.done("transport --medium m.yaml --model path --photons 40000"))["answer"].clone()
    };
    let variance = |answer: &Value| {
        let rows: Vec<f64> = answer["line"].as_array().expect("rows").iter().map(|row| number(row).0).collect();
        let y = |i: usize| (i as f64 - 200.0) * 0.02;
        let sum: f64 = rows.iter().sum();
        rows.iter().enumerate().map(|(i, share)| share * y(i) * y(i)).sum::<f64>() / sum
    };
    let (fine, wide) = (ask(0.0), ask(0.3));
    assert_eq!(fine["point"], wide["point"]);
    assert_eq!(fine["reflectance"], wide["reflectance"]);
    // Of some 28000 photons that leave, each adds a square with a relative spread of sqrt(2): 0.8 %; four of them.
    let added = variance(&wide) - variance(&fine);
    assert!((added / 0.09 - 1.0).abs() < 0.035, "{added}");
}
