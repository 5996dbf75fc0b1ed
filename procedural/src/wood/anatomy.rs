//! Resin canals, vessels (pores) and rays that the face cuts.
//!
//! Models: canals and vessels are tubes along the grain. The plane across it, bundle by time of growth, is divided into
//! cells, turned against both and bent by noise over some cells, so that no rows of them cross a face. A cell holds one
//! tube at a place of its own that wanders along the grain, so that tubes enter and leave the face and show as short
//! lines where it cuts them. A number n of tubes of diameter d per mm2 leave a face parallel to them n d of open tube
//! per mm. Canals are full of resin and stand mostly in latewood. Vessels are open: the face is a groove, d/2 deep in
//! its middle, whose wall may hold dust. In ring-porous wood vessels are few and narrow outside the earlywood. Rays are
//! sheets along the radius. The coordinates are the arc a = R phi at the fixed radius R of the face's middle, and l:
//! each cell holds an ellipse of the asked height and width, at a place of its own that wanders outwards. Where the
//! face runs along the radius it runs within such a sheet and a fleck appears, w / sin of the angle long, wander
//! included; across it the same ray is a short line. The share of the face is that of the volume at every angle. In a
//! ray cells lie along the radius. Light that enters a ray thicker than a free path ([`FREE_PATH_MM`]) meets these; one
//! that is thinner it has left before they turn it, and its fibres are those of the wood around. A mean of both
//! directions would not do: two axes at right angles have none. Fibres part around broad rays and light leaves through
//! both, so directions there are as dispersed as the kernel's tables span, a guess. Tubes that would fill more than
//! [`FULL`] of their cell's width are narrowed to that (`widest_tube_um`). Sources: docs/theory/wood.md. Limits: what
//! lies below the face is as at the face; no tyloses, no perforated ends, no radial canals, no multiples of vessels;
//! details below a pixel are seen at points, not averaged.

use base::Stream;
use glam::{Vec2, Vec3};

use super::Wood;
use super::face_grain::FaceGrain;
use super::pith::LogPoint;
use crate::noise::{Noise, smoothstep};

/// Turn of the cells of tubes [1], of cosine and sine.
const TURN: Vec2 = Vec2::new(0.838_67, 0.544_64);
/// Bending of the rows of cells, root mean square, and the cell of the noise that bends them [cells].
const BEND: [f32; 2] = [1.2, 8.0];
/// Where the noise for the second direction is read, away from that for the first [cells of the noise].
const SECOND: Vec2 = Vec2::new(531.3, 217.7);
/// Wander of a tube across the grain over its free room, root mean square [1], and its cell along the grain [mm].
const WANDER: [f32; 2] = [0.3, 9.0];
/// Share of canals that stand in earlywood over that in latewood [1].
const CANALS_EARLY: f32 = 0.15;
/// Share and size of vessels in the latewood of fully ring-porous wood [1].
const LATE_VESSELS: [f32; 2] = [0.35, 0.25];
/// How far a ray wanders around the log to either side, and half a period of that outwards [mm].
const RAY_WANDER: [f32; 2] = [0.2, 6.0];
/// Most of its cell that a tube may fill [1].
const FULL: f32 = 0.85;
/// Path of light across the fibres before it is turned [mm]: that of wood with sigma_i + k = 12 per mm.
const FREE_PATH_MM: f32 = 0.08;
/// Dispersion of directions in a broad ray [deg].
pub(super) const RAY_DISPERSION_DEG: f32 = 14.0;
/// Depth of a groove over its vessel's diameter [1].
const GROOVE: f32 = 0.5;

/// Tubes along the grain.
#[derive(Debug, Clone, Copy)]
struct Tubes {
    /// Side of a cell [mm] and radius of a tube [mm].
    cell: f32,
    radius: f32,
    noise: Noise,
}

