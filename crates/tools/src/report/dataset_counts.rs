//! Counts over all rows of a dataset, in two passes: first extents, then the bins of histograms. Memory
//! does not grow with the number of samples.

use output_schema::row::{IMAGES, ROW, SHARES};
use output_schema::{DatasetHead, NumberColumn};

use super::declared_distribution::DeclaredDistribution;
use super::folder::DatasetFolder;
use super::histogram::{DERIVED_ROUNDING, DRAWN_ROUNDING, Histogram, HistogramAxis, RunningRange};
use dataset::shares::{SampleShares, Shortfall};
use dataset::{RowBatch, RowQuery, Table};

/// Samples of little use that are named for each thing that they fall short in.
const MAX_NAMED_SAMPLES: usize = 12;

/// Pixels and objects of one pixel class.
#[derive(Debug, Clone, Default)]
pub(super) struct PixelClassCounts {
    /// Value in label images.
    pub value: usize,
    /// Name.
    pub name: String,
    /// Pixels in all samples.
    pub pixels: u64,
    /// Samples that show it.
    pub samples: u64,
    /// Objects of it.
    pub objects: u64,
    /// Their diameters [mm].
    pub extent: RunningRange,
    /// Histogram of the diameters.
    pub cells: Option<Histogram>,
}

/// A drawn or derived number.
#[derive(Debug, Clone)]
pub(super) struct NumberCounts {
    /// Its column.
    pub column: NumberColumn,
    /// What it holds.
    pub extent: RunningRange,
    /// What the recipe declares, where that is known.
    pub declared: Option<DeclaredDistribution>,
    /// Histogram; none for a constant.
    pub cells: Option<Histogram>,
}

/// Samples that fall short in one thing.
#[derive(Debug, Clone)]
pub(super) struct ShortSamples {
    /// In what.
    pub shortfall: Shortfall,
    /// How many.
    pub count: u64,
    /// Numbers in the dataset of the first of them.
    pub first: Vec<u64>,
}

/// The counts.
#[derive(Debug)]
pub(super) struct DatasetCounts {
    /// Samples `[classes, splits]`.
    pub samples: Vec<[u64; 3]>,
    /// By pixel class, those alone that labels of the subject can show.
    pub kinds: Vec<PixelClassCounts>,
    /// Drawn numbers, then derived ones.
    pub numbers: Vec<NumberCounts>,
    /// Extent of images along rows and columns [mm].
    pub field: [RunningRange; 2],
    /// Samples of little use by what they fall short in; empty where rows do not tell.
    pub short: Vec<ShortSamples>,
}

/// Position of a sample in the tables.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowPlace {
    /// Class of the recipe.
    pub class: usize,
    /// Table in [`DatasetFolder::tables`].
    pub table: usize,
    /// Row of the table.
    pub row: usize,
}

impl DatasetCounts {
    /// Samples that were read.
    pub fn total(&self) -> u64 {
        self.samples.iter().flatten().sum()
    }

    /// Samples of a class.
    pub fn of_class(&self, class: usize) -> u64 {
        self.samples.get(class).map_or(0, |splits| splits.iter().sum())
    }
}

/// Reads every row twice; the second pass calls `place` with each.
pub(super) fn count(
    head: &DatasetHead,
    folder: &mut DatasetFolder,
    declared: &dyn Fn(&NumberColumn, &[u64]) -> Option<DeclaredDistribution>,
    step: &dyn Fn(u64),
    place: &mut dyn FnMut(&DatasetCounts, RowPlace),
) -> DatasetCounts {
    let kind = |(value, name): (usize, &str)| PixelClassCounts { value, name: name.into(), ..Default::default() };
    let number = |column: &NumberColumn| {
        let (column, extent) = (column.clone(), RunningRange::default());
        NumberCounts { column, extent, declared: None, cells: None }
    };
    let short = |shortfall| ShortSamples { shortfall, count: 0, first: Vec::new() };
    let mut counts = DatasetCounts {
        samples: vec![[0; 3]; head.classes.len()],
        kinds: head.shown_classes().map(kind).collect(),
        numbers: head.parameters.iter().chain(&head.physics).map(number).collect(),
        field: [RunningRange::default(); 2],
        short: if tells_shares(head) { Shortfall::ALL.map(short).to_vec() } else { Vec::new() },
    };
    let tables = folder.tables.clone();
    for table in &tables {
        if let Err(what) = extents(table, &mut counts) {
            folder.trouble(table.relative.clone(), what, "`gen validate` says what is damaged");
        }
        step(1);
    }
    prepare(&mut counts, head, declared);
    for (number, table) in tables.iter().enumerate() {
        // What cannot be read was told by the first pass.
        let _ = fill(table, number, &mut counts, place);
        step(1);
    }
    counts
}

/// Whether rows tell how much of each sample is of use; those of older schemas do not.
pub(super) fn tells_shares(head: &DatasetHead) -> bool {
    ROW.iter().filter(|column| SHARES.contains(&column.name)).all(|column| head.has(column))
}

/// How much of each sample is of use, as far as rows tell.
pub(super) fn shares(rows: &RowBatch) -> Result<Vec<SampleShares>, String> {
    let [measured, saturated, in_view] = SHARES.map(|name| rows.numbers(name));
    let all = measured?.into_iter().zip(saturated?).zip(in_view?);
    let sound = f64::NAN;
    Ok(all.map(|((measured, saturated), in_view)| SampleShares { measured, sound, saturated, in_view }).collect())
}

