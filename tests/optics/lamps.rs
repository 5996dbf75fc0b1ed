//! The map `grey` under lamps: slopes, shadows, albedo, spread and noise against closed forms, whatever the bands.

use base::{Body, BodyKind, Class, Gloss, Matter, Medium, Mesh, Slice, Surface};
use dataset::record::AskedRows;
use glam::Vec3;
use optical_bench::settings::Lamps;
use pipeline::{derived, render_profiles, set_up};
use recipe::Scene;
use test_support::target::{moments, patterns, plate, render, scene};
use transport::kernel::{BASIS, SPREAD_MM, SpreadRow, SurfacePoint, WidthShares, gaussians, line_spread};

/// A plate that changes its height and its matter at one place of the scan.
#[derive(Debug)]
struct Halves {
    edge_mm: f32,
    heights: [f32; 2],
    media: [Medium; 2],
}

#[derive(Debug)]
struct HalvesSlice<'a>(&'a Halves, usize);

impl BodyKind for Halves {
    fn slice(&self, y: f32) -> Box<dyn Slice + '_> {
        Box::new(HalvesSlice(self, usize::from(y >= self.edge_mm)))
    }

    fn hull(&self) -> Mesh {
        Mesh::default()
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        (Vec3::new(-200.0, -50.0, 0.0), Vec3::new(200.0, 400.0, self.heights[0].max(self.heights[1])))
    }
}

impl Slice for HalvesSlice<'_> {
    fn surface(&self, _: f32) -> Option<Surface> {
        Some(Surface { z: self.0.heights[self.1], slope_x: 0.0, slope_y: 0.0 })
    }

    fn matter(&self, _: f32, _: f32) -> Matter {
        Matter { medium: self.0.media[self.1], film: None, class: Class::Clear, instance: 0 }
    }
}

/// A level plate without an end.
fn endless(medium: Medium) -> Body {
    Body::new(Halves { edge_mm: 0.0, heights: [20.0; 2], media: [medium; 2] })
}

/// White paint that nothing enters.
fn paint() -> Medium {
    Medium::opaque(Gloss { matte: 1.0, ..Gloss::NONE })
}

/// Matter that throws nothing back itself.
fn matter(mu_a: f32) -> Medium {
    Medium { mu_a, ..Medium::CLEAR_WOOD }
}

/// A scene of 12 bits with one narrow lamp, without noise and blur.
fn lamplit(profiles: usize) -> Scene {
    let mut scene = scene(profiles);
    scene.bench.optics.lamps = Lamps::One;
    scene.readout.bits = 12;
    scene.output.bits = 12;
    let lamps = &mut scene.bench.lamps;
    (lamps.fill, lamps.width_deg, lamps.blur_mm, lamps.white_dn) = (0.0, 1.0, 0.0, 150.0);
    (lamps.dark_level_dn, lamps.dark_noise_dn, lamps.full_well_e) = (0.0, 0.0, 1e6);
    scene
}

