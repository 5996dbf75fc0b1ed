//! What the command line states of files of bare numbers, and whether it has an effect.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::cli::console::Console;
use crate::cli::{CommandResult, UsageError};
use tools::compare::{CountScale, CsvForm, MissingNumber, ScanSource, StatedScale};

#[derive(Debug, Args)]
#[command(next_help_heading = "Files of bare numbers (.png, .tif, .csv, .ply)")]
pub(in crate::cli) struct ScaleArgs {
    /// What one count of Range is, in mm; 1 where the numbers are mm already
    #[arg(long, value_name = "MM", value_parser = positive, conflicts_with_all = ["um_per_count", "px_per_count"])]
    mm_per_count: Option<f64>,
    /// The same in um
    #[arg(long, value_name = "UM", value_parser = positive, conflicts_with = "px_per_count")]
    um_per_count: Option<f64>,
    /// The same in sensor rows, for scans that are not calibrated
    #[arg(long, value_name = "PX", value_parser = positive)]
    px_per_count: Option<f64>,
    /// Added to heights after that [mm, or px with --px-per-count; default: 0]
    #[arg(long, value_name = "N", value_parser = finite)]
    offset: Option<f64>,
    /// Number of Range that stands for a missing height, or none; needed for whole numbers, beside NaN for others
    #[arg(long, value_name = "N|none", value_parser = missing)]
    missing: Option<MissingNumber>,
    /// Distance between two columns, in mm [default: of points that of their grid; else unknown]
    #[arg(long, value_name = "MM", value_parser = positive)]
    col_mm: Option<f64>,
    /// Distance between two profiles, in mm [default: of points that of their grid; else unknown]
    #[arg(long, value_name = "MM", value_parser = positive)]
    row_mm: Option<f64>,
    /// Bits of the camera's digital numbers; needed for Reflectance and Scatter in files of more than 8 bits
    #[arg(long, value_name = "BITS", value_parser = clap::value_parser!(u64).range(8..=16))]
    bits: Option<u64>,
    /// Columns of a cloud of points that is stored profile by profile, missing points too
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    cols: Option<u32>,
    /// What the lines of a CSV file are: profiles of a grid, or points x, y, z [default: what its header says]
    #[arg(long, value_enum)]
    csv: Option<CsvChoice>,
    /// Reflectance of the side that is one file of Range, on the same grid
    #[arg(long, value_name = "FILE")]
    reflectance: Option<PathBuf>,
    /// Scatter of that side
    #[arg(long, value_name = "FILE")]
    scatter: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum CsvChoice {
    Grid,
    Points,
}

impl ScaleArgs {
    /// What is stated of Range and digital numbers.
    pub(in crate::cli) fn stated(&self) -> StatedScale {
        let mm = self.mm_per_count.or(self.um_per_count.map(|um| um * 1e-3)).map(CountScale::Mm);
        StatedScale {
            count: mm.or(self.px_per_count.map(CountScale::Px)),
            offset: self.offset,
            missing: self.missing,
            col_mm: self.col_mm,
            row_mm: self.row_mm,
            bits: self.bits,
            cols: self.cols.map(|cols| cols as usize),
            csv: self.csv.map(|csv| match csv {
                CsvChoice::Grid => CsvForm::Grid,
                CsvChoice::Points => CsvForm::Points,
            }),
        }
    }

    /// Gives the side that is one map its other maps; refuses what has no effect, and says where one scale holds for
    /// both sides.
    pub(in crate::cli) fn apply(
        &self,
        stated: &StatedScale,
        sides: &mut [ScanSource],
        console: &Console,
    ) -> CommandResult<()> {
        let forms: Vec<_> = sides.iter().map(ScanSource::stated_forms).collect();
        if let Some(what) = stated.without_effect(&forms.concat()) {
            return Err(UsageError(what).into());
        }
        if forms.len() > 1 && forms.iter().all(|forms| !forms.is_empty()) && *stated != StatedScale::default() {
            console.note("note: all sides are files of bare numbers, and what is stated of their scale holds for each");
        }
        let option = if self.reflectance.is_some() { "--reflectance" } else { "--scatter" };
        if self.reflectance.is_some() || self.scatter.is_some() {
            match sides.iter_mut().filter(|side| side.takes_light()).collect::<Vec<_>>().as_mut_slice() {
                [side] => side.give_light(self.reflectance.as_deref(), self.scatter.as_deref())?,
                [] => {
                    let what = "no effect, for no side is one file of Range (.png, .tif, .csv); leave it away";
                    return Err(UsageError(format!("{option}: {what}")).into());
                }
                _ => {
                    let what = "several sides are one file of Range; name them NAME.range.png and \
                        NAME.reflectance.png, so that each has \
                                its own";
                    return Err(UsageError(format!("{option}: {what}")).into());
                }
            }
        }
        Ok(())
    }
}

fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| "give a number, for instance -12.5".into())
}

fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|number| *number > 0.0).ok_or_else(|| "give a number above 0, for instance 0.005".into())
}

fn missing(text: &str) -> Result<MissingNumber, String> {
    if text == "none" {
        return Ok(MissingNumber::None);
    }
    finite(text).map(MissingNumber::Number).map_err(|_| "give a number such as 0, or none".into())
}
