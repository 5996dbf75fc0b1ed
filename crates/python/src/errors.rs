//! Errors as Python's exceptions: those that `sheetlight._errors` declares, made with what Rust knows about them.

use pyo3::call::PyCallArgs;
use pyo3::exceptions::{PyOSError, PyRuntimeError};
use pyo3::prelude::*;
use sheetlight::api::{Fault, LoadError, RecipeError, YamlFaults};

/// An exception of `sheetlight._errors`, by its name.
fn declared<'py>(py: Python<'py>, name: &str, arguments: impl PyCallArgs<'py>) -> PyErr {
    let class = py.import("sheetlight._errors").and_then(|errors| errors.getattr(name));
    class.and_then(|class| class.call1(arguments)).map_or_else(|error| error, PyErr::from_value)
}

/// Why there is no recipe: `RecipeError` with the list of faults, `FileNotFoundError`, `OSError` or `DatasetError`.
pub(crate) fn of_loading(py: Python<'_>, error: &LoadError) -> PyErr {
    match error {
        LoadError::Recipe(RecipeError::Faulty(faults)) => of_faults(py, faults),
        LoadError::Recipe(RecipeError::NotFound { .. }) => declared(py, "RecipeNotFoundError", (error.to_string(),)),
        LoadError::Recipe(RecipeError::Unreadable { .. }) => PyOSError::new_err(error.to_string()),
        LoadError::Dataset(fault) => of_fault(py, fault),
        LoadError::Folder(what) => declared(py, "DatasetError", (what,)),
    }
}

fn of_faults(py: Python<'_>, faults: &YamlFaults) -> PyErr {
    let list: Vec<_> = faults
        .list
        .iter()
        .map(|fault| {
            let place = (!faults.is_set(fault)).then_some((fault.place.line, fault.place.column));
            (place, &fault.key, &fault.problem, &fault.remedy, &fault.origin)
        })
        .collect();
    declared(py, "RecipeError", (faults.to_string().trim_end(), list))
}

/// A fault of a dataset or of the machine.
pub(crate) fn of_fault(py: Python<'_>, fault: &Fault) -> PyErr {
    declared(py, "DatasetError", (fault.to_string(),))
}

/// What must not happen.
pub(crate) fn of_program(what: &str) -> PyErr {
    PyRuntimeError::new_err(format!("{what}; this is a fault of the program, please report it"))
}
