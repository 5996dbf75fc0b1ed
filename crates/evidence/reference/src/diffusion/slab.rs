//! Plane layers by diffusion.
//!
//! A wave exp(i k . r) in the plane obeys, within a layer, D_zz psi'' = (k . D_e . k + mu_a) psi once the cross terms
//! are sheared away: Phi = exp(-i k . c z) psi with the drift c = (D_xz, D_yz) / D_zz and D_e = D_plane - D_zz c c. So
//! each layer is a piece of transmission line with q = sqrt((k . D_e . k + mu_a) / D_zz), and everything is closed form
//! for any number of layers with any tensors; only the sum over waves (`spread`) is numerical. That is why no grid is
//! used here.
//!
//! - Outer surfaces: extrapolated boundary, Phi = 0 at z_e beyond them, the light that leaves is D_zz Phi' at the
//!   surface (docs/theory/physics.md). One layer gives R = (1 - R_sp) / 2 (e^(-z0 K) + e^(-(z0 + 2 z_e) K)).
//! - Between layers: the flux is the same on both sides; Phi / n^2 jumps by J 6 (int mu^2 R_12 + int mu^2 R_21) /
//!   (n_1^2 (1 - 2 int mu R_12)), which is 0 for equal n (Aronson 1995, in the P1 form of the outer boundary).
//! - DiffuseSource: light runs straight, refracted from layer to layer, and loses its direction in each with the depth
//!   scale of the persistence vector; what ends in a layer is put at its mean place there. What reaches the bottom
//!   leaves as Fresnel's law says; the rest of it turns back into the last layer. The first surface takes its Fresnel
//!   share; partial reflection of straight light between layers is left out.
//! - Angles: P1, L(mu) ~ (1 - R)(2 A + 3 mu_inside), isotropic in form: it knows no cone light of fibres.
//!
//! Light that leaves straight pays absorption on its way; for the rest it begins where light begins to diffuse. Layers
//! without scattering are refused.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::spread::{line_spread, point_spread};
use super::tensor::refracted;
use super::transmission_line::{DiffuseSource, TransmissionLine};
use numerics::quadrature::composite;
use transport::answer::{AngleBin, Answer, Estimate, Question};
use transport::fresnel::{boundary_factor, internal_reflectance};
use transport::stack::{Scattering, Stack};

/// Least depth at which light begins to diffuse, over the length of its persistence vector [1].
const MIN_RELATIVE_DEPTH: f64 = 0.05;
/// Cosines and azimuths that stand for diffuse light.
const DIFFUSE_NODES: [usize; 2] = [6, 8];

/// What diffusion says of `stack`; `error` is 0 everywhere.
///
/// `towards_lens` and `angles` follow the P1 law of the surface, `unscattered` the true extinction.
///
/// # Errors
/// In words with a remedy, where diffusion knows nothing of what is asked; layers count from 0 at the top.
pub fn solve(stack: &Stack, question: &Question) -> Result<Answer, String> {
    let line = TransmissionLine::new(stack)?;
    let mut waves = Vec::new();
    line.wave(DVec2::ZERO, &mut waves);
    let (mut sources, mut absorbed) = (Vec::new(), vec![0.0; stack.layers.len()]);
    let (mut specular, mut straight, mut unscattered) = (0.0, 0.0, 0.0);
    for (share, s) in directions(question)? {
        let entry = enter(stack, &line, s);
        specular += share * entry.specular;
        straight += share * entry.straight;
        absorbed.iter_mut().zip(&entry.paid).for_each(|(sum, paid)| *sum += share * paid);
        unscattered += share * entry.unscattered;
        sources.extend(entry.sources.into_iter().map(|source| DiffuseSource { share: share * source.share, ..source }));
    }
    sources.retain(|source| source.share > 0.0);
    let (mut reflected, mut transmitted) = (0.0, 0.0);
    for source in &sources {
        let (up, down, own) = line.energy(source, &waves);
        reflected += source.share * up;
        transmitted += source.share * down;
        absorbed.iter_mut().zip(own).for_each(|(sum, own)| *sum += source.share * own);
    }
    let (top, bottom) = (stack.layers[0].n / stack.above, stack.layers[line.sections.len() - 1].n / line.below);
    let exact = |values: Vec<f64>| values.into_iter().map(Estimate::exact).collect();
    Ok(Answer {
        model: "diffusion".into(),
        specular,
        reflectance: Estimate::exact(reflected),
        transmittance: Estimate::exact(transmitted + straight),
        unscattered: Estimate::exact(unscattered),
        absorbed: exact(absorbed),
        towards_lens: Some(Estimate::exact(reflected * radiance_factor(top, question.view.z))),
        cone: None,
        angles: angles(question.angles, [top, bottom], [reflected, transmitted]),
        row_mm: question.row_mm,
        line: exact(line_spread(&line, &sources, question)),
        seen: Vec::new(),
        cell_mm: question.cell_mm,
        point: exact(point_spread(&line, &sources, question)),
    })
}

/// Shares and directions of the incident light.
fn directions(question: &Question) -> Result<Vec<(f64, DVec3)>, String> {
    let towards = |cos: f64, azimuth: f64| {
        let (y, x) = libm::sincos(azimuth);
        let sine = (1.0 - cos * cos).max(0.0).sqrt();
        DVec3::new(sine * x, sine * y, -cos)
    };
    let Some(angle) = question.incidence else {
        let [cosines, azimuths] = DIFFUSE_NODES;
        let turn = |j: usize| 2.0 * PI * (j as f64 + 0.5) / azimuths as f64;
        let rule = composite(&[0.0, 1.0], cosines);
        let at =
            |(mu, w): (f64, f64)| (0..azimuths).map(move |j| (2.0 * mu * w / azimuths as f64, towards(mu, turn(j))));
        return Ok(rule.into_iter().flat_map(at).collect());
    };
    if !(0.0..0.5 * PI).contains(&angle) {
        let degrees = angle.to_degrees();
        return Err(format!("light at {degrees} degrees does not meet the surface; ask for less than 90 degrees"));
    }
    Ok(vec![(1.0, towards(libm::cos(angle), question.incidence_azimuth))])
}

