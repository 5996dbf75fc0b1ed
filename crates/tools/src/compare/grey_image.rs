//! Grey images of one map: PNG with 8 or 16 bits, TIFF with 8, 16 or 32 bits or floats, strips or tiles, without
//! compression or with LZW, deflate or PackBits. Their numbers are taken as they are stored.
//!
//! Not read: colours, palettes and transparency, fewer bits (viewers scale them), several pages, TIFF whose numbers are
//! turned round (WhiteIsZero), JPEG and fax compression. Units that a TIFF names, such as dots per inch, are those of a
//! print and are not taken for pitches.

use std::io::Cursor;
use std::path::Path;

use png::{BitDepth, ColorType, Decoder, Limits, Transformations};
use tiff::decoder::DecodingResult;
use tiff::tags::Tag;

use super::map_numbers::{MAX_PIXELS, MapNumbers};
use super::scan_format::{ScanContent, ScanFormat, StatedForm, read_file};
use dataset::Fault;

/// Longest file that is read [bytes]: every pixel as eight bytes, and something around them.
const MAX_FILE_BYTES: u64 = MAX_PIXELS as u64 * 8 + (16 << 20);
/// What decoders take beside the pixels [bytes].
const DECODER_BYTES: usize = 64 << 20;
/// TIFF's word for "0 is black".
const BLACK_IS_ZERO: u16 = 1;

/// PNG and TIFF.
pub(super) const FORMAT: ScanFormat = ScanFormat {
    endings: &[("png", ".png", true), ("tif", ".tif", true), ("tiff", ".tiff", true)],
    stated: Some(StatedForm::Image),
    read: |path, _| read(path),
};

fn read(path: &Path) -> Result<ScanContent, Fault> {
    let bytes = read_file(path, MAX_FILE_BYTES, "give a grey PNG or TIFF")?;
    let is_png = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    let map = if is_png { png(&bytes) } else { tiff(&bytes) };
    let remedy = "give one map as a grey PNG or TIFF (docs/guide/compare.md)";
    map.map(ScanContent::Grid).map_err(|what| Fault::at(path, what, remedy))
}

/// The size of an image, where that many pixels are read.
fn size(cols: u32, rows: u32) -> Result<(usize, usize), String> {
    let pixels = u64::from(cols) * u64::from(rows);
    match pixels {
        0 => Err("it has no pixels".into()),
        _ if pixels > MAX_PIXELS as u64 => Err(format!(
            "its {rows} rows of {cols} columns are {pixels} pixels, more than the {MAX_PIXELS} that are compared"
        )),
        _ => Ok((cols as usize, rows as usize)),
    }
}

fn png(bytes: &[u8]) -> Result<MapNumbers, String> {
    let damaged = |e: png::DecodingError| format!("it is no whole PNG: {e}");
    // Of a row, not of the image: that is counted below.
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: DECODER_BYTES + 2 * MAX_PIXELS });
    decoder.set_transformations(Transformations::IDENTITY);
    let mut reader = decoder.read_info().map_err(damaged)?;
    let info = reader.info();
    let (color, depth) = (info.color_type, info.bit_depth);
    let ((cols, rows), is_wide) = (size(info.width, info.height)?, depth == BitDepth::Sixteen);
    if color != ColorType::Grayscale || !(is_wide || depth == BitDepth::Eight) {
        return Err(format!("it is {color:?} of {} bits, not grey of 8 or 16", depth as u8));
    }
    let length = reader.output_buffer_size().ok_or("its size is beyond memory")?;
    let mut pixels = vec![0; length];
    reader.next_frame(&mut pixels).map_err(damaged)?;
    let numbers = if is_wide {
        pixels.as_chunks::<2>().0.iter().map(|pair| f64::from(u16::from_be_bytes(*pair))).collect()
    } else {
        pixels.iter().map(|&dn| f64::from(dn)).collect()
    };
    Ok(MapNumbers { cols, rows, numbers, bits: Some(if is_wide { 16 } else { 8 }) })
}

