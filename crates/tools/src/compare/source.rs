//! Scan sources: a dataset, or files of the real camera, EXR or JSON, alone or in a folder.

use std::fs;
use std::path::{Path, PathBuf};

use output_schema::file::DATASET;

use super::{RangeUnit, ScanMaps, SensorFrame, dataset_frame, exr_frame, json_frame};
use crate::icon::{self, Content, Traits};
use dataset::{Dataset, Fault, one_line};

/// Frames that can be read one after the other.
#[derive(Debug)]
pub struct ScanSource {
    name: String,
    kind: ScanFiles,
}

#[derive(Debug)]
enum ScanFiles {
    Dataset(Box<Dataset>, Vec<u64>),
    Files(Vec<PathBuf>),
}

/// Most pixels of a camera's file that are compared: a little more than the buffers of the real camera hold, 2560 x 16383. Each
/// takes some 20 bytes.
const MAX_PIXELS: usize = 48 << 20;
/// Files that hold a frame.
const FRAME_EXTENSIONS: [&str; 3] = ["exr", "xml", "json"];

impl ScanSource {
    /// Opens a dataset folder, a folder of files, or a file. Of many frames `most` are taken, spread evenly.
    ///
    /// # Errors
    /// Where there is nothing that can be read.
    pub fn open(path: &Path, most: u64) -> Result<Self, Fault> {
        let name = path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into());
        let name = one_line(name);
        if path.join(DATASET).is_file() {
            let dataset = Dataset::open(path)?;
            let chosen = evenly(dataset.head().samples, most);
            return Ok(Self { name, kind: ScanFiles::Dataset(Box::new(dataset), chosen) });
        }
        if !path.is_dir() {
            if path.exists() || path.with_extension("xml").exists() {
                return Ok(Self { name, kind: ScanFiles::Files(vec![path.into()]) });
            }
            return Err(Fault::at(path, "it is not there", "name a dataset, a folder of scans, or a scan"));
        }
        let entries =
            fs::read_dir(path).map_err(|e| Fault::at(path, format!("it cannot be listed: {e}"), "allow it"))?;
        let known = |file: &PathBuf| file.extension().is_some_and(|found| FRAME_EXTENSIONS.iter().any(|e| found == *e));
        let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(known).collect();
        if files.is_empty() {
            let what = format!("it holds no {DATASET} and no scan (.exr, .xml with .dat, .json)");
            return Err(Fault::at(path, what, "name a dataset, a folder of scans, or a scan"));
        }
        files.sort();
        let chosen = evenly(files.len() as u64, most);
        Ok(Self { name, kind: ScanFiles::Files(chosen.iter().map(|&i| files[i as usize].clone()).collect()) })
    }

    /// What to call it: its last name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How many frames it gives.
    pub fn len(&self) -> usize {
        match &self.kind {
            ScanFiles::Dataset(_, chosen) => chosen.len(),
            ScanFiles::Files(files) => files.len(),
        }
    }

    /// Whether it gives none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Frame number `i` below [`ScanSource::len`].
    ///
    /// # Errors
    /// Where it is damaged, or holds no heights.
    pub fn frame(&self, i: usize) -> Result<ScanMaps, Fault> {
        match &self.kind {
            ScanFiles::Dataset(dataset, chosen) => dataset_frame::frame(dataset, chosen[i]),
            ScanFiles::Files(files) => {
                let path = &files[i];
                match path.extension().and_then(|extension| extension.to_str()) {
                    Some("exr") => exr_frame::read(path),
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

fn icon_file(path: &Path) -> Result<ScanMaps, Fault> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    match icon::open(path)? {
        Content::Image(image) => {
            let exposures = vec![SensorFrame { cols: image.cols, dn: image.dn }];
            Ok(ScanMaps { name, exposures, ..ScanMaps::default() })
        }
        Content::Scan(mut reader) => {
            let (unit, world) = match reader.traits() {
                Traits::World(world) => (RangeUnit::Mm, Some(world)),
                Traits::Sensor(sensor) => (RangeUnit::Px { sensor_rows: sensor.region_rows }, None),
            };
            let rows = reader.rows();
            let pixels = reader.width().saturating_mul(rows);
            if pixels > MAX_PIXELS {
                let what = format!("its {rows} profiles of {} columns are {pixels} pixels", reader.width());
                let remedy = format!("at most {MAX_PIXELS} are compared: give a part of the scan");
                return Err(Fault::at(path, what, remedy));
            }
            let scan = reader.read(0, rows)?;
            Ok(ScanMaps {
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
                ..ScanMaps::default()
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
