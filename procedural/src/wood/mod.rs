//! Solid wood: a board sawn from a log with annual rings, knots and the defects that graders look for.
//!
//! `Wood --grow--> Plank --slice--> PlankSlice --> Surface, Matter`, or `Stem --saw--> Plank`, or `GivenWood --lay-->
//! Plank`.
//!
//! Models: the log as a field of growth times around a wandering pith (`pith`, `rings`, `growth`), branches in it
//! (`knot`, `knot_placement`, `bulge`, `grain_flow`), or the branches of a whole stem (`stem`), and zones of the
//! stem (`zones`). Then come decay (`decay`), resin and bark inside it (`inclusions`), the saw (`sawn_surface`), tools
//! (`tool_marks`, `saw_teeth`), torn grain and loss by decay (`face_grain`), canals, vessels and rays (`anatomy`),
//! cracks, holes and wane (`openings`), dirt and burns (`coats`), wet places (`moisture`), and what all of that means
//! for light (`coefficients`). What is inside was sawn flat and then warped with the board. Sources stand in each file;
//! docs/theory/wood.md says what is not modelled.
//!
//! A new defect has a file with its numbers, which are a group of [`Wood`]. What lowers the face makes
//! `openings` and stands in `OPENINGS`; what changes the wood of a stem is as `zones` or `inclusions`, what lies on
//! the face as `coats`. It has a row in the test `wood_defects`, and may have a class of samples in
//! recipes/wood-grading.yaml.

mod anatomy;
mod around_knot;
mod board_face;
mod bulge;
mod chips;
mod coats;
mod coefficients;
mod cracks;
mod decay;
mod decay_texture;
mod face_grain;
mod given;
mod grain_flow;
mod growth;
mod inclusions;
mod insect_holes;
mod knot;
mod knot_inside;
mod knot_names;
mod knot_placement;
mod machine_dents;
mod moisture;
mod open_knots;
mod opening_floor;
mod openings;
mod outline_wane;
mod parameters;
mod pith;
mod rings;
mod saw_teeth;
mod sawn_surface;
pub mod stem;
#[cfg(test)]
mod tests;
mod tool_marks;
mod wane;
mod zones;

use std::sync::Arc;

use base::{BLOCK, BodyKind, Class, Gloss, Instance, Matter, Medium, Mesh, Relief, Slice, Stream, Surface};
use glam::{Vec2, Vec3};

use self::anatomy::Anatomy;
pub use self::anatomy::widest_tube_um;
pub use self::around_knot::{KnotSurrounding, KnotSurroundings};
use self::board_face::BoardFace;
use self::coats::Coats;
use self::coefficients::{Coefficients, WoodKinds};
use self::decay::Decay;
pub use self::decay::LEAST_SIGMA_I;
use self::face_grain::FaceGrains;
pub use self::given::{GivenMatter, GivenWood};
use self::growth::{Branch, Grown, Growth};
use self::inclusions::{Filling, Inclusions};
use self::knot_placement::PlacedKnot;
use self::moisture::WetPlaces;
use self::opening_floor::{FLOOR_MM, Floor, GALLERY_COAT};
use self::openings::{OpenedBoard, Opening, Openings};
use self::outline_wane::OutlineWane;
pub use self::parameters::{Board, EDGE_MOST, Log, Media, SlicesParameters, StemParameters};
use self::pith::{LogPoint, Trunk};
use self::rings::Rings;
use self::saw_teeth::TornLight;
use self::sawn_surface::{SawnProfile, SawnSurface};
pub use self::stem::{LogRoom, Stem, StemBranch, StemError, least_pieces, sawn_at};
use self::stem::{Sawing, StemCut};
use self::zones::Zones;
use crate::noise::Noise;

