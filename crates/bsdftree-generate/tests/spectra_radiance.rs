//! Spectra beside `rtrace`, live: what a path carries has the colour that Radiance gives them.
//!
//! From long to short wavelengths only: of spectra that ascend, Radiance 6.0 takes half a step at each end the wrong way, and of
//! listed wavelengths it takes even ones. It makes few samples of all of them, hence the tolerances.

#[path = "../../bsdftree-device/tests/field/scenes.rs"]
mod scenes;

use bsdftree::color::rgb_from_xyz;
use bsdftree_device::Unit;
use bsdftree_device::field::{RayState, Spectral};
use bsdftree_device::material::{Material, Modifier};
use bsdftree_generate::scatter;
use bsdftree_testing::radiance::programs;
use glam::DVec3;
use scenes::{Plane, Scene, rays};

/// The colour that a path has which meets the first modifier of a material.
fn color(material: &Material, ray: &RayState) -> DVec3 {
    let Material::Modified { modifiers, .. } = material else { panic!("{material:?}") };
    let of = |s: &Spectral| rgb_from_xyz(scatter::Spectral::from_samples(&s.wavelengths_nm, &s.values).xyz());
    match &modifiers[0] {
        Modifier::Spectrum(spectral) => DVec3::from_array(of(spectral)),
        Modifier::SpectralField(field) => DVec3::from_array(of(&field.at(ray).unwrap())),
        other => panic!("{other:?}"),
    }
}

/// The mean and the greatest deviation.
fn deviations(text: &str, files: &[(&str, &[u8])]) -> (f64, f64) {
    let scene = Scene::new(&[]);
    for (name, bytes) in files {
        std::fs::write(scene.path().join(name), bytes).unwrap();
    }
    let mut found = Vec::new();
    for plane in [Plane::Up, Plane::Down] {
        let rays = rays(plane, 200);
        // The sign of the distance limit makes the glow shine without being a light source.
        let theirs = format!("{text}\nx glow m 0 0 4 1 1 1 -1\n{}", plane.polygon());
        let theirs = scene.rtrace(&theirs, &["-ab", "0", "-ov"], &rays);
        let ours =
            scene.material(&format!("{text}\nx plastic m 0 0 5 1 1 1 0 0\n{}", plane.polygon()), Unit::Meter);
        found.extend(
            rays.iter().zip(theirs).map(|(ray, theirs)| (color(&ours, ray) - theirs).abs().max_element()),
        );
    }
    (found.iter().sum::<f64>() / found.len() as f64, found.iter().fold(0.0, |most, &d| most.max(d)))
}

#[test]
fn spectra_have_radiances_colours() {
    if programs().is_none() {
        return;
    }
    let n = 41;
    let smooth: Vec<f64> = (0..n).map(|k| 0.5 + 0.4 * (f64::from(k) * 0.1).sin()).collect();
    let values: String = smooth.iter().map(|v| format!(" {v:.4}")).collect();
    let file = format!("1\n780 380 {n}\n{values}\n");
    // Over x from -2 to 2 it goes from this spectrum to the reverse of it.
    let reverse: String = smooth.iter().rev().map(|v| format!(" {v:.4}")).collect();
    let plane = format!("2\n-2 2 2\n780 380 {n}\n{values}\n{reverse}\n");
    let functions = b"ramp(nm) = .5 + (nm - 550)/1000 + .1*Px; less(v, nm) = .8*v + .2*(nm - 380)/400;";
    let files: [(&str, &[u8]); 4] = [
        ("s.dat", file.as_bytes()),
        ("p.dat", plane.as_bytes()),
        ("f.cal", functions),
        ("p.spc", &picture()),
    ];
    for (text, tolerance) in [
        (format!("void spectrum x 0 0 {} 780 380{values}", n + 2), 0.01),
        ("void specfile x 1 s.dat 0 0".to_owned(), 0.01),
        ("void specdata x 4 less p.dat f.cal Px 0 0".to_owned(), 0.01),
        ("void specdata x 6 less p.dat f.cal .5*Px+Py -rz 20 0 0".to_owned(), 0.01),
        ("void specpict x 5 less p.spc f.cal frac(Px) frac(Py) 0 0".to_owned(), 0.01),
        ("void specpict x 8 less p.spc f.cal .3*Px+.5 .2*Py+.4 -rz 33 -mx 0 0".to_owned(), 0.01),
        // Radiance draws its samples at random.
        ("void specfunc x 2 ramp f.cal 0 2 380 780".to_owned(), 0.03),
    ] {
        let (mean, most) = deviations(&text, &files);
        println!("{text:.60}: {mean:.5} {most:.5}");
        assert!(most < tolerance, "{text}: {mean} {most}");
    }
}

/// 5 × 3 pixels of 16 components, other at each.
fn picture() -> Vec<u8> {
    let head =
        "#?RADIANCE\nNCOMP=16\nWAVELENGTH_SPLITS= 780 588 480 380\nFORMAT=Radiance_spectra\n\n-Y 3 +X 5\n";
    let mut bytes = head.as_bytes().to_vec();
    for pixel in 0..15_u8 {
        bytes.extend((0..16_u8).map(|k| 60 + 7 * pixel + (if pixel % 2 == 0 { k } else { 15 - k }) * 5));
        bytes.push(128);
    }
    bytes
}
