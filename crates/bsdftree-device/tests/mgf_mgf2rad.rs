//! The same MGF, read here and translated by Radiance's mgf2rad: the same surfaces of the same materials.

mod mgf_support;

use std::path::PathBuf;

use bsdftree::color::xyz_from_rgb;
use bsdftree_device::material::transmissivity_from_transmittance;
use bsdftree_device::{Device, Unit};
use mgf_support::{Made, Primitive, made, made_of, near, radiance, run, translated};

fn read(text: &str) -> Device {
    Device::parse_mgf(text, "text.mgf", ".".as_ref(), Unit::Meter).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Asserts that two materials are the same up to the six digits that mgf2rad prints, and to what this reader does better.
fn assert_material(ours: &Made, theirs: &Made, text: &str) {
    let (a, b) = (ours.material.as_ref().unwrap(), theirs.material.as_ref().unwrap());
    let explain = || format!("{a:?}\n{b:?}\n{text}");
    assert_eq!(a.name, b.name, "{}", explain());
    match (&*a.kind, &*b.kind) {
        ("glow", "light") => {}
        // `ts 1 0` is not there; mgf2rad makes it a trans that passes all light.
        ("illum", "trans") => assert_eq!(b.reals, [1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0], "{}", explain()),
        // What neither reflects nor transmits.
        ("glow", "plastic") => assert!(b.reals[..4] == [0.0; 4], "{}", explain()),
        ("glass", "glass") => {
            assert!((a.reals[3] - b.reals[3]).abs() < 1e-6, "{}", explain());
            // mgf2rad adds what is reflected.
            for k in 0..3 {
                assert!((a.reals[k] - b.reals[k].min(1.0)).abs() < 0.07, "{}", explain());
            }
        }
        // mgf2rad takes specular parts of less than 5 % saturation for grey.
        ("WGMDfunc", "WGMDfunc") => {
            assert_eq!((a.reals.len(), b.reals.len()), (19, 19), "{}", explain());
            for (k, (x, y)) in a.reals.iter().zip(&b.reals).enumerate() {
                let tolerance = if [9, 10, 11, 14, 15, 16].contains(&k) { 0.05 * y } else { 0.0 };
                assert!((x - y).abs() <= tolerance + 3e-6, "{k}: {}", explain());
            }
        }
        // mgf2rad prints powers of 200.
        ("dielectric", "dielectric") => assert!((a.reals[3] - b.reals[3]).abs() < 1e-6, "{}", explain()),
        _ => {
            assert_eq!(a.kind, b.kind, "{}", explain());
            // mgf2rad lets colours reflect more of a primary than there is; here they become paler.
            if b.reals[..3].iter().any(|&x| x > 1.0) {
                let luminance = |p: &Primitive| xyz_from_rgb([p.reals[0], p.reals[1], p.reals[2]])[1];
                assert!((luminance(a) - luminance(b)).abs() < 3e-6, "{}", explain());
                assert!(near(&a.reals[3..], &b.reals[3..], 3e-6), "{}", explain());
            } else {
                assert!(near(&a.reals, &b.reals, 3e-6), "{}", explain());
            }
        }
    }
}

/// Asserts that all is the same.
fn assert_agrees(mgf2rad: &PathBuf, text: &str) -> usize {
    let device = read(text);
    let scene = translated(mgf2rad, text).unwrap_or_else(|e| panic!("mgf2rad: {e}\n{text}"));
    let (ours, theirs) = (made_of(&device), made(&scene));
    assert_eq!(ours.len(), theirs.len(), "{}\n{scene}\n{text}", device.to_rad());
    for (a, b) in ours.iter().zip(&theirs) {
        let explain = || format!("{:?}\n{:?}\n{text}", a.surface, b.surface);
        assert_eq!(a.surface.kind, b.surface.kind, "{}", explain());
        // Triangles turned over may begin with another corner.
        let turns = if a.texture.is_some() { 3 } else { 1 };
        let turned = |k: usize| [&b.surface.reals[3 * k..], &b.surface.reals[..3 * k]].concat();
        assert!((0..turns).any(|k| near(&a.surface.reals, &turned(k), 1e-9)), "{}", explain());
        assert_eq!(a.texture.is_some(), b.texture.is_some(), "{}", explain());
        match (&a.texture, &b.texture) {
            (Some(a), Some(b)) => assert_same_normals(a, b, &ours[0].surface.reals),
            // mgf2rad keeps the last four of its objects' names.
            _ => assert!(a.surface.name.ends_with(&b.surface.name), "{}", explain()),
        }
        assert_material(a, b, text);
    }
    ours.len()
}

/// Asserts that two textures give the same normals near a triangle: those that `tmesh.cal` makes of their numbers.
fn assert_same_normals(a: &Primitive, b: &Primitive, near_to: &[f64]) {
    assert_eq!(a.strings[..3], b.strings[..3]);
    let normal = |texture: &Primitive, p: [f64; 3]| {
        let axis = texture.reals[0] as usize;
        let (u, v) = (p[(axis + 1) % 3], p[(axis + 2) % 3]);
        [0, 1, 2]
            .map(|k| texture.reals[1 + 3 * k] * u + texture.reals[2 + 3 * k] * v + texture.reals[3 + 3 * k])
    };
    if a.reals[0] == b.reals[0] {
        let p = [near_to[0], near_to[1], near_to[2]];
        // Single precision here, some six digits there.
        assert!(near(&normal(a, p), &normal(b, p), 1e-4), "{a:?}\n{b:?}");
    }
}

const WHITE: &str = "m white =\n\trd .6\n\tc\n\trs .04 .05\n";
const SQUARE: &str = "v a =\n\tp 0 0 0\nv b =\n\tp 1 0 0\nv c =\n\tp 1 1 .5\nv d =\n\tp 0 1 .5\n";

#[test]
fn every_entity_agrees() {
    let Some(mgf2rad) = radiance("mgf2rad") else { return };
    let bodies = [
        "f a b c d",
        "f a b c",
        "o x\no y.z\nf a b c d\no\nsph a .5\no\nsph a -.5",
        "cyl a .25 b\ncyl a -.25 b",
        "cone a .25 b 0\ncone a 0 b .25\ncone a -.25 b -.5\ncone a 0 b -.5\ncone a .5 b .5",
        "v r =\n p 1 2 3\n n 1 1 0\nring r 0 1\nring r .5 1",
        "prism a b c d .5\nprism a b c d -.5\nprism d c b a 1e-3",
        "xf -t 1 2 3 -rx 30 -ry 40 -rz 50 -s 2\nf a b c d\nsph a .1\ncyl a .1 b\ncone a .1 b .2\nxf\nf a b c d",
        "xf -mx\nf a b c d\ncone a .1 b .2\nv r =\n p 1 2 3\n n 1 1 0\nring r .5 1\nprism a b c d 1\nxf",
        "xf -s -2\nf a b c d\nsph b 1\nxf",
        "xf -a 3 -t 1 0 0\nf a b c d\nxf\nf a b c d",
        "xf -a 2 -t 1 0 0 -a 3 -rz 20 -i 2 -t 0 0 1\no k\nf a b c d\no\nxf",
        "xf -t 1 1 1\nxf -a 2 -s .5\nxf -my\nxf -a 2 -rx 45\nf a b c d\nxf\nxf\nxf\nxf",
        "xf -i 3 -t 1 0 0 -rz 10\nf a b c d\nxf",
        "f a b \\\n c \\\n d",
        "fh a b c d",
        "v a\n n 0 -1 0\nf a b c d",
        "m\nrd .3\nf a b c d\nm\nf a b c d",
        "m other = white\nrd .1\nf a b c\nm white\nf a b c\nm other\nrd .2\nf a b c\nm white = other\nf a b c",
        "v b = a\np 2 0 0\nf a b c d",
        "v e = a\n p 5 5 5\nv a\n p -1 -1 0\nf a b c d e",
    ];
    for body in bodies {
        assert!(assert_agrees(&mgf2rad, &format!("{WHITE}{SQUARE}{body}\n")) > 0);
    }
}

#[test]
fn materials_agree() {
    let Some(mgf2rad) = radiance("mgf2rad") else { return };
    let materials = [
        "rd .5",
        "c\ncxy .4 .4\nrd .5",
        "c\ncxy .1 .8\nrd .3",
        "rd 1",
        "rs .05 0",
        "rs .5 .1",
        "rs 1 0",
        "rd .035\nrs .665 .002",
        "c\ncxy .4 .4\nrd .1\nrs .6 .1",
        "c\ncxy .4 .4\nrd .3\nc\nrs .09 .1",
        "c\ncxy .4 .4\nrd .04\nc\nrs .01 .1",
        "rd .2\nc\ncxy .4 .35\nrs .6 .1\nc\ncxy .4 .35\nrd .2",
        "rd .04\nc\ncxy .4 .35\nrs .6 .1",
        "td .4",
        "td .4\nrd .4",
        "rd .3\ntd .2\nts .1 .1\nrs .05 .1",
        "rd .3\nts .2 .1",
        "ts .5 .2",
        "c\ncxy .3 .4\nrd .2\ntd .3\nts .1 .1\nc\nrs .05 .1",
        "ts 1 0",
        "ed 100",
        "ed 100\nrd .5",
        "ed .05\nrd .5",
        "ir 1.52 0\nrs .08 0\nts .88 0",
        "ir 1.52 0\nrs .0800 0\nc\ncxy .30 .35\nts .6 0",
        "ir 1.52 0\nrs .04 0\nts .96 0\nsides 1",
        "ir 1.5 0\nrd .4",
        "ir 1.5 0\nrd .4\nsides 2",
        "rd .4\nsides 1",
        "rd .3\nrs .2 .05\nts .1 .15",
        "rd .3\nts .3 0\nrs .1 .05",
        "c\ncxy .4 .4\nrd .3\nc\ntd .3",
        "c\ncxy .4 .4\nrd .3\nc\ncxy .2 .3\ntd .3\nrs .05 .1\nsides 1",
        "c\ncxy .4 .4\nts .3 .1\nc\ncxy .3 .4\ntd .1\nc\nrs .05 .1\nrd .1",
        "c\ncxy .45 .4\nrs .3 .1\nc\ncxy .3 .4\nrd .1",
        "rd .3\ntd .2\nts .1 .1\nrs .05 .1\nsides 1",
        "c k =\ncxy .5 .4\nc l =\ncxy .2 .3\nc\ncmix .3 k .7 l\nrd .4",
        "c k =\ncxy .5 .4\nc l = k\nc m =\ncxy .2 .2\nc mix =\ncmix 1 k 2 l 3 m\nc\nc mix\nrd .4",
    ];
    for material in materials {
        let text = format!("m x =\n{material}\n{SQUARE}f a b c d\n");
        assert_eq!(assert_agrees(&mgf2rad, &text), 1);
    }
}

/// mgf2rad rounds spectra to four digits at 41 wavelengths, and adds a random last digit.
#[test]
fn spectra_agree_to_three_digits() {
    let Some(mgf2rad) = radiance("mgf2rad") else { return };
    for spectrum in [
        "cct 2856",
        "cct 6500",
        "cspec 380 780 .1 .9",
        "cspec 400 700 .07 .08 .09 .1 .13 .18 .22 .25 .3 .33",
        "cspec 500 600 0 1 0",
        "cspec 380 780 0 0 0 0 1 2 3 4 5 6 7 8 9 8 7 6 5 4 3 2 1 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0",
    ] {
        let text = format!("m x =\nc\n{spectrum}\nrd .3\n{SQUARE}f a b c d\n");
        let ours = made_of(&read(&text))[0].material.clone().unwrap().reals;
        let theirs = made(&translated(&mgf2rad, &text).unwrap())[0].material.clone().unwrap().reals;
        assert!(near(&ours, &theirs, 4e-3), "{spectrum}: {ours:?} {theirs:?}");
    }
}

/// One cone of mgf2rad's 20 has this reader's cones around it: area and volume of both are of the same torus, the
/// closed form in the limit.
#[test]
fn tori_agree_in_area_and_face_the_same_way() {
    let Some(mgf2rad) = radiance("mgf2rad") else { return };
    for (radii, kinds) in [("1 2", ["cone", "cup"]), ("-1 -2", ["cup", "cone"]), ("0 1", ["cone", "cup"])] {
        let text = format!("{WHITE}v t =\n p 1 2 3\n n 1 2 2\nxf -s 2 -rx 10\ntorus t {radii}\nxf\n");
        let area = |all: &[Made], kind: &str| -> f64 {
            let of_kind = all.iter().filter(|m| m.surface.kind == kind).map(|m| &m.surface.reals);
            of_kind
                .map(|r| {
                    let slant =
                        (0..3).map(|k| (r[k] - r[k + 3]).powi(2)).sum::<f64>().sqrt().hypot(r[6] - r[7]);
                    std::f64::consts::PI * (r[6] + r[7]) * slant
                })
                .sum()
        };
        let ours = made_of(&read(&text));
        let theirs = made(&translated(&mgf2rad, &text).unwrap());
        for kind in kinds {
            let (a, b) = (area(&ours, kind), area(&theirs, kind));
            assert!((a / b - 1.0).abs() < 0.015, "{radii} {kind}: {a} {b}");
        }
        let r: Vec<f64> = radii.split(' ').map(|r| 2.0 * r.parse::<f64>().unwrap().abs()).collect();
        let exact = std::f64::consts::PI.powi(2) * (r[1] + r[0]) * (r[1] - r[0]);
        let all = area(&ours, "cone") + area(&ours, "cup");
        assert!((all / exact - 1.0).abs() < 1e-4, "{radii}: {all} {exact}");
    }
}

#[test]
fn smooth_faces_have_the_same_normals() {
    let Some(mgf2rad) = radiance("mgf2rad") else { return };
    let vertices = "v a =\n p 0 0 0\n n -1 -1 2\nv b =\n p 1 0 .1\n n 1 -1 2\nv c =\n p 1 1 0\n n 1 1 2\nv d =\n p 0 1 .2\n n -1 1 2\n";
    for (body, n) in [
        ("f a b c", 1),
        ("f a b c d", 2),
        ("f c b a", 1),
        ("f d c b a", 2),
        ("xf -mz -t 1 2 3\nf a b c d\nxf", 2),
        ("xf -s 3 -rx 70 -ry 20\nf a b c\nf c b a\nxf", 2),
        ("prism a b c d 1", 10),
        ("f a b c d a", 1),
    ] {
        assert_eq!(assert_agrees(&mgf2rad, &format!("{WHITE}{vertices}{body}\n")), n, "{body}");
    }
}

#[test]
fn what_mgf2rad_refuses_is_refused() {
    let Some(mgf2rad) = radiance("mgf2rad") else { return };
    for body in [
        "f a b",
        "f a b x",
        "sph a",
        "sph a x",
        "sph x 1",
        "cyl a 1",
        "cone a 0 b 0",
        "cone a 1 b -1",
        "ring a 0 1",
        "v r =\nn 0 0 1\nring r 1 1",
        "v r =\nn 0 0 1\nring r -1 1",
        "v r =\nn 0 0 1\ntorus r 2 1",
        "v r =\nn 0 0 1\ntorus r -1 1",
        "prism a b c",
        "prism a b c 0",
        "prism a a a 1",
        "m x",
        "m x = y",
        "m x y",
        "c x",
        "v x",
        "v x = y z",
        "c\ncxy .5 .6",
        "c\ncxy 1",
        "c\ncct 900",
        "c\ncspec 400 700",
        "c\ncspec 700 400 1 1",
        "c\ncspec 400 700 0 0",
        "c\ncmix 1 x 2 y",
        "rd 1.5",
        "rd -1",
        "rd x",
        "rs .5",
        "rs .5 -1",
        "ts 2 0",
        "ir 0 0",
        "sides 3",
        "sides",
        "ed -1",
        "rd .9\ntd .9\nf a b c",
        "o\n",
        "xf\n",
        "xf -q 1\nf a b c",
        "xf -t 1 2\nf a b c",
        "p 1 2",
        "n 1 2 x",
        "i nowhere.mgf",
        "fh a b - a b c",
        "fh a b c - a b",
        "o 1x y",
    ] {
        let text = format!("{WHITE}{SQUARE}{body}\nf a b c d\n");
        let error = Device::parse_mgf(&text, "text.mgf", "/".as_ref(), Unit::Meter).err();
        assert!(run(&mgf2rad, &text).is_err(), "mgf2rad takes {body:?}");
        let message = error.unwrap_or_else(|| panic!("{body:?} is taken")).to_string();
        assert!(message.starts_with("text.mgf:"), "{message}");
    }
}

/// Numbers from a counter.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    fn real(&mut self, low: f64, high: f64) -> f64 {
        let t = (self.next() >> 11) as f64 / (1u64 << 53) as f64;
        ((low + (high - low) * t) * 1e4).round() / 1e4
    }

    fn one<'a>(&mut self, of: &[&'a str]) -> &'a str {
        of[self.below(of.len())]
    }
}

