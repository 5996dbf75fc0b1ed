//! Wavefront OBJ: `v` and `f` lines, through tobj.

use std::io::{BufRead, Read};

use super::soup::{TriangleSoup, fan};

/// A reader that counts lines, by which a fault is placed.
struct CountedLines<'a> {
    left: &'a [u8],
    read: usize,
}

impl Read for CountedLines<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let read = self.left.read(into)?;
        Ok(read)
    }
}

impl BufRead for CountedLines<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        Ok(self.left)
    }

    fn consume(&mut self, bytes: usize) {
        self.read += usize::from(bytes > 0);
        self.left = &self.left[bytes..];
    }
}

pub(super) fn read_obj(bytes: &[u8]) -> Result<TriangleSoup, String> {
    let mut lines = CountedLines { left: bytes, read: 0 };
    let options = tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..tobj::LoadOptions::default() };
    let none = |_: &std::path::Path| Err(tobj::LoadError::MaterialParseError);
    let read = tobj::load_obj_buf(&mut lines, &options, none);
    // What shows only when all is read is told of the last line.
    let last = if lines.left.is_empty() { ", the last" } else { "" };
    let (models, _) = read.map_err(|error| format!("{error}, at line {}{last}", lines.read))?;
    let mut soup = TriangleSoup::default();
    for model in models {
        let mesh = model.mesh;
        // A file of at most some MB has fewer corners than 2^32.
        let first = soup.corners.len() as u32;
        soup.corners.extend(mesh.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
        let indices: Vec<u32> = mesh.indices.iter().map(|corner| corner.saturating_add(first)).collect();
        if mesh.face_arities.is_empty() {
            soup.triangles.extend(indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]));
            continue;
        }
        let mut from = 0;
        for arity in mesh.face_arities {
            let end = (from + arity as usize).min(indices.len());
            fan(&indices[from..end], &mut soup.triangles);
            from = end;
        }
    }
    Ok(soup)
}
