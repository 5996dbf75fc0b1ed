//! Purpose: whatever is wrong with a recipe is reported with its line, its key and its remedy, all at once, without
//! panic.

use crate::support::{GOOD, faults, only, whole};
use base::Stream;
use rand::RngExt;
use recipe::{Recipe, RecipeError};

#[test]
fn good_is_good() {
    let recipe = Recipe::parse("good.yaml", GOOD).expect("it is");
    assert_eq!(recipe.name(), "good");
    assert_eq!(recipe.size().columns, 2560);
}

#[test]
fn unknown_keys_get_the_nearest_spelling() {
    only("camera: {tilt_dg: 25}", (1, 10), "camera.tilt_dg", &["no key", "did you mean `tilt_deg`?"]);
    only("camera: {tilt: 25}", (1, 10), "camera.tilt", &["no key", "did you mean `tilt_deg`?"]);
    only("cammera: {tilt_deg: 25}", (1, 1), "cammera", &["did you mean `camera`?"]);
    only("camera: {wavelength_nm: 660}", (1, 10), "camera.wavelength_nm", &["belongs in `laser`"]);
    only("camera: {xyzzy: 1}", (1, 10), "camera.xyzzy", &["keys of `camera` are", "focal_length_mm"]);
    only("laser: {power_mw: {unifrom: [1, 2]}}", (1, 20), "laser.power_mw.unifrom", &["did you mean `uniform`?"]);
    only("extraction: {scatter_mode: fornt}", (1, 28), "extraction.scatter_mode", &["did you mean `front`?"]);
    only("output: {png: [rang]}", (1, 16), "output.png", &["did you mean `range`?"]);
}

#[test]
fn frames_that_memory_cannot_hold_are_refused() {
    only("output: {sensor_stack: all}", (1, 10), "output.sensor_stack", &["17.0 GB", "{every: 4}"]);
}

#[test]
fn wrong_types_say_what_is_right() {
    only("laser: {power_mw: [1, 2]}", (1, 19), "laser.power_mw", &["is a list", "0.01 to 5000 mW", "uniform"]);
    only("laser: {power_mw: '50'}", (1, 19), "laser.power_mw", &["remove the quotes"]);
    only("laser: {power_mw: much}", (1, 19), "laser.power_mw", &["is a text", "0.01 to 5000 mW"]);
    only("laser: {power_mw: }", (1, 17), "laser.power_mw", &["is nothing"]);
    only("laser: 50", (1, 8), "laser", &["is a number", "give a map"]);
    only("scan: {columns: 2560.5}", (1, 17), "scan.columns", &["not whole", "8 to 16384 px"]);
    only("scan: {columns: {uniform: [8, 9]}}", (1, 17), "scan.columns", &["is a map", "whole number"]);
    only("output: {truth_maps: 1}", (1, 22), "output.truth_maps", &["true or false"]);
    only("output: {sensor_stack: some}", (1, 24), "output.sensor_stack", &["none, all or {every: k}"]);
    only("output: {sensor_stack: {evry: 3}}", (1, 25), "output.sensor_stack.evry", &["did you mean `every`?"]);
    only("output: {samples_per_shard: lots}", (1, 29), "output.samples_per_shard", &["auto"]);
    only("output: {exr: range}", (1, 15), "output.exr", &["give a list"]);
    only("output: {exr: [range, range]}", (1, 23), "output.exr", &["twice"]);
    only("knots: {sound_count: 1.5}", (1, 22), "knots.sound_count", &["not whole", "0 to 40"]);
    only("knots: {sound_count: {uniform: [0.5, 3]}}", (1, 33), "knots.sound_count.uniform", &["not whole"]);
}

