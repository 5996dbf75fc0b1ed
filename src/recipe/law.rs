//! What a distribution's draws for a parameter look like: their law, for whoever tests draws.
//!
//! A draw is a sample, rounded where the parameter is a count, that was made again until it lay within the bounds: so the
//! law is that of the samples, cut at the bounds.

use procedural::Parameter;

use super::dist::Distribution;
use crate::chance::DrawLaw;

impl Distribution {
    /// The law of [`Self::draw`] for `parameter`.
    pub fn law(&self, parameter: &Parameter) -> DrawLaw {
        let (min, max) = self.bounds(parameter);
        if min >= max {
            return DrawLaw::Fixed(min);
        }
        // The bounds of a truncated distribution are its own: what is cut is the one inside.
        let of = match self {
            Self::Truncated { of, .. } => of,
            other => other,
        };
        let mut cells = match of.weighed(parameter.integer) {
            Some(cells) => cells,
            None if parameter.integer => {
                let count = |i: u64| min + i as f64;
                let chance = |k: f64| of.mass(k - 0.5, k + 0.5, 0.5);
                (0..=(max - min) as u64).map(|i| (count(i), chance(count(i)))).collect()
            }
            None => {
                let (of, inside) = (of.clone(), of.mass(min, max, 0.0));
                let below = Box::new(move |x: f64| (of.mass(min, x, 0.0) / inside).clamp(0.0, 1.0));
                return DrawLaw::Continuous { min, max, cdf: below };
            }
        };
        // The sum takes the sign from -0.
        cells.iter_mut().for_each(|cell| cell.0 += 0.0);
        cells.retain(|(value, chance)| (min..=max).contains(value) && *chance > 0.0);
        cells.sort_by(|a, b| a.0.total_cmp(&b.0));
        cells.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 += next.1;
            }
            same
        });
        let sum: f64 = cells.iter().map(|cell| cell.1).sum();
        match cells.as_slice() {
            [(value, _)] => DrawLaw::Fixed(*value),
            _ => DrawLaw::Discrete(cells.into_iter().map(|(value, chance)| (value, chance / sum)).collect()),
        }
    }

    /// The numbers of a choice with their weights; `None` where it is none.
    fn weighed(&self, count: bool) -> Option<Vec<(f64, f64)>> {
        match self {
            Self::Choice { values, weights } => {
                let whole = |value: f64| if count { value.round() } else { value };
                Some(values.iter().map(|value| whole(*value)).zip(weights.iter().copied()).collect())
            }
            _ => None,
        }
    }
}
