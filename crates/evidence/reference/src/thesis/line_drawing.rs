//! Line drawing: three ways to find the pixels of a line, as the thesis tried them.
//!
//! From every lit pixel a line runs both ways in the direction of the map. The thesis does not say what each pixel of
//! it gets; here the light of the lit pixel is shared evenly (by coverage for smooth lines), so that nothing is made;
//! what falls off the picture is lost. Where alpha is below 1 the line is shorter in proportion, and after all lines
//! are drawn each pixel is multiplied by its alpha. A pixel without direction keeps its light. Fails as the thesis
//! shows in Figure 4.22: one line for all light of a pixel makes a box of light with hard ends, ends snap to whole
//! pixels, so neighbours of almost the same direction draw other lines and the result is streaked.

use glam::DVec2;

use super::{DirectionMap, LightPicture};

/// Length of a line on either side of a lit pixel where alpha is 1 (our choice) [px].
const REACH_PX: f64 = 20.0;

/// How the pixels of a line are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineRule {
    /// y = k x, rounded, for each whole x; leaves gaps where the line is steep. A line that is too steep to leave its
    /// column is stepped along y instead: there k has no number.
    LinearEquation,
    /// Steps along the longer axis; two pixels share each step by their distance to the line along the other axis (Wu
    /// 1991). Their coverages sum to 1; scikit-image's `line_aa` measures the distance across the line instead.
    AntiAliased,
    /// Steps along the longer axis to the nearest pixel, by whole numbers (Bresenham 1965).
    Bresenham,
}

impl LineRule {
    /// Pixels of a line through (0, 0) along `direction`, `reach` pixels long on either side, and the coverage of each.
    fn pixels(self, direction: DVec2, reach: u32) -> Vec<(i32, i32, f64)> {
        let end = direction * f64::from(reach);
        let (x, y) = (end.x.round() as i32, end.y.round() as i32);
        match self {
            Self::LinearEquation if x == 0 => (-y.abs()..=y.abs()).map(|y| (0, y, 1.0)).collect(),
            Self::LinearEquation => {
                let slope = direction.y / direction.x;
                (-x.abs()..=x.abs()).map(|x| (x, (slope * f64::from(x)).round() as i32, 1.0)).collect()
            }
            Self::AntiAliased => smooth(x, y),
            Self::Bresenham => {
                let half = bresenham(x, y);
                let back = half.iter().rev().map(|&(x, y)| (-x, -y, 1.0));
                back.chain([(0, 0, 1.0)]).chain(half.iter().map(|&(x, y)| (x, y, 1.0))).collect()
            }
        }
    }
}

/// Pixels from (0, 0), which is left out, to (x, y).
fn bresenham(x: i32, y: i32) -> Vec<(i32, i32)> {
    let steep = y.abs() > x.abs();
    let (long, short) = if steep { (y, x) } else { (x, y) };
    let (n, rise) = (long.abs(), short.abs());
    // Twice n times the distance to the pixel's lower edge.
    let (mut above, mut side) = (n, 0);
    let step = |i: i32| {
        above += 2 * rise;
        if above >= 2 * n {
            above -= 2 * n;
            side += short.signum();
        }
        if steep { (side, i * long.signum()) } else { (i * long.signum(), side) }
    };
    (1..=n).map(step).collect()
}

/// Pixels from (-x, -y) to (x, y), two a step.
fn smooth(x: i32, y: i32) -> Vec<(i32, i32, f64)> {
    let steep = y.abs() > x.abs();
    let (long, short) = if steep { (y, x) } else { (x, y) };
    let slope = if long == 0 { 0.0 } else { f64::from(short) / f64::from(long) };
    let pair = |i: i32| {
        let side = slope * f64::from(i);
        let low = side.floor();
        let part = side - low;
        let place = |side: i32| if steep { (side, i) } else { (i, side) };
        [(low as i32, 1.0 - part), (low as i32 + 1, part)].map(|(side, share)| (place(side).0, place(side).1, share))
    };
    (-long.abs()..=long.abs()).flat_map(pair).filter(|&(_, _, share)| share > 0.0).collect()
}

