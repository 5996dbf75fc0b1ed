//! Each kind of damage is reported as that kind, and nothing panics.

mod shard_support;

use std::fs::{self, File};
use std::path::Path;
use std::sync::Arc;

use arrow_array::RecordBatch;
use output_schema::{DatasetHead, Manifest};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use serde_json::Value;
use sha2::{Digest, Sha256};
use shard_support::{SIZE, encoded, head, output, write_dataset};
use sheetlight::settings::Channel;
use sheetlight::shard::{
    DatasetFolder, Encoded, ExrChannel, Grey, Samples, ShardWriter, read_exr, read_png, write_exr, write_png,
};
use sheetlight::validate::{Code, Options, Report, validate};
use tempfile::TempDir;

const DATA: &str = "data/train-00000.parquet";
const EXR: &str = "exr/00000/00000000-0000-5000-8000-000000000002.exr";
const MANIFEST: &str = "shards/00000.json";

fn check(place: &TempDir) -> Report {
    let report = validate(place.path(), &Options::default());
    // Both forms can be made of every report.
    assert_eq!(report.json()["faults"].as_array().map(Vec::len), Some(report.faults.len()));
    assert!(report.to_string().contains("faults"));
    report
}

/// A dataset of four samples, then `damage`, then what validation says.
fn after(damage: impl Fn(&Path)) -> Vec<Code> {
    let place = tempfile::tempdir().expect("a folder");
    write_dataset(place.path(), 4, &output());
    damage(place.path());
    check(&place).codes()
}

/// A dataset whose sample 2 was changed before it was written.
fn with(change: impl Fn(&mut Encoded)) -> Vec<Code> {
    let place = tempfile::tempdir().expect("a folder");
    let folder = DatasetFolder::open_or_create(place.path(), head(&output(), &SIZE, 4)).expect("it opens");
    let mut writer = ShardWriter::create(&folder, 0).expect("the shard is free");
    for index in 0..4 {
        let mut sample = encoded(index, &output());
        if index == 2 {
            change(&mut sample);
        }
        writer.push(sample).expect("it is written");
    }
    writer.finish().expect("it is finished");
    check(&place).codes()
}

fn edit_json(path: &Path, change: impl Fn(&mut Value)) {
    let mut value: Value = serde_json::from_slice(&fs::read(path).expect("it is there")).expect("it is JSON");
    change(&mut value);
    fs::write(path, value.to_string()).expect("it can be written");
}

/// Makes the manifest agree with the files again, so that only their content is at fault.
fn agree(root: &Path) {
    let path = root.join(MANIFEST);
    let mut manifest: Manifest =
        serde_json::from_slice(&fs::read(&path).expect("it is there")).expect("it is a manifest");
    for file in &mut manifest.files {
        let bytes = fs::read(root.join(&file.path)).expect("it is there");
        file.bytes = bytes.len() as u64;
        file.sha256 = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    }
    fs::write(path, serde_json::to_vec(&manifest).expect("plain data")).expect("it can be written");
}

/// Rewrites the rows of `DATA`.
fn rewrite(root: &Path, change: impl Fn(Vec<RecordBatch>) -> Vec<RecordBatch>) {
    let file = File::open(root.join(DATA)).expect("it is there");
    let reader = ParquetRecordBatchReaderBuilder::try_new(file).expect("it is Parquet");
    // Batches come without the metadata of the file's schema.
    let schema = reader.schema().clone();
    let whole = |batch: RecordBatch| RecordBatch::try_new(schema.clone(), batch.columns().to_vec()).expect("same");
    let rows = reader.with_batch_size(1).build().expect("it is Parquet");
    let rows = change(rows.map(|batch| whole(batch.expect("it can be read"))).collect());
    let file = File::create(root.join(DATA)).expect("it can be written");
    let mut writer = ArrowWriter::try_new(file, rows[0].schema(), None).expect("a writer");
    rows.iter().for_each(|batch| writer.write(batch).expect("it is written"));
    writer.close().expect("it is closed");
    agree(root);
}

fn png(sample: &mut Encoded, channel: Channel, change: impl Fn(&mut Vec<u16>)) {
    let place = sample.png.iter().position(|(c, _)| *c == channel).expect("the output asks for it");
    let (cols, _, image) = read_png(&sample.png[place].1).expect("it was just written");
    let mut numbers = image.numbers();
    change(&mut numbers);
    let grey = match image {
        Grey::Eight(_) => Grey::Eight(numbers.iter().map(|&n| n as u8).collect()),
        Grey::Sixteen(_) => Grey::Sixteen(numbers),
    };
    sample.png[place].1 = write_png(&grey, cols as usize);
}

