//! The judge on packs against the judge of plane layers, against closed forms, and against itself.

use glam::{DVec2, DVec3, Vec3};
use procedural::blister::{Sheet, Solid};
use procedural::flat::Flat;
use procedural::{Body, Class, Gloss, Medium, Surface};

use super::facets::Facets;
use super::roam::Roam;
use super::shape::{PIGMENT_G, Shape, Spot};
use crate::transport::answer::{Answer, Estimate, Question};
use crate::transport::line::{Glow, LineOfLight};
use crate::transport::path::body::{Books, light};
use crate::transport::path::{Effort, solve};
use crate::transport::stack::{Layer, Scattering, Stack};

const BLACK: Gloss = Gloss { share: 1.0, reflectance: 0.0, roughness: [0.1; 2] };
/// Upper side of the film over the conveyor [mm].
const TOP: f32 = 20.0;

fn film(mu_a: f32, sigma: f32) -> Medium {
    Medium::isotropic(mu_a, sigma, 1.53, Gloss::NONE)
}

fn tablet(mu_a: f32, sigma: f32) -> Medium {
    Medium::isotropic(mu_a, sigma, 1.5, Gloss::NONE)
}

fn block(low: Vec3, high: Vec3, medium: Medium) -> Solid {
    Solid { bounds: [low, high], class: Class::Pocket, medium }
}

/// A level card of 60 mm, film of `thickness` [mm], foil `gap` [mm] below it.
fn flat(medium: Medium, thickness: f32, gap: Option<f32>, foil: Gloss, solids: Vec<Solid>) -> Roam {
    let level = |z: f32| Surface { z, slope_x: 0.0, slope_y: 0.0 };
    let sheet = Sheet { surface: level(TOP), thickness_mm: thickness, sealed: gap.is_none(), medium };
    let foil = (level(TOP - thickness - gap.unwrap_or(0.0)), Medium::opaque(foil));
    let card = [DVec2::splat(-30.0), DVec2::splat(30.0)];
    let shape = Shape::new(card, card, solids, |x, y| {
        (x.abs() < 30.0 && y.abs() < 30.0).then_some(Spot { sheet: Some(sheet), foil })
    });
    Roam { shape, view: Question::default().view }
}

fn ask(roam: &Roam, (row_mm, rows): (f64, usize), photons: u64, seed: u64) -> (Glow, Books) {
    // Any body: the ground is given.
    let medium = tablet(0.0, 1.0);
    let body = Body::Flat(Flat { height_mm: 1.0, slope_x: 0.0, slope_y: 0.0, width_mm: 1.0, length_mm: 1.0, medium });
    let (x, power) = (&[-20.0, 0.0, 20.0], &[0.0, 1.0, 0.0]);
    let line = LineOfLight { body: &body, y: 0.0, line_mm: 0.05, x, power, view: roam.view, row_mm, rows };
    light(&line, Effort { photons, seed }, roam)
}

fn layer(thickness: f64, medium: &Medium, g: f64) -> Layer {
    let scattering = Scattering::Isotropic { mu_s: f64::from(medium.sigma_i) / (1.0 - g), g };
    Layer { thickness, n: f64::from(medium.n_eff), mu_a: f64::from(medium.mu_a), scattering }
}

const AIR: Layer = Layer { thickness: 0.0, n: 1.0, mu_a: 0.0, scattering: Scattering::Isotropic { mu_s: 0.0, g: 0.0 } };

fn agree(what: &str, got: Estimate, other: Estimate) {
    let z = (got.value - other.value) / (got.error.powi(2) + other.error.powi(2)).sqrt();
    println!(
        "{what}: {:.5} +- {:.5} against {:.5} +- {:.5}, z = {z:.2}",
        got.value, got.error, other.value, other.error
    );
    assert!(z.abs() < 3.5, "{what}: {got:?} against {other:?}, z = {z}");
}

/// What entered, of what a layered answer counts in shares of what came.
fn entered(answer: &Answer, share: Estimate) -> Estimate {
    let scale = 1.0 / (1.0 - answer.specular);
    Estimate { value: share.value * scale, error: share.error * scale }
}

