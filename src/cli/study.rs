//! `gen study`: models of light inside matter side by side, and the instrument against theory.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};

use super::console::Console;
use super::progress::Progress;
use super::{Changes, CommandResult, DONE, RecipeArgs, output, print, whole};
use evidence::reference::path::Effort;
use evidence::study::instrument::{REPEATS, Trials, laser, sensor, speckle, triangulation};
use evidence::study::{StudyEvent, StudyProgress, StudyReport, lines, packs, point, profile};

/// Largest number of photons for a single question: days of work.
const MAX_PHOTONS: u64 = 10_000_000_000;
/// Largest number of repeats of a study of the instrument: hours of work.
const MAX_REPEATS: u64 = 10_000;

#[derive(Debug, Subcommand)]
pub(super) enum StudyCommand {
    /// A point of light on clear wood and on a knot: the ellipses that it makes
    #[command(after_help = "Examples:
  gen study point                                  writes out/study/point.json and point.png
  gen study point --photons 100000 --out quick     a rough look")]
    Point(PhotonArgs),
    /// A line of light on fifteen media: reflectance, spread, asymmetry
    #[command(after_help = "Examples:
  gen study transport                              writes out/study/transport.json and transport.png
  gen study transport --photons 3000000            errors three times smaller")]
    Transport(PhotonArgs),
    /// One profile of a recipe's sample by every model, with the reference's standard errors
    #[command(after_help = "Examples:
  gen study profile --recipe wood-small.yaml --index 15 --profile 128
                                                   writes out/study/profile.json and profile.png")]
    Profile(ProfileArgs),
    /// Flat targets, level and tilted: errors of Range, height of a row, width of a column
    #[command(after_help = "Examples:
  gen study triangulation                          writes out/study/triangulation.json and .png
  gen study triangulation --out targets.png        the picture there, the JSON file beside it")]
    Triangulation(InstrumentArgs),
    /// Photon transfer: gain, noise, linearity, full well, rows that stand out
    #[command(after_help = "Examples:
  gen study sensor                                 writes out/study/sensor.json and sensor.png
  gen study sensor --repeats 64                    errors half as large")]
    Sensor(InstrumentArgs),
    /// Speckle: contrast in a pixel, its law, correlation and movement, what it does to the line's centre
    #[command(after_help = "Examples:
  gen study speckle                                writes out/study/speckle.json and speckle.png
  gen study speckle --repeats 4 --seed 7           a rough look at other patterns")]
    Speckle(InstrumentArgs),
    /// The laser line: width over height, evenness along it, electrons a column
    #[command(after_help = "Examples:
  gen study laser                                  writes out/study/laser.json and laser.png
  gen study laser --out line.png > line.txt        the table in a file")]
    Laser(InstrumentArgs),
    /// One blister pack of each defect: Range, Reflectance, Scatter, and means of the pockets concerned
    #[command(after_help = "Examples:
  gen study packs                                  writes out/study/packs.json and packs.png
  gen study packs --recipe mine.yaml --seed 3      the same defects in packs of a recipe of yours")]
    Packs(PacksArgs),
}

#[derive(Debug, Args)]
pub(super) struct PacksArgs {
    #[command(flatten)]
    common: StudyArgs,
    /// Recipe for blister packs: a YAML file, or a built-in one
    #[arg(long, value_name = "FILE", default_value = "blister-small")]
    recipe: String,
    #[command(flatten)]
    changes: Changes,
}

#[derive(Debug, Args)]
pub(super) struct InstrumentArgs {
    #[command(flatten)]
    common: StudyArgs,
    /// Independent repeats, from whose spread errors come [default: 16]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..=MAX_REPEATS))]
    repeats: Option<u64>,
}

#[derive(Debug, Args)]
pub(super) struct ProfileArgs {
    #[command(flatten)]
    recipe: RecipeArgs,
    /// Which sample
    #[arg(long, default_value_t = 0, value_parser = whole::<u64>)]
    index: u64,
    /// Which profile of it [default: the middle one]
    #[arg(long, value_name = "P", value_parser = whole::<usize>)]
    profile: Option<usize>,
    #[command(flatten)]
    arguments: PhotonArgs,
}

#[derive(Debug, Args)]
pub(super) struct PhotonArgs {
    #[command(flatten)]
    common: StudyArgs,
    /// Photons for each question [default: 1000000 for point, 300000 for transport, 2000000 for profile]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_PHOTONS))]
    photons: Option<u64>,
}

#[derive(Debug, Args)]
pub(super) struct StudyArgs {
    /// Folder for the JSON file and the picture, or the picture's own name, ending in .png; folders are made
    #[arg(short, long, value_name = "PATH", default_value = "out/study", value_parser = output::folder_or_picture())]
    out: PathBuf,
    /// Seed of all chance [default: that of the dataset whose folder --recipe names, else 0]
    #[arg(long, value_name = "S", value_parser = whole::<u64>)]
    seed: Option<u64>,
    /// Threads [default: all cores]
    #[arg(short = 'j', long, value_name = "T", value_parser = whole::<usize>)]
    threads: Option<usize>,
}

