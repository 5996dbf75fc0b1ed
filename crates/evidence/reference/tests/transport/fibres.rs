//! The diffusion tensor of a bundle of fibres against a walk without boundaries.

use base::Stream;
use glam::DVec3;
use rand::Rng;
use rayon::prelude::*;
use reference::path::tracker::Photon;
use reference::phase::{fibre_collision, isotropic, uniform};
use transport::answer::Estimate;
use transport::kernel::diffusion;
use transport::stack::CylinderPhase;

/// Windows of a walk, and their length in mean free paths of the background, after which light forgets its direction.
const WINDOWS: usize = 16;
const WINDOW: f64 = 7.0;
const WALKS: u64 = 160_000;

/// Coefficients of diffusion along the fibre (z) and across it, of one walk that begins like it goes on [mm].
///
/// Light runs straight before it turns, so <x^2> = 2 D (path - lag): the same lag after one window as after two, but
/// for exp(-7). The difference of both mean squares knows no lag, and every window of a walk is as good as the first.
fn walk(sigma_i: f64, k: f64, rng: &mut impl Rng) -> [f64; 2] {
    let (direction, length) = (isotropic(rng), WINDOW / sigma_i);
    let mut photon =
        Photon { position: DVec3::ZERO, direction, weight: 1.0, layer: 0, path: 0.0, turned: 0, guided: 0 };
    let drawn = |rng: &mut _| -libm::log(uniform(rng)) / (sigma_i + k);
    let mut free = drawn(rng);
    let steps: [DVec3; WINDOWS] = std::array::from_fn(|_| {
        let (start, mut left) = (photon.position, length);
        while free < left {
            photon.position += photon.direction * free;
            left -= free;
            let collision = fibre_collision(photon.direction, sigma_i, k, rng, |_| DVec3::Z);
            photon.scatter_by(collision, CylinderPhase::Cauchy(0.0), rng);
            free = drawn(rng);
        }
        photon.position += photon.direction * left;
        free -= left;
        photon.position - start
    });
    let square = |v: DVec3| DVec3::new(0.5 * (v.x * v.x + v.y * v.y), 0.0, v.z * v.z);
    let one = steps.iter().map(|&step| square(step)).sum::<DVec3>() / WINDOWS as f64;
    let two = steps.windows(2).map(|pair| square(pair[0] + pair[1])).sum::<DVec3>() / (WINDOWS - 1) as f64;
    let d = (two - one) / (2.0 * length);
    [d.z, d.x]
}

/// D_par = 1 / (3 sigma_i) and D_perp = 1/4 int sin^3 / (sigma_i + k sin) hold within 0.5 %, three standard errors.
#[test]
#[ignore = "long"]
fn diffusion_tensor_is_that_of_walks() {
    const BATCHES: u64 = 128;
    for (sigma_i, k) in [(1.0, 5.0), (2.0, 10.0), (2.5, 14.0), (4.0, 10.0)] {
        let key = Stream::root(0).child("transport_fibres").child(&format!("{sigma_i} {k}"));
        let batch = |batch: u64| {
            let (mut rng, each) = (key.index(batch).rng(), WALKS / BATCHES);
            let sum = (0..each).map(|_| walk(sigma_i, k, &mut rng)).fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
            sum.map(|sum| sum / each as f64)
        };
        let batches: Vec<[f64; 2]> = (0..BATCHES).into_par_iter().map(batch).collect();
        let (along, across) = diffusion(sigma_i, k);
        for (axis, (name, truth)) in [("along", along), ("across", across)].into_iter().enumerate() {
            let got = Estimate::of(batches.iter().map(|batch| batch[axis]));
            let (off, error) = (got.value / truth - 1.0, got.error / truth);
            println!("({sigma_i}, {k}) {name}: {:.5}, {:+.3} % +- {:.3} %", got.value, 100.0 * off, 100.0 * error);
            assert!(error < 0.0017, "({sigma_i}, {k}) {name}: relative error {error}");
            assert!(off.abs() < 0.005, "({sigma_i}, {k}) {name}: {got:?} against {truth}");
        }
    }
}
