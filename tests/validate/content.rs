//! Samples that are wrong in themselves are reported as that kind of fault.

use crate::damaged::{MANIFEST, after, check, edit_json, exr, png, with, with_output};
use base::Class;
use dataset::validate::{Code, ValidationOptions, validate};
use dataset::{Encoded, ExrChannel, Grey, write_png};
use optical_bench::settings::{Channel, Output};
use output_schema::SampleType;
use serde_json::Value;
use test_support::records::{encoded, output, write_dataset};

#[test]
fn rows_against_manifest_and_head() {
    use Code::*;
    assert_eq!(
        after(|root| edit_json(&root.join(MANIFEST), |v| v["samples"][1]["class"] = "clear".into())),
        [RowDiffers, CardDiffers],
        "the card counts samples of each class"
    );
    let sum = "0".repeat(64);
    assert_eq!(
        after(|root| edit_json(&root.join(MANIFEST), |v| v["samples"][2]["sha256"] = sum.as_str().into())),
        [SampleChecksum]
    );
    let one_class = |v: &mut Value| v["classes"] = serde_json::json!(["clear"]);
    assert!(after(|root| edit_json(&root.join("dataset.json"), one_class)).contains(&SchemaDiffers));
    let id = encoded(0, &output()).id;
    let place = tempfile::tempdir().expect("a folder");
    write_dataset(place.path(), 4, &output());
    edit_json(&place.path().join(MANIFEST), |v| v["samples"][2]["id"] = id.as_str().into());
    let codes = check(&place).codes();
    assert!(codes.contains(&IdRepeated) && codes.contains(&RowDiffers), "{codes:?}");
    // Areas follow from it, and the EXR file repeats it.
    assert_eq!(with(|sample| sample.row_mm = -1.0), [ValueRange, ObjectDiffers, ExrDiffers]);
    assert!(with(|sample| sample.range_scale = f64::NAN).contains(&ValueRange));
    assert_eq!(with(|sample| sample.draws[0].1 = f64::NAN), [NumberMissing]);
}

#[test]
fn images() {
    use Code::*;
    assert_eq!(with(|sample| sample.png[1].1.truncate(60)), [ImageUnreadable]);
    assert_eq!(with(|sample| sample.png[4].1 = write_png(&Grey::Sixteen(vec![0; 12]), 4)), [ImageSize]);
    let shallow = |sample: &mut Encoded| sample.png[4].1 = write_png(&Grey::Eight(vec![0; 48 * 32]), 48);
    assert_eq!(with(shallow), [ImageSize]);
    // Light without range: the EXR file disagrees too.
    let dark = |n: &mut Vec<u16>| n[100] = 0;
    assert_eq!(with(|sample| png(sample, Channel::Range, dark)), [MissingRule, ShareDiffers, ExrDiffers]);
    assert_eq!(with(|sample| png(sample, Channel::Range, |n| n[100] += 5)), [ExrDiffers]);
    assert_eq!(with(|sample| png(sample, Channel::Label, |n| n[100] = 77)), [LabelUnknown, InstanceClass, ExrDiffers]);
}

#[test]
fn labels() {
    use Code::*;
    assert_eq!(with(|sample| sample.objects[0].area_px += 1), [ObjectDiffers]);
    assert_eq!(with(|sample| sample.objects[0].bbox[0] += 1), [ObjectDiffers]);
    assert_eq!(with(|sample| sample.objects[0].bbox[2] = 4000), [ValueRange, ObjectDiffers]);
    assert_eq!(with(|sample| sample.objects.truncate(1)), [ObjectDiffers]);
    assert_eq!(with(|sample| sample.objects.reverse()), [ObjectDiffers]);
    assert_eq!(with(|sample| sample.objects[0].instance.within = 2), [ValueRange]);
    // What lies in an object counts for it.
    assert_eq!(with(|sample| sample.objects[1].instance.within = 1), [ObjectDiffers]);
    assert_eq!(with(|sample| sample.objects[0].instance.state = Class::Pocket), [ValueRange]);
    assert_eq!(with(|sample| _ = sample.defects.pop()), [ObjectDiffers]);
    assert_eq!(with(|sample| sample.defects.push(Class::Missing)), [ValueRange]);
    assert_eq!(with(|sample| sample.unseen.push(Class::Missing)), [ValueRange]);
    let swap = |sample: &mut Encoded| sample.class_area_px.swap(1, 2);
    assert_eq!(with(swap), [ClassAreaDiffers]);
    assert_eq!(with(|sample| png(sample, Channel::Instance, |n| n[0] = 9)), [ObjectDiffers, ExrDiffers]);
}

