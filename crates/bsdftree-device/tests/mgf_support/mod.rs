//! Radiance's programs as the oracle, and Radiance scenes as lists of primitives.

#![allow(dead_code, reason = "not every test needs all of it")]

use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use bsdftree_device::Device;

pub use bsdftree_testing::radiance::program as radiance;

/// What a program prints for a file of this text; its message if it fails.
pub fn run(program: &PathBuf, text: &str) -> Result<String, String> {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(text.as_bytes()).unwrap();
    let output = Command::new(program).arg(file.path()).stdin(Stdio::null()).output().unwrap();
    match output.status.success() {
        true => Ok(String::from_utf8(output.stdout).unwrap()),
        false => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
    }
}

/// What mgf2rad makes of a text; its message if it fails.
pub fn translated(mgf2rad: &PathBuf, text: &str) -> Result<String, String> {
    // The one of Radiance 6.1 defines a texture by one name and uses it by another.
    Ok(run(mgf2rad, text)?.replace("\nT-nor polygon", "\nPhong polygon"))
}

/// A primitive of a Radiance scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Primitive {
    pub modifier: String,
    pub kind: String,
    pub name: String,
    pub strings: Vec<String>,
    pub reals: Vec<f64>,
}

/// All primitives of a scene without commands.
pub fn primitives(scene: &str) -> Vec<Primitive> {
    let lines = scene.lines().filter(|line| !line.starts_with('#'));
    let mut words = lines.flat_map(str::split_whitespace).map(str::to_owned).peekable();
    let mut all = Vec::new();
    while words.peek().is_some() {
        let [modifier, kind, name] = [(); 3].map(|()| words.next().unwrap());
        let n: usize = words.next().unwrap().parse().unwrap();
        let strings = words.by_ref().take(n).collect();
        assert_eq!(words.next().unwrap(), "0");
        let n: usize = words.next().unwrap().parse().unwrap();
        let reals = words.by_ref().take(n).map(|word| word.parse().unwrap()).collect();
        all.push(Primitive { modifier, kind, name, strings, reals });
    }
    all
}

/// A surface and what it is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Made {
    pub surface: Primitive,
    pub material: Option<Primitive>,
    pub texture: Option<Primitive>,
}

/// The surfaces of a scene, each with its material in force.
pub fn made(scene: &str) -> Vec<Made> {
    let mut in_force: std::collections::HashMap<String, Primitive> = Default::default();
    let mut all = Vec::new();
    for mut p in primitives(scene) {
        match &*p.kind {
            "polygon" | "sphere" | "bubble" | "cylinder" | "tube" | "cone" | "cup" | "ring" => {
                let modifier = match in_force.get(&p.modifier) {
                    // One-sided: mgf2rad of Radiance 6.1 has no mixture for it.
                    Some(mix) if mix.kind == "mixfunc" && mix.strings[1..3] == ["void", "if(Rdot,1,0)"] => {
                        let front = in_force.get(&mix.strings[0]).cloned();
                        front.map(|front| Primitive { name: mix.name.clone(), ..front })
                    }
                    modifier => modifier.cloned(),
                };
                let modifier = modifier.map(|m| flattened(m, &in_force));
                let (material, texture) = match modifier {
                    Some(t) if t.kind == "texfunc" => (in_force.get(&t.modifier).cloned(), Some(t)),
                    material => (material, None),
                };
                if p.reals.len() == 8 && p.kind.starts_with('c') && p.reals[6] == p.reals[7] {
                    p.kind = if p.kind == "cone" { "cylinder".into() } else { "tube".into() };
                    p.reals.pop();
                }
                all.push(Made { surface: p, material, texture });
            }
            _ => {
                in_force.insert(p.name.clone(), p);
            }
        }
    }
    all
}

/// A `WGMDfunc` of numbers with the colours of its patterns: red, green, blue and two roughnesses of reflection and of transmission after
/// its own reals.
fn flattened(mut p: Primitive, in_force: &std::collections::HashMap<String, Primitive>) -> Primitive {
    if p.kind == "WGMDfunc" {
        for first in [0, 4] {
            let number = |k: usize| p.strings[first + k].parse::<f64>().unwrap();
            let pattern = in_force.get(&p.strings[first]).map(|pattern| {
                assert_eq!(pattern.kind, "colorfunc");
                [0, 1, 2].map(|k| pattern.strings[k].parse::<f64>().unwrap())
            });
            let color = pattern.unwrap_or([1.0; 3]).map(|c| c * number(1));
            p.reals.extend(color.into_iter().chain([number(2), number(3)]));
        }
    }
    p
}

/// The same of a device.
pub fn made_of(device: &Device) -> Vec<Made> {
    made(&device.to_rad())
}

/// Whether all numbers are the same up to a tolerance, relative above 1.
pub fn near(a: &[f64], b: &[f64], tolerance: f64) -> bool {
    a.len() == b.len()
        && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance * (1.0 + a.abs().max(b.abs())))
}
