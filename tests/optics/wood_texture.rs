//! Clear wood shows no lattice: how much the pixels of a row differ must not repeat from row to row, and likewise for
//! columns.

use base::Class;
use dataset::record::Record;
use recipe::{Plan, Recipe};
use test_support::target::patterns;

/// Boards looked at.
const BOARDS: u64 = 100;
/// Lags looked at [rows or columns].
const LAGS: std::ops::RangeInclusive<usize> = 5..=60;

/// A drawn board without knots and rot, and without the saw's ripple and teeth, whose periods are real.
fn board(index: u64) -> Record {
    let mut scene = Recipe::load("wood-small.yaml").expect("the embedded recipe loads").draw(5, index);
    let Plan::Wood(wood) = &mut scene.plan else { panic!("boards") };
    (wood.knots.sound_count, wood.knots.dead_count) = (0.0, 0.0);
    wood.rot.reach_mm = 0.0;
    (wood.board.saw_ripple_um, wood.machining.teeth_um) = (0.0, 0.0);
    scene.output.truth_maps = false;
    pipeline::render(&scene, patterns(), &|_| ())
}

/// Root mean square departure from the mean over the mean, of each line of pixels well inside the board [1].
fn spreads(record: &Record, map: &[f32], by_row: bool) -> Vec<f64> {
    let (cols, rows) = (record.cols, record.rows);
    let (lines, length) = if by_row { (rows, cols) } else { (cols, rows) };
    let spread = |line: usize| {
        let at = |i: usize| if by_row { line * cols + i } else { i * cols + line };
        let clear: Vec<usize> = (0..length).filter(|&i| record.labels.class[at(i)] == Class::Clear as u8).collect();
        // Eight pixels inside: beyond the edge there is no light to come in.
        if clear.len() < length / 2 || clear.len() < 40 {
            return None;
        }
        let values: Vec<f64> = clear[8..clear.len() - 8].iter().map(|&i| f64::from(map[at(i)])).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|v| (v / mean - 1.0).powi(2)).sum::<f64>() / values.len() as f64;
        Some(square.sqrt())
    };
    let mut spreads: Vec<f64> = (0..lines).filter_map(spread).collect();
    spreads.drain(..8);
    spreads.truncate(spreads.len() - 8);
    spreads
}

/// A series less its mean over 61 neighbours: rings and pores that drift over the board are no lattice.
fn detrended(series: &[f64]) -> Vec<f64> {
    let smooth = |i: usize| {
        let near = &series[i.saturating_sub(30)..(i + 31).min(series.len())];
        near.iter().sum::<f64>() / near.len() as f64
    };
    (0..series.len()).map(|i| series[i] - smooth(i)).collect()
}

/// Autocorrelation of a series at each of the lags.
fn correlations(series: &[f64]) -> Vec<f64> {
    let n = series.len();
    let mean = series.iter().sum::<f64>() / n as f64;
    let product = |lag: usize| {
        series[lag..].iter().zip(series).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / (n - lag) as f64
    };
    let variance = product(0);
    LAGS.map(|lag| product(lag) / variance).collect()
}

#[test]
#[ignore = "long"]
fn the_spread_of_rows_and_columns_does_not_repeat() {
    let records: Vec<Record> = (0..BOARDS).map(board).collect();
    type Map = fn(&Record) -> &[f32];
    let maps: [(&str, Map); 2] =
        [("Reflectance", |record| &record.maps.reflectance), ("Scatter", |record| &record.maps.scatter)];
    for (name, map) in maps {
        for (direction, by_row) in [("rows", true), ("columns", false)] {
            let all: Vec<Vec<f64>> =
                records.iter().map(|record| correlations(&detrended(&spreads(record, map(record), by_row)))).collect();
            let mean: Vec<f64> = (0..all[0].len())
                .map(|lag| all.iter().map(|board| board[lag]).sum::<f64>() / all.len() as f64)
                .collect();
            let (at, largest) = mean.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).expect("lags");
            let single = all.iter().flatten().fold(f64::MIN, |most, &v| most.max(v));
            println!(
                "{name}, {direction}: {largest:.3} at lag {} over all boards, {single:.3} on one",
                at + LAGS.start()
            );
            // Strands keep the spread for some rows; a lattice brings it back at its own lag, with 0.8 for value noise.
            // 160 lines a board and 100 boards: standard error 0.008 for white series, some three times that for these.
            assert!(*largest < 0.3, "{name}, {direction}: {largest} at lag {}", at + LAGS.start());
            let later = mean[30 - LAGS.start()..].iter().fold(f64::MIN, |most, &v| most.max(v));
            println!("{name}, {direction}: {later:.3} from lag 30 on");
            assert!(later < 0.1, "{name}, {direction}: {later} from lag 30 on");
        }
    }
}
