//! Readout: from electrons to digital numbers, after EMVA 1288 (release 4.0).
//!
//! Takes the electrons of windows ([`crate::optics::window::Window`]); gives frames. [`SignalChain`] is all that stands
//! between charge and number; [`Digitiser`] takes windows through speckle and the chain, and full frames
//! (`full_frame.rs`) take the rows outside of windows through it. [`ThesisScripts`] stand in its place where a recipe
//! asks for them.
//!
//! ```text
//! e = slopes((1 + PRNU) light)                        charge, at most two slopes
//! y = clip(round(K (e + dark current) + offset + noise), 0, most)
//! offset = dark level + row noise + row pattern + column pattern + DSNU,   K = (most - dark level) / full well
//! ```
//!
//! `most` is 255, 1023 or 4095; recipes count DN on the scale of 8 bits, so that one recipe is one sensor whatever the
//! converter: everything in DN is multiplied by most / 255 here, only rounding stays 1/12 of a step squared. Shot noise
//! is Poisson; it is drawn as a normal of the same variance together with the read noise, which at the 100 electrons of
//! read noise differs from the exact sum by less than 0.01 in any quantile's standard score. A pixel that holds more
//! than its full well reads the greatest number whatever the noise, as if the converter ended just below.
//!
//! Two slopes (multiple slope integration with one knee; Ranger3 manual, "HDR"): at the time t1 = (1 - r) T a pixel
//! above the barrier B is set back to B and goes on. With phi the charge without the barrier
//!
//! ```text
//! e = phi,            phi <= B / (1 - r)
//! e = B + r phi,      above;         full at phi = (full well - B) / r
//! ```
//!
//! With B half of the full well and r = 1 / (2 g) the range grows by g = 2, 6, 15. Above the knee only photons of the
//! second slope make noise, variance r phi: what came before was cut off. Neglected: noise of setting back, pixels near
//! the knee that are set back by chance, spread of the barrier, pixels' own dark current, light that leaks into the
//! stored charge.
//!
//! An effect is a file here and what this file says of it: a field of the chain, made in `new`, and its place in the
//! order of things. That is `develop` for what a pixel does by itself, `spread` for what pixels do to each other, and
//! `fixed_pattern.rs` for what differs from pixel to pixel or by columns. An effect is off by default, or as small as
//! on a real rig, and free when off: `is_plain` has to know it. Where a pixel tells of others, `rows_are_alone` must
//! know it, and where a pixel reads more than its own light, `greatest_level`: otherwise rows are left out in which it
//! would show.

mod blooming;
mod digitise;
mod fixed_pattern;
mod postprocess;

use base::{Stream, normal};
use numerics::lanes;
use optical_bench::parameters::ExposureParameters;
use optical_bench::settings::{Hdr, Readout, Size};

use self::fixed_pattern::{CodeSteps, FixedPattern};
use super::window::WindowSignal;

pub(crate) use self::digitise::{Digitiser, TileExposure};
pub use self::postprocess::FrameLight;
pub(crate) use self::postprocess::ThesisScripts;

/// The barrier over the full well [1].
const BARRIER_SHARE: f64 = 0.5;

/// The chain of one sensor.
#[derive(Debug, Clone)]
pub(crate) struct SignalChain {
    /// Digital numbers per electron [DN/e-].
    pub gain: f32,
    /// Mean digital number without light [DN].
    pub dark_level: f32,
    /// Variance of read noise of a pixel alone, and of dark current [DN^2].
    pub read_variance: f32,
    /// Photon noise's variance over the signal [DN].
    pub shot: f32,
    /// Where pixels differ; `None` where all are alike.
    pub pixels: Option<FixedPattern>,
    /// The knee.
    pub slopes: Slopes,
    /// Signal at which a pixel is full [DN over dark].
    full: f32,
    /// Share of the charge above that which flows on [1].
    blooming: f32,
    /// Greatest digital number [DN].
    pub max_dn: f32,
    /// Fixed offsets of the rows [DN].
    pattern: Vec<f32>,
    /// Standard deviation of the rows' offsets that change [DN].
    row_noise: f32,
    stream: Stream,
}

