//! How the trunk grew around its knots: time of growth and fibre direction at a point.
//!
//! Models: time of growth t as the distance from the pith with a slight waviness, less the bulges around knots. Fibres
//! follow the pith. The spiral grain turns them, of which there is none at the pith itself and half of the law 5 mm
//! from it (a guess). Every knot pushes them aside. Then they are laid into the growth surface t = const, f =
//! normalise(f0 - (f0 n) n) with n along grad t. Inside a branch fibres run along its axis. Branch and stem meet
//! without a passage: tissues of both are laid over each other by turns, year after year (Shigo 1985). Fibres that
//! turned from one into the other would pass the angle at which guided light meets the camera, and give each sound knot
//! the same bright rim. Sources: Foley (2001) for fibres in growth surfaces; Säll (2002) for the spiral; `bulge` and
//! `grain_flow` for the rest. Around a branch that ended inside the stem all of this fades (`knot`). Limits: the
//! disturbances of several knots add up; a branch's collar has no swelling of its own; fibres that bend out of the stem
//! into a living branch from below do so within its outline, at once.

use std::sync::Arc;

use base::Stream;
use glam::{Vec2, Vec3};

use super::Wood;
use super::bulge::{Bulge, BulgePlace, REACH, SHORTEN, height};
use super::grain_flow::{RankineOval, SLOWEST};
use super::knot::{Knot, KnotDistance, KnotSection};
use super::pith::LogPoint;
use super::stem::Layers;
use crate::noise::{Noise, smoothstep};

/// Waviness of the growth layers over the distance from the pith, root mean square [1].
const WAVINESS: f32 = 0.005;
/// Lattice steps of the waviness over a radian about the pith [1].
const WAVES_PER_RAD: f32 = 3.0;
/// Cell of the waviness along the log [mm].
const WAVE_MM: f32 = 120.0;
/// Largest spiral grain [rad].
const SPIRAL_LIMIT: f32 = 10.0 * std::f32::consts::PI / 180.0;
/// Distance from a living branch's axis over which its medium begins [half widths].
const RIND: [f32; 2] = [0.82, 1.1];
/// Outlines are looked at within this distance [half widths].
const OUTLINE_REACH: f32 = 1.85;
/// Width of the passage from the stream's speed to the slowest one [1].
const FLOOR_ROUNDING: f32 = 0.3;
/// Part by which bark is thicker where the outline wobbles outwards by one part [1].
const BARK_WOBBLE: f32 = 6.0;
/// Distance from the pith where half of the spiral grain has come [mm]: the first years are straight.
const STRAIGHT_MM: f32 = 5.0;
/// How far fibre bundles follow the streamlines [1]; less than 1, or the tips of the oval would hold a single bundle.
const FOLLOW: f32 = 0.85;

/// What all points of a log share.
#[derive(Debug, Clone)]
pub(super) struct Growth {
    spiral: [f32; 2],
    waves: Noise,
    bulge: Bulge,
    oval: RankineOval,
    layers: Option<Arc<Layers>>,
}

/// Wood at a point as it grew.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grown<'a> {
    /// Radius that the trunk had then [mm].
    pub t: f32,
    /// Fibre: sideways and upwards in the log, then along it; unit length [1].
    pub fibre: Vec3,
    /// Which fibre bundle: around the log, counted at the pith's foot of the spiral [mm].
    pub bundle: f32,
    /// How much knots disturb the fibres' order here, 0 far from them and 1 at and in them [1].
    pub disturbed: f32,
    /// The nearest knot, if its outline is near.
    pub branch: Option<Branch<'a>>,
    /// Gradient of t in the same axes as the fibre, knots included [1].
    #[cfg(test)]
    pub gradient: Vec3,
}

/// A point at or in a branch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Branch<'a> {
    /// The branch.
    pub knot: &'a Knot,
    /// Distance from the axis [half widths, wobble of the outline included].
    pub x: f32,
    /// Half width [mm].
    pub half_width: f32,
    /// Wobble of the outline here [1].
    pub wobble: f32,
    /// It had died when this point grew.
    pub dead: bool,
    /// Cosine of the angle between the direction from the axis to here and down the stem [1].
    pub below: f32,
    /// From the axis to here: around and along the log [mm].
    pub offset: Vec2,
    section: KnotSection,
}

impl Growth {
    /// The growth of a log.
    pub fn new(stream: Stream, wood: &Wood) -> Self {
        let log = &wood.log;
        let slope = log.spiral_slope_deg_per_mm.to_radians();
        Self {
            spiral: [log.spiral_deg.to_radians() as f32, slope as f32],
            waves: Noise::new(stream.child("waves")),
            bulge: Bulge::new(),
            oval: RankineOval::new(wood.knots.flow_ratio as f32),
            layers: None,
        }
    }

