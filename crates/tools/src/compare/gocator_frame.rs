//! CSV as a Gocator's software exports it: blocks of lines, of which one holds a surface as a grid with its places.
//!
//! ```text
//! file  = { block }, blank lines between and within are passed over
//! block = name, { names of fields, their values }, [ grid ], [ "End" ]
//! grid  = "Y\X", { x } line, { y, { z } line }      x, y, z in mm; nothing where z is missing
//! ```
//!
//! Sources: the CSV format in the manual of the Gocator line profile sensors (blocks `Info` with `XResolution` and
//! `YResolution`, `Part` with the attributes of a surface and the grid). No real file was at hand, so it is read as
//! tolerantly as can be: every block is looked through for the resolution, in columns under names or beside them, and
//! every grid is read. A grid of a block named after intensity is Reflectance in 8 bits.

use super::map_numbers::{MAX_PIXELS, MapNumbers};
use super::number_text::{Refusal, Separator, number, shown};

/// What the first line of a grid begins with.
const CORNER: &str = "Y\\X";
/// Largest relative difference of the resolution in the head and of places beside the grid: that of rounded places.
const SAME_PITCH: f64 = 0.02;

/// A surface.
#[derive(Debug, PartialEq)]
pub(super) struct GocatorSurface {
    /// Heights [mm].
    pub(super) range: MapNumbers,
    /// Intensity on the same grid, where the file has it [DN of 8 bits].
    pub(super) intensity: Option<Vec<f64>>,
    /// Distance between columns and between profiles, where there are two [mm].
    pub(super) pitch_mm: [Option<f64>; 2],
    /// x of column 0 [mm].
    pub(super) first_mm: f64,
}

/// A grid with the places beside it.
struct FrameGrid {
    x: Vec<f64>,
    y: Vec<f64>,
    values: Vec<f64>,
    is_intensity: bool,
}

/// Whether a text is such an export: one of its lines begins with `Y\X`.
pub(super) fn is_export(text: &str) -> bool {
    text.match_indices(CORNER).any(|(at, _)| {
        let before = text[..at].trim_end_matches(['"', ' ', '\u{feff}']);
        before.is_empty() || before.ends_with('\n')
    })
}

/// Reads the surface of an export.
pub(super) fn surface(text: &str) -> Result<GocatorSurface, Refusal> {
    let mut lines = text.trim_start_matches('\u{feff}').lines().enumerate().peekable();
    let mut grids: Vec<FrameGrid> = Vec::new();
    let mut resolution = [None; 2];
    let mut is_intensity = false;
    while let Some((i, line)) = lines.next() {
        if line.trim().is_empty() {
            continue;
        }
        let separator = Separator::of(line);
        let mut in_line = separator.fields(line);
        if in_line.next().is_some_and(|corner| corner.eq_ignore_ascii_case(CORNER)) {
            let x = places(i + 1, &in_line.collect::<Vec<_>>())?;
            let mut grid = FrameGrid { x, y: Vec::new(), values: Vec::new(), is_intensity };
            while let Some((i, line)) = lines.next_if(|(_, line)| line.trim().is_empty() || is_row(line, separator)) {
                if !line.trim().is_empty() {
                    grid.add(i + 1, separator.fields(line))?;
                }
            }
            if let Some((i, line)) = lines.peek()
                && words(line).iter().filter(|word| !word.is_empty()).count() > 1
            {
                let what = format!("line {}: it begins with no place, as a row of a grid does", i + 1);
                return Err((what, "export the surface again, with decimal points"));
            }
            grids.push(grid);
            continue;
        }
        let fields = words(line);
        let mut names = fields.iter().filter(|word| !word.is_empty());
        if let (Some(name), None) = (names.next(), names.next())
            && !name.eq_ignore_ascii_case("end")
        {
            is_intensity = name.to_lowercase().contains("intensity");
        }
        // Values stand below their names, or beside them.
        let below = lines.peek().map_or(Vec::new(), |(_, line)| words(line));
        for (column, field) in fields.iter().enumerate() {
            let Some(axis) = axis_of(field) else { continue };
            let value = |field: Option<&&str>| field.and_then(|field| field.parse::<f64>().ok());
            let found = value(below.get(column)).or_else(|| value(fields.get(column + 1)));
            resolution[axis] = resolution[axis].or(found.filter(|mm| mm.is_finite() && *mm > 0.0));
        }
    }
    let (intensity, mut range): (Vec<FrameGrid>, Vec<FrameGrid>) =
        grids.into_iter().partition(|grid| grid.is_intensity);
    let surfaces = range.len();
    let (Some(grid), 1) = (range.pop(), surfaces) else {
        let what = format!("it holds {surfaces} surfaces");
        return Err((what, "give a file for each, with one grid of heights"));
    };
    let intensity = intensity.into_iter().find(|light| (light.x.len(), light.y.len()) == (grid.x.len(), grid.y.len()));
    let [col_mm, row_mm] = [(&grid.x, resolution[0]), (&grid.y, resolution[1])].map(|(places, mm)| pitch(places, mm));
    if grid.values.is_empty() {
        return Err(("its grid holds no heights".into(), "export the surface again"));
    }
    Ok(GocatorSurface {
        first_mm: grid.x[0],
        range: MapNumbers { cols: grid.x.len(), rows: grid.y.len(), numbers: grid.values, bits: None },
        intensity: intensity.map(|light| light.values),
        pitch_mm: [col_mm, row_mm],
    })
}

