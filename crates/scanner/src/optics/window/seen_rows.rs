//! Seen rows: where along the motion each sensor row of a window looks, on a surface that rises and falls.
//!
//! On a level surface sensor rows look at the specimen in even steps ([`super::scan_geometry`]). A wall that faces the
//! lens takes more of them, one that looks away none: the lens looks aslant from the front, so each row shows the first
//! place from there that falls on it. Light that has spread far leaves by the film at that place, and is as bright
//! there as the way along the motion says. Surfaces are known in the scan lines that a window looks at, and straight
//! between them.
//!
//! Of a line that itself is hidden the lens sees what has crept through the film to where it looks: along the film,
//! which is longer than along the motion. What the air carries there is told elsewhere ([`super::interreflections`]).

use crate::optics::light::{CENTRE, ROWS, ScanLine, load, window_start};
use crate::optics::speckle::TILE;

/// Distance from where a level surface would be seen, from which on places are looked for [px].
const UNEVEN_PX: f32 = 1.0;

/// Where a window looks, in one tile.
#[derive(Debug)]
pub(crate) struct SeenRows {
    /// Distance along the motion from the line `[ROWS][TILE]` [mm].
    pub away_mm: [[f32; TILE]; ROWS],
    /// Row of the window whose scan line stands there `[ROWS][TILE]`.
    pub node: [[u8; TILE]; ROWS],
}

impl SeenRows {
    /// Whether rows of a body that can mirror itself are seen elsewhere than those of a level surface.
    #[inline(always)]
    pub fn are_uneven(own: &ScanLine, neighbours: &[&ScanLine; ROWS], start: usize) -> bool {
        let own_centre = load(&own.centre, start);
        own.secondary.is_some()
            && neighbours.iter().any(|line| {
                let (mut most, moved) = (0.0f32, line.moved_px - own.moved_px);
                for (centre, own) in load(&line.centre, start).iter().zip(own_centre) {
                    most = most.max((centre - own - moved).abs());
                }
                most > UNEVEN_PX
            })
    }

    /// Where the window of the line of `own` looks, if its rows do not see a level surface; `neighbours` are the lines
    /// that a row of a window each would see of one.
    #[inline(always)]
    pub fn of(own: &ScanLine, neighbours: &[&ScanLine; ROWS], start: usize) -> Option<Box<Self>> {
        if !Self::are_uneven(own, neighbours, start) {
            return None;
        }
        let own_centre = load(&own.centre, start);
        // Where in the window each of the lines is seen.
        let mut places = [[0.0f32; TILE]; ROWS];
        for (k, place) in places.iter_mut().enumerate() {
            let (centre, away) = (load(&neighbours[k].centre, start), neighbours[k].y_mm - own.y_mm);
            let moved = neighbours[k].moved_px - own.moved_px;
            for c in 0..TILE {
                place[c] = centre[c] - moved - away * own.level_rows_per_mm - window_start(own_centre[c]) as f32;
            }
        }
        let mut seen = Box::new(Self { away_mm: [[0.0; TILE]; ROWS], node: [[0; TILE]; ROWS] });
        seen.look(&places, &neighbours.map(|line| line.y_mm - own.y_mm));
        Some(seen)
    }

    /// Length of the way along the surface from the line to what each row of the window shows `[ROWS][TILE]` [mm].
    pub fn ways_mm(&self, neighbours: &[&ScanLine; ROWS], start: usize) -> Box<[[f32; TILE]; ROWS]> {
        let own_y = neighbours[CENTRE].y_mm;
        let mut ways = Box::new([[0.0f32; TILE]; ROWS]);
        let columns = neighbours[CENTRE].hits.len().saturating_sub(start).min(TILE);
        for c in 0..columns {
            let points = neighbours.map(|line| [line.y_mm - own_y, line.hits[start + c].surface.z]);
            let steps: [f32; ROWS - 1] = std::array::from_fn(|k| {
                let [along, up] = [0, 1].map(|i| points[k][i] - points[k + 1][i]);
                (along * along + up * up).sqrt()
            });
            let mut to = [0.0f32; ROWS];
            for k in CENTRE + 1..ROWS {
                to[k] = to[k - 1] + steps[k - 1];
            }
            for k in (0..CENTRE).rev() {
                to[k] = to[k + 1] + steps[k];
            }
            for (row, way) in ways.iter_mut().enumerate() {
                let node = usize::from(self.node[row][c]);
                let beyond = self.away_mm[row][c].abs() - points[node][0].abs();
                let slope = neighbours[node].hits[start + c].surface.slope_y;
                way[c] = (to[node] + beyond * (1.0 + slope * slope).sqrt()).max(0.0);
            }
        }
        ways
    }

