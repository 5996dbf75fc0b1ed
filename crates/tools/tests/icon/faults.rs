//! Damaged files of the camera: a place, a reason, a remedy.

use std::fs;
use std::path::PathBuf;

use crate::scans::{calibrated, folder, noise, uncalibrated, write, write_between, write_files};
use tools::icon::{Content, SensorImage, open};

/// Damage has a place, a reason and a remedy; cut or changed anywhere, a file is never a panic.
#[test]
fn damage_is_told() {
    let (_folder, name) = folder();
    let (text, data) = (PathBuf::from(format!("{}.xml", name.display())), format!("{}.dat", name.display()));
    let told = |what: &str| {
        let error = open(&name).expect_err(what).to_string();
        assert!(error.contains(what) && error.matches(';').count() >= 1, "'{what}' is not in: {error}");
    };
    told("cannot be read");
    write(&name, &calibrated(12, 3));
    let good = fs::read_to_string(&text).expect("it was just written");
    for (from, to, what) in [
        ("<icon_data_format", "<icon", "XML"),
        ("icon_data_format", "other", "not <icon_data_format>"),
        ("\"version\">1", "\"version\">2", "line 3: its version is '2'"),
        ("SUBCOMPONENT", "DIAGONAL", "neither SUBCOMPONENT nor SCAN"),
        ("\"size\">60", "\"size\">61", "61 bytes a row"),
        ("FLOAT", "DOUBLE", "is DOUBLE"),
        ("FLOAT", "BYTE", "which it never is"),
        ("\"width\">12", "\"width\">13", "13 numbers of 4 bytes in 48 bytes"),
        ("\"width\">12", "\"width\">-1", "no count"),
        ("130.306992", "nan", "no number"),
        ("\"lower bound x\"", "\"left\"", "no parameter 'lower bound x'"),
        ("130.306992", "999", "above upper bounds"),
        ("worldrangetraits", "traits", "what Range means"),
        ("\"Range\"", "\"Rage\"", "'Range' or 'Image'"),
        ("\"Reflectance\"", "\"Range\"", "which it never is"),
    ] {
        fs::write(&text, good.replace(from, to)).expect("the folder is ours");
        if what != "XML" {
            told(what);
        }
        assert!(open(&name).is_err(), "{what}");
    }
    // As large as numbers go: told before any memory is taken.
    let huge = format!("{}", usize::MAX / 4);
    let vast = good.replace("\"size\">48", &format!("\"size\">{}", usize::MAX / 4 * 4));
    fs::write(&text, vast.replacen("\"width\">12", &format!("\"width\">{huge}"), 1)).expect("the folder is ours");
    told("beyond any memory");
    for end in (0..good.len()).filter(|end| good.is_char_boundary(*end)) {
        fs::write(&text, &good[..end]).expect("the folder is ours");
        assert!(open(&name).is_err(), "{end} bytes are no whole description");
    }
    fs::write(&text, [0xff, 0xfe, b'<']).expect("the folder is ours");
    told("no UTF-8");
    fs::write(&text, &good).expect("the folder is ours");
    fs::write(&data, vec![0; 179]).expect("the folder is ours");
    told("179 bytes are no whole number of rows of 60 bytes");
    fs::remove_file(&data).expect("it was there");
    told("side by side");
}

/// An image beside a plane of pixels of another width is told, in either layout.
#[test]
fn widths_that_disagree_are_told() {
    let (_folder, name) = folder();
    let image = SensorImage { cols: 10, rows: 2, offset: [0, 0], dn: vec![7; 20] };
    for layout in ["SCAN", "SUBCOMPONENT"] {
        for (plane, kind, size) in [("Range", "WORD", 200), ("Intensity", "BYTE", 100)] {
            write_between(&name, &image, layout, [(plane, kind, size, 100), ("After", "BYTE", 1, 1)]);
            let error = open(&name).expect_err("the widths disagree").to_string();
            assert!(error.contains(&format!("{plane} is 100")) && error.contains("Image is 10"), "{error}");
        }
    }
}

