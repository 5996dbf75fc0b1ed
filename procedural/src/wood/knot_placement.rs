//! Where knots meet the upper surface.
//!
//! Models: each knot proposes places, uniform over the face, from its own stream and takes the first that fits: its
//! outline inside the board unless edges may cut it, clear of the knots before it, not too flat against the surface,
//! and far enough from the pith for its width. Where none fits it takes the one that misses by least. So a further knot
//! leaves the earlier ones alone, and the knots of one kind only move where those of the other are in their way.
//! Limits: no whorls; the number, not the forest, decides how many knots a board has. `stem` is the other way.

use base::{Class, Instance, Stream};
use glam::{Vec2, Vec3};
use rand::RngExt;

use super::Wood;
use super::bulge::{ASPECT, REACH};
use super::knot::{Knot, KnotDistance, KnotDraw, KnotPoint};
use super::pith::Trunk;

/// Places that a knot proposes.
const PROPOSALS: usize = 96;
/// Wood left between a knot's outline and the edge [mm].
const EDGE_GAP_MM: f32 = 1.0;
/// Distance between two outlines over the sum of their half lengths [1].
const NEIGHBOUR_GAP: f32 = 1.25;
/// A knot wider than this part of the board's shorter side is made narrower [1].
const WIDEST_SHARE: f32 = 0.5;
/// A knot as wide as this times its distance from the pith is made narrower [1]: the largest opening angle in the log.
const WIDEST_OPENING: f32 = 0.6;
/// Axes flatter than this against the surface are avoided (spike knots) [deg].
const FLATTEST_DEG: f32 = 40.0;
/// Steepest slope of an axis [rad].
const STEEPEST: f64 = 1.2;
/// What a degree below it counts as, against a millimetre of overlap [mm/deg].
const MM_PER_DEG: f32 = 0.3;
/// Smallest sine of the dive that lengthens the outline [1].
const LEAST_SINE: f32 = 0.15;
/// Room for the outline's wobble [1].
const WOBBLE_ROOM: f32 = 1.12;
/// Skeleton points from which the room of a knot is found.
const SKELETON_STEPS: usize = 200;

/// A knot with the room in which it disturbs the board.
#[derive(Debug, Clone)]
pub(super) struct PlacedKnot {
    /// The branch.
    pub knot: Knot,
    /// Along the laser line: from, to [mm].
    pub x: [f32; 2],
    /// Along the scan: from, to [mm].
    pub y: [f32; 2],
    /// Its numbers; `None` where the upper face shows none of it.
    pub instance: Option<Instance>,
}

/// A proposal that was looked at.
#[derive(Debug, Clone, Copy)]
struct KnotProposal {
    spot: KnotPoint,
    centre: Vec2,
    /// Half length of the outline [mm].
    half_length: f32,
    dive: f32,
    /// How far it is from fitting where edges may cut it [mm], and by how much they do [mm].
    miss: f32,
    over: f32,
}

/// All knots of a board: sound ones first.
pub(super) fn place(stream: Stream, wood: &Wood, trunk: &Trunk) -> Vec<PlacedKnot> {
    let mut taken: Vec<KnotProposal> = Vec::new();
    let mut placed = Vec::new();
    let reach = trunk.reach(half_size(wood), wood.board.thickness_mm as f32) + 1.0;
    for (class, name, count) in [
        (Class::SoundKnot, "sound", wood.knots.sound_count),
        (Class::DeadKnot, "dead", wood.knots.dead_count),
        (Class::KnotHole, "hole", wood.knots.hole_count),
        (Class::LooseKnot, "loose", wood.knots.loose_count),
    ] {
        for index in 0..count.round() as u64 {
            let own = stream.child(name).index(index);
            let draw = KnotDraw::new(own, &wood.knots);
            let best = settle(own, wood, trunk, class, &draw, &taken);
            let id = placed.len() as u16 + 1;
            let knot = Knot::new(id, class, &best.spot, &draw);
            placed.push(surround(knot, &best, wood, trunk, reach));
            taken.push(best);
        }
    }
    placed
}

/// Half the size of a board [mm].
pub(super) fn half_size(wood: &Wood) -> Vec2 {
    0.5 * Vec2::new(wood.board.width_mm as f32, wood.board.length_mm as f32)
}

