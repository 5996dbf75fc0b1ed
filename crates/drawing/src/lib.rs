//! What is shown to people: raster pictures with text, lines, colour scales and charts, and pages of HTML.

pub mod chart;
pub mod html;
mod ticks;

pub use ticks::round_ticks;

use base::Class;
use embedded_graphics::mono_font::{
    MonoTextStyle,
    ascii::{FONT_7X13, FONT_10X20},
};
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::{Line, PrimitiveStyle, Rectangle};
use embedded_graphics::text::Text;
use image::{Rgb, RgbImage};

/// Space around panels [px].
pub const MARGIN: u32 = 14;
/// Width of a letter [px].
pub const LETTER: u32 = 7;
/// Colour of paper.
pub(crate) const PAPER: Rgb<u8> = Rgb([250, 250, 248]);
/// Colour of text.
pub const INK: Rgb<u8> = Rgb([30, 30, 30]);

/// Colour map: the colour of a number in [0, 1].
pub type Ramp<'a> = &'a dyn Fn(f32) -> Rgb<u8>;

/// Viridis (van der Walt and Smith 2015) through nine of its colours.
pub fn viridis(t: f32) -> Rgb<u8> {
    const STOPS: [[f32; 3]; 9] = [
        [68.0, 1.0, 84.0],
        [71.0, 44.0, 122.0],
        [59.0, 81.0, 139.0],
        [44.0, 113.0, 142.0],
        [33.0, 144.0, 141.0],
        [39.0, 173.0, 129.0],
        [92.0, 200.0, 99.0],
        [170.0, 220.0, 50.0],
        [253.0, 231.0, 37.0],
    ];
    interpolate(&STOPS, t)
}

/// Inferno (van der Walt and Smith 2015) through nine of its colours.
pub fn inferno(t: f32) -> Rgb<u8> {
    const STOPS: [[f32; 3]; 9] = [
        [0.0, 0.0, 4.0],
        [31.0, 12.0, 72.0],
        [85.0, 15.0, 109.0],
        [136.0, 34.0, 106.0],
        [186.0, 54.0, 85.0],
        [227.0, 89.0, 51.0],
        [249.0, 140.0, 10.0],
        [249.0, 201.0, 50.0],
        [252.0, 255.0, 164.0],
    ];
    interpolate(&STOPS, t)
}

/// The colour at `t` of [0, 1] between nine evenly spaced ones.
fn interpolate(stops: &[[f32; 3]; 9], t: f32) -> Rgb<u8> {
    let place = t.clamp(0.0, 1.0) * 8.0;
    let i = (place as usize).min(7);
    Rgb(std::array::from_fn(|c| (stops[i][c] + (stops[i + 1][c] - stops[i][c]) * (place - i as f32)) as u8))
}

/// Colour of a pixel class; of a value that is none, that of the background.
pub fn class_colour(class: u8) -> Rgb<u8> {
    Rgb(Class::of(class).unwrap_or(Class::Background).colour())
}

/// A rectangle of a page [px].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Area {
    /// Column of its left edge [px].
    pub left: u32,
    /// Row of its top edge [px].
    pub top: u32,
    /// Columns [px].
    pub width: u32,
    /// Rows [px].
    pub height: u32,
}

/// The numbers at the ends of a colour scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScaleEnds<'a> {
    /// Number of the first colour.
    pub low: f32,
    /// Number of the last colour.
    pub high: f32,
    /// Unit of both.
    pub unit: &'a str,
}

/// A picture to draw on; everything outside of it is clipped.
pub struct Page(pub RgbImage);

impl Page {
    /// A page of paper.
    pub fn new(width: u32, height: u32) -> Self {
        Self(RgbImage::from_pixel(width, height, PAPER))
    }

    /// Text whose base line begins at (x, y).
    pub fn words(&mut self, x: u32, y: u32, text: &str) {
        self.words_in(x, y, text, INK);
    }

    /// Text in a colour.
    pub fn words_in(&mut self, x: u32, y: u32, text: &str, colour: Rgb<u8>) {
        self.text(x, y, text, MonoTextStyle::new(&FONT_7X13, ink(colour)));
    }

    /// Large text.
    pub fn title(&mut self, x: u32, y: u32, text: &str) {
        self.text(x, y, text, MonoTextStyle::new(&FONT_10X20, ink(INK)));
    }

    fn text(&mut self, x: u32, y: u32, text: &str, style: MonoTextStyle<Rgb888>) {
        // Drawing on a page that is in memory cannot fail.
        let Ok(_) = Text::new(text, Point::new(x as i32, y as i32), style).draw(self);
    }

    /// A straight line, `width` [px] wide.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), colour: Rgb<u8>, width: u32) {
        let point = |(x, y): (f64, f64)| Point::new(x.round() as i32, y.round() as i32);
        let style = PrimitiveStyle::with_stroke(ink(colour), width);
        let Ok(_) = Line::new(point(from), point(to)).into_styled(style).draw(self);
    }

    /// A picture with its upper left corner at (x, y).
    pub fn picture(&mut self, x: u32, y: u32, picture: &RgbImage) {
        image::imageops::overlay(&mut self.0, picture, i64::from(x), i64::from(y));
    }

    /// A bar of colours with the numbers of its ends below.
    pub fn scale(&mut self, x: u32, y: u32, width: u32, ends: ScaleEnds, ramp: Ramp) {
        let ScaleEnds { low, high, unit } = ends;
        let digits = if high - low < 10.0 { 2 } else { 0 };
        self.bar(x, y, width, &format!("{low:.digits$}"), &format!("{high:.digits$} {unit}"), ramp);
    }

    /// A bar of colours with words below its ends.
    pub fn bar(&mut self, x: u32, y: u32, width: u32, low: &str, high: &str, ramp: Ramp) {
        let bar = RgbImage::from_fn(width, 10, |px, _| ramp(px as f32 / width as f32));
        self.picture(x, y, &bar);
        self.words(x, y + 24, low);
        self.words(x + width.saturating_sub(LETTER * high.len() as u32), y + 24, high);
    }
}

fn ink(colour: Rgb<u8>) -> Rgb888 {
    Rgb888::new(colour.0[0], colour.0[1], colour.0[2])
}

impl OriginDimensions for Page {
    fn size(&self) -> embedded_graphics::geometry::Size {
        embedded_graphics::geometry::Size::new(self.0.width(), self.0.height())
    }
}

impl DrawTarget for Page {
    type Color = Rgb888;
    type Error = std::convert::Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Self::Error> {
        let bounds = Rectangle::new(Point::zero(), OriginDimensions::size(self));
        for Pixel(point, colour) in pixels.into_iter().filter(|pixel| bounds.contains(pixel.0)) {
            self.0.put_pixel(point.x as u32, point.y as u32, Rgb([colour.r(), colour.g(), colour.b()]));
        }
        Ok(())
    }
}
