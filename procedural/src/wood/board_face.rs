//! The upper face of a board before it warped, and how it lies in the log.

use glam::Vec2;

use super::{EDGE_MOST, Wood};

/// The upper face of a board before it warped.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoardFace {
    /// Its middle [mm].
    pub middle: Vec2,
    /// Half its size [mm].
    pub half: Vec2,
    /// Its height over the conveyor [mm].
    pub height: f32,
    /// How far beyond its half width an edge that wanders can lie [mm].
    pub edge_room: f32,
    /// Cosine and sine of the log's turn [1].
    turn: Vec2,
}

impl BoardFace {
    /// Of a board.
    pub fn of(wood: &Wood) -> Self {
        let board = &wood.board;
        let half = 0.5 * Vec2::new(board.width_mm as f32, board.length_mm as f32);
        let middle = Vec2::new(board.offset_mm as f32, board.lead_in_mm as f32 + half.y);
        let edge_room = EDGE_MOST * board.edge_wander_mm as f32;
        let (sin, cos) = libm::sincos(wood.log.turn_deg().to_radians());
        Self { middle, half, height: board.thickness_mm as f32, edge_room, turn: Vec2::new(cos as f32, sin as f32) }
    }

    /// The spot at these shares of width and length, a tenth of either away from the edges [mm].
    pub fn spot(&self, share: [f32; 2]) -> Vec2 {
        self.middle + 0.8 * self.half * (2.0 * Vec2::from_array(share) - 1.0)
    }
    /// A way on the face as a way across and along the log [mm].
    #[inline]
    pub fn in_log(&self, d: Vec2) -> Vec2 {
        let turn = self.turn;
        Vec2::new(d.x * turn.x - d.y * turn.y, d.x * turn.y + d.y * turn.x)
    }

    /// Across and along the log, from the board's middle [mm].
    #[inline]
    pub fn log_place(&self, spot: Vec2) -> Vec2 {
        self.in_log(spot - self.middle)
    }

    /// The spot of the face at a place across and along the log [mm].
    pub fn face_place(&self, across: f32, along: f32) -> Vec2 {
        let turn = self.turn;
        self.middle + Vec2::new(across * turn.x + along * turn.y, along * turn.x - across * turn.y)
    }
}
