//! Progress on long work: a bar for people, plain lines where the output is not a terminal.

use std::io::{IsTerminal, Write};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::generate::{DatasetRequest, GenerateEvent};
use dataset::validate::ValidationStep;
use recipe::Recipe;

/// Least time between two plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(30);

/// Shows the events of a run.
pub(super) struct GenerateBar {
    bar: Option<ProgressBar>,
    profiles_per_sample: u64,
    total: AtomicU64,
    samples: AtomicU64,
    bytes: AtomicU64,
    started: Instant,
    line: Mutex<Instant>,
    hint: String,
}

impl GenerateBar {
    /// For a run; nothing is shown before its first event.
    pub(super) fn new(name: &str, recipe: &Recipe, request: &DatasetRequest) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = style("{bar:24} {percent:>3} %  {msg}  {per_sec}, {eta} left");
            let style = style.with_key("per_sec", |state: &indicatif::ProgressState, out: &mut dyn std::fmt::Write| {
                let _ = write!(out, "{:.0} profiles/s", state.per_sec());
            });
            ProgressBar::no_length().with_style(style)
        });
        Self {
            bar,
            profiles_per_sample: recipe.size().profiles as u64,
            total: AtomicU64::new(0),
            samples: AtomicU64::new(0),
            bytes: AtomicU64::new(0),
            started: Instant::now(),
            line: Mutex::new(Instant::now()),
            hint: format!("gen preview --recipe {name} --seed {}", request.seed),
        }
    }

    /// Takes one event.
    pub(super) fn show(&self, event: GenerateEvent) {
        match event {
            GenerateEvent::Begin { samples, finished } => self.begin(samples, finished),
            GenerateEvent::Profiles(n) => {
                if let Some(bar) = &self.bar {
                    bar.inc(n);
                }
            }
            GenerateEvent::Sample(size) => {
                let samples = self.samples.fetch_add(1, Ordering::Relaxed) + 1;
                let written = self.bytes.fetch_add(size, Ordering::Relaxed) + size;
                match &self.bar {
                    Some(bar) => bar.set_message(format!(
                        "{samples}/{} samples, {}",
                        self.total.load(Ordering::Relaxed),
                        describe_bytes(written)
                    )),
                    None => self.line(samples, written),
                }
            }
            GenerateEvent::Shard(_) => {}
            GenerateEvent::Busy(shard) => self.say(&format!("shard {shard} is being made by another process")),
        }
    }

    /// Removes the bar.
    pub(super) fn end(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    fn begin(&self, samples: u64, finished: u64) {
        self.total.store(samples, Ordering::Relaxed);
        if finished > 0 {
            self.say(&format!("{finished} samples are there already; {samples} to make"));
        } else if let Some(bar) = &self.bar
            && samples > 20
        {
            bar.println(format!("{samples} samples to make; to look at one first: {}", self.hint));
        }
        if let Some(bar) = &self.bar {
            bar.set_length(samples * self.profiles_per_sample);
        }
    }

    fn line(&self, samples: u64, written: u64) {
        let Ok(mut last) = self.line.lock() else { return };
        if last.elapsed() < LINE_INTERVAL {
            return;
        }
        *last = Instant::now();
        let total = self.total.load(Ordering::Relaxed);
        let elapsed = self.started.elapsed();
        let left = elapsed.mul_f64((total.saturating_sub(samples)) as f64 / samples.max(1) as f64);
        let rate = (samples * self.profiles_per_sample) as f64 / elapsed.as_secs_f64();
        say(&format!(
            "{samples}/{total} samples, {}, {rate:.0} profiles/s, {} left",
            describe_bytes(written),
            describe_duration(left)
        ));
    }

    fn say(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.println(text),
            None => say(text),
        }
    }
}

/// A bar for work that is counted in photons or repeats.
pub(super) struct WorkBar(ProgressBar);

