//! Sample rows: a sample as it will be on disk, and `Encoded -> RecordBatch`: one row of `data/*.parquet`, and the rows
//! of `stacks/*.parquet`.

use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{UInt8Type, UInt16Type};
use arrow_array::{
    Array, ArrayRef, BinaryArray, FixedSizeListArray, Float64Array, Int32Array, Int64Array, ListArray, RecordBatch,
    StringArray, StructArray, UInt8Array, UInt16Array, UInt64Array,
};
use arrow_buffer::OffsetBuffer;
use arrow_schema::{ArrowError, DataType, Field, Fields, SchemaRef};
use base::Class;
use output_schema::DatasetHead;
use output_schema::row::CALIBRATION;
use sha2::{Digest, Sha256};

use super::atomic_file::hex;
use crate::record::{Object, Record, StackFrame};
use crate::shares::SampleShares;
use optical_bench::settings::{Channel, Readout};
use optical_bench::split::{SampleGroups, Split};

/// One sample, ready to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoded {
    /// Number in the dataset.
    pub index: u64,
    /// UUID.
    pub id: String,
    /// Part of the dataset.
    pub split: Split,
    /// Name of the recipe's class.
    pub class: String,
    /// What it has in common with other samples.
    pub groups: SampleGroups,
    /// Columns of the images [px].
    pub cols: usize,
    /// Rows of the images [px].
    pub rows: usize,
    /// Distance between two rows [mm].
    pub row_mm: f64,
    /// Distance between two columns at the upper surface's height [mm].
    pub col_mm: f64,
    /// Range numbers r > 0 mean `range_offset + r * range_scale`, in the unit of Range [mm or px].
    pub range_offset: f64,
    /// See `range_offset`.
    pub range_scale: f64,
    /// Camera against laser plane, by name.
    pub calibration: Vec<(&'static str, f64)>,
    /// Every drawn number, by its path.
    pub draws: Vec<(String, f64)>,
    /// Derived numbers, by name.
    pub physics: Vec<(&'static str, f64)>,
    /// Classes of the defects of which at least one pixel shows something.
    pub defects: Vec<Class>,
    /// Classes of the other defects.
    pub unseen: Vec<Class>,
    /// Defects, pockets, teeth and parts of which at least one pixel shows something.
    pub objects: Vec<Object>,
    /// Pixels of each class [px].
    pub class_area_px: [u64; Class::ALL.len()],
    /// How much of the sample is of use.
    pub shares: SampleShares,
    /// PNG files in the order of [`Channel`].
    pub png: Vec<(Channel, Vec<u8>)>,
    /// The EXR file, where the recipe asks for one.
    pub exr: Option<Vec<u8>>,
    /// Sensor frames that are kept.
    pub stack: Vec<StackFrame>,
}

impl Encoded {
    /// SHA-256 over the maps as the manifest gives it: name, length and bytes of each PNG, then of the EXR file.
    pub fn sha256(&self) -> String {
        let png = self.png.iter().map(|(channel, bytes)| (channel.name(), bytes.as_slice()));
        maps_sha256(png, self.exr.as_deref())
    }

    /// Size of everything that goes to disk, before the compression of numbers and sensor frames [bytes].
    pub fn bytes(&self) -> u64 {
        let png: usize = self.png.iter().map(|(_, bytes)| bytes.len()).sum();
        let stack: usize = self.stack.iter().map(|frame| 2 * frame.dn.len()).sum();
        (png + self.exr.as_ref().map_or(0, Vec::len) + stack) as u64
    }
}

/// See [`Encoded::sha256`].
pub(crate) fn maps_sha256<'a>(png: impl Iterator<Item = (&'a str, &'a [u8])>, exr: Option<&'a [u8]>) -> String {
    let mut sum = Sha256::new();
    for (name, bytes) in png.chain(exr.map(|bytes| ("exr", bytes))) {
        sum.update(name);
        sum.update((bytes.len() as u64).to_le_bytes());
        sum.update(bytes);
    }
    hex(&sum.finalize())
}

/// The numbers of a record as they will be on disk, without its images and sensor frames; `bits` are those of a digital
/// number.
pub fn encode_numbers(record: &Record, bits: u32) -> Encoded {
    let mut class_area_px = [0; Class::ALL.len()];
    for &class in &record.labels.class {
        class_area_px[usize::from(class)] += 1;
    }
    let most = Readout { bits, ..Readout::PLAIN }.most();
    let shares = SampleShares::of(&record.maps, &record.labels, most, record.object_in_view);
    Encoded {
        index: record.index,
        id: record.id.clone(),
        split: record.split,
        class: record.class.clone(),
        groups: record.groups,
        cols: record.cols,
        rows: record.rows,
        row_mm: record.row_mm,
        col_mm: record.col_mm,
        range_offset: record.range_offset,
        range_scale: record.range_scale,
        calibration: record.calibration.clone(),
        draws: record.draws.clone(),
        physics: record.physics.clone(),
        defects: record.defects.clone(),
        unseen: record.unseen.clone(),
        objects: record.objects.clone(),
        class_area_px,
        shares,
        png: Vec::new(),
        exr: None,
        stack: Vec::new(),
    }
}

