//! How the object moves, and what its speckle is.

/// How the object moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Straight on, under the line.
    Linear,
    /// About an upright axis in the laser plane.
    Turntable,
}

impl Way {
    /// Names in recipes and files.
    pub const NAMES: [&str; 2] = ["linear", "turntable"];
}

/// Law of the light in a point of fully developed speckle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpeckleLaw {
    /// exp(-I), as physics has it.
    Exponential,
    /// The square root of that, which the thesis took.
    Rayleigh,
}

impl SpeckleLaw {
    /// Every law in the order of [`Self::NAMES`].
    pub const ALL: [Self; 2] = [Self::Exponential, Self::Rayleigh];
    /// Names in recipes and files.
    pub const NAMES: [&str; 2] = ["exponential", "rayleigh"];

    /// Name in recipes and files.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}
