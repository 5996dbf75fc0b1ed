//! `gen compare`: a simulated and a real scan side by side.

pub(super) mod part;
pub(super) mod scale;

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use clap::Args;

use super::console::Console;
use super::list::shared_draws;
use super::progress::Progress;
use super::{CommandResult, DONE, UsageError, output, print};
use dataset::{Dataset, Fault};
use evidence::gap::{Gap, GapJob, GapSide, GapStop};
use part::{CountedScan, PartArgs, SidePart};
use scale::ScaleArgs;
use tools::compare::{Comparison, ScanSource, ScanStatistics, StatisticsBuilder};

/// Names the Python of `--gap`.
const PYTHON_VARIABLE: &str = "SHEETLIGHT_PYTHON";
/// The Python of `--gap` where none is named.
const DEFAULT_PYTHON: &str = if cfg!(windows) { "python" } else { "python3" };

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen compare planks real.json                     a dataset against a frame of the camera
  gen compare planks scans/ --scans 20             against a folder of frames, 20 of each side
  gen compare a.exr b.xml --out page.png           two scans, with a page of plots
  gen compare planks real.json --json > both.json  for programs
  gen compare planks part.png --um-per-count 2.5 --missing 0 --reflectance light.png --bits 10
                                                   heights as counts of a picture, with reflectance
  gen compare planks scans/ --gap --python .venv/bin/python
                                                   how well a classifier tells them apart
  gen compare planks cloud.ply --mm-per-count 1    points of a scan
  gen compare planks real.json --region 100,0,256,256
                                                   a part of the real scan, which the object fills

Either side is a dataset, a folder of scans, or one scan: .exr of a dataset, .xml with .dat of
the real camera, .json as programs on the camera store it; or files of bare numbers, whose
scale you state: grey .png and .tif, .csv of a grid or of points, .ply. Of these a file holds
one map, and NAME.range.png finds NAME.reflectance.png and NAME.scatter.png. Of a dataset the
object alone counts, which its labels tell (--whole counts all); of other scans all, or a part
that you give. docs/guide/compare.md explains every file and every number.")]
pub(super) struct CompareArgs {
    /// Simulated side: a dataset, a folder of scans, or a scan
    sim: PathBuf,
    /// Real side, in the same way
    real: PathBuf,
    /// Most scans of each side, spread evenly
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u64).range(1..))]
    scans: u64,
    /// Where a page of plots goes (PNG) [default: none is drawn]
    #[arg(short, long, value_name = "FILE", value_parser = output::file("png"))]
    out: Option<PathBuf>,
    /// Print JSON instead of the table
    #[arg(long)]
    json: bool,
    /// Train a classifier to tell both sides apart, and print its accuracy on windows that it has not seen: 0.5 where
    /// it cannot. Takes a minute or two, and Python with numpy and torch
    #[arg(long)]
    gap: bool,
    /// Python for --gap [default: $SHEETLIGHT_PYTHON, else python3]
    #[arg(long, value_name = "PROGRAM", requires = "gap")]
    python: Option<PathBuf>,
    #[command(flatten)]
    part: PartArgs,
    #[command(flatten)]
    scale: ScaleArgs,
}

