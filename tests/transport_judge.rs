//! The judge (Monte Carlo of the transport equation) against exact and published values, in standard errors.

use glam::DVec3;
use sheetlight::transport::answer::{Answer, Estimate, Question};
use sheetlight::transport::path::{Effort, solve};
use sheetlight::transport::stack::{Layer, Scattering, Stack, Turn, WOOD_DISPERSION};

fn isotropic(mu_s: f64, g: f64) -> Scattering {
    Scattering::Isotropic { mu_s, g }
}

fn answer(stack: &Stack, question: Question, photons: u64) -> Answer {
    let answer = solve(stack, &Question { cells: 0, ..question }, Effort { photons, seed: 1 });
    let absorbed: f64 = answer.absorbed.iter().map(|e| e.value).sum();
    let sum = answer.specular + answer.reflectance.value + answer.transmittance.value + absorbed;
    assert!((sum - 1.0).abs() < 1e-6, "energy {sum}");
    answer
}

fn ask(stack: &Stack, photons: u64) -> Answer {
    answer(stack, Question::default(), photons)
}

/// Within three standard errors of `truth`, which is itself only known to `known`; relative error under 0.3 %.
fn agree(what: &str, got: Estimate, truth: f64, known: f64) {
    let z = (got.value - truth) / got.error.hypot(known);
    println!("{what}: {:.5} +- {:.5} against {truth} (z = {z:.2})", got.value, got.error);
    assert!(z.abs() < 3.0, "{what}: {} +- {} against {truth} +- {known}, z = {z}", got.value, got.error);
    assert!(got.error < 0.003 * truth, "{what}: relative error {}", got.error / truth);
}

/// Towards a lens at the cosine `mu` against the normal; below the slab for negative `mu`.
fn towards(mu: f64) -> Question {
    Question { view: DVec3::new(0.0, -(1.0 - mu * mu).sqrt(), mu), ..Question::default() }
}

/// Slab of van de Hulst 1980: tau = 2, albedo 0.9, g = 0.75, index-matched. Printed to five digits.
#[test]
fn slab_of_van_de_hulst() {
    let slab = Stack::slab(0.2, 1.0, 1.0, isotropic(9.0, 0.75));
    let a = ask(&slab, 3_000_000);
    agree("R", a.reflectance, 0.09739, 3e-6);
    agree("T", a.transmittance, 0.66096, 3e-6);
    agree("T unscattered", a.unscattered, (-2f64).exp(), 0.0);
    // Radiance factors at cosines; grazing exit (0) has none.
    let reflected = [(0.1, 0.13304), (0.3, 0.13856), (0.5, 0.11956), (0.7, 0.09411), (0.9, 0.07132), (1.0, 0.06180)];
    let transmitted = [(0.1, 0.16486), (0.3, 0.22473), (0.5, 0.27785), (0.7, 0.36889), (0.9, 0.72155), (1.0, 2.40270)];
    for (mu, truth) in reflected.into_iter().chain(transmitted.map(|(mu, truth)| (-mu, truth))) {
        let a = answer(&slab, towards(mu), 1_500_000);
        agree(&format!("radiance factor at {mu}"), a.towards_lens.unwrap(), truth, 3e-6);
    }
}

/// Giovanelli 1955: half space, n = 1.5, albedo 0.9, isotropic; 0.2600 with the specular 0.0400.
#[test]
fn half_space_of_giovanelli() {
    let a = ask(&Stack::half_space(1.5, 1.0, isotropic(9.0, 0.0)), 1_000_000);
    let total = Estimate { value: a.specular + a.reflectance.value, error: a.reflectance.error };
    agree("R", total, 0.2600, 5e-5);
}

/// Three layers of the MCML manual (Wang and Jacques 1992), whose own figures come from 1e6 photons.
#[test]
fn three_layers_of_mcml() {
    let layer = |mu_a: f64, mu_s: f64, g: f64, thickness: f64| Layer {
        thickness: 10.0 * thickness,
        n: 1.37,
        mu_a: 0.1 * mu_a,
        scattering: isotropic(0.1 * mu_s, g),
    };
    let layers = vec![layer(1.0, 100.0, 0.9, 0.1), layer(1.0, 10.0, 0.0, 0.1), layer(2.0, 10.0, 0.7, 0.2)];
    let a = ask(&Stack { above: 1.0, layers, below: 1.0 }, 1_500_000);
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
    let normal = [
        (0.3, 0.057_214),
        (0.5, 0.115_226),
        (0.7, 0.208_680),
        (0.8, 0.285_255),
        (0.9, 0.414_947),
        (0.95, 0.535_541),
        (0.97, 0.614_889),
        (0.98, 0.671_084),
        (0.99, 0.752_721),
        (0.995, 0.817_047),
        (0.999, 0.912_845),
        (0.9999, 0.971_418),
    ];
    let diffuse = [
        (0.5, 0.146_544),
        (0.8, 0.341_867),
        (0.9, 0.478_024),
        (0.95, 0.596_669),
        (0.99, 0.794_564),
        (0.999, 0.929_713),
    ];
    let ask = |albedo: f64, incidence: Option<f64>| {
        let stack = Stack::half_space(1.0, 1.0 - albedo, isotropic(albedo, 0.0));
        let photons = if albedo < 0.6 { 900_000 } else { 300_000 };
        answer(&stack, Question { incidence, ..towards(0.9) }, photons).reflectance
    };
    for (albedo, truth) in normal {
        agree(&format!("normal, albedo {albedo}"), ask(albedo, Some(0.0)), truth, 1e-6);
    }
    for (albedo, truth) in diffuse {
        agree(&format!("diffuse, albedo {albedo}"), ask(albedo, None), truth, 1e-6);
    }
}

