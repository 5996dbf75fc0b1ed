//! The edges of the field: a body that reaches beyond the sensor's columns is lit there too, and its light comes in.

use base::{Body, Class, Gloss, Medium, Stream, WOOD_DISPERSION_DEG};
use glam::Vec3;
use procedural::strips::{Strip, Strips};
use rand::RngExt;
use scanner::optics::{ROWS, Scratch, TILE};
use test_support::target;

/// Scan position of the line [profiles].
const PROFILE: usize = 150;

/// Light of each column away from the line's middle, rows 1 to 8 on both sides of the peak, and all of it [e-].
fn columns(body: &Body, count: usize) -> Vec<[f64; 2]> {
    let mut scene = target::scene(300);
    scene.size.columns = count;
    let (sensor, band) = target::expose(&scene, body.clone(), PROFILE..PROFILE + 1);
    let mut scratch = Scratch::default();
    let mut columns = Vec::new();
    for tile in 0..count / TILE {
        sensor.window(&band, PROFILE, tile, &mut scratch);
        columns.extend((0..TILE).map(|column| {
            let at = |k: usize| f64::from(scratch.electrons(k, column));
            let peak = (0..ROWS).max_by(|&a, &b| at(a).total_cmp(&at(b))).expect("there are rows");
            let beside = (1..=8).map(|d| at((peak + d).min(ROWS - 1)) + at(peak.saturating_sub(d))).sum();
            [beside, (0..ROWS).map(at).sum()]
        }));
    }
    columns
}

/// Plates wider than 256 columns, of wood drawn at random: evenly one kind, each column has within 1 % the light that
/// it has in the middle of a sensor twice as wide. Of strips of some mm that differ by up to 2 in absorption, within 8
/// %, since what lies beyond the field is not known there. Before light came in from beyond, the first column had half.
#[test]
fn columns_at_the_edge_have_the_light_of_those_inside() {
    for case in 0..8u64 {
        let mut rng = Stream::root(case).child("edges").rng();
        let mut draw = |low: f32, high: f32| low + (high - low) * rng.random::<f32>();
        let (sigma_i, k, n_eff, mu_a) = (draw(1.0, 4.0), draw(0.0, 15.0), draw(1.1, 1.3), draw(0.04, 0.3));
        let azimuth = draw(-0.3, 0.3);
        let fibre = Vec3::new(azimuth.sin(), azimuth.cos(), 0.0);
        let medium = |mu_a: f32| Medium {
            mu_a,
            sigma_i,
            k,
            n_eff,
            fibre,
            dispersion_deg: WOOD_DISPERSION_DEG,
            gloss: Gloss::NONE,
            coat: 1.0,
        };
        let even = target::plate(medium(mu_a), 22.0, 0.0, 0.0);
        let strip =
            |width_mm: f32, mu_a: f32| Strip { width_mm, sunk_mm: 0.0, medium: medium(mu_a), class: Class::Clear };
        let strips = (0..40).map(|_| strip(draw(2.0, 4.0), mu_a * draw(1.0, 2.0))).collect();
        let striped = Body::new(Strips { height_mm: 22.0, length_mm: 20.0, strips });
        for (name, body, most) in [("even", even, 0.01), ("striped", striped, 0.08)] {
            let (narrow, wide) = (columns(&body, 256), columns(&body, 512));
            for (column, own) in narrow.iter().enumerate() {
                let inside = wide[128 + column];
                for (what, [own, inside]) in [("beside", [own[0], inside[0]]), ("all", [own[1], inside[1]])] {
                    let off = own / inside - 1.0;
                    assert!(off.abs() < most, "case {case}, {name}, column {column}: {what} off by {off:.3}");
                }
            }
        }
    }
}
