//! Profile across the laser line where it is more than one Gaussian: a mixture of Gaussian components.
//!
//! Lens, pixel and matter convolve each component with Gaussians, so it stays a Gaussian. In units of
//! [`super::Beam::unit`]:
//!
//! ```text
//! lobes     pairs i at +-i d w, shares falling as 1 / i^2, as wide as the line itself
//! skirt     0.5 / a (1 + (y / a)^2)^-1.5, a Moffat halo (beta 2) across a line, full width at half maximum 1.533 a
//! slit      even within +-1/2: a row of boxes, each replaced by a Gaussian of its variance
//! texture   the rows of a picture in groups, each replaced by a Gaussian of the mean and variance of its light
//! ```
//!
//! The skirt is four Gaussians, fitted within 2.2 % of its height everywhere out to 8 a; the 0.4 % of its light beyond
//! are shared among them. Boxes are at most 0.9 standard deviations of lens and matter wide, so that their sum is even
//! within 1.5e-3 of its height. Where matter spreads light far anyway, components are merged; total weight, mean and
//! variance are kept. Neglected: where across the line light meets the object; the surface under the line's middle
//! returns all of it.

use super::texture::LineTexture;
use optical_bench::parameters::LaserParameters;
use optical_bench::settings::LineShape;
use transport::kernel::{BASIS, SPREAD_MM};

/// Weight and standard deviation of each Gaussian of a skirt [1, a].
pub(crate) const SKIRT_COMPONENTS: [(f64, f64); 4] = [
    (0.361_000_7, 0.504_616_56),
    (0.411_013_9, 0.966_865_87),
    (0.171_384_9, 1.885_461_84),
    (0.056_600_5, 4.312_663_95),
];
/// Full width at half maximum of a skirt [a].
const SKIRT_FWHM: f64 = 1.532_841_9;
/// Greatest width of a box of an even line, in standard deviations of the blur [1].
const MAX_BOX_WIDTH: f64 = 0.9;
/// Most boxes across the line.
const MAX_BOXES: usize = 64;
/// Distance below which two Gaussians are merged, in standard deviations of the blurred line [1].
const MERGE_DISTANCE: f64 = 0.7;

/// One Gaussian of the profile across the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GaussianComponent {
    /// Its mean along the motion [unit].
    pub offset: f32,
    /// Its variance [unit^2].
    pub variance: f32,
    /// Its share of the light [1].
    pub weight: f32,
}

/// Profile across the line of light that matter spreads by one of the fixed widths.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GaussianMixture {
    /// The components; their weights sum to 1.
    pub components: Vec<GaussianComponent>,
    /// Weights that change along the line, `[component][node]`; empty where the components' own weights hold
    /// everywhere.
    weights: Vec<Vec<f32>>,
}

/// Profile across the line for every fixed width of spread in matter.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LineProfile {
    /// For light reflected by the surface, then for each fixed width.
    mixtures: Vec<GaussianMixture>,
    /// Variance without lobes and skirt [unit^2].
    pub core: f32,
    /// Nodes along the line for which weights are known; 1 for a uniform line.
    pub nodes: usize,
}

impl LineProfile {
    /// Profile of a bench whose lens and pixel blur light by `lens_mm` on the object; `None` for a single Gaussian.
    pub fn new(bench: &LaserParameters, shape: LineShape, image: Option<&LineTexture>, lens_mm: f64) -> Option<Self> {
        let unit_mm = match shape {
            LineShape::Gaussian | LineShape::Point => 0.5 * bench.waist_mm,
            LineShape::Slit => bench.line_width_mm,
            LineShape::Texture => 1.0,
        };
        let spread = std::iter::once(0.0).chain(SPREAD_MM.map(f64::from));
        let blur = spread.map(|mm| (mm * mm + lens_mm * lens_mm).sqrt() / unit_mm);
        let mut profile = Self { mixtures: Vec::with_capacity(BASIS + 1), core: 1.0, nodes: 1 };
        match (shape, image) {
            (LineShape::Gaussian, _) if bench.lobe_share > 0.0 || bench.skirt_share > 0.0 => {
                let components = line_with_lobes_and_skirt(bench);
                profile.mixtures.extend(blur.map(|sigma| GaussianMixture::uniform(merged(&components, sigma))));
            }
            (LineShape::Slit, _) => {
                profile.mixtures.extend(blur.map(|sigma| {
                    GaussianMixture::uniform(boxes(1.0, (1.0 / (MAX_BOX_WIDTH * sigma)).ceil() as usize))
                }));
                profile.core = 1.0 / 12.0;
            }
            (LineShape::Texture, Some(image)) => {
                let width = bench.texture_width_mm;
                profile.nodes = image.columns;
                let rows = image.rows as f64;
                let variance = image.moments(0.0, rows).map_or(0.0, |[_, variance]| variance);
                profile.core = (variance * (width / rows).powi(2)) as f32;
                profile.mixtures.extend(blur.map(|sigma| {
                    GaussianMixture::from_texture(image, width, (width / (MAX_BOX_WIDTH * sigma)).ceil() as usize)
                }));
            }
            _ => return None,
        }
        Some(profile)
    }

