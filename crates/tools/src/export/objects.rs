//! Objects of a sample with their masks, from its instance image: what of a dataset formats with instances write.

use clap::ValueEnum;
use serde_json::{Map, Value};

use super::classes::{Category, categories};
use super::sample::{ExportSample, Region};
use super::source::ExportSource;
use dataset::Fault;

/// Whether the mask of an object includes the objects within it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum MaskExtent {
    // Its own and those of all that lies in it: a pocket with its defects, as `objects` of the dataset counts.
    Whole,
    // Its own alone: masks of one picture never overlap.
    Own,
}

impl MaskExtent {
    /// Name of the choice.
    pub fn name(self) -> &'static str {
        match self {
            Self::Whole => "whole",
            Self::Own => "own",
        }
    }
}

/// An object and its pixels.
#[derive(Debug)]
pub(super) struct MaskedObject<'a> {
    /// Its entry in `objects`.
    pub entry: &'a Map<String, Value>,
    /// Position of its class among the categories.
    pub category: usize,
    /// The smallest box around its pixels.
    pub bbox: Region,
    /// The instance image [rows, cols].
    pixels: &'a [u16],
    cols: usize,
    /// For each instance whether it belongs to the mask.
    members: &'a [bool],
}

impl MaskedObject<'_> {
    /// Whether a pixel of the image belongs to it.
    pub fn is_set(&self, row: usize, col: usize) -> bool {
        self.members[usize::from(self.pixels[row * self.cols + col])]
    }
}

/// The classes that have objects, where there are some.
///
/// # Errors
/// Where all objects of the dataset are of one kind, or its instance images are missing.
pub(super) fn object_categories(source: &ExportSource) -> Result<Vec<Category<'_>>, Fault> {
    source.needs(&["instance"])?;
    let classes = categories(source.head());
    if classes.is_empty() {
        let what = format!("its subject `{}` has no classes to tell apart", source.head().subject);
        return Err(Fault::at(source.root(), what, "export it as png or webdataset"));
    }
    Ok(classes)
}

/// Works on each object of a sample that has a pixel, in their order.
///
/// # Errors
/// Where `objects` and the instance image do not agree.
pub(super) fn each_object<T>(
    sample: &ExportSample,
    classes: &[Category],
    extent: MaskExtent,
    mut work: impl FnMut(&MaskedObject) -> T,
) -> Result<Vec<T>, Fault> {
    let objects = sample.objects()?;
    let pixels = sample.grey("instance")?.numbers();
    let whole = |entry: &Map<String, Value>, name: &str| whole(entry, name).map_err(|what| sample.fault(what));
    let outer = outer(&objects).map_err(|what| sample.fault(what))?;
    let is_listed = |n: u16| outer.get(usize::from(n)).is_some_and(Option::is_some);
    if let Some(stray) = pixels.iter().find(|n| **n > 0 && !is_listed(**n)) {
        return Err(sample.fault(format!("the instance image shows {stray}, which `objects` does not list")));
    }
    let mut found = Vec::new();
    for entry in objects {
        let number = whole(entry, "instance")?;
        let members = |own: bool| -> Vec<bool> {
            let mut members = vec![false; outer.len()];
            for (n, outer) in outer.iter().enumerate() {
                // What it lies in has a smaller number, and is known.
                members[n] = n as u64 == number || !own && outer.is_some_and(|outer| members[usize::from(outer)]);
            }
            members
        };
        let bbox = bounding_box(entry).filter(|found| {
            let ends = [found.left + found.cols, found.top + found.rows];
            ends.into_iter().zip([sample.cols, sample.rows]).all(|(end, side)| end <= side)
        });
        let bbox = bbox.ok_or_else(|| sample.fault(format!("the box of instance {number} is not in the image")))?;
        let class = whole(entry, "class")?;
        let category = classes.iter().position(|known| known.value as u64 == class);
        let category = category
            .ok_or_else(|| sample.fault(format!("instance {number} is of class {class}, which has no objects")))?;
        let all = members(false);
        let object = MaskedObject { entry, category, bbox, pixels: &pixels, cols: sample.cols, members: &all };
        let set = |row: usize, col: usize| object.is_set(row, col);
        let area = (bbox.top..bbox.top + bbox.rows)
            .map(|row| (bbox.left..bbox.left + bbox.cols).filter(|col| set(row, *col)).count() as u64);
        if tight(bbox, &set) != bbox || area.sum::<u64>() != whole(entry, "area_px")? {
            return Err(sample.fault(format!("instance {number} is not where `objects` says")));
        }
        if extent == MaskExtent::Whole {
            found.push(work(&object));
            continue;
        }
        let own = members(true);
        let object = MaskedObject { members: &own, ..object };
        let bbox = tight(bbox, &|row, col| object.is_set(row, col));
        if bbox.rows > 0 {
            found.push(work(&MaskedObject { bbox, ..object }));
        }
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
    use serde_json::json;

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
