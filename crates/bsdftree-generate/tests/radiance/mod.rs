//! Radiance's `rtrace` and the folder of real files, as tests of materials need them.
#![allow(dead_code)]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use glam::DVec3;

/// The folder of Radiance's programs: `BSDFTREE_RADIANCE`, or that of pyradiance in `.venv`. `None` with a visible line.
pub fn programs() -> Option<&'static Path> {
    static FOLDER: OnceLock<Option<PathBuf>> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let named = std::env::var_os("BSDFTREE_RADIANCE").map(PathBuf::from);
        let folder = named.or_else(pyradiance);
        folder.filter(|folder| folder.join("rtrace").is_file())
    });
    if folder.is_none() {
        eprintln!(
            "SKIPPED: no rtrace; install pyradiance in .venv or set BSDFTREE_RADIANCE to the folder of programs"
        );
    }
    folder.as_deref()
}

fn pyradiance() -> Option<PathBuf> {
    let libraries = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../.venv/lib"));
    let packages = std::fs::read_dir(libraries).ok()?;
    packages
        .filter_map(|python| Some(python.ok()?.path().join("site-packages/pyradiance/bin")))
        .find(|folder| folder.is_dir())
}

/// A real file, or `None` with a visible line if the folder of them is absent.
pub fn real_file(name: &str) -> Option<PathBuf> {
    let beside = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data"));
    let folder = std::env::var_os("BSDFTREE_DATA").map_or_else(beside, PathBuf::from);
    let file = folder.join(name);
    if !file.is_file() {
        eprintln!("SKIPPED: no {}; set BSDFTREE_DATA to the folder of real files", file.display());
        return None;
    }
    Some(file)
}

fn run(program: &str, folder: &Path, arguments: &[&str], input: String) -> Vec<u8> {
    let programs = programs().expect("asked for before");
    let mut child = Command::new(programs.join(program))
        .args(arguments)
        .current_dir(folder)
        .env("RAYPATH", format!(".:{}", programs.with_file_name("lib").display()))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()));
    let output = child.wait_with_output().unwrap();
    let _ = writer.join().unwrap();
    assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// Red, green and blue that rtrace sees along rays (origin, direction of travel) into a scene.
pub fn rtrace(scene: &str, options: &str, rays: &[(DVec3, DVec3)]) -> Vec<DVec3> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.rad"), scene).unwrap();
    let octree = run("oconv", folder.path(), &["scene.rad"], String::new());
    std::fs::write(folder.path().join("scene.oct"), octree).unwrap();
    let line = |&(o, d): &(DVec3, DVec3)| format!("{} {} {} {} {} {}\n", o.x, o.y, o.z, d.x, d.y, d.z);
    let mut arguments = vec!["-h", "-w-", "-fad", "-ov"];
    arguments.extend(options.split_whitespace());
    arguments.push("scene.oct");
    let bytes = run("rtrace", folder.path(), &arguments, rays.iter().map(line).collect());
    let numbers: Vec<f64> =
        bytes.chunks_exact(8).map(|bytes| f64::from_ne_bytes(bytes.try_into().unwrap())).collect();
    numbers.chunks_exact(3).map(DVec3::from_slice).collect()
}

/// Light from above is red and light from below is green, so that of a grey device at z = 0 whose rays come from above red is
/// what it reflects and green what it transmits.
pub const SKIES: &str = "void glow above 0 0 4 1 0 0 0\nabove source s 0 0 4 0 0 1 180\n\
                         void glow below 0 0 4 0 1 0 0\nbelow source s 0 0 4 0 0 -1 180\n";

/// Light that tells where it comes from: ½ + ½d as red, green and blue for direction d.
pub const DIRECTIONS: &str = "void colorfunc directions 4 .5+.5*Dx .5+.5*Dy .5+.5*Dz . 0 0\n\
                              directions glow sky 0 0 4 1 1 1 0\nsky source s 0 0 4 0 0 1 360\n";

/// What a ray sees of [`DIRECTIONS`] by a path that leaves by a direction with a weight.
pub fn seen(direction: DVec3, weight: f64) -> DVec3 {
    (direction * 0.5 + 0.5) * weight
}

/// The direction towards which light leaves, or from which it comes, from angles in degrees; over 90° from the back.
pub fn polar(theta_deg: f64, phi_deg: f64) -> DVec3 {
    let (theta, phi) = (theta_deg.to_radians(), phi_deg.to_radians());
    DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// Mean and standard error of what rtrace sees in one direction, from `n` rays.
pub fn mean(scene: &str, options: &str, towards: DVec3, n: usize) -> [DVec3; 2] {
    let origin = DVec3::new(0.013, 0.027, 0.0) + towards;
    let seen = rtrace(scene, options, &vec![(origin, -towards); n]);
    let mean = seen.iter().sum::<DVec3>() / n as f64;
    let squares = seen.iter().map(|v| (*v - mean) * (*v - mean)).sum::<DVec3>() / (n as f64 - 1.0).max(1.0);
    [mean, (squares / n as f64).map(f64::sqrt)]
}
