//! What is done with a dataset: checked with a model, exported, compared with real scans, shown as a page; and a model
//! swept over keys.

pub mod check;
pub mod compare;
pub mod export;
pub mod icon;
pub mod report;
pub mod sweep;
