//! Surface grid: the height of an upper surface on a regular grid, for occlusion and for where reflected light lands.
//!
//! Heights are sampled at nodes `PITCH_MM` apart and bilinear between them; rays are marched in steps of half that. A
//! surface of curvature radius R is met to PITCH^2 / (8 R), 2 um at an edge of 0.8 mm. For most points one comparison
//! answers whether the lens sees them: every node stores the height above which nothing before it blocks the view.
//! Neglected: detail finer than the grid, overhangs.

use glam::{Mat2, Vec2, Vec3};
use rayon::prelude::*;

/// Distance of nodes [mm].
const PITCH_MM: f32 = 0.1;
/// Step along a ray [mm].
const STEP_MM: f32 = 0.5 * PITCH_MM;
/// Height above a ray from which the surface blocks it; more than the error of bilinear heights [mm].
const BLOCKING_MARGIN_MM: f32 = 0.005;
/// First step of reflected light off the surface that it leaves [mm].
const FIRST_STEP_MM: f32 = 0.15;

/// Half of the reach of differences that tell how the surface is bent: whole nodes, so that what a cell's bilinear
/// heights lack is alike at all of their points and falls out.
const BEND_NODES: isize = 2;
const BEND_REACH_MM: f32 = BEND_NODES as f32 * PITCH_MM;

/// A value over the plane about a point, with its first and second derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Differences {
    /// The value [mm].
    pub value: f32,
    /// Its slope along x and y [1].
    pub slope: Vec2,
    /// Its second derivatives [mm^-1].
    pub bend: Mat2,
}

/// A point in a cell, whose numbers along x and y may lie beside the grid, and its fractions of that cell [1].
#[derive(Debug, Clone, Copy)]
struct About {
    cell: [isize; 2],
    part: Vec2,
}

/// Heights over a rectangle; the conveyor, at height 0, goes on around it.
#[derive(Debug, Clone)]
pub(crate) struct SurfaceGrid {
    /// Position of the first node [mm].
    low: Vec2,
    /// Nodes along x and along y.
    size: [usize; 2],
    /// Height of each node `[y, x]` [mm].
    z: Vec<f32>,
    /// Height from which each node sees the lens, whatever stands between `[y, x]` [mm].
    clear: Vec<f32>,
    /// The highest node [mm].
    top: f32,
    /// Thickness of the film over each node, of a surface below a film; else empty [mm].
    film: Vec<f32>,
}

impl SurfaceGrid {
    /// Heights over the box `low`..`high` [mm]: `line` fills those of a row of nodes, at scan position y and many x,
    /// and where the surface lies below `films` their thickness. `lens` is where the lens stands over y = 0 [mm].
    pub fn new(
        low: Vec3,
        high: Vec3,
        lens: Vec3,
        films: bool,
        line: impl Fn(f32, &[f32], &mut [f32], &mut [f32]) + Sync,
    ) -> Self {
        let first = Vec2::new(low.x - PITCH_MM, low.y - PITCH_MM);
        let nodes = |low: f32, high: f32| ((high - low) / PITCH_MM).ceil().max(0.0) as usize + 3;
        let size = [nodes(low.x, high.x), nodes(low.y, high.y)];
        let x: Vec<f32> = (0..size[0]).map(|i| first.x + i as f32 * PITCH_MM).collect();
        let (mut z, mut film) = (vec![0.0; size[0] * size[1]], vec![0.0; if films { size[0] * size[1] } else { 0 }]);
        let mut films: Vec<&mut [f32]> = film.chunks_mut(size[0]).collect();
        films.resize_with(size[1], Default::default);
        z.par_chunks_mut(size[0])
            .zip(films)
            .enumerate()
            .for_each(|(j, (row, film))| line(first.y + j as f32 * PITCH_MM, &x, row, film));
        let top = z.iter().copied().fold(0.0, f32::max);
        // Rays to the lens rise at least so fast along the motion, and lean at most as far along the line.
        let rise = (lens.z - top) / -lens.y;
        let wide = low.x.abs().max(high.x.abs());
        let lean = (wide / -lens.y).ceil().max(1.0) as usize;
        let mut clear = vec![f32::MIN; z.len()];
        for j in 1..size[1] {
            let before: Vec<f32> =
                (0..size[0]).map(|i| z[(j - 1) * size[0] + i].max(clear[(j - 1) * size[0] + i])).collect();
            for i in 0..size[0] {
                let beside = &before[i.saturating_sub(lean)..(i + lean + 1).min(size[0])];
                clear[j * size[0] + i] = beside.iter().copied().fold(f32::MIN, f32::max) - rise * PITCH_MM;
            }
        }
        Self { low: first, size, z, clear, top, film }
    }

