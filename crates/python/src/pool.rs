//! Threads for rendering, and waiting for them.
//!
//! Threads do not survive `fork`, which PyTorch's `DataLoader` begins its workers with: a pool belongs to the process
//! that made it, and a process that finds another's makes one of its own.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use sheetlight::api::cores_and_threads;

use crate::errors::of_program;

/// Time between two looks for Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// Pools that are kept for the next sample; threads of one that is dropped end when their work is done.
const MAX_POOLS: usize = 3;

/// A pool, the process that it belongs to, and its number of threads.
struct Pool {
    process: u32,
    threads: usize,
    pool: Arc<ThreadPool>,
}

/// Those that were made here or in the process that this one was forked from; the last one used is the last. Only taken
/// with Python's lock, so that nobody holds it during a `fork`.
static POOLS: Mutex<Vec<Pool>> = Mutex::new(Vec::new());

/// A number of threads as it was asked for, `None` for one a core.
pub(crate) fn thread_count(asked: Option<usize>) -> PyResult<usize> {
    let [cores, most] = cores_and_threads();
    match asked {
        None => Ok(cores),
        Some(threads) if (1..=most).contains(&threads) => Ok(threads),
        Some(threads) => Err(PyValueError::new_err(format!(
            "threads={threads}: give 1 to {most} on this machine, or None for one a core"
        ))),
    }
}

/// The pool of this process with so many threads.
pub(crate) fn pool(_: Python<'_>, threads: usize) -> PyResult<Arc<ThreadPool>> {
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    let (own, others) = std::mem::take(&mut *pools).into_iter().partition(|pool| pool.process == process);
    *pools = own;
    // Threads of another process are not here: there is nobody that dropping their pool could tell to end.
    std::mem::forget::<Vec<Pool>>(others);
    let known = pools.iter().position(|pool| pool.threads == threads).map(|at| pools.remove(at));
    let pool = match known {
        Some(known) => known.pool,
        None => {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build();
            Arc::new(pool.map_err(|error| of_program(&format!("no threads can be started: {error}")))?)
        }
    };
    if pools.len() == MAX_POOLS {
        pools.remove(0);
    }
    pools.push(Pool { process, threads, pool: pool.clone() });
    Ok(pool)
}

/// What a piece of work ended with: its result, or what it panicked with.
pub(crate) type Outcome<T> = Result<T, String>;

/// Does `work` in a thread of `pool` and sends what comes of it, a panic too. A receiver that is gone does not want it.
pub(crate) fn spawn<T: Send + 'static>(
    pool: &ThreadPool,
    sender: Sender<Outcome<T>>,
    work: impl FnOnce() -> T + Send + 'static,
) {
    pool.spawn(move || {
        let outcome = catch_unwind(AssertUnwindSafe(work)).map_err(|panic| words(panic.as_ref()));
        let _ = sender.send(outcome);
    });
}

fn words(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "a thread panicked".into())
}

/// Waits without Python's lock; where Python has a signal to handle, does that, and gives up if it raises.
pub(crate) fn wait<T: Send>(py: Python<'_>, receiver: &Mutex<Receiver<Outcome<T>>>) -> PyResult<T> {
    loop {
        let received = py.detach(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(LOOK));
        match received {
            Ok(Ok(result)) => return Ok(result),
            Ok(Err(what)) => return Err(of_program(&what)),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            Err(RecvTimeoutError::Disconnected) => return Err(of_program("a thread ended without a result")),
        }
    }
}
