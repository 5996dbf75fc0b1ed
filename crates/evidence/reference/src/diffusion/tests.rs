//! Tests of tensors and of the generalised equation.

use glam::{DVec2, DVec3};
use serde_json::Value;

use super::generalized::Generalized;
use super::spread::point_spread;
use super::tensor::Diffusive;
use super::transmission_line::{DiffuseSource, TransmissionLine};
use numerics::quadrature::composite;
use transport::answer::Question;
use transport::fresnel::boundary_factor;
use transport::stack::{CylinderPhase, Layer, Scattering, Stack};

fn fibres(sigma_i: f64, k: f64, dive_deg: f64) -> Scattering {
    let (sin, cos) = libm::sincos(dive_deg.to_radians());
    let axis = DVec3::new(0.0, cos, -sin);
    Scattering::Fibres { sigma_i, sigma_c: k, turn: CylinderPhase::Cauchy(0.0), axis, dispersion: 0.0 }
}

fn medium(scattering: Scattering, n: f64) -> Diffusive {
    Diffusive::new(&Layer::new(f64::INFINITY, n, 0.0, scattering), 0).expect("it scatters")
}

fn close(value: f64, expected: f64, relative: f64, what: &str) {
    assert!((value - expected).abs() <= relative * expected.abs(), "{what}: {value} against {expected}");
}

fn reference() -> Value {
    serde_json::from_str(include_str!("../../../../../tests/data/ade.json")).expect("a document")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn vector(value: &Value) -> DVec3 {
    DVec3::new(number(&value[0]), number(&value[1]), number(&value[2]))
}

/// Purpose: the cylinder tensor has the check values of docs/theory/physics.md, in any frame, and g2 enters as k does.
#[test]
fn cylinder_tensor_has_its_check_values() {
    // Rounded to four digits there.
    let table = [
        (1.0, 5.0, 0.06295),
        (1.0, 2.5, 0.10546),
        (1.0, 40.0 / 3.0, 0.026919),
        (2.0, 10.0, 0.03148),
        (2.5, 14.0, 0.02296),
        (4.0, 10.0, 0.02637),
        (0.8, 4.0, 0.07869),
    ];
    for (sigma_i, k, across) in table {
        for dive in [0.0f64, 20.0, 90.0] {
            let d = medium(fibres(sigma_i, k, dive), 1.2).d;
            let along = 1.0 / (3.0 * sigma_i);
            let sin2 = libm::pow(libm::sin(dive.to_radians()), 2.0);
            close(d.x_axis.x, across, 4e-4, "D across");
            close(d.z_axis.z, across + (along - across) * sin2, 4e-4, "D_zz");
            close(d.determinant(), across * across * along, 1e-3, "determinant");
        }
    }
    let axis = DVec3::Y;
    let turned =
        Scattering::Fibres { sigma_i: 1.0, sigma_c: 10.0, turn: CylinderPhase::Cauchy(0.5), axis, dispersion: 0.0 };
    close(medium(turned, 1.0).d.x_axis.x, 0.06295, 4e-4, "g2 of 0.5");
    let forward = Scattering::Isotropic { mu_s: 10.0, g: 0.9 };
    close(medium(forward, 1.0).d.y_axis.y, 1.0 / 3.0, 1e-12, "Henyey and Greenstein");
}

/// Purpose: D, z_e and z0 of the generalised equation are the published ones; z_e with their nodes, which cross the
/// critical angle, and our own z_e where the closed form is known.
#[test]
fn generalised_equation_has_the_published_values() {
    let reference = reference();
    let speed = 299.792458 / 1.4;
    for case in reference["d"].as_array().expect("cases") {
        let d = Generalized::new(vector(&case["mu_s"]), number(&case["g"])).d * speed;
        let expected = vector(&case["d"]);
        (0..3).for_each(|i| close(d[i], expected[i], 1e-10, "D"));
    }
    let theirs = composite(&[0.0, 1.0], 200);
    for case in reference["boundary"].as_array().expect("cases") {
        let medium = Generalized::new(vector(&case["mu_s"]), number(&case["g"]));
        let n = 1.4 / number(&case["outside"]);
        close(medium.extrapolation_with(n, &theirs), number(&case["ze"]), 1e-9, "z_e");
        close(medium.extrapolation(n), number(&case["ze"]), 3e-3, "z_e, cut at the critical angle");
        close(-medium.persistence(DVec3::NEG_Z).z, number(&case["z0"]), 1e-6, "z0");
    }
    let plain = Generalized::new(DVec3::splat(10.0), 0.85);
    // The table's rule is good to 1e-5.
    close(plain.extrapolation(1.4), 2.0 * boundary_factor(1.4) * plain.d.z, 2e-5, "2 A D");
    let s = DVec3::new(0.48, -0.6, 0.64);
    assert!((plain.persistence(s) - s / 1.5).length() < 1e-12, "an isotropic walk persists along its direction");
}

/// Purpose: reflectance, transmittance and R(x, y) of the published slab, through the code that answers questions.
#[test]
fn slab_has_the_published_answer() {
    let slab = &reference()["slab"];
    let scattering = Scattering::Tensor { mu_s: vector(&slab["mu_s"]), g: number(&slab["g"]) };
    let stack = Stack::slab(number(&slab["thickness"]), 1.4, number(&slab["mu_a"]), scattering);
    let mut line = TransmissionLine::new(&stack).expect("it scatters");
    // Their z_e, to compare the rest.
    line.ends = [1.6799748029623103; 2];
    let source = |exit| DiffuseSource { share: 1.0, layer: 0, depth: 1.1147137372544524, exit };
    let mut waves = Vec::new();
    line.wave(DVec2::ZERO, &mut waves);
    let (up, down, absorbed) = line.energy(&source(DVec2::ZERO), &waves);
    close(up, number(&slab["reflectance"]), 1e-9, "R");
    close(down, number(&slab["transmittance"]), 1e-9, "T");
    close(absorbed[0], 1.0 - up - down, 1e-12, "absorbed");
    let question = Question { cells: 1, cell_mm: 1e-3, ..Question::default() };
    for (place, density) in
        slab["places"].as_array().expect("places").iter().zip(slab["density"].as_array().expect("R"))
    {
        let exit = -DVec2::new(number(&place[0]), number(&place[1]));
        let cells = point_spread(&line, &[source(exit)], &question);
        close(cells[4] * 1e6, number(density), 1e-6, "R(x, y)");
    }
}
