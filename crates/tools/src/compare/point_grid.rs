//! Points of a scan on a grid of columns and profiles. Three ways, the first that applies:
//!
//! - **stored profile by profile** (the file or the user says how many columns): points keep their order, missing ones
//!   too, and nothing moves. Pitches are the medians of steps between neighbours where they are not stated.
//! - **a stated pitch**: each point goes to the nearest place of a grid that begins at the least x and y.
//! - **an even grid**: the pitch is found. Places along an axis have to lie within a twentieth of a pitch of one grid.
//!
//! In the second and third way the grid reaches as far as points with heights do, places without a point are missing
//! heights, and of several points in a place the first of the file counts; more than a hundredth lost in this way is a
//! fault. Rows of uneven x that are put on an even grid move by up to half a pitch, which roughens slopes: where
//! profiles are stored in order, say so.

use super::map_numbers::MAX_PIXELS;

/// Largest share of points that may fall on a place that is taken [1].
const MAX_LOST_SHARE: f64 = 0.01;
/// Largest deviation from an even grid [pitches].
const MAX_UNEVEN: f64 = 0.05;
/// Places that are nearer are one, as a share of the extent: rounding of single precision.
const SAME_PLACE: f64 = 1e-6;
/// Most steps of which the median is taken.
const MAX_STEPS: usize = 100_000;

/// Points that are put in order.
pub(super) struct PointGrid {
    /// Columns.
    pub(super) cols: usize,
    /// Profiles.
    pub(super) rows: usize,
    /// Which point stands at a place `[rows, cols]`, row-major; `None` where none does.
    pub(super) points: Vec<Option<u32>>,
    /// Distance between columns and between profiles, where there are two [mm].
    pub(super) pitch_mm: [Option<f64>; 2],
    /// x of column 0, where columns are evenly apart [mm].
    pub(super) first_mm: Option<f64>,
}

/// Points of whole profiles, in order; z is NaN where missing. `stated` are pitches that the user gives [mm].
pub(super) fn stored_in_order(places: &[[f64; 3]], cols: usize, stated: [Option<f64>; 2]) -> Result<PointGrid, String> {
    if cols == 0 || places.is_empty() || !places.len().is_multiple_of(cols) {
        return Err(format!("its {} points are no whole profiles of {cols} columns", places.len()));
    }
    let median = |axis: usize, step: usize| {
        let pairs = (0..places.len().saturating_sub(step)).filter(|i| axis == 1 || (i + 1) % cols != 0);
        let steps = pairs.map(|i| (places[i + step][axis] - places[i][axis]).abs()).filter(|mm| mm.is_finite());
        let mut steps: Vec<f64> = steps.take(MAX_STEPS).collect();
        let middle = steps.len() / 2;
        (!steps.is_empty()).then(|| *steps.select_nth_unstable_by(middle, f64::total_cmp).1).filter(|mm| *mm > 0.0)
    };
    Ok(PointGrid {
        cols,
        rows: places.len() / cols,
        points: (0..places.len()).map(|i| u32::try_from(i).ok()).collect(),
        pitch_mm: [stated[0].or_else(|| median(0, 1)), stated[1].or_else(|| median(1, cols))],
        first_mm: None,
    })
}

/// Points in any order; z is NaN where missing. `stated` are pitches that the user gives [mm].
pub(super) fn on_grid(places: &[[f64; 3]], stated: [Option<f64>; 2]) -> Result<PointGrid, String> {
    let with_height = || places.iter().enumerate().filter(|(_, place)| place.iter().all(|mm| mm.is_finite()));
    if with_height().next().is_none() {
        return Err("it has no point with a height".into());
    }
    let [x, y] = [(0, "x"), (1, "y")].map(|(axis, name)| {
        let found = GridAxis::of(with_height().map(|(_, place)| place[axis]).collect(), stated[axis]);
        found.map_err(|what| format!("{what} along {name}"))
    });
    let (x, y) = (x?, y?);
    let pixels = x.count as f64 * y.count as f64;
    if pixels > MAX_PIXELS as f64 {
        let what = format!("its points span {} profiles of {} columns", y.count, x.count);
        return Err(format!("{what}, more than the {MAX_PIXELS} pixels that are compared"));
    }
    let mut points = vec![None; x.count * y.count];
    let (mut all, mut lost) = (0_usize, 0_usize);
    for (i, place) in with_height() {
        let at = &mut points[y.place(place[1]) * x.count + x.place(place[0])];
        all += 1;
        if at.is_some() {
            lost += 1;
        } else {
            *at = u32::try_from(i).ok();
        }
    }
    if lost as f64 > MAX_LOST_SHARE * all as f64 {
        let pitches = format!("{} x {} mm", x.pitch.unwrap_or(0.0), y.pitch.unwrap_or(0.0));
        return Err(format!("{lost} of its {all} points share a place of the grid of {pitches} with another"));
    }
    Ok(PointGrid { cols: x.count, rows: y.count, points, pitch_mm: [x.pitch, y.pitch], first_mm: Some(x.first) })
}

