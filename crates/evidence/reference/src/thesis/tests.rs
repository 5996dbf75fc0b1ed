//! The thesis' method against lists by hand, closed forms, and what it does wrong.

use base::{Body, Medium};
use glam::{DVec2, DVec3, Vec3};
use procedural::flat::Flat;

use super::conservative::{PlanarTensor, Stencil};
use super::*;
use transport::fresnel::BoundaryTable;
use transport::line::LineSource;

const CLEAR: Medium = Medium::CLEAR_WOOD;
const YELLOW: [u8; 4] = [255, 255, 0, 255];
const CYAN: [u8; 4] = [0, 255, 255, 255];

fn towards(degrees: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    DVec2::new(cos, sin)
}

fn even(side: usize, colour: [u8; 4]) -> PixelGround {
    painted(DirectionMap::new(side, side, vec![colour; side * side]))
}

/// A painted map on clear wood: its fibres lie in the surface along the map's directions; where alpha is below 1, or
/// there is no direction, they stand upright, and nothing is where alpha is 0.
fn painted(map: DirectionMap) -> PixelGround {
    let boundary = BoundaryTable::new();
    let of = |i: usize| {
        let lying = map.direction(i).filter(|_| map.alpha(i) == 1.0);
        let fibre = lying.map_or(DVec3::Z, |along| along.extend(0.0)).as_vec3();
        (map.alpha(i) > 0.0).then(|| PlanarDiffusion::new(&Medium { fibre, ..CLEAR }, &boundary))
    };
    let walks = (0..map.rows() * map.cols()).map(of).collect();
    PixelGround { pitch_mm: 0.05, map, walks }
}

/// The three ways to draw lines.
const LINES: [SpreadMethod; 3] = [
    SpreadMethod::Lines(LineRule::LinearEquation),
    SpreadMethod::Lines(LineRule::AntiAliased),
    SpreadMethod::Lines(LineRule::Bresenham),
];

impl LightPicture {
    /// All light together.
    fn sum(&self) -> f64 {
        self.light.iter().sum()
    }

    /// Variances along x and y, and the covariance between them [px^2].
    fn variance(&self) -> (DVec2, f64) {
        let centre = self.mean(|at| at);
        let squares = self.mean(|at| (at - centre) * (at - centre));
        let product = self.mean(|at| DVec2::new((at.x - centre.x) * (at.y - centre.y), 0.0));
        (squares, product.x)
    }

    fn mean(&self, of: impl Fn(DVec2) -> DVec2) -> DVec2 {
        let place = |i: usize| DVec2::new((i % self.cols) as f64, (i / self.cols) as f64);
        let sum = self.light.iter().enumerate().fold(DVec2::ZERO, |sum, (i, &light)| sum + of(place(i)) * light);
        sum / self.sum()
    }
}

/// One lit pixel in the middle.
fn dot(side: usize) -> LightPicture {
    let mut picture = LightPicture::dark(side, side);
    picture.light[side / 2 * side + side / 2] = 1.0;
    picture
}

/// Red and blue without green are the vertical, whose slope has no number: every method spreads it upwards, both alike,
/// and colours on either side of it differ from it by no more than the angle between them.
#[test]
fn the_vertical_is_a_direction_like_others() {
    let (red, blue) = (even(41, [255, 0, 0, 255]), even(41, [0, 0, 255, 255]));
    let beside = [even(41, [255, 1, 0, 255]), even(41, [0, 1, 255, 255])];
    for method in LINES.into_iter().chain([SpreadMethod::ON_CLEAR_WOOD]) {
        let upright = spread(&dot(41), &red, method);
        assert_eq!(upright, spread(&dot(41), &blue, method), "{method:?}");
        let (variance, _) = upright.variance();
        assert!(variance.y > 4.0 * variance.x && upright.sum() > 0.99, "{method:?}: {variance}");
        for beside in &beside {
            let far: f64 =
                spread(&dot(41), beside, method).light.iter().zip(&upright.light).map(|(a, b)| (a - b).abs()).sum();
            assert!(far < 0.01, "{method:?}: {far}");
        }
        let black = spread(&dot(41), &even(41, [0, 0, 0, 255]), method);
        assert!((black.sum() - 1.0).abs() < 1e-3, "{method:?}: {}", black.sum());
    }
}

