//! What encoding costs: `RAYON_NUM_THREADS=1 cargo bench --bench write` for one core. Times by divan; sizes are printed
//! first, in bytes and bytes/pixel.
//!
//! One sample of 2560 x 500 with the noise of a scan: the numbers behind `crates/dataset/src/png.rs`, `exr.rs` and
//! `shard_size.rs`.

use dataset::record::{Below, Record};
use dataset::{
    Dataset, ExrChannel, Grey, encode, estimated_bytes_per_sample, read_exr, read_png, write_exr_as, write_png_as,
};
use divan::Bencher;
use divan::counter::BytesCount;
use exr::prelude::Compression;
use image::codecs::png::{CompressionType, FilterType};
use optical_bench::settings::{Output, SensorStack, Size};
use output_schema::SampleType;
use test_support::records;

const SIZE: Size = Size { columns: 2560, rows: 512, profiles: 500 };
const PIXELS: usize = SIZE.columns * SIZE.profiles;

fn output() -> Output {
    Output { sensor_stack: SensorStack::None, ..records::output() }
}

fn record() -> Record {
    records::record(1, &SIZE, &output())
}

const IMAGES: [&str; 5] = ["range", "reflectance", "scatter", "label", "instance"];

fn grey(name: &str) -> Grey {
    let sample = encode(record(), &output());
    let place = IMAGES.iter().position(|image| *image == name).unwrap_or(0);
    read_png(&sample.png[place].1).expect("it was just written").2
}

const PNG: [(&str, CompressionType, FilterType); 10] = [
    ("none", CompressionType::Uncompressed, FilterType::NoFilter),
    ("fast-none", CompressionType::Fast, FilterType::NoFilter),
    ("fast-sub", CompressionType::Fast, FilterType::Sub),
    ("fast-up", CompressionType::Fast, FilterType::Up),
    ("fast-paeth", CompressionType::Fast, FilterType::Paeth),
    ("fast-adaptive", CompressionType::Fast, FilterType::Adaptive),
    ("level2-none", CompressionType::Level(2), FilterType::NoFilter),
    ("level4-none", CompressionType::Level(4), FilterType::NoFilter),
    ("default-none", CompressionType::Default, FilterType::NoFilter),
    ("default-adaptive", CompressionType::Default, FilterType::Adaptive),
];

const EXR: [(&str, Compression); 5] = [
    ("none", Compression::Uncompressed),
    ("rle", Compression::RLE),
    ("zip1", Compression::ZIP1),
    ("zip16", Compression::ZIP16),
    ("piz", Compression::PIZ),
];

/// Channel of the measured and true maps in one of the three types.
fn channels(name: &str, kind: &str) -> Vec<ExrChannel> {
    let record = record();
    let numbers: Vec<f32> = match name {
        "range" => record.maps.range,
        "reflectance" => record.maps.reflectance,
        "scatter" => record.maps.scatter,
        "label" => record.labels.class.iter().map(|&n| f32::from(n)).collect(),
        _ => record.labels.instance.iter().map(|&n| f32::from(n)).collect(),
    };
    let samples = match kind {
        "f16" => SampleType::Half,
        "f32" => SampleType::Float,
        _ => SampleType::Uint,
    };
    vec![ExrChannel { name: name.into(), samples, numbers }]
}

fn bytes_of(kind: &str) -> usize {
    if kind == "f16" { 2 } else { 4 }
}

const EXR_TYPES: [(&str, &str); 10] = [
    ("range", "f32"),
    ("reflectance", "f16"),
    ("reflectance", "f32"),
    ("scatter", "f16"),
    ("scatter", "f32"),
    ("scatter", "u32"),
    ("label", "f16"),
    ("label", "u32"),
    ("instance", "f32"),
    ("instance", "u32"),
];

/// Whole files: the measured and label channels, with truth maps or without, heights rounded to `2^-step` mm.
fn whole_file(truth: bool, step: Option<i32>) -> Vec<ExrChannel> {
    let record = record();
    let named = |name: &str, of: &str, kind: &str| ExrChannel { name: name.into(), ..channels(of, kind).remove(0) };
    let mut list = vec![
        named("Instance", "instance", "u32"),
        named("Label", "label", "f16"),
        named("Range", "range", "f32"),
        named("Reflectance", "reflectance", "f16"),
        named("Scatter", "scatter", "f32"),
        named("Y", "reflectance", "f16"),
    ];
    if let (true, Some(truth)) = (truth, record.truth) {
        let round = |z: f32| step.map_or(z, |step| (z * 2f32.powi(step)).round() / 2f32.powi(step));
        let map = |name: &str, samples, numbers| ExrChannel { name: name.into(), samples, numbers };
        list.push(map("Height", SampleType::Float, truth.height.into_iter().map(round).collect()));
        if let Below::Fibre { azimuth, dive } = truth.below {
            list.push(map("FibreAzimuth", SampleType::Half, azimuth));
            list.push(map("FibreDive", SampleType::Half, dive));
        }
    }
    list
}

