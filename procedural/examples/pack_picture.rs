//! Paints a pack from above: shaded height, film thickness, gap, what lies below, classes, side by side, as a binary PPM.
//!
//! `cargo run --release -p procedural --example pack_picture -- out.ppm seed=3 pocket.dome_mm=1 defects.broken=2`
//!
//! Any `group.name=value` of the blister parameters may follow, besides `seed`, `step` [mm] and `pack` (0: no list).

use std::io::Write;

use procedural::blister::{Blister, Pack};
use procedural::{Class, Matter, Stream, Surface};

/// Colour of a class.
fn class_colour(class: Class) -> [u8; 3] {
    match class {
        Class::Background => [0, 0, 0],
        Class::Flange => [70, 80, 95],
        Class::Pocket => [90, 150, 110],
        other => {
            let h = (other as u32).wrapping_mul(0x9e37_79b1);
            [h >> 24, h >> 16, h >> 8].map(|c| 70 + (c as u8) % 186)
        }
    }
}

fn grey(share: f32) -> [u8; 3] {
    [(255.0 * share.clamp(0.0, 1.0)) as u8; 3]
}

/// Light from the upper left on a rough surface.
fn shade(surface: &Surface) -> f32 {
    let up = 1.0 / (1.0 + surface.slope_x * surface.slope_x + surface.slope_y * surface.slope_y).sqrt();
    (0.62 * surface.slope_x - 0.45 * surface.slope_y + 0.75) * up * 0.9
}

/// Lambert shading of what lies below the film, darker for metal.
fn below(matter: &Matter) -> [u8; 3] {
    let (medium, slope) = match matter.film {
        Some(film) => (film.under, film.under_slope),
        None => (matter.medium, [0.0; 2]),
    };
    let light = shade(&Surface { z: 0.0, slope_x: slope[0], slope_y: slope[1] });
    if medium.gloss.is_metal() {
        grey(0.45 * light)
    } else if medium.mu_a > 1.0 {
        [60, 10, 10]
    } else {
        let tone = medium.coat;
        [light, light * (0.3 + 0.7 * tone), light * tone].map(|c| (255.0 * c.clamp(0.0, 1.0)) as u8)
    }
}

fn main() -> std::io::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let out = arguments.next().unwrap_or_else(|| "pack.ppm".into());
    let mut blister = Blister::from_values(&mut |p| p.default);
    let (mut seed, mut step, mut list) = (0_u64, 0.1_f32, true);
    for argument in arguments {
        let (key, value) = argument.split_once('=').expect("arguments look like key=value");
        let value: f64 = value.parse().expect("the value is a number");
        match key {
            "seed" => seed = value as u64,
            "step" => step = value as f32,
            "pack" => list = value != 0.0,
            _ => {
                let mut values = blister.values().into_iter();
                blister = Blister::from_values(&mut |p| {
                    let (_, old) = values.next().expect("as many values as parameters");
                    if p.path() == key { value } else { old }
                });
            }
        }
    }
    let pack = Pack::form(Stream::root(seed), &blister);
    for instance in pack.instances().iter().filter(|_| list) {
        let i = instance;
        println!(
            "{:3} {:16} state {:16} within {:3} at {:6.1} {:6.1} size {:5.2} severity {:.2}",
            i.id,
            i.class.name(),
            i.state.name(),
            i.within,
            i.x_mm,
            i.y_mm,
            i.diameter_mm,
            i.severity
        );
    }
    let (low, high) = pack.bounds();
    let (columns, rows) = (((high.x - low.x) / step) as usize, ((high.y - low.y) / step) as usize);
    let mut picture = vec![[0_u8; 3]; rows * columns * 5];
    for row in 0..rows {
        let y = low.y + (row as f32 + 0.5) * step;
        let slice = pack.slice(y);
        for column in 0..columns {
            let x = low.x + (column as f32 + 0.5) * step;
            let Some(surface) = slice.surface(x) else { continue };
            let matter = slice.matter(x);
            let film = matter.film;
            let panels = [
                grey(shade(&surface)),
                film.map_or([120, 0, 0], |film| grey(film.thickness_mm / 0.3)),
                match film.map(|film| film.gap_mm) {
                    Some(Some(gap)) => grey(gap.sqrt() / 2.4),
                    Some(None) => [30, 30, 90],
                    None => [120, 0, 0],
                },
                below(&matter),
                class_colour(matter.class),
            ];
            for (panel, colour) in panels.into_iter().enumerate() {
                picture[(row * 5 + panel) * columns + column] = colour;
            }
        }
    }
    let mut file = std::io::BufWriter::new(std::fs::File::create(&out)?);
    write!(file, "P6\n{} {rows}\n255\n", 5 * columns)?;
    file.write_all(picture.as_flattened())?;
    file.flush()
}
