//! Clouds of points in PLY, text and binary of both byte orders: x, y, z of `vertex`, its `reflectance` (or
//! `intensity`) and `scatter`. A cloud whose header has the lines `obj_info num_cols` and `obj_info num_rows` and as
//! many points as these make is stored profile by profile. Everything else in a file is passed over. Header and binary
//! points go through ply-rs-bw; points in text do not, since it takes no `nan`, which is how other programs write
//! missing points.

use std::io::Cursor;
use std::path::Path;

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

use super::map_numbers::{MAX_PIXELS, POINT_NAMES, ScanPoints, point_axis};
use super::scan_format::{ScanContent, ScanFormat, StatedForm, read_file};
use dataset::Fault;

/// Longest file that is read [bytes].
const MAX_FILE_BYTES: u64 = 2 << 30;

/// A point as it is read: x, y, z, Reflectance, Scatter; NaN where the file has none.
struct PlyPoint([f64; 5]);

impl PropertyAccess for PlyPoint {
    fn new() -> Self {
        Self([f64::NAN; 5])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(place) = point_axis(name) else { return PropertyAccessResult::Ignored };
        self.0[place] = match property {
            Property::Char(n) => n.into(),
            Property::UChar(n) => n.into(),
            Property::Short(n) => n.into(),
            Property::UShort(n) => n.into(),
            Property::Int(n) => n.into(),
            Property::UInt(n) => n.into(),
            Property::Float(n) => n.into(),
            Property::Double(n) => n,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// PLY.
pub(super) const FORMAT: ScanFormat =
    ScanFormat { endings: &[("ply", ".ply", true)], stated: Some(StatedForm::Ply), read: |path, _| read(path) };

fn read(path: &Path) -> Result<ScanContent, Fault> {
    let points = points(&read_file(path, MAX_FILE_BYTES, "give a PLY file")?);
    let remedy = "give a PLY file with x, y and z of each `vertex`";
    points.map(ScanContent::Points).map_err(|what| Fault::at(path, what, remedy))
}

fn points(bytes: &[u8]) -> Result<ScanPoints, String> {
    let describe = |error: ParseError| clipped(&error.to_string().replace(['\n', '\t'], " "));
    let mut reader = Reader::new(Cursor::new(bytes));
    let parser = Parser::<PlyPoint>::new();
    let header = parser.read_header(&mut reader).map_err(describe)?;
    let begin = usize::try_from(reader.get_ref().position()).unwrap_or(bytes.len()).min(bytes.len());
    let is_text = header.encoding == Encoding::Ascii;
    let text = if is_text { std::str::from_utf8(&bytes[begin..]).map_err(|e| format!("its points: {e}"))? } else { "" };
    let first = 1 + bytes[..begin].iter().filter(|byte| **byte == b'\n').count();
    let mut lines = text.lines().enumerate().map(|(i, line)| (first + i, line));
    for element in header.elements.values() {
        let is_points = element.name == "vertex";
        // Each has a byte at least, unless it is empty.
        if element.count > bytes.len() || (element.count > 0 && element.properties.is_empty()) {
            return Err(format!("{} elements `{}` do not fit {} bytes", element.count, element.name, bytes.len()));
        }
        if element.count > MAX_PIXELS {
            return Err(format!("it has {} elements `{}`: at most {MAX_PIXELS} are read", element.count, element.name));
        }
        let read = if !is_text {
            parser.read_payload_for_element(&mut reader, element, &header).map_err(describe)?
        } else if is_points {
            let mut read = Vec::new();
            for (line, text) in lines.by_ref().take(element.count) {
                let point = text_point(text, element);
                let wrong = || format!("line {line}: '{}' is no `vertex` of its header", clipped(text));
                read.push(point.ok_or_else(wrong)?);
            }
            if read.len() < element.count {
                return Err(format!("it ends after {} of {} `vertex`", read.len(), element.count));
            }
            read
        } else {
            lines.by_ref().take(element.count).for_each(drop);
            continue;
        };
        if !is_points {
            continue;
        }
        if read.is_empty() {
            break;
        }
        let kind = |names: &[&str]| names.iter().find_map(|name| element.properties.get(*name)).map(|p| &p.data_type);
        if POINT_NAMES[..3].iter().any(|names| kind(names).is_none()) {
            return Err("its `vertex` has not all of x, y and z".into());
        }
        if POINT_NAMES[3].iter().all(|name| element.properties.contains_key(*name)) {
            return Err("its `vertex` has both reflectance and intensity".into());
        }
        let map = |place: usize| -> Option<Vec<f64>> {
            kind(POINT_NAMES[place]).map(|_| read.iter().map(|point| point.0[place]).collect())
        };
        let (reflectance, scatter) = (map(3), map(4));
        return Ok(ScanPoints {
            places: read.iter().map(|PlyPoint([x, y, z, ..])| [*x, *y, *z]).collect(),
            reflectance,
            scatter,
            bits: (kind(POINT_NAMES[3]) == Some(&PropertyType::Scalar(ScalarType::UChar))).then_some(8),
            organised: organised(&header).filter(|[cols, rows]| cols.checked_mul(*rows) == Some(read.len())),
            unit_mm: None,
        });
    }
    Err("it has no points".into())
}

/// A point of a line of text; `None` where it is none.
fn text_point(line: &str, element: &ElementDef) -> Option<PlyPoint> {
    let mut words = line.split_ascii_whitespace();
    let mut point = PlyPoint::new();
    for (name, property) in &element.properties {
        let word = words.next()?;
        match property.data_type {
            PropertyType::Scalar(_) => {
                let number: f64 = word.parse().ok()?;
                if let Some(place) = point_axis(name) {
                    point.0[place] = number;
                }
            }
            PropertyType::List(..) => {
                let count: usize = word.parse().ok()?;
                for _ in 0..count {
                    words.next()?;
                }
            }
        }
    }
    Some(point)
}

/// The begin of a text that a file may make long.
fn clipped(text: &str) -> String {
    const MAX_LETTERS: usize = 200;
    text.chars().take(MAX_LETTERS).flat_map(char::escape_debug).collect()
}

/// Columns and profiles that the header tells.
fn organised(header: &Header) -> Option<[usize; 2]> {
    let told = |key: &str| {
        let mut words = header.obj_infos.iter().map(|line| line.split_whitespace());
        words.find_map(|mut words| (words.next() == Some(key)).then(|| words.next()?.parse().ok()).flatten())
    };
    Some([told("num_cols")?, told("num_rows")?])
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOUD: &str = "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 1\nelement other 1\nproperty \
        int a\n\
                         element vertex 2\nproperty float x\nproperty double y\nproperty float z\nproperty uchar \
                         intensity\n\
                         property float nx\nend_header\n5\n1 2 3 200 0\n1.5 2 nan 0 0\n";

    /// Text of points, with an element before them and a property that is passed over.
    #[test]
    fn text_is_read() {
        let found = points(CLOUD.as_bytes()).expect("it is whole");
        assert_eq!((found.places[0], found.organised, found.bits), ([1.0, 2.0, 3.0], Some([2, 1]), Some(8)));
        assert_eq!((found.places[1][0], found.places[1][2].is_nan()), (1.5, true));
        assert_eq!((found.reflectance, found.scatter), (Some(vec![200.0, 0.0]), None));
    }

    /// What is not there, or not whole, is told.
    #[test]
    fn damage_is_told() {
        for (old, new, words) in [
            ("property float z\n", "property float q\n", "x, y and z"),
            ("element vertex 2", "element vertex 3", ""),
            ("element vertex 2", "element vertex 99999999999", "do not fit"),
            ("element vertex", "element corner", "no points"),
            ("property float nx", "property uchar reflectance", "both"),
            ("1 2 3", "1 two 3", "line 15: '1 two 3 200 0' is no `vertex`"),
            ("ply", "plx", ""),
        ] {
            let text = CLOUD.replacen(old, new, 1);
            let what = points(text.as_bytes()).err().unwrap_or_else(|| panic!("{new} is no fault"));
            assert!(what.contains(words), "'{words}' is not in: {what}");
        }
        let whole = CLOUD.len();
        (0..whole - 8).for_each(|end| assert!(points(&CLOUD.as_bytes()[..end]).is_err(), "{end} of {whole} bytes"));
        // A grid of another size is none.
        let other = points(CLOUD.replacen("num_rows 1", "num_rows 7", 1).as_bytes()).expect("it is whole");
        assert_eq!(other.organised, None);
    }
}
