//! Whole boards by the kernel against the reference: one line across each of twenty boards as recipes draw them, with
//! rings, knots, rot, rough faces and edges. Scatter and Range in bins of 0.74 mm along the line, free of noise and
//! speckle.

use std::collections::BTreeMap;

use super::borders::{Column, bench_of, columns};
use super::kept::Kept;
use base::{Body, Medium};
use optical_bench::settings::Transport;
use recipe::{Recipe, Scene};
use transport::answer::Estimate;

/// Boards.
const BOARDS: u64 = 20;
/// Photons of the reference for each board, and walks into which they are divided.
pub const PHOTONS: u64 = 400_000;
pub const WALKS: u64 = 4;
/// Columns in a bin: 0.74 mm.
pub const BIN: usize = 8;
/// Rows of Scatter on either side of the peak, and half of the window of which the centre of gravity is taken.
const SCATTER_ROWS: i32 = 8;
const HALF_WINDOW: i32 = 7;

/// Light by sensor row of the columns of a bin, added up [e-].
pub type BinRows = BTreeMap<i32, f64>;

/// Bins of a line that lie on the board as a whole.
pub fn bins(scene: &Scene, body: Body, transport: Transport) -> Vec<Option<BinRows>> {
    let all = columns(scene, body, transport);
    let bin = |columns: &[Column]| {
        columns.iter().all(|column| column.on_body).then(|| {
            let mut rows = BinRows::new();
            for column in columns {
                for (row, light) in (column.first..).zip(&column.light) {
                    *rows.entry(row).or_insert(0.0) += light;
                }
            }
            rows
        })
    };
    all.chunks_exact(BIN).map(bin).collect()
}

fn peak(rows: &BinRows) -> i32 {
    *rows.iter().max_by(|a, b| f64::total_cmp(a.1, b.1)).expect("there are rows").0
}

/// Light beside the peak [e-] and centre of gravity about it [rows].
pub fn figures(rows: &BinRows, peak: i32) -> [f64; 2] {
    let within = |most: i32| rows.iter().filter(move |(row, _)| (**row - peak).abs() <= most);
    let scatter: f64 = within(SCATTER_ROWS).filter(|(row, _)| **row != peak).map(|(_, light)| light).sum();
    let light: f64 = within(HALF_WINDOW).map(|(_, light)| light).sum();
    let moment: f64 = within(HALF_WINDOW).map(|(row, light)| f64::from(row - peak) * light).sum();
    [scatter, moment / light]
}

/// Of each bin: the reference's peak row, Scatter, its error, centre of gravity, its error; a bin beside the board has
/// peak -1.
pub fn reference(scene: &Scene) -> Vec<f64> {
    let body = pipeline::body(scene);
    let walk = |walk: u64| {
        let scene = Scene { stream: scene.stream.child("walk").index(walk), ..scene.clone() };
        bins(&scene, body.clone(), Transport::Path { photons: PHOTONS / WALKS })
    };
    let walks: Vec<_> = (0..WALKS).map(walk).collect();
    let of_bin = |bin: usize| {
        let own: Option<Vec<&BinRows>> = walks.iter().map(|walk| walk[bin].as_ref()).collect();
        let Some(own) = own else { return [-1.0, 0.0, 0.0, 0.0, 0.0] };
        let mut all = BinRows::new();
        own.iter().for_each(|rows| rows.iter().for_each(|(row, light)| *all.entry(*row).or_insert(0.0) += light));
        let at = peak(&all);
        let [scatter, centre] = [0, 1].map(|which| Estimate::of(own.iter().map(|rows| figures(rows, at)[which])));
        [f64::from(at), scatter.value, scatter.error, centre.value, centre.error]
    };
    (0..walks[0].len()).flat_map(of_bin).collect()
}

/// What the board is made of about the line, at its face and below: another board has another answer.
pub fn matter(scene: &Scene, body: &Body) -> Vec<Option<[Medium; 3]>> {
    let y = (scene.size.profiles / 2) as f64 * scene.bench.motion.step_mm;
    let at = |i: i32| {
        let (slice, x) = (body.slice(y as f32), 0.5 * i as f32);
        let surface = slice.surface(x)?;
        Some([0.0, 0.7, 2.0].map(|deep| slice.matter(x, surface.z - deep).medium))
    };
    (-20..=20).map(at).collect()
}

/// Scatter of 95 % of the bins within 8 % of the reference's, beside two of its standard errors; Range within 20 um
/// rms (a row is 0.2 mm), less the reference's own noise.
#[test]
fn scatter_and_range_of_boards_are_those_of_the_reference() {
    let recipe = Recipe::load("wood-small.yaml").expect("the embedded recipe loads");
    let mut kept = Kept::of("boards");
    let (mut off, mut squares, mut noise) = (Vec::new(), 0.0, 0.0);
    for index in 0..BOARDS {
        let scene = recipe.draw(14, index);
        let body = pipeline::body(&scene);
        let asked =
            (bench_of(&scene), matter(&scene, &body), [PHOTONS, WALKS, BIN as u64], [SCATTER_ROWS, HALF_WINDOW]);
        let reference = kept.says(&format!("board {index:02}"), &asked, || reference(&scene));
        let kernel = bins(&scene, body, Transport::Kernel);
        let mut own = Vec::new();
        for (bin, truth) in reference.chunks(5).enumerate() {
            let ([at, scatter, scatter_error, centre, centre_error], Some(rows)) =
                (<[f64; 5]>::try_from(truth).unwrap(), &kernel[bin])
            else {
                continue;
            };
            let [mine, place] = figures(rows, at as i32);
            assert!(mine.is_finite() && place.is_finite(), "board {index}, bin {bin}: {mine}, {place}");
            own.push((mine / scatter - 1.0, scatter_error / scatter, place - centre, centre_error, bin));
        }
        let mean = own.iter().map(|bin| bin.0).sum::<f64>() / own.len() as f64;
        let shift = own.iter().map(|bin| bin.2).sum::<f64>() / own.len() as f64;
        let text: Vec<String> = own.iter().map(|bin| format!("{:+.0}", 100.0 * bin.0)).collect();
        println!("board {index} ({}): Scatter {mean:+.3}, centre {shift:+.3}: {}", scene.class, text.join(" "));
        for (scatter, error, place, place_error, bin) in own {
            off.push(((scatter.abs() - 2.0 * error).max(0.0), index, bin));
            squares += place * place;
            noise += place_error * place_error;
        }
    }
    kept.finish();
    let count = off.len();
    off.sort_by(|a, b| b.0.total_cmp(&a.0));
    let range = 0.2e3 * ((squares - noise).max(0.0) / count as f64).sqrt();
    println!(
        "{count} bins: 95 % within {:.3}, worst {:?}; Range {range:.1} um rms, noise of the reference {:.1} um",
        off[count / 20].0,
        &off[..4],
        0.2e3 * (noise / count as f64).sqrt()
    );
    assert!(off[count / 20].0 < 0.08, "Scatter: {:?}", &off[..=count / 20]);
    assert!(range < 20.0, "Range: {range} um");
}
