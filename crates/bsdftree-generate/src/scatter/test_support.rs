//! What several test modules share: random directions, and a comparison of samples with an integrand on a hemisphere.

use std::f64::consts::TAU;

use glam::DVec3;

use super::Scatter;
use crate::random::Random;

/// Uniform on the sphere.
pub fn direction(random: &mut Random) -> DVec3 {
    let z = 2.0 * random.next_f64() - 1.0;
    let (sin, cos) = (random.next_f64() * TAU).sin_cos();
    let radius = (1.0 - z * z).sqrt();
    DVec3::new(radius * cos, radius * sin, z)
}

/// Direction from polar angles in degrees.
pub fn polar(theta_deg: f64, phi_deg: f64) -> DVec3 {
    let (sin_phi, cos_phi) = phi_deg.to_radians().sin_cos();
    let (sin, cos) = theta_deg.to_radians().sin_cos();
    DVec3::new(sin * cos_phi, sin * sin_phi, cos)
}

/// Cells of a hemisphere: rings of equal projected solid angle, cut into sectors.
pub struct Cells {
    pub rings: usize,
    pub sectors: usize,
}

impl Cells {
    pub fn count(&self) -> usize {
        self.rings * self.sectors
    }

    pub fn find(&self, d: DVec3) -> usize {
        let ring = ((d.x * d.x + d.y * d.y) * self.rings as f64) as usize;
        let sector = (d.y.atan2(d.x).rem_euclid(TAU) / TAU * self.sectors as f64) as usize;
        ring.min(self.rings - 1) * self.sectors + sector.min(self.sectors - 1)
    }

    /// ∫ f cos dω over each cell on the upper (`sign` 1) or lower (−1) hemisphere: dω cos = ½ d(r²) dφ; midpoint rule.
    pub fn integrate(&self, sign: f64, n: usize, f: impl Fn(DVec3) -> f64) -> Vec<f64> {
        (0..self.count())
            .map(|cell| {
                let (ring, sector) = (cell / self.sectors, cell % self.sectors);
                let mut sum = 0.0;
                for i in 0..n {
                    for j in 0..n {
                        let square = (ring as f64 + (i as f64 + 0.5) / n as f64) / self.rings as f64;
                        let phi = TAU * (sector as f64 + (j as f64 + 0.5) / n as f64) / self.sectors as f64;
                        let radius = square.sqrt();
                        sum += f(DVec3::new(
                            radius * phi.cos(),
                            radius * phi.sin(),
                            sign * (1.0 - square).sqrt(),
                        ));
                    }
                }
                sum * 0.5 * TAU / (self.count() * n * n) as f64
            })
            .collect()
    }

    /// Largest |z|, over the cells that expect 100 of `n` samples or more, of the mean sampled weight against `expected`.
    pub fn compare(
        &self,
        expected: &[f64],
        n: usize,
        mut sample: impl FnMut() -> Option<Scatter<f64>>,
        transmitted: bool,
    ) -> f64 {
        let mut sums = vec![[0.0; 2]; self.count()];
        for _ in 0..n {
            if let Some(s) = sample().filter(|s| s.transmitted == transmitted) {
                let cell = &mut sums[self.find(s.direction)];
                cell[0] += s.weight;
                cell[1] += s.weight * s.weight;
            }
        }
        let n = n as f64;
        let z = |([sum, squares], expected): (&[f64; 2], &f64)| {
            // A cell's sum is nearly normal from some tens of hits on.
            let variance = squares - sum * sum / n;
            if n * expected < 100.0 { 0.0 } else { (sum - n * expected).abs() / variance.sqrt() }
        };
        sums.iter().zip(expected).map(z).fold(0.0, f64::max)
    }
}
