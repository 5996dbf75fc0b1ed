//! The models that answer one line at a time, by the names that recipes have for them.

use crate::diffusion::{self, DiffusionSettings};
use crate::path::{self, Effort};
use crate::thesis::{self, LineRule, SpreadMethod, ThesisSettings};
use base::Stream;
use optical_bench::settings::{ThesisMethod, Transport};
use transport::line::{LineResponse, LineSolver, LineSource};

/// The model that a recipe asks for; `None` where the kernel answers. `stream` belongs to the sample.
pub fn line_solver(transport: Transport, stream: Stream) -> Option<Box<dyn LineSolver>> {
    match transport {
        Transport::Kernel => None,
        Transport::Path { photons } => Some(Box::new(PathOfSample { photons, stream: stream.child("transport") })),
        Transport::Diffusion { voxel_mm } => Some(Box::new(DiffusionSettings::new(voxel_mm))),
        Transport::Thesis { method, iterations, pixel_mm } => {
            let method = match method {
                ThesisMethod::LinearEquation => SpreadMethod::Lines(LineRule::LinearEquation),
                ThesisMethod::AntiAliased => SpreadMethod::Lines(LineRule::AntiAliased),
                ThesisMethod::Bresenham => SpreadMethod::Lines(LineRule::Bresenham),
                ThesisMethod::Diffusion => SpreadMethod::diffusion(iterations as u32),
                ThesisMethod::Conservative => SpreadMethod::Conservative { steps: iterations as u32 },
            };
            Some(Box::new(ThesisSettings { method, pitch_mm: pixel_mm }))
        }
    }
}

/// Monte Carlo whose chance is that of a sample.
#[derive(Debug)]
struct PathOfSample {
    photons: u64,
    stream: Stream,
}

impl LineSolver for PathOfSample {
    fn solve(&self, line: &LineSource<'_>, profile: u64) -> LineResponse {
        path::line_response(line, Effort { photons: self.photons, seed: self.stream.index(profile).key() })
    }
}

impl LineSolver for DiffusionSettings {
    fn solve(&self, line: &LineSource<'_>, _: u64) -> LineResponse {
        diffusion::line_response(line, self)
    }
}

impl LineSolver for ThesisSettings {
    fn solve(&self, line: &LineSource<'_>, _: u64) -> LineResponse {
        thesis::line_response(line, self)
    }
}