#[test]
fn numbers_out_of_range_are_faults() {
    only("camera: {tilt_deg: 90}", (1, 20), "camera.tilt_deg", &["90 is out of range", "5 to 75 deg"]);
    only("camera: {tilt_deg: .nan}", (1, 20), "camera.tilt_deg", &["no finite number", "5 to 75 deg"]);
    only("camera: {tilt_deg: .inf}", (1, 20), "camera.tilt_deg", &["no finite number"]);
    only("camera: {tilt_deg: 1e999}", (1, 20), "camera.tilt_deg", &["no finite number"]);
    only("scan: {columns: 1000000000}", (1, 17), "scan.columns", &["1e9 is out of range", "8 to 16384 px"]);
    only("scan: {profiles: 0}", (1, 18), "scan.profiles", &["1 to 16383"]);
    only("camera: {rows: 63}", (1, 16), "camera.rows", &["64 to 4096 px"]);
    only("extraction: {window_rows: 8}", (1, 27), "extraction.window_rows", &["one of 3, 7, 15"]);
    only("output: {samples_per_shard: 0}", (1, 29), "output.samples_per_shard", &["1 to 100000"]);
    only("output: {bin: {columns: 0}}", (1, 25), "output.bin.columns", &["1 to 16384"]);
    only("output: {sensor_stack: {every: 0}}", (1, 32), "output.sensor_stack.every", &["1 to 16383"]);
}

#[test]
fn distributions_are_checked_to_their_ends() {
    let key = "camera.tilt_deg";
    let case = |text: &str, column: usize, inner: &str, words: &[&str]| {
        only(&format!("camera: {{tilt_deg: {text}}}"), (1, column), &format!("{key}{inner}"), words);
    };
    case("{uniform: [30, 20]}", 30, ".uniform", &["smallest 30 is over largest 20", "swap"]);
    case("{uniform: [30, 80]}", 35, ".uniform", &["80 is out of range", "5 to 75 deg"]);
    case("{uniform: [30]}", 30, ".uniform", &["list of 1", "[smallest, largest]"]);
    case("{uniform: 30}", 30, ".uniform", &["is a number", "[smallest, largest]"]);
    case("{uniform: [30, .nan]}", 35, ".uniform", &["no finite number"]);
    case("{normal: {mean: 25, sd: -1}}", 44, ".normal.sd", &["-1 is out of range", "0 to"]);
    case("{normal: {mean: 25}}", 29, ".normal.sd", &["is missing"]);
    case("{normal: {mean: 90, sd: 1}}", 20, "", &["only 0.00 %", "5 to 75 deg"]);
    case("{lognormal: {median: 0, log_sd: 1}}", 41, ".lognormal.median", &["out of range"]);
    case("{lognormal: {median: 25, log_sd: 21}}", 32, ".lognormal.log_sd", &["at most 20"]);
    case("{choice: {values: []}}", 29, ".choice", &["has 0 values"]);
    case("{choice: {weights: [1]}}", 29, ".choice", &["no `values`"]);
    case("{choice: {values: [20, 90]}}", 43, ".choice.values", &["90 is out of range"]);
    case("{choice: {values: [20, 30], weights: [0, 0]}}", 29, ".choice", &["weights that sum to 0"]);
    case("{choice: {values: [20, 30], weights: [1]}}", 29, ".choice", &["2 values and 1 weights"]);
    case("{choice: {values: [20, 30], weights: [1, -1]}}", 61, ".choice.weights", &["-1 is out of range"]);
    case("{truncated: {min: 20}}", 32, ".truncated", &["no `of`"]);
    case("{truncated: {of: {uniform: [10, 20]}, min: 30}}", 20, "", &["only 0.00 %"]);
    case("{truncated: {of: {normal: {mean: 25, sd: 1}}, max: 90}}", 71, ".truncated.max", &["5 to 75 deg"]);
    case("{truncated: {of: {truncated: {of: 25}}}}", 38, ".truncated.of.truncated", &["truncate once"]);
    case("{}", 20, "", &["map of 0 keys"]);
    case("{uniform: [6, 7], normal: {mean: 6, sd: 1}}", 20, "", &["map of 2 keys"]);
    only("board: {offset_mm: {log_uniform: [0, 1]}}", (1, 34), "board.offset_mm.log_uniform", &["above 0"]);
}

