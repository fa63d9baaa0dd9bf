//! The generators beside Radiance's own, live, statement by statement; and what they refuse.

use std::fs;
use std::path::Path;

use bsdftree_testing::radiance::{printed, programs};
use glam::DVec3;

use super::{Environment, run};
use crate::error::{DeviceError, Place};
use crate::rad::{Content, Primitive, Statement, parse_statements};

/// SplitMix64.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E3779B97F4A7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58476D1CE4E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D049BB133111EB);
        z ^ (z >> 31)
    }

    /// One of 0 … n − 1.
    fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    fn pick<'a>(&mut self, options: &[&'a str]) -> &'a str {
        options[self.below(options.len() as u64) as usize]
    }

    fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A number with few digits.
    fn number(&mut self, a: f64, b: f64) -> String {
        format!("{:.3}", self.between(a, b))
    }
}

fn words(text: &str) -> Vec<String> {
    text.split('|').map(|word| word.trim().to_owned()).filter(|word| !word.is_empty()).collect()
}

fn ours(command: &[String], folder: &Path, limit: u64) -> Result<Vec<Statement>, DeviceError> {
    let at = Place { file: "scene.rad".into(), line: 7 };
    let environment = Environment {
        at: &at,
        read: &|name| Ok(fs::read_to_string(folder.join(name)).unwrap()),
        is_file: &|name| folder.join(name).is_file(),
        limit,
        most_steps: 1_000_000,
    };
    run(command, &environment)
}

fn theirs(command: &[String], folder: &Path) -> Option<Vec<Statement>> {
    programs()?;
    let text = String::from_utf8(printed(&command[0], folder, &command[1..], b"")).unwrap();
    if text.contains("nan") {
        // Where it divides 0 by 0 there is nothing to compare.
        return None;
    }
    Some(parse_statements(&text, &"theirs".into()).unwrap_or_else(|e| panic!("{command:?}: {e}")))
}

fn primitives(statements: &[Statement]) -> Vec<&Primitive> {
    let primitive = |s| match s {
        &Statement { content: Content::Primitive(ref p), .. } => p,
        _ => panic!("only primitives"),
    };
    statements.iter().map(primitive).collect()
}

/// What a texture gives at a point.
fn textured(texture: &Primitive, p: DVec3) -> DVec3 {
    let r = &texture.reals;
    let axis = r[0] as usize;
    let (u, v) = (p[(axis + 1) % 3], p[(axis + 2) % 3]);
    match &*texture.strings[3] {
        "tmesh.cal" => DVec3::from_array([1, 4, 7].map(|k| r[k] * u + r[k + 1] * v + r[k + 2])).normalize(),
        _ => DVec3::from_array([1, 2, 3].map(|k| r[k] * u * v + r[k + 3] * u + r[k + 6] * v + r[k + 9])),
    }
}

fn corners(polygon: &Primitive) -> Vec<DVec3> {
    polygon.reals.chunks_exact(3).map(DVec3::from_slice).collect()
}

/// Whether both have here two smooth triangles that make the same rectangle, cut along one diagonal or the other.
fn is_same_rectangle(ours: &[&Primitive], theirs: &[&Primitive]) -> bool {
    let both = |all: &[&Primitive]| match all {
        [a, _, b, ..] if a.modifier == "Phong" && a.reals.len() == 9 => [corners(a), corners(b)].concat(),
        _ => Vec::new(),
    };
    let (ours, theirs) = (both(ours), both(theirs));
    let all_in = |a: &[DVec3], b: &[DVec3]| a.iter().all(|p| b.iter().any(|q| p.distance(*q) < 1e-10));
    ours.len() == 6 && theirs.len() == 6 && all_in(&ours, &theirs) && all_in(&theirs, &ours)
}