/// Radiance by row, 1 for white, and the whole map.
fn rows(scene: &Scene, body: Body) -> Vec<f64> {
    let white = scene.bench.lamps.white_dn * scene.readout.scale();
    let columns = scene.size.columns;
    let grey = render(scene, body).maps.grey;
    grey.chunks(columns).map(|row| moments(row.iter().map(|&dn| f64::from(dn) / white)).0).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Cosine of the angle between normal and lamp, over that of a level surface; half of the sky where the lamp is none.
#[test]
fn slopes_shade_by_lamberts_law() {
    for slope in [-0.3f64, -0.1, 0.0, 0.2, 0.6] {
        for (tilt_deg, fill) in [(45.0, 0.0), (-30.0, 0.0), (60.0, 0.25), (20.0, 1.0)] {
            let mut scene = lamplit(8);
            (scene.bench.lamps.tilt_deg, scene.bench.lamps.fill) = (tilt_deg, fill);
            let got = mean(&rows(&scene, plate(paint(), 20.0, 0.0, slope as f32)));
            let up = 1.0 / slope.hypot(1.0);
            let lamp = up * (1.0 - slope * tilt_deg.to_radians().tan()).max(0.0);
            let expected = (1.0 - fill) * lamp + 0.5 * fill * (1.0 + up);
            assert!((got - expected).abs() < 0.003, "slope {slope} under {tilt_deg}: {got} for {expected}");
        }
    }
}

/// Two lamps share their light: from both sides a slope is as bright as its normal stands upright.
#[test]
fn two_lamps_share_their_light() {
    let mut scene = lamplit(8);
    scene.bench.optics.lamps = Lamps::Two;
    scene.bench.lamps.second_share = 0.5;
    let got = mean(&rows(&scene, plate(paint(), 20.0, 0.0, 0.4)));
    assert!((got - 1.0 / 1.16f64.sqrt()).abs() < 0.003, "{got}");
}

/// Behind a step of 0.6 mm a lamp at 45 degrees throws a shadow of 0.6 mm, a lamp on the other side none; light from
/// all sides is half hidden at the foot.
#[test]
fn a_step_throws_its_shadow() {
    let paints = [paint(), paint()];
    let mut scene = lamplit(40);
    let step = scene.bench.motion.step_mm;
    let edge_mm = 19.5 * step as f32;
    let body = |heights| Body::new(Halves { edge_mm, heights, media: paints });
    let shaded = rows(&scene, body([19.4, 20.0]));
    let dark = shaded.iter().take(20).filter(|light| **light < 0.5).count() as f64 * step;
    assert!((dark - 0.6).abs() < 1.5 * step, "shadow of {dark} mm: {shaded:?}");
    assert!(shaded[19] < 0.01 && (shaded[0] - 1.0).abs() < 0.003 && (shaded[25] - 1.0).abs() < 0.003);
    scene.bench.lamps.tilt_deg = -45.0;
    let open = rows(&scene, body([19.4, 20.0]));
    assert!(open.iter().all(|light| (light - 1.0).abs() < 0.003), "{open:?}");
    scene.bench.lamps.fill = 1.0;
    let even = rows(&scene, body([19.4, 20.0]));
    assert!(even[19] > 0.45 && even[19] < 0.6 && (even[30] - 1.0).abs() < 0.003, "{even:?}");
}

/// Diffuse reflectance of level matter is the kernel's; at another wavelength that of matter absorbing otherwise.
#[test]
fn level_matter_shows_its_albedo() {
    for mu_a in [0.02f32, 0.08, 0.5] {
        let scene = lamplit(8);
        let got = mean(&rows(&scene, endless(matter(mu_a))));
        let expected: f64 = spread_of(mu_a).iter().sum();
        println!("absorption {mu_a}: {got:.4} for {expected:.4}");
        assert!((got / expected - 1.0).abs() < 0.005, "absorption {mu_a}: {got} for {expected}");
        let mut other = scene.clone();
        other.bench.lamps.wavelength_nm = 660.0 - 110.0 * std::f64::consts::LN_2;
        let darker = mean(&rows(&other, endless(matter(mu_a))));
        let as_dark = mean(&rows(&scene, endless(matter(2.0 * mu_a))));
        assert!((darker / as_dark - 1.0).abs() < 0.005, "{darker} for {as_dark}");
    }
}

/// Weights of the fixed widths of level clear wood that absorbs so, the widest with all that is wider.
fn spread_of(mu_a: f32) -> [f64; BASIS] {
    let wood = matter(mu_a);
    let point = SurfacePoint {
        mu_a,
        sigma_i: wood.sigma_i,
        k: wood.k,
        n: wood.n_eff,
        dispersion_deg: wood.dispersion_deg,
        enter: 1.0 - ((wood.n_eff - 1.0) / (wood.n_eff + 1.0)).powi(2),
        ..SurfacePoint::BLACK
    };
    let tilt = 25.0f32.to_radians();
    let point = point.facing(wood.fibre, Vec3::Z, Vec3::NEG_Z, Vec3::new(0.0, -tilt.sin(), tilt.cos()));
    let mut spread = SpreadRow::new(1);
    line_spread(&[point], &[0], &WidthShares::new(SPREAD_MM), None, &mut spread);
    let mut weights: [f64; BASIS] = std::array::from_fn(|j| f64::from(spread.enter[j][0]).powi(2));
    let all: f64 = gaussians(&point).iter().map(|gaussian| gaussian.weight).sum();
    weights[BASIS - 1] += (all - weights.iter().sum::<f64>()).max(0.0);
    weights
}

/// Between light and dark wood the light goes over as the eight widths of the kernel have it, each media's weights
/// blended by their square roots: within 5 % of the lighter one.
#[test]
fn an_edge_is_as_soft_as_the_kernels_widths() {
    let media = [0.04f32, 0.6];
    let scene = lamplit(64);
    let step = scene.bench.motion.step_mm;
    let edge_mm = 31.5 * step;
    let body = Halves { edge_mm: edge_mm as f32, heights: [20.0; 2], media: media.map(matter) };
    let got = rows(&scene, Body::new(body));
    let weights = media.map(spread_of);
    let lightest: f64 = weights[0].iter().sum();
    let expected = |y: f64, own: usize| -> f64 {
        let width = |j: usize| {
            let [own, other] = [weights[own][j], weights[1 - own][j]];
            let sigma = f64::from(SPREAD_MM[j]);
            let beyond = if sigma == 0.0 { 0.0 } else { 0.5 * libm::erfc(y / (sigma * std::f64::consts::SQRT_2)) };
            own * (1.0 - beyond) + (own * other).sqrt() * beyond
        };
        (0..BASIS).map(width).sum()
    };
    let mut off = 0.0f64;
    for (row, light) in got.iter().enumerate() {
        let away = row as f64 * step - edge_mm;
        let expected = expected(away.abs(), usize::from(away > 0.0));
        println!("{away:.2} mm: {light:.4} for {expected:.4}");
        assert!(expected.is_finite(), "{away} mm");
        off = off.max((light - expected).abs() / lightest);
    }
    assert!(off < 0.05, "off by {off}");
}

/// Photon noise of the electrons that a number stands for, beside dark noise and rounding.
#[test]
fn noise_is_that_of_the_electrons() {
    for (white_dn, full_well_e, dark_noise_dn) in [(150.0, 4000.0, 0.0), (10.0, 15000.0, 2.0), (200.0, 12000.0, 1.0)] {
        let mut scene = lamplit(64);
        let lamps = &mut scene.bench.lamps;
        (lamps.white_dn, lamps.full_well_e, lamps.dark_noise_dn) = (white_dn, full_well_e, dark_noise_dn);
        lamps.dark_level_dn = 20.0;
        let grey = render(&scene, plate(paint(), 20.0, 0.0, 0.0)).maps.grey;
        let scale = scene.readout.scale();
        let (mean, sd) = moments(grey.iter().map(|&dn| f64::from(dn) / scale));
        let variance = white_dn * (255.0 - 20.0) / full_well_e + dark_noise_dn.powi(2) + 1.0 / (12.0 * scale * scale);
        // 16384 pixels: a standard error of 0.55 % of the deviation.
        assert!((mean - 20.0 - white_dn).abs() < 4.0 * (variance / 16384.0).sqrt(), "{mean} for {white_dn}");
        assert!((sd / variance.sqrt() - 1.0).abs() < 0.025, "{sd} for {}", variance.sqrt());
        let along: f64 =
            grey.chunks(256).map(|row| row.windows(2).map(|p| centred(p, mean * scale)).sum::<f64>()).sum();
        let correlation = along / (16384.0 * (sd * scale).powi(2));
        assert!(correlation.abs() < 4.0 / 128.0, "neighbours go together by {correlation}");
    }
}

fn centred(pair: &[f32], mean: f64) -> f64 {
    (f64::from(pair[0]) - mean) * (f64::from(pair[1]) - mean)
}

/// A board has the same grey whatever bands and threads render it, and where some rows alone are exposed again; nothing
/// else of it changes by the lamps.
#[test]
fn grey_depends_on_no_band() {
    let mut scene = scene(150);
    let dark = pipeline::render(&scene, patterns(), &|_| ());
    assert!(dark.maps.grey.is_empty());
    scene.bench.optics.lamps = Lamps::Two;
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| pipeline::render(&scene, patterns(), &|_| ()))
    };
    let [one, three] = [1, 3].map(on);
    assert!(bits(&one.maps.grey) == bits(&three.maps.grey), "by one thread and by three");
    assert_eq!((bits(&one.maps.range), &one.maps.reflectance), (bits(&dark.maps.range), &dark.maps.reflectance));
    assert_eq!((&one.maps.scatter, &one.labels), (&dark.maps.scatter, &dark.labels));
    let asked = AskedRows { strips: vec![0..1, 37..39, 77..78, 149..150], ..AskedRows::default() };
    for rows in derived(&scene, patterns(), &asked, &|_| ()).exposed {
        let from = rows.first * rows.cols;
        assert!(!rows.maps.grey.is_empty());
        let whole = &one.maps.grey[from..from + rows.maps.grey.len()];
        assert!(bits(&rows.maps.grey) == bits(whole), "rows from {} exposed again", rows.first);
    }
    let (sensor, specimen) = set_up(&scene, pipeline::body(&scene), patterns());
    let (sparse, _) = render_profiles(&scene, &sensor, &specimen, &[75]);
    let own = &one.maps.grey[75 * 256..76 * 256];
    let apart = sparse.grey.iter().zip(own).filter(|(a, b)| !a.is_nan() && !b.is_nan()).map(|(a, b)| (a - b).abs());
    let apart = moments(apart.map(f64::from)).0;
    assert!(apart < 4.0, "a look at one profile is {apart} DN off");
}

fn bits(map: &[f32]) -> Vec<u32> {
    map.iter().map(|v| v.to_bits()).collect()
}
