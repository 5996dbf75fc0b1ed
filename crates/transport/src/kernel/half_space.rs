//! The table's Gaussians of one medium as they are, without fixed widths: answers for a half space.
//! Films over something are answered by [`super::film_stack`].

use base::{Gloss, KERNEL_INDICES, KERNEL_LEAST_SHARE, Medium};

use super::table::{DISPERSION_DEG, HalfSpaceTable, PATH_BINS};
use super::view::{FIRST_SKEWED, SKEWED_BINS, SkewedBin, group_of};
use super::{SurfacePoint, after_absorption};
use crate::answer::{Answer, Estimate, Question};
use crate::fresnel::fresnel_dielectric;
use crate::stack::{Layer, Scattering, Stack, WOOD_DISPERSION};

/// Light that left after about the same path, or half of it where what the lens sees is skewed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaussian {
    /// Share of the light that arrived [1].
    pub weight: f64,
    /// Path [mm].
    pub path: f64,
    /// Displacement towards the diving end of the fibres [mm].
    pub along: f64,
    /// Variance along their track [mm^2].
    pub variance_along: f64,
    /// Variance across it [mm^2].
    pub variance_across: f64,
    /// Radiance factor towards the lens [1].
    pub towards: f64,
    /// How far along the motion the lens sees it beside light to all sides [mm].
    pub seen_shift: f64,
    /// Variance along the motion of what the lens sees [mm^2].
    pub seen_variance: f64,
}

/// Why the kernel has no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum KernelError {
    /// Neither a half space nor a film over air over one or over foil.
    #[error(
        "the kernel knows half spaces, and one film over air over a half space or foil, or on foil; use `--model path` \
         for other layers and slabs"
    )]
    Layers,
    /// A film that turns light in another way than pigment does.
    #[error("the kernel's films scatter with g = 0.557, as pigment does; use `--model path` for another g")]
    Pigment,
    /// A law that the table was not made for.
    #[error("the kernel's table has no tensor scattering; use `--model path` or `--model diffusion`")]
    Tensor,
    /// Light from elsewhere.
    #[error(
        "the kernel's tables are for light from straight above, and of one layer without end for up to 20 degrees; use \
         `--model path` for other incidence"
    )]
    Incidence,
    /// Fibres that lie straighter or more tangled than the table's.
    #[error("the kernel's table is for fibres dispersed by 3 to 14 degrees; use `--model path` for others")]
    Dispersion,
    /// Matter denser than the table's.
    #[error(
        "the kernel's tables are for indices from 1 to 1.55, of films from 1.4 to 1.65; use `--model path` for others"
    )]
    Index,
    /// Fibres with hardly anything between them.
    #[error(
        "the kernel's table is for fibres with an isotropic part of 3 % or more of the scattering; use `--model path` \
         for less"
    )]
    Share,
    /// Matter without fibres that sends light rather forwards or backwards.
    #[error("the kernel's half spaces scatter evenly (g = 0); use `--model path` for another g")]
    Anisotropy,
    /// Nothing that scatters.
    #[error("the kernel needs matter that scatters; use `--model path` for clear matter")]
    Clear,
    /// A lens below.
    #[error("a half space lets no light out below; put the lens above it")]
    Substrate,
    /// Something else than air.
    #[error("the kernel's table is for air above the surface; use `--model path` for other indices")]
    Above,
}

