//! Theory of fully developed speckle behind square pixels: contrast, correlation, intensity law, boiling.
//!
//! A round lens of working f-number N (1 + m) makes grains of L = lambda N (1 + m) whose intensity is correlated by
//! |mu|^2 = [2 J1(pi r / L) / (pi r / L)]^2 (Goodman 2007, 4.4). Behind a pixel of side a the contrast is
//!
//! ```text
//! C^2 = (1 / a^4) int int (a - |u|) (a - |v|) |mu(u, v)|^2 du dv,
//! ```
//!
//! pixels d apart have the same integral with u + d for u. The light of a pixel is a sum of independent exponential parts
//! whose shares are the eigenvalues of mu over the pixel (Karhunen and Loeve; Goodman 2007, 4.6): close to a gamma law of
//! shape 1 / C^2, exponential where the pixel is a point. For a line of standard deviation sigma [px] the centre
//! of gravity spreads by C sqrt(sigma L_c / (4 sqrt(pi))), L_c the integral of the correlation along the rows, which is the
//! limit of a line wide against a row of Dorsch, Häusler and Herrmann's (1994) uncertainty.

use std::f64::consts::PI;

use bench::parameters::Bench;

/// Steps of the integrals over a pixel, and lags in a pixel and in all that are kept.
const PIXEL_STEPS: usize = 120;
const LAGS_PER_PIXEL: usize = 20;
const MAX_LAG_PX: usize = 8;
/// Width of a step, two pixels being integrated [px], and steps from a lag to the next.
const STRIP_PX: f64 = 2.0 / PIXEL_STEPS as f64;
const STEPS_PER_LAG: usize = PIXEL_STEPS / (2 * LAGS_PER_PIXEL);

/// Grain L over the pixel [1].
pub(crate) fn grain_px(bench: &Bench) -> f64 {
    let camera = &bench.camera;
    let magnification = camera.focal_length_mm / (camera.distance_mm - camera.focal_length_mm);
    bench.laser.wavelength_nm * 1e-3 * camera.f_number * (1.0 + magnification) / camera.pixel_um
}

/// Share of a round pupil that another one `s` diameters away covers [1].
pub fn overlap(s: f64) -> f64 {
    let s = s.min(1.0);
    2.0 / PI * (libm::acos(s) - s * (1.0 - s * s).sqrt())
}

/// Diameters of the pupil that a step along the motion at the origin is worth: a_y (d_SP / R + 1 - l_y^2) / cos(tilt), R the
/// radius of the laser's wave [1].
pub(crate) fn pupils(bench: &Bench, step_mm: f64) -> f64 {
    let (camera, laser) = (&bench.camera, &bench.laser);
    let rayleigh = PI * laser.waist_mm.powi(2) / (laser.m_squared * laser.wavelength_nm * 1e-6);
    let behind = laser.waist_height_mm;
    let bend = behind / (behind * behind + rayleigh * rayleigh);
    let cos = libm::cos(camera.tilt_deg.to_radians());
    step_mm * (camera.distance_mm * bend + cos * cos) / cos / (camera.focal_length_mm / camera.f_number)
}

/// Correlation of a pattern in pixels with itself after the pupil has moved by `s` diameters along the rows, summed over all
/// lags along the rows [1].
///
/// The common part of both pupils contains the frequencies of its pairs of cells. A sum over rows keeps pairs side by side,
/// each weighted by the transfer function of a pixel's width.
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

/// Correlation of the light in pixels along a row or a column.
#[derive(Debug, Clone)]
pub(crate) struct PixelCorrelation {
    /// Covariance at lag 0, C^2, for light of mean 1 [1].
    pub variance: f64,
    /// Correlation at lags of 1/20 px [1].
    lags: Vec<f64>,
}

impl PixelCorrelation {
    /// For grains of `grain` pixels.
    pub fn of(grain: f64) -> Self {
        // The light of a strip of a pixel is the same for all lags that bring it there.
        let strips: Vec<f64> = (0..PIXEL_STEPS + STEPS_PER_LAG * LAGS_PER_PIXEL * MAX_LAG_PX)
            .map(|i| strip(grain, strip_place(i)))
            .collect();
        let covariance = |lag: usize| -> f64 {
            let weight = |i: usize| (1.0 - strip_place(i).abs()) * STRIP_PX;
            (0..PIXEL_STEPS).map(|i| weight(i) * strips[i + STEPS_PER_LAG * lag]).sum()
        };
        let lags: Vec<f64> = (0..=LAGS_PER_PIXEL * MAX_LAG_PX).map(covariance).collect();
        Self { variance: lags[0], lags: lags.iter().map(|lag| lag / lags[0]).collect() }
    }

    /// At a lag [px]; 0 beyond eight.
    pub fn at(&self, lag: f64) -> f64 {
        let place = lag.abs() * LAGS_PER_PIXEL as f64;
        let (i, t) = (place as usize, place.fract());
        if i + 1 < self.lags.len() { self.lags[i] * (1.0 - t) + self.lags[i + 1] * t } else { 0.0 }
    }

    /// Contrast in one pixel (Goodman) [1].
    pub fn contrast(&self) -> f64 {
        self.variance.sqrt()
    }

    /// Its integral over all lags [px].
    pub fn length(&self) -> f64 {
        // Trapezoid; both sides.
        2.0 / LAGS_PER_PIXEL as f64 * (self.lags.iter().sum::<f64>() - 0.5)
    }

    /// Closed form of the centre's spread for a line of standard deviation `sigma` [px].
    pub(crate) fn wide_line(&self, contrast: f64, sigma: f64) -> f64 {
        contrast * (sigma * self.length() / (4.0 * PI.sqrt())).sqrt()
    }
}

/// Middle of strip `i` along one axis, from a pixel before the first lag on [px].
fn strip_place(i: usize) -> f64 {
    -1.0 + (i as f64 + 0.5) * STRIP_PX
}

/// Integral of (1 - |v|) |mu(u, v)|^2 over v, across the axis of the lags [px].
fn strip(grain: f64, u: f64) -> f64 {
    let at = |j: usize| {
        let v = (j as f64 + 0.5) * STRIP_PX;
        let r = PI * libm::hypot(u, v) / grain;
        let airy = if r < 1e-6 { 1.0 } else { 2.0 * libm::j1(r) / r };
        2.0 * (1.0 - v) * airy * airy * STRIP_PX
    };
    (0..PIXEL_STEPS / 2).map(at).sum()
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
    use super::*;

    /// Goodman's contrast for the eight pixels of docs/theory/instrument.md; the correlation length that it gives for 6
    /// um.
    #[test]
    fn contrast_and_length_are_goodmans() {
        let pixels = [1.2, 2.4, 3.45, 4.8, 5.5, 6.0, 9.0, 12.0];
        let known = [0.867, 0.631, 0.487, 0.376, 0.335, 0.3115, 0.218, 0.168];
        for (pixel, contrast) in pixels.into_iter().zip(known) {
            let found = PixelCorrelation::of(1.968 / pixel).contrast();
            assert!((found / contrast - 1.0).abs() < 4e-3, "{pixel} um: {found} against {contrast}");
        }
    }

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
