//! Everything as JSON: a JSON Schema of the two documents, and the tables of columns, channels and files.

use base::Class;
use serde_json::{Map, Value, json};

use crate::channel::{CHANNEL_SHAPE, CHANNELS, RANGE_FORMS};
use crate::column::{Column, ColumnKind};
use crate::dataset::{FORMAT, SCHEMA_VERSION};
use crate::file::FILES;
use crate::row::ROW;
use crate::stack::STACK;
use crate::subject::{SUBJECTS, label_values};

/// JSON Schema (draft 2020-12) of `dataset.json` and of the manifests under `$defs`, and the tables under `tables`.
pub fn json_schema() -> Value {
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": FORMAT,
        "schema_version": SCHEMA_VERSION,
        "$ref": "#/$defs/dataset",
        "$defs": { "dataset": dataset(), "manifest": manifest() },
        "tables": {
            "files": FILES.iter().map(|f| json!({ "path": f.path, "when": f.when, "doc": f.doc })).collect::<Vec<_>>(),
            "pixel_classes": Class::ALL.map(Class::name).as_slice(),
            "subjects": SUBJECTS.map(|s| json!({ "name": s, "label_values": label_values(s, SCHEMA_VERSION[1]) })),
            "row": columns(&ROW),
            "stack": columns(&STACK),
            "range_forms": RANGE_FORMS.map(|f| json!({ "name": f.name, "unit": f.unit, "range": f.range,
                "doc": f.doc })),
            "exr": CHANNELS.iter().map(|c| json!({
                "name": c.name, "type": c.samples.name(), "shape": CHANNEL_SHAPE, "unit": c.unit, "range": c.range,
                    "missing": c.missing,
                "doc": c.doc, "asked_by": c.asked_by, "subject": c.subject,
            })).collect::<Vec<_>>(),
        },
    })
}

fn columns(table: &[Column]) -> Vec<Value> {
    let entry = |c: &Column| {
        let mut entry = json!({
            "name": c.name, "type": c.kind.name(), "shape": c.kind.shape(), "unit": c.unit,
            "range": c.range.to_string(), "missing": c.missing, "doc": c.doc,
        });
        if let ColumnKind::List(fields) | ColumnKind::Struct(fields) = c.kind {
            entry["fields"] = Value::from(columns(fields));
        }
        entry
    };
    table.iter().map(entry).collect()
}

/// An object that needs every one of its keys.
fn object(properties: Vec<(&str, Value)>) -> Value {
    let required: Vec<&str> = properties.iter().map(|(key, _)| *key).collect();
    let properties: Map<String, Value> =
        properties.iter().map(|(key, value)| (key.to_string(), value.clone())).collect();
    json!({ "type": "object", "required": required, "properties": properties })
}

fn text(doc: &str) -> Value {
    json!({ "type": "string", "description": doc })
}

fn whole(doc: &str) -> Value {
    json!({ "type": "integer", "minimum": 0, "description": doc })
}

fn list(items: Value, doc: &str) -> Value {
    json!({ "type": "array", "items": items, "description": doc })
}

fn sha256(doc: &str) -> Value {
    json!({ "type": "string", "pattern": "^[0-9a-f]{64}$", "description": doc })
}

fn version() -> Value {
    json!({ "type": "array", "items": { "type": "integer", "minimum": 0 }, "minItems": 2, "maxItems": 2 })
}

fn generator() -> Value {
    object(vec![("name", text("Program.")), ("version", text("Its version; another may give other numbers."))])
}

