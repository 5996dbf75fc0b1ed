//! The files of a dataset folder and their names.

/// Name of the document that is known before the first sample.
pub const DATASET: &str = "dataset.json";
/// Name of the dataset card.
pub const CARD: &str = "README.md";
/// Name of the Croissant metadata.
pub const CROISSANT: &str = "croissant.json";
/// Folder of results that are kept with a dataset.
pub const REPORTS: &str = "reports";
/// Start of every temporary name.
pub const TEMPORARY: &str = ".tmp-";
/// Start of every lock file's name.
pub const LOCK: &str = ".lock-";

/// The declaration of one kind of file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FileKind {
    /// Its path, with `<...>` where it varies.
    pub path: &'static str,
    /// When it is there.
    pub when: &'static str,
    /// What it holds.
    pub doc: &'static str,
}

/// Every kind of file.
pub const FILES: [FileKind; 9] = [
    FileKind {
        path: "dataset.json",
        when: "always",
        doc: "What is known before the first sample: recipe, seed, sizes, columns of drawn numbers.",
    },
    FileKind { path: "README.md", when: "always", doc: "Dataset card for people and for the Hugging Face hub." },
    FileKind {
        path: "croissant.json",
        when: "always, from 1.3 on",
        doc: "Croissant 1.1 metadata (MLCommons) for programs: files, records, splits, licence.",
    },
    FileKind {
        path: "assets/<sha256>-<name>",
        when: "the recipe names files",
        doc: "A copy of each file that the recipe names, by its content; `assets` of `dataset.json` lists them.",
    },
    FileKind {
        path: "data/<split>-<shard>.parquet",
        when: "the shard has samples of the split",
        doc: "One row for each sample: numbers, objects and images.",
    },
    FileKind {
        path: "exr/<shard>/<id>.exr",
        when: "the recipe asks for EXR channels",
        doc: "The same images in physical units.",
    },
    FileKind {
        path: "stacks/<shard>.parquet",
        when: "the recipe keeps sensor frames",
        doc: "One row for each kept sensor frame.",
    },
    FileKind {
        path: "shards/<shard>.json",
        when: "the shard is finished",
        doc: "Manifest: every file with its size and SHA-256, every sample with its own. Written last.",
    },
    FileKind {
        path: "reports/<name>",
        when: "results were kept",
        doc: "What was found out about the dataset later; belongs to no manifest, may be removed, names what it was made from.",
    },
];

/// Path of the copy of a file that the recipe names, relative to the folder.
pub fn asset_path(sha256: &str, name: &str) -> String {
    format!("assets/{sha256}-{name}")
}

/// Path of a shard's rows of one split, relative to the folder.
pub fn data_path(split: &str, shard: u64) -> String {
    format!("data/{split}-{shard:05}.parquet")
}

/// Path of a shard's EXR folder, relative to the folder.
pub fn exr_folder(shard: u64) -> String {
    format!("exr/{shard:05}")
}

/// Path of a sample's EXR file, relative to the folder.
pub fn exr_path(shard: u64, id: &str) -> String {
    format!("exr/{shard:05}/{id}.exr")
}

/// Path of a shard's sensor frames, relative to the folder.
pub fn stack_path(shard: u64) -> String {
    format!("stacks/{shard:05}.parquet")
}

/// Path of a shard's manifest, relative to the folder.
pub fn manifest_path(shard: u64) -> String {
    format!("shards/{shard:05}.json")
}

/// The temporary path beside a final one: `.tmp-` before the last name.
///
/// ```
/// assert_eq!(output_schema::file::temporary("data/train-00000.parquet"), "data/.tmp-train-00000.parquet");
/// assert_eq!(output_schema::file::temporary("dataset.json"), ".tmp-dataset.json");
/// ```
pub fn temporary(path: &str) -> String {
    match path.rsplit_once('/') {
        Some((folder, name)) => format!("{folder}/{TEMPORARY}{name}"),
        None => format!("{TEMPORARY}{path}"),
    }
}
