//! Defects of boards: each changes matter or surface where its label stands and nowhere else, shows at least a pixel,
//! and leaves everything that other streams draw as it was.

use crate::boards::{grow, wood};
use base::{BodyKind, Class, Matter, Surface};
use procedural::wood::Plank;
use procedural::wood::Wood;

/// Boards of each kind.
const BOARDS: u64 = 8;
/// Distance of the points that are looked at [mm].
const STEP_MM: f32 = 0.4;

/// A kind of defect: its class, what asks for it, and how much of a coefficient, a coat or a millimetre of depth the
/// label's border stands for: less than this beside labels, more within most of them [1].
pub(crate) struct Kind {
    class: Class,
    pub ask: fn(&mut Wood),
    /// Least change within labels, for nine of ten points.
    inside: f64,
    /// Largest change beside labels, for all but one of 500 points; wood a little deeper below a dent is other wood.
    beside: f64,
}

pub(crate) const KINDS: &[Kind] = &[
    Kind { class: Class::KnotHole, ask: |w| w.knots.hole_count = 2.0, inside: 0.3, beside: f64::INFINITY },
    Kind { class: Class::LooseKnot, ask: |w| w.knots.loose_count = 2.0, inside: 0.3, beside: f64::INFINITY },
    // Where half of the front has passed, rot of severity 1/2 absorbs 6.25^(1/2) times as much, and 6.25^(5/8) times
    // where mottle adds its root mean square of a quarter.
    Kind { class: Class::Rot, ask: |w| w.rot.pocket_count = 4.0, inside: 0.5, beside: 2.2 },
    Kind { class: Class::Rot, ask: |w| (w.rot.heart_mm, w.log.pith_depth_mm) = (25.0, 5.0), inside: 0.5, beside: 2.2 },
    Kind {
        class: Class::IncipientDecay,
        ask: |w| (w.rot.reach_mm, w.rot.incipient_mm) = (20.0, 15.0),
        inside: 0.1,
        beside: f64::INFINITY,
    },
    Kind {
        class: Class::Pith,
        ask: |w| (w.log.pith_mm, w.log.pith_depth_mm, w.log.pith_wander_mm, w.log.pith_tilt_deg) = (2.0, 0.0, 0.2, 0.0),
        inside: 0.5,
        beside: 0.05,
    },
    Kind { class: Class::CompressionWood, ask: |w| w.compression.severity = 1.0, inside: 1.0, beside: 1.05 },
    Kind { class: Class::BlueStain, ask: |w| w.stain.severity = 1.0, inside: 0.6, beside: 1.6 },
    Kind { class: Class::ResinPocket, ask: |w| w.inclusions.resin_pocket_count = 3.0, inside: 0.3, beside: 0.5 },
    Kind { class: Class::ResinStreak, ask: |w| w.inclusions.resin_streak_count = 2.0, inside: 0.25, beside: 0.5 },
    Kind { class: Class::BarkPocket, ask: |w| w.inclusions.bark_pocket_count = 3.0, inside: 2.0, beside: 20.0 },
    Kind { class: Class::Check, ask: |w| w.cracks.check_count = 3.0, inside: 0.03, beside: 0.05 },
    Kind { class: Class::Shake, ask: |w| w.cracks.shake_count = 2.0, inside: 0.03, beside: 0.05 },
    Kind { class: Class::Split, ask: |w| w.cracks.split_count = 2.0, inside: 0.03, beside: 0.05 },
    Kind { class: Class::InsectHole, ask: |w| w.holes.count = 8.0, inside: 0.03, beside: 0.05 },
    Kind { class: Class::Wane, ask: |w| w.wane.width_mm = 15.0, inside: 0.03, beside: 0.9 },
    Kind { class: Class::Dirt, ask: |w| w.marks.dirt_count = 5.0, inside: 0.1, beside: 0.35 },
    Kind { class: Class::RollerMark, ask: |w| w.marks.roller_um = 200.0, inside: 0.04, beside: 0.2 },
    Kind { class: Class::Burn, ask: |w| w.marks.burn_count = 2.0, inside: 0.2, beside: 0.4 },
];

/// Points of a face with what is there.
fn look(plank: &Plank) -> Vec<(Surface, Matter)> {
    let (low, high) = plank.bounds();
    let mut points = Vec::new();
    for j in 0..((high.y - low.y) / STEP_MM) as usize {
        let slice = plank.slice(low.y + (j as f32 + 0.5) * STEP_MM);
        for i in 0..((high.x - low.x) / STEP_MM) as usize {
            let x = low.x + (i as f32 + 0.5) * STEP_MM;
            let surface = slice.surface(x).expect("inside the board");
            points.push((surface, slice.matter(x, surface.z)));
        }
    }
    points
}