/// Even places along an axis.
struct GridAxis {
    first: f64,
    pitch: Option<f64>,
    count: usize,
}

impl GridAxis {
    fn of(mut numbers: Vec<f64>, stated: Option<f64>) -> Result<Self, String> {
        numbers.sort_unstable_by(f64::total_cmp);
        let (Some(&first), Some(&last)) = (numbers.first(), numbers.last()) else {
            return Err("it has no points".into());
        };
        let extent = last - first;
        if !extent.is_finite() {
            return Err(format!("its points reach from {first:e} to {last:e} mm"));
        }
        let size = first.abs().max(last.abs());
        let same = (SAME_PLACE * extent).max(4.0 * f64::from(f32::EPSILON) * size);
        let pitch = match stated {
            Some(pitch) => Some(pitch),
            None if extent <= same => None,
            None => Some(even_pitch(&numbers, same)?),
        };
        let steps = pitch.map_or(0.0, |pitch| (extent / pitch).round());
        if steps >= MAX_PIXELS as f64 {
            return Err(format!("its points span {steps:e} places"));
        }
        Ok(Self { first, pitch, count: steps as usize + 1 })
    }

    /// Which place is nearest.
    fn place(&self, number: f64) -> usize {
        let steps = self.pitch.map_or(0.0, |pitch| ((number - self.first) / pitch).round());
        (steps.max(0.0) as usize).min(self.count - 1)
    }
}

