//! Samples of a split as a check needs them: first what the tables say of them, then their maps.

use std::path::Path;

use output_schema::DatasetHead;

use super::window::{SampleMaps, StoredMap};
use super::{SampleTest, SampleTests};
use dataset::{Dataset, ExrMaps, Fault, FinishedTables, Grey, RowBatch, RowQuery, Table};
use optical_bench::split::Split;

/// A split of a dataset.
#[derive(Debug)]
pub(crate) struct SplitSamples {
    dataset: Dataset,
    /// Tables in the order of shards, then of splits.
    pub tables: Vec<Table>,
    /// Shards that are not finished.
    pub unfinished: u64,
}

/// What a row says of its sample beside the maps.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SampleFacts {
    /// Number in the dataset.
    pub index: u64,
    /// Name.
    pub id: String,
    /// Class of the recipe.
    pub class: usize,
    /// Pixels of each pixel class, by its value.
    pub area: Vec<u64>,
    /// Objects that lie in no other.
    pub objects: Vec<SampleObject>,
    /// The chosen numbers; NaN where there is none, or the sample lacks what it describes.
    pub numbers: Vec<f64>,
}

/// An object of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SampleObject {
    /// Pixel class of the whole with all that lies in it.
    pub state: usize,
    /// Middle of its box: row and column [px].
    pub middle: [i64; 2],
}

impl SplitSamples {
    /// Opens the finished shards of a dataset, one split or all.
    ///
    /// # Errors
    /// Where it holds no dataset that this program reads, or nothing of the split.
    pub fn open(path: &Path, split: Option<Split>) -> Result<Self, Fault> {
        let dataset = Dataset::open(path)?;
        let FinishedTables { tables, unfinished } = dataset.tables(split)?;
        Ok(Self { dataset, tables, unfinished })
    }

    /// `dataset.json`.
    pub fn head(&self) -> &DatasetHead {
        self.dataset.head()
    }

    /// What the rows say, in the order of tables; `numbers` are paths of drawn and derived numbers, of which `tests`
    /// say which samples lack what they describe.
    ///
    /// # Errors
    /// Where a table is damaged.
    pub(crate) fn facts(&self, numbers: &[String], tests: SampleTests) -> Result<Vec<SampleFacts>, Fault> {
        let numbers: Vec<_> = numbers.iter().map(|path| (path.as_str(), tests(self.head(), path))).collect();
        let wanted = |name: &str| {
            let is_group = |path: &str| path.split_once('.').is_some_and(|(group, _)| group == name);
            let is_needed = |(path, test): &(&str, Option<SampleTest>)| {
                is_group(path) || test.as_ref().is_some_and(|test| test.deciders.iter().any(|path| is_group(path)))
            };
            ["index", "id", "class", "class_area_px", "objects"].contains(&name) || numbers.iter().any(is_needed)
        };
        let mut facts = Vec::new();
        for table in &self.tables {
            for batch in table.rows(&RowQuery::of(&wanted))? {
                facts.extend(facts_of(&batch?, self.head(), &numbers).map_err(|what| table.damaged(what))?);
            }
        }
        Ok(facts)
    }

    /// The rows of a table with their images, `step` at a time.
    ///
    /// # Errors
    /// Where it cannot be opened.
    pub fn images(
        &self,
        table: &Table,
        names: &[String],
        step: usize,
    ) -> Result<impl Iterator<Item = Result<RowBatch, Fault>> + use<>, Fault> {
        let range = |name: &str| name.starts_with("range_offset_") || name.starts_with("range_scale_");
        let wanted =
            |name: &str| ["index", "cols", "rows"].contains(&name) || range(name) || names.iter().any(|n| n == name);
        table.rows(&RowQuery { at_once: step, ..RowQuery::of(&wanted) })
    }

    /// The maps of the one row of `row`, which is to be `facts`: planes in the order of `channels`, and labels where
    /// they are asked for.
    ///
    /// # Errors
    /// Where an image is missing or damaged.
    pub fn picture(
        &self,
        table: &Table,
        row: &RowBatch,
        facts: &SampleFacts,
        channels: &[String],
        labels: bool,
    ) -> Result<SampleMaps, Fault> {
        let is_png = |name: &str| self.head().images.png.iter().any(|png| png == name);
        let needed = channels.iter().map(String::as_str).chain(labels.then_some("label"));
        let of_sample = |fault: Fault| fault.of_part(format!("sample {}", facts.index));
        let exr = match needed.clone().all(is_png) {
            true => None,
            false => Some(self.dataset.exr(table.shard, &facts.id).map_err(of_sample)?),
        };
        let damaged = |what: String| of_sample(table.damaged(what));
        let one = |name: &str| first(row.integers(name)?, name);
        if one("index").map_err(damaged)? != facts.index as i64 {
            return Err(table.damaged(format!("its rows changed while sample {} was read", facts.index)));
        }
        let side = |name: &str| one(name).map(|side| usize::try_from(side).unwrap_or(0)).map_err(damaged);
        let size = [side("rows")?, side("cols")?];
        let plane = |name: &str| -> Result<StoredMap, Fault> {
            let plane = if is_png(name) { self.png_plane(row, name) } else { exr_plane(exr.as_ref(), name) };
            let plane = plane.map_err(damaged)?;
            if plane.len() != size[0] * size[1] {
                return Err(damaged(format!("`{name}` has not {} x {} pixels", size[0], size[1])));
            }
            Ok(plane)
        };
        let planes = channels.iter().map(|name| plane(name)).collect::<Result<_, _>>()?;
        let labels = match if labels { Some(plane("label")?) } else { None } {
            None => Vec::new(),
            Some(StoredMap::Eight(labels)) => labels,
            Some(StoredMap::Float(labels)) => labels.into_iter().map(|label| label as u8).collect(),
            Some(StoredMap::Sixteen { .. }) => return Err(damaged("labels have 16 bits".into())),
        };
        Ok(SampleMaps { size, planes, labels })
    }

