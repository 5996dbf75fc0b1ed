//! Monte Carlo on packs against Monte Carlo in plane layers, against closed forms, and against itself.

use base::{Body, Class, Gloss, Medium, Stream, Surface};
use glam::{DVec2, DVec3, Mat3, Vec3};
use procedural::blister::{CardFilm, Solid, solid};
use procedural::flat::Flat;

use super::super::height_cells::HeightCells;
use super::PackGeometry;
use super::microfacets::Microfacets;
use super::shape::{PackColumn, PackShape};
use crate::path::line_response::{EnergyBalance, illuminate_target};
use crate::path::{Effort, solve};
use transport::answer::{Answer, Estimate, Question};
use transport::line::{LineResponse, LineSource};
use transport::stack::PIGMENT_G;
use transport::stack::{Foil, Layer, Scattering, Stack, Substrate};

const METAL: Gloss = Gloss { share: 1.0, reflectance: 0.9, roughness: [0.1, 0.3], matte: 0.0 };
/// Smoother, so that few facets throw light into the foil: the layered model and this one then differ in what becomes
/// of it.
const SMOOTH: Gloss = Gloss { roughness: [0.05, 0.1], ..METAL };
/// Upper side of the film over the conveyor [mm].
const TOP: f32 = 20.0;

fn film(mu_a: f32, sigma: f32) -> Medium {
    Medium::isotropic(mu_a, sigma, 1.53, Gloss::NONE)
}

fn tablet(mu_a: f32, coat: f32) -> Medium {
    Medium { coat, ..Medium::isotropic(mu_a, 40.0, 1.5, Gloss::NONE) }
}

/// A flat round tablet about the z axis, turned by `turn`, the middle of its top at `top` [mm].
fn disc(top: f32, radius: f32, thickness: f32, turn: Mat3, medium: Medium) -> Solid {
    let shape = solid::SolidShape { segment: 0.0, radius, band: 0.5 * thickness, cap: None };
    let middle = Vec3::new(0.0, 0.0, top) - turn * Vec3::new(0.0, 0.0, 0.5 * thickness);
    Solid::new(shape, Vec::new(), turn, middle, medium, Class::Pocket, 0)
}

/// A card of 60 mm, `sheet` over `foil`, sloping along y.
fn card(sheet: CardFilm, foil: (Surface, Medium), solids: Vec<Solid>) -> PackGeometry {
    let corners = [DVec2::splat(-30.0), DVec2::splat(30.0)];
    let at = |surface: Surface, y: f32| Surface { z: surface.z + surface.slope_y * y, ..surface };
    let shape = PackShape::new(HeightCells::new(corners, corners), solids, |x, y| {
        let sheet = CardFilm { surface: at(sheet.surface, y), ..sheet };
        (x.abs() < 30.0 && y.abs() < 30.0).then_some(PackColumn { sheet: Some(sheet), foil: (at(foil.0, y), foil.1) })
    });
    PackGeometry::new(shape, Question::default().view)
}

/// A level card, film of `thickness` [mm], foil `gap` [mm] below it.
fn flat(medium: Medium, thickness: f32, gap: Option<f32>, foil: Gloss, solids: Vec<Solid>) -> PackGeometry {
    let level = |z: f32| Surface { z, slope_x: 0.0, slope_y: 0.0 };
    let sheet = CardFilm { surface: level(TOP), thickness_mm: thickness, sealed: gap.is_none(), medium };
    card(sheet, (level(TOP - thickness - gap.unwrap_or(0.0)), Medium::opaque(foil)), solids)
}

fn ask(
    geometry: &PackGeometry,
    (row_mm, rows): (f64, usize),
    photons: u64,
    seed: u64,
) -> (LineResponse, EnergyBalance) {
    // Any body: the ground is given.
    let medium = tablet(0.0, 1.0);
    let body = Body::new(Flat { height_mm: 1.0, slope_x: 0.0, slope_y: 0.0, width_mm: 1.0, length_mm: 1.0, medium });
    let (x, power) = (&[-20.0, 0.0, 20.0], &[0.0, 1.0, 0.0]);
    let line = LineSource { body: &body, y: 0.0, line_mm: 0.05, x, power, view: geometry.view, row_mm, rows };
    let (response, balance) = illuminate_target(&line, Effort { photons, seed }, geometry);
    let sum = balance.absorbed.value + balance.left.value + balance.dropped.value + balance.lost.value;
    assert!((sum - 1.0).abs() < 1e-6, "energy {sum}");
    (response, balance)
}

