//! One photon's way through a pack.
//!
//! In film and solids: free paths, Henyey and Greenstein's law in the film (its pigment's mean cosine) and none but
//! isotropic turns in solids, absorption and roulette as in plane layers. At the film's sides and at solids: Fresnel's
//! law decides by chance; a solid's coat takes its share of what passes. In the air: straight ways to the next film,
//! solid or foil. At the foil: facets ([`Facets`]); where the film is sealed to it, they lie on the film's lower side.
//!
//! Neglected: roughness of film and solids, refraction by anything finer than a cell.

use glam::DVec3;
use rand::Rng;

use super::facets::Facets;
use super::look::Window;
use super::march::{Realm, Stop};
use super::room::Room;
use super::shape::{Face, Shape};
use crate::transport::fresnel::fresnel_dielectric;
use crate::transport::path::LONGEST_MM;
use crate::transport::path::body::{Fate, Ground, Ledger};
use crate::transport::path::film::PIGMENT_G;
use crate::transport::path::walk::{Photon, ROULETTE};
use crate::transport::phase::{henyey_greenstein, isotropic, uniform};

/// Meetings with surfaces after which light is given up: it is caught in a wedge.
const MEETINGS: u32 = 10_000;
/// Light enters at least so far towards the lens; less is grazing, and optics sends hardly any [1].
const GRAZING: f64 = 0.02;
/// Push that brings light on a solid's surface back inside [mm].
const INSIDE_MM: f64 = 1e-5;

/// A pack to roam in.
#[derive(Debug)]
pub(in crate::transport::path) struct Roam {
    pub(super) shape: Shape,
    /// Unit vector towards the lens.
    pub(super) view: DVec3,
    /// The view into the film at each cell.
    pub(super) windows: Vec<Option<Window>>,
}

/// A photon with what it is worth to the lens.
#[derive(Debug, Clone, Copy)]
pub(super) struct Traveller {
    pub photon: Photon,
    /// Light that the lens sees per intensity towards it [sr].
    pub scale: f64,
    /// Cell that it is in, or was last.
    pub cell: usize,
    /// Room about it in a solid.
    pub room: Room,
}

impl Ground for Roam {
    fn light(&self, x: f64, y: f64, ledger: &mut impl Ledger, rng: &mut impl Rng) {
        let above = DVec3::new(x, y, self.shape.top + 1.0);
        let (length, stop) = self.shape.march(above, DVec3::NEG_Z, Realm::Above, f64::INFINITY);
        let place = above - DVec3::Z * length;
        let (place, normal, n, realm, cell) = match stop {
            Stop::Face(Face::Upper, cell) => {
                let normal = self.shape.normal(cell, Face::Upper, place);
                (place, normal, self.shape.slab(cell).n, Realm::Film, cell)
            }
            // Through a hole onto a solid; what enters foil stays there.
            _ => match (self.shape.solid(above, DVec3::NEG_Z, None), self.shape.cell(above)) {
                (Some((number, length)), Some(cell)) => {
                    let place = above - DVec3::Z * length;
                    let solid = &self.shape.solids[number];
                    let normal = solid.normal(place.as_vec3()).as_dvec3();
                    (place, normal, f64::from(solid.medium.n_eff), Realm::Solid(number), cell)
                }
                (None, Some(cell)) if self.shape.cells[cell].foil => return ledger.book(Fate::Absorbed, 1.0),
                _ => return ledger.book(Fate::Astray, 1.0),
            },
        };
        let way = refracted(DVec3::NEG_Z, -normal, 1.0 / n, fresnel_dielectric(1.0, n, normal.z).1);
        let photon = Photon { place, way, weight: 1.0, layer: 0, path: 0.0, turned: 0, guided: 0 };
        let scale = std::f64::consts::PI / normal.dot(self.view).max(GRAZING);
        self.follow(Traveller { photon, scale, cell, room: Room::default() }, realm, ledger, rng);
    }
}

impl Roam {
    /// In a shape, seen from `view`.
    pub(super) fn new(shape: Shape, view: DVec3) -> Self {
        let window = |cell: usize| {
            let film = shape.cells[cell].film;
            film.then(|| Window::new(view, shape.cells[cell].normal, shape.slab(cell).n)).flatten()
        };
        let windows = (0..shape.cells.len()).map(window).collect();
        Self { shape, view, windows }
    }

