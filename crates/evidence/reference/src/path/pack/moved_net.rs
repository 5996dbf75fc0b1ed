//! A net of moved nodes laid back on its grid.

use glam::{DVec2, DVec3};

/// Heights on a grid of `size` nodes of the net whose nodes have moved to `moved` (x and y in cells): linear within
/// half squares, the lowest where the net folds, infinite where it does not reach.
pub(super) fn lay(moved: &[Option<DVec3>], size: [usize; 2]) -> Vec<f64> {
    let mut heights = vec![f64::INFINITY; size[0] * size[1]];
    for j in 1..size[1] {
        for i in 1..size[0] {
            let at = j * size[0] + i;
            let square = [at - size[0] - 1, at - size[0], at - 1, at].map(|node| moved[node]);
            for half in [[0, 1, 2], [3, 2, 1]] {
                if let [Some(a), Some(b), Some(c)] = half.map(|corner| square[corner]) {
                    lay_triangle([a, b, c], size, &mut heights);
                }
            }
        }
    }
    heights
}

fn lay_triangle([a, b, c]: [DVec3; 3], size: [usize; 2], heights: &mut [f64]) {
    let (u, v) = ((b - a).truncate(), (c - a).truncate());
    let area = u.perp_dot(v);
    if area == 0.0 {
        return;
    }
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let (first, last) = (low.ceil().max(DVec3::ZERO), high.floor());
    for j in first.y as usize..=(last.y.max(-1.0) + 1.0) as usize {
        for i in first.x as usize..=(last.x.max(-1.0) + 1.0) as usize {
            if i >= size[0] || j >= size[1] {
                continue;
            }
            let position = DVec2::new(i as f64, j as f64) - a.truncate();
            let (s, t) = (position.perp_dot(v) / area, u.perp_dot(position) / area);
            // Nodes on a seam belong to both sides.
            if s >= -1e-9 && t >= -1e-9 && s + t <= 1.0 + 2e-9 {
                let height = a.z + s * (b.z - a.z) + t * (c.z - a.z);
                let own = &mut heights[j * size[0] + i];
                *own = own.min(height);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball's upper half moved inwards is a smaller ball, a steep plane a lower one.
    #[test]
    fn moved_surfaces_are_parallel() {
        let size = [121, 121];
        let ball = |radius: f64, x: f64, y: f64| (radius * radius - x * x - y * y).sqrt();
        let (mut moved, mut slope) = (Vec::new(), Vec::new());
        for node in 0..size[0] * size[1] {
            let (i, j) = ((node % size[0]) as f64, (node / size[0]) as f64);
            let (x, y) = ((i - 60.0) * 0.1, (j - 60.0) * 0.1);
            let inside = x.abs().max(y.abs()) < 5.0;
            moved.push(inside.then(|| {
                let up = DVec3::new(x, y, ball(10.0, x, y)) / 10.0;
                DVec3::new(i - 2.0 * up.x, j - 2.0 * up.y, 9.8 * up.z)
            }));
            let up = DVec3::new(-4.0, 0.0, 1.0).normalize();
            slope.push(Some(DVec3::new(i - 2.0 * up.x, j - 2.0 * up.y, 4.0 * x - 0.2 * up.z)));
        }
        let (inner, lower) = (lay(&moved, size), lay(&slope, size));
        for node in 0..size[0] * size[1] {
            let (x, y) = ((node % size[0]) as f64 * 0.1 - 6.0, (node / size[0]) as f64 * 0.1 - 6.0);
            if x.abs().max(y.abs()) < 4.7 {
                assert!((inner[node] - ball(9.8, x, y)).abs() < 4e-4, "{x} {y}: {}", inner[node]);
                assert!((lower[node] - (4.0 * x - 0.2 * 17f64.sqrt())).abs() < 1e-6, "{x} {y}: {}", lower[node]);
            }
        }
    }
}
