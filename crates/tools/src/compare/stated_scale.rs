//! What the user states of scans whose files hold bare numbers: what a count of Range is, which number stands for a
//! missing height, how far columns and profiles lie apart, how many bits the camera has. Nothing of it is guessed: what
//! is needed and not stated is a fault that names the option.

use std::path::Path;

use super::formats::stated_words;
use super::scan_format::{CsvForm, StatedForm};
use super::{RangeUnit, to_eight_bits};
use dataset::Fault;

/// Largest height that is believed, 1 km [mm]; what lies beyond stands for a missing one, or is damage.
const MAX_HEIGHT: f64 = 1e6;

/// What one of the numbers in Range is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CountScale {
    /// Height [mm].
    Mm(f64),
    /// Rows of the sensor [px].
    Px(f64),
}

/// Which number of Range stands for a missing height; numbers that are not finite always do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MissingNumber {
    /// None: each is a height.
    None,
    /// This one, as the file holds it.
    Number(f64),
}

/// What is stated; `None` where nothing is said.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StatedScale {
    /// One of the numbers in Range.
    pub count: Option<CountScale>,
    /// Added to heights after that [mm, or px where counts are rows].
    pub offset: Option<f64>,
    /// Number of a missing height.
    pub missing: Option<MissingNumber>,
    /// Distance between two columns [mm].
    pub col_mm: Option<f64>,
    /// Distance between two profiles [mm].
    pub row_mm: Option<f64>,
    /// Bits of the camera's digital numbers.
    pub bits: Option<u64>,
    /// Columns of a cloud of points that is stored profile by profile.
    pub cols: Option<usize>,
    /// What the lines of CSV files are.
    pub csv: Option<CsvForm>,
}

impl StatedScale {
    /// The first option that has no effect on files of these forms, and why. Their content may refuse further ones.
    pub fn without_effect(&self, forms: &[StatedForm]) -> Option<String> {
        let given = [
            ("--mm-per-count, --um-per-count and --px-per-count", self.count.is_some()),
            ("--offset", self.offset.is_some()),
            ("--missing", self.missing.is_some()),
            ("--col-mm", self.col_mm.is_some()),
            ("--row-mm", self.row_mm.is_some()),
            ("--bits", self.bits.is_some()),
        ];
        let remedy = "leave it away";
        if forms.is_empty()
            && let Some((name, _)) = given.iter().find(|(_, given)| *given)
        {
            return Some(format!(
                "{name}: no effect, for both sides say their scale themselves (it is of {}); {remedy}",
                stated_words()
            ));
        }
        if self.csv.is_some() && !forms.contains(&StatedForm::Csv) {
            return Some(format!("--csv: no effect, for no side is a CSV file; {remedy}"));
        }
        if self.cols.is_some() && !forms.iter().any(|form| *form != StatedForm::Image) {
            return Some(format!("--cols: no effect, for no side is a cloud of points (.ply, .csv); {remedy}"));
        }
        None
    }

    /// What heights are, and what one of the file's numbers is [mm or px]; `of_file` is what the file says of it [mm].
    pub(super) fn height_scale(&self, path: &Path, of_file: Option<f64>) -> Result<(RangeUnit, f64), Fault> {
        match (of_file, self.count) {
            (Some(mm), None) => Ok((RangeUnit::Mm, mm)),
            (None, Some(CountScale::Mm(mm))) => Ok((RangeUnit::Mm, mm)),
            (None, Some(CountScale::Px(px))) => Ok((RangeUnit::Px { sensor_rows: 0 }, px)),
            (Some(_), Some(_)) => {
                let what = "its header names the unit of heights itself";
                Err(Fault::at(path, what, "leave --mm-per-count, --um-per-count or --px-per-count away"))
            }
            (None, None) => {
                let what = "it does not say what one of its numbers is";
                let remedy =
                    "give --mm-per-count (1 where they are mm), --um-per-count, or --px-per-count for sensor rows";
                Err(Fault::at(path, what, remedy))
            }
        }
    }

    /// Whether a number of the file is a missing height.
    pub(super) fn is_missing(&self, number: f64) -> bool {
        let stated = match self.missing {
            // A file may hold it in single precision.
            Some(MissingNumber::Number(stated)) => number == stated || number == f64::from(stated as f32),
            Some(MissingNumber::None) | None => false,
        };
        stated || !number.is_finite()
    }

    /// A height of a number [mm or px]; NaN where it is missing.
    ///
    /// # Errors
    /// Where it is beyond belief.
    pub(super) fn height(&self, number: f64, scale: f64) -> Result<f64, String> {
        if self.is_missing(number) {
            return Ok(f64::NAN);
        }
        let height = self.offset.unwrap_or(0.0) + scale * number;
        if height.abs() <= MAX_HEIGHT {
            Ok(height)
        } else {
            Err(format!("its number {number} is a height of {height:e}"))
        }
    }

    /// Heights of the numbers of a file [mm or px]; NaN where missing. Of whole numbers (`is_whole`) any may stand for
    /// a missing height, so that has to be stated.
    pub(super) fn heights(&self, path: &Path, numbers: &[f64], scale: f64, is_whole: bool) -> Result<Vec<f64>, Fault> {
        if is_whole && self.missing.is_none() {
            let what = "it does not say which of its counts stands for a missing height";
            return Err(Fault::at(path, what, "give --missing 0, another number, or --missing none"));
        }
        let heights = numbers.iter().map(|&number| self.height(number, scale));
        heights.collect::<Result<_, _>>().map_err(|what| Self::unbelievable(path, what))
    }