/// The first difference.
fn difference(ours: &[Statement], theirs: &[Statement], tolerance: f64) -> Option<String> {
    let (ours, theirs) = (primitives(ours), primitives(theirs));
    let mut rectangle_until = 0;
    for (k, (a, b)) in ours.iter().zip(&theirs).enumerate() {
        if (&a.modifier, &a.kind, &a.name, &a.strings) != (&b.modifier, &b.kind, &b.name, &b.strings) {
            return Some(format!(
                "{k}: {} {} {} is {} {} {}",
                a.modifier, a.kind, a.name, b.modifier, b.kind, b.name
            ));
        }
        if a.reals.len() != b.reals.len() {
            return Some(format!("{k} {}: {} reals are {}", a.name, a.reals.len(), b.reals.len()));
        }
        if a.kind == "texfunc" && a.strings[3] != "rev.cal" {
            for p in corners(ours[k + 1]) {
                let (x, y) = (textured(a, p), textured(b, p));
                if x.distance(y) > tolerance * 1e5 {
                    return Some(format!("{k}: {x} at {p} is {y}: {:?} {:?}", a.reals, b.reals));
                }
            }
            continue;
        }
        let size = b.reals.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
        if let Some((x, y)) = a.reals.iter().zip(&b.reals).find(|(x, y)| (**x - **y).abs() > tolerance * size)
        {
            if k <= rectangle_until || is_same_rectangle(&ours[k..], &theirs[k..]) {
                rectangle_until = rectangle_until.max(k + 2);
                continue;
            }
            return Some(format!("{k} {}: {x} is {y}: {:?} {:?}", a.name, a.reals, b.reals));
        }
    }
    (ours.len() != theirs.len()).then(|| format!("{} statements are {}", ours.len(), theirs.len()))
}

/// Compares commands, words separated by `|`. The tolerance allows for Radiance's 12 digits.
fn agree(folder: &Path, cases: impl IntoIterator<Item = String>) {
    if programs().is_none() {
        return;
    }
    let (mut n_cases, mut wrong) = (0, Vec::new());
    for case in cases {
        let command = words(&case);
        let ours = ours(&command, folder, 1_000_000).unwrap_or_else(|e| panic!("{case}: {e}"));
        let Some(theirs) = theirs(&command, folder) else { continue };
        n_cases += 1;
        if let Some(difference) = difference(&ours, &theirs, 1e-11) {
            wrong.push(format!("{case}\n    > {}", difference.chars().take(600).collect::<String>()));
        }
    }
    assert!(n_cases >= 2, "{n_cases}");
    assert!(wrong.is_empty(), "{} of {n_cases}:\n{}", wrong.len(), wrong[..wrong.len().min(8)].join("\n"));
}

fn empty_folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

#[test]
fn blinds_are_radiances() {
    let mut r = Random(1);
    agree(
        empty_folder().path(),
        (0..120).map(|k| {
            let depth = r.between(0.01, 0.1);
            let mut case = format!(
                "genblinds|m|n|{depth}|{}|{}|{}|{}",
                r.number(0.5, 2.0),
                r.number(0.5, 2.0),
                1 + r.below(9),
                r.number(-200.0, 200.0)
            );
            if k % 3 > 0 {
                case += &format!("|{}|{}", r.pick(&["-r", "+r"]), depth * r.between(0.501, 6.0));
            }
            case
        }),
    );
}

#[test]
fn boxes_are_radiances() {
    let mut r = Random(2);
    agree(
        empty_folder().path(),
        (0..120).map(|_| {
            let size: Vec<String> = (0..3).map(|_| r.number(0.5, 3.0)).collect();
            let cut = r.between(0.01, 0.24);
            let shape =
                r.pick(&["", "|-b|C", "|-r|C", "|-r|C|-n|3", "|-r|C|-n|5", "|-r|C|-n|9|-s", "|-r|C|-n|4|-s"]);
            let inward = r.pick(&["", "|-i"]);
            // What is inverted and rounded without -n has 8000 triangles: once is enough.
            let inward = if shape == "|-r|C" { "" } else { inward };
            format!("genbox|m|n|{}{}{inward}", size.join("|"), shape.replace('C', &cut.to_string()))
        }),
    );
    let folder = empty_folder();
    agree(folder.path(), ["genbox|m|b|1|2|3|-r|.1|-i", "genbox|m|b|2|2|2|-r|1|-n|4|-s"].map(String::from));
}

