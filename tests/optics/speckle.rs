//! What speckle does to the line's centre, in production's own Range, and what law and patterns do to its contrast.

use base::{Body, Gloss, Medium, Mesh};
use dataset::record::Record;
use glam::Vec3;
use optical_bench::settings::SpeckleLaw;
use procedural::solid::{Material, Part, Placing};
use recipe::Scene;
use scanner::frame::Frame;
use scanner::optics::speckle::coherence::{CONTRAST_PLACES, coherence_per_mm, contrast_at, row_contrasts};
use scanner::optics::{Scratch, TileOfProfile};
use test_support::target::{self, expose, moments, plate, render, scene};
use transport::kernel::{SurfacePoint, path_laws};

/// A flat metal target in the waist, no noise but rounding; the line is `sigma` rows wide before pixels.
fn lined(sigma: f64, patterns: f64) -> Scene {
    let mut scene = scene(500);
    let exposure = &mut scene.bench.exposure;
    (exposure.time_us, exposure.shot_noise) = (130.0 * sigma, 0.0);
    (exposure.dark_noise_dn, exposure.row_noise_dn, exposure.row_pattern_dn) = (0.3, 0.0, 0.0);
    // A whole number, so that rows without light are exact.
    exposure.dark_level_dn = 12.0;
    (scene.extraction.subpixel_steps, scene.extraction.window_rows) = (0, if sigma > 1.0 { 15 } else { 7 });
    scene.extraction.threshold_dn = 16.0;
    scene.bench.speckle.surface_patterns = patterns;
    scene.bench.optics.diffraction = false;
    let (blur, rows_per_mm) = (2.5 / 6.0, 9.90);
    scene.bench.laser.waist_height_mm = 0.0;
    scene.bench.laser.waist_mm = 2.0 * (sigma * sigma - blur * blur).sqrt() / rows_per_mm;
    scene
}

fn metal() -> Medium {
    Medium::opaque(Gloss::wood(1.0))
}

/// Spread that speckle gives Range, over all places of the line between the rows: the target rises by two rows along
/// the line [rows].
fn spread(scene: &Scene) -> f64 {
    let range = |scene: &Scene| {
        let record = render(scene, plate(metal(), 0.3, 0.02, 0.0));
        let number = |name: &str| record.physics.iter().find(|(n, _)| *n == name).expect(name).1;
        assert!(record.maps.reflectance.iter().all(|dn| *dn < 255.0), "saturated");
        let rows = |z: &f32| f64::from(*z) / number("height_per_row_mm");
        record.maps.range[40 * record.cols..].iter().map(rows).collect::<Vec<_>>()
    };
    let apart = |(a, b): (&f64, &f64)| (a - b).is_finite().then_some(a - b);
    let mut still = scene.clone();
    still.bench.speckle.strength = 0.0;
    let (speckled, still) = (range(scene), range(&still));
    let errors: Vec<f64> = speckled.iter().zip(&still).filter_map(apart).collect();
    // The darkest speckles alone are below the threshold.
    assert!(errors.len() as f64 > 0.995 * still.len() as f64, "{} of {} places", errors.len(), still.len());
    moments(errors.iter().copied()).1
}

/// Lines of 3, 6 and 12 um on the sensor, pixels of 6 um, polarised and not, against a simulation that lets the line
/// fall on the speckle before pixels gather both (docs/theory/instrument/speckle.md), within 10 %. Dorsch, Häusler and
/// Herrmann for a line, C sqrt(sigma L_c / (4 sqrt(pi))), is 0.089, 0.126 and 0.179: below a row pixels add to it.
#[test]
fn centres_spread_as_theory_has_it() {
    let known = [(0.5, 0.0953, 0.0686), (1.0, 0.1275, 0.0905), (2.0, 0.1780, 0.1260)];
    for (sigma, polarised, depolarised) in known {
        for (patterns, known) in [(1.0, polarised), (2.0, depolarised)] {
            let found = spread(&lined(sigma, patterns));
            println!("{sigma} rows, {patterns} patterns: {found:.4} rows for {known}");
            assert!((found / known - 1.0).abs() < 0.1, "{sigma} rows, {patterns} patterns: {found} for {known}");
        }
    }
}

/// The thesis' law has about half the contrast, and so has the line's centre half the spread.
#[test]
fn the_thesis_law_spreads_half_as_much() {
    let mut scene = lined(1.0, 1.0);
    let physical = spread(&scene);
    scene.speckle_law = SpeckleLaw::Rayleigh;
    let thesis = spread(&scene);
    assert!((0.4..0.62).contains(&(thesis / physical)), "{thesis} of {physical}");
}

