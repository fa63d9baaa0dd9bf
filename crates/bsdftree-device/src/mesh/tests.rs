//! Each format by itself: what is read, what is refused, and that nothing hostile does harm.

use glam::{DVec3, dvec3};
use proptest::prelude::*;

use super::parts::Made;
use super::{Format, MeshFile, Octree, read_octree};
use crate::error::DeviceError;
use crate::options::Limits;

fn read(format: Format, bytes: impl AsRef<[u8]>) -> Result<MeshFile, DeviceError> {
    format.read(bytes.as_ref(), "m", &Limits::DEFAULT)
}

/// Triangles of a part in their places.
fn places(mesh: &MeshFile, part: usize) -> Vec<[DVec3; 3]> {
    let triangles = mesh.parts[part].triangles.iter();
    triangles.map(|t| t.map(|k| mesh.vertices.positions[k as usize])).collect()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn obj_indices_count_from_both_ends() {
    for face in ["f 1 2 3", "f -4 -3 -2", "f 1// 2/ 3//", "f 1/0/0 2//0 3/0"] {
        let mesh = read(Format::Obj, format!("{SQUARE}{face}\n")).unwrap();
        assert_eq!(places(&mesh, 0), [[DVec3::ZERO, DVec3::X, dvec3(1.0, 1.0, 0.0)]], "{face}");
        assert!(mesh.vertices.normals.is_empty() && mesh.vertices.uvs.is_empty());
    }
    let text = format!("{SQUARE}vt .5\nvt 1 2 3\nvn 0 0 2\nf 1/1/1 2/-1/-1 3/1/1 \\\n 4/2/1\n");
    let mesh = read(Format::Obj, text).unwrap();
    assert_eq!((mesh.vertices.positions.len(), mesh.parts[0].triangles.len()), (4, 2));
    assert!(mesh.vertices.normals.iter().all(|n| *n == glam::Vec3::Z));
    assert_eq!(mesh.vertices.uvs[1].to_array(), [1.0, 2.0]);
}

#[test]
fn obj_materials_are_named_by_usemtl_else_by_group() {
    let text = format!(
        "{SQUARE}f 1 2 3\ng wall left\nf 1 2 4\nusemtl red\nf 1 3 4\ng other\nf 2 3 4\nusemtl blue # why not\nf 1 2 3\n\
         usemtl red\nf 1 2 3\ncurv 1 2\n"
    );
    let mesh = read(Format::Obj, text).unwrap();
    let named = |name: &str| Made::Named(name.to_owned());
    let made: Vec<_> = mesh.parts.iter().map(|p| (p.material.clone(), p.triangles.len(), p.line)).collect();
    assert_eq!(
        made,
        [(Made::Unsaid, 1, 5), (named("wall"), 1, 7), (named("red"), 3, 9), (named("blue"), 1, 13)]
    );
    assert_eq!(mesh.vertices.positions.len(), 4, "corners are shared");
    assert_eq!(mesh.warnings, ["m: 1 statements are left out, the first is 'curv'"]);
}

#[test]
fn obj_polygons_may_be_concave_and_corners_differ_by_normal() {
    let arrow = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nf 1 2 3 4 5\nf 1 1 2\n";
    let mesh = read(Format::Obj, arrow).unwrap();
    let area: f64 = places(&mesh, 0).iter().map(|[a, b, c]| 0.5 * (b - a).cross(c - a).z).sum();
    assert_eq!((area, mesh.parts[0].triangles.len()), (10.0, 3));
    assert_eq!(mesh.warnings, ["m: 1 faces are left out: they have no area"]);
    let mixed = format!("{SQUARE}vn 1 0 1\nvn 0 0 1\nf 1//1 2//1 3//1\nf 1//2 3//2 4\n");
    let mesh = read(Format::Obj, mixed).unwrap();
    assert_eq!((mesh.vertices.positions.len(), mesh.vertices.normals.len()), (6, 6));
    assert_eq!(mesh.vertices.normals[5], glam::Vec3::ZERO);
}

#[test]
fn obj_errors_name_the_line() {
    for (text, what) in [
        ("v 1 2", "m:1: expected 3 coordinates of a vertex, found the end of the line"),
        ("v 1 2 x", "found 'x'"),
        ("v 1 2 nan", "found 'nan'"),
        ("\nvn 0 0 0", "m:2: expected a normal with a length"),
        ("v 0 0 0\nf 1 1", "m:2: expected a face of at least 3 corners, found '2'"),
        ("v 0 0 0\nf 1 1 2", "one of the 1 vertices before, found '2'"),
        ("v 0 0 0\nf 1 1 -2", "found '-2'"),
        ("v 0 0 0\nf 0 1 1", "other than 0, found '0'"),
        ("v 0 0 0\nf 1/1 1 1", "texture vertices before, found '1/1'"),
        ("v 0 0 0\nf 1/1/1/1 1 1", "v/vt/vn"),
        ("v 0 0 0\nf 1 1 99999999999999999999", "found '99999999999999999999'"),
    ] {
        let error = read(Format::Obj, text).err().expect(text).to_string();
        assert!(error.contains(what), "{text}: {error}");
    }
    let limits = Limits { surfaces: 1, ..Limits::DEFAULT };
    let error = Format::Obj.read(format!("{SQUARE}f 1 2 3 4").as_bytes(), "m", &limits).err().unwrap();
    assert!(error.to_string().contains("m:5: the scene has more than 1 triangles"), "{error}");
}

const HEADER: &str = "element vertex 4\nproperty float x\nproperty double y\nproperty float z\nproperty uchar red\n\
                      property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n\
                      element face 2\nproperty list uchar int vertex_indices\nproperty float quality\nend_header\n";

fn ply_vertices() -> [[f64; 8]; 4] {
    [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]].map(|[x, y, z]| [x, y, z, 0., 0., 3., x, 2. * y])
}

