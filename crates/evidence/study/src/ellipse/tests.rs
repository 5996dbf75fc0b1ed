//! Synthetic ellipses: exact ones, and counts of points that are drawn.

use base::{Stream, normal};
use glam::{DMat2, DVec2};

use super::*;

const CELLS: usize = 80;
const CELL_MM: f64 = 0.05;

/// Long axis at `angle` [deg] from +y towards +x; columns are half axes `aspect` and 1 times `scale`.
fn frame(aspect: f64, angle: f64, scale: f64) -> DMat2 {
    let (x, y) = libm::sincos(angle.to_radians());
    DMat2::from_cols(aspect * scale * DVec2::new(x, y), scale * DVec2::new(-y, x))
}

/// Light at each cell's middle.
fn light(of: impl Fn(DVec2) -> f64) -> Vec<f64> {
    let side = 2 * CELLS + 1;
    let at = |k: usize| (k as f64 - CELLS as f64) * CELL_MM;
    (0..side * side).map(|i| of(DVec2::new(at(i % side), at(i / side)))).collect()
}

fn map(light: &[f64]) -> LightMap<'_> {
    LightMap { light, cells: CELLS, cell_mm: CELL_MM }
}

/// Unit vector across a fibre of this azimuth [deg].
fn across(angle: f64) -> DVec2 {
    let (x, y) = libm::sincos(angle.to_radians());
    DVec2::new(-y, x)
}

/// Difference of two axes, in (-90, 90] [deg].
fn apart(a: f64, b: f64) -> f64 {
    (a - b + 90.0).rem_euclid(180.0) - 90.0
}

/// Exact light: aspect, angle, size and centre come out, for any law of falling off.
#[test]
fn exact_ellipses_come_out() {
    let laws: [fn(f64) -> f64; 3] = [|r| libm::exp(-3.0 * r), |r| libm::exp(-0.5 * r * r), |r| 1.0 / (1.0 + r * r * r)];
    for law in laws {
        for (aspect, angle) in [(1.0, 0.0), (1.3, 20.0), (2.17, 45.0), (2.3, 90.0), (1.8, -67.0), (2.0, 0.0)] {
            let centre = DVec2::new(0.07, -0.04);
            let inverse = frame(aspect, angle, 0.8).inverse();
            let light = light(|place| law((inverse * (place - centre)).length()));
            let got = ellipse(map(&light), 1.1 * across(angle)).expect("it is an ellipse");
            assert!((got.aspect.value / aspect - 1.0).abs() < 2e-3, "aspect {} against {aspect}", got.aspect.value);
            assert!((got.reach(across(angle)) - 1.1).abs() < 1e-9, "{}", got.reach(across(angle)));
            assert!((got.centre - centre).length() < 1e-3, "{}", got.centre);
            if aspect > 1.0 {
                assert!(apart(got.angle.value, angle).abs() < 0.05, "{} against {angle}", got.angle.value);
            }
        }
    }
}

/// Counts: errors of aspect and angle are as large as the fit says, and have no sign.
#[test]
#[ignore = "long"]
fn noise_is_told_rightly() {
    const DRAWS: u32 = 60;
    const POINTS: usize = 20_000;
    let (aspect, angle) = (1.8, 30.0);
    let shape = frame(aspect, angle, 0.7);
    let (mut sums, mut squares) = ([0.0; 2], [0.0; 2]);
    for draw in 0..DRAWS {
        let mut rng = Stream::root(7).child("ellipse").index(u64::from(draw)).rng();
        let side = 2 * CELLS + 1;
        let mut counts = vec![0.0; side * side];
        for _ in 0..POINTS {
            let place = shape * DVec2::new(normal(&mut rng), normal(&mut rng)) / CELL_MM;
            let at = |v: f64| v.round() as i64 + CELLS as i64;
            let (x, y) = (at(place.x), at(place.y));
            if (0..side as i64).contains(&x) && (0..side as i64).contains(&y) {
                counts[y as usize * side + x as usize] += 1.0;
            }
        }
        let got = ellipse(map(&counts), 1.0 * across(angle)).expect("there is light enough");
        let z = [apart(got.angle.value, angle) / got.angle.error, (got.aspect.value - aspect) / got.aspect.error];
        for i in 0..2 {
            sums[i] += z[i];
            squares[i] += z[i] * z[i];
        }
    }
    let n = f64::from(DRAWS);
    for i in 0..2 {
        let (mean, spread) = (sums[i] / n, (squares[i] / n).sqrt());
        println!("z: mean {mean:.2}, root mean square {spread:.2}");
        // Both bounds are 3.3 standard errors of what 60 normal numbers have.
        assert!(mean.abs() < 3.3 / n.sqrt(), "bias {mean}");
        assert!((spread - 1.0).abs() < 3.3 / (2.0 * n).sqrt(), "errors are off by {spread}");
    }
}

/// What is no ellipse of the map gives none.
#[test]
fn what_cannot_be_measured_is_not() {
    let far = light(|place| libm::exp(-place.length()));
    assert!(ellipse(map(&far), DVec2::new(3.9, 0.0)).is_none(), "the belt leaves the map");
    let even = light(|_| 1.0);
    assert!(ellipse(map(&even), DVec2::new(1.0, 0.0)).is_none(), "even light has no contour");
    let dark = light(|_| 0.0);
    assert!(ellipse(map(&dark), DVec2::new(1.0, 0.0)).is_none(), "nor has darkness");
}
