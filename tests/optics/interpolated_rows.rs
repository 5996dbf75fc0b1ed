//! Light of rows between key rows is interpolated: images must be what they are with every row worked out.

use base::Stream;
use rand::RngExt;
use recipe::{Plan, Recipe, Scene};
use scanner::optics::{CENTRE, Scratch, Sensor, TILE};
use scanner::specimen::Specimen;
use test_support::target::patterns;

/// Profiles of a band.
const PROFILES: usize = 24;

/// What a column's electrons tell without noise: the brightest row, light 7 to 11 rows beside the line, the line's
/// centre of gravity [px].
fn read(scratch: &Scratch, column: usize) -> [f64; 3] {
    let light = |k: usize| f64::from(scratch.electrons(k, column));
    let peak = (CENTRE - 2..=CENTRE + 2).map(light).fold(0.0, f64::max);
    let beside = (7..=11).map(|away| light(CENTRE - away) + light(CENTRE + away)).sum();
    let sums =
        (CENTRE - 4..=CENTRE + 4).fold([0.0; 2], |[all, moment], k| [all + light(k), moment + k as f64 * light(k)]);
    [peak, beside, sums[1] / sums[0].max(1e-9)]
}

/// All columns that see the body in the profiles from `start`, and rows per mm of height there [px/mm].
fn measured(scene: &Scene, sensor: &Sensor, specimen: &Specimen, start: usize) -> (Vec<[f64; 3]>, f64) {
    let band = sensor.band(specimen, start..start + PROFILES);
    let mut scratch = Scratch::default();
    let (mut out, mut rows_per_mm) = (Vec::new(), 0.0);
    for profile in start..start + PROFILES {
        let line = band.line(profile);
        for tile in 0..scene.size.columns.div_ceil(TILE) {
            sensor.window(&band, profile, tile, &mut scratch);
            let lit = (0..scratch.columns).filter(|c| !line.bare[tile * TILE + c] && line.hits[tile * TILE + c].seen);
            out.extend(lit.map(|column| read(&scratch, column)));
        }
        rows_per_mm = f64::from(line.level_rows_per_mm);
    }
    // Heights show as tan(tilt) of the way along the motion.
    (out, rows_per_mm * libm::tan(scene.bench.camera.tilt_deg.to_radians()))
}

/// Boards of every kind, in any step and turned any way: Reflectance and Scatter within 0.2 % of clear wood rms, Range
/// within 1 um.
#[test]
#[ignore = "long"]
fn interpolated_rows_show_what_all_rows_show() {
    let mut rng = Stream::root(41).rng();
    let (mut changed, mut all) = (0, 0);
    for round in 0..42 {
        let names = ["wood", "wood-small", "wood-train", "wood-grading", "wood-stem", "wood-log", "mesh-small"];
        let name = names[round % names.len()];
        let mut scene = Recipe::load(name).expect("the embedded recipe loads").draw(5, rng.random_range(0..10_000));
        if round >= names.len() {
            scene.bench.motion.step_mm *= rng.random_range(0.4..4.0);
            if let Plan::Wood(wood) = &mut scene.plan {
                wood.log.streak = rng.random_range(0.0..0.4);
                wood.board.roughness_um = rng.random_range(0.0..60.0);
                wood.board.saw_ripple_um = rng.random_range(0.0..60.0);
            }
        }
        let along = match &scene.plan {
            Plan::Wood(wood) => wood.board.lead_in_mm + rng.random_range(-0.02..1.0) * wood.board.length_mm,
            _ => rng.random_range(0.0..1.0) * scene.size.profiles as f64 * scene.bench.motion.step_mm,
        };
        let start = (along / scene.bench.motion.step_mm) as usize;
        let start = start.min(scene.size.profiles - PROFILES);
        let set_up = || pipeline::set_up(&scene, pipeline::body(&scene), patterns());
        let ((fast, specimen), (dense, _)) = (set_up(), set_up());
        let (got, rows_per_mm) = measured(&scene, &fast, &specimen, start);
        let (expected, _) = measured(&scene, &dense.without_interpolation(), &specimen, start);
        if expected.is_empty() {
            continue;
        }
        let middle = |i: usize| {
            let mut values: Vec<f64> = expected.iter().map(|read| read[i]).collect();
            let at = values.len() / 2;
            *values.select_nth_unstable_by(at, f64::total_cmp).1
        };
        let scale = [middle(0), middle(1), 1e-3 * rows_per_mm];
        let mut squares = [0.0; 3];
        let mut worst = [0.0f64; 3];
        for (got, expected) in got.iter().zip(&expected) {
            (changed, all) = (changed + usize::from(got != expected), all + 1);
            for i in 0..3 {
                let off = (got[i] - expected[i]) / scale[i];
                // A place as dark as the mouth of a crack has no line whose middle could be read.
                if i < 2 || expected[0] > 0.1 * scale[0] {
                    squares[i] += off * off;
                    worst[i] = worst[i].max(off.abs());
                }
            }
        }
        let rms = squares.map(|sum| (sum / got.len() as f64).sqrt());
        assert!(rms[0] < 0.002 && rms[1] < 0.002 && rms[2] < 1.0, "{name} {}: {rms:?}, {worst:?}", scene.index);
    }
    // Unless rows are interpolated this test shows nothing. Marks of teeth and hearts of knots leave them few columns.
    assert!(6 * changed > all, "{changed} of {all} columns");
}
