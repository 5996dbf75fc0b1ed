//! Where the upper face lies lower: checks, shakes and splits, insect holes, holes of knots, wane, dents and skipped
//! places.
//!
//! Models: each lowers the face. A crack is a wedge: at the distance c from its line the depth is d (1 - |c| / w), with
//! half width w(s) and depth d(s) along it, both zero at closed ends. The line of a check runs along the grain and
//! wanders; that of a shake follows a ring of the face; a split is a check that begins at an end of the board with its
//! full width. A hole is round across its axis, with walls that fall by [`STEEPEST`]. The hole of a knot has the knot's
//! own outline. A loose knot has shrunk more than the wood around: it lies lower, tilted about a drawn axis, and rests
//! against one side of its hole, so that the gap is g (1 + cos a) wide at the angle a from the other side, and
//! wedge-shaped. Wane is the log's surface: a slope from a wandering line on the face down to the side, bent as the
//! ring there is, or the outline of the stem (`outline_wane`). Teeth of a roller leave dents at a pitch; where the
//! planer missed, the sawn face lies lower and is rough. A chipped arris has lost a splinter: half an ellipse on the
//! face with an uneven outline, whose floor falls from it to the side. Depths: a line on the sensor cannot be found
//! deeper in a crack than some widths, since walls are lit and seen at grazing angles and light gets out by scattering
//! alone; cracks end at [`DEEPEST_WIDTHS`] of their width. Sources: widths and depths in docs/theory/wood.md. Limits:
//! cracks stand upright to the face; light that falls between walls is thrown back once and does not light the other
//! wall from the air; no crack passes into another; holes stand upright; loose knots sink and do not stand proud; chips
//! have no label.

use base::{Class, Instance, Stream, Surface, lognormal};
use glam::Vec2;
use rand::RngExt;

use super::growth::wrap;
use super::knot::{Knot, KnotDistance, KnotSection};
use super::knot_placement::PlacedKnot;
use super::opening_floor::{BarkCover, FLOOR_MM, Floor};
use super::outline_wane::{OutlineWane, WaneEdge};
use super::parameters::Wood;
use super::pith::Trunk;
use super::zones::BoardFace;
use crate::noise::{Noise, smoothstep};

/// Steepest wall of a hole [1].
const STEEPEST: f32 = 20.0;
/// Deepest place of a crack that can be found, over its width [1].
const DEEPEST_WIDTHS: f32 = 25.0;
/// Step of the tables of cracks along them [mm].
const STEP_MM: f32 = 0.5;
/// Most entries of such a table.
const MAX_STEPS: f32 = 20_000.0;
/// Spread of the logarithms of a crack's length, width and depth, and of a hole's diameter [1].
const LOG_SD: f64 = 0.4;
/// Wander of a check's line, root mean square over its length [1], and its cells along it [mm].
const WANDER: [f32; 2] = [0.004, 18.0];
/// Unevenness of a crack's width along it, root mean square [1], and its cell [mm].
const UNEVEN: [f32; 2] = [0.3, 5.0];
/// Wander of the wane's line over its width, root mean square [1], and its cell along the board [mm].
const WANE_WANDER: [f32; 2] = [0.3, 70.0];
/// Depth from which on a place has the opening's label [mm].
const LABELLED_MM: f32 = 0.03;
/// Wander of the outline of a place that the planer missed, over its size, root mean square [1].
const SKIP_OUTLINE: f32 = 0.15;
/// Strands of the rough wood there, across and along [mm], and their height over the depth, root mean square [1].
const SKIP_STRAND_MM: Vec2 = Vec2::new(0.5, 5.0);
const SKIP_ROUGH: f32 = 0.15;
/// Tilt of a loose knot: change of its depth over a half width, over the mean depth [1].
const LOOSE_TILT: f32 = 0.7;
/// Width across and depth of a chip over its length along the arris [1].
const CHIP_SHAPE: [f32; 2] = [0.25, 0.2];
/// Unevenness of a chip's outline and floor, root mean square [1], and its cells across and along [mm].
const CHIP_UNEVEN: f32 = 0.2;
/// Most of that unevenness [root mean squares].
const CHIP_MOST: f32 = 5.0;
const CHIP_CELL_MM: Vec2 = Vec2::new(1.2, 6.0);
/// Light that the dark wall of a gallery lets through, each way; an estimate [1].
pub(super) const GALLERY_COAT: f32 = 0.45;
/// Step of the differences that give slopes [mm].
const DIFFERENCE_MM: f32 = 0.004;

