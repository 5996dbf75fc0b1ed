//! Text of numbers: a grid of heights with a profile in each line, or a point in each line.
//!
//! ```text
//! file    = { line }, in UTF-8; blank lines and lines that begin with # are passed over
//! line    = field { separator field }
//! field   = number | "nan" | "NA" | "null" | nothing, with or without quotes; the last four are missing
//! header  = the first line, where one of its fields is none of these
//! ```
//!
//! The separator is the first of tab, semicolon, comma that the first line has, else blanks. Numbers have a decimal
//! point. A header that names x, y and z makes the lines points; `reflectance` (or `intensity`) and `scatter` are read
//! beside them, other names are not. A unit may follow a name: `x_mm`, `z [um]`. Lines without a header are a grid
//! where they have six fields or more; three to five may be either, which the user has to state. `.xyz` holds points by
//! nature, of whose fields the first three count where there are more than five (normals, colours). What a Gocator
//! exports is read as it is ([`gocator_frame`]).

use std::path::Path;

use super::gocator_frame;
use super::map_numbers::{MAX_PIXELS, MapNumbers, POINT_NAMES, ScanPoints, point_axis};
use super::number_text::{Refusal, Separator, number, shown};
use super::scan_format::{CsvForm, ScanContent, ScanFormat, StatedForm, read_file};
use dataset::Fault;

/// Longest file that is read [bytes].
const MAX_FILE_BYTES: u64 = 1 << 30;
/// Where the grammar stands.
const GRAMMAR: &str = "docs/guide/compare.md says how such a file is written";
/// Fields of a point: x, y, z, Reflectance, Scatter.
const FIELDS: usize = POINT_NAMES.len();

/// Numbers as text.
pub(super) const FORMAT: ScanFormat = ScanFormat {
    endings: &[
        ("csv", ".csv", true),
        ("tsv", ".tsv", false),
        ("txt", ".txt", false),
        ("asc", ".asc", false),
        ("xyz", ".xyz", false),
    ],
    stated: Some(StatedForm::Csv),
    read,
};

fn read(path: &Path, form: Option<CsvForm>) -> Result<ScanContent, Fault> {
    let bytes = read_file(path, MAX_FILE_BYTES, "give a file of numbers as text")?;
    let Ok(text) = std::str::from_utf8(&bytes) else {
        return Err(Fault::at(path, "it is no text in UTF-8", "save it as text in UTF-8"));
    };
    let is_cloud = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("xyz"));
    content(text, form, is_cloud).map_err(|(what, remedy)| Fault::at(path, what, remedy))
}

/// The numbers of a line.
fn numbers(line: usize, text: &str, separator: Separator, into: &mut Vec<f64>) -> Result<usize, Refusal> {
    let mut count = 0;
    for field in separator.fields(text) {
        count += 1;
        let Some(number) = number(field) else {
            let is_comma = field.contains(',') && number_with_comma(field);
            let remedy = if is_comma { "write decimals with a point" } else { GRAMMAR };
            return Err((format!("line {line}, field {count}: '{}' is no number", shown(field)), remedy));
        };
        if into.len() == MAX_PIXELS {
            return Err((
                format!("line {line}: it has more than the {MAX_PIXELS} numbers that are compared"),
                "give a part",
            ));
        }
        into.push(number);
    }
    Ok(count)
}

fn number_with_comma(field: &str) -> bool {
    field.replacen(',', ".", 1).parse::<f64>().is_ok()
}

