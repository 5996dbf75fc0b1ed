//! Photographs of real boards with labels, against the directions of their rings and the boxes that people drew around
//! knots: every bar that docs/real.md names, on any folder with a `truth.json`.
//!
//! `REAL` is the folder, `PART` `open`, `sealed` or (where it is not given) `all`; `make real-fibres` runs it.
//! Directions are tested by turning, since boards lie along their rings: each photograph is turned in millimetres and
//! cut to the largest rectangle that holds nothing from beyond its edges.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use glam::Vec2;
use serde_json::Value;
use wood_picture::{Encoding, FibreMap, PictureAnalysis, analyse};

use crate::quantile;

/// Sizes of a pixel, down and across, that the same pixels are stated to have [mm].
const PIXELS_MM: [[f32; 2]; 3] = [[0.08, 0.05], [0.11, 0.07], [0.16, 0.1]];
/// Turns [deg]; the last is told by the option that says that the length lies across.
const TURNS_DEG: [f32; 6] = [0.0, -20.0, -10.0, 10.0, 20.0, 90.0];
/// Knots from this size on are to be found, and around those from that on fibres are to turn [mm].
const KNOT_MM: f32 = 6.0;
const FLANKED_MM: f32 = 10.0;
/// Least overlap of a knot with its box over both together [1].
const LEAST_OVERLAP: f32 = 0.2;

struct Label {
    class: String,
    /// Corner and size (x, y) [px].
    at: Vec2,
    size: Vec2,
}

impl Label {
    fn is_knot(&self) -> bool {
        self.class.to_lowercase().contains("knot")
    }
}

struct Photograph {
    name: String,
    /// Numbers of the red channel `[rows, cols]`.
    red: Vec<f32>,
    size: [usize; 2],
    rings_deg: f32,
    labels: Vec<Label>,
}

impl Photograph {
    fn read(folder: &Path, told: &Value) -> Self {
        let name = told["file"].as_str().expect("a name").to_owned();
        let numbers = |value: &Value| -> Vec<f32> {
            value.as_array().expect("numbers").iter().map(|one| one.as_f64().expect("a number") as f32).collect()
        };
        let crop: Vec<usize> = numbers(&told["crop_px"]).into_iter().map(|number| number as usize).collect();
        let picture = image::open(folder.join(&name)).expect("a picture").into_rgb8();
        let size = [crop[3] - crop[1], crop[2] - crop[0]];
        let red = |i: usize| {
            let (x, y) = (crop[0] + i % size[1], crop[1] + i / size[1]);
            f32::from(picture.get_pixel(x as u32, y as u32).0[0]) / 255.0
        };
        let label = |label: &Value| {
            let edges = numbers(&label["box_px"]);
            let class = label["class"].as_str().expect("a class").to_owned();
            Label { class, at: Vec2::new(edges[0], edges[1]), size: Vec2::new(edges[2], edges[3]) }
        };
        Self {
            red: (0..size[0] * size[1]).map(red).collect(),
            size,
            rings_deg: told["ring_axis_deg"].as_f64().expect("an angle") as f32,
            labels: told["labels"].as_array().expect("labels").iter().map(label).collect(),
            name,
        }
    }

    /// Whether a place [px] is farther from all labels than their own size.
    fn is_clear(&self, at: Vec2) -> bool {
        self.labels.iter().all(|label| {
            let off = at - label.at;
            off.cmplt(-label.size).any() || off.cmpgt(2.0 * label.size).any()
        })
    }
}

/// A photograph turned in millimetres and cut.
struct Turned {
    red: Vec<f32>,
    size: [usize; 2],
    pixel_mm: [f32; 2],
    turn_rad: f32,
    whole: [usize; 2],
    whole_pixel_mm: [f32; 2],
}

