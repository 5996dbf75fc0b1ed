//! Front face of a body, as the bare line before it shows it: where its edge is, and how deep on it the lens looks
//! there. What light leaves there is worked out where windows are drawn ([`crate::optics::window`]).

use crate::optics::light::{FrontTile, ScanLine, load};
use crate::optics::speckle::TILE;

/// Depth that stands for what is below a face [mm].
const BELOW_MM: f32 = 1e3;

impl FrontTile {
    /// A tile of `line` that shows no front face yet.
    fn new(line: &ScanLine, start: usize) -> Self {
        let none = [0.0; TILE];
        let exit = std::array::from_fn(|j| *load(&line.exit[j], start));
        Self { start, exit, edge_mm: none, before_mm: none, depth_mm: none, height_mm: none }
    }
}

impl ScanLine {
    /// Lets light out where this line is bare and the `next` one is not: a body's front face looks at the lens, which
    /// sees a depth of `depth_per_mm` a mm before the edge. It is kept apart from what leaves here otherwise: a hole
    /// lets out what comes from behind it, and nothing of what comes from before it.
    pub(crate) fn open_front(&mut self, next: &Self, depth_per_mm: f32) {
        self.front.clear();
        for (tile, bare) in self.bare.chunks(TILE).enumerate() {
            if !bare.contains(&true) {
                continue;
            }
            let start = tile * TILE;
            let behind = next.front_of(start);
            let mut opened = None;
            for column in 0..bare.len() {
                let hit = &next.hits[start + column];
                let is_bare = next.bare[start + column];
                let front = behind.filter(|front| is_bare && front.depth_mm[column] > 0.0);
                if !bare[column] || (is_bare && front.is_none()) {
                    continue;
                }
                // The edge lies between the two lines.
                let edge = front.map_or(0.5 * (self.y_mm + next.y_mm), |front| front.edge_mm[column]);
                let before = edge - self.y_mm;
                // The end of a film is lower than a row.
                let own_height = if hit.matter.film.is_some() { 0.0 } else { hit.surface.z };
                let height = front.map_or(own_height, |front| front.height_mm[column]);
                let depth = before * depth_per_mm;
                let tile = opened.get_or_insert_with(|| FrontTile::new(self, start));
                tile.edge_mm[column] = edge;
                tile.depth_mm[column] = if depth < height { depth } else { BELOW_MM };
                tile.before_mm[column] = before;
                tile.height_mm[column] = height;
                for (j, exit) in tile.exit.iter_mut().enumerate() {
                    exit[column] = front.map_or(next.exit[j][start + column], |front| front.exit[j][column]);
                }
            }
            self.front.extend(opened);
        }
    }
}
