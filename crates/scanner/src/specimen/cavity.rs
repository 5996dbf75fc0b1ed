//! Cavities: the pockets of a pack as closed rooms, and where light that enters through a pocket's film at one place leaves it again.
//!
//! A room has facets of film, of the tops of what lies in it, and of its upright sides, over foil that mirrors; they send each other light from
//! all sides ([`super::enclosure`]). Light that the film turns on its way down starts from the film's lower side; light that passes
//! straight starts from what it meets, or is spread over the film by rough foil, whose lobe is a Gaussian of slopes. The
//! answer is a matrix a pocket: the light of a line is a sum of its rows. Neglected: which way film prefers to turn light, light that spreads within
//! film or tablets before it leaves, holes in the film, folds of the foil, and that foil mirrors less cleanly than a mirror where light has been
//! turned before.

use std::ops::Range;
use std::sync::Arc;

use glam::{Vec2, Vec3};
use multiversion::multiversion;
use numerics::lanes::exp;
use procedural::{Body, Film, Medium, Surface};
use rayon::prelude::*;
use transport::kernel::film_stack::{FACET_TURN, FilmShares, FilmStackKernel};

use super::enclosure::{Facet, Mirror, arrives, exchange, settle};
use super::height_below;

/// Distance of samples of a pocket's film [mm].
const SAMPLE_MM: f32 = 0.2;
/// Samples by which places are apart where pockets are looked for: none is narrower.
const SEARCH_SAMPLES: usize = 4;
/// Facets of film of one pocket, above which they become larger.
const MAX_FILM_FACETS: usize = 420;
/// Least samples along a cell's side.
const LEAST_SAMPLES: usize = 2;
/// Least distance of film from what lies below it, which does not send it light where they touch [mm].
const LEAST_GAP_MM: f32 = 0.05;
/// Cells of the card around a pocket that its walls light.
const CARD_CELLS: usize = 5;
/// Places between two points where something may stand between them.
const LOOKS: usize = 6;
/// How far a body must rise above the way between two points to hide them from each other [mm].
const HIDES_MM: f32 = 0.1;
/// Places of a vector.
const LANES: usize = 16;

/// A grid of square cells, seen from above.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Grid {
    /// Corner of the first cell [mm].
    corner: Vec2,
    /// Side of a cell [mm].
    pitch: f32,
    cells: [usize; 2],
}

