//! `croissant.json`: the dataset in the Croissant 1.1 vocabulary of MLCommons, for programs that find and load
//! datasets.
//!
//! - Files are a `FileSet` of each kind: one pattern for all shards,
//!   so the document does not grow with the number of samples. Their checksums are in the manifests; Croissant asks for
//!   one of each single file, which `dataset.json` is and each file that the recipe names.
//! - `samples` has a field for every column. Its field `split` is told by the file's name and refers to the record set
//!   `splits`: with a filter on it mlcroissant reads file by file. `class` names `classes` in words alone, since a
//!   second reference would make mlcroissant hold every row at once.
//! - `datePublished` is asked for, but no clock goes into files: it is the date of the program's version.
//! - `url` is left out: a folder has none until somebody publishes it.

use std::collections::BTreeMap;

use output_schema::file::{DATASET, patterns};
use output_schema::row::ROW;
use output_schema::stack::STACK;
use output_schema::{AssetHead, Column, ColumnKind, DatasetHead, NumberColumn};
use serde_json::{Map, Value, json};

use super::atomic_file::sha256;
use super::limits::limits;
use super::reader::to_document;
use super::recipe_words::is_entered_by_light;
use super::{GENERATOR_DATE, card};
use optical_bench::split::Split;

/// `croissant.json` of a dataset whose `present` splits have files; `document` is `dataset.json` as it is on disk.
pub(super) fn croissant(head: &DatasetHead, present: &[Split], document: &[u8]) -> Vec<u8> {
    let mut sets = vec![
        enumeration("splits", "cr:Split", "Parts of the dataset.", present.iter().map(|split| json!(split.name()))),
        numbered("classes", "Classes of the recipe.", head.classes.iter().map(String::as_str).enumerate()),
        numbered("pixel_classes", "What a pixel can show: values of label images.", head.shown_classes()),
        samples(head),
    ];
    if head.images.stack_every.is_some() {
        sets.push(frames(head));
    }
    let hash: String = head.recipe.hash.chars().take(12).collect();
    to_document(&json!({
        "@context": context(),
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.1",
        "name": head.recipe.name,
        "description": card::description(head),
        "license": "https://creativecommons.org/publicdomain/zero/1.0/",
        "citeAs": card::citation(head),
        "creator": { "@type": "sc:Organization", "name": "Sheetlight" },
        "version": format!("{}+recipe.{hash}.seed.{}.n.{}", head.generator.version, head.seed, head.samples),
        "datePublished": GENERATOR_DATE,
        "keywords": keywords(head),
        "rai:dataCollection": format!(
            "Simulated: {}, exposure of every profile on a sensor, extraction of the maps from the frames.",
            if is_entered_by_light(head) { "light transport in the object" } else { "reflection of light at the \
             object" }
        ),
        "rai:dataAnnotationProtocol": "Labels follow from the simulated object without errors of measurement; nobody \
            drew them.",
        "rai:dataLimitations": limits(head),
        "distribution": distribution(head, present, document),
        "recordSet": sets,
    }))
}

/// The context that the specification gives.
fn context() -> Value {
    let mut context = Map::new();
    context.insert("@language".into(), json!("en"));
    context.insert("@vocab".into(), json!("https://schema.org/"));
    let terms = [
        "arrayShape",
        "citeAs",
        "column",
        "containedIn",
        "equivalentProperty",
        "extract",
        "field",
        "fileProperty",
        "fileObject",
        "fileSet",
        "format",
        "includes",
        "isArray",
        "isLiveDataset",
        "jsonPath",
        "key",
        "md5",
        "parentField",
        "path",
        "recordSet",
        "references",
        "regex",
        "repeated",
        "replace",
        "samplingRate",
        "separator",
        "source",
        "subField",
        "transform",
    ];
    context.extend(terms.map(|term| (term.to_string(), json!(format!("cr:{term}")))));
    for (term, meaning) in [
        ("conformsTo", json!("dct:conformsTo")),
        ("cr", json!("http://mlcommons.org/croissant/")),
        ("rai", json!("http://mlcommons.org/croissant/RAI/")),
        ("dct", json!("http://purl.org/dc/terms/")),
        ("sc", json!("https://schema.org/")),
        ("data", json!({ "@id": "cr:data", "@type": "@json" })),
        ("examples", json!({ "@id": "cr:examples", "@type": "@json" })),
        ("dataType", json!({ "@id": "cr:dataType", "@type": "@vocab" })),
        ("description", json!({ "@container": "@language" })),
        ("name", json!({ "@container": "@language" })),
    ] {
        context.insert(term.into(), meaning);
    }
    Value::Object(context)
}

fn keywords(head: &DatasetHead) -> Vec<&str> {
    let labels = card::holds(head, "label") || card::holds(head, "instance");
    let segmentation = labels.then_some("segmentation");
    let scattering = is_entered_by_light(head).then_some("subsurface scattering");
    let first = ["synthetic", "laser triangulation"].into_iter().chain(scattering);
    first.chain(segmentation).chain([head.subject.as_str()]).collect()
}

