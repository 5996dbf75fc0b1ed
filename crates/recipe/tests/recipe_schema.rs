//! Purpose: the recipes load, the schema knows all their keys, and the committed schema and reference are fresh.
//!
//! `BLESS=1 cargo test -p recipe --test recipe_schema` writes the committed copies again.

use std::path::{Path, PathBuf};

use procedural::blister::{Blister, Defects};
use procedural::wood::Wood;
use recipe::{Plan, Recipe, Subject, reference_markdown, reference_pages, schema};
use serde_json::Value;

/// The top of the tree.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn recipes() -> Vec<(String, String)> {
    let folder = root().join("recipes");
    let files = std::fs::read_dir(&folder).expect("recipes/").map(|entry| entry.expect("an entry").path());
    let yaml = files.filter(|path| path.extension().is_some_and(|end| end == "yaml"));
    yaml.map(|path| (path.display().to_string(), std::fs::read_to_string(&path).expect("a text"))).collect()
}

#[test]
fn every_recipe_loads_and_is_embedded() {
    let recipes = recipes();
    // Those of the thesis lie in a folder of their own: recipe/thesis.rs.
    assert_eq!(recipes.len(), Recipe::embedded().map(|recipe| recipe.name).filter(|name| !name.contains('/')).count());
    for (path, text) in recipes {
        let recipe = Recipe::load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(recipe.written(), text);
        let name = recipe.name();
        assert!(path.ends_with(&format!("{name}.yaml")), "{path} is called {name}");
        for spelling in [name.to_owned(), format!("./recipes/{name}.yaml"), format!("{name}.yaml")] {
            assert_eq!(Recipe::load(&spelling).expect("embedded").hash(), recipe.hash(), "{spelling}");
        }
        assert!(text.starts_with("# yaml-language-server: $schema=recipe.schema.json\n"), "{path}");
        let classes = recipe.classes().iter().map(|class| class.name.as_str());
        match recipe.subject() {
            Subject::Wood if name.starts_with("wood-grading") => {
                assert_eq!(classes.count(), if name == "wood-grading" { 18 } else { 17 });
            }
            Subject::Wood if ["wood-stem", "wood-measured"].contains(&name) => {
                assert!(classes.eq(["flat_sawn", "quarter_sawn", "through_pith"]));
            }
            Subject::Wood if name == "wood-log" => assert!(classes.eq(["sawn_through"])),
            Subject::Wood if name == "wood-sawmill" => assert!(classes.eq(["sawn"])),
            Subject::Wood if ["wood-picture", "wood-slices"].contains(&name) => {
                assert!(classes.eq(["checked", "plain"]))
            }
            Subject::Wood => assert!(classes.eq(["clear", "dead_knot", "mixed", "rot", "sound_knot"])),
            Subject::Sawtooth if name == "sawtooth" => assert!(classes.eq(["piece"])),
            Subject::Sawtooth => assert!(classes.eq(["even", "plastic", "turned", "upright"])),
            Subject::Mesh => assert!(classes.eq(["metal", "plastic", "turned"])),
            // Classes for 19 kinds of defect or more, and those for none and for several.
            Subject::Blister => {
                let is_kind = |class: &&str| Defects::PARAMETERS.iter().any(|p| p.integer && p.name == *class);
                let (kinds, others): (Vec<_>, Vec<_>) = classes.partition(is_kind);
                assert!(kinds.len() >= 19 && others == ["mixed", "sound"], "{path}: {others:?}");
            }
        }
        assert!((recipe.classes().iter().map(|class| class.share).sum::<f64>() - 1.0).abs() < 1e-9);
    }
}

/// Recipes of species are built in, say by their name what they are, and saw as their classes say.
#[test]
fn species_are_sawn_flat_and_along_the_radius() {
    for name in ["pine", "larch", "beech", "birch", "oak"] {
        let recipe = Recipe::load(&format!("species/{name}")).expect("embedded");
        assert_eq!(recipe.name(), name);
        for scene in (0..50).map(|index| recipe.draw(0, index)) {
            let wood = scene.plan.wood().expect("a board");
            let lean = wood.log.pith_offset_mm.abs() / wood.log.pith_depth_mm;
            assert_eq!(scene.class, if lean > 1.0 { "quarter_sawn" } else { "flat_sawn" });
            let is_conifer = ["pine", "larch"].contains(&name);
            assert_eq!(wood.anatomy.canals_per_mm2 > 0.0, is_conifer);
            assert_eq!(wood.anatomy.pores_per_mm2 > 0.0, !is_conifer);
        }
    }
}

