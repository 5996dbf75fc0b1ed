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
        path: "data/[<thousand>/]<split>-<shard>.parquet",
        when: "the shard has samples of the split",
        doc: "One row for each sample: numbers, objects and images.",
    },
    FileKind {
        path: "exr/[<thousand>/]<shard>/<id>.exr",
        when: "it holds truth maps, or images that the tables do not",
        doc: "Truth maps, and images in physical units that PNG does not hold.",
    },
    FileKind {
        path: "stacks/[<thousand>/]<shard>.parquet",
        when: "the recipe keeps sensor frames",
        doc: "One row for each kept sensor frame.",
    },
    FileKind {
        path: "shards/[<thousand>/]<shard>.json",
        when: "the shard is finished",
        doc: "Manifest: every file with its size and SHA-256, every sample with its own. Written last.",
    },
    FileKind {
        path: "reports/<name>",
        when: "results were kept",
        doc: "What was found out about the dataset later; belongs to no manifest, may be removed, names what it was \
            made from.",
    },
];

/// Path of the copy of a file that the recipe names, relative to the folder.
pub fn asset_path(sha256: &str, name: &str) -> String {
    format!("assets/{sha256}-{name}")
}

/// Shards whose files share a folder. Hubs and some file systems take no more than ten thousand names in one.
pub const SHARDS_PER_FOLDER: u64 = 1000;

/// The folder in `folder` that a shard's files lie in: itself for the first thousand, one of their own for each
/// thousand more.
///
/// ```
/// assert_eq!(output_schema::file::shard_folder("data", 999), "data");
/// assert_eq!(output_schema::file::shard_folder("data", 12_345), "data/012");
/// ```
pub fn shard_folder(folder: &str, shard: u64) -> String {
    match shard / SHARDS_PER_FOLDER {
        0 => folder.into(),
        thousand => format!("{folder}/{thousand:03}"),
    }
}

/// Path of a shard's rows of one split, relative to the folder.
pub fn data_path(split: &str, shard: u64) -> String {
    format!("{}/{split}-{shard:05}.parquet", shard_folder("data", shard))
}

/// Where files of a kind lie in a dataset of so many shards, as patterns: `name` below `folder`.
///
/// ```
/// assert_eq!(output_schema::file::patterns("data", "train-*.parquet", 1000), ["data/train-*.parquet"]);
/// let spread = output_schema::file::patterns("data", "train-*.parquet", 1001);
/// assert_eq!(spread, ["data/train-*.parquet", "data/*/train-*.parquet"]);
/// ```
pub fn patterns(folder: &str, name: &str, shards: u64) -> Vec<String> {
    let mut patterns = vec![format!("{folder}/{name}")];
    if shards > SHARDS_PER_FOLDER {
        patterns.push(format!("{folder}/*/{name}"));
    }
    patterns
}

/// Path of a shard's EXR folder, relative to the folder.
pub fn exr_folder(shard: u64) -> String {
    format!("{}/{shard:05}", shard_folder("exr", shard))
}

/// Path of a sample's EXR file, relative to the folder.
pub fn exr_path(shard: u64, id: &str) -> String {
    format!("{}/{id}.exr", exr_folder(shard))
}

/// Path of a shard's sensor frames, relative to the folder.
pub fn stack_path(shard: u64) -> String {
    format!("{}/{shard:05}.parquet", shard_folder("stacks", shard))
}

/// Path of a shard's manifest, relative to the folder.
pub fn manifest_path(shard: u64) -> String {
    format!("{}/{shard:05}.json", shard_folder("shards", shard))
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
