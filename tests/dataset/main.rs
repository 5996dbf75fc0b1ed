//! Shards and folders as the writer leaves them.

mod exact;
mod hostile_folder;
mod refuse;
mod write;
