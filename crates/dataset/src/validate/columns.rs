//! Columns: `RecordBatch` of one row -> plain values; every access checks name, type and presence.

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int32Type, Int64Type, UInt64Type};
use arrow_array::{Array, ArrayRef, RecordBatch, StructArray};
use output_schema::row::{OBJECT, ROW, SHARES};
use output_schema::{Column, ColumnKind, DatasetHead, NumberColumn, Source};

use crate::shares::SampleShares;

/// One object as it is stored.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct StoredObject {
    pub(super) instance: i32,
    pub(super) class: i64,
    pub(super) state: i64,
    pub(super) within: i32,
    pub(super) bbox: [i32; 4],
    pub(super) area_px: i64,
    /// [mm^2].
    pub(super) area_mm2: f64,
    /// Axis against the upper surface; `None` where it has none [deg].
    pub(super) dive_deg: Option<f64>,
    /// What graders call it; `None` where it is no knot.
    pub(super) knot_names: Option<String>,
    /// Whether the dataset's schema has extents, depths and names of objects.
    pub(super) measured: bool,
    /// The other numbers that are there, by name.
    pub(super) numbers: Vec<(&'static str, f64)>,
}

/// One row as it is stored.
#[derive(Debug, Clone)]
pub(super) struct StoredRow {
    pub(super) id: String,
    pub(super) index: i64,
    pub(super) seed: u64,
    pub(super) split: String,
    pub(super) class: i64,
    pub(super) cols: i32,
    pub(super) rows: i32,
    pub(super) row_mm: f64,
    pub(super) col_mm: f64,
    /// In the unit of Range [mm or px].
    pub(super) range_offset: f64,
    pub(super) range_scale: f64,
    pub(super) defects: Vec<String>,
    /// Defects that no pixel shows; `None` where an older schema has them among the others.
    pub(super) unseen: Option<Vec<String>>,
    pub(super) objects: Vec<StoredObject>,
    /// Drawn numbers in the order of the head's parameters.
    pub(super) numbers: Vec<f64>,
    /// Numbers that follow from the scene and are there, without the grid's, by name in the order of columns.
    pub(super) derived: Vec<(String, f64)>,
    /// How much of the sample is of use; `None` where an older schema does not tell.
    pub(super) shares: Option<SampleShares>,
    /// Pixels of each class that labels can show, in their order [px].
    pub(super) class_area_px: Vec<i64>,
    /// PNG files by name, in the order of columns.
    pub(super) png: Vec<(String, Vec<u8>)>,
    /// What these files would be called, by name.
    pub(super) paths: Vec<(String, String)>,
    /// The row as Arrow has it.
    pub(super) batch: RecordBatch,
}

