//! `gen preview`, `validate`, `schema` and help: what they print, where, and with which status.

use std::fs;
use std::io::Read;

use serde_json::{Value, json};
use test_support::program::{self, Place, SPECKLE};

#[test]
#[ignore = "long"]
fn a_preview_shows_something() {
    Place::of_each_subject(&[SPECKLE]).iter().for_each(previews);
}

fn previews(place: &Place) {
    let run = place.done("preview --recipe tiny.yaml --index 3 --out plank.png");
    assert_eq!(run.out, "");
    let picture = image::open(place.path("plank.png")).expect("it is a picture").into_rgb8();
    let (width, height) = picture.dimensions();
    assert!((600..3000).contains(&width) && (400..2000).contains(&height), "{width} x {height}");
    assert!(run.err.contains(&format!("plank.png: {width} x {height}")), "{}", run.err);
    // Sensor frame on top, four panels below; each shows more than one colour over a good part of it.
    let colours = |left: u32, right: u32, top: u32, bottom: u32| {
        let pixels = (left..right).flat_map(|x| (top..bottom).map(move |y| (x, y)));
        let mut colours: Vec<_> = pixels.map(|(x, y)| picture.get_pixel(x, y).0).collect();
        colours.sort_unstable();
        colours.dedup();
        colours.len()
    };
    assert!(colours(20, width - 20, 30, height * 2 / 5) > 40, "the sensor frame is uniform");
    for panel in 0..4 {
        let (left, right) = (panel * width / 4 + width / 20, (panel + 1) * width / 4 - width / 20);
        let least = if panel < 3 { 10 } else { 2 };
        let found = colours(left, right, height * 6 / 10, height * 9 / 10);
        assert!(found >= least, "panel {panel} has {found} colours");
    }
    place.done("preview --recipe tiny.yaml --index 3 --out again.png");
    assert_eq!(fs::read(place.path("plank.png")).expect("it"), fs::read(place.path("again.png")).expect("it"));
    place.done("preview --recipe tiny.yaml --index 3 --seed 1 --out other.png");
    assert_ne!(fs::read(place.path("plank.png")).expect("it"), fs::read(place.path("other.png")).expect("it"));
    place.done("preview --recipe tiny.yaml --index 18446744073709551615");
    assert!(place.path("preview.png").exists());
}

/// The folder of a dataset in place of a recipe shows the samples of that dataset: those of its seed.
#[test]
fn a_preview_of_a_dataset_shows_its_samples() {
    let place = Place::with(&[]);
    place.make("set", "--n 1 --seed 5");
    place.done("preview --recipe set --index 3 --out of-the-set.png");
    place.done("preview --recipe tiny.yaml --index 3 --seed 5 --out of-its-seed.png");
    place.done("preview --recipe set --index 3 --seed 0 --out of-seed-0.png");
    let read = |name: &str| fs::read(place.path(name)).expect("a picture");
    assert_eq!(read("of-the-set.png"), read("of-its-seed.png"));
    assert_ne!(read("of-the-set.png"), read("of-seed-0.png"));
}

/// A dataset keeps its samples per shard: the command that goes on with it needs not name them again.
#[test]
fn a_dataset_goes_on_with_its_own_shards() {
    let place = Place::with(&[]);
    place.make("set", "--n 2 --samples-per-shard 2");
    place.make("set", "--n 5");
    let head = place.json("set/dataset.json");
    assert_eq!((&head["samples_per_shard"], &head["samples"], &head["shards"]), (&2.into(), &5.into(), &3.into()));
    let refused = place.run("--recipe tiny.yaml --n 5 --out set --samples-per-shard 3");
    assert!(refused.code == 1 && refused.err.contains("2 -> 3"), "{}", refused.err);
}

/// A dataset keeps what its recipe inherits: it is continued and checked although the other recipes have gone.
#[test]
fn a_dataset_needs_none_of_the_recipes_that_its_own_extends() {
    let place = Place::with(&[]);
    let child = "extends: tiny.yaml\nname: child\nlaser: {power_mw: 60}\n";
    place.write("child.yaml", child);
    assert_eq!(place.done("recipe show child.yaml").out, child);
    let flat = place.done("recipe show child.yaml --flat").out;
    place.done("--recipe child.yaml --n 3 --samples-per-shard 1 --out whole");
    place.done("--recipe child.yaml --n 1 --samples-per-shard 1 --out set");
    ["tiny.yaml", "child.yaml"].iter().for_each(|name| fs::remove_file(place.path(name)).expect("it was there"));
    assert_eq!(place.done("recipe show set").out, flat);
    place.done("--recipe set --n 3 --out set");
    place.done("validate set");
    assert!(
        place.tree("set/data") == place.tree("whole/data")
            && place.json("set/dataset.json") == place.json("whole/dataset.json")
    );
    place.write("child.yaml", child);
    place.run("preview --recipe child.yaml").refused(&["child.yaml:1:10: extends", "no file `tiny.yaml` beside it"]);
}

