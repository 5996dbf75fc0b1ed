//! Light towards the lens: what each collision, and each meeting with foil, sends straight there.
//!
//! A lens far away in direction v gets the intensity I = w p(way -> v') T exp(-depth) cos(v) / (n^2 cos(v')) per photon
//! from a collision, with v' the direction that refraction turns into v, and I = w R f(way -> v) from foil, f the
//! facets' density. What comes from below the film passes it unturned: Fresnel's law on both sides, exp(-depth), and
//! what comes after two reflections between the sides. Light of the film that its own lower side throws back is seen
//! too. The lens sees pi I / facing, with the cosine `facing` between view and normal where the light *entered*: times
//! that same cosine, which optics puts into the line's power, it is the intensity, wherever the light leaves. So a white
//! Lambertian surface returns what entered however it is tilted.
//!
//! Refraction takes the normal where light leaves, after one correction of a first guess. Which ways are followed is left
//! to chance by what they promise.
//!
//! Neglected: mirror images of what lies elsewhere, on film and solids (of the line itself they are glare, and booked by
//! optics); light that would come through a second wall of film.

use std::f64::consts::PI;

use glam::DVec3;
use rand::Rng;

use super::facets::Facets;
use super::march::{Realm, Stop};
use super::roam::{Roam, Traveller, refracted};
use super::shape::Face;
use super::spot::Slab;
use crate::transport::fresnel::fresnel_dielectric;
use crate::transport::path::body::Ledger;
use crate::transport::path::film::PIGMENT_G;
use crate::transport::phase::{henyey_greenstein_density, uniform};

/// Intensity that is always followed [sr^-1].
const WORTH: f64 = 0.1;
/// Depth beyond which light is not looked for: 1e-9 of it is left [1].
const DEEP: f64 = 20.0;
/// A little off a surface [mm].
const OFF_MM: f64 = 1e-7;

/// Refraction of the view into matter: the way inside, what gets through, and that times cos(v) / (n^2 cos(v')).
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    way: DVec3,
    passed: f64,
    factor: f64,
    cosine: f64,
}

impl Window {
    /// Into index `n` below a surface with this normal; `None` where it is turned away from the lens.
    pub fn new(view: DVec3, normal: DVec3, n: f64) -> Option<Self> {
        let facing = view.dot(normal);
        if facing <= 0.0 {
            return None;
        }
        let (thrown, cosine) = fresnel_dielectric(1.0, n, facing);
        // The view reversed goes in; the way to the lens is against it.
        let way = -refracted(-view, -normal, 1.0 / n, cosine);
        let passed = 1.0 - thrown;
        Some(Self { way, passed, factor: passed * facing / (n * n * cosine), cosine })
    }
}

/// A little more than exp(-depth), quickly: for promises.
#[inline(always)]
fn falls(depth: f64) -> f64 {
    let d = depth.clamp(0.0, DEEP) * 0.25;
    let root = 1.0 / (1.0 + d * (1.0 + d * (0.5 + d * (1.0 / 6.0 + d / 24.0))));
    (root * root) * (root * root)
}

/// Follows only some of the faint, by what they `promise`: the light with its weight, or nothing.
fn followed(intensity: f64, promise: f64, rng: &mut impl Rng) -> Option<f64> {
    let worth = promise / WORTH;
    if worth >= 1.0 {
        return Some(intensity);
    }
    (uniform(rng) <= worth).then(|| intensity / worth)
}

impl Roam {
    /// What a collision in the film sends, straight and by way of the film's lower side.
    #[inline(never)]
    pub(super) fn look_from_film(&self, light: &Traveller, slab: &Slab, ledger: &mut impl Ledger, rng: &mut impl Rng) {
        let (shape, photon) = (&self.shape, &light.photon);
        // The cell's own window does for a guess.
        let (here, Some(window)) = (&shape.cells[light.cell], &self.windows[light.cell]) else { return };
        let strength = photon.weight * slab.mu_s / slab.extinction() * window.factor;
        let towards = |way: DVec3| strength * henyey_greenstein_density(photon.way.dot(way), PIGMENT_G);
        let below = (here.middle - photon.place).dot(here.normal).max(0.0);
        let depth = slab.extinction() * below / window.cosine;
        let intensity = towards(window.way);
        if depth < DEEP
            && let Some(intensity) = followed(intensity, intensity * falls(0.7 * depth), rng)
        {
            self.rise(photon.place, window.way, intensity, slab, light.scale, ledger);
        }
        if here.sealed {
            return;
        }
        let down = window.way - here.normal * (2.0 * window.cosine);
        let intensity = towards(down) * (1.0 - window.passed);
        let Some(intensity) = followed(intensity, intensity * falls(0.5 * depth), rng) else { return };
        let (length, stop) = shape.march(photon.place, down, Realm::Film, f64::INFINITY);
        if let Stop::Face(Face::Lower, _) = stop {
            let place = photon.place + down * length;
            let intensity = intensity * libm::exp(-slab.extinction() * length);
            self.rise(place, window.way, intensity, slab, light.scale, ledger);
        }
    }

    /// Takes light in the film up and out of it, to the lens.
    fn rise(&self, place: DVec3, way: DVec3, intensity: f64, slab: &Slab, scale: f64, ledger: &mut impl Ledger) {
        let (shape, mut way) = (&self.shape, way);
        for correction in [true, false] {
            let (length, stop) = shape.march(place, way, Realm::Film, f64::INFINITY);
            let Stop::Face(Face::Upper, cell) = stop else { return };
            let end = place + way * length;
            let normal = shape.normal(cell, Face::Upper, end);
            let Some(window) = Window::new(self.view, normal, slab.n) else { return };
            if correction && window.way.dot(way) < 1.0 - 1e-7 {
                way = window.way;
                continue;
            }
            if self.visible(end + normal * OFF_MM) {
                ledger.see(end, scale * intensity * libm::exp(-slab.extinction() * length));
            }
            return;
        }
    }