/// Rays.
#[derive(Debug, Clone, Copy)]
struct Rays {
    /// Sides of a cell around and along, half width and half height [mm].
    cell: Vec2,
    half: Vec2,
    /// Radius at which the arc is counted [mm].
    radius: f32,
    tissue: RayTissue,
    noise: Noise,
}

/// Canals, vessels and rays of a board.
#[derive(Debug, Clone)]
pub(super) struct Anatomy {
    canals: Option<Tubes>,
    pores: Option<Tubes>,
    ring_porous: f32,
    dust: f32,
    rays: Option<Rays>,
}

/// The widest tubes that have room where so many stand across the grain [um]; wider ones are narrowed to it.
pub fn widest_tube_um(per_mm2: f64) -> f64 {
    1000.0 * f64::from(FULL) / per_mm2.sqrt()
}

impl Tubes {
    fn new(stream: Stream, per_mm2: f64, um: f64) -> Option<Self> {
        let cell = (1.0 / per_mm2).sqrt() as f32;
        let radius = (0.5e-3 * um as f32).min(0.5 * FULL * cell);
        (per_mm2 > 0.0).then(|| Self { cell, radius, noise: Noise::new(stream) })
    }

    /// Distance from the tube of the cell that holds a place, over its radius, and its rank among all, 0 to 1 [1].
    #[inline]
    fn at(&self, place: Vec3) -> (f32, f32) {
        let q = TURN.rotate(place.truncate()) / self.cell;
        let bend = |from: Vec2| self.noise.plane(q / BEND[1] + from).0;
        let q = q + BEND[0] * Vec2::new(bend(Vec2::ZERO), bend(SECOND));
        let (i, j) = (q.x.floor(), q.y.floor());
        // One draw for a cell, and a tube that wanders from it.
        let key = self.noise.cell(i as i32, j as i32);
        let room = 1.0 - 2.0 * self.radius / self.cell;
        let along = place.z / WANDER[1] + 17.0 * key[3];
        let wander = |seed: f32| {
            let at = along + 311.0 * seed;
            // Two waves whose periods have no common multiple.
            WANDER[0] * (0.7 * wave(at) + 0.5 * wave(0.37 * at + seed))
        };
        let centre = |n: usize| {
            let free = 0.5 + (key[n] - 0.5) * 0.7 + 0.5 * wander(key[n] + key[3]);
            0.5 * (1.0 - room) + room * free.clamp(0.0, 1.0)
        };
        let d = Vec2::new(q.x - i - centre(0), q.y - j - centre(1));
        (d.length() * self.cell / self.radius, key[2])
    }
}

/// A smooth wave of period 2 between -1 and 1 [1].
#[inline]
fn wave(at: f32) -> f32 {
    let u = at - 2.0 * (0.5 * at).floor() - 1.0;
    4.0 * u * (1.0 - u.abs())
}

/// What a ray changes.
#[derive(Debug, Clone, Copy)]
pub(super) struct RayTissue {
    /// Factor on absorption [1].
    pub mu_a: f32,
    /// Whether light meets cells along the radius.
    pub is_broad: bool,
}

/// What the anatomy adds at a spot of the face.
#[derive(Debug, Clone, Copy)]
pub(super) struct FaceAnatomy {
    /// Share of resin in a canal [1].
    pub resin: f32,
    /// Light that dust in a pore lets through [1].
    pub through: f32,
    /// The ray that it lies in.
    pub ray: Option<RayTissue>,
}

