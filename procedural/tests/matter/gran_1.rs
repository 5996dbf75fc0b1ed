//! The scanned spruce log of `recipes/logs`, and statistics that measured and grown stems share.

use base::Stream;
use procedural::wood::StemParameters;
use procedural::wood::{Stem, StemBranch};
use rand::RngExt;

/// Branches nearer than this along the stem to the next are one cluster [mm].
pub const CLUSTER_MM: f64 = 45.0;
/// Fewest branches of a whorl.
pub const WHORL: usize = 3;
/// Distance from the pith where azimuths are taken [mm].
const AZIMUTH_MM: f64 = 50.0;
/// Distance from the pith where widths are taken [mm].
const WIDTH_MM: f64 = 100.0;

fn table(text: &str) -> Vec<Vec<f64>> {
    let rows = text.lines().filter(|line| !line.starts_with('#'));
    rows.map(|line| line.split(',').map(|v| v.parse().expect("a number")).collect()).collect()
}

/// Rows of the pith: x, y, height [mm].
pub fn pith() -> Vec<[f64; 3]> {
    let rows = table(include_str!("../../../recipes/logs/gran_1_pith.csv"));
    rows.into_iter().map(|row| row.try_into().expect("three columns")).collect()
}

/// Sections of the outline [mm].
pub fn radii() -> Vec<Vec<f64>> {
    table(include_str!("../../../recipes/logs/gran_1_radii.csv"))
}

/// Rows of the knots, A to I.
pub fn knots() -> Vec<[f64; 9]> {
    let rows = table(include_str!("../../../recipes/logs/gran_1_knots.csv"));
    rows.into_iter().map(|row| row.try_into().expect("nine columns")).collect()
}

/// The measured stem.
pub fn gran_1() -> Stem {
    Stem::measured(&pith(), &radii(), &knots()).expect("the extract is in order")
}

/// A cluster of branches along a stem.
#[derive(Debug, Clone)]
pub struct Cluster {
    /// Its branches, upwards.
    pub branches: Vec<StemBranch>,
    /// From its lowest branch to that of the next cluster [mm]; the last one's is missing.
    pub pitch: Option<f64>,
}

impl Cluster {
    pub fn is_whorl(&self) -> bool {
        self.branches.len() >= WHORL
    }

    /// Mean height [mm].
    pub fn middle(&self) -> f64 {
        mean(self.branches.iter().map(|b| b.height[0]))
    }

    /// From its lowest to its highest branch [mm].
    pub fn height(&self) -> f64 {
        self.branches[self.branches.len() - 1].height[0] - self.branches[0].height[0]
    }

    /// Mean resultant length of its azimuths [1].
    pub fn resultant(&self) -> f64 {
        let sum = |f: fn(f64) -> f64| mean(self.branches.iter().map(|b| f(b.azimuth_at(AZIMUTH_MM))));
        sum(f64::cos).hypot(sum(f64::sin))
    }

    /// Gaps between neighbouring azimuths over their mean [1].
    pub fn gaps(&self) -> Vec<f64> {
        use std::f64::consts::TAU;
        let n = self.branches.len();
        let mut turns: Vec<f64> = self.branches.iter().map(|b| b.azimuth_at(AZIMUTH_MM).rem_euclid(TAU)).collect();
        turns.sort_by(f64::total_cmp);
        (0..n).map(|i| (turns[(i + 1) % n] - turns[i]).rem_euclid(TAU) * n as f64 / TAU).collect()
    }
}

/// The branches that begin within the stem, in clusters upwards.
pub fn clusters(stem: &Stem) -> Vec<Cluster> {
    let [low, high] = stem.ends_mm();
    let within = |b: &&StemBranch| low <= b.height[0] && b.height[0] < high;
    let mut branches: Vec<StemBranch> = stem.branches().iter().filter(within).copied().collect();
    branches.sort_by(|a, b| a.height[0].total_cmp(&b.height[0]));
    let mut clusters: Vec<Cluster> = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for branch in branches {
        if branch.height[0] - last > CLUSTER_MM {
            clusters.push(Cluster { branches: Vec::new(), pitch: None });
        }
        last = branch.height[0];
        clusters.last_mut().expect("just pushed").branches.push(branch);
    }
    for i in 1..clusters.len() {
        clusters[i - 1].pitch = Some(clusters[i].branches[0].height[0] - clusters[i - 1].branches[0].height[0]);
    }
    clusters
}

/// Distances between the middles of neighbouring whorls [mm].
pub fn spacings(clusters: &[Cluster]) -> Vec<f64> {
    let middles: Vec<f64> = clusters.iter().filter(|c| c.is_whorl()).map(Cluster::middle).collect();
    middles.windows(2).map(|w| w[1] - w[0]).collect()
}

/// Logarithm of the width 100 mm from the pith, or where the branch ends before.
pub fn log_width(branch: &StemBranch) -> f64 {
    branch.width_mm(WIDTH_MM.min(branch.end_mm)).ln()
}

