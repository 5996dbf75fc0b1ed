//! `gen fit`: a recipe from scans of a real camera.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;

use super::compare::part::mask;
use super::compare::scale::ScaleArgs;
use super::console::Console;
use super::generate::threads;
use super::progress::{Progress, counted};
use super::{CommandResult, DONE, RecipeArgs, UsageError, output, print, whole};
use dataset::Fault;
use fit::{Fit, FitOptions, FitProgress, RealScan, fit, fit_keys};
use recipe::{Recipe, as_sections, with_new_values};
use tools::compare::{ScanRegion, ScanSource};

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen fit --recipe plate.yaml --real scan.json     every key of bench and matter that has a distribution
  gen fit --recipe plate.yaml --real scan.xml --keys laser.waist_mm,exposure.time_us
  gen fit --recipe plate.yaml --set 'camera.f_number={log_uniform: [4, 16]}' --real scans/ --out mine.yaml
  gen fit --recipe plate.yaml --real part.png --um-per-count 2.5 --missing 0 --region 100,0,256,256

What the recipe's distributions hold is what is believed beforehand; what they don't hold is not found.
Written are the recipe with posterior distributions (mine.yaml), a page that shows what was found and what
stays out of reach (mine.html), and, while it runs, the simulated scans (mine.fit.jsonl): the same command
goes on where it was stopped. docs/guide/fit.md says how it works and when not to trust it.")]
pub(super) struct FitArgs {
    #[command(flatten)]
    recipe: RecipeArgs,
    /// Scans of the real camera: whatever gen compare reads
    #[arg(long, value_name = "SCAN", num_args = 1.., required = true)]
    real: Vec<PathBuf>,
    /// Keys to fit [default: every key of bench and matter that the recipe draws from a distribution]
    #[arg(long, value_name = "KEY,...", value_delimiter = ',')]
    keys: Vec<String>,
    /// Where the recipe goes; the page beside it [default: <recipe name>-fitted.yaml]
    #[arg(short, long, value_name = "FILE", value_parser = output::file("yaml"))]
    out: Option<PathBuf>,
    /// Begin no round of simulated scans that would not end within this time: 90s, 20m, 2h
    #[arg(long, value_name = "TIME", default_value = "20m", value_parser = duration)]
    time: Duration,
    /// Simulated scans, all rounds together
    #[arg(long, value_name = "N", default_value_t = 3000, value_parser =
        clap::value_parser!(u32).range(400..=1_000_000))]
    simulations: u32,
    /// Rounds in which they are made, each nearer to the real scans
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u32).range(2..=50))]
    rounds: u32,
    /// All scans are of one object: matter, too, is common to them
    #[arg(long)]
    one_object: bool,
    /// Class of the recipe that each scan is of, in their order: one matter and one bench, scanned in several ways
    #[arg(long, value_name = "CLASS,...", value_delimiter = ',', conflicts_with = "one_object")]
    classes: Vec<String>,
    /// Where what is found of matter goes alone, for other recipes: `extends: [wood, FILE]`
    #[arg(long, value_name = "FILE", value_parser = output::file("yaml"))]
    matter: Option<PathBuf>,
    /// Seed of all that is drawn
    #[arg(long, default_value_t = 0, value_parser = whole::<u64>)]
    seed: u64,
    /// Threads [default: all cores]
    #[arg(short = 'j', long, value_name = "T", value_parser = whole::<usize>)]
    threads: Option<usize>,
    /// Print what was found as JSON in place of a table
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    of_real: RealScanArgs,
}

/// How real scans are read.
#[derive(Debug, Args)]
pub(super) struct RealScanArgs {
    /// Most scans of each --real, spread evenly
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u64).range(1..=64))]
    scans: u64,
    /// The part of each real scan that counts [px]; of simulated scans the object alone then counts
    #[arg(long, value_name = "LEFT,TOP,COLUMNS,PROFILES", value_parser = ScanRegion::parse)]
    region: Option<ScanRegion>,
    /// Picture (PNG) of the real scans' size; where it is black, nothing counts; of simulated scans the object alone
    /// then does
    #[arg(long, value_name = "FILE")]
    mask: Option<PathBuf>,
    #[command(flatten)]
    scale: ScaleArgs,
}

