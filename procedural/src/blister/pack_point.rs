//! What stands at a place of a finished pack: film, what lies below it, and the truth about both.

use base::{Class, Film, Gloss, Matter, Medium, Surface};
use glam::{Vec2, Vec3};

use super::film_mark::{FilmMark, MarkKind};
use super::solid::{CutPlane, Solid};
use super::web::WebFilm;
use super::{CardFilm, Pack};

/// Air that is left where film rests on something [mm].
const TOUCH_MM: f32 = 0.002;
/// Steepest upright part of a normal that a slope is made of [1].
const UPRIGHT: f32 = 0.02;
/// Share of the flange's thickness that film over a tablet on the flange keeps [1].
const DRAPED: f32 = 0.7;
/// Powder lower than this does not count [mm].
const POWDER_MM: f32 = 0.005;

/// A tablet that has lost something.
#[derive(Debug, Clone)]
pub struct TabletDamage {
    /// The tablet before.
    pub whole: Solid,
    /// A place of its upper side beyond all of these is lost.
    pub lost: Vec<CutPlane>,
    /// Class and instance of those places.
    pub label: (Class, u16),
}

/// A place of the card and the film over it.
#[derive(Debug, Clone, Copy)]
pub struct PackPoint {
    /// Position on the card [mm].
    pub p: Vec2,
    /// Position on the conveyor [mm].
    pub at: Vec2,
    /// Nearest pocket.
    pub cell: Option<usize>,
    /// The film.
    pub leaf: WebFilm,
    /// Whether foil and film have come apart although this is flange.
    lifted: bool,
    /// How far a tablet on the flange holds film and foil apart [1].
    tent: f32,
    hole: Option<(Class, u16)>,
    pinhole: Option<(Class, u16)>,
    mark: Option<(Class, u16)>,
}

/// What light meets below the film.
struct UnderFilm {
    surface: Surface,
    medium: Medium,
    label: Option<(Class, u16)>,
}

impl PackPoint {
    fn sealed(&self) -> bool {
        self.leaf.inset <= 0.0 && !self.lifted
    }
}

impl Pack {
    pub(super) fn spot(&self, x: f32, y: f32) -> Option<PackPoint> {
        let p = self.lay.card(x, y);
        if !self.lay.holds(p) {
            return None;
        }
        let cell = self.web.nearest(p);
        let leaf = self.web.leaf(p, cell);
        let at = Vec2::new(x, y);
        let mut spot = PackPoint { p, at, cell, leaf, lifted: false, tent: 0.0, hole: None, pinhole: None, mark: None };
        let marks: &[FilmMark] = cell.map_or(&[], |cell| &self.marks[cell]);
        if !marks.is_empty() {
            self.mark(&mut spot, marks);
        }
        Some(spot)
    }

    fn mark(&self, spot: &mut PackPoint, marks: &[FilmMark]) {
        let (mut dent, mut raised) = ((0.0, Vec2::ZERO), (0.0, Vec2::ZERO));
        let (_, tilt) = self.lay.warp(spot.p);
        for mark in marks {
            let Some((share, gradient)) = mark.at(spot.p) else { continue };
            let label = (mark.class, mark.instance);
            let (height, slope) = (mark.height * share, mark.height * gradient);
            match mark.kind {
                MarkKind::Raised => {
                    if height > raised.0 {
                        raised = (height, slope);
                    }
                    spot.lifted = true;
                    if spot.leaf.inset <= 0.0 {
                        spot.mark = Some(label);
                    }
                }
                MarkKind::Dent => {
                    dent = (height, slope);
                    spot.mark = Some(label);
                }
                MarkKind::Hole => spot.hole = Some(label),
                MarkKind::Pinhole => spot.pinhole = Some(label),
                MarkKind::Tent => {
                    spot.tent = spot.tent.max(share);
                    spot.lifted = true;
                    // Film hangs from whichever of tablet and pocket holds its lower side higher.
                    let (pocket, mut tent) = (spot.leaf, spot.leaf);
                    tent.top = self.web.foil_mm + self.web.flat_mm + height;
                    tent.slope = slope;
                    tent.thickness *= 1.0 - (1.0 - DRAPED) * share;
                    let (mut upper, other) = if tent.top > pocket.top { (tent, pocket) } else { (pocket, tent) };
                    upper.keep_above(other.low(tilt), tilt);
                    spot.leaf = upper;
                    // Beside pockets it is not sealed, wherever its shape is the higher one.
                    if tent.top > pocket.top || pocket.inset <= 0.0 {
                        spot.mark = Some(label);
                    }
                }
            }
        }
        let low = spot.leaf.low(tilt);
        spot.leaf.top += raised.0;
        spot.leaf.slope += raised.1;
        spot.leaf.keep_above(low, tilt);
        if dent.0 > 0.0 && spot.leaf.inset > 0.0 {
            self.press(spot, dent);
        }
    }