/// The one row of a sample, as [`output_schema::arrow::row_schema`] declares it.
///
/// # Errors
/// What differs, where the sample does not fit the head: another class, other drawn or derived numbers, other images.
pub fn row_batch(schema: &SchemaRef, head: &DatasetHead, sample: &Encoded) -> Result<RecordBatch, String> {
    check_numbers("draws", head.parameters.iter().map(|n| n.path()), sample.draws.iter().map(|d| d.0.as_str()))?;
    check_numbers("physics", head.physics.iter().map(|n| n.path()), sample.physics.iter().map(|p| p.0))?;
    let declared = CALIBRATION.iter().map(|column| column.name.to_owned());
    check_numbers("numbers of calibration", declared, sample.calibration.iter().map(|c| c.0))?;
    let size = (sample.cols as u64, sample.rows as u64);
    if size != (head.images.cols, head.images.rows) {
        return Err(format!(
            "its images have {size:?} columns and rows, not {:?}",
            (head.images.cols, head.images.rows)
        ));
    }
    let cells = schema.fields().iter().map(|field| cell(field, head, sample));
    let arrays: Vec<ArrayRef> = cells.collect::<Result<_, _>>()?;
    RecordBatch::try_new(schema.clone(), arrays).map_err(|e| e.to_string())
}

/// What a column of the row says of a sample.
///
/// # Errors
/// What the sample has not, or has otherwise than the head says.
pub(crate) fn cell(field: &Field, head: &DatasetHead, sample: &Encoded) -> Result<ArrayRef, String> {
    Ok(match field.name().as_str() {
        "id" => text(&sample.id),
        "index" => int64(sample.index as i64),
        "seed" => Arc::new(UInt64Array::from(vec![head.seed])),
        "split" => text(sample.split.name()),
        "class" => {
            let number = head.classes.iter().position(|name| *name == sample.class);
            int64(number.ok_or_else(|| format!("its class `{}` is none of {:?}", sample.class, head.classes))? as i64)
        }
        "rig" => int64(sample.groups.rig as i64),
        "log_number" => group_number(sample.groups.log),
        "batch" => group_number(sample.groups.batch),
        "cols" => Arc::new(Int32Array::from(vec![sample.cols as i32])),
        "rows" => Arc::new(Int32Array::from(vec![sample.rows as i32])),
        "row_mm" => number(sample.row_mm),
        "col_mm" => number(sample.col_mm),
        "range_offset_mm" | "range_offset_px" => number(sample.range_offset),
        "range_scale_mm" | "range_scale_px" => number(sample.range_scale),
        "calibration" => structure(field, sample.calibration.iter().map(|c| float64(c.1)).collect())?,
        "physics" => structure(field, sample.physics.iter().map(|p| float64(p.1)).collect())?,
        "objects" => objects(field, &sample.objects).map_err(|e| e.to_string())?,
        "defect_classes" => class_names(field, &sample.defects).map_err(|e| e.to_string())?,
        "unseen_classes" => class_names(field, &sample.unseen).map_err(|e| e.to_string())?,
        "class_area_px" => areas(field, head, sample)?,
        "measured_share" => float64(sample.shares.measured),
        "saturated_share" => float64(sample.shares.saturated),
        "object_in_view" => float64(sample.shares.in_view),
        name => match head.images.png.iter().any(|image| image == name) {
            true => image(field, name, sample)?,
            false => group(field, head, sample)?,
        },
    })
}

