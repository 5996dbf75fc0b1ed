//! How the object moves, and what its speckle is.

use base::words;

words! {
    /// How the object moves.
    Movement {
        /// Straight on, under the line.
        Linear = "linear",
        /// About an upright axis in the laser plane.
        Turntable = "turntable",
    }
}

words! {
    /// Law of the light in a point of fully developed speckle.
    SpeckleLaw {
        /// exp(-I), as physics has it.
        Exponential = "exponential",
        /// The square root of that, which the thesis took.
        Rayleigh = "rayleigh",
    }
}
