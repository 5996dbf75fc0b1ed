//! The cue by which compression wood is told: it is darker than the wood around it, on the line and beside it.

use base::{Body, Medium};
use glam::DVec3;
use procedural::wood::Wood;
use recipe::{Plan, Recipe, Scene};
use transport::answer::Question;
use transport::kernel;
use transport::stack::{CylinderPhase, Scattering, Stack};

/// Most light of the line and of Scatter over that of the same place without compression wood [1].
const MOST: [f64; 2] = [0.95, 0.9];

/// Light of the line's row and of rows 1 to 8 on both sides as the lens sees them, fibres at an azimuth against the
/// scan [deg].
fn light(medium: &Medium, azimuth_deg: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(azimuth_deg.to_radians());
    let up = f64::from(medium.fibre.z);
    let flat = (1.0 - up * up).sqrt();
    let scattering = Scattering::Fibres {
        sigma_i: f64::from(medium.sigma_i),
        sigma_c: f64::from(medium.k),
        turn: CylinderPhase::Cauchy(0.0),
        axis: DVec3::new(flat * sin, flat * cos, up),
        dispersion: f64::from(medium.dispersion_deg).to_radians(),
    };
    let stack = Stack::half_space(f64::from(medium.n_eff), f64::from(medium.mu_a), scattering);
    let question = Question { cells: 0, ..Question::default() };
    let seen = kernel::solve(&stack, &question).expect("the kernel knows wood").seen;
    let row = |away: usize| seen[question.rows + away].value + seen[question.rows - away].value;
    [0.5 * row(0), (1..=8).map(row).sum()]
}

/// Boards of every recipe of wood whose light is drawn, and of what is drawn where none says it: compression wood of
/// severity 1 against the same places without it, fibres along the scan, across it and between. At the defaults that
/// stood here before, the line of fibres along the scan was a quarter brighter.
#[test]
fn compression_wood_is_darker_on_the_line_and_beside_it() {
    let (mut worst, mut places) = ([0.0f64; 2], 0);
    for name in ["wood-small.yaml", "wood.yaml", "wood-grading.yaml", "wood-sawmill.yaml"] {
        let recipe = Recipe::load(name).expect("an embedded recipe loads");
        for index in 0..12 {
            let Plan::Wood(mut wood) = recipe.draw(41, index).plan else { panic!("a recipe of wood") };
            (wood.knots.sound_count, wood.knots.dead_count, wood.rot.reach_mm) = (0.0, 0.0, 0.0);
            wood.compression.severity = 0.0;
            let of = |severity: f64| {
                let mut wood: Wood = wood;
                wood.compression.severity = severity;
                (wood.compression.width_mm, wood.compression.arc_deg) = (100.0, 360.0);
                pipeline::body(&Scene { plan: Plan::Wood(wood), ..recipe.draw(41, index) })
            };
            let [clear, dark] = [0.0, 1.0].map(of);
            let (low, high) = clear.bounds();
            for step in 0..40u8 {
                let share = (f32::from(step) + 0.5) / 40.0;
                let (x, y) = (low.x + share * (high.x - low.x), low.y + (share * 7.0).fract() * (high.y - low.y));
                let at = |body: &Body| {
                    let slice = body.slice(y);
                    slice.surface(x).map(|surface| slice.matter(x, surface.z).medium)
                };
                let (Some(before), Some(after)) = (at(&clear), at(&dark)) else { continue };
                // Fully developed places alone.
                let full = wood.media.compression_mu_a_ratio as f32;
                if (after.mu_a / before.mu_a - full).abs() > 0.01 * full {
                    continue;
                }
                places += 1;
                for azimuth in [0.0, 90.0, 37.0] {
                    let (before, after) = (light(&before, azimuth), light(&after, azimuth));
                    for (worst, i) in worst.iter_mut().zip(0..) {
                        *worst = worst.max(after[i] / before[i]);
                    }
                }
            }
        }
    }
    println!("{places} places: the line at most {:.3}, Scatter at most {:.3} of clear wood", worst[0], worst[1]);
    assert!(places > 100 && worst[0] <= MOST[0] && worst[1] <= MOST[1], "{places} places, {worst:.3?}");
}
