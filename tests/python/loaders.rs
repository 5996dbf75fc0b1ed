//! The examples under python/examples open what the program made, and see in it what is read here.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use crate::scripts::{IMAGES, Said, datasets, example, first, names, number, numbers, sum};
use dataset::read_exr;
use parquet::record::Field;
use test_support::program::Place;

/// `datasets` has the splits, names and pixels; Range in mm is what scale and offset make of the PNG.
#[test]
fn datasets_loads_boards_and_packs() {
    for (place, samples) in datasets() {
        let head = place.json("set/dataset.json");
        let said = example(&place.path("."), "load_datasets", &place.path("set"), &[]);
        for split in ["train", "validation", "test"] {
            let count = samples.values().filter(|s| s.text("split") == split).count();
            let line = format!("split {split}: {count} samples");
            assert_eq!(said.out.contains(&line), count > 0, "{line}\n{}", said.out);
        }
        for (class, name) in names(&head, "classes").iter().enumerate() {
            let count = samples.values().filter(|s| number(&s.columns["class"]) == class as f64).count();
            assert_eq!(said.line(&format!("class {name}: ")), format!("{count} samples"));
        }
        let (index, sample) = first(&samples, &["train"]);
        assert!(said.line("sample ").starts_with(&format!("{index}: ")), "{}", said.out);
        let (_, _, range) = sample.image("range");
        let [offset, scale] = ["offset", "scale"].map(|what| number(&sample.columns[&format!("range_{what}_mm")]));
        let seen = range.iter().filter(|&&r| r > 0).map(|&r| offset + scale * f64::from(r));
        let (low, high) = seen.fold((f64::MAX, f64::MIN), |(low, high), z| (low.min(z), high.max(z)));
        let missing = range.iter().filter(|&&r| r == 0).count();
        let expected = format!("{low:.3} to {high:.3} mm, missing {missing} px of {}", range.len());
        assert_eq!(said.line("Range: "), expected);
        assert_eq!(said.numbers("Reflectance: uint8, sum "), [sum(&sample.image("reflectance").2)]);
        let (_, _, labels) = sample.image("label");
        for (value, name) in names(&head, "pixel_classes").iter().enumerate() {
            let count = labels.iter().filter(|&&label| usize::from(label) == value).count();
            let line = format!("label {name}: {count} px\n");
            assert_eq!(said.out.contains(&line), count > 0, "{line}{}", said.out);
        }
        assert!(said.line("streamed: ").len() == 36);
    }
}

/// Every subject, 12 bits, and tables without images: `datasets` loads them, and the card says what to do.
#[test]
fn datasets_loads_whatever_the_recipe_asks_for() {
    let twelve = ["\nexposure:", "\nexposure:\n  bits: 12"];
    let none = [IMAGES[0], "png: []"];
    let mut places: Vec<Place> = Place::of_each_subject(&[]).into_iter().skip(2).collect();
    places.extend([Place::with(&[twelve]), Place::with(&[none])]);
    // `datasets` sleeps for seconds where its threads end.
    std::thread::scope(|scope| {
        for (kind, place) in ["sawtooth", "mesh", "bits", "none"].into_iter().zip(places) {
            scope.spawn(move || loads(kind, &place));
        }
    });
}

fn loads(kind: &str, place: &Place) {
    place.make("set", "--n 4");
    let said = example(&place.path("."), "load_datasets", &place.path("set"), &[]);
    let card = fs::read_to_string(place.path("set/README.md")).expect("a card");
    let samples = place.samples("set");
    let (index, sample) = first(&samples, &["train", "validation", "test"]);
    assert!(said.line("sample ").starts_with(&format!("{index}: ")), "{kind}: {}", said.out);
    if kind == "none" {
        let path = said.line("images: none in the tables; maps are in ");
        assert!(place.path("set").join(path).is_file(), "{path}");
        assert!(card.contains("take the EXR files") && card.contains("import OpenEXR"), "{card}");
    } else {
        let depth = if kind == "bits" { "uint16" } else { "uint8" };
        let line = format!("Reflectance: {depth}, sum ");
        assert_eq!(said.numbers(&line), [sum(&sample.image("reflectance").2)], "{kind}");
    }
    assert_eq!(card.contains("12 bits, 0 to 4095"), kind == "bits");
}

