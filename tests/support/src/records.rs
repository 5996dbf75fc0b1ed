//! Synthetic records with the statistics of a scan: a board with noise, knots, missing columns and sensor frames.

use std::path::Path;

use base::{Class, Instance};
use dataset::record::{Below, Labels, Maps, Object, Record, StackFrame, TruthMaps};
use dataset::{Claim, Dataset, Encoded, ShardWriter, encode, images};
use optical_bench::settings::{Channel, Output, RangeForm, SensorStack, Size};
use optical_bench::split::{SampleGroups, Split};
use output_schema::row::CALIBRATION;
use output_schema::{
    DatasetHead, FORMAT, Generator, NumberColumn, RecipeHead, SCHEMA_VERSION, SUBJECTS, SplitShares, label_values,
    pixel_classes,
};

/// Images of the tests: small, and not square.
pub const SIZE: Size = Size { columns: 48, rows: 20, profiles: 32 };
/// Seed of the tests: larger than any signed number.
pub const SEED: u64 = u64::MAX - 1;
/// Millimetres for each range number.
pub const SCALE_MM: f64 = 0.002;

/// Every image, truth map and kind of file.
pub fn output() -> Output {
    let all = vec![Channel::Range, Channel::Reflectance, Channel::Scatter, Channel::Label, Channel::Instance];
    Output {
        bin_columns: 1,
        bin_profiles: 1,
        png: all.clone(),
        exr: all,
        range_rest: false,
        truth_maps: true,
        sensor_stack: SensorStack::Every(8),
        samples_per_shard: Some(4),
        bits: 8,
    }
}

/// A head with two groups of drawn numbers.
pub fn head(output: &Output, size: &Size, samples: u64) -> DatasetHead {
    let per_shard = output.samples_per_shard.unwrap_or(4) as u64;
    DatasetHead {
        format: FORMAT.into(),
        schema_version: SCHEMA_VERSION,
        generator: Generator { name: "sheetlight".into(), version: "0.1.0".into() },
        target: "x86_64-unknown-linux-gnu".into(),
        recipe: RecipeHead {
            name: "knots: a \"test\"".into(),
            text: "name: knots\nlaser: { power_mw: 50 }\n".into(),
            hash: "5f".repeat(32),
            canonical: serde_json::json!({ "laser": { "power_mw": 50.0 }, "board": { "width_mm": 94.0 } }),
        },
        assets: Vec::new(),
        seed: SEED,
        samples,
        samples_per_shard: per_shard,
        shards: DatasetHead::shards_for(samples, per_shard),
        classes: vec!["clear".into(), "knöt".into()],
        subject: "wood".into(),
        pixel_classes: pixel_classes(SUBJECTS[0], SCHEMA_VERSION[1]),
        label_values: label_values(SUBJECTS[0], SCHEMA_VERSION[1]),
        splits: SplitShares { train: 0.5, validation: 0.25, test: 0.25 },
        images: images(output, size, RangeForm::Calibrated),
        parameters: vec![
            NumberColumn::new("laser", "power_mw", "Optical power of the whole line."),
            NumberColumn::new("laser", "wavelength_nm", "Wavelength in vacuum."),
            NumberColumn::new("board", "width_mm", "Width along the laser line."),
        ],
        physics: vec![NumberColumn::new("", "mu_eff_per_mm", "Effective attenuation of clear wood.")],
        warnings: Vec::new(),
    }
}

/// Numbers without pattern, the same in every run.
pub struct Noise(u64);

impl Noise {
    /// The numbers of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xD1B5_4A32_D192_ED03)
    }

    /// Even in [0, 1).
    pub fn even(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Nearly normal, standard deviation 1.
    pub fn normal(&mut self) -> f32 {
        ((0..12).map(|_| self.even()).sum::<f32>() - 6.0).clamp(-5.0, 5.0)
    }
}

