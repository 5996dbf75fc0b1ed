//! Extended box filter: a Gaussian blur along the line by two boxes.
//!
//! Gwosdek et al. 2011: two boxes with fractional ends have a Gaussian's variance exactly and its
//! shape nearly, at a cost that does not grow with the width.

/// Difference of variances along a line from which on it is blurred twice [px^2].
const VARYING_PX2: f32 = 0.05;

/// Blurs a line by a variance that is `own` more in each column, none where `own` is empty: at the least and at the
/// greatest of them, blended so that each column has its variance [px^2].
pub(crate) fn blur_varying(line: &mut [f32], variance: f32, own: &[f32], sides: [f32; 2], buffer: &mut Vec<f32>) {
    let low = own.iter().copied().fold(f32::INFINITY, f32::min);
    let high = own.iter().copied().fold(0.0, f32::max);
    if own.is_empty() || high - low < VARYING_PX2 {
        return blur(line, variance + 0.5 * (low.min(high) + high), sides, buffer);
    }
    let mut wide = line.to_vec();
    blur(line, variance + low, sides, buffer);
    blur(&mut wide, variance + high, sides, buffer);
    for ((narrow, wide), own) in line.iter_mut().zip(wide).zip(own) {
        *narrow += (wide - *narrow) * (own - low) / (high - low);
    }
}

/// Blurs a line by a kernel of the given variance [px^2]: two boxes with fractional ends (extended box filter, Gwosdek
/// et al. 2011). What crosses the first or the last end is folded back times its number of `sides`: 1 keeps all light,
/// less loses some of it there, negative values lose what stands near it too.
pub fn blur(line: &mut [f32], variance: f32, sides: [f32; 2], buffer: &mut Vec<f32>) {
    let n = line.len();
    let v = 0.5 * f64::from(variance);
    // Widest whole box of at most the wanted variance h (h + 1) / 3; the fold reaches no further than the line itself.
    let h = (((12.0 * v + 1.0).sqrt() - 1.0) * 0.5).floor().min(n.saturating_sub(2) as f64);
    let whole = h * (h + 1.0) * (2.0 * h + 1.0) / 3.0;
    let end = ((v * (2.0 * h + 1.0) - whole) / (2.0 * ((h + 1.0) * (h + 1.0) - v))).clamp(0.0, 1.0);
    let scale = 1.0 / (2.0 * h + 1.0 + 2.0 * end);
    let reach = h as usize;
    for _ in 0..2 {
        // The line between what is folded back at its ends.
        buffer.clear();
        buffer.extend((0..=reach).rev().map(|i| sides[0] * line[i.min(n - 1)]));
        buffer.extend_from_slice(line);
        buffer.extend((0..=reach).map(|i| sides[1] * line[(n - 1).saturating_sub(i)]));
        let at = |i: usize| f64::from(buffer[i]);
        let mut sum: f64 = (1..=2 * reach + 1).map(at).sum();
        for (i, out) in line.iter_mut().enumerate() {
            *out = ((sum + end * (at(i) + at(i + 2 * reach + 2))) * scale) as f32;
            sum += at(i + 2 * reach + 2) - at(i + 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blur_keeps_light_and_has_its_variance() {
        for variance in [0.1f32, 0.4, 1.0, 3.0, 17.0, 140.0] {
            let mut line = vec![0.0f32; 301];
            line[150] = 1.0;
            blur(&mut line, variance, [1.0; 2], &mut Vec::new());
            let sum: f64 = line.iter().map(|&v| f64::from(v)).sum();
            let second: f64 = line.iter().enumerate().map(|(i, &v)| (i as f64 - 150.0).powi(2) * f64::from(v)).sum();
            assert!((sum - 1.0).abs() < 1e-5, "light {sum}");
            assert!((second / f64::from(variance) - 1.0).abs() < 1e-3, "variance {second} for {variance}");
            let mut edge = vec![0.0f32; 40];
            edge[0] = 1.0;
            blur(&mut edge, variance, [1.0; 2], &mut Vec::new());
            assert!((edge.iter().sum::<f32>() - 1.0).abs() < 1e-4, "light at the edge");
            // Half of what enters on the very edge would leave.
            let mut open = vec![0.0f32; 200];
            open[0] = 1.0;
            blur(&mut open, variance, [0.0; 2], &mut Vec::new());
            let left: f32 = open.iter().sum();
            assert!(left < 0.995 && left > 0.3, "light at an open edge {left} of variance {variance}");
        }
    }
}
