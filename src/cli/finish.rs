//! `gen finish DIR`: card and metadata of a dataset whose data files lie elsewhere, from `dataset.json` and manifests.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::console::Console;
use super::progress::counted;
use super::{CommandResult, DONE, print};
use dataset::Dataset;

/// Arguments of `gen finish`.
#[derive(Debug, Args)]
pub(super) struct FinishArgs {
    /// Folder with dataset.json and shards/; README.md and croissant.json are written there
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Print what is there as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &FinishArgs, console: &Console) -> CommandResult {
    let dataset = Dataset::open(&arguments.folder)?;
    dataset.finish(&|| console.note("waiting for another process, which holds the folder"))?;
    let head = dataset.head();
    if arguments.json {
        let document = json!({
            "out": arguments.folder.display().to_string(), "recipe": head.recipe.name, "recipe_hash": head.recipe.hash,
            "seed": head.seed, "samples": head.samples, "shards": head.shards,
        });
        print(&format!("{document:#}\n"))?;
    } else {
        let (samples, shards) = (counted(head.samples, "sample"), counted(head.shards, "shard"));
        console.note(&format!("{}: {samples} in {shards}, finished", arguments.folder.display()));
    }
    Ok(DONE)
}
