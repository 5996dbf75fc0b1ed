//! Film over another surface: the light that leaves the film itself, and the transmitted line, which is light of the
//! surface below seen through the film.
//!
//! Light enters the film by Fresnel's law (Born and Wolf), spreads as [`FilmStackKernel`] says, and is seen at the
//! film. Light that is seen through the film lies where the laser meets the surface below: lower, so in other rows, and
//! by the camera's slant in other columns. There the line is drawn anew, linear between the points that neighbouring
//! columns meet; where the surface below jumps (the edge of a tablet) the line is broken, and what tablets hide from
//! the lens is dark. Both ways through the film are followed (`bent_film`): level film shows what lies below nearer to
//! the lens, by up to half of its thickness for views up to 45 degrees; bent film turns light, which meets what lies
//! below elsewhere, spread over more or less of it. Light that keeps its direction leaves through the film over where
//! it landed, light that has spread by that over where it has come to. What has crossed a pocket and spread far is told
//! by the pocket itself (`pocket_light`). Neglected: what the film above hides of what lies below; a second image of
//! the same light, where bent film folds the line over itself.

use std::ops::Range;

use base::{Film, Matter, Surface};
use glam::{Mat2, Vec2, Vec3};

use super::bent_film::{FilmPlace, FilmSheet, LEAST_FILM_COSINE, PlaneBelow};
use super::view::LineView;
use crate::optics::camera::{Camera, Sight};
use crate::optics::light::{FILLING, NARROW_WIDTHS, NEAR, NEAR_WIDTHS, TransmittedLine, blur_varying};
use crate::optics::speckle::TILE;
use crate::specimen::{Hit, height_below};
use transport::fresnel;
use transport::kernel::film_stack::{FilmStack, FilmStackKernel, FilmStackSpread, passed_unturned, under_normal};
use transport::kernel::{BASIS, PACK_SPREAD_MM};

/// Heights of neighbouring columns below a film that count as two surfaces [mm].
const JUMP_MM: f32 = 0.5;
/// Least slant of the view along the motion for which light off the laser plane is followed [1].
const LEAST_VIEW_SLANT: f32 = 0.05;
/// Greatest widening of the line that is believed: more is a caustic or an edge [1].
const MAX_WIDENING: f32 = 10.0;
/// Most light that bent film gathers on a place, over that of level film [1].
const MAX_GATHERED: f32 = 3.0;
/// Most that a thinner place of the film, or a glint, adds to what a column's own place promises [1].
const MAX_GAIN: f32 = 100.0;
/// Greatest radiance factor of a width that is believed [1].
const MAX_RADIANCE_FACTOR: f32 = 2.0;

/// What the laser meets below a film, by the column that looks at the film above it.
#[derive(Debug, Clone, Copy)]
struct TransmittedPoint {
    /// Sensor column where it is seen [px].
    column: f32,
    z: f32,
    /// Where along the line its light lands, and would without a film [mm].
    lands: [f32; 2],
    sight: Sight,
    /// Light towards the lens, by width; of wide widths by the root of their weight, and still to leave by `exit` [e-].
    light: [f32; BASIS],
    /// Factor by which each width leaves here; 0 where something hides this point from the lens [1].
    exit: [f32; BASIS],
    /// Where light that a pocket's tablet or foil shows here has come from: a place along the line, and how far along
    /// the motion from here [mm].
    comes_from: [f32; 2],
    /// What of that light by area is seen [1].
    shows: f32,
    /// Light of the line that film has thrown down before and that the near widths hold [e-].
    near: [f32; NEAR_WIDTHS],
    /// Share of light beyond a pocket's end that comes back [1].
    holds: f32,
    metal: bool,
    sealed: bool,
}

/// Light below a film, as the lens sees it.
#[derive(Debug, Clone, Copy)]
struct Meeting {
    /// Where it is seen: in the laser plane, on the line of the view [mm].
    seen: Vec3,
    /// Where along the line it lands, and would without a film [mm].
    lands: [f32; 2],
    /// Width of the line there over that above the film [1].
    widening: f32,
    /// What foil throws to the lens, over what it would if the film turned nothing [1].
    glint: f32,
    /// Share of light that passes the film towards the lens where that looks through it; 0 where what lies there is
    /// hidden [1].
    passes: f32,
}

/// Buffers in which second lines are made.
#[derive(Debug, Default)]
pub struct TransmissionScratch {
    below: Vec<Option<TransmittedPoint>>,
    /// Height of the surface drawn in each column [mm].
    height: Vec<f32>,
    /// Whether the film is sealed to it: light does not creep from there into a pocket.
    sealed: Vec<bool>,
    /// Variance along the line of what is out of focus, a column [px^2].
    defocus: Vec<f32>,
    /// Share of light beyond a pocket's end that comes back, a column [1].
    holds: Vec<f32>,
    /// Stretches of columns along which light spreads below the film.
    pieces: Vec<Range<usize>>,
    buffer: Vec<f32>,
}

