//! Samples that are there twice: as they are, with a little more noise, darker, mirrored.

use dataset::Encoded;
use dataset::validate::Code::{self, *};
use dataset::validate::ValidationReport;
use optical_bench::settings::Channel;

use super::place::{ESTIMATES, SIZE, always, boards, exr, inspect, inspect_rows, labels, png, relabel, write};

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
            let turned = |old: &[f32]| (0..old.len()).map(|i| old[place(i)]).collect::<Vec<f32>>();
            let dark = |map: &[f32]| (0..map.len()).map(|i| if range[i] == 0.0 { f32::NAN } else { map[i] }).collect();
            channel.numbers = match channel.name.as_str() {
                "Range" => (0..range.len())
                    .map(|i| if range[i] == 0.0 { f32::NAN } else { offset + range[i] * scale })
                    .collect(),
                "Reflectance" => dark(&reflectance),
                "Y" => reflectance.clone(),
                "Scatter" => dark(&scatter),
                _ => turned(&channel.numbers),
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

/// What is said to look at in a copy where no row is exposed again. Where rows are, as by default, the copy is a fault
/// and nothing has to be looked at.
fn told(samples: Vec<Encoded>, code: Code, place: &str, what: &str) -> String {
    let folder = write(samples);
    // The rows' own objects differ from their bodies too.
    let faults = [DrawDiffers, ObjectDiffers, TruthDiffers, LabelDiffers];
    let found =
        |report: &ValidationReport| report.warnings.iter().find(|found| ESTIMATES.contains(&found.code)).cloned();
    always(folder.path(), what);
    for report in inspect_rows(folder.path(), 0..2) {
        assert_eq!(report.codes(), [faults.as_slice(), &[ProfileDiffers]].concat(), "{what}:\n{report}");
        assert!(found(&report).is_none(), "{what}:\n{report}");
    }
    let report = inspect(folder.path());
    assert_eq!(report.codes(), faults, "{what}:\n{report}");
    let found = found(&report).unwrap_or_else(|| panic!("{what} is not looked at:\n{report}"));
    assert!(found.code == code && found.fault.place.contains(place), "{what}:\n{report}");
    found.fault.what
}

#[test]
#[ignore = "long"]
fn copies_are_found() {
    let (from, to) = pair();
    let place = format!("samples {from} and {to}");
    let copied = |to: usize, change: &dyn Fn(Channel, usize, u16) -> u16, mirrored: bool| {
        let mut samples = boards().samples.clone();
        copy(&mut samples, from, to, change, mirrored);
        samples
    };
    told(copied(to, &|_, _, n| n, false), SampleRepeated, &place, "a copy under another name");
    // One digital number up or down, as a wrong rounding makes it.
    let jitter = |_, i: usize, n: u16| if n < 2 { n } else { n + (i * 7919 % 3) as u16 - 1 };
    let jitter = |channel, i, n| if channel == Channel::Reflectance && n == 255 { n } else { jitter(channel, i, n) };
    told(copied(to, &jitter, false), SampleAlike, &place, "a copy with a little noise");
    let darker = |channel, _, n: u16| if channel == Channel::Range { n } else { (n * 9).div_ceil(10) };
    told(copied(to, &darker, false), SampleAlike, &place, "a darker copy");
    let said = told(copied(to, &|_, _, n| n, true), SampleAlike, &place, "a mirrored copy");
    assert!(said.contains("mirrored") && said.contains("leaks"), "{said}");
    // Within a split nothing leaks.
    let split = boards().samples[from].split;
    let same =
        (from + 1..boards().samples.len()).find(|&i| boards().samples[i].split == split).expect("two of a split");
    let place = format!("samples {from} and {same}");
    let said = told(copied(same, &|_, _, n| n, true), SampleAlike, &place, "a mirrored copy in its split");
    assert!(!said.contains("leaks"), "{said}");
}
