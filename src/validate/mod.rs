//! Validation: reads a dataset folder, believes nothing, and names each fault with its place and what to do.
//!
//! ```text
//! dataset.json -> each shard: manifest -> files -> rows -> images, EXR, labels -> (rendered again) -> Report
//! ```
//!
//! A damaged file gives a fault, never a panic. Only files whose checksum is right are opened.

mod columns;
mod expected;
mod exr;
mod files;
mod head;
mod images;
mod labels;
mod report;
mod sample;
mod shard;
mod stack;
mod task;

use std::collections::HashMap;
use std::path::Path;

use output_schema::DatasetHead;
use output_schema::file::{CARD, DATASET, manifest_path};
use rayon::prelude::*;

pub use expected::{Expect, Expected};
pub use report::{Code, Fault, Report};

use crate::shard::Encoded;

/// Renders one sample again: its index -> what should be on disk, or why it cannot be rendered.
pub type Rerender<'a> = &'a (dyn Fn(u64) -> Result<Encoded, String> + Sync);

/// What to do beyond reading.
#[derive(Clone, Copy, Default)]
pub struct Options<'a> {
    /// What this program makes of the dataset's recipe, or why it cannot be loaded; `None` to compare nothing.
    pub expect_head: Option<Result<&'a DatasetHead, &'a str>>,
    /// How a sample is drawn again, without rendering; `None` to compare nothing.
    pub expect: Option<Expect<'a>>,
    /// How a sample is rendered again; `None` to compare nothing.
    pub rerender: Option<Rerender<'a>>,
    /// How many samples are rendered again, spread evenly from the first to the last.
    pub rerender_samples: u64,
}

/// Checks everything in the folder.
pub fn validate(folder: &Path, options: &Options) -> Report {
    let mut report = Report::default();
    let Some(head) = head::read(folder, &mut report) else { return report };
    let comparable = options.expect_head.is_none_or(|expected| expected::head(&head, expected, &mut report));
    let expect = options.expect.filter(|_| comparable);
    let chosen = chosen(head.samples, if options.rerender.is_some() { options.rerender_samples } else { 0 });
    let parts: Vec<shard::Part> = (0..head.shards)
        .into_par_iter()
        .map(|number| {
            let rerender = options.rerender.filter(|_| !chosen.is_empty());
            shard::check(&task::Task { root: folder, head: &head, number, expect, rerender, chosen: &chosen })
        })
        .collect();

    let mut expected = vec![DATASET.to_string(), CARD.to_string()];
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
    if !folder.join(CARD).is_file() {
        report.faults.push(Fault::new(Code::FileMissing, CARD, "the dataset card is missing"));
    }
    report
}

/// `count` indices below `samples`, spread evenly, the first and the last among them.
fn chosen(samples: u64, count: u64) -> Vec<u64> {
    let count = count.min(samples);
    let place = |j: u64| if count < 2 { 0 } else { j * (samples - 1) / (count - 1) };
    (0..count).map(place).collect()
}
