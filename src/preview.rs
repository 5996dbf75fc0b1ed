//! Preview of one sample: sensor frame, Range, Reflectance, Scatter and labels side by side, with scales.

mod exposure;
mod legend;

use base::Class;
use image::{Rgb, RgbImage};

pub use self::exposure::{expose_profile, exposed};
use self::legend::Legend;
use crate::generate::equipment;
use dataset::record::Record;
use drawing::{LETTER, MARGIN, Page, Ramp, ScaleEnds, class_colour, viridis};
use optical_bench::settings::SensorStack;
use pipeline;
use recipe::{Recipe, Scene, Subject};
use scanner::optics::speckle::PatternCache;

/// Largest panel [px].
const MAX_PANEL_PX: (u32, u32) = (400, 800);
/// Space for words above and below panels [px].
const HEAD_PX: u32 = 22;
const FOOT_PX: u32 = 46;
/// Rows of the sensor frame shown above and below the line [px].
const FRAME_MARGIN_ROWS: usize = 20;

/// Renders sample `index` and draws it; `progress` is told how many profiles more are rendered.
pub fn preview(recipe: &Recipe, seed: u64, index: u64, progress: &(dyn Fn(u64) + Sync)) -> RgbImage {
    let scene = scene(recipe, seed, index);
    let patterns = PatternCache::new(recipe.streams(seed).key());
    let record = pipeline::render(&scene, equipment(&patterns), progress);
    draw(&scene, &record)
}

/// The scene of a sample with one exposure of the middle of the scan kept, and the images as the camera has them.
pub fn scene(recipe: &Recipe, seed: u64, index: u64) -> Scene {
    let mut scene = recipe.draw(seed, index);
    scene.output.sensor_stack = SensorStack::Every((scene.size.profiles / 2).max(1));
    (scene.output.bin_columns, scene.output.bin_profiles) = (1, 1);
    scene.output.truth_maps = false;
    scene
}

/// A map of a sample as it is shown.
#[derive(Debug, Clone)]
pub struct ShownMap {
    /// Its name, for people.
    pub name: &'static str,
    /// Value at the lower end of its colours.
    pub low: f32,
    /// Value at the upper end.
    pub high: f32,
    /// What values are in.
    pub unit: &'static str,
    /// What is taken off the stored values before they are shown.
    pub less: f32,
    /// Whether its colours are viridis; grey otherwise.
    pub is_coloured: bool,
    /// The map.
    pub picture: RgbImage,
}

/// All that is shown of a sample but its sensor frame: maps and labels, true to scale.
#[derive(Debug, Clone)]
pub struct ShownMaps {
    /// Range, Reflectance, Scatter less dark, and grey where there is one.
    pub maps: Vec<ShownMap>,
    /// The labels.
    pub labels: RgbImage,
}

/// Shows the maps of a sample.
pub fn shown_maps(scene: &Scene, record: &Record) -> ShownMaps {
    paint_maps(scene, record, &PanelGrid::fit(record))
}

/// Grey of a number in [0, 1].
fn grey(t: f32) -> Rgb<u8> {
    Rgb([(255.0 * t) as u8; 3])
}

fn paint_maps(scene: &Scene, record: &Record, panel: &PanelGrid) -> ShownMaps {
    let dark = scene.bench.exposure.dark_level_dn as f32;
    let scatter_dark = scanner::extract::scatter_dark(&scene.extraction, dark).kept;
    // Where no pixel of the object is measured, the scales are those of whatever is.
    let of_body = record.labels.class.iter().zip(&record.maps.range).any(|(class, z)| *class > 0 && !z.is_nan());
    let on_body = |map: &[f32]| -> Vec<f32> {
        let pixels = map.iter().zip(&record.labels.class).zip(&record.maps.range);
        let shown = pixels.filter(|((_, class), z)| !z.is_nan() && (**class > 0 || !of_body));
        shown.map(|((v, _), _)| *v).collect()
    };
    let (low, high) = ends(on_body(&record.maps.range));
    let bright = ends(on_body(&record.maps.reflectance)).1;
    let deep = (ends(on_body(&record.maps.scatter)).1 - scatter_dark).max(0.0);
    let scatter: Vec<f32> = record.maps.scatter.iter().map(|v| (v - scatter_dark).max(0.0)).collect();
    let shown = |name, values: &[f32], [low, high]: [f32; 2], unit, is_coloured| {
        let ramp: Ramp = if is_coloured { &viridis } else { &grey };
        let picture = panel.paint(values, [low, high], ramp);
        ShownMap { name, low, high, unit, less: 0.0, is_coloured, picture }
    };
    let mut maps = vec![
        shown("Range (red: missing)", &record.maps.range, [low, high], scene.extraction.range.unit(), true),
        shown("Reflectance", &record.maps.reflectance, [0.0, bright], "DN", false),
        ShownMap { less: scatter_dark, ..shown("Scatter less dark", &scatter, [0.0, deep], "DN", false) },
    ];
    if !record.maps.grey.is_empty() {
        let high = f32::from(scene.readout.most());
        maps.push(shown("Grey, under lamps", &record.maps.grey, [0.0, high], "DN", false));
    }
    ShownMaps { maps, labels: panel.paint_classes(&record.labels.class) }
}

