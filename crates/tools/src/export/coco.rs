//! COCO: pictures and one document for each split, with boxes and masks of every object.
//!
//! ```text
//! annotations/instances_<split>.json    images/<split>/<index>.png
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use clap::{Args, ValueEnum};
use output_schema::DatasetHead;
use serde_json::{Map, Value, json};

use super::classes::{Category, categories};
use super::export_folder::{ExportFolder, ExportSummary, GrowingFile, of_split};
use super::format::{Export, ExportFormat};
use super::map_scale::MapScales;
use super::picture::TrainingPicture;
use super::picture_options::{PictureContent, PictureOptions};
use super::run_length::RunLengthMask;
use super::sample::{ExportSample, Region};
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
}

/// Whether the mask of an object includes the objects within it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MaskExtent {
    // Its own and those of all that lies in it: a pocket with its defects, as `objects` of the dataset counts.
    Whole,
    // Its own alone: masks of one picture never overlap.
    Own,
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
        let classes = categories(source.head());
        if classes.is_empty() {
            let what = format!("its subject `{}` has no classes to tell apart", source.head().subject);
            return Err(Fault::at(source.root(), what, "export it as png or webdataset"));
        }
        let asked = json!({
            "image": self.pictures.image.name(), "bits": if self.is_stored() { 16 } else { 8 },
            "mask": if self.mask == MaskExtent::Whole { "whole" } else { "own" }, "plain": self.plain_rle,
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
                annotations(sample, &classes, self)
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
    let category =
        |class: &Category| json!({"id": class.value, "name": class.name, "supercategory": class.supercategory});
    json!({
        "info": {
            "description": head.recipe.name, "version": "1.0", "contributor": "sheetlight",
            "dataset": source.told(), "recipe_hash": head.recipe.hash,
            "rows_grow": "along the scan; seen from above pictures are mirrored top to bottom",
            "scaling": scaling,
        },
        "licenses": [],
        "categories": classes.iter().map(category).collect::<Vec<_>>(),
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

/// The objects of a sample, each with its mask from the instance image.
fn annotations(sample: &ExportSample, classes: &[Category], options: &Coco) -> Result<Vec<Value>, Fault> {
    let objects = sample.objects()?;
    let pixels = sample.grey("instance")?.numbers();
    let whole = |object: &Map<String, Value>, name: &str| whole(object, name).map_err(|what| sample.fault(what));
    let outer = outer(&objects).map_err(|what| sample.fault(what))?;
    let is_listed = |n: u16| outer.get(usize::from(n)).is_some_and(Option::is_some);
    if let Some(stray) = pixels.iter().find(|n| **n > 0 && !is_listed(**n)) {
        return Err(sample.fault(format!("the instance image shows {stray}, which `objects` does not list")));
    }
    let mut found = Vec::new();
    for object in objects {
        let number = whole(object, "instance")?;
        let members = |own: bool| -> Vec<bool> {
            let mut members = vec![false; outer.len()];
            for (n, outer) in outer.iter().enumerate() {
                // What it lies in has a smaller number, and is known.
                members[n] = n as u64 == number || !own && outer.is_some_and(|outer| members[usize::from(outer)]);
            }
            members
        };
        let bbox = bounding_box(object).filter(|found| {
            let ends = [found.left + found.cols, found.top + found.rows];
            ends.into_iter().zip([sample.cols, sample.rows]).all(|(end, side)| end <= side)
        });
        let bbox = bbox.ok_or_else(|| sample.fault(format!("the box of instance {number} is not in the image")))?;
        let mask = |members: &[bool]| {
            let set = |row: usize, col: usize| members[usize::from(pixels[row * sample.cols + col])];
            (tight(bbox, &set), RunLengthMask::of(sample.rows, sample.cols, bbox, set))
        };
        let (mut tight, mut runs) = mask(&members(false));
        if tight != bbox || runs.area() != whole(object, "area_px")? {
            return Err(sample.fault(format!("instance {number} is not where `objects` says")));
        }
        if options.mask == MaskExtent::Own {
            (tight, runs) = mask(&members(true));
            if runs.area() == 0 {
                continue;
            }
        }
        let class = whole(object, "class")?;
        if !classes.iter().any(|known| known.value as u64 == class) {
            return Err(sample.fault(format!("instance {number} is of class {class}, which has no objects")));
        }
        found.push(annotation(sample, object, class, tight, &runs, options.plain_rle));
    }
    Ok(found)
}

fn whole(object: &Map<String, Value>, name: &str) -> Result<u64, String> {
    let number = object.get(name).and_then(Value::as_u64);
    number.ok_or_else(|| format!("`objects.{name}` is missing or negative"))
}

/// What each instance lies in, by number: 0 for none, and nothing for numbers that no object has. Whatever an instance
/// lies in has a smaller number.
fn outer(objects: &[&Map<String, Value>]) -> Result<Vec<Option<u16>>, String> {
    let mut found = vec![None];
    for object in objects {
        let [number, outer] = [whole(object, "instance")?, whole(object, "within")?];
        // As instance images count.
        let Some((n, lies_in)) = u16::try_from(number).ok().zip(u16::try_from(outer).ok()).filter(|(n, _)| *n > 0)
        else {
            return Err(format!(
                "`objects` lists instance {number} within {outer}; instances have the numbers 1 to 65535"
            ));
        };
        let n = usize::from(n);
        let is_listed = |n: usize| found.get(n).is_some_and(Option::is_some);
        if outer >= number || outer > 0 && !is_listed(usize::from(lies_in)) || is_listed(n) {
            return Err(format!("`objects` lists instance {number} within {outer}"));
        }
        found.resize(found.len().max(n + 1), None);
        found[n] = Some(lies_in);
    }
    Ok(found)
}

fn annotation(
    sample: &ExportSample,
    object: &Map<String, Value>,
    class: u64,
    bbox: Region,
    runs: &RunLengthMask,
    plain: bool,
) -> Value {
    let counts = if plain { json!(runs.counts()) } else { json!(runs.packed()) };
    let mut attributes = object.clone();
    attributes.shift_remove("bbox");
    for name in ["class", "state"] {
        let class = object.get(name).and_then(Value::as_u64).unwrap_or(u64::MAX);
        attributes.insert(name.into(), sample.pixel_class(class).into());
    }
    json!({
        "id": 0, "image_id": sample.index, "category_id": class, "bbox": [bbox.left, bbox.top, bbox.cols, bbox.rows],
            "area": runs.area(),
        "segmentation": {"size": [sample.rows, sample.cols], "counts": counts}, "iscrowd": 0,
        "attributes": attributes,
    })
}

/// The box of an object, which the dataset keeps as first column, first row, columns, rows.
fn bounding_box(object: &Map<String, Value>) -> Option<Region> {
    let sides = object.get("bbox")?.as_array()?.iter().map(|side| side.as_u64().map(|side| side as usize));
    let [left, top, cols, rows] = sides.collect::<Option<Vec<_>>>()?.try_into().ok()?;
    Some(Region { top, left, rows, cols })
}

/// The smallest box around what is set in a box; empty where nothing is.
fn tight(within: Region, set: &impl Fn(usize, usize) -> bool) -> Region {
    let Region { top, left, rows, cols } = within;
    let col = |col: &usize| (top..top + rows).any(|row| set(row, *col));
    let row = |row: &usize| (left..left + cols).any(|col| set(*row, col));
    let ends = |mut at: std::ops::Range<usize>, is: &dyn Fn(&usize) -> bool| {
        let first = at.find(|n| is(n))?;
        Some((first, at.rfind(|n| is(n)).unwrap_or(first) + 1 - first))
    };
    match (ends(left..left + cols, &col), ends(top..top + rows, &row)) {
        (Some((left, cols)), Some((top, rows))) => Region { top, left, rows, cols },
        _ => Region { rows: 0, cols: 0, ..within },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(pairs: &[[u64; 2]]) -> Result<Vec<Option<u16>>, String> {
        let object = |[number, within]: &[u64; 2]| json!({"instance": number, "within": within});
        let objects: Vec<Value> = pairs.iter().map(object).collect();
        outer(&objects.iter().filter_map(Value::as_object).collect::<Vec<_>>())
    }

    /// Numbers that no instance image can hold are faults, however large, and never sizes.
    #[test]
    fn instances_are_what_images_can_hold() {
        assert_eq!(found(&[[1, 0], [3, 1]]), Ok(vec![None, Some(0), None, Some(1)]));
        assert_eq!(found(&[[65535, 0]]).map(|outer| outer.len()), Ok(65536));
        for wrong in [[0, 0], [65536, 0], [1 << 40, 0], [u64::MAX, 0]] {
            assert!(found(&[wrong]).is_err_and(|what| what.contains("1 to 65535")), "{wrong:?}");
        }
        for wrong in [&[[2, 2]][..], &[[2, 1]], &[[1, 0], [1, 0]], &[[1, 0], [2, 3], [3, 0]]] {
            assert!(found(wrong).is_err(), "{wrong:?}");
        }
    }
}
