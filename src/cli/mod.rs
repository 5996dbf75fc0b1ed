//! The command line: `gen --recipe R --n N`, `gen preview`, `gen rig`, `gen list`, `gen validate`, `gen recipe`, `gen
//! schema`, `gen transport`, `gen study`, `gen compare`, `gen fit`, `gen cover`, `gen finish`, `gen icon`, `gen
//! fibres`, `gen check`, `gen export`, `gen report`, `gen completions`, `gen man`.
//!
//! Exit status: 0 done, 1 faults or refusal, 2 unusable arguments, 3 an accuracy below what was asked for, 130 stopped
//! by Ctrl-C.

mod check;
mod compare;
mod completions;
mod console;
mod cover;
mod declarations;
mod export;
mod fibres;
mod finish;
mod fit;
mod generate;
mod icon;
mod list;
mod output;
mod progress;
mod recipe;
mod remaining_time;
mod report;
mod rig;
mod study;
mod transport;
mod tune;
mod validate;

use std::ffi::OsString;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};

use crate::api::{LoadedRecipe, holds_dataset};
use crate::preview;
use ::recipe::{Change, Recipe, nearest_spelling};
use console::{Console, ConsoleArgs, say, shown};
use progress::Progress;

/// Simulated laser-triangulation scans with subsurface scattering, as labelled datasets.
#[derive(Debug, Parser)]
#[command(name = "gen", version, max_term_width = 100, args_conflicts_with_subcommands = true)]
#[command(after_help = "Examples:
  gen preview --recipe wood.yaml --index 3 --out plank.png     look at one sample first
  gen --recipe wood.yaml --n 10000 --estimate                  what it would take
  gen --recipe wood.yaml --n 10000 --out planks                make it, or continue it
  gen --recipe wood.yaml --n 10000 --out planks --part 0/4     every fourth shard, for four machines
  gen wood -n 40 --set camera.tilt_deg=30 -o steep             a key of the recipe changed
  gen validate planks                                          check every file and label
  gen rig wood                                                 field of view, resolution, line, exposure, noise
  gen list                                                     the datasets below out
  gen recipe show wood > mine.yaml                             a recipe to change; gen recipe list
  gen transport --medium clear-wood --model path               light inside plane layers
  gen study point                                              a point of light on wood, by every model
  gen compare planks scans                                     simulated beside real: noise, speckle, plots
  gen fit --recipe mine.yaml --real scans                      the recipe's numbers from a real camera's scans
  gen cover mine.yaml --real scans                             whether its spread holds them, and what to widen
  gen check planks --model knots.onnx                          what a trained model makes of it
  gen export coco planks --out planks-coco                     in other people's formats, without rendering again
  gen report planks                                            one page for people, planks/reports/report.html
  gen finish planks                                            card and metadata, where data files lie in a bucket
  gen icon plank.xml                                           what a file of the real camera holds
  gen fibres board.png --pixel-mm 0.1 --encoding srgb          fibre directions from a photograph
  gen schema recipe > recipe.schema.json                       for an editor's completion

