//! Columns of a row in plain values: what a row says of its sample, and its images.

use arrow_array::cast::AsArray;
use arrow_array::types::{ArrowPrimitiveType, Float64Type, Int32Type, Int64Type};
use arrow_array::{Array, ArrayRef, RecordBatch, StructArray};
use output_schema::DatasetHead;

use super::Facts;
use crate::check::conditional::deciders;
use crate::check::window::StoredMap;
use crate::dataset::{Grey, read_png};

/// What a row says; `numbers` are paths of drawn and derived numbers.
pub(super) fn facts_of(row: &RecordBatch, head: &DatasetHead, numbers: &[String]) -> Result<Facts, String> {
    let id = column(row, "id")?.as_string_opt::<i32>().map(|c| c.value(0).to_owned()).ok_or("`id` is no text")?;
    if id.contains(['/', '\\']) {
        return Err(format!("`{id}` is no id"));
    }
    let areas = structure(&column(row, "class_area_px")?, "class_area_px")?;
    let mut area = vec![0; head.pixel_classes.len()];
    for (value, name) in head.shown_classes() {
        let counts = areas.column_by_name(name).and_then(|column| column.as_primitive_opt::<Int64Type>());
        let count =
            counts.filter(|counts| !counts.is_empty()).ok_or_else(|| format!("`class_area_px.{name}` is missing"))?;
        area[value] = u64::try_from(count.value(0)).unwrap_or(0);
    }
    let list = column(row, "objects")?;
    let list = list.as_list_opt::<i32>().ok_or("`objects` is no list")?.value(0);
    let number_of = |path: &str| {
        let (group, key) = path.split_once('.').unwrap_or(("physics", path));
        let group = structure(&column(row, group)?, group)?;
        let column = group.column_by_name(key).and_then(|column| column.as_primitive_opt::<Float64Type>());
        let column = column.filter(|column| !column.is_empty()).ok_or_else(|| format!("`{path}` is missing"))?;
        Ok::<_, String>(if column.is_null(0) { f64::NAN } else { column.value(0) })
    };
    // A number of a thing that the sample does not have is drawn all the same, and says nothing.
    let told = |path: &String| {
        let mut of = deciders(path).peekable();
        let nothing = of.peek().is_some() && of.all(|decider| number_of(decider) == Ok(0.0));
        if nothing { Ok(f64::NAN) } else { number_of(path) }
    };
    Ok(Facts {
        index: number::<Int64Type>(row, "index")? as u64,
        id,
        class: usize::try_from(number::<Int64Type>(row, "class")?).map_err(|_| "`class` is negative")?,
        area,
        objects: objects(&list)?,
        numbers: numbers.iter().map(told).collect::<Result<_, _>>()?,
    })
}

/// State and middle of every object that lies in no other.
fn objects(list: &ArrayRef) -> Result<Vec<(usize, [i64; 2])>, String> {
    let fields = structure(list, "objects")?;
    let field = |name: &str| fields.column_by_name(name).cloned().ok_or_else(|| format!("`objects.{name}` is missing"));
    let (state, within, bbox) = (field("state")?, field("within")?, field("bbox")?);
    let state = state.as_primitive_opt::<Int64Type>().ok_or("`objects.state` is not int64")?;
    let within = within.as_primitive_opt::<Int32Type>().ok_or("`objects.within` is not int32")?;
    let bbox = bbox.as_fixed_size_list_opt().ok_or("`objects.bbox` is no fixed list")?;
    let mut found = Vec::new();
    for i in (0..fields.len()).filter(|&i| within.value(i) == 0) {
        let sides = bbox.value(i);
        let sides = sides.as_primitive_opt::<Int32Type>().map(|sides| sides.values().to_vec());
        let Some([left, top, cols, rows]) = sides.as_deref() else { return Err("`objects.bbox` holds no box".into()) };
        let middle = |first: i32, length: i32| i64::from(first) + i64::from(length) / 2;
        let class = usize::try_from(state.value(i)).map_err(|_| "`objects.state` is negative")?;
        found.push((class, [middle(*top, *rows), middle(*left, *cols)]));
    }
    Ok(found)
}

/// The image `name` of a row.
pub(super) fn png_plane(row: &RecordBatch, name: &str) -> Result<StoredMap, String> {
    let bytes = structure(&column(row, name)?, name)?;
    let bytes = bytes.column_by_name("bytes").and_then(|bytes| bytes.as_binary_opt::<i32>());
    let bytes = bytes.filter(|bytes| bytes.is_valid(0)).ok_or_else(|| format!("`{name}` is empty"))?;
    let (_, _, grey) = read_png(bytes.value(0)).map_err(|e| format!("`{name}`: {e}"))?;
    // In millimetres or in sensor rows, whichever the dataset has.
    let float = |what: &str| {
        let unit = if row.column_by_name("range_offset_px").is_some() { "px" } else { "mm" };
        number::<Float64Type>(row, &format!("range_{what}_{unit}"))
    };
    Ok(match grey {
        Grey::Eight(pixels) => StoredMap::Eight(pixels),
        Grey::Sixteen(pixels) if name == "range" => {
            StoredMap::Sixteen { pixels, offset: float("offset")?, scale: float("scale")? }
        }
        Grey::Sixteen(pixels) => StoredMap::Sixteen { pixels, offset: 0.0, scale: 1.0 },
    })
}

fn column(row: &RecordBatch, name: &str) -> Result<ArrayRef, String> {
    let column = row.column_by_name(name).filter(|column| !column.is_empty() && column.is_valid(0));
    column.cloned().ok_or_else(|| format!("`{name}` is missing"))
}

fn structure(column: &ArrayRef, name: &str) -> Result<StructArray, String> {
    column.as_struct_opt().cloned().ok_or_else(|| format!("`{name}` is no struct"))
}

/// A number of a row that is always there.
pub(super) fn number<T: ArrowPrimitiveType>(row: &RecordBatch, name: &str) -> Result<T::Native, String> {
    let column = column(row, name)?;
    column.as_primitive_opt::<T>().map(|c| c.value(0)).ok_or_else(|| format!("`{name}` has another type"))
}
