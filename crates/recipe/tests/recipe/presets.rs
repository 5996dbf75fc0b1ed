//! Presets: each has sources and draws, what is stated wins, and faults name their file; first recipes.

use base::Stream;
use rand::RngExt;
use recipe::asset_source::AssetSource;
use recipe::{Change, Recipe, Subject, presets};
use serde_json::Value;

use super::support::{GOOD, faults};

fn good(text: &str) -> Recipe {
    Recipe::parse("good.yaml", text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The value at a key path.
fn at(recipe: &Recipe, path: &str) -> Value {
    path.split('.').fold(recipe.canonical(), |value, name| value[name].clone())
}

/// Each number has a source that can be looked up and the date when it was, and each sheet says what it lacks.
#[test]
fn every_number_has_a_source_and_a_date() {
    let all = presets();
    let mut names: Vec<_> = all.iter().map(|preset| (preset.section, &preset.name)).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), all.len(), "a name stands twice");
    for preset in &all {
        let name = &preset.name;
        assert!(name.bytes().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'-'), "{name}");
        assert!(!preset.what.is_empty() && !preset.numbers.is_empty() && !preset.lacks.is_empty(), "{preset:?}");
        for number in &preset.numbers {
            let of = if number.key.starts_with("knots.") { "log" } else { number.key.split('.').next().expect("one") };
            let own = if ["scan", "exposure"].contains(&of) { "camera" } else { of };
            assert_eq!(own, preset.section, "{name}: {}", number.key);
            assert!(number.source.what.len() > 8, "{name}: {number:?}");
            let date: Vec<_> = number.source.seen.split('-').map(str::len).collect();
            assert_eq!(date, [4, 2, 2], "{name}: {number:?}");
        }
        let mut keys: Vec<_> = preset.numbers.iter().map(|number| &number.key).collect();
        keys.sort();
        keys.dedup();
        assert_eq!(keys.len(), preset.numbers.len(), "{name}");
    }
    let sensor = ["camera.pixel_um", "scan.columns", "camera.rows", "exposure.full_well_e", "exposure.dark_noise_dn"];
    let whole = all.iter().filter(|preset| sensor.iter().all(|key| preset.numbers.iter().any(|n| n.key == *key)));
    assert!(whole.count() >= 10);
}

/// Each preset is a recipe's part: it draws, and the recipe has its numbers.
#[test]
fn every_preset_draws() {
    for preset in presets() {
        let subject = match preset.section {
            "tablet" | "film" | "foil" => Subject::Blister,
            _ => Subject::Wood,
        };
        let (section, name) = (preset.section, &preset.name);
        // A card with room for the largest capsules.
        let card = "pack: {width_mm: 120, length_mm: 160, pitch_x_mm: 34, pitch_y_mm: 40}\n";
        let card = if subject == Subject::Blister { card } else { "" };
        let text = format!(
            "name: good\nsubject: {}\nclasses: {{clear: {{share: 1}}}}\n{card}{section}: {{preset: {name}}}\n",
            subject.name()
        );
        let recipe = good(&text);
        (0..3).for_each(|index| drop(recipe.draw(0, index)));
        for number in &preset.numbers {
            let written = serde_json::from_str::<f64>(&number.value).ok();
            let found = at(&recipe, &number.key);
            assert!(!found.is_null() && written.is_none_or(|value| found.as_f64() == Some(value)), "{name}: {found}");
        }
        let kept = Recipe::parse_with("dataset.json", recipe.text(), &AssetSource::Kept(Vec::new())).expect("whole");
        assert_eq!(kept.hash(), recipe.hash());
        assert!(recipe.text().contains(&format!("  presets/{section}.yaml\n")), "{}", recipe.text());
        assert_eq!(recipe.written(), text);
    }
}

/// What is not stated is at its default.
const FIXED: &str = "name: good\nsubject: wood\nunstated: fixed\nclasses: {clear: {share: 1}}\n";

#[test]
fn stated_keys_win_over_presets_and_these_over_parents() {
    let camera = "camera: {preset: alvium-c-508, pixel_um: 5, f_number: 4}\nexposure: {full_well_e: 9000}\n";
    let recipe = good(&format!("extends: wood-small\n{camera}"));
    let parent = Recipe::load("wood-small").expect("built in");
    let number = |path: &str| at(&recipe, path);
    assert_eq!((number("camera.pixel_um"), number("exposure.full_well_e")), (5.0.into(), 9000.0.into()));
    assert_eq!((number("camera.rows"), number("exposure.dsnu_dn")), (2056.into(), 0.0.into()));
    assert_eq!(number("camera.tilt_deg"), at(&parent, "camera.tilt_deg"));
    // Nothing takes a number away, both the preset's and the parent's.
    let without = good("extends: wood-small\ncamera: {preset: alvium-c-508, pixel_um: null}\n");
    assert_eq!(at(&without, "camera.pixel_um"), at(&good(GOOD), "camera.pixel_um"));
    // Of several the last one, also where a list has them.
    let both = good(&format!("{GOOD}camera: {{preset: [cmv4000, lens-25mm-thesis, alvium-c-052]}}\n"));
    assert_eq!((at(&both, "camera.pixel_um"), at(&both, "camera.rows")), (9.0.into(), 624.into()));
    assert_eq!(at(&both, "exposure.dark_current_e_per_s"), Value::from(125.0));
    // A key in the words of data sheets replaces what the preset says.
    let words = good(&format!("{FIXED}laser: {{preset: s-laser-660-fine, waist_fwhm_mm: 0.3}}\n"));
    let told = format!("{FIXED}laser: {{waist_fwhm_mm: 0.3, m_squared: 1.36}}\n");
    assert_eq!(words.canonical(), good(&told).canonical());
    // In a class, and in what is changed, where it wins over the text but not over what is changed itself.
    let text =
        "name: good\nsubject: blister\nunstated: fixed\nclasses: {a: {share: 1, film: {preset: pp}}, b: {share: 1}}\n";
    let classes = good(text);
    assert_eq!((at(&classes, "classes.a.film.n"), at(&classes, "film.n")), (1.49.into(), 1.53.into()));
    let change = |text: &str| text.parse::<Change>().expect("a change");
    let changes = ["camera.preset=alvium-c-291", "camera.rows=1000", "classes.b.film.preset=pp"].map(change);
    let changed = format!("{text}camera: {{pixel_um: 7}}\n");
    let changed = Recipe::parse_changed("good.yaml", &changed, &AssetSource::BuiltIn, &changes).expect("good");
    assert_eq!((at(&changed, "camera.pixel_um"), at(&changed, "camera.rows")), (4.5.into(), 1000.into()));
    assert_eq!(at(&changed, "classes.b.film.n"), Value::from(1.49));
}

