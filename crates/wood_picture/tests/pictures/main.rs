//! Maps from pictures whose truth is known: textures, grown boards, and pictures with faults.

mod board;
mod boards;
mod cut;
mod faults;
mod photographs;
mod real;
mod textures;

/// The value at a part of the sorted values.
fn quantile(values: &mut [f32], part: f32) -> f32 {
    let at = ((values.len() - 1) as f32 * part).round() as usize;
    *values.select_nth_unstable_by(at, f32::total_cmp).1
}

/// Two azimuths' difference as lines, in degrees [deg].
fn apart_deg(a_rad: f32, b_rad: f32) -> f32 {
    let turned = (a_rad - b_rad).to_degrees();
    (turned - 180.0 * (turned / 180.0).round()).abs()
}
