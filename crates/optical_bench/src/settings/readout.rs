//! How the sensor is read out, and what is done to its frames before they are read.

use base::words;

/// Numbers of the 8-bit scale on which recipes count digital numbers [DN].
pub(crate) const SCALE_DN: f64 = 255.0;

/// How the sensor is read out: the same for all samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Readout {
    /// Bits of the converter: 8, 10 or 12.
    pub bits: u32,
    /// Slopes of the response.
    pub hdr: Hdr,
}

impl Readout {
    /// 8 bits, one slope.
    pub const PLAIN: Self = Self { bits: 8, hdr: Hdr::None };

    /// Greatest digital number [DN].
    pub fn most(&self) -> u16 {
        ((1u32 << self.bits.min(16)) - 1) as u16
    }

    /// Digital numbers of the converter for one of the 8-bit scale [1]; 1 for 8 bits.
    pub fn scale(&self) -> f64 {
        f64::from(self.most()) / SCALE_DN
    }
}

words! {
    /// Slopes of the response: one, or two with a knee between them.
    Hdr {
        /// One slope.
        None = "none",
        /// Twice the dynamic range.
        Soft = "soft",
        /// Six times.
        Medium = "medium",
        /// Fifteen times.
        Aggressive = "aggressive",
    }
}

impl Hdr {
    /// By how much the dynamic range grows [1].
    pub fn gain(self) -> f64 {
        match self {
            Self::None => 1.0,
            Self::Soft => 2.0,
            Self::Medium => 6.0,
            Self::Aggressive => 15.0,
        }
    }
}
