//! The grain that the upper face cuts, on a grid: what torn fibres, canals, pores and rays need at every pixel.
//!
//! Models: at the nodes of a grid of [`STEP_MM`] the face is asked for the time of growth t, for the bundle that lies
//! there, for the fibre's dive and for decay. Between nodes all of them are joined by straight lines, bundles the
//! shorter way about the pith, since their numbers begin anew opposite of the board's middle. Torn and fuzzy grain:
//! knives that travel along the board lift fibres that dive against their travel and tear them out. Strands of noise
//! along the grain, deep where they are low and raised where they are high, z = s h n - s h max(0, n - 1), with the
//! share s of the dive. Fibres that are only bent up (fuzz) are finer, stand where fibres dive to either side, and
//! point in all directions. Decayed wood shrinks and is worn: the face sinks by the asked depth times severity times
//! the share of the front that has passed. Strands follow the grain around knots because they are counted by bundles.
//! Sources: engineering estimates. Limits: details below the grid's step; what lies below the face is as at the face;
//! knots themselves stay whole and sound; torn places neither shade nor hide unless decay sinks the face or it has
//! openings.

use base::{Stream, Surface};
use glam::{Vec2, Vec3};
use rand::RngExt;

use super::Wood;
use super::board_face::BoardFace;
use super::growth::Growth;
use super::pith::{LogPoint, Trunk};
use crate::noise::{FIBRES_MOST, Noise, PLANE_MOST, smoothstep};

/// Distance of two nodes, where the board isn't so large that more than [`MOST_NODES`] would be needed [mm].
const STEP_MM: f32 = 1.0;
const MOST_NODES: f32 = 2.5e5;
/// Strands that the knives tear out, and raised fibres: half width across and mean length along [mm].
const TORN_MM: [Vec2; 2] = [Vec2::new(0.22, 2.4), Vec2::new(0.7, 6.0)];
const FUZZY_MM: Vec2 = Vec2::new(0.12, 0.9);
/// Height of either size of torn strands over what is asked [1]: of both the root mean square is that.
const TORN_PART: f32 = 0.7;
/// Tears begin and are complete at these parts of the dive that is asked [1].
const DIVES: [f32; 2] = [0.5, 1.5];
/// Cell of the patches in which grain tears [mm], and how much they vary it [1].
const PATCH_MM: f32 = 5.0;
const PATCHES: f32 = 0.45;
/// Dispersion that fuzz adds [deg], and the most that fibres have.
const FUZZY_DISPERSION_DEG: f32 = 5.0;
const MOST_DISPERSION_DEG: f32 = 14.0;
/// Share of the gloss that torn grain loses: its facets lean to all sides [1].
const DULL: f32 = 0.7;

/// What the face cuts at a place.
#[derive(Debug, Clone, Copy)]
pub(super) struct FaceGrain {
    /// Time of growth, bundle and place along the log [mm].
    pub t: f32,
    pub bundle: f32,
    pub l: f32,
    /// Share of torn and of fuzzy grain [1].
    torn: f32,
    fuzzy: f32,
    /// How far decay has sunk the face [mm].
    sunk: f32,
}

/// A grid over the face.
#[derive(Debug, Clone)]
pub(super) struct FaceGrains {
    low: Vec2,
    step: f32,
    size: [usize; 2],
    /// t, bundle, torn, fuzzy, sunk, change of the bundle over a turn about the pith.
    nodes: Vec<[f32; 6]>,
    middle: Vec2,
    turn: Vec2,
    /// Parts of bundle and t in the coordinate across the strands [1].
    across: Vec2,
    torn: f32,
    fuzzy: f32,
    strands: [Noise; 3],
}

