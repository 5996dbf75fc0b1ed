//! Rooms: the shape of a pack's pockets, as [`super::cavity`] asks for it: samples of their film, cells of these, and
//! the tops and upright sides of what lies in them.

use base::{Body, Film, Medium, Surface};
use glam::{Vec2, Vec3};
use transport::kernel::film_stack::{FilmShares, FilmStackKernel};

use super::enclosure::Facet;
use super::height_below;

/// Distance of samples of a pocket's film [mm].
pub(super) const SAMPLE_MM: f32 = 0.2;
/// Samples by which places are apart where pockets are looked for: none is narrower.
const SEARCH_SAMPLES: usize = 4;
/// Facets of film of one pocket, above which they become larger.
const MAX_FILM_FACETS: usize = 420;
/// Least samples along a cell's side.
const LEAST_SAMPLES: usize = 2;
/// Least distance of film from what lies below it, which does not send it light where they touch [mm].
const LEAST_GAP_MM: f32 = 0.05;
/// Places between two points where something may stand between them.
const LOOKS: usize = 6;
/// How far a body must rise above the way between two points to hide them from each other [mm].
const HIDES_MM: f32 = 0.1;

/// A grid of square cells, seen from above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CellGrid {
    /// Corner of the first cell [mm].
    pub corner: Vec2,
    /// Side of a cell [mm].
    pub pitch: f32,
    pub cells: [usize; 2],
}

impl CellGrid {
    /// Over the samples of a pocket.
    pub fn over(samples: &[FilmSample]) -> Self {
        let places = || samples.iter().map(|sample| sample.place);
        let corner = places().fold(Vec2::INFINITY, Vec2::min) - 0.5 * SAMPLE_MM;
        let end = places().fold(Vec2::NEG_INFINITY, Vec2::max) + 0.5 * SAMPLE_MM;
        let side = (samples.len() as f32 / MAX_FILM_FACETS as f32).sqrt().ceil() as usize;
        let pitch = side.max(LEAST_SAMPLES) as f32 * SAMPLE_MM;
        let size = ((end - corner) / pitch - 1e-3).max(Vec2::ZERO);
        Self { corner, pitch, cells: [size.x as usize + 1, size.y as usize + 1] }
    }

    /// The four cells about a place, and their shares of it; places beside the grid take the cells at its edge.
    #[inline(always)]
    pub fn about(&self, place: Vec2) -> [(usize, f32); 4] {
        let last = Vec2::new(self.cells[0] as f32, self.cells[1] as f32) - 1.0;
        let at = ((place - self.corner) / self.pitch - 0.5).clamp(Vec2::ZERO, last);
        let (c, r) = (at.x as usize, at.y as usize);
        let (fx, fy) = (at.x - c as f32, at.y - r as f32);
        let (next_c, next_r) = ((c + 1).min(self.cells[0] - 1), (r + 1).min(self.cells[1] - 1));
        let cell = |c: usize, r: usize| r * self.cells[0] + c;
        [
            (cell(c, r), (1.0 - fx) * (1.0 - fy)),
            (cell(next_c, r), fx * (1.0 - fy)),
            (cell(c, next_r), (1.0 - fx) * fy),
            (cell(next_c, next_r), fx * fy),
        ]
    }

    /// The cell of a place on it.
    #[inline(always)]
    pub fn cell(&self, place: Vec2) -> usize {
        let at = (place - self.corner) / self.pitch;
        at.y as usize * self.cells[0] + at.x as usize
    }

    /// Whether a place lies on it.
    #[inline(always)]
    pub fn holds(&self, place: Vec2) -> bool {
        let at = (place - self.corner) / self.pitch;
        at.x >= 0.0 && at.y >= 0.0 && at.x < self.cells[0] as f32 && at.y < self.cells[1] as f32
    }

    /// A cell and those beside it.
    pub fn beside(&self, cell: usize) -> impl Iterator<Item = usize> {
        let [columns, rows] = self.cells;
        let [column, row] = [cell % columns, cell / columns];
        let across = column.saturating_sub(1)..(column + 2).min(columns);
        let along = row.saturating_sub(1)..(row + 2).min(rows);
        along.flat_map(move |row| across.clone().map(move |column| row * columns + column))
    }

    pub fn middle(&self, cell: usize) -> Vec2 {
        let at = Vec2::new((cell % self.cells[0]) as f32, (cell / self.cells[0]) as f32);
        self.corner + (at + 0.5) * self.pitch
    }
}

/// Film at a place over air.
#[derive(Debug, Clone, Copy)]
pub(super) struct FilmSample {
    pub place: Vec2,
    pub surface: Surface,
    pub medium: Medium,
    pub film: Film,
}

