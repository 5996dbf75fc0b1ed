//! Film over another surface: the light that leaves the film itself, and the transmitted line, which is light of the
//! surface below seen through the film.
//!
//! Light enters the film by Fresnel's law (Born and Wolf), spreads as [`FilmStackKernel`] says, and is seen at the film.
//! Light that is seen through the film lies where the laser meets the surface below: lower, so in other rows, and by the
//! camera's slant in other columns. There the line is drawn anew, linear between the points that neighbouring columns
//! meet; where the surface below jumps (the edge of a tablet) the line is broken, and what tablets hide from the lens is
//! dark.
//! Both ways through the film are followed (`bent_film`): level film shows what lies below nearer to the lens, by up to half of
//! its thickness for views up to 45 degrees; bent film turns light, which meets what lies below elsewhere, spread over more or less of it.
//! Neglected: what the film above hides of what lies below; a second image of the same light, where bent film folds the line over itself.

use glam::{Mat2, Vec2, Vec3};
use procedural::{Film, Matter, Medium, Surface};

use super::bent_film::{FilmPlace, FilmSheet, LEAST_FILM_COSINE, PlaneBelow, upright};
use super::box_filter::blur_varying;
use super::camera::{Camera, Sight};
use super::row::TransmittedLine;
use super::row_view::RowView;
use super::speckle::TILE;
use crate::specimen::{Hit, height_below};
use transport::fresnel;
use transport::kernel::film_stack::{FilmStack, FilmStackKernel, FilmStackSpread, passed_unturned};
use transport::kernel::{BASIS, SPREAD_MM};

/// Heights of neighbouring columns below a film that count as two surfaces [mm].
const JUMP_MM: f32 = 0.5;
/// Least slant of the view along the motion for which light off the laser plane is followed [1].
const LEAST_VIEW_SLANT: f32 = 0.05;
/// Greatest widening of the line that is believed: more is a caustic or an edge [1].
const MAX_WIDENING: f32 = 10.0;
/// Fixed widths of light that has kept its direction as far as what lies below, up to 0.1 mm: the rest comes from all sides.
const NARROW_WIDTHS: usize = 3;
/// Most light that bent film gathers on a place, over that of level film [1].
const MAX_GATHERED: f32 = 3.0;
/// Most that a thinner place of the film, or a glint, adds to what a column's own place promises [1].
const MAX_GAIN: f32 = 100.0;
/// Greatest radiance factor of a width that is believed [1].
const MAX_RADIANCE_FACTOR: f32 = 2.0;
/// Mean run of light on its way out in free paths, as in the kernel [1].
const ESCAPE_FREE_PATHS: f32 = 1.3;

/// What the laser meets below a film, by the column that looks at the film above it.
#[derive(Debug, Clone, Copy)]
struct TransmittedPoint {
    /// Sensor column where it is seen [px].
    column: f32,
    z: f32,
    /// Where along the line its light lands, and would without a film [mm].
    lands: [f32; 2],
    sight: Sight,
    /// Light towards the lens, by width [e-].
    light: [f32; BASIS],
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
    /// Light that passes the film towards the lens where that looks through it, over that at the column's own place [1].
    passed: f32,
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
    buffer: Vec<f32>,
}

/// Share of light from `light` that enters a film of index `n` [1].
pub(crate) fn entering_share(n: f32, normal: Vec3, light: Vec3) -> f32 {
    1.0 - fresnel::fresnel_dielectric(1.0, f64::from(n), f64::from(normal.dot(light).max(1e-3))).0 as f32
}

/// How far along the motion the lens sees light leave a film beside where it leaves towards all sides [mm].
pub fn exit_shift(medium: &Medium, film: &Film, view: Vec3) -> f32 {
    let run = (ESCAPE_FREE_PATHS / (medium.mu_a + medium.sigma_i)).min(0.5 * film.thickness_mm);
    run * view.y / medium.n_eff
}

/// The film of `matter` in the production model.
pub fn spread(
    matter: &Matter,
    film: &Film,
    normal: Vec3,
    sight: &Sight,
    covers: &mut FilmStackKernel,
) -> FilmStackSpread {
    let mut spread = covers.spread(&FilmStack {
        medium: matter.medium,
        film: *film,
        enter: entering_share(matter.medium.n_eff, normal, -sight.light),
        view_up: normal.dot(sight.view).max(0.0),
        light_up: normal.dot(-sight.light).max(LEAST_FILM_COSINE),
        view: sight.view,
        light: -sight.light,
    });
    // A width that holds next to nothing says nothing of how its light leaves; another place's light must not leave by it.
    for (exit, enter) in spread.exit.iter_mut().zip(spread.enter) {
        *exit = exit.clamp(0.0, MAX_RADIANCE_FACTOR * enter);
    }
    spread
}

fn under_normal(film: &Film) -> Vec3 {
    let [along, across] = film.under_slope;
    Vec3::new(-along, -across, 1.0).normalize()
}

