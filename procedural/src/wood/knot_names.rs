//! What graders call a knot: by its place on the face, by the form of its section, by its size, by its neighbours.
//!
//! Models: names are rules on the numbers of an instance. Place: an arris knot reaches the arris with half its width,
//! an edge knot has its middle in the outer quarter of the width, any other is a face knot. Form: a section whose
//! length is more than
//! [`SPIKE_LENGTHS`] widths is a spike (splay) knot; the length of a section is width / sin(dive). Size: up to
//! [`PIN_MM`] it is a pin knot. Neighbours: [`CLUSTER_LEAST`] knots and more of which each lies within [`CLUSTER_MM`]
//! along the board of the next are a cluster, as whorls are counted in the scanned log. What has cracked has a crack
//! (`knot_inside`). Sources: the names are those of
//! European grading (EN 844, EN 1310); their wording was not at hand, so every threshold here is a **guess** and a
//! constant. The quarter is the margin of structural grading by eye. Limits: the upper face alone is looked at, so an
//! edge knot is one at the margin of the face, not one that only the narrow side shows; a knot that leans across the
//! board reaches further than half its width.

use base::{Class, Instance, KnotNames, KnotPlace};

use super::knot_placement::PlacedKnot;
use super::parameters::Board;

/// A section longer than this times its width is that of a spike knot [1]; a guess.
const SPIKE_LENGTHS: f64 = 4.0;
/// Widest pin knot [mm]; a guess, 5 to 7 are in use.
const PIN_MM: f64 = 5.0;
/// Part of the width, from either arris, in which a knot is an edge knot [1]; a guess.
const EDGE_SHARE: f64 = 0.25;
/// Farthest next member of a cluster, along the board [mm]; as whorls of the scanned log are told apart.
const CLUSTER_MM: f64 = 45.0;
/// Fewest members of a cluster; as whorls of the scanned log are told apart.
const CLUSTER_LEAST: usize = 3;

/// Names the knots among `instances` of a board.
pub(super) fn name(instances: &mut [Instance], board: &Board, knots: &[PlacedKnot]) {
    let is_knot =
        |one: &Instance| matches!(one.class, Class::SoundKnot | Class::DeadKnot | Class::KnotHole | Class::LooseKnot);
    let mut order: Vec<usize> = (0..instances.len()).filter(|&i| is_knot(&instances[i])).collect();
    order.sort_by(|&a, &b| instances[a].y_mm.total_cmp(&instances[b].y_mm));
    let near = |pair: [usize; 2]| instances[pair[1]].y_mm - instances[pair[0]].y_mm <= CLUSTER_MM;
    let groups: Vec<Vec<usize>> = order.chunk_by(|&a, &b| near([a, b])).map(<[usize]>::to_vec).collect();
    for group in groups {
        let is_clustered = group.len() >= CLUSTER_LEAST;
        for i in group {
            let knot = &mut instances[i];
            let from_arris = 0.5 * board.width_mm - (knot.x_mm - board.offset_mm).abs();
            let place = if from_arris <= 0.5 * knot.diameter_mm {
                KnotPlace::Arris
            } else if from_arris < EDGE_SHARE * board.width_mm {
                KnotPlace::Edge
            } else {
                KnotPlace::Face
            };
            let is_spike = SPIKE_LENGTHS * libm::sin(knot.dive_deg.to_radians()) < 1.0;
            let is_pin = knot.diameter_mm <= PIN_MM;
            let is_cracked = knots.iter().any(|placed| placed.knot.id == knot.id && placed.knot.inside.is_cracked());
            knot.knot = Some(KnotNames { place, is_spike, is_pin, is_clustered, is_cracked });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knot([x, y]: [f64; 2], diameter: f64, dive_deg: f64) -> Instance {
        Instance { dive_deg, ..Instance::new(1, Class::DeadKnot, [x, y], diameter, f64::NAN) }
    }

    #[test]
    fn knots_are_called_by_place_form_size_and_neighbours() {
        let board = Board { width_mm: 100.0, offset_mm: 7.0, ..Board::from_values(&mut |p| p.default) };
        let cases = [
            (knot([7.0, 10.0], 12.0, 80.0), "face"),
            (knot([7.0 - 40.0, 200.0], 12.0, 80.0), "edge"),
            (knot([7.0 + 40.0, 400.0], 20.5, 80.0), "arris"),
            (knot([7.0, 600.0], 12.0, 14.0), "face spike"),
            (knot([7.0, 605.0], 5.0, 15.0), "face pin"),
            (knot([7.0, 800.0], 12.0, 80.0), "face cluster"),
            (knot([7.0, 844.0], 4.0, 10.0), "face spike pin cluster"),
            (knot([7.0, 888.0], 12.0, 80.0), "face cluster"),
        ];
        let mut knots: Vec<Instance> = cases.iter().rev().map(|case| case.0).collect();
        knots.push(Instance::new(9, Class::Check, [0.0, 850.0], 3.0, 0.1));
        name(&mut knots, &board, &[]);
        let named: Vec<String> = knots.iter().rev().skip(1).map(|k| k.knot.expect("a knot").text()).collect();
        assert_eq!(named, cases.map(|case| case.1));
        assert_eq!(knots.last().and_then(|check| check.knot), None);
    }
}
