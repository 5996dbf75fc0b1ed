//! Work of a sample: what one takes, from sizes and settings alone.
//!
//! It says where shards are cut, so it is a rule and no measurement: the same on every machine, with any threads, for
//! ever. Its figures are rounded ones of the machine of docs/theory/performance.md and docs/guide/scale.md, within a
//! factor of three of every recipe that ships. Neglected: kept frames, effects, and what other machines do.

use optical_bench::settings::{Order, Size, Transport};

use crate::Subject;

/// Work of a board or a piece before its first pixel [s].
const SOLID_S: f64 = 0.03;
/// Work of a pixel of one [s]: `wood` 0.68 us, `wood-train` 1.1, `sawtooth` 0.9, `species/oak` 1.9.
const SOLID_PIXEL_S: f64 = 0.8e-6;
/// Work of a pack before its first pixel: its pockets are solved [s].
const PACK_S: f64 = 0.8;
/// Work of a pixel of a pack [s]: `blister` 8 to 11 s in all, `blister-small` and `blister-train` 1.2 to 1.3.
const PACK_PIXEL_S: f64 = 3.8e-6;
/// Work of a photon on a body [s]: 20 to 40 us in clear wood.
const PHOTON_S: f64 = 40e-6;
/// Work of a profile by diffusion on voxels [s]: 34 s of two cores on a board of 94 mm.
const DIFFUSION_PROFILE_S: f64 = 68.0;
/// Work of a pixel by the method of the thesis, or of its scripts on whole frames [s]: `thesis/blister` 91 s in all.
const THESIS_PIXEL_S: f64 = 35e-6;

/// What a sample takes on one core, about [s].
pub(crate) fn core_seconds(subject: Subject, transport: Transport, order: Order, size: &Size) -> f64 {
    let (profiles, pixels) = (size.profiles as f64, (size.columns * size.profiles) as f64);
    let kernel = match subject {
        Subject::Blister => PACK_S + pixels * PACK_PIXEL_S,
        Subject::Wood | Subject::Sawtooth | Subject::Mesh => SOLID_S + pixels * SOLID_PIXEL_S,
    };
    let model = match transport {
        Transport::Kernel => 0.0,
        Transport::Path { photons } => photons as f64 * profiles * PHOTON_S,
        Transport::Diffusion { .. } => profiles * DIFFUSION_PROFILE_S,
        Transport::Thesis { .. } => pixels * THESIS_PIXEL_S,
    };
    let scripts = if order == Order::Physical { 0.0 } else { pixels * THESIS_PIXEL_S };
    kernel + model + scripts
}
