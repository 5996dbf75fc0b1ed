//! Which pixels of a side's scans count.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::{CommandResult, UsageError};
use dataset::Fault;
use tools::compare::{ScanMaps, ScanMask, ScanRegion, ScanSource};

/// Longest mask that is read [bytes].
const MAX_MASK_BYTES: u64 = 1 << 28;

#[derive(Debug, Args)]
#[command(next_help_heading = "Pixels that count")]
pub(super) struct PartArgs {
    /// The part of each scan of REAL that counts [px]
    #[arg(long, value_name = "LEFT,TOP,COLUMNS,PROFILES", value_parser = ScanRegion::parse)]
    region: Option<ScanRegion>,
    /// Picture (PNG) of the size of REAL's scans; where it is black, nothing counts
    #[arg(long, value_name = "FILE")]
    mask: Option<PathBuf>,
    /// The same as --region for SIM
    #[arg(long, value_name = "LEFT,TOP,COLUMNS,PROFILES", value_parser = ScanRegion::parse)]
    sim_region: Option<ScanRegion>,
    /// The same as --mask for SIM
    #[arg(long, value_name = "FILE")]
    sim_mask: Option<PathBuf>,
    /// Of datasets count all pixels, not the object's alone, which their labels tell
    #[arg(long)]
    whole: bool,
}

/// What counts of one side.
pub(super) struct SidePart {
    region: Option<ScanRegion>,
    mask: Option<ScanMask>,
    /// Whether the object alone counts.
    object: bool,
}

impl PartArgs {
    /// What counts of SIM and of REAL.
    pub(super) fn sides(&self, sources: &[ScanSource; 2]) -> CommandResult<[SidePart; 2]> {
        if self.whole && !sources.iter().any(ScanSource::is_dataset) {
            let what = "--whole: no effect, for no side is a dataset, whose labels tell the object; leave it away";
            return Err(UsageError(what.into()).into());
        }
        let mask_of = |path: &Option<PathBuf>| path.as_deref().map(mask).transpose();
        let [sim, real] = [mask_of(&self.sim_mask)?, mask_of(&self.mask)?];
        let [is_sim, is_real] = sources.each_ref().map(|source| source.is_dataset() && !self.whole);
        Ok([
            SidePart { region: self.sim_region, mask: sim, object: is_sim },
            SidePart { region: self.region, mask: real, object: is_real },
        ])
    }
}

/// A scan, cut to what counts.
pub(super) struct CountedScan {
    /// The scan, or its region.
    pub maps: ScanMaps,
    /// Pixels of that which don't count, `[rows, cols]`; `None` where all do.
    pub ignored: Option<Vec<bool>>,
    /// Whether labels told the object.
    pub is_object: bool,
}

impl SidePart {
    /// Scan `i` of a source.
    pub(super) fn scan(&self, source: &ScanSource, i: usize) -> Result<CountedScan, Fault> {
        let (mut maps, object) = if self.object { source.object(i)? } else { (source.frame(i)?, None) };
        let is_object = object.is_some();
        // A scan without heights is a frame of the sensor alone.
        let ignored = if maps.range.is_empty() { None } else { maps.cut_to(object, self.region, self.mask.as_ref())? };
        Ok(CountedScan { maps, ignored, is_object })
    }

    /// In words; `is_object` is whether labels told the object.
    pub(super) fn words(&self, is_object: bool) -> String {
        let parts = [(is_object, "object"), (self.region.is_some(), "region"), (self.mask.is_some(), "mask")];
        let parts: Vec<&str> = parts.into_iter().filter(|(is_there, _)| *is_there).map(|(_, word)| word).collect();
        match parts.is_empty() {
            true if self.object => "all: it has no labels".into(),
            true => "all".into(),
            false => parts.join(" in "),
        }
    }
}

/// The mask in a picture.
pub(in crate::cli) fn mask(path: &Path) -> Result<ScanMask, Fault> {
    let remedy = "give a grey PNG of the scan's size, black where nothing counts";
    let bytes = files::read_or_standard_input(path, MAX_MASK_BYTES)
        .map_err(|e| Fault::at(path, format!("it cannot be read: {e}"), remedy))?;
    let picture = image::load_from_memory_with_format(&bytes, image::ImageFormat::Png)
        .map_err(|e| Fault::at(path, format!("it is no PNG that can be read: {e}"), remedy))?;
    let grey = picture.to_luma16();
    let counts: Vec<bool> = grey.pixels().map(|pixel| pixel.0[0] > 0).collect();
    if !counts.contains(&true) {
        return Err(Fault::at(path, "all of it is black: nothing counts", remedy));
    }
    Ok(ScanMask { cols: grey.width() as usize, rows: grey.height() as usize, counts })
}
