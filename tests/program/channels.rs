//! Binning, chosen channels and kept sensor frames: what the recipe asks for is on disk, and nothing else.

use std::collections::BTreeMap;

use dataset::{range_joined, range_values, read_exr};
use parquet::record::Field;
use test_support::program::{Place, Sample, rows, tree};

const BIN: [&str; 2] = ["bin: {columns: 1, profiles: 1}", "bin: {columns: 2, profiles: 4}"];
const PNG: [&str; 2] = ["png: [range, reflectance, scatter, label]", "png: [range, label]"];
const EXR: [&str; 2] = ["exr: [range, reflectance, scatter, label, instance] ", "exr: [] "];
const TRUTH: [&str; 2] = ["truth_maps: true", "truth_maps: false"];
const NAMES: [&str; 5] = ["range", "reflectance", "scatter", "label", "instance"];

#[test]
fn a_lean_dataset_holds_what_was_asked_for() {
    let place = Place::with(&[BIN, PNG, EXR, TRUTH, ["sensor_stack: none", "sensor_stack: {every: 16}"]]);
    place.make("set", "--n 4 --samples-per-shard 3");
    let files = place.tree("set");
    assert!(!files.keys().any(|name| name.starts_with("exr")), "{:?}", files.keys());
    assert!(!place.path("set/exr").exists());
    for (index, sample) in place.samples("set") {
        for channel in NAMES {
            let there = sample.columns.keys().any(|name| name.starts_with(&format!("{channel}.")));
            assert_eq!(there, ["range", "label"].contains(&channel), "sample {index}: {channel}");
        }
        let sizes = ["range", "label"].map(|channel| sample.image(channel)).map(|(w, h, _)| (w, h));
        assert_eq!(sizes, [(32, 12); 2]);
        assert_eq!([&sample.columns["cols"], &sample.columns["rows"]], [&Field::Int(32), &Field::Int(12)]);
    }
    assert_frames(&place, 4, 3, 16);
    place.done("validate set --rerender 4");
}

/// Channels of an EXR file by name, as bits; none where there is no file.
fn bits_of(sample: &Sample) -> BTreeMap<String, Vec<u32>> {
    if sample.exr.is_empty() {
        return BTreeMap::new();
    }
    let (.., channels, _) = read_exr(&sample.exr).expect("it is EXR");
    channels.into_iter().map(|c| (c.name, c.numbers.into_iter().map(f32::to_bits).collect())).collect()
}

/// The images of a row as an EXR file of everything has them: NaN where Range, or Reflectance, has found no line.
/// `rest` is what whole numbers leave of Range.
fn channels_of_row(sample: &Sample, rest: Option<&[f32]>) -> BTreeMap<String, Vec<u32>> {
    let has = |name: &str| sample.columns.contains_key(&format!("{name}.bytes"));
    let found = ["range", "reflectance"].into_iter().find(|name| has(name)).map(|name| sample.image(name).2);
    let mut channels = BTreeMap::new();
    for (name, channel) in NAMES.into_iter().zip(["Range", "Reflectance", "Scatter", "Label", "Instance"]) {
        if !has(name) {
            continue;
        }
        let pixels = sample.image(name).2;
        let numbers: Vec<f32> = match channel {
            "Range" => {
                let scale = |what: &str| {
                    let name = ["mm", "px"].map(|unit| format!("range_{what}_{unit}"));
                    let value = name.iter().find_map(|name| sample.columns.get(name));
                    let Some(Field::Double(value)) = value else { panic!("no {what}") };
                    *value
                };
                match rest {
                    None => range_values(&pixels, scale("offset"), scale("scale")),
                    Some(rest) => {
                        let cols = sample.image(name).0 as usize;
                        range_joined(&pixels, rest, cols, scale("offset"), scale("scale")).expect("images of one size")
                    }
                }
            }
            "Reflectance" | "Scatter" => {
                let seen = |(i, &dn): (usize, &u16)| match &found {
                    Some(found) if found[i] == 0 => f32::NAN,
                    _ => f32::from(dn),
                };
                pixels.iter().enumerate().map(seen).collect()
            }
            _ => pixels.iter().map(|&n| f32::from(n)).collect(),
        };
        channels.insert(channel.to_owned(), numbers.into_iter().map(f32::to_bits).collect());
    }
    channels
}

