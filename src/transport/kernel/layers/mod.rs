//! The production model for a film over air and tablet, or over foil.

pub mod table;
mod waves;

use procedural::{Film, Medium};

use super::widths::{BASIS, Shares};

/// A film over something, as light from straight above meets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cover {
    /// The film's own matter.
    pub medium: Medium,
    /// Its thickness and what lies below.
    pub film: Film,
    /// Share of light that enters the film [1].
    pub enter: f32,
    /// Cosine of the view against the film's normal [1].
    pub view_up: f32,
    /// Cosine of the view against the normal of what lies below [1].
    pub view_up_under: f32,
}

/// What a film does to a line of light: two patterns on the fixed widths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoverSpread {
    /// Square root of each width's weight, of light that leaves from the film [1].
    pub enter: [f32; BASIS],
    /// The same times the film's radiance factor [1].
    pub exit: [f32; BASIS],
    /// Weight of each width times radiance factor, of light that what lies below sends to the lens and that passes the
    /// film without being turned: it is seen where it left the surface below [1].
    pub through: [f32; BASIS],
}

/// The answer for one texel.
pub fn cover_spread(cover: &Cover, _shares: &Shares) -> CoverSpread {
    let w = cover.enter * 0.5 / BASIS as f32;
    CoverSpread { enter: [w.sqrt(); BASIS], exit: [w.sqrt(); BASIS], through: [0.0; BASIS] }
}
