//! Two pictures of one scene held against each other.

use super::Picture;

/// Both sides of one scene on the same pixels.
pub struct Verdict {
    pub name: String,
    pub reference: Picture,
    /// `[rows, cols]` [e-].
    pub production: Vec<f64>,
}

/// Chance of a false alarm in one scene, all its pixels together.
pub const ALPHA: f64 = 0.01;
/// Fewest rays in a pixel for its mean to be taken as normal.
const FEWEST_RAYS: f64 = 40.0;
/// Least light of a pixel that is tested, over the greatest of the scene: a quarter of a digital number of 8 bits.
const FAINT: f64 = 1e-3;
/// Rows on each side of the peak whose centre of gravity is taken.
const REACH: usize = 7;
/// Columns darker than this share of the median column are dark.
const DARK: f64 = 0.02;

/// What the comparison of the columns judged says.
#[derive(Debug, Clone, Copy)]
pub struct Finding {
    /// Pixels tested.
    pub pixels: usize,
    /// Greatest |z| and the bound that all pixels keep with 1 - ALPHA (Bonferroni).
    pub worst: f64,
    pub bound: f64,
    /// Sum of z^2 over the number of pixels.
    pub chi2: f64,
    /// Relative standard error of the reference in its brightest pixels: the median of the greatest of each column.
    pub peak_error: f64,
    /// Production over reference less 1: all light, and its standard error.
    pub total: [f64; 2],
    /// The same for pixels of at least a tenth of the greatest.
    pub bright: f64,
    /// Production less reference, rows: mean, its standard error, root mean square, and the part of that which is
    /// chance.
    pub shift: [f64; 4],
    /// Greatest relative deviation of pixels pooled by their distance from the line, its standard error, that distance.
    pub pooled: [f64; 3],
    /// Columns that are dark on one side alone.
    pub disputed: usize,
    /// Columns that are dark on both sides.
    pub dark: usize,
}

impl Verdict {
    fn cols(&self) -> usize {
        self.reference.region.cols
    }

    /// Electrons of a column on either side: production's, reference's [e-].
    pub fn column(&self, c: usize) -> [f64; 2] {
        let sum = |picture: &[f64]| picture.iter().skip(c).step_by(self.cols()).sum();
        [sum(&self.production), sum(&self.reference.mean)]
    }

    /// Columns that are dark: production's, reference's.
    pub fn dark(&self) -> Vec<[bool; 2]> {
        let sums: Vec<[f64; 2]> = (0..self.cols()).map(|c| self.column(c)).collect();
        let mut lit: Vec<f64> = sums.iter().map(|s| s[1]).filter(|&s| s > 0.0).collect();
        lit.sort_by(f64::total_cmp);
        let median = lit[lit.len() / 2];
        sums.iter().map(|s| s.map(|s| s < DARK * median)).collect()
    }

    /// Production's line in each column, in rows of the region; `None` where the column is dark.
    pub fn centre_rows(&self) -> Vec<Option<f64>> {
        let dark = self.dark();
        (0..self.cols()).map(|c| (!dark[c][0]).then(|| self.centres(c)[0])).collect()
    }

    /// Centre of gravity of a column about production's peak: production's, reference's, the reference's variance [px].
    fn centres(&self, c: usize) -> [f64; 3] {
        let (cols, rows) = (self.cols(), self.reference.region.rows);
        let at = |picture: &[f64], k: usize| picture[k * cols + c];
        let peak = (0..rows).max_by(|&a, &b| at(&self.production, a).total_cmp(&at(&self.production, b))).unwrap_or(0);
        let window = peak.saturating_sub(REACH)..(peak + REACH + 1).min(rows);
        let centre = |picture: &[f64]| {
            let sum: f64 = window.clone().map(|k| at(picture, k)).sum();
            let moment: f64 = window.clone().map(|k| k as f64 * at(picture, k)).sum();
            (moment / sum, sum)
        };
        let (own, _) = centre(&self.production);
        let (other, sum) = centre(&self.reference.mean);
        let variance =
            window.clone().map(|k| ((k as f64 - other) * at(&self.reference.error, k) / sum).powi(2)).sum::<f64>();
        [own, other, variance]
    }

