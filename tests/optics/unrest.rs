//! Instruments that are not at rest, dust and glare: closed forms, and the same for a row alone as in a whole scan.

use std::f64::consts::TAU;

use base::{Class, Gloss, Medium, Stream};
use dataset::record::{AskedRows, Record};
use optical_bench::settings::{SensorStack, Transport};
use pipeline::Equipment;
use recipe::{Plan, Recipe, Scene};
use scanner::optics::{ROWS, Scratch, TILE};
use test_support::target::{expose, moments, patterns, plate, render, scene};

use crate::camera_motion::line;

/// Column that is looked at.
const COLUMN: usize = 64;
/// Photons of a profile where the Monte Carlo answers.
const PHOTONS: u64 = 10_000;

fn grey() -> Medium {
    Medium::opaque(Gloss { matte: 0.5, ..Gloss::NONE })
}

/// Light and row of the line on a level plate in each profile [e-], [px].
fn lines(scene: &Scene, column: usize) -> Vec<[f64; 2]> {
    let profiles = 0..scene.size.profiles;
    let (sensor, band) = expose(scene, plate(grey(), 10.0, 0.0, 0.0), profiles.clone());
    profiles.map(|profile| line(&sensor, &band, profile, column)[0]).collect()
}

/// The image swings as far as the camera sees of the lift, at its frequency, and is blurred between profiles.
#[test]
fn what_stands_under_the_instrument_swings() {
    let mut scene = scene(40);
    let motion = &mut scene.bench.motion;
    (motion.line_rate_hz, motion.vibration_um, motion.vibration_hz) = (1000.0, 50.0, 100.0);
    let (sensor, _) = expose(&scene, plate(grey(), 10.0, 0.0, 0.0), 0..1);
    let x = sensor.camera().rig.along(COLUMN as f64, 10.0) as f32;
    let [low, high] = [9.95, 10.05].map(|z| f64::from(sensor.camera().project(x, 0.0, z)[1]));
    let rows = lines(&scene, COLUMN);
    let turn = TAU * 0.1;
    let part = |f: fn(f64) -> f64| (0..40).map(|n| rows[n][1] * f(turn * n as f64)).sum::<f64>() / 20.0;
    let amplitude = part(f64::sin).hypot(part(f64::cos));
    // The mean of a profile and the next one, by the share of a step that the exposure takes.
    let share = 0.5 * 1000.0 * scene.bench.exposure.time_us * 1e-6;
    let blurred = (1.0 - share + share * turn.cos()).hypot(share * turn.sin());
    let theory = 0.5 * (low - high) * blurred;
    assert!((amplitude / theory - 1.0).abs() < 0.01 && theory > 0.2, "{amplitude} rows, theory {theory}");
    let mean = rows.iter().map(|row| row[1]).sum::<f64>() / 40.0;
    let rest = rows.iter().enumerate().map(|(n, row)| {
        row[1] - mean - part(f64::sin) * (turn * n as f64).sin() - part(f64::cos) * (turn * n as f64).cos()
    });
    assert!(rest.fold(0.0f64, |most, off| most.max(off.abs())) < 2e-3, "more than one sine");
    // Truth is the object's own height.
    scene.output.truth_maps = true;
    let height = render(&scene, plate(grey(), 10.0, 0.0, 0.0)).truth.expect("asked for").height;
    assert!(height.iter().all(|height| *height == 10.0));
}