fn distribution(head: &DatasetHead, present: &[Split], document: &[u8]) -> Vec<Value> {
    let set = |id: &str, format: &str, includes: Vec<String>, doc: &str| {
        json!({
            "@type": "cr:FileSet", "@id": id, "name": id, "description": doc, "encodingFormat": format,
            "includes": includes,
        })
    };
    let file = |path: &str, doc: &str, bytes: u64, format: &str, sum: &str| {
        json!({
            "@type": "cr:FileObject", "@id": path, "name": path, "description": doc, "contentUrl": path,
            "contentSize": format!("{bytes} B"), "encodingFormat": format, "sha256": sum,
        })
    };
    let doc = "What is known before the first sample: recipe, seed, sizes, columns of drawn numbers.";
    let mut files = vec![file(DATASET, doc, document.len() as u64, "application/json", &sha256(document))];
    let rows = |split: &Split| patterns("data", &format!("{}-*.parquet", split.name()), head.shards);
    let tables = present.iter().flat_map(rows).collect();
    files.push(set("tables", "application/x-parquet", tables, "One row for each sample: numbers, objects and images."));
    if head.has_exr() {
        let doc = "Maps in physical units, one file for each sample.";
        files.push(set("exr", "image/x-exr", patterns("exr", "*/*.exr", head.shards), doc));
    }
    if head.images.stack_every.is_some() {
        let doc = "One row for each kept sensor frame.";
        files.push(set("stacks", "application/x-parquet", patterns("stacks", "*.parquet", head.shards), doc));
    }
    // Two keys may name one file.
    let assets: BTreeMap<&str, &AssetHead> = head.assets.iter().map(|asset| (asset.path.as_str(), asset)).collect();
    let doc = "A copy of a file that the recipe names; it keeps the licence that it came with.";
    let copy = |asset: &AssetHead| file(&asset.path, doc, asset.bytes, "application/octet-stream", &asset.sha256);
    files.extend(assets.into_values().map(copy));
    let doc = "Manifests: every file with its size and SHA-256.";
    files.push(set("manifests", "application/json", patterns("shards", "*.json", head.shards), doc));
    files
}

fn enumeration(id: &str, kind: &str, doc: &str, names: impl Iterator<Item = Value>) -> Value {
    let name = format!("{id}/name");
    json!({
        "@type": "cr:RecordSet", "@id": id, "name": id, "description": doc, "dataType": kind, "key": { "@id": name },
        "field": [{ "@type": "cr:Field", "@id": name, "name": "name", "dataType": "sc:Text" }],
        "data": names.map(|value| json!({ name.as_str(): value })).collect::<Vec<_>>(),
    })
}

fn numbered<'a>(id: &str, doc: &str, names: impl Iterator<Item = (usize, &'a str)>) -> Value {
    let (number, name) = (format!("{id}/number"), format!("{id}/name"));
    json!({
        "@type": "cr:RecordSet", "@id": id, "name": id, "description": doc, "dataType": "sc:Enumeration",
        "key": { "@id": number },
        "field": [
            { "@type": "cr:Field", "@id": number, "name": "number", "dataType": "cr:Int64" },
            { "@type": "cr:Field", "@id": name, "name": "name", "dataType": ["sc:Text", "sc:name"] },
        ],
        "data": names.map(|(at, word)| json!({ number.as_str(): at, name.as_str(): word })).collect::<Vec<_>>(),
    })
}

/// One record for each sample.
fn samples(head: &DatasetHead) -> Value {
    let numbers = |group: &str, numbers: Vec<&NumberColumn>, column: &Column| {
        let part = |n: &NumberColumn| {
            let (id, doc) = (format!("samples/{group}/{}", n.key), words(&n.doc, &n.unit, "", column.missing));
            leaf(&id, &doc, json!("cr:Float64"), from("tables", group, Some(&n.key)))
        };
        parent(&format!("samples/{group}"), column.doc, numbers.into_iter().map(part).collect(), false)
    };
    let fields = ROW.iter().filter(|column| head.has(column)).flat_map(|column| {
        let id = format!("samples/{}", column.name);
        let of = |key: &str| from("tables", column.name, Some(key));
        match column.kind {
            _ if column.name == "split" => vec![split(&id, column)],
            ColumnKind::Parameters => {
                head.groups().into_iter().map(|(group, of_group)| numbers(group, of_group, column)).collect()
            }
            ColumnKind::Physics => vec![numbers(column.name, head.physics.iter().collect(), column)],
            ColumnKind::PixelCounts => {
                let parts = head.shown_classes().map(|(_, name)| {
                    leaf(&format!("{id}/{name}"), &format!("Pixels that show {name}."), json!("cr:Int64"), of(name))
                });
                vec![parent(&id, column.doc, parts.collect(), false)]
            }
            ColumnKind::Struct(columns) | ColumnKind::List(columns) => {
                let parts = columns.iter().map(|c| declared(&format!("{id}/{}", c.name), c, of(c.name)));
                vec![parent(&id, column.doc, parts.collect(), matches!(column.kind, ColumnKind::List(_)))]
            }
            ColumnKind::Image(_) => vec![declared(&id, column, of("bytes"))],
            _ => vec![declared(&id, column, from("tables", column.name, None))],
        }
    });
    json!({
        "@type": "cr:RecordSet", "@id": "samples", "name": "samples",
        "description": "One record for each sample. With the filter {\"samples/split\": \"train\"} mlcroissant reads \
            file by file; without one it holds every row at once.",
        "key": { "@id": "samples/id" }, "field": fields.collect::<Vec<_>>(),
    })
}