impl Turned {
    fn new(photograph: &Photograph, pixel_mm: [f32; 2], turn_deg: f32) -> Self {
        let is_across = turn_deg == 90.0;
        let turn_rad = turn_deg.to_radians();
        let [height, width] = [0, 1].map(|i| (photograph.size[i] as f32 - 1.0) * pixel_mm[i]);
        let (sin, cos) = (turn_rad.sin().abs(), turn_rad.cos().abs());
        let [down, across] = if is_across {
            [width, height]
        } else if width.min(height) <= 2.0 * sin * cos * width.max(height) {
            let half = 0.5 * width.min(height);
            if width >= height { [half / cos, half / sin] } else { [half / sin, half / cos] }
        } else {
            let twice = cos * cos - sin * sin;
            [(height * cos - width * sin) / twice, (width * cos - height * sin) / twice]
        };
        let own = if is_across { [pixel_mm[1], pixel_mm[0]] } else { pixel_mm };
        let size = [(down / own[0] + 0.01) as usize + 1, (across / own[1] + 0.01) as usize + 1];
        let (whole, whole_pixel_mm) = (photograph.size, pixel_mm);
        let mut turned = Self { red: Vec::new(), size, pixel_mm: own, turn_rad, whole, whole_pixel_mm };
        turned.red = (0..size[0] * size[1])
            .map(|pixel| {
                let most = Vec2::new(whole[1] as f32, whole[0] as f32) - 1.001;
                let at = turned.there(pixel).clamp(Vec2::ZERO, most);
                let (col, row) = (at.x as usize, at.y as usize);
                let part = at - at.floor();
                let between = |row: usize| {
                    let line = &photograph.red[row * whole[1] + col..][..2];
                    line[0] + part.x * (line[1] - line[0])
                };
                between(row) + part.y * (between(row + 1) - between(row))
            })
            .collect();
        turned
    }

    /// Column and row in the photograph of a pixel [px].
    fn there(&self, pixel: usize) -> Vec2 {
        let middle = |size: [usize; 2]| 0.5 * (Vec2::new(size[1] as f32, size[0] as f32) - 1.0);
        let at = Vec2::new((pixel % self.size[1]) as f32, (pixel / self.size[1]) as f32);
        let off = (at - middle(self.size)) * Vec2::new(self.pixel_mm[1], self.pixel_mm[0]);
        let (sin, cos) = self.turn_rad.sin_cos();
        let mm = Vec2::new(off.x * cos - off.y * sin, off.x * sin + off.y * cos);
        mm / Vec2::new(self.whole_pixel_mm[1], self.whole_pixel_mm[0]) + middle(self.whole)
    }
}

/// What was found of a photograph's direction [deg].
struct Direction {
    name: String,
    turn: f32,
    rings: f32,
    /// Median of clear pixels less that of the rings, and the error that is told.
    off: f32,
    told: f32,
}

