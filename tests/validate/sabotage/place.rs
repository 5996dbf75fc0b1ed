//! A small dataset of boards, kept as encoded samples: changed before it is written, or on the disk afterwards.

use std::collections::BTreeMap;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::path::Path;
use std::sync::{Mutex, OnceLock};

use base::Class;
use dataset::record::AskedRows;
use dataset::validate::{Code, Derive, Expect, RowChoice, TakeFrame, ValidationOptions, ValidationReport, validate};
use dataset::{Dataset, Encoded, ExrChannel, Grey};
use dataset::{read_exr, read_png, write_exr, write_png};
use optical_bench::settings::Channel;
use output_schema::{DatasetHead, RigWarning};
use recipe::Recipe;
use scanner::optics::speckle::PatternCache;
use serde_json::Value;
use sheetlight::generate::{DatasetRequest, ExpectedDataset, dataset_head, rig_warnings};
use tempfile::TempDir;

pub use crate::damage::{MANIFEST, agree, edit_json as edit};
use test_support::program::{FRAMES, recipe};
use test_support::records;

/// Samples of the dataset, in shards of three.
pub const SAMPLES: u64 = 6;
/// Columns and rows of its images [px].
pub const SIZE: (usize, usize) = (128, 96);

/// The recipe, what `dataset.json` says, and every sample.
pub struct Boards {
    pub head: DatasetHead,
    pub samples: Vec<Encoded>,
}

/// Boards with knots of at least 9 mm that the images show whole; rendered once.
pub fn boards() -> &'static Boards {
    static BOARDS: OnceLock<Boards> = OnceLock::new();
    BOARDS.get_or_init(|| {
        let size = [["\n  columns: 64 ", "\n  columns: 128 "], ["\n  profiles: 48 ", "\n  profiles: 96 "]];
        let text = size.iter().fold(recipe(&[FRAMES]), |text, [old, new]| text.replacen(old, new, 1));
        // A field of 23.6 x 17.4 mm as in the whole recipe, a quarter of its pixels.
        let text = text.replacen("step_mm: 0.068", "step_mm: 0.18", 1).replacen("pixel_um: 6", "pixel_um: 12", 1);
        // Two splits have samples.
        let shares = ["{train: 0.8, validation: 0.1, test: 0.1}", "{train: 0.75, validation: 0.25, test: 0}"];
        let text = text.replacen(shares[0], shares[1], 1);
        let recipe = Recipe::parse("tiny.yaml", &text).expect("the recipe loads");
        let order =
            DatasetRequest { samples: SAMPLES, seed: 5, out: "set".into(), part: (0, 1), samples_per_shard: Some(3) };
        let patterns = PatternCache::new(recipe.streams(order.seed).key());
        let sample = |index| sheetlight::generate::render_sample(&recipe, order.seed, index, &patterns, &|_| ());
        let warnings = known_warnings(&recipe, order.seed);
        Boards { head: dataset_head(&recipe, &order, warnings), samples: (0..SAMPLES).map(sample).collect() }
    })
}

/// Warnings that say what to look at, where nothing exact can be compared.
pub const ESTIMATES: [Code; 6] = [
    Code::RangeDiffers,
    Code::OutlineDiffers,
    Code::DiveDiffers,
    Code::TruthDiffers,
    Code::SampleRepeated,
    Code::SampleAlike,
];

/// The head and the samples of a recipe, rendered.
pub fn of_recipe(text: &str, samples: u64) -> (DatasetHead, Vec<Encoded>) {
    let recipe = Recipe::parse("tiny.yaml", text).unwrap_or_else(|error| panic!("{error}"));
    let order = DatasetRequest { samples, seed: 7, out: "set".into(), part: (0, 1), samples_per_shard: Some(samples) };
    let patterns = PatternCache::new(recipe.streams(order.seed).key());
    let sample = |index| sheetlight::generate::render_sample(&recipe, order.seed, index, &patterns, &|_| ());
    let warnings = known_warnings(&recipe, order.seed);
    (dataset_head(&recipe, &order, warnings), (0..samples).map(sample).collect())
}

