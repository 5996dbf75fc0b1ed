//! Rounds: simulate, emulate, infer, and again nearer to the real scans.

mod findings;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use base::{Stream, normal};
use dataset::Fault;
use dataset::atomic_file::sha256;
use rand::RngExt;
use rayon::prelude::*;
use recipe::Recipe;
use serde_json::json;
use tools::compare::summary::summary;

use crate::emulator::{Emulator, ScoreRegion, Simulation};
use crate::observation::{MapGeometry, RealScan, half_spreads, measured};
use crate::posterior::{Posterior, ScoreLayout};
use crate::prior::{FitKey, MOST_SCORE};
use crate::result::Fit;
use crate::simulator::ScanSimulator;
use crate::store::{KeptScan, ScanStore};

/// Share of the scans that the first round, from the prior, takes.
const FIRST_SHARE: f64 = 0.2;
/// How much wider than the posterior a round is.
const WIDER: f64 = 1.5;
/// Share of a round that is drawn from the prior.
const PRIOR_SHARE: f64 = 0.1;
/// Scans that are simulated side by side before they are kept.
const BATCH: usize = 16;
/// Scans at the end that show what fitted recipes make.
const PREDICTIONS: usize = 48;
/// Numbers of scans of different rounds lie so far apart.
const ROUND_STEP: u64 = 1_000_000;
/// Parts into which scans are cut to check the posterior.
const FOLDS: usize = 4;
/// Most scans on which it is checked.
const MOST_CHECKED: usize = 400;
/// Posterior widths are never multiplied by more.
const MOST_WIDENING: f64 = 3.0;
/// Simulated scans whose halves are compared with those of the real ones.
const HALVED: usize = 8;
/// Parts of a real scan differ more than those of simulated ones where the square of its standard error is so many
/// times theirs.
const MORE_THAN_CHANCE: f64 = 3.0;
/// Places from which modes are searched.
const STARTS: usize = 6;

/// How a fit is done.
#[derive(Debug, Clone)]
pub struct FitOptions {
    /// Seed of all that is drawn.
    pub seed: u64,
    /// Simulated scans, all rounds together.
    pub simulations: usize,
    /// Rounds, the first among them.
    pub rounds: usize,
    /// No round begins that would not end within this time.
    pub time: Duration,
    /// Whether several scans are of one object, so that matter is common to them too.
    pub one_object: bool,
    /// Class of each real scan, where all are of one kind of matter that was scanned in several ways; else none.
    pub classes: Vec<String>,
    /// Where simulated scans are kept meanwhile.
    pub store: PathBuf,
}

/// What is told while a fit runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FitProgress {
    /// A fit of so many scans begins, of which some are kept from before.
    Begin {
        /// Scans to simulate.
        simulations: usize,
        /// Scans that an earlier run left.
        kept: usize,
    },
    /// A round begins.
    Round {
        /// Its number, from 1.
        round: usize,
        /// Rounds.
        rounds: usize,
        /// How far the nearest simulated scan lies from the real one: root mean square over statistics, in deviations
        /// of the scatter between simulated scans; `None` before the first round.
        distance: Option<f64>,
    },
    /// So many more scans are simulated.
    Scans(usize),
    /// Simulation has ended, and what fitted recipes make is looked at.
    Predicts,
}

