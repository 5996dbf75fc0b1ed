//! Every number of the bench and every setting of the extraction changes what comes out, one by one.

use base::Parameter;
use dataset::record::Record;
use optical_bench::parameters::{Bench, CameraParameters, ExposureParameters, MotionParameters, SpeckleParameters};
use optical_bench::settings::{
    Filter, LensModel, Movement, Optics, PeakChoice, PeakMethod, RangeForm, ScatterDark, ScatterMode, Scheimpflug,
    SearchDirection,
};
use recipe::{Plan, Scene};
use test_support::target::{nominal, patterns, scene};

fn render(scene: &Scene) -> Record {
    pipeline::render(scene, patterns(), &|_| ())
}

/// A small scene of the nominal bench whose laser stands out of its waist, so that beam quality counts.
fn base() -> Scene {
    let mut scene = scene(48);
    scene.size.columns = 128;
    if let Plan::Wood(wood) = &mut scene.plan {
        (wood.board.lead_in_mm, wood.board.width_mm) = (0.5, 8.0);
    }
    scene.bench.laser.waist_height_mm = 0.0;
    scene.bench = wobbling(scene.bench);
    scene
}

/// A bench whose wheel runs out of true, so that its period has an effect, and whose turntable would have the board
/// under the line.
fn wobbling(mut bench: Bench) -> Bench {
    if bench.motion.turn_axis_y_mm == 0.0 {
        bench.motion.turn_axis_y_mm = 10.0;
    }
    if bench.motion.wow_um == 0.0 {
        bench.motion.wow_um = 40.0;
    }
    bench
}

/// The scene that wakes a number up: a long exposure for dark current, an overfull one for blooming, a laser at the
/// edge of the filter's band for its width.
fn waking(scene: &mut Scene, name: &str) {
    let exposure = &mut scene.bench.exposure;
    match name {
        "dark_current_e_per_s" => (exposure.time_us, scene.bench.laser.power_mw) = (1e5, 0.02),
        "blooming" => exposure.time_us = 400.0,
        "filter_width_nm" => scene.bench.camera.filter_centre_nm = 645.0,
        _ => {}
    }
}

/// The nominal bench with one number changed: a quarter of its range up, or down where that leaves it.
fn changed(parameter: &'static Parameter) -> Bench {
    let old = nominal_with(&mut |p| p.default);
    let default = parameter.default;
    let step = (0.25 * default.abs()).max(0.05 * (parameter.max - parameter.min).min(4.0));
    let new = if default + step <= parameter.max { default + step } else { default - step };
    let new = if parameter.integer { new.round().max(default + 1.0) } else { new };
    let bench = nominal_with(&mut |p| if p == parameter { new } else { p.default });
    assert_ne!(old, bench, "{}: the change did not arrive", parameter.path());
    bench
}

fn nominal_with(value: &mut dyn FnMut(&'static Parameter) -> f64) -> Bench {
    Bench::from_values(value, optical_bench::settings::Optics::default())
}

/// The scene in which a number of the camera or of the movement is awake: beside the setting that asks for it, or with
/// a field as wide as what it does.
fn awake(parameter: &Parameter) -> Scene {
    let mut scene = base();
    match parameter.name {
        "sensor_tilt_deg" | "focus_distance_mm" => scene.bench.optics.scheimpflug = Scheimpflug::Given,
        "filter_centre_nm" | "filter_width_nm" => scene.bench.optics.filter = Filter::BandPass,
        name if name.starts_with("turn_") => scene.movement = Movement::Turntable,
        name if name.starts_with("distortion") => {
            (scene.size.columns, scene.size.profiles) = (2560, 16);
            if let Plan::Wood(wood) = &mut scene.plan {
                wood.board.width_mm = 220.0;
            }
        }
        _ => {}
    }
    scene
}

#[test]
fn every_number_of_the_bench_has_an_effect() {
    assert_eq!(nominal(), nominal_with(&mut |p| p.default));
    let base = base();
    let usual = render(&base);
    // The laser's: tests/optics/laser_keys.rs.
    let tables = [
        MotionParameters::PARAMETERS,
        CameraParameters::PARAMETERS,
        ExposureParameters::PARAMETERS,
        SpeckleParameters::PARAMETERS,
    ];
    let mut idle = Vec::new();
    for parameter in tables.into_iter().flatten() {
        let mut scene = awake(parameter);
        waking(&mut scene, parameter.name);
        let own = (scene != base).then(|| render(&scene));
        let plain = own.as_ref().unwrap_or(&usual);
        let (waist_height, optics) = (scene.bench.laser.waist_height_mm, scene.bench.optics);
        scene.bench = wobbling(Bench { optics, ..changed(parameter) });
        if parameter.name == "line_rate_hz" {
            scene.bench.motion.line_rate_hz = 20_000.0;
        }
        if parameter.name != "waist_height_mm" {
            scene.bench.laser.waist_height_mm = waist_height;
        }
        waking(&mut scene, parameter.name);
        let record = render(&scene);
        if same(&record, plain) {
            idle.push(parameter.path());
        }
    }
    assert!(idle.is_empty(), "numbers without effect: {idle:?}");
}

/// Whether two records measure the same.
fn same(a: &Record, b: &Record) -> bool {
    let same = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| a == b || (a.is_nan() && b.is_nan()));
    let maps = |record: &Record| {
        let maps = &record.maps;
        [maps.range.clone(), maps.reflectance.clone(), maps.scatter.clone()]
    };
    maps(a).iter().zip(&maps(b)).all(|(a, b)| same(a, b))
}