/// What validation says of such samples, by its codes.
pub fn codes_of(head: &DatasetHead, samples: Vec<Encoded>, what: &str) -> Vec<Code> {
    let folder = write_as(head.clone(), samples);
    let codes = inspect(folder.path()).codes();
    if !codes.is_empty() {
        always(folder.path(), what);
    }
    codes
}

/// The codes of what validation says to look at in such samples, where it cannot draw their recipe again.
pub fn looked_at(head: &DatasetHead, samples: Vec<Encoded>) -> Vec<Code> {
    let report = validate(write_as(head.clone(), samples).path(), &ValidationOptions::default());
    let told = |code: &Code| report.warnings.iter().any(|warning| warning.code == *code);
    ESTIMATES.into_iter().filter(told).collect()
}

/// Writes samples, with manifests that agree with them.
pub fn write(samples: Vec<Encoded>) -> TempDir {
    write_as(boards().head.clone(), samples)
}

/// Writes samples of a dataset.
pub fn write_as(mut head: DatasetHead, samples: Vec<Encoded>) -> TempDir {
    let place = tempfile::tempdir().expect("a temporary folder");
    head.samples = samples.len() as u64;
    let folder = Dataset::open_or_create(place.path(), head, false, &|| ()).expect("it opens");
    let recipe = Recipe::parse("tiny.yaml", &folder.head().recipe.text).expect("the recipe loads");
    for ((_, file), asset) in recipe.files().zip(&folder.head().assets) {
        folder.keep(&asset.path, file.bytes(), &|| ()).expect("it is kept");
    }
    let mut samples = samples.into_iter();
    for shard in 0..folder.head().shards {
        let mut writer = records::claimed(&folder, shard);
        (0..writer.span().1).for_each(|_| writer.push(samples.next().expect("enough samples")).expect("it is written"));
        writer.finish().expect("the shard is finished");
    }
    folder.complete(&|| ()).expect("the card is written");
    place
}

/// The clean dataset.
pub fn whole() -> TempDir {
    write(boards().samples.clone())
}

/// The warnings of the rig's check, which renders: once for each recipe and seed, since they follow from these alone.
fn known_warnings(recipe: &Recipe, seed: u64) -> Vec<RigWarning> {
    static KNOWN: Mutex<BTreeMap<(String, u64), Vec<RigWarning>>> = Mutex::new(BTreeMap::new());
    let key = (recipe.hash(), seed);
    let known = KNOWN.lock().expect("no test holds it").get(&key).cloned();
    known.unwrap_or_else(|| {
        let warnings = rig_warnings(recipe, seed);
        KNOWN.lock().expect("no test holds it").insert(key, warnings.clone());
        warnings
    })
}

/// What validation says, given what the recipe in the folder draws, as `gen validate --rows 0` gives it.
pub fn inspect(root: &Path) -> ValidationReport {
    again(root, |again| compare(root, again))
}

/// Gives `take` the recipe in a folder, to be drawn again.
fn again<T>(root: &Path, take: impl FnOnce(Result<&ExpectedDataset, &str>) -> T) -> T {
    let folder = Dataset::open(root).ok();
    let again = folder
        .as_ref()
        .map_or(Err("no dataset".to_owned()), |folder| ExpectedDataset::with_warnings(folder, known_warnings));
    take(again.as_ref().map_err(String::as_str))
}

/// The same with rows that are exposed again, as many as `gen validate` takes where nobody says how many, for some
/// choices of them.
pub fn inspect_rows(root: &Path, seeds: std::ops::Range<u64>) -> Vec<ValidationReport> {
    let folder = Dataset::open(root).expect("it opens");
    let again = ExpectedDataset::with_warnings(&folder, known_warnings).expect("its recipe loads");
    seeds.map(|seed| compare_rows(root, Ok(&again), again.rows(None, seed))).collect()
}

/// [`inspect`] with a recipe that was read before.
pub fn compare(root: &Path, again: Result<&ExpectedDataset, &str>) -> ValidationReport {
    compare_rows(root, again, None)
}