/// The first proposal that fits, else the one that misses by least.
fn settle(
    own: Stream,
    wood: &Wood,
    trunk: &Trunk,
    class: Class,
    draw: &KnotDraw,
    taken: &[KnotProposal],
) -> KnotProposal {
    let mut rng = own.child("place").rng();
    let mut best: Option<KnotProposal> = None;
    let may_be_cut = f64::from(own.child("cut").rng().random::<f32>()) < wood.knots.cut_share;
    for _ in 0..PROPOSALS {
        let share = Vec2::new(rng.random::<f32>(), rng.random::<f32>()) * 2.0 - 1.0;
        let mut proposal = look(share, wood, trunk, class, draw, taken);
        if !may_be_cut {
            proposal.miss += proposal.over;
        }
        if best.is_none_or(|b| proposal.miss < b.miss) {
            best = Some(proposal);
        }
        if proposal.miss <= 0.0 {
            break;
        }
    }
    best.expect("there is more than one proposal")
}

/// Looks at the place a share of the half size away from the board's middle.
fn look(
    share: Vec2,
    wood: &Wood,
    trunk: &Trunk,
    class: Class,
    draw: &KnotDraw,
    taken: &[KnotProposal],
) -> KnotProposal {
    let (board, knots) = (&wood.board, &wood.knots);
    let half = half_size(wood);
    let middle = Vec2::new(board.offset_mm as f32, board.lead_in_mm as f32 + half.y);
    let centre = middle + share * half;
    let place = trunk.place(centre.x, centre.y, board.thickness_mm as f32);
    let width = (knots.width_mm * libm::exp(knots.width_log_sd * draw.width)) as f32;
    let fitting = width.min(WIDEST_SHARE * 2.0 * half.min_element());
    let width = fitting.min(WIDEST_OPENING * place.r);
    let slope = (knots.slope_deg + knots.slope_sd_deg * draw.slope).to_radians().clamp(-STEEPEST, STEEPEST);
    let dead = class != Class::SoundKnot;
    let spot = KnotPoint {
        r: place.r,
        phi: place.phi,
        l: place.l,
        half_width: 0.5 * width,
        slope: libm::tan(slope) as f32,
        death: if dead { place.r * knots.death_share as f32 } else { f32::INFINITY },
        bark: if dead { knots.bark_mm as f32 } else { 0.0 },
    };
    let across = place.outward + draw.turn * place.around() + spot.slope * place.pith_slope;
    let axis = trunk.vector(across, spot.slope).normalize();
    let dive = libm::asinf(axis.z.abs().min(1.0));
    // The outline is an ellipse: half a width across, and longer where the axis leans.
    let long = spot.half_width * WOBBLE_ROOM / axis.z.abs().max(LEAST_SINE);
    let lean = axis.truncate().try_normalize().unwrap_or(Vec2::X);
    let round = spot.half_width * WOBBLE_ROOM;
    let extent = Vec2::new(libm::hypotf(long * lean.x, round * lean.y), libm::hypotf(long * lean.y, round * lean.x));
    let over = ((share * half).abs() + extent + EDGE_GAP_MM - half).max(Vec2::ZERO);
    let crowd: f32 = taken
        .iter()
        .map(|other| (NEIGHBOUR_GAP * (other.half_length + long) - other.centre.distance(centre)).max(0.0))
        .sum();
    let flat = MM_PER_DEG * (FLATTEST_DEG - dive.to_degrees()).max(0.0);
    let miss = crowd + flat + (fitting - width);
    KnotProposal { spot, centre, half_length: long, dive, miss, over: 2.0 * over.element_sum() }
}

/// Finds the room that a knot disturbs and notes its numbers.
fn surround(knot: Knot, at: &KnotProposal, wood: &Wood, trunk: &Trunk, reach: f32) -> PlacedKnot {
    let thickness = wood.board.thickness_mm as f32;
    let centre = at.centre.extend(thickness);
    let (mut low, mut high) = (centre, centre);
    let mut most = at.spot.half_width;
    let step = reach / SKELETON_STEPS as f32;
    for i in 1..=SKELETON_STEPS {
        let distance = KnotDistance::new(i as f32 * step);
        let section = knot.section(&distance);
        let point = trunk.point(distance.r, section.phi, section.l);
        let room = REACH * section.half_width + step;
        if point.z > -room && point.z < thickness + room {
            (low, high) = (low.min(point), high.max(point));
            most = most.max(section.half_width);
        }
    }
    // The disturbance is longest along the log; the leaning axis lengthens it further.
    let room = Vec3::splat(REACH * ASPECT * most / knot.cos_slope + 2.0 * step);
    let (low, high) = (low - room, high + room);
    let place = at.centre.as_dvec2().to_array();
    let instance = Instance {
        dive_deg: f64::from(at.dive.to_degrees()),
        death_radius_mm: if at.spot.death.is_finite() { f64::from(at.spot.death) } else { f64::NAN },
        ..Instance::new(knot.id, knot.class, place, 2.0 * f64::from(at.spot.half_width), f64::NAN)
    };
    PlacedKnot { knot, x: [low.x, high.x], y: [low.y, high.y], instance: Some(instance) }
}
