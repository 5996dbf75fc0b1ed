//! A dataset's folder that somebody else made: links, pipes, foreign names, documents that may not be read, and another
//! process that extends it. Nothing outside of the folder is read, written or removed.

use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use dataset::validate::{Code, ValidationOptions, validate};
use dataset::{Claim, Dataset, Fault, RowQuery, ShardWriter};
use tempfile::TempDir;
use test_support::records::{SIZE, claimed, encoded, granted, head, output, tree, write_dataset, write_shard};

const MANIFEST: &str = "shards/00000.json";
const TABLE: &str = "data/train-00000.parquet";
const STACK: &str = "stacks/00000.parquet";
const EXR: &str = "exr/00000/00000000-0000-5000-8000-000000000002.exr";

/// A dataset of four samples in `set`, and `foreign` beside it, which nobody may touch.
struct Scene(TempDir);

impl Scene {
    fn new() -> Self {
        let place = tempfile::tempdir().expect("a folder");
        write_dataset(&place.path().join("set"), 4, &output());
        fs::create_dir_all(place.path().join("foreign/20240101")).expect("made");
        fs::write(place.path().join("foreign/20240101/photo.jpg"), "years").expect("written");
        fs::write(place.path().join("foreign/thesis.tex"), "years").expect("written");
        Self(place)
    }

    fn set(&self, relative: &str) -> PathBuf {
        self.0.path().join("set").join(relative)
    }

    fn foreign(&self, relative: &str) -> PathBuf {
        self.0.path().join("foreign").join(relative)
    }

    /// Continues the dataset to `samples`.
    fn go_on(&self, samples: u64) -> Result<(), Fault> {
        let folder = Dataset::open_or_create(&self.set(""), head(&output(), &SIZE, samples), false, &|| ())?;
        for shard in folder.remaining(0..folder.head().shards)? {
            let mut writer = granted(ShardWriter::claim(&folder, shard)?);
            let (first, count) = writer.span();
            (first..first + count).try_for_each(|index| writer.push(encoded(index, &output())))?;
            writer.finish()?;
        }
        folder.complete(&|| ()).map(drop)
    }

    /// Continuing is refused, names the place, and leaves what is foreign.
    fn refuses(&self, samples: u64, place: &str, what: &str) {
        let before = tree(&self.foreign(""));
        let fault = self.go_on(samples).expect_err(place);
        let text = fault.to_string();
        assert!(text.contains(place) && text.contains(what) && !fault.remedy.is_empty(), "{place}: {text}");
        assert_eq!(tree(&self.foreign("")), before, "{place}: {text}");
    }
}

fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().expect("mkfifo runs").success());
}

fn replace_by_pipe(path: &Path) {
    fs::remove_file(path).expect("it was there");
    pipe(path);
}

#[test]
fn folders_that_are_links_are_refused_and_nothing_below_them_is_swept() {
    for folder in ["exr", "data", "stacks", "shards"] {
        for samples in [4, 9] {
            let scene = Scene::new();
            fs::remove_dir_all(scene.set(folder)).expect("removed");
            symlink(scene.foreign(""), scene.set(folder)).expect("linked");
            if folder != "shards" {
                fs::write(scene.set("shards/.lock-20240101"), "").expect("written");
                fs::write(scene.set("shards/.lock-00000"), "").expect("written");
            }
            scene.refuses(samples, folder, "is a link");
        }
    }
}

#[test]
fn only_names_of_this_program_are_swept() {
    let scene = Scene::new();
    let foreign = [
        "exr/20240101/photo.exr",
        "exr/.tmp-20240101/photo.exr",
        "shards/.lock-20240101",
        "shards/.lock-00001-of-mine",
        "data/.tmp-notes-00001.txt",
        "data/.tmp-train-00009.parquet",
        ".tmp-notes",
    ];
    for path in foreign {
        fs::create_dir_all(scene.set(path).parent().expect("a parent")).expect("made");
        fs::write(scene.set(path), "mine").expect("written");
    }
    let own = ["shards/.lock-00001", "shards/.tmp-00001.json", "exr/.tmp-00001/a.exr", "data/.tmp-train-00001.parquet"];
    for path in own {
        fs::create_dir_all(scene.set(path).parent().expect("a parent")).expect("made");
        fs::write(scene.set(path), "half").expect("written");
    }
    scene.go_on(9).expect("it is continued");
    let left = tree(&scene.set(""));
    for path in foreign {
        assert!(left.contains(&(path.into(), b"mine".to_vec())), "{path} is gone");
    }
    for path in own {
        assert!(!left.iter().any(|(name, _)| name == path), "{path} stays");
    }

    // What is foreign in a folder of the program's own keeps that folder, and all that is in it.
    let scene = Scene::new();
    fs::create_dir_all(scene.set("exr/00001/holiday")).expect("made");
    fs::write(scene.set("exr/00001/holiday/photo.jpg"), "mine").expect("written");
    scene.refuses(9, "exr/00001/holiday", "no file of a dataset");
    assert!(scene.set("exr/00001/holiday/photo.jpg").exists());
}

