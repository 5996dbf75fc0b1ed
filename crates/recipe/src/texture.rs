//! Texture: the picture that a projector throws, grey levels as light.

use std::io::Cursor;

use image::{ImageFormat, ImageReader};
use optical_bench::settings::TextureImage;

use crate::asset::{Asset, AssetFault};
use crate::picture::limited;

/// Most rows and most columns [px].
const MAX_SIDE: u32 = 2048;

/// The light of a PNG, or what is wrong with it; colours count by their luminance.
pub(crate) fn read(file: &Asset) -> Result<TextureImage, AssetFault> {
    let wrong = |problem: &str| {
        let remedy = format!("give a grey PNG of at most {MAX_SIDE} x {MAX_SIDE} pixels");
        AssetFault::new(format!("`{}` {problem}", file.name()), remedy)
    };
    let reader = limited(ImageReader::with_format(Cursor::new(file.bytes()), ImageFormat::Png), MAX_SIDE);
    let picture = reader.decode().map_err(|error| wrong(&format!("is no picture that can be read: {error}")))?;
    let picture = picture.into_luma16();
    let (columns, rows) = (picture.width() as usize, picture.height() as usize);
    let light: Vec<f32> = picture.into_raw().into_iter().map(|grey| f32::from(grey) / 65535.0).collect();
    if light.iter().all(|&light| light == 0.0) {
        return Err(wrong("holds no light"));
    }
    Ok(TextureImage { rows, columns, light: light.into() })
}
