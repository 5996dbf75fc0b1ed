//! Forgeries that are consistent in themselves: images, channels, sums and manifests agree, and only what the recipe
//! measures says otherwise. What is forged as a whole is always told; of a part as often as the rows promise that are
//! exposed again.

use base::Stream;
use dataset::validate::Code::ProfileDiffers;
use dataset::validate::{RowChoice, ValidationReport};
use dataset::{Dataset, Encoded, range_numbers, read_exr, read_png};
use optical_bench::settings::Channel;
use output_schema::DatasetHead;
use rand::RngExt;
use sheetlight::generate::ExpectedDataset;
use tempfile::TempDir;

use super::place::{asked_choices, compare_rows, exr, fresh, of_recipe, png, state, told, write_as};
use test_support::program::{FRAMES, mesh_recipe, pack_recipe, recipe, sawtooth_recipe};

/// A change of a map `[rows, cols]` of so many columns; the same map of another sample.
type Change = fn(&mut Vec<f32>, usize, &[f32]);

/// A change of the sensor frames of some samples.
type FrameChange = fn(&mut [Encoded]);

/// Changes of whole maps.
const WHOLE: [(&str, Change); 8] = [
    ("rolled by a column", |map, cols, _| map.chunks_mut(cols).for_each(|line| line.rotate_right(1))),
    ("rolled by a row", |map, cols, _| map.rotate_right(cols)),
    ("rolled by half", |map, cols, _| {
        let rows = map.len() / cols;
        map.rotate_right(rows / 2 * cols);
    }),
    ("mirrored", |map, cols, _| map.chunks_mut(cols).for_each(<[f32]>::reverse)),
    ("turned", |map, _, _| map.reverse()),
    ("of another sample", |map, _, other| map.copy_from_slice(other)),
    ("brighter", |map, _, _| {
        map.iter_mut().filter(|v| !v.is_nan()).for_each(|v| *v = (*v * 1.1).round().min(250.0));
    }),
    ("noisier", |map, _, _| {
        let mut rng = Stream::root(4).child("forgery").rng();
        map.iter_mut().filter(|v| **v > 2.0 && **v < 250.0).for_each(|v| *v += rng.random_range(-1..=1) as f32);
    }),
];

/// Changes of a part of a map.
const PART: [(&str, Change); 3] = [
    ("a block lost", |map, cols, _| {
        let rows = map.len() / cols;
        map[rows / 2 * cols..(rows / 2 + rows / 4) * cols].fill(f32::NAN);
    }),
    ("every tenth row darker", |map, cols, _| {
        let lines = map.chunks_mut(cols).step_by(10);
        lines.flatten().filter(|v| **v > 2.0).for_each(|v| *v -= 1.0);
    }),
    ("a pixel", |map, cols, _| {
        let middle = map.len() / 2 + cols / 2;
        map[middle] = if map[middle] > 2.0 { map[middle] - 1.0 } else { 7.0 };
    }),
];

/// A dataset of one subject, and what its recipe expects.
struct Subject {
    name: &'static str,
    head: DatasetHead,
    samples: Vec<Encoded>,
    expected: ExpectedDataset,
    _place: TempDir,
}

/// Choices of rows with which a forgery of whole maps is validated where nobody asks for more.
const FEW: u64 = 2;

/// The small recipe of each subject, changed.
fn subjects(changes: &[[&str; 2]]) -> Vec<Subject> {
    let texts = [
        ("wood", recipe(changes)),
        ("blister", pack_recipe(changes)),
        ("sawtooth", sawtooth_recipe(changes)),
        ("mesh", mesh_recipe(changes)),
    ];
    texts.into_iter().map(|(name, text)| Subject::of(name, &text)).collect()
}

/// A small recipe with lamps, whose map is in tables and EXR files.
fn lamplit(text: &str) -> String {
    let text = text.replacen("scatter, label]", "scatter, label, grey]", 1).replacen("instance]", "instance, grey]", 1);
    format!("{text}\nlamps: {{number: two, fill: 0.2}}\n")
}

impl Subject {
    /// Of a recipe.
    fn of(name: &'static str, text: &str) -> Self {
        let (head, samples) = of_recipe(text, 3);
        let place = write_as(head.clone(), samples.clone());
        let expected = ExpectedDataset::of(&Dataset::open(place.path()).expect("it opens")).expect("its recipe loads");
        Self { name, head, samples, expected, _place: place }
    }

    /// What validation says of forged samples: without rows, and with some that are exposed again.
    fn reports(&self, forged: Vec<Encoded>, rows: RowChoice) -> [ValidationReport; 2] {
        let place = write_as(self.head.clone(), forged);
        [None, Some(rows)].map(|rows| compare_rows(place.path(), Ok(&self.expected), rows))
    }

    /// The rows that the program takes where nobody says how many.
    fn usual(&self, seed: u64) -> RowChoice {
        self.expected.rows(None, seed).expect("the kernel is quick")
    }

