//! Next events: what a collision or a reflection in a pack sends to the lens.
//!
//! A lens far away in direction v gets the intensity I = w p(w -> v') T exp(-depth) cos(v) / (n^2 cos(v')) per photon
//! from a collision, with v' the direction that refraction turns into v, and I = w R f(w -> v) from foil, f the facets'
//! density. What comes from below the film passes it unturned: Fresnel's law on both sides, exp(-depth), and what comes
//! after two reflections between the sides. Light of the film that its own lower side throws back is seen too. The lens
//! sees pi I / facing, with the cosine `facing` between view and normal where the light *entered*: times that same
//! cosine, which optics puts into the line's power, it is the intensity, wherever the light leaves. So a white
//! Lambertian surface returns what entered however it is tilted.
//!
//! Refraction takes the normal where light leaves, after one correction of a first guess; ways from the air below
//! through both sides of the film are corrected towards the view as far as the cells' facets allow, and the light of a
//! point is not focused by that. Which of them are followed is left to chance by what they promise.
//!
//! Neglected: mirror images of what lies elsewhere, on film and solids (of the line itself they are glare, and booked
//! by optics); light that would come through a second wall of film.

use std::f64::consts::PI;

use glam::DVec3;
use rand::Rng;

use super::super::tracker::LineObserver;
use super::microfacets::Microfacets;
use super::shape::{FilmMatter, PackFace, PackRayEnd, PackRegion};
use super::{PackGeometry, PackPhoton, refracted_into};
use crate::phase::{henyey_greenstein_density, uniform};
use transport::fresnel::fresnel_dielectric;
use transport::stack::PIGMENT_G;

/// Openings that a ray towards the lens passes over; packs have a few holes.
const MAX_OPENINGS: usize = 64;
/// Intensity that is always followed [sr^-1].
const SURE_INTENSITY: f64 = 0.1;
/// Depth beyond which light is not looked for: 1e-9 of it is left [1].
const MAX_DEPTH: f64 = 20.0;
/// Most corrections of a way out through film.
const MAX_CORRECTIONS: usize = 6;
/// Distance from the view, of unit vectors, within which light counts as leaving towards the lens [1].
const MAX_OFF: f64 = 1e-3;
/// A little off a surface [mm].
const OFF_SURFACE_MM: f64 = 1e-7;

/// Refraction of the view into matter: the direction inside, what gets through, and that times cos(v) / (n^2 cos(v')).
#[derive(Debug, Clone, Copy)]
pub(super) struct RefractedView {
    direction: DVec3,
    passed: f64,
    factor: f64,
    cosine: f64,
}

impl RefractedView {
    /// Into index `n` below a surface with this normal; `None` where it is turned away from the lens.
    pub(super) fn new(view: DVec3, normal: DVec3, n: f64) -> Option<Self> {
        let facing = view.dot(normal);
        if facing <= 0.0 {
            return None;
        }
        let (thrown, cosine) = fresnel_dielectric(1.0, n, facing);
        // The view reversed goes in; the direction to the lens is opposite.
        let direction = -refracted_into(-view, -normal, 1.0 / n, cosine);
        let passed = 1.0 - thrown;
        Some(Self { direction, passed, factor: passed * facing / (n * n * cosine), cosine })
    }
}

/// A little more than exp(-depth), quickly: for promises.
#[inline(always)]
fn falls(depth: f64) -> f64 {
    let d = depth.clamp(0.0, MAX_DEPTH) * 0.25;
    let root = 1.0 / (1.0 + d * (1.0 + d * (0.5 + d * (1.0 / 6.0 + d / 24.0))));
    (root * root) * (root * root)
}

/// Follows only some of the faint, by what they `promise`: the light with its weight, or nothing.
fn followed(intensity: f64, promise: f64, rng: &mut impl Rng) -> Option<f64> {
    let worth = promise / SURE_INTENSITY;
    if worth >= 1.0 {
        return Some(intensity);
    }
    (uniform(rng) <= worth).then(|| intensity / worth)
}

impl PackGeometry {
    /// What a collision in the film sends, straight and by way of the film's lower side.
    #[inline(never)]
    pub(super) fn next_event_from_film(
        &self,
        light: &PackPhoton,
        slab: &FilmMatter,
        observer: &mut impl LineObserver,
        rng: &mut impl Rng,
    ) {
        let (shape, photon) = (&self.shape, &light.photon);
        // The cell's own window does for a guess.
        let (here, Some(window)) = (&shape.cells[light.cell], &self.windows[light.cell]) else { return };
        let strength = photon.weight * slab.mu_s / slab.extinction() * window.factor;
        let towards =
            |direction: DVec3| strength * henyey_greenstein_density(photon.direction.dot(direction), PIGMENT_G);
        let below = (here.middle - photon.position).dot(here.normal).max(0.0);
        let depth = slab.extinction() * below / window.cosine;
        let intensity = towards(window.direction);
        if depth < MAX_DEPTH
            && let Some(intensity) = followed(intensity, intensity * falls(0.7 * depth), rng)
        {
            self.rise(photon.position, window.direction, intensity, slab, light.scale, observer);
        }
        if here.sealed {
            return;
        }
        let down = window.direction - here.normal * (2.0 * window.cosine);
        let intensity = towards(down) * (1.0 - window.passed);
        let Some(intensity) = followed(intensity, intensity * falls(0.5 * depth), rng) else { return };
        let (length, stop) = shape.march(photon.position, down, PackRegion::Film, f64::INFINITY);
        if let PackRayEnd::Face(PackFace::Lower, _) = stop {
            let position = photon.position + down * length;
            let intensity = intensity * libm::exp(-slab.extinction() * length);
            self.rise(position, window.direction, intensity, slab, light.scale, observer);
        }
    }

