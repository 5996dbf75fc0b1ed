//! The closed form asked as the other models are: a stack and a question, an answer.
//!
//! Light that no Gaussian returns counts as absorbed, so energy closes by construction. An isotropic medium is one
//! without cylinders whose fibres stand upright: then no light belongs to a cone and the tensor is round. Rows of the
//! line spread are exact integrals of the Gaussians on fixed widths; cells of the point spread are sums of
//! smaller ones that are taken at their middle. Neglected: the fibres' own dispersion (5 degrees are built in), angles of exit.

use super::gaussians::MediaRow;
use super::{BASIS, SPREAD_MM, SpreadRow, line_spread, point_spread};
use crate::transport::answer::{Answer, Estimate, Question};
use crate::transport::fresnel::{boundary_factor, normal_reflectance};
use crate::transport::stack::{Scattering, Stack};

/// What the closed form cannot answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Beyond {
    /// Several layers, or one with a lower side.
    #[error(
        "the kernel knows one medium without end: ask it about one layer of no thickness given, or ask the model path"
    )]
    Layers,
    /// Light that does not come straight down.
    #[error("the kernel knows light straight from above: ask it so, or ask the model path")]
    Incidence,
    /// Scattering that is not one of its two laws.
    #[error("the kernel knows isotropic media and fibres: ask the model path about a tensor")]
    Law,
    /// Absorption above scattering.
    #[error("the kernel needs more scattering (isotropic, reduced) than absorption: ask the model path")]
    Absorption,
}

/// What the closed form says of `stack`.
pub fn solve(stack: &Stack, question: &Question) -> Result<Answer, Beyond> {
    let media = media(stack, question)?;
    let mut spread = SpreadRow::new(1);
    line_spread(&media, 0, 1, &mut spread);
    let weights: [f64; BASIS] = std::array::from_fn(|j| f64::from(spread.enter[j][0]).powi(2));
    let towards: f64 = (0..BASIS).map(|j| f64::from(spread.enter[j][0] * spread.exit[j][0])).sum();
    let reflectance: f64 = weights.iter().sum();
    let specular = 1.0 - f64::from(media.enter[0]);
    let rows = question.rows as i64;
    let row = |k: i64| {
        let at = |edge: f64| edge * question.row_mm - f64::from(spread.shift[0]);
        let (from, to) = (at(k as f64 - 0.5), at(k as f64 + 0.5));
        let shares = weights.iter().zip(SPREAD_MM).map(|(weight, width)| {
            let variance = f64::from(width) * f64::from(width) + question.line_mm * question.line_mm;
            weight * (below(to, variance) - below(from, variance))
        });
        Estimate::exact(shares.sum())
    };
    let point = if question.cells == 0 { Vec::new() } else { point(&media, question) };
    Ok(Answer {
        model: "kernel".into(),
        specular,
        reflectance: Estimate::exact(reflectance),
        transmittance: Estimate::exact(0.0),
        unscattered: Estimate::exact(0.0),
        absorbed: vec![Estimate::exact(1.0 - specular - reflectance)],
        towards_lens: Some(Estimate::exact(towards)),
        cone: None,
        angles: Vec::new(),
        row_mm: question.row_mm,
        line: (-rows..=rows).map(row).collect(),
        cell_mm: question.cell_mm,
        point: point.into_iter().map(Estimate::exact).collect(),
    })
}

/// The point spread of the question's cells, each the sum of an odd number of finer ones on a side.
fn point(media: &MediaRow, question: &Question) -> Vec<f64> {
    /// Cells as fine as this need no finer ones [mm].
    const FINE_MM: f64 = 0.02;
    const MOST: usize = 5;
    let parts = (question.cell_mm / FINE_MM).ceil().clamp(1.0, MOST as f64) as usize / 2 * 2 + 1;
    let parts = parts.min(MOST);
    let (side, cells) = (2 * question.cells + 1, question.cells * parts + parts / 2);
    let fine = point_spread(media, cells, question.cell_mm / parts as f64);
    let mut point = vec![0.0; side * side];
    for (i, light) in fine.into_iter().enumerate() {
        let (row, column) = (i / (side * parts) / parts, i % (side * parts) / parts);
        point[row * side + column] += light;
    }
    point
}

/// Share of a normal law below `place`; a step where it has no width.
fn below(place: f64, variance: f64) -> f64 {
    if variance > 0.0 { 0.5 * libm::erfc(-place / (2.0 * variance).sqrt()) } else { f64::from(u8::from(place > 0.0)) }
}

