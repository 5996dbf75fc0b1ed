//! Scan sources: a dataset, or files of the real camera, EXR, JSON or bare numbers, alone or in a folder.
//!
//! A scan in files of bare numbers has a file for each map. Those of Reflectance and Scatter are found by name: beside
//! `NAME.range.*` as `NAME.reflectance.*` and `NAME.scatter.*`, or in a folder with the folders `range`, `reflectance`
//! and `scatter` by one name in each.

use std::fs;
use std::path::{Path, PathBuf};

use output_schema::file::DATASET;

use super::formats::{described_by, format_of, is_looked_for, readable, stated_form};
use super::scan_format::StatedForm;
use super::stated_frame::{self, MapFiles};
use super::stated_scale::StatedScale;
use super::{ScanMaps, dataset_frame};
use crate::export::EXPORT_DOCUMENT;
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
    /// The files of each scan, and what the user states of bare numbers.
    Files(Vec<MapFiles>, Box<StatedScale>),
}

/// Remedy where nothing is found.
const NAME_A_SCAN: &str = "name a dataset, a folder of scans, or a scan";

impl ScanSource {
    /// Opens a dataset folder, a folder of files, or a file. Of many frames `most` are taken, spread evenly. What files
    /// of bare numbers are, `stated` says.
    ///
    /// # Errors
    /// Where there is nothing that can be read.
    pub fn open(path: &Path, most: u64, stated: &StatedScale) -> Result<Self, Fault> {
        let name = path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into());
        let name = one_line(name);
        if path.join(DATASET).is_file() {
            let dataset = Dataset::open(path)?;
            let chosen = evenly(dataset.head().samples, most);
            return Ok(Self { name, kind: ScanFiles::Dataset(Box::new(dataset), chosen) });
        }
        let with_scale = |files: Vec<MapFiles>| ScanFiles::Files(files, Box::new(stated.clone()));
        if !path.is_dir() {
            if !path.exists() && !path.with_extension("xml").is_file() && !described_by(path).is_file() {
                return Err(Fault::at(path, "it is not there", NAME_A_SCAN));
            }
            let format = format_of(path).ok_or_else(|| unknown(path))?;
            let files = if format.stated.is_some() { beside(path, None)? } else { MapFiles::alone(path.into()) };
            return Ok(Self { name, kind: with_scale(vec![files]) });
        }
        let described = files_in(path, false)?;
        let kind = with_scale(if described.is_empty() {
            let (folder, root) = match path.join("range") {
                range if range.is_dir() => (range, Some(path)),
                _ => (path.to_path_buf(), None),
            };
            let files = ranges(files_in(&folder, true)?);
            one_form(path, &files)?;
            few(files, most).into_iter().map(|file| beside(&file, root)).collect::<Result<_, _>>()?
        } else {
            few(described, most).into_iter().map(MapFiles::alone).collect()
        });
        let source = Self { name, kind };
        if source.is_empty() {
            let what = format!("it holds no {DATASET} and no scan ({})", readable(true));
            return Err(Fault::at(path, what, NAME_A_SCAN));
        }
        Ok(source)
    }

    /// What its files of bare numbers are; nothing where its files say themselves what their numbers are.
    pub fn stated_forms(&self) -> Vec<StatedForm> {
        match &self.kind {
            ScanFiles::Dataset(..) => Vec::new(),
            ScanFiles::Files(files, _) => files.iter().filter_map(|files| stated_form(&files.range)).collect(),
        }
    }

    /// Whether it is one scan of bare numbers that can be given maps beside Range.
    pub fn takes_light(&self) -> bool {
        matches!(self.stated_forms()[..], [StatedForm::Image | StatedForm::Csv])
    }

    /// Gives that scan the files of Reflectance and Scatter.
    ///
    /// # Errors
    /// Where it has them by name already.
    pub fn give_light(&mut self, reflectance: Option<&Path>, scatter: Option<&Path>) -> Result<(), Fault> {
        let ScanFiles::Files(all, _) = &mut self.kind else { return Ok(()) };
        let Some(files) = all.first_mut() else { return Ok(()) };
        for (own, given, option) in
            [(&mut files.reflectance, reflectance, "--reflectance"), (&mut files.scatter, scatter, "--scatter")]
        {
            let Some(given) = given else { continue };
            if let Some(own) = own {
                let what = format!("{} belongs to it by its name", own.display());
                return Err(Fault::at(&files.range, what, format!("leave {option} away, or rename that file")));
            }
            *own = Some(given.into());
        }
        Ok(())
    }

    /// What to call it: its last name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How many frames it gives.
    pub fn len(&self) -> usize {
        match &self.kind {
            ScanFiles::Dataset(_, chosen) => chosen.len(),
            ScanFiles::Files(files, _) => files.len(),
        }
    }

    /// Whether it gives none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether it is a dataset, whose labels tell the object.
    pub fn is_dataset(&self) -> bool {
        matches!(self.kind, ScanFiles::Dataset(..))
    }

    /// Frame number `i` with the pixels that show no object, `[rows, cols]`; `None` where no labels tell them. Sensor
    /// frames are dark there.
    ///
    /// # Errors
    /// Where it is damaged, or holds no heights.
    pub fn object(&self, i: usize) -> Result<(ScanMaps, Option<Vec<bool>>), Fault> {
        let mut maps = self.frame(i)?;
        let ignored = match &self.kind {
            ScanFiles::Dataset(dataset, chosen) => dataset_frame::beside_object(dataset, chosen[i], &mut maps)?,
            ScanFiles::Files(..) => None,
        };
        Ok((maps, ignored))
    }

    /// Frame number `i` with the class of each pixel, where labels tell it.
    ///
    /// # Errors
    /// Where it is damaged, or holds no heights.
    pub fn labelled(&self, i: usize) -> Result<ScanMaps, Fault> {
        let mut maps = self.frame(i)?;
        if let ScanFiles::Dataset(dataset, chosen) = &self.kind {
            maps.classes = dataset_frame::classes(dataset, chosen[i], &maps)?;
        }
        Ok(maps)
    }

    /// Frame number `i` below [`ScanSource::len`].
    ///
    /// # Errors
    /// Where it is damaged, or holds no heights.
    pub fn frame(&self, i: usize) -> Result<ScanMaps, Fault> {
        match &self.kind {
            ScanFiles::Dataset(dataset, chosen) => dataset_frame::frame(dataset, chosen[i]),
            ScanFiles::Files(files, stated) => stated_frame::read(&files[i], stated),
        }
    }
}