fn embedded() -> Vec<Recipe> {
    let names = Recipe::embedded().map(|recipe| recipe.name).filter(|name| !name.contains('/'));
    names.map(|name| Recipe::load(name).expect("embedded")).collect()
}

#[test]
fn classes_hold_what_their_names_say() {
    for (index, recipe) in embedded().iter().flat_map(|recipe| (0..400).map(move |index| (index, recipe))) {
        let scene = recipe.draw(0, index);
        match &scene.plan {
            Plan::Wood(wood) if recipe.name().starts_with("wood-grading") => {
                graded_boards_are_called(&scene.class, wood)
            }
            Plan::Wood(wood) if ["wood-stem", "wood-measured"].contains(&recipe.name()) => {
                assert_eq!(scene.class == "quarter_sawn", wood.stem.face_deg.abs() > 60.0);
                assert_eq!(scene.class == "through_pith", wood.stem.board_radius_mm < 10.0);
            }
            Plan::Wood(_) if recipe.name() == "wood-log" => assert!(scene.log_board.is_some()),
            Plan::Wood(_) if recipe.name() == "wood-sawmill" => assert_eq!(scene.class, "sawn"),
            Plan::Wood(wood) if ["wood-picture", "wood-slices"].contains(&recipe.name()) => {
                assert_eq!(scene.class == "checked", wood.cracks.check_count > 0.0);
            }
            Plan::Wood(wood) => boards_are_called(&scene.class, wood),
            Plan::Blister(blister) => packs_are_called(&scene.class, &blister.defects),
            Plan::Sawtooth(piece, material) => {
                assert_eq!(scene.class == "upright", [0.0, 1.0].contains(&piece.rise_share));
                assert_eq!(scene.class == "turned", piece.turn_deg.abs() > 5.0);
                assert_eq!(scene.class == "plastic", material.matte == 0.0);
            }
            Plan::Mesh(placing, material) => {
                assert_eq!(scene.class == "turned", placing.rotate_z_deg > 90.0);
                assert_eq!(scene.class == "plastic", material.matte == 0.0);
            }
        }
    }
}

fn boards_are_called(class: &str, wood: &Wood) {
    let shown = (wood.knots.sound_count > 0.0, wood.knots.dead_count > 0.0, wood.rot.reach_mm > 0.0);
    let meant = match class {
        "clear" => (false, false, false),
        "sound_knot" => (true, false, false),
        "dead_knot" => (false, true, false),
        "rot" => (false, false, true),
        "mixed" => (true, true, true),
        other => panic!("{other}"),
    };
    assert_eq!(shown, meant, "{class}");
}

fn graded_boards_are_called(class: &str, wood: &Wood) {
    let Wood { knots, rot, inclusions, cracks, marks, .. } = wood;
    let shown = [
        ("sound_knot", knots.sound_count > 0.0 && knots.hole_count == 0.0),
        ("dead_knot", knots.dead_count > 0.0),
        ("knot_hole", knots.hole_count > 0.0),
        ("loose_knot", knots.loose_count > 0.0),
        ("edge_rot", rot.reach_mm > 0.0),
        ("heart_rot", rot.heart_mm > 0.0),
        ("pocket_rot", rot.pocket_count > 0.0),
        ("blue_stain", wood.stain.severity > 0.0),
        ("compression_wood", wood.compression.severity > 0.0),
        ("resin", inclusions.resin_pocket_count > 0.0),
        ("bark_pocket", inclusions.bark_pocket_count > 0.0),
        ("pith", wood.log.pith_depth_mm < 2.0 && rot.heart_mm == 0.0),
        ("crack", cracks.check_count > 0.0),
        ("shake", cracks.shake_count > 0.0),
        ("insect", wood.holes.count > 0.0),
        ("wane", wood.wane.width_mm > 0.0),
        ("marks", marks.dirt_count > 0.0),
    ];
    let shown: Vec<&str> = shown.into_iter().filter(|(_, is_shown)| *is_shown).map(|(name, _)| name).collect();
    let meant = if class == "clear" { vec![] } else { vec![class] };
    assert_eq!(shown, meant);
}

