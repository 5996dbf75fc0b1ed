//! EXR files: the same maps in physical units, one layer, named channels.
//!
//! Bytes are the same in every run: blocks in order, whichever thread compresses them, one custom attribute (the crate
//! keeps them in a hash map) and ASCII in it (the format stores Latin-1, which readers take for UTF-8). Blocks are
//! compressed from the last one on, and the maps shortened by them, so that numbers go as compressed blocks come.

use std::io::Cursor;

use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::writer::ChunksWriter;
use exr::block::{BlockIndex, UncompressedBlock, enumerate_ordered_header_block_indices};
use exr::meta::attribute::{AttributeValue, SampleType as FileSampleType};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
    LayerAttributes, LineOrder, ReadChannels, ReadLayers, Text, Vec2, WritableImage, f16, read,
};
use output_schema::{Channel, DatasetHead, SampleType};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::png::stepped;
use crate::range_rest::range_rest;
use crate::record::{Below, Labels, Maps, Record, TruthMaps};

/// Compression of every file: on noisy maps smaller than ZIP and faster; see `benches/write.rs`.
pub(super) const COMPRESSION: Compression = Compression::PIZ;

/// Blocks of a file that are compressed together, by as many threads as are free: 512 rows with PIZ.
const BLOCKS_TOGETHER: usize = 16;

/// Bytes of a block beside its samples: its place in the table, its row and its length.
const BLOCK_HEAD_BYTES: usize = 8 + 4 + 4;
/// Bytes of a usual head.
const HEAD_BYTES: usize = 4096;

/// Name of the channel that [`range_rest`] makes.
pub(crate) const RANGE_REST: &str = "RangeRest";

/// Why writing into memory does not fail.
const FITS: &str = "memory takes every byte, and the channels are as large as the image";

/// One named channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ExrChannel {
    /// Name in the file.
    pub name: String,
    /// Type of its samples there.
    pub samples: SampleType,
    /// Every sample as a number, row-major.
    pub numbers: Vec<f32>,
}

/// The numbers of a channel of truth maps, before they are rounded to its type; `None` where these have none of that
/// name.
pub(crate) fn truth_channel(truth: &TruthMaps, name: &str) -> Option<Vec<f32>> {
    match (name, &truth.below) {
        ("Height", _) => Some(truth.height.iter().copied().map(stepped).collect()),
        ("FibreAzimuth", Below::Fibre { azimuth: map, .. })
        | ("FibreDive", Below::Fibre { dive: map, .. })
        | ("FilmThickness", Below::Film { thickness: map, .. })
        | ("FilmGap", Below::Film { gap: map, .. }) => Some(map.clone()),
        _ => None,
    }
}

/// The declared channels of maps, in the order of files; those of truth maps are empty where there are none.
pub(crate) fn map_channels(
    maps: &Maps,
    labels: &Labels,
    truth: Option<&TruthMaps>,
    declared: &[Channel],
) -> Vec<ExrChannel> {
    declared.iter().map(|c| map_channel(maps, labels, truth, c)).collect()
}

