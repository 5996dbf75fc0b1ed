//! Bent film: how light passes a film that is curved, as pockets are, without being turned by its pigment.
//!
//! Snell's law at both sides. The lower side lies a thickness below the upper one; where the film is bent, light that
//! crosses it aslant meets a lower side of another tilt, and where it gets thinner both sides differ anyway: the film
//! is a prism there. On a shoulder of 1 mm it turns light by some 10 degrees, which is half a millimetre on foil 3 mm
//! below. An even film only shifts light, as a slab does. Slopes, bends and thicknesses come from surface grids.
//!
//! Valid for films that are thin against their radius of curvature. Neglected: light that the film's sides throw to and
//! fro on its way, roughness.

use glam::{Mat2, Vec2, Vec3};

use crate::specimen::surface_grid::Differences;

/// Least cosine between film and light for which refraction is followed [1].
pub(crate) const LEAST_FILM_COSINE: f32 = 0.1;
/// Steps in which the upper point over a lower one is found.
const OVER_STEPS: usize = 3;
/// Most corrections of the place where the lens looks through a film.
const MAX_CORRECTIONS: usize = 6;
/// Least and greatest part of the distance that a correction takes [1].
const LEAST_STEP: f32 = 0.1;
const MOST_STEP: f32 = 2.0;
/// Distance from the point that it looks for at which they end, and which counts as found [mm].
const CORRECTED_MM: f32 = 0.01;
const FOUND_MM: f32 = 0.05;
/// Step along the motion over which widening is measured [mm].
const WIDENING_STEP_MM: f32 = 0.05;

/// A film about a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FilmPlace {
    /// Height of its upper side [mm].
    pub z: f32,
    /// Slope of its upper side [1].
    pub slope: Vec2,
    /// How that slope changes [mm^-1].
    pub bend: Mat2,
    /// Its thickness [mm].
    pub thickness_mm: f32,
    /// How the thickness changes [1].
    pub wedge: Vec2,
}

impl FilmPlace {
    /// By height and thickness about the place.
    pub fn of([upper, thickness]: [Differences; 2]) -> Self {
        let Differences { value: z, slope, bend } = upper;
        Self { z, slope, bend, thickness_mm: thickness.value, wedge: thickness.slope }
    }
}

/// Film of one index, by what it is at a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FilmSheet<F> {
    /// Index of refraction [1].
    pub n: f32,
    /// The film at places that the lens looks through; `None` where there is none.
    pub place: F,
}

/// A plane below a film: a point of it and its unit normal.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlaneBelow {
    pub point: Vec3,
    pub normal: Vec3,
}

/// Light that has passed a film: a point of its way and its direction.
#[derive(Debug, Clone, Copy)]
struct Passed {
    point: Vec3,
    direction: Vec3,
}

/// A line of light that has reached a plane below a film.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Landed {
    /// Where it lands [mm].
    pub point: Vec3,
    /// Unit vector along which it does.
    pub way: Vec3,
    /// Its width along the motion over that above the film [1].
    pub widening: f32,
}

/// How the lens sees a point through a film.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SeenThrough {
    /// Where the view meets the film's upper side [mm].
    pub point: Vec3,
    /// Unit vector from what is seen to where it enters the film.
    pub way: Vec3,
    /// Cosine of the view against the film there [1].
    pub up: f32,
    /// Thickness of the film there [mm].
    pub thickness_mm: f32,
}

impl<F: Fn(Vec2) -> Option<FilmPlace>> FilmSheet<F> {
    /// Light that meets the film at `x`, `y` of a `place`, on its way through; `None` where the lower side throws all
    /// of it back, or it grazes the film.
    fn pass(&self, x: f32, y: f32, way: Vec3, place: &FilmPlace) -> Option<Passed> {
        let FilmPlace { z, slope, bend, thickness_mm, wedge } = *place;
        let normal = upright(slope);
        let inside = refract(way, normal, 1.0 / self.n).filter(|_| -way.dot(normal) > LEAST_FILM_COSINE)?;
        let run = inside * (thickness_mm / -inside.dot(normal));
        // Of the upper side, the point over the one of the lower side that is met: along the normal there, to t / R to
        // that power.
        let mut there = slope;
        // Of even film it is alike everywhere.
        let steps = if bend == Mat2::ZERO { 0 } else { OVER_STEPS };
        for _ in 0..steps {
            let over = run + upright(there) * thickness_mm;
            there = slope + bend * over.truncate();
        }
        refract(inside, upright(there - wedge / normal.z), self.n)
            .map(|direction| Passed { point: Vec3::new(x, y, z) + run, direction })
    }