/// Unless a recipe says otherwise, EXR files hold what tables cannot, and both together hold to the last bit what files
/// of everything hold: of scans of rows the truth alone, else what is no whole number, as heights and means are.
#[test]
fn files_hold_what_tables_lack() {
    const TRUTH: [&str; 3] = ["FibreAzimuth", "FibreDive", "Height"];
    const LIGHT: [&str; 3] = ["RangeRest", "Reflectance", "Scatter"];
    let place = Place::new();
    for (number, (settings, more)) in [
        ("", &["Instance", "RangeRest"][..]),
        ("--set output.png=[range,reflectance,scatter,label,instance]", &["RangeRest"]),
        ("--set extraction.range=uncalibrated --set exposure.bits=12", &["Instance"]),
        ("--set extraction.scatter_dark=subtracted", &["Instance", "RangeRest", "Scatter"]),
        ("--set output.png=[scatter,label]", &["Instance", "Range", "Reflectance", "Scatter"]),
        ("--set output.bin={\"columns\":2,\"profiles\":4}", &["Instance", LIGHT[0], LIGHT[1], LIGHT[2]]),
        ("--set extraction.range=rectified", &["Instance", LIGHT[0], LIGHT[1], LIGHT[2]]),
        ("--set extraction.range=uncalibrated --set extraction.subpixel_steps=0", &["Instance", "RangeRest"]),
        ("--set extraction.range=uncalibrated --set extraction.subpixel_steps=256", &["Instance", "RangeRest"]),
    ]
    .into_iter()
    .enumerate()
    {
        let make = |name: &str, exr: &str| {
            let size = "--set scan.columns=64 --set scan.profiles=16";
            let name = format!("{name}-{number}");
            place.done(&format!(
                "--recipe wood-small --n 2 --out {name} --quiet {size} --set output.exr={exr} {settings}"
            ));
            place.samples(&name)
        };
        let (lean, whole) = (make("lean", "auto"), make("whole", "all"));
        for (index, sample) in &lean {
            let mut held = bits_of(sample);
            let mut expected: Vec<&str> = TRUTH.iter().chain(more).copied().collect();
            // The picture for viewers goes with Reflectance.
            expected.extend(expected.contains(&"Reflectance").then_some("Y"));
            expected.sort_unstable();
            assert_eq!(held.keys().collect::<Vec<_>>(), expected, "{settings}");
            let rest = held.remove("RangeRest");
            let rest = rest.map(|bits| bits.into_iter().map(f32::from_bits).collect::<Vec<_>>());
            let mut joined = channels_of_row(sample, rest.as_deref());
            joined.extend(held);
            let mut all = bits_of(&whole[index]);
            if !joined.contains_key("Y") {
                all.remove("Y").expect("the picture for viewers");
            }
            assert_eq!(joined.keys().collect::<Vec<_>>(), all.keys().collect::<Vec<_>>(), "{settings}");
            for (name, numbers) in &all {
                let unlike = numbers.iter().zip(&joined[name]).filter(|(a, b)| a != b).count();
                assert_eq!(unlike, 0, "{settings}: {name} of sample {index}");
            }
        }
        place.done(&format!("validate lean-{number} --rerender 2"));
    }
    // Truth is kept where nothing else is asked for, and nothing is where nothing is.
    let order = "--recipe wood-small --n 1 --quiet --set scan.profiles=8 --set output.exr=[] --set output.truth_maps";
    place.done(&format!("{order}=true --out truth"));
    assert_eq!(bits_of(&place.samples("truth")[&0]).keys().collect::<Vec<_>>(), TRUTH);
    place.done(&format!("{order}=false --out none"));
    assert!(!place.path("none/exr").exists());
}

