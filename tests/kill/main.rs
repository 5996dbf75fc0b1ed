//! `kill -9` at any moment. Moments are chosen by the time that an undisturbed run takes, so one test runs after
//! another.

mod program;
mod writer;

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Holds the machine for one test.
fn alone() -> MutexGuard<'static, ()> {
    static MACHINE: Mutex<()> = Mutex::new(());
    MACHINE.lock().unwrap_or_else(PoisonError::into_inner)
}