/// Names or values of a line outside of grids; names hold blanks.
fn words(line: &str) -> Vec<&str> {
    match Separator::of(line) {
        Separator::Blanks => vec![line.trim()],
        separator => separator.fields(line).collect(),
    }
}

/// Whether a line is a row of a grid: it begins with a place.
fn is_row(line: &str, separator: Separator) -> bool {
    separator.fields(line).next().is_some_and(|place| place.parse::<f64>().is_ok_and(f64::is_finite))
}

/// The axis whose resolution a field names.
fn axis_of(field: &str) -> Option<usize> {
    let name: String = field.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_lowercase();
    ["xresolution", "yresolution"].iter().position(|axis| *axis == name || format!("{axis}mm") == name)
}

/// Places along the line; empty fields at the end, which exports leave, are passed over.
fn places(line: usize, fields: &[&str]) -> Result<Vec<f64>, Refusal> {
    let count = fields.iter().rposition(|field| !field.is_empty()).map_or(0, |last| last + 1);
    let place = |(i, field): (usize, &&str)| {
        let place = field.parse::<f64>().ok().filter(|place| place.is_finite());
        place.ok_or_else(|| {
            let what = format!("line {line}, field {}: '{}' is no place", i + 2, shown(field));
            (what, "export the surface again, with decimal points")
        })
    };
    let found: Vec<f64> = fields[..count].iter().enumerate().map(place).collect::<Result<_, _>>()?;
    if found.is_empty() {
        return Err((format!("line {line}: no places stand behind {CORNER}"), "export the surface again"));
    }
    Ok(found)
}

impl FrameGrid {
    /// Adds a row: its place, then a number for each column; what is missing at its end is missing.
    fn add<'a>(&mut self, line: usize, mut fields: impl Iterator<Item = &'a str>) -> Result<(), Refusal> {
        self.y.extend(fields.next().and_then(|place| place.parse::<f64>().ok()));
        if self.values.len() + self.x.len() > MAX_PIXELS {
            let what = format!("line {line}: it has more than the {MAX_PIXELS} numbers that are compared");
            return Err((what, "give a part"));
        }
        let begin = self.values.len();
        for (i, field) in fields.enumerate() {
            let value = number(field).ok_or_else(|| {
                let what = format!("line {line}, field {}: '{}' is no number", i + 2, shown(field));
                (what, "export the surface again, with decimal points")
            })?;
            if i < self.x.len() {
                self.values.push(value);
            } else if !value.is_nan() {
                let what = format!("line {line}: it has more numbers than the {} columns of its head", self.x.len());
                return Err((what, "export the surface again"));
            }
        }
        self.values.resize(begin + self.x.len(), f64::NAN);
        Ok(())
    }
}