fn exr(sample: &mut Encoded, change: impl Fn(&mut Vec<ExrChannel>)) {
    let (cols, _, mut channels, text) =
        read_exr(sample.exr.as_deref().expect("the output asks for it")).expect("it was just written");
    change(&mut channels);
    let description = serde_json::from_str(&text).expect("it is JSON");
    sample.exr = Some(write_exr(channels, cols, (0.04, 0.068), &description));
}

#[test]
fn documents() {
    use Code::*;
    assert_eq!(after(|root| fs::remove_file(root.join("dataset.json")).expect("there")), [DatasetMissing]);
    assert_eq!(after(|root| fs::write(root.join("dataset.json"), "[").expect("written")), [DatasetUnreadable]);
    assert_eq!(
        after(|root| edit_json(&root.join("dataset.json"), |v| v["format"] = "tiff".into())),
        [DatasetUnreadable]
    );
    assert_eq!(after(|root| edit_json(&root.join("dataset.json"), |v| v["shards"] = 7.into())), [DatasetUnreadable]);
    let newer = |v: &mut Value| v["schema_version"] = serde_json::json!([2, 0]);
    assert_eq!(after(|root| edit_json(&root.join("dataset.json"), newer)), [VersionUnknown]);
    assert!(after(|root| fs::remove_file(root.join(MANIFEST)).expect("there")).contains(&ManifestMissing));
    assert!(after(|root| fs::write(root.join(MANIFEST), "{}").expect("written")).contains(&ManifestUnreadable));
    assert_eq!(after(|root| edit_json(&root.join(MANIFEST), |v| v["seed"] = 5.into())), [ManifestDiffers]);
    assert_eq!(after(|root| edit_json(&root.join(MANIFEST), |v| v["count"] = 3.into())), [ManifestDiffers]);
    assert_eq!(after(|root| edit_json(&root.join(MANIFEST), newer)), [ManifestDiffers]);
    let outside = |v: &mut Value| v["files"][0]["path"] = "../../etc/passwd".into();
    assert!(after(|root| edit_json(&root.join(MANIFEST), outside)).contains(&ManifestDiffers));
}

#[test]
fn files() {
    use Code::*;
    for path in [DATA, EXR, "stacks/00000.parquet"] {
        assert!(after(|root| fs::remove_file(root.join(path)).expect("there")).contains(&FileMissing), "{path}");
        let cut = |root: &Path| {
            let bytes = fs::read(root.join(path)).expect("there");
            fs::write(root.join(path), &bytes[..bytes.len() / 2]).expect("written");
        };
        assert_eq!(after(cut), [FileSize], "{path}");
        for place in [10, 1000, 4000] {
            let flip = |root: &Path| {
                let mut bytes = fs::read(root.join(path)).expect("there");
                let at = place.min(bytes.len() - 5);
                bytes[at] ^= 4;
                fs::write(root.join(path), bytes).expect("written");
            };
            assert_eq!(after(flip), [FileChecksum], "{path}");
        }
    }
    assert_eq!(after(|root| fs::remove_file(root.join("README.md")).expect("there")), [FileMissing]);
    for path in ["notes.txt", "data/train-00009.parquet", "shards/.tmp-00000.json", "exr/00000/x.exr"] {
        assert_eq!(after(|root| fs::write(root.join(path), "x").expect("written")), [FileUnexpected], "{path}");
    }
}

#[test]
fn damage_that_the_manifest_agrees_with_never_panics() {
    let place = tempfile::tempdir().expect("a folder");
    write_dataset(place.path(), 4, &output());
    for path in [DATA, EXR, "stacks/00000.parquet"] {
        let good = fs::read(place.path().join(path)).expect("there");
        for step in 0..60 {
            let mut bytes = good.clone();
            let at = (step * 7919 + 4) % bytes.len();
            bytes[at] = bytes[at].wrapping_add(1 + step as u8);
            if step % 7 == 0 {
                bytes.truncate(at);
            }
            fs::write(place.path().join(path), bytes).expect("written");
            agree(place.path());
            check(&place);
        }
        fs::write(place.path().join(path), good).expect("written");
    }
    agree(place.path());
    assert!(check(&place).is_clean());
}

