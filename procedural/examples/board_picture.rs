//! Paints the upper face of a board: brightness, class, dive and fibre azimuth side by side, as a binary PPM.
//!
//! `cargo run --release -p procedural --example board_picture -- out.ppm seed=3 knots.sound_count=3 log.pith_depth_mm=40`
//!
//! Any `group.name=value` of the wood parameters may follow, besides `seed` and `step` [mm].

use std::io::Write;

use procedural::wood::Plank;
use procedural::wood::parameters::Wood;
use procedural::{Class, Matter, Stream};

/// Diffuse reflectance of a thick piece under a normal beam, from the two-source diffusion formula [1].
fn reflectance(matter: &Matter) -> f32 {
    let m = &matter.medium;
    let sine = m.fibre.z.abs().min(1.0);
    let cosine = (1.0 - sine * sine).sqrt();
    // An average over directions stands in for the transverse coefficient: the mean sine weighted by sin^3 is 0.88.
    let (along, across) = (1.0 / (3.0 * m.sigma_i), 1.0 / (3.0 * (m.sigma_i + 0.88 * m.k)));
    let d = across + (along - across) * sine * sine;
    let depth = cosine * cosine / (m.sigma_i + m.k * cosine) + sine * sine / m.sigma_i;
    // Internal reflection: straight line through A(1.1) = 1.35 and A(1.25) = 2.06.
    let extrapolated = 2.0 * (1.35 + 4.73 * (m.n_eff - 1.1)) * d;
    let decay = (m.mu_a / d).sqrt();
    0.5 * ((-depth * decay).exp() + (-(depth + 2.0 * extrapolated) * decay).exp())
}

fn class_colour(class: Class) -> [u8; 3] {
    match class {
        Class::Background => [0, 0, 0],
        Class::Clear => [226, 196, 150],
        Class::SoundKnot => [178, 92, 30],
        Class::DeadKnot => [60, 20, 60],
        Class::Rot => [60, 110, 60],
        _ => [255, 0, 255],
    }
}

fn grey(share: f32) -> [u8; 3] {
    [(255.0 * share.clamp(0.0, 1.0)) as u8; 3]
}

/// Wood-like colour of a reflectance at red light: darker wood is browner.
fn wood_colour(red: f32) -> [u8; 3] {
    let tone = |power: f32| (255.0 * (1.15 * red).clamp(0.0, 1.0).powf(power)) as u8;
    [tone(0.55), tone(0.85), tone(1.35)]
}

fn main() -> std::io::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let out = arguments.next().unwrap_or_else(|| "board.ppm".into());
    let mut wood = Wood::from_values(&mut |p| p.default);
    let (mut seed, mut step) = (0_u64, 0.15_f32);
    for argument in arguments {
        let (key, value) = argument.split_once('=').expect("arguments look like key=value");
        let value: f64 = value.parse().expect("the value is a number");
        match key {
            "seed" => seed = value as u64,
            "step" => step = value as f32,
            _ => {
                let mut values = values(&wood).into_iter();
                wood = Wood::from_values(&mut |p| {
                    let old = values.next().expect("as many values as parameters");
                    if p.path() == key { value } else { old }
                });
            }
        }
    }
    let plank = Plank::grow(Stream::root(seed), &wood);
    for instance in plank.instances() {
        println!("{instance:?}");
    }
    let (low, high) = plank.bounds();
    let (columns, rows) = (((high.x - low.x) / step) as usize, ((high.y - low.y) / step) as usize);
    // The scan runs to the right, so that a board lies as it would in a catalogue; panels lie below each other.
    let mut panels = [(); 4].map(|()| vec![[0_u8; 3]; rows * columns]);
    for row in 0..rows {
        let y = low.y + (row as f32 + 0.5) * step;
        let slice = plank.slice(y);
        for column in 0..columns {
            let x = low.x + (column as f32 + 0.5) * step;
            let Some(surface) = slice.surface(x) else { continue };
            let matter = slice.matter(x, surface.z);
            let fibre = matter.medium.fibre;
            let at = column * rows + row;
            panels[0][at] = wood_colour(reflectance(&matter));
            panels[1][at] = class_colour(matter.class);
            panels[2][at] = grey(fibre.z.abs().asin().to_degrees() / 90.0);
            panels[3][at] = grey(0.5 + (fibre.x / fibre.y).atan().to_degrees() / 60.0);
        }
    }
    let mut file = std::io::BufWriter::new(std::fs::File::create(&out)?);
    write!(file, "P6\n{rows} {}\n255\n", 4 * columns)?;
    for panel in &panels {
        file.write_all(panel.as_flattened())?;
    }
    file.flush()
}

/// The values of all groups in the order in which `Wood::from_values` asks for them.
fn values(wood: &Wood) -> Vec<f64> {
    let groups = [wood.board.values(), wood.log.values(), wood.knots.values(), wood.rot.values(), wood.media.values()];
    groups.into_iter().flatten().map(|(_, value)| value).collect()
}
