//! Maps side by side: the real scan, the recipe as it was, the fitted recipe.
//!
//! Range is shown less a plane, each map less its own: of planes through three pixels and the plane of least squares,
//! the one whose median distance is least (least median of squares, Rousseeuw 1984). Then least squares over what lies
//! within [`NEAR`] robust deviations of it, [`PASSES`] times; then the median is taken off. Colours go from 2 to 98 %
//! of the real map.

use drawing::html::{ColourMap, MAP_LEVELS, colour_scale, data_url, hex, indexed_png, map_palette};
use maud::{Markup, html};
use nalgebra::{Matrix3, Vector3};
use tools::compare::ScanMaps;

use crate::result::{Fit, ScanFit};

/// Most columns and profiles of a picture [px].
const MOST: usize = 320;
/// Scans whose maps are shown.
const MOST_SCANS: usize = 8;
/// Colour of missing pixels, far from those of all ramps.
const MISSING: [u8; 3] = [255, 0, 160];
/// Its name in captions.
const MISSING_WORD: &str = "magenta";
/// Robust deviations within which heights count for the next plane.
const NEAR: f64 = 2.5;
/// Planes of least squares, each from what lies near the one before.
const PASSES: usize = 3;
/// Planes through three pixels that are tried.
const TRIALS: usize = 200;
/// Pixels by which they are judged.
const JUDGES: usize = 2000;
/// Quartile of the standard normal law: a median of distances over it is a deviation.
const QUARTILE: f64 = 0.674_489_750_196_081_7;

/// A kind of map.
#[derive(Debug, Clone, Copy)]
struct MapKind {
    name: &'static str,
    ramp: ColourMap,
    /// What its numbers are.
    words: &'static str,
    /// Its light, where a scan has it; `None` of heights.
    light: Option<LightOfScan>,
}

/// A map of light of a scan.
type LightOfScan = fn(&ScanMaps) -> Option<&Vec<f32>>;

const KINDS: [MapKind; 3] = [
    MapKind { name: "Range", ramp: ColourMap::Viridis, words: "less the plane of its surface", light: None },
    MapKind {
        name: "Reflectance",
        ramp: ColourMap::Grey,
        words: "at the peak, on the scale of 8 bits",
        light: Some(|maps| maps.reflectance.as_ref()),
    },
    MapKind {
        name: "Scatter",
        ramp: ColourMap::Inferno,
        words: "sum beside the peak, on the scale of 8 bits",
        light: Some(|maps| maps.scatter.as_ref()),
    },
];

impl MapKind {
    fn unit(self, maps: &ScanMaps) -> &'static str {
        if self.light.is_none() { maps.unit.name() } else { "DN" }
    }

    /// Its numbers `[rows, cols]`, NaN where missing; `None` where the scan has no such map.
    fn numbers(self, maps: &ScanMaps) -> Option<Vec<f64>> {
        let measured = |(&dn, z): (&f32, &f64)| if z.is_finite() { f64::from(dn) } else { f64::NAN };
        let numbers = match self.light {
            None => levelled(&maps.range, maps.cols),
            Some(light) => light(maps)?.iter().zip(&maps.range).map(measured).collect(),
        };
        (!numbers.is_empty() && numbers.len() == maps.cols * maps.rows).then_some(numbers)
    }
}

/// The section.
pub(super) fn section(fit: &Fit) -> Markup {
    html! {
        @if fit.scans.is_empty() { p.note { "There is no real scan." } }
        @else {
            p {
                "Left the real scan, in the middle a scan of the recipe as it was, right one of the fitted recipe, \
                    each at the middle of "
                "what is known of the keys. Draws that are not fitted differ from the real scan: parts lie elsewhere, \
                    noise is another. "
                "A row has one colour scale, from 2 to 98 % of the real map; what lies beyond has the colour of the \
                    nearer end. "
                "Rows grow downwards in the order of exposure. Range is shown less the plane of its surface."
            }
            ul.key aria-label="Colours" {
                li { span.swatch style={ "background:" (hex(MISSING)) } {} (MISSING_WORD) ": nothing measured" }
            }
        }
        @for scan in fit.scans.iter().take(MOST_SCANS) { (of_scan(scan)) }
        @if fit.scans.len() > MOST_SCANS {
            p.note {
                "Maps of the first \
                    " (MOST_SCANS) " of " (fit.scans.len()) " real scans are shown; statistics below are of all."
            }
        }
    }
}