fn packs_are_called(class: &str, defects: &Defects) {
    let counts = defects.values().into_iter().filter(|(parameter, count)| parameter.integer && *count > 0.0);
    let kinds: Vec<_> = counts.map(|(parameter, _)| parameter.name).collect();
    match class {
        "sound" => assert!(kinds.is_empty(), "{kinds:?}"),
        "mixed" => assert!(kinds.len() >= 2, "{kinds:?}"),
        kind => assert_eq!(kinds, [kind]),
    }
}

#[test]
fn the_object_lies_in_the_field() {
    for (index, recipe) in embedded().iter().flat_map(|recipe| (0..400).map(move |index| (index, recipe))) {
        let (name, scene) = (recipe.name(), recipe.draw(1, index));
        let turned = |width: f64, length: f64, turn_deg: f64| {
            let (s, t) = (turn_deg.to_radians().sin().abs(), turn_deg.to_radians().cos().abs());
            (width * t + length * s, width * s + length * t)
        };
        let (width, length, height, offset, lead_in) = match &scene.plan {
            Plan::Sawtooth(p, _) => {
                let (width, length) = turned(p.length_mm, p.width_mm, p.turn_deg);
                (width, length, p.base_mm, p.offset_mm, p.lead_in_mm)
            }
            Plan::Mesh(p, _) => {
                let extent = p.extent(scene.mesh.as_deref().expect("a recipe of meshes has one"));
                (extent.x, extent.y, 0.0, p.offset_mm, p.lead_in_mm)
            }
            Plan::Wood(Wood { board: b, .. }) => (b.width_mm, b.length_mm, b.thickness_mm, b.offset_mm, b.lead_in_mm),
            Plan::Blister(Blister { card: c, .. }) => {
                let (width, length) = turned(c.width_mm, c.length_mm, c.turn_deg);
                (width, length, 0.0, c.offset_mm, c.lead_in_mm)
            }
        };
        // Windows of a sawmill's boards cut them.
        let scanned = scene.size.profiles as f64 * scene.bench.motion.step_mm;
        assert_eq!(lead_in + length <= scanned, name != "wood-sawmill", "{name} {index}");
        // Pixel pitch on the upper surface, docs of the camera: (d - f - z cos a) / f times the pitch.
        let camera = scene.bench.camera;
        let height = height * camera.tilt_deg.to_radians().cos();
        let pitch =
            1e-3 * camera.pixel_um * (camera.distance_mm - camera.focal_length_mm - height) / camera.focal_length_mm;
        let half_field = 0.5 * pitch * scene.size.columns as f64;
        assert!(offset.abs() + 0.5 * width <= half_field, "{name} {index}: {:?} {half_field}", scene.plan);
    }
}

/// Whether the kinds of a schema have `null` among them.
fn may_be_nothing(schema: &Value) -> bool {
    schema["type"] == "null" || schema["type"].as_array().is_some_and(|kinds| kinds.contains(&"null".into()))
}

/// Every key of `value` is a property of `schema`, and every word one of its words.
fn covered(root: &Value, schema: &Value, value: &Value, path: &str) {
    if let Some(reference) = schema["$ref"].as_str() {
        let target = root.pointer(reference.trim_start_matches('#')).unwrap_or_else(|| panic!("{reference}"));
        return covered(root, target, value, path);
    }
    if let Some(options) = schema["oneOf"].as_array() {
        // The option is found by the kind of the value: a map for a distribution, else a number or a word.
        let forms = |option: &&Value| match value.as_object() {
            None if value.is_array() => option["type"] == "array",
            None if value.is_null() => option["$ref"].is_string() || may_be_nothing(option),
            Some(map) => option["$ref"].is_string() || map.keys().all(|key| !option["properties"][key].is_null()),
            None => option["$ref"].is_null() && (value.is_string() || option["minLength"].is_null()),
        };
        let maps = |option: &&Value| forms(option) && has_form(root, option, value);
        let option = options.iter().find(maps).unwrap_or_else(|| panic!("{path}: {value} is none of {options:?}"));
        return covered(root, option, value, path);
    }
    if let Some(words) = schema["enum"].as_array() {
        assert!(words.contains(value), "{path}: {value} is none of {words:?}");
    }
    if let Some(number) = value.as_f64() {
        let limit = |name: &str, none: f64| schema[name].as_f64().unwrap_or(none);
        assert!((limit("minimum", f64::MIN)..=limit("maximum", f64::MAX)).contains(&number), "{path}: {number}");
    }
    for (key, inner) in value.as_object().into_iter().flatten() {
        let path = format!("{path}.{key}");
        let property = &schema["properties"][key];
        let known = if property.is_null() { &schema["additionalProperties"] } else { property };
        assert!(known.is_object(), "{path} is not in the schema");
        covered(root, known, inner, &path);
    }
}