/// Yellow ascends, cyan descends; directions come back within 0.12 degrees.
#[test]
fn colours_are_directions() {
    let root = 0.5f64.sqrt();
    let of = |colour| DirectionMap::new(1, 1, vec![colour]).direction(0);
    assert!((of(YELLOW).expect("a direction") - DVec2::new(root, root)).length() < 1e-12);
    assert!((of(CYAN).expect("a direction") - DVec2::new(root, -root)).length() < 1e-12);
    assert_eq!((of([0, 9, 0, 255]), of([0; 4]), of([7, 0, 7, 255])), (Some(DVec2::X), None, None));
    let colours: Vec<_> = (0..1800).map(|i| DirectionMap::colour(Some(towards(f64::from(i) * 0.1)), 0.5)).collect();
    let map = DirectionMap::new(60, 30, colours);
    for i in 0..1800 {
        let miss = map.direction(i).expect("a direction").perp_dot(towards(i as f64 * 0.1)).abs();
        assert!(miss < 0.12f64.to_radians(), "{} degrees: {miss}", i as f64 * 0.1);
        assert_eq!(map.alpha(i), 128.0 / 255.0);
    }
}

/// Beside a border of unlike coefficients Stam's method makes or loses light, also when each step is solved; the
/// symmetric stencil keeps it to 1e-6. Without a border both do.
#[test]
fn only_the_symmetric_stencil_keeps_light_across_a_border() {
    let side = 121;
    let (lying, upright) = ([0, 255, 0, 255], [255, 0, 0, 255]);
    let sums = |left: [u8; 4], right: [u8; 4], column: f64| {
        let colours = (0..side * side).map(|i| if i % side < side / 2 { left } else { right }).collect();
        let ground = painted(DirectionMap::new(side, side, colours));
        let spot = LaserPoint { at: DVec2::new(column, 60.0), diameter: 9.0, deviation: 2.0 };
        let solved = SpreadMethod::Diffusion { iterations: 20, sweeps: 20 };
        let tensor =
            |walk: &Option<PlanarDiffusion>| walk.map(|walk| PlanarTensor::new(walk.axis, walk.along, walk.across));
        let tensors: Vec<_> = ground.walks.iter().map(tensor).collect();
        let kept = Stencil::new(side, side, 0.05, &tensors).walk(&spot.picture(side, side), 0.05, 10);
        [point(&ground, &spot, SpreadMethod::ON_CLEAR_WOOD).sum(), point(&ground, &spot, solved).sum(), kept.sum()]
    };
    for (column, factor) in [(53.0, -1.0), (61.0, 1.0)] {
        let [once, solved, kept] = sums(lying, upright, column);
        println!("spot at column {column}: Stam {once:.4}, solved {solved:.4}, symmetric {kept:.9}");
        assert!(factor * (once - 1.0) > 0.02 && factor * (solved - 1.0) > 0.02, "Stam {once}, solved {solved}");
        assert!((kept - 1.0).abs() < 1e-6, "symmetric {kept}");
    }
    for kept in sums(lying, lying, 60.0) {
        assert!((kept - 1.0).abs() < 1e-3, "without border {kept}");
    }
}

/// Light spreads by 2 D t along any azimuth of the fibre and in no other way: covariance of a dot against the tensor.
#[test]
fn variance_grows_with_the_tensor_at_every_azimuth() {
    let (side, pitch, dt, steps) = (101, 0.05, 0.02, 6);
    let (along, across) = (0.1667, 0.0315);
    for degrees in (0..=90).step_by(5) {
        let axis = towards(f64::from(degrees));
        let tensors = vec![Some(PlanarTensor::new(axis, along, across)); side * side];
        let light = Stencil::new(side, side, pitch, &tensors).walk(&dot(side), dt, steps);
        let (variance, covariance) = light.variance();
        let grown = variance * pitch * pitch / (2.0 * dt * f64::from(steps));
        let mixed = covariance * pitch * pitch / (2.0 * dt * f64::from(steps));
        let toward = |e: DVec2| e.x * e.x * grown.x + e.y * e.y * grown.y + 2.0 * e.x * e.y * mixed;
        assert!((toward(axis) / along - 1.0).abs() < 1e-4, "{degrees} degrees, along: {}", toward(axis));
        assert!((toward(axis.perp()) / across - 1.0).abs() < 1e-4, "{degrees} degrees, across");
        let main = 0.5 * libm::atan2(2.0 * mixed, grown.x - grown.y).to_degrees();
        assert!((main - f64::from(degrees)).abs() < 0.01, "{degrees} degrees: principal axis {main}");
        assert!(light.light.iter().all(|&l| l > -1e-9), "{degrees} degrees: negative light");
    }
}

