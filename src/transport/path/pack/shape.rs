//! The shape of a pack as light meets it: the film's two sides and the foil as height fields, and convex solids.
//!
//! Model: heights at the nodes of a grid, bilinear between them. The film's lower side is where its thickness across it
//! takes the upper one: nodes are moved along the normal, and the moved net is laid back on the grid, its lowest sheet
//! where it folds. Where a node has no film (a hole, or beside the card) both sides meet halfway, so film ends as a
//! wedge one cell long; foil ends with the last whole cell of the card. Sealed film lies on the foil. Solids are asked
//! as they are.
//!
//! Neglected: edges cut upright, shapes finer than a cell.

use glam::{DVec2, DVec3};
use procedural::Gloss;
use procedural::blister::{Pack, Solid};

use super::facets::bottom;
use super::raster::lay;
use super::spot::{Slab, Spot, normal, number};
use crate::transport::line::LineSource;
use crate::transport::path::film::PIGMENT_G;

/// Cells are as near to this size as divides the card evenly [mm].
const PITCH_MM: f64 = 0.1;
/// The region goes on so far beyond the line's rows and columns [mm].
const REACH_MM: f64 = 20.0;

/// Heights at a node [mm].
#[derive(Debug, Clone, Copy, Default)]
struct Node {
    heights: [f64; 3],
    film: bool,
    card: bool,
    sealed: bool,
    slab: u16,
    foil: u16,
}

/// Which height field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Face {
    /// The film's upper side.
    Upper = 0,
    /// The film's lower side.
    Lower = 1,
    /// The foil's upper side.
    Foil = 2,
}

/// What a cell holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// Lowest node of each face [mm].
    pub low: [f64; 3],
    /// Highest node of each face [mm].
    pub high: [f64; 3],
    /// Whether there is film in it.
    pub film: bool,
    /// Whether there is foil in it.
    pub foil: bool,
    /// Whether film and foil are one there.
    pub sealed: bool,
    /// Normal of the film's upper side in its middle.
    pub normal: DVec3,
    /// Middle of the film's upper side [mm].
    pub middle: DVec3,
    slab: u16,
    metal: u16,
}

/// A pack about a line of light.
#[derive(Debug)]
pub(super) struct Shape {
    /// Place of the first node [mm].
    pub low: DVec2,
    /// Size of cells [mm].
    pub pitch: DVec2,
    /// Cells along x and y.
    pub size: [usize; 2],
    nodes: Vec<Node>,
    pub cells: Vec<Cell>,
    /// Optical depth straight through the film of each cell, apart since it is asked for most [1].
    pub depths: Vec<f32>,
    /// Highest of film and solids [mm].
    pub top: f64,
    slabs: Vec<Slab>,
    metals: Vec<Gloss>,
    pub solids: Vec<Solid>,
}

impl Shape {
    /// The region of `pack` about `line`.
    pub fn of(pack: &Pack, line: &LineSource) -> Self {
        let (low, high) = pack.bounds();
        let card = [[low.x, low.y], [high.x, high.y]].map(|end| DVec2::new(f64::from(end[0]), f64::from(end[1])));
        let ends = [line.x.first(), line.x.last()].map(|x| f64::from(x.copied().unwrap_or(0.0)));
        let rows = line.row_mm * (line.rows as f64 + 0.5);
        let region = [DVec2::new(ends[0], line.y - rows) - REACH_MM, DVec2::new(ends[1], line.y + rows) + REACH_MM];
        Self::new(card, region, pack.solids().to_vec(), |x, y| {
            pack.slice(y).surface(x).map(|_| Spot { sheet: pack.sheet(x, y), foil: pack.foil(x, y) })
        })
    }