#[test]
fn every_setting_of_the_camera_has_an_effect() {
    let base = base();
    let mut given = base.clone();
    given.bench.optics.scheimpflug = Scheimpflug::Given;
    type Change = fn(&mut Optics);
    let changes: [(&str, &Scene, Change); 6] = [
        ("scheimpflug", &base, |o| o.scheimpflug = Scheimpflug::Given),
        ("lens", &given, |o| o.lens = LensModel::Pinhole),
        ("filter", &base, |o| o.filter = Filter::BandPass),
        ("diffraction", &base, |o| o.diffraction = false),
        ("offset_columns", &base, |o| o.offset_columns = 10.0),
        ("offset_rows", &base, |o| o.offset_rows = 10.5),
    ];
    for (name, of, change) in changes {
        let mut scene = of.clone();
        change(&mut scene.bench.optics);
        if name == "filter" {
            // A laser beside the filter's middle.
            scene.bench.camera.filter_centre_nm = 648.0;
        }
        assert!(!same(&render(of), &render(&scene)), "camera.{name} has no effect");
    }
}

#[test]
fn every_setting_of_the_extraction_has_an_effect() {
    let base = base();
    let plain = render(&base);
    type Change = fn(&mut optical_bench::settings::Extraction);
    type Map = fn(&Record) -> &Vec<f32>;
    let changes: [(&str, Change, Map); 16] = [
        ("method parabola", |e| e.method = PeakMethod::Parabola, |r| &r.maps.range),
        ("method gaussian", |e| e.method = PeakMethod::Gaussian, |r| &r.maps.range),
        ("method blais_rioux", |e| e.method = PeakMethod::BlaisRioux { order: 4 }, |r| &r.maps.range),
        ("method fir", |e| e.method = PeakMethod::Fir { length: 5 }, |r| &r.maps.range),
        ("peak first", |e| e.peak = PeakChoice::First, |r| &r.maps.range),
        ("scatter_dark", |e| e.scatter_dark = ScatterDark::Subtracted, |r| &r.maps.scatter),
        ("range uncalibrated", |e| e.range = RangeForm::Uncalibrated, |r| &r.maps.range),
        ("range rectified", |e| e.range = RangeForm::Rectified { pitch_mm: None }, |r| &r.maps.range),
        ("rectified_pitch_mm", |e| e.range = RangeForm::Rectified { pitch_mm: Some(0.15) }, |r| &r.maps.reflectance),
        ("window_rows", |e| e.window_rows = 3, |r| &r.maps.range),
        ("threshold_dn", |e| e.threshold_dn = 120.0, |r| &r.maps.reflectance),
        ("subpixel_steps", |e| e.subpixel_steps = 2, |r| &r.maps.range),
        ("scatter_mode front", |e| e.scatter_mode = ScatterMode::Front, |r| &r.maps.scatter),
        ("scatter_mode back", |e| e.scatter_mode = ScatterMode::Back, |r| &r.maps.scatter),
        ("scatter_offset_rows", |e| e.scatter_offset_rows = 3, |r| &r.maps.scatter),
        ("scatter_width_rows", |e| e.scatter_width_rows = 4, |r| &r.maps.scatter),
    ];
    for (name, change, map) in changes {
        let mut scene = base.clone();
        change(&mut scene.extraction);
        let record = render(&scene);
        let differ =
            map(&record).iter().zip(map(&plain)).filter(|(a, b)| a != b && !(a.is_nan() && b.is_nan())).count();
        assert!(differ > 100, "{name}: {differ} pixels changed");
    }
    // Settings that have an effect beside another one.
    let pairs: [(&str, Change, Change); 4] = [
        (
            "direction",
            |e| e.peak = PeakChoice::First,
            |e| (e.peak, e.direction) = (PeakChoice::First, SearchDirection::Reverse),
        ),
        (
            "blais_rioux_order",
            |e| e.method = PeakMethod::BlaisRioux { order: 2 },
            |e| e.method = PeakMethod::BlaisRioux { order: 8 },
        ),
        ("fir_length", |e| e.method = PeakMethod::Fir { length: 3 }, |e| e.method = PeakMethod::Fir { length: 9 }),
        (
            "rectified_pitch_mm",
            |e| e.range = RangeForm::Rectified { pitch_mm: None },
            |e| e.range = RangeForm::Rectified { pitch_mm: Some(0.1) },
        ),
    ];
    for (name, one, other) in pairs {
        let [one, other] = [one, other].map(|change| {
            let mut scene = base.clone();
            change(&mut scene.extraction);
            render(&scene).maps.range
        });
        let differ = one.iter().zip(&other).filter(|(a, b)| a != b && !(a.is_nan() && b.is_nan())).count();
        assert!(differ > 100, "{name}: {differ} pixels changed");
    }
    // Front and back are the two sides: together they are the symmetric sum.
    let side = |mode: ScatterMode| {
        let mut scene = base.clone();
        scene.extraction.scatter_mode = mode;
        render(&scene).maps.scatter
    };
    let (front, back) = (side(ScatterMode::Front), side(ScatterMode::Back));
    assert!(plain.maps.scatter.iter().zip(front.iter().zip(&back)).all(|(s, (f, b))| *s == f + b));
}
