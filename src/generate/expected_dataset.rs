//! Expected content of a finished dataset, made again from its own `dataset.json`: for validation.

use optical_bench::settings::{Order, Transport};
use output_schema::{DatasetHead, RigWarning};

use super::{DatasetRequest, dataset_head, equipment, recipe_of, render_sample, rig_warnings};
use dataset::record::{AskedRows, DerivedSample};
use dataset::validate::{ExpectedRow, RowChoice, TakeFrame};
use dataset::{Dataset, Encoded};
use pipeline;
use recipe::Recipe;
use scanner::optics::speckle::PatternCache;

/// Rows of an image for each place at which rows are exposed again, where nobody says how many places.
const ROWS_PER_PLACE: usize = 1000;
/// Rows that are exposed again at a place: neighbours cost little, since they look at the same rows of the specimen.
const STRIP_ROWS: u64 = 8;

/// The recipe of a dataset, and the content that this program expects of it.
pub struct ExpectedDataset {
    recipe: Recipe,
    patterns: PatternCache,
    head: DatasetHead,
}

impl ExpectedDataset {
    /// For the dataset in `folder`, with its number of samples and samples per shard.
    ///
    /// # Errors
    /// As [`recipe_of`].
    pub fn of(folder: &Dataset) -> Result<Self, String> {
        Self::with_warnings(folder, rig_warnings)
    }

    /// The same with the warnings of the rig's check, which renders, from elsewhere: of recipe and seed.
    ///
    /// # Errors
    /// As [`recipe_of`].
    pub fn with_warnings(
        folder: &Dataset,
        warnings: impl FnOnce(&Recipe, u64) -> Vec<RigWarning>,
    ) -> Result<Self, String> {
        let recipe = recipe_of(folder)?;
        let found = folder.head();
        let request = DatasetRequest {
            samples: found.samples,
            seed: found.seed,
            out: folder.root().to_owned(),
            part: (0, 1),
            samples_per_shard: Some(found.samples_per_shard),
        };
        let patterns = PatternCache::new(recipe.streams(found.seed).key());
        let warnings = warnings(&recipe, found.seed);
        Ok(Self { head: dataset_head(&recipe, &request, warnings), patterns, recipe })
    }

    /// The recipe.
    pub fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// Expected `dataset.json`.
    pub fn head(&self) -> &DatasetHead {
        &self.head
    }

    /// Expected row of a sample as far as it is drawn, without rendering.
    pub fn expected(&self, index: u64) -> ExpectedRow {
        let scene = self.recipe.draw(self.head.seed, index);
        ExpectedRow {
            numbers: scene.values().into_iter().map(|(_, value)| value).collect(),
            id: scene.id,
            split: scene.split.name().into(),
            class: scene.class,
        }
    }

    /// Expected numbers and labels of a sample that need no light, and the rows `asked`; its sensor frames go to
    /// `take_frame`.
    pub fn derived(&self, index: u64, asked: &AskedRows, take_frame: TakeFrame) -> DerivedSample {
        let scene = self.recipe.draw(self.head.seed, index);
        pipeline::derived(&scene, equipment(&self.patterns), asked, take_frame)
    }

    /// How many rows and sensor frames of each sample are exposed again: at `places` and as many frames, or as many
    /// rows as cost little and all frames. `seed` says which. It is `None` where nobody asks for rows and one costs as
    /// much as thousands: by a model that answers one line at a time.
    pub fn rows(&self, places: Option<u64>, seed: u64) -> Option<RowChoice> {
        let cheap = !matches!(self.recipe.transport(), Transport::Path { .. } | Transport::Diffusion { .. });
        let usual = || cheap.then(|| (self.head.images.rows as usize).div_ceil(ROWS_PER_PLACE).max(1) as u64);
        // One forged frame among others is met by nothing but all of them.
        let frames = places.unwrap_or(u64::MAX);
        let places = places.or_else(usual)?;
        // Neighbours have nothing in common where each line, or each frame, is made by itself.
        let alone = self.recipe.transport() != Transport::Kernel || self.recipe.postprocess().order != Order::Physical;
        Some(RowChoice { places, strip: if alone { 1 } else { STRIP_ROWS }, frames, seed })
    }

    /// The sample, rendered and encoded again.
    pub fn sample(&self, index: u64) -> Encoded {
        render_sample(&self.recipe, self.head.seed, index, &self.patterns, &|_| ())
    }
}
