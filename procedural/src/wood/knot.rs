//! One knot: the branch that the trunk grew around.
//!
//! Models: a branch whose skeleton runs outwards from the pith, at the distance r from it at
//!
//! ```text
//! l(r) = C + D sqrt r + E r  along the log and  phi(r) = F + G ln r  about it
//! ```
//!
//! and whose width grows as r (A + B r^(1/4)) while it lives. A dead branch keeps its width; bark takes the outer part
//! of it. A point belongs to the skeleton point at its own distance from the pith (Larsson et al. 2022). A branch of a
//! stem (`stem`) may end inside: over the last half width its outline rounds off to nothing as an ellipsoid, and what
//! it does to the growth layers fades from there to four half widths beyond the end, in a smooth step. Sources: form of
//! the skeleton and spread of its numbers from the 108 knots of the scanned log of Larsson et al. (2022); dead branches
//! are cylinders (Trincado and Burkhart 2008). The rounding and the healing of an end are engineering estimates.
//! Limits: knots that are placed on a face never end before it; no swelling at the base; no pocket of bark or resin at
//! an end, over which the slope of the growth layers has a faint kink at 0.8 half widths from the axis, elsewhere
//! hidden in the branch.

use base::{Class, Stream, normal};
use glam::Vec2;
use rand::RngExt;

use super::knot_inside::KnotInside;
use super::parameters::Knots;
use super::stem::StemBranch;

/// Mean and spread of A over the scanned knots [rad].
const OPENING: [f64; 2] = [0.29, 0.17];
/// A stays within these, the 5th and 95th percentiles [rad].
const OPENING_RANGE: [f64; 2] = [0.06, 0.6];
/// B as a line of A, and the spread about it [1, mm^(-1/4), mm^(-1/4)].
const TAPER: [f64; 3] = [-0.285, 0.0079, 0.009];
/// Largest B r^(1/4) / A at the surface: just below 4/5, where the width would begin to shrink [1].
const TAPER_LIMIT: f64 = 0.78;
/// Largest D of the scanned knots [mm^(1/2)].
const BEND: f64 = 0.21;
/// Spread of G [rad].
const TURN_SD: f64 = 0.055;
/// Root mean square of the outline's wobble over the radius [1].
const WOBBLE: f64 = 0.035;
/// Harmonics of the wobble: from the oval to the pentagon and on; the first would only shift the knot.
const HARMONICS: usize = 5;
/// Largest wobble [1].
const WOBBLE_LIMIT: f32 = 0.12;
/// Part of the radius that bark may take at most [1].
const BARK_LIMIT: f32 = 0.6;

/// Growth layers are healed this far beyond a branch's end [half widths].
const HEALING: f32 = 4.0;
/// An end rounds off within this part of its distance from the pith at most [1].
const CAP_LIMIT: f32 = 0.5;
/// Narrowest part of a rounded end over its width [1].
const TIP_LEAST: f32 = 1.0e-3;
/// Largest distance from the pith where the width of a stem's branch is noted [mm].
const NOTED_MM: f64 = 100.0;

/// What is drawn for a knot wherever it stands.
#[derive(Debug, Clone, Copy)]
pub(super) struct KnotDraw {
    /// Standard normal behind the width.
    pub width: f64,
    /// Standard normal behind the slope.
    pub slope: f64,
    opening: f64,
    taper: f64,
    bend: f64,
    /// G: turn of the axis about the log over a logarithm of the distance from the pith [rad].
    pub turn: f32,
    bulge: KnotBulge,
    outline: [Vec2; HARMONICS],
    inside: KnotInside,
}

/// How a knot's bulge of growth layers leaves the usual one.
#[derive(Debug, Clone, Copy)]
pub(super) struct KnotBulge {
    /// Height over the usual one [1].
    pub height: f32,
    /// Slope along the log that layers have at the axis besides; two half widths up and down -0.4 of it [1].
    pub lean: f32,
}

