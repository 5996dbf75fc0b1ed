//! Which rows are exposed again: with the chance that is promised, and every row and frame has its turn.

use dataset::validate::RowChoice;
use optical_bench::settings::Size;
use output_schema::DatasetHead;
use test_support::records::{self, output};

/// Whether a row is forged.
type IsForged = fn(usize) -> bool;

/// A head of images with 100 rows, of which every eighth profile has a sensor frame.
fn head() -> DatasetHead {
    records::head(&output(), &Size { columns: 64, rows: 20, profiles: 100 }, 10_000)
}

/// Of 10 000 samples as many meet a forgery as promised, within 4 standard errors: strips or more, rows alone neither
/// more nor less.
#[test]
fn forgeries_are_met_with_the_chance_that_is_promised() {
    let (head, samples) = (head(), 10_000);
    let forgeries: [(&str, IsForged); 4] = [
        ("a block", |row| (40..45).contains(&row)),
        ("a strip", |row| (48..56).contains(&row)),
        ("the last rows", |row| row >= 96),
        ("rows apart", |row| row % 20 == 3),
    ];
    for (what, forged) in forgeries {
        let share = (0..100).filter(|row| forged(*row)).count() as f64 / 100.0;
        for places in [1, 3] {
            let met = |strip: u64| {
                let choice = RowChoice { places, strip, frames: 1, seed: 17 };
                let meets = |index: &u64| choice.of(&head, *index).strips.into_iter().flatten().any(forged);
                (0..samples).filter(meets).count() as f64 / samples as f64
            };
            let promised = 1.0 - (1.0 - share).powi(places as i32);
            let error = (promised * (1.0 - promised) / samples as f64).sqrt();
            let [alone, strips] = [met(1), met(8)];
            println!("{what}, {places} places: promised {promised:.4}, rows {alone:.4}, strips {strips:.4}");
            assert!((alone - promised).abs() < 4.0 * error, "{what}, {places} rows: {alone}, promised {promised}");
            assert!(strips > promised - 4.0 * error, "{what}, {places} places: {strips}, promised {promised}");
        }
    }
}

/// Strips lie in the image, frames are those that are kept, each as often as the others; another seed asks for others,
/// and no places ask for nothing.
#[test]
fn all_rows_and_frames_have_their_turn() {
    let head = head();
    let choice = RowChoice { places: 2, strip: 8, frames: 3, seed: 1 };
    let (mut rows, mut frames) = ([0; 100], [0; 100]);
    for index in 0..13_000 {
        let asked = choice.of(&head, index);
        asked.strips.into_iter().flatten().for_each(|row| rows[row] += 1);
        assert!(asked.frames.len() == 3 && asked.frames.is_sorted_by(|a, b| a < b), "{:?}", asked.frames);
        asked.frames.into_iter().for_each(|profile| frames[profile] += 1);
    }
    assert!(rows.iter().all(|count| *count > 0), "{rows:?}");
    for (profile, count) in frames.into_iter().enumerate() {
        // 3000 each, standard deviation 48; four of them.
        let expected = if profile % 8 == 0 { 2808..3192 } else { 0..1 };
        assert!(expected.contains(&count), "profile {profile}: {count}");
    }
    let other = RowChoice { seed: 2, ..choice };
    assert!((0..20).any(|index| choice.of(&head, index) != other.of(&head, index)));
    let all: Vec<usize> = (0..100).step_by(8).collect();
    assert_eq!(RowChoice { frames: u64::MAX, ..choice }.of(&head, 5).frames, all);
    assert!(RowChoice { places: 0, ..choice }.of(&head, 5).is_empty());
}
