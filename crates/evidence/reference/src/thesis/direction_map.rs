//! Direction map: colours that say along which line light spreads, and how much of it is absorbed.
//!
//! Kihl and Källberg 2021, section 3.2.3 and Figure 3.9: between red and green the slope is R / G, ascending; between
//! blue and green it is -B / G, descending; alpha is what is left of the light, 1 in clear wood and 0.5 in knots. Green
//! is along x, red and blue both stand for the vertical, where the slope has no number: as a vector, (G, R - B), it has
//! one, and the formula is the thesis' own wherever R or B is 0. Where both are, it joins the two without a jump.
//! Black, and R = B without G, have no direction. Neglected: fibres that dive. A map has no colour for them.

use glam::DVec2;

/// A map of directions: RGBA of 8 bits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DirectionMap {
    rows: usize,
    cols: usize,
    /// `[rows, cols]`, row-major, row 0 at the smallest y.
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
