//! Purpose: diffusion on voxels against closed forms, and the properties that the equation has and the grid must keep.

use base::{Body, Medium};
use glam::{DMat3, DVec2, DVec3};
use procedural::flat::Flat;
use reference::diffusion::line_response::{DiffusionSettings, line_response_with_balance};
use reference::diffusion::solver::solve;
use reference::diffusion::tensor::{Diffusive, uniaxial};
use reference::diffusion::voxels::{Voxel, Voxels};
use transport::fresnel::boundary_factor;
use transport::line::LineSource;
use transport::stack::{Layer, Scattering};

fn fibre(azimuth_deg: f64, dive_deg: f64) -> DVec3 {
    let (sin, cos) = azimuth_deg.to_radians().sin_cos();
    let (down, level) = dive_deg.to_radians().sin_cos();
    DVec3::new(sin * level, cos * level, -down)
}

fn medium(mu_a: f32, sigma_i: f32, k: f32, fibre: DVec3) -> Medium {
    Medium {
        mu_a,
        sigma_i,
        k,
        n_eff: 1.2,
        fibre: fibre.as_vec3(),
        dispersion_deg: 5.0,
        gloss: base::Gloss::NONE,
        coat: 1.0,
    }
}

fn diffusive(medium: &Medium) -> Diffusive {
    let (n, mu_a) = (medium.n_eff.into(), medium.mu_a.into());
    Diffusive::new(&Layer::new(f64::INFINITY, n, mu_a, Scattering::from(medium)), 0).expect("matter")
}

fn plate(medium: Medium, slope_x: f32, slope_y: f32) -> Body {
    Body::new(Flat { height_mm: 20.0, slope_x, slope_y, width_mm: 40.0, length_mm: 40.0, medium })
}

/// A line over 1 mm of `body` with 1 W in it, which keeps away from its sides.
fn line<'a>(body: &'a Body, x: &'a [f32], power: &'a [f32]) -> LineSource<'a> {
    LineSource { body, y: 20.0, line_mm: 0.1, x, power, view: DVec3::Z, row_mm: 0.1, rows: 20 }
}

/// Purpose: total reflectance and line spread of a half space, with the error falling as the square of the pitch.
#[test]
#[ignore = "long"]
fn half_space_has_its_closed_form_and_converges() {
    let medium = medium(0.5, 3.0, 10.0, DVec3::Y);
    let d = diffusive(&medium);
    let (z0, dz, dy) = (-d.persistence(DVec3::NEG_Z).z, d.d.z_axis.z, d.d.y_axis.y);
    let ze = 2.0 * boundary_factor(1.2) * dz;
    // Robin's condition: a wave k along y leaves e^(-q z0) / (1 + q z_e) of its light.
    let wave = |k: f64| {
        let q = ((dy * k * k + 0.5) / dz).sqrt();
        (-q * z0).exp() / (1.0 + q * ze)
    };
    // The source stands in the middle of a voxel at both pitches, since its place within one changes the error, and
    // rows are one and three voxels wide.
    let (pitches, width) = ([z0 / 0.5, z0 / 1.5], z0 / 0.5);
    let row = |y: f64| {
        let step = 0.01;
        let part = |i: usize| {
            let k = (i as f64 + 0.5) * step;
            let mean = (0.5 * width * k).sin() / (0.5 * width * k);
            step * width / std::f64::consts::PI * wave(k) * (-0.5 * 0.01 * k * k).exp() * mean * (k * y).cos()
        };
        (0..8000).map(part).sum::<f64>()
    };
    let body = plate(medium, 0.0, 0.0);
    let x: Vec<f32> = (0..10).map(|i| i as f32 * 0.1 - 0.45).collect();
    let power = [0.1f32; 10];
    let ask = |pitch: f64| {
        let settings = DiffusionSettings { voxel_mm: pitch, tolerance: 1e-9 };
        let (response, balance) = line_response_with_balance(&line(&body, &x, &power), &settings);
        assert!((balance.left + balance.lost + balance.absorbed - 1.0).abs() < 1e-6, "{balance:?}");
        let rows: Vec<f32> = response.light.chunks_exact(10).map(|light| light.iter().sum()).collect();
        assert!(rows.iter().zip(rows.iter().rev()).all(|(a, b)| (a - b).abs() < 1e-6), "even about the line");
        println!("pitch {pitch}: R {} of {}, {balance:?}", balance.left, wave(0.0));
        balance
    };
    let error = |pitch: f64| (ask(pitch).left - wave(0.0)).abs();
    let [coarse, fine] = pitches.map(error);
    let order = (coarse / fine).ln() / 3f64.ln();
    assert!(fine < 2e-3 && (1.8..2.2).contains(&order), "errors {coarse} and {fine}, order {order}");
    // In the middle of a line that is long against the decay length across the fibre, 0.24 mm.
    let rows = |pitch: f64| {
        let long: Vec<f32> = (0..60).map(|i| i as f32 * 0.1 - 2.95).collect();
        let power = [1.0f32; 60];
        let settings = DiffusionSettings { voxel_mm: pitch, tolerance: 1e-9 };
        let line = LineSource { row_mm: width, ..line(&body, &long, &power) };
        let (response, _) = line_response_with_balance(&line, &settings);
        (0..41).map(|j| f64::from(response.light[j * 60 + 30])).collect::<Vec<_>>()
    };
    let worst = |pitch: f64| {
        let error = |(j, own): (usize, &f64)| (own - row((j as f64 - 20.0) * width)).abs();
        rows(pitch).iter().enumerate().map(error).fold(0.0, f64::max)
    };
    let [coarse, fine] = pitches.map(worst);
    let order = (coarse / fine).ln() / 3f64.ln();
    println!("rows: errors {coarse} and {fine} of {}, order {order}", row(0.0));
    assert!(fine < 0.02 * row(0.0) && (1.7..2.3).contains(&order), "errors {coarse} and {fine}, order {order}");
}