fn content(text: &str, form: Option<CsvForm>, is_cloud: bool) -> Result<ScanContent, Refusal> {
    if gocator_frame::is_export(text) {
        return match form {
            None => gocator_frame::surface(text).map(ScanContent::Surface),
            Some(_) => Err(("it is a Gocator's export, which says what its lines are".into(), "leave --csv away")),
        };
    }
    let form = form.or(is_cloud.then_some(CsvForm::Points));
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));
    let mut lines = lines.filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#')).peekable();
    let Some(&(_, first)) = lines.peek() else { return Err(("it holds no numbers".into(), GRAMMAR)) };
    let separator = Separator::of(first);
    let names: Vec<&str> = separator.fields(first).collect();
    let is_header = names.iter().any(|field| number(field).is_none());
    if is_header {
        lines.next();
    }
    let places = match (is_header.then(|| PointColumns::named(&names)).transpose()?.flatten(), form) {
        (Some(_), Some(CsvForm::Grid)) => {
            return Err(("its header names x, y and z, so it is no grid".into(), "leave --csv away"));
        }
        (Some(columns), _) => Some(columns),
        (None, Some(CsvForm::Points)) if is_header => {
            return Err(("its header does not name x, y and z".into(), GRAMMAR));
        }
        (None, None) if is_header => {
            let remedy = "name them so, or give --csv grid where each line is a profile";
            return Err(("its header does not name x, y and z".into(), remedy));
        }
        (None, Some(CsvForm::Points)) => Some(PointColumns::in_order(names.len(), is_cloud)?),
        (None, Some(CsvForm::Grid)) => None,
        (None, None) if names.len() > FIELDS => None,
        (None, None) => {
            let what = format!("its lines of {} fields may be points or profiles", names.len());
            return Err((what, "give --csv points or --csv grid, or name the fields in a header"));
        }
    };
    match places {
        Some(columns) => points(lines, separator, &columns).map(ScanContent::Points),
        None => grid(lines, separator).map(ScanContent::Grid),
    }
}

fn grid<'a>(lines: impl Iterator<Item = (usize, &'a str)>, separator: Separator) -> Result<MapNumbers, Refusal> {
    let mut map = MapNumbers { cols: 0, rows: 0, numbers: Vec::new(), bits: None };
    for (line, text) in lines {
        let count = numbers(line, text, separator, &mut map.numbers)?;
        if map.rows > 0 && count != map.cols {
            let what = format!("line {line}: it has {count} fields, those before it {}", map.cols);
            return Err((what, "give every profile as many fields, empty ones where heights are missing"));
        }
        (map.cols, map.rows) = (count, map.rows + 1);
    }
    if map.numbers.is_empty() { Err(("it holds no numbers".into(), GRAMMAR)) } else { Ok(map) }
}

/// Which field of a line is x, y, z, Reflectance, Scatter.
struct PointColumns {
    fields: usize,
    at: [Option<usize>; FIELDS],
    unit_mm: Option<f64>,
}

impl PointColumns {
    /// Those that a header names; `None` where it names neither x nor y.
    fn named(names: &[&str]) -> Result<Option<Self>, Refusal> {
        let mut at = [None; FIELDS];
        let mut units = Vec::new();
        for (field, name) in names.iter().enumerate() {
            let name = name.to_lowercase();
            let word = name.split([' ', '_', '[', '(', '/']).next().unwrap_or_default();
            let Some(axis) = point_axis(word) else { continue };
            if at[axis].replace(field).is_some() {
                return Err((format!("its header names {word} twice"), "name each once"));
            }
            if axis < 3 {
                units.push(unit_mm(&name[word.len()..]).ok_or_else(|| {
                    (format!("its header has the unknown unit of '{}'", shown(&name)), "use mm, um or m")
                })?);
            }
        }
        if at[0].is_none() && at[1].is_none() {
            return Ok(None);
        }
        if units.len() < 3 {
            return Err(("its header does not name all of x, y and z".into(), GRAMMAR));
        }
        if units.iter().any(|unit| *unit != units[0]) {
            let what = "its header names different units of x, y and z, or those of some";
            return Err((what.into(), "use one unit, and name it for all three or for none"));
        }
        Ok(Some(Self { fields: names.len(), at, unit_mm: units[0] }))
    }

