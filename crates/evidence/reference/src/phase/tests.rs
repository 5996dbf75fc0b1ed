//! Samples of each law against its density, mean, symmetry and limits; statistics with one error in a thousand a test.

use super::*;
use base::Stream;
use transport::stack::WOOD_DISPERSION;

const DRAWS: usize = 200_000;
const BINS: usize = 32;
/// Mean cosines of Henyey and Greenstein's law.
const HG: [f64; 5] = [-0.5, 1e-6, 0.3, 0.75, 0.95];
/// Turns about a cylinder.
const TURNS: [CylinderPhase; 5] = [
    CylinderPhase::Cauchy(-0.4),
    CylinderPhase::Cauchy(0.0),
    CylinderPhase::Cauchy(0.3),
    CylinderPhase::Cauchy(0.8),
    CylinderPhase::Mirror,
];
const DISPERSIONS: [f64; 3] = [0.03, WOOD_DISPERSION, 0.5];
/// Quantile of chi-square with 31 degrees of freedom at 1 - 1e-3 / 20: each test asks at most 20 times.
const CHI_SQUARE_31: f64 = 71.4;
/// Two-sided quantile of the normal law for 20 questions at 1e-3 together.
const Z: f64 = 4.06;

fn rng(name: &str) -> impl Rng + use<> {
    Stream::root(0).child("phase").child(name).rng()
}

/// Mean and its standard error.
fn mean(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (n, sum, squares) = values.fold((0.0, 0.0, 0.0), |(n, s, q), v| (n + 1.0, s + v, q + v * v));
    let mean: f64 = sum / n;
    (mean, ((squares / n - mean * mean) / n).sqrt())
}

/// Integrals of `density` from `low` to the ends of many small cells.
fn cumulative(low: f64, high: f64, density: impl Fn(f64) -> f64) -> Vec<f64> {
    const CELLS: usize = 200_000;
    let step = (high - low) / CELLS as f64;
    let add = |sum: &mut f64, i: usize| {
        *sum += step * density(low + (i as f64 + 0.5) * step);
        Some(*sum)
    };
    (0..CELLS).scan(0.0, add).collect()
}

/// A density integrates to 1, and samples of the same variable follow it: chi-square over bins of about equal chance.
fn follows(what: &str, (low, high): (f64, f64), density: impl Fn(f64) -> f64, samples: impl Iterator<Item = f64>) {
    let shares = cumulative(low, high, density);
    let all = shares[shares.len() - 1];
    assert!((all - 1.0).abs() < 1e-6, "{what}: the density integrates to {all}");
    let ends: Vec<usize> =
        (1..BINS).map(|bin| shares.partition_point(|&share| share < bin as f64 / BINS as f64)).collect();
    let (mut counts, mut n) = ([0f64; BINS], 0.0);
    for sample in samples {
        let cell = ((sample - low) / (high - low) * shares.len() as f64) as usize;
        counts[ends.partition_point(|&end| end < cell)] += 1.0;
        n += 1.0;
    }
    let upto = |bin: usize| if bin == BINS { all } else { shares[ends[bin - 1]] };
    let term = |(bin, count): (usize, &f64)| {
        let expected = n * (upto(bin + 1) - if bin == 0 { 0.0 } else { upto(bin) });
        (count - expected).powi(2) / expected
    };
    let chi_square: f64 = counts.iter().enumerate().map(term).sum();
    assert!(chi_square < CHI_SQUARE_31, "{what}: chi-square {chi_square}");
}

/// Directions in all corners, the poles of [`frame`] among them.
fn corners() -> [DVec3; 4] {
    [DVec3::NEG_Z, DVec3::Z, DVec3::new(0.6, -0.48, 0.64), DVec3::new(-0.36, 0.48, -0.8)]
}

/// Angle of `v` about `w`, in [-pi, pi].
fn azimuth(v: DVec3, w: DVec3) -> f64 {
    let (x, y) = frame(w);
    libm::atan2(v.dot(y), v.dot(x))
}

#[test]
fn henyey_greenstein_follows_its_density() {
    for (g, w) in HG.into_iter().zip(corners().into_iter().cycle()) {
        let mut rng = rng(&format!("HG {g}"));
        let ways: Vec<DVec3> = (0..DRAWS).map(|_| henyey_greenstein(w, g, &mut rng)).collect();
        let cosines = || ways.iter().map(|v| v.dot(w));
        let density = |t: f64| TAU * libm::sin(t) * henyey_greenstein_density(libm::cos(t), g);
        follows(&format!("g = {g}"), (0.0, PI), density, cosines().map(|cos| libm::acos(cos.clamp(-1.0, 1.0))));
        let even = |_: f64| 1.0 / TAU;
        follows(&format!("about, g = {g}"), (-PI, PI), even, ways.iter().map(|&v| azimuth(v, w)));
        let (mean, error) = mean(cosines());
        assert!((mean - g).abs() < Z * error, "mean cosine of g = {g}: {mean} +- {error}");
        assert!(ways.iter().all(|v| (v.length() - 1.0).abs() < 1e-12), "unit vectors");
    }
}

