//! Scans to write and read.

use std::fs;
use std::path::{Path, PathBuf};

use tools::icon::{
    Content, IconFiles, IconScan, PlaneContent, PlaneNumbers, ScanReader, SensorImage, SensorTraits, Traits,
    WorldTraits, open,
};

/// Traits of a real calibrated scan.
pub fn world(row_mm: Option<f64>) -> Traits {
    Traits::World(WorldTraits { lower: [130.306992, 62.224915], upper: [370.141571, 117.414742], row_mm })
}

/// Numbers without order, the same in every run.
pub fn noise(n: usize) -> impl Iterator<Item = u32> {
    (0..n as u32).map(|i| (i + 1).wrapping_mul(2_654_435_761) ^ (i << 7))
}

/// A scan with FLOAT Range and Reflectance.
pub fn calibrated(width: usize, rows: usize) -> IconScan {
    let height = |n: u32| if n.is_multiple_of(5) { 0.0 } else { 62.3 + (n % 5000) as f32 * 0.011 };
    let planes = vec![
        (PlaneContent::Range, PlaneNumbers::Float(noise(width * rows).map(height).collect())),
        (PlaneContent::Reflectance, PlaneNumbers::Byte(noise(width * rows).map(|n| n as u8).collect())),
    ];
    IconScan { width, rows, traits: world(None), planes }
}

/// A scan with every plane that an uncalibrated one may have.
pub fn uncalibrated(width: usize, rows: usize) -> IconScan {
    let planes = vec![
        (PlaneContent::Range, PlaneNumbers::Word(noise(width * rows).map(|n| n as u16 % 13312).collect())),
        (PlaneContent::Intensity, PlaneNumbers::Byte(noise(width * rows).map(|n| n as u8).collect())),
        (PlaneContent::Scatter, PlaneNumbers::Word(noise(width * rows).map(|n| (n >> 3) as u16).collect())),
        (PlaneContent::Mark, PlaneNumbers::Int(noise(rows * 5).collect())),
    ];
    IconScan { width, rows, traits: Traits::Sensor(SensorTraits::new(832, [0.0, 12.0])), planes }
}

/// Writes `NAME.dat` and `NAME.xml`.
pub fn write_files(name: &Path, files: IconFiles) {
    fs::write(format!("{}.dat", name.display()), files.data).expect("the folder is ours");
    fs::write(format!("{}.xml", name.display()), files.description).expect("the folder is ours");
}

/// Writes a scan.
pub fn write(name: &Path, scan: &IconScan) {
    write_files(name, scan.files());
}

/// Opens a scan.
pub fn reader(name: &Path) -> ScanReader {
    match open(name) {
        Ok(Content::Scan(reader)) => reader,
        other => panic!("{other:?} is no scan"),
    }
}

/// A folder that removes itself, and a name in it.
pub fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let name = folder.path().join("board.7");
    (folder, name)
}

/// A subcomponent as XML: type, name, bytes of a row, numbers of a row.
pub fn plane(kind: &str, name: &str, size: usize, width: usize) -> String {
    format!(
        "<subcomponent name=\"{name}\" valuetype=\"{kind}\">\n<parameter name=\"size\">{size}</parameter>\n\
         <parameter name=\"width\">{width}</parameter>\n</subcomponent>\n"
    )
}

/// Writes an image between two planes of that name, type, row [bytes] and width.
pub fn write_between(name: &Path, image: &SensorImage, layout: &str, beside: [(&str, &str, usize, usize); 2]) {
    write_files(name, image.files());
    let path = format!("{}.xml", name.display());
    let good = fs::read_to_string(&path).expect("it was just written").replace("SCAN", layout);
    let at = good.find("<subcomponent").expect("it is there");
    let [first, last] = beside.map(|(name, kind, size, width)| plane(kind, name, size, width));
    let text = format!("{}{first}{}", &good[..at], &good[at..]).replace("</component>", &format!("{last}</component>"));
    fs::write(path, text).expect("the folder is ours");
    let filled = |n: usize| vec![0xAA; n];
    let between = |rows: usize, dn: &[u8]| [&filled(rows * beside[0].2), dn, &filled(rows * beside[1].2)].concat();
    let bytes = match layout {
        "SCAN" => image.dn.chunks(image.cols).flat_map(|line| between(1, line)).collect(),
        _ => between(image.rows, &image.dn),
    };
    fs::write(format!("{}.dat", name.display()), bytes).expect("the folder is ours");
}
