//! The recipes of the thesis, cut small: its scripts make datasets as the instrument does.

use parquet::record::Field;
use test_support::program::{Place, assert_same, rows, tree};

/// A recipe of the thesis with pieces of its text replaced.
fn place(text: &str, changes: &[[&str; 2]]) -> Place {
    let mut text = text.to_owned();
    for [old, new] in changes {
        assert_eq!(text.matches(old).count(), 1, "`{old}` is not once in the recipe");
        text = text.replacen(old, new, 1);
    }
    let place = Place::new();
    place.write("tiny.yaml", text);
    place
}

/// Columns of the scans, and rows that lie below the conveyor and see no light.
const COLUMNS: usize = 128;
const DARK: std::ops::Range<usize> = 600..832;

/// Mean and standard deviation of the dark rows of the two frames kept [DN].
fn dark(place: &Place) -> [f64; 2] {
    let mut numbers = Vec::new();
    for name in tree(&place.path("one/stacks")).keys() {
        for row in rows(&place.path("one/stacks").join(name)) {
            let frame = row.iter().find(|(name, _)| name.starts_with("frame")).expect("a frame").1;
            let Field::ListInternal(frame) = frame else { panic!("a frame is {frame:?}") };
            let number = |dn: &Field| match dn {
                Field::UByte(dn) => f64::from(*dn),
                other => panic!("a number is {other:?}"),
            };
            let all: Vec<f64> = frame.elements().iter().map(number).collect();
            numbers.extend_from_slice(&all[DARK.start * COLUMNS..DARK.end * COLUMNS]);
        }
    }
    let n = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / n;
    [mean, (numbers.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()]
}

/// One thread and two make the same files, `gen validate` renders them again to the byte, maps have the object in them,
/// and rows without light are the thesis' noise, under its pattern where the pattern comes last.
#[test]
fn orders_of_the_thesis_make_datasets() {
    let stack = ["\noutput:\n", "\noutput:\n  sensor_stack: {every: 4}\n"];
    let wood = place(
        include_str!("../../recipes/thesis/wood.yaml"),
        &[["columns: 2560, profiles: 4000", "columns: 128, profiles: 8"], ["lead_in_mm: 28", "lead_in_mm: 0.1"], stack],
    );
    let sawtooth = place(
        include_str!("../../recipes/thesis/sawtooth.yaml"),
        &[
            ["columns: 2560, profiles: 400}", "columns: 128, profiles: 8}"],
            ["lead_in_mm: 1}", "lead_in_mm: 0.1}"],
            ["order: blur_speckle_noise", "order: noise_speckle"],
            ["  blur_radius_px: 0.5\n", ""],
            stack,
        ],
    );
    for (place, pattern, bright) in [(wood, false, 40), (sawtooth, true, 100)] {
        place.make("one", "--n 1 --threads 1");
        place.make("two", "--n 1 --threads 2");
        assert_same(&place.tree("one"), &place.tree("two"), "2 threads");
        place.done("validate one --rerender 1");
        let (columns, profiles, light) = place.samples("one")[&0].image("reflectance");
        assert_eq!((columns as usize, profiles), (COLUMNS, 8));
        let lit = light.iter().filter(|dn| **dn > bright).count();
        assert!(lit > light.len() / 2, "{lit} of {} pixels are lit", light.len());
        let [mean, spread] = dark(&place);
        println!("dark {mean:.3} and {spread:.3} DN");
        if pattern {
            // Times 3.5 and a pattern whose contrast in a pixel is 0.191, known to 2 %; its mean over these rows is
            // known to 0.191 sqrt(1.5 / 29 696), four of which.
            let own = 1.09f64 * 1.09 - 1.0 / 12.0;
            let variance = 12.25 * (own * (1.0 + 0.191 * 0.191) + (11.6 * 0.191f64).powi(2)) + 1.0 / 12.0;
            let expected = variance.sqrt();
            assert!((mean - 40.6).abs() < 0.25 && (spread / expected - 1.0).abs() < 0.03, "{mean} {spread} {expected}");
        } else {
            // 59 392 pixels: errors 0.0045 and 0.0032, four of which.
            assert!((mean - 11.6).abs() < 0.018 && (spread - 1.09).abs() < 0.013, "{mean} {spread}");
        }
    }
}
