//! An estimate: in the middle of a knot the fibre dives as its axis does. Made where the recipe cannot be drawn again.

use base::Class;

use super::{Code, LOOK, Rule, SampleToCheck, ValidationReport};

pub(super) const RULE: Rule = Rule {
    meaning: "Warning: in the middle of a knot the fibre seems to dive otherwise than the knot's axis.",
    remedy: LOOK,
};
/// The classes of objects that show fibres along their own axis: a hole shows the wood below, and the gap about a loose
/// knot too.
const GROWN: [Class; 2] = [Class::SoundKnot, Class::DeadKnot];
/// Pixels of a knot from which on the fibre's dive in it is compared with that of its axis [px].
const KNOT_PX: usize = 200;
/// Furthest that the middle fibre of a knot dives from its axis [deg]: rings about the axis and a knot that is cut
/// off by the image leave it within a few degrees, clear wood dives tens of degrees less.
const DIVE_DEG: f32 = 20.0;

pub(in crate::validate) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    if sample.task.is_exact() {
        return;
    }
    let row = &sample.row;
    let (Some(dive), Some(instance)) = (sample.channel("FibreDive"), sample.images.get("instance")) else { return };
    let is_grown = |class: i64| Class::of(class).is_some_and(|class| GROWN.contains(&class));
    let grown = row.objects.iter().filter(|object| is_grown(object.class));
    for object in grown.filter(|object| object.dive_deg.is_some()) {
        // A box that leads out of the image is told by another rule.
        let [x, y, width, height] = object.bbox.map(|side| usize::try_from(side).unwrap_or(0));
        let cols = row.cols.max(1) as usize;
        let lines = (y..y.saturating_add(height)).map(|y| (y * cols + x.min(cols), y * cols + (x + width).min(cols)));
        let lines = lines.map_while(|(from, to)| Some((dive.get(from..to)?, instance.get(from..to)?)));
        let own = lines.flat_map(|(dive, instance)| dive.iter().zip(instance));
        let own = own.filter(|(dive, number)| i32::from(**number) == object.instance && !dive.is_nan());
        let mut own: Vec<f32> = own.map(|(dive, _)| dive.abs()).collect();
        if own.len() < KNOT_PX {
            continue;
        }
        let middle = own.len() / 2;
        let (_, median, _) = own.select_nth_unstable_by(middle, f32::total_cmp);
        let axis = object.dive_deg.unwrap_or_default().abs() as f32;
        if (*median - axis).abs() > DIVE_DEG {
            let what = format!("the fibre dives {median:.0} deg in object {}, its axis {axis:.0} deg", object.instance);
            report.warn(Code::DiveDiffers, sample.exr_path(), what);
        }
    }
}
