//! Disturbance: what an instrument that is not at rest has otherwise from profile to profile.
//!
//! ```text
//! height of all that stands under it   A sin(2 pi f n / r + phase)          r profiles a second
//! power of the laser, over its mean    1 + p g(n) + h m(n), at least 0
//! place of the line along the motion   b m(n)
//! row of the image                     row + d + w n / N + s (row - c_row)   N profiles of the scan, axis at c_row
//! ```
//!
//! One vibration has the amplitude A and a phase of the sample's own. g is standard normal noise with a correlation
//! length ([`super::correlated_noise`]). The diode has two modes, m = -1/2 and 1/2: the sign of such noise of another
//! stream, whose sign changes 1 / (pi l) times a profile for the length l (Rice 1945); l follows from the mean stay. d,
//! w and s are drifts since the calibration, which knows of none of these. Each number is a function of the profile
//! alone, and constant while that is exposed; motion blur goes over to that of the next one.
//!
//! Engineering models. Neglected: what a height of micrometres does to the place along the line (x dz / d, 14 um for 50
//! um at 118 mm), other vibrations than one sine in height, steps of wavelength at a hop, stays in a mode that are
//! shorter than chance has them, drift along the line.

use std::f64::consts::{PI, TAU};

use base::Stream;
use rand::RngExt;

use super::camera::Sight;
use super::correlated_noise::ScanNoise;
use crate::frame::Rig;
use optical_bench::parameters::Bench;

/// What one profile has otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Disturbance {
    /// How high all that stands under the instrument is over where it is at rest [mm].
    pub lift_mm: f32,
    /// How far along the motion the line has jumped [mm].
    beam_mm: f32,
    /// Power of the laser over its mean [1].
    power: f32,
    /// Rows that the image has drifted at row 0, and more of them for each row [px], [1].
    drift: [f32; 2],
}

impl Disturbance {
    /// What it makes of an image of the line.
    pub fn disturb(&self, sight: Sight) -> Sight {
        let row = sight.row - self.beam_mm * sight.rows_per_mm;
        Sight { row: row + self.drift[0] + self.drift[1] * row, electrons: self.power * sight.electrons, ..sight }
    }
}

/// Disturbances of one scan.
#[derive(Debug, Clone)]
pub(crate) struct Disturbances {
    /// Amplitude [mm], angle from profile to profile and in profile 0 [rad].
    vibration: [f64; 3],
    /// Standard deviation of the power over its mean [1], and where in its law each profile is.
    power: Option<(f64, ScanNoise)>,
    /// Difference of the line's places [mm] and of the powers [1] of two modes, and which of them a profile has.
    modes: Option<([f64; 2], ScanNoise)>,
    /// Rows that the image has drifted at row 0 in profile 0, more a profile [px], more a row [1].
    drift: [f64; 3],
}

impl Disturbances {
    /// Of a sample that has `profiles`, to which `stream` belongs, under a camera of the geometry `rig`.
    pub fn new(bench: &Bench, rig: &Rig, profiles: usize, stream: Stream) -> Self {
        let Bench { motion, laser, camera, .. } = bench;
        let rate = motion.line_rate_hz;
        let turn = if rate > 0.0 { TAU * motion.vibration_hz / rate } else { 0.0 };
        let amplitude = if rate > 0.0 { 1e-3 * motion.vibration_um } else { 0.0 };
        let phase = TAU * stream.child("vibration").rng().random::<f64>();
        let hop = [1e-3 * laser.mode_hop_um, laser.mode_hop_power];
        let scale = camera.drift_scale;
        Self {
            vibration: [amplitude, turn, phase],
            power: (laser.power_noise > 0.0)
                .then(|| (laser.power_noise, ScanNoise::new(laser.power_noise_profiles, stream.child("power")))),
            modes: (hop != [0.0; 2]).then(|| (hop, ScanNoise::new(laser.mode_profiles / PI, stream.child("modes")))),
            drift: [camera.drift_rows - scale * rig.centre_row, camera.drift_scan_rows / profiles.max(1) as f64, scale],
        }
    }

    /// What `profile` has otherwise, which may lie before the first; `None` for an instrument at rest.
    pub fn at(&self, profile: isize) -> Option<Disturbance> {
        let ([amplitude, turn, phase], [first, further, scale]) = (self.vibration, self.drift);
        if amplitude == 0.0 && self.power.is_none() && self.modes.is_none() && self.drift == [0.0; 3] {
            return None;
        }
        let n = profile as f64;
        let noise = self.power.as_ref().map_or(0.0, |(deviation, noise)| deviation * noise.at(profile));
        let [beam, step] = self.modes.as_ref().map_or([0.0; 2], |(hop, noise)| {
            let mode = 0.5f64.copysign(noise.at(profile));
            hop.map(|hop| mode * hop)
        });
        Some(Disturbance {
            lift_mm: (amplitude * libm::sin(turn * n + phase)) as f32,
            beam_mm: beam as f32,
            power: (1.0 + noise + step).max(0.0) as f32,
            drift: [(first + further * n) as f32, scale as f32],
        })
    }
}
