//! `gen export`: a dataset in other people's formats. Names, help and options come from the list of exports.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{ArgMatches, Args, FromArgMatches, Subcommand};
use serde_json::json;

use super::check::SplitChoice;
use super::console::Console;
use super::generate::threads;
use super::progress::{Progress, counted, describe_bytes};
use super::{CommandResult, DONE, UsageError, output, print, whole};
use tools::export::{EXPORTS, Export, ExportSource, Selection};

/// Version of the layout of the document that `--json` prints.
const SCHEMA_VERSION: u32 = 1;

/// A format, with its options and those of all.
#[derive(Debug)]
pub(super) struct ExportCommand {
    name: &'static str,
    common: ExportArgs,
    export: Box<dyn Export>,
}

// A documentation comment would become the help of each format.
#[derive(Debug, Args)]
struct ExportArgs {
    /// Folder of the dataset
    dir: PathBuf,
    /// Folder of the export: a new or empty one, or that of the same export, stopped
    #[arg(short, long, value_name = "OUT", value_parser = output::folder())]
    out: PathBuf,
    /// Part of the dataset
    #[arg(long, value_enum, default_value_t = SplitChoice::All)]
    split: SplitChoice,
    /// Samples by number: 3, 0-99, or several: 0-99,205 [default: all]
    #[arg(long, value_name = "I", value_delimiter = ',', value_parser = indices)]
    index: Vec<RangeInclusive<u64>>,
    /// Threads [default: all cores]
    #[arg(short = 'j', long, value_name = "T", value_parser = whole::<usize>)]
    threads: Option<usize>,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

impl Subcommand for ExportCommand {
    fn augment_subcommands(command: clap::Command) -> clap::Command {
        let titles: Vec<&str> = EXPORTS.iter().map(|format| format.title).collect();
        let examples = EXPORTS.iter().map(|format| format.example);
        let examples = examples.chain([["png planks --out pngs --json | jq .files", "what was written, for programs"]]);
        let examples: String = examples.map(|[order, what]| format!("  gen export {order:<50}{what}\n")).collect();
        let formats = EXPORTS.iter().map(|format| {
            let command = ExportArgs::augment_args(clap::Command::new(format.name));
            let [order, what] = format.example;
            (format.add_options)(command).after_help(format!("Example:\n  gen export {order:<50}{what}"))
        });
        command
            .about(format!("Write a dataset in other people's formats: {}", titles.join(", ")))
            .after_help(format!(
                "Examples:\n{examples}\nA stopped export is finished by the same command. docs/guide/export.md \
                 describes every file, and the\nfields of the JSON."
            ))
            .subcommands(formats)
    }

    fn augment_subcommands_for_update(command: clap::Command) -> clap::Command {
        Self::augment_subcommands(command)
    }

    fn has_subcommand(name: &str) -> bool {
        EXPORTS.iter().any(|format| format.name == name)
    }
}

impl FromArgMatches for ExportCommand {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let missing = || clap::Error::new(ErrorKind::MissingSubcommand);
        let (name, found) = matches.subcommand().ok_or_else(missing)?;
        let format = EXPORTS.iter().find(|format| format.name == name).ok_or_else(missing)?;
        let (common, export) = (ExportArgs::from_arg_matches(found)?, (format.read)(found)?);
        Ok(Self { name: format.name, common, export })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Numbers of samples: one, or from one to another.
fn indices(text: &str) -> Result<RangeInclusive<u64>, String> {
    let wrong = || format!("'{text}' is neither a number nor FIRST-LAST, for instance 0-99");
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let (first, last): (u64, u64) = (first.parse().map_err(|_| wrong())?, last.parse().map_err(|_| wrong())?);
    if first <= last { Ok(first..=last) } else { Err(wrong()) }
}

pub(super) fn run(command: &ExportCommand, console: &Console) -> CommandResult {
    let ExportCommand { name, common, export } = command;
    export.check().map_err(UsageError)?;
    let splits = export.splits(common.split.split()).map_err(UsageError)?;
    output::check_outside_datasets(&common.out, false)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads(common.threads)?).build()?;
    let source = ExportSource::open(&common.dir, Selection { splits, indices: common.index.clone() })?;
    export.check_for(source.head()).map_err(UsageError)?;
    if source.unfinished > 0 {
        console.note(&format!("not finished and left out: {} of the dataset", counted(source.unfinished, "shard")));
    }
    let folder = common.out.clone();
    console.on_stop(move || format!("what is written in {} is kept; the same command finishes it", folder.display()));
    let progress = Progress::new(console, "samples", None);
    let summary = pool.install(|| export.write(&source, &common.out, &|done, all| progress.set(done, all)));
    drop(progress);
    let summary = summary?;
    if common.json {
        let document = json!({
            "schema_version": SCHEMA_VERSION,
            "format": name,
            "dataset": common.dir.display().to_string(),
            "out": common.out.display().to_string(),
            "samples": source.samples,
            "unfinished_shards": source.unfinished,
            "nothing_to_do": summary.nothing_to_do,
            "files": (!summary.nothing_to_do).then_some(summary.files),
            "bytes": (!summary.nothing_to_do).then_some(summary.bytes),
            "notes": &summary.notes,
        });
        print(&format!("{document:#}\n"))?;
    }
    let out = common.out.display();
    for note in &summary.notes {
        console.note(&format!("note: {note}"));
    }
    console.note(&match summary.nothing_to_do {
        true => format!("{out} is finished already; there is nothing to do"),
        false => format!(
            "{out}: {} of {}, {}",
            counted(summary.files, "file"),
            counted(source.samples, "sample"),
            describe_bytes(summary.bytes)
        ),
    });
    Ok(DONE)
}