/// Draws a sample that kept an exposure.
pub fn draw(scene: &Scene, record: &Record) -> RgbImage {
    let panel = PanelGrid::fit(record);
    let shown = paint_maps(scene, record, &panel);
    let panels = shown.maps.len() as u32 + 1;
    let width = panels * (panel.width + MARGIN) + MARGIN;
    let strip = frame_strip(scene, record, width - 2 * MARGIN);
    let top = HEAD_PX + strip.as_ref().map_or(0, |s| s.height() + FOOT_PX);
    let legend = Legend::of(&record.labels.class, panel.width);
    let mut page = Page::new(width, top + HEAD_PX + panel.height + FOOT_PX + legend.more());
    if let Some(strip) = strip {
        page.words(
            MARGIN,
            15,
            &format!("Sensor frame, profile {}: square root of DN", record.stack[record.stack.len() / 2].profile),
        );
        page.picture(MARGIN, HEAD_PX, &strip);
        let size = format!("{} columns, {} rows around the line", scene.size.columns, strip_rows(scene, record).len());
        page.words(MARGIN, HEAD_PX + strip.height() + 14, &size);
    }
    let title =
        format!("sample {}  class {}  split {}  {}", record.index, record.class, record.split.name(), record.id);
    page.words(MARGIN, top - 6, &title);
    for (number, map) in shown.maps.iter().enumerate() {
        let left = MARGIN + number as u32 * (panel.width + MARGIN);
        let ends = ScaleEnds { low: map.low, high: map.high, unit: map.unit };
        page.words(left, top + 15, map.name);
        page.picture(left, top + HEAD_PX, &map.picture);
        let ramp: Ramp = if map.is_coloured { &viridis } else { &grey };
        page.scale(left, top + HEAD_PX + panel.height + 8, panel.width, ends, ramp);
    }
    let left = MARGIN + (panels - 1) * (panel.width + MARGIN);
    page.words(left, top + 15, "Labels");
    page.picture(left, top + HEAD_PX, &shown.labels);
    if scene.plan.subject() == Subject::Blister {
        name_pockets(&mut page, record, &panel, [left, top + HEAD_PX]);
    }
    legend.draw(&mut page, left, top + HEAD_PX + panel.height + 8, panel.mm_per_px);
    page.0
}

/// Writes the number of each pocket on its upper left corner, and its state where that is a defect and the words fit.
fn name_pockets(page: &mut Page, record: &Record, panel: &PanelGrid, [left, top]: [u32; 2]) {
    for object in record.objects.iter().filter(|object| object.instance.within == 0) {
        let at = |pixel: u32, size: u32, count: usize| (u64::from(pixel) * u64::from(size) / count as u64) as u32;
        let x = left + at(object.bbox[0], panel.width, panel.cols);
        let y = top + at(object.bbox[1], panel.height, panel.rows);
        let state = object.instance.state;
        let number = object.instance.id.to_string();
        let name = format!("{number} {}", state.name().replace('_', " "));
        let fits = LETTER * name.len() as u32 <= at(object.bbox[2], panel.width, panel.cols);
        page.words(x, y + 10, if fits && state != Class::Pocket { &name } else { &number });
    }
}

