//! Measures the table of films by Monte Carlo and writes it.
//!
//! `cargo run --release --example film_table -- TABLE`; `make film-table` runs it, some six minutes on two cores.

mod film;

use film::{FilmIllumination, MeasuredFilm, condense, condense_sealed, measure};
use transport::kernel::film_stack::table::{ABSORBED, FOIL_REFLECTANCES, FOIL_ROUGHNESSES, N, TURNS, frequencies};
use transport::stack::Foil;

/// Photons of one film in air under one light, and of one film on one foil.
const PHOTONS: u64 = 400_000;
const SEALED_PHOTONS: u64 = 150_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).ok_or("name the table")?;
    let frequencies = frequencies();
    let of_reflectance = |reflectance| FOIL_ROUGHNESSES.map(|alpha| Foil { reflectance, roughness: [alpha; 2] });
    let foils = FOIL_REFLECTANCES.map(of_reflectance).concat();
    let mut bytes = Vec::new();
    for n in N {
        for turns in TURNS {
            let by = |light, photons| measure(MeasuredFilm { n, turns }, light, &frequencies, &ABSORBED, photons, 0);
            let [straight, lambert] =
                [FilmIllumination::Straight, FilmIllumination::Lambert].map(|light| by(light, PHOTONS));
            let sealed: Vec<_> = foils.iter().map(|foil| by(FilmIllumination::Sealed(*foil), SEALED_PHOTONS)).collect();
            for a in 0..ABSORBED.len() {
                let film = condense(turns, &straight[a], &lambert[a]);
                let on_foils = sealed.iter().flat_map(|on_foil| condense_sealed(&on_foil[a]));
                bytes.extend(film.into_iter().chain(on_foils).flat_map(f32::to_le_bytes));
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
