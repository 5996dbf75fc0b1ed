//! `gen export`: a dataset in other people's formats.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Subcommand, ValueEnum};

use super::check::Part;
use super::generate::threads;
use super::progress::{Things, bytes, counted, say};
use super::{Outcome, Usage};
use crate::export::{ExportError, Progress, Selection, Show, Source, Summary, coco, icon, mvtec, png, webdataset};
use crate::record::Split;

/// Formats with their options.
#[derive(Debug, Subcommand)]
#[command(after_help = "Examples:
  gen export coco planks --out planks-coco                     boxes and masks, 8-bit pictures
  gen export mvtec packs --out packs-mvtec --patch-px 256      folders for anomaly detection
  gen export webdataset planks --out tars --tar-mb 1000        tars for training that streams
  gen export png planks --out pngs --colour --index 0-19       pictures, as stored, of 20 samples
  gen export icon planks --out scans --index 3                 files of the real camera

A stopped export is finished by the same command. docs/export.md describes every file.")]
pub(super) enum Format {
    /// COCO instances: pictures, boxes, run-length masks, one document for each split
    Coco(Coco),
    /// Folders as MVTec AD has them: train/good, test/good, test/<defect>, ground_truth/<defect>
    Mvtec(Mvtec),
    /// WebDataset tars: every map as PNG and every number as JSON
    Webdataset(Webdataset),
    /// Folders of PNG files as they are stored, and the rows as lines of JSON
    Png(Png),
    /// Files of the real camera (iCon .dat and .xml), one pair for each sample
    Icon(Icon),
}

#[derive(Debug, Args)]
pub(super) struct Common {
    /// Folder of the dataset
    dir: PathBuf,
    /// Folder of the export: a new or empty one, or that of the same export, stopped
    #[arg(long, value_name = "OUT")]
    out: PathBuf,
    /// Part of the dataset
    #[arg(long, value_enum, default_value_t = Part::All)]
    split: Part,
    /// Samples by number: 3, 0-99, or several: 0-99,205 [default: all]
    #[arg(long, value_name = "I", value_delimiter = ',', value_parser = indices)]
    index: Vec<RangeInclusive<u64>>,
    /// Threads [default: all cores]
    #[arg(long, value_name = "T")]
    threads: Option<usize>,
}

#[derive(Debug, Args)]
pub(super) struct Pictures {
    /// What pictures show; rgb is Range, Reflectance and Scatter as red, green and blue
    #[arg(long, value_enum, default_value_t = Image::Reflectance)]
    image: Image,
    /// Heights (or sensor rows) at the ends of 8 bits [default: from 64 samples of the dataset]
    #[arg(long, value_name = "LOW,HIGH", value_parser = ends, allow_hyphen_values = true)]
    range_ends: Option<[f64; 2]>,
    /// Scatter at the ends of 8 bits, in DN [default: from 64 samples of the dataset]
    #[arg(long, value_name = "LOW,HIGH", value_parser = ends)]
    scatter_ends: Option<[f64; 2]>,
}

#[derive(Debug, Args)]
pub(super) struct Coco {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    pictures: Pictures,
    /// 16 writes one map as it is stored instead of scaling it to 8 bits
    #[arg(long, default_value = "8", value_parser = ["8", "16"])]
    bits: String,
    /// Pixels of an object that others lie in: with them, or its own alone
    #[arg(long, value_enum, default_value_t = Mask::Whole)]
    mask: Mask,
    /// Masks as lists of run lengths instead of packed strings
    #[arg(long)]
    plain_rle: bool,
}

#[derive(Debug, Args)]
pub(super) struct Mvtec {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    pictures: Pictures,
    /// Pixel classes that count as good [default: clear of wood, flange and pocket of packs]
    #[arg(long, value_name = "CLASS", value_delimiter = ',')]
    good: Vec<String>,
    /// Cut pictures into square patches of this side, good or not by their own pixels
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(8..=65536))]
    patch_px: Option<u32>,
}

#[derive(Debug, Args)]
pub(super) struct Webdataset {
    #[command(flatten)]
    common: Common,
    /// Maps [default: all that the dataset has]
    #[arg(long, value_enum, value_delimiter = ',')]
    maps: Vec<Map>,
    /// Largest tar, in MB; a sample that is larger has one for itself
    #[arg(long, value_name = "MB", default_value_t = 500, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    tar_mb: u64,
}

#[derive(Debug, Args)]
pub(super) struct Png {
    #[command(flatten)]
    common: Common,
    /// Maps [default: all that the dataset has]
    #[arg(long, value_enum, value_delimiter = ',')]
    maps: Vec<Map>,
    /// Labels as coloured pictures too
    #[arg(long)]
    colour: bool,
}

