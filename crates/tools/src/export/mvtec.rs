//! MVTec AD layout: folders that programs for anomaly detection read.
//!
//! ```text
//! train/good/<name>.png    test/good/<name>.png    test/<defect>/<name>.png    ground_truth/<defect>/<name>_mask.png
//! ```
//!
//! `validation` has no place in the layout.

use std::path::Path;

use clap::Args;

use super::anomaly::{AnomalyLayout, AnomalyOptions, AnomalyPart, write};
use super::export_folder::{ExportFolder, ExportSummary};
use super::format::{Export, ExportFormat};
use super::source::{ExportProgress, ExportSource};
use dataset::Fault;
use optical_bench::split::Split;

pub(super) const FORMAT: ExportFormat = ExportFormat::of::<Mvtec>(
    "mvtec",
    "MVTec AD folders",
    ["mvtec packs --out packs-mvtec --patch-px 256", "folders for anomaly detection"],
);

const LAYOUT: AnomalyLayout =
    AnomalyLayout { name: FORMAT.name, splits: &[Split::Train, Split::Test], images: &[], put };

/// Folders as MVTec AD has them: train/good, test/good, test/<defect>, ground_truth/<defect>
#[derive(Debug, Args)]
struct Mvtec {
    #[command(flatten)]
    options: AnomalyOptions,
}

impl Export for Mvtec {
    fn splits(&self, given: Option<Split>) -> Result<Vec<Split>, String> {
        match given {
            None => Ok(LAYOUT.splits.to_vec()),
            Some(Split::Validation) => {
                Err("the layout has no folder for validation: give --split train, test or all".into())
            }
            Some(split) => Ok(vec![split]),
        }
    }

    fn check(&self) -> Result<(), String> {
        self.options.pictures.check()
    }

    fn write(&self, source: &ExportSource, out: &Path, progress: ExportProgress) -> Result<ExportSummary, Fault> {
        write(LAYOUT, &self.options, source, out, progress)
    }
}

fn put(out: &ExportFolder, part: &AnomalyPart) -> Result<(), Fault> {
    let AnomalyPart { split, folder, name, .. } = part;
    out.put(&format!("{}/{folder}/{name}.png", split.name()), || Ok(part.picture().png()))?;
    if *folder != "good" {
        out.put(&format!("ground_truth/{folder}/{name}_mask.png"), || Ok(part.mask()))?;
    }
    Ok(())
}