Exit status: 0 all samples of the dataset, or of its part, are there, whoever made them; 1 they are not;
2 unusable arguments; 130 stopped by Ctrl-C, and the same command goes on.")]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    generate: GenerateArgs,
    #[command(flatten)]
    console: ConsoleArgs,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Draw one sample: sensor frame, Range, Reflectance, Scatter and labels side by side
    Preview(PreviewArgs),
    /// Say what the rig of a recipe is: field of view, resolution, line, exposure, speckle, noise, with warnings
    Rig(rig::RigArgs),
    /// List datasets with their facts: recipe, seed, samples, classes, splits, size
    List(list::ListArgs),
    /// Check a dataset: files, draws, images, labels, rows exposed again, samples rendered again
    Validate(validate::ValidateArgs),
    /// List the recipes that are built in, or print the text of one
    Recipe {
        /// What to do
        #[command(subcommand)]
        what: recipe::RecipeCommand,
    },
    /// Ask a model of light inside matter about plane layers: reflectance, spread, angles, with standard errors
    Transport(transport::TransportArgs),
    /// Compare the models of light inside matter: a table, a JSON file and a picture
    Study {
        /// What to compare
        #[command(subcommand)]
        what: study::StudyCommand,
    },
    /// Put the statistics of a simulated and a real scan side by side: noise, speckle, distances, plots
    Compare(Box<compare::CompareArgs>),
    /// Turn scans of a real camera into a recipe: which values of its keys make simulated scans look like them
    Fit(Box<fit::FitArgs>),
    /// Say where real scans lie in the spread of a recipe's own, and which keys to widen; without any, what it varies
    Cover(Box<cover::CoverArgs>),
    /// Run a trained model (ONNX) over a dataset: confusion, accuracy, calibration, slices, the worst answers
    Check(check::CheckArgs),
    // The list of exports has its help.
    Export {
        /// Which format
        #[command(subcommand)]
        format: export::ExportCommand,
    },
    /// Show a dataset as one HTML page: samples, classes, histograms, frames, sizes, and results that are kept
    Report(report::ReportArgs),
    /// Write card and metadata of a dataset from its dataset.json and manifests alone: its other files may lie
    /// elsewhere
    Finish(finish::FinishArgs),
    /// Say what files of the real camera (iCon .dat and .xml) hold
    Icon(icon::IconArgs),
    /// Find fibre directions, knots and absorption of a board in a picture of it
    Fibres(fibres::FibresArgs),
    /// Turn the keys of a recipe on a page of this machine's browser, and see a sample of it at once
    Tune(tune::TuneArgs),
    /// Print the JSON Schema of recipes or of datasets, or the reference of recipe keys
    Schema {
        /// What to print
        what: SchemaKind,
    },
    /// Print what makes a shell complete commands, options and their values
    Completions(completions::CompletionsArgs),
    /// Print the manual's page of a command
    Man(completions::ManArgs),
}

/// Arguments of a generating run.
#[derive(Debug, Args)]
pub(crate) struct GenerateArgs {
    #[command(flatten)]
    recipe: RecipeName,
    #[command(flatten)]
    changes: Changes,
    /// Samples that the dataset shall have; a larger number later extends it. Of one that was begun with more, only the
    /// shards with the first N are made; where nothing of it is made yet, it is begun anew
    #[arg(short, long, value_name = "N", value_parser = whole::<u64>)]
    n: Option<u64>,
    /// What other programs call `-n`.
    #[arg(long, hide = true, aliases = ["count", "number", "num-samples", "num"], value_name = "N",
        value_parser = not_n)]
    samples: Option<u64>,
    /// Folder of the dataset [default: the one that --recipe names, else out/<recipe name>]
    #[arg(short, long, value_name = "DIR", value_parser = output::folder())]
    out: Option<PathBuf>,
    /// Seed; sample i depends on recipe, seed and i alone [default: that of the dataset that --recipe continues, else
    /// 0]
    #[arg(long, value_parser = whole::<u64>)]
    seed: Option<u64>,
    /// Threads [default: all cores]
    #[arg(short = 'j', long, value_name = "T", value_parser = whole::<usize>)]
    threads: Option<usize>,
    /// Make part K of M only (shards K, K+M, K+2M, ...), for as many processes or machines as wanted. Shards that other
    /// processes are making come last and are waited for; whatever they leave unfinished is made here
    #[arg(long, value_name = "K/M", value_parser = parse_part, default_value = "0/1", allow_hyphen_values = true)]
    part: (u64, u64),
    /// Samples in a shard, which is kept as a whole or not at all [default: those of a dataset that is continued, the
    /// recipe's, or what stays under about 500 MB and about a minute's work of two cores]
    #[arg(long, value_name = "S", value_parser = whole::<u64>)]
    samples_per_shard: Option<u64>,
    /// Take warnings of the rig's check (nothing in the field, hardly or partly measured, saturated, values that look
    /// like a mistake) as errors: nothing is written. Where only single samples fall short, all are written and the
    /// exit status is 1
    #[arg(long)]
    strict: bool,
    /// Say what it would take (time, disk, samples of each class) and stop
    #[arg(long)]
    estimate: bool,
    /// Print the estimate, or what was made, as JSON
    #[arg(long)]
    json: bool,
    /// For programs: all that is said on standard error is a JSON object a line. Its `event` is begin (samples,
    /// finished), anew (samples, samples_per_shard: as it was begun) and larger (samples, to_make, left) of a dataset
    /// that is there, profiles (done, of; at most one a second), sample (bytes), shard, busy and waits (shard), note,
    /// fault and stopped (text)
    #[arg(long, conflicts_with = "quiet")]
    events: bool,
}