    /// The image `name` of the one row of `row`.
    fn png_plane(&self, row: &RowBatch, name: &str) -> Result<StoredMap, String> {
        let number = |what: &str| {
            let name = format!("range_{what}_{}", self.head().range_unit());
            first(row.numbers(&name)?, &name)
        };
        Ok(match row.image(0, name, &self.head().images)?.grey {
            Grey::Eight(pixels) => StoredMap::Eight(pixels),
            Grey::Sixteen(pixels) if name == "range" => {
                StoredMap::Sixteen { pixels, offset: number("offset")?, scale: number("scale")? }
            }
            Grey::Sixteen(pixels) => StoredMap::Sixteen { pixels, offset: 0.0, scale: 1.0 },
        })
    }
}

fn exr_plane(exr: Option<&ExrMaps>, name: &str) -> Result<StoredMap, String> {
    let channel = exr.and_then(|exr| exr.channel(name)).ok_or_else(|| format!("no EXR channel `{name}`"))?;
    Ok(StoredMap::Float(channel.numbers.clone()))
}

fn first<T>(values: Vec<T>, name: &str) -> Result<T, String> {
    values.into_iter().next().ok_or_else(|| format!("`{name}` is missing"))
}

/// What some rows say; `numbers` are paths of drawn and derived numbers with what they describe.
fn facts_of(
    rows: &RowBatch,
    head: &DatasetHead,
    numbers: &[(&str, Option<SampleTest>)],
) -> Result<Vec<SampleFacts>, String> {
    let (index, id, class) = (rows.integers("index")?, rows.ids()?, rows.integers("class")?);
    let area = |(value, name): (usize, &str)| Ok((value, rows.integers(&format!("class_area_px.{name}"))?));
    let areas = head.shown_classes().map(area).collect::<Result<Vec<_>, String>>()?;
    let numbers = numbers.iter().map(|(path, test)| conditional_number(rows, path, test.as_ref()));
    let numbers = numbers.collect::<Result<Vec<_>, String>>()?;
    let facts = |(row, objects): (usize, Vec<SampleObject>)| {
        let mut area = vec![0; head.pixel_classes.len()];
        areas
            .iter()
            .for_each(|(value, counts): &(usize, Vec<i64>)| area[*value] = u64::try_from(counts[row]).unwrap_or(0));
        Ok(SampleFacts {
            index: index[row] as u64,
            id: id[row].clone(),
            class: usize::try_from(class[row]).map_err(|_| "`class` is negative")?,
            area,
            objects,
            numbers: numbers.iter().map(|values| values[row]).collect(),
        })
    };
    let middle = |first: i32, length: i32| i64::from(first) + i64::from(length) / 2;
    let objects = rows.objects()?.into_iter().map(|objects| {
        let outer = objects.into_iter().filter(|object| object.within == 0);
        let place = outer.map(|object| {
            let [left, top, cols, rows] = object.bbox;
            SampleObject { state: object.state, middle: [middle(top, rows), middle(left, cols)] }
        });
        place.collect()
    });
    objects.enumerate().map(facts).collect()
}

/// The number `path` of some rows; NaN also where the sample lacks what the number describes, since it is drawn all the
/// same.
fn conditional_number(rows: &RowBatch, path: &str, test: Option<&SampleTest>) -> Result<Vec<f64>, String> {
    let mut values = rows.numbers(path)?;
    let Some(SampleTest { deciders, is_lacking }) = test else { return Ok(values) };
    // Datasets of before a number was declared don't have it.
    let deciders: Vec<Option<Vec<f64>>> = deciders.iter().map(|path| rows.numbers(path).ok()).collect();
    for (row, value) in values.iter_mut().enumerate() {
        let of_row: Vec<_> = deciders.iter().map(|column| column.as_ref().map(|column| column[row])).collect();
        if is_lacking(&of_row) {
            *value = f64::NAN;
        }
    }
    Ok(values)
}
