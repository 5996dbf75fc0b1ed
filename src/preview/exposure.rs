//! One exposure of a sample with the line that extraction finds in it, before any drawing.

use crate::extract::{Profile, extract};
use crate::frame::Frame;
use crate::optics::Band;
use crate::optics::speckle::Tiles;
use crate::pipeline;
use crate::recipe::Scene;
use crate::settings::RangeForm;

/// Sensor rows kept above and below the line [px].
const AROUND: usize = 24;

/// A sensor frame, cut to the rows around the line, and what extraction reads from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Exposure {
    /// Number of the profile in the scan.
    pub profile: usize,
    /// Profiles in the scan.
    pub profiles: usize,
    /// Where the profile lies along the scan [mm].
    pub y_mm: f64,
    /// Columns of the sensor [px].
    pub cols: usize,
    /// First sensor row of the cut [px].
    pub first_row: usize,
    /// Digital numbers `[rows, cols]`, row-major [DN].
    pub dn: Vec<u16>,
    /// Greatest digital number [DN].
    pub most: u16,
    /// Sensor row of the line in each column; NaN where none is found [px].
    pub line: Vec<f32>,
    /// Place along the laser line and height of each column; NaN where none is found [mm].
    pub points: Vec<[f64; 2]>,
}

/// Exposes profile `profile` of a scene and reads it.
pub fn exposure(scene: &Scene, profile: usize, tiles: &Tiles) -> Exposure {
    let (columns, rows) = (scene.size.columns, scene.size.rows);
    let profile = profile.min(scene.size.profiles.saturating_sub(1));
    let (sensor, specimen) = pipeline::set_up(scene, pipeline::body(scene), tiles);
    let band = sensor.band(&specimen, profile..profile + 1, Band::default());
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
    let mut out = Profile { range: &mut line, reflectance: &mut reflectance, scatter: &mut scatter };
    let dn = frame.dn.clone();
    extract(&[frame, Frame::default()], &calibration, &settings, &mut out);
    let reading = calibration.rig.reading();
    let place = |(column, row): (usize, &f32)| reading.locate(column as f64, f64::from(*row));
    let points = line.iter().enumerate().map(place).collect();
    let known = || line.iter().filter(|row| !row.is_nan());
    let first = known().copied().fold(f32::INFINITY, f32::min).min(rows as f32) as usize;
    let last = known().copied().fold(f32::NEG_INFINITY, f32::max).max(0.0) as usize;
    let (first, end) =
        if known().count() == 0 { (0, rows) } else { (first.saturating_sub(AROUND), (last + AROUND + 1).min(rows)) };
    Exposure {
        profile,
        profiles: scene.size.profiles,
        y_mm: profile as f64 * scene.bench.motion.step_mm,
        cols: columns,
        first_row: first,
        dn: dn.get(first * columns..end * columns).unwrap_or_default().to_vec(),
        most: scene.readout.most(),
        line,
        points,
    }
}
