//! Volumes of known densities: where boards lie in them, what they are made of, and what is no wood.

use base::{BodyKind, Medium, Stream};
use procedural::wood::{Plank, Wood};

use super::*;

const KINDS: KindDensities = KindDensities { earlywood: 320.0, latewood: 800.0 };

/// A number from 0 to 1 that follows from others.
fn random(words: [usize; 3]) -> f32 {
    let mixed = words.into_iter().fold(7_u64, |mixed, word| {
        let mixed = (mixed ^ word as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ (mixed >> 29)
    });
    (mixed >> 40) as f32 / (1 << 24) as f32
}

fn stack(
    size: [usize; 3],
    voxel_mm: [f32; 3],
    fibres: FibreAxis,
    density: &dyn Fn([usize; 3]) -> f32,
) -> Result<DensityStack, VolumeFault> {
    let mut stack = DensityStack::new(size, voxel_mm, fibres)?;
    for slice in 0..size[0] {
        let voxels = (0..size[1]).flat_map(|row| (0..size[2]).map(move |col| density([slice, row, col])));
        stack.push(&voxels.collect::<Vec<f32>>());
    }
    Ok(stack)
}

fn volume(
    size: [usize; 3],
    voxel_mm: [f32; 3],
    fibres: FibreAxis,
    density: &dyn Fn([usize; 3]) -> f32,
) -> Arc<WoodVolume> {
    Arc::new(stack(size, voxel_mm, fibres, density).expect("room").volume(KINDS))
}

fn board(size_mm: [f64; 3]) -> Wood {
    let mut wood = Wood::from_values(&mut |parameter| parameter.default);
    [wood.board.width_mm, wood.board.length_mm, wood.board.thickness_mm] = size_mm;
    wood
}

/// A ramp of densities is met exactly between voxels, so it says where each point of a board lies: against a turn about
/// the middle of the stack by glam, in every way to lie.
#[test]
fn boards_lie_where_their_numbers_say() {
    let (size, voxel_mm) = ([40, 36, 44], [0.5, 0.4, 0.3]);
    let slopes = Vec3::new(3.0, 5.0, 7.0);
    let mut count = 0;
    for (fibres, order, far_first) in [
        (FibreAxis::Through, [2, 0, 1], false),
        (FibreAxis::Down, [2, 1, 0], true),
        (FibreAxis::Across, [1, 2, 0], false),
    ] {
        let centre = |voxel: [usize; 3], axis: usize| (voxel[axis] as f32 + 0.5) * voxel_mm[axis];
        // Across, along and above of the wood, from the middle of the stack.
        let middle = |axis: usize| 0.5 * size[axis] as f32 * voxel_mm[axis];
        let wood = |voxel: [usize; 3]| {
            let [x, y, z] = order.map(|axis| centre(voxel, axis) - middle(axis));
            Vec3::new(x, if far_first { -y } else { y }, -z)
        };
        let whole = volume(size, voxel_mm, fibres, &|voxel| 500.0 + slopes.dot(wood(voxel)));
        let half = Vec3::from(order.map(middle));
        for way in 0..16 {
            let mut numbers = board([5.0, 9.0, 3.0]);
            let place = &mut numbers.slices;
            (place.along, place.across, place.depth) = (0.25, 0.5, 0.75);
            let turns = way % 4;
            (place.quarter_turns, place.mirrored, place.turned) =
                (f64::from(turns), f64::from(way / 4 % 2), f64::from(way / 8));
            let cut = whole.cut(&numbers);
            let turn = glam::Quat::from_rotation_y(std::f32::consts::FRAC_PI_2 * turns as f32);
            let size = (turn * half).abs();
            let corner = 2.0 * size - Vec3::new(5.0, 9.0, 3.0);
            for point in 0..20 {
                let at = |axis: usize, most: f32| most * random([way as usize, point, axis]);
                let (x, y, depth) = (at(0, 5.0), at(1, 9.0), at(2, 3.0));
                // Turned end for end both x and y run backwards, mirrored x does.
                let (mut u, mut v) = (x, y);
                if way / 8 == 1 {
                    (u, v) = (5.0 - u, 9.0 - v);
                }
                if way / 4 % 2 == 1 {
                    u = 5.0 - u;
                }
                let here = Vec3::new(
                    u + 0.5 * corner.x - size.x,
                    v + 0.25 * corner.y - size.y,
                    size.z - depth - 0.75 * corner.z,
                );
                let wanted = 500.0 + slopes.dot(turn.inverse() * here);
                let found = cut.density(Vec2::new(x, y), depth);
                let clamped = [0, 1, 2].map(|axis| voxel_mm[axis]).into_iter().fold(0.0, f32::max) * 7.0;
                let inner = (turn.inverse() * here).abs().cmplt(half - 0.5).all();
                assert!(
                    (found - wanted).abs() < if inner { 0.05 } else { clamped },
                    "{fibres:?}, way {way}, ({x}, {y}, {depth}): {found} and {wanted}"
                );
                count += usize::from(inner);
            }
        }
    }
    assert!(count > 400, "{count} points within the outer voxels' centres");
}

/// At random voxels, from air to beyond the cell wall: in proportion to density with the ratio of the class table; with
/// others the lines of the module's head.
#[test]
fn coefficients_are_the_laws_at_random_voxels() {
    let density = |voxel: [usize; 3]| 1700.0 * random(voxel);
    let whole = volume([30, 30, 30], [0.2; 3], FibreAxis::Through, &density);
    let mut numbers = board([6.0, 6.0, 6.0]);
    for ratios in [[2.5, 2.5, 2.5], [2.5, 1.1, 0.9], [0.5, 3.0, 1.0]] {
        let media = &mut numbers.media;
        [media.latewood_mu_a_ratio, media.latewood_sigma_i_ratio, media.latewood_k_ratio] = ratios;
        let cut = whole.cut(&numbers);
        for sample in 0..2000 {
            let voxel = [0, 1, 2].map(|axis| (30.0 * random([sample, axis, 99])) as usize);
            let [along, depth, across] = voxel.map(|index| 0.2 * (index as f32 + 0.5));
            let found = cut.at(Vec2::new(across, along), depth);
            let rho = f64::from(density(voxel)).clamp(50.0, 1500.0);
            let shares = [rho.min(320.0) / 320.0, (rho.clamp(320.0, 800.0) - 320.0) / 480.0, rho.max(800.0) / 800.0];
            let law = |earlywood: f64, ratio: f64| {
                earlywood * (shares[0] + (ratio - 1.0) * shares[1]) * if rho > 800.0 { shares[2] } else { 1.0 }
            };
            let wanted = [law(0.08, ratios[0]), law(2.0, ratios[1]), law(10.0, ratios[2])];
            for (found, wanted) in [found.mu_a, found.sigma_i, found.k].into_iter().zip(wanted) {
                assert!((f64::from(found) / wanted - 1.0).abs() < 1.0e-4, "{rho}: {found} and {wanted}");
            }
            if ratios[0] == 2.5 {
                assert!((f64::from(found.mu_a) / (0.08 * rho / 320.0) - 1.0).abs() < 1.0e-4);
            }
            assert!(found.fibre == Vec3::Y && found.class == Class::Clear && found.instance == 0);
        }
    }
}

/// The law is a line between the two kinds, so the mean of the coefficients is what the mean density has.
#[test]
fn mean_coefficients_are_those_of_the_mean_density() {
    let whole = volume([40, 40, 40], [0.15, 0.25, 0.2], FibreAxis::Across, &|voxel| 330.0 + 460.0 * random(voxel));
    let numbers = board([8.0, 7.0, 5.0]);
    let (cut, law) = (whole.cut(&numbers), DensityLaw::new(&numbers.media, KINDS));
    let places =
        (0..20_000).map(|i| (Vec2::new(8.0 * random([i, 1, 0]), 7.0 * random([i, 2, 0])), 5.0 * random([i, 3, 0])));
    let (mut density, mut sums, mut count) = (0.0_f64, [0.0_f64; 3], 0.0);
    for (place, depth) in places {
        let found = cut.at(place, depth);
        density += f64::from(cut.density(place, depth));
        for (sum, one) in sums.iter_mut().zip([found.mu_a, found.sigma_i, found.k]) {
            *sum += f64::from(one);
        }
        count += 1.0;
    }
    for (sum, wanted) in sums.into_iter().zip(law.at((density / count) as f32)) {
        assert!((sum / count / f64::from(wanted) - 1.0).abs() < 1.0e-5, "{} and {wanted}", sum / count);
    }
}

/// One density all over is a plain board: of earlywood at earlywood's density, of latewood at its own, at every point
/// and depth.
#[test]
fn one_density_is_a_plain_board() {
    let stream = Stream::root(3).child("plain");
    for (density, kind) in [(320.0, [0.08, 2.0, 10.0]), (800.0, [0.2, 2.2, 11.0]), (160.0, [0.04, 1.0, 5.0])] {
        let numbers = board([10.0, 12.0, 4.0]);
        let whole = volume([30, 12, 22], [0.5; 3], FibreAxis::Through, &|_| density);
        let plank = Plank::lay(stream, &numbers, Arc::new(whole.cut(&numbers)));
        assert!(plank.instances().is_empty());
        for i in 0..300 {
            let [x, y, depth] = [0, 1, 2].map(|axis| random([i, axis, 5]));
            let matter = plank.slice(20.0 + 12.0 * y).matter(10.0 * x - 5.0, 4.0 * depth);
            let [mu_a, sigma_i, k] = kind;
            let found = matter.medium;
            let wanted = Medium { mu_a, sigma_i, k, fibre: Vec3::Y, gloss: found.gloss, ..Medium::CLEAR_WOOD };
            let same = |a: f32, b: f32| (a / b - 1.0).abs() < 1.0e-5;
            assert!(same(found.mu_a, mu_a) && same(found.sigma_i, sigma_i) && same(found.k, k), "{found:?}");
            assert_eq!(
                (found.n_eff, found.fibre, found.dispersion_deg, found.coat),
                (wanted.n_eff, Vec3::Y, wanted.dispersion_deg, 1.0)
            );
        }
    }
}

/// Voxels of 10 and 20 um are means over 0.05 and 0.06 mm, what is left over at the ends is left out, and coarser ones
/// are as they were.
#[test]
fn fine_voxels_are_put_together() {
    let density = |voxel: [usize; 3]| 300.0 + 600.0 * random(voxel);
    let whole = volume([104, 52, 16], [0.01, 0.02, 0.07], FibreAxis::Through, &density);
    assert_eq!(whole.size, [20, 17, 16]);
    for (found, wanted) in whole.voxel_mm.into_iter().zip([0.05, 0.06, 0.07]) {
        assert!((found - wanted).abs() < 1.0e-6);
    }
    for (block, found) in whole.densities.iter().enumerate() {
        let [slice, row, col] = [block / (17 * 16), block / 16 % 17, block % 16];
        let own = (0..5).flat_map(|i| (0..3).map(move |j| [5 * slice + i, 3 * row + j, col]));
        let wanted = own.map(density).sum::<f32>() / 15.0;
        assert!((found - wanted).abs() < 0.01, "{found} and {wanted}");
    }
}

#[test]
fn what_is_no_wood_is_told() {
    let side = [20, 20, 20];
    let fault = |size: [usize; 3], mm: f32, density: &dyn Fn([usize; 3]) -> f32| {
        let read = stack(size, [mm; 3], FibreAxis::Through, density).and_then(|stack| stack.finish(KINDS));
        let fault = read.expect_err("no wood");
        let text = fault.to_string();
        println!("{text}");
        assert!(text.contains("; "), "{text} has no remedy");
        fault
    };
    let wood = |voxel: [usize; 3]| 300.0 + 500.0 * random(voxel);
    assert!(matches!(fault(side, 0.04, &wood), VolumeFault::TooSmall { .. }));
    assert!(matches!(fault([1 << 12, 1 << 9, 1 << 9], 0.1, &wood), VolumeFault::Large { voxels: 1_073_741_824, .. }));
    assert!(matches!(fault(side, 0.2, &|_| 430.0), VolumeFault::Even { .. }));
    let faint = |voxel: [usize; 3]| if voxel[0].is_multiple_of(2) { 429.0 } else { 431.0 };
    assert!(fault(side, 0.2, &faint).to_string().contains("0.23 % of the mean"));
    assert!(matches!(fault(side, 0.2, &|voxel| 0.1 * wood(voxel)), VolumeFault::Mean { .. }));
    assert!(matches!(fault(side, 0.2, &|voxel| 4.0 * wood(voxel)), VolumeFault::Mean { .. }));
    let hollow = |voxel: [usize; 3]| if voxel[1] < 7 { 0.0 } else { wood(voxel) };
    assert!(fault(side, 0.2, &hollow).to_string().contains("0.0 to 4.0 mm through the slices, 1.4 to 4.0 mm down"));
    // The rows of the stack count from the first, though the near end is the last.
    let down = stack(side, [0.2; 3], FibreAxis::Down, &hollow).expect("room").finish(KINDS).expect_err("air");
    assert!(down.to_string().contains("1.4 to 4.0 mm down and 0.0 to 4.0 mm across"), "{down}");
    assert!(stack(side, [0.2; 3], FibreAxis::Through, &wood).expect("room").finish(KINDS).is_ok());
    // Few dense voxels in even wood are rings, fibres or knots all the same.
    let sparse = |voxel: [usize; 3]| if random(voxel) < 0.04 { 800.0 } else { 400.0 };
    assert!(stack(side, [0.2; 3], FibreAxis::Through, &sparse).expect("room").finish(KINDS).is_ok());
}

/// A margin of air on one side of the stack is found on the face of boards that lie in it, whichever way the stack is
/// turned, and wood begins where it ends; pores that touch no millimetre are no air.
#[test]
fn air_around_the_wood_is_found_on_faces() {
    let size = [40, 40, 40];
    // Above the wood and on its left, where it lies without turns.
    let airy = |voxel: [usize; 3]| {
        if voxel[1] < 5 || voxel[2] < 8 { 12.0 * random(voxel) } else { 300.0 + 300.0 * random(voxel) }
    };
    let whole = volume(size, [0.25; 3], FibreAxis::Through, &airy);
    let place = |depth: f64, across: f64, quarter_turns: u8| StackPlace {
        board_mm: [6.0, 5.0, 4.0],
        shares: [0.5, across, depth],
        quarter_turns,
    };
    let close = |found: f32, wanted: f32, off: f32| assert!((found - wanted).abs() <= off, "{found} and {wanted}");
    close(whole.air_on_face(&place(0.0, 1.0, 0)), 1.0, 0.0);
    close(whole.air_on_face(&place(0.3, 1.0, 0)), 0.0, 0.0);
    close(whole.air_on_face(&place(0.3, 0.0, 0)), 0.4, 0.01);
    close(whole.air_on_face(&place(0.0, 0.9, 2)), 0.3, 0.11);
    close(whole.air_on_face(&place(0.0, 0.0, 2)), 0.0, 0.0);
    // Turned by one, the left side lies up; by three, the right one.
    close(whole.air_on_face(&place(0.0, 0.0, 1)), 1.0, 0.0);
    close(whole.air_on_face(&place(0.0, 1.0, 3)), 0.0, 0.0);
    for (turns, wanted) in [
        (0, [[0.0, 10.0], [2.0, 10.0], [1.25, 10.0]]),
        (1, [[0.0, 10.0], [0.0, 8.75], [2.0, 10.0]]),
        (2, [[0.0, 10.0], [0.0, 8.0], [0.0, 8.75]]),
        (3, [[0.0, 10.0], [1.25, 10.0], [0.0, 8.0]]),
    ] {
        for (found, wanted) in whole.wood_mm(turns).into_iter().flatten().zip(wanted.into_iter().flatten()) {
            close(found, wanted, 0.15);
        }
    }
    // Vessels of 0.3 mm, 0.1 mm apart, are 56 % of the face.
    let porous = |voxel: [usize; 3]| if voxel[1] < 3 && voxel[0] % 4 < 3 && voxel[2] % 4 < 3 { 0.0 } else { 900.0 };
    let oak = volume([80, 40, 80], [0.1; 3], FibreAxis::Through, &porous);
    close(
        oak.air_on_face(&StackPlace { board_mm: [7.0, 7.0, 3.0], shares: [0.5, 0.5, 0.0], quarter_turns: 0 }),
        0.0,
        0.0,
    );
}
