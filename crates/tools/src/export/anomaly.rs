//! Folders for anomaly detection: which pictures and parts of pictures are good, and where they go.
//!
//! Samples to learn from go to `good` where they are good and nowhere else: such methods learn from good ones alone.
//! Those of `test` go to the folder of their defect.

use std::collections::BTreeMap;
use std::path::Path;

use clap::Args;
use serde_json::json;

use super::classes::{folder_name, good};
use super::export_folder::{ExportFolder, ExportSummary};
use super::map_scale::MapScales;
use super::picture::TrainingPicture;
use super::picture_options::PictureOptions;
use super::sample::{ExportSample, Region};
use super::source::{ExportProgress, ExportSource};
use dataset::{Fault, Grey, write_png};
use optical_bench::split::Split;

/// Folder of pictures with defects of several classes, as MVTec AD names it.
const COMBINED_FOLDER: &str = "combined";

// Options of exports for anomaly detection; a documentation comment would become the help of each of them.
#[derive(Debug, Args)]
pub(super) struct AnomalyOptions {
    #[command(flatten)]
    pub pictures: PictureOptions,
    /// Pixel classes that count as good [default: clear of wood, flange and pocket of packs; none of others]
    #[arg(long, value_name = "CLASS", value_delimiter = ',')]
    good: Vec<String>,
    /// Cut pictures into square patches of this side, good or not by their own pixels
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(8..=65536))]
    patch_px: Option<u32>,
}

/// A layout of such folders.
#[derive(Debug, Clone, Copy)]
pub(super) struct AnomalyLayout {
    /// Name of the format.
    pub name: &'static str,
    /// The splits that it has folders for.
    pub splits: &'static [Split],
    /// Images that it needs beside those of pictures and labels.
    pub images: &'static [&'static str],
    /// Writes the files of a part.
    pub put: fn(&ExportFolder, &AnomalyPart) -> Result<(), Fault>,
}

/// A picture or a patch of one, and where it belongs.
#[derive(Debug)]
pub(super) struct AnomalyPart<'a> {
    pub sample: &'a ExportSample<'a>,
    picture: &'a TrainingPicture,
    labels: &'a [u8],
    good: &'a [bool; 256],
    pub region: Region,
    pub split: Split,
    /// `good`, or the class of its defects.
    pub folder: &'a str,
    /// Name of its files.
    pub name: &'a str,
}

impl AnomalyPart<'_> {
    /// The part of the picture.
    pub fn picture(&self) -> TrainingPicture {
        self.picture.cut(self.region)
    }

    /// 255 where its labels are not good, as PNG.
    pub fn mask(&self) -> Vec<u8> {
        let Region { top, left, rows, cols } = self.region;
        let line = |row: usize| &self.labels[row * self.sample.cols + left..][..cols];
        let pixels = (top..top + rows).flat_map(line);
        let pixels = pixels.map(|label| if self.good[usize::from(*label)] { 0 } else { 255 }).collect();
        write_png(&Grey::Eight(pixels), cols)
    }
}

/// Writes such an export.
///
/// # Errors
/// As [`super::format::Export::write`].
pub(super) fn write(
    layout: AnomalyLayout,
    options: &AnomalyOptions,
    source: &ExportSource,
    out: &Path,
    progress: ExportProgress,
) -> Result<ExportSummary, Fault> {
    let head = source.head();
    let AnomalyOptions { pictures, good: given, patch_px } = options;
    let images = [pictures.image.maps(), layout.images, &["label"]].concat();
    let good = good(head, given)?;
    source.needs(&images)?;
    let least = head.images.cols.min(head.images.rows);
    if let Some(side) = patch_px.filter(|side| u64::from(*side) > least) {
        let what = format!("{side} px is larger than the images of {} x {} px", head.images.cols, head.images.rows);
        return Err(Fault::at("--patch-px".as_ref(), what, format!("give up to {least}")));
    }
    has_splits(source)?;
    let order = json!({
        "image": pictures.image.name(), "good": given, "patch_px": patch_px,
        "range": pictures.range_ends, "scatter": pictures.scatter_ends,
    });
    ExportFolder::write(out, layout.name, order, source, |out| {
        let scalings = MapScales::of(source, pictures, progress);
        let scalings = scalings.map_err(|e| out.withdrawn(e))?;
        let mut counts: BTreeMap<String, u64> = BTreeMap::new();
        let mut left_out = 0;
        let work = |sample: &ExportSample| put_parts(sample, &out, layout, *patch_px, &scalings, &good);
        let take = |_: &ExportSample, folders: Vec<Option<String>>| {
            for folder in folders {
                match folder {
                    Some(folder) => *counts.entry(folder).or_default() += 1,
                    None => left_out += 1,
                }
            }
            Ok(())
        };
        source.each(&images, work, take, progress)?;
        let learnt = learnt(layout, source);
        if counts.is_empty() {
            let what = format!(
                "there is nothing to write: all {left_out} pictures are of {learnt} and have defects, and methods \
                 learn from good ones"
            );
            let remedy = "try --patch-px, --good, --split all or more samples";
            return Err(out.withdrawn(Fault::at(source.root(), what, remedy)));
        }
        let notes = notes(layout, source, left_out, &counts);
        let good: Vec<&str> =
            head.shown_classes().filter(|(value, _)| good[value & 255]).map(|(_, name)| name).collect();
        let scaling = scalings.json(head.range_unit());
        out.finish(&json!({"pictures": counts, "left_out": left_out, "good": good, "scaling": scaling}), notes)
    })
}