/// The first row of a batch.
///
/// # Errors
/// Which column is missing, empty or of another type.
pub(super) fn stored_row(batch: &RecordBatch, head: &DatasetHead) -> Result<StoredRow, String> {
    let column = |name: &str| present(batch.column_by_name(name), name);
    let has = |name: &str| ROW.iter().any(|column| column.name == name && head.has(column));
    let drawn = |number: &NumberColumn| {
        let group = structure(&column(&number.group)?, &number.group)?;
        float64(&present(group.column_by_name(&number.key), &number.path())?, &number.path())
    };
    let numbers = head.parameters.iter().map(drawn).collect::<Result<_, String>>()?;
    let areas = structure(&column("class_area_px")?, "class_area_px")?;
    let area = |(_, name): (usize, &str)| int64(&present(areas.column_by_name(name), name)?, name);
    let png = |name: &String| {
        let image = structure(&column(name)?, name)?;
        let bytes = present(image.column_by_name("bytes"), name)?;
        let bytes = bytes.as_binary_opt::<i32>().ok_or_else(|| format!("`{name}` has no bytes"))?;
        Ok((name.clone(), bytes.value(0).to_vec()))
    };
    let path = |name: &String| {
        let path = text(&present(structure(&column(name)?, name)?.column_by_name("path"), name)?, name)?;
        Ok((name.clone(), path))
    };
    let ranged = |name: &str| {
        let name = format!("{name}_{}", head.range_unit());
        float64(&column(&name)?, &name)
    };
    let is_derived = |column: &&Column| column.follows == Source::Scene && !GRID.contains(&column.name);
    let derived = ROW.iter().filter(|column| head.has(column)).filter(is_derived);
    let derived = derived.map(|column| numbers_of(batch, column, head)).collect::<Result<Vec<_>, _>>()?.concat();
    let share =
        |name: &str| Ok::<_, String>(known(batch.column_by_name(name), name)?.map_or(f64::NAN, |(_, share)| share));
    let shares = if SHARES.iter().all(|name| has(name)) {
        let [measured, saturated, in_view] = SHARES.map(share);
        // The share of sound matter is in the images alone.
        let sound = f64::NAN;
        Some(SampleShares { measured: measured?, sound, saturated: saturated?, in_view: in_view? })
    } else {
        None
    };
    Ok(StoredRow {
        id: text(&column("id")?, "id")?,
        index: int64(&column("index")?, "index")?,
        seed: column("seed")?.as_primitive_opt::<UInt64Type>().ok_or("`seed` is not uint64")?.value(0),
        split: text(&column("split")?, "split")?,
        class: int64(&column("class")?, "class")?,
        cols: int32(&column("cols")?, "cols")?,
        rows: int32(&column("rows")?, "rows")?,
        row_mm: float64(&column("row_mm")?, "row_mm")?,
        col_mm: float64(&column("col_mm")?, "col_mm")?,
        range_offset: ranged("range_offset")?,
        range_scale: ranged("range_scale")?,
        defects: names(&column("defect_classes")?, "defect_classes")?,
        unseen: has("unseen_classes").then(|| names(&column("unseen_classes")?, "unseen_classes")).transpose()?,
        objects: objects(&column("objects")?, head)?,
        numbers,
        derived,
        shares,
        class_area_px: head.shown_classes().map(area).collect::<Result<_, _>>()?,
        png: head.images.png.iter().map(png).collect::<Result<_, String>>()?,
        paths: head.images.png.iter().map(path).collect::<Result<_, String>>()?,
        batch: batch.clone(),
    })
}

/// Numbers of the grid, which [`StoredRow`] has beside the derived ones, as it has those of Range.
const GRID: [&str; 2] = ["row_mm", "col_mm"];

/// The numbers of a column that are there, by name: its own, or those of its fields.
///
/// # Errors
/// Which one has no column, is empty though it is never missing, or is of another type.
fn numbers_of(batch: &RecordBatch, column: &Column, head: &DatasetHead) -> Result<Vec<(String, f64)>, String> {
    let name = column.name;
    let number = |found: Option<&ArrayRef>, name: &str, is_needed: bool| {
        if is_needed {
            present(found, name).map(drop)?
        }
        known(found, name)
    };
    let fields: Vec<(&str, bool)> = match column.kind {
        ColumnKind::Float64 => {
            return Ok(number(batch.column_by_name(name), name, column.is_never_missing())?.into_iter().collect());
        }
        ColumnKind::Struct(fields) => fields.iter().map(|field| (field.name, field.is_never_missing())).collect(),
        ColumnKind::Physics => head.physics.iter().map(|number| (number.key.as_str(), false)).collect(),
        _ => return Ok(Vec::new()),
    };
    let group = structure(&present(batch.column_by_name(name), name)?, name)?;
    let numbers = fields.into_iter().map(|(key, is_needed)| number(group.column_by_name(key), key, is_needed));
    numbers.filter_map(Result::transpose).collect()
}

/// Whether a number of an object is one that its column may take.
pub(super) fn in_range(name: &str, value: f64) -> bool {
    OBJECT.iter().any(|column| column.name == name && column.range.have(value))
}

fn names(column: &ArrayRef, of: &str) -> Result<Vec<String>, String> {
    let list = column.as_list_opt::<i32>().ok_or_else(|| format!("`{of}` is no list"))?.value(0);
    let names = list.as_string_opt::<i32>().ok_or_else(|| format!("`{of}` does not hold texts"))?;
    names.iter().map(|name| name.map(String::from).ok_or_else(|| format!("`{of}` holds nothing"))).collect()
}

