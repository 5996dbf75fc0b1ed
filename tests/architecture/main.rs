//! What the compiler can't say of the parts: which crate may use which, and who knows what inside a crate.

mod portable_floats;

use std::fs::{self, DirEntry};
use std::path::PathBuf;

/// Crate, and the crates of this workspace that it may use. What is not here may use all.
const CRATES: [(&str, &[&str]); 22] = [
    ("crates/base", &[]),
    ("procedural", &["base"]),
    ("output_schema", &["base"]),
    ("crates/numerics", &[]),
    ("crates/files", &[]),
    ("crates/yaml", &["files"]),
    ("crates/optical_bench", &["base"]),
    ("crates/drawing", &["base"]),
    ("crates/transport", &["base", "numerics"]),
    ("crates/wood_picture", &["base", "numerics", "procedural"]),
    ("crates/scanner", &["base", "numerics", "optical_bench", "transport"]),
    (
        "crates/recipe",
        &["base", "files", "numerics", "optical_bench", "output_schema", "procedural", "wood_picture", "yaml"],
    ),
    ("crates/dataset", &["base", "files", "optical_bench", "output_schema"]),
    (
        "crates/tools",
        &["base", "dataset", "drawing", "files", "numerics", "optical_bench", "output_schema", "recipe", "yaml"],
    ),
    ("crates/pipeline", &["base", "dataset", "optical_bench", "procedural", "recipe", "scanner", "transport"]),
    ("crates/rig", &["dataset", "optical_bench", "pipeline", "recipe", "scanner", "transport"]),
    (
        "crates/fit",
        &[
            "base",
            "dataset",
            "drawing",
            "numerics",
            "optical_bench",
            "output_schema",
            "pipeline",
            "recipe",
            "scanner",
            "tools",
            "yaml",
        ],
    ),
    ("crates/python", &["sheetlight"]),
    ("crates/evidence", &["gap", "reference", "study"]),
    ("crates/evidence/gap", &["dataset", "tools"]),
    ("crates/evidence/reference", &["base", "files", "numerics", "optical_bench", "procedural", "transport", "yaml"]),
    (
        "crates/evidence/study",
        &[
            "base",
            "dataset",
            "drawing",
            "numerics",
            "optical_bench",
            "pipeline",
            "procedural",
            "recipe",
            "reference",
            "rig",
            "scanner",
            "transport",
        ],
    ),
];

/// What a change of the optics builds anew: `cargo test -p` of what lies below them takes seconds.
const HEAVY: [&str; 1] = ["scanner"];

/// A library, and the only files that may name it.
const LIBRARIES: [(&str, &[&str]); 2] = [
    ("obvhs", &["crates/scanner/src/specimen/rays.rs"]),
    ("ort", &["crates/tools/src/check/model.rs", "crates/tools/src/check/onnxruntime.rs"]),
];

/// What opens, makes or renames a file by its path.
const OPENINGS: [&str; 23] = [
    "File::open",
    "File::create",
    "File::create_new",
    "File::options",
    "OpenOptions",
    "fs::read",
    "fs::read_to_string",
    "fs::write",
    "fs::copy",
    "fs::rename",
    "fs::hard_link",
    "fs::symlink",
    "fs::open",
    "fs::openat",
    "fs::renameat",
    "image::open",
    "image::save_buffer",
    "ImageReader::open",
    ".save(",
    ".save_with_format(",
    ".commit_from_file(",
    "read_first_flat_layer_from_file(",
    "Handle::from_path",
];

/// The only files that may name one of them, and why.
const OPENERS: [(&str, &str); 8] = [
    ("crates/files/src/lib.rs", "opens files that a user names"),
    ("crates/files/src/cache.rs", "keeps what can be made again in the user's cache"),
    ("crates/dataset/src/atomic_file.rs", "writes files that a user names"),
    ("crates/dataset/src/enclosed/unix.rs", "opens and writes what lies in a folder of others"),
    ("crates/dataset/src/enclosed/windows.rs", "the same there"),
    ("crates/tools/src/check/model.rs", "onnxruntime opens the model, which was read as a plain file before"),
    ("crates/evidence/gap/src/process.rs", "works in a new folder that nobody else can enter"),
    ("src/generate/memory.rs", "asks the system for its memory"),
];

