//! Scenes of other people, read from the shared test data.

use bsdftree_device::{Device, Material, Shape, Unit};
use bsdftree_testing::real_file;
use glam::dvec3;

#[test]
fn blinds_of_pyradiance_are_read() {
    let Some(path) = real_file("pyradiance/blinds.rad") else { return };
    let device = Device::read_rad(&[path], Unit::Meter).unwrap();
    assert_eq!((device.surfaces.len(), device.materials.len(), device.warnings.len()), (311, 2, 0));
    assert_eq!(device.bounds().unwrap(), [dvec3(0.0, -0.0127, -0.048591), dvec3(6.096, 1.524, 0.0)]);
    assert!(matches!(device.materials[0].material, Material::Glass { .. }));
    let again = Device::parse_rad(&device.to_rad(), "again", ".".as_ref(), Unit::Meter).unwrap();
    assert_eq!(again, device);
}

#[test]
fn blinds_only_of_pyradiance_are_read() {
    let Some(path) = real_file("pyradiance/blindsOnly.rad") else { return };
    let device = Device::read_rad(&[path], Unit::Foot).unwrap();
    assert_eq!((device.surfaces.len(), device.materials.len()), (307, 2));
    let [low, high] = device.bounds().unwrap();
    assert!((high - low).distance(dvec3(6.096, 0.048591, 2.4384 - 0.909521) * 0.3048) < 1e-12);
}

#[test]
fn two_files_are_one_scene() {
    let (Some(a), Some(b)) = (real_file("pyradiance/blinds.rad"), real_file("pyradiance/blindsOnly.rad"))
    else {
        return;
    };
    let device = Device::read_rad(&[a, b], Unit::Meter).unwrap();
    assert_eq!((device.surfaces.len(), device.materials.len()), (618, 2));
}

#[test]
fn prisms_redirect_by_the_function_file_beside_them() {
    for (name, n_redirections) in [("radiance/prism1.rad", 1), ("radiance/prism2.rad", 2)] {
        let Some(path) = real_file(name) else { return };
        let device = Device::read_rad(&[path], Unit::Meter).unwrap();
        let Material::Prism(prism) = &device.materials[0].material else { panic!("{name}: no prism") };
        assert_eq!(prism.redirections.len(), n_redirections);
    }
}

#[test]
fn genprism_makes_the_sawtooth() {
    let Some(path) = real_file("radiance/sawtooth.rad") else { return };
    let device = Device::read_rad(&[path], Unit::Meter).unwrap();
    let n_cylinders = device.surfaces.iter().filter(|s| matches!(s.shape, Shape::Cylinder { .. })).count();
    assert!(device.surfaces.len() > 300 && n_cylinders > 50, "{} {n_cylinders}", device.surfaces.len());
}
