//! Diffusion in media whose scattering is a tensor: the generalised anisotropic diffusion equation.
//!
//! Model: a walk with scattering mu(s) = sum mu_i s_i^2 in direction s and Henyey and Greenstein's law about s (Pini,
//! Giusfredi and Pattelli 2026, arXiv 2602.18963). The walk is not reciprocal: in equilibrium radiance goes as 1 / mu.
//! With the mean free path l = 1/4pi int 1/mu and real harmonics Y_lm, to first order in the gradient
//!
//! ```text
//! F(s)   = s_i / mu + sum_(l odd) g^l / (1 - g^l) sum_m Y_lm(s) int Y_lm s_i / mu
//! D_i    = 1 / (4 pi l) int s_i / mu F
//! z_e    = (2 pi D_z + 1/l int_up R s_z / mu F) / (1/l int_up (1 - R) s_z / mu)
//! h_i    = F(s0)           mean displacement of light that starts in direction s0
//! ```
//!
//! Integrals: Gauss and Legendre in the cosine against z, cut at the critical angle, and the midpoint rule in the
//! azimuth. The series runs until a degree adds less than 1e-13. Valid for weak absorption, as every diffusion; D does
//! not depend on it. The published z_e are made with 200 nodes across the critical angle, which leaves up to 2e-3 in
//! them; with the same nodes the formulas here return them to all digits.

use std::f64::consts::PI;

use glam::DVec3;

use numerics::quadrature::{composite, legendre};
use transport::fresnel::internal_reflectance;

/// Nodes of the cosine in each interval.
const COSINE_NODES: usize = 100;
/// Nodes of the azimuth in a quarter turn.
const AZIMUTH_NODES: usize = 64;
/// Highest degree of the series.
const MAX_DEGREE: usize = 99;

/// One harmonic: order m, degree l and its coefficient times g^l / (1 - g^l).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Harmonic {
    m: usize,
    l: usize,
    value: f64,
}

/// What the equation needs of a medium with a tensor of scattering.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Generalized {
    mu_s: DVec3,
    /// Mean free path [mm].
    free: f64,
    /// Series of F of each axis.
    series: [Vec<Harmonic>; 3],
    /// Diffusion coefficient along each axis [mm].
    pub d: DVec3,
}

impl Generalized {
    /// The coefficients of a medium with scattering `mu_s` [mm^-1] along x, y, z and mean cosine `g`.
    pub fn new(mu_s: DVec3, g: f64) -> Self {
        let cosines = composite(&[0.0, 1.0], COSINE_NODES);
        let mut medium = Self { mu_s, free: 0.0, series: [vec![], vec![], vec![]], d: DVec3::ZERO };
        let azimuths = azimuths();
        let directions = || {
            let azimuths = &azimuths;
            cosines.iter().flat_map(move |&(mu, w)| azimuths.iter().map(move |&phi| (direction(mu, phi), w)))
        };
        // Each node stands for its eight mirror images, each azimuth for pi / (2 AZIMUTH_NODES).
        let solid = 4.0 * PI / AZIMUTH_NODES as f64;
        medium.free = directions().map(|(s, w)| w / medium.mu(s)).sum::<f64>() * solid / (4.0 * PI);
        for axis in 0..3 {
            let plain = directions().map(|(s, w)| w * (s[axis] / medium.mu(s)).powi(2)).sum::<f64>() * solid;
            let (series, added) = medium.harmonics(axis, g, plain, &cosines, &azimuths);
            medium.series[axis] = series;
            medium.d[axis] = (plain + added) / (4.0 * PI * medium.free);
        }
        medium
    }

    /// Scattering in direction `s` [mm^-1].
    fn mu(&self, s: DVec3) -> f64 {
        self.mu_s.dot(s * s)
    }

