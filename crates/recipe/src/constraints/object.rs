//! Constraints between the parameters of an object, and with the bench above it.

use base::{Mesh, Parameter};
use procedural::blister::{Blister, Card, Pocket, RIM_MM, Tablet, Web, exclusive_counts, extent, pocket_counts};
use procedural::solid::Placing;
use procedural::wood::EDGE_MOST;

use super::bounds::DrawBounds;
use crate::distribution::Distribution;
use yaml::{YamlReader, number_text};

/// What stands above the object.
const STANDS: [&str; 3] = ["laser.fan_height_mm", "camera.distance_mm", "camera.tilt_deg"];
/// Smallest size of a part that is no mistake of units [mm].
const MIN_SIZE_MM: f64 = 0.01;
/// Part of the half width that an edge of a board may wander away [1].
const EDGE_SHARE: f64 = 0.25;

/// Laser and camera stand above an object that can be `height` high, which follows from `keys` [mm].
fn below_the_bench(scene: &DrawBounds, yaml: &mut YamlReader, height: f64, keys: &[&str], noun: &str) {
    for stand in ["laser.fan_height_mm", "camera.distance_mm"] {
        let tilt = if stand.starts_with("camera") { scene.most("camera.tilt_deg") } else { 0.0 };
        let lowest = scene.least(stand) * libm::cos(tilt.to_radians());
        if lowest <= height {
            let problem = format!(
                "stands {} mm high, and the {noun} can be {} mm thick",
                number_text(lowest),
                number_text(rounded(height))
            );
            let keys: Vec<_> = [stand].into_iter().chain(keys.iter().copied()).chain(["camera.tilt_deg"]).collect();
            scene.fault(yaml, &keys, problem, &format!("laser and camera must be above the {noun}"));
        }
    }
}

/// A board.
pub(super) fn wood(yaml: &mut YamlReader, scene: &DrawBounds) {
    let thickness = scene.most("board.thickness_mm");
    below_the_bench(scene, yaml, thickness, &["board.thickness_mm"], "board");

    edges_stay_apart(yaml, scene);

    for key in ["rot.edge", "wane.edge"] {
        let one = |values: Vec<f64>| values.iter().all(|edge| edge.abs() == 1.0);
        if !scene.distribution(key).and_then(Distribution::values).is_some_and(one) {
            let remedy = "give -1, 1 or {choice: {values: [-1, 1]}}";
            scene.fault(yaml, &[key], "can be something other than -1 and 1".to_owned(), remedy);
        }
    }
}

/// An edge that wanders takes at most a quarter of the half width: beyond it the edges of a narrow board come near to
/// each other, and its warp, which goes by the nominal half width, grows with the square.
fn edges_stay_apart(yaml: &mut YamlReader, scene: &DrawBounds) {
    let keys = ["board.edge_wander_mm", "board.width_mm"];
    let (away, width) = (f64::from(EDGE_MOST) * scene.most(keys[0]), scene.least(keys[1]));
    let room = EDGE_SHARE * 0.5 * width;
    if away > room {
        let [away, width] = [away, width].map(|mm| number_text(rounded(mm)));
        let problem = format!("an edge can lie {away} mm beside its line, and the board can be {width} mm wide");
        let most = number_text((100.0 * room / f64::from(EDGE_MOST)).floor() / 100.0);
        scene.fault(yaml, &keys, problem, &format!("give at most {most} mm of wander for that width, or wider boards"));
    }
}

/// A saw-tooth.
pub(super) fn sawtooth(yaml: &mut YamlReader, scene: &DrawBounds) {
    let keys = ["sawtooth.base_mm", "sawtooth.depth_mm"];
    below_the_bench(scene, yaml, scene.most(keys[0]) + scene.most(keys[1]), &keys, "piece");
    material(yaml, scene);
}

