//! What the reader of Radiance scenes understands.

use std::path::Path;

use bsdftree_device::material::{GlossKind, Medium};
use bsdftree_device::{Device, DeviceError, Material, Shape, Unit};
use glam::{DVec3, dvec3};

fn read(text: &str) -> Result<Device, DeviceError> {
    Device::parse_rad(text, "scene.rad", Path::new("."), Unit::Meter)
}

const WHITE: &str = "void plastic white 0 0 5 .8 .8 .8 0 0\n";

/// The only shape of a scene with a white material in front.
fn shape(text: &str) -> Shape {
    let device = read(&format!("{WHITE}{text}")).unwrap();
    assert_eq!(device.surfaces.len(), 1, "{:?}", device.warnings);
    device.surfaces[0].shape.clone()
}

/// The material that a ring gets from a definition of `m`.
fn material(definition: &str) -> Material {
    let device = read(&format!("{definition}\nm ring r 0 0 8 0 0 0 0 0 1 0 1")).unwrap();
    device.materials[device.surfaces[0].material as usize].material.clone()
}

#[test]
fn all_surface_types_are_read() {
    assert_eq!(
        shape("white sphere s 0 0 4 1 2 3 .5"),
        Shape::Sphere { center: dvec3(1.0, 2.0, 3.0), radius: 0.5, inward: false }
    );
    assert!(matches!(shape("white bubble s 0 0 4 1 2 3 .5"), Shape::Sphere { inward: true, .. }));
    let ends = [DVec3::ZERO, DVec3::Z];
    assert_eq!(
        shape("white cylinder c 0 0 7 0 0 0 0 0 1 .5"),
        Shape::Cylinder { ends, radius: 0.5, inward: false }
    );
    assert!(matches!(shape("white tube c 0 0 7 0 0 0 0 0 1 .5"), Shape::Cylinder { inward: true, .. }));
    let cone = Shape::Cone { ends, radii: [0.5, 0.0], inward: false };
    assert_eq!(shape("white cone c 0 0 8 0 0 0 0 0 1 .5 0"), cone);
    assert!(matches!(shape("white cup c 0 0 8 0 0 0 0 0 1 .5 0"), Shape::Cone { inward: true, .. }));
    let ring = Shape::Ring { center: DVec3::ZERO, normal: DVec3::Y, radii: [0.1, 0.3] };
    assert_eq!(shape("white ring r 0 0 8 0 0 0 0 5 0 .1 .3"), ring);
    let polygon = Shape::Polygon(vec![DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(shape("white polygon p 0 0 9 0 0 0 1 0 0 0 1 0"), polygon);
}

#[test]
fn odd_radii_are_handled_as_in_radiance() {
    assert!(matches!(
        shape("white sphere s 0 0 4 0 0 0 -2"),
        Shape::Sphere { radius: 2.0, inward: true, .. }
    ));
    assert!(matches!(shape("white bubble s 0 0 4 0 0 0 -2"), Shape::Sphere { inward: false, .. }));
    assert!(matches!(shape("white cylinder s 0 0 7 0 0 0 0 0 1 -2"), Shape::Cylinder { inward: true, .. }));
    assert!(matches!(shape("white cup s 0 0 8 0 0 0 0 0 1 -2 -1"), Shape::Cone { inward: false, .. }));
    assert!(matches!(shape("white cone s 0 0 8 0 0 0 0 0 1 2 2"), Shape::Cylinder { radius: 2.0, .. }));
    assert!(matches!(shape("white ring s 0 0 8 0 0 0 0 0 1 2 1"), Shape::Ring { radii: [1.0, 2.0], .. }));
    for dropped in [
        "sphere s 0 0 4 0 0 0 0",
        "cylinder s 0 0 7 1 2 3 1 2 3 1",
        "cylinder s 0 0 7 0 0 0 0 0 1 0",
        "cone s 0 0 8 0 0 0 0 0 1 1 -1",
        "ring s 0 0 8 0 0 0 0 0 1 1 1",
        "ring s 0 0 8 0 0 0 0 0 0 0 1",
        "ring s 0 0 8 0 0 0 0 0 1 -1 1",
        "polygon s 0 0 9 0 0 0 1 1 1 2 2 2",
    ] {
        let device = read(&format!("{WHITE}white {dropped}")).unwrap();
        assert!(device.surfaces.is_empty(), "{dropped}");
        assert!(device.warnings[0].starts_with("scene.rad:2: "), "{:?}", device.warnings);
        assert!(device.warnings[0].contains("\"s\" is dropped: "), "{:?}", device.warnings);
    }
}

#[test]
fn bent_polygons_are_kept_with_a_warning() {
    let device = read(&format!("{WHITE}white polygon p 0 0 12 0 0 0 1 0 0 1 1 .5 0 1 0")).unwrap();
    assert_eq!(device.surfaces.len(), 1);
    assert!(device.warnings[0].contains("not in one plane"));
}

#[test]
fn all_gloss_types_are_read() {
    for (kind, expected) in
        [("plastic", GlossKind::Plastic), ("metal", GlossKind::Metal), ("trans", GlossKind::Trans)]
    {
        let tail = if kind == "trans" { ".6 .7" } else { "" };
        let n = if kind == "trans" { 7 } else { 5 };
        let Material::Gloss(gloss) = material(&format!("void {kind} m 0 0 {n} .1 .2 .3 .4 .5 {tail}")) else {
            panic!("{kind} is a gloss")
        };
        assert_eq!((gloss.kind, gloss.color, gloss.specular), (expected, dvec3(0.1, 0.2, 0.3), 0.4));
        assert_eq!((gloss.roughness, gloss.orientation), ([0.5, 0.5], None));
        let transmitted = (gloss.transmission, gloss.transmitted_specular);
        assert_eq!(transmitted, if kind == "trans" { (0.6, 0.7) } else { (0.0, 0.0) });

        let two = format!("void {kind}2 m 4 0 3 0 . 0 {} .1 .2 .3 .4 .05 .15 {tail}", n + 1);
        let Material::Gloss(gloss) = material(&two) else { panic!("{kind}2 is a gloss") };
        assert_eq!(
            (gloss.kind, gloss.roughness, gloss.orientation),
            (expected, [0.05, 0.15], Some(DVec3::Y))
        );
        assert_eq!((gloss.transmission, gloss.transmitted_specular), transmitted);
    }
}

#[test]
fn orientation_takes_its_own_transformation() {
    let turned = "void metal2 m 8 1 0 0 . -s 3 -rz 90 0 6 .1 .1 .1 .5 .1 .2";
    let Material::Gloss(gloss) = material(turned) else { panic!("metal2 is a gloss") };
    assert_eq!(gloss.orientation, Some(DVec3::Y));
}

#[test]
fn transparent_materials_are_read() {
    let glass = Material::Glass { transmissivity: dvec3(0.9, 0.8, 0.7), index: 1.52 };
    assert_eq!(material("void glass m 0 0 3 .9 .8 .7"), glass);
    assert!(matches!(material("void glass m 0 0 4 .9 .8 .7 1.6"), Material::Glass { index: 1.6, .. }));
    let inside = Medium { transmittance: dvec3(0.9, 0.8, 0.7), index: 1.5 };
    let dielectric = Material::Dielectric { inside, outside: Medium::VACUUM };
    assert_eq!(material("void dielectric m 0 0 5 .9 .8 .7 1.5 0"), dielectric);
    let outside = Medium { transmittance: DVec3::splat(0.5), index: 1.33 };
    let interface = material("void interface m 0 0 8 .9 .8 .7 1.5 .5 .5 .5 1.33");
    assert_eq!(interface, Material::Dielectric { inside, outside });
}

#[test]
fn emitters_are_black_and_illum_is_its_alternate() {
    for emitter in ["light m 0 0 3 1 1 1", "glow m 0 0 4 1 1 1 0", "spotlight m 0 0 7 1 1 1 20 0 0 -1"] {
        let device = read(&format!("void {emitter}\nm ring r 0 0 8 0 0 0 0 0 1 0 1")).unwrap();
        assert_eq!(device.materials[0].material, Material::Black);
        assert_eq!(device.warnings.len(), 1, "{emitter}");
        assert!(device.warnings[0].starts_with("scene.rad:1: "));
    }
    assert_eq!(material("void illum m 0 0 3 1 1 1"), Material::Void);
    assert_eq!(material("void illum m 1 void 0 3 1 1 1"), Material::Void);
    let alternate = material("void glass g 0 0 3 .5 .5 .5 void illum m 1 g 0 3 1 1 1");
    assert!(matches!(alternate, Material::Glass { .. }));
    assert_eq!(read("void light unused 0 0 3 1 1 1").unwrap().warnings.len(), 0);
}

#[test]
fn mirror_with_alternate_stays_a_mirror_with_a_warning() {
    let text = format!("{WHITE}void mirror m 1 white 0 3 .8 .7 .6\nm ring r 0 0 8 0 0 0 0 0 1 0 1");
    let device = read(&text).unwrap();
    assert_eq!(device.materials[0].material, Material::Mirror { reflectance: dvec3(0.8, 0.7, 0.6) });
    assert!(device.warnings[0].contains("'white'"), "{:?}", device.warnings);
}

#[test]
fn void_surfaces_are_not_there() {
    let device = read("void ring r 0 0 8 0 0 0 0 0 1 0 1").unwrap();
    assert_eq!(device.materials[0].material, Material::Void);
}

#[test]
fn latest_definition_before_use_wins() {
    let device = read(
        "void plastic m 0 0 5 .1 .1 .1 0 0\nm sphere a 0 0 4 0 0 0 1\nvoid plastic m 0 0 5 .2 .2 .2 0 0\n\
         m sphere b 0 0 4 0 0 0 1\nvoid plastic m 0 0 5 .1 .1 .1 0 0\nm sphere c 0 0 4 0 0 0 1",
    )
    .unwrap();
    let used: Vec<u32> = device.surfaces.iter().map(|s| s.material).collect();
    assert_eq!(used, [0, 1, 0]);
}

#[test]
fn aliases_keep_what_they_were_made_from() {
    let device = read(
        "void plastic a 0 0 5 .1 .1 .1 0 0\nvoid alias b a\ninherit alias c b\nvoid plastic a 0 0 5 .2 .2 .2 0 0\n\
         b sphere s 0 0 4 0 0 0 1\nc sphere t 0 0 4 0 0 0 1",
    )
    .unwrap();
    let names: Vec<&str> = device.materials.iter().map(|m| &*m.name).collect();
    assert_eq!(names, ["b", "c"]);
    assert_eq!(device.materials[0].material, device.materials[1].material);
}

#[test]
fn alias_under_void_loses_its_pattern_and_inherit_keeps_it() {
    let head = "void brightfunc pat 2 Px . 0 0\npat plastic a 0 0 5 .1 .1 .1 0 0\n";
    let with = |alias: &str| read(&format!("{head}{alias}\nb sphere s 0 0 4 0 0 0 1")).unwrap();
    assert!(matches!(with("void alias b a").materials[0].material, Material::Gloss(_)));
    assert!(matches!(with("inherit alias b a").materials[0].material, Material::Modified { .. }));
}

#[test]
fn units_scale_lengths_and_absorption() {
    let text = "void dielectric d 0 0 5 .9 .5 0 1.5 0\nd sphere s 0 0 4 1 2 3 .5";
    let device = Device::parse_rad(text, "s", Path::new("."), Unit::Centimeter).unwrap();
    assert_eq!(
        device.surfaces[0].shape,
        Shape::Sphere { center: dvec3(0.01, 0.02, 0.03), radius: 0.005, inward: false }
    );
    let Material::Dielectric { inside, .. } = &device.materials[0].material else { panic!("a dielectric") };
    // 0.9 over 1 cm is 0.9^100 over 1 m.
    assert!((inside.transmittance.x / 0.9f64.powi(100) - 1.0).abs() < 1e-12);
    assert_eq!(inside.transmittance.z, 0.0);
}

#[test]
fn layout_and_comments_do_not_matter() {
    let text =
        "# head !not a command\n\n  void\tplastic \"a b\" 0\n0 5\n.5 .5 5e-1 +0 0. # tail\n!cat\\\n  \n";
    let error = read(text).unwrap_err().to_string();
    assert!(error.starts_with("scene.rad:6: expected a file"), "{error}");
}

#[test]
fn written_scenes_read_back_the_same() {
    let text = "void trans2 t 4 1 2 3 . 0 8 .1 .2 .3 .04 .05 .06 .7 .8\n\
        void metal m 0 0 5 .1 .2 .3 .9 .05\nvoid glow g 0 0 4 0 0 0 0\nvoid illum i 0 0 3 0 0 0\n\
        void interface f 0 0 8 .9 .8 .7 1.5 .5 .5 .5 1.33\nvoid dielectric d 0 0 5 .9 .8 .7 1.5 0\n\
        void mirror w 0 0 3 .8 .8 .8\nvoid glass l 0 0 3 .9 .9 .9\n\
        t polygon a 0 0 9 0 0 0 1e-9 0 0 0.1 1e-3 0\nm ring b 0 0 8 0 0 0 1 1 1 .1 .3\n\
        g cone c 0 0 8 0 0 0 0 .1 1 .5 0\ni cup e 0 0 8 0 0 0 0 .1 1 .5 0\nf tube h 0 0 7 1 2 3 4 5 6 .1\n\
        d cylinder j 0 0 7 1 2 3 4 5 6 .1\nw sphere k 0 0 4 1 2 3 .3\nl bubble n 0 0 4 1 2 3 .3\n\
        void ring o 0 0 8 0 0 0 1 0 0 0 1\nvoid plastic m 0 0 5 .5 .5 .5 0 0\nm ring p 0 0 8 0 0 0 0 0 1 0 1\n";
    let device = Device::parse_rad(text, "s", Path::new("."), Unit::Inch).unwrap();
    assert_eq!((device.surfaces.len(), device.materials.len()), (10, 10));
    assert_eq!(read(&device.to_rad()).unwrap(), device);
}
