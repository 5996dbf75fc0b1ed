//! The `gen` program: see [`sheetlight::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    sheetlight::cli::run()
}
