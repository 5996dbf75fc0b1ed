//! The options of `gen export`, how their values are read, and which of them do not go together.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use crate::cli::check::SplitChoice;
use crate::cli::{output, whole};
use tools::export::{GivenEnds, PictureContent};

/// Formats with their options.
#[derive(Debug, Subcommand)]
#[command(after_help = "Examples:
  gen export coco planks --out planks-coco                     boxes and masks, 8-bit pictures
  gen export mvtec packs --out packs-mvtec --patch-px 256      folders for anomaly detection
  gen export webdataset planks --out tars --tar-mb 1000        tars for training that streams
  gen export png planks --out pngs --colour --index 0-19       pictures, as stored, of 20 samples
  gen export icon planks --out scans --index 3                 files of the real camera
  gen export png planks --out pngs --json | jq .files          what was written, for programs

A stopped export is finished by the same command. docs/guide/export.md describes every file, and the
fields of the JSON.")]
pub(in crate::cli) enum ExportCommand {
    /// COCO instances: pictures, boxes, run-length masks, one document for each split
    Coco(CocoArgs),
    /// Folders as MVTec AD has them: train/good, test/good, test/<defect>, ground_truth/<defect>
    Mvtec(MvtecArgs),
    /// WebDataset tars: every map as PNG and every number as JSON
    Webdataset(WebdatasetArgs),
    /// Folders of PNG files as they are stored, and the rows as lines of JSON
    Png(PngArgs),
    /// Files of the real camera (iCon .dat and .xml), one pair for each sample
    Icon(ExportIconArgs),
}

#[derive(Debug, Args)]
pub(in crate::cli) struct ExportArgs {
    /// Folder of the dataset
    pub(super) dir: PathBuf,
    /// Folder of the export: a new or empty one, or that of the same export, stopped
    #[arg(short, long, value_name = "OUT", value_parser = output::folder())]
    pub(super) out: PathBuf,
    /// Part of the dataset
    #[arg(long, value_enum, default_value_t = SplitChoice::All)]
    pub(super) split: SplitChoice,
    /// Samples by number: 3, 0-99, or several: 0-99,205 [default: all]
    #[arg(long, value_name = "I", value_delimiter = ',', value_parser = indices)]
    pub(super) index: Vec<RangeInclusive<u64>>,
    /// Threads [default: all cores]
    #[arg(short = 'j', long, value_name = "T", value_parser = whole::<usize>)]
    pub(super) threads: Option<usize>,
    /// Print what was written as JSON
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Debug, Args)]
pub(super) struct PictureArgs {
    /// What pictures show; rgb is Range, Reflectance and Scatter as red, green and blue
    #[arg(long, value_enum, default_value_t = ImageChoice::Reflectance)]
    pub(super) image: ImageChoice,
    /// Heights (or sensor rows) at the ends of 8 bits [default: from 64 samples of the dataset]
    #[arg(long, value_name = "LOW,HIGH", value_parser = ends, allow_hyphen_values = true)]
    pub(super) range_ends: Option<[f64; 2]>,
    /// Scatter at the ends of 8 bits, in DN [default: from 64 samples of the dataset]
    #[arg(long, value_name = "LOW,HIGH", value_parser = ends)]
    pub(super) scatter_ends: Option<[f64; 2]>,
}

#[derive(Debug, Args)]
pub(in crate::cli) struct CocoArgs {
    #[command(flatten)]
    pub(super) common: ExportArgs,
    #[command(flatten)]
    pub(super) pictures: PictureArgs,
    /// 16 writes one map as it is stored instead of scaling it to 8 bits
    #[arg(long, default_value = "8", value_parser = ["8", "16"])]
    pub(super) bits: String,
    /// Pixels of an object that others lie in: with them, or its own alone
    #[arg(long, value_enum, default_value_t = MaskChoice::Whole)]
    pub(super) mask: MaskChoice,
    /// Masks as lists of run lengths instead of packed strings
    #[arg(long)]
    pub(super) plain_rle: bool,
}

#[derive(Debug, Args)]
pub(in crate::cli) struct MvtecArgs {
    #[command(flatten)]
    pub(super) common: ExportArgs,
    #[command(flatten)]
    pub(super) pictures: PictureArgs,
    /// Pixel classes that count as good [default: clear of wood, flange and pocket of packs; none of others]
    #[arg(long, value_name = "CLASS", value_delimiter = ',')]
    pub(super) good: Vec<String>,
    /// Cut pictures into square patches of this side, good or not by their own pixels
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(8..=65536))]
    pub(super) patch_px: Option<u32>,
}

#[derive(Debug, Args)]
pub(in crate::cli) struct WebdatasetArgs {
    #[command(flatten)]
    pub(super) common: ExportArgs,
    /// Maps [default: all that the dataset has]
    #[arg(long, value_enum, value_delimiter = ',')]
    pub(super) maps: Vec<MapChoice>,
    /// Largest tar, in MB; a sample that is larger has one for itself
    #[arg(long, value_name = "MB", default_value_t = 500, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub(super) tar_mb: u64,
}

