//! MGF of other people, and the geometry inside their BSDF files, read from the shared test data.

use std::path::Path;

use bsdftree::xml::{Strictness, read_file};
use bsdftree_device::{Device, Material, Shape, Unit};
use bsdftree_testing::real_file;
use glam::{DVec3, dvec3};

/// Ward's: a prism of a profile with rounded edges; each line of it that is a surface is one here.
#[test]
fn the_talks_sawtooth_is_read() {
    let Some(path) = real_file("radiance/sawtooth.mgf") else { return };
    let text = std::fs::read_to_string(&path).unwrap();
    let device = Device::read_mgf(&[path], Unit::Meter).unwrap();
    assert_eq!(device.warnings, Vec::<String>::new());
    assert_eq!(device.materials.len(), 1);
    let Material::Gloss(alum) = &device.materials[0].material else { panic!() };
    assert!((alum.color - DVec3::splat(0.7)).abs().max_element() < 1e-12, "{alum:?}");
    assert!((alum.specular - 0.95).abs() < 1e-12 && alum.roughness == [0.002; 2]);
    let [low, high] = device.bounds().unwrap();
    let size = dvec3(300.0, 300.0, 1.97833);
    assert!((high - low - size).abs().max_element() < 1e-4, "{low} {high}");
    let lines = |keyword: &str| text.lines().filter(|line| line.starts_with(keyword)).count();
    let shapes = |is: fn(&Shape) -> bool| device.surfaces.iter().filter(|s| is(&s.shape)).count();
    assert_eq!(shapes(|s| matches!(s, Shape::Cylinder { .. })), lines("cyl "));
    assert_eq!(shapes(|s| matches!(s, Shape::Sphere { .. })), lines("sph "));
    assert_eq!(shapes(|s| matches!(s, Shape::Polygon(_))), lines("f "));
}

#[test]
fn the_coloured_diffuser_is_read() {
    let Some(path) = real_file("radiance/testspecmat.mgf") else { return };
    let device = Device::read_mgf(&[path], Unit::Meter).unwrap();
    assert_eq!((device.surfaces.len(), device.materials[0].name.as_str()), (1, "SpectralDiffuser"));
    let Material::Wgmd(wgmd) = &device.materials[0].material else { panic!("{:?}", device.materials) };
    // As mgf2rad has it, which rounds spectra.
    let near = |a: DVec3, b: [f64; 3]| (a - DVec3::from_array(b)).abs().max_element() < 2e-3;
    assert!(near(wgmd.diffuse_reflection[0], [0.233271, 0.141179, 0.083439]), "{wgmd:?}");
    assert!(near(wgmd.diffuse_transmission, [0.528095, 0.384498, 0.036183]), "{wgmd:?}");
}

/// The geometry of a file reaches over the box that its header gives.
#[test]
fn devices_inside_bsdf_files_have_the_size_of_the_header() {
    for name in ["pyradiance/blinds.xml", "pyradiance/blindsT3.xml"] {
        let Some(path) = real_file(name) else { return };
        let device = Device::read_bsdf_geometry(&path, Unit::Inch).unwrap().unwrap();
        let header = read_file(&path, Strictness::Repair).unwrap().0.header;
        let [low, high] = device.bounds().unwrap();
        let size = high - low;
        assert!((size.x - header.width.unwrap()).abs() < 1e-5, "{name}: {size}");
        assert!((size.y - header.height.unwrap()).abs() < 1e-5, "{name}: {size}");
        assert!((low.x + high.x).abs() < 1e-5 && (low.y + high.y).abs() < 1e-5, "{name} is centred");
        assert_eq!(device.surfaces.len(), 311);
    }
    // Made for a part of the device.
    let Some(path) = real_file("frads/blinds30.xml") else { return };
    let device = Device::read_bsdf_geometry(&path, Unit::Inch).unwrap().unwrap();
    let [low, high] = device.bounds().unwrap();
    assert!((high - low).distance(dvec3(3.05, 2.74, 0.131650635)) < 1e-5, "{low} {high}");
}

#[test]
fn files_without_geometry_have_none() {
    let Some(path) = real_file("radiance/sawtooth.xml") else { return };
    assert!(Device::read_bsdf_geometry(&path, Unit::Meter).unwrap().is_none());
    let error = Device::read_bsdf_geometry(Path::new("/nowhere.xml"), Unit::Meter).unwrap_err().to_string();
    assert!(error.contains("cannot read '/nowhere.xml'"), "{error}");
}

#[test]
fn geometry_inside_a_file_names_no_other_file() {
    let geometry = bsdftree::Geometry { mgf: "\ni /etc/passwd\n".into(), unit: bsdftree::LengthUnit::Meter };
    let error = Device::from_bsdf_geometry(&geometry, Unit::Meter).unwrap_err().to_string();
    assert!(error.starts_with("geometry of the BSDF:2: including '/etc/passwd' is not supported"), "{error}");
}
