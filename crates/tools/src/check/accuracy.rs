//! Accuracy with its Wilson interval at 95 %, on an effective number of independent predictions.
//!
//! **Accuracy** is the share of right guesses. Its interval is Wilson's (1927) at 95 %,
//!
//! ```text
//! (p + z^2/2n -+ z sqrt(p(1-p)/n + z^2/4n^2)) / (1 + z^2/n),    z = 1.96
//! ```
//!
//! which holds for independent guesses. Patches and pixels of one sample are not: they share a board, a laser and a
//! camera. So n is the effective number: guesses over the design effect (Kish 1965), which is the variance of the share
//! between samples over the variance that independent guesses would have,
//!
//! ```text
//! deff = m/(m-1) sum_i (c_i - p n_i)^2 / (n p (1-p)),    n_eff = n / max(1, deff)
//! ```
//!
//! with n_i guesses of sample i, c_i of them right, and m samples. That variance is known as well as there are samples
//! to know it from. Of a share near 1 these are the k that have a wrong guess (near 0, those that have a right one),
//! fewer than m: so n_eff is cut as Korn and Graubard (1998) cut it for lost degrees of freedom,
//!
//! ```text
//! n_eff' = n_eff (t_{m-1} / t_k)^2, but not below m,    t_v = 97.5 % quantile of Student's law
//! ```
//!
//! since m is what samples whose guesses are all alike are worth. Where all guesses are right or all are wrong, k is 0
//! and n_eff is m; so it is with one sample. Where every sample has an error nothing is cut. With one guess a sample
//! n_eff is n.

/// Quantile of the normal law for 95 % [1].
const NORMAL_QUANTILE: f64 = 1.959_963_984_540_054;

/// Right predictions among all, and how they spread over samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Accuracy {
    /// Right guesses.
    pub right: u64,
    /// Guesses.
    pub of: u64,
    /// Samples that had any.
    pub samples: u64,
    right_squared: u128,
    right_times_of: u128,
    of_squared: u128,
    /// Samples with a right guess, and with a wrong one.
    showing: [u64; 2],
}

impl Accuracy {
    /// Takes the guesses of one sample, all of them at once.
    pub fn add(&mut self, right: u64, of: u64) {
        if of == 0 {
            return;
        }
        let (c, n) = (u128::from(right), u128::from(of));
        self.right += right;
        self.of += of;
        self.samples += 1;
        self.right_squared += c * c;
        self.right_times_of += c * n;
        self.of_squared += n * n;
        self.showing[0] += u64::from(right > 0);
        self.showing[1] += u64::from(right < of);
    }

    /// The share itself; `None` without guesses.
    pub fn value(&self) -> Option<f64> {
        (self.of > 0).then(|| self.right as f64 / self.of as f64)
    }

    /// Number of independent guesses that would know the share as well.
    pub fn effective(&self) -> f64 {
        let (n, m) = (self.of as f64, self.samples as f64);
        if self.of == self.samples {
            return n;
        }
        if self.samples < 2 || self.right == 0 || self.right == self.of {
            return m;
        }
        let p = self.right as f64 / n;
        let spread = self.right_squared as f64 - 2.0 * p * self.right_times_of as f64 + p * p * self.of_squared as f64;
        let effect = m / (m - 1.0) * spread.max(0.0) / (n * p * (1.0 - p));
        let known = n / effect.max(1.0);
        let [right, wrong] = self.showing;
        let lost = student_quantile(self.samples - 1) / student_quantile(right.min(wrong).min(self.samples - 1));
        known.min((known * lost * lost).max(m))
    }

    /// The 95 % interval; all of [0, 1] without guesses.
    pub(crate) fn interval(&self) -> [f64; 2] {
        self.value().map_or([0.0, 1.0], |p| wilson_interval(p, self.effective()))
    }
}

/// 97.5 % quantile of Student's law with `freedom` degrees of freedom, at least 1: the first two in closed form, the
/// others by its expansion in 1 / freedom (Abramowitz and Stegun 26.7.5), right to 0.002 of itself.
fn student_quantile(freedom: u64) -> f64 {
    match freedom {
        0 | 1 => 12.706_204_736,
        2 => 4.302_652_730,
        _ => {
            let (z, v) = (NORMAL_QUANTILE, freedom as f64);
            let [z3, z5, z7, z9] = [3, 5, 7, 9].map(|power| z.powi(power));
            z + (z3 + z) / (4.0 * v)
                + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * v.powi(2))
                + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * v.powi(3))
                + (79.0 * z9 + 776.0 * z7 + 1482.0 * z5 - 1920.0 * z3 - 945.0 * z) / (92160.0 * v.powi(4))
        }
    }
}

