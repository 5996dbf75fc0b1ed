//! Monte Carlo of light in a pack: film, air, tablets and foil in their true shape.
//!
//! Model: the film is a body of its own between two height fields, its upper side and its lower one ([`shape`]). Light
//! walks in it as in a layer, leaves it by Fresnel's law through either side, flies straight through the air and meets
//! film, tablets and foil where they stand. Tablets are walked in like layers. No plane layers, no diffuse gaps,
//! no tables: nothing is shared with the kernel but coefficients.
//!
//! A cell of the answer holds the light that leaves the *film* over it towards the lens (or whatever lies open, in a
//! hole). A ray is a ray: through clear film the lens sees that point of the film, wherever the light was last turned.
//!
//! Valid for shapes coarser than 0.1 mm. Neglected: polarisation and waves, roughness of film and tablets, mirror
//! images, light farther than 20 mm from the line's grid (booked as lost).
//!
//! # Photons
//!
//! In film and solids: free paths, Henyey and Greenstein's law in the film (its pigment's mean cosine) and none but
//! isotropic turns in solids, absorption and roulette as in plane layers. At the film's sides and at solids: Fresnel's
//! law decides by chance; a solid's coat takes its share of what passes. In the air: straight lines to the next film,
//! solid or foil. At the foil: facets ([`Microfacets`]); where the film is sealed to it, they lie on the film's lower
//! side.
//!
//! Neglected: roughness of film and solids, refraction by anything finer than a cell.
//!
//! What the lens sees is in [`next_events`].

mod clearance;
mod microfacets;
mod moved_net;
mod next_events;
mod shape;
#[cfg(test)]
mod tests;

use glam::DVec3;
use procedural::blister::Pack;
use rand::Rng;

use self::clearance::Clearance;
use self::microfacets::Microfacets;
use self::next_events::RefractedView;
use self::shape::{FilmMatter, PackFace, PackRayEnd, PackRegion, PackShape};
use super::LONGEST_MM;
use super::tracker::{Fate, FlightEnd, Geometry, LineObserver, Photon, RouletteOrder, Target, refracted, transmitted};
use crate::phase::{henyey_greenstein, isotropic, uniform};
use transport::fresnel::fresnel_dielectric;
use transport::line::{LEAST_FACING, LineSource};
use transport::stack::PIGMENT_G;

/// Meetings with surfaces after which light is given up: it is caught in a wedge.
const MAX_MEETINGS: u32 = 10_000;
/// Push that brings light on a solid's surface back inside [mm].
const PUSH_INSIDE_MM: f64 = 1e-5;

/// A pack about a line of light, as photons meet it.
#[derive(Debug)]
pub(super) struct PackGeometry {
    shape: PackShape,
    /// Unit vector towards the lens.
    view: DVec3,
    /// The view into the film at each cell.
    windows: Vec<Option<RefractedView>>,
}

/// A photon in a pack, with what it is worth to the lens.
#[derive(Debug, Clone, Copy)]
pub(super) struct PackPhoton {
    photon: Photon,
    /// Light that the lens sees per intensity towards it [sr].
    scale: f64,
    /// Where it is.
    region: PackRegion,
    /// Cell that it is in, or was last.
    cell: usize,
    /// The solid that it has just left or been thrown back by; convex, it is not met again on a straight line.
    left: Option<usize>,
    /// Clearance about it in a solid.
    clearance: Clearance,
    /// Surfaces that it has met.
    meetings: u32,
}

impl AsMut<Photon> for PackPhoton {
    #[inline(always)]
    fn as_mut(&mut self) -> &mut Photon {
        &mut self.photon
    }
}

/// Matter of a pack in which light collides.
#[derive(Debug, Clone, Copy)]
pub(super) enum PackMedium {
    /// The film.
    Film(FilmMatter),
    /// The solid of this number.
    Solid(usize),
}

/// A surface of a pack.
#[derive(Debug, Clone, Copy)]
pub(super) enum PackSurface {
    /// A side of the film, or the foil, in the photon's cell.
    Face(PackFace),
    /// The solid of this number, from the air.
    IntoSolid(usize),
    /// The solid of this number, from inside, and its outward normal.
    OutOfSolid(usize, DVec3),
}

