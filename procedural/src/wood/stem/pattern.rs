//! A sawing pattern: where the boards of one log lie in it.
//!
//! Models: the log is cut across into pieces, and each piece is sawn through and through into parallel boards (live
//! sawing). The first board lies where `stem` says. With d its distance from the pith along its normal, s that across
//! it, and p the height of its middle, the others lie at
//! d + m (thickness + KERF_MM),  s,  p + j pitch,   pitch = min((length + CROSSCUT_MM) / |cos g|, (width + KERF_MM) /
//! |sin g|), for all whole m that keep the board's corners within the stem's mean radius, and all whole j that keep it
//! between the stem's ends; g is the log's turn against the board, along which rectangles on a line still lie apart.
//! Boards are counted from the first inwards through the pith to the far side, then from the first outwards, then in
//! the next piece upwards, and from the lowest on. Sources: geometry; the widths of the cuts are guesses within what
//! band saws and chain saws take. Limits: one pattern, without turning the log, edging or sizes of their own for
//! boards; taper and the outline's shape are not asked.

use std::f64::consts::PI;

use crate::wood::Wood;

/// Wood that the saw takes between two boards [mm], a guess.
const KERF_MM: f64 = 4.0;
/// Wood that is lost between two pieces [mm], a guess.
const CROSSCUT_MM: f64 = 8.0;

/// The room that a pattern has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogRoom {
    /// Length of the stem [mm].
    pub length_mm: f64,
    /// Its mean radius [mm].
    pub radius_mm: f64,
}

/// Pieces that a stem of `length_mm` always has for boards of this length and width, turned by `turn_deg` at most.
pub fn least_pieces(length_mm: f64, board_length_mm: f64, board_width_mm: f64, turn_deg: f64) -> u64 {
    // The pitch has its most at the ends of the turn or where both cuts agree.
    let both = libm::atan2(board_width_mm + KERF_MM, board_length_mm + CROSSCUT_MM).to_degrees();
    let turns = [0.0, turn_deg.abs(), both.min(turn_deg.abs())];
    let most = turns.into_iter().map(|turn| pitch(board_length_mm, board_width_mm, turn)).fold(0.0, f64::max);
    (((length_mm - board_length_mm) / most).floor().max(1.0)) as u64
}

fn pitch(length_mm: f64, width_mm: f64, turn_deg: f64) -> f64 {
    let (sin, cos) = libm::sincos(turn_deg.to_radians());
    ((length_mm + CROSSCUT_MM) / cos.abs()).min((width_mm + KERF_MM) / sin.abs())
}

/// `wood`, which says where the first board lies, with the place of board `number` in `wood.stem`.
pub fn sawn_at(wood: &Wood, room: LogRoom, number: u64) -> Wood {
    let (board, stem) = (&wood.board, &wood.stem);
    // Across the log: distance along the normal and across it.
    let (sin, cos) = libm::sincos(stem.face_deg.to_radians());
    let (depth, aside) = (stem.board_radius_mm * cos, -stem.board_radius_mm * sin);
    let step = board.thickness_mm + KERF_MM;
    let corner = aside.abs() + 0.5 * board.width_mm;
    let half_chord = (room.radius_mm * room.radius_mm - corner * corner).max(0.0).sqrt();
    let (over, under) = (half_chord - depth, depth - board.thickness_mm + half_chord);
    let (outer, inner) = if over < 0.0 || under < 0.0 { (0, 0) } else { ((over / step) as u64, (under / step) as u64) };
    let (piece, of_piece) = (number / (outer + inner + 1), number % (outer + inner + 1));
    let mut sawn = *wood;
    if of_piece > 0 {
        let cuts = if of_piece <= inner { -(of_piece as f64) } else { (of_piece - inner) as f64 };
        let depth = depth + cuts * step;
        let turn = libm::atan2(aside, depth);
        let normal = (stem.board_azimuth_deg + stem.face_deg).to_radians();
        sawn.stem.board_radius_mm = libm::hypot(aside, depth);
        sawn.stem.board_azimuth_deg = wrapped_deg(normal + turn);
        sawn.stem.face_deg = wrapped_deg(-turn);
    }
    // Along the log.
    if piece > 0 && room.length_mm > board.length_mm {
        let pitch = pitch(board.length_mm, board.width_mm, wood.log.grain_angle_deg);
        let free = room.length_mm - board.length_mm;
        let low = (stem.board_along_mm - 0.5 * board.length_mm).clamp(0.0, free);
        let below = (low / pitch).floor();
        let lowest = low - below * pitch;
        let pieces = ((free - lowest) / pitch).floor() + 1.0;
        let place = (below + piece as f64) % pieces;
        sawn.stem.board_along_mm = lowest + place * pitch + 0.5 * board.length_mm;
    }
    sawn
}

/// An angle [rad] in degrees from -180 to 180.
fn wrapped_deg(angle: f64) -> f64 {
    (angle - 2.0 * PI * (angle / (2.0 * PI)).round()).to_degrees().clamp(-180.0, 180.0)
}
