//! Purpose: `transport` says the same in its short and its long form, and nothing that it says is without effect.

use optical_bench::settings::{ThesisMethod, Transport, TransportName};
use recipe::{Recipe, RecipeError, YamlFault, differences, reference_markdown, schema};
use serde_json::{Value, json};

/// The line of [`text`] that the key stands in.
const LINE: usize = 3;

fn text(transport: &str) -> String {
    format!("name: a\nsubject: wood\n{transport}\nclasses: {{a: {{share: 1}}}}\nunstated: fixed\n")
}

fn recipe(transport: &str) -> Recipe {
    Recipe::parse("good.yaml", &text(transport)).unwrap_or_else(|error| panic!("{error}"))
}

fn faults(transport: &str) -> Vec<YamlFault> {
    match Recipe::parse("bad.yaml", &text(transport)) {
        Err(RecipeError::Faulty(faults)) => faults.list,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("accepted: {transport}"),
    }
}

/// The only fault of `transport` stands in `column` at `key` and says all of `words`.
fn only(transport: &str, column: usize, key: &str, words: &[&str]) {
    let faults = faults(transport);
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert_eq!(
        (faults[0].place.line, faults[0].place.column, faults[0].key.as_str()),
        (LINE, column, key),
        "{}",
        faults[0]
    );
    for word in words {
        assert!(faults[0].to_string().contains(word), "{} lacks {word}", faults[0]);
    }
    assert!(!faults[0].remedy.is_empty(), "{}", faults[0]);
}

fn thesis(method: ThesisMethod, iterations: usize, pixel_mm: f64) -> Transport {
    Transport::Thesis { method, iterations, pixel_mm }
}

/// Ways of writing the same, what they mean, and the canonical form.
fn meanings() -> Vec<(Vec<&'static str>, Transport, Value)> {
    use ThesisMethod::{Bresenham, Conservative, Diffusion};
    let default_thesis = json!({"model": "thesis", "method": "diffusion", "iterations": 20, "pixel_mm": 0.1});
    vec![
        (
            vec!["", "transport:", "transport: {}", "transport: kernel", "transport: {model: kernel}"],
            Transport::Kernel,
            json!({"model": "kernel"}),
        ),
        (
            vec![
                "transport: path",
                "transport: {model: path}",
                "transport: {photons_per_profile: 1e6, model: path}",
                "transport: 'path'",
            ],
            Transport::Path { photons: 1_000_000 },
            json!({"model": "path", "photons_per_profile": 1_000_000}),
        ),
        (
            vec!["transport: {model: path, photons_per_profile: 10000000000}"],
            Transport::Path { photons: 10_000_000_000 },
            json!({"model": "path", "photons_per_profile": 10_000_000_000u64}),
        ),
        (
            vec!["transport: diffusion", "transport: {model: diffusion, voxel_mm: 0.10}"],
            Transport::Diffusion { voxel_mm: 0.1 },
            json!({"model": "diffusion", "voxel_mm": 0.1}),
        ),
        (
            vec!["transport: {model: diffusion, voxel_mm: 0.05}"],
            Transport::Diffusion { voxel_mm: 0.05 },
            json!({"model": "diffusion", "voxel_mm": 0.05}),
        ),
        (
            vec!["transport: thesis", "transport: {model: thesis, method: diffusion, iterations: 20, pixel_mm: 0.1}"],
            thesis(Diffusion, 20, 0.1),
            default_thesis,
        ),
        (
            vec!["transport: {model: thesis, method: conservative, iterations: 4, pixel_mm: 0.5}"],
            thesis(Conservative, 4, 0.5),
            json!({"model": "thesis", "method": "conservative", "iterations": 4, "pixel_mm": 0.5}),
        ),
        (
            vec!["transport: {model: thesis, method: bresenham}"],
            thesis(Bresenham, 0, 0.1),
            json!({"model": "thesis", "method": "bresenham", "pixel_mm": 0.1}),
        ),
    ]
}

