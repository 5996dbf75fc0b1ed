//! Mesh files: OBJ, STL (both forms) and PLY (all three forms) -> `base::Mesh`, in the file's own units.
//!
//! The ending of the name says which; other crates read them, and what they take is looked at again: numbers are
//! finite, corners exist, something has an area. Triangles without area and corners that no triangle has are left out.
//! Colours, normals, textures and materials are not read. Polygons become fans about their first corner, so they must
//! be convex.

mod obj;
mod ply;
mod soup;
mod stl;
#[cfg(test)]
mod tests;

use std::panic::{AssertUnwindSafe, catch_unwind};

use base::Mesh;
use glam::Vec3;

use self::soup::TriangleSoup;
use crate::asset::{Asset, AssetFault};

/// Endings of the files that can be read.
pub const ENDINGS: [&str; 3] = ["obj", "stl", "ply"];

/// Most triangles of a part.
const MAX_TRIANGLES: usize = 4_000_000;
/// Greatest coordinate that counts as a number of some unit.
const MAX_COORDINATE: f32 = 1e9;

/// The triangles of `file`.
///
/// # Errors
/// What is wrong, with its place in the file, and what to do.
pub(crate) fn read_mesh(file: &Asset) -> Result<Mesh, AssetFault> {
    let ending = file.name().rsplit_once('.').map(|(_, ending)| ending.to_ascii_lowercase()).unwrap_or_default();
    let read: fn(&[u8]) -> Result<TriangleSoup, String> = match ending.as_str() {
        "obj" => obj::read_obj,
        "stl" => stl::read_stl,
        "ply" => ply::read_ply,
        _ => {
            let problem = format!("`{}` has the ending of no kind of mesh that is read", file.name());
            return Err(AssetFault::new(problem, format!("give a file that ends in .{}", ENDINGS.join(", ."))));
        }
    };
    // Readers of other crates may panic on content that was made to mislead.
    let soup = catch_unwind(AssertUnwindSafe(|| read(file.bytes())));
    let soup = soup.unwrap_or_else(|_| Err("the reader gave up on its content".into()));
    let wrong = |problem: String| {
        AssetFault::new(
            format!("`{}`: {problem}", file.name()),
            format!("export the part as {} anew", ending.to_ascii_uppercase()),
        )
    };
    check(soup.map_err(wrong)?).map_err(wrong)
}

/// A soup that is a mesh, less what has no area.
fn check(soup: TriangleSoup) -> Result<Mesh, String> {
    let TriangleSoup { corners, triangles } = soup;
    if triangles.len() > MAX_TRIANGLES {
        return Err(format!("it has {} triangles, more than {MAX_TRIANGLES}", triangles.len()));
    }
    let whole = |corner: &[f32; 3]| corner.iter().all(|c| c.abs() <= MAX_COORDINATE);
    if let Some(number) = corners.iter().position(|corner| !whole(corner)) {
        return Err(format!("corner {} is at {:?}", number + 1, corners[number]));
    }
    let mut mesh = Mesh::default();
    let mut numbers = vec![u32::MAX; corners.len()];
    for (number, triangle) in triangles.iter().enumerate() {
        if let Some(corner) = triangle.iter().find(|&&corner| corner as usize >= corners.len()) {
            let (triangle, corner) = (number + 1, u64::from(*corner) + 1);
            return Err(format!("triangle {triangle} has corner {corner} of {}", corners.len()));
        }
        let [a, b, c] = triangle.map(|corner| Vec3::from(corners[corner as usize]).as_dvec3());
        if (b - a).cross(c - a).length_squared() == 0.0 {
            continue;
        }
        mesh.triangles.push(triangle.map(|corner| {
            let own = &mut numbers[corner as usize];
            if *own == u32::MAX {
                *own = mesh.positions.len() as u32;
                mesh.positions.push(Vec3::from(corners[corner as usize]));
            }
            *own
        }));
    }
    if mesh.triangles.is_empty() {
        return Err(match triangles.len() {
            0 => "it has no triangle".into(),
            n => format!("none of its {n} triangles has an area"),
        });
    }
    Ok(mesh)
}
