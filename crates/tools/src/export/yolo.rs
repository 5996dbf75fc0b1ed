//! YOLO: pictures, a text of labels beside each, and a document that names splits and classes.
//!
//! ```text
//! data.yaml    images/<split>/<index>.png    labels/<split>/<index>.txt
//! ```
//!
//! A line of labels is an object: its class from 0 on, then centre and size of its box, or x and y of the vertices of
//! one polygon, all in widths and heights of the picture. A picture without objects has an empty text.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use clap::{Args, ValueEnum};
use serde_json::json;

use super::classes::Category;
use super::export_folder::{ExportFolder, ExportSummary};
use super::format::{Export, ExportFormat};
use super::map_scale::MapScales;
use super::objects::{MaskExtent, MaskedObject, each_object, object_categories};
use super::picture::TrainingPicture;
use super::picture_options::PictureOptions;
use super::polygon::{PolygonParts, polygons};
use super::sample::{ExportSample, Region};
use super::source::{ExportProgress, ExportSource};
use dataset::Fault;
use optical_bench::split::Split;

pub(super) const FORMAT: ExportFormat =
    ExportFormat::of::<Yolo>("yolo", "YOLO", ["yolo planks --out planks-yolo", "polygons as text, 8-bit pictures"]);

/// Folders as Ultralytics trains from: pictures of 8 bits, labels as text, data.yaml
#[derive(Debug, Args)]
struct Yolo {
    #[command(flatten)]
    pictures: PictureOptions,
    /// What labels are: boxes, or polygons
    #[arg(long, value_enum, default_value_t = LabelTask::Segment)]
    task: LabelTask,
    /// Pixels of an object that others lie in: with them, or its own alone
    #[arg(long, value_enum, default_value_t = MaskExtent::Whole)]
    mask: MaskExtent,
}

/// What a network learns from labels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LabelTask {
    // Boxes.
    Detect,
    // Polygons.
    Segment,
}

impl LabelTask {
    fn name(self) -> &'static str {
        match self {
            Self::Detect => "detect",
            Self::Segment => "segment",
        }
    }
}

impl Export for Yolo {
    fn check(&self) -> Result<(), String> {
        self.pictures.check()
    }

    fn write(&self, source: &ExportSource, out: &Path, progress: ExportProgress) -> Result<ExportSummary, Fault> {
        let images = [self.pictures.image.maps(), &["instance"]].concat();
        source.needs(&images)?;
        let classes = object_categories(source)?;
        let asked = json!({
            "image": self.pictures.image.name(), "task": self.task.name(), "mask": self.mask.name(),
            "range": self.pictures.range_ends, "scatter": self.pictures.scatter_ends,
        });
        ExportFolder::write(out, FORMAT.name, asked, source, |out| {
            let scalings = MapScales::of(source, &self.pictures, progress).map_err(|e| out.withdrawn(e))?;
            let mut counts: BTreeMap<Split, [u64; 2]> = BTreeMap::new();
            let work = |sample: &ExportSample| {
                let (split, key) = (sample.split.name(), &sample.key);
                out.put(&format!("images/{split}/{key}.png"), || Ok(TrainingPicture::of(sample, &scalings)?.png()))?;
                let lines = each_object(sample, &classes, self.mask, |object| line(sample, object, self.task))?;
                out.put(&format!("labels/{split}/{key}.txt"), || Ok(lines.concat().into_bytes()))?;
                Ok(lines.len() as u64)
            };
            let take = |sample: &ExportSample, objects: u64| {
                let [images, all] = counts.entry(sample.split).or_default();
                (*images, *all) = (*images + 1, *all + objects);
                Ok(())
            };
            source.each(&images, work, take, progress)?;
            out.put("data.yaml", || Ok(document(&counts, &classes).into_bytes()))?;
            let count = |(split, [images, objects]): (&Split, &[u64; 2])| {
                (split.name().to_owned(), json!({"images": images, "objects": objects}))
            };
            let splits: serde_json::Map<_, _> = counts.iter().map(count).collect();
            let scaling = scalings.json(source.head().range_unit());
            let names: Vec<&str> = classes.iter().map(|class| class.name).collect();
            out.finish(&json!({"splits": splits, "names": names, "scaling": scaling}), notes(&counts))
        })
    }
}

/// The line of an object.
fn line(sample: &ExportSample, object: &MaskedObject, task: LabelTask) -> String {
    let (width, height) = (sample.cols as f64, sample.rows as f64);
    let mut line = object.category.to_string();
    let mut push = |[x, y]: [f64; 2]| {
        // Words that are written to memory are written.
        let _ = write!(line, " {:.7} {:.7}", x / width, y / height);
    };
    match task {
        LabelTask::Detect => {
            let Region { top, left, rows, cols } = object.bbox;
            let [left, top, cols, rows] = [left, top, cols, rows].map(|side| side as f64);
            push([left + cols / 2.0, top + rows / 2.0]);
            push([cols, rows]);
        }
        LabelTask::Segment => {
            polygons(object, PolygonParts::Bridged)
                .iter()
                .for_each(|one| one.vertices().iter().copied().for_each(&mut push));
        }
    }
    line.push('\n');
    line
}

/// `data.yaml`: folders of the splits, beside it, and the names of the classes.
fn document(counts: &BTreeMap<Split, [u64; 2]>, classes: &[Category]) -> String {
    let mut text = String::new();
    for split in counts.keys() {
        text += &format!("{}: images/{}\n", key(*split), split.name());
    }
    text += "names:\n";
    for (number, class) in classes.iter().enumerate() {
        // A string of JSON is one of YAML.
        text += &format!("  {number}: {}\n", json!(class.name));
    }
    text
}

/// What Ultralytics calls a split.
fn key(split: Split) -> &'static str {
    match split {
        Split::Validation => "val",
        other => other.name(),
    }
}

/// What Ultralytics would refuse.
fn notes(counts: &BTreeMap<Split, [u64; 2]>) -> Vec<String> {
    let missing = [Split::Train, Split::Validation].into_iter().filter(|split| !counts.contains_key(split));
    let note = |split: Split| {
        format!(
            "no sample of the split {} is exported: data.yaml has no `{}`, without which Ultralytics does not train",
            split.name(),
            key(split)
        )
    };
    missing.map(note).collect()
}