#[test]
fn keys_must_fit_together() {
    only("extraction: {scatter_offset_rows: 9}", (1, 14), "extraction.scatter_offset_rows", &["31-row", "at most 16"]);
    let wide = "extraction: {scatter_offset_rows: 1, scatter_width_rows: 15}";
    only(wide, (1, 38), "extraction.scatter_width_rows", &["30 rows", "at most 29"]);
    only("scan: {columns: 16384, profiles: 16383}", (1, 24), "scan.profiles", &["134217728"]);
    only("output: {bin: {columns: 3}}", (1, 16), "output.bin.columns", &["does not divide", "is 2"]);
    only("splits: {train: 0.9}", (1, 10), "splits.train", &["sum to 1.1"]);
    only("camera: {focal_length_mm: 200, distance_mm: 400}", (1, 10), "camera.focal_length_mm", &["half the distance"]);
    let near = "camera: {focal_length_mm: {uniform: [20, 60]}, distance_mm: {normal: {mean: 120, sd: 1}}}";
    only(near, (1, 10), "camera.focal_length_mm", &["60 mm at a distance of 112 mm"]);
    only("exposure: {dark_noise_dn: 0.4}", (1, 12), "exposure.dark_noise_dn", &["0.462 DN"]);
    only("exposure: {row_noise_dn: {uniform: [0.1, 2]}}", (1, 12), "exposure.row_noise_dn", &["row noise 2"]);
    only(
        "laser: {fan_height_mm: 20}",
        (1, 9),
        "laser.fan_height_mm",
        &["20 mm high", "22 mm thick", "above the board"],
    );
    only("rot: {edge: 0}", (1, 7), "rot.edge", &["choice"]);
    only("rot: {edge: {uniform: [-1, 1]}}", (1, 7), "rot.edge", &["choice"]);
}

#[test]
fn classes_are_checked_like_the_top_level() {
    let case = |classes: &str, place: (usize, usize), key: &str, words: &[&str]| {
        whole(&format!("name: a\nsubject: wood\n{classes}\n"), place, key, words);
    };
    case("classes: {}", (3, 10), "classes", &["0 classes"]);
    case("other: 1\nclasses: {a: {share: 1}}", (3, 1), "other", &["no key of a recipe"]);
    case("classes: {a: {}}", (3, 14), "classes.a.share", &["is missing"]);
    case("classes: {a: {share: 0}}", (3, 15), "classes.a.share", &["is 0 of all shares", "remove the class"]);
    let rare = "classes: {a: {share: 1e-3}, b: {share: 1e6}}";
    case(rare, (3, 15), "classes.a.share", &["is 9.99", "at least 0.000001"]);
    case("classes: {a: {share: -1}}", (3, 22), "classes.a.share", &["out of range"]);
    case("classes: {A b: {share: 1}}", (3, 11), "classes.A b", &["a-z"]);
    case("classes: {a: {share: 1, camera: {rows: 64}}}", (3, 34), "classes.a.camera.rows", &["same for all classes"]);
    case("classes: {a: {share: 1, scan: {columns: 64}}}", (3, 25), "classes.a.scan", &["same for all classes"]);
    case("classes: {a: {share: 1, knot: {}}}", (3, 25), "classes.a.knot", &["did you mean `knots`?"]);
    case("classes: {a: {share: 1, camera: {tilt_deg: 90}}}", (3, 44), "classes.a.camera.tilt_deg", &["5 to 75 deg"]);
    let short = "classes: {a: {share: 1, camera: {distance_mm: 50}}}";
    case(short, (3, 34), "classes.a.camera.distance_mm", &["half the distance"]);
}

