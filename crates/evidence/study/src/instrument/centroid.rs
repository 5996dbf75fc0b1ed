//! Standard deviation of a line's centre of gravity under noise and speckle: to first order, and beyond it for speckle,
//! whose law is skew.

use rand::RngExt;

use super::speckle_theory::IntensityLaw;
use rig::PixelCorrelation;

/// Variance of the centre of gravity of a line over `reach` rows beside its peak, to first order; `contrast` is that of
/// each row [px^2].
pub fn spread(
    line: &[f64],
    reach: usize,
    still: f64,
    shot: f64,
    contrast: &[f64],
    correlation: &PixelCorrelation,
) -> f64 {
    let peak = (0..line.len()).max_by(|&a, &b| line[a].total_cmp(&line[b])).unwrap_or(0);
    let rows = peak.saturating_sub(reach)..(peak + reach + 1).min(line.len());
    let sum: f64 = line[rows.clone()].iter().sum();
    let centre = rows.clone().map(|k| k as f64 * line[k]).sum::<f64>() / sum;
    let arm = |k: usize| k as f64 - centre;
    let noise: f64 = rows.clone().map(|k| arm(k).powi(2) * (still + shot * line[k])).sum();
    let pairs = rows.clone().flat_map(|k| rows.clone().map(move |l| (k, l)));
    let lever = |k: usize| arm(k) * line[k] * contrast[k];
    let grains: f64 = pairs.map(|(k, l)| lever(k) * lever(l) * correlation.at(k.abs_diff(l) as f64)).sum();
    (noise + grains) / (sum * sum)
}

/// What the centre of gravity of a line spreads by, over what first order says, for rows with light `line` whose
/// speckle is scaled by `strength`. Bright grains make the sum bright by which they are divided, so a skew law spreads
/// less. Rows are drawn from the law as if they were independent; error of the result 0.1 %.
pub(crate) fn beyond_first_order(line: &[f64], law: &IntensityLaw, strength: f64) -> f64 {
    const DRAWS: usize = 400_000;
    let peak = line.iter().fold(0.0, |most: f64, light| most.max(*light));
    let lit: Vec<f64> = line.iter().copied().filter(|light| *light > 1e-3 * peak).collect();
    let sum: f64 = lit.iter().sum();
    let centre = lit.iter().enumerate().map(|(k, light)| k as f64 * light).sum::<f64>() / sum;
    let mut rng = base::Stream::root(0).child("beyond_first_order").rng();
    let (mut exact, mut first) = (0.0, 0.0);
    for _ in 0..DRAWS {
        let (mut moment, mut all) = (0.0, 0.0);
        for (k, light) in lit.iter().enumerate() {
            let light = light * (1.0 + strength * (law.draw(rng.random::<f64>()) - 1.0));
            moment += (k as f64 - centre) * light;
            all += light;
        }
        exact += (moment / all).powi(2);
        first += (moment / sum).powi(2);
    }
    (exact / first).sqrt()
}
