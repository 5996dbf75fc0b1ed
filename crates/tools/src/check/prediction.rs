//! Predicted class and its confidence, from the logits or probabilities that a model answers.

use super::sidecar::OutputKind;

/// How far probabilities may miss 1 together: single precision, and sums that somebody rounded [1].
const PROBABILITY_TOLERANCE: f32 = 1e-3;

/// The class of the largest probability, and that probability. One number is the second class of two.
///
/// # Errors
/// Where a number is not finite, or is no probability though it should be; what to do.
pub(crate) fn predict(scores: &[f32], output: OutputKind) -> Result<(usize, f64), String> {
    if let Some(bad) = scores.iter().find(|score| !score.is_finite()) {
        return Err(format!(
            "it answers {bad}; hold mean, sd and missing of the channels against what it was trained with"
        ));
    }
    let sum: f32 = if scores.len() == 1 { 1.0 } else { scores.iter().sum() };
    let is_probability = |p: &f32| (-PROBABILITY_TOLERANCE..=1.0 + PROBABILITY_TOLERANCE).contains(p);
    if output == OutputKind::Probabilities
        && (!scores.iter().all(is_probability) || (sum - 1.0).abs() > PROBABILITY_TOLERANCE)
    {
        return Err("it answers numbers that are no probabilities; write `output: logits` in the sidecar".into());
    }
    if let [one] = scores {
        let p = match output {
            OutputKind::Logits => 1.0 / (1.0 + libm::exp(-f64::from(*one))),
            OutputKind::Probabilities => f64::from(*one).clamp(0.0, 1.0),
        };
        // At a half the first class is taken, as of two equal numbers.
        return Ok(if p > 0.5 { (1, p) } else { (0, 1.0 - p) });
    }
    let mut best = 0;
    for (class, score) in scores.iter().enumerate() {
        if *score > scores[best] {
            best = class;
        }
    }
    let top = f64::from(scores[best]);
    let confidence = match output {
        OutputKind::Logits => 1.0 / scores.iter().map(|score| libm::exp(f64::from(*score) - top)).sum::<f64>(),
        OutputKind::Probabilities => top.clamp(0.0, 1.0),
    };
    Ok((best, confidence))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near((class, confidence): (usize, f64), wanted: (usize, f64)) {
        assert!(class == wanted.0 && (confidence - wanted.1).abs() < 1e-7, "{class} {confidence}, not {wanted:?}");
    }

    /// Softmax of ln 1, ln 2, ln 5 is 1/8, 2/8, 5/8; adding the same to all changes nothing; large numbers overflow
    /// nothing.
    #[test]
    fn logits_become_probabilities() {
        let logits = [1.0_f32, 2.0, 5.0].map(f32::ln);
        near(predict(&logits, OutputKind::Logits).expect("finite"), (2, 0.625));
        near(predict(&logits.map(|x| x + 10.0), OutputKind::Logits).expect("finite"), (2, 0.625));
        near(predict(&[-1e30, 1e30], OutputKind::Logits).expect("finite"), (1, 1.0));
        near(predict(&[3.0, 3.0], OutputKind::Logits).expect("finite"), (0, 0.5));
    }

    #[test]
    fn one_number_tells_two_classes_apart() {
        near(predict(&[3.0_f32.ln()], OutputKind::Logits).expect("finite"), (1, 0.75));
        near(predict(&[-3.0_f32.ln()], OutputKind::Logits).expect("finite"), (0, 0.75));
        near(predict(&[0.2], OutputKind::Probabilities).expect("finite"), (0, 0.8));
    }

    #[test]
    fn what_is_no_answer_is_told() {
        near(predict(&[0.1, 0.7, 0.2], OutputKind::Probabilities).expect("they are"), (1, 0.7));
        for wrong in [&[0.4, 0.4][..], &[-1.0, 2.0], &[1.5]] {
            assert!(
                predict(wrong, OutputKind::Probabilities).expect_err("none").contains("output: logits"),
                "{wrong:?}"
            );
        }
        assert!(predict(&[1.0, f32::NAN], OutputKind::Logits).expect_err("NaN").contains("NaN"));
        assert!(predict(&[1.0, f32::INFINITY], OutputKind::Logits).is_err());
    }
}