pub(super) fn run(arguments: &FitArgs, console: &Console) -> CommandResult {
    let recipe = arguments.recipe.load(console)?.recipe;
    let keys = fit_keys(&recipe, &arguments.keys, &arguments.classes);
    let keys = keys.map_err(|faults| UsageError(format!("--keys: {}", faults.join("\n"))))?;
    let out = arguments.out.clone().unwrap_or_else(|| PathBuf::from(format!("{}-fitted.yaml", recipe.name())));
    let page = out.with_extension("html");
    for written in arguments.matter.iter().chain([&out]) {
        check_replaceable(written)?;
        output::check_writable(written)?;
    }
    output::check_replaceable(&page, output::Written::Html)?;
    let real = arguments.of_real.read(&arguments.real, false, console)?;
    let store = out.with_extension("fit.jsonl");
    let options = FitOptions {
        seed: arguments.seed,
        simulations: arguments.simulations as usize,
        rounds: arguments.rounds as usize,
        time: arguments.time,
        one_object: arguments.one_object,
        classes: arguments.classes.clone(),
        store: store.clone(),
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads(arguments.threads)?).build()?;
    let found = {
        let progress = FitWatch::new(console);
        pool.install(|| fit(&recipe, &keys, &real, &options, &|event| progress.show(event)))?
    };
    let parse = |text: &str| Recipe::parse_with(&out.display().to_string(), text, &recipe.kept_files());
    let mut text = fitted_text(&recipe, &found);
    let together = correlations(&found.correlations);
    let goes_together = together.is_empty() || parse(&(text.clone() + &together)).is_ok();
    if goes_together {
        text += &together;
    } else {
        console.note("note: the recipe cannot hold how keys go together; --json has it");
    }
    if let Err(faults) = parse(&text) {
        let what = format!("the fitted recipe does not read back: {faults}");
        return Err(Fault::at(&out, what, "write the values that --json gives into the recipe by hand").into());
    }
    output::write(&out, text.as_bytes())?;
    output::write(&page, found.page(recipe.text(), &text).as_bytes())?;
    if let Some(matter) = &arguments.matter {
        output::write(matter, matter_text(&found, goes_together).as_bytes())?;
    }
    // What is found is written: the scans have done their work.
    fs::remove_file(&store).map_err(|e| Fault::at(&store, format!("it cannot be removed: {e}"), "remove it"))?;
    let name = arguments.recipe.name.get()?;
    if recipe.files().next().is_some() && out.parent() != Path::new(name).parent() {
        console.note(&format!("note: {} names files that lie beside {name}; keep both in one folder", out.display()));
    }
    if found.rounds[0] < found.rounds[1] {
        console.note(&format!(
            "note: --time ended the fit after {} of {}; --rounds {} gives the same recipe again",
            counted(found.rounds[0] as u64, "round"),
            found.rounds[1],
            found.rounds[0]
        ));
    }
    let also = arguments.matter.as_ref().map_or_else(String::new, |matter| format!(", {}", matter.display()));
    let wrote = format!("{} and {}{also}", out.display(), page.display());
    print(&if arguments.json { format!("{:#}\n", found.json()) } else { table(&found, &wrote) })?;
    Ok(DONE)
}

/// Bytes in which the first two lines of a fitted recipe end.
const MAX_HEAD_BYTES: u64 = 1 << 16;

/// What a fitted recipe begins with, in its first line or behind that of an editor.
const HEAD: &str = "# Fitted by gen ";

