//! Patterns against closed forms: law, correlation, stack, pixels.

use super::contrast;
use super::pupil::{Pupil, TILE};
use super::stack::PatternStack;
use base::Stream;
use optical_bench::settings::SpeckleLaw;

const PHYSICAL: SpeckleLaw = SpeckleLaw::Exponential;

/// Intensity of a square pattern of mean 1 whose phases have moved by `shift`, `[side, side]`.
fn intensity(side: usize, grain: f64, shift: usize, stream: Stream) -> Vec<f64> {
    let light = Pupil::new([side; 2], grain, stream).intensity(shift);
    let mean = light.iter().map(|v| f64::from(*v)).sum::<f64>() / light.len() as f64;
    light.iter().map(|v| f64::from(*v) / mean).collect()
}

fn covariance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - 1.0) * (b - 1.0)).sum::<f64>() / a.len() as f64
}

/// Distance of Kolmogorov and Smirnov, and what it exceeds once in a thousand times if the law is right.
fn distance(mut sample: Vec<f64>, law: impl Fn(f64) -> f64) -> (f64, f64) {
    sample.sort_by(f64::total_cmp);
    let n = sample.len() as f64;
    let apart = |(i, x): (usize, &f64)| (law(*x) - i as f64 / n).max((i as f64 + 1.0) / n - law(*x));
    (sample.iter().enumerate().map(apart).fold(0.0, f64::max), 1.95 / n.sqrt())
}

/// g^2 of two pupils s diameters apart.
fn alike(s: f64) -> f64 {
    let s = s.min(1.0);
    (2.0 / std::f64::consts::PI * (libm::acos(s) - s * (1.0 - s * s).sqrt())).powi(2)
}

/// Q = 1000, D = 500: exponential at points four grains apart (alpha = 0.001), contrast 1, and the Airy correlation.
#[test]
fn light_in_a_point_is_exponential() {
    const SIDE: usize = 1000;
    let light = intensity(SIDE, 2.0, 0, Stream::root(1));
    let points = |i: usize| (i / SIDE).is_multiple_of(8) && i.is_multiple_of(8);
    let sample = (0..light.len()).filter(|i| points(*i)).map(|i| light[i]).collect();
    let (found, bar) = distance(sample, |x| 1.0 - libm::exp(-x));
    assert!(found < bar, "distance {found} of {bar}");
    // A grain covers 4 L^2 / pi samples; the variance of an exponential's square is 8, of a product 1 and a bit more.
    let cells = light.len() as f64 / (16.0 / std::f64::consts::PI);
    let variance = covariance(&light, &light);
    assert!((variance - 1.0).abs() < 4.0 * (8.0 / cells).sqrt(), "variance {variance}");
    for (lag, known) in [(1, 0.521), (2, 0.033), (3, 0.014)] {
        for step in [lag, lag * SIDE] {
            let moved: Vec<f64> = (0..light.len()).map(|i| light[(i + step) % light.len()]).collect();
            let found = covariance(&light, &moved);
            assert!((found - known).abs() < 4.0 * (2.0 / cells).sqrt(), "lag {step}: {found} for {known}");
        }
    }
}

/// Bergmann's M = 16: patterns u steps apart on his circle are a chord apart; and what counts is the distance alone.
#[test]
fn patterns_of_the_stack_boil_as_pupils_overlap() {
    const SIDE: usize = 1000;
    let pattern = |shift: usize| intensity(SIDE, 2.0, shift, Stream::root(2));
    let first = pattern(0);
    let cells = (SIDE * SIDE) as f64 / (16.0 / std::f64::consts::PI);
    let bar = 4.0 * (2.0 / cells).sqrt();
    for (u, known) in [(1.0, 0.766), (2.0, 0.567), (4.0, 0.276), (8.0, 0.033), (12.0, 0.001)] {
        let chord = libm::sin(std::f64::consts::PI * u / 32.0);
        let found = covariance(&first, &pattern((500.0 * chord).round() as usize));
        assert!((found - known).abs() < bar && (alike(chord) - known).abs() < 1e-3, "u = {u}: {found} for {known}");
    }
    let (near, far) = (pattern(400), pattern(525));
    assert!((covariance(&near, &far) - alike(0.25)).abs() < bar, "{}", covariance(&near, &far));
    // After two diameters the phases come again.
    assert!((covariance(&first, &pattern(1000)) - 1.0).abs() < bar);
}

