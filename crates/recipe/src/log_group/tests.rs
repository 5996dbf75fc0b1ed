//! Boards of one log: what they share, what they do not, and what is refused.

use std::collections::BTreeMap;

use super::*;
use crate::level::{DrawLevel, declared};
use crate::{Recipe, Scene};

/// Keys of the log, of its boards and of the bench.
const BASE: &str = "
name: logs
subject: wood
unstated: fixed
board: {width_mm: {uniform: [60, 120]}, length_mm: {uniform: [150, 250]}, cup_mm: {uniform: [-1, 1]}}
stem:
  radius_mm: {uniform: [100, 140]}
  board_radius_mm: {uniform: [20, 80]}
  board_along_mm: {uniform: [0, 4000]}
media: {earlywood_mu_a_per_mm: {log_uniform: [0.04, 0.16]}, gloss: {uniform: [0.1, 0.5]}}
camera: {tilt_deg: {uniform: [24, 26]}}
classes:
  a: {share: 3}
  b: {share: 1, camera: {tilt_deg: 25}}
";

fn text(log: &str, rest: &str) -> String {
    format!("{BASE}log: {{{log}, ring_width_mm: {{uniform: [1, 3]}}}}\n{rest}")
}

fn parse(log: &str, rest: &str) -> Recipe {
    Recipe::parse("test", &text(log, rest)).unwrap_or_else(|error| panic!("{error}"))
}

fn draws(scene: &Scene) -> BTreeMap<String, f64> {
    scene.draws().into_iter().collect()
}

/// Keys that say where a board lies in the log.
const PLACE: [&str; 4] = ["stem.board_along_mm", "stem.board_radius_mm", "stem.board_azimuth_deg", "stem.face_deg"];

#[test]
fn one_board_of_each_log_is_what_it_was() {
    for source in ["stem", "measured"] {
        let of = |log: &str| {
            let text = text(&format!("source: {source}{log}"), "");
            let grown = "  radius_mm: {uniform: [100, 140]}\n";
            let text = if source == "stem" { text } else { text.replace(grown, "") };
            Recipe::parse("test", &text).unwrap_or_else(|error| panic!("{error}"))
        };
        let (plain, one) = (of(""), of(", boards_per_log: 1"));
        assert_eq!((plain.hash(), plain.canonical_json()), (one.hash(), one.canonical_json()));
        for index in 0..20 {
            let scene = one.draw(3, index);
            assert_eq!(scene, plain.draw(3, index));
            assert!(scene.log_board.is_none() && scene.log_stream == scene.stream);
        }
    }
}

/// By every way of sampling, what belongs to the log is drawn once for it, all else for each board, and class and split
/// are one.
#[test]
fn boards_of_a_log_share_what_belongs_to_it() {
    for rest in
        ["", "sampling: low_discrepancy", "correlations: [{keys: [log.ring_width_mm, stem.radius_mm], spearman: 0.6}]"]
    {
        let recipe = parse("source: stem, boards_per_log: 6", rest);
        assert_eq!(Recipe::parse("again", &recipe.canonical_json()).expect("a recipe").hash(), recipe.hash());
        let logs: Vec<Vec<Scene>> =
            (0..60).map(|log| (0..6).map(|board| recipe.draw(9, 6 * log + board)).collect()).collect();
        for (number, boards) in logs.iter().enumerate() {
            let first = draws(&boards[0]);
            for (place, scene) in boards.iter().enumerate() {
                assert_eq!(scene.log_board, Some(LogBoard { log: number as u64, board: place as u64 }));
                assert_eq!((scene.split, &scene.class), (boards[0].split, &boards[0].class));
                assert_eq!((scene.split, &scene.class), {
                    (recipe.split_of(9, scene.index), &recipe.class_of(9, scene.index).name)
                });
                assert_eq!(scene.log_stream, boards[0].log_stream);
                assert!(place == 0 || scene.stream != boards[0].stream);
                for (path, value) in draws(scene).iter().filter(|(path, _)| !PLACE.contains(&path.as_str())) {
                    let is_fixed = recipe.distribution(&scene.class, path).is_some_and(|own| own.values().is_some());
                    let same = *value == first[path];
                    assert_eq!(
                        same,
                        is_fixed || place == 0 || declared(path) == DrawLevel::Lot,
                        "{path} of board {place}"
                    );
                }
            }
        }
        // Logs differ, and every law keeps its range.
        for path in ["log.ring_width_mm", "stem.radius_mm", "media.gloss", "camera.tilt_deg"] {
            let own: Vec<f64> =
                logs.iter().filter(|boards| boards[0].class == "a").map(|b| draws(&b[0])[path]).collect();
            assert!(own.windows(2).all(|pair| pair[0] != pair[1]), "{path}");
        }
        // Counted by logs, classes and splits keep their bounds.
        let of_a = logs.iter().filter(|boards| boards[0].class == "a").count() as f64;
        assert!((of_a - 45.0).abs() < 2.0 + 60f64.ln() / 1.618f64.ln(), "{of_a} logs of class a");
    }
}

/// With low discrepancy the logs of a class cover each key of the log evenly, and the boards each key of the board.
#[test]
fn logs_and_boards_each_cover_their_keys_evenly() {
    let recipe = parse("source: stem, boards_per_log: 4", "sampling: low_discrepancy");
    for (path, low, high, boards) in [("log.ring_width_mm", 1.0, 3.0, 1), ("media.gloss", 0.1, 0.5, 4)] {
        let own = (0..400).map(|index| recipe.draw(2, index)).filter(|scene| scene.class == "a");
        let own = own.filter(|scene| scene.index % 4 < boards);
        let mut cells: Vec<u64> =
            own.take(64).map(|scene| (64.0 * (draws(&scene)[path] - low) / (high - low)) as u64).collect();
        cells.sort_unstable();
        assert!(cells.into_iter().eq(0..64), "{path}");
    }
}

#[test]
fn what_cannot_be_is_refused_with_a_remedy() {
    let refused = |log: &str, rest: &str, parts: &[&str]| {
        let fault = Recipe::parse("test", &text(log, rest)).expect_err("a fault").to_string();
        assert!(parts.iter().all(|part| fault.contains(part)), "{fault}");
    };
    refused("source: placed, boards_per_log: 2", "", &["boards_per_log", "stem"]);
    refused("source: stem, boards_per_log: 40", "", &["boards_per_log", "at most 14"]);
    let pair = "correlations: [{keys: [log.ring_width_mm, media.gloss], spearman: 0.5}]";
    refused("source: stem, boards_per_log: 4", pair, &["drawn once for a log", "remove `log.boards_per_log`"]);
    parse("source: stem", pair);
}
