//! The columns of `data/*.parquet`: one row for each sample.

pub use crate::calibration::CALIBRATION;
use crate::column::Column;
use crate::column::ColumnKind::*;
use crate::column::Values::*;

/// How much of a sample is of use, in the order of columns; rows have them from schema 1.4 on.
pub const SHARES: [&str; 3] = ["measured_share", "saturated_share", "object_in_view"];

/// Images of a row in the order of columns; each is written only where the recipe asks for it.
pub const IMAGES: [&str; 6] = ["range", "reflectance", "scatter", "grey", "label", "instance"];

/// Those that are measured.
pub const MEASURED: [&str; 4] = ["range", "reflectance", "scatter", "grey"];

/// Those of them that are digital numbers of one pixel, as deep as the sensor's converter.
pub const LIGHT: [&str; 2] = ["reflectance", "grey"];

/// Which samples have something in common; rows have them from schema 1.8 on.
pub const GROUPS: [&str; 3] = ["rig", "log_number", "batch"];

/// Every column in order.
///
/// `seed` is unsigned because it is: a signed column would change seeds from 2^63 on, and every reader that is tested
/// here knows uint64. `index` is signed because frameworks index with int64.
pub const ROW: [Column; 32] = [
    Column::of_draws("id", Text, "", Words("UUID, version 5"))
        .means("Name of the sample: follows from recipe, seed and index."),
    Column::of_draws("index", Int64, "1", Words("0 to n - 1")).means("Number of the sample in the dataset."),
    Column::of_draws("seed", UInt64, "1", Any)
        .means("Seed of the dataset; with the recipe and `index` it makes the sample."),
    Column::of_draws("split", Text, "", Words("train, validation, test"))
        .means("Part of the dataset; follows from seed and index, so it stays as n grows and as the recipe is edited."),
    Column::of_draws("class", SampleClass, "", Words("0 to classes - 1"))
        .means("Class of the recipe that the sample was drawn from."),
    Column::of_draws("rig", Int64, "1", NotNegative)
        .since(8)
        .means("Instrument that scanned it; without `rigs` in the recipe each sample has its own. From 1.8 on."),
    Column::of_draws("log_number", Int64, "1", NotNegative)
        .missing("null where the object is no board")
        .since(8)
        .means("Log that the board was sawn from. From 1.8 on."),
    Column::of_draws("batch", Int64, "1", NotNegative)
        .missing("null where the object is a board")
        .since(8)
        .means("Batch that the object is of; without `samples_per_batch` each is its own. From 1.8 on."),
    Column::of_draws("cols", Int32, "px", Words("1 or more")).means("Columns of the images, along the laser line (x)."),
    Column::of_draws("rows", Int32, "px", Words("1 or more"))
        .means("Rows of the images, along the scan (y): row 0 was exposed first."),
    Column::of_scene("row_mm", Float64, "mm", Positive).means("Distance between two rows."),
    Column::of_scene("col_mm", Float64, "mm", Positive)
        .means("Distance between two columns at the upper surface's height."),
    Column::of_scene("range_offset_mm", RangeNumber, "mm", Any)
        .missing("not there where Range is in px")
        .means("See `range`."),
    Column::of_scene("range_scale_mm", RangeNumber, "mm", Positive)
        .missing("not there where Range is in px")
        .means("See `range`."),
    Column::of_scene("range_offset_px", RangeNumber, "px", Any)
        .missing("not there where Range is in mm")
        .means("See `range`."),
    Column::of_scene("range_scale_px", RangeNumber, "px", Positive)
        .missing("not there where Range is in mm")
        .means("See `range`."),
    Column::of_scene("calibration", Struct(&CALIBRATION), "by field", Words("by field"))
        .missing("null where it has no meaning")
        .means("Camera against laser plane: from a column and a row of the sensor to x and z, by python/calibrate.py."),
    Column::of_draws("parameters", Parameters, "by field", Words("by recipe"))
        .means("Every drawn number as `group.key`; the column is named after the group."),
    Column::of_scene("physics", Physics, "by field", Words("by recipe"))
        .missing("null where it has no meaning")
        .means("Numbers that follow from the drawn ones."),
    Column::of_images("defect_classes", PixelClassNames, "", Words("names of pixel classes"))
        .missing("empty list")
        .means(
            "Class of every defect of which at least one pixel shows something, by number. Before 1.7 of every \
         defect, seen or not.",
        ),
    Column::of_images("unseen_classes", PixelClassNames, "", Words("names of pixel classes"))
        .missing("empty list")
        .since(7)
        .means(
            "Class of every defect that the object has and no pixel shows: inside, covered or beyond the field; \
             by number. From 1.7 on.",
        ),
    Column::of_images("objects", List(&OBJECT), "", NotNegative)
        .missing("empty list")
        .means("Defects, pockets, teeth and parts of which at least one pixel shows something, by number."),
    Column::of_images("class_area_px", PixelCounts, "px", Words("sum is rows times cols"))
        .means("Pixels of each pixel class of the subject in the label image."),
    Column::of_images("measured_share", Float64, "1", Within(0.0, 1.0))
        .missing("null where no pixel shows the object")
        .since(4)
        .means("Share of the pixels that show the object (label not background) in which Range is measured."),
    Column::of_images("saturated_share", Float64, "1", Within(0.0, 1.0))
        .missing("null where nothing of the object is measured")
        .since(4)
        .means(
            "Share of those measured pixels in which the line saturates: Reflectance, rounded, is the greatest \
             digital number.",
        ),
    Column::of_scene("object_in_view", Float64, "1", Within(0.0, 1.0))
        .missing("null on a turntable")
        .since(4)
        .means("Share of the object's convex outline, seen from above, that lies within the field of the images."),
    Column::of_images("range", Image(16), "see doc", Within(0.0, 65535.0))
        .missing("0")
        .means("Measured: a value r > 0 means range_offset_mm + r * range_scale_mm [mm], or the same with _px [px]."),
    Column::of_images("reflectance", Image(8), "DN", Words("0 to 255; 16 bits, to 1023 or 4095, for 10 or 12"))
        .missing("0")
        .means("Digital number at the peak of the laser line, rounded."),
    Column::of_images("scatter", Image(16), "DN", Words("0 to 65535, saturates"))
        .missing("0")
        .means("Sum of digital numbers beside the peak, rounded."),
    Column::of_images("grey", Image(8), "DN", Words("1 to 255; 16 bits, to 1023 or 4095, for 10 or 12"))
        .missing("0")
        .since(7)
        .means(
            "Digital number under lamps beside the laser, rounded; 0 where the lens does not see the pixel's point.",
        ),
    Column::of_images("label", Image(8), "", Words("number of a pixel class")).means("What each pixel really shows."),
    Column::of_images("instance", Image(16), "", Words("0 for none, else `objects.instance`"))
        .means("Which defect or pocket each pixel really shows."),
];

