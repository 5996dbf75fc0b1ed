//! Exposure against the reference for every kind of laser, on level plates.

use crate::rays::light::{Across, Draw, Light, bowed, cylindrical, draws, gaussian, half_width, powell, slit};
use crate::rays::scenes::{Trial, matte, plane, scene};
use crate::rays::verdict::Verdict;
use base::Body;
use optical_bench::settings::{Fan, LineShape};
use procedural::flat::Flat;
use recipe::Scene;

/// A level plate 20 mm high.
fn plate<'a>(name: &'a str, scene: &'a Scene, first_col: usize, cols: usize, rays: usize) -> Trial<'a> {
    let medium = matte(0.6);
    let flat = Flat { height_mm: 20.0, slope_x: 0.0, slope_y: 0.0, width_mm: 400.0, length_mm: 400.0, medium };
    Trial {
        name,
        scene,
        body: Body::new(flat),
        profile: 200,
        facets: plane(20.0, [0.0; 2], 0.6),
        heights: [20.0; 2],
        first_col,
        cols,
        rays,
    }
}

/// The comparison under a laser made from the scene's and the range of its fan that is judged.
fn under(trial: &Trial<'_>, make: impl Fn([f64; 2]) -> Light) -> Verdict {
    let eye = trial.eye();
    trial.compare_under(&make(trial.tans(&eye)), &eye)
}

/// A fan with a hot spot, in its middle and on its flank.
#[test]
fn a_cylindrical_lens() {
    let mut scene = scene(2560);
    scene.line.fan = Fan::Cylindrical;
    scene.bench.laser.fan_angle_deg = 30.0;
    let laser = scene.bench.laser;
    for (name, first_col) in [("cylindrical lens, middle", 1280), ("cylindrical lens, x = 79 mm", 2176)] {
        let trial = plate(name, &scene, first_col, 64, 2_000_000);
        under(&trial, |tans| Light::new(&laser, tans, cylindrical(&laser), gaussian(&laser))).hold(|_| true);
    }
}

/// An even line with hard edges, as wide as seven rows.
#[test]
fn a_slit() {
    let mut scene = scene(256);
    scene.line.shape = LineShape::Slit;
    scene.bench.laser.line_width_mm = 0.7;
    let laser = scene.bench.laser;
    let wide = |tans| {
        let draws = vec![Draw { share: 1.0, centre: 0.0, sigma: 0.3 }];
        Light::new(&laser, tans, powell(&laser), slit(&laser, laser.line_width_mm)).drawn(draws)
    };
    under(&plate("slit of 0.7 mm", &scene, 96, 64, 4_000_000), wide).hold(|_| true);
}

/// The picture of a line that a projector throws: three pixels wide, blurred by five, 61 rows over the extent of the
/// key.
#[test]
fn a_texture() {
    let mut scene = scene(256);
    scene.line.shape = LineShape::Texture;
    let laser = scene.bench.laser;
    let pixel = laser.texture_width_mm / 61.0;
    let height = laser.fan_height_mm;
    let across: fn(f64) -> f64 = |rows| {
        let edge = |d: f64| libm::erf(d / 5.0 / std::f64::consts::SQRT_2);
        edge(rows + 1.5) - edge(rows - 1.5)
    };
    // Rows are even squares of the picture; what lies beyond the 61 is cut.
    let sum: f64 = (-30..=30).map(|i| across(f64::from(i))).sum();
    let section = move |near: f64| -> Across {
        Box::new(move |y, tan, rho| {
            let depth = rho / (1.0 + tan * tan).sqrt();
            let pitch = pixel * near * depth / height;
            let row = (y / pitch).round();
            if row.abs() > 30.0 { 0.0 } else { across(row) / sum / pitch }
        })
    };
    // The picture is as even along as a Powell lens's line, and as long as its key says.
    let half = 0.5 * laser.texture_length_mm / height;
    let projector = |tans| {
        let along = Box::new(move |tan: f64| (1.0 + tan * tan) / (2.0 * half));
        Light::new(&laser, tans, along, section(1.0)).drawn(draws(0.0, 5.2 * pixel))
    };
    under(&plate("texture", &scene, 96, 64, 3_000_000), projector).hold(|_| true);
}

