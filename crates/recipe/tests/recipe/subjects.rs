//! Purpose: a recipe about one subject has that subject's keys and rules, and says whose the others are.

use crate::support::{GOOD, faults, only, whole};
use recipe::Recipe;

/// As [`only`], in a recipe about packs.
fn only_pack(line: &str, place: (usize, usize), key: &str, words: &[&str]) {
    whole(&format!("{}{line}\n", GOOD.replace("wood", "blister")), (place.0 + 3, place.1), key, words);
}

#[test]
fn numbers_of_a_pack_must_fit_together() {
    Recipe::parse("good.yaml", &GOOD.replace("wood", "blister")).expect("defaults fit together");
    only_pack("pack: {pitch_x_mm: 14}", (1, 8), "pack.pitch_x_mm", &["14 mm apart along the laser line", "move"]);
    only_pack("pack: {pitch_y_mm: {uniform: [9, 17]}}", (1, 8), "pack.pitch_y_mm", &["9 mm apart along the scan"]);
    only_pack("pack: {columns: 4}", (1, 8), "pack.columns", &["58 mm along the laser line", "need 7"]);
    only_pack("pack: {length_mm: 40}", (1, 8), "pack.length_mm", &["40 mm along the scan", "larger"]);
    only_pack("pocket: {draft_deg: 25}", (1, 10), "pocket.draft_deg", &["mm apart along the scan", "steeper"]);
    let caplet = "tablet: {length_mm: 15, width_mm: 7}\npocket: {turn_deg: {uniform: [0, 90]}}";
    let faults = faults(&format!("{}{caplet}\n", GOOD.replace("wood", "blister")));
    assert!(faults.to_string().contains("along the laser line") && faults.to_string().contains("along the scan"));
    only_pack("tablet: {band_mm: 2, thickness_mm: 1.5}", (1, 10), "tablet.band_mm", &["2 mm", "1.5 mm thick"]);
    let low = "laser: {fan_height_mm: 20}\ntablet: {thickness_mm: 15, band_mm: 2}\npack: {pitch_x_mm: 34, pitch_y_mm: \
        34, width_mm: 120, length_mm: 120}\npocket: {headroom_mm: 5}";
    only_pack(low, (1, 9), "laser.fan_height_mm", &["20 mm high", "mm thick", "above the pack"]);
}

/// Hard capsules are as thick as wide, and a pocket for two tablets is formed deeper.
#[test]
fn laser_and_camera_stand_above_all_that_a_pack_can_become() {
    let card = "pack: {pitch_x_mm: 50, pitch_y_mm: 50, width_mm: 170, length_mm: 170}";
    let capsule = "tablet: {shape: 2, length_mm: 25, width_mm: 20, thickness_mm: 0.5, band_mm: 0.2}";
    let low = format!("laser: {{fan_height_mm: 20}}\n{capsule}\n{card}");
    only_pack(&low, (1, 9), "laser.fan_height_mm", &["20 mm high", "mm thick", "above the pack"]);
    let either = low.replace("shape: 2", "shape: {choice: {values: [0, 2]}}");
    only_pack(&either, (1, 9), "laser.fan_height_mm", &["20 mm high", "above the pack"]);
    let text = |defects: &str| {
        let pack = "tablet: {thickness_mm: 8, band_mm: 4}\npack: {bow_mm: {uniform: [-1, 0]}, pitch_y_mm: 18}\nlaser: \
            {fan_height_mm: 20}";
        format!("name: a\nsubject: blister\nclasses: {{a: {{share: 1{defects}}}}}\n{pack}\n")
    };
    Recipe::parse("single.yaml", &text("")).expect("one tablet has room");
    whole(&text(", defects: {double: 1}"), (3, 35), "classes.a.defects.double", &["20 mm high", "above the pack"]);
}

/// A warp takes the more room of pockets the smaller the card is.
#[test]
fn pockets_fit_on_the_smallest_card() {
    let text = |width: &str| format!("pack: {{pitch_x_mm: 16.55, columns: 2, bow_mm: 3, width_mm: {width}}}");
    let good = |width: &str| format!("{}{}\n", GOOD.replace("wood", "blister"), text(width));
    Recipe::parse("large.yaml", &good("{uniform: [110, 120]}")).expect("a large card has room");
    only_pack(&text("{uniform: [40, 120]}"), (1, 8), "pack.pitch_x_mm", &["mm apart along the laser line", "move"]);
}

/// Counts that no pack has pockets for are refused; kinds that always exclude each other are noted.
#[test]
fn defects_have_pockets() {
    only_pack(
        "pack: {columns: 2, rows: 1}\ndefects: {missing: 3}",
        (2, 11),
        "defects.missing",
        &["asks for 3 of at most 2 pockets", "more pockets"],
    );
    only_pack("defects: {missing: 0.3}", (1, 20), "defects.missing", &["not whole", "no share"]);
    let good = |class: &str| {
        let text = format!(
            "name: a\nsubject: blister\npack: {{columns: 2, rows: 1}}\nclasses: {{a: {{share: 1, defects: {class}}}}}\n"
        );
        Recipe::parse("p.yaml", &text).expect("some packs can have them").notes().to_vec()
    };
    assert_eq!(good("{missing: {uniform: [1, 4]}, wrinkle: 5}"), Vec::<String>::new());
    assert_eq!(good("{missing: 1, broken: 1}"), Vec::<String>::new());
    let notes = good("{missing: {uniform: [1, 3]}, broken: 2}");
    let told = |note: &String| {
        ["classes.a.defects.missing", "3 or more", "at most 2 pockets"].iter().all(|word| note.contains(word))
    };
    assert!(notes.iter().any(told), "{notes:?}");
}

#[test]
fn a_pack_needs_light_that_knows_air() {
    for model in ["diffusion", "thesis"] {
        only_pack(
            &format!("transport: {model}"),
            (1, 1),
            "transport",
            &[model, "no film over air", "`kernel`, or `path`"],
        );
        let long = format!("transport: {{model: {model}}}");
        only_pack(&long, (1, 13), "transport.model", &["subject is `blister`"]);
        Recipe::parse("wood.yaml", &format!("{GOOD}transport: {model}\n")).expect("wood knows it");
    }
    for model in ["kernel", "path"] {
        Recipe::parse("p.yaml", &format!("{}transport: {model}\n", GOOD.replace("wood", "blister"))).expect(model);
    }
}

#[test]
fn keys_of_another_subject_say_whose_they_are() {
    only("pack: {columns: 2}", (1, 1), "pack", &["`pack` is for subject `blister`", "remove it", "`subject: blister`"]);
    only("board: {columns: 2}", (1, 9), "board.columns", &["belongs in `scan`"]);
    only("board: {headroom_mm: 2}", (1, 9), "board.headroom_mm", &["of `pocket` is for subject `blister`"]);
    only_pack("rot: {reach_mm: 2}", (1, 1), "rot", &["`rot` is for subject `wood`"]);
    only_pack("foil: {bark_mm: 2}", (1, 8), "foil.bark_mm", &["of `knots` is for subject `wood`"]);
    let class = "name: a\nsubject: blister\nclasses: {a: {share: 1, knots: {}}}\n";
    whole(class, (3, 25), "classes.a.knots", &["is for subject `wood`"]);
    // While the subject is a fault itself, whose a key is stays open.
    whole(
        "name: a\nsubject: bister\nclasses: {a: {share: 1, knots: {}}}\npack: {}\n",
        (2, 10),
        "subject",
        &["blister"],
    );
}