/// Share of light from `light` that enters a film of index `n` [1].
pub(crate) fn entering_share(n: f32, normal: Vec3, light: Vec3) -> f32 {
    1.0 - fresnel::fresnel_dielectric(1.0, f64::from(n), f64::from(normal.dot(light).max(1e-3))).0 as f32
}

/// The film of `matter`, as its light is asked for.
pub(crate) fn stack(matter: &Matter, film: &Film, normal: Vec3, sight: &Sight) -> FilmStack {
    FilmStack {
        medium: matter.medium,
        film: *film,
        enter: entering_share(matter.medium.n_eff, normal, -sight.light),
        view_up: normal.dot(sight.view).max(0.0),
        light_up: normal.dot(-sight.light).max(LEAST_FILM_COSINE),
        view: sight.view,
        light: -sight.light,
        normal,
    }
}

/// The film of `matter` in the production model.
pub fn spread(
    matter: &Matter,
    film: &Film,
    normal: Vec3,
    sight: &Sight,
    films: &mut FilmStackKernel,
) -> FilmStackSpread {
    let mut spread = films.spread(&stack(matter, film, normal, sight));
    // A width that holds next to nothing says nothing of how its light leaves; another place's light must not leave by
    // it.
    for (exit, enter) in spread.exit.iter_mut().zip(spread.enter) {
        *exit = exit.clamp(0.0, MAX_RADIANCE_FACTOR * enter);
    }
    spread
}

/// Share of light from `target` below the film of `hit` that passes it unturned to a lens along `to_lens`, wherever the
/// lens looks through the film; `None` where it does not see the point [1].
pub(crate) fn passes_from(target: Vec3, hit: &Hit, film: &Film, to_lens: Vec3, view: &LineView<'_>) -> Option<f32> {
    if !view.specimen.sees_below(target, view.y) {
        return None;
    }
    let place = |place: Vec2| view.specimen.film(place).map(FilmPlace::of);
    let sheet = FilmSheet { n: hit.matter.medium.n_eff, place };
    let plane = PlaneBelow { point: target, normal: under_normal(film) };
    let seen = sheet.see(target, to_lens, &plane, hit.surface.z)?;
    let looked_through = Film { thickness_mm: seen.thickness_mm, ..*film };
    Some(passed_unturned(&hit.matter.medium, &looked_through, seen.up))
}

/// Where light that `hit` lets through its film meets what lies below at height `z`, and how the lens sees that:
/// through the film as it is `bent`, or as if it were even.
fn meeting(hit: &Hit, above: &Sight, film: &Film, z: f32, view: &LineView<'_>, bent: bool) -> Option<Meeting> {
    let own = Vec2::new(hit.surface.slope_x, hit.surface.slope_y);
    let at = Vec3::new(hit.x, view.y, hit.surface.z);
    let here = FilmPlace { z: at.z, slope: own, bend: Mat2::ZERO, thickness_mm: film.thickness_mm, wedge: Vec2::ZERO };
    let shape = |place: Vec2| match bent {
        true => view.specimen.film(place).map(FilmPlace::of),
        false => Some(FilmPlace { z: at.z + own.dot(place - at.truncate()), ..here }),
    };
    let around = shape(at.truncate())?;
    let here = FilmPlace { bend: around.bend, wedge: around.wedge, ..here };
    let plane = PlaneBelow { point: Vec3::new(hit.x, view.y, z), normal: under_normal(film) };
    let sheet = FilmSheet { n: hit.matter.medium.n_eff, place: shape };
    let landed = sheet.land(at.x, at.y, above.light, &here, &plane)?;
    let target = landed.point;
    let seen = sheet.see(target, above.view, &plane, at.z)?;
    // What is seen lies on the view's line, which meets the laser plane here.
    let along = above.view * ((view.y - seen.point.y) / above.view.y.min(-LEAST_VIEW_SLANT));
    let straight = hit.x + above.light.x * ((at.z - target.z) / -above.light.z);
    let looked_through = Film { thickness_mm: seen.thickness_mm, ..*film };
    let shows = view.specimen.sees_below(target, view.y);
    let passes = if shows { passed_unturned(&hit.matter.medium, &looked_through, seen.up) } else { 0.0 };
    // Foil glints by the ways that light and view have below the film.
    let under = &film.under.gloss;
    let glints = |light: Vec3, view: Vec3| fresnel::gloss(under, plane.normal, light, view).max(f32::MIN_POSITIVE);
    let glint = match under.is_metal() {
        true => glints(-landed.way, seen.way) / glints(-above.light, above.view),
        false => 1.0,
    };
    Some(Meeting {
        glint: glint.min(MAX_GATHERED),
        seen: seen.point + along,
        lands: [target.x, straight],
        widening: landed.widening,
        passes,
    })
}