    /// Takes light in the film up and out of it, to the lens.
    fn rise(
        &self,
        position: DVec3,
        direction: DVec3,
        intensity: f64,
        slab: &FilmMatter,
        scale: f64,
        observer: &mut impl LineObserver,
    ) {
        let (shape, mut direction) = (&self.shape, direction);
        for correction in [true, false] {
            let (length, stop) = shape.march(position, direction, PackRegion::Film, f64::INFINITY);
            let PackRayEnd::Face(PackFace::Upper, cell) = stop else { return };
            let end = position + direction * length;
            let normal = shape.normal(cell, PackFace::Upper, end);
            let Some(window) = RefractedView::new(self.view, normal, slab.n) else { return };
            if correction && window.direction.dot(direction) < 1.0 - 1e-7 {
                direction = window.direction;
                continue;
            }
            if self.visible(end + normal * OFF_SURFACE_MM) {
                observer.see(end, scale * intensity * libm::exp(-slab.extinction() * length));
            }
            return;
        }
    }

    /// Whether nothing stands between a point above the film and the lens. Beside the card, and over its holes, the ray
    /// leaves the air above the film for that below it and may come back.
    pub(super) fn visible(&self, position: DVec3) -> bool {
        let (mut position, mut region) = (position, PackRegion::Above);
        for _ in 0..MAX_OPENINGS {
            let (length, stop) = self.shape.march(position, self.view, region, f64::INFINITY);
            let is_under = region == PackRegion::Under;
            if is_under && self.shape.solid(position, self.view, None).is_some_and(|(_, blocked)| blocked < length) {
                return false;
            }
            match stop {
                PackRayEnd::Beyond => return true,
                PackRayEnd::Region(other) => (position, region) = (position + self.view * length, other),
                _ => return false,
            }
        }
        false
    }

    /// What a collision in a solid sends.
    #[inline(never)]
    pub(super) fn next_event_from_solid(
        &self,
        light: &PackPhoton,
        number: usize,
        observer: &mut impl LineObserver,
        rng: &mut impl Rng,
    ) {
        let (solid, photon) = (&self.shape.solids[number], &light.photon);
        let (n, coat) = (f64::from(solid.medium.n_eff), f64::from(solid.medium.coat));
        let extinction = f64::from(solid.medium.mu_a) + f64::from(solid.medium.sigma_i);
        let albedo = f64::from(solid.medium.sigma_i) / extinction;
        let strength = photon.weight * albedo / (4.0 * PI) * coat;
        // The depth of the film above, and at least that of the solid.
        let film = self.shape.cell(photon.position).map_or(0.0, |cell| f64::from(self.shape.depths[cell]));
        let below = extinction * light.clearance.free(photon.position);
        if below > MAX_DEPTH {
            return;
        }
        let promise = strength / (n * n) * falls(film + 0.7 * below);
        let Some(strength) = followed(strength, promise, rng) else { return };
        let Some(mut window) = RefractedView::new(self.view, solid.normal(photon.position.as_vec3()).as_dvec3(), n)
        else {
            return;
        };
        let mut end = photon.position;
        let mut depth = 0.0;
        for _ in 0..2 {
            let Some([_, far]) = solid.span(photon.position.as_vec3(), window.direction.as_vec3()) else { return };
            depth = extinction * f64::from(far).max(0.0);
            if depth > MAX_DEPTH {
                return;
            }
            end = photon.position + window.direction * f64::from(far).max(0.0);
            let normal = solid.normal(end.as_vec3()).as_dvec3();
            let Some(right) = RefractedView::new(self.view, normal, n) else { return };
            if right.direction.dot(window.direction) > 1.0 - 1e-7 {
                break;
            }
            window = right;
        }
        let intensity = strength * window.factor * libm::exp(-depth);
        self.through(end, Some(number), |_| intensity, light.scale, observer, rng);
    }