/// Whether a reference to a form of distribution is to the form of `value`.
fn has_form(root: &Value, option: &Value, value: &Value) -> bool {
    let Some(reference) = option["$ref"].as_str() else { return true };
    let target = &root.pointer(reference.trim_start_matches('#')).unwrap_or_else(|| panic!("{reference}"));
    let keys = value.as_object().map(|map| map.keys().map(String::as_str).collect::<Vec<_>>()).unwrap_or_default();
    target["oneOf"].is_array() || keys.iter().all(|key| !target["properties"][key].is_null())
}

#[test]
fn the_schema_knows_every_key() {
    let schema = schema();
    for (path, text) in recipes() {
        let written: Value = serde_saphyr::from_str(&text).expect("YAML");
        covered(&schema, &schema, &written, &path);
        // The canonical form has every key, defaults included.
        let canonical = Recipe::load(&path).expect("a recipe").canonical_json();
        covered(&schema, &schema, &serde_json::from_str(&canonical).expect("JSON"), &path);
    }
}

#[test]
fn every_map_of_the_schema_is_closed() {
    fn closed(value: &Value, path: &str) {
        // What stands beside `oneOf` narrows the forms, which are closed themselves.
        if value["properties"].is_object() && value["type"].is_string() {
            assert!(!value["additionalProperties"].is_null(), "{path}");
        }
        for (key, inner) in value.as_object().into_iter().flatten() {
            closed(inner, &format!("{path}/{key}"));
        }
    }
    closed(&schema(), "");
}

/// The committed `file` is `fresh`; with BLESS=1 it is written.
fn committed(file: &str, fresh: &str) {
    let path = root().join(file);
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&path, fresh).expect("it can be written");
    }
    let stale = std::fs::read_to_string(&path).unwrap_or_default() != fresh;
    assert!(!stale, "{file} is stale: run `BLESS=1 cargo test -p recipe --test recipe_schema` and commit it");
}

#[test]
fn the_committed_schema_is_fresh() {
    committed("recipes/recipe.schema.json", &format!("{:#}\n", schema()));
}

/// A number has one unit, in the reference of recipes and in the tables of datasets.
#[test]
fn units_are_those_of_datasets() {
    let mut numbers = 0;
    for line in reference_markdown().lines() {
        let cells: Vec<&str> = line.split(" | ").map(|cell| cell.trim_matches([' ', '|', '`'])).collect();
        let [key, _, unit, default, ..] = cells.as_slice() else { continue };
        // A plain `rows` or `columns` is a size, which tables have by other names.
        if !key.contains('_') || default.parse::<f64>().is_err() {
            continue;
        }
        numbers += 1;
        let unit = if unit.is_empty() { "1" } else { unit };
        assert_eq!(unit, output_schema::unit_of(key), "{key}");
    }
    assert!(numbers > 100, "{numbers}");
}

#[test]
fn the_committed_reference_is_fresh() {
    let pages = reference_pages();
    let first = pages[0].text.split("## Fifteen keys that matter first").nth(1).expect("a section");
    let keys = first.split("## ").next().unwrap_or_default().lines().filter(|line| line.starts_with("| `")).count();
    assert_eq!(keys, 15, "the keys that matter first are keys: {first}");
    for page in pages {
        committed(&format!("recipes/{}", page.file), &page.text);
    }
}

#[test]
fn the_whole_recipe_of_the_reference_is_one() {
    let page = reference_markdown();
    let example = page.split("```yaml\n").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    let recipe = Recipe::parse("README.md", example).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(recipe.classes().len(), 2);
}