fn layer(thickness: f64, medium: &Medium, g: f64) -> Layer {
    let scattering = Scattering::Isotropic { mu_s: f64::from(medium.sigma_i) / (1.0 - g), g };
    let layer = Layer::new(thickness, f64::from(medium.n_eff), f64::from(medium.mu_a), scattering);
    Layer { coat: f64::from(medium.coat), ..layer }
}

fn agree(what: &str, got: Estimate, other: Estimate, bar: f64) {
    let z = (got.value - other.value) / (got.error.powi(2) + other.error.powi(2)).sqrt();
    println!(
        "{what}: {:.5} +- {:.5} against {:.5} +- {:.5}, z = {z:.2}",
        got.value, got.error, other.value, other.error
    );
    assert!(z.abs() < bar, "{what}: {got:?} against {other:?}, z = {z}");
}

/// What entered, of what a layered answer counts in shares of what came.
fn entered(answer: &Answer, share: Estimate) -> Estimate {
    let scale = 1.0 / (1.0 - answer.specular);
    Estimate { value: share.value * scale, error: share.error * scale }
}

/// The lens sees the low flange of a card up to its edges and beside its holes, where the ray passes over bare ground
/// below the height of the highest pocket; behind a pocket that is high enough it sees nothing, whatever lies between.
#[test]
fn edges_and_holes_hide_nothing() {
    let corners = [DVec2::splat(-30.0), DVec2::splat(30.0)];
    let level = |z: f32| Surface { z, slope_x: 0.0, slope_y: 0.0 };
    let sheet = |z: f32| CardFilm { surface: level(z), thickness_mm: 0.2, sealed: true, medium: film(0.02, 12.0) };
    // A flange of 40 x 40 mm in a field of 60, a hole of 2 x 4 mm, and a block of 6 x 8 mm that stands 5 mm high.
    let shape = PackShape::new(HeightCells::new(corners, corners), Vec::new(), |x, y| {
        let is_hole = (x - 10.0).abs() < 1.0 && y.abs() < 2.0;
        let is_block = (x + 10.0).abs() < 3.0 && y.abs() < 4.0;
        let z = if is_block { TOP } else { TOP - 5.0 };
        let column = || PackColumn { sheet: Some(sheet(z)), foil: (level(z - 0.2), Medium::opaque(METAL)) };
        (x.abs() < 20.0 && y.abs() < 20.0 && !is_hole).then(column)
    });
    let geometry = PackGeometry::new(shape, Question::default().view);
    let ahead = geometry.view.y.signum();
    assert!(geometry.view.x.abs() < 1e-9 && geometry.view.y.abs() > 0.1, "the lens stands along y: {}", geometry.view);
    let seen = |x: f64, y: f64| geometry.visible(DVec3::new(x, ahead * y, f64::from(TOP) - 5.0 + 1e-6));
    // How far a ray goes until it is above the block.
    let reach = 5.0 * geometry.view.y.abs() / geometry.view.z;
    for back in [0.1, 0.5, 0.5 * reach, reach + 0.5] {
        assert!(seen(5.0, 19.9 - back), "{back} mm behind the edge towards the lens");
        assert!(seen(-5.0, -19.9 + back), "{back} mm before the other edge");
        assert!(seen(10.0, -2.3 - back), "{back} mm behind the hole");
    }
    assert!(!seen(-10.0, -4.3 - 0.5 * reach), "behind the block");
    assert!(seen(-10.0, -4.7 - reach), "further behind");
}