/// The files of `src` that ask the evidence: commands, and the models that recipes name.
const ASK_EVIDENCE: [&str; 4] =
    ["src/cli/compare/mod.rs", "src/cli/study.rs", "src/cli/transport.rs", "src/generate.rs"];

/// Folder or file, and what may not be named there although the crate knows it.
const FORBIDDEN: [(&str, &[&str]); 13] = [
    // Labels come from the truth, never from what was measured.
    ("crates/pipeline/src/labels.rs", &["scanner::frame", "scanner::extract", "scanner::optics"]),
    ("crates/pipeline/src", &["dataset::Dataset", "dataset::ShardWriter", "dataset::validate"]),
    ("crates/scanner/src/frame.rs", &["base", "crate", "transport"]),
    ("crates/scanner/src/specimen.rs", &["crate::extract", "crate::optics"]),
    ("crates/scanner/src/specimen", &["crate::extract", "crate::optics"]),
    // Light is data. What makes a line's light knows no sensor rows, what draws these no numbers, and each phase the
    // data alone that the one before it leaves.
    (
        "crates/scanner/src/optics/light",
        &["crate::optics::scan_line", "crate::optics::window", "crate::optics::readout"],
    ),
    ("crates/scanner/src/optics/scan_line", &["crate::optics::window", "crate::optics::readout"]),
    ("crates/scanner/src/optics/window", &["crate::optics::scan_line", "crate::optics::readout"]),
    ("crates/scanner/src/optics/readout", &["crate::optics::scan_line"]),
    // Validation believes nothing, the reader of datasets included.
    ("crates/dataset/src/validate", &["crate::Dataset", "crate::reader"]),
    ("crates/tools/src/check", &["crate::compare", "crate::export", "crate::report", "recipe"]),
    ("crates/tools/src/report", &["crate::compare", "crate::export", "crate::check", "dataset::validate"]),
    ("crates/tools/src/export", &["crate::check", "crate::report", "dataset::validate", "recipe"]),
];

/// All that the Python package may know of this workspace: what is promised to other programs.
const PYTHON_MAY: [&str; 2] = ["sheetlight::api", "sheetlight::cli::run_from"];

/// All that extraction may know: frames and how they shall be read. It would read real frames unchanged.
const EXTRACT_MAY: [&str; 4] = ["crate::frame", "crate::extract", "optical_bench::settings", "optical_bench::lens"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// What lies in a folder of the repository.
fn listed(relative: &str) -> impl Iterator<Item = DirEntry> {
    let entries = fs::read_dir(root().join(relative)).expect("the folder can be listed");
    entries.map(|entry| entry.expect("the folder can be listed"))
}

/// Every Rust file below a path of the repository, or the file itself, with its text.
fn sources(relative: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut paths = vec![root().join(relative)];
    while let Some(path) = paths.pop() {
        if path.is_dir() {
            let entries = fs::read_dir(&path).expect("the folder can be listed");
            paths.extend(entries.map(|entry| entry.expect("the folder can be listed").path()));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let name = path.strip_prefix(root()).expect("it lies below").to_string_lossy().into_owned();
            found.push((name, fs::read_to_string(&path).expect("it is text")));
        }
    }
    assert!(!found.is_empty(), "no source at {relative}");
    found
}

/// The paths that a source names: of its `use` lines with groups taken apart, and those in the code.
fn paths(text: &str) -> Vec<String> {
    let code: Vec<&str> = text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
    let code = code.join("\n");
    let mut paths = Vec::new();
    for (start, _) in code.match_indices("use ") {
        let before = code[..start].trim_end();
        if !(before.is_empty() || before.ends_with([';', '}', '{', ']', ')']) || before.ends_with("pub")) {
            continue;
        }
        let rest = &code[start + 4..];
        spread("", &rest[..rest.find(';').unwrap_or(rest.len())], &mut paths);
    }
    let word = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    paths.extend(code.split(|c| !word(c)).filter(|path| path.contains("::")).map(String::from));
    paths
}

/// `a::{b, c::{d, e}}` as `a::b`, `a::c::d` and `a::c::e`.
fn spread(prefix: &str, tree: &str, paths: &mut Vec<String>) {
    let (mut depth, mut from) = (0, 0);
    let mut parts = Vec::new();
    for (i, c) in tree.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&tree[from..i]);
                from = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&tree[from..]);
    for part in parts.into_iter().map(str::trim).filter(|part| !part.is_empty()) {
        match part.split_once('{') {
            Some((head, tail)) => spread(&format!("{prefix}{head}"), tail.trim_end_matches('}'), paths),
            None => paths.push(format!("{prefix}{part}")),
        }
    }
}