/// Counts of what is right, of so many.
#[derive(Default)]
struct Tally(BTreeMap<&'static str, [f32; 2]>);

impl Tally {
    fn count(&mut self, what: &'static str, is_right: bool) {
        let [right, all] = self.0.entry(what).or_default();
        (*right, *all) = (*right + f32::from(is_right), *all + 1.0);
    }

    fn share(&self, what: &str) -> f32 {
        self.0.get(what).map_or(f32::NAN, |[right, all]| right / all)
    }
}

/// Knots of an unturned photograph against their labels.
fn knots(photograph: &Photograph, seen: &Turned, map: &FibreMap, tally: &mut Tally) {
    let mm = Vec2::new(seen.pixel_mm[1], seen.pixel_mm[0]);
    let extent = Vec2::new(seen.size[1] as f32, seen.size[0] as f32) * mm;
    let name = &photograph.name;
    let area = |size: Vec2| size.max(Vec2::ZERO).element_product();
    for label in photograph.labels.iter().filter(|label| label.is_knot()) {
        let size = label.size * mm;
        if size.max_element() < KNOT_MM {
            continue;
        }
        let (low, high) = ((label.at * mm).max(Vec2::ZERO), (label.at * mm + size).min(extent));
        let found = map.knots.iter().find(|knot| {
            let (sin, cos) = knot.azimuth_rad.sin_cos();
            let [a, b] = knot.half_axes_mm;
            let half = Vec2::new((a * sin).hypot(b * cos), (a * cos).hypot(b * sin));
            let (left, right) = ((knot.centre_mm - half).max(Vec2::ZERO), (knot.centre_mm + half).min(extent));
            let both = area(right.min(high) - left.max(low));
            let is_inside = knot.centre_mm.cmpge(low).all() && knot.centre_mm.cmple(high).all();
            is_inside && both >= LEAST_OVERLAP * (area(right - left) + area(high - low) - both)
        });
        tally.count("found", found.is_some());
        match (found, label.class.as_str()) {
            (Some(knot), "Live_Knot") => tally.count("living", !knot.dead),
            (Some(knot), "Dead_Knot") => tally.count("dead", knot.dead),
            (Some(_), _) => {}
            (None, class) => println!("{name}: {class} at {low} to {high} mm was not found"),
        }
        let is_cut = low.cmple(2.0 * mm).any() || high.cmpge(extent - 2.0 * mm).any();
        if size.max_element() >= FLANKED_MM && !is_cut {
            flanks(map, 0.5 * (low + high), 0.5 * size, tally);
        }
    }
    for knot in &map.knots {
        let is_labelled = photograph.labels.iter().filter(|label| label.is_knot()).any(|label| {
            let (low, high) = (label.at * mm - 0.5, (label.at + label.size) * mm + 0.5);
            knot.centre_mm.cmpge(low).all() && knot.centre_mm.cmple(high).all()
        });
        tally.count("labelled", is_labelled);
        if !is_labelled {
            println!("{name}: {:?} at {} mm has no label", knot.half_axes_mm, knot.centre_mm);
        }
    }
}

/// On both sides of a knot fibres lean away from it before its middle and back behind it.
fn flanks(map: &FibreMap, middle: Vec2, half: Vec2, tally: &mut Tally) {
    for side in [-1.0, 1.0] {
        let mut sums = [Vec2::ZERO; 2];
        for pixel in (0..map.azimuth_rad.len()).step_by(3) {
            let off = (map.place_mm(pixel) - middle) / half;
            let is_beside = (0.5..1.5).contains(&(side * off.x)) && (0.2..1.5).contains(&off.y.abs());
            if is_beside && off.length() > 1.0 {
                sums[usize::from(off.y > 0.0)] += Vec2::new(side * map.azimuth_rad[pixel], 1.0);
            }
        }
        if sums.iter().all(|sum| sum.y > 0.0) {
            tally.count("flanks", sums[0].x / sums[0].y > sums[1].x / sums[1].y);
        }
    }
}

fn rms(values: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    (sum / count as f32).sqrt()
}

fn correlation(pairs: &[[f32; 2]]) -> f32 {
    let mean = |i: usize| pairs.iter().map(|pair| pair[i]).sum::<f32>() / pairs.len() as f32;
    let means = [mean(0), mean(1)];
    let moment = |i: usize, j: usize| pairs.iter().map(|p| (p[i] - means[i]) * (p[j] - means[j])).sum::<f32>();
    moment(0, 1) / (moment(0, 0) * moment(1, 1)).sqrt()
}

/// A line of the table; whether the bar is met.
fn bar(what: &str, seen: f32, low: f32, high: f32) -> bool {
    let is_met = seen >= low && seen <= high;
    println!("| {what} | {seen:.3} | {low} to {high} | {} |", if is_met { "met" } else { "NOT MET" });
    is_met
}

#[test]
#[ignore = "needs a folder of photographs: REAL"]
fn real_boards() {
    let Some(folder) = std::env::var_os("REAL").map(PathBuf::from) else {
        return println!("nothing to do: REAL names no folder with photographs and a truth.json");
    };
    let part = std::env::var("PART").unwrap_or_else(|_| "all".into());
    let text = std::fs::read_to_string(folder.join("truth.json")).expect("truth.json");
    let truth: Value = serde_json::from_str(&text).expect("JSON");
    let is_asked = |picture: &&Value| match (part.as_str(), picture["sealed"].as_bool().unwrap_or(false)) {
        ("open", sealed) => !sealed,
        ("sealed", sealed) => sealed,
        _ => true,
    };
    let told: Vec<&Value> = truth["pictures"].as_array().expect("pictures").iter().filter(is_asked).collect();
    let mut all_met = true;
    for pixel_mm in PIXELS_MM {
        let is_first = pixel_mm == PIXELS_MM[0];
        let next = Mutex::new(told.iter());
        let found = Mutex::new((Vec::new(), Tally::default()));
        std::thread::scope(|scope| {
            for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
                scope.spawn(|| {
                    loop {
                        let Some(one) = next.lock().expect("no thread has panicked").next() else { break };
                        let photograph = Photograph::read(&folder, one);
                        for turn in TURNS_DEG {
                            look(&photograph, pixel_mm, turn, &found);
                        }
                    }
                });
            }
        });
        let (directions, tally) = found.into_inner().expect("no thread has panicked");
        println!("\n{} photographs at {pixel_mm:?} mm\n\n| bar | seen | asked | |\n|---|---|---|---|", told.len());
        all_met &= tell(&directions, &tally, is_first);
    }
    assert!(all_met, "bars are not met");
}