/// Rings are grown this far beyond the layer of the farthest corner [mm]: layers wave, and dents behind dead branches
/// reach outwards.
const RING_MARGIN_MM: f32 = 10.0;
/// One over the cells of fine bundles and of coarse ones: around and outwards, along [mm^-1]; a fine one is three or
/// four tracheids, a fibre's length.
const BUNDLES_PER_MM: [[f32; 2]; 2] = [[1.0 / 0.12, 1.0 / 3.5], [1.0 / 0.6, 1.0 / 18.0]];
/// Their shares of the root mean square; squares sum to 1 [1].
const STREAK_SHARES: [f32; 2] = [0.8, 0.6];
/// Scattering varies against absorption by this part of it [1]: a dense bundle absorbs more and guides light less.
const STREAK_SCATTERING: f32 = -0.5;
/// Smallest factor that a streak may put on a coefficient [1].
const STREAK_LEAST: f32 = 0.1;
/// How much latewood raises the absorption within a knot [1].
const KNOT_RINGS: f32 = 0.6;
/// Step of the differences that give the slopes of vessels' grooves [mm].
const GROOVE_STEP_MM: f32 = 0.008;

base::parameter_groups! {
    /// Everything that makes a board.
    Wood {
        /// The sawn board.
        board: Board;
        /// The log.
        log: Log;
        /// Its knots.
        knots: parameters::Knots;
        /// Its decay.
        rot: parameters::Rot;
        /// Its media.
        media: Media;
        /// Its compression wood.
        compression: parameters::Compression;
        /// Its blue stain.
        stain: parameters::Stain;
        /// Its resin and enclosed bark.
        inclusions: parameters::Inclusions;
        /// Its cracks.
        cracks: cracks::Cracks;
        /// Its insect holes.
        holes: insect_holes::Holes;
        /// Its wane.
        wane: wane::Wane;
        /// Marks on its face.
        marks: parameters::Marks;
        /// The whole stem, for a board that is sawn from one.
        stem: StemParameters;
        /// How its face was made.
        machining: parameters::Machining;
        /// Its torn grain.
        grain: parameters::Grain;
        /// Its canals, vessels and rays.
        anatomy: parameters::Anatomy;
        /// Where in a picture it lies, for a board from one.
        picture: parameters::PictureParameters;
        /// Where in a stack of slices it lies, for a board from one.
        slices: SlicesParameters;
        /// Its wet places.
        moisture: parameters::Moisture;
    }
}

/// What makes openings in the face, in the order of their instances.
const OPENINGS: &[fn(&mut Openings, &mut OpenedBoard)] = &[
    open_knots::holes,
    open_knots::loose,
    cracks::grow,
    insect_holes::grow,
    wane::grow,
    machine_dents::roll,
    machine_dents::skip,
    chips::grow,
];

/// A sawn board.
#[derive(Debug, Clone)]
pub struct Plank {
    trunk: Trunk,
    rings: Rings,
    growth: Growth,
    knots: Vec<PlacedKnot>,
    zones: Option<Zones>,
    decay: Option<Decay>,
    inclusions: Inclusions,
    openings: Openings,
    coats: Coats,
    wet: WetPlaces,
    sawn: SawnSurface,
    /// Grain and anatomy at the face, where something asks for them.
    grain: Option<Box<(FaceGrains, Anatomy)>>,
    kinds: WoodKinds,
    streaks: [Noise; 2],
    streak: f32,
    latewood_share: f32,
    /// Dispersion of the fibres far from knots and in them [deg].
    dispersion_deg: [f32; 2],
    gloss: f32,
    instances: Vec<Instance>,
    /// Outline of the stem that it was sawn from.
    cut: Option<Box<StemCut>>,
    /// Wood that something else knows, in the place of the log's.
    given: Option<Arc<dyn GivenWood>>,
}

/// Where a board draws from.
#[derive(Debug, Clone, Copy)]
pub struct BoardStreams {
    /// What is its own.
    pub board: Stream,
    /// What it has in common with the other boards of its log.
    pub log: Stream,
}

