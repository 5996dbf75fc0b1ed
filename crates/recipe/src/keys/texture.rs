//! Texture: the picture that a projector throws, grey levels as light.

use std::io::Cursor;

use image::{ImageFormat, ImageReader, Limits};

use optical_bench::settings::TextureImage;

/// Most rows and most columns [px].
pub(crate) const MAX_SIDE: u32 = 2048;

/// The light of a PNG, or what is wrong with it; colours count by their luminance.
pub(crate) fn read(bytes: &[u8]) -> Result<TextureImage, String> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    reader.limits(limits);
    let picture = reader.decode().map_err(|error| format!("is no picture that can be read: {error}"))?.into_luma16();
    let (columns, rows) = (picture.width() as usize, picture.height() as usize);
    let light: Vec<f32> = picture.into_raw().into_iter().map(|grey| f32::from(grey) / 65535.0).collect();
    if light.iter().all(|&light| light == 0.0) {
        return Err("holds no light".to_owned());
    }
    Ok(TextureImage { rows, columns, light: light.into() })
}