impl<O: LineObserver> Geometry<O> for PackGeometry {
    type State = PackPhoton;
    type Medium<'g> = PackMedium;
    type Surface = PackSurface;
    const ROULETTE_ORDER: RouletteOrder = RouletteOrder::BeforeScattering;

    #[inline(always)]
    fn fly(&self, state: &mut PackPhoton, rng: &mut impl Rng) -> FlightEnd<PackMedium, PackSurface> {
        loop {
            if state.photon.path > LONGEST_MM || state.meetings > MAX_MEETINGS {
                return FlightEnd::End(Fate::Lost);
            }
            let end = match state.region {
                PackRegion::Solid(number) => self.fly_in_solid(state, number, rng),
                PackRegion::Above | PackRegion::Film | PackRegion::Under => self.fly_in_film_or_air(state, rng),
            };
            if let Some(end) = end {
                return end;
            }
        }
    }

    #[inline(always)]
    fn next_event(&self, state: &PackPhoton, medium: PackMedium, observer: &mut O, rng: &mut impl Rng) {
        match medium {
            PackMedium::Film(slab) => self.next_event_from_film(state, &slab, observer, rng),
            PackMedium::Solid(number) => self.next_event_from_solid(state, number, observer, rng),
        }
    }

    #[inline(always)]
    fn absorbed(&self, photon: &Photon, medium: PackMedium) -> f64 {
        let share = match medium {
            PackMedium::Film(slab) => slab.mu_a / slab.extinction(),
            PackMedium::Solid(number) => {
                let medium = &self.shape.solids[number].medium;
                f64::from(medium.mu_a) / (f64::from(medium.mu_a) + f64::from(medium.sigma_i))
            }
        };
        photon.weight * share
    }

    #[inline(always)]
    fn scatter(&self, photon: &mut Photon, medium: PackMedium, rng: &mut impl Rng) {
        photon.direction = match medium {
            PackMedium::Film(_) => henyey_greenstein(photon.direction, PIGMENT_G, rng),
            PackMedium::Solid(_) => isotropic(rng),
        };
    }

    #[inline(always)]
    fn cross(
        &self,
        state: &mut PackPhoton,
        surface: PackSurface,
        observer: &mut O,
        rng: &mut impl Rng,
    ) -> Option<Fate> {
        match surface {
            PackSurface::Face(face) => self.cross_face(state, face, observer, rng),
            PackSurface::IntoSolid(number) => {
                let solid = &self.shape.solids[number];
                let normal = solid.normal(state.photon.position.as_vec3()).as_dvec3();
                if cross_surface(&mut state.photon, -normal, 1.0, f64::from(solid.medium.n_eff), rng) {
                    self.lose(&mut state.photon, 1.0 - f64::from(solid.medium.coat), observer, rng);
                    state.region = PackRegion::Solid(number);
                }
            }
            PackSurface::OutOfSolid(number, normal) => {
                let medium = &self.shape.solids[number].medium;
                if cross_surface(&mut state.photon, normal, f64::from(medium.n_eff), 1.0, rng) {
                    self.lose(&mut state.photon, 1.0 - f64::from(medium.coat), observer, rng);
                    state.meetings += 1;
                    self.leave_solid(state, number);
                }
            }
        }
        None
    }

    #[inline(always)]
    fn book(&self, _: &Photon, fate: Fate, weight: f64, observer: &mut O) {
        observer.book(fate, weight);
    }
}

impl Target for PackGeometry {
    fn illuminate(&self, x: f64, y: f64, observer: &mut impl LineObserver, rng: &mut impl Rng) {
        let above = DVec3::new(x, y, self.shape.top + 1.0);
        let (length, stop) = self.shape.march(above, DVec3::NEG_Z, PackRegion::Above, f64::INFINITY);
        let position = above - DVec3::Z * length;
        let (position, normal, n, region, cell) = match stop {
            PackRayEnd::Face(PackFace::Upper, cell) => {
                let normal = self.shape.normal(cell, PackFace::Upper, position);
                (position, normal, self.shape.slab(cell).n, PackRegion::Film, cell)
            }
            // Through a hole onto a solid; what enters foil stays there.
            _ => match (self.shape.solid(above, DVec3::NEG_Z, None), self.shape.cell(above)) {
                (Some((number, length)), Some(cell)) => {
                    let position = above - DVec3::Z * length;
                    let solid = &self.shape.solids[number];
                    let normal = solid.normal(position.as_vec3()).as_dvec3();
                    (position, normal, f64::from(solid.medium.n_eff), PackRegion::Solid(number), cell)
                }
                (None, Some(cell)) if self.shape.cells[cell].foil => return observer.book(Fate::Absorbed, 1.0),
                _ => return observer.book(Fate::Lost, 1.0),
            },
        };
        let direction = refracted_into(DVec3::NEG_Z, -normal, 1.0 / n, fresnel_dielectric(1.0, n, normal.z).1);
        let photon = Photon { position, direction, weight: 1.0, layer: 0, path: 0.0, turned: 0, guided: 0 };
        let scale = std::f64::consts::PI / normal.dot(self.view).max(f64::from(LEAST_FACING));
        let clearance = Clearance::default();
        self.track(PackPhoton { photon, scale, region, cell, left: None, clearance, meetings: 0 }, observer, rng);
    }
}

