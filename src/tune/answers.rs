//! What the page can ask, and the answers: documents of JSON, and maps as the bytes of their numbers.

use std::fmt::Display;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use base::{Class, Words};
use drawing::html::data_url;
use drawing::{class_colour, viridis};
use image::{ImageFormat, Rgb, RgbImage};
use rayon::ThreadPoolBuildError;
use serde::Deserialize;
use serde_json::{Value, json};

use super::TuneStart;
use super::connection::{HttpRefusal, HttpReply};
use super::samples::{RenderedSample, SampleName, SampleStore, SetUpSample, SparseLook};
use super::turns::{PageTurn, Turns, locked};
use crate::preview;
use dataset::record::{Labels, Maps};
use pipeline::PixelRegion;
use recipe::{Change, Recipe, RecipeError, Subject, YamlFault, declarations, with_key, without_key, written_keys};
use scanner::extract;

/// Most pixels of a region.
const MAX_REGION_PIXELS: usize = 1 << 20;
/// Samples that are looked through for one of a class.
const MAX_SEARCHED: u64 = 5_000;
/// Width of a look at a sample [px].
const LOOK_WIDTH: u32 = 120;
/// Greatest height of a look [px].
const LOOK_HEIGHT: u32 = 180;
/// Share of values that a look leaves beyond each end of its colours [1].
const LOOK_CUT: f64 = 0.005;
/// Colours of a map that go to the page.
const COLOURS: u16 = 256;
/// Longest name that is saved [bytes].
const MAX_NAME_BYTES: usize = 64;
/// What all files that are saved end in.
const ENDING: &str = ".yaml";

/// Everything that is asked of.
#[derive(Debug)]
pub(super) struct Answers {
    start: TuneStart,
    /// What lies in the recipe's file, as far as this program knows.
    on_disk: Mutex<String>,
    samples: SampleStore,
    turns: Turns,
}

/// A recipe and one of its samples.
#[derive(Debug, Deserialize)]
struct SampleQuestion {
    text: String,
    seed: u64,
    index: u64,
    #[serde(flatten)]
    turn: PageTurn,
    /// Pixel that a region lies about; of an exposure, its profile.
    #[serde(default)]
    profile: usize,
    #[serde(default)]
    column: usize,
    /// Size of a region.
    #[serde(default)]
    profiles: usize,
    #[serde(default)]
    columns: usize,
    /// Whether nothing is rendered for it.
    #[serde(default)]
    at_hand: bool,
}

/// A recipe, an edit of it, and which sample to name.
#[derive(Debug, Deserialize)]
struct StateQuestion {
    text: String,
    seed: u64,
    index: u64,
    /// Class whose numbers the knobs show; none for those of all.
    class: Option<String>,
    /// Class of which the sample is to be: from `index` on.
    of_class: Option<String>,
    edit: Option<KeyEdit>,
}

/// A key and its new value in YAML; none takes it out.
#[derive(Debug, Deserialize)]
struct KeyEdit {
    key: String,
    value: Option<String>,
}

/// A text to be saved.
#[derive(Debug, Deserialize)]
struct SaveQuestion {
    text: String,
    /// Another name than that of the recipe's file.
    name: Option<String>,
    /// Whether what lies there is replaced.
    #[serde(default)]
    replace: bool,
}

impl Answers {
    /// Of the recipe that the page begins with.
    pub fn new(start: TuneStart) -> Result<Self, ThreadPoolBuildError> {
        let samples = SampleStore::new(start.origin.clone(), start.files.clone(), start.threads);
        let turns = Turns::new(start.threads)?;
        Ok(Self { on_disk: Mutex::new(start.text.clone()), samples, turns, start })
    }

    /// A part of the page itself.
    pub fn page(&self, path: &str) -> HttpReply {
        let (kind, text) = match path {
            "tune.css" => ("text/css; charset=utf-8", include_str!("page/tune.css")),
            "tune.js" => ("text/javascript; charset=utf-8", include_str!("page/tune.js")),
            _ => ("text/html; charset=utf-8", include_str!("page/tune.html")),
        };
        HttpReply { status: 200, kind, body: text.as_bytes().to_vec() }
    }

    /// The answer to the question `name` of that body. What the page deals with itself (faults of a recipe, work that
    /// was stopped) is an answer too: `fault` in words, and a status.
    pub fn answer(&self, name: &str, body: &[u8]) -> Result<HttpReply, HttpRefusal> {
        match self.found(name, body) {
            Err(HttpRefusal { status: status @ (409 | 422), why }) => {
                Ok(HttpReply::json(&json!({ "fault": why, "status": status })))
            }
            other => other,
        }
    }

