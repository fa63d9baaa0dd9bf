//! Compiled meshes and octrees of Radiance's own programs, live: they are read as what they were made of.

use std::fs;
use std::path::Path;

use bsdftree_device::mesh::Mesh;
use bsdftree_device::options::MaterialMap;
use bsdftree_device::{Device, DeviceError, ReadOptions, Shape, Unit};
use bsdftree_testing::radiance::{printed, programs};
use glam::DVec3;

const MATERIALS: &str =
    "void plastic red 0 0 5 .5 .25 .125 0 0\nvoid metal blue 0 0 5 .125 .25 .5 .5 0\nvoid alias green red\n";

fn run(folder: &Path, program: &str, arguments: &[&str]) -> Vec<u8> {
    printed(program, folder, arguments, b"")
}

/// A smooth ball without its poles, of 20 × 30 quadrangles, with texture coordinates.
fn ball(folder: &Path) {
    let [x, y, z] = ["sin(.3+2.5*s)*cos(6*t)", "cos(.3+2.5*s)", "-sin(.3+2.5*s)*sin(6*t)"];
    let obj = run(folder, "gensurf", &["red", "ball", x, y, z, "20", "30", "-s", "-o"]);
    // Quadrangles could be cut either way.
    let triangles = |line: &str| match line.split(' ').collect::<Vec<_>>()[..] {
        ["f", a, b, c, d] => format!("f {a} {b} {c}\nf {a} {c} {d}\n"),
        _ => format!("{line}\n"),
    };
    let obj: String = String::from_utf8(obj).unwrap().lines().map(triangles).collect();
    fs::write(folder.join("ball.obj"), obj).unwrap();
    fs::write(folder.join("m.mat"), MATERIALS).unwrap();
}

/// A folder with that ball, if there are programs to make it.
fn folder_with_ball() -> Option<tempfile::TempDir> {
    programs()?;
    let folder = tempfile::tempdir().unwrap();
    ball(folder.path());
    Some(folder)
}

fn with_materials(folder: &Path) -> ReadOptions {
    let materials = MaterialMap { files: vec![folder.join("m.mat")], ..MaterialMap::default() };
    ReadOptions { materials, ..ReadOptions::default() }
}

fn mesh(device: &Device, surface: usize) -> &Mesh {
    let Shape::Mesh(mesh) = &device.surfaces[surface].shape else { panic!("a mesh") };
    mesh
}

/// A triangle's centre and normal, and what its mesh knows in its centre.
type Triangle = (DVec3, DVec3, DVec3, [f64; 2]);

fn triangles(mesh: &Mesh) -> Vec<Triangle> {
    let triangle = |k| {
        let [a, b, c] = mesh.corners(k);
        let center = (a + b + c) / 3.0;
        let point = mesh.at(k, center);
        (center, (b - a).cross(c - a).normalize(), point.normal.unwrap_or(DVec3::ZERO), point.uv)
    };
    (0..mesh.triangles.len()).map(triangle).collect()
}

/// Each triangle with that of the other mesh that is nearest.
fn pairs(ours: &[Triangle], theirs: &[Triangle]) -> Vec<(Triangle, Triangle)> {
    assert_eq!(ours.len(), theirs.len());
    let nearest = |a: &Triangle| {
        let by_distance =
            |b: &&Triangle, c: &&Triangle| a.0.distance_squared(b.0).total_cmp(&a.0.distance_squared(c.0));
        *theirs.iter().min_by(by_distance).unwrap()
    };
    ours.iter().map(|a| (*a, nearest(a))).collect()
}