/// Changes to a recipe.
#[derive(Debug, Args)]
struct Changes {
    /// Change a key of the recipe, the value in YAML: --set camera.tilt_deg=30; may be given several
    /// times, and of one key the last counts
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Change>,
}

/// The name of a recipe, as a word or behind `--recipe`.
#[derive(Debug, Args)]
struct RecipeName {
    /// Recipe: a YAML file, a built-in one (wood, wood-small, blister, ...), the folder of a dataset, or - for standard
    /// input
    #[arg(id = "recipe_word", value_name = "RECIPE", conflicts_with = "recipe")]
    word: Option<String>,
    /// The same, behind an option
    #[arg(id = "recipe", long = "recipe", value_name = "FILE")]
    option: Option<String>,
}

impl RecipeName {
    fn given(&self) -> Option<&str> {
        self.word.as_deref().or(self.option.as_deref())
    }

    fn get(&self) -> Result<&str, UsageError> {
        self.given().ok_or_else(|| {
            let remedy =
                "name a YAML file or a built-in one, for instance --recipe wood.yaml; gen recipe list has them";
            UsageError(format!("which recipe? {remedy}"))
        })
    }
}

/// A recipe, and changes to it.
#[derive(Debug, Args)]
struct RecipeArgs {
    #[command(flatten)]
    name: RecipeName,
    #[command(flatten)]
    changes: Changes,
}

#[derive(Debug, Args)]
struct PreviewArgs {
    #[command(flatten)]
    recipe: RecipeArgs,
    /// Which sample
    #[arg(long, default_value_t = 0, value_parser = whole::<u64>)]
    index: u64,
    /// Seed [default: that of the dataset whose folder --recipe names, else 0]
    #[arg(long, value_parser = whole::<u64>)]
    seed: Option<u64>,
    /// Where the picture goes (PNG); - for standard output
    #[arg(short, long, value_name = "FILE", default_value = "preview.png",
          value_parser = output::file_or_standard_output("png"))]
    out: PathBuf,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum SchemaKind {
    /// JSON Schema of a recipe
    Recipe,
    /// JSON Schema of dataset.json and the manifests, with every column
    Dataset,
    /// Every recipe key in words (recipes/README.md)
    RecipeReference,
    /// Every command with its arguments, as JSON
    Commands,
}

/// What a command, or a step of one, ends with; without a type the exit status of the program.
type CommandResult<T = u8> = Result<T, Box<dyn std::error::Error + Send + Sync>>;

/// Exit status of what is done.
const DONE: u8 = 0;
/// Exit status of faults that were found, and of refusals.
const FAULTS: u8 = 1;
/// Exit status of arguments that cannot be used.
const UNUSABLE: u8 = 2;

/// Reads the arguments, of which the first is the name of the program, does what they say, and returns the exit status.
/// Only Ctrl-C, which is listened to from here on, ends the process.
pub fn run_from(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let outcome = misspelt_command(&arguments).map_or_else(|| command().try_get_matches_from(arguments), Err);
    let outcome = outcome.and_then(|found| Cli::from_arg_matches(&found));
    let outcome = match outcome {
        Ok(cli) => {
            let console = Console::new(&cli.console, cli.generate.events);
            let outcome = obey(cli, &console);
            return outcome.unwrap_or_else(|error| {
                let status = if error.is::<UsageError>() { UNUSABLE } else { FAULTS };
                console.fault(error.to_string().trim_end(), status);
                status
            });
        }
        Err(error) if error.use_stderr() => {
            // Whoever closes the other end of standard error does not change what the arguments are.
            let _ = error.print();
            Ok(UNUSABLE)
        }
        // Help and version are results as others are.
        Err(error) => printed(error.print().and_then(|()| std::io::stdout().flush())).map(|()| DONE),
    };
    outcome.unwrap_or_else(|error| {
        say(&format!("gen: {}", error.to_string().trim_end()));
        FAULTS
    })
}

