//! What was taken away or moved in all files alike, so that they agree with each other and not with the recipe's
//! bodies.

use base::Class;
use dataset::validate::Code::*;
use dataset::{Encoded, ExrChannel};
use optical_bench::settings::Channel;

use super::place::{ESTIMATES, always, boards, exr, inspect, inspect_rows, labels, png, relabel, with, write};

/// A board that shows an object.
fn shown() -> usize {
    boards().samples.iter().position(|sample| !sample.objects.is_empty()).expect("a board shows a knot or rot")
}

/// Adds `more` to the numbers of an EXR channel.
fn raise(channels: &mut [ExrChannel], name: &str, more: f32) {
    let channel = channels.iter_mut().find(|channel| channel.name == name).expect("the channel");
    channel.numbers.iter_mut().for_each(|number| *number += more);
}

#[test]
fn erased_objects() {
    let erase = |sample: &mut Encoded| {
        let [mut label, instance] = labels(sample);
        let own = label.iter_mut().zip(&instance).filter(|(_, instance)| **instance > 0);
        own.for_each(|(label, _)| *label = Class::Clear as u16);
        relabel(sample, &label, &vec![0; instance.len()]);
    };
    let place = format!("sample {}", shown());
    with(|samples| erase(&mut samples[shown()]), &[LabelDiffers], &place, "every object of a sample erased");
    with(|samples| samples.iter_mut().for_each(erase), &[LabelDiffers], &place, "every object erased");
}

#[test]
#[ignore = "long"]
fn maps_that_moved() {
    let place = format!("{}.exr", boards().samples[0].id);
    let height = |samples: &mut Vec<Encoded>| exr(&mut samples[0], |channels, _| raise(channels, "Height", 0.5));
    with(height, &[TruthDiffers], &place, "Height half a millimetre higher");
    // In whole steps of the image, so that both files stay alike.
    let range = |samples: &mut Vec<Encoded>| {
        let steps = (3.0 / samples[0].range_scale).round();
        let more = (steps * samples[0].range_scale) as f32;
        png(&mut samples[0], Channel::Range, |numbers| {
            numbers.iter_mut().filter(|n| **n > 0).for_each(|n| *n += steps as u16);
        });
        exr(&mut samples[0], |channels, _| raise(channels, "Range", more));
    };
    let mut samples = boards().samples.clone();
    range(&mut samples);
    let moved = write(samples);
    always(moved.path(), "Range three millimetres higher");
    // Exposed again, as by default, it is a fault; where no row is, it is looked at.
    for report in inspect_rows(moved.path(), 0..4) {
        assert_eq!(report.codes(), [ProfileDiffers], "{report}");
    }
    let report = inspect(moved.path());
    let told = report.warnings.iter().filter(|found| ESTIMATES.contains(&found.code));
    let told: Vec<_> = told.map(|found| (found.code, found.fault.place.ends_with("sample 0"))).collect();
    assert!(report.is_clean() && told == [(RangeDiffers, true)], "{report}");
}

#[test]
fn frames_that_all_samples_lack() {
    let last = |samples: &mut Vec<Encoded>| samples.iter_mut().for_each(|sample| _ = sample.stack.pop());
    with(last, &[StackDiffers], "stacks/00000.parquet", "the last frame of every sample left out");
}
