//! Patterns, textures and mixtures of modifiers beside `rtrace`, live: the same numbers at the same places.

#[path = "field/scenes.rs"]
mod scenes;

use bsdftree_device::Unit;
use bsdftree_device::field::RayState;
use bsdftree_device::material::{Material, Modifier};
use bsdftree_testing::radiance::programs;
use glam::DVec3;
use scenes::{Plane, Scene, rays};

/// What modifiers make of white and of the normal, as a tracer has to do it.
fn shade(modifiers: &[Modifier], ray: &RayState) -> (DVec3, DVec3) {
    let (mut color, mut perturbation) = (DVec3::ONE, DVec3::ZERO);
    for modifier in modifiers {
        match modifier {
            Modifier::Brightness(field) => color *= field.at(ray).unwrap()[0],
            Modifier::Color(field) => color *= DVec3::from_array(field.at(ray).unwrap()),
            Modifier::Spectrum(_) | Modifier::SpectralField(_) => {
                panic!("what RGB spectra are is a tracer's to say")
            }
            Modifier::Texture(field) => perturbation += field.vector(ray).unwrap(),
            Modifier::Mixture { amount, foreground, background } => {
                let amount = amount.at(ray).unwrap()[0].clamp(0.0, 1.0);
                let [(a, p), (b, q)] = [foreground, background].map(|side| shade(side, ray));
                color *= a * amount + b * (1.0 - amount);
                perturbation += p * amount + q * (1.0 - amount);
            }
        }
    }
    (color, perturbation)
}

fn modifiers(material: &Material) -> &[Modifier] {
    match material {
        Material::Modified { modifiers, .. } => modifiers,
        other => panic!("{other:?}"),
    }
}

/// The same ray in metres.
pub fn scaled(ray: &RayState, unit: Unit) -> RayState {
    let m = unit.meters();
    RayState { position: ray.position * m, distance: ray.distance * m, traveled: ray.traveled * m, ..*ray }
}

/// Compares the colour of `m`, which stands for a material with the modifier `x` of the text; what was found.
fn patterns_agree(name: &str, text: &str, files: &[(&str, &str)], unit: Unit, tolerance: f64) -> Vec<DVec3> {
    let scene = Scene::new(files);
    let mut all = Vec::new();
    for plane in [Plane::Up, Plane::Down] {
        let rays = rays(plane, 200);
        // The sign of the distance limit makes the glow shine without being a light source.
        let theirs = format!("{text}\nx glow m 0 0 4 1 1 1 -1\n{}", plane.polygon());
        let theirs = scene.rtrace(&theirs, &["-ab", "0", "-ov"], &rays);
        let ours = format!("{text}\nx plastic m 0 0 5 1 1 1 0 0\n{}", plane.polygon());
        let ours = scene.material(&ours, unit);
        for (ray, expected) in rays.iter().zip(theirs) {
            let (found, _) = shade(modifiers(&ours), &scaled(ray, unit));
            let limit = tolerance * expected.abs().max_element().max(0.1);
            assert!(
                (found - expected).abs().max_element() < limit,
                "{name} {plane:?} {ray:?}: {found} {expected}"
            );
            all.push(found);
        }
    }
    all
}

/// Values of a ray as a file asks for them; each differs from ray to ray.
const CHANNELS: &str = "all = 2 + .3*Dx - .2*Dy + .1*Dz + .05*Nx + .06*Ny + .07*Nz + .11*Px - .12*Py + .13*Pz
    + .02*T + .03*Ts + .2*Rdot + .01*S + .011*Tx + .012*Ty + .013*Tz
    + .021*Ix + .022*Iy + .023*Iz + .031*Jx + .032*Jy + .033*Jz + .041*Kx + .042*Ky + .043*Kz;
    checks(size) = if(.5 - mod(floor(Px/size) + floor(Py/size), 2), A1, A2);
    bump(p, f) = .2*sin(f*p + A1);";

#[test]
fn functions_see_what_they_see_in_radiance() {
    if programs().is_none() {
        return;
    }
    let files = [("f.cal", CHANNELS)];
    for transformation in [
        "",
        "-rz 30",
        "-t 1 2 3 -rx 50",
        "-s 2.5 -ry -20",
        "-mx -rz 10",
        "-s -1 -t 0 .5 0",
        "-my -s .3 -rx 180",
    ] {
        for unit in [Unit::Meter, Unit::Inch] {
            let n = 2 + transformation.split_whitespace().count();
            let text = format!("void brightfunc x {n} all f.cal {transformation} 0 0");
            patterns_agree(transformation, &text, &files, unit, 1e-5);
        }
    }
}

