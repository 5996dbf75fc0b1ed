use super::*;
use optical_bench::settings::{Order, SpecklePattern};

const ROWS: usize = 120;
const COLUMNS: usize = 400;

fn scripts(order: Order, law: SpeckleLaw, blur_radius_px: f64) -> ThesisScripts {
    let pattern = SpecklePattern { size_px: 1000, mask_px: 500, factor: 5, law };
    let settings = Postprocess { order, blur_radius_px, intensity_scale: 1.0, pattern };
    ThesisScripts::new(settings, &Bench::default(), Readout::PLAIN, Stream::root(4))
}

/// A line of 100 DN, 12 rows wide.
fn line() -> FrameLight {
    FrameLight { columns: COLUMNS, first_row: 50, numbers: vec![100.0; 12 * COLUMNS] }
}

/// Mean and standard deviation.
fn moments(values: impl Iterator<Item = f32> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let mean = values.clone().map(f64::from).sum::<f64>() / n;
    (mean, (values.map(|v| (f64::from(v) - mean).powi(2)).sum::<f64>() / n).sqrt())
}

/// Patterns have their law's contrast, 1 and sqrt(4 / pi - 1), and 0.374 and 0.191 behind 5 x 5 of their pixels.
#[test]
fn patterns_have_the_contrast_of_their_law() {
    for (law, fine, coarse) in [(SpeckleLaw::Exponential, 1.0, 0.374), (SpeckleLaw::Rayleigh, 0.5227, 0.191)] {
        let scripts = scripts(Order::NoiseSpeckle, law, 0.5);
        let (mean, spread) = moments(scripts.pattern(0).into_iter());
        // 196 000 speckles: under 1 %.
        assert!((mean - 1.0).abs() < 1e-4 && (spread / fine - 1.0).abs() < 0.01, "{law:?}: {mean}, {spread}");
        let even = FrameLight { columns: 200, first_row: 0, numbers: vec![1.0; 200 * 200] };
        let (mean, spread) = moments(scripts.speckled(even, 0).numbers.into_iter());
        assert!((mean - 1.0).abs() < 0.005 && (spread / coarse - 1.0).abs() < 0.02, "{law:?}: {mean}, {spread}");
    }
}

/// Patterns of profiles are alike as discs overlap: g^2 with g = 2 (acos s - s sqrt(1 - s^2)) / pi, s = sin(turn / 2).
#[test]
fn patterns_change_as_their_discs_move() {
    let mut scripts = scripts(Order::NoiseSpeckle, SpeckleLaw::Exponential, 0.5);
    // 0.126 mm of a pupil of 8.9 mm, times pi.
    assert!((scripts.angle_step / std::f64::consts::PI - 0.0141).abs() < 2e-4, "{}", scripts.angle_step);
    scripts.angle_step = 0.2;
    let first = scripts.pattern(0);
    for profile in [1, 3, 6] {
        let other = scripts.pattern(profile);
        let product = first.iter().zip(&other).map(|(a, b)| f64::from((a - 1.0) * (b - 1.0))).sum::<f64>();
        let found = product / first.len() as f64;
        let s = libm::sin(0.1 * profile as f64);
        let g = (libm::acos(s) - s * (1.0 - s * s).sqrt()) * 2.0 / std::f64::consts::PI;
        assert!((found - g * g).abs() < 0.012, "{profile}: {found} for {}", g * g);
    }
}

/// The blur keeps light and adds its variance in rows and columns, and nothing where it is next to nothing.
#[test]
fn blur_keeps_light_and_has_its_variance() {
    for sigma in [0.05, 0.5, 1.0, 3.0] {
        let mut point = FrameLight { columns: 41, first_row: 20, numbers: vec![0.0; 41] };
        point.numbers[20] = 10.0;
        let seen = blurred(&point, sigma, 41);
        let light: f64 = seen.numbers.iter().map(|&v| f64::from(v)).sum();
        assert!((light - 10.0).abs() < 1e-4, "{sigma}: {light}");
        for along in [true, false] {
            let place = |i: usize| if along { i % 41 } else { seen.first_row + i / 41 };
            let off = |i: usize| (place(i) as f64 - 20.0).powi(2);
            let variance = seen.numbers.iter().enumerate().map(|(i, &v)| off(i) * f64::from(v)).sum::<f64>() / light;
            // Rows sample the Gaussian: less than that at half a row; what lies beyond 4 sigma is left out.
            let sampled: [f64; 2] = (-30..=30).fold([0.0; 2], |sum, i: i32| {
                let w = libm::exp(-0.5 * (f64::from(i) / sigma).powi(2));
                [sum[0] + w, sum[1] + w * f64::from(i).powi(2)]
            });
            let expected = sampled[1] / sampled[0];
            assert!((variance - expected).abs() < 0.002 * expected + 1e-6, "{sigma}: {variance} for {expected}");
        }
    }
    // Columns at the edge see themselves beyond it.
    let edge = blurred(&line(), 2.0, ROWS);
    let middle = (56 - edge.first_row) * COLUMNS;
    assert!((edge.numbers[middle] - edge.numbers[middle + COLUMNS / 2]).abs() < 1e-3);
}

