//! Zones of the stem: heartwood, compression wood, blue stain and the pith's own tissue.
//!
//! Models: heartwood reaches to the last ring that lies within a radius which wanders slowly about and along the log;
//! the border therefore follows a ring and steps over to the next one here and there, and it lies the same in earlywood
//! and latewood. Compression wood is a crescent about the pith, developed like a raised cosine over its angle, and
//! within its rings from one distance of the pith to another. Blue stain fills wedges about planes through the pith
//! whose sides are frayed by streaks along the rays; it stays in the sapwood and out of knots. The pith is a cylinder
//! about the pith line. Each changes the coefficients of the wood that is there (`WoodKinds`), so rings and streaks
//! show through. Sources: anatomy of conifers in docs/theory/wood.md; sizes are engineering estimates. Limits: one
//! crescent; heartwood without a transition zone; stain without the hyphae's own spots; no juvenile core.

use base::{Class, Instance, Stream, lognormal};
use glam::Vec3;
use rand::RngExt;

use super::Wood;
use super::board_face::BoardFace;
use super::growth::wrap;
use super::pith::{LogPoint, Trunk};
use super::rings::Rings;
use crate::noise::{Noise, smoothstep};

/// Wander of the heartwood's radius over the radius, root mean square [1].
const BORDER_WANDER: f32 = 0.05;
/// Lattice steps of that wander over a radian [1], and its cell along the log [mm].
const BORDER_CELLS: [f32; 2] = [1.5, 250.0];
/// Width over which heartwood begins [mm].
const BORDER_MM: f32 = 0.3;
/// Width over which compression wood begins and ends, outwards [mm].
const CRESCENT_EDGE_MM: f32 = 1.5;
/// Wander of the crescent's middle along the log, root mean square [rad], and its cell [mm].
const CRESCENT_WANDER: [f32; 2] = [0.1, 120.0];
/// Spread of the logarithms of a wedge's angle and length [1].
const WEDGE_LOG_SD: f64 = 0.35;
/// How far rays fray a wedge's sides, over half its angle [1].
const FRAY: f32 = 0.45;
/// Cells of the fraying outwards and along the log [mm], and its lattice steps over half the wedge's angle [1].
const FRAY_CELLS: [f32; 3] = [40.0, 14.0, 3.0];
/// Share of half a wedge's angle over which the stain fades [1].
const WEDGE_EDGE: f32 = 0.35;
/// Unevenness of the stain inside a wedge, root mean square [1].
const STAIN_CLOUDS: f32 = 0.18;
/// Developed or stained by half, wood has the label [1].
const LABELLED: f32 = 0.5;

/// How far a place belongs to each zone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ZoneShares {
    /// Heartwood, 0 to 1 [1].
    pub heartwood: f32,
    /// Compression wood, 0 to 1 [1].
    pub compression: f32,
    /// Blue stain, 0 to 1 [1].
    pub stain: f32,
    /// Tissue of the pith, 0 to 1 [1].
    pub pith: f32,
    /// What the place counts as, and its instance.
    pub class: Class,
    /// Number of the instance; 0 for none.
    pub instance: u16,
}

#[derive(Debug, Clone)]
struct Heartwood {
    radius: f32,
    border: Noise,
}

#[derive(Debug, Clone)]
struct Crescent {
    severity: f32,
    /// Rings from, to [mm].
    rings: [f32; 2],
    azimuth: f32,
    half_arc: f32,
    wander: Noise,
    id: u16,
}

#[derive(Debug, Clone, Copy)]
struct Wedge {
    azimuth: f32,
    half_angle: f32,
    along: f32,
    half_length: f32,
    fray: Noise,
    id: u16,
}

/// The zones of a log.
#[derive(Debug, Clone)]
pub(super) struct Zones {
    heartwood: Option<Heartwood>,
    crescent: Option<Crescent>,
    /// Severity of the stain [1].
    stain: f32,
    wedges: Vec<Wedge>,
    clouds: Noise,
    /// Radius of the pith's tissue [mm], and its instance.
    pith: (f32, u16),
}

