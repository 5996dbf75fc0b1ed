//! EXR files: the same maps in physical units, one layer, named channels.
//!
//! Bytes are the same in every run: one thread, one custom attribute (the crate keeps them in a hash map) and ASCII in
//! it (the format stores Latin-1, which readers take for UTF-8).

use std::borrow::Cow;
use std::io::Cursor;

use exr::meta::attribute::AttributeValue;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
    LayerAttributes, LineOrder, ReadChannels, ReadLayers, Text, Vec2, WritableImage, f16, read,
};
use output_schema::{Channel, SampleType};
use serde_json::{Value, json};

use crate::record::{Below, Record};

/// Compression of every file: on noisy maps smaller than ZIP and faster; see `benches/write.rs`.
pub(super) const COMPRESSION: Compression = Compression::PIZ;

/// Steps of heights in files, per mm: a power of two, so that they are exact. 0.12 um is far below any noise of such an
/// instrument; the bits beyond it would be a third of a file that holds truth maps.
pub(crate) const HEIGHT_STEPS: f32 = 8192.0;

/// A height as it is written [mm]; NaN stays.
fn stepped(height: f32) -> f32 {
    (height * HEIGHT_STEPS).round() / HEIGHT_STEPS
}

/// Samples of one channel, row-major.
#[derive(Debug, Clone, PartialEq)]
pub enum Samples {
    /// 16-bit floats, given as 32-bit ones.
    Half(Vec<f32>),
    /// 32-bit floats.
    Float(Vec<f32>),
    /// Whole numbers.
    Uint(Vec<u32>),
}

/// One named channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ExrChannel {
    /// Name in the file.
    pub name: String,
    /// Its samples.
    pub samples: Samples,
}

impl ExrChannel {
    /// Every sample as a number.
    pub fn numbers(&self) -> Vec<f32> {
        self.as_numbers().into_owned()
    }

    /// The same without a copy, where samples are floats.
    pub(crate) fn as_numbers(&self) -> Cow<'_, [f32]> {
        match &self.samples {
            Samples::Half(v) | Samples::Float(v) => Cow::Borrowed(v),
            Samples::Uint(v) => v.iter().map(|&n| n as f32).collect(),
        }
    }

    /// Type of the samples.
    pub(crate) fn sample_type(&self) -> SampleType {
        match self.samples {
            Samples::Half(_) => SampleType::Half,
            Samples::Float(_) => SampleType::Float,
            Samples::Uint(_) => SampleType::Uint,
        }
    }
}

/// The declared channels of a record, in the order of files.
pub(super) fn record_channels(record: &Record, declared: &[Channel]) -> Vec<ExrChannel> {
    let empty = Vec::new();
    let height = || record.truth.as_ref().map_or(&empty, |truth| &truth.height);
    let below = |second: bool| match record.truth.as_ref().map(|truth| &truth.below) {
        Some(Below::Fibre { azimuth: a, dive: b } | Below::Film { thickness: a, gap: b }) => {
            if second {
                b.clone()
            } else {
                a.clone()
            }
        }
        Some(Below::Solid(_)) | None => empty.clone(),
    };
    // Missing is NaN in float images, the picture for viewers apart.
    let seen = |map: &[f32]| -> Vec<f32> {
        map.iter().zip(&record.maps.range).map(|(&v, z)| if z.is_nan() { f32::NAN } else { v }).collect()
    };
    let channel = |c: &Channel| {
        let numbers = match c.name {
            "FibreAzimuth" | "FilmThickness" => below(false),
            "FibreDive" | "FilmGap" => below(true),
            "Height" => height().iter().copied().map(stepped).collect(),
            "Instance" => record.labels.instance.iter().map(|&n| f32::from(n)).collect(),
            "Label" => record.labels.class.iter().map(|&n| f32::from(n)).collect(),
            "Range" => record.maps.range.iter().copied().map(stepped).collect(),
            "Scatter" => seen(&record.maps.scatter),
            "Reflectance" => seen(&record.maps.reflectance),
            _ => record.maps.reflectance.clone(),
        };
        let samples = match c.samples {
            SampleType::Half => Samples::Half(numbers),
            SampleType::Float => Samples::Float(numbers),
            SampleType::Uint => Samples::Uint(numbers.iter().map(|&n| n as u32).collect()),
        };
        ExrChannel { name: c.name.into(), samples }
    };
    declared.iter().map(channel).collect()
}

