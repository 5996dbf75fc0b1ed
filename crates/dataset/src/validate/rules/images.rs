//! The PNG images of a row, each decoded once: readable, of the size and depth that are declared. The rules of decoding
//! are one file.

use output_schema::row::{IMAGES, LIGHT, ROW};
use output_schema::{ColumnKind, Images};

use super::{Code, REMAKE_OR_REPORT, Rule, ValidationReport, missing_rule};
use crate::validate::columns::StoredRow;
use crate::validate::decoded_images::DecodedImages;
use crate::{PngSize, foreign_part, png_size, read_png_of};

pub(super) const UNREADABLE: Rule = Rule { meaning: "An image cannot be decoded.", remedy: REMAKE_OR_REPORT };
pub(super) const SIZE: Rule =
    Rule { meaning: "An image has another size or bit depth than declared.", remedy: REMAKE_OR_REPORT };

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
        let is_light = LIGHT.contains(&name.as_str());
        let declared = if is_light { images.depth() } else { declared_bits(name) };
        let misfit = if (i64::from(cols), i64::from(rows), bits) != (row.cols.into(), row.rows.into(), declared) {
            let found = format!("`{name}` is {cols} x {rows} with {bits} bits");
            Some(format!("{found}, not {} x {} with {declared} bits", row.cols, row.rows))
        } else if (u64::from(cols), u64::from(rows)) != (images.cols, images.rows) {
            Some(format!("`{name}` is {cols} x {rows}, not {} x {} as dataset.json says", images.cols, images.rows))
        } else {
            None
        };
        if let Some(what) = misfit {
            report.images += 1;
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
                let beyond = numbers.iter().filter(|&&n| is_light && n > images.most_dn()).count();
                if beyond > 0 {
                    let what = format!("{beyond} pixels of `{name}` are beyond {} DN", images.most_dn());
                    report.fault(Code::ValueRange, place, what);
                }
                decoded.add(name.clone(), numbers);
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
