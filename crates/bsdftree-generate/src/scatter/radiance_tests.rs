//! Materials with patterns and textures beside `rtrace`, live.
//!
//! Specular parts: the surface lies in a glow that shines in the colour of its direction, so that a mean over our samples is one
//! of directions. Directional functions: the surface is lit by a small distant source, the radiance being BSDF times cosine.

use std::path::Path;

use bsdftree_device::{Device, ReadOptions, Unit};
use bsdftree_testing::radiance::{doubles, printed, programs};
use glam::DVec3;

use super::function::{BrtdShading, FunctionShading};
use super::shading::{Facing, Shade, ray_state};
use super::test_support::direction;
use super::*;
use crate::random::Random;

/// A material in the plane z = 0, and what is around it in Radiance.
struct Scene {
    programs: &'static Path,
    folder: tempfile::TempDir,
    /// Defines `m`.
    text: String,
}

impl Scene {
    fn new(text: &str) -> Option<Scene> {
        let programs = programs()?;
        let folder = tempfile::tempdir().unwrap();
        let functions = "bump(p, f) = .25*sin(f*p + 1); checks = if(.5 - mod(floor(3*Px) + floor(3*Py), 2), .9, .3);
            phong(x,y,z,o) = .3*noneg(x*(Dx - 2*Nx*(Nx*Dx+Ny*Dy+Nz*Dz)) + y*(Dy - 2*Ny*(Nx*Dx+Ny*Dy+Nz*Dz)) + z*(Dz - 2*Nz*(Nx*Dx+Ny*Dy+Nz*Dz)))^3;
            perturbed(x,y,z,o) = .2*noneg(x*NxP + y*NyP + z*NzP) + .1*RdotP + .05*CrP;
            sided(x,y,z,o) = if(z*Dz, .1, .2)*(1.5 + x) + A1*0;
            scaled(v,x,y,z,o) = .1*v*(2 + y); cosine(x,y,z,o) = z; azimuth(x,y,z,o) = atan2(y, x);";
        let data = "2\n-1 1 3\n0 0 4 -4 -1 1 4\n1 2 3 4\n5 4 3 2\n2 1 2 1\n";
        std::fs::write(folder.path().join("f.cal"), functions).unwrap();
        std::fs::write(folder.path().join("d.dat"), data).unwrap();
        Some(Scene { programs, folder, text: text.to_owned() })
    }

    /// Radiance's values for rays that start at a distance of 1 from where they meet the plane.
    fn rtrace(&self, around: &str, meetings: &[Meeting]) -> Vec<DVec3> {
        let plane = "m polygon p 0 0 12 -99 -99 0 99 -99 0 99 99 0 -99 99 0\n";
        std::fs::write(self.folder.path().join("s.rad"), format!("{}\n{plane}{around}", self.text)).unwrap();
        let octree = printed("oconv", self.folder.path(), &["s.rad"], b"");
        std::fs::write(self.folder.path().join("s.oct"), octree).unwrap();
        let rays = meetings.iter().map(|m| {
            let (o, d) = (m.position - m.incoming, m.incoming);
            format!("{:?} {:?} {:?} {:?} {:?} {:?}\n", o.x, o.y, o.z, d.x, d.y, d.z)
        });
        let options = "-h -fad -ab 0 -dj 0 -dt 0 -dc 1 -ds 0 -st 0 -ss 0 -lr 8 -lw 1e-9 -ov s.oct"
            .split(' ')
            .collect::<Vec<_>>();
        let input: String = rays.collect();
        let bytes = printed("rtrace", self.folder.path(), &options, input.as_bytes());
        doubles(&bytes).chunks_exact(3).map(DVec3::from_slice).collect()
    }

    fn material(&self) -> Material {
        let search = Some(vec![self.programs.with_file_name("lib")]);
        let options = ReadOptions { unit: Unit::Meter, search, ..ReadOptions::default() };
        let text = format!("{}\nm ring r 0 0 8 0 0 0 0 0 1 0 1", self.text);
        let device = Device::parse_rad(&text, "s.rad", self.folder.path(), options);
        device.unwrap_or_else(|e| panic!("{e}")).materials[0].material.clone()
    }
}