/// Whether `path` lies in what `name` names: a module, a crate, or a family of crates.
fn within(path: &str, name: &str) -> bool {
    let path = path.strip_prefix("::").unwrap_or(path);
    match path.strip_prefix(name) {
        Some(rest) => {
            name.ends_with("::")
                || rest.is_empty()
                || rest.starts_with("::")
                || (name == "arrow" && rest.starts_with('_'))
        }
        None => false,
    }
}

/// What a path of a source may mean from its crate on, if it begins with `super`: in the file itself, and in a module
/// of its tests.
fn from_the_crate(file: &str, path: &str) -> Vec<String> {
    let rest = path.trim_start_matches("super::");
    let ups = (path.len() - rest.len()) / "super::".len();
    let module = file.split_once("src/").map_or(file, |(_, below)| below).trim_end_matches(".rs");
    let above: Vec<&str> = module.split('/').filter(|part| !["mod", "lib", "main"].contains(part)).collect();
    let kept = [above.len().checked_sub(ups), (above.len() + 1).checked_sub(ups)].into_iter().flatten();
    let named = kept
        .filter(|_| ups > 0)
        .map(|kept| above[..kept].iter().fold(String::from("crate"), |all, part| all + "::" + part));
    named.map(|parent| parent + "::" + rest).collect()
}

#[test]
fn paths_are_found() {
    let text = "use a::{b, c::{self, d}};\npub(crate) use e::f as g;\nfn h() { i::j(k::l::M); } // use n::o;\nuse p;";
    let found = paths(text);
    for path in ["a::b", "a::c::self", "a::c::d", "i::j", "k::l::M", "p"] {
        assert!(found.iter().any(|p| p == path), "{path} is not in {found:?}");
    }
    assert!(found.iter().any(|p| within(p, "e::f")) && !found.iter().any(|p| p.contains("n::o")), "{found:?}");
    let file = "crates/scanner/src/optics/light/tile.rs";
    let means = |path: &str, name: &str| from_the_crate(file, path).iter().any(|path| within(path, name));
    assert!(
        means("super::super::window::Band", "crate::optics::window") && means("super::widths", "crate::optics::light")
    );
    assert!(means("super::super::super::window::Band", "crate::optics::window") && !means("window::Band", "crate"));
    assert!(
        within("arrow_array::Array", "arrow") && !within("images::a", "image") && within("crate::a::B", "crate::a")
    );
}