impl BoardStreams {
    /// Of a board that is the only one of its log.
    pub fn alone(stream: Stream) -> Self {
        Self { board: stream, log: stream }
    }
}

/// A board cut at one scan position.
#[derive(Debug, Clone)]
pub struct PlankSlice<'a> {
    plank: &'a Plank,
    y: f32,
    middle: f32,
    cut: SawnProfile<'a>,
    /// Knots that disturb this cut.
    near: Vec<&'a PlacedKnot>,
    /// Openings that it crosses.
    open: Vec<&'a Opening>,
}

/// Wood at a point before openings and coats.
struct PointWood {
    coefficients: Coefficients,
    /// Unit vector along the fibre [1].
    fibre: Vec3,
    dispersion_deg: f32,
    gloss: f32,
    /// Share of the light that passes what lies on it [1].
    coat: f32,
    class: Class,
    instance: u16,
}

impl Plank {
    /// Grows the log and saws the board; every part draws from its own child of `stream`.
    pub fn grow(stream: Stream, wood: &Wood) -> Self {
        let trunk = Trunk::grow(stream.child("pith"), wood);
        let growth = Growth::new(stream.child("growth"), wood);
        let sawn = SawnSurface::grow(stream.child("saw"), wood);
        let knots = knot_placement::place(stream.child("knot"), wood, &trunk);
        Self::assemble(BoardStreams::alone(stream), wood, trunk, growth, sawn, knots, None)
    }

    /// A board of wood that is given: its shape, openings and coats are drawn as for any board, with strands and cracks
    /// along the direction of most of its fibres and a pith as far from the face as `wood.log` says, on the side that
    /// is given. Of `wood`, what stands inside the wood (rings, knots, rot, zones, inclusions) has to be off.
    pub fn lay(stream: Stream, wood: &Wood, given: Arc<dyn GivenWood>) -> Self {
        let mut wood = *wood;
        // What is given shows the marks of its own saw.
        wood.machining.teeth_um = 0.0;
        wood.log.grain_angle_deg = f64::from(given.azimuth_deg());
        if given.pith_is_above() {
            wood.log.pith_depth_mm = -wood.log.pith_depth_mm;
        }
        let trunk = Trunk::grow(stream.child("pith"), &wood);
        let growth = Growth::new(stream.child("growth"), &wood);
        let sawn = SawnSurface::grow(stream.child("saw"), &wood);
        Self::assemble(BoardStreams::alone(stream), &wood, trunk, growth, sawn, Vec::new(), Some(given))
    }

    /// Saws the board that `wood.stem` asks for out of a stem, whose pith, outline and branches it takes; rings,
    /// waviness, bundles, rot and the saw draw from children of `stream`. The knots' counts, widths, slopes and deaths
    /// in `wood.knots` and the pith's depth, offset and wander in `wood.log` do not count.
    pub fn saw(stream: Stream, wood: &Wood, stem: &Stem) -> Self {
        Self::saw_of_log(BoardStreams::alone(stream), wood, stem)
    }

    /// The same for one of several boards of a log: rings and outlines of branches draw from children of the log's
    /// stream.
    pub fn saw_of_log(streams: BoardStreams, wood: &Wood, stem: &Stem) -> Self {
        let stream = streams.board;
        let sawing = Sawing::new(wood, stem);
        let growth = Growth::new(stream.child("growth"), wood).with_layers(sawing.trunk.layers());
        let sawn = SawnSurface::grow(stream.child("saw"), wood);
        let knots = sawing.knots(streams.log.child("knot"), wood, stem, &growth, sawn.relief());
        let cut = Box::new(sawing.cut(wood, stem));
        let mut plank = Self::assemble(streams, wood, sawing.trunk, growth, sawn, knots, None);
        if wood.stem.outline_wane >= 0.5 {
            let wane = OutlineWane::new(stream.child("outline wane"), wood, &cut);
            let Self { openings, trunk, sawn, instances, .. } = &mut plank;
            wane.open(openings, trunk, |y| sawn.edges(y), instances);
        }
        plank.cut = Some(cut);
        plank
    }

