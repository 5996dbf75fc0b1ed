//! Every key of every object at another value: it changes the object, or it is refused or noted with what to do. And of
//! every object alone: what it is said to lack changes nothing, so nothing is said to be lacking that is there (the
//! whole kind of "none" for a sample that has the thing: all kinds of knots, of rot, of other defects, on boards from
//! anywhere, and packs).

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use base::{Body, Parameter, Stream};
use rand::RngExt;
use recipe::{Plan, Recipe, SampleNeeds, Scene, Subject};

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
#[ignore = "long"]
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
    let text = "name: a\nsubject: wood\nknots: {width_mm: 9}\nclasses:\n  knotty: {share: 1, knots: {sound_count: \
        2}}\n  \
                clear: {share: 1, knots: {bark_mm: 2}}\n";
    let recipe = Recipe::parse("a.yaml", text).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(recipe.notes().len(), 1, "{:?}", recipe.notes());
    assert!(recipe.notes()[0].starts_with(
        "classes.clear.knots.bark_mm has no effect while `knots.dead_count` and `knots.hole_count` and \
            `knots.loose_count` are 0; "
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

/// The scene with other values of some numbers of its object.
fn with_values(scene: &Scene, changed: &BTreeMap<String, f64>) -> Scene {
    let old: BTreeMap<String, f64> = scene.plan.values().into_iter().map(|(p, value)| (p.path(), value)).collect();
    let value = &mut |p: &'static Parameter| changed.get(&p.path()).copied().unwrap_or(old[&p.path()]);
    Scene { plan: Plan::from_values(scene.plan.subject(), value), ..scene.clone() }
}

/// Random objects, each with a few of the things that the numbers are of: numbers of what one lacks change nothing of
/// it.
#[test]
#[ignore = "long"]
fn what_an_object_is_said_to_lack_changes_nothing() {
    let board = "subject: wood\nboard: {width_mm: 60, length_mm: 90}\nlog: {pith_depth_mm: 4, pith_offset_mm: 0}\n\
                 stem: {board_radius_mm: 20, whorl_spacing_mm: 40}\n";
    let of_stem = board.replace("pith_depth_mm: 4, pith_offset_mm: 0", "source: stem");
    let board = board.split("stem:").next().expect("it has one");
    let mut rng = Stream::root(3).child("what they lack").rng();
    for (object, least) in [(board, 85), (&of_stem, 70), ("subject: blister\n", 3)] {
        let text = format!("name: a\nclasses: {{one: {{share: 1}}}}\n{object}");
        let recipe = Recipe::parse("a.yaml", &text).unwrap_or_else(|error| panic!("{error}"));
        let canonical = recipe.canonical();
        let usual = recipe.draw(3, 0);
        let conditional: Vec<(&Parameter, SampleNeeds)> = usual
            .plan
            .values()
            .into_iter()
            .filter_map(|(p, _)| Some((p, SampleNeeds::new(&canonical, &p.path())?)))
            .collect();
        assert!(conditional.len() >= least, "{} numbers of {object}", conditional.len());
        // Sizes of a pack are no amounts.
        let mut deciders: Vec<&str> = conditional
            .iter()
            .flat_map(|(_, needs)| needs.deciders())
            .copied()
            .filter(|path| !path.starts_with("tablet.") && !["pocket.headroom_mm", "pocket.dome_mm"].contains(path))
            .collect();
        deciders.sort_unstable();
        deciders.dedup();
        // How often each is lacking, and how often not.
        let mut counts = vec![[0_u32; 2]; conditional.len()];
        for trial in 0..20 {
            let share = if trial % 2 == 0 { 0.1 } else { 0.4 };
            let mut drawn = BTreeMap::new();
            for path in &deciders {
                let parameter = usual.plan.values().into_iter().map(|(p, _)| p).find(|p| p.path() == *path);
                let Some(p) = parameter else { continue };
                let none = if p.name.ends_with("_ratio") { 1.0 } else { 0.0 };
                let some = if p.integer { 3.0 } else { (p.min + 0.4 * (p.max - p.min)).min(12.0) };
                drawn.insert(p.path(), if rng.random::<f64>() < share { some.max(p.min) } else { none });
            }
            let scene = with_values(&usual, &drawn);
            let number = |path: &str| scene.plan.values().into_iter().find(|(p, _)| p.path() == path).map(|(_, v)| v);
            let mut lacking = Vec::new();
            for ((p, needs), counts) in conditional.iter().zip(&mut counts) {
                let values: Vec<_> = needs.deciders().iter().map(|path| number(path)).collect();
                let is_lacking = needs.are_unmet(&values);
                counts[usize::from(is_lacking)] += 1;
                if is_lacking {
                    lacking.push(*p);
                }
            }
            let before = answers(&pipeline::body(&scene));
            let changed = |numbers: &[&Parameter]| -> bool {
                let other = |p: &&Parameter| {
                    let value = number(&p.path()).expect("it is of the object");
                    let end = if p.max - value > value - p.min { p.max } else { p.min };
                    let other = value + 0.4 * (end - value);
                    (p.path(), if p.integer { other.round() } else { other })
                };
                let other = with_values(&scene, &numbers.iter().map(other).collect());
                answers(&pipeline::body(&other)) != before
            };
            // Two that decide each other have an effect together.
            let (alone, together): (Vec<&Parameter>, Vec<_>) =
                lacking.into_iter().partition(|p| deciders.contains(&p.path().as_str()));
            let mut which: Vec<_> = alone.into_iter().filter(|p| changed(&[p])).collect();
            if changed(&together) {
                which.extend(together.into_iter().filter(|p| changed(&[p])));
            }
            let which: Vec<String> = which.iter().map(|p| p.path()).collect();
            assert!(which.is_empty(), "trial {trial} of {object}with {drawn:?} has what these are of: {which:?}");
        }
        for ((p, _), counts) in conditional.iter().zip(counts) {
            let path = p.path();
            assert!(counts.iter().all(|n| *n > 0) || path.starts_with("tablet."), "{path} of {object}: {counts:?}");
        }
    }
}

/// Counts say themselves that there is nothing; what boards from elsewhere have is not asked of counts that these don't
/// have.
#[test]
fn counts_are_never_lacking() {
    let of = |source: &str, path: &str| {
        let canonical = serde_json::json!({"subject": "wood", "log": {"source": source}});
        SampleNeeds::new(&canonical, path)
    };
    for source in ["placed", "stem", "measured", "picture", "slices"] {
        for path in
            ["knots.sound_count", "knots.dead_count", "knots.hole_count", "knots.loose_count", "rot.pocket_count"]
        {
            assert!(of(source, path).is_none(), "{path} of {source}");
        }
        for path in ["rot.heart_mm", "rot.reach_mm", "exposure.time_us", "physics.speckle_volume", ""] {
            assert!(of(source, path).is_none(), "{path} of {source}");
        }
        if source != "placed" {
            for path in
                ["knots.width_mm", "knots.hole_depth_mm", "knots.loose_gap_mm", "knots.flow_ratio", "media.knot_n_eff"]
            {
                assert!(of(source, path).is_none(), "{path} of {source}");
            }
        }
    }
    let needs = of("placed", "knots.width_mm").expect("there may be no knot");
    assert_eq!(needs.deciders().len(), 4);
    assert!(needs.are_unmet(&[Some(0.0); 4]) && !needs.are_unmet(&[Some(0.0), None, Some(2.0), None]));
    // A dataset of before such knots were there has none of them.
    assert!(needs.are_unmet(&[None, None, Some(0.0), None]));
}