/// A text of some 40 entities that mgf2rad and this reader take.
fn random_text(random: &mut Random) -> String {
    let mut text = String::new();
    let names = ["a", "b", "c", "d"];
    let mut line = |s: String| text += &(s + "\n");
    for name in names {
        line(format!(
            "v {name} =\n p {} {} {}",
            random.real(-2.0, 2.0),
            random.real(-2.0, 2.0),
            random.real(-2.0, 2.0)
        ));
        line(format!(" n {} {} 1", random.real(-1.0, 1.0), random.real(-1.0, 1.0)));
        // Faces through these are flat.
        line(format!("v {name}0 = {name}\n n 0 0 0"));
        line(format!("c {name} =\n cxy {} {}", random.real(0.2, 0.45), random.real(0.2, 0.45)));
    }
    let (mut objects, mut transforms) = (0, Vec::new());
    for _ in 0..40 {
        match random.below(15) {
            0 => {
                line(format!("m {} =", random.one(&["x", "y", "z"])));
                line(format!("c {}\nrd {}", random.one(&names), random.real(0.06, 0.4)));
                line(format!("c\nrs {} {}", random.real(0.0, 0.09), random.real(0.0, 0.2)));
            }
            1 => {
                line(format!("m {} =\nc {}", random.one(&["x", "y", "z"]), random.one(&names)));
                line(format!(
                    "rd {}\nrs {} {}",
                    random.real(0.0, 0.3),
                    random.real(0.1, 0.6),
                    random.real(0.0, 0.2)
                ));
            }
            2 => {
                line(format!("m {} =\nc {}", random.one(&["x", "y", "z"]), random.one(&names)));
                let rough = random.real(0.0, 0.2);
                line(format!("rd {}\ntd {}", random.real(0.01, 0.3), random.real(0.02, 0.3)));
                line(format!(
                    "ts {} {rough}\nc\nrs {} {rough}",
                    random.real(0.02, 0.3),
                    random.real(0.0, 0.05)
                ));
            }
            14 => {
                line(format!("m {} =\nc a\nrd {}", random.one(&["x", "y", "z"]), random.real(0.06, 0.3)));
                line(format!(
                    "c b\ntd {}\nc c\nts {} {}",
                    random.real(0.02, 0.2),
                    random.real(0.02, 0.2),
                    random.real(0.0, 0.2)
                ));
                line(format!("c d\nrs {} {}", random.real(0.0, 0.2), random.real(0.0, 0.2)));
            }
            3 => {
                let weights = [random.real(0.1, 1.0), random.real(0.1, 1.0)];
                line(format!(
                    "c {} =\ncmix {} {} {} {}",
                    "e",
                    weights[0],
                    random.one(&names),
                    weights[1],
                    random.one(&names)
                ));
                line(format!("m w =\nrd {}", random.real(0.0, 0.5)));
            }
            4 => {
                objects += 1;
                line(format!("o {}", random.one(&["o1", "o2", "part"])));
            }
            5 if objects > 0 && transforms.last().is_none_or(|&at: &usize| at < objects) => {
                objects -= 1;
                line("o".to_owned());
            }
            6 if transforms.len() < 3 => {
                let mut words = Vec::new();
                for _ in 0..=random.below(4) {
                    let x = random.real(-2.0, 2.0);
                    words.push(match random.below(6) {
                        0 => format!("-t {x} {} .5", random.real(-2.0, 2.0)),
                        1 => format!("-r{} {}", random.one(&["x", "y", "z"]), random.real(-180.0, 180.0)),
                        2 => format!("-s {}", random.real(0.5, 2.0)),
                        3 => format!("-m{}", random.one(&["x", "y", "z"])),
                        4 => format!("-i {} -t {x} 0 0", random.below(4)),
                        _ => format!("-a {} -rx 20 -t 0 {x} 0", 1 + random.below(3)),
                    });
                }
                line(format!("xf {}", words.join(" ")));
                transforms.push(objects);
            }
            7 if transforms.last() == Some(&objects) => {
                transforms.pop();
                line("xf".to_owned());
            }
            8 => line(format!("f {}0 b0 {}0", random.one(&["a", "d"]), random.one(&["c"]))),
            9 => line(format!("sph {} {}", random.one(&names), random.real(-1.0, 1.0))),
            10 => line(format!("cyl a {} {}", random.real(-1.0, 1.0), random.one(&["b", "c", "d"]))),
            11 => line(format!("cone c {} d {}", random.real(0.01, 1.0), random.real(0.0, 1.0))),
            12 => line(format!(
                "ring {} {} {}",
                random.one(&names),
                random.real(0.0, 0.5),
                random.real(0.6, 1.0)
            )),
            _ => line(format!("prism a0 b0 c0 {}", random.real(0.1, 1.0))),
        }
    }
    for around in transforms.into_iter().rev() {
        for _ in around..objects {
            line("o".to_owned());
        }
        objects = around;
        line("xf".to_owned());
    }
    text
}

#[test]
fn random_texts_agree() {
    let Some(mgf2rad) = radiance("mgf2rad") else { return };
    let mut random = Random(1);
    let mut n = 0;
    for _ in 0..300 {
        n += assert_agrees(&mgf2rad, &random_text(&mut random));
    }
    assert!(n > 5000, "{n} surfaces");
}

/// A pane's transmittance is what `ts` says: closed form of the reference manual.
#[test]
fn panes_transmit_what_is_said() {
    for ts in [0.05, 0.2, 0.5963, 0.88] {
        let t = transmissivity_from_transmittance(ts, 1.52);
        let r: f64 = (0.52_f64 / 2.52).powi(2);
        let rs = r + (1.0 - r).powi(2) * r * t * t / (1.0 - r * r * t * t);
        let device = read(&format!("m x =\nir 1.52 0\nrs {rs} 0\nts {ts} 0\n{SQUARE}f a b c d"));
        let reals = &made_of(&device)[0].material.clone().unwrap().reals;
        let through = (1.0 - r).powi(2) * reals[0] / (1.0 - (r * reals[0]).powi(2));
        assert!((through - ts).abs() < 1e-12, "{ts}: {reals:?}");
    }
}
