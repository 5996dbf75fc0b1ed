//! Check of a recipe's rig before the first sample: whether samples will be of use at all.
//!
//! For each of the most frequent classes the first sample is looked at: how much of its object lies in the field, and
//! how much of it laser and lens reach by rays. A few of its profiles, rendered nearly as they will be, tell how much
//! is measured and saturated. Where that falls short of what a sample is of use for ([`Shortfall`]), the next samples
//! of the class are looked at too, and a warning is given where all of them fall short: one scan that is overexposed by
//! chance is none. The result follows from recipe and seed alone.
//!
//! A new shortfall is a variant of [`Shortfall`] with limit, words and remedy. It has a column, a warning among the
//! rules of validate, a cause here, and a row of docs/guide/faults.md.
//!
//! Neglected: classes beyond the most frequent ones; light that fills pockets, and where exactly light leaves that has
//! crept far; and light of slow models of transport, of which only the geometry is looked at. What single samples fall
//! short in, their rows tell.

use std::cell::LazyCell;

use rayon::prelude::*;

use super::{BRIGHT_PEAK, DIM_PEAK, Facts, figure, percent};
use dataset::shares::{FEW_SOUND, LEAST_IN_VIEW, SampleShares, Shortfall};
use optical_bench::settings::{LineShape, Movement, SensorStack, Transport};
use pipeline::{body, field, profile_hits, render_profiles, set_up};
use recipe::{Recipe, Scene, Subject};
use scanner::extract::margin;
use scanner::optics::Sensor;
use scanner::optics::speckle::PatternCache;
use scanner::specimen::{Hit, Specimen};
use transport::kernel::Doubt;

/// Most classes that are looked at, those of the greatest shares: the check grows one object of each and renders a few
/// profiles.
const MAX_CLASSES: usize = 4;
/// Samples of a class that all fall short where a warning is given: of shipped recipes fewer than one sample in ten
/// thousand does, so three in a row are no chance.
const SAMPLES_OF_CLASS: usize = 3;
/// Profiles of a sample that are rendered, evenly spread over the object; each asks for some ten rows of light.
const PROFILES: usize = 2;
/// Profiles of a sample of which rays alone are looked at, spread alike: two can pass through the walls of two rows of
/// pockets.
const RAY_PROFILES: usize = 16;
/// Share of an object's sound pixels beyond the fan, or beyond the sensor's rows, that passes for chance and soft ends
/// [1].
const MOST_CUT: f64 = 0.02;
/// Share of the object about which the model of light may be in doubt without a word [1].
const MOST_IN_DOUBT: f64 = 0.05;
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
    /// The laser's fan ends on the object.
    FanCuts,
    /// The object reaches to heights that the sensor does not see.
    RowsCut,
    /// A number is absurd beside the others, and there is another reading of it ([`mistakes`](super::mistakes)).
    UnlikelyValue,
}

impl RigFault {
    /// Every one that a look at samples finds, in the order in which they are told.
    const ALL: [Self; 8] = [
        Self::Shortfall(Shortfall::ObjectOutOfView),
        Self::Shortfall(Shortfall::HardlyMeasured),
        Self::Shortfall(Shortfall::PartlyMeasured),
        Self::Shortfall(Shortfall::Saturated),
        Self::WideLine,
        Self::FarApart,
        Self::FanCuts,
        Self::RowsCut,
    ];