    fn assemble(
        streams: BoardStreams,
        wood: &Wood,
        trunk: Trunk,
        growth: Growth,
        sawn: SawnSurface,
        knots: Vec<PlacedKnot>,
        given: Option<Arc<dyn GivenWood>>,
    ) -> Self {
        let stream = streams.board;
        let board = &wood.board;
        let face = BoardFace::of(wood);
        let widest = face.half + Vec2::new(face.edge_room, 0.0);
        let reach = trunk.youngest(trunk.reach(widest, face.height)) + RING_MARGIN_MM;
        let kinds = WoodKinds::new(&wood.media);
        let rings = Rings::grow(streams.log.child("rings"), &wood.log, reach);
        let mut instances: Vec<Instance> = knots.iter().filter_map(|placed| placed.instance).collect();
        if let Some(given) = &given {
            let corner = [board.offset_mm - 0.5 * board.width_mm, board.lead_in_mm];
            let placed =
                |known: Instance| Instance { x_mm: known.x_mm + corner[0], y_mm: known.y_mm + corner[1], ..known };
            instances.extend(given.instances().into_iter().map(placed));
        }
        knot_names::name(&mut instances, board, &knots);
        let decay = Decay::grow(stream.child("rot"), wood, &trunk, kinds.rot, &mut instances);
        let loss = wood.rot.loss_mm as f32;
        let sunk = |x: f32, place: &LogPoint| decay.as_ref().map_or(0.0, |decay| decay.sunk(x, place, loss));
        let grains = FaceGrains::grow(stream.child("grain"), wood, &trunk, &growth, &knots, sunk);
        let grain = grains.map(|grains| {
            let middle = trunk.place(face.middle.x, face.middle.y, face.height);
            Box::new((grains, Anatomy::grow(stream.child("anatomy"), wood, &middle)))
        });
        let zones = Zones::grow(stream.child("zones"), wood, &trunk, &mut instances);
        let inclusions = Inclusions::grow(stream.child("inclusions"), wood, &trunk, &rings, &mut instances);
        let mut opened = OpenedBoard {
            stream: stream.child("openings"),
            wood,
            trunk: &trunk,
            knots: &knots,
            instances: &mut instances,
        };
        let mut openings = Openings::new(wood);
        for open in OPENINGS {
            open(&mut openings, &mut opened);
        }
        let coats = Coats::grow(stream.child("coats"), wood, &mut instances);
        Self {
            rings,
            growth,
            sawn,
            grain,
            streaks: ["fine", "coarse"].map(|name| Noise::new(stream.child("streak").child(name))),
            streak: wood.log.streak as f32,
            latewood_share: wood.log.latewood_share as f32,
            dispersion_deg: [wood.media.fibre_dispersion_deg, wood.media.knot_fibre_dispersion_deg]
                .map(|deg| deg as f32),
            gloss: wood.media.gloss as f32,
            trunk,
            knots,
            zones: (!zones.is_empty()).then_some(zones),
            decay,
            inclusions,
            openings,
            coats,
            wet: WetPlaces::grow(stream.child("moisture"), wood),
            kinds,
            instances,
            cut: None,
            given,
        }
    }