    /// Whether every row of a map of the first sample is another one.
    fn is_whole(&self, forged: &[Encoded], name: &str) -> bool {
        let [own, other] = [&self.samples[0], &forged[0]].map(|sample| numbers(sample, name));
        let bits = |line: &[f32]| line.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        own.chunks(self.samples[0].cols).zip(other.chunks(self.samples[0].cols)).all(|(a, b)| bits(a) != bits(b))
    }
}

/// Numbers of a channel of the EXR file.
fn numbers(sample: &Encoded, name: &str) -> Vec<f32> {
    let (_, _, channels, _) = read_exr(sample.exr.as_deref().expect("there")).expect("it was just written");
    channels.iter().find(|channel| channel.name == name).expect("the channel").numbers.clone()
}

/// Changes a map of a sample in the EXR file and in the image that repeats it.
fn forge(sample: &mut Encoded, name: &str, change: Change, other: &Encoded) {
    let (cols, other) = (sample.cols, numbers(other, name));
    let before = numbers(sample, name);
    let mut map = before.clone();
    change(&mut map, cols, &other);
    exr(sample, |channels, _| {
        for channel in channels.iter_mut().filter(|c| c.name == name || (name == "Reflectance" && c.name == "Y")) {
            // The picture for viewers has no missing pixels.
            let missing = if channel.name == "Y" { 0.0 } else { f32::NAN };
            channel.numbers = map.iter().map(|v| if v.is_nan() { missing } else { *v }).collect();
        }
    });
    let scale = [sample.range_offset, sample.range_scale];
    let image = match name {
        "Range" => Some((Channel::Range, range_numbers(&map, scale[0], scale[1]))),
        "Reflectance" => Some((Channel::Reflectance, map.iter().map(|v| v.round() as u16).collect())),
        "Scatter" => Some((Channel::Scatter, map.iter().map(|v| v.round() as u16).collect())),
        "Grey" => Some((Channel::Grey, map.iter().map(|v| v.round() as u16).collect())),
        _ => None,
    };
    if let Some((channel, numbers)) = image {
        // Channels are rounded too: what stays in them stays in the image.
        let changed = |i: &usize| map[*i].to_bits() != before[*i].to_bits();
        png(sample, channel, |own| (0..own.len()).filter(changed).for_each(|i| own[i] = numbers[i]));
    }
}

const MEASURED: [&str; 3] = ["Range", "Reflectance", "Scatter"];
const TRUTH: [&str; 5] = ["FibreAzimuth", "FibreDive", "FilmGap", "FilmThickness", "Height"];

#[test]
#[ignore = "long"]
fn whole_maps_are_always_told() {
    let seeds = fresh(asked_choices().unwrap_or(FEW));
    let (mut tried, mut before, mut silent) = (0, 0, Vec::new());
    for subject in subjects(&[]) {
        let own: Vec<&str> = subject.head.channels().iter().map(|channel| channel.name).collect();
        let maps = MEASURED.iter().chain(&TRUTH).filter(|name| own.contains(name));
        for name in maps {
            for (what, change) in WHOLE {
                let mut forged = subject.samples.clone();
                let (first, others) = forged.split_at_mut(1);
                forge(&mut first[0], name, change, &others[0]);
                // Maps without structure of a piece that is level along the scan are the same in another row.
                if !subject.is_whole(&forged, name) {
                    continue;
                }
                let place = write_as(subject.head.clone(), forged);
                let (root, again) = (place.path(), Ok(&subject.expected));
                tried += 1;
                before += usize::from(!compare_rows(root, again, None).is_clean());
                let what = format!("{name} {what}, {}", subject.name);
                if told(root, again, &what, &seeds) < seeds.len() {
                    silent.push(what);
                }
            }
        }
    }
    println!(
        "{tried} forgeries of whole maps: {before} told without exposing rows again, {} silent with",
        silent.len()
    );
    assert!(tried >= 100 && before < tried && silent.is_empty(), "{silent:#?}");
}

#[test]
#[ignore = "long"]
fn sensor_frames_are_told() {
    let changes: [(&str, FrameChange); 4] = [
        ("of another sample", |samples| {
            let frames = samples[1].stack.clone();
            samples[0].stack.iter_mut().zip(frames).for_each(|(own, other)| own.dn = other.dn);
            samples[1].stack.iter_mut().for_each(|frame| frame.dn.reverse());
        }),
        ("turned", |samples| samples[0].stack.iter_mut().for_each(|frame| frame.dn.reverse())),
        ("one number brighter in one pixel", |samples| {
            samples[0].stack.iter_mut().for_each(|frame| frame.dn[77] = frame.dn[77].saturating_add(1));
        }),
        ("in another order", |samples| {
            let frames: Vec<Vec<u16>> = samples[0].stack.iter().map(|frame| frame.dn.clone()).collect();
            let last = frames.len() - 1;
            samples[0]
                .stack
                .iter_mut()
                .enumerate()
                .for_each(|(i, own)| own.dn = frames[(i + last) % (last + 1)].clone());
        }),
    ];
    for subject in subjects(&[FRAMES]) {
        for (what, change) in changes {
            let mut forged = subject.samples.clone();
            change(&mut forged);
            let [old, new] = subject.reports(forged, subject.usual(1));
            let fault = new.faults.iter().find(|found| found.fault.place == "stacks/00000.parquet, sample 0");
            let fault = fault.unwrap_or_else(|| panic!("{}, frames {what}:\n{new}", subject.name));
            assert!(old.is_clean() && fault.code == ProfileDiffers, "{}, frames {what}: {old}\n{new}", subject.name);
            for word in ["the sensor frame of profile", "sensor row", "column", "exposed again"] {
                assert!(fault.fault.what.contains(word), "no `{word}` in {}", fault.fault.what);
            }
        }
    }
}