    /// Follows lines that are seen at these `places` of the window and lie this far away, from the front to the back.
    #[inline(always)]
    fn look(&mut self, places: &[[f32; TILE]; ROWS], away_mm: &[f32; ROWS]) {
        // Rows from here on are taken.
        let mut covered = [ROWS as u8; TILE];
        for k in (0..ROWS).rev() {
            let from = (k + 1).min(ROWS - 1);
            let (before, here) = (&places[from], &places[k]);
            for c in 0..TILE {
                let first = here[c].ceil().clamp(0.0, ROWS as f32) as u8;
                // Where the nearer of the two is hidden itself, the other one stands for what is seen between them.
                let is_hidden = f32::from(covered[c]) < before[c].ceil().min(ROWS as f32);
                while covered[c] > first {
                    covered[c] -= 1;
                    let (row, step) = (usize::from(covered[c]), before[c] - here[c]);
                    let part = if step > 0.0 { ((before[c] - row as f32) / step).clamp(0.0, 1.0) } else { 1.0 };
                    self.away_mm[row][c] = away_mm[from] + (away_mm[k] - away_mm[from]) * part;
                    self.node[row][c] = if part < 0.5 && !is_hidden { from } else { k } as u8;
                }
            }
        }
        for (c, covered) in covered.into_iter().enumerate() {
            for row in 0..usize::from(covered) {
                self.away_mm[row][c] = away_mm[0];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    /// On random walks of heights: each row shows the first place from the front that falls on it, and what lies behind
    /// is hidden.
    #[test]
    fn rows_show_what_stands_first() {
        let mut rng = base::Stream::root(43).rng();
        let (rows_per_mm, mut hidden) = (5.0f32, 0);
        for _ in 0..40 {
            // A profile a row, from behind the line to before it.
            let away: [f32; ROWS] = std::array::from_fn(|k| (22.0 - k as f32) / rows_per_mm);
            let mut heights = [0.0f32; ROWS];
            for k in 1..ROWS {
                let step = if rng.random_bool(0.3) { rng.random_range(-1.5..1.5) } else { 0.0 };
                heights[k] = heights[k - 1] + step;
            }
            let at = |k: usize| 22.0 - rows_per_mm * (away[k] + 0.466 * (heights[k] - heights[22]));
            let places = std::array::from_fn(|k| [at(k); TILE]);
            let mut seen = SeenRows { away_mm: [[0.0; TILE]; ROWS], node: [[0; TILE]; ROWS] };
            seen.look(&places, &away);
            for row in 0..ROWS {
                let r = row as f32;
                // From the front: the first stretch between two profiles that comes down to this row.
                let stretch = (0..ROWS - 1).rev().find(|&k| at(k) <= r && (at(k + 1) >= r || k == ROWS - 2));
                let expected = match stretch {
                    _ if at(ROWS - 1) <= r => away[ROWS - 1],
                    None => away[0],
                    Some(k) => {
                        let part = ((at(k + 1) - r) / (at(k + 1) - at(k))).clamp(0.0, 1.0);
                        away[k + 1] + (away[k] - away[k + 1]) * part
                    }
                };
                let got = seen.away_mm[row][TILE / 2];
                assert!((got - expected).abs() < 1e-4, "row {row} shows {got} mm, not {expected}");
            }
            hidden += (0..ROWS - 1).filter(|&k| at(k) > at(k + 1)).count();
        }
        assert!(hidden > 50, "{hidden} places are hidden");
    }

    /// On walls of random slopes the way is as long as the wall is; over the edge between a wall and a card it is that
    /// of both.
    #[test]
    fn ways_follow_the_surface() {
        use crate::specimen::Hit;
        use base::{Class, Gloss, Matter, Medium, Surface};

        let mut rng = base::Stream::root(44).rng();
        for _ in 0..50 {
            let (step, wall, card) =
                (rng.random_range(0.05..0.3f32), rng.random_range(-3.0..3.0f32), rng.random_range(-0.5..0.5f32));
            let edge = CENTRE + rng.random_range(2..18usize);
            // The line stands on the wall, which ends at a node in front of it.
            let place = |k: usize| (CENTRE as f32 - k as f32) * step;
            let height = |k: usize| match k <= edge {
                true => wall * place(k),
                false => wall * place(edge) + card * (place(k) - place(edge)),
            };
            let lines: Vec<ScanLine> = (0..ROWS)
                .map(|k| {
                    let surface = Surface { z: height(k), slope_x: 0.0, slope_y: if k <= edge { wall } else { card } };
                    let matter =
                        Matter { medium: Medium::opaque(Gloss::NONE), film: None, class: Class::Clear, instance: 0 };
                    let hit = Hit { x: 0.0, surface, matter, lit: true, seen: true };
                    ScanLine { y_mm: 7.0 + place(k), hits: vec![hit; TILE], ..ScanLine::default() }
                })
                .collect();
            let neighbours: [&ScanLine; ROWS] = std::array::from_fn(|k| &lines[k]);
            let mut seen = SeenRows { away_mm: [[0.0; TILE]; ROWS], node: [[0; TILE]; ROWS] };
            for k in 0..ROWS {
                // Between nodes, on the side of the edge where the nearer one lies.
                let near = if k == edge { 0.0 } else { rng.random_range(-0.49..0.49f32) };
                (seen.away_mm[k], seen.node[k]) = ([place(k) + near * step; TILE], [k as u8; TILE]);
            }
            let ways = seen.ways_mm(&neighbours, 0);
            let [steep, flat] = [wall, card].map(|slope| (1.0 + slope * slope).sqrt());
            for k in 0..ROWS {
                let away = seen.away_mm[k][3];
                let (on_wall, beyond) = (away.max(place(edge)).abs(), (place(edge) - away).max(0.0));
                let expected = on_wall * steep + beyond * flat;
                assert!(
                    (ways[k][3] - expected).abs() < 1e-4 * expected + 1e-5,
                    "row {k}: {} mm for {expected}",
                    ways[k][3]
                );
            }
        }
    }
}
