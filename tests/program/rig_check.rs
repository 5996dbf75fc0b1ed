//! The check of the rig before the first sample: recipes whose samples would be of no use are told with what to do,
//! wherever a dataset is made, looked at or checked; the shipped ones are not.

use std::fs;

use parquet::record::Field;
use recipe::Recipe;
use recipe::asset_source::AssetSource;
use scanner::optics::speckle::PatternCache;
use serde_json::Value;
use sheetlight::generate::rig_warnings;
use test_support::pages::{between, page};
use test_support::program::{Place, assert_same, mesh_recipe, pack_recipe, recipe, sawtooth_recipe};

/// Recipes of no use: what is changed of a shipped one, what is warned of, and a word of the remedy.
const USELESS: [(&str, &str, &str, &str); 12] = [
    ("wood-small", "laser.power_mw=0.1", "hardly-measured", "raise laser.power_mw"),
    ("wood-small", "camera.rows=64", "hardly-measured", "raise camera.rows"),
    (
        "wood-small",
        "laser.fan_angle_deg=1 --set laser.power_mw=1",
        "partly-measured",
        "widen the fan by laser.fan_angle_deg",
    ),
    // Bright enough in the middle of the line, and too dark at its ends.
    (
        "wood-small",
        "laser.fan=cylindrical --set laser.fan_angle_deg=3 --set laser.power_mw=0.25",
        "partly-measured",
        "raise laser.power_mw",
    ),
    ("wood-small", "board.thickness_mm=150", "hardly-measured", "raise camera.rows"),
    ("wood-small", "board.offset_mm=300", "object-out-of-view", "board.offset_mm"),
    ("wood-small", "board.lead_in_mm=100", "object-out-of-view", "board.lead_in_mm"),
    (
        "wood-small",
        "board.width_mm=200 --set board.length_mm=300",
        "object-out-of-view",
        "scan.columns or camera.distance_mm, and the fan with it by laser.fan_angle_deg or laser.fan_height_mm; and \
            let it begin",
    ),
    ("wood-small", "laser.power_mw=3000", "saturated", "lower laser.power_mw"),
    ("blister-small", "laser.power_mw=0.1", "hardly-measured", "raise laser.power_mw"),
    ("blister-small", "laser.power_mw=3000", "saturated", "lower laser.power_mw"),
    (
        "blister-small",
        "pack.columns=2 --set pack.rows=7 --set pack.width_mm=23 --set pack.length_mm=78",
        "object-out-of-view",
        "scan.profiles",
    ),
];

/// A place with a shipped recipe as `tiny.yaml`, of one class alone: the check looks at fewer samples.
fn of_one_class(name: &str) -> Place {
    let text = Recipe::built_in(name).expect("it is built in").text;
    let (before, rest) = text.split_once("\nclasses:\n").expect("classes");
    let (_, after) = rest.split_once("\n# How the profiles are read").expect("the section behind them");
    let place = Place::new();
    place.write(
        "tiny.yaml",
        format!("{before}\nclasses: {{plain: {{share: 1}}}}\n\n# How the profiles are read{after}"),
    );
    place
}

/// What dataset.json warns of.
fn warnings(place: &Place, folder: &str) -> Vec<Value> {
    place.json(&format!("{folder}/dataset.json"))["warnings"].as_array().cloned().unwrap_or_default()
}

#[test]
#[ignore = "long"]
fn what_is_of_no_use_is_told_before_the_first_sample() {
    for (recipe, change, code, remedy) in USELESS {
        let place = of_one_class(recipe);
        let asked = format!("--recipe tiny.yaml --set {change} --n 1 --out set");
        let strict = place.run(&format!("{asked} --strict"));
        assert_eq!(strict.code, 1, "{change}: {}", strict.err);
        assert!(strict.err.contains("--strict") && strict.err.contains(remedy), "{change}: {}", strict.err);
        assert!(!place.path("set").exists(), "{change}: nothing is written");

        let made = place.done(&asked);
        let found = warnings(&place, "set");
        let codes: Vec<&str> = found.iter().filter_map(|warning| warning["code"].as_str()).collect();
        assert!(codes.contains(&code), "{recipe} {change}: {found:?}");
        let own = found.iter().find(|warning| warning["code"] == code).expect("it is there");
        let text = |key: &str| own[key].as_str().expect("a text");
        assert!(text("remedy").contains(remedy), "{recipe} {change}: {own}");
        let told = format!("warning: {}; {}", text("what"), text("remedy"));
        assert!(made.err.contains(&told), "no `{told}` in {}", made.err);

        // The row of each sample tells it, and so does validation, which has no fault.
        let strict = place.run("validate set --json --rerender 0 --strict");
        let report: Value = serde_json::from_str(&strict.out).expect("it is JSON");
        assert_eq!((&report["clean"], &report["fault_counts"]), (&true.into(), &serde_json::json!({})), "{change}");
        assert_eq!(report["warning_counts"][code], 1, "{recipe} {change}: {report:#}");
        assert!(strict.code == 1 && strict.err.contains("0 faults and"), "{change}: {}", strict.err);
    }
}

