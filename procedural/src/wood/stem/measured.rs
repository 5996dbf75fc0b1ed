//! What a measured stem must be: sizes, numbers and ranges of its three tables.
//!
//! Models: none; every fault names the table, the row counted from 1, what is wrong and what to do. The first fault is
//! told. Source: the file format of the scanned log of Larsson et al. (2022). Ranges are those of trees: what lies
//! beyond them is a wrong unit or a shifted column.

use std::fmt;

/// Fewest azimuths of a section.
const LEAST_AZIMUTHS: usize = 8;
/// Most knots: the scanned log has 108 over 4 m, and each is looked at for every board.
const MOST_KNOTS: usize = 10_000;
/// Radii of stems [mm].
const RADII_MM: [f64; 2] = [1.0, 2000.0];
/// Largest A [rad]: wider than its distance from the pith no branch is.
const WIDEST_OPENING: f64 = 1.5;
/// Steepest slope of an axis 10 mm from the pith and beyond [1].
const STEEPEST: f64 = 5.0;
/// Largest F: two turns [rad].
const LARGEST_AZIMUTH: f64 = 4.0 * std::f64::consts::PI;
/// Largest G [rad]; the scanned log has 0.17.
const LARGEST_TURN: f64 = 0.5;
/// Branches may begin this far beyond the ends of the pith [mm].
const BEYOND_MM: f64 = 1000.0;

/// What is wrong with a measured stem.
#[derive(Debug, Clone, PartialEq)]
pub enum StemError {
    /// A table has too few rows.
    TooFewRows {
        /// Which table: pith, radii or knots.
        table: &'static str,
        /// Rows that it has.
        rows: usize,
        /// Rows that it needs.
        least: usize,
    },
    /// A table has more rows than a stem can have.
    TooManyRows {
        /// Which table.
        table: &'static str,
        /// Rows that it has.
        rows: usize,
        /// The most.
        most: usize,
    },
    /// There are more sections of radii than points of the pith.
    TooManySections {
        /// Sections of radii.
        sections: usize,
        /// Points of the pith.
        points: usize,
    },
    /// A section has another number of radii than the first, or too few.
    SectionSize {
        /// Section, from 1.
        row: usize,
        /// Radii that it has.
        radii: usize,
        /// Radii that it needs.
        needed: usize,
    },
    /// A number is not finite.
    NotFinite {
        /// Which table.
        table: &'static str,
        /// Row, from 1.
        row: usize,
        /// Column as the table calls it: x, y and height, the number of a radius from 1, or A to I.
        column: String,
    },
    /// The heights of the pith do not rise.
    HeightNotRising {
        /// Row, from 1.
        row: usize,
        /// Its height [mm].
        height: f64,
        /// The height of the row before [mm].
        before: f64,
    },
    /// A number lies outside of what trees have.
    OutOfRange {
        /// Which table.
        table: &'static str,
        /// Row, from 1.
        row: usize,
        /// What it is, with its column and unit.
        what: String,
        /// The number.
        value: f64,
        /// Least and most.
        range: [f64; 2],
    },
}

impl fmt::Display for StemError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewRows { table, rows, least } => {
                let what = match *table {
                    "pith" => "rows of x, y and height",
                    "radii" => "sections, one row of radii each",
                    _ => "rows of the nine numbers A to I",
                };
                write!(f, "{table}: {rows} rows, but at least {least} are needed; give {what}")
            }
            Self::TooManyRows { table, rows, most } => {
                write!(f, "{table}: {rows} rows, but at most {most} can be; leave out rows, or give a part of the stem")
            }
            Self::TooManySections { sections, points } => write!(
                f,
                "radii: {sections} sections for {points} points of the pith; give as many as the pith has points, or \
                    fewer in \
                 equal steps from its first to its last height"
            ),
            Self::SectionSize { row, radii, needed } => write!(
                f,
                "radii, row {row}: {radii} radii where {needed} are needed; give every section the same number of \
                    radii, at least \
                 {LEAST_AZIMUTHS}, in equal steps of a whole turn"
            ),
            Self::NotFinite { table, row, column } => write!(
                f,
                "{table}, row {row}: column {column} is not a finite number; measure it again, fill it in from its \
                    neighbours, or \
                 leave a knot out"
            ),
            Self::HeightNotRising { row, height, before } => write!(
                f,
                "pith, row {row}: height {height} mm after {before} mm; sort the rows by height and leave out \
                    repeated heights"
            ),
            Self::OutOfRange { table, row, what, value, range: [least, most] } => write!(
                f,
                "{table}, row {row}: {what} is {value}, outside {least} to {most}; check its unit (mm and rad) and \
                    the order of the \
                 columns"
            ),
        }
    }
}

