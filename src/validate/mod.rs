//! Validation: reads a dataset folder, believes nothing, and names each fault with its place and what to do.
//!
//! ```text
//! dataset.json -> each shard: manifest -> files -> rows -> images, EXR, labels -> (rendered again) -> Report
//! ```
//!
//! A damaged file gives a fault, never a panic. Only files whose checksum is right are opened.

mod columns;
mod exr;
mod files;
mod images;
mod labels;
mod report;
mod sample;
mod shard;
mod stack;
mod task;

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use output_schema::file::{CARD, CROISSANT, DATASET, manifest_path};
use output_schema::{DatasetHead, FORMAT, SubjectFiles, refuse_version};
use rayon::prelude::*;
use serde_json::Value;

pub use report::{Code, Fault, Report};

use crate::shard::Encoded;

/// Renders one sample again: its index -> what should be on disk, or why it cannot be rendered.
pub type Rerender<'a> = &'a (dyn Fn(u64) -> Result<Encoded, String> + Sync);

/// What to do beyond reading.
#[derive(Clone, Copy, Default)]
pub struct Options<'a> {
    /// How a sample is rendered again; `None` to compare nothing.
    pub rerender: Option<Rerender<'a>>,
    /// How many samples are rendered again, spread evenly from the first to the last.
    pub rerender_samples: u64,
}

/// Checks everything in the folder.
pub fn validate(folder: &Path, options: &Options) -> Report {
    let mut report = Report::default();
    let head = match read_head(folder) {
        Ok(head) => head,
        Err(fault) => {
            report.faults.push(fault);
            return report;
        }
    };
    let chosen = chosen(head.samples, if options.rerender.is_some() { options.rerender_samples } else { 0 });
    let parts: Vec<shard::Part> = (0..head.shards)
        .into_par_iter()
        .map(|number| {
            let rerender = options.rerender.filter(|_| !chosen.is_empty());
            shard::check(&task::Task { root: folder, head: &head, number, rerender, chosen: &chosen })
        })
        .collect();

    let mut expected = vec![DATASET.to_string(), CARD.to_string(), CROISSANT.to_string()];
    expected.extend(files::assets(folder, &head, &mut report));
    let mut ids: HashMap<String, u64> = HashMap::new();
    for (number, part) in (0..).zip(parts) {
        report.add(part.report);
        expected.push(manifest_path(number));
        expected.extend(part.files);
        for (index, id) in part.ids {
            if let Some(first) = ids.insert(id.clone(), index) {
                let what = format!("samples {first} and {index} have the same id {id}");
                report.faults.push(Fault::new(Code::IdRepeated, manifest_path(number), what));
            }
        }
    }
    report.faults.extend(files::unexpected(folder, &expected));
    report.faults.extend(files::documents(folder, &head));
    report
}

/// `count` indices below `samples`, spread evenly, the first and the last among them.
fn chosen(samples: u64, count: u64) -> Vec<u64> {
    let count = count.min(samples);
    let place = |j: u64| if count < 2 { 0 } else { j * (samples - 1) / (count - 1) };
    (0..count).map(place).collect()
}

fn read_head(folder: &Path) -> Result<DatasetHead, Fault> {
    let fault = |code, what: String| Fault::new(code, DATASET, what);
    let text =
        fs::read(folder.join(DATASET)).map_err(|e| fault(Code::DatasetMissing, format!("cannot be read: {e}")))?;
    let value: Value = serde_json::from_slice(&text).map_err(|e| fault(Code::DatasetUnreadable, e.to_string()))?;
    let format = value["format"].as_str().unwrap_or("").to_string();
    // The version first: a newer document may have other keys.
    let version = serde_json::from_value(value["schema_version"].clone()).unwrap_or([0, 0]);
    if let Some(reason) = refuse_version(&format, version) {
        let code = if format == FORMAT { Code::VersionUnknown } else { Code::DatasetUnreadable };
        return Err(fault(code, reason));
    }
    let head: DatasetHead = serde_json::from_value(value).map_err(|e| fault(Code::DatasetUnreadable, e.to_string()))?;
    let shards = DatasetHead::shards_for(head.samples, head.samples_per_shard);
    if head.samples_per_shard == 0 || head.shards != shards {
        let what =
            format!("{} samples in shards of {} are not {} shards", head.samples, head.samples_per_shard, head.shards);
        return Err(fault(Code::DatasetUnreadable, what));
    }
    let Some(subject) = SubjectFiles::named(&head.subject) else {
        return Err(fault(Code::DatasetUnreadable, format!("its subject is `{}`", head.subject)));
    };
    if (&head.pixel_classes, &head.label_values) != (&subject.pixel_classes(), &subject.label_values()) {
        let what = format!("its pixel classes are {:?}, its labels {:?}", head.pixel_classes, head.label_values);
        return Err(fault(Code::DatasetUnreadable, what));
    }
    Ok(head)
}
