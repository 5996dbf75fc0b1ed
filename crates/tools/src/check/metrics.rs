//! Classification metrics: confusion matrix, precision, recall, F1, intersection over union and calibration error.
//!
//! **Calibration**: predictions go to ten bins by confidence; the expected calibration error is the mean distance of a
//! bin's accuracy from its mean confidence, weighted by its predictions (Naeini 2015, Guo 2017).

/// Bins of confidence.
pub(crate) const CONFIDENCE_BINS: usize = 10;

/// Predictions of like confidence: a bin of the reliability diagram.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CalibrationBin {
    /// Guesses.
    pub count: u64,
    /// Right ones.
    pub right: u64,
    /// Sum of confidences.
    pub confidence: f64,
}

/// Figures of one class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClassMetrics {
    /// How often it was true.
    pub support: u64,
    /// How often it was guessed.
    pub guessed: u64,
    /// Right among the guesses of it.
    pub precision: Option<f64>,
    /// Right among those that it was true of.
    pub recall: Option<f64>,
    /// Harmonic mean of the two.
    pub f1: Option<f64>,
    /// Right among those that it was true of or guessed for: intersection over union.
    pub iou: Option<f64>,
}

/// Confusion matrix and reliability bins, filled prediction by prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassificationMetrics {
    classes: usize,
    confusion: Vec<u64>,
    bins: [CalibrationBin; CONFIDENCE_BINS],
}

impl ClassificationMetrics {
    /// For `classes` classes.
    pub fn new(classes: usize) -> Self {
        Self { classes, confusion: vec![0; classes * classes], bins: [CalibrationBin::default(); CONFIDENCE_BINS] }
    }

    /// Takes one guess; both classes are below the number of classes.
    pub fn add(&mut self, truth: usize, guess: usize, confidence: f64) {
        self.confusion[truth * self.classes + guess] += 1;
        // A bin owns its lower end: of two classes 0.5 is the least that the better one can have.
        let bin = ((confidence * CONFIDENCE_BINS as f64) as usize).min(CONFIDENCE_BINS - 1);
        let bin = &mut self.bins[bin];
        bin.count += 1;
        bin.right += u64::from(truth == guess);
        bin.confidence += confidence;
    }

    /// Counts, `[true class, guessed class]`.
    pub fn confusion(&self) -> Vec<&[u64]> {
        self.confusion.chunks(self.classes).collect()
    }

    /// Bins by confidence, from 0 to 1.
    pub fn bins(&self) -> &[CalibrationBin; CONFIDENCE_BINS] {
        &self.bins
    }

    /// Guesses.
    pub fn count(&self) -> u64 {
        self.confusion.iter().sum()
    }

    /// The figures of every class.
    pub fn classes(&self) -> Vec<ClassMetrics> {
        let ratio = |right: u64, of: u64| (of > 0).then(|| right as f64 / of as f64);
        let figures = |class: usize| {
            let right = self.confusion[class * self.classes + class];
            let support = self.confusion[class * self.classes..][..self.classes].iter().sum();
            let guessed = (0..self.classes).map(|truth| self.confusion[truth * self.classes + class]).sum();
            ClassMetrics {
                support,
                guessed,
                precision: ratio(right, guessed),
                recall: ratio(right, support),
                f1: ratio(2 * right, support + guessed),
                iou: ratio(right, support + guessed - right),
            }
        };
        (0..self.classes).map(figures).collect()
    }

    /// Mean recall of the classes that were true of anything.
    pub(crate) fn balanced_accuracy(&self) -> Option<f64> {
        mean(self.classes().into_iter().filter_map(|class| class.recall))
    }

    /// Mean intersection over union of the classes that were true of anything or guessed.
    pub(crate) fn mean_iou(&self) -> Option<f64> {
        mean(self.classes().into_iter().filter_map(|class| class.iou))
    }

    /// Expected calibration error; `None` without guesses.
    pub(crate) fn calibration_error(&self) -> Option<f64> {
        let n = self.count();
        let off = |bin: &CalibrationBin| (bin.right as f64 - bin.confidence).abs();
        (n > 0).then(|| self.bins.iter().map(off).sum::<f64>() / n as f64)
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let values: Vec<f64> = values.collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: f64, wanted: f64, error: f64) {
        assert!((found - wanted).abs() < error, "{found}, not {wanted}");
    }

    /// By hand: 3 clear, 2 knot, 1 rot.
    #[test]
    fn figures_of_classes_are_those_by_hand() {
        let mut metrics = ClassificationMetrics::new(3);
        for (truth, guess) in [(0, 0), (0, 0), (0, 1), (1, 1), (1, 2), (2, 1)] {
            metrics.add(truth, guess, 0.5);
        }
        assert_eq!(metrics.confusion(), [[2, 1, 0], [0, 1, 1], [0, 1, 0]]);
        let [clear, knot, rot] = metrics.classes().try_into().expect("three classes");
        assert_eq!(
            (clear.precision, clear.recall, clear.f1, clear.iou),
            (Some(1.0), Some(2.0 / 3.0), Some(0.8), Some(2.0 / 3.0))
        );
        assert_eq!(
            (knot.precision, knot.recall, knot.f1, knot.iou),
            (Some(1.0 / 3.0), Some(0.5), Some(0.4), Some(0.25))
        );
        assert_eq!((rot.support, rot.guessed, rot.precision, rot.f1), (1, 1, Some(0.0), Some(0.0)));
        near(metrics.balanced_accuracy().expect("classes"), (2.0 / 3.0 + 0.5) / 3.0, 1e-15);
        near(metrics.mean_iou().expect("classes"), (2.0 / 3.0 + 0.25) / 3.0, 1e-15);
    }

    /// A class that never was true nor guessed has no figures and does not pull the means down.
    #[test]
    fn absent_classes_have_no_figures() {
        let mut metrics = ClassificationMetrics::new(3);
        metrics.add(0, 0, 1.0);
        let last = metrics.classes()[2];
        assert_eq!((last.precision, last.recall, last.f1, last.iou), (None, None, None, None));
        assert_eq!((metrics.balanced_accuracy(), metrics.mean_iou()), (Some(1.0), Some(1.0)));
        let none = ClassificationMetrics::new(2);
        assert_eq!((none.balanced_accuracy(), none.calibration_error()), (None, None));
    }

    /// By hand: two guesses at 0.95 of which one is right, two at 0.6 (lower end of its bin) both right.
    #[test]
    fn calibration_is_that_by_hand() {
        let mut metrics = ClassificationMetrics::new(2);
        for (guess, confidence) in [(0, 0.95), (1, 0.95), (0, 0.6), (0, 0.6)] {
            metrics.add(0, guess, confidence);
        }
        assert_eq!((metrics.bins()[9].count, metrics.bins()[9].right, metrics.bins()[6].count), (2, 1, 2));
        near(metrics.calibration_error().expect("guesses"), 0.5 * 0.45 + 0.5 * 0.4, 1e-12);
        metrics.add(1, 1, 1.0);
        assert_eq!(metrics.bins()[9].count, 3);
    }
}
