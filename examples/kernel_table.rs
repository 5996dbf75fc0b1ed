//! Measures the table of `transport: kernel` with the judge: `cargo run --release --example kernel_table -- FILE`.
//!
//! Appends one JSON line a half space to FILE, and goes on where it stopped. `make kernel-table` runs it.

use std::fs::OpenOptions;
use std::io::{BufRead, BufReader, Write};

use sheetlight::transport::path::paths::{HalfSpace, Paths, measure};

/// Photons of one half space.
const PHOTONS: u64 = 250_000;
const RHO: [f64; 8] = [0.03, 0.08, 0.14, 0.2, 0.28, 0.4, 0.6, 1.0];
const DIVE_DEG: [f64; 10] = [0.0, 5.0, 10.0, 15.0, 20.0, 30.0, 45.0, 60.0, 75.0, 90.0];
const N: [f64; 5] = [1.12, 1.25, 1.4, 1.55, 1.0];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("name the file of measurements")?;
    let mut file = OpenOptions::new().create(true).read(true).append(true).open(&path)?;
    let mut done: Vec<Paths> = BufReader::new(file.try_clone()?)
        .lines()
        .map(|line| Ok(serde_json::from_str(&line?)?))
        .collect::<Result<_, Box<dyn std::error::Error>>>()?;
    let spaces = N.iter().flat_map(|&n| RHO.iter().flat_map(move |&rho| DIVE_DEG.map(|dive_deg| HalfSpace { rho, dive_deg, n })));
    for of in spaces {
        if done.iter().any(|paths| paths.of == of) {
            continue;
        }
        // Without cylinders the fibres' dive means nothing, but the table has a place for it.
        let same = done.iter().find(|paths| of.rho == 1.0 && paths.of.rho == 1.0 && paths.of.n == of.n);
        let paths = match same {
            Some(paths) => Paths { of, ..paths.clone() },
            None => measure(of, PHOTONS, 0),
        };
        writeln!(file, "{}", serde_json::to_string(&paths)?)?;
        eprintln!("{of:?}: {:.4} left", paths.left);
        done.push(paths);
    }
    Ok(())
}