/// Meetings at the plane, from both sides, not too grazing.
fn meetings(n: u64) -> Vec<Meeting> {
    let mut random = Random::new(51, 0, 0);
    (0..n)
        .map(|_| {
            let mut incoming = direction(&mut random);
            while incoming.z.abs() < 0.3 {
                incoming = direction(&mut random);
            }
            let position = DVec3::new(random.next_f64() * 4.0 - 2.0, random.next_f64() * 4.0 - 2.0, 0.0);
            Meeting { position, distance: 1.0, traveled: 1.0, ..Meeting::new(DVec3::Z, incoming) }
        })
        .collect()
}

/// All around shines in the colour of the direction.
const AROUND: &str = "void colorfunc all 4 .6+.4*Dx .6+.4*Dy .6+.4*Dz . 0 0\nall glow sky 0 0 4 1 1 1 -1
sky source up 0 0 4 0 0 1 180\nsky source down 0 0 4 0 0 -1 180\n";

fn shine(direction: DVec3) -> DVec3 {
    DVec3::splat(0.6) + 0.4 * direction
}

#[test]
fn specular_parts_under_patterns_and_textures_are_as_in_radiance() {
    let patterns = "void brightfunc p 4 checks f.cal -rz 20 0 0\n";
    let textures = "p texfunc x 6 bump(Px,3) bump(Py,2) .1 f.cal -rz 40 0 0\n";
    let pattern = "p colorfunc x 4 .9 .7 .5 . 0 0\n";
    for modifiers in [textures, pattern] {
        for material in [
            "x mirror m 0 0 3 .9 .8 .7",
            "x metal m 0 0 5 .9 .8 .7 1 0",
            "x glass m 0 0 4 .9 .8 .7 1.6",
            "x trans m 0 0 7 .9 .8 .7 .1 0 1 1",
            "x dielectric m 0 0 5 1 1 1 1.5 0",
            "x BRTDfunc m 10 .3 .4*RdotP .2+.1*NxP .3*CrP .2 .1*abs(Rdot) 0 0 0 f.cal 0 9 0 0 0 0 0 0 0 0 0",
            "x mirror silver 0 0 3 .9 .9 .9 x glass pane 0 0 3 .8 .8 .8 void mixfunc m 4 silver pane .5+.4*sin(3*Px) . 0 0",
            "void BRTDfunc m 10 sr_frit_r sr_frit_g sr_frit_b st_frit_r st_frit_g st_frit_b 0 0 0 glaze1.cal 0 11 0 0 0 0 0 0 0 0 0 1 .4",
        ] {
            // A pattern on a medium takes all of what comes from afar.
            let modifiers = if material.contains("dielectric") {
                &textures.replace("p texfunc", "void texfunc")
            } else {
                modifiers
            };
            let Some(scene) = Scene::new(&format!("{patterns}{modifiers}{material}")) else { return };
            let meetings = meetings(30);
            let theirs = scene.rtrace(AROUND, &meetings);
            let faults = std::sync::Arc::default();
            let prepared = PreparedMaterial::<DVec3>::prepare(&scene.material(), "m", &faults);
            let mut random = Random::new(52, 0, 0);
            for (meeting, expected) in meetings.iter().zip(theirs) {
                let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
                let n = 20_000;
                for _ in 0..n {
                    let Some(s) = prepared.scatter(meeting, &mut random) else { continue };
                    // Radiance carries radiance, which a boundary changes by the squared ratio of the indices.
                    let denser = match material.contains("dielectric") && s.transmitted {
                        true => {
                            if meeting.is_front() {
                                1.5_f64.powi(-2)
                            } else {
                                1.5_f64.powi(2)
                            }
                        }
                        false => 1.0,
                    };
                    let value = s.weight * shine(s.direction) * denser;
                    sum += value;
                    squares += value * value;
                }
                let mean = sum / f64::from(n);
                let error =
                    ((squares / f64::from(n) - mean * mean).max(DVec3::ZERO) / f64::from(n)).map(f64::sqrt);
                let excess = (mean - expected).abs() - 5.0 * error;
                assert!(
                    excess.max_element() < 2e-5,
                    "{modifiers}{material}\n{meeting:?}: {mean} ± {error}, not {expected}"
                );
            }
            assert!(faults.error().is_none());
        }
    }
}

