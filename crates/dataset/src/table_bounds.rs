//! Bounds of tables: what the pages of a Parquet file would take, asked of their headers before any page is decoded.
//!
//! A table of kilobytes can hold gigabytes: a long text that compresses, values that are said to be repeated, lists
//! without end. Footers are not trusted either: what is added up here are the headers of the pages themselves, which
//! say how much their reader takes. Each column is bounded by what it is declared to hold in the rows of the dataset:
//!
//! | column | values in a row | bytes of a value |
//! |---|---|---|
//! | numbers | 1 | 4 or 8 |
//! | texts | 1 | [`MAX_TEXT_BYTES`] |
//! | images | 1 | a PNG of the declared size that is not compressed |
//! | lists of objects and defects | [`MAX_LISTED`] | as above |
//! | sensor frames | pixels of a frame | 4 |

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use arrow_array::cast::AsArray;
use arrow_array::{ArrayRef, RecordBatch};
use output_schema::row::{IMAGES, ROW};
use output_schema::{DatasetHead, Images};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::Type;
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData};

/// Longest text of a row, in bytes: ids have 36, paths of images and names of classes fewer than 100.
pub(crate) const MAX_TEXT_BYTES: usize = 255;
/// Most entries of a list of a row: objects are numbered from 1 to 65535.
pub(crate) const MAX_LISTED: usize = 65535;
/// Most entries of a list in a group of rows, beside those of its last row. A writer closes a group at 32 MiB, and an
/// object takes more than 32 bytes of it.
const MAX_LISTED_IN_GROUP: u64 = 1 << 20;
/// Bytes at which writers close a page [bytes].
const PAGE_BYTES: u64 = 1 << 20;
/// What a page or a column takes beside its values: levels, dictionaries, headers [bytes].
const SLACK_BYTES: u64 = 1 << 16;
/// Most pixels of sensor frames in a page, beside those of one frame [px].
const MAX_FRAME_PAGE: u64 = 1 << 26;
/// Longest footer of a short file: its schema, twice, and a group of rows [bytes].
const FOOTER_BYTES: u64 = 4 << 20;
/// The file is so many times as long as what its footer has beyond that: groups of rows are large [1].
const FOOTER_SHARE: u64 = 32;
/// Most columns of a table.
const MAX_COLUMNS: usize = 4096;
/// Longest header of a page that is read [bytes].
const MAX_HEADER_BYTES: u64 = 1 << 16;

/// What a table may hold.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TableBounds {
    /// Most rows.
    rows: u64,
    /// Pixels of an image of a row [px].
    pixels: u64,
    /// Rows of an image [px].
    lines: u64,
    /// Pixels of a sensor frame [px].
    frame: u64,
}

impl TableBounds {
    /// Of the samples of one shard.
    pub(crate) fn of_rows(head: &DatasetHead) -> Self {
        Self::new(&head.images, head.samples_per_shard.min(head.samples))
    }

    /// Of the sensor frames of one shard.
    pub(crate) fn of_frames(head: &DatasetHead) -> Self {
        // A sample has as many profiles as its images have rows, before they are binned.
        let profiles = head.recipe.canonical["scan"]["profiles"].as_u64().unwrap_or(head.images.rows).min(1 << 16);
        Self::new(&head.images, head.samples_per_shard.min(head.samples).saturating_mul(profiles))
    }

    /// Of that many rows without images.
    #[cfg(test)]
    pub(crate) fn of_count(rows: u64) -> Self {
        Self { rows, pixels: 0, lines: 0, frame: 0 }
    }

    fn new(images: &Images, rows: u64) -> Self {
        Self {
            // A row too many is told by another rule.
            rows: rows.saturating_mul(2).saturating_add(100),
            pixels: images.cols.saturating_mul(images.rows),
            lines: images.rows,
            frame: images.sensor_cols.saturating_mul(images.sensor_rows),
        }
    }

    /// Longest PNG of a row: its pixels of 16 bits as they are, a byte for each line, and blocks of deflate around them
    /// [bytes].
    fn image_bytes(&self) -> u64 {
        let raw = self.pixels.saturating_mul(2).saturating_add(self.lines);
        raw.saturating_add(raw / 16).saturating_add(SLACK_BYTES)
    }

