//! Damage that only what follows without light gives away, and datasets that look odd but are not damaged.

use std::fmt::Write;
use std::fs;

use base::{Class, KnotNames, KnotPlace};
use dataset::validate::Code;
use dataset::validate::Code::*;
use dataset::{Dataset, Encoded};
use output_schema::{OLDEST_MINOR, SCHEMA_VERSION};

use serde_json::json;

use super::place::{boards, codes_of, edit, inspect, whole};
use test_support::program::Place;

/// Asks for exactly these codes after a change of one sample with objects, before it is written.
fn with(what: &str, change: impl Fn(&mut Encoded), codes: &[Code]) {
    let mut samples = boards().samples.clone();
    let has_knot = |sample: &&mut Encoded| sample.objects.first().is_some_and(|o| !o.instance.diameter_mm.is_nan());
    change(samples.iter_mut().find(has_knot).expect("boards have knots"));
    assert_eq!(codes_of(&boards().head, samples, what), codes, "{what}");
}

#[test]
#[ignore = "long"]
fn what_follows_without_light_is_held_to_the_recipe() {
    with("nothing", |_| (), &[]);
    let state = |s: &mut Encoded| {
        let own = &mut s.objects[0].instance.state;
        *own = if *own == Class::Rot { Class::SoundKnot } else { Class::Rot };
    };
    with("another state", state, &[DrawDiffers]);
    with("a place far away", |s| s.objects[0].instance.x_mm = -1e6, &[DrawDiffers]);
    with("another diameter", |s| s.objects[0].instance.diameter_mm *= 7.0, &[DrawDiffers]);
    with("a severity of a knot", |s| s.objects[0].instance.severity = 0.5, &[DrawDiffers]);
    with("a depth of a knot", |s| s.objects[0].instance.depth_mm = 0.5, &[DrawDiffers]);
    let [is_spike, is_pin, is_clustered, is_cracked] = [true; 4];
    let names = KnotNames { place: KnotPlace::Arris, is_spike, is_pin, is_clustered, is_cracked };
    with("other names of a knot", |s| s.objects[0].instance.knot = Some(names), &[DrawDiffers]);
    with("another extent", |s| s.objects[0].extent_mm[0] *= 2.0, &[ObjectDiffers]);
    with("another derived number", |s| s.physics[0].1 = 3.0 * s.physics[0].1 + 1.0, &[DrawDiffers]);
    with("defects listed twice", |s| s.defects.extend(s.defects.clone()), &[DrawDiffers, ObjectDiffers]);
    with("a pith that is not there", |s| s.unseen.push(Class::Pith), &[DrawDiffers]);
}

#[test]
fn a_head_that_all_manifests_contradict_is_told_once() {
    let place = whole();
    edit(&place.path().join("dataset.json"), |v| v["seed"] = json!(6));
    let report = inspect(place.path());
    assert_eq!((report.codes(), report.faults.len()), (vec![DatasetDiffers], 1), "{report}");
    assert!(
        report.faults[0].fault.place == "dataset.json" && !report.to_string().contains("manifest and run"),
        "{report}"
    );
}

#[test]
#[ignore = "long"]
fn another_minor_version_destroys_nothing() {
    for minor in (OLDEST_MINOR..SCHEMA_VERSION[1] + 2).filter(|&minor| minor != SCHEMA_VERSION[1]) {
        let place = whole();
        for path in ["dataset.json", "shards/00000.json", "shards/00001.json"] {
            edit(&place.path().join(path), |v| v["schema_version"] = json!([1, minor]));
        }
        let report = inspect(place.path());
        assert_eq!((report.codes(), report.faults.len()), (vec![VersionDiffers], 1), "{report}");
        assert!(!report.to_string().contains("remove"), "{report}");
    }
}

#[test]
fn a_huge_head_ends_at_once() {
    let place = whole();
    edit(&place.path().join("dataset.json"), |v| {
        v["samples"] = u64::MAX.into();
        v["shards"] = u64::MAX.into();
        v["samples_per_shard"] = 1.into();
    });
    assert_eq!(inspect(place.path()).codes(), [DatasetUnreadable]);
    let told = Dataset::open(place.path()).expect_err("it is refused").to_string();
    assert!(told.contains("at most 100000000 samples in 100000 shards"), "{told}");
}

#[test]
fn many_missing_shards_are_one_fault() {
    let place = whole();
    edit(&place.path().join("dataset.json"), |v| (v["samples"], v["shards"]) = (300.into(), 100.into()));
    let report = inspect(place.path());
    let missing: Vec<&str> =
        report.faults.iter().filter(|f| f.code == ManifestMissing).map(|f| &*f.fault.place).collect();
    assert_eq!(missing, ["shards/00002.json to shards/00099.json"], "{report}");
}

#[test]
fn a_missing_table_does_not_fault_the_card() {
    let place = whole();
    let table = fs::read_dir(place.path().join("data")).expect("there").next().expect("a table").expect("listed");
    fs::write(table.path(), "").expect("written");
    assert_eq!(inspect(place.path()).codes(), [FileSize]);
}

#[test]
fn parts_that_were_copied_together_are_told_how_to_end() {
    let place = Place::with(&[]);
    for part in [0, 1] {
        let run = place.make(&format!("p{part}"), &format!("--n 2 --samples-per-shard 1 --part {part}/2"));
        assert!(run.err.contains("run the command once more there, without --part"), "{}", run.err);
    }
    for path in place
        .tree("p1")
        .into_keys()
        .filter(|path| path.starts_with("data") || path.starts_with("exr") || path.starts_with("shards"))
    {
        let to = place.path("p0").join(&path);
        fs::create_dir_all(to.parent().expect("a folder")).expect("made");
        fs::copy(place.path("p1").join(&path), to).expect("copied");
    }
    let report = inspect(&place.path("p0"));
    let ends = |fault: &dataset::validate::Finding| fault.code == CardDiffers && fault.fault.remedy.contains("--part");
    assert!(!report.is_clean() && report.faults.iter().all(ends), "{report}");
    place.make("p0", "--n 2 --samples-per-shard 1");
    assert!(inspect(&place.path("p0")).is_clean());
}

#[test]
fn sloping_sides_are_no_fault() {
    let place = Place::new();
    let mut cone = String::from("v 0 0 6\n");
    for k in 0..64 {
        let (sin, cos) = libm::sincos(f64::from(k) * std::f64::consts::TAU / 64.0);
        writeln!(cone, "v {} {} 0", 4.0 * cos, 4.0 * sin).expect("a text grows");
    }
    (0..64).for_each(|k| writeln!(cone, "f 1 {} {}", k + 2, (k + 1) % 64 + 2).expect("a text grows"));
    place.write("cone.obj", cone);
    let text = include_str!("../../../recipes/mesh-small.yaml").replacen("meshes/clip.obj", "cone.obj", 1);
    place.write("tiny.yaml", text);
    place.make("set", "--n 4");
    let report = inspect(&place.path("set"));
    assert!(report.is_clean() && report.samples == 4, "{report}");
}

#[test]
fn a_folder_without_a_readable_head_keeps_nothing() {
    let place = Place::new();
    fs::create_dir(place.path("set")).expect("made");
    let run = place.run("validate set --save");
    assert!(run.code == 1 && run.err.contains("validate without --save") && run.out.is_empty(), "{}", run.err);
}