/// Monte Carlo by others' code of ours: half spaces with an index step, a thick slab, mirror-like cylinders.
#[test]
fn values_of_an_earlier_walk() {
    let half = |n: f64, mu_a: f64, mu_s: f64, g: f64| ask(&Stack::half_space(n, mu_a, isotropic(mu_s, g)), 400_000);
    agree("n 1.4", half(1.4, 0.01, 0.99, 0.0).reflectance, 0.603_50, 1.8e-4);
    agree("n 1.5", half(1.5, 0.01, 0.99, 0.0).reflectance, 0.562_30, 1.8e-4);
    agree("g 0.9", half(1.4, 0.1, 99.0, 0.9).reflectance, 0.602_58, 2.5e-4);
    let slab = ask(&Stack::slab(10.0, 1.0, 0.01, isotropic(0.99, 0.0)), 1_500_000);
    agree("slab R", slab.reflectance, 0.740_98, 2e-4);
    agree("slab T", slab.transmittance, 0.084_78, 2e-4);
    let axis = DVec3::Y;
    let fibres = Scattering::Fibres { sigma_i: 0.0, sigma_c: 0.9, turn: Turn::Mirror, axis, dispersion: 0.0 };
    let a = ask(&Stack::half_space(1.0, 0.1, fibres), 400_000);
    agree("cylinders R", a.reflectance, 0.507_58, 2.6e-4);
    // Light stays on its cone: entering across the fibre, it never moves along it.
    let centre = a.line.len() / 2;
    assert!((a.line[centre].value - a.reflectance.value).abs() < 1e-12, "spread along parallel fibres");
}

fn wood(dive_deg: f64, azimuth_deg: f64) -> Stack {
    let ((up, flat), (x, y)) = (dive_deg.to_radians().sin_cos(), azimuth_deg.to_radians().sin_cos());
    let axis = DVec3::new(x * flat, y * flat, up);
    let turn = Turn::Cauchy(0.0);
    let fibres = Scattering::Fibres { sigma_i: 2.0, sigma_c: 10.0, turn, axis, dispersion: WOOD_DISPERSION };
    Stack::half_space(1.18, 0.08, fibres)
}

/// What collisions send to the lens and what photons bring there are the same light.
#[test]
fn next_events_agree_with_counting() {
    let walks = [wood(15.0, 0.0), wood(40.0, 30.0), Stack::slab(0.3, 1.3, 0.1, isotropic(20.0, 0.6))];
    for (i, stack) in walks.iter().enumerate() {
        let layers = vec![Layer { thickness: f64::INFINITY, ..stack.layers[0] }];
        let a = ask(&Stack { layers, ..stack.clone() }, 400_000);
        let (lens, cone) = (a.towards_lens.unwrap(), a.cone.unwrap());
        let z = (lens.value - cone.value) / lens.error.hypot(cone.error);
        println!("{i}: {lens:?} {cone:?} z = {z:.2}");
        assert!(z.abs() < 3.3, "case {i}: lens {lens:?}, cone {cone:?}");
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
    for (from, to) in [((0.0, 0.0), (25.0, -90.0)), ((50.0, 20.0), (30.0, 130.0)), ((65.0, -60.0), (15.0, 90.0))] {
        let radiance = |light: (f64, f64), view: (f64, f64)| {
            // Light that arrives from `light` travels the other way.
            let (incidence, azimuth) = (light.0.to_radians(), (light.1 + 180.0).to_radians());
            let question = Question {
                incidence: Some(incidence),
                incidence_azimuth: azimuth,
                view: direction(view.0, view.1),
                ..Question::default()
            };
            answer(&wood(20.0, 35.0), question, 300_000).towards_lens.unwrap()
        };
        let (one, other) = (radiance(from, to), radiance(to, from));
        let z = (one.value - other.value) / one.error.hypot(other.error);
        println!("{from:?} {to:?}: {one:?} {other:?} z = {z:.2}");
        assert!(z.abs() < 3.3, "{from:?} to {to:?}: {one:?}, back {other:?}");
    }
}

/// Slab of Pini, Giusfredi and Pattelli 2026: their diffusion theory gives R = 0.6637, T = 0.0232; walks of that law
/// agree where diffusion holds (20 mm, many mean free paths).
#[test]
fn tensor_scattering_diffuses_as_published() {
    let scattering = Scattering::Tensor { mu_s: DVec3::new(12.0, 8.0, 5.0), g: 0.85 };
    let a = ask(&Stack::slab(20.0, 1.4, 0.01, scattering), 40_000);
    println!("{:?} {:?} spec {}", a.reflectance, a.transmittance, a.specular);
    assert!((a.reflectance.value - 0.6637).abs() < 0.02, "R {:?}", a.reflectance);
    assert!((a.transmittance.value - 0.0232).abs() < 0.002, "T {:?}", a.transmittance);
}

/// An answer does not depend on the number of threads.
#[test]
fn threads_do_not_count() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| ask(&wood(10.0, 0.0), 20_000))
    };
    assert_eq!(run(1), run(3));
}