/// Coefficients are never negative: up to a ratio of 5.83 the tensor is as asked, beyond it the smaller one is raised
/// by what the angle needs, and axis and larger one stay.
#[test]
fn the_limit_of_the_stencil_raises_the_smaller_coefficient() {
    for ratio in [1.0, 5.3, 5.828, 12.0, 100.0] {
        for tenth in 0..1800 {
            let axis = towards(f64::from(tenth) * 0.1);
            let tensor = PlanarTensor::new(axis, ratio, 1.0);
            let bare = (tensor.xx - tensor.xy.abs()).min(tensor.yy - tensor.xy.abs());
            assert!(bare > -1e-12 * ratio, "ratio {ratio}, {tenth}: {bare}");
            let image = DVec2::new(tensor.xx * axis.x + tensor.xy * axis.y, tensor.xy * axis.x + tensor.yy * axis.y);
            assert!((image - axis * ratio).length() < 1e-9 * ratio, "ratio {ratio}, {tenth}: {image}");
            let short = tensor.xx + tensor.yy - ratio;
            let wanted = if ratio < 5.8284 || tenth % 450 == 0 { 1.0..=1.000_001 } else { 1.0..=ratio / 5.828 };
            assert!(wanted.contains(&(short + 1e-9)), "ratio {ratio}, {tenth}: {short}");
        }
    }
    let (wide, tall) = (PlanarTensor::new(DVec2::X, 1.0, 3.0), PlanarTensor::new(DVec2::Y, 3.0, 1.0));
    assert_eq!((wide.xx, wide.yy), (tall.xx, tall.yy), "the larger coefficient may lie across");
}

/// On an even half space the sum over paths returns the closed form of its weights, and alpha follows from it.
#[test]
fn light_returns_as_the_closed_form_says() {
    let boundary = BoundaryTable::new();
    let knot = Medium { mu_a: 0.22, sigma_i: 3.0, k: 14.0, n_eff: 1.22, ..CLEAR };
    for (medium, dive, below, above) in
        [(CLEAR, 0.0f32, 1.0, 1.0), (CLEAR, 30.0, 1.0, 1.0), (CLEAR, 90.0, 0.6, 0.8), (knot, 80.0, 0.5, 0.6)]
    {
        let fibre = Vec3::new(0.0, dive.to_radians().cos(), dive.to_radians().sin());
        let medium = Medium { fibre, ..medium };
        let closed = PlanarDiffusion::new(&medium, &boundary).reflectance();
        let ground = PixelGround::new(61, 61, 0.25, &vec![Some(medium); 61 * 61]);
        let sum = spread(&dot(61), &ground, SpreadMethod::CONSERVATIVE).sum();
        assert!((sum - closed).abs() < 0.002, "dive {dive}: {sum} against {closed}");
        let alpha = alpha(closed, &boundary);
        assert!((below..=above).contains(&alpha), "dive {dive}: alpha {alpha}");
        assert!((ground.map.alpha(0) - alpha).abs() < 0.002);
    }
}

/// Implicit steps spread a line as the exact Gaussians over path length do: light beyond three distances, within 3 %.
#[test]
fn steps_follow_the_gaussians() {
    let pixels = 401;
    let medium = Medium { fibre: Vec3::X, ..CLEAR };
    let ground = PixelGround::new(1, pixels, 0.05, &vec![Some(medium); pixels]);
    let mut line = LightPicture::dark(1, pixels);
    line.light[200] = 1.0;
    let light = spread(&line, &ground, SpreadMethod::CONSERVATIVE).light;
    let walk = PlanarDiffusion::new(&medium, &BoundaryTable::new());
    for beyond in [10usize, 20, 40] {
        let reach = 0.05 * (beyond as f64 + 0.5);
        let ratio = 1.01;
        let paths = std::iter::successors(Some(0.003), |path| Some(path * ratio)).take_while(|&path| path < 200.0);
        let of = |path: f64| {
            let outside = libm::erfc(reach / (4.0 * walk.along * path).sqrt());
            walk.rate(path) * libm::exp(-walk.mu_a * path) * path * libm::log(ratio) * outside
        };
        let exact: f64 = paths.map(of).sum();
        let stepped: f64 = light[..200 - beyond].iter().chain(&light[201 + beyond..]).sum();
        assert!((stepped / exact - 1.0).abs() < 0.03, "beyond {reach} mm: {stepped} against {exact}");
    }
}

