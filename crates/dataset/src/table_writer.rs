//! Table writer: a Parquet file that grows: encodings by column, row groups by size.

use std::io::Error;
use std::path::{Path, PathBuf};

use arrow_array::RecordBatch;
use arrow_schema::{DataType, Field, SchemaRef};
use output_schema::ManifestFile;
use output_schema::file::temporary;
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, Encoding, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::metadata::SortingColumn;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesBuilder, WriterVersion};
use parquet::schema::types::ColumnPath;

use super::GENERATOR_VERSION;
use super::atomic_file::{FileError, SummedFile};
use super::enclosed::{create, rename};

/// Row groups are closed at this size [bytes]: it bounds the memory of each open file, and readers that shuffle read
/// whole row groups.
pub(super) const ROW_GROUP_BYTES: usize = 32 << 20;

/// A Parquet file under its temporary name.
#[derive(Debug)]
pub(super) struct TableWriter {
    root: PathBuf,
    relative: String,
    partial: PathBuf,
    writer: ArrowWriter<SummedFile>,
    rows: u64,
}

impl TableWriter {
    pub(super) fn create(root: &Path, relative: String, schema: SchemaRef) -> Result<Self, FileError> {
        let partial = root.join(temporary(&relative));
        let file = SummedFile::new(create(root, &temporary(&relative))?);
        let writer =
            ArrowWriter::try_new(file, schema.clone(), Some(properties(&schema))).map_err(refused(&partial))?;
        Ok(Self { root: root.into(), relative, partial, writer, rows: 0 })
    }

    pub(super) fn write(&mut self, rows: &RecordBatch) -> Result<(), FileError> {
        let mut write = || {
            self.writer.write(rows)?;
            if self.writer.in_progress_size() >= ROW_GROUP_BYTES { self.writer.flush() } else { Ok(()) }
        };
        write().map_err(refused(&self.partial))?;
        self.rows += rows.num_rows() as u64;
        Ok(())
    }

    /// About what is still in memory [bytes].
    pub(super) fn unwritten_bytes(&self) -> u64 {
        self.writer.in_progress_size() as u64
    }

    /// Writes the footer, syncs, and gives the file its name.
    pub(super) fn finish(self) -> Result<ManifestFile, FileError> {
        let file = self.writer.into_inner().map_err(refused(&self.partial))?;
        let (bytes, sha256) = file.finish(&self.partial)?;
        rename(&self.root, &temporary(&self.relative), &self.relative)?;
        Ok(ManifestFile { path: self.relative, bytes, sha256, rows: Some(self.rows) })
    }
}

/// A refusal of the disk as such; anything else stays the [`ParquetError`] that it is.
fn refused(path: &Path) -> impl Fn(ParquetError) -> FileError {
    let write = FileError::of("write", path);
    move |error| match error {
        ParquetError::External(inner) => match inner.downcast::<Error>() {
            Ok(refusal) => write(*refusal),
            Err(inner) => write(Error::other(ParquetError::External(inner))),
        },
        error => write(Error::other(error)),
    }
}

/// Images are compressed already: plain and unpacked. Floats: bytes of equal place together, then zstd.
fn properties(schema: &SchemaRef) -> WriterProperties {
    // Level 3 is within the range that zstd knows.
    let zstd = ZstdLevel::try_new(3).map_or(Compression::UNCOMPRESSED, Compression::ZSTD);
    let index = schema.index_of("index").unwrap_or(0) as i32;
    let mut builder = WriterProperties::builder()
        .set_writer_version(WriterVersion::PARQUET_2_0)
        .set_created_by(format!("sheetlight {GENERATOR_VERSION}"))
        .set_compression(zstd)
        .set_max_row_group_row_count(None)
        .set_sorting_columns(Some(vec![SortingColumn { column_idx: index, descending: false, nulls_first: false }]));
    for field in schema.fields() {
        builder = leaf_properties(builder, field, &mut Vec::new());
    }
    builder.build()
}

fn leaf_properties(builder: WriterPropertiesBuilder, field: &Field, path: &mut Vec<String>) -> WriterPropertiesBuilder {
    path.push(field.name().clone());
    let leaf = ColumnPath::from(path.clone());
    let builder = match field.data_type() {
        DataType::Float64 => builder
            .set_column_dictionary_enabled(leaf.clone(), false)
            .set_column_encoding(leaf, Encoding::BYTE_STREAM_SPLIT),
        DataType::Binary => builder
            .set_column_dictionary_enabled(leaf.clone(), false)
            .set_column_encoding(leaf.clone(), Encoding::PLAIN)
            .set_column_compression(leaf.clone(), Compression::UNCOMPRESSED)
            .set_column_statistics_enabled(leaf, EnabledStatistics::None),
        DataType::UInt8 | DataType::UInt16 => builder.set_column_statistics_enabled(leaf, EnabledStatistics::None),
        DataType::Struct(fields) => fields.iter().fold(builder, |builder, field| leaf_properties(builder, field, path)),
        DataType::List(item) | DataType::FixedSizeList(item, _) => {
            path.push("list".into());
            let builder = leaf_properties(builder, item, path);
            path.pop();
            builder
        }
        _ => builder,
    };
    path.pop();
    builder
}
