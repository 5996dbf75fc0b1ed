//! Expected rows: what the recipe says about the dataset and each of its samples, handed in from outside, against what
//! is on disk.

use output_schema::file::DATASET;
use output_schema::{DatasetHead, ManifestSample};

use super::columns::StoredRow;
use super::report::ValidationReport;
use super::rules::{Code, Finding};
use crate::differences;
use crate::differences::shortened;
use crate::record::{AskedRows, DerivedSample, StackFrame};

/// What the recipe draws for one sample, without rendering it.
#[derive(Debug, Clone, PartialEq)]
pub struct ExpectedRow {
    /// UUID.
    pub id: String,
    /// Name of its split.
    pub split: String,
    /// Name of its class.
    pub class: String,
    /// Drawn numbers in the order of the head's parameters.
    pub numbers: Vec<f64>,
}

/// Takes sensor frames, in any order, as they are exposed: all of a sample can be more than memory holds.
pub type TakeFrame<'a> = &'a (dyn Fn(StackFrame) + Sync);

/// Derives one sample: its index, the rows and frames to expose, and who takes the frames -> what its row has to say
/// beyond its draws, and these rows.
pub type Derive<'a> = &'a (dyn Fn(u64, &AskedRows, TakeFrame) -> DerivedSample + Sync);

/// Draws one sample: its index -> what its row has to say.
pub type Expect<'a> = &'a (dyn Fn(u64) -> ExpectedRow + Sync);

/// Differences of `dataset.json` that one fault names.
const MAX_NAMED_DIFFERENCES: usize = 6;

/// Checks `dataset.json` against what this program makes of its recipe; `true` where samples can be compared too.
pub(super) fn head(found: &DatasetHead, expected: Result<&DatasetHead, &str>, report: &mut ValidationReport) -> bool {
    let mut fault = |code, what: String| report.faults.push(Finding::new(code, DATASET, what));
    let expected = match expected {
        Ok(expected) => expected,
        Err(what) => {
            fault(Code::RecipeDiffers, what.to_owned());
            return false;
        }
    };
    if (&found.generator, &found.target) != (&expected.generator, &expected.target) {
        let writer =
            |head: &DatasetHead| format!("{} {} for {}", head.generator.name, head.generator.version, head.target);
        fault(Code::WriterDiffers, format!("it was written by {}, this is {}", writer(found), writer(expected)));
        return false;
    }
    // Heads are plain data: they always become JSON.
    let value = |head: &DatasetHead| serde_json::to_value(head).unwrap_or_default();
    let other = differences("", &value(found), &value(expected));
    if !other.is_empty() {
        let named = shortened(&other, MAX_NAMED_DIFFERENCES);
        fault(Code::DatasetDiffers, format!("said -> what the recipe gives: {named}"));
    }
    // Rows have other columns where these differ.
    found.parameters.len() == expected.parameters.len()
}

/// Checks what a manifest lists about a sample; the reason where it is wrong.
pub(super) fn listed(listed: &ManifestSample, expected: &ExpectedRow) -> Option<String> {
    let said = (&listed.id, &listed.split, &listed.class);
    (said != (&expected.id, &expected.split, &expected.class)).then(|| {
        let text = |(id, split, class): (&String, &String, &String)| format!("{id}, {split}, {class}");
        let drawn = text((&expected.id, &expected.split, &expected.class));
        format!("sample {} is {}, the recipe draws {drawn}", listed.index, text(said))
    })
}

/// Checks every drawn number of a row, bit for bit.
pub(super) fn numbers(
    row: &StoredRow,
    head: &DatasetHead,
    expected: &ExpectedRow,
    place: &str,
    report: &mut ValidationReport,
) {
    let pairs = head.parameters.iter().zip(row.numbers.iter().zip(&expected.numbers));
    let other: Vec<String> = pairs
        .filter(|(_, (stored, drawn))| stored.to_bits() != drawn.to_bits())
        .map(|(number, (stored, drawn))| format!("{} is {stored:?}, the recipe draws {drawn:?}", number.path()))
        .collect();
    if let Some(first) = other.first() {
        let more = if other.len() > 1 { format!("; {} more numbers differ", other.len() - 1) } else { String::new() };
        report.faults.push(Finding::new(Code::DrawDiffers, place, format!("{first}{more}")));
    }
}
