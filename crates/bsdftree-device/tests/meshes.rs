//! Mesh files as devices: what they are made of, their unit, and what is said if a material is missing.

use std::fs;
use std::path::{Path, PathBuf};

use bsdftree_device::options::{Limits, MaterialMap};
use bsdftree_device::{Device, DeviceError, ReadOptions, Shape, Unit, Up};
use glam::DVec3;

const PANES: &str =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nf 1 2 3 4\nusemtl Frame\nf 1 2 5\nusemtl Glass\nf 1 5 4\n";
const MATERIALS: &str = "void plastic white 0 0 5 .8 .8 .8 0 0\nvoid glass clear 0 0 3 .9 .9 .9\n";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("panes.obj"), PANES).unwrap();
    fs::write(folder.path().join("m.rad"), MATERIALS).unwrap();
    folder
}

fn options(folder: &Path, names: &[(&str, &str)], default: Option<&str>) -> ReadOptions {
    let names = names.iter().map(|(a, b)| (a.to_string(), b.to_string())).collect();
    let materials =
        MaterialMap { files: vec![folder.join("m.rad")], names, default: default.map(str::to_owned) };
    ReadOptions { unit: Unit::Millimeter, materials, ..ReadOptions::default() }
}

fn made_of(device: &Device) -> Vec<(&str, &str)> {
    let material = |k: u32| &*device.materials[k as usize].name;
    device.surfaces.iter().map(|s| (&*s.name, material(s.material))).collect()
}

#[test]
fn names_go_through_the_map_then_to_definitions_then_to_the_default() {
    let folder = folder();
    let path = folder.path().join("panes.obj");
    let options = options(folder.path(), &[("Glass", "clear")], Some("white"));
    let device = Device::read_mesh(&path, &options).unwrap();
    assert_eq!(made_of(&device), [("panes", "white"), ("panes.Frame", "white"), ("panes.Glass", "clear")]);
    assert!(device.bounds().unwrap()[1].distance(DVec3::splat(1e-3)) < 1e-18);
    let Shape::Mesh(first) = &device.surfaces[0].shape else { panic!("a mesh") };
    let Shape::Mesh(last) = &device.surfaces[2].shape else { panic!("a mesh") };
    assert!(std::sync::Arc::ptr_eq(&first.vertices, &last.vertices));
    let turned = device.turned_up(Up::Z);
    let Shape::Mesh(mesh) = &turned.surfaces[0].shape else { panic!("a mesh") };
    assert!(mesh.vertices.positions[2].distance(DVec3::new(1e-3, 0.0, -1e-3)) < 1e-18);
}

#[test]
fn scenes_before_a_mesh_define_its_materials() {
    let folder = folder();
    fs::write(folder.path().join("scene.rad"), "void alias Frame white\nvoid alias Glass clear\n").unwrap();
    let files: Vec<PathBuf> =
        ["m.rad", "scene.rad", "panes.obj"].iter().map(|f| folder.path().join(f)).collect();
    let default = MaterialMap { default: Some("white".to_owned()), ..MaterialMap::default() };
    let device = Device::read(&files, ReadOptions { materials: default, ..ReadOptions::default() }).unwrap();
    assert_eq!(made_of(&device)[2], ("panes.Glass", "Glass"));
}

#[test]
fn missing_materials_are_named_with_what_to_do() {
    let folder = folder();
    let path = folder.path().join("panes.obj");
    let message = |names: &[(&str, &str)], default: Option<&str>| {
        Device::read_mesh(&path, options(folder.path(), names, default)).unwrap_err().to_string()
    };
    let error = message(&[], None);
    assert!(error.contains("panes.obj:6: expected a material for mesh \"panes\", found no name"), "{error}");
    fs::write(&path, PANES.replace("f 1 2 3 4\n", "")).unwrap();
    let error = message(&[], None);
    assert!(
        error.contains("panes.obj:7: expected a material of mesh \"panes\" that is defined, found 'Frame'"),
        "{error}"
    );
    let error = message(&[("Frame", "wood")], None);
    assert!(error.contains("found 'wood': define it in a file of materials"), "{error}");
    let error = message(&[], Some("wood"));
    assert!(error.contains("'wood' is not defined"), "{error}");
}

#[test]
fn what_a_mesh_takes_is_bounded() {
    let folder = folder();
    let limits = Limits { surfaces: 3, ..Limits::DEFAULT };
    let options = ReadOptions { limits, ..options(folder.path(), &[], Some("white")) };
    let error = Device::read_mesh(&folder.path().join("panes.obj"), &options).unwrap_err();
    assert!(matches!(error, DeviceError::TooLarge { limit: 3, .. }), "{error}");
    assert!(Device::read_mesh(&folder.path().join("none.ply"), Unit::Meter).is_err());
}

#[test]
fn a_mesh_written_as_polygons_has_the_same_triangles() {
    let folder = folder();
    let path = folder.path().join("panes.obj");
    let device =
        Device::read_mesh(&path, options(folder.path(), &[("Glass", "clear")], Some("white"))).unwrap();
    let again = Device::parse_rad(&device.to_rad(), "again.rad", folder.path(), Unit::Meter).unwrap();
    // Whichever corner comes first.
    let first_least = |t: [DVec3; 3]| {
        let from = (0..3).min_by(|&i, &j| t[i].to_array().partial_cmp(&t[j].to_array()).unwrap()).unwrap();
        [0, 1, 2].map(|k| t[(from + k) % 3])
    };
    let all = |device: &Device| -> Vec<[DVec3; 3]> {
        device.surfaces.iter().flat_map(|s| s.shape.triangulate()).map(first_least).collect()
    };
    assert_eq!(all(&again), all(&device));
    assert_eq!(again.surfaces.len(), 4);
}
