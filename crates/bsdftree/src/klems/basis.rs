//! Angle bases: the hemisphere cut into rings and the rings into patches, after J. H. Klems (ASHRAE Transactions 100, 1994).
//!
//! Patches count ring by ring from the normal; patch k of a ring of n is **centred** on azimuth 2πk/n, counter-clockwise from
//! +X. A polar angle on the border between rings belongs to the outer one, an azimuth on a border to the next patch.

use std::f64::consts::{PI, TAU};

use crate::direction::Direction;

/// Most patches of a basis: a matrix of it has at most 2^32 values.
pub const MAX_PATCHES: usize = 1 << 16;

/// A ring of patches between two polar angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Polar angles between which it lies \[degree\].
    pub bounds_deg: [f64; 2],
    /// Number of patches.
    pub n_phi: u32,
}

/// A partition of the hemisphere into patches.
#[derive(Clone, Debug, PartialEq)]
pub struct Basis {
    name: String,
    rings: Vec<Ring>,
    /// Patches before each ring.
    first: Vec<usize>,
    n_patches: usize,
}

/// The bases of WINDOW and Radiance: name, borders of the rings \[degree\], patches per ring.
const KNOWN: &[(&str, &[f64], &[u32])] = &[
    (
        "LBNL/Klems Full",
        &[0., 5., 15., 25., 35., 45., 55., 65., 75., 90.],
        &[1, 8, 16, 20, 24, 24, 24, 16, 12],
    ),
    ("LBNL/Klems Half", &[0., 6.5, 19.5, 32.5, 45.5, 58.5, 71.5, 90.], &[1, 8, 12, 16, 20, 12, 8]),
    ("LBNL/Klems Half", &[0., 6.5, 19.5, 32.5, 46.5, 61.5, 76.5, 90.], &[1, 8, 12, 16, 20, 12, 4]),
    ("LBNL/Klems Quarter", &[0., 9., 27., 45., 63., 90.], &[1, 8, 12, 12, 8]),
];

impl Basis {
    /// A basis of consecutive rings.
    ///
    /// # Errors
    /// If the rings do not follow each other from 0° to 90°, a ring has no patch, or there are over [`MAX_PATCHES`].
    pub fn new(name: impl Into<String>, rings: Vec<Ring>) -> Result<Basis, String> {
        let mut border = 0.0;
        let mut n_patches = 0usize;
        let mut first = Vec::with_capacity(rings.len());
        for (k, ring) in rings.iter().enumerate() {
            let [lower, upper] = ring.bounds_deg;
            // Files round their borders to a tenth of a degree at worst.
            if !(lower - border).abs().le(&0.11)
                || upper.partial_cmp(&lower) != Some(std::cmp::Ordering::Greater)
            {
                return Err(format!(
                    "ring {} goes from {lower}° to {upper}°; expected it to begin at {border}°",
                    k + 1
                ));
            }
            if ring.n_phi == 0 {
                return Err(format!("ring {} has no patches", k + 1));
            }
            first.push(n_patches);
            n_patches += ring.n_phi as usize;
            if n_patches > MAX_PATCHES {
                return Err(format!("the basis has over {MAX_PATCHES} patches"));
            }
            border = upper;
        }
        if !(border - 90.0).abs().le(&0.11) {
            return Err(format!("the last ring ends at {border}°; expected 90°"));
        }
        Ok(Basis { name: name.into(), rings, first, n_patches })
    }

    fn known((name, borders, n_phis): &(&str, &[f64], &[u32])) -> Basis {
        let ring = |(b, &n_phi): (&[f64], &u32)| Ring { bounds_deg: [b[0], b[1]], n_phi };
        Basis::new(*name, borders.windows(2).zip(*n_phis).map(ring).collect())
            .expect("the known bases are well formed")
    }

    /// LBNL/Klems Full, 145 patches.
    pub fn full() -> Basis {
        Basis::known(&KNOWN[0])
    }

    /// LBNL/Klems Half as of 2022, 77 patches.
    pub fn half() -> Basis {
        Basis::known(&KNOWN[1])
    }

    /// LBNL/Klems Half before 2022, 73 patches.
    pub fn half_73() -> Basis {
        Basis::known(&KNOWN[2])
    }

    /// LBNL/Klems Quarter, 41 patches.
    pub fn quarter() -> Basis {
        Basis::known(&KNOWN[3])
    }

    /// The well-known bases of a name (any case), newest first. Half has two, told apart by their patch count.
    pub fn named(name: &str) -> Vec<Basis> {
        KNOWN.iter().filter(|(known, ..)| known.eq_ignore_ascii_case(name.trim())).map(Basis::known).collect()
    }

    /// Each patch of each ring split into n × n: the rings at equal projected solid angle, the first ring's single patch
    /// becoming n rings of n·n… patches so that all children of a patch have equal projected solid angle.
    ///
    /// # Errors
    /// If the result has over [`MAX_PATCHES`] patches or n is 0.
    pub fn subdivided(&self, n: u32) -> Result<Basis, String> {
        if n == 0 {
            return Err("a basis is subdivided 1 × 1 or finer, not 0 × 0".into());
        }
        let mut rings = Vec::new();
        for ring in &self.rings {
            let [lower, upper] = ring.bounds_deg.map(|t| t.to_radians().sin().powi(2));
            let border =
                |j: u32| (lower + (upper - lower) * f64::from(j) / f64::from(n)).sqrt().asin().to_degrees();
            for j in 0..n {
                let mut bounds_deg = [border(j), border(j + 1)];
                if j == 0 {
                    bounds_deg[0] = ring.bounds_deg[0];
                }
                if j + 1 == n {
                    bounds_deg[1] = ring.bounds_deg[1];
                }
                rings.push(Ring { bounds_deg, n_phi: ring.n_phi.saturating_mul(n) });
            }
        }
        let name = if n == 1 { self.name.clone() } else { format!("{} {n}x{n}", self.name) };
        Basis::new(name, rings)
    }

