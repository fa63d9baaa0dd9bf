//! Files that name files: where they are found, how they are transformed, and what is too much.

use std::fs;
use std::path::PathBuf;

use glam::{DVec3, dvec3};

use crate::options::Limits;
use crate::{Device, DeviceError, Material, ReadOptions, Shape};

/// A directory of its own, removed at the end.
struct Directory(PathBuf);

impl Directory {
    fn new(name: &str, files: &[(&str, &str)]) -> Self {
        let path = std::env::temp_dir().join(format!("bsdftree-{}-{name}", std::process::id()));
        for (file, text) in files {
            let file = path.join(file);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, text).unwrap();
        }
        Directory(path)
    }

    fn parse(&self, text: &str) -> Result<Device, DeviceError> {
        self.parse_within(text, Limits::DEFAULT)
    }

    fn parse_within(&self, text: &str, limits: Limits) -> Result<Device, DeviceError> {
        let search = Some(vec![self.0.join("library")]);
        Device::parse_rad(text, "top.rad", &self.0, ReadOptions { search, limits, ..ReadOptions::default() })
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

const WHITE: &str = "void plastic white 0 0 5 .8 .8 .8 0 0\n";
const BALL: &str = "white sphere s 0 0 4 0 0 0 1\n";

fn centers(device: &Device) -> Vec<(String, DVec3)> {
    let center = |shape: &Shape| match shape {
        Shape::Sphere { center, .. } => *center,
        _ => panic!("only spheres here"),
    };
    device.surfaces.iter().map(|s| (s.name.clone(), center(&s.shape))).collect()
}

/// Figures printed by Radiance's xform (2025) for this pair of nested commands; 12 digits.
#[test]
fn nested_arrays_agree_with_radiance() {
    let inner = "void plastic p 0 0 5 .5 .5 .5 0 0\np polygon a 0 0 9 0 0 0 1 0 0 1 2 .5\n\
                 p sphere s 0 0 4 1 2 3 .5\np ring g 0 0 8 .1 .2 .3 1 2 2 .1 .3\np cup k 0 0 8 0 0 0 0 1 1 .5 .2\n";
    let mid = "!xform -n in -I -rz 40 -mx inner.rad\n";
    let dir = Directory::new("nested", &[("inner.rad", inner), ("mid.rad", mid)]);
    let command = "!xform -n out -m q -s 1.5 -ry 25 -a 2 -t 1 2 3 -a 2 -rx -50 -i 2 -my -t 0 0 .25 mid.rad";
    let device = dir.parse(&format!("void metal q 0 0 5 .1 .2 .3 0 0\n{command}")).unwrap();
    let names: Vec<&str> = device.surfaces.iter().map(|s| &*s.name).collect();
    assert_eq!(names[..5], ["out.0.0.in.a", "out.0.0.in.s", "out.0.0.in.g", "out.0.0.in.k", "out.0.1.in.a"]);
    assert_eq!(names[15], "out.1.1.in.k");
    assert_eq!((device.materials.len(), &*device.materials[0].name), (1, "q"));

    let near = |a: DVec3, b: [f64; 3]| assert!(a.distance(b.into()) < 1e-10, "{a} is not {b:?}");
    let Shape::Polygon(v) = &device.surfaces[0].shape else { panic!("a polygon") };
    near(v[0], [0.0, 0.0, 0.5]);
    near(v[1], [-1.04140806602, 0.96418141453, 0.985616556451]);
    near(v[2], [1.02324587849, 3.26231474388, 0.850386049906]);
    let Shape::Sphere { center, radius, inward: true } = device.surfaces[5].shape else { panic!("a bubble") };
    near(center, [2.60806436002, 4.9689069478, 0.410758540493]);
    assert_eq!(radius, 0.75);
    let Shape::Ring { center, normal, radii } = device.surfaces[14].shape else { panic!("a ring") };
    near(center, [1.260806436, 4.08059924351, 0.887349796871]);
    // Radiance leaves the length of the direction scaled: 3 × 1.5.
    near(normal * 4.5, [-1.97413696741, -3.92749888177, 0.963086583611]);
    assert!((radii[0] - 0.15).abs() < 1e-15 && (radii[1] - 0.45).abs() < 1e-15);
    let Shape::Cone { ends, radii, inward: false } = device.surfaces[11].shape else { panic!("a cone") };
    near(ends[0], [1.0, 2.0, 3.5]);
    near(ends[1], [2.50777251672, 3.14906666468, 4.45198100714]);
    assert!((radii[0] - 0.75).abs() < 1e-15 && (radii[1] - 0.3).abs() < 1e-15);
}

#[test]
fn mirrored_polygons_keep_their_front() {
    let square = "white polygon p 0 0 12 0 0 0 1 0 0 1 1 0 0 1 0\n";
    let dir = Directory::new("mirror", &[("square.rad", &format!("{WHITE}{square}"))]);
    for (options, front) in [
        ("-mx", DVec3::Z),
        ("-mz", DVec3::NEG_Z),
        ("-s -1", DVec3::NEG_Z),
        ("-I", DVec3::NEG_Z),
        ("-I -my", DVec3::NEG_Z),
        ("-I -mz", DVec3::Z),
        ("-rx 90 -mz", dvec3(0.0, -1.0, 0.0)),
    ] {
        let device = dir.parse(&format!("!xform {options} square.rad")).unwrap();
        let Shape::Polygon(v) = &device.surfaces[0].shape else { panic!("a polygon") };
        assert_eq!((v[1] - v[0]).cross(v[2] - v[0]), front, "{options}");
    }
}

#[test]
fn transformations_reach_media_and_orientations() {
    let text = "void dielectric d 0 0 5 .25 1 1 1.5 0\nd sphere s 0 0 4 0 0 0 1\n\
                void metal2 m 4 1 0 0 . 0 6 .5 .5 .5 1 .1 .2\nm sphere s 0 0 4 0 0 0 1\n";
    let dir = Directory::new("media", &[("a.rad", text)]);
    let device = dir.parse("!xform -s 2 -rz 90 -ry 90 a.rad").unwrap();
    let Material::Dielectric { inside, .. } = &device.materials[0].material else { panic!("a dielectric") };
    assert_eq!(inside.transmittance.x, 0.5);
    let Material::Gloss(gloss) = &device.materials[1].material else { panic!("a gloss") };
    assert_eq!(gloss.orientation, Some(DVec3::Y));
}

#[test]
fn copies_of_a_material_are_one() {
    let dir = Directory::new("copies", &[("ball.rad", &format!("{WHITE}{BALL}"))]);
    let device = dir.parse("!xform -a 100 -t 1 0 0 ball.rad").unwrap();
    assert_eq!((device.surfaces.len(), device.materials.len()), (100, 1));
    assert_eq!(centers(&device)[99], ("a99.s".to_owned(), dvec3(99.0, 0.0, 0.0)));
}

#[test]
fn files_are_found_beside_the_naming_file_then_in_raypath() {
    let dir = Directory::new(
        "paths",
        &[
            (
                "sub/a.rad",
                &*format!("{WHITE}!xform -t 1 0 0 b.rad\n!xform -t 10 0 0 ./b.rad\n!xform -t 100 0 0 c.rad"),
            ),
            ("sub/b.rad", BALL),
            ("b.rad", "white sphere wrong 0 0 4 0 0 0 1"),
            ("library/c.rad", BALL),
        ],
    );
    let found: Vec<f64> = centers(&dir.parse("!xform sub/a.rad").unwrap()).iter().map(|c| c.1.x).collect();
    assert_eq!(found, [1.0, 10.0, 100.0]);
    let error = dir.parse(&format!("{WHITE}\n!xform ./c.rad")).unwrap_err().to_string();
    assert!(error.starts_with("top.rad:3: ") && error.contains("no such file"), "{error}");
    // -c leaves commands to run where the xform runs.
    assert_eq!(centers(&dir.parse("!xform -c sub/a.rad").unwrap())[0].0, "wrong");
}

#[test]
fn pipes_transform_what_the_first_program_makes() {
    let dir = Directory::new("pipes", &[("m.rad", WHITE), ("b.rad", BALL)]);
    let piped = "!xform -n in -t 1 0 0 m.rad b.rad | xform -n out -a 2 -rz 90 \\\n -i 1 -t 0 0 5";
    let device = dir.parse(piped).unwrap();
    let expected =
        [("out.0.in.s".to_owned(), dvec3(1.0, 0.0, 5.0)), ("out.1.in.s".to_owned(), dvec3(0.0, 1.0, 5.0))];
    assert_eq!(centers(&device), expected);
    assert_eq!(centers(&dir.parse("!cat m.rad b.rad | xform -t 1 2 3").unwrap())[0].1, dvec3(1.0, 2.0, 3.0));
}

/// Names and order as Radiance's xform (2025) prints them for these argument files.
#[test]
fn argument_files_make_one_copy_a_line() {
    let ball = format!("{WHITE}{BALL}");
    let dir = Directory::new(
        "arguments",
        &[
            ("b.rad", &*ball),
            ("two", "-t 1 0 0\n# comment\n\n!xform -rz 90 -a 2 -t 0 0 1\n"),
            ("nest", "-n k\n-f two\n"),
            ("loop", "-f loop\n-f loop\n"),
        ],
    );
    let names =
        |text: &str| -> Vec<String> { centers(&dir.parse(text).unwrap()).into_iter().map(|c| c.0).collect() };
    assert_eq!(names("!xform -f two b.rad"), ["i0.s", "i1.0.s", "i1.1.s"]);
    assert_eq!(
        names("!xform -a 2 -f two b.rad"),
        ["i0.0.s", "i0.1.s", "i1.0.0.s", "i1.0.1.s", "i1.1.0.s", "i1.1.1.s"]
    );
    assert_eq!(names("!xform -f nest -f two b.rad")[..4], ["k.0.0.s", "k.0.1.0.s", "k.0.1.1.s", "i1.0.0.s"]);
    let error = dir.parse("!xform -f loop b.rad").unwrap_err();
    assert!(matches!(error, DeviceError::TooLarge { .. }), "{error}");
}

#[test]
fn circles_of_files_are_named() {
    let dir = Directory::new(
        "circle",
        &[("a.rad", "\n!xform b.rad"), ("b.rad", "\n\n!xform ./../*"), ("c.rad", "")],
    );
    fs::write(dir.0.join("b.rad"), "\n\n!xform -rz 90 a.rad").unwrap();
    let error = dir.parse("!xform a.rad").unwrap_err();
    let DeviceError::Cycle { at, chain } = &error else { panic!("{error}") };
    assert_eq!((at.line, chain.len()), (3, 3));
    assert!(at.file.ends_with("b.rad") && chain[0].ends_with("a.rad") && chain[0] == chain[2], "{error}");
}

#[test]
fn deep_nesting_is_bounded() {
    let files: Vec<(String, String)> =
        (0..70).map(|k| (format!("{k}.rad"), format!("!xform {}.rad", k + 1))).collect();
    let files: Vec<(&str, &str)> = files.iter().map(|(a, b)| (&**a, &**b)).collect();
    let error = Directory::new("deep", &files).parse("!xform 0.rad").unwrap_err();
    assert!(error.to_string().contains("more than 64 files inside each other"), "{error}");
}

#[test]
fn copies_are_bounded() {
    let ball = format!("{WHITE}{BALL}");
    let dir = Directory::new(
        "bounded",
        &[("ball.rad", &*ball), ("empty.rad", ""), ("many.rad", "!xform -a 1e6 empty.rad")],
    );
    let limits = Limits { surfaces: 1000, bytes: 1 << 24, ..Limits::DEFAULT };
    for (text, what) in [
        ("!xform -a 1001 ball.rad", "more than 1000 surfaces"),
        ("!xform -a 1e6 -a 1e6 -a 1e6 ball.rad", "more than 1000 surfaces"),
        ("!xform -a 1e19 -a 1e19 empty.rad", "bytes after all copies"),
        ("!xform -a 1e9 empty.rad", "bytes after all copies"),
        ("!xform -a 1e3 many.rad", "bytes after all copies"),
    ] {
        let error = dir.parse_within(text, limits).unwrap_err();
        assert!(matches!(error, DeviceError::TooLarge { .. }), "{error}");
        assert!(error.to_string().contains(what), "{error}");
    }
    assert_eq!(dir.parse_within("!xform -a 1000 ball.rad", limits).unwrap().surfaces.len(), 1000);
}

#[test]
fn overflow_is_an_error() {
    let triangle = "white polygon p 0 0 9 0 0 0 1 0 0 0 1 0\n";
    let dir = Directory::new(
        "overflow",
        &[("ball.rad", &format!("{WHITE}{BALL}")), ("p.rad", &format!("{WHITE}{triangle}"))],
    );
    for command in
        ["-i 100000 -s 2 ball.rad", "-s 1e300 -s 1e300 ball.rad", "-s 1e300 -t 1e308 0 0 -t 1e308 0 0 p.rad"]
    {
        let error = dir.parse(&format!("\n!xform {command}")).unwrap_err().to_string();
        assert!(error.contains("an overflow in"), "{error}");
    }
}

#[test]
fn warnings_are_bounded() {
    let text = format!("{WHITE}{}", "white sphere s 0 0 4 0 0 0 0\n".repeat(500));
    let warnings = Directory::new("warnings", &[]).parse(&text).unwrap().warnings;
    assert_eq!((warnings.len(), &*warnings[100]), (101, "and 400 more warnings"));
}

#[test]
fn generators_make_surfaces_in_place() {
    let dir = Directory::new("generators", &[("white.rad", WHITE)]);
    let text = "!cat white.rad\n!genbox white b 1 2 3 | xform -n out -a 2 -t 10 0 0\n!echo white sphere e 0 0 4 1 2 3 .5";
    let device = dir.parse(text).unwrap();
    assert_eq!(device.surfaces.len(), 13);
    assert_eq!(device.surfaces[6].name, "out.1.b.1540");
    assert_eq!(
        device.bounds().unwrap(),
        [DVec3::ZERO, dvec3(11.0, 2.5, 3.5)].map(|p| p.min(dvec3(11.0, 2.5, 3.5)))
    );
    let error = dir.parse("\n\n!genbox white b 1 2").unwrap_err().to_string();
    assert!(error.starts_with("top.rad:3: expected a size above 0 for genbox"), "{error}");
    let error = dir.parse("!genbox white b 1 2 3").unwrap_err().to_string();
    assert!(error.starts_with("top.rad:1: ") && error.contains("'white' is not defined"), "{error}");
}

#[test]
fn marks_are_replaced_where_they_point() {
    let ball = format!("{WHITE}white sphere s 0 0 4 1 2 3 .25\n");
    let marks = "mark polygon a 0 0 9 1 2 3 4 2 3 1 3 3\nmark polygon \"b c\" 0 0 9 0 0 0 0 0 2 1 0 2\n\
                 white sphere keep 0 0 4 9 9 9 .25\n";
    let dir = Directory::new("marks", &[("ball.rad", &*ball), ("marks.rad", marks)]);
    let placed = |command: &str| centers(&dir.parse(&format!("{WHITE}{command}")).unwrap());
    let near = |found: &[(String, DVec3)], expected: &[(&str, DVec3)]| {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for ((name, center), (expected_name, expected)) in found.iter().zip(expected) {
            assert!(name == expected_name && center.distance(*expected) < 1e-12, "{name} {center}");
        }
    };
    // The second points down from (0, 0, 2), its y axis to +x.
    let keep = ("keep", DVec3::splat(9.0));
    let expected = [("a.s", dvec3(2.0, 4.0, 6.0)), ("b c.s", dvec3(2.0, -3.0, 1.0)), keep];
    near(&placed("!replmarks -x ball.rad mark marks.rad"), &expected);
    let scaled = [("a.s", dvec3(7.0, 14.0, 21.0)), ("b c.s", dvec3(8.0, -12.0, -2.0)), keep];
    near(&placed("!replmarks -s 2 -x ball.rad mark marks.rad"), &scaled);
    near(&placed("!cat marks.rad | replmarks -x ball.rad mark"), &expected);
    let moved = expected.map(|(name, center)| (name, center + DVec3::X));
    near(&placed("!replmarks -x ball.rad mark marks.rad | xform -t 1 0 0"), &moved);
    let error = dir.parse("!replmarks -x ball.rad mark").unwrap_err().to_string();
    assert!(error.contains("a file for replmarks to read"), "{error}");
    let error = dir.parse("!xform marks.rad | replmarks -x ball.rad mark").unwrap_err().to_string();
    assert!(error.contains("put xform after it"), "{error}");
    fs::write(dir.0.join("self.rad"), "!replmarks -x ball.rad mark self.rad").unwrap();
    let error = dir.parse("!xform self.rad").unwrap_err();
    assert!(matches!(error, DeviceError::Cycle { .. }), "{error}");
}

#[test]
fn programs_are_refused_by_name_and_place() {
    let dir = Directory::new("refused", &[]);
    for (command, what) in [
        ("\n!mkfs /dev/sda", "top.rad:2: command 'mkfs' is not supported: no program but xform"),
        ("!/bin/sh -c ls", "--allow-command /bin/sh"),
        ("!genbox m b 1 1 1 | tee x", "after '|' there can be xform"),
        ("!xform `ls`", "'`' in the command"),
        ("!genbox m b 1 1 1 ; rm x", "';' in the command"),
        ("!genbox m b 1 1 1 > x", "'>' in the command"),
        ("!echo $HOME", "'$' in the command"),
        ("! | xform", "expected a command after"),
    ] {
        let error = dir.parse(command).unwrap_err().to_string();
        assert!(error.contains(what), "{command}: {error}");
    }
}

#[cfg(unix)]
#[test]
fn allowed_programs_run_in_the_directory_of_the_scene() {
    let dir = Directory::new("allowed", &[("sub/scene.rad", "!head -n 9 ball.rad"), ("sub/ball.rad", BALL)]);
    let read = |text: &str| {
        let limits =
            Limits { command_time: std::time::Duration::from_secs(20), bytes: 1 << 20, ..Limits::DEFAULT };
        let allowed_commands = vec!["head".to_owned(), "sed".to_owned(), "yes".to_owned()];
        let options = ReadOptions { limits, allowed_commands, ..ReadOptions::default() };
        Device::parse_rad(&format!("{WHITE}{text}"), "top.rad", &dir.0, options)
    };
    assert_eq!(read("!xform sub/scene.rad").unwrap().surfaces.len(), 1);
    let piped = read("!head -n 1 sub/ball.rad | sed \"s/0 0 0 1/0 0 7 1/\" | xform -t 1 0 0").unwrap();
    assert_eq!(centers(&piped)[0].1, dvec3(1.0, 0.0, 7.0));
    for (command, what) in [
        ("!head missing", "top.rad:2: the command 'head missing' failed: exit status"),
        ("!yes", "more than 1048576 bytes"),
        ("!genbox white b 1 1 1 | sed p", "let that program read a file"),
        ("!sed -n 1p sub/scene.rad x", "the command 'sed -n 1p sub/scene.rad x' failed"),
        ("!head -c 6 sub/ball.rad", "output of 'head -c 6 sub/ball.rad':1: expected"),
    ] {
        let error = read(command).unwrap_err().to_string();
        assert!(error.contains(what), "{command}: {error}");
    }
    fs::write(dir.0.join("again.rad"), "!sed -n 1p again.rad").unwrap();
    let error = read("!sed -n 1p again.rad").unwrap_err();
    assert!(matches!(error, DeviceError::Cycle { .. }), "{error}");
}
