//! What a solid piece is made of: one medium throughout, given by numbers.
//!
//! The default is blasted metal: it throws 40 % of the light back evenly, has a few facets that shine, and lets nothing
//! in that would come back. Machining marks are a roughness that is less along them than across.

use base::{Gloss, Medium, Need::Amount, TANGLED, parameters};
use glam::Vec3;

parameters! {
    /// What the piece is made of, alike all through.
    material: Material {
        /// Absorption.
        mu_a_per_mm: 0.0001, 1000.0, 1000.0, "metal: nothing comes back from below", fixed;
        /// Isotropic reduced scattering.
        sigma_i_per_mm: 0.01, 200.0, 1.0, "free", fixed;
        /// Reduced cylinder scattering for light across the fibre; 0 for matter without fibres.
        k_per_mm: 0.0, 200.0, 0.0, "free", fixed;
        /// Effective refractive index of the matter below the surface.
        n_eff: 1.0, 2.0, 1.5, "free", fixed;
        /// Angle of the fibres on the level against the scan, positive towards +x, as the piece lies.
        fibre_azimuth_deg: -90.0, 90.0, 0.0, "free", fixed, needs [Amount("material.k_per_mm")];
        /// Angle by which the fibres dive below the level, as the piece lies.
        fibre_dive_deg: 0.0, 90.0, 0.0, "free", fixed, needs [Amount("material.k_per_mm")];
        /// Standard deviation of single fibres' tilt in each of two directions.
        fibre_dispersion_deg: 3.0, 14.0, 5.0, "as clear wood", fixed, needs [Amount("material.k_per_mm")], of [TANGLED];
        /// Share of the surface that reflects like facets.
        gloss: 0.0, 1.0, 0.1, "[M]", log_uniform(0.05, 0.2);
        /// Reflectance of a facet at normal incidence.
        reflectance: 0.0, 1.0, 0.9, "aluminium; spread [M]", uniform(0.85, 0.93);
        /// Roughness (alpha of GGX) along the laser line; machining marks are smoother along than across.
        roughness_x: 0.05, 1.0, 0.25, "[M]", uniform(0.15, 0.35);
        /// Roughness (alpha of GGX) along the scan.
        roughness_y: 0.05, 1.0, 0.35, "[M]", uniform(0.25, 0.45);
        /// Light that the surface throws back evenly, before any enters.
        matte: 0.0, 1.0, 0.4, "[M] blasted metal", uniform(0.3, 0.5);
    }
}

impl Material {
    /// As light meets it.
    pub fn medium(&self) -> Medium {
        let (azimuth, dive) = (self.fibre_azimuth_deg.to_radians(), self.fibre_dive_deg.to_radians());
        let level = libm::cos(dive);
        let fibre = [libm::sin(azimuth) * level, libm::cos(azimuth) * level, -libm::sin(dive)];
        Medium {
            mu_a: self.mu_a_per_mm as f32,
            sigma_i: self.sigma_i_per_mm as f32,
            k: self.k_per_mm as f32,
            n_eff: self.n_eff as f32,
            fibre: Vec3::from(fibre.map(|part| part as f32)),
            dispersion_deg: self.fibre_dispersion_deg as f32,
            gloss: Gloss {
                share: self.gloss as f32,
                reflectance: self.reflectance as f32,
                roughness: [self.roughness_x as f32, self.roughness_y as f32],
                matte: self.matte as f32,
            },
            coat: 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each number is a part of the medium, and the fibre is a unit vector of the stated angles.
    #[test]
    fn every_number_has_an_effect() {
        let default = Material::from_values(&mut |p| p.default).medium();
        for parameter in Material::PARAMETERS {
            let other = if parameter.default == parameter.max { parameter.min } else { parameter.max };
            let changed = Material::from_values(&mut |p| if p == parameter { other } else { p.default });
            assert_ne!(changed.medium(), default, "{}", parameter.name);
        }
        let mut material = Material::from_values(&mut |p| p.default);
        (material.fibre_azimuth_deg, material.fibre_dive_deg) = (30.0, 40.0);
        let fibre = material.medium().fibre;
        assert!((fibre.length() - 1.0).abs() < 1e-6 && fibre.z < 0.0);
        assert!((fibre.x / fibre.y - 30f32.to_radians().tan()).abs() < 1e-6);
        assert!((-fibre.z - 40f32.to_radians().sin()).abs() < 1e-6);
    }
}
