//! What a broken, chipped, capped or cracked tablet has lost.
//!
//! Models: plane cuts. The plane of a break or a chip is moved until the volume beyond it is the asked share of the
//! whole. A cap is lost at an asked depth, with hard capsules the one of their two shells; a crack is a slab of the
//! asked width without matter, its halves unmoved. Neglected: rough faces of fracture, and that they lack the coat; a
//! broken tablet lies as the whole one would.

use glam::Vec3;
use rand::RngExt;

use super::{PlannedDefect, graded};
use crate::blister::solid::CutPlane;
use crate::blister::tablet::TabletForm;

/// Tablets that are this much longer than wide break across [1].
const SLENDER: f32 = 1.3;
/// Columns across a tablet that measure volumes.
const COLUMNS: usize = 160;

/// A damaged tablet: the pieces that are left, and what tells the place of what is not.
#[derive(Debug, Clone)]
pub struct Damage {
    /// Cuts of each piece.
    pub pieces: Vec<Vec<CutPlane>>,
    /// Places beyond all of these, in the shape's coordinates, are lost.
    pub lost: Vec<CutPlane>,
}

/// A plane in the tablet's own coordinates, as a cut of its shape.
fn cut(form: &TabletForm, normal: Vec3, limit: f32) -> CutPlane {
    let scaled = normal * form.scale;
    let length = scaled.length();
    CutPlane { normal: scaled / length, limit: limit / length }
}

/// Upright columns of a tablet: place and half the height [mm].
fn columns(form: &TabletForm) -> Vec<Vec3> {
    let half = form.outline().half();
    let step = |i: usize| (2 * i + 1) as f32 / COLUMNS as f32 - 1.0;
    let mut columns = Vec::with_capacity(COLUMNS * COLUMNS);
    for j in 0..COLUMNS {
        for i in 0..COLUMNS {
            let (x, y) = (half.x * step(i), half.y * step(j));
            let own = x / form.scale.x;
            let beyond = own - own.clamp(-form.shape.segment, form.shape.segment);
            let distance = (beyond * beyond + y * y).sqrt();
            if distance < form.shape.radius {
                columns.push(Vec3::new(x, y, form.shape.top(distance)));
            }
        }
    }
    columns
}

/// Share of the volume beyond the plane `normal . p = limit` [1].
fn beyond(columns: &[Vec3], normal: Vec3, limit: f32) -> f64 {
    let (mut lost, mut all) = (0.0_f64, 0.0_f64);
    for c in columns {
        let room = limit - normal.x * c.x - normal.y * c.y;
        let share = if normal.z.abs() < 1.0e-4 {
            f32::from(room < 0.0)
        } else {
            // The part of [-h, h] with z n_z > room.
            (0.5 - 0.5 * room / (normal.z.abs() * c.z)).clamp(0.0, 1.0)
        };
        all += f64::from(c.z);
        lost += f64::from(c.z * share);
    }
    lost / all
}