fn binary_ply(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut bytes =
        format!("ply\nformat binary_{order}_endian 1.0\ncomment made by hand\n{HEADER}").into_bytes();
    let float = |x: f64| if big { (x as f32).to_be_bytes() } else { (x as f32).to_le_bytes() };
    for [x, y, z, nx, ny, nz, s, t] in ply_vertices() {
        bytes.extend(float(x));
        bytes.extend(if big { y.to_be_bytes() } else { y.to_le_bytes() });
        bytes.extend(float(z));
        bytes.push(7);
        [nx, ny, nz, s, t].into_iter().for_each(|x| bytes.extend(float(x)));
    }
    for face in [&[0i32, 1, 2][..], &[0, 2, 3]] {
        bytes.push(face.len() as u8);
        face.iter().for_each(|k| bytes.extend(if big { k.to_be_bytes() } else { k.to_le_bytes() }));
        bytes.extend(float(0.5));
    }
    bytes
}

fn text_ply() -> String {
    let vertices =
        ply_vertices().map(|[x, y, z, nx, ny, nz, s, t]| format!("{x} {y} {z} 7 {nx} {ny} {nz} {s} {t}\n"));
    format!("ply\nformat ascii 1.0\n{HEADER}{}3 0 1 2 .5\n3 0 2 3 .5\n", vertices.concat())
}

#[test]
fn ply_is_the_same_in_text_and_in_both_byte_orders() {
    let text = read(Format::Ply, text_ply()).unwrap();
    assert_eq!(text.parts[0].triangles.len(), 2);
    assert_eq!(places(&text, 0)[1], [DVec3::ZERO, dvec3(1.0, 1.0, 0.0), DVec3::Y]);
    assert!(text.vertices.normals.iter().all(|n| *n == glam::Vec3::Z));
    assert_eq!(text.vertices.uvs[2].to_array(), [1.0, 2.0]);
    for big in [false, true] {
        let binary = read(Format::Ply, binary_ply(big)).unwrap();
        assert_eq!(
            (&binary.vertices, &binary.parts[0].triangles),
            (&text.vertices, &text.parts[0].triangles)
        );
    }
}

