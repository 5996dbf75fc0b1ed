//! Cavities: the pockets of a pack as closed rooms, and where light that enters through a pocket's film at one place
//! leaves it again.
//!
//! A room has facets of film, of the tops of what lies in it, and of its upright sides, over foil that mirrors; they
//! send each other light from all sides ([`super::enclosure`]). Light that the film turns on its way down starts from
//! the film's lower side; light that passes straight starts from what it meets, or is spread over the film by rough
//! foil, whose lobe is a Gaussian of slopes. A room is solved once, for whatever light enters; lines that cross a
//! pocket are followed together. Neglected: which way film prefers to turn light, light that spreads within film or
//! tablets before it leaves, holes in the film, folds of the foil, and that foil mirrors less cleanly than a mirror
//! where light has been turned before.

use std::sync::{Arc, OnceLock};

use base::{Body, Relief};
use glam::{Vec2, Vec3};
use numerics::lanes::exp;
use transport::kernel::film_stack::{FACET_TURN, FilmShares};

use super::enclosure::{Enclosure, Facet, LANES, LineLight, Mirror, arrives, exchange, multiply};
use super::room::{BodyTop, Cell, CellFoil, CellGrid, FilmSample, Tops, cells, rooms};

/// Cells of the card around a pocket that its walls light.
const CARD_CELLS: usize = 5;
/// A pocket whose light is worked out once somebody asks: many a card reaches beyond what is scanned of it.
#[derive(Debug)]
pub(crate) struct Pocket {
    samples: Vec<FilmSample>,
    grid: CellGrid,
    cavity: OnceLock<Arc<Cavity>>,
}

impl Pocket {
    fn of(samples: Vec<FilmSample>) -> Self {
        let grid = CellGrid::over(&samples);
        Self { samples, grid, cavity: OnceLock::new() }
    }

    /// Its cavity, if a place lies in it.
    pub fn at(&self, place: Vec2) -> Option<&Arc<Cavity>> {
        let cavity = || self.cavity.get_or_init(|| Arc::new(Cavity::of(&self.samples)));
        self.grid.holds(place).then(cavity).filter(|cavity| cavity.holds(place))
    }
}

/// What a pocket does to light.
#[derive(Debug)]
pub(crate) struct Cavity {
    grid: CellGrid,
    /// The facet of film in each cell; beside the pocket, the nearest.
    film: Vec<u16>,
    /// Whether a cell or one beside it has film: other pockets may stand in the rest of the grid.
    near: Vec<bool>,
    cells: Vec<Cell>,
    /// Facets of film above bodies, by rising number: their bodies' tops are the sources after those of film.
    bodies: Vec<usize>,
    /// Share of straight light that entered each facet's film and that rough foil spreads over it from below,
    /// `[facet][source facet]` [1].
    lobes: Vec<f32>,
    /// Facets of film, then tops of bodies.
    room: Enclosure,
    card: Card,
}

/// The card around a pocket.
#[derive(Debug)]
struct Card {
    grid: CellGrid,
    /// Its cells beside the film, and at most one cell under that.
    cells: Vec<usize>,
    /// The facets of film that light it.
    walls: Vec<usize>,
    /// Share of the light of each of these that each of those cells receives, by its area seen from above,
    /// `[cell][facet]` [1].
    receives: Vec<f32>,
}

/// All pockets of a body.
pub(super) fn find(body: &Body) -> Vec<Pocket> {
    match body.relief() {
        Relief::Film { .. } => rooms(body).into_iter().map(Pocket::of).collect(),
        Relief::Smooth | Relief::Openings => Vec::new(),
    }
}