impl FilmSample {
    fn is_over_foil(&self) -> bool {
        self.film.under.gloss.is_metal()
    }
}

/// Film of one cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// Its number in the grid.
    pub number: usize,
    /// Lower side of the film [mm].
    pub at: Vec3,
    /// Its normal downwards, as long as its area [mm^2].
    pub area: Vec3,
    /// Area seen from above [mm^2].
    pub level: f32,
    pub shares: FilmShares,
    /// What lies below it in whole or in part.
    pub body: Option<BodyTop>,
    pub foil: Option<CellFoil>,
}

/// The part of a cell that stands over a tablet, or over something else that scatters.
#[derive(Debug, Clone, Copy)]
pub(super) struct BodyTop {
    /// The body's surface [mm].
    pub at: Vec3,
    /// Its normal upwards, as long as its area [mm^2].
    pub area: Vec3,
    /// Part of the cell [1].
    pub part: f32,
    pub shares: FilmShares,
}

/// The part of a cell that stands over foil.
#[derive(Debug, Clone, Copy)]
pub(super) struct CellFoil {
    /// Its height [mm].
    pub z: f32,
    /// Part of the cell [1].
    pub part: f32,
    pub reflectance: f32,
    /// Roughness along x and y [1].
    pub roughness: Vec2,
}

/// Samples of the film of each pocket.
pub(super) fn rooms(body: &Body) -> Vec<Vec<FilmSample>> {
    let (low, high) = body.bounds();
    let (low, size) = (low.truncate(), (high - low).truncate() / SAMPLE_MM);
    let [columns, rows] = [size.x as usize + 1, size.y as usize + 1];
    let sample = |column: usize, row: usize| {
        let place = low + (Vec2::new(column as f32, row as f32) + 0.5) * SAMPLE_MM;
        let slice = body.slice(place.y);
        let surface = slice.surface(place.x)?;
        let matter = slice.matter(place.x, surface.z);
        let film = matter.film.filter(Film::is_over_room)?;
        Some(FilmSample { place, surface, medium: matter.medium, film })
    };
    let mut seen = vec![false; columns * rows];
    let mut rooms = Vec::new();
    for row in (0..rows).step_by(SEARCH_SAMPLES) {
        for column in (0..columns).step_by(SEARCH_SAMPLES) {
            let (mut open, mut room) = (vec![[column, row]], Vec::new());
            while let Some([column, row]) = open.pop() {
                if std::mem::replace(&mut seen[row * columns + column], true) {
                    continue;
                }
                let Some(sample) = sample(column, row) else { continue };
                room.push(sample);
                let beside = [
                    [column.wrapping_sub(1), row],
                    [column + 1, row],
                    [column, row.wrapping_sub(1)],
                    [column, row + 1],
                ];
                open.extend(beside.into_iter().filter(|&[column, row]| column < columns && row < rows));
            }
            if !room.is_empty() {
                rooms.push(room);
            }
        }
    }
    rooms
}

/// The cells of a pocket's film, on its grid.
pub(super) fn cells(samples: &[FilmSample], grid: &CellGrid) -> Vec<Cell> {
    let mut members = vec![Vec::new(); grid.cells[0] * grid.cells[1]];
    for sample in samples {
        members[grid.cell(sample.place)].push(sample);
    }
    // Flood fills come in no order that matters, and sums shall not depend on it.
    for members in &mut members {
        members.sort_by(|a, b| a.place.y.total_cmp(&b.place.y).then(a.place.x.total_cmp(&b.place.x)));
    }
    let mut kernel = FilmStackKernel::new();
    let cells = members.iter().enumerate().filter(|(_, members)| !members.is_empty());
    cells.map(|(number, members)| Cell::of(number, members, &mut kernel)).collect()
}

