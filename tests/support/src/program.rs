//! The program `gen` as its users run it, small recipes, and what is in a folder afterwards.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, Row};
use serde_json::Value;
use tempfile::TempDir;

/// Keeps sensor frames too, so that every kind of file is there.
pub const FRAMES: [&str; 2] = ["sensor_stack: none", "sensor_stack: {every: 16}"];

/// Speckle, which takes the most of a small sample's time and is left out where nobody asks.
pub const SPECKLE: [&str; 2] = ["\n  strength: 0", "\n  strength: 1"];

/// Every image in EXR files too, and not those alone that PNG cannot hold.
const EXR: [&str; 2] = ["\n  exr: auto ", "\n  exr: [range, reflectance, scatter, label, instance] "];
/// The same where the recipe has no such list.
const ALL_EXR: [&str; 2] = ["label, instance]\n", "label, instance]\n  exr: all\n"];

/// A small recipe: wood-small.yaml with 64 columns and 48 profiles, every image in EXR files too, pieces of its text
/// replaced.
pub fn recipe(changes: &[[&str; 2]]) -> String {
    let size = [["\n  columns: 256 ", "\n  columns: 64 "], ["\n  profiles: 256 ", "\n  profiles: 48 "], EXR];
    changed(include_str!("../../../recipes/wood-small.yaml"), &size, changes)
}

/// The same of blister-small.yaml: the corner of a pocket in the middle of the card.
pub fn pack_recipe(changes: &[[&str; 2]]) -> String {
    let size = [["\n  columns: 384 ", "\n  columns: 128 "], ["\n  profiles: 360 ", "\n  profiles: 96 "], EXR];
    changed(include_str!("../../../recipes/blister-small.yaml"), &size, changes)
}

/// The same of sawtooth-small.yaml: the front of the piece.
pub fn sawtooth_recipe(changes: &[[&str; 2]]) -> String {
    let size = [["\n  columns: 256 ", "\n  columns: 64 "], ["\n  profiles: 192 ", "\n  profiles: 48 "], ALL_EXR];
    changed(include_str!("../../../recipes/sawtooth-small.yaml"), &size, changes)
}

/// The same of mesh-small.yaml: the front of the part.
pub fn mesh_recipe(changes: &[[&str; 2]]) -> String {
    let size = [["\n  columns: 256 ", "\n  columns: 64 "], ["\n  profiles: 256 ", "\n  profiles: 48 "], ALL_EXR];
    changed(include_str!("../../../recipes/mesh-small.yaml"), &size, changes)
}

/// The same of wood-slices.yaml: the near end of a board.
pub fn slices_recipe(changes: &[[&str; 2]]) -> String {
    let size = [["\n  columns: 256 ", "\n  columns: 64 "], ["\n  profiles: 440 ", "\n  profiles: 60 "]];
    changed(include_str!("../../../recipes/wood-slices.yaml"), &size, changes)
}

fn changed(text: &str, size: &[[&str; 2]], changes: &[[&str; 2]]) -> String {
    let speckle = "speckle:\n  strength: 1\n  surface_patterns: 1\n  volume_patterns: 2\n";
    let mut text = if text.contains(speckle) { text.replacen(speckle, "", 1) } else { text.to_owned() };
    text += "\nspeckle:\n  strength: 0\n";
    for [old, new] in size.iter().chain(changes) {
        assert_eq!(text.matches(old).count(), 1, "`{old}` is not once in the recipe");
        text = text.replacen(old, new, 1);
    }
    text
}

/// The program's path, which cargo tells to the tests of its package.
pub fn program() -> PathBuf {
    std::env::var_os("CARGO_BIN_EXE_gen").expect("`cargo test` names the program in CARGO_BIN_EXE_gen").into()
}

