//! Patterns, textures, mixtures and function materials of scene files: what is read, what is written, what is wrong.

use std::path::Path;

use bsdftree_device::field::{RayState, Source};
use bsdftree_device::material::{Material, Modifier};
use bsdftree_device::{Device, DeviceError, ReadOptions, Unit, Up};
use glam::DVec3;

const RING: &str = "\nm ring r 0 0 8 0 0 0 0 0 1 0 1";

fn read_in(text: &str, folder: &Path, unit: Unit) -> Result<Device, DeviceError> {
    let options = ReadOptions { unit, search: Some(Vec::new()), ..ReadOptions::default() };
    Device::parse_rad(text, "scene.rad", folder, options)
}

/// A folder with a function file, a data file and a picture.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    put("f.cal", b"checks = if(Px, A1, .2); f(x,y,z,o) = z; half(v) = v/2; u = 2*Px; ramp(nm) = nm/1000; plus(v,nm) = v + nm/1e4;");
    put("d.dat", b"2\n0 1 2\n0 0 3 0 .2 1\n1 2 3\n4 5 6\n");
    put("s.dat", b"1\n0 0 3 400 500 800\n.1 .2 .3\n");
    put("wrong.cal", b"a = 1;\nb = 2 + ;\n");
    put("wrong.dat", b"1\n0 1 2\n5 x\n");
    put("p.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n\x80\x80\x80\x80\x90\x80\x80\x80\xa0\x80\x80\x80\xb0\x80\x80\x80");
    put("s.fnt", b"73 4 100 0 150 0 150 200 100 200 # I\n32 0\n");
    put("lines.txt", b"I I\n\nIII\n");
    put(
        "p.spc",
        b"#?RADIANCE\nNCOMP=4\nWAVELENGTH_SPLITS= 780 588 480 380\nFORMAT=Radiance_spectra\n\n-Y 2 +X 2\n\
          \x80\x90\xa0\xb0\x80\x80\x90\xa0\xb0\x80\x80\x90\xa0\xb0\x80\x80\x90\xa0\xff\x80",
    );
    put("dark.rad", b"void brightfunc dark 2 if(Pz,.1,.9) . 0 0\n");
    folder
}

const ALL: &[&str] = &[
    "void brightfunc a 2 checks f.cal 0 1 .8\na plastic m 0 0 5 .5 .5 .5 0 0",
    "void colorfunc a 10 .1 'if(Px, .2, .3)' Rdot f.cal -rz 30 -t 1 2 3 0 0\na metal m 0 0 5 .5 .5 .5 .9 .1",
    "void brightdata a 7 half d.dat f.cal u Py -rx 20 0 0\na glass m 0 0 3 .9 .9 .9",
    "void colordata a 9 half noop half d.dat d.dat d.dat f.cal u Py 0 0\na trans m 0 0 7 .5 .5 .5 0 0 .5 .5",
    "void colorpict a 8 red green blue p.hdr . Px Py -my 0 0\na mirror m 0 0 3 .5 .5 .5",
    "void texfunc a 8 Px 0 .1*Py . -s 2 -ry 10 0 0\na brightfunc b 2 .5 . 0 0\nb plastic m 0 0 5 .5 .5 .5 .1 .1",
    "void texdata a 9 red green blue d.dat d.dat d.dat . Px Py 0 0\na plastic m 0 0 5 .5 .5 .5 .1 .1",
    "void plastic x 0 0 5 .5 .5 .5 0 0\nvoid mixfunc m 4 x void checks f.cal 0 1 .3",
    "void plastic x 0 0 5 .5 .5 .5 0 0\nvoid metal y 0 0 5 .9 .9 .9 1 0\nvoid mixdata m 7 x y half d.dat f.cal u Py 0 0",
    "void brightfunc x 2 .3 . 0 0\nvoid mixpict a 7 x void grey p.hdr . Px Py 0 0\na glass m 0 0 3 .9 .9 .9",
    "void spectrum a 0 0 5 400 700 .1 .2 .3\na plastic m 0 0 5 .5 .5 .5 0 0",
    "void specfile a 1 s.dat 0 0\na plastic m 0 0 5 .5 .5 .5 0 0",
    "void specfunc a 2 ramp f.cal 0 2 400 700\na plastic m 0 0 5 .5 .5 .5 0 0",
    "void specdata a 6 plus d.dat f.cal u -rz 30 0 0\na plastic m 0 0 5 .5 .5 .5 0 0",
    "void specpict a 6 plus p.spc f.cal u Py -my 0 0\na plastic m 0 0 5 .5 .5 .5 0 0",
    "void brighttext a 2 s.fnt lines.txt 0 11 0 1 0 .1 .02 0 0 -.2 .1 .1 .9\na plastic m 0 0 5 .5 .5 .5 0 0",
    "void colortext a 4 s.fnt . I 'I I' 0 16 0 1 0 .1 0 0 0 -.2 0 .1 .2 .3 .4 .5 .6 -.2\na glass m 0 0 3 .9 .9 .9",
    "void plastic x 0 0 5 .5 .5 .5 0 0\nvoid mixtext m 4 x void s.fnt lines.txt 0 9 0 1 0 .1 0 0 0 -.2 0",
    "void brightfunc x 2 .3 . 0 0\nvoid mixtext a 5 void x s.fnt . II 0 10 0 1 0 .1 0 0 0 -.2 0 .1\na glass m 0 0 3 .9 .9 .9",
    "void plasfunc m 2 f f.cal 0 4 .5 .5 .5 .2",
    "void metdata m 7 half d.dat f.cal f f -rz 3 0 4 .5 .5 .5 .2",
    "void transfunc m 3 f f.cal -mx 0 7 .5 .5 .5 .2 .3 .4 9",
    "void BRTDfunc m 10 .1 .2 .3 0 0 0 f f 0 f.cal 0 9 .1 .1 .1 .2 .2 .2 .3 .3 .3",
    "void plastic2 m 6 Px 1 0 f.cal -rz 20 0 6 .5 .5 .5 .1 .1 .2",
];