    /// Its name in the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The rings, from the normal outwards.
    pub fn rings(&self) -> &[Ring] {
        &self.rings
    }

    /// Number of patches.
    pub fn n_patches(&self) -> usize {
        self.n_patches
    }

    /// The patch that a direction lies in; its side does not matter.
    pub fn patch(&self, direction: Direction) -> usize {
        let [x, y, z] = direction;
        let theta_deg = x.hypot(y).atan2(z.abs()).to_degrees();
        let k = self.rings.partition_point(|r| r.bounds_deg[1] <= theta_deg).min(self.rings.len() - 1);
        let n = f64::from(self.rings[k].n_phi);
        let turn = (y.atan2(x) * n / TAU + 0.5).floor().rem_euclid(n);
        self.first[k] + turn as usize
    }

    pub(crate) fn ring_of(&self, patch: usize) -> usize {
        self.first.partition_point(|&f| f <= patch) - 1
    }

    /// The patches of a ring.
    pub(crate) fn patches_of(&self, ring: usize) -> std::ops::Range<usize> {
        self.first[ring]..self.first[ring] + self.rings[ring].n_phi as usize
    }

    /// Radii of a ring on the unit disk. Rings touch, as [`Basis::patch`] has it: each begins where the one before ends.
    pub(crate) fn radii(&self, ring: usize) -> [f64; 2] {
        let last = self.rings.len() - 1;
        let outer = |k: usize| if k == last { 1.0 } else { self.rings[k].bounds_deg[1].to_radians().sin() };
        [if ring == 0 { 0.0 } else { outer(ring - 1) }, outer(ring)]
    }

    /// Azimuths between which a patch lies \[rad\], the first may be negative.
    pub(crate) fn azimuths(&self, patch: usize) -> [f64; 2] {
        let ring = self.ring_of(patch);
        let step = TAU / f64::from(self.rings[ring].n_phi);
        [-0.5, 0.5].map(|half| step * ((patch - self.first[ring]) as f64 + half))
    }

    /// Projected solid angle of a patch \[sr\].
    pub fn projected_solid_angle(&self, patch: usize) -> f64 {
        let ring = &self.rings[self.ring_of(patch)];
        let [lower, upper] = ring.bounds_deg.map(|t| t.to_radians().cos().powi(2));
        PI * (lower - upper) / f64::from(ring.n_phi)
    }

    /// A point of the unit disk in a patch, uniform in projected solid angle for uniform (u, v) in \[0, 1)².
    pub fn disk_point(&self, patch: usize, u: f64, v: f64) -> [f64; 2] {
        let k = self.ring_of(patch);
        let ring = &self.rings[k];
        let [lower, upper] = ring.bounds_deg.map(|t| t.to_radians().sin().powi(2));
        let r = (lower + (upper - lower) * u).sqrt();
        let phi = TAU / f64::from(ring.n_phi) * ((patch - self.first[k]) as f64 + v - 0.5);
        [r * phi.cos(), r * phi.sin()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Side;

    fn all() -> Vec<Basis> {
        let mut bases = vec![Basis::full(), Basis::half(), Basis::half_73(), Basis::quarter()];
        bases.push(Basis::full().subdivided(2).unwrap());
        bases.push(Basis::full().subdivided(4).unwrap());
        bases
    }

    #[test]
    fn known_bases_have_their_patches() {
        let counts: Vec<_> = all().iter().map(Basis::n_patches).collect();
        assert_eq!(counts, [145, 77, 73, 41, 580, 2320]);
        assert_eq!(Basis::named("lbnl/klems half").len(), 2);
        assert!(Basis::named("LBNL/Shirley-Chiu").is_empty());
    }

    #[test]
    fn patches_cover_the_hemisphere() {
        for basis in all() {
            let sum: f64 = (0..basis.n_patches()).map(|k| basis.projected_solid_angle(k)).sum();
            assert!((sum - PI).abs() < 1e-12, "{}: {sum}", basis.name());
        }
    }

    #[test]
    fn points_of_a_patch_lie_in_it() {
        for basis in all() {
            for k in 0..basis.n_patches() {
                for (u, v) in [(0.5, 0.5), (0.01, 0.99), (0.99, 0.01)] {
                    let d = Side::Front.direction_from_disk(basis.disk_point(k, u, v));
                    assert_eq!(basis.patch(d), k, "{} patch {k}", basis.name());
                }
            }
        }
    }

    #[test]
    fn broken_rings_are_refused() {
        let ring = |a, b, n_phi| Ring { bounds_deg: [a, b], n_phi };
        assert!(Basis::new("gap", vec![ring(0., 5., 1), ring(10., 90., 8)]).is_err());
        assert!(Basis::new("short", vec![ring(0., 5., 1)]).is_err());
        assert!(Basis::new("empty", vec![]).is_err());
        assert!(Basis::new("no patch", vec![ring(0., 90., 0)]).is_err());
        assert!(Basis::new("huge", vec![ring(0., 90., u32::MAX)]).is_err());
        assert!(Basis::new("nan", vec![ring(0., f64::NAN, 1)]).is_err());
    }
}
