//! Many pictures as one asset: the PNG files of a folder as a tar, and the PNG files in a tar.
//!
//! A dataset keeps one copy of each file that its recipe names, known by its content; a folder of slices is one file by becoming a tar, whose
//! bytes follow from the names and the contents of the pictures alone. Their order is that of their names, with numbers in them by
//! their value: `s9.png` stands before `s10.png`. Names that begin with a dot and other files are left out.

use std::cmp::Ordering;
use std::fs;
use std::io::{Cursor, Read};
use std::path::Path;

use crate::asset::{Asset, AssetFault, printable};

/// Most pictures in one.
pub(crate) const MOST_PICTURES: usize = 4096;

/// The PNG files of a folder, whose content has at most `max_bytes` in all, as a tar; `name` is what the recipe calls it.
pub(crate) fn of_folder(path: &Path, name: &str, max_bytes: usize) -> Result<Asset, AssetFault> {
    let shown = printable(&path.to_string_lossy());
    let unreadable = |e: std::io::Error| AssetFault::new(format!("`{shown}` cannot be read: {e}"), "make it readable");
    let mut names = Vec::new();
    for entry in fs::read_dir(path).map_err(unreadable)? {
        let name = entry.map_err(unreadable)?.file_name();
        let name = name.into_string().map_err(|name| {
            let problem = format!("`{}` in `{shown}` is no name of UTF-8", printable(&name.to_string_lossy()));
            AssetFault::new(problem, "give it another name")
        })?;
        if is_picture(&name) {
            names.push(name);
        }
    }
    names.sort_by(|a, b| natural(a, b));
    if names.len() > MOST_PICTURES {
        return Err(too_many(&shown, names.len()));
    }
    let mut tar = tar::Builder::new(Vec::new());
    let mut left = max_bytes;
    for name in names {
        let place = path.join(&name);
        if !fs::metadata(&place).map_err(unreadable)?.is_file() {
            return Err(AssetFault::new(format!("`{}` in `{shown}` is no plain file", printable(&name)), "remove it"));
        }
        let mut bytes = Vec::new();
        fs::File::open(&place)
            .and_then(|file| file.take(left as u64 + 1).read_to_end(&mut bytes))
            .map_err(|e| AssetFault::new(format!("`{}` cannot be read: {e}", printable(&name)), "make it readable"))?;
        left = left.checked_sub(bytes.len()).ok_or_else(|| {
            let problem = format!("the PNG files in `{shown}` have more than {max_bytes} bytes");
            AssetFault::new(problem, format!("give at most {} MB: fewer or smaller slices", max_bytes >> 20))
        })?;
        let mut header = tar::Header::new_gnu();
        header.set_size(bytes.len() as u64);
        header.set_mode(0o644);
        tar.append_data(&mut header, &name, bytes.as_slice()).map_err(unreadable)?;
    }
    let folder = name.trim_end_matches(['/', '\\']);
    Ok(Asset::new(&format!("{folder}.tar"), tar.into_inner().map_err(unreadable)?))
}

/// The PNG files in a tar, in their order, each with its name.
pub(crate) fn pictures(file: &Asset) -> Result<Vec<(String, &[u8])>, AssetFault> {
    let broken = || {
        let problem = format!("`{}` is no tar, or not a whole one", printable(file.name()));
        AssetFault::new(problem, "name a folder of PNG files, one for each slice, or a tar of them")
    };
    let mut pictures = Vec::new();
    for entry in tar::Archive::new(Cursor::new(file.bytes())).entries().map_err(|_| broken())? {
        let entry = entry.map_err(|_| broken())?;
        let name = String::from_utf8_lossy(&entry.path_bytes()).into_owned();
        if !entry.header().entry_type().is_file() || !is_picture(&name) {
            continue;
        }
        // Lengths are what the tar says: its bytes are looked at where they lie.
        let first = usize::try_from(entry.raw_file_position()).unwrap_or(usize::MAX);
        let length = usize::try_from(entry.size()).unwrap_or(usize::MAX);
        let bytes = file.bytes().get(first..first.saturating_add(length));
        pictures.push((printable(&name), bytes.ok_or_else(broken)?));
    }
    if pictures.len() > MOST_PICTURES {
        return Err(too_many(file.name(), pictures.len()));
    }
    pictures.sort_by(|a, b| natural(&a.0, &b.0));
    Ok(pictures)
}

