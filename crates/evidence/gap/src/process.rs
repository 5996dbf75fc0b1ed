//! The Python process that trains the classifier of the gap: started without a shell, stopped with the program.
//!
//! A folder of its own below the temporary one holds windows, script and answer, and is removed afterwards. The process
//! ends with the program in whatever way: [`GapStop::now`] kills it, and the script ends where its standard input does.

use std::fs::{self, DirBuilder, File};
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

use serde::Deserialize;
use serde_json::Value;

use dataset::{Fault, one_line};

/// What is run.
const SCRIPT: &str = include_str!("network.py");
/// Exit status of the script where numpy or torch cannot be imported.
const NO_PACKAGE: i32 = 3;
/// Most bytes of an answer; a number takes about twenty.
const MOST_ANSWER_BYTES: u64 = 64 << 20;
/// Letters of the last words of a process that are told.
const MOST_LAST_WORDS: usize = 300;
/// How often is looked whether the process has ended, after its output has.
const POLL: Duration = Duration::from_millis(20);
/// What else can be done where a Python or its packages are missing.
const OTHER_PYTHON: &str = "name a Python that has them with --python or SHEETLIGHT_PYTHON";

/// Kills the process and removes its folder, from any thread.
#[derive(Debug, Clone, Default)]
pub struct GapStop(Arc<Mutex<Running>>);

#[derive(Debug, Default)]
struct Running {
    child: Option<Child>,
    folder: Option<PathBuf>,
    is_stopped: bool,
}

impl GapStop {
    /// Stops what runs; what has not begun will not.
    pub fn now(&self) {
        let mut running = self.locked();
        running.is_stopped = true;
        if let Some(mut child) = running.child.take() {
            // What has ended already cannot be killed.
            let _ = child.kill();
            let _ = child.wait();
        }
        if let Some(folder) = running.folder.take() {
            let _ = fs::remove_dir_all(folder);
        }
    }

    fn locked(&self) -> MutexGuard<'_, Running> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What the script writes.
#[derive(Debug, Deserialize)]
struct GapAnswer {
    scores: Vec<Vec<f64>>,
    torch: String,
}

/// Stops when it goes out of scope, whether all went well or not.
struct Cleared<'s>(&'s GapStop);

impl Drop for Cleared<'_> {
    fn drop(&mut self) {
        self.0.now();
    }
}

/// Trains on `windows` (numbers in the order of `job`), and calls `folds` with 1 for each fold that is done. Gives the
/// scores of each experiment, which has as many windows as `counts` says, and the version of torch.
///
/// # Errors
/// Where Python or torch is missing, fails, is killed, or gives no numbers.
pub(crate) fn train(
    python: &Path,
    job: &Value,
    windows: &[f32],
    counts: &[usize],
    stop: &GapStop,
    folds: &dyn Fn(u64),
) -> Result<(Vec<Vec<f64>>, String), Fault> {
    let folder = own_folder(stop)?;
    let cleared = Cleared(stop);
    let bytes: Vec<u8> = windows.iter().flat_map(|number| number.to_le_bytes()).collect();
    let script = folder.join("gap_network.py");
    write(&script, SCRIPT.as_bytes())?;
    write(&folder.join("windows.f32"), &bytes)?;
    drop(bytes);
    write(&folder.join("job.json"), job.to_string().as_bytes())?;
    let said = folder.join("said.txt");
    let log = File::create(&said).map_err(|error| unwritable(&said, &error))?;
    let status = run(python, &script, &folder, log, stop, folds)?;
    if !status.success() {
        return Err(failed(python, status, &last_words(&said)));
    }
    let answer = read_answer(python, &folder.join("scores.json"), counts)?;
    drop(cleared);
    Ok((answer.scores, answer.torch))
}

fn run(
    python: &Path,
    script: &Path,
    folder: &Path,
    log: File,
    stop: &GapStop,
    folds: &dyn Fn(u64),
) -> Result<ExitStatus, Fault> {
    let mut command = Command::new(python);
    command.arg(script).arg(folder).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(log);
    // What it compiles would be left in the folder.
    command.env("PYTHONDONTWRITEBYTECODE", "1").env("PYTHONUTF8", "1");
    let (lifeline, output) = {
        let mut running = stop.locked();
        if running.is_stopped {
            return Err(stopped(python));
        }
        let mut child = command.spawn().map_err(|error| unstarted(python, &error))?;
        let pipes = (child.stdin.take(), child.stdout.take());
        running.child = Some(child);
        pipes
    };
    if let Some(mut output) = output {
        let mut chunk = [0; 4096];
        loop {
            match output.read(&mut chunk) {
                Ok(0) => break,
                Ok(n) => folds(chunk[..n].iter().filter(|byte| **byte == b'\n').count() as u64),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => break,
            }
        }
    }
    loop {
        // Not waited for under the lock, which whoever stops it needs.
        let ended = match stop.locked().child.as_mut() {
            Some(child) => child.try_wait(),
            None => return Err(stopped(python)),
        };
        match ended {
            Ok(Some(status)) => {
                drop(lifeline);
                return Ok(status);
            }
            Ok(None) => std::thread::sleep(POLL),
            Err(error) => {
                let what = format!("how it ended cannot be told: {error}");
                return Err(Fault::at(python, what, "run the same command again"));
            }
        }
    }
}

