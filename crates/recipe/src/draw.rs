//! From recipe, seed and index to the scene of one sample; a pure function.
//!
//! Every parameter has a stream of its own, keyed by seed, family, index and path, so that editing one key leaves every
//! other draw as it was. The family is that of the recipe: what another recipe draws for the same seed has nothing to
//! do with it, unless both say that they are one family. The split follows from seed, index and classes and not from
//! the id, which changes with the recipe: no sample changes sides when a recipe is edited, but where its classes are.
//!
//! Boards of one log ([`super::log_group`]) have class, split and what belongs to the log in common.
//!
//! A key is drawn in one of two ways. By itself and independently of other samples: numbers from its stream, again
//! until one lies within the bounds ([`super::Distribution::draw`]). Where it is correlated ([`super::correlation`]) or
//! the recipe asks for low discrepancy ([`super::sampling`]): the quantile of its distribution at one number u of (0,
//! 1).

use std::collections::BTreeMap;

use base::{Parameter, Stream};
use numerics::chance::{normal_below, normal_quantile};
use rand::Rng;
use uuid::Uuid;

use super::balance::{self, ClassRotation};
use super::distribution::Distribution;
use super::log_group::{self, LogBoard};
use super::sampling::{self, Sampling};
use super::{Plan, Recipe, SampleClass, Scene, keys};
use optical_bench::parameters::Bench;
use optical_bench::split::Split;

/// The namespace of all sample ids; drawn once, at random.
const NAMESPACE: Uuid = Uuid::from_u128(0x7d0b_5c1e_93a4_4f6b_8e27_51c6_d20f_a938);

