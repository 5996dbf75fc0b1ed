//! The header of an EXR file is the one that this program writes: windows, spacing, compression, attributes and the
//! text of its own one. Foreign parts of PNG images are told where these are decoded.

use exr::meta::header::Header;
use output_schema::SCHEMA_VERSION;
use output_schema::row::CALIBRATION;

use super::{Code, REMAKE_OR_REPORT, Rule};
use crate::validate::report::ValidationReport;
use crate::validate::sample_to_check::SampleToCheck;
use crate::{ExrDescription, GENERATOR_VERSION, expected_header};

pub(super) const RULE: Rule = Rule {
    meaning: "An image or EXR file has a header, or a part, that the program does not write.",
    remedy: REMAKE_OR_REPORT,
};

/// Checks the header of a file that this version wrote: of another one it may be another one.
pub(super) fn check(header: &Header, sample: &SampleToCheck, place: &str, report: &mut ValidationReport) {
    let (head, row) = (sample.task.head, &sample.row);
    if head.schema_version != SCHEMA_VERSION || head.generator.version != GENERATOR_VERSION {
        return;
    }
    let channels = head.channels();
    let class = usize::try_from(row.class).ok().and_then(|class| head.classes.get(class));
    let calibration = row.derived.iter().filter(|(name, _)| CALIBRATION.iter().any(|field| field.name == name));
    let description = ExrDescription {
        id: &row.id,
        index: row.index.unsigned_abs(),
        split: &row.split,
        class: class.map_or("", String::as_str),
        pitch_mm: [row.row_mm, row.col_mm],
        bits: head.images.bits,
        range: &head.images.range,
        sensor_rows: head.images.sensor_rows,
        calibration: calibration.map(|(name, value)| (name.as_str(), *value)).collect(),
        channels: &channels,
    };
    let size = (header.layer_size.0, header.layer_size.1);
    let expected = expected_header(&channels, size, (row.col_mm, row.row_mm), &description.json());
    let Some(expected) = expected.filter(|expected| expected != header) else { return };
    let [found, made] = [&header, &&expected].map(|header| &header.own_attributes);
    let (shared, own) = (&header.shared_attributes, &expected.shared_attributes);
    let parts = [
        ("data window", found.layer_position != made.layer_position),
        ("display window", shared.display_window != own.display_window),
        ("pixel aspect", shared.pixel_aspect != own.pixel_aspect),
        ("text attribute", shared.other != own.other),
        ("compression", header.compression != expected.compression),
        ("order of lines", header.line_order != expected.line_order),
    ];
    let other: Vec<&str> = parts.iter().filter(|(_, differs)| *differs).map(|(name, _)| *name).collect();
    let named = if other.is_empty() { "attributes".into() } else { other.join(", ") };
    let what = format!("its header is not the one that the program writes: {named}");
    report.fault(Code::HeaderDiffers, place, what);
}