fn tiff(bytes: &[u8]) -> Result<MapNumbers, String> {
    let damaged = |e: tiff::TiffError| format!("it is no whole TIFF: {e}");
    let mut limits = tiff::decoder::Limits::default();
    limits.decoding_buffer_size = MAX_PIXELS * 8;
    limits.intermediate_buffer_size = DECODER_BYTES + MAX_PIXELS * 8;
    let mut decoder = tiff::decoder::Decoder::new(Cursor::new(bytes)).map_err(damaged)?.with_limits(limits);
    let (cols, rows) = decoder.dimensions().map_err(damaged)?;
    let (cols, rows) = size(cols, rows)?;
    let color = decoder.colortype().map_err(damaged)?;
    if !matches!(color, tiff::ColorType::Gray(8 | 16 | 32 | 64)) {
        return Err(format!("it is {color:?}, not grey of 8, 16 or 32 bits"));
    }
    let meaning: Option<u16> = decoder.find_tag_unsigned(Tag::PhotometricInterpretation).map_err(damaged)?;
    if meaning != Some(BLACK_IS_ZERO) {
        return Err("its numbers are turned round (WhiteIsZero): save it with 0 as black".into());
    }
    if decoder.more_images() {
        return Err("it has several pages: save each map as a file".into());
    }
    let whole = |numbers: Vec<f64>, bits: u8| (numbers, Some(bits));
    let (numbers, bits) = match decoder.read_image().map_err(damaged)? {
        DecodingResult::U8(dn) => whole(dn.into_iter().map(f64::from).collect(), 8),
        DecodingResult::U16(dn) => whole(dn.into_iter().map(f64::from).collect(), 16),
        DecodingResult::U32(dn) => whole(dn.into_iter().map(f64::from).collect(), 32),
        DecodingResult::I8(dn) => whole(dn.into_iter().map(f64::from).collect(), 16),
        DecodingResult::I16(dn) => whole(dn.into_iter().map(f64::from).collect(), 16),
        DecodingResult::I32(dn) => whole(dn.into_iter().map(f64::from).collect(), 32),
        DecodingResult::F32(mm) => (mm.into_iter().map(f64::from).collect(), None),
        DecodingResult::F64(mm) => (mm, None),
        _ => return Err("its numbers are neither whole ones of 8, 16 or 32 bits nor floats of 32 or 64".into()),
    };
    if numbers.len() != cols * rows {
        return Err(format!("its {} numbers are not {cols} x {rows}", numbers.len()));
    }
    Ok(MapNumbers { cols, rows, numbers, bits })
}

#[cfg(test)]
mod tests {
    use super::*;
    use dataset::{Grey, write_png};

    /// Whole numbers of both sizes come back as they were written.
    #[test]
    fn grey_png_is_read() {
        let wide = png(&write_png(&Grey::Sixteen(vec![0, 1, 256, 65535, 7, 8]), 3)).expect("it is whole");
        assert_eq!((wide.cols, wide.rows, wide.bits), (3, 2, Some(16)));
        assert_eq!(wide.numbers, [0.0, 1.0, 256.0, 65535.0, 7.0, 8.0]);
        let narrow = png(&write_png(&Grey::Eight(vec![0, 255]), 2)).expect("it is whole");
        assert_eq!((narrow.numbers, narrow.bits), (vec![0.0, 255.0], Some(8)));
    }

    /// Colours, fewer bits and sizes beyond the bound are refused before pixels are decoded.
    #[test]
    fn other_png_is_refused() {
        let picture = |color, depth, size: (u32, u32), pixels: &[u8]| {
            let mut bytes = Vec::new();
            let mut encoder = png::Encoder::new(&mut bytes, size.0, size.1);
            encoder.set_color(color);
            encoder.set_depth(depth);
            let mut writer = encoder.write_header().expect("memory takes it");
            writer.write_image_data(pixels).expect("memory takes it");
            writer.finish().expect("memory takes it");
            bytes
        };
        let told = |bytes: &[u8], words: &str| {
            let what = png(bytes).expect_err(words);
            assert!(what.contains(words), "'{words}' is not in: {what}");
        };
        told(&picture(ColorType::Rgb, BitDepth::Eight, (1, 1), &[1, 2, 3]), "Rgb of 8 bits");
        told(&picture(ColorType::Grayscale, BitDepth::Four, (2, 1), &[0x12]), "of 4 bits");
        let mut huge = write_png(&Grey::Eight(vec![1; 4]), 2);
        huge[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
        // Its checksum is of other numbers: either is told, and neither takes memory.
        assert!(png(&huge).is_err());
        assert!(size(1 << 16, 1 << 16).expect_err("too many").contains("4294967296 pixels"));
    }
}
