//! Light about the holes of a part.

use recipe::{Recipe, Scene};
use scanner::optics::speckle::PatternCache;
use scanner::optics::{Band, ROWS, Scratch, TILE, expose};

/// Light of every pixel about the line of `profile`, worked out in the band `profiles` [e-].
fn light(scene: &Scene, profiles: std::ops::Range<usize>, profile: usize) -> Vec<u32> {
    let (sensor, specimen) = pipeline::set_up(scene, pipeline::body(scene), &PatternCache::new(0));
    let band = sensor.band(&specimen, profiles, Band::default());
    let mut scratch = Scratch::default();
    let mut light = Vec::new();
    for tile in 0..scene.size.columns.div_ceil(TILE) {
        expose::window(&sensor, &band, profile, tile, &mut scratch);
        light.extend(
            (0..ROWS).flat_map(|k| (0..TILE).map(move |c| (k, c))).map(|(k, c)| scratch.electrons(k, c).to_bits()),
        );
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
    for profile in (0..profiles).step_by(profiles / 12) {
        let (alone, among) = (light(&scene, profile..profile + 1, profile), light(&scene, 0..profiles, profile));
        assert!(lit(&alone) > 0, "profile {profile} is dark");
        assert!(alone == among, "profile {profile}");
    }
}
