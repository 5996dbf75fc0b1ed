//! Input windows of a model: cut out of the maps, resized by area averaging, normalised.
//!
//! Cell i of n along a side of N pixels covers the pixels `floor(iN/n)` to `ceil((i+1)N/n)` and takes the mean of those
//! that were measured; it is missing where none was, and so is all outside of the image. What was measured becomes
//! `(value - mean) / sd`; with `relative` the mean of the window's cells is taken off before. What is missing becomes
//! `missing`, after normalisation. The truth of a cell is the label of its middle pixel.

use super::sidecar::{InputChannel, Layout};

/// A map as it was read, row-major.
#[derive(Debug, Clone, PartialEq)]
pub enum StoredMap {
    /// Digital numbers, 0 where missing.
    Eight(Vec<u8>),
    /// `offset + n * scale`, missing where n is 0.
    Sixteen {
        /// Whole numbers.
        pixels: Vec<u16>,
        /// What number 0 would mean.
        offset: f64,
        /// What a step means.
        scale: f64,
    },
    /// Plain numbers, NaN where missing.
    Float(Vec<f32>),
}

impl StoredMap {
    /// Pixels.
    pub fn len(&self) -> usize {
        match self {
            Self::Eight(pixels) => pixels.len(),
            Self::Sixteen { pixels, .. } => pixels.len(),
            Self::Float(pixels) => pixels.len(),
        }
    }
}

/// The maps of one sample.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleMaps {
    /// Rows and columns [px].
    pub size: [usize; 2],
    /// Maps in the order of the sidecar's channels.
    pub planes: Vec<StoredMap>,
    /// Pixel classes; empty where no window needs them.
    pub labels: Vec<u8>,
}

/// A part of an image; it may reach over the border.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InputWindow {
    /// First row and column [px].
    pub first: [i64; 2],
    /// Rows and columns [px].
    pub size: [usize; 2],
}

impl InputWindow {
    /// The one around a pixel: of an even size the pixel is the first behind the middle.
    pub fn around(centre: [i64; 2], size: [usize; 2]) -> Self {
        Self { first: std::array::from_fn(|i| centre[i] - (size[i] / 2) as i64), size }
    }

    /// The pixels that cell `cell` of `cells` covers along `side`, cut at the image of `length`: first and end.
    fn span(&self, side: usize, cell: usize, cells: usize, length: usize) -> [usize; 2] {
        let n = self.size[side];
        let inside = |place: usize| (self.first[side] + place as i64).clamp(0, length as i64) as usize;
        [inside(cell * n / cells), inside(((cell + 1) * n).div_ceil(cells))]
    }

    /// Cells, of `cells` rows and columns, whose middle lies in the image.
    pub fn inside(&self, cells: [usize; 2], image: [usize; 2]) -> u64 {
        let along =
            |side: usize| (0..cells[side]).filter(move |&i| self.middle(side, i, cells[side], image[side]).is_some());
        (along(0).count() * along(1).count()) as u64
    }

    /// The middle pixel of a cell along `side`, where it lies in the image of `length`.
    fn middle(&self, side: usize, cell: usize, cells: usize, length: usize) -> Option<usize> {
        let place = self.first[side] + ((2 * cell + 1) * self.size[side] / (2 * cells)) as i64;
        usize::try_from(place).ok().filter(|&place| place < length)
    }
}

