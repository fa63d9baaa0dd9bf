//! Materials with optics of their own in scene files: what is read, what is refused, and what is written back.

use std::path::{Path, PathBuf};

use bsdftree::{Component, Lobes, Part, Rank, Tree, xml};
use bsdftree_device::material::{Antimatter, Orientation};
use bsdftree_device::{Device, Material, Unit};
use glam::DVec3;

const PANE: &str = "\nm polygon pane 0 0 12 0 0 0 1 0 0 1 1 0 0 1 0\n";

fn parse(text: &str, directory: &Path) -> Result<Device, String> {
    Device::parse_rad(text, "a.rad", directory, Unit::Meter).map_err(|e| e.to_string())
}

fn material(text: &str) -> Material {
    parse(&format!("{text}{PANE}"), ".".as_ref()).unwrap().materials[0].material.clone()
}

fn error(text: &str) -> String {
    parse(&format!("{text}{PANE}"), ".".as_ref()).unwrap_err()
}

/// A folder with a BSDF file that reflects 30 % and transmits 50 %, diffuse.
fn folder(reflectance: f32) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut bsdf = bsdftree::Bsdf::default();
    let diffuse = |rho: f32| Component::grey(Tree::uniform(Rank::Four, rho / std::f32::consts::PI).into());
    bsdf.band_mut("Visible").insert(Part::ReflectionBack, diffuse(reflectance));
    bsdf.band_mut("Visible").insert(Part::TransmissionBack, diffuse(0.5));
    xml::write_file(&bsdf, folder.path().join("pane.xml")).unwrap();
    std::fs::write(folder.path().join("up.cal"), "ux = 0; uy = Py; uz = 1; thick : 0; deep : .1;").unwrap();
    folder
}

#[test]
fn a_bsdf_is_read_with_all_that_it_says() {
    let folder = folder(0.3);
    let text = format!("void BSDF m 6 0 pane.xml 0 2 0 . 0 9 .1 .1 .1 .05 .05 .05 .02 .02 .02 {PANE}");
    let device = parse(&text, folder.path()).unwrap();
    assert!(device.warnings.is_empty(), "{:?}", device.warnings);
    let Material::Measured(measured) = &device.materials[0].material else { panic!("{device:?}") };
    assert_eq!(measured.up, Orientation::Constant(2.0 * DVec3::Y));
    assert_eq!(measured.diffuse, [0.1, 0.05, 0.02].map(DVec3::splat));
    assert!(!measured.through && !measured.file.has_color());
    let total = measured.file.band().hemispherical([0.0, 0.6, 0.8], Lobes::All);
    assert!((total - 0.8).abs() < 1e-6, "{total}");
}

#[test]
fn an_absdf_takes_its_orientation_from_a_function_file_and_a_transformation() {
    let folder = folder(0.3);
    let device = parse(&format!("void aBSDF m 7 pane.xml 0 1 0 . -rz 90 0 0 {PANE}"), folder.path()).unwrap();
    let Material::Measured(measured) = &device.materials[0].material else { panic!("{device:?}") };
    let Orientation::Constant(up) = measured.up else { panic!("{measured:?}") };
    assert!(measured.through && up.distance(-DVec3::X) < 1e-15, "{up}");
    let device =
        parse(&format!("void aBSDF m 5 pane.xml ux uy uz up.cal 0 0 {PANE}"), folder.path()).unwrap();
    let Material::Measured(measured) = &device.materials[0].material else { panic!("{device:?}") };
    assert!(matches!(measured.up, Orientation::Varying(_)), "{measured:?}");
}

#[test]
fn a_thickness_stands_for_geometry_and_is_told() {
    let folder = folder(0.3);
    for (thickness, there) in
        [("0", true), ("thick", true), ("deep", false), ("-.1", false), ("2*deep", false)]
    {
        let text = format!("void BSDF m 6 {thickness} pane.xml 0 1 0 up.cal 0 0 {PANE}");
        let device = parse(&text, folder.path()).unwrap();
        assert_eq!(device.materials[0].material != Material::Void, there, "{thickness}");
        let told = device
            .warnings
            .iter()
            .any(|w| w.contains("stand for geometry") && w.starts_with("a.rad:1: BSDF"));
        assert_eq!(told, !there, "{:?}", device.warnings);
    }
    let text = format!("void BSDF m 6 Py pane.xml 0 1 0 . 0 0 {PANE}");
    let message = parse(&text, folder.path()).unwrap_err();
    assert!(
        message.contains("a thickness that is the same everywhere") && message.contains("'Py'"),
        "{message}"
    );
}

