//! From the density of wood to its optical coefficients.
//!
//! Law, for each coefficient mu of absorption, background and cylinder scattering, with rho the local density and mu_e,
//! mu_l those of the recipe's earlywood and latewood at the densities rho_e and rho_l:
//!
//!   rho <= rho_e           mu = mu_e rho / rho_e                                        earlywood with air in it
//! rho_e < rho < rho_l    mu = mu_e + (mu_l - mu_e) (rho - rho_e) / (rho_l - rho_e)    earlywood and latewood side by
//! side
//!   rho_l <= rho           mu = mu_l rho / rho_l                                        latewood pressed together
//!
//! It is made of lines, so that where one of them holds the coefficients of mean density are the mean coefficients, and
//! averaging voxels before the law or after it is the same. With the ratio of the class table, 2.5 = 800 / 320,
//! absorption is in proportion to density all over, mu_a = mu_e rho / rho_e.
//!
//! Source: absorption occurs in the cell walls, so it goes with their share of the volume (docs/theory/wood.md, which
//! chose the class table so). Scattering between earlywood and latewood is the class table's too: the number of walls
//! that light meets decides, not density (Sugimoto et al. 2018), 1.1 times as much in latewood. **Guesses**: both lines
//! beyond these two kinds. Limits: 50 to 1500 kg/m3, air and the cell wall without lumina; what lies beyond counts as
//! these ends. The effective index is that of clear wood all over. One wavelength; what is dense without being cell
//! wall (resin, water, metal) counts as wood.

use procedural::wood::Media;

/// Density below which nothing is told apart from air [kg/m^3].
pub(crate) const AIR_KG_PER_M3: f32 = 50.0;
/// Density of the cell wall [kg/m^3].
const WALL_KG_PER_M3: f32 = 1500.0;

/// Densities of the two kinds of wood whose coefficients a recipe gives [kg/m^3].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KindDensities {
    /// Of earlywood.
    pub earlywood: f32,
    /// Of latewood, above that of earlywood.
    pub latewood: f32,
}

/// Absorption, background and cylinder scattering by density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DensityLaw {
    densities: KindDensities,
    /// Of earlywood and of latewood [mm^-1].
    kinds: [[f32; 3]; 2],
}

impl DensityLaw {
    /// Between the kinds of wood of a recipe.
    pub fn new(media: &Media, densities: KindDensities) -> Self {
        let earlywood = [media.earlywood_mu_a_per_mm, media.earlywood_sigma_i_per_mm, media.earlywood_k_per_mm];
        let ratios = [media.latewood_mu_a_ratio, media.latewood_sigma_i_ratio, media.latewood_k_ratio];
        let latewood = [0, 1, 2].map(|i| earlywood[i] * ratios[i]);
        Self { densities, kinds: [earlywood, latewood].map(|kind| kind.map(|mu| mu as f32)) }
    }

    /// Absorption, background and cylinder scattering of wood of a density [kg/m^3] [mm^-1].
    pub fn at(&self, density: f32) -> [f32; 3] {
        let density = density.clamp(AIR_KG_PER_M3, WALL_KG_PER_M3);
        let KindDensities { earlywood, latewood } = self.densities;
        let [early, late] = &self.kinds;
        if density <= earlywood {
            early.map(|mu| mu * density / earlywood)
        } else if density < latewood {
            let share = (density - earlywood) / (latewood - earlywood);
            [0, 1, 2].map(|i| early[i] + share * (late[i] - early[i]))
        } else {
            late.map(|mu| mu * density / latewood)
        }
    }
}