/// An opening at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Opened {
    /// How far it lies below the face [mm].
    pub depth: f32,
    /// Its class and instance.
    pub class: Class,
    pub id: u16,
    /// Whether the place has its label.
    pub is_labelled: bool,
    /// What is at its floor.
    pub floor: Floor,
}

#[derive(Debug, Clone)]
enum OpeningForm {
    Crack {
        /// First entry's place along the log, from the board's middle [mm].
        start: f32,
        /// Distance of two entries [mm].
        step: f32,
        /// At each step: place across the log, half width, depth [mm].
        table: Vec<[f32; 3]>,
    },
    Hole {
        centre: Vec2,
        /// Half its size along and across the log [mm].
        half: Vec2,
        depth: f32,
        frass: bool,
    },
    Knot {
        knot: Box<Knot>,
        depth: f32,
    },
    LooseKnot {
        knot: Box<Knot>,
        /// Mean width of the gap [mm], and its depth where it is widest [mm].
        gap: f32,
        depth: f32,
        /// Mean depth of the knot's face [mm].
        sunk: f32,
        /// Directions on the outline where the gap is widest and where the face lies deepest.
        wide: Vec2,
        low: Vec2,
    },
    Wane {
        /// -1 or 1.
        side: f32,
        width: f32,
        slope: f32,
        /// One over twice the radius of the log [mm^-1].
        bend: f32,
        line: Noise,
        bark: BarkCover,
    },
    Outline(Box<OutlineWane>),
    Roller {
        /// Middle of the band across the board [mm].
        x: f32,
        half_width: f32,
        pitch: f32,
        depth: f32,
    },
    Skip {
        centre: Vec2,
        half: Vec2,
        depth: f32,
        outline: Noise,
        rough: Noise,
    },
    Chip {
        /// Middle of the chip on the arris.
        arris: Vec2,
        /// -1 or 1.
        side: f32,
        half: Vec2,
        depth: f32,
        uneven: Noise,
    },
}

/// One opening.
#[derive(Debug, Clone)]
pub(super) struct Opening {
    class: Class,
    id: u16,
    /// Box on the face: from, to [mm].
    low: Vec2,
    high: Vec2,
    /// Depth from which on a place has the label [mm].
    labelled: f32,
    form: OpeningForm,
}

/// All openings of a board.
#[derive(Debug, Clone)]
pub(super) struct Openings {
    all: Vec<Opening>,
    face: BoardFace,
    /// Cosine and sine of the log's turn [1].
    turn: Vec2,
}