#[test]
fn every_kind_is_read_and_written_back() {
    let folder = folder();
    for text in ALL {
        for unit in [Unit::Meter, Unit::Inch] {
            let device = read_in(&format!("{text}{RING}"), folder.path(), unit)
                .unwrap_or_else(|e| panic!("{text}: {e}"));
            assert!(!device.materials[0].material.is_constant(), "{text}");
            let again = read_in(&device.to_rad(), Path::new("."), Unit::Meter);
            let again = again.unwrap_or_else(|e| panic!("{e}\n{}", device.to_rad()));
            if unit == Unit::Meter && !text.contains("-r") {
                assert_eq!(again, device, "{}", device.to_rad());
            }
            // Written once more it is the same text, up to rounding of transformations.
            let thrice = read_in(&again.to_rad(), Path::new("."), Unit::Meter).unwrap();
            assert_eq!(thrice.surfaces, again.surfaces);
            assert_eq!(format!("{:?}", thrice.materials[0].name), format!("{:?}", again.materials[0].name));
        }
    }
}

/// The first modifier of the first material.
fn modifier(device: &Device) -> &Modifier {
    match &device.materials[0].material {
        Material::Modified { modifiers, .. } => &modifiers[0],
        other => panic!("{other:?}"),
    }
}

fn state(position: DVec3) -> RayState {
    RayState {
        direction: DVec3::NEG_Z,
        normal: DVec3::Z,
        position,
        distance: 1.0,
        traveled: 1.0,
        uv: [0.0; 2],
        perturbed_normal: DVec3::Z,
        perturbed_cosine: 1.0,
        color: DVec3::ONE,
    }
}

#[test]
fn turning_a_device_up_turns_its_functions() {
    let text = "void colorfunc a 3 2+Px 2+Py 2+Pz . 0 0\na plastic m 0 0 5 .5 .5 .5 0 0";
    let text = text.replace("a 3", "a 4");
    let device = read_in(&format!("{text}{RING}"), Path::new("."), Unit::Meter).unwrap();
    for up in [Up::X, Up::MinusX, Up::MinusY, Up::Z, Up::MinusZ] {
        let turned = device.turned_up(up);
        let p = DVec3::new(0.1, 0.2, 0.3);
        // A surface tells where a point has gone: its centre moves as the functions do.
        let moved = |p: DVec3| {
            let ring =
                format!("void plastic m 0 0 5 .5 .5 .5 0 0 m sphere s 0 0 4 {} {} {} .1", p.x, p.y, p.z);
            let device = read_in(&ring, Path::new("."), Unit::Meter).unwrap().turned_up(up);
            let [low, high] = device.bounds().unwrap();
            (low + high) / 2.0
        };
        let Modifier::Color(field) = modifier(&turned) else { panic!("a colour") };
        let found = DVec3::from_array(field.at(&state(moved(p))).unwrap());
        assert!(found.distance(p + 2.0) < 1e-12, "{up:?}: {found}");
    }
}