#[test]
fn xform_moves_functions_with_the_scene() {
    if programs().is_none() {
        return;
    }
    let inner = "void brightfunc y 4 all f.cal -rz 15 0 0\ny brightfunc x 2 checks(.3) f.cal 0 2 .4 .9\n";
    for command in
        ["-t .3 .2 .1", "-rx 33 -rz 12 -s 1.5", "-mz -ry 60", "-i 3 -rz 11 -t .1 0 0", "-n q -s .2 -t 0 0 .3"]
    {
        let middle = format!("!xform {command} inner.rad\n");
        for (text, files) in [
            (middle.clone(), vec![("f.cal", CHANNELS), ("inner.rad", inner)]),
            (
                "!xform -rx 20 -t 0 .1 0 middle.rad".to_owned(),
                vec![("f.cal", CHANNELS), ("inner.rad", inner), ("middle.rad", &middle)],
            ),
        ] {
            patterns_agree(command, &text, &files, Unit::Foot, 1e-5);
        }
    }
}

const RAMPS: &str = "2\n-1 1 3\n0 0 4 -2 -.5 .25 3\n.1 .2 .3 .4\n.5 .9 .7 .8\n.4 .3 .2 .1\n";
const CURVE: &str = "1 # a curve\n0 0 5 -3 -1 0 .5 2 .2 .9 .5 .7 .1\n";

#[test]
fn data_are_interpolated_and_extrapolated_as_in_radiance() {
    if programs().is_none() {
        return;
    }
    let files = [
        ("r.dat", RAMPS),
        ("c.dat", CURVE),
        ("f.cal", "half(v) = .5*v; sum(r,g,b) = r+.1*g+.01*b; u = Px*A1;"),
    ];
    for (name, text) in [
        ("brightdata", "void brightdata x 7 half r.dat f.cal u 'Py - .1' -rz 20 0 1 1.3"),
        ("one dimension", "void brightdata x 4 noop c.dat . 2*Px 0 0"),
        ("colordata", "void colordata x 8 half noop noneg c.dat c.dat c.dat . Px 0 0"),
        (
            "colordata, three arguments",
            "void colordata x 11 sum half noop r.dat r.dat r.dat f.cal u Py -rz -40 0 1 .8",
        ),
        ("words that nothing asks for", "void brightdata x 8 noop c.dat . 2*Px extra words -rx 60 0 0"),
    ] {
        // 'noop' and the like are standard names.
        let text =
            if text.contains("colordata x 8") { text.replace("half", "clip") } else { text.to_owned() };
        patterns_agree(name, &text, &files, Unit::Centimeter, 2e-5);
    }
}

