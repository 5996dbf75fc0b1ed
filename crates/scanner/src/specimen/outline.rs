//! Outline of a body as it is seen from above: its convex hull in the plane of the conveyor, and how much of it a field
//! holds.
//!
//! The hull is the monotone chain of Andrew (1979), cut to the field edge by edge after Sutherland and Hodgman (1974);
//! areas are exact but for rounding. Neglected: bays and holes, which a convex outline covers.

use glam::Vec3;

/// A convex polygon, counter-clockwise; fewer than three corners where the body has no extent.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct ConvexOutline(Vec<[f64; 2]>);

impl ConvexOutline {
    /// Around points seen from above [mm].
    pub(crate) fn around(points: &[Vec3]) -> Self {
        let mut points: Vec<[f64; 2]> = points.iter().map(|p| [f64::from(p.x), f64::from(p.y)]).collect();
        points.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        points.dedup();
        let chain = |points: &mut dyn Iterator<Item = &[f64; 2]>| {
            let mut chain: Vec<[f64; 2]> = Vec::new();
            for &point in points {
                while let [.., a, b] = chain[..]
                    && turn(a, b, point) <= 0.0
                {
                    chain.pop();
                }
                chain.push(point);
            }
            // Its last corner is the first of the other chain.
            chain.pop();
            chain
        };
        let (mut lower, upper) = (chain(&mut points.iter()), chain(&mut points.iter().rev()));
        lower.extend(upper);
        Self(lower)
    }

    /// Share of the area that lies within a field [mm]; NaN where there is no area.
    pub(crate) fn share_within(&self, x: [f64; 2], y: [f64; 2]) -> f64 {
        let mut cut = self.0.clone();
        for (axis, [low, high]) in [x, y].into_iter().enumerate() {
            cut = keep(&cut, axis, |at| at - low);
            cut = keep(&cut, axis, |at| high - at);
        }
        (area(&cut) / area(&self.0)).clamp(0.0, 1.0)
    }
}

/// Twice the area of the triangle a, b, c: positive where it turns left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Area of a polygon [mm^2].
fn area(corners: &[[f64; 2]]) -> f64 {
    let Some(&first) = corners.first() else { return 0.0 };
    corners.windows(2).map(|pair| 0.5 * turn(first, pair[0], pair[1])).sum()
}

/// The part of a polygon on which `inside` of a coordinate is not negative.
fn keep(corners: &[[f64; 2]], axis: usize, inside: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let mut kept = Vec::new();
    let Some(mut from) = corners.last().copied() else { return kept };
    for &to in corners {
        let [before, behind] = [from, to].map(|corner| inside(corner[axis]));
        if (before < 0.0) != (behind < 0.0) {
            let share = before / (before - behind);
            kept.push([0, 1].map(|i| from[i] + share * (to[i] - from[i])));
        }
        if behind >= 0.0 {
            kept.push(to);
        }
        from = to;
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(width: f32, length: f32) -> Vec<Vec3> {
        let corners = [(0.0, 0.0), (width, 0.0), (width, length), (0.0, length)];
        // A corner twice, one inside, and heights that do not matter.
        let others = [Vec3::new(0.3 * width, 0.6 * length, 9.0), Vec3::new(0.0, 0.0, 5.0)];
        corners.map(|(x, y)| Vec3::new(x, y, 1.0)).into_iter().chain(others).collect()
    }

    #[test]
    fn shares_of_a_rectangle() {
        let card = ConvexOutline::around(&rectangle(40.0, 130.0));
        assert_eq!(card.0.len(), 4);
        assert_eq!(card.share_within([-100.0, 100.0], [-10.0, 200.0]), 1.0);
        assert_eq!(card.share_within([-100.0, 100.0], [-5.0, 65.0]), 0.5);
        assert!((card.share_within([30.0, 50.0], [0.0, 13.0]) - 0.025).abs() < 1e-12);
        assert_eq!(card.share_within([41.0, 50.0], [0.0, 13.0]), 0.0);
        assert_eq!(card.share_within([-300.0, -200.0], [0.0, 130.0]), 0.0);
    }

    /// A square on its corner, of which a field from its middle on holds half, and a field beside the middle a
    /// triangle.
    #[test]
    fn shares_of_a_square_on_its_corner() {
        let corners = [(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)].map(|(x, y)| Vec3::new(x, y, 0.0));
        let square = ConvexOutline::around(&corners);
        assert!((square.share_within([0.0, 9.0], [-9.0, 9.0]) - 0.5).abs() < 1e-12);
        assert!((square.share_within([0.5, 9.0], [-9.0, 9.0]) - 0.125).abs() < 1e-12);
    }

    #[test]
    fn without_extent_there_is_no_share() {
        for points in [&[][..], &[Vec3::ONE], &[Vec3::ONE, Vec3::ZERO]] {
            assert!(ConvexOutline::around(points).share_within([-1.0, 1.0], [-1.0, 1.0]).is_nan(), "{points:?}");
        }
    }
}
