//! A body made ready for light: which point each sensor column sees in the laser plane, and whether the laser and the
//! camera reach it.
//!
//! The upper surface of boards and packs is asked directly, since they are height fields; the hull in the ray tracer
//! serves for shadows on the conveyor next to the body. A board never hides itself. A blister pack does: its upper surface
//! is put on a grid ([`relief`]), which tells what its pockets hide from the lens and where mirrored light lands, and where
//! its film is clear so is the surface of tablets and foil below. Of saw-teeth and parts from files the triangles of the
//! hull are the surface, and rays tell everything (`solid`). Neglected: light that a body throws onto the conveyor.

mod rays;
pub mod relief;
mod solid;
pub mod turned;

use glam::Vec3;
use procedural::{Body, Class, Film, Matter, Medium, Surface};

use self::rays::{LEAVE_MM, Rays};
use self::relief::Relief;
use self::turned::{Pose, Turn};
use crate::frame::{Rig, Sightline, Sightlines};

/// What one sensor column sees at one position of the scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Along the laser line [mm].
    pub x: f32,
    /// The surface there.
    pub surface: Surface,
    /// What it is; the conveyor has class `Background`.
    pub matter: Matter,
    /// Whether the laser reaches it.
    pub lit: bool,
    /// Whether the camera reaches it.
    pub seen: bool,
}

/// A body ready for rays.
#[derive(Debug)]
pub struct Specimen {
    body: Body,
    rays: Rays,
    rig: Rig,
    /// Height of the point that the laser fan comes from [mm].
    fan_height: f32,
    /// The upper surface of a body that can hide itself.
    upper: Option<Relief>,
    /// What lies below its film, where light comes through.
    lower: Option<Relief>,
    /// Where it turns; `None` for a straight way.
    turn: Option<Turn>,
}

/// Scattering over a film's thickness above which nothing is seen through it [1].
const DENSE: f32 = 4.0;
/// Steps towards the place that a column sees on a steep surface.
const STEPS: usize = 6;
/// How near such a place is found [mm].
const NEAR_MM: f32 = 0.002;

/// Height of what lies below a film whose upper side is `surface` [mm].
pub fn height_below(surface: &Surface, film: &Film) -> f32 {
    let upright = (1.0 + surface.slope_x * surface.slope_x + surface.slope_y * surface.slope_y).sqrt();
    surface.z - film.thickness_mm * upright - film.gap_mm.unwrap_or(0.0)
}

impl Specimen {
    /// Puts `body` under a camera and a laser fan from `fan_height` [mm].
    pub fn new(body: Body, rig: Rig, fan_height: f64) -> Self {
        let rays = Rays::new(&body.hull());
        let (upper, lower) = reliefs(&body, lens(&rig, 0.0));
        Self { body, rays, rig, fan_height: fan_height as f32, upper, lower, turn: None }
    }

    /// The same on a turntable, for a body that does not hide itself on a grid; scan positions are ways at its radius.
    pub fn turned(self, turn: Option<Turn>) -> Self {
        Self { turn, ..self }
    }

    /// The body.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// Height of the body's highest point [mm].
    pub fn top(&self) -> f32 {
        self.rays.high.z
    }

    /// Whether the body can hide parts of itself and throw light onto itself.
    pub fn has_relief(&self) -> bool {
        self.upper.is_some()
    }

    /// Whether what lies at `point` below a film is in sight of the lens with the laser at scan position `y`, the film
    /// itself let aside [mm].
    pub fn sees_below(&self, point: Vec3, y: f32) -> bool {
        self.lower.as_ref().is_some_and(|lower| !lower.hides(point, lens(&self.rig, y)))
    }

    /// Where light that leaves `from` on the surface along the unit vector `way` lands on the body within `reach` [mm],
    /// the surface there, and whether it is in sight of the lens with the laser at scan position `y`.
    pub fn lands(&self, from: Vec3, way: Vec3, reach: f32, y: f32) -> Option<(Vec3, Surface, bool)> {
        let upper = self.upper.as_ref()?;
        let at = upper.meet(from, way, reach)?;
        let slope = upper.slope(at.x, at.y);
        let surface = Surface { z: at.z, slope_x: slope.x, slope_y: slope.y };
        let lens = lens(&self.rig, y);
        let seen = faces(&surface, lens - at) && !upper.hides(at, lens);
        Some((at, surface, seen))
    }

