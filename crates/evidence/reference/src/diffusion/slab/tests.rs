//! Tests of plane layers.

use glam::{DVec2, DVec3};

use super::super::tensor::moments;
use super::super::transmission_line::{DiffuseSource, TransmissionLine};
use super::radiance_factor;
use super::solve;
use transport::answer::{LineSide, Question};
use transport::stack::{CylinderPhase, Layer, Scattering, Stack, Substrate};

fn fibres(sigma_i: f64, k: f64, dive_deg: f64) -> Scattering {
    let (sin, cos) = libm::sincos(dive_deg.to_radians());
    let axis = DVec3::new(0.0, cos, -sin);
    Scattering::Fibres { sigma_i, sigma_c: k, turn: CylinderPhase::Cauchy(0.0), axis, dispersion: 0.0 }
}

fn close(value: f64, expected: f64, relative: f64, what: &str) {
    assert!((value - expected).abs() <= relative * expected.abs(), "{what}: {value} against {expected}");
}

/// Purpose: a half space has the closed form of docs/theory/physics.md at every dive, with the shift of its pattern.
#[test]
fn half_space_has_the_closed_form() {
    let question = Question { cells: 0, ..Question::default() };
    // R before Fresnel's loss is that of the table over T; both to its three digits.
    let table = [
        (0.0, 0.743, 0.0),
        (15.0, 0.710, 0.009),
        (30.0, 0.644, 0.001),
        (45.0, 0.583, -0.013),
        (60.0, 0.540, -0.026),
        (90.0, 0.511, 0.0),
    ];
    for (dive, reflectance, shift) in table {
        let wide = Question { rows: 400, row_mm: 0.05, ..question };
        let answer = solve(&Stack::half_space(1.18, 0.08, fibres(2.0, 10.0, dive)), &wide).expect("it scatters");
        assert!((answer.reflectance.value - reflectance).abs() < 1e-3, "R at {dive}: {:?}", answer.reflectance);
        let total: f64 = answer.line.iter().map(|e| e.value).sum();
        close(total, answer.reflectance.value, 2e-5, "rows");
        let moment: f64 = answer.line.iter().enumerate().map(|(j, e)| e.value * (j as f64 - 400.0) * 0.05).sum();
        // Positive towards +y, where this fibre dives.
        assert!((moment / total - shift).abs() < 1.5e-3, "shift at {dive}: {}", moment / total);
    }
}

/// Purpose: layers that are alike are one layer, in energy, line and point; and energy closes for slanted, diffuse and
/// thin cases.
#[test]
fn cuts_through_a_medium_change_nothing() {
    let question = Question { cells: 8, incidence: Some(0.5), incidence_azimuth: 0.7, ..Question::default() };
    let layer = |thickness| Layer::new(thickness, 1.3, 0.4, fibres(3.0, 9.0, 35.0));
    let one = Stack { above: 1.0, layers: vec![layer(1.4)], below: Substrate::Index(1.5) };
    let three = Stack { layers: vec![layer(0.6), layer(0.5), layer(0.3)], ..one.clone() };
    let (a, b) = (solve(&one, &question).expect("one"), solve(&three, &question).expect("three"));
    // The mean place of what ends in each layer differs from one mean place by its spread alone.
    assert!((a.reflectance.value - b.reflectance.value).abs() < 0.02, "{:?} {:?}", a.reflectance, b.reflectance);
    let deep = Stack { layers: vec![layer(1.4), layer(50.0)], ..one.clone() };
    let whole = Stack { layers: vec![layer(51.4)], ..one.clone() };
    let line = TransmissionLine::new(&deep).expect("it scatters");
    let other = TransmissionLine::new(&whole).expect("it scatters");
    let (mut waves, mut others) = (Vec::new(), Vec::new());
    for k in [DVec2::ZERO, DVec2::new(3.0, -1.0), DVec2::new(0.0, 20.0)] {
        line.wave(k, &mut waves);
        other.wave(k, &mut others);
        for (layer, depth) in [(0, 0.2), (0, 1.1), (1, 0.1)] {
            let source = DiffuseSource { share: 1.0, layer, depth, exit: DVec2::ZERO };
            let same = DiffuseSource { layer: 0, depth: depth + 1.4 * layer as f64, ..source };
            close(line.exit(&source, &waves), other.exit(&same, &others), 1e-10, "exit");
        }
    }
    for stack in [&one, &three, &deep] {
        for incidence in [Some(0.0), Some(1.2), None] {
            let answer = solve(stack, &Question { incidence, cells: 0, ..question }).expect("it scatters");
            let absorbed: f64 = answer.absorbed.iter().map(|e| e.value).sum();
            let sum = answer.specular + answer.reflectance.value + answer.transmittance.value + absorbed;
            close(sum, 1.0, 1e-12, "energy");
            assert!(answer.unscattered.value > 0.0 || stack.layers.len() == 2);
            assert!(answer.unscattered.value <= answer.transmittance.value);
        }
    }
}