/// Level packs are stacks: what leaves, and what the lens sees against the layered model's count in a cone. 3.6
/// standard errors: 14 comparisons, alpha 0.005 together. Light that goes lost along the gap might have left.
#[test]
#[ignore = "long"]
fn level_packs_are_stacks() {
    let (cover, pill) = (film(0.02, 12.0), tablet(0.02, 0.8));
    let under = |gap: f32| vec![disc(TOP - 0.2 - gap, 25.0, 15.0, Mat3::IDENTITY, pill)];
    let over = |gap: f64| vec![layer(0.2, &cover, PIGMENT_G), Layer::air(gap), layer(f64::INFINITY, &pill, 0.0)];
    let slab = |medium: &Medium| layer(0.2, medium, PIGMENT_G);
    let foil = Substrate::Foil(Foil { reflectance: 0.9, roughness: [0.05, 0.1] });
    let tint = film(0.5, 6.0);
    let (clear, air) = (film(0.02, 2.0), Substrate::Index(1.0));
    let black = Gloss { reflectance: 0.0, ..SMOOTH };
    let cases = [
        ("tablet under 0.1 mm", flat(cover, 0.2, Some(16.0), SMOOTH, under(0.1)), over(0.1), air),
        ("touching tablet", flat(cover, 0.2, Some(16.0), SMOOTH, under(0.0)), over(1e-9), air),
        ("black foil", flat(cover, 0.2, Some(3.0), black, Vec::new()), vec![slab(&cover)], air),
        ("foil under 1 mm", flat(cover, 0.2, Some(1.0), SMOOTH, Vec::new()), vec![slab(&cover), Layer::air(1.0)], foil),
        (
            "foil under clear",
            flat(clear, 0.2, Some(1.0), SMOOTH, Vec::new()),
            vec![slab(&clear), Layer::air(1.0)],
            foil,
        ),
        ("sealed", flat(cover, 0.2, None, SMOOTH, Vec::new()), vec![slab(&cover)], foil),
        ("sealed tint", flat(tint, 0.2, None, SMOOTH, Vec::new()), vec![slab(&tint)], foil),
    ];
    for (seed, (name, geometry, layers, below)) in cases.into_iter().enumerate() {
        let effort = Effort { photons: 60_000, seed: 20 + seed as u64 };
        let truth = solve(&Stack { above: 1.0, layers, below }, &Question { cells: 0, ..Question::default() }, effort);
        let (_, balance) = ask(&geometry, (60.0, 0), 40_000, 40 + seed as u64);
        let half = 0.5 * balance.lost.value;
        let left = Estimate { value: balance.left.value + half, error: balance.left.error + half / 3.0 };
        agree(&format!("{name}, left"), left, entered(&truth, truth.reflectance), 3.6);
        agree(&format!("{name}, seen"), balance.seen, entered(&truth, truth.cone.unwrap_or_default()), 3.6);
    }
}

/// Rows 1 to 8 on both sides, as shares, against the light that leaves a stack in all directions. Film
/// sends both alike, but for the last run of light: chi-square of 7 degrees of freedom, alpha 0.001.
#[test]
fn the_line_spread_is_that_of_the_stack() {
    let (cover, pill, rows) = (film(0.02, 20.0), tablet(0.05, 1.0), 8);
    let solids = vec![disc(TOP - 0.2, 25.0, 15.0, Mat3::IDENTITY, pill)];
    let mut geometry = flat(cover, 0.2, Some(16.0), METAL, solids);
    // Seen from beside the line: from before it, light leaves nearer to the lens than where it was turned.
    let view = DVec3::new(geometry.view.y, 0.0, geometry.view.z);
    geometry = PackGeometry::new(geometry.shape, view);
    let (response, _) = ask(&geometry, (0.1, rows), 80_000, 3);
    let layers = vec![layer(0.2, &cover, PIGMENT_G), Layer::air(1e-9), layer(f64::INFINITY, &pill, 0.0)];
    let question = Question { cells: 0, row_mm: 0.1, rows, ..Question::default() };
    let stack = Stack { above: 1.0, layers, below: Substrate::Index(1.0) };
    let truth = solve(&stack, &question, Effort { photons: 80_000, seed: 4 });
    let got = |row: usize| {
        let cells = 3 * row..3 * row + 3;
        let value = response.light[cells.clone()].iter().map(|&v| f64::from(v)).sum();
        Estimate { value, error: response.error[cells].iter().map(|&v| f64::from(v).powi(2)).sum::<f64>().sqrt() }
    };
    let pair = |a: Estimate, b: Estimate| Estimate { value: a.value + b.value, error: a.error.hypot(b.error) };
    let ours: Vec<Estimate> = (1..=rows).map(|d| pair(got(rows - d), got(rows + d))).collect();
    let theirs: Vec<Estimate> = (1..=rows).map(|d| pair(truth.line[rows - d], truth.line[rows + d])).collect();
    let sums = [&ours, &theirs].map(|of| of.iter().map(|e| e.value).sum::<f64>());
    let mut chi2 = 0.0;
    for (row, (a, b)) in ours.iter().zip(&theirs).enumerate() {
        let (a, b) = ([a.value, a.error].map(|v| v / sums[0]), [b.value, b.error].map(|v| v / sums[1]));
        println!("row {}: {:.4} +- {:.4} against {:.4} +- {:.4}", row + 1, a[0], a[1], b[0], b[1]);
        chi2 += (a[0] - b[0]).powi(2) / (a[1] * a[1] + b[1] * b[1]);
    }
    assert!(chi2 < 24.3, "chi-square {chi2} of 7 degrees of freedom");
}

