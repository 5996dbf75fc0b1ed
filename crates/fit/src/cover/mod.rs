//! Whether a recipe covers real scans: where these lie among simulated ones, and which keys to widen.
//!
//! Every statistic of `summary`, of whole scans and of the pixels of each labelled class, is taken of scans that the
//! recipe draws. Real scans are placed among them by `spread`, and what lies outside is led back to keys by `screen`.
//! **Limits**: what no statistic asks about is not covered; a key is asked alone, so two keys that are both wrong
//! explain a scan together better than either; shifts are means over a few scans.

mod page;
mod result;
mod screen;
mod spread;
#[cfg(test)]
mod tests;

use base::{Class, Parameter};
use dataset::Fault;
use nalgebra::DVector;
use rayon::prelude::*;
use recipe::Recipe;
use tools::compare::ScanMaps;
use tools::compare::summary::{SummaryStatistic, summary};

use crate::observation::{RealScan, measured};
use crate::prior::{FitKey, free_keys, is_spread};
use crate::simulator::ScanSimulator;
pub use result::{Cover, CoverPlace, CoveredScan, CoveredStatistic, KeyEffect, StillStatistic, WidenedKey};
use screen::{ALL_RUNGS, FEW_RUNGS, KeyAnswer, KeyLadder, mean_shift};
use spread::{ScanSpread, SpreadLimits, StatisticSpread};

/// Numbers of a scan in the scales of their laws, in the order of their names.
pub(crate) type ScanNumbers = Vec<Option<f64>>;

/// Fewest measured pixels of a class for statistics of it.
const FEWEST_OF_CLASS: usize = 400;
/// Scans by which keys are chosen, and by which those that are chosen are asked further.
const FEW_SCANS: usize = 1;
const MORE_SCANS: usize = 4;
/// Keys that are asked further.
const CHOSEN_KEYS: usize = 12;
/// Most keys that are named.
const MOST_NAMED: usize = 6;
/// Share of a scan's squared depth that a key leaves at most, where it is named.
const MOST_LEFT: f64 = 0.9;
/// Cosine of what two keys do, in directions of unit scatter, from which they are not told apart.
const ALIKE: f64 = 0.9;
/// Width from 5 to 95 % in the scale of its law below which a statistic hardly varies: a tenth of a positive number.
const STILL: f64 = 0.1;
/// Change of a statistic over a key's inner 90 %, in deviations of simulated scans, below which the key does nothing:
/// a hundredth of the variance.
const IDLE: f64 = 0.33;
/// Scores of 5, 50 and 95 %.
const INNER_SCORES: [f64; 3] = [-1.644_853_626_951_472_2, 0.0, 1.644_853_626_951_472_2];

/// How scans are simulated.
#[derive(Debug, Clone, Copy)]
pub struct CoverOptions {
    /// Seed of all that is drawn.
    pub seed: u64,
    /// Scans of the recipe as it is.
    pub simulations: usize,
}

/// What is told meanwhile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CoverProgress {
    /// So many more scans are to be simulated, for what these words say.
    More(usize, &'static str),
    /// One more is.
    Scan,
}

/// Asks whether a recipe covers real scans; without any, what it varies.
///
/// # Errors
/// Where scans are of another geometry, or have no statistic in common with simulated ones.
pub fn cover(
    recipe: &Recipe,
    real: &[RealScan],
    options: CoverOptions,
    watch: &(dyn Fn(CoverProgress) + Sync),
) -> Result<Cover, Fault> {
    let object_alone = real.iter().any(|scan| scan.ignored.is_some());
    let frames = real.iter().any(|scan| !scan.maps.exposures.is_empty());
    let simulator = ScanSimulator::new(recipe, &[], options.seed, object_alone, frames)?;
    let geometry = simulator.geometry(0);
    real.iter().try_for_each(|scan| scan.check_geometry(geometry))?;
    let by_class = real.is_empty() || real.iter().any(|scan| scan.maps.classes.is_some());
    let simulate = |recipe: &Recipe, index: u64| {
        let mut maps = simulator.scan_of(recipe, index);
        let ignored = simulator.ignored(&maps);
        maps.classes = maps.classes.filter(|_| by_class);
        statistics(&maps, ignored.as_deref())
    };
    let asked = CoverQuestion { recipe, simulate: &simulate, names: names(&simulator), watch };
    watch(CoverProgress::More(options.simulations, "what the recipe makes"));
    let all: Vec<u64> = (0..options.simulations as u64).collect();
    let scans = asked.scans(recipe, &all);
    let mut found = Cover {
        recipe: recipe.name().to_owned(),
        seed: options.seed,
        simulations: options.simulations,
        ..Cover::default()
    };
    if real.is_empty() {
        (found.still, found.classes) = asked.still(&scans);
        (found.keys, found.held) = asked.effects(&scans);
        return Ok(found);
    }
    let mut outside = Vec::new();
    for scan in real {
        let numbers = statistics(&scan.maps, scan.ignored.as_deref());
        let place = asked.place(&scan.maps.name, &numbers, &scan.spreads, &scans)?;
        found.scans.push(place.told);
        if found.scans.last().is_some_and(CoveredScan::is_outside) {
            outside.push(place.point);
        }
    }
    if !outside.is_empty() {
        (found.widen, found.asked) = asked.widen(&scans, &outside);
    }
    Ok(found)
}

