//! Constraints between a board and the stack of slices that it is cut from: keys, sizes, and air where its face can
//! lie.

use super::bounds::DrawBounds;
use crate::distribution::Distribution;
use crate::keys::settings::Settings;
use crate::subject::Subject;
use optical_bench::settings::LogSource;
use wood_picture::{StackPlace, WoodVolume};
use yaml::{YamlReader, number_text};

/// The parameter that says which side of the stack lies up.
const TURNS: &str = "slices.quarter_turns";
/// Where a board lies in the stack, and how large it is: along the fibres, across them, downwards.
const PLACES: [&str; 3] = ["slices.along", "slices.across", "slices.depth"];
const SIZES: [&str; 3] = ["board.length_mm", "board.width_mm", "board.thickness_mm"];
/// Shares of a face that may be air without a word, and at all [1]: its edges may lie on those of the wood.
const AIR: [f32; 2] = [0.05, 0.5];

/// A board from slices has some, their grey is a density and latewood the denser wood.
pub(super) fn settings(yaml: &mut YamlReader, subject: Option<Subject>, settings: &Settings) {
    if subject != Some(Subject::Wood) || settings.log.source != LogSource::Slices {
        return;
    }
    let own = &settings.slices;
    // Slices that are named and cannot be read are a fault of their own.
    if own.stack.asset().is_none() && !yaml.has_fault_of("slices.stack") {
        let remedy = "give `slices: {stack: ..., pixel_mm: ..., white_kg_per_m3: ...}`";
        yaml.joint_fault(&["log.source"], "is `slices`, and no stack of slices is named", remedy);
    }
    // Nor does one default beside a setting at fault say what was meant.
    if yaml.has_fault_of("slices") {
        return;
    }
    if own.black_kg_per_m3 == own.white_kg_per_m3 {
        let keys = ["slices.white_kg_per_m3", "slices.black_kg_per_m3"];
        let problem = format!("black and white are both {} kg/m3", number_text(own.white_kg_per_m3));
        yaml.joint_fault(&keys, problem, "give the densities at grey 0 and at the end of the scale");
    }
    if own.earlywood_kg_per_m3 >= own.latewood_kg_per_m3 {
        let keys = ["slices.latewood_kg_per_m3", "slices.earlywood_kg_per_m3"];
        let [early, late] = [own.earlywood_kg_per_m3, own.latewood_kg_per_m3].map(number_text);
        yaml.joint_fault(&keys, format!("latewood has {late} kg/m3, and earlywood {early}"), "latewood is the denser");
    }
}

/// Boards are no larger than what the slices show, whichever of its sides lies up.
pub(super) fn scene(yaml: &mut YamlReader, slices: Option<&WoodVolume>, scene: &DrawBounds) {
    let Some(slices) = slices else { return };
    let [length, width, depth] = slices.extent_mm().map(f64::from);
    let turns = |sides: [u8; 2]| sides.iter().any(|turn| is_drawn(scene, *turn));
    // Of two ways to lie the narrower one counts.
    let across = |straight: f64, turned: f64| {
        let ways = [(turns([0, 2]), straight), (turns([1, 3]), turned)];
        ways.into_iter().filter(|(lies, _)| *lies).map(|(_, mm)| mm).fold(f64::INFINITY, f64::min)
    };
    let mut fits = true;
    for (key, way, shown) in [
        ("board.length_mm", "long", length),
        ("board.width_mm", "wide", across(width, depth)),
        ("board.thickness_mm", "thick", across(depth, width)),
    ] {
        if scene.most(key) > shown + 1.0e-3 {
            fits = false;
            let [most, shown] = [scene.most(key), shown].map(|mm| number_text((mm * 100.0 + 0.1).floor() / 100.0));
            let problem = format!("the board can be {most} mm {way}, and its slices cover {shown} mm there");
            let remedy = format!("give at most {shown} mm, more slices, or the right size of a voxel");
            scene.fault(yaml, &[key, TURNS], problem, &remedy);
        }
    }
    let found = air(slices, scene).filter(|found| fits && found.share > AIR[1]);
    if let Some(Air { keys, problem, remedy, .. }) = found {
        let keys: Vec<&str> =
            keys.iter().copied().chain(["slices.stack"]).chain(PLACES).chain(SIZES).chain([TURNS]).collect();
        scene.fault(yaml, &keys, problem, &remedy);
    }
}

