//! Theory of fully developed speckle behind square pixels: intensity law, boiling.
//!
//! [`PixelCorrelation`](rig::PixelCorrelation) has the contrast of a pixel and the correlation between pixels. The
//! light of a pixel is a sum of independent exponential parts whose shares are the eigenvalues of mu over the pixel
//! (Karhunen and Loeve; Goodman 2007, 4.6): close to a gamma law of shape 1 / C^2, exponential where the pixel is a
//! point. For a line of standard deviation sigma [px] the centre of gravity spreads by C sqrt(sigma L_c / (4
//! sqrt(pi))), L_c the integral of the correlation along the rows, which is the limit of a line wide against a row of
//! Dorsch, Häusler and Herrmann's (1994) uncertainty.

use std::f64::consts::PI;

use optical_bench::parameters::Bench;

/// Share of a round pupil that another one `s` diameters away covers [1].
pub fn overlap(s: f64) -> f64 {
    let s = s.min(1.0);
    2.0 / PI * (libm::acos(s) - s * (1.0 - s * s).sqrt())
}

/// Diameters of the pupil that a step along the motion at the origin is worth: a_y (d_SP / R + 1 - l_y^2) / cos(tilt),
/// R the radius of the laser's wave [1].
pub(crate) fn pupils(bench: &Bench, step_mm: f64) -> f64 {
    let (camera, laser) = (&bench.camera, &bench.laser);
    let rayleigh = PI * laser.waist_mm.powi(2) / (laser.m_squared * laser.wavelength_nm * 1e-6);
    let behind = laser.waist_height_mm;
    let bend = behind / (behind * behind + rayleigh * rayleigh);
    let cos = libm::cos(camera.tilt_deg.to_radians());
    step_mm * (camera.distance_mm * bend + cos * cos) / cos / (camera.focal_length_mm / camera.f_number)
}

/// Correlation of a pattern in pixels with itself after the pupil has moved by `s` diameters along the rows, summed
/// over all lags along the rows [1].
///
/// The common part of both pupils contains the frequencies of its pairs of cells. A sum over rows keeps pairs side by
/// side, each weighted by the transfer function of a pixel's width.
pub(crate) fn boiled(grain: f64, s: f64) -> f64 {
    const CELLS: usize = 400;
    let cell = 1.0 / (CELLS as f64 * grain);
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { (libm::sin(PI * x) / (PI * x)).powi(2) };
    let light = |s: f64| -> f64 {
        let wide = |down: f64| (0.25 - down * down).max(0.0).sqrt();
        let row = |i: usize| {
            let down = (i as f64 + 0.5) / CELLS as f64 - 0.5;
            // Cells across that both pupils have here.
            let cells = (2.0 * wide(down).min(wide(down - s)) * CELLS as f64).round() as usize;
            (0..cells)
                .map(|d| (if d == 0 { 1.0 } else { 2.0 }) * (cells - d) as f64 * sinc(d as f64 * cell))
                .sum::<f64>()
        };
        (0..CELLS).map(row).sum()
    };
    light(s) / light(0.0)
}

/// Probability distribution of the light in one pixel, of mean 1.
#[derive(Debug, Clone)]
pub(crate) struct IntensityLaw {
    /// Shares of the independent exponential parts [1].
    shares: Vec<f64>,
    /// Chance of less light than i / [`LAW_POINTS`] [1].
    below: Vec<f64>,
}

/// Points of a law in a unit of light, and light up to which it is kept.
const LAW_POINTS: usize = 40;
const MAX_LIGHT: usize = 14;

impl IntensityLaw {
    /// Of the mean of `patterns` independent patterns with grains of `grain` pixels.
    pub fn of(grain: f64, patterns: usize) -> Self {
        let parts = eigenvalues(covariances(grain));
        let share = |part: f64| vec![part / patterns as f64; patterns];
        let shares: Vec<f64> = parts.into_iter().filter(|part| *part > 1e-7).flat_map(share).collect();
        let below = (0..=LAW_POINTS * MAX_LIGHT).map(|i| i as f64 / LAW_POINTS as f64);
        // Gil-Pelaez' (1951) inversion of the characteristic function 1 / prod(1 - i t share), by trapezoids.
        const STEP: f64 = 0.04;
        let waves: Vec<(f64, f64, f64)> = (1..20_000)
            .map(|i| {
                let t = STEP * f64::from(i);
                let (mut size, mut angle) = (1.0, 0.0);
                for share in &shares {
                    size /= (1.0 + t * t * share * share).sqrt();
                    angle += libm::atan(t * share);
                }
                (t, size, angle)
            })
            .take_while(|(t, size, _)| size / t > 1e-9)
            .collect();
        let at = |x: f64| {
            let sum: f64 = waves.iter().map(|(t, size, angle)| size * libm::sin(angle - t * x) / t).sum();
            (0.5 - STEP / PI * (sum + 0.5 * (1.0 - x))).clamp(0.0, 1.0)
        };
        let below = below.map(at).collect();
        Self { shares, below }
    }