/// Analyses a photograph that is turned.
fn look(photograph: &Photograph, pixel_mm: [f32; 2], turn: f32, found: &Mutex<(Vec<Direction>, Tally)>) {
    let seen = Turned::new(photograph, pixel_mm, turn);
    let settings =
        PictureAnalysis { encoding: Encoding::Srgb, lies_across: turn == 90.0, ..PictureAnalysis::default() };
    let map = analyse(&seen.red, seen.size, seen.pixel_mm, &settings);
    let mut found = found.lock().expect("no thread has panicked");
    let (directions, tally) = &mut *found;
    tally.count("read", map.is_ok());
    let (map, board) = match map {
        Ok(map) => map,
        Err(fault) => return println!("{} turned by {turn}: {fault}", photograph.name),
    };
    if turn == 0.0 {
        knots(photograph, &seen, &map, tally);
    }
    let rings = photograph.rings_deg;
    let clear = (0..map.azimuth_rad.len()).step_by(17).filter(|&pixel| photograph.is_clear(seen.there(pixel)));
    let off = |pixel: usize| {
        let off = map.azimuth_rad[pixel].to_degrees() - rings - turn;
        off - 180.0 * (off / 180.0).round()
    };
    let mut offs: Vec<f32> = clear.map(off).collect();
    // A label may reach over all of what a turn has left.
    if !offs.is_empty() {
        let (off, told) = (quantile(&mut offs, 0.5), board.error_rad.to_degrees());
        if off.abs() > 3.0 {
            println!("{} turned by {turn}: off by {off:.1} deg, {told:.1} told", photograph.name);
        }
        let name = photograph.name.clone();
        directions.push(Direction { name, turn, rings, off, told });
    }
}

/// The table of one size of pixels; whether all of its bars are met. Knots are as large as their labels say at the
/// first.
fn tell(directions: &[Direction], tally: &Tally, is_first: bool) -> bool {
    let within =
        |deg: f32| directions.iter().filter(|one| one.off.abs() <= deg).count() as f32 / directions.len() as f32;
    for deg in [3.0, 6.0] {
        let boards: BTreeSet<&str> =
            directions.iter().filter(|one| one.off.abs() > deg).map(|one| one.name.as_str()).collect();
        println!("boards that are off by more than {deg} deg in some turn: {boards:?}");
    }
    let unturned: Vec<&Direction> = directions.iter().filter(|one| one.turn == 0.0).collect();
    let ratio = rms(unturned.iter().map(|one| one.off)) / rms(unturned.iter().map(|one| one.rings));
    let pairs: Vec<[f32; 2]> = unturned.iter().map(|one| [one.rings, one.rings + one.off]).collect();
    let mut met = vec![
        bar("refused", 1.0 - tally.share("read"), 0.0, 0.05),
        bar("within 3 deg of the turn", within(3.0), 0.95, 1.0),
        bar("within 6 deg of the turn", within(6.0), 1.0, 1.0),
        bar("unturned, rms error over rms of the rings", ratio, 0.0, 0.8),
        bar("unturned, correlation with the rings", correlation(&pairs), 0.6, 1.0),
    ];
    let mut by_told: Vec<[f32; 2]> = directions.iter().map(|one| [one.told, one.off]).collect();
    by_told.sort_by(|a, b| a[0].total_cmp(&b[0]));
    for group in by_told.chunks(by_told.len().div_ceil(5)) {
        let [told, seen] = [0, 1].map(|i| rms(group.iter().map(|pair| pair[i])));
        met.push(bar(&format!("rms error over what is told, {told:.2} deg"), seen / told, 0.67, 1.5));
    }
    if is_first {
        let balanced = 0.5 * (tally.share("living") + tally.share("dead"));
        met.push(bar("knots found", tally.share("found"), 0.8, 1.0));
        met.push(bar("knots that are labelled", tally.share("labelled"), 0.85, 1.0));
        met.push(bar("living against dead, balanced accuracy", balanced, 0.75, 1.0));
        met.push(bar("flanks of knots where fibres turn around them", tally.share("flanks"), 0.9, 1.0));
        println!("\nright, of: {:?}", tally.0);
    }
    met.into_iter().all(|is_met| is_met)
}