impl FaceGrains {
    /// The grid of a board; none where nothing asks for it. `sunk` says how far decay sinks the face at x and a place
    /// of the log [mm].
    pub fn grow(
        stream: Stream,
        wood: &Wood,
        trunk: &Trunk,
        growth: &Growth,
        knots: &[super::PlacedKnot],
        sunk: impl Fn(f32, &LogPoint) -> f32,
    ) -> Option<Self> {
        let (grain, anatomy) = (&wood.grain, &wood.anatomy);
        let counts = [anatomy.canals_per_mm2, anatomy.pores_per_mm2, anatomy.ray_share];
        let heights = [grain.torn_um, grain.fuzzy_um, wood.rot.loss_mm];
        if counts.iter().chain(&heights).all(|&number| number == 0.0) {
            return None;
        }
        let face = BoardFace::of(wood);
        let half = face.half + Vec2::new(face.edge_room, 0.0);
        let step = STEP_MM.max((4.0 * half.x * half.y / MOST_NODES).sqrt());
        let size = [half.x, half.y].map(|half| (2.0 * half / step).ceil() as usize + 2);
        let low = face.middle - half - 0.5 * step;
        let feed = if stream.child("feed").rng().random::<f32>() < 0.5 { -1.0 } else { 1.0 };
        let patches = Noise::new(stream.child("patches"));
        let (sin, cos) = libm::sincos(wood.log.turn_deg().to_radians());
        let limit = libm::sin(grain.torn_dive_deg.to_radians()) as f32;
        let node = |spot: Vec2, near: &[&super::PlacedKnot]| {
            let place = trunk.place(spot.x, spot.y, face.height);
            let near = near.iter().filter(|knot| knot.x[0] <= spot.x && spot.x <= knot.x[1]);
            let grown = growth.at(&place, near.map(|placed| &placed.knot));
            let fibre = trunk.vector(grown.fibre.truncate(), grown.fibre.z);
            // Upwards along the travel of the knives.
            let dive = fibre.z * (feed * fibre.y).signum();
            let outside = grown.branch.as_ref().map_or(1.0, |branch| smoothstep(0.95, 1.05, branch.x));
            let uneven = (1.0 + PATCHES * patches.plane(spot / PATCH_MM).0).max(0.0) * outside;
            let share = |dive: f32| uneven * smoothstep(DIVES[0] * limit, DIVES[1] * limit, dive);
            // Decay keeps out of knots, which stand in the sunk face.
            let sunk = sunk(spot.x, &place) * outside;
            [grown.t, grown.bundle, share(dive), share(dive.abs()), sunk, growth.bundles_around(place.r)]
        };
        let row = |j: usize| {
            let y = low.y + step * j as f32;
            let near: Vec<_> = knots.iter().filter(|knot| knot.y[0] <= y && y <= knot.y[1]).collect();
            (0..size[0]).map(|i| node(Vec2::new(low.x + step * i as f32, y), &near)).collect::<Vec<_>>()
        };
        let above = trunk.place(face.middle.x, face.middle.y, face.height).outward;
        Some(Self {
            low,
            step,
            nodes: (0..size[1]).flat_map(row).collect(),
            size,
            middle: face.middle,
            turn: Vec2::new(cos as f32, sin as f32),
            across: Vec2::new(above.y, above.x),
            torn: 1.0e-3 * grain.torn_um as f32,
            fuzzy: 1.0e-3 * grain.fuzzy_um as f32,
            strands: ["torn", "splinters", "fuzz"].map(|name| Noise::new(stream.child(name))),
        })
    }

