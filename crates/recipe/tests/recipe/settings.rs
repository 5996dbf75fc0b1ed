//! Settings that mean nothing beside others are refused, with the words that their declarations give.

use crate::support::{GOOD, faults};

/// Each case: keys of a board, the key that is told, what is said of it.
const CASES: [(&str, &str, &str); 8] = [
    (
        "laser: {profile: point, fan: cylindrical}",
        "laser.fan",
        "has no effect on `profile: point`; it is for lines with a lens: remove it",
    ),
    (
        "camera: {lens: pinhole}",
        "camera.lens",
        "`pinhole` has no effect while `camera.scheimpflug` is `solved`: the laser plane is sharp anyway; give `given` \
         there, or remove it",
    ),
    (
        "exposure: {hdr: soft}\npostprocess: {order: blur_noise}",
        "exposure.hdr",
        "has no effect on order `blur_noise`; remove it, or give `order: physical`",
    ),
    (
        "speckle: {law: exponential}\npostprocess: {order: blur_noise}",
        "speckle.law",
        "has no effect on order `blur_noise`; remove it",
    ),
    (
        "picture: {pixel_mm: 0.2}",
        "picture.pixel_mm",
        "has no effect while `log.source` is `placed`; give `picture` there, or remove it",
    ),
    (
        "slices: {white_kg_per_m3: 1400}\nlog: {source: stem}",
        "slices.white_kg_per_m3",
        "has no effect while `log.source` is `stem`; give `slices` there, or remove it",
    ),
    (
        "picture: {gamma: 2}\nlog: {source: picture}",
        "picture.gamma",
        "has no effect beside `encoding: srgb`; it is for `encoding: gamma`: give that, or remove it",
    ),
    (
        "transport: {model: path, voxel_mm: 0.2}",
        "transport.voxel_mm",
        "has no effect on model `path`; it is for model `diffusion`: give `model: diffusion`, or remove it",
    ),
];

#[test]
fn settings_without_an_effect_are_told() {
    for (keys, key, told) in CASES {
        let faults = faults(&format!("{GOOD}{keys}\n"));
        let of_key = faults.list.iter().find(|fault| fault.key == key).unwrap_or_else(|| panic!("{keys}: {faults}"));
        assert_eq!(format!("{}; {}", of_key.problem, of_key.remedy), told, "{keys}");
    }
}

/// What is as it is by default is no fault, nor is what an object needs while nobody knows the object.
#[test]
fn defaults_and_unknown_subjects_are_left_alone() {
    for keys in ["laser: {profile: point, fan: powell}", "picture: {pixel_mm: 0.1}", "exposure: {hdr: none}"] {
        assert!(recipe::Recipe::parse("a.yaml", &format!("{GOOD}{keys}\n")).is_ok(), "{keys}");
    }
    let unknown = GOOD.replace("wood", "wod");
    assert_eq!(faults(&format!("{unknown}slices: {{white_kg_per_m3: 1400}}\n")).list.len(), 1);
}