    /// Mixture for light that matter spreads by fixed width `j`, or for light reflected by the surface.
    #[inline]
    pub(crate) fn mixture(&self, j: Option<usize>) -> &GaussianMixture {
        &self.mixtures[j.map_or(0, |j| j + 1)]
    }
}

impl GaussianMixture {
    fn uniform(components: Vec<GaussianComponent>) -> Self {
        Self { components, weights: Vec::new() }
    }

    /// At most `count` boxes of an image that is `width` mm wide across the line; its first row has the largest y.
    fn from_texture(image: &LineTexture, width: f64, count: usize) -> Self {
        let mut components = boxes(width as f32, count.min(image.rows));
        let (rows, cells) = (image.rows as f64, components.len() as f64);
        let nodes = image.columns;
        let mut weights = vec![vec![0.0f32; nodes]; components.len()];
        for node in 0..nodes {
            let position = (node as f64 + 0.5) / nodes as f64;
            let all = image.column_sum(position);
            for (cell, weights) in weights.iter_mut().rev().enumerate() {
                let (low, high) = (cell as f64 / cells * rows, (cell + 1) as f64 / cells * rows);
                let part = |row: usize| (high.min(row as f64 + 1.0) - low.max(row as f64)).max(0.0);
                let last = (high.ceil() as usize).min(image.rows);
                let light: f64 = (low as usize..last).map(|row| part(row) * image.at(row, position)).sum();
                weights[node] = if all > 0.0 { (light / all) as f32 } else { 0.0 };
            }
        }
        for (cell, component) in components.iter_mut().rev().enumerate() {
            let ends = (cell as f64 / cells * rows, (cell + 1) as f64 / cells * rows);
            if let Some([middle, variance]) = image.moments(ends.0, ends.1) {
                component.offset = ((0.5 - middle / rows) * width) as f32;
                component.variance = (variance * (width / rows).powi(2)) as f32;
            }
        }
        if nodes == 1 {
            components.iter_mut().zip(&weights).for_each(|(component, weights)| component.weight = weights[0]);
            weights.clear();
        }
        Self { components, weights }
    }

    /// Weight of a component at `node` along the line [1].
    #[inline(always)]
    pub fn weight(&self, component: usize, node: f32) -> f32 {
        match self.weights.get(component) {
            Some(weights) => {
                let left = (node.max(0.0) as usize).min(weights.len() - 2);
                weights[left] + (weights[left + 1] - weights[left]) * (node - left as f32).clamp(0.0, 1.0)
            }
            None => self.components[component].weight,
        }
    }

    /// Whether weights change along the line.
    #[inline(always)]
    pub fn varies(&self) -> bool {
        !self.weights.is_empty()
    }
}

/// An even line of a width as boxes, each replaced by a Gaussian of its variance.
fn boxes(width: f32, count: usize) -> Vec<GaussianComponent> {
    let count = count.clamp(1, MAX_BOXES);
    let side = width / count as f32;
    let offset = |i: usize| (i as f32 + 0.5) * side - 0.5 * width;
    let weight = 1.0 / count as f32;
    (0..count).map(|i| GaussianComponent { offset: offset(i), variance: side * side / 12.0, weight }).collect()
}

/// A Gaussian line with its side lobes and its skirt; w is two units.
fn line_with_lobes_and_skirt(bench: &LaserParameters) -> Vec<GaussianComponent> {
    let mut components = vec![(0.0, 1.0, 1.0 - bench.lobe_share - bench.skirt_share)];
    let pairs = bench.lobe_pairs.max(1.0) as usize;
    let sum: f64 = (1..=pairs).map(|i| 1.0 / (i * i) as f64).sum();
    for i in 1..=pairs {
        let (offset, share) = (2.0 * bench.lobe_distance * i as f64, bench.lobe_share / (2.0 * sum * (i * i) as f64));
        components.extend([(-offset, 1.0, share), (offset, 1.0, share)]);
    }
    let a = 2.0 * bench.skirt_width / SKIRT_FWHM;
    components
        .extend(SKIRT_COMPONENTS.map(|(weight, sigma)| (0.0, (sigma * a) * (sigma * a), bench.skirt_share * weight)));
    let lit = components.into_iter().filter(|&(_, _, weight)| weight > 0.0);
    lit.map(|(offset, variance, weight)| GaussianComponent {
        offset: offset as f32,
        variance: variance as f32,
        weight: weight as f32,
    })
    .collect()
}