/// The stack as a row of one medium.
fn media(stack: &Stack, question: &Question) -> Result<MediaRow, Beyond> {
    let [layer] = stack.layers.as_slice() else { return Err(Beyond::Layers) };
    if layer.thickness.is_finite() {
        return Err(Beyond::Layers);
    }
    if question.incidence != Some(0.0) {
        return Err(Beyond::Incidence);
    }
    let mut media = MediaRow::new(1);
    let (sigma_i, k) = match layer.scattering {
        Scattering::Isotropic { mu_s, g } => {
            media.sin_dive[0] = 1.0;
            (mu_s * (1.0 - g), 0.0)
        }
        Scattering::Fibres { sigma_i, sigma_c, turn, axis, .. } => {
            // A fibre has no sense of direction; the point spread wants its end at larger x.
            let fibre = if axis.x < 0.0 { -axis } else { axis };
            let flat = (fibre.x * fibre.x + fibre.y * fibre.y).sqrt();
            media.sin_dive[0] = fibre.z as f32;
            media.cos_azimuth[0] = if flat > 1e-9 { (fibre.y / flat) as f32 } else { 1.0 };
            // Light comes along -z; what counts is how far its cosine to the fibre has to change.
            media.cone[0] = (question.view.dot(fibre) + fibre.z) as f32;
            (sigma_i, sigma_c * (1.0 - turn.mean_cosine()))
        }
        Scattering::Tensor { .. } => return Err(Beyond::Law),
    };
    if sigma_i <= layer.mu_a {
        return Err(Beyond::Absorption);
    }
    let n = layer.n / stack.above;
    media.mu_a[0] = layer.mu_a as f32;
    media.sigma_i[0] = sigma_i as f32;
    media.k[0] = k as f32;
    media.boundary[0] = boundary_factor(n) as f32;
    media.enter[0] = 1.0 - normal_reflectance(n as f32);
    Ok(media)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::transport::stack::{Layer, Turn};

    fn clear(axis: DVec3) -> Stack {
        let fibres =
            Scattering::Fibres { sigma_i: 2.0, sigma_c: 10.0, turn: Turn::Cauchy(0.0), axis, dispersion: 0.087 };
        Stack::half_space(1.18, 0.08, fibres)
    }

    /// Energy closes, and all rows and all cells together return the reflectance within what leaves the windows.
    #[test]
    fn answers_are_whole() {
        let question = Question { rows: 200, cells: 120, ..Question::default() };
        let answer = solve(&clear(DVec3::Y), &question).expect("it is wood");
        let sum = |list: &[Estimate]| list.iter().map(|e| e.value).sum::<f64>();
        assert!((answer.specular + answer.reflectance.value + sum(&answer.absorbed) - 1.0).abs() < 1e-12);
        let (line, point) = (sum(&answer.line), sum(&answer.point));
        assert!((line / answer.reflectance.value - 1.0).abs() < 1e-3, "{line}");
        assert!((point / answer.reflectance.value - 1.0).abs() < 0.01, "{point}");
    }

    /// A fibre and its opposite are the same fibre, whatever quadrant they are given in.
    #[test]
    fn fibres_have_no_sense() {
        let axis = DVec3::new(0.6, -0.7, 0.2).normalize();
        let (one, other) = (solve(&clear(axis), &Question::default()), solve(&clear(-axis), &Question::default()));
        assert_eq!(one, other);
    }

    /// Closed form of the reflectance of an isotropic half space: D = 1 / (3 s), z0 = 1 / s, docs/physics.md.
    #[test]
    fn isotropic_media_have_a_round_tensor() {
        let (s, a, n) = (10.0, 0.1, 1.4);
        let stack = Stack::half_space(n, a, Scattering::Isotropic { mu_s: 20.0, g: 0.5 });
        let answer = solve(&stack, &Question::default()).expect("it is isotropic");
        let (d, z0) = (1.0 / (3.0 * s), 1.0 / s);
        let z2 = z0 + 4.0 * boundary_factor(n) * d;
        let root = libm::sqrt(a / d);
        let entered = (1.0 - f64::from(normal_reflectance(n as f32))) * libm::exp(-0.5 * a * z0);
        let truth = entered * 0.5 * (libm::exp(-z0 * root) + libm::exp(-z2 * root));
        assert!((answer.reflectance.value - truth).abs() < 2e-3, "{} against {truth}", answer.reflectance.value);
        let towards = answer.towards_lens.map_or(0.0, |e| e.value);
        assert!((towards - answer.reflectance.value).abs() < 1e-6, "no light belongs to a cone: {towards}");
    }

    #[test]
    fn what_it_cannot_say_it_refuses() {
        let wood = clear(DVec3::Y);
        let ask = |stack: &Stack, question: &Question| solve(stack, question).map(|_| ());
        let with = |change: &dyn Fn(&mut Layer)| {
            let mut stack = wood.clone();
            change(&mut stack.layers[0]);
            ask(&stack, &Question::default())
        };
        assert_eq!(with(&|layer| layer.thickness = 3.0), Err(Beyond::Layers));
        assert_eq!(with(&|layer| layer.mu_a = 3.0), Err(Beyond::Absorption));
        assert_eq!(with(&|layer| layer.scattering = Scattering::Tensor { mu_s: DVec3::ONE, g: 0.0 }), Err(Beyond::Law));
        let oblique = Question { incidence: Some(0.1), ..Question::default() };
        assert_eq!(ask(&wood, &oblique), Err(Beyond::Incidence));
        let two = Stack { layers: vec![wood.layers[0]; 2], ..wood.clone() };
        assert_eq!(ask(&two, &Question::default()), Err(Beyond::Layers));
    }
}