impl Grid {
    /// The four cells about a place, and their shares of it; places beside the grid take the cells at its edge.
    fn about(&self, place: Vec2) -> [(usize, f32); 4] {
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
    fn cell(&self, place: Vec2) -> usize {
        let at = (place - self.corner) / self.pitch;
        at.y as usize * self.cells[0] + at.x as usize
    }

    /// Whether a place lies on it.
    fn holds(&self, place: Vec2) -> bool {
        let at = (place - self.corner) / self.pitch;
        at.x >= 0.0 && at.y >= 0.0 && at.x < self.cells[0] as f32 && at.y < self.cells[1] as f32
    }

    fn middle(&self, cell: usize) -> Vec2 {
        let at = Vec2::new((cell % self.cells[0]) as f32, (cell / self.cells[0]) as f32);
        self.corner + (at + 0.5) * self.pitch
    }
}

/// One pocket.
#[derive(Debug)]
pub(crate) struct Cavity {
    grid: Grid,
    /// The facet of film in each cell; beside the pocket, the nearest.
    film: Vec<u16>,
    /// Whether a cell or one beside it has film: other pockets may stand in the rest of the grid.
    near: Vec<bool>,
    cells: Vec<Cell>,
    /// Facets of film above bodies, by rising number: their bodies' tops are the sources after those of film.
    bodies: Vec<usize>,
    /// Share of straight light that entered each facet's film and that rough foil spreads over it from below, `[facet][source facet]` [1].
    lobes: Vec<f32>,
    /// What arrives in the end at facets of film and tops of bodies of what each of them sends, `[facet][source]` [1].
    flux: Vec<f32>,
    card: Card,
}

/// The card around a pocket.
#[derive(Debug)]
struct Card {
    grid: Grid,
    /// Its cells beside the film, and at most one cell under that.
    cells: Vec<usize>,
    /// The facets of film that light it.
    walls: Vec<usize>,
    /// Share of the light of each of these that each of those cells receives, by its area seen from above, `[cell][facet]` [1].
    receives: Vec<f32>,
}

/// Film at a place over air.
#[derive(Debug, Clone, Copy)]
struct Sample {
    place: Vec2,
    surface: Surface,
    medium: Medium,
    film: Film,
}

impl Sample {
    fn is_over_foil(&self) -> bool {
        self.film.under.gloss.is_metal()
    }
}

/// Film of one cell.
#[derive(Debug, Clone, Copy)]
struct Cell {
    /// Its number in the grid.
    number: usize,
    /// Lower side of the film [mm].
    at: Vec3,
    /// Its normal downwards, as long as its area [mm^2].
    area: Vec3,
    /// Area seen from above [mm^2].
    level: f32,
    shares: FilmShares,
    /// What lies below it in whole or in part.
    body: Option<BodyTop>,
    foil: Option<Foil>,
}

/// The part of a cell that stands over a tablet, or over something else that scatters.
#[derive(Debug, Clone, Copy)]
struct BodyTop {
    /// The body's surface [mm].
    at: Vec3,
    /// Its normal upwards, as long as its area [mm^2].
    area: Vec3,
    /// Part of the cell [1].
    part: f32,
    shares: FilmShares,
}

/// The part of a cell that stands over foil.
#[derive(Debug, Clone, Copy)]
struct Foil {
    /// Its height [mm].
    z: f32,
    /// Part of the cell [1].
    part: f32,
    reflectance: f32,
    /// Roughness along x and y [1].
    roughness: Vec2,
}

/// All pockets of a body.
pub(super) fn find(body: &Body) -> Vec<Arc<Cavity>> {
    let Body::Pack(_) = body else { return Vec::new() };
    rooms(body).par_iter().map(|samples| Arc::new(Cavity::of(samples))).collect()
}

/// Samples of the film of each pocket.
fn rooms(body: &Body) -> Vec<Vec<Sample>> {
    let (low, high) = body.bounds();
    let (low, size) = (low.truncate(), (high - low).truncate() / SAMPLE_MM);
    let [columns, rows] = [size.x as usize + 1, size.y as usize + 1];
    let sample = |column: usize, row: usize| {
        let place = low + (Vec2::new(column as f32, row as f32) + 0.5) * SAMPLE_MM;
        let slice = body.slice(place.y);
        let surface = slice.surface(place.x)?;
        let matter = slice.matter(place.x, surface.z);
        let film = matter.film.filter(Film::is_over_room)?;
        Some(Sample { place, surface, medium: matter.medium, film })
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

/// The cells of a pocket's film.
fn cells(samples: &[Sample]) -> (Grid, Vec<Cell>) {
    let corner = samples.iter().map(|sample| sample.place).fold(Vec2::INFINITY, Vec2::min) - 0.5 * SAMPLE_MM;
    let end = samples.iter().map(|sample| sample.place).fold(Vec2::NEG_INFINITY, Vec2::max) + 0.5 * SAMPLE_MM;
    let side = (samples.len() as f32 / MAX_FILM_FACETS as f32).sqrt().ceil() as usize;
    let pitch = side.max(LEAST_SAMPLES) as f32 * SAMPLE_MM;
    let size = ((end - corner) / pitch - 1e-3).max(Vec2::ZERO);
    let grid = Grid { corner, pitch, cells: [size.x as usize + 1, size.y as usize + 1] };
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
    let cells = cells.map(|(number, members)| Cell::of(number, members, &mut kernel)).collect();
    (grid, cells)
}

impl Cell {
    /// Of these samples.
    fn of(number: usize, samples: &[&Sample], kernel: &mut FilmStackKernel) -> Self {
        let (bodies, foil): (Vec<&Sample>, Vec<&Sample>) = samples.iter().partition(|sample| !sample.is_over_foil());
        let part = |of: &[&Sample]| of.len() as f32 / samples.len() as f32;
        let level = SAMPLE_MM * SAMPLE_MM;
        let below = |sample: &Sample| height_below(&sample.surface, &sample.film);
        let mut shares = |sample: &Sample| kernel.shares(&sample.medium, &sample.film);
        let film_at = |sample: &Sample| below(sample) + sample.film.gap_mm.unwrap_or(0.0).max(LEAST_GAP_MM);
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
            foil: (!foil.is_empty()).then(|| Foil {
                z: mean_place(&foil, below).z,
                part: part(&foil),
                reflectance: foil[0].film.under.gloss.reflectance,
                roughness: Vec2::from(foil[0].film.under.gloss.roughness),
            }),
        }
    }
}

/// Mean place of samples at these heights [mm].
fn mean_place(samples: &[&Sample], z: impl Fn(&Sample) -> f32) -> Vec3 {
    samples.iter().map(|sample| sample.place.extend(z(sample))).sum::<Vec3>() / samples.len() as f32
}

/// Heights of bodies at the samples of a pocket; nothing where those show foil.
struct Tops {
    /// Where the samples stand.
    grid: Grid,
    z: Vec<f32>,
    /// The highest of them.
    highest: f32,
}

impl Tops {
    fn of(samples: &[Sample], cells: &Grid) -> Self {
        let times = (cells.pitch / SAMPLE_MM).round() as usize;
        let grid = Grid { pitch: SAMPLE_MM, cells: cells.cells.map(|cells| cells * times), ..*cells };
        let mut z = vec![f32::MIN; grid.cells[0] * grid.cells[1]];
        for sample in samples.iter().filter(|sample| !sample.is_over_foil()) {
            z[grid.cell(sample.place)] = height_below(&sample.surface, &sample.film);
        }
        let highest = z.iter().copied().fold(f32::MIN, f32::max);
        Self { grid, z, highest }
    }

    /// Whether a body stands between two points.
    fn block(&self, a: Vec3, b: Vec3) -> bool {
        a.z.min(b.z) + HIDES_MM < self.highest
            && (1..LOOKS).any(|look| self.hides(a + (b - a) * (look as f32 / LOOKS as f32)))
    }

    /// Whether a body stands at a point.
    fn hides(&self, at: Vec3) -> bool {
        let place = at.truncate();
        self.grid.holds(place) && self.z[self.grid.cell(place)] > at.z + HIDES_MM
    }

    /// Upright sides of bodies, down to the `floor`: those of each cell of `cells` that look the same way together.
    fn sides(&self, cells: &Grid, members: &[Cell], floor: f32) -> Vec<Facet> {
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

/// Share of straight light that entered each cell's film and that rough foil spreads over it from below, `[cell][source cell]` [1].
fn lobes(cells: &[Cell], mirror: Mirror, pitch: f32) -> Vec<f32> {
    let n = cells.len();
    let mut lobes = vec![0.0f32; n * n];
    for (source, from) in cells.iter().enumerate() {
        let Some(foil) = from.foil else { continue };
        // As wide as half of a cell at least: it is spread over whole ones.
        let deviation = foil.roughness * (2.0 * (from.at.z - mirror.z).max(0.0) * FACET_TURN) + 0.4 * pitch;
        let lobe = |to: &Cell| {
            let away = (to.at - from.at).truncate() / deviation;
            exp((-0.5 * away.length_squared()).max(-80.0)) * to.level
        };
        let all: f32 = cells.iter().map(lobe).sum();
        let share = foil.part * from.shares.straight_down * foil.reflectance / all;
        cells.iter().enumerate().for_each(|(to, cell)| lobes[to * n + source] = share * lobe(cell));
    }
    lobes
}

impl Cavity {
    fn of(samples: &[Sample]) -> Self {
        let (grid, cells) = cells(samples);
        Self::solve(samples, grid, cells)
    }

    /// The cavity of these samples in cells.
    fn solve(samples: &[Sample], grid: Grid, cells: Vec<Cell>) -> Self {
        let films = cells.len();
        let foil: Vec<Foil> = cells.iter().filter_map(|cell| cell.foil).collect();
        let mean = |value: &dyn Fn(&Foil) -> f32| foil.iter().map(value).sum::<f32>() / foil.len() as f32;
        let bodies: Vec<usize> = (0..films).filter(|&film| cells[film].body.is_some()).collect();
        let tops = || bodies.iter().filter_map(|&cell| cells[cell].body.as_ref());
        let mirror = match foil.is_empty() {
            false => Mirror { z: mean(&|foil| foil.z), reflectance: mean(&|foil| foil.reflectance) },
            // Nothing of it is seen.
            true => Mirror { z: tops().map(|top| top.at.z).fold(f32::MAX, f32::min), reflectance: 1.0 },
        };
        let heights = Tops::of(samples, &grid);
        let film = cells.iter().map(|cell| Facet { at: cell.at, area: cell.area, returns: cell.shares.held });
        let top = |top: &BodyTop| Facet { at: top.at, area: top.area, returns: top.shares.below };
        let facets: Vec<Facet> = film.chain(tops().map(top)).chain(heights.sides(&grid, &cells, mirror.z)).collect();
        let blocked = (!bodies.is_empty()).then_some(|a: Vec3, b: Vec3| heights.block(a, b));
        let shares = exchange(&facets, mirror, blocked);
        let flux = settle(&facets, &shares, films + bodies.len());
        let card = Card::around(&grid, &cells);
        let (film, lobes) = (nearest(&grid, &cells), lobes(&cells, mirror, grid.pitch));
        let near = near(&grid, &cells);
        Self { grid, film, near, cells, bodies, lobes, flux, card }
    }

    /// Whether a place lies in the pocket, or within a cell of it.
    pub fn holds(&self, place: Vec2) -> bool {
        self.grid.holds(place) && self.near[self.grid.cell(place)]
    }

    /// Facets of film about a place, and their shares of it; `None` beside the pocket.
    fn about(&self, place: Vec2) -> Option<[(usize, f32); 4]> {
        let about = || self.grid.about(place).map(|(cell, weight)| (usize::from(self.film[cell]), weight));
        self.holds(place).then(about)
    }
}

impl Card {
    fn around(film: &Grid, cells: &[Cell]) -> Self {
        let grid = Grid {
            corner: film.corner - CARD_CELLS as f32 * film.pitch,
            cells: film.cells.map(|cells| cells + 2 * CARD_CELLS),
            ..*film
        };
        let [columns, rows] = grid.cells;
        let mut is_film = vec![false; columns * rows];
        for cell in cells {
            let [column, row] = [cell.number % film.cells[0], cell.number / film.cells[0]];
            is_film[(row + CARD_CELLS) * columns + column + CARD_CELLS] = true;
        }
        let is_shown = |number: &usize| {
            let [column, row] = [number % columns, number / columns];
            let mut about = (row.saturating_sub(1)..(row + 2).min(rows))
                .flat_map(|row| (column.saturating_sub(1)..(column + 2).min(columns)).map(move |column| (row, column)));
            about.any(|(row, column)| !is_film[row * columns + column])
        };
        let shown: Vec<usize> = (0..columns * rows).filter(is_shown).collect();
        let foot = cells.iter().map(|cell| cell.at.z).fold(f32::MAX, f32::min);
        let area = grid.pitch * grid.pitch;
        let share = |number: usize, wall: &Cell| {
            let to = (grid.middle(number).extend(foot), Vec3::Z * area);
            arrives(&Facet { at: wall.at, area: -wall.area, returns: 0.0 }, to) * wall.level / area
        };
        let walls: Vec<usize> =
            (0..cells.len()).filter(|&wall| shown.iter().any(|&number| share(number, &cells[wall]) > 0.0)).collect();
        let receives =
            shown.iter().flat_map(|&number| walls.iter().map(move |&wall| share(number, &cells[wall]))).collect();
        Self { grid, cells: shown, walls, receives }
    }

    /// What each of its cells receives of what leaves each facet of film, by area.
    fn receive(&self, leaves: &[f32]) -> Vec<f32> {
        let walls: Vec<f32> = self.walls.iter().map(|&wall| leaves[wall]).collect();
        let mut received = vec![0.0; self.cells.len()];
        multiply(&self.receives, &walls, 0..walls.len(), &mut received);
        let mut all = vec![0.0; self.grid.cells[0] * self.grid.cells[1]];
        self.cells.iter().zip(received).for_each(|(&cell, light)| all[cell] = light);
        all
    }
}

/// The facet of film nearest to each cell.
fn nearest(grid: &Grid, cells: &[Cell]) -> Vec<u16> {
    let distance = |cell: usize, other: &Cell| grid.middle(cell).distance_squared(grid.middle(other.number));
    (0..grid.cells[0] * grid.cells[1])
        .map(|cell| {
            let nearest =
                (0..cells.len()).min_by(|&a, &b| distance(cell, &cells[a]).total_cmp(&distance(cell, &cells[b])));
            nearest.unwrap_or(0) as u16
        })
        .collect()
}

/// Whether each cell, or one beside it, has film.
fn near(grid: &Grid, cells: &[Cell]) -> Vec<bool> {
    let [columns, rows] = grid.cells;
    let mut near = vec![false; columns * rows];
    for cell in cells {
        let [column, row] = [cell.number % columns, cell.number / columns];
        for row in row.saturating_sub(1)..(row + 2).min(rows) {
            near[row * columns..][column.saturating_sub(1)..(column + 2).min(columns)].fill(true);
        }
    }
    near
}

/// Light of one line in a cavity.
#[derive(Debug, Clone)]
pub(crate) struct CavityLight {
    cavity: Arc<Cavity>,
    /// What entered the film at each facet, times length of the line [e- mm].
    entered: Vec<f32>,
    /// What leaves each facet turned, by area seen from above [e-/mm].
    leaves: Vec<f32>,
    /// What lies below each throws up again of what the film has thrown down [e-/mm].
    below: Vec<f32>,
    /// What each cell of the card receives, by area [e-/mm].
    card: Vec<f32>,
}

impl CavityLight {
    /// Nothing in any.
    pub fn none(cavity: &Arc<Cavity>) -> Self {
        let entered = vec![0.0; cavity.cells.len()];
        Self { cavity: cavity.clone(), entered, leaves: Vec::new(), below: Vec::new(), card: Vec::new() }
    }

    /// Whether it is the light of this cavity.
    pub fn is_of(&self, cavity: &Arc<Cavity>) -> bool {
        Arc::ptr_eq(&self.cavity, cavity)
    }

    /// Whether any of it may leave between two places along the line.
    pub fn is_within(&self, low: f32, high: f32) -> bool {
        let card = &self.cavity.card.grid;
        high >= card.corner.x && low <= card.corner.x + card.pitch * card.cells[0] as f32
    }

    /// Adds light of the line that enters the film at a place, times the length of line that it stands for [e- mm].
    pub fn enter(&mut self, place: Vec2, light: f32) {
        for (facet, share) in self.cavity.about(place).into_iter().flatten() {
            self.entered[facet] += share * light;
        }
    }

    /// Lets what has entered spread.
    pub fn spread(&mut self) {
        let Cavity { cells, bodies, lobes, flux, card, .. } = &*self.cavity;
        let films = cells.len();
        let mut lobe = vec![0.0; films];
        // A line crosses two rows of facets.
        let lit = |light: &f32| *light > 0.0;
        let first = self.entered.iter().position(lit).unwrap_or(0);
        let end = self.entered.iter().rposition(lit).map_or(0, |last| last + 1);
        multiply(lobes, &self.entered, first..end.max(first), &mut lobe);
        let film = cells.iter().zip(&self.entered).zip(&lobe);
        let film =
            film.map(|((cell, entered), lobe)| cell.shares.turned_down * entered + cell.shares.straight_held * lobe);
        let top = |&cell: &usize| {
            let straight = |top: &BodyTop| top.part * top.shares.straight_down * top.shares.straight_below;
            cells[cell].body.as_ref().map_or(0.0, straight) * self.entered[cell]
        };
        let sent: Vec<f32> = film.chain(bodies.iter().map(top)).collect();
        let mut arrived = vec![0.0; sent.len()];
        multiply(flux, &sent, 0..sent.len(), &mut arrived);
        let mut tops = arrived[films..].iter();
        (self.leaves, self.below) = cells
            .iter()
            .zip(arrived.iter().zip(&lobe))
            .map(|(cell, (arrived, lobe))| {
                let Cell { shares, level, .. } = cell;
                let leaves = shares.out * arrived + shares.straight_out * lobe;
                let top = |top: &BodyTop| top.shares.seen_below * tops.next().copied().unwrap_or(0.0);
                // Foil shows the film's lower side.
                let foil = |foil: &Foil| foil.part * foil.reflectance * shares.held * arrived;
                let below = cell.body.as_ref().map_or(0.0, top) + cell.foil.as_ref().map_or(0.0, foil);
                (leaves / level, below / level)
            })
            .unzip();
        self.card = card.receive(&self.leaves);
    }

    /// What leaves the film turned at a place, by area seen from above; `None` beside the cavity [e-/mm].
    pub fn leaves(&self, place: Vec2) -> Option<f32> {
        self.cavity.about(place).map(|about| mean(&self.leaves, about))
    }

    /// What lies below throws up at a place, by area seen from above; `None` beside the cavity [e-/mm].
    pub fn below(&self, place: Vec2) -> Option<f32> {
        self.cavity.about(place).map(|about| mean(&self.below, about))
    }

    /// What the card receives at a place, by area; `None` far from the cavity [e-/mm].
    pub fn card(&self, place: Vec2) -> Option<f32> {
        let card = &self.cavity.card.grid;
        card.holds(place).then(|| mean(&self.card, card.about(place)))
    }
}

fn mean(values: &[f32], about: [(usize, f32); 4]) -> f32 {
    about.iter().map(|&(at, share)| share * values[at]).sum()
}

/// `matrix` `[out][values]` times those of `values` that are not zero.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn multiply(matrix: &[f32], values: &[f32], of: Range<usize>, out: &mut [f32]) {
    let (length, values) = (values.len().max(1), &values[of.clone()]);
    for (out, row) in out.iter_mut().zip(matrix.chunks_exact(length)) {
        let row = &row[of.clone()];
        // Sums over lanes, whatever the machine's vectors.
        let mut sums = [0.0f32; LANES];
        let (whole, rest) = (row.chunks_exact(LANES), row.chunks_exact(LANES).remainder());
        let (lanes, last) = (values.chunks_exact(LANES), values.chunks_exact(LANES).remainder());
        for (row, values) in whole.zip(lanes) {
            for lane in 0..LANES {
                sums[lane] += row[lane] * values[lane];
            }
        }
        for (sum, (row, value)) in sums.iter_mut().zip(rest.iter().zip(last)) {
            *sum += row * value;
        }
        *out = sums.iter().sum();
    }
}

#[cfg(test)]
mod tests {
    use procedural::{Gloss, Stream};
    use rand::{Rng, RngExt};

    use super::*;

    /// A cap of a sphere over level foil at z = 0.
    struct Cap {
        height: f32,
        radius: f32,
    }

    impl Cap {
        /// Radius of the sphere [mm].
        fn sphere(&self) -> f32 {
            (self.radius * self.radius + self.height * self.height) / (2.0 * self.height)
        }

        fn middle(&self) -> Vec3 {
            Vec3::Z * (self.height - self.sphere())
        }

        /// Its film's samples, as thin as nothing.
        fn samples(&self, medium: Medium, under: Medium) -> Vec<Sample> {
            let count = (2.0 * self.radius / SAMPLE_MM) as usize + 1;
            let at = |n: usize| (n as f32 - 0.5 * (count - 1) as f32) * SAMPLE_MM;
            let places = (0..count * count).map(|n| Vec2::new(at(n % count), at(n / count)));
            let sample = |place: Vec2| {
                let z = (self.sphere().powi(2) - place.length_squared()).sqrt();
                let surface = Surface { z: z + self.middle().z, slope_x: -place.x / z, slope_y: -place.y / z };
                let (gap_mm, under_slope) = (Some(surface.z), [0.0; 2]);
                let film = Film { thickness_mm: 1e-6, gap_mm, room_mm: [self.radius; 2], under, under_slope };
                Sample { place, surface, medium, film }
            };
            places.filter(|place| place.length() < self.radius).map(sample).collect()
        }

        /// Where a ray within it meets it, after the foil if that comes first; whether it did.
        fn meets(&self, from: Vec3, way: Vec3) -> (Vec3, bool) {
            let meet = |from: Vec3, way: Vec3| {
                let off = from - self.middle();
                let along = off.dot(way);
                from + way * (-along + (along * along - off.length_squared() + self.sphere().powi(2)).max(0.0).sqrt())
            };
            let at = meet(from, way);
            if at.z > 0.0 {
                return (at, false);
            }
            let on = from - way * (from.z / way.z);
            (meet(on, Vec3::new(way.x, way.y, -way.z)), true)
        }
    }

    /// An oblong pocket that lies aslant leaves the corners of its grid to others, and holds all of its own film.
    #[test]
    fn corners_beside_an_aslant_pocket_are_not_its_own() {
        let cap = Cap { height: 2.0, radius: 4.0 };
        let foil = Gloss { share: 1.0, reflectance: 0.9, roughness: [0.1; 2], matte: 0.0 };
        let medium = Medium::isotropic(0.0, 20.0, 1.5, Gloss::NONE);
        let samples = cap.samples(medium, Medium::opaque(foil));
        let aslant: Vec<Sample> =
            samples.into_iter().filter(|sample| (sample.place.x - sample.place.y).abs() < 1.5).collect();
        let cavity = Cavity::of(&aslant);
        assert!(aslant.iter().all(|sample| cavity.holds(sample.place)));
        assert!(cavity.grid.holds(Vec2::new(2.5, -2.5)) && !cavity.holds(Vec2::new(2.5, -2.5)));
        let mut light = CavityLight::none(&Arc::new(cavity));
        light.enter(Vec2::new(2.5, -2.5), 1.0);
        light.spread();
        assert!(light.leaves.iter().all(|&leaves| leaves == 0.0));
    }

    /// A unit vector by Lambert's law about a normal.
    fn lambert(normal: Vec3, rng: &mut impl Rng) -> Vec3 {
        let (turn, sin2) = (std::f32::consts::TAU * rng.random::<f32>(), rng.random::<f32>());
        let (a, b) = normal.any_orthonormal_pair();
        (a * turn.cos() + b * turn.sin()) * sin2.sqrt() + normal * (1.0 - sin2).sqrt()
    }

    /// Rays by Lambert's law in random caps over foil, thrown back by film as often as its shares say, leave as much in each of six parts of the
    /// cap as the cavity says, within 4 % and four standard errors.
    #[test]
    fn caps_are_lit_as_rays_light_them() {
        let mut rng = Stream::root(64).rng();
        for _ in 0..4 {
            let cap = Cap { height: rng.random_range(1.5..3.0), radius: rng.random_range(3.2..4.5) };
            let reflectance = rng.random_range(0.6..0.95);
            let foil = Gloss { share: 1.0, reflectance, roughness: [0.1; 2], matte: 0.0 };
            let medium = Medium::isotropic(0.0, 1.0, 1.5, Gloss::NONE);
            let samples = cap.samples(medium, Medium::opaque(foil));
            let (grid, mut cells) = cells(&samples);
            // What film this thin would not do.
            let [held, out] = [rng.random_range(0.2..0.7), 0.25];
            let shares = FilmShares { turned_down: 1.0, held, out, ..FilmShares::default() };
            cells.iter_mut().for_each(|cell| cell.shares = shares);
            let cavity = Arc::new(Cavity::solve(&samples, grid, cells));
            let (from, parts) = (Vec2::new(rng.random_range(-2.0..2.0), rng.random_range(-2.0..2.0)), 6);
            let mut light = CavityLight::none(&cavity);
            light.enter(from, 1.0);
            light.spread();
            // By whole cells, so that both count the same.
            let columns = cavity.grid.cells[0];
            let part = |cell: usize| cell % columns * parts / columns;
            let mut ours = vec![0.0f32; parts];
            for (cell, leaves) in cavity.cells.iter().zip(&light.leaves) {
                ours[part(cell.number)] += leaves * cell.level;
            }
            let (rays, mut rayed) = (200_000, vec![0.0f32; parts]);
            for _ in 0..rays {
                let z = (cap.sphere().powi(2) - from.length_squared()).sqrt() + cap.middle().z;
                let mut at = from.extend(z);
                loop {
                    let (next, mirrored) = cap.meets(at, lambert((cap.middle() - at).normalize(), &mut rng));
                    if mirrored && rng.random::<f32>() > reflectance {
                        break;
                    }
                    at = next;
                    let cell = cavity.film[cavity.grid.cell(at.truncate())];
                    rayed[part(cavity.cells[usize::from(cell)].number)] += out;
                    if rng.random::<f32>() > held {
                        break;
                    }
                }
            }
            for (ours, rayed) in ours.iter().zip(&rayed) {
                let (count, rayed) = (rayed / out, rayed / rays as f32);
                assert!((ours / rayed - 1.0).abs() < 0.04 + 4.0 / count.sqrt(), "{ours} for {rayed}");
            }
        }
    }
}