    /// What `columns` see with the laser at scan position `y` [mm]; fills `hits`, one a column.
    pub fn look(&self, y: f32, columns: &Sightlines, conveyor: Medium, hits: &mut Vec<Hit>) {
        hits.clear();
        if let Some(turn) = &self.turn {
            return self.look_turned(turn, y, columns, conveyor, hits);
        }
        if self.body.is_its_hull() {
            let near_y = self.near(y);
            let bare = |x: f32| self.conveyor(x, y, near_y, conveyor);
            return self.look_at_triangles(&Pose::moved(y), columns, bare, hits);
        }
        let slice = self.body.slice(y);
        let near_y = self.near(y);
        let lens = lens(&self.rig, y);
        let (mut guess, mut last) = (self.rays.high.z, (0.0, 0.0));
        for column in 0..columns.len() {
            let line = columns.of(column);
            let along = |z: f32| line.at(z);
            if self.upper.is_some() {
                // As high as the last place's slope leads to, within reason.
                guess += ((along(guess) - last.0) * last.1).clamp(-0.5, 0.5);
            }
            let mut found = slice.surface(along(guess)).map(|s| (along(guess), s));
            if found.is_none() && self.upper.is_some() {
                // Where the card ends on the lens's far side, a look from as high as the pockets goes past its edge.
                found = slice.surface(along(0.0)).map(|s| (along(0.0), s));
            }
            if let Some((_, first)) = found
                && (first.z - guess).abs() > 0.05
            {
                // The guess was from another part of the body: look again where this column really meets it.
                found = slice.surface(along(first.z)).map(|s| (along(first.z), s));
            }
            if let (Some(upper), Some(place)) = (&self.upper, &mut found) {
                *place = approach(*place, line, |x| slice.surface(x));
                guess = place.1.z;
                let (x, surface) = *place;
                last = (x, surface.slope_x);
                let point = Vec3::new(x, y, surface.z);
                let seen = faces(&surface, lens - point) && !upper.hides(point, lens);
                hits.push(Hit { x, surface, matter: slice.matter(x, surface.z), lit: true, seen });
                continue;
            }
            let hit = match found {
                Some((x, surface)) => {
                    guess = surface.z;
                    let matter = slice.matter(x, surface.z);
                    Hit { x, surface, matter, lit: true, seen: true }
                }
                None => self.conveyor(along(0.0), y, near_y, conveyor),
            };
            hits.push(hit);
        }
        if self.upper.is_some() {
            self.shade(hits);
        }
    }

    /// Takes the laser from what stands in the shadow of the body's own steep walls: outwards along the line the fan's
    /// angle must grow from point to point.
    fn shade(&self, hits: &mut [Hit]) {
        let middle = hits.partition_point(|hit| hit.x < 0.0);
        let (left, right) = hits.split_at_mut(middle);
        let shade = |hits: &mut dyn Iterator<Item = &mut Hit>| {
            let mut widest = 0.0f32;
            for hit in hits {
                let angle = hit.x.abs() / (self.fan_height - hit.surface.z);
                hit.lit &= angle >= widest;
                widest = widest.max(angle);
            }
        };
        shade(&mut right.iter_mut());
        shade(&mut left.iter_mut().rev());
    }

    /// Whether a body can throw shadows on the conveyor at scan position `y` [mm].
    fn near(&self, y: f32) -> bool {
        let shadow = self.rays.high.z * libm::tan(self.rig.tilt) as f32 * 1.2 + 1.0;
        y > self.rays.low.y - LEAVE_MM && y < self.rays.high.y + shadow
    }

    fn conveyor(&self, x: f32, y: f32, near_y: bool, medium: Medium) -> Hit {
        let surface = Surface { z: 0.0, slope_x: 0.0, slope_y: 0.0 };
        let matter = Matter { medium, film: None, class: Class::Background, instance: 0 };
        let point = Vec3::new(x, y, 0.0);
        let lens = lens(&self.rig, y);
        let Rays { low, high, .. } = self.rays;
        // Shadows reach no further than the lower of fan and lens throws them over the body's top, and a margin.
        let over = (self.fan_height.min(lens.z) - high.z).max(1.0);
        let reach = high.z * x.abs() / over * 1.2 + 0.5;
        let near = near_y && x > low.x - reach && x < high.x + reach;
        let lit = !near || self.rays.free(point, Vec3::new(0.0, y, self.fan_height));
        let seen = !near || self.rays.free(point, lens);
        Hit { x, surface, matter, lit, seen }
    }
}

/// Where the lens stands with the laser at scan position `y` [mm].
fn lens(rig: &Rig, y: f32) -> Vec3 {
    let (sin, cos) = libm::sincos(rig.tilt);
    Vec3::new(0.0, y - (rig.distance * sin) as f32, (rig.distance * cos) as f32)
}

/// Whether a surface faces `way`.
fn faces(surface: &Surface, way: Vec3) -> bool {
    Vec3::new(-surface.slope_x, -surface.slope_y, 1.0).dot(way) > 0.0
}

/// Comes nearer to the place where a column's line of sight meets the surface (Newton's way). Where the
/// surface ends before, the last place counts.
fn approach(mut place: (f32, Surface), line: Sightline, surface: impl Fn(f32) -> Option<Surface>) -> (f32, Surface) {
    for _ in 0..STEPS {
        let (x, here) = place;
        let off = x - line.at(here.z);
        if off.abs() < NEAR_MM {
            break;
        }
        let next = x - off / (1.0 - line.lean(here.z) * here.slope_x).max(0.5);
        match surface(next) {
            Some(there) => place = (next, there),
            None => break,
        }
    }
    place
}

/// The upper surface of a body that can hide itself, and what lies below its film where that lets light through.
fn reliefs(body: &Body, lens: Vec3) -> (Option<Relief>, Option<Relief>) {
    let Body::Pack(pack) = body else { return (None, None) };
    let (low, high) = body.bounds();
    let upper = Relief::new(low, high, lens, |y, x, row| {
        let slice = body.slice(y);
        for (z, &x) in row.iter_mut().zip(x) {
            *z = slice.surface(x).map_or(0.0, |surface| surface.z);
        }
    });
    let lower = (pack.clearest() < DENSE).then(|| {
        Relief::new(low, high, lens, |y, x, row| {
            let slice = body.slice(y);
            for (z, &x) in row.iter_mut().zip(x) {
                *z = slice.surface(x).map_or(0.0, |surface| match slice.matter(x, surface.z).film {
                    Some(film) => height_below(&surface, &film),
                    None => surface.z,
                });
            }
        })
    });
    (Some(upper), lower)
}
