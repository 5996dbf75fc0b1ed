//! A row against what its recipe draws, and what it makes without light: the bench, effective physics and the body's
//! own instances, bit for bit.
//!
//! What light decides stays with the other checks: which instances a pixel shows, their boxes and their areas.

use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, ArrayRef, StructArray};
use base::Instance;
use output_schema::row::{GROUPS, OBJECT, ROW};
use output_schema::{Column, ColumnKind, Source};

use super::{Code, REMAKE_OR_REPORT, Rule, SampleToCheck, ValidationReport};
use crate::record::Object;
use crate::validate::columns::{StoredObject, StoredRow};
use crate::validate::expected;
use crate::{cell, encode_numbers, object_cells, table_reader};

pub(super) const RULE: Rule = Rule {
    meaning: "A drawn number, a group, or what follows from the draws without light, is not what the recipe gives.",
    remedy: REMAKE_OR_REPORT,
};

/// Differences of a row that one fault names.
const MAX_NAMED_DIFFERENCES: usize = 3;

pub(super) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    let SampleToCheck { row, place, .. } = sample;
    if let Some(expected) = &sample.expected {
        expected::numbers(row, sample.task.head, expected, place, report);
    }
    let head = sample.task.head;
    let Some(derived) = &sample.derived else { return };
    let numbers = encode_numbers(&derived.record, u32::try_from(head.images.bits).unwrap_or(u32::MAX));
    let mut other = Vec::new();
    let is_made = |column: &&Column| column.follows == Source::Scene || GROUPS.contains(&column.name);
    for column in ROW.iter().filter(is_made) {
        // The number of Range is called as the row has it, whatever its unit.
        let name = match column.kind {
            ColumnKind::RangeNumber => column.name.trim_end_matches(&format!("_{}", column.unit)),
            _ => column.name,
        };
        if let Some((place, field)) = row.batch.schema_ref().fields().find(column.name) {
            match cell(field, head, &numbers) {
                Ok(made) => differences("", name, row.batch.column(place), &made, &mut other),
                Err(what) => other.push(what),
            }
        }
    }
    other.extend(defects(row, &derived.instances));
    if let Some(stored) = row.batch.column_by_name("objects").and_then(|list| list.as_list_opt::<i32>()) {
        let fields = stored.value(0);
        for (at, object) in row.objects.iter().enumerate() {
            objects((object, fields.as_struct()), at, &derived.instances, &mut other);
        }
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

/// `stored` has the fields of the object at place `at`, and those of the others.
fn objects(
    (object, stored): (&StoredObject, &StructArray),
    at: usize,
    instances: &[Instance],
    other: &mut Vec<String>,
) {
    let of = format!("object {}: ", object.instance);
    let Some(own) = instances.iter().find(|own| i32::from(own.id) == object.instance) else {
        other.push(format!("{of}the recipe makes none of that number"));
        return;
    };
    let made = (own.class as i64, own.state as i64, i32::from(own.within));
    let said = (object.class, object.state, object.within);
    if said != made {
        other.push(format!("{of}class, state and within are {said:?}, the recipe makes {made:?}"));
    }
    // What light decides is not compared.
    let own = [Object { instance: *own, area_px: 0, area_mm2: f64::NAN, bbox: [0; 4], extent_mm: [f64::NAN; 2] }];
    let names = OBJECT.iter().filter(|column| column.follows == Source::Scene).map(|column| column.name);
    for name in names.filter(|name| !["class", "state", "within"].contains(name)) {
        let field = stored.fields().find(name).map(|(place, field)| (stored.column(place).slice(at, 1), field));
        if let Some((said, field)) = field {
            match object_cells(field, &own) {
                Ok(made) => differences(&of, name, &said, &made, other),
                Err(error) => other.push(error.to_string()),
            }
        }
    }
}

/// What is not the same bit for bit, or there on one side alone: values of one row, or the fields of a struct.
fn differences(of: &str, name: &str, said: &ArrayRef, made: &ArrayRef, other: &mut Vec<String>) {
    if let (Some(said), Some(made)) = (said.as_struct_opt(), made.as_struct_opt()) {
        for (field, (said, made)) in made.fields().iter().zip(said.columns().iter().zip(made.columns())) {
            differences(of, field.name(), said, made, other);
        }
    } else if said != made {
        other.push(format!("{of}{name} is {}, the recipe makes {}", text(said), text(made)));
    }
}

/// The value of one row in words.
fn text(value: &ArrayRef) -> String {
    match (value.as_primitive_opt::<Float64Type>(), value.as_string_opt::<i32>()) {
        (Some(number), _) if number.is_null(0) => "missing".to_owned(),
        (Some(number), _) => format!("{:?}", number.value(0)),
        (_, Some(text)) => format!("{:?}", text.is_valid(0).then(|| text.value(0))),
        _ => table_reader::value(value, 0).map_or_else(|what| what, |value| value.to_string()),
    }
}
