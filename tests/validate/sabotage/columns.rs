//! Every declared column is held to something: a change of any value of any of them is found, of what follows from the
//! scene the change of a last bit.

use std::sync::Arc;

use arrow_array::builder::{ListBuilder, StringBuilder};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int32Type, Int64Type, UInt64Type};
use arrow_array::{
    ArrayRef, FixedSizeListArray, Float64Array, Int64Array, ListArray, RecordBatch, StringArray, StructArray,
};
use output_schema::row::{CALIBRATION, OBJECT, ROW};
use output_schema::{Column, ColumnKind, Source};

use super::place::{always, boards, inspect, whole};
use crate::damage::rewrite;

/// Other values of a column, each as near as `follows` promises to tell; of a struct its first field has others.
fn changed(column: &ArrayRef, follows: Source) -> ArrayRef {
    let nearest = |value: f64| if follows == Source::Scene { value.next_up() } else { 1.01 * value + 0.01 };
    if let Some(numbers) = column.as_primitive_opt::<Float64Type>() {
        Arc::new(numbers.iter().map(|value| Some(value.map_or(0.5, nearest))).collect::<Float64Array>())
    } else if let Some(numbers) = column.as_primitive_opt::<Int32Type>() {
        Arc::new(numbers.unary::<_, Int32Type>(|value| value + 1))
    } else if let Some(numbers) = column.as_primitive_opt::<Int64Type>() {
        Arc::new(numbers.iter().map(|value| Some(value.map_or(0, |value| value + 1))).collect::<Int64Array>())
    } else if let Some(numbers) = column.as_primitive_opt::<UInt64Type>() {
        Arc::new(numbers.unary::<_, UInt64Type>(|value| value ^ 1))
    } else if let Some(texts) = column.as_string_opt::<i32>() {
        let texts = texts.iter().map(|text| Some(format!("{}x", text.unwrap_or_default())));
        Arc::new(texts.collect::<StringArray>())
    } else if let Some(list) = column.as_fixed_size_list_opt() {
        let (item, length, values, nulls) = list.clone().into_parts();
        Arc::new(FixedSizeListArray::new(item, length, changed(&values, follows), nulls))
    } else if let Some(list) = column.as_list_opt::<i32>() {
        // Names of classes.
        let mut more = ListBuilder::new(StringBuilder::new());
        for names in list.iter().flatten() {
            names.as_string::<i32>().iter().for_each(|name| more.values().append_option(name));
            more.values().append_value("dirt");
            more.append(true);
        }
        Arc::new(more.finish())
    } else if let Some(group) = column.as_struct_opt() {
        changed_field(column, group.fields()[0].name(), follows)
    } else {
        column.clone()
    }
}

/// The same structs, or lists of such, with one field changed.
fn changed_field(column: &ArrayRef, name: &str, follows: Source) -> ArrayRef {
    if let Some(list) = column.as_list_opt::<i32>() {
        let (item, offsets, values, nulls) = list.clone().into_parts();
        return Arc::new(ListArray::new(item, offsets, changed_field(&values, name, follows), nulls));
    }
    let fields = column.as_struct().fields().iter().zip(column.as_struct().columns());
    let fields = fields.map(|(field, child)| {
        (field.clone(), if field.name() == name { changed(child, follows) } else { child.clone() })
    });
    Arc::new(StructArray::from(fields.collect::<Vec<_>>()))
}

#[test]
#[ignore = "long"]
fn whatever_changes_is_found() {
    let head = &boards().head;
    let has = |column: &&Column| head.has(column);
    let name_of = |column: &Column| match column.kind {
        ColumnKind::Parameters => head.parameters[0].group.clone(),
        ColumnKind::Image(_) => format!("{}.path", column.name),
        _ => column.name.to_owned(),
    };
    let is_single = |column: &&Column| !matches!(column.kind, ColumnKind::List(_));
    let rows = ROW.iter().filter(has).filter(is_single).map(|column| (name_of(column), column.follows));
    let fields = [("calibration", CALIBRATION.as_slice()), ("objects", OBJECT.as_slice())];
    let fields = fields.iter().flat_map(|(of, fields)| fields.iter().map(move |field| (of, field)));
    let fields = fields.map(|(of, field)| (format!("{of}.{}", field.name), field.follows));
    for (path, follows) in rows.chain(fields) {
        let (name, field) = path.split_once('.').map_or((path.as_str(), None), |(name, field)| (name, Some(field)));
        let other = |row: &RecordBatch| {
            let (place, _) = row.schema().column_with_name(name).expect("the column");
            let mut columns = row.columns().to_vec();
            columns[place] = match field {
                Some(field) => changed_field(&columns[place], field, follows),
                None => changed(&columns[place], follows),
            };
            RecordBatch::try_new(row.schema(), columns).expect("of the same type")
        };
        let place = whole();
        rewrite(place.path(), |rows| {
            let others: Vec<RecordBatch> = rows.iter().map(other).collect();
            assert!(others != rows, "`{path}` stays the same");
            others
        });
        assert!(!inspect(place.path()).faults.is_empty(), "a change of `{path}` is not found");
        always(place.path(), &format!("a change of `{path}`"));
    }
}
