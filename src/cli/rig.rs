//! `gen rig`: the rig of a recipe in the words of data sheets.

use clap::Args;

use super::console::Console;
use super::generate::{note, tell, variation_json};
use super::{CommandResult, DONE, RecipeArgs, print, whole};
use rig::report;

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen rig wood                                     field of view, resolution, line, exposure, speckle, noise
  gen rig wood --set camera.tilt_deg=40            what a steeper view would change
  gen rig mine.yaml --index 7 --json               of another sample, for programs
  gen rig mine.yaml --strict                       for scripts: status 1 where it warns

Numbers go to standard output, warnings to standard error; the document of --json holds both.
Numbers that the recipe draws are those of one sample. docs/theory/instrument.md explains the bench.")]
pub(super) struct RigArgs {
    #[command(flatten)]
    recipe: RecipeArgs,
    /// Which sample's draws
    #[arg(long, default_value_t = 0, value_parser = whole::<u64>)]
    index: u64,
    /// Seed [default: that of the dataset whose folder is named, else 0]
    #[arg(long, value_parser = whole::<u64>)]
    seed: Option<u64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Take warnings as errors: the numbers are printed, and the exit status is 1
    #[arg(long)]
    strict: bool,
}

pub(super) fn run(arguments: &RigArgs, console: &Console) -> CommandResult {
    let loaded = arguments.recipe.load(console)?;
    note(&loaded.recipe, console);
    let seed = loaded.seed(arguments.seed);
    let report = report(&loaded.recipe.draw(seed, arguments.index));
    if arguments.json {
        let mut document = report.json();
        document["recipe"] = loaded.recipe.name().into();
        document["variation"] = variation_json(&loaded.recipe);
        (document["seed"], document["index"]) = (seed.into(), arguments.index.into());
        print(&format!("{document:#}\n"))?;
    } else {
        print(&report.table())?;
    }
    if arguments.strict && !report.warnings.is_empty() {
        return Err(format!("--strict: {}", report.warnings.join("\n")).into());
    }
    tell(&report.warnings, console);
    Ok(DONE)
}