impl Anatomy {
    /// The anatomy of a board whose face's middle lies at `middle` in the log.
    pub fn grow(stream: Stream, wood: &Wood, middle: &LogPoint) -> Self {
        let asked = &wood.anatomy;
        let rays = (asked.ray_share > 0.0).then(|| {
            let half = 0.5 * Vec2::new(1.0e-3 * asked.ray_width_um as f32, asked.ray_height_mm as f32);
            // An ellipse of the asked share in a cell 1.5 times as high as it.
            let high = 3.0 * half.y;
            let wide = std::f32::consts::PI * half.x * half.y / (asked.ray_share as f32 * high);
            Rays {
                cell: Vec2::new(wide, high),
                half,
                radius: middle.r.max(5.0),
                tissue: RayTissue { mu_a: asked.ray_mu_a_ratio as f32, is_broad: 2.0 * half.x > FREE_PATH_MM },
                noise: Noise::new(stream.child("rays")),
            }
        });
        Self {
            canals: Tubes::new(stream.child("canals"), asked.canals_per_mm2, asked.canal_um),
            pores: Tubes::new(stream.child("pores"), asked.pores_per_mm2, asked.pore_um),
            ring_porous: asked.pore_ring as f32,
            dust: asked.pore_dust as f32,
            rays,
        }
    }

    /// How open a vessel is here: distance across it as 1 - x^2, 0 outside [1].
    #[inline]
    fn pore(&self, place: Vec3, latewood: f32) -> f32 {
        let Some(pores) = &self.pores else { return 0.0 };
        let (x, rank) = pores.at(place);
        let late = self.ring_porous * latewood;
        if rank > 1.0 - late * (1.0 - LATE_VESSELS[0]) {
            return 0.0;
        }
        let x = x / (1.0 - late * (1.0 - LATE_VESSELS[1]));
        (1.0 - x * x).max(0.0)
    }

    /// Depth of a vessel's groove at a place with this share of latewood [mm].
    #[inline]
    pub fn groove(&self, place: Vec3, latewood: f32) -> f32 {
        let Some(pores) = &self.pores else { return 0.0 };
        2.0 * GROOVE * pores.radius * self.pore(place, latewood).sqrt()
    }

    /// Whether there are grooves.
    pub fn is_open(&self) -> bool {
        self.pores.is_some()
    }

    /// What the face cuts at a place of the face's grain, `point` in the log.
    #[inline]
    pub fn at(&self, grain: &FaceGrain, point: &LogPoint, latewood: f32) -> FaceAnatomy {
        let place = Vec3::new(grain.bundle, grain.t, grain.l);
        let resin = self.canals.as_ref().map_or(0.0, |canals| {
            let (x, rank) = canals.at(place);
            let stands = rank < CANALS_EARLY + (1.0 - CANALS_EARLY) * latewood;
            if stands { 1.0 - smoothstep(0.8, 1.0, x) } else { 0.0 }
        });
        let open = self.pore(place, latewood);
        let through = 1.0 - self.dust * smoothstep(0.0, 0.6, open);
        let ray = self.rays.as_ref().and_then(|rays| rays.is_at(point).then_some(rays.tissue));
        FaceAnatomy { resin, through, ray }
    }
}

impl Rays {
    #[inline]
    fn is_at(&self, point: &LogPoint) -> bool {
        let a = self.radius * point.phi / self.cell.x;
        let column = a.floor();
        // Each column of cells begins at a place of its own.
        let shift = self.noise.cell(column as i32, 0)[0];
        let b = point.l / self.cell.y + shift;
        let row = b.floor();
        let key = self.noise.cell(column as i32, row as i32 + 1);
        let room = (1.0 - 2.0 * self.half / self.cell).max(Vec2::ZERO);
        let wander = (RAY_WANDER[0] / self.cell.x).min(0.5 * room.x);
        let at = point.r / RAY_WANDER[1] + 17.0 * key[2];
        let swing = wander * (0.7 * wave(at) + 0.3 * wave(2.3 * at + key[3]));
        let x = 0.5 + (room.x - 2.0 * wander) * (key[0] - 0.5) + swing;
        let centre = Vec2::new(x, 0.5 + room.y * (key[1] - 0.5));
        let d = (Vec2::new(a - column, b - row) - centre) * self.cell / self.half;
        d.length_squared() < 1.0
    }
}