/// Purpose: unlike layers against finite differences of the same problem in depth.
#[test]
fn unlike_layers_agree_with_finite_differences() {
    let isotropic = |mu_s| Scattering::Isotropic { mu_s, g: 0.0 };
    let layers = [(0.5, 0.1, 8.0), (0.8, 0.6, 3.0), (1.2, 0.02, 15.0)];
    let layer = |&(thickness, mu_a, mu_s): &(f64, f64, f64)| Layer::new(thickness, 1.4, mu_a, isotropic(mu_s));
    let stack = Stack { above: 1.0, layers: layers.iter().map(layer).collect(), below: Substrate::Index(1.4) };
    let line = TransmissionLine::new(&stack).expect("it scatters");
    let mut waves = Vec::new();
    line.wave(DVec2::ZERO, &mut waves);
    let source = DiffuseSource { share: 1.0, layer: 1, depth: 0.2, exit: DVec2::ZERO };
    let (up, down, absorbed) = line.energy(&source, &waves);
    // Cells of h from z_e above to z_e below, Phi = 0 at both ends.
    let h = 2e-4;
    let count = ((line.ends[0] + 2.5 + line.ends[1]) / h).round() as usize;
    let depth = |i: usize| (i as f64 + 0.5) * h - line.ends[0];
    let own = |z: f64| {
        if z < 0.5 {
            0
        } else if z < 1.3 {
            1
        } else {
            2
        }
    };
    let d = |i: usize| 1.0 / (3.0 * layers[own(depth(i))].2);
    let face = |i: usize| 2.0 * d(i) * d(i + 1) / (d(i) + d(i + 1)) / h;
    let (mut slope, mut value) = (vec![0.0; count], vec![0.0; count]);
    for i in 0..count {
        let last = if i > 0 { face(i - 1) } else { 2.0 * d(i) / h };
        let next = if i + 1 < count { face(i) } else { 2.0 * d(i) / h };
        let s = if (depth(i) - 0.7).abs() <= 0.5 * h { 1.0 } else { 0.0 };
        let (a, b) = if i > 0 { (slope[i - 1], value[i - 1]) } else { (0.0, 0.0) };
        let pivot = last + next + h * layers[own(depth(i))].1 - last * a;
        slope[i] = next / pivot;
        value[i] = (s + last * b) / pivot;
    }
    for i in (0..count - 1).rev() {
        value[i] += slope[i] * value[i + 1];
    }
    let at = |z: f64| ((z + line.ends[0]) / h).round() as usize;
    let mut sums = [0.0; 3];
    (at(0.0)..at(2.5)).for_each(|i| sums[own(depth(i))] += h * layers[own(depth(i))].1 * value[i]);
    let flux = |i: usize| face(i - 1) * (value[i] - value[i - 1]);
    close(up, flux(at(0.0)), 1e-3, "R");
    close(down, -flux(at(2.5)), 1e-3, "T");
    (0..3).for_each(|i| close(absorbed[i], sums[i], 1e-3, "absorbed"));
}

/// Purpose: the point spread added up over x is the line spread, for a slanted tensor and an index step inside.
#[test]
fn point_spread_adds_up_to_line_spread() {
    let question = Question { line_mm: 0.0, rows: 25, row_mm: 0.1, cells: 30, cell_mm: 0.1, ..Question::default() };
    let (sin, cos) = libm::sincos(0.6);
    let axis = DVec3::new(0.5 * cos, 0.75f64.sqrt() * cos, -sin);
    let wood = Scattering::Fibres { sigma_i: 4.0, sigma_c: 12.0, turn: CylinderPhase::Mirror, axis, dispersion: 0.0 };
    let film = Layer::new(0.3, 1.5, 1.0, Scattering::Isotropic { mu_s: 12.0, g: 0.5 });
    let below = Layer::new(f64::INFINITY, 1.2, 1.5, wood);
    for layers in [vec![film, below], vec![below]] {
        let answer =
            solve(&Stack { above: 1.0, layers, below: Substrate::Index(1.0) }, &question).expect("it scatters");
        let side = 61;
        for row in 0..51 {
            let sum: f64 = answer.point[(row + 5) * side..(row + 6) * side].iter().map(|e| e.value).sum();
            let line = answer.line[row].value;
            // Beyond 3 mm lies less than 1e-6 of the light.
            assert!((sum - line).abs() < 2e-6, "row {row}: {sum} against {line}");
        }
        let rest = answer.rows(0, 25, LineSide::Both) / answer.reflectance.value;
        assert!(rest > 0.99 && rest <= 1.0, "{rest}");
    }
}

