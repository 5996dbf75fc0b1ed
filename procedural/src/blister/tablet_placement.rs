//! Tablets into pockets: how they lie, and what they have lost.
//!
//! Models: film is formed deeper where what lies in a pocket would not have room, as a press does with two tablets.

use base::{Class, Gloss, Medium, Stream, normal};
use glam::{Mat3, Vec2, Vec3};
use rand::RngExt;

use super::card_placement::CardPlacement;
use super::defects::content::{PocketContent, shallowness};
use super::defects::damage::{Damage, DamageDraw};
use super::defects::film::MarkDraw;
use super::defects::{DefectOf, PlannedDefect};
use super::pack_point::TabletDamage;
use super::parameters::Tablet;
use super::pose::{DrawnPose, Pose, TabletRoom};
use super::solid::{CutPlane, Solid};
use super::tablet::TabletForm;
use super::{Blister, Pack};

/// Least distance of a tablet from the film [mm].
const MARGIN_MM: f32 = 0.01;
/// Least distance of a tablet from a steep wall beside it [mm].
pub const BESIDE_MM: f32 = 0.06;
/// Distance between columns that the pose is checked at [mm].
const COLUMN_MM: f32 = 0.25;
/// Film that is closer than this is looked at more closely [mm].
const CLOSE_MM: f32 = 0.15;
/// How much deeper the film is formed at a time where something has no room [1].
const DEEPER: f32 = 1.03;

/// Most that a pocket may be formed deeper than its form, for one tablet or for two [1].
///
/// The form has room for a tablet with `spare` to lose, least of it over the tablet's rim; so film that is
/// (floor + rim + spare) / rim times as deep has room for one that lies on `floor`. The first of two may stand as high
/// as the film, or as it is long.
pub fn deepest(form: &TabletForm, depth: f32, spare: f32, double: bool) -> f32 {
    let rim = form.top_mm(0.0);
    let half = form.outline().half();
    let long = (4.0 * half.x * half.x + form.thickness_mm() * form.thickness_mm()).sqrt();
    let floor = if double { depth.min(long) } else { 0.0 };
    DEEPER * (floor + rim + spare + CLOSE_MM) / rim
}

/// Draws the pose of a tablet.
fn wish(stream: Stream, blister: &Blister, form: &TabletForm) -> DrawnPose {
    let Tablet { tilt_deg, rattle, on_edge, .. } = blister.tablet;
    let mut rng = stream.rng();
    let mut even = || rng.random::<f64>();
    let (yaw, about, flipped, edge) = (even(), even(), even() < 0.5, even() < on_edge);
    let (far, way) = (rattle * even().sqrt() * blister.pocket.clearance_mm, std::f64::consts::TAU * even());
    let (sine, cosine) = libm::sincos(way);
    // Round tablets turn freely, long ones as far as their ends have room.
    let half = form.outline().half();
    let play = if half.x == half.y { std::f64::consts::PI } else { 2.0 * far / f64::from(half.x) };
    let tilt = normal(&mut stream.child("tilt").rng()) * tilt_deg.to_radians();
    DrawnPose {
        yaw: (2.0 * play * (yaw - 0.5)) as f32,
        tilt: tilt as f32,
        about: (std::f64::consts::TAU * about) as f32,
        offset: Vec2::new((far * cosine) as f32, (far * sine) as f32),
        flipped,
        on_edge: edge,
    }
}

/// A posed tablet, or a piece of it, as a solid on the conveyor.
fn solid(
    lay: &CardPlacement,
    form: &TabletForm,
    pose: &Pose,
    cuts: Vec<CutPlane>,
    medium: Medium,
    class: Class,
) -> Solid {
    let (tangent, origin) = lay.tangent(pose.middle.truncate());
    let linear = tangent * pose.turn * Mat3::from_diagonal(form.scale);
    let mut solid = Solid::new(form.shape, cuts, linear, origin + Vec3::Z * pose.middle.z, medium, class, 0);
    solid.marked = class != Class::ForeignTablet && !form.is_capsule();
    solid
}