    /// The comparison of the columns for which `judged` says so; others stand at edges, say.
    pub fn find(&self, judged: impl Fn(usize) -> bool) -> Finding {
        let (cols, rows) = (self.cols(), self.reference.region.rows);
        let dark = self.dark();
        let columns: Vec<usize> = (0..cols).filter(|&c| judged(c + self.reference.region.first_col)).collect();
        let lit: Vec<usize> = columns.iter().copied().filter(|&c| dark[c] == [false; 2]).collect();
        let greatest = self.reference.mean.iter().copied().fold(0.0, f64::max);

        let mut scores = Vec::new();
        let (mut sums, mut chance) = ([0.0; 4], 0.0);
        for i in lit.iter().flat_map(|&c| (0..rows).map(move |k| k * cols + c)) {
            let (own, other, error) = (self.production[i], self.reference.mean[i], self.reference.error[i]);
            let quantum = if other > 0.0 { error * error / other } else { self.reference.quantum };
            if own.max(other) >= (FEWEST_RAYS * quantum).max(FAINT * greatest) {
                // The variance that the reference would have were production right.
                scores.push((own - other) / (own * quantum).sqrt().max(1e-12));
            }
            sums[0] += own;
            sums[1] += other;
            if other >= 0.1 * greatest {
                sums[2] += own;
                sums[3] += other;
            }
            chance += error * error;
        }
        let mut peaks: Vec<f64> = lit
            .iter()
            .filter_map(|&c| {
                let best = (0..rows)
                    .map(|k| k * cols + c)
                    .max_by(|&a, &b| self.reference.mean[a].total_cmp(&self.reference.mean[b]))?;
                Some(self.reference.error[best] / self.reference.mean[best])
            })
            .collect();
        peaks.sort_by(f64::total_cmp);

        let centres: Vec<[f64; 3]> = lit.iter().map(|&c| self.centres(c)).collect();
        let n = centres.len() as f64;
        let mean = |f: &dyn Fn(&[f64; 3]) -> f64| centres.iter().map(f).sum::<f64>() / n;
        let noise = mean(&|c| c[2]);
        Finding {
            pixels: scores.len(),
            worst: scores.iter().fold(0.0, |worst, z| worst.max(z.abs())),
            bound: bound(ALPHA / scores.len() as f64),
            chi2: scores.iter().map(|z| z * z).sum::<f64>() / scores.len() as f64,
            peak_error: peaks[peaks.len() / 2],
            total: [sums[0] / sums[1] - 1.0, chance.sqrt() / sums[1]],
            bright: sums[2] / sums[3] - 1.0,
            shift: [mean(&|c| c[0] - c[1]), (noise / n).sqrt(), mean(&|c| (c[0] - c[1]).powi(2)).sqrt(), noise.sqrt()],
            pooled: self.pooled(&lit, &centres, greatest),
            disputed: columns.iter().filter(|&&c| dark[c][0] != dark[c][1]).count(),
            dark: columns.iter().filter(|&&c| dark[c] == [true; 2]).count(),
        }
    }

    /// Greatest deviation of pixels pooled in quarter rows by their distance from production's line, where they hold at
    /// least a twentieth of the greatest light.
    fn pooled(&self, lit: &[usize], centres: &[[f64; 3]], greatest: f64) -> [f64; 3] {
        let (cols, rows) = (self.cols(), self.reference.region.rows);
        let mut bins = std::collections::BTreeMap::<i64, [f64; 4]>::new();
        for (&c, centre) in lit.iter().zip(centres) {
            for k in 0..rows {
                let i = k * cols + c;
                let bin = bins.entry(((k as f64 - centre[0]) * 4.0).round() as i64).or_default();
                bin[0] += self.production[i];
                bin[1] += self.reference.mean[i];
                bin[2] += self.reference.error[i].powi(2);
                bin[3] += 1.0;
            }
        }
        let deviations = bins.iter().filter(|(_, b)| b[1] / b[3] > 0.05 * greatest && b[2].sqrt() < 0.01 * b[1]);
        let deviations = deviations.map(|(at, b)| [b[0] / b[1] - 1.0, b[2].sqrt() / b[1], *at as f64 / 4.0]);
        deviations.max_by(|a, b| a[0].abs().total_cmp(&b[0].abs())).unwrap_or_default()
    }

    /// Holds the columns judged to the bars, and prints a line of the table in docs/theory/instrument/reference.md.
    pub fn hold(&self, judged: impl Fn(usize) -> bool) -> Finding {
        let f = self.find(judged);
        println!(
            "| {} | {} | {:.1} % | {:.1} / {:.1} | {:.2} | {:+.2} ± {:.2} % | {:+.2} % | {:+.4} ± {:.4} | {:.4} \
                ({:.4}) | {:+.1} ± {:.1} % at {:+.2} | {} |",
            self.name,
            f.pixels,
            100.0 * f.peak_error,
            f.worst,
            f.bound,
            f.chi2,
            100.0 * f.total[0],
            100.0 * f.total[1],
            100.0 * f.bright,
            f.shift[0],
            f.shift[1],
            f.shift[2],
            f.shift[3],
            100.0 * f.pooled[0],
            100.0 * f.pooled[1],
            f.pooled[2],
            f.dark,
        );
        let name = &self.name;
        assert!(f.pixels > 150, "{name}: only {} pixels are bright enough to be judged", f.pixels);
        assert!(f.peak_error < 0.02, "{name}: the reference's own error is {:.3} at the peak", f.peak_error);
        assert!(f.worst < f.bound, "{name}: a pixel is {:.1} standard errors off, {:.1} are allowed", f.worst, f.bound);
        assert!(f.total[0].abs() < 0.01, "{name}: all light is {:.4} off", f.total[0]);
        assert!(f.bright.abs() < 0.01, "{name}: bright pixels are {:.4} off", f.bright);
        assert!(f.shift[2] < 1.0 / 16.0, "{name}: the line is {:.4} rows off (rms)", f.shift[2]);
        assert!(f.disputed == 0, "{name}: {} columns are dark on one side alone", f.disputed);
        f
    }
}

/// The |z| that a normal number exceeds with probability `chance`, both sides together.
pub fn bound(chance: f64) -> f64 {
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if libm::erfc(middle / std::f64::consts::SQRT_2) > chance { low = middle } else { high = middle }
    }
    high
}
