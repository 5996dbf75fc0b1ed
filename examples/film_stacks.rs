//! The production kernel beside the judge on films over something: the figures of docs/transport/layers.md.
//!
//! `cargo run --release --example film_stacks -- PHOTONS`: prints one row of a table a stack.

use sheetlight::transport::answer::{Answer, Question, Side};
use sheetlight::transport::kernel;
use sheetlight::transport::path::{Effort, solve};
use sheetlight::transport::stack::{Below, Foil, Layer, Scattering, Stack};

const FOIL: Foil = Foil { reflectance: 0.9, roughness: [0.25, 0.12] };

fn film(sigma: f64, thickness: f64) -> Layer {
    Layer::new(thickness, 1.53, 0.02, Scattering::Isotropic { mu_s: sigma / (1.0 - 0.557), g: 0.557 })
}

fn tablet(coat: f64) -> Layer {
    Layer { coat, ..Layer::new(f64::INFINITY, 1.5, 0.005, Scattering::Isotropic { mu_s: 40.0, g: 0.0 }) }
}

fn over_tablet(film: Layer, gap: f64, coat: f64) -> Stack {
    Stack { above: 1.0, layers: vec![film, Layer::air(gap), tablet(coat)], below: Below::Index(1.0) }
}

fn over_foil(film: Layer, gap: Option<f64>) -> Stack {
    let layers = std::iter::once(film).chain(gap.map(Layer::air)).collect();
    Stack { above: 1.0, layers, below: Below::Foil(FOIL) }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let photons = std::env::args().nth(1).map_or(Ok(1_000_000), |text| text.parse())?;
    let stacks = [
        ("12/mm .12 over .5 over tablet", over_tablet(film(12.0, 0.12), 0.5, 1.0)),
        ("12 touching tablet", over_tablet(film(12.0, 0.12), 0.0, 1.0)),
        ("12 over 5 over foil", over_foil(film(12.0, 0.12), Some(5.0))),
        ("12 .25 sealed to foil", over_foil(film(12.0, 0.25), None)),
        ("4 over .5 tablet", over_tablet(film(4.0, 0.12), 0.5, 1.0)),
        ("4 over 5 foil", over_foil(film(4.0, 0.12), Some(5.0))),
        ("40 .2 over .5 tablet", over_tablet(film(40.0, 0.2), 0.5, 1.0)),
        ("100 over .5 tablet", over_tablet(film(100.0, 0.12), 0.5, 1.0)),
        ("clear over .5 tablet", over_tablet(film(0.0, 0.12), 0.5, 1.0)),
        ("12 over .5 coated .7", over_tablet(film(12.0, 0.12), 0.5, 0.7)),
    ];
    let question = Question { cells: 0, ..Question::default() };
    for (name, stack) in stacks {
        let judge = solve(&stack, &question, Effort { photons, seed: 1 });
        let kernel = kernel::solve(&stack, &question)?;
        let windows = |a: &Answer| {
            let seen = Answer { line: a.seen.clone(), ..a.clone() };
            [a.rows(1, 8, Side::Both), a.rows(7, 11, Side::Both), seen.rows(1, 8, Side::Both), seen.rows(7, 11, Side::Both)]
        };
        print!("{name:32} R {:.4} {:.4}", judge.reflectance.value, kernel.reflectance.value);
        print!(" lens {:.4} {:.4}", judge.cone.map_or(0.0, |e| e.value), kernel.towards_lens.map_or(0.0, |e| e.value));
        print!(" bottom {:.4} {:.4}", judge.absorbed.last().map_or(0.0, |e| e.value), kernel.absorbed.last().map_or(0.0, |e| e.value));
        for (judge, kernel) in windows(&judge).into_iter().zip(windows(&kernel)) {
            print!(" | {judge:.4} {kernel:.4} {:.3}", kernel / judge);
        }
        println!();
    }
    Ok(())
}
