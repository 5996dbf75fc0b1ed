//! Scans draw the rows alone that are read about a line: what is read must be what whole windows give, to the bit.

use bench::settings::{Extraction, PeakChoice, PeakMethod, SearchDirection};
use procedural::Stream;
use rand::{Rng, RngExt};
use recipe::Recipe;
use scanner::extract::{MeasuredProfile, extract};
use scanner::frame::Frame;
use scanner::optics::{Band, Scratch, TILE, TileOfProfile};
use test_support::target::tiles;

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

#[test]
fn rows_that_are_left_out_change_nothing() {
    let mut rng = Stream::root(17).rng();
    let (mut short, mut all) = (0, 0);
    let names = ["wood-small", "wood-grading-train", "wood-train", "blister-small", "mesh-small", "sawtooth-small"];
    for (round, name) in (0..4).flat_map(|round| names.map(|name| (round, name))) {
        let mut scene = Recipe::load(name).expect("the embedded recipe loads").draw(3, rng.random_range(0..10_000));
        // What recipes say, then anything.
        if round > 0 {
            scene.extraction = settings(scene.extraction, scene.bench.exposure.dark_level_dn, &mut rng);
        }
        // A grid mixes columns afterwards.
        scene.output.bin_columns = 1;
        scene.output.bin_profiles = 1;
        scene.size.profiles = 160;
        let record = pipeline::render(&scene, tiles(), &|_| ());
        let (sensor, specimen) = pipeline::set_up(&scene, pipeline::body(&scene), tiles());
        let (calibration, columns) = (sensor.calibration(), scene.size.columns);
        let band = sensor.band(&specimen, 0..scene.size.profiles, Band::default());
        let (mut scratch, mut frames, mut offsets) = (Scratch::default(), <[Frame; 2]>::default(), Vec::new());
        for profile in 0..scene.size.profiles {
            sensor.row_offsets(profile, &mut offsets);
            let [mut range, mut reflectance, mut scatter] = [0, 1, 2].map(|_| vec![0.0; columns]);
            for tile in 0..columns.div_ceil(TILE) {
                let part = TileOfProfile { band: &band, profile, tile, offsets: &offsets };
                let left_out = sensor.expose_to_read(&part, &scene.extraction, &mut scratch, &mut frames);
                (short, all) = (short + usize::from(left_out.is_some()), all + 1);
                sensor.expose(&part, &mut scratch, &mut frames);
                let line = frames[0].first_col..frames[0].first_col + frames[0].cols;
                let mut out = MeasuredProfile {
                    range: &mut range[line.clone()],
                    reflectance: &mut reflectance[line.clone()],
                    scatter: &mut scatter[line],
                };
                extract(&frames, &calibration, &scene.extraction, &mut out);
            }
            let at = profile * columns..(profile + 1) * columns;
            let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            let said = format!("{name}, sample {}, profile {profile}, {:?}", scene.index, scene.extraction);
            assert!(bits(&record.maps.range[at.clone()]) == bits(&range), "Range: {said}");
            assert!(bits(&record.maps.reflectance[at.clone()]) == bits(&reflectance), "Reflectance: {said}");
            assert!(bits(&record.maps.scatter[at]) == bits(&scatter), "Scatter: {said}");
        }
    }
    assert!(6 * short > all, "{short} of {all} tiles are drawn in part");
}
