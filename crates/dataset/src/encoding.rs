//! Encoding: `Record -> Encoded`, everything about a sample as it will be on disk. Pure, and called from many threads.

use output_schema::channel::channels;
use rayon::prelude::*;

use super::png::{range_numbers, rounded8, rounded16};
use super::{Encoded, Grey, encode_numbers, exr, write_exr, write_png};
use crate::record::{Labels, Maps, Record};
use optical_bench::settings::{Channel, Output};

/// A record as it will be on disk; the float maps end here.
///
/// # Panics
/// Where a map does not hold `rows * cols` numbers, or truth maps are asked for and the record has none.
pub fn encode(mut record: Record, output: &Output) -> Encoded {
    let mut asked = output.png.clone();
    asked.sort_unstable();
    asked.dedup();
    let png = asked.into_par_iter().map(|channel| (channel, image(&record, channel, output.bits))).collect();

    let subject = record.truth.as_ref().map_or("", |truth| truth.below.subject());
    let declared = channels(&output.exr_names(), output.truth_maps, subject, record.range.name(), output.bits.into());
    let numbers = encode_numbers(&record, output.bits);
    let exr = output.has_exr().then(|| {
        let description = exr::description(&record, &declared, output.bits);
        let (cols, spacing_mm) = (record.cols, (record.col_mm, record.row_mm));
        write_exr(exr::record_channels(&mut record, &declared), cols, spacing_mm, &description)
    });
    Encoded { png, exr, stack: record.stack, ..numbers }
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
        Channel::Grey if bits > 8 => Grey::Sixteen(rounded16(&maps.grey)),
        Channel::Grey => Grey::Eight(rounded8(&maps.grey)),
        Channel::Scatter => Grey::Sixteen(rounded16(&maps.scatter)),
        Channel::Label => Grey::Eight(labels.class.clone()),
        Channel::Instance => Grey::Sixteen(labels.instance.clone()),
    }
}