    /// The cut at scan position `y` [mm].
    pub fn cut(&self, y: f32) -> PlankSlice<'_> {
        let near = self.knots.iter().filter(|placed| placed.y[0] <= y && y <= placed.y[1]).collect();
        let (low, high) = self.sawn.bounds();
        let open = self.openings.near(y);
        PlankSlice { plank: self, y, middle: 0.5 * (low.x + high.x), cut: self.sawn.cut(y), near, open }
    }

    /// Distance from the pith to the outline of the stem [mm] at an azimuth `phi` [rad] and a place `l` along the log
    /// [mm], both as in the log's coordinates; `None` for a board that was not sawn from a stem.
    pub fn outline_mm(&self, phi: f32, l: f32) -> Option<f32> {
        self.cut.as_ref().map(|cut| cut.radius(phi, l))
    }

    /// Relative departure of the fibre bundle at a place from the mean [1].
    #[inline]
    fn streak(&self, place: &LogPoint, grown: &Grown<'_>) -> f32 {
        let [fine, coarse] = BUNDLES_PER_MM.map(|cell| bundle(cell, place, grown));
        self.streak
            * (STREAK_SHARES[0] * self.streaks[0].bundles(fine) + STREAK_SHARES[1] * self.streaks[1].bundles(coarse))
    }

    /// The same at some places; any number where there is no place.
    #[inline]
    fn streaks(&self, places: &[Option<(LogPoint, Grown<'_>)>; BLOCK]) -> [f32; BLOCK] {
        let [fine, coarse] = [0, 1].map(|i| {
            let mut p = [[0.0; BLOCK]; 3];
            for (n, (place, grown)) in places.iter().enumerate().filter_map(|(n, place)| Some((n, place.as_ref()?))) {
                [p[0][n], p[1][n], p[2][n]] = bundle(BUNDLES_PER_MM[i], place, grown).to_array();
            }
            self.streaks[i].bundles_at(&p)
        });
        std::array::from_fn(|n| self.streak * (STREAK_SHARES[0] * fine[n] + STREAK_SHARES[1] * coarse[n]))
    }

    /// Dispersion of the fibres where knots disturb their order by `disturbed` [deg].
    #[inline]
    fn dispersion(&self, disturbed: f32) -> f32 {
        let [clear, knotted] = self.dispersion_deg;
        clear + disturbed * (knotted - clear)
    }

    /// Wood without defect.
    #[inline]
    fn clear(&self, grown: &Grown, streak: f32) -> Coefficients {
        let phase = self.rings.at(grown.t);
        let absorption = phase.gain * (1.0 + streak).max(STREAK_LEAST);
        let scattering = (1.0 + STREAK_SCATTERING * streak).max(STREAK_LEAST);
        self.kinds.earlywood.mix(self.kinds.latewood, phase.latewood).scaled(absorption, scattering)
    }

    /// Wood outside of branches, clear or decayed, with its class and instance.
    #[inline]
    fn stem(&self, x: f32, place: &LogPoint, grown: &Grown, streak: f32) -> (Coefficients, Class, u16) {
        let (mut wood, mut class, mut instance) = (self.clear(grown, streak), Class::Clear, 0);
        if let Some(zones) = &self.zones {
            let shares = zones.at(place, grown.t, &self.rings);
            wood = self.kinds.zoned(wood, &shares);
            (class, instance) = (shares.class, shares.instance);
        }
        if let Some(decayed) = self.decay.as_ref().and_then(|decay| decay.at(x, place).map(|at| (decay, at))) {
            let (decay, at) = decayed;
            wood = decay.change(wood, at);
            if at.class != Class::Clear {
                (class, instance) = (at.class, at.id);
            }
        }
        if let Some(included) = self.inclusions.at(place, grown.t) {
            let filling = match included.filling {
                Filling::Resin => self.kinds.resin,
                Filling::Bark => self.kinds.bark,
            };
            wood = if included.share < 1.0 { wood.mix(filling, included.share) } else { filling };
            if included.share >= 0.5 {
                (class, instance) = (included.class, included.id);
            }
        }
        (wood, class, instance)
    }

    /// Wood of a branch, with its own rings or its bark.
    #[inline]
    fn branch(&self, branch: &Branch, r: f32) -> Coefficients {
        let knot = branch.knot;
        let bark = branch.bark();
        // Wood of a branch without bark fades into what is around it, and is wood until there.
        if bark > 0.0 && branch.x > 1.0 - bark {
            return self.kinds.bark;
        }
        let kind = if branch.dead { self.kinds.dead_knot } else { self.kinds.sound_knot };
        // Time runs from the branch's pith to the outline as it does from the log's pith to here.
        let circle = knot.inside.circle(branch.offset, branch.x);
        let latewood = self.rings.at(r * circle).latewood;
        let rings = 1.0 + KNOT_RINGS * (latewood - self.latewood_share);
        kind.scaled(rings * knot.inside.absorption(branch.offset, branch.x, circle, branch.below, r), 1.0)
    }
}

impl BodyKind for Plank {
    fn slice(&self, y: f32) -> Box<dyn Slice + '_> {
        Box::new(self.cut(y))
    }

    /// Warped and rippled like the board but smooth.
    fn hull(&self) -> Mesh {
        self.sawn.hull()
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        let (low, high) = self.sawn.bounds();
        let relief = self.grain.as_ref().map_or(0.0, |grain| grain.0.relief());
        (low, high + relief * Vec3::Z)
    }

    /// Its knots, sound ones first where they were placed and along the board where it was sawn from a stem, then its
    /// rot, zones, inclusions, openings and coats.
    fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// Whether its upper face has openings or sunk decay.
    fn relief(&self) -> Relief {
        let is_open = !self.openings.is_empty() || self.grain.as_ref().is_some_and(|grain| grain.0.is_sunk());
        if is_open { Relief::Openings } else { Relief::Smooth }
    }
}

