//! PLY, text and binary of both byte orders, through ply-rs-bw: x, y, z of `vertex`, the corners of `face`.

use std::io::Cursor;

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

use super::soup::{TriangleSoup, fan};

/// An element: what is known of a vertex or a face.
#[derive(Debug)]
struct PlyElement {
    place: [f32; 3],
    corners: Vec<i64>,
}

impl PropertyAccess for PlyElement {
    fn new() -> Self {
        Self { place: [f32::NAN; 3], corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if let Some(axis) = ["x", "y", "z"].iter().position(|axis| *axis == name) {
            let Some(number) = property.to_f32_lossy() else { return PropertyAccessResult::UnsupportedType };
            self.place[axis] = number;
            return PropertyAccessResult::Set;
        }
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        self.corners = match property {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

pub(super) fn read_ply(bytes: &[u8]) -> Result<TriangleSoup, String> {
    let describe = |error: ParseError| error.to_string().replace(['\n', '\t'], " ");
    let mut reader = Reader::new(Cursor::new(bytes));
    let parser = Parser::<PlyElement>::new();
    let header = parser.read_header(&mut reader).map_err(describe)?;
    let mut soup = TriangleSoup::default();
    for element in header.elements.values() {
        // Each has a byte at least, unless it is empty.
        if element.count > bytes.len() || (element.count > 0 && element.properties.is_empty()) {
            return Err(format!("{} elements `{}` do not fit {} bytes", element.count, element.name, bytes.len()));
        }
        let read = parser.read_payload_for_element(&mut reader, element, &header).map_err(describe)?;
        match element.name.as_str() {
            "vertex" => soup.corners = read.iter().map(|vertex| vertex.place).collect(),
            "face" => {
                for (number, face) in read.iter().enumerate() {
                    let corners = face.corners.iter().map(|&corner| u32::try_from(corner));
                    let corners: Result<Vec<u32>, _> = corners.collect();
                    let corners = corners.map_err(|_| format!("face {} has a corner below 0", number + 1))?;
                    fan(&corners, &mut soup.triangles);
                }
            }
            _ => {}
        }
    }
    Ok(soup)
}
