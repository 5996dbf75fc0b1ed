//! From electrons to digital numbers, after EMVA 1288.
//!
//! y = clip(round(K e + noise + row + offset), 0, 255), K = (255 - offset) / full well. Shot noise is
//! Poisson; it is drawn as a normal of the same variance together with the read noise, which at the 100 electrons of
//! read noise of an 8-bit gain differs from the exact sum by less than 0.01 in any quantile's standard score. Dark noise
//! is split into pixel, row (each exposure anew) and row pattern (fixed). Not modelled here: differences between pixels
//! (PRNU, DSNU), dark current, blooming, several slopes.

use procedural::{Stream, normal};

use super::parameters::Exposure;
use crate::lanes;

/// The chain of one sensor.
#[derive(Debug, Clone)]
pub struct Chain {
    /// Digital numbers per electron [DN/e-].
    pub gain: f32,
    /// Mean digital number without light [DN].
    pub dark_level: f32,
    /// Variance of read noise of a pixel alone [DN^2].
    pub read_variance: f32,
    /// Photon noise's variance over the signal [DN].
    pub shot: f32,
    /// Fixed offsets of the rows [DN].
    pattern: Vec<f32>,
    /// Standard deviation of the rows' offsets that change [DN].
    row_noise: f64,
    stream: Stream,
}

impl Chain {
    /// The chain of a sensor of `rows` rows; `stream` belongs to the sample.
    pub fn new(exposure: &Exposure, rows: usize, stream: Stream) -> Self {
        let full = 255.0 - exposure.dark_level_dn;
        let gain = full / exposure.full_well_e;
        let rest = exposure.dark_noise_dn.powi(2)
            - exposure.row_noise_dn.powi(2)
            - exposure.row_pattern_dn.powi(2)
            - 1.0 / 12.0;
        let mut rng = stream.child("row_pattern").rng();
        let pattern = (0..rows).map(|_| (exposure.row_pattern_dn * normal(&mut rng)) as f32).collect();
        Self {
            gain: gain as f32,
            dark_level: exposure.dark_level_dn as f32,
            read_variance: rest.max(0.0) as f32,
            shot: (exposure.shot_noise * gain) as f32,
            pattern,
            row_noise: exposure.row_noise_dn,
            stream,
        }
    }

    /// Offsets of every row in exposure `profile`, dark level included [DN].
    pub fn rows(&self, profile: usize, offsets: &mut Vec<f32>) {
        let keys = self.keys("row_noise", profile);
        offsets.clear();
        offsets.extend(self.pattern.iter().enumerate().map(|(row, fixed)| {
            let (normal, _) = lanes::normals(row as u32, keys);
            self.dark_level + fixed + self.row_noise as f32 * normal
        }));
    }

    /// Keys of the pixels' noise in exposure `profile`.
    pub fn keys(&self, name: &str, profile: usize) -> [u32; 2] {
        let key = self.stream.child(name).index(profile as u64).key();
        [key as u32, (key >> 32) as u32]
    }

    /// One digital number: `signal` [DN over dark], a standard normal and the row's offset [DN].
    #[inline(always)]
    pub fn digitise(&self, signal: f32, normal: f32, offset: f32) -> u16 {
        let noise = (self.read_variance + self.shot * signal).sqrt() * normal;
        // Rounding to even at halves, as the sum with 1.5 * 2^23 does it; the clamp keeps it in range.
        let level = (signal + noise + offset).clamp(0.0, 255.0);
        ((level + 12_582_912.0).to_bits() & 0xff) as u16
    }
}
