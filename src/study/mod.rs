//! Studies: models of transport side by side, as tables, JSON and pictures.

pub mod ellipse;
mod fit;