/// The fault of a first word that is no command and no recipe, and is spelt like a command.
fn misspelt_command(arguments: &[OsString]) -> Option<clap::Error> {
    let word = arguments.get(1)?.to_str().filter(|word| !word.starts_with('-'))?;
    let command = command();
    if command.find_subcommand(word).is_some() || word == "help" || Path::new(word).exists() {
        return None;
    }
    // A recipe of that name, or of one that is as near, was meant.
    let recipes = Recipe::embedded().map(|known| known.name.rsplit('/').next().unwrap_or(known.name));
    let names = command.get_subcommands().map(clap::Command::get_name);
    let meant = nearest_spelling(word, recipes.chain(names))?;
    let meant = command.find_subcommand(meant)?.get_name().to_owned();
    let text = format!("`{word}` is neither a command nor a recipe; did you mean `gen {meant}`?\n");
    Some(clap::Error::raw(clap::error::ErrorKind::InvalidSubcommand, text).with_cmd(&command))
}

fn obey(cli: Cli, console: &Console) -> CommandResult {
    console.listen();
    match cli.command {
        Some(Command::Preview(arguments)) => preview_command(&arguments, console),
        Some(Command::Rig(arguments)) => rig::run(&arguments, console),
        Some(Command::List(arguments)) => list::run(&arguments, console),
        Some(Command::Validate(arguments)) => validate::run(&arguments, console),
        Some(Command::Recipe { what }) => recipe::run(&what, console),
        Some(Command::Transport(arguments)) => transport::run(&arguments, console),
        Some(Command::Study { what }) => study::run(&what, console),
        Some(Command::Compare(arguments)) => compare::run(&arguments, console),
        Some(Command::Fit(arguments)) => fit::run(&arguments, console),
        Some(Command::Cover(arguments)) => cover::run(&arguments, console),
        Some(Command::Check(arguments)) => check::run(&arguments, console),
        Some(Command::Export { format }) => export::run(&format, console),
        Some(Command::Report(arguments)) => report::run(&arguments, console),
        Some(Command::Finish(arguments)) => finish::run(&arguments, console),
        Some(Command::Icon(arguments)) => icon::run(&arguments),
        Some(Command::Fibres(arguments)) => fibres::run(&arguments),
        Some(Command::Tune(arguments)) => tune::run(&arguments, console),
        Some(Command::Schema { what }) => schema_command(what),
        Some(Command::Completions(arguments)) => completions::run(&arguments, &mut command()),
        Some(Command::Man(arguments)) => completions::manual(&arguments, command()),
        None if cli.generate.recipe.given().is_none() && cli.generate.n.is_none() => {
            // Nobody asked for anything: the help, and the status of a usage error.
            print(&command().render_help().to_string()).map(|()| UNUSABLE)
        }
        None => generate::run(&cli.generate, console),
    }
}

/// The command line, as it is parsed; a number below zero is the value that an option has, and not another option.
pub fn command() -> clap::Command {
    fn with_negative_numbers(command: clap::Command) -> clap::Command {
        let numbers = |argument: clap::Arg| {
            let takes_value = argument.get_action().takes_values();
            if takes_value { argument.allow_negative_numbers(true) } else { argument }
        };
        command.mut_args(numbers).mut_subcommands(with_negative_numbers)
    }
    with_negative_numbers(Cli::command())
}

/// Arguments that cannot be used, and what to give instead.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct UsageError(String);

/// Writes all of a result to standard output. A reader that has gone away is no fault; a disk that takes no more is
/// one.
fn print(text: &str) -> CommandResult<()> {
    let mut out = std::io::stdout().lock();
    printed(out.write_all(shown(text).as_bytes()).and_then(|()| out.flush()))
}

/// What became of a result on standard output, in words.
fn printed(result: std::io::Result<()>) -> CommandResult<()> {
    match result {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            let remedy = "what it holds is not whole: make room there, then try again";
            Err(format!("cannot write to standard output: {e}; {remedy}").into())
        }
        _ => Ok(()),
    }
}

impl RecipeArgs {
    /// The recipe, changed.
    fn load(&self, console: &Console) -> CommandResult<LoadedRecipe> {
        load(self.name.get()?, &self.changes.set, console)
    }
}