/// A source of half an opening of 0.05° whose irradiance at right angles is 1.
fn source(towards: DVec3) -> String {
    let omega = 2.0 * std::f64::consts::PI * (1.0 - 0.05_f64.to_radians().cos());
    let l = 1.0 / omega;
    format!(
        "void light sun 0 0 3 {l} {l} {l}\nsun source s 0 0 4 {:?} {:?} {:?} .1\n",
        towards.x, towards.y, towards.z
    )
}

#[test]
fn directional_functions_are_as_in_radiance() {
    let modifiers = "void brightfunc p 4 checks f.cal -rz 20 0 0\np texfunc x 6 bump(Px,3) bump(Py,2) .1 f.cal -rz 40 0 0\n";
    for material in [
        "x plasfunc m 2 phong f.cal 0 4 .5 .6 .7 .4",
        "x plasfunc m 2 perturbed f.cal 0 4 .5 .6 .7 .4",
        "x metfunc m 6 phong f.cal -rx 30 -rz 10 0 4 .5 .6 .7 .4",
        "x metfunc m 8 sided f.cal -t 1 2 3 -rz 50 0 4 .5 .6 .7 .4",
        "x transfunc m 2 sided f.cal 0 6 .5 .6 .7 .3 .5 .4",
        "x transfunc m 4 perturbed f.cal -rz 33 0 6 .5 .6 .7 .3 .8 .9",
        "x plasdata m 5 scaled d.dat f.cal cosine azimuth 0 4 .5 .6 .7 .4",
        "x transdata m 7 scaled d.dat f.cal cosine azimuth -rz 70 0 6 .5 .6 .7 .3 .5 .4",
        "x BRTDfunc m 10 0 0 0 0 0 0 phong sided perturbed f.cal 0 9 .1 .2 .3 .3 .2 .1 .05 .1 .15",
        "x BRTDfunc m 12 0 0 0 0 0 0 sided sided sided f.cal -rz 25 0 9 0 0 0 .3 .2 .1 0 0 0",
    ] {
        let Some(scene) = Scene::new(&format!("{modifiers}{material}")) else { return };
        let device = scene.material();
        let Material::Modified { modifiers, material: inner, .. } = &device else { panic!("{device:?}") };
        let watch = Watch::new("m", &Default::default());
        let mut random = Random::new(53, 0, 0);
        let (mut n_lit, mut most) = (0, 0.0_f64);
        for _ in 0..6 {
            let light = direction(&mut random);
            let meetings = meetings(40);
            let theirs = scene.rtrace(&source(light), &meetings);
            for (meeting, expected) in meetings.iter().zip(theirs) {
                let mut shade = Shade::<DVec3>::of(meeting);
                modified::apply(modifiers, &ray_state(meeting), &mut shade).unwrap();
                let value = match &**inner {
                    Material::Function(function) => {
                        let shading = FunctionShading { function: function.clone(), watch: watch.clone() };
                        shading.evaluate(meeting, &shade, light).unwrap()
                    }
                    Material::Brtd(function) => {
                        let shading = BrtdShading { function: function.clone(), watch: watch.clone() };
                        shading.evaluate(meeting, &shade, light).unwrap()
                    }
                    other => panic!("{other:?}"),
                };
                let cosine = Facing::new(meeting, &shade).normal.dot(light);
                let above = Facing::new(meeting, &shade).surface.dot(light);
                // Where the perturbed normal and the surface are of two minds about the side, Radiance lets light leak.
                if cosine * above < 0.0 || cosine.abs() < 0.02 {
                    continue;
                }
                let found = value * cosine.abs();
                n_lit += usize::from(expected != DVec3::ZERO);
                most = most.max(expected.max_element());
                let limit = 1e-3 * expected.max_element().max(0.02);
                assert!(
                    (found - expected).abs().max_element() < limit,
                    "{material}\n{meeting:?} {light}: {found}, not {expected}"
                );
            }
        }
        assert!(n_lit > 50 && most > 0.03, "{material}: {n_lit} {most}");
    }
}
