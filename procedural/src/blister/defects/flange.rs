//! Defects of the flange: wrinkles, delamination, tablets beside the pockets.
//!
//! Models: each is a [`FilmMark`] whose size grows with the severity; docs/theory/blister.md has the ranges. They lie
//! on the lines halfway between pockets, or between pocket and edge.

use base::{Class, Stream};
use glam::{Mat3, Vec2, Vec3};
use rand::RngExt;

use super::graded;
use crate::blister::card_placement::CardPlacement;
use crate::blister::film_mark::{FilmMark, MarkKind};
use crate::blister::outline::Outline;
use crate::blister::pose::DrawnPose;
use crate::blister::solid::Solid;
use crate::blister::tablet::{self, TabletForm};
use crate::blister::{Blister, Pack};

/// Room between a tablet on the flange and the film over it [mm].
const OVER_MM: f32 = 0.05;
/// Most that film comes off the foil: by delamination [mm].
pub const RAISED_MM: f32 = 0.4;
/// Distance between places that must be free [mm].
const COLUMN_MM: f32 = 0.2;
/// Room between a tablet on the flange and anything beside it [mm].
const BESIDE_MM: f32 = 0.3;

/// What defects of the flange draw from.
pub struct FlangeDraw<'a> {
    /// The pack so far.
    pub pack: &'a Pack,
    /// Its numbers.
    pub blister: &'a Blister,
    /// The form of its tablets.
    pub form: &'a TabletForm,
    /// Class of its pixels.
    pub class: Class,
    /// Number of its instance.
    pub instance: u16,
    /// Severity [1].
    pub severity: f32,
    /// What decides its details.
    pub stream: Stream,
}

/// A defect of the flange.
pub struct FlangeDefect {
    /// What it does to the film.
    pub mark: FilmMark,
    /// What lies below the film.
    pub solid: Option<Solid>,
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

/// Film that has come off on a line of the flange; `form` makes outline and height.
fn raised(draw: &FlangeDraw, form: impl Fn(f32, f32) -> (Outline, f32)) -> Option<FlangeDefect> {
    let pack = draw.pack;
    let mut rng = draw.stream.child("mark").rng();
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
    let (outline, height) = form(draw.severity, even());
    let FlangeDraw { class, instance, .. } = *draw;
    let mark =
        FilmMark { kind: MarkKind::Raised, class, instance, middle, axis, outline, height, skirt: 0.0, sag: 0.0 };
    Some(FlangeDefect { mark, solid: None })
}

/// A wrinkle of the foil.
pub fn wrinkle(draw: &FlangeDraw) -> Option<FlangeDefect> {
    raised(draw, |severity, even| {
        let (length, width) = (graded(severity, 5.0, 20.0), graded(even, 0.6, 1.4));
        let outline = Outline::Stadium { segment: 0.5 * (length - width), radius: 0.5 * width };
        (outline, graded(severity, 0.05, 0.3))
    })
}

/// A patch where the film has come off the foil.
pub fn delamination(draw: &FlangeDraw) -> Option<FlangeDefect> {
    raised(draw, |severity, even| {
        let long = graded(severity, 2.0, 8.0);
        (Outline::Ellipse { long, short: long * graded(even, 0.4, 0.8) }, graded(severity, 0.05, RAISED_MM))
    })
}

/// Height of film of that thickness over a tablet beside the pockets [mm].
pub fn tent_mm(form: &TabletForm, lay: &CardPlacement, slack: f32, flat_mm: f32) -> f32 {
    form.thickness_mm() + 2.0 * slack + lay.steepest() * flat_mm + 2.0 * OVER_MM
}

/// A tablet beside the pockets and the film over it; `None` where there is no room for one.
pub fn tablet_on_flange(draw: &FlangeDraw) -> Option<FlangeDefect> {
    let FlangeDraw { pack, form, class, instance, .. } = *draw;
    let medium = tablet::medium(&draw.blister.tablet);
    let mut rng = draw.stream.child("place").rng();
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
                Solid::new(form.shape, Vec::new(), linear, origin, medium, class, instance)
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
                class,
                instance,
                middle,
                axis: pose.turn.x_axis.truncate(),
                outline: outline.grown(OVER_MM + skirt),
                height: over,
                skirt,
                sag: drop / over,
            };
            return Some(FlangeDefect { mark, solid: Some(solid) });
        }
    }
    None
}
