//! Writes the built-in mesh `recipes/meshes/clip.obj`: a plate with a hole, an arch over it and a ball on it.
//!
//! What a height field cannot hold: light reaches the plate below the arch at a slant only, and the ball's lower half
//! never. `cargo run --release --example clip_mesh > recipes/meshes/clip.obj`. Lengths in mm.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

type Corner = [f64; 3];

/// Half of the plate along x and y, its thickness, and the hole's middle and radius [mm].
const HALF: [f64; 2] = [9.0, 6.5];
const THICK: f64 = 1.5;
const HOLE: ([f64; 2], f64) = ([-5.5, -2.0], 1.75);
/// Middle of the arch, its turn about the vertical, radius of its bow and of its rod [mm].
const ARCH: ([f64; 2], f64, [f64; 2]) = ([2.0, 1.0], 0.6, [4.0, 0.9]);
/// Middle of the ball and its radius [mm].
const BALL: (Corner, f64) = ([-5.0, 3.5, THICK + 1.9], 2.0);

/// A closed piece, corner by corner and quad by quad.
#[derive(Default)]
struct Piece {
    corners: Vec<Corner>,
    quads: Vec<[usize; 4]>,
}

/// Rings of corners joined by quads; the first and the last ring may be one point each.
fn rings(rings: Vec<Vec<Corner>>, closed: bool) -> Piece {
    let (count, length) = (rings.len(), rings[0].len());
    let mut piece = Piece { corners: rings.concat(), quads: Vec::new() };
    for i in 0..if closed { count } else { count - 1 } {
        for j in 0..length {
            let (next, beside) = ((i + 1) % count, (j + 1) % length);
            piece.quads.push([i * length + j, i * length + beside, next * length + beside, next * length + j]);
        }
    }
    piece
}

fn plate() -> Piece {
    let ([x, y], radius) = HOLE;
    let mut turns: Vec<f64> = (0..32).map(|i| f64::from(i) * TAU / 32.0).collect();
    for corner in [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]] {
        turns.push((corner[1] * HALF[1] - y).atan2(corner[0] * HALF[0] - x).rem_euclid(TAU));
    }
    turns.sort_by(f64::total_cmp);
    let inner = |z: f64| turns.iter().map(|t| [x + radius * t.cos(), y + radius * t.sin(), z]).collect::<Vec<_>>();
    let outer = |z: f64| {
        let reach = |t: &f64| {
            let to = |way: f64, from: f64, half: f64| (half * way.signum() - from) / way;
            let far = to(t.cos(), x, HALF[0]).min(to(t.sin(), y, HALF[1]));
            [x + far * t.cos(), y + far * t.sin(), z]
        };
        turns.iter().map(reach).collect::<Vec<_>>()
    };
    rings(vec![inner(0.0), inner(THICK), outer(THICK), outer(0.0)], true)
}

fn arch() -> Piece {
    let ([x, y], turn, [bow, rod]) = ARCH;
    let ring = |i: i32| {
        let around = -0.15 + (PI + 0.3) * f64::from(i) / 24.0;
        let place = |j: i32| {
            let own = f64::from(j) * TAU / 14.0;
            let far = bow + rod * own.cos();
            let (along, across) = (far * around.cos(), rod * own.sin());
            let z = THICK + far * around.sin();
            [x + along * turn.cos() - across * turn.sin(), y + along * turn.sin() + across * turn.cos(), z.max(0.1)]
        };
        (0..14).map(place).collect()
    };
    // Its ends are open, inside of the plate.
    rings((0..=24).map(ring).collect(), false)
}

fn ball() -> Piece {
    let (middle, radius) = BALL;
    let ring = |i: i32| {
        let rise = f64::from(i) * PI / 14.0 - FRAC_PI_2;
        let place = |j: i32| {
            let turn = f64::from(j) * TAU / 20.0;
            let level = radius * rise.cos();
            [middle[0] + level * turn.cos(), middle[1] + level * turn.sin(), middle[2] + radius * rise.sin()]
        };
        (0..20).map(place).collect()
    };
    rings((0..=14).map(ring).collect(), false)
}

fn main() {
    println!("# Plate with a hole, arch and ball; mm. Written by examples/clip_mesh.rs.");
    let mut first = 1;
    for (name, piece) in [("plate", plate()), ("arch", arch()), ("ball", ball())] {
        println!("o {name}");
        for [x, y, z] in &piece.corners {
            println!("v {x:.3} {y:.3} {z:.3}");
        }
        for quad in &piece.quads {
            println!("f {}", quad.map(|corner| (corner + first).to_string()).join(" "));
        }
        first += piece.corners.len();
    }
}
