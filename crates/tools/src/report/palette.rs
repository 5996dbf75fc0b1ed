//! Palettes of maps, labels and classes, and PNG images with a palette.

use image::Rgb;
use output_schema::DatasetHead;

use dataset::Fault;
use drawing::class_colour;
use drawing::html::{ColourMap, MAP_LEVELS, hex, indexed_png, map_palette};

/// Colour of what is missing.
const MISSING_COLOUR: [u8; 3] = [70, 110, 190];
/// Opacity of the labels inside and along their borders, of 255.
const INSIDE_OPACITY: u8 = 78;

/// A map as PNG: level 0 is missing, 1 to 127 go from `low` to `high`.
pub(super) fn map_png(map: &[f32], width: u32, (low, high): (f32, f32), ramp: ColourMap) -> Result<Vec<u8>, Fault> {
    let most = f32::from(MAP_LEVELS - 2);
    let level = |&value: &f32| {
        if value.is_nan() { 0 } else { 1 + ((value - low) / (high - low).max(1e-9) * most).clamp(0.0, most) as u8 }
    };
    let levels: Vec<u8> = map.iter().map(level).collect();
    indexed(&levels, width, map_palette(MISSING_COLOUR, ramp), Vec::new())
}

/// Labels as PNG to be laid over a map: borders between classes solid, the inside of all but plain surfaces tinted.
pub(super) fn labels_png(labels: &[u8], width: u32, plain: &[u8]) -> Result<Vec<u8>, Fault> {
    let (mut palette, mut opacity) = (Vec::new(), Vec::new());
    let most = labels.iter().copied().max().unwrap_or(0).min(126);
    for class in 0..=most {
        for alpha in [if plain.contains(&class) { 0 } else { INSIDE_OPACITY }, 255] {
            palette.extend(class_colour(class).0);
            opacity.push(alpha);
        }
    }
    let (width, count) = (width as usize, labels.len());
    let level = |i: usize| {
        let class = labels[i].min(most);
        // The border is drawn by the class that is no plain surface, on its own side.
        let beside = [(!i.is_multiple_of(width), i.wrapping_sub(1)), (i % width + 1 < width, i + 1)];
        let above = [(i >= width, i.wrapping_sub(width)), (i + width < count, i + width)];
        let differs = |(there, at): (bool, usize)| there && labels[at] != class;
        let border = !plain.contains(&class) && beside.into_iter().chain(above).any(differs);
        2 * class + u8::from(border)
    };
    let levels: Vec<u8> = (0..count).map(level).collect();
    indexed(&levels, width as u32, palette, opacity)
}

/// A sensor frame as grey PNG, the square root of digital numbers.
pub(super) fn frame_png(dn: &[u16], width: u32, most: u16) -> Result<Vec<u8>, Fault> {
    let palette = (0..64u8).flat_map(|level| [level * 4; 3]).collect();
    let level = |&dn: &u16| ((f32::from(dn) / f32::from(most.max(1))).sqrt() * 63.0).clamp(0.0, 63.0) as u8;
    let levels: Vec<u8> = dn.iter().map(level).collect();
    indexed(&levels, width, palette, Vec::new())
}

fn indexed(levels: &[u8], width: u32, palette: Vec<u8>, opacity: Vec<u8>) -> Result<Vec<u8>, Fault> {
    indexed_png(levels, width, palette, opacity).map_err(|error| {
        Fault::new("a picture of the page", error.to_string(), "report it with recipe, seed and index")
    })
}

/// Colours of the recipe's classes in CSS: that of the pixel class of the same name, or else a hue that is far from
/// those of pixel classes and of the classes before it. Its lightness is `--l` of the style sheet, for light and dark
/// pages.
pub(super) fn class_colours(head: &DatasetHead) -> Vec<String> {
    let mut taken: Vec<[f64; 3]> =
        head.shown_classes().map(|(value, _)| class_rgb(value).0.map(|part| f64::from(part) / 255.0)).collect();
    let one = |name: &String| {
        if let Some((value, _)) = head.shown_classes().find(|(_, shown)| shown == name) {
            return class_hex(value);
        }
        let near = |hue: u32| taken.iter().map(|colour| apart(*colour, of_hue(hue))).fold(f64::INFINITY, f64::min);
        let hue = (0..360).step_by(5).max_by(|a, b| near(*a).total_cmp(&near(*b))).unwrap_or(0);
        taken.push(of_hue(hue));
        format!("hsl({hue} 60% var(--l))")
    };
    head.classes.iter().map(one).collect()
}

/// Square of the distance between colours.
fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum()
}

/// Red, green and blue of a hue [deg] of saturation 0.6 and lightness 0.5, each in [0, 1].
fn of_hue(hue: u32) -> [f64; 3] {
    [0.0, 8.0, 4.0].map(|n| {
        let k = (n + f64::from(hue) / 30.0) % 12.0;
        0.5 - 0.3 * (k - 3.0).min(9.0 - k).clamp(-1.0, 1.0)
    })
}

fn class_rgb(class: usize) -> Rgb<u8> {
    class_colour(class.try_into().unwrap_or(0))
}

/// A pixel class as `#rrggbb`.
pub(super) fn class_hex(class: usize) -> String {
    hex(class_rgb(class).0)
}
