//! Datasets whose Range is sensor rows or lies on an even grid, as their users make, check, export and compare them.

use dataset::read_exr;
use serde_json::Value;
use test_support::program::{self, Place, SPECKLE};
use tools::icon::{Content, IconScan, PlaneContent, PlaneNumbers, Traits, open};

/// A dataset of two samples whose Range has a form.
fn planks(range: &str, changes: &[[&str; 2]]) -> Place {
    let line = format!("\n  range: {range}\n  window_rows: 7");
    let changes: Vec<[&str; 2]> =
        [SPECKLE, ["\n  window_rows: 7", line.as_str()]].into_iter().chain(changes.iter().copied()).collect();
    let place = Place::with(&changes);
    place.make("planks", "--n 2");
    place
}

/// Channels of a sample's EXR file by name, and its description.
fn exr(place: &Place, index: u64) -> (Vec<(String, Vec<f32>)>, Value) {
    let files = std::fs::read_dir(place.path("planks/exr/00000")).expect("EXR files are there");
    for path in files.flatten().map(|entry| entry.path()) {
        let (_, _, channels, text) = read_exr(&std::fs::read(path).expect("it can be read")).expect("it is whole");
        let said: Value = serde_json::from_str(&text).expect("it is JSON");
        if said["index"] == index {
            return (channels.into_iter().map(|c| (c.name, c.numbers)).collect(), said);
        }
    }
    panic!("sample {index} is not there")
}

fn scan(place: &Place, name: &str) -> IconScan {
    let Ok(Content::Scan(mut reader)) = open(&place.path(name)) else { panic!("{name} is no scan") };
    let rows = reader.rows();
    reader.read(0, rows).expect("it is whole")
}

fn channel<'a>(channels: &'a [(String, Vec<f32>)], name: &str) -> &'a [f32] {
    &channels.iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("no channel {name}")).1
}

/// Each form says its unit in `dataset.json`, in the files and in the card, and passes its check to the last bit.
#[test]
fn forms_say_what_they_are() {
    for (range, unit) in [("calibrated", "mm"), ("uncalibrated", "px"), ("rectified", "mm")] {
        let place = planks(range, &[]);
        let head = place.json("planks/dataset.json");
        assert_eq!(head["images"]["range"], range);
        let (_, said) = exr(&place, 1);
        assert_eq!((&said["units"]["Range"], &said["range"]), (&Value::from(unit), &Value::from(range)));
        assert_eq!(said["calibration"]["x_first_mm"].is_number(), range == "rectified", "{said}");
        let card = std::fs::read_to_string(place.path("planks/README.md")).expect("the card is there");
        assert!(card.contains(&format!("`range_scale_{unit}`")) && card.contains(&format!("Range [{unit}]")), "{card}");
        assert!(!card.contains(&format!("`range_scale_{}`", if unit == "px" { "mm" } else { "px" })));
        let run = place.run("validate planks --rerender 2");
        assert_eq!(run.code, 0, "{range}: {}{}", run.out, run.err);
    }
}

/// Readers that take 16-bit images for signed numbers see no height as negative, whatever the object.
#[test]
fn heights_fit_signed_numbers_of_16_bits() {
    for place in Place::of_each_subject(&[]) {
        place.make("set", "--n 2");
        for (index, sample) in place.samples("set") {
            let (_, _, numbers) = sample.image("range");
            let most = numbers.iter().max().copied().unwrap_or(0);
            assert!((1..=32767).contains(&most), "sample {index}: {most}");
        }
    }
}

/// Keys without an effect are refused with the key that wakes them up.
#[test]
fn idle_keys_are_refused() {
    for (line, words) in [
        ("fir_length: 5", "it is for `method: fir`"),
        ("blais_rioux_order: 4", "it is for `method: blais_rioux`"),
        ("method: parabola", "no effect beside `method: parabola`"),
        ("rectified_pitch_mm: 0.1", "it is for `range: rectified`"),
    ] {
        let text = format!("\n  {line}\n  window_rows: 7");
        let place = Place::with(&[["\n  method: centre_of_gravity", ""], ["\n  window_rows: 7", &text]]);
        let run = place.run("--recipe tiny.yaml --n 1 --out planks");
        assert!(run.code != 0 && run.err.contains(words), "{line}: {}", run.err);
    }
}

