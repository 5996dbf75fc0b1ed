//! What tools press into the flange: the sealing knurl, the embossed code, the perforation.
//!
//! Models: a diamond grid of pits with lines at +-45 degrees, digits of three by five dots that stand up from the foil,
//! and rows of cuts halfway between pockets. All have continuous slopes; their profiles are s(t) = (1 - t^2)^2.

use base::Stream;
use glam::Vec2;

use super::parameters::{Card, Web};

/// Size of a dot of the code [mm].
const DOT_MM: f32 = 0.55;
/// Dots of a digit and the gap behind it.
const ADVANCE: i32 = 4;
/// Digits of the code.
const DIGITS: u64 = 8;
/// Distance of the code's middle from the far edge [mm].
const CODE_MM: f32 = 3.2;
/// Half the width of a cut of the perforation [mm].
const CUT_MM: f32 = 0.12;
/// Share of the film's thickness that a cut takes [1].
const CUT: f32 = 0.7;
/// Digits 0 to 9 in dots of three by five, the upper left one first.
const FONT: [u16; 10] = [
    0b111_101_101_101_111,
    0b010_110_010_010_111,
    0b111_001_111_100_111,
    0b111_001_111_001_111,
    0b101_101_111_001_001,
    0b111_100_111_001_111,
    0b111_100_111_101_111,
    0b111_001_010_010_010,
    0b111_101_111_101_111,
    0b111_101_111_001_111,
];

/// The texture of a flange.
#[derive(Debug, Clone)]
pub struct Texture {
    knurl_mm: f32,
    knurl_pitch: f32,
    code_mm: f32,
    digits: Vec<u16>,
    /// Middle of the code across the card [mm].
    code_v: f32,
    perforation: f32,
    cut_mm: f32,
}

/// s(t) = (1 - t^2)^2 within [-1, 1], and its slope.
#[inline]
pub fn hump(t: f32) -> (f32, f32) {
    let left = (1.0 - t * t).max(0.0);
    (left * left, -4.0 * t * left)
}

/// Height of printed digits at a place in dots from the lower left corner of the first one, 0 to 1 [1].
pub fn digits(digits: &[u16], dots: Vec2) -> f32 {
    let (i, j) = (dots.x as i32, dots.y as i32);
    // Dots are bumps of a little more than their cell, so that neighbours run together.
    let mut height = 0.0_f32;
    for (column, row) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (0, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
        let (column, row) = (i + column, j + row);
        let (digit, own) = (column.div_euclid(ADVANCE), column.rem_euclid(ADVANCE));
        let bits = usize::try_from(digit).ok().and_then(|d| digits.get(d)).copied().unwrap_or(0);
        if own < 3 && (0..5).contains(&row) && bits >> (3 * row + 2 - own) & 1 == 1 {
            let d = dots - Vec2::new(column as f32 + 0.5, row as f32 + 0.5);
            height += hump((d.length_squared() / 1.2).sqrt()).0;
        }
    }
    height.min(1.0)
}

/// The dots of digit `d`.
pub fn digit(d: u64) -> u16 {
    FONT[(d % 10) as usize]
}

impl Texture {
    /// The texture of a card; `half_length` is half of it along the scan [mm].
    pub fn new(stream: Stream, card: &Card, web: &Web, half_length: f32) -> Self {
        let stream = stream.child("code");
        Self {
            knurl_mm: 1.0e-3 * card.knurl_um as f32,
            knurl_pitch: card.knurl_pitch_mm as f32,
            code_mm: card.code_mm as f32,
            digits: (0..DIGITS).map(|i| digit(stream.index(i).key() >> 32)).collect(),
            code_v: half_length - CODE_MM,
            perforation: card.perforation_mm as f32,
            cut_mm: CUT * web.thickness_mm as f32,
        }
    }

    /// Highest that it stands over the flange [mm].
    pub fn highest(&self) -> f32 {
        self.code_mm
    }

    /// Height of film and foil alike [mm] and its slope [1].
    #[inline]
    pub fn relief(&self, p: Vec2) -> (f32, Vec2) {
        let scale = std::f32::consts::FRAC_1_SQRT_2 / self.knurl_pitch;
        let wave = |t: f32| hump(2.0 * (t - floor(t)) - 1.0);
        let ((a, da), (b, db)) = (wave((p.x + p.y) * scale), wave((p.x - p.y) * scale));
        let deep = -self.knurl_mm;
        let steep = 2.0 * scale * deep;
        let (da, db) = (steep * da * b, steep * db * a);
        let (height, slope) = (deep * a * b, Vec2::new(da + db, da - db));
        if self.code_mm == 0.0 || (p.y - self.code_v).abs() > 3.5 * DOT_MM {
            return (height, slope);
        }
        const H: f32 = 0.02;
        let corner = Vec2::new(-0.5 * DOT_MM * (ADVANCE * DIGITS as i32 - 1) as f32, self.code_v - 2.5 * DOT_MM);
        // One cell is added so that truncation rounds down beside the first digit.
        let at = |p: Vec2| self.code_mm * self.code((p - corner) / DOT_MM);
        let rise = Vec2::new(at(p + H * Vec2::X) - at(p - H * Vec2::X), at(p + H * Vec2::Y) - at(p - H * Vec2::Y));
        (height + at(p), slope + rise / (2.0 * H))
    }

    fn code(&self, dots: Vec2) -> f32 {
        if dots.min_element() < -1.0 { 0.0 } else { digits(&self.digits, dots) }
    }

    /// Depth of the perforation's cuts [mm] and its slope [1], at `q` from the middle of a cell of half size `half`;
    /// `open` says on which sides of it (low x, high x, low y, high y) another cell lies.
    #[inline]
    pub fn cuts(&self, q: Vec2, half: Vec2, open: [bool; 4]) -> (f32, Vec2) {
        if self.perforation == 0.0 {
            return (0.0, Vec2::ZERO);
        }
        let cut = |across: f32, half: f32, along: f32, low: bool, high: bool| {
            let edge = if across < 0.0 { -half } else { half };
            if !(if across < 0.0 { low } else { high }) || (across - edge).abs() >= CUT_MM {
                return (0.0, 0.0, 0.0);
            }
            let (deep, steep) = hump((across - edge) / CUT_MM);
            let t = along / self.perforation;
            let (long, rise) = hump((t - floor(t) - 0.5) / 0.35);
            let rise = rise / (0.35 * self.perforation);
            (self.cut_mm * deep * long, self.cut_mm * steep / CUT_MM * long, self.cut_mm * deep * rise)
        };
        let a = cut(q.x, half.x, q.y, open[0], open[1]);
        let b = cut(q.y, half.y, q.x, open[2], open[3]);
        if a.0 >= b.0 { (a.0, Vec2::new(a.1, a.2)) } else { (b.0, Vec2::new(b.2, b.1)) }
    }
}

/// The whole number below, without the call that the plainest x86-64 makes of it.
#[inline]
fn floor(t: f32) -> f32 {
    let truncated = t as i32 as f32;
    if t < truncated { truncated - 1.0 } else { truncated }
}
