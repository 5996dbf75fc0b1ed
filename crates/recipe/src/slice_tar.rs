//! Many pictures as one asset: the PNG files of a folder as a tar, and the PNG files in a tar.
//!
//! A dataset keeps one copy of each file that its recipe names, known by its content; a folder of slices is one file by
//! becoming a tar, whose bytes follow from the names and the contents of the pictures alone. Their order is that of
//! their names, with numbers in them by their value: `s9.png` stands before `s10.png`. Names that begin with a dot and
//! other files are left out. Of a picture that a tar has twice the last one counts, as for tar itself, which appends
//! what is new; links, pictures in more than one folder and a tar without its end are refused.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{Cursor, ErrorKind};
use std::path::Path;

use crate::asset::{Asset, AssetFault, printable};

/// Most pictures in one.
pub(crate) const MOST_PICTURES: usize = 4096;
/// Tars are made of blocks of so many bytes.
const TAR_BLOCK: usize = 512;

/// The PNG files of a folder, whose content has at most `max_bytes` in all, as a tar; `name` is what the recipe calls
/// it.
pub(crate) fn of_folder(path: &Path, name: &str, max_bytes: usize) -> Result<Asset, AssetFault> {
    let shown = printable(&path.to_string_lossy());
    let unreadable = |e: std::io::Error| AssetFault::new(format!("`{shown}` cannot be read: {e}"), "make it readable");
    let mut names = Vec::new();
    for entry in fs::read_dir(path).map_err(unreadable)? {
        let name = entry.map_err(unreadable)?.file_name();
        if is_picture(&name.to_string_lossy()) {
            names.push(name.into_string().map_err(|name| no_utf8(&name.to_string_lossy(), &shown))?);
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
        let unread = |e: std::io::Error| {
            let problem = format!("`{}` in `{shown}` cannot be read: {e}", printable(&name));
            let is_link = fs::symlink_metadata(&place).is_ok_and(|found| found.is_symlink());
            let remedy = match e.kind() {
                _ if is_link => "it is a link: mend or remove it",
                ErrorKind::Other => "remove it",
                _ => "make it readable",
            };
            AssetFault::new(problem, remedy)
        };
        let bytes = files::read_start(&place, left as u64 + 1).map_err(unread)?;
        left = left.checked_sub(bytes.len()).ok_or_else(|| {
            let problem = format!("the PNG files in `{shown}` have more than {max_bytes} bytes");
            AssetFault::new(problem, format!("give at most {} MB: fewer or smaller slices", max_bytes >> 20))
        })?;
        let mut header = tar::Header::new_gnu();
        header.set_size(bytes.len() as u64);
        header.set_mode(0o644);
        tar.append_data(&mut header, &name, bytes.as_slice()).map_err(unreadable)?;
    }
    // `.` and `..` are no name that a copy can have.
    let folder =
        Path::new(name.trim_end_matches(['/', '\\'])).file_name().map_or("stack".into(), |own| own.to_string_lossy());
    Ok(Asset::new(&format!("{folder}.tar"), tar.into_inner().map_err(unreadable)?))
}

/// The PNG files in a tar, in their order, each with its name; `called` is what the recipe calls the tar, or the folder
/// that it was made of.
pub(crate) fn pictures<'f>(file: &'f Asset, called: &str) -> Result<Vec<(String, &'f [u8])>, AssetFault> {
    let bytes = file.bytes();
    let broken = || {
        let problem = format!("`{called}` is no tar, or not a whole one");
        AssetFault::new(problem, "name a folder of PNG files, one for each slice, or a tar of them")
    };
    let mut archive = tar::Archive::new(Cursor::new(bytes));
    let mut pictures = BTreeMap::new();
    for entry in archive.entries().map_err(|_| broken())? {
        let entry = entry.map_err(|_| broken())?;
        let path = entry.path_bytes();
        if !is_picture(&String::from_utf8_lossy(&path)) {
            continue;
        }
        let name = std::str::from_utf8(&path).map_err(|_| no_utf8(&String::from_utf8_lossy(&path), called))?;
        if !entry.header().entry_type().is_file() {
            let problem = format!("`{}` in `{called}` is a link, or no plain file", printable(name));
            let remedy = "write the tar anew with files in the place of links (`tar --dereference \
                --hard-dereference`), or \
                          name the folder itself";
            return Err(AssetFault::new(problem, remedy));
        }
        let name = name.split('/').filter(|part| !matches!(*part, "" | ".")).collect::<Vec<_>>().join("/");
        // Lengths are what the tar says: its bytes are looked at where they lie.
        let first = usize::try_from(entry.raw_file_position()).unwrap_or(usize::MAX);
        let length = usize::try_from(entry.size()).unwrap_or(usize::MAX);
        pictures.insert(name, bytes.get(first..first.saturating_add(length)).ok_or_else(broken)?);
    }
    // The first of two blocks of zeros was read, or nothing is left.
    let rest = usize::try_from(archive.into_inner().position()).ok().and_then(|end| bytes.get(end..)).unwrap_or(&[]);
    if rest.len() < TAR_BLOCK {
        let problem = format!("`{called}` is not a whole tar: the two blocks of zeros at its end are missing");
        return Err(AssetFault::new(problem, "copy or write it anew, or name a folder of PNG files"));
    }
    if rest.iter().any(|byte| *byte != 0) {
        let problem = format!("`{called}` goes on behind the end of a tar, and what follows is not read");
        return Err(AssetFault::new(problem, "write all slices into one tar, or name a folder of PNG files"));
    }
    if pictures.len() > MOST_PICTURES {
        return Err(too_many(called, pictures.len()));
    }
    let folders: BTreeSet<&str> =
        pictures.keys().map(|name| name.rsplit_once('/').map_or(".", |(own, _)| own)).collect();
    if let [one, other, ..] = folders.into_iter().collect::<Vec<_>>()[..] {
        let problem = format!(
            "`{called}` has PNG files in more than one folder: `{}` and `{}`",
            printable(one),
            printable(other)
        );
        return Err(AssetFault::new(problem, "give a tar of one folder with all slices of one stack"));
    }
    let mut pictures: Vec<_> = pictures.into_iter().collect();
    pictures.sort_by(|a, b| natural(&a.0, &b.0));
    Ok(pictures)
}