/// Radiance times pi over the flux that leaves, at the cosine `mu` outside; `n` is the index inside over that outside
/// [1].
///
/// (1 - R) (2 A + 3 mu_inside) / (4 n^2): its mean over the outer hemisphere, weighted by 2 mu, is 1 by the definition
/// of A.
pub(crate) fn radiance_factor(n: f64, mu: f64) -> f64 {
    let inside = 1.0 - (1.0 - mu * mu) / (n * n);
    if inside <= 0.0 {
        return 0.0;
    }
    let inside = inside.sqrt();
    (1.0 - internal_reflectance(n, inside)) * (2.0 * boundary_factor(n) + 3.0 * inside) / (4.0 * n * n)
}

/// Flux over solid angle in `count` bins even in the angle.
fn angles(count: usize, n: [f64; 2], flux: [f64; 2]) -> Vec<AngleBin> {
    let step = 0.5 * PI / count as f64;
    let mean = |n: f64, from: f64| {
        let (near, far) = (libm::cos(from + step), libm::cos(from));
        let rule = composite(&[near, far], 4);
        let sum: f64 = rule.iter().map(|&(mu, w)| w * mu * radiance_factor(n, mu) / PI).sum();
        sum / (far - near)
    };
    let bin = |i: usize| {
        let from = i as f64 * step;
        AngleBin {
            from_deg: from.to_degrees(),
            to_deg: (from + step).to_degrees(),
            reflected: Estimate::exact(flux[0] * mean(n[0], from)),
            transmitted: Estimate::exact(flux[1] * mean(n[1], from)),
        }
    };
    (0..count).map(bin).collect()
}

/// Light in direction `s` outside: Fresnel share of the first surface, sources, what leaves straight at the bottom, and
/// the part of that which was never scattered.
struct EntryShares {
    specular: f64,
    sources: Vec<DiffuseSource>,
    straight: f64,
    unscattered: f64,
    /// What each layer absorbs of the light that crosses all of them.
    paid: Vec<f64>,
}

fn enter(stack: &Stack, line: &TransmissionLine, s: DVec3) -> EntryShares {
    let first = stack.layers[0].n;
    let specular = internal_reflectance(stack.above / first, -s.z);
    let mut entry = EntryShares {
        specular,
        sources: Vec::new(),
        straight: 0.0,
        unscattered: 0.0,
        paid: vec![0.0; line.sections.len()],
    };
    let (mut left, mut place, mut optical, mut direction, mut n) = (1.0 - specular, DVec2::ZERO, 0.0, s, stack.above);
    let (mut end, mut total, mut absorption) = (None, false, vec![0.0; line.sections.len()]);
    for (i, section) in line.sections.iter().enumerate() {
        let Some(inside) = refracted(direction, DVec3::Z, section.medium.n / n) else {
            // Total reflection between layers: the light stays in the layer above.
            total = true;
            break;
        };
        (direction, n) = (inside, section.medium.n);
        let h = section.medium.persistence(inside);
        // Slanted light on fibres that rise towards it is led upwards, on average; it still begins below the surface.
        let scale = (-h.z).max(MIN_RELATIVE_DEPTH * h.length());
        let keep = if section.thickness.is_infinite() { 0.0 } else { libm::exp(-section.thickness / scale) };
        let depth = if keep > 0.0 { scale - section.thickness * keep / (1.0 - keep) } else { scale };
        entry.sources.push(DiffuseSource {
            share: left * (1.0 - keep),
            layer: i,
            depth,
            exit: place + h.truncate() * (depth / scale),
        });
        if keep > 0.0 {
            place += inside.truncate() / -inside.z * section.thickness;
            let way = section.thickness / -inside.z;
            optical += extinction(stack, i, inside) * way;
            absorption[i] = section.medium.mu_a * way;
        }
        left *= keep;
        end = Some((i, section.thickness - depth, place));
    }
    for (paid, absorption) in entry.paid.iter_mut().zip(&absorption) {
        *paid = left * (1.0 - libm::exp(-absorption));
        left -= *paid;
    }
    if left > 0.0
        && let Some((layer, depth, place)) = end
    {
        // Beyond the critical angle at the bottom this is 1 too.
        let back = if total { 1.0 } else { internal_reflectance(n / line.below, -direction.z) };
        entry.straight = left * (1.0 - back);
        entry.unscattered = ((1.0 - specular) * (1.0 - back) * libm::exp(-optical)).min(entry.straight);
        entry.sources.push(DiffuseSource { share: left * back, layer, depth, exit: place });
    }
    for source in &mut entry.sources {
        source.exit += line.sections[source.layer].medium.drift() * source.depth;
        for above in &line.sections[..source.layer] {
            source.exit += above.medium.drift() * above.thickness;
        }
    }
    entry
}

/// Extinction of layer `i` for light in direction `s` [mm^-1].
fn extinction(stack: &Stack, i: usize, s: DVec3) -> f64 {
    let layer = &stack.layers[i];
    layer.mu_a
        + match layer.scattering {
            Scattering::Isotropic { mu_s, .. } => mu_s,
            Scattering::Fibres { sigma_i, sigma_c, axis, .. } => sigma_i + sigma_c * s.cross(axis).length(),
            Scattering::Tensor { mu_s, .. } => mu_s.dot(s * s),
        }
}

#[cfg(test)]
mod tests;
