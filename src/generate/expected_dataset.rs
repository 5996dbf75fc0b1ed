//! Expected content of a finished dataset, made again from its own `dataset.json`: for validation.

use output_schema::DatasetHead;
use procedural::Parameter;

use super::{DatasetRequest, dataset_head, recipe_of, render_sample};
use bench::split::Split;
use dataset::validate::{DeclaredLaws, ExpectedRow, ParameterLaws, UnlitRow};
use dataset::{Dataset, Encoded};
use pipeline;
use recipe::{Distribution, Recipe};
use scanner::optics::speckle::PatternCache;

/// The recipe of a dataset, and the content that this program expects of it.
pub struct ExpectedDataset {
    recipe: Recipe,
    tiles: PatternCache,
    head: DatasetHead,
}

impl ExpectedDataset {
    /// For the dataset in `folder`, with its number of samples and samples per shard.
    ///
    /// # Errors
    /// As [`recipe_of`].
    pub fn of(folder: &Dataset) -> Result<Self, String> {
        let recipe = recipe_of(folder)?;
        let found = folder.head();
        let request = DatasetRequest {
            samples: found.samples,
            seed: found.seed,
            out: folder.root().to_owned(),
            part: (0, 1),
            samples_per_shard: Some(found.samples_per_shard),
        };
        Ok(Self {
            tiles: PatternCache::new(recipe.streams(found.seed).key()),
            head: dataset_head(&recipe, &request),
            recipe,
        })
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

    /// Expected numbers and labels of a sample that need no light.
    pub fn unlit(&self, index: u64) -> UnlitRow {
        let pipeline::Unlit { record, instances, rows } =
            pipeline::unlit(&self.recipe.draw(self.head.seed, index), &self.tiles);
        let derived = record.calibration.iter().chain(&record.physics);
        UnlitRow {
            derived: derived.map(|(name, value)| ((*name).to_owned(), *value)).collect(),
            grid: [record.row_mm, record.col_mm, record.range_offset, record.range_scale],
            defects: record.defects.iter().map(|class| class.name().to_owned()).collect(),
            instances,
            rows,
        }
    }

    /// How the rows are drawn.
    pub fn declared(&self) -> DeclaredLaws {
        declared(&self.recipe, self.head.seed)
    }

    /// The sample, rendered and encoded again.
    pub fn sample(&self, index: u64) -> Encoded {
        render_sample(&self.recipe, self.head.seed, index, &self.tiles, &|_| ())
    }
}

/// How the rows of a dataset of `recipe` and `seed` are drawn.
pub fn declared(recipe: &Recipe, seed: u64) -> DeclaredLaws {
    let classes = recipe.classes();
    let parameter = |(parameter, _): (&'static Parameter, f64)| {
        let path = parameter.path();
        let mut distinct: Vec<&Distribution> = Vec::new();
        let law_of_class = classes.iter().filter_map(|class| recipe.distribution(&class.name, &path)).map(|own| {
            distinct.iter().position(|known| *known == own).unwrap_or_else(|| {
                distinct.push(own);
                distinct.len() - 1
            })
        });
        let law_of_class = law_of_class.collect();
        ParameterLaws { laws: distinct.iter().map(|own| own.law(parameter)).collect(), path, law_of_class }
    };
    let own = recipe.clone();
    let class_of = move |index: u64| {
        let class = own.class_of(seed, index);
        own.classes().iter().position(|known| known.name == class.name).unwrap_or(usize::MAX)
    };
    let splits = recipe.splits();
    DeclaredLaws {
        classes: classes.iter().map(|class| (class.name.clone(), class.share)).collect(),
        class_of: Box::new(class_of),
        splits: Split::ALL
            .iter()
            .map(|split| split.name().to_owned())
            .zip([splits.train, splits.validation, splits.test])
            .collect(),
        parameters: recipe.draw(seed, 0).values().into_iter().map(parameter).collect(),
    }
}