/// What is asked of a recipe.
struct CoverQuestion<'a> {
    recipe: &'a Recipe,
    /// Statistics of a scan of a recipe.
    simulate: &'a (dyn Fn(&Recipe, u64) -> ScanNumbers + Sync),
    /// Every statistic, first those of whole scans.
    names: StatisticNames,
    watch: &'a (dyn Fn(CoverProgress) + Sync),
}

/// Statistics without their numbers.
struct StatisticNames {
    list: Vec<SummaryStatistic>,
    /// How many are of whole scans.
    whole: usize,
}

/// A real scan as a point in the cloud of simulated ones.
struct ScanPoint {
    spread: ScanSpread,
    standard: DVector<f64>,
    /// Its numbers.
    numbers: ScanNumbers,
    /// Statistics that it tells.
    told: Vec<usize>,
    limits: SpreadLimits,
}

impl ScanPoint {
    /// Whether the scan lies within both limits once a key has shifted it.
    fn is_covered(&self, answer: &KeyAnswer) -> bool {
        let shifted = |(number, shift): (&Option<f64>, &Option<f64>)| Some((*number)? - (*shift)?);
        let shifted: ScanNumbers = self.numbers.iter().zip(&answer.shift).map(shifted).collect();
        answer.square <= self.limits.depth * self.limits.depth
            && self.spread.out(&shifted).into_iter().flatten().all(|out| out <= self.limits.out)
    }
}

/// A real scan's place in words, and as a point.
struct ScanPlace {
    told: CoveredScan,
    point: ScanPoint,
}

/// The classes of which pixels are asked: what surfaces show, without what lies around them.
fn classes() -> impl Iterator<Item = Class> {
    Class::ALL.into_iter().filter(|class| *class != Class::Background)
}

/// Statistics of a scan: of all that counts, then of the pixels of each class.
fn statistics(maps: &ScanMaps, ignored: Option<&[bool]>) -> ScanNumbers {
    let scaled = |list: Vec<SummaryStatistic>| list.into_iter().map(|statistic| statistic.scaled);
    let mut all: ScanNumbers = scaled(summary(maps, ignored)).collect();
    let whole = all.len();
    let labels = maps.classes.as_deref().unwrap_or_default();
    let mut counts = [0_usize; 256];
    if !labels.is_empty() {
        measured(maps, ignored).for_each(|i| counts[labels[i] as usize] += 1);
    }
    // Frames of the sensor are of whole profiles.
    let alone = ScanMaps { exposures: Vec::new(), ..maps.clone() };
    for class in classes() {
        if counts[class as usize] < FEWEST_OF_CLASS {
            all.extend(std::iter::repeat_n(None, whole));
            continue;
        }
        let other = |(i, label): (usize, &u8)| *label != class as u8 || ignored.is_some_and(|ignored| ignored[i]);
        let others: Vec<bool> = labels.iter().enumerate().map(other).collect();
        all.extend(scaled(summary(&alone, Some(&others))));
    }
    all
}

/// The names of [`statistics`].
fn names(simulator: &ScanSimulator) -> StatisticNames {
    let (maps, _) = simulator.scan(0, &[], 0);
    let list = summary(&maps, None);
    let whole = list.len();
    let of_class = |class: Class| {
        list.iter().map(move |statistic| SummaryStatistic {
            key: format!("{}.{}", class.name(), statistic.key),
            name: format!("{}: {}", class.name().replace('_', " "), statistic.name),
            ..statistic.clone()
        })
    };
    let of_classes: Vec<SummaryStatistic> = classes().flat_map(of_class).collect();
    StatisticNames { list: list.iter().cloned().chain(of_classes).collect(), whole }
}