/// Refuses to write over what is no fitted recipe: the recipe that is fitted for one.
fn check_replaceable(out: &Path) -> Result<(), UsageError> {
    let refuse = |what: &str| Err(UsageError(format!("{}: {what}; give another --out, or remove it", out.display())));
    match files::read_start(out, MAX_HEAD_BYTES) {
        Ok(start) if String::from_utf8_lossy(&start).lines().take(2).any(|line| line.starts_with(HEAD)) => Ok(()),
        Ok(_) => refuse("it is there, and no recipe that gen fit wrote"),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => refuse(&error.to_string()),
    }
}

impl RealScanArgs {
    /// Whether a part of real scans is asked for.
    pub(super) fn is_given(&self) -> bool {
        self.region.is_some() || self.mask.is_some()
    }

    /// The scans at these paths; with the class of each pixel where that is wanted and labels tell it.
    pub(super) fn read(
        &self,
        paths: &[PathBuf],
        with_classes: bool,
        console: &Console,
    ) -> CommandResult<Vec<RealScan>> {
        let stated = self.scale.stated();
        let open = |path: &PathBuf| ScanSource::open(path, self.scans, &stated);
        let mut sources = paths.iter().map(open).collect::<Result<Vec<_>, Fault>>()?;
        self.scale.apply(&stated, &mut sources, console)?;
        let mask = self.mask.as_deref().map(mask).transpose()?;
        let mut real = Vec::new();
        for (source, path) in sources.iter().zip(paths) {
            for i in 0..source.len() {
                let mut maps = if with_classes { source.labelled(i)? } else { source.frame(i)? };
                // Samples are numbered in their own dataset.
                if maps.name.starts_with("sample ") {
                    maps.name = format!("{} {}", source.name(), maps.name);
                }
                let scan = RealScan::new(maps, self.region, mask.as_ref());
                real.push(scan.map_err(|fault| fault.of_part(path.display()))?);
            }
        }
        Ok(real)
    }
}

/// The line that says what a fit was.
fn head(found: &Fit) -> String {
    let names: Vec<&str> = found.scans.iter().map(|scan| scan.name.as_str()).collect();
    format!(
        "{HEAD}{} to {}: seed {}, {} scans in {} rounds.\n",
        env!("CARGO_PKG_VERSION"),
        dataset::one_line(names.join(", ")),
        found.seed,
        found.simulations,
        found.rounds[0]
    )
}

/// What was found of matter alone, as sections that a recipe extends.
fn matter_text(found: &Fit, goes_together: bool) -> String {
    let matter = found.of_matter();
    let mut text = head(found);
    text += "# Matter alone: a recipe takes it by `extends`, and keeps what is not here.\n";
    matter.untold.iter().for_each(|key| text += &format!("# {key}: not told by these scans\n"));
    text += &as_sections(&matter.values);
    text + &if goes_together { correlations(&matter.correlations) } else { String::new() }
}

/// The recipe's text with what was found, under a line that says so.
fn fitted_text(recipe: &Recipe, found: &Fit) -> String {
    let text = with_new_values(recipe.text(), &found.new_values());
    let head = head(found);
    // An editor looks for the schema in the first line.
    match text.split_once('\n') {
        Some((first, rest)) if first.starts_with("# yaml-language-server") => format!("{first}\n{head}{rest}"),
        _ => head + &text,
    }
}

/// How keys go together, as a section of a recipe; nothing where none do.
fn correlations(pairs: &[([String; 2], f64)]) -> String {
    if pairs.is_empty() {
        return String::new();
    }
    let mut text = String::from(
        "\n# What the scans tell of keys together: each alone may lie anywhere in its distribution.\ncorrelations:\n",
    );
    for ([a, b], spearman) in pairs {
        text.push_str(&format!("  - {{keys: [{a}, {b}], spearman: {spearman}}}\n"));
    }
    text
}

