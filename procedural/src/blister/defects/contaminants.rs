//! Foreign matter in pockets: particles, fibres, powder.
//!
//! Models: a particle is an ellipsoid and a fibre a straight rod, each lying level on the highest of what is below it
//! where film leaves room; one that finds no room is made smaller. Powder is a rough height over the foil, on the asked
//! share of the pocket's floor and never higher than what leaves it room. Sizes: docs/theory/blister.md.
//! Neglected: bent fibres, powder on top of tablets.

use base::{Class, Gloss, Medium};
use glam::{Mat3, Vec2, Vec3};
use rand::RngExt;

use super::{PlannedDefect, graded};
use crate::blister::outline::OutlinePoint;
use crate::blister::solid::{Solid, SolidShape};
use crate::blister::{Blister, Pack, tablet};
use crate::noise::{Noise, smoothstep};

/// Places tried for each size.
const TRIES: usize = 40;
/// Size over the size before, and how often it is made smaller.
const SMALLER: (f32, usize) = (0.8, 10);
/// Distance from anything else [mm].
const APART_MM: f32 = 0.01;
/// How much wider than itself the ground of a particle is probed [1].
const WIDER: f32 = 1.2;
/// Sizes of particles and of fibres at severity 0 and 1 [mm].
const PARTICLE_MM: [f32; 2] = [0.2, 1.5];
const FIBRE_MM: [f32; 2] = [1.0, 10.0];
/// Gloss of dark matter.
const DARK: Gloss = Gloss { share: 0.5, reflectance: 0.04, roughness: [0.5; 2], matte: 0.0 };
/// Size of powder's heaps, of what they are made of, and of its grains [mm].
const HEAPS_MM: [f32; 3] = [1.7, 0.6, 0.14];
/// Axis of the lattice of the heaps [1].
const TURN: Vec2 = Vec2::new(0.8, 0.6);

/// Powder on the floor of a pocket.
#[derive(Debug, Clone)]
pub struct Powder {
    heaps: Noise,
    grains: Noise,
    threshold: f32,
    height: f32,
    /// What it is made of.
    pub medium: Medium,
    /// Class and instance of its pixels.
    pub label: (Class, u16),
}

impl Powder {
    /// The planned powder of a tablet's medium on the floor of a pocket of `pack`.
    fn new(pack: &Pack, planned: &PlannedDefect, medium: Medium) -> Self {
        let stream = planned.stream;
        let heaps = Noise::new(stream.child("heaps"));
        let (outline, middle) = (pack.web.formed.outline, pack.web.cells[planned.cell].middle);
        let (axis, half) = (pack.web.formed.axis, outline.half());
        let mut values = Vec::new();
        for i in 0..40 * 40 {
            let share = Vec2::new((i % 40) as f32 + 0.5, (i / 40) as f32 + 0.5) / 20.0 - 1.0;
            let own = share * half;
            if matches!(outline.place(own, 0.0), OutlinePoint::Roof(..)) {
                values.push(self::heaps(heaps, middle + own.x * axis + own.y * axis.perp()));
            }
        }
        values.sort_by(f32::total_cmp);
        let share = graded(planned.severity, 0.05, 0.6);
        let rank = ((1.0 - share) * values.len() as f32) as usize;
        let gloss = Gloss { share: 0.5 * medium.gloss.share, roughness: [0.6; 2], ..medium.gloss };
        Self {
            heaps,
            grains: Noise::new(stream.child("grains")),
            threshold: values.get(rank).copied().unwrap_or(0.0),
            height: graded(planned.severity, 0.05, 0.5),
            // Loose powder scatters less than compressed, and has no coat.
            medium: Medium { sigma_i: 0.6 * medium.sigma_i, coat: 1.0, gloss, ..medium },
            label: (planned.kind.class, pack.next_id()),
        }
    }

    /// Height over the foil where nothing is in its way [mm].
    pub fn height(&self, p: Vec2) -> f32 {
        let heap = smoothstep(0.0, 0.5, heaps(self.heaps, p) - self.threshold);
        if heap == 0.0 {
            return 0.0;
        }
        self.height * heap * (0.75 + 0.14 * self.grains.plane(p / HEAPS_MM[2]).0)
    }
}

/// A rough field of unit size: two lattices turned against each other [1].
fn heaps(noise: Noise, p: Vec2) -> f32 {
    let turned = Vec2::new(TURN.dot(p), TURN.perp_dot(p));
    0.8 * noise.plane(turned / HEAPS_MM[0]).0 + 0.6 * noise.plane(TURN.rotate(turned) / HEAPS_MM[1] + 17.0).0
}

/// Something small and level.
struct ContaminantPiece {
    /// How far it reaches to its sides, and its height [mm].
    half: Vec2,
    height: f32,
    /// What it is the image of, and how that is scaled.
    shape: SolidShape,
    scale: Vec3,
    medium: Medium,
}

