//! What is said beside results, on standard error: notes, details, faults, and the last words where Ctrl-C stops the
//! work.

use std::borrow::Cow;
use std::io::Write;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget};
use serde_json::{Value, json};

/// Exit status after Ctrl-C, as shells give it: 128 and the number of SIGINT.
const EXIT_INTERRUPTED: i32 = 130;

/// Arguments that every command takes.
#[derive(Debug, Args)]
pub(super) struct ConsoleArgs {
    /// Say nothing but faults beside the result
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Say more: which recipe it is, and each shard that is finished
    #[arg(short, long, global = true)]
    verbose: bool,
    /// Seconds between two lines of progress, where standard error is no terminal and has no bar
    #[arg(long, global = true, value_name = "SECONDS", default_value_t = 30, value_parser = super::whole::<u64>)]
    progress: u64,
}

/// Where notes and progress go, and what is said in the end.
#[derive(Clone)]
pub(super) struct Console {
    quiet: bool,
    verbose: bool,
    /// Whether all is said as events for programs.
    events: bool,
    interval: Duration,
    shown: Arc<Mutex<Shown>>,
}

/// What Ctrl-C has to put in order.
#[derive(Default)]
struct Shown {
    bar: Option<ProgressBar>,
    last_words: Option<Box<dyn Fn() -> String + Send>>,
}

impl Console {
    /// As the arguments ask; `events` for a program in place of a person.
    pub(super) fn new(arguments: &ConsoleArgs, events: bool) -> Self {
        let ConsoleArgs { quiet, verbose, progress } = *arguments;
        Self { quiet, verbose, events, interval: Duration::from_secs(progress), shown: Arc::default() }
    }

    /// From now on Ctrl-C removes the bar, says what is kept and how to go on, and ends the program.
    pub(super) fn listen(&self) {
        let (shown, events) = (Arc::clone(&self.shown), self.events);
        // Where there is no such signal, the program ends as any other does.
        let _ = ctrlc::set_handler(move || {
            let shown = locked(&shown);
            if let Some(bar) = &shown.bar {
                bar.finish_and_clear();
                bar.set_draw_target(ProgressDrawTarget::hidden());
            }
            let words = shown.last_words.as_ref().map_or_else(|| "nothing is written".into(), |words| words());
            if events {
                say_event(&json!({ "event": "stopped", "text": words, "status": EXIT_INTERRUPTED }));
            } else {
                say(&format!("gen: stopped: {words}"));
            }
            std::process::exit(EXIT_INTERRUPTED);
        });
    }

    /// What Ctrl-C says from now on: what is kept, and how to go on.
    pub(super) fn on_stop(&self, words: impl Fn() -> String + Send + 'static) {
        locked(&self.shown).last_words = Some(Box::new(words));
    }

    /// Something that is good to know.
    pub(super) fn note(&self, text: &str) {
        if self.quiet {
            return;
        }
        if self.events {
            return say_event(&json!({ "event": "note", "text": text }));
        }
        let bar = locked(&self.shown).bar.clone();
        match bar {
            Some(bar) => bar.println(text),
            None => say(text),
        }
    }

    /// Something that those want to know who asked for more.
    pub(super) fn detail(&self, text: &str) {
        if self.verbose {
            self.note(text);
        }
    }

    /// The last words where something can't be done.
    pub(super) fn fault(&self, text: &str, status: u8) {
        if self.events {
            say_event(&json!({ "event": "fault", "text": text, "status": status }));
        } else {
            say(&format!("gen: {text}"));
        }
    }

    /// Whether a program is told what goes on.
    pub(super) fn has_events(&self) -> bool {
        self.events
    }

    /// Tells a program what goes on; nothing where a person reads.
    pub(super) fn event(&self, event: impl FnOnce() -> Value) {
        if self.events {
            say_event(&event());
        }
    }

    /// Whether nothing but faults is said to a person.
    pub(super) fn is_quiet(&self) -> bool {
        self.quiet || self.events
    }

    /// Least time between two lines of progress.
    pub(super) fn interval(&self) -> Duration {
        self.interval
    }

    /// Takes the bar that is shown now; `None` for none.
    pub(super) fn shows(&self, bar: Option<ProgressBar>) {
        locked(&self.shown).bar = bar;
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A line for the user. Whoever closes the other end of standard error does not stop the work.
pub(super) fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "{}", shown(text));
}

/// One event, on a line of its own.
fn say_event(event: &Value) {
    let _ = writeln!(std::io::stderr(), "{event}");
}

/// A text of several lines without what a terminal would obey: names of files may hold escape characters.
pub(super) fn shown(text: &str) -> Cow<'_, str> {
    dataset::plain(text, &['\n', '\t'])
}
