//! The production kernel beside the reference on films over something: the tables of docs/theory/transport/layers.md.
//!
//! `cargo run --release --example film_stacks -- PHOTONS`: one row a stack, then filled over empty pockets by pigment.

use std::iter;

use reference::path::{Effort, solve};
use transport::answer::{Answer, Estimate, LineSide, Question};
use transport::kernel;
use transport::stack::{Foil, Layer, Scattering, Stack, Substrate};

const FOIL: Foil = Foil { reflectance: 0.9, roughness: [0.2, 0.2] };

fn film(sigma: f64, thickness: f64) -> Layer {
    Layer::new(thickness, 1.53, 0.02, Scattering::Isotropic { mu_s: sigma / (1.0 - 0.557), g: 0.557 })
}

fn over_tablet(film: Layer, gap: f64, coat: f64) -> Stack {
    let tablet = Layer::new(f64::INFINITY, 1.5, 0.005, Scattering::Isotropic { mu_s: 40.0, g: 0.0 });
    Stack { above: 1.0, layers: vec![film, Layer::air(gap), Layer { coat, ..tablet }], below: Substrate::Index(1.0) }
}

fn over_foil(film: Layer, gap: Option<f64>) -> Stack {
    let layers = iter::once(film).chain(gap.map(Layer::air)).collect();
    Stack { above: 1.0, layers, below: Substrate::Foil(FOIL) }
}

/// Rows `from..=to` on both sides of light to all sides, or of what the lens sees, with the standard error.
fn window(answer: &Answer, seen: bool, from: usize, to: usize) -> Estimate {
    let line = if seen { &answer.seen } else { &answer.line };
    let middle = line.len() / 2;
    let rows = (from..=to).flat_map(|row| [line[middle - row], line[middle + row]]);
    let error = rows.map(|row| row.error * row.error).sum::<f64>().sqrt();
    let value = Answer { line: line.clone(), ..answer.clone() }.rows(from, to, LineSide::Both);
    Estimate { value, error }
}

fn windows(answer: &Answer) -> [Estimate; 4] {
    [(false, 1, 8), (false, 7, 11), (true, 1, 8), (true, 7, 11)].map(|(seen, from, to)| window(answer, seen, from, to))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let photons = std::env::args().nth(1).map_or(Ok(400_000), |text| text.parse())?;
    let question = Question { cells: 0, angles: 0, ..Question::default() };
    let reference = |stack: &Stack| solve(stack, &question, Effort { photons, seed: 1 });
    let stacks = [
        ("12 /mm, 0.12 mm over 0.5 mm over tablet", over_tablet(film(12.0, 0.12), 0.5, 1.0)),
        ("the same, touching the tablet", over_tablet(film(12.0, 0.12), 0.0, 1.0)),
        ("the same over 5 mm over foil", over_foil(film(12.0, 0.12), Some(5.0))),
        ("12 /mm, 0.25 mm sealed to foil", over_foil(film(12.0, 0.25), None)),
        ("4 /mm, 0.12 mm over 0.5 mm over tablet", over_tablet(film(4.0, 0.12), 0.5, 1.0)),
        ("40 /mm, 0.2 mm over 0.5 mm over tablet", over_tablet(film(40.0, 0.2), 0.5, 1.0)),
        ("100 /mm, 0.12 mm over 0.5 mm over tablet", over_tablet(film(100.0, 0.12), 0.5, 1.0)),
        ("clear, 0.12 mm over 0.5 mm over tablet", over_tablet(film(0.0, 0.12), 0.5, 1.0)),
        ("12 /mm, 0.12 mm over 0.5 mm over coated tablet", over_tablet(film(12.0, 0.12), 0.5, 0.7)),
        ("4 /mm, 0.12 mm over 5 mm over foil", over_foil(film(4.0, 0.12), Some(5.0))),
    ];
    for (name, stack) in stacks {
        let (reference, kernel) = (reference(&stack), kernel::solve(&stack, &question)?);
        print!("| {name} | {:.4} {:.4} |", reference.reflectance.value, kernel.reflectance.value);
        for (reference, kernel) in windows(&reference).into_iter().zip(windows(&kernel)) {
            print!(
                " {:.4} +- {:.4}, {:.4} ({:.3}) |",
                reference.value,
                reference.error,
                kernel.value,
                kernel.value / reference.value
            );
        }
        println!();
    }
    for (sigma, thickness) in
        [(4.0, 0.08), (4.0, 0.12), (4.0, 0.3), (12.0, 0.12), (40.0, 0.12), (100.0, 0.12), (150.0, 0.08), (150.0, 0.3)]
    {
        let film = film(sigma, thickness);
        let [filled, empty] = [over_tablet(film, 0.5, 1.0), over_foil(film, Some(5.0))];
        let reference = [&filled, &empty].map(|stack| windows(&reference(stack)));
        let kernel = [windows(&kernel::solve(&filled, &question)?), windows(&kernel::solve(&empty, &question)?)];
        print!("| {sigma} | {thickness} |");
        for i in 0..4 {
            let ratio = reference[0][i].value / reference[1][i].value;
            let relative = |e: Estimate| e.error / e.value;
            let error = ratio * (relative(reference[0][i]).powi(2) + relative(reference[1][i]).powi(2)).sqrt();
            print!(" {ratio:.3} +- {error:.3}, {:.3} |", kernel[0][i].value / kernel[1][i].value);
        }
        println!();
    }
    Ok(())
}
