//! Check of a recipe's rig before the first sample: whether samples will be of use at all.
//!
//! For each of the most frequent classes the first sample is looked at: how much of its object lies in the field, and in a few of
//! its profiles, rendered nearly as they will be, how much is measured and saturated. Where that falls short of what a sample is of use
//! for ([`Shortfall`]), the next samples of the class are looked at too, and a warning is given where all of them fall short: one
//! scan that is overexposed by chance is none. The result follows from recipe and seed alone.
//!
//! Neglected: classes beyond the most frequent ones; light that fills pockets, and where exactly light leaves that has crept far; and light of slow
//! models of transport, of which only the geometry is looked at. What single samples fall short in, their rows tell.

use std::cell::LazyCell;

use rayon::prelude::*;

use super::{BRIGHT_PEAK, DIM_PEAK, Facts, figure, percent};
use bench::settings::{Movement, SensorStack, Transport};
use dataset::shares::{LEAST_IN_VIEW, SampleShares, Shortfall};
use pipeline::{body, field, render_profiles, set_up};
use procedural::Class;
use recipe::{Recipe, Scene, Subject};
use scanner::extract::margin;
use scanner::optics::Sensor;
use scanner::optics::speckle::PatternCache;
use scanner::specimen::Specimen;

/// Most classes that are looked at, those of the greatest shares: the check grows one object of each and renders a few profiles.
const MAX_CLASSES: usize = 4;
/// Samples of a class that all fall short where a warning is given: of shipped recipes fewer than one sample in ten thousand
/// does, so three in a row are no chance.
const SAMPLES_OF_CLASS: usize = 3;
/// Profiles of a sample that are rendered, evenly spread over the object; each asks for some ten rows of light.
const PROFILES: usize = 2;
/// Samples among which those of a class are searched; a class that is rarer is not looked at.
const SEARCHED_SAMPLES: u64 = 10_000;

/// What is wrong with samples of a recipe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RigFault {
    /// They fall short.
    Shortfall(Shortfall),
    /// The line is wider than the window in which its centre is looked for.
    WideLine,
    /// Profiles are so far apart that an image hardly shows the object.
    FarApart,
}

impl RigFault {
    /// Every one in the order in which they are told.
    const ALL: [Self; 5] = [
        Self::Shortfall(Shortfall::ObjectOutOfView),
        Self::Shortfall(Shortfall::HardlyMeasured),
        Self::Shortfall(Shortfall::Saturated),
        Self::WideLine,
        Self::FarApart,
    ];

    /// Its code, in documents.
    pub fn code(self) -> &'static str {
        match self {
            Self::Shortfall(shortfall) => shortfall.code(),
            Self::WideLine => "wide-line",
            Self::FarApart => "profiles-far-apart",
        }
    }
}

/// What is wrong with samples of a recipe, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RigWarning {
    /// Which fault it is.
    pub fault: RigFault,
    /// What was found.
    pub what: String,
    /// What to do.
    pub remedy: String,
}

