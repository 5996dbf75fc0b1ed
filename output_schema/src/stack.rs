//! The columns of `stacks/*.parquet`: one row for each kept sensor frame.

use crate::column::{Column, ColumnKind};

/// Every column in order.
pub const STACK: [Column; 4] = [
    Column {
        name: "id",
        kind: ColumnKind::Text,
        unit: "",
        range: "UUID, version 5",
        missing: "never",
        doc: "Name of the sample.",
    },
    Column {
        name: "index",
        kind: ColumnKind::Int64,
        unit: "1",
        range: "0 to n - 1",
        missing: "never",
        doc: "Number of the sample in the dataset.",
    },
    Column {
        name: "profile",
        kind: ColumnKind::Int32,
        unit: "1",
        range: "0 to profiles - 1",
        missing: "never",
        doc: "Number of the exposure in the scan.",
    },
    Column {
        name: "frame",
        kind: ColumnKind::Tensor,
        unit: "DN",
        range: "0 to 255; uint16, to 1023 or 4095, for 10 or 12 bits",
        missing: "never",
        doc: "What the camera digitised, [sensor rows, sensor columns], row-major.",
    },
];