/// Distance from the pith where the axis meets the outline [mm].
pub fn surface(stem: &Stem, branch: &StemBranch) -> f64 {
    (0..20).fold(100.0, |r, _| stem.radius_mm(branch.azimuth_at(r), branch.height_at(r)))
}

/// Volume of a branch within the stem [mm^3].
pub fn volume(stem: &Stem, branch: &StemBranch) -> f64 {
    let end = surface(stem, branch).min(branch.end_mm);
    let n = 60;
    let area = |i: i32| branch.width_mm((f64::from(i) + 0.5) * end / f64::from(n)).powi(2);
    0.25 * std::f64::consts::PI * (0..n).map(area).sum::<f64>() * end / f64::from(n)
}

/// One section of the outline: mean radius [mm], mean square [mm^2], and largest over smallest radius [1].
#[derive(Debug, Clone, Copy)]
pub struct Section {
    pub height: f64,
    pub mean: f64,
    pub square: f64,
    pub ratio: f64,
}

/// Sections every 70 mm at 36 azimuths, as the extract has them.
pub fn sections(stem: &Stem) -> Vec<Section> {
    let [low, high] = stem.ends_mm();
    let count = ((high - low) / 70.0) as usize;
    let section = |i: usize| {
        let height = low + 70.0 * i as f64;
        let radii: Vec<f64> =
            (0..36).map(|j| stem.radius_mm(-std::f64::consts::TAU * f64::from(j) / 36.0, height)).collect();
        let most = radii.iter().copied().fold(0.0, f64::max);
        let least = radii.iter().copied().fold(f64::INFINITY, f64::min);
        let square = mean(radii.iter().map(|r| r * r));
        Section { height, mean: mean(radii.iter().copied()), square, ratio: most / least }
    };
    (0..=count).map(section).collect()
}

/// Loss of the mean radius along the stem [mm/m], by least squares.
pub fn taper(sections: &[Section]) -> f64 {
    let (h, r) = (mean(sections.iter().map(|s| s.height)), mean(sections.iter().map(|s| s.mean)));
    let up: f64 = sections.iter().map(|s| (s.height - h) * (s.mean - r)).sum();
    -1000.0 * up / sections.iter().map(|s| (s.height - h).powi(2)).sum::<f64>()
}

/// Stretches of 400 mm of the pith: squares of its distance from its mean line [mm^2], and of its tilt over 100 mm
/// [rad^2], every 10 mm.
pub fn pith_stretches(stem: &Stem) -> Vec<Vec<[f64; 2]>> {
    let [low, high] = stem.ends_mm();
    let heights: Vec<f64> = (0..).map(|i| low + 10.0 * f64::from(i)).take_while(|&h| h <= high).collect();
    let points: Vec<[f64; 2]> = heights.iter().map(|&h| stem.pith_mm(h)).collect();
    let middle = mean(heights.iter().copied());
    let square = mean(heights.iter().map(|h| (h - middle).powi(2)));
    let line = [0, 1].map(|axis| {
        let at = mean(points.iter().map(|p| p[axis]));
        let slope = mean(heights.iter().zip(&points).map(|(h, p)| (h - middle) * (p[axis] - at))) / square;
        (at, slope)
    });
    let off = |i: usize, axis: usize| points[i][axis] - line[axis].0 - line[axis].1 * (heights[i] - middle);
    let rows = (0..points.len() - 10).map(|i| {
        let over = (off(i + 10, 0) - off(i, 0)).hypot(off(i + 10, 1) - off(i, 1));
        [off(i, 0).powi(2) + off(i, 1).powi(2), (over / 100.0).atan().powi(2)]
    });
    rows.collect::<Vec<_>>().chunks(40).map(<[_]>::to_vec).collect()
}

pub fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0.0), |(sum, n), value| (sum + value, n + 1.0));
    sum / n
}

pub fn deviation(values: &[f64]) -> f64 {
    let middle = mean(values.iter().copied());
    mean(values.iter().map(|v| (v - middle).powi(2))).sqrt()
}

/// Percentile bootstrap of a statistic over resampled units: the interval that holds `share` of the resamples.
pub fn bootstrap<T: Clone>(units: &[T], share: f64, name: &str, statistic: impl Fn(&[T]) -> f64) -> [f64; 2] {
    let mut rng = Stream::root(0).child("bootstrap").child(name).rng();
    let resamples = 4000;
    let mut values: Vec<f64> = (0..resamples)
        .map(|_| {
            let drawn: Vec<T> = units.iter().map(|_| units[rng.random_range(0..units.len())].clone()).collect();
            statistic(&drawn)
        })
        .collect();
    values.sort_by(f64::total_cmp);
    let tail = (0.5 * (1.0 - share) * f64::from(resamples)) as usize;
    [values[tail], values[values.len() - 1 - tail]]
}

/// A grown stem of the default numbers.
pub fn grown(seed: u64) -> Stem {
    Stem::grow(Stream::root(seed).child("stem"), &StemParameters::from_values(&mut |p| p.default))
}
