//! The judge (Monte Carlo of the transport equation) against exact and published values, in standard errors.

use sheetlight::transport::answer::{Answer, Estimate, Question};
use sheetlight::transport::path::{Effort, solve};
use sheetlight::transport::stack::{Scattering, Stack};

fn isotropic(mu_s: f64, g: f64) -> Scattering {
    Scattering::Isotropic { mu_s, g }
}

fn ask(stack: &Stack, photons: u64) -> Answer {
    solve(stack, &Question { cells: 0, ..Question::default() }, Effort { photons, seed: 1 })
}

/// Within three standard errors, with a relative error under 0.3 %; `known` is the uncertainty of `truth` itself.
fn agree(what: &str, got: Estimate, truth: f64, known: f64) {
    let z = (got.value - truth) / got.error.hypot(known);
    println!("{what}: {:.5} +- {:.5} against {truth} (z = {z:.2})", got.value, got.error);
    assert!(z.abs() < 3.0, "{what}: {} +- {} against {truth} +- {known}, z = {z}", got.value, got.error);
    assert!(got.error < 0.003 * truth, "{what}: relative error {}", got.error / truth);
}

fn closes(answer: &Answer) {
    let absorbed: f64 = answer.absorbed.iter().map(|e| e.value).sum();
    let sum = answer.specular + answer.reflectance.value + answer.transmittance.value + absorbed;
    assert!((sum - 1.0).abs() < 1e-6, "energy {sum}");
}

/// Slab of van de Hulst 1980: tau = 2, albedo 0.9, g = 0.75, index-matched.
fn van_de_hulst() -> Stack {
    Stack::slab(0.2, 1.0, 1.0, isotropic(9.0, 0.75))
}

#[test]
fn slab_of_van_de_hulst() {
    let answer = ask(&van_de_hulst(), 4_000_000);
    closes(&answer);
    agree("R", answer.reflectance, 0.09739, 5e-6);
    agree("T", answer.transmittance, 0.66096, 5e-6);
    agree("T unscattered", answer.unscattered, (-2f64).exp(), 0.0);
}