/// The splits that are learnt from and asked for, in words.
fn learnt(layout: AnomalyLayout, source: &ExportSource) -> String {
    let names: Vec<&str> =
        asked(layout.splits, source).filter(|split| *split != Split::Test).map(Split::name).collect();
    format!("the {} {}", if names.len() == 1 { "split" } else { "splits" }, names.join(" and "))
}

/// Those of some splits that are asked for.
fn asked(splits: &[Split], source: &ExportSource) -> impl Iterator<Item = Split> {
    splits.iter().copied().filter(|split| source.selection.has_split(split.name()))
}

/// Refuses where a split that is asked for has no samples: its folder would be missing, and whoever learns or judges
/// with the export would find out there. One of them alone is made where it alone is asked for.
fn has_splits(source: &ExportSource) -> Result<(), Fault> {
    let Some(missing) = asked(&[Split::Train, Split::Test], source).find(|split| source.in_split(*split) == 0) else {
        return Ok(());
    };
    let other = if missing == Split::Train { Split::Test } else { Split::Train };
    let more = match (source.selection.indices.is_empty(), source.unfinished) {
        (false, _) => "give another --index",
        (true, 0) => "make more samples, or give the split a larger share in the recipe's `splits`",
        (true, _) => "run gen again to finish the dataset",
    };
    let (name, other) = (missing.name(), other.name());
    let what = format!("the split {name} has no samples, and the export would have no folder `{name}`");
    Err(Fault::at(source.root(), what, format!("{more}; --split {other} exports `{other}` alone")))
}

/// What the user should know: pictures and samples that are left out, and folders without a picture.
fn notes(layout: AnomalyLayout, source: &ExportSource, left_out: u64, counts: &BTreeMap<String, u64>) -> Vec<String> {
    let mut notes = Vec::new();
    if left_out > 0 {
        notes.push(format!(
            "{left_out} pictures with defects of {} are left out: methods learn from good ones",
            learnt(layout, source)
        ));
    }
    for name in asked(layout.splits, source).map(Split::name) {
        if !counts.contains_key(&format!("{name}/good")) {
            notes.push(format!(
                "{name}/good is empty: no picture of that split is good; try --patch-px, --good or more samples"
            ));
        }
        if name == "test" && counts.keys().all(|folder| !folder.starts_with("test/") || folder == "test/good") {
            notes.push("test has no defects: no picture of that split shows one; make more samples".into());
        }
    }
    let validation = source.in_split(Split::Validation);
    if validation > 0 && !layout.splits.contains(&Split::Validation) && asked(layout.splits, source).count() == 2 {
        let samples = if validation == 1 { "sample" } else { "samples" };
        notes
            .push(format!("{validation} {samples} of the split validation left out: the layout has no place for them"));
    }
    notes
}

/// Writes the parts of a sample; gives the folder of each, none for those that are left out.
fn put_parts(
    sample: &ExportSample,
    out: &ExportFolder,
    layout: AnomalyLayout,
    patch_px: Option<u32>,
    scalings: &MapScales,
    good: &[bool; 256],
) -> Result<Vec<Option<String>>, Fault> {
    let Grey::Eight(labels) = sample.grey("label")? else { return Err(sample.fault("`label` has 16 bits")) };
    let picture = TrainingPicture::of(sample, scalings)?;
    let mut folders = Vec::new();
    for region in parts(sample, patch_px.map(|side| side as usize)) {
        let Region { top, left, rows, cols } = region;
        let line = |row: usize| &labels[row * sample.cols + left..][..cols];
        let mut seen = [false; 256];
        (top..top + rows).flat_map(line).for_each(|label| seen[usize::from(*label)] = true);
        let mut defects = (0..256).filter(|value| seen[*value] && !good[*value]);
        let folder = match (defects.next(), defects.next()) {
            (None, _) => "good",
            (Some(one), None) => folder_name(sample.pixel_class(one as u64))?,
            _ => COMBINED_FOLDER,
        };
        if sample.split != Split::Test && folder != "good" {
            folders.push(None);
            continue;
        }
        let name = match patch_px {
            Some(_) => format!("{}_r{top:05}_c{left:05}", sample.key),
            None => sample.key.clone(),
        };
        let split = sample.split;
        let (picture, labels) = (&picture, labels.as_slice());
        let part = AnomalyPart { sample, picture, labels, good, region, split, folder, name: &name };
        (layout.put)(out, &part)?;
        folders.push(Some(format!("{}/{folder}", split.name())));
    }
    Ok(folders)
}

/// The parts of a picture. Patches cover all of it, evenly apart, and overlap where its sides are no multiples of
/// theirs.
fn parts(sample: &ExportSample, patch_px: Option<usize>) -> Vec<Region> {
    let Some(side) = patch_px else { return vec![Region { top: 0, left: 0, rows: sample.rows, cols: sample.cols }] };
    let starts = |length: usize| {
        let count = length.div_ceil(side);
        let start = move |i: usize| if count > 1 { i * (length - side) / (count - 1) } else { 0 };
        (0..count).map(start)
    };
    let patch = |top: usize| starts(sample.cols).map(move |left| Region { top, left, rows: side, cols: side });
    starts(sample.rows).flat_map(patch).collect()
}