fn of_scan(scan: &ScanFit) -> Markup {
    let sides =
        [("real scan", &scan.maps.real), ("recipe as it was", &scan.maps.before), ("fitted recipe", &scan.maps.after)];
    html! {
        article.scan {
            h3 { (scan.name) }
            @for kind in KINDS { (row(kind, sides)) }
        }
    }
}

/// One kind of map of one scan.
fn row(kind: MapKind, sides: [(&str, &ScanMaps); 3]) -> Markup {
    let real = sides[0].1;
    let Some((low, high)) = kind.numbers(real).map(|numbers| colour_ends(&numbers)) else {
        let made = sides[1..].iter().any(|(_, maps)| kind.numbers(maps).is_some());
        return html! {
            p.note { "The real scan has no " (kind.name) @if made { "; that of simulated scans is left out" } "." }
        };
    };
    let widest = sides.iter().map(|(_, maps)| maps.cols.min(MOST)).max().unwrap_or(1).max(1);
    let unit = kind.unit(real);
    html! {
        h4 { (kind.name) " " span.dim { "[" (unit) "], " (kind.words) } }
        div.maps {
            @for (side, maps) in sides {
                figure {
                    @match kind.numbers(maps).and_then(|numbers| picture(kind, &numbers, maps, low, high)) {
                        Some(picture) => {
                            img width=(picture.cols) height=(picture.rows) alt={ (kind.name) " of the " (side) }
                                style=(format!("width:{:.1}%",
                                    100.0 * picture.cols as f64 / widest as f64)) src=(picture.url);
                            figcaption { strong { (side) } ", " (picture.part) }
                        }
                        None => {
                            div.empty { "no such map" }
                            figcaption { strong { (side) } }
                        }
                    }
                }
            }
        }
        (colour_scale(kind.ramp, low, high, unit))
    }
}

/// A map as a picture.
struct MapPicture {
    cols: usize,
    rows: usize,
    /// Which part of the map it is, in words.
    part: String,
    url: String,
}

/// The middle of a map, no more than [`MOST`] either way. `None` where it has no pixel.
fn picture(kind: MapKind, numbers: &[f64], maps: &ScanMaps, low: f64, high: f64) -> Option<MapPicture> {
    let (cols, rows) = (maps.cols.min(MOST), maps.rows.min(MOST));
    let (left, top) = ((maps.cols - cols) / 2, (maps.rows - rows) / 2);
    let most = f64::from(MAP_LEVELS - 2);
    let level = |value: f64| {
        if value.is_finite() { 1 + ((value - low) / (high - low) * most).round().clamp(0.0, most) as u8 } else { 0 }
    };
    let lines = (top..top + rows).flat_map(|y| &numbers[y * maps.cols + left..y * maps.cols + left + cols]);
    let levels: Vec<u8> = lines.map(|&value| level(value)).collect();
    let whole = (cols, rows) == (maps.cols, maps.rows);
    let part = if whole {
        format!("{cols} \u{d7} {rows} px")
    } else {
        format!("the middle {cols} \u{d7} {rows} px of {} \u{d7} {}", maps.cols, maps.rows)
    };
    let png = indexed_png(&levels, cols as u32, map_palette(MISSING, kind.ramp), Vec::new()).ok()?;
    Some(MapPicture { cols, rows, part, url: data_url(&png) })
}

