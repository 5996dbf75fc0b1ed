//! Answers for whole stacks: film over air over a half space or foil, film sealed to foil.
//!
//! What leaves in each row towards all sides is in `line`; what the lens sees of it in `seen`, where light from below
//! is moved to where it leaves the film. Spreads are those of the fixed widths, as production uses them.

use base::{Film, Gloss, KERNEL_INDICES, Medium};
use glam::Vec3;

use super::super::half_space::{Gaussian, KernelError, index_within, point, scatters_evenly, seen_from_above, share};
use super::super::widths::{BASIS, PACK_SPREAD_MM};
use super::adding::flow;
use super::table::FILM_INDICES;
use super::{FilmStack, FilmStackKernel};
use crate::answer::{Answer, Estimate, Question};
use crate::fresnel::fresnel_dielectric;
use crate::stack::{Layer, PIGMENT_G, Scattering, Stack, Substrate};

/// How far a pigment's mean cosine may be from the table's [1].
const MAX_COSINE_DIFFERENCE: f64 = 0.05;

/// Asks about a film over something.
///
/// # Errors
/// Whatever the tables were not made for.
pub fn solve(stack: &Stack, question: &Question) -> Result<Answer, KernelError> {
    let film_stack = film_stack(stack, question)?;
    let mut kernel = FilmStackKernel::new();
    let spread = kernel.spread(&film_stack);
    let whole = flow(&kernel.tables, &film_stack, 0.0);
    // Light that spreads beyond the fixed frequencies is all there without a gap.
    let gapless = Film { gap_mm: film_stack.film.gap_mm.map(|_| 0.0), ..film_stack.film };
    let total = flow(&kernel.tables, &FilmStack { film: gapless, ..film_stack }, 0.0);
    let fixed = |weights: [f32; BASIS]| -> Vec<Gaussian> {
        let one = |(weight, s): (f32, f32)| Gaussian {
            weight: f64::from(weight),
            path: 0.0,
            along: 0.0,
            variance_along: f64::from(s * s),
            variance_across: f64::from(s * s),
            towards: 1.0,
            seen_shift: 0.0,
            seen_variance: f64::from(s * s),
        };
        weights.into_iter().zip(PACK_SPREAD_MM).map(one).collect()
    };
    let (pitch, laser, rows) = (question.row_mm, question.line_mm * question.line_mm, question.rows as i64);
    let row = |all: &[Gaussian], row: i64, middle: f64| -> f64 {
        all.iter().map(|g| g.weight * share(row as f64 * pitch - middle, pitch, g.variance_along + laser)).sum()
    };
    let leaves = fixed(kernel.back.weights(&whole.all));
    let film = fixed(std::array::from_fn(|j| spread.enter[j] * spread.exit[j]));
    let below = fixed(spread.below.map(|weight| spread.passes * weight));
    let moved = f64::from(film_stack.seen_beside() + spread.below_beside);
    let film_row = |at: i64| -> f64 {
        film.iter().zip(spread.film_beside).map(|(one, beside)| row(std::slice::from_ref(one), at, beside.into())).sum()
    };
    let mirror = |at: i64| {
        let away = at as f64 * pitch - f64::from(film_stack.mirrored_beside());
        f64::from(spread.passes * spread.mirrored) * share(away, pitch, f64::from(spread.mirrored_mm).powi(2) + laser)
    };
    let mut absorbed = vec![0.0; stack.layers.len()];
    absorbed[0] = f64::from(film_stack.enter - total.total - total.sunk);
    *absorbed.last_mut().expect("a stack has a layer") += f64::from(total.sunk);
    Ok(Answer {
        model: "kernel".into(),
        specular: 1.0 - f64::from(film_stack.enter),
        reflectance: Estimate::exact(total.total.into()),
        transmittance: Estimate::exact(0.0),
        unscattered: Estimate::exact(0.0),
        absorbed: absorbed.into_iter().map(Estimate::exact).collect(),
        towards_lens: Some(Estimate::exact(f64::from(
            total.towards[0] + total.passes * (total.below[0] + total.mirrored),
        ))),
        cone: None,
        angles: Vec::new(),
        row_mm: question.row_mm,
        line: (-rows..=rows).map(|at| Estimate::exact(row(&leaves, at, 0.0))).collect(),
        seen: (-rows..=rows).map(|at| Estimate::exact(film_row(at) + row(&below, at, moved) + mirror(at))).collect(),
        cell_mm: question.cell_mm,
        point: point(&leaves, (0.0, 1.0), question),
    })
}

/// The stack as production sees it.
pub fn film_stack(stack: &Stack, question: &Question) -> Result<FilmStack, KernelError> {
    let (top, gap, under) = match (stack.layers.as_slice(), stack.below) {
        ([film], Substrate::Foil(foil)) => (film, None, metal(&foil)),
        ([film, air], Substrate::Foil(foil)) => (film, Some(height(air)?), metal(&foil)),
        ([film, air, body], Substrate::Index(_)) => (film, Some(height(air)?), matter(body)?),
        _ => return Err(KernelError::Layers),
    };
    if !top.thickness.is_finite() || top.coat < 1.0 {
        return Err(KernelError::Layers);
    }
    seen_from_above(stack, question, 0.0)?;
    if let Scattering::Isotropic { mu_s, g } = top.scattering
        && mu_s > 0.0
        && (g - PIGMENT_G).abs() > MAX_COSINE_DIFFERENCE
    {
        return Err(KernelError::Pigment);
    }
    index_within(top, FILM_INDICES)?;
    let medium = isotropic(top)?;
    let thickness_mm = top.thickness as f32;
    let film = Film { thickness_mm, gap_mm: gap, room_mm: [f32::INFINITY; 2], under, under_slope: [0.0; 2] };
    let enter = 1.0 - fresnel_dielectric(1.0, top.n, 1.0).0 as f32;
    let view: Vec3 = question.view.as_vec3();
    Ok(FilmStack { medium, film, enter, view_up: view.z, view, light_up: 1.0, light: Vec3::Z, normal: Vec3::Z })
}

/// Height of a layer of air [mm].
fn height(layer: &Layer) -> Result<f32, KernelError> {
    let clear = matches!(layer.scattering, Scattering::Isotropic { mu_s: 0.0, .. }) && layer.mu_a == 0.0;
    let air = layer.n == 1.0 && layer.coat == 1.0 && layer.thickness.is_finite();
    if clear && air { Ok(layer.thickness as f32) } else { Err(KernelError::Layers) }
}

/// What lies at the bottom: matter without end.
fn matter(layer: &Layer) -> Result<Medium, KernelError> {
    index_within(layer, KERNEL_INDICES)?;
    scatters_evenly(layer)?;
    let medium = isotropic(layer)?;
    if layer.thickness.is_finite() {
        return Err(KernelError::Layers);
    }
    if medium.sigma_i <= 0.0 {
        return Err(KernelError::Clear);
    }
    Ok(Medium { coat: layer.coat as f32, ..medium })
}

fn metal(foil: &crate::stack::Foil) -> Medium {
    let roughness = foil.roughness.map(|alpha| alpha as f32);
    Medium::opaque(Gloss { share: 1.0, reflectance: foil.reflectance as f32, roughness, matte: 0.0 })
}

/// A layer that scatters alike in all directions.
fn isotropic(layer: &Layer) -> Result<Medium, KernelError> {
    let Scattering::Isotropic { mu_s, g } = layer.scattering else { return Err(KernelError::Layers) };
    Ok(Medium::isotropic(layer.mu_a as f32, (mu_s * (1.0 - g)) as f32, layer.n as f32, Gloss::NONE))
}
