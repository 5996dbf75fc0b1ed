//! WebDataset: tars of samples, each a run of files with one key.
//!
//! ```text
//! <split>-00000.tar:  <index>.range.png  <index>.reflectance.png  ...  <index>.json  <next index>.range.png  ...
//! ```
//!
//! Headers hold nothing of the machine: time 0, user 0, mode 644.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use serde_json::{Map, json};
use tar::Header;

use super::out::Growing;
use super::png::chosen;
use super::{ExportError, Out, Progress, Sample, Source, Summary};
use crate::record::Split;

/// What is asked for.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Options {
    /// Maps by name; empty for all that the dataset has.
    pub maps: Vec<String>,
    /// A tar is closed before it grows beyond this; one sample is always in it [bytes].
    pub most_bytes: u64,
}

/// The tars of one split: the one that grows, its size [bytes], how many are closed, and samples.
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
                Entry::Vacant(entry) => entry.insert(Tars { open: None, size: 0, closed: 0, samples: 0 }),
            };
            if tars.size + files.len() as u64 + END.len() as u64 > options.most_bytes {
                tars.close(&out)?;
            }
            if tars.open.is_none() {
                tars.open = Some(out.create(&format!("{}-{:05}.tar", sample.split.name(), tars.closed))?);
            }
            if let Some(tar) = &mut tars.open {
                tar.push(&files)?;
            }
            tars.size += files.len() as u64;
            tars.samples += 1;
            Ok(())
        };
        source.each(&maps, work, take, progress)?;
        let mut counts = Map::new();
        for (split, mut tars) in splits {
            tars.close(&out)?;
            counts.insert(split.name().into(), json!({"tars": tars.closed, "samples": tars.samples}));
        }
        out.finish(&json!({"splits": counts}), Vec::new())
    })
}

/// What ends a tar: two empty blocks.
const END: [u8; 1024] = [0; 1024];

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
