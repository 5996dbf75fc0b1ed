//! The data dictionary on disk says what the declarations say; `BLESS=1` rewrites it.

#[test]
fn readme_is_the_dictionary() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
    let expected = output_schema::dictionary::dictionary();
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(path, &expected).expect("README.md can be written");
    }
    let found = std::fs::read_to_string(path).unwrap_or_default();
    assert!(found == expected, "output_schema/README.md is out of date: run BLESS=1 cargo test -p output_schema");
}

#[test]
fn json_schema_lists_every_key_of_the_documents() {
    use output_schema::*;
    let schema = json_schema();
    let head = DatasetHead {
        format: FORMAT.into(),
        schema_version: SCHEMA_VERSION,
        generator: Generator { name: "gen".into(), version: "0".into() },
        target: "t".into(),
        recipe: RecipeHead {
            name: "r".into(),
            text: String::new(),
            hash: String::new(),
            canonical: serde_json::json!({}),
        },
        assets: vec![AssetHead {
            key: "mesh.file".into(),
            name: "a.obj".into(),
            path: file::asset_path(&"0".repeat(64), "a.obj"),
            bytes: 1,
            sha256: "0".repeat(64),
        }],
        seed: 1,
        samples: 5,
        samples_per_shard: 2,
        shards: 3,
        classes: vec![],
        subject: "wood".into(),
        pixel_classes: vec![],
        label_values: vec![],
        splits: SplitShares { train: 1.0, validation: 0.0, test: 0.0 },
        images: Images {
            cols: 1,
            rows: 1,
            png: vec![],
            exr: vec![],
            range: "calibrated".into(),
            bits: 8,
            truth_maps: false,
            stack_every: None,
            sensor_cols: 1,
            sensor_rows: 1,
        },
        parameters: vec![],
        physics: vec![],
        warnings: vec![RigWarning { code: "saturated".into(), what: "w".into(), remedy: "r".into() }],
    };
    assert_eq!(head.span(2), (4, 1));
    assert_eq!(head.span(3), (6, 0));
    let manifest = Manifest {
        format: FORMAT.into(),
        schema_version: SCHEMA_VERSION,
        generator: head.generator.clone(),
        recipe_hash: String::new(),
        seed: 1,
        shard: 0,
        first: 0,
        count: 0,
        files: vec![],
        samples: vec![],
    };
    for (name, document) in [("dataset", serde_json::to_value(&head)), ("manifest", serde_json::to_value(&manifest))] {
        let document = document.expect("plain structs serialise");
        let keys: Vec<&String> = document.as_object().expect("an object").keys().collect();
        let declared: Vec<&String> =
            schema["$defs"][name]["properties"].as_object().expect("properties").keys().collect();
        assert_eq!(keys, declared, "{name}");
    }
    let images = serde_json::to_value(&head.images).expect("plain structs serialise");
    let keys: Vec<&String> = images.as_object().expect("an object").keys().collect();
    let declared = &schema["$defs"]["dataset"]["properties"]["images"]["properties"];
    assert_eq!(keys, declared.as_object().expect("properties").keys().collect::<Vec<_>>());
}

/// A copy's path leads nowhere else, whatever a document says.
#[test]
fn copies_lie_in_the_folder() {
    use output_schema::AssetHead;
    let sum = "a1".repeat(32);
    let head = |path: &str, sha256: &str| AssetHead {
        key: "mesh.file".into(),
        name: "a.obj".into(),
        path: path.into(),
        bytes: 1,
        sha256: sha256.into(),
    };
    assert!(head(&output_schema::file::asset_path(&sum, "a.obj"), &sum).is_in_folder());
    for path in ["a.obj", "/etc/passwd", "assets/a.obj", "assets/../a.obj"] {
        assert!(!head(path, &sum).is_in_folder(), "{path}");
    }
    assert!(!head(&format!("assets/{sum}-../../a"), &sum).is_in_folder());
    assert!(!head("assets/..-a", "..").is_in_folder());
}
