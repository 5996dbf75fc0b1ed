//! Simulated scans: values of keys in, statistics of a scan out. Where real scans are of a class of the recipe each, a
//! simulated scan is one of each of them, of a place of its own: its parts.

use base::Class;
use dataset::Fault;
use dataset::record::{Record, StackFrame};
use optical_bench::settings::{RangeForm, SensorStack, Transport};
use recipe::Recipe;
use scanner::optics::speckle::PatternCache;
use tools::compare::summary::{SummaryStatistic, summary};
use tools::compare::{RangeUnit, ScanMaps, SensorFrame, to_eight_bits};

use crate::observation::MapGeometry;
use crate::prior::FitKey;

/// Sets of speckle patterns. Samples of a dataset share one set, which a real scan does not: with one set alone what is
/// common to a column, or the noise of Scatter, would scatter up to two times too little from scan to scan.
const PATTERN_SETS: u64 = 12;

/// Makes scans of a recipe with some keys held.
#[derive(Debug)]
pub(crate) struct ScanSimulator<'a> {
    recipe: &'a Recipe,
    /// The recipe of each part.
    parts: Vec<Recipe>,
    keys: &'a [FitKey],
    seed: u64,
    patterns: Vec<PatternCache>,
    /// Whether only the object counts, not what lies around it.
    object_alone: bool,
    /// Whether frames of the sensor are wanted.
    frames: bool,
}

impl<'a> ScanSimulator<'a> {
    /// Of a recipe.
    ///
    /// # Errors
    /// Where a scan takes too long for a fit.
    pub fn new(
        recipe: &'a Recipe,
        keys: &'a [FitKey],
        seed: u64,
        object_alone: bool,
        frames: bool,
    ) -> Result<Self, Fault> {
        if recipe.transport() != Transport::Kernel {
            let remedy = "set `transport: kernel`: thousands of scans are needed";
            return Err(Fault::new(recipe.name().to_owned(), "its model of light is slow".to_owned(), remedy));
        }
        let patterns = recipe.streams(seed).child("patterns");
        let patterns = (0..PATTERN_SETS).map(|set| PatternCache::keeping_one(patterns.index(set).key())).collect();
        Ok(Self { recipe, parts: vec![recipe.clone()], keys, seed, patterns, object_alone, frames })
    }

    /// With a part of each of these classes, unless there are none.
    ///
    /// # Errors
    /// Where the recipe has no such class.
    pub fn of_classes(mut self, classes: &[String]) -> Result<Self, Fault> {
        let known = || self.recipe.classes().iter().map(|class| class.name.as_str());
        let part = |name: &String| {
            let remedy = || format!("give some of its classes: {}", known().collect::<Vec<_>>().join(", "));
            let none = || Fault::new(self.recipe.name().to_owned(), format!("it has no class `{name}`"), remedy());
            self.recipe.of_class(name).ok_or_else(none)
        };
        let parts = classes.iter().map(part).collect::<Result<Vec<_>, Fault>>()?;
        if !parts.is_empty() {
            self.parts = parts;
        }
        Ok(self)
    }

    /// Parts of a scan.
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// A part of simulated scan `index` at these scores: all that is not fitted is drawn anew for each index and part.
    /// What a class gives a value of its own keeps that.
    pub fn scan(&self, part: usize, scores: &[f64], index: u64) -> (ScanMaps, Option<Vec<bool>>) {
        let recipe = &self.parts[part];
        let open = self.keys.iter().zip(scores).filter(|(key, _)| !recipe.is_changed_by_class(&key.path));
        let values: Vec<(&str, f64)> = open.map(|(key, &score)| (key.path.as_str(), key.value(score))).collect();
        let maps = self.scan_of(&recipe.with_values(values), index * self.parts.len() as u64 + part as u64);
        let ignored = self.ignored(&maps);
        (maps, ignored)
    }

    /// Pixels of one of its scans that don't count; `None` where all do.
    pub fn ignored(&self, maps: &ScanMaps) -> Option<Vec<bool>> {
        let is_background = |class: &u8| *class == Class::Background as u8;
        self.object_alone.then(|| maps.classes.iter().flatten().map(is_background).collect())
    }

    /// Scan `index` of a recipe whose keys hold what they hold.
    pub fn scan_of(&self, recipe: &Recipe, index: u64) -> ScanMaps {
        let mut scene = recipe.draw(self.seed, index);
        scene.output.truth_maps = false;
        if !self.frames {
            scene.output.sensor_stack = SensorStack::None;
        }
        let record = pipeline::render(&scene, &self.patterns[(index % PATTERN_SETS) as usize], &|_| ());
        scan_maps(record, self.recipe.size().columns, self.recipe.output().bits)
    }

    /// The statistics of all parts.
    pub fn statistics(&self, scores: &[f64], index: u64) -> Vec<SummaryStatistic> {
        let of_part = |part: usize| {
            let (maps, ignored) = self.scan(part, scores, index);
            summary(&maps, ignored.as_deref())
        };
        (0..self.parts.len()).flat_map(of_part).collect()
    }

    /// The geometry of scans of a part, from the middle of what is believed beforehand.
    pub fn geometry(&self, part: usize) -> MapGeometry {
        let (maps, _) = self.scan(part, &vec![0.0; self.keys.len()], 0);
        MapGeometry {
            pitch_mm: [maps.col_mm, maps.row_mm].map(|mm| mm.unwrap_or(f64::NAN)),
            is_uncalibrated: maps.unit != RangeUnit::Mm,
        }
    }
}

/// A simulated scan in the form of real ones.
fn scan_maps(record: Record, sensor_cols: usize, bits: u32) -> ScanMaps {
    let scale = to_eight_bits(u64::from(bits));
    let eight = |map: Vec<f32>| if scale == 1.0 { map } else { map.into_iter().map(|dn| dn * scale).collect() };
    let frame = |StackFrame { profile, dn }: StackFrame| SensorFrame {
        cols: sensor_cols,
        profile: Some(profile as usize),
        dn: dn.into_iter().map(|dn| (f32::from(dn) * scale).round() as u8).collect(),
    };
    ScanMaps {
        name: format!("simulated scan {}", record.index),
        cols: record.cols,
        rows: record.rows,
        col_mm: Some(record.col_mm),
        row_mm: Some(record.row_mm),
        unit: match record.range {
            RangeForm::Uncalibrated => RangeUnit::Px { sensor_rows: record.sensor_rows as u32 },
            _ => RangeUnit::Mm,
        },
        exposures: record.stack.iter().cloned().map(frame).collect(),
        range: record.maps.range.iter().map(|&z| f64::from(z)).collect(),
        reflectance: Some(eight(record.maps.reflectance)),
        scatter: Some(eight(record.maps.scatter)),
        classes: Some(record.labels.class),
        ..ScanMaps::default()
    }
}