fn too_many(name: &str, count: usize) -> AssetFault {
    let problem = format!("`{name}` has {count} PNG files, more than {MOST_PICTURES}");
    AssetFault::new(problem, "leave slices out, or average neighbours")
}

fn is_picture(name: &str) -> bool {
    let last = name.rsplit('/').next().unwrap_or(name);
    !last.starts_with('.') && last.to_ascii_lowercase().ends_with(".png")
}

/// Order of names, numbers in them by value.
fn natural(a: &str, b: &str) -> Ordering {
    let (mut left, mut right) = (a, b);
    while let (Some(x), Some(y)) = (left.chars().next(), right.chars().next()) {
        let order = if x.is_ascii_digit() && y.is_ascii_digit() {
            let [p, q] = [digits(&mut left), digits(&mut right)].map(|run| run.trim_start_matches('0'));
            p.len().cmp(&q.len()).then_with(|| p.cmp(q))
        } else {
            (left, right) = (&left[x.len_utf8()..], &right[y.len_utf8()..]);
            x.cmp(&y)
        };
        if order != Ordering::Equal {
            return order;
        }
    }
    left.len().cmp(&right.len()).then_with(|| a.cmp(b))
}

/// Takes the digits that a text begins with.
fn digits<'t>(text: &mut &'t str) -> &'t str {
    let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (run, rest) = text.split_at(end);
    *text = rest;
    run
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(files: &[(&str, &[u8])]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, bytes) in files {
            fs::write(folder.path().join(name), bytes).expect("written");
        }
        folder
    }

    #[test]
    fn a_folder_is_its_pictures_in_the_order_of_their_numbers() {
        let long = format!("{}.png", "x".repeat(180));
        let files: [(&str, &[u8]); 6] = [
            ("s10.png", b"ten"),
            ("s9.PNG", b"nine"),
            ("s009b.png", b""),
            ("notes.txt", b"no"),
            (".s1.png", b"no"),
            (&long, b"x"),
        ];
        let asset = of_folder(folder(&files).path(), "scans/pine/", 100).expect("read");
        assert_eq!(asset.name(), "pine.tar");
        let names: Vec<_> = pictures(&asset).expect("a tar").into_iter().collect();
        let wanted: [(String, &[u8]); 4] =
            [("s9.PNG".into(), b"nine"), ("s009b.png".into(), b""), ("s10.png".into(), b"ten"), (long.clone(), b"x")];
        assert_eq!(names, wanted);
        // Neither when nor where it was written matters.
        let mut other = files;
        other.reverse();
        assert_eq!(of_folder(folder(&other).path(), "pine", 100).expect("read").sha256(), asset.sha256());
    }

    #[test]
    fn what_is_too_much_or_broken_is_told() {
        let own = folder(&[("a.png", b"12345"), ("b.png", b"67890")]);
        let told = of_folder(own.path(), "own", 9).expect_err("too large").problem;
        assert!(told.contains("more than 9 bytes"), "{told}");
        let whole = of_folder(own.path(), "own", 10).expect("read");
        fs::create_dir(own.path().join("c.png")).expect("made");
        assert!(of_folder(own.path(), "own", 99).expect_err("a folder").problem.contains("`c.png`"));
        // Any part of a tar, and any byte of it spoilt, gives pictures or a fault that names the file.
        for length in 0..whole.bytes().len() {
            let cut = Asset::new("own.tar", whole.bytes()[..length].to_vec());
            if let Err(fault) = pictures(&cut) {
                assert!(fault.problem.contains("`own.tar`") && fault.remedy.contains("folder"), "{fault:?}");
            }
        }
        for at in (0..whole.bytes().len()).step_by(3) {
            let mut bytes = whole.bytes().to_vec();
            bytes[at] ^= 0x35;
            if let Err(fault) = pictures(&Asset::new("own.tar", bytes)) {
                assert!(fault.problem.contains("`own.tar`"), "{fault:?}");
            }
        }
        let many: Vec<String> = (0..=MOST_PICTURES).map(|i| format!("{i}.png")).collect();
        let files: Vec<(&str, &[u8])> = many.iter().map(|name| (name.as_str(), &b""[..])).collect();
        assert!(of_folder(folder(&files).path(), "many", 9).expect_err("too many").problem.contains("4097 PNG files"));
    }
}
