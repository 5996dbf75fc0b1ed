//! Fresnel reflection, internal reflection of diffuse light, and microfacet gloss of a surface.
//!
//! Models: unpolarised Fresnel reflectance of a smooth dielectric; the boundary factor A(n) of diffusion theory
//! (Contini, Martelli, Zaccanti 1997), A = (1 + 3 int mu^2 R) / (1 - 2 int mu R) over cosines from inside;
//! microfacets with the GGX law (Walter et al. 2007), Smith shadowing left out, which at the 25 degrees of a
//! triangulation camera is under 3 %. Neglected: polarisation, absorption in the facet.

use base::Gloss;
use glam::Vec3;

/// Share of light from all sides that enters matter of index 1.5 [1].
pub const ENTERS_FROM_ALL_SIDES: f32 = 0.91;

/// Reflectance of a smooth surface at normal incidence, index `n` against air [1].
pub fn normal_reflectance(n: f32) -> f32 {
    let r = (n - 1.0) / (n + 1.0);
    r * r
}

/// Unpolarised reflectance for light inside a medium of index `n` that meets air under cosine `mu` [1].
pub fn internal_reflectance(n: f64, mu: f64) -> f64 {
    fresnel_dielectric(n, 1.0, mu).0
}

/// Unpolarised reflectance of a plane from index `n` to index `other` under cosine `mu`, and the cosine beyond [1].
#[inline]
pub fn fresnel_dielectric(n: f64, other: f64, mu: f64) -> (f64, f64) {
    let ratio = n / other;
    let sine2 = ratio * ratio * (1.0 - mu * mu);
    if sine2 >= 1.0 {
        return (1.0, 0.0);
    }
    let cosine = (1.0 - sine2).sqrt();
    let s = (n * mu - other * cosine) / (n * mu + other * cosine);
    let p = (other * mu - n * cosine) / (other * mu + n * cosine);
    (0.5 * (s * s + p * p), cosine)
}

/// Boundary factor A(n) of diffusion theory [1].
pub fn boundary_factor(n: f64) -> f64 {
    const QUADRATURE_STEPS: usize = 4000;
    let (mut first, mut second) = (0.0, 0.0);
    for i in 0..QUADRATURE_STEPS {
        let mu = (i as f64 + 0.5) / QUADRATURE_STEPS as f64;
        let r = internal_reflectance(n, mu) / QUADRATURE_STEPS as f64;
        first += mu * r;
        second += mu * mu * r;
    }
    (1.0 + 3.0 * second) / (1.0 - 2.0 * first)
}

/// [`boundary_factor`] from a table, linear between steps of 0.005 in `n` (error under 1e-3 for n in [1, 1.7]).
#[derive(Debug, Clone)]
pub struct BoundaryTable(Vec<f32>);

impl BoundaryTable {
    const STEP: f32 = 0.005;

    /// The table for n in [1, 1.7].
    pub fn new() -> Self {
        Self((0..=141).map(|i| boundary_factor(1.0 + f64::from(i) * f64::from(Self::STEP)) as f32).collect())
    }

    /// A(n), clamped to the table's range.
    #[inline]
    pub fn at(&self, n: f32) -> f32 {
        let place = ((n - 1.0) / Self::STEP).clamp(0.0, 139.999);
        let i = place as usize;
        self.0[i] + (self.0[i + 1] - self.0[i]) * (place - i as f32)
    }
}

impl Default for BoundaryTable {
    fn default() -> Self {
        Self::new()
    }
}

/// Radiance factor of a surface itself, matte and gloss: pi times the reflected radiance over the irradiance [1].
///
/// `normal`, `light` (towards the laser) and `view` (towards the lens) are unit vectors. Roughness along x and along y
/// is that of a level surface; slopes turn it with the surface about the axis across.
#[inline(always)]
pub fn gloss(gloss: &Gloss, normal: Vec3, light: Vec3, view: Vec3) -> f32 {
    if gloss.share == 0.0 {
        return gloss.matte;
    }
    let half = (view + light).normalize();
    // Schlick's fit of Fresnel's law is exact to 1 % at these angles.
    let c = 1.0 - half.dot(view);
    let c2 = c * c;
    let fresnel = gloss.reflectance + (1.0 - gloss.reflectance) * c2 * c2 * c;
    let [ax, ay] = gloss.roughness;
    let up = half.dot(normal);
    // Tangents nearest to x and y; the half vector's parts along them are its slopes times `up`.
    let tx = (Vec3::X - normal * normal.x).normalize();
    let ty = normal.cross(tx);
    let (hx, hy) = (half.dot(tx) / ax, half.dot(ty) / ay);
    let d = hx * hx + hy * hy + up * up;
    // pi D F / (4 mu mu'), pi cancelled against the one in D.
    gloss.matte
        + gloss.share * fresnel / (ax * ay * d * d * 4.0 * normal.dot(light).max(0.05) * normal.dot(view).max(0.05))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference values of A(n) by independent quadrature, docs/theory/physics.md.
    #[test]
    fn boundary_factor_matches_reference() {
        for (n, a) in [(1.0, 1.0), (1.10, 1.3504), (1.18, 1.7080), (1.25, 2.0638), (1.40, 2.9485), (1.55, 3.9944)] {
            assert!((boundary_factor(n) - a).abs() < 2e-3 * a, "A({n}) = {} against {a}", boundary_factor(n));
            let table = f64::from(BoundaryTable::new().at(n as f32));
            assert!((table - boundary_factor(n)).abs() < 1e-3, "table at {n}: {table}");
        }
    }

    /// The hemispherical integral of the lobe is Fresnel's reflectance to 20 %: what a lobe without shadowing keeps.
    #[test]
    fn gloss_conserves_energy() {
        let wood = Gloss::wood(1.0);
        assert!((wood.reflectance - normal_reflectance(1.55)).abs() < 1e-6);
        let steps = 400;
        for gloss_of in [wood, Gloss { roughness: [0.2, 0.4], ..wood }] {
            let mut sum = 0.0;
            for i in 0..steps {
                let mu = (i as f32 + 0.5) / steps as f32;
                for j in 0..steps {
                    let azimuth = (j as f32 + 0.5) / steps as f32 * std::f32::consts::TAU;
                    let flat = (1.0 - mu * mu).sqrt();
                    let view = Vec3::new(flat * azimuth.cos(), flat * azimuth.sin(), mu);
                    sum += 2.0 * gloss(&gloss_of, Vec3::Z, Vec3::Z, view) * mu / (steps * steps) as f32;
                }
            }
            let f0 = wood.reflectance;
            assert!(sum < 1.15 * f0 && sum > 0.8 * f0, "albedo of the lobe {sum}, F0 {f0}");
        }
    }
}