impl KnotDraw {
    /// The draws of one knot's own stream.
    pub fn new(stream: Stream, knots: &Knots) -> Self {
        let mut rng = stream.child("shape").rng();
        let mut next = || normal(&mut rng);
        let (width, slope, opening, taper, turn): (f64, f64, f64, f64, f64) = (next(), next(), next(), next(), next());
        let bend = BEND * rng.random::<f64>();
        let mut rng = stream.child("outline").rng();
        // Amplitudes fall as 1/order; the root mean square of a harmonic is its amplitude over sqrt 2, of its two
        // normal parts that of one of them.
        let power: f64 = (0..HARMONICS).map(|i| 1.0 / ((i + 2) as f64).powi(2)).sum();
        let outline = std::array::from_fn(|i| {
            let mut part = || normal(&mut rng);
            let amplitude = WOBBLE / ((i + 2) as f64 * power.sqrt());
            Vec2::new((amplitude * part()) as f32, (amplitude * part()) as f32)
        });
        let mut rng = stream.child("bulge").rng();
        let bulge = KnotBulge {
            height: libm::exp(knots.bulge_log_sd * normal(&mut rng)) as f32,
            lean: (knots.lean_sd_deg.to_radians() * normal(&mut rng)) as f32,
        };
        Self {
            width,
            slope,
            opening,
            taper,
            bend,
            turn: (TURN_SD * turn) as f32,
            bulge,
            outline,
            inside: KnotInside::grow(stream, knots),
        }
    }
}

/// Where a knot meets the upper surface, and how.
#[derive(Debug, Clone, Copy)]
pub(super) struct KnotPoint {
    /// Distance from the pith [mm].
    pub r: f32,
    /// Azimuth [rad].
    pub phi: f32,
    /// Along the log [mm].
    pub l: f32,
    /// Half width [mm].
    pub half_width: f32,
    /// dl/dr [1].
    pub slope: f32,
    /// Distance from the pith where it died [mm]; infinite for a sound knot.
    pub death: f32,
    /// Thickness of the bark ring [mm].
    pub bark: f32,
}

/// A branch in the log.
#[derive(Debug, Clone)]
pub(super) struct Knot {
    /// What it is at the upper surface.
    pub class: Class,
    /// Its number among the instances.
    pub id: u16,
    /// Distance from the pith where it died [mm]; infinite for a sound knot.
    pub death: f32,
    /// Thickness of the bark ring [mm].
    pub bark: f32,
    /// Distance from the pith where it ends [mm]; infinite where it reaches the surface of the log.
    pub end: f32,
    /// Cosine of the axis' slope: the cut along the log is longer by its inverse [1].
    pub cos_slope: f32,
    /// Length of the rounded end [mm].
    cap: f32,
    /// Length beyond the end over which growth layers heal [mm].
    healing: f32,
    /// C [mm], D [mm^(1/2)], E [1], F [rad] and G [rad].
    skeleton: [f32; 5],
    /// Distance from the pith where the width is given: at the surface, or where the branch died [mm].
    fixed: f32,
    /// Half width there [mm].
    half_width: f32,
    /// B r^(1/4) / A there, with its sign turned [1].
    taper: f32,
    /// r / fixed beyond which the width stays [1].
    widest: f32,
    /// Its bulge of growth layers.
    pub bulge: KnotBulge,
    outline: [Vec2; HARMONICS],
    /// What a cut through it shows.
    pub inside: KnotInside,
}

/// Powers of the distance from the pith that all knots at a point share.
#[derive(Debug, Clone, Copy)]
pub(super) struct KnotDistance {
    /// The distance itself [mm].
    pub r: f32,
    root: f32,
    log: f32,
    fourth_root: f32,
}

impl KnotDistance {
    /// Of a point `r` away from the pith [mm].
    #[inline]
    pub fn new(r: f32) -> Self {
        let root = r.sqrt();
        Self { r, root, log: libm::logf(r), fourth_root: root.sqrt() }
    }
}

/// A knot's skeleton and width at one distance from the pith.
#[derive(Debug, Clone, Copy)]
pub(super) struct KnotSection {
    /// Azimuth of the axis [rad].
    pub phi: f32,
    /// r d(phi)/dr of the axis [rad].
    pub turn: f32,
    /// Axis along the log [mm].
    pub l: f32,
    /// dl/dr of the axis [1].
    pub slope: f32,
    /// Half width [mm].
    pub half_width: f32,
    /// Change of the half width with r [1].
    pub widening: f32,
}