/// A block of one medium, its surface reflecting as index 1.2.
fn block(shape: [usize; 3], pitch: f64, mu_a: f64, d: DMat3) -> Voxels {
    let leak = 0.5 / boundary_factor(1.2);
    Voxels::new(shape, pitch, |_| Some(Voxel { mu_a, d, leak }), |_, _| 1.0)
}

/// Purpose: cross terms. Light of a point in wood whose fibre is turned by 30 and dives by 20 degrees comes out where
/// the drift says, with the second moments of the closed form: cov = D_e / (D_zz q) (z0 + z_e / (1 + q z_e)).
#[test]
#[ignore = "long"]
fn turned_fibres_have_the_moments_of_the_closed_form() {
    let mu_a = 0.6;
    let up = uniaxial(1.0 / 6.0, 0.05, fibre(30.0, 20.0));
    let slanted = diffusive(&medium(0.6, 2.0, 10.0, fibre(30.0, 20.0)));
    // A tensor of our own, the same map of depth as in the grid: z down.
    let flip = DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
    assert!(
        (slanted.drift() - DVec2::new(slanted.d.z_axis.x, slanted.d.z_axis.y) / slanted.d.z_axis.z).length() < 1e-12
    );
    let dzz = up.z_axis.z;
    let cross = up.z_axis.truncate();
    let (ze, q) = (2.0 * boundary_factor(1.2) * dzz, (mu_a / dzz).sqrt());
    let mut errors = Vec::new();
    for (pitch, half, deep, level) in [(0.1, 30usize, 24, 1), (0.06, 50, 40, 2)] {
        let n = 2 * half + 1;
        let voxels = block([n, n, deep], pitch, mu_a, flip * up * flip);
        let mut source = vec![0.0; voxels.count()];
        source[voxels.place([half, half, level])] = 1.0;
        let solution = solve(&voxels, source, 1e-9, 1000);
        let exits = voxels.exits(&solution.phi);
        let place = |i: usize| DVec2::new((i / n) as f64 - half as f64, (i % n) as f64 - half as f64) * pitch;
        let total: f64 = exits.iter().sum();
        let mean: DVec2 = exits.iter().enumerate().map(|(i, e)| place(i) * (e / total)).sum();
        let second = exits.iter().enumerate().fold([0.0; 3], |sum, (i, e)| {
            let p = place(i) - mean;
            [sum[0] + p.x * p.x * e / total, sum[1] + p.x * p.y * e / total, sum[2] + p.y * p.y * e / total]
        });
        let z0 = (level as f64 + 0.5) * pitch;
        let scale = (z0 + ze / (1.0 + q * ze)) / (dzz * q);
        let sheared = [
            up.x_axis.x - cross.x * cross.x / dzz,
            up.x_axis.y - cross.x * cross.y / dzz,
            up.y_axis.y - cross.y * cross.y / dzz,
        ];
        let drift = cross * (z0 / dzz);
        let off = (mean - drift).length();
        let worst = (0..3).map(|i| (second[i] / (scale * sheared[i]) - 1.0).abs()).fold(0.0, f64::max);
        println!("pitch {pitch}: mean {mean} of {drift}, moments {second:?} of {:?}", sheared.map(|v| v * scale));
        let reflected = (-q * z0).exp() / (1.0 + q * ze);
        println!("R {total} of {reflected}, {} steps", solution.iterations);
        errors.push((worst, off, (total / reflected - 1.0).abs()));
    }
    println!("{errors:?}");
    assert!(errors[0].0 < 0.05 && errors[0].1 < 0.01 && errors[0].2 < 0.01, "{errors:?}");
    assert!(errors[1].0 < 0.02 && errors[1].1 < 0.004 && errors[1].2 < 0.004, "{errors:?}");
}