    /// Follows light until it is gone.
    fn follow(&self, mut light: Traveller, mut realm: Realm, ledger: &mut impl Ledger, rng: &mut impl Rng) {
        // The solid that light has just left or been thrown back by; convex, it is not met again on a straight way.
        let mut left = None;
        let mut meetings = 0;
        while light.photon.weight > 0.0 {
            if light.photon.path > LONGEST_MM || meetings > MEETINGS {
                return ledger.book(Fate::Astray, light.photon.weight);
            }
            let (place, way) = (light.photon.place, light.photon.way);
            if let Realm::Solid(number) = realm {
                if self.walk(&mut light, number, ledger, rng) {
                    meetings += 1;
                    light.room = Room::default();
                    (realm, left) = (self.outside(&mut light), Some(number));
                }
                continue;
            }
            let next = if realm == Realm::Under { self.shape.solid(place, way, left) } else { None };
            let free = match realm {
                Realm::Film => -libm::log(uniform(rng)) / self.shape.slab(light.cell).extinction(),
                _ => next.map_or(f64::INFINITY, |(_, length)| length),
            };
            if realm == Realm::Film && self.shape.stays(place + way * free, light.cell) {
                light.photon.place += way * free;
                light.photon.path += free;
                self.collide(&mut light, ledger, rng);
                continue;
            }
            let (length, stop) = self.shape.march(place, way, realm, free);
            light.photon.place += way * length;
            match stop {
                Stop::Length => match next {
                    Some((number, _)) => {
                        meetings += 1;
                        left = Some(number);
                        if self.enter_solid(&mut light.photon, number, ledger, rng) {
                            realm = Realm::Solid(number);
                        }
                    }
                    None => {
                        light.photon.path += length;
                        if let Some(cell) = self.shape.cell(light.photon.place) {
                            light.cell = cell;
                        }
                        self.collide(&mut light, ledger, rng);
                    }
                },
                Stop::Face(face, cell) => {
                    meetings += 1;
                    light.cell = cell;
                    light.photon.path += length;
                    left = None;
                    realm = self.meet(&mut light, face, realm, ledger, rng);
                }
                Stop::Realm(other) => realm = other,
                Stop::Ground => return ledger.book(Fate::Dropped, light.photon.weight),
                Stop::Beyond if way.z < 0.0 => return ledger.book(Fate::Dropped, light.photon.weight),
                Stop::Beyond => return ledger.book(Fate::Left, light.photon.weight),
                Stop::Astray => return ledger.book(Fate::Astray, light.photon.weight),
            }
        }
    }

    /// A collision in the film.
    fn collide(&self, light: &mut Traveller, ledger: &mut impl Ledger, rng: &mut impl Rng) {
        let slab = *self.shape.slab(light.cell);
        self.look_from_film(light, &slab, ledger, rng);
        lose(&mut light.photon, slab.mu_a / slab.extinction(), ledger, rng);
        light.photon.way = henyey_greenstein(light.photon.way, PIGMENT_G, rng);
    }

    /// Light at a face of film or foil: the realm it goes on in.
    fn meet(
        &self,
        light: &mut Traveller,
        face: Face,
        realm: Realm,
        ledger: &mut impl Ledger,
        rng: &mut impl Rng,
    ) -> Realm {
        let (shape, photon) = (&self.shape, &mut light.photon);
        let normal = shape.normal(light.cell, face, photon.place);
        let sealed = face == Face::Lower && realm == Realm::Film && shape.cells[light.cell].sealed;
        if face == Face::Foil || sealed {
            let facets = Facets::new(shape.metal(light.cell), normal);
            self.look_from_foil(light, &facets, sealed, ledger, rng);
            lose(&mut light.photon, 1.0 - facets.reflectance, ledger, rng);
            if light.photon.weight > 0.0 {
                light.photon.way = facets.sample(light.photon.way, rng);
            }
            return realm;
        }
        let n = shape.slab(light.cell).n;
        // The normal on the side that light goes to.
        let ahead = if (face == Face::Upper) == (realm == Realm::Film) { normal } else { -normal };
        let beyond = match (realm, face) {
            (Realm::Film, Face::Upper) => Realm::Above,
            (Realm::Film, _) => Realm::Under,
            _ => Realm::Film,
        };
        let (from, to) = if realm == Realm::Film { (n, 1.0) } else { (1.0, n) };
        if cross(photon, ahead, from, to, rng) { beyond } else { realm }
    }