    /// Opens a table, of which the columns that `is_wanted` names are going to be read.
    ///
    /// # Errors
    /// What is wrong with it, or too large.
    pub(crate) fn open(
        &self,
        mut file: File,
        is_wanted: &dyn Fn(&str) -> bool,
    ) -> Result<ParquetRecordBatchReaderBuilder<File>, String> {
        let whole = file.metadata().map_err(|e| e.to_string())?;
        let footer = footer_bytes(&mut file, whole.len())?;
        let most = FOOTER_BYTES + whole.len() / FOOTER_SHARE;
        if footer > most {
            return Err(format!("its footer claims {footer} bytes, at most {most} can be"));
        }
        let pages = file.try_clone().map_err(|e| e.to_string())?;
        let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|e| e.to_string())?;
        self.check(builder.metadata(), pages, whole.len(), is_wanted)?;
        Ok(builder)
    }

    /// Adds up what the pages say.
    fn check(
        &self,
        metadata: &ParquetMetaData,
        mut file: File,
        length: u64,
        is_wanted: &dyn Fn(&str) -> bool,
    ) -> Result<(), String> {
        let columns = metadata.file_metadata().schema_descr().num_columns();
        if columns > MAX_COLUMNS {
            return Err(format!("it has {columns} columns, at most {MAX_COLUMNS} are read"));
        }
        let mut rows = 0u64;
        for group in metadata.row_groups() {
            let own = u64::try_from(group.num_rows()).map_err(|_| "a group of rows has fewer than none".to_owned())?;
            rows = rows.saturating_add(own);
            if rows > self.rows {
                return Err(format!("it claims {rows} rows, a shard has {} at most", self.rows));
            }
            for column in group.columns() {
                let root = column.column_path().parts().first().map_or("", String::as_str);
                if is_wanted(root) {
                    let bound = self.column(column, own);
                    let pages = pages(&mut file, column, length)?;
                    bound.check(&pages).map_err(|what| format!("`{}`: {what}", column.column_path().string()))?;
                }
            }
        }
        Ok(())
    }

    /// What a column may hold in a group of `rows`.
    fn column(&self, column: &ColumnChunkMetaData, rows: u64) -> ColumnBound {
        let parts = column.column_path().parts();
        let root = parts.first().map_or("", String::as_str);
        let is_list = column.column_descr().max_rep_level() > 0;
        let is_frame = is_list && root == "frame";
        let sides = if parts.iter().any(|part| part == "bbox") { 4 } else { 1 };
        let in_row = match root {
            "frame" if is_list => self.frame.max(1),
            _ if is_list && ROW.iter().any(|column| column.name == root && column.kind.is_list()) => {
                MAX_LISTED as u64 * sides
            }
            _ => 1,
        };
        let image = self.image_bytes();
        let (value, longest) = match column.column_type() {
            Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY if IMAGES.contains(&root) => (image, image),
            Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY => (MAX_TEXT_BYTES as u64 + 5, 0),
            _ => (12, 0),
        };
        let mut values = rows.saturating_mul(in_row);
        if is_list && !is_frame {
            values = values.min(MAX_LISTED_IN_GROUP * sides + in_row);
        }
        // A page is closed once it is full: with the last value, or the last row of a list.
        let last = if is_list { in_row.saturating_mul(value) } else { longest };
        ColumnBound {
            values,
            page: PAGE_BYTES + SLACK_BYTES + last,
            bytes: values.saturating_mul(value).saturating_add(SLACK_BYTES),
            frame: is_frame.then_some(in_row),
        }
    }
}

/// What is too long of some rows that were decoded.
///
/// # Errors
/// Which column it is.
pub(crate) fn check_lengths(batch: &RecordBatch) -> Result<(), String> {
    let fields = batch.schema();
    let mut columns: Vec<(&str, ArrayRef)> = fields
        .fields()
        .iter()
        .zip(batch.columns())
        .map(|(field, column)| (field.name().as_str(), column.clone()))
        .collect();
    while let Some((name, column)) = columns.pop() {
        if let Some(texts) = column.as_string_opt::<i32>() {
            let longest = texts.offsets().lengths().max().unwrap_or(0);
            if longest > MAX_TEXT_BYTES {
                return Err(format!("`{name}` holds a text of {longest} bytes, at most {MAX_TEXT_BYTES} are read"));
            }
        } else if let Some(lists) = column.as_list_opt::<i32>() {
            let longest = lists.offsets().lengths().max().unwrap_or(0);
            if longest > MAX_LISTED {
                return Err(format!("`{name}` holds a list of {longest} entries, at most {MAX_LISTED} are read"));
            }
            columns.push((name, lists.values().clone()));
        } else if let Some(group) = column.as_struct_opt() {
            columns.extend(group.columns().iter().map(|child| (name, child.clone())));
        }
    }
    Ok(())
}

