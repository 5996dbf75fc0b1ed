//! Where frames come from: a dataset, files of the real camera, EXR or JSON, alone or in a folder.

use std::fs;
use std::path::{Path, PathBuf};

use output_schema::file::DATASET;

use super::{Exposure, Frame, Unit, dataset, json_frame, to_eight_bits};
use crate::dataset::{Dataset, ExrChannel, ExrMaps, Fault};
use crate::icon::{self, Content, Traits};

/// What is wrong with a place where frames should be, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {what}; {remedy}")]
pub struct SourceError {
    /// File or folder.
    pub place: String,
    /// What is wrong.
    pub what: String,
    /// What to do.
    pub remedy: String,
}

/// Frames that can be read one after the other.
#[derive(Debug)]
pub struct Source {
    name: String,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    Dataset(Box<Dataset>, Vec<u64>),
    Files(Vec<PathBuf>),
}

/// Files that hold a frame.
const EXTENSIONS: [&str; 3] = ["exr", "xml", "json"];

impl Source {
    /// Opens a dataset folder, a folder of files, or a file. Of many frames `most` are taken, spread evenly.
    ///
    /// # Errors
    /// Where there is nothing that can be read.
    pub fn open(path: &Path, most: u64) -> Result<Self, SourceError> {
        let name = path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into());
        if path.join(DATASET).is_file() {
            let dataset = Dataset::open(path)?;
            let chosen = evenly(dataset.head().samples, most);
            return Ok(Self { name, kind: Kind::Dataset(Box::new(dataset), chosen) });
        }
        if !path.is_dir() {
            if path.exists() || path.with_extension("xml").exists() {
                return Ok(Self { name, kind: Kind::Files(vec![path.into()]) });
            }
            return Err(error(path, "it is not there".into(), "name a dataset, a folder of scans, or a scan"));
        }
        let entries = fs::read_dir(path).map_err(|e| error(path, format!("it cannot be listed: {e}"), "allow it"))?;
        let known = |file: &PathBuf| file.extension().is_some_and(|found| EXTENSIONS.iter().any(|e| found == *e));
        let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(known).collect();
        if files.is_empty() {
            let what = format!("it holds no {DATASET} and no scan (.exr, .xml with .dat, .json)");
            return Err(error(path, what, "name a dataset, a folder of scans, or a scan"));
        }
        files.sort();
        let chosen = evenly(files.len() as u64, most);
        Ok(Self { name, kind: Kind::Files(chosen.iter().map(|&i| files[i as usize].clone()).collect()) })
    }

    /// What to call it: its last name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How many frames it gives.
    pub fn len(&self) -> usize {
        match &self.kind {
            Kind::Dataset(_, chosen) => chosen.len(),
            Kind::Files(files) => files.len(),
        }
    }

    /// Whether it gives none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Frame number `i` below [`Source::len`].
    ///
    /// # Errors
    /// Where it is damaged, or holds no heights.
    pub fn frame(&self, i: usize) -> Result<Frame, SourceError> {
        match &self.kind {
            Kind::Dataset(dataset, chosen) => Ok(dataset::frame(dataset, chosen[i])?),
            Kind::Files(files) => {
                let path = &files[i];
                match path.extension().and_then(|extension| extension.to_str()) {
                    Some("exr") => exr_file(path),
                    Some("json") => json_frame::read(path),
                    _ => icon_file(path),
                }
            }
        }
    }
}

/// `most` numbers below `count`, spread evenly, the first and the last among them.
fn evenly(count: u64, most: u64) -> Vec<u64> {
    let most = most.min(count);
    (0..most).map(|j| if most < 2 { 0 } else { j * (count - 1) / (most - 1) }).collect()
}

/// Something wrong with a place.
pub(super) fn error(path: &Path, what: String, remedy: &str) -> SourceError {
    SourceError { place: path.display().to_string(), what, remedy: remedy.into() }
}

impl From<Fault> for SourceError {
    fn from(Fault { place, what, remedy, .. }: Fault) -> Self {
        Self { place, what, remedy: remedy.into() }
    }
}

