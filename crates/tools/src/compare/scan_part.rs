//! The part of a scan that counts: a region, the pixels of a mask, an object.

use super::{ScanMaps, SensorFrame};
use dataset::Fault;

/// A part of a scan: left, top, width, height [px].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScanRegion {
    /// First column.
    pub left: usize,
    /// First profile.
    pub top: usize,
    /// Columns.
    pub columns: usize,
    /// Profiles.
    pub profiles: usize,
}

/// Pixels of a scan that count, as a picture of its size: those that are not black.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScanMask {
    /// Columns.
    pub cols: usize,
    /// Profiles.
    pub rows: usize,
    /// Whether a pixel counts, `[rows, cols]`.
    pub counts: Vec<bool>,
}

impl ScanRegion {
    /// `LEFT,TOP,COLUMNS,PROFILES`.
    ///
    /// # Errors
    /// What is expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let expected = || "give LEFT,TOP,COLUMNS,PROFILES in pixels, for instance 100,0,256,256".to_owned();
        let numbers: Vec<usize> =
            text.split(',').map(|part| part.trim().parse().map_err(|_| expected())).collect::<Result<_, _>>()?;
        match numbers[..] {
            [left, top, columns, profiles] if columns > 0 && profiles > 0 => Ok(Self { left, top, columns, profiles }),
            _ => Err(expected()),
        }
    }

    /// Whether it lies in an image of so many columns and profiles.
    fn is_in(self, cols: usize, rows: usize) -> bool {
        let end = |first: usize, count: usize| first.checked_add(count);
        end(self.left, self.columns).is_some_and(|end| end <= cols)
            && end(self.top, self.profiles).is_some_and(|end| end <= rows)
    }

    fn cut<T: Clone>(self, map: &[T], cols: usize) -> Vec<T> {
        let lines = self.top..self.top + self.profiles;
        lines.flat_map(|y| map[y * cols + self.left..y * cols + self.left + self.columns].iter().cloned()).collect()
    }
}

impl ScanMaps {
    /// Cuts the scan to what counts and tells which pixels of that don't, `[rows, cols]`; `None` where all do and no
    /// part was asked for. `ignored` are pixels of the whole scan that don't count whatever is asked.
    ///
    /// # Errors
    /// Where the part does not fit the scan.
    pub fn cut_to(
        &mut self,
        mut ignored: Option<Vec<bool>>,
        region: Option<ScanRegion>,
        mask: Option<&ScanMask>,
    ) -> Result<Option<Vec<bool>>, Fault> {
        let fault = |what: String, remedy: &str| Fault::new(self.name.clone(), what, remedy.to_owned());
        if let Some(mask) = mask {
            if (mask.cols, mask.rows) != (self.cols, self.rows) {
                let what =
                    format!("it has {} x {} pixels, the mask {} x {}", self.cols, self.rows, mask.cols, mask.rows);
                return Err(fault(what, "give a mask of the scan's size"));
            }
            let before = ignored.unwrap_or_else(|| vec![false; mask.counts.len()]);
            ignored = Some(before.iter().zip(&mask.counts).map(|(ignored, counts)| *ignored || !counts).collect());
        }
        if let Some(region) = region {
            if !region.is_in(self.cols, self.rows) {
                let what = format!("the region reaches beyond its {} columns and {} profiles", self.cols, self.rows);
                return Err(fault(what, "give a region that lies inside"));
            }
            let cols = self.cols;
            self.range = region.cut(&self.range, cols);
            self.x = self.x.take().map(|map| region.cut(&map, cols));
            self.reflectance = self.reflectance.take().map(|map| region.cut(&map, cols));
            self.scatter = self.scatter.take().map(|map| region.cut(&map, cols));
            self.classes = self.classes.take().map(|map| region.cut(&map, cols));
            // With nothing ignored it is a part all the same, beside which of simulated scans the object alone counts.
            ignored = Some(match ignored {
                Some(map) => region.cut(&map, cols),
                None => vec![false; region.columns * region.profiles],
            });
            self.first_mm = self.first_mm.zip(self.col_mm).map(|(first, pitch)| first + pitch * region.left as f64);
            (self.cols, self.rows) = (region.columns, region.profiles);
        }
        Ok(ignored)
    }

    /// The scan without heights where pixels don't count, as if it had ended there.
    #[must_use]
    pub fn without(&self, ignored: &[bool]) -> Self {
        let mut cut = self.clone();
        for (z, _) in cut.range.iter_mut().zip(ignored).filter(|(_, ignored)| **ignored) {
            *z = f64::NAN;
        }
        cut
    }

    /// Darkens the columns of sensor frames in which no pixel counts, of frames whose profile is known; so many
    /// profiles are averaged into a row of the scan.
    pub(super) fn darken_frames(&mut self, ignored: &[bool], binned_profiles: usize) {
        let (map_cols, rows) = (self.cols, self.rows);
        for SensorFrame { cols, profile, dn } in &mut self.exposures {
            let row = profile.map(|profile| profile / binned_profiles).filter(|row| *row < rows);
            let (Some(row), cols) = (row, *cols) else { continue };
            let of_row = &ignored[row * map_cols..][..map_cols];
            for (i, dn) in dn.iter_mut().enumerate() {
                if of_row[i % cols * map_cols / cols] {
                    *dn = 0;
                }
            }
        }
    }
}
