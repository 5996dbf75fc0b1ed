//! The record sets of `croissant.json` that have a field for every column: `samples` and `frames`.

use output_schema::row::ROW;
use output_schema::stack::STACK;
use output_schema::{Column, DatasetHead, Kind, NumberColumn};
use serde_json::{Value, json};

/// One record for each sample.
pub(super) fn samples(head: &DatasetHead) -> Value {
    let mut fields = Vec::new();
    for column in ROW.iter().filter(|column| head.has(column)) {
        let id = format!("samples/{}", column.name);
        let of = |key: &str| from("tables", column.name, Some(key));
        fields.extend(match column.kind {
            _ if column.name == "split" => vec![split(&id, column)],
            Kind::Parameters => {
                let group = |(name, numbers): (&str, Vec<&NumberColumn>)| {
                    let id = format!("samples/{name}");
                    let parts = numbers.iter().map(|n| {
                        leaf(
                            &format!("{id}/{}", n.key),
                            &words(&n.doc, &n.unit, "", "never"),
                            json!("cr:Float64"),
                            from("tables", name, Some(&n.key)),
                        )
                    });
                    parent(&id, column.doc, parts.collect(), false)
                };
                head.groups().into_iter().map(group).collect()
            }
            Kind::Physics => {
                let parts = head.physics.iter().map(|n| {
                    leaf(
                        &format!("{id}/{}", n.key),
                        &words(&n.doc, &n.unit, "", column.missing),
                        json!("cr:Float64"),
                        of(&n.key),
                    )
                });
                vec![parent(&id, column.doc, parts.collect(), false)]
            }
            Kind::PixelCounts => {
                let parts = head.shown_classes().map(|(_, name)| {
                    leaf(&format!("{id}/{name}"), &format!("Pixels that show {name}."), json!("cr:Int64"), of(name))
                });
                vec![parent(&id, column.doc, parts.collect(), false)]
            }
            Kind::Struct(columns) | Kind::List(columns) => {
                let parts = columns.iter().map(|c| declared(&format!("{id}/{}", c.name), c, of(c.name)));
                vec![parent(&id, column.doc, parts.collect(), matches!(column.kind, Kind::List(_)))]
            }
            Kind::Image(_) => vec![declared(&id, column, of("bytes"))],
            _ => vec![declared(&id, column, from("tables", column.name, None))],
        });
    }
    json!({
        "@type": "cr:RecordSet", "@id": "samples", "name": "samples",
        "description": "One record for each sample. With the filter {\"samples/split\": \"train\"} mlcroissant reads file by file; without one it holds every row at once.",
        "key": { "@id": "samples/id" }, "field": fields,
    })
}

/// One record for each kept sensor frame.
pub(super) fn frames(head: &DatasetHead) -> Value {
    let field = |column: &Column| {
        let mut field = declared(&format!("frames/{}", column.name), column, from("stacks", column.name, None));
        if column.kind == Kind::Tensor {
            field["dataType"] = json!(if head.images.depth() > 8 { "cr:UInt16" } else { "cr:UInt8" });
            field["isArray"] = json!(true);
            field["arrayShape"] = json!(format!("{},{}", head.images.sensor_rows, head.images.sensor_cols));
        }
        field
    };
    json!({
        "@type": "cr:RecordSet", "@id": "frames", "name": "frames", "description": "One record for each kept sensor frame.",
        "field": STACK.iter().map(field).collect::<Vec<_>>(),
    })
}

/// The split, told by the name of the file: so that a filter on it opens the files of that split alone. mlcroissant asks
/// the pattern a second time, of what it found, where it joins.
fn split(id: &str, column: &Column) -> Value {
    let source = json!({
        "fileSet": { "@id": "tables" }, "extract": { "fileProperty": "fullpath" },
        "transform": { "regex": "^(?:data/)?(train|validation|test)(?:-.+)?$" },
    });
    let mut field = leaf(id, &words(column.doc, column.unit, column.range, column.missing), json!("sc:Text"), source);
    field["references"] = json!({ "field": { "@id": "splits/name" } });
    field
}

/// One declared column.
fn declared(id: &str, column: &Column, source: Value) -> Value {
    let kind = match column.kind {
        Kind::Text | Kind::PixelClassNames => json!("sc:Text"),
        Kind::Int32 | Kind::Box4 => json!("cr:Int32"),
        Kind::UInt64 => json!("cr:UInt64"),
        Kind::Float64 => json!("cr:Float64"),
        Kind::SampleClass | Kind::PixelClass => json!(["cr:Int64", "cr:Label"]),
        Kind::Image(_) if column.name == "label" => json!(["sc:ImageObject", "cr:SegmentationMask"]),
        Kind::Image(_) => json!("sc:ImageObject"),
        _ => json!("cr:Int64"),
    };
    let mut field = leaf(id, &words(column.doc, column.unit, column.range, column.missing), kind, source);
    let length = match column.kind {
        Kind::Box4 => Some("4"),
        Kind::PixelClassNames => Some("-1"),
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