/// A bare tablet tilted by 20 degrees is a half space lit and seen aslant.
#[test]
fn a_bare_tilted_tablet_is_a_half_space_lit_aslant() {
    let (pill, tilt) = (tablet(0.2, 0.7), 20f64.to_radians());
    let turn = Mat3::from_rotation_x(tilt as f32);
    let corners = [DVec2::splat(-30.0), DVec2::splat(30.0)];
    let black = (Surface { z: 0.0, slope_x: 0.0, slope_y: 0.0 }, Medium::opaque(Gloss::NONE));
    let shape = PackShape::new(HeightCells::new(corners, corners), vec![disc(20.0, 14.0, 9.0, turn, pill)], |_, _| {
        Some(PackColumn { sheet: None, foil: black })
    });
    let geometry = PackGeometry::new(shape, Question::default().view);
    let (_, balance) = ask(&geometry, (60.0, 0), 60_000, 5);
    let [along, up] = [turn.y_axis, turn.z_axis].map(|axis| axis.as_dvec3());
    let question = Question {
        incidence: Some(tilt),
        // Light goes towards -z, which is towards -y of the tilted surface.
        incidence_azimuth: -std::f64::consts::FRAC_PI_2,
        view: DVec3::new(0.0, geometry.view.dot(along), geometry.view.dot(up)),
        cells: 0,
        ..Question::default()
    };
    let layers = vec![layer(f64::INFINITY, &pill, 0.0)];
    let stack = Stack { above: 1.0, layers, below: Substrate::Index(1.0) };
    let truth = solve(&stack, &question, Effort { photons: 60_000, seed: 6 });
    // The coat takes its share of what enters, which the stack counts as having come.
    agree("seen", balance.seen, scaled(entered(&truth, truth.towards_lens.unwrap_or_default()), pill), 3.3);
    // What leaves downwards ends at the black foil, with what the tablet absorbs.
    let out = entered(&truth, truth.reflectance);
    let bound = scaled(out, pill).value;
    assert!(
        balance.left.value < bound + 3.0 * balance.left.error && balance.left.value > 0.9 * bound,
        "{balance:?}, {bound}"
    );
}

/// The coat that light has passed where it enters bare.
fn scaled(of: Estimate, medium: Medium) -> Estimate {
    let coat = f64::from(medium.coat);
    Estimate { value: of.value / coat, error: of.error / coat }
}

/// Film that slopes, sealed to foil, is a stack lit aslant: what leaves it, upwards or down.
#[test]
fn sloping_sealed_film_is_a_stack_lit_aslant() {
    let (cover, slope) = (film(0.05, 8.0), 0.35f32);
    let level = |z: f32| Surface { z, slope_x: 0.0, slope_y: slope };
    let sheet = CardFilm { surface: level(TOP), thickness_mm: 0.25, sealed: true, medium: cover };
    let geometry = card(sheet, (level(TOP - 0.4), Medium::opaque(SMOOTH)), Vec::new());
    let (_, balance) = ask(&geometry, (60.0, 0), 60_000, 7);
    let foil = Substrate::Foil(Foil { reflectance: 0.9, roughness: [0.05, 0.1] });
    let stack = Stack { above: 1.0, layers: vec![layer(0.25, &cover, PIGMENT_G)], below: foil };
    let incidence = Some(libm::atan(f64::from(slope)));
    let question =
        Question { incidence, incidence_azimuth: -std::f64::consts::FRAC_PI_2, cells: 0, ..Question::default() };
    let truth = solve(&stack, &question, Effort { photons: 60_000, seed: 8 });
    let out = Estimate {
        value: balance.left.value + balance.dropped.value,
        error: balance.left.error.max(balance.absorbed.error),
    };
    agree("out", out, entered(&truth, truth.reflectance), 3.3);
}

