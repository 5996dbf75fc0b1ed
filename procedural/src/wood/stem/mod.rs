//! A whole stem: its pith, its outline and its branches, from which boards are sawn.
//!
//! `Stem::grow` or `Stem::measured` --> Stem --`Plank::saw`--> Plank.
//!
//! Models: a stem in cylinder coordinates about its pith: the distance r from the pith across the stem, the azimuth,
//! which grows from x to y, and the height h along it. The pith is a line (`pith_line`), the outline a radius at every
//! azimuth and height (`outline`). Every branch is nine numbers A to I in the form of the scanned log (`branch`): its
//! width, its axis, the distances from the pith where it died and where it ends. A grown stem has a whorl at the end of
//! every year's shoot and branches between whorls (`shoots`); a measured one has what a scanner saw (`measured`). A
//! board takes the branches that come near it (`sawing`). Sources: form of branches and all statistics from the scanned
//! log "Gran_1" of Larsson et al. (2022). Limits: one log, not a stand: no crown, no age and no butt swell; branches do
//! not bend the pith; whorls do not swell the outline. Growth layers stand about the pith and what of its wander is
//! left farther out (`layers`), and follow the outline only where they are asked to (`oval`); the log's numbers are
//! those of one Norway spruce.

mod branch;
mod cut;
mod layers;
mod measured;
mod outline;
mod oval;
mod pattern;
mod pith_line;
mod sawing;
mod shoots;
#[cfg(test)]
mod tests;

use base::Stream;

use self::branch::BranchSite;
pub use self::branch::StemBranch;
pub(super) use self::cut::StemCut;
pub(super) use self::layers::Layers;
pub use self::measured::StemError;
use self::outline::{GrownOutline, StemOutline};
pub use self::pattern::{LogRoom, least_pieces, sawn_at};
use self::pith_line::PithLine;
pub(super) use self::sawing::Sawing;
use super::parameters::StemParameters;

/// A whole log.
#[derive(Debug, Clone, PartialEq)]
pub struct Stem {
    pith: PithLine,
    outline: StemOutline,
    branches: Vec<StemBranch>,
    /// Lowest and highest end [mm].
    ends: [f64; 2],
}

impl Stem {
    /// Grows a stem; every part and every branch draws from its own child of `stream`.
    pub fn grow(stream: Stream, numbers: &StemParameters) -> Self {
        let pith = PithLine::grow(stream.child("pith"), numbers);
        let outline = StemOutline::Grown(Box::new(GrownOutline::grow(stream.child("outline"), numbers)));
        let mut stem = Self { pith, outline, branches: Vec::new(), ends: [0.0, numbers.length_mm] };
        let site = BranchSite::new(stream.child("side"));
        let buds = shoots::buds(stream.child("shoot"), numbers);
        stem.branches = buds.iter().map(|bud| site.branch(bud, numbers, &stem)).collect();
        stem
    }

    /// The stem that a scanner measured, in the file format of the scanned log. `pith` has rows of x, y and height
    /// [mm]. `radii` has sections from the first to the last height of the pith in equal steps, each with the distances
    /// from the pith to the outline [mm] at azimuths that fall from 0 in equal steps of a turn. `knots` has rows of A
    /// to I: width r (A + B r^(1/4)), height C + D sqrt r + E r, azimuth F + G ln r, end H and death I, all in mm and
    /// rad.
    pub fn measured(pith: &[[f64; 3]], radii: &[Vec<f64>], knots: &[[f64; 9]]) -> Result<Self, StemError> {
        measured::check(pith, radii, knots)?;
        let ends = [pith[0][2], pith[pith.len() - 1][2]];
        let outline = StemOutline::measured(ends, radii);
        let branches = knots.iter().map(|row| StemBranch::measured(row, &outline)).collect();
        Ok(Self { pith: PithLine::through(pith), outline, branches, ends })
    }

    /// Heights of its two ends [mm].
    pub fn ends_mm(&self) -> [f64; 2] {
        self.ends
    }

    /// The pith at a height: x and y [mm].
    pub fn pith_mm(&self, height: f64) -> [f64; 2] {
        self.pith.at(height).0
    }

    /// Distance from the pith to the outline at an azimuth [rad] and a height [mm], in mm.
    pub fn radius_mm(&self, azimuth: f64, height: f64) -> f64 {
        self.outline.radius(azimuth, height, self.pith.at(height).0)
    }

    /// Mean distance from the pith to the outline halfway between its ends [mm].
    pub fn mean_radius_mm(&self) -> f64 {
        const AZIMUTHS: usize = 32;
        let height = 0.5 * (self.ends[0] + self.ends[1]);
        let radius = |i: usize| self.radius_mm(std::f64::consts::TAU * i as f64 / AZIMUTHS as f64, height);
        (0..AZIMUTHS).map(radius).sum::<f64>() / AZIMUTHS as f64
    }

    /// Its branches, upwards along the stem if it was grown, in the order of the rows if it was measured.
    pub fn branches(&self) -> &[StemBranch] {
        &self.branches
    }
}