/// The sample `index`.
pub fn record(index: u64, size: &Size, output: &Output) -> Record {
    let (cols, rows) = (size.columns / output.bin_columns, size.profiles / output.bin_profiles);
    let mut noise = Noise::new(index);
    let (mut maps, mut labels) = (Maps::default(), Labels::default());
    let (mut heights, mut azimuth, mut dive) = (Vec::new(), Vec::new(), Vec::new());
    let radius = rows as f32 / 5.0;
    let centres = [(cols as f32 * 0.35, rows as f32 * 0.4, 1u16), (cols as f32 * 0.7, rows as f32 * 0.6, 2)];
    for y in 0..rows {
        for x in 0..cols {
            let (fx, fy) = (x as f32, y as f32);
            let on_board = x >= cols / 12 && x < cols - cols / 10;
            let knot = centres.iter().find(|c| (fx - c.0).hypot((fy - c.1) * 1.5) < radius);
            let class = match knot {
                _ if !on_board => Class::Background,
                Some((.., 1)) => Class::SoundKnot,
                Some(_) => Class::DeadKnot,
                None => Class::Clear,
            };
            let seen = on_board && noise.even() > 0.002;
            let height = 22.0 + 0.3 * (fx / cols as f32 * 3.0).sin() + 0.02 * (fy * 0.11).sin();
            let dark = if knot.is_some() { 0.5 } else { 1.0 };
            let ring = 1.0 + 0.2 * (fx * 0.13 + 0.02 * fy).sin();
            // Range as a camera gives it: steps of 1/16 row, about 0.006 mm.
            let range = ((height + 0.02 * noise.normal()) / 0.006).round() * 0.006;
            maps.range.push(if seen { range } else { f32::NAN });
            let dn = (110.0 * dark * ring * (1.0 + 0.15 * noise.normal())).round().clamp(12.0, 255.0);
            maps.reflectance.push(if seen { dn } else { 0.0 });
            let scatter = (320.0 * dark * ring + 18.0 * noise.normal()).round().max(0.0);
            maps.scatter.push(if seen { scatter } else { 0.0 });
            labels.class.push(class as u8);
            labels.instance.push(if on_board { knot.map_or(0, |knot| knot.2) } else { 0 });
            heights.push(if on_board { height } else { f32::NAN });
            azimuth.push(if on_board { 3.0 * (fy * 0.05 + fx * 0.01).sin() } else { f32::NAN });
            dive.push(if on_board { 2.0 + ring } else { f32::NAN });
        }
    }
    let frame = |profile: usize| StackFrame {
        profile: profile as u32,
        dn: (0..size.columns * size.rows).map(|_| (11.6 + 1.09 * noise.normal()).round() as u16).collect(),
    };
    let stack = match output.sensor_stack {
        SensorStack::None => Vec::new(),
        SensorStack::Every(step) => (0..size.profiles).step_by(step).map(frame).collect(),
        SensorStack::All => (0..size.profiles).map(frame).collect(),
    };
    Record {
        index,
        id: format!("00000000-0000-5000-8000-{index:012x}"),
        split: [Split::Train, Split::Validation, Split::Train, Split::Test][(index % 4) as usize],
        groups: SampleGroups { rig: index % 3, log: Some(index / 2), batch: None },
        class: if index.is_multiple_of(2) { "clear".into() } else { "knöt".into() },
        cols,
        rows,
        row_mm: 0.068 * output.bin_profiles as f64,
        col_mm: 0.04 * output.bin_columns as f64,
        range_offset: -20.0,
        range_scale: SCALE_MM,
        sensor_rows: size.rows,
        calibration: CALIBRATION
            .iter()
            .map(|field| (field.name, if field.missing == "never" { 1.0 } else { f64::NAN }))
            .collect(),
        draws: [("laser.power_mw", 50.0 + index as f64), ("laser.wavelength_nm", 660.0), ("board.width_mm", 94.0)]
            .map(|(path, value)| (path.to_string(), value))
            .to_vec(),
        physics: vec![("mu_eff_per_mm", 0.7)],
        objects: objects(&labels, cols),
        defects: objects(&labels, cols).iter().map(|object| object.instance.class).collect(),
        unseen: vec![Class::Pith],
        object_in_view: 0.75 + 0.01 * index as f64,
        maps,
        labels,
        truth: output.truth_maps.then_some(TruthMaps { height: heights, below: Below::Fibre { azimuth, dive } }),
        stack,
        ..Record::default()
    }
}

