//! The recipes of the thesis, cut small: its scripts make datasets as the instrument does.

mod gen_support;

use gen_support::{Place, assert_same, rows, tree};
use parquet::record::Field;

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

/// Mean and standard deviation of the darkest half of all rows kept, of which none sees the line [DN].
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
            let mut lines: Vec<_> = all.chunks(128).collect();
            lines.sort_by(|a, b| a.iter().sum::<f64>().total_cmp(&b.iter().sum()));
            // Away from both ends, so that sorting does not change the mean.
            numbers.extend(lines[50..450].iter().flat_map(|line| line.iter().copied()));
        }
    }
    let n = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / n;
    [mean, (numbers.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()]
}

/// One thread and two make the same files, `gen validate` renders them again to the byte, maps have the object in them, and
/// rows without light are the thesis' noise, under its pattern where the pattern comes last.
#[test]
fn orders_of_the_thesis_make_datasets() {
    let stack = ["\noutput:\n", "\noutput:\n  sensor_stack: {every: 4}\n"];
    let wood = place(
        include_str!("../recipes/thesis/wood.yaml"),
        &[["columns: 2560, profiles: 4000", "columns: 128, profiles: 8"], ["lead_in_mm: 28", "lead_in_mm: 0.1"], stack],
    );
    let sawtooth = place(
        include_str!("../recipes/thesis/sawtooth.yaml"),
        &[
            ["columns: 2560, profiles: 400}", "columns: 128, profiles: 8}"],
            ["lead_in_mm: 1}", "lead_in_mm: 0.1}"],
            ["order: blur_speckle_noise", "order: noise_speckle"],
            ["  blur_radius_px: 0.5\n", ""],
            stack,
        ],
    );
    for (place, pattern) in [(wood, false), (sawtooth, true)] {
        place.make("one", "--n 1 --threads 1");
        place.make("two", "--n 1 --threads 2");
        assert_same(&place.tree("one"), &place.tree("two"), "2 threads");
        place.done("validate one --rerender 1");
        let (columns, profiles, light) = place.samples("one")[&0].image("reflectance");
        assert_eq!((columns, profiles), (128, 8));
        let lit = light.iter().filter(|dn| **dn > 40).count();
        assert!(lit > light.len() / 2, "{lit} of {} pixels are lit", light.len());
        let [mean, spread] = dark(&place);
        println!("dark {mean:.3} and {spread:.3} DN");
        if pattern {
            // 3.5 times as bright as before the pattern, whose contrast is 0.19.
            assert!((mean / 3.5 - 11.6).abs() < 0.3 && spread > 5.0, "{mean} {spread}");
        } else {
            // Rows in the middle of the order are even more alike than they are by chance: 0.01 DN.
            assert!((mean - 11.6).abs() < 0.03 && (spread - 1.09).abs() < 0.02, "{mean} {spread}");
        }
    }
}