impl Knot {
    /// The branch through a spot.
    pub fn new(id: u16, class: Class, spot: &KnotPoint, draw: &KnotDraw) -> Self {
        let opening = (OPENING[0] + OPENING[1] * draw.opening).clamp(OPENING_RANGE[0], OPENING_RANGE[1]);
        let narrowing = TAPER[0] * opening + TAPER[1] + TAPER[2] * draw.taper;
        let fixed = spot.r.min(spot.death);
        let taper = (-narrowing * f64::from(fixed).sqrt().sqrt() / opening).clamp(0.0, TAPER_LIMIT) as f32;
        let bend = draw.bend as f32;
        let turn = draw.turn;
        let rise = spot.slope - 0.5 * bend / spot.r.sqrt();
        let start = spot.l - bend * spot.r.sqrt() - rise * spot.r;
        Self {
            class,
            id,
            death: spot.death,
            end: f32::INFINITY,
            cap: 0.0,
            healing: 0.0,
            bark: spot.bark.min(BARK_LIMIT * spot.half_width),
            cos_slope: 1.0 / (1.0 + spot.slope * spot.slope).sqrt(),
            skeleton: [start, bend, rise, spot.phi - turn * libm::logf(spot.r), turn],
            half_width: spot.half_width,
            fixed,
            taper,
            widest: if taper > 0.0 { (0.8 / taper).powi(4) } else { f32::INFINITY },
            bulge: draw.bulge,
            outline: draw.outline,
            inside: draw.inside,
        }
    }

    /// A branch of a stem in the log of a board: `along` is the board's middle along the stem [mm], `azimuth` what is
    /// azimuth 0 in the log [rad], `r` the distance from the pith where its slope is taken, and `bark` the thickness of
    /// its ring [mm]. Its width, skeleton, death and end are those of the branch; class and number are given later.
    pub fn of_branch(branch: &StemBranch, along: f64, azimuth: f64, r: f64, bark: f32, draw: &KnotDraw) -> Self {
        let [opening, narrowing] = branch.width;
        let fixed = branch.widest_mm().min(branch.end_mm).min(NOTED_MM);
        let half_width = 0.5 * branch.width_mm(fixed) as f32;
        let taper = -narrowing * fixed.sqrt().sqrt() / opening;
        let end = branch.end_mm as f32;
        let last = if end.is_finite() { 0.5 * branch.width_mm(branch.end_mm) as f32 } else { 0.0 };
        let [start, bend, rise] = branch.height;
        let [from, turn] = branch.azimuth;
        // Half a turn away at most, so that differences of azimuths need one turn at most.
        let middle = from + turn * libm::log(0.5 * fixed) - azimuth;
        let turns = libm::round(middle / std::f64::consts::TAU) * std::f64::consts::TAU;
        Self {
            class: Class::SoundKnot,
            id: 0,
            death: branch.death_mm as f32,
            end,
            cap: if end.is_finite() { last.min(CAP_LIMIT * end) } else { 0.0 },
            healing: HEALING * last,
            bark: bark.min(BARK_LIMIT * half_width),
            cos_slope: (1.0 / (1.0 + branch.slope(r) * branch.slope(r)).sqrt()) as f32,
            skeleton: [(start - along) as f32, bend as f32, rise as f32, (from - azimuth - turns) as f32, turn as f32],
            half_width,
            fixed: fixed as f32,
            taper: taper as f32,
            widest: if taper > 0.0 { libm::pow(0.8 / taper, 4.0) as f32 } else { f32::INFINITY },
            bulge: draw.bulge,
            outline: draw.outline,
            inside: draw.inside,
        }
    }

    /// Distance from the pith beyond which nothing is left of it [mm].
    #[inline]
    pub fn gone(&self) -> f32 {
        self.end + self.healing
    }

    /// How much of what it does to the wood around is left at a distance from the pith [1], and the slope of that
    /// [mm^-1].
    #[inline]
    pub fn left(&self, r: f32) -> (f32, f32) {
        let length = self.cap + self.healing;
        let u = ((r - self.end + self.cap) / length).clamp(0.0, 1.0);
        let (v, w) = (u * u, 1.0 - u);
        (1.0 - v * u * (u * (6.0 * u - 15.0) + 10.0), -30.0 * v * w * w / length)
    }

    /// Width of the outline over that of the branch, below 1 in a rounded end only [1].
    #[inline]
    pub fn tip(&self, r: f32) -> f32 {
        if self.end == f32::INFINITY {
            return 1.0;
        }
        let u = ((r - self.end + self.cap) / self.cap).clamp(0.0, 1.0);
        (1.0 - u * u).sqrt().max(TIP_LEAST)
    }

