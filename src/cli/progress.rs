//! Progress on long work: a bar for people, plain lines where standard error is no terminal; and numbers in words.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use output_schema::file::LOCK;
use serde_json::json;

use super::console::{Console, say};
use super::remaining_time::RemainingTime;
use crate::generate::{DatasetRequest, GenerateEvent};
pub(super) use dataset::describe_bytes;
use dataset::validate::ValidationStep;
use recipe::Recipe;

/// How often a bar is drawn while nothing is done.
const TICK: Duration = Duration::from_millis(250);

/// Work of which parts are done one after the other.
pub(super) struct Progress<'c> {
    console: &'c Console,
    bar: Option<ProgressBar>,
    /// What a rate is of; empty for none.
    unit: &'static str,
    state: Mutex<ProgressState>,
}

struct ProgressState {
    done: u64,
    total: Option<u64>,
    message: String,
    started: Instant,
    line: Instant,
    time: RemainingTime,
}

impl<'c> Progress<'c> {
    /// For work of which `total` is to be done, or an amount that is told later. `unit` is what its rate counts, empty
    /// for none.
    pub(super) fn new(console: &'c Console, unit: &'static str, total: Option<u64>) -> Self {
        let terminal = std::io::stderr().is_terminal() && !console.is_quiet();
        let bar = (terminal && total != Some(0)).then(|| {
            let bar = total.map_or_else(ProgressBar::no_length, ProgressBar::new);
            let style = ProgressStyle::with_template("{bar:24} {percent:>3} %  {msg}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.enable_steady_tick(TICK);
            bar
        });
        console.shows(bar.clone());
        let now = Instant::now();
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let state = ProgressState {
            done: 0,
            total,
            message: String::new(),
            started: now,
            line: now,
            time: RemainingTime::new(threads),
        };
        Self { console, bar, unit, state: Mutex::new(state) }
    }

    /// Sets the amount of work.
    pub(super) fn set_total(&self, total: u64) {
        self.state().total = Some(total);
        if let Some(bar) = &self.bar {
            bar.set_length(total);
        }
    }

    /// So much more is done.
    pub(super) fn add(&self, work: u64) {
        if work == 0 {
            return;
        }
        let mut state = self.state();
        let done = state.done + work;
        self.update(&mut state, done);
    }

    /// So much of so much is done.
    pub(super) fn set(&self, done: u64, total: u64) {
        if self.state().total != Some(total) {
            self.set_total(total);
        }
        let mut state = self.state();
        if done != state.done {
            self.update(&mut state, done);
        }
    }

    /// Says what is being done, in place of a count.
    pub(super) fn say(&self, message: &str) {
        let mut state = self.state();
        message.clone_into(&mut state.message);
        self.draw(&state);
    }

    /// Work that is done.
    pub(super) fn done(&self) -> u64 {
        self.state().done
    }

    /// Whether a bar is drawn.
    pub(super) fn is_drawn(&self) -> bool {
        self.bar.is_some()
    }

    fn state(&self) -> MutexGuard<'_, ProgressState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn update(&self, state: &mut ProgressState, done: u64) {
        state.done = done;
        let elapsed = state.started.elapsed();
        state.time.part(elapsed, done);
        if let Some(bar) = &self.bar {
            bar.set_position(done);
        }
        self.draw(state);
        if self.bar.is_none() && !self.console.is_quiet() && state.line.elapsed() >= self.console.interval() {
            state.line = Instant::now();
            let share = state.total.filter(|total| *total > 0);
            let percent = share.map_or_else(String::new, |total| format!("{} %, ", 100 * done.min(total) / total));
            say(&format!("{percent}{}", self.words(state)));
        }
    }

    fn draw(&self, state: &ProgressState) {
        if let Some(bar) = &self.bar {
            bar.set_message(self.words(state));
        }
    }

    /// What is being done, how fast, and how long it will take.
    fn words(&self, state: &ProgressState) -> String {
        let ProgressState { done, total, message, started, time, .. } = state;
        let mut words = Vec::new();
        if !message.is_empty() {
            words.push(message.clone());
        } else if let Some(total) = total {
            words.push(format!("{done}/{total} {}", self.unit));
        }
        let elapsed = started.elapsed().as_secs_f64();
        if !self.unit.is_empty() && *done > 0 && elapsed > 0.0 {
            // The same rate as that behind the time that is left.
            let rate = time.rate().unwrap_or(*done as f64 / elapsed);
            words.push(format!("{} {}/s", rounded(rate), self.unit));
        }
        if let Some(left) = total.and_then(|total| time.left(total)).filter(|left| !left.is_zero()) {
            words.push(format!("{} left", describe_duration(left)));
        }
        words.join(", ")
    }
}

impl Drop for Progress<'_> {
    /// Removes the bar.
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        self.console.shows(None);
    }
}

/// Least time between two events of profiles.
const EVENT_INTERVAL: Duration = Duration::from_secs(1);

/// Shows the events of a run that makes a dataset.
pub(super) struct GenerateProgress<'c> {
    progress: Progress<'c>,
    console: &'c Console,
    profiles_per_sample: u64,
    counts: Mutex<GenerateCounts>,
    /// Samples that are written and whose shard is not finished: what is lost where the run is stopped.
    unkept: Arc<AtomicU64>,
    hint: String,
    out: PathBuf,
    /// Samples that are asked for.
    asked: u64,
}

/// What has been made.
struct GenerateCounts {
    total: u64,
    samples: u64,
    bytes: u64,
    /// When profiles were told to a program, last.
    told: Instant,
}

