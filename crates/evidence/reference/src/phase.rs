//! Phase functions: sampling and density of each law of scattering.
//!
//! - Henyey and Greenstein 1941: p(cos) = (1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^(3/2)), mean cosine g;
//! - a cylinder with axis f keeps the angle between light and f and turns light about f by an angle phi. Wrapped Cauchy
//!   law p2(phi) = (1 - g2^2) / (2 pi (1 + g2^2 - 2 g2 cos phi)), mean cosine g2; mirror p2(phi) = |sin(phi / 2)| / 4,
//!   mean cosine -1/3;
//! - dispersion: a fibre's axis f' is tilted against the mean axis by an angle of Rayleigh's law with parameter s,
//!   evenly about it: on the sphere q(t) = t exp(-t^2 / 2 s^2) / (2 pi s^2 sin t).
//!
//! Uniform directions in the plane come from points in the unit disc, so no sine is asked for.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rand::Rng;
use transport::stack::CylinderPhase;

/// Uniform in (0, 1].
#[inline(always)]
pub fn uniform(rng: &mut impl Rng) -> f64 {
    ((rng.next_u64() >> 11) + 1) as f64 * (1.0 / 9_007_199_254_740_992.0)
}

/// A point in the unit disc, evenly: (x, y, x^2 + y^2).
#[inline(always)]
pub fn disc(rng: &mut impl Rng) -> (f64, f64, f64) {
    loop {
        let bits = rng.next_u64();
        // Two numbers of 32 bits in (-1, 1).
        let half = |bits: u32| (f64::from(bits as i32) + 0.5) * (1.0 / 2_147_483_648.0);
        let (x, y) = (half(bits as u32), half((bits >> 32) as u32));
        let s = x * x + y * y;
        if s < 1.0 {
            return (x, y, s);
        }
    }
}

/// A direction, evenly over the sphere (Marsaglia 1972).
#[inline(always)]
pub fn isotropic(rng: &mut impl Rng) -> DVec3 {
    let (x, y, s) = disc(rng);
    let f = 2.0 * (1.0 - s).sqrt();
    DVec3::new(x * f, y * f, 1.0 - 2.0 * s)
}

/// Two unit vectors that make a right-handed frame with `w` (Duff et al. 2017).
#[inline(always)]
pub fn frame(w: DVec3) -> (DVec3, DVec3) {
    let sign = 1f64.copysign(w.z);
    let a = -1.0 / (sign + w.z);
    let b = w.x * w.y * a;
    (DVec3::new(1.0 + sign * w.x * w.x * a, sign * b, -sign * w.x), DVec3::new(b, sign + w.y * w.y * a, -w.y))
}

/// A direction after scattering of light in direction `w` by Henyey and Greenstein's law.
#[inline(always)]
pub fn henyey_greenstein(w: DVec3, g: f64, rng: &mut impl Rng) -> DVec3 {
    if g == 0.0 {
        return isotropic(rng);
    }
    let f = (1.0 - g * g) / (1.0 - g + 2.0 * g * uniform(rng));
    let cos = ((1.0 + g * g - f * f) / (2.0 * g)).clamp(-1.0, 1.0);
    let sin = (1.0 - cos * cos).sqrt();
    let (x, y, s) = disc(rng);
    let scale = sin / s.sqrt();
    let (u, v) = frame(w);
    w * cos + u * (x * scale) + v * (y * scale)
}

/// Density of Henyey and Greenstein's law at the cosine between both directions [sr^-1].
#[inline]
pub fn henyey_greenstein_density(cos: f64, g: f64) -> f64 {
    let d = 1.0 + g * g - 2.0 * g * cos;
    (1.0 - g * g) / (4.0 * PI * d * d.sqrt())
}

/// Cosine and sine of a turn about a cylinder.
#[inline(always)]
pub fn sample_turn(phase: CylinderPhase, rng: &mut impl Rng) -> (f64, f64) {
    match phase {
        // phi = 2 atan(r tan(angle)) with an angle that is even over a half turn; tan(angle) = y / x.
        CylinderPhase::Cauchy(g2) => {
            let r = (1.0 - g2) / (1.0 + g2);
            let (x, y, _) = disc(rng);
            let y = r * y;
            let norm = 1.0 / (x * x + y * y);
            ((x * x - y * y) * norm, 2.0 * x * y * norm)
        }
        // cos(phi / 2) is even over [-1, 1].
        CylinderPhase::Mirror => {
            let half = 1.0 - 2.0 * uniform(rng);
            (2.0 * half * half - 1.0, 2.0 * half * (1.0 - half * half).max(0.0).sqrt())
        }
    }
}

