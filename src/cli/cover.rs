//! `gen cover`: whether a recipe's spread holds real scans.

use std::path::PathBuf;

use clap::Args;

use super::console::Console;
use super::fit::{RealScanArgs, number};
use super::generate::threads;
use super::progress::Progress;
use super::{CommandResult, DONE, RecipeArgs, UsageError, output, print, whole};
use fit::{Cover, CoverOptions, CoverProgress, CoveredScan, cover};

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen cover mine.yaml --real scans                 where they lie in its spread, and which keys to widen
  gen cover planks --real a.exr b.exr --json       the recipe and the seed of a dataset
  gen cover plate.yaml --real scan.json --region 100,0,256,256
  gen cover blister                                what hardly varies, and which keys do nothing

A scan that the recipe could have made is called outside once in a hundred. What is outside is no fault of the
scan: it is to be looked at. docs/guide/cover.md says how it works.")]
pub(super) struct CoverArgs {
    #[command(flatten)]
    recipe: RecipeArgs,
    /// Scans of the real camera: whatever gen compare reads
    #[arg(long, value_name = "SCAN", num_args = 1..)]
    real: Vec<PathBuf>,
    /// Where the page goes [default: <recipe name>-cover.html]
    #[arg(short, long, value_name = "FILE", value_parser = output::file("html"))]
    out: Option<PathBuf>,
    /// Scans of the recipe as it is; of a dataset its first ones, drawn again
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = clap::value_parser!(u32).range(200..=100_000))]
    simulations: u32,
    /// Seed of all that is drawn [default: that of the dataset, else 0]
    #[arg(long, value_parser = whole::<u64>)]
    seed: Option<u64>,
    /// Threads [default: all cores]
    #[arg(short = 'j', long, value_name = "T", value_parser = whole::<usize>)]
    threads: Option<usize>,
    /// Print what was found as JSON in place of a table
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    of_real: RealScanArgs,
}

pub(super) fn run(arguments: &CoverArgs, console: &Console) -> CommandResult {
    let loaded = arguments.recipe.load(console)?;
    let page = arguments.out.clone().unwrap_or_else(|| PathBuf::from(format!("{}-cover.html", loaded.recipe.name())));
    output::check_replaceable(&page, output::Written::Html)?;
    if arguments.real.is_empty() && arguments.of_real.is_given() {
        let what = "--region, --mask: no effect without --real; name real scans, or leave them away";
        return Err(UsageError(what.into()).into());
    }
    let real = arguments.of_real.read(&arguments.real, true, console)?;
    let options = CoverOptions { seed: loaded.seed(arguments.seed), simulations: arguments.simulations as usize };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads(arguments.threads)?).build()?;
    let found = {
        let progress = Progress::new(console, "scans", None);
        let total = std::sync::atomic::AtomicU64::new(0);
        let show = |event| match event {
            CoverProgress::More(scans, words) => {
                let before = total.fetch_add(scans as u64, std::sync::atomic::Ordering::Relaxed);
                progress.set_total(before + scans as u64);
                progress.say(words);
            }
            CoverProgress::Scan => progress.add(1),
        };
        pool.install(|| cover(&loaded.recipe, &real, options, &show))?
    };
    output::write(&page, found.page().as_bytes())?;
    print(&if arguments.json { format!("{:#}\n", found.json()) } else { table(&found, &page.display().to_string()) })?;
    Ok(DONE)
}

/// What was found, for people.
fn table(found: &Cover, page: &str) -> String {
    let mut lines = vec![found.verdict()];
    for scan in &found.scans {
        lines.extend(of_scan(scan));
    }
    if !found.widen.is_empty() {
        lines.push(format!("\nof {} keys these explain most of it:", found.asked));
    }
    for key in &found.widen {
        let alike = if key.alike.is_empty() { String::new() } else { format!("; as {} does", key.alike.join(", ")) };
        let then = if key.covers { ", and the scans are covered" } else { "" };
        lines.push(format!("  {}: {:.0} % is left{then}{alike}", key.words(), 100.0 * key.left));
    }
    if !found.keys.is_empty() {
        lines.push(format!("\n{:<36} {:>10}  {}", "key", "deviations", "of what it moves most"));
    }
    for key in &found.keys {
        let what = if key.is_idle { "does nothing" } else { key.statistic.as_str() };
        lines.push(format!("{:<36} {:>10.2}  {what}", key.path, key.by));
    }
    if !found.still.is_empty() {
        lines.push("\nhardly vary:".into());
    }
    for still in &found.still {
        let [low, _, high] = still.three.map(number);
        lines.push(format!("  {:<62} {low} to {high} {}", still.name, super::fit::unit(still.unit)));
    }
    lines.push(format!("\n{page}"));
    lines.join("\n") + "\n"
}

fn of_scan(scan: &CoveredScan) -> Vec<String> {
    let [inside, edge, outside] = scan.counts();
    let word = if scan.is_outside() { "look at this: " } else { "" };
    let mut lines = vec![format!(
        "\n{}: {word}{inside} inside, {edge} at the edge, {outside} outside; distance {}, limit {}",
        scan.name,
        number(scan.depth),
        number(scan.limit)
    )];
    for statistic in scan.outside() {
        let real = statistic.real.map_or("-".into(), number);
        let made =
            statistic.simulated.map_or("-".into(), |[low, _, high]| format!("{} to {}", number(low), number(high)));
        let unit = super::fit::unit(statistic.unit);
        lines.push(format!("  {:<62} real {real}, simulated {made} {unit}", statistic.name));
    }
    lines
}