#[test]
fn a_compiled_mesh_is_the_mesh_it_was_made_of() {
    let Some(folder) = folder_with_ball() else { return };
    let folder = folder.path();
    run(folder, "obj2mesh", &["-a", "m.mat", "ball.obj", "ball.rtm"]);
    let from_obj = Device::read_mesh(&folder.join("ball.obj"), with_materials(folder)).unwrap();
    let compiled = Device::read_mesh(&folder.join("ball.rtm"), Unit::Meter).unwrap();
    // Reals are compiled with 31 bits.
    let bsdftree_device::Material::Gloss(red) = &compiled.materials[0].material else { panic!("a gloss") };
    assert!(red.color.distance(DVec3::new(0.5, 0.25, 0.125)) < 1e-9);
    assert_eq!((&*compiled.materials[0].name, compiled.surfaces.len()), ("red", 1));
    let (ours, theirs) = (triangles(mesh(&from_obj, 0)), triangles(mesh(&compiled, 0)));
    assert_eq!(ours.len(), 1200);
    for (a, b) in pairs(&ours, &theirs) {
        assert!(a.0.distance(b.0) < 1e-8 && a.1.distance(b.1) < 1e-6, "{a:?} {b:?}");
        // Normals are compiled with 13 bits.
        assert!(a.2.distance(b.2) < 2e-4, "{a:?} {b:?}");
        assert!((a.3[0] - b.3[0]).abs() < 1e-6 && (a.3[1] - b.3[1]).abs() < 1e-6, "{a:?} {b:?}");
    }
}

#[test]
fn materials_of_each_triangle_survive_compilation() {
    let Some(folder) = folder_with_ball() else { return };
    let folder = folder.path();
    let plain: String = fs::read_to_string(folder.join("ball.obj"))
        .unwrap()
        .lines()
        .filter(|line| line.starts_with('v'))
        .map(|line| format!("{line}\n"))
        .collect();
    // A strip of quadrangles, coloured in turns, over three patches of vertices.
    let faces = (1..600).map(|k| {
        let material = ["red", "blue", "green"][k % 3];
        format!("usemtl {material}\nf {} {} {}\n", k, k + 1, k + 31)
    });
    fs::write(folder.join("strip.obj"), plain + &faces.collect::<String>()).unwrap();
    run(folder, "obj2mesh", &["-w", "-a", "m.mat", "strip.obj", "strip.rtm"]);
    let from_obj = Device::read_mesh(&folder.join("strip.obj"), with_materials(folder)).unwrap();
    let compiled = Device::read_mesh(&folder.join("strip.rtm"), Unit::Meter).unwrap();
    for material in ["red", "blue", "green"] {
        let of = |device: &Device, stem: &str| {
            let surface =
                device.surfaces.iter().position(|s| s.name == format!("{stem}.{material}")).unwrap();
            assert_eq!(device.materials[device.surfaces[surface].material as usize].name, material);
            triangles(mesh(device, surface))
        };
        let (ours, theirs) = (of(&from_obj, "strip"), of(&compiled, "strip"));
        assert!(ours.len() > 150 && ours.len() == theirs.len(), "{} {}", ours.len(), theirs.len());
        for (a, b) in pairs(&ours, &theirs) {
            assert!(a.0.distance(b.0) < 1e-8 && a.1.distance(b.1) < 1e-5, "{a:?} {b:?}");
        }
    }
}

#[test]
fn a_mesh_in_a_scene_is_placed_and_made_of_what_is_said() {
    let Some(folder) = folder_with_ball() else { return };
    let folder = folder.path();
    run(folder, "obj2mesh", &["-a", "m.mat", "ball.obj", "ball.rtm"]);
    let scene = "void mesh own 1 ball.rtm 0 0\nvoid glass pane 0 0 3 .9 .9 .9\n\
                 pane mesh imposed 8 ball.rtm -s 2 -mx -t 10 0 0 0 0\nvoid plastic red 0 0 5 .9 .9 .9 0 0\n\
                 red sphere after 0 0 4 0 9 0 1\n";
    let device = Device::parse_rad(scene, "s.rad", folder, Unit::Centimeter).unwrap();
    let names: Vec<_> = device.surfaces.iter().map(|s| &*s.name).collect();
    assert_eq!(names, ["own.red", "imposed", "after"]);
    let materials: Vec<_> =
        device.surfaces.iter().map(|s| &*device.materials[s.material as usize].name).collect();
    assert_eq!(materials, ["red", "pane", "red"]);
    assert_ne!(
        device.surfaces[0].material, device.surfaces[2].material,
        "what the mesh brings along is its own"
    );
    let [low, high] = device.surfaces[1].shape.bounds();
    assert!(
        low.distance(DVec3::new(0.08, -0.02, -0.02)) < 2e-3
            && high.distance(DVec3::new(0.12, 0.02, 0.02)) < 2e-3
    );
    // Mirrored or not, the front is outside, and so are the normals.
    for surface in [0, 1] {
        let center = DVec3::X * [0.0, 0.1][surface];
        for (at, facing, smooth, _) in triangles(mesh(&device, surface)) {
            let outward = (at - center).normalize();
            assert!(facing.dot(outward) > 0.9 && smooth.dot(outward) > 0.9, "{at} {facing} {smooth}");
        }
    }
}

