//! COCO: pictures and one document for each split, with boxes and masks of every object.
//!
//! ```text
//! annotations/instances_<split>.json    images/<split>/<index>.png
//! ```

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::annotation::annotations;
use super::classes::categories;
use super::out::Growing;
use super::picture::Picture;
use super::{ExportError, Out, Progress, Sample, Scalings, Show, Source, Summary};
use crate::split::Split;

/// Which pixels the mask of an object holds that others lie in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mask {
    /// Its own and those of all that lies in it: a pocket with its defects, as `objects` of the dataset counts.
    Whole,
    /// Its own alone: masks of one picture never overlap.
    Own,
}

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// What pictures show.
    pub show: Show,
    /// One map as it is stored, with up to 16 bits, instead of 8 bits.
    pub stored: bool,
    /// What masks hold.
    pub mask: Mask,
    /// Masks as lists of lengths instead of packed strings.
    pub plain: bool,
    /// Ends of the scale of Range; found where there are none [mm or px].
    pub range: Option<[f64; 2]>,
    /// Ends of the scale of Scatter; found where there are none [DN].
    pub scatter: Option<[f64; 2]>,
}

/// Annotations and images of one split while they grow.
struct Document {
    images: Growing,
    annotations: Growing,
    counts: [u64; 2],
}

/// Writes the export.
///
/// # Errors
/// Where the dataset is damaged or lacks images, or the folder cannot be written.
pub fn export(
    source: &Source,
    out: &std::path::Path,
    options: &Options,
    progress: Progress,
) -> Result<Summary, ExportError> {
    let maps = options.show.maps();
    if options.stored && options.show == Show::Rgb {
        let what = "colours of 16 bits are read by few";
        return Err(ExportError::at("--bits 16".as_ref(), what, "choose one map with --image, or leave --bits away"));
    }
    let images = [maps, &["instance"]].concat();
    source.needs(&images)?;
    let classes = categories(source.head());
    if classes.is_empty() {
        let what = format!("its subject `{}` has no classes to tell apart", source.head().subject);
        return Err(ExportError::at(source.root(), what, "export it as png or webdataset"));
    }
    let asked = json!({
        "image": options.show.name(), "bits": if options.stored { 16 } else { 8 },
        "mask": if options.mask == Mask::Whole { "whole" } else { "own" }, "plain": options.plain,
        "range": options.range, "scatter": options.scatter,
    });
    Out::write(out, "coco", asked, source, |out| {
        let found = || Scalings::of(source, maps, options.range, options.scatter, progress);
        let scalings = (!options.stored).then(found).transpose().map_err(|e| out.withdrawn(e))?;
        let scaling = scalings.as_ref().map_or(Value::Null, |scalings| scalings.json(source.head().range_unit()));
        let head = header(source, &classes, &scaling);
        let mut documents: BTreeMap<Split, Document> = BTreeMap::new();
        let work = |sample: &Sample| {
            out.put(&format!("images/{}/{}.png", sample.split.name(), sample.key), || match &scalings {
                Some(scalings) => Ok(Picture::of(sample, scalings)?.png()),
                None => sample.png(maps[0]),
            })?;
            annotations(sample, &classes, options)
        };
        let take = |sample: &Sample, annotations: Vec<Value>| {
            let document = match documents.entry(sample.split) {
                std::collections::btree_map::Entry::Occupied(entry) => entry.into_mut(),
                std::collections::btree_map::Entry::Vacant(entry) => {
                    entry.insert(Document::begin(&out, sample.split, &head)?)
                }
            };
            document.push(sample, annotations)
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

/// What comes before the images of every document.
fn header(source: &Source, classes: &[(usize, &str, &'static str)], scaling: &Value) -> Value {
    let head = source.head();
    let category =
        |(value, name, kind): &(usize, &str, &'static str)| json!({"id": value, "name": name, "supercategory": kind});
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

impl Document {
    fn begin(out: &Out, split: Split, head: &Value) -> Result<Self, ExportError> {
        let name = format!("annotations/instances_{}", split.name());
        let mut images = out.create(&format!("{name}.json"))?;
        let head = head.to_string();
        images.push(head.strip_suffix('}').unwrap_or(&head).as_bytes())?;
        images.push(b",\n\"images\":[")?;
        Ok(Self { images, annotations: out.create(&format!("{name}.part"))?, counts: [0, 0] })
    }

    fn push(&mut self, sample: &Sample, annotations: Vec<Value>) -> Result<(), ExportError> {
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

    fn finish(self, out: &Out) -> Result<(), ExportError> {
        let Self { mut images, annotations, .. } = self;
        images.push(b"],\n\"annotations\":[")?;
        images.append(annotations)?;
        images.push(b"]}\n")?;
        out.finish_file(images)
    }
}

/// The entry of an image: what COCO asks for, and who the sample is.
fn image(sample: &Sample) -> Result<Value, ExportError> {
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
    entry["defect_classes"] = sample.row.values.get("defect_classes").cloned().unwrap_or_default();
    Ok(entry)
}