    /// What `ask` says about places (x, y) [mm] on a card, `None` beside it, within a region; both by their low and high
    /// corners [mm].
    pub fn new(
        card: [DVec2; 2],
        region: [DVec2; 2],
        solids: Vec<Solid>,
        ask: impl Fn(f32, f32) -> Option<Spot>,
    ) -> Self {
        let count = ((card[1] - card[0]) / PITCH_MM).round().max(DVec2::ONE);
        let pitch = (card[1] - card[0]) / count;
        // One node beyond the card on each side closes it.
        let node = |v: DVec2| ((v - card[0]) / pitch).floor().clamp(DVec2::NEG_ONE, count);
        let (first, last) = (node(region[0]), node(region[1]));
        let size = (last - first).max(DVec2::ONE);
        let low = card[0] + (first + 0.5) * pitch;
        let size = [size.x as usize, size.y as usize];
        let mut shape = Self {
            low,
            pitch,
            size,
            nodes: Vec::with_capacity((size[0] + 1) * (size[1] + 1)),
            cells: Vec::with_capacity(size[0] * size[1]),
            depths: Vec::with_capacity(size[0] * size[1]),
            top: solids.iter().map(|solid| f64::from(solid.bounds[1].z)).fold(0.0, f64::max),
            slabs: Vec::new(),
            metals: Vec::new(),
            solids,
        };
        // Where each node of the upper side goes through the film [cells].
        let mut moved = Vec::with_capacity(shape.nodes.capacity());
        for j in 0..=size[1] {
            for i in 0..=size[0] {
                let place = low + DVec2::new(i as f64, j as f64) * pitch;
                let spot = ask(place.x as f32, place.y as f32);
                moved.push(spot.and_then(|spot| spot.sheet).map(|sheet| {
                    let through = normal(&sheet.surface) * f64::from(sheet.thickness_mm);
                    let flat = DVec2::new(i as f64, j as f64) - DVec2::new(through.x, through.y) / pitch;
                    flat.extend(f64::from(sheet.surface.z) - through.z)
                }));
                let node = shape.node(spot);
                shape.nodes.push(node);
            }
        }
        shape.close(&lay(&moved, [size[0] + 1, size[1] + 1]));
        shape
    }

    /// A node as asked, its film's lower side still missing.
    fn node(&mut self, spot: Option<Spot>) -> Node {
        let Some(spot) = spot else { return Node::default() };
        let mut node = Node { card: true, ..Node::default() };
        node.heights[Face::Foil as usize] = f64::from(spot.foil.0.z);
        node.foil = number(&mut self.metals, bottom(&spot.foil.1));
        if let Some(sheet) = spot.sheet {
            let (z, medium) = (f64::from(sheet.surface.z), &sheet.medium);
            let mu_s = f64::from(medium.sigma_i) / (1.0 - PIGMENT_G);
            let slab = Slab { n: f64::from(medium.n_eff), mu_a: f64::from(medium.mu_a), mu_s };
            (node.film, node.sealed, node.slab) = (true, sheet.sealed, number(&mut self.slabs, slab));
            node.heights[Face::Upper as usize] = z;
            node.heights[Face::Lower as usize] = z - f64::from(sheet.thickness_mm) / normal(&sheet.surface).z;
            self.top = self.top.max(z);
        }
        node
    }

