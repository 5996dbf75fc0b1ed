//! A board in its stem: where it lies, which branches come near, and what of them its upper face shows.
//!
//! Models: the board is sawn along the stem's heights. The middle of its upper face lies `board_radius_mm` from the
//! pith at the azimuth `board_azimuth_deg`, and its normal is turned by `face_deg` against that direction. With alpha
//! the azimuth of the normal, the log's axes are
//!
//! ```text
//! upwards = (cos alpha, sin alpha),  sideways = (-sin alpha, cos alpha),  along = height
//! ```
//!
//! The log keeps its turn and its dive against the board (`log`), and every branch its own numbers. The upper face is
//! asked where a branch shows: the axis crosses it, or the outline does at a point of a grid within the height of
//! ripple and roughness. Sources: geometry. Limits: parts of an outline smaller than the grid may lie in the face
//! without an instance; their label is clear wood. The dive against the board shears the sections, as in `pith`.

use std::sync::Arc;

use base::{Class, Instance, Stream};
use glam::{Vec2, Vec3};

use super::Stem;
use super::branch::StemBranch;
use super::cut::{AZIMUTHS, SECTION_MM, StemCut};
use super::layers::Layers;
use super::oval::Oval;
use crate::wood::Wood;
use crate::wood::bulge::{ASPECT, REACH};
use crate::wood::growth::Growth;
use crate::wood::knot::{Knot, KnotDistance, KnotDraw};
use crate::wood::knot_placement::{PlacedKnot, half_size};
use crate::wood::pith::{LogPoint, PithNode, Trunk, zenith};

/// The pith is known this far beyond the board [mm], more than branches lean on their way to it.
const MARGIN_MM: f32 = 150.0;
/// Distance between two points of an axis that are looked at [mm].
const STEP_MM: f32 = 1.0;
/// Room for the outline's wobble [1].
const WOBBLE_ROOM: f32 = 1.12;
/// Step of the grid on the face over a branch's half width [1], and its least and most [mm].
const GRID: [f32; 3] = [0.15, 0.2, 1.0];
/// Most points of the grid across and along.
const GRID_POINTS: f32 = 200.0;

/// Where a board lies in its stem.
#[derive(Debug, Clone)]
pub(in crate::wood) struct Sawing {
    /// The log of the board.
    pub trunk: Trunk,
    /// Height of the board's middle [mm].
    pub(super) along: f64,
    /// Azimuth in the stem of the log's azimuth 0 [rad].
    pub(super) azimuth: f64,
}

/// A point of a branch's axis in the board's frame.
#[derive(Debug, Clone, Copy)]
struct AxisPoint {
    r: f32,
    half_width: f32,
    place: Vec3,
}

