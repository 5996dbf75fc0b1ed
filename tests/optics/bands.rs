//! What a profile shows does not depend on the band that it is worked out in.

use std::ops::Range;

use base::Stream;
use rand::RngExt;
use recipe::{Recipe, Scene};
use scanner::optics::speckle::PatternCache;
use scanner::optics::{Band, ROWS, Scratch, Sensor, TILE};
use scanner::specimen::Specimen;

fn set_up(scene: &Scene) -> (Sensor, Specimen) {
    pipeline::set_up(scene, pipeline::body(scene), &PatternCache::repeating(0))
}

/// Light of every pixel about the line of `profile` [e-], in both windows.
fn light(scene: &Scene, sensor: &Sensor, band: &Band, profile: usize) -> Vec<u32> {
    let mut scratch = Scratch::default();
    let mut light = Vec::new();
    for tile in 0..scene.size.columns.div_ceil(TILE) {
        sensor.window(band, profile, tile, &mut scratch);
        for window in &scratch.windows[..scratch.used] {
            let pixels = (0..ROWS).flat_map(|k| (0..TILE).map(move |c| (k, c)));
            light.extend(pixels.map(|(k, c)| (window.volume[k][c] + window.surface[k][c]).to_bits()));
        }
    }
    light
}

/// What plastic sends out before, in and behind a hole does not depend on how far the band reaches beyond it.
#[test]
fn holes_look_alike_in_every_band() {
    let recipe = Recipe::load("mesh-small").expect("the embedded recipe loads");
    let scene =
        (0..40).map(|index| recipe.draw(0, index)).find(|scene| scene.class == "plastic").expect("a part of plastic");
    let lit = |light: &[u32]| light.iter().filter(|bits| **bits != 0).count();
    let profiles = scene.size.profiles;
    let (sensor, specimen) = set_up(&scene);
    let all = sensor.band(&specimen, 0..profiles);
    for profile in (0..profiles).step_by(profiles / 12) {
        let alone = sensor.band(&specimen, profile..profile + 1);
        let (alone, among) = [&alone, &all].map(|band| light(&scene, &sensor, band, profile)).into();
        assert!(lit(&alone) > 0, "profile {profile} is dark");
        assert!(alone == among, "profile {profile}");
    }
}

/// Bands that take over rows of one another, forwards, backwards and with gaps, hold what bands made anew hold.
#[test]
#[ignore = "long"]
fn rows_that_are_used_again_stay_as_they_are() {
    let mut rng = Stream::root(31).rng();
    // Boards with every defect, film over foil that is seen and that is not, triangles: each kind of row.
    for name in ["wood-grading-train", "blister-small", "blister-clear", "mesh-small"] {
        let mut scene = Recipe::load(name).expect("the embedded recipe loads").draw(7, rng.random_range(0..1000));
        // Bands divide the profiles, so that some columns tell of all.
        scene.size.columns = scene.size.columns.min(5 * TILE);
        let profiles = scene.size.profiles;
        let (sensor, specimen) = set_up(&scene);
        let mut bands = sensor.bands(&specimen);
        let mut start = rng.random_range(0..profiles / 2);
        for _ in 0..6 {
            let range: Range<usize> = start..(start + rng.random_range(1..40)).min(profiles);
            let band = bands.make(range.clone());
            let anew = sensor.band(&specimen, range.clone());
            for profile in [range.start, rng.random_range(range.clone()), range.end - 1] {
                let [used, made] = [band, &anew].map(|band| light(&scene, &sensor, band, profile));
                assert!(used == made, "{name}, profile {profile} of {range:?}");
            }
            start = match rng.random_range(0..4) {
                0 => range.start.saturating_sub(rng.random_range(0..50)),
                1 => range.end + rng.random_range(0..90),
                _ => range.end,
            }
            .min(profiles - 1);
        }
    }
}