/// What was found, for people.
fn table(found: &Fit, wrote: &str) -> String {
    let mut lines = vec![format!("{:<34} {:>12}  {:>26}  {:>26}", "key", "", "before, 90 %", "after, 90 %")];
    let ends = |three: [f64; 3]| format!("{} to {}", number(three[0]), number(three[2]));
    for key in &found.keys {
        let after = if key.is_written() { ends(key.after) } else { "as before".into() };
        lines.push(format!("{:<34} {:>12}  {:>26}  {after:>26}", key.path, key.state.name(), ends(key.before)));
    }
    for ([a, b], r) in &found.pairs {
        lines.push(format!("{a} and {b} cannot be told apart (correlation {r:.2})"));
    }
    for scan in &found.scans {
        let missed: Vec<_> = scan.statistics.iter().filter(|statistic| statistic.is_out_of_reach()).collect();
        let told = scan.statistics.iter().filter(|statistic| statistic.real.is_some()).count();
        lines.push(format!("\n{}: {} of {told} statistics out of reach", scan.name, missed.len()));
        for statistic in missed {
            let real = statistic.real.map_or("-".into(), number);
            let made = statistic.after.map_or("-".into(), ends);
            lines.push(format!("  {:<62} real {real}, simulated {made} {}", statistic.name, unit(statistic.unit)));
        }
    }
    lines.push(format!("\n{wrote}"));
    lines.join("\n") + "\n"
}

pub(super) fn unit(unit: &str) -> &str {
    if unit == "1" { "" } else { unit }
}

/// A number with three digits.
pub(super) fn number(x: f64) -> String {
    let digits =
        if x == 0.0 || !x.is_finite() { 0 } else { (2 - libm::floor(libm::log10(x.abs())) as i32).clamp(0, 9) };
    format!("{x:.*}", digits as usize)
}

fn duration(text: &str) -> Result<Duration, String> {
    let expected = || "give a time such as 90s, 20m or 2h".to_owned();
    let (number, factor) = match text.char_indices().last() {
        Some((i, 's')) => (&text[..i], 1.0),
        Some((i, 'm')) => (&text[..i], 60.0),
        Some((i, 'h')) => (&text[..i], 3600.0),
        _ => return Err(expected()),
    };
    let number: f64 = number.parse().map_err(|_| expected())?;
    let seconds = number * factor;
    if (1.0..=1e7).contains(&seconds) { Ok(Duration::from_secs_f64(seconds)) } else { Err(expected()) }
}

/// Shows how a fit goes on.
struct FitWatch<'c> {
    progress: Progress<'c>,
    console: &'c Console,
}

impl<'c> FitWatch<'c> {
    fn new(console: &'c Console) -> Self {
        Self { progress: Progress::new(console, "scans", None), console }
    }

    fn show(&self, event: FitProgress) {
        match event {
            FitProgress::Begin { simulations, kept } => {
                self.progress.set_total(simulations as u64);
                if kept > 0 {
                    self.console.note(&format!(
                        "{} are there already, of a run that was stopped",
                        counted(kept as u64, "scan")
                    ));
                }
            }
            FitProgress::Round { round, rounds, distance } => {
                let near = distance.map_or_else(String::new, |d| format!(", nearest scan {d:.2} deviations away"));
                let words = format!("round {round} of {rounds}{near}");
                self.console.detail(&words);
                self.progress.say(&words);
            }
            FitProgress::Scans(n) => self.progress.add(n as u64),
            FitProgress::Predicts => self.progress.say("what the fitted recipe makes"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times with their units; nothing else.
    #[test]
    fn times_are_read() {
        assert_eq!(duration("90s"), Ok(Duration::from_secs(90)));
        assert_eq!(duration("1.5m"), Ok(Duration::from_secs(90)));
        assert_eq!(duration("2h"), Ok(Duration::from_secs(7200)));
        for wrong in ["", "20", "m", "-1m", "1e99h", "nans", "20 min"] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
    }
}
