//! Sample of the contact sheet: its maps, small and true to scale, and what its row says.
//!
//! A pixel of a picture is the mean of the map's pixels behind it that were measured, and of labels the largest class
//! number behind it, so that no small defect is lost.

use std::collections::BTreeMap;

use output_schema::DatasetHead;
use output_schema::row::{MEASURED, SHARES};

use super::dataset_counts::{shares, tells_shares};
use dataset::{Dataset, ExrMaps, RowBatch, Table};

/// A sample.
#[derive(Debug, Clone)]
pub(super) struct SheetSample {
    /// Number in the dataset.
    pub index: u64,
    /// Name.
    pub id: String,
    /// Class of the recipe.
    pub class: usize,
    /// Place of the split.
    pub split: usize,
    /// Rows and columns of the images [px].
    pub size: [usize; 2],
    /// Width of the pictures [px].
    pub width: u32,
    /// Height of the pictures [px].
    pub height: u32,
    /// The maps of [`MEASURED`] that the dataset has, NaN where missing [mm or px, DN].
    pub maps: [Option<Vec<f32>>; MEASURED.len()],
    /// Pixel classes on the same grid, where there are labels.
    pub labels: Vec<u8>,
    /// Of the whole Range map, not of its picture.
    pub range: Option<RangeFigures>,
    /// Share of Reflectance at its greatest where there is an object, or anywhere without labels [1].
    pub saturated: Option<f64>,
    /// What makes it of little use, in words.
    pub short: Vec<String>,
    /// How many objects of each pixel class, by its value in label images.
    pub objects: BTreeMap<usize, u64>,
    /// Some drawn numbers.
    pub numbers: Vec<DrawnNumber>,
}

/// A drawn number as a card shows it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DrawnNumber {
    /// Group and key.
    pub path: String,
    /// Its value, in `unit`.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

/// What a card says of a Range map. "On the object" is where labels show no background, or anywhere without labels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RangeFigures {
    /// Median of what was measured on the object [mm or px].
    pub median: Option<f32>,
    /// Share that is missing on the object [1].
    pub missing: Option<f64>,
    /// Share that is missing of all pixels [1].
    pub missing_of_all: f64,
}

/// Drawn numbers that tell an engineer most, where the dataset varies them.
const CARD_NUMBERS: [&str; 4] = ["exposure.time_us", "laser.waist_mm", "laser.power_mw", "camera.tilt_deg"];

/// Reads row `row` of a table; pictures get about `pixels` pixels.
///
/// # Errors
/// In words, where the row or one of its images cannot be read.
pub(super) fn read(
    dataset: &Dataset,
    (table, row): (&Table, usize),
    class: usize,
    pixels: f64,
) -> Result<SheetSample, String> {
    let wanted = |name: &str| {
        let drawn = CARD_NUMBERS.iter().any(|path| path.split_once('.').is_some_and(|(group, _)| group == name));
        let known = ["index", "id", "cols", "rows", "row_mm", "col_mm", "objects", "label"].contains(&name);
        known || drawn || SHARES.contains(&name) || name.starts_with("range_") || MEASURED.contains(&name)
    };
    let row = table.row(row, &wanted).map_err(|fault| fault.what)?;
    let index = first(row.integers("index")?, "index")? as u64;
    of_row(dataset, table, &row, (index, class), pixels).map_err(|what| format!("sample {index}: {what}"))
}

fn first<T>(values: Vec<T>, name: &str) -> Result<T, String> {
    values.into_iter().next().ok_or_else(|| format!("`{name}` is missing"))
}

