//! JSON frames, as programs on the camera's own platform store them: a list of images with pixel size and base64
//! pixels. The first image is range (16 bits, 0 where missing), the second reflectance (8 bits) on the same grid;
//! further images are not read.

use std::fmt;
use std::io::ErrorKind;
use std::path::Path;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::de::{IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::ScanMaps;
use super::scan_format::{ScanContent, ScanFormat};
use dataset::{Fault, atomic_file};

/// Longest file that is read [bytes]: 32 million pixels, three times a scan of the thesis.
const MAX_FILE_BYTES: u64 = 130 << 20;
/// Images that are read.
const IMAGES: usize = 2;

/// What an entry says of itself.
#[derive(Deserialize)]
struct EntryClass {
    class: String,
}

/// An entry that is an image.
#[derive(Deserialize)]
struct ImageEntry {
    data: JsonImage,
}

/// The places of the first images in the list, found without keeping what the entries hold.
struct ImagePlaces;

impl<'de> Visitor<'de> for ImagePlaces {
    type Value = Vec<usize>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a sequence of images")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<usize>, A::Error> {
        let (mut places, mut place) = (Vec::new(), 0);
        while let Some(entry) = list.next_element::<EntryClass>()? {
            if entry.class == "Image" && places.len() < IMAGES {
                places.push(place);
            }
            place += 1;
        }
        Ok(places)
    }
}

/// The images at some places of the list.
struct ImagesAt(Vec<usize>);

