use super::Outcome;
use clap::Subcommand;
#[derive(Debug, Subcommand)]
pub(super) enum Study {
    Point,
}
pub(super) fn run(_: &Study) -> Outcome {
    todo!()
}