impl Recipe {
    /// The scene of sample `index` for `seed`.
    pub fn draw(&self, seed: u64, index: u64) -> Scene {
        let root = self.streams(seed);
        let stream = root.child("sample").index(index);
        let rotation = self.rotation(seed);
        let boards = self.boards_per_log();
        let (log, board) = (index / boards, index % boards);
        let log_stream = if boards > 1 { root.child("log").index(log) } else { stream };
        let number = rotation.class(log);
        let (class, mixture) = (&self.classes[number], &self.mixtures[number]);
        let sequences = root.child("sequence").child(&class.name);
        let log_rank = rotation.rank(number, log);
        // Stream and rank of what a key is drawn for: the log or the board.
        let drawn_for = |path: &str| match boards > 1 && log_group::is_of_log(path) {
            true => (log_stream, log_rank),
            false => (stream, log_rank * boards + board),
        };
        let unit = |path: &str| {
            let (stream, rank) = drawn_for(path);
            match self.sampling {
                Sampling::Independent => sampling::open_unit(stream.child(path).rng().next_u64()),
                Sampling::LowDiscrepancy => sampling::point(sequences.child(path), rank),
            }
        };
        let mut value = |parameter: &'static Parameter| {
            let path = parameter.path();
            let distribution = class.overrides.get(&path).unwrap_or_else(|| &self.parameters[&path]);
            match (mixture.of(&path), self.sampling) {
                (Some(scores), _) => {
                    let mixed = scores.iter().map(|(key, weight)| weight * normal_quantile(unit(key))).sum();
                    distribution.quantile(parameter, normal_below(mixed))
                }
                (None, Sampling::LowDiscrepancy) if !matches!(distribution, Distribution::Fixed(_)) => {
                    distribution.quantile(parameter, unit(&path))
                }
                (None, _) => distribution.draw(parameter, drawn_for(&path).0.child(&path)),
            }
        };
        let bench = Bench::from_values(&mut value, self.settings.optics());
        let mut plan = Plan::from_values(self.subject, &mut value);
        if boards > 1 {
            log_group::lay(&mut plan, self.contents.measured.as_deref(), board);
        }
        Scene {
            index,
            id: Uuid::new_v5(&NAMESPACE, format!("{}/{seed}/{index}", self.hash).as_bytes()).to_string(),
            split: self.split_at(seed, &rotation, index),
            class: class.name.clone(),
            stream,
            log_stream,
            log_board: (boards > 1).then_some(LogBoard { log, board }),
            size: self.settings.size(),
            bench,
            line: self.settings.line(self.contents.texture.clone()),
            plan,
            mesh: self.contents.mesh.clone(),
            picture: self.contents.picture.clone(),
            slices: self.contents.slices.clone(),
            log: self.settings.log.source,
            measured: self.contents.measured.clone(),
            transport: self.settings.transport(),
            movement: self.settings.motion.kind,
            readout: self.settings.readout(),
            postprocess: self.settings.postprocess(),
            speckle_law: self.settings.speckle.law,
            extraction: self.settings.extraction(),
            output: self.settings.output(),
        }
    }

    /// The root of everything that is drawn for `seed`: another one for each family of recipes, so that no two families
    /// have samples in common.
    pub fn streams(&self, seed: u64) -> Stream {
        Stream::root(seed).child("family").child(&self.family)
    }

    /// What bounds cut off from distributions, by path: the share of a key's draws that lie beyond and are made again,
    /// or would be, over all classes by their shares. Only keys of which some is cut off.
    pub fn cut_off(&self) -> BTreeMap<String, f64> {
        let share = |parameter: &'static Parameter| {
            let path = parameter.path();
            let cut = |class: &SampleClass| {
                let distribution = class.overrides.get(&path).or_else(|| self.parameters.get(&path))?;
                Some(class.share * (1.0 - distribution.chance_inside(parameter)))
            };
            (path.clone(), self.classes.iter().filter_map(cut).sum::<f64>())
        };
        // Below this it is rounding, or what is cut off from any normal distribution.
        keys::parameters(Some(self.subject)).map(share).filter(|(_, cut)| *cut > 1.0e-9).collect()
    }

    /// The class of sample `index`.
    pub fn class_of(&self, seed: u64, index: u64) -> &SampleClass {
        &self.classes[self.rotation(seed).class(index / self.boards_per_log())]
    }

    /// The split of sample `index`.
    pub fn split_of(&self, seed: u64, index: u64) -> Split {
        self.split_at(seed, &self.rotation(seed), index)
    }

    /// Samples of each class among the first `samples`, in the recipe's order, by split: train, validation, test. Takes
    /// no longer for many.
    pub fn class_counts(&self, seed: u64, samples: u64) -> Vec<[u64; 3]> {
        let (rotation, boards, stream) =
            (self.rotation(seed), self.boards_per_log(), self.streams(seed).child("split"));
        let (logs, rest) = (samples / boards, samples % boards);
        let of_class = |class| {
            let (_, counts) = balance::split(self.settings.splits(), stream, class, rotation.rank(class, logs));
            counts.map(|count| count * boards)
        };
        let mut counts: Vec<[u64; 3]> = (0..self.classes.len()).map(of_class).collect();
        if rest > 0 {
            counts[rotation.class(logs)][self.split_at(seed, &rotation, samples - 1) as usize] += rest;
        }
        counts
    }

    fn split_at(&self, seed: u64, rotation: &ClassRotation, index: u64) -> Split {
        let log = index / self.boards_per_log();
        let class = rotation.class(log);
        let stream = self.streams(seed).child("split");
        balance::split(self.settings.splits(), stream, class, rotation.rank(class, log)).0
    }

    fn rotation(&self, seed: u64) -> ClassRotation {
        ClassRotation::new(self.classes.iter().map(|class| class.share), self.streams(seed).child("class"))
    }
}

impl Scene {
    /// Every drawn number with its declaration, in their order: bench, then object.
    pub fn values(&self) -> Vec<(&'static Parameter, f64)> {
        let Bench { motion, laser, camera, exposure, speckle, lamps, optics: _ } = &self.bench;
        let [motion, laser, camera] = [motion.values(), laser.values(), camera.values()];
        let bench = [motion, laser, camera, exposure.values(), speckle.values(), lamps.values()];
        bench.into_iter().flatten().chain(self.plan.values()).collect()
    }

    /// Every drawn number by its path, in the order of [`Self::values`].
    pub fn draws(&self) -> Vec<(String, f64)> {
        self.values().into_iter().map(|(parameter, value)| (parameter.path(), value)).collect()
    }
}

#[cfg(test)]
mod tests;