#[test]
#[ignore = "long"]
fn validation_passes_what_is_whole_and_names_what_is_not() {
    Place::of_each_subject(&[]).iter().for_each(validates);
}

fn validates(place: &Place) {
    place.make("set", "--n 6 --samples-per-shard 3");
    let clean = place.done("validate set --rerender 2");
    for word in ["2 shards", "6 samples", "images", "2 rendered again", "0 faults"] {
        assert!(clean.out.contains(word), "no `{word}` in {}", clean.out);
    }
    assert_eq!(clean.err, "");
    let json: Value = serde_json::from_str(&place.done("validate set --json").out).expect("it is JSON");
    assert_eq!((&json["clean"], &json["samples"], &json["rerendered"]), (&true.into(), &6.into(), &1.into()));

    let tables: Vec<String> = place.tree("set").into_keys().filter(|name| name.ends_with(".parquet")).collect();
    let victim = tables.last().expect("a table");
    let mut bytes = fs::read(place.path("set").join(victim)).expect("it can be read");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(place.path("set").join(victim), bytes).expect("it can be written");
    let run = place.run("validate set");
    assert_eq!(run.code, 1);
    for word in ["file-checksum", victim, "run the command again", "1 faults"] {
        assert!(run.out.contains(word), "no `{word}` in {}", run.out);
    }
    assert!(run.err.contains("set has 1 fault"), "{}", run.err);
    let json: Value = serde_json::from_str(&place.run("validate set --json").out).expect("it is JSON");
    assert_eq!(json["fault_counts"], serde_json::json!({ "file-checksum": 1 }));
    // What the report says to do heals it.
    let shard = victim.rsplit('-').next().and_then(|name| name.split('.').next()).expect("a number");
    fs::remove_file(place.path(&format!("set/shards/{shard}.json"))).expect("the manifest is there");
    place.make("set", "--n 6 --samples-per-shard 3");
    place.done("validate set --rerender 6");

    let nowhere = place.run("validate nowhere");
    assert_eq!(nowhere.code, 1);
    assert!(nowhere.err.contains("nowhere") && nowhere.out.contains("dataset.json"), "{}", nowhere.out);
}

#[test]
fn schemas_are_those_of_the_repository() {
    let place = Place::new();
    let recipe = place.done("schema recipe");
    assert_eq!(recipe.out, include_str!("../../recipes/recipe.schema.json"));
    let dataset: Value = serde_json::from_str(&place.done("schema dataset").out).expect("it is JSON");
    assert!(dataset["$schema"].is_string(), "{dataset:#}");
    let reference = place.done("schema recipe-reference").out;
    for page in [include_str!("../../recipes/README.md"), include_str!("../../recipes/keys/bench.md")] {
        assert!(reference.contains(page.trim()), "{reference}");
    }
    assert_eq!(place.run("schema").code, 2);
}

#[test]
fn help_helps() {
    let place = Place::new();
    let help = place.done("--help");
    for word in ["Examples:", "gen --recipe wood.yaml --n 10000 --out planks", "preview", "--estimate", "--part"] {
        assert!(help.out.contains(word), "no `{word}` in {}", help.out);
    }
    let alone = place.run("");
    assert_eq!((alone.code, alone.err.as_str()), (2, ""));
    assert!(alone.out.contains("Examples:") && alone.out.contains("Usage:"), "{}", alone.out);
    for command in ["preview", "validate", "schema"] {
        assert!(place.done(&format!("{command} --help")).out.contains("Usage: gen"), "{command}");
    }
    assert!(place.done("--version").out.starts_with("gen "));
}

#[test]
fn built_in_recipes_work_anywhere_and_files_win() {
    let place = Place::new();
    for (i, name) in ["wood-small", "wood-small.yaml", "recipes/wood-small.yaml"].into_iter().enumerate() {
        let run = place.done(&format!("--recipe {name} --n 1 --out set{i}"));
        assert!(run.err.contains("1 sample in 1 shard made; dataset of 1 sample"), "{}", run.err);
    }
    place.done("--recipe wood-small --n 1");
    assert_eq!(place.json("out/wood-small/dataset.json")["images"]["cols"], 256);
    place.write("wood-small.yaml", program::recipe(&[]));
    place.done("--recipe wood-small.yaml --n 1 --out mine");
    assert_eq!(place.json("mine/dataset.json")["images"]["cols"], 64);
}

