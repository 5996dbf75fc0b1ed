//! Round numbers along an axis.

/// Round numbers from `low` to `high`, two to six of them.
pub fn round_ticks(low: f64, high: f64) -> Vec<f64> {
    let span = high - low;
    if !(span > 0.0 && span.is_finite()) {
        return Vec::new();
    }
    let power = libm::pow(10.0, libm::floor(libm::log10(span / 4.0)));
    let steps = [1.0, 2.0, 2.5, 5.0, 10.0].map(|step| step * power);
    let step = steps.into_iter().find(|step| span / step <= 5.0).unwrap_or(10.0 * power);
    let first = libm::ceil(low / step - 1e-9);
    // Adding 0 takes the sign from -0.
    (0..8).map(|i| (first + f64::from(i)) * step + 0.0).take_while(|tick| *tick <= high + 1e-9 * span).collect()
}

#[cfg(test)]
mod tests {
    use super::round_ticks as ticks;

    /// Ticks are round, inside, and few.
    #[test]
    fn ticks_are_round() {
        assert_eq!(ticks(0.0, 255.0), [0.0, 100.0, 200.0]);
        assert_eq!(ticks(-1.2, 1.3), [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert!(ticks(1.0, 1.0).is_empty() && ticks(f64::NAN, 1.0).is_empty());
        for (low, high) in [(0.0, 1e-3), (186.0, 4000.0), (-0.01, 17.3)] {
            let found = ticks(low, high);
            assert!(
                (2..=6).contains(&found.len()) && found.iter().all(|t| (low..=high * 1.001).contains(t)),
                "{found:?}"
            );
        }
    }
}
