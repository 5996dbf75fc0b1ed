//! From recipe, seed and index to the scene of one sample; a pure function.
//!
//! Every parameter has a stream of its own, keyed by seed, family, index and path, so that editing one key leaves every
//! other draw as it was. The family is that of the recipe: what another recipe draws for the same seed has nothing to
//! do with it, unless both say that they are one family. The split follows from seed, index and classes and not from
//! the id, which changes with the recipe: no sample changes sides when a recipe is edited, but where its classes are.
//!
//! What samples have in common ([`super::groups`]), numbers of an instrument, a log or a batch ([`super::level`]), is
//! drawn once for it.
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

use super::distribution::Distribution;
use super::groups::{Groups, GroupsOf};
use super::level::DrawLevel;
use super::log_group::{self, LogBoard};
use super::sampling::{self, Sampling};
use super::{Plan, Recipe, SampleClass, Scene, Subject, keys};
use optical_bench::parameters::Bench;
use optical_bench::split::{SampleGroups, Split};

/// The namespace of all sample ids; drawn once, at random.
const NAMESPACE: Uuid = Uuid::from_u128(0x7d0b_5c1e_93a4_4f6b_8e27_51c6_d20f_a938);

impl Recipe {
    /// The scene of sample `index` for `seed`.
    pub fn draw(&self, seed: u64, index: u64) -> Scene {
        let root = self.streams(seed);
        let stream = root.child("sample").index(index);
        let groups = self.groups(seed);
        let own = groups.of(index);
        let number = groups.class(index);
        let (class, mixture) = (&self.classes[number], &self.mixtures[number]);
        let is_wood = self.subject == Subject::Wood;
        let boards = self.boards_per_log();
        let lot = groups.lot(index);
        let lot_stream = match self.groups.lot {
            1 => stream,
            _ => root.child(if is_wood { "log" } else { "batch" }).index(lot),
        };
        let rig_stream = root.child("rig").index(own.rig);
        let of_class = || root.child("sequence").child(&class.name);
        // Stream, sequence and rank of what a key is drawn for.
        let drawn_for = |path: &str| match self.groups.level(path) {
            DrawLevel::Rig => (rig_stream, root.child("sequence of rigs"), own.rig),
            // Boards of a log have one class, objects of a batch have not.
            DrawLevel::Lot if is_wood => (lot_stream, of_class(), groups.rank(index)),
            DrawLevel::Lot => (lot_stream, root.child("sequence of batches"), lot),
            DrawLevel::Sample => (stream, of_class(), groups.sample_rank(index)),
        };
        let unit = |path: &str| {
            let (stream, sequence, rank) = drawn_for(path);
            match self.sampling {
                Sampling::Independent => sampling::open_unit(stream.child(path).rng().next_u64()),
                Sampling::LowDiscrepancy => sampling::point(sequence.child(path), rank),
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
            log_group::lay(&mut plan, self.contents.measured.as_deref(), index % boards);
        }
        Scene {
            index,
            id: Uuid::new_v5(&NAMESPACE, format!("{}/{seed}/{index}", self.hash).as_bytes()).to_string(),
            split: groups.split(index),
            class: class.name.clone(),
            stream,
            log_stream: lot_stream,
            rig_stream,
            groups: own,
            log_board: (boards > 1).then_some(LogBoard { log: lot, board: index % boards }),
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
        &self.classes[self.groups(seed).class(index)]
    }

    /// The split of sample `index`.
    pub fn split_of(&self, seed: u64, index: u64) -> Split {
        self.groups(seed).split(index)
    }

    /// Samples of each class among the first `samples`, in the recipe's order, by split: train, validation, test.
    pub fn class_counts(&self, seed: u64, samples: u64) -> Vec<[u64; 3]> {
        self.groups(seed).counts(samples)
    }

    /// Which instrument, log and batch sample `index` has.
    pub fn groups_of(&self, seed: u64, index: u64) -> SampleGroups {
        self.groups(seed).of(index)
    }

    fn groups(&self, seed: u64) -> Groups {
        let shares = self.classes.iter().map(|class| class.share).collect();
        let of = GroupsOf { shares, sizes: self.groups, subject: self.subject, settings: &self.settings };
        Groups::new(of, self.streams(seed))
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
