//! Monte Carlo of light in a body of any shape and matter: photons below a height field.
//!
//! Model: radiance in a body whose absorption, scattering and fibre direction change from point to point
//! ([`Medium`](base::Medium), cylinders that turn light evenly about themselves), below a relief with cracks,
//! sides and bottom ([`height_field`]), with Fresnel's law wherever light meets a surface. Matter is the same within
//! cells of 0.1 mm ([`medium_cache`]).
//!
//! Free paths are drawn cell by cell: the optical depth of a path is drawn once and used up by the extinction of each
//! cell passed, mu_a + sigma_i + k. This is delta tracking (Woodcock 1965) with a majorant of each cell's own, which
//! the cell's matter cannot exceed; what is null is only the cylinder that shows less than its whole width.
//!
//! At surfaces Fresnel's law with the local index decides by chance. Light outside goes straight on; where it meets the
//! body again, across a crack for one, Fresnel's law decides again. So cracks need no rule of their own. A coat of the
//! face takes its share of what passes either way.
//!
//! Towards the lens each collision gives its share as in plane layers, times exp(-depth) along the straight line up,
//! with the mean extinction over fibre directions in each cell. The direction inside is the view refracted at the
//! surface's normal, averaged over a mm: finer relief would only blur it. Radiance towards the lens goes with 1 /
//! facing, facing the cosine between view and normal, as in plane layers; so the factor of a collision is pi T / (n^2
//! cos), with the cosine of the direction inside, and a white Lambertian surface returns what entered however it is
//! tilted. Where that line ends on a wall, or the body stands between its end and the lens, the lens sees nothing.
//! Which lines are followed is left to chance by what they promise to bring, so that most of the time goes where light
//! comes from.
//!
//! Source: Woodcock et al. 1965 for free paths. Neglected: refraction on entry, bending of light where n_eff changes
//! inside, roughness finer than 0.1 mm, cracks narrower than 0.2 mm, light beyond 20 mm from the line's grid (it is
//! booked as lost), light to the lens through walls other than the front face and through sides of cracks.

mod height_field;
mod medium_cache;
#[cfg(test)]
mod tests;

use std::f64::consts::PI;

use base::Medium;
use glam::DVec3;
use rand::Rng;

use self::height_field::{CellIndex, HeightField, RayEnd};
use self::medium_cache::{MediumCache, axis, dispersion, extinction};
use super::LONGEST_MM;
use super::next_event::mean_sine;
use super::tracker::{Fate, FlightEnd, Geometry, LineObserver, Photon, RouletteOrder, Target, refracted, transmitted};
use crate::phase::{cylinder_towards, dispersed, fibre_collision, frame, uniform};
use transport::fresnel::fresnel_dielectric;
use transport::line::LineSource;
use transport::stack::CylinderPhase;

/// Meetings with surfaces after which light is given up: it is caught in a wedge.
const MAX_MEETINGS: u32 = 10_000;
/// Slope from which on a surface is a wall, through which the lens does not look [1].
const WALL_SLOPE: f64 = 2.0;
/// Light from so far behind a front face is followed to the lens through it, and the least cosine between its normal
/// and the motion [mm], [1].
const FRONT_REACH_MM: f64 = 4.0;
const FRONT_FACING: f64 = 0.9;
/// Surface that stands so far above a point nearby may hide it from the lens [mm].
const HIDES_MM: f64 = 0.1;
/// Light to the lens that is always followed, and depth below which no more is given up for depth [1], [mm].
const SURE_LIGHT: f64 = 0.1;
const MAX_JUDGED_DEPTH_MM: f64 = 1.0;
/// Optical depth from which on chance decides whether a line to the lens is followed on, and its chance.
const FAINT_DEPTH: f64 = 4.0;
const FAINT_CHANCE: f64 = 0.25;

/// A body about a line of light, as photons meet it.
#[derive(Debug)]
pub(super) struct BodyGeometry<'a> {
    media: MediumCache<'a>,
    view: DVec3,
    sines: MeanSineTable,
    /// Place along y of the front face in each cell along x; `None` where no row shows it [mm].
    fronts: Vec<Option<f64>>,
}

/// A photon in a body, or in the air about it.
#[derive(Debug, Clone, Copy)]
pub(super) struct BodyPhoton {
    photon: Photon,
    /// Whether it is in the air.
    outside: bool,
    /// Surfaces that it has met.
    meetings: u32,
}

impl AsMut<Photon> for BodyPhoton {
    #[inline(always)]
    fn as_mut(&mut self) -> &mut Photon {
        &mut self.photon
    }
}

