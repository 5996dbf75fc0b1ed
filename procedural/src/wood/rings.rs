//! Annual rings: how wide they are and how wood changes through each of them.
//!
//! Models: ring widths w_i = exp(m + s a_i), a_i = rho a_(i-1) + sqrt(1 - rho^2) e_i with standard normal e_i, so that
//! every width is lognormal with the asked mean and the logarithms follow a first-order autoregression. Within a ring
//! earlywood passes gradually into latewood, which ends at the boundary (conifers): at once, or as 1 - smoothstep over
//! the first part of the next ring, as sawn faces show it, whose torn fibres blur the boundary. The latewood keeps
//! about its width, so that wide rings have a smaller share of it. Age: ring number n from the pith is wider than that
//! by 1 + (p - 1) exp(-n / N), with p the ratio at the pith and N the rings of the trend; in the juvenile core of J
//! rings the share of latewood is smaller by q + (1 - q) n / J. Both are 1 by default. Sources: forestry practice for
//! the numbers (docs/theory/wood.md); that rings fall in width outwards and that the core has less latewood is common
//! knowledge, the forms and the numbers of both are guesses. Limits: no false rings, no growth stress; the core's
//! fibres have the angles and the dispersion of those outside of it.

use base::{Stream, normal};

use super::parameters::Log;
use crate::noise::smoothstep;

/// Spread of the absorption from ring to ring [1].
const GAIN_SD: f64 = 0.08;
/// The gain stays within this distance of 1 [1].
const GAIN_LIMIT: f64 = 0.3;
/// Half width of the change from early- to latewood over the latewood's share [1].
const RAMP_PER_SHARE: f64 = 0.6;
/// The most that half width may be [ring].
const RAMP_LIMIT: f64 = 0.15;
/// The latewood share of a ring stays within this factor of the mean share [1].
const SHARE_FACTOR: f64 = 2.0;
/// No ring is thinner [mm]: one row of cells.
const THINNEST_MM: f64 = 0.03;

#[derive(Debug, Clone, Copy)]
struct Ring {
    /// Inner boundary [mm].
    start: f32,
    /// One over the width [mm^-1].
    per_width: f32,
    /// Where the change to latewood begins and ends [ring].
    ramp: [f32; 2],
    /// Factor on the absorption [1].
    gain: f32,
}

/// All rings from the pith outwards.
#[derive(Debug, Clone)]
pub(super) struct Rings {
    rings: Vec<Ring>,
    /// Ring at the start of each stretch of one mean width.
    index: Vec<u32>,
    /// One over the mean width [mm^-1].
    per_mean: f32,
    /// Distance behind a boundary over which the latewood before it ends [mm].
    end: f32,
}

/// Wood within its ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RingPhase {
    /// Share of latewood, 0 to 1 [1].
    pub latewood: f32,
    /// Factor on the absorption of the whole ring [1].
    pub gain: f32,
}

/// Width of a ring over what it would be far out, by the rings inside of it [1].
fn width_trend(log: &Log, age: f64) -> f64 {
    1.0 + (log.ring_width_pith_ratio - 1.0) * libm::exp(-age / log.ring_width_trend_rings)
}

/// Share of latewood in a ring over what it would be outside of the juvenile core, by the rings inside of it [1].
fn juvenile_share(log: &Log, age: f64) -> f64 {
    if age >= log.juvenile_rings {
        return 1.0;
    }
    log.juvenile_latewood_ratio + (1.0 - log.juvenile_latewood_ratio) * age / log.juvenile_rings
}