impl WorkBar {
    /// For `total` photons or repeats.
    pub(super) fn new(total: u64) -> Self {
        Self(bar("{bar:24} {percent:>3} %  {msg}  {eta} left", Some(total)))
    }

    /// Says what is being done.
    pub(super) fn say(&self, text: &str) {
        self.0.set_message(text.to_owned());
    }

    /// Adds photons or repeats that are done.
    pub(super) fn done(&self, work: u64) {
        self.0.inc(work);
    }

    /// Removes the bar.
    pub(super) fn end(&self) {
        self.0.finish_and_clear();
    }
}

/// A bar that counts things, whose number is known once the first is done.
pub(super) struct CountBar(ProgressBar);

impl CountBar {
    /// Nothing is shown before the first of the `things`.
    pub(super) fn new(things: &str) -> Self {
        let template = format!("{{bar:24}} {{percent:>3}} %  {{pos}}/{{len}} {things}  {{per_sec}}, {{eta}} left");
        Self(bar(&template, None))
    }

    /// Sets the things done and their number.
    pub(super) fn show(&self, done: u64, all: u64) {
        self.0.set_length(all);
        self.0.set_position(done);
    }

    /// Things done.
    pub(super) fn done(&self) -> u64 {
        self.0.position()
    }

    /// Whether it is visible.
    pub(super) fn is_seen(&self) -> bool {
        !self.0.is_hidden()
    }

    /// Removes the bar.
    pub(super) fn end(&self) {
        self.0.finish_and_clear();
    }
}

/// A bar for samples that are validated, with the bytes that were read.
pub(super) struct ValidationBar(ProgressBar, AtomicU64);

impl ValidationBar {
    /// For `total` samples.
    pub(super) fn new(total: u64) -> Self {
        let template = "{bar:24} {percent:>3} %  {pos}/{len} samples, {msg}  {per_sec}, {eta} left";
        Self(bar(template, Some(total)), AtomicU64::new(0))
    }

    /// Adds a step that is done.
    pub(super) fn show(&self, step: ValidationStep) {
        if self.0.is_hidden() {
            return;
        }
        let read = self.1.fetch_add(step.bytes, Ordering::Relaxed) + step.bytes;
        let rate = read as f64 / self.0.elapsed().as_secs_f64().max(1e-3);
        self.0.set_message(format!("{}, {}/s", describe_bytes(read), describe_bytes(rate as u64)));
        self.0.inc(step.samples);
    }

    /// Removes the bar.
    pub(super) fn end(&self) {
        self.0.finish_and_clear();
    }
}

/// A bar for `total` things, or for a number that is set later; hidden where there is nothing to do or standard error is no
/// terminal.
fn bar(template: &str, total: Option<u64>) -> ProgressBar {
    if total == Some(0) || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    total.map_or_else(ProgressBar::no_length, ProgressBar::new).with_style(style(template))
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// A line for the user. Whoever closes the other end of standard error does not stop the work.
pub(super) fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// A number of things in words.
pub(super) fn counted(n: u64, thing: &str) -> String {
    if n == 1 { format!("1 {thing}") } else { format!("{n} {thing}s") }
}

/// A size in words.
pub(super) fn describe_bytes(n: u64) -> String {
    let units = [("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)];
    let n = n as f64;
    units
        .iter()
        .find(|(_, size)| n >= *size)
        .map_or(format!("{n} bytes"), |(unit, size)| format!("{:.1} {unit}", n / size))
}

/// A time in words.
pub(super) fn describe_duration(time: Duration) -> String {
    let s = time.as_secs();
    match s {
        0..60 => format!("{:.1} s", time.as_secs_f64()),
        60..3600 => format!("{} min {} s", s / 60, s % 60),
        3600..86400 => format!("{} h {} min", s / 3600, s % 3600 / 60),
        _ => format!("{} d {} h", s / 86400, s % 86400 / 3600),
    }
}