/// The whole recipe that the reference of keys shows makes samples of use.
#[test]
fn the_recipe_of_the_reference_has_no_warning() {
    let page = recipe::reference_markdown();
    let (_, rest) = page.split_once("A whole recipe:\n\n```yaml\n").expect("the page shows one");
    let (text, _) = rest.split_once("```").expect("it ends");
    let place = Place::new();
    place.write("tiny.yaml", text);
    let made = place.done("--recipe tiny.yaml --n 1 --out set --strict");
    assert!(!made.err.contains("warning"), "{}", made.err);
}

/// The cause is told, not the symptom: each remedy is of the key that is at fault, and the opposite of none.
#[test]
#[ignore = "long"]
fn remedies_name_the_cause() {
    let place = of_one_class("wood-small");
    for (change, code, remedy) in [
        ("exposure.time_us=100000", "", "shorten exposure.time_us"),
        ("laser.waist_mm=2", "wide-line", "narrow it on the object (laser.waist_mm"),
        (
            "camera.scheimpflug=given --set camera.focus_distance_mm=200",
            "wide-line",
            "bring it into focus on the sensor (camera.scheimpflug: solved",
        ),
        ("motion.step_mm=5", "profiles-far-apart", "lower motion.step_mm"),
        ("extraction.threshold_dn=250", "hardly-measured", "lower extraction.threshold_dn"),
        ("camera.rows=64", "hardly-measured", "raise camera.rows"),
        // All the light on a third of the board saturates there, and less of it is no remedy.
        ("laser.fan_angle_deg=1", "partly-measured", "widen the fan by laser.fan_angle_deg"),
        ("laser.fan_angle_deg=2.8 --set laser.power_mw=3", "fan-cuts-object", "widen the fan by laser.fan_angle_deg"),
        ("camera.rows=200", "", "raise camera.rows"),
        // The first sample is hardly measured, the next ones in part.
        (
            "laser.fan=cylindrical --set laser.fan_angle_deg=3 --set laser.power_mw=0.16",
            "partly-measured",
            "raise laser.power_mw",
        ),
    ] {
        let strict = place.run(&format!("--recipe tiny.yaml --set {change} --n 1 --out set --strict"));
        assert!(strict.code == 1 && strict.err.contains(remedy), "{change}: {}", strict.err);
        assert!(!strict.err.contains("raise exposure.time_us"), "{change}: {}", strict.err);
        let less_light = remedy.contains("shorten exposure.time_us");
        assert_eq!(strict.err.contains("shorten exposure.time_us"), less_light, "{change}: {}", strict.err);
        if !code.is_empty() {
            place.done(&format!("--recipe tiny.yaml --set {change} --n 1 --out {code}"));
            let found = warnings(&place, code);
            assert!(found.iter().any(|warning| warning["code"] == code), "{change}: {found:?}");
            fs::remove_dir_all(place.path(code)).expect("it goes");
        }
    }
}

/// Guards against data of which a part is missing by the rig's doing and nobody says so. A fan of one degree lights the
/// share of the board that its width says, the check, the rows and `gen rig` tell it, and what samples lack by their
/// own defects is not told.
#[test]
fn a_fan_that_ends_on_the_object_is_told() {
    let place = of_one_class("wood-small");
    let board = "--set board.offset_mm=0 --set board.width_mm=20 --set board.thickness_mm=22";
    let narrow = "--set laser.fan_angle_deg=1 --set laser.power_mw=1";
    let made = place.done(&format!("--recipe tiny.yaml {narrow} {board} --n 2 --out set"));
    assert!(made.err.contains("the laser's fan ends on it") && !made.err.contains("of 2 samples made"), "{}", made.err);
    let expected = 2.0 * (400.0 - 22.0) * 0.5f64.to_radians().tan() / 20.0;
    for sample in place.samples("set").values() {
        let Field::Double(measured) = sample.columns["measured_share"] else { panic!("no number") };
        // Light creeps a few tenths of a mm through the wood beyond either end.
        assert!((0.0..0.04).contains(&(measured - expected)), "{measured} of {expected}");
    }
    let rig = place.done("rig tiny.yaml --set laser.fan_angle_deg=1");
    assert!(rig.err.contains("widen the fan") && !rig.err.contains("shorten exposure"), "{}", rig.err);
    assert!(!place.done("rig tiny.yaml --set laser.power_mw=3000").err.contains("fan"));

    // Holes and the dark parts of knots are what samples show.
    let defects = "--set knots.hole_count=3 --set knots.width_mm=8 --set knots.dead_count=2";
    let made = place.done(&format!("--recipe tiny.yaml {defects} --n 3 --out holes --strict"));
    assert!(!made.err.contains("warning: "), "{}", made.err);
}

