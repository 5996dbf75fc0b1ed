//! Production against the judge where media meet: a line across the edge of a knot, of rot, over a crack and at the side
//! of a board. Scatter (rows 1 to 8 on both sides of the peak) along the line, free of noise.

mod bench;

use glam::Vec3;
use procedural::strips::{Strip, Strips};
use procedural::{Body, Class, Medium};
use sheetlight::optics::expose::{self, ROWS};
use sheetlight::optics::{Scratch, TILE};
use sheetlight::settings::Transport;

/// Scan position of the line, in the middle of the plate [profiles].
const PROFILE: usize = 150;
/// Columns averaged into one, 0.74 mm.
const BIN: usize = 2;

fn wood(mu_a: f32, sigma_i: f32, k: f32, n_eff: f32, dive_deg: f32) -> Medium {
    let (up, flat) = dive_deg.to_radians().sin_cos();
    Medium { mu_a, sigma_i, k, n_eff, fibre: Vec3::new(0.0, flat, up), gloss: 0.0 }
}

fn clear() -> Medium {
    wood(0.08, 2.0, 10.0, 1.18, 0.0)
}

fn strip(width_mm: f32, medium: Medium) -> Strip {
    Strip { width_mm, sunk_mm: 0.0, medium, class: Class::Clear }
}

fn plate(strips: Vec<Strip>) -> Body {
    Body::Strips(Strips { height_mm: 22.0, length_mm: 20.0, strips })
}

/// Scatter and light at all, of bins of columns along the line [e-]; and where the bins lie [mm].
fn profile(body: Body, transport: Transport) -> (Vec<[f64; 2]>, Vec<f64>) {
    let mut scene = bench::scene(300);
    scene.transport = transport;
    let (sensor, band) = bench::expose(&scene, body, PROFILE..PROFILE + 1);
    let mut sums = Vec::new();
    let mut scratch = Scratch::default();
    for tile in 0..scene.size.columns / TILE {
        expose::window(&sensor, &band, PROFILE, tile, &mut scratch);
        for column in 0..TILE {
            let at = |k: usize| f64::from(scratch.electrons(k, column));
            let peak = (0..ROWS).max_by(|&a, &b| at(a).total_cmp(&at(b))).unwrap();
            let beside: f64 = (1..=8).map(|d| at((peak + d).min(ROWS - 1)) + at(peak.saturating_sub(d))).sum();
            sums.push([beside, (0..ROWS).map(at).sum()]);
        }
    }
    let hits = &band.row(PROFILE).hits;
    let place = |bin: usize| hits[bin * BIN..][..BIN].iter().map(|hit| f64::from(hit.x)).sum::<f64>() / BIN as f64;
    let mean = |chunk: &[[f64; 2]]| [0, 1].map(|i| chunk.iter().map(|v| v[i]).sum::<f64>() / BIN as f64);
    (sums.chunks_exact(BIN).map(mean).collect(), (0..sums.len() / BIN).map(place).collect())
}

struct Case {
    name: &'static str,
    body: Body,
    /// Columns that are compared [mm].
    span: [f64; 2],
}

fn cases() -> Vec<Case> {
    let knot = wood(0.22, 3.0, 14.0, 1.22, 80.0);
    let rot = wood(0.5, 4.0, 8.0, 1.15, 0.0);
    let crack = Strip { sunk_mm: 3.0, ..strip(0.6, clear()) };
    vec![
        Case { name: "edge of a knot", body: plate(vec![strip(10.0, clear()), strip(10.0, knot)]), span: [-6.0, 6.0] },
        Case { name: "edge of rot", body: plate(vec![strip(10.0, clear()), strip(10.0, rot)]), span: [-6.0, 6.0] },
        Case { name: "crack", body: plate(vec![strip(10.0, clear()), crack, strip(10.0, clear())]), span: [-6.0, 6.0] },
        Case { name: "side of a board", body: plate(vec![strip(16.0, clear())]), span: [1.0, 7.95] },
    ]
}

/// Root mean square of relative differences in scatter over the bins of a span.
fn apart(case: &Case, one: &[[f64; 2]], judge: &[[f64; 2]], places: &[f64]) -> f64 {
    let inside = (0..places.len()).filter(|&i| (case.span[0]..=case.span[1]).contains(&places[i]));
    let squares: Vec<f64> =
        inside.filter(|&i| judge[i][0] > 0.0).map(|i| (one[i][0] / judge[i][0] - 1.0).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn scatter_across_borders_is_the_judges() {
    let photons = std::env::var("PHOTONS").ok().and_then(|text| text.parse().ok()).unwrap_or(150_000);
    let mut faults = Vec::new();
    for case in cases().into_iter().skip(std::env::var("SKIP").map_or(0, |s| s.parse().unwrap())) {
        let (judge, places) = profile(case.body.clone(), Transport::Path { photons });
        let (kernel, _) = profile(case.body.clone(), Transport::Kernel);
        let (diffusion, _) = profile(case.body.clone(), Transport::Diffusion { voxel_mm: 0.1 });
        for i in 0..places.len() {
            println!(
                "{:7.2} mm  scatter {:9.0} {:9.0} {:9.0}   all {:9.0} {:9.0} {:9.0}",
                places[i], judge[i][0], kernel[i][0], diffusion[i][0], judge[i][1], kernel[i][1], diffusion[i][1]
            );
        }
        let off = [&kernel, &diffusion].map(|model| apart(&case, model, &judge, &places));
        println!("{}: kernel {:.3}, diffusion {:.3} rms of the judge", case.name, off[0], off[1]);
        if off[0] > 0.10 {
            faults.push((case.name, off));
        }
    }
    assert!(faults.is_empty(), "{faults:?}");
}
