//! What the compiler can't say of the parts: which crate may use which, and who knows what inside a crate.

use std::fs;
use std::path::PathBuf;

/// Crate, and the crates of this workspace that it may use. What is not here may use all.
const CRATES: [(&str, &[&str]); 17] = [
    ("procedural", &[]),
    ("output_schema", &[]),
    ("crates/numerics", &[]),
    ("crates/yaml", &[]),
    ("crates/bench", &["procedural"]),
    ("crates/drawing", &["procedural"]),
    ("crates/transport", &["numerics", "procedural"]),
    ("crates/wood_picture", &["numerics", "procedural"]),
    ("crates/reference", &["numerics", "procedural", "transport"]),
    ("crates/scanner", &["bench", "numerics", "procedural", "transport"]),
    ("crates/recipe", &["bench", "numerics", "procedural", "wood_picture", "yaml"]),
    ("crates/dataset", &["bench", "numerics", "output_schema", "procedural"]),
    ("crates/tools", &["bench", "dataset", "drawing", "output_schema", "procedural", "recipe", "yaml"]),
    ("crates/pipeline", &["bench", "dataset", "procedural", "recipe", "reference", "scanner", "transport"]),
    (
        "crates/fit",
        &[
            "bench",
            "dataset",
            "drawing",
            "numerics",
            "output_schema",
            "pipeline",
            "procedural",
            "recipe",
            "scanner",
            "tools",
            "yaml",
        ],
    ),
    ("crates/python", &["sheetlight"]),
    (
        "crates/study",
        &[
            "bench",
            "dataset",
            "drawing",
            "pipeline",
            "procedural",
            "recipe",
            "reference",
            "scanner",
            "transport",
            "yaml",
        ],
    ),
];

/// A library, and the only files that may name it.
const LIBRARIES: [(&str, &[&str]); 2] = [
    ("obvhs", &["crates/scanner/src/specimen/rays.rs"]),
    ("ort", &["crates/tools/src/check/model.rs", "crates/tools/src/check/onnxruntime.rs"]),
];

/// Folder or file, and what may not be named there although the crate knows it.
const FORBIDDEN: [(&str, &[&str]); 9] = [
    // Labels come from the truth, never from what was measured.
    ("crates/pipeline/src/labels.rs", &["scanner::frame", "scanner::extract", "scanner::optics"]),
    ("crates/pipeline/src", &["dataset::Dataset", "dataset::ShardWriter", "dataset::validate"]),
    ("crates/scanner/src/frame.rs", &["crate", "procedural", "transport"]),
    ("crates/scanner/src/specimen.rs", &["crate::extract", "crate::optics"]),
    ("crates/scanner/src/specimen", &["crate::extract", "crate::optics"]),
    // Validation believes nothing, the reader of datasets included.
    ("crates/dataset/src/validate", &["crate::Dataset", "crate::reader"]),
    ("crates/tools/src/check", &["crate::compare", "crate::export", "crate::report", "recipe"]),
    ("crates/tools/src/report", &["crate::compare", "crate::export", "crate::check", "dataset::validate"]),
    ("crates/tools/src/export", &["crate::check", "crate::report", "dataset::validate", "recipe"]),
];

/// All that the Python package may know of this workspace: what is promised to other programs.
const PYTHON_MAY: [&str; 2] = ["sheetlight::api", "sheetlight::cli::run_from"];

/// All that extraction may know: frames and how they shall be read. It would read real frames unchanged.
const EXTRACT_MAY: [&str; 4] = ["crate::frame", "crate::extract", "bench::settings", "bench::lens"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
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

#[test]
fn paths_are_found() {
    let text = "use a::{b, c::{self, d}};\npub(crate) use e::f as g;\nfn h() { i::j(k::l::M); } // use n::o;\nuse p;";
    let found = paths(text);
    for path in ["a::b", "a::c::self", "a::c::d", "i::j", "k::l::M", "p"] {
        assert!(found.iter().any(|p| p == path), "{path} is not in {found:?}");
    }
    assert!(found.iter().any(|p| within(p, "e::f")) && !found.iter().any(|p| p.contains("n::o")), "{found:?}");
    assert!(
        within("arrow_array::Array", "arrow") && !within("images::a", "image") && within("crate::a::B", "crate::a")
    );
}

#[test]
fn crates_use_what_they_may() {
    let names: Vec<&str> = CRATES.iter().map(|(path, _)| path.rsplit('/').next().unwrap_or(path)).collect();
    for (path, may) in CRATES {
        let manifest = fs::read_to_string(root().join(path).join("Cargo.toml")).expect("every crate has a manifest");
        let (_, section) = manifest.split_once("\n[dependencies]\n").unwrap_or_default();
        let section = section.split("\n[").next().unwrap_or_default();
        let used = section.lines().filter_map(|line| line.split(['.', ' ', '=']).next());
        let used: Vec<&str> = used.filter(|name| names.contains(name) || *name == "sheetlight").collect();
        let beyond: Vec<_> = used.iter().filter(|name| !may.contains(name)).collect();
        assert!(beyond.is_empty(), "{path} uses {beyond:?}: ARCHITECTURE.md says why it must not");
        let idle: Vec<_> = may.iter().filter(|name| !used.contains(name)).collect();
        assert!(idle.is_empty(), "{path} does not use {idle:?}: take it out of the table");
    }
    let folders = fs::read_dir(root().join("crates")).expect("the folder can be listed").count();
    assert_eq!(folders + 2, CRATES.len(), "a crate is missing in the table");
}

#[test]
fn nothing_names_what_it_must_not_know() {
    let mut faults = Vec::new();
    for (place, forbidden) in FORBIDDEN {
        for (file, text) in sources(place) {
            let named = paths(&text);
            let bad = forbidden.iter().filter(|name| named.iter().any(|path| within(path, name)));
            faults.extend(bad.map(|name| format!("{file} names {name}")));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn extraction_sees_frames_alone() {
    for (file, text) in sources("crates/scanner/src/extract") {
        let parts = ["crate", "procedural", "transport", "bench", "numerics"];
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
