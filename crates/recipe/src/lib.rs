//! Recipe: distributions, classes, sensor and sizes, exactly as in the YAML; and what one draw makes of it.
//!
//! `text -> tree -> walk over the tables -> Recipe -> draw -> Scene`. Every fault of a text is found at once and names
//! its line, its key and its remedy; what is left after that is in range, so nothing behind this door checks it again.

pub mod asset;
pub mod asset_source;
pub mod mesh;

mod balance;
mod built_in;
mod canonical;
mod changes;
mod class;
mod constraints;
mod controls;
mod correlation;
mod distribution;
mod draw;
mod embedded;
mod extends;
mod file_contents;
mod flat_text;
mod groups;
mod keys;
mod kinds;
mod level;
mod log_group;
mod measured_log;
mod merge;
mod picture;
mod presets;
mod reader;
mod recipe_text;
mod reference;
mod sample_work;
mod sampling;
mod schema;
mod slice_tar;
mod slices;
mod subject;
mod text_edit;
mod texture;
mod variation;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use base::{Mesh, Parameter, Stream};
use procedural::wood::Stem;

use self::constraints::RecipeObject;
use self::correlation::{Correlation, ScoreMixture};
use self::file_contents::FileContents;
use self::groups::GroupSizes;
use self::keys::settings::Settings;
use self::sampling::Sampling;
use self::variation::Variation;
use crate::asset::Asset;
use crate::asset_source::{AssetSource, KeptAsset};
use optical_bench::parameters::Bench;
use optical_bench::settings::{
    Extraction, LaserLine, LogSource, Movement, Output, Postprocess, Readout, Size, SpeckleLaw, Splits, Transport,
};
use optical_bench::split::{SampleGroups, Split};

pub use self::canonical::differences;
pub use self::changes::{Change, changed_text};
pub use self::class::SampleClass;
pub use self::constraints::of_samples::SampleNeeds;
pub use self::controls::declarations;
pub use self::distribution::Distribution;
pub use self::embedded::{BuiltInRecipe, RecipeError};
pub use self::log_group::LogBoard;
pub use self::presets::{Preset, PresetNumber, PresetSource, presets};
pub use self::recipe_text::{NewValue, as_sections, with_new_values};
pub use self::reference::{ReferencePage, reference_markdown, reference_pages};
pub use self::schema::schema;
pub use self::subject::{Plan, Subject};
pub use self::text_edit::{with_key, without_key, written_keys};
pub use self::variation::VariationCount;
pub use wood_picture::{BoardPicture, WoodVolume};
pub use yaml::{YamlFault, YamlFaults, nearest_spelling};

/// What a dataset is made from; every number in it is in range.
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    name: String,
    /// Whose random numbers it draws; the name, unless the recipe says otherwise.
    family: String,
    subject: Subject,
    settings: Settings,
    /// Every parameter's distribution by path.
    parameters: BTreeMap<String, Distribution>,
    /// By name.
    classes: Vec<SampleClass>,
    variation: Variation,
    groups: GroupSizes,
    sampling: Sampling,
    /// Pairs of keys that go together, in their order.
    correlations: Vec<Correlation>,
    /// What these do in each class.
    mixtures: Vec<ScoreMixture>,
    contents: FileContents,
    /// Keys that have no effect, and boards that show air, with what to do.
    notes: Vec<String>,
    text: String,
    /// What was read, where it extends another recipe.
    written: Option<String>,
    canonical: serde_json::Value,
    hash: String,
}

