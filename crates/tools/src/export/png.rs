//! PNG folders: the images as they are stored, and a line of JSON for each row.
//!
//! ```text
//! <split>/<map>/<index>.png    <split>/colour/<index>.png    <split>.jsonl
//! ```

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
            let mut tables: BTreeMap<Split, (GrowingFile, u64)> = BTreeMap::new();
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
                row["files"] = Value::Object(files);
                Ok(format!("{row}\n"))
            };
            let take = |sample: &ExportSample, line: String| {
                let begin = || Ok((out.create(&format!("{}.jsonl", sample.split.name()))?, 0));
                let (table, rows) = of_split(&mut tables, sample.split, begin)?;
                *rows += 1;
                table.push(line.as_bytes())
            };
            source.each(&images, work, take, progress)?;
            let mut rows = Map::new();
            for (split, (table, count)) in tables {
                out.finish_file(table)?;
                rows.insert(split.name().into(), count.into());
            }
            let classes: Map<String, Value> =
                source.head().shown_classes().map(|(value, name)| (value.to_string(), name.into())).collect();
            out.finish(&json!({"rows": rows, "label_values": classes}), Vec::new())
        })
    }
}