#[test]
fn faults_of_presets_name_what_to_do() {
    for (line, words) in [
        ("camera: {preset: alvium-c-509}", "did you mean `alvium-c-508`?"),
        ("camera: {preset: 3}", "is a number; give the name of a preset, or a list of some"),
        ("camera: {preset: }", "is nothing; give the name of a preset"),
        ("camera: {preset: [cmv2000, {a: 1}]}", "is a map; give the name of a preset"),
        ("camera: {preset: [a, a, a, a, a, a, a, a, a]}", "names 9 presets; name at most 8"),
        ("speckle: {preset: cmv2000}", "presets are for `laser`, `camera`, `log`"),
        ("preset: cmv2000", "presets are for `laser`, `camera`, `log`"),
        ("classes: {clear: {share: 1, camera: {preset: cmv2000}}}", "`camera.rows` is the same for all classes"),
        ("set: {camera: {preset: cmv2000}}", "set `camera.preset` by itself"),
        ("film: {preset: pp}", "is for subject `blister`"),
    ] {
        let text =
            if line.starts_with("classes") { GOOD.lines().take(2).collect::<Vec<_>>().join("\n") } else { GOOD.into() };
        let found = faults(&format!("{text}\n{line}\n"));
        assert!(found.to_string().contains(words), "{line}: {found}");
        assert!(found.list.iter().all(|fault| !fault.remedy.is_empty()), "{found}");
    }
    // What does not go with what is stated is told where the preset says it.
    let found = faults(&format!("{GOOD}camera: {{preset: cmv2000}}\nexposure: {{row_noise_dn: 2}}\n"));
    let fault = &found.list[0];
    assert_eq!(
        (fault.origin.as_deref(), fault.key.as_str()),
        (Some("presets/camera.yaml (built in)"), "exposure.dark_noise_dn")
    );
    assert!(found.to_string().contains("exposure.dark_noise_dn: {is: 0.45"), "{found}");
}

/// Any presets together, in any recipe: taken or refused with a remedy, never a panic.
#[test]
fn presets_at_random_never_panic() {
    let mut rng = Stream::root(52).child("presets").rng();
    let all = presets();
    let mut accepted = 0;
    for _ in 0..60 {
        let subject = Subject::NAMES[rng.random_range(0..4)];
        let parent = format!("{}-small", subject);
        let mut text = format!("extends: {parent}\n");
        let mut sections: Vec<_> = all.iter().map(|preset| preset.section).collect();
        sections.dedup();
        for section in sections {
            if rng.random_range(0..4) > 0 {
                continue;
            }
            let of_it: Vec<_> = all.iter().filter(|preset| preset.section == section).collect();
            let names: Vec<_> =
                (0..rng.random_range(1..4)).map(|_| of_it[rng.random_range(0..of_it.len())].name.as_str()).collect();
            text += &format!("{section}: {{preset: [{}]}}\n", names.join(", "));
        }
        match Recipe::parse("random.yaml", &text) {
            Ok(recipe) => {
                accepted += 1;
                recipe.draw(0, 0);
                assert_eq!(Recipe::parse("flat", recipe.text()).expect("good").hash(), recipe.hash(), "{text}");
            }
            Err(error) => assert!(error.to_string().contains("; "), "{error}"),
        }
    }
    assert!((10..60).contains(&accepted), "{accepted} of 60 accepted");
}

/// A first recipe is short, says what its lines are, and draws.
#[test]
fn first_recipes_are_short_and_draw() {
    for subject in Subject::ALL {
        let text = Recipe::first(subject);
        assert!(text.lines().count() <= 20, "{text}");
        assert!(text.matches('#').count() >= 8, "{text}");
        let recipe = good(text);
        assert_eq!(recipe.subject(), subject);
        assert!(recipe.classes().len() > 1 && recipe.notes().is_empty(), "{:?}", recipe.notes());
        (0..20).for_each(|index| drop(recipe.draw(0, index)));
    }
}

/// The rigs that the guide follows are recipes, and the presets in them are used.
#[test]
fn the_rigs_of_the_guide_draw() {
    let page = include_str!("../../../../docs/guide/data-sheets.md");
    let rigs: Vec<_> = page.split("```yaml\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    assert_eq!(rigs.len(), 3);
    for rig in rigs {
        let recipe = good(rig);
        assert!(rig.contains("preset: ") && recipe.notes().is_empty(), "{:?}", recipe.notes());
        (0..3).for_each(|index| drop(recipe.draw(0, index)));
    }
}