/// Where light that `hit` lets through its film meets what lies below at height `z`, and how the lens sees that: through the film as it
/// is `bent`, or as if it were even.
fn meeting(hit: &Hit, above: &Sight, film: &Film, z: f32, view: &RowView<'_>, bent: bool) -> Option<Meeting> {
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
    let up = upright(own).dot(above.view).max(LEAST_FILM_COSINE);
    let passed = |thickness_mm: f32, up: f32| {
        passed_unturned(&hit.matter.medium, &Film { thickness_mm, ..*film }, up).max(f32::MIN_POSITIVE)
    };
    // Foil glints by the ways that light and view have below the film.
    let under = &film.under.gloss;
    let glints = |light: Vec3, view: Vec3| fresnel::gloss(under, plane.normal, light, view).max(f32::MIN_POSITIVE);
    let glint = match under.is_metal() {
        true => glints(-landed.way, seen.way) / glints(-above.light, above.view),
        false => 1.0,
    };
    view.specimen.sees_below(target, view.y).then_some(Meeting {
        glint: glint.min(MAX_GATHERED),
        seen: seen.point + along,
        lands: [target.x, straight],
        widening: landed.widening,
        passed: passed(seen.thickness_mm, seen.up) / passed(film.thickness_mm, up),
    })
}

impl TransmissionScratch {
    /// Nothing below any of `columns` columns.
    pub fn clear(&mut self, columns: usize) {
        self.below.clear();
        self.below.resize(columns, None);
    }

    /// Notes what is seen through the film of `hit`, which `column` looks at as `above` says; `through` as [`FilmStackSpread`] has it.
    pub(crate) fn note(
        &mut self,
        column: usize,
        (hit, above): (&Hit, &Sight),
        film: &Film,
        through: &[f32; BASIS],
        view: &RowView<'_>,
    ) {
        let z = height_below(&hit.surface, film);
        // No row holds more than all of it.
        let light: f32 = through.iter().sum();
        if !hit.lit || light * above.electrons * MAX_GAIN < view.faint {
            return;
        }
        let bent = film.gap_mm.and_then(|_| meeting(hit, above, film, z, view, true));
        // Where the film turns the line away, what it has scattered before is left.
        let first = if bent.is_some() || film.gap_mm.is_none() { 0 } else { NARROW_WIDTHS };
        let Some(meeting) = bent.or_else(|| meeting(hit, above, film, z, view, false)) else { return };
        let Meeting { seen, lands, widening, glint, passed } = meeting;
        let [slope_x, slope_y] = film.under_slope;
        let sight = view.sight(seen.x, &Surface { z: seen.z, slope_x, slope_y });
        let white = under_normal(film).dot(sight.view).max(0.0) * sight.electrons * passed;
        if light * white < view.faint {
            return;
        }
        let spread = sight.laser_variance * (widening.min(MAX_WIDENING).powi(2) - 1.0);
        self.below[column] = Some(TransmittedPoint {
            column: view.camera.project(seen.x, 0.0, seen.z)[0],
            z,
            lands,
            sight: Sight { variance: sight.variance + spread, ..sight },
            light: std::array::from_fn(|j| match j {
                _ if j < first => 0.0,
                0..NARROW_WIDTHS => through[j] * white * glint,
                _ => through[j] * white,
            }),
            metal: film.under.gloss.is_metal(),
            sealed: film.gap_mm.is_none(),
        });
    }

    /// Draws the second line of a row.
    pub fn draw(&mut self, camera: &Camera, line: &mut TransmittedLine) {
        let columns = self.below.len();
        let padded = columns.next_multiple_of(TILE);
        let old = line.columns.clone();
        // Columns without a line are alike whatever was there before: their numbers too decide how far a tile's are drawn.
        for field in [&mut line.centre, &mut line.rows_per_mm, &mut line.variance] {
            field.resize(padded, 1.0);
            field[old.clone()].fill(1.0);
        }
        for source in &mut line.source {
            source.resize(padded, 0.0);
            source[old.clone()].fill(0.0);
        }
        line.metal.resize(padded, false);
        self.height.clear();
        self.height.resize(columns, f32::MIN);
        self.sealed.clear();
        self.sealed.resize(columns, false);
        self.defocus.resize(columns, 0.0);
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
                line.variance[column] = mix(a.sight.variance, b.sight.variance);
                line.metal[column] = a.metal;
                for j in 0..BASIS {
                    let share = if j < NARROW_WIDTHS { gathered } else { 1.0 };
                    line.source[j][column] = share * mix(a.light[j], b.light[j]);
                }
            }
        }
        line.columns = first.min(last)..last;
        self.blur(camera, line);
    }

    /// Spreads the second line along itself, piece by piece.
    fn blur(&mut self, camera: &Camera, line: &mut TransmittedLine) {
        let mut start = line.columns.start;
        for column in line.columns.clone() {
            let ends = column + 1 == line.columns.end
                || (self.height[column + 1] - self.height[column]).abs() > JUMP_MM
                || line.metal[column + 1] != line.metal[column]
                || self.sealed[column + 1] != self.sealed[column];
            if !ends {
                continue;
            }
            let piece = start..column + 1;
            start = column + 1;
            if self.height[column] == f32::MIN {
                continue;
            }
            let defocus = &self.defocus[piece.clone()];
            for j in 0..BASIS {
                let source = &mut line.source[j][piece.clone()];
                if source.iter().any(|&light| light != 0.0) {
                    blur_varying(source, camera.along_variance(SPREAD_MM[j]), defocus, [1.0; 2], &mut self.buffer);
                }
            }
        }
    }
}