/// Speckle in an even field of 100 DN by order: its contrast where speckle comes last of the two, softened where blur
/// comes after it, none without it; light is kept by all.
#[test]
fn each_order_differs_as_it_must() {
    // The field is one whole pattern, of 200 pixels a side; further on it would come again and tell nothing new.
    const SIDE: usize = 200;
    let field = || FrameLight { columns: SIDE, first_row: 30, numbers: vec![100.0; SIDE * SIDE] };
    let frame = |order: Order| scripts(order, SpeckleLaw::Rayleigh, 1.0).frame(field(), SIDE + 60, 0);
    let seen = |order: Order| {
        let (mean, spread) = moments(frame(order)[40 * SIDE..220 * SIDE].iter().map(|&dn| f32::from(dn)));
        (mean - 11.6, (spread * spread - 1.19).max(0.0).sqrt())
    };
    let [last, before, none] = [Order::BlurSpeckleNoise, Order::SpeckleBlurNoise, Order::BlurNoise].map(seen);
    println!("blur speckle noise {last:?}, speckle blur noise {before:?}, blur noise {none:?}");
    // 36 000 pixels, of which neighbours are alike by 0.11: a spread is known to 0.4 %, four of which.
    assert!((last.1 / 19.1 - 1.0).abs() < 0.016, "{last:?}");
    // A Gaussian of deviation s keeps sum(likeness(d) exp(-d^2 / 4 s^2)) / (4 pi s^2) of a variance: 0.108 with
    // neighbours alike by 0.11 and corners by 0.01. It leaves a pixel of 4 pi s^2 / 2 on its own, and the spread known
    // to 0.9 %; the likeness of neighbours to 0.02 is another 3 %.
    assert!((before.1 / last.1 / 0.329 - 1.0).abs() < 0.05, "{before:?}");
    assert!(none.1 < 0.1, "{none:?}");
    // The mean of a whole pattern is 1. Ten rows of either side are missing here: of light they hold 10 %, known to
    // 19.1 sqrt(1.5 / 4000) = 0.37 DN, so what is left is known to 0.04 DN; noise to 0.006; four of both.
    for (light, _) in [last, before, none] {
        assert!((light - 100.0).abs() < 0.17, "{light}");
    }
    let all: Vec<_> = Order::ALL[1..].iter().map(|&order| frame(order)).collect();
    assert!((0..4).all(|i| (0..i).all(|j| all[i] != all[j])), "orders are alike");
}

/// Noise that comes last is N(11.6, 1.09) in the dark, rounding included; noise before speckle has the pattern on it.
#[test]
fn noise_is_the_law_of_the_thesis() {
    for order in &Order::ALL[1..] {
        let scripts = scripts(*order, SpeckleLaw::Rayleigh, 0.5);
        let frames: Vec<u16> = (0..8).flat_map(|profile| scripts.frame(line(), ROWS, profile)).collect();
        let dark = || frames.iter().enumerate().filter(|(i, _)| i / COLUMNS % ROWS < 40).map(|(_, &dn)| f32::from(dn));
        let (mean, spread) = moments(dark());
        if *order == Order::NoiseSpeckle {
            // Products of independent numbers: variances of both, and their product; patterns of profiles are alike.
            let expected = (1.19f64 + (11.6 * 0.191f64).powi(2)).sqrt();
            assert!((mean - 11.6).abs() < 0.15 && (spread / expected - 1.0).abs() < 0.05, "{mean} {spread} {expected}");
        } else {
            // 128 000 pixels: errors 0.003 and 0.0022, four of which.
            assert!((mean - 11.6).abs() < 0.0122 && (spread - 1.09).abs() < 0.0087, "{order:?}: {mean} {spread}");
        }
    }
}