/// 2 and 98 % of the numbers that are there, apart from each other.
fn colour_ends(numbers: &[f64]) -> (f64, f64) {
    let mut sorted: Vec<f64> = numbers.iter().copied().filter(|x| x.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else { return (0.0, 1.0) };
    let [low, high] = [0.02, 0.98].map(|share| sorted[(share * last as f64).round() as usize]);
    let least = 1e-6 * low.abs().max(high.abs()).max(1e-3);
    if high - low > least { (low, high) } else { (low - 0.5, low + 0.5) }
}

/// Heights less their plane and their median, NaN where missing.
fn levelled(heights: &[f64], cols: usize) -> Vec<f64> {
    let cols = cols.max(1);
    let at = |i: usize| Vector3::new(1.0, (i % cols) as f64 / cols as f64, (i / cols) as f64 / cols as f64);
    let measured: Vec<usize> = (0..heights.len()).filter(|&i| heights[i].is_finite()).collect();
    let mut plane = median_plane(heights, &measured, &at);
    for _ in 0..PASSES {
        let distances: Vec<f64> = measured.iter().map(|&i| (heights[i] - plane.dot(&at(i))).abs()).collect();
        let limit = NEAR / QUARTILE * median(&distances);
        let near: Vec<usize> =
            measured.iter().zip(&distances).filter(|(_, distance)| **distance <= limit).map(|(&i, _)| i).collect();
        let Some(found) = plane_of(heights, &near, &at) else { break };
        plane = found;
    }
    let mut flat: Vec<f64> = heights.iter().enumerate().map(|(i, z)| z - plane.dot(&at(i))).collect();
    let middle = median(&measured.iter().map(|&i| flat[i]).collect::<Vec<_>>());
    flat.iter_mut().for_each(|z| *z = if z.is_finite() { *z - middle } else { f64::NAN });
    flat
}

/// Of planes through three pixels, that of least squares and a level one, the plane whose median distance from some
/// pixels is least.
fn median_plane(heights: &[f64], measured: &[usize], at: &dyn Fn(usize) -> Vector3<f64>) -> Vector3<f64> {
    let n = measured.len();
    let judges: Vec<usize> = measured.iter().copied().step_by(n.div_ceil(JUDGES).max(1)).collect();
    let level = Vector3::new(median(&judges.iter().map(|&i| heights[i]).collect::<Vec<_>>()), 0.0, 0.0);
    // Square roots of 2, 3 and 5: their multiples spread evenly over the pixels, the same ones each time.
    let three = |trial: usize| {
        [2.0_f64, 3.0, 5.0]
            .map(|root| measured[(((trial as f64 * root.sqrt()).fract() * n as f64) as usize).min(n - 1)])
    };
    let through = |pixels: [usize; 3]| -> Option<Vector3<f64>> {
        let places = Matrix3::from_columns(&pixels.map(at)).transpose();
        Some(places.try_inverse()? * Vector3::from(pixels.map(|i| heights[i])))
    };
    let trials = (1..=TRIALS).filter(|_| n > 0).filter_map(|trial| through(three(trial)));
    let candidates = plane_of(heights, measured, at).into_iter().chain(trials);
    let miss = |plane: &Vector3<f64>| {
        median(&judges.iter().map(|&i| (heights[i] - plane.dot(&at(i))).abs()).collect::<Vec<_>>())
    };
    let mut best = (miss(&level), level);
    for plane in candidates {
        let missed = miss(&plane);
        if missed < best.0 {
            best = (missed, plane);
        }
    }
    best.1
}

/// The plane of least squares through these pixels; `None` where they lie in a line.
fn plane_of(heights: &[f64], pixels: &[usize], at: &dyn Fn(usize) -> Vector3<f64>) -> Option<Vector3<f64>> {
    let (mut products, mut sums) = (Matrix3::zeros(), Vector3::zeros());
    for &i in pixels {
        let x = at(i);
        products += x * x.transpose();
        sums += x * heights[i];
    }
    let n = pixels.len() as f64;
    let inverse = (products / n.max(1.0)).cholesky().filter(|cholesky| cholesky.determinant() > 1e-12)?;
    Some(inverse.solve(&(sums / n)))
}

fn median(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    let middle = sorted.len() / 2;
    if sorted.is_empty() { 0.0 } else { *sorted.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

#[cfg(test)]
mod tests {
    use base64::Engine;
    use base64::engine::general_purpose::STANDARD;

    use super::*;

    /// A tilted plate becomes level though a third of the scan is a block and a belt far below, with holes in both; a
    /// single line of pixels, which has no plane, and a scan without heights are no trouble.
    #[test]
    fn tilt_is_taken_off() {
        let (cols, rows) = (40, 30);
        let tilted = |i: usize| 7.0 + 0.2 * (i % cols) as f64 - 0.1 * (i / cols) as f64;
        let step = |i: usize| match (i % cols, i / cols) {
            (_, 0..6) => -20.0 - 0.2 * (i % cols) as f64,
            (5..20, 15..28) => 3.0,
            _ => 0.0,
        };
        let heights: Vec<f64> =
            (0..cols * rows).map(|i| if i % 7 == 0 { f64::NAN } else { tilted(i) + step(i) }).collect();
        for (i, z) in levelled(&heights, cols).into_iter().enumerate() {
            assert_eq!(z.is_nan(), i % 7 == 0);
            assert!(z.is_nan() || (z - step(i)).abs() < 1e-9, "{i}: {z}");
        }
        assert!(levelled(&[f64::NAN; 4], 2).iter().all(|z| z.is_nan()));
        assert_eq!(levelled(&[1.0, 3.0, 5.0], 3), [-2.0, 0.0, 2.0]);
    }

    /// A saw-tooth keeps its teeth: no plane lies along their flanks.
    #[test]
    fn teeth_are_kept() {
        let (cols, rows) = (40, 60);
        let heights: Vec<f64> = (0..cols * rows).map(|i| ((i / cols) % 12) as f64 / 11.0).collect();
        let flat = levelled(&heights, cols);
        let slope = flat[11 * cols] - flat[0];
        assert!((0.8..1.2).contains(&slope), "a flank rises by {slope}");
    }

    /// The colour of missing pixels is none of any ramp, by far.
    #[test]
    fn missing_pixels_stand_out() {
        for kind in KINDS {
            for i in 0..=100_u8 {
                let colour = kind.ramp.at(f32::from(i) / 100.0);
                let apart: f64 = colour.iter().zip(MISSING).map(|(a, b)| (f64::from(*a) - f64::from(b)).powi(2)).sum();
                assert!(apart.sqrt() > 90.0, "{kind:?} at {i} %: {colour:?}");
            }
        }
    }

    /// A picture shows the middle of a large map in its own pixels, in the colours of its numbers.
    #[test]
    fn pictures_are_the_middle() {
        let (cols, rows) = (MOST + 10, 5);
        let mut range: Vec<f64> = (0..cols * rows).map(|i| (i % cols) as f64).collect();
        range[2 * cols + 5] = f64::NAN;
        let maps = ScanMaps { cols, rows, range: range.clone(), ..ScanMaps::default() };
        let found = picture(KINDS[1], &range, &maps, 5.0, 5.0 + (MOST - 1) as f64).expect("a picture");
        assert_eq!((found.cols, found.rows), (MOST, rows));
        assert_eq!(found.part, "the middle 320 \u{d7} 5 px of 330 \u{d7} 5");
        let png = STANDARD.decode(&found.url["data:image/png;base64,".len()..]).expect("base64");
        let mut decoder = png::Decoder::new(std::io::Cursor::new(png));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().expect("a PNG");
        let mut pixels = vec![0; 3 * MOST * rows];
        reader.next_frame(&mut pixels).expect("its pixels");
        let pixel = |x: usize, y: usize| &pixels[3 * (y * MOST + x)..3 * (y * MOST + x) + 3];
        assert_eq!((pixel(0, 0), pixel(MOST - 1, 0), pixel(0, 2)), (&[0; 3][..], &[255; 3][..], &MISSING[..]));
    }

    /// Scales end at 2 and 98 % of what is there, and never at one number.
    #[test]
    fn scales_have_two_ends() {
        let numbers: Vec<f64> = (0..=100).map(f64::from).chain([f64::NAN]).collect();
        assert_eq!(colour_ends(&numbers), (2.0, 98.0));
        assert_eq!(colour_ends(&[4.0; 9]), (3.5, 4.5));
        assert_eq!(colour_ends(&[f64::NAN]), (0.0, 1.0));
    }
}