/// One draw: plain numbers, no distributions.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Sample number.
    pub index: u64,
    /// UUID v5 of (recipe hash, seed, index).
    pub id: String,
    /// Split, by the rank of the sample in its class.
    pub split: Split,
    /// Name of the class.
    pub class: String,
    /// Root of every stream of this sample.
    pub stream: Stream,
    /// Root of the streams of what belongs to a log or a batch: that of the sample, but where several have one.
    pub log_stream: Stream,
    /// Root of the streams of what belongs to the instrument, which samples may have in common.
    pub rig_stream: Stream,
    /// Which instrument, log and batch it has.
    pub groups: SampleGroups,
    /// Which board of which log it is, where logs have several.
    pub log_board: Option<LogBoard>,
    /// Sizes.
    pub size: Size,
    /// Bench.
    pub bench: Bench,
    /// What of the laser is not drawn.
    pub line: LaserLine,
    /// Object.
    pub plan: Plan,
    /// Triangles of a part, in units of its file.
    pub mesh: Option<Arc<Mesh>>,
    /// The picture that a board is cut from.
    pub picture: Option<Arc<BoardPicture>>,
    /// The stack of slices that a board is cut from.
    pub slices: Option<Arc<WoodVolume>>,
    /// Where the log of a board comes from.
    pub log: LogSource,
    /// The log that was measured.
    pub measured: Option<Arc<Stem>>,
    /// How light spreads below the surface.
    pub transport: Transport,
    /// How the object moves.
    pub movement: Movement,
    /// How the sensor is read out.
    pub readout: Readout,
    /// What is done to frames before they are read.
    pub postprocess: Postprocess,
    /// Law of speckle in a point.
    pub speckle_law: SpeckleLaw,
    /// How profiles are read.
    pub extraction: Extraction,
    /// What is written.
    pub output: Output,
}

impl Recipe {
    /// The recipe in the file `name`, or else the embedded one of that name, also as `recipes/{name}.yaml`.
    pub fn load(name: &str) -> Result<Self, RecipeError> {
        Self::load_changed(name, &[])
    }

    /// The same with `changes`, which its text has then too.
    pub fn load_changed(name: &str, changes: &[Change]) -> Result<Self, RecipeError> {
        let found = embedded::find(name, &AssetSource::Beside(PathBuf::new()))?;
        Self::parse_changed(name, &found.text, &found.files, changes)
    }

    /// The recipe that `text` writes, which can name built-in files alone; `origin` is where faults say that it comes
    /// from.
    pub fn parse(origin: &str, text: &str) -> Result<Self, RecipeError> {
        Self::parse_with(origin, text, &AssetSource::BuiltIn)
    }

    /// The same with the files that it names looked for in `files`.
    pub fn parse_with(origin: &str, text: &str, files: &AssetSource) -> Result<Self, RecipeError> {
        Self::parse_changed(origin, text, files, &[])
    }

    /// The same with `changes`, which its text has then too.
    pub fn parse_changed(
        origin: &str,
        text: &str,
        files: &AssetSource,
        changes: &[Change],
    ) -> Result<Self, RecipeError> {
        Ok(reader::read(origin, text, changes, files)?)
    }

    /// The same recipe with `changes`, and with the files that it has.
    ///
    /// # Errors
    /// Every fault of what becomes of it.
    pub fn changed(&self, changes: &[Change]) -> Result<Self, RecipeError> {
        Self::parse_changed(&self.name, &self.text, &self.kept_files(), changes)
    }

    /// The files that it names, as they were read.
    pub fn kept_files(&self) -> AssetSource {
        let kept = self.files().map(|(key, file)| KeptAsset {
            key: key.to_owned(),
            name: file.name().to_owned(),
            content: Ok(file.bytes().to_vec()),
        });
        AssetSource::Kept(kept.collect())
    }

    /// Keys that have no effect in any sample, although objects of its subject can have what they are about; each with
    /// its reason and what to do.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Name of the dataset.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Name of the recipes that draw the same random numbers for the same seed: its own, unless it says otherwise.
    pub fn family(&self) -> &str {
        &self.family
    }

    /// What the objects are.
    pub fn subject(&self) -> Subject {
        self.subject
    }

    /// Triangles of the part that the recipe names.
    pub fn mesh(&self) -> Option<&Mesh> {
        self.contents.mesh.as_deref()
    }

    /// Samples in a row that are boards of one log; 1 where each sample is alone.
    pub fn boards_per_log(&self) -> u64 {
        log_group::boards_per_log(&self.settings)
    }

    /// Sizes of the scan.
    pub fn size(&self) -> Size {
        self.settings.size()
    }

    /// How profiles are read.
    pub fn extraction(&self) -> Extraction {
        self.settings.extraction()
    }

    /// How light spreads below the surface.
    pub fn transport(&self) -> Transport {
        self.settings.transport()
    }

    /// What is done to frames before they are read.
    pub fn postprocess(&self) -> Postprocess {
        self.settings.postprocess()
    }

    /// What is written.
    pub fn output(&self) -> Output {
        self.settings.output()
    }

    /// What a sample takes on one core by a fixed rule, the same on every machine: where shards are cut follows from it
    /// [s].
    pub fn sample_seconds(&self) -> f64 {
        sample_work::core_seconds(self.subject, self.transport(), self.postprocess().order, &self.size())
    }

