//! The extension module of the Python package: `sheetlight._sheetlight`.
//!
//! It is what [`sheetlight::api`] promises, as Python sees it: recipes and datasets in, maps as NumPy arrays out.
//! Words, checks of arguments and everything that Python does as well are in `python/sheetlight`.
//!
//! Rendering goes on in threads of its own, without Python's lock; the caller's thread waits, and looks for Ctrl-C.

mod errors;
mod pool;
mod recipe;
mod sample;
mod stored;

use std::ffi::OsString;

use pyo3::prelude::*;

/// The extension module.
#[pymodule]
mod _sheetlight {
    use super::*;

    #[pymodule_export]
    use super::recipe::{Recipe, Samples};
    #[pymodule_export]
    use super::sample::Sample;
    #[pymodule_export]
    use super::stored::StoredDataset;

    /// Version of the program.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const version: &str = env!("CARGO_PKG_VERSION");

    /// The names and summaries of the recipes that are built in.
    #[pyfunction]
    fn built_in_recipes() -> Vec<(&'static str, &'static str)> {
        sheetlight::api::Recipe::embedded().map(|known| (known.name, known.summary)).collect()
    }

    /// Path of the manifest of a shard, relative to the dataset's folder.
    #[pyfunction]
    fn manifest_path(shard: u64) -> String {
        sheetlight::api::manifest_path(shard)
    }

    /// Red, green and blue of a pixel class, as previews show it.
    #[pyfunction]
    fn class_colour(class: u8) -> [u8; 3] {
        sheetlight::api::class_colour(class).0
    }

    /// Does what `gen` does with these arguments, of which the first is the program's name; returns its exit status.
    #[pyfunction]
    fn run_from(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
        py.detach(|| sheetlight::cli::run_from(arguments))
    }
}