/// Share of straight light that entered each cell's film and that rough foil spreads over it from below, `[cell][source
/// cell]` [1].
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
    fn of(samples: &[FilmSample]) -> Self {
        let grid = CellGrid::over(samples);
        Self::solve(samples, grid, cells(samples, &grid))
    }

    /// The cavity of these samples in cells.
    fn solve(samples: &[FilmSample], grid: CellGrid, cells: Vec<Cell>) -> Self {
        let films = cells.len();
        let foil: Vec<CellFoil> = cells.iter().filter_map(|cell| cell.foil).collect();
        let mean = |value: &dyn Fn(&CellFoil) -> f32| foil.iter().map(value).sum::<f32>() / foil.len() as f32;
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
        let sides = heights.sides(&grid, &cells, mirror.z).into_iter();
        let facets: Vec<Facet> = sides.chain(film).chain(tops().map(top)).collect();
        let blocked = (!bodies.is_empty()).then_some(|a: Vec3, b: Vec3| heights.block(a, b));
        let shares = exchange(&facets, mirror, blocked);
        let room = Enclosure::of(&facets, &shares, films + bodies.len());
        let card = Card::around(&grid, &cells);
        let (film, lobes) = (nearest(&grid, &cells), lobes(&cells, mirror, grid.pitch));
        let near = near(&grid, &cells);
        Self { grid, film, near, cells, bodies, lobes, room, card }
    }

    /// Whether a place lies in the pocket, or within a cell of it.
    #[inline(always)]
    pub fn holds(&self, place: Vec2) -> bool {
        self.grid.holds(place) && self.near[self.grid.cell(place)]
    }

    /// Lets what has entered in each of at most [`LANES`] lines spread.
    fn spread(&self, lights: &mut [&mut CavityLight]) {
        let Self { cells, bodies, lobes, room, card, .. } = self;
        let films = cells.len();
        let each = |value: &dyn Fn(usize) -> f32| -> LineLight {
            std::array::from_fn(|line| if line < lights.len() { value(line) } else { 0.0 })
        };
        let entered: Vec<LineLight> = (0..films).map(|facet| each(&|line| lights[line].entered[facet])).collect();
        let mut lobe = vec![[0.0; LANES]; films];
        // A line crosses two rows of facets.
        let lit = |lines: &LineLight| lines.iter().any(|light| *light > 0.0);
        let first = entered.iter().position(lit).unwrap_or(0);
        let end = entered.iter().rposition(lit).map_or(first, |last| last + 1);
        multiply(lobes, &entered, first..end, &mut lobe);
        let film = (0..films).map(|facet| {
            let FilmShares { turned_down, straight_held, .. } = cells[facet].shares;
            std::array::from_fn(|line| turned_down * entered[facet][line] + straight_held * lobe[facet][line])
        });
        let top = |&cell: &usize| {
            let straight = |top: &BodyTop| top.part * top.shares.straight_down * top.shares.straight_below;
            let part = cells[cell].body.as_ref().map_or(0.0, straight);
            entered[cell].map(|entered| part * entered)
        };
        let sent: Vec<LineLight> = film.chain(bodies.iter().map(top)).collect();
        let arrived = room.arrives(&sent);
        let mut tops = arrived[films..].iter();
        let (leaves, below): (Vec<LineLight>, Vec<LineLight>) = cells
            .iter()
            .zip(arrived.iter().zip(&lobe))
            .map(|(cell, (arrived, lobe))| {
                let Cell { shares, level, .. } = cell;
                let on_top = cell.body.as_ref().and_then(|top| Some((top.shares.seen_below, tops.next()?)));
                // Foil shows the film's lower side.
                let foil = cell.foil.as_ref().map_or(0.0, |foil| foil.part * foil.reflectance * shares.held);
                let leaves = |line: usize| (shares.out * arrived[line] + shares.straight_out * lobe[line]) / level;
                let below = |line: usize| {
                    (on_top.map_or(0.0, |(seen, arrived)| seen * arrived[line]) + foil * arrived[line]) / level
                };
                (std::array::from_fn(leaves), std::array::from_fn(below))
            })
            .unzip();
        let on_card = card.receive(&leaves);
        for (line, light) in lights.iter_mut().enumerate() {
            let by_cell = |all: &[LineLight]| self.film.iter().map(|&facet| all[usize::from(facet)][line]).collect();
            (light.leaves, light.below) = (by_cell(&leaves), by_cell(&below));
            light.card = on_card.iter().map(|lines| lines[line]).collect();
        }
    }

    /// Cells about a place, and their shares of it; `None` beside the pocket.
    #[inline(always)]
    fn about(&self, place: Vec2) -> Option<[(usize, f32); 4]> {
        self.holds(place).then(|| self.grid.about(place))
    }
}

