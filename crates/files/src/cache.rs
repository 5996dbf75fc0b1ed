//! What can be made again, kept in the user's cache folder so that it need not be.
//!
//! The folder is `$SHEETLIGHT_CACHE` (empty: nothing is kept), else `sheetlight` in `$XDG_CACHE_HOME`, in `~/.cache`,
//! or on Windows in `%LOCALAPPDATA%`. Whatever goes wrong there is no fault: what cannot be read is made again, what
//! cannot be written is not kept. Whoever reads must be able to tell that the content is whole, and is what was asked
//! for. The oldest files go where all together have too many bytes.

use std::env::var_os;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime};

/// Names the folder, or none.
const VARIABLE: &str = "SHEETLIGHT_CACHE";
/// Most bytes of all files together.
const MOST_BYTES: u64 = 1 << 30;
/// Before the name of a file that is being written.
const BEGUN: &str = ".begun-";
/// Nobody writes one for so long.
const LONGEST_WRITING: Duration = Duration::from_secs(3600);

/// A folder of files that can be made again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cache {
    folder: PathBuf,
    most_bytes: u64,
}

impl Cache {
    /// That of the user; `None` where nothing shall be kept, or nobody says where.
    pub fn of_user() -> Option<Self> {
        let named = |variable: &str| var_os(variable).map(PathBuf::from).filter(|path| path.is_absolute());
        let folder = match var_os(VARIABLE) {
            Some(folder) if folder.is_empty() => return None,
            Some(folder) => PathBuf::from(folder),
            None if cfg!(windows) => named("LOCALAPPDATA")?.join("sheetlight"),
            None => named("XDG_CACHE_HOME").or_else(|| Some(named("HOME")?.join(".cache")))?.join("sheetlight"),
        };
        Some(Self::at(&folder, MOST_BYTES))
    }

    /// The folder at this path, with at most so many bytes.
    pub fn at(folder: &Path, most_bytes: u64) -> Self {
        Self { folder: folder.into(), most_bytes }
    }

    /// The content of a file that was kept.
    pub fn read(&self, name: &str) -> Option<Vec<u8>> {
        crate::read(&self.folder.join(name), self.most_bytes).ok()
    }

    /// Keeps a file of this name, which ends as all of its kind do; one that is there is replaced, and the oldest of
    /// the kind go.
    pub fn keep(&self, name: &str, content: &[u8]) {
        if content.len() as u64 <= self.most_bytes && self.write(name, content).is_ok() {
            // What cannot be listed or removed stays.
            let _ = self.shrink(name);
        }
    }

    /// The file is there as a whole or not at all.
    fn write(&self, name: &str, content: &[u8]) -> io::Result<()> {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        fs::create_dir_all(&self.folder)?;
        let partial = self.folder.join(format!("{BEGUN}{}-{number}-{name}", std::process::id()));
        let written = File::create_new(&partial).and_then(|mut file| file.write_all(content));
        written.and_then(|()| fs::rename(&partial, self.folder.join(name))).inspect_err(|_| {
            // The first error is the one to tell.
            let _ = fs::remove_file(&partial);
        })
    }

    /// Removes the oldest files of the kind of `name` until the others have few enough bytes, and what killed processes
    /// have begun.
    fn shrink(&self, name: &str) -> io::Result<()> {
        let ending = Path::new(name).extension();
        let now = SystemTime::now();
        let mut kept = Vec::new();
        for entry in fs::read_dir(&self.folder)?.flatten() {
            let (path, found) = (entry.path(), entry.metadata()?);
            if path.extension() != ending || !found.is_file() {
                continue;
            }
            let written = found.modified()?;
            if !entry.file_name().to_string_lossy().starts_with(BEGUN) {
                kept.push((written, path, found.len()));
            } else if now.duration_since(written).is_ok_and(|age| age > LONGEST_WRITING) {
                fs::remove_file(path)?;
            }
        }
        // The newest first, and of the same moment by name.
        kept.sort_unstable_by(|a, b| b.cmp(a));
        let mut bytes = 0;
        for (_, path, length) in kept {
            bytes += length;
            if bytes > self.most_bytes && !path.ends_with(name) {
                fs::remove_file(path)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is kept comes back; the oldest goes where there is too much; other files stay; where nothing can be written
    /// nothing is said.
    #[test]
    fn the_newest_are_kept() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = place.path().join("deep/cache");
        let cache = Cache::at(&folder, 100);
        assert_eq!(cache.read("a.kept"), None);
        let old = |name: &str, days: u64| {
            let written = SystemTime::now() - Duration::from_secs(86_400 * days);
            File::options()
                .write(true)
                .open(folder.join(name))
                .and_then(|file| file.set_modified(written))
                .expect("it is there");
        };
        cache.keep("a.kept", &[1; 40]);
        cache.keep("b.kept", &[2; 40]);
        old("a.kept", 2);
        old("b.kept", 3);
        fs::write(folder.join("notes.txt"), [0; 200]).expect("written");
        fs::write(folder.join(format!("{BEGUN}1-0-x.kept")), "cut").expect("written");
        fs::write(folder.join(format!("{BEGUN}2-0-y.kept")), "at work").expect("written");
        old(&format!("{BEGUN}1-0-x.kept"), 1);
        cache.keep("c.kept", &[3; 40]);
        cache.keep("large.kept", &[4; 101]);
        assert_eq!(cache.read("a.kept").as_deref(), Some(&[1; 40][..]));
        assert_eq!(cache.read("c.kept").as_deref(), Some(&[3; 40][..]));
        cache.keep("c.kept", &[5; 30]);
        assert_eq!(cache.read("c.kept").as_deref(), Some(&[5; 30][..]));
        let mut names: Vec<_> = fs::read_dir(&folder)
            .expect("it lists")
            .map(|entry| entry.expect("it lists").file_name().into_string().expect("plain"))
            .collect();
        names.sort();
        assert_eq!(names.join(" "), format!("{BEGUN}2-0-y.kept a.kept c.kept notes.txt"));
        let nowhere = Cache::at(&folder.join("notes.txt"), 100);
        nowhere.keep("a.kept", b"1");
        assert_eq!(nowhere.read("a.kept"), None);
    }
}