/// Whether [`motley`] has no matter: a hole in the middle and a missing corner.
fn hollow([i, j, k]: [usize; 3]) -> bool {
    i < 3 && j < 4 || (i == 9 && j == 9 && k > 3)
}

/// Voxels of unlike media with slanted fibres.
fn motley(shape: [usize; 3]) -> Voxels {
    let matter = |[i, j, k]: [usize; 3]| {
        if hollow([i, j, k]) {
            return None;
        }
        let hash = ((i / 3) * 7 + (j / 4) * 13 + (k / 2) * 29) as f64;
        let d = uniaxial(0.2 + 0.1 * (hash * 0.7).sin(), 0.04, fibre(hash * 40.0, hash * 23.0));
        Some(Voxel {
            mu_a: 0.3 + 0.25 * (hash * 1.3).sin(),
            d,
            leak: 0.5 / boundary_factor(1.1 + 0.4 * (hash * 0.3).sin().abs()),
        })
    };
    Voxels::new(shape, 0.1, matter, |i, _| 1.0 + 0.01 * i as f64)
}

/// Purpose: in = out + absorbed, and light from a to b is light from b to a, in a mixture of everything.
#[test]
fn energy_closes_and_light_is_reciprocal_in_unlike_media() {
    let voxels = motley([40, 23, 12]);
    let (a, b) = (voxels.place([8, 5, 1]), voxels.place([29, 17, 6]));
    let from = |place: usize| {
        let mut source = vec![0.0; voxels.count()];
        source[place] = 1.0;
        let solution = solve(&voxels, source, 1e-13, 2000);
        assert!(solution.residual < 1e-13, "{} after {}", solution.residual, solution.iterations);
        solution.phi
    };
    let (one, two) = (from(a), from(b));
    assert!((one[b] / two[a] - 1.0).abs() < 1e-8, "{} against {}", one[b], two[a]);
    for phi in [&one, &two] {
        let sum = voxels.exits(phi).iter().sum::<f64>() + voxels.drained(phi) + voxels.absorbed(phi);
        assert!((sum - 1.0).abs() < 1e-10, "energy {sum}");
    }
    // The operator itself, on patterns that excite everything, and its positive definiteness.
    let pattern = |seed: f64| -> Vec<f64> {
        let [_, ny, nz] = voxels.shape;
        let holds = |c: usize| !hollow([c / (ny * nz), c % ny, c / ny % nz]);
        (0..voxels.count()).map(|c| if holds(c) { (c as f64 * seed).sin() } else { 0.0 }).collect()
    };
    let (u, v) = (pattern(0.37), pattern(1.91));
    let product = |a: &[f64], b: &[f64]| {
        let mut image = vec![0.0; a.len()];
        voxels.apply(b, &mut image);
        a.iter().zip(&image).map(|(a, b)| a * b).sum::<f64>()
    };
    let scale = product(&u, &u);
    assert!(scale > 0.0 && product(&v, &v) > 0.0);
    assert!((product(&u, &v) - product(&v, &u)).abs() < 1e-12 * scale);
}

/// Purpose: the same bits for any number of threads.
#[test]
fn threads_change_nothing() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let voxels = motley([50, 20, 10]);
            let mut source = vec![0.0; voxels.count()];
            source[voxels.place([25, 10, 1])] = 1.0;
            let solution = solve(&voxels, source, 1e-8, 500);
            (voxels.exits(&solution.phi), solution)
        })
    };
    assert!(run(1) == run(2) && run(1) == run(7));
}