impl Rings {
    /// Rings out to `reach` [mm].
    pub fn grow(stream: Stream, log: &Log, reach: f32) -> Self {
        let (mut widths, mut gains) = (stream.child("widths").rng(), stream.child("gains").rng());
        let (sd, rho) = (log.ring_width_log_sd, log.ring_width_correlation);
        let log_mean = libm::log(log.ring_width_mm) - 0.5 * sd * sd;
        let mut state = normal(&mut widths);
        let mut start = 0.0_f64;
        let mut rings = Vec::new();
        while start <= f64::from(reach) {
            let age = rings.len() as f64;
            let drawn = libm::exp(log_mean + sd * state);
            let width = (drawn * width_trend(log, age)).max(THINNEST_MM);
            let share = log.latewood_share * (log.ring_width_mm / width).clamp(1.0 / SHARE_FACTOR, SHARE_FACTOR);
            let share = share * juvenile_share(log, age);
            let share = share.min(0.9);
            let half = (RAMP_PER_SHARE * share).min(RAMP_LIMIT).min(1.0 - share);
            let gain = 1.0 + (GAIN_SD * normal(&mut gains)).clamp(-GAIN_LIMIT, GAIN_LIMIT);
            rings.push(Ring {
                start: start as f32,
                per_width: (1.0 / width) as f32,
                ramp: [(1.0 - share - half) as f32, (1.0 - share + half) as f32],
                gain: gain as f32,
            });
            start += width;
            state = rho * state + (1.0 - rho * rho).sqrt() * normal(&mut widths);
        }
        let per_mean = (1.0 / log.ring_width_mm) as f32;
        let stretches = (reach * per_mean) as usize + 2;
        let index = (0..stretches).map(|i| rings.partition_point(|ring| ring.start * per_mean <= i as f32) as u32 - 1);
        Self { index: index.collect(), rings, per_mean, end: log.latewood_end_mm as f32 }
    }

    /// Outer boundary of the last ring [mm].
    #[cfg(test)]
    pub fn end(&self) -> f32 {
        self.rings.last().map_or(0.0, |ring| ring.start + 1.0 / ring.per_width)
    }

    /// The ring that grew when the trunk had the radius `t` [mm], which is not negative.
    #[inline]
    fn ring(&self, t: f32) -> &Ring {
        let stretch = ((t * self.per_mean) as usize).min(self.index.len() - 1);
        let mut i = self.index[stretch] as usize;
        while i + 1 < self.rings.len() && self.rings[i + 1].start <= t {
            i += 1;
        }
        &self.rings[i]
    }

    /// Inner boundary of the ring that grew when the trunk had the radius `t` [mm].
    #[inline]
    pub fn boundary(&self, t: f32) -> f32 {
        self.ring(t.max(0.0)).start
    }

