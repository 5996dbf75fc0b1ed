//! The optical coefficients of the kinds of wood, and what lies between two kinds.
//!
//! Models: the kinds of wood as points in the space of coefficients, joined by straight lines.
//! Source: the class table of docs/theory/wood.md. Limits: one wavelength; the same gloss everywhere.

use super::parameters::Media;
use super::zones::ZoneShares;

/// Coefficients without a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Coefficients {
    /// Absorption [mm^-1].
    pub mu_a: f32,
    /// Isotropic reduced scattering [mm^-1].
    pub sigma_i: f32,
    /// Cylinder scattering [mm^-1].
    pub k: f32,
    /// Effective refractive index [1].
    pub n_eff: f32,
}

impl Coefficients {
    fn new(mu_a: f64, sigma_i: f64, k: f64, n_eff: f64) -> Self {
        Self { mu_a: mu_a as f32, sigma_i: sigma_i as f32, k: k as f32, n_eff: n_eff as f32 }
    }

    /// The point a share of the way to another kind.
    #[inline]
    pub fn mix(self, to: Self, share: f32) -> Self {
        let along = |a: f32, b: f32| a + share * (b - a);
        Self {
            // Beside absorption that is 10^7 times as large, rounding would leave none.
            mu_a: along(self.mu_a, to.mu_a).max(0.5 * self.mu_a.min(to.mu_a)),
            sigma_i: along(self.sigma_i, to.sigma_i),
            k: along(self.k, to.k),
            n_eff: along(self.n_eff, to.n_eff),
        }
    }

    /// With absorption and scattering multiplied [1].
    #[inline]
    pub fn scaled(self, absorption: f32, scattering: f32) -> Self {
        Self {
            mu_a: self.mu_a * absorption,
            sigma_i: self.sigma_i * scattering,
            k: self.k * scattering,
            n_eff: self.n_eff,
        }
    }
}

/// The kinds of wood in a board.
#[derive(Debug, Clone, Copy)]
pub(super) struct WoodKinds {
    /// Earlywood.
    pub earlywood: Coefficients,
    /// Latewood.
    pub latewood: Coefficients,
    /// Knot wood that lived.
    pub sound_knot: Coefficients,
    /// Knot wood that had died.
    pub dead_knot: Coefficients,
    /// Bark around a dead knot.
    pub bark: Coefficients,
    /// Decayed wood at severity 1/2.
    pub rot: Coefficients,
    /// Wood full of resin.
    pub resin: Coefficients,
    /// Frass: chewed earlywood, cut so short that no cylinder guides light.
    pub frass: Coefficients,
    /// What zones of the stem make of wood.
    zones: ZoneFactors,
}

/// Factors on the coefficients of wood in fully developed zones of the stem [1].
#[derive(Debug, Clone, Copy)]
struct ZoneFactors {
    /// Absorption of heartwood, of the pith, of stained wood, of compression wood.
    heartwood: f32,
    pith: f32,
    stain: f32,
    compression: f32,
    /// Isotropic and cylinder scattering of compression wood, and its effective index.
    compression_sigma_i: f32,
    compression_k: f32,
    compression_n_eff: f32,
}

/// Isotropic scattering of frass over that of earlywood [1], an estimate: all of its scattering without direction.
const FRASS_SIGMA_I: f64 = 4.0;
/// Absorption of frass over that of earlywood [1], an estimate: powder is lighter in bulk and has passed an insect.
const FRASS_MU_A: f64 = 2.0;
/// Effective index of loose powder [1].
const FRASS_N_EFF: f64 = 1.1;

impl WoodKinds {
    /// The kinds of a recipe: earlywood as it is given, everything else but bark's absorption by its ratios to
    /// earlywood.
    pub fn new(m: &Media) -> Self {
        let (mu_a, sigma_i, k) = (m.earlywood_mu_a_per_mm, m.earlywood_sigma_i_per_mm, m.earlywood_k_per_mm);
        let knot = |mu_a| Coefficients::new(mu_a, m.knot_sigma_i_ratio * sigma_i, m.knot_k_ratio * k, m.knot_n_eff);
        Self {
            earlywood: Coefficients::new(mu_a, sigma_i, k, m.clear_n_eff),
            latewood: Coefficients::new(
                m.latewood_mu_a_ratio * mu_a,
                m.latewood_sigma_i_ratio * sigma_i,
                m.latewood_k_ratio * k,
                m.clear_n_eff,
            ),
            sound_knot: knot(m.knot_mu_a_ratio * mu_a),
            dead_knot: knot(m.dead_knot_mu_a_ratio * mu_a),
            bark: knot(m.bark_mu_a_per_mm),
            rot: Coefficients::new(
                m.rot_mu_a_ratio * mu_a,
                m.rot_sigma_i_ratio * sigma_i,
                m.rot_k_ratio * k,
                m.rot_n_eff,
            ),
            resin: Coefficients::new(m.resin_mu_a_per_mm, m.resin_sigma_i_per_mm, m.resin_k_per_mm, m.resin_n_eff),
            frass: Coefficients::new(FRASS_MU_A * mu_a, FRASS_SIGMA_I * sigma_i, 0.0, FRASS_N_EFF),
            zones: ZoneFactors {
                heartwood: m.heartwood_mu_a_ratio as f32,
                pith: m.pith_mu_a_ratio as f32,
                stain: m.stain_mu_a_ratio as f32,
                compression: m.compression_mu_a_ratio as f32,
                compression_sigma_i: m.compression_sigma_i_ratio as f32,
                compression_k: m.compression_k_ratio as f32,
                compression_n_eff: m.compression_n_eff as f32,
            },
        }
    }

    /// What zones of the stem make of wood: factors are joined by straight lines from 1.
    #[inline]
    pub fn zoned(&self, wood: Coefficients, shares: &ZoneShares) -> Coefficients {
        let (zones, compression) = (&self.zones, shares.compression);
        let factor = |share: f32, full: f32| 1.0 + share * (full - 1.0);
        Coefficients {
            mu_a: wood.mu_a
                * factor(shares.heartwood, zones.heartwood)
                * factor(shares.stain, zones.stain)
                * factor(shares.pith, zones.pith)
                * factor(compression, zones.compression),
            sigma_i: wood.sigma_i * factor(compression, zones.compression_sigma_i),
            k: wood.k * factor(compression, zones.compression_k),
            n_eff: wood.n_eff + compression * (zones.compression_n_eff - wood.n_eff),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wood::Wood;

    #[test]
    fn the_defaults_are_the_class_table() {
        let kinds = WoodKinds::new(&Wood::from_values(&mut |p| p.default).media);
        // docs/theory/wood.md.
        let table = [
            (kinds.earlywood, 0.08, 2.0, 10.0, 1.18),
            (kinds.latewood, 0.2, 2.2, 11.0, 1.18),
            (kinds.sound_knot, 0.22, 3.0, 14.0, 1.22),
            (kinds.dead_knot, 0.8, 3.0, 14.0, 1.22),
            (kinds.bark, 2.5, 3.0, 14.0, 1.22),
            (kinds.rot, 0.5, 4.0, 8.0, 1.15),
        ];
        for (kind, mu_a, sigma_i, k, n_eff) in table {
            assert_eq!(kind, Coefficients { mu_a, sigma_i, k, n_eff });
        }
    }
}