/// A round spot on its way along the line.
#[test]
fn a_point() {
    let mut scene = scene(2560);
    scene.line.shape = LineShape::Point;
    let bench = &mut scene.bench.laser;
    (bench.waist_mm, bench.waist_height_mm, bench.point_span_mm, bench.power_mw) = (0.5, 0.0, 100.0, 1.0);
    bench.point_x_mm = 63.03;
    bench.point_step_mm = 0.0;
    let laser = scene.bench.laser;
    // It stands over the conveyor where the key says, and comes from the fan's source.
    let aim = 63.03 / laser.fan_height_mm;
    let spot = |_: [f64; 2]| {
        let w = half_width(&laser, laser.fan_height_mm - 20.0);
        let reach = 2.5 * w / (laser.fan_height_mm - 20.0);
        let across: Across = Box::new(move |y, tan, rho| {
            let w = half_width(&laser, rho);
            // The distance from the pencil's axis in the plane of the fan; rho makes up for the share along the fan, 1
            // / rho.
            let off = rho * (tan.atan() - aim.atan()).sin();
            2.0 / (std::f64::consts::PI * w * w) * (-2.0 * (off * off + y * y) / (w * w)).exp() * rho
        });
        Light::new(&laser, [aim - reach, aim + reach], Box::new(|_| 1.0), across).drawn(draws(0.0, 0.5 * w))
    };
    under(&plate("point, x = 60 mm", &scene, 1943, 32, 1_500_000), spot).hold(|_| true);
}

/// A second line with a third of the light, a millimetre behind the first.
#[test]
fn two_lines() {
    let mut scene = scene(256);
    let laser = &mut scene.bench.laser;
    (laser.second_line_mm, laser.second_line_share) = (1.0, 0.25);
    let laser = scene.bench.laser;
    let both = |tans| {
        let (one, other) = (gaussian(&laser), gaussian(&laser));
        let across: Across = Box::new(move |y, tan, rho| 0.75 * one(y, tan, rho) + 0.25 * other(y - 1.0, tan, rho));
        let sigma = 0.5 * half_width(&laser, laser.fan_height_mm - 20.0);
        let halve = |centre: f64| draws(centre, sigma).into_iter().map(|d| Draw { share: 0.5 * d.share, ..d });
        Light::new(&laser, tans, powell(&laser), across).drawn(halve(0.0).chain(halve(1.0)).collect())
    };
    under(&plate("two lines", &scene, 96, 64, 4_000_000), both).hold(|_| true);
}

/// A line that bows by 0.4 mm at the end of the fan, quadratic and cubic.
#[test]
fn smile() {
    let mut scene = scene(2560);
    let laser = &mut scene.bench.laser;
    (laser.smile_um, laser.smile_cubic_um) = (400.0, -150.0);
    let laser = scene.bench.laser;
    for (name, first_col) in [("smile, x = 105 mm", 2432), ("smile, x = -100 mm", 128)] {
        let trial = plate(name, &scene, first_col, 64, 2_000_000);
        let bent = |tans: [f64; 2]| {
            let across = bowed(&laser, gaussian(&laser), |side| 0.4 * side * side - 0.15 * side * side * side);
            let side = 0.5 * (tans[0] + tans[1]) / (0.5 * laser.fan_angle_deg).to_radians().tan();
            let centre = 0.4 * side * side - 0.15 * side * side * side;
            let sigma = 0.5 * half_width(&laser, laser.fan_height_mm + 10.0);
            Light::new(&laser, tans, powell(&laser), across).drawn(draws(0.95 * centre, 1.5 * sigma))
        };
        under(&trial, bent).hold(|_| true);
    }
}

/// Lobes and a skirt beside the line.
#[test]
fn lobes_and_skirt() {
    let mut scene = scene(256);
    let laser = &mut scene.bench.laser;
    (laser.lobe_share, laser.lobe_distance, laser.lobe_pairs) = (0.1, 4.0, 1.0);
    (laser.skirt_share, laser.skirt_width) = (0.1, 8.0);
    let laser = scene.bench.laser;
    let flawed = |tans| {
        let across: Across = Box::new(move |y, _, rho| {
            let w = half_width(&laser, rho);
            let line = |y: f64| (2.0 / std::f64::consts::PI).sqrt() / w * (-2.0 * y * y / (w * w)).exp();
            // A Moffat halo (1 + r^2 / a^2)^-2 seen across a line; half of its height lies at 8 w / 2.
            let a = 0.5 * 8.0 * w / (0.5f64.powf(-2.0 / 3.0) - 1.0).sqrt();
            let skirt = 0.5 / a * (1.0 + (y / a).powi(2)).powf(-1.5);
            0.8 * line(y) + 0.05 * (line(y - 4.0 * w) + line(y + 4.0 * w)) + 0.1 * skirt
        });
        let sigma = 0.5 * half_width(&laser, laser.fan_height_mm - 20.0);
        let laws = [(0.6, 0.0, 1.1), (0.1, 8.0, 1.1), (0.1, -8.0, 1.1), (0.2, 0.0, 10.0)];
        let laws = laws.map(|(share, centre, wide)| Draw { share, centre: centre * sigma, sigma: wide * sigma });
        Light::new(&laser, tans, powell(&laser), across).drawn(laws.to_vec())
    };
    under(&plate("lobes and skirt", &scene, 96, 64, 4_000_000), flawed).hold(|_| true);
}
