//! The judge on packs against the judge of plane layers, against closed forms, and against itself.

use glam::{DVec2, DVec3, Mat3, Vec3};
use procedural::blister::{Sheet, Solid, solid};
use procedural::flat::Flat;
use procedural::{Body, Class, Gloss, Medium, Surface};

use super::facets::Facets;
use super::roam::Roam;
use super::shape::{Face, PIGMENT_G, Shape, Spot};
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

/// A flat round tablet about the origin, its top at `top` [mm].
fn disc(top: f32, radius: f32, thickness: f32, medium: Medium) -> Solid {
    let shape = solid::Shape { segment: 0.0, radius, band: 0.5 * thickness, cap: None };
    let middle = Vec3::new(0.0, 0.0, top - 0.5 * thickness);
    Solid::new(shape, Vec::new(), Mat3::IDENTITY, middle, medium, Class::Pocket, 0)
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
    Roam::new(shape, Question::default().view)
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
    let under = |gap: f32| vec![disc(TOP - 0.2 - gap, 25.0, 15.0, pill)];
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
        let start = std::time::Instant::now();
        let truth = solve(
            &Stack { above: 1.0, layers, below },
            &Question { cells: 0, ..Question::default() },
            Effort { photons: 200_000, seed: 1 },
        );
        println!("layers {:?}", start.elapsed());
        let start = std::time::Instant::now();
        let (_, books) = ask(&roam, (60.0, 0), 100_000, 10 + seed as u64);
        println!("{:?} {books:?}", start.elapsed());
        closes(&books);
        // What goes astray in the gap would have ended somewhere.
        let unknown = Estimate {
            error: books.left.error + 0.5 * books.astray.value,
            value: books.left.value + 0.5 * books.astray.value,
        };
        agree(&format!("{name}, left"), unknown, entered(&truth, truth.reflectance));
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

/// TEMPORARY
#[test]
fn temporary_real_pack() {
    use procedural::blister::*;
    let d = &mut |p: &'static procedural::Parameter| p.default;
    let mut b = Blister {
        card: Card::from_values(d),
        pocket: Pocket::from_values(d),
        tablet: Tablet::from_values(d),
        web: Web::from_values(d),
        foil: Foil::from_values(d),
        defects: Defects::from_values(d),
    };
    b.tablet.tilt_deg = 0.0;
    let t = std::time::Instant::now();
    let pack = Pack::form(procedural::Stream::root(3), &b);
    println!("form {:?} bounds {:?}", t.elapsed(), pack.bounds());
    for s in pack.solids() {
        println!("{:?}", s.bounds);
    }
    let y = pack.instances()[4].y_mm;
    let x0 = pack.instances()[4].x_mm;
    let body = Body::Pack(Box::new(pack));
    let x: Vec<f32> = (0..9).map(|i| (x0 - 4.0 + i as f64) as f32).collect();
    let line = LineOfLight {
        body: &body,
        y,
        line_mm: 0.05,
        x: &x,
        power: &[1.0; 9],
        view: Question::default().view,
        row_mm: 0.1,
        rows: 60,
    };
    let t = std::time::Instant::now();
    let Body::Pack(pack) = &body else { panic!() };
    let roam = Roam::in_pack(pack, &line);
    println!("shape {:?}", t.elapsed());
    for i in -30..=30 {
        let at = DVec3::new(x0 + 0.3 * i as f64, y, 0.0);
        let c = roam.shape.cell(at).unwrap();
        let h = [Face::Upper, Face::Lower, Face::Foil].map(|f| roam.shape.height(c, f, at));
        let s = pack.sheet(at.x as f32, y as f32).unwrap();
        println!(
            "{:6.2} {:.3?} sealed {} t {:.3} nz {:.3} lower by normal {:.3}",
            at.x - x0,
            h,
            roam.shape.cells[c].sealed,
            s.thickness_mm,
            roam.shape.normal(c, Face::Upper, at).z,
            s.surface.z - s.thickness_mm * (1.0 + s.surface.slope_x.powi(2) + s.surface.slope_y.powi(2)).sqrt()
        );
    }
    let t = std::time::Instant::now();
    let (glow, books) = light(&line, Effort { photons: 100_000, seed: 1 }, &roam);
    println!("{:?} {books:?}", t.elapsed());
    for row in (0..=120).step_by(4) {
        println!("{row} {:.4?}", &glow.light[row * 9..][..9]);
    }
}

/// TEMPORARY
#[test]
fn temporary_precise() {
    let (cover, pill) = (film(0.02, 12.0), tablet(0.02, 40.0));
    let bare = vec![layer(f64::INFINITY, &pill, 0.0)];
    let both = vec![layer(0.2, &cover, PIGMENT_G), Layer { thickness: 1e-9, ..AIR }, layer(f64::INFINITY, &pill, 0.0)];
    for (name, layers) in [("bare", bare), ("both", both)] {
        let truth = solve(
            &Stack { above: 1.0, layers, below: 1.0 },
            &Question { cells: 0, ..Question::default() },
            Effort { photons: 600_000, seed: 2 },
        );
        let tablet = vec![disc(TOP - 0.2, 25.0, 15.0, pill)];
        let roam = if name == "bare" {
            let card = [DVec2::splat(-30.0), DVec2::splat(30.0)];
            let foil = (Surface { z: 0.0, slope_x: 0.0, slope_y: 0.0 }, Medium::opaque(BLACK));
            let shape = Shape::new(card, card, tablet, |x, y| {
                (x.abs() < 30.0 && y.abs() < 30.0).then_some(Spot { sheet: None, foil })
            });
            Roam::new(shape, Question::default().view)
        } else {
            flat(cover, 0.2, Some(16.0), BLACK, tablet)
        };
        let (_, books) = ask(&roam, (60.0, 0), 600_000, 77);
        println!("{books:?}");
        println!("{name} left: {:?} against {:?}", books.left, entered(&truth, truth.reflectance));
        println!(
            "{name} seen: {:?} against {:?} {:?}",
            books.seen,
            entered(&truth, truth.towards_lens.unwrap_or_default()),
            truth.cone
        );
    }
}