/// Slope of the plate that shows where it stands [1].
const SLOPE: f32 = 0.6;

/// Truth and Range belong to where a profile really was: on a slope both leave the straight line by slope times jitter.
#[test]
fn jitter_and_wow_show_in_truth_and_range() {
    let heights = |record: &Record| -> (Vec<f64>, Vec<f64>) {
        let truth = &record.truth.as_ref().expect("the recipe keeps truth maps").height;
        let column = |map: &[f32], row: usize| {
            let line = &map[row * record.cols..][..record.cols];
            line.iter().map(|v| f64::from(*v)).sum::<f64>() / record.cols as f64
        };
        let rows = 40..record.rows;
        rows.map(|row| (column(truth, row), column(&record.maps.range, row))).unzip()
    };
    let of = |jitter: f64, wow: f64| {
        let mut scene = scene(240);
        scene.bench.speckle.strength = 0.0;
        (scene.bench.motion.encoder_jitter_um, scene.bench.motion.wow_um) = (jitter, wow);
        scene.bench.motion.wow_period_mm = 5.44;
        heights(&render(&scene, plate(target::ceramic(), 10.0, 0.0, SLOPE)))
    };
    let (even, _) = of(0.0, 0.0);
    for (jitter, wow, sd) in [(20.0, 0.0, 20.0), (0.0, 60.0, 60.0 / 2f64.sqrt())] {
        let (truth, range) = of(jitter, wow);
        let off: Vec<f64> = truth.iter().zip(&even).map(|(a, b)| 1000.0 * (a - b)).collect();
        let (_, found) = moments(off.iter().copied());
        // 200 profiles: standard error of a deviation 5 %.
        assert!((found / (f64::from(SLOPE) * sd) - 1.0).abs() < 0.2, "{found} um for {} times {sd}", SLOPE);
        let (_, apart) = moments(range.iter().zip(&truth).map(|(a, b)| 1000.0 * (a - b)));
        let (_, whole) = moments(range.iter().zip(&even).map(|(a, b)| 1000.0 * (a - b)));
        assert!(apart < 0.6 * whole, "Range is {apart} um off the truth, {whole} um off even steps");
    }
}

/// A plate with a ridge of 1.3 mm along the scan at `x` [mm].
fn ridged(x: f32) -> Body {
    let mut mesh = Mesh::default();
    for (at, size) in
        [(Vec3::ZERO, Vec3::new(22.0, 10.0, 5.0)), (Vec3::new(x + 11.0, 0.0, 4.0), Vec3::new(1.3, 10.0, 6.0))]
    {
        let first = mesh.positions.len() as u32;
        let corner = |i: u32| at + Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * size;
        mesh.positions.extend((0..8).map(corner));
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let corners = |q: [u32; 4]| q.map(|corner| corner + first);
        mesh.triangles.extend(quads.map(corners).iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]));
    }
    let placing = Placing { lead_in_mm: 0.5, ..Placing::from_values(&mut |p| p.default) };
    Body::new(Part::new(&mesh, &placing, &Material::from_values(&mut |p| p.default)))
}

/// A narrow ridge in the middle of a tile leaves the speckle of the plate beside it as it is.
#[test]
fn a_ridge_leaves_the_speckle_beside_it() {
    let scene = scene(60);
    let columns = |body: Body| -> Vec<Vec<u16>> {
        let (sensor, band) = expose(&scene, body, 40..60);
        let (mut scratch, mut offsets) = (Scratch::default(), Vec::new());
        let frame = |profile: usize| {
            let mut frames = <[Frame; 2]>::default();
            sensor.row_offsets(profile, &mut offsets);
            sensor.expose(
                &TileOfProfile { band: &band, profile, tile: 0, offsets: &offsets },
                &mut scratch,
                &mut frames,
            );
            let [frame, _] = frames;
            frame.dn.chunks_exact(frame.cols).flat_map(|row| row[12..36].to_vec()).collect()
        };
        (40..60).map(frame).collect()
    };
    // The middle of tile 0 stands at -5.7 mm; the other ridge is in tile 1.
    let (within, beyond) = (columns(ridged(-6.4)), columns(ridged(7.0)));
    assert!(within == beyond, "the plate has another speckle beside the ridge");
}

