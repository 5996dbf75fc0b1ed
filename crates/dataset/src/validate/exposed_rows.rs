//! Exposed rows: rows of a sample that were exposed again against those on disk, bit for bit, in every image and channel.

use std::fmt::Display;

use bench::settings::Channel;
use exr::prelude::f16;
use output_schema::{DatasetHead, SampleType};

use super::finding::{Code, Finding};
use super::images::DecodedImages;
use super::report::ValidationReport;
use crate::record::ExposedRows;
use crate::{ExrChannel, image_of, map_channels};

/// Rows of one sample that were exposed again, and what differs on disk.
pub(super) struct RowComparison<'a> {
    rows: &'a [ExposedRows],
    /// Their channels, as EXR files have them.
    channels: Vec<Vec<ExrChannel>>,
    /// Maps that differ, and in how many pixels.
    other: Vec<(String, usize)>,
    /// The first pixel that does.
    first: Option<String>,
}

impl<'a> RowComparison<'a> {
    /// Nothing compared yet.
    pub(super) fn new(rows: &'a [ExposedRows], head: &DatasetHead) -> Self {
        let declared = if rows.is_empty() { Vec::new() } else { head.channels() };
        let channels = |row: &ExposedRows| map_channels(&row.maps, &row.labels, row.truth.as_ref(), &declared);
        Self { rows, channels: rows.iter().map(channels).collect(), other: Vec::new(), first: None }
    }

    /// Compares the images of the row, of `cols` columns; `scale` is what the number 0 of Range means and what a step is [mm or
    /// px].
    pub(super) fn images(&mut self, cols: usize, decoded: &DecodedImages, head: &DatasetHead, scale: [f64; 2]) {
        let bits = u32::try_from(head.images.bits).unwrap_or(u32::MAX);
        for row in self.rows {
            for channel in Channel::ALL {
                let Some(stored) = decoded.get(channel.name()) else { continue };
                let made = image_of(&row.maps, &row.labels, channel, bits, scale).numbers();
                let name = format!("`{}`", channel.name());
                self.strip(&name, (row, cols), stored, &made, |a, b| a == b);
            }
        }
    }

    /// Compares a channel of the EXR file, of `cols` columns.
    pub(super) fn channel(&mut self, cols: usize, stored: &ExrChannel) {
        if self.rows.is_empty() {
            return;
        }
        let is_half = stored.sample_type() == SampleType::Half;
        let numbers = stored.as_numbers();
        for (place, row) in self.rows.iter().enumerate() {
            let Some(made) = self.channels[place].iter().find(|channel| channel.name == stored.name) else { continue };
            let made = made.numbers();
            let rounded = |made: f32| if is_half { f16::from_f32(made).to_f32() } else { made };
            let made: Vec<f32> = made.into_iter().map(rounded).collect();
            let same = |a: f32, b: f32| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
            self.strip(&stored.name, (row, cols), &numbers, &made, same);
        }
    }

    /// Compares the pixels of a map in some neighbouring rows.
    fn strip<T: Copy + Display>(
        &mut self,
        name: &str,
        (row, cols): (&ExposedRows, usize),
        stored: &[T],
        made: &[T],
        same: impl Fn(T, T) -> bool,
    ) {
        // Images of another size are told by another rule.
        let from = row.first * cols;
        let Some(stored) = stored.get(from..from + made.len()).filter(|_| row.cols == cols) else { return };
        let mut count = 0;
        for (i, (&stored, &made)) in stored.iter().zip(made).enumerate() {
            if same(stored, made) {
                continue;
            }
            count += 1;
            let place = || format!("{name}, row {}, column {}", row.first + i / cols, i % cols);
            self.first.get_or_insert_with(|| format!("{} is {stored}, exposed again {made}", place()));
        }
        if count > 0 {
            match self.other.iter_mut().find(|(known, _)| known == name) {
                Some((_, sum)) => *sum += count,
                None => self.other.push((name.to_owned(), count)),
            }
        }
    }

    /// Tells what differs, in one fault.
    pub(super) fn tell(self, place: &str, report: &mut ValidationReport) {
        report.rows += self.rows.iter().map(|row| row.labels.class.len() / row.cols.max(1)).sum::<usize>() as u64;
        let Some(first) = self.first else { return };
        let counts: Vec<String> = self.other.iter().map(|(name, count)| format!("{count} of {name}")).collect();
        let rows: Vec<String> = self.rows.iter().map(|row| row.name()).collect();
        let what = format!("pixels of rows {} differ: {}; the first: {first}", rows.join(", "), counts.join(", "));
        report.faults.push(Finding::new(Code::ProfileDiffers, place, what));
    }
}

impl ExposedRows {
    /// Its rows in words.
    fn name(&self) -> String {
        match self.labels.class.len() / self.cols.max(1) {
            0 | 1 => self.first.to_string(),
            rows => format!("{} to {}", self.first, self.first + rows - 1),
        }
    }
}
