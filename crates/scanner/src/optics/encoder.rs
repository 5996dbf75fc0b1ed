//! Encoder: the position of the object when a profile is taken.
//!
//! Profile n is wanted at n steps. The encoder triggers it with two errors: jitter, which is new with each profile, and
//! wow, which comes again with each turn of a wheel whose axis is off its middle:
//!
//! ```text
//! y(n) = n step + A sin(2 pi n step / P + phase) + jitter(n)
//! ```
//!
//! with a phase of the sample's own. Profiles never change places: the jitter is cut at 0.45 of the smallest distance
//! that the periodic error leaves between two profiles, 1 - 2 pi A / P steps, and recipes are held to 2 pi A / P <=
//! 1/2. Labels and truth belong to the place where the object really stands; a reader of the scan believes in even
//! steps.
//!
//! Neglected: slip, vibration across the motion. `unrest.rs` has that in height.

use std::f64::consts::TAU;

use crate::specimen::turntable::Turntable;
use base::Stream;
use numerics::lanes;
use optical_bench::parameters::MotionParameters;
use optical_bench::settings::Movement;

/// Largest jitter over the smallest step [1].
const MAX_JITTER_SHARE: f64 = 0.45;

/// Where an object turns; `None` for a straight way.
pub fn turn(motion: &MotionParameters, movement: Movement) -> Option<Turntable> {
    let turn = Turntable { axis: [motion.turn_axis_x_mm, motion.turn_axis_y_mm], radius: motion.turn_radius_mm };
    (movement == Movement::Turntable).then_some(turn)
}

/// The places of the profiles of one sample.
#[derive(Debug, Clone)]
pub struct Encoder {
    step: f64,
    jitter: f64,
    /// Where jitter is cut [mm].
    cut: f64,
    wow: f64,
    turn_per_mm: f64,
    phase: f64,
    keys: [u32; 2],
}

impl Encoder {
    /// For one sample, to which `stream` belongs.
    pub fn new(motion: &MotionParameters, stream: Stream) -> Self {
        use rand::RngExt;
        let (wow, turn_per_mm) = (1e-3 * motion.wow_um, TAU / motion.wow_period_mm);
        let key = stream.child("jitter").key();
        Self {
            step: motion.step_mm,
            jitter: 1e-3 * motion.encoder_jitter_um,
            cut: MAX_JITTER_SHARE * motion.step_mm * (1.0 - wow * turn_per_mm).max(0.0),
            wow,
            turn_per_mm,
            phase: TAU * stream.child("wow").rng().random::<f64>(),
            keys: [key as u32, (key >> 32) as u32],
        }
    }

    /// Place of a profile, which may lie before the first [mm].
    pub fn position(&self, profile: isize) -> f64 {
        let even = profile as f64 * self.step;
        let mut place = even;
        if self.wow > 0.0 {
            place += self.wow * libm::sin(self.turn_per_mm * even + self.phase);
        }
        if self.jitter > 0.0 {
            let (normal, _) = lanes::normals(profile as u32, self.keys);
            place += (self.jitter * f64::from(normal)).clamp(-self.cut, self.cut);
        }
        place
    }

    /// Whether each step is like the others.
    pub fn even(&self) -> bool {
        self.wow == 0.0 && self.jitter == 0.0
    }

    /// The profile nearest to `away` [mm] behind `profile`, as an offset within `most` either way.
    pub fn nearest(&self, profile: isize, away: f64, most: isize) -> isize {
        let wanted = self.position(profile) + away;
        let miss = |offset: isize| (self.position(profile + offset) - wanted).abs();
        let mut offset = ((away / self.step).round() as isize).clamp(-most, most);
        // Places are in order, so the way there is downhill.
        while offset < most && miss(offset + 1) < miss(offset) {
            offset += 1;
        }
        while offset > -most && miss(offset - 1) < miss(offset) {
            offset -= 1;
        }
        offset
    }

    /// Profiles that lie within `away` [mm] at most.
    pub fn within(&self, away: f64) -> usize {
        let least = self.step * (1.0 - self.wow * self.turn_per_mm).max(0.1);
        (away / least).round() as usize + usize::from(!self.even())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion() -> MotionParameters {
        MotionParameters::from_values(&mut |p| p.default)
    }

    /// A thousand places spread by the jitter around even ones, each on its own; no jitter makes two change places.
    #[test]
    fn jitter_is_new_each_profile_and_keeps_the_order() {
        let mut motion = motion();
        motion.encoder_jitter_um = 2.0;
        let encoder = Encoder::new(&motion, Stream::root(1));
        let off: Vec<f64> = (0..4000).map(|n| 1e3 * (encoder.position(n) - n as f64 * 0.068)).collect();
        let n = off.len() as f64;
        let mean = off.iter().sum::<f64>() / n;
        let variance = off.iter().map(|v| v * v).sum::<f64>() / n;
        let alike = off.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n / variance;
        // Standard errors 2 / sqrt(n), 1 / sqrt(2 n) of the deviation, 1 / sqrt(n); four of each.
        assert!(mean.abs() < 4.0 * 2.0 / n.sqrt(), "mean {mean} um");
        assert!((variance.sqrt() / 2.0 - 1.0).abs() < 4.0 / (2.0 * n).sqrt(), "deviation {} um", variance.sqrt());
        assert!(alike.abs() < 4.0 / n.sqrt(), "neighbours {alike}");
        (motion.encoder_jitter_um, motion.wow_um, motion.wow_period_mm) = (1000.0, 500.0, 10.0);
        let wild = Encoder::new(&motion, Stream::root(1));
        assert!((-50..4000).all(|n| wild.position(n + 1) > wild.position(n)), "profiles change places");
    }

    /// The periodic error alone: amplitude and period as asked for, and the nearest profile is the nearest.
    #[test]
    fn wow_comes_again_and_the_nearest_profile_is_found() {
        let mut motion = motion();
        (motion.wow_um, motion.wow_period_mm) = (300.0, 6.8);
        let encoder = Encoder::new(&motion, Stream::root(2));
        let off: Vec<f64> = (0..300).map(|n| encoder.position(n) - n as f64 * 0.068).collect();
        let most = off.iter().fold(0.0f64, |most, v| most.max(v.abs()));
        assert!((most - 0.3).abs() < 1e-3, "{most}");
        assert!(off.iter().zip(&off[100..]).all(|(a, b)| (a - b).abs() < 1e-9), "not periodic");
        motion.encoder_jitter_um = 15.0;
        let encoder = Encoder::new(&motion, Stream::root(2));
        for profile in [0, 40, 71] {
            for k in -22..=22 {
                let away = 0.1 * f64::from(k);
                let miss =
                    |offset: isize| (encoder.position(profile + offset) - encoder.position(profile) - away).abs();
                let best = (-64..=64).min_by(|a, b| miss(*a).total_cmp(&miss(*b)));
                assert_eq!(Some(encoder.nearest(profile, away, 64)), best, "{profile} {away}");
                assert!(best.is_some_and(|best| best.unsigned_abs() <= encoder.within(2.2)), "{best:?}");
            }
        }
    }
}