/// How much two points differ: the largest of the relative changes of coefficients and coat, and the change of height
/// [mm].
fn change(a: &(Surface, Matter), b: &(Surface, Matter)) -> f64 {
    let (m, n) = (a.1.medium, b.1.medium);
    let parts = [(m.mu_a, n.mu_a), (m.sigma_i, n.sigma_i), (m.k, n.k), (m.coat, n.coat)];
    let most = parts.iter().map(|(with, without)| (with / without - 1.0).abs()).fold(0.0f32, f32::max);
    f64::from(most.max((a.0.z - b.0.z).abs()))
}

#[test]
#[ignore = "long"]
fn defects_are_where_their_labels_stand() {
    for kind in KINDS {
        let (mut inside, mut beside) = (Vec::new(), Vec::new());
        for seed in 0..BOARDS {
            let mut base = wood(0.0, 0.0);
            (base.board.width_mm, base.board.length_mm) = (60.0, 80.0);
            let mut asked = base;
            (kind.ask)(&mut asked);
            // The log is the same with and without.
            let clear = Wood { log: procedural::wood::Log { pith_mm: 0.0, ..asked.log }, ..base };
            let (with, without) = (grow(seed, &asked), grow(seed, &clear));
            let (with_points, without_points) = (look(&with), look(&without));
            for instance in with.instances().iter().filter(|instance| instance.class == kind.class) {
                let pixels = with_points.iter().filter(|(_, matter)| matter.instance == instance.id).count();
                assert!(pixels > 0, "{:?} of seed {seed} shows nothing: {instance:?}", kind.class);
            }
            for (a, b) in with_points.iter().zip(&without_points) {
                let labelled = a.1.class == kind.class;
                if labelled { &mut inside } else { &mut beside }.push(change(a, b));
            }
        }
        inside.sort_by(f64::total_cmp);
        beside.sort_by(f64::total_cmp);
        let (low, high) = (inside[inside.len() / 10], beside[beside.len() - 1 - beside.len() / 500]);
        println!("{:?}: {} points, nine of ten change by {low:.3}; beside {high:.3}", kind.class, inside.len());
        assert!(low >= kind.inside, "{:?}: a tenth of its points change by less than {low}", kind.class);
        assert!(high <= kind.beside, "{:?}: beside it points change by {high}", kind.class);
    }
}

#[test]
fn a_defect_leaves_the_others_alone() {
    let mut base = wood(2.0, 1.0);
    base.rot.reach_mm = 15.0;
    base.stain.severity = 0.5;
    base.cracks.check_count = 2.0;
    let before = grow(3, &base);
    let mut more = base;
    more.holes.count = 5.0;
    more.inclusions.resin_pocket_count = 2.0;
    more.marks.dirt_count = 3.0;
    let after = grow(3, &more);
    for instance in before.instances() {
        let same = |other: &&base::Instance| {
            (other.class, other.x_mm.to_bits(), other.y_mm.to_bits())
                == (instance.class, instance.x_mm.to_bits(), instance.y_mm.to_bits())
        };
        assert!(after.instances().iter().any(|other| same(&other)), "{instance:?} has moved");
    }
}

/// Blue stain keeps out of heartwood, and the border of heartwood follows rings.
#[test]
fn stain_stays_in_sapwood() {
    let mut asked = wood(0.0, 0.0);
    asked.log.heartwood_mm = 75.0;
    asked.media.heartwood_mu_a_ratio = 2.0;
    asked.stain.severity = 1.0;
    asked.stain.wedge_count = 8.0;
    let mut bare = asked;
    bare.stain.severity = 0.0;
    let mut plain = bare;
    plain.log.heartwood_mm = 0.0;
    let (mut heart, mut stained) = (0, 0);
    for seed in 0..6 {
        let [with, without, plain] = [asked, bare, plain].map(|wood| look(&grow(seed, &wood)));
        for ((with, without), plain) in with.iter().zip(&without).zip(&plain) {
            let in_heartwood = without.1.medium.mu_a / plain.1.medium.mu_a > 1.999;
            heart += u32::from(in_heartwood);
            stained += u32::from(with.1.class == Class::BlueStain);
            let darker = with.1.medium.mu_a / without.1.medium.mu_a;
            assert!(!in_heartwood || darker < 1.01, "heartwood is stained by {darker}");
        }
    }
    assert!(heart > 10_000 && stained > 5_000, "{heart} points of heartwood, {stained} stained");
}