/// Fills `out`, `[channels, rows, columns]` or `[rows, columns, channels]` by layout, with a window of the picture.
pub(crate) fn fill_input(
    out: &mut [f32],
    picture: &SampleMaps,
    window: InputWindow,
    channels: &[InputChannel],
    size: [usize; 2],
    layout: Layout,
) {
    let cells = size[0] * size[1];
    let mut buffer = vec![0.0; if layout == Layout::Nhwc { cells } else { 0 }];
    for (c, (channel, map)) in channels.iter().zip(&picture.planes).enumerate() {
        let plane = if layout == Layout::Nchw { &mut out[c * cells..][..cells] } else { &mut buffer[..] };
        match map {
            StoredMap::Eight(pixels) => {
                let number = |n: u8| if n == 0 { f32::NAN } else { f32::from(n) };
                resize_by_mean(plane, pixels, number, picture.size, window, size);
            }
            StoredMap::Sixteen { pixels, offset, scale } => {
                let (offset, scale) = (*offset as f32, *scale as f32);
                let number = |n: u16| if n == 0 { f32::NAN } else { offset + f32::from(n) * scale };
                resize_by_mean(plane, pixels, number, picture.size, window, size);
            }
            StoredMap::Float(pixels) => resize_by_mean(plane, pixels, |value| value, picture.size, window, size),
        }
        normalise(plane, channel);
        if layout == Layout::Nhwc {
            let cells = out.iter_mut().skip(c).step_by(channels.len());
            cells.zip(&buffer).for_each(|(out, value)| *out = *value);
        }
    }
}

/// Means of what was measured in each cell, `[rows, columns]`; NaN where nothing was. `number` says what a pixel means.
fn resize_by_mean<T: Copy>(
    out: &mut [f32],
    pixels: &[T],
    number: impl Fn(T) -> f32,
    image: [usize; 2],
    window: InputWindow,
    size: [usize; 2],
) {
    if window.size == size {
        return copy_pixels(out, pixels, number, image, window);
    }
    let spans: Vec<[usize; 2]> = (0..size[1]).map(|col| window.span(1, col, size[1], image[1])).collect();
    for row in 0..size[0] {
        let [top, bottom] = window.span(0, row, size[0], image[0]);
        for (out, [left, right]) in out[row * size[1]..][..size[1]].iter_mut().zip(&spans) {
            let (mut sum, mut count) = (0.0, 0_u32);
            for r in top..bottom {
                for &pixel in &pixels[r * image[1] + left..r * image[1] + right] {
                    let value = number(pixel);
                    if !value.is_nan() {
                        sum += f64::from(value);
                        count += 1;
                    }
                }
            }
            *out = if count == 0 { f32::NAN } else { (sum / f64::from(count)) as f32 };
        }
    }
}

/// The window as it is, for cells of one pixel each.
fn copy_pixels<T: Copy>(
    out: &mut [f32],
    pixels: &[T],
    number: impl Fn(T) -> f32,
    image: [usize; 2],
    window: InputWindow,
) {
    let cols = window.size[1];
    let inside = |side: usize, place: usize| (window.first[side] + place as i64).clamp(0, image[side] as i64) as usize;
    let (left, right) = (inside(1, 0), inside(1, cols));
    let before = (left as i64 - window.first[1]).clamp(0, cols as i64) as usize;
    for (row, out) in out.chunks_exact_mut(cols).enumerate() {
        let count = if inside(0, row + 1) > inside(0, row) { right - left } else { 0 };
        let first = if count > 0 { inside(0, row) * image[1] + left } else { 0 };
        let (outside, out) = out.split_at_mut(before);
        let (out, beyond) = out.split_at_mut(count);
        outside.fill(f32::NAN);
        out.iter_mut().zip(&pixels[first..first + count]).for_each(|(out, &pixel)| *out = number(pixel));
        beyond.fill(f32::NAN);
    }
}

fn normalise(plane: &mut [f32], channel: &InputChannel) {
    let mut shift = channel.mean;
    if channel.relative {
        shift += mean(plane);
    }
    let (shift, sd, missing) = (shift as f32, channel.sd as f32, channel.missing as f32);
    for value in plane {
        *value = if value.is_nan() { missing } else { (*value - shift) / sd };
    }
}

