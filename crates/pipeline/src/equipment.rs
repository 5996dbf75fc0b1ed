//! What renders take beside a scene: patterns of speckle, and the models that answer one line at a time.

use base::Stream;
use optical_bench::settings::Transport;
use scanner::optics::speckle::PatternCache;
use transport::line::LineSolver;

/// The model that `transport:` of a recipe names, for the sample of a stream; `None` for the kernel.
pub type LineSolvers = fn(Transport, Stream) -> Option<Box<dyn LineSolver>>;

/// What renders take beside a scene, and share for as long as a run.
#[derive(Debug, Clone, Copy)]
pub struct Equipment<'a> {
    /// Patterns of speckle.
    pub patterns: &'a PatternCache,
    /// Models other than the kernel. The pipeline knows none of them by name.
    pub line_solvers: LineSolvers,
}

impl<'a> From<&'a PatternCache> for Equipment<'a> {
    /// For scenes of the kernel.
    fn from(patterns: &'a PatternCache) -> Self {
        Self { patterns, line_solvers: kernel_alone }
    }
}

/// Knows no model beside the kernel.
///
/// # Panics
/// Where a scene asks for another one: a caller that renders such scenes hands [`Equipment`] over that has it.
fn kernel_alone(transport: Transport, _: Stream) -> Option<Box<dyn LineSolver>> {
    assert!(transport == Transport::Kernel, "nobody gave the pipeline the model `transport: {}`", transport.name());
    None
}
