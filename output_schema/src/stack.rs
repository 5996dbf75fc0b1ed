//! The columns of `stacks/*.parquet`: one row for each kept sensor frame.

use crate::column::Column;
use crate::column::ColumnKind::*;
use crate::column::Values::*;

/// Every column in order.
pub const STACK: [Column; 4] = [
    Column::of_draws("id", Text, "", Words("UUID, version 5")).means("Name of the sample."),
    Column::of_draws("index", Int64, "1", Words("0 to n - 1")).means("Number of the sample in the dataset."),
    Column::of_draws("profile", Int32, "1", Words("0 to profiles - 1")).means("Number of the exposure in the scan."),
    Column::of_images("frame", Tensor, "DN", Words("0 to 255; uint16, to 1023 or 4095, for 10 or 12 bits"))
        .means("What the camera digitised, [sensor rows, sensor columns], row-major."),
];