impl PackGeometry {
    /// `pack` about `line`.
    pub(super) fn in_pack(pack: &Pack, line: &LineSource) -> Self {
        Self::new(PackShape::of(pack, line), line.view)
    }

    /// A shape, seen from `view`.
    fn new(shape: PackShape, view: DVec3) -> Self {
        let window = |cell: usize| {
            let film = shape.cells[cell].film;
            film.then(|| RefractedView::new(view, shape.cells[cell].normal, shape.slab(cell).n)).flatten()
        };
        let windows = (0..shape.cells.len()).map(window).collect();
        Self { shape, view, windows }
    }

    /// A flight in film or air to a collision, a surface or another region; `None` where the photon goes on at once.
    #[inline(always)]
    fn fly_in_film_or_air(
        &self,
        state: &mut PackPhoton,
        rng: &mut impl Rng,
    ) -> Option<FlightEnd<PackMedium, PackSurface>> {
        let (position, direction) = (state.photon.position, state.photon.direction);
        let region = state.region;
        let next = if region == PackRegion::Under { self.shape.solid(position, direction, state.left) } else { None };
        let free = match region {
            PackRegion::Film => -libm::log(uniform(rng)) / self.shape.slab(state.cell).extinction(),
            _ => next.map_or(f64::INFINITY, |(_, length)| length),
        };
        if region == PackRegion::Film && self.shape.stays(position + direction * free, state.cell) {
            state.photon.position += direction * free;
            state.photon.path += free;
            return Some(FlightEnd::Collision(PackMedium::Film(*self.shape.slab(state.cell))));
        }
        let (length, end) = self.shape.march(position, direction, region, free);
        state.photon.position += direction * length;
        Some(match end {
            PackRayEnd::Length => match next {
                Some((number, _)) => {
                    state.meetings += 1;
                    state.left = Some(number);
                    FlightEnd::Surface(PackSurface::IntoSolid(number))
                }
                None => {
                    state.photon.path += length;
                    if let Some(cell) = self.shape.cell(state.photon.position) {
                        state.cell = cell;
                    }
                    FlightEnd::Collision(PackMedium::Film(*self.shape.slab(state.cell)))
                }
            },
            PackRayEnd::Face(face, cell) => {
                state.meetings += 1;
                state.cell = cell;
                state.photon.path += length;
                state.left = None;
                FlightEnd::Surface(PackSurface::Face(face))
            }
            PackRayEnd::Region(other) => {
                state.region = other;
                return None;
            }
            PackRayEnd::Ground => FlightEnd::End(Fate::Dropped),
            PackRayEnd::Beyond if direction.z < 0.0 => FlightEnd::End(Fate::Dropped),
            PackRayEnd::Beyond => FlightEnd::End(Fate::Left),
            PackRayEnd::Lost => FlightEnd::End(Fate::Lost),
        })
    }

