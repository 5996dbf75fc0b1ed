//! Fit of an ellipse of equal light around a point of light.
//!
//! Model: in a belt about the ellipse, with rho the elliptical radius (1 on it), t = rho - 1 and phi the elliptical
//! angle,
//!
//! ```text
//! log I = b0 + b1 t + b2 t^2 + (b3 + b4 t) cos 2 phi + (b5 + b6 t) sin 2 phi + b7 cos phi + b8 sin phi
//! ```
//!
//! fitted to the cells' counts (poisson_fit.rs). Where b3, b5, b7 and b8 vanish the ellipse is a line of equal light;
//! what they are moves it there (Newton's steps). Moments inside a contour would weigh the core most, which is
//! elongated the other way; a fit of the contour's points would lose the counts beside them. The belt is wide enough
//! for some hundred cells, and its own change of shape with radius is in b4 and b6. Towards its edges cells count less,
//! so that none comes or goes at once while the belt moves.
//!
//! Errors of the coefficients become errors of aspect and angle. Neglected: contours that are no ellipses (what is
//! beyond the second harmonic), and the blur of a cell.

use glam::{DMat2, DVec2};

use super::poisson_fit::{Observation, PoissonFit, fit};
use transport::answer::Estimate;

/// Half width of the belt, in elliptical radii.
const BELT: f64 = 0.25;
/// Greatest number of Newton steps.
const MAX_NEWTON_STEPS: usize = 60;

/// Light per cell around a point, `[2 cells + 1, 2 cells + 1]`, row-major, rows along y.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LightMap<'a> {
    /// Light of each cell.
    pub light: &'a [f64],
    /// Cells on either side of the central one.
    pub cells: usize,
    /// Pitch of the cells [mm].
    pub cell_mm: f64,
}

/// An ellipse of equal light; vectors are (x, y).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipse {
    /// Its centre [mm].
    pub centre: DVec2,
    /// Long and short half axis [mm].
    pub half: [f64; 2],
    /// Azimuth of the long axis, from +y towards +x, in (-90, 90] [deg].
    pub angle: Estimate,
    /// Long half axis over the short one [1].
    pub aspect: Estimate,
}

impl Ellipse {
    /// Half of the diameter in direction `direction`, a unit vector [mm].
    pub fn reach(&self, direction: DVec2) -> f64 {
        1.0 / (self.frame().inverse() * direction).length()
    }

    /// Takes the unit circle to the ellipse about its own centre: columns are the half axes.
    pub fn frame(&self) -> DMat2 {
        let (x, y) = libm::sincos(self.angle.value.to_radians());
        DMat2::from_cols(self.half[0] * DVec2::new(x, y), self.half[1] * DVec2::new(-y, x))
    }
}

/// The ellipse of equal light whose half diameter in the direction of `through` is as long as `through` [mm].
///
/// `None` where the belt leaves the map, the light does not fall off, or no ellipse is found.
pub fn ellipse(map: LightMap, through: DVec2) -> Option<Ellipse> {
    let direction = through.normalize();
    let mut centre = DVec2::ZERO;
    let mut frame = DMat2::from_diagonal(DVec2::splat(through.length()));
    let mut fitted: Option<PoissonFit> = None;
    for step in 0.. {
        let rows = belt(map, centre, frame)?;
        let start = fitted.map_or_else(|| level(&rows), |fit| fit.b);
        let now = fit(&rows, start)?;
        let slope = now.b[1];
        if slope > -0.05 {
            return None;
        }
        let calm = |v: f64| (-v / slope).clamp(-0.2, 0.2);
        let (p, r, move_to) = (calm(now.b[3]), calm(now.b[5]), DVec2::new(calm(now.b[7]), calm(now.b[8])));
        if p.abs().max(r.abs()).max(move_to.length()) < 1e-6 {
            return Some(fitted_ellipse(centre, frame, &now));
        }
        if step == MAX_NEWTON_STEPS {
            return None;
        }
        centre += frame * move_to;
        frame = upright(frame * DMat2::from_cols(DVec2::new(1.0 + p, r), DVec2::new(r, 1.0 - p)));
        frame *= through.length() * (frame.inverse() * direction).length();
        fitted = Some(now);
    }
    None
}