/// `most` numbers below `count`, spread evenly, the first and the last among them.
fn evenly(count: u64, most: u64) -> Vec<u64> {
    let most = most.min(count);
    (0..most).map(|j| if most < 2 { 0 } else { j * (count - 1) / (most - 1) }).collect()
}

/// Some of many, spread evenly.
fn few(files: Vec<PathBuf>, most: u64) -> Vec<PathBuf> {
    evenly(files.len() as u64, most).iter().map(|&i| files[i as usize].clone()).collect()
}

/// The fault of a file that is of no kind that can be read.
fn unknown(path: &Path) -> Fault {
    let ending = path.extension().map(|ending| one_line(ending.to_string_lossy().into_owned()));
    let what = match &ending {
        Some(ending) => format!("files that end in .{ending} are not read"),
        None => "its name has no ending that says what it is".to_owned(),
    };
    let is_recipe = ending.is_some_and(|ending| ["yaml", "yml"].contains(&ending.to_lowercase().as_str()));
    let hint = if is_recipe { "; `gen --recipe FILE --out DIR` makes a dataset of a recipe" } else { "" };
    Fault::at(path, what, format!("give a dataset, a folder of scans, or a scan ({}){hint}", readable(false)))
}

/// Scans of a folder, files of bare numbers or others, in the order of their names; what an export says of itself is
/// none.
fn files_in(folder: &Path, is_stated: bool) -> Result<Vec<PathBuf>, Fault> {
    let entries =
        fs::read_dir(folder).map_err(|e| Fault::at(folder, format!("it cannot be listed: {e}"), "allow it"))?;
    let is_known = |file: &PathBuf| {
        let ending = file.extension().and_then(|ending| ending.to_str());
        ending.is_some_and(|letters| is_looked_for(letters, is_stated))
            && !file.ends_with(EXPORT_DOCUMENT)
            && !file.is_dir()
    };
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(is_known).collect();
    files.sort();
    Ok(files)
}

/// The name before `.range`, where a file is called so.
fn range_name(path: &Path) -> Option<&str> {
    path.file_stem()?.to_str()?.strip_suffix(".range")
}

/// Files of Range: those that are called so, else all.
fn ranges(files: Vec<PathBuf>) -> Vec<PathBuf> {
    let named: Vec<PathBuf> = files.iter().filter(|file| range_name(file).is_some()).cloned().collect();
    if named.is_empty() { files } else { named }
}

/// Refuses files of several forms: which of them are scans cannot be told.
fn one_form(folder: &Path, files: &[PathBuf]) -> Result<(), Fault> {
    let forms = || files.iter().filter_map(|file| stated_form(file));
    match forms().find(|form| Some(*form) != forms().next()) {
        None => Ok(()),
        Some(_) => {
            let what = "it holds images, .csv and .ply of which any may be scans";
            Err(Fault::at(
                folder,
                what,
                "keep one kind there, or name those that hold Range NAME.range.png (.tif, .csv, .ply)",
            ))
        }
    }
}

/// A scan of a file of Range with the maps that belong to it by name: in the folders of `root`, or beside it.
fn beside(range: &Path, root: Option<&Path>) -> Result<MapFiles, Fault> {
    let map = |name: &str| -> Result<Option<PathBuf>, Fault> {
        let stem = range.file_stem().unwrap_or_default().to_string_lossy();
        let (folder, wanted) = match (root, range_name(range)) {
            (Some(root), _) => (root.join(name), stem.into_owned()),
            (None, Some(before)) => (range.with_file_name(""), format!("{before}.{name}")),
            (None, None) => return Ok(None),
        };
        let folder = if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder };
        if !folder.is_dir() {
            return Ok(None);
        }
        let is_wanted = |file: &PathBuf| file.file_stem().is_some_and(|stem| stem.to_string_lossy() == wanted);
        let mut found = files_in(&folder, true)?.into_iter().filter(is_wanted);
        match (found.next(), found.next()) {
            (Some(one), Some(other)) => {
                let what = format!("{} and {} may both be its {name}", one.display(), other.display());
                Err(Fault::at(range, what, "move one of them away"))
            }
            (found, _) => Ok(found),
        }
    };
    Ok(MapFiles { range: range.into(), reflectance: map("reflectance")?, scatter: map("scatter")? })
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