/// Lays a piece somewhere in a pocket; its middle on the conveyor, and its direction.
fn lie(pack: &Pack, planned: &PlannedDefect, piece: &ContaminantPiece, round: usize) -> Option<(Vec3, Vec2)> {
    let mut rng = planned.stream.child("place").index(round as u64).rng();
    let half = pack.web.formed.outline.half();
    for _ in 0..TRIES {
        let (a, b, turn) = (rng.random::<f32>(), rng.random::<f32>(), rng.random::<f32>());
        let own = half * Vec2::new(2.0 * a - 1.0, 2.0 * b - 1.0);
        let axis = pack.web.formed.axis;
        let middle = pack.lay.conveyor(pack.web.cells[planned.cell].middle + own.x * axis + own.y * axis.perp());
        let (sine, cosine) = libm::sincosf(std::f32::consts::TAU * turn);
        let way = Vec2::new(cosine, sine);
        if let Some(rest) = rest(pack, planned.cell, piece, middle, way) {
            return Some((middle.extend(rest + 0.5 * piece.height), way));
        }
    }
    None
}

/// Level on which a piece comes to rest; `None` where film leaves no room for it [mm].
fn rest(pack: &Pack, cell: usize, piece: &ContaminantPiece, middle: Vec2, way: Vec2) -> Option<f32> {
    let reach = piece.half * WIDER + APART_MM;
    let counts = reach.map(|r| (r / 0.06).clamp(2.0, 96.0));
    let (mut floor, mut ceiling) = (f32::NEG_INFINITY, f32::INFINITY);
    for i in 0..=counts.x as usize {
        for j in 0..=counts.y as usize {
            let share = Vec2::new(i as f32, j as f32) / counts.map(|c| (c as usize) as f32) * 2.0 - 1.0;
            let d = share * reach;
            let at = middle + d.x * way + d.y * way.perp();
            let spot = pack.spot(at.x, at.y).filter(|spot| spot.cell == Some(cell) && spot.leaf.inset > 0.0)?;
            let top = pack.highest(Some(cell), at.x, at.y).map(|(_, top)| top);
            floor = floor.max(top.unwrap_or_else(|| pack.ground(&spot).0.z));
            ceiling = ceiling.min(pack.ceiling(&spot));
        }
    }
    let floor = floor + 2.0 * APART_MM;
    (floor + piece.height + APART_MM <= ceiling).then_some(floor)
}

/// Powder on the floor.
pub fn powder(pack: &mut Pack, blister: &Blister, planned: &PlannedDefect) {
    let powder = Powder::new(pack, planned, tablet::medium(&blister.tablet));
    let (middle, size) = (pack.web.cells[planned.cell].middle, 2.0 * pack.web.formed.outline.half().x);
    pack.enter_in(planned, middle, size, planned.severity);
    pack.powders[planned.cell] = Some(powder);
}

/// A foreign particle.
pub fn particle(pack: &mut Pack, _: &Blister, planned: &PlannedDefect) {
    strew(pack, planned, PARTICLE_MM, |size, [slim, kind]| {
        let half = 0.5 * size * Vec2::new(1.0, graded(slim, 0.6, 1.0));
        let height = size * graded(slim, 0.35, 0.7);
        let metal = Gloss { share: 1.0, reflectance: 0.6, roughness: [0.3; 2], matte: 0.0 };
        let is_metal = kind < 0.3;
        ContaminantPiece {
            half,
            height,
            shape: SolidShape { segment: 0.0, radius: 1.0, band: 0.0, cap: Some([1.0, 0.0]) },
            scale: half.extend(0.5 * height),
            medium: if is_metal { Medium::opaque(metal) } else { Medium::isotropic(20.0, 10.0, 1.5, DARK) },
        }
    });
}

/// A foreign fibre.
pub fn fibre(pack: &mut Pack, _: &Blister, planned: &PlannedDefect) {
    strew(pack, planned, FIBRE_MM, |size, [slim, kind]| {
        let height = graded(slim, 0.02, 0.1);
        let (half, radius) = (Vec2::new(0.5 * size, 0.5 * height), 0.5 * height);
        ContaminantPiece {
            half,
            height,
            shape: SolidShape { segment: half.x - radius, radius, band: 0.0, cap: Some([radius, 0.0]) },
            scale: Vec3::ONE,
            medium: Medium::isotropic(graded(kind, 0.5, 8.0), 20.0, 1.5, DARK),
        }
    });
}

/// Lays a piece as `make` makes it of a size and two drawn shares, smaller where it has no room; `sizes` are those of
/// severity 0 and 1 [mm].
fn strew(pack: &mut Pack, planned: &PlannedDefect, sizes: [f32; 2], make: impl Fn(f32, [f32; 2]) -> ContaminantPiece) {
    let mut rng = planned.stream.child("piece").rng();
    let drawn = [rng.random::<f32>(), rng.random::<f32>()];
    let mut size = graded(planned.severity, sizes[0], sizes[1]);
    for round in 0..=SMALLER.1 {
        let piece = make(size, drawn);
        if let Some((middle, way)) = lie(pack, planned, &piece, round) {
            let linear = Mat3::from_cols(way.extend(0.0), way.perp().extend(0.0), Vec3::Z);
            let linear = linear * Mat3::from_diagonal(piece.scale);
            let (class, instance) = (planned.kind.class, pack.next_id());
            let solid = Solid::new(piece.shape, Vec::new(), linear, middle, piece.medium, class, instance);
            let at = 0.5 * (solid.bounds[0] + solid.bounds[1]);
            let severity = ((size - sizes[0]) / (sizes[1] - sizes[0])).clamp(0.0, 1.0);
            pack.enter_in(planned, pack.lay.card(at.x, at.y), size, severity);
            return pack.add(planned.cell, solid);
        }
        size *= SMALLER.0;
    }
}