#[test]
fn turns_follow_their_density() {
    for turn in TURNS {
        let mut rng = rng(&format!("{turn:?}"));
        let turns: Vec<(f64, f64)> = (0..DRAWS).map(|_| sample_turn(turn, &mut rng)).collect();
        let angles = turns.iter().map(|&(cos, sin)| libm::atan2(sin, cos));
        follows(&format!("{turn:?}"), (-PI, PI), |angle| turn_density(turn, libm::cos(angle)), angles);
        let (mean, error) = mean(turns.iter().map(|turn| turn.0));
        assert!((mean - turn.mean_cosine()).abs() < Z * error, "mean cosine of {turn:?}: {mean} +- {error}");
    }
}

/// Tilts of Rayleigh's law have the mean square 2 s^2.
#[test]
fn dispersion_follows_its_density() {
    for (s, axis) in DISPERSIONS.into_iter().zip(corners()) {
        let mut rng = rng(&format!("dispersion {s}"));
        let axes: Vec<DVec3> = (0..DRAWS).map(|_| dispersed(axis, frame(axis), s, &mut rng)).collect();
        // Sine and cosine: a cosine alone says little of small tilts.
        let tilts = || axes.iter().map(|f| libm::atan2(f.cross(axis).length(), f.dot(axis)));
        let density = |t: f64| TAU * libm::sin(t) * dispersion_density(t, s);
        follows(&format!("s = {s}"), (0.0, PI), density, tilts());
        follows(&format!("about, s = {s}"), (-PI, PI), |_| 1.0 / TAU, axes.iter().map(|&f| azimuth(f, axis)));
        let (mean, error) = mean(tilts().map(|t| t * t));
        assert!((mean - 2.0 * s * s).abs() < Z * error, "mean square of s = {s}: {mean} +- {error}");
    }
    assert_eq!(dispersed(DVec3::X, frame(DVec3::X), 0.0, &mut rng("none")), DVec3::X);
}

/// Without a mean cosine every direction and every turn is as likely.
#[test]
fn laws_without_a_mean_cosine_are_even() {
    for cos in [-1.0, -0.3, 0.4, 1.0] {
        assert!((henyey_greenstein_density(cos, 0.0) * 4.0 * PI - 1.0).abs() < 1e-15);
        assert!((turn_density(CylinderPhase::Cauchy(0.0), cos) * TAU - 1.0).abs() < 1e-15);
    }
    for g in [0.0, 1e-6] {
        let mut rng = rng(&format!("even {g}"));
        let up = (0..DRAWS).map(|_| henyey_greenstein(DVec3::new(0.48, 0.6, 0.64), g, &mut rng).z);
        follows(&format!("height, g = {g}"), (-1.0, 1.0), |_| 0.5, up);
    }
}

/// A turn about a fibre keeps the angle with it and turns what is across it by the drawn angle.
#[test]
fn light_stays_on_its_cone() {
    let mut rng = rng("cone");
    for i in 0..10_000 {
        let (w, axis) = (isotropic(&mut rng), isotropic(&mut rng));
        let (cos, sin) = sample_turn(TURNS[i % TURNS.len()], &mut rng);
        let v = turned(w, axis, (cos, sin));
        let along = w.dot(axis);
        assert!((v.dot(axis) - along).abs() < 1e-12 && (v.length() - 1.0).abs() < 1e-12, "{w} about {axis} to {v}");
        let across = 1.0 - along * along;
        let (foot_w, foot_v) = (w - axis * along, v - axis * along);
        assert!((foot_w.dot(foot_v) - across * cos).abs() < 1e-12, "turned by {cos}");
        assert!((foot_w.cross(foot_v).dot(axis) - across * sin).abs() < 1e-12, "turned by {sin}");
    }
}

/// Light in direction `w` after a cylinder of width sin(w, f'), or none.
fn by_cylinder(w: DVec3, axis: DVec3, turn: CylinderPhase, s: f64, rng: &mut impl Rng) -> Option<DVec3> {
    match fibre_collision(w, 0.0, 1.0, rng, |rng| dispersed(axis, frame(axis), s, rng)) {
        FibreCollision::Cylinder(fibre) => Some(turned(w, fibre, sample_turn(turn, rng))),
        _ => None,
    }
}

