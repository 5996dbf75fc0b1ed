//! Grey PNG images: measured maps as whole numbers.
//!
//! Filter and compression were chosen with `benches/write.rs` on noisy content; see [`write_png`].

use std::io::Cursor;

use image::codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder};
use image::{ColorType, ExtendedColorType, ImageDecoder, ImageEncoder, Limits};

/// Pixels of a grey image, row-major.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Grey {
    /// 8 bits.
    Eight(Vec<u8>),
    /// 16 bits.
    Sixteen(Vec<u16>),
}

impl Grey {
    /// Every pixel as a number.
    pub fn numbers(&self) -> Vec<u16> {
        match self {
            Self::Eight(pixels) => pixels.iter().map(|&p| u16::from(p)).collect(),
            Self::Sixteen(pixels) => pixels.clone(),
        }
    }

    /// Bits in a pixel.
    pub fn bits(&self) -> u8 {
        match self {
            Self::Eight(_) => 8,
            Self::Sixteen(_) => 16,
        }
    }
}

/// Height -> range numbers: 0 where missing, else `1 + ...` so that a value r means `offset + r * scale`, saturating at
/// 1 and 65535. `offset` and `scale` in the unit of the heights [mm or px].
pub fn range_numbers(range: &[f32], offset: f64, scale: f64) -> Vec<u16> {
    let number = |&z: &f32| {
        if z.is_nan() { 0 } else { ((f64::from(z) - offset) / scale).round().clamp(1.0, 65535.0) as u16 }
    };
    range.iter().map(number).collect()
}

/// Digital numbers -> whole numbers, saturating; NaN becomes 0.
pub fn rounded16(map: &[f32]) -> Vec<u16> {
    map.iter().map(|v| v.round() as u16).collect()
}

/// Digital numbers -> whole numbers, saturating; NaN becomes 0.
pub fn rounded8(map: &[f32]) -> Vec<u8> {
    map.iter().map(|v| v.round() as u8).collect()
}

/// An image of `cols` columns as PNG, with fast compression and adaptive filters: on noisy maps ten times as fast as
/// deflate's default for a sixth more bytes, and small on labels too.
///
/// # Panics
/// Where the pixels are not whole rows of `cols`, or there are none.
pub fn write_png(image: &Grey, cols: usize) -> Vec<u8> {
    write_png_as(image, cols, CompressionType::Fast, FilterType::Adaptive)
}

/// As [`write_png`] with a given compression and filter.
///
/// # Panics
/// As [`write_png`].
pub fn write_png_as(image: &Grey, cols: usize, compression: CompressionType, filter: FilterType) -> Vec<u8> {
    let (bytes, color) = match image {
        Grey::Eight(pixels) => (pixels.clone(), ExtendedColorType::L8),
        Grey::Sixteen(pixels) => (pixels.iter().flat_map(|p| p.to_ne_bytes()).collect(), ExtendedColorType::L16),
    };
    let size = image_size(bytes.len() / usize::from(image.bits() / 8), cols);
    let mut png = Vec::new();
    PngEncoder::new_with_quality(&mut png, compression, filter)
        .write_image(&bytes, size.0, size.1, color)
        .expect("memory takes every byte, and the size was computed from the pixels");
    png
}

fn image_size(pixels: usize, cols: usize) -> (u32, u32) {
    assert!(cols > 0 && pixels > 0 && pixels.is_multiple_of(cols), "{pixels} pixels are not whole rows of {cols}");
    let side = |n: usize| u32::try_from(n).expect("an image side is far below 2^32");
    (side(cols), side(pixels / cols))
}

/// Largest image that is decoded [bytes]: a damaged header must not take all memory.
const MAX_DECODED_BYTES: u64 = 2 << 30;

/// Columns, rows and pixels of a grey PNG.
///
/// # Errors
/// What is wrong with it, for a damaged file or one that is not grey with 8 or 16 bits.
pub fn read_png(png: &[u8]) -> Result<(u32, u32, Grey), String> {
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_DECODED_BYTES);
    let decoder = PngDecoder::with_limits(Cursor::new(png), limits).map_err(|e| e.to_string())?;
    let (cols, rows) = decoder.dimensions();
    if decoder.total_bytes() > MAX_DECODED_BYTES {
        return Err(format!("it claims {cols} x {rows} pixels"));
    }
    let color = decoder.color_type();
    if !matches!(color, ColorType::L8 | ColorType::L16) {
        return Err(format!("it is {color:?}, not grey"));
    }
    let mut bytes = vec![0; decoder.total_bytes() as usize];
    decoder.read_image(&mut bytes).map_err(|e| e.to_string())?;
    let grey = match color {
        ColorType::L8 => Grey::Eight(bytes),
        _ => Grey::Sixteen(bytes.as_chunks().0.iter().map(|&pair| u16::from_ne_bytes(pair)).collect()),
    };
    Ok((cols, rows, grey))
}
