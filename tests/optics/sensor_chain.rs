//! The sensor by EMVA 1288, read off digital numbers: gain, dark law, what stays with pixels, rows and columns, slopes.

use base::{Body, Gloss, Medium};
use optical_bench::settings::{Hdr, Readout};
use procedural::flat::Flat;
use recipe::Scene;
use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex64;
use scanner::frame::Frame;
use scanner::optics::{Band, ROWS, Scratch, Sensor, TileOfProfile};
use test_support::target::{moments, patterns, scene};

/// First profile that sees nothing but the conveyor.
const BARE: usize = 64;

/// A white conveyor under a line of 4 mm: a patch of light whose pixels are all known.
fn white(profiles: usize) -> Scene {
    let mut scene = scene(BARE + profiles);
    (scene.bench.motion.conveyor_reflectance, scene.bench.laser.waist_mm) = (1.0, 2.0);
    scene.bench.speckle.strength = 0.0;
    // A window's brightest pixel then stands at about 0.9 of the full well.
    scene.bench.exposure.time_us = 130.0;
    scene
}

fn sensor(scene: &Scene) -> (Sensor, Band) {
    let medium = Medium::opaque(Gloss::NONE);
    let body = Body::new(Flat { height_mm: 0.01, slope_x: 0.0, slope_y: 0.0, width_mm: 1.0, length_mm: 1.0, medium });
    let (sensor, specimen) = pipeline::set_up(scene, body, patterns());
    let band = sensor.band(&specimen, BARE..scene.size.profiles);
    (sensor, band)
}

/// Mean and variance in time of each pixel of the first tile's window [DN, DN^2].
fn in_time(scene: &Scene) -> Vec<[f64; 2]> {
    let (sensor, band) = sensor(scene);
    let (mut scratch, mut frames, mut offsets) = (Scratch::default(), <[Frame; 2]>::default(), Vec::new());
    let mut sums = Vec::new();
    for profile in band.profiles.clone() {
        sensor.row_offsets(profile, &mut offsets);
        sensor.expose(&TileOfProfile { band: &band, profile, tile: 0, offsets: &offsets }, &mut scratch, &mut frames);
        sums.resize(frames[0].dn.len(), [0.0f64; 2]);
        for (sum, &dn) in sums.iter_mut().zip(&frames[0].dn) {
            let dn = f64::from(dn);
            *sum = [sum[0] + dn, sum[1] + dn * dn];
        }
    }
    let n = band.profiles.len() as f64;
    sums.iter().map(|[s, q]| [s / n, (q - s * s / n) / (n - 1.0)]).collect()
}

fn means(pixels: &[[f64; 2]]) -> [f64; 2] {
    let n = pixels.len() as f64;
    pixels.iter().fold([0.0; 2], |sum, p| [sum[0] + p[0] / n, sum[1] + p[1] / n])
}

/// Variance over mean is the gain, for each converter, with all that stays with the pixels switched on: it is no noise
/// in time.
#[test]
fn photon_transfer_gives_the_gain_back() {
    const EXPOSURES: usize = 500;
    for bits in [8, 10, 12] {
        let mut scene = white(EXPOSURES);
        scene.readout = Readout { bits, hdr: Hdr::None };
        let exposure = &mut scene.bench.exposure;
        (exposure.prnu, exposure.dsnu_dn, exposure.column_pattern_dn) = (0.01, 0.25, 0.1);
        let gain = scene.readout.scale() * (255.0 - exposure.dark_level_dn) / exposure.full_well_e;
        let light = means(&in_time(&scene));
        scene.bench.laser.power_mw = 0.01;
        let dark = means(&in_time(&scene));
        let slope = (light[1] - dark[1]) / (light[0] - dark[0]);
        // 128 x 44 pixels times 499: a variance is known to sqrt(2 / 2.8e6) = 0.084 % (rows a little worse).
        let error = 0.00084 * (light[1].powi(2) + dark[1].powi(2)).sqrt() / (light[0] - dark[0]) / gain;
        println!("{bits} bits: {slope:.6} DN/e- for {gain:.6}, standard error {:.2} %", 100.0 * error);
        assert!(error < 0.0035 && (slope / gain - 1.0).abs() < 4.0 * error, "{bits} bits: {slope}, set {gain}");
    }
}

