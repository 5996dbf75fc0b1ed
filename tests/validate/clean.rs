//! A dataset as the writer makes it has no fault, and is what it would be if it were rendered again.

use dataset::validate::{ValidationOptions, validate};
use optical_bench::settings::{Channel, Output, SensorStack};
use test_support::records::{encoded, output, write_dataset};

#[test]
fn a_full_dataset_is_clean() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = output();
    write_dataset(folder.path(), 10, &output);
    let rerender = |index| Ok(encoded(index, &output));
    let report = validate(
        folder.path(),
        &ValidationOptions { rerender: Some(&rerender), rerender_samples: 4, ..ValidationOptions::default() },
    );
    assert!(report.is_clean(), "{report}");
    assert_eq!((report.shards, report.samples, report.rerendered), (3, 10, 4));
    // Five PNG and nine channels for each sample.
    assert_eq!(report.images, 10 * (5 + 9));
    assert_eq!(report.json()["clean"], true);
}

#[test]
fn a_small_output_is_clean() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let png = vec![Channel::Label, Channel::Range];
    let output = Output { png, exr: vec![], truth_maps: false, sensor_stack: SensorStack::None, ..output() };
    write_dataset(folder.path(), 3, &output);
    let report = validate(folder.path(), &ValidationOptions::default());
    assert!(report.is_clean(), "{report}");
    assert!(!folder.path().join("exr").exists() && !folder.path().join("stacks").exists());
}

#[test]
fn classes_are_those_of_the_subjects() {
    for (value, class) in base::Class::ALL.iter().enumerate() {
        assert_eq!(*class as usize, value);
    }
    assert_eq!(output_schema::SUBJECTS, recipe::Subject::NAMES);
    // Every class is of a subject, background apart.
    let subjects: Vec<Option<&str>> = base::Class::ALL.into_iter().map(base::Class::subject).collect();
    assert!(subjects[1..].iter().all(|own| own.is_some_and(|own| output_schema::SUBJECTS.contains(&own))));
}