impl<'c> GenerateProgress<'c> {
    /// For a run; nothing is counted before its first event. `unkept` counts samples whose shard is not finished.
    pub(super) fn new(
        console: &'c Console,
        name: &str,
        recipe: &Recipe,
        request: &DatasetRequest,
        unkept: Arc<AtomicU64>,
    ) -> Self {
        Self {
            progress: Progress::new(console, "profiles", None),
            console,
            profiles_per_sample: recipe.size().profiles as u64,
            counts: Mutex::new(GenerateCounts { total: 0, samples: 0, bytes: 0, told: Instant::now() }),
            unkept,
            hint: format!("gen preview --recipe {name} --seed {}", request.seed),
            out: request.out.clone(),
            asked: request.samples,
        }
    }

    /// Takes one event.
    pub(super) fn show(&self, event: GenerateEvent) {
        self.tell(event);
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        // A program has been told all of it.
        let note = |text: &str| {
            if !self.console.has_events() {
                self.console.note(text);
            }
        };
        match event {
            GenerateEvent::Anew { samples, samples_per_shard } => note(&format!(
                "{} was begun with {} in shards of {samples_per_shard}, of which nothing is made: it is begun anew",
                self.out.display(),
                counted(samples, "sample")
            )),
            GenerateEvent::Larger { samples, to_make, left } => note(&format!(
                "{} was begun with {}, more than -n {} asks for: {to_make} are made now, in whole shards, and {left} \
                 are left; -n {samples} makes all",
                self.out.display(),
                counted(samples, "sample"),
                self.asked,
            )),
            GenerateEvent::Begin { samples, finished } => {
                counts.total = samples;
                if finished > 0 {
                    note(&format!("{finished} samples are there already; {samples} to make"));
                } else if self.progress.is_drawn() && samples > 20 {
                    note(&format!("{samples} samples to make; to look at one first: {}", self.hint));
                }
                self.progress.set_total(samples * self.profiles_per_sample);
                self.say(&counts);
            }
            GenerateEvent::Profiles { done } => self.progress.add(done),
            GenerateEvent::Sample { bytes } => {
                counts.samples += 1;
                counts.bytes += bytes;
                self.unkept.fetch_add(1, Ordering::Relaxed);
                self.say(&counts);
            }
            GenerateEvent::Shard { shard } => {
                // Samples are written in the order of shards: those before its last one are kept.
                self.unkept.store(0, Ordering::Relaxed);
                self.say(&counts);
                self.console.detail(&format!("shard {shard} is finished"));
            }
            GenerateEvent::Busy { shard } => {
                note(&format!("shard {shard} is being made by another process; it is looked at again at the end"));
            }
            GenerateEvent::NoLocks { text } => note(&format!("warning: {text}")),
            GenerateEvent::Waits { shard: None } => {
                let lock = self.out.join(format!("{LOCK}dataset"));
                note(&format!("waiting for another process, which holds {}", lock.display()));
            }
            GenerateEvent::Waits { shard: Some(shard) } => {
                note(&format!("waiting for shard {shard}, which another process is making"));
            }
        }
    }

    /// The same for a program.
    fn tell(&self, event: GenerateEvent) {
        if !matches!(event, GenerateEvent::Profiles { .. }) {
            // An event is plain data: it always becomes JSON.
            return self.console.event(|| serde_json::to_value(event).unwrap_or_default());
        }
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        if counts.told.elapsed() >= EVENT_INTERVAL {
            counts.told = Instant::now();
            let of = counts.total * self.profiles_per_sample;
            self.console.event(|| json!({ "event": "profiles", "done": self.progress.done(), "of": of }));
        }
    }

    fn say(&self, counts: &GenerateCounts) {
        let GenerateCounts { total, samples, bytes, .. } = counts;
        let kept = match self.unkept.load(Ordering::Relaxed) {
            0 => String::new(),
            unkept => format!(" ({} kept)", samples - unkept.min(*samples)),
        };
        self.progress.say(&format!("{samples}/{total} samples{kept}, {}", describe_bytes(*bytes)));
    }
}

/// Samples that are validated, with the bytes that were read.
pub(super) struct ValidationProgress<'c>(Progress<'c>, AtomicU64);

impl<'c> ValidationProgress<'c> {
    /// For `total` samples.
    pub(super) fn new(console: &'c Console, total: u64) -> Self {
        Self(Progress::new(console, "samples", Some(total)), AtomicU64::new(0))
    }

    /// Adds a step that is done.
    pub(super) fn show(&self, step: ValidationStep) {
        let read = self.1.fetch_add(step.bytes, Ordering::Relaxed) + step.bytes;
        let state = self.0.state();
        let rate = read as f64 / state.started.elapsed().as_secs_f64().max(1e-3);
        let (done, total) = (state.done + step.samples, state.total.unwrap_or(0));
        drop(state);
        let read = format!("{}, {}/s", describe_bytes(read), describe_bytes(rate as u64));
        self.0.say(&format!("{done}/{total} samples, {read}"));
        self.0.add(step.samples);
    }
}

/// A rate with a few digits.
fn rounded(rate: f64) -> String {
    if rate < 10.0 { format!("{rate:.1}") } else { format!("{rate:.0}") }
}

/// A number of things in words.
pub(super) fn counted(n: u64, thing: &str) -> String {
    if n == 1 { format!("1 {thing}") } else { format!("{n} {thing}s") }
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