/// Without structure dark pixels are a normal law of 11.6 and 1.09 DN, rounding included: chi-square over all levels.
#[test]
fn dark_pixels_are_the_law_of_the_thesis() {
    let mut scene = white(4);
    (scene.bench.laser.power_mw, scene.bench.exposure.time_us) = (0.01, 0.1);
    let exposure = &mut scene.bench.exposure;
    (exposure.row_noise_dn, exposure.row_pattern_dn, exposure.dark_current_e_per_s) = (0.0, 0.0, 0.0);
    let (sensor, band) = sensor(&scene);
    let mut counts = [0.0f64; 32];
    for profile in band.profiles.clone() {
        sensor.full_frame(&band, profile).iter().for_each(|&dn| counts[usize::from(dn).min(31)] += 1.0);
    }
    let n: f64 = counts.iter().sum();
    let sigma = (1.09f64 * 1.09 - 1.0 / 12.0).sqrt();
    let below = |dn: f64| 0.5 * libm::erfc(-(dn - 11.6) / sigma / std::f64::consts::SQRT_2);
    let expected = |dn: usize| n * (below(dn as f64 + 0.5) - below(dn as f64 - 0.5));
    let kept: Vec<usize> = (0..31).filter(|&dn| expected(dn) > 5.0).collect();
    let chi: f64 = kept.iter().map(|&dn| (counts[dn] - expected(dn)).powi(2) / expected(dn)).sum();
    let freedom = kept.len() as f64 - 1.0;
    println!("chi-square {chi:.1} for {freedom} degrees of freedom, {n} pixels");
    // Wilson and Hilferty's cube root at alpha = 1e-3.
    let most = freedom * (1.0 - 2.0 / (9.0 * freedom) + 3.09 * (2.0 / (9.0 * freedom)).sqrt()).powi(3);
    assert!(chi < most, "chi-square {chi} for {freedom} degrees of freedom");
}

/// Power along lines of an averaged frame, over lines: white noise of variance v has the power v at each frequency
/// `[frequency]` [DN^2]. EMVA 1288's spectrograms.
fn spectrum(frame: &[f64], columns: usize, along_rows: bool) -> Vec<f64> {
    let rows = frame.len() / columns;
    let mean = frame.iter().sum::<f64>() / frame.len() as f64;
    let (lines, length) = if along_rows { (rows, columns) } else { (columns, rows) };
    let transform = FftPlannerScalar::new().plan_fft_forward(length);
    let mut power = vec![0.0; length / 2];
    for line in 0..lines {
        let at = |i: usize| if along_rows { line * columns + i } else { i * columns + line };
        let mut wave: Vec<_> = (0..length).map(|i| Complex64::new(frame[at(i)] - mean, 0.0)).collect();
        transform.process(&mut wave);
        power.iter_mut().zip(&wave).for_each(|(sum, w)| *sum += w.norm_sqr() / (length * lines) as f64);
    }
    power
}

/// Rows and columns stand out at frequency 0 of the spectra across them, DSNU and noise in all others, each by its own
/// variance, and each is gone when it is off.
#[test]
fn structure_shows_in_the_spectra() {
    const FRAMES: usize = 12;
    for (row, column, dsnu) in [(0.2, 0.1, 0.25), (0.0, 0.1, 0.25), (0.2, 0.0, 0.25), (0.2, 0.1, 0.0), (0.0, 0.0, 0.0)]
    {
        let mut scene = white(FRAMES);
        (scene.bench.laser.power_mw, scene.bench.exposure.time_us) = (0.01, 0.1);
        let exposure = &mut scene.bench.exposure;
        (exposure.row_noise_dn, exposure.row_pattern_dn) = (0.0, row);
        (exposure.column_pattern_dn, exposure.dsnu_dn) = (column, dsnu);
        let dark = exposure.dark_noise_dn;
        let (sensor, band) = sensor(&scene);
        let (columns, rows) = (scene.size.columns, scene.size.rows);
        let mut mean = vec![0.0; columns * rows];
        for profile in band.profiles.clone() {
            let frame = sensor.full_frame(&band, profile);
            mean.iter_mut().zip(frame).for_each(|(sum, dn)| *sum += f64::from(dn) / FRAMES as f64);
        }
        let noise = (dark * dark - row * row - column * column - dsnu * dsnu) / FRAMES as f64;
        let pixel = noise + dsnu * dsnu;
        for (along_rows, across, length, lines) in [(true, row, columns, rows), (false, column, rows, columns)] {
            let power = spectrum(&mean, columns, along_rows);
            let other = if along_rows { column } else { row };
            // Of `lines` independent lines; the other structure is alike in all of them and scatters as one line does.
            let expected = pixel + across * across * length as f64;
            let error = expected * (2.0 / lines as f64).sqrt();
            assert!(
                (power[0] - expected).abs() < 4.0 * error,
                "{row} {column} {dsnu}: {} for {expected} at 0",
                power[0]
            );
            let rest = power[1..].iter().sum::<f64>() / (power.len() - 1) as f64;
            let all = pixel + other * other;
            let error = pixel * (2.0 / (columns * rows) as f64).sqrt() + other * other * (2.0 / length as f64).sqrt();
            assert!((rest - all).abs() < 4.0 * error, "{row} {column} {dsnu}: {rest} for {all} elsewhere");
        }
    }
}

