//! Defects of the film and of the seal: dents, holes, channels, wrinkles, delamination, tablets beside the pockets.
//!
//! Models: each is a [`FilmMark`] whose size grows with the severity; docs/theory/blister.md has the ranges. Those of
//! the flange lie on the lines halfway between pockets, or between pocket and edge.

use base::{Class, Medium, Stream};
use glam::{Mat3, Vec2, Vec3};
use rand::RngExt;

use super::Pack;
use super::card_placement::CardPlacement;
use super::film_mark::{FilmMark, MarkKind};
use super::outline::Outline;
use super::plan::{PlannedDefect, graded};
use super::pose::DrawnPose;
use super::solid::Solid;
use super::tablet::TabletForm;

/// Room between a tablet on the flange and the film over it [mm].
const OVER_MM: f32 = 0.05;
/// Most that film comes off the foil: by delamination [mm].
pub const RAISED_MM: f32 = 0.4;
/// Distance between places that must be free [mm].
const COLUMN_MM: f32 = 0.2;
/// Room between a tablet on the flange and anything beside it [mm].
const BESIDE_MM: f32 = 0.3;

/// The mark of a defect of one pocket, `solid` being its tablet.
pub fn in_pocket(pack: &Pack, planned: &PlannedDefect, instance: u16, tablet: Option<(&Solid, f32)>) -> FilmMark {
    let mut rng = planned.stream.child("mark").rng();
    let mut even = || rng.random::<f32>();
    let (formed, cell) = (&pack.web.formed, pack.web.cells[planned.cell]);
    let half = formed.outline.half();
    let (sine, cosine) = libm::sincosf(std::f32::consts::TAU * even());
    let way = Vec2::new(cosine, sine);
    let far = even().sqrt();
    let own = |share: f32| {
        let p = share * far * half * way;
        cell.middle + p.x * formed.axis + p.y * formed.axis.perp()
    };
    let severity = planned.severity;
    let ellipse = |size: f32, slim: f32| Outline::Ellipse { long: 0.5 * size, short: 0.5 * size * slim };
    let (kind, middle, axis, outline, height) = match planned.class {
        Class::Collapsed => {
            // Over a tablet the dent stays within its outline, so that the film can rest on it.
            let size = graded(severity, 3.0, 8.0);
            let (middle, room) = match tablet {
                Some((solid, short)) => {
                    let middle = 0.5 * (solid.bounds[0] + solid.bounds[1]);
                    (pack.lay.card(middle.x, middle.y), 1.7 * short)
                }
                None => (own(0.2), 1.2 * half.y),
            };
            (MarkKind::Dent, middle, way, ellipse(size.min(room), 0.8 + 0.2 * even()), graded(severity, 0.5, 3.0))
        }
        Class::Punctured => {
            (MarkKind::Hole, own(0.85), way.perp(), ellipse(graded(severity, 0.2, 2.0), 0.6 + 0.4 * even()), 0.0)
        }
        Class::Pinhole => {
            (MarkKind::Pinhole, own(0.9), way.perp(), ellipse(graded(severity, 0.02, 0.3), 0.7 + 0.3 * even()), 0.0)
        }
        _ => {
            // A channel leaves the pocket along one of its axes.
            let (side, reach) = if even() < 0.5 { (formed.axis, half.x) } else { (formed.axis.perp(), half.y) };
            let side = if even() < 0.5 { side } else { -side };
            let (width, length) = (graded(severity, 0.5, 3.0), 2.0 + 4.0 * even());
            let outline = Outline::Stadium { segment: 0.5 * length, radius: 0.5 * width };
            (MarkKind::Raised, cell.middle + (reach + 0.5 * length) * side, side, outline, graded(severity, 0.03, 0.15))
        }
    };
    FilmMark { kind, class: planned.class, instance, middle, axis, outline, height, skirt: 0.0, sag: 0.0 }
}

/// Lines of the flange across one axis of the card: halfway between pockets, and between pocket and edge [mm].
fn lines(count: usize, pitch: f32, reach: f32, half: f32) -> Vec<f32> {
    let outer = 0.5 * (count as f32 - 1.0) * pitch + reach;
    let edge = 0.5 * (outer + half);
    let between = (1..count).map(|i| (i as f32 - 0.5 * count as f32) * pitch);
    std::iter::once(-edge).chain(between).chain(std::iter::once(edge)).collect()
}

/// The lines of the flange along both axes [mm].
fn both(pack: &Pack) -> [Vec<f32>; 2] {
    let ([columns, rows], pitch) = pack.web.grid();
    let (reach, half, middle) = (pack.web.formed.reach(), pack.lay.half, pack.web.shift());
    let across = lines(rows, pitch.y, reach.y, half.y).into_iter().map(|v| (v + middle).clamp(-half.y, half.y));
    [lines(columns, pitch.x, reach.x, half.x), across.collect()]
}