/// The same of a record, whose maps end here: each goes with the last channel that needs it, so that memory holds the
/// maps once.
pub(super) fn record_channels<'a>(
    record: &'a mut Record,
    declared: &'a [Channel],
) -> impl Iterator<Item = ExrChannel> + 'a {
    let needs = |c: &Channel, map: usize| match c.name {
        "Range" | RANGE_REST => map == 0,
        "Reflectance" => map <= 1,
        "Scatter" => map == 0 || map == 2,
        "Y" => map == 1,
        "Grey" => map == 3,
        _ => false,
    };
    declared.iter().enumerate().map(move |(place, c)| {
        let channel = match c.name {
            RANGE_REST => rest_channel(record, c),
            _ => map_channel(&record.maps, &record.labels, record.truth.as_ref(), c),
        };
        let later = &declared[place + 1..];
        let Maps { range, reflectance, scatter, grey } = &mut record.maps;
        for (number, map) in [range, reflectance, scatter, grey].into_iter().enumerate() {
            if !later.iter().any(|c| needs(c, number)) {
                *map = Vec::new();
            }
        }
        match (c.name, &mut record.truth) {
            ("Label", _) => record.labels.class = Vec::new(),
            ("Instance", _) => record.labels.instance = Vec::new(),
            ("Height", Some(truth)) => truth.height = Vec::new(),
            ("FibreAzimuth", Some(TruthMaps { below: Below::Fibre { azimuth: map, .. }, .. }))
            | ("FibreDive", Some(TruthMaps { below: Below::Fibre { dive: map, .. }, .. }))
            | ("FilmThickness", Some(TruthMaps { below: Below::Film { thickness: map, .. }, .. }))
            | ("FilmGap", Some(TruthMaps { below: Below::Film { gap: map, .. }, .. })) => *map = Vec::new(),
            _ => {}
        }
        channel
    })
}

/// What the numbers of Range leave of it, as a channel.
fn rest_channel(record: &Record, c: &Channel) -> ExrChannel {
    let numbers = range_rest(&record.maps.range, record.cols, record.range_offset, record.range_scale);
    ExrChannel { name: c.name.into(), samples: c.samples, numbers }
}

fn map_channel(maps: &Maps, labels: &Labels, truth: Option<&TruthMaps>, c: &Channel) -> ExrChannel {
    let truth = |name: &str| truth.and_then(|truth| truth_channel(truth, name)).unwrap_or_default();
    // Missing is NaN in float images, the picture for viewers apart.
    let seen = |map: &[f32]| -> Vec<f32> {
        map.iter().zip(&maps.range).map(|(&v, z)| if z.is_nan() { f32::NAN } else { v }).collect()
    };
    let numbers = match c.name {
        "FibreAzimuth" | "FilmThickness" | "FibreDive" | "FilmGap" | "Height" => truth(c.name),
        "Instance" => labels.instance.iter().map(|&n| f32::from(n)).collect(),
        "Label" => labels.class.iter().map(|&n| f32::from(n)).collect(),
        "Range" => maps.range.iter().copied().map(stepped).collect(),
        "Scatter" => seen(&maps.scatter),
        "Reflectance" => seen(&maps.reflectance),
        "Grey" => maps.grey.clone(),
        _ => maps.reflectance.clone(),
    };
    ExrChannel { name: c.name.into(), samples: c.samples, numbers }
}

/// What the text attribute says about a sample.
#[derive(Debug, Clone)]
pub(crate) struct ExrDescription<'a> {
    pub(crate) id: &'a str,
    pub(crate) index: u64,
    pub(crate) split: &'a str,
    /// Name of the recipe's class, where it has that.
    pub(crate) class: Option<&'a str>,
    /// Distance between two rows, and between two columns [mm].
    pub(crate) pitch_mm: [f64; 2],
    pub(crate) bits: u64,
    /// Name of the form of Range.
    pub(crate) range: &'a str,
    pub(crate) sensor_rows: u64,
    /// Numbers of the calibration that are there, by name.
    pub(crate) calibration: Vec<(&'a str, f64)>,
    /// Declarations of the channels.
    pub(crate) channels: &'a [Channel],
}

impl ExrDescription<'_> {
    /// The document.
    pub(crate) fn json(&self) -> Value {
        let Self { id, index, split, class, pitch_mm: [row_mm, col_mm], bits, range, sensor_rows, .. } = self;
        let calibration: serde_json::Map<String, Value> =
            self.calibration.iter().map(|&(name, n)| (name.into(), n.into())).collect();
        let units: serde_json::Map<String, Value> =
            self.channels.iter().map(|c| (c.name.into(), c.unit.into())).collect();
        json!({
            "id": id, "index": index, "split": split, "class": class, "row_mm": row_mm, "col_mm": col_mm,
            "bits": bits, "units": units, "range": range, "sensor_rows": sensor_rows, "calibration": calibration,
        })
    }
}