/// The same for light that pixels have gathered, grains of `grain` pixels: the overlap O of both pupils sends out
/// sum over pairs of its cells of sinc^2 of their distance in cycles a pixel. Points have g^2, wide pixels g.
fn alike_in_pixels(s: f64, grain: f64) -> f64 {
    const CELLS: usize = 24;
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { (libm::sin(x) / x).powi(2) };
    let share = |d: usize| sinc(std::f64::consts::PI * d as f64 / (CELLS as f64 * grain));
    let shares: Vec<f64> = (0..CELLS).map(share).collect();
    let sum = |s: f64| {
        let inside = |x: f64, y: f64| x * x + y * y <= 0.25 && x * x + (y - s) * (y - s) <= 0.25;
        let at = |i: usize| (i as f64 + 0.5) / CELLS as f64 - 0.5;
        let cells: Vec<(usize, usize)> =
            (0..CELLS * CELLS).map(|i| (i % CELLS, i / CELLS)).filter(|(x, y)| inside(at(*x), at(*y))).collect();
        let pair = |a: &(usize, usize), b: &(usize, usize)| shares[a.0.abs_diff(b.0)] * shares[a.1.abs_diff(b.1)];
        cells.iter().map(|a| cells.iter().map(|b| pair(a, b)).sum::<f64>()).sum::<f64>()
    };
    sum(s) / sum(0.0)
}

/// The patterns of a stack themselves: mean 1, neighbours 1/16 of a pupil apart.
#[test]
fn neighbours_in_the_stack_are_a_sixteenth_apart() {
    let stack = PatternStack::new(0.5, PHYSICAL, [1, 4], Stream::root(3));
    let whole = |pattern: i64, which: usize| -> Vec<f64> {
        let rows = (0..stack.rows()).step_by(stack.fine());
        rows.flat_map(|row| stack.row(pattern, row as i64)[which].map(|v| 1.0 + f64::from(v))).collect()
    };
    let first = whole(0, 0);
    let variance = covariance(&first, &first);
    assert!((first.iter().sum::<f64>() / first.len() as f64 - 1.0).abs() < 2e-3);
    for apart in [1, 2, 4, 31] {
        let left = covariance(&first, &whole(apart, 0)) / variance;
        let known = alike_in_pixels(apart.min(32 - apart) as f64 / 16.0, 0.5);
        assert!((left - known).abs() < 0.03, "{apart} patterns: {left} for {known}");
    }
    // Light from below is a mean of four, unlike the light from the surface.
    let below = whole(0, 1);
    let share = covariance(&below, &below) / variance;
    assert!((share - 0.25).abs() < 0.02, "{share}");
    assert!(covariance(&first, &below).abs() / (variance * share.sqrt()) < 4.0 / (first.len() as f64).sqrt());
}

