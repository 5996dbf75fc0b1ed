//! The maps of a sample are those whose sum its manifest lists.

use super::{Code, REMAKE, Rule, SampleToCheck, ValidationReport};
use crate::maps_sha256;

pub(super) const RULE: Rule =
    Rule { meaning: "The maps of a sample have another SHA-256 than the manifest says.", remedy: REMAKE };

pub(super) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    let complete = sample.exr.is_some() || !sample.task.head.has_exr();
    let png = sample.row.png.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()));
    if complete && maps_sha256(png, sample.exr) != sample.listed.sha256 {
        report.fault(Code::SampleChecksum, &sample.place, "its maps are not those of the manifest");
    }
}