    /// The same in a log whose layers leave the pith's wander.
    pub fn with_layers(self, layers: Option<&Arc<Layers>>) -> Self {
        Self { layers: layers.cloned(), ..self }
    }

    /// Spiral grain at a distance from the pith, sine and cosine [1].
    #[inline]
    fn spiral(&self, r: f32) -> (f32, f32) {
        let spiral = (self.spiral[0] + self.spiral[1] * r).clamp(-SPIRAL_LIMIT, SPIRAL_LIMIT);
        (spiral * (1.0 - spiral * spiral / 6.0), 1.0 - 0.5 * spiral * spiral)
    }

    /// By how much the number of the bundle changes over a whole turn about the pith [mm].
    pub fn bundles_around(&self, r: f32) -> f32 {
        std::f32::consts::TAU * r * self.spiral(r).1
    }

    /// Time of growth and fibre at a place among the knots that may be near.
    #[inline]
    pub fn at<'a>(&self, place: &LogPoint, knots: impl Iterator<Item = &'a Knot>) -> Grown<'a> {
        let (r, around) = (place.r, place.around());
        let spiral @ (sin, _) = self.spiral(r);
        // Lay the rings and bundles as they grow without knots.
        let (mut bent, runs) = self.without_knots(place, spiral);
        // Let every knot near bulge the rings and push the bundles aside.
        let mut distance = None;
        for knot in knots {
            if r < knot.gone() {
                let section = knot.section(distance.get_or_insert_with(|| KnotDistance::new(r)));
                self.bend(knot, section, place, spiral, &mut bent);
            }
        }
        let Bent { t, slope, stream, bundle, disturbed, branch } = bent;
        // Lay the fibre into the growth surface t = const, along the stream.
        let normal_across = slope.x * place.outward + slope.y * around;
        let normal = normal_across.extend(slope.z - place.pith_slope.dot(normal_across));
        let stream = Vec2::new(not_below(stream.x, SLOWEST), stream.y);
        // Bundles are numbered by the whole spiral, or those of long boards would be sheared near the pith.
        let sin = sin * r * r / (r * r + STRAIGHT_MM * STRAIGHT_MM);
        let cos = 1.0 - 0.5 * sin * sin;
        let (along, aside) = (stream.x * cos + stream.y * sin, stream.y * cos - stream.x * sin);
        let free = (along * runs + aside * around).extend(along);
        let laid = free - normal * (free.dot(normal) / normal.length_squared());
        let mut fibre = laid.normalize_or(Vec3::Z);
        if let Some(branch) = &branch {
            fibre = branch.fibre(fibre, place);
        }
        Grown {
            t,
            fibre,
            bundle,
            disturbed,
            branch,
            #[cfg(test)]
            gradient: normal,
        }
    }

    /// Rings and bundles at a place of a trunk without knots, whose spiral grain has this sine and cosine; and where
    /// fibres run that go straight along it, sideways and upwards [1].
    #[inline]
    fn without_knots<'a>(&self, place: &LogPoint, (sin, cos): (f32, f32)) -> (Bent<'a>, Vec2) {
        let (r, around) = (place.r, place.around());
        let (wave, wave_slope) = self.waves.space_slope((WAVES_PER_RAD * place.outward).extend(place.l / WAVE_MM));
        let mut t = r * (1.0 + WAVINESS * wave);
        let mut slope = Vec3::new(
            1.0 + WAVINESS * wave,
            WAVINESS * WAVES_PER_RAD * wave_slope.truncate().dot(around),
            WAVINESS * r * wave_slope.z / WAVE_MM,
        );
        let (mut turned_phi, mut runs) = (place.phi, place.pith_slope);
        if let Some(layers) = &self.layers {
            let layer = layers.at(place);
            t += layer.t - r;
            let [out, aside, along] = layer.slope;
            slope += Vec3::new(out - 1.0, aside, along);
            turned_phi += layer.turn;
            runs += layer.drift_slope;
        }
        let bundle = r * turned_phi * cos + place.l * sin;
        (Bent { t, slope, stream: Vec2::X, bundle, disturbed: 0.0, branch: None }, runs)
    }

    /// Adds what a knot does to rings and bundles at a place, where its section is this and the spiral grain has this
    /// sine and cosine.
    #[inline]
    fn bend<'a>(
        &self,
        knot: &'a Knot,
        section: KnotSection,
        place: &LogPoint,
        (sin, cos): (f32, f32),
        bent: &mut Bent<'a>,
    ) {
        let (r, a) = (place.r, section.half_width);
        let offset = Vec2::new(r * wrap(place.phi - section.phi), place.l - section.l);
        let (across, along) = (offset.x * offset.x, (knot.cos_slope * offset.y).powi(2));
        if across + along * SHORTEN >= REACH * REACH * a * a {
            return;
        }
        let bulging = BulgePlace::of((across + along).sqrt() / a, (across + along * SHORTEN).sqrt() / a);
        if bulging.x >= REACH {
            return;
        }
        let merge = self.bulge.at(bulging.x);
        let (h, h_slope) = height(a, section.widening, r - knot.death);
        // Layers that lean at the knot are bulges of another height on either side of it.
        let lean = knot.bulge.lean * self.bulge.per_rim();
        let mut h = knot.bulge.height * h + lean * offset.y;
        let mut h_slope = knot.bulge.height * h_slope - lean * section.slope;
        let mut left = 1.0;
        if knot.end.is_finite() {
            let fall;
            (left, fall) = knot.left(r);
            h_slope = left * h_slope + fall * h;
            h *= left;
        }
        bent.t -= h * merge.depth;
        let steep = bulging.steepness.map(|part| h * merge.slope_over_x * part / (a * a));
        let steep_across = steep[0] + steep[1];
        let steep_along = (steep[0] + steep[1] * SHORTEN) * knot.cos_slope * knot.cos_slope;
        let drift = steep_across * offset.x * (offset.x / r - section.turn) - steep_along * offset.y * section.slope;
        let widening = bulging.widened * h * merge.slope_over_x * section.widening / a;
        let along = steep_along * offset.y + left * lean * merge.depth;
        bent.slope -= Vec3::new(h_slope * merge.depth + drift - widening, steep_across * offset.x, along);
        let rise = offset.y * knot.cos_slope;
        let turned = Vec2::new(rise * cos - offset.x * sin, offset.x * cos + rise * sin) / a;
        let disturbance = self.oval.disturb(turned);
        let weight = left * merge.weight;
        bent.stream += weight * disturbance.velocity;
        bent.disturbed = bent.disturbed.max(left * self.bulge.disorder(&merge));
        bent.bundle += FOLLOW * weight * a * disturbance.psi;
        let d = Vec2::new(offset.x, rise);
        if d.length_squared() < (OUTLINE_REACH * a).powi(2) && r < knot.end {
            let a = a * knot.tip(r);
            let (x, wobble) = knot.reach(d, a);
            let length = d.length();
            if bent.branch.is_none_or(|other| x < other.x) {
                let (dead, below) = (r >= knot.death, -rise / length.max(1.0e-6));
                bent.branch = Some(Branch { knot, x, half_width: a, wobble, dead, below, offset, section });
            }
        }
    }
}

