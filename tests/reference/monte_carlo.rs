//! The reference (Monte Carlo of the transport equation) against exact and published values, in standard errors.

use std::f64::consts::{FRAC_PI_2, PI};

use base::Stream;
use glam::DVec3;
use reference::path::{Effort, solve};
use transport::answer::{Answer, Estimate, Question};
use transport::stack::{CylinderPhase, Layer, Scattering, Stack, Substrate, WOOD_DISPERSION};

fn isotropic(mu_s: f64, g: f64) -> Scattering {
    Scattering::Isotropic { mu_s, g }
}

/// Asks with a seed of the case's own name, so that cases are independent.
fn answer(case: &str, stack: &Stack, question: Question, photons: u64) -> Answer {
    let seed = Stream::root(0).child("transport_reference").child(case).key();
    let answer = solve(stack, &Question { cells: 0, ..question }, Effort { photons, seed });
    let absorbed: f64 = answer.absorbed.iter().map(|e| e.value).sum();
    let sum = answer.specular + answer.reflectance.value + answer.transmittance.value + absorbed;
    assert!((sum - 1.0).abs() < 1e-6, "{case}: energy {sum}");
    answer
}

fn ask(case: &str, stack: &Stack, photons: u64) -> Answer {
    answer(case, stack, Question::default(), photons)
}

/// Within three standard errors of `truth`, which is itself only known to `known`; relative error under 0.3 %.
fn agree(what: &str, got: Estimate, truth: f64, known: f64) {
    let (z, relative) = ((got.value - truth) / got.error.hypot(known), got.error / truth);
    println!("{what}: {:.5} +- {:.2} % against {truth:.5} (z = {z:.2})", got.value, 100.0 * relative);
    assert!(z.abs() < 3.0, "{what}: {} +- {} against {truth} +- {known}, z = {z}", got.value, got.error);
    assert!(relative < 0.003, "{what}: relative error {relative}");
}

/// Towards a lens at the cosine `mu` against the normal; below the slab for negative `mu`.
fn towards(mu: f64) -> Question {
    Question { view: DVec3::new(0.0, -(1.0 - mu * mu).sqrt(), mu), ..Question::default() }
}

/// Slab of van de Hulst 1980: tau = 2, albedo 0.9, g = 0.75, index-matched. Printed to five digits.
#[test]
fn slab_of_van_de_hulst() {
    let slab = Stack::slab(0.2, 1.0, 1.0, isotropic(9.0, 0.75));
    let a = ask("van de Hulst", &slab, 1_000_000);
    agree("R", a.reflectance, 0.09739, 3e-6);
    agree("T", a.transmittance, 0.66096, 3e-6);
    agree("T unscattered", a.unscattered, (-2f64).exp(), 0.0);
    // Radiance factors at cosines, and millions of photons: little light from few collisions goes to a grazing lens.
    // Grazing exit (0) has no estimate.
    let reflected = [(0.1, 0.13304, 9.5), (0.3, 0.13856, 3.2), (0.5, 0.11956, 2.4), (0.7, 0.09411, 2.2)];
    let steep = [(0.9, 0.07132, 1.6), (1.0, 0.06180, 1.6), (-1.0, 2.40270, 0.1), (-0.9, 0.72155, 0.3)];
    let transmitted = [(-0.1, 0.16486, 6.2), (-0.3, 0.22473, 2.0), (-0.5, 0.27785, 1.0), (-0.7, 0.36889, 0.7)];
    for (mu, truth, millions) in reflected.into_iter().chain(steep).chain(transmitted) {
        let case = format!("radiance factor at {mu}");
        let a = answer(&case, &slab, towards(mu), (millions * 1e6) as u64);
        agree(&case, a.towards_lens.unwrap(), truth, 3e-6);
    }
}