    /// Presses the film in, down to what lies below.
    fn press(&self, spot: &mut PackPoint, (depth, slope): (f32, Vec2)) {
        let free = spot.leaf;
        spot.leaf.top -= depth;
        spot.leaf.slope -= slope;
        let (warp, lean) = self.lay.warp(spot.p);
        let solid = self.highest(spot.cell, spot.at.x, spot.at.y);
        let floor = solid.map_or(self.web.foil_mm, |(_, top)| top - warp) + TOUCH_MM;
        if spot.leaf.low(lean) >= floor || free.low(lean) <= floor {
            if free.low(lean) <= floor {
                spot.leaf = free;
            }
            return;
        }
        let tilt = solid.map_or(Vec2::ZERO, |(number, top)| {
            let normal = self.solids[number].normal(spot.at.extend(top));
            let slope = -normal.truncate() / normal.z.max(UPRIGHT);
            self.lay.across(slope) - lean
        });
        spot.leaf.slope = tilt;
        spot.leaf.top = floor + spot.leaf.thickness * (1.0 + (tilt + lean).length_squared()).sqrt();
    }

    /// The film at a spot; `None` in a hole.
    pub(super) fn film(&self, spot: &PackPoint) -> Option<CardFilm> {
        spot.hole.is_none().then(|| CardFilm {
            surface: self.world(spot.p, spot.leaf.top, spot.leaf.slope),
            thickness_mm: spot.leaf.thickness,
            sealed: spot.sealed(),
            medium: self.web.medium(spot.leaf.drawn),
        })
    }

    /// A height over the flat card, and its slope there, on the conveyor.
    fn world(&self, p: Vec2, height: f32, slope: Vec2) -> Surface {
        let (rise, tilt) = self.lay.warp(p);
        let slope = self.lay.along(slope + tilt);
        Surface { z: height + rise, slope_x: slope.x, slope_y: slope.y }
    }

    /// Lower side of the film at a spot, on the conveyor [mm].
    pub(super) fn ceiling(&self, spot: &PackPoint) -> f32 {
        let (rise, tilt) = self.lay.warp(spot.p);
        spot.leaf.low(tilt) + rise
    }

    /// The foil, or powder on it.
    pub(super) fn ground(&self, spot: &PackPoint) -> (Surface, Medium, Option<(Class, u16)>) {
        let (height, slope) = self.web.relief(spot.p, spot.leaf.inset);
        let keep = 1.0 - spot.tent;
        let surface = self.world(spot.p, self.web.foil_mm + keep * height, keep * slope);
        if spot.leaf.inset > 0.0
            && let Some(cell) = spot.cell
            && let Some(powder) = &self.powders[cell]
        {
            let height = |at: Vec2| {
                let p = self.lay.card(at.x, at.y);
                let (rise, tilt) = self.lay.warp(p);
                let free = self.web.leaf(p, Some(cell)).low(tilt) - self.web.foil_mm - TOUCH_MM;
                let foil = self.web.foil_mm + rise;
                let room = self.contents[cell].iter().filter_map(|&n| self.solids[n].column(at.x, at.y));
                let room = room.fold(free, |room, [low, _]| room.min(low - foil - 0.0005));
                powder.height(p).min(room).max(0.0)
            };
            const H: f32 = 0.02;
            let here = height(spot.at);
            if here > POWDER_MM {
                let slope = |step: Vec2| (height(spot.at + step) - height(spot.at - step)) / (2.0 * H);
                let (slope_x, slope_y) = (slope(H * Vec2::X), slope(H * Vec2::Y));
                let surface = Surface {
                    z: surface.z + here,
                    slope_x: surface.slope_x + slope_x,
                    slope_y: surface.slope_y + slope_y,
                };
                return (surface, powder.medium, Some(powder.label));
            }
        }
        match spot.pinhole {
            Some(label) => (surface, Medium::opaque(Gloss::NONE), Some(label)),
            None => (surface, self.foil, None),
        }
    }

