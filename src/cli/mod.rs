//! The command line: `gen --recipe R --n N`, `gen preview`, `gen validate`, `gen recipe`, `gen schema`, `gen transport`,
//! `gen study`, `gen compare`, `gen icon`, `gen check`, `gen export`, `gen report`.
//!
//! Exit status: 0 done, 1 faults or refusal, 2 unusable arguments, 3 an accuracy below what was asked for.

mod check;
mod compare;
mod export;
mod generate;
mod icon;
mod output;
mod progress;
mod recipe;
mod report;
mod study;
mod transport;
mod validate;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, CommandFactory, Parser, Subcommand, ValueEnum};
use output_schema::file::DATASET;

use crate::preview;
use dataset::Dataset;
use progress::say;
use ::recipe::Recipe;

/// Simulated laser-triangulation scans with subsurface scattering, as labelled datasets.
#[derive(Debug, Parser)]
#[command(name = "gen", version, max_term_width = 100, args_conflicts_with_subcommands = true)]
#[command(after_help = "Examples:
  gen preview --recipe wood.yaml --index 3 --out plank.png     look at one sample first
  gen --recipe wood.yaml --n 10000 --estimate                  what it would take
  gen --recipe wood.yaml --n 10000 --out planks                make it, or continue it
  gen --recipe wood.yaml --n 10000 --out planks --part 0/4     every fourth shard, for four machines
  gen validate planks                                          check every file and label
  gen recipe show wood > mine.yaml                             a recipe to change; gen recipe list
  gen transport --medium clear-wood --model path               light inside plane layers
  gen study point                                              a point of light on wood, by every model
  gen compare planks scans                                     simulated beside real: noise, speckle, plots
  gen check planks --model knots.onnx                          what a trained model makes of it
  gen export coco planks --out planks-coco                     in other people's formats, without rendering again
  gen report planks                                            one page for people, planks/reports/report.html
  gen icon plank.xml                                           what a file of the real camera holds
  gen schema recipe > recipe.schema.json                       for an editor's completion")]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    generate: GenerateArgs,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Draw one sample: sensor frame, Range, Reflectance, Scatter and labels side by side
    Preview(PreviewArgs),
    /// Check a dataset: files, draws, images, labels, statistics, samples rendered again
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
    Compare(compare::CompareArgs),
    /// Run a trained model (ONNX) over a dataset: confusion, accuracy, calibration, slices, the worst answers
    Check(check::CheckArgs),
    /// Write a dataset in other people's formats: COCO, MVTec AD folders, WebDataset, PNG, files of the real camera
    Export {
        /// Which format
        #[command(subcommand)]
        format: export::ExportCommand,
    },
    /// Show a dataset as one HTML page: samples, classes, histograms, frames, sizes, and results that are kept
    Report(report::ReportArgs),
    /// Say what files of the real camera (iCon .dat and .xml) hold
    Icon(icon::IconArgs),
    /// Print the JSON Schema of recipes or of datasets, or the reference of recipe keys
    Schema {
        /// What to print
        what: SchemaKind,
    },
}

/// Arguments of a generating run.
#[derive(Debug, Args)]
pub(crate) struct GenerateArgs {
    /// Recipe: a YAML file, a built-in one (wood, wood-small, blister, ...), or the folder of a dataset to continue
    #[arg(long, value_name = "FILE")]
    recipe: Option<String>,
    /// Samples that the dataset shall have; a larger number later extends it
    #[arg(long, value_name = "N")]
    n: Option<u64>,
    /// Folder of the dataset [default: the one that --recipe names, else out/<recipe name>]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Seed; sample i depends on recipe, seed and i alone [default: that of the dataset that --recipe continues, else 0]
    #[arg(long)]
    seed: Option<u64>,
    /// Threads [default: all cores]
    #[arg(long, value_name = "T")]
    threads: Option<usize>,
    /// Make part K of M only (shards K, K+M, K+2M, ...), for as many processes or machines as wanted
    #[arg(long, value_name = "K/M", value_parser = parse_part, default_value = "0/1")]
    part: (u64, u64),
    /// Samples in a shard [default: those of a dataset that is continued, the recipe's, or what stays under about 500 MB]
    #[arg(long, value_name = "S")]
    samples_per_shard: Option<u64>,
    /// Say what it would take (time, disk, samples of each class) and stop
    #[arg(long)]
    estimate: bool,
}

