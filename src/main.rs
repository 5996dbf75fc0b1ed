//! The `gen` program: see [`sheetlight::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(sheetlight::cli::run_from(std::env::args_os()))
}