    /// The cell around a point: its first node, and the point's fractions of the cell along x and y [1].
    fn cell(&self, x: f32, y: f32) -> Option<(usize, Vec2)> {
        let at = (Vec2::new(x, y) - self.low) / PITCH_MM;
        let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < (self.size[0] - 1) as f32 && at.y < (self.size[1] - 1) as f32;
        let (i, j) = (at.x as usize, at.y as usize);
        inside.then(|| (j * self.size[0] + i, at - Vec2::new(i as f32, j as f32)))
    }

    /// The cell around a point, on the grid or beside it, for [`Self::near`].
    fn about(&self, place: Vec2) -> About {
        let at = (place - self.low) / PITCH_MM;
        let cell = at.floor();
        About { cell: [cell.x as isize, cell.y as isize], part: at - cell }
    }

    /// Numbers of the corners of a cell: its first node, the next along x, then the same two along y.
    fn corners(&self, of: &[f32], node: usize) -> [f32; 4] {
        let next = node + self.size[0];
        [of[node], of[node + 1], of[next], of[next + 1]]
    }

    /// Height of the surface [mm].
    pub fn height(&self, x: f32, y: f32) -> f32 {
        self.between(&self.z, x, y)
    }

    /// Bilinear between nodes, 0 beyond them.
    fn between(&self, of: &[f32], x: f32, y: f32) -> f32 {
        self.cell(x, y).map_or(0.0, |(node, part)| self.bilinear(of, node, part))
    }

    /// Within the cell of this first node.
    #[inline(always)]
    fn bilinear(&self, of: &[f32], node: usize, part: Vec2) -> f32 {
        let [a, b, c, d] = self.corners(of, node);
        (a + (b - a) * part.x) * (1.0 - part.y) + (c + (d - c) * part.x) * part.y
    }

    /// Slope of the surface, dz/dx and dz/dy [1].
    pub fn slope(&self, x: f32, y: f32) -> Vec2 {
        let Some((node, f)) = self.cell(x, y) else { return Vec2::ZERO };
        let [a, b, c, d] = self.corners(&self.z, node);
        let along_x = (b - a) * (1.0 - f.y) + (d - c) * f.y;
        let along_y = (c - a) * (1.0 - f.x) + (d - b) * f.x;
        Vec2::new(along_x, along_y) / PITCH_MM
    }

    /// Height, slope and bend of the surface about a point, by central differences.
    pub fn bent(&self, place: Vec2) -> Differences {
        let about = self.about(place);
        let mut around = self.differences(&self.z, &about);
        let at = |i: isize, j: isize| self.near(&self.z, &about, i, j);
        let mixed = 0.25 * (at(1, 1) + at(-1, -1) - at(1, -1) - at(-1, 1)) / (BEND_REACH_MM * BEND_REACH_MM);
        (around.bend.x_axis.y, around.bend.y_axis.x) = (mixed, mixed);
        around
    }

    /// Thickness of the film over the surface about a point, and how it changes, but for its mixed derivative.
    pub fn film(&self, place: Vec2) -> Differences {
        self.differences(&self.film, &self.about(place))
    }

