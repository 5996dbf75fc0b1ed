//! Range and Scatter of blister packs with one defect each: means over the pockets concerned and over the others, and
//! the maps as the camera sees them.
//!
//! Every pack has draws of its own, those of samples 0, 1, 2 ... of the recipe, but one film, one exposure and the
//! defects of `PACKS`; so apart from the defect packs differ as they do in a dataset.

use base::{Class, Instance};
use image::{Rgb, RgbImage};
use procedural::blister::{Blister, Defects};
use serde_json::{Value, json};

use super::{StudyEvent, StudyProgress, StudyReport, announce, document_head};
use dataset::record::Record;
use drawing::{MARGIN, Page, viridis};
use pipeline;
use recipe::{Plan, Recipe, Scene};
use scanner::optics::speckle::PatternCache;

/// Severity of the defects [1].
const SEVERITY: f64 = 0.9;
/// Scattering of semi-transparent, clear and opaque film [mm^-1].
const FILM_SIGMA_PER_MM: f64 = 12.0;
const CLEAR_SIGMA_PER_MM: f64 = 0.05;
const OPAQUE_SIGMA_PER_MM: f64 = 150.0;
/// Exposure time of a good scan, and of one as overexposed as those of Kihl and Källberg [us].
const GOOD_US: f64 = 40.0;
const OVEREXPOSED_US: f64 = 400.0;

/// A pack of the study: what makes it so.
struct PackCase {
    name: &'static str,
    /// Changes the numbers of a sound pack and the exposure time [us].
    change: fn(&mut Blister, &mut f64),
}

const fn pack(name: &'static str, change: fn(&mut Blister, &mut f64)) -> PackCase {
    PackCase { name, change }
}

/// The packs: sound, each defect alone, then other films and light, then several defects together.
const PACKS: [PackCase; 24] = [
    pack("sound", |_, _| ()),
    pack("missing", |b, _| b.defects.missing = 1.0),
    pack("broken", |b, _| b.defects.broken = 1.0),
    pack("chipped", |b, _| b.defects.chipped = 1.0),
    pack("cracked", |b, _| b.defects.cracked = 1.0),
    pack("capped", |b, _| b.defects.capped = 1.0),
    pack("foreign tablet", |b, _| b.defects.foreign_tablet = 1.0),
    pack("wrong coat", |b, _| b.defects.wrong_coat = 1.0),
    pack("double", |b, _| b.defects.double = 1.0),
    pack("particle", |b, _| b.defects.particle = 1.0),
    pack("fibre", |b, _| b.defects.fibre = 1.0),
    pack("powder", |b, _| b.defects.powder = 1.0),
    pack("shallow", |b, _| b.defects.shallow = 1.0),
    pack("collapsed", |b, _| b.defects.collapsed = 1.0),
    pack("punctured", |b, _| b.defects.punctured = 1.0),
    pack("pinhole, clear film", |b, _| (b.defects.pinhole, b.web.sigma_per_mm) = (3.0, CLEAR_SIGMA_PER_MM)),
    pack("channel", |b, _| b.defects.channel = 1.0),
    pack("wrinkle", |b, _| b.defects.wrinkle = 1.0),
    pack("delamination", |b, _| b.defects.delamination = 1.0),
    pack("tablet on flange", |b, _| b.defects.tablet_on_flange = 1.0),
    pack("missing, clear film", |b, _| (b.defects.missing, b.web.sigma_per_mm) = (1.0, CLEAR_SIGMA_PER_MM)),
    pack("missing, opaque film", |b, _| (b.defects.missing, b.web.sigma_per_mm) = (1.0, OPAQUE_SIGMA_PER_MM)),
    pack("missing, overexposed", |b, time_us| {
        b.defects.missing = 1.0;
        *time_us = OVEREXPOSED_US;
    }),
    pack("several", |b, _| {
        (b.defects.missing, b.defects.broken, b.defects.powder, b.defects.channel) = (1.0, 1.0, 1.0, 1.0);
    }),
];

/// A pack that was rendered.
struct PackSample {
    name: &'static str,
    record: Record,
    /// Contribution of the dark level to Scatter [DN].
    dark_dn: f64,
}

/// Number of packs of the study.
pub fn workload() -> u64 {
    PACKS.len() as u64
}