    /// The knot at a distance from the pith.
    #[inline]
    pub fn section(&self, at: &KnotDistance) -> KnotSection {
        let [start, bend, rise, azimuth, turn] = self.skeleton;
        let share = at.r / self.fixed;
        let (half_width, widening) = if at.r >= self.death || share >= self.widest {
            let share = self.widest.min(self.death / self.fixed);
            (self.half_width * self.growth(share, share.sqrt().sqrt()), 0.0)
        } else {
            let fourth = at.fourth_root / self.fixed.sqrt().sqrt();
            let slope = (1.0 - 1.25 * self.taper * fourth) / (1.0 - self.taper);
            (self.half_width * self.growth(share, fourth), self.half_width * slope / self.fixed)
        };
        KnotSection {
            phi: azimuth + turn * at.log,
            turn,
            l: start + bend * at.root + rise * at.r,
            slope: rise + 0.5 * bend / at.root,
            half_width,
            widening,
        }
    }

    #[inline]
    fn growth(&self, share: f32, fourth_root: f32) -> f32 {
        share * (1.0 - self.taper * fourth_root) / (1.0 - self.taper)
    }

    /// Distance of a place off the axis (around, along, as the leaning branch is cut) from it, in half widths of the
    /// wobbling outline [1], and the wobble there as a part of the radius [1].
    #[inline]
    pub fn reach(&self, offset: Vec2, half_width: f32) -> (f32, f32) {
        let wobble = self.wobble(offset);
        (offset.length() / (half_width * (1.0 + wobble)), wobble)
    }

    /// Wobble of the outline in the direction of a place off the axis (around, along), as a part of the radius [1].
    #[inline]
    fn wobble(&self, offset: Vec2) -> f32 {
        let direction = offset / offset.length().max(1.0e-6);
        // Cosine and sine of the multiples of the direction's angle are powers of it as a complex number.
        let mut turned = direction;
        let mut sum = 0.0;
        for harmonic in self.outline {
            turned = turned.rotate(direction);
            sum += harmonic.dot(turned);
        }
        sum.clamp(-WOBBLE_LIMIT, WOBBLE_LIMIT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draw(index: u64) -> KnotDraw {
        let wood = crate::wood::Wood::from_values(&mut |p| p.default);
        KnotDraw::new(Stream::root(2).index(index), &wood.knots)
    }

    fn knot(death: f32, index: u64) -> Knot {
        let spot = KnotPoint { r: 70.0, phi: 0.3, l: 12.0, half_width: 6.0, slope: -0.18, death, bark: 0.7 };
        Knot::new(1, Class::SoundKnot, &spot, &draw(index))
    }

    #[test]
    fn a_knot_passes_its_spot_with_its_width_and_slope() {
        for death in [f32::INFINITY, 49.0] {
            for index in 0..50 {
                let section = knot(death, index).section(&KnotDistance::new(70.0));
                assert!((section.l - 12.0).abs() < 1.0e-4 && (section.phi - 0.3).abs() < 1.0e-5);
                assert!((section.half_width - 6.0).abs() < 1.0e-4 && (section.slope + 0.18).abs() < 1.0e-5);
            }
        }
    }

    #[test]
    fn width_grows_while_the_branch_lives_and_then_stays() {
        for index in 0..50 {
            let knot = knot(49.0, index);
            let widths: Vec<f32> = (1..120).map(|r| knot.section(&KnotDistance::new(r as f32)).half_width).collect();
            assert!(widths.windows(2).all(|w| w[1] >= w[0]), "{widths:?}");
            assert!(widths[49..].iter().all(|&w| w == widths[60]) && widths[20] < 0.9 * widths[60]);
        }
    }

    #[test]
    fn slopes_are_derivatives() {
        for (death, r) in [(f32::INFINITY, 30.0), (f32::INFINITY, 65.0), (49.0, 40.0), (49.0, 60.0)] {
            let knot = knot(death, 3);
            let h = 0.05;
            let (low, mid, high) = (
                knot.section(&KnotDistance::new(r - h)),
                knot.section(&KnotDistance::new(r)),
                knot.section(&KnotDistance::new(r + h)),
            );
            assert!(((high.l - low.l) / (2.0 * h) - mid.slope).abs() < 1.0e-3);
            assert!(((high.phi - low.phi) / (2.0 * h) * r - mid.turn).abs() < 1.0e-3);
            assert!(((high.half_width - low.half_width) / (2.0 * h) - mid.widening).abs() < 1.0e-3);
        }
    }
}