/// Merges components that a blur of `sigma` makes one; total weight, mean and variance are kept.
fn merged(components: &[GaussianComponent], sigma: f64) -> Vec<GaussianComponent> {
    let mut components = components.to_vec();
    let blur = (sigma * sigma) as f32;
    let limit = (MERGE_DISTANCE * MERGE_DISTANCE) as f32;
    let apart = |a: &GaussianComponent, b: &GaussianComponent| {
        let gap = a.offset - b.offset;
        (gap * gap + 0.5 * (a.variance - b.variance).abs()) / (blur + a.variance.min(b.variance))
    };
    loop {
        let pairs = (1..components.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
        let nearest = pairs
            .map(|(a, b)| (apart(&components[a], &components[b]), a, b))
            .min_by(|one, other| one.0.total_cmp(&other.0))
            .filter(|&(apart, ..)| apart < limit);
        let Some((_, a, b)) = nearest else { return components };
        let (one, other) = (components[a], components.swap_remove(b));
        let weight = one.weight + other.weight;
        let part = other.weight / weight;
        let gap = other.offset - one.offset;
        components[a] = GaussianComponent {
            offset: one.offset + part * gap,
            variance: one.variance + part * (other.variance - one.variance) + part * (1.0 - part) * gap * gap,
            weight,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bench() -> LaserParameters {
        LaserParameters::from_values(&mut |p| p.default)
    }

    fn height(components: &[GaussianComponent], y: f64, blur: f64) -> f64 {
        let one = |s: &GaussianComponent| {
            let variance = f64::from(s.variance) + blur * blur;
            let d = y - f64::from(s.offset);
            f64::from(s.weight) * (-0.5 * d * d / variance).exp() / (2.0 * std::f64::consts::PI * variance).sqrt()
        };
        components.iter().map(one).sum()
    }

    /// The Gaussians of the skirt against the halo's own law, out to eight times its scale.
    #[test]
    fn skirt_is_a_moffat_halo() {
        assert!((SKIRT_COMPONENTS.iter().map(|&(weight, _)| weight).sum::<f64>() - 1.0).abs() < 1e-6);
        let a = 4.0;
        let component = |&(weight, sigma): &(f64, f64)| GaussianComponent {
            offset: 0.0,
            variance: (a * a * sigma * sigma) as f32,
            weight: weight as f32,
        };
        let components: Vec<_> = SKIRT_COMPONENTS.iter().map(component).collect();
        let law = |y: f64| 0.5 / a * (1.0 + (y / a).powi(2)).powf(-1.5);
        for i in 0..=800 {
            let y = 0.01 * f64::from(i) * a;
            assert!((height(&components, y, 0.0) / law(y) - 1.0).abs() < 0.0222, "{y}");
        }
        assert!((law(0.5 * SKIRT_FWHM * a) / law(0.0) - 0.5).abs() < 1e-6);
    }

    /// However many components are merged, light stays, and the blurred line stays within 3 % of the lobes' height.
    #[test]
    fn joined_strands_look_the_same() {
        let mut bench = bench();
        (bench.lobe_share, bench.lobe_pairs, bench.lobe_distance) = (0.05, 3.0, 1.5);
        (bench.skirt_share, bench.skirt_width) = (0.03, 8.0);
        let components = line_with_lobes_and_skirt(&bench);
        let mut fewer = 0;
        for sigma in [1.0, 2.0, 4.0, 8.0, 16.0, 32.0] {
            let merged = merged(&components, sigma);
            fewer += components.len() - merged.len();
            assert!((merged.iter().map(|s| s.weight).sum::<f32>() - 1.0).abs() < 1e-5);
            let most = height(&components, 0.0, sigma);
            for i in 0..400 {
                let y = 0.25 * f64::from(i);
                let off = (height(&merged, y, sigma) - height(&components, y, sigma)).abs();
                assert!(off < 1.5e-3 * most, "{off} of {most} at {y}, blur {sigma}");
            }
        }
        assert!(fewer > 10, "{fewer} components merged");
    }

    /// Boxes under the blur that they were made for are an even line, within 1.5e-3.
    #[test]
    fn boxes_are_an_even_line() {
        for (sigma, count) in [(0.05f64, 23), (0.12, 10), (0.5, 3), (1.5, 1)] {
            assert_eq!((1.0 / (MAX_BOX_WIDTH * sigma)).ceil() as usize, count);
            let components = boxes(1.0, count);
            for i in 0..200 {
                let y = 0.02 * f64::from(i);
                let below = |x: f64| 0.5 * (1.0 + libm::erf(x / sigma * std::f64::consts::FRAC_1_SQRT_2));
                let law = below(y + 0.5) - below(y - 0.5);
                let top = below(0.5) - below(-0.5);
                assert!((height(&components, y, sigma) - law).abs() < 1.5e-3 * top, "{y} at {sigma}: {law}");
            }
        }
    }
}
