//! Defects of packs: how many a pack has, which pocket gets which, and how bad each is.
//!
//! A kind is a row of [`KINDS`]: its class, what it is of, and the function that makes it, which stands in a file of
//! this folder. Its count is the key of `defects` that has the name of its class. Which label stands before others, and
//! a stain that changes matter alone, is in `pack_point.rs`; there the path model of packs must see it too. Nothing
//! lies on the film.
//!
//! A kind may also have a pack in `gen study packs` and a class of samples in `recipes/blister*.yaml` and
//! `recipes/gap`. Where what is in a pocket counts as a tablet, `python/baseline_patches.py` and
//! `tests/models/blister_*.yaml` name it. New shares of classes change what those networks are tested on (`make
//! baselines`).
//!
//! Models: each kind ranks the pockets by a hash of its own and takes the first that may have it, so that another count
//! of one kind moves another kind only where the two exclude each other. A pocket has at most one defect of its whole,
//! at most one damage to its tablet, and at most one of every other kind.

pub mod contaminants;
pub mod content;
pub mod damage;
pub mod film;
pub mod flange;

use base::Need::{self, Any};
use base::{Class, Stream, parameters};
use rand::RngExt;

use self::DefectOf::{Film, Flange, Pocket, Room, Tablet};
use self::content::PocketContent;
use self::damage::{Damage, DamageDraw};
use self::film::MarkDraw;
use self::flange::{FlangeDefect, FlangeDraw};
use super::film_mark::FilmMark;
use super::tablet::TabletForm;
use super::{Blister, Pack};

/// Any of the counts: all numbers but the last.
const COUNTED: Need = Any(Defects::PATHS.split_at(Defects::PATHS.len() - 1).0);

parameters! {
    /// How many of each defect a pack has, and how bad they are.
    defects: Defects {
        /// Pockets without tablet.
        missing: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Broken tablets.
        broken: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Tablets with a chipped edge.
        chipped: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Cracked tablets.
        cracked: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Tablets that lost a cap.
        capped: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Pockets with another product.
        foreign_tablet: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Tablets of the wrong colour, or with a damaged coat.
        wrong_coat: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Pockets with two tablets.
        double: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Foreign particles, in pockets.
        particle: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Foreign fibres, in pockets.
        fibre: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Pockets with powder.
        powder: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Pockets that were not formed to their full depth.
        shallow: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Pockets with a dent.
        collapsed: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Pockets with a hole.
        punctured: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Holes in the foil.
        pinhole: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Channels through the seal.
        channel: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Wrinkles of the foil.
        wrinkle: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Places where film and foil have come apart.
        delamination: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Tablets caught beside the pockets.
        tablet_on_flange: 0.0, 600.0, 0.0, "free", fixed, count;
        /// Severity of the worst, from barely there to as bad as its kind can be; each defect's own lies between half
        /// and all of it.
        severity: 0.0, 1.0, 0.6, "free; spread [M]", uniform(0.2, 1.0), of [COUNTED];
    }
}

/// What a defect is of, with the function that makes it.
#[derive(Debug, Clone, Copy)]
pub enum DefectOf {
    /// A whole pocket: what lies in it, and how deep it is formed.
    Pocket(fn(&Blister, &TabletForm, &PlannedDefect) -> PocketContent),
    /// A tablet, which has lost something.
    Tablet(fn(&DamageDraw) -> Damage),
    /// The film or the foil of a pocket.
    Film(fn(&mut MarkDraw) -> FilmMark),
    /// The room in a pocket, where something lies that does not belong there; nothing where it has no room.
    Room(fn(&mut Pack, &Blister, &PlannedDefect)),
    /// The flange; `None` where it has no room.
    Flange(fn(&FlangeDraw) -> Option<FlangeDefect>),
}

/// A kind of defect.
#[derive(Debug)]
pub struct PackDefect {
    /// Class of its pixels; its name is that of its count.
    pub class: Class,
    /// What it is of.
    pub of: DefectOf,
}

/// Every kind, in the order in which they choose their pockets.
pub static KINDS: &[PackDefect] = &[
    PackDefect { class: Class::Missing, of: Pocket(content::missing) },
    PackDefect { class: Class::ForeignTablet, of: Pocket(content::foreign_tablet) },
    PackDefect { class: Class::Double, of: Pocket(content::double) },
    PackDefect { class: Class::WrongCoat, of: Pocket(content::wrong_coat) },
    PackDefect { class: Class::Shallow, of: Pocket(content::shallow) },
    PackDefect { class: Class::Broken, of: Tablet(damage::broken) },
    PackDefect { class: Class::Capped, of: Tablet(damage::capped) },
    PackDefect { class: Class::Cracked, of: Tablet(damage::cracked) },
    PackDefect { class: Class::Chipped, of: Tablet(damage::chipped) },
    PackDefect { class: Class::Collapsed, of: Film(film::collapsed) },
    PackDefect { class: Class::Punctured, of: Film(film::punctured) },
    PackDefect { class: Class::Powder, of: Room(contaminants::powder) },
    PackDefect { class: Class::Particle, of: Room(contaminants::particle) },
    PackDefect { class: Class::Fibre, of: Room(contaminants::fibre) },
    PackDefect { class: Class::Pinhole, of: Film(film::pinhole) },
    PackDefect { class: Class::Channel, of: Film(film::channel) },
    PackDefect { class: Class::Wrinkle, of: Flange(flange::wrinkle) },
    PackDefect { class: Class::Delamination, of: Flange(flange::delamination) },
    PackDefect { class: Class::TabletOnFlange, of: Flange(flange::tablet_on_flange) },
];