#[test]
fn ply_errors_name_line_or_byte() {
    let broken = text_ply().replace("3 0 2 3", "3 0 2 4");
    let error = read(Format::Ply, broken).err().unwrap().to_string();
    assert!(error.starts_with("m:22: expected an index of one of the 4 vertices before, found 4"), "{error}");
    let error = read(Format::Ply, text_ply().replace("1 1 0 7", "1 x 0 7")).err().unwrap().to_string();
    assert!(error.starts_with("m:19: expected element 3 of 4 'vertex'"), "{error}");
    let mut cut = binary_ply(true);
    cut.truncate(cut.len() - 5);
    let error = read(Format::Ply, &cut).err().unwrap().to_string();
    assert!(error.starts_with("m: byte ") && error.contains("element 2 of 2 'face'"), "{error}");
    let error = read(Format::Ply, "plywood").err().unwrap().to_string();
    assert!(error.starts_with("m:1: expected the header of a PLY file"), "{error}");
    let many = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000000\nproperty float x\nelement none \
                18446744073709551615\nend_header\n1234";
    assert!(read(Format::Ply, many).err().unwrap().to_string().contains("element 2 of 4000000000000"));
}

fn binary_stl(head: &str) -> Vec<u8> {
    let mut bytes = head.as_bytes().to_vec();
    bytes.resize(80, b' ');
    bytes.extend(2u32.to_le_bytes());
    for corners in [[0., 0., 0., 1., 0., 0., 1., 1., 0.], [0., 0., -0., 1., 1., 0., 0., 1., 0.]] {
        [0.0f32; 3].into_iter().chain(corners).for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

#[test]
fn stl_is_the_same_in_text_and_binary() {
    let facet = |corners: &str| {
        let vertices: Vec<String> = corners.split(',').map(|c| format!("  vertex {c}\n")).collect();
        format!(" facet normal 0 0 1\n outer loop\n{} endloop\n endfacet\n", vertices.concat())
    };
    let (a, b) = (facet("0 0 0,1 0 0,1 1 0"), facet("0 0 0,1 1 0,0 1 0"));
    let text = read(Format::Stl, format!("solid\n{a}{b}endsolid\n")).unwrap();
    assert_eq!(text.vertices.positions.len(), 4);
    assert_eq!(text.parts[0].material, Made::Unsaid);
    for head in ["made by hand", "solid but binary"] {
        let binary = read(Format::Stl, binary_stl(head)).unwrap();
        assert_eq!(
            (&binary.vertices, &binary.parts[0].triangles),
            (&text.vertices, &text.parts[0].triangles)
        );
    }
    let two = read(Format::Stl, format!("solid one\n{a}endsolid one\nSOLID two\n{b}endsolid\n")).unwrap();
    assert_eq!(two.parts[1].material, Made::Named("two".to_owned()));
    for (text, what) in [
        (format!("solid\n{a}"), "m:8: expected endsolid, found the end of the file"),
        (
            "solid\nfacet\nvertex 1 2\n".to_owned(),
            "m:3: expected vertex and three numbers, found 'vertex 1 2'",
        ),
        (
            "solid\nfacet\nendfacet\n".to_owned(),
            "m:3: expected three vertices before endfacet, found 0 vertices",
        ),
        ("hello".to_owned(), "m:1: expected solid"),
    ] {
        let error = read(Format::Stl, &text).err().expect(&text).to_string();
        assert!(error.contains(what), "{error}");
    }
    let mut cut = binary_stl("");
    cut.pop();
    let error = read(Format::Stl, cut).err().unwrap().to_string();
    assert!(error.contains("byte 80: expected as many facets as follow, 1, found 2"), "{error}");
}

/// A patch of three vertices and a triangle, as obj2mesh writes it.
fn compiled() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nobj2mesh\nFORMAT=Radiance_tmesh\n\n\x01\x430\x000\x000\x002\0".to_vec();
    bytes.extend([0; 20]);
    bytes.push(0);
    bytes.extend(b"plastic\0\0");
    bytes.extend(b"\x00\xff\xff\xff\xffred\0\0\0\0\x05");
    for mantissa in [0x3fffffffi32, 0x3fffffff, 0x3fffffff, 0, 0] {
        bytes.extend(mantissa.to_be_bytes());
        bytes.push(0);
    }
    bytes.extend(b"\xff\0\0\0\x01\x01\0\x03");
    for place in [[0u32, 0, 0], [1 << 31, 0, 0], [0, 1 << 31, 0]] {
        place.into_iter().for_each(|x| bytes.extend(x.to_be_bytes()));
    }
    bytes.extend(b"\0\x01\x00\x01\x02\0\x01\0\0\0\0\0\0");
    bytes
}

#[test]
fn compiled_meshes_bring_their_materials() {
    let mesh = read(Format::Rtm, compiled()).unwrap();
    assert_eq!((mesh.materials.len(), &mesh.parts[0].material), (1, &Made::Own("red".to_owned())));
    assert!(places(&mesh, 0)[0][1].distance(DVec3::X) < 1e-9);
}

#[test]
fn files_that_are_cut_or_changed_are_refused_or_read_but_never_harm() {
    let whole = [
        (Format::Rtm, compiled()),
        (Format::Ply, binary_ply(false)),
        (Format::Ply, text_ply().into_bytes()),
        (Format::Stl, binary_stl("")),
    ];
    for (format, bytes) in whole {
        for end in 0..bytes.len() {
            let _ = read(format, &bytes[..end]);
            for change in [1u8, 0x80, 0xff] {
                let mut changed = bytes.clone();
                changed[end] ^= change;
                if let Ok(mesh) = read(format, &changed) {
                    let n = mesh.vertices.positions.len();
                    assert!(
                        mesh.parts.iter().flat_map(|p| &p.triangles).flatten().all(|&k| (k as usize) < n)
                    );
                }
            }
        }
    }
    let error = read(Format::Rtm, &compiled()[..60]).err().unwrap().to_string();
    assert!(error.starts_with("m: byte 58: expected") && error.contains("make it again"), "{error}");
}

#[test]
fn octrees_are_of_files_or_frozen() {
    let head = b"#?RADIANCE\noconv\nFORMAT=Radiance_octree\n\n\x01\x1f0\x000\x000\x002\0".to_vec();
    let named = [&head[..], b"a.rad\0b.rad\0\0\0\0\0\x01\0"].concat();
    let Ok(Octree::Files(files)) = read_octree(&named, "o") else { panic!("of files") };
    assert_eq!(files, ["a.rad", "b.rad"]);
    let frozen = [&head[..], b"\0\0\0\0\x00\0sphere\0\0\xff"].concat();
    assert!(matches!(read_octree(&frozen, "o"), Ok(Octree::Frozen(all)) if all.is_empty()));
    let deep = [&head[..], b"\0\0\0\0\x00", &[2; 5000]].concat();
    assert!(read_octree(&deep, "o").err().unwrap().to_string().contains("more than 64 levels"));
    assert!(read_octree(b"", "o").err().unwrap().to_string().contains("Radiance_octree"));
}

proptest! {
    #[test]
    fn any_text_is_refused_or_read(text in "[vftns 0-9/.\\n-]{0,200}", bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        for format in [Format::Obj, Format::Ply, Format::Stl, Format::Rtm] {
            let _ = read(format, &text);
            let _ = read(format, &bytes);
        }
    }
}
