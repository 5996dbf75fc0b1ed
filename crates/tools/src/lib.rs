//! What is done with a dataset: checked with a model, exported, compared with real scans, shown as a page.

pub mod check;
pub mod compare;
pub mod export;
pub mod icon;
pub mod report;
