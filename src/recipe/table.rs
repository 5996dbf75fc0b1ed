//! Every key of a recipe by section: reading, canonical form, schema and reference all walk over this table.
//!
//! Parameters are drawn for each sample and declared beside the physics that uses them; settings are the same for all
//! samples and declared here.

use procedural::Parameter;
use procedural::wood::{Board, Knots, Log, Media, Rot};

use super::setting::{self, Setting};
use super::transport;
use crate::optics::parameters::{Camera, Exposure, Laser, Motion, Speckle};

/// A group of keys.
#[derive(Debug, Clone, Copy)]
pub(super) struct Section {
    /// Key path, for instance `camera` or `output.bin`.
    pub path: &'static str,
    /// What the group is about.
    pub doc: &'static str,
    /// Keys that are the same for all samples.
    pub settings: &'static [Setting],
    /// Keys that are drawn for each sample.
    pub parameters: &'static [Parameter],
}

/// A section of parameters, and perhaps settings beside them.
macro_rules! drawn {
    ($Group:ty, $settings:expr) => {
        Section { path: <$Group>::GROUP, doc: <$Group>::DOC, settings: $settings, parameters: <$Group>::PARAMETERS }
    };
}

/// A section of settings alone.
const fn fixed(path: &'static str, doc: &'static str, settings: &'static [Setting]) -> Section {
    Section { path, doc, settings, parameters: &[] }
}

/// Every section, in the order of the light: scan, bench, board, transport, reading, writing.
pub(super) const SECTIONS: [Section; 16] = [
    fixed("scan", "Sizes of the scan.", setting::SCAN),
    drawn!(Motion, &[]),
    drawn!(Laser, &[]),
    drawn!(Camera, setting::CAMERA),
    drawn!(Exposure, &[]),
    drawn!(Speckle, &[]),
    drawn!(Board, &[]),
    drawn!(Log, &[]),
    drawn!(Knots, &[]),
    drawn!(Rot, &[]),
    drawn!(Media, &[]),
    fixed(transport::SECTION, transport::DOC, transport::TABLE),
    fixed("extraction", "How a profile is read from a frame.", setting::EXTRACTION),
    fixed("splits", "Shares of the parts of the dataset; they sum to 1.", setting::SPLITS),
    fixed("output", "What is written.", setting::OUTPUT),
    fixed("output.bin", "How many pixels are averaged into one of the written images.", setting::BIN),
];

/// Every parameter in the order of [`SECTIONS`].
pub(super) fn parameters() -> impl Iterator<Item = &'static Parameter> {
    SECTIONS.iter().flat_map(|section| section.parameters)
}

/// The unit that a key ends in, empty for none.
pub(super) fn unit(name: &str) -> &'static str {
    const UNITS: [(&str, &str); 12] = [
        ("_deg_per_mm", "deg/mm"),
        ("_per_mm", "1/mm"),
        ("_mm", "mm"),
        ("_um", "um"),
        ("_nm", "nm"),
        ("_deg", "deg"),
        ("_mw", "mW"),
        ("_us", "us"),
        ("_dn", "DN"),
        ("_e", "electrons"),
        ("_rows", "px"),
        ("_columns", "px"),
    ];
    UNITS.iter().find(|(end, _)| name.ends_with(end)).map_or("", |(_, unit)| unit)
}

/// Where a key that stands in the wrong section belongs.
pub(super) fn home(name: &str) -> Option<String> {
    let has = |section: &&Section| {
        section.parameters.iter().any(|p| p.name == name) || section.settings.iter().any(|s| s.name == name)
    };
    let homes: Vec<_> = SECTIONS.iter().filter(has).map(|section| format!("`{}`", section.path)).collect();
    (!homes.is_empty()).then(|| format!("`{name}` belongs in {}", homes.join(" or ")))
}

/// Documentation without the blanks that `///` leaves in front of its lines.
pub(super) fn tidy(doc: &str) -> String {
    doc.trim().replace("  ", " ")
}