#[test]
fn files_are_found_beside_the_naming_file() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    std::fs::write(folder.path().join("sub/g.cal"), "g = .25;").unwrap();
    std::fs::write(folder.path().join("sub/in.rad"), "void brightfunc a 2 g g.cal 0 0\n").unwrap();
    let text = format!("!xform sub/in.rad\na plastic m 0 0 5 .5 .5 .5 0 0{RING}");
    let device = read_in(&text, folder.path(), Unit::Meter).unwrap();
    let Modifier::Brightness(field) = modifier(&device) else { panic!("a brightness") };
    assert_eq!(field.at(&state(DVec3::ZERO)).unwrap(), [0.25]);
    let missing = read_in(
        &text.replace("sub/in.rad", "dark.rad").replace("a plastic", "dark plastic"),
        folder.path(),
        Unit::Meter,
    );
    assert!(missing.is_ok());
}

#[test]
fn copies_of_a_modifier_in_other_places_are_others_and_in_the_same_place_are_one() {
    let folder = folder();
    let inner = format!("void brightfunc a 2 checks f.cal 0 1 .5\na plastic m 0 0 5 .5 .5 .5 0 0{RING}\n");
    std::fs::write(folder.path().join("in.rad"), inner).unwrap();
    let device = |command: &str| read_in(command, folder.path(), Unit::Meter).unwrap().materials.len();
    assert_eq!(device("!xform -a 5 -t 1 0 0 in.rad"), 5);
    assert_eq!(device("!cat in.rad in.rad in.rad"), 1);
}

#[test]
fn what_is_wrong_is_said_with_its_line_where_it_is_used() {
    let folder = folder();
    for (definition, part) in [
        ("brightfunc a 2 f nowhere.cal 0 0", "cannot read 'nowhere.cal': no such file, looked for in"),
        ("brightfunc a 2 f wrong.cal 0 0", "wrong.cal:2: expected"),
        ("brightfunc a 2 'Px +' . 0 0", "expected"),
        ("brightfunc a 4 Px . -rz x 0 0", "a number as argument 1 of -rz in brightfunc \"a\", found 'x'"),
        ("brightdata a 4 noop d.dat . Px 0 0", "coordinates after the function file"),
        ("brightdata a 4 noop wrong.dat . Px 0 0", "wrong.dat:3: expected value 2 of 2, a number, found 'x'"),
        ("brightdata a 5 missing d.dat . Px Py 0 0", "function 'missing' is not defined"),
        (
            "colordata a 9 red green blue d.dat s.dat d.dat . Px Py 0 0",
            "data files of the same number of dimensions",
        ),
        ("colorpict a 7 red green blue f.cal . Px Py 0 0", "it is no Radiance picture"),
        ("specfile a 1 d.dat 0 0", "a data file of one dimension"),
        ("specfunc a 2 ramp f.cal 0 2 500 500", "different wavelengths"),
        ("specfunc a 2 missing f.cal 0 2 400 500", "function 'missing"),
        ("spectrum a 0 0 5 500 500 1 1 1", "different wavelengths"),
        ("brighttext a 2 none.fnt s.dat 0 11 0 0 0 1 0 0 0 -1 0 1 0", "cannot read 'none.fnt'"),
        ("brighttext a 2 wrong.dat s.dat 0 11 0 0 0 1 0 0 0 -1 0 1 0", "wrong.dat:2: expected a code once"),
        ("brighttext a 2 s.fnt none.txt 0 11 0 0 0 1 0 0 0 -1 0 1 0", "cannot read 'none.txt'"),
        (
            "colortext a 3 s.fnt . I 0 15 0 0 0 1 0 0 2 0 0 1 0 0 1 0 0",
            "vectors to the right and down that span",
        ),
        ("specdata a 4 plus s.dat f.cal Px 0 0", "expected a data file of two or more dimensions"),
        ("specdata a 4 missing d.dat f.cal Px 0 0", "function 'missing"),
        ("specpict a 5 plus s.dat f.cal Px Py 0 0", "it is no Radiance picture"),
    ] {
        let library = format!(
            "void plastic white 0 0 5 .5 .5 .5 0 0\nvoid {definition}\na plastic m 0 0 5 .5 .5 .5 0 0"
        );
        read_in(&library, folder.path(), Unit::Meter).unwrap_or_else(|e| panic!("{e}"));
        let message =
            read_in(&format!("{library}{RING}"), folder.path(), Unit::Meter).unwrap_err().to_string();
        assert!(message.starts_with("scene.rad:2: ") && message.contains(part), "{definition}: {message}");
        assert!(message.contains("'r' uses it at scene.rad:4"), "{message}");
    }
    for (definition, part) in [
        ("void plasfunc m 2 missing f.cal 0 4 .5 .5 .5 .2", "function 'missing"),
        ("void plasfunc m 2 f f.cal 0 4 .5 .5 1.5 .2", "colour between 0 and 1 in plasfunc \"m\", found 1.5"),
        ("void BRTDfunc m 10 1 1 1 1 1 1 0 missing 0 . 0 9 0 0 0 0 0 0 0 0 0", "function 'missing"),
        ("void plastic2 m 4 Px 0 0 nowhere.cal 0 6 .5 .5 .5 .1 .1 .1", "cannot read 'nowhere.cal'"),
    ] {
        let message =
            read_in(&format!("\n{definition}{RING}"), folder.path(), Unit::Meter).unwrap_err().to_string();
        assert!(message.starts_with("scene.rad:2: ") && message.contains(part), "{definition}: {message}");
    }
}

