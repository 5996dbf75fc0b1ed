//! Scans draw the rows alone that are read about a line: what is read must be what whole windows give, to the bit.

use std::sync::Arc;

use base::{Mesh, Stream};
use glam::Vec3;
use optical_bench::settings::{Extraction, PeakChoice, PeakMethod, SearchDirection};
use rand::{Rng, RngExt};
use recipe::{Plan, Recipe};
use scanner::extract::{MeasuredProfile, extract};
use scanner::frame::Frame;
use scanner::optics::{Scratch, TILE, TileOfProfile};
use test_support::target::patterns;

/// Settings of an extraction, any that recipes accept; thresholds from among the noise to above most lines.
fn settings(mut settings: Extraction, dark_dn: f64, rng: &mut impl Rng) -> Extraction {
    settings.method = match rng.random_range(0..6) {
        0 | 1 => PeakMethod::CentreOfGravity,
        2 => PeakMethod::Parabola,
        3 => PeakMethod::Gaussian,
        4 => PeakMethod::BlaisRioux { order: [2, 4, 8][rng.random_range(0..3)] },
        _ => PeakMethod::Fir { length: [3, 5, 7, 9][rng.random_range(0..4)] },
    };
    settings.window_rows = match settings.method {
        PeakMethod::Parabola | PeakMethod::Gaussian => 1,
        _ => [3, 7, 15][rng.random_range(0..3)],
    };
    settings.peak = PeakChoice::ALL[rng.random_range(0..2)];
    settings.direction = SearchDirection::ALL[rng.random_range(0..2)];
    settings.scatter_offset_rows = rng.random_range(0..4);
    settings.scatter_width_rows = rng.random_range(1..11);
    settings.threshold_dn = dark_dn + 1.5 * libm::pow(100.0, rng.random_range(0.0..1.0));
    settings
}

/// A plate with grooves of a width across the scan, from whose floors the lens sees no light [mm].
fn comb(groove_mm: f32) -> Mesh {
    const PITCH_MM: f32 = 1.4;
    let mut mesh = Mesh::default();
    let mut add = |y: [f32; 2], z: [f32; 2]| {
        let first = mesh.positions.len() as u32;
        for (i, j, k) in (0..8).map(|corner| (corner & 1, corner >> 1 & 1, corner >> 2)) {
            mesh.positions.push(Vec3::new(if i == 0 { -30.0 } else { 30.0 }, y[j], z[k]));
        }
        for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            mesh.triangles.extend([[a, b, c], [a, c, d]].map(|corners: [u32; 3]| corners.map(|corner| first + corner)));
        }
    };
    add([-9.0, 9.0], [0.0, 3.5]);
    for bar in 0..12 {
        let y = -9.0 + PITCH_MM * bar as f32;
        add([y, y + PITCH_MM - groove_mm], [3.4, 6.0]);
    }
    mesh
}

#[test]
#[ignore = "long"]
fn rows_that_are_left_out_change_nothing() {
    let mut rng = Stream::root(17).rng();
    let (mut short, mut all, mut needed) = (0, 0, 0);
    let names = ["wood-small", "wood-grading-train", "wood-train", "blister-small", "mesh-small", "sawtooth-small"];
    for (round, name) in (0..6).flat_map(|round| names.map(|name| (round, name))) {
        let mut scene = Recipe::load(name).expect("the embedded recipe loads").draw(3, rng.random_range(0..10_000));
        // What recipes say, then anything.
        if round > 0 {
            scene.extraction = settings(scene.extraction, scene.bench.exposure.dark_level_dn, &mut rng);
        }
        // Light that speckle does not throw about, on bodies that fill the field and have dark lines across it.
        if round > 2 {
            scene.bench.speckle.strength = 0.0;
            scene.bench.laser.power_mw *= rng.random_range(0.5..6.0);
            match &mut scene.plan {
                Plan::Wood(wood) => {
                    (wood.board.width_mm, wood.board.lead_in_mm) = (40.0, 0.5);
                    (wood.marks.burn_count, wood.marks.burn_mm, wood.marks.burn_coat) = (8.0, 1.5, 0.1);
                }
                Plan::Mesh(..) => scene.mesh = Some(Arc::new(comb(rng.random_range(0.1..0.6)))),
                Plan::Blister(_) | Plan::Sawtooth(..) => {}
            }
        }
        // Any line.
        if round > 4 {
            scene.bench.laser.lobe_share = rng.random_range(0.0..0.3);
            scene.bench.laser.lobe_distance = rng.random_range(2.0..8.0);
        }
        // A grid mixes columns afterwards.
        scene.output.bin_columns = 1;
        scene.output.bin_profiles = 1;
        scene.size.profiles = 160;
        let record = pipeline::render(&scene, patterns(), &|_| ());
        let (sensor, specimen) = pipeline::set_up(&scene, pipeline::body(&scene), patterns());
        let (calibration, columns) = (sensor.calibration(), scene.size.columns);
        let band = sensor.band(&specimen, 0..scene.size.profiles);
        let (mut scratch, mut frames, mut offsets) = (Scratch::default(), <[Frame; 2]>::default(), Vec::new());
        for profile in 0..scene.size.profiles {
            sensor.row_offsets(profile, &mut offsets);
            let [mut range, mut reflectance, mut scatter] = [0, 1, 2].map(|_| vec![0.0; columns]);
            for tile in 0..columns.div_ceil(TILE) {
                let part = TileOfProfile { band: &band, profile, tile, offsets: &offsets };
                let mut read = |frames: &[Frame; 2]| {
                    let line = frames[0].first_col..frames[0].first_col + frames[0].cols;
                    let mut out = MeasuredProfile {
                        range: &mut range[line.clone()],
                        reflectance: &mut reflectance[line.clone()],
                        scatter: &mut scatter[line.clone()],
                    };
                    extract(frames, &calibration, &scene.extraction, &mut out);
                    bits(&range[line.clone()], &reflectance[line.clone()], &scatter[line])
                };
                let left_out = sensor.expose_to_read(&part, &scene.extraction, &mut scratch, &mut frames);
                let of_part = read(&frames);
                sensor.expose(&part, &mut scratch, &mut frames);
                // What is read of a part alone is something else where the rest holds a peak.
                needed += usize::from(read(&frames) != of_part);
                (short, all) = (short + usize::from(left_out.is_some()), all + 1);
            }
            let at = profile * columns..(profile + 1) * columns;
            let record =
                bits(&record.maps.range[at.clone()], &record.maps.reflectance[at.clone()], &record.maps.scatter[at]);
            let said = format!("{name}, sample {}, profile {profile}, {:?}", scene.index, scene.extraction);
            assert!(record == bits(&range, &reflectance, &scatter), "{said}");
        }
    }
    println!("{short} of {all} tiles are drawn in part, in {needed} the rest holds a peak");
    assert!(4 * short > all, "{short} of {all} tiles are drawn in part");
    assert!(needed > 500, "in {needed} of {short} tiles the rest holds a peak");
}

/// Range, Reflectance and Scatter as they are stored.
fn bits(range: &[f32], reflectance: &[f32], scatter: &[f32]) -> [Vec<u32>; 3] {
    [range, reflectance, scatter].map(|values| values.iter().map(|value| value.to_bits()).collect())
}