/// polars and DuckDB answer the same questions alike, and as counting here does: an object that lies in another one is
/// no second pocket.
#[test]
fn tables_are_asked_in_one_line() {
    let mut inside = 0;
    for (place, samples) in datasets() {
        let head = place.json("set/dataset.json");
        let (names, classes) = (names(&head, "pixel_classes"), names(&head, "classes"));
        let mut kinds: BTreeMap<&str, (f64, BTreeSet<i64>, f64)> = BTreeMap::new();
        let mut wholes: BTreeMap<&str, f64> = BTreeMap::new();
        let mut waists: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for (index, sample) in &samples {
            let Field::ListInternal(list) = &sample.columns["objects"] else { panic!("no list") };
            for object in list.elements() {
                let Field::Group(object) = object else { panic!("no object") };
                let key = |key: &str| object.get_column_iter().find(|(name, _)| *name == key).map(|(_, v)| number(v));
                let name = |of: &str| names[key(of).expect("a pixel class") as usize].as_str();
                let (count, among, area) = kinds.entry(name("class")).or_default();
                *count += 1.0;
                among.insert(*index);
                *area += key("area_mm2").expect("an area");
                if key("within").expect("a number") == 0.0 {
                    *wholes.entry(name("state")).or_default() += 1.0;
                } else {
                    inside += 1;
                }
            }
            let class = &classes[number(&sample.columns["class"]) as usize];
            waists.entry(class).or_default().push(number(&sample.columns["laser.waist_mm"]));
        }
        assert!(kinds.len() > 1, "{kinds:?}");
        for name in ["load_polars", "load_duckdb"] {
            let said = example(&place.path("."), name, &place.path("set"), &[]);
            assert_eq!(said.out.lines().count(), kinds.len() + wholes.len() + waists.len(), "{}", said.out);
            for (class, (count, among, area)) in &kinds {
                let expected = format!("{count} in {} samples, mean {:.6} mm2", among.len(), area / count);
                close(&said, &format!("object {class}: "), &expected);
            }
            for (state, count) in &wholes {
                assert_eq!(said.line(&format!("state {state}: ")), count.to_string());
            }
            for (class, waists) in &waists {
                let mean = waists.iter().sum::<f64>() / waists.len() as f64;
                let expected = format!("{} samples, mean laser.waist_mm {mean:.6}", waists.len());
                close(&said, &format!("class {class}: "), &expected);
            }
        }
    }
    assert!(inside > 0, "no defect lies in a pocket: nothing could be counted twice");
}

/// Two lines with the same words, whose numbers differ by their last digit at most: sums are taken in another order.
fn close(said: &Said, start: &str, expected: &str) {
    let (found, wanted) = (said.numbers(start), numbers(expected));
    let near = found.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1.5e-6 * (1.0 + b.abs()));
    assert!(found.len() == wanted.len() && near, "{start}{}\nis not {expected}", said.line(start));
}

/// pandas: maps by class of pixel.
#[test]
fn pandas_decodes_images() {
    for (place, samples) in datasets() {
        let head = place.json("set/dataset.json");
        let said = example(&place.path("."), "load_pandas", &place.path("set"), &[]);
        assert_eq!(said.numbers("rows: ")[0], samples.len() as f64);
        let mut sums: BTreeMap<u16, [f64; 3]> = BTreeMap::new();
        for sample in samples.values() {
            let [label, scatter, bright] = ["label", "scatter", "reflectance"].map(|name| sample.image(name).2);
            for i in (0..label.len()).filter(|&i| bright[i] > 0) {
                let entry = sums.entry(label[i]).or_default();
                [1.0, scatter[i].into(), bright[i].into()].into_iter().zip(entry).for_each(|(n, sum)| *sum += n);
            }
        }
        for (value, [count, scatter, bright]) in sums {
            let name = &names(&head, "pixel_classes")[usize::from(value)];
            let means = format!("{:.4} {:.4}", scatter / count, bright / count);
            let found = said.numbers(&format!("pixels {name}: "));
            assert_eq!(found[0], count, "{name}");
            let near = found[1..].iter().zip(numbers(&means)).all(|(a, b)| (a - b).abs() < 1.5e-4);
            assert!(near, "{name}: {found:?}, not {means}");
        }
    }
}

/// OpenEXR and OpenCV: channels, NaN as missing, spacing.
#[test]
fn exr_files_open_in_openexr_and_opencv() {
    for (place, samples) in datasets() {
        // The first file by name.
        let (index, sample) = first(&samples, &["test", "train"]);
        let said = example(&place.path("."), "load_openexr", &place.path("set"), &[]);
        let (cols, rows, channels, _) = read_exr(&sample.exr).expect("it is EXR");
        let spacing = ["row_mm", "col_mm"].map(|name| number(&sample.columns[name]));
        let expected = [index as f64, rows as f64, spacing[0], cols as f64, spacing[1]];
        assert_eq!(said.numbers("sample "), expected);
        for channel in &channels {
            let numbers = &channel.numbers;
            let seen: Vec<f64> = numbers.iter().filter(|v| !v.is_nan()).map(|&v| f64::from(v)).collect();
            let found = said.line(&format!("{}: ", channel.name));
            assert!(
                found.ends_with(&format!("missing {} px", numbers.len() - seen.len())),
                "{}: {found}",
                channel.name
            );
            if !seen.is_empty() {
                let mean: f64 = found.split(' ').nth(2).and_then(|word| word.parse().ok()).expect("a mean");
                let expected = seen.iter().sum::<f64>() / seen.len() as f64;
                assert!((mean - expected).abs() < 1.5e-6 * (1.0 + expected.abs()), "{}: {found}", channel.name);
            }
        }
        let said = example(&place.path("."), "load_opencv", &place.path("set"), &[]);
        let bright = channels.iter().find(|channel| channel.name == "Y").expect("Y is there").numbers.clone();
        let total: f64 = bright.iter().map(|&v| f64::from(v)).sum();
        let missing = bright.iter().filter(|&&v| v == 0.0).count();
        let expected = format!("float32 ({rows}, {cols}), sum {total:.3} DN, missing {missing} px");
        assert_eq!(said.line("Reflectance: "), expected);
        let missing = sample.image("range").2.iter().filter(|&&r| r == 0).count();
        assert_eq!(said.line("Range: "), format!("uint16 ({rows}, {cols}), missing {missing} px"));
    }
}