/// The same of a record.
pub(super) fn description(record: &Record, declared: &[Channel], bits: u32) -> Value {
    let description = ExrDescription {
        id: &record.id,
        index: record.index,
        split: record.split.name(),
        class: Some(&record.class),
        pitch_mm: [record.row_mm, record.col_mm],
        bits: bits.into(),
        range: record.range.name(),
        sensor_rows: record.sensor_rows as u64,
        calibration: record.calibration.iter().filter(|(_, number)| !number.is_nan()).copied().collect(),
        channels: declared,
    };
    description.json()
}

/// An EXR file of `cols` columns; `spacing_mm` is the distance between two columns and between two rows [mm].
///
/// # Panics
/// Where a channel does not hold whole rows of `cols`, or not as many samples as the others.
pub fn write_exr(
    channels: impl IntoIterator<Item = ExrChannel>,
    cols: usize,
    spacing_mm: (f64, f64),
    description: &Value,
) -> Vec<u8> {
    write_exr_as(channels, cols, spacing_mm, description, COMPRESSION)
}

/// As [`write_exr`] with a given compression.
///
/// # Panics
/// As [`write_exr`].
pub fn write_exr_as(
    channels: impl IntoIterator<Item = ExrChannel>,
    cols: usize,
    (col_mm, row_mm): (f64, f64),
    description: &Value,
    compression: Compression,
) -> Vec<u8> {
    let mut list: Vec<(String, FlatSamples)> =
        channels.into_iter().map(|channel| (channel.name, samples(channel.samples, channel.numbers))).collect();
    // As files have them.
    list.sort_by(|a, b| a.0.cmp(&b.0));
    let size = Vec2(cols, list.first().map_or(0, |(_, samples)| samples.len()) / cols.max(1));
    let empty =
        list.iter().map(|(name, samples)| (name.clone(), self::samples(sample_type(samples), Vec::new()))).collect();
    let headers = image(empty, size, (col_mm, row_mm), description, compression).write().infer_meta_data();
    let mut maps: Vec<FlatSamples> = list.into_iter().map(|(_, samples)| samples).collect();
    let blocks: Vec<(usize, BlockIndex)> = enumerate_ordered_header_block_indices(&headers).collect();
    let mut chunks: Vec<Chunk> = Vec::with_capacity(blocks.len());
    for group in blocks.chunks(BLOCKS_TOGETHER).rev() {
        let compressed = group.par_iter().map(|(_, index)| block(&maps, cols, *index).compress_to_chunk(&headers));
        let compressed: Vec<Chunk> = compressed.collect::<exr::error::Result<_>>().expect(FITS);
        chunks.extend(compressed.into_iter().rev());
        let rows = group.first().map_or(0, |(_, index)| index.pixel_position.y());
        maps.iter_mut().for_each(|map| shorten(map, rows * cols));
    }
    // Room for all of it at once: a file that grows is there twice for a while.
    let bytes: usize = chunks.iter().map(|chunk| BLOCK_HEAD_BYTES + compressed(chunk)).sum();
    let mut file = Cursor::new(Vec::with_capacity(HEAD_BYTES + bytes));
    exr::block::write(&mut file, headers, true, |_, writer| {
        let mut chunks = blocks.into_iter().zip(chunks.into_iter().rev());
        chunks.try_for_each(|((number, _), chunk)| writer.write_chunk(number, chunk))
    })
    .expect(FITS);
    file.into_inner()
}

/// Bytes of a compressed block of scan lines.
fn compressed(chunk: &Chunk) -> usize {
    match &chunk.compressed_block {
        CompressedBlock::ScanLine(lines) => lines.compressed_pixels_le.len(),
        _ => 0,
    }
}