    /// The highest solid over a place: its number and its upper side.
    pub(super) fn highest(&self, cell: Option<usize>, x: f32, y: f32) -> Option<(usize, f32)> {
        let mut best = None;
        for &number in cell.map_or(&[][..], |cell| &self.contents[cell]) {
            let top = self.solids[number].column(x, y).map(|[_, top]| top);
            if let Some(top) = top.filter(|&top| best.is_none_or(|(_, other)| top > other)) {
                best = Some((number, top));
            }
        }
        best
    }

    fn below(&self, spot: &PackPoint) -> UnderFilm {
        let Vec2 { x, y } = spot.at;
        let solid = if spot.sealed() { None } else { self.highest(spot.cell, x, y) };
        let Some((number, top)) = solid else {
            let (surface, medium, label) = self.ground(spot);
            return UnderFilm { surface, medium, label };
        };
        let solid = &self.solids[number];
        let at = Vec3::new(x, y, top);
        let normal = solid.normal(at);
        let slope = -normal.truncate() / normal.z.max(UPRIGHT);
        let mut surface = Surface { z: top, slope_x: slope.x, slope_y: slope.y };
        if solid.marked {
            let (depth, slope) = self.face.depth(solid, at);
            surface.z -= depth;
            surface.slope_x -= slope.x;
            surface.slope_y -= slope.y;
        }
        UnderFilm {
            surface,
            medium: solid.medium,
            label: (solid.instance != 0).then_some((solid.class, solid.instance)),
        }
    }

    /// Whether the tablet of a pocket has lost what was visible at a spot.
    fn wound(&self, spot: &PackPoint) -> Option<(Class, u16)> {
        let wound = self.wounds[spot.cell?].as_ref()?;
        let [_, top] = wound.whole.column(spot.at.x, spot.at.y)?;
        let own = wound.whole.own(spot.at.extend(top));
        wound.lost.iter().all(|cut| cut.normal.dot(own) < cut.limit).then_some(wound.label)
    }

    /// What lies open in a hole of the film, else the film.
    pub(super) fn surface_at(&self, spot: &PackPoint) -> Surface {
        match spot.hole {
            Some(_) => self.below(spot).surface,
            None => self.world(spot.p, spot.leaf.top, spot.leaf.slope),
        }
    }

    pub(super) fn matter_at(&self, spot: &PackPoint) -> Matter {
        let below = self.below(spot);
        let inside = spot.leaf.inset > 0.0;
        let label = spot
            .hole
            .or(if inside { self.wound(spot) } else { None }.filter(|_| below.label.is_none()))
            .or(below.label)
            .or(spot.mark)
            .or_else(|| spot.cell.filter(|_| inside).map(|cell| (self.instances[cell].class, self.instances[cell].id)));
        let (class, instance) = label.unwrap_or((Class::Flange, 0));
        if spot.hole.is_some() {
            return Matter { medium: below.medium, film: None, class, instance };
        }
        let gap = (self.ceiling(spot) - below.surface.z).max(0.0);
        let film = Film {
            thickness_mm: spot.leaf.thickness,
            gap_mm: (!spot.sealed()).then_some(gap),
            room_mm: match spot.cell {
                Some(cell) if inside => self.web.ends(spot.p, cell, self.lay.across(Vec2::Y)),
                _ => [f32::INFINITY; 2],
            },
            under: below.medium,
            under_slope: [below.surface.slope_x, below.surface.slope_y],
        };
        Matter { medium: self.web.medium(spot.leaf.drawn), film: Some(film), class, instance }
    }
}
