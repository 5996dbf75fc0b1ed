//! Writer of iCon files: numbers under a temporary name as they come, the XML last.

use std::fs::{self, File};
use std::io::{Error, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::layout::{FileLayout, PlaneContent};
use super::{IconScan, PeakLight, ProfileMark, RangeValues, Scatter, SensorImage};
use dataset::{Fault, atomic_file};

/// A scan that is being written. Without [`ScanWriter::finish`] nothing stays.
#[derive(Debug)]
pub struct ScanWriter {
    layout: FileLayout,
    rows: usize,
    written: usize,
    data: PathBuf,
    partial: PathBuf,
    file: File,
}

impl ScanWriter {
    /// Begins `NAME.dat` for `rows` rows like those of `like`, whose own rows are not written; `name` is NAME, with or
    /// without one of the two extensions.
    ///
    /// # Errors
    /// Where the place cannot be written.
    pub fn create(name: &Path, like: &IconScan, rows: usize) -> Result<Self, Fault> {
        let data = paths(name)?.0;
        let partial = partial(&data);
        let file = atomic_file::create(&partial).map_err(|no| refused(&data, &no.source))?;
        Ok(Self { layout: FileLayout::of(like), rows, written: 0, data, partial, file })
    }

    /// Adds rows.
    ///
    /// # Errors
    /// Where they have another layout, are more than were announced, or the disk refuses.
    pub fn push(&mut self, rows: &IconScan) -> Result<(), Fault> {
        let wrong = |what: String| Fault::at(&self.data, what, "give whole rows of the scan that was begun");
        if FileLayout::of(rows) != self.layout {
            return Err(wrong("these rows have other planes, another width or other traits".into()));
        }
        if self.written + rows.rows > self.rows {
            return Err(wrong(format!("{} rows are too many for {}", self.written + rows.rows, self.rows)));
        }
        for plane in &self.layout.planes {
            let bytes = bytes(rows, plane.part);
            if bytes.len() != rows.rows * plane.line() {
                return Err(wrong(format!(
                    "{:?} holds {} bytes, not {}",
                    plane.part,
                    bytes.len(),
                    rows.rows * plane.line()
                )));
            }
            let at = self.rows as u64 * plane.before as u64 + self.written as u64 * plane.line() as u64;
            let mut put = || {
                self.file.seek(SeekFrom::Start(at))?;
                self.file.write_all(&bytes)
            };
            put().map_err(|error: Error| refused(&self.data, &error))?;
        }
        self.written += rows.rows;
        Ok(())
    }

    /// Gives both files their names.
    ///
    /// # Errors
    /// Where rows are missing, or the disk refuses.
    pub fn finish(self) -> Result<(), Fault> {
        if self.written != self.rows {
            let what = format!("{} of {} rows were written", self.written, self.rows);
            return Err(Fault::at(&self.data, what, "write all rows"));
        }
        self.file.sync_all().map_err(|error| refused(&self.data, &error))?;
        atomic_file::rename(&self.partial, &self.data).map_err(|no| refused(&self.data, &no.source))?;
        write_text(&self.data.with_extension("xml"), &self.layout.write())
    }
}

impl Drop for ScanWriter {
    fn drop(&mut self) {
        // After `finish` the name is gone, and nothing is left to remove.
        let _ = fs::remove_file(&self.partial);
    }
}

/// Writes a sensor image as `NAME.dat` and `NAME.xml`.
///
/// # Errors
/// Where the place cannot be written, or the image is not whole rows.
pub fn write_image(name: &Path, image: &SensorImage) -> Result<(), Fault> {
    let (data, text) = paths(name)?;
    if image.cols == 0 || image.dn.len() != image.cols * image.rows {
        let what = format!("{} numbers are not {} rows of {}", image.dn.len(), image.rows, image.cols);
        return Err(Fault::at(&data, what, "give a whole image"));
    }
    let told = |no: atomic_file::FileError| refused(&data, &no.source);
    atomic_file::write(&partial(&data), &data, &image.dn).map_err(told)?;
    write_text(&text, &FileLayout::of_image(image.cols, image.rows, image.offset).write())
}

fn write_text(path: &Path, text: &str) -> Result<(), Fault> {
    atomic_file::write(&partial(path), path, text.as_bytes()).map_err(|no| refused(path, &no.source))
}

/// `NAME.dat` and `NAME.xml`.
fn paths(name: &Path) -> Result<(PathBuf, PathBuf), Fault> {
    let bare = match name.extension() {
        Some(extension) if extension == "dat" || extension == "xml" => name.with_extension(""),
        _ => name.to_path_buf(),
    };
    let Some(last) = bare.file_name().filter(|_| !name.is_dir()) else {
        return Err(refused(name, &ErrorKind::IsADirectory.into()));
    };
    let side = |extension| bare.with_file_name(format!("{}.{extension}", last.to_string_lossy()));
    Ok((side("dat"), side("xml")))
}

fn partial(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".tmp-{}-{name}", std::process::id()))
}

fn refused(path: &Path, error: &Error) -> Fault {
    let (what, remedy) = match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => ("the disk is full", "make room, then try again"),
        ErrorKind::IsADirectory => ("it is a folder", "give another name with --out"),
        _ => ("it cannot be written", "make the folder first, or give another name with --out"),
    };
    Fault::at(path, format!("{what}: {error}"), remedy)
}

/// The bytes of a plane; none where the scan has no such plane.
fn bytes(scan: &IconScan, part: PlaneContent) -> Vec<u8> {
    let words = |words: &[u16]| words.iter().flat_map(|n| n.to_le_bytes()).collect();
    let floats = |numbers: &[f32]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    match part {
        PlaneContent::RangeX => scan.x.as_deref().map(floats).unwrap_or_default(),
        PlaneContent::Range => match &scan.range {
            RangeValues::Steps(steps) => words(steps),
            RangeValues::World(heights) => floats(heights),
        },
        PlaneContent::Intensity | PlaneContent::Reflectance => match &scan.light {
            Some(PeakLight::Intensity(dn) | PeakLight::Reflectance(dn)) => dn.clone(),
            None => Vec::new(),
        },
        PlaneContent::Scatter => match &scan.scatter {
            Some(Scatter::Byte(dn)) => dn.clone(),
            Some(Scatter::Word(sums)) => words(sums),
            None => Vec::new(),
        },
        PlaneContent::Mark => scan.marks.iter().flatten().flat_map(mark).collect(),
        PlaneContent::Image | PlaneContent::Other => Vec::new(),
    }
}

fn mark(mark: &ProfileMark) -> Vec<u8> {
    let numbers = [mark.encoder.cast_unsigned(), mark.status, mark.timestamp, mark.pulse, mark.scan];
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}