/// Response with one knee, of signals over dark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Slopes {
    /// Signal from which the second slope counts [DN]; infinite for one slope.
    pub knee: f32,
    /// Where the second slope would start without light [DN].
    pub barrier: f32,
    /// The second slope [1].
    pub second: f32,
}

impl Slopes {
    /// Of a pixel that is full at `full` [DN].
    fn new(hdr: Hdr, full: f64) -> Self {
        if hdr == Hdr::None {
            return Self { knee: f32::INFINITY, barrier: 0.0, second: 0.0 };
        }
        let rest = (1.0 - BARRIER_SHARE) / hdr.gain();
        let barrier = BARRIER_SHARE * full;
        Self { knee: (barrier / (1.0 - rest)) as f32, barrier: barrier as f32, second: rest as f32 }
    }

    /// What is read of `signal`, and the part of it that makes photon noise [DN].
    #[inline(always)]
    fn respond(&self, signal: f32) -> (f32, f32) {
        let late = self.second * signal;
        if signal > self.knee { (self.barrier + late, late) } else { (signal, signal) }
    }
}

impl SignalChain {
    /// The chain of a sensor of `size`; `stream` belongs to the sample.
    pub fn new(exposure: &ExposureParameters, readout: Readout, size: &Size, stream: Stream) -> Self {
        let scale = readout.scale();
        let full = (255.0 - exposure.dark_level_dn) * scale;
        let gain = full / exposure.full_well_e;
        let offsets = exposure.row_noise_dn.powi(2)
            + exposure.row_pattern_dn.powi(2)
            + exposure.column_pattern_dn.powi(2)
            + exposure.dsnu_dn.powi(2);
        let own = exposure.dark_noise_dn.powi(2) - offsets;
        let gathered = exposure.dark_current_e_per_s * exposure.time_us * 1e-6;
        let read = (own * scale * scale - 1.0 / 12.0).max(0.0);
        let mut rng = stream.child("row_pattern").rng();
        let row = |rng: &mut _| (exposure.row_pattern_dn * scale * normal(rng)) as f32;
        Self {
            gain: gain as f32,
            dark_level: (exposure.dark_level_dn * scale + gain * gathered) as f32,
            read_variance: (read + exposure.shot_noise * gain * gain * gathered) as f32,
            shot: (exposure.shot_noise * gain) as f32,
            pixels: FixedPattern::new(exposure, scale, size, stream.child("pixel")),
            slopes: Slopes::new(readout.hdr, full),
            full: full as f32,
            blooming: exposure.blooming as f32,
            max_dn: f32::from(readout.most()),
            pattern: (0..size.rows).map(|_| row(&mut rng)).collect(),
            row_noise: (exposure.row_noise_dn * scale) as f32,
            stream,
        }
    }

    /// What a pixel by itself makes of a signal over dark: what is read, the part of it that makes photon noise, and
    /// its `offset` [DN].
    #[inline(always)]
    pub fn develop(&self, signal: f32, offset: f32) -> [f32; 3] {
        let (level, noisy) = self.slopes.respond(signal);
        [level, noisy, offset]
    }

    /// Whether pixels do something to each other.
    pub fn spreads(&self) -> bool {
        self.blooming > 0.0
    }

    /// What pixels do to each other, between what each has made of its light and the noise.
    pub fn spread(&self, signal: &mut WindowSignal) {
        signal.bloom(self.full, self.blooming);
    }

    /// Whether nothing but gain and noise stands between charge and number.
    pub fn is_plain(&self) -> bool {
        self.pixels.is_none() && !self.spreads() && self.slopes.knee == f32::INFINITY
    }

