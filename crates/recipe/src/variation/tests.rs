//! What is not stated: drawn within its natural range, out of the way of what is stated, and told.

use std::collections::BTreeMap;

use base::Words;

use super::*;
use crate::{Recipe, Subject};

fn parse(text: &str) -> Recipe {
    Recipe::parse("test", text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn draws(recipe: &Recipe, index: u64) -> BTreeMap<String, f64> {
    recipe.draw(3, index).draws().into_iter().collect()
}

const SUBJECTS: [&str; 3] = ["wood", "blister", "sawtooth"];

/// What varies by nature is drawn from the declared distribution; all else, and all with `unstated: fixed`, is at its
/// default.
#[test]
fn what_is_not_stated_is_drawn_by_nature_or_fixed() {
    for subject in SUBJECTS {
        let text = format!("name: a\nsubject: {subject}\nclasses: {{a: {{share: 1}}}}\n");
        let [drawn, fixed] = ["drawn", "fixed"].map(|word| parse(&format!("{text}unstated: {word}\n")));
        assert_eq!(drawn.hash(), parse(&text).hash(), "drawn is the default");
        let natural = &drawn.variation.natural;
        assert!(natural.len() >= 20, "{subject}: {natural:?}");
        for parameter in keys::parameters(Subject::named(subject)) {
            let (path, own) = (parameter.path(), Distribution::natural(parameter));
            let expected = if natural.contains(&path) { own } else { Distribution::Fixed(parameter.default) };
            assert_eq!(drawn.distribution("a", &path), Some(&expected), "{path}");
            assert_eq!(fixed.distribution("a", &path), Some(&Distribution::Fixed(parameter.default)), "{path}");
        }
        // Nothing is drawn that has no effect, and what is off stays off.
        assert!(!natural.contains("rot.severity") && !natural.contains("laser.lobe_distance"), "{natural:?}");
        let (count, held) = (drawn.variation(), fixed.variation());
        // The usual card has hardly room for the widest pockets: one number of them gives way.
        assert_eq!((count.stated, count.natural), (0, natural.len()));
        assert!(count.held <= 1 && count.telling.is_empty(), "{subject}: {count:?}");
        assert_eq!((held.stated, held.natural, held.held), (0, 0, natural.len() + count.held));
        assert!(count.warning().is_none() && held.warning().is_some(), "{held:?}");
        assert!(held.told().contains(&format!("{} more", held.held)), "{}", held.told());
        // Its canonical form states all of it.
        let again = parse(&drawn.canonical_json());
        assert_eq!((again.hash(), again.canonical_json()), (drawn.hash(), drawn.canonical_json()));
    }
}

/// A number that is stated leaves every other draw as it was, but of one that goes with it by nature.
#[test]
fn stating_a_number_leaves_the_others() {
    let text = "name: a\nsubject: wood\nclasses: {a: {share: 1}, b: {share: 1, rot: {reach_mm: 5}}}\n";
    let (whole, stated) = (parse(text), parse(&format!("{text}log: {{ring_width_mm: 2}}\n")));
    assert!(whole.is_correlated("log.ring_width_mm") && !stated.is_correlated("log.latewood_share"));
    for index in 0..20 {
        let (mut one, mut other) = (draws(&whole, index), draws(&stated, index));
        for path in ["log.ring_width_mm", "log.latewood_share"] {
            one.remove(path);
            other.remove(path);
        }
        assert_eq!(one, other);
    }
    assert!(whole.variation.natural.contains("rot.severity"), "a class has rot");
}

/// Wide rings have less latewood, and a recipe's own pairs come first.
#[test]
fn what_goes_together_by_nature_does() {
    let text = "name: a\nsubject: wood\nclasses: {a: {share: 1}}\n";
    let pairs = |text: &str| parse(text).canonical()["correlations"].clone();
    let known: Vec<[&str; 2]> = CORRELATED.iter().map(|(a, b, _)| [*a, *b]).collect();
    assert!(
        known.iter().all(|[a, b]| a < b && keys::parameter(None, a).is_some() && keys::parameter(None, b).is_some())
    );
    assert_eq!(pairs(text).as_array().map(Vec::len), Some(4), "{}", pairs(text));
    let own = "correlations: [{keys: [log.ring_width_mm, log.streak], spearman: 0.5}]\n";
    let own = pairs(&format!("{text}{own}"));
    assert!(!own.to_string().contains("latewood_share") && own.as_array().map(Vec::len) == Some(4), "{own}");
}

/// Natural numbers go back to their defaults where what is stated leaves them no room: a recipe is at fault only where
/// it would be with `unstated: fixed`.
#[test]
fn natural_numbers_give_way_to_stated_ones() {
    let text = "name: a\nsubject: blister\ntablet: {thickness_mm: 2.4}\nclasses: {a: {share: 1}}\n";
    let recipe = parse(text);
    assert!(!recipe.variation.natural.contains("tablet.band_mm") && recipe.variation.natural.contains("tablet.gloss"));
    assert_eq!(recipe.distribution("a", "tablet.band_mm"), Some(&Distribution::Fixed(2.4)));
    for rest in ["tablet: {thickness_mm: 2}\n", "exposure: {dark_noise_dn: 0.5}\n", "pack: {width_mm: 30}\n"] {
        let [drawn, fixed] = ["drawn", "fixed"].map(|word| {
            let text = format!("name: a\nsubject: blister\nunstated: {word}\nclasses: {{a: {{share: 1}}}}\n{rest}");
            Recipe::parse("test", &text).map(|recipe| recipe.hash()).map_err(|error| error.to_string())
        });
        assert_eq!(drawn.is_ok(), fixed.is_ok(), "{rest}: {drawn:?}\n{fixed:?}");
        assert!(drawn.is_ok() || drawn == fixed, "{drawn:?}\n{fixed:?}");
    }
}

/// The files that are built in state what they hold fixed, so that nothing of theirs varies by nature.
#[test]
fn nothing_of_a_built_in_recipe_varies_by_nature() {
    for known in Recipe::embedded() {
        let recipe = Recipe::load(known.name).expect("built in");
        assert!(recipe.variation.natural.is_empty(), "{}", known.name);
    }
}