/// The Gaussians of a surface point.
pub fn gaussians(texel: &SurfacePoint) -> Vec<Gaussian> {
    let scattering = f64::from(texel.sigma_i + texel.k);
    let share = texel.sigma_i / (texel.sigma_i + texel.k);
    let node = HalfSpaceTable::get().between(texel.n, share, texel.sin_dive, texel.dispersion_deg);
    let towards = texel.view.towards(node.views(), texel.n, texel.cos_azimuth, texel.view_motion);
    let c2 = f64::from(texel.cos_azimuth).powi(2);
    let mut all = Vec::with_capacity(PATH_BINS + SKEWED_BINS);
    for l in 0..PATH_BINS {
        let path = f64::from(node.path()[l]) / scattering;
        let (left, narrower) = after_absorption(texel.mu_a * path as f32);
        let area = f64::from(narrower) / (scattering * scattering);
        let variance_along = f64::from(node.variance_along()[l]) * area;
        let variance_across = f64::from(node.variance_across()[l]) * area;
        let group = group_of(l);
        let (seen_along, seen_across) = (f64::from(towards.along[group]), f64::from(towards.across[group]));
        let bin = Gaussian {
            weight: f64::from(texel.enter * node.weight()[l] * left),
            path,
            along: f64::from(node.along()[l]) / scattering,
            variance_along,
            variance_across,
            towards: f64::from(towards.factor[group]),
            seen_shift: f64::from(towards.shift[group]) / scattering,
            seen_variance: c2 * seen_along * variance_along + (1.0 - c2) * seen_across * variance_across,
        };
        match l.checked_sub(FIRST_SKEWED) {
            Some(number) if number < SKEWED_BINS => {
                let halves = SkewedBin::new(number, bin.seen_shift as f32, bin.seen_variance as f32);
                for (side, variance) in [1.0, -1.0].into_iter().zip(halves.variances) {
                    let seen_shift = bin.seen_shift + side * f64::from(halves.nearer);
                    all.push(Gaussian { weight: 0.5 * bin.weight, seen_shift, seen_variance: variance.into(), ..bin });
                }
            }
            _ => all.push(bin),
        }
    }
    all
}

/// Asks about a half space.
///
/// # Errors
/// Whatever its table was not made for.
pub(super) fn solve(stack: &Stack, question: &Question) -> Result<Answer, KernelError> {
    let (texel, track) = texel(stack, question)?;
    let mut all = gaussians(&texel);
    // A coat takes its share on the way in and on the way out.
    let coat = stack.layers[0].coat;
    all.iter_mut().for_each(|gaussian| gaussian.weight *= coat * coat);
    let sum = |pick: &dyn Fn(&Gaussian) -> f64| all.iter().map(pick).sum::<f64>();
    let reflectance = sum(&|g| g.weight);
    let enter = f64::from(texel.enter);
    let variance = |g: &Gaussian| g.variance_along * track.1 * track.1 + g.variance_across * track.0 * track.0;
    let share_of = |g: &Gaussian, row: i64, shift: f64, variance: f64| {
        let (pitch, middle) = (question.row_mm, g.along * track.1 + shift);
        g.weight * share(row as f64 * pitch - middle, pitch, variance + question.line_mm * question.line_mm)
    };
    let line = |row: i64| sum(&|g| share_of(g, row, 0.0, variance(g)));
    let seen = |row: i64| sum(&|g| g.towards * share_of(g, row, g.seen_shift, g.seen_variance));
    let rows = question.rows as i64;
    Ok(Answer {
        model: "kernel".into(),
        specular: 1.0 - enter,
        reflectance: Estimate::exact(reflectance),
        transmittance: Estimate::exact(0.0),
        unscattered: Estimate::exact(0.0),
        absorbed: vec![Estimate::exact(enter - reflectance)],
        towards_lens: Some(Estimate::exact(sum(&|g| g.weight * g.towards))),
        cone: None,
        angles: Vec::new(),
        row_mm: question.row_mm,
        line: (-rows..=rows).map(|row| Estimate::exact(line(row))).collect(),
        seen: (-rows..=rows).map(|row| Estimate::exact(seen(row))).collect(),
        cell_mm: question.cell_mm,
        point: point(&all, track, question),
    })
}

/// Share of a Gaussian of `variance` in a row of `pitch` whose centre is `away` from its own [1].
pub(super) fn share(away: f64, pitch: f64, variance: f64) -> f64 {
    let scale = 1.0 / (2.0 * variance.max(1e-12)).sqrt();
    0.5 * (libm::erf((away + 0.5 * pitch) * scale) - libm::erf((away - 0.5 * pitch) * scale))
}

