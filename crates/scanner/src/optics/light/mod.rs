//! Light: the data that the phases hand on, which knows none of them.
//!
//! [`ScanLine`] is the light of one position of the scan, with [`SecondaryLight`] where there is film. Beside them
//! stand what both sides must agree on: the classes of the fixed widths, tiles and windows, and a blur.

mod box_filter;
mod glare_part;
mod lamp_line;
mod mixed_column;
mod scan_line;
mod secondary;
mod streak;
mod tile;
mod widths;

pub(crate) use self::box_filter::{blur, blur_varying};
pub(crate) use self::glare_part::GlarePart;
pub(crate) use self::lamp_line::LampLine;
pub use self::mixed_column::MixedColumn;
pub use self::scan_line::{FrontTile, ScanLine};
pub(crate) use self::secondary::{NEAR_MM2, PER_TILE, PocketLight, STRIDE, middle_of};
pub use self::secondary::{Patches, Reflection, SecondaryLight, TransmittedLine, WindowNeed};
pub use self::streak::Streak;
pub(crate) use self::streak::column_shares;
pub use self::tile::{CENTRE, ROWS};
pub(crate) use self::tile::{
    MIN_VARIANCE, UNIT_EXIT, greater, greatest, load, needs_own_window, window_start, without_overlap,
};
pub(crate) use self::widths::{FAR, FILLING, NARROW_WIDTHS, NEAR, NEAR_WIDTHS, WIDE};