/// A white tablet under white film over a perfect mirror, sealed all around: everything comes back.
#[test]
fn nothing_is_lost_in_a_white_pack() {
    let (cover, pill) = (film(0.0, 12.0), Medium { mu_a: 0.0, ..tablet(0.0, 1.0) });
    let metal = Medium::opaque(Gloss { reflectance: 1.0, ..METAL });
    let corners = [DVec2::splat(-30.0), DVec2::splat(30.0)];
    let turn = Mat3::from_rotation_y(0.1);
    let shape =
        PackShape::new(HeightCells::new(corners, corners), vec![disc(TOP - 1.0, 4.0, 3.0, turn, pill)], |x, y| {
            let level = |z: f32| Surface { z, slope_x: 0.0, slope_y: 0.0 };
            let sealed = x.hypot(y) > 6.0;
            let sheet = CardFilm { surface: level(TOP), thickness_mm: 0.2, sealed, medium: cover };
            let foil = (level(if sealed { TOP - 0.2 } else { TOP - 6.0 }), metal);
            (x.abs() < 30.0 && y.abs() < 30.0).then_some(PackColumn { sheet: Some(sheet), foil })
        });
    let (_, balance) = ask(&PackGeometry::new(shape, Question::default().view), (60.0, 0), 10_000, 9);
    assert!(balance.absorbed.value.abs() < 1e-12 && balance.left.value > 0.999, "{balance:?}");
}

/// The same bits for any number of threads.
#[test]
fn threads_do_not_matter() {
    let solids = || vec![disc(TOP - 0.5, 5.0, 3.0, Mat3::from_rotation_y(0.05), tablet(0.01, 0.9))];
    let geometry = flat(film(0.02, 12.0), 0.2, Some(4.0), METAL, solids());
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| ask(&geometry, (0.1, 10), 2_000, 10))
    };
    let one = run(1);
    assert!(one.1.seen.value > 0.3);
    assert_eq!(one, run(2));
    assert_eq!(one, run(3));
}

/// Microfacets throw their share back under every angle, and their density is that of their samples.
#[test]
fn facets_keep_their_share() {
    let mut rng = Stream::root(1).child("facets").rng();
    let facets = Microfacets::new(&METAL, DVec3::new(0.2, -0.1, 1.0).normalize());
    for direction in [DVec3::NEG_Z, DVec3::new(0.7, 0.2, -0.6).normalize(), DVec3::new(0.1, 0.95, -0.25).normalize()] {
        let (steps, mut sum, mut mean) = (1000, 0.0, DVec3::ZERO);
        for i in 0..steps {
            let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(steps);
            for j in 0..steps {
                let (sin, cos) = libm::sincos((f64::from(j) + 0.5) / f64::from(steps) * std::f64::consts::TAU);
                let flat = (1.0 - z * z).sqrt();
                let view = DVec3::new(flat * cos, flat * sin, z);
                let share = facets.density(direction, view) * 4.0 * std::f64::consts::PI / f64::from(steps * steps);
                (sum, mean) = (sum + share, mean + view * share);
            }
        }
        assert!((sum - 1.0).abs() < 2e-3, "all directions {sum}");
        let drawn = (0..100_000).map(|_| facets.sample(direction, &mut rng)).sum::<DVec3>() / 1e5;
        // Each part of a unit vector varies by at most 1.
        assert!((drawn - mean).length() < 3.0 * 3f64.sqrt() / 1e5f64.sqrt(), "{drawn} against {mean}");
    }
}