/// Shares of a beam's energy in cells, `[2 cells + 1, 2 cells + 1]`, rows along y.
pub(super) fn point(all: &[Gaussian], (sin, cos): (f64, f64), question: &Question) -> Vec<Estimate> {
    let cells = question.cells as i64;
    if cells == 0 {
        return Vec::new();
    }
    let cell = question.cell_mm;
    let places = (-cells..=cells).flat_map(|y| (-cells..=cells).map(move |x| (x as f64 * cell, y as f64 * cell)));
    let at = |(x, y): (f64, f64)| {
        let (along, across) = (y * cos + x * sin, x * cos - y * sin);
        let one = |g: &Gaussian| {
            g.weight * share(along - g.along, cell, g.variance_along) * share(across, cell, g.variance_across)
        };
        Estimate::exact(all.iter().map(one).sum())
    };
    places.map(at).collect()
}

/// Steepest light that [`SurfacePoint::facing`] was compared with Monte Carlo for [rad].
const MAX_INCIDENCE: f64 = 20.0 * std::f64::consts::PI / 180.0;

/// Whether light comes down through air, `steepest` from the normal at most, and the lens stands above.
pub(super) fn seen_from_above(stack: &Stack, question: &Question, steepest: f64) -> Result<(), KernelError> {
    if stack.above != 1.0 {
        return Err(KernelError::Above);
    }
    if question.incidence.is_none_or(|angle| angle > steepest + 1e-9) {
        return Err(KernelError::Incidence);
    }
    if question.view.z <= 0.0 {
        return Err(KernelError::Substrate);
    }
    Ok(())
}

/// What is left of a number that was 32 bits wide on its way [1].
const ROUNDING: f64 = 1e-6;

/// Whether a layer's index is one that a table spans.
pub(super) fn index_within(layer: &Layer, [least, most]: [f32; 2]) -> Result<(), KernelError> {
    let spanned = f64::from(least) - ROUNDING..=f64::from(most) + ROUNDING;
    if spanned.contains(&layer.n) { Ok(()) } else { Err(KernelError::Index) }
}

/// Largest mean cosine of what counts as even: it changes the middle row by 4 %, and 0.3 by 20 to 27 % [1].
const MAX_EVEN_COSINE: f64 = 0.05;

/// Whether a layer without fibres scatters as those do that the table was measured on.
pub(super) fn scatters_evenly(layer: &Layer) -> Result<(), KernelError> {
    match layer.scattering {
        Scattering::Isotropic { mu_s, g } if mu_s > 0.0 && g.abs() > MAX_EVEN_COSINE => Err(KernelError::Anisotropy),
        Scattering::Isotropic { .. } | Scattering::Fibres { .. } | Scattering::Tensor { .. } => Ok(()),
    }
}

/// The half space's matter, where the table spans it; its fibres lie along their axis.
pub(super) fn medium(stack: &Stack, question: &Question) -> Result<Medium, KernelError> {
    let [layer] = stack.layers.as_slice() else { return Err(KernelError::Layers) };
    if layer.thickness.is_finite() {
        return Err(KernelError::Layers);
    }
    seen_from_above(stack, question, MAX_INCIDENCE)?;
    let (sigma_i, k, axis, dispersion) = match layer.scattering {
        Scattering::Isotropic { mu_s, g } => (mu_s * (1.0 - g), 0.0, glam::DVec3::Y, WOOD_DISPERSION),
        Scattering::Fibres { sigma_i, sigma_c, turn, axis, dispersion } => {
            (sigma_i, sigma_c * (1.0 - turn.mean_cosine()), axis, dispersion)
        }
        Scattering::Tensor { .. } => return Err(KernelError::Tensor),
    };
    if sigma_i + k <= 0.0 {
        return Err(KernelError::Clear);
    }
    index_within(layer, KERNEL_INDICES)?;
    scatters_evenly(layer)?;
    if sigma_i / (sigma_i + k) < f64::from(KERNEL_LEAST_SHARE) - ROUNDING {
        return Err(KernelError::Share);
    }
    let dispersion_deg = dispersion.to_degrees() as f32;
    let [least, .., most] = DISPERSION_DEG;
    if k > 0.0 && !(least - 1e-4..=most + 1e-4).contains(&dispersion_deg) {
        return Err(KernelError::Dispersion);
    }
    let [mu_a, sigma_i, k, n_eff] = [layer.mu_a, sigma_i, k, layer.n].map(|number| number as f32);
    Ok(Medium { k, fibre: axis.as_vec3(), dispersion_deg, ..Medium::isotropic(mu_a, sigma_i, n_eff, Gloss::NONE) })
}

