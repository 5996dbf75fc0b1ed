//! Files that are small on the disk and large in memory are told before they take it.

use std::fs::{self, File};
use std::path::Path;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::{Array, ArrayRef, BinaryArray, FixedSizeListArray, Int32Array, ListArray, RecordBatch};
use arrow_array::{StringArray, StructArray, new_null_array};
use parquet::file::metadata::{ParquetMetaDataReader, ParquetMetaDataWriter};

use crate::damage::{DATA, agree, rewrite};
use crate::damaged::{after, with};
use dataset::validate::Code;
use dataset::{Dataset, RowQuery};
use test_support::records::{output, write_dataset};

/// Replaces a column of the first row.
fn with_column(rows: Vec<RecordBatch>, name: &str, column: impl Fn(&ArrayRef) -> ArrayRef) -> Vec<RecordBatch> {
    let change = |(i, batch): (usize, RecordBatch)| {
        let place = batch.schema().index_of(name).expect("the column");
        let mut columns = batch.columns().to_vec();
        if i == 0 {
            columns[place] = column(&columns[place]);
        }
        RecordBatch::try_new(batch.schema(), columns).expect("of the same type")
    };
    rows.into_iter().enumerate().map(change).collect()
}

/// A long text that compresses well, in place of the first id.
fn long_id(root: &Path) {
    let text = "x".repeat(16_000_000);
    rewrite(root, |rows| with_column(rows, "id", |_| Arc::new(StringArray::from(vec![text.as_str()]))));
}

/// Two million objects without a number in place of those of the first row.
fn many_objects(root: &Path) {
    let many = |column: &ArrayRef| -> ArrayRef {
        let (item, _, objects, _) = column.as_list::<i32>().clone().into_parts();
        let values = new_null_array(objects.data_type(), 2_000_000);
        Arc::new(ListArray::from(FixedSizeListArray::new(item, 2_000_000, values, None)))
    };
    rewrite(root, |rows| with_column(rows, "objects", many));
}

/// Gives every column of a table the footer that a column of a few bytes has.
fn lying_footer(root: &Path) {
    let path = root.join(DATA);
    let metadata = ParquetMetaDataReader::new().parse_and_finish(&File::open(&path).expect("there")).expect("Parquet");
    let bytes = fs::read(&path).expect("there");
    let footer = u32::from_le_bytes(bytes[bytes.len() - 8..][..4].try_into().expect("four")) as usize;
    let pages = bytes[..bytes.len() - 8 - footer].to_vec();
    let mut builder = metadata.into_builder();
    let groups = builder.take_row_groups().into_iter().map(|group| {
        let mut group = group.into_builder();
        let columns = group.take_columns().into_iter();
        let small = |column: parquet::file::metadata::ColumnChunkMetaData| {
            column.into_builder().set_total_uncompressed_size(64).set_num_values(1).build().expect("a column")
        };
        group.set_column_metadata(columns.map(small).collect()).set_total_byte_size(64).build().expect("a group")
    });
    let metadata = builder.set_row_groups(groups.collect()).build();
    let mut file = fs::File::create(&path).expect("ours");
    std::io::Write::write_all(&mut file, &pages).expect("ours");
    ParquetMetaDataWriter::new(&mut file, &metadata).finish().expect("a footer");
    agree(root);
}

#[test]
fn tables() {
    type Bomb = fn(&Path);
    let bombs: [(&str, Bomb, &str); 4] = [
        ("a long id", long_id, "`id`: its pages claim"),
        ("many objects", many_objects, "values, at most"),
        ("a long id with a lying footer", |root| (long_id(root), lying_footer(root)).1, "`id`: its pages claim"),
        ("many objects with a lying footer", |root| (many_objects(root), lying_footer(root)).1, "values, at most"),
    ];
    for (name, bomb, told) in bombs {
        let place = tempfile::tempdir().expect("a folder");
        write_dataset(place.path(), 4, &output());
        bomb(place.path());
        let report = crate::damaged::check(&place);
        assert!(report.codes().contains(&Code::TableUnreadable), "{name}: {report}");
        assert!(report.to_string().contains(told) && report.to_string().len() < 5_000, "{name}: {report}");
        // The one reader of all tools refuses it as well.
        let tables = Dataset::open(place.path()).and_then(|dataset| dataset.tables(None)).expect("manifests are whole");
        let table = tables.tables.iter().find(|table| table.relative == DATA).expect("the table");
        let fault = table.rows(&RowQuery::of(&|_| true)).map(|_| ()).expect_err(name).to_string();
        assert!(fault.contains(told), "{name}: {fault}");
        // Columns that are not asked for do not matter.
        assert!(table.rows(&RowQuery::of(&|column| column == "index")).is_ok(), "{name}");
    }
}

