//! What keys do to statistics: simulated scans with a key at some values, all else as it was drawn.
//!
//! A key at value v shifts the statistics of a scan by what the same scans show with the key there less what they show
//! with it in the middle of its distribution. Beyond the ends of the distribution values lie on a ladder, evenly or in
//! equal ratios as the key calls for, until the declared range ends, the recipe refuses or [`FAR`] is reached; between
//! rungs shifts are linear. What shift leaves least of a real scan's squared depth is what the key explains of it.

use nalgebra::DVector;
use rayon::prelude::*;
use recipe::{Change, Recipe};

use super::ScanNumbers;
use super::spread::ScanSpread;
use crate::prior::FitKey;

/// Places of the rungs of a ladder, over its length: few to choose keys by, all for those that are chosen.
pub(super) const FEW_RUNGS: &[f64] = &[0.06, 0.25];
pub(super) const ALL_RUNGS: &[f64] = &[0.03, 0.06, 0.12, 0.25, 0.5, 1.0];
/// Length of a ladder: in equal ratios as a factor, else in widths of what the recipe draws.
const FAR: [f64; 2] = [100.0, 10.0];
/// Ratio of a declared range's ends from which its values lie in equal ratios.
const WIDE: f64 = 30.0;
/// Steps between two rungs that are tried.
const STEPS: usize = 12;
/// Squared deviation that stands for a statistic of the real scan which simulated ones don't tell at some value.
const UNTOLD: f64 = 9.0;

/// A key with the values beyond what the recipe draws, and what they do.
#[derive(Debug, Clone)]
pub(super) struct KeyLadder {
    pub key: FitKey,
    pub low: f64,
    pub high: f64,
    pub rungs: Vec<KeyRung>,
    is_log: bool,
}

/// A value of a key, and the shift of each statistic there; `None` where it is not told.
#[derive(Debug, Clone)]
pub(super) struct KeyRung {
    pub value: f64,
    pub shift: Vec<Option<f64>>,
}

/// The value of a key that explains most of a scan.
#[derive(Debug, Clone)]
pub(super) struct KeyAnswer {
    pub value: f64,
    /// What is left of the scan, from the middle of simulated ones, in robust deviations.
    pub left: DVector<f64>,
    /// Squared depth that is left.
    pub square: f64,
    /// The shift of each statistic.
    pub shift: Vec<Option<f64>>,
}

/// Mean over scans of what one set of them tells less what another does; `None` where fewer than half of the pairs tell
/// both.
pub(super) fn mean_shift(there: &[ScanNumbers], here: &[ScanNumbers]) -> Vec<Option<f64>> {
    let of = |j: usize| {
        let pairs: Vec<f64> = there.iter().zip(here).filter_map(|(there, here)| Some(there[j]? - here[j]?)).collect();
        (!pairs.is_empty() && 2 * pairs.len() >= there.len()).then(|| pairs.iter().sum::<f64>() / pairs.len() as f64)
    };
    (0..there.first().map_or(0, Vec::len)).map(of).collect()
}

impl KeyLadder {
    /// Of a key, with rungs at these places.
    pub fn new(key: &FitKey, places: &[f64]) -> Self {
        let (low, high) = key.prior.bounds(key.parameter);
        let declared = [key.parameter.min, key.parameter.max];
        let is_log = low > 0.0 && (key.prior.is_log() || declared[0] > 0.0 && declared[1] > WIDE * declared[0]);
        let middle = key.value(0.0);
        let width = match high - low {
            0.0 if middle == 0.0 => (declared[1] - declared[0]) / 50.0,
            0.0 => 0.5 * middle.abs(),
            width => width,
        };
        let at = |end: f64, side: f64, place: f64| {
            let value =
                if is_log { end * libm::pow(FAR[0], side * place) } else { end + side * place * FAR[1] * width };
            let value = value.clamp(declared[0], declared[1]);
            if key.parameter.integer { value.round() } else { value }
        };
        let mut values: Vec<f64> =
            places.iter().flat_map(|&place| [at(low, -1.0, place), at(high, 1.0, place)]).collect();
        values.retain(|value| !(low..=high).contains(value));
        values.push(middle);
        values.sort_by(f64::total_cmp);
        values.dedup();
        let rungs = values.into_iter().map(|value| KeyRung { value, shift: Vec::new() }).collect();
        Self { key: key.clone(), low, high, rungs, is_log }
    }

