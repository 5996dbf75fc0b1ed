//! Light across the line, where it is more than one Gaussian: strands, each a Gaussian of its own.
//!
//! Lens, pixel and matter spread each strand further, and a Gaussian spread by Gaussians stays one. In units of
//! [`super::Beam::unit`]:
//!
//! ```text
//! lobes     pairs i at +-i d w, shares falling as 1 / i^2, as wide as the line itself
//! skirt     0.5 / a (1 + (y / a)^2)^-1.5, a Moffat halo (beta 2) seen across a line, full width at half maximum 1.533 a
//! slit      even within +-1/2: a row of boxes, each taken by its variance
//! texture   the rows of a picture, taken the same way
//! ```
//!
//! The skirt is four Gaussians, fitted within 2.2 % of its height everywhere out to 8 a; the 0.4 % of it that lie beyond
//! are shared among them. Boxes are at most 0.9 standard deviations of lens and matter wide, so that they are one even
//! line within 1.5e-3 of its height; a picture's boxes have the variance that the picture lacks without. Where matter spreads light far anyway, strands are joined to fewer, weight, centre
//! and variance kept. Neglected: the place across the line where light meets the object; what throws it back is what
//! stands under the line's middle.

use super::texture::Texture;
use crate::optics::parameters::Laser;
use crate::settings::Shape;
use crate::transport::kernel::{BASIS, SPREAD_MM};

/// Weights and standard deviations of the Gaussians of a skirt [1, a].
const SKIRT: [(f64, f64); 4] = [
    (0.361_000_7, 0.504_616_56),
    (0.411_013_9, 0.966_865_87),
    (0.171_384_9, 1.885_461_84),
    (0.056_600_5, 4.312_663_95),
];
/// Full width at half maximum of a skirt [a].
const SKIRT_FWHM: f64 = 1.532_841_9;
/// Widest box of an even line over the standard deviation of what blurs it [1].
const BOX: f64 = 0.9;
/// Most boxes.
const MOST: usize = 64;
/// Distance at which two Gaussians are one, over the standard deviation of what blurs them [1].
const TOGETHER: f64 = 0.7;

/// A Gaussian across the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strand {
    /// Where it stands along the motion [unit].
    pub offset: f32,
    /// Its variance [unit^2].
    pub variance: f32,
    /// Its share of the light [1].
    pub weight: f32,
}

/// Strands for light that matter spreads by one of its widths.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// The strands; their weights sum to 1.
    pub strands: Vec<Strand>,
    /// Weights that change along the line, `[strand][node]`; empty where the strands' own hold everywhere.
    weights: Vec<Vec<f32>>,
}

/// Light across the line.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// For light of the surface, then for each fixed width.
    levels: Vec<Level>,
    /// Variance without lobes and skirt [unit^2].
    core: f32,
    /// Nodes along the line, 1 where all of it is alike.
    nodes: usize,
}

impl Section {
    /// The section of a bench whose lens and pixel blur light by `lens_mm` on the object; `None` for one Gaussian.
    pub fn new(bench: &Laser, shape: Shape, image: Option<&Texture>, lens_mm: f64) -> Option<Self> {
        let unit_mm = match shape {
            Shape::Gaussian | Shape::Point => 0.5 * bench.waist_mm,
            Shape::Slit => bench.line_width_mm,
            Shape::Texture => 1.0,
        };
        let spread = std::iter::once(0.0).chain(SPREAD_MM.map(f64::from));
        let blur = spread.map(|mm| (mm * mm + lens_mm * lens_mm).sqrt() / unit_mm);
        let mut section = Self { levels: Vec::with_capacity(BASIS + 1), core: 1.0, nodes: 1 };
        match (shape, image) {
            (Shape::Gaussian, _) if bench.lobe_share > 0.0 || bench.skirt_share > 0.0 => {
                let strands = flawed(bench);
                section.levels.extend(blur.map(|sigma| Level::even(joined(&strands, sigma))));
            }
            (Shape::Slit, _) => {
                section.levels.extend(blur.map(|sigma| Level::even(boxes(1.0, (1.0 / (BOX * sigma)).ceil() as usize))));
                section.core = 1.0 / 12.0;
            }
            (Shape::Texture, Some(image)) => {
                let width = bench.texture_width_mm;
                section.nodes = image.columns();
                section.core = image.moments(width)[1] as f32;
                section
                    .levels
                    .extend(blur.map(|sigma| Level::of(image, width, (width / (BOX * sigma)).ceil() as usize)));
            }
            _ => return None,
        }
        Some(section)
    }

    /// Strands of light of the surface, and of light that matter spreads by fixed width `j`.
    #[inline]
    pub fn level(&self, j: Option<usize>) -> &Level {
        &self.levels[j.map_or(0, |j| j + 1)]
    }

