//! Frames as the thesis made them: light without speckle, noise or lens blur, then its scripts one after the other.
//!
//! Kihl and Källberg 2021, sections 3.2.1, 3.2.2 and 3.3. The light of a whole frame is what [`super::expose`] gives, in DN
//! over dark; each script works on the whole frame:
//!
//! ```text
//! blur      I <- I * Gaussian of standard deviation `blur_radius_px` in rows and columns
//! speckle   I <- I s p,    p the mean of factor x factor numbers of a pattern of mean 1, s `intensity_scale`
//! noise     I <- I + N(dark level, dark noise)
//! ```
//!
//! and the end is clipped and rounded. The pattern follows Bergmann et al. 2016 (after Duncan and Kirkpatrick 2008): a disc
//! of random phases out of a square, Fourier transformed, squared; its root for the Rayleigh law. The disc's centre moves
//! on a circle of its own radius about the square's middle, by pi a / D from profile to profile, with D the pupil and
//! a = step (d / h + 1 - sin^2 tilt) the shift of the field there (appendix A of the thesis: camera at distance d, laser at
//! height h). Kept as the thesis has it: the pattern lies on the sensor, not on the object; its pitch of a fifth of a
//! pixel takes 1.22 lambda N (1 + m) for lambda N (1 + m), so speckles are 22 % too large (`sampling_factor` 6 is right);
//! pattern coordinates wrap at one less than the side (equation 3.1). Not kept: numbers between patterns of a stack are not
//! interpolated, each profile has a disc of its own; energy is kept by the mean and not by a factor of thumb; scripts pass
//! numbers on without rounding. The spread of the noise includes the final rounding. `physical` orders never come here.

use procedural::Stream;
use rand::RngExt;
use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex32;

use crate::lanes;
use crate::parameters::Bench;
use crate::settings::{Postprocess, Readout, SpeckleLaw, Step};

/// Standard deviations to which the blur reaches.
const REACH: f64 = 4.0;

/// The scripts of one sample.
#[derive(Debug, Clone)]
pub struct Scripts {
    settings: Postprocess,
    /// Random phases `[size, size]`.
    phases: Vec<Complex32>,
    /// Where the disc stands in profile 0, and its turn from profile to profile [rad].
    turns: [f64; 2],
    /// Mean and standard deviation of the noise [DN].
    noise: [f32; 2],
    most: f32,
    stream: Stream,
}

/// Light or numbers of some rows of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Columns [px].
    pub columns: usize,
    /// Sensor row of the first row [px].
    pub first_row: usize,
    /// Numbers `[rows, columns]`, row-major [DN over dark].
    pub numbers: Vec<f32>,
}