#[derive(Debug, Args)]
pub(super) struct Icon {
    #[command(flatten)]
    common: Common,
    /// Heights as WORD instead of FLOAT
    #[arg(long)]
    words: bool,
    /// Profiles a second, for the timestamps in Mark
    #[arg(long, value_name = "HZ", default_value_t = 1000.0, value_parser = rate)]
    rate: f64,
    /// The middle sensor frame of each sample instead of its scan
    #[arg(long, conflicts_with = "words")]
    sensor: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Image {
    Reflectance,
    Scatter,
    Range,
    Rgb,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Mask {
    Whole,
    Own,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Map {
    Range,
    Reflectance,
    Scatter,
    Label,
    Instance,
}

impl Pictures {
    fn show(&self) -> Show {
        match self.image {
            Image::Reflectance => Show::Reflectance,
            Image::Scatter => Show::Scatter,
            Image::Range => Show::Range,
            Image::Rgb => Show::Rgb,
        }
    }
}

pub(super) fn run(format: &Format) -> Outcome {
    let common = match format {
        Format::Coco(Coco { common, .. })
        | Format::Mvtec(Mvtec { common, .. })
        | Format::Webdataset(Webdataset { common, .. })
        | Format::Png(Png { common, .. })
        | Format::Icon(Icon { common, .. }) => common,
    };
    let splits = match (format, common.split.split()) {
        (Format::Mvtec(_), None) => vec![Split::Train, Split::Test],
        (Format::Mvtec(_), Some(Split::Validation)) => {
            return Err(Usage("the layout has no folder for validation: give --split train, test or all".into()).into());
        }
        (_, split) => split.into_iter().collect(),
    };
    let within = |place: &Path| std::path::absolute(place).ok().zip(common.dir.canonicalize().ok());
    if let Some((out, dir)) = within(&common.out)
        && out.ancestors().any(|folder| folder.canonicalize().is_ok_and(|folder| folder == dir))
    {
        let what = "it lies in the dataset, where nothing else may lie; choose a folder elsewhere";
        return Err(Usage(format!("--out {}: {what}", common.out.display())).into());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads(common.threads)?).build()?;
    let source = Source::open(&common.dir, Selection { splits, indices: common.index.clone() })?;
    if source.unfinished > 0 {
        say(&format!("not finished and left out: {} of the dataset", counted(source.unfinished, "shard")));
    }
    let bar = Things::new("samples");
    let summary = pool.install(|| write(format, &source, &common.out, &|done, all| bar.show(done, all)));
    bar.end();
    let summary = summary?;
    let out = common.out.display();
    for note in &summary.notes {
        say(&format!("note: {note}"));
    }
    say(&match summary.nothing_to_do {
        true => format!("{out} is finished already; there is nothing to do"),
        false => format!(
            "{out}: {} of {}, {}",
            counted(summary.files, "file"),
            counted(source.samples, "sample"),
            bytes(summary.bytes)
        ),
    });
    Ok(ExitCode::SUCCESS)
}

fn write(format: &Format, source: &Source, out: &Path, progress: Progress) -> Result<Summary, ExportError> {
    match format {
        Format::Coco(coco) => {
            let options = coco::Options {
                show: coco.pictures.show(),
                stored: coco.bits == "16",
                mask: match coco.mask {
                    Mask::Whole => coco::Mask::Whole,
                    Mask::Own => coco::Mask::Own,
                },
                plain: coco.plain_rle,
                range: coco.pictures.range_ends,
                scatter: coco.pictures.scatter_ends,
            };
            coco::export(source, out, &options, progress)
        }
        Format::Mvtec(mvtec) => {
            let options = mvtec::Options {
                show: mvtec.pictures.show(),
                good: mvtec.good.clone(),
                patch_px: mvtec.patch_px.map(|side| side as usize),
                range: mvtec.pictures.range_ends,
                scatter: mvtec.pictures.scatter_ends,
            };
            mvtec::export(source, out, &options, progress)
        }
        Format::Webdataset(tars) => {
            let options = webdataset::Options { maps: names(&tars.maps), most_bytes: tars.tar_mb * 1_000_000 };
            webdataset::export(source, out, &options, progress)
        }
        Format::Png(png) => {
            png::export(source, out, &png::Options { maps: names(&png.maps), colour: png.colour }, progress)
        }
        Format::Icon(icon) => {
            let options = icon::Options { words: icon.words, rate: icon.rate, sensor: icon.sensor };
            icon::export(source, out, &options, progress)
        }
    }
}

fn names(maps: &[Map]) -> Vec<String> {
    let name = |map: &Map| map.to_possible_value().map(|value| value.get_name().to_owned());
    maps.iter().filter_map(name).collect()
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
    let numbers: Vec<f64> = text.split(',').filter_map(|number| number.trim().parse().ok()).collect();
    match numbers[..] {
        [low, high] if low < high && low.is_finite() && high.is_finite() => Ok([low, high]),
        _ => Err(format!("'{text}' is not LOW,HIGH, for instance 10,30")),
    }
}

/// A number of profiles a second.
fn rate(text: &str) -> Result<f64, String> {
    let rate: f64 = text.parse().map_err(|_| "it is no number".to_owned())?;
    if (0.001..=1e6).contains(&rate) { Ok(rate) } else { Err("give 0.001 to 1000000 Hz".into()) }
}