impl Pack {
    /// Lays the tablets of a pocket, and does to them and to the film what was planned.
    pub(super) fn fill(
        &mut self,
        stream: Stream,
        blister: &Blister,
        cell: usize,
        form: &TabletForm,
        content: &PocketContent,
        plan: &[PlannedDefect],
    ) {
        let mine = || plan.iter().filter(move |p| p.cell == cell);
        let mut short = None;
        if content.tablets == 0 {
            self.instances[cell].state = Class::Missing;
        } else {
            let wish = wish(stream.child("pose").index(cell as u64), blister, form);
            let PocketContent { form: own, medium, .. } = content;
            let probes = own.probes();
            let mut pose = self.settle(cell, own, &probes, wish, self.web.foil_mm + self.slack);
            short = Some(own.outline().half().y);
            let up = if wish.flipped { -1.0 } else { 1.0 };
            let damaged = mine().find_map(|p| match p.kind.of {
                DefectOf::Tablet(damage) => Some((p, damage(&DamageDraw::new(own, p, up)))),
                _ => None,
            });
            self.lay_tablet(cell, own, &pose, *medium, damaged);
            for _ in 1..content.tablets {
                // A further one lies flat on the one before.
                let floor = pose.middle.z + own.support(pose.turn, Vec3::Z) + self.slack;
                pose = self.settle(cell, own, &probes, DrawnPose::FLAT, floor);
                self.lay_tablet(cell, own, &pose, *medium, None);
            }
            if content.depth < 1.0 {
                self.instances[cell].severity = f64::from(shallowness(self.web.cells[cell].factor));
            }
        }
        for planned in mine() {
            let DefectOf::Film(make) = planned.kind.of else { continue };
            let tablet = self.contents[cell].first().map(|&n| &self.solids[n]).zip(short);
            let mark = make(&mut MarkDraw::new(self, planned, self.next_id(), tablet));
            self.enter_in(planned, mark.middle, 2.0 * mark.outline.half().x, planned.severity);
            self.draw(mark);
        }
    }

    /// Adds a tablet as one solid, or as what is left of it.
    pub(super) fn lay_tablet(
        &mut self,
        cell: usize,
        form: &TabletForm,
        pose: &Pose,
        medium: Medium,
        damaged: Option<(&PlannedDefect, Damage)>,
    ) {
        let class = self.instances[cell].class;
        let make = |cuts: Vec<CutPlane>| solid(&self.lay, form, pose, cuts, medium, class);
        let Some((planned, damage)) = damaged else {
            let solid = make(Vec::new());
            return self.add(cell, solid);
        };
        let (whole, pieces) = (make(Vec::new()), damage.pieces.into_iter().map(&make).collect::<Vec<_>>());
        pieces.into_iter().for_each(|piece| self.add(cell, piece));
        let size = 2.0 * form.outline().half().x;
        let id = self.enter_in(planned, pose.middle.truncate(), size, planned.severity);
        self.wounds[cell] = Some(TabletDamage { whole, lost: damage.lost, label: (planned.kind.class, id) });
    }

    pub(super) fn add(&mut self, cell: usize, solid: Solid) {
        self.contents[cell].push(self.solids.len());
        self.solids.push(solid);
    }

    /// Lays a tablet in a pocket on that level; where not even a flat one has room, the film is formed deeper until it
    /// has.
    fn settle(&mut self, cell: usize, form: &TabletForm, probes: &[Vec3], wish: DrawnPose, floor: f32) -> Pose {
        let mut more = 0.0;
        loop {
            let (web, lay, middle) = (&self.web, &self.lay, self.web.cells[cell].middle);
            let ceiling = |p: Vec2| {
                let leaf = web.leaf(p, Some(cell));
                leaf.low(lay.warp(p).1) - BESIDE_MM * leaf.slope.length()
            };
            let margin = MARGIN_MM + self.slack + more;
            let cavity = TabletRoom { middle, axis: web.formed.axis, floor, ceiling: &ceiling, margin };
            if let Some(pose) = cavity.settle(form, probes, wish) {
                // Bumps between the probes take what the probes must then keep in addition.
                let room = room(form, &pose, &ceiling) - self.slack;
                if room > 0.5 * MARGIN_MM {
                    return pose;
                }
                more += MARGIN_MM - room;
            } else {
                self.web.deepen(cell, DEEPER * self.web.cells[cell].factor);
            }
        }
    }
}

/// Least distance between the upper side of a tablet and the film over it, column by column [mm].
fn room(form: &TabletForm, pose: &Pose, ceiling: &dyn Fn(Vec2) -> f32) -> f32 {
    let linear = pose.turn * Mat3::from_diagonal(form.scale);
    let solid = Solid::new(form.shape, Vec::new(), linear, pose.middle, Medium::opaque(Gloss::NONE), Class::Pocket, 0);
    let gap = |p: Vec2| solid.column(p.x, p.y).map_or(f32::INFINITY, |[_, top]| ceiling(p) - top);
    let mut least = f32::INFINITY;
    for (p, [_, top]) in solid.columns(COLUMN_MM) {
        let room = ceiling(p) - top;
        least = least.min(room);
        if room < CLOSE_MM {
            // A crevice may pass between the columns.
            let steps = (0..9).map(|k| Vec2::new((k % 3) as f32 - 1.0, (k / 3) as f32 - 1.0) * (COLUMN_MM / 3.0));
            least = steps.map(|step| gap(p + step)).fold(least, f32::min);
        }
    }
    least
}
