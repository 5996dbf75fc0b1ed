//! Constraints: what keys must mean together, once each is in its own range.

pub(super) mod bounds;
mod camera;
mod lamps;
mod laser;
mod motion;
pub(super) mod needs;
mod object;
pub(super) mod of_samples;
mod picture;
mod postprocess;
mod slices;
pub(super) mod transport;

use std::collections::BTreeMap;

use self::bounds::{DrawBounds, NO_OVERRIDES};
use super::class::SampleClass;
use super::distribution::Distribution;
use super::file_contents::FileContents;
use super::keys::settings::Settings;
use super::log_group;
use super::subject::Subject;
use optical_bench::settings::{ScatterMode, SensorStack};
use yaml::{YamlReader, number_text};

/// Rows of the camera's window on one side of the peak and the peak itself [px]; 31 in all.
const HALF_WINDOW: usize = 16;
/// Most pixels of an unbinned image, 12 times the thesis' scan [px].
const MAX_PIXELS: usize = 1 << 27;
/// Most rows that the camera sums [px].
const MAX_SUMMED_ROWS: usize = 29;
/// Most pixels of sensor frames that one sample may keep: they are in memory, 2 bytes each, until it is written [px].
const MAX_FRAME_PIXELS: usize = 2 << 30;
/// Slack of a sum that should be 1.
const SUM_SLACK: f64 = 1e-9;
/// Variance of rounding to whole digital numbers [DN^2].
const ROUNDING: f64 = 1.0 / 12.0;

/// What the objects of a recipe are, as far as it is known.
#[derive(Debug, Clone, Copy)]
pub(super) struct RecipeObject<'a> {
    pub subject: Option<Subject>,
    pub settings: &'a Settings,
    /// What the files say that it names.
    pub contents: &'a FileContents,
    /// The top level's distributions by path.
    pub parameters: &'a BTreeMap<String, Distribution>,
    pub classes: &'a [SampleClass],
}

impl<'a> RecipeObject<'a> {
    /// The parameters of the top level, then of each class.
    fn scenes(&self) -> Vec<DrawBounds<'a>> {
        let scene = |prefix, overrides| DrawBounds { prefix, base: self.parameters, overrides };
        let of_class = |class: &'a SampleClass| scene(format!("classes.{}.", class.name), &class.overrides);
        [scene(String::new(), &NO_OVERRIDES)].into_iter().chain(self.classes.iter().map(of_class)).collect()
    }
}

/// Notes whatever the keys of a recipe cannot mean together: the settings, the top level and each class.
pub(super) fn check(yaml: &mut YamlReader, object: RecipeObject) {
    settings(yaml, object.subject, object.settings);
    let scenes = object.scenes();
    scenes.iter().for_each(|own| scene(yaml, object, own));
    needs::refuse(yaml, object, &scenes);
}

/// Paths of the parameters that have no effect in any class.
pub(super) fn without_effect(object: RecipeObject) -> Vec<String> {
    needs::without_effect(object, &object.scenes())
}

/// The keys that are named where the keys of a recipe cannot mean something together.
pub(super) fn refused(yaml: &YamlReader, object: RecipeObject) -> Vec<String> {
    yaml.keys_at_fault(|trial| check(trial, object))
}

/// Parameters that have no effect, each with the reason: in `class`, or in every class.
pub(super) fn reasons(object: RecipeObject, class: Option<&str>) -> Vec<(String, String)> {
    let mut scenes = object.scenes();
    match object.classes.iter().position(|known| class == Some(&known.name)) {
        Some(place) => scenes = vec![scenes.swap_remove(place + 1)],
        None => _ = if scenes.len() > 1 { Some(scenes.remove(0)) } else { None },
    }
    needs::reasons(object, &scenes)
}

/// What is said of the keys together although a recipe may have them so.
pub(super) fn notes(object: RecipeObject) -> Vec<String> {
    let scenes = object.scenes();
    let mut notes = needs::notes(object, &scenes);
    for own in &scenes {
        notes.extend(slices::note(object.contents.slices.as_deref(), own));
        if object.subject == Some(Subject::Blister) {
            notes.extend(object::note(own));
        }
    }
    notes
}