    /// Its code, in documents.
    pub fn code(self) -> &'static str {
        match self {
            Self::Shortfall(shortfall) => shortfall.name(),
            Self::WideLine => "wide-line",
            Self::FarApart => "profiles-far-apart",
            Self::FanCuts => "fan-cuts-object",
            Self::RowsCut => "rows-cut-object",
            Self::UnlikelyValue => "unlikely-value",
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
    let patterns = patterns(recipe, seed);
    let classes = samples_of_classes(recipe, seed);
    let look = |index: u64| check_scene(&recipe.draw(seed, index), &patterns);
    let firsts: Vec<Vec<RigWarning>> = classes.par_iter().map(|(_, samples)| look(samples[0])).collect();
    // Only samples that fall short have the others of their class looked at.
    let suspects = classes.iter().zip(&firsts).filter(|(_, first)| !first.is_empty());
    let others: Vec<u64> = suspects.flat_map(|((_, samples), _)| &samples[1..]).copied().collect();
    let others: Vec<(u64, Vec<RigWarning>)> = others.into_par_iter().map(|index| (index, look(index))).collect();
    let [hardly, partly] = [Shortfall::HardlyMeasured, Shortfall::PartlyMeasured].map(RigFault::Shortfall);
    // What is hardly measured is measured in part at most.
    let is =
        |warning: &RigWarning, fault: RigFault| warning.fault == fault || (warning.fault == hardly && fault == partly);
    let has = |index: &u64, fault: RigFault| {
        let found = others.iter().find(|(other, _)| other == index);
        found.is_some_and(|(_, found)| found.iter().any(|warning| is(warning, fault)))
    };
    let (mut warnings, mut hardly_measured) = (Vec::new(), Vec::new());
    for fault in RigFault::ALL {
        let own = |((name, samples), first): (&(String, Vec<u64>), &Vec<RigWarning>)| {
            if fault == partly && hardly_measured.contains(name) {
                return None;
            }
            let first = first.iter().find(|warning| is(warning, fault))?;
            samples[1..].iter().all(|index| has(index, fault)).then(|| (name.clone(), samples[0], first.clone()))
        };
        let short: Vec<(String, u64, RigWarning)> = classes.iter().zip(&firsts).filter_map(own).collect();
        if fault == hardly {
            hardly_measured = short.iter().map(|(name, ..)| name.clone()).collect();
        }
        let Some((_, index, first)) = short.first() else { continue };
        let names: Vec<&str> = short.iter().map(|(name, ..)| name.as_str()).collect();
        let of = match names[..] {
            _ if names.len() == classes.len() => "samples".to_owned(),
            [name] => format!("samples of the class {name}"),
            _ => format!("samples of the classes {}", names.join(", ")),
        };
        let are = match fault {
            RigFault::FanCuts | RigFault::RowsCut => "lack a part of the object",
            RigFault::Shortfall(_) | RigFault::WideLine | RigFault::FarApart | RigFault::UnlikelyValue => {
                "are of little use"
            }
        };
        let what = format!("{of} {are}: {}, as the sample of index {index} shows", first.what);
        warnings.push(RigWarning { fault, what, remedy: first.remedy.clone() });
    }
    warnings
}

/// The most frequent classes in the order of the recipe, each with the indices of its first samples.
pub(super) fn samples_of_classes(recipe: &Recipe, seed: u64) -> Vec<(String, Vec<u64>)> {
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

fn check_scene(scene: &Scene, patterns: &PatternCache) -> Vec<RigWarning> {
    let mut scene = scene.clone();
    // Nothing but what is measured and labelled is asked for.
    (scene.output.sensor_stack, scene.output.truth_maps) = (SensorStack::None, false);
    let transport = std::mem::replace(&mut scene.transport, Transport::Kernel);
    let (sensor, specimen) = set_up(&scene, body(&scene), patterns);
    let specimen = specimen.without_pockets();
    let [x, y] = field(&scene, &sensor, &specimen);
    let in_view = specimen.share_within(x, y);
    let rays = ObjectRays::of(&scene, &sensor, &specimen, RAY_PROFILES);
    let (shares, missed) = measured_shares((&scene, transport), &sensor, &specimen, &rays, in_view);
    let share = |cause: Cause| missed[cause as usize];
    let is_cut = |cut: Cause| share(cut) > MOST_CUT;
    let main = Cause::ALL.into_iter().max_by(|a, b| share(*a).total_cmp(&share(*b))).unwrap_or(Cause::Light);
    // A few profiles can pass by an object that lies in the field.
    let lies_in_field = in_view >= LEAST_IN_VIEW;
    let holds = |shortfall: &Shortfall| *shortfall != Shortfall::ObjectOutOfView || !lies_in_field;
    // They are worked out, noise and all, where there is something to tell alone.
    let facts = LazyCell::new(|| Facts::of(&scene, &sensor, f64::from(specimen.top())));
    let fan = || (Some(fan_end(share(Cause::Fan))), fan_remedy(&scene).to_owned());
    let rows = || beyond_rows(&facts, &rays);
    let light = |shortfall: Shortfall| match facts.peak {
        // A frame that is white all over has no peak; a fan that is too narrow makes one.
        peak if peak > BRIGHT_PEAK && is_cut(Cause::Fan) => fan(),
        _ => unmeasured_light(&facts, shortfall),
    };
    let warning = |shortfall: Shortfall| {
        let (cause, remedy) = match shortfall {
            Shortfall::ObjectOutOfView => (None, out_of_view_remedy(&scene, &specimen, [x, y])),
            Shortfall::HardlyMeasured | Shortfall::PartlyMeasured => match main {
                Cause::Fan => fan(),
                Cause::Rows => rows(),
                Cause::Unlit => (
                    Some(format!("{} of them lie in the shadow of higher parts", percent(share(main)))),
                    "raise laser.fan_height_mm, from where the laser looks down more steeply".to_owned(),
                ),
                Cause::Unseen => (
                    Some(format!("higher parts hide {} of them from the camera", percent(share(main)))),
                    "lower camera.tilt_deg".to_owned(),
                ),
                Cause::Light => light(shortfall),
            },
            Shortfall::Saturated if is_cut(Cause::Fan) => fan(),
            Shortfall::Saturated if facts.peak > 1.0 => too_bright(&facts),
            Shortfall::Saturated => (None, shortfall.remedy().to_owned()),
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
    let partly = [Shortfall::HardlyMeasured, Shortfall::PartlyMeasured].map(RigFault::Shortfall);
    let told = warnings.iter().any(|warning| partly.contains(&warning.fault));
    for (cut, fault) in [(Cause::Fan, RigFault::FanCuts), (Cause::Rows, RigFault::RowsCut)] {
        if is_cut(cut) && !(told && main == cut) {
            let (what, remedy) = if cut == Cause::Fan { fan() } else { rows() };
            warnings.push(RigWarning { fault, what: what.unwrap_or_default(), remedy });
        }
    }
    warnings
}

/// What of a sample is measured by the model `transport`, as far as a few profiles tell, and the shares of the object's
/// pixels that each [`Cause`] loses; `rays` have seen more profiles [1].
fn measured_shares(
    (scene, transport): (&Scene, Transport),
    sensor: &Sensor,
    specimen: &Specimen,
    rays: &ObjectRays,
    in_view: f64,
) -> (SampleShares, [f64; 5]) {
    let (shares, lost) = match transport {
        Transport::Kernel => {
            let profiles = profiles(scene, sensor, specimen, PROFILES);
            let (maps, labels) = render_profiles(scene, sensor, specimen, &profiles);
            let lost = ObjectRays::of(scene, sensor, specimen, PROFILES).lost(&maps.range);
            (SampleShares::of(&maps, &labels, scene.readout.most(), in_view), lost)
        }
        // At most what laser and lens reach is measured.
        Transport::Path { .. } | Transport::Diffusion { .. } | Transport::Thesis { .. } => {
            let measured = rays.shares()[Cause::Light as usize];
            (SampleShares { measured, sound: measured, saturated: 0.0, in_view }, LOST)
        }
    };
    let mut missed = rays.shares();
    missed.iter_mut().zip(lost).for_each(|(share, lost)| *share *= lost);
    // What two profiles have of walls and shadows is chance.
    let sound = if shares.sound.is_nan() { f64::NAN } else { 1.0 - missed.iter().sum::<f64>() };
    (SampleShares { sound, ..shares }, missed)
}

/// A cause, where one is known, and a remedy.
type CauseAndRemedy = (Option<String>, String);

/// Of a white surface that saturates.
fn too_bright(facts: &Facts) -> CauseAndRemedy {
    let cause = format!("a white surface has {} times the light of saturation", figure(facts.peak));
    (Some(cause), Shortfall::Saturated.remedy().to_owned())
}

/// Of an object that reaches to heights that the sensor does not see.
fn beyond_rows(facts: &Facts, rays: &ObjectRays) -> CauseAndRemedy {
    let [low, high] = facts.heights_mm.map(figure);
    let cause = format!(
        "its surface lies at {} to {} mm, and every column measures {low} to {high} mm",
        figure(rays.low.into()),
        figure(rays.high.into()),
    );
    let remedy = format!(
        "raise camera.rows or camera.distance_mm or lower camera.tilt_deg; or bring the surface there by {}",
        height_keys(facts.scene)
    );
    (Some(cause), remedy)
}

/// Why light that laser and lens let through is not measured.
fn unmeasured_light(facts: &Facts, shortfall: Shortfall) -> CauseAndRemedy {
    let threshold = facts.scene.extraction.threshold_dn / facts.scene.readout.scale();
    match facts.peak {
        peak if peak > BRIGHT_PEAK => too_bright(facts),
        _ if facts.is_wider_than_window() => (Some(facts.wide_line()), facts.narrow_line_remedy()),
        _ if facts.usual_dn() < threshold => {
            let [peak, least] = [facts.usual_dn(), threshold].map(figure);
            let remedy = "lower extraction.threshold_dn, or lengthen exposure.time_us or raise laser.power_mw";
            (Some(format!("clear matter peaks at {peak} DN, and the threshold is {least} DN")), remedy.to_owned())
        }
        peak if peak < DIM_PEAK => (
            Some(format!("a white surface peaks at {} of saturation", percent(peak))),
            "lengthen exposure.time_us or raise laser.power_mw".to_owned(),
        ),
        _ => (None, shortfall.remedy().to_owned()),
    }
}

/// What is told of a fan beyond whose ends a share of the object's pixels lies.
fn fan_end(share: f64) -> String {
    format!("the laser's fan ends on it: {} of its pixels lie beyond", percent(share))
}

/// What makes the laser reach all of an object.
fn fan_remedy(scene: &Scene) -> &'static str {
    match scene.line.shape {
        LineShape::Texture => "raise laser.texture_length_mm",
        LineShape::Gaussian | LineShape::Slit | LineShape::Point => {
            "widen the fan by laser.fan_angle_deg or laser.fan_height_mm, which spreads its light as well"
        }
    }
}

/// What is told of a sample whose object the laser's fan does not reach as a whole, and what to do.
pub(super) fn cut_by_fan(scene: &Scene, sensor: &Sensor, specimen: &Specimen) -> Option<String> {
    let share = ObjectRays::of(scene, sensor, specimen, RAY_PROFILES).shares()[Cause::Fan as usize];
    (share > MOST_CUT).then(|| format!("{}: {}", fan_end(share), fan_remedy(scene)))
}

/// What is told of a sample whose object lies beside the field, and what to do.
pub(super) fn out_of_view(scene: &Scene, sensor: &Sensor, specimen: &Specimen) -> Option<String> {
    let [x, y] = field(scene, sensor, specimen);
    let shares = SampleShares { measured: 1.0, sound: 1.0, saturated: 0.0, in_view: specimen.share_within(x, y) };
    let shortfall = shares.shortfalls().into_iter().find(|shortfall| *shortfall == Shortfall::ObjectOutOfView)?;
    Some(format!("{}: {}", shares.describe(shortfall), out_of_view_remedy(scene, specimen, [x, y])))
}

/// What is told where the model of light is in doubt about much of a sample, and what to do.
pub(super) fn light_in_doubt(scene: &Scene, sensor: &Sensor, specimen: &Specimen) -> Option<String> {
    let (mut object, mut doubtful, mut doubt) = (0u32, 0u32, None);
    for profile in profiles(scene, sensor, specimen, RAY_PROFILES) {
        for hit in profile_hits(scene, sensor, specimen, profile).into_iter().filter(|hit| !hit.is_bare()) {
            let medium = &hit.matter.medium;
            let found = match &hit.matter.film {
                Some(film) => Doubt::of_film(medium, film),
                None => Doubt::of_matter(medium, sensor.camera().sight(hit.x, hit.surface.z, 0.0).view),
            };
            object += 1;
            doubtful += u32::from(found.is_some());
            doubt = doubt.or(found);
        }
    }
    let share = f64::from(doubtful) / f64::from(object);
    let text = |doubt| {
        format!(
            "light of {} of the object is in doubt: {doubt}; compare some profiles with `gen study profile`",
            percent(share)
        )
    };
    doubt.filter(|_| share > MOST_IN_DOUBT).map(text)
}

/// At most so many profiles evenly spread over what of the object lies in the scan, over the whole scan on a turntable;
/// none where it lies beside.
fn profiles(scene: &Scene, sensor: &Sensor, specimen: &Specimen, most: usize) -> Vec<usize> {
    let (low, high) = specimen.body().bounds();
    let over = |profile: &usize| {
        let on_object = (f64::from(low.y)..=f64::from(high.y)).contains(&sensor.position(*profile));
        scene.movement == Movement::Turntable || on_object
    };
    let over: Vec<usize> = (0..scene.size.profiles).filter(over).collect();
    let count = most.min(over.len());
    (0..count).map(|k| over[(2 * k + 1) * over.len() / (2 * count)]).collect()
}

/// What keeps a pixel of the object from being measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cause {
    /// It lies beyond the ends of the laser's fan.
    Fan,
    /// Its sensor row leaves no room for a measurement.
    Rows,
    /// It lies in the laser's shadow.
    Unlit,
    /// Something hides it from the camera.
    Unseen,
    /// None of these: laser and lens reach it, and it is the light and how it is read.
    Light,
}

/// Share of the pixels that each [`Cause`] loses where no light is looked at [1].
const LOST: [f64; 5] = [1.0, 1.0, 1.0, 1.0, 0.0];

impl Cause {
    const ALL: [Self; 5] = [Self::Fan, Self::Rows, Self::Unlit, Self::Unseen, Self::Light];
}

/// A pixel of the object by rays alone.
struct ObjectPixel {
    /// Whether it shows matter without defect.
    sound: bool,
    /// What keeps it from being measured whatever the light.
    blocked: Option<Cause>,
}

/// The object in some profiles by rays alone.
struct ObjectRays {
    /// Lowest point [mm].
    low: f32,
    /// Highest point [mm].
    high: f32,
    /// The pixels of the profiles; `None` shows the background.
    pixels: Vec<Option<ObjectPixel>>,
}

impl ObjectRays {
    /// In so many profiles at most.
    fn of(scene: &Scene, sensor: &Sensor, specimen: &Specimen, most: usize) -> Self {
        let (camera, margin) = (sensor.camera(), margin(&scene.extraction) as f64);
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        let mut pixel = |hit: Hit| {
            let z = hit.surface.z;
            if hit.is_bare() {
                return None;
            }
            (low, high) = (low.min(z), high.max(z));
            let (_, row) = camera.rig.project(hit.x.into(), 0.0, z.into());
            let blocked = match () {
                () if !camera.laser.fan_reaches(hit.x, z) => Some(Cause::Fan),
                () if row < margin || row >= scene.size.rows as f64 - margin => Some(Cause::Rows),
                () if !hit.lit => Some(Cause::Unlit),
                () if !hit.seen => Some(Cause::Unseen),
                () => None,
            };
            Some(ObjectPixel { sound: hit.matter.class.is_sound(), blocked })
        };
        let profiles = profiles(scene, sensor, specimen, most);
        let hits = profiles.into_iter().flat_map(|profile| profile_hits(scene, sensor, specimen, profile));
        let pixels = hits.map(&mut pixel).collect();
        Self { low, high, pixels }
    }

    /// Pixels of sound matter, of all of the object where hardly any is sound, each with its place and with its
    /// [`Cause`] if it is not measured.
    fn own(&self) -> impl Iterator<Item = (usize, Cause)> {
        let object = || self.pixels.iter().enumerate().filter_map(|(place, pixel)| Some((place, pixel.as_ref()?)));
        let (all, sound) = (object().count(), object().filter(|(_, pixel)| pixel.sound).count());
        let few = (sound as f64) < FEW_SOUND * all as f64;
        let own = object().filter(move |(_, pixel)| few || pixel.sound);
        own.map(|(place, pixel)| (place, pixel.blocked.unwrap_or(Cause::Light))).collect::<Vec<_>>().into_iter()
    }

    /// Shares of these pixels by [`Cause`]; NaN where there are none [1].
    fn shares(&self) -> [f64; 5] {
        let mut counts = [0u64; 5];
        self.own().for_each(|(_, cause)| counts[cause as usize] += 1);
        counts.map(|count| count as f64 / counts.iter().sum::<u64>() as f64)
    }

    /// Share of the pixels of each [`Cause`] that have no `range`: some light goes beyond a fan's ends. [`LOST`] where
    /// none has the cause [1].
    fn lost(&self, range: &[f32]) -> [f64; 5] {
        let mut counts = [[0u64; 2]; 5];
        for (place, cause) in self.own() {
            let [all, lost] = &mut counts[cause as usize];
            (*all, *lost) = (*all + 1, *lost + u64::from(range[place].is_nan()));
        }
        std::array::from_fn(|cause| match counts[cause] {
            [0, _] => LOST[cause],
            [all, lost] => lost as f64 / all as f64,
        })
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
        "bring it under the line by {group}.offset_mm, or widen the field by scan.columns or camera.distance_mm, and \
            the fan with \
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
