//! What a finished dataset should hold, made again from its own `dataset.json`: for whoever checks it.

use output_schema::DatasetHead;

use super::{Order, head, recipe_of, sample};
use crate::optics::speckle::Tiles;
use crate::recipe::Recipe;
use crate::shard::{DatasetFolder, Encoded};
use crate::validate::Expected;

/// The recipe of a dataset, and what this program makes of it.
pub struct Again {
    recipe: Recipe,
    tiles: Tiles,
    head: DatasetHead,
}

impl Again {
    /// Of the dataset in `folder`, with its number of samples and its cuts into shards.
    ///
    /// # Errors
    /// As [`recipe_of`].
    pub fn of(folder: &DatasetFolder) -> Result<Self, String> {
        let recipe = recipe_of(folder)?;
        let found = folder.head();
        let order = Order {
            samples: found.samples,
            seed: found.seed,
            out: folder.root().to_owned(),
            part: (0, 1),
            samples_per_shard: Some(found.samples_per_shard),
        };
        Ok(Self { tiles: Tiles::new(found.seed), head: head(&recipe, &order), recipe })
    }

    /// The recipe.
    pub fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// What `dataset.json` should say.
    pub fn head(&self) -> &DatasetHead {
        &self.head
    }

    /// What the row of a sample should say, drawn without rendering.
    pub fn expected(&self, index: u64) -> Expected {
        let scene = self.recipe.draw(self.head.seed, index);
        Expected {
            numbers: scene.values().into_iter().map(|(_, value)| value).collect(),
            id: scene.id,
            split: scene.split.name().into(),
            class: scene.class,
        }
    }

    /// The sample, rendered and encoded again.
    pub fn sample(&self, index: u64) -> Encoded {
        sample(&self.recipe, self.head.seed, index, &self.tiles, &|_| ())
    }
}