/// What the pages of a column may hold in one group of rows.
struct ColumnBound {
    /// Values, missing ones and empty lists included.
    values: u64,
    /// Of a page [bytes].
    page: u64,
    /// Of all pages [bytes].
    bytes: u64,
    /// Pixels of a row, for sensor frames.
    frame: Option<u64>,
}

impl ColumnBound {
    fn check(&self, pages: &[PageHeader]) -> Result<(), String> {
        let (mut values, mut bytes) = (0u64, 0u64);
        for page in pages {
            bytes = bytes.saturating_add(page.bytes);
            if page.bytes > self.page || bytes > self.bytes {
                let (claimed, most) =
                    if page.bytes > self.page { (page.bytes, self.page) } else { (bytes, self.bytes) };
                return Err(format!("its pages claim {claimed} bytes, at most {most} are declared"));
            }
            if page.is_dictionary {
                // Every value of a dictionary takes four bytes at least.
                if page.values > page.bytes / 4 {
                    return Err(format!("a dictionary of {} bytes claims {} values", page.bytes, page.values));
                }
                continue;
            }
            values = values.saturating_add(page.values);
            if values > self.values {
                return Err(format!("its pages claim {values} values, at most {} are declared", self.values));
            }
            if let Some(frame) = self.frame {
                let most = page.rows.map_or(u64::MAX, |rows| rows.saturating_mul(frame));
                if page.values > most.min(MAX_FRAME_PAGE + frame) {
                    return Err(format!("a page claims {} values, {frame} are declared in a row", page.values));
                }
            }
        }
        Ok(())
    }
}

/// Length of the footer, as the end of the file says [bytes].
fn footer_bytes(file: &mut File, length: u64) -> Result<u64, String> {
    let mut end = [0; 8];
    let mut read = || {
        file.seek(SeekFrom::Start(length.saturating_sub(8)))?;
        file.read_exact(&mut end)
    };
    read().map_err(|e| format!("its end cannot be read: {e}"))?;
    let [a, b, c, d, ..] = end;
    if &end[4..] != b"PAR1" {
        return Err("it does not end as Parquet files do".into());
    }
    let footer = u64::from(u32::from_le_bytes([a, b, c, d]));
    if footer + 12 > length { Err(format!("its footer claims {footer} of {length} bytes")) } else { Ok(footer) }
}

/// What the header of a page says.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct PageHeader {
    is_dictionary: bool,
    /// Of the page without its header, decompressed [bytes].
    bytes: u64,
    /// The same in the file [bytes].
    stored: u64,
    /// Values, missing ones included.
    values: u64,
    /// Rows, where the page says it.
    rows: Option<u64>,
}

/// The headers of all pages of a column in a group of rows.
fn pages(file: &mut File, column: &ColumnChunkMetaData, length: u64) -> Result<Vec<PageHeader>, String> {
    let name = || column.column_path().string();
    let broken = |what: String| format!("`{}`: {what}", name());
    let start = column.dictionary_page_offset().unwrap_or_else(|| column.data_page_offset());
    let range = u64::try_from(start).ok().zip(u64::try_from(column.compressed_size()).ok());
    let range = range.and_then(|(start, size)| Some((start, start.checked_add(size)?)));
    let (mut at, end) =
        range.filter(|(_, end)| *end <= length).ok_or_else(|| broken("it lies beyond the file".into()))?;
    let mut pages = Vec::new();
    let mut part = Vec::new();
    while at < end {
        let mut header = None;
        // Nearly every header is short.
        for most in [1 << 8, MAX_HEADER_BYTES] {
            part.clear();
            file.seek(SeekFrom::Start(at)).map_err(|e| e.to_string())?;
            file.by_ref().take(most.min(end - at)).read_to_end(&mut part).map_err(|e| e.to_string())?;
            header = Compact { bytes: &part, at: 0 }.page();
            if header.is_some() {
                break;
            }
        }
        let (page, header) = header.ok_or_else(|| broken(format!("the header of a page at byte {at} is damaged")))?;
        at = at.checked_add(header + page.stored).filter(|at| *at <= end).ok_or_else(|| {
            broken(format!("a page at byte {at} claims {} bytes, more than its column has", page.stored))
        })?;
        pages.push(page);
    }
    Ok(pages)
}