/// Isotropic half spaces below an index step, exact from Chandrasekhar's H-function and Fresnel's law. Giovanelli 1955
/// prints 0.2600 for the first, with the specular 0.0400.
#[test]
fn half_spaces_below_an_index_step() {
    for (n, albedo, truth, photons) in
        [(1.5, 0.9, 0.219_919, 300_000), (1.4, 0.99, 0.603_589, 120_000), (1.5, 0.99, 0.561_981, 120_000)]
    {
        let case = format!("n {n}, albedo {albedo}");
        let a = ask(&case, &Stack::half_space(n, 1.0 - albedo, isotropic(albedo, 0.0)), photons);
        agree(&case, a.reflectance, truth, 1e-6);
    }
}

/// Three layers of the MCML manual (Wang and Jacques 1992), whose own figures come from 1e6 photons.
#[test]
fn three_layers_of_mcml() {
    let layer = |mu_a: f64, mu_s: f64, g: f64, thickness: f64| {
        Layer::new(10.0 * thickness, 1.37, 0.1 * mu_a, isotropic(0.1 * mu_s, g))
    };
    let layers = vec![layer(1.0, 100.0, 0.9, 0.1), layer(1.0, 10.0, 0.0, 0.1), layer(2.0, 10.0, 0.7, 0.2)];
    let a = ask("MCML", &Stack { above: 1.0, layers, below: Substrate::Index(1.0) }, 600_000);
    assert!((a.specular - 0.024_372_9).abs() < 1e-6);
    agree("R", a.reflectance, 0.237_544, 4e-4);
    agree("T", a.transmittance, 0.096_489_6, 3e-4);
    for (layer, truth) in [0.2612, 0.1488, 0.2316].into_iter().enumerate() {
        agree(&format!("absorbed in {layer}"), a.absorbed[layer], truth, 4e-4);
    }
}

/// Chandrasekhar 1950: isotropic half space, index-matched; from the H-function, six digits.
#[test]
fn half_spaces_of_chandrasekhar() {
    let low = [(0.3, 0.057_214), (0.5, 0.115_226), (0.7, 0.208_680), (0.8, 0.285_255), (0.9, 0.414_947)];
    let high = [(0.95, 0.535_541), (0.97, 0.614_889), (0.98, 0.671_084), (0.99, 0.752_721)];
    let higher = [(0.995, 0.817_047), (0.999, 0.912_845), (0.9999, 0.971_418)];
    let normal = low.into_iter().chain(high).chain(higher);
    let diffuse = [(0.5, 0.146_544), (0.8, 0.341_867), (0.9, 0.478_024), (0.95, 0.596_669)];
    let diffuse = diffuse.into_iter().chain([(0.99, 0.794_564), (0.999, 0.929_713)]);
    let ask = |case: &str, albedo: f64, incidence: Option<f64>| {
        let stack = Stack::half_space(1.0, 1.0 - albedo, isotropic(albedo, 0.0));
        // Light that lives longer varies less.
        let photons = 6e5 * (1.0 - albedo).sqrt();
        answer(case, &stack, Question { incidence, ..towards(0.9) }, photons as u64).reflectance
    };
    for (albedo, truth) in normal {
        let case = format!("normal, albedo {albedo}");
        agree(&case, ask(&case, albedo, Some(0.0)), truth, 1e-6);
    }
    for (albedo, truth) in diffuse {
        let case = format!("diffuse, albedo {albedo}");
        agree(&case, ask(&case, albedo, None), truth, 1e-6);
    }
}

/// Monte Carlo of ours by other code: a half space that scatters forwards, and a thick slab.
#[test]
fn values_of_an_earlier_walk() {
    let half = ask("g 0.9", &Stack::half_space(1.4, 0.1, isotropic(99.0, 0.9)), 80_000);
    agree("g 0.9", half.reflectance, 0.602_58, 2.5e-4);
    let slab = ask("slab", &Stack::slab(10.0, 1.0, 0.01, isotropic(0.99, 0.0)), 1_000_000);
    agree("slab R", slab.reflectance, 0.740_98, 2e-4);
    agree("slab T", slab.transmittance, 0.084_78, 2e-4);
}