/// Averaged exposures of a patch of known light spread by PRNU, and by next to nothing without it.
#[test]
fn response_stays_with_the_pixels() {
    let look = |prnu: f64| {
        let mut scene = white(300);
        scene.bench.exposure.prnu = prnu;
        (scene.bench.exposure.row_noise_dn, scene.bench.exposure.row_pattern_dn) = (0.0, 0.0);
        let (sensor, band) = sensor(&scene);
        let mut scratch = Scratch::default();
        sensor.window(&band, BARE, 0, &mut scratch);
        let gain = (255.0 - 11.6) / scene.bench.exposure.full_well_e;
        let pixels = in_time(&scene);
        let columns = pixels.len() / ROWS;
        let relative = |i: usize| {
            let light = gain * f64::from(scratch.electrons(i / columns, i % columns));
            (pixels[i].map(|v| v - 11.6)[0] - light) / light
        };
        // Ten rows about the middle.
        (0..pixels.len()).filter(|i| (17..27).contains(&(i / columns))).map(relative).collect::<Vec<_>>()
    };
    let (on, off) = (look(0.01), look(0.0));
    let (_, spread) = moments(on.iter().copied());
    let (_, noise) = moments(off.iter().copied());
    let found = (spread * spread - noise * noise).sqrt();
    println!("PRNU {found:.5}, noise that is left {noise:.5}");
    // 1280 pixels: 2 %, four of which.
    assert!((found / 0.01 - 1.0).abs() < 0.08, "PRNU {found}");
    assert!(noise < 0.002, "without PRNU pixels still differ by {noise}");
}

/// Two slopes: numbers follow the closed form over 20 times the range, noise falls with the second slope, and pixels
/// are full at 2, 6 and 15 times the light.
#[test]
fn slopes_stretch_the_range() {
    for hdr in [Hdr::None, Hdr::Soft, Hdr::Medium, Hdr::Aggressive] {
        for over in [0.3, 0.8, 1.5, 4.0, 12.0] {
            let mut scene = white(200);
            scene.bench.exposure.time_us *= over;
            scene.readout = Readout { bits: 12, hdr };
            let exposure = scene.bench.exposure;
            let scale = scene.readout.scale();
            let full = scale * (255.0 - exposure.dark_level_dn);
            let gain = full / exposure.full_well_e;
            let (sensor, band) = sensor(&scene);
            let mut scratch = Scratch::default();
            sensor.window(&band, BARE, 0, &mut scratch);
            let pixels = in_time(&scene);
            let columns = pixels.len() / ROWS;
            let row = ROWS / 2;
            let light = gain * f64::from(scratch.electrons(row, 0));
            let [mean, variance] = means(&pixels[row * columns..(row + 1) * columns]);
            let rest = 0.5 / hdr.gain();
            let (level, noisy) = if hdr == Hdr::None || light * (1.0 - rest) <= 0.5 * full {
                (light, light)
            } else {
                (0.5 * full + rest * light, rest * light)
            };
            if level > 0.97 * full {
                assert!(level < 1.03 * full || mean > f64::from(scene.readout.most()) - 0.5, "{hdr:?} {over}: {mean}");
                continue;
            }
            // The row's own pattern is 0.2 DN of 8 bits.
            let dark = exposure.dark_level_dn * scale;
            assert!((mean - dark - level).abs() < 0.8 * scale, "{hdr:?} {over}: {} for {level}", mean - dark);
            let expected =
                (exposure.dark_noise_dn.powi(2) - exposure.row_pattern_dn.powi(2)) * scale * scale + gain * noisy;
            // 128 columns times 199, of which row noise is common: 1.6 %, four of which.
            assert!((variance / expected - 1.0).abs() < 0.065, "{hdr:?} {over}: variance {variance} for {expected}");
        }
    }
}
