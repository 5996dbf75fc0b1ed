//! Lists of classes that stand for an image: `defect_classes` says what at least one pixel shows and nothing else,
//! `unseen_classes` what the object has beside it. A list of what the object has is no list of what an image shows.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

use base::Class;
use dataset::validate::Code::*;
use dataset::{Encoded, read_png};
use optical_bench::settings::Channel;
use output_schema::DatasetHead;
use serde_json::json;

use super::place::{codes_of, edit, inspect, of_recipe, write_as};
use test_support::program::{pack_recipe, recipe};

/// A head and its samples.
type Samples = (DatasetHead, Vec<Encoded>);

/// Boards of which every second has its pith in the face, binned so that small things are lost; rendered once.
fn boards() -> &'static Samples {
    static BOARDS: OnceLock<Samples> = OnceLock::new();
    BOARDS.get_or_init(|| {
        let pith = "pith_mm: 1.5\n  pith_depth_mm: {choice: {values: [0.2, 60]}}\n  pith_offset_mm: 0\n";
        let text = recipe(&[
            ["bin: {columns: 1, profiles: 1}", "bin: {columns: 2, profiles: 2}"],
            // The field of the whole recipe.
            ["step_mm: 0.068", "step_mm: 0.36"],
            ["pixel_um: 6", "pixel_um: 24"],
            ["pith_depth_mm: {uniform: [30, 110]}\n  pith_offset_mm: {normal: {mean: 0, sd: 35}}\n", pith],
            ["png: [range, reflectance, scatter, label]", "png: [range, reflectance, scatter, label, instance]"],
        ]);
        of_recipe(&text, 16)
    })
}

/// The numbers of an image as it is stored.
fn numbers(sample: &Encoded, channel: Channel) -> Vec<u16> {
    let (_, png) = sample.png.iter().find(|(known, _)| *known == channel).expect("the recipe asks for it");
    read_png(png).expect("it was just written").2.numbers()
}

#[test]
#[ignore = "long"]
fn tags_are_what_pixels_show() {
    // Of packs a part lies in the field.
    for (name, (head, samples)) in [("boards", boards().clone()), ("packs", of_recipe(&pack_recipe(&[]), 12))] {
        let (mut shown, mut unseen) = (0, 0);
        for sample in &samples {
            let (label, instance) = (numbers(sample, Channel::Label), numbers(sample, Channel::Instance));
            let class = |value: u16| Class::ALL[usize::from(value)];
            let own: BTreeMap<u16, Class> =
                instance.iter().zip(&label).map(|(&id, &label)| (id, class(label))).collect();
            let defects: Vec<Class> =
                own.into_iter().filter(|(id, class)| *id > 0 && class.is_defect()).map(|own| own.1).collect();
            assert_eq!(sample.defects, defects, "{name}, sample {}", sample.index);
            let pixels: BTreeSet<Class> =
                label.iter().map(|&label| class(label)).filter(|class| class.is_defect()).collect();
            assert_eq!(sample.defects.iter().copied().collect::<BTreeSet<_>>(), pixels);
            (shown, unseen) = (shown + defects.len(), unseen + sample.unseen.len());
        }
        println!("{name}: {shown} defects show, {unseen} do not");
        assert!(shown > 0 && unseen > 8, "{name}: {shown} shown, {unseen} not");
        assert_eq!(codes_of(&head, samples, name), [], "{name}");
    }
}

#[test]
#[ignore = "long"]
fn tags_are_held_to_images_and_body() {
    let (head, samples) = boards();
    let has_both = |sample: &Encoded| !sample.defects.is_empty() && !sample.unseen.is_empty();
    let place = samples.iter().position(has_both).expect("some show and some do not");
    let codes = |change: fn(&mut Encoded)| {
        let mut samples = samples.clone();
        change(&mut samples[place]);
        codes_of(head, samples, "other lists of classes")
    };
    // What was listed of old: all that the object has.
    assert_eq!(codes(|s| s.defects.append(&mut s.unseen)), [ObjectDiffers]);
    assert_eq!(codes(|s| s.unseen.append(&mut s.defects)), [ObjectDiffers]);
    assert!(codes(|s| std::mem::swap(&mut s.unseen, &mut s.defects)).contains(&ObjectDiffers));
    assert_eq!(codes(|s| s.unseen.clear()), [DrawDiffers]);
    assert_eq!(codes(|s| s.unseen[0] = Class::Wane), [DrawDiffers]);
    assert_eq!(codes(|s| s.unseen[0] = Class::Tooth), [DrawDiffers, ValueRange]);
}

/// Before 1.7 one list has all defects, seen or not: such datasets stay right, and an object's class that is not in it
/// stays a fault.
#[test]
fn older_datasets_keep_their_meaning() {
    let (mut head, mut samples) = boards().clone();
    head.schema_version = [1, 6];
    for sample in &mut samples {
        let unseen = std::mem::take(&mut sample.unseen);
        sample.defects.extend(unseen);
    }
    let codes = |samples: &[Encoded]| {
        let place = write_as(head.clone(), samples.to_vec());
        edit(&place.path().join("shards/00000.json"), |v| v["schema_version"] = json!([1, 6]));
        inspect(place.path()).codes()
    };
    assert_eq!(codes(&samples), [VersionDiffers]);
    samples.iter_mut().for_each(|sample| sample.defects.clear());
    assert_eq!(codes(&samples), [VersionDiffers, ObjectDiffers]);
}