    fn found(&self, name: &str, body: &[u8]) -> Result<HttpReply, HttpRefusal> {
        match name {
            "start" => Ok(HttpReply::json(&self.start())),
            "declarations" => {
                let word: String = asked(body)?;
                let subject = Subject::named(&word).ok_or_else(|| faulty(format!("no object is a `{word}`")))?;
                Ok(HttpReply::json(&declarations(subject)))
            }
            "state" => self.state(asked(body)?),
            "save" => self.keep(&asked(body)?),
            "region" => self.region(&asked(body)?),
            "exposure" => self.exposure(&asked(body)?),
            "scan" => self.whole(&asked(body)?, false),
            "picture" => self.whole(&asked(body)?, true),
            "look" => self.look(&asked(body)?),
            "rig" => self.rig(&asked(body)?),
            _ => Err(HttpRefusal::unknown()),
        }
    }

    /// What the page has to know once.
    fn start(&self) -> Value {
        let TuneStart { text, origin, file, seed, index, .. } = &self.start;
        let name = file.as_deref().and_then(Path::file_name).map(|name| name.to_string_lossy());
        let classes: Vec<Value> = Class::ALL
            .iter()
            .map(|class| json!({ "value": *class as u8, "name": class.name(), "colour": class_colour(*class as u8).0 }))
            .collect();
        let colours: Vec<_> = (0..COLOURS).map(|n| viridis(f32::from(n) / f32::from(COLOURS - 1)).0).collect();
        json!({
            "text": text, "origin": origin, "file": name, "seed": seed, "index": index,
            "subject": subject_of(text).name(), "classes": classes, "colours": colours,
        })
    }

    /// What becomes of a recipe by an edit: its text, and what the knobs show or what is wrong with it.
    fn state(&self, question: StateQuestion) -> Result<HttpReply, HttpRefusal> {
        let StateQuestion { mut text, seed, mut index, class, of_class, edit } = question;
        if let Some(KeyEdit { key, value }) = edit {
            text = match value {
                Some(value) => with_key(&text, &format!("{key}={value}").parse::<Change>().map_err(faulty)?),
                None => without_key(&text, &key)
                    .ok_or_else(|| faulty(format!("`{key}` cannot be taken out here: change the text")))?,
            };
        }
        let written = written_keys(&text);
        let recipe = match self.samples.recipe(&text) {
            Ok(recipe) => recipe,
            Err(RecipeError::Faulty(faults)) => {
                let list: Vec<Value> = faults.list.iter().map(fault_json).collect();
                let document = json!({ "text": text, "written": written, "faults": list, "unlisted": faults.unlisted });
                return Ok(HttpReply::json(&document));
            }
            Err(error) => return Err(faulty(error)),
        };
        if let Some(wanted) = &of_class {
            let found =
                (index..index.saturating_add(MAX_SEARCHED)).find(|&index| recipe.draw(seed, index).class == *wanted);
            index = found.ok_or_else(|| faulty(format!("none of the next {MAX_SEARCHED} samples is of `{wanted}`")))?;
        }
        let scene = recipe.draw(seed, index);
        let classes: Vec<Value> =
            recipe.classes().iter().map(|class| json!({ "name": class.name, "share": class.share })).collect();
        let draws: serde_json::Map<String, Value> =
            scene.draws().into_iter().map(|(path, value)| (path, json!(value))).collect();
        Ok(HttpReply::json(&json!({
            "text": text, "written": written, "faults": [], "index": index, "subject": recipe.subject().name(),
            "name": recipe.name(), "hash": recipe.hash(), "id": scene.id, "class": scene.class,
            "split": scene.split.name(), "classes": classes, "draws": draws, "notes": recipe.notes(),
            "states": recipe.key_states(class.as_deref()),
            "columns": scene.size.columns, "profiles": scene.size.profiles, "rows": scene.size.rows,
            "scatter_dark": extract::scatter_dark(&scene.extraction, scene.bench.exposure.dark_level_dn as f32).kept,
            "most_dn": scene.readout.most(), "step_mm": scene.bench.motion.step_mm,
            "range_unit": scene.extraction.range.unit(),
        })))
    }

    fn sample(&self, question: &SampleQuestion) -> Result<Arc<SetUpSample>, HttpRefusal> {
        self.samples.set_up(&question.name()).map_err(faulty)
    }