    /// Light in the air at a solid: whether it enters.
    fn enter_solid(&self, photon: &mut Photon, number: usize, ledger: &mut impl Ledger, rng: &mut impl Rng) -> bool {
        let solid = &self.shape.solids[number];
        let normal = solid.normal(photon.place.as_vec3()).as_dvec3();
        let enters = cross(photon, -normal, 1.0, f64::from(solid.medium.n_eff), rng);
        if enters {
            lose(photon, 1.0 - f64::from(solid.medium.coat), ledger, rng);
        }
        enters
    }

    /// One free path in a solid: whether light comes out.
    fn walk(&self, light: &mut Traveller, number: usize, ledger: &mut impl Ledger, rng: &mut impl Rng) -> bool {
        let solid = &self.shape.solids[number];
        let medium = &solid.medium;
        let extinction = f64::from(medium.mu_a) + f64::from(medium.sigma_i);
        let photon = &mut light.photon;
        let free = -libm::log(uniform(rng)) / extinction;
        let far = if free < light.room.free(photon.place) {
            f64::INFINITY
        } else {
            let span = solid.span(photon.place.as_vec3(), photon.way.as_vec3());
            span.map_or(0.0, |[_, far]| f64::from(far).max(0.0))
        };
        photon.place += photon.way * free.min(far);
        photon.path += free.min(far);
        if free < far {
            if far < f64::INFINITY {
                light.room.renew(photon.place, solid, extinction);
            }
            self.look_from_solid(light, number, ledger, rng);
            lose(&mut light.photon, f64::from(medium.mu_a) / extinction, ledger, rng);
            light.photon.way = isotropic(rng);
            return false;
        }
        let normal = solid.normal(photon.place.as_vec3()).as_dvec3();
        if photon.way.dot(normal) <= 0.0 {
            // Rounding has put it out.
            photon.place -= normal * INSIDE_MM;
            return false;
        }
        let out = cross(photon, normal, f64::from(medium.n_eff), 1.0, rng);
        if out {
            lose(photon, 1.0 - f64::from(medium.coat), ledger, rng);
        }
        out
    }

    /// Where light is that has left a solid: a little over the film's lower side where both touch.
    fn outside(&self, light: &mut Traveller) -> Realm {
        let (shape, place) = (&self.shape, &mut light.photon.place);
        let Some(cell) = shape.cell(*place) else { return Realm::Under };
        light.cell = cell;
        if shape.cells[cell].film {
            let (lower, upper) = (shape.height(cell, Face::Lower, *place), shape.height(cell, Face::Upper, *place));
            if place.z > lower && place.z < upper {
                place.z = lower;
            }
        }
        Realm::Under
    }
}

/// Takes a share of the light away, and lets chance decide about faint light.
fn lose(photon: &mut Photon, share: f64, ledger: &mut impl Ledger, rng: &mut impl Rng) {
    let lost = photon.weight * share;
    ledger.book(Fate::Absorbed, lost);
    photon.weight -= lost;
    if photon.weight < ROULETTE && photon.weight > 0.0 {
        ledger.book(Fate::Absorbed, photon.gamble(rng));
    }
}

/// Takes light through a surface or back: whether it is through. `ahead` is the normal on the far side.
fn cross(photon: &mut Photon, ahead: DVec3, n: f64, other: f64, rng: &mut impl Rng) -> bool {
    let mu = photon.way.dot(ahead).clamp(0.0, 1.0);
    let (reflectance, cosine) = fresnel_dielectric(n, other, mu);
    let through = uniform(rng) > reflectance;
    photon.way = if through {
        refracted(photon.way, ahead, n / other, cosine)
    } else {
        (photon.way - ahead * (2.0 * mu)).normalize()
    };
    through
}

/// A direction beyond a surface whose normal there is `ahead`, with this ratio of indices and cosine.
pub(super) fn refracted(way: DVec3, ahead: DVec3, ratio: f64, cosine: f64) -> DVec3 {
    (way * ratio + ahead * (cosine - ratio * way.dot(ahead))).normalize()
}
