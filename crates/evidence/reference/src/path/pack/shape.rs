//! Geometry of a pack: the film's two sides and the foil as height fields, and convex solids.
//!
//! Model: heights at the nodes of a grid, bilinear between them. The film's lower side is where its thickness across it
//! takes the upper one: nodes are moved along the normal, and the moved net is laid back on the grid, its lowest sheet
//! where it folds. Where a node has no film (a hole, or beside the card) both sides meet halfway, so film ends as a
//! wedge one cell long; foil ends with the last whole cell of the card. Sealed film lies on the foil. Solids are asked
//! as they are.
//!
//! Neglected: edges cut upright, shapes finer than a cell.
//!
//! Rays go from cell to cell, as in a body of wood, and cross faces as [`BilinearPatch`] says.

use base::{BodyKind, Gloss, Medium, Surface};
use glam::{DVec2, DVec3};
use procedural::blister::{CardFilm, Pack, Solid};

use super::super::bilinear_patch::BilinearPatch;
use super::super::height_cells::HeightCells;
use super::microfacets::bottom;
use super::moved_net::lay;
use transport::line::LineSource;
use transport::stack::PIGMENT_G;

/// A little over a cell's border, so that the next direction begins beyond it [mm].
const OVER_MM: f64 = 1e-9;

/// What a pack is at one point, from above.
#[derive(Debug, Clone, Copy)]
pub(super) struct PackColumn {
    /// The film, unless there is a hole.
    pub sheet: Option<CardFilm>,
    /// The foil below.
    pub foil: (Surface, Medium),
}

/// The film's matter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FilmMatter {
    /// Refractive index [1].
    pub n: f64,
    /// Absorption [mm^-1].
    pub mu_a: f64,
    /// Scattering [mm^-1].
    pub mu_s: f64,
}

impl FilmMatter {
    /// Extinction [mm^-1].
    #[inline(always)]
    pub fn extinction(&self) -> f64 {
        self.mu_a + self.mu_s
    }
}

/// Heights at a node [mm].
#[derive(Debug, Clone, Copy, Default)]
struct PackNode {
    heights: [f64; 3],
    film: bool,
    card: bool,
    sealed: bool,
    slab: u16,
    foil: u16,
}

/// Which height field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PackFace {
    /// The film's upper side.
    Upper = 0,
    /// The film's lower side.
    Lower = 1,
    /// The foil's upper side.
    Foil = 2,
}

/// What a cell holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct PackCell {
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
pub(super) struct PackShape {
    /// Place of the first node [mm].
    pub low: DVec2,
    /// Size of cells [mm].
    pub pitch: DVec2,
    /// Cells along x and y.
    pub size: [usize; 2],
    nodes: Vec<PackNode>,
    pub cells: Vec<PackCell>,
    /// Optical depth straight through the film of each cell, apart since it is asked for most [1].
    pub depths: Vec<f32>,
    /// Highest of film and solids [mm].
    pub top: f64,
    slabs: Vec<FilmMatter>,
    metals: Vec<Gloss>,
    pub solids: Vec<Solid>,
}

impl PackShape {
    /// The region of `pack` about `line`.
    pub fn of(pack: &Pack, line: &LineSource) -> Self {
        let (low, high) = pack.bounds();
        let card = [low, high].map(|corner| corner.as_dvec3().truncate());
        Self::new(HeightCells::about(line, card), pack.solids().to_vec(), |x, y| {
            pack.slice(y).surface(x).map(|_| PackColumn { sheet: pack.sheet(x, y), foil: pack.foil(x, y) })
        })
    }