impl Scripts {
    /// Of a sample whose bench is `bench`; `stream` belongs to the sample.
    pub fn new(settings: Postprocess, bench: &Bench, readout: Readout, stream: Stream) -> Self {
        let size = settings.pattern.size_px;
        let mut rng = stream.child("phases").rng();
        let phases = (0..size * size).map(|_| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * rng.random::<f64>());
            Complex32::new(cos as f32, sin as f32)
        });
        let (camera, scale) = (&bench.camera, readout.scale());
        let sin = libm::sin(camera.tilt_deg.to_radians());
        let shift = bench.motion.step_mm * (camera.distance_mm / bench.laser.fan_height_mm + 1.0 - sin * sin);
        let pupil = camera.focal_length_mm / camera.f_number;
        let noise = bench.exposure.dark_noise_dn * scale;
        Self {
            settings,
            phases: phases.collect(),
            turns: [std::f64::consts::TAU * rng.random::<f64>(), std::f64::consts::PI * shift / pupil],
            noise: [bench.exposure.dark_level_dn * scale, (noise * noise - 1.0 / 12.0).max(0.0).sqrt()]
                .map(|v| v as f32),
            most: f32::from(readout.most()),
            stream,
        }
    }

    /// Digital numbers of the whole sensor of `rows` rows in exposure `profile`, `[rows, columns]`, row-major [DN].
    pub fn frame(&self, light: Picture, rows: usize, profile: usize) -> Vec<u16> {
        let mut picture = light;
        for step in self.settings.order.steps() {
            picture = match step {
                Step::Blur => blurred(&picture, self.settings.blur_radius_px, rows),
                Step::Speckle => self.speckled(picture, profile),
                Step::Noise => self.noisy(&picture, rows, profile),
            };
        }
        picture.numbers.iter().map(|&v| (v.clamp(0.0, self.most) + 12_582_912.0).to_bits() as u16).collect()
    }

    /// Times the pattern of a profile.
    fn speckled(&self, mut picture: Picture, profile: usize) -> Picture {
        let pattern = self.pattern(profile);
        let (size, factor) = (self.settings.pattern.size_px, self.settings.pattern.factor);
        let wrap = size - 1;
        let scale = self.settings.intensity_scale as f32 / (factor * factor) as f32;
        let mut sums = vec![0.0f32; wrap];
        for (row, line) in (picture.first_row..).zip(picture.numbers.chunks_exact_mut(picture.columns)) {
            sums.fill(0.0);
            for part in 0..factor {
                let from = (row * factor + part) % wrap * size;
                sums.iter_mut().zip(&pattern[from..]).for_each(|(sum, v)| *sum += v);
            }
            for (column, number) in line.iter_mut().enumerate() {
                let square: f32 = (0..factor).map(|part| sums[(column * factor + part) % wrap]).sum();
                *number *= scale * square;
            }
        }
        picture
    }

    /// The pattern of a profile, mean 1 `[size, size]`.
    fn pattern(&self, profile: usize) -> Vec<f32> {
        let (size, radius) = (self.settings.pattern.size_px, 0.5 * self.settings.pattern.mask_px as f64);
        let (sin, cos) = libm::sincos(self.turns[0] + profile as f64 * self.turns[1]);
        let centre = [0.5 * size as f64 + radius * sin, 0.5 * size as f64 + radius * cos];
        // Other planners pick instructions by the CPU, and with them the last bits.
        let transform = FftPlannerScalar::new().plan_fft_forward(size);
        let mut field = vec![Complex32::default(); size * size];
        for row in 0..size {
            let dy = row as f64 - centre[0];
            let half = (radius * radius - dy * dy).max(-1.0);
            if half < 0.0 {
                continue;
            }
            let half = half.sqrt();
            let columns =
                (centre[1] - half).ceil().max(0.0) as usize..((centre[1] + half).floor() as usize + 1).min(size);
            let line = row * size..(row + 1) * size;
            let disc = line.start + columns.start..line.start + columns.end;
            field[disc.clone()].copy_from_slice(&self.phases[disc]);
            transform.process(&mut field[line]);
        }
        for row in 0..size {
            for column in row + 1..size {
                field.swap(row * size + column, column * size + row);
            }
        }
        transform.process(&mut field);
        let numbers = field.iter().map(|v| match self.settings.pattern.law {
            SpeckleLaw::Exponential => v.norm_sqr(),
            SpeckleLaw::Rayleigh => v.norm_sqr().sqrt(),
        });
        let mut numbers: Vec<f32> = numbers.collect();
        let mean = numbers.iter().map(|&v| f64::from(v)).sum::<f64>() / numbers.len() as f64;
        numbers.iter_mut().for_each(|v| *v = (f64::from(*v) / mean) as f32);
        numbers
    }

    /// Noise over the whole sensor, and what there is of a picture on it.
    fn noisy(&self, picture: &Picture, rows: usize, profile: usize) -> Picture {
        let key = self.stream.child("noise").index(profile as u64).key();
        let keys = [key as u32, (key >> 32) as u32];
        let noise = |pixel: usize| self.noise[0] + self.noise[1] * lanes::normals(pixel as u32, keys).0;
        let mut numbers: Vec<f32> = (0..rows * picture.columns).map(noise).collect();
        let from = picture.first_row * picture.columns;
        numbers[from..].iter_mut().zip(&picture.numbers).for_each(|(sum, light)| *sum += light);
        Picture { columns: picture.columns, first_row: 0, numbers }
    }
}

/// A picture under a Gaussian of standard deviation `sigma` [px], on a sensor of `rows` rows whose edge pixels go on.
fn blurred(picture: &Picture, sigma: f64, rows: usize) -> Picture {
    let reach = (REACH * sigma).ceil() as usize;
    let weights: Vec<f64> =
        (0..=2 * reach).map(|i| libm::exp(-0.5 * ((i as f64 - reach as f64) / sigma.max(1e-9)).powi(2))).collect();
    let sum: f64 = weights.iter().sum();
    let weights: Vec<f32> = weights.iter().map(|w| (w / sum) as f32).collect();
    let (columns, held) = (picture.columns, picture.numbers.len() / picture.columns.max(1));
    let first = picture.first_row.saturating_sub(reach);
    let last = (picture.first_row + held + reach).min(rows);
    let mut numbers = vec![0.0f32; (last - first) * columns];
    let mut line = vec![0.0f32; columns];
    for (row, out) in (first..).zip(numbers.chunks_exact_mut(columns)) {
        line.fill(0.0);
        for (i, weight) in weights.iter().enumerate() {
            let from = (row + i).saturating_sub(reach).min(rows - 1);
            let held_row = from.checked_sub(picture.first_row).filter(|&row| row < held);
            if let Some(held_row) = held_row {
                let source = &picture.numbers[held_row * columns..][..columns];
                line.iter_mut().zip(source).for_each(|(sum, v)| *sum += weight * v);
            }
        }
        for (column, out) in out.iter_mut().enumerate() {
            *out = weights
                .iter()
                .enumerate()
                .map(|(i, weight)| weight * line[(column + i).saturating_sub(reach).min(columns - 1)])
                .sum();
        }
    }
    Picture { columns, first_row: first, numbers }
}

#[cfg(test)]
mod tests;