/// The distance between places [mm]: their own, which is exact over many; where they only count, that of the head.
fn pitch(places: &[f64], head: Option<f64>) -> Option<f64> {
    let steps = places.len().saturating_sub(1);
    let own = (steps > 0).then(|| ((places[steps] - places[0]) / steps as f64).abs()).filter(|mm| *mm > 0.0);
    let (Some(own), Some(head)) = (own, head) else { return own.or(head) };
    let is_count = (own - 1.0).abs() < 1e-9 && places.iter().all(|place| place.fract() == 0.0);
    Some(if is_count && (head / own - 1.0).abs() > SAME_PITCH { head } else { own })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An export of a surface of 3 x 2 points, 0.02 and 0.05 mm apart.
    const EXPORT: &str = "Info\nCSV Version,Sensor \
        Count,XResolution,YResolution,ZResolution\n2,1,0.02,0.05,0.001\nEnd\n\
        DeviceInfo\nID,Model\n13434,2330\nEnd\nPart\nFrame,Source,Time,Row Count,Column Count,X \
        Offset\n7,0,1.5,2,3,-0.02\n\
        Y\\X,-0.020,0.000,0.020,\n0.000,1.25,,1.5,\n0.050,-2,3e-1,\nEnd\n";

    /// The grid, its places and its resolution, in every spelling of line ends, separators, quotes and blanks.
    #[test]
    fn exports_are_read() {
        let others = [
            EXPORT.replace('\n', "\r\n"),
            EXPORT.replace(',', ";"),
            EXPORT.replace(',', "\t"),
            format!("\u{feff}{}", EXPORT.replace("Y\\X", "\"Y\\X\"")),
            EXPORT.replace("End\n", "\n").replace("\n0.05", "\n\n0.05"),
            EXPORT.replace("XResolution,YResolution", "X Resolution (mm),Y Resolution (mm)"),
            EXPORT[EXPORT.find("Y\\X").expect("it is there")..].to_owned(),
            EXPORT.replace("DeviceInfo", "Frame\n7\nEnd\nDeviceInfo"),
        ];
        for text in others.iter().map(String::as_str).chain([EXPORT]) {
            assert!(is_export(text), "{text}");
            let found = surface(text).unwrap_or_else(|refusal| panic!("{refusal:?}: {text}"));
            assert_eq!((found.range.cols, found.range.rows, found.first_mm), (3, 2, -0.02), "{text}");
            let z = &found.range.numbers;
            assert!(z[0] == 1.25 && z[1].is_nan() && z[2..5] == [1.5, -2.0, 0.3] && z[5].is_nan(), "{z:?}");
            for (mm, expected) in found.pitch_mm.iter().zip([0.02, 0.05]) {
                assert!(mm.is_some_and(|mm| (mm - expected).abs() < 1e-12), "{:?}: {text}", found.pitch_mm);
            }
        }
        let counted = EXPORT.replace("-0.020,0.000,0.020", "0,1,2");
        assert_eq!(surface(&counted).expect("it is whole").pitch_mm[0], Some(0.02));
        let line = EXPORT.replace("0.050,-2,3e-1,\n", "");
        assert_eq!(surface(&line).expect("it is whole").pitch_mm[1], Some(0.05));
        let lit = EXPORT.to_owned() + "PartIntensity\nY\\X,-0.02,0,0.02\n0,9,,7\n0.05,1,2,3\nEnd\n";
        let light = surface(&lit).expect("it is whole").intensity.expect("it has light");
        assert!(light[0] == 9.0 && light[1].is_nan() && light[2..] == [7.0, 1.0, 2.0, 3.0]);
        for other in ["x,y,z\n1,2,3\n", "# Y\\X\n1,2\n", "", "a,Y\\X\n"] {
            assert!(!is_export(other), "{other}");
        }
    }

    /// What is wrong names its line; any cut of the text is read or refused.
    #[test]
    fn damage_is_told() {
        for (text, words) in [
            (EXPORT.replace("1.25", "1.2.5"), "line 13, field 2: '1.2.5' is no number"),
            (EXPORT.replace(",0.000,0.020,", ",0.000,x,"), "line 12, field 4: 'x' is no place"),
            (EXPORT.replace("\n0.050", "\n0.0.5"), "line 14: it begins with no place"),
            (EXPORT.replace("3e-1,", "3e-1,1,2"), "more numbers than the 3 columns"),
            (EXPORT.replace(",-0.020,0.000,0.020,", ""), "no places"),
            (EXPORT.repeat(2), "it holds 2 surfaces"),
            (EXPORT[..EXPORT.find("0.000,1.25").expect("it is there")].to_owned(), "no heights"),
        ] {
            let (what, _) = surface(&text).expect_err(words);
            assert!(what.contains(words), "'{words}' is not in: {what}");
        }
        for end in 0..EXPORT.len() {
            let _ = surface(&EXPORT[..end]);
        }
    }
}
