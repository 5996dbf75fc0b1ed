//! Scan line: the light of one position of the scan.
//!
//! Takes a specimen under camera and laser at one position ([`LineView`]); gives what each column sends to the lens and
//! what it lets out of its neighbours' light ([`crate::optics::light::ScanLine`]). [`LineMaker`] goes through the
//! steps; of sensor rows, of other lines and of numbers nothing is known here.

mod along_line;
mod bent_film;
mod edge_search;
mod film;
mod front_face;
mod highlights;
mod maker;
mod patches;
mod pockets;
mod reflections;
mod response;
mod secondary_light;
mod spans;
mod surface_point;
mod view;

pub(crate) use self::highlights::Highlights;
pub(crate) use self::maker::{LineMaker, LineScratch};
pub(crate) use self::surface_point::surface_point;
pub(crate) use self::view::LineView;