/// What is wrong with samples of a recipe and a seed, in the order of [`RigFault`].
pub fn check(recipe: &Recipe, seed: u64) -> Vec<RigWarning> {
    let tiles = patterns(recipe, seed);
    let classes = samples_of_classes(recipe, seed);
    let look = |index: u64| check_scene(&recipe.draw(seed, index), &tiles);
    let firsts: Vec<Vec<RigWarning>> = classes.par_iter().map(|(_, samples)| look(samples[0])).collect();
    // Only samples that fall short have the others of their class looked at.
    let suspects = classes.iter().zip(&firsts).filter(|(_, first)| !first.is_empty());
    let others: Vec<u64> = suspects.flat_map(|((_, samples), _)| &samples[1..]).copied().collect();
    let others: Vec<(u64, Vec<RigWarning>)> = others.into_par_iter().map(|index| (index, look(index))).collect();
    let has = |index: &u64, fault: RigFault| {
        let found = others.iter().find(|(other, _)| other == index);
        found.is_some_and(|(_, found)| found.iter().any(|warning| warning.fault == fault))
    };
    let mut warnings = Vec::new();
    for fault in RigFault::ALL {
        let own = |((name, samples), first): (&(String, Vec<u64>), &Vec<RigWarning>)| {
            let first = first.iter().find(|warning| warning.fault == fault)?;
            samples[1..].iter().all(|index| has(index, fault)).then(|| (name.clone(), samples[0], first.clone()))
        };
        let short: Vec<(String, u64, RigWarning)> = classes.iter().zip(&firsts).filter_map(own).collect();
        let Some((_, index, first)) = short.first() else { continue };
        let names: Vec<&str> = short.iter().map(|(name, ..)| name.as_str()).collect();
        let of = match names[..] {
            _ if names.len() == classes.len() => "samples".to_owned(),
            [name] => format!("samples of the class {name}"),
            _ => format!("samples of the classes {}", names.join(", ")),
        };
        let what = format!("{of} are of little use: {}, as the sample of index {index} shows", first.what);
        warnings.push(RigWarning { fault, what, remedy: first.remedy.clone() });
    }
    warnings
}

/// The most frequent classes in the order of the recipe, each with the indices of its first samples.
fn samples_of_classes(recipe: &Recipe, seed: u64) -> Vec<(String, Vec<u64>)> {
    let mut places: Vec<usize> = (0..recipe.classes().len()).collect();
    let share = |place: usize| recipe.classes()[place].share;
    places.sort_by(|&a, &b| share(b).total_cmp(&share(a)));
    places.truncate(MAX_CLASSES);
    places.sort_unstable();
    let mut classes: Vec<(String, Vec<u64>)> =
        places.into_iter().map(|place| (recipe.classes()[place].name.clone(), Vec::new())).collect();
    for index in 0..SEARCHED_SAMPLES {
        let name = &recipe.class_of(seed, index).name;
        if let Some((_, samples)) = classes.iter_mut().find(|(known, _)| known == name)
            && samples.len() < SAMPLES_OF_CLASS
        {
            samples.push(index);
        }
        if classes.iter().all(|(_, samples)| samples.len() == SAMPLES_OF_CLASS) {
            break;
        }
    }
    classes.retain(|(_, samples)| samples.len() == SAMPLES_OF_CLASS);
    classes
}

/// What one sample falls short in, as far as a few of its profiles tell.
pub fn check_sample(recipe: &Recipe, seed: u64, index: u64) -> Vec<RigWarning> {
    check_scene(&recipe.draw(seed, index), &patterns(recipe, seed))
}

/// Patterns of speckle for a look at few profiles.
fn patterns(recipe: &Recipe, seed: u64) -> PatternCache {
    PatternCache::repeating(recipe.streams(seed).key())
}

