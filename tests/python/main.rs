//! Everything that needs the Python environment of `make venv`, onnxruntime in it, or Chromium.

mod baselines;
mod browser;
mod check;
mod check_faults;
mod check_inputs;
mod compare_gap;
mod export;
mod fit_browser;
mod gap;
mod loaders;
mod loaders_card;
mod loaders_metadata;
mod models;
mod notebook;
mod older_datasets;
mod readers;
mod real_boards;
mod report_browser;
mod report_check;
mod scripts;
mod sweep;
mod tune_browser;