/// Eight pixels behind grains of 1.968 um: contrast as gathered, not scaled, within 2 % of Goodman's; so are neighbours
/// behind small and large pixels, which sums of six samples, or grains no smaller than a third of a pixel, get wrong.
#[test]
fn pixels_have_goodmans_contrast_and_neighbours() {
    let sizes = [1.2, 2.4, 3.45, 4.8, 5.5, 6.0, 9.0, 12.0];
    let known = [0.867, 0.631, 0.487, 0.376, 0.335, 0.3115, 0.218, 0.168];
    for (um, known) in sizes.into_iter().zip(known) {
        let grain = 1.968 / um;
        // Patterns a pupil apart have nothing in common; pixels of 1.2 um are alike, so that they take more of them.
        let streams = if um < 2.0 { 6 } else { 1 };
        let (mut squares, mut lag, mut n) = (0.0, 0.0, 0.0);
        for (stream, pattern) in (0..streams).flat_map(|stream| [(stream, 0), (stream, 16)]) {
            let stack = PatternStack::new(grain, PHYSICAL, [1, 1], Stream::root(10 + stream));
            assert!((stack.grain() / grain - 1.0).abs() < 1e-9, "grain {} for {grain}", stack.grain());
            for row in 0..stack.rows() as i64 {
                let line = stack.row(pattern, row)[0];
                let next = stack.row(pattern, row + stack.fine() as i64)[0];
                for c in 0..TILE {
                    let v = f64::from(line[c]);
                    squares += v * v;
                    lag += v * 0.5 * f64::from(line[(c + 1) % TILE] + next[c]);
                    n += 1.0;
                }
            }
        }
        let contrast = (squares / n).sqrt();
        assert!((contrast / known - 1.0).abs() < 0.02, "{um} um: contrast {contrast} for {known}");
        let (lag, theory) = (lag / squares, contrast::neighbours(grain));
        assert!((lag - theory).abs() < 0.012, "{um} um: neighbours {lag} for {theory}");
    }
}

/// The thesis' law, Q = 1000, D = 500: 0.523 in a point, and 0.191 after 5 x 5 samples; in pixels of a stack as
/// integrated.
#[test]
fn the_thesis_law_has_its_contrast() {
    const SIDE: usize = 1000;
    let light: Vec<f64> = intensity(SIDE, 2.0, 0, Stream::root(4)).iter().map(|v| v.sqrt()).collect();
    let mean = light.iter().sum::<f64>() / light.len() as f64;
    let contrast =
        |values: &[f64]| (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt() / mean;
    assert!((contrast(&light) - 0.5227).abs() < 0.003, "{}", contrast(&light));
    let bin = |i: usize| {
        let start = i / (SIDE / 5) * 5 * SIDE + i % (SIDE / 5) * 5;
        (0..25).map(|j| light[start + j / 5 * SIDE + j % 5]).sum::<f64>() / 25.0
    };
    let bins: Vec<f64> = (0..SIDE * SIDE / 25).map(bin).collect();
    assert!((contrast(&bins) - 0.191).abs() < 0.004, "{}", contrast(&bins));
    let stack = PatternStack::new(0.328, SpeckleLaw::Rayleigh, [1, 1], Stream::root(5));
    let squares: f64 = (0..stack.rows()).flat_map(|row| stack.row(0, row as i64)[0]).map(|v| f64::from(v * v)).sum();
    let (found, theory) =
        ((squares / (stack.rows() * TILE) as f64).sqrt(), contrast::pixel_contrast(0.328, SpeckleLaw::Rayleigh, 0.0));
    assert!((found / theory - 1.0).abs() < 0.025, "{found} for {theory}");
}

/// Depolarised light is the mean of two patterns: p(I) = 4 I exp(-2 I), C = 0.707 (alpha = 0.001).
#[test]
fn depolarised_light_is_a_mean_of_two() {
    let mut sample = Vec::new();
    for seed in 0..12 {
        let stack = PatternStack::new(4.0, PHYSICAL, [2, 1], Stream::root(20 + seed));
        for (pattern, row) in [0, 16].into_iter().flat_map(|pattern| (0..8).map(move |row| (pattern, row * 16))) {
            let line = stack.row(pattern, (row * stack.fine()) as i64)[0];
            sample.extend(line.iter().step_by(16).map(|v| 1.0 + f64::from(*v)));
        }
    }
    let n = sample.len() as f64;
    let contrast = (sample.iter().map(|v| (v - 1.0).powi(2)).sum::<f64>() / n).sqrt();
    // Standard error of a gamma law's deviation: 0.707 sqrt((kurtosis 6 - 1) / 4 n); pixels of a quarter grain take 1.5
    // %.
    assert!((contrast - 0.7).abs() < 4.0 * 0.707 * (5.0 / (4.0 * n)).sqrt(), "contrast {contrast}");
    let (found, bar) = distance(sample, |x| 1.0 - (1.0 + 2.0 * x) * libm::exp(-2.0 * x));
    assert!(found < bar, "distance {found} of {bar}");
}