#[test]
fn temporary_names_and_locks_that_are_links_are_not_written_through() {
    let names = [
        (".tmp-dataset.json", 9),
        (".tmp-README.md", 9),
        (".tmp-croissant.json", 4),
        (".lock-dataset", 4),
        ("shards/.lock-00001", 9),
        ("shards/.tmp-00001.json", 9),
        ("data/.tmp-train-00001.parquet", 9),
        ("data/test-00001.parquet", 9),
        ("exr/.tmp-00001", 9),
        ("exr/00001", 9),
        ("README.md", 9),
        ("croissant.json", 4),
        ("dataset.json", 4),
        (MANIFEST, 4),
        (TABLE, 4),
        (EXR, 4),
    ];
    for (name, samples) in names {
        for target in ["thesis.tex", "not-there"] {
            let scene = Scene::new();
            let _ = fs::remove_file(scene.set(name));
            symlink(scene.foreign(target), scene.set(name)).expect("linked");
            scene.refuses(samples, name, "is a link");
        }
    }
    let scene = Scene::new();
    symlink(scene.foreign(""), scene.set("assets")).expect("linked");
    let folder = Dataset::open(&scene.set("")).expect("it opens");
    let fault = folder.keep("assets/a", b"a", &|| ()).expect_err("a link");
    assert!(fault.to_string().contains("`assets` is a link") && !scene.foreign("a").exists(), "{fault}");
}

/// A run that holds the lock would wait for the other end of the pipe for ever.
#[test]
fn pipes_are_refused_and_not_waited_for() {
    for name in ["README.md", "croissant.json", "dataset.json", MANIFEST, TABLE, STACK, EXR] {
        let scene = Scene::new();
        replace_by_pipe(&scene.set(name));
        scene.refuses(9, name, "is a pipe");
        let report = validate(&scene.set(""), &ValidationOptions::default());
        assert!(report.faults.iter().any(|fault| fault.fault.place == name), "{name}: {report}");
    }
    for name in [".lock-dataset", ".tmp-README.md", "shards/.lock-00001", "shards/.tmp-00001.json"] {
        let scene = Scene::new();
        pipe(&scene.set(name));
        scene.refuses(9, name, "is a pipe");
    }
}

/// What the reader is asked for beside documents.
fn read_everything(root: &Path) -> Vec<String> {
    let mut told = Vec::new();
    let folder = match Dataset::open(root) {
        Ok(folder) => folder,
        Err(fault) => return vec![fault.to_string()],
    };
    folder.sums();
    match folder.manifest(0) {
        Err(fault) => told.push(fault.to_string()),
        Ok(None) => told.push("no manifest".into()),
        Ok(Some(manifest)) => {
            for table in folder.tables_of(0, &manifest) {
                told.extend(table.rows(&RowQuery::of(&|_| true)).err().map(|fault| fault.to_string()));
            }
            let ids = manifest.samples.iter().map(|sample| folder.exr(0, &sample.id).err());
            told.extend(ids.flatten().map(|fault| fault.to_string()));
            told.extend(folder.sensor_frames(&manifest, 0, 1).err().map(|fault| fault.to_string()));
        }
    }
    told
}

#[test]
fn readers_open_plain_files_alone() {
    for name in ["dataset.json", MANIFEST, TABLE, STACK, EXR] {
        for link in [false, true] {
            let scene = Scene::new();
            if link {
                fs::rename(scene.set(name), scene.foreign("moved")).expect("moved");
                symlink(scene.foreign("moved"), scene.set(name)).expect("linked");
            } else {
                replace_by_pipe(&scene.set(name));
            }
            let told = read_everything(&scene.set("")).join("\n");
            let kind = if link { "is a link" } else { "is a pipe" };
            assert!(told.contains(name) && told.contains(kind), "{name}: {told}");
        }
    }
    let scene = Scene::new();
    assert_eq!(read_everything(&scene.set("")), [] as [String; 0]);
    fs::rename(scene.set("exr"), scene.foreign("exr")).expect("moved");
    symlink(scene.foreign("exr"), scene.set("exr")).expect("linked");
    assert!(read_everything(&scene.set("")).join("\n").contains("`exr` is a link"));
    let report = validate(&scene.set(""), &ValidationOptions::default());
    assert!(report.codes().contains(&Code::FileMissing), "{report}");
}

/// A file of 8 GiB that takes no room on the disk.
#[test]
fn nothing_is_read_beyond_what_the_head_allows() {
    for name in ["dataset.json", MANIFEST, TABLE, STACK, EXR] {
        let scene = Scene::new();
        let file = File::options().write(true).open(scene.set(name)).expect("it is there");
        file.set_len(8 << 30).expect("it grows");
        let told = read_everything(&scene.set("")).join("\n");
        assert!(told.contains(name) && told.contains("8589934592 bytes, more than"), "{name}: {told}");
        let report = validate(&scene.set(""), &ValidationOptions::default());
        let fault = report.faults.iter().find(|fault| fault.fault.place == name);
        assert!(fault.is_some_and(|fault| fault.fault.what.contains("8589934592")), "{name}: {report}");
        let card = ["README.md", "croissant.json"].map(|name| fs::read(scene.set(name)).expect("there"));
        let fault = scene.go_on(4);
        assert_eq!(fault.is_err(), ["dataset.json", MANIFEST].contains(&name), "{name}: {fault:?}");
        assert_eq!(["README.md", "croissant.json"].map(|name| fs::read(scene.set(name)).expect("there")), card);
    }
}