    /// Fills its shifts by `scans` of a recipe, leaves out rungs whose value the recipe refuses, and returns for how
    /// many values scans were made; `as_drawn` are those of the recipe as it is.
    pub fn fill(
        &mut self,
        scans: &(dyn Fn(&Recipe) -> Vec<ScanNumbers> + Sync),
        recipe: &Recipe,
        as_drawn: &[ScanNumbers],
    ) -> usize {
        let path = self.key.path.as_str();
        let middle = self.key.value(0.0);
        let is_fixed = self.low == self.high;
        let here = if is_fixed { as_drawn.to_vec() } else { scans(&recipe.with_values([(path, middle)])) };
        let shift = |value: f64| {
            if value == middle {
                return Some(mean_shift(&here, &here));
            }
            let change: Change = format!("{path}={value}").parse().ok()?;
            let changed = recipe.changed(&[change]).ok()?;
            Some(mean_shift(&scans(&changed), &here))
        };
        let shifts: Vec<Option<Vec<Option<f64>>>> = self.rungs.par_iter().map(|rung| shift(rung.value)).collect();
        let filled = self.rungs.iter().zip(shifts);
        self.rungs = filled.filter_map(|(rung, shift)| Some(KeyRung { value: rung.value, shift: shift? })).collect();
        self.rungs.len() - usize::from(is_fixed)
    }

    /// The value beyond what the recipe draws that explains most of a scan; `None` where it has none.
    pub fn answer(&self, spread: &ScanSpread, standard: &DVector<f64>, told: &[usize]) -> Option<KeyAnswer> {
        let scale = |value: f64| if self.is_log { libm::log(value) } else { value };
        let unscale = |at: f64| if self.is_log { libm::exp(at) } else { at };
        let mut best: Option<KeyAnswer> = None;
        for pair in self.rungs.windows(2) {
            let [from, to] = [scale(pair[0].value), scale(pair[1].value)];
            for step in 0..=STEPS {
                let part = step as f64 / STEPS as f64;
                let value = unscale(from + part * (to - from));
                let value = if self.key.parameter.integer { value.round() } else { value };
                if (self.low..=self.high).contains(&value) {
                    continue;
                }
                let between = |(from, to): (&Option<f64>, &Option<f64>)| Some((1.0 - part) * (*from)? + part * (*to)?);
                let shift: Vec<Option<f64>> = pair[0].shift.iter().zip(&pair[1].shift).map(between).collect();
                let (left, untold) = left_of(spread, standard, told, &shift);
                let depth = spread.depth(&left);
                let square = depth * depth + UNTOLD * untold as f64;
                if best.as_ref().is_none_or(|best| square < best.square) {
                    best = Some(KeyAnswer { value, left, square, shift });
                }
            }
        }
        best
    }
}

/// What a shift leaves of a scan, and how many of the statistics that it tells the shift does not.
fn left_of(
    spread: &ScanSpread,
    standard: &DVector<f64>,
    told: &[usize],
    shift: &[Option<f64>],
) -> (DVector<f64>, usize) {
    let mut left = standard.clone();
    let mut untold = 0;
    for (place, &j) in spread.joint.iter().enumerate() {
        match (shift[j], spread.statistics[j].as_ref()) {
            (Some(shift), Some(of)) => left[place] -= shift / of.deviation(),
            _ => untold += usize::from(told.contains(&j)),
        }
    }
    (left, untold)
}