    /// What `ask` says about points (x, y) [mm] on a card, `None` beside it.
    pub fn new(grid: HeightCells, solids: Vec<Solid>, ask: impl Fn(f32, f32) -> Option<PackColumn>) -> Self {
        let HeightCells { low, pitch, size } = grid;
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
                let position = low + DVec2::new(i as f64, j as f64) * pitch;
                let column = ask(position.x as f32, position.y as f32);
                moved.push(column.and_then(|column| column.sheet).map(|sheet| {
                    let through = normal(&sheet.surface) * f64::from(sheet.thickness_mm);
                    let flat = DVec2::new(i as f64, j as f64) - DVec2::new(through.x, through.y) / pitch;
                    flat.extend(f64::from(sheet.surface.z) - through.z)
                }));
                let node = shape.node(column);
                shape.nodes.push(node);
            }
        }
        shape.close(&lay(&moved, [size[0] + 1, size[1] + 1]));
        shape
    }

    /// A node as asked, its film's lower side still missing.
    fn node(&mut self, column: Option<PackColumn>) -> PackNode {
        let Some(column) = column else { return PackNode::default() };
        let mut node = PackNode { card: true, ..PackNode::default() };
        node.heights[PackFace::Foil as usize] = f64::from(column.foil.0.z);
        node.foil = number(&mut self.metals, bottom(&column.foil.1));
        if let Some(sheet) = column.sheet {
            let (z, medium) = (f64::from(sheet.surface.z), &sheet.medium);
            let mu_s = f64::from(medium.sigma_i) / (1.0 - PIGMENT_G);
            let slab = FilmMatter { n: f64::from(medium.n_eff), mu_a: f64::from(medium.mu_a), mu_s };
            (node.film, node.sealed, node.slab) = (true, sheet.sealed, number(&mut self.slabs, slab));
            node.heights[PackFace::Upper as usize] = z;
            node.heights[PackFace::Lower as usize] = z - f64::from(sheet.thickness_mm) / normal(&sheet.surface).z;
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
            self.cells.push(PackCell {
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
            let middle = flat.extend(self.height(at, PackFace::Upper, flat.extend(0.0)));
            let normal = self.normal(at, PackFace::Upper, middle);
            let thickness = middle.z - self.height(at, PackFace::Lower, middle);
            let depth = if covered.is_some() { self.slab(at).extinction() * thickness * normal.z } else { 0.0 };
            let cell = &mut self.cells[at];
            (cell.middle, cell.normal) = (middle, normal);
            self.depths.push(depth as f32);
        }
    }

    /// A face in a cell.
    #[inline(always)]
    fn patch(&self, cell: usize, face: PackFace) -> BilinearPatch {
        let (row, face) = (self.size[0] + 1, face as usize);
        let at = cell / self.size[0] * row + cell % self.size[0];
        BilinearPatch([at, at + 1, at + row, at + row + 1].map(|node| self.nodes[node].heights[face]))
    }

    /// The cell over or under a point, if it is in the region.
    #[inline(always)]
    pub fn cell(&self, position: DVec3) -> Option<usize> {
        let local = (DVec2::new(position.x, position.y) - self.low) / self.pitch;
        let inside = local.x >= 0.0 && local.y >= 0.0 && local.x < self.size[0] as f64 && local.y < self.size[1] as f64;
        inside.then(|| local.y as usize * self.size[0] + local.x as usize)
    }

    /// Where in its cell a point lies, along x and y [cells].
    #[inline(always)]
    pub fn within(&self, cell: usize, position: DVec3) -> DVec2 {
        let corner = DVec2::new((cell % self.size[0]) as f64, (cell / self.size[0]) as f64);
        (DVec2::new(position.x, position.y) - self.low) / self.pitch - corner
    }

    /// Height of a face above a point of a cell [mm].
    #[inline]
    pub fn height(&self, cell: usize, face: PackFace, position: DVec3) -> f64 {
        let at = self.within(cell, position);
        self.patch(cell, face).height(at.x, at.y)
    }

    /// Upward normal of a face above a point of a cell.
    #[inline]
    pub fn normal(&self, cell: usize, face: PackFace, position: DVec3) -> DVec3 {
        let at = self.within(cell, position);
        self.patch(cell, face).normal(at.x, at.y, self.pitch)
    }

    /// The film's matter in a cell.
    #[inline(always)]
    pub fn slab(&self, cell: usize) -> &FilmMatter {
        &self.slabs[usize::from(self.cells[cell].slab)]
    }

    /// The foil's facets in a cell.
    #[inline(always)]
    pub fn metal(&self, cell: usize) -> &Gloss {
        &self.metals[usize::from(self.cells[cell].metal)]
    }
}

/// Where light is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PackRegion {
    /// In the air above the film.
    Above,
    /// In the film.
    Film,
    /// In the air below the film, in a hole or beside the card.
    Under,
    /// In the solid of this number.
    Solid(usize),
}

/// What ends a straight direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PackRayEnd {
    /// Its given length.
    Length,
    /// A face in this cell.
    Face(PackFace, usize),
    /// Another region, without a surface between.
    Region(PackRegion),
    /// The conveyor.
    Ground,
    /// The open sky, or the region's end in the open.
    Beyond,
    /// The region's end, in or under the film.
    Lost,
}

