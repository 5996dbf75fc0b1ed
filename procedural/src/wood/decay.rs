//! Rot: along one long edge of the board, about the pith, and in pockets.
//!
//! Models: a front at the asked distance from the edge or from the pith, or around spindles along the grain, that
//! wanders with elongated noise; where fronts meet the farther advanced counts. Severity rises across the front along a
//! smooth step. With severity s and v = 2 s, absorption is mu_a,clear (mu_a,rot / mu_a,clear)^v, every other
//! coefficient is clear + v (rot - clear): at s = 1/2 the medium is that of the class table. Before the front lies a
//! rim of reaction that absorbs half as much again, or a wider zone of incipient decay, discoloured as wood of a fifth
//! of the severity. A point is decayed where at least half of the front has passed. What is inside of it is in
//! `decay_texture`. Sources: class table and sizes in docs/theory/wood.md. Limits: heart rot does not taper.

use base::{Class, Instance, KERNEL_INDICES, Stream, lognormal};
use glam::Vec3;
use rand::RngExt;

use super::Wood;
use super::board_face::BoardFace;
use super::coefficients::Coefficients;
use super::decay_texture::{DecayTexture, Inside};
use super::growth::wrap;
use super::pith::{LogPoint, Trunk};
use crate::noise::{Noise, smoothstep};

/// Cell of the front's noise across the fibre [mm].
const CELL_MM: f32 = 12.0;
/// The noise stays within this many root mean squares: three octaves of uniform lattice values reach 3.9 [1].
const NOISE_LIMIT: f32 = 4.0;
/// Absorption in the rim over that of clear wood [1].
const RIM_FACTOR: f32 = 1.5;

/// Length of a pocket over its width [1], and the spread of the logarithm of its length [1].
const POCKET_LENGTHS: f32 = 5.0;
const POCKET_LOG_SD: f64 = 0.35;
/// Wander of a pocket's front over its half width, root mean square, at most [1].
const POCKET_WANDER: f32 = 0.3;
/// Share of the severity that incipient decay reaches at the front [1].
const INCIPIENT: f32 = 0.2;

/// Isotropic scattering stays above this where severity goes beyond the class table [mm^-1].
pub const LEAST_SIGMA_I: f32 = 0.01;
/// Effective indices lie between those of air and of the cell wall [1].
const INDICES: [f32; 2] = KERNEL_INDICES;

/// Decay of a board.
#[derive(Debug, Clone)]
pub(super) struct Decay {
    /// Middle of the board along the laser line [mm].
    middle: f32,
    /// Half the board's width [mm].
    half_width: f32,
    /// -1 or 1: the edge that it came from.
    side: f32,
    /// Decay at the edge; none where the edge is sound.
    edge: Option<EdgeRot>,
    /// Mean distance of the front from the pith [mm], and its instance.
    heart: Option<(f32, u16)>,
    pockets: Vec<RotPocket>,
    /// Severity behind the front, 0 to 1 [1].
    severity: f32,
    /// Half width of the front [mm].
    half_transition: f32,
    /// Root mean square of the front's wandering [mm].
    wander: f32,
    /// Width of the rim before the front, and of incipient decay [mm].
    rim: f32,
    incipient: f32,
    /// Instance of all incipient decay; 0 for none.
    incipient_id: u16,
    noise: Noise,
    /// One over the cell of the noise across the fibre [mm^-1].
    across: f32,
    /// One over the cell of the noise along the fibre [mm^-1].
    along: f32,
    texture: DecayTexture,
    /// The class table's medium.
    rot: Coefficients,
}

/// Decay that came in from an edge: half an ellipse, or a strip where it has no length.
#[derive(Debug, Clone, Copy)]
struct EdgeRot {
    /// How far it reaches in [mm].
    reach: f32,
    /// Place along the log of its middle, and half its length [mm].
    along: Option<[f32; 2]>,
    id: u16,
}

/// A spindle of decay.
#[derive(Debug, Clone, Copy)]
struct RotPocket {
    /// Distance from the pith, azimuth [rad] and place along the log of its middle [mm].
    r: f32,
    azimuth: f32,
    along: f32,
    /// Half its width and half its length [mm].
    half: [f32; 2],
    id: u16,
}