/// A block of scan lines: row by row the samples of each channel.
fn block(maps: &[FlatSamples], cols: usize, index: BlockIndex) -> UncompressedBlock {
    let bytes: u64 = maps.iter().map(|map| sample_bytes(sample_type(map))).sum();
    let mut data = Vec::with_capacity(index.pixel_size.area() * bytes as usize);
    let first = index.pixel_position.y();
    for row in first..first + index.pixel_size.height() {
        let line = row * cols..(row + 1) * cols;
        for map in maps {
            match map {
                FlatSamples::F16(v) => v[line.clone()].iter().for_each(|n| data.extend_from_slice(&n.to_ne_bytes())),
                FlatSamples::F32(v) => v[line.clone()].iter().for_each(|n| data.extend_from_slice(&n.to_ne_bytes())),
                FlatSamples::U32(v) => v[line.clone()].iter().for_each(|n| data.extend_from_slice(&n.to_ne_bytes())),
            }
        }
    }
    UncompressedBlock { index, data }
}

/// Lets go of all samples but the first.
fn shorten(map: &mut FlatSamples, samples: usize) {
    fn shorten<T>(map: &mut Vec<T>, samples: usize) {
        map.truncate(samples);
        map.shrink_to_fit();
    }
    match map {
        FlatSamples::F16(v) => shorten(v, samples),
        FlatSamples::F32(v) => shorten(v, samples),
        FlatSamples::U32(v) => shorten(v, samples),
    }
}

fn sample_type(samples: &FlatSamples) -> SampleType {
    match samples {
        FlatSamples::F16(_) => SampleType::Half,
        FlatSamples::F32(_) => SampleType::Float,
        FlatSamples::U32(_) => SampleType::Uint,
    }
}

/// Numbers as samples of that type.
fn samples(samples: SampleType, numbers: Vec<f32>) -> FlatSamples {
    match samples {
        SampleType::Half => FlatSamples::F16(numbers.into_iter().map(f16::from_f32).collect()),
        SampleType::Float => FlatSamples::F32(numbers),
        SampleType::Uint => FlatSamples::U32(numbers.into_iter().map(|n| n as u32).collect()),
    }
}

/// The image that is written: one layer, scan lines, every attribute.
fn image(
    list: Vec<(String, FlatSamples)>,
    size: Vec2<usize>,
    (col_mm, row_mm): (f64, f64),
    description: &Value,
    compression: Compression,
) -> Image<Layer<AnyChannels<FlatSamples>>> {
    let list = list.into_iter().map(|(name, sample_data)| AnyChannel {
        name: Text::from(name.as_str()),
        sample_data,
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
    Image::new(attributes, Layer::new(size, layer, encoding, AnyChannels::sort(list.collect())))
}

/// What the file of a sample may hold, as far as it is known before the file is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ExrSize {
    /// Columns and rows; `None` for any [px].
    size: Option<(u64, u64)>,
    /// Of all samples of all channels, decoded [bytes].
    bytes: u64,
}

/// Most channels of a file.
const MAX_CHANNELS: usize = 64;

impl ExrSize {
    /// The largest file that belongs to no dataset.
    pub(crate) const LARGEST: Self = Self { size: None, bytes: 1 << 30 };

    /// Of the files of a dataset.
    pub(crate) fn of(head: &DatasetHead) -> Self {
        let size = (head.images.cols, head.images.rows);
        let bytes: u64 = head.channels().iter().map(|channel| sample_bytes(channel.samples)).sum();
        Self { size: Some(size), bytes: size.0.saturating_mul(size.1).saturating_mul(bytes) }
    }

    /// Why a file with that header does not fit; asked before anything is taken for its samples.
    pub(crate) fn refuses(&self, header: &Header) -> Option<String> {
        let Vec2(cols, rows) = header.layer_size;
        let (cols, rows) = (cols as u64, rows as u64);
        if let Some(size) = self.size.filter(|size| *size != (cols, rows)) {
            return Some(format!("it is {cols} x {rows}, not {} x {}", size.0, size.1));
        }
        let list = &header.channels.list;
        let each: u64 = list.iter().map(|channel| channel.sample_type.bytes_per_sample() as u64).sum();
        let bytes = cols.saturating_mul(rows).saturating_mul(each);
        let what = format!("{} channels of {cols} x {rows} take {bytes} bytes, at most {}", list.len(), self.bytes);
        (bytes > self.bytes || list.len() > MAX_CHANNELS).then_some(what)
    }
}

fn sample_bytes(samples: SampleType) -> u64 {
    match samples {
        SampleType::Half => 2,
        SampleType::Float | SampleType::Uint => 4,
    }
}

/// The header of a file of one layer of scan lines.
///
/// # Errors
/// What is wrong with it.
pub(crate) fn exr_header(bytes: &[u8]) -> Result<Header, String> {
    let mut headers = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| e.to_string())?.headers;
    match (headers.pop(), headers.len()) {
        (Some(header), 0) if header.deep || header.blocks != BlockDescription::ScanLines => {
            Err("it holds tiles or deep data, not scan lines".into())
        }
        (Some(header), 0) => Ok(together(header)),
        (_, layers) => Err(format!("it holds {} layers, not one", layers + 1)),
    }
}