/// A diode of two modes has two lines as far apart as asked for, and as unlike in light.
#[test]
fn modes_move_and_dim_the_line() {
    let mut scene = scene(60);
    let laser = &mut scene.bench.laser;
    (laser.mode_hop_um, laser.mode_hop_power, laser.mode_profiles) = (15.0, 0.04, 5.0);
    let (sensor, _) = expose(&scene, plate(grey(), 10.0, 0.0, 0.0), 0..1);
    let x = sensor.camera().rig.along(COLUMN as f64, 10.0) as f32;
    let apart = 0.015 * f64::from(sensor.camera().sight(x, 10.0, 0.0).rows_per_mm);
    let seen = lines(&scene, COLUMN);
    let middle =
        0.5 * seen.iter().fold([f64::MAX, f64::MIN], |[a, b], s| [a.min(s[1]), b.max(s[1])]).iter().sum::<f64>();
    let of = |ahead: bool, i: usize| {
        let own: Vec<f64> = seen.iter().filter(|s| (s[1] < middle) == ahead).map(|s| s[i]).collect();
        assert!(own.len() > 5 && own.iter().all(|v| (v / own[0] - 1.0).abs() < 1e-4), "{own:?}");
        own.iter().sum::<f64>() / own.len() as f64
    };
    assert!((of(false, 1) - of(true, 1) - apart).abs() < 2e-3 && apart > 0.1, "{apart} rows");
    // The mode that lies ahead on the scan, in smaller rows, is the brighter one.
    assert!((of(true, 0) / of(false, 0) - 1.02 / 0.98).abs() < 1e-4, "{}", of(true, 0) / of(false, 0));
}

/// The image moves by what the keys say, before the scan, on it, and from the axis on, and Range follows.
#[test]
fn drift_moves_the_image() {
    let mut drifted = scene(30);
    let rest = lines(&drifted, COLUMN);
    let camera = &mut drifted.bench.camera;
    (camera.drift_rows, camera.drift_scan_rows, camera.drift_scale) = (0.5, 0.9, 0.004);
    let (sensor, _) = expose(&drifted, plate(grey(), 10.0, 0.0, 0.0), 0..1);
    let axis = sensor.camera().rig.centre_row;
    for (n, (own, [_, row])) in lines(&drifted, COLUMN).iter().zip(rest).enumerate() {
        let theory = row + 0.5 + 0.9 * n as f64 / 30.0 + 0.004 * (row - axis);
        assert!((own[1] - theory).abs() < 2e-3, "profile {n}: row {}, theory {theory}", own[1]);
    }
    // Half a row and what the scan adds read too low: some 0.2 mm a row.
    (drifted.bench.speckle.strength, drifted.bench.camera.drift_scale) = (0.0, 0.0);
    let mean = |scene: &Scene| {
        let range = render(scene, plate(grey(), 10.0, 0.0, 0.0)).maps.range;
        range.iter().map(|z| f64::from(*z)).sum::<f64>() / range.len() as f64
    };
    let low = mean(&drifted);
    (drifted.bench.camera.drift_rows, drifted.bench.camera.drift_scan_rows) = (0.0, 0.0);
    let rig = sensor.camera().rig;
    let row = rig.project(0.0, 0.0, 10.0).1;
    let theory = rig.height(row + 0.5 + 0.9 * 29.0 / 60.0) - 10.0;
    assert!((low - mean(&drifted) - theory).abs() < 5e-3 && theory < -0.15, "{low}, theory {theory}");
}

/// Dust takes the same light from a column in each profile and in each sample of an instrument, and none is added.
#[test]
fn dust_stays_with_the_instrument() {
    let clean = scene(12);
    let mut dusty = clean.clone();
    let laser = &mut dusty.bench.laser;
    (laser.dust_count, laser.dust_shade) = (300.0, 0.6);
    let light = |scene: &Scene| -> Vec<f64> {
        let (sensor, band) = expose(scene, plate(grey(), 10.0, 0.0, 0.0), 2..4);
        let of = |profile: usize| (0..256).map(move |column| (profile, column));
        of(2).chain(of(3)).map(|(profile, column)| line(&sensor, &band, profile, column)[0][0]).collect()
    };
    let whole = light(&clean);
    let left = |scene: &Scene| -> Vec<f64> { light(scene).iter().zip(&whole).map(|(own, all)| own / all).collect() };
    let own = left(&dusty);
    let (first, second) = own.split_at(256);
    assert!(first.iter().zip(second).all(|(a, b)| (a - b).abs() < 1e-5), "dust moves with the object");
    let darkest = first.iter().fold(1.0f64, |least, share| least.min(*share));
    assert!(darkest < 0.8 && darkest > 0.02 && first.iter().all(|share| *share < 1.0 + 1e-5), "{darkest}");
    let mut other = dusty.clone();
    other.stream = Stream::root(77);
    assert!(left(&other).iter().zip(&own).all(|(a, b)| (a - b).abs() < 1e-5), "samples of an instrument differ");
    other.rig_stream = Stream::root(78);
    assert!(left(&other).iter().zip(&own).any(|(a, b)| (a - b).abs() > 0.05), "instruments are alike");
}