    /// Puts the film's lower side in, joins what meets, and sums up cells.
    fn close(&mut self, lower: &[f64]) {
        let row = self.size[0] + 1;
        let rows = self.nodes.len() / row;
        for at in 0..self.nodes.len() {
            let node = &mut self.nodes[at];
            if node.film {
                if lower[at].is_finite() {
                    node.heights[1] = lower[at].min(node.heights[0]);
                }
                node.heights[2] = if node.sealed { node.heights[1] } else { node.heights[2].min(node.heights[1]) };
                continue;
            }
            let (i, j) = (at % row, at / row);
            let (mut sum, mut count) = (0.0, 0.0);
            for y in j.saturating_sub(1)..=(j + 1).min(rows - 1) {
                for x in i.saturating_sub(1)..=(i + 1).min(row - 1) {
                    let other = &self.nodes[y * row + x];
                    if other.film {
                        sum += 0.5 * (other.heights[0] + other.heights[1]);
                        count += 1.0;
                    }
                }
            }
            let middle = if count > 0.0 { sum / count } else { 0.0 };
            let node = &mut self.nodes[at];
            (node.heights[0], node.heights[1]) = (middle, middle);
            node.heights[2] = if count > 0.0 { node.heights[2].min(middle) } else { node.heights[2] };
        }
        for at in 0..self.size[0] * self.size[1] {
            let corner = at / self.size[0] * row + at % self.size[0];
            let nodes = [corner, corner + 1, corner + row, corner + row + 1].map(|node| self.nodes[node]);
            let of = |pick: fn(f64, f64) -> f64| {
                std::array::from_fn(|face| nodes.iter().map(|node| node.heights[face]).reduce(pick).unwrap_or(0.0))
            };
            let covered = nodes.iter().find(|node| node.film);
            self.cells.push(Cell {
                low: of(f64::min),
                high: of(f64::max),
                film: covered.is_some(),
                foil: nodes.iter().all(|node| node.card),
                sealed: covered.is_some() && nodes.iter().all(|node| node.sealed || !node.film),
                normal: DVec3::Z,
                middle: DVec3::ZERO,
                slab: covered.map_or(0, |node| node.slab),
                metal: nodes[0].foil,
            });
            let flat =
                self.low + (DVec2::new((at % self.size[0]) as f64, (at / self.size[0]) as f64) + 0.5) * self.pitch;
            let middle = flat.extend(self.height(at, Face::Upper, flat.extend(0.0)));
            let normal = self.normal(at, Face::Upper, middle);
            let thickness = middle.z - self.height(at, Face::Lower, middle);
            let depth = if covered.is_some() { self.slab(at).extinction() * thickness * normal.z } else { 0.0 };
            let cell = &mut self.cells[at];
            (cell.middle, cell.normal) = (middle, normal);
            self.depths.push(depth as f32);
        }
    }

    /// Heights of a cell's nodes: at its low corner, along x, along y, opposite [mm].
    #[inline(always)]
    pub fn corners(&self, cell: usize, face: Face) -> [f64; 4] {
        let (row, face) = (self.size[0] + 1, face as usize);
        let at = cell / self.size[0] * row + cell % self.size[0];
        [at, at + 1, at + row, at + row + 1].map(|node| self.nodes[node].heights[face])
    }

    /// The cell over or under a place, if it is in the region.
    #[inline(always)]
    pub fn cell(&self, place: DVec3) -> Option<usize> {
        let local = (DVec2::new(place.x, place.y) - self.low) / self.pitch;
        let inside = local.x >= 0.0 && local.y >= 0.0 && local.x < self.size[0] as f64 && local.y < self.size[1] as f64;
        inside.then(|| local.y as usize * self.size[0] + local.x as usize)
    }

    /// Part of the way through its cell that a place is, along x and y.
    #[inline(always)]
    pub fn within(&self, cell: usize, place: DVec3) -> DVec2 {
        let corner = DVec2::new((cell % self.size[0]) as f64, (cell / self.size[0]) as f64);
        (DVec2::new(place.x, place.y) - self.low) / self.pitch - corner
    }

    /// Height of a face above a place of a cell [mm].
    #[inline]
    pub fn height(&self, cell: usize, face: Face, place: DVec3) -> f64 {
        let [h, x, y, xy] = self.corners(cell, face);
        let at = self.within(cell, place);
        h + (x - h) * at.x + (y - h) * at.y + (h + xy - x - y) * at.x * at.y
    }

    /// Upward normal of a face above a place of a cell.
    #[inline]
    pub fn normal(&self, cell: usize, face: Face, place: DVec3) -> DVec3 {
        let [h, x, y, xy] = self.corners(cell, face);
        let (at, twist) = (self.within(cell, place), h + xy - x - y);
        DVec3::new(-((x - h) + twist * at.y) / self.pitch.x, -((y - h) + twist * at.x) / self.pitch.y, 1.0).normalize()
    }

    /// The film's matter in a cell.
    #[inline(always)]
    pub fn slab(&self, cell: usize) -> &Slab {
        &self.slabs[usize::from(self.cells[cell].slab)]
    }

    /// The foil's facets in a cell.
    #[inline(always)]
    pub fn metal(&self, cell: usize) -> &Gloss {
        &self.metals[usize::from(self.cells[cell].metal)]
    }
}
