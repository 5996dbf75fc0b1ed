//! PNG folders: the images as they are stored, and a line of JSON for each row.
//!
//! ```text
//! <split>/<map>/<index>.png    <split>/colour/<index>.png    <split>.jsonl
//! ```

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;

use output_schema::row::IMAGES;
use serde_json::{Map, Value, json};

use super::export_folder::GrowingFile;
use super::picture::colour_png;
use super::{ExportFolder, ExportProgress, ExportSummary, Sample, Source};
use bench::split::Split;
use dataset::Fault;
use drawing::class_colour;

/// Options of the export.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PngOptions {
    /// Maps by name; empty for all that the dataset has.
    pub maps: Vec<String>,
    /// Labels as coloured pictures too.
    pub colour: bool,
}

/// The chosen maps, in the order of columns.
pub(super) fn chosen(source: &Source, asked: &[String]) -> Result<Vec<&'static str>, Fault> {
    let is_chosen = |map: &&str| if asked.is_empty() { source.has(map) } else { asked.iter().any(|name| name == map) };
    let maps: Vec<&'static str> = IMAGES.into_iter().filter(is_chosen).collect();
    source.needs(&maps)?;
    if maps.is_empty() {
        let remedy = "add some to `output: {png: [..]}` of the recipe and make it anew";
        return Err(Fault::at(source.root(), "it was made without images", remedy));
    }
    Ok(maps)
}

/// Writes the export.
///
/// # Errors
/// Where the dataset is damaged or lacks images, or the folder cannot be written.
pub fn export(
    source: &Source,
    out: &Path,
    options: &PngOptions,
    progress: ExportProgress,
) -> Result<ExportSummary, Fault> {
    let maps = chosen(source, &options.maps)?;
    let images = match options.colour && !maps.contains(&"label") {
        true => [maps.as_slice(), &["label"]].concat(),
        false => maps.clone(),
    };
    source.needs(&images)?;
    let asked = json!({"maps": maps, "colour": options.colour});
    ExportFolder::write(out, "png", asked, source, |out| {
        let mut tables: BTreeMap<Split, (GrowingFile, u64)> = BTreeMap::new();
        let work = |sample: &Sample| {
            let mut files = Map::new();
            let place = |map: &str| format!("{}/{map}/{}.png", sample.split.name(), sample.key);
            for map in &maps {
                out.put(&place(map), || sample.png(map))?;
                files.insert((*map).into(), place(map).into());
            }
            if options.colour {
                out.put(&place("colour"), || {
                    let labels = sample.grey("label")?.numbers();
                    let pixels: Vec<u8> = labels.into_iter().flat_map(|label| class_colour(label as u8).0).collect();
                    Ok(colour_png(&pixels, sample.cols))
                })?;
                files.insert("colour".into(), place("colour").into());
            }
            let mut row = sample.json();
            row["files"] = Value::Object(files);
            Ok(format!("{row}\n"))
        };
        let take = |sample: &Sample, line: String| {
            let (table, rows) = match tables.entry(sample.split) {
                Entry::Occupied(entry) => entry.into_mut(),
                Entry::Vacant(entry) => {
                    let table = out.create(&format!("{}.jsonl", sample.split.name()))?;
                    entry.insert((table, 0))
                }
            };
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
