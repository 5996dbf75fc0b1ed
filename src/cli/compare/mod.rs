//! `gen compare`: a simulated and a real scan side by side.

mod scale;

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use clap::Args;

use super::console::Console;
use super::list::shared_draws;
use super::progress::Progress;
use super::{CommandResult, DONE, UsageError, output, print};
use dataset::{Dataset, Fault};
use scale::ScaleArgs;
use tools::compare::{Comparison, ScanSource, ScanStatistics, StatisticsBuilder};

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen compare planks real.json                     a dataset against a frame of the camera
  gen compare planks scans/ --scans 20             against a folder of frames, 20 of each side
  gen compare a.exr b.xml --out page.png           two scans, with a page of plots
  gen compare planks real.json --json > both.json  for programs
  gen compare planks part.png --um-per-count 2.5 --missing 0 --reflectance light.png --bits 10
                                                   heights as counts of a picture, with reflectance
  gen compare planks cloud.ply --mm-per-count 1    points of a scan

Either side is a dataset, a folder of scans, or one scan: .exr of a dataset, .xml with .dat of
the real camera, .json as programs on the camera store it; or files of bare numbers, whose
scale you state: grey .png and .tif, .csv of a grid or of points, .ply. Of these a file holds
one map, and NAME.range.png finds NAME.reflectance.png and NAME.scatter.png. docs/compare.md
explains every file and every number.")]
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
    let [sim, real] = sides;
    let is_stated = [&sim, &real].map(|side| !side.stated_forms().is_empty());
    let [sim, real] = {
        let progress = Progress::new(console, "scans", Some((sim.len() + real.len()) as u64));
        [statistics(&sim, &arguments.sim, &progress)?, statistics(&real, &arguments.real, &progress)?]
    };
    let is_dark = |side: &ScanStatistics| side.least_reflectance.is_none() && side.scatter.is_none();
    if stated.bits.is_some() && [&sim, &real].into_iter().zip(is_stated).all(|(side, stated)| !stated || is_dark(side))
    {
        let what = "--bits: no effect, for there is neither Reflectance nor Scatter; leave it away";
        return Err(UsageError(what.into()).into());
    }
    if let (Some(ours), Some(theirs)) = (sim.unit, real.unit)
        && ours.thousandth() != theirs.thousandth()
    {
        let what = "one side has heights, the other sensor rows";
        let remedy = "compare calibrated with calibrated or uncalibrated with uncalibrated scans (`extraction: {range: ..}` in \
                      the recipe)";
        return Err(Fault::at(&arguments.real, what, remedy).into());
    }
    let comparison = Comparison { sim, real };
    print(&if arguments.json { format!("{:#}\n", comparison.json()) } else { comparison.table() })?;
    if let Some(out) = &arguments.out {
        let page = comparison.page();
        output::write(out, &output::png(&page)?)?;
        if std::io::stderr().is_terminal() {
            console.note(&format!("{}: {} x {} px", out.display(), page.width(), page.height()));
        }
    }
    Ok(DONE)
}

fn statistics(source: &ScanSource, path: &Path, progress: &Progress) -> Result<ScanStatistics, Fault> {
    let mut builder = StatisticsBuilder::new(source.name());
    let mut unit = None;
    for i in 0..source.len() {
        let frame = source.frame(i)?;
        let this = frame.unit.thousandth();
        if !frame.range.is_empty() && unit.replace(this).is_some_and(|before| before != this) {
            let what = "it has sensor rows where other scans have heights, or the other way round";
            return Err(Fault::new(frame.name, what, "compare scans of one kind"));
        }
        builder.add(&frame);
        progress.add(1);
    }
    let found = builder.statistics();
    if found.missing == Some(1.0) {
        let what = "no height was measured in any scan";
        return Err(Fault::at(path, what, "give scans in which the laser line is seen"));
    }
    Ok(found)
}
