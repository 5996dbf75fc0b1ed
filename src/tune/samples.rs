//! What is dear to make again while knobs are turned: recipes that were read, objects, what was set up for a sample,
//! and the last whole scan. The newest of each is kept, a few of them.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, Mutex};

use base::Body;
use rayon::prelude::*;

use super::turns::locked;
use crate::generate::{MemoryEstimate, equipment};
use crate::preview::{self, ShownMaps};
use dataset::record::{Labels, Maps, Record};
use pipeline::{PixelRegion, cropped, render_region, render_set_up, sensor_over, specimen_under};
use recipe::asset_source::AssetSource;
use recipe::{Recipe, RecipeError, Scene};
use scanner::frame::Rig;
use scanner::optics::Sensor;
use scanner::optics::speckle::PatternCache;
use scanner::specimen::Specimen;

/// Things of each kind that are kept.
const KEPT: usize = 4;
/// Profiles of a look at a sample, each of which stands for those beside it.
const LOOK_PROFILES: usize = 64;
/// Profiles of a look that a thread makes in turn.
const LOOK_IN_TURN: usize = 8;

/// Which sample is meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct SampleName {
    /// Text of the recipe.
    pub text: String,
    /// Seed.
    pub seed: u64,
    /// Number.
    pub index: u64,
}

/// A sample under its bench.
#[derive(Debug)]
pub(super) struct SetUpSample {
    name: SampleName,
    /// As `gen preview` draws it.
    pub scene: Scene,
    /// The instrument.
    pub sensor: Sensor,
    /// The object, which other samples may share.
    pub specimen: Arc<Specimen>,
}

/// A sample whose whole scan is rendered.
#[derive(Debug)]
pub(super) struct RenderedSample {
    /// What was rendered.
    pub sample: Arc<SetUpSample>,
    /// Its maps and labels.
    pub record: Record,
    /// The same as `gen preview` shows them.
    pub shown: ShownMaps,
}

/// A few profiles of a sample over its whole length.
#[derive(Debug)]
pub(super) struct SparseLook {
    /// Numbers of the profiles.
    pub profiles: Vec<usize>,
    /// Their maps, `[profiles, columns]`.
    pub maps: Maps,
    /// What they show.
    pub labels: Labels,
}

/// What was made last.
#[derive(Debug)]
pub(super) struct SampleStore {
    origin: String,
    files: AssetSource,
    threads: usize,
    recipes: Mutex<VecDeque<(String, Arc<Recipe>)>>,
    patterns: Mutex<VecDeque<(u64, Arc<PatternCache>)>>,
    bodies: Mutex<VecDeque<(Scene, Body)>>,
    specimens: Mutex<VecDeque<(Scene, Rig, Arc<Specimen>)>>,
    set_up: Mutex<VecDeque<Arc<SetUpSample>>>,
    rendered: Mutex<Option<Arc<RenderedSample>>>,
}

/// Stops a whole scan from within: a panic of our own, which no hook tells of.
struct StoppedScan;

impl SampleStore {
    /// Of recipes whose faults come from `origin` and whose files lie in `files`.
    pub fn new(origin: String, files: AssetSource, threads: usize) -> Self {
        Self {
            origin,
            files,
            threads,
            recipes: Mutex::default(),
            patterns: Mutex::default(),
            bodies: Mutex::default(),
            specimens: Mutex::default(),
            set_up: Mutex::default(),
            rendered: Mutex::default(),
        }
    }

    /// The recipe that `text` writes.
    pub fn recipe(&self, text: &str) -> Result<Arc<Recipe>, RecipeError> {
        kept(
            &self.recipes,
            |(known, _)| known == text,
            || {
                let recipe = Recipe::parse_with(&self.origin, text, &self.files)?;
                Ok((text.to_owned(), Arc::new(recipe)))
            },
        )
        .map(|(_, recipe)| recipe)
    }

    /// A sample under its bench.
    ///
    /// # Errors
    /// Faults of its recipe, or memory that is missing, in words.
    pub fn set_up(&self, name: &SampleName) -> Result<Arc<SetUpSample>, String> {
        kept(
            &self.set_up,
            |known| known.name == *name,
            || {
                let recipe = self.recipe(&name.text).map_err(|error| error.to_string())?;
                MemoryEstimate::of_preview(&recipe, self.threads).check().map_err(|fault| fault.to_string())?;
                let scene = preview::scene(&recipe, name.seed, name.index);
                let key = recipe.streams(name.seed).key();
                let Ok((_, patterns)) = kept(
                    &self.patterns,
                    |(known, _)| *known == key,
                    || Ok::<_, String>((key, Arc::new(PatternCache::new(key)))),
                ) else {
                    return Err("there are no patterns of speckle".to_owned());
                };
                let (_, body) = kept(
                    &self.bodies,
                    |(known, _)| has_same_body(known, &scene),
                    || Ok::<_, String>((scene.clone(), pipeline::body(&scene))),
                )?;
                let sensor = sensor_over(&scene, &body, equipment(&patterns));
                let rig = sensor.camera().rig;
                let is_it = |(known, of, _): &(Scene, Rig, _)| *of == rig && has_same_specimen(known, &scene);
                let (.., specimen) = kept(&self.specimens, is_it, || {
                    let specimen = Arc::new(specimen_under(&scene, body, &sensor));
                    Ok::<_, String>((scene.clone(), rig, specimen))
                })?;
                Ok(Arc::new(SetUpSample { name: name.clone(), scene, sensor, specimen }))
            },
        )
    }