/// Warnings of validation are told with what to do, and change the status only where that is asked for.
#[test]
fn warnings_of_validation_are_no_faults() {
    let place = of_one_class("wood-small");
    place.done("--recipe tiny.yaml --set board.offset_mm=300 --n 2 --out set");
    let clean = place.done("validate set --rerender 0");
    assert!(clean.out.contains("warning: object-out-of-view (2): bring the object into the field"), "{}", clean.out);
    assert!(clean.out.contains("0 faults, 2 warnings") && clean.err.is_empty(), "{}{}", clean.out, clean.err);
    let strict = place.run("validate set --rerender 0 --strict");
    assert!(strict.code == 1 && strict.err.contains("set has 0 faults and 2 warnings"), "{}", strict.err);
}

/// A bright surface over matter that lets no light out again is measured like any other.
#[test]
fn matter_that_swallows_all_light_is_measured_by_its_surface() {
    let place = Place::new();
    let matter = "--set material.mu_a_per_mm=1000 --set material.sigma_i_per_mm=0.01 --set material.gloss=0 --set \
        material.matte=0.37";
    let made = place.done(&format!("--recipe sawtooth-small {matter} --n 1 --strict --out set"));
    assert!(!made.err.contains("warning: "), "{}", made.err);
}

/// Samples that fall short by chance are told when they are made, once, and by the exit status where that is asked for.
#[test]
fn single_samples_that_fall_short_are_told() {
    let place = Place::new();
    let some = "board.offset_mm={choice: {values: [0, 300]}}";
    let mut command = place.command("--recipe wood-small --n 8 --out set --strict");
    let made = command.args(["--set", some]).output().expect("it runs");
    let err = String::from_utf8_lossy(&made.stderr);
    let told = err.matches(" of 8 samples made are of little use (object-out-of-view)").count();
    assert!(made.status.code() == Some(1) && told == 2, "{err}");
    assert!(err.contains("--strict: the samples are kept, and "), "{err}");
    let found = place.run("validate set --rerender 0 --strict");
    assert!(found.code == 1 && found.out.contains("0 faults"), "{}{}", found.out, found.err);
}

/// A preview and an estimate tell it too.
#[test]
fn a_preview_tells_what_its_sample_falls_short_in() {
    let place = Place::new();
    let shown = place.done("preview --recipe wood-small --set board.offset_mm=300 --out board.png");
    assert!(shown.err.contains("warning: ") && shown.err.contains("board.offset_mm"), "{}", shown.err);
    let plain = place.done("preview --recipe wood-small --out board.png");
    assert!(!plain.err.contains("warning: "), "{}", plain.err);
    let estimate = place.done("--recipe wood-small --set laser.power_mw=0.1 --n 1 --estimate");
    assert!(estimate.err.contains("warning: ") && estimate.err.contains("raise laser.power_mw"), "{}", estimate.err);
}

/// Nothing that is shipped is warned of, whatever the seed: dark parts, overexposed packs and pieces that are longer
/// than the field are meant.
#[test]
#[ignore = "long"]
fn shipped_recipes_have_no_warnings() {
    let is_full = |name: &str| !name.ends_with("-small") && !name.ends_with("-train");
    for known in Recipe::embedded() {
        let recipe = Recipe::load(known.name).expect("it is built in");
        // Windows of a sawmill's boards cut them.
        let expected: &[&str] = if known.name == "wood-sawmill" { &["object-out-of-view"] } else { &[] };
        for seed in 0..if is_full(known.name) { 1 } else { 3 } {
            let codes: Vec<String> = rig_warnings(&recipe, seed).into_iter().map(|warning| warning.code).collect();
            assert_eq!(codes, expected, "{} with seed {seed}", known.name);
        }
    }
    let beside = AssetSource::Beside(concat!(env!("CARGO_MANIFEST_DIR"), "/recipes/real").into());
    for (name, text, expected) in [
        ("plastic-tray.yaml", include_str!("../../recipes/real/plastic-tray.yaml"), &[][..]),
        // A plate that is wider than the field, as the level part of a larger one is.
        ("plastic-level.yaml", include_str!("../../recipes/real/plastic-level.yaml"), &["object-out-of-view"]),
    ] {
        let recipe = Recipe::parse_with(name, text, &beside).expect("it loads");
        let codes: Vec<String> = rig_warnings(&recipe, 0).into_iter().map(|warning| warning.code).collect();
        assert_eq!(codes, expected, "{name}");
    }
}