/// A defect of a pocket.
#[derive(Debug, Clone, Copy)]
pub struct PlannedDefect {
    /// Number of the pocket.
    pub cell: usize,
    /// Kind.
    pub kind: &'static PackDefect,
    /// Severity [1].
    pub severity: f32,
    /// What decides its details.
    pub stream: Stream,
}

impl PackDefect {
    /// Whether it excludes all other kinds of which this is true: another content, or a damaged tablet.
    fn is_exclusive(&self) -> bool {
        matches!(self.of, Pocket(_) | Tablet(_)) && self.class != Class::WrongCoat
    }

    /// Whether it may be in a pocket that has `there`.
    fn goes_with(&self, there: &Self) -> bool {
        match self.of {
            _ if self.class == there.class => false,
            Pocket(_) => !matches!(there.of, Pocket(_)),
            Tablet(_) => there.class == Class::WrongCoat,
            _ if self.class == Class::Collapsed => {
                !matches!(there.of, Tablet(_)) && !matches!(there.class, Class::Shallow | Class::Double)
            }
            _ => true,
        }
    }

    /// Paths of the counts of the kinds that are `chosen`, in the order of the keys.
    fn counts(chosen: impl Fn(&Self) -> bool) -> impl Iterator<Item = &'static str> {
        let is_chosen = move |name: &str| KINDS.iter().find(|kind| kind.class.name() == name).is_some_and(&chosen);
        let named = Defects::PARAMETERS.iter().zip(Defects::PATHS);
        named.filter(move |(parameter, _)| is_chosen(parameter.name)).map(|(_, path)| *path)
    }

    /// What decides the details of all of its kind in a pack.
    pub fn stream(&self, pack: Stream) -> Stream {
        pack.child("defects").child(self.class.name())
    }
}

/// Paths of the counts of the kinds that a pocket has at most one of.
pub fn pocket_counts() -> impl Iterator<Item = &'static str> {
    PackDefect::counts(|kind| !matches!(kind.of, Flange(_)))
}

/// Paths of the counts of the kinds that exclude each other in a pocket: those of its whole first.
pub fn exclusive_counts() -> impl Iterator<Item = &'static str> {
    let of_tablets = |kind: &PackDefect| matches!(kind.of, Tablet(_));
    let contents = PackDefect::counts(move |kind| kind.is_exclusive() && !of_tablets(kind));
    contents.chain(PackDefect::counts(of_tablets))
}

impl Defects {
    /// How many of a kind are asked for.
    pub fn asked(&self, kind: &PackDefect) -> usize {
        let values = self.values().into_iter();
        values.filter(|(parameter, _)| parameter.name == kind.class.name()).map(|(_, count)| count as usize).sum()
    }

    /// Severity of a defect with that stream: between half and all of the worst [1].
    pub fn severity(&self, stream: Stream) -> f32 {
        let share: f64 = stream.child("severity").rng().random();
        (self.severity * (0.5 + 0.5 * share)) as f32
    }
}

/// The defects of all pockets, kind by kind.
pub fn plan(stream: Stream, defects: &Defects, pockets: usize) -> Vec<PlannedDefect> {
    let mut plan: Vec<PlannedDefect> = Vec::new();
    for kind in KINDS.iter().filter(|kind| !matches!(kind.of, Flange(_))) {
        let stream = kind.stream(stream);
        let mut ranking: Vec<usize> = (0..pockets).collect();
        ranking.sort_by_key(|&cell| stream.index(cell as u64).key());
        let free: Vec<usize> = ranking
            .into_iter()
            .filter(|&cell| plan.iter().all(|p| p.cell != cell || kind.goes_with(p.kind)))
            .take(defects.asked(kind))
            .collect();
        plan.extend(free.into_iter().map(|cell| {
            let stream = stream.index(cell as u64);
            PlannedDefect { cell, kind, severity: defects.severity(stream), stream }
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
    use super::*;

    /// Every kind has a count, and those that recipes are told to exclude each other do.
    #[test]
    fn counts_are_those_of_the_plan() {
        let mut counted: Vec<&str> = Defects::PARAMETERS.iter().filter(|p| p.integer).map(|p| p.name).collect();
        let mut named: Vec<&str> = KINDS.iter().map(|kind| kind.class.name()).collect();
        counted.sort_unstable();
        named.sort_unstable();
        assert_eq!(counted, named);
        let exclusive: Vec<&PackDefect> = KINDS.iter().filter(|kind| kind.is_exclusive()).collect();
        assert_eq!(exclusive.len(), exclusive_counts().count());
        for (place, later) in exclusive.iter().enumerate() {
            for earlier in &exclusive[..place] {
                assert!(!later.goes_with(earlier), "{earlier:?} and {later:?}");
            }
        }
    }
}
