//! Front face of a body: light leaves a row through the surface and through the face that looks at the lens.
//!
//! Light that spreads up to a front face from behind leaves through it, and is seen about where it would leave if the
//! surface went on. Neglected: the height at which it leaves.

use procedural::Class;

use super::row::Row;
use crate::specimen::Hit;

impl Row {
    /// Lets light out where this row is bare and the `next` one is not: a body's front face looks at the lens, so light
    /// that would leave before the front edge is seen as if the surface went on. It is kept apart from what leaves here
    /// otherwise: a hole lets out what comes from behind it, and nothing of what comes from before it.
    pub(crate) fn open_front(&mut self, next: &Row) {
        let bare = |hit: &Hit| hit.matter.class == Class::Background;
        let beyond = next.front_exit.as_deref().unwrap_or(&next.exit);
        let lets = |column: usize| bare(&self.hits[column]) && beyond.iter().any(|exit| exit[column] != 0.0);
        if !(0..self.hits.len()).any(lets) {
            return;
        }
        let mut faced = Box::new(self.exit.clone());
        for column in (0..self.hits.len()).filter(|&column| lets(column)) {
            for (own, next) in faced.iter_mut().zip(beyond) {
                own[column] = next[column];
            }
        }
        self.front_exit = Some(faced);
    }
}