    /// The whole scan of a sample, where it was the last one to be rendered.
    pub fn rendered(&self, name: &SampleName) -> Option<Arc<RenderedSample>> {
        locked(&self.rendered).as_ref().filter(|rendered| rendered.sample.name == *name).cloned()
    }

    /// Renders the whole scan of a sample, and keeps it; `None` where it was stopped.
    pub fn render(
        &self,
        sample: &Arc<SetUpSample>,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Option<Arc<RenderedSample>> {
        if let Some(rendered) = self.rendered(&sample.name) {
            return Some(rendered);
        }
        // The last one makes room.
        *locked(&self.rendered) = None;
        let progress = |_: u64| {
            if is_stopped() {
                resume_unwind(Box::new(StoppedScan));
            }
        };
        let SetUpSample { scene, sensor, specimen, .. } = &**sample;
        let render = || render_set_up(scene, sensor, specimen, &progress);
        let record = match catch_unwind(AssertUnwindSafe(render)) {
            Ok(record) => record,
            Err(panic) if panic.is::<StoppedScan>() => return None,
            Err(panic) => resume_unwind(panic),
        };
        let shown = preview::shown_maps(scene, &record);
        let rendered = Arc::new(RenderedSample { sample: Arc::clone(sample), record, shown });
        *locked(&self.rendered) = Some(Arc::clone(&rendered));
        Some(rendered)
    }

    /// A region of a sample: out of its whole scan where that is there.
    pub fn region(
        &self,
        sample: &SetUpSample,
        region: &PixelRegion,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Option<(Maps, Labels)> {
        match self.rendered(&sample.name) {
            Some(rendered) => Some(cut(&rendered.record, region)),
            None => render_region(&sample.scene, &sample.sensor, &sample.specimen, region, is_stopped),
        }
    }
}

impl SetUpSample {
    /// A look at the sample in a fraction of the time of its scan.
    pub fn look(&self, is_stopped: &(dyn Fn() -> bool + Sync)) -> Option<SparseLook> {
        let (all, columns) = (self.scene.size.profiles, self.scene.size.columns);
        let count = LOOK_PROFILES.min(all);
        let profiles: Vec<usize> = (0..count).map(|place| (2 * place + 1) * all / (2 * count)).collect();
        let parts: Option<Vec<(Maps, Labels)>> = profiles
            .par_chunks(LOOK_IN_TURN)
            .map(|part| {
                let render = || pipeline::render_profiles(&self.scene, &self.sensor, &self.specimen, part);
                (!is_stopped()).then(render)
            })
            .collect();
        let (mut maps, mut labels) = (Maps::default(), Labels::default());
        for (part, shown) in parts? {
            maps.range.extend(part.range);
            maps.reflectance.extend(part.reflectance);
            maps.scatter.extend(part.scatter);
            maps.grey.extend(part.grey);
            labels.class.extend(shown.class);
            labels.instance.extend(shown.instance);
        }
        debug_assert_eq!(maps.range.len(), profiles.len() * columns);
        Some(SparseLook { profiles, maps, labels })
    }
}

/// A region of a whole scan.
fn cut(record: &Record, region: &PixelRegion) -> (Maps, Labels) {
    fn part<T: Copy>(map: &[T], cols: usize, PixelRegion { profiles, columns }: &PixelRegion) -> Vec<T> {
        // Without lamps there is no grey.
        let rows = map.get(profiles.start * cols..profiles.end * cols).unwrap_or_default();
        cropped(rows, cols, columns)
    }
    let cols = record.cols;
    let Maps { range, reflectance, scatter, grey } = &record.maps;
    let of = |map: &[f32]| part(map, cols, region);
    let maps = Maps { range: of(range), reflectance: of(reflectance), scatter: of(scatter), grey: of(grey) };
    let Labels { class, instance } = &record.labels;
    (maps, Labels { class: part(class, cols, region), instance: part(instance, cols, region) })
}

/// Whether the same object grows for both: of other scenes it is all the same.
fn has_same_body(a: &Scene, b: &Scene) -> bool {
    a.plan == b.plan
        && a.stream == b.stream
        && a.log_stream == b.log_stream
        && a.log == b.log
        && a.mesh == b.mesh
        && a.picture == b.picture
        && a.slices == b.slices
        && a.measured == b.measured
}

/// Whether the same body stands the same way under a camera at the same place.
fn has_same_specimen(a: &Scene, b: &Scene) -> bool {
    has_same_body(a, b)
        && a.bench.laser.fan_height_mm == b.bench.laser.fan_height_mm
        && a.bench.motion == b.bench.motion
        && a.movement == b.movement
        && a.transport == b.transport
}

/// What is kept that `is_it`, or what `make` makes, which is kept in the place of the oldest. Two that miss it at a
/// time both make it.
fn kept<T: Clone, E>(
    store: &Mutex<VecDeque<T>>,
    is_it: impl Fn(&T) -> bool,
    make: impl FnOnce() -> Result<T, E>,
) -> Result<T, E> {
    {
        let mut store = locked(store);
        if let Some(place) = store.iter().position(&is_it)
            && let Some(found) = store.remove(place)
        {
            store.push_front(found.clone());
            return Ok(found);
        }
    }
    let made = make()?;
    let mut store = locked(store);
    store.push_front(made.clone());
    store.truncate(KEPT);
    Ok(made)
}