/// A built-in recipe in place of a file that is not there is told; by its own name it is what was asked for.
#[test]
fn a_built_in_recipe_is_taken_aloud() {
    let place = Place::new();
    let words = ["there is no file wood-small.yaml", "built-in recipe `wood-small`", "gen recipe show wood-small"];
    let run = place.done("--recipe wood-small.yaml --n 1 --out set");
    words.iter().for_each(|word| assert!(run.err.contains(word), "no `{word}` in {}", run.err));
    let run = place.done("--recipe wood-small --n 1 --out set");
    assert!(!run.err.contains("built-in"), "{}", run.err);
    place.write("wood-small.yaml", place.done("recipe show wood-small").out);
    let run = place.done("--recipe wood-small.yaml --n 1 --out set");
    assert!(!run.err.contains("built-in"), "{}", run.err);
}

#[test]
fn built_in_recipes_are_listed_and_printed() {
    let place = Place::new();
    let listed = place.done("recipe list").out;
    let documents: Value = serde_json::from_str(&place.done("recipe list --json").out).expect("it is JSON");
    let names: Vec<&str> =
        documents.as_array().expect("a list").iter().filter_map(|recipe| recipe["name"].as_str()).collect();
    assert!(names.contains(&"wood") && names.contains(&"thesis/blister"), "{names:?}");
    assert_eq!(listed.lines().count(), names.len(), "{listed}");
    for (line, name) in listed.lines().zip(&names) {
        assert!(line.starts_with(&format!("{name} ")), "{line}");
    }
    assert_eq!(place.done("recipe show wood").out, include_str!("../../recipes/wood.yaml"));
    let full: Value = serde_json::from_str(&place.done("recipe show wood --json").out).expect("it is JSON");
    assert_eq!((&full["name"], &full["camera"]["lens"]), (&"wood".into(), &"thin_lens".into()));
    // Of a dataset too.
    place.write("tiny.yaml", program::recipe(&[]));
    place.make("set", "--n 1");
    assert_eq!(place.done("recipe show set").out, program::recipe(&[]));
    let run = place.run("recipe show wod");
    assert!(run.code == 1 && run.err.contains("did you mean `wood`"), "{}", run.err);
}

/// A first recipe renders as it is, and presets are listed with their sources.
#[test]
fn a_first_recipe_renders_and_presets_are_listed() {
    let place = Place::new();
    for subject in ["wood", "blister", "sawtooth", "mesh"] {
        let text = place.done(&format!("recipe new --subject {subject}")).out;
        assert!(text.lines().count() <= 20, "{text}");
        place.write("mine.yaml", text);
        place.done(&format!("preview --recipe mine.yaml --out {subject}.png"));
    }
    let refused = place.run("recipe new --subject steel");
    assert!(refused.code == 2 && refused.err.contains("wood, blister, sawtooth, mesh"), "{}", refused.err);
    let listed = place.done("recipe presets").out;
    for words in ["camera: {preset: alvium-c-508}", "exposure.full_well_e: 10400", "alliedvision.com", "lacks: QE"] {
        assert!(listed.contains(words), "no `{words}` in {listed}");
    }
    let documents: Value = serde_json::from_str(&place.done("recipe presets --json").out).expect("it is JSON");
    let documents = documents.as_array().expect("a list");
    assert_eq!(documents.len(), listed.matches("{preset: ").count());
    assert!(documents.iter().all(|preset| preset["numbers"][0]["source"].is_string()));
}

