//! Who says where the light of a point comes out: the models of transport, and beside them the thesis' pictures.
//!
//! The thesis' method is shown as Figures 4.23 and 4.24 show it: a spot of 55 pixels, 20 iterations on clear wood and 10
//! on a knot. It works on pixels, whose size the thesis does not say; here they are the study's cells, so its
//! half diameters in mm are a choice, its aspects and angles are not. Its own spot is in them. The conservative
//! stencil lights one pixel and is asked what the models are asked.

use glam::DVec2;

use super::media::Wood;
use super::point::{CELL_MM, CELLS, question};
use super::{Watch, ask, asks};
use crate::transport::answer::Estimate;
use crate::transport::model::{Model, ModelError};
use crate::transport::path::Effort;
use crate::transport::thesis::{LaserPoint, PixelGround, SpreadMethod, point};

/// Whose picture of a point it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// A model of transport.
    Model(Model),
    /// Kihl and Källberg's method, their spot.
    Thesis,
    /// Its stencil made right, one pixel lit.
    Conservative,
}

impl By {
    /// All, the judge first.
    pub fn all() -> impl Iterator<Item = Self> {
        Model::ALL.into_iter().map(Self::Model).chain([Self::Thesis, Self::Conservative])
    }

    /// Name in tables and answers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Model(model) => model.name(),
            Self::Thesis => "thesis",
            Self::Conservative => "conservative",
        }
    }

    /// What is lit and how, where it is not a point as such.
    pub fn note(self, wood: &Wood) -> String {
        match self {
            Self::Model(_) => String::new(),
            Self::Thesis => {
                let iterations = if on_a_knot(&ground(wood)) { 10 } else { 20 };
                format!("55 px spot, {iterations} iterations, {CELL_MM} mm/px")
            }
            Self::Conservative => format!("one pixel lit, {CELL_MM} mm/px"),
        }
    }

    /// Share of the energy that leaves in each cell, `[2 CELLS + 1, 2 CELLS + 1]`, row-major, rows along y [1].
    ///
    /// # Errors
    /// Where the model refuses.
    pub fn light(self, wood: &Wood, effort: Effort, watch: Watch) -> Result<Vec<Estimate>, ModelError> {
        let middle = DVec2::splat(CELLS as f64);
        let what = format!("{} at {} deg", wood.name, wood.azimuth);
        let (spot, method) = match self {
            Self::Model(model) => {
                return Ok(ask(model, &what, (&wood.stack(), &question()), effort, watch)?.point);
            }
            Self::Thesis if on_a_knot(&ground(wood)) => (LaserPoint::thesis(middle), SpreadMethod::ON_A_KNOT),
            Self::Thesis => (LaserPoint::thesis(middle), SpreadMethod::ON_CLEAR_WOOD),
            Self::Conservative => {
                (LaserPoint { at: middle, diameter: 1.0, deviation: 1.0 }, SpreadMethod::CONSERVATIVE)
            }
        };
        asks(self.name(), &what, watch);
        Ok(point(&ground(wood), &spot, method).light.into_iter().map(Estimate::exact).collect())
    }
}

/// The wood as a picture's ground.
fn ground(wood: &Wood) -> PixelGround {
    const SIDE: usize = 2 * CELLS + 1;
    PixelGround::new(SIDE, SIDE, CELL_MM, &vec![Some(wood.medium()); SIDE * SIDE])
}

/// The thesis' rule: what absorbs is a knot.
fn on_a_knot(ground: &PixelGround) -> bool {
    ground.map.alpha(0) < 1.0
}