impl Sawing {
    /// The place of the board in a stem.
    pub fn new(wood: &Wood, stem: &Stem) -> Self {
        let (board, lies) = (&wood.board, &wood.stem);
        let half = 0.5 * board.length_mm;
        let [low, high] = stem.ends_mm();
        let along = if high - low > 2.0 * half {
            (low + lies.board_along_mm).clamp(low + half, high - half)
        } else {
            0.5 * (low + high)
        };
        let turn = lies.face_deg.to_radians();
        let normal = lies.board_azimuth_deg.to_radians() + turn;
        let (turn_sin, turn_cos) = libm::sincos(turn);
        // Seen from the pith the face's middle lies at the azimuth -turn against the face's normal.
        let straight = Vec2::new(
            (lies.board_radius_mm * turn_sin) as f32,
            (board.thickness_mm - lies.board_radius_mm * turn_cos) as f32,
        );
        let dive = libm::tan(wood.log.pith_tilt_deg.to_radians()) as f32;
        let (sin, cos) = libm::sincos(normal);
        let into = |v: [f64; 2]| Vec2::new((v[1] * cos - v[0] * sin) as f32, (v[0] * cos + v[1] * sin) as f32);
        let origin = stem.pith_mm(along);
        let trunk = Trunk::along(wood, MARGIN_MM, straight, |l| {
            let (place, slope) = stem.pith.at(along + f64::from(l));
            let away = into([place[0] - origin[0], place[1] - origin[1]]);
            PithNode { place: straight + away - Vec2::new(0.0, dive * l), slope: into(slope) - Vec2::new(0.0, dive) }
        });
        let half = half_size(wood).length() + 10.0;
        let reach = trunk.reach(half_size(wood), board.thickness_mm as f32);
        let layers = Layers::new(half, reach, |l| {
            let place = stem.pith_mm(along + f64::from(l));
            into([place[0] - origin[0], place[1] - origin[1]])
        });
        let zenith = zenith(wood, straight);
        let azimuth = normal + f64::from(libm::atan2f(zenith.x, zenith.y));
        let share = lies.rings_follow_outline as f32;
        if share == 0.0 {
            return Self { trunk: trunk.with_layers(Arc::new(layers)), along, azimuth };
        }
        let sawing = Self { trunk, along, azimuth };
        let aside = Vec2::new(zenith.y, -zenith.x);
        let oval = Oval::new(&sawing.cut(wood, stem), share, stem.mean_radius_mm() as f32, |r, phi, l| {
            let (sin, cos) = libm::sincosf(phi);
            layers.at(&LogPoint { r, phi, l, outward: cos * zenith + sin * aside, pith_slope: Vec2::ZERO }).t
        });
        let trunk = sawing.trunk.with_layers(Arc::new(layers.following(oval)));
        Self { trunk, along, azimuth }
    }

    /// The stem's outline around the board.
    pub fn cut(&self, wood: &Wood, stem: &Stem) -> StemCut {
        let reach = half_size(wood).length() + SECTION_MM;
        let count = (2.0 * reach / SECTION_MM).ceil() as usize + 2;
        let radii = (0..count).map(|row| {
            let height = self.along + f64::from(row as f32 * SECTION_MM - reach);
            std::array::from_fn(|column| {
                let phi = std::f64::consts::TAU * column as f64 / AZIMUTHS as f64;
                stem.radius_mm(self.azimuth + phi, height) as f32
            })
        });
        StemCut { start: -reach, radii: radii.collect() }
    }

