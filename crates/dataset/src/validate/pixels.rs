//! Pixels: label, instance and truth maps, pixel by pixel: all of them come from one noise-free hit, so they agree
//! exactly. How the fibre dives in a knot is an estimate beside that, for datasets whose recipe cannot be drawn again.

use std::borrow::Cow;

use output_schema::PIXEL_CLASSES;

use super::columns::StoredRow;
use super::finding::{Code, Finding};
use super::images::DecodedImages;
use super::report::ValidationReport;
use super::shard_task::ShardTask;
use crate::ExrChannel;

/// The classes of pixels that belong to no instance.
const GROUND: [&str; 3] = ["background", "clear", "flange"];
/// The classes of objects that show fibres along their own axis: a hole shows the wood below, and the gap about a loose
/// knot too.
const GROWN: [&str; 2] = ["sound_knot", "dead_knot"];
/// Pixels of a knot from which on the fibre's dive in it is compared with that of its axis [px].
const KNOT_PX: usize = 200;
/// Furthest that the middle fibre of a knot dives from its axis [deg]: rings about the axis and a knot that is cut
/// off by the image leave it within a few degrees, clear wood dives tens of degrees less.
const DIVE_DEG: f32 = 20.0;

/// Every pixel of an instance has the class of its object, and every other one is ground.
pub(super) fn instances(row: &StoredRow, decoded: &DecodedImages, place: &str, report: &mut ValidationReport) {
    let (Some(label), Some(instance)) = (decoded.get("label"), decoded.get("instance")) else { return };
    let ground = PIXEL_CLASSES.map(|name| GROUND.contains(&name));
    let ground = |class: u16| ground.get(usize::from(class)).is_some_and(|ground| *ground);
    // No class is as large: an instance without an object is told by another rule.
    let numbers = row.objects.iter().filter_map(|object| u16::try_from(object.instance).ok());
    let mut classes = vec![None; usize::from(numbers.max().unwrap_or(0)) + 1];
    for object in &row.objects {
        if let Some(class) = usize::try_from(object.instance).ok().and_then(|place| classes.get_mut(place)) {
            *class = u16::try_from(object.class).ok();
        }
    }
    let wrong = |(&label, &instance): (&u16, &u16)| match instance {
        0 => !ground(label),
        instance => classes.get(usize::from(instance)).copied().flatten().is_some_and(|class| class != label),
    };
    let mut count = 0;
    let mut first = None;
    for (i, pair) in label.iter().zip(instance).enumerate() {
        if wrong(pair) {
            count += 1;
            first = first.or(Some((i, *pair.0, *pair.1)));
        }
    }
    if let Some((i, label, instance)) = first {
        let cols = row.cols.max(1) as usize;
        let what = format!(
            "{count} pixels have a class that their instance has not; the first, column {} row {}, is class {label} of instance {instance}",
            i % cols,
            i / cols
        );
        report.faults.push(Finding::new(Code::InstanceClass, place, what));
    }
}

/// Labels against the truth maps of the EXR file.
pub(super) fn truth(
    task: &ShardTask,
    channels: &[ExrChannel],
    decoded: &DecodedImages,
    place: &str,
    report: &mut ValidationReport,
) {
    let map = |name| map(channels, name);
    let mut fault = |what: String| report.tell(task.is_exact(), Finding::new(Code::TruthDiffers, place, what));
    let bin = &task.head.recipe.canonical["output"]["bin"];
    // A binned pixel is of the most frequent class, its truth a mean of what is known.
    let whole = bin["columns"] == 1 && bin["profiles"] == 1;
    if let (Some(height), Some(label)) = (map("Height"), decoded.get("label")) {
        let wrong =
            |(z, label): &(&f32, &u16)| if whole { z.is_nan() != (**label == 0) } else { z.is_nan() && **label != 0 };
        let count = height.iter().zip(label).filter(wrong).count();
        if count > 0 {
            fault(format!("{count} pixels have a height on the background, or none on the object"));
        }
    }
    let Some(instance) = decoded.get("instance") else { return };
    if let Some(gap) = map("FilmGap").filter(|_| whole) {
        let count = gap.iter().zip(instance).filter(|(gap, instance)| **gap > 0.0 && **instance == 0).count();
        if count > 0 {
            fault(format!("{count} pixels of the flange have air below the film"));
        }
    }
}

/// An estimate: in the middle of a knot the fibre dives as its axis does.
pub(super) fn dive(
    row: &StoredRow,
    channels: &[ExrChannel],
    decoded: &DecodedImages,
    place: &str,
    report: &mut ValidationReport,
) {
    let (Some(dive), Some(instance)) = (map(channels, "FibreDive"), decoded.get("instance")) else { return };
    let class = |class: i64| usize::try_from(class).ok().and_then(|class| PIXEL_CLASSES.get(class));
    let grown = row.objects.iter().filter(|object| class(object.class).is_some_and(|name| GROWN.contains(name)));
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
            report.warnings.push(Finding::new(Code::DiveDiffers, place, what));
        }
    }
}

/// The numbers of a channel.
fn map<'a>(channels: &'a [ExrChannel], name: &str) -> Option<Cow<'a, [f32]>> {
    channels.iter().find(|channel| channel.name == name).map(ExrChannel::as_numbers)
}
