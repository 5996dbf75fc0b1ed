//! Elementary functions for vector lanes: plain arithmetic, so that loops over columns become vector code on any
//! instruction set and give the same bits on each: no fused multiply-add, no table, no call.
//!
//! Errors are stated with each function and tested against `f64`.

/// Step of uniform numbers.
const UNIT: f32 = 1.0 / 16_777_216.0;

/// exp(x); relative error under 4e-7 + 1e-7 |x| for x in [-87, 87], clamped beyond.
#[inline(always)]
pub fn exp(x: f32) -> f32 {
    exp2(x * std::f32::consts::LOG2_E)
}

/// 2^x; relative error under 3e-7 for x in [-126, 126], clamped there.
#[inline(always)]
pub fn exp2(x: f32) -> f32 {
    /// 1.5 * 2^23: adding it rounds to the nearest whole number, left in the low bits.
    const ROUNDING_SHIFT: f32 = 12_582_912.0;
    let x = x.clamp(-126.0, 126.0);
    let shifted = x + ROUNDING_SHIFT;
    let whole = shifted - ROUNDING_SHIFT;
    let f = x - whole;
    // Taylor series of 2^f on [-1/2, 1/2]: ln(2)^n / n!.
    let p = 1.540_353e-4;
    let p = p * f + 1.333_355_8e-3;
    let p = p * f + 9.618_129e-3;
    let p = p * f + 5.550_411e-2;
    let p = p * f + 2.402_265_1e-1;
    let p = p * f + 6.931_472e-1;
    let p = p * f + 1.0;
    let exponent = (shifted.to_bits() << 23).wrapping_add(0x3f80_0000);
    p * f32::from_bits(exponent)
}

/// ln(x) for normal x > 0; absolute error under 4e-7 (1 + |ln x|).
#[inline(always)]
pub fn ln(x: f32) -> f32 {
    // Mantissa in [sqrt(1/2), sqrt(2)), then ln m = 2 artanh((m - 1) / (m + 1)).
    let bits = x.to_bits().wrapping_sub(0x3f35_04f3);
    let exponent = ((bits as i32) >> 23) as f32;
    let m = f32::from_bits((bits & 0x007f_ffff).wrapping_add(0x3f35_04f3));
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let series = 0.222_222_22 + s2 * 0.181_818_18;
    let series = 0.285_714_3 + s2 * series;
    let series = 0.4 + s2 * series;
    let series = 0.666_666_7 + s2 * series;
    exponent * std::f32::consts::LN_2 + s * (2.0 + s2 * series)
}

/// (cos, sin) of 2 pi u for u in [0, 1); absolute error under 4e-6.
#[inline(always)]
pub fn cos_sin_turns(u: f32) -> (f32, f32) {
    let x = u - 0.5;
    let a = x.abs();
    // Both are sines of an angle folded into a quarter turn; minus signs because x is u less half a turn.
    let cos = quarter_sine(a - 0.25);
    let sin = -quarter_sine((0.25 - (a - 0.25).abs()).copysign(x));
    (cos, sin)
}

/// sin(2 pi t) for t in [-1/4, 1/4].
#[inline(always)]
fn quarter_sine(t: f32) -> f32 {
    let t2 = t * t;
    let p = 42.058_69 + t2 * -15.094_643;
    let p = -76.705_86 + t2 * p;
    let p = 81.605_25 + t2 * p;
    let p = -41.341_7 + t2 * p;
    t * (std::f32::consts::TAU + t2 * p)
}

/// A hash of 32 bits into 32 bits with two multiplications: an invertible mixer after Wellons' search for low bias.
#[inline(always)]
pub fn hash(x: u32) -> u32 {
    let x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    let x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// Two independent standard normals for a counter under two keys (Box and Muller 1958); |n| < 5.9.
#[inline(always)]
pub fn normals(counter: u32, keys: [u32; 2]) -> (f32, f32) {
    let u = radius_uniform(counter, keys);
    let v = (hash(counter.wrapping_add(keys[1])) >> 8) as i32 as f32 * UNIT;
    let radius = (-2.0 * ln(u)).max(0.0).sqrt();
    let (cos, sin) = cos_sin_turns(v);
    (radius * cos, radius * sin)
}

/// The uniform number u from which [`normals`] have their common radius, sqrt(-2 ln u); in (0, 1].
#[inline(always)]
pub fn radius_uniform(counter: u32, keys: [u32; 2]) -> f32 {
    ((hash(counter ^ keys[0]) >> 8) as i32 as f32 + 0.5) * UNIT
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_match_double_precision() {
        for i in -8000..=8000i32 {
            let x = i as f32 * 0.01;
            let truth = f64::from(x).exp();
            assert!((f64::from(exp(x)) / truth - 1.0).abs() < 4e-7 + 1e-7 * f64::from(x.abs()), "exp {x}");
            let y = (f64::from(i) * 0.005).exp() as f32;
            let truth = f64::from(y).ln();
            assert!((f64::from(ln(y)) - truth).abs() < 4e-7 * (1.0 + truth.abs()), "ln {y}");
        }
        for i in 0..10_000 {
            let u = i as f32 / 10_000.0;
            let angle = f64::from(u) * std::f64::consts::TAU;
            let (cos, sin) = cos_sin_turns(u);
            assert!((f64::from(cos) - angle.cos()).abs() < 6e-6, "cos {u}: {cos}");
            assert!((f64::from(sin) - angle.sin()).abs() < 6e-6, "sin {u}: {sin}");
        }
    }

    /// Kolmogorov-Smirnov distance of n normals against the normal law, at alpha = 1e-3.
    #[test]
    fn normals_are_normal() {
        let mut draws: Vec<f64> = (0..100_000u32)
            .flat_map(|i| {
                let (a, b) = normals(i, [0x1234_5678, 0x9abc_def0]);
                [f64::from(a), f64::from(b)]
            })
            .collect();
        let n = draws.len() as f64;
        let lag: f64 = draws.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n;
        assert!(lag.abs() < 3.3 / n.sqrt(), "correlation of neighbours {lag}");
        draws.sort_by(f64::total_cmp);
        let mut distance = 0.0f64;
        for (i, &x) in draws.iter().enumerate() {
            let cdf = normal_cdf(x);
            distance = distance.max((cdf - i as f64 / n).abs()).max(((i + 1) as f64 / n - cdf).abs());
        }
        assert!(distance < 1.95 / n.sqrt(), "KS distance {distance}");
    }

    /// Normal law by Marsaglia's series, exact to 1e-15 for |x| < 7.
    fn normal_cdf(x: f64) -> f64 {
        let (mut sum, mut term, mut i) = (x, x, 1.0);
        while term.abs() > 1e-17 * sum.abs() {
            i += 2.0;
            term *= x * x / i;
            sum += term;
        }
        0.5 + sum * (-0.5 * x * x - 0.918_938_533_204_672_7).exp()
    }
}