    /// Standard deviation without lobes and skirt [unit].
    pub fn core_sigma(&self) -> f32 {
        self.core.sqrt()
    }

    /// Variance without lobes and skirt [unit^2].
    pub fn core(&self) -> f32 {
        self.core
    }

    /// Nodes along the line for which weights are known, 1 where all of it is alike.
    pub fn nodes(&self) -> usize {
        self.nodes
    }
}

impl Level {
    fn even(strands: Vec<Strand>) -> Self {
        Self { strands, weights: Vec::new() }
    }

    /// At most `count` boxes of an image that is `width` mm wide across the line; its first row has the largest y.
    fn of(image: &Texture, width: f64, count: usize) -> Self {
        let mut strands = boxes(width as f32, count.min(image.rows()));
        let (rows, cells) = (image.rows() as f64, strands.len() as f64);
        let nodes = image.columns();
        let mut weights = vec![vec![0.0f32; nodes]; strands.len()];
        for node in 0..nodes {
            let place = (node as f64 + 0.5) / nodes as f64;
            let all = image.along(place);
            for (cell, weights) in weights.iter_mut().rev().enumerate() {
                let (low, high) = (cell as f64 / cells * rows, (cell + 1) as f64 / cells * rows);
                let part = |row: usize| (high.min(row as f64 + 1.0) - low.max(row as f64)).max(0.0);
                let last = (high.ceil() as usize).min(image.rows());
                let light: f64 = (low as usize..last).map(|row| part(row) * image.at(row, place)).sum();
                weights[node] = if all > 0.0 { (light / all) as f32 } else { 0.0 };
            }
        }
        // What light in the middles of the boxes lacks of the picture's variance, or has too much.
        let [middle, variance] = image.moments(width);
        let place = |strand: &Strand| (f64::from(strand.offset) - middle).powi(2);
        let of = |weights: &Vec<f32>| weights.iter().map(|&w| f64::from(w)).sum::<f64>() / nodes as f64;
        let told: f64 = strands.iter().zip(&weights).map(|(strand, weights)| of(weights) * place(strand)).sum();
        strands.iter_mut().for_each(|strand| strand.variance = (variance - told) as f32);
        if nodes == 1 {
            strands.iter_mut().zip(&weights).for_each(|(strand, weights)| strand.weight = weights[0]);
            weights.clear();
        }
        Self { strands, weights }
    }

    /// Weight of a strand at `node` along the line [1].
    #[inline(always)]
    pub fn weight(&self, strand: usize, node: f32) -> f32 {
        match self.weights.get(strand) {
            Some(weights) => {
                let left = (node.max(0.0) as usize).min(weights.len() - 2);
                weights[left] + (weights[left + 1] - weights[left]) * (node - left as f32).clamp(0.0, 1.0)
            }
            None => self.strands[strand].weight,
        }
    }

    /// Whether weights change along the line.
    #[inline(always)]
    pub fn varies(&self) -> bool {
        !self.weights.is_empty()
    }
}

/// An even line of a width as boxes, taken by their variance.
fn boxes(width: f32, count: usize) -> Vec<Strand> {
    let count = count.clamp(1, MOST);
    let side = width / count as f32;
    let offset = |i: usize| (i as f32 + 0.5) * side - 0.5 * width;
    let weight = 1.0 / count as f32;
    (0..count).map(|i| Strand { offset: offset(i), variance: side * side / 12.0, weight }).collect()
}

/// A Gaussian line with its lobes and its skirt; w is two units.
fn flawed(bench: &Laser) -> Vec<Strand> {
    let mut strands = vec![(0.0, 1.0, 1.0 - bench.lobe_share - bench.skirt_share)];
    let pairs = bench.lobe_pairs.max(1.0) as usize;
    let sum: f64 = (1..=pairs).map(|i| 1.0 / (i * i) as f64).sum();
    for i in 1..=pairs {
        let (place, share) = (2.0 * bench.lobe_distance * i as f64, bench.lobe_share / (2.0 * sum * (i * i) as f64));
        strands.extend([(-place, 1.0, share), (place, 1.0, share)]);
    }
    let a = 2.0 * bench.skirt_width / SKIRT_FWHM;
    strands.extend(SKIRT.map(|(weight, sigma)| (0.0, (sigma * a) * (sigma * a), bench.skirt_share * weight)));
    let lit = strands.into_iter().filter(|&(_, _, weight)| weight > 0.0);
    lit.map(|(offset, variance, weight)| Strand {
        offset: offset as f32,
        variance: variance as f32,
        weight: weight as f32,
    })
    .collect()
}

