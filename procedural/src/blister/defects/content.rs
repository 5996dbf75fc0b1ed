//! What lies in a pocket, and how deep that is formed: nothing, another product, two tablets, a wrong coat, too little
//! depth.
//!
//! Models: one tablet a pocket, none, or a second one flat on the first; another product; the right one with the wrong
//! coat. Half of the pockets that were not formed to their full depth have lost their tablet.

use base::Medium;
use rand::RngExt;

use super::{PlannedDefect, graded};
use crate::blister::Blister;
use crate::blister::tablet::{self, TabletForm};

/// Depth of a pocket that is barely too shallow, and of the worst, over the full depth [1].
const SHALLOW: [f32; 2] = [0.85, 0.3];

/// What lies in a pocket.
#[derive(Debug, Clone, Copy)]
pub struct PocketContent {
    /// Form of each tablet.
    pub form: TabletForm,
    /// What they are made of.
    pub medium: Medium,
    /// How many lie there, each on the one before.
    pub tablets: usize,
    /// Depth of the pocket over the full one [1].
    pub depth: f32,
}

impl PocketContent {
    /// What lies in a pocket as it should be.
    pub fn sound(blister: &Blister, form: &TabletForm) -> Self {
        Self { form: *form, medium: tablet::medium(&blister.tablet), tablets: 1, depth: 1.0 }
    }
}

/// No tablet.
pub fn missing(blister: &Blister, form: &TabletForm, _: &PlannedDefect) -> PocketContent {
    PocketContent { tablets: 0, ..PocketContent::sound(blister, form) }
}

/// Another product that is no larger.
pub fn foreign_tablet(blister: &Blister, _: &TabletForm, planned: &PlannedDefect) -> PocketContent {
    let tablet = &blister.tablet;
    let (long, short) = (tablet.length_mm.max(tablet.width_mm), tablet.length_mm.min(tablet.width_mm));
    let size = f64::from(graded(planned.severity, 1.0, 0.75));
    let mut other = *tablet;
    if long < 1.15 * short {
        (other.shape, other.length_mm, other.width_mm) = (1.0, 0.95 * size * long, 0.6 * size * long);
    } else {
        (other.shape, other.length_mm, other.width_mm) = (0.0, 0.95 * size * short, 0.95 * size * short);
    }
    other.thickness_mm = 0.9 * size * if tablet.shape >= 1.5 { short } else { tablet.thickness_mm };
    other.band_mm = 0.6 * other.thickness_mm;
    other.coat *= f64::from(graded(planned.severity, 0.9, 0.4));
    PocketContent { form: TabletForm::new(&other), medium: tablet::medium(&other), tablets: 1, depth: 1.0 }
}

/// Two tablets.
pub fn double(blister: &Blister, form: &TabletForm, _: &PlannedDefect) -> PocketContent {
    PocketContent { tablets: 2, ..PocketContent::sound(blister, form) }
}

/// A tablet of the wrong colour.
pub fn wrong_coat(blister: &Blister, form: &TabletForm, planned: &PlannedDefect) -> PocketContent {
    let sound = PocketContent::sound(blister, form);
    let mu_a = sound.medium.mu_a * graded(planned.severity, 1.5, 20.0);
    let coat = sound.medium.coat * graded(planned.severity, 0.95, 0.3);
    PocketContent { medium: Medium { mu_a, coat, ..sound.medium }, ..sound }
}

/// A pocket that is not deep enough for its tablet, which half of the time is not there.
pub fn shallow(blister: &Blister, form: &TabletForm, planned: &PlannedDefect) -> PocketContent {
    let is_swept = planned.stream.child("swept").rng().random::<f32>() < 0.5;
    let depth = graded(planned.severity, SHALLOW[0], SHALLOW[1]);
    PocketContent { tablets: usize::from(!is_swept), depth, ..PocketContent::sound(blister, form) }
}

/// Severity of a depth over the full one that a pocket had to be given for its tablet [1].
pub fn shallowness(depth: f32) -> f32 {
    ((SHALLOW[0] - depth) / (SHALLOW[0] - SHALLOW[1])).clamp(0.0, 1.0)
}
