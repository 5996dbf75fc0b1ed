//! A row says what it should of its id, split, class, seed and the names of its images. A class without a name has a
//! code of its own.

use super::{Code, REMAKE_OR_REPORT, Rule, SampleToCheck, ValidationReport};
use crate::image_path;

pub(super) const RULE: Rule = Rule {
    meaning: "A row says another id, split, class or seed than its file, manifest or `dataset.json`.",
    remedy: REMAKE_OR_REPORT,
};
pub(super) const CLASS_UNKNOWN: Rule =
    Rule { meaning: "A row has a class that `dataset.json` does not name.", remedy: REMAKE_OR_REPORT };

pub(super) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    let SampleToCheck { row, place, listed, expected, .. } = sample;
    let head = sample.task.head;
    let mut fault = |code, what: String| report.fault(code, place, what);
    // What the manifest lists was compared with the recipe where there is one.
    let named = expected.as_ref().map_or([&listed.id, &listed.split, &listed.class], |e| [&e.id, &e.split, &e.class]);
    let [id, split, class] = named;
    if (&row.id, &row.split, row.seed) != (id, split, head.seed) {
        let said = format!("id {}, split {}, seed {}", row.id, row.split, row.seed);
        fault(Code::RowDiffers, format!("it says {said}, it should be id {id}, split {split}, seed {}", head.seed));
    }
    for (name, path) in row.paths.iter().filter(|(name, path)| *path != image_path(&row.id, name)) {
        fault(Code::RowDiffers, format!("`{name}.path` is {path}, not {}", image_path(&row.id, name)));
    }
    match usize::try_from(row.class).ok().and_then(|class| head.classes.get(class)) {
        None => fault(Code::ClassUnknown, format!("class {} is none of {:?}", row.class, head.classes)),
        Some(name) if name != class => {
            fault(Code::RowDiffers, format!("it is of class {name}, it should be {class}"));
        }
        Some(_) => {}
    }
}
