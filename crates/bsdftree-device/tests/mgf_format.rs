//! What the language says, beyond what mgf2rad can be asked: includes, holes, limits, places of errors.

use std::fs;
use std::path::Path;

use bsdftree_device::material::{Gloss, GlossKind};
use bsdftree_device::options::Limits;
use bsdftree_device::{Device, DeviceError, Material, ReadOptions, Shape, Unit};
use glam::{DVec3, dvec3};
use tempfile::TempDir;

const SQUARE: &str = "v a =\np 0 0 0\nv b =\np 1 0 0\nv c =\np 1 1 0\nv d =\np 0 1 0\n";

fn parse(text: &str) -> Device {
    Device::parse_mgf(text, "text.mgf", Path::new("."), Unit::Meter).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn message(text: &str) -> String {
    Device::parse_mgf(text, "text.mgf", Path::new("."), Unit::Meter).unwrap_err().to_string()
}

fn directory(files: &[(&str, &str)]) -> TempDir {
    let directory = TempDir::new().unwrap();
    for (name, text) in files {
        let path = directory.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    directory
}

fn read(directory: &TempDir, name: &str) -> Result<Device, DeviceError> {
    Device::read_mgf(&[directory.path().join(name)], Unit::Meter)
}

fn gloss(material: &Material) -> &Gloss {
    let Material::Gloss(gloss) = material else { panic!("{material:?}") };
    gloss
}

fn area(device: &Device) -> f64 {
    device.surfaces.iter().map(|s| s.shape.area()).sum()
}

#[test]
fn includes_are_found_beside_the_file_that_names_them() {
    let files = directory(&[
        ("top.mgf", "o top\ni parts/part.mgf\ni parts/part.mgf -t 5 0 0 -a 2 -t 0 0 1\no\n"),
        ("parts/part.mgf", "i materials.mgf\nm white\nv a =\no part\nsph a 1\no\n"),
        ("parts/materials.mgf", "m white =\nrd .5\n"),
    ]);
    let device = read(&files, "top.mgf").unwrap();
    let found: Vec<_> = device
        .surfaces
        .iter()
        .map(|s| match s.shape {
            Shape::Sphere { center, .. } => (s.name.as_str(), center),
            _ => panic!("{s:?}"),
        })
        .collect();
    let expected = [
        ("top.part.s1", DVec3::ZERO),
        ("top.a0.part.s2", dvec3(5.0, 0.0, 0.0)),
        ("top.a1.part.s3", dvec3(5.0, 0.0, 1.0)),
    ];
    assert_eq!(found, expected);
    assert_eq!(device.materials.len(), 1);
}

#[test]
fn contexts_go_on_in_the_next_file() {
    let files = directory(&[("materials.mgf", "m white =\nrd .5\n"), ("b.mgf", "v a =\nsph a 1\n")]);
    let paths = ["materials.mgf", "b.mgf"].map(|name| files.path().join(name));
    let device = Device::read_mgf(&paths, Unit::Foot).unwrap();
    assert_eq!(device.materials[0].name, "white");
    assert_eq!(device.bounds().unwrap()[1], DVec3::splat(0.3048));
}

#[test]
fn circles_of_files_are_refused() {
    let files = directory(&[
        ("a.mgf", "\ni b/b.mgf\n"),
        ("b/b.mgf", "i ../b/./c.mgf\n"),
        ("b/c.mgf", "i ../a.mgf\n"),
    ]);
    let error = read(&files, "a.mgf").unwrap_err();
    assert!(matches!(&error, DeviceError::Cycle { chain, .. } if chain.len() == 4), "{error}");
    assert!(error.to_string().contains("c.mgf:1: files name each other in a circle"), "{error}");
}

#[test]
fn deep_nesting_is_refused() {
    let many: Vec<(String, String)> =
        (0..70).map(|k| (format!("{k}.mgf"), format!("i {}.mgf\n", k + 1))).collect();
    let files: Vec<(&str, &str)> = many.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    assert!(
        read(&directory(&files), "0.mgf")
            .unwrap_err()
            .to_string()
            .contains("more than 64 files inside each other")
    );
    assert!(
        message(&"xf -t 1 0 0\n".repeat(100))
            .contains("text.mgf:65: the scene has more than 64 transformations")
    );
    assert!(message(&"o a\n".repeat(1000)).contains("objects inside each other"));
}

#[test]
fn included_files_end_what_they_begin_and_no_more() {
    let files = directory(&[
        ("open.mgf", "i begins.mgf\n"),
        ("begins.mgf", "\nxf -t 1 0 0\n"),
        ("close.mgf", "xf -t 1 0 0\ni ends.mgf\nxf\n"),
        ("ends.mgf", "xf\n"),
        ("array.mgf", "i ends.mgf -a 3 -t 1 0 0\n"),
    ]);
    for (name, part) in [
        (
            "open.mgf",
            "begins.mgf:2: expected 'xf' that ends this one in the same file, found the end of the file",
        ),
        ("close.mgf", "ends.mgf:1: expected 'xf' with a transformation before 'xf' that ends it"),
        ("array.mgf", "ends.mgf:1: expected 'xf' with a transformation before 'xf' that ends it"),
    ] {
        let error = read(&files, name).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn missing_files_are_named_with_their_line() {
    let files = directory(&[("a.mgf", "# \ni nowhere.mgf\n")]);
    let error = read(&files, "a.mgf").unwrap_err().to_string();
    assert!(error.contains("a.mgf:2: cannot read '") && error.contains("nowhere.mgf"), "{error}");
    assert!(
        Device::read_mgf(&["/nowhere.mgf".into()], Unit::Meter)
            .unwrap_err()
            .to_string()
            .starts_with("cannot read")
    );
    assert!(read(&files, ".").unwrap_err().to_string().contains("not a regular file"));
}

#[test]
fn huge_arrays_cost_no_time() {
    for (words, part) in [
        ("-a 1000000000 -t 1 0 0", "more than 10000000 copies"),
        ("-a 1e9", "more than 10000000 copies"),
        ("-a 1e19 -a 1e19", "more than 10000000 copies"),
        ("-a 100000 -t 1 0 0 -a 1000 -t 0 1 0", "more than 10000000 copies"),
        ("-i 1e300 -s 2", "an overflow in a transformation"),
        ("-s 1e300 -s 1e300", "an overflow in a transformation"),
    ] {
        let error = message(&format!("{SQUARE}xf {words}\nsph a 1\nxf\n"));
        assert!(error.starts_with("text.mgf:9: ") && error.contains(part), "{words}: {error}");
    }
}

#[test]
fn nested_arrays_are_bounded_together() {
    let limits = Limits { surfaces: 100, bytes: 1 << 20, ..Limits::DEFAULT };
    let options = || ReadOptions { limits, ..ReadOptions::default() };
    let read = |text: &str| Device::parse_mgf(text, "t", Path::new("."), options());
    let nested =
        |body: &str| format!("{SQUARE}{}{body}\n{}", "xf -a 90 -t 1 0 0\n".repeat(5), "xf\n".repeat(5));
    assert!(read(&nested("sph a 1")).unwrap_err().to_string().contains("more than 100 surfaces"));
    assert!(read(&nested("")).unwrap_err().to_string().contains("more than 1048576 bytes"));
    let once = format!("{SQUARE}xf -a 90 -t 1 0 0\nsph a 1\nxf\n");
    assert_eq!(read(&once).unwrap().surfaces.len(), 90);
}

#[test]
fn holes_stay_open_whichever_way_they_turn_and_however_many() {
    let holes = "v h1 =\np .1 .1 0\nv h2 =\np .3 .1 0\nv h3 =\np .3 .3 0\nv h4 =\np .1 .3 0\nv g1 =\np .6 .6 0\nv g2 =\np .8 .6 0\nv g3 =\np .8 .8 0\n";
    for (face, open) in [
        ("fh a b c d - h1 h2 h3 h4", 0.04),
        ("fh a b c d - h4 h3 h2 h1", 0.04),
        ("fh a b c d - h1 h2 h3 h4 - g1 g2 g3", 0.06),
        ("fh d c b a - h4 h3 h2 h1 - g1 g2 g3 -", 0.06),
    ] {
        let device = parse(&format!("{SQUARE}{holes}{face}\n"));
        assert!((area(&device) - (1.0 - open)).abs() < 1e-12, "{face}: {}", area(&device));
        let up = !face.starts_with("fh d");
        for surface in &device.surfaces {
            let [[a, b, c]] = surface.shape.triangulate()[..] else { panic!("{surface:?}") };
            assert_eq!((b - a).cross(c - a).z > 0.0, up, "{face}");
        }
    }
    assert_eq!(parse(&format!("{SQUARE}fh a b c d\n")).surfaces.len(), 1);
}

/// The closed solid of a prism: its volume, by the divergence theorem, is positive if it faces out.
#[test]
fn prisms_are_closed_and_face_out_or_in() {
    for (base, length) in [("a b c d", 0.5), ("d c b a", 0.5), ("a b c d", -0.5)] {
        let device = parse(&format!("{SQUARE}prism {base} {length}\n"));
        let triangles = device.surfaces.iter().flat_map(|s| s.shape.triangulate());
        let volume: f64 = triangles.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
        assert!((volume - length).abs() < 1e-12, "{base}: {volume}");
    }
}

#[test]
fn vertices_without_normals_again_are_flat() {
    let device =
        parse(&format!("{SQUARE}v a\nn 1 0 1\nv b\nn 0 0 1\nv c\nn 0 0 1\nf a b c\nv a\nn 0 0 0\nf a b c\n"));
    assert!(
        matches!(device.surfaces[0].shape, Shape::Mesh(_))
            && matches!(device.surfaces[1].shape, Shape::Polygon(_))
    );
    // Of the plane itself, or nearly.
    let flat = parse(&format!("{SQUARE}v a\nn 0 0 3\nv b\nn 1e-4 0 1\nv c\nn 0 0 1\nf a b c\n"));
    assert!(matches!(flat.surfaces[0].shape, Shape::Polygon(_)));
}

#[test]
fn materials_are_in_the_order_of_their_use_and_change_by_name() {
    let text = "v a =\nm x =\nrd .1\nm y =\nrd .2\nsph a 1\nm x\nsph a 2\nrd .3\nsph a 3\nm y\nsph a 4\nm z = y\nsph a 5\n";
    let device = parse(text);
    let names: Vec<&str> = device.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["y", "x", "x", "z"]);
    let used: Vec<u32> = device.surfaces.iter().map(|s| s.material).collect();
    assert_eq!(used, [0, 1, 2, 0, 3]);
    assert_eq!(gloss(&device.materials[2].material).color, DVec3::splat(0.3));
}

#[test]
fn highlights_that_are_white_stay_white() {
    let device = parse("v a =\nm x =\nc\ncxy .5 .4\nrd .3\nc\nrs .3 .1\nsph a 1\n");
    let gloss = gloss(&device.materials[0].material);
    assert_eq!((gloss.kind, gloss.specular, gloss.roughness), (GlossKind::Plastic, 0.3, [0.1; 2]));
    let luminance = bsdftree::color::xyz_from_rgb(gloss.color.to_array())[1];
    assert!((luminance * 0.7 - 0.3).abs() < 1e-12, "{gloss:?}");
}

#[test]
fn faint_transmission_is_kept() {
    let device = parse("v a =\nm x =\nrd .5\ntd .004\nrs .02 .1\nsph a 1\n");
    let gloss = gloss(&device.materials[0].material);
    assert_eq!(gloss.kind, GlossKind::Trans);
    let diffuse = gloss.color.x * (1.0 - gloss.specular);
    assert!(
        (diffuse * gloss.transmission - 0.004).abs() < 1e-12
            && (diffuse * (1.0 - gloss.transmission) - 0.5).abs() < 1e-12
    );
    let clear = parse("v a =\nm x =\ntd .6\nrs .1 .1\nsph a 1\n");
    let gloss = self::gloss(&clear.materials[0].material);
    assert!((gloss.color.x * (1.0 - gloss.specular) * gloss.transmission - 0.6).abs() < 1e-12, "{gloss:?}");
}

#[test]
fn solids_pass_what_is_left_after_one_reflection() {
    let f: f64 = (0.5_f64 / 2.5).powi(2);
    let ts = (1.0 - f) * 0.999;
    let text = format!("v a =\nm x =\nir 1.5 0\nsides 1\nrs {f} 0\nts {ts} 0\nsph a 1\n");
    for unit in [Unit::Meter, Unit::Millimeter] {
        let device = Device::parse_mgf(&text, "t", Path::new("."), unit).unwrap();
        let Material::Dielectric { inside, .. } = &device.materials[0].material else { panic!() };
        // 5 units of 1/1000.
        let through = inside.transmittance.x.powf(0.005 * unit.meters());
        assert!((through - 0.999).abs() < 1e-9 && inside.index == 1.5, "{inside:?}");
    }
}

#[test]
fn light_and_too_much_color_are_told() {
    let device = parse(
        "v a =\nm lamp =\ned 500\nsph a 1\nm red =\nc\ncxy .6 .35\nrd .9\nsph a 2\nc\nm foggy =\nir 1.5 0\n\nrd .01\nrs .08 0\nts .8 0\nsph a 3\n",
    );
    assert_eq!(device.materials[0].material, Material::Black);
    let told = device.warnings.join("\n");
    assert!(told.contains("text.mgf:3: material \"lamp\": its light is left out"), "{told}");
    assert!(told.contains("text.mgf:8: material \"red\": it is paler"), "{told}");
    assert!(told.contains("material \"foggy\": its diffuse part is left out"), "{told}");
    assert_eq!(device.warnings.len(), 3, "{told}");
}

#[test]
fn unknown_entities_are_told_once_and_left_out() {
    let device = parse("\nfrobnicate 1 2\nv a =\nfrobnicate 3\nsph a 1\n#no space\n");
    assert_eq!(device.surfaces.len(), 1);
    assert_eq!(device.warnings, ["text.mgf:2: unknown entity 'frobnicate' is left out wherever it stands"]);
    let many: String = (0..10_000).map(|k| format!("x{k}\n")).collect();
    assert_eq!(parse(&many).warnings.len(), 101);
}

#[test]
fn what_has_no_area_is_dropped_and_told() {
    let device = parse(&format!("{SQUARE}f a a b\nfh a a b - a b c\nsph a 0\ncyl a 1 a\nf a b c\n"));
    assert_eq!((device.surfaces.len(), device.warnings.len()), (1, 4), "{:?}", device.warnings);
}

#[test]
fn luminaires_are_refused() {
    let error = message("o x\nies lamp.ies -m .5\n");
    assert!(error.starts_with("text.mgf:2: the luminaire of 'ies' is not supported"), "{error}");
}

#[test]
fn errors_name_place_found_and_expected() {
    for (text, parts) in [
        ("f a b c", &["text.mgf:1: vertex 'a' is not defined"][..]),
        ("\nm x\n", &["text.mgf:2: material 'x' is not defined"]),
        ("c x = y", &["colour 'y' is not defined"]),
        ("v a =\np 1 2 x", &["text.mgf:2: expected a number as argument 3 of 'p', found 'x'"]),
        ("p 1 2", &["expected x, y, z after 'p', found 2 arguments"]),
        ("rd 1.5", &["expected a number between 0 and 1 as argument 1 of 'rd', found '1.5'"]),
        ("rd nan", &["found 'nan'"]),
        ("rd 0x1", &["found '0x1'"]),
        ("sides 3", &["expected 1 or 2 sides, found '3'"]),
        ("c\ncspec 700 400 1 1", &["a last wavelength above the first, found 700 to 400"]),
        ("c\ncxy .3 0", &["x ≥ 0, y > 0 and x + y ≤ 1, found '.3 0'"]),
        ("c a =\nc\ncmix 1 a 2 a 3", &["a name for each weight"]),
        ("v a =\nring a 0 1", &["a vertex with a normal, found no normal at vertex 'a': add 'n'"]),
        ("v a =\nn 0 0 1\nring a 1 1", &["0 ≤ inner radius < outer radius, found 1 and 1"]),
        ("xf -t 1 2", &["a number as argument 3 of -t, found the end of the words"]),
        ("xf -q 1", &["one of -t -rx", "'-q'"]),
        ("o", &["no open object"]),
        ("xf -a 2\no x\nxf", &["text.mgf:3: expected the end of all objects before the array ends"]),
        ("xf -a 2\no\nxf", &["text.mgf:2:", "no open object"]),
        (
            "v a =\nm x =\n\nrd .8\nts .3 0\nsph a 1",
            &[
                "text.mgf:5: expected rd + td + rs + ts of at most 1 in material \"x\", found 1.1",
                "\"s1\" uses it at text.mgf:6",
            ],
        ),
        (
            "v a =\np 1e300 0 0\nxf -s 1e300\nsph a 1\nxf",
            &["text.mgf:4: expected lengths within the range of numbers"],
        ),
        ("v a =\np 1e999 0 0", &["'1e999'"]),
    ] {
        let error = message(text);
        for part in parts {
            assert!(error.contains(part), "{text}\n{error}");
        }
    }
}

#[test]
fn errors_in_files_name_the_included_file() {
    let files = directory(&[("a.mgf", "i b.mgf\n"), ("b.mgf", "\n\nsph x 1\n")]);
    assert!(read(&files, "a.mgf").unwrap_err().to_string().contains("b.mgf:3: vertex 'x' is not defined"));
}

#[test]
fn one_transformation_left_open_at_the_end_is_told() {
    let device = parse("v a =\nxf -t 1 0 0 -a 2\nsph a 1\n");
    assert_eq!(device.surfaces.len(), 1);
    assert!(device.warnings[0].contains("text.mgf:2: 'xf' is not ended"), "{:?}", device.warnings);
}
