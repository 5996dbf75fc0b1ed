//! Direction map: colours that say along which line light spreads, and how much of it is absorbed.
//!
//! Kihl and Källberg 2021, section 3.2.3 and Figure 3.9: between red and green the slope is R / G, ascending; between
//! blue and green it is -B / G, descending; alpha is what is left of the light, 1 in clear wood and 0.5 in knots. Green
//! is along x, red and blue both stand for the vertical, where the slope has no number: as a vector, (G, R - B), it has
//! one, and the formula is the thesis' own wherever R or B is 0. Where both are, it joins the two without a jump. Black,
//! and R = B without G, have no direction.
//! Neglected: fibres that dive. A map has no colour for them.

use std::io::BufReader;
use std::path::{Path, PathBuf};

use glam::DVec2;
use image::{DynamicImage, ImageError, ImageFormat, ImageReader, RgbaImage};

/// Why a map cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    /// The file cannot be read as a PNG.
    #[error("cannot read the direction map {}: {source}; give the path of a PNG image with red, green, blue and alpha of 8 bits", path.display())]
    Read {
        /// Where.
        path: PathBuf,
        /// Why.
        source: ImageError,
    },
    /// The image has other channels.
    #[error("cannot use {} as a direction map: it is {found}; save it as PNG with red, green, blue and alpha of 8 bits", path.display())]
    Channels {
        /// Where.
        path: PathBuf,
        /// What it has instead.
        found: String,
    },
    /// The file cannot be written.
    #[error("cannot write the direction map {}: {source}; check that the folder exists, is writable and has room", path.display())]
    Write {
        /// Where.
        path: PathBuf,
        /// Why.
        source: ImageError,
    },
}

/// A map of directions: RGBA of 8 bits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DirectionMap {
    rows: usize,
    cols: usize,
    /// `[rows, cols]`, row-major, row 0 at the smallest y: the image's lowest.
    pixels: Vec<[u8; 4]>,
}

impl DirectionMap {
    /// A map from colours, `[rows, cols]`, row-major, row 0 at the smallest y.
    ///
    /// # Panics
    /// Where there are not rows times cols pixels.
    pub fn new(rows: usize, cols: usize, pixels: Vec<[u8; 4]>) -> Self {
        assert_eq!(pixels.len(), rows * cols, "a map has rows times cols pixels");
        Self { rows, cols, pixels }
    }

    /// A map of one colour.
    pub fn even(rows: usize, cols: usize, colour: [u8; 4]) -> Self {
        Self::new(rows, cols, vec![colour; rows * cols])
    }

    /// Colour of a direction in the surface, `None` for no direction, and of what is left of the light, in [0, 1].
    ///
    /// Directions come back within 0.12 degrees; which end of a line is given has no meaning.
    pub fn colour(direction: Option<DVec2>, alpha: f64) -> [u8; 4] {
        let byte = |v: f64| (255.0 * v.clamp(0.0, 1.0)).round() as u8;
        let along = direction.unwrap_or_default();
        let along = if along.x < 0.0 { -along } else { along };
        let largest = along.x.max(along.y.abs()).max(f64::MIN_POSITIVE);
        [byte(along.y / largest), byte(along.x / largest), byte(-along.y / largest), byte(alpha)]
    }

    /// Reads a PNG with red, green and blue of 8 bits; without alpha it is 1.
    ///
    /// # Errors
    /// Where the file cannot be read, is no PNG or has other channels.
    pub fn load(path: &Path) -> Result<Self, MapError> {
        let read = |source: ImageError| MapError::Read { path: path.to_path_buf(), source };
        let file = BufReader::new(files::open(path).map_err(|e| read(e.into()))?);
        let image = match ImageReader::with_format(file, ImageFormat::Png).decode().map_err(read)? {
            image @ (DynamicImage::ImageRgb8(_) | DynamicImage::ImageRgba8(_)) => image.into_rgba8(),
            other => {
                let found = format!("{:?}", other.color());
                return Err(MapError::Channels { path: path.to_path_buf(), found });
            }
        };
        let (rows, cols) = (image.height() as usize, image.width() as usize);
        Ok(Self::new(rows, cols, image.rows().rev().flatten().map(|pixel| pixel.0).collect()))
    }

    /// Writes the map as PNG, largest y on top.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), MapError> {
        let image = RgbaImage::from_fn(self.cols as u32, self.rows as u32, |x, y| {
            image::Rgba(self.pixels[(self.rows - 1 - y as usize) * self.cols + x as usize])
        });
        let write = |source| MapError::Write { path: path.to_path_buf(), source };
        image.save_with_format(path, ImageFormat::Png).map_err(write)
    }

    /// Rows, along y.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns, along x.
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Unit vector along which light of pixel `i` spreads, x to the right and y upwards; `None` without a direction.
    #[inline]
    pub fn direction(&self, i: usize) -> Option<DVec2> {
        let [red, green, blue, _] = self.pixels[i].map(f64::from);
        DVec2::new(green, red - blue).try_normalize()
    }

    /// Share of the light that pixel `i` does not absorb, in [0, 1].
    #[inline]
    pub fn alpha(&self, i: usize) -> f64 {
        f64::from(self.pixels[i][3]) / 255.0
    }
}