/// The settings together.
fn settings(yaml: &mut YamlReader, subject: Option<Subject>, settings: &Settings) {
    needs::refuse_settings(yaml, subject, settings);
    transport::check(yaml, subject, settings);
    picture::settings(yaml, subject, settings);
    slices::settings(yaml, subject, settings);
    lamps::settings(yaml, subject, settings);
    laser::settings(yaml, settings);
    motion::settings(yaml, subject, settings);
    postprocess::settings(yaml, settings);
    let size = settings.size();
    if size.columns * size.profiles > MAX_PIXELS {
        let problem = format!(
            "{} columns times {} profiles are {} pixels",
            size.columns,
            size.profiles,
            size.columns * size.profiles
        );
        yaml.joint_fault(&["scan.profiles", "scan.columns"], problem, format!("stay at or below {MAX_PIXELS}"));
    }
    let output = settings.output();
    for (name, bin, whole) in
        [("columns", output.bin_columns, size.columns), ("profiles", output.bin_profiles, size.profiles)]
    {
        if !whole.is_multiple_of(bin) {
            let keys = [format!("output.bin.{name}"), format!("scan.{name}")];
            let near =
                (1..=whole).filter(|factor| whole.is_multiple_of(*factor)).min_by_key(|factor| factor.abs_diff(bin));
            let remedy = format!("the nearest factor of {whole} is {}", near.unwrap_or(1));
            yaml.joint_fault(&keys, format!("{bin} does not divide the {whole} {name} of the scan"), remedy);
        }
    }
    let every = match output.sensor_stack {
        SensorStack::None => size.profiles + 1,
        SensorStack::Every(k) => k,
        SensorStack::All => 1,
    };
    let (kept, frame) = (size.profiles / every, size.columns * size.rows);
    if kept * frame > MAX_FRAME_PIXELS {
        let problem = format!(
            "{kept} sensor frames of {} x {} pixels are {:.1} GB a sample",
            size.columns,
            size.rows,
            (2 * kept * frame) as f64 / 1e9
        );
        let least = (size.profiles * frame).div_ceil(MAX_FRAME_PIXELS);
        let remedy =
            format!("at most 4 GiB are kept: {{every: {least}}} or more, fewer camera.rows, or fewer profiles");
        yaml.joint_fault(&["output.sensor_stack"], problem, remedy);
    }
    let extraction = settings.extraction();
    let (offset, width) = (extraction.scatter_offset_rows, extraction.scatter_width_rows);
    let keys =
        ["extraction.scatter_width_rows", "extraction.scatter_offset_rows", "extraction.scatter_mode", "exposure.bits"];
    if offset + width > HALF_WINDOW {
        let problem =
            format!("offset {offset} and width {width} reach {} rows, beyond the 31-row window", offset + width - 1);
        yaml.joint_fault(&keys[..3], problem, format!("offset and width together are at most {HALF_WINDOW}"));
    }
    let summed = match extraction.scatter_mode {
        ScatterMode::Symmetric => 2 * width - usize::from(offset == 0),
        ScatterMode::Front | ScatterMode::Back => width,
    };
    // 29 rows of 8 or 10 bits, 16 of 12.
    let (bits, fitting) =
        (settings.readout().bits, usize::from(u16::MAX / settings.readout().most()).min(MAX_SUMMED_ROWS));
    if summed > fitting {
        let problem = format!("{summed} rows of {bits} bits are summed");
        yaml.joint_fault(&keys, problem, format!("at most {fitting} fit in 16 bits"));
    }
    let splits = settings.splits();
    let sum = splits.train + splits.validation + splits.test;
    if (sum - 1.0).abs() > SUM_SLACK {
        let [train, validation, test, sum] =
            [splits.train, splits.validation, splits.test, sum].map(|share| number_text((share * 1e9).round() / 1e9));
        let problem = format!("train {train}, validation {validation} and test {test} sum to {sum}");
        let remedy = "make them sum to 1; one that is not given has its default";
        yaml.joint_fault(&["splits.train", "splits.validation", "splits.test"], problem, remedy);
    }
}

/// The parameters of a class together, or those of the top level that no class overrides.
fn scene(yaml: &mut YamlReader, object: RecipeObject, scene: &DrawBounds) {
    camera::scene(yaml, object.settings, scene);
    let keys = [
        "exposure.dark_noise_dn",
        "exposure.row_noise_dn",
        "exposure.row_pattern_dn",
        "exposure.column_pattern_dn",
        "exposure.dsnu_dn",
    ];
    let dark = scene.least(keys[0]);
    let parts = [1, 2, 3, 4].map(|i| scene.most(keys[i]));
    let sum = parts.iter().map(|part| part * part).sum::<f64>() + ROUNDING;
    if sum > dark * dark {
        let [row, pattern, column, dsnu] = parts.map(number_text);
        let problem = format!(
            "the dark noise can be {} DN, below its parts: row noise {row}, row pattern {pattern}, column pattern \
             {column}, DSNU {dsnu} and rounding make {:.3} DN",
            number_text(dark),
            sum.sqrt(),
        );
        scene.fault(yaml, &keys, problem, "raise it or lower the parts");
    }

    motion::scene(yaml, object.settings, scene);
    laser::scene(yaml, object.settings, scene);
    postprocess::scene(yaml, object.settings, scene);
    transport::media(yaml, object.subject, object.settings, scene);

    match object.subject {
        Some(Subject::Wood) => {
            object::wood(yaml, scene);
            log_group::fits(yaml, object.settings, object.contents.measured.as_deref(), scene);
            picture::scene(yaml, object.contents.picture.as_deref(), scene);
            slices::scene(yaml, object.contents.slices.as_deref(), scene);
        }
        Some(Subject::Blister) => object::blister(yaml, scene),
        Some(Subject::Sawtooth) => object::sawtooth(yaml, scene),
        Some(Subject::Mesh) => object::mesh(yaml, scene, object.contents.mesh.as_deref()),
        None => {}
    }
}
