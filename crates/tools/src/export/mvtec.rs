//! MVTec AD layout: folders that programs for anomaly detection read.
//!
//! ```text
//! train/good/<name>.png    test/good/<name>.png    test/<defect>/<name>.png    ground_truth/<defect>/<name>_mask.png
//! ```
//!
//! Samples of the split `train` go to `train/good` where they are good and nowhere else: such methods learn from good
//! ones alone. Those of `test` go to `test`; `validation` has no place in the layout.

use std::collections::BTreeMap;
use std::path::Path;

use clap::Args;
use serde_json::json;

use super::classes::{folder_name, good};
use super::export_folder::{ExportFolder, ExportSummary};
use super::format::{Export, ExportFormat};
use super::map_scale::MapScales;
use super::picture::TrainingPicture;
use super::picture_options::PictureOptions;
use super::sample::{ExportSample, Region};
use super::source::{ExportProgress, ExportSource};
use dataset::{Fault, Grey, write_png};
use optical_bench::split::Split;

/// Folder of pictures with defects of several classes, as MVTec AD names it.
const COMBINED_FOLDER: &str = "combined";

pub(super) const FORMAT: ExportFormat = ExportFormat::of::<Mvtec>(
    "mvtec",
    "MVTec AD folders",
    ["mvtec packs --out packs-mvtec --patch-px 256", "folders for anomaly detection"],
);

/// Folders as MVTec AD has them: train/good, test/good, test/<defect>, ground_truth/<defect>
#[derive(Debug, Args)]
struct Mvtec {
    #[command(flatten)]
    pictures: PictureOptions,
    /// Pixel classes that count as good [default: clear of wood, flange and pocket of packs; none of others]
    #[arg(long, value_name = "CLASS", value_delimiter = ',')]
    good: Vec<String>,
    /// Cut pictures into square patches of this side, good or not by their own pixels
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(8..=65536))]
    patch_px: Option<u32>,
}

impl Export for Mvtec {
    fn splits(&self, given: Option<Split>) -> Result<Vec<Split>, String> {
        match given {
            None => Ok(vec![Split::Train, Split::Test]),
            Some(Split::Validation) => {
                Err("the layout has no folder for validation: give --split train, test or all".into())
            }
            Some(split) => Ok(vec![split]),
        }
    }

    fn check(&self) -> Result<(), String> {
        self.pictures.check()
    }

    fn write(&self, source: &ExportSource, out: &Path, progress: ExportProgress) -> Result<ExportSummary, Fault> {
        let head = source.head();
        let maps = self.pictures.image.maps();
        let images = [maps, &["label"]].concat();
        let good = good(head, &self.good)?;
        source.needs(&images)?;
        let least = head.images.cols.min(head.images.rows);
        if let Some(side) = self.patch_px.filter(|side| u64::from(*side) > least) {
            let what = format!("{side} px is larger than the images of {} x {} px", head.images.cols, head.images.rows);
            return Err(Fault::at("--patch-px".as_ref(), what, format!("give up to {least}")));
        }
        has_splits(source)?;
        let asked = json!({
            "image": self.pictures.image.name(), "good": self.good, "patch_px": self.patch_px,
            "range": self.pictures.range_ends, "scatter": self.pictures.scatter_ends,
        });
        ExportFolder::write(out, FORMAT.name, asked, source, |out| {
            let scalings = MapScales::of(source, &self.pictures, progress);
            let scalings = scalings.map_err(|e| out.withdrawn(e))?;
            let mut counts: BTreeMap<String, u64> = BTreeMap::new();
            let mut left_out = 0;
            let work = |sample: &ExportSample| pictures(sample, &out, self.patch_px, &scalings, &good);
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
            if counts.is_empty() {
                let what = format!(
                    "there is nothing to write: all {left_out} pictures are of the split train and have defects, and \
                        methods learn \
                 from good ones"
                );
                let remedy = "try --patch-px, --good, --split all or more samples";
                return Err(out.withdrawn(Fault::at(source.root(), what, remedy)));
            }
            let notes = notes(source, left_out, &counts);
            let good: Vec<&str> =
                head.shown_classes().filter(|(value, _)| good[value & 255]).map(|(_, name)| name).collect();
            let scaling = scalings.json(head.range_unit());
            out.finish(&json!({"pictures": counts, "left_out": left_out, "good": good, "scaling": scaling}), notes)
        })
    }
}

/// The splits of the layout that are asked for.
fn asked(source: &ExportSource) -> impl Iterator<Item = Split> {
    [Split::Train, Split::Test].into_iter().filter(|split| source.selection.has_split(split.name()))
}

/// Refuses where a split that is asked for has no samples: its folder would be missing, and whoever learns or judges
/// with the export would find out there. One of them alone is made where it alone is asked for.
fn has_splits(source: &ExportSource) -> Result<(), Fault> {
    let Some(missing) = asked(source).find(|split| source.in_split(*split) == 0) else { return Ok(()) };
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
fn notes(source: &ExportSource, left_out: u64, counts: &BTreeMap<String, u64>) -> Vec<String> {
    let mut notes = Vec::new();
    if left_out > 0 {
        notes.push(format!(
            "{left_out} pictures with defects of the split train are left out: methods learn from good ones"
        ));
    }
    for name in asked(source).map(Split::name) {
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
    if validation > 0 && asked(source).count() == 2 {
        let samples = if validation == 1 { "sample" } else { "samples" };
        notes
            .push(format!("{validation} {samples} of the split validation left out: the layout has no place for them"));
    }
    notes
}

/// Writes the pictures of a sample; gives the folder of each, none for those that are left out.
fn pictures(
    sample: &ExportSample,
    out: &ExportFolder,
    patch_px: Option<u32>,
    scalings: &MapScales,
    good: &[bool; 256],
) -> Result<Vec<Option<String>>, Fault> {
    let Grey::Eight(labels) = sample.grey("label")? else { return Err(sample.fault("`label` has 16 bits")) };
    let picture = TrainingPicture::of(sample, scalings)?;
    let mut folders = Vec::new();
    for part in parts(sample, patch_px.map(|side| side as usize)) {
        let Region { top, left, rows, cols } = part;
        let line = |row: usize| &labels[row * sample.cols + left..][..cols];
        let mut seen = [false; 256];
        (top..top + rows).flat_map(line).for_each(|label| seen[usize::from(*label)] = true);
        let mut defects = (0..256).filter(|value| seen[*value] && !good[*value]);
        let defect = match (defects.next(), defects.next()) {
            (None, _) => None,
            (Some(one), None) => Some(folder_name(sample.pixel_class(one as u64))?),
            _ => Some(COMBINED_FOLDER),
        };
        let name = match patch_px {
            Some(_) => format!("{}_r{top:05}_c{left:05}", sample.key),
            None => sample.key.clone(),
        };
        let folder = match (sample.split, defect) {
            (Split::Train, None) => "train/good".to_owned(),
            (Split::Test, defect) => format!("test/{}", defect.unwrap_or("good")),
            _ => {
                folders.push(None);
                continue;
            }
        };
        out.put(&format!("{folder}/{name}.png"), || Ok(picture.cut(part).png()))?;
        if let Some(defect) = defect {
            let mask = || {
                let pixels = (top..top + rows).flat_map(line);
                let pixels = pixels.map(|label| if good[usize::from(*label)] { 0 } else { 255 }).collect();
                Ok(write_png(&Grey::Eight(pixels), cols))
            };
            out.put(&format!("ground_truth/{defect}/{name}_mask.png"), mask)?;
        }
        folders.push(Some(folder));
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