#[test]
fn exr_files() {
    use Code::*;
    assert_eq!(with(|sample| exr(sample, |channels| _ = channels.pop())), [ExrChannels]);
    assert_eq!(with(|sample| exr(sample, |channels| channels[0].name = "Aha".into())), [ExrChannels]);
    let float = |channels: &mut Vec<ExrChannel>| channels[4].samples = SampleType::Float;
    assert_eq!(with(|sample| exr(sample, float)), [ExrChannels]);
    let shift = |channels: &mut Vec<ExrChannel>| {
        channels[5].numbers.iter_mut().for_each(|z| *z += 0.0012);
    };
    assert_eq!(with(|sample| exr(sample, shift)), [ExrDiffers]);
    let steep = |channels: &mut Vec<ExrChannel>| channels[1].numbers.fill(120.0);
    assert_eq!(with(|sample| exr(sample, steep)), [ValueRange]);
    assert_eq!(with(|sample| sample.exr = encoded(3, &output()).exr), [ExrDiffers]);
}

/// Numbers in tables and what they leave in EXR files are one Range.
#[test]
fn rests_of_range() {
    use Code::*;
    let lean = Output { exr: Vec::new(), range_rest: true, ..output() };
    let rest = |change: fn(&mut f32)| {
        with_output(&lean, |sample| {
            exr(sample, |channels| {
                let channel = channels.iter_mut().find(|channel| channel.name == "RangeRest").expect("it is asked for");
                change(channel.numbers.iter_mut().find(|rest| **rest > 0.0).expect("the first height is new"));
            });
        })
    };
    assert_eq!(rest(|_| ()), []);
    // A number is 16 steps of files: they leave eight of them at most.
    assert_eq!(rest(|rest| *rest += 30.0), [ExrDiffers]);
    assert_eq!(rest(|rest| *rest = 0.0), [ExrDiffers]);
    assert_eq!(with_output(&lean, |sample| png(sample, Channel::Range, |n| n[100] += 5)), [ExrDiffers]);
}

#[test]
fn sensor_frames() {
    assert_eq!(with(|sample| _ = sample.stack.pop()), [Code::StackDiffers]);
    assert_eq!(with(|sample| sample.stack[1].profile = 9), [Code::StackDiffers]);
    assert_eq!(with(|sample| sample.stack.swap(0, 1)), [Code::StackDiffers]);
}

#[test]
fn rendered_again() {
    let place = tempfile::tempdir().expect("a folder");
    write_dataset(place.path(), 4, &output());
    let run = |render: &(dyn Fn(u64) -> Result<Encoded, String> + Sync)| {
        validate(
            place.path(),
            &ValidationOptions { rerender: Some(render), rerender_samples: 9, ..ValidationOptions::default() },
        )
    };
    assert_eq!(run(&|i| Ok(encoded(i, &output()))).codes(), []);
    assert_eq!(run(&|i| Err(format!("no recipe for {i}"))).codes(), [Code::RerenderFailed]);
    let other = run(&|i| {
        let mut sample = encoded(i, &output());
        sample.draws[0].1 += 1e-9;
        Ok(sample)
    });
    assert_eq!((other.codes(), other.rerendered), (vec![Code::RerenderDiffers], 4));
    assert!(other.faults[0].fault.what.contains("laser"), "{other}");
    let frame = run(&|i| {
        let mut sample = encoded(i, &output());
        sample.stack[2].dn[7] ^= 1;
        Ok(sample)
    });
    assert!(frame.faults.len() == 4 && frame.faults[0].fault.what.contains("sensor frames"), "{frame}");
}