#[derive(Debug, Args)]
pub(in crate::cli) struct PngArgs {
    #[command(flatten)]
    pub(super) common: ExportArgs,
    /// Maps [default: all that the dataset has]
    #[arg(long, value_enum, value_delimiter = ',')]
    pub(super) maps: Vec<MapChoice>,
    /// Labels as coloured pictures too
    #[arg(long)]
    pub(super) colour: bool,
}

#[derive(Debug, Args)]
pub(in crate::cli) struct ExportIconArgs {
    #[command(flatten)]
    pub(super) common: ExportArgs,
    /// Heights as WORD instead of FLOAT
    #[arg(long)]
    pub(super) words: bool,
    /// Profiles a second, for the timestamps in Mark [default: 1000]
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub(super) rate: Option<f64>,
    /// The middle sensor frame of each sample instead of its scan
    #[arg(long)]
    pub(super) sensor: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum ImageChoice {
    Reflectance,
    Scatter,
    Range,
    Rgb,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum MaskChoice {
    Whole,
    Own,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum MapChoice {
    Range,
    Reflectance,
    Scatter,
    Label,
    Instance,
}

impl ExportCommand {
    /// Its word on the command line.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Coco(_) => "coco",
            Self::Mvtec(_) => "mvtec",
            Self::Webdataset(_) => "webdataset",
            Self::Png(_) => "png",
            Self::Icon(_) => "icon",
        }
    }

    /// What every format takes.
    pub(super) fn common(&self) -> &ExportArgs {
        match self {
            Self::Coco(CocoArgs { common, .. })
            | Self::Mvtec(MvtecArgs { common, .. })
            | Self::Webdataset(WebdatasetArgs { common, .. })
            | Self::Png(PngArgs { common, .. })
            | Self::Icon(ExportIconArgs { common, .. }) => common,
        }
    }

    /// Why an option would have no effect, and what to do.
    pub(super) fn without_effect(&self) -> Option<&'static str> {
        match self {
            Self::Coco(CocoArgs { pictures, bits, .. }) if bits == "16" => pictures.without_effect_as_stored(),
            Self::Coco(CocoArgs { pictures, .. }) | Self::Mvtec(MvtecArgs { pictures, .. }) => {
                pictures.without_effect()
            }
            Self::Icon(ExportIconArgs { sensor: true, words: true, .. }) => {
                Some("--words is of the heights of scans, and --sensor writes sensor frames; leave one of them away")
            }
            Self::Icon(ExportIconArgs { sensor: true, rate: Some(_), .. }) => {
                Some("--rate is of the marks of scans, and --sensor writes sensor frames; leave one of them away")
            }
            Self::Webdataset(_) | Self::Png(_) | Self::Icon(_) => None,
        }
    }
}

impl PictureArgs {
    /// The ends of grey scales that were given.
    pub(super) fn ends(&self) -> GivenEnds {
        GivenEnds { range: self.range_ends, scatter: self.scatter_ends }
    }

    pub(super) fn show(&self) -> PictureContent {
        match self.image {
            ImageChoice::Reflectance => PictureContent::Reflectance,
            ImageChoice::Scatter => PictureContent::Scatter,
            ImageChoice::Range => PictureContent::Range,
            ImageChoice::Rgb => PictureContent::Rgb,
        }
    }

    fn without_effect(&self) -> Option<&'static str> {
        let shown = self.show().maps();
        if self.range_ends.is_some() && !shown.contains(&"range") {
            return Some("--range-ends has no effect without --image range or rgb; give one of them, or leave it away");
        }
        if self.scatter_ends.is_some() && !shown.contains(&"scatter") {
            return Some(
                "--scatter-ends has no effect without --image scatter or rgb; give one of them, or leave it away",
            );
        }
        None
    }

    fn without_effect_as_stored(&self) -> Option<&'static str> {
        if self.show() == PictureContent::Rgb {
            return Some(
                "--bits 16: colours of 16 bits are read by few; choose one map with --image, or leave --bits away",
            );
        }
        if self.range_ends.is_some() || self.scatter_ends.is_some() {
            return Some("--bits 16 writes a map as it is stored, and ends have no effect; leave them or --bits away");
        }
        None
    }
}

/// Numbers of samples: one, or from one to another.
fn indices(text: &str) -> Result<RangeInclusive<u64>, String> {
    let wrong = || format!("'{text}' is neither a number nor FIRST-LAST, for instance 0-99");
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let (first, last): (u64, u64) = (first.parse().map_err(|_| wrong())?, last.parse().map_err(|_| wrong())?);
    if first <= last { Ok(first..=last) } else { Err(wrong()) }
}

/// Two numbers, the lower first.
fn ends(text: &str) -> Result<[f64; 2], String> {
    let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    let ends = text.split_once(',').and_then(|(low, high)| Some([number(low)?, number(high)?]));
    ends.filter(|[low, high]| low < high).ok_or_else(|| format!("'{text}' is not LOW,HIGH, for instance 10,30"))
}

/// A number of profiles a second.
fn rate(text: &str) -> Result<f64, String> {
    let rate: f64 = text.parse().map_err(|_| "it is no number".to_owned())?;
    if (0.001..=1e6).contains(&rate) { Ok(rate) } else { Err("give 0.001 to 1000000 Hz".into()) }
}