/// What the labels show, as objects.
fn objects(labels: &Labels, cols: usize) -> Vec<Object> {
    let mut objects = Vec::new();
    for id in 1..=2u16 {
        let pixels: Vec<usize> = (0..labels.instance.len()).filter(|&i| labels.instance[i] == id).collect();
        let x = |i: &usize| (i % cols) as u32;
        let y = |i: &usize| (i / cols) as u32;
        let (Some(left), Some(right)) = (pixels.iter().map(x).min(), pixels.iter().map(x).max()) else { continue };
        let (top, bottom) = (y(&pixels[0]), y(&pixels[pixels.len() - 1]));
        let class = if id == 1 { Class::SoundKnot } else { Class::DeadKnot };
        let death_radius_mm = if id == 1 { f64::NAN } else { 31.5 };
        objects.push(Object {
            instance: Instance {
                id,
                class,
                state: class,
                within: 0,
                x_mm: 1.0,
                y_mm: 2.0,
                diameter_mm: 12.0,
                dive_deg: 70.0,
                death_radius_mm,
                severity: f64::NAN,
                depth_mm: f64::NAN,
                knot: None,
            },
            area_px: pixels.len() as u64,
            area_mm2: pixels.len() as f64 * 0.068 * 0.04,
            bbox: [left, top, right - left + 1, bottom - top + 1],
            extent_mm: [f64::from(bottom - top + 1) * 0.068, f64::from(right - left + 1) * 0.04],
        });
    }
    objects
}

/// The sample as it goes to disk.
pub fn encoded(index: u64, output: &Output) -> Encoded {
    encode(record(index, &SIZE, output), output)
}

/// The shard of a claim, which is free.
pub fn granted(claim: Claim) -> ShardWriter {
    match claim {
        Claim::Granted(writer) => *writer,
        other => panic!("the shard is not free: {other:?}"),
    }
}

/// Takes a shard that is free.
pub fn claimed(folder: &Dataset, shard: u64) -> ShardWriter {
    granted(ShardWriter::claim(folder, shard).expect("the folder can be written"))
}

/// Writes one shard.
pub fn write_shard(folder: &Dataset, shard: u64, output: &Output) {
    let mut writer = claimed(folder, shard);
    let (first, count) = writer.span();
    for index in first..first + count {
        writer.push(encoded(index, output)).expect("the sample can be written");
    }
    writer.finish().expect("the shard can be finished");
}

/// Writes a whole dataset of `samples` samples.
pub fn write_dataset(path: &Path, samples: u64, output: &Output) -> Dataset {
    let folder =
        Dataset::open_or_create(path, head(output, &SIZE, samples), false, &|| ()).expect("the folder can be opened");
    for shard in folder.remaining(0..folder.head().shards).expect("they can be read") {
        write_shard(&folder, shard, output);
    }
    folder.complete(&|| ()).expect("the card can be written");
    folder
}

/// Every file below `root` with its bytes, by path.
pub fn tree(root: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    let mut folders = vec![root.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("the folder can be listed").flatten() {
            if entry.path().is_dir() {
                folders.push(entry.path());
            } else {
                let name = entry.path().strip_prefix(root).expect("it is below").to_string_lossy().into_owned();
                files.push((name, std::fs::read(entry.path()).expect("it can be read")));
            }
        }
    }
    files.sort();
    files
}