    /// Those of lines without a header; of clouds that have more than a scan has, x, y and z alone.
    fn in_order(fields: usize, is_cloud: bool) -> Result<Self, Refusal> {
        let is_longer = is_cloud && fields > FIELDS;
        if !(3..=FIELDS).contains(&fields) && !is_longer {
            let what = format!("its lines have {fields} fields, and points are x, y, z, Reflectance and Scatter");
            return Err((what, "give three to five, or name them in a header"));
        }
        let mut at = [None; FIELDS];
        at.iter_mut().take(if is_longer { 3 } else { fields }).enumerate().for_each(|(field, at)| *at = Some(field));
        Ok(Self { fields, at, unit_mm: None })
    }
}

/// A unit behind a name [mm]; the inner one is `None` where nothing stands there.
fn unit_mm(rest: &str) -> Option<Option<f64>> {
    match rest.trim_matches([' ', '_', '[', ']', '(', ')', '/']) {
        "" => Some(None),
        "mm" => Some(Some(1.0)),
        "um" | "µm" | "μm" => Some(Some(1e-3)),
        "m" => Some(Some(1e3)),
        _ => None,
    }
}

fn points<'a>(
    lines: impl Iterator<Item = (usize, &'a str)>,
    separator: Separator,
    columns: &PointColumns,
) -> Result<ScanPoints, Refusal> {
    let mut places = Vec::new();
    let mut light: [Vec<f64>; 2] = Default::default();
    let mut fields = Vec::with_capacity(columns.fields);
    for (line, text) in lines {
        fields.clear();
        let count = numbers(line, text, separator, &mut fields)?;
        if count != columns.fields {
            let what = format!("line {line}: it has {count} fields, not {}", columns.fields);
            return Err((what, "give every point as many fields, empty ones where they are missing"));
        }
        if places.len() == MAX_PIXELS {
            return Err((
                format!("line {line}: it has more than the {MAX_PIXELS} points that are compared"),
                "give a part",
            ));
        }
        let at = |axis: usize| columns.at[axis].map_or(f64::NAN, |field| fields[field]);
        places.push([at(0), at(1), at(2)]);
        for (axis, map) in (3..).zip(&mut light) {
            if columns.at[axis].is_some() {
                map.push(at(axis));
            }
        }
    }
    if places.is_empty() {
        return Err(("it holds no points".into(), GRAMMAR));
    }
    let [reflectance, scatter] = light;
    let some = |map: Vec<f64>| (!map.is_empty()).then_some(map);
    Ok(ScanPoints {
        places,
        reflectance: some(reflectance),
        scatter: some(scatter),
        bits: None,
        organised: None,
        unit_mm: columns.unit_mm,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(text: &str, form: Option<CsvForm>) -> MapNumbers {
        match content(text, form, false) {
            Ok(ScanContent::Grid(map)) => map,
            other => panic!("{other:?} is no grid of {text}"),
        }
    }

    fn cloud(text: &str, form: Option<CsvForm>) -> ScanPoints {
        match content(text, form, false) {
            Ok(ScanContent::Points(points)) => points,
            other => panic!("{other:?} are no points of {text}"),
        }
    }

    /// Every separator, missing fields, quotes, comments and blank lines.
    #[test]
    fn grids_are_read() {
        for text in [
            "# made by hand\n1,2,3,4,5,6\n\n7,,nan,NA,\"11\",12\n",
            "1;2;3;4;5;6\r\n7;;nan;null; 11 ;12",
            "\u{feff}1\t2\t3\t4\t5\t6\n7\t\t\t\t11\t12\n",
            "1 2 3  4 5 6\n 7 nan nan nan 11 1.2e1\n",
        ] {
            let found = map(text, None);
            assert_eq!((found.cols, found.rows, found.bits), (6, 2, None), "{text}");
            assert_eq!(found.numbers[..7], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], "{text}");
            assert!(found.numbers[7..10].iter().all(|z| z.is_nan()) && found.numbers[10..] == [11.0, 12.0], "{text}");
        }
        assert_eq!(map("1,2,3\n4,5,6\n", Some(CsvForm::Grid)).numbers.len(), 6);
        assert_eq!(map("col 0,col 1\n4,5\n", Some(CsvForm::Grid)).numbers, [4.0, 5.0]);
    }

    /// Names in any order, with units; without names in the order x, y, z, Reflectance, Scatter.
    #[test]
    fn points_are_read() {
        let found = cloud("red;Z [um];X_um;y (um);Intensity\n9;3000;1000;2000;77\n9;;1100;2000;0\n", None);
        assert_eq!((found.places[0], found.unit_mm), ([1000.0, 2000.0, 3000.0], Some(1e-3)));
        assert!(found.places[1][2].is_nan());
        assert_eq!((found.reflectance, found.scatter), (Some(vec![77.0, 0.0]), None));
        let found = cloud("1 2 3 4 5\n", Some(CsvForm::Points));
        assert_eq!((found.places, found.unit_mm), (vec![[1.0, 2.0, 3.0]], None));
        assert_eq!((found.reflectance, found.scatter), (Some(vec![4.0]), Some(vec![5.0])));
    }

    /// `.xyz` are points, whatever the number of their fields; what is stated holds all the same.
    #[test]
    fn clouds_are_points_by_nature() {
        let places = |text: &str| match content(text, None, true) {
            Ok(ScanContent::Points(points)) => (points.places[0], points.reflectance),
            other => panic!("{other:?} are no points of {text}"),
        };
        assert_eq!(places("1 2 3\n4 5 6\n"), ([1.0, 2.0, 3.0], None));
        assert_eq!(places("1 2 3 77\n"), ([1.0, 2.0, 3.0], Some(vec![77.0])));
        assert_eq!(places("1 2 3 255 0 9\n"), ([1.0, 2.0, 3.0], None));
        assert_eq!(places("1,2,3,0,0,1,9,9\n"), ([1.0, 2.0, 3.0], None));
        assert!(matches!(content("1 2 3\n4 5 6\n", Some(CsvForm::Grid), true), Ok(ScanContent::Grid(_))));
        assert!(content("1 2\n", None, true).is_err());
    }

    /// What is wrong is told with line and field, what is ambiguous with the option that decides.
    #[test]
    fn faults_name_line_and_remedy() {
        for (text, form, words) in [
            ("", None, "no numbers"),
            ("# nothing\n\n", None, "no numbers"),
            ("1,2,3,4,5,6\n1,2,x,4,5,6\n", None, "line 2, field 3: 'x' is no number"),
            (
                "1;2;3;4;5;6\n\n1;2,5;3;4;5;6\n",
                None,
                "line 3, field 2: '2,5' is no number; write decimals with a point",
            ),
            ("1,2,3,4,5,6\n1,2\n", None, "line 2: it has 2 fields, those before it 6"),
            ("1,2,3\n4,5,6\n", None, "--csv points or --csv grid"),
            ("1\n2\n", None, "--csv points or --csv grid"),
            ("a,b\n1,2\n", None, "does not name x, y and z"),
            ("x,y\n1,2\n", None, "all of x, y and z"),
            ("x,y,z,x\n1,2,3,4\n", None, "x twice"),
            ("x_mm,y_mm,z_inch\n1,2,3\n", None, "unknown unit"),
            ("x_mm,y_mm,z_um\n1,2,3\n", None, "different units"),
            ("x_mm,y_mm,z\n1,2,3\n", None, "different units"),
            ("x,y,z\n", None, "no points"),
            ("x,y,z\n1,2\n", None, "line 2: it has 2 fields, not 3"),
            ("x,y,z\n1,2,3\n", Some(CsvForm::Grid), "leave --csv away"),
            ("1,2\n", Some(CsvForm::Points), "three to five"),
            ("a,b,c\n1,2,3\n", Some(CsvForm::Points), "does not name"),
        ] {
            let (what, remedy) = content(text, form, false).expect_err(words);
            let told = format!("{what}; {remedy}");
            assert!(told.contains(words), "'{words}' is not in: {told}");
        }
    }
}