fn sizes() {
    let rate = |bytes: usize| bytes as f64 / PIXELS as f64;
    let whole = encode(record(), &output());
    println!("one sample: {} bytes, estimated {}", whole.bytes(), estimated_bytes_per_sample(&output(), &SIZE));
    let exr = whole.exr.as_deref().map_or(0, <[u8]>::len);
    println!("  its PNG {:?}", whole.png.iter().map(|(_, png)| png.len()).collect::<Vec<_>>());
    println!("  its EXR {exr} bytes, {:.3} bytes/pixel", rate(exr));
    for (truth, step) in [(false, None), (true, None), (true, Some(16)), (true, Some(13)), (true, Some(10))] {
        for (setting, compression) in EXR {
            let (list, start) = (whole_file(truth, step), std::time::Instant::now());
            let file = write_exr_as(list, SIZE.columns, (0.04, 0.068), &serde_json::json!({}), compression);
            let (ms, rate) = (start.elapsed().as_millis(), rate(file.len()));
            println!("whole EXR, truth {truth}, height step {step:?}, {setting:6} {:9} {rate:6.3} {ms} ms", file.len());
        }
    }
    for name in IMAGES {
        let image = grey(name);
        for (setting, compression, filter) in PNG {
            let png = write_png_as(&image, SIZE.columns, compression, filter);
            println!("png {name:12} {setting:17} {:9} {:6.3}", png.len(), rate(png.len()));
        }
    }
    for (name, kind) in EXR_TYPES {
        for (setting, compression) in EXR {
            let description = serde_json::json!({});
            let file = write_exr_as(channels(name, kind), SIZE.columns, (0.04, 0.068), &description, compression);
            assert!(read_exr(&file).is_ok(), "{name} {kind} {setting}");
            println!("exr {name:12} {kind} {setting:6} {:9} {:6.3}", file.len(), rate(file.len()));
        }
    }
}

#[divan::bench(args = IMAGES.iter().flat_map(|i| PNG.iter().map(move |p| (*i, p.0))).map(|(i, p)| format!("{i} \
    {p}")).collect::<Vec<_>>(), sample_count = 5)]
fn png(bencher: Bencher, case: &str) {
    let (name, setting) = case.split_once(' ').unwrap_or((case, ""));
    let image = grey(name);
    let (_, compression, filter) = *PNG.iter().find(|p| p.0 == setting).unwrap_or(&PNG[0]);
    bencher
        .counter(BytesCount::new(PIXELS * usize::from(image.bits() / 8)))
        .bench_local(|| write_png_as(&image, SIZE.columns, compression, filter));
}

#[divan::bench(args = EXR_TYPES.iter().flat_map(|i| EXR.iter().map(move |e| format!("{} {} \
    {}", i.0, i.1, e.0))).collect::<Vec<_>>(), sample_count = 5)]
fn exr(bencher: Bencher, case: &str) {
    let words: Vec<&str> = case.split(' ').collect();
    let compression = EXR.iter().find(|e| e.0 == words[2]).unwrap_or(&EXR[0]).1;
    let description = serde_json::json!({});
    bencher
        .counter(BytesCount::new(PIXELS * bytes_of(words[1])))
        .with_inputs(|| channels(words[0], words[1]))
        .bench_local_values(|c| write_exr_as(c, SIZE.columns, (0.04, 0.068), &description, compression));
}

#[divan::bench(sample_count = 5)]
fn whole_sample(bencher: Bencher) {
    let output = output();
    bencher
        .counter(BytesCount::new(PIXELS * (2 + 1 + 2 + 1 + 2)))
        .with_inputs(record)
        .bench_local_values(|record| encode(record, &output));
}

/// Sensor frames of dark noise through Parquet: ten of 2560 x 512.
fn sensor_frames() {
    let output = Output { png: vec![], exr: vec![], sensor_stack: SensorStack::Every(50), ..records::output() };
    let sample = encode(records::record(0, &SIZE, &output), &output);
    let (frames, pixels) = (sample.stack.len(), sample.stack.len() * SIZE.columns * SIZE.rows);
    let place = tempfile::tempdir().expect("a folder");
    let folder =
        Dataset::open_or_create(place.path(), records::head(&output, &SIZE, 1), false, &|| ()).expect("it opens");
    let mut writer = records::claimed(&folder, 0);
    let start = std::time::Instant::now();
    writer.push(sample).expect("it is written");
    let manifest = writer.finish().expect("it is finished");
    let seconds = start.elapsed().as_secs_f64();
    let bytes = manifest.files.iter().find(|file| file.path.starts_with("stacks")).map_or(0, |file| file.bytes);
    let rate = bytes as f64 / pixels as f64;
    println!("{frames} sensor frames: {bytes} bytes, {rate:.3} bytes/pixel, {:.0} MB/s", pixels as f64 / 1e6 / seconds);
}

fn main() {
    if std::env::args().any(|arg| arg == "--bench") {
        sizes();
        sensor_frames();
    }
    divan::main();
}