/// What a field of `objects` says of each of them.
///
/// # Errors
/// Where there is no such field, or it is of another type.
pub(crate) fn object_cells(field: &Field, objects: &[Object]) -> Result<ArrayRef, ArrowError> {
    let whole = |number: fn(&Object) -> i32| -> ArrayRef {
        Arc::new(objects.iter().map(|o| Some(number(o))).collect::<Int32Array>())
    };
    let long = |number: fn(&Object) -> i64| -> ArrayRef {
        Arc::new(objects.iter().map(|o| Some(number(o))).collect::<Int64Array>())
    };
    let float = |number: fn(&Object) -> f64| -> ArrayRef {
        Arc::new(objects.iter().map(|o| known(number(o))).collect::<Float64Array>())
    };
    Ok(match field.name().as_str() {
        "instance" => whole(|o| o.instance.id.into()),
        "class" => long(|o| o.instance.class as i64),
        "state" => long(|o| o.instance.state as i64),
        "within" => whole(|o| o.instance.within.into()),
        "bbox" => boxes(field, objects)?,
        "area_px" => long(|o| o.area_px as i64),
        "area_mm2" => float(|o| o.area_mm2),
        "x_mm" => float(|o| o.instance.x_mm),
        "y_mm" => float(|o| o.instance.y_mm),
        "diameter_mm" => float(|o| o.instance.diameter_mm),
        "dive_deg" => float(|o| o.instance.dive_deg),
        "death_radius_mm" => float(|o| o.instance.death_radius_mm),
        "severity" => float(|o| o.instance.severity),
        "length_mm" => float(|o| o.extent_mm[0]),
        "width_mm" => float(|o| o.extent_mm[1]),
        "depth_mm" => float(|o| o.instance.depth_mm),
        "knot_names" => {
            Arc::new(objects.iter().map(|o| o.instance.knot.map(|knot| knot.text())).collect::<StringArray>())
        }
        other => return Err(ArrowError::SchemaError(format!("no value for `objects.{other}`"))),
    })
}

/// One row for each sensor frame of a sample; `None` where it has none.
///
/// # Errors
/// What differs, where a frame is not as large as the head says.
pub(super) fn stack_batch(schema: &SchemaRef, sample: &Encoded) -> Result<Option<RecordBatch>, String> {
    let rows = sample.stack.len();
    if rows == 0 {
        return Ok(None);
    }
    let DataType::FixedSizeList(item, length) = schema.field(3).data_type() else {
        return Err("the column `frame` is no tensor".into());
    };
    if let Some(frame) = sample.stack.iter().find(|frame| frame.dn.len() != *length as usize) {
        return Err(format!("the frame of profile {} has {} pixels, not {length}", frame.profile, frame.dn.len()));
    }
    let pixels = sample.stack.iter().flat_map(|frame| frame.dn.iter().copied());
    let pixels: ArrayRef = match item.data_type() {
        DataType::UInt8 => {
            let narrow = |dn: u16| u8::try_from(dn).map_err(|_| format!("a frame holds {dn} DN, beyond 8 bits"));
            Arc::new(UInt8Array::from(pixels.map(narrow).collect::<Result<Vec<u8>, _>>()?))
        }
        _ => Arc::new(UInt16Array::from(pixels.collect::<Vec<u16>>())),
    };
    let frames = FixedSizeListArray::try_new(item.clone(), *length, pixels, None);
    let arrays: Vec<ArrayRef> = vec![
        Arc::new(StringArray::from(vec![sample.id.as_str(); rows])),
        Arc::new(Int64Array::from(vec![sample.index as i64; rows])),
        Arc::new(sample.stack.iter().map(|frame| Some(frame.profile as i32)).collect::<Int32Array>()),
        Arc::new(frames.map_err(|e| e.to_string())?),
    ];
    RecordBatch::try_new(schema.clone(), arrays).map(Some).map_err(|e| e.to_string())
}

/// Digital numbers of a frame of either depth.
pub(crate) fn frame_numbers(pixels: &ArrayRef) -> Option<Vec<u16>> {
    let narrow = pixels.as_primitive_opt::<UInt8Type>().map(|dn| dn.values().iter().map(|&dn| dn.into()).collect());
    narrow.or_else(|| pixels.as_primitive_opt::<UInt16Type>().map(|dn| dn.values().to_vec()))
}

fn check_numbers<'a>(
    what: &str,
    declared: impl Iterator<Item = String>,
    given: impl Iterator<Item = &'a str>,
) -> Result<(), String> {
    let (declared, given): (Vec<String>, Vec<&str>) = (declared.collect(), given.collect());
    if declared == given {
        return Ok(());
    }
    let missing: Vec<&String> = declared.iter().filter(|name| !given.contains(&name.as_str())).collect();
    let extra: Vec<&&str> = given.iter().filter(|name| !declared.iter().any(|d| d == *name)).collect();
    Err(format!(
        "its {what} are not those of dataset.json: missing {missing:?}, unknown {extra:?}, or in another order"
    ))
}

fn known(number: f64) -> Option<f64> {
    (!number.is_nan()).then_some(number)
}

fn text(value: &str) -> ArrayRef {
    Arc::new(StringArray::from(vec![value]))
}