type Matrix = Vec<Vec<f64>>;

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let row = |a: &Vec<f64>| {
        let mut sum = vec![0.0; b.len()];
        a.iter().zip(b).for_each(|(a, b)| sum.iter_mut().zip(b).for_each(|(sum, b)| *sum += a * b));
        sum
    };
    a.iter().map(row).collect()
}

fn sum(a: &Matrix, b: &Matrix) -> Matrix {
    a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| a + b).collect()).collect()
}

/// Angles against the normal and weights, Gauss and Legendre's on [-pi/2, pi/2]; the middle one of an odd `count` is 0.
fn angles(count: usize) -> Vec<(f64, f64)> {
    let node = |i: usize| {
        let (mut x, mut slope) = ((PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos(), 1.0);
        for _ in 0..20 {
            let next = |(p, q): (f64, f64), k: usize| (((2 * k + 1) as f64 * x * p - k as f64 * q) / (k + 1) as f64, p);
            let (p, q) = (0..count).fold((1.0, 0.0), next);
            slope = count as f64 * (x * p - q) / (x * x - 1.0);
            x -= p / slope;
        }
        (FRAC_PI_2 * x, PI / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(node).collect()
}

/// Reflectance of a half space for light straight from above that moves in a plane, by adding and doubling (van de
/// Hulst 1963): of a thin layer scattered once to what doubling it makes of it. `density` is that of a turn.
fn plane_half_space(albedo: f64, density: impl Fn(f64) -> f64) -> f64 {
    const COUNT: usize = 81;
    const THIN: f64 = 1e-7;
    let angles = angles(COUNT);
    // Of light in each direction (column), the share that a thin layer sends into each (row), upwards or on.
    let [mut back, mut on] = [(); 2].map(|()| vec![vec![0.0; COUNT]; COUNT]);
    for (j, (from, _)) in angles.iter().enumerate() {
        let to = |turn: f64| angles.iter().map(move |(to, weight)| (turn + to, weight));
        let up: Vec<f64> = to(PI).map(|(to, weight)| weight * density(to + from)).collect();
        let down: Vec<f64> = to(0.0).map(|(to, weight)| weight * density(to - from)).collect();
        let scale = albedo * THIN / from.cos() / up.iter().chain(&down).sum::<f64>();
        for i in 0..COUNT {
            back[i][j] = up[i] * scale;
            on[i][j] = down[i] * scale + if i == j { 1.0 - THIN / from.cos() } else { 0.0 };
        }
    }
    for _ in 0..34 {
        // Light between both halves: the sum of all powers of back and forth.
        let (mut power, mut between) = (product(&back, &back), on.clone());
        for _ in 0..6 {
            between = sum(&between, &product(&power, &between));
            power = product(&power, &power);
        }
        back = sum(&back, &product(&on, &product(&back, &between)));
        on = product(&on, &between);
    }
    back.iter().map(|row| row[COUNT / 2]).sum()
}

/// Light across parallel fibres stays in a plane, where adding and doubling is exact: 0.50517 for mirror-like cylinders
/// with albedo 0.9 (160 angles), and isotropic turns.
#[test]
fn cylinders_across_are_a_plane_problem() {
    for (case, turn, truth) in
        [("mirror", CylinderPhase::Mirror, Some(0.505_17)), ("even", CylinderPhase::Cauchy(0.0), None)]
    {
        let exact = plane_half_space(0.9, |turned| reference::phase::turn_density(turn, turned.cos()));
        assert!(truth.is_none_or(|truth| (exact - truth).abs() < 2e-5), "{case}: {exact}");
        let fibres = Scattering::Fibres { sigma_i: 0.0, sigma_c: 0.9, turn, axis: DVec3::Y, dispersion: 0.0 };
        let question = Question { line_mm: 0.0, ..Question::default() };
        let a = answer(case, &Stack::half_space(1.0, 0.1, fibres), question, 200_000);
        agree(&format!("cylinders, {case}"), a.reflectance, exact, 2e-5);
        // Light stays on its cone: entering across the fibre, it never moves along it.
        let centre = a.line.len() / 2;
        assert!((a.line[centre].value - a.reflectance.value).abs() < 1e-12, "spread along parallel fibres");
    }
}

fn wood(dive_deg: f64, azimuth_deg: f64) -> Stack {
    let ((up, flat), (x, y)) = (dive_deg.to_radians().sin_cos(), azimuth_deg.to_radians().sin_cos());
    let axis = DVec3::new(x * flat, y * flat, up);
    let turn = CylinderPhase::Cauchy(0.0);
    let fibres = Scattering::Fibres { sigma_i: 2.0, sigma_c: 10.0, turn, axis, dispersion: WOOD_DISPERSION };
    Stack::half_space(1.18, 0.08, fibres)
}

/// What collisions send to the lens and what photons bring there are the same light.
#[test]
fn next_events_agree_with_counting() {
    let walks = [
        ("wood at 15 deg", wood(15.0, 0.0)),
        ("wood at 40 deg", wood(40.0, 30.0)),
        ("even", Stack::half_space(1.3, 0.1, isotropic(20.0, 0.6))),
    ];
    for (case, stack) in walks {
        let a = ask(case, &stack, 150_000);
        let (lens, cone) = (a.towards_lens.unwrap(), a.cone.unwrap());
        let z = (lens.value - cone.value) / lens.error.hypot(cone.error);
        println!("{case}: {lens:?} {cone:?} z = {z:.2}");
        assert!(z.abs() < 3.0, "{case}: lens {lens:?}, cone {cone:?}");
        assert!(lens.error < 0.3 * cone.error, "a next event is worth its price");
    }
}

/// Light takes a way and its reverse with the same chance, however the fibres lie.
#[test]
fn ways_are_reversible() {
    let direction = |tilt: f64, azimuth: f64| {
        let ((sin, cos), (y, x)) = (tilt.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
        DVec3::new(sin * x, sin * y, cos)
    };
    let radiance = |light: (f64, f64), view: (f64, f64)| {
        let question = Question {
            incidence: Some(light.0.to_radians()),
            // Light that arrives from `light` travels the other way.
            incidence_azimuth: (light.1 + 180.0).to_radians(),
            view: direction(view.0, view.1),
            ..Question::default()
        };
        answer(&format!("{light:?} to {view:?}"), &wood(20.0, 35.0), question, 100_000).towards_lens.unwrap()
    };
    for (from, to) in [((0.0, 0.0), (25.0, -90.0)), ((50.0, 20.0), (30.0, 130.0)), ((65.0, -60.0), (15.0, 90.0))] {
        let (one, other) = (radiance(from, to), radiance(to, from));
        let z = (one.value - other.value) / one.error.hypot(other.error);
        println!("{from:?} {to:?}: {one:?} {other:?} z = {z:.2}");
        assert!(z.abs() < 3.0, "{from:?} to {to:?}: {one:?}, back {other:?}");
    }
}

/// Slab of Pini, Giusfredi and Pattelli 2026: their diffusion gives R = 0.66369, T = 0.0231992 of light that entered.
/// Diffusion itself errs by up to 4 % here, 20 mm or some 20 transport mean free paths thick.
#[test]
fn tensor_scattering_diffuses_as_published() {
    let scattering = Scattering::Tensor { mu_s: DVec3::new(12.0, 8.0, 5.0), g: 0.85 };
    let a = ask("tensor", &Stack::slab(20.0, 1.4, 0.01, scattering), 40_000);
    for (what, got, truth) in [("R", a.reflectance, 0.663_69), ("T", a.transmittance, 0.023_199_2)] {
        let truth = (1.0 - a.specular) * truth;
        println!("{what}: {got:?} against {truth:.5}, {:+.2} %", 100.0 * (got.value / truth - 1.0));
        assert!((got.value - truth).abs() < 0.04 * truth + 2.0 * got.error, "{what}: {got:?} against {truth}");
    }
}

/// An answer does not depend on the number of threads.
#[test]
fn threads_do_not_count() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| ask("threads", &wood(10.0, 0.0), 20_000))
    };
    assert_eq!(run(1), run(3));
}