fn of_row(
    dataset: &Dataset,
    table: &Table,
    row: &RowBatch,
    (index, class): (u64, usize),
    pixels: f64,
) -> Result<SheetSample, String> {
    let head = dataset.head();
    let id = first(row.ids()?, "id")?;
    let side = |name| Ok::<_, String>(usize::try_from(first(row.integers(name)?, name)?).unwrap_or(0));
    let pitch = |name| first(row.numbers(name)?, name);
    let (size, pitch) = ([side("rows")?, side("cols")?], [pitch("row_mm")?, pitch("col_mm")?]);
    let extent = [size[0] as f64 * pitch[0], size[1] as f64 * pitch[1]];
    if !(extent[0] > 0.0 && extent[1] > 0.0 && extent[0].is_finite() && extent[1].is_finite()) {
        return Err(format!("its images are {} x {} mm", extent[1], extent[0]));
    }
    // No finer than the finer of its pitches, no more pixels than asked for, no thinner than a strip that can be seen.
    let mm = pitch[0].min(pitch[1]).max((extent[0] * extent[1] / pixels).sqrt());
    let shown = extent.map(|mm_long| ((mm_long / mm).round().max(8.0) as usize).min(2000));
    let grid = PictureGrid { size, shown };

    let mut exr: Option<ExrMaps> = None;
    let mut plane = |name: &str| -> Result<Option<Vec<f32>>, String> {
        let plane = if head.images.png.iter().any(|png| png == name) {
            png(row, head, name)?
        } else if head.images.exr.iter().any(|exr| exr.eq_ignore_ascii_case(name)) {
            let maps = match exr.take() {
                Some(maps) => maps,
                None => dataset.exr(table.shard, &id).map_err(|fault| format!("{}: {}", fault.place, fault.what))?,
            };
            let channel = exr.insert(maps).channel(name);
            channel.ok_or_else(|| format!("its EXR file has no `{name}`"))?.numbers.clone()
        } else {
            return Ok(None);
        };
        if plane.len() != size[0] * size[1] {
            return Err(format!("`{name}` has not {} x {} pixels", size[0], size[1]));
        }
        Ok(Some(plane))
    };
    let labels = plane("label")?;
    let on_object = |map: &[f32]| -> Vec<f32> {
        let on = |i: usize| labels.as_ref().is_none_or(|labels| labels[i] > 0.0);
        map.iter().enumerate().filter(|(i, _)| on(*i)).map(|(_, value)| *value).collect()
    };
    let (mut maps, mut range, mut saturated) = ([const { None }; MEASURED.len()], None, None);
    for (place, name) in MEASURED.into_iter().enumerate() {
        let Some(map) = plane(name)? else { continue };
        match name {
            "range" => range = Some(figures(&map, on_object(&map))),
            "reflectance" => saturated = share(&on_object(&map), |value| value >= f32::from(head.images.most_dn())),
            _ => {}
        }
        maps[place] = Some(grid.mean(&map));
    }
    let mut objects = BTreeMap::new();
    for object in row.objects()?.into_iter().flatten() {
        *objects.entry(object.class).or_default() += 1;
    }
    Ok(SheetSample {
        index,
        id: id.clone(),
        class,
        split: table.split as usize,
        size,
        width: shown[1] as u32,
        height: shown[0] as u32,
        maps,
        labels: labels.map_or(Vec::new(), |labels| grid.largest(&labels)),
        range,
        saturated,
        short: if tells_shares(head) { shortfalls(row)? } else { Vec::new() },
        objects,
        numbers: numbers(row, head),
    })
}

/// The share of `values` that count [1]; `None` of none.
fn share(values: &[f32], counts: impl Fn(f32) -> bool) -> Option<f64> {
    let count = values.iter().filter(|value| counts(**value)).count();
    (!values.is_empty()).then(|| count as f64 / values.len() as f64)
}

/// Statistics of a Range map and of its pixels on the object.
fn figures(map: &[f32], mut on_object: Vec<f32>) -> RangeFigures {
    let missing = share(&on_object, f32::is_nan);
    let missing_of_all = share(map, f32::is_nan).unwrap_or(0.0);
    on_object.retain(|value| !value.is_nan());
    RangeFigures { median: median(&mut on_object), missing, missing_of_all }
}

/// The median; of an even number of values the mean of the middle two.
fn median(values: &mut [f32]) -> Option<f32> {
    let half = values.len() / 2;
    let even = values.len().is_multiple_of(2);
    let (below, middle, _) = (!values.is_empty()).then(|| values.select_nth_unstable_by(half, f32::total_cmp))?;
    let lower = below.iter().copied().max_by(f32::total_cmp).filter(|_| even);
    Some(lower.map_or(*middle, |lower| 0.5 * (lower + *middle)))
}

