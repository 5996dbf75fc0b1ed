//! The columns of `data/*.parquet`: one row for each sample.

use crate::column::{Column, Kind};

/// Names of the pixel classes; the position is the value in label images.
pub const PIXEL_CLASSES: [&str; 26] = [
    "background",
    "clear",
    "sound_knot",
    "dead_knot",
    "rot",
    "flange",
    "pocket",
    "missing",
    "broken",
    "chipped",
    "cracked",
    "capped",
    "foreign_tablet",
    "wrong_coat",
    "double",
    "particle",
    "fibre",
    "powder",
    "shallow",
    "collapsed",
    "punctured",
    "pinhole",
    "channel",
    "wrinkle",
    "delamination",
    "tablet_on_flange",
];

/// Images of a row in the order of columns; each is written only where the recipe asks for it.
pub const IMAGES: [&str; 5] = ["range", "reflectance", "scatter", "label", "instance"];

const fn column(
    name: &'static str,
    kind: Kind,
    unit: &'static str,
    range: &'static str,
    missing: &'static str,
    doc: &'static str,
) -> Column {
    Column { name, kind, unit, range, missing, doc }
}

/// Every column in order.
///
/// `seed` is unsigned because it is: a signed column would change seeds from 2^63 on, and every reader that is tested
/// here knows uint64. `index` is signed because frameworks index with int64.
pub const ROW: [Column; 20] = [
    column(
        "id",
        Kind::Text,
        "",
        "UUID, version 5",
        "never",
        "Name of the sample: follows from recipe, seed and index.",
    ),
    column("index", Kind::Int64, "1", "0 to n - 1", "never", "Number of the sample in the dataset."),
    column(
        "seed",
        Kind::UInt64,
        "1",
        "any",
        "never",
        "Seed of the dataset; with the recipe and `index` it makes the sample.",
    ),
    column(
        "split",
        Kind::Text,
        "",
        "train, validation, test",
        "never",
        "Part of the dataset; follows from seed and index, so it stays as n grows and as the recipe is edited.",
    ),
    column(
        "class",
        Kind::SampleClass,
        "",
        "0 to classes - 1",
        "never",
        "Class of the recipe that the sample was drawn from.",
    ),
    column("cols", Kind::Int32, "px", "1 or more", "never", "Columns of the images, along the laser line (x)."),
    column(
        "rows",
        Kind::Int32,
        "px",
        "1 or more",
        "never",
        "Rows of the images, along the scan (y): row 0 was exposed first.",
    ),
    column("row_mm", Kind::Float64, "mm", "above 0", "never", "Distance between two rows."),
    column(
        "col_mm",
        Kind::Float64,
        "mm",
        "above 0",
        "never",
        "Distance between two columns at the upper surface's height.",
    ),
    column("range_offset_mm", Kind::Float64, "mm", "any", "never", "See `range`."),
    column("range_scale_mm", Kind::Float64, "mm", "above 0", "never", "See `range`."),
    column(
        "parameters",
        Kind::Parameters,
        "by field",
        "by recipe",
        "never",
        "Every drawn number as `group.key`; the column is named after the group.",
    ),
    column(
        "physics",
        Kind::Physics,
        "by field",
        "by recipe",
        "null where it has no meaning",
        "Numbers that follow from the drawn ones.",
    ),
    column(
        "objects",
        Kind::List(&OBJECT),
        "",
        "0 or more",
        "empty list",
        "Defects that at least one pixel shows, by number.",
    ),
    column(
        "class_area_px",
        Kind::PixelCounts,
        "px",
        "sum is rows times cols",
        "never",
        "Pixels of each pixel class in the label image.",
    ),
    column(
        "range",
        Kind::Image(16),
        "see doc",
        "0 to 65535",
        "0",
        "Measured height: a value r > 0 means range_offset_mm + r * range_scale_mm [mm].",
    ),
    column(
        "reflectance",
        Kind::Image(8),
        "DN",
        "0 to 255",
        "0",
        "Digital number at the peak of the laser line, rounded.",
    ),
    column(
        "scatter",
        Kind::Image(16),
        "DN",
        "0 to 65535, saturates",
        "0",
        "Sum of digital numbers beside the peak, rounded.",
    ),
    column("label", Kind::Image(8), "", "number of a pixel class", "never", "What each pixel really shows."),
    column(
        "instance",
        Kind::Image(16),
        "",
        "0 for none, else `objects.instance`",
        "never",
        "Which defect each pixel really shows.",
    ),
];

/// Fields of one object.
pub const OBJECT: [Column; 11] = [
    column("instance", Kind::Int32, "1", "1 to 65535", "never", "Its value in the instance image."),
    column("class", Kind::PixelClass, "", "number of a pixel class", "never", "Its class."),
    column(
        "bbox",
        Kind::Box4,
        "px",
        "inside the image",
        "never",
        "Smallest box around it: first column, first row, columns, rows (COCO order).",
    ),
    column("area_px", Kind::Int64, "px", "1 or more", "never", "Pixels that it covers."),
    column("area_mm2", Kind::Float64, "mm^2", "above 0", "never", "Area that it covers."),
    column(
        "x_mm",
        Kind::Float64,
        "mm",
        "any",
        "null where it has no meaning",
        "Centre at the upper surface, along the laser line.",
    ),
    column(
        "y_mm",
        Kind::Float64,
        "mm",
        "any",
        "null where it has no meaning",
        "Centre at the upper surface, along the scan.",
    ),
    column(
        "diameter_mm",
        Kind::Float64,
        "mm",
        "0 or more",
        "null where it has no meaning",
        "Diameter across its axis at the upper surface.",
    ),
    column(
        "dive_deg",
        Kind::Float64,
        "deg",
        "-90 to 90",
        "null where it has no meaning",
        "Angle between its axis and the upper surface.",
    ),
    column(
        "death_radius_mm",
        Kind::Float64,
        "mm",
        "0 or more",
        "null where it has no meaning",
        "Distance from the pith at which the branch died.",
    ),
    column("severity", Kind::Float64, "1", "0 to 1", "null where it has no meaning", "Severity of decay."),
];
