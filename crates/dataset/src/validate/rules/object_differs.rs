//! The objects of a row against the images: numbers, order, boxes, areas, and the defects among them.

use std::collections::BTreeMap;

use base::Class;

use super::{Code, REMAKE_OR_REPORT, Rule, SampleToCheck, ValidationReport};
use crate::validate::columns::{StoredRow, in_range};

pub(super) const RULE: Rule = Rule {
    meaning: "An object's area or box is not what the instance image shows, an instance has no object, or \
        `defect_classes` is not what pixels show.",
    remedy: REMAKE_OR_REPORT,
};

/// Rounding in a sum of as many areas as an image has pixels [1].
const AREA: f64 = 1e-6;

/// Pixels and corners of one instance.
#[derive(Debug, Clone, Copy)]
struct LabelledRegion {
    area: i64,
    first: (usize, usize),
    last: (usize, usize),
}

/// Checks objects, their numbers and pixels.
pub(super) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    let (row, place) = (&sample.row, &sample.place);
    // The pixel classes that labels of the dataset's subject can show.
    let values = &sample.task.head.label_values;
    let turned = sample.task.head.recipe.canonical["motion"]["kind"] == "turntable";
    let mut fault = |code, what: String| report.fault(code, place, what);
    let (cols, rows) = (i64::from(row.cols), i64::from(row.rows));
    for object in &row.objects {
        let [x, y, width, height] = object.bbox.map(i64::from);
        let inside = x >= 0 && y >= 0 && width > 0 && height > 0 && x + width <= cols && y + height <= rows;
        let area = (1..=width.saturating_mul(height)).contains(&object.area_px);
        let known = [object.class, object.state].iter().all(|class| values.iter().any(|&v| i64::from(v) == *class));
        let nested = u16::try_from(object.instance).is_ok() && (0..object.instance).contains(&object.within);
        if !inside || !area || !known || !nested {
            let what = "is not inside the image, of no known class, of no number from 1 to 65535, or lies within none \
                before it";
            fault(Code::ValueRange, format!("object {object:?} {what}"));
        }
        for (name, value) in object.numbers.iter().filter(|(name, value)| !in_range(name, *value)) {
            fault(Code::ValueRange, format!("{name} of object {} is {value}", object.instance));
        }
        // On a turntable pixels are as large as their distance from the axis says.
        let even = object.area_px as f64 * row.row_mm * row.col_mm;
        let apart = (object.area_mm2 - even).abs();
        if !turned && apart > AREA * even.abs() {
            let said = format!("{} mm^2 and {} pixels", object.area_mm2, object.area_px);
            fault(Code::ObjectDiffers, format!("object {} has {said}, which are {even} mm^2", object.instance));
        }
        let extents = [("length_mm", height as f64 * row.row_mm), ("width_mm", width as f64 * row.col_mm)];
        for (name, extent) in extents.into_iter().filter(|_| object.measured) {
            let said = object.numbers.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
            let made = (!turned).then_some(extent);
            if said.map(f64::to_bits) != made.map(f64::to_bits) {
                fault(
                    Code::ObjectDiffers,
                    format!("{name} of object {} is {said:?}, its box makes {made:?}", object.instance),
                );
            }
        }
    }
    defects(row, values, place, report);
    if let Some(instance) = sample.images.get("instance").filter(|_| sample.unknown_label.is_none()) {
        objects(row, instance, place, report);
    }
}

/// The defects that the row lists against its objects and the areas of classes, which are those of the images.
fn defects(row: &StoredRow, values: &[u8], place: &str, report: &mut ValidationReport) {
    let mut fault = |code, what: String| report.fault(code, place, what);
    let classes = || values.iter().filter_map(|&value| Class::of(value));
    let mut is_known = true;
    for name in row.defects.iter().chain(row.unseen.iter().flatten()) {
        if !classes().any(|class| class.name() == name) {
            is_known = false;
            fault(Code::ValueRange, format!("the defect `{name}` is no pixel class of the subject"));
        }
    }
    let shown = row.objects.iter().filter_map(|object| Class::of(object.class)).filter(|class| class.is_defect());
    let shown: Vec<&str> = shown.map(Class::name).collect();
    // Before 1.7 the list has the unseen ones too.
    if row.unseen.is_none() {
        for name in shown.iter().filter(|name| !row.defects.iter().any(|defect| defect == *name)) {
            fault(Code::ObjectDiffers, format!("an object is a `{name}`, none of the defects"));
        }
        return;
    }
    if is_known && row.defects != shown {
        let what = format!("`defect_classes` is {:?}, the objects' defects are {shown:?}", row.defects);
        fault(Code::ObjectDiffers, what);
    }
    for (class, area) in classes().zip(&row.class_area_px).filter(|(class, _)| class.is_defect()) {
        if shown.contains(&class.name()) != (*area > 0) {
            let what = format!("{area} pixels show `{}`, the objects' defects are {shown:?}", class.name());
            fault(Code::ObjectDiffers, what);
        }
    }
}

fn objects(row: &StoredRow, instance: &[u16], place: &str, report: &mut ValidationReport) {
    let numbers = row.objects.iter().filter_map(|object| u16::try_from(object.instance).ok());
    let most = numbers.chain(instance.iter().copied()).max().unwrap_or(0);
    let mut all: Vec<Option<LabelledRegion>> = vec![None; usize::from(most) + 1];
    let cols = row.cols.max(1) as usize;
    // What holds an object has a smaller number, or the way out of it ends there.
    let mut holders = vec![0u16; all.len()];
    for object in &row.objects {
        let number = u16::try_from(object.instance).unwrap_or(0);
        let within = u16::try_from(object.within).unwrap_or(0);
        holders[usize::from(number)] = within.min(number.saturating_sub(1));
    }
    for (y, line) in instance.chunks(cols).enumerate() {
        for (x, &number) in line.iter().enumerate() {
            let mut number = usize::from(number);
            while number > 0 {
                let entry = all[number].get_or_insert(LabelledRegion { area: 0, first: (x, y), last: (x, y) });
                entry.area += 1;
                entry.first = (entry.first.0.min(x), entry.first.1.min(y));
                entry.last = (entry.last.0.max(x), entry.last.1.max(y));
                number = usize::from(holders[number]);
            }
        }
    }
    let numbered = (0..).zip(all).filter_map(|(number, seen)| seen.map(|seen| (number, seen)));
    let mut seen: BTreeMap<i32, LabelledRegion> = numbered.collect();
    let mut fault = |what: String| report.fault(Code::ObjectDiffers, place, what);
    let mut last = 0;
    for object in &row.objects {
        if object.instance <= last {
            fault(format!("object {} is not in order, or there twice", object.instance));
        }
        last = object.instance;
        let Some(found) = seen.remove(&object.instance) else {
            fault(format!("no pixel shows object {}", object.instance));
            continue;
        };
        let (width, height) = (found.last.0 - found.first.0 + 1, found.last.1 - found.first.1 + 1);
        let bbox = [found.first.0, found.first.1, width, height].map(|side| side as i32);
        if (bbox, found.area) != (object.bbox, object.area_px) {
            let said = format!("box {:?} and {} pixels", object.bbox, object.area_px);
            fault(format!("object {} has {said}, the image shows box {bbox:?} and {}", object.instance, found.area));
        }
    }
    for number in seen.keys() {
        fault(format!("the image shows instance {number}, which is no object"));
    }
}
