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
fn pixel_classes_are_those_of_the_labels() {
    let names: Vec<&str> = base::Class::ALL.iter().map(|class| class.name()).collect();
    assert_eq!(names, output_schema::PIXEL_CLASSES);
    for (value, class) in base::Class::ALL.iter().enumerate() {
        assert_eq!(*class as usize, value);
    }
    let subjects: Vec<&str> = output_schema::SUBJECTS.iter().map(|subject| subject.name).collect();
    assert_eq!(subjects, recipe::Subject::NAMES);
    // Together the subjects have every class once, background apart.
    let own =
        output_schema::SUBJECTS.iter().flat_map(|subject| subject.runs.iter().flat_map(|run| run.first..=run.last));
    let mut own: Vec<usize> = own.map(usize::from).collect();
    own.sort_unstable();
    assert_eq!(own, (1..names.len()).collect::<Vec<_>>());
}