/// A surface through which the lens may see a collision.
#[derive(Debug, Clone, Copy)]
struct Window {
    normal: DVec3,
    /// How far below it the collision is, roughly [mm].
    below: f64,
    /// Cosine between it and the view, over that of the face above [1].
    share: f64,
}

/// Light on its way to the lens, where it leaves a surface.
#[derive(Debug, Clone, Copy)]
struct SeenLight {
    position: DVec3,
    cell: CellIndex,
    light: f64,
}

/// A surface of a body.
#[derive(Debug, Clone, Copy)]
pub(super) enum BodySurface {
    /// Its relief, in this cell.
    Top(CellIndex),
    /// Its bottom, on the conveyor.
    Bottom,
}

impl<O: LineObserver> Geometry<O> for BodyGeometry<'_> {
    type State = BodyPhoton;
    type Medium<'g>
        = (&'g Medium, CellIndex)
    where
        Self: 'g;
    type Surface = BodySurface;
    const ROULETTE_ORDER: RouletteOrder = RouletteOrder::AfterScattering;

    #[inline(always)]
    fn fly(&self, state: &mut BodyPhoton, rng: &mut impl Rng) -> FlightEnd<(&Medium, CellIndex), BodySurface> {
        if state.outside {
            return self.fly_outside(state);
        }
        let photon = &mut state.photon;
        let mut depth = -libm::log(uniform(rng));
        let mut medium = None;
        let end = self.media.heights().march(photon.position, photon.direction, true, |cell, length| {
            let here = self.media.at(cell);
            let (extinction, passed) = (extinction(here), extinction(here) * length);
            if passed < depth {
                depth -= passed;
                return None;
            }
            medium = Some((here, cell));
            Some(if extinction > 0.0 { depth / extinction } else { 0.0 })
        });
        let (RayEnd::Taken(length) | RayEnd::Surface(length, _) | RayEnd::Ground(length) | RayEnd::Beyond(length)) =
            end;
        photon.position += photon.direction * length;
        photon.path += length;
        if photon.path > LONGEST_MM || state.meetings > MAX_MEETINGS {
            return FlightEnd::End(Fate::Lost);
        }
        match (end, medium) {
            (RayEnd::Taken(_), Some(medium)) => FlightEnd::Collision(medium),
            (RayEnd::Surface(_, cell), _) => {
                state.meetings += 1;
                FlightEnd::Surface(BodySurface::Top(cell))
            }
            (RayEnd::Ground(_), _) => {
                state.meetings += 1;
                // Back into the lowest cells by the sign of its direction, whatever rounding did to the height.
                photon.position.z = 0.0;
                FlightEnd::Surface(BodySurface::Bottom)
            }
            (RayEnd::Taken(_), None) | (RayEnd::Beyond(_), _) => FlightEnd::End(Fate::Lost),
        }
    }

    /// Shows the lens what a collision sends towards it, through the face above and through a front face nearby.
    #[inline(never)]
    fn next_event(
        &self,
        BodyPhoton { photon, .. }: &BodyPhoton,
        (medium, cell): (&Medium, CellIndex),
        observer: &mut O,
        rng: &mut impl Rng,
    ) {
        let heights = self.media.heights();
        let normal = heights.lean(cell);
        let facing = self.view.dot(normal);
        if facing <= 0.0 {
            return;
        }
        let below = heights.around(cell) - photon.position.z;
        if let Some(seen) = self.send_to_lens(photon, medium, Window { normal, below, share: 1.0 }, rng) {
            let upright = heights.normal(seen.cell, seen.position).z;
            if upright * upright * (1.0 + WALL_SLOPE * WALL_SLOPE) >= 1.0 && !self.hidden(seen.position, seen.cell) {
                observer.see(seen.position, seen.light * self.media.coat(seen.cell));
            }
        }
        let front_facing = self.view.dot(DVec3::NEG_Y);
        let below = self.fronts[cell[0]].map_or(f64::INFINITY, |front| photon.position.y - front);
        if front_facing <= 0.0 || below > FRONT_REACH_MM {
            return;
        }
        let front = Window { normal: DVec3::NEG_Y, below, share: front_facing / facing };
        let Some(seen) = self.send_to_lens(photon, medium, front, rng) else { return };
        let inside = seen.position + DVec3::Y * heights.pitch.y;
        if heights.normal(seen.cell, seen.position).y > -FRONT_FACING
            || !matches!(heights.march(seen.position, self.view, false, |_, _| None), RayEnd::Beyond(_))
        {
            return;
        }
        // The sensor row looks at the place where the line of sight crosses the face's level.
        let rise = heights.above(inside).map_or(0.0, |top| (top - seen.position.z).max(0.0));
        observer.see(seen.position + self.view * (rise / self.view.z), seen.light);
    }

    #[inline(always)]
    fn absorbed(&self, photon: &Photon, (medium, _): (&Medium, CellIndex)) -> f64 {
        photon.weight * f64::from(medium.mu_a) / extinction(medium)
    }

    #[inline(always)]
    fn scatter(&self, photon: &mut Photon, (medium, _): (&Medium, CellIndex), rng: &mut impl Rng) {
        let axis = axis(medium);
        let fibre = |rng: &mut _| dispersed(axis, frame(axis), dispersion(medium), rng);
        let (sigma_i, k) = (f64::from(medium.sigma_i), f64::from(medium.k));
        if sigma_i + k > 0.0 {
            let collision = fibre_collision(photon.direction, sigma_i, k, rng, fibre);
            photon.scatter_by(collision, CylinderPhase::Cauchy(0.0), rng);
        }
    }

    fn cross(
        &self,
        state: &mut BodyPhoton,
        surface: BodySurface,
        observer: &mut O,
        rng: &mut impl Rng,
    ) -> Option<Fate> {
        let photon = &mut state.photon;
        let outward = match surface {
            BodySurface::Top(cell) => self.media.heights().normal(cell, photon.position),
            BodySurface::Bottom => DVec3::NEG_Z,
        };
        let index = self.index(photon.position);
        let (ahead, n, other) = if state.outside { (-outward, 1.0, index) } else { (outward, index, 1.0) };
        let mu = photon.direction.dot(ahead).clamp(0.0, 1.0);
        match transmitted(n, other, mu, rng) {
            Some(cosine) => {
                // In this order both ways round as their ratio does: one of the indices is 1.
                photon.direction = refracted(photon.direction * n / other, ahead, n * mu / other, cosine);
                if let BodySurface::Top(cell) = surface {
                    self.pass_coat(photon, cell, observer);
                }
                state.outside = !state.outside;
            }
            None => photon.reflect(ahead, mu),
        }
        match surface {
            BodySurface::Bottom if state.outside => Some(Fate::Dropped),
            BodySurface::Bottom | BodySurface::Top(_) => None,
        }
    }

    #[inline(always)]
    fn book(&self, _: &Photon, fate: Fate, weight: f64, observer: &mut O) {
        observer.book(fate, weight);
    }
}