/// The 0.5 % and 99.5 % quantiles of the values.
fn ends(mut values: Vec<f32>) -> (f32, f32) {
    values.sort_by(f32::total_cmp);
    let at = |share: f64| values.get(((values.len() as f64 - 1.0).max(0.0) * share) as usize).copied().unwrap_or(0.0);
    let (low, high) = (at(0.005), at(0.995));
    (low, high.max(low + 0.1))
}

/// What is missing in a map: far from both ramps.
pub const MISSING_COLOUR: Rgb<u8> = Rgb([130, 25, 25]);

/// Sensor rows around the line in the kept exposure.
fn strip_rows(scene: &Scene, record: &Record) -> std::ops::Range<usize> {
    let columns = scene.size.columns;
    let threshold = scene.extraction.threshold_dn;
    let lit = |row: &usize| {
        let dn = &record.stack[record.stack.len() / 2].dn;
        dn[row * columns..(row + 1) * columns]
            .iter()
            .filter(|&&v| f64::from(v) >= threshold + 8.0 * scene.readout.scale())
            .count()
            > columns / 200
    };
    let first = (0..scene.size.rows).find(lit).unwrap_or(0);
    let last = (0..scene.size.rows).rev().find(lit).unwrap_or(scene.size.rows - 1);
    first.saturating_sub(FRAME_MARGIN_ROWS)..(last + FRAME_MARGIN_ROWS + 1).min(scene.size.rows)
}

fn frame_strip(scene: &Scene, record: &Record, width: u32) -> Option<RgbImage> {
    let frame = record.stack.get(record.stack.len() / 2)?;
    let (rows, columns) = (strip_rows(scene, record), scene.size.columns);
    let zoom = f64::from(width) / columns as f64;
    let height = ((rows.len() as f64 * zoom.max(1.0)) as u32).clamp(1, 400);
    Some(RgbImage::from_fn(width, height, |x, y| {
        let row = rows.start + (f64::from(y) / f64::from(height) * rows.len() as f64) as usize;
        let column = ((f64::from(x) / zoom) as usize).min(columns - 1);
        let value = f32::from(frame.dn[row * columns + column]) / f32::from(scene.readout.most());
        Rgb([(255.0 * value.sqrt()) as u8; 3])
    }))
}

/// The grid on which maps are shown true to scale.
struct PanelGrid {
    cols: usize,
    rows: usize,
    width: u32,
    height: u32,
    mm_per_px: f64,
}

impl PanelGrid {
    fn fit(record: &Record) -> Self {
        let (across, along) = (record.cols as f64 * record.col_mm, record.rows as f64 * record.row_mm);
        let mm_per_px = (across / f64::from(MAX_PANEL_PX.0)).max(along / f64::from(MAX_PANEL_PX.1));
        let pixels = |mm: f64| (mm / mm_per_px).round().max(1.0) as u32;
        Self { cols: record.cols, rows: record.rows, width: pixels(across).max(150), height: pixels(along), mm_per_px }
    }

    /// Map pixels behind one panel pixel.
    fn behind(&self, x: u32, y: u32) -> impl Iterator<Item = usize> + use<> {
        let span = |p: u32, size: u32, count: usize| {
            let edge = |p: u32| (u64::from(p) * count as u64 / u64::from(size)) as usize;
            let start = edge(p);
            start..edge(p + 1).max(start + 1).min(count)
        };
        let (columns, cols) = (span(x, self.width, self.cols), self.cols);
        span(y, self.height, self.rows).flat_map(move |row| columns.clone().map(move |column| row * cols + column))
    }

    fn paint(&self, values: &[f32], [low, high]: [f32; 2], ramp: Ramp) -> RgbImage {
        RgbImage::from_fn(self.width, self.height, |x, y| {
            let values = self.behind(x, y).map(|i| values[i]).filter(|v| !v.is_nan());
            let (sum, count) = values.fold((0.0f64, 0u32), |(sum, count), v| (sum + f64::from(v), count + 1));
            if count == 0 {
                return MISSING_COLOUR;
            }
            ramp((((sum / f64::from(count)) as f32 - low) / (high - low)).clamp(0.0, 1.0))
        })
    }

    fn paint_classes(&self, class: &[u8]) -> RgbImage {
        RgbImage::from_fn(self.width, self.height, |x, y| {
            class_colour(self.behind(x, y).map(|i| class[i]).max().unwrap_or(0))
        })
    }
}
