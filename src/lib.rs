//! Sheetlight.
