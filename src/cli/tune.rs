//! `gen tune`: a page of this machine's browser on which the keys of a recipe are turned.

use std::path::{Path, PathBuf};

use clap::Args;

use super::console::Console;
use super::generate::threads;
use super::{CommandResult, DONE, RecipeArgs, UsageError, output, print, whole};
use crate::api::{self, holds_dataset};
use crate::tune::{TuneServer, TuneStart};
use recipe::asset_source::AssetSource;
use recipe::{Recipe, RecipeError, with_key};

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen tune mine.yaml                               open the address that it prints in a browser
  gen tune wood --set camera.tilt_deg=40           of a built-in recipe, which is saved by another name
  gen tune mine.yaml --index 7 --port 8100         begins with that sample; the same port each time

Only this machine is answered, and only where the whole address is known: it ends in a token that is new each time.
Nothing is written before one saves. Ctrl-C ends it. docs/guide/tune.md shows the page.")]
pub(super) struct TuneArgs {
    #[command(flatten)]
    recipe: RecipeArgs,
    /// Which sample is shown first
    #[arg(long, default_value_t = 0, value_parser = whole::<u64>)]
    index: u64,
    /// Seed [default: that of the dataset whose folder is named, else 0]
    #[arg(long, value_parser = whole::<u64>)]
    seed: Option<u64>,
    /// Port of 127.0.0.1 [default: any that is free]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    port: Option<u16>,
    /// Threads [default: all cores]
    #[arg(short = 'j', long, value_name = "T", value_parser = whole::<usize>)]
    threads: Option<usize>,
}

/// Largest whole number that a page's script counts to without a gap, 2^53 - 1.
const MAX_NUMBER: u64 = (1 << 53) - 1;

pub(super) fn run(arguments: &TuneArgs, console: &Console) -> CommandResult {
    let name = arguments.recipe.name.get()?;
    let mut start =
        TuneStart { index: arguments.index, threads: threads(arguments.threads)?, ..found(name, arguments.seed)? };
    for (what, number) in [("--index", start.index), ("--seed", start.seed)] {
        if number > MAX_NUMBER {
            return Err(UsageError(format!("{what}: a page counts to {MAX_NUMBER}; give at most that")).into());
        }
    }
    for change in &arguments.recipe.changes.set {
        start.text = with_key(&start.text, change);
    }
    let server = TuneServer::open(start, arguments.port.unwrap_or(0)).map_err(|error| {
        let port = arguments.port.map_or_else(|| "any port".into(), |port| format!("port {port}"));
        format!("cannot listen at {port} of 127.0.0.1: {error}; give another one with --port")
    })?;
    console.on_stop(|| "what was not saved on the page is gone".into());
    print(&format!("{}\n", server.address()))?;
    console.note("open this address in a browser of this machine; Ctrl-C ends it");
    server.serve();
    Ok(DONE)
}

/// The recipe of that name: a file, the dataset in a folder, or one that is built in. A file may have faults, which the
/// page shows.
fn found(name: &str, seed: Option<u64>) -> CommandResult<TuneStart> {
    let path = Path::new(name);
    let start = |text: String, file: Option<PathBuf>, folder: PathBuf, files: AssetSource| TuneStart {
        text,
        origin: name.to_owned(),
        file,
        folder,
        files,
        seed: seed.unwrap_or(0),
        index: 0,
        threads: 1,
        save: |path, content| output::write_or(path, content, "save it by another name"),
    };
    if path.is_dir() {
        let loaded = api::load(name, &[])?;
        debug_assert!(holds_dataset(path));
        let seed = loaded.seed(seed);
        let recipe = loaded.recipe;
        return Ok(TuneStart { seed, ..start(recipe.text().to_owned(), None, PathBuf::new(), recipe.kept_files()) });
    }
    if name == "-" {
        let bytes = yaml::read_bytes_or_standard_input(path).map_err(|error| format!("standard input: {error}"))?;
        let text = yaml::utf8_text("standard input", bytes, "recipe")?;
        if text.trim().is_empty() {
            return Err("standard input is empty; send the text of a recipe, or name a file".into());
        }
        return Ok(start(text, None, PathBuf::new(), AssetSource::Beside(PathBuf::new())));
    }
    if path.exists() {
        let unreadable = |source| RecipeError::Unreadable { path: path.to_owned(), source };
        let text = yaml::utf8_text(name, yaml::read_bytes(path).map_err(unreadable)?, "recipe")?;
        if text.len() > yaml::MAX_FILE_BYTES {
            // What says so of every recipe.
            Recipe::load(name)?;
        }
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        return Ok(start(text, Some(path.to_owned()), folder.clone(), AssetSource::Beside(folder)));
    }
    let recipe = Recipe::load(name)?;
    Ok(start(recipe.written().to_owned(), None, PathBuf::new(), AssetSource::Beside(PathBuf::new())))
}