fn check_scene(scene: &Scene, tiles: &PatternCache) -> Vec<RigWarning> {
    let mut scene = scene.clone();
    // Nothing but what is measured and labelled is asked for.
    (scene.output.sensor_stack, scene.output.truth_maps) = (SensorStack::None, false);
    let (sensor, specimen) = set_up(&scene, body(&scene), tiles);
    let specimen = specimen.without_pockets();
    let [x, y] = field(&scene, &sensor, &specimen);
    let in_view = specimen.share_within(x, y);
    let profiles = profiles(&scene, &sensor, &specimen);
    let heights = ObjectHeights::of(&scene, &sensor, &specimen, &profiles);
    let shares = match scene.transport {
        Transport::Kernel => {
            let (maps, labels) = render_profiles(&scene, &sensor, &specimen, &profiles);
            SampleShares::of(&maps, &labels, scene.readout.most(), in_view)
        }
        // At most what the sensor sees is measured.
        Transport::Path { .. } | Transport::Diffusion { .. } | Transport::Thesis { .. } => {
            SampleShares { measured: heights.seen_share, saturated: 0.0, in_view }
        }
    };
    // A few profiles can pass by an object that lies in the field.
    let lies_in_field = in_view >= LEAST_IN_VIEW;
    let holds = |shortfall: &Shortfall| *shortfall != Shortfall::ObjectOutOfView || !lies_in_field;
    // They are worked out, noise and all, where there is something to tell alone.
    let facts = LazyCell::new(|| Facts::of(&scene, &sensor, f64::from(specimen.top())));
    let threshold = scene.extraction.threshold_dn / scene.readout.scale();
    let warning = |shortfall: Shortfall| {
        let (cause, remedy) = match shortfall {
            Shortfall::ObjectOutOfView => (None, out_of_view_remedy(&scene, &specimen, [x, y])),
            Shortfall::HardlyMeasured if heights.seen_share < 0.5 => (
                Some(format!(
                    "its surface lies at {} to {} mm, and every column measures {} to {} mm",
                    figure(heights.low.into()),
                    figure(heights.high.into()),
                    figure(facts.heights_mm[0]),
                    figure(facts.heights_mm[1])
                )),
                format!(
                    "raise camera.rows or camera.distance_mm or lower camera.tilt_deg; or bring the surface there by \
                     {}",
                    height_keys(&scene)
                ),
            ),
            // A frame that is white all over has no peak.
            _ if facts.peak > if shortfall == Shortfall::Saturated { 1.0 } else { BRIGHT_PEAK } => (
                Some(format!("a white surface has {} times the light of saturation", figure(facts.peak))),
                Shortfall::Saturated.remedy().to_owned(),
            ),
            Shortfall::HardlyMeasured if facts.is_wider_than_window() => {
                (Some(facts.wide_line()), facts.narrow_line_remedy())
            }
            Shortfall::HardlyMeasured if facts.usual_dn() < threshold => (
                Some(format!(
                    "clear matter peaks at {} DN, and the threshold is {} DN",
                    figure(facts.usual_dn()),
                    figure(threshold)
                )),
                "lower extraction.threshold_dn, or lengthen exposure.time_us or raise laser.power_mw".to_owned(),
            ),
            Shortfall::HardlyMeasured if facts.peak < DIM_PEAK => (
                Some(format!("a white surface peaks at {} of saturation", percent(facts.peak))),
                "lengthen exposure.time_us or raise laser.power_mw".to_owned(),
            ),
            Shortfall::HardlyMeasured | Shortfall::Saturated => (None, shortfall.remedy().to_owned()),
        };
        let cause = cause.map(|cause| format!(" ({cause})")).unwrap_or_default();
        let what = format!("{}{cause}", shares.describe(shortfall));
        RigWarning { fault: RigFault::Shortfall(shortfall), what, remedy }
    };
    let mut warnings: Vec<RigWarning> = shares.shortfalls().into_iter().filter(holds).map(warning).collect();
    let is_told = |fault: &RigFault| warnings.iter().any(|warning| warning.fault == *fault);
    let hardly_measured = is_told(&RigFault::Shortfall(Shortfall::HardlyMeasured));
    if facts.is_wider_than_window() && !hardly_measured {
        let (what, remedy) = (facts.wide_line(), facts.narrow_line_remedy());
        warnings.push(RigWarning { fault: RigFault::WideLine, what, remedy });
    }
    if let Some(what) = facts.far_apart() {
        warnings.push(RigWarning { fault: RigFault::FarApart, what, remedy: "lower motion.step_mm".to_owned() });
    }
    warnings
}

/// What is told of a sample whose object lies beside the field, and what to do.
pub(super) fn out_of_view(scene: &Scene, sensor: &Sensor, specimen: &Specimen) -> Option<String> {
    let [x, y] = field(scene, sensor, specimen);
    let shares = SampleShares { measured: 1.0, saturated: 0.0, in_view: specimen.share_within(x, y) };
    let shortfall = shares.shortfalls().into_iter().find(|shortfall| *shortfall == Shortfall::ObjectOutOfView)?;
    Some(format!("{}: {}", shares.describe(shortfall), out_of_view_remedy(scene, specimen, [x, y])))
}

