//! Samples that are there twice: as they are, with a little more noise, darker, mirrored.

use bench::settings::Channel;
use dataset::validate::Code::*;
use dataset::validate::ValidationReport;
use dataset::{ChannelValues, Encoded};

use super::place::{SIZE, boards, exr, inspect, labels, png, relabel, with, write};

/// Makes sample `to` show what sample `from` shows, under its own name and numbers; `change` is applied to each line of
/// numbers of the measured maps.
fn copy(samples: &mut [Encoded], from: usize, to: usize, change: &dyn Fn(Channel, usize, u16) -> u16, mirrored: bool) {
    let source = samples[from].clone();
    let own = samples[to].clone();
    let cols = SIZE.0;
    let place = |i: usize| if mirrored { i / cols * cols + cols - 1 - i % cols } else { i };
    let target = &mut samples[to];
    (target.png, target.exr) = (source.png, source.exr);
    (target.objects, target.defects, target.unseen) = (source.objects, source.defects, source.unseen);
    (target.range_offset, target.range_scale) = (source.range_offset, source.range_scale);
    for channel in [Channel::Range, Channel::Reflectance, Channel::Scatter] {
        png(target, channel, |numbers| {
            let old = numbers.clone();
            numbers.iter_mut().enumerate().for_each(|(i, n)| *n = change(channel, i, old[place(i)]));
        });
    }
    let [range, reflectance, scatter] = [Channel::Range, Channel::Reflectance, Channel::Scatter].map(|channel| {
        let mut numbers = Vec::new();
        png(target, channel, |found| numbers = found.iter().map(|&n| f32::from(n)).collect());
        numbers
    });
    let (offset, scale) = (target.range_offset as f32, target.range_scale as f32);
    exr(target, |channels, text| {
        for channel in channels.iter_mut() {
            let turned = |old: Vec<f32>| (0..old.len()).map(|i| old[place(i)]).collect::<Vec<f32>>();
            let dark = |map: &[f32]| (0..map.len()).map(|i| if range[i] == 0.0 { f32::NAN } else { map[i] }).collect();
            let numbers = match channel.name.as_str() {
                "Range" => (0..range.len())
                    .map(|i| if range[i] == 0.0 { f32::NAN } else { offset + range[i] * scale })
                    .collect(),
                "Reflectance" => dark(&reflectance),
                "Y" => reflectance.clone(),
                "Scatter" => dark(&scatter),
                _ => turned(channel.numbers()),
            };
            channel.samples = match channel.samples {
                ChannelValues::Half(_) => ChannelValues::Half(numbers),
                ChannelValues::Float(_) => ChannelValues::Float(numbers),
                ChannelValues::Uint(_) => ChannelValues::Uint(numbers.iter().map(|&n| n as u32).collect()),
            };
        }
        let calibration = own.calibration.iter().filter(|(_, n)| !n.is_nan());
        text["calibration"] =
            calibration.map(|&(name, n)| (name.to_owned(), n.into())).collect::<serde_json::Map<_, _>>().into();
        for (key, value) in [("id", own.id.as_str()), ("split", own.split.name()), ("class", &own.class)] {
            text[key] = value.into();
        }
        text["index"] = own.index.into();
        (text["row_mm"], text["col_mm"]) = (own.row_mm.into(), own.col_mm.into());
    });
    let [label, instance] = labels(target);
    relabel(target, &label, &instance);
}

/// The first sample and the first of another split.
fn pair() -> (usize, usize) {
    let samples = &boards().samples;
    (0, samples.iter().position(|sample| sample.split != samples[0].split).expect("two splits have samples"))
}

/// What is said of the copy; the rows' own objects differ from their bodies too.
fn said(report: &ValidationReport) -> &str {
    &report.faults.iter().find(|fault| fault.code == SampleAlike).expect("it is told").fault.what
}

#[test]
fn copies_are_found() {
    let (from, to) = pair();
    let place = format!("samples {from} and {to}");
    with(
        |samples| copy(samples, from, to, &|_, _, n| n, false),
        &[DrawDiffers, ObjectDiffers, TruthDiffers, LabelDiffers, SampleRepeated],
        &place,
        "a copy under another name",
    );
    // One digital number up or down, as a wrong rounding makes it.
    let jitter = |_, i: usize, n: u16| if n < 2 { n } else { n + (i * 7919 % 3) as u16 - 1 };
    let jitter = |channel, i, n| if channel == Channel::Reflectance && n == 255 { n } else { jitter(channel, i, n) };
    with(
        |samples| copy(samples, from, to, &jitter, false),
        &[DrawDiffers, ObjectDiffers, TruthDiffers, LabelDiffers, SampleAlike],
        &place,
        "a copy with a little noise",
    );
    let darker = |channel, _, n: u16| if channel == Channel::Range { n } else { (n * 9).div_ceil(10) };
    with(
        |samples| copy(samples, from, to, &darker, false),
        &[DrawDiffers, ObjectDiffers, TruthDiffers, LabelDiffers, SampleAlike],
        &place,
        "a darker copy",
    );
    let mut samples = boards().samples.clone();
    copy(&mut samples, from, to, &|_, _, n| n, true);
    let report = inspect(write(samples).path());
    assert_eq!(report.codes(), [DrawDiffers, ObjectDiffers, TruthDiffers, LabelDiffers, SampleAlike], "{report}");
    assert!(said(&report).contains("mirrored") && said(&report).contains("leaks"), "{report}");
    // Within a split nothing leaks.
    let split = boards().samples[from].split;
    let same =
        (from + 1..boards().samples.len()).find(|&i| boards().samples[i].split == split).expect("two of a split");
    let mut samples = boards().samples.clone();
    copy(&mut samples, from, same, &|_, _, n| n, true);
    let report = inspect(write(samples).path());
    assert_eq!(report.codes(), [DrawDiffers, ObjectDiffers, TruthDiffers, LabelDiffers, SampleAlike], "{report}");
    assert!(!said(&report).contains("leaks"), "{report}");
}