#[test]
fn broken_yaml_is_one_fault_at_its_place() {
    whole("", (1, 1), "", &["the file is empty"]);
    whole("# only a comment\n", (2, 1), "", &["the file is empty"]);
    whole("wood", (1, 1), "", &["the file is a text"]);
    whole("- a\n- b\n", (1, 1), "", &["the file is a list"]);
    whole("name: a\nsubject: wood\nname: b\n", (3, 1), "", &["key `name` stands here twice", "remove one"]);
    whole("name: a\n---\nname: b\n", (2, 1), "", &["a second document"]);
    whole("name: [a\n", (1, 7), "", &["unclosed"]);
    whole("a: *b\n", (1, 4), "", &["unknown anchor"]);
    whole("a: !secret b\n", (1, 12), "", &["unsupported tag"]);
    let bomb = (b'b'..=b'h').fold("a: &a [x, x, x, x, x, x, x, x, x]\n".to_owned(), |text, letter| {
        let (new, old) = (letter as char, (letter - 1) as char);
        text + &format!("{new}: &{new} [{}]\n", vec![format!("*{old}"); 9].join(", "))
    });
    assert!(faults(&bomb).to_string().contains("than any recipe needs"), "{}", faults(&bomb));
    for deep in ["[", "{a: ", "- ", "a:\n "] {
        assert_eq!(faults(&deep.repeat(10_000)).list.len(), 1, "{deep}");
    }
    assert!(faults(&"# long\n".repeat(200_000)).to_string().contains("longer than 1048576"));
}

/// What the reader of YAML stumbles over has a remedy of its own, and the section that it stands in.
#[test]
fn faults_of_yaml_say_where_and_what_to_do() {
    let start = "name: a\nsubject: wood\ncamera:\n  tilt_deg: 25\n";
    for (lines, line, words) in [
        ("\tf_number: 2\n", 5, ["in `camera`", "indent with blanks"]),
        ("   f_number: 2\n", 5, ["in `camera`", "the same column"]),
        (" f_number: 2\n", 5, ["in `camera`", "the same column"]),
        ("  f_number: {uniform: [1, 2]\nlaser:\n", 5, ["in `camera`", "close each `{`"]),
        ("  lens: 'pinhole\n", 5, ["in `camera`", "the quote that it begins with"]),
        ("laser: {power_mw: [50}\n", 5, ["laser", "close each `{`"]),
    ] {
        let faults = faults(&format!("{start}{lines}"));
        assert_eq!(faults.list.len(), 1, "{faults}");
        assert!(faults.list[0].place.line >= line, "{faults}");
        let told = faults.to_string();
        words.iter().for_each(|word| assert!(told.contains(word), "no `{word}` in {told}"));
    }
}

#[test]
fn all_faults_come_at_once_in_the_order_of_the_file() {
    let text = "name: Bad Name\nsubject: wod\ncamera: {tilt_dg: 25, f_number: 0}\nscan:\n  columns: -3\nsplits: \
        {test: 0.5}\n\
                classes:\n  a: {share: 1, rot: {reach_mm: {uniform: [3, 1]}}}\n";
    let faults = faults(text);
    let keys: Vec<_> = faults.list.iter().map(|fault| (fault.place.line, fault.key.as_str())).collect();
    assert_eq!(
        keys,
        [
            (1, "name"),
            (2, "subject"),
            (3, "camera.tilt_dg"),
            (3, "camera.f_number"),
            (5, "scan.columns"),
            (6, "splits.test"),
            (8, "classes.a.rot.reach_mm.uniform"),
        ]
    );
    let shown = faults.to_string();
    assert!(shown.starts_with("bad.yaml has 7 faults:\nbad.yaml:1:7: name: "), "{shown}");
    assert!(shown.contains("     5 |   columns: -3\n       |            ^\n"), "{shown}");
}

