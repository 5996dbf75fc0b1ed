//! Front face of a body: light leaves a row through the surface and through the face that looks at the lens.
//!
//! Light that spreads up to a front face from behind leaves through it, and is seen about where it would leave if the
//! surface went on. Neglected: the height at which it leaves.

use super::row::{FrontTile, Row};
use super::speckle::TILE;
use super::window::load;
use transport::kernel::BASIS;

impl Row {
    /// Lets light out where this row is bare and the `next` one is not: a body's front face looks at the lens, so light
    /// that would leave before the front edge is seen as if the surface went on. It is kept apart from what leaves here
    /// otherwise: a hole lets out what comes from behind it, and nothing of what comes from before it.
    pub(crate) fn open_front(&mut self, next: &Row) {
        self.front.clear();
        for (tile, bare) in self.bare.chunks(TILE).enumerate() {
            if !bare.contains(&true) {
                continue;
            }
            let start = tile * TILE;
            let beyond: [&[f32; TILE]; BASIS] = std::array::from_fn(|j| next.leaves(j, start, true));
            let lets = |column: &usize| bare[*column] && beyond.iter().any(|exit| exit[*column] != 0.0);
            let mut columns = (0..bare.len()).filter(lets).peekable();
            if columns.peek().is_none() {
                continue;
            }
            let mut exit = std::array::from_fn(|j| *load(&self.exit[j], start));
            for column in columns {
                for (own, next) in exit.iter_mut().zip(beyond) {
                    own[column] = next[column];
                }
            }
            self.front.push(FrontTile { start, exit });
        }
    }
}
