//! Postprocessing of the thesis: frames of light without speckle, noise or lens blur, then its scripts one after the
//! other.
//!
//! Kihl and Källberg 2021, sections 3.2.1, 3.2.2 and 3.3. The light of a whole frame is what
//! [`crate::optics::Sensor::light`] gives, in DN over dark; each script works on the whole frame:
//!
//! ```text
//! blur      I <- I * Gaussian of standard deviation `blur_radius_px` in rows and columns
//! speckle   I <- I s p,    p the mean of factor x factor numbers of a pattern of mean 1, s `intensity_scale`
//! noise     I <- I + N(dark level, dark noise)
//! ```
//!
//! and the end is clipped and rounded. The pattern follows Bergmann et al. 2016 (after Duncan and Kirkpatrick 2008): a
//! disc of random phases out of a square, Fourier transformed, squared; its root for the Rayleigh law. The disc's
//! centre moves on a circle of its own radius about the square's middle, by pi a / D from profile to profile. D is
//! the pupil and a = step (d / h + 1 - sin^2 tilt) the shift of the field there (appendix A of the thesis: camera at
//! distance d, laser at height h). Kept as the thesis has it: the pattern lies on the sensor, not on the object; its
//! pitch of a fifth of a pixel takes 1.22 lambda N (1 + m) for lambda N (1 + m), so speckles are 22 % too large
//! (`sampling_factor` 6 is right). Pattern coordinates wrap at one less than the side (equation 3.1). Not kept: numbers
//! between patterns of a stack are not interpolated, each profile has a disc of its own; energy is kept by the mean and
//! not by a factor of thumb; scripts pass numbers on without rounding. The spread of the noise includes the final
//! rounding. `physical` orders never come here.

use base::Stream;
use rand::RngExt;
use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex32;

use numerics::lanes;
use optical_bench::parameters::Bench;
use optical_bench::settings::{Postprocess, Readout, Script, SpeckleLaw};

/// Half length of the blur's kernel, in standard deviations [1].
const KERNEL_REACH: f64 = 4.0;

/// The scripts of one sample.
#[derive(Debug, Clone)]
pub(crate) struct ThesisScripts {
    settings: Postprocess,
    /// Random phases `[size, size]`.
    phases: Vec<Complex32>,
    /// Angle of the disc's centre on its circle in profile 0 [rad].
    start_angle: f64,
    /// Change of that angle from profile to profile [rad].
    angle_step: f64,
    /// Mean of the noise [DN].
    dark_level: f32,
    /// Standard deviation of the noise [DN].
    dark_noise: f32,
    /// Greatest digital number [DN].
    max_dn: f32,
    stream: Stream,
}

/// Light, or the numbers that scripts made of it, in some rows of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameLight {
    /// Columns [px].
    pub columns: usize,
    /// Sensor row of the first row [px].
    pub first_row: usize,
    /// Numbers `[rows, columns]`, row-major [DN over dark].
    pub numbers: Vec<f32>,
}

impl ThesisScripts {
    /// For a sample with the bench `bench`; `stream` belongs to the sample.
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
            start_angle: std::f64::consts::TAU * rng.random::<f64>(),
            angle_step: std::f64::consts::PI * shift / pupil,
            dark_level: (bench.exposure.dark_level_dn * scale) as f32,
            dark_noise: (noise * noise - 1.0 / 12.0).max(0.0).sqrt() as f32,
            max_dn: f32::from(readout.most()),
            stream,
        }
    }

    /// Digital numbers of the whole sensor of `rows` rows in exposure `profile`, `[rows, columns]`, row-major [DN].
    pub fn frame(&self, mut light: FrameLight, rows: usize, profile: usize) -> Vec<u16> {
        for step in self.settings.order.steps() {
            light = match step {
                Script::Blur => blurred(&light, self.settings.blur_radius_px, rows),
                Script::Speckle => self.speckled(light, profile),
                Script::Noise => self.noisy(&light, rows, profile),
            };
        }
        light.numbers.iter().map(|&v| (v.clamp(0.0, self.max_dn) + 12_582_912.0).to_bits() as u16).collect()
    }

    /// Multiplies light with the pattern of a profile.
    fn speckled(&self, mut light: FrameLight, profile: usize) -> FrameLight {
        let pattern = self.pattern(profile);
        let (size, factor) = (self.settings.pattern.size_px, self.settings.pattern.factor);
        let wrap = size - 1;
        let scale = self.settings.intensity_scale as f32 / (factor * factor) as f32;
        let mut sums = vec![0.0f32; wrap];
        for (row, line) in (light.first_row..).zip(light.numbers.chunks_exact_mut(light.columns)) {
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
        light
    }

    /// The pattern of a profile, of mean 1, `[size, size]`.
    fn pattern(&self, profile: usize) -> Vec<f32> {
        let (size, radius) = (self.settings.pattern.size_px, 0.5 * self.settings.pattern.mask_px as f64);
        let (sin, cos) = libm::sincos(self.start_angle + profile as f64 * self.angle_step);
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

    /// Noise over the whole sensor, with the light added to it.
    fn noisy(&self, light: &FrameLight, rows: usize, profile: usize) -> FrameLight {
        let key = self.stream.child("noise").index(profile as u64).key();
        let keys = [key as u32, (key >> 32) as u32];
        let noise = |pixel: usize| self.dark_level + self.dark_noise * lanes::normals(pixel as u32, keys).0;
        let mut numbers: Vec<f32> = (0..rows * light.columns).map(noise).collect();
        let from = light.first_row * light.columns;
        numbers[from..].iter_mut().zip(&light.numbers).for_each(|(sum, light)| *sum += light);
        FrameLight { columns: light.columns, first_row: 0, numbers }
    }
}

/// Light blurred by a Gaussian of standard deviation `sigma` [px], on a sensor of `rows` rows whose edge pixels extend
/// beyond it.
fn blurred(light: &FrameLight, sigma: f64, rows: usize) -> FrameLight {
    let reach = (KERNEL_REACH * sigma).ceil() as usize;
    let weights: Vec<f64> =
        (0..=2 * reach).map(|i| libm::exp(-0.5 * ((i as f64 - reach as f64) / sigma.max(1e-9)).powi(2))).collect();
    let sum: f64 = weights.iter().sum();
    let weights: Vec<f32> = weights.iter().map(|w| (w / sum) as f32).collect();
    let (columns, held) = (light.columns, light.numbers.len() / light.columns.max(1));
    let first = light.first_row.saturating_sub(reach);
    let last = (light.first_row + held + reach).min(rows);
    let mut numbers = vec![0.0f32; (last - first) * columns];
    let mut line = vec![0.0f32; columns];
    for (row, out) in (first..).zip(numbers.chunks_exact_mut(columns)) {
        line.fill(0.0);
        for (i, weight) in weights.iter().enumerate() {
            let from = (row + i).saturating_sub(reach).min(rows - 1);
            let held_row = from.checked_sub(light.first_row).filter(|&row| row < held);
            if let Some(held_row) = held_row {
                let source = &light.numbers[held_row * columns..][..columns];
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
    FrameLight { columns, first_row: first, numbers }
}

#[cfg(test)]
mod tests;
