//! Blooming as frames show it: charge above the full well is there again, beside where it was too much, and nowhere
//! else.

use base::{Body, Gloss, Medium};
use procedural::flat::Flat;
use recipe::Scene;
use scanner::frame::Frame;
use scanner::optics::{Band, ROWS, Scratch, Sensor, TileOfProfile};
use test_support::target::{patterns, scene};

/// First profile that looks at the middle of the plate.
const PROFILE: usize = 40;
/// Noise that is left [DN of 8 bits].
const NOISE: f64 = 0.3;

/// A white plate on a dark conveyor, read with 12 bits and next to no noise.
fn quiet() -> Scene {
    let mut scene = scene(PROFILE + 1);
    scene.bench.speckle.strength = 0.0;
    scene.bench.motion.conveyor_reflectance = 0.05;
    scene.readout.bits = 12;
    let exposure = &mut scene.bench.exposure;
    (exposure.shot_noise, exposure.dark_noise_dn) = (0.0, NOISE);
    (exposure.row_noise_dn, exposure.row_pattern_dn, exposure.dark_current_e_per_s) = (0.0, 0.0, 0.0);
    scene
}

fn sensor(scene: &Scene) -> (Sensor, Band) {
    let medium = Medium::opaque(Gloss { matte: 1.0, ..Gloss::NONE });
    let body = Body::new(Flat { height_mm: 0.01, slope_x: 0.0, slope_y: 0.0, width_mm: 6.0, length_mm: 40.0, medium });
    let (sensor, specimen) = pipeline::set_up(scene, body, patterns());
    let band = sensor.band(&specimen, PROFILE..PROFILE + 1);
    (sensor, band)
}

/// Electrons of the first tile's window.
fn light(scene: &Scene) -> Scratch {
    let (sensor, band) = sensor(scene);
    let mut scratch = Scratch::default();
    sensor.window(&band, PROFILE, 0, &mut scratch);
    scratch
}

fn frame(scene: &Scene) -> Frame {
    let (sensor, band) = sensor(scene);
    let (mut scratch, mut frames, mut offsets) = (Scratch::default(), <[Frame; 2]>::default(), Vec::new());
    sensor.row_offsets(PROFILE, &mut offsets);
    sensor.expose(
        &TileOfProfile { band: &band, profile: PROFILE, tile: 0, offsets: &offsets },
        &mut scratch,
        &mut frames,
    );
    std::mem::take(&mut frames[0])
}

/// Of each column's charge above the full well the share that blooms is read in rows that have room, next to those that
/// are full and as many on either side; columns with room stay as they are.
#[test]
fn charge_that_overflows_is_read_beside() {
    let mut scene = quiet();
    let most = f64::from(scene.readout.most());
    let dark = scene.bench.exposure.dark_level_dn * scene.readout.scale();
    let full_well = scene.bench.exposure.full_well_e;
    let brightest = light(&scene);
    let brightest = (0..ROWS * 128).map(|i| brightest.electrons(i / 128, i % 128)).fold(0.0, f32::max);
    scene.bench.exposure.time_us *= 3.0 * full_well / f64::from(brightest);
    let light = light(&scene);
    // Of what is there, in full wells, and of what can be read.
    let gain = (most - dark) / full_well;
    let plain = frame(&scene);
    let noise = NOISE * scene.readout.scale();
    for share in [0.25, 1.0] {
        scene.bench.exposure.blooming = share;
        let bloomed = frame(&scene);
        let (mut overfull, mut filled, mut gained, mut over) = (0, 0, 0.0, 0.0);
        for c in 0..plain.cols {
            let column = |frame: &Frame| (0..ROWS).map(|k| f64::from(frame.dn[k * frame.cols + c])).collect::<Vec<_>>();
            let [before, after] = [&plain, &bloomed].map(column);
            let above = |k: usize| (gain * (f64::from(light.electrons(k, c)) - full_well)).max(0.0);
            let own: f64 = (0..ROWS).map(above).sum();
            if own == 0.0 {
                assert_eq!(before, after, "column {c} has room for all its charge");
                continue;
            }
            overfull += 1;
            over += share * own;
            gained += after.iter().sum::<f64>() - before.iter().sum::<f64>();
            // Full rows are together and reach as far up as down.
            let full = |numbers: &[f64]| (0..ROWS).filter(|&k| numbers[k] > most - 4.0 * noise).collect::<Vec<_>>();
            let [inner, outer] = [full(&before), full(&after)];
            let ends = |rows: &[usize]| [rows[0] as i64, rows[rows.len() - 1] as i64];
            let ([first, last], [up, down]) = (ends(&inner), ends(&outer));
            assert_eq!(outer.len() as i64, down - up + 1, "column {c}: full rows are together");
            // What flows to either side fills a pixel there at the least.
            if 0.5 * share * own > most - dark {
                filled += 1;
                assert!(up < first && down > last, "column {c}: {outer:?} around {inner:?}");
            }
            assert!(((first - up) - (down - last)).abs() <= 1, "column {c}: {outer:?} around {inner:?}");
        }
        println!("{share}: {overfull} columns, {filled} far over, gained {gained:.0} of {over:.0} DN");
        // Rows that are filled to the brim lose 0.4 of the noise to the end of the scale, a dozen in a column.
        let lost = 12.0 * 0.4 * noise * f64::from(overfull);
        let error = 4.0 * noise * (2.0 * ROWS as f64 * f64::from(overfull)).sqrt();
        assert!(
            overfull > 20 && (filled > 20 || share < 1.0) && lost < 0.02 * over,
            "{overfull} columns overflow by {over}"
        );
        assert!(gained < over + error && gained > over - lost - error, "{share}: {gained} of {over}");
    }
}