/// Samples of one instrument have its dust, others have not.
#[test]
fn samples_of_a_rig_have_its_dust() {
    let text = "name: a\nsubject: wood\nunstated: fixed\nclasses: {one: {share: 1}}\nrigs: 3\n";
    let recipe = Recipe::parse("a.yaml", text).unwrap_or_else(|error| panic!("{error}"));
    let scenes: Vec<Scene> = (0..12).map(|index| recipe.draw(1, index)).collect();
    for a in &scenes {
        for b in &scenes {
            assert_eq!(a.groups.rig == b.groups.rig, a.rig_stream == b.rig_stream);
        }
    }
}

/// On a surface that throws all light back at once Scatter is the halo's light in its rows, by the closed form across a
/// line; the line itself has lost the share.
#[test]
fn glare_lies_in_scatter() {
    let mut clear = scene(24);
    clear.bench.speckle.strength = 0.0;
    (clear.extraction.scatter_offset_rows, clear.extraction.scatter_width_rows) = (6, 8);
    let mut veiled = clear.clone();
    (veiled.bench.camera.glare_share, veiled.bench.camera.glare_um) = (0.1, 60.0);
    let scatter = |scene: &Scene| {
        let maps = render(scene, plate(grey(), 10.0, 0.0, 0.0)).maps.scatter;
        maps.iter().map(|s| f64::from(*s)).sum::<f64>() / maps.len() as f64
    };
    let [all, left] = [&clear, &veiled].map(|scene| lines(scene, COLUMN)[0][0]);
    assert!((left / all - 0.9).abs() < 1e-4, "{}", left / all);
    let radius = 60.0 / clear.bench.camera.pixel_um;
    let height = |row: i32| 0.1 * all * 0.5 / radius * (1.0 + (f64::from(row) / radius).powi(2)).powf(-1.5);
    let gain = (255.0 - clear.bench.exposure.dark_level_dn) / clear.bench.exposure.full_well_e;
    let theory = 2.0 * gain * (6..14).map(height).sum::<f64>();
    let got = scatter(&veiled) - scatter(&clear);
    // The fit of the halo is within 2.2 % of its height everywhere: 4 % of what these rows hold.
    assert!((got / theory - 1.0).abs() < 0.05 && theory > 10.0, "{got} DN, theory {theory}");
}

/// With everything that changes from profile to profile, rows and frames exposed alone are those of the whole scan.
#[test]
fn rows_alone_are_those_of_the_scan() {
    for name in ["wood-small", "blister-small"] {
        let mut scene = Recipe::load(name).expect("the embedded recipe loads").draw(3, 1);
        (scene.size.columns, scene.size.profiles) = (128, 48);
        let (motion, laser, camera) = (&mut scene.bench.motion, &mut scene.bench.laser, &mut scene.bench.camera);
        (motion.line_rate_hz, motion.vibration_um) = (2000.0, 40.0);
        (laser.power_noise, laser.mode_hop_um, laser.mode_profiles) = (0.03, 15.0, 6.0);
        (laser.dust_count, camera.glare_share, camera.drift_rows) = (200.0, 0.02, 0.4);
        (camera.drift_scan_rows, camera.drift_scale) = (0.5, 0.002);
        (scene.output.bin_columns, scene.output.bin_profiles) = (1, 1);
        scene.output.sensor_stack = SensorStack::All;
        let whole: Record = pipeline::render(&scene, patterns(), &|_| ());
        let kept = std::sync::Mutex::new(Vec::new());
        let asked = AskedRows { strips: vec![5..6, 20..23, 47..48], unlit: Vec::new(), frames: vec![0, 19, 40] };
        let alone = pipeline::derived(&scene, patterns(), &asked, &|frame| kept.lock().expect("no panic").push(frame));
        for rows in alone.exposed {
            let from = rows.first * 128;
            let same = |a: &[f32], b: &[f32]| a.iter().zip(&b[from..]).all(|(a, b)| a.to_bits() == b.to_bits());
            assert!(same(&rows.maps.range, &whole.maps.range), "{name}: Range of row {}", rows.first);
            assert!(same(&rows.maps.reflectance, &whole.maps.reflectance), "{name}: Reflectance of row {}", rows.first);
            assert!(same(&rows.maps.scatter, &whole.maps.scatter), "{name}: Scatter of row {}", rows.first);
        }
        for frame in kept.into_inner().expect("no panic") {
            assert!(whole.stack[frame.profile as usize] == frame, "{name}: frame {}", frame.profile);
        }
    }
}

