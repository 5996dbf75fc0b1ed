//! The wood's own tone: light that structures of wood have, without what machining and gloss have put on it.
//!
//! Model: the tone of a photograph is reflectance times lamps times the surface (scratches, raised and torn fibres,
//! glints, noise of the sensor and of JPEG). Structures of wood run along the fibre for millimetres; marks of teeth and
//! knives cross it, and what is torn is short. So a pixel's tone is the median of light along its fibre, over 2 mm to
//! either side in the face: fibres that dive are short there, and in an upright knot a pixel stays what it is. Lines
//! end at the outlines of knots. What is darker than its median by more than three deviations of all clear pixels from
//! theirs is wood too (small knots, rims, checks across the grain), and keeps its darkness but for these three; nothing
//! is brighter than its median, since what shines is the surface. Source: the median as a filter of lines that cross a
//! signal is Tukey's (1977); lengths are engineering estimates, tried on twenty photographs (docs/real.md). Limits:
//! pale things shorter than 2 mm along the grain are lost, and dark ones lose three deviations; fibre bundles that are
//! torn over more than half of the line stay bright.

use glam::Vec2;

use crate::FibreMap;
use crate::raster::quantile;

/// Half of the line whose median counts [mm]: above the pitch of marks, below the length of a fibre bundle.
const HALF_MM: f32 = 2.0;
/// Places on either side.
const PLACES: usize = 4;
/// Deviations from the median that what is dark has to pass [1].
const SURE: f32 = 3.0;
/// A deviation of a normal distribution over the median of its sizes [1].
const NORMAL: f32 = 1.4826;

/// Light of the wood alone; `inside` says which pixels lie in knots.
pub(crate) fn of_wood(light: &[f32], fibres: &FibreMap, inside: &[bool]) -> Vec<f32> {
    let [rows, cols] = fibres.size;
    let step = HALF_MM / PLACES as f32 / Vec2::new(fibres.pixel_mm[1], fibres.pixel_mm[0]);
    let mut tone = Vec::with_capacity(light.len());
    for (row, col) in (0..rows).flat_map(|row| (0..cols).map(move |col| (row, col))) {
        let pixel = row * cols + col;
        let ahead = step * fibres.fibre(pixel).truncate();
        let start = Vec2::new(col as f32 + 0.5, row as f32 + 0.5);
        let mut line = [light[pixel]; 2 * PLACES + 1];
        let mut count = 1;
        for end in [1.0, -1.0] {
            for place in (1..=PLACES).map(|i| start + end * i as f32 * ahead) {
                let (x, y) = (place.x.floor(), place.y.floor());
                if !(0.0..cols as f32).contains(&x) || !(0.0..rows as f32).contains(&y) {
                    break;
                }
                let there = y as usize * cols + x as usize;
                if inside[there] != inside[pixel] {
                    break;
                }
                line[count] = light[there];
                count += 1;
            }
        }
        tone.push(quantile(&mut line[..count], 0.5));
    }
    let mut offs: Vec<f32> = (0..light.len())
        .step_by(97)
        .filter(|&pixel| !inside[pixel] && tone[pixel] > 0.0)
        .map(|pixel| (light[pixel] / tone[pixel] - 1.0).abs())
        .collect();
    let least = if offs.is_empty() { 1.0 } else { 1.0 + SURE * NORMAL * quantile(&mut offs, 0.5) };
    tone.iter_mut().zip(light).for_each(|(tone, light)| *tone = tone.min(light * least));
    tone
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::knots::direction;

    /// Streaks along fibres that run 10 degrees off the rows' normal, thin bright marks across the board, a small knot
    /// that nobody found: streaks stay, marks go, and the knot keeps its darkness but for three deviations.
    #[test]
    fn marks_go_and_streaks_and_dark_wood_stay() {
        let (size, pixel_mm, azimuth) = ([500, 400], [0.08, 0.1], 0.175);
        let count = size[0] * size[1];
        let fibres = FibreMap {
            size,
            pixel_mm,
            azimuth_rad: vec![azimuth; count],
            dive_rad: vec![0.0; count],
            confidence: vec![1.0; count],
            knots: Vec::new(),
        };
        let pin = Vec2::new(20.0, 20.0);
        let wood = |place: Vec2| {
            let streaks = 0.6 * (1.0 + 0.08 * libm::sinf(4.0 * place.dot(direction(azimuth).perp())));
            if place.distance(pin) < 0.6 { 0.4 * streaks } else { streaks }
        };
        let light: Vec<f32> = (0..count)
            .map(|i| {
                let place = fibres.place_mm(i);
                let mark = ((place.y + 0.05 * place.x) / 1.3).fract() < 0.2;
                wood(place) * if mark { 1.4 } else { 1.0 } * (1.0 + 0.02 * ((i * 7919 % 101) as f32 / 50.0 - 1.0))
            })
            .collect();
        let tone = of_wood(&light, &fibres, &vec![false; count]);
        let off = |seen: &[f32], is_asked: &dyn Fn(Vec2) -> bool| {
            let offs = (0..count).filter(|&i| is_asked(fibres.place_mm(i)));
            let offs: Vec<f32> = offs.map(|i| seen[i] / wood(fibres.place_mm(i)) - 1.0).collect();
            (offs.iter().map(|off| off * off).sum::<f32>() / offs.len() as f32).sqrt()
        };
        let clear = |place: Vec2| place.distance(pin) > 1.0;
        let dark = |place: Vec2| place.distance(pin) < 0.4;
        let [before, after] = [&light, &tone].map(|seen| off(seen, &clear));
        println!("clear wood off by {before:.3} before, {after:.3} after; small knot by {:.3}", off(&tone, &dark));
        assert!(before > 0.15 && after < 0.02, "{before}, {after}");
        // A mark crosses it too, which leaves 0.4 on a third of it.
        assert!(off(&tone, &dark) < 0.4);
        // In an upright knot each pixel speaks for itself; one that shines no more than its deviation allows stays.
        let upright = FibreMap { dive_rad: vec![std::f32::consts::FRAC_PI_2; count], ..fibres };
        assert_eq!(of_wood(&light, &upright, &vec![true; count]), light);
    }
}