/// Detailed balance: of light in all directions as much goes from any part of the sphere to any other as back (Bowker's
/// test of symmetry, 12 parts, 66 pairs; quantile at 1 - 1e-3 / 20).
#[test]
fn laws_are_reciprocal() {
    const PARTS: usize = 12;
    let part = |w: DVec3| {
        let ring = ((w.z + 1.0) * 1.5).min(2.0) as usize;
        4 * ring + 2 * usize::from(w.x > 0.0) + usize::from(w.y > 0.0)
    };
    let axis = DVec3::new(0.36, 0.48, 0.8);
    let excess = |name: &str, scatter: &dyn Fn(DVec3, &mut dyn Rng) -> Option<DVec3>| {
        let (mut rng, mut counts) = (rng(name), [[0f64; PARTS]; PARTS]);
        for _ in 0..5 * DRAWS {
            let w = isotropic(&mut rng);
            if let Some(v) = scatter(w, &mut rng) {
                counts[part(w)][part(v)] += 1.0;
            }
        }
        let pairs = (0..PARTS).flat_map(|i| (0..i).map(move |j| (i, j)));
        let term = |(i, j): (usize, usize)| {
            let (there, back): (f64, f64) = (counts[i][j], counts[j][i]);
            (there - back).powi(2) / (there + back).max(1.0)
        };
        pairs.map(term).sum::<f64>()
    };
    let test = |name: &str, scatter: &dyn Fn(DVec3, &mut dyn Rng) -> Option<DVec3>| {
        let excess = excess(name, scatter);
        assert!(excess < 120.4, "{name}: {excess}");
    };
    test("HG", &|w, mut rng| Some(henyey_greenstein(w, 0.6, &mut rng)));
    for (name, turn) in [("Cauchy", CylinderPhase::Cauchy(0.4)), ("mirror", CylinderPhase::Mirror)] {
        test(name, &|w, mut rng| by_cylinder(w, axis, turn, 0.2, &mut rng));
    }
    // The test can tell a law that prefers a direction.
    let uneven =
        excess("uneven", &|w, mut rng| Some((henyey_greenstein(w, 0.6, &mut rng) + 0.1 * DVec3::Z).normalize()));
    assert!(uneven > 120.4, "towards z: {uneven}");
}

/// The density that a lens is served with is that of scattering, counted in small cones about where it looks.
#[test]
fn density_towards_the_lens_is_that_of_scattering() {
    const CONE: f64 = 0.06;
    let axis = DVec3::new(0.0, 0.6, 0.8);
    let (x, y) = frame(axis);
    // On the sphere, by the angle with the axis and about it.
    let place = |angle: f64, about: f64| {
        let ((sin, cos), (up, along)) = (libm::sincos(angle), libm::sincos(about));
        axis * cos + x * (sin * along) + y * (sin * up)
    };
    let low = libm::cos(CONE);
    for (turn, s) in [
        (CylinderPhase::Cauchy(0.0), WOOD_DISPERSION),
        (CylinderPhase::Cauchy(0.5), 0.3),
        (CylinderPhase::Mirror, WOOD_DISPERSION),
    ] {
        let mut rng = rng(&format!("towards {turn:?}"));
        let w = place(0.9, 0.3);
        let scattered: Vec<_> = (0..10 * DRAWS).map(|_| by_cylinder(w, axis, turn, s, &mut rng)).collect();
        for v in [place(0.9, 2.0), place(0.85, 3.4), place(1.0, -1.0), place(0.9, 0.6), place(0.75, -2.2)] {
            let hits = |v0: &Option<DVec3>| f64::from(u8::from(v0.is_some_and(|to| to.dot(v) > low)));
            let (counted, spread) = mean(scattered.iter().map(hits));
            let (across, beside) = frame(v);
            // Even over the cone.
            let towards = |_: usize| {
                let (a, b, r2) = disc(&mut rng);
                let cos = 1.0 - (1.0 - low) * r2;
                let scale = ((1.0 - cos * cos) / r2).sqrt();
                let to = v * cos + across * (a * scale) + beside * (b * scale);
                TAU * (1.0 - low) * cylinder_towards(w, to, axis, turn, s, &mut rng)
            };
            let (expected, error) = mean((0..DRAWS).map(towards));
            let z = (counted - expected) / (spread * spread + error * error).sqrt();
            assert!(z.abs() < Z, "{turn:?} {s}, towards {v}: {counted} +- {spread}, density {expected} +- {error}");
            assert!(spread < 0.1 * counted, "enough light arrives: {counted} +- {spread}");
        }
    }
}