/// Sensor rows become an uncalibrated scan, number by number: sixteenths of rows, light, sums, and notes of each
/// profile.
#[test]
fn sensor_rows_become_uncalibrated_scans() {
    let place = planks("uncalibrated", &[]);
    place.done("export icon planks --index 1 --out rows --rate 7000");
    let (scan, (channels, said)) = (scan(&place, "rows/00000001"), exr(&place, 1));
    let Traits::Sensor(sensor) = scan.traits else { panic!("it is calibrated") };
    assert_eq!(
        (u64::from(sensor.region_rows), sensor.scale),
        (said["sensor_rows"].as_u64().unwrap_or(0), [1.0, 0.0625])
    );
    let planes = [PlaneContent::Range, PlaneContent::Reflectance, PlaneContent::Scatter];
    let [Some(PlaneNumbers::Word(steps)), Some(PlaneNumbers::Byte(light)), Some(PlaneNumbers::Word(sums))] =
        planes.map(|part| scan.plane(part))
    else {
        panic!("it has other planes")
    };
    let maps = ["Range", "Reflectance", "Scatter"].map(|name| channel(&channels, name));
    for i in 0..steps.len() {
        let of = |map: &[f32], scale: f32| if maps[0][i].is_nan() { 0.0 } else { map[i] * scale };
        assert_eq!(f32::from(steps[i]), of(maps[0], 16.0), "Range of pixel {i}");
        assert_eq!(
            (f32::from(light[i]), f32::from(sums[i])),
            (of(maps[1], 1.0), of(maps[2], 1.0)),
            "light of pixel {i}"
        );
    }
    assert!(steps.contains(&0) && steps.iter().any(|n| *n > 0));
    let marks = scan.marks().expect("each profile has notes");
    assert_eq!((marks.len(), marks[0].encoder, marks[0].timestamp), (48, 0, 0));
    let step = said["row_mm"].as_f64().expect("it is a number");
    assert_eq!(marks[47].encoder, (47.0 * step * 1000.0).round() as i32);
    assert_eq!(marks[7].timestamp, 1000, "seven profiles of 1/7000 s are a millisecond");
    let told = place.run("icon rows/00000001.xml");
    assert!(
        told.out.contains("uncalibrated") && told.out.contains("Range WORD") && told.out.contains(" px"),
        "{}",
        told.out
    );
    // Means of rows are no sensor rows.
    let binned = planks("uncalibrated", &[["  bin: {columns: 1, profiles: 1}", "  bin: {columns: 2, profiles: 1}"]]);
    let run = binned.run("export icon planks --index 0 --out rows");
    assert!(run.code != 0 && run.err.contains("without `output: {bin: ..}`"), "{}", run.err);
}

/// A rectified scan spans the grid that it says; read back its heights are equal, but for 0, which means missing there
/// and is written as the least number above.
#[test]
fn rectified_scans_keep_their_grid() {
    let place = planks("rectified\n  rectified_pitch_mm: 0.1", &[]);
    place.done("export icon planks --index 0 --out grid");
    let (scan, (channels, said)) = (scan(&place, "grid/00000000"), exr(&place, 0));
    let Traits::World(world) = scan.traits else { panic!("it is uncalibrated") };
    let first = said["calibration"]["x_first_mm"].as_f64().expect("it is a number");
    assert!((world.col_mm(64) - 0.1).abs() < 1e-12 && (world.lower[0] + 0.05 - first).abs() < 1e-12, "{world:?}");
    assert_eq!(said["col_mm"], 0.1);
    let heights = channel(&channels, "Range");
    assert!(
        scan.heights()
            .iter()
            .zip(heights)
            .all(|(a, b)| (a.is_nan() && b.is_nan()) || (a - f64::from(*b)).abs() < 1e-30)
    );
    assert!(scan.marks().is_some() && heights.iter().any(|z| z.is_finite()));
}

/// Sensor rows are compared with sensor rows, from dataset, EXR and iCon alike, and with nothing else.
#[test]
fn sensor_rows_are_compared_with_their_kind() {
    let place = planks("uncalibrated", &[program::FRAMES]);
    place.done("export icon planks --index 0 --out scan");
    let run = place.run("compare planks planks --whole --json --scans 1");
    let both: Value = serde_json::from_str(&run.out).expect("it prints JSON");
    let run = place.run("compare planks scan/00000000.xml --whole --json --scans 1");
    let other: Value = serde_json::from_str(&run.out).expect("it prints JSON");
    assert_eq!(other["sim"]["range_noise_mpx"], other["real"]["range_noise_mpx"]);
    assert_eq!(both["sim"]["range_noise_mpx"], other["sim"]["range_noise_mpx"]);
    assert!(
        both["sim"]["range_noise_mpx"]["along"].as_f64().is_some_and(|noise| (5.0..2000.0).contains(&noise)),
        "{both}"
    );
    for name in ["line_width_px", "line_sigma_px"] {
        assert_eq!(both["distances"][name]["ks"], 0.0, "{name}");
        assert!(both["sim"][name]["p50"].as_f64().is_some_and(|px| px > 0.3));
    }
    let table = place.run("compare planks scan/00000000.xml").out;
    assert!(table.contains("range noise, along the line [mpx]"), "{table}");
    let heights = planks("calibrated", &[]);
    let path = heights.path("planks");
    let run = place.run(&format!("compare planks {}", path.display()));
    assert!(run.code != 0 && run.err.contains("one side has heights, the other sensor rows"), "{}", run.err);
}
