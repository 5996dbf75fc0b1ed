//! Fan: light along the line, q(t), the share of the power per unit of t = tan(theta); on a level plane at depth h a mm
//! of the line carries q / h.
//!
//! ```text
//! powell        q = 1 / (2 T) within |t| < T, ends ramp down over T (1 +- soft) even on a plane
//! cylindrical   q ~ exp(-2 t^2 / T^2) / (1 + t^2)                               hot spot, p(theta) Gaussian in t
//! texture       q ~ sum of the image's column
//! ```
//!
//! T = tan(fan_angle / 2), for a cylindrical lens the angle at 1/e^2. Ripple multiplies q by 1 + r(t), r the sum of 3
//! to 5 sinusoids with 1.5 to 12 periods over the fan, scaled to the amplitude asked for. Each q has the integral 1.
//! Sources: cylindrical lenses and Powell lenses as their vendors describe them (Edmund Optics, Coherent). Neglected:
//! speckle and interference fringes of the lens, light beyond the fan.

use base::Stream;
use rand::RngExt;

use super::texture::LineTexture;
use numerics::lanes::cos_sin_turns;
use optical_bench::parameters::LaserParameters;
use optical_bench::settings::{self, LaserLine};

/// Steps of a tabulated fan.
const TABLE_STEPS: usize = 4096;
/// Extent of a Gaussian fan in half widths at 1/e^2; beyond it there is less than 1.5e-8 of the peak [1].
const GAUSSIAN_REACH: f64 = 3.0;

/// Distribution of power along the fan, q(t).
#[derive(Debug, Clone)]
pub(super) enum FanProfile {
    /// A Powell lens: half the length of the even line and width of its ramps over that [1].
    Even { half: f32, soft: f32 },
    /// q at even steps of t from -`reach` to `reach`.
    Table { reach: f32, q: Vec<f32> },
}

impl FanProfile {
    /// The fan of a bench with the tangent `half` at its ends.
    pub fn new(
        bench: &LaserParameters,
        line: &LaserLine,
        half: f64,
        image: Option<&LineTexture>,
        stream: Stream,
    ) -> Self {
        let even = Self::Even { half: half as f32, soft: bench.fan_soft_ends as f32 };
        let ripple = Ripple::new(bench.fan_ripple, half, stream);
        match (image, line.fan) {
            (Some(image), _) => Self::table(half, &|t| image.column_sum(0.5 + 0.5 * t / half)),
            (None, settings::Fan::Cylindrical) => Self::table(GAUSSIAN_REACH * half, &|t| {
                let side = t / half;
                libm::exp(-2.0 * side * side) / (1.0 + t * t) * ripple.at(t)
            }),
            (None, settings::Fan::Powell) if bench.fan_ripple == 0.0 => even,
            (None, settings::Fan::Powell) => {
                let reach = half * (1.0 + bench.fan_soft_ends);
                Self::table(reach, &|t| f64::from(even.at(t as f32)) * ripple.at(t))
            }
        }
    }

    /// A table of `q`, brought to the integral 1 by the trapezoidal rule.
    fn table(reach: f64, q: &dyn Fn(f64) -> f64) -> Self {
        let step = 2.0 * reach / TABLE_STEPS as f64;
        let values: Vec<f64> = (0..=TABLE_STEPS).map(|i| q(i as f64 * step - reach)).collect();
        let sum = values.iter().sum::<f64>() - 0.5 * (values[0] + values[TABLE_STEPS]);
        let scale = if sum > 0.0 { 1.0 / (sum * step) } else { 0.0 };
        Self::Table { reach: reach as f32, q: values.into_iter().map(|q| (q * scale) as f32).collect() }
    }

    /// q at `t` [1].
    #[inline]
    pub fn at(&self, t: f32) -> f32 {
        match self {
            Self::Even { half, soft } => {
                let side = t.abs() / half;
                0.5 * (1.0 - ((side - 1.0) / soft).clamp(-1.0, 1.0)) / (2.0 * half)
            }
            Self::Table { reach, q } => {
                let position = (t + reach) / (2.0 * reach) * TABLE_STEPS as f32;
                if !(0.0..TABLE_STEPS as f32).contains(&position) {
                    return 0.0;
                }
                let left = position as usize;
                q[left] + (q[left + 1] - q[left]) * (position - left as f32)
            }
        }
    }
}

/// Ripple: sinusoids along the fan.
struct Ripple {
    /// Tangent of half the fan's angle [1].
    half: f64,
    waves: Vec<Sinusoid>,
}

/// One sinusoid of a ripple.
struct Sinusoid {
    /// Amplitude [1].
    amplitude: f64,
    /// Periods over the fan [1].
    periods: f64,
    /// Phase [turns].
    phase: f64,
}

impl Ripple {
    /// Ripple whose greatest departure from an even line is `amplitude`.
    fn new(amplitude: f64, half: f64, stream: Stream) -> Self {
        let mut rng = stream.rng();
        let count = 3 + (rng.random::<u32>() % 3) as usize;
        let mut wave = || Sinusoid {
            amplitude: 0.5 + rng.random::<f64>(),
            periods: 1.5 + 10.5 * rng.random::<f64>(),
            phase: rng.random(),
        };
        let mut ripple = Self { half, waves: (0..count).map(|_| wave()).collect() };
        let tangent = |i: usize| half * (2.0 * i as f64 / TABLE_STEPS as f64 - 1.0);
        let largest = (0..=TABLE_STEPS).map(|i| (ripple.at(tangent(i)) - 1.0).abs()).fold(0.0, f64::max);
        ripple.waves.iter_mut().for_each(|wave| wave.amplitude *= amplitude / largest.max(1e-9));
        ripple
    }

    fn at(&self, t: f64) -> f64 {
        let side = 0.5 + 0.5 * t / self.half;
        let wave = |Sinusoid { amplitude, periods, phase }: &Sinusoid| {
            let turns = periods * side + phase;
            amplitude * f64::from(cos_sin_turns((turns - turns.floor()).min(1.0 - 1e-7) as f32).0)
        };
        1.0 + self.waves.iter().map(wave).sum::<f64>()
    }
}