/// `rejoin_exr` makes of tables and lean EXR files what files of everything hold, bit for bit.
#[test]
fn tables_and_exr_files_are_rejoined() {
    for (number, (recipe, more)) in [
        ("wood-small", "--set scan.columns=96 --set scan.profiles=24"),
        ("wood-small", "--set scan.profiles=24 --set exposure.bits=12 --set extraction.range=uncalibrated"),
        ("wood-small", "--set scan.profiles=24 --set output.bin={\"columns\":4,\"profiles\":3}"),
        ("blister-small", "--set scan.profiles=24 --set output.png=[reflectance,scatter]"),
    ]
    .into_iter()
    .enumerate()
    {
        let place = Place::new();
        for (name, exr) in [("lean", "auto"), ("whole", "all")] {
            place.done(&format!("--recipe {recipe} --n 2 --quiet --out {name} --set output.exr={exr} {more}"));
        }
        let out = place.path("joined").to_string_lossy().into_owned();
        example(&place.path("."), "rejoin_exr", &place.path("lean"), &[&out]);
        for (index, sample) in place.samples("whole") {
            let joined = fs::read(place.path(&format!("joined/{index:08}.exr"))).expect("it is written");
            let [whole, joined] = [&sample.exr, &joined].map(|file| read_exr(file).expect("it is EXR"));
            let names = |channels: &[dataset::ExrChannel]| -> Vec<_> {
                channels.iter().map(|c| (c.name.clone(), c.samples)).collect()
            };
            assert_eq!(names(&whole.2), names(&joined.2), "{number}");
            for (a, b) in whole.2.iter().zip(&joined.2) {
                let same = a.numbers.iter().zip(&b.numbers).all(|(a, b)| a.to_bits() == b.to_bits());
                assert!(same, "{number}: {} of sample {index}", a.name);
            }
        }
    }
}

/// Crops are the pixels at their places, the same for any number of workers, and a model learns from them.
#[test]
fn pytorch_trains_on_crops() {
    for (i, (place, samples)) in datasets().into_iter().enumerate() {
        let run = |workers: &str| {
            let more = ["--crop", "24", "--scans", "3", "--crops", "2", "--steps", "20", "--workers", workers];
            example(&place.path("."), "train_pytorch", &place.path("set"), &more)
        };
        let alone = run("0");
        // Dealing scans out to workers knows no subject, and each start of torch takes seconds: once is enough.
        if i == 0 {
            assert_eq!(alone.line("sha256 of all batches: "), run("2").line("sha256 of all batches: "));
        }
        assert_eq!(alone.line("batch: "), "[6, 4, 24, 24] torch.float32, labels [6, 24, 24] torch.int64");
        let classes: Vec<u64> = place.json("set/dataset.json")["label_values"]
            .as_array()
            .expect("a list")
            .iter()
            .map(|value| value.as_u64().expect("a number"))
            .collect();
        let crops: Vec<&str> = alone.out.lines().filter_map(|line| line.strip_prefix("crop of sample ")).collect();
        assert_eq!(crops.len(), 6);
        for crop in crops {
            let found = numbers(crop);
            let sample = &samples[&(found[0] as i64)];
            assert_eq!(sample.text("split"), "train");
            let [offset, scale] = ["offset", "scale"].map(|what| number(&sample.columns[&format!("range_{what}_mm")]));
            let [range, bright, scatter, label] =
                ["range", "reflectance", "scatter", "label"].map(|name| sample.image(name));
            let mut expected = [0.0; 5];
            for i in 0..24 * 24 {
                let at = (found[1] as usize + i / 24) * range.0 as usize + found[2] as usize + i % 24;
                let class = classes.iter().position(|&value| value == u64::from(label.2[at])).expect("a label");
                expected[4] += class as f64;
                if range.2[at] > 0 {
                    let sums =
                        [1.0, offset + scale * f64::from(range.2[at]), bright.2[at].into(), scatter.2[at].into()];
                    sums.iter().zip(&mut expected).for_each(|(n, sum)| *sum += n);
                }
            }
            // Maps are 32-bit floats of three digits beyond a unit; 576 of them add up.
            let near = found[3..].iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.01 + 1e-6 * b.abs());
            assert!(found.len() == 8 && near, "{crop}\nis not {expected:?}");
        }
        let [start, end] = ["step 0: ", "step 19: "].map(|step| alone.numbers(step));
        assert!(end[0] < start[0] && start[1] > 0.0 && end[1] > 0.0, "{}", alone.out);
    }
}
