//! Exposure against the reference for bodies of triangles: saw-teeth, a ball, a part with walls that hide what lies
//! behind.

use crate::rays::object::Facet;
use crate::rays::scenes::{Trial, scene};
use crate::rays::shapes::{ball, facets, raised};
use base::{Body, Mesh};
use glam::DVec3;
use procedural::solid::part::Placing;
use procedural::solid::sawtooth::Piece;
use procedural::solid::{Material, Part, Sawtooth};

/// Grey paint without gloss, and nothing from below.
fn paint() -> Material {
    let mut material = Material::from_values(&mut |p| p.default);
    (material.matte, material.gloss) = (0.6, 0.0);
    material
}

/// What the material's surface throws back evenly.
fn share(body: &Body) -> f64 {
    f64::from(body.slice(20.0).matter(0.0, 1.0).medium.gloss.matte)
}

/// A mesh laid on the conveyor as it is.
fn part(mesh: &Mesh) -> Body {
    let mut placing = Placing::from_values(&mut |p| p.default);
    (placing.lead_in_mm, placing.lift_mm) = (5.0, 0.0);
    Body::new(Part::new(mesh, &placing, &paint()))
}

/// The triangles that production has, for the reference; its own rays meet them.
fn triangles(body: &Body) -> Vec<Facet> {
    let conveyor = 300.0;
    let floor = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0) * conveyor);
    facets(&body.hull(), share(body)).into_iter().chain(Facet::quad(floor, CONVEYOR)).collect()
}

/// Reflectance of the conveyor.
const CONVEYOR: f64 = 0.04;

/// Teeth along the line, away from their tips and roots.
#[test]
fn saw_teeth() {
    let mut scene = scene(2560);
    scene.bench.motion.conveyor_reflectance = CONVEYOR;
    let piece = Piece::from_values(&mut |p| p.default);
    let body = Body::new(Sawtooth::new(&piece, &paint()));
    let (low, high) = body.bounds();
    println!("saw-tooth from {low} to {high}");
    let profile = (0.5 * f64::from(low.y + high.y) / scene.bench.motion.step_mm) as usize;
    let facets = triangles(&body);
    let heights = [0.0, f64::from(high.z)];
    for (name, first_col) in [("saw-teeth, middle", 1216), ("saw-teeth, x = 70 mm", 2000)] {
        let body = body.clone();
        let facets = facets.clone();
        let trial =
            Trial { name, scene: &scene, body, profile, facets, heights, first_col, cols: 128, rays: 5_000_000 };
        let verdict = trial.compare();
        let edge = edges(&verdict.centre_rows());
        verdict.hold(|col| !edge[col - first_col]);
    }
}

/// A ball of 10 mm radius, where it rises by up to 45 degrees.
#[test]
fn a_ball() {
    let scene = scene(256);
    let body = part(&ball(DVec3::new(0.0, 0.0, 10.0), 10.0, 1440));
    let (low, high) = body.bounds();
    let facets = triangles(&body);
    // Before the middle: the surface rises along the motion; a little off it.
    let y = 0.5 * f64::from(low.y + high.y) - 2.0;
    let profile = (y / scene.bench.motion.step_mm) as usize;
    let heights = [0.0, f64::from(high.z)];
    let trial = Trial {
        name: "ball of 20 mm",
        scene: &scene,
        body,
        profile,
        facets,
        heights,
        first_col: 100,
        cols: 100,
        rays: 4_000_000,
    };
    let verdict = trial.compare();
    let edge = edges(&verdict.centre_rows());
    verdict.hold(|col| !edge[col - 100]);
}

/// A block with a deep groove and a rib, aside of the fan and the lens, which hide parts of it from each other. Walls
/// turned to the lens are judged pixel by pixel, and what is hidden must be dark on both sides; columns whose light
/// comes from several heights, at corners and at the ends of shadows, are asked for their light alone.
#[test]
fn a_part_that_hides_itself() {
    let mut scene = scene(2560);
    scene.bench.laser.fan_height_mm = 250.0;
    scene.bench.laser.fan_angle_deg = 60.0;
    let profile_of = |x: f64, _: f64| match x {
        x if x < 92.0 => 8.0,
        x if x < 92.4 => 8.0 + (x - 92.0) / 0.4 * 8.0,
        x if x < 94.0 => 16.0,
        x if x < 94.4 => 16.0 - (x - 94.0) / 0.4 * 8.0,
        x if x < 98.0 => 8.0,
        x if x < 98.4 => 8.0 - (x - 98.0) / 0.4 * 7.0,
        x if x < 99.6 => 1.0,
        x if x < 100.0 => 1.0 + (x - 99.6) / 0.4 * 7.0,
        _ => 8.0,
    };
    let mesh = raised([80.0, 112.0], [0.0, 40.0], [160, 1], profile_of);
    let mut placing = Placing::from_values(&mut |p| p.default);
    (placing.lead_in_mm, placing.offset_mm) = (0.0, 96.0);
    let body = Body::new(Part::new(&mesh, &placing, &paint()));
    let facets = triangles(&body);
    let trial = Trial {
        name: "part with a rib and a groove",
        scene: &scene,
        body,
        profile: 250,
        facets,
        heights: [0.0, 16.0],
        first_col: 2280,
        cols: 128,
        rays: 6_000_000,
    };
    let verdict = trial.compare();
    let edge = edges(&verdict.centre_rows());
    let found = verdict.hold(|col| !edge[col - 2280]);
    // Columns are points for production: where a shadow ends it takes all of a column or none, half of one too much at
    // most.
    let sums: Vec<[f64; 2]> = (0..128).map(|c| verdict.column(c)).collect();
    let [own, reference] = [0, 1].map(|side| sums.iter().map(|s| s[side]).sum::<f64>());
    let ends = verdict.dark().windows(2).filter(|pair| pair[0][0] != pair[1][0]).count();
    let most = 0.5 * ends as f64 * sums.iter().map(|s| s[1]).fold(0.0, f64::max) / reference;
    let left = edge.iter().filter(|&&edge| edge).count();
    let disputed = verdict.find(|_| true).disputed;
    println!(
        "{left} columns left out, {disputed} of them dark on one side alone; all light {:.4}, {most:.4} allowed",
        own / reference - 1.0
    );
    assert!(found.dark > 10, "{} columns are hidden", found.dark);
    assert!((own / reference - 1.0).abs() < most, "all light is {:.4} off, {most:.4} allowed", own / reference - 1.0);
    assert!(left < 50 && disputed <= 2 * ends, "{left} columns left out, {disputed} dark on one side alone");
}

/// Columns beside a jump of the line by more than a row, or beside the dark: what the blur mixes there.
fn edges(rows: &[Option<f64>]) -> Vec<bool> {
    let jumps = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() > 2.0,
        (None, None) => false,
        _ => true,
    };
    let near = |c: usize| {
        let (from, to) = (c.saturating_sub(3), (c + 3).min(rows.len() - 1));
        (from..to).any(|i| jumps(rows[i], rows[i + 1]))
    };
    let kink = |c: usize| {
        let (from, to) = (c.saturating_sub(2).max(1), (c + 2).min(rows.len() - 2));
        (from..=to).any(|i| match (rows[i - 1], rows[i], rows[i + 1]) {
            (Some(a), Some(b), Some(c)) => (a - 2.0 * b + c).abs() > 0.15,
            (None, None, None) => false,
            _ => true,
        })
    };
    (0..rows.len()).map(|c| near(c) || kink(c)).collect()
}
