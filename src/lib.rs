//! Sheetlight.

pub mod record;
pub mod settings;
pub mod shard;
pub mod validate;