/// In an even knot the passes of absorption come to alpha, whatever their number, and light spreads the same all
/// around.
#[test]
fn knots_absorb_by_alpha_and_spread_evenly() {
    let knot = even(161, [255, 255, 0, 128]);
    for iterations in [1, 10, 25] {
        let method = SpreadMethod::diffusion(iterations);
        let light = point(&knot, &LaserPoint::thesis(DVec2::splat(80.0)), method);
        assert!((light.sum() - 128.0 / 255.0).abs() < 1e-6, "{iterations}: {}", light.sum());
        let (variance, covariance) = light.variance();
        assert!((variance.x / variance.y - 1.0).abs() < 0.02 && covariance.abs() < 0.02 * variance.x, "{variance}");
    }
}

/// On a knot lines are shorter by alpha, and what they leave is multiplied by it.
#[test]
fn lines_on_knots_are_short_and_dim() {
    for method in LINES {
        let [long, short] = [255, 128].map(|alpha| spread(&dot(61), &even(61, [0, 255, 0, alpha]), method));
        let lit = |picture: &LightPicture| picture.light.iter().filter(|&&light| light > 0.0).count();
        assert_eq!((lit(&long), lit(&short)), (41, 21), "{method:?}");
        assert!((long.sum() - 1.0).abs() < 1e-12 && (short.sum() - 128.0 / 255.0).abs() < 1e-12, "{method:?}");
    }
}

/// A line on a plate: unevenly spaced columns get back what entered them, clear wood in the thesis' model returns all
/// of it (times the level that was asked for) and the right model its reflectance; threads change nothing.
#[test]
fn a_line_on_a_plate_keeps_its_light() {
    let plate = |medium| {
        Body::new(Flat { height_mm: 20.0, slope_x: 0.0, slope_y: 0.0, width_mm: 60.0, length_mm: 60.0, medium })
    };
    let x: Vec<f32> = (0..20).map(|i| 0.3 * i as f32 + 0.005 * (i * i) as f32).collect();
    let power: Vec<f32> = (0..20).map(|i| if i == 10 { 3.0 } else { 0.0 }).collect();
    let ask = |body: &Body, method: SpreadMethod, pitch_mm: f64| {
        let (view, row_mm, rows) = (DVec3::Z, 0.1, 40);
        let line = LineSource { body, y: 30.0, line_mm: 0.05, x: &x, power: &power, view, row_mm, rows };
        line_response(&line, &ThesisSettings { method, pitch_mm })
    };
    let body = plate(CLEAR);
    let sum = |light: &[f32]| light.iter().map(|&light| f64::from(light)).sum::<f64>();
    for method in [SpreadMethod::Lines(LineRule::Bresenham), SpreadMethod::ON_CLEAR_WOOD] {
        let answer = ask(&body, method, 0.05);
        assert!((sum(&answer.light) - 3.0).abs() < 2e-4, "{method:?}: {}", sum(&answer.light));
        let column: f64 = answer.light.chunks(20).map(|row| f64::from(row[10])).sum();
        assert!(column > 1.5, "{method:?}: column 10 holds {column}");
    }
    // The central row holds a pixel of +-1/2 deviation and half of both neighbours up to 3/2 deviations.
    let still = SpreadMethod::diffusion(0);
    let centre = sum(&ask(&body, still, 0.05).light[40 * 20..41 * 20]);
    assert!((centre / 3.0 - (0.382_925 + 0.5 * 0.483_461)).abs() < 1e-4, "{centre}");

    let right = SpreadMethod::Conservative { steps: 1 };
    let answer = ask(&body, right, 0.1);
    let closed = PlanarDiffusion::new(&CLEAR, &BoundaryTable::new()).reflectance();
    assert!((sum(&answer.light) / 3.0 - closed).abs() < 0.02, "{} against {closed}", sum(&answer.light) / 3.0);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        assert!(pool.install(|| ask(&body, right, 0.1)) == answer, "{threads} threads change the light");
    }
}