/// How a run of the program ended.
pub struct Run {
    /// Exit status.
    pub code: i32,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Run {
    /// Checks that it was refused with exit status 1, and that all of these words are said on standard error.
    pub fn refused(&self, words: &[&str]) {
        assert_eq!(self.code, 1, "{}", self.err);
        for word in words {
            assert!(self.err.contains(word), "no `{word}` in {}", self.err);
        }
    }
}

/// Waits until something is so, however long the machine takes; `false` where the process that makes it so ends before.
pub fn until(child: &mut Child, mut is_so: impl FnMut() -> bool) -> bool {
    loop {
        // What it did last counts too.
        let ended = child.try_wait().expect("the child can be asked").is_some();
        if is_so() || ended {
            return is_so();
        }
        sleep(Duration::from_micros(500));
    }
}

/// A folder to work in; the program runs there.
pub struct Place(TempDir);

impl Default for Place {
    fn default() -> Self {
        Self::new()
    }
}

impl Place {
    /// An empty folder.
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    /// A folder that holds the small recipe, changed, as `tiny.yaml`.
    pub fn with(changes: &[[&str; 2]]) -> Self {
        let place = Self::new();
        place.write("tiny.yaml", recipe(changes));
        place
    }

    /// A folder for each subject, with its small recipe, changed, as `tiny.yaml`.
    pub fn of_each_subject(changes: &[[&str; 2]]) -> [Self; 4] {
        [recipe, pack_recipe, sawtooth_recipe, mesh_recipe].map(|text| {
            let place = Self::new();
            place.write("tiny.yaml", text(changes));
            place
        })
    }

    /// The path of what lies in the folder by this name.
    pub fn path(&self, relative: &str) -> PathBuf {
        self.0.path().join(relative)
    }

    /// Writes a file.
    pub fn write(&self, relative: &str, text: impl AsRef<[u8]>) {
        fs::write(self.path(relative), text).expect("a file can be written");
    }

    /// The program with arguments that blanks divide.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(program());
        command.current_dir(self.0.path()).args(arguments.split_whitespace());
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs the program, which never panics and never dies of a signal.
    pub fn run(&self, arguments: &str) -> Run {
        let output = self.command(arguments).output().expect("the program starts");
        let text = |bytes| String::from_utf8(bytes).expect("the program writes UTF-8");
        let run = Run { code: output.status.code().unwrap_or(-1), out: text(output.stdout), err: text(output.stderr) };
        let quiet = !run.err.contains("panicked") && (0..=3).contains(&run.code);
        assert!(quiet, "gen {arguments}: status {}\n{}", run.code, run.err);
        run
    }

    /// Runs the program, which does what it is asked.
    pub fn done(&self, arguments: &str) -> Run {
        let run = self.run(arguments);
        assert_eq!(run.code, 0, "gen {arguments}:\n{}{}", run.out, run.err);
        run
    }

    /// Makes a dataset of `tiny.yaml` in `out`.
    pub fn make(&self, out: &str, arguments: &str) -> Run {
        self.done(&format!("--recipe tiny.yaml --out {out} {arguments}"))
    }

    /// Every file of a folder.
    pub fn tree(&self, relative: &str) -> BTreeMap<String, Vec<u8>> {
        tree(&self.path(relative))
    }

    /// Every sample of a dataset.
    pub fn samples(&self, out: &str) -> BTreeMap<i64, Sample> {
        samples(&self.path(out))
    }

    /// A document of a dataset.
    pub fn json(&self, relative: &str) -> Value {
        let text = fs::read(self.path(relative)).expect("the document is there");
        serde_json::from_slice(&text).expect("it is JSON")
    }
}

/// Every file below a folder, by relative path.
pub fn tree(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![root.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("the folder can be listed") {
            let path = entry.expect("the folder can be listed").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(root).expect("it lies below").to_string_lossy().into_owned();
                files.insert(name, fs::read(&path).expect("the file can be read"));
            }
        }
    }
    files
}