/// Fits `keys` of a recipe to real scans.
///
/// # Errors
/// Where the scans are of another geometry or not one of each class, simulated ones have no statistic in common with
/// them, or the disk refuses.
pub fn fit(
    recipe: &Recipe,
    keys: &[FitKey],
    real: &[RealScan],
    options: &FitOptions,
    watch: &(dyn Fn(FitProgress) + Sync),
) -> Result<Fit, Fault> {
    let object_alone = real.iter().any(|scan| scan.ignored.is_some());
    let frames = real.iter().any(|scan| !scan.maps.exposures.is_empty());
    let simulator = ScanSimulator::new(recipe, keys, options.seed, object_alone, frames)?;
    let simulator = simulator.of_classes(&options.classes)?;
    if !options.classes.is_empty() && real.len() != options.classes.len() {
        let what = format!("there are {} scans and {} classes", real.len(), options.classes.len());
        return Err(Fault::new(recipe.name().to_owned(), what, "give the class of each scan, in their order"));
    }
    let geometries: Vec<MapGeometry> = (0..simulator.parts()).map(|part| simulator.geometry(part)).collect();
    real.iter().zip(geometries.iter().cycle()).try_for_each(|(scan, geometry)| scan.check_geometry(*geometry))?;
    let stream = Stream::root(options.seed).child("fit");
    let (observed, spreads, pixels) = observations(real, simulator.parts());
    let mut fitter = Fitter {
        keys,
        simulator: &simulator,
        layout: ScoreLayout::new(
            &keys.iter().map(|key| key.is_bench || options.one_object).collect::<Vec<_>>(),
            observed.len(),
        ),
        store: ScanStore::open(&options.store, &described(recipe, keys, &observed, options))?,
        observed,
        spreads,
        pixels,
        simulations: Vec::new(),
        stream,
    };
    watch(FitProgress::Begin { simulations: options.simulations + PREDICTIONS, kept: fitter.store.len() });
    let begin = Instant::now();
    let first = ((FIRST_SHARE * options.simulations as f64) as usize).clamp(1, options.simulations);
    let later = (options.simulations - first) / (options.rounds - 1).max(1);
    watch(FitProgress::Round { round: 1, rounds: options.rounds, distance: None });
    let prior = |index: u64| -> Vec<f64> {
        let mut rng = stream.child("prior").index(index).rng();
        keys.iter().map(|_| normal(&mut rng).clamp(-MOST_SCORE, MOST_SCORE)).collect()
    };
    let scores = (0..first as u64).map(prior);
    fitter.simulations = fitter.scans(0, scores, watch)?;
    // What calls for another recipe leaves nothing that another fit would trip over.
    fitter.check_common(real).inspect_err(|_| fitter.store.remove())?;
    let mut region = ScoreRegion::prior(keys.len());
    let (mut done, mut longest) = (1, begin.elapsed());
    for round in 1..options.rounds {
        // A round costs what the longest before it has cost, per scan; inference is a small part of it.
        let per_scan = longest.as_secs_f64() / if done == 1 { first } else { later }.max(1) as f64;
        if begin.elapsed().as_secs_f64() + per_scan * (later + PREDICTIONS) as f64 > options.time.as_secs_f64() {
            break;
        }
        let since = Instant::now();
        let draws = fitter.infer(&mut region, round as u64);
        watch(FitProgress::Round { round: round + 1, rounds: options.rounds, distance: fitter.distance(&region) });
        let scores = fitter.proposals(&draws, later, round as u64);
        let scans = fitter.scans(round as u64, scores, watch)?;
        fitter.simulations.extend(scans);
        (done, longest) = (done + 1, since.elapsed());
    }
    watch(FitProgress::Predicts);
    // The kernel follows the posterior once more, now that all scans are there.
    fitter.infer(&mut region, options.rounds as u64);
    let (draws, widening) = fitter.final_draws(&mut region, options.rounds as u64 + 1);
    let predictions = fitter.predict(&draws, watch)?;
    Ok(fitter.result(recipe, real, &region, InferenceOutcome { draws, widening, predictions, rounds: done, options }))
}

/// Statistics of each observation, which is of so many real scans in a row, their standard errors, and the measured
/// pixels of each scan.
type Observations = (Vec<Vec<Option<f64>>>, Vec<Vec<Option<f64>>>, Vec<Vec<usize>>);

fn observations(real: &[RealScan], parts: usize) -> Observations {
    let of = |scans: &[RealScan]| {
        let pixels = |scan: &RealScan| measured(&scan.maps, scan.ignored.as_deref()).count().max(1);
        let told = scans.iter().flat_map(|scan| scan.statistics.iter().map(|statistic| statistic.scaled)).collect();
        (told, scans.iter().flat_map(|scan| scan.spreads.clone()).collect(), scans.iter().map(pixels).collect())
    };
    real.chunks(parts).map(of).collect()
}

