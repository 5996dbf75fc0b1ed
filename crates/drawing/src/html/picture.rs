//! Pictures within a page: maps with a palette as PNG, and the scale of their colours.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};
use png::{BitDepth, ColorType, Compression, Encoder, EncodingError};

use super::format::number;
use crate::{inferno, round_ticks, viridis};

/// Levels of a map; level 0 stands for a missing value.
pub const MAP_LEVELS: u8 = 128;

/// How numbers become colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColourMap {
    /// From violet over green to yellow.
    Viridis,
    /// From black to white.
    Grey,
    /// From black over red to pale yellow.
    Inferno,
}

impl ColourMap {
    /// The colour of a number in [0, 1].
    pub fn at(self, t: f32) -> [u8; 3] {
        match self {
            Self::Viridis => viridis(t).0,
            Self::Grey => [(255.0 * t.clamp(0.0, 1.0)) as u8; 3],
            Self::Inferno => inferno(t).0,
        }
    }
}

/// Colours of a map's levels: that of missing values, then those from the lowest number to the highest.
pub fn map_palette(missing: [u8; 3], ramp: ColourMap) -> Vec<u8> {
    let most = f32::from(MAP_LEVELS - 2);
    let mut palette = missing.to_vec();
    (1..MAP_LEVELS).for_each(|level| palette.extend(ramp.at(f32::from(level - 1) / most)));
    palette
}

/// Levels `[rows, width]` as PNG with a palette of red, green and blue, and the opacity of each level, if any is not
/// opaque.
///
/// # Errors
/// Where the palette is no palette, or the levels are no whole rows.
pub fn indexed_png(levels: &[u8], width: u32, palette: Vec<u8>, opacity: Vec<u8>) -> Result<Vec<u8>, EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, levels.len() as u32 / width.max(1));
    encoder.set_color(ColorType::Indexed);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::High);
    encoder.set_palette(palette);
    if !opacity.is_empty() {
        encoder.set_trns(opacity);
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(levels)?;
    writer.finish()?;
    Ok(bytes)
}

/// Bytes of a PNG as a data URL.
pub fn data_url(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

/// A bar of colours with round numbers below it.
pub fn colour_scale(ramp: ColourMap, low: f64, high: f64, unit: &str) -> Markup {
    let place = |value: f64| 4.0 + (value - low) / (high - low) * 252.0;
    html! {
        svg.scale viewBox="0 0 260 34" role="img"
            aria-label={ "Colours from " (number(low)) " to " (number(high)) " " (unit) } {
            @for i in 0..84_u8 {
                rect x=(4 + 3 * u32::from(i)) y="0" width="3.5" height="12" fill=(hex(ramp.at(f32::from(i) / 83.0))) {}
            }
            @for tick in round_ticks(low, high) {
                line.axis x1=(format!("{:.1}", place(tick))) x2=(format!("{:.1}", place(tick))) y1="12" y2="17" {}
                text x=(format!("{:.1}", place(tick).clamp(12.0, 246.0))) y="29" text-anchor="middle" { (number(tick)) }
            }
        }
    }
}

/// A colour as a style sheet writes it.
pub fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}