    /// Chance of less light than `x` [1].
    pub fn below(&self, x: f64) -> f64 {
        let place = x.max(0.0) * LAW_POINTS as f64;
        let (i, t) = (place as usize, place.fract());
        if i + 1 < self.below.len() { self.below[i] * (1.0 - t) + self.below[i + 1] * t } else { 1.0 }
    }

    /// The light that is not reached with the chance `below` [1].
    pub fn draw(&self, below: f64) -> f64 {
        let i = self.below.partition_point(|chance| *chance < below).clamp(1, self.below.len() - 1);
        let (low, high) = (self.below[i - 1], self.below[i]);
        let t = if high > low { (below - low) / (high - low) } else { 0.5 };
        (i as f64 - 1.0 + t.clamp(0.0, 1.0)) / LAW_POINTS as f64
    }

    /// Its density at `x` [1].
    pub fn density(&self, x: f64) -> f64 {
        let half = 1.0 / LAW_POINTS as f64;
        (self.below(x + half) - self.below((x - half).max(0.0))) / (half + half.min(x))
    }

    /// Third central moment over the variance to 3/2 [1].
    pub(crate) fn skewness(&self) -> f64 {
        let moment = |n: i32| self.shares.iter().map(|share| share.powi(n)).sum::<f64>();
        2.0 * moment(3) / (moment(2) * moment(2).sqrt())
    }
}

/// mu between points of the pixel over their number, `[POINTS^2][POINTS^2]` [1].
fn covariances(grain: f64) -> Vec<Vec<f64>> {
    const POINTS: usize = 9;
    let place = |i: usize| [i / POINTS, i % POINTS].map(|p| (p as f64 + 0.5) / POINTS as f64);
    let mu = |i: usize, j: usize| {
        let ([a, b], [c, d]) = (place(i), place(j));
        let r = PI * libm::hypot(a - c, b - d) / grain;
        let mu = if r < 1e-6 { 1.0 } else { 2.0 * libm::j1(r) / r };
        mu / (POINTS * POINTS) as f64
    };
    (0..POINTS * POINTS).map(|i| (0..POINTS * POINTS).map(|j| mu(i, j)).collect()).collect()
}

/// Eigenvalues of a symmetric matrix by Jacobi's rotations.
fn eigenvalues(mut m: Vec<Vec<f64>>) -> Vec<f64> {
    let n = m.len();
    for _ in 0..8 {
        for p in 0..n {
            for q in p + 1..n {
                if m[p][q].abs() < 1e-12 {
                    continue;
                }
                let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let (c, s) = (1.0 / (t * t + 1.0).sqrt(), t / (t * t + 1.0).sqrt());
                for row in &mut m {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
                for i in 0..n {
                    (m[p][i], m[q][i]) = (c * m[p][i] - s * m[q][i], s * m[p][i] + c * m[q][i]);
                }
            }
        }
    }
    (0..n).map(|i| m[i][i]).collect()
}

#[cfg(test)]
mod tests {
    use rig::PixelCorrelation;

    use super::*;

    /// The parts make the pixel's mean and Goodman's contrast; points are exponential; many patterns are nearly normal.
    #[test]
    fn laws_have_goodmans_moments() {
        for grain in [0.328, 1.64] {
            let (law, contrast) = (IntensityLaw::of(grain, 1), PixelCorrelation::of(grain).contrast());
            let moment = |n: i32| law.shares.iter().map(|share| share.powi(n)).sum::<f64>();
            assert!((moment(1) - 1.0).abs() < 1e-5, "{}", moment(1));
            assert!((moment(2).sqrt() / contrast - 1.0).abs() < 0.01, "{} {contrast}", moment(2).sqrt());
            // Never less skew than the gamma law.
            assert!(law.skewness() >= 2.0 * contrast * 0.99, "{}", law.skewness());
        }
        let point = IntensityLaw::of(60.0, 1);
        for x in [0.1, 0.5, 1.0, 3.0] {
            assert!((point.below(x) - (1.0 - libm::exp(-x))).abs() < 2e-3, "{x}: {}", point.below(x));
        }
    }
}