#[test]
fn tables() {
    use Code::*;
    let garbage = |path: &'static str| {
        after(move |root| {
            fs::write(root.join(path), "PAR1 and no more").expect("written");
            agree(root);
        })
    };
    assert_eq!(garbage(DATA), [TableUnreadable]);
    assert_eq!(garbage("stacks/00000.parquet"), [TableUnreadable]);
    assert_eq!(garbage(EXR), [ExrUnreadable, SampleChecksum]);
    let fewer = |rows: Vec<RecordBatch>| rows[..1].to_vec();
    assert_eq!(after(|root| rewrite(root, fewer)), [RowCount]);
    let swapped = |rows: Vec<RecordBatch>| vec![rows[1].clone(), rows[0].clone()];
    assert_eq!(after(|root| rewrite(root, swapped)), [IndexOrder]);
    let longer = |rows: Vec<RecordBatch>| vec![rows[0].clone(), rows[1].clone(), rows[1].clone()];
    assert_eq!(after(|root| rewrite(root, longer)), [RowCount, IndexOrder]);
    let narrow = |rows: Vec<RecordBatch>| {
        let all: Vec<usize> = (0..rows[0].num_columns() - 1).collect();
        rows.iter().map(|batch| batch.project(&all).expect("columns")).collect()
    };
    assert_eq!(after(|root| rewrite(root, narrow)), [SchemaDiffers]);
    let bare = |rows: Vec<RecordBatch>| {
        let schema = Arc::new(rows[0].schema().as_ref().clone().with_metadata([("a", "b")]));
        rows.into_iter().map(|b| RecordBatch::try_new(schema.clone(), b.columns().to_vec()).expect("same")).collect()
    };
    assert_eq!(after(|root| rewrite(root, bare)), [SchemaDiffers], "without the metadata, images do not decode");
    let empty = |rows: Vec<RecordBatch>| {
        let mut columns = rows[0].columns().to_vec();
        columns[7] = arrow_array::new_null_array(columns[7].data_type(), 1);
        vec![RecordBatch::try_new(rows[0].schema(), columns).expect("same"), rows[1].clone()]
    };
    assert_eq!(after(|root| rewrite(root, empty)), [NumberMissing]);
    let strange = |rows: Vec<RecordBatch>| {
        let mut columns = rows[0].columns().to_vec();
        columns[4] = Arc::new(arrow_array::Int64Array::from(vec![9]));
        vec![RecordBatch::try_new(rows[0].schema(), columns).expect("same"), rows[1].clone()]
    };
    assert_eq!(after(|root| rewrite(root, strange)), [ClassUnknown]);
}

#[test]
fn rows_against_manifest_and_head() {
    use Code::*;
    assert_eq!(
        after(|root| edit_json(&root.join(MANIFEST), |v| v["samples"][1]["class"] = "clear".into())),
        [RowDiffers]
    );
    let sum = "0".repeat(64);
    assert_eq!(
        after(|root| edit_json(&root.join(MANIFEST), |v| v["samples"][2]["sha256"] = sum.as_str().into())),
        [SampleChecksum]
    );
    let one_class = |v: &mut Value| v["classes"] = serde_json::json!(["clear"]);
    assert!(after(|root| edit_json(&root.join("dataset.json"), one_class)).contains(&SchemaDiffers));
    let id = encoded(0, &output()).id;
    let place = tempfile::tempdir().expect("a folder");
    write_dataset(place.path(), 4, &output());
    edit_json(&place.path().join(MANIFEST), |v| v["samples"][2]["id"] = id.as_str().into());
    let codes = check(&place).codes();
    assert!(codes.contains(&IdRepeated) && codes.contains(&RowDiffers), "{codes:?}");
    assert_eq!(with(|sample| sample.row_mm = -1.0), [ValueRange]);
    assert!(with(|sample| sample.range_scale_mm = f64::NAN).contains(&ValueRange));
    assert_eq!(with(|sample| sample.draws[0].1 = f64::NAN), [NumberMissing]);
}

