//! Defects of boards by the kernel against the reference: lines across open cracks, holes, enclosed bark and resin,
//! stained and compressed wood on small boards. Scatter in bins of 0.74 mm along the line, free of noise and speckle.

use super::boards::{BIN, PHOTONS, WALKS, bins, figures, matter, reference};
use super::borders::bench_of;
use super::kept::Kept;
use optical_bench::settings::Transport;
use procedural::wood::Wood;
use recipe::{Plan, Recipe, Scene};

/// Boards of each kind.
const BOARDS: u64 = 3;
/// Bins that hold less than this part of a board's median are dark [1]: there the reference's own error and the lens's
/// blur of the neighbours decide.
const DARK: f64 = 0.25;

/// A kind of defect: its name, what it is, and the part of Scatter's bins' root mean square that is allowed [1].
type Kind = (&'static str, fn(&mut Wood), f64);

const KINDS: [Kind; 6] = [
    ("check", |wood| (wood.cracks.check_count, wood.cracks.length_mm, wood.cracks.width_mm) = (2.0, 30.0, 0.6), 0.10),
    ("bark pocket", |wood| (wood.inclusions.bark_pocket_count, wood.inclusions.width_mm) = (2.0, 3.0), 0.10),
    ("resin pocket", |wood| (wood.inclusions.resin_pocket_count, wood.inclusions.width_mm) = (2.0, 3.0), 0.10),
    ("resin streak", |wood| (wood.inclusions.resin_streak_count, wood.inclusions.width_mm) = (2.0, 4.0), 0.10),
    ("blue stain", |wood| (wood.stain.severity, wood.stain.wedge_deg) = (0.9, 2.0), 0.10),
    // Denser than recipes have it.
    (
        "compression wood",
        |wood| {
            (wood.compression.severity, wood.compression.width_mm) = (0.9, 4.0);
            let media = &mut wood.media;
            (media.compression_mu_a_ratio, media.compression_sigma_i_ratio, media.compression_k_ratio) =
                (1.9, 1.9, 1.3);
        },
        0.10,
    ),
];

/// A small clear board with defects of a kind near its middle line.
fn scene(recipe: &Recipe, kind: &Kind, index: u64) -> Scene {
    let mut scene = recipe.draw(31, index);
    let Plan::Wood(wood) = &mut scene.plan else { panic!("a recipe of wood") };
    (wood.knots.sound_count, wood.knots.dead_count, wood.rot.reach_mm) = (0.0, 0.0, 0.0);
    (kind.1)(wood);
    scene
}

#[test]
fn scatter_at_defects_is_that_of_the_reference() {
    let recipe = Recipe::load("wood-small.yaml").expect("the embedded recipe loads");
    let mut kept = Kept::of("defects");
    let mut missed = Vec::new();
    for kind in &KINDS {
        let (mut squares, mut noise, mut count) = (0.0, 0.0, 0);
        let mut text = Vec::new();
        for index in 0..BOARDS {
            let scene = scene(&recipe, kind, index);
            let body = pipeline::body(&scene);
            let asked = (bench_of(&scene), matter(&scene, &body), [PHOTONS, WALKS, BIN as u64]);
            let reference = kept.says(&format!("{} {index}", kind.0), &asked, || reference(&scene));
            let kernel = bins(&scene, body, Transport::Kernel);
            let mut lights: Vec<f64> = reference.chunks(5).filter(|bin| bin[0] >= 0.0).map(|bin| bin[1]).collect();
            lights.sort_by(f64::total_cmp);
            let dark = DARK * lights[lights.len() / 2];
            for (truth, rows) in reference.chunks(5).zip(&kernel) {
                let Some(rows) = rows.as_ref().filter(|_| truth[1] > dark && truth[0] >= 0.0) else { continue };
                let off = figures(rows, truth[0] as i32)[0] / truth[1] - 1.0;
                text.push(format!("{:+.0}", 100.0 * off));
                (squares, noise, count) = (squares + off * off, noise + (truth[2] / truth[1]).powi(2), count + 1);
            }
            text.push("|".into());
        }
        let rms = ((squares - noise).max(0.0) / f64::from(count)).sqrt();
        println!("{}: {rms:.3} rms over {count} bins: {}", kind.0, text.join(" "));
        if rms > kind.2 {
            missed.push((kind.0, rms));
        }
    }
    kept.finish();
    assert!(missed.is_empty(), "{missed:?}");
}
