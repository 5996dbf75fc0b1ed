//! Conditional parameters: numbers that are drawn for every sample and mean something only where the sample has what they
//! describe. The width of knots means nothing on a board without knots.

use procedural::blister::parameters::DEFECT_COUNTS;

/// Beginning of a path, and the numbers that say whether the sample has what it describes: it has not where all are 0.
const CONDITIONS: [(&str, &[&str]); 16] = [
    ("knots.sound_count", &[]),
    ("knots.dead_count", &[]),
    ("knots.death_share", &["knots.dead_count"]),
    ("knots.bark_mm", &["knots.dead_count"]),
    ("knots.", &["knots.sound_count", "knots.dead_count"]),
    ("media.knot_", &["knots.sound_count", "knots.dead_count"]),
    ("media.dead_knot_", &["knots.dead_count"]),
    ("media.bark_", &["knots.dead_count"]),
    ("rot.reach_mm", &[]),
    ("rot.", &["rot.reach_mm"]),
    ("media.rot_", &["rot.reach_mm"]),
    ("motion.wow_period_mm", &["motion.wow_um"]),
    ("laser.second_line_share", &["laser.second_line_mm"]),
    ("laser.streak_", &["laser.streaks_per_mm"]),
    ("laser.glint_", &["laser.glints_per_mm"]),
    ("defects.severity", &DEFECT_COUNTS),
];

/// Paths of the numbers that say whether a sample has what the number `path` is of; none where every sample has it.
pub(crate) fn deciders(path: &str) -> impl Iterator<Item = &'static str> {
    let found = CONDITIONS.iter().find(|(start, _)| path.starts_with(start));
    found.map_or(&[][..], |(_, deciders)| deciders).iter().copied()
}

#[cfg(test)]
mod tests {
    use procedural::Parameter;
    use procedural::blister::Blister;
    use procedural::wood::Wood;

    use super::*;

    /// Every path in the table is a number that is declared, every start one or more of them, and none is shadowed: a
    /// number that is renamed or a new defect must be entered here.
    #[test]
    fn the_table_is_of_numbers_that_there_are() {
        let mut known = vec!["motion.wow_um".to_owned(), "laser.second_line_mm".into()];
        known.extend(["laser.streaks_per_mm", "laser.glints_per_mm"].map(String::from));
        let mut note = |p: &'static Parameter| {
            known.push(p.path());
            p.default
        };
        Wood::from_values(&mut note);
        Blister::from_values(&mut note);
        for (start, deciders) in CONDITIONS {
            assert!(deciders.iter().all(|decider| known.iter().any(|path| path == decider)), "{start}");
            let elsewhere = start.starts_with("motion.") || start.starts_with("laser.");
            let first =
                |path: &String| CONDITIONS.iter().find(|(s, _)| path.starts_with(s)).is_some_and(|(s, _)| *s == start);
            assert!(elsewhere || known.iter().any(first), "{start} begins nothing");
        }
        let counts = known.iter().filter(|path| path.starts_with("defects.") && *path != "defects.severity");
        assert!(counts.eq(DEFECT_COUNTS.iter()));
    }

    #[test]
    fn a_count_is_never_moot_and_what_it_counts_is() {
        let of = |path: &str| deciders(path).collect::<Vec<_>>();
        assert_eq!(of("knots.width_mm"), ["knots.sound_count", "knots.dead_count"]);
        assert_eq!(of("media.dead_knot_mu_a_ratio"), ["knots.dead_count"]);
        assert_eq!(of("defects.severity").len(), DEFECT_COUNTS.len());
        for path in ["knots.dead_count", "rot.reach_mm", "laser.streaks_per_mm", "exposure.time_us", "film.n", ""] {
            assert!(of(path).is_empty(), "{path}");
        }
    }
}
