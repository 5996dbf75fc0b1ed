//! Matter below the pixels of a picture: a map for the thesis' methods, coefficients of diffusion for the right one.
//!
//! From media to a map: direction is the fibre's track in the surface; fibres steeper than 84 degrees have none. Alpha
//! is the reflectance of the medium over that of clear wood with fibres in the surface, both from the closed form of
//! diffusion below a plane, R = 1/2 (e^(-z0 K) + e^(-z2 K)), K = sqrt(mu_a / D_zz) (docs/theory/physics.md). From 0.8
//! upwards it counts as 1, since the thesis' map is opaque but for the knots, and any other alpha spreads evenly. A
//! sound knot gets 0.55, against the 0.5 that the thesis measured. Neglected: relief other than the fibre's angle with
//! the surface.

use base::{Body, Class, Medium};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::DirectionMap;
use transport::fresnel::BoundaryTable;
use transport::kernel::diffusion;

/// Alpha from which wood counts as clear [1].
pub(crate) const CLEAR_FROM: f64 = 0.8;
/// What alpha is relative to: clear spruce with fibres in the surface.
const CLEAR_WOOD: Medium = Medium::CLEAR_WOOD;
/// Length of the track of a unit vector along the fibre below which it has no direction.
const MIN_TRACK: f64 = 0.1;

/// How light walks below one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarDiffusion {
    /// Unit vector along the fibre's track in the surface.
    pub axis: DVec2,
    /// Coefficient of diffusion along it [mm].
    pub along: f64,
    /// Coefficient across it [mm].
    pub across: f64,
    /// Coefficient along the surface's normal [mm].
    pub down: f64,
    /// Absorption [mm^-1].
    pub mu_a: f64,
    /// Depth at which light from above begins to diffuse [mm].
    pub z0: f64,
    /// The same plus twice the height at which the fluence vanishes [mm].
    pub z2: f64,
}

impl PlanarDiffusion {
    /// Of a medium whose fibre is given with z along the surface's normal.
    pub fn new(medium: &Medium, boundary: &BoundaryTable) -> Self {
        let fibre = medium.fibre.as_dvec3();
        let (sigma_i, k) = (f64::from(medium.sigma_i), f64::from(medium.k));
        let (par, perp) = diffusion(sigma_i, k);
        let sin2 = (fibre.z * fibre.z).min(1.0);
        let cos2 = 1.0 - sin2;
        let down = perp + (par - perp) * sin2;
        let z0 = cos2 / (sigma_i + k * cos2.sqrt()) + sin2 / sigma_i;
        let z2 = z0 + 4.0 * f64::from(boundary.at(medium.n_eff)) * down;
        let axis = fibre.truncate().try_normalize().unwrap_or(DVec2::Y);
        Self { axis, along: perp * par / down, across: perp, down, mu_a: f64::from(medium.mu_a), z0, z2 }
    }

    /// Share of light that entered and comes out again [1].
    pub fn reflectance(&self) -> f64 {
        let decay = (self.mu_a / self.down).sqrt();
        0.5 * (libm::exp(-self.z0 * decay) + libm::exp(-self.z2 * decay))
    }

    /// Share that comes out per path length after `path`, were nothing absorbed [mm^-1].
    pub fn rate(&self, path: f64) -> f64 {
        let term = |z: f64| z * libm::exp(-z * z / (4.0 * self.down * path));
        (term(self.z0) + term(self.z2)) / (4.0 * path * (std::f64::consts::PI * self.down * path).sqrt())
    }
}

/// Alpha of a map for a medium that returns this share of what enters, by the rule above [1].
pub fn alpha(reflectance: f64, boundary: &BoundaryTable) -> f64 {
    let ratio = reflectance / PlanarDiffusion::new(&CLEAR_WOOD, boundary).reflectance();
    if ratio >= CLEAR_FROM { 1.0 } else { ratio }
}

/// What lies below each pixel of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct PixelGround {
    /// Side of a pixel [mm].
    pub pitch_mm: f64,
    /// Directions and alpha; transparent beside the body.
    pub map: DirectionMap,
    /// How light walks, `[rows, cols]`; `None` beside the body.
    pub walks: Vec<Option<PlanarDiffusion>>,
}

impl PixelGround {
    /// Of media, `[rows, cols]`, row-major, row 0 at the smallest y, fibres given with z along the surface's normal.
    ///
    /// # Panics
    /// Where there are not rows times cols media.
    pub fn new(rows: usize, cols: usize, pitch_mm: f64, media: &[Option<Medium>]) -> Self {
        let boundary = BoundaryTable::new();
        let walks: Vec<_> = media
            .par_iter()
            .map(|medium| medium.as_ref().map(|medium| PlanarDiffusion::new(medium, &boundary)))
            .collect();
        let paint = |(medium, walk): (&Option<Medium>, &Option<PlanarDiffusion>)| match (medium, walk) {
            (Some(medium), Some(walk)) => {
                let track = medium.fibre.as_dvec3().truncate();
                let direction = (track.length() > MIN_TRACK).then_some(track);
                DirectionMap::colour(direction, alpha(walk.reflectance(), &boundary))
            }
            _ => [0; 4],
        };
        let map = DirectionMap::new(rows, cols, media.iter().zip(&walks).map(paint).collect());
        Self { pitch_mm, map, walks }
    }

    /// Of a body, pixels of `pitch_mm` from the pixel whose middle is at `first` [mm].
    pub(crate) fn of_body(body: &Body, first: DVec2, pitch_mm: f64, rows: usize, cols: usize) -> Self {
        let row = |row: usize| {
            let slice = body.slice((first.y + pitch_mm * row as f64) as f32);
            let at = |col: usize| {
                let x = (first.x + pitch_mm * col as f64) as f32;
                let surface = slice.surface(x)?;
                let matter = slice.matter(x, surface.z);
                let normal = DVec3::new(f64::from(-surface.slope_x), f64::from(-surface.slope_y), 1.0).normalize();
                let fibre = matter.medium.fibre.as_dvec3();
                let dive = fibre.dot(normal).clamp(-1.0, 1.0);
                let track = (fibre - normal * dive).truncate().normalize_or_zero() * (1.0 - dive * dive).sqrt();
                let fibre = track.extend(dive).as_vec3();
                (matter.class != Class::Background).then_some(Medium { fibre, ..matter.medium })
            };
            (0..cols).map(at).collect::<Vec<_>>()
        };
        let media: Vec<_> = (0..rows).into_par_iter().flat_map_iter(row).collect();
        Self::new(rows, cols, pitch_mm, &media)
    }
}