impl CoverQuestion<'_> {
    /// Statistics of these scans of a recipe.
    fn scans(&self, recipe: &Recipe, indices: &[u64]) -> Vec<ScanNumbers> {
        let of = |index: &u64| {
            let found = (self.simulate)(recipe, *index);
            (self.watch)(CoverProgress::Scan);
            found
        };
        indices.par_iter().map(of).collect()
    }

    /// Where a real scan lies among simulated ones.
    fn place(
        &self,
        name: &str,
        numbers: &[Option<f64>],
        spreads: &[Option<f64>],
        scans: &[ScanNumbers],
    ) -> Result<ScanPlace, Fault> {
        let (list, whole) = (&self.names.list, self.names.whole);
        let asked = |j: usize| numbers[j].is_some();
        let spread = ScanSpread::new(scans, None, list, whole, &asked);
        if spread.joint.is_empty() {
            let what = "no statistic of it is one that most simulated scans tell";
            let remedy = "look at what the recipe makes (`gen preview`): it must show heights where the real scan has \
                them";
            return Err(Fault::new(name.to_owned(), what, remedy));
        }
        let limits = SpreadLimits::new(scans, list, whole, &asked);
        let standard = spread.standard(numbers);
        let depth = spread.depth(&standard);
        let out = spread.out(numbers);
        let of = |j: usize| {
            let (real_scaled, law) = (numbers[j], list[j].law);
            let of_scans: Vec<f64> = scans.iter().filter_map(|scan| scan[j]).collect();
            let simulated = spread.statistics[j].map(|spread| spread.three);
            let place = real_scaled.zip(simulated).zip(out[j]).map(|((x, [low, _, high]), out)| match () {
                () if out > limits.out => CoverPlace::Outside,
                () if out > 1.0 || x < low || x > high => CoverPlace::Edge,
                () => CoverPlace::Inside,
            });
            let below = real_scaled.filter(|_| !of_scans.is_empty()).map(|x| {
                let of_scan = |y: &f64| if *y < x { 1.0 } else { f64::from(u8::from(*y == x)) * 0.5 };
                of_scans.iter().map(of_scan).sum::<f64>() / of_scans.len() as f64
            });
            let ends = |error: f64| real_scaled.map(|x| [x - error, x + error].map(|x| law.number(x)));
            CoveredStatistic {
                key: list[j].key.clone(),
                name: list[j].name.clone(),
                unit: list[j].unit,
                simulated: simulated.map(|three| three.map(|x| law.number(x))),
                real: real_scaled.map(|x| law.number(x)),
                real_ends: spreads.get(j).copied().flatten().and_then(ends),
                below,
                out: out[j],
                place,
            }
        };
        // Of classes what the scan tells.
        let kept = (0..list.len()).filter(|&j| j < whole || numbers[j].is_some());
        let told = CoveredScan {
            name: name.to_owned(),
            statistics: kept.map(of).collect(),
            depth,
            limit: limits.depth,
            out_limit: limits.out,
            share_beyond: limits.share_beyond(depth),
        };
        let told_numbers = (0..list.len()).filter(|&j| numbers[j].is_some()).collect();
        let point = ScanPoint { spread, standard, numbers: numbers.to_vec(), told: told_numbers, limits };
        Ok(ScanPlace { told, point })
    }

    /// The keys that explain most of these scans, and how many were asked.
    fn widen(&self, scans: &[ScanNumbers], outside: &[ScanPoint]) -> (Vec<WidenedKey>, usize) {
        let near = near(scans, outside);
        let mut ladders: Vec<KeyLadder> =
            free_keys(self.recipe).map(|key| KeyLadder::new(&key, FEW_RUNGS)).filter(|l| l.rungs.len() > 1).collect();
        let asked = ladders.len();
        self.fill(scans, &mut ladders, &near[..FEW_SCANS.min(near.len())], "which keys move what is outside");
        let mut ranked = ranked(&ladders, outside);
        ranked.truncate(CHOSEN_KEYS);
        let mut chosen: Vec<KeyLadder> =
            ranked.iter().map(|(i, _)| KeyLadder::new(&ladders[*i].key, ALL_RUNGS)).collect();
        self.fill(scans, &mut chosen, &near[..MORE_SCANS.min(near.len())], "how far to widen them");
        let before: f64 = outside.iter().map(square).sum();
        let ranked: Vec<(usize, Vec<KeyAnswer>)> = self::ranked(&chosen, outside);
        let shifts: Vec<DVector<f64>> = ranked.iter().map(|(_, answers)| explained(&answers[0], &outside[0])).collect();
        let left = |answers: &[KeyAnswer]| answers.iter().map(|answer| answer.square).sum::<f64>() / before;
        let widened = |(n, (i, answers)): (usize, &(usize, Vec<KeyAnswer>))| {
            let ladder = &chosen[*i];
            let mut values: Vec<f64> = answers.iter().map(|answer| answer.value).collect();
            values.sort_by(f64::total_cmp);
            let alike = (0..ranked.len()).filter(|&other| other != n && cosine(&shifts[n], &shifts[other]) > ALIKE);
            let covers = answers.iter().zip(outside).all(|(answer, point)| point.is_covered(answer));
            WidenedKey {
                path: ladder.key.path.clone(),
                parameter: ladder.key.parameter,
                drawn: [ladder.low, ladder.high],
                values: [values[0], values[values.len() - 1]],
                left: left(answers),
                covers,
                alike: alike.map(|other| chosen[ranked[other].0].key.path.clone()).collect(),
            }
        };
        let named = ranked.iter().enumerate().filter(|(_, (_, answers))| left(answers) <= MOST_LEFT);
        (named.take(MOST_NAMED).map(widened).collect(), asked)
    }

    /// Fills ladders from these scans.
    fn fill(&self, scans: &[ScanNumbers], ladders: &mut [KeyLadder], indices: &[u64], words: &'static str) {
        let here: Vec<ScanNumbers> = indices.iter().map(|&i| scans[i as usize].clone()).collect();
        let values: usize = ladders.iter().map(|ladder| ladder.rungs.len()).sum();
        (self.watch)(CoverProgress::More(values * indices.len(), words));
        ladders.par_iter_mut().for_each(|ladder| {
            let asked = ladder.rungs.len();
            let made = ladder.fill(&|recipe| self.scans(recipe, indices), self.recipe, &here);
            // What the recipe refuses needs no scan, and what it makes anyway is there.
            (made * indices.len()..asked * indices.len()).for_each(|_| (self.watch)(CoverProgress::Scan));
        });
    }

    /// Statistics that hardly vary, and the classes that scans show.
    fn still(&self, scans: &[ScanNumbers]) -> (Vec<StillStatistic>, Vec<String>) {
        let spread = ScanSpread::new(scans, None, &self.names.list, 0, &|_| true);
        let whole = self.names.whole;
        let seen: Vec<String> = classes()
            .enumerate()
            .filter(|(n, _)| {
                let of_class = spread.statistics.get((n + 1) * whole..(n + 2) * whole);
                of_class.is_some_and(|of_class| of_class.iter().any(Option::is_some))
            })
            .map(|(_, class)| class.name().to_owned())
            .collect();
        let still = |(statistic, spread): (&SummaryStatistic, &Option<StatisticSpread>)| {
            let [low, middle, high] = spread.as_ref()?.three;
            (high - low < STILL).then(|| StillStatistic {
                key: statistic.key.clone(),
                name: statistic.name.clone(),
                unit: statistic.unit,
                three: [low, middle, high].map(|x| statistic.law.number(x)),
            })
        };
        (self.names.list.iter().zip(&spread.statistics).filter_map(still).collect(), seen)
    }

    /// What keys that are drawn do to statistics of classes, or to all where no two classes are there; and the keys
    /// that are not asked.
    fn effects(&self, scans: &[ScanNumbers]) -> (Vec<KeyEffect>, Vec<String>) {
        let spread = ScanSpread::new(scans, None, &self.names.list, 0, &|_| true);
        let whole = self.names.whole;
        let of_classes = (whole..spread.statistics.len()).filter(|&j| spread.statistics[j].is_some());
        let asked: Vec<usize> = match of_classes.clone().map(|j| j / whole).collect::<std::collections::BTreeSet<_>>() {
            classes if classes.len() > 1 => of_classes.collect(),
            _ => (0..whole).collect(),
        };
        let indices = telling(scans, &asked, MORE_SCANS);
        let drawn: Vec<_> = free_keys(self.recipe).filter(|key| is_spread(&key.prior, key.parameter)).collect();
        (self.watch)(CoverProgress::More(drawn.len() * INNER_SCORES.len() * indices.len(), "what each key does"));
        let effect = |key: &FitKey| {
            let at = INNER_SCORES
                .map(|score| self.scans(&self.recipe.with_values([(key.path.as_str(), key.value(score))]), &indices));
            let shifts = [mean_shift(&at[1], &at[0]), mean_shift(&at[2], &at[0]), mean_shift(&at[2], &at[1])];
            let moved = |&j: &usize| {
                let most = shifts.iter().filter_map(|shift| shift[j]).fold(0.0, |most: f64, x| most.max(x.abs()));
                spread.statistics[j].map(|spread| (j, most / spread.deviation()))
            };
            let most = asked.iter().filter_map(moved).max_by(|a, b| a.1.total_cmp(&b.1));
            let (statistic, by) = most.map_or((String::new(), 0.0), |(j, by)| (self.names.list[j].name.clone(), by));
            KeyEffect { path: key.path.clone(), parameter: key.parameter, statistic, by, is_idle: by < IDLE }
        };
        let mut effects: Vec<KeyEffect> = drawn.par_iter().map(effect).collect();
        effects.sort_by(|a, b| b.by.total_cmp(&a.by));
        let is_asked = |parameter: &Parameter| drawn.iter().any(|key| key.path == parameter.path());
        let spread_keys = self.recipe.parameters().filter(|(parameter, prior)| is_spread(prior, parameter));
        let held = spread_keys.filter(|(parameter, _)| !is_asked(parameter)).map(|(p, _)| p.path()).collect();
        (effects, held)
    }
}