/// Contrast of the numbers in a row of the window, `rows` from the line, over all columns and profiles of a plate;
/// `brighter` lengthens the exposure so that the row has numbers to tell it by.
fn row_contrast(medium: Medium, rows: usize, brighter: f64) -> f64 {
    let mut scene = scene(240);
    let exposure = &mut scene.bench.exposure;
    (exposure.shot_noise, exposure.dark_noise_dn, exposure.row_noise_dn, exposure.row_pattern_dn) =
        (0.0, 0.0, 0.0, 0.0);
    exposure.dark_level_dn = 12.0;
    exposure.time_us *= brighter;
    scene.readout.bits = 12;
    let dark = 12.0 * scene.readout.scale();
    let mut still = scene.clone();
    still.bench.speckle.strength = 0.0;
    let numbers = |scene: &Scene| -> Vec<f64> {
        let (sensor, band) = expose(scene, plate(medium, 22.0, 0.0, 0.0), 40..240);
        let (mut scratch, mut offsets) = (Scratch::default(), Vec::new());
        let mut found = Vec::new();
        for profile in 40..240 {
            let mut frames = <[Frame; 2]>::default();
            sensor.row_offsets(profile, &mut offsets);
            for tile in 0..2 {
                sensor.expose(
                    &TileOfProfile { band: &band, profile, tile, offsets: &offsets },
                    &mut scratch,
                    &mut frames,
                );
                let frame = &frames[0];
                found.extend(frame.dn[(22 + rows) * frame.cols..][..frame.cols].iter().map(|dn| f64::from(*dn) - dark));
            }
        }
        found
    };
    let (speckled, even) = (numbers(&scene), numbers(&still));
    let ratios = speckled.iter().zip(&even).map(|(speckled, even)| speckled / even);
    let (mean, deviation) = moments(ratios);
    println!(
        "{rows} rows: mean {mean:.3}, contrast {:.4}, level {:.2}",
        deviation / mean,
        moments(even.iter().copied()).0
    );
    deviation / mean
}

/// The contrast that paths leave in a row behind that of the line, before pixels: of the kernel's law, which
/// `reference::contrast` holds to the reference, for the line's blur, its place and the rows of this bench.
fn path_contrast_of(medium: Medium, rows: usize) -> f64 {
    let scene = scene(240);
    let (sensor, band) = expose(&scene, plate(medium, 22.0, 0.0, 0.0), 100..101);
    let (line, tilt) = (band.line(100), sensor.camera().rig.tilt as f32);
    let (variance, per_mm) = (line.variance[128] - 1.0 / 12.0, line.rows_per_mm[128]);
    let point = SurfacePoint {
        mu_a: medium.mu_a,
        sigma_i: medium.sigma_i,
        k: medium.k,
        n: medium.n_eff,
        dispersion_deg: medium.dispersion_deg,
        enter: 1.0,
        ..SurfacePoint::BLACK
    };
    let point = point.facing(medium.fibre, Vec3::Z, Vec3::NEG_Z, Vec3::new(0.0, -tilt.sin(), tilt.cos()));
    let laws = path_laws(&point, variance / (per_mm * per_mm), CONTRAST_PLACES.map(|rows| rows / per_mm));
    let laser = &scene.bench.laser;
    let per_mm = coherence_per_mm(laser.wavelength_nm, laser.linewidth_nm) as f32 * medium.n_eff;
    let beyond = line.centre[128] - line.centre[128].floor();
    f64::from(contrast_at(&row_contrasts(per_mm, &laws), beyond - rows as f32))
}

/// Numbers beside a line on wood have the contrast of the paths of the light there, against that on the line, within 7
/// %. One contrast stood here for all rows and places.
#[test]
fn speckle_pales_beside_the_line() {
    let clear = Medium { gloss: Gloss::NONE, ..Medium::CLEAR_WOOD };
    let (sin, cos) = 80f32.to_radians().sin_cos();
    let knot = Medium { mu_a: 0.22, sigma_i: 3.0, k: 14.0, n_eff: 1.22, fibre: Vec3::new(0.0, cos, sin), ..clear };
    let on_clear = row_contrast(clear, 0, 0.5) / path_contrast_of(clear, 0);
    for (name, medium, rows, brighter) in [
        ("clear wood", clear, 9, 6.0),
        ("a knot", knot, 0, 0.5),
        ("a knot", knot, 9, 12.0),
        ("clear wood", clear, 5, 2.0),
    ] {
        let (found, known) = (row_contrast(medium, rows, brighter) / on_clear, path_contrast_of(medium, rows));
        println!("{name}, {rows} rows away: {found:.3} for {known:.3}");
        assert!((found / known - 1.0).abs() < 0.07, "{name}, {rows} rows away: {found} for {known}");
    }
    // What one contrast for all would be.
    assert!(path_contrast_of(clear, 9) < 0.5 * path_contrast_of(clear, 0));
}