impl Cell {
    /// Of these samples.
    fn of(number: usize, samples: &[&FilmSample], kernel: &mut FilmStackKernel) -> Self {
        let (bodies, foil): (Vec<&FilmSample>, Vec<&FilmSample>) =
            samples.iter().partition(|sample| !sample.is_over_foil());
        let part = |of: &[&FilmSample]| of.len() as f32 / samples.len() as f32;
        let level = SAMPLE_MM * SAMPLE_MM;
        let below = |sample: &FilmSample| height_below(&sample.surface, &sample.film);
        let mut shares = |sample: &FilmSample| kernel.shares(&sample.medium, &sample.film);
        let film_at = |sample: &FilmSample| below(sample) + sample.film.gap_mm.unwrap_or(0.0).max(LEAST_GAP_MM);
        let normal = |[x, y]: [f32; 2]| Vec3::new(-x, -y, 1.0) * level;
        Self {
            number,
            at: mean_place(samples, film_at),
            area: samples.iter().map(|sample| -normal([sample.surface.slope_x, sample.surface.slope_y])).sum(),
            level: level * samples.len() as f32,
            shares: shares(samples[samples.len() / 2]),
            body: (!bodies.is_empty()).then(|| BodyTop {
                at: mean_place(&bodies, below),
                area: bodies.iter().map(|sample| normal(sample.film.under_slope)).sum(),
                part: part(&bodies),
                shares: shares(bodies[bodies.len() / 2]),
            }),
            foil: (!foil.is_empty()).then(|| CellFoil {
                z: mean_place(&foil, below).z,
                part: part(&foil),
                reflectance: foil[0].film.under.gloss.reflectance,
                roughness: Vec2::from(foil[0].film.under.gloss.roughness),
            }),
        }
    }
}

/// Mean place of samples at these heights [mm].
fn mean_place(samples: &[&FilmSample], z: impl Fn(&FilmSample) -> f32) -> Vec3 {
    samples.iter().map(|sample| sample.place.extend(z(sample))).sum::<Vec3>() / samples.len() as f32
}

/// Heights of bodies at the samples of a pocket; nothing where those show foil.
pub(super) struct Tops {
    /// Where the samples stand.
    pub grid: CellGrid,
    pub z: Vec<f32>,
    /// The highest of them.
    pub highest: f32,
}

impl Tops {
    pub fn of(samples: &[FilmSample], cells: &CellGrid) -> Self {
        let times = (cells.pitch / SAMPLE_MM).round() as usize;
        let grid = CellGrid { pitch: SAMPLE_MM, cells: cells.cells.map(|cells| cells * times), ..*cells };
        let mut z = vec![f32::MIN; grid.cells[0] * grid.cells[1]];
        for sample in samples.iter().filter(|sample| !sample.is_over_foil()) {
            z[grid.cell(sample.place)] = height_below(&sample.surface, &sample.film);
        }
        let highest = z.iter().copied().fold(f32::MIN, f32::max);
        Self { grid, z, highest }
    }

    /// Whether a body stands between two points.
    pub fn block(&self, a: Vec3, b: Vec3) -> bool {
        a.z.min(b.z) + HIDES_MM < self.highest
            && (1..LOOKS).any(|look| self.hides(a + (b - a) * (look as f32 / LOOKS as f32)))
    }

    /// Whether a body stands at a point.
    fn hides(&self, at: Vec3) -> bool {
        let place = at.truncate();
        at.z + HIDES_MM < self.highest && self.grid.holds(place) && self.z[self.grid.cell(place)] > at.z + HIDES_MM
    }

    /// Upright sides of bodies, down to the `floor`: those of each cell of `cells` that look the same way together.
    pub fn sides(&self, cells: &CellGrid, members: &[Cell], floor: f32) -> Vec<Facet> {
        let [columns, rows] = self.grid.cells.map(|cells| cells as isize);
        let mut sides = Vec::new();
        for (cell, body) in members.iter().filter_map(|cell| Some((cell, cell.body.as_ref()?))) {
            let times = (cells.pitch / SAMPLE_MM).round() as isize;
            let first = [cell.number % cells.cells[0], cell.number / cells.cells[0]].map(|at| at as isize * times);
            for [right, behind] in [[-1, 0], [1, 0], [0, -1], [0, 1]] {
                let (mut middle, mut area) = (Vec3::ZERO, 0.0);
                for at in 0..times * times {
                    let [column, row] = [first[0] + at % times, first[1] + at / times];
                    let z = self.z[(row * columns + column) as usize];
                    let [beside, over] = [column + right, row + behind];
                    let inside = beside >= 0 && over >= 0 && beside < columns && over < rows;
                    let is_open = !inside || self.z[(over * columns + beside) as usize] == f32::MIN;
                    if z > floor && is_open {
                        let side = SAMPLE_MM * (z - floor);
                        let edge = self.grid.middle((row * columns + column) as usize);
                        middle += side * (edge + 0.5 * SAMPLE_MM * Vec2::new(right as f32, behind as f32)).extend(z);
                        area += side;
                    }
                }
                if area > 0.0 {
                    let (top, out) = (middle / area, Vec3::new(right as f32, behind as f32, 0.0));
                    let at = top.truncate().extend(0.5 * (floor + top.z));
                    sides.push(Facet { at, area: out * area, returns: body.shares.below });
                }
            }
        }
        sides
    }
}