    /// Shares of the splits.
    pub fn splits(&self) -> Splits {
        self.settings.splits()
    }

    /// What splits part as one, where that is more than a sample: rigs, logs or batches.
    pub fn split_groups(&self) -> Option<&'static str> {
        groups::unparted(self.subject, &self.settings, self.groups)
    }

    /// Every file that it names, with the key, by key.
    pub fn files(&self) -> impl Iterator<Item = (&str, &Asset)> {
        let of_subject = keys::settings(Some(self.subject));
        let used = of_subject.filter(|setting| setting.idle(&self.settings).is_none());
        used.filter_map(|setting| Some((setting.path, (setting.asset)(&self.settings)?)))
    }

    /// The classes by name; their shares sum to 1.
    pub fn classes(&self) -> &[SampleClass] {
        &self.classes
    }

    /// The distribution of the parameter `path` (`camera.tilt_deg`) in `class`; `None` where there is no such one.
    pub fn distribution(&self, class: &str, path: &str) -> Option<&Distribution> {
        let class = self.classes.iter().find(|known| known.name == class)?;
        class.overrides.get(path).or_else(|| self.parameters.get(path))
    }

    /// Every parameter of its objects and its bench with the distribution that classes change, in the order of
    /// sections.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static Parameter, &Distribution)> {
        let of_subject = keys::parameters(Some(self.subject));
        of_subject.filter_map(|parameter| Some((parameter, self.parameters.get(&parameter.path())?)))
    }

    /// Whether the key at `path` goes with others in its draws.
    pub fn is_correlated(&self, path: &str) -> bool {
        self.mixtures.iter().any(|mixture| mixture.of(path).is_some())
    }

    /// Whether the recipe states the distribution of the key at `path`, in a class or for all; others are drawn as they
    /// vary by nature, or fixed.
    pub fn is_stated(&self, path: &str) -> bool {
        self.variation.stated.contains(path) || self.is_changed_by_class(path)
    }

    /// How many numbers vary, and why.
    pub fn variation(&self) -> VariationCount {
        self.variation.count(RecipeObject {
            subject: Some(self.subject),
            settings: &self.settings,
            contents: &self.contents,
            parameters: &self.parameters,
            classes: &self.classes,
        })
    }

    /// Whether a class has a distribution of its own for the key at `path`.
    pub fn is_changed_by_class(&self, path: &str) -> bool {
        self.classes.iter().any(|class| class.overrides.contains_key(path))
    }

    /// The same recipe with one value for some keys, each within the bounds of its distribution here, in every class.
    /// Text and hash remain those of this one, so what is drawn has its ids; it is meant for samples that nobody keeps.
    #[must_use]
    pub fn with_values<'a>(&self, values: impl IntoIterator<Item = (&'a str, f64)>) -> Self {
        let mut fixed = self.clone();
        for (path, value) in values {
            fixed.parameters.insert(path.to_owned(), Distribution::Fixed(value));
            fixed.classes.iter_mut().for_each(|class| {
                class.overrides.remove(path);
            });
        }
        fixed
    }

    /// The same recipe with the class of this name alone; for samples that nobody keeps, too.
    pub fn of_class(&self, name: &str) -> Option<Self> {
        let at = self.classes.iter().position(|class| class.name == name)?;
        let mut alone = self.clone();
        alone.classes = vec![SampleClass { share: 1.0, ..alone.classes.swap_remove(at) }];
        alone.mixtures = vec![alone.mixtures.swap_remove(at)];
        Some(alone)
    }

    /// Its text, which needs no other recipe: that which it was read from, or written out where that extends another.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The text that it was read from, with what was changed.
    pub fn written(&self) -> &str {
        self.written.as_ref().unwrap_or(&self.text)
    }

    /// Everything that the recipe means, defaults included, as JSON that is a recipe itself.
    pub fn canonical_json(&self) -> String {
        format!("{:#}\n", self.canonical)
    }

    /// The same as a JSON value.
    pub fn canonical(&self) -> serde_json::Value {
        self.canonical.clone()
    }

    /// SHA-256 of the canonical form without its blanks, in hexadecimal: comments, order and spelling leave it as it
    /// is.
    pub fn hash(&self) -> String {
        self.hash.clone()
    }
}