/// Start of the fit: even light.
fn level(rows: &[Observation]) -> [f64; super::poisson_fit::TERMS] {
    let mean = rows.iter().map(|row| row.y).sum::<f64>() / rows.len() as f64;
    let mut start = [0.0; super::poisson_fit::TERMS];
    start[0] = libm::log(mean.max(1e-300));
    start
}

/// Cells about the ellipse with the terms of the model; `None` where some lie outside of the map.
fn belt(map: LightMap, centre: DVec2, frame: DMat2) -> Option<Vec<Observation>> {
    let inverse = frame.inverse();
    let rows = DVec2::new(frame.x_axis.x, frame.y_axis.x).length();
    let columns = DVec2::new(frame.x_axis.y, frame.y_axis.y).length();
    let limit = map.cells as f64 * map.cell_mm;
    let reach = DVec2::new(rows, columns) * (1.0 + BELT) + centre.abs();
    if reach.is_nan() || reach.max_element() > limit {
        return None;
    }
    let side = 2 * map.cells + 1;
    let place = |i: usize| {
        let at = |k: usize| (k as f64 - map.cells as f64) * map.cell_mm;
        inverse * (DVec2::new(at(i % side), at(i / side)) - centre)
    };
    let term = |i: usize| {
        let z = place(i);
        let rho = z.length();
        let t = rho - 1.0;
        if t.abs() >= BELT {
            return None;
        }
        let (c, s) = (z.x / rho, z.y / rho);
        let (c2, s2) = (c * c - s * s, 2.0 * c * s);
        let taper = 1.0 - (t / BELT).powi(2);
        let x = [1.0, t, t * t, c2, t * c2, s2, t * s2, c, s];
        Some(Observation { x, y: map.light[i], share: taper * taper })
    };
    let rows: Vec<Observation> = (0..side * side).filter_map(term).collect();
    let lit = rows.iter().filter(|row| row.y > 0.0).count();
    (lit > 3 * super::poisson_fit::TERMS).then_some(rows)
}

/// The same ellipse with its half axes as columns, the long one first.
fn upright(frame: DMat2) -> DMat2 {
    let m = frame * frame.transpose();
    let (sum, difference, cross) = (m.x_axis.x + m.y_axis.y, m.x_axis.x - m.y_axis.y, m.x_axis.y);
    let root = (difference * difference + 4.0 * cross * cross).sqrt();
    let (long, short) = (((sum + root) / 2.0).sqrt(), ((sum - root) / 2.0).max(0.0).sqrt());
    let turn = 0.5 * libm::atan2(2.0 * cross, difference);
    let (sin, cos) = libm::sincos(turn);
    DMat2::from_cols(long * DVec2::new(cos, sin), short * DVec2::new(-sin, cos))
}

fn fitted_ellipse(centre: DVec2, frame: DMat2, fit: &PoissonFit) -> Ellipse {
    // `frame` is upright but for the first step, in which it is a circle.
    let frame = upright(frame);
    let (long, short) = (frame.x_axis.length(), frame.y_axis.length());
    let aspect = long / short;
    let [p, r] = [fit.error[3], fit.error[5]].map(|error| (error / fit.b[1]).abs());
    let mut angle = libm::atan2(frame.x_axis.x, frame.x_axis.y).to_degrees();
    if angle <= -90.0 {
        angle += 180.0;
    } else if angle > 90.0 {
        angle -= 180.0;
    }
    // A turn by d moves the contour by d (aspect - 1 / aspect) / 2 sin 2 phi; a circle has no angle.
    let turn = 2.0 * r / (aspect - 1.0 / aspect).max(1e-12);
    Ellipse {
        centre,
        half: [long, short],
        angle: Estimate { value: angle, error: turn.to_degrees().min(90.0) },
        aspect: Estimate { value: aspect, error: 2.0 * aspect * p },
    }
}

#[cfg(test)]
mod tests;