    /// A flight in a solid; `None` where rounding has put the photon out of it, which is mended.
    #[inline(always)]
    fn fly_in_solid(
        &self,
        state: &mut PackPhoton,
        number: usize,
        rng: &mut impl Rng,
    ) -> Option<FlightEnd<PackMedium, PackSurface>> {
        let solid = &self.shape.solids[number];
        let extinction = f64::from(solid.medium.mu_a) + f64::from(solid.medium.sigma_i);
        let photon = &mut state.photon;
        let free = -libm::log(uniform(rng)) / extinction;
        let far = if free < state.clearance.free(photon.position) {
            f64::INFINITY
        } else {
            let span = solid.span(photon.position.as_vec3(), photon.direction.as_vec3());
            span.map_or(0.0, |[_, far]| f64::from(far).max(0.0))
        };
        photon.position += photon.direction * free.min(far);
        photon.path += free.min(far);
        if free < far {
            if far < f64::INFINITY {
                state.clearance.renew(photon.position, solid, extinction);
            }
            return Some(FlightEnd::Collision(PackMedium::Solid(number)));
        }
        let normal = solid.normal(photon.position.as_vec3()).as_dvec3();
        if photon.direction.dot(normal) <= 0.0 {
            photon.position -= normal * PUSH_INSIDE_MM;
            return None;
        }
        Some(FlightEnd::Surface(PackSurface::OutOfSolid(number, normal)))
    }

    /// Light at a face of film or foil.
    fn cross_face(&self, state: &mut PackPhoton, face: PackFace, observer: &mut impl LineObserver, rng: &mut impl Rng) {
        let (shape, region) = (&self.shape, state.region);
        let normal = shape.normal(state.cell, face, state.photon.position);
        let sealed = face == PackFace::Lower && region == PackRegion::Film && shape.cells[state.cell].sealed;
        if face == PackFace::Foil || sealed {
            let facets = Microfacets::new(shape.metal(state.cell), normal);
            self.next_event_from_foil(state, &facets, sealed, observer, rng);
            self.lose(&mut state.photon, 1.0 - facets.reflectance, observer, rng);
            if state.photon.weight > 0.0 {
                state.photon.direction = facets.sample(state.photon.direction, rng);
            }
            return;
        }
        let n = shape.slab(state.cell).n;
        // The normal on the side that light goes to.
        let ahead = if (face == PackFace::Upper) == (region == PackRegion::Film) { normal } else { -normal };
        let beyond = match (region, face) {
            (PackRegion::Film, PackFace::Upper) => PackRegion::Above,
            (PackRegion::Film, _) => PackRegion::Under,
            _ => PackRegion::Film,
        };
        let (from, to) = if region == PackRegion::Film { (n, 1.0) } else { (1.0, n) };
        if cross_surface(&mut state.photon, ahead, from, to, rng) {
            state.region = beyond;
        }
    }

    /// Takes a share of the light away, and plays roulette with what is left.
    fn lose(&self, photon: &mut Photon, share: f64, observer: &mut impl LineObserver, rng: &mut impl Rng) {
        let lost = photon.weight * share;
        observer.book(Fate::Absorbed, lost);
        photon.weight -= lost;
        if photon.weight > 0.0 {
            self.roulette(photon, observer, rng);
        }
    }

    /// Puts light that has left a solid under the film: a little over the film's lower side where both touch.
    fn leave_solid(&self, state: &mut PackPhoton, number: usize) {
        state.clearance = Clearance::default();
        (state.region, state.left) = (PackRegion::Under, Some(number));
        let (shape, position) = (&self.shape, &mut state.photon.position);
        let Some(cell) = shape.cell(*position) else { return };
        state.cell = cell;
        if shape.cells[cell].film {
            let (lower, upper) =
                (shape.height(cell, PackFace::Lower, *position), shape.height(cell, PackFace::Upper, *position));
            if position.z > lower && position.z < upper {
                position.z = lower;
            }
        }
    }
}

/// A direction beyond a surface whose normal there is `ahead`, with this ratio of indices and cosine.
fn refracted_into(direction: DVec3, ahead: DVec3, ratio: f64, cosine: f64) -> DVec3 {
    refracted(direction * ratio, ahead, ratio * direction.dot(ahead), cosine)
}

/// Takes light through a smooth surface or back: whether it is through. `ahead` is the normal on the far side.
fn cross_surface(photon: &mut Photon, ahead: DVec3, n: f64, other: f64, rng: &mut impl Rng) -> bool {
    let mu = photon.direction.dot(ahead).clamp(0.0, 1.0);
    let beyond = transmitted(n, other, mu, rng);
    match beyond {
        Some(cosine) => {
            photon.direction = refracted_into(photon.direction, ahead, n / other, cosine);
        }
        None => photon.reflect(ahead, mu),
    }
    beyond.is_some()
}