/// A part from a file.
pub(super) fn mesh(yaml: &mut YamlReader, scene: &DrawBounds, mesh: Option<&Mesh>) {
    material(yaml, scene);
    let keys = ["mesh.unit_mm", "mesh.lift_mm", "mesh.rotate_x_deg", "mesh.rotate_y_deg"];
    let Some(mesh) = mesh.filter(|_| scene.concerned(keys.into_iter().chain(STANDS))) else { return };
    let mut placing = Placing::from_values(&mut |parameter| scene.most(&parameter.path()));
    let fixed = keys[2..].iter().all(|turn| scene.least(turn) == scene.most(turn));
    // However it is turned, it is no higher than its box is long across.
    let height = if fixed { placing.extent(mesh).z } else { placing.extent(mesh).length() };
    below_the_bench(scene, yaml, height + placing.lift_mm, &keys, "part");
    placing.unit_mm = scene.least(keys[0]);
    let size = placing.extent(mesh).max_element();
    if size < MIN_SIZE_MM {
        let problem = format!("the part can be {} mm large", number_text(size));
        scene.fault(yaml, &[keys[0]], problem, "give the length of a unit of the file in mm");
    }
}

/// What a solid piece is made of.
fn material(yaml: &mut YamlReader, scene: &DrawBounds) {
    let keys = ["material.matte", "material.gloss", "material.reflectance"];
    let thrown = scene.most(keys[0]) + scene.most(keys[1]) * scene.most(keys[2]);
    if thrown > 1.0 + 1e-9 {
        let problem = format!("the surface can throw back {} of the light", number_text(rounded(thrown)));
        scene.fault(yaml, &keys, problem, "matte plus gloss times reflectance is at most 1");
    }
}

/// A blister pack.
pub(super) fn blister(yaml: &mut YamlReader, scene: &DrawBounds) {
    let keys = ["tablet.band_mm", "tablet.thickness_mm"];
    let (band, thickness) = (scene.most(keys[0]), scene.least(keys[1]));
    if band > thickness {
        let problem =
            format!("the band can be {} mm of a tablet that is {} mm thick", number_text(band), number_text(thickness));
        scene.fault(yaml, &keys, problem, "the straight side is at most the whole thickness");
    }
    defects_have_pockets(yaml, scene);
    let forming = Card::PARAMETERS.iter().chain(Pocket::PARAMETERS).chain(Tablet::PARAMETERS).chain(Web::PARAMETERS);
    let forming: Vec<_> = forming.map(Parameter::path).collect();
    let forming: Vec<_> = forming.iter().map(String::as_str).collect();
    // The stands above it, and what else makes a pack high.
    let others = ["defects.double", "foil.thickness_mm"];
    if !scene.concerned(forming.iter().copied().chain(STANDS).chain(others)) {
        return;
    }
    let (room, height) = largest(scene);
    if scene.concerned(forming.iter().copied()) {
        pockets_fit(yaml, scene, room);
    }
    // What makes most of the height first: the fault stands at the first that the recipe has.
    let first = ["defects.double", "tablet.thickness_mm", "pocket.headroom_mm", "pocket.dome_mm", "foil.thickness_mm"];
    let keys: Vec<_> = first.into_iter().chain(forming).collect();
    below_the_bench(scene, yaml, height, &keys, "pack");
}

/// A pocket has at most one defect of a kind: more than there are pockets are never made.
fn defects_have_pockets(yaml: &mut YamlReader, scene: &DrawBounds) {
    let pockets = most_pockets(scene);
    for count in pocket_counts() {
        let least = scene.least(count);
        if least > pockets {
            let problem = format!("asks for {least} of at most {pockets} pockets");
            let remedy = "a pocket has at most one of a kind: give that many or fewer, or a pack with more pockets";
            scene.fault(yaml, &[count, "pack.columns", "pack.rows"], problem, remedy);
        }
    }
}

/// Most pockets that a pack can have.
fn most_pockets(scene: &DrawBounds) -> f64 {
    scene.most("pack.columns") * scene.most("pack.rows")
}