/// Walls of pockets hide a third of the cards from a camera that looks along them.
#[test]
fn what_hides_itself_is_told_as_that() {
    let recipe =
        Recipe::load_changed("blister-small", &["camera.tilt_deg=73".parse().expect("a change")]).expect("loads");
    let found = rig_warnings(&recipe, 0);
    let own = found.iter().find(|warning| warning.code == "partly-measured").expect("it is told");
    assert!(own.what.contains("higher parts hide") && own.remedy == "lower camera.tilt_deg", "{own:?}");
}

/// Half of a board beside the middle of the line: the share that lies in the field is that of the rig's own field of
/// view.
#[test]
fn the_share_in_the_field_is_that_of_the_rig() {
    let place = Place::new();
    let flat = "--set board.width_mm=20 --set board.offset_mm=10 --set board.cup_mm=0 --set board.twist_deg=0";
    let rig: Value = serde_json::from_str(&place.done(&format!("rig wood-small {flat} --json")).out).expect("JSON");
    let field = rig["numbers"]["field_of_view_mm"].as_f64().expect("a number");
    place.done(&format!("--recipe wood-small {flat} --n 1 --out set"));
    let samples = place.samples("set");
    let Field::Double(found) = samples[&0].columns["object_in_view"] else { panic!("no number") };
    // The board lies from 0 to 20 mm, the field to half of its width; the hull is within 0.2 mm of the board.
    assert!((found - 0.5 * field / 20.0).abs() < 0.2 / 20.0, "{found} of a field of {field} mm");
}

/// The check looks at profiles as the dataset will have them. Labels are the same, bodies that light does not enter are
/// bit for bit, and what is measured of others is but for light that has crept far and light that fills pockets, of
/// which Reflectance has next to nothing.
#[test]
fn profiles_are_rendered_as_in_the_whole_scan() {
    let even = recipe(&[["\n  window_rows: 7", "\n  range: rectified\n  window_rows: 7"]]);
    let second = recipe(&[["\nlaser:\n", "\nlaser:\n  second_line_mm: 1.3\n  second_line_share: 0.4\n"]]);
    let spread = [recipe(&[]), even, second, pack_recipe(&[])].map(|text| (text, false));
    let solid = [sawtooth_recipe(&[]), mesh_recipe(&[])].map(|text| (text, true));
    for (text, is_solid) in spread.into_iter().chain(solid) {
        let recipe = Recipe::parse("tiny.yaml", &text).expect("the recipe loads");
        let (scene, patterns) = (recipe.draw(3, 1), PatternCache::new(recipe.streams(3).key()));
        let whole = pipeline::render(&scene, &patterns, &|_| ());
        let (sensor, specimen) = pipeline::set_up(&scene, pipeline::body(&scene), &patterns);
        let specimen = specimen.without_pockets();
        let chosen: Vec<usize> = (0..scene.size.profiles).step_by(7).collect();
        let (maps, labels) = pipeline::render_profiles(&scene, &sensor, &specimen, &chosen);
        let cols = scene.size.columns;
        let mut counts = [[0u32; 2]; 2];
        let mut light = [0.0f64; 2];
        for (place, &profile) in chosen.iter().enumerate() {
            let [part, line] = [place, profile].map(|row| row * cols..(row + 1) * cols);
            assert_eq!(labels.class[part.clone()], whole.labels.class[line.clone()]);
            assert_eq!(labels.instance[part.clone()], whole.labels.instance[line.clone()]);
            let bits = |map: &[f32]| map.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            let both = [
                (&maps.range, &whole.maps.range),
                (&maps.reflectance, &whole.maps.reflectance),
                (&maps.scatter, &whole.maps.scatter),
            ];
            for (looked, all) in both.into_iter().filter(|_| is_solid) {
                assert_eq!(bits(&looked[part.clone()]), bits(&all[line.clone()]), "profile {profile}");
            }
            for (of, (maps, pixels)) in [(&maps, part), (&whole.maps, line)].into_iter().enumerate() {
                counts[0][of] += maps.range[pixels.clone()].iter().filter(|height| height.is_finite()).count() as u32;
                counts[1][of] +=
                    maps.reflectance[pixels.clone()].iter().filter(|&&light| light >= 255.0).count() as u32;
                let reflected = maps.reflectance[pixels].iter().copied();
                light[of] += reflected.filter(|light| light.is_finite()).map(f64::from).sum::<f64>();
            }
        }
        let pixels = (chosen.len() * cols) as f64;
        for (what, [part, all]) in ["measured", "saturated"].into_iter().zip(counts) {
            let off = f64::from(part.abs_diff(all)) / pixels;
            assert!(off < 0.01, "{what} {part} and {all} of {pixels}");
        }
        let [part, all] = light;
        assert!((part / all - 1.0).abs() < 0.005, "Reflectance {part} and {all}");
    }
}