impl TransmissionScratch {
    /// Nothing below any of `columns` columns.
    pub fn clear(&mut self, columns: usize) {
        self.below.clear();
        self.below.resize(columns, None);
    }

    /// Notes what lies below the film of `hit`, which `column` looks at as `above` says and which spreads light like
    /// `spread`.
    pub(crate) fn note(
        &mut self,
        column: usize,
        (hit, above): (&Hit, &Sight),
        film: &Film,
        spread: &FilmStackSpread,
        view: &LineView<'_>,
    ) {
        let z = height_below(&hit.surface, film);
        // No line holds more than all of it. Light that lands here may leave where the film is level.
        let light: f32 = spread.below.iter().sum();
        let passes = spread.passes.max(passed_unturned(&hit.matter.medium, film, above.view.z));
        if !hit.lit || light * passes * above.electrons * MAX_GAIN < view.faint {
            return;
        }
        let bent = film.gap_mm.and_then(|_| meeting(hit, above, film, z, view, true));
        // Where the film turns the line away, what it has scattered before is left.
        let first = if bent.is_some() || film.gap_mm.is_none() { 0 } else { NARROW_WIDTHS };
        let Some(meeting) = bent.or_else(|| meeting(hit, above, film, z, view, false)) else { return };
        let Meeting { seen, lands, widening, glint, passes } = meeting;
        let sealed = film.gap_mm.is_none();
        let passes = if sealed && passes > 0.0 { spread.passes } else { passes };
        let [slope_x, slope_y] = film.under_slope;
        let sight = view.sight(seen.x, &Surface { z: seen.z, slope_x, slope_y });
        let white = under_normal(film).dot(sight.view).max(0.0) * sight.electrons;
        let metal = film.under.gloss.is_metal();
        let row = sight.row - spread.below_beside * sight.rows_per_mm;
        let widened = sight.laser_variance * (widening.min(MAX_WIDENING).powi(2) - 1.0);
        let of_pocket = film.is_over_room();
        // Foil shows the film that stands where its mirror image does.
        let mirrored = if metal { film.gap_mm.unwrap_or(0.0) } else { 0.0 };
        let comes_from = [0, 1].map(|i| -sight.view[i] / sight.view.z.max(LEAST_FILM_COSINE) * mirrored);
        let left = |j: usize| {
            if of_pocket && j >= FILLING { spread.below[j] * spread.below_first[j] } else { spread.below[j] }
        };
        self.below[column] = Some(TransmittedPoint {
            column: view.camera.project(seen.x, 0.0, seen.z)[0],
            z,
            lands,
            sight: Sight { row, variance: sight.variance + widened, ..sight },
            light: std::array::from_fn(|j| match j {
                _ if j < first => 0.0,
                0..NARROW_WIDTHS => spread.below[j] * white * glint,
                _ => left(j).sqrt() * white,
            }),
            exit: std::array::from_fn(|j| if j < NARROW_WIDTHS { passes } else { left(j).sqrt() * passes }),
            comes_from: [lands[0] + comes_from[0], comes_from[1]],
            shows: if of_pocket {
                passes * under_normal(film).dot(sight.view).max(0.0) * spread.below_law
            } else {
                0.0
            },
            near: std::array::from_fn(|k| {
                let j = NEAR.start + k;
                if of_pocket { passes * white * spread.below[j] * (1.0 - spread.below_first[j]) } else { 0.0 }
            }),
            // Foil throws flat light elsewhere than to the lens: what a wall has sent back must be turned down once
            // more.
            holds: if metal { spread.holds * spread.holds } else { spread.holds },
            metal,
            sealed,
        });
    }