fn closes(books: &Books) {
    let sum = books.absorbed.value + books.left.value + books.dropped.value + books.astray.value;
    assert!((sum - 1.0).abs() < 1e-6, "energy {sum}");
}

/// Film over air and tablet, touching tablet, and black foil: what leaves and what the lens sees are the layered judge's.
#[test]
fn flat_packs_are_stacks() {
    let (cover, pill) = (film(0.02, 12.0), tablet(0.02, 40.0));
    let under = |gap: f32| {
        let z = TOP - 0.2 - gap;
        vec![block(Vec3::new(-25.0, -25.0, z - 15.0), Vec3::new(25.0, 25.0, z), pill)]
    };
    let layers = |gap: f64| {
        vec![layer(0.2, &cover, PIGMENT_G), Layer { thickness: gap, ..AIR }, layer(f64::INFINITY, &pill, 0.0)]
    };
    let cases = [
        ("tablet under 0.5 mm", flat(cover, 0.2, Some(16.0), BLACK, under(0.5)), layers(0.5)),
        ("touching tablet", flat(cover, 0.2, Some(16.0), BLACK, under(0.0)), layers(1e-9)),
        ("black foil", flat(cover, 0.2, Some(3.0), BLACK, Vec::new()), vec![layer(0.2, &cover, PIGMENT_G)]),
        ("sealed black foil", flat(cover, 0.2, None, BLACK, Vec::new()), vec![layer(0.2, &cover, PIGMENT_G)]),
    ];
    for (seed, (name, roam, layers)) in cases.into_iter().enumerate() {
        let below = if name.starts_with("sealed") { 1.53 } else { 1.0 };
        let truth = solve(
            &Stack { above: 1.0, layers, below },
            &Question { cells: 0, ..Question::default() },
            Effort { photons: 200_000, seed: 1 },
        );
        let start = std::time::Instant::now();
        let (_, books) = ask(&roam, (60.0, 0), 100_000, 10 + seed as u64);
        println!("{:?} {books:?}", start.elapsed());
        closes(&books);
        agree(&format!("{name}, left"), books.left, entered(&truth, truth.reflectance));
        println!("{:?} {:?}", truth.towards_lens, truth.cone);
        agree(&format!("{name}, seen"), books.seen, entered(&truth, truth.cone.unwrap_or_default()));
    }
}

/// Facets throw their reflectance back, whatever the angle, and their density is that of their samples.
#[test]
fn facets_keep_their_share() {
    let mut rng = procedural::Stream::root(1).child("facets").rng();
    let normal = DVec3::new(0.2, -0.1, 1.0).normalize();
    let facets = Facets::new(&Gloss { share: 1.0, reflectance: 0.9, roughness: [0.1, 0.3] }, normal);
    for way in [DVec3::NEG_Z, DVec3::new(0.7, 0.2, -0.6).normalize(), DVec3::new(0.1, 0.95, -0.25).normalize()] {
        let (steps, mut sum, mut mean) = (1500, 0.0, DVec3::ZERO);
        for i in 0..steps {
            let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(steps);
            for j in 0..steps {
                let (sin, cos) = libm::sincos((f64::from(j) + 0.5) / f64::from(steps) * std::f64::consts::TAU);
                let flat = (1.0 - z * z).sqrt();
                let view = DVec3::new(flat * cos, flat * sin, z);
                let share = facets.density(way, view) * 4.0 * std::f64::consts::PI / f64::from(steps * steps);
                (sum, mean) = (sum + share, mean + view * share);
            }
        }
        assert!((sum - 1.0).abs() < 2e-3, "all directions {sum}");
        let drawn = (0..100_000).map(|_| facets.sample(way, &mut rng)).sum::<DVec3>() / 1e5;
        // Each part of a unit vector varies by at most 1.
        assert!((drawn - mean).length() < 3.0 * 3f64.sqrt() / 1e5f64.sqrt(), "{drawn} against {mean}");
    }
}
