//! Reader of iCon files.

use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::layout::{Component, FileLayout, Plane, PlaneContent};
use super::traits::Traits;
use super::{IconScan, PlaneNumbers, SensorImage, xml};
use dataset::Fault;

/// Longest XML that is read: cameras add their settings to it, some hundred kB [bytes].
const MAX_XML_BYTES: u64 = 16 << 20;
/// Most columns and rows that are read: no sensor is as wide, and the camera's buffers hold 16383 profiles.
const MAX_SIDES: (usize, usize) = (1 << 16, 1 << 20);
/// Most pixels that are read: as many as the largest recipe makes.
const MAX_PIXELS: usize = 1 << 27;

/// What a file holds.
#[derive(Debug)]
pub enum Content {
    /// A scan, to be read by rows.
    Scan(ScanReader),
    /// One exposure.
    Image(SensorImage),
}

/// A scan on disk.
#[derive(Debug)]
pub struct ScanReader {
    traits: Traits,
    data: DataFile,
}

/// A `.dat` and the layout of its numbers.
#[derive(Debug)]
struct DataFile {
    layout: FileLayout,
    /// Rows of every plane; all planes together are as long as the file was.
    rows: usize,
    file: File,
    path: PathBuf,
}

/// Opens `NAME.xml` and `NAME.dat`; either may be given, or `NAME`.
///
/// # Errors
/// What is wrong with one of them, where, and what to do.
pub fn open(path: &Path) -> Result<Content, Fault> {
    let known = path.extension().is_some_and(|extension| extension == "xml" || extension == "dat");
    let side = |extension: &str| {
        if known { path.with_extension(extension) } else { PathBuf::from(format!("{}.{extension}", path.display())) }
    };
    let (description, data) = (side("xml"), side("dat"));
    let layout = read_layout(&description)?;
    let unreadable = |error: std::io::Error| Fault::at(&data, format!("it cannot be read: {error}"), SIDE_BY_SIDE);
    let (file, length) = files::open_within(&data, u64::MAX).map_err(unreadable)?;
    let whole = layout.line as u64;
    if whole == 0 || !length.is_multiple_of(whole) {
        let what = format!("its {length} bytes are no whole number of rows of {whole} bytes, as its XML has them");
        return Err(Fault::at(&data, what, COPY_AGAIN));
    }
    let rows = usize::try_from(length / whole).map_err(|_| Fault::at(&data, "it is beyond memory", COPY_AGAIN))?;
    let (width, most) = (layout.width(), MAX_SIDES);
    if width > most.0 || rows > most.1 || width.saturating_mul(rows) > MAX_PIXELS {
        let what = format!(
            "its {length} bytes are {rows} rows of {width} columns; at most {} rows, {} columns and {MAX_PIXELS} \
                pixels are read",
            most.1, most.0
        );
        return Err(Fault::at(&data, what, "give a scan of that size, as the camera stores it"));
    }
    let subject = layout.subject;
    let mut data = DataFile { layout, rows, file, path: data };
    match subject {
        Component::Scan(traits) => Ok(Content::Scan(ScanReader { traits, data })),
        Component::SensorImage { rows: height, offset, plane } => {
            if height != rows {
                let what = format!("it has {rows} rows of {whole} bytes, its XML says {height}");
                return Err(Fault::at(&data.path, what, COPY_AGAIN));
            }
            let dn = data.bytes(&plane, 0, rows)?;
            Ok(Content::Image(SensorImage { cols: plane.width, rows, offset, dn }))
        }
    }
}

/// What to do about a file that is not whole.
const COPY_AGAIN: &str = "copy both files again, or have them written again";
/// What to do about a file that is not there.
const SIDE_BY_SIDE: &str = "NAME.xml and NAME.dat must lie side by side";

fn read_layout(path: &Path) -> Result<FileLayout, Fault> {
    let unreadable = |error: std::io::Error| Fault::at(path, format!("it cannot be read: {error}"), SIDE_BY_SIDE);
    let bytes = files::read(path, MAX_XML_BYTES).map_err(|error| match error.kind() {
        ErrorKind::FileTooLarge => Fault::at(path, error.to_string(), "give the .xml of a scan"),
        _ => unreadable(error),
    })?;
    let text = String::from_utf8(bytes);
    let text = text.map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Fault::at(path, format!("byte {at} is no UTF-8"), "save it as UTF-8 without other changes")
    })?;
    // Windows tools may begin with a mark of byte order.
    let read = xml::read(text.trim_start_matches('\u{feff}')).and_then(|root| FileLayout::read(&root));
    read.map_err(|wrong| {
        let place = format!("{}, line {}", path.display(), wrong.line);
        Fault::new(place, wrong.what, "correct this line, or have the file written again")
    })
}

impl ScanReader {
    /// Columns.
    pub fn width(&self) -> usize {
        self.data.layout.width()
    }

    /// Profiles.
    pub fn rows(&self) -> usize {
        self.data.rows
    }

    /// What columns and steps of Range mean.
    pub fn traits(&self) -> Traits {
        self.traits
    }

    /// Names and types of what the file holds and is not read.
    pub fn unused(&self) -> &[String] {
        &self.data.layout.unused
    }

    /// `count` rows from `first` on; fewer where the scan ends.
    ///
    /// # Errors
    /// Where the disk refuses, or the file has become shorter.
    pub fn read(&mut self, first: usize, count: usize) -> Result<IconScan, Fault> {
        let rows = count.min(self.data.rows.saturating_sub(first));
        let mut planes = Vec::new();
        for plane in self.data.layout.planes.clone() {
            if !matches!(plane.part, PlaneContent::Other | PlaneContent::Image) {
                let bytes = self.data.bytes(&plane, first, rows)?;
                planes.push((plane.part, PlaneNumbers::read(plane.kind, bytes)));
            }
        }
        Ok(IconScan { width: self.width(), rows, traits: self.traits, planes })
    }
}

impl DataFile {
    /// The bytes of some rows of a plane.
    fn bytes(&mut self, plane: &Plane, first: usize, rows: usize) -> Result<Vec<u8>, Fault> {
        let refused = |error: std::io::Error| Fault::at(&self.path, format!("it cannot be read: {error}"), COPY_AGAIN);
        let mut bytes = vec![0; rows * plane.line()];
        // A plane on its own lies the same way in either layout.
        if self.layout.planar || plane.line() == self.layout.line {
            let at = self.rows as u64 * plane.before as u64 + first as u64 * plane.line() as u64;
            self.file.seek(SeekFrom::Start(at)).map_err(refused)?;
            self.file.read_exact(&mut bytes).map_err(refused)?;
        } else {
            for (row, line) in (first as u64..).zip(bytes.chunks_exact_mut(plane.line())) {
                self.file
                    .seek(SeekFrom::Start(row * self.layout.line as u64 + plane.before as u64))
                    .map_err(refused)?;
                self.file.read_exact(line).map_err(refused)?;
            }
        }
        Ok(bytes)
    }
}
