//! `gen report`: a dataset as one page for people.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use output_schema::file::{DATASET, REPORTS};

use super::console::{Console, say};
use super::generate::threads;
use super::output::{ELSEWHERE, ResultFolder};
use super::progress::{Progress, counted, describe_bytes};
use super::{CommandResult, DONE, FAULTS, UsageError, output, whole};
use crate::generate::{recipe_of, render_sample};
use crate::preview::expose_profile;
use dataset::Dataset;
use optical_bench::settings::Transport;
use scanner::optics::speckle::PatternCache;
use tools::report::{ExposedProfile, RenderTiming, ReportOptions, report};

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen report planks                                writes planks/reports/report.html; open it in any browser
  gen report planks --samples 60 --out page.html   more samples, smaller pictures, another place
  gen report planks --no-timing                    the same bytes each time

Results that `gen validate --save` and `gen check --save` keep beside the dataset are shown too.
A filter can be part of the address: report.html#class=rot&split=test

Exit status: 0 done, 1 the dataset is damaged or cannot be opened (the page says where and why), or the
page cannot be written, 2 unusable arguments. An unfinished dataset is not damaged: status 0, and its page
says what is missing.")]
pub(super) struct ReportArgs {
    /// Folder of the dataset
    dir: PathBuf,
    /// Where the page goes [default: DIR/reports/report.html]
    #[arg(short, long, value_name = "FILE", value_parser = output::file("html"))]
    out: Option<PathBuf>,
    /// Samples in the contact sheet at most
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u64).range(1..=500))]
    samples: u64,
    /// Sensor frames that are exposed again at most
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u64).range(0..=100))]
    frames: u64,
    /// Measure no time: the same folder then gives the same bytes
    #[arg(long)]
    no_timing: bool,
    /// Threads [default: all cores]
    #[arg(short = 'j', long, value_name = "T", value_parser = whole::<usize>)]
    threads: Option<usize>,
}

pub(super) fn run(arguments: &ReportArgs, console: &Console) -> CommandResult {
    let root = &arguments.dir;
    if !root.is_dir() {
        return Err(
            UsageError(format!("{}: there is no such folder; name the folder of a dataset", root.display())).into()
        );
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads(arguments.threads)?).build()?;
    let out = match &arguments.out {
        Some(out) => out.clone(),
        None if root.join(DATASET).exists() => {
            ResultFolder::Kept(root).make(ELSEWHERE)?;
            root.join(REPORTS).join("report.html")
        }
        None => {
            let what = format!("{}: it holds no {DATASET}; name the folder of a dataset", root.display());
            return Err(UsageError(what).into());
        }
    };
    if let Some(what) = misplaced(root, &out) {
        return Err(UsageError(format!("--out {}: {what}", out.display())).into());
    }
    output::check_replaceable(&out, output::Written::Html)?;
    let kept = out.file_name().and_then(|name| name.to_str()).filter(|_| out.parent() == Some(&root.join(REPORTS)));
    match kept {
        Some(_) => ResultFolder::Kept(root).check_writable(ELSEWHERE)?,
        None => output::check_writable(&out)?,
    }
    let folder = Dataset::open(root);
    let seed = folder.as_ref().map_or(0, |folder| folder.head().seed);
    let recipe = folder.as_ref().map_err(ToString::to_string).and_then(recipe_of);
    let patterns = PatternCache::new(recipe.as_ref().map_or(seed, |recipe| recipe.streams(seed).key()));
    // A slow model takes minutes for a line.
    let fast = recipe.as_ref().ok().filter(|recipe| recipe.transport() == Transport::Kernel);
    let expose = fast.map(|recipe| {
        let patterns = &patterns;
        move |index: u64, along: f64| {
            let profiles = recipe.size().profiles;
            expose_profile(&recipe.draw(seed, index), (along * profiles as f64) as usize, patterns)
        }
    });
    let measure = fast.filter(|_| !arguments.no_timing).map(|recipe| {
        let patterns = &patterns;
        move |index: u64| {
            let start = Instant::now();
            render_sample(recipe, seed, index, patterns, &|_| ());
            RenderTiming { index, seconds: start.elapsed().as_secs_f64(), threads: rayon::current_num_threads() }
        }
    });
    let progress = Progress::new(console, "steps", None);
    let options = ReportOptions {
        recipe: recipe.as_ref().map_err(Clone::clone),
        samples: arguments.samples,
        frames: arguments.frames as usize,
        expose: expose.as_ref().map(|expose| expose as &(dyn Fn(u64, f64) -> ExposedProfile + Sync)),
        measure: measure.as_ref().map(|measure| measure as &(dyn Fn(u64) -> RenderTiming + Sync)),
        watch: &|done, all| progress.set(done, all),
    };
    let page = pool.install(|| report(root, &options));
    drop(progress);
    match kept {
        Some(name) => ResultFolder::Kept(root).write(name, page.html.as_bytes(), ELSEWHERE)?,
        None => output::write(&out, page.html.as_bytes())?,
    }
    let size = describe_bytes(page.html.len() as u64);
    console.note(&format!("{}: {size}, {} shown", out.display(), counted(page.shown, "sample")));
    if page.troubles > 0 {
        let state = if page.damage > 0 { "damaged" } else { "unfinished" };
        let listed = counted(page.troubles, "fault");
        say(&format!("gen: {} is {state}; the page shows what can be read, and lists {listed}", root.display()));
    }
    Ok(if page.damage > 0 { FAULTS } else { DONE })
}

/// Why a page must not be written to `out`, which lies among the dataset's files or is a kept result.
fn misplaced(root: &Path, out: &Path) -> Option<&'static str> {
    // The page takes the place of a link, not of what that leads to.
    let folder = output::resolve(&out.parent()?.join("."))?;
    let root = root.canonicalize().ok()?;
    if !folder.starts_with(&root) {
        return None;
    }
    if !folder.starts_with(root.join(REPORTS)) {
        return Some("it lies in the dataset, where nothing else may lie but under reports/; choose another place");
    }
    let page = out.extension().is_some_and(|extension| extension == "html");
    (!page).then_some("reports/ keeps results of other commands; choose a name that ends in .html, or another place")
}