    /// Maps of a region of the scan.
    fn region(&self, question: &SampleQuestion) -> Result<HttpReply, HttpRefusal> {
        let SampleQuestion { profile, column, profiles, columns, .. } = *question;
        if profiles.saturating_mul(columns) > MAX_REGION_PIXELS {
            return Err(faulty(format!("a region has at most {MAX_REGION_PIXELS} pixels")));
        }
        if question.at_hand && self.samples.rendered(&question.name()).is_none() {
            return Err(HttpRefusal { status: 409, why: "the scan is not there yet".into() });
        }
        let begun = Instant::now();
        let made = self.turns.in_front(&question.turn, |is_stopped| {
            let sample = match self.sample(question) {
                Ok(sample) => sample,
                Err(refusal) => return Some(Err(refusal)),
            };
            let region = PixelRegion::about([profile, column], [profiles, columns], sample.scene.size);
            let (maps, labels) = self.samples.region(&sample, &region, is_stopped)?;
            Some(Ok((region, maps, labels, column_mm(&sample))))
        });
        let (region, maps, labels, column_mm) = made.ok_or_else(stopped)??;
        Ok(packed_region(&region, &maps, &labels, [column_mm, begun.elapsed().as_secs_f64() * 1e3]))
    }

    /// The sensor frame of a profile, with the line that is read from it.
    fn exposure(&self, question: &SampleQuestion) -> Result<HttpReply, HttpRefusal> {
        let sample = self.sample(question)?;
        let SetUpSample { scene, sensor, specimen, .. } = &*sample;
        let made =
            self.turns.in_front(&question.turn, |_| Some(preview::exposed(scene, sensor, specimen, question.profile)));
        let seen = made.ok_or_else(stopped)?;
        let head = json!({
            "profile": seen.profile, "y_mm": seen.y_mm, "columns": seen.cols, "first_row": seen.first_row,
            "rows": seen.dn.len() / seen.cols.max(1), "max_dn": seen.max_dn,
            "threshold_dn": scene.extraction.threshold_dn,
        });
        let mut packed = Packed::new(&head);
        packed.floats(&seen.line);
        for place in 0..2 {
            packed.floats(&seen.points.iter().map(|point| point[place] as f32).collect::<Vec<_>>());
        }
        packed.0.extend(seen.dn.iter().flat_map(|dn| dn.to_le_bytes()));
        Ok(packed.reply())
    }

    /// The maps of the whole scan as `gen preview` shows them; with `as_file`, its picture.
    fn whole(&self, question: &SampleQuestion, as_file: bool) -> Result<HttpReply, HttpRefusal> {
        let made = self.turns.behind(&question.turn, |is_stopped| match self.sample(question) {
            Ok(sample) => self.samples.render(&sample, is_stopped).map(Ok),
            Err(refusal) => Some(Err(refusal)),
        });
        let rendered = made.ok_or_else(stopped)??;
        let RenderedSample { sample, record, shown } = &*rendered;
        if as_file {
            let body = png(&preview::draw(&sample.scene, record))?;
            return Ok(HttpReply { status: 200, kind: "image/png", body });
        }
        let maps: Result<Vec<Value>, HttpRefusal> = shown
            .maps
            .iter()
            .map(|map| {
                Ok(json!({
                    "name": map.name, "low": map.low, "high": map.high, "unit": map.unit, "less": map.less,
                    "coloured": map.is_coloured, "picture": data_url(&png(&map.picture)?),
                }))
            })
            .collect();
        let labels = data_url(&png(&shown.labels)?);
        Ok(HttpReply::json(&json!({
            "maps": maps?, "labels": labels, "width": shown.labels.width(), "height": shown.labels.height(),
            "column_mm": record.col_mm, "row_mm": record.row_mm, "unseen": record.unseen.len(),
            "objects": record.objects.len(), "object_in_view": record.object_in_view,
        })))
    }

    /// A small picture of a sample, of each map.
    fn look(&self, question: &SampleQuestion) -> Result<HttpReply, HttpRefusal> {
        let made = self.turns.behind(&question.turn, |is_stopped| match self.sample(question) {
            Ok(sample) => sample.look(is_stopped).map(|look| Ok((sample, look))),
            Err(refusal) => Some(Err(refusal)),
        });
        let (sample, look) = made.ok_or_else(stopped)??;
        let pictures: Result<Vec<String>, HttpRefusal> =
            painted_look(&sample, &look).iter().map(|picture| Ok(data_url(&png(picture)?))).collect();
        Ok(HttpReply::json(&json!({
            "index": question.index, "class": sample.scene.class, "pictures": pictures?,
            "profiles": look.profiles.len(),
        })))
    }