    /// The fault of a height beyond belief.
    pub(super) fn unbelievable(path: &Path, what: String) -> Fault {
        let remedy = "give its number to --missing if it stands for a missing height, else check the scale";
        Fault::at(path, what, remedy)
    }

    /// Bits of digital numbers; `of_file` is what the type of Reflectance in the file says.
    pub(super) fn bits(&self, path: &Path, of_file: Option<u64>) -> Result<u64, Fault> {
        match (of_file, self.bits) {
            (Some(found), Some(stated)) if found != stated => {
                Err(Fault::at(path, format!("its Reflectance has {found} bits, not {stated}"), "leave --bits away"))
            }
            (Some(bits), _) | (None, Some(bits)) => Ok(bits),
            (None, None) => {
                let what = "it does not say how many bits the camera's digital numbers have";
                Err(Fault::at(path, what, "give --bits, 8 to 16"))
            }
        }
    }
}

/// Reflectance of digital numbers of so many bits, on the scale of 8 bits; 0 where missing.
///
/// # Errors
/// Where a number has more bits, or is below zero.
pub(super) fn reflectance(numbers: &[f64], bits: u64) -> Result<Vec<f32>, String> {
    let most = ((1_u64 << bits) - 1) as f64;
    let wrong = numbers.iter().find(|dn| dn.is_finite() && !(0.0..=most).contains(*dn));
    match wrong {
        Some(dn) => Err(format!("its Reflectance {dn} is no digital number of {bits} bits")),
        None => Ok(scatter(numbers, bits)),
    }
}

/// Scatter, a sum of digital numbers of so many bits, on the scale of 8 bits; 0 where missing.
pub(super) fn scatter(numbers: &[f64], bits: u64) -> Vec<f32> {
    let scale = to_eight_bits(bits);
    numbers.iter().map(|&dn| if dn.is_finite() { scale * dn as f32 } else { 0.0 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(result: Result<impl std::fmt::Debug, Fault>, words: &str) {
        let fault = result.expect_err(words).to_string();
        assert!(fault.contains(words), "'{words}' is not in: {fault}");
    }

    /// What is not stated is asked for by the name of its option, and what the file says itself is not stated again.
    #[test]
    fn what_is_needed_is_asked_for() {
        let path = Path::new("a.png");
        let nothing = StatedScale::default();
        told(nothing.height_scale(path, None), "--mm-per-count (1 where they are mm)");
        told(nothing.heights(path, &[0.0], 1.0, true), "--missing 0");
        told(nothing.bits(path, None), "--bits, 8 to 16");
        let stated = StatedScale { count: Some(CountScale::Mm(0.5)), bits: Some(10), ..StatedScale::default() };
        told(stated.height_scale(path, Some(1.0)), "leave --mm-per-count");
        told(stated.bits(path, Some(8)), "has 8 bits, not 10");
        assert_eq!(stated.height_scale(path, None), Ok((RangeUnit::Mm, 0.5)));
        assert_eq!((stated.bits(path, None), nothing.bits(path, Some(8))), (Ok(10), Ok(8)));
    }

    /// Offset and scale by hand; the missing number is missing in single precision too, and what is not finite always
    /// is.
    #[test]
    fn heights_by_hand() {
        let path = Path::new("a.tif");
        let missing = Some(MissingNumber::Number(-3.4e38));
        let stated = StatedScale { offset: Some(-1.0), missing, ..StatedScale::default() };
        let numbers = [2.0, f64::from(-3.4e38_f32), -3.4e38, f64::NAN, f64::NEG_INFINITY];
        let found = stated.heights(path, &numbers, 0.25, true).expect("each is a height or missing");
        assert_eq!(found[0], -0.5);
        assert!(found[1..].iter().all(|z| z.is_nan()));
        let all = StatedScale { missing: Some(MissingNumber::None), ..StatedScale::default() };
        assert_eq!(all.heights(path, &[0.0, 3.0], 0.5, true), Ok(vec![0.0, 1.5]));
        told(all.heights(path, &[1e300], 1.0, false), "--missing");
    }

    /// Digital numbers come to the scale of 8 bits; more than their bits hold is told.
    #[test]
    fn digital_numbers_by_hand() {
        assert_eq!(reflectance(&[1023.0, 0.0, f64::NAN], 10), Ok(vec![255.0, 0.0, 0.0]));
        assert_eq!(reflectance(&[255.0], 8), Ok(vec![255.0]));
        assert!(reflectance(&[1024.0], 10).is_err() && reflectance(&[-1.0], 8).is_err());
        assert_eq!(scatter(&[2046.0], 10), [510.0]);
    }

    /// An option that no side has a use for is told.
    #[test]
    fn options_without_effect_are_told() {
        let offset = StatedScale { offset: Some(1.0), ..StatedScale::default() };
        assert!(offset.without_effect(&[]).is_some_and(|what| what.starts_with("--offset")));
        assert_eq!(offset.without_effect(&[StatedForm::Image]), None);
        let csv = StatedScale { csv: Some(CsvForm::Grid), ..StatedScale::default() };
        assert!(csv.without_effect(&[StatedForm::Ply]).is_some_and(|what| what.starts_with("--csv")));
        let cols = StatedScale { cols: Some(4), ..StatedScale::default() };
        assert!(cols.without_effect(&[StatedForm::Image]).is_some_and(|what| what.starts_with("--cols")));
        assert_eq!((csv.without_effect(&[StatedForm::Csv]), cols.without_effect(&[StatedForm::Ply])), (None, None));
    }
}