/// Fields of one object.
pub const OBJECT: [Column; 17] = [
    Column::of_images("instance", Int32, "1", Within(1.0, 65535.0)).means("Its value in the instance image."),
    Column::of_scene("class", PixelClass, "", Words("number of a pixel class"))
        .means("Its class: that of its own pixels."),
    Column::of_scene("state", PixelClass, "", Words("number of a pixel class"))
        .means("What the whole of it counts as: the worst defect of a pocket, else its class."),
    Column::of_scene("within", Int32, "1", Words("0 for none, else a smaller `objects.instance`"))
        .means("The object that it lies in: for a defect of a pocket, the pocket."),
    Column::of_images("bbox", Box4, "px", Words("inside the image"))
        .means("Smallest box around it and what lies in it: first column, first row, columns, rows (COCO order)."),
    Column::of_images("area_px", Int64, "px", Words("1 or more"))
        .means("Pixels that it covers, those of what lies in it included."),
    Column::of_images("area_mm2", Float64, "mm^2", Positive).means("Area that it covers."),
    Column::of_scene("x_mm", Float64, "mm", Any)
        .missing("null where it has no meaning")
        .means("Centre at the upper surface, along the laser line; 0 where the optical axis looks."),
    Column::of_scene("y_mm", Float64, "mm", Any)
        .missing("null where it has no meaning")
        .means("Centre at the upper surface, along the scan; 0 in the middle of the first unbinned profile."),
    Column::of_scene("diameter_mm", Float64, "mm", NotNegative)
        .missing("null where it has no meaning")
        .means("Diameter across its axis at the upper surface, or largest extent."),
    Column::of_scene("dive_deg", Float64, "deg", Within(-90.0, 90.0))
        .missing("null where it has no meaning")
        .means("Angle between its axis and the upper surface."),
    Column::of_scene("death_radius_mm", Float64, "mm", NotNegative)
        .missing("null where it has no meaning")
        .means("Distance from the pith at which the branch died."),
    Column::of_scene("severity", Float64, "1", Within(0.0, 1.0))
        .missing("null where it has no meaning")
        .means("Severity of decay or of a defect."),
    Column::of_images("length_mm", Float64, "mm", Positive)
        .missing("null on a turntable")
        .since(5)
        .means("Extent of its pixels along the scan: rows of `bbox` times `row_mm`. From 1.5 on."),
    Column::of_images("width_mm", Float64, "mm", Positive)
        .missing("null on a turntable")
        .since(5)
        .means("Extent of its pixels along the laser line: columns of `bbox` times `col_mm`. From 1.5 on."),
    Column::of_scene("depth_mm", Float64, "mm", NotNegative).missing("null where it has no meaning").since(5).means(
        "Greatest depth of an opening below the face, seen or not; of wane where it is as wide as its mean. \
             From 1.5 on.",
    ),
    Column::of_scene("knot_names", Text, "", Words("face, edge or arris; then spike, pin, cluster, crack"))
        .missing("null where it is no knot")
        .since(5)
        .means(
            "What graders call a knot, with spaces between the names; thresholds in docs/theory/wood.md. From 1.5 on.",
        ),
];
