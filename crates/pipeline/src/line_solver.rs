//! Models of light in matter that answer one line at a time: Monte Carlo, diffusion, the thesis' models.

use procedural::Stream;

use bench::settings::{ThesisMethod, Transport};
use reference::path::{self, Effort};
use reference::{diffusion, thesis};
use scanner::optics::LineSolver;

/// The solver that a recipe asks for; `None` where the kernel answers. `stream` belongs to the sample.
pub(super) fn line_solver(transport: Transport, stream: Stream) -> Option<LineSolver> {
    match transport {
        Transport::Kernel => None,
        Transport::Path { photons } => Some(LineSolver::new(move |line, profile| {
            let seed = stream.child("transport").index(profile).key();
            path::line_response(line, Effort { photons, seed })
        })),
        Transport::Diffusion { voxel_mm } => Some(LineSolver::new(move |line, _| {
            diffusion::line_response(
                line,
                &diffusion::DiffusionSettings { voxel_mm, ..diffusion::DiffusionSettings::default() },
            )
        })),
        Transport::Thesis { method, iterations, pixel_mm } => Some(LineSolver::new(move |line, _| {
            let method = thesis_method(method, iterations as u32);
            thesis::line_response(
                line,
                &thesis::ThesisSettings { method, pitch_mm: pixel_mm, ..thesis::ThesisSettings::default() },
            )
        })),
    }
}

fn thesis_method(method: ThesisMethod, iterations: u32) -> thesis::SpreadMethod {
    match method {
        ThesisMethod::LinearEquation => thesis::SpreadMethod::LINEAR_EQUATION,
        ThesisMethod::AntiAliased => thesis::SpreadMethod::ANTI_ALIASED,
        ThesisMethod::Bresenham => thesis::SpreadMethod::BRESENHAM,
        ThesisMethod::Diffusion => thesis::SpreadMethod::diffusion(iterations),
        ThesisMethod::Conservative => thesis::SpreadMethod::conservative(iterations),
    }
}
