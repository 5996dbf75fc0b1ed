//! Measures the table of films by Monte Carlo and writes it.
//!
//! `cargo run --release --example film_table -- TABLE`; `make film-table` runs it, three minutes on two cores.

use reference::path::measure::film::{FilmIllumination, MeasuredFilm, condense, measure};
use transport::kernel::film_stack::table::{ABSORBED, N, TURNS, frequencies};

/// Photons of one film under one light.
const PHOTONS: u64 = 400_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).ok_or("name the table")?;
    let frequencies = frequencies();
    let mut bytes = Vec::new();
    for n in N {
        for turns in TURNS {
            let responses = [FilmIllumination::Straight, FilmIllumination::Lambert, FilmIllumination::Sealed]
                .map(|light| measure(MeasuredFilm { n, turns }, light, &frequencies, &ABSORBED, PHOTONS, 0));
            let [straight, lambert, sealed] = &responses;
            for a in 0..ABSORBED.len() {
                let node = condense(turns, &straight[a], &lambert[a], &sealed[a]);
                bytes.extend(node.iter().flat_map(|value| value.to_le_bytes()));
            }
            eprintln!(
                "n {n}, {turns}: {:.4} up, {:.4} down, of Lambert light {:.4} down",
                straight[0].up.total, straight[0].down.total, lambert[0].down.total
            );
        }
    }
    std::fs::write(out, bytes)?;
    Ok(())
}