/// Purpose: across a border of unlike media the flux goes on: without absorption all light of a sealed column leaves at
/// the top, and the fluence is a straight line in each medium, with its kink on the border.
#[test]
fn flux_goes_on_across_a_border() {
    let (h, leak) = (0.1, 0.5 / boundary_factor(1.4));
    let d = |k: usize| if k < 5 { 0.25 } else { 0.02 };
    let matter = |[_, _, k]: [usize; 3]| Some(Voxel { mu_a: 0.0, d: DMat3::from_diagonal(DVec3::splat(d(k))), leak });
    let voxels = Voxels::new([3, 2, 12], h, matter, |_, _| 1.0);
    let mut source = vec![0.0; voxels.count()];
    (0..3).for_each(|i| (0..2).for_each(|j| source[voxels.place([i, j, 11])] = h * h));
    let phi = solve(&voxels, source, 1e-12, 500).phi;
    for k in 0..12 {
        let depth = (k as f64 + 0.5) * h;
        let expected = 1.0 / leak + depth.min(0.5) / 0.25 + (depth - 0.5).max(0.0) / 0.02;
        let value = phi[voxels.place([1, 1, k])];
        // Coefficients are f32.
        assert!((value / expected - 1.0).abs() < 1e-6, "voxel {k}: {value} against {expected}");
    }
}

/// Purpose: a tilted plate is a plate: the answer is the closed form for light that comes in at the angle of the tilt.
#[test]
fn slopes_cost_no_staircase() {
    let medium = medium(0.5, 8.0, 0.0, DVec3::Y);
    let d = diffusive(&medium);
    let x: Vec<f32> = (0..10).map(|i| i as f32 * 0.1 - 0.45).collect();
    let power = [0.1f32; 10];
    for slopes in [(0.0, 0.0), (0.5, 0.0), (0.3, -0.4)] {
        let body = plate(medium, slopes.0, slopes.1);
        let settings = DiffusionSettings::new(0.05);
        let (_, balance) = line_response_with_balance(&line(&body, &x, &power), &settings);
        let sine2 = 1.0 - 1.0 / (1.0 + f64::from(slopes.0 * slopes.0 + slopes.1 * slopes.1));
        let z0 = (1.0 - sine2 / 1.44).sqrt() / 8.0;
        let (q, ze) = ((0.5 / d.d.z_axis.z).sqrt(), 2.0 * boundary_factor(1.2) * d.d.z_axis.z);
        let expected = (-q * z0).exp() / (1.0 + q * ze);
        println!("slopes {slopes:?}: {} against {expected}", balance.left);
        assert!((balance.left - expected).abs() < 2e-3, "slopes {slopes:?}: {} against {expected}", balance.left);
        assert!((balance.left + balance.lost + balance.absorbed - 1.0).abs() < 1e-5, "{balance:?}");
    }
}

/// Purpose: fibres that dive, and surfaces that slope, shift the glow by persistence less drift, as
/// docs/theory/physics.md says.
#[test]
fn diving_fibres_shift_the_glow() {
    let x: Vec<f32> = (0..10).map(|i| i as f32 * 0.1 - 0.45).collect();
    let power = [0.1f32; 10];
    for (dive, slope) in [(15.0, 0.0), (50.0, 0.0), (10.0, 0.1)] {
        let medium = medium(0.6, 4.0, 20.0, fibre(0.0, dive));
        let body = plate(medium, 0.0, slope);
        // The closed form in the frame of the surface; along a slope y is shorter by its cosine, and so is the shift.
        let tilt = f64::from(slope).atan();
        let into = glam::DMat3::from_rotation_x(-tilt);
        let inside = (tilt.sin() / 1.2).asin();
        let local = Medium { fibre: (into * medium.fibre.as_dvec3()).as_vec3(), ..medium };
        let own = diffusive(&local);
        let h = own.persistence(DVec3::new(0.0, -inside.sin(), -inside.cos()));
        let along = h.y - h.z * own.drift().y;
        // What begins deeper comes out lower on the slope: nothing else than the cosine in plan.
        let expected = along * tilt.cos();
        // The source in the middle of a voxel: shared between two, it would favour the shallower one.
        let pitch = -h.z / tilt.cos() / 1.5;
        let line = LineSource { rows: 40, ..line(&body, &x, &power) };
        let (response, balance) = line_response_with_balance(&line, &DiffusionSettings::new(pitch));
        let rows = || response.light.chunks_exact(10).map(|light| light.iter().map(|&v| f64::from(v)).sum::<f64>());
        let mean = rows().enumerate().map(|(j, v)| v * (j as f64 - 40.0) * 0.1).sum::<f64>() / rows().sum::<f64>();
        println!("dive {dive} slope {slope}: {mean} against {expected}; {balance:?}");
        assert!((mean - expected).abs() < 5e-4, "dive {dive}, slope {slope}: {mean} against {expected}");
    }
}
