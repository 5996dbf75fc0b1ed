//! Tablets into pockets: whose they are, how they lie, and what they have lost.
//!
//! Models: one tablet a pocket, none, or a second one flat on the first; another product; the right one with the wrong
//! coat. Film is formed deeper where what lies in a pocket would not have room, as a press does with a double.

use base::{Class, Gloss, Medium, Stream, normal};
use glam::{Mat3, Vec2, Vec3};
use rand::RngExt;

use super::card_placement::CardPlacement;
use super::damage::{Damage, damage};
use super::pack_point::TabletDamage;
use super::parameters::{Blister, Tablet};
use super::plan::{self, PlannedDefect, graded};
use super::pose::{DrawnPose, Pose, TabletRoom};
use super::solid::{CutPlane, Solid};
use super::tablet::{self, TabletForm};
use super::{Pack, flange};

/// Least distance of a tablet from the film [mm].
const MARGIN_MM: f32 = 0.01;
/// Least distance of a tablet from a steep wall beside it [mm].
pub const BESIDE_MM: f32 = 0.06;
/// Distance between columns that the pose is checked at [mm].
const COLUMN_MM: f32 = 0.25;
/// Film that is closer than this is looked at more closely [mm].
const CLOSE_MM: f32 = 0.15;
/// Depth of a pocket that is barely too shallow, and of the worst, over the full depth [1].
pub const SHALLOW: [f32; 2] = [0.85, 0.3];
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

/// Another product that is no larger: its form and what it is made of.
fn other_product(tablet: &Tablet, severity: f32) -> (TabletForm, Medium) {
    let (long, short) = (tablet.length_mm.max(tablet.width_mm), tablet.length_mm.min(tablet.width_mm));
    let size = f64::from(graded(severity, 1.0, 0.75));
    let mut other = *tablet;
    if long < 1.15 * short {
        (other.shape, other.length_mm, other.width_mm) = (1.0, 0.95 * size * long, 0.6 * size * long);
    } else {
        (other.shape, other.length_mm, other.width_mm) = (0.0, 0.95 * size * short, 0.95 * size * short);
    }
    other.thickness_mm = 0.9 * size * if tablet.shape >= 1.5 { short } else { tablet.thickness_mm };
    other.band_mm = 0.6 * other.thickness_mm;
    other.coat *= f64::from(graded(severity, 0.9, 0.4));
    (TabletForm::new(&other), tablet::medium(&other))
}

impl Pack {
    /// Lays the tablets of a pocket, and does to them and to the film what was planned.
    pub(super) fn fill(
        &mut self,
        stream: Stream,
        blister: &Blister,
        cell: usize,
        form: &TabletForm,
        probes: &[Vec3],
        plan: &[PlannedDefect],
    ) {
        let mine = || plan.iter().filter(move |p| p.cell == cell);
        let of_whole = mine().find(|p| plan::whole(p.class));
        let class = self.instances[cell].class;
        let wish = wish(stream.child("pose").index(cell as u64), blister, form);
        let swept =
            |p: &PlannedDefect| p.class == Class::Shallow && p.stream.child("swept").rng().random::<f32>() < 0.5;
        if of_whole.is_some_and(swept) {
            // Not formed deep enough for its tablet, which is not there.
            self.instances[cell].state = Class::Missing;
        }
        let mut short = None;
        if class != Class::Missing && !of_whole.is_some_and(swept) {
            let severity = of_whole.map_or(0.0, |p| p.severity);
            let (own, medium) = match class {
                Class::ForeignTablet => other_product(&blister.tablet, severity),
                Class::WrongCoat => {
                    let medium = tablet::medium(&blister.tablet);
                    let mu_a = medium.mu_a * graded(severity, 1.5, 20.0);
                    (*form, Medium { mu_a, coat: medium.coat * graded(severity, 0.95, 0.3), ..medium })
                }
                _ => (*form, tablet::medium(&blister.tablet)),
            };
            let foreign = (class == Class::ForeignTablet).then(|| own.probes());
            let probes = foreign.as_deref().unwrap_or(probes);
            let floor = self.web.foil_mm + self.slack;
            let pose = self.settle(cell, &own, probes, wish, floor);
            short = Some(own.outline().half().y);
            let damaged = mine().find(|p| plan::damage(p.class));
            let up = if wish.flipped { -1.0 } else { 1.0 };
            self.lay_tablet(cell, &own, &pose, medium, damaged.map(|p| (p, damage(&own, p, up))));
            if class == Class::Double {
                // The second one lies flat on the first.
                let floor = pose.middle.z + own.support(pose.turn, Vec3::Z) + self.slack;
                let second = self.settle(cell, &own, probes, DrawnPose::FLAT, floor);
                self.lay_tablet(cell, &own, &second, medium, None);
            }
            if class == Class::Shallow {
                let depth = self.web.cells[cell].factor;
                let real = (SHALLOW[0] - depth) / (SHALLOW[0] - SHALLOW[1]);
                self.instances[cell].severity = f64::from(real.clamp(0.0, 1.0));
            }
        }
        let marks = [Class::Collapsed, Class::Punctured, Class::Pinhole, Class::Channel];
        for planned in mine().filter(|p| marks.contains(&p.class)) {
            let number = self.instances.len() as u16 + 1;
            let tablet = self.contents[cell].first().map(|&n| &self.solids[n]).zip(short);
            let mark = flange::in_pocket(self, planned, number, tablet);
            let size = 2.0 * mark.outline.half().x;
            self.enter(planned.class, cell as u16 + 1, mark.middle, size, planned.severity);
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
        let id = self.enter(planned.class, cell as u16 + 1, pose.middle.truncate(), size, planned.severity);
        self.wounds[cell] = Some(TabletDamage { whole, lost: damage.lost, label: (planned.class, id) });
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