/// One record for each kept sensor frame.
fn frames(head: &DatasetHead) -> Value {
    let field = |column: &Column| {
        let mut field = declared(&format!("frames/{}", column.name), column, from("stacks", column.name, None));
        if column.kind == ColumnKind::Tensor {
            field["dataType"] = json!(if head.images.depth() > 8 { "cr:UInt16" } else { "cr:UInt8" });
            field["isArray"] = json!(true);
            field["arrayShape"] = json!(format!("{},{}", head.images.sensor_rows, head.images.sensor_cols));
        }
        field
    };
    json!({
        "@type": "cr:RecordSet", "@id": "frames", "name": "frames", "description": "One record for each kept sensor \
            frame.",
        "field": STACK.iter().map(field).collect::<Vec<_>>(),
    })
}

/// The split, told by the name of the file: so that a filter on it opens the files of that split alone. mlcroissant
/// asks the pattern a second time, of what it found, where it joins.
fn split(id: &str, column: &Column) -> Value {
    let source = json!({
        "fileSet": { "@id": "tables" }, "extract": { "fileProperty": "fullpath" },
        "transform": { "regex": "^(?:data/)?(?:[0-9]+/)?(train|validation|test)(?:-.+)?$" },
    });
    let mut field = leaf(id, &words_of(column), json!("sc:Text"), source);
    field["references"] = json!({ "field": { "@id": "splits/name" } });
    field
}

/// One declared column.
fn declared(id: &str, column: &Column, source: Value) -> Value {
    let kind = match column.kind {
        ColumnKind::Text | ColumnKind::PixelClassNames => json!("sc:Text"),
        ColumnKind::Int32 | ColumnKind::Box4 => json!("cr:Int32"),
        ColumnKind::UInt64 => json!("cr:UInt64"),
        ColumnKind::Float64 | ColumnKind::RangeNumber => json!("cr:Float64"),
        ColumnKind::SampleClass | ColumnKind::PixelClass => json!(["cr:Int64", "cr:Label"]),
        ColumnKind::Image(_) if column.name == "label" => json!(["sc:ImageObject", "cr:SegmentationMask"]),
        ColumnKind::Image(_) => json!("sc:ImageObject"),
        _ => json!("cr:Int64"),
    };
    let mut field = leaf(id, &words_of(column), kind, source);
    let length = match column.kind {
        ColumnKind::Box4 => Some("4"),
        ColumnKind::PixelClassNames => Some("-1"),
        _ => None,
    };
    if let Some(length) = length {
        field["isArray"] = json!(true);
        field["arrayShape"] = json!(length);
    }
    field
}

/// A column of a table, or one key of a column of structs.
fn from(set: &str, column: &str, key: Option<&str>) -> Value {
    let mut source = json!({ "fileSet": { "@id": set }, "extract": { "column": column } });
    if let Some(key) = key {
        source["transform"] = json!({ "jsonPath": key });
    }
    source
}

fn leaf(id: &str, doc: &str, kind: Value, source: Value) -> Value {
    let name = id.rsplit('/').next().unwrap_or(id);
    json!({ "@type": "cr:Field", "@id": id, "name": name, "description": doc, "dataType": kind, "source": source })
}

fn parent(id: &str, doc: &str, parts: Vec<Value>, list: bool) -> Value {
    let name = id.rsplit('/').next().unwrap_or(id);
    let mut field = json!({ "@type": "cr:Field", "@id": id, "name": name, "description": doc });
    if list {
        field["isArray"] = json!(true);
        field["arrayShape"] = json!("-1");
    }
    field["subField"] = json!(parts);
    field
}

/// What a declared column is, in one line.
fn words_of(column: &Column) -> String {
    words(column.doc, column.unit, &column.range.to_string(), column.missing)
}

/// Meaning, unit, values and missing rule in one line.
fn words(doc: &str, unit: &str, range: &str, missing: &str) -> String {
    let mut words = doc.to_string();
    for (name, value) in [("Unit", unit), ("Values", range), ("Missing", missing)] {
        if !value.is_empty() {
            words += &format!(" {name}: {value}.");
        }
    }
    words
}
