//! Images: the PNG images of a row: size, depth, values, and the rule for missing pixels.

use output_schema::row::{IMAGES, ROW};
use output_schema::{ColumnKind, Images};

use super::columns::StoredRow;
use super::finding::{Code, Finding};
use super::report::ValidationReport;
use crate::{PngSize, foreign_part, png_size, read_png_of};

/// Decoded images by name.
#[derive(Debug, Default)]
pub(super) struct DecodedImages(Vec<(String, Vec<u16>)>);

impl DecodedImages {
    /// Numbers of an image, row-major.
    pub(super) fn get(&self, name: &str) -> Option<&[u16]> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, numbers)| numbers.as_slice())
    }

    /// Adds an image that was found elsewhere, where there is none of that name.
    pub(super) fn add(&mut self, name: &str, numbers: Vec<u16>) {
        if self.get(name).is_none() {
            self.0.push((name.into(), numbers));
        }
    }
}

/// Decodes every image, and checks size, depth and values.
pub(super) fn check(row: &StoredRow, images: &Images, place: &str, report: &mut ValidationReport) -> DecodedImages {
    let mut decoded = DecodedImages::default();
    for (name, png) in &row.png {
        let unreadable = |what: String| Finding::new(Code::ImageUnreadable, place, format!("`{name}`: {what}"));
        let size = match png_size(png) {
            Ok(size) => size,
            Err(what) => {
                report.faults.push(unreadable(what));
                continue;
            }
        };
        let PngSize { cols, rows, bits } = size;
        // Nothing is decoded that is not as large as declared: a row may claim as much as its image, the head has bounds.
        let declared = if name == "reflectance" { images.depth() } else { declared_bits(name) };
        if (i64::from(cols), i64::from(rows), bits) != (row.cols.into(), row.rows.into(), declared) {
            report.images += 1;
            let found = format!("`{name}` is {cols} x {rows} with {bits} bits");
            let what = format!("{found}, not {} x {} with {declared} bits", row.cols, row.rows);
            report.faults.push(Finding::new(Code::ImageSize, place, what));
            continue;
        }
        if (u64::from(cols), u64::from(rows)) != (images.cols, images.rows) {
            report.images += 1;
            let what =
                format!("`{name}` is {cols} x {rows}, not {} x {} as dataset.json says", images.cols, images.rows);
            report.faults.push(Finding::new(Code::ImageSize, place, what));
            continue;
        }
        if let Some(part) = foreign_part(png) {
            let what = format!("`{name}` has {part}, which the program does not write");
            report.faults.push(Finding::new(Code::HeaderDiffers, place, what));
        }
        match read_png_of(png, (cols.into(), rows.into())) {
            Err(what) => report.faults.push(unreadable(what)),
            Ok(grey) => {
                report.images += 1;
                let numbers = grey.numbers();
                let beyond = numbers.iter().filter(|&&n| name == "reflectance" && n > images.most_dn()).count();
                if beyond > 0 {
                    let what = format!("{beyond} pixels of `{name}` are beyond {} DN", images.most_dn());
                    report.faults.push(Finding::new(Code::ValueRange, place, what));
                }
                decoded.add(name, numbers);
            }
        }
    }
    missing_rule(&decoded, place, report);
    decoded
}

fn declared_bits(name: &str) -> u8 {
    let declared = ROW.iter().find(|column| column.name == name && IMAGES.contains(&column.name));
    match declared.map(|column| column.kind) {
        Some(ColumnKind::Image(bits)) => bits,
        _ => 0,
    }
}

/// Range is 0 exactly where reflectance and scatter are 0.
fn missing_rule(decoded: &DecodedImages, place: &str, report: &mut ValidationReport) {
    let Some(range) = decoded.get("range") else { return };
    let (reflectance, scatter) = (decoded.get("reflectance"), decoded.get("scatter"));
    let light = |map: Option<&[u16]>, i: usize| map.is_some_and(|map| map[i] > 0);
    let both = reflectance.is_some() && scatter.is_some();
    let broken = |&i: &usize| {
        let lit = light(reflectance, i) || light(scatter, i);
        if range[i] == 0 { lit } else { both && !lit }
    };
    let count = (0..range.len()).filter(broken).count();
    if count > 0 {
        let what = format!("{count} pixels have range without light, or light without range");
        report.faults.push(Finding::new(Code::MissingRule, place, what));
    }
}

/// Every label is one of `values`.
pub(super) fn known_labels(decoded: &DecodedImages, values: &[u8], place: &str, report: &mut ValidationReport) -> bool {
    let Some(label) = decoded.get("label") else { return true };
    let mut known = [false; 256];
    values.iter().for_each(|&value| known[usize::from(value)] = true);
    match label.iter().find(|&&class| !known.get(usize::from(class)).is_some_and(|known| *known)) {
        None => true,
        Some(class) => {
            let what = format!("the label {class} is no pixel class of the subject");
            report.faults.push(Finding::new(Code::LabelUnknown, place, what));
            false
        }
    }
}