/// Profiles evenly spread over what of the object lies in the scan, over the whole scan on a turntable; none where it lies beside.
fn profiles(scene: &Scene, sensor: &Sensor, specimen: &Specimen) -> Vec<usize> {
    let (low, high) = specimen.body().bounds();
    let over = |profile: &usize| {
        let on_object = (f64::from(low.y)..=f64::from(high.y)).contains(&sensor.position(*profile));
        scene.movement == Movement::Turntable || on_object
    };
    let over: Vec<usize> = (0..scene.size.profiles).filter(over).collect();
    let count = PROFILES.min(over.len());
    (0..count).map(|k| over[(2 * k + 1) * over.len() / (2 * count)]).collect()
}

/// Heights of the object's surface in some profiles, and whether the sensor sees them.
struct ObjectHeights {
    /// Lowest point [mm].
    low: f32,
    /// Highest point [mm].
    high: f32,
    /// Share of the points whose sensor row leaves room for a measurement; NaN where no column shows the object [1].
    seen_share: f64,
}

impl ObjectHeights {
    fn of(scene: &Scene, sensor: &Sensor, specimen: &Specimen, profiles: &[usize]) -> Self {
        let (rig, margin) = (sensor.camera().rig, margin(&scene.extraction) as f64);
        let (mut low, mut high, mut seen, mut all) = (f32::INFINITY, f32::NEG_INFINITY, 0u64, 0u64);
        let mut hits = Vec::new();
        for &profile in profiles {
            sensor.hits(specimen, profile, &mut hits);
            for hit in hits.iter().filter(|hit| hit.matter.class != Class::Background) {
                (low, high) = (low.min(hit.surface.z), high.max(hit.surface.z));
                let (_, row) = rig.project(hit.x.into(), 0.0, hit.surface.z.into());
                seen += u64::from(row >= margin && row < scene.size.rows as f64 - margin);
                all += 1;
            }
        }
        Self { low, high, seen_share: if all == 0 { f64::NAN } else { seen as f64 / all as f64 } }
    }
}

/// The keys that set how high the object's surface lies.
fn height_keys(scene: &Scene) -> &'static str {
    match scene.plan.subject() {
        Subject::Wood => "board.thickness_mm",
        Subject::Blister => "pocket.headroom_mm and tablet.thickness_mm",
        Subject::Sawtooth => "sawtooth.base_mm and sawtooth.depth_mm",
        Subject::Mesh => "mesh.lift_mm and mesh.unit_mm",
    }
}

/// What brings an object into the field: along the line, along the scan, or both, wherever too much of it stands out.
fn out_of_view_remedy(scene: &Scene, specimen: &Specimen, [x, y]: [[f64; 2]; 2]) -> String {
    let group = match scene.plan.subject() {
        Subject::Wood => "board",
        Subject::Blister => "pack",
        Subject::Sawtooth => "sawtooth",
        Subject::Mesh => "mesh",
    };
    let endless = [f64::MIN, f64::MAX];
    let [along_line, along_scan] = [specimen.share_within(x, endless), specimen.share_within(endless, y)];
    let beside = format!(
        "bring it under the line by {group}.offset_mm, or widen the field by scan.columns or camera.distance_mm, and the fan with \
         it by laser.fan_angle_deg or laser.fan_height_mm"
    );
    let behind =
        format!("let it begin earlier by {group}.lead_in_mm, or lengthen the scan by scan.profiles or motion.step_mm");
    let shares = format!(
        "{} of it lies within the field along the line, {} along the scan",
        percent(along_line),
        percent(along_scan)
    );
    match [along_line, along_scan].map(|share| share < LEAST_IN_VIEW) {
        [true, true] => format!("{beside}; and {behind} ({shares})"),
        _ if along_line < along_scan => beside,
        _ if along_scan < along_line => behind,
        _ => Shortfall::ObjectOutOfView.remedy().to_owned(),
    }
}
