//! Damaged and unfinished files of the camera: a place, a reason, a remedy, and nothing left behind.

mod icon_support;

use std::fs;
use std::path::PathBuf;

use icon_support::{calibrated, folder, uncalibrated, write};
use sheetlight::icon::{Scan, ScanWriter, open};

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

/// Rows of another form, too many or too few leave no file behind.
#[test]
fn unfinished_scans_leave_nothing() {
    let (folder, name) = folder();
    let scan = calibrated(4, 2);
    let mut writer = ScanWriter::create(&name, &scan, 3).expect("the folder is ours");
    assert!(writer.push(&uncalibrated(4, 2)).is_err());
    assert!(writer.push(&calibrated(5, 2)).is_err());
    assert!(writer.push(&Scan { rows: 3, ..calibrated(4, 2) }).is_err());
    writer.push(&scan).expect("it fits");
    assert!(writer.push(&scan).expect_err("one row too many").to_string().contains("4 rows are too many for 3"));
    assert!(writer.finish().expect_err("a row is missing").to_string().contains("2 of 3 rows"));
    assert_eq!(fs::read_dir(folder.path()).expect("it is ours").count(), 0);
    assert!(ScanWriter::create(&folder.path().join("no/such"), &scan, 1).is_err());
}