    /// Where light along `way` that meets the film at `x`, `y` of a `place` lands on a plane.
    pub fn land(&self, x: f32, y: f32, way: Vec3, place: &FilmPlace, plane: &PlaneBelow) -> Option<Landed> {
        let passed = self.pass(x, y, way, place)?;
        let point = plane.meet(passed)?;
        let step = Vec2::Y * WIDENING_STEP_MM;
        let beside = FilmPlace {
            z: place.z + place.slope.dot(step) + 0.5 * step.dot(place.bend * step),
            slope: place.slope + place.bend * step,
            thickness_mm: place.thickness_mm + place.wedge.dot(step),
            ..*place
        };
        let other = plane.meet(self.pass(x, y + step.y, way, &beside)?)?;
        let widening = ((other.y - point.y) / WIDENING_STEP_MM).abs();
        Some(Landed { point, way: passed.direction, widening })
    }

    /// How a lens in direction `view` sees `target` on a plane through the film, which is looked for at this `height`.
    pub fn see(&self, target: Vec3, view: Vec3, plane: &PlaneBelow, height: f32) -> Option<SeenThrough> {
        let mut at = target.truncate() + view.truncate() * ((height - target.z) / view.z);
        let plane = PlaneBelow { point: target, ..*plane };
        let (mut share, mut last) = (1.0, None);
        for correction in 0..=MAX_CORRECTIONS {
            let place = (self.place)(at)?;
            let passed = self.pass(at.x, at.y, -view, &place)?;
            let off = plane.meet(passed)? - target;
            let far = off.length();
            if far < CORRECTED_MM || (correction == MAX_CORRECTIONS && far < FOUND_MM) {
                let up = upright(place.slope).dot(view);
                let (point, way) = (at.extend(place.z), -passed.direction);
                return Some(SeenThrough { point, way, up, thickness_mm: place.thickness_mm });
            }
            // How much of the last step was the right one (Barzilai and Borwein 1988): film that spreads light needs
            // less.
            let off = off.truncate();
            if let Some((moved, before)) = last {
                let change: Vec2 = off - before;
                share = (Vec2::dot(moved, change) / change.length_squared().max(1e-9)).clamp(LEAST_STEP, MOST_STEP);
            }
            let step = -share * off;
            last = Some((step, off));
            at += step;
        }
        None
    }
}

impl PlaneBelow {
    /// Where light that has passed meets the plane; at once where that touches the film.
    fn meet(&self, passed: Passed) -> Option<Vec3> {
        let Passed { point, direction } = passed;
        let sinks = direction.dot(self.normal);
        (sinks < -LEAST_FILM_COSINE)
            .then(|| point + direction * ((self.point - point).dot(self.normal) / sinks).max(0.0))
    }
}

/// Unit normal of a surface with this slope.
pub(crate) fn upright(slope: Vec2) -> Vec3 {
    Vec3::new(-slope.x, -slope.y, 1.0).normalize()
}

