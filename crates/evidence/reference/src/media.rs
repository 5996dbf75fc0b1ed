//! Fifteen kinds of wood with their optical coefficients: those of docs/theory/physics.md's table.

use crate::medium::axis;
use base::{Gloss, Medium, WOOD_DISPERSION_DEG};
use transport::stack::{CylinderPhase, Scattering, Stack, WOOD_DISPERSION};

/// A kind of wood under the laser. The end of its fibres towards +y rises.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WoodMedium {
    /// Name in tables.
    pub name: &'static str,
    /// Absorption, background and cylinder scattering [mm^-1], refractive index [1].
    pub coefficients: [f64; 4],
    /// Angle of the fibre with the surface [deg].
    pub dive: f64,
    /// Azimuth of the fibre against the motion [deg].
    pub azimuth: f64,
}

const fn wood(name: &'static str, coefficients: [f64; 4], dive: f64, azimuth: f64) -> WoodMedium {
    WoodMedium { name, coefficients, dive, azimuth }
}

/// Clear wood's coefficients.
const CLEAR: [f64; 4] = [0.08, 2.0, 10.0, 1.18];

/// Clear wood, fibre in the surface.
pub const CLEAR_WOOD: WoodMedium = wood("clear along motion", CLEAR, 0.0, 0.0);
/// A sound knot: its fibres dive steeply.
pub const SOUND_KNOT: WoodMedium = wood("sound knot", [0.22, 3.0, 14.0, 1.22], 80.0, 0.0);

/// All fifteen, in the table's order.
pub const WOODS: [WoodMedium; 15] = [
    CLEAR_WOOD,
    wood("clear across motion", CLEAR, 0.0, 90.0),
    wood("dive 15", CLEAR, 15.0, 0.0),
    wood("dive 30", CLEAR, 30.0, 0.0),
    wood("dive 45", CLEAR, 45.0, 0.0),
    wood("dive 60", CLEAR, 60.0, 0.0),
    wood("dive 90", CLEAR, 90.0, 0.0),
    wood("latewood", [0.2, 2.2, 11.0, 1.18], 0.0, 0.0),
    SOUND_KNOT,
    wood("dead knot", [0.8, 3.0, 14.0, 1.22], 80.0, 0.0),
    wood("rot", [0.5, 4.0, 8.0, 1.15], 0.0, 0.0),
    wood("blue stain", [0.35, 2.0, 10.0, 1.18], 0.0, 0.0),
    wood("compression", [0.20, 4.0, 14.0, 1.25], 0.0, 0.0),
    wood("resin", [0.12, 0.7, 3.0, 1.45], 0.0, 0.0),
    wood("wet", [0.06, 0.8, 4.0, 1.40], 0.0, 0.0),
];

impl WoodMedium {
    /// The same with its fibre at another azimuth [deg].
    pub fn turned(self, azimuth: f64) -> Self {
        Self { azimuth, ..self }
    }

    /// The same as the medium of a body, without gloss.
    pub fn medium(&self) -> Medium {
        let [mu_a, sigma_i, k, n_eff] = self.coefficients.map(|value| value as f32);
        Medium {
            mu_a,
            sigma_i,
            k,
            n_eff,
            fibre: axis(self.azimuth, self.dive).as_vec3(),
            dispersion_deg: WOOD_DISPERSION_DEG,
            gloss: Gloss::NONE,
            coat: 1.0,
        }
    }

    /// A half space of it.
    pub fn stack(&self) -> Stack {
        let [mu_a, sigma_i, sigma_c, n] = self.coefficients;
        let axis = axis(self.azimuth, self.dive);
        let turn = CylinderPhase::Cauchy(0.0);
        Stack::half_space(n, mu_a, Scattering::Fibres { sigma_i, sigma_c, turn, axis, dispersion: WOOD_DISPERSION })
    }
}

#[cfg(test)]
mod tests {
    use procedural::wood::Media;

    use super::*;

    fn of(name: &str) -> [f64; 4] {
        WOODS.iter().find(|wood| wood.name == name).expect(name).coefficients
    }

    /// Guards coefficients that are written twice: those of kinds that recipes have too are what the keys' defaults
    /// give. (Blue stain and compression wood are ratios to the wood they are in, and there is no wet wood among the
    /// keys.)
    #[test]
    fn coefficients_are_the_defaults_of_recipes() {
        let default = |name: &str| {
            let parameter = Media::PARAMETERS.iter().find(|parameter| parameter.name == name);
            parameter.unwrap_or_else(|| panic!("no key {name}")).default
        };
        let early = ["earlywood_mu_a_per_mm", "earlywood_sigma_i_per_mm", "earlywood_k_per_mm"].map(default);
        let over = |ratios: [&str; 3], n: &str| {
            let ratios = ratios.map(default);
            [early[0] * ratios[0], early[1] * ratios[1], early[2] * ratios[2], default(n)]
        };
        let clear = [early[0], early[1], early[2], default("clear_n_eff")];
        let knot = |mu_a: &'static str| over([mu_a, "knot_sigma_i_ratio", "knot_k_ratio"], "knot_n_eff");
        let resin = ["resin_mu_a_per_mm", "resin_sigma_i_per_mm", "resin_k_per_mm", "resin_n_eff"].map(default);
        let late = over(["latewood_mu_a_ratio", "latewood_sigma_i_ratio", "latewood_k_ratio"], "clear_n_eff");
        let rot = over(["rot_mu_a_ratio", "rot_sigma_i_ratio", "rot_k_ratio"], "rot_n_eff");
        for (name, expected) in [
            ("clear along motion", clear),
            ("latewood", late),
            ("sound knot", knot("knot_mu_a_ratio")),
            ("dead knot", knot("dead_knot_mu_a_ratio")),
            ("rot", rot),
            ("resin", resin),
        ] {
            for (written, expected) in of(name).into_iter().zip(expected) {
                assert!((written - expected).abs() < 1e-9, "{name}: {written} where the keys give {expected}");
            }
        }
    }
}