impl StudyArgs {
    fn seed(&self) -> u64 {
        self.seed.unwrap_or(0)
    }
}

pub(super) fn run(study: &StudyCommand, console: &Console) -> CommandResult {
    match study {
        StudyCommand::Point(arguments) => {
            run_photon_study(arguments, console, "point", point::PHOTONS, point::workload, point::study)
        }
        StudyCommand::Transport(arguments) => {
            run_photon_study(arguments, console, "transport", lines::PHOTONS, lines::workload, lines::study)
        }
        StudyCommand::Profile(one) => {
            let loaded = one.recipe.load(console)?;
            let scene = loaded.recipe.draw(loaded.seed(one.arguments.common.seed), one.index);
            let chosen = one.profile.unwrap_or(scene.size.profiles / 2);
            if chosen >= scene.size.profiles {
                let last = scene.size.profiles - 1;
                return Err(format!("profile {chosen} is beyond the scan: give --profile 0 to {last}").into());
            }
            let study = |effort: Effort, progress: StudyProgress<'_>| profile::study(&scene, chosen, effort, progress);
            run_photon_study(&one.arguments, console, "profile", profile::PHOTONS, profile::workload, study)
        }
        StudyCommand::Triangulation(of) => run_instrument_study(of, console, "triangulation", triangulation::study),
        StudyCommand::Sensor(of) => run_instrument_study(of, console, "sensor", sensor::study),
        StudyCommand::Speckle(of) => run_instrument_study(of, console, "speckle", speckle::study),
        StudyCommand::Laser(of) => run_instrument_study(of, console, "laser", laser::study),
        StudyCommand::Packs(of) => {
            let recipe = super::load(&of.recipe, &of.changes.set, console)?.recipe;
            run_study(&of.common, console, "packs", packs::workload(), |progress| {
                packs::study(&recipe, of.common.seed(), progress)
            })
        }
    }
}

/// A study that walks photons.
fn run_photon_study(
    arguments: &PhotonArgs,
    console: &Console,
    name: &str,
    photons: u64,
    work: fn(Effort) -> u64,
    study: impl Fn(Effort, StudyProgress) -> StudyReport + Sync,
) -> CommandResult {
    let effort = Effort { photons: arguments.photons.unwrap_or(photons), seed: arguments.common.seed() };
    run_study(&arguments.common, console, name, work(effort), |progress| Ok(study(effort, progress)))
}

/// A study that is repeated.
fn run_instrument_study(
    of: &InstrumentArgs,
    console: &Console,
    name: &str,
    study: fn(Trials, StudyProgress) -> StudyReport,
) -> CommandResult {
    let trials = Trials { repeats: of.repeats.unwrap_or(REPEATS), seed: of.common.seed() };
    run_study(&of.common, console, name, trials.repeats, |progress| Ok(study(trials, progress)))
}

fn run_study(
    common: &StudyArgs,
    console: &Console,
    name: &str,
    work: u64,
    study: impl Fn(StudyProgress) -> Result<StudyReport, String> + Sync,
) -> CommandResult {
    let threads = super::generate::threads(common.threads)?;
    let out = &common.out;
    let (json, png) = if out.extension().is_some_and(|extension| extension == "png") {
        (out.with_extension("json"), out.clone())
    } else {
        (out.join(format!("{name}.json")), out.join(format!("{name}.png")))
    };
    output::check_replaceable(&json, output::Written::Json)?;
    output::check_replaceable(&png, output::Written::Png)?;
    let folder = png.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make {}: {error}; give another place with --out", folder.display()))?;
    output::check_writable(&json)?;
    let progress = Progress::new(console, "", Some(work));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let report = pool.install(|| {
        study(&|step| match step {
            StudyEvent::Asks(what) => progress.say(what),
            StudyEvent::Done(part) => progress.add(part),
        })
    })?;
    drop(progress);
    let printed = print(&report.table);
    output::write(&json, format!("{:#}\n", report.json).as_bytes())?;
    output::write(&png, &encoded(&report)?)?;
    let name = |path: &Path| path.display().to_string();
    console.note(&format!("{}, {}", name(&json), name(&png)));
    printed.map(|()| DONE)
}

fn encoded(report: &StudyReport) -> Result<Vec<u8>, image::ImageError> {
    let mut bytes = Vec::new();
    report.picture.write_with_encoder(PngEncoder::new_with_quality(
        &mut bytes,
        CompressionType::Best,
        FilterType::Adaptive,
    ))?;
    Ok(bytes)
}