/// The same with rows that are exposed again.
pub fn compare_rows(root: &Path, again: Result<&ExpectedDataset, &str>, rows: Option<RowChoice>) -> ValidationReport {
    let expect = again.ok().map(|again| |index: u64| again.expected(index));
    let derive = again.ok().map(|again| |index, asked: &AskedRows, take: TakeFrame| again.derived(index, asked, take));
    let options = ValidationOptions {
        rows,
        expect_head: Some(again.map(ExpectedDataset::head)),
        expect: expect.as_ref().map(|expect| expect as Expect),
        derive: derive.as_ref().map(|derive| derive as Derive),
        ..ValidationOptions::default()
    };
    let report = validate(root, &options);
    // Every fault says where it is and what to do.
    assert!(
        report
            .faults
            .iter()
            .all(|f| !f.fault.place.is_empty() && !f.fault.what.is_empty() && f.fault.remedy.len() > 10),
        "{report}"
    );
    report
}

/// Choices of rows that `SABOTAGE_SEEDS` in the environment asks for.
pub fn asked_choices() -> Option<u64> {
    let asked = std::env::var("SABOTAGE_SEEDS").ok()?;
    Some(asked.parse().expect("SABOTAGE_SEEDS is a number"))
}

/// Seeds of fresh choices of rows, from the system's source of chance as in the program.
pub fn fresh(choices: u64) -> Vec<u64> {
    (0..choices).map(|_| RandomState::new().build_hasher().finish()).collect()
}

/// Prints of how many choices a damage is told.
pub fn state(what: &str, told: usize, choices: usize) {
    let thread = std::thread::current();
    println!("share | {} | {what} | {told} | {choices}", thread.name().unwrap_or_default());
}

/// Of how many choices of rows, as many as `gen validate` takes where nobody says how many, the damaged dataset has
/// faults.
pub fn told(root: &Path, again: Result<&ExpectedDataset, &str>, what: &str, seeds: &[u64]) -> usize {
    let rows = |seed| again.ok().and_then(|again| again.rows(None, seed));
    let told = seeds.iter().filter(|seed| !compare_rows(root, again, rows(**seed)).is_clean()).count();
    state(what, told, seeds.len());
    told
}

/// Where a rule without rows tells a damage, every choice of rows does: asked for with `SABOTAGE_SEEDS`.
pub fn always(root: &Path, what: &str) {
    let Some(choices) = asked_choices() else { return };
    let seeds = fresh(choices);
    again(root, |again| assert_eq!(told(root, again, what, &seeds), seeds.len(), "{what}"));
}

/// Asks for exactly these codes and for a word in the place of a fault.
pub fn says(root: &Path, codes: &[Code], place: &str, what: &str) {
    let report = inspect(root);
    let mut codes = codes.to_vec();
    codes.sort_unstable();
    assert_eq!(report.codes(), codes, "{what}:\n{report}");
    assert!(report.faults.iter().any(|found| found.fault.place.contains(place)), "{what}: no `{place}` in\n{report}");
    always(root, what);
}

/// The clean dataset, damaged on the disk.
pub fn after(damage: impl Fn(&Path), codes: &[Code], place: &str, what: &str) {
    let folder = whole();
    damage(folder.path());
    says(folder.path(), codes, place, what);
}

/// The dataset, changed before it was written.
pub fn with(change: impl Fn(&mut Vec<Encoded>), codes: &[Code], place: &str, what: &str) {
    let mut samples = boards().samples.clone();
    change(&mut samples);
    says(write(samples).path(), codes, place, what);
}

/// Changes an image of the row.
pub fn png(sample: &mut Encoded, channel: Channel, mut change: impl FnMut(&mut Vec<u16>)) {
    let place = sample.png.iter().position(|(known, _)| *known == channel).expect("the output asks for it");
    let (cols, _, image) = read_png(&sample.png[place].1).expect("it was just written");
    let mut numbers = image.numbers();
    change(&mut numbers);
    let grey = match image {
        Grey::Eight(_) => Grey::Eight(numbers.iter().map(|&n| n as u8).collect()),
        Grey::Sixteen(_) => Grey::Sixteen(numbers),
    };
    sample.png[place].1 = write_png(&grey, cols as usize);
}

