//! STL, binary and text, through stl_io. Corners of one place become one.

use std::io::Cursor;

use super::soup::TriangleSoup;

/// Bytes before the first triangle of a binary file, and of each.
const HEADER_BYTES: usize = 84;
const TRIANGLE_BYTES: usize = 50;

pub(super) fn read_stl(bytes: &[u8]) -> Result<TriangleSoup, String> {
    let mut bytes = bytes.to_vec();
    let count =
        bytes.get(HEADER_BYTES - 4..HEADER_BYTES).map(|n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]) as usize);
    let long = |count: usize| count.saturating_mul(TRIANGLE_BYTES).saturating_add(HEADER_BYTES);
    if count.is_some_and(|count| long(count) == bytes.len()) {
        // A binary header may say `solid` too, which the reader would take for a text.
        bytes[..HEADER_BYTES - 4].fill(0);
    } else if bytes.starts_with(b"solid") && !bytes.contains(&0) {
        // A solid without a name has no blank.
        bytes.insert("solid".len(), b' ');
    } else {
        return Err(match count {
            Some(count) => {
                format!("it has {} bytes; {count} triangles, as its byte 80 says, have {}", bytes.len(), long(count))
            }
            None => format!("it ends after {} bytes, before its first triangle", bytes.len()),
        });
    }
    let mut soup = TriangleSoup::default();
    let mut known = std::collections::HashMap::new();
    let mut source = Cursor::new(&bytes);
    let triangles = stl_io::create_stl_reader(&mut source).map_err(|error| error.to_string())?;
    for (number, triangle) in triangles.enumerate() {
        let triangle = triangle.map_err(|error| format!("{error}, in facet {}", number + 1))?;
        soup.triangles.push(triangle.vertices.map(|corner| {
            *known.entry(corner.0.map(f32::to_bits)).or_insert_with(|| {
                soup.corners.push(corner.0);
                soup.corners.len() as u32 - 1
            })
        }));
    }
    Ok(soup)
}
