//! Datasets that are damaged in one way, and what validation says about them.

use std::path::Path;

use dataset::validate::{Code, ValidationOptions, ValidationReport, validate};
use dataset::{Dataset, Encoded, ExrChannel, Grey, read_exr, read_png, write_exr, write_png};
use optical_bench::settings::{Channel, Output};
use tempfile::TempDir;

pub use crate::damage::*;

use test_support::records::{SIZE, claimed, encoded, head, output, write_dataset};

/// A file of the damaged dataset.
pub const EXR: &str = "exr/00000/00000000-0000-5000-8000-000000000002.exr";

pub fn check(place: &TempDir) -> ValidationReport {
    let report = validate(place.path(), &ValidationOptions::default());
    // Both forms can be made of every report.
    assert_eq!(report.json()["faults"].as_array().map(Vec::len), Some(report.faults.len()));
    assert!(report.to_string().contains("faults"));
    report
}

/// A dataset of four samples, then `damage`, then what validation says.
pub fn after(damage: impl Fn(&Path)) -> Vec<Code> {
    let place = tempfile::tempdir().expect("a folder");
    write_dataset(place.path(), 4, &output());
    damage(place.path());
    check(&place).codes()
}

/// A dataset whose sample 2 was changed before it was written.
pub fn with(change: impl Fn(&mut Encoded)) -> Vec<Code> {
    with_output(&output(), change)
}

/// The same of a dataset that holds what `output` says.
pub fn with_output(output: &Output, change: impl Fn(&mut Encoded)) -> Vec<Code> {
    let place = tempfile::tempdir().expect("a folder");
    let folder = Dataset::open_or_create(place.path(), head(output, &SIZE, 4), false, &|| ()).expect("it opens");
    let mut writer = claimed(&folder, 0);
    for index in 0..4 {
        let mut sample = encoded(index, output);
        if index == 2 {
            change(&mut sample);
        }
        writer.push(sample).expect("it is written");
    }
    writer.finish().expect("it is finished");
    folder.complete(&|| ()).expect("the card is written");
    check(&place).codes()
}

pub fn png(sample: &mut Encoded, channel: Channel, change: impl Fn(&mut Vec<u16>)) {
    let place = sample.png.iter().position(|(c, _)| *c == channel).expect("the output asks for it");
    let (cols, _, image) = read_png(&sample.png[place].1).expect("it was just written");
    let mut numbers = image.numbers();
    change(&mut numbers);
    let grey = match image {
        Grey::Eight(_) => Grey::Eight(numbers.iter().map(|&n| n as u8).collect()),
        Grey::Sixteen(_) => Grey::Sixteen(numbers),
    };
    sample.png[place].1 = write_png(&grey, cols as usize);
}

pub fn exr(sample: &mut Encoded, change: impl Fn(&mut Vec<ExrChannel>)) {
    let (cols, _, mut channels, text) =
        read_exr(sample.exr.as_deref().expect("the output asks for it")).expect("it was just written");
    change(&mut channels);
    let description = serde_json::from_str(&text).expect("it is JSON");
    sample.exr = Some(write_exr(channels, cols, (0.04, 0.068), &description));
}
