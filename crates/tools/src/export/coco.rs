//! COCO: pictures and one document for each split, with boxes and masks of every object.
//!
//! ```text
//! annotations/instances_<split>.json    images/<split>/<index>.png
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use clap::Args;
use output_schema::DatasetHead;
use serde_json::{Map, Value, json};

use super::classes::Category;
use super::export_folder::{ExportFolder, ExportSummary, GrowingFile, of_split};
use super::format::{Export, ExportFormat};
use super::map_scale::MapScales;
use super::objects::{MaskExtent, MaskedObject, each_object, object_categories};
use super::picture::TrainingPicture;
use super::picture_options::{PictureContent, PictureOptions};
use super::polygon::{Polygon, PolygonParts, polygons};
use super::run_length::RunLengthMask;
use super::sample::ExportSample;
use super::source::{ExportProgress, ExportSource};
use dataset::Fault;
use optical_bench::split::Split;

pub(super) const FORMAT: ExportFormat =
    ExportFormat::of::<Coco>("coco", "COCO", ["coco planks --out planks-coco", "boxes and masks, 8-bit pictures"]);

/// COCO instances: pictures, boxes, run-length masks, one document for each split
#[derive(Debug, Args)]
struct Coco {
    #[command(flatten)]
    pictures: PictureOptions,
    /// 16 writes one map as it is stored instead of scaling it to 8 bits
    #[arg(long, default_value = "8", value_parser = ["8", "16"])]
    bits: String,
    /// Pixels of an object that others lie in: with them, or its own alone
    #[arg(long, value_enum, default_value_t = MaskExtent::Whole)]
    mask: MaskExtent,
    /// Masks as lists of run lengths instead of packed strings
    #[arg(long)]
    plain_rle: bool,
    /// Masks as polygons instead of run lengths: one for each part of an object, with bridges to its holes
    #[arg(long, conflicts_with = "plain_rle")]
    polygons: bool,
}

/// Annotations and images of one split while they grow.
struct CocoDocument {
    images: GrowingFile,
    annotations: GrowingFile,
    counts: [u64; 2],
}

impl Coco {
    /// Whether pictures are a map as it is stored, instead of 8 bits.
    fn is_stored(&self) -> bool {
        self.bits == "16"
    }
}

impl Export for Coco {
    fn check(&self) -> Result<(), String> {
        let PictureOptions { image, range_ends, scatter_ends } = self.pictures;
        if !self.is_stored() {
            return self.pictures.check();
        }
        if image == PictureContent::Rgb {
            let what =
                "--bits 16: colours of 16 bits are read by few; choose one map with --image, or leave --bits away";
            return Err(what.into());
        }
        if range_ends.is_some() || scatter_ends.is_some() {
            let what = "--bits 16 writes a map as it is stored, and ends have no effect; leave them or --bits away";
            return Err(what.into());
        }
        Ok(())
    }

    fn check_for(&self, head: &DatasetHead) -> Result<(), String> {
        let image = self.pictures.image;
        let is_light = matches!(image, PictureContent::Reflectance | PictureContent::Grey);
        if self.is_stored() && is_light && head.images.bits <= 8 {
            return Err(format!(
                "--bits 16 has no effect: the dataset stores {} with 8 bits; leave it away, or give another --image",
                image.name()
            ));
        }
        Ok(())
    }

    fn write(&self, source: &ExportSource, out: &Path, progress: ExportProgress) -> Result<ExportSummary, Fault> {
        let maps = self.pictures.image.maps();
        let images = [maps, &["instance"]].concat();
        source.needs(&images)?;
        let classes = object_categories(source)?;
        let asked = json!({
            "image": self.pictures.image.name(), "bits": if self.is_stored() { 16 } else { 8 },
            "mask": self.mask.name(), "plain": self.plain_rle, "polygons": self.polygons,
            "range": self.pictures.range_ends, "scatter": self.pictures.scatter_ends,
        });
        ExportFolder::write(out, FORMAT.name, asked, source, |out| {
            let found = || MapScales::of(source, &self.pictures, progress);
            let scalings = (!self.is_stored()).then(found).transpose().map_err(|e| out.withdrawn(e))?;
            let scaling = scalings.as_ref().map_or(Value::Null, |scalings| scalings.json(source.head().range_unit()));
            let head = header(source, &classes, &scaling);
            let mut documents: BTreeMap<Split, CocoDocument> = BTreeMap::new();
            let work = |sample: &ExportSample| {
                out.put(&format!("images/{}/{}.png", sample.split.name(), sample.key), || match &scalings {
                    Some(scalings) => Ok(TrainingPicture::of(sample, scalings)?.png()),
                    None => sample.png(maps[0]),
                })?;
                each_object(sample, &classes, self.mask, |object| annotation(sample, object, self))
            };
            let take = |sample: &ExportSample, annotations: Vec<Value>| {
                let begin = || CocoDocument::begin(&out, sample.split, &head);
                of_split(&mut documents, sample.split, begin)?.push(sample, annotations)
            };
            source.each(&images, work, take, progress)?;
            let mut counted = Map::new();
            for (split, document) in documents {
                let [images, annotations] = document.counts;
                counted.insert(split.name().into(), json!({"images": images, "annotations": annotations}));
                document.finish(&out)?;
            }
            out.finish(&json!({"splits": counted, "scaling": scaling}), Vec::new())
        })
    }
}

