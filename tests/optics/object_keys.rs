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
    let mut text = format!("name: a\nsubject: {}\nunstated: fixed\nclasses: {{one: {{share: 1}}}}\n", subject.name());
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
    let board = "subject: wood\nunstated: fixed\n\
        board: {width_mm: 60, length_mm: 90}\nlog: {pith_depth_mm: 4, pith_offset_mm: 0}\n\
                 stem: {board_radius_mm: 20, whorl_spacing_mm: 40}\n";
    let of_stem = board.replace("pith_depth_mm: 4, pith_offset_mm: 0", "source: stem");
    let board = board.split("stem:").next().expect("it has one");
    let mut rng = Stream::root(3).child("what they lack").rng();
    for (object, least) in [(board, 85), (&of_stem, 70), ("subject: blister\nunstated: fixed\n", 3)] {
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
