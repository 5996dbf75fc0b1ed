//! One sample as Python has it: arrays by name, numbers as JSON, the row of a dataset as an Arrow stream.

use std::sync::Arc;

use arrow_ipc::writer::StreamWriter;
use numpy::ndarray::Array2;
use numpy::{Element, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde_json::Value;
use sheetlight::api::{Below, Fault, Grey, Labels, Maps, Record, RowBatch, Simulator, StoredSample, TruthMaps};

use crate::errors::{of_fault, of_program};

/// A map by its name here, in the tables (where it is there), and in EXR files.
const MAPS: [(&str, &str, &str); 11] = [
    ("range", "range", "Range"),
    ("reflectance", "reflectance", "Reflectance"),
    ("scatter", "scatter", "Scatter"),
    ("grey", "grey", "Grey"),
    ("label", "label", "Label"),
    ("instance", "instance", "Instance"),
    ("height_mm", "", "Height"),
    ("fibre_azimuth_deg", "", "FibreAzimuth"),
    ("fibre_dive_deg", "", "FibreDive"),
    ("film_thickness_mm", "", "FilmThickness"),
    ("film_gap_mm", "", "FilmGap"),
];

/// A sample, rendered or read.
#[pyclass(frozen, module = "sheetlight._sheetlight")]
pub(crate) struct Sample {
    numbers: String,
    source: SampleSource,
}

enum SampleSource {
    /// Rendered: its maps have moved into arrays by name.
    Rendered { simulator: Arc<Simulator>, record: Box<Record>, maps: Py<PyDict>, frames: Py<PyDict> },
    /// Of a dataset: maps are decoded when they are asked for.
    Stored(Box<StoredSample>),
}

impl Sample {
    /// A rendered one; `numbers` is the JSON text of its row's numbers.
    pub(crate) fn of_record(
        py: Python<'_>,
        simulator: Arc<Simulator>,
        mut record: Record,
        numbers: String,
    ) -> PyResult<Self> {
        let size = [record.rows, record.cols];
        let maps = PyDict::new(py);
        let Maps { range, mut reflectance, mut scatter, grey } = std::mem::take(&mut record.maps);
        py.detach(|| {
            missing_as_nan(&range, &mut reflectance);
            missing_as_nan(&range, &mut scatter);
        });
        let Labels { class, instance } = std::mem::take(&mut record.labels);
        for (name, map) in [("range", range), ("reflectance", reflectance), ("scatter", scatter)] {
            maps.set_item(name, array(py, size, map)?)?;
        }
        if !grey.is_empty() {
            maps.set_item("grey", array(py, size, grey)?)?;
        }
        maps.set_item("label", array(py, size, class)?)?;
        maps.set_item("instance", array(py, size, instance)?)?;
        if let Some(TruthMaps { height, below }) = record.truth.take() {
            maps.set_item("height_mm", array(py, size, height)?)?;
            let below = match below {
                Below::Fibre { azimuth, dive } => vec![("fibre_azimuth_deg", azimuth), ("fibre_dive_deg", dive)],
                Below::Film { thickness, gap } => vec![("film_thickness_mm", thickness), ("film_gap_mm", gap)],
                Below::Solid(_) => Vec::new(),
            };
            for (name, map) in below {
                maps.set_item(name, array(py, size, map)?)?;
            }
        }
        let frames = PyDict::new(py);
        for frame in std::mem::take(&mut record.stack) {
            frames.set_item(
                frame.profile,
                array(py, [record.sensor_rows, simulator.recipe().size().columns], frame.dn)?,
            )?;
        }
        let (maps, frames) = (maps.unbind(), frames.unbind());
        Ok(Self { numbers, source: SampleSource::Rendered { simulator, record: Box::new(record), maps, frames } })
    }

    /// One of a dataset.
    pub(crate) fn of_stored(py: Python<'_>, stored: StoredSample) -> PyResult<Self> {
        let numbers = stored.numbers().map_err(|fault| of_fault(py, &fault))?;
        Ok(Self { numbers: Value::Object(numbers).to_string(), source: SampleSource::Stored(Box::new(stored)) })
    }
}

#[pymethods]
impl Sample {
    /// The numbers of its row, as JSON.
    #[getter]
    fn numbers(&self) -> &str {
        &self.numbers
    }

    /// The names of the maps that it has.
    fn maps(&self, py: Python<'_>) -> Vec<String> {
        match &self.source {
            SampleSource::Rendered { maps, .. } => maps.bind(py).keys().iter().map(|key| key.to_string()).collect(),
            SampleSource::Stored(stored) => {
                let channels = stored.channels();
                let held = |(_, image, channel): &&(&str, &str, &str)| {
                    stored.images().png.iter().any(|name| name == image) || channels.contains(channel)
                };
                MAPS.iter().filter(held).map(|(name, ..)| (*name).to_owned()).collect()
            }
        }
    }

    /// A map `[rows, cols]` of those that it has.
    fn map<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        match &self.source {
            SampleSource::Rendered { maps, .. } => {
                let map = maps.bind(py).get_item(name)?;
                map.ok_or_else(|| of_program(&format!("it has no map {name}")))
            }
            SampleSource::Stored(stored) => stored_map(py, stored, name),
        }
    }

    /// Its sensor frames `[sensor rows, sensor columns]`, by profile.
    fn frames<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        match &self.source {
            SampleSource::Rendered { frames, .. } => frames.bind(py).copy(),
            SampleSource::Stored(stored) => {
                let frames = py.detach(|| stored.frames()).map_err(|fault| of_fault(py, &fault))?;
                let images = stored.images();
                let size = [images.sensor_rows as usize, images.sensor_cols as usize];
                let found = PyDict::new(py);
                for frame in frames {
                    found.set_item(frame.profile, array(py, size, frame.dn)?)?;
                }
                Ok(found)
            }
        }
    }

    /// The row that a dataset has of it, as an Arrow stream of one batch.
    fn row<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let stream = match &self.source {
            SampleSource::Rendered { simulator, record, maps, .. } => {
                let maps = maps.bind(py);
                let mut whole = (**record).clone();
                whole.maps = Maps {
                    range: taken(maps, "range")?,
                    reflectance: taken(maps, "reflectance")?,
                    scatter: taken(maps, "scatter")?,
                    grey: if maps.contains("grey")? { taken(maps, "grey")? } else { Vec::new() },
                };
                whole.labels = Labels { class: taken(maps, "label")?, instance: taken(maps, "instance")? };
                py.detach(|| simulator.row(whole).and_then(|row| streamed(&row)))
            }
            SampleSource::Stored(stored) => py.detach(|| streamed(stored.row())),
        };
        Ok(PyBytes::new(py, &stream.map_err(|what| of_program(&what))?))
    }
}