#[test]
fn an_instance_is_the_scene_of_its_octree() {
    let Some(folder) = folder_with_ball() else { return };
    let folder = folder.path();
    run(folder, "obj2mesh", &["-a", "m.mat", "ball.obj", "ball.rtm"]);
    let inner = "void plastic red 0 0 5 .5 .25 .125 0 0\nvoid colorfunc half 4 .5 .5 .5 . 0 0\nhalf alias dark red\n\
                 red sphere a 0 0 4 0 0 0 1\nvoid metal red 0 0 5 .75 .75 .75 .5 0\ndark sphere b 0 0 4 2 0 0 1\n\
                 red polygon c 0 0 9 4 0 0 5 0 0 4 1 0\nvoid mesh m 5 ball.rtm -t 0 5 0 0 0\n";
    fs::write(folder.join("inner.rad"), inner).unwrap();
    fs::write(folder.join("frozen.oct"), run(folder, "oconv", &["-f", "inner.rad"])).unwrap();
    fs::write(folder.join("thin.oct"), run(folder, "oconv", &["inner.rad"])).unwrap();
    let expected = Device::parse_rad("!xform -n i -t 0 0 3 inner.rad", "s.rad", folder, Unit::Meter).unwrap();
    for octree in ["frozen.oct", "thin.oct"] {
        let scene = format!("void instance i 5 {octree} -t 0 0 3 0 0\n");
        let device = Device::parse_rad(&scene, "s.rad", folder, Unit::Meter).unwrap();
        assert_eq!(device.surfaces.len(), expected.surfaces.len());
        for (a, b) in device.surfaces.iter().zip(&expected.surfaces) {
            assert_eq!(a.name, b.name);
            let (p, q) = (a.shape.bounds(), b.shape.bounds());
            assert!(p[0].distance(q[0]) < 1e-8 && p[1].distance(q[1]) < 1e-8, "{p:?} {q:?}");
            let [p, q] =
                [(a, &device), (b, &expected)].map(|(s, d)| &d.materials[s.material as usize].material);
            let kind = |m| format!("{m:?}").chars().take_while(|c| c.is_alphabetic()).collect::<String>();
            assert_eq!(kind(p), kind(q), "{octree} {}", a.name);
        }
        let alone = Device::read(&[folder.join(octree)], Unit::Meter).unwrap();
        assert_eq!(alone.surfaces.len(), expected.surfaces.len());
    }
    let imposed = "void glass pane 0 0 3 .9 .9 .9\npane instance i 1 frozen.oct 0 0\n";
    let device = Device::parse_rad(imposed, "s.rad", folder, Unit::Meter).unwrap();
    assert_eq!((device.materials.len(), device.surfaces.len()), (1, 4));
    fs::remove_file(folder.join("inner.rad")).unwrap();
    let error =
        Device::parse_rad("\nvoid instance i 1 thin.oct 0 0", "s.rad", folder, Unit::Meter).unwrap_err();
    assert!(matches!(error, DeviceError::Unsupported { .. }), "{error}");
    assert!(error.to_string().starts_with("s.rad:2: ") && error.to_string().contains("oconv -f"), "{error}");
}
