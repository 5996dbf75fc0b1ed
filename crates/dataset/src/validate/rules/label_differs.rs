//! Label and instance images in some rows against the body that the recipe makes, grown again without light, pixel by
//! pixel.

use super::{Code, REMAKE_OR_REPORT, Rule, SampleToCheck, ValidationReport};

pub(super) const RULE: Rule =
    Rule { meaning: "Labels or instances are not those of the body that the recipe makes.", remedy: REMAKE_OR_REPORT };

pub(super) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    let (rows, cols) = (sample.true_rows(), sample.cols());
    let [label, instance] = ["label", "instance"].map(|name| sample.images.get(name));
    let (mut wrong, mut first) = (0_usize, None);
    for row in rows {
        let line = row.row * cols..(row.row + 1) * cols;
        let [label, instance] = [label, instance].map(|image| image.and_then(|image| image.get(line.clone())));
        let classes = label.is_some_and(|label| label.iter().zip(&row.class).any(|(a, b)| *a != u16::from(*b)));
        if !classes && instance.is_none_or(|instance| instance == row.instance) {
            continue;
        }
        for column in 0..cols {
            let found = [label, instance].map(|line| line.and_then(|line| line.get(column).copied()));
            let made = [row.class.get(column).map(|class| u16::from(*class)), row.instance.get(column).copied()];
            if found.iter().zip(made).any(|(found, made)| found.is_some() && *found != made) {
                wrong += 1;
                first = first.or(Some((row.row, column, made)));
            }
        }
    }
    if let Some((row, column, [class, instance])) = first {
        let what = format!(
            "{wrong} pixels of {} rows are not as the body has them; the first, column {column} row {row}, is \
                class {} of instance {}",
            rows.len(),
            class.unwrap_or_default(),
            instance.unwrap_or_default()
        );
        report.fault(Code::LabelDiffers, &sample.place, what);
    }
}
