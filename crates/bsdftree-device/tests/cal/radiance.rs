//! Radiance's programs as the oracle: `rcalc`, and `rtrace` for what only the renderer has.

use bsdftree_testing::radiance::{doubles, run};

/// All outputs of a file for rcalc; `None` if it stops with an error.
pub fn rcalc(text: &str) -> Option<Vec<f64>> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("case.cal"), text).unwrap();
    run("rcalc", folder.path(), &["-n", "-od", "-f", "case.cal"], b"").ok().map(|bytes| doubles(&bytes))
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
    let octree = run("oconv", path, &["case.rad"], b"").ok()?;
    std::fs::write(path.join("case.oct"), octree).unwrap();
    let input: String = rays
        .iter()
        .map(|ray| {
            let [x, y, z] = ray.origin;
            let [dx, dy, dz] = ray.direction;
            format!("{x} {y} {z} {dx} {dy} {dz}\n")
        })
        .collect();
    let bytes = run("rtrace", path, &["-h", "-fad", "-ab", "0", "-ov", "case.oct"], input.as_bytes()).ok()?;
    Some(doubles(&bytes).chunks_exact(3).map(|rgb| rgb[0]).collect())
}
