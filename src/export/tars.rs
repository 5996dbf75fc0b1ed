//! Which samples a finished tar holds, by its headers alone.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use tar::Archive;

use super::source::Done;

/// What ends a tar: two empty blocks.
pub(super) const END: [u8; 1024] = [0; 1024];

/// The size of a tar [bytes] and the samples in it: whole ones, with these maps and their JSON, in the order of indices
/// from after `before` on. `None` where there is no such tar.
pub(super) fn finished(path: &Path, maps: &[&str], before: Option<u64>) -> Option<(u64, Done)> {
    let mut file = File::open(path).ok()?;
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
    (&file).take(END.len() as u64 + 1).read_to_end(&mut rest).ok()?;
    let is_whole = samples > 0 && wanted.is_empty() && rest == END;
    is_whole.then_some((end + END.len() as u64, Done { samples, last: last? }))
}