/// The half space as a surface point, and (sine, cosine) of the fibres' track against the motion.
fn texel(stack: &Stack, question: &Question) -> Result<(SurfacePoint, (f64, f64)), KernelError> {
    let Medium { mu_a, sigma_i, k, n_eff, fibre, dispersion_deg, .. } = medium(stack, question)?;
    let (n, axis) = (stack.layers[0].n, fibre.as_dvec3());
    let (sin, cos) = libm::sincos(question.incidence.unwrap_or_default());
    let (up, along) = libm::sincos(question.incidence_azimuth);
    let light = glam::DVec3::new(sin * along, sin * up, -cos);
    let entering = glam::DVec3::new(light.x, light.y, 0.0) / n;
    let entering = glam::DVec3::new(entering.x, entering.y, -(1.0 - entering.length_squared()).sqrt());
    let matter = SurfacePoint {
        mu_a,
        sigma_i,
        k,
        n: n_eff,
        dispersion_deg,
        enter: 1.0 - fresnel_dielectric(1.0, n, cos).0 as f32,
        ..SurfacePoint::BLACK
    };
    let texel = matter.facing(fibre, glam::Vec3::Z, light.as_vec3(), question.view.as_vec3());
    // The end that goes with the light.
    let axis = if axis.dot(entering) < 0.0 { -axis } else { axis };
    let flat = (axis - entering * axis.dot(entering)).truncate();
    let track = flat.try_normalize().map_or((0.0, 1.0), |track| (track.x, track.y));
    Ok((texel, track))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stack::{CylinderPhase, Foil, PIGMENT_G, Substrate};

    fn refused(stack: &Stack) -> Option<KernelError> {
        crate::kernel::solve(stack, &Question::default()).err()
    }

    /// What the tables do not span is refused and not clamped; what they span to the last is answered.
    #[test]
    fn nothing_is_clamped() {
        let fibres = |n: f64, sigma_i: f64, sigma_c: f64| {
            let wood = Scattering::Fibres {
                sigma_i,
                sigma_c,
                turn: CylinderPhase::Cauchy(0.0),
                axis: glam::DVec3::Y,
                dispersion: WOOD_DISPERSION,
            };
            Stack::half_space(n, 0.1, wood)
        };
        for (n, sigma_i, sigma_c, expected) in [
            (1.2, 2.0, 10.0, None),
            (1.0, 2.0, 10.0, None),
            (1.55, 2.0, 10.0, None),
            (1.551, 2.0, 10.0, Some(KernelError::Index)),
            (1.2, 0.3, 9.7, None),
            (1.2, 0.29, 9.71, Some(KernelError::Share)),
            (1.2, 2.0, 0.0, None),
        ] {
            assert_eq!(refused(&fibres(n, sigma_i, sigma_c)), expected, "n {n}, {sigma_i} and {sigma_c}");
        }
        for (g, expected) in
            [(0.0, None), (0.04, None), (0.06, Some(KernelError::Anisotropy)), (-0.5, Some(KernelError::Anisotropy))]
        {
            let even = Scattering::Isotropic { mu_s: 3.0, g };
            assert_eq!(refused(&Stack::half_space(1.3, 0.1, even)), expected, "g {g}");
        }
        let pigment = |n: f64| Layer::new(0.3, n, 0.02, Scattering::Isotropic { mu_s: 20.0, g: PIGMENT_G });
        let foil = Substrate::Foil(Foil { reflectance: 0.9, roughness: [0.2, 0.2] });
        for (n, expected) in
            [(1.4, None), (1.65, None), (1.39, Some(KernelError::Index)), (1.66, Some(KernelError::Index))]
        {
            let stack = Stack { above: 1.0, layers: vec![pigment(n)], below: foil };
            assert_eq!(refused(&stack), expected, "film of {n}");
        }
    }
}