    /// The grain at a spot of the face, and its changes along x and y by millimetre.
    #[inline]
    pub fn at(&self, spot: Vec2) -> (FaceGrain, [FaceGrain; 2]) {
        let q = (spot - self.low) / self.step;
        let (i, j) = ((q.x.max(0.0) as usize).min(self.size[0] - 2), (q.y.max(0.0) as usize).min(self.size[1] - 2));
        let (u, v) = ((q.x - i as f32).clamp(0.0, 1.0), (q.y - j as f32).clamp(0.0, 1.0));
        let at = j * self.size[0] + i;
        let [a, b, c, d] = [at, at + 1, at + self.size[0], at + self.size[0] + 1].map(|n| &self.nodes[n]);
        // Of numbers of bundles that are a turn apart the ones near to that of the nearest node.
        let main = [a, b, c, d][usize::from(u > 0.5) + 2 * usize::from(v > 0.5)][1];
        let near = |node: &[f32; 6]| {
            let (off, turn) = (main - node[1], node[5]);
            let bundle = if off.abs() > 0.5 * turn { node[1] + (off / turn).round() * turn } else { node[1] };
            [node[0], bundle, node[2], node[3], node[4]]
        };
        let [a, b, c, d] = [a, b, c, d].map(near);
        let value = |n: usize| (a[n] + u * (b[n] - a[n])) * (1.0 - v) + (c[n] + u * (d[n] - c[n])) * v;
        let along_x = |n: usize| ((b[n] - a[n]) * (1.0 - v) + (d[n] - c[n]) * v) / self.step;
        let along_y = |n: usize| ((c[n] - a[n]) * (1.0 - u) + (d[n] - b[n]) * u) / self.step;
        let off = spot - self.middle;
        let l = off.x * self.turn.y + off.y * self.turn.x;
        let grain = |n: &dyn Fn(usize) -> f32, l: f32| FaceGrain {
            t: n(0),
            bundle: n(1),
            l,
            torn: n(2),
            fuzzy: n(3),
            sunk: n(4),
        };
        (grain(&value, l), [grain(&along_x, self.turn.y), grain(&along_y, self.turn.x)])
    }

    /// How far the face is raised at most [mm]: both sizes of torn strands at the height where they are cut, and the
    /// highest fibres, in the patch that varies them most.
    pub fn relief(&self) -> f32 {
        (1.0 + PATCHES * PLANE_MOST) * (2.0 * TORN_PART * self.torn + FIBRES_MOST * self.fuzzy)
    }

    /// Whether decay has sunk the face somewhere.
    pub fn is_sunk(&self) -> bool {
        self.nodes.iter().any(|node| node[4] > 0.0)
    }

    /// The face with what is torn out of it, raised and sunk.
    #[inline]
    pub fn change(&self, face: Surface, spot: Vec2) -> Surface {
        let (here, by) = self.at(spot);
        let mut face =
            Surface { z: face.z - here.sunk, slope_x: face.slope_x - by[0].sunk, slope_y: face.slope_y - by[1].sunk };
        let across = |g: &FaceGrain| self.across.x * g.bundle + self.across.y * g.t;
        let mut add = |noise: Noise, size: Vec2, height: f32, share: f32, change: [f32; 2], is_torn: bool| {
            if share <= 0.0 || height == 0.0 {
                return;
            }
            let (mut n, mut slope) = noise.fibres(Vec2::new(across(&here), here.l) / size);
            if is_torn && n > 1.0 {
                // What stands too high is cut.
                (n, slope) = (1.0, Vec2::ZERO);
            }
            let slope = slope / size;
            let along = |g: &FaceGrain| slope.x * across(g) + slope.y * g.l;
            face.z += height * share * n;
            face.slope_x += height * (share * along(&by[0]) + change[0] * n);
            face.slope_y += height * (share * along(&by[1]) + change[1] * n);
        };
        let torn = [by[0].torn, by[1].torn];
        add(self.strands[0], TORN_MM[0], TORN_PART * self.torn, here.torn, torn, true);
        add(self.strands[1], TORN_MM[1], TORN_PART * self.torn, here.torn, torn, true);
        add(self.strands[2], FUZZY_MM, self.fuzzy, here.fuzzy, [by[0].fuzzy, by[1].fuzzy], false);
        face
    }

    /// Dispersion [deg] and gloss [1] of grain that is torn or fuzzy here.
    #[inline]
    pub fn disorder(&self, here: &FaceGrain, dispersion_deg: f32, gloss: f32) -> (f32, f32) {
        let fuzzy = if self.fuzzy > 0.0 { here.fuzzy.min(1.0) } else { 0.0 };
        let torn = if self.torn > 0.0 { here.torn.min(1.0) } else { 0.0 };
        let most = MOST_DISPERSION_DEG.max(dispersion_deg);
        ((dispersion_deg + FUZZY_DISPERSION_DEG * fuzzy).min(most), gloss * (1.0 - DULL * fuzzy.max(torn)))
    }

    /// The place for cells: across, outwards and along [mm].
    #[inline]
    pub fn cell(here: &FaceGrain) -> Vec3 {
        Vec3::new(here.bundle, here.t, here.l)
    }
}
