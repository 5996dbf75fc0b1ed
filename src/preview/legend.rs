//! Legend of a label image: the colours and names of the pixel classes that it shows.

use base::Class;
use image::RgbImage;

use drawing::{INK, LETTER, Page, class_colour};

/// Height of a line of the legend [px].
const LINE_PX: u32 = 14;

/// The classes that a label image shows, and where each stands in a legend.
pub(super) struct Legend(Vec<(u8, &'static str, [u32; 2])>);

impl Legend {
    /// The classes of `labels`, in lines of `width` [px].
    pub(super) fn of(labels: &[u8], width: u32) -> Self {
        let mut shown = [false; 256];
        labels.iter().for_each(|&class| shown[usize::from(class)] = true);
        let (mut at, mut entries) = ([0, 0], Vec::new());
        for class in Class::ALL.into_iter().filter(|class| shown[*class as usize]) {
            let length = 18 + LETTER * class.name().len() as u32;
            if at[0] > 0 && at[0] + length > width {
                at = [0, at[1] + LINE_PX];
            }
            entries.push((class as u8, class.name(), at));
            at[0] += length;
        }
        Self(entries)
    }

    /// Height of its lines beyond the first [px].
    pub(super) fn more(&self) -> u32 {
        self.0.last().map_or(0, |(_, _, at)| at[1])
    }

    /// Draws it at (x, y), and below it a bar of a round length.
    pub(super) fn draw(&self, page: &mut Page, x: u32, y: u32, mm_per_px: f64) {
        for &(class, name, [left, down]) in &self.0 {
            page.picture(x + left, y + down, &RgbImage::from_pixel(8, 10, class_colour(class)));
            page.words(x + left + 10, y + down + 9, &name.replace('_', " "));
        }
        let mm = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0];
        let mm = mm.into_iter().rfind(|mm| mm / mm_per_px < 120.0).unwrap_or(1.0);
        let length = (mm / mm_per_px).max(1.0) as u32;
        let below = y + self.more() + 20;
        page.picture(x, below, &RgbImage::from_pixel(length, 3, INK));
        page.words(x + length + 6, below + 6, &format!("{mm} mm"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Classes that one picture can show together have colours that an eye tells apart.
    #[test]
    fn colours_differ() {
        for subject in output_schema::SUBJECTS {
            let values = output_schema::label_values(subject, output_schema::SCHEMA_VERSION[1]);
            for (i, &a) in values.iter().enumerate() {
                for &b in &values[..i] {
                    let squares =
                        (0..3).map(|c| (i32::from(class_colour(a).0[c]) - i32::from(class_colour(b).0[c])).pow(2));
                    let apart = f64::from(squares.sum::<i32>()).sqrt();
                    assert!(apart > 40.0, "{} and {}: {apart}", Class::ALL[usize::from(a)].name(), b);
                }
            }
        }
    }

    #[test]
    fn a_legend_lists_what_is_shown_in_lines_that_fit() {
        let legend = Legend::of(&[7, 0, 5, 7, 25], 200);
        let names: Vec<_> = legend.0.iter().map(|(_, name, _)| *name).collect();
        assert_eq!(names, ["background", "flange", "missing", "tablet_on_flange"]);
        assert!(legend.0.iter().all(|(_, name, at)| at[0] + 18 + LETTER * name.len() as u32 <= 200));
        assert_eq!(legend.more(), LINE_PX);
    }
}
