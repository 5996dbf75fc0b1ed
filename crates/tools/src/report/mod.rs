//! Report of a dataset: one HTML page for people, with everything that it shows inside of it.
//!
//! ```text
//! folder ---> dataset_counts (every row, twice) ---> sheet_sample (the rows that are shown) ---> page
//! ```
//!
//! Works on what is there: of an unfinished or damaged dataset the page says what is missing. Nothing but the section
//! on time depends on anything but the folder, so that the same folder gives the same bytes. The caller provides the
//! functions that expose a sample again and measure how long that takes.

mod dataset_counts;
mod declared_distribution;
mod exposed_profile;
mod folder;
mod histogram;
mod kept_documents;
mod page;
mod page_data;
mod palette;
mod selection;
mod sheet_sample;

use std::path::Path;

use output_schema::{DatasetHead, NumberColumn};

use self::dataset_counts::RowPlace;
use self::declared_distribution::DeclaredDistribution;
use self::folder::DatasetFolder;
use self::page_data::PageData;
use self::sheet_sample::SheetSample;
use dataset::Dataset;
use recipe::Recipe;

pub use self::exposed_profile::ExposedProfile;
pub use self::page_data::RenderTiming;

/// Bytes of pictures that the contact sheet may take; more samples have smaller pictures [bytes].
const MAX_SHEET_BYTES: f64 = 7.0e6;
/// Bytes in the page of one pixel of the three maps, in base64, measured on noisy maps.
const PIXEL_BYTES: f64 = 3.3;
/// Fewest pixels of a picture.
const MIN_PICTURE_PX: f64 = 2_000.0;
/// Most pixels of a picture.
const MAX_PICTURE_PX: f64 = 120_000.0;

/// What to show.
pub struct ReportOptions<'a> {
    /// The dataset's recipe, or why it cannot be had.
    pub recipe: Result<&'a Recipe, String>,
    /// Most samples in the contact sheet.
    pub samples: u64,
    /// Most exposures.
    pub frames: usize,
    /// Exposes a sample at a place along its scan, 0 at the first profile and 1 at the last; no frames without.
    pub expose: Option<&'a (dyn Fn(u64, f64) -> ExposedProfile + Sync)>,
    /// Renders a sample as a whole; no times without.
    pub measure: Option<&'a (dyn Fn(u64) -> RenderTiming + Sync)>,
    /// Told of steps done and of all steps.
    pub watch: &'a (dyn Fn(u64, u64) + Sync),
}

/// A page and what it is about.
#[derive(Debug, Clone, PartialEq)]
pub struct DatasetPage {
    /// The page.
    pub html: String,
    /// Samples whose pictures it shows.
    pub shown: u64,
    /// What is missing of the dataset or cannot be read.
    pub troubles: u64,
    /// How much of it is damage: all but shards that are yet to be made.
    pub damage: u64,
}