/// A board that is wet all over is darker on its line and spreads the light farther; a film of water on it shines.
#[test]
fn wet_boards_are_dark_and_shine() {
    let seen = |filled: f64, film: f64| {
        let mut scene = Recipe::load("wood-small").expect("the embedded recipe loads").draw(5, 2);
        let Plan::Wood(wood) = &mut scene.plan else { panic!("a board") };
        (wood.moisture.board_filled, wood.moisture.film, wood.moisture.film_roughness) = (filled, film, 0.25);
        let record = pipeline::render(&scene, patterns(), &|_| ());
        let mean = |map: &[f32]| {
            let clear = map.iter().zip(&record.labels.class).filter(|(_, class)| **class == Class::Clear as u8);
            moments(clear.map(|(value, _)| f64::from(*value))).0
        };
        [mean(&record.maps.reflectance), mean(&record.maps.scatter)]
    };
    let [dry, wet, shining] = [seen(0.0, 0.0), seen(0.8, 0.0), seen(0.8, 1.0)];
    println!("Reflectance and Scatter: dry {dry:.1?}, wet {wet:.1?}, under a film {shining:.1?}");
    assert!(wet[0] < 0.85 * dry[0] && wet[1] / wet[0] > 1.1 * dry[1] / dry[0], "{dry:?} {wet:?}");
    assert!(shining[0] > 1.03 * wet[0], "{wet:?} {shining:?}");
}

/// Models that answer one line at a time have the line and its spread where the instrument moves both, and glare.
#[test]
fn slow_models_are_disturbed_too() {
    let mut rest = scene(24);
    (rest.size.columns, rest.transport) = (128, Transport::Diffusion { voxel_mm: 0.2 });
    if let Plan::Wood(wood) = &mut rest.plan {
        (wood.board.lead_in_mm, wood.board.width_mm) = (0.5, 12.0);
    }
    let mut drifted = rest.clone();
    drifted.bench.camera.drift_rows = 3.0;
    drifted.bench.laser.mode_hop_power = 0.2;
    drifted.bench.camera.glare_share = 0.1;
    let seen = |scene: &Scene| {
        let equipment = Equipment { patterns: patterns(), line_solvers: reference::line_solver };
        let (sensor, specimen) = pipeline::set_up(scene, pipeline::body(scene), equipment);
        let (band, mut scratch) = (sensor.band(&specimen, 20..21), Scratch::default());
        sensor.window(&band, 20, 0, &mut scratch);
        let window = &scratch.windows[0];
        let sum = |field: &[[f32; TILE]]| field.iter().map(|row| f64::from(row[COLUMN])).sum::<f64>();
        let veil = sum(&window.ambient);
        let moment = (0..ROWS).map(|k| k as f64 * f64::from(window.volume[k][COLUMN])).sum::<f64>();
        let below = sum(&window.volume[..]);
        [f64::from(window.first_row[COLUMN]) + moment / below, below, sum(&window.surface[..]), veil]
    };
    let ([row, below, surface, clear], [moved, less, shines, veil]) = (seen(&rest), seen(&drifted));
    assert!((moved - row - 3.0).abs() < 5e-3 && below > surface, "moved by {} rows", moved - row);
    let power = less / below;
    assert!((power / 0.9 - 1.0).abs() > 0.09 && (shines / surface / power - 1.0).abs() < 1e-3, "{power}");
    assert!(clear == 0.0 && veil > 0.0, "{clear} {veil}");
}

