//! Radiance's programs as the oracle.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// The folder of Radiance's programs: `BSDFTREE_RADIANCE`, or that of pyradiance in `.venv`. `None` with a visible line.
pub fn programs() -> Option<&'static Path> {
    static FOLDER: OnceLock<Option<PathBuf>> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let named = std::env::var_os("BSDFTREE_RADIANCE").map(PathBuf::from);
        let folder = named.or_else(|| pyradiance().map(|folder| folder.join("bin")));
        folder.filter(|folder| folder.join("rtrace").is_file())
    });
    if folder.is_none() {
        eprintln!(
            "SKIPPED: no rtrace; install pyradiance in .venv or set BSDFTREE_RADIANCE to the folder of programs"
        );
    }
    folder.as_deref()
}

/// One program, or `None` with a visible line.
pub fn program(name: &str) -> Option<PathBuf> {
    let path = programs()?.join(name);
    if !path.is_file() {
        eprintln!("SKIPPED: there is no {}", path.display());
        return None;
    }
    Some(path)
}

/// The folder of the package pyradiance, if it is there.
pub fn pyradiance() -> Option<PathBuf> {
    let libraries = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../.venv/lib"));
    let packages = std::fs::read_dir(libraries).ok()?;
    packages
        .filter_map(|python| Some(python.ok()?.path().join("site-packages/pyradiance")))
        .find(|folder| folder.is_dir())
}

/// What a program prints in a folder, given this on standard input; its messages if it fails. It finds Radiance's function files
/// and other programs.
///
/// # Panics
/// If there are no programs, which is to be asked first.
pub fn run(
    program: &str,
    folder: &Path,
    arguments: &[impl AsRef<str>],
    input: &[u8],
) -> Result<Vec<u8>, String> {
    let programs = programs().expect("asked for before");
    let mut child = Command::new(programs.join(program))
        .args(arguments.iter().map(AsRef::as_ref))
        .current_dir(folder)
        .env("PATH", programs)
        .env("RAYPATH", format!(".:{}", programs.with_file_name("lib").display()))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap_or_else(|error| panic!("{program}: {error}"));
    let mut stdin = child.stdin.take().expect("it is a pipe");
    let output = std::thread::scope(|threads| {
        // A program that stops with an error may not have read everything.
        threads.spawn(move || drop(stdin.write_all(input)));
        child.wait_with_output().unwrap_or_else(|error| panic!("{program}: {error}"))
    });
    match output.status.success() {
        true => Ok(output.stdout),
        false => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
    }
}

/// As [`run`], of a program that must not fail.
///
/// # Panics
/// If it does, or there are no programs.
pub fn printed(program: &str, folder: &Path, arguments: &[impl AsRef<str>], input: &[u8]) -> Vec<u8> {
    run(program, folder, arguments, input).unwrap_or_else(|message| panic!("{program}: {message}"))
}

/// The numbers of a program's binary output.
pub fn doubles(bytes: &[u8]) -> Vec<f64> {
    let (chunks, _) = bytes.as_chunks();
    chunks.iter().map(|&chunk| f64::from_ne_bytes(chunk)).collect()
}
