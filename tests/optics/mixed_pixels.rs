//! Pixels across an edge: a column that the edge cuts sees both sides, each with its part of the column's width.

use base::{Body, Class, Stream};
use procedural::strips::{Strip, Strips};
use rand::RngExt;
use scanner::optics::{ROWS, Scratch, TILE};
use test_support::target;

/// Scan position of the line [profiles].
const PROFILE: usize = 150;

/// Place and light by sensor row of each column of the tile in the middle [mm, e-].
fn columns(body: &Body) -> Vec<(f64, i32, Vec<f64>)> {
    let mut scene = target::scene(300);
    scene.size.columns = TILE;
    let (sensor, band) = target::expose(&scene, body.clone(), PROFILE..PROFILE + 1);
    let mut scratch = Scratch::default();
    sensor.window(&band, PROFILE, 0, &mut scratch);
    let hits = &band.line(PROFILE).hits;
    (0..TILE)
        .map(|c| {
            let light = (0..ROWS).map(|k| f64::from(scratch.electrons(k, c))).collect();
            (f64::from(hits[c].x), scratch.windows[0].first_row[c], light)
        })
        .collect()
}

/// Bright ceramic, sunk by 1.2 mm from the plate's middle on.
fn step(edge_mm: f32, sunk_mm: f32) -> Body {
    let strip =
        |width_mm: f32, sunk_mm: f32| Strip { width_mm, sunk_mm, medium: target::ceramic(), class: Class::Clear };
    // The plate is centred: the border lies where half of the difference of both widths says.
    let strips = vec![strip(40.0 + edge_mm, 0.0), strip(40.0 - edge_mm, sunk_mm)];
    Body::new(Strips { height_mm: 22.0, length_mm: 20.0, strips })
}

/// A step of some rows at places drawn at random: the light of its low side in the cut column is the part of the
/// column's width that lies beyond the edge, within a sixteenth of a column for the search and one for the lean of
/// lines of sight. All other columns have one line.
#[test]
fn a_cut_column_has_the_light_of_both_sides_by_their_widths() {
    let mut rng = Stream::root(3).child("steps").rng();
    let mut shares = Vec::new();
    for _ in 0..24 {
        let edge = 0.4 * rng.random::<f32>();
        let all = columns(&step(edge, 1.2));
        let cut = all
            .windows(2)
            .position(|pair| f64::from(edge) >= pair[0].0 && f64::from(edge) < pair[1].0)
            .expect("an edge");
        // The sensor row of either side's line, from columns well away.
        let line = |column: usize| {
            let (_, first, light) = &all[column];
            first + (0..ROWS).max_by(|&a, &b| light[a].total_cmp(&light[b])).expect("rows") as i32
        };
        let (high, low) = (line(cut - 4), line(cut + 5));
        assert!((high - low).abs() >= 5, "rows {high} and {low}");
        let nearer_low = |column: usize| -> f64 {
            let (_, first, light) = &all[column];
            let at = |k: usize| first + k as i32;
            let low_side = (0..ROWS).filter(|&k| (at(k) - low).abs() < (at(k) - high).abs());
            low_side.map(|k| light[k]).sum::<f64>() / light.iter().sum::<f64>()
        };
        let pitch = all[cut + 1].0 - all[cut].0;
        for (column, expected) in
            (cut - 3..cut + 4).map(|column| (column, (0.5 + (all[column].0 - f64::from(edge)) / pitch).clamp(0.0, 1.0)))
        {
            let found = nearer_low(column);
            assert!((found - expected).abs() < 0.125, "edge {edge}, column {column}: {found:.3} for {expected:.3}");
            if expected > 0.0 && expected < 1.0 {
                shares.push((found, expected));
            }
        }
    }
    // Cut at all places, and not always to the same side.
    let mean_error = shares.iter().map(|(found, expected)| found - expected).sum::<f64>() / shares.len() as f64;
    println!("{} cut columns, mean error {mean_error:.4}", shares.len());
    assert!(shares.iter().any(|(found, _)| (0.2..0.8).contains(found)), "no mixed column: {shares:?}");
    assert!(mean_error.abs() < 0.05, "{mean_error}");
}

/// A surface without jumps, however steep, has no mixed columns.
#[test]
fn slopes_have_no_edges() {
    for slope in [0.0, 0.5, 1.5] {
        let mut scene = target::scene(300);
        scene.size.columns = TILE;
        let (_, band) =
            target::expose(&scene, target::plate(target::ceramic(), 20.0, slope, 0.0), PROFILE..PROFILE + 1);
        assert!(band.line(PROFILE).mixed.is_empty(), "slope {slope}: {:?}", band.line(PROFILE).mixed);
    }
}