/// Names and types of the channels of a header, in its order.
pub(crate) fn channel_types(header: &Header) -> Vec<(String, SampleType)> {
    let sample_type = |sample_type: FileSampleType| match sample_type {
        FileSampleType::F16 => SampleType::Half,
        FileSampleType::F32 => SampleType::Float,
        FileSampleType::U32 => SampleType::Uint,
    };
    header.channels.list.iter().map(|channel| (channel.name.to_string(), sample_type(channel.sample_type))).collect()
}

/// The header that [`write_exr`] writes for such channels.
pub(crate) fn expected_header(
    channels: &[Channel],
    (cols, rows): (usize, usize),
    spacing_mm: (f64, f64),
    description: &Value,
) -> Option<Header> {
    let list = channels.iter().map(|channel| (channel.name.to_owned(), samples(channel.samples, Vec::new()))).collect();
    image(list, Vec2(cols, rows), spacing_mm, description, COMPRESSION).write().infer_meta_data().pop().map(together)
}

/// A header with all custom attributes in one place: a file does not say which are of the image and which of its layer.
fn together(mut header: Header) -> Header {
    let own = std::mem::take(&mut header.own_attributes.other);
    header.shared_attributes.other.extend(own);
    header
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
pub(super) type ExrContent = (usize, usize, Vec<ExrChannel>, String);

/// Columns, rows, channels and text attribute of an EXR file.
///
/// # Errors
/// What is wrong with it, for a damaged file or one that is larger than any.
pub fn read_exr(bytes: &[u8]) -> Result<ExrContent, String> {
    read_exr_of(bytes, &ExrSize::LARGEST)
}

/// The same of a file of a dataset; nothing is taken for one of another size.
///
/// # Errors
/// As [`read_exr`], and where it has another size.
pub(crate) fn read_exr_of(bytes: &[u8], size: &ExrSize) -> Result<ExrContent, String> {
    if let Some(what) = size.refuses(&exr_header(bytes)?) {
        return Err(what);
    }
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
        samples: sample_type(&channel.sample_data),
        numbers: match channel.sample_data {
            FlatSamples::F16(v) => v.into_iter().map(f16::to_f32).collect(),
            FlatSamples::F32(v) => v,
            FlatSamples::U32(v) => v.into_iter().map(|n| n as f32).collect(),
        },
    };
    let Vec2(cols, rows) = image.layer_data.size;
    Ok((cols, rows, image.layer_data.channel_data.list.into_iter().map(channel).collect(), text))
}
