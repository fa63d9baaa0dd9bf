//! C programs against the static library: the whole interface under the address and undefined-behaviour sanitizers and from eight
//! threads, and the examples. Needs a C and a C++ compiler; skipped visibly without.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Arc;

use bsdftree::binary::Packing;
use bsdftree::{Basis, Bsdf, Component, Matrix, Part, Rank, Scattering, Tree, file};

/// Where cargo puts the static library that belongs to this test.
fn library() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let found =
        test.ancestors().skip(1).map(|folder| folder.join("libbsdftree_c.a")).find(|path| path.is_file());
    found.expect("cargo builds the static library before its tests")
}

/// Compiles a program; `None` without a compiler.
fn compiled(compiler: &str, source: &str, flags: &[&str], folder: &Path) -> Option<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = folder.join(Path::new(source).file_stem().unwrap());
    let mut command = Command::new(compiler);
    command.args(["-O1", "-Wall", "-Wextra", "-Werror"]).args(flags).arg(here.join(source));
    command.arg("-I").arg(here.join("include")).arg(library()).args(["-lpthread", "-ldl", "-lm"]);
    match command.arg("-o").arg(&program).output() {
        Err(_) => {
            eprintln!("SKIPPED: {source} needs {compiler}");
            None
        }
        Ok(output) => {
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            Some(program)
        }
    }
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn run(command: &mut Command) -> Output {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// A file of trees of both ranks, or of matrices, and one that is cut short.
fn files(folder: &Path, matrices: bool, ending: &str) -> [PathBuf; 2] {
    let mut bsdf = Bsdf::default();
    let band = bsdf.band_mut("Visible");
    if matrices {
        let basis = Arc::new(Basis::quarter());
        let n = basis.n_patches();
        let values = (0..n * n).map(|k| (k % 11) as f32 * 0.02).collect();
        let matrix = Matrix::new(Arc::clone(&basis), basis, values).unwrap();
        band.insert(Part::TransmissionFront, Component::grey(matrix.into()));
    } else {
        let tree = |rank: Rank, log2: usize| {
            let n = 1usize << (log2 * rank.dimensions());
            let values: Vec<f32> =
                (0..n).map(|k| if k % 3 == 0 { 0.0 } else { (k % 29) as f32 * 0.01 }).collect();
            Component::grey(Scattering::from(Tree::from_grid(rank, &values).unwrap()))
        };
        band.insert(Part::TransmissionBack, tree(Rank::Four, 3));
        band.insert(Part::ReflectionFront, tree(Rank::Four, 2));
        band.insert(Part::ReflectionBack, tree(Rank::Four, 1));
    }
    let [good, bad] = ["good", "bad"].map(|name| folder.join(format!("{name}-{matrices}.{ending}")));
    file::write(&bsdf, &good, Packing::Raw).unwrap();
    let text = std::fs::read(&good).unwrap();
    std::fs::write(&bad, &text[..text.len() / 2]).unwrap();
    [good, bad]
}

#[test]
fn the_interface_holds_from_c_under_sanitizers_and_from_many_threads() {
    let folder = folder("interface");
    let flags = ["-std=c11", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    let Some(program) = compiled("cc", "tests/interface.c", &flags, &folder) else { return };
    for matrices in [false, true] {
        for ending in ["xml", "bsdft"] {
            let output = run(Command::new(&program).args(files(&folder, matrices, ending)));
            assert_eq!(output.stdout, b"all of bsdftree.h holds\n");
        }
    }
}

#[test]
fn the_examples_run() {
    let folder = folder("examples");
    let [good, bad] = files(&folder, false, "xml");
    if let Some(program) = compiled("cc", "examples/integrate.c", &["-std=c11"], &folder) {
        let table = run(Command::new(&program).arg(&good)).stdout;
        assert_eq!(String::from_utf8(table).unwrap().lines().count(), 2 + 6);
        let refused = Command::new(&program).arg(&bad).output().unwrap();
        assert_eq!(refused.status.code(), Some(1));
    }
    if let Some(program) = compiled("c++", "examples/render.cpp", &["-std=c++17"], &folder) {
        let picture = run(Command::new(&program).arg(&good).arg("4")).stdout;
        assert!(picture.starts_with(b"P6\n192 144\n255\n"));
        let pixels = &picture[15..];
        assert_eq!(pixels.len(), 192 * 144 * 3);
        assert!(pixels.iter().any(|&byte| byte > 128) && pixels.iter().any(|&byte| byte < 128));
    }
}
