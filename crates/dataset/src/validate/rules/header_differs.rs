//! The header of an EXR file is the one that this program writes: windows, spacing, compression, attributes and the
//! text of its own one. Foreign parts of PNG images are told where these are decoded.

use exr::meta::header::Header;
use output_schema::SCHEMA_VERSION;
use serde_json::Value;

use super::{Code, REMAKE_OR_REPORT, Rule, SampleToCheck, ValidationReport};
use crate::{GENERATOR_VERSION, expected_header};

pub(super) const RULE: Rule = Rule {
    meaning: "An image or EXR file has a header, or a part, that the program does not write.",
    remedy: REMAKE_OR_REPORT,
};

/// Checks the header of a file that this version wrote: of another one it may be another one. `description` is the text
/// attribute that the row makes.
pub(super) fn check(header: &Header, description: &Value, sample: &SampleToCheck, report: &mut ValidationReport) {
    let (head, row) = (sample.task.head, &sample.row);
    if head.schema_version != SCHEMA_VERSION || head.generator.version != GENERATOR_VERSION {
        return;
    }
    let size = (header.layer_size.0, header.layer_size.1);
    let expected = expected_header(&head.channels(), size, (row.col_mm, row.row_mm), description);
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
    report.fault(Code::HeaderDiffers, sample.exr_path(), what);
}