/// The objects of a row.
fn objects(column: &ArrayRef, head: &DatasetHead) -> Result<Vec<StoredObject>, String> {
    let list = column.as_list_opt::<i32>().ok_or("`objects` is no list")?.value(0);
    let fields = structure(&list, "objects")?;
    let child = |name: &str| {
        let child = fields.column_by_name(name).ok_or_else(|| format!("`objects.{name}` is missing"))?;
        if child.null_count() > 0 { Err(format!("`objects.{name}` is empty")) } else { Ok(child.clone()) }
    };
    let short = |name: &str| -> Result<_, String> {
        let numbers = child(name)?.as_primitive_opt::<Int32Type>().cloned();
        numbers.ok_or_else(|| format!("`objects.{name}` is not int32"))
    };
    let long = |name: &str| -> Result<_, String> {
        let numbers = child(name)?.as_primitive_opt::<Int64Type>().cloned();
        numbers.ok_or_else(|| format!("`objects.{name}` is not int64"))
    };
    let (instances, withins) = (short("instance")?, short("within")?);
    let (classes, states, areas) = (long("class")?, long("state")?, long("area_px")?);
    let known = |name: &'static str| -> Result<_, String> {
        let column = fields.column_by_name(name).ok_or_else(|| format!("`objects.{name}` is missing"))?;
        let numbers = column.as_primitive_opt::<Float64Type>().cloned();
        Ok((name, numbers.ok_or_else(|| format!("`objects.{name}` is not float64"))?))
    };
    let declared = || OBJECT.iter().filter(|column| head.has(column));
    let measures = declared().filter(|column| column.kind == ColumnKind::Float64).map(|column| known(column.name));
    let measures = measures.collect::<Result<Vec<_>, String>>()?;
    let measured = declared().any(|column| column.name == "knot_names");
    let names = match fields.column_by_name("knot_names") {
        _ if !measured => None,
        Some(names) => Some(names.as_string_opt::<i32>().ok_or("`objects.knot_names` does not hold texts")?),
        None => return Err("`objects.knot_names` is missing".into()),
    };
    let boxes = child("bbox")?;
    let boxes = boxes.as_fixed_size_list_opt().ok_or("`objects.bbox` is no fixed list")?;
    let object = |i: usize| {
        let sides = boxes.value(i);
        let sides = sides.as_primitive_opt::<Int32Type>().ok_or("`objects.bbox` does not hold int32")?;
        let bbox = sides.values().as_ref().try_into().map_err(|_| "`objects.bbox` does not hold four numbers")?;
        let there = measures.iter().filter(|(_, column)| !column.is_null(i));
        let numbers: Vec<(&str, f64)> = there.map(|(name, column)| (*name, column.value(i))).collect();
        let number = |name: &str| numbers.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
        Ok(StoredObject {
            area_mm2: number("area_mm2").ok_or("`objects.area_mm2` is empty")?,
            dive_deg: number("dive_deg"),
            knot_names: names.filter(|names| !names.is_null(i)).map(|names| names.value(i).to_owned()),
            measured,
            numbers,
            instance: instances.value(i),
            class: classes.value(i),
            state: states.value(i),
            within: withins.value(i),
            bbox,
            area_px: areas.value(i),
        })
    };
    (0..fields.len()).map(object).collect()
}

fn present(column: Option<&ArrayRef>, name: &str) -> Result<ArrayRef, String> {
    let column = column.ok_or_else(|| format!("`{name}` is missing"))?;
    if column.is_empty() || column.is_null(0) { Err(format!("`{name}` is empty")) } else { Ok(column.clone()) }
}

/// A number that may be missing, with its name.
fn known(column: Option<&ArrayRef>, name: &str) -> Result<Option<(String, f64)>, String> {
    let column = column.ok_or_else(|| format!("`{name}` is missing"))?;
    if column.is_null(0) { Ok(None) } else { float64(column, name).map(|number| Some((name.to_owned(), number))) }
}

fn structure(column: &ArrayRef, name: &str) -> Result<StructArray, String> {
    column.as_struct_opt().cloned().ok_or_else(|| format!("`{name}` is no struct"))
}

fn text(column: &ArrayRef, name: &str) -> Result<String, String> {
    column.as_string_opt::<i32>().map(|c| c.value(0).into()).ok_or_else(|| format!("`{name}` is no text"))
}

fn int32(column: &ArrayRef, name: &str) -> Result<i32, String> {
    column.as_primitive_opt::<Int32Type>().map(|c| c.value(0)).ok_or_else(|| format!("`{name}` is not int32"))
}

fn int64(column: &ArrayRef, name: &str) -> Result<i64, String> {
    column.as_primitive_opt::<Int64Type>().map(|c| c.value(0)).ok_or_else(|| format!("`{name}` is not int64"))
}

fn float64(column: &ArrayRef, name: &str) -> Result<f64, String> {
    column.as_primitive_opt::<Float64Type>().map(|c| c.value(0)).ok_or_else(|| format!("`{name}` is not float64"))
}
