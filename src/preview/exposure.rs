//! One exposure of a profile: the sensor frame around the laser line, and the line that extraction finds in it.

use crate::generate::equipment;
use optical_bench::settings::RangeForm;
use pipeline;
use recipe::Scene;
use scanner::extract::{MeasuredProfile, extract};
use scanner::frame::Frame;
use scanner::optics::Sensor;
use scanner::optics::speckle::PatternCache;
use scanner::specimen::Specimen;
use tools::report::ExposedProfile;

/// Sensor rows kept above and below the line [px].
const MARGIN_ROWS: usize = 24;

/// Exposes profile `profile` of a scene and extracts its line.
pub fn expose_profile(scene: &Scene, profile: usize, patterns: &PatternCache) -> ExposedProfile {
    let (sensor, specimen) = pipeline::set_up(scene, pipeline::body(scene), equipment(patterns));
    exposed(scene, &sensor, &specimen, profile)
}

/// The same of what is set up already.
pub fn exposed(scene: &Scene, sensor: &Sensor, specimen: &Specimen, profile: usize) -> ExposedProfile {
    let (columns, rows) = (scene.size.columns, scene.size.rows);
    let profile = profile.min(scene.size.profiles.saturating_sub(1));
    let band = sensor.band(specimen, profile..profile + 1);
    let frame = if sensor.is_scripted() {
        sensor.processed(&band, profile)
    } else {
        let dn = sensor.full_frame(&band, profile);
        Frame { cols: columns, rows, first_col: 0, first_row: vec![0; columns], dn }
    };
    let (mut line, mut reflectance, mut scatter) = (vec![f32::NAN; columns], vec![0.0; columns], vec![0.0; columns]);
    let mut settings = scene.extraction;
    settings.range = RangeForm::Uncalibrated;
    let calibration = sensor.calibration();
    let mut out = MeasuredProfile { range: &mut line, reflectance: &mut reflectance, scatter: &mut scatter };
    let dn = frame.dn.clone();
    extract(&[frame, Frame::default()], &calibration, &settings, &mut out);
    let back = calibration.rig.back_projection();
    let place = |(column, row): (usize, &f32)| back.locate(column as f64, f64::from(*row));
    let points = line.iter().enumerate().map(place).collect();
    let known = || line.iter().filter(|row| !row.is_nan());
    let first = known().copied().fold(f32::INFINITY, f32::min).min(rows as f32) as usize;
    let last = known().copied().fold(f32::NEG_INFINITY, f32::max).max(0.0) as usize;
    let (first, end) = if known().count() == 0 {
        (0, rows)
    } else {
        (first.saturating_sub(MARGIN_ROWS), (last + MARGIN_ROWS + 1).min(rows))
    };
    ExposedProfile {
        profile,
        profiles: scene.size.profiles,
        y_mm: profile as f64 * scene.bench.motion.step_mm,
        cols: columns,
        first_row: first,
        dn: dn.get(first * columns..end * columns).unwrap_or_default().to_vec(),
        max_dn: scene.readout.most(),
        line,
        points,
    }
}