    /// Whether nothing stands between a place above the film and the lens.
    fn visible(&self, place: DVec3) -> bool {
        matches!(self.shape.march(place, self.view, Realm::Above, f64::INFINITY).1, Stop::Beyond)
    }

    /// What a collision in a solid sends.
    #[inline(never)]
    pub(super) fn look_from_solid(
        &self,
        light: &Traveller,
        number: usize,
        ledger: &mut impl Ledger,
        rng: &mut impl Rng,
    ) {
        let (solid, photon) = (&self.shape.solids[number], &light.photon);
        let (n, coat) = (f64::from(solid.medium.n_eff), f64::from(solid.medium.coat));
        let extinction = f64::from(solid.medium.mu_a) + f64::from(solid.medium.sigma_i);
        let albedo = f64::from(solid.medium.sigma_i) / extinction;
        let strength = photon.weight * albedo / (4.0 * PI) * coat;
        // The depth of the film above, and at least that of the solid.
        let film = self.shape.cell(photon.place).map_or(0.0, |cell| f64::from(self.shape.depths[cell]));
        let below = extinction * light.room.free(photon.place);
        if below > DEEP {
            return;
        }
        let promise = strength / (n * n) * falls(film + 0.7 * below);
        let Some(strength) = followed(strength, promise, rng) else { return };
        let Some(mut window) = Window::new(self.view, solid.normal(photon.place.as_vec3()).as_dvec3(), n) else {
            return;
        };
        let mut end = photon.place;
        let mut depth = 0.0;
        for _ in 0..2 {
            let Some([_, far]) = solid.span(photon.place.as_vec3(), window.way.as_vec3()) else { return };
            depth = extinction * f64::from(far).max(0.0);
            if depth > DEEP {
                return;
            }
            end = photon.place + window.way * f64::from(far).max(0.0);
            let normal = solid.normal(end.as_vec3()).as_dvec3();
            let Some(right) = Window::new(self.view, normal, n) else { return };
            if right.way.dot(window.way) > 1.0 - 1e-7 {
                break;
            }
            window = right;
        }
        let intensity = strength * window.factor * libm::exp(-depth);
        self.through(end, Some(number), intensity, light.scale, ledger, rng);
    }

    /// What foil sends, in the air or under sealed film.
    #[inline(never)]
    pub(super) fn look_from_foil(
        &self,
        light: &Traveller,
        facets: &Facets,
        sealed: bool,
        ledger: &mut impl Ledger,
        rng: &mut impl Rng,
    ) {
        let photon = &light.photon;
        let strength = photon.weight * facets.reflectance;
        if !sealed {
            let intensity = strength * facets.density(photon.way, self.view);
            return self.through(photon.place, None, intensity, light.scale, ledger, rng);
        }
        let slab = *self.shape.slab(light.cell);
        let normal = self.shape.normal(light.cell, Face::Upper, photon.place);
        let Some(window) = Window::new(self.view, normal, slab.n) else { return };
        let intensity = strength * facets.density(photon.way, window.way) * window.factor;
        let over = (self.shape.height(light.cell, Face::Upper, photon.place) - photon.place.z) * normal.z;
        let promise = intensity * falls(0.7 * slab.extinction() * over / window.cosine);
        if let Some(intensity) = followed(intensity, promise, rng) {
            self.rise(photon.place, window.way, intensity, &slab, light.scale, ledger);
        }
    }

    /// Takes light from a place in the air below towards the lens: through the film, or through a hole.
    fn through(
        &self,
        place: DVec3,
        but: Option<usize>,
        intensity: f64,
        scale: f64,
        ledger: &mut impl Ledger,
        rng: &mut impl Rng,
    ) {
        let shape = &self.shape;
        let Some(cell) = shape.cell(place) else { return };
        let Some(intensity) = followed(intensity, intensity * falls(f64::from(shape.depths[cell])), rng) else {
            return;
        };
        let mut place = place;
        if let Some(lower) = shape.cells[cell].film.then(|| shape.height(cell, Face::Lower, place)) {
            // A solid that touches the film, by rounding.
            if place.z > lower && place.z < shape.height(cell, Face::Upper, place) {
                place.z = lower;
            }
        }
        let (length, stop) = shape.march(place, self.view, Realm::Under, f64::INFINITY);
        let end = place + self.view * length;
        if shape.solid(place, self.view, but).is_some_and(|(_, blocked)| blocked < length) {
            return;
        }
        match stop {
            Stop::Face(Face::Lower, cell) => {
                let slab = shape.slab(cell);
                let Some(window) = Window::new(self.view, shape.normal(cell, Face::Lower, end), slab.n) else { return };
                let (length, stop) = shape.march(end, window.way, Realm::Film, f64::INFINITY);
                let Stop::Face(Face::Upper, cell) = stop else { return };
                let end = end + window.way * length;
                if self.visible(end + shape.normal(cell, Face::Upper, end) * OFF_MM) {
                    let pass = libm::exp(-slab.extinction() * length);
                    let back = (1.0 - window.passed) * pass;
                    let unturned = window.passed * window.passed * pass / (1.0 - back * back);
                    ledger.see(end, scale * intensity * unturned);
                }
            }
            Stop::Realm(Realm::Above) if self.visible(end) => ledger.see(place, scale * intensity),
            Stop::Beyond => ledger.see(place, scale * intensity),
            _ => {}
        }
    }
}