/// A picture of 5 × 3 pixels in this order of lines.
fn picture(size: &str, aspect: &str, runs: bool) -> Vec<u8> {
    let mut bytes =
        format!("#?RADIANCE\nEXPOSURE=7\n{aspect}FORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes();
    let pixel =
        |k: u32| [(60 + 13 * k) as u8, (250 - 11 * k) as u8, (128 + k * 3) as u8, (127 + k % 3) as u8];
    for k in 0..15 {
        bytes.extend(pixel(if runs && k % 5 > 1 { k / 5 } else { k }));
    }
    bytes
}

#[test]
fn pictures_lie_as_in_radiance() {
    if programs().is_none() {
        return;
    }
    for size in ["-Y 3 +X 5", "-Y 3 -X 5", "+Y 3 +X 5", "+X 5 -Y 3", "-X 5 -Y 3", "-X 5 +Y 3"] {
        for aspect in ["", "PIXASPECT=2.5\n"] {
            let scene_files = [("f.cal", "sum(r,g,b) = .3*r+.4*g+.2*b; first(r) = 2*r;")];
            for text in [
                "void colorpict x 9 red green blue p.hdr . Px*.5 Py*.5 -rz 25 0 0",
                "void colorpict x 7 sum first clip_b p.hdr f.cal frac(Px) frac(Py) 0 0",
                "void brightfunc dark 2 .2 . 0 0 void mixpict x 7 dark void sum p.hdr f.cal frac(Px) frac(Py) 0 0",
            ] {
                let scene = Scene::new(&scene_files);
                std::fs::write(scene.path().join("p.hdr"), picture(size, aspect, false)).unwrap();
                for plane in [Plane::Up, Plane::Down] {
                    let rays = rays(plane, 100);
                    let theirs = format!("{text}\nx glow m 0 0 4 1 1 1 -1\n{}", plane.polygon());
                    let theirs = scene.rtrace(&theirs, &["-ab", "0", "-ov"], &rays);
                    let ours = format!("{text}\nx plastic m 0 0 5 1 1 1 0 0\n{}", plane.polygon());
                    let ours = scene.material(&ours, Unit::Meter);
                    for (ray, expected) in rays.iter().zip(theirs) {
                        let (found, _) = shade(modifiers(&ours), ray);
                        let limit = 1e-5 * expected.abs().max_element().max(0.1);
                        assert!(
                            (found - expected).abs().max_element() < limit,
                            "{size} {text}: {found} {expected}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn chains_mixtures_and_aliases_are_as_in_radiance() {
    if programs().is_none() {
        return;
    }
    let files = [("f.cal", CHANNELS)];
    let head = "void colorfunc a 4 .9 .8*Px .7 . 0 0\nvoid brightfunc b 2 checks(.7) f.cal 0 2 .5 .9\n";
    for (name, text) in [
        ("chain", "a brightfunc x 2 all f.cal 0 0"),
        ("mixture of patterns", "void mixfunc x 4 a b .3+.2*Px . 0 0"),
        ("amounts beyond 0 and 1", "void mixfunc x 4 a b 3*Px . 0 0"),
        ("a side that is nothing", "b mixfunc x 4 void a .4 . 0 0"),
        ("mixture of a mixture", "void mixfunc y 4 a b .4 . 0 0 a mixfunc x 4 y b Py . 0 0"),
        ("mixdata", "void mixdata x 6 a b noop c.dat . Px 0 0"),
        ("alias", "void alias c a b alias x c"),
        (
            "later definition",
            "a alias c b void colorfunc a 4 0 0 0 . 0 0 void alias x c c brightfunc x 2 .5 . 0 0",
        ),
    ] {
        let files = [files[0], ("c.dat", CURVE)];
        patterns_agree(name, &format!("{head}{text}"), &files, Unit::Meter, 1e-5);
    }
}

#[test]
fn library_functions_and_files_work() {
    if programs().is_none() {
        return;
    }
    for (name, text) in [
        ("noise", "void brightfunc x 10 '.5+.5*fnoise3(Px,Py,Pz)' . -s .3 -rx 20 -t 1 2 3 0 0"),
        ("turbulence", "void brightfunc x 4 turbulence(Px,Py,Pz,.1) . -rz 10 0 0"),
        (
            "spherical harmonics",
            "void brightfunc x 2 '.5+.1*SphericalHarmonicYr(2,1,Acos(-Dz),Px)' spharm.cal 0 0",
        ),
        ("tmesh", "void colorfunc x 6 .5+.5*u .5+.5*v .5 tmesh.cal -rz 5 0 7 2 .3 .1 .2 -.4 .5 .1"),
    ] {
        patterns_agree(name, text, &[], Unit::Meter, 2e-5);
    }
}

#[test]
fn textures_move_the_normal_as_in_radiance() {
    if programs().is_none() {
        return;
    }
    let files = [
        ("f.cal", CHANNELS),
        ("r.dat", RAMPS),
        ("t.cal", "tx(a,b,c) = a - .3; ty(a,b,c) = .5*b; tz(a,b,c) = .1*c;"),
    ];
    for (name, text) in [
        ("texfunc", "void texfunc x 4 bump(Px,2) bump(Py,3) 0 f.cal 0 1 .5"),
        ("turned", "void texfunc x 8 bump(Px,2) bump(Py,3) .1 f.cal -rx 40 -rz 70 0 1 .5"),
        ("scaled", "void texfunc x 9 bump(Px,2) bump(Py,3) .1 f.cal -s 4 -mx -rz 20 0 1 .5"),
        (
            "two",
            "void texfunc y 6 .1 bump(Px,5) 0 f.cal -rz 12 0 1 .2 y texfunc x 4 bump(Py,3) 0 .1 f.cal 0 1 .1",
        ),
        (
            "mixed",
            "void texfunc y 4 .3 bump(Px,5) 0 f.cal 0 1 .2 void mixfunc x 6 y void .5+.5*Px . -rz 30 0 0",
        ),
        ("texdata", "void texdata x 11 tx ty tz r.dat r.dat r.dat t.cal Px Py -rz 33 0 0"),
        ("tmesh", "void texfunc x 6 dx dy dz tmesh.cal -rx 0 0 10 2 .3 .1 .2 -.4 .5 .1 .1 .1 1"),
        ("under xform", "!xform -mx -rz 35 -s 2 inner.rad"),
    ] {
        let inner = "void texfunc x 6 bump(Px,2) bump(Py,3) .05 f.cal -ry 10 0 1 .5";
        let scene = Scene::new(&[files[0], files[1], files[2], ("inner.rad", inner)]);
        for plane in [Plane::Up, Plane::Down] {
            for unit in [Unit::Meter, Unit::Inch] {
                let text = format!("{text}\nx plastic m 0 0 5 .5 .5 .5 0 0\n{}", plane.polygon());
                let rays = rays(plane, 100);
                let theirs = scene.rtrace(&text, &["-ab", "0", "-on"], &rays);
                let ours = scene.material(&text, unit);
                let mut most: f64 = 0.0;
                for (ray, expected) in rays.iter().zip(theirs) {
                    let (_, perturbation) = shade(modifiers(&ours), &scaled(ray, unit));
                    let found = (ray.normal + perturbation).normalize();
                    if found.dot(ray.direction) > -0.05 {
                        continue;
                    }
                    most = most.max(found.distance(ray.normal));
                    assert!(found.distance(expected) < 1e-6, "{name} {plane:?} {ray:?}: {found} {expected}");
                }
                assert!(most > 0.05, "{name}: the normal hardly moves");
            }
        }
    }
}

/// Letters with holes, of parts that overlap, narrow and wide ones, and a space; not all codes have one.
const FONT: &str = "# letters for a test
    65 11  20 0 128 250 235 0 200 0 128 170 60 0 20 0  90 40 128 120 160 40 90 40  20 0
    105 4  110 0 150 0 140 180 115 180
    87 6   0 255 60 0 128 200 196 0 255 255 128 30
    46 4   100 10 140 10 140 60 100 60
    32 0";

#[test]
fn text_lies_as_in_radiance() {
    if programs().is_none() {
        return;
    }
    let lines = "AiW. iA\n  iiiWA    i.i\n\nW?W i?i.\n? AA   A    A i";
    let files = [("f.fnt", FONT), ("lines.txt", lines)];
    for spacing in ["", "0", "-.15", ".2", ".31", "-.7"] {
        let values = |n: usize| if spacing.is_empty() { n } else { n + 1 };
        for vectors in [
            "-2 2 0 .4 0 0 0 -.8 0",
            "-2 1.5 0 .3 .1 .2 .1 -.7 .4",
            "1.9 -1 .3 -.5 .2 0 .2 .8 0",
            "-2 2 0 1.1 0 0 0 -.9 0",
        ] {
            for text in [
                format!("void brighttext x 2 f.fnt lines.txt 0 {} {vectors} .9 .2 {spacing}", values(11)),
                format!(
                    "void brighttext x 5 f.fnt . 'A  i' WWWW AWAW 0 {} {vectors} .2 .7 {spacing}",
                    values(11)
                ),
                format!(
                    "void colortext x 2 f.fnt lines.txt 0 {} {vectors} .1 .2 .3 .9 .8 .7 {spacing}",
                    values(15)
                ),
                format!(
                    "void colorfunc a 4 .9 .8*Px .7 . 0 0 void brightfunc b 2 .3 . 0 0 \
                     void mixtext x 4 a b f.fnt lines.txt 0 {} {vectors} {spacing}",
                    values(9)
                ),
            ] {
                let found = patterns_agree(&text, &text, &files, Unit::Meter, 1e-5);
                let n_first = found.iter().filter(|color| color.x == found[0].x).count();
                assert!((3..found.len() - 2).contains(&n_first), "{text}: {n_first} of {}", found.len());
            }
        }
    }
}

#[test]
fn text_moves_with_the_scene() {
    if programs().is_none() {
        return;
    }
    let inner = "void brighttext x 3 f.fnt . AiWAWAW 0 11 -2 .5 0 .5 0 0 0 -1 0 .2 .9\n";
    for command in ["-t .3 .2 .1", "-rx 33 -rz 12 -s 1.5", "-mx -rz 60", "-i 3 -rz 11 -t .1 0 0"] {
        let files = [("f.fnt", FONT), ("inner.rad", inner)];
        patterns_agree(command, &format!("!xform {command} inner.rad"), &files, Unit::Foot, 1e-5);
    }
}