#[test]
fn wrong_counts_are_errors_at_once() {
    for (definition, part) in [
        (
            "brightfunc a 1 f 0 0",
            "string arguments formula funcfile [transform] of brightfunc \"a\", found 1",
        ),
        ("colorfunc a 3 f f f 0 0", "string arguments formula formula formula funcfile"),
        ("brightdata a 3 f d.dat . 0 0", "string arguments func datafile funcfile x0"),
        ("texdata a 7 f f f d d d . 0 0", "datafile datafile datafile funcfile x0"),
        ("colorpict a 6 f f f p . u 0 0", "picture funcfile u v"),
        ("mixfunc a 3 void void f 0 0", "foreground background formula funcfile"),
        ("mixpict a 6 void void f p . u 0 0", "foreground background func picture funcfile u v"),
        ("spectrum a 0 0 4 400 500 1 1", "at least 5 real arguments"),
        ("specfile a 0 0 0", "1 string argument"),
        ("specfunc a 2 f f.cal 0 1 400", "at least 2 real arguments"),
        ("specdata a 3 f d.dat . 0 0", "string arguments func datafile funcfile x0"),
        ("specpict a 4 f p.spc . u 0 0", "string arguments func specfile funcfile u v"),
        (
            "brighttext a 2 s.fnt t 0 9 0 0 0 1 0 0 0 -1 0",
            "Dx Dy Dz foreground background [spacing] of brighttext \"a\", found 2 and 9",
        ),
        (
            "colortext a 1 s.fnt 0 15 0 0 0 1 0 0 0 -1 0 1 1 1 0 0 0",
            "fontfile textfile, or fontfile . word …",
        ),
        ("mixtext a 3 void void s.fnt 0 9 0 0 0 1 0 0 0 -1 0", "foreground background fontfile textfile"),
        ("plasfunc a 1 f 0 4 .5 .5 .5 .2", "refl funcfile"),
        ("transfunc a 2 f f.cal 0 4 .5 .5 .5 .2", "6 or more real arguments"),
        ("BRTDfunc a 9 0 0 0 0 0 0 0 0 . 0 9 0 0 0 0 0 0 0 0 0", "rrefl grefl brefl"),
        ("mixfunc a 4 nobody void f . 0 0", "side of a mixture 'nobody' is not defined"),
    ] {
        let message =
            read_in(&format!("\nvoid {definition}"), Path::new("."), Unit::Meter).unwrap_err().to_string();
        assert!(message.starts_with("scene.rad:2: ") && message.contains(part), "{definition}: {message}");
    }
}

