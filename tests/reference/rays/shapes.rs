//! Bodies as triangles, for both sides.

use base::Mesh;
use glam::{DVec3, Vec3};

use super::object::Facet;

/// The triangles of a mesh, all of one colour.
pub fn facets(mesh: &Mesh, matte: f64) -> Vec<Facet> {
    let corner = |i: u32| super::exact(mesh.positions[i as usize]);
    mesh.triangles.iter().map(|t| Facet::new(t.map(corner), matte)).collect()
}

/// A closed body over the rectangle `x` x `y` with the upper surface `height` on `steps` squares and a flat floor at 0.
pub fn raised(x: [f64; 2], y: [f64; 2], steps: [u32; 2], height: impl Fn(f64, f64) -> f64) -> Mesh {
    let [nx, ny] = steps;
    let at = |i: u32, j: u32| {
        let place = |[low, high]: [f64; 2], i: u32, n: u32| low + (high - low) * f64::from(i) / f64::from(n);
        (place(x, i, nx), place(y, j, ny))
    };
    let single = |x: f64, y: f64, z: f64| Vec3::new(x as f32, y as f32, z as f32);
    let mut mesh = Mesh::default();
    for level in 0..2 {
        for (j, i) in (0..=ny).flat_map(|j| (0..=nx).map(move |i| (j, i))) {
            let (x, y) = at(i, j);
            mesh.positions.push(single(x, y, if level == 0 { height(x, y) } else { 0.0 }));
        }
    }
    let index = |level: u32, i: u32, j: u32| level * (nx + 1) * (ny + 1) + j * (nx + 1) + i;
    let mut quad = |a: u32, b: u32, c: u32, d: u32| mesh.triangles.extend([[a, b, c], [a, c, d]]);
    for (j, i) in (0..ny).flat_map(|j| (0..nx).map(move |i| (j, i))) {
        quad(index(0, i, j), index(0, i + 1, j), index(0, i + 1, j + 1), index(0, i, j + 1));
        quad(index(1, i, j + 1), index(1, i + 1, j + 1), index(1, i + 1, j), index(1, i, j));
    }
    for i in 0..nx {
        quad(index(1, i, 0), index(1, i + 1, 0), index(0, i + 1, 0), index(0, i, 0));
        quad(index(0, i, ny), index(0, i + 1, ny), index(1, i + 1, ny), index(1, i, ny));
    }
    for j in 0..ny {
        quad(index(0, 0, j), index(0, 0, j + 1), index(1, 0, j + 1), index(1, 0, j));
        quad(index(1, nx, j), index(1, nx, j + 1), index(0, nx, j + 1), index(0, nx, j));
    }
    mesh
}

/// A ball of `radius` about `centre`, triangles between `steps` meridians and half as many circles.
pub fn ball(centre: DVec3, radius: f64, steps: u32) -> Mesh {
    let circles = steps / 2;
    let mut mesh = Mesh::default();
    for (j, i) in (0..=circles).flat_map(|j| (0..steps).map(move |i| (j, i))) {
        let polar = std::f64::consts::PI * f64::from(j) / f64::from(circles);
        let azimuth = std::f64::consts::TAU * f64::from(i) / f64::from(steps);
        let (up, out) = (polar.cos(), polar.sin());
        let place = centre + radius * DVec3::new(out * azimuth.cos(), out * azimuth.sin(), up);
        mesh.positions.push(place.as_vec3());
    }
    let index = |i: u32, j: u32| j * steps + i % steps;
    for (j, i) in (0..circles).flat_map(|j| (0..steps).map(move |i| (j, i))) {
        if j > 0 {
            mesh.triangles.push([index(i, j), index(i, j + 1), index(i + 1, j)]);
        }
        if j + 1 < circles {
            mesh.triangles.push([index(i + 1, j), index(i, j + 1), index(i + 1, j + 1)]);
        }
    }
    mesh
}
