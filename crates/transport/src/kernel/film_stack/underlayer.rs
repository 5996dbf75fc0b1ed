//! Reflection by what lies below a film: what of the light that arrives it sends out again, and how far from where it
//! arrived.
//!
//! A tablet mirrors Fresnel's share at its surface. The rest enters, and its transform is that of the half space's
//! table: sum of w exp(-q^2 v / 2) over the table's Gaussians with weight w and variance v. A coat takes its share
//! twice. Foil mirrors all that it does not absorb, alike in all directions.
//!
//! Light that enters by Lambert's law is taken to spread as light from straight above does. What goes to the lens of it
//! is as narrow and leaves as far beside the rest as the table says of light that goes there, on average over its
//! paths. Neglected beside that: the fibres of what lies below, roughness of a tablet, that light to the lens is
//! skewed.

use super::super::after_absorption;
use super::super::table::{HalfSpaceTable, PATH_BINS};
use super::super::view::CONE_BINS;
use super::super::view::{View, grazing, view_group};
use super::super::widths::line_mm2;
use super::sealed::lobe;
use super::spectrum::{FREQUENCY_COUNT, Spectrum, frequency};
use crate::fresnel::{fresnel_dielectric, normal_reflectance};
use base::Medium;
use numerics::lanes::exp;

/// Steps of the mean of Fresnel's law over Lambert light.
const FRESNEL_STEPS: usize = 32;

/// What lies below, ready to be asked.
#[derive(Debug, Clone)]
pub(super) struct Underlayer {
    /// Of what.
    pub medium: Medium,
    /// Of light that entered, what leaves again [1].
    pub body: Spectrum,
    /// The same of what goes to a view [1].
    pub seen: Spectrum,
    /// Share that the surface mirrors, of Lambert light and of light from straight above [1].
    pub mirrors: [f32; 2],
    /// How far beside light to all sides the light to a view leaves, over the view's part along the surface [mm].
    pub beside: f32,
    /// Height over which Lambert light spreads along the motion as straight light does that foil mirrors, over that of
    /// the air [1].
    pub lobe: f32,
    /// Coefficients of the radiance factor of what leaves, a mean over its paths.
    leaves: [f32; 4],
}

impl Underlayer {
    pub fn of(medium: &Medium) -> Self {
        if medium.gloss.is_metal() {
            let (none, mirrors) = ([0.0; FREQUENCY_COUNT], [medium.gloss.reflectance; 2]);
            let lobe = lobe(medium.gloss.roughness, 1.0);
            return Self { medium: *medium, body: none, seen: none, mirrors, beside: 0.0, lobe, leaves: [0.0; 4] };
        }
        let node = HalfSpaceTable::get().between(medium.n_eff, 1.0, 0.0, medium.dispersion_deg);
        let free = 1.0 / medium.sigma_i.max(1e-3);
        let waves: Spectrum = std::array::from_fn(|i| frequency(i) as f32);
        let (mut body, mut seen) = ([0.0; FREQUENCY_COUNT], [0.0; FREQUENCY_COUNT]);
        let (mut leaves, mut all) = ([0.0; 4], 0.0);
        let (mut beside, mut height) = (0.0, 0.0);
        for l in 0..PATH_BINS {
            let (left, narrower) = after_absorption(medium.mu_a * free * node.path()[l]);
            let weight = medium.coat * medium.coat * node.weight()[l] * left;
            // Without fibres nothing is on a cone, and no direction differs.
            let group = view_group(false, l.saturating_sub(CONE_BINS));
            let terms = node.views();
            let half = -0.25 * free * free * narrower * (node.variance_along()[l] + node.variance_across()[l]);
            let seen_half = 0.5 * (terms[7][group] + terms[9][group]) * half;
            for i in 0..FREQUENCY_COUNT {
                body[i] += weight * exp((half * waves[i] * waves[i]).max(-80.0));
                seen[i] += weight * exp((seen_half * waves[i] * waves[i]).max(-80.0));
            }
            // A line stands where its highest light does.
            let high = weight / (line_mm2() - 2.0 * half).sqrt();
            beside += high * 0.5 * (terms[5][group] + terms[6][group]) * free;
            height += high;
            for (term, sum) in leaves.iter_mut().enumerate() {
                *sum += weight * node.views()[term][group];
            }
            all += weight;
        }
        leaves.iter_mut().for_each(|sum| *sum /= all.max(f32::MIN_POSITIVE));
        beside /= height.max(f32::MIN_POSITIVE);
        let mirrors = [diffuse_reflectance(medium.n_eff), normal_reflectance(medium.n_eff)];
        Self { medium: *medium, body, seen, mirrors, beside, lobe: 0.0, leaves }
    }

    /// Radiance factor of light that left the body under cosine `up` [1].
    #[inline(always)]
    pub fn towards(&self, up: f32) -> f32 {
        let along = (1.0 - up * up).max(0.0).sqrt();
        grazing(up, self.medium.n_eff) * View::new(along, up, self.medium.n_eff, 0.0).rest(self.leaves)
    }
}

/// Share of Lambert light in air that a surface of index `n` throws back [1].
fn diffuse_reflectance(n: f32) -> f32 {
    // Even in the square of the cosine, as Lambert light is.
    let at = |i: usize| fresnel_dielectric(1.0, n.into(), ((i as f64 + 0.5) / FRESNEL_STEPS as f64).sqrt()).0;
    ((0..FRESNEL_STEPS).map(at).sum::<f64>() / FRESNEL_STEPS as f64) as f32
}