/// A header of 40 000 x 40 000 pixels.
fn huge_png(bits: u8) -> Vec<u8> {
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    png.extend([40_000_u32.to_be_bytes(), 40_000_u32.to_be_bytes()].concat());
    png.extend([bits, 0, 0, 0, 0]);
    let sum = crc(&png[12..]);
    png.extend(sum.to_be_bytes());
    png.extend(*b"\0\0\0\0IDAT");
    png.extend(crc(b"IDAT").to_be_bytes());
    png
}

/// CRC-32 as PNG has it.
fn crc(bytes: &[u8]) -> u32 {
    let step = |sum: u32| if sum & 1 == 1 { 0xedb8_8320 ^ (sum >> 1) } else { sum >> 1 };
    !bytes.iter().fold(!0, |sum, &byte| (0..8).fold(sum ^ u32::from(byte), |sum, _| step(sum)))
}

#[test]
fn pictures() {
    assert_eq!(with(|sample| sample.png[1].1 = huge_png(8)), [Code::ImageSize]);
    assert_eq!(with(|sample| sample.png[0].1 = huge_png(16)), [Code::ImageSize]);
    // A row that claims the same size does not help.
    let codes = after(|root| {
        rewrite(root, |rows| {
            let side = |_: &ArrayRef| -> ArrayRef { Arc::new(Int32Array::from(vec![40_000])) };
            let rows = with_column(with_column(rows, "cols", side), "rows", side);
            with_column(rows, "range", |column| {
                let (fields, mut children, nulls) = column.as_struct().clone().into_parts();
                children[0] = Arc::new(BinaryArray::from(vec![huge_png(16).as_slice()]));
                Arc::new(StructArray::new(fields, children, nulls))
            })
        });
    });
    assert!(codes.contains(&Code::ImageSize) && !codes.contains(&Code::ImageUnreadable), "{codes:?}");
    assert!(
        dataset::read_png_of(&huge_png(16), (48, 32)).expect_err("another size").contains("40000 x 40000, not 48 x 32")
    );
}

#[test]
fn long_files() {
    // As long as a manifest says, and longer than any: none of it takes room on the disk.
    for (path, what) in [(crate::damaged::EXR, "EXR"), (DATA, "table")] {
        let codes = after(|root| {
            fs::OpenOptions::new().write(true).open(root.join(path)).expect("there").set_len(1 << 40).expect("a hole");
            crate::damage::edit_json(&root.join(crate::damage::MANIFEST), |manifest| {
                let files = manifest["files"].as_array_mut().expect("files");
                files
                    .iter_mut()
                    .filter(|file| file["path"] == path)
                    .for_each(|file| file["bytes"] = (1_u64 << 40).into());
            });
        });
        assert!(codes.contains(&Code::FileSize), "{what}: {codes:?}");
    }
}

#[test]
fn heads() {
    for (key, value, told) in [
        ("/classes/0", serde_json::json!("x".repeat(10_000_000)), "a name of 10000000 bytes, at most"),
        ("/images/cols", serde_json::json!(1_u64 << 40), "`images.cols` is 1099511627776"),
        ("/images/sensor_rows", serde_json::json!(0), "`images.sensor_rows` is 0"),
        ("/classes", serde_json::json!(vec!["a"; 300]), "300 classes"),
    ] {
        let place = tempfile::tempdir().expect("a folder");
        write_dataset(place.path(), 4, &output());
        crate::damage::edit_json(&place.path().join("dataset.json"), |head| {
            *head.pointer_mut(key).expect("the key") = value.clone();
        });
        let report = crate::damaged::check(&place);
        assert!(report.codes() == [Code::DatasetUnreadable] && report.to_string().contains(told), "{key}: {report}");
        let fault = Dataset::open(place.path()).expect_err(key).to_string();
        assert!(fault.contains(told) && fault.len() < 1_000, "{key}: {fault}");
    }
}