/// Strands joined where a blur of `sigma` makes them one; weight, mean and variance stay.
fn joined(strands: &[Strand], sigma: f64) -> Vec<Strand> {
    let mut strands = strands.to_vec();
    let blur = (sigma * sigma) as f32;
    let limit = (TOGETHER * TOGETHER) as f32;
    let apart = |a: &Strand, b: &Strand| {
        let gap = a.offset - b.offset;
        (gap * gap + 0.5 * (a.variance - b.variance).abs()) / (blur + a.variance.min(b.variance))
    };
    loop {
        let pairs = (1..strands.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
        let nearest = pairs
            .map(|(a, b)| (apart(&strands[a], &strands[b]), a, b))
            .min_by(|one, other| one.0.total_cmp(&other.0))
            .filter(|&(apart, ..)| apart < limit);
        let Some((_, a, b)) = nearest else { return strands };
        let (one, other) = (strands[a], strands.swap_remove(b));
        let weight = one.weight + other.weight;
        let part = other.weight / weight;
        let gap = other.offset - one.offset;
        strands[a] = Strand {
            offset: one.offset + part * gap,
            variance: one.variance + part * (other.variance - one.variance) + part * (1.0 - part) * gap * gap,
            weight,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bench() -> Laser {
        Laser::from_values(&mut |p| p.default)
    }

    fn height(strands: &[Strand], y: f64, blur: f64) -> f64 {
        let one = |s: &Strand| {
            let variance = f64::from(s.variance) + blur * blur;
            let d = y - f64::from(s.offset);
            f64::from(s.weight) * (-0.5 * d * d / variance).exp() / (2.0 * std::f64::consts::PI * variance).sqrt()
        };
        strands.iter().map(one).sum()
    }

    /// The Gaussians of the skirt against the halo's own law, out to eight times its scale.
    #[test]
    fn skirt_is_a_moffat_halo() {
        assert!((SKIRT.iter().map(|&(weight, _)| weight).sum::<f64>() - 1.0).abs() < 1e-6);
        let a = 4.0;
        let strand = |&(weight, sigma): &(f64, f64)| Strand {
            offset: 0.0,
            variance: (a * a * sigma * sigma) as f32,
            weight: weight as f32,
        };
        let strands: Vec<_> = SKIRT.iter().map(strand).collect();
        let law = |y: f64| 0.5 / a * (1.0 + (y / a).powi(2)).powf(-1.5);
        for i in 0..=800 {
            let y = 0.01 * f64::from(i) * a;
            assert!((height(&strands, y, 0.0) / law(y) - 1.0).abs() < 0.0222, "{y}");
        }
        assert!((law(0.5 * SKIRT_FWHM * a) / law(0.0) - 0.5).abs() < 1e-6);
    }

    /// However many strands are joined, light stays, and the blurred line stays within 3 % of the lobes' height.
    #[test]
    fn joined_strands_look_the_same() {
        let mut bench = bench();
        (bench.lobe_share, bench.lobe_pairs, bench.lobe_distance) = (0.05, 3.0, 1.5);
        (bench.skirt_share, bench.skirt_width) = (0.03, 8.0);
        let strands = flawed(&bench);
        let mut fewer = 0;
        for sigma in [1.0, 2.0, 4.0, 8.0, 16.0, 32.0] {
            let joined = joined(&strands, sigma);
            fewer += strands.len() - joined.len();
            assert!((joined.iter().map(|s| s.weight).sum::<f32>() - 1.0).abs() < 1e-5);
            let most = height(&strands, 0.0, sigma);
            for i in 0..400 {
                let y = 0.25 * f64::from(i);
                let off = (height(&joined, y, sigma) - height(&strands, y, sigma)).abs();
                assert!(off < 1.5e-3 * most, "{off} of {most} at {y}, blur {sigma}");
            }
        }
        assert!(fewer > 10, "{fewer} strands joined");
    }

    /// Boxes under the blur that they were made for are an even line, within 1.5e-3.
    #[test]
    fn boxes_are_an_even_line() {
        for (sigma, count) in [(0.05f64, 23), (0.12, 10), (0.5, 3), (1.5, 1)] {
            assert_eq!((1.0 / (BOX * sigma)).ceil() as usize, count);
            let strands = boxes(1.0, count);
            for i in 0..200 {
                let y = 0.02 * f64::from(i);
                let below = |x: f64| 0.5 * (1.0 + libm::erf(x / sigma * std::f64::consts::FRAC_1_SQRT_2));
                let law = below(y + 0.5) - below(y - 0.5);
                let top = below(0.5) - below(-0.5);
                assert!((height(&strands, y, sigma) - law).abs() < 1.5e-3 * top, "{y} at {sigma}: {law}");
            }
        }
    }
}