/// Runs the study on the packs of `recipe`.
///
/// # Errors
/// In words, where the recipe is not about blister packs.
pub fn study(recipe: &Recipe, seed: u64, progress: StudyProgress) -> Result<StudyReport, String> {
    let patterns = PatternCache::new(seed);
    let mut packs = Vec::with_capacity(PACKS.len());
    for (number, PackCase { name, change }) in PACKS.into_iter().enumerate() {
        announce("kernel", name, progress);
        let scene = scene(recipe, seed, number as u64, change)?;
        let record = pipeline::render(&scene, &patterns, &|_| ());
        let dark = record.physics.iter().find(|(name, _)| *name == "scatter_dark_dn");
        packs.push(PackSample { name, dark_dn: dark.map_or(0.0, |(_, dn)| *dn), record });
        progress(StudyEvent::Done(1));
    }
    let mut table =
        format!("{:22} {:>10} {:>10} {:>10} {:>10}  defects\n", "pack", "Scatter", "others", "Range", "others");
    table += &format!("{:22} {:>10} {:>10} {:>10} {:>10}\n", "", "[DN]", "[DN]", "[mm]", "[mm]");
    let mut rows = Vec::new();
    for pack in &packs {
        let (line, row) = describe(pack);
        table += &line;
        rows.push(row);
    }
    let mut json = document_head("packs");
    json["recipe"] = json!(recipe.name());
    json["seed"] = json!(seed);
    json["packs"] = json!(rows);
    Ok(StudyReport { table, json, picture: page(&packs), figures: Vec::new() })
}

/// Sample `index` of the recipe without defects, then changed by `change`.
fn scene(recipe: &Recipe, seed: u64, index: u64, change: fn(&mut Blister, &mut f64)) -> Result<Scene, String> {
    let mut scene = recipe.draw(seed, index);
    let subject = recipe.subject().name();
    let Plan::Blister(blister) = &mut scene.plan else {
        return Err(format!(
            "{} is about {subject}; name a recipe for blister packs, blister-small for one",
            recipe.name()
        ));
    };
    blister.defects = Defects::from_values(&mut |parameter| parameter.default);
    blister.defects.severity = SEVERITY;
    blister.web.sigma_per_mm = FILM_SIGMA_PER_MM;
    scene.bench.exposure.time_us = GOOD_US;
    change(blister, &mut scene.bench.exposure.time_us);
    (scene.output.bin_columns, scene.output.bin_profiles) = (1, 1);
    Ok(scene)
}

/// Means over the pixels of some pockets.
#[derive(Clone, Copy)]
struct PocketMeans {
    /// Scatter without the dark level [DN].
    scatter_dn: f64,
    /// Range [mm].
    range_mm: f64,
}

/// Means of the pockets that `chosen` picks; `None` for none.
fn pocket_means(pack: &PackSample, chosen: impl Fn(&Instance) -> bool) -> Option<PocketMeans> {
    let record = &pack.record;
    let ids: Vec<u16> = record.objects.iter().map(|o| o.instance).filter(|i| chosen(i)).map(|i| i.id).collect();
    let parent = |id: u16| {
        let own = record.objects.iter().map(|object| &object.instance).find(|instance| instance.id == id);
        own.map_or(id, |instance| if instance.within > 0 { instance.within } else { id })
    };
    let seen = |i: &usize| {
        let id = record.labels.instance[*i];
        id > 0 && record.maps.scatter[*i] > 0.0 && ids.contains(&parent(id))
    };
    let pixels: Vec<usize> = (0..record.labels.instance.len()).filter(seen).collect();
    let of = |map: &[f32]| pixels.iter().map(|&i| f64::from(map[i])).sum::<f64>() / pixels.len() as f64;
    (!pixels.is_empty())
        .then(|| PocketMeans { scatter_dn: of(&record.maps.scatter) - pack.dark_dn, range_mm: of(&record.maps.range) })
}

/// A pack's line in the table, and the same as JSON.
fn describe(pack: &PackSample) -> (String, Value) {
    let pocket = |i: &Instance| i.within == 0 && (i.class == Class::Pocket || i.state != Class::Pocket);
    let concerned = pocket_means(pack, |i| pocket(i) && i.state != Class::Pocket);
    let others = pocket_means(pack, |i| pocket(i) && i.state == Class::Pocket);
    let defects: Vec<&str> =
        pack.record.objects.iter().map(|o| o.instance.class).filter(|c| *c != Class::Pocket).map(Class::name).collect();
    let number = |value: Option<f64>, digits: usize| value.map_or("-".to_owned(), |value| format!("{value:.digits$}"));
    let line = format!(
        "{:22} {:>10} {:>10} {:>10} {:>10}  {}\n",
        pack.name,
        number(concerned.map(|means| means.scatter_dn), 1),
        number(others.map(|means| means.scatter_dn), 1),
        number(concerned.map(|means| means.range_mm), 2),
        number(others.map(|means| means.range_mm), 2),
        defects.join(", ")
    );
    let pair = |of: Option<PocketMeans>| {
        of.map(|PocketMeans { scatter_dn, range_mm }| json!({"scatter_dn": scatter_dn, "range_mm": range_mm}))
    };
    let json = json!({"name": pack.name, "defects": defects, "concerned": pair(concerned), "others": pair(others)});
    (line, json)
}

