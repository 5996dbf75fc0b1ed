//! An estimate: Range lies near the body that the recipe makes. Made where no row is exposed again, which tells it
//! exactly.
//!
//! Range is no truth: it lies below the surface of what lets light in, and is the tablet's under clear film. So it is
//! held to what hardly a measurement misses: the median distance of well lit pixels from between the surface and what
//! lies below a film is [`FAR_MM`] at most. Pixels at the greatest digital number are left out: a line that is
//! saturated over many rows is measured in the middle of these.

use super::{Code, Rule, SampleToCheck, ValidationReport};

pub(super) const RULE: Rule = Rule {
    meaning: "Warning: Range seems to be nowhere near the body that the recipe makes.",
    remedy: "look at the sample: this is an estimate; --rows 1 compares Range exactly",
};
/// Median distance of Range from the body that is told [mm].
const FAR_MM: f32 = 2.0;
/// A pixel is well lit from this share of the greatest digital number on, if it is below that [1].
const LIT: f32 = 0.25;
/// Pixels that it takes to judge Range [px].
const MIN_PIXELS: usize = 64;

pub(super) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    let head = sample.task.head;
    if !sample.exposed().is_empty() || head.range_unit() != "mm" {
        return;
    }
    let (rows, cols, most) = (sample.true_rows(), sample.cols(), head.images.most_dn());
    let (range, light) = (sample.images.get("range"), sample.images.get("reflectance"));
    let (Some(range), Some(light)) = (range, light) else { return };
    let mut apart = Vec::new();
    for row in rows {
        let line = row.row * cols..(row.row + 1) * cols;
        let (Some(range), Some(light)) = (range.get(line.clone()), light.get(line)) else { continue };
        let bodies = row.truth.height.iter().zip(&row.lower);
        for ((&range, &light), (&height, &below)) in range.iter().zip(light).zip(bodies) {
            if range > 0 && light < most && f32::from(light) >= LIT * f32::from(most) && !height.is_nan() {
                let measured = (sample.row.range_offset + f64::from(range) * sample.row.range_scale) as f32;
                apart.push((measured - height).max(0.0) - (below - measured).max(0.0));
            }
        }
    }
    if apart.len() < MIN_PIXELS {
        return;
    }
    let middle = apart.len() / 2;
    let median = *apart.select_nth_unstable_by(middle, f32::total_cmp).1;
    if median.abs() > FAR_MM {
        let side = if median > 0.0 { "above" } else { "below" };
        let what = format!(
            "Range of {} well lit pixels lies {:.1} mm {side} the body in the middle, of {} rows",
            apart.len(),
            median.abs(),
            rows.len()
        );
        report.warn(Code::RangeDiffers, &sample.place, what);
    }
}
