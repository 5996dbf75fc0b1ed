//! Declarations -> Arrow schemas, with the metadata by which `datasets` decodes images and class labels.
//!
//! `datasets` honours a feature only where the Arrow type is exactly what the feature would make: every field
//! nullable, list children called `item`, images as `struct<bytes: binary, path: string>`.

use std::sync::Arc;

use arrow_schema::{DataType, Field, Fields, Metadata, Schema};
use serde_json::{Map, Value, json};

use crate::column::{Column, ColumnKind, NumberColumn};
use crate::dataset::DatasetHead;
use crate::row::ROW;
use crate::stack::STACK;

/// Schema of `data/*.parquet`.
pub fn row_schema(head: &DatasetHead) -> Schema {
    let mut fields = Vec::new();
    let mut features = Map::new();
    for column in &ROW {
        match column.kind {
            _ if !head.has(column) => {}
            ColumnKind::Parameters => {
                for (group, numbers) in head.groups() {
                    let (kind, feature) = numbers_struct(&numbers);
                    features.insert(group.into(), feature);
                    fields.push(Field::new(group, kind, true).with_metadata([("doc", column.doc)]));
                }
            }
            _ => {
                let (field, feature) = declared(column, head);
                features.insert(column.name.into(), feature);
                fields.push(field);
            }
        }
    }
    let huggingface = json!({ "info": { "features": features } }).to_string();
    let version = head.schema_version.map(|n| n.to_string()).join(".");
    Schema::new_with_metadata(fields, [("huggingface", huggingface), ("sheetlight.schema_version", version)])
}

/// Schema of `stacks/*.parquet`.
pub fn stack_schema(head: &DatasetHead) -> Schema {
    let fields: Vec<Field> = STACK.iter().map(|column| declared(column, head).0).collect();
    let version = head.schema_version.map(|n| n.to_string()).join(".");
    Schema::new_with_metadata(fields, [("sheetlight.schema_version", version)])
}

/// Fields of an image column.
pub fn image_fields() -> Fields {
    Fields::from(vec![Field::new("bytes", DataType::Binary, true), Field::new("path", DataType::Utf8, true)])
}

fn value(dtype: &str) -> Value {
    json!({ "dtype": dtype, "_type": "Value" })
}

fn labels<S: AsRef<str>>(names: &[S]) -> Value {
    json!({ "names": names.iter().map(AsRef::as_ref).collect::<Vec<_>>(), "_type": "ClassLabel" })
}

fn item(kind: DataType) -> Arc<Field> {
    Arc::new(Field::new("item", kind, true))
}

fn numbers_struct(numbers: &[&NumberColumn]) -> (DataType, Value) {
    let field = |n: &&NumberColumn| {
        Field::new(&n.key, DataType::Float64, true).with_metadata([("doc", n.doc.as_str()), ("unit", n.unit.as_str())])
    };
    let feature = numbers.iter().map(|n| (n.key.clone(), value("float64"))).collect();
    (DataType::Struct(numbers.iter().map(field).collect()), Value::Object(feature))
}

fn declared_struct(columns: &[Column], head: &DatasetHead) -> (DataType, Value) {
    let (fields, features): (Vec<Field>, Map<String, Value>) = columns
        .iter()
        .map(|column| {
            let (field, feature) = declared(column, head);
            (field, (column.name.to_string(), feature))
        })
        .unzip();
    (DataType::Struct(fields.into()), Value::Object(features))
}

/// One column as Arrow field and as feature of `datasets`.
fn declared(column: &Column, head: &DatasetHead) -> (Field, Value) {
    let mut metadata = Metadata::from([("doc", column.doc), ("unit", column.unit)]);
    let (kind, feature) = match column.kind {
        ColumnKind::Text => (DataType::Utf8, value("string")),
        ColumnKind::Int32 => (DataType::Int32, value("int32")),
        ColumnKind::Int64 => (DataType::Int64, value("int64")),
        ColumnKind::UInt64 => (DataType::UInt64, value("uint64")),
        ColumnKind::Float64 | ColumnKind::RangeNumber => (DataType::Float64, value("float64")),
        ColumnKind::SampleClass => (DataType::Int64, labels(&head.classes)),
        ColumnKind::PixelClass => (DataType::Int64, labels(&head.pixel_classes)),
        ColumnKind::PixelClassNames => {
            (DataType::List(item(DataType::Utf8)), json!({ "feature": value("string"), "_type": "List" }))
        }
        ColumnKind::Box4 => (
            DataType::FixedSizeList(item(DataType::Int32), 4),
            json!({ "feature": value("int32"), "length": 4, "_type": "List" }),
        ),
        ColumnKind::Image(_) => (DataType::Struct(image_fields()), json!({ "_type": "Image" })),
        ColumnKind::PixelCounts => {
            let names = || head.shown_classes().map(|(_, name)| name);
            let field = |name: &str| Field::new(name, DataType::Int64, true).with_metadata([("unit", "px")]);
            let feature = names().map(|name| (name.to_string(), value("int64"))).collect();
            (DataType::Struct(names().map(field).collect()), Value::Object(feature))
        }
        ColumnKind::Physics => numbers_struct(&head.physics.iter().collect::<Vec<_>>()),
        ColumnKind::Parameters => numbers_struct(&head.parameters.iter().collect::<Vec<_>>()),
        ColumnKind::Struct(columns) => declared_struct(columns, head),
        ColumnKind::List(columns) => {
            let (kind, feature) = declared_struct(columns, head);
            (DataType::List(item(kind)), json!({ "feature": feature, "_type": "List" }))
        }
        ColumnKind::Tensor => {
            let (rows, cols) = (head.images.sensor_rows, head.images.sensor_cols);
            metadata.insert("ARROW:extension:name", "arrow.fixed_shape_tensor");
            metadata.insert("ARROW:extension:metadata", json!({ "shape": [rows, cols] }).to_string());
            // A sensor has far fewer pixels than 2^31; a hostile document gets a type that no file can have.
            let length = i32::try_from(rows.saturating_mul(cols)).unwrap_or(0);
            let (kind, name) =
                if head.images.depth() > 8 { (DataType::UInt16, "uint16") } else { (DataType::UInt8, "uint8") };
            (DataType::FixedSizeList(item(kind), length), value(name))
        }
    };
    (Field::new(column.name, kind, true).with_metadata(metadata), feature)
}
