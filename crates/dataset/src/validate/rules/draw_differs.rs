//! A row against what its recipe draws, and what it makes without light: the bench, effective physics and the body's
//! own instances, bit for bit.
//!
//! What light decides stays with the other checks: which instances a pixel shows, their boxes and their areas.

use procedural::Instance;

use super::{Code, REMAKE_OR_REPORT, Rule};
use crate::validate::columns::{StoredObject, StoredRow};
use crate::validate::expected::{self, UnlitRow};
use crate::validate::report::ValidationReport;
use crate::validate::sample::StoredSample;

pub(super) const RULE: Rule = Rule {
    meaning: "A drawn number, or what follows from the draws without light, is not what recipe, seed and index give.",
    remedy: REMAKE_OR_REPORT,
};

/// Names of the numbers of [`UnlitRow::grid`].
const GRID: [&str; 4] = ["row_mm", "col_mm", "range_offset", "range_scale"];
/// Differences of a row that one fault names.
const MAX_NAMED_DIFFERENCES: usize = 3;

pub(super) fn check(sample: &StoredSample, report: &mut ValidationReport) {
    let StoredSample { row, place, .. } = sample;
    if let Some(expected) = &sample.expected {
        expected::numbers(row, sample.task.head, expected, place, report);
    }
    let Some(unlit) = sample.derived.as_ref().map(|derived| &derived.unlit) else { return };
    let mut other = Vec::new();
    let grid = [row.row_mm, row.col_mm, row.range_offset, row.range_scale];
    let stored = GRID.into_iter().zip(grid).map(|(name, value)| (name.to_owned(), value)).collect::<Vec<_>>();
    let made = GRID.into_iter().zip(unlit.grid).map(|(name, value)| (name.to_owned(), value)).collect::<Vec<_>>();
    differences("", &stored, &made, &mut other);
    let known: Vec<(String, f64)> = unlit.derived.iter().filter(|number| !number.1.is_nan()).cloned().collect();
    differences("", &row.derived, &known, &mut other);
    other.extend(defects(row, &unlit.instances));
    for object in &row.objects {
        objects(object, unlit, &mut other);
    }
    if !other.is_empty() {
        let more = if other.len() > MAX_NAMED_DIFFERENCES {
            format!("; {} more differ", other.len() - MAX_NAMED_DIFFERENCES)
        } else {
            String::new()
        };
        let named = other.iter().take(MAX_NAMED_DIFFERENCES).map(String::as_str).collect::<Vec<_>>().join("; ");
        report.fault(Code::DrawDiffers, place, format!("{named}{more}"));
    }
}

/// Defects that show and those that do not, together those of the body; which of them show is decided by the images.
/// What differs.
fn defects(row: &StoredRow, instances: &[Instance]) -> Option<String> {
    let unseen = row.unseen.as_ref()?;
    let own = || instances.iter().filter(|own| own.class.is_defect());
    let is_object = |own: &&Instance| row.objects.iter().any(|object| object.instance == i32::from(own.id));
    let (shown, hidden): (Vec<&Instance>, Vec<&Instance>) = own().partition(is_object);
    let names = |own: Vec<&Instance>| own.into_iter().map(|own| own.class.name().to_owned()).collect::<Vec<_>>();
    let (mut stored, mut made) = (vec![row.defects.clone(), unseen.clone()], vec![names(shown), names(hidden)]);
    // Where the list is not that of the objects, which is told elsewhere, both lists are compared as one.
    if stored[0].len() != made[0].len() {
        for lists in [&mut stored, &mut made] {
            let mut all = lists.concat();
            all.sort_unstable();
            *lists = vec![all];
        }
    }
    (stored != made).then(|| format!("the defects, shown and unseen, are {stored:?}, the recipe makes {made:?}"))
}

fn objects(object: &StoredObject, unlit: &UnlitRow, other: &mut Vec<String>) {
    let name = format!("object {}: ", object.instance);
    let Some(own) = unlit.instances.iter().find(|own| i32::from(own.id) == object.instance) else {
        other.push(format!("{name}the recipe makes none of that number"));
        return;
    };
    let made = (own.class as i64, own.state as i64, i32::from(own.within));
    let said = (object.class, object.state, object.within);
    if said != made {
        other.push(format!("{name}class, state and within are {said:?}, the recipe makes {made:?}"));
    }
    let made = [
        ("x_mm", own.x_mm),
        ("y_mm", own.y_mm),
        ("diameter_mm", own.diameter_mm),
        ("dive_deg", own.dive_deg),
        ("death_radius_mm", own.death_radius_mm),
        ("severity", own.severity),
        ("depth_mm", if object.measured { own.depth_mm } else { f64::NAN }),
    ];
    let stored = object.numbers.iter().filter(|(known, _)| made.iter().any(|(own, _)| own == known));
    let stored: Vec<(String, f64)> = stored.map(|(known, value)| ((*known).to_owned(), *value)).collect();
    let made = made.into_iter().filter(|number| !number.1.is_nan());
    let made: Vec<(String, f64)> = made.map(|(known, value)| (known.to_owned(), value)).collect();
    differences(&name, &stored, &made, other);
    let names = own.knot.map(|knot| knot.text());
    if object.measured && object.knot_names != names {
        other.push(format!("{name}knot_names is {:?}, the recipe makes {names:?}", object.knot_names));
    }
}

/// Numbers that are not the same bit for bit, or there on one side alone.
fn differences(of: &str, stored: &[(String, f64)], made: &[(String, f64)], other: &mut Vec<String>) {
    let find = |list: &[(String, f64)], name: &str| list.iter().find(|known| known.0 == name).map(|known| known.1);
    let text = |value: Option<f64>| value.map_or("missing".to_owned(), |value| format!("{value:?}"));
    let extra = stored.iter().filter(|known| find(made, &known.0).is_none());
    for name in made.iter().chain(extra).map(|known| &known.0) {
        let (found, expected) = (find(stored, name), find(made, name));
        if found.map(f64::to_bits) != expected.map(f64::to_bits) {
            other.push(format!("{of}{name} is {}, the recipe makes {}", text(found), text(expected)));
        }
    }
}
