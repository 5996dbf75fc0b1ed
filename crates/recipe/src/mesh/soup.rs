//! Triangle soup: corners and triangles as a file has them, before anything is checked.

/// Corners and triangles as a file has them.
#[derive(Debug, Default)]
pub(super) struct TriangleSoup {
    /// Places of the corners, in units of the file.
    pub corners: Vec<[f32; 3]>,
    /// Numbers of three corners each.
    pub triangles: Vec<[u32; 3]>,
}

/// A polygon of `corners` as a fan of triangles.
pub(super) fn fan(corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    triangles.extend(corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]));
}
