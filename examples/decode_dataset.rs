//! Decodes every PNG and EXR image of a dataset once, on all cores, and does nothing with them: what `gen validate` is
//! measured against, beside `sha256sum`. Run: `cargo run --release --example decode_dataset -- DIR`.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::Instant;

use arrow_array::cast::AsArray;
use dataset::{read_exr, read_png};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use rayon::prelude::*;

type Failure = Box<dyn std::error::Error + Send + Sync>;

fn main() -> Result<(), Failure> {
    let root = PathBuf::from(std::env::args().nth(1).ok_or("name the folder of a dataset")?);
    let start = Instant::now();
    let mut files = Vec::new();
    below(&root.join("exr"), "exr", &mut files)?;
    let exr = sum(files.par_iter().map(|path| Ok(read_exr(&fs::read(path)?)?.2.len())))?;
    let mut tables = Vec::new();
    below(&root.join("data"), "parquet", &mut tables)?;
    let mut png = 0;
    for table in tables {
        let rows = ParquetRecordBatchReaderBuilder::try_new(File::open(table)?)?.with_batch_size(1).build()?;
        let images = rows.par_bridge().map(|row| {
            let row = row?;
            let structs = row.columns().iter().filter_map(|column| column.as_struct_opt());
            let bytes = structs.filter_map(|image| image.column_by_name("bytes"));
            let mut count = 0;
            for png in bytes.filter_map(|bytes| bytes.as_binary_opt::<i32>()) {
                read_png(png.value(0))?;
                count += 1;
            }
            Ok(count)
        });
        png += sum(images)?;
    }
    println!("decoded {exr} EXR channels and {png} PNG images in {:.2} s", start.elapsed().as_secs_f64());
    Ok(())
}

/// The sum of counts; the first failure ends it.
fn sum(counts: impl ParallelIterator<Item = Result<usize, Failure>>) -> Result<usize, Failure> {
    counts.try_reduce(|| 0, |a, b| Ok(a + b))
}

/// Every file below a folder that ends so; none where there is no folder.
fn below(folder: &Path, end: &str, found: &mut Vec<PathBuf>) -> Result<(), Failure> {
    if !folder.is_dir() {
        return Ok(());
    }
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            below(&path, end, found)?;
        } else if path.extension().is_some_and(|extension| extension == end) {
            found.push(path);
        }
    }
    Ok(())
}