/// Squared depth of a real scan.
fn square(point: &ScanPoint) -> f64 {
    let depth = point.spread.depth(&point.standard);
    depth * depth
}

/// Numbers of the simulated scans that are most like the real ones, nearest first.
fn near(scans: &[ScanNumbers], outside: &[ScanPoint]) -> Vec<u64> {
    let distance = |scan: &ScanNumbers| {
        let of = |point: &ScanPoint| point.spread.depth(&(point.spread.standard(scan) - &point.standard));
        outside.iter().map(of).fold(f64::INFINITY, f64::min)
    };
    let mut order: Vec<(f64, u64)> = scans.iter().map(distance).zip(0..).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.into_iter().map(|(_, index)| index).collect()
}

/// Numbers of scans that together tell these statistics: each tells most of those that none before it does.
fn telling(scans: &[ScanNumbers], asked: &[usize], most: usize) -> Vec<u64> {
    let mut times = vec![0_u32; scans.first().map_or(0, Vec::len)];
    let mut chosen: Vec<u64> = Vec::new();
    while chosen.len() < most.min(scans.len()) {
        let worth = |i: usize| {
            let told = asked.iter().filter(|&&j| scans[i][j].is_some());
            told.map(|&j| 1.0 / f64::from(1 + times[j] * times[j])).sum::<f64>()
        };
        let free = (0..scans.len()).filter(|i| !chosen.contains(&(*i as u64)));
        let best = free.map(|i| (worth(i), i)).max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let Some((_, best)) = best else { break };
        asked.iter().filter(|&&j| scans[best][j].is_some()).for_each(|&j| times[j] += 1);
        chosen.push(best as u64);
    }
    chosen
}

/// Ladders by how little they leave of the scans, with their answers for each.
fn ranked(ladders: &[KeyLadder], outside: &[ScanPoint]) -> Vec<(usize, Vec<KeyAnswer>)> {
    let answers = |(i, ladder): (usize, &KeyLadder)| {
        let of = |point: &ScanPoint| ladder.answer(&point.spread, &point.standard, &point.told);
        Some((i, outside.iter().map(of).collect::<Option<Vec<_>>>()?))
    };
    let left = |answers: &[KeyAnswer]| answers.iter().map(|answer| answer.square).sum::<f64>();
    let mut found: Vec<(usize, Vec<KeyAnswer>)> = ladders.iter().enumerate().filter_map(answers).collect();
    found.sort_by(|a, b| left(&a.1).total_cmp(&left(&b.1)));
    found
}

/// What an answer explains of a scan, in directions of unit scatter.
fn explained(answer: &KeyAnswer, point: &ScanPoint) -> DVector<f64> {
    point.spread.whitened(&(&point.standard - &answer.left))
}

fn cosine(a: &DVector<f64>, b: &DVector<f64>) -> f64 {
    let norms = a.norm() * b.norm();
    if norms > 0.0 { a.dot(b) / norms } else { 0.0 }
}
