//! Words of card and Croissant metadata that the recipe decides: kind and origin of the wood, whether light enters the
//! object, which model of light and which effects. A fixed word in their place is wrong of some recipe.

use std::fs;

use dataset::{Dataset, objects_in_words};
use output_schema::file::{CARD, CROISSANT, manifest_path};
use output_schema::{Manifest, ManifestSample};
use recipe::Recipe;
use serde_json::Value;
use sheetlight::generate::{DatasetRequest, dataset_head};

/// What is said of a dataset of one sample, which nobody rendered: the words for its objects, the card and the
/// metadata.
fn said(recipe: &Recipe) -> (String, String, Value) {
    let place = tempfile::tempdir().expect("a temporary folder");
    let request =
        DatasetRequest { samples: 1, seed: 0, out: place.path().to_owned(), part: (0, 1), samples_per_shard: Some(1) };
    let folder = Dataset::open_or_create(place.path(), dataset_head(recipe, &request, Vec::new()), false, &|| ())
        .expect("it opens");
    let head = folder.head();
    let sample = ManifestSample {
        index: 0,
        id: "00000000-0000-5000-8000-000000000000".into(),
        split: "train".into(),
        class: head.classes[0].clone(),
        sha256: String::new(),
    };
    let manifest = Manifest {
        format: head.format.clone(),
        schema_version: head.schema_version,
        generator: head.generator.clone(),
        recipe_hash: head.recipe.hash.clone(),
        seed: 0,
        shard: 0,
        first: 0,
        count: 1,
        files: Vec::new(),
        samples: vec![sample],
    };
    fs::create_dir_all(place.path().join("shards")).expect("a folder");
    fs::write(place.path().join(manifest_path(0)), serde_json::to_vec(&manifest).expect("plain data"))
        .expect("written");
    assert!(folder.complete(&|| ()).expect("documents are written"));
    let text = |name: &str| fs::read_to_string(place.path().join(name)).expect("it is there");
    (objects_in_words(head), text(CARD), serde_json::from_str(&text(CROISSANT)).expect("JSON"))
}

/// What the scans of a built-in recipe are of.
fn objects(name: &str) -> &'static str {
    match name {
        "species/oak" | "species/beech" | "species/birch" => "boards of hardwood",
        "species/pine" | "species/larch" => "boards of softwood",
        "wood-stem" | "wood-log" => "boards of wood sawn out of simulated stems",
        "wood-measured" => "boards of wood sawn out of a measured log",
        "wood-picture" => "boards of wood cut out of a picture",
        "wood-slices" => "boards of wood cut out of a stack of slices",
        name if name.contains("blister") => "blister packs",
        name if name.contains("sawtooth") => "a saw-tooth for calibration",
        name if name.contains("mesh") => "a part from a file of triangles",
        _ => "boards of wood",
    }
}

#[test]
fn every_recipe_is_called_what_it_is() {
    for built_in in Recipe::embedded() {
        let recipe = Recipe::load(built_in.name).expect("it is built in");
        let (words, card, croissant) = said(&recipe);
        assert_eq!(words, objects(built_in.name), "{}", built_in.name);
        let description = croissant["description"].as_str().expect("a text");
        // Names end what they tell of: "boards of wood" is not the beginning of another kind.
        let scans = format!("laser-triangulation scans of {words} with pixel-exact labels");
        assert!(description.contains(&scans) && card.contains(description), "{}: {description}", built_in.name);
        let text = format!("{card}{croissant}").to_lowercase();
        // The recipe stands on the card too, with its own words.
        let text = text.replace(&recipe.text().trim_end().to_lowercase(), "");
        for wood in ["softwood", "hardwood"] {
            assert_eq!(text.contains(wood), words.contains(wood), "{wood} of {}", built_in.name);
        }
        let is_metal = ["sawtooth", "thesis/sawtooth"].contains(&built_in.name);
        let is_by_kernel = text.contains("| transport | kernel");
        for (what, holds) in [
            ("subsurface-scattering\n", !is_metal),
            ("\"subsurface scattering\"", !is_metal),
            ("light transport in the object", !is_metal),
            ("light spreads below the surface", !is_metal),
            ("the model of light takes film", words == "blister packs" && is_by_kernel),
        ] {
            assert_eq!(text.contains(what), holds, "`{what}` of {}", built_in.name);
        }
    }
}

/// What one class of samples has is not said of all; what a key takes away is not listed.
#[test]
fn classes_and_keys_change_the_words() {
    let of = |keys: &str| {
        let text = format!("extends: species/oak\nname: other\n{keys}\n");
        said(&Recipe::parse("oak.yaml", &text).unwrap_or_else(|error| panic!("{error}")))
    };
    let speckle = "patterns of speckle repeat";
    let (words, card, _) = of("");
    assert!(words == "boards of hardwood" && card.contains(speckle), "{words}");
    let (words, ..) = of("classes: {flat_sawn: {anatomy: {pores_per_mm2: 0}}}");
    assert_eq!(words, "boards of wood");
    let (_, card, _) = of("speckle: {strength: 0}");
    assert!(!card.contains(speckle), "{card}");
}
