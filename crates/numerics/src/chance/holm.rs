//! Holm's step-down correction for many tests at once.

/// Chances adjusted for being the extremes of all of them (Holm 1979): whoever rejects those below alpha is wrong about
/// any true one with a chance of at most alpha, however the tests depend on each other.
pub fn holm(chances: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..chances.len()).collect();
    order.sort_by(|&a, &b| chances[a].total_cmp(&chances[b]));
    let mut adjusted = vec![0.0; chances.len()];
    let mut least: f64 = 0.0;
    for (rank, &place) in order.iter().enumerate() {
        least = least.max((chances.len() - rank) as f64 * chances[place]).min(1.0);
        adjusted[place] = least;
    }
    adjusted
}