#[test]
fn many_faults_are_listed_up_to_a_hundred_and_counted() {
    let keys: String = (0..250).map(|i| format!("key{i}: 1\n")).collect();
    let faults = faults(&format!("{GOOD}{keys}"));
    assert_eq!((faults.list.len(), faults.unlisted), (100, 150));
    assert!(faults.to_string().ends_with("and 150 more\n"));
}

#[test]
fn names_that_are_nothing_list_what_there_is() {
    let error = Recipe::load("recipes/wod.yaml").expect_err("no such recipe").to_string();
    for word in ["`recipes/wod.yaml`", "did you mean `wood`?", "wood, wood-small, blister"] {
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn bytes_that_are_no_text_are_a_fault_at_their_place() {
    let file = tempfile::NamedTempFile::new().expect("a temporary file");
    std::fs::write(file.path(), b"name: a\nsub\xff").expect("it can be written");
    let error = Recipe::load(&file.path().to_string_lossy()).expect_err("no text");
    let RecipeError::Faulty(faults) = error else { panic!("{error}") };
    assert_eq!((faults.list[0].place.line, faults.list[0].place.column), (2, 4));
    assert!(faults.to_string().contains("UTF-8"));
    if cfg!(unix) {
        let endless = Recipe::load("/dev/zero").expect_err("no recipe").to_string();
        assert!(endless.contains("it is a device"), "{endless}");
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    assert!(matches!(Recipe::load(&folder.path().to_string_lossy()), Err(RecipeError::NotFound { .. })));
}

#[test]
#[ignore = "long"]
fn no_mutation_of_a_recipe_panics() {
    const TOKENS: [&str; 24] = [
        "{",
        "}",
        "[",
        "]",
        ":",
        ",",
        "-",
        "\n",
        "  ",
        "&a ",
        "*a",
        "<<: ",
        ".nan",
        "-1",
        "1e308",
        "0",
        "null",
        "uniform",
        "truncated",
        "'",
        "\"",
        "!!str ",
        "\u{feff}",
        "é",
    ];
    let mut rng = Stream::root(1).rng();
    let mut accepted = 0;
    let whole = ["wood", "blister", "wood-small", "blister-small"].map(|name| Recipe::load(name).expect("embedded"));
    for round in 0..4000 {
        let mut text = whole[round % 4].text().to_owned();
        for _ in 0..rng.random_range(1..6) {
            let at = |u: f64, text: &str| text.floor_char_boundary((u * text.len() as f64) as usize);
            let (a, b) = (at(rng.random(), &text), at(rng.random(), &text));
            match rng.random_range(0..4) {
                0 => text.insert_str(a, TOKENS[rng.random_range(0..TOKENS.len())]),
                1 => text.replace_range(a..text.floor_char_boundary(a + 9), ""),
                2 => text.replace_range(a..text.floor_char_boundary(a + 3), TOKENS[rng.random_range(0..TOKENS.len())]),
                _ => {
                    let piece = text[b..text.floor_char_boundary(b + 30)].to_owned();
                    text.insert_str(a, &piece);
                }
            }
        }
        match Recipe::parse("mutated.yaml", &text) {
            Ok(recipe) => {
                accepted += 1;
                recipe.draw(0, round as u64);
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
    // Comments and harmless digits leave some recipes right; if all or none were, the test would see nothing.
    assert!((100..3900).contains(&accepted), "{accepted} of 4000 accepted");
}

/// Edges of a board that wander stay apart.
#[test]
fn edges_stay_apart() {
    let words = &["an edge can lie 9 mm beside its line", "10 mm wide", "at most 0.41 mm"];
    only("board: {width_mm: 10, edge_wander_mm: 3}", (1, 23), "board.edge_wander_mm", words);
    assert!(Recipe::parse("a.yaml", &format!("{GOOD}board: {{width_mm: 10, edge_wander_mm: 0.41}}\n")).is_ok());
}
