//! The sums of Gaussians against what they stand for.

use super::*;

fn bench() -> Laser {
    Laser::from_values(&mut |p| p.default)
}

fn height(strands: &[Strand], y: f64, blur: f64) -> f64 {
    let one = |s: &Strand| {
        let variance = f64::from(s.variance) + blur * blur;
        let d = y - f64::from(s.offset);
        f64::from(s.weight) * (-0.5 * d * d / variance).exp() / (2.0 * std::f64::consts::PI * variance).sqrt()
    };
    strands.iter().map(one).sum()
}

/// The Gaussians of the skirt against the halo's own law, out to eight times its scale.
#[test]
fn skirt_is_a_moffat_halo() {
    assert!((SKIRT.iter().map(|&(weight, _)| weight).sum::<f64>() - 1.0).abs() < 1e-6);
    let a = 4.0;
    let strand = |&(weight, sigma): &(f64, f64)| Strand {
        offset: 0.0,
        variance: (a * a * sigma * sigma) as f32,
        weight: weight as f32,
    };
    let strands: Vec<_> = SKIRT.iter().map(strand).collect();
    let law = |y: f64| 0.5 / a * (1.0 + (y / a).powi(2)).powf(-1.5);
    for i in 0..=800 {
        let y = 0.01 * f64::from(i) * a;
        assert!((height(&strands, y, 0.0) / law(y) - 1.0).abs() < 0.0222, "{y}");
    }
    assert!((law(0.5 * SKIRT_FWHM * a) / law(0.0) - 0.5).abs() < 1e-6);
}

/// However many strands are joined, light stays, and the blurred line stays within 3 % of the lobes' height.
#[test]
fn joined_strands_look_the_same() {
    let mut bench = bench();
    (bench.lobe_share, bench.lobe_pairs, bench.lobe_distance) = (0.05, 3.0, 1.5);
    (bench.skirt_share, bench.skirt_width) = (0.03, 8.0);
    let strands = flawed(&bench);
    let mut fewer = 0;
    for sigma in [1.0, 2.0, 4.0, 8.0, 16.0, 32.0] {
        let joined = joined(&strands, sigma);
        fewer += strands.len() - joined.len();
        assert!((joined.iter().map(|s| s.weight).sum::<f32>() - 1.0).abs() < 1e-5);
        let most = height(&strands, 0.0, sigma);
        for i in 0..400 {
            let y = 0.25 * f64::from(i);
            let off = (height(&joined, y, sigma) - height(&strands, y, sigma)).abs();
            assert!(off < 1.5e-3 * most, "{off} of {most} at {y}, blur {sigma}");
        }
    }
    assert!(fewer > 10, "{fewer} strands joined");
}

/// Boxes under the blur that they were made for are an even line, within 1.5e-3.
#[test]
fn boxes_are_an_even_line() {
    for (sigma, count) in [(0.05f64, 23), (0.12, 10), (0.5, 3), (1.5, 1)] {
        assert_eq!((1.0 / (BOX * sigma)).ceil() as usize, count);
        let strands = boxes(1.0, count);
        for i in 0..200 {
            let y = 0.02 * f64::from(i);
            let below = |x: f64| 0.5 * (1.0 + libm::erf(x / sigma * std::f64::consts::FRAC_1_SQRT_2));
            let law = below(y + 0.5) - below(y - 0.5);
            let top = below(0.5) - below(-0.5);
            assert!((height(&strands, y, sigma) - law).abs() < 1.5e-3 * top, "{y} at {sigma}: {law}");
        }
    }
}
