//! Which pocket gets which defect, and how bad it is.
//!
//! Models: each kind ranks the pockets by a hash of its own and takes the first that may have it, so that another count
//! of one kind moves another kind only where the two exclude each other. A pocket has at most one defect of its whole,
//! at most one damage to its tablet, and at most one of every other kind.

use base::{Class, Stream};
use rand::RngExt;

use super::parameters::Defects;

/// A defect of a pocket.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannedDefect {
    /// Number of the pocket.
    pub cell: usize,
    /// Kind.
    pub class: Class,
    /// Severity [1].
    pub severity: f32,
    /// What decides its details.
    pub stream: Stream,
}

/// Defects that a pocket can have, in the order in which they choose; first those of its whole.
const KINDS: [Class; 15] = [
    Class::Missing,
    Class::ForeignTablet,
    Class::Double,
    Class::WrongCoat,
    Class::Shallow,
    Class::Broken,
    Class::Capped,
    Class::Cracked,
    Class::Chipped,
    Class::Collapsed,
    Class::Punctured,
    Class::Powder,
    Class::Particle,
    Class::Fibre,
    Class::Pinhole,
];

/// Whether it is a defect of the whole pocket.
pub fn whole(class: Class) -> bool {
    matches!(class, Class::Missing | Class::ForeignTablet | Class::Double | Class::WrongCoat | Class::Shallow)
}

/// Whether it takes something away from a tablet.
pub fn damage(class: Class) -> bool {
    matches!(class, Class::Broken | Class::Capped | Class::Cracked | Class::Chipped)
}

/// Whether a pocket that has `there` may also have `new`.
fn together(there: Class, new: Class) -> bool {
    match new {
        _ if there == new || whole(there) && whole(new) => false,
        Class::Broken | Class::Capped | Class::Cracked | Class::Chipped => {
            !damage(there) && matches!(there, Class::WrongCoat)
        }
        Class::Collapsed => !damage(there) && !matches!(there, Class::Shallow | Class::Double),
        _ => true,
    }
}

/// How many of a kind are asked for.
pub fn asked(defects: &Defects, class: Class) -> usize {
    let count = match class {
        Class::Missing => defects.missing,
        Class::ForeignTablet => defects.foreign_tablet,
        Class::Double => defects.double,
        Class::WrongCoat => defects.wrong_coat,
        Class::Shallow => defects.shallow,
        Class::Broken => defects.broken,
        Class::Capped => defects.capped,
        Class::Cracked => defects.cracked,
        Class::Chipped => defects.chipped,
        Class::Collapsed => defects.collapsed,
        Class::Punctured => defects.punctured,
        Class::Powder => defects.powder,
        Class::Particle => defects.particle,
        Class::Fibre => defects.fibre,
        Class::Pinhole => defects.pinhole,
        Class::Channel => defects.channel,
        Class::Wrinkle => defects.wrinkle,
        Class::Delamination => defects.delamination,
        Class::TabletOnFlange => defects.tablet_on_flange,
        _ => 0.0,
    };
    count as usize
}

/// Severity of a defect with that stream: between half and all of the worst [1].
pub fn severity(defects: &Defects, stream: Stream) -> f32 {
    let share: f64 = stream.child("severity").rng().random();
    (defects.severity * (0.5 + 0.5 * share)) as f32
}

/// The defects of all pockets, kind by kind.
pub fn plan(stream: Stream, defects: &Defects, pockets: usize) -> Vec<PlannedDefect> {
    let mut plan: Vec<PlannedDefect> = Vec::new();
    for class in KINDS.into_iter().chain([Class::Channel]) {
        let stream = stream.child("defects").child(class.name());
        let mut ranking: Vec<usize> = (0..pockets).collect();
        ranking.sort_by_key(|&cell| stream.index(cell as u64).key());
        let free: Vec<usize> = ranking
            .into_iter()
            .filter(|&cell| plan.iter().all(|p| p.cell != cell || together(p.class, class)))
            .take(asked(defects, class))
            .collect();
        plan.extend(free.into_iter().map(|cell| {
            let stream = stream.index(cell as u64);
            PlannedDefect { cell, class, severity: severity(defects, stream), stream }
        }));
    }
    plan
}

/// `from` at severity 0 and `to` at severity 1.
pub fn graded(severity: f32, from: f32, to: f32) -> f32 {
    from + (to - from) * severity
}

#[cfg(test)]
mod tests {
    use super::super::parameters::{EXCLUSIVE_DEFECT_COUNTS, POCKET_DEFECT_COUNTS};
    use super::*;

    /// What recipes are told of counts is what the plan does: these are the kinds of pockets, and those exclude each
    /// other.
    #[test]
    fn counts_are_those_of_the_plan() {
        let path = |class: &Class| format!("defects.{}", class.name());
        let planned: Vec<Class> = KINDS.into_iter().chain([Class::Channel]).collect();
        let mut kinds: Vec<String> = planned.iter().map(path).collect();
        let mut named = POCKET_DEFECT_COUNTS.to_vec();
        kinds.sort();
        named.sort_unstable();
        assert_eq!(kinds, named);
        let exclusive: Vec<&Class> =
            planned.iter().filter(|class| EXCLUSIVE_DEFECT_COUNTS.contains(&path(class).as_str())).collect();
        assert_eq!(exclusive.len(), EXCLUSIVE_DEFECT_COUNTS.len());
        for (place, later) in exclusive.iter().enumerate() {
            for earlier in &exclusive[..place] {
                assert!(!together(**earlier, **later), "{earlier:?} and {later:?}");
            }
        }
    }
}
