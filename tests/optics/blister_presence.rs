//! What Scatter is for: on 40 packs of one film and one exposure, a plain threshold on a pocket's mean Scatter finds
//! the missing tablets, and one on its mean Range does not; the more pigment in the film, the less is left of it.

use base::{Class, Instance};
use dataset::record::Record;
use rayon::prelude::*;
use recipe::{Plan, Recipe};
use test_support::target;

/// A pocket: whether it holds its tablet, mean Scatter [DN], mean Range over the card's [mm].
struct Seen {
    filled: bool,
    scatter: f64,
    range: f64,
}

/// Pockets of `packs` packs through film of reduced scattering `sigma` [mm^-1] and `thickness` [mm].
fn pockets(packs: u64, sigma: f64, thickness: f64) -> Vec<Seen> {
    let recipe = Recipe::load("blister-small.yaml").expect("the embedded recipe loads");
    let seen = (0..packs).into_par_iter().flat_map_iter(|index| {
        let mut scene = recipe.draw(7, index);
        // One line: the same film and the same bench all day; cards, tablets and their places vary.
        let nominal = recipe.draw(7, 0).bench;
        scene.bench = nominal;
        // A quarter of the profiles show as much of a pocket's mean.
        scene.bench.motion.step_mm *= 4.0;
        scene.size.profiles /= 4;
        scene.bench.exposure.time_us = 20.0;
        let Plan::Blister(blister) = &mut scene.plan else { panic!("the recipe is about packs") };
        (blister.web.sigma_per_mm, blister.web.thickness_mm) = (sigma, thickness);
        blister.web.mu_a_per_mm = 0.05;
        blister.defects = procedural::blister::Defects::from_values(&mut |parameter| parameter.default);
        blister.defects.missing = (index % 4) as f64;
        (scene.output.bin_columns, scene.output.bin_profiles, scene.output.truth_maps) = (1, 1, false);
        let record = pipeline::render(&scene, target::patterns(), &|_| ());
        seen(&record)
    });
    seen.collect()
}

fn seen(record: &Record) -> Vec<Seen> {
    let pocket = |instance: &Instance| matches!(instance.class, Class::Pocket | Class::Missing);
    let found = record.objects.iter().map(|object| object.instance).filter(pocket);
    found
        .map(|instance| {
            let inside = |i: &usize| record.labels.instance[*i] == instance.id && record.maps.scatter[*i] > 0.0;
            let pixels: Vec<usize> = (0..record.labels.instance.len()).filter(inside).collect();
            let mean = |map: &[f32]| pixels.iter().map(|&i| f64::from(map[i])).sum::<f64>() / pixels.len() as f64;
            Seen {
                filled: instance.class == Class::Pocket,
                scatter: mean(&record.maps.scatter),
                range: mean(&record.maps.range),
            }
        })
        .collect()
}

/// Share of pockets told right by the threshold that tells the first half best, on the second half: mean of filled and
/// of empty ones.
fn found(pockets: &[Seen], value: impl Fn(&Seen) -> f64) -> f64 {
    let (learn, test) = pockets.split_at(pockets.len() / 2);
    let share = |set: &[Seen], threshold: f64, sign: f64| {
        let right = |filled: bool| {
            let (mut hits, mut all) = (0.0f64, 0.0f64);
            for pocket in set.iter().filter(|pocket| pocket.filled == filled) {
                all += 1.0;
                hits += f64::from(u8::from((sign * (value(pocket) - threshold) > 0.0) == filled));
            }
            hits / all.max(1.0)
        };
        0.5 * (right(true) + right(false))
    };
    let choices = learn.iter().flat_map(|pocket| [(value(pocket), 1.0), (value(pocket), -1.0)]);
    let best = choices
        .map(|(threshold, sign)| (share(learn, threshold, sign), threshold, sign))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .expect("there are pockets");
    share(test, best.1, best.2)
}

#[test]
#[ignore = "long"]
fn scatter_finds_missing_tablets_and_range_does_not() {
    let pockets = pockets(40, 12.0, 0.25);
    let empty = pockets.iter().filter(|pocket| !pocket.filled).count();
    assert!(empty > 40 && pockets.len() - empty > 120, "{empty} empty of {}", pockets.len());
    let (scatter, range) = (found(&pockets, |p| p.scatter), found(&pockets, |p| p.range));
    println!("missing tablets found on 40 packs: by Scatter {:.3}, by Range {:.3}", scatter, range);
    assert!(scatter > 0.95, "Scatter tells {scatter} of the pockets right");
    assert!(range < 0.70, "Range tells {range} of the pockets right");
}

/// By how much filled pockets are brighter in Scatter than empty ones, and its standard error [DN].
fn brighter(pockets: &[Seen]) -> [f64; 2] {
    let of = |filled: bool| target::moments(pockets.iter().filter(move |p| p.filled == filled).map(|p| p.scatter));
    let count = |filled: bool| pockets.iter().filter(|p| p.filled == filled).count() as f64;
    let ((full, spread), (empty, other)) = (of(true), of(false));
    [full - empty, (spread * spread / count(true) + other * other / count(false)).sqrt()]
}

/// The more pigment, the less a tablet adds; through 0.9 mm of white film, which is a quarter of that on shoulders, it
/// adds next to nothing.
#[test]
#[ignore = "long"]
fn what_tablets_add_to_scatter_fades_as_the_film_turns_opaque() {
    let films = [(12.0, 0.25), (40.0, 0.25), (100.0, 0.25), (200.0, 0.25), (200.0, 0.9)];
    let added = films.map(|(sigma, thickness)| brighter(&pockets(12, sigma, thickness)));
    println!("filled less empty [DN]: {added:.2?}");
    for pair in added.windows(2) {
        let [[before, error], [after, other]] = [pair[0], pair[1]];
        assert!(before - after > 3.0 * error.hypot(other), "{before} to {after}");
    }
    let [[clear, _], .., [opaque, error]] = added;
    assert!(opaque.abs() < 3.0 * error + 0.02 * clear, "{opaque} +- {error} through opaque film");
}