fn exr_file(path: &Path) -> Result<Frame, SourceError> {
    let bytes = fs::read(path).map_err(|e| error(path, format!("it cannot be read: {e}"), "allow it"))?;
    let maps = ExrMaps::decode(path, &bytes);
    Ok(exr_frame(&maps.map_err(|what| error(path, what, "copy it again, or have it made again"))?)?)
}

/// The maps of an EXR file.
pub(super) fn exr_frame(maps: &ExrMaps) -> Result<Frame, Fault> {
    let find = |name: &str| maps.channels.iter().find(|channel| channel.name == name).map(ExrChannel::numbers);
    let remedy = "set `output: {exr: [range, reflectance]}` in the recipe";
    let missing = || Fault::at(&maps.path, "it has no channel Range", remedy);
    let range = find("Range").ok_or_else(missing)?.into_iter().map(f64::from).collect();
    let seen = |map: Vec<f32>| map.into_iter().map(|v| if v.is_nan() { 0.0 } else { v }).collect::<Vec<f32>>();
    let description: serde_json::Value = serde_json::from_str(&maps.description).unwrap_or_default();
    let name = maps.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let bits = description["bits"].as_u64().unwrap_or(0);
    let scaled = |map: Vec<f32>| map.into_iter().map(|v| v * to_eight_bits(bits)).collect::<Vec<f32>>();
    let sensor_rows = description["sensor_rows"].as_u64().and_then(|rows| u32::try_from(rows).ok()).unwrap_or(0);
    Ok(Frame {
        name,
        cols: maps.cols,
        rows: maps.rows,
        bits,
        unit: if description["units"]["Range"] == "px" { Unit::Px { sensor_rows } } else { Unit::Mm },
        first_mm: description["calibration"]["x_first_mm"].as_f64(),
        col_mm: description["col_mm"].as_f64(),
        row_mm: description["row_mm"].as_f64(),
        range,
        reflectance: find("Reflectance").or_else(|| find("Y")).map(seen).map(scaled),
        scatter: find("Scatter").map(seen).map(scaled),
        exposures: Vec::new(),
    })
}

fn icon_file(path: &Path) -> Result<Frame, SourceError> {
    let told = |e: icon::IconError| SourceError { place: e.place, what: e.what, remedy: e.remedy };
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    match icon::open(path).map_err(told)? {
        Content::Image(image) => {
            let exposures = vec![Exposure { cols: image.cols, dn: image.dn }];
            Ok(Frame { name, exposures, ..Frame::default() })
        }
        Content::Scan(mut reader) => {
            let (unit, world) = match reader.traits() {
                Traits::World(world) => (Unit::Mm, Some(world)),
                Traits::Sensor(sensor) => (Unit::Px { sensor_rows: sensor.region_rows }, None),
            };
            let rows = reader.rows();
            let scan = reader.read(0, rows).map_err(told)?;
            Ok(Frame {
                name,
                cols: scan.width,
                rows,
                unit,
                first_mm: world.map(|world| world.lower[0] + 0.5 * world.col_mm(scan.width)),
                col_mm: world.map(|world| world.col_mm(scan.width)),
                row_mm: world.and_then(|world| world.row_mm),
                range: scan.heights(),
                reflectance: scan.light_dn().map(|dn| dn.iter().map(|&dn| f32::from(dn)).collect()),
                scatter: match scan.scatter {
                    Some(icon::Scatter::Byte(dn)) => Some(dn.into_iter().map(f32::from).collect()),
                    Some(icon::Scatter::Word(dn)) => Some(dn.into_iter().map(f32::from).collect()),
                    None => None,
                },
                ..Frame::default()
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Few of many are spread from the first to the last; few of few are all.
    #[test]
    fn frames_are_chosen_evenly() {
        assert_eq!(evenly(10, 4), [0, 3, 6, 9]);
        assert_eq!(evenly(3, 8), [0, 1, 2]);
        assert_eq!((evenly(5, 1), evenly(0, 3)), (vec![0], vec![]));
    }
}
