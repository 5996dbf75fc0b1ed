//! The declaration of one column, and the rule that gives a drawn number its unit.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColumnKind {
    /// UTF-8 text.
    Text,
    /// Signed whole number, 32 bits.
    Int32,
    /// Signed whole number, 64 bits.
    Int64,
    /// Unsigned whole number, 64 bits.
    UInt64,
    /// Floating point, 64 bits.
    Float64,
    /// The same, only in datasets whose Range has the column's unit.
    RangeNumber,
    /// Number of a class of the recipe, 64 bits; the names are in `dataset.json`.
    SampleClass,
    /// Number of a pixel class, 64 bits; the names are [`base::Class`].
    PixelClass,
    /// A list of names of pixel classes.
    PixelClassNames,
    /// Four whole numbers of 32 bits: first column, first row, columns, rows.
    Box4,
    /// A grey PNG with this many bits in a pixel, as struct of `bytes` and `path`.
    Image(u8),
    /// A struct with one 64-bit whole number for each pixel class that labels of the subject can show.
    PixelCounts,
    /// One struct for each group of drawn numbers; the groups are in `dataset.json` as `parameters`.
    Parameters,
    /// A struct of the numbers that are in `dataset.json` as `physics`.
    Physics,
    /// One struct with these fields.
    Struct(&'static [Column]),
    /// A list of structs with these fields.
    List(&'static [Column]),
    /// An image of 8-bit numbers as `arrow.fixed_shape_tensor`, row-major.
    Tensor,
}

impl ColumnKind {
    /// Name in the data dictionary.
    pub fn name(self) -> String {
        match self {
            Self::Text => "string".into(),
            Self::Int32 => "int32".into(),
            Self::Int64 => "int64".into(),
            Self::UInt64 => "uint64".into(),
            Self::Float64 | Self::RangeNumber => "float64".into(),
            Self::SampleClass => "int64, ClassLabel of the recipe's classes".into(),
            Self::PixelClass => "int64, ClassLabel of the pixel classes".into(),
            Self::PixelClassNames => "list of string".into(),
            Self::Box4 => "fixed list of 4 int32".into(),
            Self::Image(bits) => format!("struct of bytes (grey PNG, {bits} bits) and path"),
            Self::PixelCounts => "struct of int64, one for each pixel class of the subject".into(),
            Self::Parameters => "one struct of float64 for each group".into(),
            Self::Physics => "struct of float64".into(),
            Self::Struct(_) => "struct".into(),
            Self::List(_) => "list of struct".into(),
            Self::Tensor => "fixed list of uint8, `arrow.fixed_shape_tensor`".into(),
        }
    }

    /// Whether a row can have any number of values.
    pub fn is_list(self) -> bool {
        matches!(self, Self::PixelClassNames | Self::List(_))
    }

    /// Shape of one value, row-major.
    pub fn shape(self) -> &'static str {
        match self {
            Self::Image(_) => "[rows, cols]",
            Self::Tensor => "[sensor_rows, sensor_cols]",
            Self::Box4 => "[4]",
            Self::PixelClassNames => "[defects]",
            Self::List(_) => "[objects]",
            Self::PixelCounts | Self::Parameters | Self::Physics | Self::Struct(_) => "fields",
            _ => "one",
        }
    }
}

/// Values that a column may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Values {
    /// Any.
    Any,
    /// Numbers above 0.
    Positive,
    /// Numbers from 0 on.
    NotNegative,
    /// Numbers between these two, both included.
    Within(f64, f64),
    /// Others, in words.
    Words(&'static str),
}

impl Values {
    /// Whether a number is one of them; what words say is not asked.
    pub fn have(self, number: f64) -> bool {
        number.is_finite()
            && match self {
                Self::Any | Self::Words(_) => true,
                Self::Positive => number > 0.0,
                Self::NotNegative => number >= 0.0,
                Self::Within(least, most) => (least..=most).contains(&number),
            }
    }
}

impl fmt::Display for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Any => f.write_str("any"),
            Self::Positive => f.write_str("above 0"),
            Self::NotNegative => f.write_str("0 or more"),
            Self::Within(least, most) => write!(f, "{least} to {most}"),
            Self::Words(words) => f.write_str(words),
        }
    }
}

/// What the values of a column follow from, which is what validation holds them to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The head and what the recipe draws.
    Draws,
    /// The scene, without light: made again and compared bit for bit.
    Scene,
    /// The images, by a rule of the column's own.
    Images,
}

impl Source {
    /// Name in the data dictionary.
    pub fn name(self) -> &'static str {
        match self {
            Self::Draws => "draws",
            Self::Scene => "scene",
            Self::Images => "images",
        }
    }
}

/// The declaration of one column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column {
    /// Name of the column.
    pub name: &'static str,
    /// What it holds.
    pub kind: ColumnKind,
    /// Unit; `1` for pure numbers, empty where a unit has no meaning.
    pub unit: &'static str,
    /// Values that it may take.
    pub range: Values,
    /// How a missing value is written; `never` where none can be missing.
    pub missing: &'static str,
    /// What it means.
    pub doc: &'static str,
    /// What its values follow from.
    pub follows: Source,
    /// Minor version of the schema from which on datasets have it.
    pub since: u32,
}