/// Changes channels and text of the EXR file.
pub fn exr(sample: &mut Encoded, change: impl Fn(&mut Vec<ExrChannel>, &mut Value)) {
    let bytes = sample.exr.as_deref().expect("the output asks for it");
    let (cols, _, mut channels, text) = read_exr(bytes).expect("it was just written");
    let mut text = serde_json::from_str(&text).expect("it is JSON");
    change(&mut channels, &mut text);
    sample.exr = Some(write_exr(channels, cols, (sample.col_mm, sample.row_mm), &text));
}

/// Numbers of a channel.
pub fn channel(sample: &Encoded, name: &str) -> Vec<f32> {
    let (_, _, channels, _) = read_exr(sample.exr.as_deref().expect("there")).expect("it was just written");
    channels.iter().find(|channel| channel.name == name).expect("the channel").numbers.clone()
}

/// Gives a sample other labels, and makes every number that is about them right again.
pub fn relabel(sample: &mut Encoded, label: &[u16], instance: &[u16]) {
    if sample.png.iter().any(|(channel, _)| *channel == Channel::Label) {
        png(sample, Channel::Label, |numbers| numbers.copy_from_slice(label));
    }
    exr(sample, |channels, _| {
        for (name, numbers) in [("Label", label), ("Instance", instance)] {
            let channel = channels.iter_mut().find(|channel| channel.name == name).expect("the channel");
            channel.numbers = numbers.iter().map(|&n| n.into()).collect();
        }
    });
    let numbers = |channel| {
        let png = sample.png.iter().find(|(known, _)| *known == channel).expect("the output asks for it");
        read_png(&png.1).expect("it was just written").2.numbers()
    };
    let pixels = numbers(Channel::Range).into_iter().zip(numbers(Channel::Reflectance));
    let own: Vec<(u16, u16)> = label.iter().zip(pixels).filter(|(label, _)| **label > 0).map(|(_, n)| n).collect();
    let measured = own.iter().filter(|(range, _)| *range > 0).count() as f64;
    let saturated = own.iter().filter(|(range, dn)| *range > 0 && *dn == 255).count() as f64;
    (sample.shares.measured, sample.shares.saturated) = (measured / own.len() as f64, saturated / measured);
    sample.class_area_px = [0; Class::ALL.len()];
    label.iter().for_each(|&class| sample.class_area_px[usize::from(class)] += 1);
    let cols = sample.cols;
    let mut shown = Vec::new();
    sample.objects.retain_mut(|object| {
        let own: Vec<(usize, usize)> =
            (0..instance.len()).filter(|&i| instance[i] == object.instance.id).map(|i| (i % cols, i / cols)).collect();
        let ends =
            |side: fn(&(usize, usize)) -> usize| Some((own.iter().map(side).min()?, own.iter().map(side).max()?));
        let (Some((left, right)), Some((top, bottom))) = (ends(|p| p.0), ends(|p| p.1)) else { return false };
        object.area_px = own.len() as u64;
        object.area_mm2 = own.len() as f64 * sample.row_mm * sample.col_mm;
        object.bbox = [left, top, right - left + 1, bottom - top + 1].map(|side| side as u32);
        shown.push(object.instance.class);
        true
    });
    shown.retain(|class| class.is_defect());
    let mut unseen = std::mem::take(&mut sample.defects);
    for class in &shown {
        let place = unseen.iter().position(|known| known == class);
        place.map(|place| unseen.remove(place));
    }
    unseen.append(&mut sample.unseen);
    (sample.defects, sample.unseen) = (shown, unseen);
}

/// Label and instance of each pixel.
pub fn labels(sample: &Encoded) -> [Vec<u16>; 2] {
    ["Label", "Instance"].map(|name| channel(sample, name).iter().map(|&n| n as u16).collect())
}
