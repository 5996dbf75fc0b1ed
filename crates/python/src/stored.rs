//! Datasets that were written.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use sheetlight::api;

use crate::errors::{of_fault, of_program};
use crate::sample::Sample;

/// A dataset's folder.
#[pyclass(frozen, module = "sheetlight._sheetlight")]
pub(crate) struct StoredDataset {
    stored: Arc<api::StoredDataset>,
}

#[pymethods]
impl StoredDataset {
    /// Reads the documents of the dataset in that folder.
    #[staticmethod]
    fn open(py: Python<'_>, root: PathBuf) -> PyResult<Self> {
        let stored = py.detach(|| api::StoredDataset::open(&root)).map_err(|fault| of_fault(py, &fault))?;
        Ok(Self { stored: Arc::new(stored) })
    }

    /// `dataset.json` of the dataset in that folder, checked; manifests may be missing.
    #[staticmethod]
    fn read_head(py: Python<'_>, root: PathBuf) -> PyResult<String> {
        let dataset = py.detach(|| api::Dataset::open(&root)).map_err(|fault| of_fault(py, &fault))?;
        serde_json::to_string(dataset.head()).map_err(|error| of_program(&error.to_string()))
    }

    /// `dataset.json`.
    fn head(&self) -> PyResult<String> {
        serde_json::to_string(self.stored.dataset().head()).map_err(|error| of_program(&error.to_string()))
    }

    /// Index, split and class of every sample that is finished.
    fn samples(&self) -> Vec<(u64, String, String)> {
        self.stored.samples().map(|sample| (sample.index, sample.split.clone(), sample.class.clone())).collect()
    }

    /// The files that a sample is read from, relative to the folder, each with its size [bytes].
    fn files(&self, py: Python<'_>, index: u64) -> PyResult<Vec<(String, u64)>> {
        let files = self.stored.files(index).map_err(|fault| of_fault(py, &fault))?;
        Ok(files.into_iter().map(|file| (file.path.clone(), file.bytes)).collect())
    }

    /// A sample.
    fn sample(&self, py: Python<'_>, index: u64) -> PyResult<Sample> {
        let stored = py.detach(|| self.stored.sample(index)).map_err(|fault| of_fault(py, &fault))?;
        Sample::of_stored(py, stored)
    }
}