/// Where a place lies among bundles of these cells [cell].
#[inline]
fn bundle(per_mm: [f32; 2], place: &LogPoint, grown: &Grown<'_>) -> Vec3 {
    Vec3::new(grown.bundle * per_mm[0], grown.t * per_mm[0], place.l * per_mm[1])
}

impl Slice for PlankSlice<'_> {
    #[inline]
    fn surface(&self, x: f32) -> Option<Surface> {
        Some(self.opened(x, self.cut.surface(x)?))
    }

    /// Beyond the board's sides the log goes on.
    fn matter(&self, x: f32, z: f32) -> Matter {
        let wood = match &self.plank.given {
            Some(given) => self.given(given.as_ref(), x, z),
            None => {
                let (place, grown) = self.place(Vec2::new(x, z));
                self.grown(x, &place, &grown, self.plank.streak(&place, &grown))
            }
        };
        let torn = self.cut.torn(&[x; BLOCK]).map(|torn| torn[0]);
        self.on_face(x, wood, torn)
    }

    fn surfaces(&self, x: &[f32; BLOCK]) -> [Option<Surface>; BLOCK] {
        let mut faces = self.cut.surfaces(x);
        if self.plank.grain.is_some() || !self.open.is_empty() {
            for (face, &x) in faces.iter_mut().zip(x) {
                *face = face.map(|sawn| self.opened(x, sawn));
            }
        }
        faces
    }

    fn matters(&self, places: &[Option<Vec2>; BLOCK], put: &mut dyn FnMut(usize, Matter)) {
        if let Some(given) = &self.plank.given {
            for (n, place) in places.iter().enumerate().filter_map(|(n, place)| Some((n, (*place)?))) {
                put(n, self.on_face(place.x, self.given(given.as_ref(), place.x, place.y), None));
            }
            return;
        }
        let mut grown: [Option<(LogPoint, Grown<'_>)>; BLOCK] = [const { None }; BLOCK];
        for (grown, place) in grown.iter_mut().zip(places) {
            if let Some(place) = place {
                *grown = Some(self.place(*place));
            }
        }
        let streaks = self.plank.streaks(&grown);
        let torn = self.cut.torn(&places.map(|place| place.map_or(0.0, |place| place.x)));
        for (n, grown) in grown.iter().enumerate() {
            if let (Some(place), Some((log, grown))) = (places[n], grown) {
                let wood = self.grown(place.x, log, grown, streaks[n]);
                put(n, self.on_face(place.x, wood, torn.map(|torn| torn[n])));
            }
        }
    }
}

impl PlankSlice<'_> {
    /// What grain and openings make of the sawn surface above `x`.
    #[inline]
    fn opened(&self, x: f32, sawn: Surface) -> Surface {
        let (plank, spot, mut face) = (self.plank, Vec2::new(x, self.y), sawn);
        if let Some(grain) = &plank.grain {
            face = self.carved(grain, face, spot);
        }
        if !self.open.is_empty() {
            face = plank.openings.lower(&self.open, spot, &plank.trunk, face);
        }
        if face.z >= FLOOR_MM || face.z >= sawn.z {
            return face;
        }
        // Whatever takes wood away leaves a sheet of it above the conveyor, or what a board that warps below it has
        // there.
        let left = Surface { z: FLOOR_MM, slope_x: 0.0, slope_y: 0.0 };
        if sawn.z < FLOOR_MM { sawn } else { left }
    }

    /// The face with torn grain, grooves of vessels and what decay took.
    #[inline]
    fn carved(&self, (grains, anatomy): &(FaceGrains, Anatomy), face: Surface, spot: Vec2) -> Surface {
        let mut face = grains.change(face, spot);
        if anatomy.is_open() {
            let depth = |spot: Vec2| {
                let here = grains.at(spot).0;
                anatomy.groove(FaceGrains::cell(&here), self.plank.rings.at(here.t).latewood)
            };
            let deep = depth(spot);
            face.z -= deep;
            let by = |step: Vec2| (depth(spot + step) - deep) / GROOVE_STEP_MM;
            face.slope_x -= by(GROOVE_STEP_MM * Vec2::X);
            face.slope_y -= by(GROOVE_STEP_MM * Vec2::Y);
        }
        face
    }

    /// How far below the outline of its stem (x, z) of the cut lies along the radius, negative outside of the stem
    /// [mm]; `None` for a board that was not sawn from a stem.
    pub fn below_outline_mm(&self, x: f32, z: f32) -> Option<f32> {
        let plank = self.plank;
        let cut = plank.cut.as_ref()?;
        let place = plank.trunk.place(x, self.y, z - self.cut.warp(x - self.middle).z);
        Some(cut.radius(place.phi, place.l) - place.r)
    }

    /// Where (x, z) of the cut was in the log, and how wood grew there.
    #[inline]
    fn place(&self, Vec2 { x, y: z }: Vec2) -> (LogPoint, Grown<'_>) {
        let plank = self.plank;
        let place = plank.trunk.place(x, self.y, z - self.cut.warp(x - self.middle).z);
        let near = self.near.iter().filter(|placed| placed.x[0] <= x && x <= placed.x[1]).map(|placed| &placed.knot);
        (place, plank.growth.at(&place, near))
    }

    /// Wood that is given.
    fn given(&self, given: &dyn GivenWood, x: f32, z: f32) -> PointWood {
        let plank = self.plank;
        let low = plank.sawn.corner();
        let depth = plank.sawn.thickness() + self.cut.warp(x - self.middle).z - z;
        let GivenMatter { mu_a, sigma_i, k, n_eff, fibre, disturbed, class, instance } =
            given.at(Vec2::new(x - low.x, self.y - low.y), depth.max(0.0));
        let coefficients = Coefficients { mu_a, sigma_i, k, n_eff };
        let dispersion_deg = plank.dispersion(disturbed);
        PointWood { coefficients, fibre, dispersion_deg, gloss: plank.gloss, coat: 1.0, class, instance }
    }

    /// Wood of the log at `x`.
    #[inline]
    fn grown(&self, x: f32, place: &LogPoint, grown: &Grown<'_>, streak: f32) -> PointWood {
        let plank = self.plank;
        let (mut coefficients, mut class, mut instance) = match &grown.branch {
            // The surroundings of a branch are only asked for where some of them are there.
            Some(branch) if branch.share() == 1.0 => (plank.branch(branch, place.r), Class::Clear, 0),
            near => {
                let (wood, class, instance) = plank.stem(x, place, grown, streak);
                let stain = near.as_ref().map_or(1.0, |branch| branch.knot.inside.stain(branch.offset, branch.x));
                (wood.scaled(stain, 1.0), class, instance)
            }
        };
        if let Some(branch) = &grown.branch {
            let share = branch.share();
            if 0.0 < share && share < 1.0 {
                coefficients = coefficients.mix(plank.branch(branch, place.r), share);
            }
            if branch.x < 1.0 {
                (class, instance) = (branch.knot.class, branch.knot.id);
            }
        }
        let mut dispersion_deg = plank.dispersion(grown.disturbed);
        let mut fibre = plank.trunk.vector(grown.fibre.truncate(), grown.fibre.z);
        let (mut gloss, mut coat) = (plank.gloss, 1.0);
        if let Some(grain) = &plank.grain {
            let (grains, anatomy) = &**grain;
            let here = grains.at(Vec2::new(x, self.y)).0;
            (dispersion_deg, gloss) = grains.disorder(&here, dispersion_deg, gloss);
            // Branches have none of the stem's tissues.
            if grown.branch.as_ref().is_none_or(|branch| branch.x >= 1.0) {
                let found = anatomy.at(&here, place, plank.rings.at(here.t).latewood);
                coat = found.through;
                if let Some(ray) = found.ray {
                    coefficients = coefficients.scaled(ray.mu_a, 1.0);
                    if ray.is_broad {
                        fibre = plank.trunk.vector(place.outward, 0.0);
                        dispersion_deg = anatomy::RAY_DISPERSION_DEG;
                    }
                }
                if found.resin > 0.0 {
                    coefficients = coefficients.mix(plank.kinds.resin, found.resin);
                }
            }
        }
        PointWood { coefficients, fibre, dispersion_deg, gloss, coat, class, instance }
    }

    /// What openings, coats and torn fibre make of wood at the face.
    #[inline]
    fn on_face(&self, x: f32, wood: PointWood, torn: Option<TornLight>) -> Matter {
        let plank = self.plank;
        let PointWood { mut coefficients, fibre, dispersion_deg, gloss, mut coat, mut class, mut instance } = wood;
        let spot = Vec2::new(x, self.y);
        let mut gloss = Gloss::wood(gloss);
        if let Some(torn) = torn {
            coat *= torn.coat;
            (gloss.share, gloss.matte) = (gloss.share * torn.gloss, torn.matte);
        }
        if let Some(filled) = plank.wet.at(spot) {
            coefficients = moisture::wetted(coefficients, filled);
        }
        gloss = plank.wet.film(gloss);
        if let Some(coated) = plank.coats.at(spot) {
            coat *= coated.through;
            if let Some(label) = coated.label {
                (class, instance) = label;
            }
        }
        if !self.open.is_empty()
            && let Some(opened) = plank.openings.at(&self.open, spot, &plank.trunk)
        {
            match opened.floor {
                Floor::Wood => {}
                Floor::Gallery => coat *= GALLERY_COAT,
                Floor::Bark => coefficients = plank.kinds.bark,
                Floor::Frass => coefficients = plank.kinds.frass,
            }
            if opened.is_labelled {
                (class, instance) = (opened.class, opened.id);
            }
        }
        let Coefficients { mu_a, sigma_i, k, n_eff } = coefficients;
        Matter {
            medium: Medium { mu_a, sigma_i, k, n_eff, fibre, dispersion_deg, gloss, coat },
            film: None,
            class,
            instance,
        }
    }
}