#[test]
fn an_up_direction_along_the_normal_is_told() {
    let folder = folder(0.3);
    for (up, told) in [("0 0 1", true), ("0 0 -2", true), ("0 1e-3 1", false)] {
        let device = parse(&format!("void aBSDF m 5 pane.xml {up} . 0 0 {PANE}"), folder.path()).unwrap();
        assert_eq!(device.warnings.iter().any(|w| w.contains("it is black")), told, "{:?}", device.warnings);
    }
}

#[test]
fn files_that_make_light_are_told_and_files_that_are_none_are_refused() {
    let folder = folder(0.7);
    let device = parse(&format!("void aBSDF m 5 pane.xml 0 1 0 . 0 0 {PANE}"), folder.path()).unwrap();
    assert!(device.warnings[0].contains("scatters up to 120.0 %"), "{:?}", device.warnings);
    std::fs::write(folder.path().join("bad.xml"), "<WindowElement><Optical></Optical>").unwrap();
    for (file, expected) in
        [("bad.xml", "bad.xml: line 1"), ("none.xml", "cannot read 'none.xml': no such file")]
    {
        let text = format!("void aBSDF m 5 {file} 0 1 0 . 0 0 {PANE}");
        let message = parse(&text, folder.path()).unwrap_err();
        assert!(message.starts_with("a.rad:1: ") && message.contains(expected), "{message}");
    }
    // Nobody uses it, so nobody misses it.
    assert!(parse("void aBSDF m 5 none.xml 0 1 0 . 0 0", folder.path()).is_ok());
    let mut solar = bsdftree::Bsdf::default();
    solar
        .band_mut("Solar")
        .insert(Part::ReflectionBack, Component::grey(Tree::uniform(Rank::Four, 0.1).into()));
    xml::write_file(&solar, folder.path().join("solar.xml")).unwrap();
    let message = parse(&format!("void aBSDF m 5 solar.xml 0 1 0 . 0 0 {PANE}"), folder.path()).unwrap_err();
    assert!(message.contains("expected data of wavelength Visible, found Solar"), "{message}");
}

#[test]
fn wrong_arguments_are_named_with_their_line() {
    for (text, expected) in [
        (
            "void BSDF m\n5 0 a.xml 0 1 0\n0\n0",
            "string arguments thickness bsdffile ux uy uz funcfile [transform]",
        ),
        ("void aBSDF m 5 a.xml 0 1 0 . 0 4 1 1 1 1", "0, 3, 6 or 9 real arguments"),
        ("void ashik2 m 4 1 0 0 . 0 7 1 1 1 1 1 1 1", "8 real arguments (dred"),
        ("void ashik2 m 4 1 0 0 . 0 8 1 1 1 1 1 1 -5 1", "a specular power of at least 0"),
        ("void ashik2 m 4 1 0 0 . 0 8 1 1 2 1 1 1 5 1", "diffuse colour between 0 and 1"),
        ("void ashik2 m 4 0 0 0 . 0 8 1 1 1 1 1 1 5 1", "a direction ux uy uz"),
        ("void prism1 m 4 1 0 0 1 0 0", "coef dx dy dz funcfile"),
        ("void prism2 m 5 1 0 0 1 . 0 0", "coef1 dx1 dy1 dz1 coef2"),
        ("void prism1 m 5 1 0 0 '1+' . 0 0", "complete the formula"),
        (
            "void WGMDfunc m 13 void 0 0 0 void 0 0 0 void 1 0 0 . 0 8 0 0 0 0 0 0 0 0",
            "9 or more real arguments",
        ),
        (
            "void WGMDfunc m 13 nobody 0 0 0 void 0 0 0 void 1 0 0 . 0 9 0 0 0 0 0 0 0 0 0",
            "'nobody' is not defined",
        ),
        ("void antimatter m 0 0 0", "1 or more string arguments"),
        ("void plastic p 0 0 5 1 1 1 0 0 p antimatter m 1 p 0 0", "as the modifier of antimatter \"m\""),
    ] {
        let message = error(text);
        assert!(message.starts_with("a.rad:") && message.contains(expected), "{text}: {message}");
    }
}

