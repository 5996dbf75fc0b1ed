//! Log groups: samples in a row that are boards of one log, and stay in one split.
//!
//! **Model.** With `log.boards_per_log: N` the samples N g to N g + N - 1 are boards of log g. Class and split are
//! those of the log, by its number in the place of the sample's ([`super::balance`]). What belongs to the log is drawn
//! once for it, from the stream seed / family / `log` / g; what belongs to the board, its face and the bench is drawn
//! for each sample as ever. The boards have one size and lie in the log by a pattern ([`procedural::wood::sawn_at`])
//! that begins where `stem` says. With `sampling: low_discrepancy` a key of the log has a point for each log, a key of
//! the board one for each board.
//!
//! What belongs to the log is said in [`super::level`].
//!
//! **Limits.** Rot, stain, compression wood, inclusions, cracks and all that lies on the face are each board's own,
//! although some would go on in the next one; the same holds for the waviness of growth layers and the pattern of fibre
//! bundles.

use procedural::wood::{LogRoom, Stem, least_pieces, sawn_at};

use super::Plan;
use super::constraints::bounds::DrawBounds;
use super::keys::settings::Settings;
use optical_bench::settings::LogSource;
use yaml::YamlReader;

/// The key of a recipe that says how many boards of one log there are.
pub(super) const BOARDS_PER_LOG: &str = "log.boards_per_log";

/// Which board of which log a sample is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LogBoard {
    /// Number of the log.
    pub log: u64,
    /// Number of the board in it.
    pub board: u64,
}

/// Boards of one log; 1 where each has a log of its own, or what it is made from is no log.
pub(super) fn boards_per_log(settings: &Settings) -> u64 {
    match settings.log.source {
        LogSource::Stem | LogSource::Measured => settings.log.boards_per_log as u64,
        LogSource::Placed | LogSource::Picture | LogSource::Slices => 1,
    }
}

/// Lays the board of a plan, whose numbers are those of the first of its log, where it is sawn.
pub(super) fn lay(plan: &mut Plan, measured: Option<&Stem>, board: u64) {
    if let Plan::Wood(wood) = plan {
        let room = match measured {
            Some(stem) => measured_room(stem),
            None => LogRoom { length_mm: wood.stem.length_mm, radius_mm: wood.stem.radius_mm },
        };
        *wood = sawn_at(wood, room, board);
    }
}

fn measured_room(stem: &Stem) -> LogRoom {
    let [low, high] = stem.ends_mm();
    LogRoom { length_mm: high - low, radius_mm: stem.mean_radius_mm() }
}

/// Notes a fault where a log may have no room for its boards.
pub(super) fn fits(yaml: &mut YamlReader, settings: &Settings, measured: Option<&Stem>, scene: &DrawBounds) {
    let boards = boards_per_log(settings);
    if boards == 1 {
        return;
    }
    let length = measured.map_or_else(|| scene.least("stem.length_mm"), |stem| measured_room(stem).length_mm);
    let (long, wide) = (scene.most("board.length_mm"), scene.most("board.width_mm"));
    let pieces = least_pieces(length, long, wide, scene.ends("log.grain_angle_deg")[1]);
    if boards > pieces {
        let problem = format!("{boards} boards may not fit: of a log, {pieces} pieces one behind the other are sure");
        let keys = [BOARDS_PER_LOG, "stem.length_mm", "board.length_mm", "board.width_mm", "log.grain_angle_deg"];
        let remedy = format!("give at most {pieces}, shorter boards or longer stems");
        scene.fault(yaml, &keys, problem, &remedy);
    }
}

#[cfg(test)]
mod tests;