/// What the text attribute says about a record.
pub(super) fn description(record: &Record, declared: &[Channel], bits: u32) -> Value {
    let numbers = record.calibration.iter().filter(|(_, number)| !number.is_nan());
    let calibration: serde_json::Map<String, Value> = numbers.map(|&(name, n)| (name.into(), n.into())).collect();
    let units: serde_json::Map<String, Value> = declared.iter().map(|c| (c.name.into(), c.unit.into())).collect();
    json!({
        "id": record.id, "index": record.index, "split": record.split.name(), "class": record.class,
        "row_mm": record.row_mm, "col_mm": record.col_mm, "bits": bits, "units": units,
        "range": record.range.name(), "sensor_rows": record.sensor_rows, "calibration": calibration,
    })
}

/// An EXR file of `cols` columns; `spacing_mm` is the distance between two columns and between two rows [mm].
///
/// # Panics
/// Where a channel does not hold whole rows of `cols`, or not as many samples as the others.
pub fn write_exr(channels: Vec<ExrChannel>, cols: usize, spacing_mm: (f64, f64), description: &Value) -> Vec<u8> {
    write_exr_as(channels, cols, spacing_mm, description, COMPRESSION)
}

/// As [`write_exr`] with a given compression.
///
/// # Panics
/// As [`write_exr`].
pub fn write_exr_as(
    channels: Vec<ExrChannel>,
    cols: usize,
    (col_mm, row_mm): (f64, f64),
    description: &Value,
    compression: Compression,
) -> Vec<u8> {
    let size = Vec2(cols, channels.first().map_or(0, |c| c.numbers().len()) / cols.max(1));
    let list = channels.into_iter().map(|channel| AnyChannel {
        name: Text::from(channel.name.as_str()),
        sample_data: match channel.samples {
            Samples::Half(v) => FlatSamples::F16(v.into_iter().map(f16::from_f32).collect()),
            Samples::Float(v) => FlatSamples::F32(v),
            Samples::Uint(v) => FlatSamples::U32(v),
        },
        quantize_linearly: false,
        sampling: Vec2(1, 1),
    });
    let encoding = Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let layer = LayerAttributes {
        software_name: Text::new_or_none(format!("sheetlight {}", super::GENERATOR_VERSION)),
        // Pixels in an inch, as OpenEXR has it.
        horizontal_density: Some((25.4 / col_mm) as f32),
        ..LayerAttributes::default()
    };
    let mut attributes = ImageAttributes::new(IntegerBounds::from_dimensions(size));
    attributes.pixel_aspect = (col_mm / row_mm) as f32;
    let text = Text::from(ascii(&description.to_string()).as_str());
    attributes.other.insert(Text::from(output_schema::channel::ATTRIBUTE), AttributeValue::Text(text));

    let layer = Layer::new(size, layer, encoding, AnyChannels::sort(list.collect()));
    let mut file = Cursor::new(Vec::new());
    Image::empty(attributes)
        .with_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut file)
        .expect("memory takes every byte, and the channels are as large as the image");
    file.into_inner()
}

/// JSON text without characters beyond ASCII.
fn ascii(json: &str) -> String {
    let mut text = String::with_capacity(json.len());
    for unit in json.encode_utf16() {
        match u8::try_from(unit) {
            Ok(byte) if byte.is_ascii() => text.push(char::from(byte)),
            _ => text.push_str(&format!("\\u{unit:04x}")),
        }
    }
    text
}

/// Columns, rows, channels and text attribute of an EXR file.
///
/// # Errors
/// What is wrong with it, for a damaged file.
pub fn read_exr(bytes: &[u8]) -> Result<(usize, usize, Vec<ExrChannel>, String), String> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| e.to_string())?;
    let name = Text::from(output_schema::channel::ATTRIBUTE);
    let text = match image.attributes.other.get(&name).or_else(|| image.layer_data.attributes.other.get(&name)) {
        Some(AttributeValue::Text(text)) => text.to_string(),
        _ => return Err(format!("the text attribute `{name}` is missing")),
    };
    let channel = |channel: AnyChannel<FlatSamples>| ExrChannel {
        name: channel.name.to_string(),
        samples: match channel.sample_data {
            FlatSamples::F16(v) => Samples::Half(v.into_iter().map(f16::to_f32).collect()),
            FlatSamples::F32(v) => Samples::Float(v),
            FlatSamples::U32(v) => Samples::Uint(v),
        },
    };
    let Vec2(cols, rows) = image.layer_data.size;
    Ok((cols, rows, image.layer_data.channel_data.list.into_iter().map(channel).collect(), text))
}