    /// What `gen rig` says of the sample.
    fn rig(&self, question: &SampleQuestion) -> Result<HttpReply, HttpRefusal> {
        let recipe = self.samples.recipe(&question.text).map_err(faulty)?;
        let made =
            self.turns.behind(&question.turn, |_| Some(rig::report(&recipe.draw(question.seed, question.index))));
        let report = made.ok_or_else(stopped)?;
        let numbers: Vec<Value> = report
            .numbers
            .iter()
            .map(|number| json!({ "name": number.name, "doc": number.doc, "value": number.value }))
            .collect();
        Ok(HttpReply::json(&json!({ "numbers": numbers, "warnings": report.warnings })))
    }

    /// Saves a text as the recipe's file, or by another name beside it.
    fn keep(&self, question: &SaveQuestion) -> Result<HttpReply, HttpRefusal> {
        let SaveQuestion { text, name, replace } = question;
        let own = self.start.file.as_deref();
        let path = match (name, own) {
            (Some(name), _) => self.start.folder.join(file_name(name)?),
            (None, Some(own)) => own.to_owned(),
            (None, None) => return Err(faulty("the recipe came from no file: save it by a name")),
        };
        let is_own = own.is_some_and(|own| own == path);
        let there = path.symlink_metadata().is_ok();
        let is_known = is_own
            && files::read(&path, yaml::MAX_FILE_BYTES as u64)
                .is_ok_and(|bytes| bytes == locked(&self.on_disk).as_bytes());
        let shown = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        if there && !is_known && !replace {
            let why = if is_own { "has changed on the disk since it was read" } else { "is there already" };
            return Err(HttpRefusal { status: 409, why: format!("{shown} {why}") });
        }
        (self.start.save)(&path, text.as_bytes()).map_err(faulty)?;
        if is_own {
            locked(&self.on_disk).clone_from(text);
        }
        Ok(HttpReply::json(&json!({ "saved": shown })))
    }
}

impl SampleQuestion {
    fn name(&self) -> SampleName {
        SampleName { text: self.text.clone(), seed: self.seed, index: self.index }
    }
}

/// A name by which a recipe may be saved: of a file, and nothing that leads elsewhere.
fn file_name(name: &str) -> Result<PathBuf, HttpRefusal> {
    let letters = |c: u8| c.is_ascii_alphanumeric() || b"-_.".contains(&c);
    let is_plain = name.bytes().all(letters) && !name.starts_with(['.', '-']) && name.len() <= MAX_NAME_BYTES;
    // Windows keeps some names for devices, whatever they end in.
    let stem = name.split('.').next().unwrap_or_default().to_ascii_uppercase();
    let is_device = ["CON", "PRN", "AUX", "NUL"].contains(&stem.as_str())
        || stem.len() == 4 && (stem.starts_with("COM") || stem.starts_with("LPT"));
    if is_plain && !is_device && name.len() > ENDING.len() && name.ends_with(ENDING) {
        return Ok(PathBuf::from(name));
    }
    Err(faulty(format!("`{name}` is no name for a recipe: give letters, digits, - and _, and {ENDING} at its end")))
}

/// What a text is about that may not be a recipe yet.
fn subject_of(text: &str) -> Subject {
    let word = |line: &str| Subject::named(line.strip_prefix("subject:")?.split('#').next()?.trim());
    let parsed = || Recipe::parse("", text).map_or(Subject::Wood, |recipe| recipe.subject());
    text.lines().find_map(word).unwrap_or_else(parsed)
}

/// A question of the page.
fn asked<'b, T: Deserialize<'b>>(body: &'b [u8]) -> Result<T, HttpRefusal> {
    serde_json::from_slice(body).map_err(|_| HttpRefusal::malformed())
}

fn faulty(why: impl Display) -> HttpRefusal {
    HttpRefusal { status: 422, why: why.to_string() }
}

/// Something newer has taken the place of a request.
fn stopped() -> HttpRefusal {
    HttpRefusal { status: 409, why: "a newer request took its place".into() }
}

fn fault_json(fault: &YamlFault) -> Value {
    json!({
        "key": fault.key, "line": fault.place.line, "column": fault.place.column, "origin": fault.origin,
        "problem": fault.problem, "remedy": fault.remedy,
    })
}