    /// Draws the second line of a line.
    pub fn draw(&mut self, camera: &Camera, line: &mut TransmittedLine) {
        let columns = self.below.len();
        let padded = columns.next_multiple_of(TILE);
        let old = line.columns.clone();
        // Columns without a line are alike whatever was there before: their numbers too decide how far a tile's are
        // drawn.
        for field in [&mut line.centre, &mut line.rows_per_mm, &mut line.variance] {
            field.resize(padded, 1.0);
            field[old.clone()].fill(1.0);
        }
        let light = line.source.iter_mut().chain(&mut line.exit).chain(&mut line.near);
        for field in light.chain(&mut line.lands).chain([&mut line.shows]) {
            field.resize(padded, 0.0);
            field[old.clone()].fill(0.0);
        }
        line.metal.resize(padded, false);
        self.height.clear();
        self.height.resize(columns, f32::MIN);
        self.sealed.clear();
        self.sealed.resize(columns, false);
        self.defocus.resize(columns, 0.0);
        self.holds.resize(columns, 0.0);
        let (mut first, mut last) = (columns, 0);
        for pair in self.below.windows(2) {
            let [Some(a), Some(b)] = pair else { continue };
            if (a.z - b.z).abs() > JUMP_MM || b.column <= a.column {
                continue;
            }
            // Light that bent film spreads over more of the line is as much fainter.
            let gathered = ((b.lands[1] - a.lands[1]) / (b.lands[0] - a.lands[0])).abs().min(MAX_GATHERED);
            let end = (b.column.ceil() as usize).min(columns);
            for column in a.column.ceil().max(0.0) as usize..end {
                let part = (column as f32 - a.column) / (b.column - a.column);
                let mix = |a: f32, b: f32| a + (b - a) * part;
                let z = mix(a.z, b.z);
                if z <= self.height[column] {
                    continue;
                }
                self.height[column] = z;
                self.sealed[column] = a.sealed;
                self.defocus[column] = mix(a.sight.defocus, b.sight.defocus);
                (first, last) = (first.min(column), last.max(column + 1));
                line.centre[column] = mix(a.sight.row, b.sight.row);
                line.rows_per_mm[column] = mix(a.sight.rows_per_mm, b.sight.rows_per_mm);
                self.holds[column] = a.holds;
                line.variance[column] = mix(a.sight.variance, b.sight.variance);
                line.metal[column] = a.metal;
                for (i, lands) in line.lands.iter_mut().enumerate() {
                    lands[column] = mix(a.comes_from[i], b.comes_from[i]);
                }
                line.shows[column] = mix(a.shows, b.shows);
                for (k, near) in line.near.iter_mut().enumerate() {
                    near[column] = mix(a.near[k], b.near[k]);
                }
                let shows = a.exit[0] > 0.0 && b.exit[0] > 0.0;
                for j in 0..BASIS {
                    line.exit[j][column] = if shows { mix(a.exit[j], b.exit[j]) } else { 0.0 };
                    let share = if j < NARROW_WIDTHS { gathered } else { 1.0 };
                    line.source[j][column] = share * mix(a.light[j], b.light[j]);
                }
            }
        }
        line.columns = first.min(last)..last;
        self.blur(camera, line);
    }

    /// Spreads the second line along itself, piece by piece. What has spread far leaves by the film over where it
    /// arrives; what has kept its direction, by that over where it landed.
    fn blur(&mut self, camera: &Camera, line: &mut TransmittedLine) {
        for (widths, over_hidden) in [(0..NARROW_WIDTHS, false), (NARROW_WIDTHS..BASIS, true)] {
            self.find_pieces(line, over_hidden);
            for j in widths {
                for piece in &self.pieces {
                    let (source, defocus) = (&mut line.source[j][piece.clone()], &self.defocus[piece.clone()]);
                    if source.iter().any(|&light| light != 0.0) {
                        let ends = [piece.start, piece.end - 1].map(|end| self.holds[end]);
                        let sides = if over_hidden && line.metal[piece.start] { ends } else { [1.0; 2] };
                        blur_varying(
                            source,
                            camera.along_variance(PACK_SPREAD_MM[j]),
                            defocus,
                            sides,
                            &mut self.buffer,
                        );
                    }
                }
            }
        }
        for (j, source) in line.source.iter_mut().enumerate() {
            for column in line.columns.clone() {
                // What has kept its direction leaves here and nowhere else.
                let (own, exit) = (self.height[column] > f32::MIN, &mut line.exit[j][column]);
                source[column] *= match own {
                    false => 0.0,
                    true if j < NARROW_WIDTHS => std::mem::replace(exit, 1.0),
                    true => 1.0,
                };
            }
        }
    }

    /// Finds the pieces along which the second line's light spreads: one surface below, `over_hidden` columns too that
    /// show nothing of it.
    fn find_pieces(&mut self, line: &TransmittedLine, over_hidden: bool) {
        self.pieces.clear();
        let mut last: Option<usize> = None;
        for column in line.columns.clone().filter(|&column| self.height[column] > f32::MIN) {
            let joined = last.is_some_and(|last| {
                (over_hidden || last + 1 == column)
                    && (self.height[column] - self.height[last]).abs() <= JUMP_MM
                    && line.metal[column] == line.metal[last]
                    && self.sealed[column] == self.sealed[last]
            });
            match self.pieces.last_mut() {
                Some(piece) if joined => piece.end = column + 1,
                _ => self.pieces.push(column..column + 1),
            }
            last = Some(column);
        }
    }
}
