//! Laser line width in one sensor column: full width at half maximum above the dark level, and standard deviation. A
//! Gaussian is 2.355 deviations wide at half maximum; light from below the surface has long tails, and the ratio is
//! smaller.

/// Least light above the dark level that makes a line [DN].
pub(crate) const MIN_PEAK_DN: f32 = 20.0;

/// The brightest row of a column, the first of several alike, and the median, which stands for the dark level.
struct ColumnPeak {
    row: usize,
    dn: u8,
    dark: f32,
}

impl ColumnPeak {
    /// `None` where the column has no rows.
    fn of(column: &[u8]) -> Option<Self> {
        let mut order = column.to_vec();
        order.sort_unstable();
        let dark = f32::from(*order.get(order.len() / 2)?);
        let (row, dn) = column.iter().enumerate().max_by_key(|(i, dn)| (**dn, usize::MAX - i))?;
        Some(Self { row, dn: *dn, dark })
    }
}

/// Full width at half maximum of a column of digital numbers, linear between rows [px]. The dark level is the median of
/// the column. `None` where the peak is saturated, too dark, or cut off by the edge.
pub(crate) fn full_width(column: &[u8]) -> Option<f32> {
    let ColumnPeak { row: top, dn: peak, dark } = ColumnPeak::of(column)?;
    if peak == u8::MAX || f32::from(peak) - dark < MIN_PEAK_DN {
        return None;
    }
    let half = (f32::from(peak) + dark) / 2.0;
    let at = |i: usize| f32::from(column[i]);
    // The first row on either side that is at or below half, and how far before it the half was passed.
    let below = (0..top).rev().find(|&i| at(i) <= half)?;
    let above = (top + 1..column.len()).find(|&i| at(i) <= half)?;
    let before = |out: usize, within: usize| (half - at(out)) / (at(within) - at(out));
    Some(above as f32 - below as f32 - before(below, below + 1) - before(above, above - 1))
}

/// Standard deviation of the light above the dark level within one and a half `width`s of the peak [px]: 3.5 deviations
/// of a Gaussian. `None` where that is not all in the column.
pub(crate) fn line_deviation(column: &[u8], width: f32) -> Option<f32> {
    let ColumnPeak { row: top, dark, .. } = ColumnPeak::of(column)?;
    let reach = (1.5 * width).ceil() as usize;
    let rows = column.get(top.checked_sub(reach)?..=top + reach)?;
    let (mut sum, mut first, mut second) = (0.0f32, 0.0f32, 0.0f32);
    for (i, dn) in rows.iter().enumerate() {
        let (light, d) = (f32::from(*dn) - dark, i as f32 - reach as f32);
        (sum, first, second) = (sum + light, first + light * d, second + light * d * d);
    }
    let variance = second / sum - (first / sum) * (first / sum);
    (sum > 0.0 && variance > 0.0).then(|| variance.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gaussian(rows: usize, centre: f64, deviation: f64, peak: f64) -> Vec<u8> {
        let dn = |row: usize| {
            let t = (row as f64 - centre) / deviation;
            (10.0 + peak * libm::exp(-t * t / 2.0)).round() as u8
        };
        (0..rows).map(dn).collect()
    }

    /// A Gaussian of deviation s whose brightest row lies d beside its centre passes half of that row 2
    /// sqrt(2 ln 2 s^2 + d^2) apart.
    #[test]
    fn gaussians_have_their_width() {
        for deviation in [1.5, 2.5, 4.0] {
            for (shift, beside) in [(0.0, 0.0), (0.25, 0.25), (0.5, 0.5), (0.8, 0.2_f64)] {
                let found = full_width(&gaussian(80, 40.0 + shift, deviation, 230.0)).expect("there is a line");
                let expected = 2.0 * (2.0 * 2_f64.ln() * deviation * deviation + beside * beside).sqrt();
                // A chord between rows strays by (t^2 - 1) / (8 s t) on either side, t = 1.2 deviations; whole digital
                // numbers by a hundredth.
                let error = 0.12 / deviation + 0.02;
                assert!((f64::from(found) - expected).abs() < error, "{deviation} at {shift}: {found}, not {expected}");
            }
        }
    }

    /// The same Gaussians have their deviation, but for the tails beyond one and a half widths (3.53 deviations: they
    /// take 2 t phi(t) / (2 Phi(t) - 1) = 0.6 % of the variance) and digital numbers rounded to nothing beyond.
    #[test]
    fn gaussians_have_their_deviation() {
        for expected in [1.5, 2.5, 4.0] {
            let column = gaussian(80, 40.25, expected, 230.0);
            let found =
                line_deviation(&column, full_width(&column).expect("there is a line")).expect("it is all there");
            assert!((f64::from(found) / expected - 1.0).abs() < 0.02, "{found}, not {expected}");
        }
        assert_eq!(line_deviation(&gaussian(20, 3.0, 2.0, 200.0), 4.7), None, "cut off");
    }

    /// A triangle by hand: half height is passed exactly half way down.
    #[test]
    fn triangles_by_hand() {
        assert_eq!(full_width(&[0, 0, 0, 0, 50, 100, 50, 0, 0, 0]), Some(2.0));
        assert_eq!(full_width(&[0, 0, 0, 0, 0, 0, 40, 80, 60, 20, 0, 0, 0, 0]), Some(3.5 - 1.0));
    }

    /// No line, a saturated one, one at the edge and none at all have no width.
    #[test]
    fn unclear_lines_have_none() {
        assert_eq!(full_width(&[10; 20]), None);
        assert_eq!(full_width(&[0, 0, 0, 200, 255, 255, 200, 0, 0, 0, 0]), None);
        assert_eq!(full_width(&[200, 150, 0, 0, 0, 0, 0]), None);
        assert_eq!(full_width(&[]), None);
    }
}