#[test]
fn datasets_are_listed_with_their_facts() {
    let place = Place::with(&[]);
    place.make("out/a", "--n 4 --seed 3 --samples-per-shard 2");
    place.make("out/below/b", "--n 6 --samples-per-shard 2 --part 0/3");
    let listed = place.done("list").out;
    for words in [
        "out/a: wood-small about wood, seed 3, 4 samples",
        "out/below/b: wood-small about wood, seed 0, 2 samples, 4 samples to make",
    ] {
        assert!(listed.contains(words), "no `{words}` in {listed}");
    }
    let documents: Value = serde_json::from_str(&place.done("list out --json").out).expect("it is JSON");
    let [a, b] = [&documents[0], &documents[1]];
    assert_eq!((&a["path"], &a["seed"], &a["finished_samples"]), (&"out/a".into(), &3.into(), &4.into()));
    assert_eq!((&b["samples"], &b["finished_shards"], &b["shards"]), (&6.into(), &1.into(), &3.into()));
    let counted: i64 = a["splits"].as_object().expect("a map").values().filter_map(Value::as_i64).sum();
    assert_eq!(counted, 4);
    fs::create_dir(place.path("empty")).expect("a folder");
    assert!(place.done("list empty").err.contains("no dataset"));
    assert_eq!(place.run("list nowhere").code, 2);
    place.write("out/a/dataset.json", "{");
    let damaged = place.run("list");
    assert!(
        damaged.code == 1 && damaged.out.contains("out/below/b") && damaged.out.contains("out/a: "),
        "{}",
        damaged.out
    );
}

/// Where two datasets with the same random numbers meet, it is said.
#[test]
fn shared_draws_are_told() {
    let place = Place::with(&[]);
    place.write("kin.yaml", program::recipe(&[["name: wood-small", "name: kin\nfamily: wood-small"]]));
    place.write("other.yaml", program::recipe(&[["name: wood-small", "name: other"]]));
    place.make("out/a", "--n 2");
    for name in ["kin", "other"] {
        place.done(&format!("--recipe {name}.yaml --n 2 --out out/{name}"));
    }
    place.make("out/seed", "--n 2 --seed 1");
    let words = "both draw the random numbers of family `wood-small` for seed 0";
    assert!(place.done("compare out/a out/kin").err.contains(words));
    let told = place.done("list").err;
    assert!(told.contains("out/a and out/kin") && told.matches(words).count() == 1, "{told}");
    for other in ["out/other", "out/seed"] {
        assert!(!place.done(&format!("compare out/a {other}")).err.contains("random numbers"), "{other}");
    }
}

/// A model that is not there is missed before its sidecar, and an export of icon files is read as the scans that it
/// holds.
#[test]
fn what_is_missing_is_named_and_exports_are_read() {
    let place = Place::with(&[]);
    place.done("--recipe tiny.yaml --n 2 --out set");
    let missing = place.run("check set --model knots.onnx --split all");
    assert!(missing.code == 1 && missing.err.contains("knots.onnx: it is not there"), "{}", missing.err);
    place.done("export icon set --out scans --index 1");
    place.done("compare set scans");
}

/// A program gets what a run made, and what it would take, as JSON alone on standard output.
#[test]
fn programs_get_json() {
    let place = Place::with(&[]);
    let json = |arguments: &str| -> Value { serde_json::from_str(&place.done(arguments).out).expect("it is JSON") };
    let estimate = json("--recipe tiny.yaml --n 5 --out set --estimate --json");
    assert_eq!((&estimate["to_make"], &estimate["fits"]), (&5.into(), &true.into()));
    assert!(estimate["seconds"].as_f64() > Some(0.0) && estimate["classes"]["rot"].is_u64(), "{estimate}");
    for (class, all) in estimate["classes"].as_object().expect("classes") {
        let split = |name: &str| estimate["splits"][name][class].as_u64().expect("a count");
        assert_eq!(all.as_u64(), Some(["train", "validation", "test"].map(split).iter().sum()), "{estimate}");
    }
    let made = json("--recipe tiny.yaml --n 5 --out set --json");
    assert_eq!((&made["made_samples"], &made["samples"], &made["out"]), (&5.into(), &5.into(), &"set".into()));
    assert!(made["hidden_defects"].is_object(), "{made}");
    assert_eq!(json("--recipe tiny.yaml --n 5 --out set --json")["made_samples"], 0);
}