#[test]
fn images() {
    use Code::*;
    assert_eq!(with(|sample| sample.png[1].1.truncate(60)), [ImageUnreadable]);
    assert_eq!(with(|sample| sample.png[4].1 = write_png(&Grey::Sixteen(vec![0; 12]), 4)), [ImageSize]);
    let shallow = |sample: &mut Encoded| sample.png[4].1 = write_png(&Grey::Eight(vec![0; 48 * 32]), 48);
    assert_eq!(with(shallow), [ImageSize]);
    // Light without range: the EXR file disagrees too.
    let dark = |n: &mut Vec<u16>| n[100] = 0;
    assert_eq!(with(|sample| png(sample, Channel::Range, dark)), [MissingRule, ExrDiffers]);
    assert_eq!(with(|sample| png(sample, Channel::Range, |n| n[100] += 5)), [ExrDiffers]);
    assert_eq!(with(|sample| png(sample, Channel::Label, |n| n[100] = 77)), [LabelUnknown, ExrDiffers]);
}

#[test]
fn labels() {
    use Code::*;
    assert_eq!(with(|sample| sample.objects[0].area_px += 1), [ObjectDiffers]);
    assert_eq!(with(|sample| sample.objects[0].bbox[0] += 1), [ObjectDiffers]);
    assert_eq!(with(|sample| sample.objects[0].bbox[2] = 4000), [ValueRange, ObjectDiffers]);
    assert_eq!(with(|sample| sample.objects.truncate(1)), [ObjectDiffers]);
    assert_eq!(with(|sample| sample.objects.reverse()), [ObjectDiffers]);
    let swap = |sample: &mut Encoded| sample.class_area_px.swap(1, 2);
    assert_eq!(with(swap), [ClassAreaDiffers]);
    assert_eq!(with(|sample| png(sample, Channel::Instance, |n| n[0] = 9)), [ObjectDiffers, ExrDiffers]);
}

#[test]
fn exr_files() {
    use Code::*;
    assert_eq!(with(|sample| exr(sample, |channels| _ = channels.pop())), [ExrChannels]);
    assert_eq!(with(|sample| exr(sample, |channels| channels[0].name = "Aha".into())), [ExrChannels]);
    let float = |channels: &mut Vec<ExrChannel>| channels[4].samples = Samples::Float(channels[4].numbers());
    assert_eq!(with(|sample| exr(sample, float)), [ExrChannels]);
    let shift = |channels: &mut Vec<ExrChannel>| {
        let range = channels[5].numbers().iter().map(|z| z + 0.0012).collect();
        channels[5].samples = Samples::Float(range);
    };
    assert_eq!(with(|sample| exr(sample, shift)), [ExrDiffers]);
    let steep = |channels: &mut Vec<ExrChannel>| channels[1].samples = Samples::Half(vec![120.0; 48 * 32]);
    assert_eq!(with(|sample| exr(sample, steep)), [ValueRange]);
    assert_eq!(with(|sample| sample.exr = encoded(3, &output()).exr), [ExrDiffers]);
}

#[test]
fn sensor_frames() {
    assert_eq!(with(|sample| _ = sample.stack.pop()), [Code::StackDiffers]);
    assert_eq!(with(|sample| sample.stack[1].profile = 9), [Code::StackDiffers]);
    assert_eq!(with(|sample| sample.stack.swap(0, 1)), [Code::StackDiffers]);
}

#[test]
fn rendered_again() {
    let place = tempfile::tempdir().expect("a folder");
    write_dataset(place.path(), 4, &output());
    let run = |render: &(dyn Fn(u64) -> Result<Encoded, String> + Sync)| {
        validate(place.path(), &Options { rerender: Some(render), rerender_samples: 9 })
    };
    assert_eq!(run(&|i| Ok(encoded(i, &output()))).codes(), []);
    assert_eq!(run(&|i| Err(format!("no recipe for {i}"))).codes(), [Code::RerenderFailed]);
    let other = run(&|i| {
        let mut sample = encoded(i, &output());
        sample.draws[0].1 += 1e-9;
        Ok(sample)
    });
    assert_eq!((other.codes(), other.rerendered), (vec![Code::RerenderDiffers], 4));
    assert!(other.faults[0].what.contains("laser"), "{other}");
}

#[test]
fn an_unfinished_dataset_says_which_shards_are_missing() {
    let place = tempfile::tempdir().expect("a folder");
    write_dataset(place.path(), 4, &output());
    DatasetFolder::open_or_create(place.path(), head(&output(), &SIZE, 12)).expect("it opens");
    let report = check(&place);
    assert_eq!(report.codes(), [Code::ManifestMissing]);
    assert_eq!(report.faults.len(), 2);
    let head: DatasetHead =
        serde_json::from_slice(&fs::read(place.path().join("dataset.json")).expect("there")).expect("a head");
    assert_eq!(head.shards, 3);
}
