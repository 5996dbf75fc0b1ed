//! The annotations of COCO: box, mask and fields of each object of a sample, held against its instance image.

use serde_json::{Map, Value, json};

use super::coco::{Mask, Options};
use super::{ExportError, Runs, Sample};

/// The objects of a sample, each with its mask from the instance image.
pub(super) fn annotations(
    sample: &Sample,
    classes: &[(usize, &str, &'static str)],
    options: &Options,
) -> Result<Vec<Value>, ExportError> {
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

fn whole(object: &Map<String, Value>, name: &str) -> Result<u64, String> {
    let number = object.get(name).and_then(Value::as_u64);
    number.ok_or_else(|| format!("`objects.{name}` is missing or negative"))
}

/// What each instance lies in, by number: 0 for none, and nothing for numbers that no object has. Whatever an instance lies
/// in has a smaller number.
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