/// Wilson's 95 % interval of a share `p` of `n` independent guesses.
pub(crate) fn wilson_interval(p: f64, n: f64) -> [f64; 2] {
    let z2 = NORMAL_QUANTILE * NORMAL_QUANTILE / n;
    let (middle, half) = (p + z2 / 2.0, NORMAL_QUANTILE * (p * (1.0 - p) / n + z2 / (4.0 * n)).sqrt());
    [((middle - half) / (1.0 + z2)).max(0.0), ((middle + half) / (1.0 + z2)).min(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: f64, wanted: f64, error: f64) {
        assert!((found - wanted).abs() < error, "{found}, not {wanted}");
    }

    /// Newcombe's (1998) worked example: 81 of 263 give 0.2553 to 0.3662; none of 20 gives 0 to 0.1611.
    #[test]
    fn intervals_are_the_published_ones() {
        let [low, high] = wilson_interval(81.0 / 263.0, 263.0);
        near(low, 0.2553, 5e-5);
        near(high, 0.3662, 5e-5);
        let [low, high] = wilson_interval(0.0, 20.0);
        near(low, 0.0, 1e-12);
        near(high, 0.1611, 5e-5);
    }

    fn share(samples: &[(u64, u64)]) -> Accuracy {
        let mut share = Accuracy::default();
        samples.iter().for_each(|&(right, of)| share.add(right, of));
        share
    }

    /// One guess a sample: independent. Samples that are all right or all wrong: as many guesses as samples (with the
    /// small-sample factor m/(m-1)). Samples that all have the same share: independent at least.
    #[test]
    fn guesses_of_one_sample_count_as_what_they_tell() {
        near(share(&[(1, 1), (0, 1), (1, 1)]).effective(), 3.0, 1e-12);
        near(share(&[(10, 10), (0, 10), (10, 10), (0, 10)]).effective(), 3.0, 1e-12);
        near(share(&[(5, 10), (5, 10), (5, 10)]).effective(), 30.0, 1e-12);
        near(share(&[(10, 10), (10, 10)]).effective(), 2.0, 1e-12);
        near(share(&[(5, 10)]).effective(), 1.0, 1e-12);
        assert_eq!(share(&[(0, 0)]), Accuracy::default());
        assert_eq!(Accuracy::default().interval(), [0.0, 1.0]);
    }

    /// Quantiles of published tables of Student's law.
    #[test]
    fn student_is_the_published_one() {
        for (freedom, wanted) in [(1, 12.7062), (2, 4.3027), (3, 3.1824), (5, 2.5706), (10, 2.2281), (120, 1.9799)] {
            near(student_quantile(freedom) / wanted, 1.0, 0.002);
        }
        near(student_quantile(u64::MAX), NORMAL_QUANTILE, 1e-9);
    }

    /// By hand, 24 samples of six guesses: few errors cannot say whether errors come alone, so one of them leaves the
    /// interval near that of none; three lone ones are worth 144 (t_23 / t_3)^2 = 144 (2.0687 / 3.1824)^2 = 60.8
    /// guesses. Where each sample has one nothing is cut, and guesses that share their sample's fate are never worth
    /// more for it.
    #[test]
    fn few_errors_do_not_make_sure() {
        let wrong_in = |count: usize, wrong: u64| {
            share(&(0..24).map(|i| (6 - if i < count { wrong } else { 0 }, 6)).collect::<Vec<_>>())
        };
        near(wrong_in(0, 0).effective(), 24.0, 1e-12);
        near(wrong_in(1, 1).effective(), 24.0, 1e-12);
        near(wrong_in(3, 1).effective(), 60.8, 0.3);
        near(wrong_in(24, 1).effective(), 144.0, 1e-9);
        near(wrong_in(24, 5).effective(), 144.0, 1e-9);
        let alike = wrong_in(6, 6).effective();
        near(alike, 23.0, 1e-9);
        let lows: Vec<f64> = (0..5).map(|count| wrong_in(count, 1).interval()[0]).collect();
        assert!(lows.windows(2).all(|two| (two[1] - two[0]).abs() < 0.04), "{lows:?}");
        let [none, one] = [0, 1].map(|count| wrong_in(count, 1).interval());
        assert!(one[0] < none[0] && one[1] <= none[1], "{one:?} {none:?}");
        // Few right ones are as few wrong ones.
        let mirrored = share(&(0..24).map(|i| (u64::from(i < 3), 6)).collect::<Vec<_>>());
        near(mirrored.effective(), wrong_in(3, 1).effective(), 1e-9);
    }
}