#[test]
fn forms_of_the_same_meaning_draw_and_hash_alike() {
    let mut hashes = Vec::new();
    for (forms, meaning, canonical) in meanings() {
        for form in &forms {
            let recipe = recipe(form);
            assert_eq!((recipe.transport(), recipe.draw(0, 7).transport), (meaning, meaning), "{form}");
            assert_eq!(recipe.canonical()["transport"], canonical, "{form}");
            hashes.push((recipe.hash(), canonical.to_string()));
            // The canonical form is a recipe of the same meaning.
            let again = Recipe::parse("canonical.json", &recipe.canonical_json()).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!((again.hash(), again.transport()), (recipe.hash(), meaning), "{form}");
        }
    }
    for (hash, meaning) in &hashes {
        hashes.iter().for_each(|(other, theirs)| assert_eq!(hash == other, meaning == theirs, "{meaning} {theirs}"));
    }
    for (method, name) in ThesisMethod::ALL.into_iter().zip(ThesisMethod::NAMES) {
        let iterations = if method.iterates() { 20 } else { 0 };
        let written = recipe(&format!("transport: {{model: thesis, method: {name}}}"));
        assert_eq!(written.transport(), thesis(method, iterations, 0.1));
    }
    let changed = differences(&recipe("").canonical_json(), &recipe("transport: path").canonical_json());
    let changes = [r#"transport.model: "kernel" -> "path""#, "transport.photons_per_profile: nothing -> 1000000"];
    assert_eq!(changed, changes);
}

#[test]
fn the_model_changes_no_draw() {
    let (kernel, path) = (recipe(""), recipe("transport: path"));
    for index in 0..20 {
        let (one, other) = (kernel.draw(3, index), path.draw(3, index));
        assert_eq!((one.draws(), &one.class, one.split), (other.draws(), &other.class, other.split));
        assert_ne!(one.id, other.id);
    }
}

#[test]
fn what_is_no_transport_says_what_is() {
    let names = "kernel, path, diffusion, thesis";
    only("transport: pth", 12, "transport", &["`pth` is unknown", "did you mean `path`?", names]);
    only("transport: 5", 12, "transport", &["is a number", names, "map of `model`"]);
    only("transport: [path]", 12, "transport", &["is a list", names]);
    only("transport: {model: kernl}", 20, "transport.model", &["did you mean `kernel`?"]);
    only("transport: {model: {path: 1}}", 20, "transport.model", &["is a map", names]);
    only(
        "transport: {model: path, photons_per_profil: 5000}",
        26,
        "transport.photons_per_profil",
        &["did you mean `photons_per_profile`?"],
    );
    only("transport: {model: path, columns: 5}", 26, "transport.columns", &["belongs in `scan`"]);
    only("camera: {voxel_mm: 0.1}", 10, "camera.voxel_mm", &["belongs in `transport`"]);
    only("transprt: path", 1, "transprt", &["did you mean `transport`?"]);
    let method = "transport: {model: thesis, method: bresenhm}";
    only(method, 36, "transport.method", &["did you mean `bresenham`?", "linear_equation"]);
}

#[test]
fn settings_out_of_range_are_faults() {
    for (model, key, from, to, range) in [
        ("path", "photons_per_profile", "999", "10000000001", "a whole number from 1000 to 1e10"),
        ("diffusion", "voxel_mm", "0.049", "0.51", "a number from 0.05 to 0.5 mm"),
        ("thesis", "iterations", "0", "1001", "a whole number from 1 to 1000"),
        ("thesis", "pixel_mm", "0.019", "0.51", "a number from 0.02 to 0.5 mm"),
    ] {
        let start = format!("transport: {{model: {model}, {key}: ");
        for value in [from, to] {
            only(&format!("{start}{value}}}"), start.len() + 1, &format!("transport.{key}"), &["out of range", range]);
        }
        for value in [".nan", "{uniform: [1, 2]}", "much"] {
            only(&format!("{start}{value}}}"), start.len() + 1, &format!("transport.{key}"), &[range]);
        }
    }
    for (model, key) in [("path", "photons_per_profile"), ("thesis", "iterations")] {
        let start = format!("transport: {{model: {model}, {key}: ");
        only(&format!("{start}1000.5}}"), start.len() + 1, &format!("transport.{key}"), &["whole number"]);
    }
}

#[test]
fn settings_without_effect_say_whose_they_are() {
    let settings = [
        ("photons_per_profile", "5000", "path"),
        ("voxel_mm", "0.1", "diffusion"),
        ("method", "diffusion", "thesis"),
        ("iterations", "20", "thesis"),
        ("pixel_mm", "0.1", "thesis"),
    ];
    for model in TransportName::NAMES {
        for (key, value, user) in settings {
            let start = format!("transport: {{model: {model}, ");
            let line = format!("{start}{key}: {value}}}");
            if model == user {
                recipe(&line);
                continue;
            }
            let words = [format!("model `{model}`"), format!("for model `{user}`"), format!("`model: {user}`")];
            let words: Vec<_> = words.iter().map(String::as_str).chain(["has no effect", "remove it"]).collect();
            only(&line, start.len() + 1, &format!("transport.{key}"), &words);
        }
    }
    // Without a model it is the default's, and the order of keys does not matter.
    only("transport: {voxel_mm: 0.1}", 13, "transport.voxel_mm", &["model `kernel`", "`model: diffusion`"]);
    recipe("transport: {voxel_mm: 0.1, model: diffusion}");
    for method in ["linear_equation", "anti_aliased", "bresenham"] {
        let line = format!("transport: {{iterations: 20, model: thesis, method: {method}}}");
        let words = [&format!("no effect on method `{method}`"), "`diffusion` or `conservative`"];
        only(&line, 13, "transport.iterations", &words);
    }
    // A model that is itself a fault leaves open whose the others are, and their ranges are checked all the same.
    only("transport: {model: kernl, voxel_mm: 0.1}", 20, "transport.model", &["`kernel`"]);
    only("transport: {model: thesis, method: lines, iterations: 3}", 36, "transport.method", &["`lines` is unknown"]);
    let both = faults("transport: {model: pth, voxel_mm: 7, iterations: 3}");
    assert_eq!(
        both.iter().map(|fault| fault.key.as_str()).collect::<Vec<_>>(),
        ["transport.model", "transport.voxel_mm"]
    );
    let both = faults("transport: {model: path, photons_per_profile: 7, voxel_mm: 0.1}");
    assert_eq!(both.len(), 2, "{both:?}");
}

#[test]
fn a_class_cannot_have_its_own() {
    for own in ["transport: path", "transport: {model: path}"] {
        let text = format!("name: a\nsubject: wood\nunstated: fixed\nclasses: {{a: {{share: 1, {own}}}}}\n");
        let Err(RecipeError::Faulty(faults)) = Recipe::parse("bad.yaml", &text) else { panic!("accepted: {own}") };
        assert_eq!((faults.list.len(), faults.list[0].key.as_str()), (1, "classes.a.transport"), "{faults}");
        assert!(faults.to_string().contains("`transport` is the same for all classes: set it at the top level"));
    }
}

/// Whether `value` is what `schema` allows, as far as the schema of `transport` goes.
fn allows(schema: &Value, value: &Value) -> bool {
    let kind = if value.is_null() {
        "null"
    } else if value.is_object() {
        "object"
    } else {
        "other"
    };
    let named = |name: &str| match name {
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        _ => name == kind,
    };
    let types = schema["type"]
        .as_str()
        .into_iter()
        .chain(schema["type"].as_array().into_iter().flatten().flat_map(Value::as_str));
    let limit = |name: &str, none: f64| schema[name].as_f64().unwrap_or(none);
    let inside = |number: f64| (limit("minimum", f64::MIN)..=limit("maximum", f64::MAX)).contains(&number);
    let keys = |map: &serde_json::Map<String, Value>| {
        let required = schema["required"].as_array().into_iter().flatten().flat_map(Value::as_str);
        let known = |(key, inner): (&String, &Value)| allows(&schema["properties"][key], inner);
        required.into_iter().all(|key| map.contains_key(key))
            && (schema["properties"].is_null()
                || map.keys().all(|key| !schema["properties"][key].is_null()) && map.iter().all(known))
    };
    (schema["type"].is_null() || types.into_iter().any(named))
        && (schema["const"].is_null() || schema["const"] == *value)
        && schema["enum"].as_array().is_none_or(|words| words.contains(value))
        && value.as_f64().is_none_or(inside)
        && value.as_object().is_none_or(keys)
        && schema["oneOf"].as_array().is_none_or(|forms| forms.iter().filter(|form| allows(form, value)).count() == 1)
}

#[test]
#[ignore = "long"]
fn the_schema_allows_what_the_program_does() {
    let root = schema();
    let schema = &root["properties"]["transport"];
    assert_eq!(schema["oneOf"].as_array().map(Vec::len), Some(6), "a name, four models, the thesis' twice");
    let models = [None, Some("kernel"), Some("path"), Some("diffusion"), Some("thesis"), Some("pth")];
    let settings = [
        [None, Some("999"), Some("5000")],
        [None, Some("0.6"), Some("0.2")],
        [None, Some("conservative"), Some("bresenham")],
        [None, Some("2.5"), Some("30")],
        [None, Some("0.01"), Some("0.05")],
    ];
    let names = ["photons_per_profile", "voxel_mm", "method", "iterations", "pixel_mm"];
    let mut right = 0;
    for (model, code) in models.iter().flat_map(|model| (0..3usize.pow(5)).map(move |code| (model, code))) {
        let choice = (0..5).map(|i| (names[i], settings[i][code / 3usize.pow(i as u32) % 3]));
        let keys = [("model", *model)].into_iter().chain(choice);
        let keys: Vec<_> = keys.filter_map(|(key, value)| Some(format!("{key}: {}", value?))).collect();
        let line = format!("{{{}}}", keys.join(", "));
        let value: Value = serde_saphyr::from_str(&line).expect("YAML");
        let accepted = Recipe::parse("any.yaml", &text(&format!("transport: {line}"))).is_ok();
        assert_eq!(allows(schema, &value), accepted, "{line}");
        right += usize::from(accepted);
    }
    // One with and one without `model: kernel`; path and diffusion 2 each; the thesis' diffusion 4, conservative 4,
    // lines 2.
    assert_eq!(right, 2 + 2 + 2 + 10);
    for (value, right) in [(json!("path"), true), (json!("pth"), false), (json!(5), false), (Value::Null, true)] {
        assert_eq!(allows(schema, &value), right, "{value}");
    }
    let page = reference_markdown();
    let part =
        page.split("### `transport` (settings)").nth(1).and_then(|rest| rest.split("###").next()).expect("its part");
    for row in ["| `model` |", "| 1000000 | 1000 to 10000000000 |", "| mm | 0.1 | 0.02 to 0.5 |", "| 20 | 1 to 1000 |"]
    {
        assert!(part.contains(row), "{row} is not in {part}");
    }
}

/// What lies beyond the kernel's tables is refused by name, and accepted where light is followed without tables.
#[test]
fn media_beyond_the_tables_of_the_kernel_are_refused() {
    const PIECE: &str = "name: a\nsubject: sawtooth\nunstated: fixed\nclasses: {a: {share: 1}}\n";
    for (text, key, words) in [
        (
            text("media: {earlywood_sigma_i_per_mm: 0.3}"),
            "media.earlywood_sigma_i_per_mm",
            ["earlywood", "2.9 %", "3 %"],
        ),
        (
            text("media: {earlywood_k_per_mm: {uniform: [10, 70]}}"),
            "media.earlywood_k_per_mm",
            ["earlywood", "2.8 %", "path"],
        ),
        (text("media: {rot_k_ratio: 5, rot_sigma_i_ratio: 1}"), "media.rot_sigma_i_ratio", ["rot", "2.2 %", "path"]),
        (format!("{PIECE}material: {{n_eff: 1.6}}\n"), "material.n_eff", ["1.6", "1.55", "transport: path"]),
        (format!("{PIECE}material: {{k_per_mm: 40}}\n"), "material.k_per_mm", ["2.4 %", "3 %", "lower k"]),
    ] {
        let accepted = Recipe::parse("path.yaml", &format!("{text}transport: path\n"));
        assert!(accepted.is_ok(), "{text}{}", accepted.err().map(|error| error.to_string()).unwrap_or_default());
        match Recipe::parse("bad.yaml", &text) {
            Ok(_) => panic!("accepted: {text}"),
            Err(RecipeError::Faulty(faults)) => {
                assert_eq!(faults.list.len(), 1, "{faults}");
                assert_eq!(faults.list[0].key, key, "{faults}");
                for word in words {
                    assert!(faults.to_string().contains(word), "{faults} lacks {word}");
                }
            }
            Err(other) => panic!("{other}"),
        }
    }
}