fn no_utf8(name: &str, called: &str) -> AssetFault {
    AssetFault::new(format!("`{}` in `{called}` is no name of UTF-8", printable(name)), "give it another name")
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
        let names: Vec<_> = pictures(&asset, "pine").expect("a tar").into_iter().collect();
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
        // Any part of a tar, and any byte of it spoilt, gives pictures or a fault that names it.
        for length in 0..whole.bytes().len() {
            let cut = Asset::new("own.tar", whole.bytes()[..length].to_vec());
            let fault = pictures(&cut, "own").expect_err("not whole");
            assert!(fault.problem.contains("`own`") && fault.remedy.contains("folder"), "{fault:?}");
        }
        for at in (0..whole.bytes().len()).step_by(3) {
            let mut bytes = whole.bytes().to_vec();
            bytes[at] ^= 0x35;
            if let Err(fault) = pictures(&Asset::new("own.tar", bytes), "own") {
                assert!(fault.problem.contains("`own`"), "{fault:?}");
            }
        }
        let twice = [whole.bytes(), whole.bytes()].concat();
        assert!(
            pictures(&Asset::new("own.tar", twice), "own").expect_err("two").problem.contains("goes on behind the end")
        );
        let many: Vec<String> = (0..=MOST_PICTURES).map(|i| format!("{i}.png")).collect();
        let files: Vec<(&str, &[u8])> = many.iter().map(|name| (name.as_str(), &b""[..])).collect();
        assert!(of_folder(folder(&files).path(), "many", 9).expect_err("too many").problem.contains("4097 PNG files"));
    }

    /// A tar of these members: name, kind and content, or what a link leads to.
    fn tar_of(members: &[(&str, tar::EntryType, &str)]) -> Asset {
        let mut tar = tar::Builder::new(Vec::new());
        for (name, kind, content) in members {
            let mut header = tar::Header::new_gnu();
            header.set_entry_type(*kind);
            if kind.is_file() {
                header.set_size(content.len() as u64);
                tar.append_data(&mut header, name, content.as_bytes()).expect("written");
            } else {
                header.set_size(0);
                tar.append_link(&mut header, name, content).expect("written");
            }
        }
        Asset::new("own.tar", tar.into_inner().expect("written"))
    }

    #[test]
    fn members_of_tars_are_the_last_of_their_name_in_one_folder() {
        use tar::EntryType::{Link, Regular, Symlink};
        fn file(name: &str) -> (&str, tar::EntryType, &str) {
            (name, Regular, "old")
        }
        // Names are longer than what a message shows of them, and the order is theirs.
        let folder = format!("{}/{}", "x".repeat(100), "y".repeat(150));
        let [nine, ten] = ["s9.png", "s10.png"].map(|name| format!("{folder}/{name}"));
        let long = tar_of(&[file(&ten), file(&nine)]);
        let names: Vec<_> = pictures(&long, "own").expect("a tar").into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, [nine, ten]);
        let appended = tar_of(&[file("scan/a.png"), file("scan/b.png"), ("./scan/a.png", Regular, "new")]);
        let wanted: [(String, &[u8]); 2] = [("scan/a.png".into(), b"new"), ("scan/b.png".into(), b"old")];
        assert_eq!(pictures(&appended, "own").expect("a tar"), wanted);
        for (kind, target) in [(Link, "a.png"), (Symlink, "a.png")] {
            let fault = pictures(&tar_of(&[file("a.png"), ("b.png", kind, target)]), "own").expect_err("a link");
            assert!(fault.problem.contains("`b.png`") && fault.remedy.contains("--dereference"), "{fault:?}");
            assert_eq!(pictures(&tar_of(&[file("a.png"), ("b.txt", kind, target)]), "own").expect("a tar").len(), 1);
        }
        let fault = pictures(&tar_of(&[file("a/1.png"), file("b/1.png")]), "own").expect_err("two folders");
        assert!(fault.problem.contains("more than one folder: `a` and `b`"), "{fault:?}");
    }

    #[test]
    fn copies_of_folders_have_their_names() {
        let own = folder(&[("a.png", b"1")]);
        for (name, wanted) in
            [("scan", "scan.tar"), ("../my scans/", "my scans.tar"), (".", "stack.tar"), ("..", "stack.tar")]
        {
            assert_eq!(of_folder(own.path(), name, 9).expect("read").name(), wanted);
        }
    }

    #[cfg(unix)]
    #[test]
    fn faults_name_the_slice_and_others_do_not_count() {
        use std::os::unix::ffi::OsStrExt;
        let own = folder(&[("a.png", b"1")]);
        fs::write(own.path().join(std::ffi::OsStr::from_bytes(b"notes\xff.txt")), b"no").expect("written");
        assert!(of_folder(own.path(), "own", 9).is_ok());
        for target in ["nowhere", "s99.png"] {
            let link = own.path().join("s99.png");
            std::os::unix::fs::symlink(target, &link).expect("made");
            let fault = of_folder(own.path(), "own", 9).expect_err("no file");
            assert!(fault.problem.contains("`s99.png`") && fault.remedy.contains("link"), "{fault:?}");
            fs::remove_file(link).expect("removed");
        }
        fs::write(own.path().join(std::ffi::OsStr::from_bytes(b"s\xff.png")), b"1").expect("written");
        assert!(of_folder(own.path(), "own", 9).expect_err("a name").problem.contains("no name of UTF-8"));
    }
}