    /// The branches that disturb the board, with the numbers of those that the upper face shows, in their order along
    /// it; `relief` is how far ripple and roughness leave the face [mm].
    pub fn knots(&self, stream: Stream, wood: &Wood, stem: &Stem, growth: &Growth, relief: f32) -> Vec<PlacedKnot> {
        let near = stem.branches().iter().enumerate().filter_map(|(index, branch)| {
            let draw = KnotDraw::new(stream.index(index as u64), &wood.knots);
            self.near(wood, branch, &draw)
        });
        let mut placed: Vec<PlacedKnot> = near.collect();
        for (index, knot) in placed.iter_mut().enumerate() {
            // Numbers by which the face can tell them apart.
            knot.knot.id = index as u16 + 1;
        }
        let shown: Vec<Option<Instance>> = (0..placed.len())
            .map(|index| {
                self.crossing(wood, &placed[index].knot).or_else(|| self.glimpse(wood, &placed, index, growth, relief))
            })
            .collect();
        let mut order: Vec<usize> = (0..placed.len()).filter(|&index| shown[index].is_some()).collect();
        order.sort_by(|&a, &b| {
            let key = |index: usize| shown[index].map_or((0.0, 0.0), |instance| (instance.y_mm, instance.x_mm));
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        for (index, knot) in placed.iter_mut().enumerate() {
            let id = order.iter().position(|&other| other == index).map_or(0, |rank| rank as u16 + 1);
            knot.instance = shown[index].map(|instance| Instance { id, ..instance });
            knot.knot.id = id;
            // What the face does not show has no label.
            knot.knot.class = knot.instance.map_or(Class::Clear, |instance| instance.class);
        }
        placed.sort_by_key(|knot| (knot.knot.id == 0, knot.knot.id));
        placed
    }

    /// The branch with its room, if that meets the board.
    fn near(&self, wood: &Wood, branch: &StemBranch, draw: &KnotDraw) -> Option<PlacedKnot> {
        let thickness = wood.board.thickness_mm as f32;
        let bark = if branch.death_mm.is_finite() { wood.knots.bark_mm as f32 } else { 0.0 };
        let at = |r: f64| Knot::of_branch(branch, self.along, self.azimuth, r, bark, draw);
        let knot = at(f64::from(STEP_MM));
        let axis = self.axis(wood, &knot);
        let in_board = |p: &&AxisPoint| {
            let room = REACH * p.half_width + 2.0 * STEP_MM;
            p.place.z > -room && p.place.z < thickness + room
        };
        let off_face = |p: &AxisPoint| (p.place.z - thickness).abs();
        // The slope counts where the face is nearest.
        let nearest = axis.iter().filter(in_board).min_by(|a, b| off_face(a).total_cmp(&off_face(b)))?;
        let knot = at(f64::from(nearest.r.min(knot.end)));
        let turn = wood.log.turn_deg().to_radians();
        let (sin, cos) = (libm::sin(turn).abs() as f32, libm::cos(turn).abs() as f32);
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for p in axis.iter().filter(in_board) {
            let across = REACH * p.half_width;
            let along = ASPECT * across / knot.cos_slope;
            // Between two points the axis leans no further than the slope says.
            let slope = knot.section(&KnotDistance::new(p.r)).slope.abs();
            let step = STEP_MM * Vec2::new(2.0, 1.0 + slope);
            let room = Vec2::new(cos * across + sin * along, cos * along + sin * across)
                + Vec2::new(cos * step.x + sin * step.y, cos * step.y + sin * step.x);
            (low, high) = (low.min(p.place.truncate() - room), high.max(p.place.truncate() + room));
        }
        let (from, to) = face(wood);
        let meets = low.cmplt(to).all() && high.cmpgt(from).all();
        meets.then_some(PlacedKnot { knot, x: [low.x, high.x], y: [low.y, high.y], instance: None })
    }

    /// Points of a branch's axis from the pith to where it is gone or beyond the board.
    fn axis(&self, wood: &Wood, knot: &Knot) -> Vec<AxisPoint> {
        let reach = self.trunk.reach(half_size(wood), wood.board.thickness_mm as f32) + MARGIN_MM;
        let count = (reach.min(knot.gone()) / STEP_MM).ceil() as usize;
        let points = (1..=count).map(|i| {
            let r = i as f32 * STEP_MM;
            let section = knot.section(&KnotDistance::new(r));
            AxisPoint { r, half_width: section.half_width, place: self.trunk.point(r, section.phi, section.l) }
        });
        points.collect()
    }

    /// The numbers of a knot whose axis crosses the upper face within the board.
    fn crossing(&self, wood: &Wood, knot: &Knot) -> Option<Instance> {
        let thickness = wood.board.thickness_mm as f32;
        let point = |r: f32| {
            let section = knot.section(&KnotDistance::new(r));
            self.trunk.point(r, section.phi, section.l)
        };
        let (from, to) = face(wood);
        let axis = self.axis(wood, knot);
        axis.windows(2).find_map(|pair| {
            let above = |z: f32| z >= thickness;
            if above(pair[0].place.z) == above(pair[1].place.z) {
                return None;
            }
            let (mut low, mut high) = (pair[0].r, pair[1].r);
            for _ in 0..20 {
                let middle = 0.5 * (low + high);
                if above(point(middle).z) == above(pair[0].place.z) { low = middle } else { high = middle }
            }
            let r = 0.5 * (low + high);
            let place = point(r).truncate();
            let inside = place.cmpge(from).all() && place.cmple(to).all();
            (inside && r < knot.end).then(|| self.instance(knot, place, thickness))
        })
    }

    /// The numbers of a knot whose outline shows in the upper face, though its axis does not cross it: where most of it
    /// shows.
    fn glimpse(
        &self,
        wood: &Wood,
        placed: &[PlacedKnot],
        index: usize,
        growth: &Growth,
        relief: f32,
    ) -> Option<Instance> {
        let thickness = wood.board.thickness_mm as f32;
        let knot = &placed[index].knot;
        let (mut low, mut high, mut widest) = (Vec2::INFINITY, Vec2::NEG_INFINITY, 0.0f32);
        for p in self.axis(wood, knot).iter().take_while(|p| p.r < knot.end + STEP_MM) {
            let round = WOBBLE_ROOM * p.half_width;
            let room = round / knot.cos_slope + 2.0 * STEP_MM;
            if (p.place.z - thickness).abs() < round + relief + 2.0 * STEP_MM {
                (low, high) = (low.min(p.place.truncate() - room), high.max(p.place.truncate() + room));
                widest = widest.max(p.half_width);
            }
        }
        let (from, to) = face(wood);
        let (low, high) = (low.max(from), high.min(to));
        if low.cmpge(high).any() {
            return None;
        }
        let extent = high - low;
        let step = (GRID[0] * widest).clamp(GRID[1], GRID[2]).max(extent.max_element() / GRID_POINTS);
        let count = (extent / step).ceil();
        let mut shown: Vec<Vec2> = Vec::new();
        // The face itself first: beside it the outline may show on ridges or in furrows alone.
        for z in [0.0, relief, -relief].map(|off| thickness + off) {
            for j in 0..count.y as usize {
                let y = low.y + (j as f32 + 0.5) * extent.y / count.y;
                for i in 0..count.x as usize {
                    let x = low.x + (i as f32 + 0.5) * extent.x / count.x;
                    let place = self.trunk.place(x, y, z);
                    // Only where its own outline reaches can it be the nearest.
                    let alone = growth.at(&place, std::iter::once(knot));
                    if alone.branch.is_none_or(|branch| branch.x >= 1.0) {
                        continue;
                    }
                    let near = placed
                        .iter()
                        .filter(|other| other.x[0] <= x && x <= other.x[1] && other.y[0] <= y && y <= other.y[1]);
                    let all = growth.at(&place, near.map(|other| &other.knot));
                    if all.branch.is_some_and(|branch| branch.knot.id == knot.id) {
                        shown.push(Vec2::new(x, y));
                    }
                }
            }
            if !shown.is_empty() {
                break;
            }
        }
        let middle = shown.iter().sum::<Vec2>() / shown.len().max(1) as f32;
        let off = |p: &Vec2| p.distance_squared(middle);
        let centre = shown.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
        Some(self.instance(knot, *centre, thickness))
    }

    /// The numbers of a knot with its centre at a place of the face.
    fn instance(&self, knot: &Knot, centre: Vec2, thickness: f32) -> Instance {
        let place = self.trunk.place(centre.x, centre.y, thickness);
        let section = knot.section(&KnotDistance::new(place.r));
        let across = place.outward + section.turn * place.around() + section.slope * place.pith_slope;
        let axis = self.trunk.vector(across, section.slope).normalize();
        let dead = place.r >= knot.death;
        let class = if dead { Class::DeadKnot } else { Class::SoundKnot };
        let diameter_mm = 2.0 * f64::from(section.half_width * knot.tip(place.r));
        Instance {
            dive_deg: f64::from(libm::asinf(axis.z.abs().min(1.0)).to_degrees()),
            death_radius_mm: if dead { f64::from(knot.death) } else { f64::NAN },
            ..Instance::new(0, class, centre.as_dvec2().to_array(), diameter_mm, f64::NAN)
        }
    }
}

/// Corners of the upper face [mm].
fn face(wood: &Wood) -> (Vec2, Vec2) {
    let board = &wood.board;
    let middle = Vec2::new(board.offset_mm as f32, (board.lead_in_mm + 0.5 * board.length_mm) as f32);
    (middle - half_size(wood), middle + half_size(wood))
}