impl<'de> Visitor<'de> for ImagesAt {
    type Value = Vec<JsonImage>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a sequence of images")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<JsonImage>, A::Error> {
        let (mut images, mut place) = (Vec::new(), 0);
        loop {
            if self.0.contains(&place) {
                let Some(entry) = list.next_element::<ImageEntry>()? else { return Ok(images) };
                images.push(entry.data);
            } else if list.next_element::<IgnoredAny>()?.is_none() {
                return Ok(images);
            }
            place += 1;
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct JsonImage {
    pixel_size: Point,
    origin: Point,
    data: PixelArray,
}

#[derive(Deserialize)]
struct Point {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct PixelArray {
    image_type: String,
    width: usize,
    height: usize,
    pixels: EncodedPixels,
}

#[derive(Deserialize)]
struct EncodedPixels {
    endian: String,
    data: String,
}

/// Images as JSON.
pub(super) const FORMAT: ScanFormat =
    ScanFormat { endings: &[("json", ".json", true)], stated: None, read: |path, _| read(path) };

fn read(path: &Path) -> Result<ScanContent, Fault> {
    let whole = "give a JSON file with a range image and a reflectance image as docs/guide/compare.md describes";
    let text = atomic_file::read(path, MAX_FILE_BYTES).map_err(|e| match e.kind() {
        ErrorKind::FileTooLarge => Fault::at(path, "it is longer than any frame", whole),
        _ => Fault::at(path, format!("it cannot be read: {e}"), "allow it"),
    })?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let maps = frame(&name, &text).map_err(|what| Fault::at(path, what, whole))?;
    Ok(ScanContent::Scan(Box::new(maps)))
}

/// A frame of the text of a file.
fn frame(name: &str, text: &[u8]) -> Result<ScanMaps, String> {
    let list = |text| serde_json::Deserializer::from_slice(text);
    let places = list(text).deserialize_seq(ImagePlaces).map_err(|e| e.to_string())?;
    let mut read = list(text);
    let images = read.deserialize_seq(ImagesAt(places)).map_err(|e| format!("an image is not whole: {e}"))?;
    read.end().map_err(|e| e.to_string())?;
    let mut images = images.into_iter();
    let range = images.next().ok_or("it holds no image")?;
    let (cols, rows, size, z0) = (range.data.width, range.data.height, range.pixel_size, range.origin.z);
    let wide = range.data.numbers("uint16", 2)?;
    let even = |mm: f64| mm.is_finite() && mm > 0.0;
    if !(even(size.x) && even(size.y) && even(size.z) && z0.is_finite()) {
        return Err(format!("its pixel size is {} x {} x {} mm", size.x, size.y, size.z));
    }
    let height = |&n: &u16| if n == 0 { f64::NAN } else { z0 + f64::from(n) * size.z };
    let light = match images.next() {
        None => None,
        Some(image) if (image.data.width, image.data.height) != (cols, rows) => {
            let (w, h) = (image.data.width, image.data.height);
            return Err(format!("range is {cols} x {rows}, reflectance {w} x {h}"));
        }
        Some(image) => Some(image.data.numbers("uint8", 1)?.into_iter().map(f32::from).collect()),
    };
    Ok(ScanMaps {
        name: name.into(),
        cols,
        rows,
        col_mm: Some(size.x),
        row_mm: Some(size.y),
        range: wide.iter().map(height).collect(),
        reflectance: light,
        ..ScanMaps::default()
    })
}

impl PixelArray {
    fn numbers(&self, kind: &str, bytes: usize) -> Result<Vec<u16>, String> {
        if self.image_type != kind {
            return Err(format!("an image holds {}, not {kind}", self.image_type));
        }
        let pixels = BASE64_STANDARD.decode(&self.pixels.data).map_err(|e| format!("its pixels are no base64: {e}"))?;
        let expected = self.width.checked_mul(self.height).and_then(|n| n.checked_mul(bytes));
        if expected != Some(pixels.len()) || pixels.is_empty() {
            let found = pixels.len();
            return Err(format!("{} x {} pixels of {bytes} bytes are not {found} bytes", self.width, self.height));
        }
        match (bytes, self.pixels.endian.as_str()) {
            (1, _) => Ok(pixels.into_iter().map(u16::from).collect()),
            (_, "big") => Ok(pixels.as_chunks::<2>().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect()),
            (_, "little") => Ok(pixels.as_chunks::<2>().0.iter().map(|pair| u16::from_le_bytes(*pair)).collect()),
            (_, other) => Err(format!("its pixels have the order of bytes '{other}', neither big nor little")),
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn image(kind: &str, endian: &str, (width, height): (usize, usize), bytes: &[u8]) -> Value {
        let pixels = json!({ "elemSz": 2, "endian": endian, "data": BASE64_STANDARD.encode(bytes) });
        let grid = json!({ "ImageType": kind, "Width": width, "Height": height, "Pixels": pixels });
        let (size, origin) = (json!({ "x": 0.1, "y": 0.2, "z": 0.005 }), json!({ "x": -3.0, "y": 0, "z": 0 }));
        json!({ "class": "Image", "data": { "PixelSize": size, "Origin": origin, "Data": grid } })
    }

    fn whole() -> Value {
        let range = image("uint16", "big", (2, 2), &[1, 0, 0, 0, 0, 2, 0, 3]);
        let light = image("uint8", "neutral", (2, 2), &[20, 0, 255, 7]);
        json!([range, light, { "class": "SensorData", "data": { "FrameNo": 34 } }])
    }

    /// Big-endian steps of z become heights, 0 becomes missing, reflectance lies on the same grid.
    #[test]
    fn frames_are_read() {
        let found = frame("a", whole().to_string().as_bytes()).expect("it is whole");
        assert_eq!((found.cols, found.rows, found.col_mm, found.row_mm), (2, 2, Some(0.1), Some(0.2)));
        assert_eq!((found.range[0], found.range[2], found.range[3]), (1.28, 0.01, 3.0 * 0.005));
        assert!(found.range[1].is_nan());
        assert_eq!(found.reflectance, Some(vec![20.0, 0.0, 255.0, 7.0]));
    }

    /// Damage is told, with what is wrong.
    #[test]
    fn damage_is_told() {
        let told = |value: &Value, what: &str| {
            let error = frame("a", value.to_string().as_bytes()).expect_err(what);
            assert!(error.contains(what), "'{what}' is not in: {error}");
        };
        told(&json!([]), "no image");
        told(&json!({}), "expected a sequence");
        for (path, value, what) in [
            ("/0/data/Data/Width", json!(3), "3 x 2 pixels of 2 bytes are not 8 bytes"),
            ("/0/data/Data/Width", json!(usize::MAX), "are not 8 bytes"),
            ("/0/data/Data/ImageType", json!("float"), "holds float, not uint16"),
            ("/0/data/Data/Pixels/endian", json!("mixed"), "neither big nor little"),
            ("/0/data/Data/Pixels/data", json!("?"), "no base64"),
            ("/0/data/PixelSize/z", json!(0.0), "pixel size"),
            ("/0/data/PixelSize", json!(null), "not whole"),
            ("/1/data/Data/Height", json!(1), "range is 2 x 2, reflectance 2 x 1"),
        ] {
            let mut broken = whole();
            *broken.pointer_mut(path).expect("it is there") = value;
            told(&broken, what);
        }
        let text = whole().to_string();
        assert!((0..text.len()).all(|end| frame("a", &text.as_bytes()[..end]).is_err()));
    }
}