/// `picture` with the light of each pixel spread along its line.
pub(super) fn spread(picture: &LightPicture, map: &DirectionMap, rule: LineRule) -> LightPicture {
    let mut out = LightPicture::dark(picture.rows, picture.cols);
    for (i, &light) in picture.light.iter().enumerate().filter(|&(_, &light)| light > 0.0) {
        let reach = (REACH_PX * map.alpha(i)).round() as u32;
        let line = map.direction(i).map_or(vec![(0, 0, 1.0)], |direction| rule.pixels(direction, reach));
        let share = light / line.iter().map(|&(_, _, share)| share).sum::<f64>();
        let (row, col) = ((i / picture.cols) as i64, (i % picture.cols) as i64);
        for (x, y, coverage) in line {
            let (row, col) = (row + i64::from(y), col + i64::from(x));
            if (0..picture.rows as i64).contains(&row) && (0..picture.cols as i64).contains(&col) {
                out.light[row as usize * picture.cols + col as usize] += share * coverage;
            }
        }
    }
    for (i, light) in out.light.iter_mut().enumerate() {
        *light *= map.alpha(i);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(rule: LineRule, direction: DVec2, reach: u32) -> Vec<(i32, i32)> {
        rule.pixels(direction, reach).into_iter().map(|(x, y, _)| (x, y)).collect()
    }

    /// Bresenham's pixels in all octants against the list worked out by hand for a rise of 2 in 5.
    #[test]
    fn bresenham_hits_what_was_worked_out_by_hand() {
        let half = [(1, 0), (2, 1), (3, 1), (4, 2), (5, 2)];
        for (along_x, along_y) in [(1, 1), (1, -1), (-1, 1), (-1, -1)] {
            for steep in [false, true] {
                let turn =
                    |(x, y): (i32, i32)| if steep { (along_x * y, along_y * x) } else { (along_x * x, along_y * y) };
                let (x, y) = turn((5, 2));
                let direction = DVec2::new(f64::from(x), f64::from(y)).normalize();
                let mut expected: Vec<_> = half.map(turn).into_iter().map(|(x, y)| (-x, -y)).rev().collect();
                expected.push((0, 0));
                expected.extend(half.map(turn));
                assert_eq!(places(LineRule::Bresenham, direction, 5), expected, "towards {direction}");
            }
        }
    }

    /// Smooth lines: each step's coverages sum to 1 and lie about the line, alike on both sides of the middle.
    #[test]
    fn coverage_of_smooth_lines_sums_to_one_a_step() {
        for degrees in [0.0, 13.0, 45.0, 61.0, 90.0, 118.0, 135.0, 171.0] {
            let (sin, cos) = libm::sincos(f64::to_radians(degrees));
            let direction = DVec2::new(cos, sin);
            let line = LineRule::AntiAliased.pixels(direction, 12);
            let end = (direction * 12.0).round();
            let steep = end.y.abs() > end.x.abs();
            let slope = if steep { end.x / end.y } else { end.y / end.x };
            let n = end.abs().max_element() as i32;
            for step in -n..=n {
                let of = |&(x, y, share): &(i32, i32, f64)| {
                    let (long, side) = if steep { (y, x) } else { (x, y) };
                    (long == step).then_some((f64::from(side) * share, share))
                };
                let (moment, sum) = line.iter().filter_map(of).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
                assert!((sum - 1.0).abs() < 1e-12, "{degrees} degrees, step {step}: {sum}");
                assert!((moment - slope * f64::from(step)).abs() < 1e-12, "{degrees} degrees, step {step}: {moment}");
            }
            let mirrored = |&(x, y, share): &(i32, i32, f64)| {
                line.iter().any(|&(u, v, other)| (u, v) == (-x, -y) && (other - share).abs() < 1e-12)
            };
            assert!(line.iter().all(mirrored), "{degrees} degrees: {line:?}");
        }
    }

    /// The straight equation hits the diagonal, and leaves two of three rows out where it rises by three.
    #[test]
    fn the_linear_equation_has_gaps_where_it_is_steep() {
        assert_eq!(
            places(LineRule::LinearEquation, DVec2::ONE.normalize(), 3),
            [(-2, -2), (-1, -1), (0, 0), (1, 1), (2, 2)]
        );
        let steep = DVec2::new(1.0, 3.0).normalize();
        assert_eq!(places(LineRule::LinearEquation, steep, 7), [(-2, -6), (-1, -3), (0, 0), (1, 3), (2, 6)]);
        assert_eq!(places(LineRule::Bresenham, steep, 7).len(), 15);
    }
}
