//! Scan sources: a dataset, or files of the real camera, EXR, JSON or bare numbers, alone or in a folder.
//!
//! A scan in files of bare numbers has a file for each map. Those of Reflectance and Scatter are found by name: beside
//! `NAME.range.*` as `NAME.reflectance.*` and `NAME.scatter.*`, or in a folder with the folders `range`, `reflectance` and
//! `scatter` by one name in each.

use std::fs;
use std::path::{Path, PathBuf};

use output_schema::file::DATASET;

use super::map_numbers::MAX_PIXELS;
use super::stated_frame::{self, MapFiles};
use super::stated_scale::{StatedForm, StatedScale};
use super::{RangeUnit, ScanMaps, SensorFrame, dataset_frame, exr_frame, json_frame};
use crate::export::EXPORT_DOCUMENT;
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
    /// Files that say what their numbers are.
    Described(Vec<PathBuf>),
    /// Files of bare numbers, and what the user states of them.
    Stated(Vec<MapFiles>, Box<StatedScale>),
}

/// How a file that says what its numbers are is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum DescribedForm {
    Exr,
    Json,
    Icon,
}

impl DescribedForm {
    /// Endings of such files, how a list names them, and whether a folder of them is looked through for scans.
    const ENDINGS: [(&'static str, Self, &'static str, bool); 4] = [
        ("exr", Self::Exr, ".exr", true),
        ("xml", Self::Icon, ".xml with .dat", true),
        ("dat", Self::Icon, "", false),
        ("json", Self::Json, ".json", true),
    ];

    /// That of a file by its ending; a name without one may stand for the two files of the camera.
    fn of(path: &Path) -> Option<Self> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let known = Self::ENDINGS.iter().find(|(known, ..)| known.eq_ignore_ascii_case(ending));
        known.map(|(_, form, ..)| *form).or_else(|| described_by(path).is_file().then_some(Self::Icon))
    }
}

/// `NAME.xml` of a file of the camera that is given as `NAME`.
fn described_by(path: &Path) -> PathBuf {
    PathBuf::from(format!("{}.xml", path.display()))
}

/// The endings of all files that can be read, in words; of folders those that are looked for in them.
fn readable(in_folders: bool) -> String {
    let described = DescribedForm::ENDINGS.iter().filter(|(.., words, _)| !words.is_empty());
    let described = described.filter(|(.., looked)| *looked || !in_folders).map(|(.., words, _)| (*words).to_owned());
    let stated = StatedForm::ENDINGS.iter().filter(|(.., looked)| *looked || !in_folders);
    described.chain(stated.map(|(ending, ..)| format!(".{ending}"))).collect::<Vec<_>>().join(", ")
}

/// Remedy where nothing is found.
const NAME_A_SCAN: &str = "name a dataset, a folder of scans, or a scan";

