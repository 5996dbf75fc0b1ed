//! Files that are built in: what a recipe can name although no file of that name lies beside it.

use crate::asset::BuiltIn;

/// Meshes, by the names that the recipes beside them give.
pub(crate) const MESHES: [BuiltIn; 1] = [("meshes/clip.obj", include_bytes!("../../../recipes/meshes/clip.obj"))];

/// Pictures of boards.
pub(crate) const PICTURES: [BuiltIn; 1] =
    [("pictures/board.png", include_bytes!("../../../recipes/pictures/board.png"))];

/// Stacks of slices.
pub(crate) const STACKS: [BuiltIn; 1] = [("slices/spruce.tar", include_bytes!("../../../recipes/slices/spruce.tar"))];

/// Pith, radii and knots of the scanned log "Gran_1": MIT, copyright 2022 Maria Larsson (recipes/logs).
pub(crate) const GRAN_1: [[BuiltIn; 1]; 3] = [
    [("logs/gran_1_pith.csv", include_bytes!("../../../recipes/logs/gran_1_pith.csv"))],
    [("logs/gran_1_radii.csv", include_bytes!("../../../recipes/logs/gran_1_radii.csv"))],
    [("logs/gran_1_knots.csv", include_bytes!("../../../recipes/logs/gran_1_knots.csv"))],
];
