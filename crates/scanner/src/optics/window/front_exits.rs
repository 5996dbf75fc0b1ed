//! Front face of a body: light that spreads up to it from behind leaves through it, and is seen before the front edge.
//!
//! Diffusion in a quarter space whose two faces let light out (images of the source in both): of light that has spread
//! with standard deviations s along the motion and s' down, and entered a distance d behind the edge, what leaves at a
//! depth h is
//!
//! ```text
//! 2 d h / s'^2 exp(((d + e)^2 - d^2) / 2 s^2 - h^2 / 2 s'^2)
//! ```
//!
//! of what would leave a distance e before the edge if the surface went on, and the lens, aslant, sees that depth
//! there. Both lengths reach [`BEYOND_MM`] beyond the faces, as radiance does (Milne's problem). Neglected: what the
//! face takes from light that leaves through the surface behind it, a seventh within the first 0.3 mm of clear wood.
//! Light that enters less than 0.15 mm behind the edge and comes out deep; scattering that changes with depth; films,
//! whose ends are lower than a row.

use std::ops::Range;

use crate::optics::light::{CENTRE, FrontTile, ROWS, ScanLine, load};
use crate::optics::speckle::TILE;
use numerics::lanes::exp;

/// Spread down over that along the motion: of wood along the grain, 2.3 to 1 in the reference Monte Carlo, and a little
/// of what dives [1].
const DOWN_OVER_ALONG: f32 = 0.45;
/// Distances beyond a front face and the one above at which light would be gone [mm].
const BEYOND_MM: [f32; 2] = [0.5, 0.03];
/// Least spread of light: less is nothing beside the blur of any image [mm].
const LEAST_SPREAD_MM: f32 = 0.01;
/// Greatest exponent that is worked out: where it is greater, nothing would leave before the edge.
const MAX_EXPONENT: f32 = 20.0;
/// Exponent from which on nothing leaves.
const MIN_EXPONENT: f32 = -80.0;

/// Rows of a window that show a front face to one tile of a line, and what leaves there.
#[derive(Debug)]
pub(crate) struct FrontExits<'a> {
    rows: Vec<(usize, &'a FrontTile)>,
    /// Factors of one width in these rows [sqrt(1)].
    exit: Vec<[f32; TILE]>,
}

impl<'a> FrontExits<'a> {
    /// Those of the lines that a window looks at; rows behind its own line show none of its light.
    pub fn of(neighbours: &[&'a ScanLine; ROWS], start: usize) -> Self {
        let front = |k: usize| Some((k, neighbours[k].front_of(start)?));
        let rows: Vec<_> = (CENTRE + 1..ROWS).filter_map(front).collect();
        Self { exit: vec![[0.0; TILE]; rows.len()], rows }
    }

    /// Works out what width `j` of the line of `own` shows in these rows of the window.
    #[inline(always)]
    pub fn look(&mut self, j: usize, own: &ScanLine, start: usize, rows: &Range<usize>) {
        if self.rows.is_empty() {
            return;
        }
        let (variance, rows_per_mm) = (load(&own.variance, start), load(&own.spread_rows_per_mm, start));
        let spread_mm = own.spread_mm[j].max(LEAST_SPREAD_MM);
        let (own_mm, mut blur_mm2) = (own.y_mm, [0.0f32; TILE]);
        for c in 0..TILE {
            blur_mm2[c] = variance[c] / (rows_per_mm[c] * rows_per_mm[c]).max(f32::MIN_POSITIVE);
        }
        for ((_, front), exit) in self.rows.iter().zip(&mut self.exit).filter(|((k, _), _)| rows.contains(k)) {
            let FrontTile { edge_mm, before_mm, depth_mm, .. } = front;
            let mut shares = [0.0f32; TILE];
            // Worked out where there is no face too, and apart from the choice: loops with branches are not vector
            // code.
            for c in 0..TILE {
                shares[c] = share([own_mm - edge_mm[c], before_mm[c], depth_mm[c]], spread_mm, blur_mm2[c]);
            }
            let of_level = &front.exit[j];
            for c in 0..TILE {
                exit[c] = of_level[c] * if depth_mm[c] > 0.0 { shares[c] } else { 1.0 };
            }
        }
    }

    /// Factors by which that width leaves in row `k` of the window, where it shows a front face [sqrt(1)].
    #[inline(always)]
    pub fn row(&self, k: usize) -> Option<&[f32; TILE]> {
        self.rows.iter().position(|row| row.0 == k).map(|at| &self.exit[at])
    }
}

/// Light that is seen before a front edge, of that which would be if the surface went on [1]: from distances `behind`
/// the edge where it entered, `before` it and down the face [mm], and variances that light spreads and the image is
/// blurred by.
#[inline(always)]
fn share([behind, before, depth]: [f32; 3], spread_mm: f32, blur_mm2: f32) -> f32 {
    let (behind, along) = (behind.max(0.0), spread_mm * spread_mm);
    let half = [0.5 / along, 0.5 / (along * DOWN_OVER_ALONG * DOWN_OVER_ALONG)];
    let [way, from] = [behind + before, behind + BEYOND_MM[0]];
    let exponent = (way * way - from * from) * half[0] - depth * (depth + 2.0 * BEYOND_MM[1]) * half[1];
    let face = 4.0 * from * (depth + BEYOND_MM[1]) * half[1] * exp(exponent.clamp(MIN_EXPONENT, MAX_EXPONENT));
    // What left behind the edge, and is blurred to before it: the way is the sum of two normal laws. The logistic law
    // is near theirs.
    let all = along + blur_mm2;
    let deviations = (behind - way * along / all) * (all / (along * blur_mm2)).sqrt();
    let blurred = 1.0 / (1.0 + exp((-1.702 * deviations).clamp(MIN_EXPONENT, MAX_EXPONENT)));
    blurred + (1.0 - blurred) * face
}