#[test]
fn materials_stand_where_they_belong() {
    let head = "void plastic white 0 0 5 .8 .8 .8 0 0\nvoid brightfunc half 2 .5 . 0 0\n";
    for (text, part) in [
        ("white plastic m 0 0 5 .5 .5 .5 0 0", "the material 'white'"),
        (
            "half mixfunc m 4 white void .5 . 0 0",
            "expected 'void' as the modifier of a mixture of materials, \"m\", found the modifier 'half'",
        ),
        ("white mixfunc m 4 white void .5 . 0 0", "found the material 'white'"),
    ] {
        let message =
            read_in(&format!("{head}{text}{RING}"), Path::new("."), Unit::Meter).unwrap_err().to_string();
        assert!(message.starts_with("scene.rad:3: ") && message.contains(part), "{message}");
    }
    // A chain without a material is not there.
    let device = read_in(&format!("{head}half alias m half{RING}"), Path::new("."), Unit::Meter).unwrap();
    assert_eq!(device.materials[0].material, Material::Void);
}

#[test]
fn mixtures_of_mixtures_are_bounded() {
    let mut text = "void plastic m0 0 0 5 .8 .8 .8 0 0\n".to_owned();
    for k in 1..=60 {
        text += &format!("void mixfunc m{k} 4 m{} m{} .5 . 0 0\n", k - 1, k - 1);
    }
    let message = read_in(&format!("{text}void alias m m60{RING}"), Path::new("."), Unit::Meter)
        .unwrap_err()
        .to_string();
    assert!(message.contains("at most 4096 modifiers in all of"), "{message}");
    let fine = format!("{text}void alias m m8{RING}");
    assert!(read_in(&fine, Path::new("."), Unit::Meter).is_ok());
}

#[test]
fn words_that_nothing_asks_for_are_told() {
    let text = format!("void brightfunc a 4 .5 . extra words 0 0\na plastic m 0 0 5 .5 .5 .5 0 0{RING}");
    let warnings = read_in(&text, Path::new("."), Unit::Meter).unwrap().warnings;
    assert_eq!(
        warnings,
        ["scene.rad:1: brightfunc \"a\": string arguments that nothing asks for are left out: 'extra words'"]
    );
}

#[test]
fn what_would_stop_a_ray_is_told_at_once() {
    let folder = folder();
    std::fs::write(folder.path().join("late.cal"), "a = if(Px, b, 1);\nf(x) = x + missing(x) + a;\n")
        .unwrap();
    let read = |definition: &str| {
        let text = format!("void {definition}\na plastic m 0 0 5 .5 .5 .5 0 0{RING}");
        read_in(&text, folder.path(), Unit::Meter).unwrap().warnings
    };
    let [warning] = &read("brightfunc a 2 a+a late.cal 0 0")[..] else { panic!() };
    for part in [
        "scene.rad:1: brightfunc \"a\": generation will fail if a ray needs this: ",
        "late.cal:1: ",
        "'b`late' is not defined",
    ] {
        assert!(warning.contains(part), "{warning}");
    }
    let warnings = read("brightdata a 5 f d.dat late.cal Px Py 0 0");
    assert!(warnings.len() == 2 && warnings[0].contains("'missing"), "{warnings:?}");
    assert_eq!(read("brightfunc a 2 'if(1, Px, .5)' . 0 0"), [""; 0]);
}

#[test]
fn formulas_are_told_apart_by_their_files() {
    let folder = folder();
    let field = |text: &str| {
        let device =
            read_in(&format!("{text}\na plastic m 0 0 5 .5 .5 .5 0 0{RING}"), folder.path(), Unit::Meter)
                .unwrap();
        match modifier(&device) {
            Modifier::Brightness(field) => field.clone(),
            other => panic!("{other:?}"),
        }
    };
    let first = field("void brightfunc a 2 checks f.cal 0 1 .8");
    assert!(matches!(first.source, Source::Formulas(_)));
    assert_eq!(first, field("\n\nvoid brightfunc b 2 1 . 0 0 void brightfunc a 2 checks f.cal 0 1 .8"));
    assert_ne!(first, field("void brightfunc a 2 checks f.cal 0 1 .9"));
    assert_ne!(first, field("void brightfunc a 4 checks f.cal -rz 1 0 1 .8"));
    std::fs::write(folder.path().join("f.cal"), "checks = if(Px, A1, .3);").unwrap();
    assert_ne!(first, field("void brightfunc a 2 checks f.cal 0 1 .8"));
}