#[test]
fn parts_of_wgmdfunc_have_modifiers_of_their_own() {
    let wgmd = material(
        "void brightfunc grey 2 .5 . 0 0  void texfunc bumps 4 0 0 .1 . 0 0
         grey WGMDfunc m 13 inherit A10 .1 .2 bumps .3 .1 .1 void 1 0 0 . 0 10 .1 .1 .1 .2 .2 .2 .3 .3 .3 .4",
    );
    let Material::Modified { modifiers, material, .. } = wgmd else { panic!("{wgmd:?}") };
    let Material::Wgmd(wgmd) = *material else { panic!("{material:?}") };
    assert_eq!(modifiers.len(), 1);
    let lengths = wgmd.modifiers.each_ref().map(|m| m.as_ref().map(|m| m.len()));
    assert_eq!(lengths, [None, Some(1), Some(0)]);
    assert_eq!(wgmd.diffuse_reflection, [DVec3::splat(0.1), DVec3::splat(0.2)]);
    let message = error(
        "void plastic p 0 0 5 1 1 1 0 0
         void WGMDfunc m 13 p 1 .1 .2 void 0 0 0 void 1 0 0 . 0 9 0 0 0 0 0 0 0 0 0",
    );
    assert!(
        message.contains("a pattern or a texture as modifier of a part of \"m\", found the material 'p'"),
        "{message}"
    );
}

#[test]
fn antimatter_names_materials_by_their_places() {
    let text = "void glass clear 0 0 3 .9 .9 .9  void plastic red 0 0 5 .5 0 0 0 0
         void antimatter hole 3 red clear nobody 0 0  void antimatter window 2 void clear 0 0
         hole sphere a 0 0 4 0 0 0 1  clear sphere b 0 0 4 0 0 1 1  window sphere c 0 0 4 0 0 2 1";
    let device = parse(text, ".".as_ref()).unwrap();
    let names: Vec<&str> = device.materials.iter().map(|m| &*m.name).collect();
    assert_eq!(names, ["red", "clear", "hole", "window"]);
    let hole = Material::Antimatter(Antimatter { skin: Some(0), hidden: vec![0, 1] });
    let window = Material::Antimatter(Antimatter { skin: None, hidden: vec![1] });
    assert_eq!((&device.materials[2].material, &device.materials[3].material), (&hole, &window));
    assert_eq!(device.warnings.len(), 1);
    assert!(device.warnings[0].contains("'nobody' is not defined before it"), "{:?}", device.warnings);
}

#[test]
fn what_is_written_reads_back_as_it_was() {
    let folder = folder(0.3);
    let text = format!(
        "void BSDF m 6 0 pane.xml 0 2 1 . 0 3 .1 .2 .3 {PANE}
         void aBSDF m 7 pane.xml ux uy uz up.cal -rx 30 0 0 {PANE}
         void ashik2 m 4 1 0 Px . 0 8 .1 .2 .3 .4 .5 .6 50 200 {PANE}
         void prism1 m 7 .9 Dx Dy A1 . -s 2 0 2 .5 1 {PANE}
         void prism2 m 9 .4 Dx Dy .1 .4 Dx .1 Dz . 0 0 {PANE}
         void brightfunc grey 2 .5 . 0 0
         grey WGMDfunc m 15 inherit .1 .1 .2 grey .3 .1 .1 void 1 0 0 . -rz 20 0 9 .1 .1 .1 .2 .2 .2 .3 .3 .3 {PANE}
         void glass clear 0 0 3 .9 .9 .9  void plastic red 0 0 5 .5 0 0 0 0
         void antimatter m 3 red clear m 0 0 {PANE} clear sphere s 0 0 4 0 0 0 1
         void antimatter none 2 void clear 0 0  none sphere s 0 0 4 0 0 0 1"
    );
    let device = parse(&text, folder.path()).unwrap();
    let again = parse(&device.to_rad(), PathBuf::from("/").as_path()).unwrap();
    assert_eq!(device.surfaces, again.surfaces);
    assert_eq!(device.materials.len(), again.materials.len());
    for (a, b) in device.materials.iter().zip(&again.materials) {
        // Turns are written in degrees, so they differ by rounding.
        let is_turned = matches!(a.material, Material::Modified { .. } | Material::Prism(_))
            || matches!(&a.material, Material::Measured(m) if m.through);
        assert!(a == b || is_turned, "{a:?} {b:?}");
        assert_eq!(a.name, b.name);
    }
}
