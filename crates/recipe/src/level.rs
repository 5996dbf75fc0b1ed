//! Levels: which samples have a number in common, because it belongs to the instrument, or to what they were made from.
//!
//! | level | numbers | drawn once for |
//! |---|---|---|
//! | rig | all of the bench | each of `rigs`, or each sample |
//! | lot | matter: a board's log; tablets, film, foil and tools; material | each log or batch, or each sample |
//! | sample | what lies on the face, defects, and how the object lies | each sample |

use optical_bench::parameters::Bench;

use super::groups::GroupSizes;

/// What a number belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DrawLevel {
    /// The instrument.
    Rig,
    /// The log or the batch.
    Lot,
    /// The sample.
    Sample,
}

/// Numbers of a pack that say how it lies and has warped.
const OF_A_PACK: [&str; 5] = ["offset_mm", "lead_in_mm", "turn_deg", "bow_mm", "curl_mm"];
/// Numbers of a calibration piece that say how it lies.
const OF_A_PIECE: [&str; 3] = ["turn_deg", "offset_mm", "lead_in_mm"];
/// Numbers of a board that are those of all boards of its log.
const OF_BOARDS: [&str; 3] = ["width_mm", "length_mm", "thickness_mm"];

/// What the parameter at `path` belongs to.
pub(super) fn declared(path: &str) -> DrawLevel {
    let lot = |is_of_lot| if is_of_lot { DrawLevel::Lot } else { DrawLevel::Sample };
    match path.split_once('.') {
        Some((group, _)) if Bench::SECTIONS.contains(&group) => DrawLevel::Rig,
        Some(("log" | "stem" | "knots" | "anatomy", _)) => DrawLevel::Lot,
        // The gloss is what the tool leaves.
        Some(("media", name)) => lot(name != "gloss"),
        Some(("board", name)) => lot(OF_BOARDS.contains(&name)),
        Some(("pocket" | "tablet" | "film" | "foil" | "material", _)) => DrawLevel::Lot,
        Some(("pack", name)) => lot(!OF_A_PACK.contains(&name)),
        Some(("sawtooth", name)) => lot(!OF_A_PIECE.contains(&name)),
        _ => DrawLevel::Sample,
    }
}

impl GroupSizes {
    /// What the parameter at `path` is drawn once for: the sample, where each has an instrument, a log or a batch of
    /// its own.
    pub fn level(&self, path: &str) -> DrawLevel {
        match declared(path) {
            DrawLevel::Rig if self.rigs.is_none() => DrawLevel::Sample,
            DrawLevel::Lot if self.lot == 1 => DrawLevel::Sample,
            level => level,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::keys;

    /// What varies by nature is of every level, and a section of the bench is never another's.
    #[test]
    fn levels_are_of_keys_that_are_declared() {
        let of = |level| keys::parameters(None).filter(|parameter| declared(&parameter.path()) == level).count();
        assert!([DrawLevel::Rig, DrawLevel::Lot, DrawLevel::Sample].into_iter().all(|level| of(level) > 50));
        for (group, names) in [("pack", &OF_A_PACK[..]), ("sawtooth", &OF_A_PIECE), ("board", &OF_BOARDS)] {
            for name in names {
                assert!(keys::parameter(None, &format!("{group}.{name}")).is_some(), "{group}.{name}");
            }
        }
        // A group is a column of datasets too, beside those that say which log a board is of.
        for parameter in keys::parameters(None) {
            assert!(output_schema::row::ROW.iter().all(|column| column.name != parameter.group), "{}", parameter.group);
        }
    }
}
