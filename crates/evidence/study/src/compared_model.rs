//! The models that studies put side by side: those of transport, and beside them the method of Kihl and Källberg's
//! thesis.

use image::Rgb;

use reference::model::Model;

/// A model that a study compares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ComparedModel {
    /// A model of transport.
    Model(Model),
    /// Kihl and Källberg's method.
    Thesis,
    /// The thesis' method with a stencil that conserves energy.
    Conservative,
}

impl ComparedModel {
    /// All of them, the reference Monte Carlo first.
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

    /// Its colour in every chart.
    pub(super) fn colour(self) -> Rgb<u8> {
        match self {
            Self::Model(Model::Path) => Rgb([30, 30, 30]),
            Self::Model(Model::Diffusion) => Rgb([214, 96, 30]),
            Self::Model(Model::Kernel) => Rgb([44, 113, 142]),
            Self::Thesis => Rgb([160, 50, 140]),
            Self::Conservative => Rgb([80, 140, 40]),
        }
    }
}
