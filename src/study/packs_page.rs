//! The page of [`super::packs`]: each pack's Range with its defects outlined, Reflectance and Scatter.

use image::{Rgb, RgbImage};
use procedural::Class;

use super::packs::Pack;
use crate::drawing::{MARGIN, Page, viridis};
use crate::record::Record;

/// Packs in a line of the page.
const ACROSS: u32 = 3;
/// Space for a pack's name [px].
const HEAD: u32 = 18;
/// Space between the pictures of a pack [px].
const SEAM: u32 = 3;
/// Columns and profiles behind one pixel of the page.
const SHRINK: usize = 2;
/// Share of a picture's pixels that are whiter than white.
const CLIP: f64 = 0.004;
/// Outlines of defects.
const OUTLINE: Rgb<u8> = Rgb([255, 60, 40]);
/// Where nothing was measured.
const MISSING: Rgb<u8> = Rgb([60, 0, 40]);

/// The page.
pub(super) fn page(packs: &[Pack]) -> RgbImage {
    let size = |record: &Record| ((record.cols / SHRINK) as u32, (record.rows / SHRINK) as u32);
    let (width, height) = packs.first().map_or((1, 1), |pack| size(&pack.record));
    let (cell, line) = (3 * width + 2 * SEAM + MARGIN, HEAD + height + MARGIN);
    let mut page = Page::new(ACROSS * cell + MARGIN, (packs.len() as u32).div_ceil(ACROSS) * line + MARGIN);
    for (number, pack) in packs.iter().enumerate() {
        let number = number as u32;
        let (left, top) = (MARGIN + number % ACROSS * cell, MARGIN + number / ACROSS * line);
        page.words(left, top + HEAD - 6, pack.name);
        for (place, picture) in pictures(pack).iter().enumerate() {
            page.picture(left + place as u32 * (width + SEAM), top + HEAD, picture);
        }
    }
    page.0
}

/// Range, Reflectance and Scatter of a pack.
fn pictures(pack: &Pack) -> [RgbImage; 3] {
    let maps = &pack.record.maps;
    let dark = pack.dark_dn as f32;
    let scatter: Vec<f32> = maps.scatter.iter().map(|v| if *v > 0.0 { (v - dark).max(0.1) } else { 0.0 }).collect();
    let grey = |t: f32| Rgb([(255.0 * t) as u8; 3]);
    let mut range = paint(&pack.record, &maps.range, viridis);
    outline(&pack.record, &mut range);
    [range, paint(&pack.record, &maps.reflectance, grey), paint(&pack.record, &scatter, grey)]
}

/// A map from 0 to what nearly all of its pixels stay below.
fn paint(record: &Record, map: &[f32], ramp: fn(f32) -> Rgb<u8>) -> RgbImage {
    let on = |i: &usize| record.labels.class[*i] != Class::Background as u8 && map[*i] > 0.0;
    let mut values: Vec<f32> = (0..map.len()).filter(on).map(|i| map[i]).collect();
    values.sort_by(f32::total_cmp);
    let white = values.get(((1.0 - CLIP) * values.len() as f64) as usize).copied().unwrap_or(1.0);
    RgbImage::from_fn((record.cols / SHRINK) as u32, (record.rows / SHRINK) as u32, |x, y| {
        let seen: Vec<f32> = behind(record, x, y).map(|i| map[i]).filter(|v| *v > 0.0).collect();
        if seen.is_empty() {
            return MISSING;
        }
        ramp((seen.iter().sum::<f32>() / seen.len() as f32 / white).clamp(0.0, 1.0))
    })
}

/// Pixels of the images behind one of the page.
fn behind(record: &Record, x: u32, y: u32) -> impl Iterator<Item = usize> {
    let (x, y, cols) = (x as usize * SHRINK, y as usize * SHRINK, record.cols);
    (y..y + SHRINK).flat_map(move |row| (x..x + SHRINK).map(move |column| row * cols + column))
}

/// Draws a line where a defect's pixels end.
fn outline(record: &Record, picture: &mut RgbImage) {
    let sound = [Class::Background, Class::Flange, Class::Pocket].map(|class| class as u8);
    let (width, height) = picture.dimensions();
    let at = |x: u32, y: u32| {
        let i = behind(record, x, y).next().unwrap_or(0);
        if sound.contains(&record.labels.class[i]) { 0 } else { record.labels.instance[i] }
    };
    for y in 1..height {
        for x in 1..width {
            if at(x, y) != at(x - 1, y) || at(x, y) != at(x, y - 1) {
                picture.put_pixel(x, y, OUTLINE);
            }
        }
    }
}
