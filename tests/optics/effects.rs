//! Every number of the bench and every setting of the extraction changes what comes out, one by one.

use base::{Body, Gloss, Medium, Need, Parameter, Unmet};
use dataset::record::Record;
use optical_bench::parameters::{
    Bench, CameraParameters, ExposureParameters, LampParameters, LaserParameters, MotionParameters, SpeckleParameters,
};
use optical_bench::settings::{
    Filter, LensModel, Optics, PeakChoice, PeakMethod, RangeForm, ScatterDark, ScatterMode, Scheimpflug,
    SearchDirection,
};
use recipe::{Plan, Recipe, Scene};
use test_support::target::{patterns, plate, scene};

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
    scene
}

/// The bench with one number changed.
fn with(bench: &Bench, is_it: impl Fn(&Parameter) -> bool, change: impl Fn(&Parameter, f64) -> f64) -> Bench {
    let Bench { motion, laser, camera, exposure, speckle, lamps, optics } = bench;
    let [motion, laser, camera] = [motion.values(), laser.values(), camera.values()];
    let values = [motion, laser, camera, exposure.values(), speckle.values(), lamps.values()].concat();
    let old = |parameter: &Parameter| values.iter().find(|(known, _)| *known == parameter).expect("all of them").1;
    Bench::from_values(&mut |p| if is_it(p) { change(p, old(p)) } else { old(p) }, *optics)
}

/// A quarter of its value or a twentieth of its range more, or less where that leaves it.
fn changed(parameter: &Parameter, old: f64) -> f64 {
    let range = parameter.max - parameter.min;
    let step = if old == 0.0 { 0.05 * range } else { (0.25 * old.abs()).max(0.05 * range.min(4.0)) };
    let step = if parameter.integer { step.round().max(1.0) } else { step };
    if old + step <= parameter.max { old + step } else { old - step }
}

/// A scene, and a body in it, in which a number means something: beside the words and the amounts that it needs.
fn awake(parameter: &Parameter) -> (Scene, Body) {
    let needs = || parameter.conditions.iter().filter(|condition| condition.unmet != Unmet::Zero).map(|c| c.need);
    let word = |need| match need {
        Need::On(path, words) | Need::While(path, words) => Some(format!("\n  {path}: {}", words[0])),
        _ => None,
    };
    let words: String = needs().filter_map(word).collect();
    let text = format!("name: a\nsubject: wood\nunstated: fixed\nclasses: {{one: {{share: 1}}}}\nset:{words}\n");
    let asked = Recipe::parse("a.yaml", &text).unwrap_or_else(|error| panic!("{text}{error}")).draw(0, 0);
    let mut scene = base();
    (scene.line, scene.movement, scene.bench.optics) = (asked.line, asked.movement, asked.bench.optics);
    for need in needs() {
        if let Need::Amount(path) = need {
            let tenth = |p: &Parameter, old: f64| if old == 0.0 { 0.1 * p.max } else { old };
            scene.bench = with(&scene.bench, |p| p.path() == path, tenth);
        }
    }
    wake(&mut scene, parameter.name);
    let metal = Medium::opaque(Gloss { share: 1.0, reflectance: 0.9, roughness: [0.45; 2], matte: 0.0 });
    let shines = needs().any(|need| need == Need::Facets) || parameter.name.starts_with("glint");
    let body = if shines { plate(metal, 10.0, 0.0, 0.0) } else { pipeline::body(&scene) };
    (scene, body)
}

/// What wakes a number beside which its needs alone do not.
fn wake(scene: &mut Scene, name: &str) {
    let Bench { motion, laser, camera, exposure, lamps, .. } = &mut scene.bench;
    match name {
        // An overfull exposure, and a long one.
        "blooming" => exposure.time_us = 400.0,
        "dark_current_e_per_s" => (exposure.time_us, laser.power_mw) = (1e5, 0.02),
        // A laser at the edge of the filter's band.
        "filter_width_nm" => camera.filter_centre_nm = 645.0,
        // The fan's ends lie on the sensor.
        "fan_soft_ends" | "smile_um" | "smile_cubic_um" => laser.fan_angle_deg = 1.2,
        "point_x_mm" | "point_step_mm" | "point_span_mm" => (laser.power_mw, laser.point_span_mm) = (0.2, 3.0),
        "vibration_hz" => motion.line_rate_hz = 1000.0,
        // Modes that change within the scan.
        "mode_profiles" => (laser.mode_hop_um, laser.mode_profiles) = (100.0, 4.0),
        // Light that wood absorbs otherwise than the laser's.
        "absorption_decay_nm" => lamps.wavelength_nm = 550.0,
        // The board lies under the line.
        name if name.starts_with("turn_") => motion.turn_axis_y_mm = 10.0,
        // A field as wide as what distortion does.
        name if name.starts_with("distortion") => {
            (scene.size.columns, scene.size.profiles) = (2560, 16);
            if let Plan::Wood(wood) = &mut scene.plan {
                wood.board.width_mm = 220.0;
            }
        }
        _ => {}
    }
}

#[test]
fn every_number_of_the_bench_has_an_effect() {
    let tables = [
        MotionParameters::PARAMETERS,
        LaserParameters::PARAMETERS,
        CameraParameters::PARAMETERS,
        ExposureParameters::PARAMETERS,
        SpeckleParameters::PARAMETERS,
        LampParameters::PARAMETERS,
    ];
    let mut idle = Vec::new();
    for parameter in tables.into_iter().flatten() {
        let (scene, body) = awake(parameter);
        let mut other = scene.clone();
        other.bench = with(&scene.bench, |p| p == parameter, changed);
        assert_ne!(scene.bench, other.bench, "{}: the change did not arrive", parameter.path());
        let [plain, record] = [&scene, &other].map(|s| pipeline::render_body(s, body.clone(), patterns(), &|_| ()));
        if same(&record, &plain) {
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
        [maps.range.clone(), maps.reflectance.clone(), maps.scatter.clone(), maps.grey.clone()]
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