impl ScanSource {
    /// Opens a dataset folder, a folder of files, or a file. Of many frames `most` are taken, spread evenly. What files of bare
    /// numbers are, `stated` says.
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
        let stated_files = |files: Vec<MapFiles>| ScanFiles::Stated(files, Box::new(stated.clone()));
        if !path.is_dir() {
            let form = DescribedForm::of(path);
            if !path.exists() && !path.with_extension("xml").is_file() && !described_by(path).is_file() {
                return Err(Fault::at(path, "it is not there", NAME_A_SCAN));
            }
            let kind = match (StatedForm::of(path), form) {
                (Some(_), _) => stated_files(vec![beside(path, None)?]),
                (None, Some(_)) => ScanFiles::Described(vec![path.into()]),
                (None, None) => return Err(unknown(path)),
            };
            return Ok(Self { name, kind });
        }
        let described = files_in(path, is_described)?;
        let kind = if described.is_empty() {
            let (folder, root) = match path.join("range") {
                range if range.is_dir() => (range, Some(path)),
                _ => (path.to_path_buf(), None),
            };
            let files = ranges(files_in(&folder, is_stated)?);
            one_form(path, &files)?;
            let chosen = few(files, most).into_iter().map(|file| beside(&file, root));
            stated_files(chosen.collect::<Result<_, _>>()?)
        } else {
            ScanFiles::Described(few(described, most))
        };
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
            ScanFiles::Dataset(..) | ScanFiles::Described(_) => Vec::new(),
            ScanFiles::Stated(files, _) => files.iter().filter_map(|files| StatedForm::of(&files.range)).collect(),
        }
    }

    /// Whether it is one scan of bare numbers that can be given maps beside Range.
    pub fn takes_light(&self) -> bool {
        match &self.kind {
            ScanFiles::Stated(files, _) => {
                files.len() == 1 && files.iter().all(|files| StatedForm::of(&files.range) != Some(StatedForm::Ply))
            }
            ScanFiles::Dataset(..) | ScanFiles::Described(_) => false,
        }
    }

    /// Gives that scan the files of Reflectance and Scatter.
    ///
    /// # Errors
    /// Where it has them by name already.
    pub fn give_light(&mut self, reflectance: Option<&Path>, scatter: Option<&Path>) -> Result<(), Fault> {
        let ScanFiles::Stated(all, _) = &mut self.kind else { return Ok(()) };
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
            ScanFiles::Described(files) => files.len(),
            ScanFiles::Stated(files, _) => files.len(),
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
            ScanFiles::Described(_) | ScanFiles::Stated(..) => None,
        };
        Ok((maps, ignored))
    }

    /// Frame number `i` below [`ScanSource::len`].
    ///
    /// # Errors
    /// Where it is damaged, or holds no heights.
    pub fn frame(&self, i: usize) -> Result<ScanMaps, Fault> {
        match &self.kind {
            ScanFiles::Dataset(dataset, chosen) => dataset_frame::frame(dataset, chosen[i]),
            ScanFiles::Stated(files, stated) => stated_frame::read(&files[i], stated),
            ScanFiles::Described(files) => {
                let path = &files[i];
                match DescribedForm::of(path) {
                    Some(DescribedForm::Exr) => exr_frame::read(path),
                    Some(DescribedForm::Json) => json_frame::read(path),
                    Some(DescribedForm::Icon) | None => icon_file(path),
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

/// Some of many, spread evenly.
fn few(files: Vec<PathBuf>, most: u64) -> Vec<PathBuf> {
    evenly(files.len() as u64, most).iter().map(|&i| files[i as usize].clone()).collect()
}

/// Whether files of bare numbers have this ending.
fn is_stated(ending: &str) -> bool {
    StatedForm::ENDINGS.iter().any(|(known, _, looked)| *looked && ending.eq_ignore_ascii_case(known))
}

/// Whether files that say what their numbers are have this ending.
fn is_described(ending: &str) -> bool {
    DescribedForm::ENDINGS.iter().any(|(known, .., looked)| *looked && ending.eq_ignore_ascii_case(known))
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

/// Files of a folder with endings that are `known`, in the order of their names; what an export says of itself is none.
fn files_in(folder: &Path, known: fn(&str) -> bool) -> Result<Vec<PathBuf>, Fault> {
    let entries =
        fs::read_dir(folder).map_err(|e| Fault::at(folder, format!("it cannot be listed: {e}"), "allow it"))?;
    let is_known = |file: &PathBuf| {
        let ending = file.extension().and_then(|ending| ending.to_str());
        ending.is_some_and(known) && !file.ends_with(EXPORT_DOCUMENT) && !file.is_dir()
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
    let forms = || files.iter().filter_map(|file| StatedForm::of(file));
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
        let mut found = files_in(&folder, is_stated)?.into_iter().filter(is_wanted);
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

fn icon_file(path: &Path) -> Result<ScanMaps, Fault> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    match icon::open(path)? {
        Content::Image(image) => {
            let exposures = vec![SensorFrame { cols: image.cols, profile: None, dn: image.dn }];
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
            let mut unused = reader.unused().to_vec();
            unused.extend(scan.marks.as_ref().map(|_| "Mark INT".to_owned()));
            let x = scan.places();
            Ok(ScanMaps {
                name,
                cols: scan.width,
                rows,
                unit,
                first_mm: world.filter(|_| x.is_none()).map(|world| world.lower[0] + 0.5 * world.col_mm(scan.width)),
                col_mm: scan.col_mm(),
                x,
                unused,
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