/// The last part of a crate's path, its name.
fn name(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

/// The crates of this workspace that a section of a crate's manifest names.
fn asked(path: &str, section: &str) -> Vec<String> {
    let manifest = fs::read_to_string(root().join(path).join("Cargo.toml")).expect("every crate has a manifest");
    let (_, section) = manifest.split_once(&format!("\n[{section}]\n")).unwrap_or_default();
    let section = section.split("\n[").next().unwrap_or_default();
    let named = section.lines().filter_map(|line| line.split(['.', ' ', '=']).next());
    let is_ours = |asked: &&str| *asked == "sheetlight" || CRATES.iter().any(|(path, _)| name(path) == *asked);
    named.filter(is_ours).map(str::to_owned).collect()
}

#[test]
fn crates_use_what_they_may() {
    for (path, may) in CRATES {
        let used = asked(path, "dependencies");
        let beyond: Vec<_> = used.iter().filter(|name| !may.contains(&name.as_str())).collect();
        assert!(beyond.is_empty(), "{path} uses {beyond:?}: ARCHITECTURE.md says why it must not");
        let idle: Vec<_> = may.iter().filter(|name| !used.iter().any(|own| own == *name)).collect();
        assert!(idle.is_empty(), "{path} does not use {idle:?}: take it out of the table");
    }
    let is_crate = |entry: &DirEntry| entry.path().join("Cargo.toml").exists();
    let folders = ["crates", "crates/evidence"].into_iter().flat_map(listed).filter(is_crate).count();
    assert_eq!(folders + 2, CRATES.len(), "a crate is missing in the table");
}

/// Whether a crate builds one of [`HEAVY`], itself or what it may use.
fn is_heavy(asked: &str) -> bool {
    let may = CRATES.iter().find(|(path, _)| name(path) == asked).map_or(&[][..], |(_, may)| may);
    HEAVY.contains(&asked) || may.iter().any(|below| is_heavy(below))
}

/// Tests of a crate that renders nothing build nothing that does.
#[test]
fn tests_of_light_crates_are_light() {
    for (path, _) in CRATES.into_iter().filter(|(path, _)| !is_heavy(name(path))) {
        let heavy: Vec<_> = asked(path, "dev-dependencies").into_iter().filter(|asked| is_heavy(asked)).collect();
        assert!(heavy.is_empty(), "tests of {path} build {heavy:?}: move those that need it to tests/");
    }
}

/// What the product is held to is not in it: no crate of it uses the evidence, but `src`, through the door and where a
/// command or a recipe asks.
#[test]
fn evidence_is_reached_by_one_door() {
    const BEHIND: [&str; 3] = ["gap", "reference", "study"];
    for (path, may) in CRATES.into_iter().filter(|(path, _)| !path.starts_with("crates/evidence")) {
        let used: Vec<_> = may.iter().filter(|name| **name == "evidence" || BEHIND.contains(name)).collect();
        assert!(used.is_empty(), "{path} may use {used:?}");
    }
    let manifest = fs::read_to_string(root().join("Cargo.toml")).expect("the root has a manifest");
    let (_, section) = manifest.split_once("\n[dependencies]\n").unwrap_or_default();
    let section = section.split("\n[").next().unwrap_or_default();
    let beside = section.lines().filter_map(|line| line.split('.').next()).find(|name| BEHIND.contains(name));
    assert_eq!(beside, None, "src uses it beside the door");
    let mut asking: Vec<String> = sources("src")
        .into_iter()
        .filter(|(_, text)| paths(text).iter().any(|path| within(path, "evidence")))
        .map(|(file, _)| file)
        .collect();
    asking.sort();
    assert_eq!(asking, ASK_EVIDENCE);
}

#[test]
fn nothing_names_what_it_must_not_know() {
    let mut faults = Vec::new();
    for (place, forbidden) in FORBIDDEN {
        for (file, text) in sources(place) {
            let mut named = paths(&text);
            let relative: Vec<String> = named.iter().flat_map(|path| from_the_crate(&file, path)).collect();
            named.extend(relative);
            let bad = forbidden.iter().filter(|name| named.iter().any(|path| within(path, name)));
            faults.extend(bad.map(|name| format!("{file} names {name}")));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Lines of a source that open a file, without those of its tests.
fn openings(file: &str, text: &str) -> Vec<String> {
    let text = text.split_once("\n#[cfg(test)]\nmod tests").map_or(text, |(code, _)| code);
    let text = text.split_once("\n#[cfg(all(test, unix))]\nmod tests").map_or(text, |(code, _)| code);
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let names = |line: &str, opening: &str| {
        line.match_indices(opening).any(|(at, _)| {
            let is_start = opening.starts_with('.') || !line[..at].ends_with(is_word);
            is_start && (opening.ends_with('(') || !line[at + opening.len()..].starts_with(is_word))
        })
    };
    let code = text.lines().zip(1..).map(|(line, number)| (line.split("//").next().unwrap_or_default(), number));
    let opens = code.filter(|(line, _)| OPENINGS.iter().any(|opening| names(line, opening)));
    opens.map(|(line, number)| format!("{file}:{number}: {}", line.trim())).collect()
}

/// Files are opened by few functions, which say what is refused: a pipe that is waited for, a device that never ends, a
/// link that leads elsewhere. Everything else asks `files` or `dataset::enclosed`.
#[test]
fn few_files_open_files() {
    let mut openers = Vec::new();
    let mut faults = Vec::new();
    let places = CRATES.iter().map(|(path, _)| format!("{path}/src")).chain(["src".to_owned()]);
    for (file, text) in places.flat_map(|place| sources(&place)) {
        let is_test = file.ends_with("tests.rs") || file.contains("/tests/");
        let opens = if is_test { Vec::new() } else { openings(&file, &text) };
        if OPENERS.iter().any(|(may, _)| *may == file) {
            assert!(!opens.is_empty(), "{file} opens nothing: take it out of the list");
            openers.push(file);
        } else {
            faults.extend(opens);
        }
    }
    assert!(
        faults.is_empty(),
        "ask `files` (what a user names) or `dataset::enclosed` (what lies there):\n{faults:#?}"
    );
    assert_eq!(openers.len(), OPENERS.len(), "one of the list is not there");
}

#[test]
fn openings_are_found() {
    for line in [
        "let file = File::open(path)?;",
        "use std::fs::OpenOptions;",
        "    std::fs::read(path)",
        "fs::write(path, text).and_then(|()| fs::rename(&partial, &path))",
        "let mut reader = ImageReader::open(path)?;",
        "rustix::fs::openat(&folder, name, flags, mode)?",
        "image.save_with_format(path, ImageFormat::Png)",
    ] {
        assert_eq!(openings("a.rs", line).len(), 1, "{line}");
        assert_eq!(openings("a.rs", &format!("fn a() {{}}\n#[cfg(test)]\nmod tests {{\n{line}\n}}")).len(), 0);
    }
    for line in ["// File::open(path)", "fs::read_dir(path)", "files::read(path, 9)", "enclosed::rename(root, a, b)"] {
        assert!(openings("a.rs", line).is_empty(), "{line}");
    }
}

#[test]
fn extraction_sees_frames_alone() {
    for (file, text) in sources("crates/scanner/src/extract") {
        let parts = ["crate", "base", "transport", "optical_bench", "numerics"];
        let known = paths(&text).into_iter().filter(|path| parts.iter().any(|part| within(path, part)));
        let beyond: Vec<_> = known.filter(|path| !EXTRACT_MAY.iter().any(|name| within(path, name))).collect();
        assert!(beyond.is_empty(), "{file} names {beyond:?}");
    }
}

#[test]
fn python_uses_what_is_promised() {
    for (file, text) in sources("crates/python/src") {
        let named = paths(&text).into_iter().filter(|path| within(path, "sheetlight"));
        let beyond: Vec<_> = named.filter(|path| !PYTHON_MAY.iter().any(|name| within(path, name))).collect();
        assert!(beyond.is_empty(), "{file} names {beyond:?}");
    }
}

#[test]
fn few_files_name_the_ray_tracer_and_onnxruntime() {
    for (library, may) in LIBRARIES {
        let all = ["src", "crates", "procedural/src", "output_schema/src"].into_iter().flat_map(sources);
        let naming = all.filter(|(_, text)| paths(text).iter().any(|path| within(path, library)));
        let mut naming: Vec<String> = naming.map(|(file, _)| file).collect();
        naming.sort();
        assert_eq!(naming, may, "{library}");
    }
}
