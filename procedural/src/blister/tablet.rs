//! The form and the medium of a tablet.
//!
//! Models: round and oval biconvex tablets (caps of spheres and of ellipsoids over a straight band), flat ones, caplets
//! (the same over a stadium), and hard capsules (a rod with round ends). A cap of height h over the half width b has
//! the radius R = (h^2 + b^2) / 2h.

use base::{Gloss, Medium};
use glam::{Mat3, Vec3};

use super::outline::Outline;
use super::parameters::Tablet;
use super::solid::SolidShape;

/// Angles at which a tablet's surface is probed.
const ANGLES: usize = 40;
/// Rings of probes on each cap.
const RINGS: usize = 8;
/// Probes along a straight side.
const ALONG: usize = 10;

/// The size and form of a tablet; its long axis is x, its faces lie at +z and -z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TabletForm {
    /// Before scaling.
    pub shape: SolidShape,
    /// From the shape's coordinates to the tablet's, axis by axis [1].
    pub scale: Vec3,
}

impl TabletForm {
    /// The form of these numbers.
    pub fn new(tablet: &Tablet) -> Self {
        let sizes = [0.5 * tablet.length_mm as f32, 0.5 * tablet.width_mm as f32];
        let (long, short) = (sizes[0].max(sizes[1]), sizes[0].min(sizes[1]));
        if tablet.shape >= 1.5 {
            let shape = SolidShape { segment: long - short, radius: short, band: 0.0, cap: Some([short, 0.0]) };
            return Self { shape, scale: Vec3::ONE };
        }
        let thickness = tablet.thickness_mm as f32;
        let height = (0.5 * (thickness - tablet.band_mm as f32)).clamp(0.0, 0.95 * short);
        let flat = height < 0.02;
        let band = if flat { 0.5 * thickness } else { 0.5 * thickness - height };
        let radius = (height * height + short * short) / (2.0 * height);
        let cap = (!flat).then_some([radius, radius - height - band]);
        if tablet.shape >= 0.5 {
            Self { shape: SolidShape { segment: long - short, radius: short, band, cap }, scale: Vec3::ONE }
        } else {
            let shape = SolidShape { segment: 0.0, radius: short, band, cap };
            Self { shape, scale: Vec3::new(long / short, 1.0, 1.0) }
        }
    }

    /// Thickness over all [mm].
    pub fn thickness_mm(&self) -> f32 {
        2.0 * self.shape.top(0.0)
    }

    /// Height of each cap [mm].
    pub fn cap_mm(&self) -> f32 {
        self.shape.top(0.0) - self.shape.band
    }

    /// Whether it is a hard capsule.
    pub fn is_capsule(&self) -> bool {
        self.shape.band == 0.0 && self.shape.cap == Some([self.shape.radius, 0.0])
    }

    /// Its outline seen from above.
    pub fn outline(&self) -> Outline {
        let radius = self.shape.radius;
        if self.scale.x > 1.0 {
            Outline::Ellipse { long: radius * self.scale.x, short: radius }
        } else {
            Outline::Stadium { segment: self.shape.segment, radius }
        }
    }

    /// Height of its upper face over what it lies on, `inset` inwards from the outline across its long axis [mm].
    pub fn top_mm(&self, inset: f32) -> f32 {
        self.shape.top(0.0) + self.shape.top((self.shape.radius - inset).max(0.0))
    }

    /// Reach of the turned tablet in a direction of the card [mm].
    pub fn support(&self, turn: Mat3, way: Vec3) -> f32 {
        self.shape.support(self.scale * (turn.transpose() * way))
    }

    /// Places whose convex hull holds the tablet to a few micrometres, in its own coordinates [mm].
    pub fn probes(&self) -> Vec<Vec3> {
        let SolidShape { segment, radius, band, .. } = self.shape;
        let round = 1.0 / libm::cosf(std::f32::consts::PI / ANGLES as f32);
        let mut probes = Vec::with_capacity(2 * (RINGS + 1) * (ANGLES + 2 * ALONG));
        for ring in 0..=RINGS {
            // Rings of equal steps; the outermost lies on the band's rim.
            let distance = radius * ring as f32 / RINGS as f32;
            let height = if ring == RINGS { band } else { self.shape.top(distance) };
            for side in [-1.0, 1.0] {
                let z = side * height;
                for angle in 0..ANGLES {
                    let (sine, cosine) = libm::sincosf(std::f32::consts::TAU * (angle as f32 + 0.5) / ANGLES as f32);
                    let out = distance * round;
                    let p = Vec3::new(out * cosine + segment * cosine.signum(), out * sine, z);
                    probes.push(p * self.scale);
                }
                if segment > 0.0 {
                    for i in 0..ALONG {
                        let x = segment * ((2 * i + 1) as f32 / ALONG as f32 - 1.0);
                        probes.extend([-1.0, 1.0].map(|s| Vec3::new(x, s * distance, z)));
                    }
                }
            }
        }
        probes
    }
}

/// What a tablet of these numbers is made of.
pub fn medium(tablet: &Tablet) -> Medium {
    let n = tablet.n as f32;
    let gloss = Gloss {
        share: tablet.gloss as f32,
        reflectance: super::fresnel(n),
        roughness: [tablet.roughness as f32; 2],
        matte: 0.0,
    };
    let medium = Medium::isotropic(tablet.mu_a_per_mm as f32, tablet.sigma_per_mm as f32, n, gloss);
    Medium { coat: tablet.coat as f32, ..medium }
}