/// The recipe in the file `name`, the built-in one of that name, that of the dataset in the folder `name`, or on
/// standard input that of the name `-`; with changes.
fn load(name: &str, changes: &[Change], console: &Console) -> CommandResult<LoadedRecipe> {
    let loaded = if name == "-" && !holds_dataset(Path::new(name)) {
        let origin = "standard input";
        let bytes = yaml::read_bytes_or_standard_input(Path::new(name))
            .map_err(|error| format!("{origin} cannot be read: {error}; send the text of a recipe, or name a file"))?;
        let text = yaml::utf8_text(origin, bytes, "recipe")?;
        crate::api::parse(origin, &text, changes)?
    } else {
        if let Some(known) = Recipe::built_in(name).filter(|known| known.name != name && !Path::new(name).is_dir()) {
            console.note(&format!(
                "there is no file {name}: the built-in recipe `{0}` is taken; `gen recipe show {0} > {name}` makes \
                    the file",
                known.name
            ));
        }
        crate::api::load(name, changes)?
    };
    let recipe = &loaded.recipe;
    console.detail(&format!("recipe {} about {}, {}", recipe.name(), recipe.subject().name(), recipe.hash()));
    Ok(loaded)
}

fn preview_command(arguments: &PreviewArgs, console: &Console) -> CommandResult {
    let loaded = arguments.recipe.load(console)?;
    if !output::is_standard_output(&arguments.out) {
        output::check_replaceable(&arguments.out, output::Written::Png)?;
    }
    generate::warn(&loaded.recipe, console);
    generate::note(&loaded.recipe, console);
    crate::generate::MemoryEstimate::of_preview(&loaded.recipe, rayon::current_num_threads()).check()?;
    let seed = loaded.seed(arguments.seed);
    if let Some(dataset) = loaded.dataset.as_ref().filter(|dataset| arguments.index >= dataset.head().samples) {
        let samples = progress::counted(dataset.head().samples, "sample");
        console.note(&format!(
            "{} has {samples}: number {} is the one that it would have if it were continued",
            dataset.root().display(),
            arguments.index
        ));
    }
    if let Some(dataset) = &loaded.dataset
        && (seed != dataset.head().seed || !arguments.recipe.changes.set.is_empty())
    {
        let root = dataset.root().display();
        console.note(&format!("--seed or --set ask for another sample than number {} of {root}", arguments.index));
    }
    let warnings = crate::generate::sample_warnings(&loaded.recipe, seed, arguments.index);
    generate::tell(&warnings.iter().map(generate::described).collect::<Vec<_>>(), console);
    let picture = {
        let progress = Progress::new(console, "profiles", Some(loaded.recipe.size().profiles as u64));
        preview::preview(&loaded.recipe, seed, arguments.index, &|profiles| progress.add(profiles))
    };
    if output::is_standard_output(&arguments.out) {
        output::write_standard_output(&output::png(&picture)?)?;
        return Ok(DONE);
    }
    output::write(&arguments.out, &output::png(&picture)?)?;
    console.note(&format!("{}: {} x {} px", arguments.out.display(), picture.width(), picture.height()));
    Ok(DONE)
}

fn schema_command(what: SchemaKind) -> CommandResult {
    let text = match what {
        SchemaKind::Recipe => format!("{:#}\n", ::recipe::schema()),
        SchemaKind::Dataset => format!("{:#}\n", output_schema::json_schema()),
        SchemaKind::RecipeReference => ::recipe::reference_markdown(),
        SchemaKind::Commands => format!("{:#}\n", declarations::commands(command())),
    };
    print(&text)?;
    Ok(DONE)
}

/// A whole number that is not negative.
fn whole<T: FromStr>(text: &str) -> Result<T, String> {
    let most = format!("give a whole number of at most {}", u64::MAX);
    let too_great = !text.is_empty() && text.bytes().all(|digit| digit.is_ascii_digit());
    text.parse()
        .map_err(|_| if too_great { most } else { "give a whole number that is not negative, for instance 100".into() })
}

/// Refuses what other programs call `-n`, which names it.
fn not_n(text: &str) -> Result<u64, String> {
    Err(format!("samples are asked for with -n: give -n {text}"))
}

fn parse_part(text: &str) -> Result<(u64, u64), String> {
    let wrong = || format!("'{text}' is not K/M with 0 <= K < M, for instance 0/4 for the first of four parts");
    let (part, parts) = text.split_once('/').ok_or_else(wrong)?;
    let (part, parts): (u64, u64) = (part.parse().map_err(|_| wrong())?, parts.parse().map_err(|_| wrong())?);
    if part < parts { Ok((part, parts)) } else { Err(wrong()) }
}