/// What is said of packs that always lack some of the defects that they are asked for.
pub(super) fn note(scene: &DrawBounds) -> Option<String> {
    let asked = || exclusive_counts().filter(|count| scene.least(count) > 0.0);
    let (pockets, least) = (most_pockets(scene), asked().map(|count| scene.least(count)).sum::<f64>());
    let is_new = scene.concerned(exclusive_counts().chain(["pack.columns", "pack.rows"]));
    (is_new && least > pockets).then(|| {
        let keys: Vec<_> = asked().map(|count| format!("{}{count}", scene.prefix)).collect();
        format!(
            "{}: ask for {least} or more defects of which a pocket has at most one, and a pack has at most {pockets} \
                pockets; some are \
             left out",
            keys.join(", ")
        )
    })
}

/// Pockets that have no room on the card would be left out, or moved apart.
fn pockets_fit(yaml: &mut YamlReader, scene: &DrawBounds, room: [f64; 2]) {
    let tablet =
        ["tablet.length_mm", "tablet.width_mm", "tablet.thickness_mm", "pocket.clearance_mm", "pocket.draft_deg"];
    for (way, room, pitch, count, size) in [
        ("the laser line", room[0], "pack.pitch_x_mm", "pack.columns", "pack.width_mm"),
        ("the scan", room[1], "pack.pitch_y_mm", "pack.rows", "pack.length_mm"),
    ] {
        let keys: Vec<_> = [pitch].into_iter().chain(tablet).collect();
        if scene.most(count) > 1.0 && room > scene.least(pitch) {
            let least = number_text(scene.least(pitch));
            let problem =
                format!("pockets can be {least} mm apart along {way}, and need {} mm", number_text(rounded(room)));
            scene.fault(yaml, &keys, problem, "move them apart, or make them smaller or steeper");
        }
        let whole = (scene.most(count) - 1.0) * scene.most(pitch).max(room) + room + RIM_MM;
        let keys: Vec<_> = [size, count, pitch].into_iter().chain(tablet).collect();
        if whole > scene.least(size) {
            let least = number_text(scene.least(size));
            let problem = format!(
                "the card can be {least} mm along {way}, and its pockets need {} mm",
                number_text(rounded(whole))
            );
            scene.fault(yaml, &keys, problem, "make the card larger, or its pockets fewer, smaller or closer");
        }
    }
}

/// Largest room of a pocket along the laser line and along the scan, and largest height of the pack [mm]: at the ends
/// of the numbers that form it.
fn largest(scene: &DrawBounds) -> ([f64; 2], f64) {
    // All grow with each number but these, of which either end may give the larger one. A warp takes more of the room
    // the smaller the card, and a flat tablet under a high roof leaves the most to be formed for a second one.
    const EITHER: [&[&str]; 6] = [
        &["tablet.shape"],
        &["pocket.dome_mm"],
        &["pocket.turn_deg"],
        &["pack.width_mm", "pack.length_mm"],
        &["tablet.thickness_mm"],
        &["tablet.band_mm"],
    ];
    let (mut room, mut height) = ([0.0f64; 2], 0.0f64);
    for choice in 0..1usize << EITHER.len() {
        let second = |i: usize| choice >> i & 1 == 1;
        let same = |path: &&str| scene.ends(path)[0] == scene.ends(path)[1];
        if (0..EITHER.len()).any(|i| second(i) && EITHER[i].iter().all(same)) {
            continue;
        }
        let formed = Blister::from_values(&mut |parameter| {
            let path = parameter.path();
            let either = EITHER.iter().position(|group| group.contains(&path.as_str()));
            scene.ends(&path)[either.map_or(1, |i| usize::from(second(i)))]
        });
        let own = extent(&formed);
        room = [0, 1].map(|i| room[i].max(own.room_mm[i]));
        height = height.max(own.height_mm);
    }
    (room, height)
}

/// To hundredths, for messages.
fn rounded(number: f64) -> f64 {
    (number * 100.0).round() / 100.0
}
