//! Shards and folders as the writer leaves them.

mod card;
mod exact;
/// Links are made as Unix makes them.
#[cfg(unix)]
mod hostile_folder;
mod refuse;
mod write;
