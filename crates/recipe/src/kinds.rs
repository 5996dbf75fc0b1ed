//! Kinds: the classes of a recipe that names none, one of each kind of sample that its subject has.
//!
//! Shares are estimates of what a line sees where somebody has looked for defects [M]: sound objects lead, common kinds
//! follow. Extents fit objects from 20 mm on. Kinds that the recipe's source of boards cannot have (counted knots in
//! boards out of a stem, decay in boards from a picture) are left out.

use yaml::{YamlReader, parse_yaml};

use super::class::SampleClass;
use super::constraints::needs;
use super::keys::settings::Settings;
use super::reader;
use super::subject::Subject;

const BOARDS: &str = "\
clear: {share: 0.28}
sound_knot: {share: 0.16, knots: {sound_count: {uniform: [1, 3]}}}
dead_knot: {share: 0.1, knots: {dead_count: {uniform: [1, 3]}}}
loose_knot: {share: 0.03, knots: {loose_count: {uniform: [1, 2]}}}
knot_hole: {share: 0.03, knots: {hole_count: {uniform: [1, 2]}}}
rot: {share: 0.08, rot: {reach_mm: {uniform: [3, 10]}}}
pocket_rot: {share: 0.03, rot: {pocket_count: {uniform: [1, 4]}, transition_mm: {uniform: [1, 2]}}}
blue_stain: {share: 0.06, stain: {severity: {uniform: [0.4, 1]}}}
compression_wood: {share: 0.04, compression: {severity: {uniform: [0.5, 1]}}}
resin: {share: 0.05, inclusions: {resin_pocket_count: {uniform: [1, 3]}}}
bark_pocket: {share: 0.03, inclusions: {bark_pocket_count: {uniform: [1, 2]}}}
crack: {share: 0.04, cracks: {check_count: {uniform: [1, 4]}}}
shake: {share: 0.01, cracks: {shake_count: 1}}
insect: {share: 0.02, holes: {count: {uniform: [2, 12]}}}
wane: {share: 0.02, wane: {width_mm: {uniform: [2, 6]}}}
dirt: {share: 0.02, marks: {dirt_count: {uniform: [1, 5]}}}
";

const PACKS: &str = "\
sound: {share: 0.32}
missing: {share: 0.1, defects: {missing: {uniform: [1, 2]}}}
broken: {share: 0.07, defects: {broken: {uniform: [1, 2]}}}
chipped: {share: 0.06, defects: {chipped: {uniform: [1, 2]}}}
cracked: {share: 0.05, defects: {cracked: {uniform: [1, 2]}}}
capped: {share: 0.03, defects: {capped: {uniform: [1, 2]}}}
foreign_tablet: {share: 0.05, defects: {foreign_tablet: {uniform: [1, 2]}}}
wrong_coat: {share: 0.04, defects: {wrong_coat: {uniform: [1, 2]}}}
double: {share: 0.02, defects: {double: 1}}
particle: {share: 0.03, defects: {particle: {uniform: [1, 2]}}}
fibre: {share: 0.03, defects: {fibre: {uniform: [1, 2]}}}
powder: {share: 0.03, defects: {powder: {uniform: [1, 2]}}}
shallow: {share: 0.03, defects: {shallow: {uniform: [1, 2]}}}
collapsed: {share: 0.03, defects: {collapsed: {uniform: [1, 2]}}}
punctured: {share: 0.02, defects: {punctured: {uniform: [1, 2]}}}
pinhole: {share: 0.02, defects: {pinhole: {uniform: [1, 2]}}}
channel: {share: 0.02, defects: {channel: {uniform: [1, 2]}}}
wrinkle: {share: 0.02, defects: {wrinkle: {uniform: [1, 2]}}}
delamination: {share: 0.02, defects: {delamination: {uniform: [1, 2]}}}
tablet_on_flange: {share: 0.01, defects: {tablet_on_flange: 1}}
";

const PIECES: &str = "sound: {share: 1}\n";

/// The classes of a recipe about `subject` that names none.
pub(super) fn usual(subject: Option<Subject>, settings: &Settings) -> Vec<SampleClass> {
    let text = match subject {
        Some(Subject::Wood) => BOARDS,
        Some(Subject::Blister) => PACKS,
        Some(Subject::Sawtooth | Subject::Mesh) | None => PIECES,
    };
    let root = parse_yaml(text, "recipe").unwrap_or_else(|_| panic!("a test reads it"));
    let can_be = |class: &SampleClass| class.overrides.keys().all(|key| needs::has_room_in(key, settings.log.source));
    // Its places are none of the recipe's.
    let mut yaml = YamlReader::new(text, "recipe");
    let mut classes = reader::classes(&mut yaml, &root, subject);
    classes.retain(can_be);
    reader::share_out(&mut yaml, &mut classes);
    classes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Recipe;

    /// Every defect of packs has a kind, and boards from any source have those that they can have.
    #[test]
    fn a_recipe_without_classes_has_one_of_each_kind() {
        let names = |text: &str| -> Vec<String> {
            let recipe = Recipe::parse("kinds", text).unwrap_or_else(|error| panic!("{error}"));
            let sum: f64 = recipe.classes().iter().map(|class| class.share).sum();
            assert!((sum - 1.0).abs() < 1e-9, "{text}: {sum}");
            recipe.classes().iter().map(|class| class.name.clone()).collect()
        };
        let packs = names("name: a\nsubject: blister\n");
        let counts = crate::keys::parameters(Some(Subject::Blister)).filter(|p| p.group == "defects" && p.integer);
        counts.for_each(|count| assert!(packs.iter().any(|name| name == count.name), "{}", count.name));
        let boards = names("name: a\nsubject: wood\n");
        assert_eq!(boards.len(), 16);
        let sawn = names("name: a\nsubject: wood\nlog: {source: stem}\n");
        assert!(sawn.contains(&"rot".to_owned()) && !sawn.contains(&"sound_knot".to_owned()), "{sawn:?}");
        let pictured = names(
            "name: a\nsubject: wood\nlog: {source: picture}\npicture: {file: pictures/board.png}\n\
            board: {width_mm: 20, length_mm: 20}\n",
        );
        assert!(pictured.contains(&"wane".to_owned()) && !pictured.contains(&"rot".to_owned()), "{pictured:?}");
        assert_eq!(names("name: a\nsubject: sawtooth\n"), ["sound"]);
        // `null` takes the parent's classes away.
        let own = names("extends: blister-small\nname: a\nclasses: null\n");
        assert_eq!(own, packs);
    }
}