impl Column {
    /// A column that every dataset has, that is never empty and follows from the images.
    pub const fn of_images(name: &'static str, kind: ColumnKind, unit: &'static str, range: Values) -> Self {
        Self { name, kind, unit, range, missing: "never", doc: "", follows: Source::Images, since: 0 }
    }

    /// The same, following from the scene.
    pub const fn of_scene(name: &'static str, kind: ColumnKind, unit: &'static str, range: Values) -> Self {
        Self { follows: Source::Scene, ..Self::of_images(name, kind, unit, range) }
    }

    /// The same, following from the draws.
    pub const fn of_draws(name: &'static str, kind: ColumnKind, unit: &'static str, range: Values) -> Self {
        Self { follows: Source::Draws, ..Self::of_images(name, kind, unit, range) }
    }

    /// The same with its meaning.
    #[must_use]
    pub const fn means(self, doc: &'static str) -> Self {
        Self { doc, ..self }
    }

    /// Whether every row has a value.
    pub fn is_never_missing(&self) -> bool {
        self.missing == "never"
    }

    /// The same with another rule for missing values.
    #[must_use]
    pub const fn missing(self, missing: &'static str) -> Self {
        Self { missing, ..self }
    }

    /// The same in datasets of this minor version and newer ones alone.
    #[must_use]
    pub const fn since(self, since: u32) -> Self {
        Self { since, ..self }
    }
}

/// The newest of `minor` and the minor versions since which there are `columns`.
pub(crate) const fn newest(columns: &[Column], mut minor: u32) -> u32 {
    let mut place = 0;
    while place < columns.len() {
        if columns[place].since > minor {
            minor = columns[place].since;
        }
        place += 1;
    }
    minor
}

/// The declaration of one drawn or derived number: known only together with a recipe, and so kept in `dataset.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NumberColumn {
    /// Struct column; empty for the numbers of `physics`.
    pub group: String,
    /// Field in the struct; ends in its unit.
    pub key: String,
    /// Unit.
    pub unit: String,
    /// What it means.
    pub doc: String,
}

impl NumberColumn {
    /// A number whose unit is told by the end of its key.
    pub fn new(group: &str, key: &str, doc: &str) -> Self {
        Self { group: group.into(), key: key.into(), unit: unit_of(key).into(), doc: doc.trim().into() }
    }

    /// `group.key`, or `key` alone without a group.
    pub fn path(&self) -> String {
        if self.group.is_empty() { self.key.clone() } else { format!("{}.{}", self.group, self.key) }
    }
}

/// Ends of keys and the unit that they stand for; where one is the end of another, the longer first.
const UNITS: [(&str, &str); 26] = [
    ("_w_per_m2_nm", "W/(m^2 nm)"),
    ("_deg_per_mm", "deg/mm"),
    ("_um_per_mm", "um/mm"),
    ("_per_mm", "1/mm"),
    ("_w_per_mm2", "W/mm^2"),
    ("_mm_per_s", "mm/s"),
    ("_e_per_s", "electrons/s"),
    ("_dn_per_e", "DN/electron"),
    ("_per_mm2", "1/mm^2"),
    ("_mm2", "mm^2"),
    ("_mm", "mm"),
    ("_um", "um"),
    ("_nm", "nm"),
    ("_deg", "deg"),
    ("_rad", "rad"),
    ("_mw", "mW"),
    ("_us", "us"),
    ("_ms", "ms"),
    ("_s", "s"),
    ("_hz", "Hz"),
    ("_px", "px"),
    ("_rows", "px"),
    ("_columns", "px"),
    ("_e", "electrons"),
    ("_dn", "DN"),
    ("_kg_per_m3", "kg/m^3"),
];

/// The unit that the end of a key stands for; `1` where it names none.
///
/// ```
/// assert_eq!(output_schema::unit_of("power_mw"), "mW");
/// assert_eq!(output_schema::unit_of("spiral_slope_deg_per_mm"), "deg/mm");
/// assert_eq!(output_schema::unit_of("dark_current_e_per_s"), "electrons/s");
/// assert_eq!(output_schema::unit_of("gain_dn_per_e"), "DN/electron");
/// assert_eq!(output_schema::unit_of("f_number"), "1");
/// ```
pub fn unit_of(key: &str) -> &'static str {
    UNITS.iter().find(|(end, _)| key.ends_with(end)).map_or("1", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shorter end before a longer one would hide it: the key of each unit would have another's.
    #[test]
    fn every_end_stands_for_its_own_unit() {
        for (end, unit) in UNITS {
            assert_eq!(unit_of(&format!("x{end}")), unit, "{end}");
            assert_eq!(end.contains("_per_"), unit.contains('/'), "{end} is no {unit}");
        }
    }
}
