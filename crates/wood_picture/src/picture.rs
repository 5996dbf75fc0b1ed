//! A picture at the door: brightness made linear in light, and checks that need no analysis.
//!
//! Model: brightness in proportion to light, B = s R with one factor s for the picture. sRGB's curve after IEC
//! 61966-2-1: c / 12.92 up to 0.04045, else ((c + 0.055) / 1.055)^2.4; other curves are powers. Which channel: the
//! laser has 660 nm, and the red channel of a camera spans 580 to 690 nm about, so a colour picture is reduced to its
//! red channel alone, made linear and divided by the white balance's factor, which moves s and nothing else. Limits:
//! even light; the tone curves of phones are none of these (take raw files); red is a mean over 100 nm.

use crate::raster::quantile_of;
use crate::{PictureAnalysis, PictureFault};

/// Least length and width of what a picture shows [mm]: some windows of the orientation's integral.
pub(crate) const LEAST_MM: f32 = 15.0;
/// Longest pixel [mm]: bundles of fibres are 0.1 to 0.6 mm wide.
const COARSEST_MM: f32 = 0.4;
/// Longest side of a pixel over its shortest [1].
const MOST_PIXEL_ASPECT: f32 = 4.0;
/// Lengths of board and picture may differ by this part [1]: a crop by eye.
const ASPECT_TOLERANCE: f32 = 0.03;
/// Least spread of the middle 90 % of the pixels over their median [1]: an 8-bit step at half scale.
const LEAST_SPREAD: f32 = 0.01;
/// Share of pixels that may have reached the end of the scale [1]: three photographs with 4 % had directions within 0.5
/// degrees and absorption within 4 % of what they had before.
const MOST_SATURATED: f32 = 0.05;
/// From this part of the scale on a pixel has reached its end [1]: the last step of 8 bits.
const END: f32 = 254.5 / 255.0;

/// How the numbers of a picture go with light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Encoding {
    /// Nobody said: refused.
    Unknown,
    /// In proportion to light: raw files, EXR, a Reflectance map less its dark level.
    Linear,
    /// The curve of ordinary JPEG and PNG files.
    Srgb,
    /// Light to the power of one over this [1].
    Gamma(f32),
}

impl Encoding {
    /// Light of a number, both from 0 to 1 [1].
    pub fn light(self, number: f32) -> f32 {
        match self {
            Self::Unknown | Self::Linear => number,
            Self::Srgb if number <= 0.040_45 => number / 12.92,
            Self::Srgb => libm::powf((number + 0.055) / 1.055, 2.4),
            Self::Gamma(gamma) => libm::powf(number, gamma),
        }
    }
}

/// The red channel of a colour picture, `[rows, cols]` of red, green and blue: numbers as they are encoded.
pub fn red_channel(colours: &[[f32; 3]]) -> Vec<f32> {
    colours.iter().map(|colour| colour[0]).collect()
}

/// Share of pixels that have reached the end of the scale [1].
pub(crate) fn clipped_share(grey: &[f32], full_scale: f32) -> f32 {
    grey.iter().filter(|&&value| value >= END * full_scale).count() as f32 / grey.len() as f32
}

/// Light of every pixel, over the light at the end of the scale [1], of a picture that passes the checks.
pub(crate) fn light(
    grey: &[f32],
    [rows, cols]: [usize; 2],
    pixel_mm: [f32; 2],
    settings: &PictureAnalysis,
) -> Result<Vec<f32>, PictureFault> {
    if rows.checked_mul(cols) != Some(grey.len()) {
        return Err(PictureFault::Length { pixels: grey.len(), rows, cols });
    }
    let (short, long) = (pixel_mm[0].min(pixel_mm[1]), pixel_mm[0].max(pixel_mm[1]));
    if !(pixel_mm.iter().all(|&side| side > 0.0) && long <= MOST_PIXEL_ASPECT * short) {
        return Err(PictureFault::Pixel { pixel_mm });
    }
    let extent_mm = [rows as f32 * pixel_mm[0], cols as f32 * pixel_mm[1]];
    if extent_mm[0].min(extent_mm[1]) < LEAST_MM {
        return Err(PictureFault::TooSmall { extent_mm, least_mm: LEAST_MM });
    }
    if let Some(board_mm) = settings.board_mm
        && (0..2).any(|i| (extent_mm[i] / board_mm[i] - 1.0).abs() > ASPECT_TOLERANCE)
    {
        return Err(PictureFault::Aspect { extent_mm, board_mm });
    }
    if long > COARSEST_MM {
        return Err(PictureFault::Coarse { pixel_mm: long, most_mm: COARSEST_MM });
    }
    match settings.encoding {
        Encoding::Unknown => return Err(PictureFault::NotLinear),
        Encoding::Gamma(gamma) if !(0.3..=4.0).contains(&gamma) => return Err(PictureFault::Gamma { gamma }),
        _ => {}
    }
    if let Some(i) = grey.iter().position(|value| !(value.is_finite() && *value >= 0.0)) {
        return Err(PictureFault::Value { row: i / cols, col: i % cols, value: grey[i] });
    }
    let share = clipped_share(grey, settings.full_scale);
    if share > MOST_SATURATED {
        return Err(PictureFault::Saturated { share, full_scale: settings.full_scale });
    }
    let light: Vec<f32> = grey.iter().map(|value| settings.encoding.light(value / settings.full_scale)).collect();
    let [low, middle, high] = [0.05, 0.5, 0.95].map(|part| quantile_of(&light, part));
    let spread = (high - low) / middle.max(f32::MIN_POSITIVE);
    if spread < LEAST_SPREAD {
        return Err(PictureFault::Constant { spread });
    }
    Ok(light)
}
