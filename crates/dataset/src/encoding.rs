//! Encoding: `Record -> Encoded`, everything about a sample as it will be on disk. Pure, and called from many threads.

use output_schema::PIXEL_CLASSES;
use output_schema::channel::channels;
use procedural::Class;
use rayon::prelude::*;
use sha2::{Digest, Sha256};

use super::atomic_file::hex;
use super::png::{range_numbers, rounded8, rounded16};
use super::{Grey, exr, write_exr, write_png};
use crate::record::{Labels, Maps, Object, Record, StackFrame};
use crate::shares::SampleShares;
use bench::settings::{Channel, Output, Readout};
use bench::split::Split;

/// One sample, ready to be written.
#[derive(Debug, Clone)]
pub struct Encoded {
    /// Number in the dataset.
    pub index: u64,
    /// UUID.
    pub id: String,
    /// Part of the dataset.
    pub split: Split,
    /// Name of the recipe's class.
    pub class: String,
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
    pub class_area_px: [u64; PIXEL_CLASSES.len()],
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
        let png = self.png.iter().map(|(channel, bytes)| (channel_name(*channel), bytes.as_slice()));
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

/// Name of an image in files; a column of the rows and a word of `images` in `dataset.json`.
pub(crate) fn channel_name(channel: Channel) -> &'static str {
    match channel {
        Channel::Range => "range",
        Channel::Reflectance => "reflectance",
        Channel::Scatter => "scatter",
        Channel::Label => "label",
        Channel::Instance => "instance",
    }
}

/// A record as it will be on disk; the float maps end here.
///
/// # Panics
/// Where a map does not hold `rows * cols` numbers, or truth maps are asked for and the record has none.
pub fn encode(mut record: Record, output: &Output) -> Encoded {
    let mut asked = output.png.clone();
    asked.sort_unstable();
    asked.dedup();
    let png = asked.into_par_iter().map(|channel| (channel, image(&record, channel, output.bits))).collect();

    let names: Vec<String> = output.exr.iter().map(|&channel| channel_name(channel).into()).collect();
    let subject = record.truth.as_ref().map_or("", |truth| truth.below.subject());
    let declared = channels(&names, output.truth_maps, subject, record.range.name(), output.bits.into());
    let numbers = encode_numbers(&record, output.bits);
    let exr = (!declared.is_empty()).then(|| {
        let description = exr::description(&record, &declared, output.bits);
        let (cols, spacing_mm) = (record.cols, (record.col_mm, record.row_mm));
        write_exr(exr::record_channels(&mut record, &declared), cols, spacing_mm, &description)
    });
    Encoded { png, exr, stack: record.stack, ..numbers }
}

/// The numbers of a record as they will be on disk, without its images and sensor frames; `bits` are those of a digital number.
pub fn encode_numbers(record: &Record, bits: u32) -> Encoded {
    let mut class_area_px = [0; PIXEL_CLASSES.len()];
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

fn image(record: &Record, channel: Channel, bits: u32) -> Vec<u8> {
    let scale = [record.range_offset, record.range_scale];
    write_png(&image_of(&record.maps, &record.labels, channel, bits, scale), record.cols)
}

/// An image of maps; `scale` is what the number 0 of Range means and what a step of it is [mm or px].
pub(crate) fn image_of(maps: &Maps, labels: &Labels, channel: Channel, bits: u32, [offset, scale]: [f64; 2]) -> Grey {
    match channel {
        Channel::Range => Grey::Sixteen(range_numbers(&maps.range, offset, scale)),
        Channel::Reflectance if bits > 8 => Grey::Sixteen(rounded16(&maps.reflectance)),
        Channel::Reflectance => Grey::Eight(rounded8(&maps.reflectance)),
        Channel::Scatter => Grey::Sixteen(rounded16(&maps.scatter)),
        Channel::Label => Grey::Eight(labels.class.clone()),
        Channel::Instance => Grey::Sixteen(labels.instance.clone()),
    }
}
