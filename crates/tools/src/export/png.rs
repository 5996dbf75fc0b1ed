//! PNG folders: the images as they are stored, and a line of JSON for each row.
//!
//! ```text
//! <split>/<map>/<index>.png    <split>/colour/<index>.png    <split>.jsonl    <split>/metadata.jsonl
//! ```
//!
//! `metadata.jsonl` is what makes the images of a sample one row of `datasets`. That takes one type for each column, in
//! all splits: so it holds what no sample lacks, and objects as text.

use std::collections::BTreeMap;
use std::path::Path;

use clap::Args;
use output_schema::row::IMAGES;
use serde_json::{Map, Value, json};

use super::export_folder::{ExportFolder, ExportSummary, GrowingFile, of_split};
use super::format::{Export, ExportFormat};
use super::picture::colour_png;
use super::sample::ExportSample;
use super::source::{ExportProgress, ExportSource};
use dataset::Fault;
use drawing::class_colour;
use optical_bench::split::Split;

pub(super) const FORMAT: ExportFormat = ExportFormat::of::<Png>(
    "png",
    "PNG",
    ["png planks --out pngs --colour --index 0-19", "pictures, as stored, of 20 samples"],
);

/// Folders of PNG files as they are stored, and the rows as lines of JSON
#[derive(Debug, Args)]
struct Png {
    #[command(flatten)]
    maps: MapOptions,
    /// Labels as coloured pictures too
    #[arg(long)]
    colour: bool,
}

// Options of exports that write maps; a documentation comment would become the help of each of them.
#[derive(Debug, Args)]
pub(super) struct MapOptions {
    /// Maps [default: all that the dataset has]
    #[arg(long, value_name = "MAPS", value_delimiter = ',', value_parser = IMAGES)]
    maps: Vec<String>,
}

impl MapOptions {
    /// The chosen maps, in the order of columns.
    pub(super) fn chosen(&self, source: &ExportSource) -> Result<Vec<&'static str>, Fault> {
        let is_chosen =
            |map: &&str| if self.maps.is_empty() { source.has(map) } else { self.maps.iter().any(|name| name == map) };
        let maps: Vec<&'static str> = IMAGES.into_iter().filter(is_chosen).collect();
        source.needs(&maps)?;
        if maps.is_empty() {
            let remedy = "add some to `output: {png: [..]}` of the recipe and make it anew";
            return Err(Fault::at(source.root(), "it was made without images", remedy));
        }
        Ok(maps)
    }
}

/// The lines of a split while they grow.
struct SplitTables {
    files: [GrowingFile; 2],
    rows: u64,
}

/// What `datasets` makes a row of: the files of a sample, each in a column of its map's name, and what no sample lacks.
fn metadata(sample: &ExportSample, row: &Value, files: &Map<String, Value>) -> Value {
    let mut found = Map::new();
    for (map, place) in files {
        // Places are meant from the folder of the split on.
        let place = place.as_str().and_then(|place| place.split_once('/')).map(|(_, place)| place);
        found.insert(format!("{map}_file_name"), place.into());
    }
    let is_kept = |key: &str| {
        ["index", "id", "seed", "row_mm", "col_mm"].contains(&key)
            || key.starts_with("range_offset_")
            || key.starts_with("range_scale_")
    };
    let kept = sample.row.values.iter().filter(|(key, _)| is_kept(key));
    found.extend(kept.map(|(key, value)| (key.clone(), value.clone())));
    found.insert("class_name".into(), sample.class.clone().into());
    found.insert("objects".into(), row["objects"].to_string().into());
    Value::Object(found)
}

impl Export for Png {
    fn write(&self, source: &ExportSource, out: &Path, progress: ExportProgress) -> Result<ExportSummary, Fault> {
        let maps = self.maps.chosen(source)?;
        let images = match self.colour && !maps.contains(&"label") {
            true => [maps.as_slice(), &["label"]].concat(),
            false => maps.clone(),
        };
        source.needs(&images)?;
        let asked = json!({"maps": maps, "colour": self.colour});
        ExportFolder::write(out, FORMAT.name, asked, source, |out| {
            let mut tables: BTreeMap<Split, SplitTables> = BTreeMap::new();
            let work = |sample: &ExportSample| {
                let mut files = Map::new();
                let place = |map: &str| format!("{}/{map}/{}.png", sample.split.name(), sample.key);
                for map in &maps {
                    out.put(&place(map), || sample.png(map))?;
                    files.insert((*map).into(), place(map).into());
                }
                if self.colour {
                    out.put(&place("colour"), || {
                        let labels = sample.grey("label")?.numbers();
                        let pixels: Vec<u8> =
                            labels.into_iter().flat_map(|label| class_colour(label as u8).0).collect();
                        Ok(colour_png(&pixels, sample.cols))
                    })?;
                    files.insert("colour".into(), place("colour").into());
                }
                let mut row = sample.json();
                let metadata = metadata(sample, &row, &files);
                row["files"] = Value::Object(files);
                Ok([row, metadata].map(|line| format!("{line}\n")))
            };
            let take = |sample: &ExportSample, lines: [String; 2]| {
                let split = sample.split.name();
                let names = [format!("{split}.jsonl"), format!("{split}/metadata.jsonl")];
                let begin = || Ok(SplitTables { files: [out.create(&names[0])?, out.create(&names[1])?], rows: 0 });
                let tables = of_split(&mut tables, sample.split, begin)?;
                tables.rows += 1;
                tables.files.iter_mut().zip(lines).try_for_each(|(file, line)| file.push(line.as_bytes()))
            };
            source.each(&images, work, take, progress)?;
            let mut rows = Map::new();
            for (split, table) in tables {
                table.files.into_iter().try_for_each(|file| out.finish_file(file))?;
                rows.insert(split.name().into(), table.rows.into());
            }
            let classes: Map<String, Value> =
                source.head().shown_classes().map(|(value, name)| (value.to_string(), name.into())).collect();
            out.finish(&json!({"rows": rows, "label_values": classes}), Vec::new())
        })
    }
}