/// Decay at a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Decayed {
    /// How much of the front has passed, 0 to 1 [1].
    pub passed: f32,
    /// How much of incipient decay is here, 0 to 1 [1].
    incipient: f32,
    /// What it counts as.
    pub class: Class,
    /// Its instance; 0 where it still counts as clear.
    pub id: u16,
    /// Factor on the absorption of clear wood [1].
    rim: f32,
    inside: Inside,
}

impl Decay {
    /// The decay that a recipe asks for, with its instances added to `instances`; none without reach or without
    /// severity.
    pub fn grow(
        stream: Stream,
        wood: &Wood,
        trunk: &Trunk,
        rot: Coefficients,
        instances: &mut Vec<Instance>,
    ) -> Option<Self> {
        let (asked, board, face) = (&wood.rot, &wood.board, BoardFace::of(wood));
        let pockets = asked.pocket_count.round() as u64;
        if asked.severity == 0.0 || (asked.reach_mm == 0.0 && asked.heart_mm == 0.0 && pockets == 0) {
            return None;
        }
        let mut note = |class: Class, x: f64, y: f64, size: f64| {
            let id = instances.len() as u16 + 1;
            instances.push(Instance::new(id, class, [x, y], size, f64::from(asked.severity as f32)));
            id
        };
        let side = if asked.edge < 0.0 { -1.0 } else { 1.0 };
        let middle = board.lead_in_mm + 0.5 * board.length_mm;
        let inwards = 0.5 * (board.width_mm - asked.reach_mm.min(board.width_mm));
        let edge = (asked.reach_mm > 0.0).then(|| {
            let x = board.offset_mm + side * inwards;
            let spot = face.spot([0.5, stream.child("edge").rng().random()]);
            let (y, along) = match asked.edge_length_mm {
                0.0 => (middle, None),
                length => {
                    let place = trunk.place(x as f32, spot.y, face.height);
                    (f64::from(spot.y), Some([place.l, 0.5 * length as f32]))
                }
            };
            EdgeRot { reach: asked.reach_mm as f32, along, id: note(Class::Rot, x, y, f64::NAN) }
        });
        let heart = (asked.heart_mm > 0.0)
            .then(|| (asked.heart_mm as f32, note(Class::Rot, board.offset_mm, middle, 2.0 * asked.heart_mm)));
        let pockets = (0..pockets).map(|index| {
            let mut rng = stream.child("pocket").index(index).rng();
            let spot = face.spot([rng.random(), rng.random()]);
            let length = lognormal(&mut rng, asked.pocket_length_mm, POCKET_LOG_SD);
            let place = trunk.place(spot.x, spot.y, face.height);
            let half = 0.5 * length as f32;
            let id = note(Class::Rot, f64::from(spot.x), f64::from(spot.y), length);
            RotPocket { r: place.r, azimuth: place.phi, along: place.l, half: [half / POCKET_LENGTHS, half], id }
        });
        let pockets = pockets.collect();
        let incipient_id = match asked.incipient_mm > 0.0 {
            true => note(Class::IncipientDecay, board.offset_mm, middle, f64::NAN),
            false => 0,
        };
        Some(Self {
            pockets,
            middle: board.offset_mm as f32,
            half_width: 0.5 * board.width_mm as f32,
            side: side as f32,
            edge,
            heart,
            severity: asked.severity as f32,
            half_transition: 0.5 * asked.transition_mm as f32,
            wander: asked.front_mm as f32,
            rim: asked.rim_mm as f32,
            incipient: asked.incipient_mm as f32,
            incipient_id,
            noise: Noise::new(stream.child("front")),
            across: 1.0 / CELL_MM,
            along: 1.0 / (CELL_MM * asked.elongation as f32),
            texture: DecayTexture::new(stream.child("texture"), asked),
            rot,
        })
    }