    /// What foil sends, in the air or under sealed film.
    #[inline(never)]
    pub(super) fn next_event_from_foil(
        &self,
        light: &PackPhoton,
        facets: &Microfacets,
        sealed: bool,
        observer: &mut impl LineObserver,
        rng: &mut impl Rng,
    ) {
        let photon = &light.photon;
        let strength = photon.weight * facets.reflectance;
        if !sealed {
            let intensity = |way: DVec3| strength * facets.density(photon.direction, way);
            return self.through(photon.position, None, intensity, light.scale, observer, rng);
        }
        let slab = *self.shape.slab(light.cell);
        let normal = self.shape.normal(light.cell, PackFace::Upper, photon.position);
        let Some(window) = RefractedView::new(self.view, normal, slab.n) else { return };
        let intensity = strength * facets.density(photon.direction, window.direction) * window.factor;
        let over = (self.shape.height(light.cell, PackFace::Upper, photon.position) - photon.position.z) * normal.z;
        let promise = intensity * falls(0.7 * slab.extinction() * over / window.cosine);
        if let Some(intensity) = followed(intensity, promise, rng) {
            self.rise(photon.position, window.direction, intensity, &slab, light.scale, observer);
        }
    }

    /// Takes light from a point in the air below towards the lens: through the film, or through a hole; `intensity` is
    /// what the point sends along a direction. Film whose sides differ turns light on its way out: the direction that
    /// leaves it towards the lens is found by taking away what it is off by.
    fn through(
        &self,
        position: DVec3,
        but: Option<usize>,
        intensity: impl Fn(DVec3) -> f64,
        scale: f64,
        observer: &mut impl LineObserver,
        rng: &mut impl Rng,
    ) {
        let shape = &self.shape;
        let Some(cell) = shape.cell(position) else { return };
        let promise = intensity(self.view) * falls(f64::from(shape.depths[cell]));
        let Some(share) = followed(1.0, promise, rng) else { return };
        let mut position = position;
        if let Some(lower) = shape.cells[cell].film.then(|| shape.height(cell, PackFace::Lower, position)) {
            // A solid that touches the film, by rounding.
            if position.z > lower && position.z < shape.height(cell, PackFace::Upper, position) {
                position.z = lower;
            }
        }
        let mut way = self.view;
        // The best way yet: how far it is off, where it ends, and what it brings.
        let mut best: Option<(f64, DVec3, f64)> = None;
        for correction in 0..=MAX_CORRECTIONS {
            match self.way_out(position, way, but) {
                WayOut::Film { end, normal, direction, unturned } => {
                    let off = direction - self.view;
                    let far = off.length();
                    if best.is_none_or(|(least, ..)| far < least) {
                        best = Some((far, end + normal * OFF_SURFACE_MM, intensity(way) * unturned));
                    }
                    if far < MAX_OFF {
                        break;
                    }
                    way = (way - off).normalize();
                }
                WayOut::Hole(end) if correction == 0 && self.visible(end) => {
                    return observer.see(position, scale * share * intensity(way));
                }
                WayOut::Beyond if correction == 0 => return observer.see(position, scale * share * intensity(way)),
                WayOut::Hole(_) | WayOut::Beyond | WayOut::Blocked => break,
            }
        }
        if let Some((_, end, intensity)) = best.filter(|&(_, end, _)| self.visible(end)) {
            observer.see(end, scale * share * intensity);
        }
    }

    /// Where light from a point in the air below gets that sets out along `way`; the solid `but` does not block it.
    fn way_out(&self, position: DVec3, way: DVec3, but: Option<usize>) -> WayOut {
        let shape = &self.shape;
        let (length, stop) = shape.march(position, way, PackRegion::Under, f64::INFINITY);
        let end = position + way * length;
        if shape.solid(position, way, but).is_some_and(|(_, blocked)| blocked < length) {
            return WayOut::Blocked;
        }
        let cell = match stop {
            PackRayEnd::Face(PackFace::Lower, cell) => cell,
            PackRayEnd::Region(PackRegion::Above) => return WayOut::Hole(end),
            PackRayEnd::Beyond => return WayOut::Beyond,
            _ => return WayOut::Blocked,
        };
        let slab = shape.slab(cell);
        let Some(enters) = RefractedView::new(way, shape.normal(cell, PackFace::Lower, end), slab.n) else {
            return WayOut::Blocked;
        };
        let (length, stop) = shape.march(end, enters.direction, PackRegion::Film, f64::INFINITY);
        let PackRayEnd::Face(PackFace::Upper, cell) = stop else { return WayOut::Blocked };
        let end = end + enters.direction * length;
        let normal = shape.normal(cell, PackFace::Upper, end);
        let (thrown, cosine) = fresnel_dielectric(slab.n, 1.0, enters.direction.dot(normal).max(0.0));
        if thrown >= 1.0 {
            return WayOut::Blocked;
        }
        let direction = refracted_into(enters.direction, normal, slab.n, cosine);
        let pass = libm::exp(-slab.extinction() * length);
        let back = (1.0 - enters.passed) * thrown * pass * pass;
        WayOut::Film { end, normal, direction, unturned: enters.passed * (1.0 - thrown) * pass / (1.0 - back) }
    }
}

/// Where light gets that sets out in the air below.
enum WayOut {
    /// It leaves the film at `end`, where that has a `normal`, along `direction`; the share that does so unturned.
    Film { end: DVec3, normal: DVec3, direction: DVec3, unturned: f64 },
    /// Through a hole, at this point.
    Hole(DVec3),
    /// Beside the card.
    Beyond,
    /// Nowhere.
    Blocked,
}