impl Target for BodyGeometry<'_> {
    fn illuminate(&self, x: f64, y: f64, observer: &mut impl LineObserver, rng: &mut impl Rng) {
        match self.media.heights().above(DVec3::new(x, y, 0.0)) {
            Some(z) => {
                let (position, direction) = (DVec3::new(x, y, z), DVec3::NEG_Z);
                let mut photon = Photon { position, direction, weight: 1.0, layer: 0, path: 0.0, turned: 0, guided: 0 };
                self.pass_coat(&mut photon, self.media.heights().cell(position), observer);
                self.track(BodyPhoton { photon, outside: false, meetings: 0 }, observer, rng);
            }
            None => observer.book(Fate::Lost, 1.0),
        }
    }
}

impl<'a> BodyGeometry<'a> {
    /// The body that `line` falls on.
    pub fn about(line: &LineSource<'a>) -> Self {
        let (heights, cuts) = HeightField::new(line);
        let fronts = heights.fronts(line);
        Self { media: MediumCache::new(heights, cuts), view: line.view, sines: MeanSineTable::new(), fronts }
    }

    /// Leaves in the coat over a cell what it takes.
    fn pass_coat(&self, photon: &mut Photon, cell: CellIndex, observer: &mut impl LineObserver) {
        let left = photon.weight * self.media.coat(cell);
        observer.book(Fate::Absorbed, photon.weight - left);
        photon.weight = left;
    }

    /// Refractive index of the body at its surface [1].
    fn index(&self, position: DVec3) -> f64 {
        f64::from(self.media.at(self.media.heights().cell(position)).n_eff)
    }

    /// A flight through the air.
    fn fly_outside(&self, state: &mut BodyPhoton) -> FlightEnd<(&Medium, CellIndex), BodySurface> {
        let photon = &mut state.photon;
        if state.meetings > MAX_MEETINGS {
            return FlightEnd::End(Fate::Lost);
        }
        match self.media.heights().march(photon.position, photon.direction, false, |_, _| None) {
            RayEnd::Surface(length, cell) => {
                state.meetings += 1;
                photon.position += photon.direction * length;
                FlightEnd::Surface(BodySurface::Top(cell))
            }
            RayEnd::Ground(_) => FlightEnd::End(Fate::Dropped),
            // Beside the body the region ends; what sinks there meets the conveyor farther off.
            RayEnd::Beyond(_) | RayEnd::Taken(_) if photon.direction.z < 0.0 => FlightEnd::End(Fate::Dropped),
            RayEnd::Beyond(_) | RayEnd::Taken(_) => FlightEnd::End(Fate::Left),
        }
    }

