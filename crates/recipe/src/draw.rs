//! From recipe, seed and index to the scene of one sample; a pure function.
//!
//! Every parameter has a stream of its own, keyed by seed, index and path, so that editing one key leaves every other
//! draw as it was. The split is keyed by seed and index alone and not by the id, which changes with the recipe: two
//! recipes can then be compared sample by sample, and no sample changes sides when a recipe is edited.

use procedural::{Parameter, Stream};
use rand::RngExt;
use uuid::Uuid;

use super::distribution::pick;
use super::{Class, Plan, Recipe, Scene};
use bench::parameters::Bench;
use bench::settings::Splits;
use bench::split::Split;

/// The namespace of all sample ids; drawn once, at random.
const NAMESPACE: Uuid = Uuid::from_u128(0x7d0b_5c1e_93a4_4f6b_8e27_51c6_d20f_a938);
/// 2^64 over the golden ratio, odd: the step of the rotation that spreads classes over the indices.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

impl Recipe {
    /// The scene of sample `index` for `seed`.
    pub fn draw(&self, seed: u64, index: u64) -> Scene {
        let root = Stream::root(seed);
        let stream = root.child("sample").index(index);
        let class = self.class_of(seed, index);
        let mut value = |parameter: &'static Parameter| {
            let path = parameter.path();
            let distribution = class.overrides.get(&path).unwrap_or_else(|| &self.parameters[&path]);
            distribution.draw(parameter, stream.child(&path))
        };
        let bench = Bench::from_values(&mut value, self.settings.optics());
        let plan = Plan::from_values(self.subject, &mut value);
        Scene {
            index,
            id: Uuid::new_v5(&NAMESPACE, format!("{}/{seed}/{index}", self.hash).as_bytes()).to_string(),
            split: split(self.settings.splits(), stream.child("split")),
            class: class.name.clone(),
            stream,
            size: self.settings.size(),
            bench,
            line: self.line.clone(),
            plan,
            mesh: self.mesh.clone(),
            transport: self.settings.transport(),
            movement: self.settings.motion.kind,
            readout: self.settings.readout(),
            postprocess: self.settings.postprocess(),
            speckle_law: self.settings.speckle.law,
            extraction: self.settings.extraction(),
            output: self.settings.output(),
        }
    }

    /// The class of sample `index`: golden-ratio rotation (Weyl 1916) over the shares from an offset of the seed's own.
    ///
    /// By Denjoy and Koksma, any prefix of n samples holds each class within 2 + log_phi(n) of its share of n.
    pub fn class_of(&self, seed: u64, index: u64) -> &Class {
        let turn = Stream::root(seed).child("class").key().wrapping_add(index.wrapping_mul(GOLDEN));
        let shares: Vec<_> = self.classes.iter().map(|class| class.share).collect();
        &self.classes[pick(&shares, unit(turn))]
    }
}

impl Scene {
    /// Every drawn number with its declaration, in their order: bench, then object.
    pub fn values(&self) -> Vec<(&'static Parameter, f64)> {
        let Bench { motion, laser, camera, exposure, speckle, .. } = &self.bench;
        let bench = [motion.values(), laser.values(), camera.values(), exposure.values(), speckle.values()];
        bench.into_iter().flatten().chain(self.plan.values()).collect()
    }

    /// Every drawn number by its path, in the order of [`Self::values`].
    pub fn draws(&self) -> Vec<(String, f64)> {
        self.values().into_iter().map(|(parameter, value)| (parameter.path(), value)).collect()
    }
}

/// A split by its share.
fn split(splits: Splits, stream: Stream) -> Split {
    let shares = [splits.train, splits.validation, splits.test];
    Split::ALL[pick(&shares, stream.rng().random())]
}

/// The word as a number in [0, 1): its 53 upper bits.
fn unit(word: u64) -> f64 {
    (word >> 11) as f64 / (1u64 << 53) as f64
}