    /// Greatest level over dark, and greatest standard deviation of what noise adds to it, of pixels without defect on
    /// which no more than `light` falls [e-] [DN].
    #[inline(always)]
    pub fn greatest_level(&self, light: f32) -> (f32, f32) {
        let most = self.pixels.as_ref().map_or(1.0, FixedPattern::greatest_response);
        let signal = self.gain * light * most;
        let (level, noisy) = self.slopes.respond(signal);
        // Above the knee there is less noise than right below it.
        let noisy = noisy.max(signal.min(self.slopes.knee));
        (level, (self.read_variance + self.shot * noisy).sqrt())
    }

    /// Whether charge stays where light falls and no pixel is defective, so that a row of pixels tells nothing of
    /// others.
    pub fn rows_are_alone(&self) -> bool {
        !self.spreads() && self.pixels.as_ref().is_none_or(|pixels| !pixels.has_defects())
    }

    /// What pixels' codes mean.
    pub fn steps(&self) -> CodeSteps {
        self.pixels.as_ref().map_or(CodeSteps::default(), |pixels| pixels.steps)
    }

    /// Offsets of every row in exposure `profile`, dark level included [DN].
    pub fn row_offsets(&self, profile: usize, offsets: &mut Vec<f32>) {
        let keys = self.keys("row_noise", profile);
        offsets.clear();
        offsets.extend(self.pattern.iter().enumerate().map(|(row, fixed)| {
            let (normal, _) = lanes::normals(row as u32, keys);
            self.dark_level + fixed + self.row_noise * normal
        }));
    }

    /// Keys of the pixels' noise in exposure `profile`.
    pub fn keys(&self, name: &str, profile: usize) -> [u32; 2] {
        let key = self.stream.child(name).index(profile as u64).key();
        [key as u32, (key >> 32) as u32]
    }

    /// The number of a pixel of the sensor, of its light [e-], a standard normal and the offset of its row [DN].
    pub fn number(&self, [row, column]: [usize; 2], light: f32, normal: f32, offset: f32) -> u16 {
        let (response, shift) = self.pixels.as_ref().map_or((1.0, 0.0), |pixels| pixels.at(row, column));
        self.digitise(self.develop(response * (self.gain * light), offset + shift), normal)
    }

    /// One digital number: `level` [DN over dark], the part of it that makes photon noise [DN], a standard normal and
    /// the pixel's offset [DN].
    #[inline(always)]
    pub fn digitise(&self, [level, noisy, offset]: [f32; 3], normal: f32) -> u16 {
        let noise = (self.read_variance + self.shot * noisy).sqrt() * normal;
        let floor = if level < self.max_dn - self.dark_level { 0.0 } else { self.max_dn };
        // Rounding to even at halves, as the sum with 1.5 * 2^23 does it; the clamp keeps it in range.
        let level = (level + noise + offset).clamp(0.0, self.max_dn);
        // A full pixel reads the greatest number; a choice between two numbers, so that the loop stays vector code.
        let level = level.max(floor);
        ((level + 12_582_912.0).to_bits() & 0xffff) as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The knee does not jump, the first slope is 1, and a pixel is full at 2, 6 and 15 times the light of one slope;
    /// of that only the second slope's share makes noise.
    #[test]
    fn slopes_meet_and_stretch_the_range() {
        let full = 243.4;
        for hdr in [Hdr::Soft, Hdr::Medium, Hdr::Aggressive] {
            let slopes = Slopes::new(hdr, full);
            let below = slopes.respond(slopes.knee * (1.0 - 1e-6)).0;
            let above = slopes.respond(slopes.knee * (1.0 + 1e-6)).0;
            assert!((above - below).abs() < 1e-3, "{hdr:?}: {below} and {above} at the knee");
            assert_eq!(slopes.respond(50.0), (50.0, 50.0));
            let most = (hdr.gain() * full) as f32;
            let (level, noisy) = slopes.respond(most);
            assert!((f64::from(level) / full - 1.0).abs() < 1e-5, "{hdr:?}: {level} at {most}");
            // Half of the full well came after the barrier.
            assert!((f64::from(noisy) / full - 0.5).abs() < 1e-5, "{hdr:?}: {noisy} is noisy at {most}");
        }
        assert_eq!(Slopes::new(Hdr::None, full).respond(1e6), (1e6, 1e6));
    }
}