/// Makes the page of the dataset in `root`; one that cannot be opened has a page that says why.
pub fn report(root: &Path, options: &ReportOptions) -> DatasetPage {
    let folder = match Dataset::open(root) {
        Ok(folder) => folder,
        Err(error) => {
            let html = page::unreadable(&root.display().to_string(), &error.to_string()).into_string();
            return DatasetPage { html, shown: 0, troubles: 1, damage: 1 };
        }
    };
    let head = folder.head();
    let mut found = DatasetFolder::look(&folder);
    let parameters: Vec<_> = match &options.recipe {
        Ok(recipe) => recipe.draw(head.seed, 0).values().into_iter().map(|(parameter, _)| parameter).collect(),
        Err(_) => Vec::new(),
    };
    let declared = |column: &NumberColumn, counts: &[u64]| {
        let parameter = parameters.iter().find(|parameter| parameter.path() == column.path())?;
        DeclaredDistribution::of(options.recipe.as_ref().ok()?, parameter, counts)
    };
    let tables = found.tables.len() as u64;
    let steps = 2 * tables + options.samples.min(head.samples) + options.frames as u64 + 1;
    let done = std::cell::Cell::new(0);
    let step = |n: u64| {
        done.set(done.get() + n);
        (options.watch)(done.get().min(steps), steps);
    };
    // The first pass counts the classes, so the second one knows which of their samples are shown.
    let (mut places, mut quotas, mut seen) = (Vec::new(), Vec::new(), vec![0; head.classes.len()]);
    let counts = dataset_counts::count(head, &mut found, &declared, &step, &mut |tally, place: RowPlace| {
        if quotas.is_empty() {
            let counts: Vec<u64> = (0..head.classes.len()).map(|class| tally.of_class(class)).collect();
            quotas = selection::quotas(&counts, options.samples);
        }
        let class = place.class;
        if selection::is_shown(seen[class], tally.of_class(class), quotas[class]) {
            places.push(place);
        }
        seen[class] += 1;
    });
    let pixels = (MAX_SHEET_BYTES / PIXEL_BYTES / places.len().max(1) as f64).clamp(MIN_PICTURE_PX, MAX_PICTURE_PX);
    let mut samples: Vec<SheetSample> = Vec::new();
    for place in places {
        let table = found.tables[place.table].clone();
        match sheet_sample::read(&folder, (&table, place.row), place.class, pixels) {
            Ok(sample) => samples.push(sample),
            Err(what) => found.trouble(table.relative, what, "`gen validate` says what is damaged"),
        }
        step(1);
    }
    samples.sort_by_key(|sample| (sample.class, sample.index));
    let exposures = exposures(&samples, head, options, &step);
    let timing = options.measure.and_then(|measure| Some(measure(samples.first()?.index)));
    step(1);
    let facts = PageData {
        root,
        head,
        folder: found,
        counts,
        samples,
        exposures,
        timing,
        recipe: &options.recipe,
        sums: folder.sums(),
    };
    DatasetPage {
        html: page::page(&facts).into_string(),
        shown: facts.samples.len() as u64,
        troubles: facts.folder.troubles.len() as u64 + facts.folder.more,
        damage: facts.folder.damage,
    }
}

/// Exposes a profile of some samples, one a class as far as they go: through the most of what is no plain surface.
fn exposures(
    samples: &[SheetSample],
    head: &DatasetHead,
    options: &ReportOptions,
    step: &dyn Fn(u64),
) -> Vec<(usize, ExposedProfile)> {
    let Some(expose) = options.expose else { return Vec::new() };
    let mut chosen: Vec<usize> = Vec::new();
    for (i, sample) in samples.iter().enumerate() {
        if chosen.last().is_none_or(|&last| samples[last].class != sample.class) {
            chosen.push(i);
        }
    }
    // Few classes have several samples each, many have every so-many-th class.
    let all: Vec<usize> = if chosen.len() >= options.frames { chosen } else { (0..samples.len()).collect() };
    let count = options.frames.min(all.len());
    let spread = (0..count).map(|j| all[(2 * j + 1) * all.len() / (2 * count)]);
    let one = |i: usize| {
        let exposure = expose(samples[i].index, through(&samples[i], head));
        step(1);
        (i, exposure)
    };
    spread.map(one).collect()
}

/// The row of labels that shows most of what is no plain surface, as a share of the scan; its middle where none does.
fn through(sample: &SheetSample, head: &DatasetHead) -> f64 {
    let plain = page::plain_classes(head);
    let count = |row: &[u8]| row.iter().filter(|class| !plain.contains(class)).count();
    let rows: Vec<usize> = sample.labels.chunks(sample.width.max(1) as usize).map(count).collect();
    let most = rows.iter().max().copied().unwrap_or(0);
    if most == 0 {
        return 0.5;
    }
    // The middle of the rows that show as much.
    let best: Vec<usize> = (0..rows.len()).filter(|&row| rows[row] == most).collect();
    (best[best.len() / 2] as f64 + 0.5) / rows.len() as f64
}