    /// Central differences along x and along y.
    #[inline(always)]
    fn differences(&self, of: &[f32], about: &About) -> Differences {
        let at = |i: isize, j: isize| self.near(of, about, i, j);
        let (value, [west, east, south, north]) = (at(0, 0), [at(-1, 0), at(1, 0), at(0, -1), at(0, 1)]);
        let second = Vec2::new(east + west - 2.0 * value, north + south - 2.0 * value);
        Differences {
            value,
            slope: 0.5 * Vec2::new(east - west, north - south) / BEND_REACH_MM,
            bend: Mat2::from_diagonal(second * (1.0 / (BEND_REACH_MM * BEND_REACH_MM))),
        }
    }

    /// A value beside a point, by steps of the differences; 0 beyond the nodes.
    #[inline(always)]
    fn near(&self, of: &[f32], about: &About, i: isize, j: isize) -> f32 {
        let [column, row] = [about.cell[0] + i * BEND_NODES, about.cell[1] + j * BEND_NODES];
        let [columns, rows] = self.size.map(|nodes| nodes as isize - 1);
        let inside = column >= 0 && row >= 0 && column < columns && row < rows;
        if inside { self.bilinear(of, row as usize * self.size[0] + column as usize, about.part) } else { 0.0 }
    }

    /// Whether the surface stands between `from`, a point on it, and `to` far above it [mm].
    pub fn hides(&self, from: Vec3, to: Vec3) -> bool {
        let Some((node, _)) = self.cell(from.x, from.y) else { return false };
        let next = node + self.size[0];
        let clear = [node, node + 1, next, next + 1].map(|at| self.clear[at]);
        if from.z > clear.into_iter().fold(f32::MIN, f32::max) {
            return false;
        }
        let ray = to - from;
        let step = ray * (STEP_MM / ray.truncate().length().max(1e-6));
        let steps = ((self.top - from.z) / step.z.max(1e-6)).ceil().max(0.0) as usize;
        (1..=steps).any(|i| {
            let at = from + step * i as f32;
            self.height(at.x, at.y) > at.z + BLOCKING_MARGIN_MM
        })
    }