impl Zones {
    /// The zones that the numbers ask for; their instances are added to `instances`.
    pub fn grow(stream: Stream, wood: &Wood, trunk: &Trunk, instances: &mut Vec<Instance>) -> Self {
        let face = BoardFace::of(wood);
        let middle = trunk.place(face.middle.x, face.middle.y, face.height);
        let heartwood = (wood.log.heartwood_mm > 0.0)
            .then(|| Heartwood { radius: wood.log.heartwood_mm as f32, border: Noise::new(stream.child("heartwood")) });
        let mut note = |class, x: f64, y: f64, size: f64, severity: f64| {
            let id = instances.len() as u16 + 1;
            instances.push(Instance::new(id, class, [x, y], size, severity));
            id
        };
        let at = [f64::from(face.middle.x), f64::from(face.middle.y)];
        let asked = &wood.compression;
        let crescent = (asked.severity > 0.0).then(|| {
            let ring = f64::from(trunk.layer(&middle)) + asked.offset_mm;
            Crescent {
                severity: asked.severity as f32,
                rings: [-0.5, 0.5].map(|side| (ring + side * asked.width_mm) as f32),
                azimuth: asked.azimuth_deg.to_radians() as f32,
                half_arc: (0.5 * asked.arc_deg.to_radians()) as f32,
                wander: Noise::new(stream.child("crescent")),
                id: note(Class::CompressionWood, at[0], at[1], asked.width_mm, asked.severity),
            }
        });
        let asked = &wood.stain;
        let count = if asked.severity > 0.0 { asked.wedge_count.round() as u64 } else { 0 };
        let wedges = (0..count).map(|i| {
            let own = stream.child("wedge").index(i);
            let mut rng = own.rng();
            let spot = face.spot([rng.random(), rng.random()]);
            let place = trunk.place(spot.x, spot.y, face.height);
            let mut about = |median: f64| lognormal(&mut rng, median, WEDGE_LOG_SD);
            let (angle, length) = (about(asked.wedge_deg), about(asked.length_mm));
            Wedge {
                azimuth: place.phi,
                half_angle: (0.5 * angle.to_radians()) as f32,
                along: place.l,
                half_length: (0.5 * length) as f32,
                fray: Noise::new(own.child("fray")),
                id: note(Class::BlueStain, f64::from(spot.x), f64::from(spot.y), length, asked.severity),
            }
        });
        let wedges = wedges.collect();
        let pith = wood.log.pith_mm as f32;
        let pith =
            (pith, if pith > 0.0 { note(Class::Pith, at[0], at[1], 2.0 * f64::from(pith), f64::NAN) } else { 0 });
        let clouds = Noise::new(stream.child("clouds"));
        Self { heartwood, crescent, stain: wood.stain.severity as f32, wedges, clouds, pith }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.heartwood.is_none() && self.crescent.is_none() && self.wedges.is_empty() && self.pith.0 == 0.0
    }

    /// The zones at a place that grew when the trunk had the radius `t` [mm].
    #[inline]
    pub fn at(&self, place: &LogPoint, t: f32, rings: &Rings) -> ZoneShares {
        let heartwood = self.heartwood.as_ref().map_or(0.0, |heartwood| heartwood.share(place, t, rings));
        let mut shares =
            ZoneShares { heartwood, compression: 0.0, stain: 0.0, pith: 0.0, class: Class::Clear, instance: 0 };
        if let Some(crescent) = &self.crescent {
            let share = crescent.share(place, t);
            shares.compression = share * crescent.severity;
            if share >= LABELLED {
                (shares.class, shares.instance) = (Class::CompressionWood, crescent.id);
            }
        }
        let (mut most, mut id) = (0.0, 0);
        for wedge in &self.wedges {
            let share = wedge.share(place);
            if share > most {
                (most, id) = (share, wedge.id);
            }
        }
        most *= 1.0 - heartwood;
        if most > 0.0 {
            let cloud = self
                .clouds
                .space(Vec3::new(place.r * place.outward.x, 0.25 * place.l, place.r * place.outward.y) / 6.0);
            shares.stain = self.stain * (most * (1.0 + STAIN_CLOUDS * cloud)).clamp(0.0, 1.0);
            if most >= LABELLED {
                (shares.class, shares.instance) = (Class::BlueStain, id);
            }
        }
        if place.r < self.pith.0 {
            shares.pith = 1.0 - smoothstep(0.7 * self.pith.0, self.pith.0, place.r);
            (shares.class, shares.instance) = (Class::Pith, self.pith.1);
        }
        shares
    }
}

impl Heartwood {
    #[inline]
    fn share(&self, place: &LogPoint, t: f32, rings: &Rings) -> f32 {
        let at = (BORDER_CELLS[0] * place.outward).extend(place.l / BORDER_CELLS[1]);
        let border = rings.boundary(self.radius * (1.0 + BORDER_WANDER * self.border.space(at)));
        1.0 - smoothstep(border - BORDER_MM, border, t)
    }
}

impl Crescent {
    /// How much of its full development compression wood has here, 0 to 1.
    #[inline]
    fn share(&self, place: &LogPoint, t: f32) -> f32 {
        let [inner, outer] = self.rings;
        if t < inner || t > outer {
            return 0.0;
        }
        let wander = CRESCENT_WANDER[0] * self.wander.line(place.l / CRESCENT_WANDER[1]).0;
        let aside = wrap(place.phi - self.azimuth - wander).abs() / self.half_arc;
        let edge = CRESCENT_EDGE_MM.min(0.5 * (outer - inner));
        (1.0 - smoothstep(0.6, 1.0, aside))
            * smoothstep(inner, inner + edge, t)
            * (1.0 - smoothstep(outer - edge, outer, t))
    }
}

impl Wedge {
    #[inline]
    fn share(&self, place: &LogPoint) -> f32 {
        let along = (place.l - self.along).abs() / self.half_length;
        if along >= 1.0 {
            return 0.0;
        }
        let aside = wrap(place.phi - self.azimuth) / self.half_angle;
        if aside.abs() > 1.0 + 4.0 * FRAY {
            return 0.0;
        }
        let at = Vec3::new(place.r / FRAY_CELLS[0], place.l / FRAY_CELLS[1], aside * FRAY_CELLS[2]);
        // The wedge narrows towards its ends along the grain, as the fungus spreads fastest along it in the middle.
        let half = (1.0 - along * along) * (1.0 + FRAY * self.fray.space(at));
        1.0 - smoothstep(half - WEDGE_EDGE, half + WEDGE_EDGE, aside.abs())
    }
}