/// Mean of what was measured, 0 where nothing was; several sums side by side, since one waits for each addition.
fn mean(plane: &[f32]) -> f64 {
    const SUMS: usize = 8;
    let (mut sums, mut counts) = ([0.0; SUMS], [0_u32; SUMS]);
    let mut add = |i: usize, value: f32| {
        sums[i] += if value.is_nan() { 0.0 } else { f64::from(value) };
        counts[i] += u32::from(!value.is_nan());
    };
    let (rows, rest) = plane.as_chunks::<SUMS>();
    rows.iter().for_each(|row| (0..SUMS).for_each(|i| add(i, row[i])));
    rest.iter().enumerate().for_each(|(i, &value)| add(i, value));
    sums.iter().sum::<f64>() / f64::from(counts.iter().sum::<u32>().max(1))
}

/// The model's class of each cell, `[rows, columns]`; `NO_CLASS` outside and where the label belongs to no class.
pub fn truth(picture: &SampleMaps, window: InputWindow, size: [usize; 2], classes: &[Option<usize>]) -> Vec<u8> {
    let class = |label: u8| classes.get(usize::from(label)).copied().flatten().map_or(NO_CLASS, |class| class as u8);
    let mut truth = Vec::with_capacity(size[0] * size[1]);
    for row in 0..size[0] {
        let from = window.middle(0, row, size[0], picture.size[0]);
        truth.extend((0..size[1]).map(|col| {
            let place = from.zip(window.middle(1, col, size[1], picture.size[1]));
            place.map_or(NO_CLASS, |(row, col)| class(picture.labels[row * picture.size[1] + col]))
        }));
    }
    truth
}

