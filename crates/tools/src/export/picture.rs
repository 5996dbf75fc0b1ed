//! Training pictures: one map of a sample in 8 bits or as stored, or three of them as colours.

use std::io::Cursor;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::map_scale::{MapScales, physical_scale};
use super::sample::{ExportSample, Region};
use dataset::{Fault, Grey, write_png};

/// Pixels of a picture with 8 bits, channels together `[rows, cols, channels]`.
#[derive(Debug, Clone)]
pub(super) struct TrainingPicture {
    cols: usize,
    channels: usize,
    pixels: Vec<u8>,
}

impl TrainingPicture {
    /// The picture of a sample, scaled as the whole dataset is.
    pub(super) fn of(sample: &ExportSample, scalings: &MapScales) -> Result<Self, Fault> {
        let channels = scalings.channels().count();
        let mut pixels = vec![0; sample.cols * sample.rows * channels];
        for (channel, (map, scaling)) in scalings.channels().enumerate() {
            let [offset, scale] = physical_scale(sample, map)?;
            let numbers = sample.grey(map)?.numbers();
            for (pixel, n) in pixels.chunks_exact_mut(channels).zip(numbers) {
                pixel[channel] = if n == 0 { 0 } else { scaling.level(offset + scale * f64::from(n)) };
            }
        }
        Ok(Self { cols: sample.cols, channels, pixels })
    }

    /// A part of it.
    pub(super) fn cut(&self, region: Region) -> Self {
        let Region { top, left, rows, cols } = region;
        let line = |row: usize| {
            let from = (row * self.cols + left) * self.channels;
            &self.pixels[from..from + cols * self.channels]
        };
        let pixels = (top..top + rows).flat_map(line).copied().collect();
        Self { cols, channels: self.channels, pixels }
    }

    /// The same in three channels; those of a single map are alike.
    pub(super) fn colours(self) -> Self {
        let pixels = match self.channels {
            1 => self.pixels.iter().flat_map(|level| [*level; 3]).collect(),
            _ => self.pixels,
        };
        Self { cols: self.cols, channels: 3, pixels }
    }

    /// As PNG.
    pub(super) fn png(self) -> Vec<u8> {
        match self.channels {
            1 => write_png(&Grey::Eight(self.pixels), self.cols),
            _ => colour_png(&self.pixels, self.cols),
        }
    }
}

/// Colours `[rows, cols, 3]` as PNG, compressed as the dataset's own images are.
pub(super) fn colour_png(pixels: &[u8], cols: usize) -> Vec<u8> {
    let rows = pixels.len() / 3 / cols.max(1);
    let mut png = Vec::new();
    let encoder = PngEncoder::new_with_quality(Cursor::new(&mut png), CompressionType::Fast, FilterType::Adaptive);
    let written = encoder.write_image(pixels, cols as u32, rows as u32, ExtendedColorType::Rgb8);
    written.expect("memory takes every byte, and the size was computed from the pixels");
    png
}