    /// Distance to the nearest front, negative behind it, the most that it wanders, root mean square, and its instance
    /// [mm].
    #[inline]
    fn ahead(&self, x: f32, place: &LogPoint) -> (f32, f32, u16) {
        let (mut ahead, mut wander, mut id) = (f32::INFINITY, self.wander, 0);
        if let Some(edge) = self.edge {
            let inwards = self.half_width - self.side * (x - self.middle);
            ahead = match edge.along {
                None => inwards - edge.reach,
                // Distances count as across the board, where they are least.
                Some([middle, half]) => {
                    edge.reach * (libm::hypotf(inwards / edge.reach, (place.l - middle) / half) - 1.0)
                }
            };
            id = edge.id;
        }
        if let Some((radius, own)) = self.heart
            && place.r - radius < ahead
        {
            (ahead, id) = (place.r - radius, own);
        }
        for pocket in &self.pockets {
            let along = (place.l - pocket.along) / pocket.half[1];
            if along.abs() > 2.0 {
                continue;
            }
            let around = place.r * wrap(place.phi - pocket.azimuth);
            let aside = libm::hypotf(around, place.r - pocket.r) / pocket.half[0];
            // Distances count as across the spindle, where they are least.
            let own = pocket.half[0] * (libm::hypotf(aside, along) - 1.0);
            if own < ahead {
                (ahead, wander, id) = (own, self.wander.min(POCKET_WANDER * pocket.half[0]), pocket.id);
            }
        }
        (ahead, wander, id)
    }

    /// Decay at `x` [mm] of the scan frame, with `place` the same point in the log.
    #[inline]
    pub fn at(&self, x: f32, place: &LogPoint) -> Option<Decayed> {
        let (ahead, wander, id) = self.ahead(x, place);
        if ahead > NOISE_LIMIT * wander + self.half_transition + self.rim.max(self.incipient) {
            return None;
        }
        let log = Vec3::new(place.r * place.outward.x, place.l, place.r * place.outward.y);
        let ahead = if ahead < -NOISE_LIMIT * wander - self.half_transition {
            ahead
        } else {
            ahead + wander * self.noise.fractal(log * Vec3::new(self.across, self.along, self.across))
        };
        let passed = 1.0 - smoothstep(-self.half_transition, self.half_transition, ahead);
        let middle = 0.5 * (self.half_transition + self.rim);
        let q = (ahead - middle) / (middle + 1.0e-6);
        let bump = (1.0 - q * q).max(0.0);
        let rim = if self.rim > 0.0 { 1.0 + (RIM_FACTOR - 1.0) * bump * bump } else { 1.0 };
        let incipient = if self.incipient > 0.0 {
            1.0 - smoothstep(0.7 * self.incipient, self.incipient, ahead - self.half_transition)
        } else {
            0.0
        };
        let (class, id) = if passed >= 0.5 {
            (Class::Rot, id)
        } else if incipient >= 0.5 {
            (Class::IncipientDecay, self.incipient_id)
        } else {
            (Class::Clear, 0)
        };
        let inside = self.texture.at(log, passed, self.severity);
        Some(Decayed { passed, incipient, class, id, rim, inside })
    }

    /// How far the face sinks at `x` [mm] of the scan frame, for a loss that is asked at severity 1 [mm].
    pub fn sunk(&self, x: f32, place: &LogPoint, loss: f32) -> f32 {
        self.at(x, place).map_or(0.0, |decayed| loss * self.severity * decayed.passed)
    }

    /// What decay makes of clear wood.
    #[inline]
    pub fn change(&self, clear: Coefficients, decayed: Decayed) -> Coefficients {
        let Inside { severity, absorption } = decayed.inside;
        let v = 2.0 * (severity * decayed.passed).max(self.severity * INCIPIENT * decayed.incipient);
        let mu_a = clear.mu_a * decayed.rim;
        let along = |from: f32, to: f32| from + v * (to - from);
        Coefficients {
            mu_a: mu_a * libm::powf(self.rot.mu_a / mu_a, v) * absorption,
            sigma_i: along(clear.sigma_i, self.rot.sigma_i).max(LEAST_SIGMA_I),
            k: along(clear.k, self.rot.k).max(0.0),
            n_eff: along(clear.n_eff, self.rot.n_eff).clamp(INDICES[0], INDICES[1]),
        }
    }
}
