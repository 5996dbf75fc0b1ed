//! Motion blur and its bookkeeping: the light of an exposure is the mean over the way moved, whoever asks in what
//! order.

use base::{Body, Gloss, Medium};
use procedural::flat::Flat;
use recipe::{Plan, Scene};
use scanner::optics::{Band, ROWS, Scratch, Sensor, TILE};
use test_support::target::{expose, nominal, patterns, plate, scene};

/// Share of a step that the moving scenes move while they are exposed.
const WAY: f64 = 0.6;

fn grey() -> Medium {
    Medium::opaque(Gloss { matte: 0.5, ..Gloss::NONE })
}

fn moving(still: &Scene) -> Scene {
    let mut scene = still.clone();
    scene.bench.motion.line_rate_hz = WAY / (still.bench.exposure.time_us * 1e-6);
    scene
}

/// Light and middle of a column [e-], [px], of each window.
pub(crate) fn line(sensor: &Sensor, band: &Band, profile: usize, column: usize) -> Vec<[f64; 2]> {
    let mut scratch = Scratch::default();
    sensor.window(band, profile, column / TILE, &mut scratch);
    let c = column % TILE;
    let sum = |window: &scanner::optics::Window| {
        let light = |k: usize| f64::from(window.volume[k][c] + window.surface[k][c]);
        let total: f64 = (0..ROWS).map(light).sum();
        let moment: f64 = (0..ROWS).map(|k| light(k) * (k as f64 + f64::from(window.first_row[c]))).sum();
        [total, moment / total]
    };
    scratch.windows[..scratch.used].iter().map(sum).collect()
}

/// A stripe of grey on black ends between two profiles: the one before it holds what it sees on its way, WAY / 2 of the
/// black in the mean over where the edge lies; no light is lost along the scan.
#[test]
fn edges_of_reflectance_are_spread_over_the_way() {
    let still = scene(1);
    let last = 50;
    let stripe = || {
        let length_mm = (last as f32 + 0.5) * 0.068;
        Body::new(Flat { height_mm: 0.05, slope_x: 0.0, slope_y: 0.0, width_mm: 400.0, length_mm, medium: grey() })
    };
    let lights = |scene: &Scene| {
        let (sensor, band) = expose(scene, stripe(), 45..56);
        (45..56).map(|profile| line(&sensor, &band, profile, 100)[0][0]).collect::<Vec<_>>()
    };
    let (sharp, blurred) = (lights(&still), lights(&moving(&still)));
    assert!(sharp[last - 45] > 10.0 * sharp[last + 1 - 45], "the stripe ends after profile {last}: {sharp:?}");
    for i in 0..10 {
        let theory = (1.0 - 0.5 * WAY) * sharp[i] + 0.5 * WAY * sharp[i + 1];
        assert!((blurred[i] / theory - 1.0).abs() < 1e-4, "profile {}: {} e-, theory {theory}", 45 + i, blurred[i]);
    }
}

/// The line of a plate that rises moves by WAY / 2 of what it moves from profile to profile, and its travel is told.
#[test]
fn the_middle_of_the_way_is_where_a_moving_line_stands() {
    let still = scene(1);
    let body = || plate(grey(), 10.0, 0.0, 0.5);
    let (sensor, band) = expose(&still, body(), 60..62);
    let [here, next] = [60, 61].map(|profile| line(&sensor, &band, profile, 100)[0][1]);
    assert!((here - next).abs() > 0.1, "the line moves: {here} {next}");
    let (sensor, band) = expose(&moving(&still), body(), 60..61);
    let blurred = line(&sensor, &band, 60, 100)[0][1];
    let theory = here + 0.5 * WAY * (next - here);
    assert!((blurred - theory).abs() < 1e-3, "stands in row {blurred}, theory {theory}");

    let (sensor, _) = expose(&moving(&still), plate(grey(), 0.1, 0.0, 0.0), 60..61);
    let travel = WAY * nominal().motion.step_mm * f64::from(sensor.camera().sight(0.0, 0.1, 0.0).rows_per_mm);
    assert!((sensor.travel_px() / travel - 1.0).abs() < 1e-3 && (travel - 0.404).abs() < 0.01, "{travel} px");
}

/// Over the front edge of a board the sensor sees both lines in one exposure, each with its share of the time.
#[test]
fn an_upright_edge_shows_two_lines() {
    let mut still = scene(1);
    if let Plan::Wood(wood) = &mut still.plan {
        wood.board.lead_in_mm = 0.5;
    }
    let column = 100;
    let at = |scene: &Scene| {
        let (sensor, specimen) = pipeline::set_up(scene, pipeline::body(scene), patterns());
        let band = sensor.band(&specimen, 5..10);
        (5..10).map(|profile| line(&sensor, &band, profile, column)).collect::<Vec<_>>()
    };
    let (sharp, blurred) = (at(&still), at(&moving(&still)));
    let edge = (0..4).find(|&i| (sharp[i][0][1] - sharp[i + 1][0][1]).abs() > 50.0).expect("the board begins");
    let [conveyor, board] = [sharp[edge][0], sharp[edge + 1][0]];
    let [first, second] = blurred[edge][..] else { panic!("one window alone: {:?}", blurred[edge]) };
    assert!((first[0] / ((1.0 - 0.5 * WAY) * conveyor[0]) - 1.0).abs() < 1e-4 && (first[1] - conveyor[1]).abs() < 1e-3);
    assert!((second[0] / (0.5 * WAY * board[0]) - 1.0).abs() < 1e-4 && (second[1] - board[1]).abs() < 1e-2);
}

/// The next profile's light that is kept serves whoever asks in order, and nobody else.
#[test]
fn light_does_not_depend_on_the_order_of_asking() {
    let scene = moving(&scene(1));
    let (sensor, specimen) = pipeline::set_up(&scene, pipeline::body(&scene), patterns());
    let band = sensor.band(&specimen, 200..206);
    let other = sensor.band(&specimen, 203..209);
    let fresh = |profile: usize, tile: usize| {
        let mut scratch = Scratch::default();
        sensor.window(&band, profile, tile, &mut scratch);
        (scratch.windows[0].volume.clone(), scratch.windows[0].surface.clone(), scratch.windows[0].first_row)
    };
    let mut scratch = Scratch::default();
    let orders = [(200, 0), (201, 0), (202, 0), (201, 1), (202, 1), (202, 0), (205, 0), (203, 0), (204, 0)];
    for (profile, tile) in orders {
        sensor.window(&band, profile, tile, &mut scratch);
        let got = &scratch.windows[0];
        let (volume, surface, first) = fresh(profile, tile);
        assert!(got.volume == volume && got.surface == surface && got.first_row == first, "profile {profile} {tile}");
    }
    sensor.window(&other, 205, 0, &mut scratch);
    let (volume, ..) = fresh(205, 0);
    assert!(scratch.windows[0].volume == volume, "another band");
}