/// The warnings follow from recipe and seed: the same for any threads, parts and number of samples, so the dataset goes
/// on.
#[test]
fn a_dataset_with_warnings_goes_on() {
    let place = of_one_class("wood-small");
    let asked = "--recipe tiny.yaml --set scan.columns=96 --set scan.profiles=64 --set laser.power_mw=0.1 \
        --samples-per-shard 1";
    place.done(&format!("{asked} --n 1 --out set --threads 1"));
    place.done(&format!("{asked} --n 3 --out set --part 1/2"));
    let again = place.done(&format!("{asked} --n 3 --out set"));
    assert!(again.err.contains("warning: "), "{}", again.err);
    place.done("--recipe set --n 3");
    place.done(&format!("{asked} --n 3 --out whole"));
    assert_same(&place.tree("set"), &place.tree("whole"), "one run and three");
    assert!(!warnings(&place, "set").is_empty());
    let card = fs::read_to_string(place.path("set/README.md")).expect("a card");
    assert!(card.contains("## Warnings") && card.contains("raise laser.power_mw"), "{card}");
    place.done("validate set");

    // The warnings are part of what dataset.json has to say.
    let mut head = place.json("set/dataset.json");
    head["warnings"][0]["what"] = "all is well".into();
    place.write("set/dataset.json", format!("{head:#}\n"));
    let run = place.run("validate set --rerender 0");
    assert!(
        run.code == 1 && run.out.contains("dataset-differs") && run.out.contains("warnings[0].what"),
        "{}",
        run.out
    );
    head.as_object_mut().expect("an object").shift_remove("warnings");
    place.write("set/dataset.json", format!("{head:#}\n"));
    let run = place.run("validate set --rerender 0");
    assert!(run.code == 1 && run.out.contains("dataset-differs"), "{}", run.out);
}

/// The page shows in red what is of little use; that of a dataset that is of use has nothing to show.
#[test]
fn the_report_shows_it_in_red() {
    let place = of_one_class("wood-small");
    place.done("--recipe tiny.yaml --set board.offset_mm=300 --n 2 --out set");
    let html = page(&place, "set", "--frames 0");
    let section = between(&html, "<section class=\"trouble alarm\" id=\"warnings\"", "</section>");
    assert_eq!(section.len(), 1);
    assert!(section[0].contains("object-out-of-view") && section[0].contains("2 of 2 samples: 0, 1"), "{}", section[0]);
    assert!(
        section[0].contains("Before the first sample: ") && section[0].contains("board.offset_mm"),
        "{}",
        section[0]
    );
    assert!(html.contains("<span class=\"badge bad\">of little use</span>"));
    let cards = between(&html, "<article class=\"card\"", "</article>");
    assert!(cards.iter().all(|card| card.contains("no pixel shows the object")), "{}", cards[0]);
    // Red is the colour of what is bad.
    assert!(html.contains(".alarm { color: var(--bad)") && html.contains(".alarm dt { color: var(--bad)"));
    place.done("validate set --save --rerender 0");
    let verdict = page(&place, "set", "--frames 0");
    let verdict = between(&verdict, "<section id=\"validation\"", "</section>")[0];
    assert!(
        verdict.contains("clean") && verdict.contains("<span class=\"badge bad\">warnings</span> 2 listed"),
        "{verdict}"
    );

    place.done("--recipe wood-small --n 1 --out fine");
    let html = page(&place, "fine", "--frames 0");
    assert!(!html.contains("id=\"warnings\"") && !html.contains("of little use"));
}