/// Purpose: the law of exit sends out the flux, angles add up to it, and moments keep detailed balance.
#[test]
fn exit_angles_carry_the_flux() {
    for n in [1.0, 1.18, 1.5] {
        let steps = 4000;
        let mu = |i: usize| (i as f64 + 0.5) / steps as f64;
        let sum: f64 = (0..steps).map(|i| 2.0 * mu(i) * radiance_factor(n, mu(i)) / steps as f64).sum();
        // The factor A is good to 1e-5.
        close(sum, 1.0, 5e-5, "flux");
        let (inside, outside) = (moments(n).0, moments(1.0 / n).0);
        close(n * n * (1.0 - 2.0 * inside), 1.0 - 2.0 * outside, 2e-4, "balance");
    }
    let stack = Stack::slab(2.0, 1.5, 0.1, Scattering::Isotropic { mu_s: 10.0, g: 0.2 });
    let answer = solve(&stack, &Question { cells: 0, ..Question::default() }).expect("it scatters");
    let solid =
        |from: f64, to: f64| 2.0 * std::f64::consts::PI * (libm::cos(from.to_radians()) - libm::cos(to.to_radians()));
    let sum: f64 = answer.angles.iter().map(|a| a.reflected.value * solid(a.from_deg, a.to_deg)).sum();
    close(sum, answer.reflectance.value, 1e-4, "angles");
}

/// Purpose: what diffusion cannot say is refused, by the number of the layer and with a remedy.
#[test]
fn clear_layers_are_refused() {
    let layer = |mu_s| Layer::new(1.0, 1.0, 0.0, Scattering::Isotropic { mu_s, g: 0.0 });
    let ask =
        |layers, question: &Question| solve(&Stack { above: 1.0, layers, below: Substrate::Index(1.0) }, question);
    let question = Question::default();
    let refusal = ask(vec![layer(9.0), layer(0.0), layer(9.0)], &question).expect_err("a gap");
    assert!(refusal.starts_with("layer 1 does not scatter") && refusal.contains("path model"), "{refusal}");
    let guided = Layer { scattering: fibres(0.0, 5.0, 0.0), ..layer(1.0) };
    let refused = |layers, question| ask(layers, question).expect_err("diffusion cannot say");
    assert!(refused(vec![guided], &question).starts_with("layer 0 has cylinders without background"));
    assert!(refused(vec![], &question).starts_with("the stack has no layer"));
    let grazing = Question { incidence: Some(1.6), ..question };
    assert!(refused(vec![layer(9.0)], &grazing).ends_with("ask for less than 90 degrees"));
}

/// Purpose: how far diffusion is from the transport equation, so that nobody trusts it further. Chandrasekhar's
/// solution for n = 1 (H function), Monte Carlo of 1e-4 for the others.
#[test]
fn transport_is_met_within_the_stated_error() {
    let isotropic = |mu_s, g| Scattering::Isotropic { mu_s, g };
    let question = Question { cells: 0, rows: 0, ..Question::default() };
    let albedo = |a: f64, n: f64| Stack::half_space(n, 1.0 - a, isotropic(a, 0.0));
    let half_spaces = [
        (albedo(0.9, 1.0), 0.414947, 0.006),
        (albedo(0.99, 1.0), 0.752721, 0.004),
        (albedo(0.999, 1.0), 0.912845, 0.002),
        (albedo(0.99, 1.4), 0.60350, 0.012),
        (albedo(0.99, 1.5), 0.56230, 0.016),
    ];
    for (stack, reflectance, error) in half_spaces {
        let value = solve(&stack, &question).expect("it scatters").reflectance.value;
        println!("half space: {value:.5} against {reflectance}");
        assert!((value - reflectance).abs() < error, "{value} against {reflectance}");
    }
    let slab = solve(&Stack::slab(10.0, 1.0, 0.01, isotropic(0.99, 0.0)), &question).expect("it scatters");
    println!("slab: {:?} {:?} against 0.74098 0.08478", slab.reflectance, slab.transmittance);
    assert!((slab.reflectance.value - 0.74098).abs() < 0.006 && (slab.transmittance.value - 0.08478).abs() < 0.003);
}
