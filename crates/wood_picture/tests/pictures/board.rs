//! A picture of a grown board: what a camera would see under even light, with the truth of every pixel.
//!
//! Model: diffuse reflectance of the medium at each point of the face, a blur of 0.15 mm, noise of 2 % a pixel.

use std::collections::HashMap;

use base::{BodyKind, Class, Medium, Stream, normal};
use glam::Vec2;
use procedural::wood::{Plank, Wood};
use wood_picture::HalfSpace;

/// Blur of the picture [mm] and noise of a pixel [1].
const BLUR_MM: f32 = 0.15;
const NOISE: f64 = 0.02;

/// A picture and what is true in it, `[rows, cols]`.
pub struct BoardPicture {
    pub wood: Wood,
    pub plank: Plank,
    pub size: [usize; 2],
    pub pixel_mm: [f32; 2],
    pub light: Vec<f32>,
    pub azimuth_rad: Vec<f32>,
    pub dive_rad: Vec<f32>,
    pub class: Vec<Class>,
    pub mu_a: Vec<f32>,
    pub instance: Vec<u16>,
}

/// A flat-sawn board as recipes/wood.yaml draws them, with that many sound knots, and where the picture's corner is
/// [mm].
pub fn wood(stream: Stream, sound: f64, dead: f64) -> Wood {
    let mut wood = Wood::from_values(&mut |p| p.default);
    let mut rng = stream.child("wood").rng();
    let mut draw = |mean: f64, sd: f64, least: f64, most: f64| (mean + sd * normal(&mut rng)).clamp(least, most);
    wood.board.width_mm = 60.0;
    wood.board.length_mm = 90.0;
    wood.board.lead_in_mm = 0.0;
    wood.log.pith_depth_mm = draw(75.0, 25.0, 35.0, 120.0);
    wood.log.pith_offset_mm = draw(0.0, 20.0, -50.0, 50.0);
    wood.log.pith_tilt_deg = draw(0.0, 0.6, -2.0, 2.0);
    wood.log.grain_angle_deg = draw(0.0, 3.0, -9.0, 9.0);
    wood.log.spiral_deg = draw(2.5, 1.2, -6.0, 6.0);
    wood.log.ring_width_mm = draw(1.9, 0.6, 0.8, 4.0);
    wood.log.latewood_share = draw(0.22, 0.06, 0.12, 0.35);
    wood.log.streak = draw(0.06, 0.02, 0.03, 0.1);
    wood.knots.sound_count = sound;
    wood.knots.dead_count = dead;
    wood.knots.width_mm = draw(11.0, 2.5, 6.0, 18.0);
    wood.knots.flow_ratio = draw(1.0, 0.25, 0.5, 1.5);
    wood.media.knot_mu_a_ratio = draw(2.5, 0.5, 1.6, 3.4);
    // Knots alike and plain: fibres and light are in question, not how knots differ.
    (wood.knots.bulge_log_sd, wood.knots.lean_sd_deg, wood.knots.tone_log_sd) = (0.0, 0.0, 0.0);
    (wood.knots.heart_mu_a_ratio, wood.knots.stain_mu_a_ratio) = (1.0, 1.0);
    (wood.knots.pith_shift, wood.knots.crack_share, wood.knots.bark_uneven) = (0.0, 0.0, 0.0);
    wood
}

pub fn picture(stream: Stream, wood: Wood, pixel_mm: f32) -> BoardPicture {
    let mut seen = look(Plank::grow(stream.child("plank"), &wood), wood, pixel_mm);
    seen.light = blurred(&seen.light, seen.size, BLUR_MM / pixel_mm);
    let mut rng = stream.child("noise").rng();
    seen.light.iter_mut().for_each(|light| *light *= (1.0 + NOISE * normal(&mut rng)) as f32);
    seen
}