/// Forgeries of parts are told as often as promised, or more: by `places` of a sample, over 20 choices of rows, within
/// 4 standard errors.
#[test]
#[ignore = "long"]
fn parts_are_told_as_often_as_promised() {
    let seeds: Vec<u64> = (0..20).collect();
    for subject in subjects(&[]) {
        for (what, change) in PART {
            let mut forged = subject.samples.clone();
            let (first, others) = forged.split_at_mut(1);
            MEASURED.iter().for_each(|name| forge(&mut first[0], name, change, &others[0]));
            let cols = forged[0].cols;
            let maps = [&subject.samples[0], &forged[0]].map(|sample| numbers(sample, "Reflectance"));
            let lines = maps[0].chunks(cols).zip(maps[1].chunks(cols));
            let other = lines.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.to_bits() != b.to_bits())).count();
            let share = other as f64 / forged[0].rows as f64;
            let place = write_as(subject.head.clone(), forged);
            // More places are the same rule for every subject.
            let places = if subject.name == "wood" { [1, 4].as_slice() } else { &[1] };
            for &places in places {
                let report = |seed: &u64| {
                    let rows = RowChoice { places, ..subject.usual(*seed) };
                    compare_rows(place.path(), Ok(&subject.expected), Some(rows))
                };
                let reports: Vec<ValidationReport> = seeds.iter().map(report).collect();
                let what = format!("{what}, {share:.3} of the rows, {places} places, {}", subject.name);
                state(&what, reports.iter().filter(|report| !report.is_clean()).count(), seeds.len());
                let of_rows = reports.iter().filter(|report| report.codes().contains(&ProfileDiffers)).count();
                let told = of_rows as f64 / seeds.len() as f64;
                let promised = 1.0 - (1.0 - share).powi(places as i32);
                let error = (promised * (1.0 - promised) / seeds.len() as f64).sqrt();
                assert!(told >= promised - 4.0 * error, "{what}: promised {promised}, told {told}");
            }
        }
    }
}

/// Forgeries of the whole map under lamps are told; nothing is of the map as it is.
#[test]
fn light_of_lamps_is_exposed_again() {
    for (name, text) in [("wood", recipe(&[])), ("sawtooth", sawtooth_recipe(&[])), ("mesh", mesh_recipe(&[]))] {
        let subject = Subject::of(name, &lamplit(&text));
        let [old, new] = subject.reports(subject.samples.clone(), subject.usual(1));
        assert!(old.is_clean() && new.is_clean(), "{name}: {old}\n{new}");
        for (what, change) in WHOLE {
            let mut forged = subject.samples.clone();
            let (first, others) = forged.split_at_mut(1);
            forge(&mut first[0], "Grey", change, &others[0]);
            if subject.is_whole(&forged, "Grey") {
                let [_, new] = subject.reports(forged, subject.usual(1));
                let fault = new.faults.iter().find(|found| found.code == ProfileDiffers);
                let told = fault.is_some_and(|found| found.fault.what.contains("of `grey`"));
                assert!(told, "{name}, grey {what}:\n{new}");
            }
        }
    }
}

/// What is told says where: sample, rows, map, column, the number on disk and the one that is made.
#[test]
fn faults_say_where() {
    let subject = subjects(&[]).swap_remove(0);
    let mut forged = subject.samples.clone();
    let (first, others) = forged.split_at_mut(1);
    forge(&mut first[0], "Scatter", |map, _, _| map.iter_mut().for_each(|v| *v += 1.0), &others[0]);
    let made = read_png(&subject.samples[0].png[2].1).expect("an image").2.numbers();
    let rows = RowChoice { places: 1, strip: 8, frames: 1, seed: 3 };
    let strip = rows.of(&subject.head, 0).strips.remove(0);
    let [old, new] = subject.reports(forged, rows);
    assert!(old.is_clean() && new.codes() == [ProfileDiffers] && new.faults.len() == 1, "{old}\n{new}");
    let fault = &new.faults[0].fault;
    assert!(fault.place.starts_with("data/") && fault.place.ends_with("sample 0"), "{}", fault.place);
    let cols = subject.samples[0].cols;
    let lit = (strip.start * cols..strip.end * cols).filter(|&i| made[i] > 0);
    let i = lit.min().expect("light");
    let place = format!("`scatter`, row {}, column {}", i / cols, i % cols);
    let first = format!("{place} is {}, exposed again {}", made[i] + 1, made[i]);
    for word in [" of `scatter`, ", " of Scatter; ", &first] {
        assert!(fault.what.contains(word), "no `{word}` in {}", fault.what);
    }
}