/// Says which files differ, in a few words instead of megabytes.
pub fn assert_same(a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>, what: &str) {
    let names: Vec<&String> = a.keys().chain(b.keys().filter(|name| !a.contains_key(*name))).collect();
    let other: Vec<_> = names.into_iter().filter(|name| a.get(*name) != b.get(*name)).collect();
    assert!(other.is_empty(), "{what}: these differ: {other:?}");
}

/// One sample as it is on disk.
#[derive(PartialEq)]
pub struct Sample {
    /// Every column, nested ones as `group.key`.
    pub columns: BTreeMap<String, Field>,
    /// The EXR file; empty for none.
    pub exr: Vec<u8>,
}

impl Sample {
    /// The drawn numbers: every float of a column that is named after a group of the recipe.
    pub fn draws(&self) -> BTreeMap<&str, f64> {
        let drawn = |name: &str| name.contains('.') && !name.starts_with("physics.");
        let number = |(name, value): (&'_ String, &Field)| match value {
            Field::Double(value) if drawn(name) => Some(*value),
            _ => None,
        };
        self.columns.iter().filter_map(|(name, value)| Some((name.as_str(), number((name, value))?))).collect()
    }

    /// A column that holds text.
    pub fn text(&self, column: &str) -> &str {
        match &self.columns[column] {
            Field::Str(text) => text,
            other => panic!("{column} is {other:?}"),
        }
    }

    /// An image of the row: columns, rows and its numbers.
    pub fn image(&self, channel: &str) -> (u32, u32, Vec<u16>) {
        let Field::Bytes(bytes) = &self.columns[&format!("{channel}.bytes")] else { panic!("{channel} is no image") };
        let image = image::load_from_memory_with_format(bytes.data(), image::ImageFormat::Png).expect("it is PNG");
        let (width, height) = (image.width(), image.height());
        let numbers = match image {
            image::DynamicImage::ImageLuma8(image) => image.into_raw().into_iter().map(u16::from).collect(),
            image::DynamicImage::ImageLuma16(image) => image.into_raw(),
            other => panic!("{channel} is {:?}", other.color()),
        };
        (width, height, numbers)
    }
}

/// Rows of a Parquet file by its footer, which is written last.
pub fn row_count(path: &Path) -> i64 {
    let file = fs::File::open(path).expect("the table is there");
    SerializedFileReader::new(file).expect("it is Parquet").metadata().file_metadata().num_rows()
}

/// Every row of a Parquet file.
pub fn rows(path: &Path) -> Vec<BTreeMap<String, Field>> {
    let file = fs::File::open(path).expect("the table is there");
    let reader = SerializedFileReader::new(file).expect("it is Parquet");
    let rows = reader.get_row_iter(None).expect("it has rows");
    rows.map(|row| flat("", &row.expect("the row can be read"))).collect()
}

fn flat(group: &str, row: &Row) -> BTreeMap<String, Field> {
    let mut columns = BTreeMap::new();
    for (name, value) in row.get_column_iter() {
        let name = if group.is_empty() { name.clone() } else { format!("{group}.{name}") };
        match value {
            Field::Group(row) => columns.extend(flat(&name, row)),
            value => _ = columns.insert(name, value.clone()),
        }
    }
    columns
}

/// Every sample of the dataset in `root`, by index.
pub fn samples(root: &Path) -> BTreeMap<i64, Sample> {
    let mut exr: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    if root.join("exr").exists() {
        let name = |path: String| path.rsplit('/').next().unwrap_or_default().to_owned();
        exr = tree(&root.join("exr")).into_iter().map(|(path, bytes)| (name(path), bytes)).collect();
    }
    let mut samples = BTreeMap::new();
    for name in tree(&root.join("data")).into_keys() {
        for columns in rows(&root.join("data").join(name)) {
            let Field::Long(index) = columns["index"] else { panic!("no index") };
            let mut sample = Sample { columns, exr: Vec::new() };
            sample.exr = exr.get(&format!("{}.exr", sample.text("id"))).cloned().unwrap_or_default();
            assert!(samples.insert(index, sample).is_none(), "sample {index} is there twice");
        }
    }
    samples
}