    /// The series of one axis, and what it adds to the integral `plain`.
    fn harmonics(
        &self,
        axis: usize,
        g: f64,
        plain: f64,
        cosines: &[(f64, f64)],
        azimuths: &[f64],
    ) -> (Vec<Harmonic>, f64) {
        let (mut series, mut added) = (Vec::new(), 0.0);
        if g == 0.0 {
            return (series, added);
        }
        let scale = 4.0 * PI / azimuths.len() as f64;
        // Projection on cos(m phi) or sin(m phi) at each cosine; x and y have odd orders alone, z even ones.
        let projected: Vec<Vec<f64>> = (0..=MAX_DEGREE)
            .map(|m| {
                let at = |mu: f64| -> f64 {
                    let sum = azimuths.iter().map(|&phi| {
                        let s = direction(mu, phi);
                        s[axis] / self.mu(s) * turn(axis, m, phi)
                    });
                    sum.sum()
                };
                let own = m % 2 == usize::from(axis < 2);
                if own { cosines.iter().map(|&(mu, _)| at(mu)).collect() } else { Vec::new() }
            })
            .collect();
        let tables: Vec<Vec<Vec<f64>>> =
            (0..=MAX_DEGREE).map(|m| cosines.iter().map(|&(mu, _)| legendre(m, MAX_DEGREE, mu)).collect()).collect();
        for l in (1..=MAX_DEGREE).step_by(2) {
            let power = libm::pow(g.abs(), l as f64).copysign(g);
            let weight = power / (1.0 - power);
            let mut degree = 0.0;
            for m in (usize::from(axis < 2)..=l).step_by(2) {
                let nodes = cosines.iter().zip(&projected[m]).zip(&tables[m]);
                let own: f64 = nodes.map(|((&(_, w), value), table)| w * value * table[l - m]).sum::<f64>() * scale;
                series.push(Harmonic { m, l, value: weight * own });
                degree += weight * own * own;
            }
            added += degree;
            if degree.abs() < 1e-13 * plain {
                break;
            }
        }
        (series, added)
    }

    /// F along `axis` in direction (mu, phi) [mm].
    fn first_order(&self, axis: usize, mu: f64, phi: f64) -> f64 {
        let s = direction(mu, phi);
        let (mut sum, mut order, mut table) = (s[axis] / self.mu(s), usize::MAX, Vec::new());
        let degree = self.series[axis].last().map_or(0, |term| term.l);
        let mut terms: Vec<&Harmonic> = self.series[axis].iter().collect();
        terms.sort_by_key(|term| (term.m, term.l));
        for term in terms {
            if term.m != order {
                (order, table) = (term.m, legendre(term.m, degree, mu));
            }
            sum += term.value * table[term.l - term.m] * turn(axis, term.m, phi);
        }
        sum
    }

    /// Mean displacement of light that starts in direction `s` [mm].
    pub fn persistence(&self, s: DVec3) -> DVec3 {
        let phi = libm::atan2(s.y, s.x);
        DVec3::from_array(std::array::from_fn(|axis| self.first_order(axis, s.z, phi)))
    }

    /// Height z_e above a surface across z at which the fluence vanishes, `n` the index inside over that outside [mm].
    pub(crate) fn extrapolation(&self, n: f64) -> f64 {
        let critical = if n > 1.0 { (1.0 - 1.0 / (n * n)).sqrt() } else { 0.0 };
        let edges = if critical > 0.0 { vec![0.0, critical, 1.0] } else { vec![0.0, 1.0] };
        self.extrapolation_with(n, &composite(&edges, COSINE_NODES))
    }

    pub(super) fn extrapolation_with(&self, n: f64, cosines: &[(f64, f64)]) -> f64 {
        let (mut out, mut back) = (0.0, 0.0);
        let azimuths = azimuths();
        let solid = 2.0 * PI / (azimuths.len() as f64 * self.free);
        for &(mu, w) in cosines {
            let r = internal_reflectance(n, mu);
            for &phi in &azimuths {
                let flow = w * mu / self.mu(direction(mu, phi));
                out += (1.0 - r) * flow;
                if r > 0.0 {
                    back += r * flow * self.first_order(2, mu, phi);
                }
            }
        }
        (2.0 * PI * self.d.z + solid * back) / (solid * out)
    }
}

fn direction(mu: f64, phi: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(phi);
    let sine = (1.0 - mu * mu).max(0.0).sqrt();
    DVec3::new(sine * cos, sine * sin, mu)
}

/// Midpoints of a quarter turn.
fn azimuths() -> Vec<f64> {
    (0..AZIMUTH_NODES).map(|j| (j as f64 + 0.5) * 0.5 * PI / AZIMUTH_NODES as f64).collect()
}

/// Azimuthal part of a real harmonic: F along y is odd in y, along x and z even.
fn turn(axis: usize, m: usize, phi: f64) -> f64 {
    let (sin, cos) = libm::sincos(m as f64 * phi);
    match (axis, m) {
        (_, 0) => 1.0,
        (1, _) => std::f64::consts::SQRT_2 * sin,
        _ => std::f64::consts::SQRT_2 * cos,
    }
}
