//! WebDataset: tars of samples, each a run of files with one key.
//!
//! ```text
//! <split>-00000.tar:  <index>.range.png  <index>.reflectance.png  ...  <index>.json  <next index>.range.png  ...
//! ```
//!
//! Headers hold nothing of the machine: time 0, user 0, mode 644. Tars that a stopped run finished are kept: they were
//! synced before they got their names, and the order of the export is the same, so only their headers are read again.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use clap::Args;
use serde_json::{Map, json};
use tar::{Archive, EntryType, Header};

use super::export_folder::{ExportFolder, ExportSummary, GrowingFile};
use super::format::{Export, ExportFormat};
use super::png::MapOptions;
use super::sample::ExportSample;
use super::source::{Done, ExportProgress, ExportSource};
use dataset::Fault;
use optical_bench::split::Split;

/// What ends a tar: two empty blocks.
const END_OF_TAR: [u8; 1024] = [0; 1024];

pub(super) const FORMAT: ExportFormat = ExportFormat::of::<WebDataset>(
    "webdataset",
    "WebDataset",
    ["webdataset planks --out tars --tar-mb 1000", "tars for training that streams"],
);

/// WebDataset tars: every map as PNG and every number as JSON
#[derive(Debug, Args)]
struct WebDataset {
    #[command(flatten)]
    maps: MapOptions,
    /// Largest tar, in MB; a sample that is larger has one for itself
    #[arg(long, value_name = "MB", default_value_t = 500, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    tar_mb: u64,
}

/// The tars of one split: the one that grows, its size [bytes], how many are closed, and samples.
#[derive(Default)]
struct SplitTars {
    open: Option<GrowingFile>,
    size: u64,
    closed: u64,
    samples: u64,
}

impl Export for WebDataset {
    fn write(&self, source: &ExportSource, out: &Path, progress: ExportProgress) -> Result<ExportSummary, Fault> {
        let maps = self.maps.chosen(source)?;
        // A tar is closed before it grows beyond this; one sample is always in it.
        let most_bytes = self.tar_mb * 1_000_000;
        let asked = json!({"maps": maps, "most_bytes": most_bytes});
        ExportFolder::write(out, FORMAT.name, asked, source, |out| {
            let mut splits: BTreeMap<Split, SplitTars> = BTreeMap::new();
            let mut kept: BTreeMap<Split, Done> = BTreeMap::new();
            for split in Split::ALL {
                if let Some((tars, done)) = keep(&out, source, split, &maps)? {
                    kept.insert(split, done);
                    splits.insert(split, tars);
                }
            }
            let work = |sample: &ExportSample| {
                let mut files = Vec::new();
                for map in &maps {
                    entry(&mut files, sample, &format!("{}.{map}.png", sample.key), &sample.png(map)?)?;
                }
                entry(&mut files, sample, &format!("{}.json", sample.key), format!("{}\n", sample.json()).as_bytes())?;
                Ok(files)
            };
            let take = |sample: &ExportSample, files: Vec<u8>| {
                let tars = splits.entry(sample.split).or_default();
                if tars.size + files.len() as u64 + END_OF_TAR.len() as u64 > most_bytes {
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
            source.after(kept).each(&maps, work, take, progress)?;
            let mut counts = Map::new();
            for (split, mut tars) in splits {
                tars.close(&out)?;
                counts.insert(split.name().into(), json!({"tars": tars.closed, "samples": tars.samples}));
            }
            out.finish(&json!({"splits": counts}), Vec::new())
        })
    }
}

/// Name of a tar.
fn name(split: Split, number: u64) -> String {
    format!("{}-{number:05}.tar", split.name())
}

/// The tars of a split that a stopped run has finished, and what is in them; `None` where there are none, or where they
/// are not the first of this export.
fn keep(
    out: &ExportFolder,
    source: &ExportSource,
    split: Split,
    maps: &[&str],
) -> Result<Option<(SplitTars, Done)>, Fault> {
    let mut tars = SplitTars::default();
    let mut sizes = Vec::new();
    let mut last = None;
    while let Some((bytes, done)) = finished_tar(out.read(&name(split, tars.closed)), maps, last) {
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

impl SplitTars {
    fn close(&mut self, out: &ExportFolder) -> Result<(), Fault> {
        if let Some(mut tar) = self.open.take() {
            tar.push(&END_OF_TAR)?;
            out.finish_file(tar)?;
            self.closed += 1;
            self.size = 0;
        }
        Ok(())
    }
}

/// Appends a file with its header, filled up to whole blocks.
fn entry(files: &mut Vec<u8>, sample: &ExportSample, name: &str, content: &[u8]) -> Result<(), Fault> {
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

/// The size of a tar [bytes] and the samples in it: whole ones, with these maps and their JSON, in the order of indices
/// from after `before` on. `None` where there is no such tar.
fn finished_tar(file: Option<File>, maps: &[&str], before: Option<u64>) -> Option<(u64, Done)> {
    let mut file = file?;
    let (mut end, mut samples, mut last) = (0, 0, before);
    let mut wanted = Vec::new();
    for entry in Archive::new(&file).entries_with_seek().ok()? {
        let entry = entry.ok()?;
        let name = entry.path().ok()?.to_str()?.to_owned();
        if wanted.is_empty() {
            let key = name.split('.').next()?;
            let index: u64 = key.parse().ok().filter(|index| last.is_none_or(|last| *index > last))?;
            last = Some(index);
            samples += 1;
            wanted.push(format!("{key}.json"));
            wanted.extend(maps.iter().rev().map(|map| format!("{key}.{map}.png")));
        }
        if wanted.pop()? != name {
            return None;
        }
        end = entry.size().checked_next_multiple_of(512)?.checked_add(entry.raw_file_position())?;
    }
    let mut rest = Vec::new();
    file.seek(SeekFrom::Start(end)).ok()?;
    (&file).take(END_OF_TAR.len() as u64 + 1).read_to_end(&mut rest).ok()?;
    let is_whole = samples > 0 && wanted.is_empty() && rest == END_OF_TAR;
    is_whole.then_some((end + END_OF_TAR.len() as u64, Done { samples, last: last? }))
}