/// A map and its picture, both `[rows, columns]`.
struct PictureGrid {
    size: [usize; 2],
    shown: [usize; 2],
}

impl PictureGrid {
    /// Gives `take` the pixels of the map behind each pixel of the picture.
    fn each<T>(&self, take: impl Fn(&mut dyn Iterator<Item = usize>) -> T) -> Vec<T> {
        let span = |place: usize, axis: usize| {
            let first = place * self.size[axis] / self.shown[axis];
            first..((place + 1) * self.size[axis] / self.shown[axis]).max(first + 1).min(self.size[axis])
        };
        let mut picture = Vec::with_capacity(self.shown[0] * self.shown[1]);
        for row in 0..self.shown[0] {
            for col in 0..self.shown[1] {
                let columns = span(col, 1);
                let line = |row: usize| columns.clone().map(move |col| row * self.size[1] + col);
                picture.push(take(&mut span(row, 0).flat_map(line)));
            }
        }
        picture
    }

    fn mean(&self, map: &[f32]) -> Vec<f32> {
        self.each(|behind| {
            let known = behind.map(|i| map[i]).filter(|value| !value.is_nan());
            let (sum, count) = known.fold((0.0f64, 0u32), |(sum, count), value| (sum + f64::from(value), count + 1));
            if count == 0 { f32::NAN } else { (sum / f64::from(count)) as f32 }
        })
    }

    fn largest(&self, labels: &[f32]) -> Vec<u8> {
        self.each(|behind| behind.map(|i| labels[i] as u8).max().unwrap_or(0))
    }
}

/// An image of a row as physical numbers, NaN where missing.
fn png(row: &RowBatch, head: &DatasetHead, name: &str) -> Result<Vec<f32>, String> {
    let numbers = row.image(0, name, &head.images)?.grey.numbers();
    if name == "label" {
        return Ok(numbers.into_iter().map(f32::from).collect());
    }
    let (mut offset, mut scale) = (0.0, 1.0);
    if name == "range" {
        let number = |what: &str| {
            let name = format!("range_{what}_{}", head.range_unit());
            first(row.numbers(&name)?, &name)
        };
        (offset, scale) = (number("offset")?, number("scale")?);
    }
    let value = |n: u16| if n == 0 { f32::NAN } else { (offset + f64::from(n) * scale) as f32 };
    Ok(numbers.into_iter().map(value).collect())
}

/// What makes the sample of a row of little use.
fn shortfalls(row: &RowBatch) -> Result<Vec<String>, String> {
    let shares = first(shares(row)?, "measured_share")?;
    Ok(shares.shortfalls().into_iter().map(|shortfall| shares.describe(shortfall)).collect())
}

fn numbers(row: &RowBatch, head: &DatasetHead) -> Vec<DrawnNumber> {
    let one = |path: &&str| {
        let column = head.parameters.iter().find(|column| column.path() == **path)?;
        let value = first(row.numbers(path).ok()?, path).ok()?;
        Some(DrawnNumber { path: column.path(), value, unit: column.unit.clone() })
    };
    CARD_NUMBERS.iter().filter_map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a card says of Range is of the map on the object: its picture has other numbers.
    #[test]
    fn figures_are_of_the_whole_map() {
        let nan = f32::NAN;
        let map = [1.0, 9.0, 1.0, 9.0, 1.0, 1.0, 1.0, 2.0, nan, 1.0, 9.0, nan, 9.0, 1.0, 1.0, nan];
        let told = figures(&map, map[..14].to_vec());
        assert_eq!((told.median, told.missing, told.missing_of_all), (Some(1.0), Some(2.0 / 14.0), 3.0 / 16.0));
        let picture = PictureGrid { size: [4, 4], shown: [2, 2] }.mean(&map);
        assert!(picture.iter().all(|value| *value > 2.0), "{picture:?}");
        assert_eq!(figures(&map, vec![4.0, 1.0, nan, 3.0, 2.0]).median, Some(2.5));
        let told = figures(&map, Vec::new());
        assert_eq!((told.median, told.missing), (None, None));
    }
}