/// Stands for no class in [`truth`].
pub(crate) const NO_CLASS: u8 = 255;

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(mean: f64, sd: f64, missing: f64, relative: bool) -> InputChannel {
        InputChannel { name: "scatter".into(), mean, sd, missing, relative }
    }

    /// Three rows of four: 1 2 3 4 / 5 0 7 8 / 9 10 11 12, 0 is missing.
    fn picture() -> SampleMaps {
        let pixels = vec![1, 2, 3, 4, 5, 0, 7, 8, 9, 10, 11, 12];
        let labels = vec![0, 0, 1, 1, 0, 0, 1, 1, 2, 2, 2, 2];
        SampleMaps { size: [3, 4], planes: vec![StoredMap::Eight(pixels)], labels }
    }

    fn cut(window: InputWindow, size: [usize; 2], channel: &InputChannel) -> Vec<f32> {
        let mut out = vec![f32::MAX; size[0] * size[1]];
        fill_input(&mut out, &picture(), window, std::slice::from_ref(channel), size, Layout::Nchw);
        out
    }

    #[test]
    fn windows_are_cut_and_normalised() {
        let plain = channel(0.0, 1.0, -1.0, false);
        let window = InputWindow::around([1, 1], [2, 2]);
        assert_eq!(window, InputWindow { first: [0, 0], size: [2, 2] });
        assert_eq!(cut(window, [2, 2], &plain), [1.0, 2.0, 5.0, -1.0]);
        assert_eq!(cut(window, [2, 2], &channel(1.0, 2.0, -9.0, false)), [0.0, 0.5, 2.0, -9.0]);
        // The mean of 1, 2 and 5 is 8/3.
        let relative = cut(window, [2, 2], &channel(0.0, 1.0, 0.0, true));
        for (found, wanted) in relative.iter().zip([1.0 - 8.0 / 3.0, 2.0 - 8.0 / 3.0, 5.0 - 8.0 / 3.0, 0.0]) {
            assert!((found - wanted).abs() < 1e-6);
        }
        // Over the border everything is missing.
        assert_eq!(
            cut(InputWindow::around([0, 0], [3, 3]), [3, 3], &plain),
            [-1.0, -1.0, -1.0, -1.0, 1.0, 2.0, -1.0, 5.0, -1.0]
        );
        assert_eq!(cut(InputWindow::around([50, 50], [2, 1]), [2, 1], &plain), [-1.0, -1.0]);
    }

    /// Whole factors take means of what was measured; others share pixels between cells; growing repeats them.
    #[test]
    fn resizing_takes_means() {
        let plain = channel(0.0, 1.0, -1.0, false);
        let whole = InputWindow { first: [0, 0], size: [3, 4] };
        assert_eq!(cut(whole, [1, 2], &plain), [27.0 / 5.0, 45.0 / 6.0]);
        assert_eq!(cut(whole, [3, 1], &plain), [2.5, 20.0 / 3.0, 10.5]);
        // Rows 0 to 1 and 1 to 2.
        assert_eq!(cut(InputWindow { first: [0, 0], size: [3, 1] }, [2, 1], &plain), [3.0, 7.0]);
        assert_eq!(cut(InputWindow { first: [0, 2], size: [1, 1] }, [2, 2], &plain), [3.0; 4]);
    }

    /// Cells of one pixel are that pixel, wherever the window lies; outside of the image nothing was measured.
    #[test]
    fn copies_are_the_pixels() {
        let pixels: [u8; 12] = std::array::from_fn(|i| i as u8);
        for (row, col) in (-4..6).flat_map(|row| (-5..7).map(move |col| (row, col))) {
            let window = InputWindow { first: [row, col], size: [2, 3] };
            let (mut short, mut long) = ([0.0; 6], [0.0; 6]);
            copy_pixels(&mut short, &pixels, f32::from, [3, 4], window);
            // Every pixel on its own.
            for (cell, out) in long.iter_mut().enumerate() {
                let [r, c] = [row + cell as i64 / 3, col + cell as i64 % 3];
                let inside = (0..3).contains(&r) && (0..4).contains(&c);
                *out = if inside { (4 * r + c) as f32 } else { f32::NAN };
            }
            assert!(
                short.iter().zip(long).all(|(a, b)| *a == b || a.is_nan() && b.is_nan()),
                "{window:?}: {short:?} {long:?}"
            );
        }
    }

    #[test]
    fn layouts_interleave() {
        let mut picture = picture();
        picture.planes.push(StoredMap::Sixteen { pixels: (0..12).collect(), offset: 0.5, scale: 0.25 });
        picture.planes.push(StoredMap::Float((0..12).map(|i| i as f32).collect()));
        let channels = [0, 1, 2].map(|_| channel(0.0, 1.0, -1.0, false));
        let window = InputWindow { first: [0, 0], size: [1, 2] };
        let mut out = vec![0.0; 6];
        fill_input(&mut out, &picture, window, &channels, [1, 2], Layout::Nchw);
        assert_eq!(out, [1.0, 2.0, -1.0, 0.75, 0.0, 1.0]);
        fill_input(&mut out, &picture, window, &channels, [1, 2], Layout::Nhwc);
        assert_eq!(out, [1.0, -1.0, 0.0, 2.0, 0.75, 1.0]);
    }

    #[test]
    fn truth_is_the_middle_pixels_class() {
        let classes = [Some(1), None, Some(0)];
        let whole = InputWindow { first: [0, 0], size: [3, 4] };
        assert_eq!(truth(&picture(), whole, [3, 4], &classes), [1, 1, 255, 255, 1, 1, 255, 255, 0, 0, 0, 0]);
        // Middle pixels: row 1 (the 2nd of 3), columns 1 and 3.
        assert_eq!(truth(&picture(), whole, [1, 2], &classes), [1, 255]);
        let beyond = InputWindow { first: [2, 3], size: [2, 2] };
        assert_eq!(truth(&picture(), beyond, [2, 2], &classes), [0, 255, 255, 255]);
    }

    /// The mean of what was measured, however many cells there are (sums of whole numbers are exact); 0 where nothing
    /// was.
    #[test]
    fn means_leave_out_what_is_missing() {
        for count in [0_u8, 1, 2, 7, 8, 9, 64, 101] {
            let plane: Vec<f32> = (0..count).map(|i| if i % 3 == 0 { f32::NAN } else { f32::from(i) }).collect();
            let known: Vec<f64> = plane.iter().filter(|value| !value.is_nan()).map(|&value| f64::from(value)).collect();
            let wanted = known.iter().sum::<f64>() / known.len().max(1) as f64;
            assert_eq!(mean(&plane), wanted, "{count} cells");
        }
    }
}