    /// Wood that grew when the trunk had the radius `t` [mm].
    #[inline]
    pub fn at(&self, t: f32) -> RingPhase {
        let t = t.max(0.0);
        let ring = self.ring(t);
        let into = t - ring.start;
        let mut latewood = smoothstep(ring.ramp[0], ring.ramp[1], into * ring.per_width);
        if into < self.end && ring.start > 0.0 {
            latewood = latewood.max(1.0 - smoothstep(0.0, self.end, into));
        }
        RingPhase { latewood, gain: ring.gain }
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::wood::Wood;

    fn rings(reach: f32) -> (Rings, Log) {
        let log = Wood::from_values(&mut |p| p.default).log;
        (Rings::grow(Stream::root(5).child("rings"), &log, reach), log)
    }

    #[test]
    fn widths_follow_a_lognormal_autoregression() {
        let (rings, log) = rings(40_000.0);
        let logs: Vec<f64> = rings.rings.iter().map(|ring| -f64::from(ring.per_width).ln()).collect();
        let n = logs.len() as f64;
        let mean = logs.iter().sum::<f64>() / n;
        let variance = logs.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
        let lagged = logs.windows(2).map(|w| (w[0] - mean) * (w[1] - mean)).sum::<f64>() / n;
        let (sd, rho) = (log.ring_width_log_sd, log.ring_width_correlation);
        // 3 tests, alpha 0.001 in all: 3.6 standard errors of an AR(1) process of n values (Bartlett's formulas).
        let z = 3.6;
        let stretch = ((1.0 + rho) / (1.0 - rho)).sqrt();
        assert!(
            (mean - (libm::log(log.ring_width_mm) - 0.5 * sd * sd)).abs() < z * sd * stretch / n.sqrt(),
            "mean {mean}"
        );
        let doubled = ((1.0 + rho * rho) / (1.0 - rho * rho)).sqrt();
        assert!((variance / (sd * sd) - 1.0).abs() < z * 2.0_f64.sqrt() * doubled / n.sqrt(), "variance {variance}");
        let r1 = lagged / variance;
        assert!((r1 - rho).abs() < z * ((1.0 - rho * rho) / n).sqrt(), "correlation {r1}");
    }

    /// With every trend, each ring has its drawn width times the trend, and the share of latewood that goes with the
    /// width and the core.
    #[test]
    fn rings_fall_in_width_outwards_and_the_core_has_less_latewood() {
        for case in 0..12 {
            let mut draws = Stream::root(case).child("age").rng();
            let mut draw = |low: f64, high: f64| low + (high - low) * draws.random::<f64>();
            let mut log = Wood::from_values(&mut |p| p.default).log;
            let grow = |log: &Log| Rings::grow(Stream::root(case).child("rings"), log, 150.0).rings;
            let plain = grow(&log);
            (log.ring_width_pith_ratio, log.ring_width_trend_rings) = (draw(0.3, 5.0), draw(1.0, 60.0));
            (log.juvenile_rings, log.juvenile_latewood_ratio) = (draw(0.0, 40.0).round(), draw(0.05, 1.0));
            let aged = grow(&log);
            let (mut drawn, mut grown) = (0.0, 0.0);
            for (n, (ring, before)) in aged.iter().zip(&plain).enumerate() {
                let age = n as f64;
                let trend = 1.0 + (log.ring_width_pith_ratio - 1.0) * (-age / log.ring_width_trend_rings).exp();
                let width = 1.0 / f64::from(ring.per_width);
                assert!((width * f64::from(before.per_width) / trend - 1.0).abs() < 1e-5, "ring {n}: {width}");
                (drawn, grown) = (drawn + trend / f64::from(before.per_width), grown + width);
                let core = if age < log.juvenile_rings {
                    let q = log.juvenile_latewood_ratio;
                    q + (1.0 - q) * age / log.juvenile_rings
                } else {
                    1.0
                };
                let share = core * log.latewood_share * (log.ring_width_mm / width).clamp(0.5, 2.0);
                let held = 1.0 - 0.5 * f64::from(ring.ramp[0] + ring.ramp[1]);
                assert!((held - share).abs() < 1e-5, "ring {n}: {held} against {share}");
            }
            assert!((grown / drawn - 1.0).abs() < 0.02, "{grown} mm of rings, {drawn} drawn");
        }
    }

    #[test]
    fn latewood_ends_abruptly_at_the_cumulative_widths() {
        let (rings, _) = rings(200.0);
        let mut boundary = 0.0_f64;
        for ring in &rings.rings[..rings.rings.len() - 1] {
            boundary += 1.0 / f64::from(ring.per_width);
            let (inside, outside) = (rings.at(boundary as f32 - 1.0e-3), rings.at(boundary as f32 + 1.0e-3));
            assert!(inside.latewood > 0.99 && outside.latewood < 0.01, "at {boundary}: {inside:?} {outside:?}");
        }
    }

    #[test]
    fn a_ring_holds_its_share_of_latewood() {
        let (rings, log) = rings(50.0);
        for (ring, next) in rings.rings.iter().zip(&rings.rings[1..]) {
            let n = 2000;
            let step = (next.start - ring.start) / n as f32;
            let held = (0..n).map(|i| rings.at(ring.start + (i as f32 + 0.5) * step).latewood).sum::<f32>() / n as f32;
            let width = 1.0 / f64::from(ring.per_width);
            let share = log.latewood_share * (log.ring_width_mm / width).clamp(0.5, 2.0);
            // The change is symmetric about 1 - share, so the mean is the share itself.
            assert!((f64::from(held) - share).abs() < 2.0e-3, "held {held}, share {share}");
        }
    }
}
