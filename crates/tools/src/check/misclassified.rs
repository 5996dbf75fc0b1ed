//! The most confidently misclassified windows, and pictures of what the model saw there.

use std::cmp::Ordering;

use image::{Rgb, RgbImage};

use super::sidecar::{Layout, Sidecar};
use super::window::{InputWindow, NO_CLASS};
use drawing::{INK, LETTER, MARGIN, Page, viridis};

/// Least side of a panel [px]; smaller windows are drawn larger by whole factors.
const MIN_PANEL_PX: usize = 160;
/// Height of a line of the legend [px].
const LEGEND_LINE_PX: u32 = 16;
/// Colour of cells without a class.
const NO_CLASS_COLOUR: Rgb<u8> = Rgb([200, 200, 200]);
/// Colour of cells without a measurement.
const MISSING_COLOUR: Rgb<u8> = Rgb([60, 90, 150]);

/// A wrong answer.
#[derive(Debug, Clone)]
pub struct Misclassification {
    /// Number of the sample in the dataset.
    pub index: u64,
    /// Name of the sample.
    pub id: String,
    /// Where the window was cut.
    pub window: InputWindow,
    /// Class that it is; of a map the class whose wrong cells weigh most.
    pub truth: usize,
    /// Class that the model gave.
    pub guess: usize,
    /// How sure the model was; of a map the sum over wrong cells by the number of cells.
    pub confidence: f64,
    /// What the model saw, where pictures are wanted.
    pub picture: Option<RgbImage>,
}

/// The more confident first, then by sample and place: an order that no batch or thread changes.
fn order(a: &Misclassification, b: &Misclassification) -> Ordering {
    let place = |wrong: &Misclassification| (wrong.index, wrong.window.first);
    b.confidence.total_cmp(&a.confidence).then_with(|| place(a).cmp(&place(b)))
}

/// Takes a wrong answer where it is among the `most` worst, which `list` holds, the most confident first; `draw` makes
/// its picture then.
pub(crate) fn keep_worst(
    list: &mut Vec<Misclassification>,
    most: usize,
    wrong: Misclassification,
    draw: impl FnOnce(&Misclassification) -> Option<RgbImage>,
) {
    let at = list.partition_point(|kept| order(kept, &wrong) == Ordering::Less);
    if at < most {
        let picture = draw(&wrong);
        list.insert(at, Misclassification { picture, ..wrong });
        list.truncate(most);
    }
}

/// What the model saw: a panel for each channel as it came in, from dark (lowest) to bright (highest), blue where
/// missing, and of maps what is true and what was answered, with the colours of the classes below.
pub(crate) fn draw_panels(
    wrong: &Misclassification,
    input: &[f32],
    maps: Option<[&[u8]; 2]>,
    sidecar: &Sidecar,
) -> RgbImage {
    let [rows, cols] = sidecar.size;
    let factor = (MIN_PANEL_PX / rows.max(cols)).max(1);
    let panel = |colour: &dyn Fn(usize) -> Rgb<u8>| {
        RgbImage::from_fn((cols * factor) as u32, (rows * factor) as u32, |x, y| {
            colour((y as usize / factor) * cols + x as usize / factor)
        })
    };
    let count = sidecar.channels.len();
    let mut panels: Vec<(String, RgbImage)> = Vec::new();
    for (c, channel) in sidecar.channels.iter().enumerate() {
        let at = |cell: usize| match sidecar.layout {
            Layout::Nchw => input[c * rows * cols + cell],
            Layout::Nhwc => input[cell * count + c],
        };
        // Something measured may happen to have the same number, and is blue then too.
        let missing = |value: f32| value == channel.missing as f32;
        let cells = || (0..rows * cols).map(at).filter(|value| !missing(*value));
        let (low, high) = (cells().fold(f32::INFINITY, f32::min), cells().fold(f32::NEG_INFINITY, f32::max));
        let shade = |cell: usize| match at(cell) {
            value if missing(value) => MISSING_COLOUR,
            value => Rgb([(255.0 * (value - low) / (high - low).max(f32::MIN_POSITIVE)) as u8; 3]),
        };
        panels.push((channel.name.clone(), panel(&shade)));
    }
    for (name, map) in ["truth", "answer"].into_iter().zip(maps.into_iter().flatten()) {
        let shade = |cell: usize| if map[cell] == NO_CLASS { NO_CLASS_COLOUR } else { colour(map[cell], sidecar) };
        panels.push((name.into(), panel(&shade)));
    }
    let side = |n: usize| n as u32 * factor as u32;
    let (width, height) = (side(cols).max(11 * LETTER), side(rows));
    let words = [
        format!("sample {}, row {}, column {}", wrong.index, wrong.window.first[0], wrong.window.first[1]),
        format!("{} taken for {}", sidecar.classes[wrong.truth], sidecar.classes[wrong.guess]),
        format!("confidence {:.3}", wrong.confidence),
    ];
    let longest = words.iter().map(|words| words.len() as u32 * LETTER).max().unwrap_or(0);
    let all = panels.len() as u32 * (width + MARGIN);
    let legend = if maps.is_some() { sidecar.classes.as_slice() } else { &[] };
    let mut page = Page::new(MARGIN + all.max(longest + MARGIN), 90 + height + LEGEND_LINE_PX * legend.len() as u32);
    for (i, words) in words.iter().enumerate() {
        page.words(MARGIN, 18 + 16 * i as u32, words);
    }
    for (i, (name, picture)) in panels.iter().enumerate() {
        let left = MARGIN + i as u32 * (width + MARGIN);
        page.words_in(left, 74, name, INK);
        page.picture(left, 80, picture);
    }
    for (class, name) in (0..).zip(legend) {
        let y = 88 + height + LEGEND_LINE_PX * u32::from(class);
        page.picture(MARGIN, y, &RgbImage::from_pixel(10, 10, colour(class, sidecar)));
        page.words(MARGIN + 16, y + 9, name);
    }
    page.0
}

/// Colour of a class of the model.
fn colour(class: u8, sidecar: &Sidecar) -> Rgb<u8> {
    viridis(f32::from(class) / (sidecar.classes.len() - 1) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrong(confidence: f64, index: u64) -> Misclassification {
        let window = InputWindow { first: [0, 0], size: [1, 1] };
        Misclassification { index, id: String::new(), window, truth: 0, guess: 1, confidence, picture: None }
    }

    /// The same list comes out whatever the order in which they came.
    #[test]
    fn the_worst_are_kept_in_order() {
        let all = [(0.5, 1), (0.9, 2), (0.9, 0), (0.7, 3), (0.6, 4)];
        for turn in 0..all.len() {
            let mut worst = Vec::new();
            let mut drawn = 0;
            for i in 0..all.len() {
                let (confidence, index) = all[(i + turn) % all.len()];
                keep_worst(&mut worst, 3, wrong(confidence, index), |_| {
                    drawn += 1;
                    None
                });
            }
            let kept: Vec<_> = worst.iter().map(|w| (w.confidence, w.index)).collect();
            assert_eq!(kept, [(0.9, 0), (0.9, 2), (0.7, 3)]);
            assert!((3..=5).contains(&drawn));
        }
        let mut none = Vec::new();
        keep_worst(&mut none, 0, wrong(1.0, 0), |_| panic!("nobody wants a picture"));
        assert!(none.is_empty());
    }
}