    /// Where light that leaves `from`, a point on the surface, along the unit vector `direction` meets it again within
    /// `reach` [mm].
    pub(crate) fn first_hit(&self, from: Vec3, direction: Vec3, reach: f32) -> Option<Vec3> {
        let over = |t: f32| {
            let at = from + direction * t;
            at.z - self.height(at.x, at.y)
        };
        let (mut before, mut t) = (over(FIRST_STEP_MM).max(0.0), FIRST_STEP_MM);
        while t < reach {
            let at = from + direction * t;
            if (direction.z > 0.0 && at.z > self.top) || self.cell(at.x, at.y).is_none() {
                return None;
            }
            let air = over(t + STEP_MM);
            if air <= 0.0 {
                let part = before / (before - air).max(1e-9);
                let at = from + direction * (t + STEP_MM * part);
                return Some(Vec3::new(at.x, at.y, self.height(at.x, at.y)));
            }
            (before, t) = (air, t + STEP_MM);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    const LENS: Vec3 = Vec3::new(0.0, -173.3, 371.6);

    /// A wall of 4 mm across the motion that rises from y = 10 to 11 and falls from y = 12 to 13, on a plate of 1 mm.
    fn wall() -> SurfaceGrid {
        let height = |y: f32| 1.0 + 4.0 * ((y - 10.0).clamp(0.0, 1.0) - (y - 12.0).clamp(0.0, 1.0));
        SurfaceGrid::new(Vec3::ZERO, Vec3::new(20.0, 30.0, 5.0), LENS, false, move |y, x, row, _| {
            for (z, _) in row.iter_mut().zip(x) {
                *z = height(y);
            }
        })
    }

    /// Central differences of a quadratic surface are its derivatives, wherever in a cell; around a point beside the
    /// grid nothing is known.
    #[test]
    fn a_quadratic_surface_is_bent_as_its_derivatives_say() {
        let mut rng = base::Stream::root(65).rng();
        for _ in 0..20 {
            let [a, b, c, d, e] = std::array::from_fn(|_| rng.random_range(-0.2..0.2f32));
            let height = move |x: f32, y: f32| 5.0 + a * x + b * y + c * x * x + d * x * y + e * y * y;
            let grid = SurfaceGrid::new(Vec3::ZERO, Vec3::new(4.0, 4.0, 5.0), LENS, false, move |y, x, row, _| {
                row.iter_mut().zip(x).for_each(|(z, &x)| *z = height(x, y));
            });
            for _ in 0..50 {
                let place = Vec2::new(rng.random_range(0.3..3.7), rng.random_range(0.3..3.7));
                let Differences { value, slope, bend } = grid.bent(place);
                let right = Vec2::new(a + 2.0 * c * place.x + d * place.y, b + d * place.x + 2.0 * e * place.y);
                assert!((value - height(place.x, place.y)).abs() < 2e-3, "{value} at {place}");
                assert!(slope.distance(right) < 1e-4, "{slope} in place of {right} at {place}");
                let off = bend - Mat2::from_cols_array(&[2.0 * c, d, d, 2.0 * e]);
                assert!(off.to_cols_array().into_iter().all(|off| off.abs() < 1e-3), "{bend} at {place}");
            }
            assert_eq!(grid.bent(Vec2::splat(-9.0)), Differences { value: 0.0, slope: Vec2::ZERO, bend: Mat2::ZERO });
        }
    }

    /// The shadow of a wall ends where the straight line over its edge says, to a step, and the walls' fronts are in
    /// sight.
    #[test]
    fn what_lies_behind_a_wall_is_hidden_as_far_as_its_edge_says() {
        let field = wall();
        let hidden = |x: f32, y: f32| {
            let from = Vec3::new(x, y, field.height(x, y));
            field.hides(from, LENS + Vec3::Y * y)
        };
        // From (12, 5): the line falls by (371.6 - 1) / 173.3 for each mm until it meets the plate.
        let end = 12.0 + 4.0 * 173.3 / (371.6 - 1.0);
        for x in [2.0, 9.0, 17.0] {
            assert!(
                !hidden(x, 5.0) && !hidden(x, 10.5) && !hidden(x, 11.7) && !hidden(x, end + STEP_MM),
                "in sight at {x}"
            );
            assert!(hidden(x, 12.9) && hidden(x, 13.2) && hidden(x, end - STEP_MM), "hidden at {x}");
        }
    }

    /// A ray down at 30 degrees to the vertical lands tan(30 deg) times its height away; one that rises over the wall
    /// lands nowhere, one under its edge on its front.
    #[test]
    fn rays_land_where_straight_lines_meet_the_surface() {
        let field = wall();
        let from = Vec3::new(5.0, 11.5, 5.0);
        let direction = Vec3::new(-0.5, 0.0, -0.75f32.sqrt());
        assert!(
            field.first_hit(from, direction, 30.0).is_some_and(|at| at.distance(from) < 0.21),
            "it starts on the level top"
        );
        let from = Vec3::new(5.0, 4.0, 1.0);
        let met = field.first_hit(from, Vec3::new(0.0, 1.0, 0.3).normalize(), 30.0).expect("it meets the wall");
        // 1 + 0.3 (y - 4) = 1 + 4 (y - 10)
        assert!((met.y - 38.8 / 3.7).abs() < 2e-3 && (met.z - 1.0 - 4.0 * (met.y - 10.0)).abs() < 2e-3, "{met}");
        assert_eq!(field.first_hit(from, Vec3::new(0.0, 1.0, 0.7).normalize(), 30.0), None);
        assert_eq!(field.first_hit(from, Vec3::new(0.0, -1.0, 0.1).normalize(), 30.0), None);
    }
}
