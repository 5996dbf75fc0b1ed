//! An estimate of label against picture: where the label ends at the background, Range steps between the object and the
//! conveyor.
//!
//! Made for datasets whose recipe cannot be drawn again. On each of the four sides of the object, pixels 2 and
//! 3 places beyond its edge are expected at the conveyor's height and those 2 and 3 places within at the object's, told
//! apart half way between both. The object's height there is taken from the pixels further within that are of the
//! edge's own class, less what these rise towards its middle. A mask that is shifted by three pixels, mirrored, or of
//! another sample has most of them wrong on some side; docs/theory/validation.md has the rates. Sides without a clear
//! step are left out: a card as thin as the noise of Range on the conveyor, an object that fills the image, a rim that
//! is narrower than these strips. And the first and last rows under a laser with a second line, which lights the object
//! ahead of the line. Saturated pixels within do not count: near an edge, where part of the line's width falls beside
//! the object, their peaks are out of place by more than a card is thick, and a conveyor that is taken for the object
//! is dark.

use super::{Code, LOOK, Rule, SampleToCheck, ValidationReport};

pub(super) const RULE: Rule = Rule {
    meaning: "Warning: the label's outline seems not to be where Range steps from the conveyor to the object.",
    remedy: LOOK,
};

/// The strip beyond or within an edge: from this place on [px].
const NEAR: usize = 2;
/// To this place [px].
const FAR: usize = 3;
/// To this place the object's height and slope are taken [px].
const DEEP: usize = 13;
/// To this place is the nearer of two strips from which the object's slope is told [px].
const MIDDLE: usize = 8;
/// From the middle of `within` to that of the nearer strip over the distance of both [1].
const SLOPE: f32 = 3.5 / 5.0;
/// Pixels that a strip must have [px].
const LEAST: usize = 24;
/// A step is clear that is so many times the noise of Range on the conveyor [1].
const CLEAR: f32 = 6.0;
/// Share of wrong pixels that is told [1]: in clean scans it stayed below 0.1.
const WRONG: f32 = 0.6;
/// Of a normal law, standard deviation over median absolute deviation [1].
const SIGMA: f32 = 1.4826;
/// Saturated share from which a scan without Reflectance is left out [1].
const SATURATED_LEFT_OUT: f64 = 0.1;

/// Checks the edges of one sample; under a second line, which lights the object ahead of the line, those of columns
/// alone.
pub(super) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    let (head, cols) = (sample.task.head, sample.cols());
    let recipe = &head.recipe.canonical;
    // The thesis' method lets light out beyond the object's edges.
    if sample.task.is_exact() || recipe["transport"]["model"] == "thesis" {
        return;
    }
    let (Some(label), Some(range)) = (sample.images.get("label"), sample.images.get("range")) else { return };
    let reflectance = sample.images.get("reflectance");
    let share = sample.row.shares.as_ref().map(|shares| shares.saturated);
    if reflectance.is_none() && share.is_some_and(|share| share > SATURATED_LEFT_OUT) {
        return;
    }
    let mut conveyor: Vec<u16> =
        label.iter().zip(range).filter(|(label, range)| **label == 0 && **range > 0).map(|(_, range)| *range).collect();
    if conveyor.len() < LEAST || conveyor.len() == label.len() {
        return;
    }
    let level = median(&mut conveyor);
    conveyor.iter_mut().for_each(|r| *r = (f32::from(*r) - level).abs() as u16);
    let noise = SIGMA * median(&mut conveyor);
    let saturated = |i: usize| reflectance.and_then(|dn| dn.get(i)).is_some_and(|dn| *dn >= head.images.most_dn());
    for (name, lines) in [("column", Lines { cols, across: false }), ("row", Lines { cols, across: true })] {
        if lines.across && recipe["laser"]["second_line_mm"] != 0.0 {
            continue;
        }
        for backwards in [false, true] {
            let Some(wrong) = side((label, range, &saturated), (level, noise), &lines, backwards) else { continue };
            if wrong > WRONG {
                let side = if backwards { "last" } else { "first" };
                let what = format!(
                    "{:.0} % of the pixels about the {side} {name} of the object are not at the height that the \
                        label says",
                    100.0 * wrong
                );
                report.warn(Code::OutlineDiffers, &sample.place, what);
            }
        }
    }
}

