//! Purpose: numbers of the movement that have no effect, or no meaning together, are refused with a remedy.

use crate::support::{GOOD, only, whole};
use optical_bench::settings::{Movement, SpeckleLaw};
use recipe::Recipe;

#[test]
fn numbers_without_effect_are_refused() {
    let idle = &["has no effect while `motion.wow_um` is 0", "give `motion.wow_um` too"];
    only("motion: {wow_period_mm: 100}", (1, 10), "motion.wow_period_mm", idle);
    let still = &["has no effect while `motion.line_rate_hz` is 0", "give `motion.line_rate_hz` too"];
    only("motion: {vibration_um: 20}", (1, 10), "motion.vibration_um", still);
    let calm = &["has no effect while `motion.vibration_um` is 0"];
    only("motion: {line_rate_hz: 1000, vibration_hz: 50}", (1, 30), "motion.vibration_hz", calm);
    let linear = &["has no effect on `kind: linear`", "`kind: turntable`"];
    only("motion: {turn_radius_mm: 20}", (1, 10), "motion.turn_radius_mm", linear);
    only("motion: {turn_axis_y_mm: 20}", (1, 10), "motion.turn_axis_y_mm", linear);
}

#[test]
fn profiles_stay_in_order() {
    let steep = &["314 % too short", "at most 50 %"];
    only("motion: {wow_um: 5000, wow_period_mm: 10}", (1, 10), "motion.wow_um", steep);
}

/// A class that gives the amount wakes the top level's number up.
#[test]
fn what_a_class_has_use_for_is_no_fault() {
    let class = "classes: {clear: {share: 1, motion: {wow_um: 30}}}";
    let text = GOOD.replace("classes: {clear: {share: 1}}", class) + "motion: {wow_period_mm: 100}\n";
    assert!(text.contains(class));
    Recipe::parse("wow.yaml", &text).expect("the class has use for it");
}

#[test]
fn a_turntable_is_refused_where_it_is_not_known() {
    let words = &["a straight way alone", "kind: linear"];
    only("motion: {kind: turntable}\ntransport: path", (1, 10), "motion.kind", words);
    let words = &["a second line", "motion.kind: linear"];
    only("motion: {kind: turntable}\nlaser: {second_line_mm: 4}", (2, 9), "laser.second_line_mm", words);
    let pack = GOOD.replace("subject: wood", "subject: blister") + "motion: {kind: turntable}\n";
    whole(&pack, (4, 10), "motion.kind", &["a pack hides and lights itself", "another subject"]);
}

#[test]
fn words_arrive() {
    let text = format!("motion: {{kind: turntable}}\nspeckle: {{law: rayleigh}}\n{GOOD}");
    let scene = Recipe::parse("words.yaml", &text).expect("it is good").draw(0, 0);
    assert_eq!((scene.movement, scene.speckle_law), (Movement::Turntable, SpeckleLaw::Rayleigh));
    assert_eq!(SpeckleLaw::ALL.map(SpeckleLaw::name), SpeckleLaw::NAMES);
}
