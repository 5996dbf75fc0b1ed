//! One branch of a stem, as nine numbers.
//!
//! Models: at the distance r from the pith a branch is r (A + B r^(1/4)) wide, its axis lies at the height
//! C + D sqrt r + E r and at the azimuth F + G ln r, it ends at H and died at I. From its death on, and from where the
//! law has its maximum, r = (-4 A / 5 B)^4, the width stays (Trincado and Burkhart 2008). In the scanned log that
//! maximum lies at I wherever a branch died, so a dead branch has B = -4/5 A / I^(1/4).
//! A grown branch draws the distance where it dies, lognormal; what dies beyond the outline is alive. Its width at
//! min(I, 100 mm) is lognormal and goes with (min(I, 100 mm) / 100 mm)^0.9. A living one is as straight as -B s^(1/4) /
//! A = 4/5 u^0.35 at the outline s, with u even. A dead one's stub stays for some widths; where it then ends inside,
//! the stem grows over it. Source: the 108 knots of the scanned log of Larsson et al. (2022), of which 95 reach the
//! outline, 59 of them dead, and 13 end inside. For dead ones ln width goes with 0.90 ln I, spread 0.48; slopes have a
//! mean of -12.2 deg and a spread of 8.0 deg at 100 mm, D a mean of 0.13 and a spread of 0.08 mm^(1/2), G a spread of
//! 0.056 rad. Widths on one side exceed the mean by a factor of e^0.2 and lag behind it on the other.
//! Limits: branches of a whorl do not compete; slope and width are independent (-0.24 in the scanned log).

use std::f64::consts::TAU;

use base::{Stream, normal};
use rand::RngExt;

use super::super::parameters::StemParameters;
use super::Stem;
use super::outline::StemOutline;
use super::shoots::Bud;

/// Largest D, drawn evenly from 0 on [mm^(1/2)].
const BEND: f64 = 0.27;
/// Spread of G [rad].
const TURN_SD: f64 = 0.056;
/// Distance from the pith where azimuths of buds hold [mm]: halfway out in the scanned log.
const AZIMUTH_MM: f64 = 50.0;
/// Distance from the pith where width and slope are asked for [mm].
const ASKED_MM: f64 = 100.0;
/// Power of the width over the distance of the death.
const WIDTH_POWER: f64 = 0.9;
/// Power of the even draw behind a living branch's straightness.
const STRAIGHTNESS_POWER: f64 = 0.35;
/// -B r^(1/4) / A where the law has its maximum [1].
const FULL: f64 = 0.8;
/// Spread of the logarithm of a stub's length.
const STUB_LOG_SD: f64 = 0.3;
/// Nearest death to the pith [mm]: a branch of some years.
const LEAST_DEATH_MM: f64 = 5.0;
/// Widest opening of a branch, its width over the distance from the pith [1]: beyond that of the scanned log, 0.77.
const WIDEST_OPENING: f64 = 0.9;
/// Steepest slope [rad].
const STEEPEST: f64 = 1.2;
/// A measured end this far out counts as the outline [its radius]: the ends of the scanned log that belong to the
/// outline scatter about it by 3 percent, and no other lies beyond 0.87.
const AT_OUTLINE: f64 = 0.9;

/// A branch of a stem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StemBranch {
    /// A [rad] and B [mm^(-1/4)].
    pub width: [f64; 2],
    /// C [mm], D [mm^(1/2)] and E [1].
    pub height: [f64; 3],
    /// F and G [rad].
    pub azimuth: [f64; 2],
    /// Distance from the pith where it ends inside the stem; infinite where it reaches the outline [mm].
    pub end_mm: f64,
    /// Distance from the pith where it died; infinite for a living one [mm].
    pub death_mm: f64,
}

impl StemBranch {
    /// The branch of a row A to I.
    pub(super) fn measured(row: &[f64; 9], outline: &StemOutline) -> Self {
        let &[a, b, c, d, e, f, g, end, death] = row;
        let open = Self { width: [a, b], height: [c, d, e], azimuth: [f, g], end_mm: end, death_mm: f64::INFINITY };
        // Measured radii are distances from the pith, wherever that lies.
        let at_outline = outline.radius(open.azimuth_at(end), open.height_at(end), [0.0; 2]) * AT_OUTLINE;
        let reaches = end >= at_outline;
        let death_mm = match (reaches, death < end) {
            (_, true) => death,
            // A stub that lived to its end died there.
            (false, false) => end,
            (true, false) => f64::INFINITY,
        };
        Self { end_mm: if reaches { f64::INFINITY } else { end }, death_mm, ..open }
    }