/// What is said of boards whose face can be air in part.
pub(super) fn note(slices: Option<&WoodVolume>, scene: &DrawBounds) -> Option<String> {
    let Air { keys, problem, remedy, .. } = air(slices?, scene)?;
    let key = keys.first().copied().unwrap_or("slices.stack");
    Some(format!("{}{key}: {problem}; {remedy}", scene.prefix))
}

/// Whether a board can lie with so many quarter turns.
fn is_drawn(scene: &DrawBounds, turn: u8) -> bool {
    let turn = f64::from(turn);
    match scene.distribution(TURNS).and_then(Distribution::values) {
        Some(values) => values.iter().any(|value| value.round() == turn),
        None => (scene.least(TURNS)..=scene.most(TURNS)).contains(&turn),
    }
}

/// Air on the face of a board where there can be most.
struct Air {
    share: f32,
    /// Keys by which the board leaves the wood.
    keys: Vec<&'static str>,
    problem: String,
    remedy: String,
}

/// Looks at the largest board at the ends of what is drawn; `None` where hardly any is found or this class changes
/// nothing of it.
fn air(slices: &WoodVolume, scene: &DrawBounds) -> Option<Air> {
    if !scene.concerned(PLACES.into_iter().chain(SIZES).chain([TURNS])) {
        return None;
    }
    let board_mm = SIZES.map(|key| scene.most(key));
    let ends = PLACES.map(|key| [scene.least(key), scene.most(key)]);
    let places = (0..4_u8).filter(|turn| is_drawn(scene, *turn)).flat_map(|quarter_turns| {
        (0..8).map(move |corner| {
            let shares = [0, 1, 2].map(|axis| ends[axis][corner >> axis & 1]);
            StackPlace { board_mm, shares, quarter_turns }
        })
    });
    let looked = places.map(|place| (slices.air_on_face(&place), place));
    let (share, place) = looked.reduce(|most, one| if one.0 > most.0 { one } else { most })?;
    if share <= AIR[0] {
        return None;
    }
    let extent = slices.turned_extent_mm(place.quarter_turns).map(f64::from);
    let wood = slices.wood_mm(place.quarter_turns).map(|ends| ends.map(f64::from));
    let (mut keys, mut mended) = (Vec::new(), Vec::new());
    for (axis, [first, last]) in wood.into_iter().enumerate() {
        let room = extent[axis] - board_mm[axis];
        let [least, most] = [first, last - board_mm[axis]];
        if most < least - 1.0e-3 {
            keys.push(SIZES[axis]);
            mended.push(format!("`{}` of at most {}", SIZES[axis], rounded(last - first, 100.0, f64::floor)));
        } else if room * ends[axis][0] < least - 1.0e-3 || room * ends[axis][1] > most + 1.0e-3 {
            keys.push(PLACES[axis]);
            let [least, most] = [
                rounded((least / room - 1.0e-6).max(0.0), 1000.0, f64::ceil),
                rounded((most / room + 1.0e-6).min(1.0), 1000.0, f64::floor),
            ];
            mended.push(format!("`{}` from {least} to {most}", PLACES[axis]));
        }
    }
    let [along, across, depth] = wood.map(|ends| ends.map(|mm| rounded(mm, 100.0, f64::round)));
    let problem = format!(
        "{:.0} % of a board's face can be air, which lies around the wood: with `quarter_turns: {}` wood lies {} to \
            {} mm below the \
         upper side of the stack, {} to {} mm from its left and {} to {} mm from its near end",
        100.0 * share,
        place.quarter_turns,
        depth[0],
        depth[1],
        across[0],
        across[1],
        along[0],
        along[1]
    );
    let remedy = match mended.as_slice() {
        [] => "crop the slices to wood".to_owned(),
        mended => format!("give {}, or crop the slices to wood", mended.join(" and ")),
    };
    Some(Air { share, keys, problem, remedy })
}

/// A number in steps of one part of so many.
fn rounded(number: f64, parts: f64, way: fn(f64) -> f64) -> String {
    number_text(way(number * parts) / parts)
}
