//! The orders in which the thesis worked on its rendered frames.

use base::words;

use super::SpeckleLaw;

/// What is done to the light of a frame, and in which order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Postprocess {
    /// The order.
    pub order: Order,
    /// Standard deviation of the blur [px].
    pub blur_radius_px: f64,
    /// Mean of the pattern of speckle, by which light is multiplied [1].
    pub intensity_scale: f64,
    /// The pattern.
    pub pattern: SpecklePattern,
}

/// A pattern of speckle as the thesis made it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SpecklePattern {
    /// Side of the square of random phases [px of the pattern].
    pub size_px: usize,
    /// Diameter of the disc cut from it, at most half of the side [px of the pattern].
    pub mask_px: usize,
    /// Pattern pixels along the side of a sensor pixel.
    pub factor: usize,
    /// Law of the pattern's numbers; the thesis preferred the root of an intensity.
    pub law: SpeckleLaw,
}

/// One of the thesis' scripts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Script {
    /// Gaussian blur over rows and columns.
    Blur,
    /// Multiplication by a pattern of speckle.
    Speckle,
    /// Addition of normal noise about the dark level.
    Noise,
}

words! {
    /// The order of the scripts.
    Order {
        /// None of them: the instrument's own optics, speckle and sensor.
        Physical = "physical",
        /// Noise, then speckle.
        NoiseSpeckle = "noise_speckle",
        /// Blur, then noise.
        BlurNoise = "blur_noise",
        /// Speckle, blur, noise.
        SpeckleBlurNoise = "speckle_blur_noise",
        /// Blur, speckle, noise; what the thesis found best.
        BlurSpeckleNoise = "blur_speckle_noise",
    }
}

impl Order {
    /// The orders that have `step`.
    pub fn with(step: Script) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |order| order.steps().contains(&step))
    }

    /// The scripts, first one first.
    pub fn steps(self) -> &'static [Script] {
        match self {
            Self::Physical => &[],
            Self::NoiseSpeckle => &[Script::Noise, Script::Speckle],
            Self::BlurNoise => &[Script::Blur, Script::Noise],
            Self::SpeckleBlurNoise => &[Script::Speckle, Script::Blur, Script::Noise],
            Self::BlurSpeckleNoise => &[Script::Blur, Script::Speckle, Script::Noise],
        }
    }
}