/// What inference ended with.
struct InferenceOutcome<'a> {
    draws: Vec<Vec<f64>>,
    widening: Vec<f64>,
    /// Scans at draws of the posterior, beside the real ones by turns.
    predictions: Vec<Simulation>,
    rounds: usize,
    options: &'a FitOptions,
}

/// A fit on its way.
struct Fitter<'a> {
    keys: &'a [FitKey],
    simulator: &'a ScanSimulator<'a>,
    layout: ScoreLayout,
    store: ScanStore,
    observed: Vec<Vec<Option<f64>>>,
    spreads: Vec<Vec<Option<f64>>>,
    /// Measured pixels of each real scan that count, `[observations][parts]`.
    pixels: Vec<Vec<usize>>,
    simulations: Vec<Simulation>,
    stream: Stream,
}

impl Fitter<'_> {
    /// A scan at each of these scores, simulated or as it was kept.
    fn scans(
        &mut self,
        round: u64,
        scores: impl IntoIterator<Item = Vec<f64>>,
        watch: &(dyn Fn(FitProgress) + Sync),
    ) -> Result<Vec<Simulation>, Fault> {
        let numbered: Vec<(u64, Vec<f64>)> = (round * ROUND_STEP..).zip(scores).collect();
        let mut scans = Vec::with_capacity(numbered.len());
        for batch in numbered.chunks(BATCH) {
            // Scans are kept in their order: behind one that is missing all are.
            let kept: Vec<_> = batch.iter().map_while(|(index, scores)| self.store.take(*index, scores)).collect();
            kept.iter().for_each(|_| watch(FitProgress::Scans(1)));
            let simulated = |(index, scores): &(u64, Vec<f64>)| {
                let statistics = self.simulator.statistics(scores, *index).into_iter().map(|s| s.scaled).collect();
                watch(FitProgress::Scans(1));
                KeptScan { index: *index, scores: scores.clone(), statistics }
            };
            let made: Vec<KeptScan> = batch[kept.len()..].par_iter().map(simulated).collect();
            self.store.keep(&made)?;
            let statistics = kept.into_iter().chain(made.into_iter().map(|scan| scan.statistics));
            let of_batch = batch.iter().zip(statistics);
            scans.extend(of_batch.map(|((_, scores), statistics)| Simulation { scores: scores.clone(), statistics }));
        }
        Ok(scans)
    }

    /// From all scans so far, with these weights.
    fn emulator(&self, weights: &[f64]) -> Emulator {
        Emulator::new(&self.simulations, weights, self.simulator.parts())
    }

    /// Refuses a real scan of which simulated ones have no statistic.
    fn check_common(&self, real: &[RealScan]) -> Result<(), Fault> {
        let known = self.emulator(&vec![1.0; self.simulations.len()]).known;
        let has_none =
            |observed: &[Option<f64>]| !observed.iter().zip(&known).any(|(value, known)| *known && value.is_some());
        let parts = self.simulator.parts();
        let Some((real, _)) = real.iter().step_by(parts).zip(&self.observed).find(|(_, observed)| has_none(observed))
        else {
            return Ok(());
        };
        let what = "no statistic of it is one that most simulated scans tell and that varies between them";
        let remedy = "look at what the recipe makes (`gen preview`): its exposure, threshold and object must show \
            heights where the real scan has \
                      them, all over the keys' distributions";
        Err(Fault::new(real.maps.name.clone(), what, remedy))
    }

    /// Root mean square distance of the nearest scan to the nearest real one, in deviations of the scatter near the
    /// region.
    fn distance(&self, region: &ScoreRegion) -> Option<f64> {
        let weights = region.weights(&self.simulations, Emulator::wanted(self.keys.len()));
        let emulator = self.emulator(&weights);
        let of = |simulation: &Simulation, observed: &[Option<f64>]| {
            let squares = squares(&emulator, &simulation.statistics, observed);
            let (sum, n) = squares.fold((0.0, 0_u32), |(sum, n), square| (sum + square, n + 1));
            (n > 0).then(|| (sum / f64::from(n)).sqrt())
        };
        let all = self.simulations.iter().flat_map(|scan| self.observed.iter().filter_map(move |real| of(scan, real)));
        all.min_by(f64::total_cmp)
    }

    /// Scores of simulated scans that are most like the real ones, for each real scan the best: places to start at.
    fn starts(&self, emulator: &Emulator, observed: &[Vec<Option<f64>>]) -> Vec<Vec<f64>> {
        let mut ranked: Vec<(f64, usize)> = self
            .simulations
            .iter()
            .enumerate()
            .map(|(n, scan)| {
                let (mut sum, mut count) = (0.0, 1.0_f64);
                for square in observed.iter().flat_map(|real| squares(emulator, &scan.statistics, real)) {
                    // One wild statistic shall not decide.
                    sum += libm::log1p(square);
                    count += 1.0;
                }
                (sum / count, n)
            })
            .collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut starts = vec![vec![0.0; self.layout.length]];
        starts.extend(ranked.iter().take(STARTS).map(|(_, n)| self.layout.repeated(&self.simulations[*n].scores)));
        starts
    }

    /// Draws from the posterior by an emulator about the region, which moves to them.
    fn infer(&self, region: &mut ScoreRegion, turn: u64) -> Vec<Vec<f64>> {
        let weights = region.weights(&self.simulations, Emulator::wanted(self.keys.len()));
        let emulator = self.emulator(&weights);
        let starts = self.starts(&emulator, &self.observed);
        // The first is the middle of the prior.
        let excess = self.excess(starts.get(1..).filter(|similar| !similar.is_empty()).unwrap_or(&starts), turn);
        let posterior = Posterior::new(&emulator, &self.layout, &self.observed, Some(&excess), &starts);
        let draws = posterior.draws(self.stream.child("draws").index(turn));
        *region = self.region(&draws);
        draws
    }

    /// Variance of each real scan's statistics that no recipe has, by its halves and those of the most similar
    /// simulated scans ([`beyond_chance`]).
    fn excess(&self, similar: &[Vec<f64>], turn: u64) -> Vec<Vec<f64>> {
        let parts = self.simulator.parts();
        let halved = |i: usize| {
            let scores = self.layout.of_scan(0, &similar[i % similar.len()]);
            let of_part = |part: usize| {
                let (maps, ignored) = self.simulator.scan(part, &scores, (700 + turn) * ROUND_STEP + i as u64);
                let whole = summary(&maps, ignored.as_deref());
                (half_spreads(&maps, ignored.as_deref(), &whole), measured(&maps, ignored.as_deref()).count())
            };
            let (spreads, pixels): (Vec<Vec<Option<f64>>>, Vec<usize>) = (0..parts).map(of_part).unzip();
            (spreads.concat(), pixels)
        };
        let simulated: Vec<(Vec<Option<f64>>, Vec<usize>)> = (0..HALVED).into_par_iter().map(halved).collect();
        let pixels = |part: usize| simulated.iter().map(|(_, of)| of[part] as f64).sum::<f64>() / HALVED as f64;
        let usual = |j: usize| {
            let told: Vec<f64> = simulated.iter().filter_map(|(spreads, _)| spreads[j]).collect();
            (!told.is_empty()).then(|| told.iter().map(|error| error * error).sum::<f64>() / told.len() as f64)
        };
        let usual: Vec<Option<f64>> = (0..self.spreads[0].len()).map(usual).collect();
        let of_scan = |(spreads, own_pixels): (&Vec<Option<f64>>, &Vec<usize>)| {
            let larger: Vec<f64> =
                own_pixels.iter().enumerate().map(|(part, own)| pixels(part) / *own as f64).collect();
            let beyond = |(j, (own, usual)): (usize, (&Option<f64>, &Option<f64>))| {
                beyond_chance(*own, usual.map(|usual| usual * larger[j * parts / spreads.len()]))
            };
            spreads.iter().zip(&usual).enumerate().map(beyond).collect()
        };
        self.spreads.iter().zip(&self.pixels).map(of_scan).collect()
    }

    /// Where the scores of single scans lie in draws.
    fn region(&self, draws: &[Vec<f64>]) -> ScoreRegion {
        let of_scans: Vec<Vec<f64>> = draws
            .iter()
            .flat_map(|draw| (0..self.layout.scans()).map(|scan| self.layout.of_scan(scan, draw)))
            .collect();
        ScoreRegion::of(of_scans.iter().map(Vec::as_slice), self.keys.len())
    }

    /// Scores for a round: draws, farther from their mean, and some of the prior.
    fn proposals(&self, draws: &[Vec<f64>], count: usize, round: u64) -> Vec<Vec<f64>> {
        let scans = self.layout.scans();
        let means: Vec<Vec<f64>> = (0..scans)
            .map(|scan| {
                let of_scan: Vec<Vec<f64>> = draws.iter().map(|draw| self.layout.of_scan(scan, draw)).collect();
                (0..self.keys.len()).map(|k| of_scan.iter().map(|u| u[k]).sum::<f64>() / of_scan.len() as f64).collect()
            })
            .collect();
        (0..count)
            .map(|i| {
                let mut rng = self.stream.child("round").index(round).index(i as u64).rng();
                if rng.random::<f64>() < PRIOR_SHARE {
                    return self.keys.iter().map(|_| normal(&mut rng).clamp(-MOST_SCORE, MOST_SCORE)).collect();
                }
                let (draw, scan) = (&draws[rng.random_range(0..draws.len())], i % scans);
                let scores = self.layout.of_scan(scan, draw);
                let wide = |(k, score): (usize, f64)| {
                    (means[scan][k] + WIDER * (score - means[scan][k])).clamp(-MOST_SCORE, MOST_SCORE)
                };
                scores.into_iter().enumerate().map(wide).collect()
            })
            .collect()
    }

    /// Draws at the end, with the widths that a check on simulated scans calls for, and the factors of these.
    fn final_draws(&self, region: &mut ScoreRegion, turn: u64) -> (Vec<Vec<f64>>, Vec<f64>) {
        let widening = self.check(region);
        let draws = self.infer(region, turn);
        let length = self.layout.length;
        let mean: Vec<f64> =
            (0..length).map(|k| draws.iter().map(|draw| draw[k]).sum::<f64>() / draws.len() as f64).collect();
        // The factor of a key holds for each of its scores.
        let mut factors = vec![1.0; length];
        for scan in 0..self.layout.scans() {
            let places: Vec<f64> = (0..length).map(|place| place as f64).collect();
            for (key, place) in self.layout.of_scan(scan, &places).into_iter().enumerate() {
                factors[place as usize] = widening[key];
            }
        }
        let wide = |draw: Vec<f64>| -> Vec<f64> {
            let place =
                |(k, score): (usize, f64)| (mean[k] + factors[k] * (score - mean[k])).clamp(-MOST_SCORE, MOST_SCORE);
            draw.into_iter().enumerate().map(place).collect()
        };
        (draws.into_iter().map(wide).collect(), widening)
    }

    /// How much wider than told the posterior must be: simulated scans that lie as the posterior does stand for the
    /// real one, by an emulator that has not seen them. The root mean square error of the scores at the mode, in their
    /// told deviations, is 1 where the posterior is right.
    fn check(&self, region: &ScoreRegion) -> Vec<f64> {
        let keys = self.keys.len();
        let weights = region.weights(&self.simulations, Emulator::wanted(keys));
        let layout = ScoreLayout::new(&vec![true; keys], 1);
        // Scans of a round are wider than the posterior; these weights leave those that lie as it does.
        let narrower = 1.0 - 1.0 / (WIDER * WIDER);
        let like = region.like(&self.simulations, narrower);
        let mut ranked: Vec<usize> = (0..like.len()).collect();
        ranked.sort_by(|&a, &b| like[b].total_cmp(&like[a]).then(a.cmp(&b)));
        ranked.truncate(MOST_CHECKED);
        let errors: Vec<(f64, Vec<f64>)> = (0..FOLDS)
            .into_par_iter()
            .flat_map(|fold| {
                let left: Vec<f64> =
                    weights.iter().enumerate().map(|(n, w)| if n % FOLDS == fold { 0.0 } else { *w }).collect();
                let emulator = self.emulator(&left);
                let of = |n: usize| {
                    let simulation = &self.simulations[n];
                    let observed = [simulation.statistics.clone()];
                    let starts = [simulation.scores.clone(), region.mean.as_slice().to_vec()];
                    let posterior = Posterior::new(&emulator, &layout, &observed, None, &starts);
                    let errors = posterior.mode.iter().zip(&simulation.scores).zip(posterior.deviations());
                    (like[n], errors.map(|((mode, score), deviation)| (mode - score) / deviation).collect())
                };
                ranked.iter().copied().filter(|n| n % FOLDS == fold).map(of).collect::<Vec<_>>()
            })
            .collect();
        let sum: f64 = errors.iter().map(|(weight, _)| weight).sum();
        (0..keys)
            .map(|k| {
                let square = errors.iter().map(|(weight, z)| weight * (z[k] * z[k]).min(16.0)).sum::<f64>();
                (square / sum.max(1e-300)).sqrt().clamp(1.0, MOST_WIDENING)
            })
            .collect()
    }

    /// Scans at draws of the posterior, beside the real ones by turns.
    fn predict(&mut self, draws: &[Vec<f64>], watch: &(dyn Fn(FitProgress) + Sync)) -> Result<Vec<Simulation>, Fault> {
        let mut rng = self.stream.child("predictions").rng();
        let scores: Vec<Vec<f64>> = (0..PREDICTIONS)
            .map(|i| self.layout.of_scan(i % self.layout.scans(), &draws[rng.random_range(0..draws.len())]))
            .collect();
        self.scans(900, scores, watch)
    }
}

