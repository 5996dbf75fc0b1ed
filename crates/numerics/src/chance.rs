//! Normal distribution: share below a number, and the number below which a share lies.
//!
//! Share: Phi(z) = erfc(-z / sqrt 2) / 2, with full relative precision below 0.
//!
//! Quantile: Phi(z) = p, by rational functions of degree seven on three intervals (Wichura 1988, algorithm AS 241,
//! PPND16): within 10^-16 of it relatively, for p from 10^-316 on. Valid for p in (0, 1); 0 and 1 have the infinities.
//! Above one half the steps of floating-point numbers next to 1 limit z: who needs the upper tail asks for the lower
//! one and turns the sign.

/// Half width of the middle interval of p about one half [1].
const MIDDLE: f64 = 0.425;
/// Its square [1].
const MIDDLE_SQUARE: f64 = 0.180_625;
/// Where the far tail begins, in sqrt(-ln p) [1].
const FAR: f64 = 5.0;
/// Shift of the near tail, in sqrt(-ln p) [1].
const NEAR_SHIFT: f64 = 1.6;

/// Numerator and denominator of a rational function, from the constant up.
type Rational = ([f64; 8], [f64; 8]);

const MIDDLE_PART: Rational = (
    [
        3.387_132_872_796_366_5,
        133.141_667_891_784_38,
        1_971.590_950_306_551_3,
        13_731.693_765_509_46,
        45_921.953_931_549_87,
        67_265.770_927_008_7,
        33_430.575_583_588_13,
        2_509.080_928_730_122_7,
    ],
    [
        1.0,
        42.313_330_701_600_91,
        687.187_007_492_057_9,
        5_394.196_021_424_751,
        21_213.794_301_586_597,
        39_307.895_800_092_71,
        28_729.085_735_721_943,
        5_226.495_278_852_854,
    ],
);

const NEAR_TAIL: Rational = (
    [
        1.423_437_110_749_683_5,
        4.630_337_846_156_546,
        5.769_497_221_460_691,
        3.647_848_324_763_204_5,
        1.270_458_252_452_368_4,
        0.241_780_725_177_450_6,
        0.022_723_844_989_269_184,
        7.745_450_142_783_414e-4,
    ],
    [
        1.0,
        2.053_191_626_637_759,
        1.676_384_830_183_803_8,
        0.689_767_334_985_1,
        0.148_103_976_427_480_08,
        0.015_198_666_563_616_457,
        5.475_938_084_995_345e-4,
        1.050_750_071_644_416_9e-9,
    ],
);

const FAR_TAIL: Rational = (
    [
        6.657_904_643_501_103,
        5.463_784_911_164_114,
        1.784_826_539_917_291_3,
        0.296_560_571_828_504_87,
        0.026_532_189_526_576_124,
        0.001_242_660_947_388_078_4,
        2.711_555_568_743_487_6e-5,
        2.010_334_399_292_288_1e-7,
    ],
    [
        1.0,
        0.599_832_206_555_887_9,
        0.136_929_880_922_735_8,
        0.014_875_361_290_850_615,
        7.868_691_311_456_133e-4,
        1.846_318_317_510_054_8e-5,
        1.421_511_758_316_446e-7,
        2.044_263_103_389_939_8e-15,
    ],
);

/// Share of the normal distribution below `z`.
pub fn normal_below(z: f64) -> f64 {
    0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)
}

/// The number below which the share `p` of the normal distribution lies.
pub fn normal_quantile(p: f64) -> f64 {
    if p <= 0.0 {
        return f64::NEG_INFINITY;
    }
    if p >= 1.0 {
        return f64::INFINITY;
    }
    let from_middle = p - 0.5;
    if from_middle.abs() <= MIDDLE {
        return from_middle * ratio(&MIDDLE_PART, MIDDLE_SQUARE - from_middle * from_middle);
    }
    let depth = (-libm::log(p.min(1.0 - p))).sqrt();
    let z = if depth <= FAR { ratio(&NEAR_TAIL, depth - NEAR_SHIFT) } else { ratio(&FAR_TAIL, depth - FAR) };
    if from_middle < 0.0 { -z } else { z }
}

fn ratio((numerator, denominator): &Rational, x: f64) -> f64 {
    let polynomial = |terms: &[f64; 8]| terms.iter().rev().fold(0.0, |sum, term| sum * x + term);
    polynomial(numerator) / polynomial(denominator)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the values of another program (Cephes' ndtri, by scipy 1.16).
    #[test]
    fn quantiles_are_those_of_tables() {
        let known = [
            (0.5, 0.0),
            (0.75, 0.674_489_750_196_081_7),
            (0.975, 1.959_963_984_540_054),
            (0.001, -3.090_232_306_167_813_5),
            (1e-10, -6.361_340_902_404_056),
            (1e-20, -9.262_340_089_798_409),
            (1e-100, -21.273_453_560_965_32),
        ];
        for (p, z) in known {
            assert!((normal_quantile(p) - z).abs() <= 4e-16 * z.abs().max(1.0), "{p}: {}", normal_quantile(p));
        }
        assert_eq!((normal_quantile(0.0), normal_quantile(1.0)), (f64::NEG_INFINITY, f64::INFINITY));
    }

    /// The share below the quantile is the share, from far in the lower tail to where numbers next to 1 are too coarse.
    #[test]
    fn quantiles_turn_shares_back() {
        for step in -3000..=800 {
            let z = f64::from(step) / 100.0;
            let p = normal_below(z);
            // A relative error e of p moves z by e p / density(z), about e / |z| in the tails; beside 1 the error is
            // absolute.
            let density = libm::exp(-0.5 * z * z) / (2.0 * std::f64::consts::PI).sqrt();
            let slack = 4e-16 * z.abs().max(1.0)
                + (4.0 * f64::EPSILON * p + if z > 0.0 { f64::EPSILON } else { 0.0 }) / density * (1.0 + z * z);
            assert!((normal_quantile(p) - z).abs() <= slack, "{z}: {} of {p}, slack {slack:e}", normal_quantile(p));
        }
    }

    #[test]
    fn quantiles_rise() {
        let quantiles: Vec<f64> = (1..100_000).map(|i| normal_quantile(f64::from(i) / 100_000.0)).collect();
        assert!(quantiles.windows(2).all(|pair| pair[0] < pair[1]));
    }
}
