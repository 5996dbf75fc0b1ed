//! Shards and folders as the writer leaves them.

mod exact;
mod refuse;
mod write;