#[test]
fn prisms_are_radiances() {
    let mut r = Random(3);
    let folder = empty_folder();
    fs::write(folder.path().join("l.txt"), "0 0  0 2\n1 2 1 1 1.5 1 2 1 2 0\n").unwrap();
    agree(
        folder.path(),
        (0..160).map(|k| {
            let outline = match k % 4 {
                0 => "l.txt".to_owned(),
                1 => "7|0|0|2|0|2|1|1.5|1|1|1|1|2|0|2".to_owned(),
                _ => {
                    // Around the origin, either way.
                    let n = 3 + r.below(6);
                    let turn = if r.below(2) == 0 { -1.0 } else { 1.0 };
                    let corners = (0..n).map(|k| {
                        let (sin, cos) = (turn * std::f64::consts::TAU * k as f64 / n as f64
                            + r.between(0.0, 0.3))
                        .sin_cos();
                        let radius = r.between(0.8, 2.0);
                        format!("{:.4}|{:.4}", radius * cos, radius * sin)
                    });
                    format!("{n}|{}", corners.collect::<Vec<_>>().join("|"))
                }
            };
            let mut case = format!("genprism|m|n|{outline}");
            if r.below(2) == 0 {
                let z = r.pick(&["2", "-2", "1.25", "-.75"]);
                case += &format!("|-l|{}|{}|{z}", r.number(-0.5, 0.5), r.number(-0.5, 0.5));
            }
            if r.below(2) == 0 {
                case += &format!("|-r|{}", r.number(0.01, 0.1));
            }
            case += r.pick(&["", "", "|-c", "|-e", "|-c|-e"]);
            case
        }),
    );
}

#[test]
fn worms_are_radiances() {
    let mut r = Random(4);
    let folder = empty_folder();
    fs::write(folder.path().join("f.cal"), "bend(t) = sin(2*PI*t);\nthick = .3;\n").unwrap();
    agree(
        folder.path(),
        (0..100).map(|_| {
            let x = r.pick(&["t", "2*t", "cos(PI*t)", "bezier(0,1,3,1.5,t)", "hermite(0,1,2,-1,t)"]);
            let y = r.pick(&["3*t*t", "bend(t)", "bspline(0,1,3,2,t)", "0"]);
            let z = r.pick(&["t", "5*t", "-t", "sin(t)"]);
            let radius = r.pick(&["thick", ".1", ".1+.05*t", ".2-.1*t*t", "thick*(1+.2*bend(t))"]);
            let count = r.pick(&["1", "2", "7", "2.5", "3*4", "20"]);
            format!("genworm|m|n|{x}|{y}|{z}|{radius}|{count}|-f|f.cal|-e|other = 2; more(x) = x")
        }),
    );
}

#[test]
fn revolutions_are_radiances() {
    let mut r = Random(5);
    let folder = empty_folder();
    let steps = "Z(i) = select(i+1, 0, 1, 1, 4, 4.5, 4.5); R(i) = select(i+1, 1, 1.5, 2, 2.2, 2.2, 5);";
    fs::write(folder.path().join("s.cal"), steps).unwrap();
    agree(
        folder.path(),
        (0..120).map(|_| {
            let z = r.pick(&["t", "1-t", "sin(2*PI*t)", "Z(5*t)", "Z(5-5*t)", "0", "if(t-.5,t,0)", "t*t"]);
            let radius =
                r.pick(&["1", "1+t", "2-t*t", "2+cos(2*PI*t)", "R(5*t)", "R(5-5*t)", "t", "if(t-.5,2,1)"]);
            let smooth = r.pick(&["", "|-s"]);
            format!("genrev|m|n|{z}|{radius}|{}{smooth}|-f|s.cal", r.pick(&["1", "2", "5", "10", "13"]))
        }),
    );
}

