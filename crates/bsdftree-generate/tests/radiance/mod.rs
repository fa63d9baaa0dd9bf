//! Radiance's `rtrace` and the folder of real files, as tests of materials need them.
#![allow(dead_code)]

pub use bsdftree_testing::radiance::programs;
use bsdftree_testing::radiance::{doubles, printed};
pub use bsdftree_testing::real_file;
use glam::DVec3;

/// Red, green and blue that rtrace sees along rays (origin, direction of travel) into a scene.
pub fn rtrace(scene: &str, options: &str, rays: &[(DVec3, DVec3)]) -> Vec<DVec3> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.rad"), scene).unwrap();
    let octree = printed("oconv", folder.path(), &["scene.rad"], b"");
    std::fs::write(folder.path().join("scene.oct"), octree).unwrap();
    let line = |&(o, d): &(DVec3, DVec3)| format!("{} {} {} {} {} {}\n", o.x, o.y, o.z, d.x, d.y, d.z);
    let mut arguments = vec!["-h", "-w-", "-fad", "-ov"];
    arguments.extend(options.split_whitespace());
    arguments.push("scene.oct");
    let input: String = rays.iter().map(line).collect();
    let bytes = printed("rtrace", folder.path(), &arguments, input.as_bytes());
    doubles(&bytes).chunks_exact(3).map(DVec3::from_slice).collect()
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
