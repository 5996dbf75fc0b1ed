//! Columns of a line of light.

/// Edges of the columns: half way between their middles, the outer ones as far beyond; a lone column is `alone` wide
/// [mm].
pub(crate) fn column_edges(x: &[f32], alone: f64) -> Vec<f64> {
    let x: Vec<f64> = x.iter().map(|&x| f64::from(x)).collect();
    let halves: Vec<f64> = match x.as_slice() {
        [_] => vec![0.5 * alone],
        several => several.windows(2).map(|pair| 0.5 * (pair[1] - pair[0])).collect(),
    };
    let (Some(first), Some(last)) = (halves.first(), halves.last()) else { return Vec::new() };
    let inner = x.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    [x[0] - first].into_iter().chain(inner).chain([x[x.len() - 1] + last]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns end half way to their neighbours, the outer ones as far beyond; a lone one is as wide as told.
    #[test]
    fn columns_end_half_way_to_their_neighbours() {
        assert_eq!(column_edges(&[0.0, 1.0, 3.0], 0.1), [-0.5, 0.5, 2.0, 4.0]);
        assert_eq!(column_edges(&[5.0], 0.5), [4.75, 5.25]);
        assert!(column_edges(&[], 0.5).is_empty());
    }
}
