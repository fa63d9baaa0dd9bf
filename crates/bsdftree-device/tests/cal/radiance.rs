//! Radiance's programs as the oracle: `rcalc`, and `rtrace` for what only the renderer has.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// The folder of Radiance's programs: `BSDFTREE_RADIANCE`, or that of pyradiance in `.venv`. `None` with a visible line.
pub fn programs() -> Option<&'static Path> {
    static FOLDER: OnceLock<Option<PathBuf>> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let named = std::env::var_os("BSDFTREE_RADIANCE").map(PathBuf::from);
        let folder = named.or_else(|| pyradiance().map(|folder| folder.join("bin")));
        folder.filter(|folder| folder.join("rcalc").is_file())
    });
    if folder.is_none() {
        eprintln!(
            "SKIPPED: no rcalc; install pyradiance in .venv or set BSDFTREE_RADIANCE to the folder of programs"
        );
    }
    folder.as_deref()
}

/// The folder of the package pyradiance, if it is there.
pub fn pyradiance() -> Option<PathBuf> {
    let libraries = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../.venv/lib"));
    let packages = std::fs::read_dir(libraries).ok()?;
    packages
        .filter_map(|python| Some(python.ok()?.path().join("site-packages/pyradiance")))
        .find(|folder| folder.is_dir())
}

fn run(program: &str, folder: &Path, arguments: &[&str], input: &str) -> Option<Vec<u8>> {
    use std::io::Write;
    let programs = programs()?;
    let mut child = Command::new(programs.join(program))
        .args(arguments)
        .current_dir(folder)
        .env("RAYPATH", format!(".:{}", programs.with_file_name("lib").display()))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let input = input.to_owned();
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()));
    let output = child.wait_with_output().unwrap();
    // A program that stops with an error may not have read everything.
    let _ = writer.join().unwrap();
    output.status.success().then_some(output.stdout)
}

fn doubles(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|bytes| f64::from_ne_bytes(bytes.try_into().unwrap())).collect()
}

/// All outputs of a file for rcalc; `None` if it stops with an error.
pub fn rcalc(text: &str) -> Option<Vec<f64>> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("case.cal"), text).unwrap();
    run("rcalc", folder.path(), &["-n", "-od", "-f", "case.cal"], "").map(|bytes| doubles(&bytes))
}

/// A ray and where it meets the plane z = 0, whose normal is +z.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub origin: [f64; 3],
    pub direction: [f64; 3],
}

/// The real arguments of the primitive in [`rtrace`].
pub const ARGUMENTS: [f64; 4] = [1.5, 0.25, 3.0, 0.5];

/// Values of an expression against a function file (`.` for none), for each ray; `None` if rtrace stops with an error.
///
/// They come as `f32`: rtrace keeps radiances so.
pub fn rtrace(file: &str, expression: &str, rays: &[Ray]) -> Option<Vec<f64>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("case.cal"), file).unwrap();
    let arguments: Vec<String> = ARGUMENTS.iter().map(f64::to_string).collect();
    // The sign of the distance limit -1 makes the glow shine without being a light source.
    let scene = format!(
        "void brightfunc b\n2 \"{expression}\" case.cal\n0\n{} {}\n\
         b glow g\n0\n0\n4 1 1 1 -1\n\
         g polygon p\n0\n0\n12 -100 -100 0 100 -100 0 100 100 0 -100 100 0\n",
        arguments.len(),
        arguments.join(" ")
    );
    std::fs::write(path.join("case.rad"), scene).unwrap();
    let octree = run("oconv", path, &["case.rad"], "")?;
    std::fs::write(path.join("case.oct"), octree).unwrap();
    let input: String = rays
        .iter()
        .map(|ray| {
            let [x, y, z] = ray.origin;
            let [dx, dy, dz] = ray.direction;
            format!("{x} {y} {z} {dx} {dy} {dz}\n")
        })
        .collect();
    let bytes = run("rtrace", path, &["-h", "-fad", "-ab", "0", "-ov", "case.oct"], &input)?;
    Some(doubles(&bytes).chunks_exact(3).map(|rgb| rgb[0]).collect())
}