/// The rig of the default bench by hand, and the warnings that its keys deserve.
#[test]
fn a_rig_is_told_in_words_of_data_sheets() {
    let place = Place::new();
    let rig = |changes: &str| -> Value {
        serde_json::from_str(&place.done(&format!("rig wood-small --json {changes}")).out).expect("it is JSON")
    };
    let bench =
        "--set camera.distance_mm=410 --set camera.tilt_deg=25 --set laser.waist_mm=0.1 --set exposure.time_us=40";
    let plain = rig(bench);
    let number = |document: &Value, name: &str| document["numbers"][name].as_f64().unwrap_or(f64::NAN);
    // d cos a and d sin a.
    assert!((number(&plain, "working_distance_mm") - 371.586).abs() < 1e-3, "{plain}");
    assert!((number(&plain, "baseline_mm") - 173.273).abs() < 1e-3, "{plain}");
    // 256 columns of p (d - f) / f on the conveyor: 23.65 mm.
    assert!((number(&plain, "field_on_conveyor_mm") - 256.0 * 6e-3 * 385.0 / 25.0).abs() < 0.01, "{plain}");
    // A row is p (d - f) / f / sin a high where the axis meets the conveyor, a little less on the board.
    let row = 6.0 * 385.0 / 25.0 / 25f64.to_radians().sin();
    assert!((number(&plain, "height_per_row_um") / row - 1.0).abs() < 0.12, "{row}: {plain}");
    let parts =
        ["photons", "dark", "speckle", "rounding"].map(|part| number(&plain, &format!("range_noise_{part}_um")));
    let total = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
    assert!((number(&plain, "range_noise_um") - total).abs() < 1e-9 && parts.iter().all(|part| *part > 0.0), "{plain}");
    assert!(number(&plain, "speed_mm_per_s").is_nan() && number(&plain, "travel_px") == 0.0, "{plain}");
    // Its noise is that of the frames: of a flat board's rows, without speckle and grain.
    for (change, words) in [
        ("exposure.time_us=4000", "saturates: shorten exposure.time_us"),
        ("exposure.time_us=1", "lengthen exposure.time_us"),
        ("laser.waist_mm=1", "raise extraction.window_rows"),
        ("camera.rows=64", "are not seen in all columns"),
        ("motion.step_mm=0.3 --set motion.line_rate_hz=20000", "rows in an exposure: shorten exposure.time_us"),
        ("motion.step_mm=0.5", "times as long as wide; set motion.step_mm"),
        ("output.bin.columns=8", "pixels of the binned images are 10.3 times as wide as long"),
        ("motion.step_mm=0.001", "pixels are 87.6 times as wide as long"),
        ("board.offset_mm=300", "0.0 % of the object lies in the field of the images"),
    ] {
        let told = rig(&format!("{bench} --set {change}"));
        let warnings = told["warnings"].as_array().expect("a list");
        let said = |warning: &Value| warning.as_str().is_some_and(|text| text.contains(words));
        assert!(warnings.iter().any(said), "{change}: no `{words}` in {warnings:?}");
        assert!(!plain["warnings"].as_array().expect("a list").iter().any(said), "{change} is told without reason");
    }
    let table = place.done("rig wood").out;
    assert!(table.contains("field_of_view_mm") && table.contains("range_noise_um"), "{table}");
}

/// Guards against a command that warns in another way than `gen`: beside its result on standard output, and with no
/// means to have the status say it.
#[test]
fn a_rig_warns_as_a_run_does() {
    let place = Place::new();
    let plain = place.done("rig wood-small");
    let odd = "rig wood-small --set motion.step_mm=0.001";
    let told = place.done(odd);
    assert!(!plain.err.contains("warning: ") && told.err.contains("\nwarning: profiles are 0.001 mm"), "{}", told.err);
    // Standard output holds the same lines, and nothing else.
    let names = |out: &str| out.lines().filter_map(|line| line.split(' ').next()).map(String::from).collect::<Vec<_>>();
    assert_eq!(names(&told.out), names(&plain.out));
    assert!(place.done(&format!("{odd} -q")).err.is_empty());

    let json: Value = serde_json::from_str(&place.done(&format!("{odd} --json")).out).expect("it is JSON");
    assert!(json["warnings"][0].as_str().is_some_and(|text| told.err.contains(text)), "{json}");
    for form in ["", "--json"] {
        let strict = place.run(&format!("{odd} --strict {form}"));
        assert!(strict.code == 1 && strict.err.contains("gen: --strict: profiles are 0.001 mm"), "{}", strict.err);
        assert!(strict.out.contains("field_of_view_mm"), "{}", strict.out);
    }
    place.done("rig wood-small --strict");
}

/// Sizes of pixels and boards are numbers with commas between, as the help says.
#[test]
fn sides_of_pictures_are_given_with_commas() {
    let place = Place::new();
    for (sides, words) in [
        ("--pixel-mm 0.1,0.1,0.1", "two with a comma"),
        ("--pixel-mm 0.1,wide", "above 0"),
        ("--pixel-mm 0.1 --board-mm 60", "length (down the rows) and width"),
        ("--pixel-mm 0.1 --board-mm 60,-1", "above 0"),
    ] {
        let run = place.run(&format!("fibres board.png --encoding srgb {sides}"));
        assert!(run.code == 2 && run.err.contains(words), "{sides}: {}", run.err);
    }
    // What is missing is then the picture alone.
    for sides in ["--pixel-mm 0.1 --board-mm 60,39.9", "--pixel-mm 0.068,0.092"] {
        let run = place.run(&format!("fibres board.png --encoding srgb {sides}"));
        assert!(run.code == 1 && run.err.contains("board.png"), "{sides}: {} {}", run.code, run.err);
    }
}

