//! `gen export`: the tools that the formats are made for read them, and find the dataset's own numbers.

use std::path::Path;

use crate::scripts::interpreter;
use drawing::class_colour;
use test_support::program::{Place, assert_same, pack_recipe, recipe};
use tools::export::EXPORTS;

/// As many samples to test as to train, so that few samples fill both.
const SPLITS: [&str; 2] = ["{train: 0.8, validation: 0.1, test: 0.1}", "{train: 0.4, validation: 0.2, test: 0.4}"];

/// As large as wood-small.yaml has them: a board with its knots.
const LARGE: [[&str; 2]; 2] = [["\n  columns: 64 ", "\n  columns: 256 "], ["\n  profiles: 48 ", "\n  profiles: 256 "]];

/// A dataset of 12 samples in shards of 5, in `set`.
fn dataset(text: String) -> Place {
    let place = Place::new();
    place.write("tiny.yaml", text);
    place.make("set", "--n 12 --samples-per-shard 5");
    place
}

/// Exports and has the export read by the tool that it is made for, which knows what was asked; gives what that says.
fn checked(place: &Place, format: &str, options: &str) -> String {
    let out = format!("{format}{}", options.replace([' ', ',', '-'], ""));
    place.done(&format!("export {format} set --out {out} {options}"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let run = interpreter()
        .arg(root.join("python/check_exports.py"))
        .args([format.as_ref(), place.path("set").as_os_str(), place.path(&out).as_os_str()])
        .args(options.split_whitespace())
        .output()
        .expect("python starts");
    let text = format!("{}{}", String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success(), "{format} {options}: {text}\nif a package is missing: make venv");
    let last = text.lines().rev().find(|line| line.starts_with(format)).unwrap_or_default().to_owned();
    println!("{last}");
    last
}

/// Boards, with images in rows: pycocotools, folders of anomaly detection and PNG readers find each of them.
#[test]
fn tools_read_boards() {
    let place = dataset(recipe(&[SPLITS, LARGE[0], LARGE[1]]));
    let coco = checked(&place, "coco", "");
    assert!(coco.contains("12 images") && !coco.contains(" 0 objects"), "{coco}");
    let folders = checked(&place, "mvtec", "--patch-px 60");
    assert!(folders.contains("'train/good'") && folders.contains("knot'"), "{folders}");
    let png = checked(&place, "png", "--colour");
    assert!(png.contains("12 rows") && !["0", "1"].iter().any(|n| png.contains(&format!(" {n} colours"))), "{png}");
    // The colours are those of `gen preview`.
    let files = place.tree("pngcolour");
    for (name, colours) in files.iter().filter(|(name, _)| name.contains("/colour/")) {
        let picture = |png: &[u8]| image::load_from_memory(png).expect("it is PNG");
        let labels = picture(&files[&name.replace("/colour/", "/label/")]).into_luma8();
        let expected: Vec<u8> = labels.iter().flat_map(|label| class_colour(*label).0).collect();
        assert!(picture(colours).into_rgb8().into_raw() == expected, "{name}");
    }
}

/// Packs, whose defects lie in pockets: masks with and without what lies in them, in every way that masks and pictures
/// are written.
#[test]
fn tools_read_packs() {
    let place = dataset(pack_recipe(&[SPLITS]));
    for options in [
        "--image rgb",
        "--image range --range-ends -1,8",
        "--image scatter --bits 16 --plain-rle",
        "--image rgb --range-ends 0,6 --scatter-ends 20,300",
        "--mask own --split train",
    ] {
        let coco = checked(&place, "coco", options);
        assert!(!coco.contains(" 0 objects"), "{coco}");
        // The few images of one split need not have a defect inside of anything.
        let is_whole = !options.contains("--split");
        assert!(!is_whole || coco.contains("12 images") && !coco.contains(" 0 with others inside"), "{coco}");
    }
    let folders = checked(&place, "mvtec", "--image rgb --patch-px 48 --range-ends 0,6 --scatter-ends 20,300");
    assert!(folders.contains("'test/good'"), "{folders}");
}

/// A dataset of EXR files alone gives the same pictures, masks and folders.
#[test]
fn tools_read_what_comes_from_exr() {
    let png = "png: [range, reflectance, scatter, label]";
    let place = dataset(recipe(&[SPLITS, [png, "png: []"], LARGE[0], LARGE[1]]));
    assert!(checked(&place, "coco", "--image scatter").contains("12 images"));
    checked(&place, "mvtec", "--good clear,sound_knot --image range");
    assert_eq!(checked(&place, "webdataset", ""), "webdataset: 3 tars, 12 samples");
    // Folders for anomaly detection were asked for above; files of the real camera are read by `gen icon`, and others
    // in tests/formats.
    let elsewhere = ["mvtec", "mvtec3d", "webdataset", "icon", "yolo"];
    for format in EXPORTS.iter().filter(|format| !elsewhere.contains(&format.name)) {
        checked(&place, format.name, "");
    }
}

/// Sensor rows, from PNG and from EXR, are scaled as heights are.
#[test]
fn tools_read_sensor_rows() {
    let png = "png: [range, reflectance, scatter, label]";
    for stored in [png, "png: []"] {
        let rows = ["\n  window_rows: 7", "\n  range: uncalibrated\n  window_rows: 7"];
        let place = dataset(recipe(&[SPLITS, rows, [png, stored]]));
        assert!(checked(&place, "coco", "--image range").contains("12 images"));
    }
}

/// Splits, numbers and maps that were asked for, and no others, are in tars, folders and documents.
#[test]
fn parts_are_what_was_asked() {
    let place = dataset(recipe(&[SPLITS]));
    assert!(checked(&place, "webdataset", "--index 3,7-9 --maps range,label").ends_with(" 4 samples"));
    let parts = ["train", "validation", "test"].map(|split| {
        let maps = if split == "test" { "--maps scatter --colour" } else { "--maps reflectance,instance" };
        let said = checked(&place, "png", &format!("--split {split} --index 0-10 {maps}"));
        said.split(' ').nth(1).and_then(|number| number.parse::<u32>().ok()).unwrap_or_else(|| panic!("{said}"))
    });
    assert!(parts.iter().sum::<u32>() == 11 && parts.iter().all(|part| *part > 0), "{parts:?}");
    for split in ["train", "test"] {
        checked(&place, "mvtec", &format!("--split {split} --patch-px 16 --image range"));
    }
}

/// Scales of a dataset that is not finished come from samples that are, wherever these lie.
#[test]
fn scales_come_from_finished_samples() {
    let place = Place::with(&[]);
    place.make("set", "--n 4000 --samples-per-shard 4 --part 1/1000");
    assert!(checked(&place, "coco", "--image rgb").contains("4 images"));
    checked(&place, "mvtec", "--image rgb --patch-px 16 --split train");
}

/// The bytes are the same for any number of threads, and a second run of the same command changes nothing.
#[test]
fn bytes_follow_from_dataset_and_options() {
    let place = dataset(recipe(&[SPLITS]));
    for format in [
        "coco --image rgb",
        "coco --polygons",
        "yolo --image scatter",
        "mvtec --patch-px 24",
        "mvtec3d --patch-px 24",
        "webdataset",
        "png --colour",
        "icon --words",
    ] {
        let out = |threads: u32| format!("{}-{threads}", format.replace(' ', ""));
        for threads in [1, 3] {
            place.done(&format!("export {format} set --out {} --threads {threads}", out(threads)));
        }
        assert_same(&place.tree(&out(1)), &place.tree(&out(3)), format);
        let again = place.done(&format!("export {format} set --out {}", out(1)));
        assert!(again.err.contains("nothing to do"), "{}", again.err);
    }
}

/// Tars are closed before they pass the size that was asked for, and hold nothing of the machine.
#[test]
fn tars_have_a_size() {
    let one_split = [SPLITS[0], "{train: 0, validation: 0, test: 1}"];
    let place = dataset(recipe(&[one_split, LARGE[0], LARGE[1]]));
    assert!(checked(&place, "webdataset", "--tar-mb 1").ends_with("12 samples"));
    let tars = place.tree("webdatasettarmb1");
    let tars: Vec<_> = tars.iter().filter(|(name, _)| name.ends_with(".tar")).collect();
    assert!(tars.len() > 1 && tars.iter().all(|(_, bytes)| bytes.len() <= 1_000_000), "{}", tars.len());
    let header = &tars[0].1[..512];
    let field = |from: usize, length: usize| header[from..from + length].iter().all(|c| [b'0', b' ', 0].contains(c));
    assert!(field(108, 8) && field(116, 8) && field(136, 12), "user, group and time are 0");
    assert_eq!(header[156], b'0', "it says that it is a file");
    assert!(header[265..329].iter().all(|c| *c == 0), "there are no names of users");
}

/// Samples are chosen by split and by number.
#[test]
fn samples_are_chosen() {
    let place = dataset(recipe(&[SPLITS]));
    let names = |options: &str, out: &str| -> Vec<String> {
        place.done(&format!("export icon set --out {out} {options}"));
        let names = place.tree(out).into_keys().filter_map(|name| name.strip_suffix(".dat").map(String::from));
        names.collect()
    };
    assert_eq!(names("--index 3,7-9 --words --rate 500", "some"), ["00000003", "00000007", "00000008", "00000009"]);
    let order = &place.json("some/export.json")["order"];
    assert_eq!(order["options"], serde_json::json!({"words": true, "rate_hz": 500.0, "sensor": false}));
    assert_eq!(order["source"]["indices"], serde_json::json!([[3, 3], [7, 9]]));
    let of_splits: Vec<_> =
        ["train", "validation", "test"].map(|split| names(&format!("--split {split} --index 0-11"), split)).concat();
    let mut sorted = of_splits.clone();
    sorted.sort();
    assert_eq!((sorted, of_splits.len()), (names("", "all"), 12));
}