    /// Distance from the pith from where on it is no wider; infinite if it widens on [mm].
    pub fn widest_mm(&self) -> f64 {
        let [a, b] = self.width;
        if b < 0.0 { libm::pow(-FULL * a / b, 4.0).min(self.death_mm) } else { self.death_mm }
    }

    /// Width across its axis at a distance from the pith, without the rounding of an end [mm].
    pub fn width_mm(&self, r: f64) -> f64 {
        let r = r.min(self.widest_mm());
        r * (self.width[0] + self.width[1] * r.sqrt().sqrt())
    }

    /// Height of its axis at a distance from the pith [mm].
    pub fn height_at(&self, r: f64) -> f64 {
        self.height[0] + self.height[1] * r.sqrt() + self.height[2] * r
    }

    /// Rise of its axis along the stem over the distance from the pith [1].
    pub fn slope(&self, r: f64) -> f64 {
        self.height[2] + 0.5 * self.height[1] / r.sqrt()
    }

    /// Azimuth of its axis at a distance from the pith [rad].
    pub fn azimuth_at(&self, r: f64) -> f64 {
        self.azimuth[0] + self.azimuth[1] * libm::log(r)
    }
}

/// What all branches of a grown stem share.
#[derive(Debug, Clone, Copy)]
pub(super) struct BranchSite {
    /// Azimuth of the side with most light [rad].
    light: f64,
}

impl BranchSite {
    /// The site of a stem.
    pub fn new(stream: Stream) -> Self {
        Self { light: TAU * stream.rng().random::<f64>() }
    }

    /// The branch of a bud of `stem`, whose pith and outline are known.
    pub fn branch(&self, bud: &Bud, numbers: &StemParameters, stem: &Stem) -> StemBranch {
        let mut rng = bud.stream.child("branch").rng();
        let mut next = || normal(&mut rng);
        let (width, death, slope, turn, stub) = (next(), next(), next(), next(), next());
        let (bend, straightness): (f64, f64) = (rng.random(), rng.random());
        let slope = libm::tan(
            (numbers.branch_slope_deg + numbers.branch_slope_sd_deg * slope).to_radians().clamp(-STEEPEST, STEEPEST),
        );
        let bend = BEND * bend;
        let turn = TURN_SD * turn;
        let mut branch = StemBranch {
            width: [0.0; 2],
            height: [bud.height, bend, slope - 0.5 * bend / ASKED_MM.sqrt()],
            azimuth: [bud.azimuth - turn * libm::log(AZIMUTH_MM), turn],
            end_mm: f64::INFINITY,
            death_mm: f64::INFINITY,
        };
        // The outline is nearly round and the axis nearly radial: a few steps find where they meet.
        let mut surface = numbers.radius_mm;
        for _ in 0..4 {
            surface = stem.radius_mm(branch.azimuth_at(surface), branch.height_at(surface));
        }
        let dies = numbers.death_share * numbers.radius_mm * libm::exp(numbers.death_log_sd * death);
        let dies = dies.max(LEAST_DEATH_MM);
        let noted = dies.min(ASKED_MM);
        let kind = if bud.between { numbers.between_width } else { 1.0 };
        let side = numbers.branch_side * libm::cos(bud.azimuth - self.light);
        let width = numbers.branch_width_mm
            * kind
            * libm::exp(numbers.branch_width_log_sd * width + side)
            * libm::pow(noted / ASKED_MM, WIDTH_POWER);
        // Where the law has its maximum, which must not lie before the width is noted.
        let widest = if dies < surface {
            dies
        } else {
            (surface / libm::pow(straightness, 4.0 * STRAIGHTNESS_POWER)).max(noted)
        };
        let opening = width / (noted * (1.0 - FULL * libm::pow(noted / widest, 0.25)));
        let opening = opening.min(WIDEST_OPENING);
        branch.width = [opening, -FULL * opening / widest.sqrt().sqrt()];
        if dies < surface {
            branch.death_mm = dies;
            let end = dies + numbers.stub_length * branch.width_mm(dies) * libm::exp(STUB_LOG_SD * stub);
            if end < surface {
                branch.end_mm = end;
            }
        }
        branch
    }
}