/// Packs in a line of the page.
const PACKS_ACROSS: u32 = 3;
/// Space for a pack's name [px].
const NAME_PX: u32 = 18;
/// Space between the pictures of a pack [px].
const SEAM_PX: u32 = 3;
/// Columns and profiles behind one pixel of the page.
const SHRINK: usize = 2;
/// Share of a map's pixels above white.
const CLIPPED_SHARE: f64 = 0.004;
/// Outlines of defects.
const OUTLINE: Rgb<u8> = Rgb([255, 60, 40]);
/// Where nothing was measured.
const MISSING: Rgb<u8> = Rgb([60, 0, 40]);

/// The page.
fn page(packs: &[PackSample]) -> RgbImage {
    let size = |record: &Record| ((record.cols / SHRINK) as u32, (record.rows / SHRINK) as u32);
    let (width, height) = packs.first().map_or((1, 1), |pack| size(&pack.record));
    let (cell, line) = (3 * width + 2 * SEAM_PX + MARGIN, NAME_PX + height + MARGIN);
    let mut page = Page::new(PACKS_ACROSS * cell + MARGIN, (packs.len() as u32).div_ceil(PACKS_ACROSS) * line + MARGIN);
    for (number, pack) in packs.iter().enumerate() {
        let number = number as u32;
        let (left, top) = (MARGIN + number % PACKS_ACROSS * cell, MARGIN + number / PACKS_ACROSS * line);
        page.words(left, top + NAME_PX - 6, pack.name);
        for (place, picture) in pictures(pack).iter().enumerate() {
            page.picture(left + place as u32 * (width + SEAM_PX), top + NAME_PX, picture);
        }
    }
    page.0
}

/// Range, Reflectance and Scatter of a pack.
fn pictures(pack: &PackSample) -> [RgbImage; 3] {
    let maps = &pack.record.maps;
    let dark = pack.dark_dn as f32;
    let scatter: Vec<f32> = maps.scatter.iter().map(|v| if *v > 0.0 { (v - dark).max(0.1) } else { 0.0 }).collect();
    let grey = |t: f32| Rgb([(255.0 * t) as u8; 3]);
    let mut range = paint(&pack.record, &maps.range, viridis);
    outline(&pack.record, &mut range);
    [range, paint(&pack.record, &maps.reflectance, grey), paint(&pack.record, &scatter, grey)]
}

/// A map from 0 to what nearly all of its pixels stay below.
fn paint(record: &Record, map: &[f32], ramp: fn(f32) -> Rgb<u8>) -> RgbImage {
    let on = |i: &usize| record.labels.class[*i] != Class::Background as u8 && map[*i] > 0.0;
    let mut values: Vec<f32> = (0..map.len()).filter(on).map(|i| map[i]).collect();
    values.sort_by(f32::total_cmp);
    let white = values.get(((1.0 - CLIPPED_SHARE) * values.len() as f64) as usize).copied().unwrap_or(1.0);
    RgbImage::from_fn((record.cols / SHRINK) as u32, (record.rows / SHRINK) as u32, |x, y| {
        let seen: Vec<f32> = behind(record, x, y).map(|i| map[i]).filter(|v| *v > 0.0).collect();
        if seen.is_empty() {
            return MISSING;
        }
        ramp((seen.iter().sum::<f32>() / seen.len() as f32 / white).clamp(0.0, 1.0))
    })
}

/// Pixels of the images behind one of the page.
fn behind(record: &Record, x: u32, y: u32) -> impl Iterator<Item = usize> {
    let (x, y, cols) = (x as usize * SHRINK, y as usize * SHRINK, record.cols);
    (y..y + SHRINK).flat_map(move |row| (x..x + SHRINK).map(move |column| row * cols + column))
}

/// Draws a line where a defect's pixels end.
fn outline(record: &Record, picture: &mut RgbImage) {
    let sound = [Class::Background, Class::Flange, Class::Pocket].map(|class| class as u8);
    let (width, height) = picture.dimensions();
    let at = |x: u32, y: u32| {
        let i = behind(record, x, y).next().unwrap_or(0);
        if sound.contains(&record.labels.class[i]) { 0 } else { record.labels.instance[i] }
    };
    for y in 1..height {
        for x in 1..width {
            if at(x, y) != at(x - 1, y) || at(x, y) != at(x, y - 1) {
                picture.put_pixel(x, y, OUTLINE);
            }
        }
    }
}
