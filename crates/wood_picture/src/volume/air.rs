//! Air where boards can be cut: the margin around the wood of a stack, told from the lumina in it.
//!
//! Model: a place of a face is air where the mean density of a square millimetre about it is that of air. Vessels are
//! 0.3 mm wide at most and have walls between them, so no wood is air at that scale. Along each axis wood lies between
//! the first and the last layer whose mean density is half of the stack's at least. Limits: a face is looked at in 24 x
//! 24 places at most, a square millimetre in 16; what is air below the face is not looked for.

use super::{FibreAxis, WoodVolume};
use crate::density_law::AIR_KG_PER_M3;

/// Side of the square that a mean is taken over [mm].
const SQUARE_MM: f32 = 1.0;
/// Most squares along a side of a face.
const MOST_SQUARES: f32 = 24.0;
/// Points along a side of a square.
const POINTS: usize = 4;
/// Layers along an axis, and points along each side of them.
const LAYERS: usize = 200;
const LAYER_POINTS: usize = 24;

/// Where a board lies in a stack; what has three numbers has them along the fibres, across them and downwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StackPlace {
    /// Length, width and thickness of the board [mm].
    pub board_mm: [f64; 3],
    /// Where it lies in the room that the stack leaves [1].
    pub shares: [f64; 3],
    /// Quarter turns of the stack about the fibres.
    pub quarter_turns: u8,
}

impl WoodVolume {
    /// Length along the fibres, width and depth of the stack as it lies after quarter turns [mm].
    pub fn turned_extent_mm(&self, quarter_turns: u8) -> [f32; 3] {
        let [length, width, depth] = self.extent_mm();
        if quarter_turns % 2 == 1 { [length, depth, width] } else { [length, width, depth] }
    }

    /// The near left corner of a board's face in the stack as it is turned (along, across, depth) [mm].
    pub(super) fn corner_mm(&self, place: &StackPlace) -> [f32; 3] {
        let extent = self.turned_extent_mm(place.quarter_turns);
        [0, 1, 2].map(|i| ((f64::from(extent[i]) - place.board_mm[i]).max(0.0) * place.shares[i]) as f32)
    }

    /// Density at a place (along, across, depth) of the stack as it lies after quarter turns [mm] [kg/m^3].
    pub(super) fn turned_density(&self, quarter_turns: u8, [along, across, depth]: [f32; 3]) -> f32 {
        let [_, width, thickness] = self.extent_mm();
        let [across, depth] = match quarter_turns {
            0 => [across, depth],
            1 => [depth, thickness - across],
            2 => [width - across, thickness - depth],
            _ => [width - depth, across],
        };
        self.density([along, across, depth])
    }

    /// Share of a board's face that is air [1].
    pub fn air_on_face(&self, place: &StackPlace) -> f32 {
        let [along, across, depth] = self.corner_mm(place);
        let sides = [place.board_mm[0], place.board_mm[1]].map(|side| side as f32);
        let [rows, cols] = sides.map(|side| (side / SQUARE_MM).ceil().clamp(1.0, MOST_SQUARES) as usize);
        let at = |side: f32, square: usize, squares: usize, point: usize| {
            let middle = side * (square as f32 + 0.5) / squares as f32;
            (middle + SQUARE_MM * ((point as f32 + 0.5) / POINTS as f32 - 0.5)).clamp(0.0, side)
        };
        let is_air = |row: usize, col: usize| {
            let points = (0..POINTS * POINTS).map(|point| {
                let y = at(sides[0], row, rows, point / POINTS);
                let x = at(sides[1], col, cols, point % POINTS);
                self.turned_density(place.quarter_turns, [along + y, across + x, depth])
            });
            points.sum::<f32>() < AIR_KG_PER_M3 * (POINTS * POINTS) as f32
        };
        let air = (0..rows * cols).filter(|square| is_air(square / cols, square % cols)).count();
        air as f32 / (rows * cols) as f32
    }

    /// From where to where wood lies along the fibres, across them and downwards, in the stack as it lies after quarter
    /// turns [mm].
    pub fn wood_mm(&self, quarter_turns: u8) -> [[f32; 2]; 3] {
        let extent = self.turned_extent_mm(quarter_turns);
        [0, 1, 2].map(|axis| {
            let others = [(axis + 1) % 3, (axis + 2) % 3];
            let layers: Vec<f32> = (0..LAYERS)
                .map(|layer| {
                    let mut place = [0.0; 3];
                    place[axis] = extent[axis] * (layer as f32 + 0.5) / LAYERS as f32;
                    let points = (0..LAYER_POINTS * LAYER_POINTS).map(|point| {
                        for (other, index) in others.into_iter().zip([point / LAYER_POINTS, point % LAYER_POINTS]) {
                            place[other] = extent[other] * (index as f32 + 0.5) / LAYER_POINTS as f32;
                        }
                        self.turned_density(quarter_turns, place)
                    });
                    points.sum()
                })
                .collect();
            let least = 0.5 * layers.iter().sum::<f32>() / LAYERS as f32;
            let first = layers.iter().position(|sum| *sum >= least).unwrap_or(0);
            let last = layers.iter().rposition(|sum| *sum >= least).unwrap_or(LAYERS - 1);
            [first, last + 1].map(|layer| extent[axis] * layer as f32 / LAYERS as f32)
        })
    }

    /// From where to where wood lies through the slices, down and across them [mm].
    pub(super) fn wood_in_slices_mm(&self) -> [[f32; 2]; 3] {
        let mut found = [[0.0; 2]; 3];
        for (axis, ends) in self.fibres.order().into_iter().zip(self.wood_mm(0)) {
            found[axis] = ends;
        }
        if self.fibres == FibreAxis::Down {
            let [first, last] = found[1];
            let length = self.extent_mm()[0];
            found[1] = [length - last, length - first];
        }
        found
    }
}