/// Where the plane with that normal leaves that share of the volume beyond it [mm].
fn plane(form: &TabletForm, normal: Vec3, share: f32) -> f32 {
    let columns = columns(form);
    let reach = form.shape.support(form.scale * normal);
    let (mut low, mut high) = (-reach, reach);
    for _ in 0..26 {
        let middle = 0.5 * (low + high);
        if beyond(&columns, normal, middle) > f64::from(share) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The numbers that all damages draw.
#[derive(Debug)]
pub struct DamageDraw<'a> {
    form: &'a TabletForm,
    severity: f32,
    /// Level direction of what is lost [1].
    across: Vec3,
    /// How far the cut leans, of 1 [1].
    lean: f32,
    /// Sign of the face that lies up.
    up: f32,
}

impl<'a> DamageDraw<'a> {
    /// Of a planned damage; `up` is the sign of the face that lies up.
    pub fn new(form: &'a TabletForm, planned: &PlannedDefect, up: f32) -> Self {
        let mut rng = planned.stream.child("damage").rng();
        let mut even = || rng.random::<f32>();
        let half = form.outline().half();
        // Long tablets break across: within a quarter of a right angle of their long axis.
        let turn = if half.x > SLENDER * half.y { 0.25 * (even() - 0.5) } else { even() };
        let (sine, cosine) = libm::sincosf(std::f32::consts::TAU * turn);
        let across = Vec3::new(cosine, sine, 0.0) * if even() < 0.5 { -1.0 } else { 1.0 };
        Self { form, severity: planned.severity, across, lean: even(), up }
    }

    /// What one cut leaves: all but what lies beyond `limit` along `normal`.
    fn one(&self, normal: Vec3, limit: f32) -> Damage {
        let cut = cut(self.form, normal, limit);
        Damage { pieces: vec![vec![cut]], lost: vec![CutPlane { normal: -cut.normal, limit: -cut.limit }] }
    }

    /// What a cut leaves that takes this share of the volume.
    fn share(&self, normal: Vec3, share: f32) -> Damage {
        self.one(normal, plane(self.form, normal, share))
    }
}

/// A part broken off.
pub fn broken(draw: &DamageDraw) -> Damage {
    let normal = (draw.across + Vec3::Z * (0.5 * draw.lean - 0.25)).normalize();
    draw.share(normal, graded(draw.severity, 0.2, 0.8))
}

/// A chip off an edge of the upper face.
pub fn chipped(draw: &DamageDraw) -> Damage {
    let normal = (draw.across + Vec3::Z * draw.up * (0.3 + 0.7 * draw.lean)).normalize();
    draw.share(normal, graded(draw.severity, 0.01, 0.1))
}

/// A cap lost, or a shell of a hard capsule.
pub fn capped(draw: &DamageDraw) -> Damage {
    let form = draw.form;
    if form.is_capsule() {
        let half = form.outline().half().x;
        let depth = graded(draw.severity, 0.25, 0.5) * 2.0 * half;
        return draw.one(Vec3::X * draw.across.x.signum(), half - depth);
    }
    let depth = graded(draw.severity, 0.1, 0.4) * form.thickness_mm();
    draw.one(Vec3::Z * draw.up, 0.5 * form.thickness_mm() - depth)
}

/// A gap from side to side.
pub fn cracked(draw: &DamageDraw) -> Damage {
    let gap = 0.5 * graded(draw.severity, 0.1, 0.4);
    let middle = 0.4 * (draw.lean - 0.5) * draw.form.outline().half().y;
    let sides = [cut(draw.form, draw.across, middle - gap), cut(draw.form, -draw.across, -middle - gap)];
    let lost = sides.map(|c| CutPlane { normal: -c.normal, limit: -c.limit });
    Damage { pieces: sides.map(|c| vec![c]).to_vec(), lost: lost.to_vec() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blister::defects::KINDS;
    use crate::blister::parameters::Tablet;
    use base::Stream;

    #[test]
    fn planes_take_the_asked_share_of_a_tablet() {
        let mut tablet = Tablet::from_values(&mut |p| p.default);
        for shape in 0..3 {
            tablet.shape = f64::from(shape);
            tablet.length_mm = 15.0;
            tablet.width_mm = 8.0;
            let form = TabletForm::new(&tablet);
            let columns = columns(&form);
            for severity in [0.0, 0.3, 1.0] {
                for (is_chip, share) in [(false, 0.2 + 0.6 * severity), (true, 0.01 + 0.09 * severity)] {
                    let stream = Stream::root(shape as u64);
                    let planned = PlannedDefect { cell: 0, kind: &KINDS[0], severity, stream };
                    let draw = DamageDraw::new(&form, &planned, 1.0);
                    let damage = if is_chip { chipped(&draw) } else { broken(&draw) };
                    let cut = damage.pieces[0][0];
                    let normal = cut.normal / form.scale;
                    let found = beyond(&columns, normal, cut.limit);
                    assert!((found / f64::from(share) - 1.0).abs() < 0.01, "{found} for {share}");
                }
            }
        }
    }
}