#[test]
fn surfaces_are_radiances() {
    let mut r = Random(6);
    let folder = empty_folder();
    let mut write = |name: &str, n: usize| {
        let numbers: Vec<String> = (0..n).map(|_| r.number(-1.0, 1.0)).collect();
        fs::write(folder.path().join(name), numbers.join(" ")).unwrap();
    };
    write("z12", 12);
    write("p12", 36);
    write("z6", 6);
    let formulas = (0..160).map(|_| {
        let x = r.pick(&["s", "2*s", "s+.1*t", "s*t", "(2+cos(3*t))*cos(2*s)", "sin(1.5*s)*cos(1.5*t)"]);
        let y = r.pick(&["t", "t+s*s", "(2+cos(3*t))*sin(2*s)", "3*cos(t)"]);
        let z = r.pick(&["0", "s*t", "s*s+t*t", "sin(4*t)", "sin(3*s)*sin(2*t)", "sin(5*s)*cos(3*t)", "z6"]);
        let valid = r.pick(&["", "", "|-e|valid(s,t) = s+t-.4", "|-e|valid(s,t) = if(s-.5,s-.7,.3-s)"]);
        let counts = if z == "z6" {
            r.pick(&["1|2", "2|1", "2|3", "3|2"])
        } else {
            r.pick(&["1|1", "2|3", "5|4", "3|7"])
        };
        format!("gensurf|m|n|{x}|{y}|{z}|{counts}{valid}{}{}", r.pick(&["", "|-s"]), r.pick(&["", "|-i"]))
    });
    agree(folder.path(), formulas.collect::<Vec<_>>());
    let files = ["2|3", "3|2", "3|4", "4|3"].into_iter().flat_map(|counts| {
        let kinds = ["s|t|z12", "p12|p12|p12"];
        kinds.into_iter().flat_map(move |kind| {
            ["", "|-s", "|-i|-s"].map(|options| format!("gensurf|m|n|{kind}|{counts}{options}"))
        })
    });
    agree(folder.path(), files);
}

#[test]
fn too_much_is_refused_before_it_is_made() {
    let folder = empty_folder();
    for command in [
        "gensurf|m|n|s|t|s*t|1e5|1e4",
        "gensurf|m|n|s|t|s*t|1e300|1e300",
        "genworm|m|n|t|0|0|1|1e9",
        "genrev|m|n|t|1|1e18",
        "genblinds|m|n|1|1|1|1e12|0",
        "genbox|m|n|1|1|1|-r|.1|-n|1e6",
        "genbox|m|n|1|1|1|-r|.1|-n|1e19",
    ] {
        let error = ours(&words(command), folder.path(), 1_000_000).err().expect(command);
        assert!(matches!(error, DeviceError::TooLarge { .. }), "{command}: {error}");
    }
    let long = "gensurf|m|n|s|t|f(1000)|300|300|-e|f(n) = if(n-.5, f(n-1)+1, 0);";
    let error = ours(&words(long), folder.path(), 1_000_000).err().expect("long").to_string();
    assert!(error.contains("more than 1000000 operations in the formulas"), "{error}");
}

#[test]
fn wrong_words_are_named_with_how_it_is_called() {
    let folder = empty_folder();
    fs::write(folder.path().join("bad"), "0 0 1 0 x 1").unwrap();
    for (command, what) in [
        ("genbox|m|n|1|2", "expected a size above 0 for genbox, found the end"),
        ("genbox|m|n|1|2|x", "found 'x': usage: genbox mat name xsize"),
        ("genbox|m|n|1|2|3|-q", "found '-q'"),
        ("genbox|m|n|1|2|3|-o", "OBJ output of genbox is not supported"),
        ("genbox|m|n|1|2|3|-r|.6", "up to half the smallest size"),
        ("genblinds|m|n|1|2|3|4|5|-r|.4", "at least half the depth"),
        ("genprism|m|n|bad", "found 'x'"),
        ("genprism|m|n|2|0|0|1|0", "at least three corners"),
        ("genprism|m|n|3|0|0|1|0|1|1|-l|1|0|0", "not 0"),
        ("genprism|m|n|4|0|0|1|0|1|0|1|1|-r|.1", "no length"),
        ("genworm|m|n|t|0|0|1|0", "at least 1"),
        ("genworm|m|n|t|0|0|undefined|3", "'undefined' is not defined"),
        ("genworm|m|n|t|0|0|1+|3", "scene.rad:7"),
        ("gensurf|m|n|s|t|-|3|3", "commands have no input"),
        ("genrev|m|n|t", "expected r(t) for genrev"),
    ] {
        let error = ours(&words(command), folder.path(), 1000).err().expect(command).to_string();
        assert!(error.starts_with("scene.rad:7") && error.contains(what), "{command}: {error}");
    }
}