pub(super) fn run(arguments: &CompareArgs, console: &Console) -> CommandResult {
    if let Some(out) = &arguments.out {
        output::check_replaceable(out, output::Written::Png)?;
        output::check_writable(out)?;
    }
    if let [Ok(sim), Ok(real)] = [&arguments.sim, &arguments.real].map(|path| Dataset::open(path))
        && sim.root() != real.root()
        && let Some(what) = shared_draws(&sim, &real)
    {
        console.note(&format!("note: {what}"));
    }
    let stated = arguments.scale.stated();
    let open = |path: &Path| ScanSource::open(path, arguments.scans, &stated);
    let mut sides = [open(&arguments.sim)?, open(&arguments.real)?];
    arguments.scale.apply(&stated, &mut sides, console)?;
    let [sim_part, real_part] = arguments.part.sides(&sides)?;
    let [sim, real] = sides;
    let is_stated = [&sim, &real].map(|side| !side.stated_forms().is_empty());
    let mut windows = [&sim, &real].map(|side| arguments.gap.then(|| GapSide::new(side.len())));
    let [sim, real] = {
        let progress = Progress::new(console, "scans", Some((sim.len() + real.len()) as u64));
        let [ours, theirs] = windows.each_mut().map(Option::as_mut);
        let sim = statistics(&sim, &sim_part, &arguments.sim, ours, &progress)?;
        [sim, statistics(&real, &real_part, &arguments.real, theirs, &progress)?]
    };
    let is_dark = |side: &ScanStatistics| side.least_reflectance.is_none() && side.scatter_sample.numbers().is_empty();
    if stated.bits.is_some() && [&sim, &real].into_iter().zip(is_stated).all(|(side, stated)| !stated || is_dark(side))
    {
        let what = "--bits: no effect, for there is neither Reflectance nor Scatter; leave it away";
        return Err(UsageError(what.into()).into());
    }
    if let (Some(ours), Some(theirs)) = (sim.unit, real.unit)
        && ours.thousandth() != theirs.thousandth()
    {
        let what = "one side has heights, the other sensor rows";
        let remedy = "compare calibrated with calibrated or uncalibrated with uncalibrated scans (`extraction: \
            {range: ..}` in \
                      the recipe)";
        return Err(Fault::at(&arguments.real, what, remedy).into());
    }
    let gap = match &windows {
        [Some(sim), Some(real)] => Some(gap(arguments, sim, real, console)?),
        _ => None,
    };
    let comparison = Comparison { sim, real };
    print(&if arguments.json {
        let mut document = comparison.json();
        if let Some(gap) = &gap {
            document["gap"] = gap.json();
        }
        format!("{document:#}\n")
    } else {
        let gap = gap.map_or_else(String::new, |gap| format!("\n{}", gap.table()));
        comparison.table() + &gap
    })?;
    if let Some(out) = &arguments.out {
        let page = comparison.page();
        output::write(out, &output::png(&page)?)?;
        if std::io::stderr().is_terminal() {
            console.note(&format!("{}: {} x {} px", out.display(), page.width(), page.height()));
        }
    }
    Ok(DONE)
}

/// Trains and judges the classifier, and says what is good to know about it.
fn gap(arguments: &CompareArgs, sim: &GapSide, real: &GapSide, console: &Console) -> Result<Gap, Fault> {
    let named = std::env::var_os(PYTHON_VARIABLE).filter(|name| !name.is_empty()).map(PathBuf::from);
    let python = arguments.python.clone().or(named).unwrap_or_else(|| DEFAULT_PYTHON.into());
    let job = GapJob::new(sim, real, [&arguments.sim, &arguments.real])?;
    let stop = GapStop::default();
    console.on_stop({
        let stop = stop.clone();
        move || {
            stop.now();
            "nothing is written".into()
        }
    });
    let found = {
        let progress = Progress::new(console, "networks", Some(job.folds()));
        job.run(&python, &stop, &|folds| progress.add(folds))?
    };
    found.notes.iter().for_each(|note| console.note(&format!("note: {note}")));
    Ok(found)
}

fn statistics(
    source: &ScanSource,
    part: &SidePart,
    path: &Path,
    mut windows: Option<&mut GapSide>,
    progress: &Progress,
) -> Result<ScanStatistics, Fault> {
    let mut builder = StatisticsBuilder::new(source.name());
    let (mut unit, mut is_object) = (None, false);
    for i in 0..source.len() {
        let CountedScan { maps: frame, ignored, is_object: told } = part.scan(source, i)?;
        let this = frame.unit.thousandth();
        if !frame.range.is_empty() && unit.replace(this).is_some_and(|before| before != this) {
            let what = "it has sensor rows where other scans have heights, or the other way round";
            return Err(Fault::new(frame.name, what, "compare scans of one kind"));
        }
        match &ignored {
            Some(ignored) => builder.add_part(&frame, ignored),
            None => builder.add(&frame),
        }
        if let Some(windows) = &mut windows {
            windows.add(&frame, ignored.as_deref());
        }
        is_object = told;
        progress.add(1);
    }
    let found = builder.of_part(&part.words(is_object)).statistics();
    if found.frames > 0 && found.missing.is_none_or(|share| share == 1.0) {
        let what = "no height was measured in any scan, or in the part of it that counts";
        return Err(Fault::at(path, what, "give scans in which the laser line is seen, and a part on the object"));
    }
    Ok(found)
}