impl PackShape {
    /// Follows a ray outside of solids from `position` for at most `length` [mm]: how far it goes [mm], and what ends
    /// it.
    #[inline]
    pub(crate) fn march(
        &self,
        position: DVec3,
        direction: DVec3,
        region: PackRegion,
        length: f64,
    ) -> (f64, PackRayEnd) {
        let local = (DVec2::new(position.x, position.y) - self.low) / self.pitch;
        let mut cell = [local.x.floor() as i64, local.y.floor() as i64];
        let mut next: [f64; 2] = std::array::from_fn(|axis| match direction[axis] {
            0.0 => f64::INFINITY,
            along => {
                let border = (cell[axis] + i64::from(along > 0.0)) as f64 - local[axis];
                border * self.pitch[axis] / along
            }
        });
        let step: [f64; 2] = std::array::from_fn(|axis| (self.pitch[axis] / direction[axis]).abs());
        let (mut gone, mut open) = (0.0f64, false);
        loop {
            if (0..2).any(|axis| cell[axis] < 0 || cell[axis] >= self.size[axis] as i64) {
                let covered = region == PackRegion::Film || (region == PackRegion::Under && !open && gone > 0.0);
                return (gone, if covered { PackRayEnd::Lost } else { PackRayEnd::Beyond });
            }
            let number = cell[1] as usize * self.size[0] + cell[0] as usize;
            let here = &self.cells[number];
            let axis = usize::from(next[1] < next[0]);
            let end = next[axis].max(gone).min(length);
            let start = position + direction * gone;
            let far = position.z + direction.z * end;
            let (low, high) = (start.z.min(far), start.z.max(far));
            let mut stop = (end - gone, None);
            let mut meet = |face: PackFace, side: f64| {
                let at = self.within(number, start);
                let length = self.patch(number, face).crossing([at.x, at.y, start.z], direction, self.pitch, side);
                if length <= stop.0 {
                    stop = (length, Some(PackRayEnd::Face(face, number)));
                }
            };
            match region {
                PackRegion::Film => {
                    if !here.film {
                        return (gone + OVER_MM, PackRayEnd::Region(PackRegion::Under));
                    }
                    if high >= here.low[0] {
                        meet(PackFace::Upper, 1.0);
                    }
                    if low <= here.high[1] {
                        meet(PackFace::Lower, -1.0);
                    }
                }
                PackRegion::Above => {
                    if !here.film {
                        return (gone + OVER_MM, PackRayEnd::Region(PackRegion::Under));
                    }
                    if direction.z >= 0.0 && start.z > self.top {
                        return (gone, PackRayEnd::Beyond);
                    }
                    if low <= here.high[0] {
                        meet(PackFace::Upper, -1.0);
                    }
                }
                PackRegion::Under | PackRegion::Solid(_) => {
                    if here.film {
                        if open && start.z > self.height(number, PackFace::Upper, start) {
                            return (gone + OVER_MM, PackRayEnd::Region(PackRegion::Above));
                        }
                        if high >= here.low[1] {
                            meet(PackFace::Lower, 1.0);
                        }
                    } else if direction.z >= 0.0 && start.z > self.top {
                        return (gone, PackRayEnd::Beyond);
                    }
                    if here.foil {
                        if low <= here.high[2] {
                            meet(PackFace::Foil, -1.0);
                        }
                    } else if low < 0.0 && direction.z < 0.0 {
                        let down = (-start.z / direction.z).max(0.0);
                        if down <= stop.0 {
                            stop = (down, Some(PackRayEnd::Ground));
                        }
                    }
                    open = !here.film;
                }
            }
            if let (length, Some(what)) = stop {
                return (gone + length, what);
            }
            if end >= length {
                return (length, PackRayEnd::Length);
            }
            gone = end;
            cell[axis] += if direction[axis] > 0.0 { 1 } else { -1 };
            next[axis] += step[axis];
        }
    }

    /// Whether a path in the film that ends at `end` meets nothing: it ends in the cell where it began, between all
    /// that bounds the film there.
    #[inline(always)]
    pub fn stays(&self, end: DVec3, cell: usize) -> bool {
        let here = &self.cells[cell];
        let half = 0.5 * self.pitch;
        (end.x - here.middle.x).abs() < half.x
            && (end.y - here.middle.y).abs() < half.y
            && end.z > here.high[1]
            && end.z < here.low[0]
    }

    /// The next solid along a direction, but for one: its number and how far it is [mm].
    #[inline]
    pub fn solid(&self, position: DVec3, direction: DVec3, but: Option<usize>) -> Option<(usize, f64)> {
        let mut next = None;
        let (from, along) = (position.as_vec3(), direction.as_vec3());
        for (number, solid) in self.solids.iter().enumerate() {
            let (low, high) = ((solid.bounds[0] - from) / along, (solid.bounds[1] - from) / along);
            let (near, far) = (low.min(high).max_element(), low.max(high).min_element());
            if Some(number) == but || near > far || far < 0.0 || next.is_some_and(|(_, best)| f64::from(near) > best) {
                continue;
            }
            // Light that begins on or a little inside a solid it touches enters only if it goes inwards.
            if let Some([near, far]) = solid.span(from, along)
                && far > 0.0
                && (near > 0.0 || solid.normal(from).dot(along) < 0.0)
            {
                let near = f64::from(near).max(0.0);
                if next.is_none_or(|(_, best)| near < best) {
                    next = Some((number, near));
                }
            }
        }
        next
    }
}

/// Upward normal of a surface.
pub(super) fn normal(surface: &Surface) -> DVec3 {
    DVec3::new(-f64::from(surface.slope_x), -f64::from(surface.slope_y), 1.0).normalize()
}

/// The number of a value in a list without repetitions.
pub(super) fn number<T: PartialEq>(list: &mut Vec<T>, value: T) -> u16 {
    let at = list.iter().rposition(|other| *other == value).unwrap_or_else(|| {
        list.push(value);
        list.len() - 1
    });
    u16::try_from(at).unwrap_or(u16::MAX)
}