/// A manifest that cannot be read belongs to a shard that somebody finished: nothing of it is removed.
#[test]
fn a_manifest_that_cannot_be_read_is_a_fault() {
    let scene = Scene::new();
    fs::remove_file(scene.set(MANIFEST)).expect("there");
    fs::create_dir(scene.set(MANIFEST)).expect("made");
    fs::write(scene.set(MANIFEST).join("kept"), "mine").expect("written");
    let before = tree(&scene.set(""));
    for samples in [4, 9] {
        let fault = scene.go_on(samples).expect_err("the manifest is a folder").to_string();
        assert!(fault.contains(MANIFEST) && fault.contains("is a folder"), "{fault}");
    }
    let own = |tree: Vec<(String, Vec<u8>)>| -> Vec<(String, Vec<u8>)> {
        let documents = ["dataset.json", "README.md", "croissant.json"];
        tree.into_iter().filter(|(name, _)| !documents.contains(&name.as_str())).collect()
    };
    assert_eq!(own(tree(&scene.set(""))), own(before));
    let folder = Dataset::open(&scene.set("")).expect("it opens");
    assert!(folder.is_done(0).is_err() && folder.remaining(0..1).is_err());
    // Other shards are missing, as names tell: nothing is opened. Once all are named, all are looked at.
    assert_eq!(folder.complete(&|| ()).map_err(|fault| fault.to_string()), Ok(false));
    for shard in 1..folder.head().shards {
        fs::copy(scene.set("dataset.json"), scene.set(&format!("shards/{shard:05}.json"))).expect("copied");
    }
    assert!(folder.complete(&|| ()).expect_err("a folder is no manifest").to_string().contains("is a folder"));

    let scene = Scene::new();
    fs::write(scene.set(MANIFEST), "{").expect("written");
    let before = tree(&scene.set(""));
    assert!(scene.go_on(4).expect_err("no JSON").to_string().contains("cannot be read"));
    assert_eq!(tree(&scene.set("")), before);
}

/// Whoever ends last, the card is of the dataset as it is then.
#[test]
fn a_smaller_run_that_ends_last_leaves_the_card_of_the_larger_one() {
    let (place, alone) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    write_dataset(alone.path(), 10, &output());
    let smaller = Dataset::open_or_create(place.path(), head(&output(), &SIZE, 4), false, &|| ()).expect("it opens");
    write_shard(&smaller, 0, &output());
    write_dataset(place.path(), 10, &output());
    assert!(smaller.complete(&|| ()).expect("it is complete"));
    assert_eq!(tree(place.path()), tree(alone.path()));

    // The same where the larger one is not finished: its card stays as it was begun.
    let place = tempfile::tempdir().expect("a folder");
    let smaller = Dataset::open_or_create(place.path(), head(&output(), &SIZE, 4), false, &|| ()).expect("it opens");
    write_shard(&smaller, 0, &output());
    let larger =
        Dataset::open_or_create(place.path(), head(&output(), &SIZE, 10), false, &|| ()).expect("it is extended");
    let card = || fs::read(place.path().join("README.md")).expect("there");
    let before = card();
    assert!(!smaller.complete(&|| ()).expect("it can be read"));
    assert!(card() == before, "the card of the larger dataset was replaced");

    // And a shard that was made larger stays so.
    let smaller = Dataset::open(place.path()).expect("it opens");
    let wider =
        Dataset::open_or_create(place.path(), head(&output(), &SIZE, 12), false, &|| ()).expect("it is extended");
    assert_eq!((smaller.head().span(2), wider.head().span(2)), ((8, 2), (8, 4)));
    write_shard(&wider, 2, &output());
    assert!(matches!(ShardWriter::claim(&smaller, 2), Ok(Claim::Done)));
    assert!(wider.is_done(2).expect("it can be read") && !larger.is_done(1).expect("it can be read"));
}

#[test]
fn whoever_waits_says_so_and_takes_over() {
    let place = tempfile::tempdir().expect("a folder");
    let folder = Dataset::open_or_create(place.path(), head(&output(), &SIZE, 4), false, &|| ()).expect("it opens");
    let held = claimed(&folder, 0);
    let (tell, told) = std::sync::mpsc::channel();
    thread::scope(|scope| {
        let waiting = scope.spawn(|| {
            let claim = ShardWriter::claim_when_free(&folder, 0, &move || tell.send(()).expect("somebody listens"));
            matches!(claim.expect("it can be written"), Claim::Granted(_))
        });
        told.recv().expect("it says that it waits");
        assert!(!waiting.is_finished());
        drop(held);
        assert!(waiting.join().expect("no panic"), "the shard was not made: whoever waited makes it");
    });
    assert!(!place.path().join("shards/.lock-00000").exists());
}