/// Every example of the help that needs no file of the user's works where it stands.
#[test]
fn examples_of_the_help_work() {
    let place = Place::new();
    let help = place.done("--help").out;
    for example in ["transport --medium clear-wood --model path", "recipe show wood", "schema recipe"] {
        assert!(help.contains(&format!("gen {example}")), "no `{example}` in {help}");
        place.done(&format!("{example}{}", if example.starts_with("transport") { " --photons 128" } else { "" }));
    }
}

#[test]
fn pipes_get_plain_text_and_progress_stays_off_standard_output() {
    let place = Place::with(&[]);
    let runs = [
        place.make("set", "--n 3"),
        place.make("set", "--n 4"),
        place.done("validate set"),
        place.done("preview --recipe tiny.yaml"),
        place.done("--recipe tiny.yaml --n 2 --estimate"),
        place.run("--recipe nothing.yaml --n 2"),
        place.run("--help"),
        place.run("--recipe tiny.yaml --n x"),
    ];
    for (i, run) in runs.iter().enumerate() {
        let text = format!("{}{}", run.out, run.err);
        let control = text.chars().find(|c| c.is_control() && *c != '\n');
        assert!(control.is_none(), "run {i}: {control:?} in {text:?}");
        assert!(!text.is_empty(), "run {i}");
    }
    assert_eq!((runs[0].out.as_str(), runs[1].out.as_str()), ("", ""));
}

#[test]
fn readers_that_go_away_stop_nothing() {
    let place = Place::with(&[]);
    let mut child = place.command("--recipe tiny.yaml --n 3 --out set").spawn().expect("the program starts");
    drop(child.stderr.take());
    drop(child.stdout.take());
    assert!(child.wait().expect("it ends").success());
    place.done("validate set");
    for command in ["schema recipe", "--help", "", "validate set", "--recipe tiny.yaml --n 1 --estimate"] {
        let mut child = place.command(command).spawn().expect("the program starts");
        drop(child.stdout.take());
        let mut text = String::new();
        child.stderr.take().expect("a pipe").read_to_string(&mut text).expect("it is text");
        let status = child.wait().expect("it ends").code();
        assert!(matches!(status, Some(0 | 2)) && !text.contains("panicked"), "gen {command}: {status:?} {text}");
    }
}

/// The smallest recipe with few photons.
const FEW: &str = "\ntransport: {model: path, photons_per_profile: 1000}\nclasses:\n";

#[test]
#[ignore = "long"]
fn the_program_says_what_a_slow_model_is_for_and_files_name_it() {
    let place = Place::with(&[["\nclasses:\n", FEW], ["\n  profiles: 48 ", "\n  profiles: 8 "]]);
    let words = ["transport: path walks 1000 photons in each of 8 profiles", "slow", "`transport: kernel`"];
    let estimate = place.done("--recipe tiny.yaml --n 3 --estimate");
    assert!(estimate.err.contains("rendering 1 sample to measure"), "{}", estimate.err);
    let made = place.make("set", "--n 1");
    let rendered = [place.done("preview --recipe tiny.yaml"), place.done("validate set --rerender 1")];
    for run in [estimate, made].iter().chain(&rendered) {
        words.iter().for_each(|word| assert!(run.err.contains(word), "no `{word}` in {}", run.err));
    }
    let canonical = &place.json("set/dataset.json")["recipe"]["canonical"]["transport"];
    assert_eq!(*canonical, json!({"model": "path", "photons_per_profile": 1000}));
    let card = fs::read_to_string(place.path("set/README.md")).expect("a card");
    assert!(card.contains("\n| transport | path, photons_per_profile 1000 |\n"), "{card}");

    let place = Place::with(&[]);
    let run = place.make("set", "--n 1");
    assert!(!run.err.contains("transport"), "{}", run.err);
    let card = fs::read_to_string(place.path("set/README.md")).expect("a card");
    assert!(card.contains("\n| transport | kernel |\n"), "{card}");
}