impl Openings {
    /// The openings that the numbers ask for; instances of all but knots are added to `instances`.
    pub fn grow(
        stream: Stream,
        wood: &Wood,
        trunk: &Trunk,
        knots: &[PlacedKnot],
        instances: &mut Vec<Instance>,
    ) -> Self {
        let (sin, cos) = libm::sincos(wood.log.turn_deg().to_radians());
        let mut openings = Self { all: Vec::new(), face: BoardFace::of(wood), turn: Vec2::new(cos as f32, sin as f32) };
        openings.knots(wood, knots, instances);
        openings.loose_knots(stream.child("loose"), wood, knots, instances);
        openings.cracks(stream, wood, trunk, instances);
        openings.holes(stream.child("hole"), wood, instances);
        openings.wane(stream.child("wane"), wood, trunk, instances);
        openings.machining(stream, wood, instances);
        openings.chips(stream.child("chip"), wood);
        openings
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The openings that the profile at `y` crosses [mm].
    pub fn near(&self, y: f32) -> Vec<&Opening> {
        self.all.iter().filter(|one| one.low.y <= y && y <= one.high.y).collect()
    }

    fn note(instances: &mut Vec<Instance>, class: Class, spot: Vec2, size: f32, severity: f64, depth: f32) -> u16 {
        let id = instances.len() as u16 + 1;
        let at = [f64::from(spot.x), f64::from(spot.y)];
        let depth_mm = f64::from(depth);
        instances.push(Instance { depth_mm, ..Instance::defect(id, class, at, f64::from(size), severity) });
        id
    }

    /// Part of the board's thickness that an opening takes [1].
    fn part(&self, depth: f32) -> f64 {
        f64::from((depth / self.face.height).min(1.0))
    }

    fn knots(&mut self, wood: &Wood, knots: &[PlacedKnot], instances: &mut [Instance]) {
        let depth = (wood.knots.hole_depth_mm as f32).min(self.face.height - FLOOR_MM).max(0.0);
        for placed in knots.iter().filter(|placed| placed.knot.class == Class::KnotHole) {
            for instance in instances.iter_mut().filter(|instance| instance.id == placed.knot.id) {
                instance.depth_mm = f64::from(depth);
            }
            let form = OpeningForm::Knot { knot: Box::new(placed.knot.clone()), depth };
            let (low, high) = (Vec2::new(placed.x[0], placed.y[0]), Vec2::new(placed.x[1], placed.y[1]));
            self.all.push(Opening {
                class: Class::KnotHole,
                id: placed.knot.id,
                low,
                high,
                labelled: LABELLED_MM,
                form,
            });
        }
    }

    fn loose_knots(&mut self, stream: Stream, wood: &Wood, knots: &[PlacedKnot], instances: &mut [Instance]) {
        let room = self.face.height - FLOOR_MM;
        let [gap, sunk] = [wood.knots.loose_gap_mm, wood.knots.loose_sunk_mm].map(|mm| mm as f32);
        let loose = knots.iter().filter(|placed| placed.knot.class == Class::LooseKnot);
        for (placed, index) in loose.zip(0..) {
            let mut rng = stream.index(index).rng();
            let mut direction = || {
                let (sin, cos) = libm::sincosf(std::f32::consts::TAU * rng.random::<f32>());
                Vec2::new(cos, sin)
            };
            let (wide, low) = (direction(), direction());
            let depth = (DEEPEST_WIDTHS * 2.0 * gap).min(room).max(0.0);
            let sunk = sunk.min(room / (1.0 + LOOSE_TILT)).max(0.0);
            for instance in instances.iter_mut().filter(|instance| instance.id == placed.knot.id) {
                let half_width = 0.5 * instance.diameter_mm as f32;
                // A gap that is wider than the knot has no room for its deepest place.
                let open = depth * (half_width / gap.max(1.0e-3)).min(1.0);
                instance.depth_mm = f64::from(open.max(deepest_of_face(sunk, half_width)));
            }
            let form = OpeningForm::LooseKnot { knot: Box::new(placed.knot.clone()), gap, depth, sunk, wide, low };
            self.all.push(Opening {
                class: Class::LooseKnot,
                id: placed.knot.id,
                low: Vec2::new(placed.x[0], placed.y[0]),
                high: Vec2::new(placed.x[1], placed.y[1]),
                labelled: LABELLED_MM,
                form,
            });
        }
    }

    fn chips(&mut self, stream: Stream, wood: &Wood) {
        let face = self.face;
        for index in 0..wood.marks.chip_count.round() as u64 {
            let own = stream.index(index);
            let mut rng = own.rng();
            let side = if rng.random::<bool>() { 1.0 } else { -1.0 };
            let along = 2.0 * rng.random::<f32>() - 1.0;
            let length = lognormal(&mut rng, wood.marks.chip_mm, LOG_SD) as f32;
            let depth = (CHIP_SHAPE[1] * length).min(0.5 * face.height).min(face.height - FLOOR_MM).max(0.0);
            let half = Vec2::new((CHIP_SHAPE[0] * length).min(0.5 * face.half.x), 0.5 * length);
            let arris = face.middle + face.half * Vec2::new(side, along);
            let room = (1.0 + CHIP_MOST * CHIP_UNEVEN) * half + Vec2::new(face.edge_room, 0.0);
            let form = OpeningForm::Chip { arris, side, half, depth, uneven: Noise::new(own.child("uneven")) };
            self.all.push(Opening {
                class: Class::Clear,
                id: 0,
                low: arris - room,
                high: arris + room,
                labelled: f32::INFINITY,
                form,
            });
        }
    }

    fn cracks(&mut self, stream: Stream, wood: &Wood, trunk: &Trunk, instances: &mut Vec<Instance>) {
        let (asked, face) = (&wood.cracks, self.face);
        for (class, name, count) in [
            (Class::Check, "check", asked.check_count),
            (Class::Shake, "shake", asked.shake_count),
            (Class::Split, "split", asked.split_count),
        ] {
            for index in 0..count.round() as u64 {
                let own = stream.child(name).index(index);
                let mut rng = own.rng();
                let mut spot = face.spot([rng.random(), rng.random()]);
                let (end, towards) = (rng.random::<f32>() < 0.5, [1.0, -1.0]);
                let mut about = |median: f64| lognormal(&mut rng, median, LOG_SD) as f32;
                let (length, width, depth) = (about(asked.length_mm), about(asked.width_mm), about(asked.depth_mm));
                let side = towards[usize::from(end)];
                if class == Class::Split {
                    spot.y = face.middle.y - side * face.half.y;
                }
                let depth = depth.min(DEEPEST_WIDTHS * width).min(face.height - FLOOR_MM).max(0.0);
                let [across, along] = self.log_place(spot);
                // A split goes on as far beyond the end as into the board, so that it is widest there.
                let reach = if class == Class::Split { length } else { 0.5 * length };
                let steps = (2.0 * reach / STEP_MM).ceil().clamp(4.0, MAX_STEPS);
                let (wander, uneven) = (Noise::new(own.child("wander")), Noise::new(own.child("uneven")));
                let ring = trunk.layer(&trunk.place(spot.x, spot.y, face.height));
                let mut line = across;
                let step = 2.0 * reach / steps;
                let table: Vec<[f32; 3]> = (0..=steps as usize)
                    .map(|i| {
                        let s = -reach + i as f32 * step;
                        let place = match class {
                            Class::Shake => {
                                line = self.on_ring(trunk, ring, line, along + s);
                                line
                            }
                            _ => across + WANDER[0] * length * wander.line(s / WANDER[1]).0,
                        };
                        let q = s / reach;
                        let taper = (1.0 - q * q).max(0.0);
                        let uneven = (1.0 + UNEVEN[0] * uneven.line(s / UNEVEN[1]).0).max(0.2);
                        [place, 0.5 * width * taper * uneven, depth * taper.sqrt()]
                    })
                    .collect();
                let id = Self::note(instances, class, spot, length, self.part(depth), depth);
                let start = along - reach;
                let widest = table.iter().fold([f32::MAX, f32::MIN], |[low, high], &[place, half, _]| {
                    [low.min(place - half), high.max(place + half)]
                });
                let corners = [0, 1]
                    .map(|end| [0, 1].map(|side| self.face_place(widest[side], start + end as f32 * 2.0 * reach)));
                let corners = corners.as_flattened();
                let low = corners.iter().copied().reduce(Vec2::min).unwrap_or(spot);
                let high = corners.iter().copied().reduce(Vec2::max).unwrap_or(spot);
                self.all.push(Opening {
                    class,
                    id,
                    low,
                    high,
                    labelled: LABELLED_MM,
                    form: OpeningForm::Crack { start, step, table },
                });
            }
        }
    }

    /// Place across the log where the face at `along` shows the ring `ring`, nearest to `line` [mm].
    fn on_ring(&self, trunk: &Trunk, ring: f32, line: f32, along: f32) -> f32 {
        let mut across = line;
        for _ in 0..4 {
            let spot = self.face_place(across, along);
            let place = trunk.place(spot.x, spot.y, self.face.height);
            // Right above the pith rings lie flat on the face: a step no longer than a millimetre keeps to one line.
            let slope = place.outward.x;
            across -= ((trunk.layer(&place) - ring) * slope / (slope * slope + 0.01)).clamp(-1.0, 1.0);
        }
        across
    }

    fn holes(&mut self, stream: Stream, wood: &Wood, instances: &mut Vec<Instance>) {
        let asked = &wood.holes;
        for index in 0..asked.count.round() as u64 {
            let mut rng = stream.index(index).rng();
            let spot = self.face.spot([rng.random(), rng.random()]);
            let lean = 1.0 + rng.random::<f32>();
            let frass = rng.random::<f64>() < asked.frass;
            let diameter = lognormal(&mut rng, asked.diameter_mm, LOG_SD) as f32;
            let half = 0.5 * diameter * Vec2::new(1.0, lean);
            let full = if frass { 0.15 } else { 1.0 };
            let depth = (asked.depth_mm as f32 * full).min(self.face.height - FLOOR_MM).max(0.0);
            let id = Self::note(instances, Class::InsectHole, spot, 2.0 * half.y, self.part(depth), depth);
            let [across, along] = self.log_place(spot);
            let form = OpeningForm::Hole { centre: Vec2::new(across, along), half, depth, frass };
            let room = Vec2::splat(half.max_element());
            self.all.push(Opening {
                class: Class::InsectHole,
                id,
                low: spot - room,
                high: spot + room,
                labelled: LABELLED_MM,
                form,
            });
        }
    }

    fn wane(&mut self, stream: Stream, wood: &Wood, trunk: &Trunk, instances: &mut Vec<Instance>) {
        let (asked, face) = (&wood.wane, self.face);
        if asked.width_mm == 0.0 {
            return;
        }
        let side = if asked.edge < 0.0 { -1.0 } else { 1.0 };
        let corner = face.middle + Vec2::new(side * face.half.x, 0.0);
        let radius = trunk.place(corner.x, corner.y, face.height).r.max(20.0);
        let width = asked.width_mm as f32;
        let severity = f64::from((width / (2.0 * face.half.x)).min(1.0));
        let spot = corner - Vec2::new(side * 0.5 * width, 0.0);
        let (slope, bend) = (libm::tan(asked.angle_deg.to_radians()) as f32, 0.5 / radius);
        // At the side of the board, where it is as wide as its mean.
        let depth = (slope * width + bend * width * width).min(face.height - FLOOR_MM).max(0.0);
        let id = Self::note(instances, Class::Wane, spot, width, severity, depth);
        let form = OpeningForm::Wane {
            side,
            width,
            slope,
            bend,
            line: Noise::new(stream.child("line")),
            bark: BarkCover::new(stream, asked.bark),
        };
        let reach = width * (1.0 + 4.0 * WANE_WANDER[0]);
        let (inner, outer) = (Vec2::new(side * reach, 0.0), Vec2::new(side * face.edge_room, 0.0));
        let (low, high) = ((corner - inner).min(corner + outer), (corner - inner).max(corner + outer));
        let long = Vec2::new(0.0, face.half.y);
        self.all.push(Opening {
            class: Class::Wane,
            id,
            low: low - long,
            high: high + long,
            labelled: LABELLED_MM,
            form,
        });
    }

    /// Wane where the outline of the stem leaves the face, whose edges at a place along the scan `edges` says, from the
    /// board's middle [mm].
    pub fn leave_outline(
        &mut self,
        wane: &OutlineWane,
        trunk: &Trunk,
        edges: impl Fn(f32) -> [f32; 2],
        instances: &mut Vec<Instance>,
    ) {
        let half_width = self.face.half.x;
        let opening = |edge: WaneEdge| {
            let severity = f64::from((edge.width / (2.0 * half_width)).min(1.0));
            let id = Self::note(instances, Class::Wane, edge.spot, edge.width, severity, edge.depth);
            let (low, high, form) = (edge.low, edge.high, OpeningForm::Outline(Box::new(wane.clone())));
            Opening { class: Class::Wane, id, low, high, labelled: LABELLED_MM, form }
        };
        let waned: Vec<Opening> = wane.edges(self.face, trunk, edges).map(opening).collect();
        // Chips come last: they leave the label of what they cut.
        let chips = self.all.partition_point(|one| !matches!(one.form, OpeningForm::Chip { .. }));
        self.all.splice(chips..chips, waned);
    }

    fn machining(&mut self, stream: Stream, wood: &Wood, instances: &mut Vec<Instance>) {
        let (asked, face) = (&wood.marks, self.face);
        if asked.roller_um > 0.0 {
            let x = face.spot([stream.child("roller").rng().random(), 0.5]).x;
            let (half_width, depth) = (0.5 * asked.roller_width_mm as f32, 1.0e-3 * asked.roller_um as f32);
            let middle = Vec2::new(x, face.middle.y);
            let id = Self::note(instances, Class::RollerMark, middle, 2.0 * face.half.y, self.part(depth), depth);
            let form = OpeningForm::Roller { x, half_width, pitch: asked.roller_pitch_mm as f32, depth };
            let room = Vec2::new(half_width, face.half.y);
            let (low, high) = (middle - room, middle + room);
            self.all.push(Opening { class: Class::RollerMark, id, low, high, labelled: 0.25 * depth, form });
        }
        for index in 0..asked.skip_count.round() as u64 {
            let own = stream.child("skip").index(index);
            let mut rng = own.rng();
            let centre = face.spot([rng.random(), rng.random()]);
            let length = lognormal(&mut rng, asked.skip_mm, LOG_SD) as f32;
            let depth = 1.0e-3 * asked.skip_um as f32;
            let half = 0.5 * length * Vec2::new(1.0 / 3.0, 1.0);
            let id = Self::note(instances, Class::PlanerSkip, centre, length, self.part(depth), depth);
            let [outline, rough] = ["outline", "rough"].map(|name| Noise::new(own.child(name)));
            let form = OpeningForm::Skip { centre, half, depth, outline, rough };
            let room = 1.6 * half;
            let (low, high) = (centre - room, centre + room);
            self.all.push(Opening { class: Class::PlanerSkip, id, low, high, labelled: 0.5 * depth, form });
        }
    }

    /// Across and along the log, from the board's middle [mm].
    #[inline]
    fn log_place(&self, spot: Vec2) -> [f32; 2] {
        let (d, turn) = (spot - self.face.middle, self.turn);
        [d.x * turn.x - d.y * turn.y, d.x * turn.y + d.y * turn.x]
    }

    /// The spot of the face at a place across and along the log [mm].
    fn face_place(&self, across: f32, along: f32) -> Vec2 {
        let turn = self.turn;
        self.face.middle + Vec2::new(across * turn.x + along * turn.y, along * turn.x - across * turn.y)
    }

    /// The deepest of `near` openings at a spot of the face.
    #[inline]
    pub fn at(&self, near: &[&Opening], spot: Vec2, trunk: &Trunk) -> Option<Opened> {
        let mut deepest: Option<Opened> = None;
        for one in near {
            if spot.x < one.low.x || spot.x > one.high.x || spot.y < one.low.y || spot.y > one.high.y {
                continue;
            }
            let (depth, floor) = self.depth(one, spot, trunk);
            if depth > deepest.map_or(0.0, |other| other.depth) {
                let is_labelled = depth > one.labelled;
                deepest = Some(match deepest {
                    // What has no label leaves that of what it cuts.
                    Some(other) if one.labelled == f32::INFINITY => Opened { depth, floor, ..other },
                    _ => Opened { depth, class: one.class, id: one.id, is_labelled, floor },
                });
            }
        }
        deepest
    }

    fn depth(&self, one: &Opening, spot: Vec2, trunk: &Trunk) -> (f32, Floor) {
        match &one.form {
            OpeningForm::Crack { start, step, table } => {
                let [across, along] = self.log_place(spot);
                let at = (along - start) / step;
                let last = table.len() - 2;
                if at < 0.0 || at >= (last + 1) as f32 {
                    return (0.0, Floor::Wood);
                }
                let i = at as usize;
                let part = at - i as f32;
                let [place, half, depth] =
                    std::array::from_fn(|n| table[i][n] + part * (table[i + 1][n] - table[i][n]));
                let aside = (across - place).abs();
                let inside = aside < half;
                (if inside { depth * (1.0 - aside / half) } else { 0.0 }, Floor::Wood)
            }
            OpeningForm::Hole { centre, half, depth, frass } => {
                let [across, along] = self.log_place(spot);
                let q = ((across - centre.x) / half.x).powi(2) + ((along - centre.y) / half.y).powi(2);
                let wall = (depth / STEEPEST / half.x).min(0.9);
                let depth = depth * (1.0 - smoothstep(1.0 - wall, 1.0, q.sqrt()));
                (depth, if *frass { Floor::Frass } else { Floor::Gallery })
            }
            OpeningForm::Knot { knot, depth } => {
                let (x, _, section) = self.in_knot(knot, spot, trunk);
                let wall = (depth / STEEPEST / section.half_width).min(0.7);
                (depth * (1.0 - smoothstep(1.0 - wall, 1.0, x)), Floor::Wood)
            }
            OpeningForm::LooseKnot { knot, gap, depth, sunk, wide, low } => {
                let (x, direction, section) = self.in_knot(knot, spot, trunk);
                if x >= 1.0 {
                    return (0.0, Floor::Wood);
                }
                let width = gap * (1.0 + wide.dot(direction));
                // From the middle of the gap, in halves of its width.
                let aside = (2.0 * (1.0 - x) * section.half_width / width.max(1.0e-3) - 1.0).abs();
                let open = depth * width / (2.0 * gap) * (1.0 - aside).max(0.0);
                (open.max(loose_face(*sunk, section.half_width, x, low.dot(direction))), Floor::Wood)
            }
            OpeningForm::Wane { side, width, slope, bend, line, bark } => {
                let along = spot.y - self.face.middle.y;
                let inwards = self.face.half.x - side * (spot.x - self.face.middle.x);
                let edge = width * (1.0 + WANE_WANDER[0] * line.line(along / WANE_WANDER[1]).0).max(0.0);
                let down = edge - inwards;
                if down <= 0.0 {
                    return (0.0, Floor::Wood);
                }
                let (rough, floor) = bark.at(spot, down);
                let depth = slope * down + bend * down * down + rough;
                (depth.clamp(0.0, (self.face.height - FLOOR_MM).max(0.0)), floor)
            }
            OpeningForm::Outline(wane) => wane.depth(spot, trunk),
            OpeningForm::Roller { x, half_width, pitch, depth } => {
                let aside = (spot.x - x) / half_width;
                // Teeth stand in two staggered rows.
                let turn = spot.y / pitch + if aside < 0.0 { 0.5 } else { 0.0 };
                let (along, across) = (4.0 * (turn - (turn + 0.5).floor()), 2.0 * aside.abs() - 1.0);
                let inside = (1.0 - along * along).max(0.0) * (1.0 - across * across).max(0.0);
                (depth * inside, Floor::Wood)
            }
            OpeningForm::Skip { centre, half, depth, outline, rough } => {
                let q = (spot - centre) / half;
                let edge = 1.0 + SKIP_OUTLINE * outline.plane(2.0 * q).0;
                let share = 1.0 - smoothstep(edge - 0.15, edge + 0.15, q.length());
                if share == 0.0 {
                    return (0.0, Floor::Wood);
                }
                let torn = rough.fibres(Vec2::from_array(self.log_place(spot)) / SKIP_STRAND_MM).0;
                ((depth * share * (1.0 + SKIP_ROUGH * torn)).max(0.0), Floor::Wood)
            }
            OpeningForm::Chip { arris, side, half, depth, uneven } => {
                let uneven = (1.0 + CHIP_UNEVEN * uneven.fibres((spot - arris) / CHIP_CELL_MM).0).max(0.2);
                let q = (spot - arris) / Vec2::new(half.x * uneven, half.y);
                // Inwards from the arris along a chord of the outline; where the edge wanders outwards nothing is left
                // beside it.
                let (chord, inwards) = ((1.0 - q.y * q.y).max(0.0).sqrt(), (-side * q.x).max(0.0));
                (depth * chord * (1.0 - inwards / chord.max(1.0e-3)).max(0.0), Floor::Wood)
            }
        }
    }

    /// Distance of a spot from the axis of a knot in half widths of its outline [1], the direction on the outline
    /// (around, along), and the knot there.
    #[inline]
    fn in_knot(&self, knot: &Knot, spot: Vec2, trunk: &Trunk) -> (f32, Vec2, KnotSection) {
        let place = trunk.place(spot.x, spot.y, self.face.height);
        let section = knot.section(&KnotDistance::new(place.r));
        let offset = Vec2::new(place.r * wrap(place.phi - section.phi), place.l - section.l);
        let offset = Vec2::new(offset.x, offset.y * knot.cos_slope);
        (knot.reach(offset, section.half_width).0, offset.normalize_or(Vec2::X), section)
    }

    /// Lowers the face at a spot.
    #[inline]
    pub fn lower(&self, near: &[&Opening], spot: Vec2, trunk: &Trunk, face: Surface) -> Surface {
        let Some(opened) = self.at(near, spot, trunk) else { return face };
        let depth =
            |dx: f32, dy: f32| self.at(near, spot + Vec2::new(dx, dy), trunk).map_or(0.0, |opened| opened.depth);
        let h = DIFFERENCE_MM;
        let slope_x = (depth(h, 0.0) - depth(-h, 0.0)) / (2.0 * h);
        let slope_y = (depth(0.0, h) - depth(0.0, -h)) / (2.0 * h);
        Surface { z: face.z - opened.depth, slope_x: face.slope_x - slope_x, slope_y: face.slope_y - slope_y }
    }
}

/// How far the face of a loose knot lies below the board's [mm]: `x` half widths from its axis, where the cosine of the
/// angle from the direction of its lowest place is `towards`; it has sunk by `sunk` [mm].
#[inline]
fn loose_face(sunk: f32, half_width: f32, x: f32, towards: f32) -> f32 {
    let wall = (sunk / STEEPEST / half_width).min(0.7);
    sunk * (1.0 + LOOSE_TILT * x * towards) * (1.0 - smoothstep(1.0 - wall, 1.0, x))
}

/// The deepest place of such a face [mm].
fn deepest_of_face(sunk: f32, half_width: f32) -> f32 {
    const PLACES: u16 = 100;
    (0..=PLACES).map(|i| loose_face(sunk, half_width, f32::from(i) / f32::from(PLACES), 1.0)).fold(0.0, f32::max)
}