/// A map of a dataset in physical units, from the EXR file where that has it, else from the image in the table.
fn stored_map<'py>(py: Python<'py>, stored: &StoredSample, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let unknown = || of_program(&format!("it has no map {name}"));
    let &(_, image, channel) = MAPS.iter().find(|(known, ..)| *known == name).ok_or_else(unknown)?;
    let fault = |fault| of_fault(py, &fault);
    let images = stored.images();
    let size = [images.rows as usize, images.cols as usize];
    if image == "label" || image == "instance" {
        // Whole numbers are the same in both, and images are decoded sooner.
        let found = match py.detach(|| stored.image(image)).map_err(fault)? {
            Some(found) => found.numbers(),
            None => {
                let numbers = py.detach(|| stored.channel(channel)).map_err(fault)?.ok_or_else(unknown)?;
                numbers.into_iter().map(|number| number as u16).collect()
            }
        };
        return match image {
            "label" => array(py, size, found.into_iter().map(|number| number as u8).collect()),
            _ => array(py, size, found),
        };
    }
    let map = py.detach(|| -> Result<_, Fault> {
        if image == "range" {
            return stored.range();
        }
        if let Some(map) = stored.channel(channel)? {
            return Ok(Some(map));
        }
        let Some(pixels) = stored.image(image)? else { return Ok(None) };
        let missing = missing_of(stored, image, &pixels)?;
        let value = |(number, missing): (u16, bool)| if missing { f32::NAN } else { f32::from(number) };
        Ok(Some(pixels.numbers().into_iter().zip(missing).map(value).collect::<Vec<f32>>()))
    });
    array(py, size, map.map_err(fault)?.ok_or_else(unknown)?)
}

/// Which pixels of a sample of a dataset are not measured: 0 in the image `range`, NaN in any measured channel of the
/// EXR file. Where neither is there, 0 in Reflectance, which is the peak of a line that was found, or else in the image
/// that is asked for. Light of lamps needs no line: `grey` tells by itself.
fn missing_of(stored: &StoredSample, image: &str, pixels: &Grey) -> Result<Vec<bool>, Fault> {
    let is_zero = |pixels: &Grey| pixels.numbers().into_iter().map(|number| number == 0).collect();
    if image == "grey" {
        return Ok(is_zero(pixels));
    }
    if let Some(range) = stored.image("range")? {
        return Ok(is_zero(&range));
    }
    for channel in ["Range", "Reflectance", "Scatter"] {
        if let Some(map) = stored.channel(channel)? {
            return Ok(map.into_iter().map(f32::is_nan).collect());
        }
    }
    Ok(stored.image("reflectance")?.as_ref().map_or_else(|| is_zero(pixels), is_zero))
}

fn missing_as_nan(range: &[f32], map: &mut [f32]) {
    for (value, range) in map.iter_mut().zip(range) {
        if range.is_nan() {
            *value = f32::NAN;
        }
    }
}

/// A map as an array `[rows, cols]`, which takes it over. It cannot be written to: what comes of a sample later shall
/// be of the sample that it is.
fn array<T: Element>(py: Python<'_>, [rows, cols]: [usize; 2], map: Vec<T>) -> PyResult<Bound<'_, PyAny>> {
    let map = Array2::from_shape_vec([rows, cols], map).map_err(|error| of_program(&error.to_string()))?;
    let array = PyArray2::from_owned_array(py, map);
    array.readwrite().make_nonwriteable();
    Ok(array.into_any())
}

/// A copy of a map.
fn taken<T: Element + Clone>(maps: &Bound<'_, PyDict>, name: &str) -> PyResult<Vec<T>> {
    let map = maps.get_item(name)?.ok_or_else(|| of_program(&format!("it has no map {name}")))?;
    let map: PyReadonlyArray2<'_, T> = map.extract()?;
    map.as_slice().map(<[T]>::to_vec).map_err(|error| of_program(&error.to_string()))
}

fn streamed(row: &RowBatch) -> Result<Vec<u8>, String> {
    let mut stream = Vec::new();
    let mut writer = StreamWriter::try_new(&mut stream, &row.batch().schema()).map_err(|error| error.to_string())?;
    writer.write(row.batch()).and_then(|()| writer.finish()).map_err(|error| error.to_string())?;
    drop(writer);
    Ok(stream)
}
