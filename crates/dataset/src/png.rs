//! Grey PNG images: measured maps as whole numbers.
//!
//! Filter and compression were chosen with `benches/write.rs` on noisy content; see [`write_png`].

use std::io::Cursor;

use image::codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder};
use image::{ColorType, ExtendedColorType, ImageDecoder, ImageEncoder, Limits};
use multiversion::multiversion;

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
    let mut numbers = vec![0; range.len()];
    number(range, offset, scale, &mut numbers);
    numbers
}

/// As [`range_numbers`], in place.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn number(range: &[f32], offset: f64, scale: f64, numbers: &mut [u16]) {
    for (number, &z) in numbers.iter_mut().zip(range) {
        *number = range_number(z, offset, scale);
    }
}

#[inline(always)]
fn range_number(z: f32, offset: f64, scale: f64) -> u16 {
    if z.is_nan() { 0 } else { ((f64::from(z) - offset) / scale).round().clamp(1.0, 65535.0) as u16 }
}

/// Steps of heights in files, per mm or px: a power of two, so that they are exact. 0.12 um is far below any noise of
/// such an instrument; the bits beyond it would be a third of an EXR file that holds truth maps.
pub(crate) const HEIGHT_STEPS: f32 = 8192.0;

/// A height as it is kept [mm or px]; NaN stays, and 0 has no sign.
#[inline(always)]
pub(crate) fn stepped(height: f32) -> f32 {
    (height * HEIGHT_STEPS).round() / HEIGHT_STEPS + 0.0
}

/// The way back of one of [`range_numbers`] [mm or px].
#[inline(always)]
pub(crate) fn range_value(number: u16, offset: f64, scale: f64) -> f32 {
    if number == 0 { f32::NAN } else { stepped((offset + f64::from(number) * scale) as f32) }
}

/// Range numbers -> height, the way back of [`range_numbers`]: 0 becomes NaN [mm or px].
pub fn range_values(numbers: &[u16], offset: f64, scale: f64) -> Vec<f32> {
    numbers.iter().map(|&number| range_value(number, offset, scale)).collect()
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

/// Largest image that is decoded where its size is not known before [bytes]: a damaged header must not take all memory.
const MAX_DECODED_BYTES: u64 = 2 << 30;
/// What the decoder may take beside the pixels [bytes].
const DECODER_BYTES: u64 = 16 << 20;
/// How PNG files begin.
const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Columns, rows and pixels of a grey PNG.
///
/// # Errors
/// What is wrong with it, for a damaged file or one that is not grey with 8 or 16 bits.
pub fn read_png(png: &[u8]) -> Result<(u32, u32, Grey), String> {
    let size = png_size(png)?;
    Ok((size.cols, size.rows, decoded(png, MAX_DECODED_BYTES)?))
}

/// Pixels of a grey PNG of that many columns and rows; nothing is taken for one of another size.
///
/// # Errors
/// As [`read_png`], and where it has another size.
pub fn read_png_of(png: &[u8], (cols, rows): (u64, u64)) -> Result<Grey, String> {
    let size = png_size(png)?;
    if (u64::from(size.cols), u64::from(size.rows)) != (cols, rows) {
        return Err(format!("it is {} x {}, not {cols} x {rows} as dataset.json says", size.cols, size.rows));
    }
    decoded(png, cols.saturating_mul(rows).saturating_mul(2))
}

/// What the header of a PNG says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PngSize {
    /// Columns [px].
    pub(crate) cols: u32,
    /// Rows [px].
    pub(crate) rows: u32,
    /// Bits in a pixel, of a grey one.
    pub(crate) bits: u8,
}

/// The size of a grey PNG, by its header alone.
///
/// # Errors
/// What is wrong with it, for one that is not grey with 8 or 16 bits.
pub(crate) fn png_size(png: &[u8]) -> Result<PngSize, String> {
    let decoder = decoder(png, 0)?;
    let (cols, rows) = decoder.dimensions();
    match decoder.color_type() {
        ColorType::L8 => Ok(PngSize { cols, rows, bits: 8 }),
        ColorType::L16 => Ok(PngSize { cols, rows, bits: 16 }),
        color => Err(format!("it is {color:?}, not grey")),
    }
}

fn decoder(png: &[u8], most: u64) -> Result<PngDecoder<Cursor<&[u8]>>, String> {
    let mut limits = Limits::default();
    limits.max_alloc = Some(most + DECODER_BYTES);
    PngDecoder::with_limits(Cursor::new(png), limits).map_err(|e| e.to_string())
}

/// The pixels, `most` bytes of them.
fn decoded(png: &[u8], most: u64) -> Result<Grey, String> {
    let decoder = decoder(png, most)?;
    let (color, (cols, rows)) = (decoder.color_type(), decoder.dimensions());
    if decoder.total_bytes() > most {
        return Err(format!("it claims {cols} x {rows} pixels"));
    }
    let mut bytes = vec![0; decoder.total_bytes() as usize];
    decoder.read_image(&mut bytes).map_err(|e| e.to_string())?;
    Ok(match color {
        ColorType::L8 => Grey::Eight(bytes),
        _ => Grey::Sixteen(bytes.as_chunks().0.iter().map(|&pair| u16::from_ne_bytes(pair)).collect()),
    })
}

/// What a PNG holds that [`write_png`] never writes: another chunk than header, pixels and end, interlaced pixels, or
/// bytes beyond its end. Viewers show other pixels for some of them.
pub(crate) fn foreign_part(png: &[u8]) -> Option<String> {
    let mut rest = png.strip_prefix(SIGNATURE)?;
    let mut first = true;
    while let Some((length, body)) = rest.split_first_chunk::<4>() {
        let (kind, content) = body.split_first_chunk::<4>()?;
        let length = u32::from_be_bytes(*length) as usize;
        let content = content.get(..length.checked_add(4)?)?;
        rest = &body[4 + content.len()..];
        let known = if first { kind == b"IHDR" } else { matches!(kind, b"IDAT" | b"IEND") };
        if !known {
            return Some(format!("a chunk {}", kind.escape_ascii()));
        }
        if first && content.get(10..13) != Some(&[0; 3]) {
            return Some("interlaced pixels".into());
        }
        if kind == b"IEND" {
            break;
        }
        first = false;
    }
    (!rest.is_empty()).then(|| format!("{} bytes beyond its end", rest.len()))
}