/// Row of the light from below, light from below, light of the surface and veil, over the columns of a tile.
fn answered(scene: &Scene) -> [f64; 4] {
    let equipment = Equipment { patterns: patterns(), line_solvers: reference::line_solver };
    let (sensor, specimen) = pipeline::set_up(scene, pipeline::body(scene), equipment);
    let (band, mut scratch) = (sensor.band(&specimen, 20..21), Scratch::default());
    sensor.window(&band, 20, 0, &mut scratch);
    let window = &scratch.windows[0];
    let sum = |field: &[[f32; TILE]]| field.iter().flatten().map(|light| f64::from(*light)).sum::<f64>();
    let row = |k: usize, column: usize| f64::from(window.first_row[column]) + k as f64;
    let moment = (0..ROWS).flat_map(|k| (0..TILE).map(move |c| (k, c)));
    let moment: f64 = moment.map(|(k, c)| row(k, c) * f64::from(window.volume[k][c])).sum();
    let below = sum(&window.volume[..]);
    [moment / below, below, sum(&window.surface[..]), sum(&window.ambient)]
}

/// Instruments at unrest, dust, glare and water change the light of the Monte Carlo as they change the kernel's: where
/// it stands, and how much comes from below and from the surface. With the same chance in both of its answers there is
/// next to no noise in what changes the line alone; water changes the paths.
#[test]
#[ignore = "long"]
fn walked_light_is_disturbed_as_the_kernels() {
    fn water(scene: &mut Scene, film: f64) {
        let Plan::Wood(wood) = &mut scene.plan else { panic!("a board") };
        (wood.moisture.board_filled, wood.moisture.film, wood.moisture.film_roughness) = (0.8, film, 0.25);
    }
    type Effect = (&'static str, fn(&mut Scene), [f64; 2]);
    // Where the line moves, rows differ by what a sawn face adds at another place.
    let (line, paths) = ([0.06, 0.01], [0.4, 0.05]);
    let effects: [Effect; 8] = [
        ("power", |scene| scene.bench.laser.power_noise = 0.3, line),
        ("modes", |scene| (scene.bench.laser.mode_hop_um, scene.bench.laser.mode_hop_power) = (60.0, 0.2), line),
        ("vibration", |scene| (scene.bench.motion.line_rate_hz, scene.bench.motion.vibration_um) = (1e3, 300.0), line),
        ("dust", |scene| (scene.bench.laser.dust_count, scene.bench.laser.dust_shade) = (300.0, 0.6), line),
        ("drift", |scene| (scene.bench.camera.drift_rows, scene.bench.camera.drift_scan_rows) = (3.0, 2.0), line),
        ("glare", |scene| scene.bench.camera.glare_share = 0.1, line),
        ("water", |scene| water(scene, 0.0), paths),
        ("a film of water", |scene| water(scene, 1.0), paths),
    ];
    let models = [Transport::Kernel, Transport::Path { photons: PHOTONS }].map(|model| {
        let mut rest = scene(24);
        (rest.size.columns, rest.transport) = (TILE, model);
        let Plan::Wood(wood) = &mut rest.plan else { panic!("a board") };
        (wood.board.lead_in_mm, wood.board.width_mm) = (0.5, 14.0);
        (answered(&rest), rest)
    });
    for (name, disturb, allowed) in effects {
        let changes = models.each_ref().map(|([row, below, surface, _], rest)| {
            let mut disturbed = rest.clone();
            disturb(&mut disturbed);
            let [own_row, own_below, own_surface, veil] = answered(&disturbed);
            [own_row - row, own_below / below - 1.0, own_surface / surface - 1.0, veil / own_below]
        });
        println!("{name}: {changes:.4?}");
        let [kernel, walked] = changes;
        assert!(kernel.iter().any(|change| change.abs() > 0.04), "{name} changes nothing");
        let off: [f64; 4] = std::array::from_fn(|i| (kernel[i] - walked[i]).abs());
        assert!(off[0] < allowed[0] && off[1..].iter().all(|off| *off < allowed[1]), "{name}: {kernel:?} {walked:?}");
    }
}