#[derive(Debug, Args)]
struct PreviewArgs {
    /// Recipe: a YAML file, a built-in one, or the folder of a dataset
    #[arg(long, value_name = "FILE")]
    recipe: String,
    /// Which sample
    #[arg(long, default_value_t = 0)]
    index: u64,
    /// Seed [default: that of the dataset whose folder --recipe names, else 0]
    #[arg(long)]
    seed: Option<u64>,
    /// Where the picture goes (PNG)
    #[arg(long, value_name = "FILE", default_value = "preview.png")]
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
}

/// What a command ends with.
type CommandResult = Result<ExitCode, Box<dyn std::error::Error + Send + Sync>>;

/// Reads the arguments and does what they say.
pub fn run() -> ExitCode {
    let cli = Cli::parse();
    let outcome = match cli.command {
        Some(Command::Preview(arguments)) => preview_command(&arguments),
        Some(Command::Validate(arguments)) => validate::run(&arguments),
        Some(Command::Recipe { what }) => recipe::run(&what),
        Some(Command::Transport(arguments)) => transport::run(&arguments),
        Some(Command::Study { what }) => study::run(&what),
        Some(Command::Compare(arguments)) => compare::run(&arguments),
        Some(Command::Check(arguments)) => check::run(&arguments),
        Some(Command::Export { format }) => export::run(&format),
        Some(Command::Report(arguments)) => report::run(&arguments),
        Some(Command::Icon(arguments)) => icon::run(&arguments),
        Some(Command::Schema { what }) => schema_command(what),
        None if cli.generate.recipe.is_none() && cli.generate.n.is_none() => {
            // Nobody asked for anything: the help, and the status of a usage error.
            print(&Cli::command().render_help().to_string());
            return ExitCode::from(2);
        }
        None => generate::run(&cli.generate),
    };
    outcome.unwrap_or_else(|error| {
        say(&format!("gen: {}", error.to_string().trim_end()));
        if error.is::<UsageError>() { ExitCode::from(2) } else { ExitCode::FAILURE }
    })
}

/// Arguments that cannot be used, and what to give instead.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct UsageError(String);

/// Writes to standard output. A reader that has gone away is no fault.
fn print(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}

/// A recipe, and the dataset that it was taken from where a folder was named.
struct LoadedRecipe {
    recipe: Recipe,
    dataset: Option<Dataset>,
}

impl LoadedRecipe {
    /// The seed that was asked for, else that of the dataset, else 0.
    fn seed(&self, asked: Option<u64>) -> u64 {
        asked.or(self.dataset.as_ref().map(|dataset| dataset.head().seed)).unwrap_or(0)
    }
}

/// The recipe in the file `name`, the built-in one of that name, or that of the dataset in the folder `name`.
fn load(name: &str) -> Result<LoadedRecipe, Box<dyn std::error::Error + Send + Sync>> {
    if Path::new(name).join(DATASET).is_file() {
        let dataset = Dataset::open(Path::new(name))?;
        return Ok(LoadedRecipe { recipe: crate::generate::recipe_of(&dataset)?, dataset: Some(dataset) });
    }
    if let Some(known) = Recipe::built_in(name).filter(|known| known.name != name) {
        say(&format!(
            "there is no file {name}: the built-in recipe `{0}` is taken; `gen recipe show {0} > {name}` makes the file",
            known.name
        ));
    }
    Ok(LoadedRecipe { recipe: Recipe::load(name)?, dataset: None })
}

fn preview_command(arguments: &PreviewArgs) -> CommandResult {
    let loaded = load(&arguments.recipe)?;
    generate::warn(&loaded.recipe);
    let picture = preview::preview(&loaded.recipe, loaded.seed(arguments.seed), arguments.index);
    output::write(&arguments.out, &output::png(&picture)?)?;
    say(&format!("{}: {} x {} px", arguments.out.display(), picture.width(), picture.height()));
    Ok(ExitCode::SUCCESS)
}

fn schema_command(what: SchemaKind) -> CommandResult {
    let text = match what {
        SchemaKind::Recipe => format!("{:#}\n", ::recipe::schema()),
        SchemaKind::Dataset => format!("{:#}\n", output_schema::json_schema()),
        SchemaKind::RecipeReference => ::recipe::reference_markdown(),
    };
    print(&text);
    Ok(ExitCode::SUCCESS)
}

fn parse_part(text: &str) -> Result<(u64, u64), String> {
    let wrong = || format!("'{text}' is not K/M with 0 <= K < M, for instance 0/4 for the first of four parts");
    let (part, parts) = text.split_once('/').ok_or_else(wrong)?;
    let (part, parts): (u64, u64) = (part.parse().map_err(|_| wrong())?, parts.parse().map_err(|_| wrong())?);
    if part < parts { Ok((part, parts)) } else { Err(wrong()) }
}