    /// What of a collision's light reaches the lens through a window; `None` where chance or matter ends it, or it
    /// meets no surface.
    #[inline(always)]
    fn send_to_lens(&self, photon: &Photon, medium: &Medium, window: Window, rng: &mut impl Rng) -> Option<SeenLight> {
        let Window { normal, below, share } = window;
        let (heights, n, facing) = (self.media.heights(), f64::from(medium.n_eff), self.view.dot(normal));
        let cosine = (1.0 - (1.0 - facing * facing) / (n * n)).max(0.0).sqrt();
        if cosine <= 0.0 {
            return None;
        }
        let direction = ((self.view - normal * facing) / n + normal * cosine).normalize();
        let turned = f64::from(medium.sigma_i) / (4.0 * PI)
            + f64::from(medium.k)
                * cylinder_towards(
                    photon.direction,
                    direction,
                    axis(medium),
                    CylinderPhase::Cauchy(0.0),
                    dispersion(medium),
                    rng,
                );
        let factor = PI * (1.0 - fresnel_dielectric(n, 1.0, cosine).0) / (n * n * cosine);
        let mut light = photon.weight * turned / extinction(medium) * factor * share;
        // Chance decides which of the many dim or deep ones are worth following; the depth need not be right for that.
        let worth = light / SURE_LIGHT * libm::exp(-0.5 * below.min(MAX_JUDGED_DEPTH_MM) * extinction(medium));
        if worth < 1.0 {
            if uniform(rng) > worth {
                return None;
            }
            light /= worth;
        }
        let (mut depth, mut faint) = (0.0, FAINT_DEPTH);
        let stop = heights.march(photon.position, direction, true, |cell, length| {
            let here = self.media.at(cell);
            let sine = self.sines.at(axis(here).dot(direction), here.dispersion_deg);
            depth += length * (f64::from(here.mu_a) + f64::from(here.sigma_i) + f64::from(here.k) * sine);
            while depth > faint {
                if uniform(rng) > FAINT_CHANCE {
                    return Some(0.0);
                }
                light /= FAINT_CHANCE;
                faint -= libm::log(FAINT_CHANCE);
            }
            None
        });
        let RayEnd::Surface(length, cell) = stop else { return None };
        Some(SeenLight { position: photon.position + direction * length, cell, light: light * libm::exp(-depth) })
    }

    /// Whether the body stands between a point on it and the lens.
    #[inline]
    fn hidden(&self, position: DVec3, cell: CellIndex) -> bool {
        let heights = self.media.heights();
        heights.around(cell) > position.z + HIDES_MM
            && !matches!(heights.march(position, self.view, false, |_, _| None), RayEnd::Beyond(_))
    }
}

/// Mean sine between light and wood's fibres, from a table: linear in the root of 1 - |cos| and in whole degrees of
/// dispersion, good to 5e-4.
#[derive(Debug)]
struct MeanSineTable(Vec<Vec<f64>>);

impl MeanSineTable {
    const TABLE_STEPS: f64 = 512.0;
    /// Most dispersion that a body has [deg].
    const MOST_DISPERSION_DEG: f32 = 14.0;

    fn new() -> Self {
        let along = |i: usize| 1.0 - (i as f64 / Self::TABLE_STEPS).powi(2);
        let of = |dispersion: f64| {
            (0..=Self::TABLE_STEPS as usize + 1).map(|i| mean_sine(along(i).max(0.0), dispersion)).collect()
        };
        Self((0..=Self::MOST_DISPERSION_DEG as usize + 1).map(|degrees| of((degrees as f64).to_radians())).collect())
    }

    #[inline(always)]
    fn at(&self, along: f64, dispersion_deg: f32) -> f64 {
        let position = (1.0 - along.abs()).max(0.0).sqrt() * Self::TABLE_STEPS;
        let i = position as usize;
        let of =
            |degrees: usize| self.0[degrees][i] + (self.0[degrees][i + 1] - self.0[degrees][i]) * (position - i as f64);
        let dispersion = dispersion_deg.clamp(0.0, Self::MOST_DISPERSION_DEG);
        let (degrees, part) = (dispersion as usize, f64::from(dispersion.fract()));
        if part == 0.0 { of(degrees) } else { of(degrees) + (of(degrees + 1) - of(degrees)) * part }
    }
}