fn dataset() -> Value {
    let number = object(vec![
        ("group", text("Struct column; empty for `physics`.")),
        ("key", text("Field in the struct.")),
        ("unit", text("Unit.")),
        ("doc", text("Meaning.")),
    ]);
    let share = json!({ "type": "number", "minimum": 0, "maximum": 1 });
    let asset = object(vec![
        ("key", text("Key of the recipe that names it.")),
        ("name", text("Its name when it was read, without folders.")),
        ("path", text("Path of the copy, relative to the folder.")),
        ("bytes", whole("Size [bytes].")),
        ("sha256", sha256("Of its content.")),
    ]);
    let warning = object(vec![
        ("code", text("What samples fall short in.")),
        ("what", text("What was found.")),
        ("remedy", text("What to do.")),
    ]);
    let mut document = object(vec![
        ("format", json!({ "const": FORMAT })),
        ("schema_version", version()),
        ("generator", generator()),
        ("target", text("Target triple of the program; bytes are promised for one target.")),
        (
            "recipe",
            object(vec![
                ("name", text("Name, for titles.")),
                ("text", text("The file as the user wrote it.")),
                ("hash", text("SHA-256 of the canonical form, hexadecimal.")),
                ("canonical", json!({ "description": "Every key with its value, defaults filled in." })),
            ]),
        ),
        ("assets", list(asset, "Files that the recipe names, by key; left out where there are none.")),
        ("seed", whole("Seed.")),
        ("samples", whole("Samples (n).")),
        ("samples_per_shard", json!({ "type": "integer", "minimum": 1, "description": "Samples in a shard." })),
        ("shards", whole("Shards.")),
        ("classes", list(text("Name."), "Classes of the recipe; the position is the value of `class`.")),
        ("subject", json!({ "enum": SUBJECTS, "description": "What the objects are." })),
        ("pixel_classes", list(text("Name."), "Pixel classes; the position is the value in label images.")),
        ("label_values", list(whole("Value."), "Values that label images of the subject can have.")),
        ("splits", object(vec![("train", share.clone()), ("validation", share.clone()), ("test", share)])),
        (
            "images",
            object(vec![
                ("cols", whole("Columns of every image [px].")),
                ("rows", whole("Rows of every image [px].")),
                ("png", list(text("Name."), "Images in the Parquet rows.")),
                ("exr", list(text("Name."), "Images in the EXR files.")),
                ("range", json!({ "enum": RANGE_FORMS.map(|form| form.name), "description": "What Range is." })),
                ("truth_maps", json!({ "type": "boolean", "description": "Whether the EXR files hold truth maps." })),
                (
                    "stack_every",
                    json!({ "type": ["integer", "null"], "minimum": 1, "description": "A sensor frame is kept every \
                        so many profiles." }),
                ),
                ("sensor_cols", whole("Columns of a sensor frame [px].")),
                ("sensor_rows", whole("Rows of a sensor frame [px].")),
                ("bits", json!({ "enum": [8, 10, 12], "description": "Bits of a digital number." })),
            ]),
        ),
        ("parameters", list(number.clone(), "Drawn numbers in the order of columns.")),
        ("physics", list(number, "Derived numbers in the order of columns.")),
        ("warnings", list(warning, "What the check of the rig warns of; left out where that is nothing.")),
    ]);
    // Left out where there are none.
    if let Some(required) = document["required"].as_array_mut() {
        required.retain(|key| key != "assets" && key != "warnings");
    }
    document
}

fn manifest() -> Value {
    let file = object(vec![
        ("path", text("Path relative to the folder.")),
        ("bytes", whole("Size [bytes].")),
        ("sha256", sha256("Of the file.")),
        ("rows", json!({ "type": ["integer", "null"], "description": "Rows of a Parquet file." })),
    ]);
    let sample = object(vec![
        ("index", whole("Number in the dataset.")),
        ("id", text("Name.")),
        ("split", json!({ "enum": ["train", "validation", "test"] })),
        ("class", text("Name of the recipe's class.")),
        ("sha256", sha256("Over the sample's encoded maps.")),
    ]);
    object(vec![
        ("format", json!({ "const": FORMAT })),
        ("schema_version", version()),
        ("generator", generator()),
        ("recipe_hash", text("SHA-256 of the recipe's canonical form.")),
        ("seed", whole("Seed.")),
        ("shard", whole("Number of the shard.")),
        ("first", whole("Index of its first sample.")),
        ("count", whole("Samples.")),
        ("files", list(file, "Every file, by path.")),
        ("samples", list(sample, "Every sample, by index.")),
    ])
}