/// Rings and bundles at a place, bent by the knots that were looked at so far.
struct Bent<'a> {
    /// Time of growth [mm], and its slopes outwards, around and along [1].
    t: f32,
    slope: Vec3,
    /// The stream of fibres about the knots, along and across it [1].
    stream: Vec2,
    /// Which fibre bundle [mm].
    bundle: f32,
    /// How much knots disturb the fibres' order [1].
    disturbed: f32,
    /// The nearest knot whose outline is near.
    branch: Option<Branch<'a>>,
}

impl Branch<'_> {
    /// Thickness of the bark here over the half width [1].
    #[inline]
    pub fn bark(&self) -> f32 {
        if !self.dead {
            return 0.0;
        }
        let mean = self.knot.bark / self.half_width * self.knot.inside.bark(self.offset);
        (mean * (1.0 + BARK_WOBBLE * self.wobble)).max(0.0)
    }

    /// How much of the medium here is the branch's [1]: wood begins gradually, bark sharply.
    #[inline]
    pub fn share(&self) -> f32 {
        if self.bark() > 0.0 { f32::from(self.x < 1.0) } else { 1.0 - smoothstep(RIND[0], RIND[1], self.x) }
    }

    /// The fibre here, given that of the trunk around.
    #[inline]
    fn fibre(&self, trunk: Vec3, place: &LogPoint) -> Vec3 {
        if self.x >= 1.0 {
            return trunk;
        }
        // Lines that keep their place in the widening branch.
        let spread = self.section.widening / self.half_width;
        let around = self.section.turn + self.offset.x * spread;
        let along = self.section.slope + self.offset.y * spread;
        let axis = place.outward + around * place.around() + along * place.pith_slope;
        axis.extend(along).normalize()
    }
}

/// The larger of both without a kink, which fibres would show as a point from which they fan out.
#[inline]
pub(super) fn not_below(speed: f32, slowest: f32) -> f32 {
    let above = speed - slowest;
    slowest + 0.5 * (above + (above * above + FLOOR_ROUNDING * FLOOR_ROUNDING).sqrt())
}

/// An angle brought within half a turn of 0 [rad].
#[inline]
pub(super) fn wrap(angle: f32) -> f32 {
    use std::f32::consts::{PI, TAU};
    if angle > PI {
        angle - TAU
    } else if angle < -PI {
        angle + TAU
    } else {
        angle
    }
}