/// A wrinkle or a patch of delamination.
pub fn on_flange(pack: &Pack, class: Class, severity: f32, stream: Stream, instance: u16) -> FilmMark {
    let mut rng = stream.child("mark").rng();
    let mut even = || rng.random::<f32>();
    let [lines_u, lines_v] = both(pack);
    let half = pack.lay.half;
    let (along_scan, line, place) = (even() < 0.5, even(), 1.6 * even() - 0.8);
    let pick = |lines: &[f32]| lines[((line * lines.len() as f32) as usize).min(lines.len() - 1)];
    let (middle, axis) = if along_scan {
        (Vec2::new(pick(&lines_u), place * half.y), Vec2::Y)
    } else {
        (Vec2::new(place * half.x, pick(&lines_v)), Vec2::X)
    };
    let (outline, height) = if class == Class::Wrinkle {
        let (length, width) = (graded(severity, 5.0, 20.0), graded(even(), 0.6, 1.4));
        (Outline::Stadium { segment: 0.5 * (length - width), radius: 0.5 * width }, graded(severity, 0.05, 0.3))
    } else {
        let long = graded(severity, 2.0, 8.0);
        (Outline::Ellipse { long, short: long * graded(even(), 0.4, 0.8) }, graded(severity, 0.05, RAISED_MM))
    };
    FilmMark { kind: MarkKind::Raised, class, instance, middle, axis, outline, height, skirt: 0.0, sag: 0.0 }
}

/// Height of film of that thickness over a tablet beside the pockets [mm].
pub fn tent_mm(form: &TabletForm, lay: &CardPlacement, slack: f32, flat_mm: f32) -> f32 {
    form.thickness_mm() + 2.0 * slack + lay.steepest() * flat_mm + 2.0 * OVER_MM
}

/// A tablet beside the pockets and the film over it; `None` where there is no room for one.
pub fn tablet_on_flange(
    pack: &Pack,
    form: &TabletForm,
    medium: Medium,
    stream: Stream,
    instance: u16,
) -> Option<(Solid, FilmMark)> {
    let mut rng = stream.child("place").rng();
    let [lines_u, lines_v] = both(pack);
    let mut places: Vec<Vec2> = lines_u.iter().flat_map(|&u| lines_v.iter().map(move |&v| Vec2::new(u, v))).collect();
    let yaw = std::f32::consts::TAU * rng.random::<f32>();
    let height = form.thickness_mm() + OVER_MM;
    let outline = form.outline();
    let half = outline.half();
    let grown = form.scale * Vec3::new(1.0 + BESIDE_MM / half.x, 1.0 + BESIDE_MM / half.y, 1.0);
    while !places.is_empty() {
        let middle = places.swap_remove(rng.random_range(0..places.len()));
        for eighth in 0..4_u8 {
            let wish = DrawnPose { yaw: yaw + std::f32::consts::FRAC_PI_4 * f32::from(eighth), ..DrawnPose::FLAT };
            let pose = wish.pose(form, middle, Vec2::X, pack.web.foil_mm + pack.slack);
            let (tangent, origin) = pack.lay.tangent(middle);
            let origin = origin + Vec3::Z * pose.middle.z;
            let scaled = |scale: Vec3| {
                let linear = tangent * pose.turn * Mat3::from_diagonal(scale);
                Solid::new(form.shape, Vec::new(), linear, origin, medium, Class::TabletOnFlange, instance)
            };
            let free = |p: Vec2| pack.spot(p.x, p.y).is_some_and(|spot| pack.highest(spot.cell, p.x, p.y).is_none());
            if !scaled(grown).columns(COLUMN_MM).all(|(p, _)| free(p)) {
                continue;
            }
            let solid = scaled(form.scale);
            let skirt = 0.8 * height;
            let over = tent_mm(form, &pack.lay, pack.slack, pack.web.flat_mm);
            // A cap of radius R falls by at least r^2 / 2R from its middle.
            let drop = form.shape.cap.map_or(0.0, |[radius, _]| half.y * half.y / (2.0 * radius));
            let mark = FilmMark {
                kind: MarkKind::Tent,
                class: Class::TabletOnFlange,
                instance,
                middle,
                axis: pose.turn.x_axis.truncate(),
                outline: outline.grown(OVER_MM + skirt),
                height: over,
                skirt,
                sag: drop / over,
            };
            return Some((solid, mark));
        }
    }
    None
}