fn wanted(name: &str) -> bool {
    const OTHERS: [&str; 6] = ["id", "seed", "split", "calibration", "defect_classes", "unseen_classes"];
    !OTHERS.contains(&name) && !IMAGES.contains(&name) && !name.starts_with("range_")
}

/// The path of a number's column in the tables.
fn path(column: &NumberColumn) -> String {
    if column.group.is_empty() { format!("physics.{}", column.key) } else { column.path() }
}

/// The classes of some rows, each of them one of `count`.
fn classes(rows: &RowBatch, count: usize) -> Result<Vec<usize>, String> {
    let known = |class: i64| usize::try_from(class).ok().filter(|class| *class < count);
    let class =
        |class: i64| known(class).ok_or_else(|| format!("`class` is {class}, dataset.json names {count} classes"));
    rows.integers("class")?.into_iter().map(class).collect()
}

/// Gives `take` the rows of a table without its images.
fn each(table: &Table, take: &mut dyn FnMut(&RowBatch) -> Result<(), String>) -> Result<(), String> {
    for rows in table.rows(&RowQuery::of(&wanted)).map_err(|fault| fault.what)? {
        take(&rows.map_err(|fault| fault.what)?)?;
    }
    Ok(())
}

fn extents(table: &Table, counts: &mut DatasetCounts) -> Result<(), String> {
    each(table, &mut |rows| {
        for class in classes(rows, counts.samples.len())? {
            counts.samples[class][table.split as usize] += 1;
        }
        for (field, [count, pitch]) in counts.field.iter_mut().zip([["rows", "row_mm"], ["cols", "col_mm"]]) {
            let sides = rows.integers(count)?.into_iter().zip(rows.numbers(pitch)?);
            sides.for_each(|(count, pitch)| field.add(count as f64 * pitch));
        }
        if !counts.short.is_empty() {
            for (shares, index) in shares(rows)?.into_iter().zip(rows.integers("index")?) {
                let found = shares.shortfalls();
                for short in counts.short.iter_mut().filter(|short| found.contains(&short.shortfall)) {
                    short.count += 1;
                    if short.first.len() < MAX_NAMED_SAMPLES {
                        short.first.push(index.unsigned_abs());
                    }
                }
            }
        }
        for number in &mut counts.numbers {
            rows.numbers(&path(&number.column))?.into_iter().for_each(|value| number.extent.add(value));
        }
        for kind in &mut counts.kinds {
            let areas = rows.integers(&format!("class_area_px.{}", kind.name))?;
            for area in areas.into_iter().filter(|&area| area > 0) {
                kind.pixels += area.unsigned_abs();
                kind.samples += 1;
            }
        }
        for object in rows.objects()?.into_iter().flatten() {
            if let Some(kind) = counts.kinds.iter_mut().find(|kind| kind.value == object.class) {
                kind.objects += 1;
                kind.extent.add(object.diameter_mm);
            }
        }
        Ok(())
    })
}

/// Lays out the histograms.
fn prepare(
    counts: &mut DatasetCounts,
    head: &DatasetHead,
    declared: &dyn Fn(&NumberColumn, &[u64]) -> Option<DeclaredDistribution>,
) {
    let classes: Vec<u64> = (0..head.classes.len()).map(|class| counts.of_class(class)).collect();
    for number in &mut counts.numbers {
        number.declared = declared(&number.column, &classes);
        let extent = &number.extent;
        let rounding = if number.column.group.is_empty() { DERIVED_ROUNDING } else { DRAWN_ROUNDING };
        if extent.count == 0 || extent.is_constant(rounding) {
            continue;
        }
        let (mut min, mut max) = (extent.min, extent.max);
        // What is declared is shown as a whole unless it is far wider than what was drawn, as the ends of a normal law.
        if let Some(declared) = &number.declared
            && declared.max - declared.min < 2.0 * (max - min)
        {
            (min, max) = (min.min(declared.min), max.max(declared.max));
        }
        let log = number.declared.as_ref().is_some_and(|declared| declared.log);
        number.cells = Some(Histogram::new(HistogramAxis::new(min, max, extent.whole, log), head.classes.len()));
    }
    for kind in counts.kinds.iter_mut().filter(|kind| kind.extent.count > 0 && !kind.extent.is_constant(DRAWN_ROUNDING))
    {
        let axis = HistogramAxis::new(0.0, kind.extent.max, false, false);
        kind.cells = Some(Histogram::new(axis, head.classes.len()));
    }
}

fn fill(
    table: &Table,
    number: usize,
    counts: &mut DatasetCounts,
    place: &mut dyn FnMut(&DatasetCounts, RowPlace),
) -> Result<(), String> {
    let mut first = 0;
    each(table, &mut |rows| {
        let classes = classes(rows, counts.samples.len())?;
        for number in &mut counts.numbers {
            let values = rows.numbers(&path(&number.column))?;
            let Some(cells) = &mut number.cells else { continue };
            values.into_iter().zip(&classes).for_each(|(value, &class)| cells.add(class, value));
        }
        for (objects, &class) in rows.objects()?.into_iter().zip(&classes) {
            for object in objects {
                let kind = counts.kinds.iter_mut().find(|kind| kind.value == object.class);
                if let Some(cells) = kind.and_then(|kind| kind.cells.as_mut()) {
                    cells.add(class, object.diameter_mm);
                }
            }
        }
        for (row, &class) in classes.iter().enumerate() {
            place(counts, RowPlace { class, table: number, row: first + row });
        }
        first += rows.len();
        Ok(())
    })
}
