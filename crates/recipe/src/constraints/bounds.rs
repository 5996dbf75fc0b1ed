//! Bounds of the draws: the least and the most that each parameter of a class, or of the top level, can be.

use std::collections::BTreeMap;

use crate::distribution::Distribution;
use crate::keys;
use yaml::YamlReader;

/// Of what changes nothing of the top level.
pub(crate) static NO_OVERRIDES: BTreeMap<String, Distribution> = BTreeMap::new();

/// The parameters of a class, or of the top level where `prefix` is empty.
pub(crate) struct DrawBounds<'a> {
    /// Path of the class and a dot.
    pub prefix: String,
    /// The top level's distributions.
    pub base: &'a BTreeMap<String, Distribution>,
    /// The class's own in place of them.
    pub overrides: &'a BTreeMap<String, Distribution>,
}

impl DrawBounds<'_> {
    /// The distribution of the parameter at `path`.
    pub fn distribution(&self, path: &str) -> Option<&Distribution> {
        self.overrides.get(path).or_else(|| self.base.get(path))
    }

    fn bounds(&self, path: &str) -> (f64, f64) {
        let (distribution, parameter) = self
            .distribution(path)
            .zip(keys::parameter(None, path))
            .unwrap_or_else(|| panic!("no table declares {path}"));
        distribution.bounds(parameter)
    }

    /// Smallest value that a draw can have.
    pub fn least(&self, path: &str) -> f64 {
        self.bounds(path).0
    }

    /// Largest value that a draw can have.
    pub fn most(&self, path: &str) -> f64 {
        self.bounds(path).1
    }

    /// Smallest and largest value by size alone: an angle counts without its sign [least, most].
    pub fn ends(&self, path: &str) -> [f64; 2] {
        let (low, high) = self.bounds(path);
        let least = if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
        [least, low.abs().max(high.abs())]
    }

    /// Whether it is for this class to say something about `keys`: it changes one, or is the top level.
    pub fn concerned<'k>(&self, mut keys: impl Iterator<Item = &'k str>) -> bool {
        self.prefix.is_empty() || keys.any(|key| self.overrides.contains_key(key))
    }

    /// Notes a fault of `keys` together, once: at the class's key where a class changes one, else at the top level's.
    pub fn fault(&self, yaml: &mut YamlReader, keys: &[&str], problem: String, remedy: &str) {
        if self.concerned(keys.iter().copied()) {
            let own = keys.iter().map(|key| format!("{}{key}", self.prefix));
            let places: Vec<_> = own.chain(keys.iter().map(|key| (*key).to_owned())).collect();
            yaml.joint_fault(&places, problem, remedy);
        }
    }
}
