//! Datasets of 10 and 12 bits as their users meet them: written, found whole, read back, compared; refused where 8 are
//! needed.

use parquet::record::Field;
use serde_json::Value;
use test_support::program::{FRAMES, Place, rows, tree};

/// A dataset of two small boards and their sensor frames.
fn planks(bits: u32) -> Place {
    let key = format!("\nexposure:\n  bits: {bits}");
    // The dark level that is asked for below, in both samples.
    let drawn = "dark_level_dn: {truncated: {of: {normal: {mean: 11.6, sd: 0.6}}, min: 9, max: 14}}";
    let place = Place::with(&[FRAMES, ["\nexposure:", &key], [drawn, "dark_level_dn: 11.6"]]);
    place.make("planks", "--n 2");
    place
}

/// Digital numbers of every frame kept, and the width of their column.
fn frames(place: &Place) -> Vec<u16> {
    let mut all = Vec::new();
    for name in tree(&place.path("planks/stacks")).keys() {
        for row in rows(&place.path("planks/stacks").join(name)) {
            let frame = row.iter().find(|(name, _)| name.starts_with("frame")).expect("a frame").1;
            let Field::ListInternal(frame) = frame else { panic!("a frame is {frame:?}") };
            all.extend(frame.elements().iter().map(|dn| match dn {
                Field::UShort(dn) => *dn,
                other => panic!("a number is {other:?}"),
            }));
        }
    }
    all
}

/// All that is written counts in the converter's own numbers, dark at 11.6 / 255 of its range; what reads it knows.
#[test]
fn wide_numbers_go_all_the_way() {
    let eight = planks(8);
    for (bits, most) in [(10, 1023u16), (12, 4095)] {
        let place = planks(bits);
        place.done("validate planks --rerender 1");
        let scale = f64::from(most) / 255.0;

        let frames = frames(&place);
        let brightest = frames.iter().copied().max().expect("frames are kept");
        assert!(brightest > 255 && brightest <= most, "{bits} bits: {brightest}");
        // The median pixel is dark: known to a step, within the rows' 0.2 DN of 8 bits.
        let mut dark = frames;
        dark.sort_unstable();
        let median = f64::from(dark[dark.len() / 2]);
        assert!((median - 11.6 * scale).abs() < 0.5 + 0.1 * scale, "{bits} bits: dark at {median}");

        for (index, sample) in place.samples("planks") {
            let (_, _, image) = sample.image("reflectance");
            let read = dataset::read_exr(&sample.exr).expect("it is whole");
            let said: Value = serde_json::from_str(&read.3).expect("it is JSON");
            assert_eq!((said["index"].as_i64(), said["bits"].as_u64()), (Some(index), Some(bits.into())));
            let channel = read.2.iter().find(|channel| channel.name == "Reflectance").expect("it has light");
            // Halves would be off by one above 2048.
            for (i, (dn, exact)) in image.iter().zip(channel.numbers.iter().copied()).enumerate() {
                let exact = if exact.is_nan() { 0.0 } else { exact };
                assert!((f32::from(*dn) - exact).abs() <= 0.5, "{bits} bits, pixel {i}: {dn} and {exact}");
            }
            assert!(image.iter().any(|&dn| dn > 255) && image.iter().all(|&dn| dn <= most), "{bits} bits");
        }

        // Comparison counts all of them on the scale of 8 bits: the same boards are as bright, to a step of these.
        let other = eight.path("planks");
        let run = place.done(&format!("compare planks {} --json", other.display()));
        let both: Value = serde_json::from_str(&run.out).expect("it prints JSON");
        let apart = both["distances"]["reflectance_dn"]["wasserstein"].as_f64().expect("it is a number");
        assert!(apart < 1.0, "{bits} bits: {apart} DN apart");
        assert_eq!(both["sim"]["scans"], both["real"]["scans"]);

        for arguments in ["export icon planks --out a", "export icon planks --out a --sensor"] {
            let run = place.run(arguments);
            let words = [format!("{bits} bits"), "exposure: {bits: 8}".to_owned()];
            assert!(run.code != 0 && words.iter().all(|words| run.err.contains(words)), "{}", run.err);
        }
        assert!(!place.path("a").exists());
    }
}
