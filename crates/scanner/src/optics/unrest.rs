//! Unrest: what an instrument that is not at rest has otherwise from profile to profile.
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
//! stream. That changes 1 / (pi l) times a profile for the length l (Rice 1945), which follows from the mean stay. d, w
//! and s are drifts since the calibration, which knows of none of these. Each number is a function of the profile
//! alone, and constant while that is exposed; motion blur goes over to that of the next one.
//!
//! Engineering models. Neglected: what a height of micrometres does to the place along the line (x dz / d, 14 um for 50
//! um at 118 mm); vibrations other than one sine in height; steps of wavelength at a hop; drift along the line. A
//! second line has the power of the profile that stands where it lies.

use std::f64::consts::{PI, TAU};

use base::Stream;
use rand::RngExt;

use super::camera::Sight;
use super::correlated_noise::ScanNoise;
use crate::frame::Rig;
use optical_bench::parameters::Bench;

/// What one profile has otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unrest {
    /// How high all that stands under the instrument is over where it is at rest [mm].
    pub lift_mm: f32,
    /// How far along the motion the line has jumped [mm].
    beam_mm: f32,
    /// Power of the laser over its mean [1].
    power: f32,
    /// Rows that the image has drifted at row 0, and more of them for each row [px], [1].
    drift: [f32; 2],
}

impl Unrest {
    /// What it makes of the image of a line.
    pub fn change(&self, sight: Sight) -> Sight {
        let row = sight.row - self.beam_mm * sight.rows_per_mm;
        Sight { row: row + self.drift[0] + self.drift[1] * row, electrons: self.power * sight.electrons, ..sight }
    }
}

/// An instrument that is not at rest, over one scan.
#[derive(Debug, Clone)]
pub(crate) struct UnsteadyRig {
    /// Amplitude [mm], angle from profile to profile and in profile 0 [rad].
    vibration: [f64; 3],
    /// Standard deviation of the power over its mean [1], and where in its law each profile is.
    power: Option<(f64, ScanNoise)>,
    /// Difference of the line's places [mm] and of the powers [1] of two modes, and which of them a profile has.
    modes: Option<([f64; 2], ScanNoise)>,
    /// Rows that the image has drifted at row 0 in profile 0, more a profile [px], more a row [1].
    drift: [f64; 3],
}

impl UnsteadyRig {
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
    pub fn at(&self, profile: isize) -> Option<Unrest> {
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
        Some(Unrest {
            lift_mm: (amplitude * libm::sin(turn * n + phase)) as f32,
            beam_mm: beam as f32,
            power: (1.0 + noise + step).max(0.0) as f32,
            drift: [(first + further * n) as f32, scale as f32],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::camera::rig;
    use optical_bench::settings::Size;

    const SIZE: Size = Size { columns: 128, rows: 832, profiles: 1000 };

    fn of(change: impl Fn(&mut Bench)) -> UnsteadyRig {
        let mut bench = Bench::default();
        change(&mut bench);
        UnsteadyRig::new(&bench, &rig(&bench, &SIZE), SIZE.profiles, Stream::root(5))
    }

    #[test]
    fn rigs_are_at_rest_by_default() {
        let calm = of(|_| ());
        assert!((-50..1000).all(|profile| calm.at(profile).is_none()));
    }

    /// Power has the spread and the correlation asked for, within 4 standard errors; the squared correlation of a
    /// length of 5 profiles has the integral 5 sqrt(pi).
    #[test]
    fn power_is_spread_as_asked_for() {
        let noisy = of(|bench| (bench.laser.power_noise, bench.laser.power_noise_profiles) = (0.02, 5.0));
        let power: Vec<f64> = (0..40_000).map(|n| f64::from(noisy.at(n).expect("noise").power) - 1.0).collect();
        let product = |lag: usize| power.iter().zip(&power[lag..]).map(|(a, b)| a * b).sum::<f64>() / 40_000.0 / 4e-4;
        let error = (2.0 * 5.0 * PI.sqrt() / 40_000.0).sqrt();
        for lag in [0, 3, 5, 10, 20] {
            let law = libm::exp(-0.5 * (lag as f64 / 5.0).powi(2));
            // Linear between nodes: up to 0.8 % of the variance are missing.
            assert!((product(lag) - law).abs() < 4.0 * error + 0.008, "{lag}: {} for {law}", product(lag));
        }
        // A short length: each profile on its own.
        let alone = of(|bench| (bench.laser.power_noise, bench.laser.power_noise_profiles) = (0.02, 0.1));
        let power: Vec<f64> = (0..10_000).map(|n| f64::from(alone.at(n).expect("noise").power) - 1.0).collect();
        let alike = power.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / 1e4 / 4e-4;
        assert!(alike.abs() < 4.0 / 100.0, "{alike}");
    }

    /// The diode has two modes, half of the time each, and changes as often as the law says: arccos(rho) / pi a profile
    /// for the correlation rho of neighbours, within 4 standard errors of a binomial count.
    #[test]
    fn modes_change_as_often_as_asked_for() {
        for stay in [4.0, 25.0] {
            let hops = of(|bench| {
                let laser = &mut bench.laser;
                (laser.mode_hop_um, laser.mode_hop_power, laser.mode_profiles) = (10.0, 0.02, stay);
            });
            let seen: Vec<Unrest> = (0..20_000).map(|n| hops.at(n).expect("a mode")).collect();
            for one in &seen {
                let side = one.beam_mm.signum();
                assert!((one.beam_mm - 0.005 * side).abs() < 1e-7 && (one.power - 1.0 - 0.01 * side).abs() < 1e-6);
            }
            let changes = seen.windows(2).filter(|w| w[0].beam_mm != w[1].beam_mm).count() as f64 / 20_000.0;
            let length = stay / PI;
            let law = libm::acos(libm::exp(-0.5 / (length * length))) / PI;
            assert!((changes - law).abs() < 4.0 * (law / 20_000.0).sqrt() + 0.004 * law, "{changes} for {law}");
            assert!(stay < 20.0 || (law * stay - 1.0).abs() < 0.01, "a stay of {}", 1.0 / law);
            let first = seen.iter().filter(|one| one.beam_mm > 0.0).count() as f64 / 20_000.0;
            assert!((first - 0.5).abs() < 4.0 * 0.5 * (2.0 * stay / 20_000.0).sqrt(), "{first} in the first mode");
        }
    }
}