/// A direction downwards behind a surface with the upward `normal`, with this ratio of indices, before over behind;
/// `None` where all of it is thrown back.
fn refract(way: Vec3, normal: Vec3, ratio: f32) -> Option<Vec3> {
    let cosine = -way.dot(normal);
    let beyond2 = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    (cosine > 0.0 && beyond2 > 0.0).then(|| way * ratio + normal * (ratio * cosine - beyond2.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVEL: PlaneBelow = PlaneBelow { point: Vec3::ZERO, normal: Vec3::Z };

    fn sheet(place: impl Fn(Vec2) -> Option<FilmPlace>) -> FilmSheet<impl Fn(Vec2) -> Option<FilmPlace>> {
        FilmSheet { n: 1.54, place }
    }

    fn even(z: f32, slope: Vec2) -> FilmPlace {
        FilmPlace { z, slope, bend: Mat2::ZERO, thickness_mm: 0.25, wedge: Vec2::ZERO }
    }

    /// A slab shifts light by t sin(a) (1 - cos(a) / (n cos(b))) across its way, and turns none, whatever its tilt.
    #[test]
    fn even_films_shift_light_as_slabs_do() {
        for slope in [Vec2::ZERO, Vec2::new(0.4, 0.0), Vec2::new(-0.3, 1.2), Vec2::new(2.0, -1.0)] {
            let landed = sheet(|_| None).land(1.0, 2.0, Vec3::NEG_Z, &even(3.0, slope), &LEVEL).expect("it lands");
            let cosine = upright(slope).z;
            let sine = (1.0 - cosine * cosine).sqrt();
            let inside = (1.0 - sine * sine / (1.54 * 1.54)).sqrt();
            let shift = 0.25 * sine * (1.0 - cosine / (1.54 * inside));
            let off = landed.point - Vec3::new(1.0, 2.0, 0.0);
            assert!((off.length() - shift).abs() < 1e-5, "slope {slope}: {off}, not {shift}");
            // Light that enters a slope bends towards its normal, so it leaves uphill of where it came from.
            assert!(off.truncate().dot(slope) >= 0.0, "slope {slope}: {off}");
            assert!((landed.widening - 1.0).abs() < 1e-3);
        }
    }

    /// A wedge of a small angle turns light by (n - 1) times that, towards its thick side.
    #[test]
    fn wedges_turn_light() {
        for wedge in [Vec2::new(0.05, 0.0), Vec2::new(-0.02, 0.04)] {
            let place = FilmPlace { wedge, ..even(3.0, Vec2::ZERO) };
            let passed = sheet(|_| None).pass(0.0, 0.0, Vec3::NEG_Z, &place).expect("it passes");
            let turned = passed.direction.truncate() / -passed.direction.z;
            assert!(turned.distance(0.54 * wedge) < 0.01 * wedge.length(), "{turned} by {wedge}");
        }
    }

    /// A sphere's film about a place.
    fn sphere(outer: f32, place: Vec2) -> FilmPlace {
        let z = (outer * outer - place.length_squared()).sqrt();
        // Second derivatives of the sphere's height.
        let over = 1.0 / z.powi(3);
        let mixed = -place.x * place.y * over;
        let (xx, yy) = (-(outer * outer - place.y * place.y) * over, -(outer * outer - place.x * place.x) * over);
        let bend = Mat2::from_cols(Vec2::new(xx, mixed), Vec2::new(mixed, yy));
        FilmPlace { bend, ..even(z, -place / z) }
    }

    /// A shell of two concentric spheres is a weak lens of 1 / f = (n - 1) (1 / R1 - 1 / R2 + (n - 1) t / (n R1 R2))
    /// (Hecht, Optics, 6.1) near its axis, and turns rays far from it by Snell's law at both spheres. Slopes are
    /// followed to first order over the thickness, of which there is a sixth of the radius here.
    #[test]
    fn shells_are_lenses() {
        let (outer, n) = (1.5f32, 1.54f32);
        let inner = outer - 0.25;
        let power = (n - 1.0) * (1.0 / outer - 1.0 / inner + (n - 1.0) * 0.25 / (n * outer * inner));
        for (off, within) in [(0.05f32, 0.01f32), (0.4, 0.03), (0.8, 0.1)] {
            let place = Vec2::new(0.6, 0.8) * off;
            let film = sphere(outer, place);
            let passed = sheet(|_| None).pass(place.x, place.y, Vec3::NEG_Z, &film).expect("it passes");
            let outward = passed.direction.truncate().dot(place.normalize()) / -passed.direction.z;
            // The angle at the inner sphere follows from the law of sines in the plane of incidence.
            let (a, b) = ((off / outer).asin(), (off / outer / n).asin());
            let c = (b.sin() * outer / inner).asin();
            let d = (n * c.sin()).asin();
            let turned = ((d - c) - (a - b)).tan();
            assert!((outward - turned).abs() < within * turned, "{off} mm off: {outward}, not {turned}");
            if off < 0.1 {
                assert!((outward + power * off).abs() < 0.02 * outward, "{outward}, not {}", -power * off);
            }
        }
    }

    /// Where the lens looks through a film, the way back ends at what it sees.
    #[test]
    fn views_end_at_what_is_seen() {
        let film = sheet(|place| (place.length() < 1.4).then(|| sphere(1.5, place)));
        for target in [Vec3::new(0.3, -0.2, 0.2), Vec3::new(-0.1, 0.3, 0.6), Vec3::new(0.0, 0.5, -0.3)] {
            let plane = PlaneBelow { point: target, normal: Vec3::Z };
            let view = Vec3::new(0.05, -0.42, 0.9).normalize();
            let seen = film.see(target, view, &plane, 1.4).expect("it is seen");
            assert!((seen.point.length() - 1.5).abs() < 1e-4, "{} lies on the film", seen.point);
            let place = sphere(1.5, seen.point.truncate());
            let back = film.pass(seen.point.x, seen.point.y, -view, &place).and_then(|passed| plane.meet(passed));
            assert!(back.expect("it lands").distance(target) < FOUND_MM, "{back:?} for {target}");
        }
    }

    /// Steep light inside a sharply bent film stays in it.
    #[test]
    fn sharp_edges_throw_light_back() {
        let place = FilmPlace { bend: Mat2::from_diagonal(Vec2::new(-20.0, 0.0)), ..even(3.0, Vec2::new(-2.0, 0.0)) };
        assert!(sheet(|_| None).land(0.0, 0.0, Vec3::NEG_Z, &place, &LEVEL).is_none());
    }
}
