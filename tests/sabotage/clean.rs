//! Datasets of every subject, depth and choice of files as the program makes them have no fault.

use crate::gen_support::{FRAMES, Place};
use crate::place::inspect;

#[test]
fn clean_datasets_of_every_subject() {
    for place in Place::of_each_subject(&[FRAMES]) {
        place.make("set", "--n 8 --samples-per-shard 3");
        let report = inspect(&place.path("set"));
        assert!(report.is_clean() && report.samples == 8, "{report}");
    }
}

#[test]
fn clean_datasets_of_other_files() {
    let exr = ["png: [range, reflectance, scatter, label]", "png: []"];
    let binned = ["bin: {columns: 1, profiles: 1}", "bin: {columns: 2, profiles: 3}"];
    let wide = ["\nexposure:", "\nexposure:\n  bits: 10"];
    let pixels = ["\nextraction:", "\nextraction:\n  range: sensor_row"];
    for change in [exr, binned, wide, pixels] {
        let place = Place::with(&[change]);
        place.make("set", "--n 6");
        let report = inspect(&place.path("set"));
        assert!(report.is_clean() && report.samples == 6, "{}:\n{report}", change[1]);
    }
}
