//! Light along lines: three ways to find the pixels of a line, as the thesis tried them.
//!
//! From every lit pixel a line runs both ways in the direction of the map. The thesis does not say what each
//! pixel of it gets; here the light of the lit pixel is shared evenly (by coverage for smooth lines), so that nothing is
//! made; what falls off the picture is lost. Where alpha is below 1 the line is shorter in proportion, and after all lines
//! are drawn each pixel is multiplied by its alpha. A pixel without direction keeps its light.
//! Fails as the thesis shows in Figure 4.22: one line for all light of a pixel makes a box of light with hard ends, ends
//! snap to whole pixels, so neighbours of almost the same direction draw other lines and the result is streaked.

use glam::DVec2;

use super::{DirectionMap, Picture};

/// How the pixels of a line are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// y = k x, rounded, for each whole x; leaves gaps where the line is steep. A line that is too steep to leave its
    /// column is stepped along y instead: there k has no number.
    LinearEquation,
    /// Steps along the longer axis; two pixels share each step by their distance to the line along the other axis (Wu
    /// 1991). Their coverages sum to 1; scikit-image's `line_aa` measures the distance across the line instead.
    AntiAliased,
    /// Steps along the longer axis to the nearest pixel, by whole numbers (Bresenham 1965).
    Bresenham,
}

impl Rule {
    /// Pixels of a line through (0, 0) along `direction`, `reach` pixels long on either side, and the coverage of each.
    pub fn pixels(self, direction: DVec2, reach: u32) -> Vec<(i32, i32, f64)> {
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
pub(super) fn spread(picture: &Picture, map: &DirectionMap, rule: Rule, reach: u32) -> Picture {
    let mut out = Picture::dark(picture.rows, picture.cols);
    for (i, &light) in picture.light.iter().enumerate().filter(|&(_, &light)| light > 0.0) {
        let reach = (f64::from(reach) * map.alpha(i)).round() as u32;
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
