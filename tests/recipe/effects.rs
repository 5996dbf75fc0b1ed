//! Every key of every object at another value: it changes the object, or it is refused or noted with what to do.

use std::hash::{DefaultHasher, Hash, Hasher};

use procedural::{Body, Parameter};
use recipe::{Recipe, Subject};

/// A recipe of a subject with every default but those of `keys`, and one class.
fn recipe(subject: Subject, keys: &[(&Parameter, f64)]) -> Result<Recipe, String> {
    let mut text = format!("name: a\nsubject: {}\nclasses: {{one: {{share: 1}}}}\n", subject.name());
    for (parameter, value) in keys {
        text.push_str(&format!("{}: {{{}: {value}}}\n", parameter.group, parameter.name));
    }
    Recipe::parse("a.yaml", &text).map_err(|error| error.to_string())
}

/// A sum of what a body answers on a grid.
fn answers(body: &Body) -> u64 {
    const SIDE: usize = 130;
    let (low, high) = body.bounds();
    let at = |low: f32, high: f32, k: usize| low + (high - low) * (k as f32 + 0.5) / SIDE as f32;
    let mut sum = DefaultHasher::new();
    for j in 0..SIDE {
        let slice = body.slice(at(low.y, high.y, j));
        for i in 0..SIDE {
            let x = at(low.x, high.x, i);
            let surface = slice.surface(x);
            let z = surface.as_ref().map_or(0.0, |surface| surface.z);
            format!("{surface:?} {:?}", slice.matter(x, z)).hash(&mut sum);
        }
    }
    format!("{:?} {:?} {:?}", body.instances(), body.bounds(), body.hull().positions).hash(&mut sum);
    sum.finish()
}

#[test]
fn every_key_of_an_object_has_an_effect_or_is_told() {
    let (mut silent, mut told) = (Vec::new(), 0);
    for subject in Subject::ALL {
        let usual = recipe(subject, &[]).unwrap_or_else(|error| panic!("{error}"));
        assert!(usual.notes().is_empty(), "{:?}", usual.notes());
        let scene = usual.draw(3, 0);
        let before = answers(&pipeline::body(&scene));
        for (parameter, value) in scene.plan.values() {
            // A tenth of the way to the farther end of the range, or one more.
            let end = if parameter.max - value > value - parameter.min { parameter.max } else { parameter.min };
            let other = match parameter.name {
                "edge" => -value,
                // The board shows no ring within 48 mm.
                "heartwood_mm" => 80.0,
                "juvenile_rings" => 60.0,
                _ if parameter.integer => {
                    if value + 1.0 > parameter.max {
                        value - 1.0
                    } else {
                        value + 1.0
                    }
                }
                _ => value + 0.1 * (end - value),
            };
            let path = parameter.path();
            match recipe(subject, &[(parameter, other)]) {
                Err(error) => {
                    assert!(error.contains(parameter.name), "{path}: {error}");
                    told += 1;
                }
                Ok(recipe) if recipe.notes().iter().any(|note| note.starts_with(&path)) => told += 1,
                Ok(recipe) => {
                    if answers(&pipeline::body(&recipe.draw(3, 0))) == before {
                        silent.push(format!("{} of {}: {value} and {other}", path, subject.name()));
                    }
                }
            }
        }
    }
    assert!(silent.is_empty() && told > 25, "{told} told; these do nothing: {silent:#?}");
}

#[test]
fn facets_on_a_pack_are_refused() {
    let text = "name: a\nsubject: blister\nclasses: {one: {share: 1}}\nlaser: {glints_per_mm: 1}\n";
    let error = Recipe::parse("a.yaml", text).expect_err("no facets").to_string();
    assert!(error.contains("laser.glints_per_mm") && error.contains("below its film"), "{error}");
}

/// What a class alone has, or lacks, is told of that class.
#[test]
fn notes_name_the_class() {
    let text = "name: a\nsubject: wood\nknots: {width_mm: 9}\nclasses:\n  knotty: {share: 1, knots: {sound_count: 2}}\n  \
                clear: {share: 1, knots: {bark_mm: 2}}\n";
    let recipe = Recipe::parse("a.yaml", text).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(recipe.notes().len(), 1, "{:?}", recipe.notes());
    assert!(recipe.notes()[0].starts_with(
        "classes.clear.knots.bark_mm has no effect while `knots.dead_count` and `knots.hole_count` and `knots.loose_count` are 0; "
    ));
}

/// What is asked and cannot show is told: wet places that are dry, a core like all other wood, tubes that have no room.
#[test]
fn what_cannot_show_is_told() {
    let recipe = |keys: &str| {
        let text = format!("name: a\nsubject: wood\nclasses: {{one: {{share: 1}}}}\n{keys}\n");
        Recipe::parse("a.yaml", &text).unwrap_or_else(|error| panic!("{error}"))
    };
    for (keys, note) in [
        (
            "speckle: {strength: 0, surface_patterns: 2}",
            "speckle.surface_patterns has no effect while `speckle.strength` is 0",
        ),
        ("moisture: {patch_count: 2, filled: 0}", "moisture.patch_count has no effect while `moisture.filled` is 0"),
        ("log: {juvenile_rings: 9, juvenile_latewood_ratio: 1}", "log.juvenile_rings has no effect while"),
        ("anatomy: {canals_per_mm2: 20, canal_um: 500}", "anatomy.canal_um can be 500, and where 20 canals stand"),
        ("anatomy: {pores_per_mm2: {uniform: [1, 100]}}", "at most 85 um wide"),
    ] {
        let notes = recipe(keys).notes().to_vec();
        assert!(notes.len() == 1 && notes[0].contains(note), "{keys}: {notes:?}");
    }
    assert!(recipe("anatomy: {pores_per_mm2: 72}").notes().is_empty());
}