fn read_answer(python: &Path, path: &Path, counts: &[usize]) -> Result<GapAnswer, Fault> {
    let none = |what: String| {
        Fault::at(python, what, "give Python 3 itself, or a program that runs it with the arguments that it gets")
    };
    let mut text = Vec::new();
    let read = File::open(path).and_then(|file| file.take(MOST_ANSWER_BYTES).read_to_end(&mut text));
    read.map_err(|_| none("it ended without an answer, as if it were no Python".into()))?;
    let answer: GapAnswer =
        serde_json::from_slice(&text).map_err(|error| none(format!("its answer cannot be read: {error}")))?;
    let found: Vec<usize> = answer.scores.iter().map(Vec::len).collect();
    if found != counts {
        return Err(none(format!("it answered for {found:?} windows, asked were {counts:?}")));
    }
    if answer.scores.iter().flatten().any(|score| !(0.0..=1.0).contains(score)) {
        return Err(none("its answer has numbers that are no probabilities".into()));
    }
    Ok(answer)
}

fn own_folder(stop: &GapStop) -> Result<PathBuf, Fault> {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |time| time.as_nanos());
    let path = std::env::temp_dir().join(format!("sheetlight-gap-{}-{since}", std::process::id()));
    let mut builder = DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    let mut running = stop.locked();
    // It must be new: nobody else has put a thing there.
    builder.create(&path).map_err(|error| unwritable(&path, &error))?;
    running.folder = Some(path.clone());
    Ok(path)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Fault> {
    File::create_new(path).and_then(|mut file| file.write_all(bytes)).map_err(|error| unwritable(path, &error))
}

fn unwritable(path: &Path, error: &std::io::Error) -> Fault {
    let remedy = "make room there, or let TMPDIR name a folder on another disk";
    Fault { tried: Some("write"), ..Fault::at(path, error.to_string(), remedy) }
}

fn stopped(python: &Path) -> Fault {
    Fault::at(python, "it was stopped", "run the same command again")
}

fn unstarted(python: &Path, error: &std::io::Error) -> Fault {
    let remedy = match error.kind() {
        ErrorKind::NotFound => format!("--gap needs Python 3 with numpy and torch: install it, or {OTHER_PYTHON}"),
        _ => format!("--gap needs Python 3 with numpy and torch: {OTHER_PYTHON}"),
    };
    Fault::at(python, format!("it cannot be started: {error}"), remedy)
}

fn failed(python: &Path, status: ExitStatus, said: &str) -> Fault {
    let words = if said.is_empty() { String::new() } else { format!(": {said}") };
    match status.code() {
        Some(NO_PACKAGE) => {
            let remedy = format!(
                "`{} -m pip install numpy torch` installs what --gap needs; or {OTHER_PYTHON}",
                python.display()
            );
            Fault::at(python, format!("it lacks a package{words}"), remedy)
        }
        None => Fault::at(
            python,
            format!("it was killed ({status}){words}"),
            "where memory was short, free some or give fewer --scans, then run the same command again",
        ),
        Some(_) => {
            let remedy = format!(
                "--gap needs Python 3.9 or newer with numpy and torch 2: correct what it says, or {OTHER_PYTHON}"
            );
            Fault::at(python, format!("it failed ({status}){words}"), remedy)
        }
    }
}

/// The last line that a process said.
fn last_words(path: &Path) -> String {
    let mut bytes = Vec::new();
    // Where nothing can be read, nothing is told.
    let _ = File::open(path).and_then(|file| file.take(1 << 20).read_to_end(&mut bytes));
    let text = String::from_utf8_lossy(&bytes);
    let line = text.lines().rev().map(str::trim).find(|line| !line.is_empty()).unwrap_or_default();
    one_line(line.chars().take(MOST_LAST_WORDS).collect())
}
