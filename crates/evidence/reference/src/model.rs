//! Every model by name, and one place where they are asked.
//!
//! A new model is a folder beside this file that answers a `Stack` and a `Question` with an `Answer`, or refuses with a
//! remedy. It is a variant of [`Model`] with its name and one line in [`Model::ask`]: command line, studies and
//! pictures follow. For scans it also implements `LineSolver` in `line_solver.rs`, and `Transport` of
//! `optical_bench::settings` has its name. A test holds it to the reference Monte Carlo; docs/theory/physics.md says
//! where it fails.

use crate::diffusion;
use crate::path::{Effort, solve_watched};
use transport::answer::{Answer, Question};
use transport::kernel;
use transport::stack::Stack;

/// A model of transport.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Monte Carlo of the transport equation.
    Path,
    /// Steady anisotropic diffusion.
    Diffusion,
    /// Gaussians over path length, from a table.
    Kernel,
}

impl Model {
    /// Every model, the reference first.
    pub const ALL: [Self; 3] = [Self::Path, Self::Diffusion, Self::Kernel];

    /// Name on the command line and in answers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::Diffusion => "diffusion",
            Self::Kernel => "kernel",
        }
    }

    /// Whether it tracks photons, so that effort and seed mean something.
    pub fn walks(self) -> bool {
        matches!(self, Self::Path)
    }

    /// Asks the model about `stack`; one that tracks photons tells `watch` how many photons are done.
    ///
    /// # Errors
    /// What the model cannot say, and what to do instead.
    pub fn ask(
        self,
        stack: &Stack,
        question: &Question,
        effort: Effort,
        watch: &(dyn Fn(u64) + Sync),
    ) -> Result<Answer, String> {
        match self {
            Self::Path => Ok(solve_watched(stack, question, effort, watch)),
            Self::Diffusion => diffusion::solve(stack, question),
            Self::Kernel => kernel::solve(stack, question).map_err(|refusal| refusal.to_string()),
        }
    }
}
