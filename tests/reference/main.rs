//! Production against slow and obvious reference models, and these against published values. Takes minutes.

mod accepted;
mod boards;
mod borders;
mod contrast;
mod cracks;
mod defects;
mod drawn_packs;
mod expose;
mod expose_camera;
mod expose_laser;
mod expose_parts;
mod foil_through_film;
mod front_faces;
mod half_spaces;
mod kept;
mod layers;
mod monte_carlo;
mod pack;
mod rays;
mod table;
mod unlike_foil;

use std::ops::Range;

use base::Body;
use pipeline::Equipment;
use recipe::Scene;
use scanner::optics::{Band, Sensor};
use test_support::target;

/// The sensor over a body, and light of `profiles` by the model that the scene names.
fn expose(scene: &Scene, body: Body, profiles: Range<usize>) -> (Sensor, Band) {
    let equipment = Equipment { patterns: target::patterns(), line_solvers: reference::line_solver };
    let (sensor, specimen) = pipeline::set_up(scene, body, equipment);
    let band = sensor.band(&specimen, profiles);
    (sensor, band)
}