/// The text with every number replaced in turn, and every element taken away or doubled.
fn mutations(good: &str) -> Vec<String> {
    const NUMBERS: [&str; 8] = ["0", "1", "18446744073709551615", "4294967297", "1e308", "-1", "lots", ""];
    let lines: Vec<&str> = good.lines().map(str::trim).collect();
    let joined = |parts: [&[&str]; 3]| parts.concat().join("\n");
    let mut list = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        if let Some((front, rest)) = line.split_once("\">")
            && let Some((number, back)) = rest.split_once("</")
            && number.parse::<f64>().is_ok()
        {
            list.extend(NUMBERS.map(|other| {
                let changed = format!("{front}\">{other}</{back}");
                joined([&lines[..i], &[changed.as_str()], &lines[i + 1..]])
            }));
        }
        if line.starts_with("</") {
            continue;
        }
        // An element ends in its own line, or where as many have been closed as were opened.
        let mut depth = 0;
        let end = lines[i..].iter().position(|line| {
            depth += if line.starts_with("</") { -1 } else { i32::from(!line.contains("</")) };
            depth == 0
        });
        let end = i + end.expect("the text is whole") + 1;
        list.push(joined([&lines[..i], &[], &lines[end..]]));
        list.push(joined([&lines[..end], &lines[i..end], &lines[end..]]));
    }
    list
}

/// Whatever is wrong with a description or with the length of its data gives an error, or what the data can hold.
#[test]
fn mutated_files_are_errors_or_sane() {
    let (_folder, name) = folder();
    let image = SensorImage { cols: 9, rows: 4, offset: [3, 128], dn: noise(36).map(|n| n as u8).collect() };
    let (text, data) = (format!("{}.xml", name.display()), format!("{}.dat", name.display()));
    for case in ["image", "SCAN", "SUBCOMPONENT", "calibrated", "uncalibrated"] {
        match case {
            "image" => write_files(&name, image.files()),
            "calibrated" => write(&name, &calibrated(12, 3)),
            "uncalibrated" => write(&name, &uncalibrated(12, 3)),
            layout => write_between(&name, &image, layout, [("Before", "WORD", 10, 5), ("After", "INT", 12, 3)]),
        }
        let (good, whole) = (fs::read_to_string(&text).expect("it is there"), fs::read(&data).expect("it is there"));
        let cut = |n: usize| whole[..n].to_vec();
        let longer = |n: usize| [whole.as_slice(), &vec![0; n]].concat();
        let lengths = [whole.clone(), cut(0), cut(1), cut(whole.len() - 1), longer(1), longer(whole.len())];
        let mut told = [0; 2];
        for mutated in [good.clone()].into_iter().chain(mutations(&good)) {
            fs::write(&text, &mutated).expect("the folder is ours");
            for bytes in &lengths {
                fs::write(&data, bytes).expect("the folder is ours");
                let held = match open(&name) {
                    Err(error) => {
                        assert!(error.to_string().contains(';') && !error.what.is_empty(), "{error}");
                        told[0] += 1;
                        continue;
                    }
                    Ok(Content::Image(back)) => {
                        assert_eq!(back.dn.len(), back.cols * back.rows, "{case}\n{mutated}");
                        assert!(*bytes != whole || back.dn == image.dn, "{case}\n{mutated}");
                        back.dn.len()
                    }
                    Ok(Content::Scan(mut reader)) => {
                        let scan = reader.read(0, usize::MAX).expect("the data are as long as they were");
                        assert_eq!(scan.heights().len(), scan.width * scan.rows, "{case}\n{mutated}");
                        scan.width * scan.rows
                    }
                };
                assert!(held <= bytes.len(), "{held} of {} bytes: {case}\n{mutated}", bytes.len());
                told[1] += 1;
            }
        }
        // Some elements can be missed, most cannot.
        assert!(told[0] > told[1] && told[1] > 10, "{case}: {told:?}");
    }
}

/// Files that are longer than any scan, pipes, and descriptions without end are refused before they are read.
#[test]
fn endless_files_are_refused() {
    let (_folder, name) = folder();
    let (text, data) = (PathBuf::from(format!("{}.xml", name.display())), format!("{}.dat", name.display()));
    write(&name, &calibrated(12, 3));
    let told = |what: &str| {
        let error = open(&name).expect_err(what).to_string();
        assert!(error.contains(what) && error.contains(';'), "'{what}' is not in: {error}");
    };
    // As long as 10 000 000 000 rows, of which none takes room on the disk.
    let sparse = fs::File::create(&data).expect("the folder is ours");
    sparse.set_len(600_000_000_000).expect("the disk knows holes");
    told("at most 1048576 rows, 65536 columns and 134217728 pixels are read");
    let good = fs::read_to_string(&text).expect("it was just written");
    let plane = "<subcomponent valuetype=\"BYTE\" name=\"Other\"><parameter name=\"size\">12</parameter>\
                 <parameter name=\"width\">12</parameter></subcomponent>";
    fs::write(&text, good.replace("</component>", &format!("{}</component>", plane.repeat(100)))).expect("it is ours");
    told("more than 64 subcomponents");
    fs::remove_file(&text).expect("it is ours");
    assert!(std::process::Command::new("mkfifo").arg(&text).status().expect("it starts").success());
    told("it is a pipe, no plain file");
}
