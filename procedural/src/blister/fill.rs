//! From numbers to a filled pack.

use glam::{Mat3, Vec2, Vec3};
use rand::RngExt;

use super::Pack;
use super::lay::Lay;
use super::parameters::{Blister, Foil, Tablet};
use super::pose::{Cavity, Pose, Wish};
use super::solid::Solid;
use super::tablet::{self, Form};
use super::web::FormedWeb;
use crate::{Class, Gloss, Instance, Medium, Stream, normal};

/// Least distance of a tablet from the film [mm].
const MARGIN_MM: f32 = 0.01;
/// Largest part of the bumps that probes of a tablet may miss between them [1].
const MISSED: f32 = 0.3;

/// Forms and fills a pack.
pub fn form(stream: Stream, blister: &Blister) -> Pack {
    let lay = Lay::new(&blister.card);
    let form = Form::new(&blister.tablet);
    let slack = lay.slack(form.outline().half().length() + blister.pocket.clearance_mm as f32);
    let mut web = FormedWeb::new(stream, blister, &form, lay.half, slack);
    let probes = form.probes();
    let mut solids = Vec::new();
    let mut contents = Vec::new();
    let mut instances = Vec::new();
    for number in 0..web.cells.len() {
        let wish = wish(stream.child("pose").index(number as u64), blister);
        let pose = settle(&mut web, number, &form, &probes, wish, slack);
        contents.push(vec![solids.len()]);
        solids.push(solid(&lay, &form, pose, tablet::medium(&blister.tablet)));
        let at = lay.conveyor(web.cells[number].middle);
        instances.push(Instance {
            id: number as u16 + 1,
            class: Class::Pocket,
            state: Class::Pocket,
            within: 0,
            x_mm: f64::from(at.x),
            y_mm: f64::from(at.y),
            diameter_mm: 2.0 * f64::from(web.formed.outline.half().x),
            dive_deg: f64::NAN,
            death_radius_mm: f64::NAN,
            severity: f64::NAN,
        });
    }
    let (depth, crown) = web.formed.depth_mm();
    let deepest = web.cells.iter().map(|cell| cell.factor).fold(0.0, f32::max);
    let height = web.foil_mm
        + web.flat_mm
        + (deepest * (depth + crown) + web.highest_bump()).max(web.highest_relief())
        + lay.highest();
    Pack { lay, web, foil: metal(&blister.foil), solids, contents, instances, height }
}

/// The foil's bright side.
fn metal(foil: &Foil) -> Medium {
    let (along, across) = (foil.roughness_along as f32, foil.roughness_across as f32);
    let roughness = if foil.rolled_along_line >= 0.5 { [along, across] } else { [across, along] };
    Medium::opaque(Gloss { share: 1.0, reflectance: foil.reflectance as f32, roughness })
}

/// Draws the pose of a tablet.
fn wish(stream: Stream, blister: &Blister) -> Wish {
    let Tablet { tilt_deg, rattle, on_edge, .. } = blister.tablet;
    let mut rng = stream.rng();
    let mut even = || rng.random::<f64>();
    let (yaw, about, flipped, edge) = (even(), even(), even() < 0.5, even() < on_edge);
    let (far, way) = (rattle * even().sqrt() * blister.pocket.clearance_mm, std::f64::consts::TAU * even());
    let (sine, cosine) = libm::sincos(way);
    let tilt = normal(&mut stream.child("tilt").rng()) * tilt_deg.to_radians();
    Wish {
        yaw: (std::f64::consts::TAU * (yaw - 0.5)) as f32,
        tilt: tilt as f32,
        about: (std::f64::consts::TAU * about) as f32,
        offset: Vec2::new((far * cosine) as f32, (far * sine) as f32),
        flipped,
        on_edge: edge,
    }
}

/// Lays a tablet in a pocket; where not even a flat one has room, the film is formed deeper until it has.
fn settle(web: &mut FormedWeb, number: usize, form: &Form, probes: &[Vec3], wish: Wish, slack: f32) -> Pose {
    let margin = MARGIN_MM + slack + MISSED * web.highest_bump();
    loop {
        let cell = web.cells[number];
        let ceiling = |p: Vec2| web.leaf(p, Some(number)).low();
        let cavity = Cavity {
            middle: cell.middle,
            axis: web.formed.axis,
            floor: web.foil_mm + slack,
            ceiling: &ceiling,
            margin,
        };
        if let Some(pose) = cavity.settle(form, probes, wish) {
            return pose;
        }
        let factor = cell.factor * 1.03;
        web.cells[number].factor = factor;
        web.cells[number].stretch = web.formed.stretch(factor);
    }
}

/// A posed tablet as a solid on the conveyor.
fn solid(lay: &Lay, form: &Form, pose: Pose, medium: Medium) -> Solid {
    let (tangent, origin) = lay.tangent(pose.middle.truncate());
    let linear = tangent * pose.turn * Mat3::from_diagonal(form.scale);
    Solid::new(form.shape, Vec::new(), linear, origin + Vec3::Z * pose.middle.z, medium, Class::Pocket, 0)
}