impl std::error::Error for StemError {}

fn in_range(table: &'static str, row: usize, what: &str, value: f64, range: [f64; 2]) -> Result<(), StemError> {
    if (range[0]..=range[1]).contains(&value) {
        return Ok(());
    }
    Err(StemError::OutOfRange { table, row, what: what.to_owned(), value, range })
}

fn finite(table: &'static str, row: usize, values: &[f64], name: impl Fn(usize) -> String) -> Result<(), StemError> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(column) => Err(StemError::NotFinite { table, row, column: name(column) }),
        None => Ok(()),
    }
}

/// Whether the tables are those of a stem.
pub(super) fn check(pith: &[[f64; 3]], radii: &[Vec<f64>], knots: &[[f64; 9]]) -> Result<(), StemError> {
    for (table, rows, least) in [("pith", pith.len(), 2), ("radii", radii.len(), 2), ("knots", knots.len(), 1)] {
        if rows < least {
            return Err(StemError::TooFewRows { table, rows, least });
        }
    }
    if knots.len() > MOST_KNOTS {
        return Err(StemError::TooManyRows { table: "knots", rows: knots.len(), most: MOST_KNOTS });
    }
    if radii.len() > pith.len() {
        return Err(StemError::TooManySections { sections: radii.len(), points: pith.len() });
    }
    for (i, point) in pith.iter().enumerate() {
        finite("pith", i + 1, point, |column| ["x", "y", "height"][column].to_owned())?;
        if i > 0 && point[2] <= pith[i - 1][2] {
            return Err(StemError::HeightNotRising { row: i + 1, height: point[2], before: pith[i - 1][2] });
        }
    }
    let needed = radii[0].len().max(LEAST_AZIMUTHS);
    for (i, section) in radii.iter().enumerate() {
        if section.len() != needed {
            return Err(StemError::SectionSize { row: i + 1, radii: section.len(), needed });
        }
        finite("radii", i + 1, section, |column| (column + 1).to_string())?;
        for (column, &radius) in section.iter().enumerate() {
            in_range("radii", i + 1, &format!("the radius in column {} [mm]", column + 1), radius, RADII_MM)?;
        }
    }
    let heights = [pith[0][2] - BEYOND_MM, pith[pith.len() - 1][2] + BEYOND_MM];
    for (i, row) in knots.iter().enumerate() {
        let i = i + 1;
        finite("knots", i, row, |column| char::from(b'A' + column as u8).to_string())?;
        let &[a, b, c, d, e, f, g, end, death] = row;
        in_range("knots", i, "A, the opening [rad],", a, [1.0e-4, WIDEST_OPENING])?;
        in_range("knots", i, "C, the height at the pith [mm],", c, heights)?;
        in_range("knots", i, "F, the azimuth [rad],", f, [-LARGEST_AZIMUTH, LARGEST_AZIMUTH])?;
        in_range("knots", i, "G, the turn about the stem [rad],", g, [-LARGEST_TURN, LARGEST_TURN])?;
        in_range("knots", i, "H, the distance where it ends [mm],", end, RADII_MM)?;
        in_range("knots", i, "I, the distance where it died [mm],", death, RADII_MM)?;
        for r in [10.0, end] {
            let slope = e + 0.5 * d / r.sqrt();
            in_range("knots", i, "the slope of the axis (D and E)", slope, [-STEEPEST, STEEPEST])?;
        }
        // Where B is negative the width stays from its maximum on, so that it can only be too large.
        let opening = a + b.max(0.0) * end.sqrt().sqrt();
        in_range("knots", i, "the width where it ends over that distance (A and B)", opening, [0.0, WIDEST_OPENING])?;
    }
    Ok(())
}
