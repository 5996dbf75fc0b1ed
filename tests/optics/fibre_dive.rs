//! Clear wood as recipes draw it: how far its Reflectance changes with the dive of the fibres, and the ellipse of a
//! point of light on it, within what docs/theory/wood.md says of both.

use base::Medium;
use glam::Vec3;
use pipeline::effective::earlywood;
use recipe::{Plan, Recipe};
use transport::answer::{Answer, Question};
use transport::kernel;
use transport::stack::Stack;

/// Draws of each recipe.
const DRAWS: u64 = 40;
/// Cells on either side of a point of light, and their pitch [mm].
const CELLS: usize = 32;
const CELL_MM: f64 = 0.15;
/// Half axis across the fibre at which an ellipse is measured [cells]: 1.5 mm.
const ACROSS: usize = 10;

/// Clear wood of each recipe of boards that is built in, but for the thesis', which says nothing of fibres.
fn clear_wood() -> impl Iterator<Item = (&'static str, Vec<Medium>)> {
    let of_thesis = |name: &str| name.starts_with("thesis/");
    Recipe::embedded().map(|built_in| built_in.name).filter(move |name| !of_thesis(name)).filter_map(|name| {
        let recipe = Recipe::load(name).expect("built in");
        let boards = (0..DRAWS).map(|i| match recipe.draw(51, i * recipe.boards_per_log()).plan {
            Plan::Wood(wood) => Some(earlywood(&wood.media)),
            _ => None,
        });
        Some((name, boards.collect::<Option<Vec<_>>>()?))
    })
}

/// The kernel's answer where the fibres rise away from the camera by this angle, `cells` about a point.
fn answer(wood: &Medium, dive_deg: f64, cells: usize) -> Answer {
    let (sin, cos) = libm::sincos(dive_deg.to_radians());
    let wood = Medium { fibre: Vec3::new(0.0, cos as f32, sin as f32), ..*wood };
    let question = Question { cells, cell_mm: CELL_MM, angles: 0, ..Question::default() };
    kernel::solve(&Stack::from(&wood), &question).expect("a recipe's media are the kernel's")
}

/// Relative change of the brightest row for a degree of dive, about fibres in the surface [1].
fn change(wood: &Medium) -> f64 {
    let peak = |dive| answer(wood, dive, 0).seen.iter().fold(0.0, |most: f64, row| most.max(row.value));
    0.5 * libm::log(peak(1.0) / peak(-1.0))
}

/// Length over width of the line of equal light whose half width is [`ACROSS`] [1].
fn ellipse(wood: &Medium) -> f64 {
    let point = answer(wood, 0.0, CELLS).point;
    let side = 2 * CELLS + 1;
    let at = |x: usize, y: usize| point[y * side + x].value;
    let level = at(CELLS + ACROSS, CELLS);
    let long = (0..side).filter(|&y| at(CELLS, y) > level).count();
    0.5 * long as f64 / ACROSS as f64
}

/// 1 to 6 % for a degree in nine of ten draws of each recipe, none above 8 %; ellipses of 1.5 to 3, to 0.1.
#[test]
fn reflectance_follows_dive_as_far_as_on_sawn_wood() {
    let mut recipes = 0;
    for (name, woods) in clear_wood() {
        let mut changes: Vec<f64> = woods.iter().map(change).collect();
        changes.sort_by(f64::total_cmp);
        let ellipses: Vec<f64> = woods.iter().step_by(8).map(ellipse).collect();
        let within = changes.iter().filter(|change| (0.01..0.06).contains(*change)).count();
        println!("{name}: {within} of {DRAWS}, {:.3} to {:.3}; {ellipses:.2?}", changes[0], changes[changes.len() - 1]);
        assert!(10 * within >= 9 * woods.len() && changes[changes.len() - 1] < 0.08, "{name}: {changes:.3?}");
        assert!(ellipses.iter().all(|ratio| (1.4..3.1).contains(ratio)), "{name}: {ellipses:.2?}");
        recipes += 1;
    }
    assert_eq!(recipes, 16, "recipes of boards");
}

/// The check can fail: fibres of 5 degrees and little between them change by more.
#[test]
fn straight_fibres_change_more() {
    let change = change(&Medium::CLEAR_WOOD);
    assert!(change > 0.09, "{change}");
}
