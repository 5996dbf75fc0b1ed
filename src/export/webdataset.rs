//! WebDataset: tars of samples, each a run of files with one key.
//!
//! ```text
//! <split>-00000.tar:  <index>.range.png  <index>.reflectance.png  ...  <index>.json  <next index>.range.png  ...
//! ```
//!
//! Headers hold nothing of the machine: time 0, user 0, mode 644. Tars that a stopped run finished are kept: they were
//! synced before they got their names, and the order of the export is the same, so only their headers are read again.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use serde_json::{Map, json};
use tar::{EntryType, Header};

use super::out::Growing;
use super::png::chosen;
use super::source::Done;
use super::tars::{END, finished};
use super::{ExportError, Out, Progress, Sample, Source, Summary};
use crate::split::Split;

/// What is asked for.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Options {
    /// Maps by name; empty for all that the dataset has.
    pub maps: Vec<String>,
    /// A tar is closed before it grows beyond this; one sample is always in it [bytes].
    pub most_bytes: u64,
}

/// The tars of one split: the one that grows, its size [bytes], how many are closed, and samples.
#[derive(Default)]
struct Tars {
    open: Option<Growing>,
    size: u64,
    closed: u64,
    samples: u64,
}

/// Writes the export.
///
/// # Errors
/// Where the dataset is damaged or lacks images, or the folder cannot be written.
pub fn export(
    source: &Source,
    out: &std::path::Path,
    options: &Options,
    progress: Progress,
) -> Result<Summary, ExportError> {
    let maps = chosen(source, &options.maps)?;
    let asked = json!({"maps": maps, "most_bytes": options.most_bytes});
    Out::write(out, "webdataset", asked, source, |out| {
        let mut splits: BTreeMap<Split, Tars> = BTreeMap::new();
        let mut kept: BTreeMap<Split, Done> = BTreeMap::new();
        for split in Split::ALL {
            if let Some((tars, done)) = keep(&out, source, split, &maps)? {
                kept.insert(split, done);
                splits.insert(split, tars);
            }
        }
        let work = |sample: &Sample| {
            let mut files = Vec::new();
            for map in &maps {
                entry(&mut files, sample, &format!("{}.{map}.png", sample.key), &sample.png(map)?)?;
            }
            entry(&mut files, sample, &format!("{}.json", sample.key), format!("{}\n", sample.json()).as_bytes())?;
            Ok(files)
        };
        let take = |sample: &Sample, files: Vec<u8>| {
            let tars = match splits.entry(sample.split) {
                Entry::Occupied(entry) => entry.into_mut(),
                Entry::Vacant(entry) => entry.insert(Tars::default()),
            };
            if tars.size + files.len() as u64 + END.len() as u64 > options.most_bytes {
                tars.close(&out)?;
            }
            if tars.open.is_none() {
                tars.open = Some(out.create(&name(sample.split, tars.closed))?);
            }
            if let Some(tar) = &mut tars.open {
                tar.push(&files)?;
            }
            tars.size += files.len() as u64;
            tars.samples += 1;
            Ok(())
        };
        source.after(&kept).each(&maps, work, take, progress)?;
        let mut counts = Map::new();
        for (split, mut tars) in splits {
            tars.close(&out)?;
            counts.insert(split.name().into(), json!({"tars": tars.closed, "samples": tars.samples}));
        }
        out.finish(&json!({"splits": counts}), Vec::new())
    })
}

/// Name of a tar.
fn name(split: Split, number: u64) -> String {
    format!("{}-{number:05}.tar", split.name())
}

/// The tars of a split that a stopped run has finished, and what is in them; `None` where there are none, or where they
/// are not the first of this export.
fn keep(out: &Out, source: &Source, split: Split, maps: &[&str]) -> Result<Option<(Tars, Done)>, ExportError> {
    let mut tars = Tars::default();
    let mut sizes = Vec::new();
    let mut last = None;
    while let Some((bytes, done)) = finished(&out.root().join(name(split, tars.closed)), maps, last) {
        sizes.push(bytes);
        tars.closed += 1;
        tars.samples += done.samples;
        last = Some(done.last);
    }
    let Some(last) = last else { return Ok(None) };
    if source.up_to(split, last)? != tars.samples {
        return Ok(None);
    }
    sizes.into_iter().for_each(|bytes| out.count(bytes));
    let done = Done { samples: tars.samples, last };
    Ok(Some((tars, done)))
}

impl Tars {
    fn close(&mut self, out: &Out) -> Result<(), ExportError> {
        if let Some(mut tar) = self.open.take() {
            tar.push(&END)?;
            out.finish_file(tar)?;
            self.closed += 1;
            self.size = 0;
        }
        Ok(())
    }
}

/// Appends a file with its header, filled up to whole blocks.
fn entry(files: &mut Vec<u8>, sample: &Sample, name: &str, content: &[u8]) -> Result<(), ExportError> {
    let mut header = Header::new_ustar();
    header.set_path(name).map_err(|e| sample.fault(format!("{name} is no name for a tar: {e}")))?;
    header.set_entry_type(EntryType::Regular);
    header.set_size(content.len() as u64);
    header.set_mode(0o644);
    header.set_mtime(0);
    header.set_uid(0);
    header.set_gid(0);
    header.set_cksum();
    files.extend(header.as_bytes());
    files.extend(content);
    files.resize(files.len().next_multiple_of(512), 0);
    Ok(())
}