/// Lamps add a map to tables and EXR files, the same by any number of threads, which validation exposes again and
/// exports and reports show; nothing else of a sample changes.
#[test]
fn lamps_add_a_map() {
    let lists = [PNG[0], "png: [range, reflectance, scatter, label, grey]"];
    let exr = [EXR[0], "exr: [range, reflectance, scatter, label, instance, grey] "];
    let place = Place::with(&[lists, exr, ["\nextraction:", "\nlamps: {number: two}\n\nextraction:"]]);
    place.make("set", "--n 4 --threads 3");
    place.make("again", "--n 4 --threads 1");
    let dark = Place::with(&[]);
    dark.make("set", "--n 4");
    for ((index, lit), (_, other)) in place.samples("set").into_iter().zip(dark.samples("set")) {
        let (width, height, grey) = lit.image("grey");
        assert_eq!((width, height), (64, 48));
        assert!(grey.iter().filter(|&&dn| dn == 0).count() * 10 < grey.len(), "sample {index} is dark");
        for name in ["range", "reflectance", "scatter", "label"] {
            assert_eq!(lit.image(name), other.image(name), "sample {index}: {name}");
        }
        assert_eq!(place.samples("again")[&index].image("grey"), (width, height, grey));
    }
    place.done("validate set --rerender 4");
    place.done("export coco set --out coco --image grey");
    place.done("report set --no-timing --frames 0");
    let without = Place::with(&[lists]);
    without.run("--recipe tiny.yaml --n 1 --out set").refused(&["lists `grey`", "there are no lamps", "number: one"]);
    let unlisted = Place::with(&[["\nextraction:", "\nlamps: {number: two}\n\nextraction:"]]);
    unlisted.run("--recipe tiny.yaml --n 1 --out set").refused(&["there are lamps", "has `grey`"]);
    place.run("--recipe blister-small --set lamps.number=one --n 1 --out packs").refused(&["lamps", "film mirrors"]);
    place.run("--recipe tiny.yaml --set transport=path --n 1 --out slow").refused(&["lamps.number", "the laser alone"]);
}

#[test]
fn every_sensor_frame_can_be_kept() {
    let place = Place::with(&[
        ["sensor_stack: none", "sensor_stack: all"],
        ["s: 48 ", "s: 20 "],
        ["  rows: 832", "  rows: 400"],
    ]);
    place.make("set", "--n 2");
    assert_frames(&place, 2, 20, 1);
    place.done("validate set --rerender 2");
}

/// What is as the recipe asks is no fault, however odd: wide pixels on packs, a second line, film that hangs from a
/// tablet at the rim of a pocket.
#[test]
#[ignore = "long"]
fn odd_recipes_have_no_faults() {
    let place = Place::new();
    for (number, recipe) in [
        "blister-train --set output.bin.columns=8 --set output.bin.profiles=8",
        "wood-train --set laser.second_line_mm=0.3",
        "blister-small --set defects.tablet_on_flange=1 --set pack.rows=1",
    ]
    .into_iter()
    .enumerate()
    {
        place.done(&format!("--recipe {recipe} --n 3 --out set-{number}"));
        place.done(&format!("validate set-{number}"));
    }
}