/// Reader of Thrift's compact protocol, as far as headers of pages go. Fields must rise, so that no reader can take
/// another one of two.
struct Compact<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// A field: its number, and its type.
type Field = (i16, u8);

impl Compact<'_> {
    /// The header of a page, and its length [bytes]; `None` where it is damaged, or goes on beyond the bytes.
    fn page(mut self) -> Option<(PageHeader, u64)> {
        let mut page = PageHeader::default();
        let (mut kind, mut sizes, mut counted) = (None, [None; 2], None);
        let mut last = 0;
        while let Some(field) = self.field(&mut last)? {
            match field {
                (1, 5) => kind = Some(self.whole()?),
                (2, 5) => sizes[0] = Some(self.whole()?),
                (3, 5) => sizes[1] = Some(self.whole()?),
                (number @ (5 | 7 | 8), 12) => counted = Some((number, self.counts()?)),
                (_, kind) => self.skip(kind, 0)?,
            }
        }
        let size = |size: Option<i64>| u64::try_from(size?).ok();
        (page.bytes, page.stored) = (size(sizes[0])?, size(sizes[1])?);
        let (number, [values, rows]) = counted?;
        page.values = size(values)?;
        page.is_dictionary = kind? == 2;
        // Data pages, pages of a dictionary, and data pages that count their rows.
        match (kind?, number) {
            (0, 5) | (2, 7) => {}
            (3, 8) => page.rows = Some(size(rows)?),
            _ => return None,
        }
        Some((page, self.at as u64))
    }

    /// Number of values, and of rows in pages that count them, of a header within a header.
    fn counts(&mut self) -> Option<[Option<i64>; 2]> {
        let (mut counts, mut last) = ([None; 2], 0);
        while let Some(field) = self.field(&mut last)? {
            match field {
                (1, 5) => counts[0] = Some(self.whole()?),
                (3, 5) => counts[1] = Some(self.whole()?),
                (_, kind) => self.skip(kind, 1)?,
            }
        }
        Some(counts)
    }

    /// The next field of a structure; the inner `None` where it ends.
    fn field(&mut self, last: &mut i16) -> Option<Option<Field>> {
        let byte = self.byte()?;
        let kind = byte & 15;
        if kind == 0 {
            return Some(None);
        }
        let number = match byte >> 4 {
            0 => i16::try_from(self.whole()?).ok()?,
            step => last.checked_add(i16::from(step))?,
        };
        if number <= *last {
            return None;
        }
        *last = number;
        Some(Some((number, kind)))
    }

    fn skip(&mut self, kind: u8, depth: usize) -> Option<()> {
        if depth > 8 {
            return None;
        }
        match kind {
            1 | 2 => Some(()),
            3 => self.byte().map(|_| ()),
            4..=6 => self.varint().map(|_| ()),
            7 => self.forward(8),
            8 => {
                let length = usize::try_from(self.varint()?).ok()?;
                self.forward(length)
            }
            12 => {
                let mut last = 0;
                while let Some((_, kind)) = self.field(&mut last)? {
                    self.skip(kind, depth + 1)?;
                }
                Some(())
            }
            // Lists and maps: headers of pages have none.
            _ => None,
        }
    }

    fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    fn forward(&mut self, count: usize) -> Option<()> {
        self.at = self.at.checked_add(count).filter(|at| *at <= self.bytes.len())?;
        Some(())
    }

    fn varint(&mut self) -> Option<u64> {
        let mut number = 0u64;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= u64::from(byte & 127) << shift;
            if byte < 128 {
                return Some(number);
            }
        }
        None
    }

    /// A whole number, whose sign is its last bit.
    fn whole(&mut self) -> Option<i64> {
        let number = self.varint()?;
        Some((number >> 1).cast_signed() ^ -((number & 1).cast_signed()))
    }
}