/// Bytes of PNG.
fn png(picture: &RgbImage) -> Result<Vec<u8>, HttpRefusal> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).map_err(faulty)?;
    Ok(bytes.into_inner())
}

/// A head of JSON behind its length, then numbers in small ends first.
struct Packed(Vec<u8>);

impl Packed {
    fn new(head: &Value) -> Self {
        let mut head = head.to_string();
        // Numbers begin at whole words.
        while !head.len().is_multiple_of(4) {
            head.push(' ');
        }
        let mut bytes = u32::try_from(head.len()).unwrap_or(0).to_le_bytes().to_vec();
        bytes.extend(head.into_bytes());
        Self(bytes)
    }

    fn floats(&mut self, numbers: &[f32]) {
        self.0.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }

    fn reply(self) -> HttpReply {
        HttpReply { status: 200, kind: "application/octet-stream", body: self.0 }
    }
}

/// Distance of columns on the object's upper surface, the mean of all [mm].
fn column_mm(sample: &SetUpSample) -> f64 {
    let (rig, top, columns) = (sample.sensor.camera().rig, f64::from(sample.specimen.top()), sample.scene.size.columns);
    (rig.along(columns as f64, top) - rig.along(0.0, top)).abs() / columns as f64
}

fn packed_region(region: &PixelRegion, maps: &Maps, labels: &Labels, [column_mm, ms]: [f64; 2]) -> HttpReply {
    let head = json!({
        "profile": region.profiles.start, "column": region.columns.start,
        "profiles": region.profiles.len(), "columns": region.columns.len(),
        "grey": !maps.grey.is_empty(), "column_mm": column_mm, "ms": ms,
    });
    let mut packed = Packed::new(&head);
    for map in [&maps.range, &maps.reflectance, &maps.scatter, &maps.grey] {
        packed.floats(map);
    }
    packed.0.extend(labels.instance.iter().flat_map(|instance| instance.to_le_bytes()));
    packed.0.extend(&labels.class);
    packed.reply()
}

/// Range, Reflectance, Scatter and labels of a look, true to scale as far as that is small.
fn painted_look(sample: &SetUpSample, look: &SparseLook) -> Vec<RgbImage> {
    let (columns, rows) = (sample.scene.size.columns, look.profiles.len());
    let across = column_mm(sample) * columns as f64;
    let along = sample.scene.bench.motion.step_mm * sample.scene.size.profiles as f64;
    let height = (f64::from(LOOK_WIDTH) * along / across.max(1e-6)).round() as u32;
    let (width, height) = (LOOK_WIDTH, height.clamp(16, LOOK_HEIGHT));
    let behind = |x: u32, y: u32| {
        let span = |place: u32, size: u32, count: usize| {
            let edge = |place: u32| (u64::from(place) * count as u64 / u64::from(size)) as usize;
            edge(place).min(count - 1)..edge(place + 1).max(edge(place) + 1).min(count)
        };
        let of_row = span(x, width, columns);
        span(y, height, rows).flat_map(move |row| of_row.clone().map(move |column| row * columns + column))
    };
    let paint = |map: &[f32], colour: &dyn Fn(f32) -> Rgb<u8>| {
        let mut known: Vec<f32> = map.iter().copied().filter(|value| !value.is_nan()).collect();
        known.sort_by(f32::total_cmp);
        let at =
            |share: f64| known.get((known.len().saturating_sub(1) as f64 * share) as usize).copied().unwrap_or(0.0);
        let (low, high) = (at(LOOK_CUT), at(1.0 - LOOK_CUT));
        RgbImage::from_fn(width, height, |x, y| {
            let values = behind(x, y).map(|place| map[place]).filter(|value| !value.is_nan());
            let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0f32));
            if count == 0.0 {
                return preview::MISSING_COLOUR;
            }
            colour(((sum / count - low) / (high - low).max(1e-6)).clamp(0.0, 1.0))
        })
    };
    let grey = |t: f32| Rgb([(255.0 * t) as u8; 3]);
    let class = |x, y| class_colour(behind(x, y).map(|place| look.labels.class[place]).max().unwrap_or(0));
    vec![
        paint(&look.maps.range, &viridis),
        paint(&look.maps.reflectance, &grey),
        paint(&look.maps.scatter, &grey),
        RgbImage::from_fn(width, height, class),
    ]
}
