//! One box in every form that is read, and 20 files that are none.

use super::*;

const CORNERS: [[f32; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [2.0, 0.0, 0.0],
    [2.0, 3.0, 0.0],
    [0.0, 3.0, 0.0],
    [0.0, 0.0, 1.5],
    [2.0, 0.0, 1.5],
    [2.0, 3.0, 1.5],
    [0.0, 3.0, 1.5],
];
const QUADS: [[usize; 4]; 6] = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

fn read_as(name: &str, bytes: impl Into<Vec<u8>>) -> Result<Mesh, AssetFault> {
    read_mesh(&Asset::new(name, bytes.into()))
}

/// The box's triangles with places for corners, in order.
fn places(mesh: &Mesh) -> Vec<[[f32; 3]; 3]> {
    let mut all: Vec<_> =
        mesh.triangles.iter().map(|t| t.map(|corner| mesh.positions[corner as usize].to_array())).collect();
    all.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    all
}

fn triangles() -> Vec<[usize; 3]> {
    QUADS.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect()
}

fn obj() -> String {
    let corners: String = CORNERS.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let quads: String = QUADS.iter().map(|q| format!("f {}\n", q.map(|c| (c + 1).to_string()).join(" "))).collect();
    format!("# a box\nmtllib none.mtl\no box\n{corners}{quads}")
}

fn stl() -> String {
    let vertex = |c: usize| CORNERS[c].map(|x| x.to_string()).join(" ");
    let facet = |t: &[usize; 3]| {
        let corners: String = t.iter().map(|&c| format!("vertex {}\n", vertex(c))).collect();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    format!("solid box\n{}endsolid box\n", triangles().iter().map(facet).collect::<String>())
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = b"solid, but binary".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(12u32.to_le_bytes());
    for t in triangles() {
        bytes.extend([0; 12]);
        bytes.extend(t.iter().flat_map(|&c| CORNERS[c]).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

fn ply_header(form: &str) -> String {
    format!(
        "ply\nformat {form} 1.0\ncomment a box\nelement vertex 8\nproperty float x\nproperty float y\nproperty float \
            z\n\
         property uchar red\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

fn ply() -> String {
    let corners: String = CORNERS.iter().map(|[x, y, z]| format!("{x} {y} {z} 7\n")).collect();
    let quads: String = QUADS.iter().map(|q| format!("4 {}\n", q.map(|c| c.to_string()).join(" "))).collect();
    format!("{}{corners}{quads}", ply_header("ascii"))
}

fn binary_ply(big: bool) -> Vec<u8> {
    let form = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = ply_header(form).into_bytes();
    for corner in CORNERS {
        bytes.extend(corner.iter().flat_map(|x| if big { x.to_be_bytes() } else { x.to_le_bytes() }));
        bytes.push(7);
    }
    for quad in QUADS {
        bytes.push(4);
        bytes.extend(quad.iter().flat_map(|&c| if big { (c as i32).to_be_bytes() } else { (c as i32).to_le_bytes() }));
    }
    bytes
}

/// Every form gives the same twelve triangles over eight corners.
#[test]
fn every_form_says_the_same() {
    let expected = places(&read_as("box.obj", obj()).expect("a box"));
    let mut by_hand: Vec<_> = triangles().iter().map(|t| t.map(|c| CORNERS[c])).collect();
    by_hand.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    assert_eq!(expected, by_hand);
    // Corners counted from the end, and with normals and textures beside them.
    let back: String =
        QUADS.iter().map(|q| format!("f {}\n", q.map(|c| format!("-{}/1/1", 8 - c)).join(" "))).collect();
    let corners = obj().split("f ").next().map(str::to_owned).expect("corners");
    let back = format!("{corners}vt 0 0\nvn 0 0 1\n{back}");
    let forms: [(&str, Vec<u8>); 7] = [
        ("box.OBJ", back.into()),
        ("box.stl", stl().into()),
        ("box.stl", stl().replace("solid box", "solid").into()),
        ("box.stl", binary_stl()),
        ("box.ply", ply().into()),
        ("box.ply", binary_ply(false)),
        ("box.ply", binary_ply(true)),
    ];
    for (number, (name, bytes)) in forms.into_iter().enumerate() {
        let mesh = read_as(name, bytes).unwrap_or_else(|fault| panic!("{name} {number}: {fault:?}"));
        assert_eq!((places(&mesh), mesh.positions.len()), (expected.clone(), 8), "{name} {number}");
    }
    // What has no area, and corners that nothing has, are left out.
    let more = format!("{}v 900 900 900\nf 1 1 2\n", obj());
    let mesh = read_as("box.obj", more).expect("a box");
    assert_eq!((mesh.triangles.len(), mesh.positions.len()), (12, 8));
}

/// Twenty files that are no mesh: each says what is wrong and where, and nothing panics.
#[test]
fn faults_name_their_place() {
    let cut = |bytes: Vec<u8>, length: usize| bytes[..length].to_vec();
    let (obj, stl, ply) = (obj(), stl(), ply());
    let faulty: [(&str, Vec<u8>, &str); 20] = [
        ("box.gltf", obj.clone().into(), ".obj, .stl, .ply"),
        ("box", obj.clone().into(), ".obj, .stl, .ply"),
        ("box.obj", Vec::new(), "no triangle"),
        ("box.obj", obj.replace("v 2 0 0\n", "v 2 O 0\n").into(), "line 5"),
        ("box.obj", obj.replace("v 2 0 0\n", "v 2 0\n").into(), "line 5"),
        ("box.obj", obj.replace("f 5 6 7 8", "f 5 six 7").into(), "line 13"),
        ("box.obj", obj.replace("f 5 6 7 8", "f 5 6 9").into(), "out of bounds"),
        ("box.obj", obj.replace("v 2 0 0\n", "v nan 0 0\n").into(), "NaN"),
        ("box.obj", obj.replace("v 2 0 0\n", "v 1e30 0 0\n").into(), "1e30"),
        ("box.obj", b"v 0 0 0\nf 1 1 1\n".to_vec(), "none of its 1 triangles has an area"),
        ("box.obj", vec![0xff; 100], "line 1"),
        ("box.stl", Vec::new(), "ends after 0 bytes"),
        ("box.stl", cut(binary_stl(), 400), "12 triangles"),
        ("box.stl", stl.replacen("vertex 0 3 0", "vertex 0 3", 1).into(), "facet 1"),
        ("box.stl", stl.replace("endsolid box\n", "").into(), "facet 13"),
        ("box.ply", obj.into(), "Line 1"),
        ("box.ply", ply.replace("2 3 0 7", "2 3 zero 7").into(), "Line 14"),
        ("box.ply", ply.replace("4 0 3 2 1", "4 0 3 2 -1").into(), "face 1 has a corner below 0"),
        ("box.ply", ply.replace("element vertex 8", "element vertex 4000000000").into(), "do not fit"),
        ("box.ply", cut(binary_ply(true), 300), "fill whole buffer"),
    ];
    for (number, (name, bytes, words)) in faulty.into_iter().enumerate() {
        let AssetFault { problem, remedy } = read_as(name, bytes).expect_err("it is no mesh");
        assert!(format!("{problem}; {remedy}").contains(words), "{number}: {problem}; {remedy}");
    }
}

/// Bytes changed at every place: a mesh or a fault, never a panic.
#[test]
fn damage_never_panics() {
    for (name, bytes) in [
        ("a.obj", obj().into_bytes()),
        ("a.stl", stl().into_bytes()[..300].to_vec()),
        ("a.stl", binary_stl()),
        ("a.ply", ply().into_bytes()),
        ("a.ply", binary_ply(false)),
    ] {
        for at in 0..bytes.len() {
            for change in [0x01, 0x10, 0x80] {
                let mut bytes = bytes.clone();
                bytes[at] ^= change;
                let given_up = read_as(name, bytes).is_err_and(|fault| fault.problem.contains("gave up"));
                assert!(!given_up, "{name}: byte {at} changed by {change}");
            }
        }
    }
}
