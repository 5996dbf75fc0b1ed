//! Measures the table of `transport: kernel` by Monte Carlo and writes it.
//!
//! `cargo run --release --example kernel_table -- MEASUREMENTS TABLE`: appends one JSON line a half space to
//! MEASUREMENTS, goes on where an earlier run stopped, and at the end condenses them into TABLE. `make kernel-table`
//! runs it; on two cores it takes three quarters of an hour.

mod half_space;

use std::fs::OpenOptions;
use std::io::{BufRead, BufReader, Write};

use half_space::{MeasuredHalfSpace, PathStatistics, measure};
use transport::kernel::table;

/// Photons of one half space where fibres are dispersed like those of clear wood, and elsewhere.
const PHOTONS: [u64; 2] = [250_000, 80_000];
/// Dispersion of clear wood's fibres [deg].
const CLEAR_WOOD_DEG: f64 = 5.0;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result<()> {
    let mut names = std::env::args().skip(1);
    let (Some(measurements), Some(out)) = (names.next(), names.next()) else {
        return Err("name the file of measurements and the table".into());
    };
    let mut file = OpenOptions::new().create(true).read(true).append(true).open(&measurements)?;
    let lines = BufReader::new(file.try_clone()?).lines();
    let mut done: Vec<PathStatistics> = lines.map(|line| Ok(serde_json::from_str(&line?)?)).collect::<Result<_>>()?;
    for of in spaces() {
        if done.iter().any(|paths| paths.of == of) {
            continue;
        }
        // Without cylinders the fibres' dive and dispersion mean nothing, but the table has a place for them.
        let same = done.iter().find(|paths| of.rho == 1.0 && paths.of.rho == 1.0 && paths.of.n == of.n);
        let paths = match same {
            Some(paths) => PathStatistics { of, ..paths.clone() },
            None => measure(of, PHOTONS[usize::from(of.dispersion_deg != CLEAR_WOOD_DEG)], 0),
        };
        writeln!(file, "{}", serde_json::to_string(&paths)?)?;
        eprintln!("{of:?}: {:.4} left", paths.left);
        done.push(paths);
    }
    let ordered: Option<Vec<PathStatistics>> =
        spaces().map(|of| done.iter().find(|paths| paths.of == of).cloned()).collect();
    let ordered = ordered.ok_or("a half space is missing")?;
    // What `transport::kernel::view` has as constants.
    for (group, [slope, correlation]) in half_space::skewness(&ordered).into_iter().enumerate() {
        eprintln!("group {group}: third moments {slope:.3} of shift times variance, correlation {correlation:.2}");
    }
    let nodes = half_space::table(&ordered);
    let bytes: Vec<u8> = nodes.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    std::fs::write(&out, bytes)?;
    Ok(())
}

/// The table's half spaces in its order.
fn spaces() -> impl Iterator<Item = MeasuredHalfSpace> {
    let wide = |value: f32| (f64::from(value) * 1e6).round() / 1e6;
    let of = move |dispersion: f32, n: f32, rho: f32, dive: f32| MeasuredHalfSpace {
        rho: wide(rho),
        dive_deg: f64::from(dive),
        n: wide(n),
        dispersion_deg: f64::from(dispersion),
    };
    table::DISPERSION_DEG.into_iter().flat_map(move |dispersion| {
        table::N.into_iter().flat_map(move |n| {
            table::RHO
                .into_iter()
                .flat_map(move |rho| table::DIVE_DEG.into_iter().map(move |dive| of(dispersion, n, rho, dive)))
        })
    })
}
