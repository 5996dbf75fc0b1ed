//! x
/// Logarithm of the ratio between neighbouring frequencies: ln(1000) / 15.
pub const RATIO_LN: f64 = 0.460_517_018_598_809_13;