/// The lines of an image in one of two directions.
struct Lines {
    cols: usize,
    across: bool,
}

impl Lines {
    /// Pixels of line `number`, from the first; `None` past the last line.
    fn line(&self, number: usize, pixels: usize) -> Option<(usize, usize, usize)> {
        let rows = pixels / self.cols;
        match self.across {
            false => (number < rows).then(|| (number * self.cols, 1, self.cols)),
            true => (number < self.cols).then_some((number, self.cols, rows)),
        }
    }
}

/// Share of wrong pixels beyond and within one side, the greater one; `None` where nothing can be told.
fn side(
    (label, range, saturated): (&[u16], &[u16], &dyn Fn(usize) -> bool),
    (level, noise): (f32, f32),
    lines: &Lines,
    backwards: bool,
) -> Option<f32> {
    let [mut beyond, mut near, mut far] = [const { Vec::new() }; 3];
    // With whether the pixel is saturated.
    let mut within = Vec::new();
    let mut number = 0;
    while let Some((first, step, length)) = lines.line(number, label.len()) {
        number += 1;
        let at = |k: usize| first + step * if backwards { length - 1 - k } else { k };
        let mut edge = None;
        let mut before = label[at(0)];
        for k in 1..length {
            let here = label[at(k)];
            match (std::mem::replace(&mut before, here), here) {
                (0, 0) => continue,
                // Into the object.
                (0, _) => {
                    edge = Some((k, here));
                    let outside = (NEAR..=FAR).filter_map(|d| k.checked_sub(d)).map(at);
                    beyond.extend(outside.take_while(|&i| label[i] == 0).map(|i| range[i]).filter(|&r| r > 0));
                }
                (_, 0) => edge = None,
                _ => {}
            }
            // Beside another class the object may stand higher: a pocket on a card.
            let Some((edge, _)) = edge.filter(|(_, class)| *class == here) else { continue };
            let place = k - edge + 1;
            let r = range[at(k)];
            if r > 0 && (NEAR..=DEEP).contains(&place) {
                if place <= FAR {
                    within.push((r, saturated(at(k))));
                } else if place <= MIDDLE {
                    near.push(r);
                } else {
                    far.push(r);
                }
            }
        }
    }
    if [beyond.len(), within.len(), near.len(), far.len()].into_iter().any(|pixels| pixels < LEAST) {
        return None;
    }
    // Where the object slopes, it is as much lower at its edge.
    let [near, far] = [median(&mut near) - level, median(&mut far) - level];
    let slope = (far - near) * near.signum() * SLOPE;
    let body = level + near - slope.max(0.0) * near.signum();
    if (body > level) != (near > 0.0) {
        return None;
    }
    if (body - level).abs() < CLEAR * noise.max(1.0) {
        return None;
    }
    let half = 0.5 * (body + level);
    let is_wrong = |r: u16, high: bool| (f32::from(r) > half) != high;
    let outside = beyond.iter().filter(|&&r| is_wrong(r, body < level)).count();
    let inside: Vec<u16> = within.into_iter().filter_map(|(r, saturated)| (!saturated).then_some(r)).collect();
    let wrong = inside.iter().filter(|&&r| is_wrong(r, body > level)).count();
    let inside = if inside.len() < LEAST { 0.0 } else { wrong as f32 / inside.len() as f32 };
    Some((outside as f32 / beyond.len() as f32).max(inside))
}

fn median(numbers: &mut [u16]) -> f32 {
    let middle = numbers.len() / 2;
    f32::from(*numbers.select_nth_unstable(middle).1)
}