/// What comes before the images of every document.
fn header(source: &ExportSource, classes: &[Category], scaling: &Value) -> Value {
    let head = source.head();
    // Tools count from 1 without gaps; labels of pixels have gaps.
    let category = |(i, class): (usize, &Category)| {
        let Category { value, name, supercategory } = class;
        json!({"id": i + 1, "name": name, "supercategory": supercategory, "label_value": value})
    };
    json!({
        "info": {
            "description": head.recipe.name, "version": "1.0", "contributor": "sheetlight",
            "dataset": source.told(), "recipe_hash": head.recipe.hash,
            "rows_grow": "along the scan; seen from above pictures are mirrored top to bottom",
            "scaling": scaling,
        },
        "licenses": [],
        "categories": classes.iter().enumerate().map(category).collect::<Vec<_>>(),
    })
}

impl CocoDocument {
    fn begin(out: &ExportFolder, split: Split, head: &Value) -> Result<Self, Fault> {
        let name = format!("annotations/instances_{}", split.name());
        let mut images = out.create(&format!("{name}.json"))?;
        let head = head.to_string();
        images.push(head.strip_suffix('}').unwrap_or(&head).as_bytes())?;
        images.push(b",\n\"images\":[")?;
        Ok(Self { images, annotations: out.create(&format!("{name}.part"))?, counts: [0, 0] })
    }

    fn push(&mut self, sample: &ExportSample, annotations: Vec<Value>) -> Result<(), Fault> {
        let entry = image(sample)?;
        self.images.push(format!("{}\n{entry}", if self.counts[0] == 0 { "" } else { "," }).as_bytes())?;
        self.counts[0] += 1;
        for mut annotation in annotations {
            let comma = if self.counts[1] == 0 { "" } else { "," };
            self.counts[1] += 1;
            // Tools take 0 for no annotation.
            annotation["id"] = self.counts[1].into();
            self.annotations.push(format!("{comma}\n{annotation}").as_bytes())?;
        }
        Ok(())
    }

    fn finish(self, out: &ExportFolder) -> Result<(), Fault> {
        let Self { mut images, annotations, .. } = self;
        images.push(b"],\n\"annotations\":[")?;
        images.append(annotations)?;
        images.push(b"]}\n")?;
        out.finish_file(images)
    }
}

/// The entry of an image: the keys that COCO defines, and the identity of the sample.
fn image(sample: &ExportSample) -> Result<Value, Fault> {
    let mut entry = json!({
        "id": sample.index, "file_name": format!("{}.png", sample.key), "width": sample.cols, "height": sample.rows,
    });
    for key in ["id", "index", "seed", "split", "col_mm", "row_mm"] {
        let name = if key == "id" { "sample_id" } else { key };
        entry[name] = sample.row.values.get(key).cloned().unwrap_or_default();
    }
    for (key, value) in &sample.row.values {
        if key.starts_with("range_offset_") || key.starts_with("range_scale_") {
            entry[key] = value.clone();
        }
    }
    entry["sample_class"] = sample.class.clone().into();
    for tags in ["defect_classes", "unseen_classes"] {
        if let Some(classes) = sample.row.values.get(tags) {
            entry[tags] = classes.clone();
        }
    }
    Ok(entry)
}

/// An object as COCO writes it; its `id` is given where documents grow.
fn annotation(sample: &ExportSample, object: &MaskedObject, options: &Coco) -> Value {
    let MaskedObject { entry, category, bbox, .. } = object;
    let runs = RunLengthMask::of(sample.rows, sample.cols, *bbox, |row, col| object.is_set(row, col));
    let run_lengths = |counts: Value| json!({"size": [sample.rows, sample.cols], "counts": counts});
    let segmentation = match (options.polygons, options.plain_rle) {
        (true, _) => json!(polygons(object, PolygonParts::Apart).iter().map(Polygon::numbers).collect::<Vec<_>>()),
        (false, true) => run_lengths(json!(runs.counts())),
        (false, false) => run_lengths(json!(runs.packed())),
    };
    let mut attributes = (*entry).clone();
    attributes.shift_remove("bbox");
    for name in ["class", "state"] {
        let class = entry.get(name).and_then(Value::as_u64).unwrap_or(u64::MAX);
        attributes.insert(name.into(), sample.pixel_class(class).into());
    }
    json!({
        "id": 0, "image_id": sample.index, "category_id": category + 1,
        "bbox": [bbox.left, bbox.top, bbox.cols, bbox.rows], "area": runs.area(), "segmentation": segmentation,
        "iscrowd": 0, "attributes": attributes,
    })
}