/// What a line camera of a sawmill makes of a board, in sRGB of 8 bits. Lamps leave half of the light at a corner. A
/// planer has left thin bright marks across the grain every 1.3 mm, each of its own strength. Ten patches of torn
/// fibres shine by half.
pub fn photographed(board: &BoardPicture) -> Vec<f32> {
    // Numbers that fill 0 to 1 evenly.
    let drawn = |i: usize, step: f32| (0.5 + i as f32 * step).fract();
    let [length, width] = [board.wood.board.length_mm as f32, board.wood.board.width_mm as f32];
    let torn: Vec<Vec2> = (0..10).map(|i| Vec2::new(drawn(i, 0.755) * width, drawn(i, 0.57) * length)).collect();
    (0..board.light.len())
        .map(|i| {
            let [row, col] = [i / board.size[1], i % board.size[1]];
            let place = Vec2::new((col as f32 + 0.5) * board.pixel_mm[1], (row as f32 + 0.5) * board.pixel_mm[0]);
            let lamps = (-0.5 * place.y / length).exp() / (1.0 + (place.x / width - 0.45).powi(2));
            let at = (place.y + 0.03 * place.x) / 1.3;
            let mark = if at.fract() < 0.3 { 1.0 + 0.5 * drawn(at as usize, 0.618) } else { 1.0 };
            let shine = if torn.iter().any(|torn| torn.distance(place) < 2.5) { 1.5 } else { 1.0 };
            let light = (0.8 * board.light[i] * lamps * mark * shine).clamp(0.0, 1.0);
            let coded = if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
            (255.0 * coded).round() / 255.0
        })
        .collect()
}

/// The same of any board, sharp and without noise.
pub fn look(plank: Plank, wood: Wood, pixel_mm: f32) -> BoardPicture {
    let size = [wood.board.length_mm, wood.board.width_mm].map(|mm| (mm as f32 / pixel_mm) as usize);
    let pixels = size[0] * size[1];
    let mut spaces: HashMap<[i32; 3], HalfSpace> = HashMap::new();
    let mut seen = BoardPicture {
        wood,
        size,
        pixel_mm: [pixel_mm; 2],
        light: Vec::with_capacity(pixels),
        azimuth_rad: Vec::with_capacity(pixels),
        dive_rad: Vec::with_capacity(pixels),
        class: Vec::with_capacity(pixels),
        mu_a: Vec::with_capacity(pixels),
        instance: Vec::with_capacity(pixels),
        plank,
    };
    for row in 0..size[0] {
        let y = (row as f32 + 0.5) * pixel_mm;
        let slice = seen.plank.slice(y);
        for col in 0..size[1] {
            let x = (col as f32 + 0.5) * pixel_mm - 0.5 * wood.board.width_mm as f32;
            let z = slice.surface(x).expect("the picture lies on the board").z;
            let matter = slice.matter(x, z);
            let medium = matter.medium;
            let fibre = if medium.fibre.y < 0.0 { -medium.fibre } else { medium.fibre };
            let dive = fibre.z.clamp(-1.0, 1.0).asin();
            // Lengths scale with one over sigma_i: half spaces of one k / sigma_i, index and dive are one.
            let ratio = medium.k / medium.sigma_i;
            let key = [(50.0 * ratio) as i32, (500.0 * medium.n_eff) as i32, dive.abs().to_degrees().round() as i32];
            let space = spaces.entry(key).or_insert_with(|| {
                let unit = Medium { sigma_i: 1.0, k: ratio, ..medium };
                HalfSpace::new(&unit, dive.abs().to_degrees().round().to_radians())
            });
            seen.light.push(space.reflectance(f64::from(medium.mu_a / medium.sigma_i)) as f32);
            seen.azimuth_rad.push(fibre.x.atan2(fibre.y));
            seen.dive_rad.push(-dive);
            seen.class.push(matter.class);
            seen.mu_a.push(medium.mu_a);
            seen.instance.push(matter.instance);
        }
    }
    seen
}

/// A Gaussian along both axes, the border repeated.
pub fn blurred(data: &[f32], [rows, cols]: [usize; 2], sigma: f32) -> Vec<f32> {
    let reach = (3.0 * sigma).ceil() as isize;
    let weights: Vec<f32> = (-reach..=reach).map(|i| (-0.5 * (i as f32 / sigma).powi(2)).exp()).collect();
    let sum: f32 = weights.iter().sum();
    let pass = |data: &[f32], step: [isize; 2]| -> Vec<f32> {
        let mut out = vec![0.0; rows * cols];
        for row in 0..rows as isize {
            for col in 0..cols as isize {
                let value: f32 = (-reach..=reach)
                    .zip(&weights)
                    .map(|(i, weight)| {
                        let r = (row + i * step[0]).clamp(0, rows as isize - 1) as usize;
                        let c = (col + i * step[1]).clamp(0, cols as isize - 1) as usize;
                        weight * data[r * cols + c]
                    })
                    .sum();
                out[row as usize * cols + col as usize] = value / sum;
            }
        }
        out
    };
    pass(&pass(data, [0, 1]), [1, 0])
}