fn int64(value: i64) -> ArrayRef {
    Arc::new(Int64Array::from(vec![value]))
}

fn group_number(value: Option<u64>) -> ArrayRef {
    Arc::new(Int64Array::from(vec![value.map(|number| number as i64)]))
}

fn number(value: f64) -> ArrayRef {
    Arc::new(Float64Array::from(vec![value]))
}

/// A number that may be missing: NaN stands for that.
fn float64(value: f64) -> ArrayRef {
    Arc::new(Float64Array::from(vec![known(value)]))
}

fn fields_of(field: &Field) -> Result<Fields, String> {
    match field.data_type() {
        DataType::Struct(fields) => Ok(fields.clone()),
        other => Err(format!("the column `{}` is {other}, not a struct", field.name())),
    }
}

fn structure(field: &Field, children: Vec<ArrayRef>) -> Result<ArrayRef, String> {
    let fields = fields_of(field)?;
    if fields.is_empty() {
        return Ok(Arc::new(StructArray::new_empty_fields(1, None)));
    }
    StructArray::try_new(fields, children, None).map(|array| Arc::new(array) as ArrayRef).map_err(|e| e.to_string())
}

fn group(field: &Field, head: &DatasetHead, sample: &Encoded) -> Result<ArrayRef, String> {
    // Declarations and draws have the same order, which was checked.
    let numbers = head.parameters.iter().zip(&sample.draws).filter(|(n, _)| n.group == *field.name());
    structure(field, numbers.map(|(_, draw)| float64(draw.1)).collect())
}

/// What the image of a sample would be called if it were a file of its own.
pub(crate) fn image_path(id: &str, name: &str) -> String {
    format!("{id}_{name}.png")
}

fn image(field: &Field, name: &str, sample: &Encoded) -> Result<ArrayRef, String> {
    let png = sample.png.iter().find(|(channel, _)| channel.name() == name);
    let (_, png) = png.ok_or_else(|| format!("its image `{name}` is missing"))?;
    let bytes = Arc::new(BinaryArray::from(vec![png.as_slice()]));
    structure(field, vec![bytes, text(&image_path(&sample.id, name))])
}

/// Pixels of the classes that the head lists; a class that it does not list covers none.
fn areas(field: &Field, head: &DatasetHead, sample: &Encoded) -> Result<ArrayRef, String> {
    let listed: Vec<usize> = head.shown_classes().map(|(value, _)| value).collect();
    let unlisted = (0..sample.class_area_px.len()).find(|v| sample.class_area_px[*v] > 0 && !listed.contains(v));
    if let Some(value) = unlisted {
        return Err(format!("its labels show class {value}, which is none of {listed:?}"));
    }
    structure(field, listed.iter().map(|&value| int64(sample.class_area_px[value] as i64)).collect())
}

fn class_names(field: &Field, classes: &[Class]) -> Result<ArrayRef, ArrowError> {
    let DataType::List(item) = field.data_type() else {
        return Err(ArrowError::SchemaError(format!("the column `{}` is no list", field.name())));
    };
    let names: StringArray = classes.iter().map(|class| Some(class.name())).collect();
    let lengths = OffsetBuffer::from_lengths([classes.len()]);
    Ok(Arc::new(ListArray::try_new(item.clone(), lengths, Arc::new(names), None)?))
}

fn objects(field: &Field, objects: &[Object]) -> Result<ArrayRef, ArrowError> {
    let DataType::List(item) = field.data_type() else {
        return Err(ArrowError::SchemaError("the column `objects` is no list".into()));
    };
    let DataType::Struct(fields) = item.data_type() else {
        return Err(ArrowError::SchemaError("the column `objects` is no list of structs".into()));
    };
    let children = fields.iter().map(|field| object_cells(field, objects)).collect::<Result<Vec<_>, _>>()?;
    let structs: Arc<dyn Array> = Arc::new(StructArray::try_new(fields.clone(), children, None)?);
    Ok(Arc::new(ListArray::try_new(item.clone(), OffsetBuffer::from_lengths([objects.len()]), structs, None)?))
}

fn boxes(field: &Field, objects: &[Object]) -> Result<ArrayRef, ArrowError> {
    let DataType::FixedSizeList(side, length) = field.data_type() else {
        return Err(ArrowError::SchemaError("the field `bbox` is no fixed list".into()));
    };
    let sides: Int32Array = objects.iter().flat_map(|object| object.bbox.map(|n| Some(n as i32))).collect();
    Ok(Arc::new(FixedSizeListArray::try_new(side.clone(), *length, Arc::new(sides), None)?))
}
