//! What numbers become on disk: PNG rounding and saturation, half floats that are exact, attributes in ASCII.

use dataset::{Encoded, ExrChannel, Grey, encode, range_joined, read_exr, read_png, write_exr, write_png};
use optical_bench::settings::{Channel, Output};
use output_schema::SampleType;
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use test_support::records::{SIZE, output, record};

/// A channel of these samples, written and read.
fn exr(samples: SampleType, numbers: &[f32], cols: usize) -> Vec<f32> {
    let channel = ExrChannel { name: "A".into(), samples, numbers: numbers.into() };
    let file = write_exr(vec![channel], cols, (0.04, 0.068), &serde_json::json!({}));
    let read = read_exr(&file).expect("it was just written").2.remove(0);
    assert_eq!(read.samples, samples);
    read.numbers
}

#[test]
fn every_whole_number_survives() {
    let all: Vec<u16> = (0..=u16::MAX).collect();
    let (cols, rows, image) = read_png(&write_png(&Grey::Sixteen(all.clone()), 256)).expect("it was just written");
    assert_eq!((cols, rows, image), (256, 256, Grey::Sixteen(all)));
    let bytes: Vec<u8> = (0..=255).collect();
    let (.., image) = read_png(&write_png(&Grey::Eight(bytes.clone()), 16)).expect("it was just written");
    assert_eq!(image, Grey::Eight(bytes));
    // Digital numbers and labels in half floats, instances in whole numbers, sums in floats.
    for (samples, count, cols) in
        [(SampleType::Half, 2049, 3), (SampleType::Uint, 65_536, 256), (SampleType::Float, 70_000, 700)]
    {
        let numbers: Vec<f32> = (0..count).map(|n| n as f32).collect();
        assert_eq!(exr(samples, &numbers, cols), numbers);
    }
}

#[test]
fn half_floats_are_as_close_as_the_declaration_says() {
    let binned: Vec<f32> = (0..=255 * 64).map(|n| n as f32 / 64.0).collect();
    let read = exr(SampleType::Half, &binned, 1);
    let worst = read.iter().zip(&binned).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst <= 0.0625, "{worst}");
    let angles: Vec<f32> = (-9000..=9000).map(|n| n as f32 / 100.0).collect();
    let read = exr(SampleType::Half, &angles, 1);
    let worst = read.iter().zip(&angles).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst <= 0.032, "{worst} deg");
}

#[test]
fn range_rounds_saturates_and_knows_missing() {
    let output = Output { png: vec![Channel::Range], ..output() };
    let mut sample = record(0, &SIZE, &output);
    let heights = [f32::NAN, -20.0, -500.0, -19.998, -19.9951, 22.0, 400.0];
    sample.maps.range[..heights.len()].copy_from_slice(&heights);
    let sample = encode(sample, &output);
    let (.., image) = read_png(&sample.png[0].1).expect("it was just written");
    // Offset -20 mm, 0.002 mm for each number.
    assert_eq!(image.numbers()[..heights.len()], [0, 1, 1, 1, 2, 21000, 65535]);
    let channels = read_exr(sample.exr.as_deref().expect("the output asks for it")).expect("it was just written").2;
    let range = channels.iter().find(|c| c.name == "Range").expect("the output asks for it").numbers.clone();
    assert!(range[0].is_nan() && range[1] == -20.0 && range[5] == 22.0);
}

/// Heights of all sizes and scales of all finenesses: numbers and what they leave are those of files of everything.
#[test]
fn numbers_and_their_rest_are_range_to_the_last_bit() {
    let whole = Output { png: vec![Channel::Range], exr: vec![Channel::Range], ..output() };
    let lean = Output { exr: vec![], range_rest: true, ..whole.clone() };
    let mut random = SmallRng::seed_from_u64(4);
    for _ in 0..40 {
        let mut sample = record(0, &SIZE, &whole);
        // All that a sensor sees, of 0.5 mm to 2 m, in 32767 steps.
        let (offset, depth) = (random.random_range(-1000.0..1000.0_f64), 0.5 * 4000_f64.powf(random.random()));
        (sample.range_offset, sample.range_scale) = (offset, depth / 32767.0);
        for height in &mut sample.maps.range {
            *height = if random.random_bool(0.1) {
                f32::NAN
            } else {
                (offset + depth * random.random_range(1e-4..1.0)) as f32
            };
        }
        let channel = |sample: &Encoded, name: &str| {
            let channels = read_exr(sample.exr.as_deref().expect("the output asks for it")).expect("it was written").2;
            channels.into_iter().find(|channel| channel.name == name).expect("the output asks for it").numbers
        };
        let (whole, lean) = (encode(sample.clone(), &whole), encode(sample, &lean));
        let (.., numbers) = read_png(&lean.png[0].1).expect("it was just written");
        let rest = channel(&lean, "RangeRest");
        let joined = range_joined(&numbers.numbers(), &rest, SIZE.columns, offset, depth / 32767.0);
        let joined = joined.expect("they are of one image");
        let differs = |(a, b): (&f32, &f32)| a.to_bits() != b.to_bits() && !(a.is_nan() && b.is_nan());
        assert_eq!(joined.iter().zip(&channel(&whole, "Range")).filter(|pair| differs(*pair)).count(), 0, "{depth} mm");
    }
}

#[test]
fn scatter_and_reflectance_saturate() {
    let output = Output { png: vec![Channel::Scatter, Channel::Reflectance], ..output() };
    let mut sample = record(0, &SIZE, &output);
    sample.maps.scatter[..3].copy_from_slice(&[0.4, 65535.4, 80000.0]);
    sample.maps.reflectance[..3].copy_from_slice(&[0.5, 254.4, 255.0]);
    let sample = encode(sample, &output);
    // In the order of columns, whatever the order of asking.
    let names: Vec<Channel> = sample.png.iter().map(|(channel, _)| *channel).collect();
    assert_eq!(names, [Channel::Reflectance, Channel::Scatter]);
    let numbers = |i: usize| read_png(&sample.png[i].1).expect("it was just written").2.numbers();
    assert_eq!(numbers(0)[..3], [1, 254, 255]);
    assert_eq!(numbers(1)[..3], [0, 65535, 65535]);
}

#[test]
fn attributes_are_ascii_and_bytes_repeat() {
    let output = output();
    let sample = encode(record(1, &SIZE, &output), &output);
    let file = sample.exr.clone().expect("the output asks for it");
    let (.., text) = read_exr(&file).expect("it was just written");
    assert!(text.is_ascii(), "{text}");
    let said: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
    assert_eq!((said["class"].as_str(), said["row_mm"].as_f64()), (Some("knöt"), Some(0.068)));
    assert_eq!(said["units"]["Range"], "mm");
    for _ in 0..5 {
        let again = encode(record(1, &SIZE, &output), &output);
        assert!(again.exr == sample.exr && again.png == sample.png, "the bytes of the maps change from run to run");
    }
    assert_ne!(encode(record(2, &SIZE, &output), &output).sha256(), sample.sha256());
}