impl Card {
    fn around(film: &CellGrid, cells: &[Cell]) -> Self {
        let grid = CellGrid {
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
        let is_shown = |&number: &usize| grid.beside(number).any(|number| !is_film[number]);
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

    /// What each of its cells receives of what leaves each facet of film in each line, by area.
    fn receive(&self, leaves: &[LineLight]) -> Vec<LineLight> {
        let walls: Vec<LineLight> = self.walls.iter().map(|&wall| leaves[wall]).collect();
        let mut received = vec![[0.0; LANES]; self.cells.len()];
        multiply(&self.receives, &walls, 0..walls.len(), &mut received);
        let mut all = vec![[0.0; LANES]; self.grid.cells[0] * self.grid.cells[1]];
        self.cells.iter().zip(received).for_each(|(&cell, light)| all[cell] = light);
        all
    }
}

/// The facet of film nearest to each cell.
fn nearest(grid: &CellGrid, cells: &[Cell]) -> Vec<u16> {
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
fn near(grid: &CellGrid, cells: &[Cell]) -> Vec<bool> {
    let mut near = vec![false; grid.cells[0] * grid.cells[1]];
    cells.iter().flat_map(|cell| grid.beside(cell.number)).for_each(|number| near[number] = true);
    near
}

/// Light of one line in a cavity.
#[derive(Debug, Clone)]
pub(crate) struct CavityLight {
    cavity: Arc<Cavity>,
    /// What entered the film at each facet, times length of the line [e- mm].
    entered: Vec<f32>,
    /// What leaves the film of each cell turned, by area seen from above [e-/mm].
    leaves: Vec<f32>,
    /// What lies below it throws up again of what the film has thrown down [e-/mm].
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
        for (cell, share) in self.cavity.about(place).into_iter().flatten() {
            self.entered[usize::from(self.cavity.film[cell])] += share * light;
        }
    }

    /// Lets what has entered spread, lines of a cavity together.
    pub fn spread(mut lights: Vec<&mut Self>) {
        while let Some(first) = lights.last() {
            let cavity = first.cavity.clone();
            let (mut together, mut others) = (Vec::new(), Vec::new());
            for light in lights {
                let of = if light.is_of(&cavity) && together.len() < LANES { &mut together } else { &mut others };
                of.push(light);
            }
            cavity.spread(&mut together);
            lights = others;
        }
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

#[inline(always)]
fn mean(values: &[f32], about: [(usize, f32); 4]) -> f32 {
    about.iter().map(|&(at, share)| share * values[at]).sum()
}

#[cfg(test)]
mod tests {
    use base::{Film, Gloss, Medium, Stream, Surface};
    use rand::{Rng, RngExt};

    use super::super::room::SAMPLE_MM;
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
        fn samples(&self, medium: Medium, under: Medium) -> Vec<FilmSample> {
            let count = (2.0 * self.radius / SAMPLE_MM) as usize + 1;
            let at = |n: usize| (n as f32 - 0.5 * (count - 1) as f32) * SAMPLE_MM;
            let places = (0..count * count).map(|n| Vec2::new(at(n % count), at(n / count)));
            let sample = |place: Vec2| {
                let z = (self.sphere().powi(2) - place.length_squared()).sqrt();
                let surface = Surface { z: z + self.middle().z, slope_x: -place.x / z, slope_y: -place.y / z };
                let (gap_mm, under_slope) = (Some(surface.z), [0.0; 2]);
                let film = Film { thickness_mm: 1e-6, gap_mm, room_mm: [self.radius; 2], under, under_slope };
                FilmSample { place, surface, medium, film }
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
        let aslant: Vec<FilmSample> =
            samples.into_iter().filter(|sample| (sample.place.x - sample.place.y).abs() < 1.5).collect();
        let cavity = Cavity::of(&aslant);
        assert!(aslant.iter().all(|sample| cavity.holds(sample.place)));
        assert!(cavity.grid.holds(Vec2::new(2.5, -2.5)) && !cavity.holds(Vec2::new(2.5, -2.5)));
        let mut light = CavityLight::none(&Arc::new(cavity));
        light.enter(Vec2::new(2.5, -2.5), 1.0);
        CavityLight::spread(vec![&mut light]);
        assert!(light.leaves.iter().all(|&leaves| leaves == 0.0));
    }

    /// A unit vector by Lambert's law about a normal.
    fn lambert(normal: Vec3, rng: &mut impl Rng) -> Vec3 {
        let (turn, sin2) = (std::f32::consts::TAU * rng.random::<f32>(), rng.random::<f32>());
        let (a, b) = normal.any_orthonormal_pair();
        (a * turn.cos() + b * turn.sin()) * sin2.sqrt() + normal * (1.0 - sin2).sqrt()
    }

    /// Rays by Lambert's law in random caps over foil, thrown back by film as often as its shares say, leave as much in
    /// each of six parts of the cap as the cavity says, within 4 % and four standard errors.
    #[test]
    fn caps_are_lit_as_rays_light_them() {
        let mut rng = Stream::root(64).rng();
        for _ in 0..4 {
            let cap = Cap { height: rng.random_range(1.5..3.0), radius: rng.random_range(3.2..4.5) };
            let reflectance = rng.random_range(0.6..0.95);
            let foil = Gloss { share: 1.0, reflectance, roughness: [0.1; 2], matte: 0.0 };
            let medium = Medium::isotropic(0.0, 1.0, 1.5, Gloss::NONE);
            let samples = cap.samples(medium, Medium::opaque(foil));
            let grid = CellGrid::over(&samples);
            let mut cells = cells(&samples, &grid);
            // What film this thin would not do.
            let [held, out] = [rng.random_range(0.2..0.7), 0.25];
            let shares = FilmShares { turned_down: 1.0, held, out, ..FilmShares::default() };
            cells.iter_mut().for_each(|cell| cell.shares = shares);
            let cavity = Arc::new(Cavity::solve(&samples, grid, cells));
            let (from, parts) = (Vec2::new(rng.random_range(-2.0..2.0), rng.random_range(-2.0..2.0)), 6);
            let mut light = CavityLight::none(&cavity);
            light.enter(from, 1.0);
            CavityLight::spread(vec![&mut light]);
            // By whole cells, so that both count the same.
            let columns = cavity.grid.cells[0];
            let part = |cell: usize| cell % columns * parts / columns;
            let mut ours = vec![0.0f32; parts];
            for cell in &cavity.cells {
                ours[part(cell.number)] += light.leaves[cell.number] * cell.level;
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
