//! COCO: pictures and one document for each split, with boxes and masks of every object.
//!
//! ```text
//! annotations/instances_<split>.json    images/<split>/<index>.png
//! ```

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::classes::categories;
use super::out::Growing;
use super::picture::Picture;
use super::{ExportError, Out, Progress, Runs, Sample, Scalings, Show, Source, Summary};
use crate::record::Split;

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
        let what = format!("its subject `{}` has no objects to annotate", source.head().subject);
        return Err(ExportError::at(source.root(), what, "export it as png or webdataset"));
    }
    let asked = json!({
        "image": options.show.name(), "bits": if options.stored { 16 } else { 8 },
        "mask": if options.mask == Mask::Whole { "whole" } else { "own" }, "plain": options.plain,
        "range": options.range, "scatter": options.scatter,
    });
    let Some(out) = Out::open(out, "coco", asked, source.told())? else {
        return Ok(Summary { nothing_to_do: true, ..Summary::default() });
    };
    let scalings = match options.stored {
        true => None,
        false => Some(Scalings::of(source, maps, options.range, options.scatter)?),
    };
    let scaling = scalings.map_or(Value::Null, |scalings| scalings.json(maps, source.head().range_unit()));
    let head = header(source, &classes, &scaling);
    let mut documents: BTreeMap<Split, Document> = BTreeMap::new();
    let work = |sample: &Sample| {
        out.put(&format!("images/{}/{}.png", sample.split.name(), sample.key), || match scalings {
            Some(scalings) => Ok(Picture::of(sample, options.show, &scalings)?.png()),
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

/// The objects of a sample, each with its mask from the instance image.
fn annotations(
    sample: &Sample,
    classes: &[(usize, &str, &'static str)],
    options: &Options,
) -> Result<Vec<Value>, ExportError> {
    let objects = sample.objects()?;
    let pixels = sample.grey("instance")?.numbers();
    let whole = |object: &Map<String, Value>, name: &str| {
        let number = object.get(name).and_then(Value::as_u64);
        number.ok_or_else(|| sample.fault(format!("`objects.{name}` is missing or negative")))
    };
    // What each instance lies in; 0 for none, and nothing for numbers that no object has.
    let mut within: BTreeMap<u64, u64> = BTreeMap::new();
    for object in &objects {
        let [number, outer] = [whole(object, "instance")?, whole(object, "within")?];
        if outer >= number || outer > 0 && !within.contains_key(&outer) || within.insert(number, outer).is_some() {
            return Err(sample.fault(format!("`objects` lists instance {number} within {outer}")));
        }
    }
    if let Some(stray) = pixels.iter().find(|n| **n > 0 && !within.contains_key(&u64::from(**n))) {
        return Err(sample.fault(format!("the instance image shows {stray}, which `objects` does not list")));
    }
    let most = within.keys().max().copied().unwrap_or(0) as usize;
    let mut found = Vec::new();
    for object in objects {
        let number = whole(object, "instance")?;
        let lies_in = |mut inner: u64| {
            while inner > number {
                inner = within.get(&inner).copied().unwrap_or(0);
            }
            inner == number
        };
        let members = |own: bool| -> Vec<bool> {
            (0..=most as u64).map(|n| if own { n == number } else { within.contains_key(&n) && lies_in(n) }).collect()
        };
        let bbox = bbox(object).filter(|[left, top, width, height]| {
            [left + width, top + height].into_iter().zip([sample.cols, sample.rows]).all(|(end, side)| end <= side)
        });
        let bbox = bbox.ok_or_else(|| sample.fault(format!("the box of instance {number} is not in the image")))?;
        let mask = |members: &[bool]| {
            let set = |row: usize, col: usize| members[usize::from(pixels[row * sample.cols + col])];
            (tight(bbox, &set), Runs::of(sample.rows, sample.cols, bbox, set))
        };
        let (mut tight, mut runs) = mask(&members(false));
        if tight != bbox || runs.area() != whole(object, "area_px")? {
            return Err(sample.fault(format!("instance {number} is not where `objects` says")));
        }
        if options.mask == Mask::Own {
            (tight, runs) = mask(&members(true));
            if runs.area() == 0 {
                continue;
            }
        }
        let class = whole(object, "class")?;
        if !classes.iter().any(|(value, ..)| *value as u64 == class) {
            return Err(sample.fault(format!("instance {number} is of class {class}, which has no objects")));
        }
        found.push(annotation(sample, object, class, tight, &runs, options.plain));
    }
    Ok(found)
}

fn annotation(
    sample: &Sample,
    object: &Map<String, Value>,
    class: u64,
    bbox: [usize; 4],
    runs: &Runs,
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
        "id": 0, "image_id": sample.index, "category_id": class, "bbox": bbox, "area": runs.area(),
        "segmentation": {"size": [sample.rows, sample.cols], "counts": counts}, "iscrowd": 0,
        "attributes": attributes,
    })
}

/// First column, first row, columns, rows.
fn bbox(object: &Map<String, Value>) -> Option<[usize; 4]> {
    let sides = object.get("bbox")?.as_array()?.iter().map(|side| side.as_u64().map(|side| side as usize));
    sides.collect::<Option<Vec<_>>>()?.try_into().ok()
}

/// The smallest box around what is set in a box; empty where nothing is.
fn tight([left, top, width, height]: [usize; 4], set: &impl Fn(usize, usize) -> bool) -> [usize; 4] {
    let col = |col: &usize| (top..top + height).any(|row| set(row, *col));
    let row = |row: &usize| (left..left + width).any(|col| set(*row, col));
    let ends = |mut at: std::ops::Range<usize>, is: &dyn Fn(&usize) -> bool| {
        let first = at.find(|n| is(n))?;
        Some((first, at.rfind(|n| is(n)).unwrap_or(first) + 1 - first))
    };
    match (ends(left..left + width, &col), ends(top..top + height, &row)) {
        (Some((left, width)), Some((top, height))) => [left, top, width, height],
        _ => [left, top, 0, 0],
    }
}