/// The pitch of the even grid on which sorted numbers lie.
fn even_pitch(sorted: &[f64], same: f64) -> Result<f64, String> {
    let gaps = || sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > same);
    let uneven = || "its points lie on no even grid".to_owned();
    // Rounding in the file makes some gaps smaller than the pitch, never by half: the mean of those near the smallest.
    let least = gaps().fold(f64::INFINITY, f64::min);
    let (sum, count) = gaps().filter(|gap| *gap < 1.5 * least).fold((0.0, 0.0), |(s, n), gap| (s + gap, n + 1.0));
    let near = sum / count;
    // Whole steps over the whole extent give it exactly.
    let steps: f64 = gaps().map(|gap| (gap / near).round()).sum();
    if steps.is_nan() || steps < 1.0 {
        return Err(uneven());
    }
    let pitch = (sorted[sorted.len() - 1] - sorted[0]) / steps;
    let is_even = sorted.iter().all(|number| {
        let place = (number - sorted[0]) / pitch;
        (place - place.round()).abs() <= MAX_UNEVEN
    });
    if is_even { Ok(pitch) } else { Err(uneven()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a grid of 4 x 3 places, 0.1 x 0.25 mm apart, in some other order and without two of them.
    fn points() -> Vec<[f64; 3]> {
        let all = (0..12).map(|i| {
            let i = (i * 5 + 3) % 12;
            [7.0 + 0.1 * f64::from(i % 4), -2.0 + 0.25 * f64::from(i / 4), f64::from(i)]
        });
        all.filter(|place| place[2] != 5.0 && place[2] != 6.0).collect()
    }

    fn heights(grid: &PointGrid, places: &[[f64; 3]]) -> Vec<f64> {
        grid.points.iter().map(|point| point.map_or(f64::NAN, |i| places[i as usize][2])).collect()
    }

    /// An even grid is found, whatever the order, with its pitches; what is not there is missing.
    #[test]
    fn an_even_grid_is_found() {
        let places = points();
        let grid = on_grid(&places, [None; 2]).expect("it is even");
        assert_eq!((grid.cols, grid.rows, grid.first_mm), (4, 3, Some(7.0)));
        let [col, row] = grid.pitch_mm.map(|mm| mm.expect("there are several"));
        assert!((col - 0.1).abs() < 1e-12 && (row - 0.25).abs() < 1e-12);
        for (i, z) in heights(&grid, &places).into_iter().enumerate() {
            assert!(if i == 5 || i == 6 { z.is_nan() } else { z == i as f64 }, "{i}: {z}");
        }
    }

    /// Numbers that are rounded to three digits, as text holds them, are still even over a long line.
    #[test]
    fn rounded_places_are_even() {
        let rounded = |i: u32| (f64::from(i) * 101.2).round() / 1000.0;
        let places: Vec<[f64; 3]> = (0..4000).map(|i| [rounded(i % 2000), f64::from(i / 2000), 1.0]).collect();
        let grid = on_grid(&places, [None; 2]).expect("it is even");
        assert_eq!((grid.cols, grid.rows), (2000, 2));
        assert!((grid.pitch_mm[0].expect("it has columns") - 0.1012).abs() < 1e-6);
    }

    /// A stated pitch takes uneven places; two points in a place are told.
    #[test]
    fn uneven_places_need_a_pitch() {
        let x = [0.0, 1.1, 1.9, 3.2, 4.0];
        let places: Vec<[f64; 3]> = (0..10).map(|i| [x[i % 5], (i / 5) as f64, i as f64]).collect();
        let what = on_grid(&places, [None; 2]).err().expect("it is uneven");
        assert!(what.contains("no even grid along x"), "{what}");
        let grid = on_grid(&places, [Some(1.0), None]).expect("a pitch is stated");
        assert_eq!((grid.cols, grid.rows), (5, 2));
        assert_eq!(heights(&grid, &places), (0..10).map(f64::from).collect::<Vec<_>>());
        let what = on_grid(&places, [Some(4.0), None]).err().expect("they share places");
        assert!(what.contains("share a place"), "{what}");
        assert!(on_grid(&places, [Some(1e-300), None]).err().is_some_and(|what| what.contains("span")));
    }

    /// Points in order keep it, and pitches are medians of steps.
    #[test]
    fn order_is_kept() {
        let mut places: Vec<[f64; 3]> =
            (0..12).map(|i| [0.1 * f64::from(i % 4), 0.2 * f64::from(i / 4), f64::from(i)]).collect();
        places[3] = [f64::NAN; 3];
        let grid = stored_in_order(&places, 4, [None; 2]).expect("whole profiles");
        assert_eq!((grid.cols, grid.rows, grid.points[3]), (4, 3, Some(3)));
        let [col, row] = grid.pitch_mm.map(|mm| mm.expect("there are several"));
        assert!((col - 0.1).abs() < 1e-12 && (row - 0.2).abs() < 1e-12);
        assert_eq!(stored_in_order(&places, 4, [Some(9.0), None]).map(|grid| grid.pitch_mm[0]), Ok(Some(9.0)));
        assert!(stored_in_order(&places, 5, [None; 2]).is_err() && stored_in_order(&[], 5, [None; 2]).is_err());
    }

    /// What is hostile is told: nothing finite, one place, infinities.
    #[test]
    fn odd_points_do_not_panic() {
        assert!(on_grid(&[[f64::NAN, 0.0, 0.0]], [None; 2]).err().is_some_and(|what| what.contains("no point")));
        let one = on_grid(&[[1.0, 2.0, 3.0]], [None; 2]).expect("one point is a grid");
        assert_eq!((one.cols, one.rows, one.pitch_mm), (1, 1, [None, None]));
        let far = [[-1e308, 0.0, 0.0], [1e308, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert!(on_grid(&far, [None; 2]).is_err());
        let fine: Vec<[f64; 3]> = (0..100).map(|i| [f64::from(i * i), f64::from(i), 0.0]).collect();
        assert!(on_grid(&fine, [None; 2]).is_ok());
    }
}