/// Density at the cosine of a turn [rad^-1].
#[inline]
pub fn turn_density(phase: CylinderPhase, cos: f64) -> f64 {
    match phase {
        CylinderPhase::Cauchy(g2) => (1.0 - g2 * g2) / (TAU * (1.0 + g2 * g2 - 2.0 * g2 * cos)),
        CylinderPhase::Mirror => (0.5 * (1.0 - cos)).max(0.0).sqrt() * 0.25,
    }
}

/// Light in direction `w` after a turn with this cosine and sine about `axis`.
#[inline(always)]
pub fn turned(w: DVec3, axis: DVec3, (cos, sin): (f64, f64)) -> DVec3 {
    let along = w.dot(axis);
    let foot = axis * along;
    foot + (w - foot) * cos + axis.cross(w) * sin
}

/// An axis near `axis`, by the law of dispersion with parameter `s` [rad]; `across` are [`frame`] of `axis`.
#[inline(always)]
pub fn dispersed(axis: DVec3, across: (DVec3, DVec3), s: f64, rng: &mut impl Rng) -> DVec3 {
    if s == 0.0 {
        return axis;
    }
    let (x, y, r2) = disc(rng);
    let (sin, cos) = libm::sincos(s * (-2.0 * libm::log(r2)).sqrt());
    let scale = sin / r2.sqrt();
    axis * cos + across.0 * (x * scale) + across.1 * (y * scale)
}

/// What a collision in a medium of fibres was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FibreCollision {
    /// The isotropic background.
    Background,
    /// A cylinder with this axis.
    Cylinder(DVec3),
    /// Nothing: the cylinder shows light less than its whole width.
    Null,
}

/// Draws what light in direction `w` collides with where the extinction is sigma_i + sigma_c (delta tracking, Woodcock
/// et al. 1965); `fibre` draws a cylinder's axis.
#[inline(always)]
pub fn fibre_collision<R: Rng>(
    w: DVec3,
    sigma_i: f64,
    sigma_c: f64,
    rng: &mut R,
    fibre: impl FnOnce(&mut R) -> DVec3,
) -> FibreCollision {
    let choice = uniform(rng) * (sigma_i + sigma_c);
    if choice < sigma_i {
        return FibreCollision::Background;
    }
    let fibre = fibre(rng);
    let along = w.dot(fibre);
    let hit = (choice - sigma_i) / sigma_c;
    if hit * hit < 1.0 - along * along { FibreCollision::Cylinder(fibre) } else { FibreCollision::Null }
}

/// Density of the law of dispersion at tilt `t` [sr^-1].
#[inline]
fn dispersion_density(t: f64, s: f64) -> f64 {
    let ratio = if t < 1e-6 { 1.0 } else { t / libm::sin(t) };
    ratio * libm::exp(-0.5 * t * t / (s * s)) / (TAU * s * s)
}

/// Density of cylinder scattering times the sine that extinction carries, from direction `w` into `v`, over fibres
/// dispersed about `axis` [sr^-1]; one random sample of an integral, right on average.
///
/// Fibres that can turn w into v lie on the great circle across w - v: their angle with both is the same. With
/// delta(f' . (v - w)) = delta(f' . m) / |v - w| the density is 1 / |v - w| times the integral along that circle of
/// q(f') sin(w, f') p2(turn); the sample is drawn about the circle's point nearest to `axis`.
pub fn cylinder_towards(w: DVec3, v: DVec3, axis: DVec3, turn: CylinderPhase, s: f64, rng: &mut impl Rng) -> f64 {
    let change = v - w;
    let far = change.length();
    if s == 0.0 || far < 1e-9 {
        return 0.0;
    }
    let m = change / far;
    let above = axis.dot(m);
    let nearest = axis - m * above;
    let length = nearest.length();
    // Farther from the circle than six dispersions: nothing comes from there.
    if length < 1e-9 || above.abs() > libm::sin((6.0 * s).min(0.5 * PI)) {
        return 0.0;
    }
    let nearest = nearest / length;
    let (x, y, r2) = disc(rng);
    let _ = y;
    let a = s * x * (-2.0 * libm::log(r2) / r2).sqrt();
    if a.abs() > PI {
        return 0.0;
    }
    let (sin, cos) = libm::sincos(a);
    let fibre = nearest * cos + m.cross(nearest) * sin;
    let tilt = libm::acos(fibre.dot(axis).clamp(-1.0, 1.0));
    let chance = libm::exp(-0.5 * a * a / (s * s)) / (s * TAU.sqrt());
    let along = w.dot(fibre);
    let sin2 = (1.0 - along * along).max(1e-12);
    let cos_turn = ((w.dot(v) - along * along) / sin2).clamp(-1.0, 1.0);
    dispersion_density(tilt, s) / chance * sin2.sqrt() * turn_density(turn, cos_turn) / far
}

#[cfg(test)]
mod tests;