/// Squared differences of the statistics that two scans tell and that scatter, over the variance of the scatter.
fn squares<'a>(
    emulator: &'a Emulator,
    ours: &'a [Option<f64>],
    real: &'a [Option<f64>],
) -> impl Iterator<Item = f64> + 'a {
    let square = |(j, (ours, real)): (usize, (&Option<f64>, &Option<f64>))| {
        let (variance, off) = (emulator.covariance[(j, j)], ours.as_ref()? - real.as_ref()?);
        (variance > 0.0).then(|| off * off / variance)
    };
    ours.iter().zip(real).enumerate().filter_map(square)
}

/// By how much the square of a statistic's standard error, from its real scan's halves, is above what is `usual` for as
/// many pixels, if by more than chance; where no simulated scan tells what is usual, all of it.
fn beyond_chance(own: Option<f64>, usual: Option<f64>) -> f64 {
    let (own, usual) = (own.map_or(0.0, |error| error * error), usual.unwrap_or(0.0));
    if own > MORE_THAN_CHANCE * usual { own - usual } else { 0.0 }
}

/// What a fit depends on; a kept scan is of use where all of it is the same.
fn described(
    recipe: &Recipe,
    keys: &[FitKey],
    observed: &[Vec<Option<f64>>],
    options: &FitOptions,
) -> serde_json::Value {
    let numbers = serde_json::to_vec(observed).unwrap_or_default();
    json!({
        "program": env!("CARGO_PKG_VERSION"),
        "recipe": recipe.hash(),
        "keys": keys.iter().map(|key| key.path.as_str()).collect::<Vec<_>>(),
        "real": sha256(&numbers),
        "seed": options.seed,
        "simulations": options.simulations,
        "rounds": options.rounds,
        "one_object": options.one_object,
        "classes": options.classes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What halves of a real scan differ by is taken for chance up to three times the square of what simulated ones do.
    #[test]
    fn more_than_chance_is_added() {
        for (own, usual, excess) in [
            (Some(2.0), Some(1.0), 3.0),
            (Some(1.7), Some(1.0), 0.0),
            (Some(0.5), Some(1.0), 0.0),
            (Some(2.0), None, 4.0),
            (None, Some(1.0), 0.0),
        ] {
            assert_eq!(beyond_chance(own, usual), excess, "{own:?} where {usual:?} is usual");
        }
    }
}
