//! The PNG images of a row, each decoded once: readable, of the size and depth that are declared. The rules of decoding
//! are one file.

use output_schema::row::{IMAGES, ROW};
use output_schema::{ColumnKind, Images};

use super::{Code, REMAKE_OR_REPORT, Rule, missing_rule};
use crate::validate::columns::StoredRow;
use crate::validate::report::ValidationReport;
use crate::{ExrChannel, PngSize, foreign_part, png_size, read_png_of};

pub(super) const UNREADABLE: Rule = Rule { meaning: "An image cannot be decoded.", remedy: REMAKE_OR_REPORT };
pub(super) const SIZE: Rule =
    Rule { meaning: "An image has another size or bit depth than declared.", remedy: REMAKE_OR_REPORT };

/// Decoded images by name.
#[derive(Debug, Default)]
pub(in crate::validate) struct DecodedImages(Vec<(String, Vec<u16>)>);

impl DecodedImages {
    /// Numbers of an image, row-major.
    pub(in crate::validate) fn get(&self, name: &str) -> Option<&[u16]> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, numbers)| numbers.as_slice())
    }

    /// Adds the channels of an EXR file of which the row has no image, as the image of that name would have them;
    /// `scale` is what the number 0 of Range means and what a step is [mm or px].
    pub(in crate::validate) fn add_channels(&mut self, channels: &[ExrChannel], scale: [f64; 2]) {
        for channel in channels {
            let name = image_of_channel(&channel.name);
            if !IMAGES.contains(&name.as_str()) || self.get(&name).is_some() {
                continue;
            }
            let numbers = channel.as_numbers();
            let height = |z: f32| ((f64::from(z) - scale[0]) / scale[1]).round().clamp(1.0, 65535.0);
            let numbers: Vec<u16> = match name.as_str() {
                "range" => numbers.iter().map(|&z| if z.is_nan() { 0 } else { height(z) as u16 }).collect(),
                "label" | "instance" => numbers.iter().map(|&n| n as u16).collect(),
                _ => numbers.iter().map(|n| n.round() as u16).collect(),
            };
            self.0.push((name, numbers));
        }
    }
}

/// Name of the image that repeats a channel of an EXR file.
pub(super) fn image_of_channel(channel: &str) -> String {
    if channel == "Y" { "reflectance".into() } else { channel.to_lowercase() }
}

/// Decodes every image, and checks size, depth and values.
pub(in crate::validate) fn check(
    row: &StoredRow,
    images: &Images,
    place: &str,
    report: &mut ValidationReport,
) -> DecodedImages {
    let mut decoded = DecodedImages::default();
    for (name, png) in &row.png {
        let size = match png_size(png) {
            Ok(size) => size,
            Err(what) => {
                report.fault(Code::ImageUnreadable, place, format!("`{name}`: {what}"));
                continue;
            }
        };
        let PngSize { cols, rows, bits } = size;
        // Nothing is decoded that is not as large as declared: a row may claim as much as its image, the head has
        // bounds.
        let declared = if name == "reflectance" { images.depth() } else { declared_bits(name) };
        if (i64::from(cols), i64::from(rows), bits) != (row.cols.into(), row.rows.into(), declared) {
            report.images += 1;
            let found = format!("`{name}` is {cols} x {rows} with {bits} bits");
            let what = format!("{found}, not {} x {} with {declared} bits", row.cols, row.rows);
            report.fault(Code::ImageSize, place, what);
            continue;
        }
        if (u64::from(cols), u64::from(rows)) != (images.cols, images.rows) {
            report.images += 1;
            let what =
                format!("`{name}` is {cols} x {rows}, not {} x {} as dataset.json says", images.cols, images.rows);
            report.fault(Code::ImageSize, place, what);
            continue;
        }
        if let Some(part) = foreign_part(png) {
            let what = format!("`{name}` has {part}, which the program does not write");
            report.fault(Code::HeaderDiffers, place, what);
        }
        match read_png_of(png, (cols.into(), rows.into())) {
            Err(what) => report.fault(Code::ImageUnreadable, place, format!("`{name}`: {what}")),
            Ok(grey) => {
                report.images += 1;
                let numbers = grey.numbers();
                let beyond = numbers.iter().filter(|&&n| name == "reflectance" && n > images.most_dn()).count();
                if beyond > 0 {
                    let what = format!("{beyond} pixels of `{name}` are beyond {} DN", images.most_dn());
                    report.fault(Code::ValueRange, place, what);
                }
                decoded.0.push((name.clone(), numbers));
            }
        }
    }
    missing_rule::check(&decoded, place, report);
    decoded
}

fn declared_bits(name: &str) -> u8 {
    let declared = ROW.iter().find(|column| column.name == name && IMAGES.contains(&column.name));
    match declared.map(|column| column.kind) {
        Some(ColumnKind::Image(bits)) => bits,
        _ => 0,
    }
}
