//! Devices written as MGF: read back here, and by Radiance's mgf2rad; and rad2mgf's text of the same device.

mod mgf_support;

use std::path::Path;

use bsdftree_device::material::{Gloss, GlossKind, Medium};
use bsdftree_device::{Device, Material, NamedMaterial, Shape, Surface, Unit};
use glam::{DVec3, dvec3};
use mgf_support::{made, made_of, near, radiance, run, translated};
use proptest::prelude::*;

fn read(text: &str, unit: Unit) -> Device {
    Device::parse_mgf(text, "again.mgf", Path::new("."), unit).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn gloss(kind: GlossKind, color: DVec3, specular: f64, roughness: f64) -> Material {
    let (transmission, transmitted_specular) = if kind == GlossKind::Trans { (0.6, 0.3) } else { (0.0, 0.0) };
    let roughness = [roughness; 2];
    Material::Gloss(Gloss {
        kind,
        color,
        specular,
        roughness,
        orientation: None,
        transmission,
        transmitted_specular,
    })
}

/// A device of all shapes, each with one of the materials in turn.
fn device_of(materials: Vec<Material>) -> Device {
    let (a, b) = (dvec3(0.1, 0.2, 0.3), dvec3(1.0, -1.0 / 3.0, 0.7));
    let shapes = vec![
        Shape::Polygon(vec![a, b, DVec3::X]),
        Shape::Sphere { center: a, radius: 0.3, inward: false },
        Shape::Sphere { center: a, radius: 0.4, inward: true },
        Shape::Cylinder { ends: [a, b], radius: 0.1, inward: false },
        Shape::Cylinder { ends: [a, b], radius: 1.0 / 3.0, inward: true },
        Shape::Cone { ends: [a, b], radii: [0.1, 0.0], inward: false },
        Shape::Cone { ends: [a, b], radii: [0.1, 0.4], inward: true },
        Shape::Ring { center: b, normal: DVec3::Y, radii: [0.0, 0.25] },
        Shape::Ring { center: b, normal: dvec3(0.6, 0.0, 0.8), radii: [0.1, 0.2] },
    ];
    let n = materials.len().max(shapes.len());
    let surfaces = (0..n)
        .map(|k| Surface {
            name: format!("part.{}", k / 2),
            shape: shapes[k % shapes.len()].clone(),
            material: (k % materials.len()) as u32,
        })
        .collect();
    let named = |(k, material)| NamedMaterial { name: format!("m{k}"), material };
    Device {
        surfaces,
        materials: materials.into_iter().enumerate().map(named).collect(),
        ..Device::default()
    }
}

fn close(a: DVec3, b: DVec3, tolerance: f64) -> bool {
    (a - b).abs().max_element() <= tolerance
}

/// Asserts that two materials are the same but for rounding. Grey plastic of strong highlights comes back as metal, which is the
/// same.
fn assert_same_material(a: &Material, b: &Material, tolerance: f64) {
    let explain = || format!("{a:?}\n{b:?}");
    match (a, b) {
        (Material::Gloss(a), Material::Gloss(b)) => {
            let parts = |g: &Gloss| {
                let diffuse = g.color * (1.0 - g.specular);
                let reflected =
                    if g.kind == GlossKind::Metal { g.color * g.specular } else { DVec3::splat(g.specular) };
                let through = diffuse * g.transmission;
                [
                    reflected,
                    diffuse - through,
                    through * (1.0 - g.transmitted_specular),
                    through * g.transmitted_specular,
                ]
            };
            for (a, b) in parts(a).into_iter().zip(parts(b)) {
                assert!(close(a, b, tolerance), "{}", explain());
            }
            assert!(a.kind == b.kind || a.transmission + b.transmission == 0.0, "{}", explain());
            assert!((a.roughness[0] - b.roughness[0]).abs() <= tolerance, "{}", explain());
        }
        (
            Material::Glass { transmissivity: t, index: n },
            Material::Glass { transmissivity: u, index: m },
        ) => {
            assert!(close(*t, *u, tolerance) && (n - m).abs() <= tolerance, "{}", explain());
        }
        (Material::Dielectric { inside: i, outside: o }, Material::Dielectric { inside: j, outside: p }) => {
            // Of five millimetres, as it is written.
            let part = |m: &Medium| m.transmittance.powf(0.005);
            assert!(
                close(part(i), part(j), tolerance) && (i.index - j.index).abs() <= tolerance && o == p,
                "{}",
                explain()
            );
        }
        (Material::Gloss(a), Material::Black) => {
            let nothing = if a.kind == GlossKind::Metal {
                a.color.max_element()
            } else {
                a.color.max_element().max(a.specular)
            };
            assert!(nothing <= tolerance, "{}", explain());
        }
        _ => assert_eq!(a, b),
    }
}

fn plain() -> Vec<Material> {
    let pink = dvec3(0.8, 0.5, 0.6);
    let mut all = vec![
        Material::Void,
        Material::Black,
        Material::Glass { transmissivity: DVec3::splat(0.96), index: 1.52 },
        Material::Glass { transmissivity: dvec3(0.9, 0.3, 0.1), index: 1.52 },
        Material::Glass { transmissivity: DVec3::splat(0.02), index: 1.5 },
        Material::Glass { transmissivity: DVec3::splat(0.9), index: 2.4 },
        Material::Dielectric {
            inside: Medium { transmittance: dvec3(0.9, 0.8, 0.1), index: 1.49 },
            outside: Medium::VACUUM,
        },
        Material::Dielectric {
            inside: Medium { transmittance: DVec3::ONE, index: 2.4 },
            outside: Medium::VACUUM,
        },
        Material::Dielectric {
            inside: Medium { transmittance: DVec3::ONE, index: 0.75 },
            outside: Medium::VACUUM,
        },
    ];
    for color in [DVec3::splat(0.7), pink, DVec3::X, DVec3::ONE] {
        for (specular, roughness) in [(0.0, 0.0), (0.05, 0.1), (0.3, 0.02), (0.95, 0.0)] {
            all.push(gloss(GlossKind::Plastic, color, specular, roughness));
            all.push(gloss(GlossKind::Metal, color, specular, roughness));
            all.push(gloss(GlossKind::Trans, color, specular, roughness));
        }
    }
    all
}

#[test]
fn plain_devices_come_back_the_same() {
    for material in plain() {
        let device = device_of(vec![material]);
        let mgf = device.to_mgf(Unit::Meter);
        assert_eq!(mgf.losses, Vec::<String>::new());
        let again = read(&mgf.text, Unit::Meter);
        assert_eq!(again.warnings, Vec::<String>::new(), "{}", mgf.text);
        assert_same_material(&device.materials[0].material, &again.materials[0].material, 1e-10);
        assert_eq!(again.surfaces.len(), device.surfaces.len());
        for (a, b) in again.surfaces.iter().zip(&device.surfaces) {
            assert_eq!(a.shape, b.shape);
        }
    }
}

#[test]
fn materials_of_parts_come_back() {
    for material in [
        "rd .3\nrs .2 .05\nts .1 .15",
        "c\ncxy .4 .4\nrd .3\nc\ncxy .2 .3\ntd .3\nrs .05 .1\nsides 1",
        "c\ncxy .45 .4\nrs .3 .1\nc\ncxy .3 .4\nrd .1",
    ] {
        let device = read(&format!("v a =\nm x =\n{material}\nsph a 1\n"), Unit::Meter);
        let mgf = device.to_mgf(Unit::Meter);
        assert_eq!(mgf.losses, Vec::<String>::new(), "{}", device.to_rad());
        let again = read(&mgf.text, Unit::Meter);
        let [a, b] = [&device, &again].map(|d| made_of(d)[0].material.clone().unwrap());
        assert_eq!((&a.kind, a.reals.len()), (&b.kind, 19));
        assert!(near(&a.reals, &b.reals, 1e-12), "{a:?}\n{b:?}");
    }
}

#[test]
fn one_sided_surfaces_come_back() {
    for material in ["rd .5", "rd 0", "td .4\nrs .05 .1"] {
        let text = format!("v a =\nm x =\n{material}\nsides 1\nsph a 1\n");
        let device = read(&text, Unit::Meter);
        assert!(matches!(device.materials[0].material, Material::Mixture { .. }));
        let mgf = device.to_mgf(Unit::Meter);
        assert!(mgf.losses.is_empty() && mgf.text.contains("sides 1"), "{mgf:?}");
        assert_eq!(read(&mgf.text, Unit::Meter).materials, device.materials);
    }
}

#[test]
fn materials_stay_apart_though_they_share_names() {
    let white = gloss(GlossKind::Plastic, DVec3::splat(0.8), 0.0, 0.0);
    let mut device = device_of(vec![white, Material::Black, gloss(GlossKind::Metal, DVec3::X, 0.2, 0.1)]);
    device.materials.iter_mut().for_each(|m| m.name = "2 mm\\glass".into());
    let again = read(&device.to_mgf(Unit::Meter).text, Unit::Meter);
    assert_eq!(again.materials.len(), 3);
    let used = |device: &Device| device.surfaces.iter().map(|s| s.material).collect::<Vec<_>>();
    assert_eq!(used(&again), used(&device));
}

#[test]
fn every_unit_comes_back() {
    let device = device_of(plain());
    for unit in [Unit::Foot, Unit::Inch, Unit::Centimeter, Unit::Millimeter] {
        let again = read(&device.to_mgf(unit).text, unit);
        let (a, b) = (device.bounds().unwrap(), again.bounds().unwrap());
        assert!(close(a[0], b[0], 1e-12) && close(a[1], b[1], 1e-12), "{unit:?}");
        for (a, b) in device.materials.iter().zip(&again.materials) {
            assert_same_material(&a.material, &b.material, 1e-9);
        }
    }
}

#[test]
fn parametric_devices_come_back() {
    for spec in ["blinds", "sawtooth", "prism", "perforated", "mirror"] {
        let device = Device::from_spec(spec).unwrap();
        let mgf = device.to_mgf(Unit::Millimeter);
        let n_mirrors =
            device.materials.iter().filter(|m| matches!(m.material, Material::Mirror { .. })).count();
        assert_eq!(mgf.losses.len(), n_mirrors, "{:?}", mgf.losses);
        let again = read(&mgf.text, Unit::Millimeter);
        assert_eq!(again.surfaces.len(), device.surfaces.len());
        let area = |d: &Device| d.surfaces.iter().map(|s| s.shape.area()).sum::<f64>();
        assert!((area(&again) / area(&device) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn what_mgf_cannot_say_is_listed() {
    let brushed = Gloss {
        kind: GlossKind::Metal,
        color: DVec3::splat(0.5),
        specular: 0.9,
        roughness: [0.1, 0.3],
        orientation: Some(DVec3::X),
        transmission: 0.0,
        transmitted_specular: 0.0,
    };
    let water = Medium { transmittance: DVec3::ONE, index: 1.33 };
    let device = device_of(vec![
        Material::Gloss(brushed),
        Material::Mirror { reflectance: DVec3::splat(0.9) },
        Material::Dielectric { inside: Medium { index: 1.5, ..water }, outside: water },
    ]);
    let mgf = device.to_mgf(Unit::Meter);
    assert_eq!(mgf.losses.len(), 3, "{:?}", mgf.losses);
    assert!(mgf.losses[0].starts_with("material \"m0\": that its roughness differs"), "{:?}", mgf.losses);
    let again = read(&mgf.text, Unit::Meter);
    let Material::Gloss(gloss) = &again.materials[0].material else { panic!() };
    assert!((gloss.roughness[0] - 0.2).abs() < 1e-15 && gloss.orientation.is_none());
}

/// Text that mgf2rad takes, with the numbers that `to_rad` writes.
#[test]
fn mgf2rad_reads_what_is_written() {
    let Some(mgf2rad) = radiance("mgf2rad") else { return };
    let plain = plain().into_iter().filter(|m| {
        !matches!(m, Material::Glass { .. } | Material::Dielectric { .. } | Material::Void | Material::Black)
    });
    let device = device_of(plain.collect());
    let mgf = device.to_mgf(Unit::Meter);
    let scene = translated(&mgf2rad, &mgf.text).unwrap();
    let (ours, theirs) = (made_of(&device), made(&scene));
    assert_eq!(ours.len(), theirs.len());
    for (a, b) in ours.iter().zip(&theirs) {
        assert_eq!(a.surface.kind, b.surface.kind);
        assert!(near(&a.surface.reals, &b.surface.reals, 1e-9), "{a:?}\n{b:?}");
        let (a, b) = (a.material.as_ref().unwrap(), b.material.as_ref().unwrap());
        if a.kind == b.kind && a.reals[3] < 0.9 {
            assert!(near(&a.reals, &b.reals, 3e-5), "{a:?}\n{b:?}");
        }
    }
}

/// What a BSDF file holds is what pkgBSDF gives to mgf2rad.
#[test]
fn mgf2rad_reads_the_geometry_of_a_file() {
    let Some(mgf2rad) = radiance("mgf2rad") else { return };
    let blinds = Device::from_spec("blinds:glazing=0.88").unwrap();
    let (geometry, losses) = blinds.to_bsdf_geometry(bsdftree::LengthUnit::Inch, [0.25, -0.5]);
    assert!(losses.is_empty());
    let theirs = made(&translated(&mgf2rad, &geometry.mgf).unwrap());
    let ours = made_of(&Device::from_bsdf_geometry(&geometry, Unit::Meter).unwrap());
    assert_eq!((ours.len(), theirs.len()), (blinds.surfaces.len(), blinds.surfaces.len()));
    for (a, b) in ours.iter().zip(&theirs) {
        let in_meters: Vec<f64> = b.surface.reals.iter().map(|x| x * 0.0254).collect();
        assert!(near(&a.surface.reals, &in_meters, 1e-9), "{a:?}\n{b:?}");
        assert_eq!(a.material.as_ref().map(|m| &m.kind), b.material.as_ref().map(|m| &m.kind));
    }
}

#[test]
fn rad2mgf_says_the_same() {
    let Some(rad2mgf) = radiance("rad2mgf") else { return };
    let plain: Vec<Material> =
        plain().into_iter().filter(|m| *m != Material::Void && *m != Material::Black).collect();
    let device = device_of(plain);
    let theirs = read(&run(&rad2mgf, &device.to_rad()).unwrap(), Unit::Meter);
    let ours = read(&device.to_mgf(Unit::Meter).text, Unit::Meter);
    assert_eq!(theirs.surfaces.len(), ours.surfaces.len());
    for (a, b) in ours.surfaces.iter().zip(&theirs.surfaces) {
        let (a_bounds, b_bounds) = (a.shape.bounds(), b.shape.bounds());
        assert!(close(a_bounds[0], b_bounds[0], 1e-11) && close(a_bounds[1], b_bounds[1], 1e-11));
        let (a, b) = (&ours.materials[a.material as usize], &theirs.materials[b.material as usize]);
        assert_eq!(a.name, b.name);
        // rad2mgf writes six digits, also of chromaticities of dark colours.
        if !matches!(a.material, Material::Dielectric { .. }) {
            assert_same_material(&a.material, &b.material, 2e-5);
        }
    }
}

proptest! {
    #[test]
    fn any_material_comes_back(
        kind in prop::sample::select(vec![GlossKind::Plastic, GlossKind::Metal, GlossKind::Trans]),
        color in prop::array::uniform3(0.0..1.0f64), specular in 0.0..1.0f64, roughness in 0.0..0.5f64
    ) {
        let device = device_of(vec![gloss(kind, DVec3::from_array(color), specular, roughness)]);
        let again = read(&device.to_mgf(Unit::Meter).text, Unit::Meter);
        assert_same_material(&device.materials[0].material, &again.materials[0].material, 1e-9);
    }

    #[test]
    fn any_pane_comes_back(color in prop::array::uniform3(0.001..1.0f64), index in 1.2..2.5f64) {
        let glass = Material::Glass { transmissivity: DVec3::from_array(color), index };
        let again = read(&device_of(vec![glass.clone()]).to_mgf(Unit::Meter).text, Unit::Meter);
        assert_same_material(&glass, &again.materials[0].material, 1e-9);
    }
}