/// Every `step`-th of the profiles of each sample is there once, of the sensor's size.
fn assert_frames(place: &Place, samples: i64, frames: i32, step: i32) {
    let tables = tree(&place.path("set/stacks"));
    let frames_of = |name: &String| rows(&place.path("set/stacks").join(name));
    let all: Vec<_> = tables.keys().flat_map(frames_of).collect();
    let mut places = Vec::new();
    for row in &all {
        let (Field::Long(index), Field::Int(profile)) = (&row["index"], &row["profile"]) else { panic!("{row:?}") };
        places.push((*index, *profile));
    }
    let expected = (0..samples).flat_map(|index| (0..frames).map(move |frame| (index, frame * step)));
    assert_eq!(places, expected.collect::<Vec<_>>());
    let images = &place.json("set/dataset.json")["images"];
    let pixels = images["sensor_rows"].as_u64().expect("rows") * images["sensor_cols"].as_u64().expect("columns");
    for row in &all {
        let Some(Field::ListInternal(frame)) = row.iter().find(|(name, _)| name.starts_with("frame")).map(|f| f.1)
        else {
            panic!("{:?}", row.keys())
        };
        assert_eq!(frame.len() as u64, pixels);
        assert!(frame.elements().iter().any(|dn| *dn != frame.elements()[0]), "a frame is uniform");
    }
}

#[test]
fn a_binned_label_is_the_majority_of_its_pixels() {
    let png = ["png: [range, reflectance, scatter, label]", "png: [reflectance, label, instance]"];
    // A view of the whole board, so that its defects are seen.
    let wide = [["s: 64 ", "s: 256 "], ["s: 48 ", "s: 64 "], ["step_mm: 0.068", "step_mm: 0.25"]];
    let [columns, profiles, step] = wide;
    let full = Place::with(&[png, columns, profiles, step]);
    let binned = Place::with(&[png, columns, profiles, step, BIN]);
    full.make("set", "--n 5");
    binned.make("set", "--n 5");
    let (full, binned) = (full.samples("set"), binned.samples("set"));
    let mut seen = [0usize; 5];
    let (mut mixed, mut edges) = (0, 0);
    for (index, sample) in &full {
        let ((w, h, label), (_, _, instance)) = (sample.image("label"), sample.image("instance"));
        let reflectance = sample.image("reflectance").2;
        let small = ["label", "instance", "reflectance"].map(|channel| binned[index].image(channel));
        assert_eq!([w, h, small[0].0, small[0].1], [256, 64, 128, 16]);
        for (i, &class) in small[0].2.iter().enumerate() {
            let (x, y) = (i % 128 * 2, i / 128 * 4);
            let behind: Vec<usize> = (0..8).map(|p| (y + p / 2) * 256 + x + p % 2).collect();
            let count = |wanted: u16| behind.iter().filter(|p| label[**p] == wanted).count();
            let most = (0..5).map(count).max().expect("five classes");
            // Of equals the greater class wins, so that a small defect is not lost.
            let winner = (0..5).rev().find(|class| count(*class) == most).expect("one of them");
            assert_eq!(class, winner, "sample {index}, pixel {i}");
            let of_class = behind.iter().filter(|p| label[**p] == class);
            assert!(of_class.clone().any(|p| instance[*p] == small[1].2[i]), "sample {index}, pixel {i}");
            // What is measured on the board and beside it; the greater part is averaged, where both together are half
            // of the pixels.
            let side = |on_board: bool| -> Vec<f64> {
                let own = behind.iter().filter(|p| (label[**p] > 0) == on_board);
                own.map(|p| f64::from(reflectance[*p])).filter(|dn| *dn > 0.0).collect()
            };
            let (board, beside) = (side(true), side(false));
            let lit = if board.len() >= beside.len() { &board } else { &beside };
            let known = 2 * (board.len() + beside.len()) >= behind.len();
            let mean = if known { lit.iter().sum::<f64>() / lit.len() as f64 } else { 0.0 };
            assert!((f64::from(small[2].2[i]) - mean).abs() <= 0.501, "sample {index}, pixel {i}");
            edges += usize::from(!board.is_empty() && !beside.is_empty());
            seen[usize::from(class)] += 1;
            mixed += usize::from(most < 8);
        }
    }
    assert!(seen[0] > 0 && seen[1] > 0 && seen[2..].iter().sum::<usize>() > 0 && mixed > 10, "{seen:?}, {mixed} mixed");
    assert!(edges > 10, "{edges} pixels at the board's edges");
}
