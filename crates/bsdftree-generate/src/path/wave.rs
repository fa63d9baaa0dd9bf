//! Many paths at once, ray by ray.
//!
//! Enters: where paths start. Leaves: how each ended. Invariant: what becomes of a path depends on its own departure alone.
//! A processor works ahead of itself until it guesses a branch wrong. Of paths one after another, each step waits for
//! the step before; of a wave of paths it need not, and rays that meet something are told from those that leave without a
//! branch. Source: S. Laine, T. Karras, T. Aila, "Megakernels considered harmful: wavefront path tracing on GPUs",
//! HPG 2013. Deviation: a wave is not filled up while it lasts, as all its paths being at the same bounce makes branches easier
//! to guess.

use glam::DVec3;

use super::{Outcome, Path, Scene};
#[cfg(target_arch = "x86_64")]
use crate::bvh::Avx2;
use crate::bvh::{Kernel, Portable, Simd};
use crate::random::Random;
use crate::scatter::Spectrum;
use crate::tile::Tile;

/// Paths in a wave: enough to forget the few that bounce for long, few enough for the cache next to the core.
const WAVE: usize = 128;

/// Where a path starts, and how.
#[derive(Clone, Debug)]
pub struct Departure<T> {
    /// From where \[m\].
    pub origin: DVec3,
    /// Unit vector along travel.
    pub direction: DVec3,
    /// All that is random about it.
    pub random: Random,
    /// What the caller wants to know when it ends.
    pub tag: T,
}

struct Traveller<S, T> {
    path: Path<S>,
    random: Random,
    tag: T,
}

impl<S: Spectrum> Scene<S> {
    /// [`Scene::follow`] for each of many departures, about a sixth faster. Tells of every end with the tag of its departure, in
    /// an order that depends on nothing but the departures.
    #[inline]
    pub fn follow_all<T: Copy>(
        &self,
        departures: impl Iterator<Item = Departure<T>>,
        tile: Option<&Tile>,
        ended: impl FnMut(T, Outcome<S>),
    ) {
        match self.bvh.simd() {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the tree names only what the processor has.
            Simd::Avx2 => unsafe { self.follow_all_avx2(departures, tile, ended) },
            // SAFETY: the portable kernel needs nothing.
            _ => unsafe { self.follow_all_by::<Portable, T>(departures, tile, ended) },
        }
    }

    /// # Safety
    /// The processor must have AVX2 and FMA.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    unsafe fn follow_all_avx2<T: Copy>(
        &self,
        departures: impl Iterator<Item = Departure<T>>,
        tile: Option<&Tile>,
        ended: impl FnMut(T, Outcome<S>),
    ) {
        // SAFETY: this function has the features of the kernel.
        unsafe { self.follow_all_by::<Avx2, T>(departures, tile, ended) }
    }

    /// # Safety
    /// The processor must have the features `K` names.
    #[inline(always)]
    unsafe fn follow_all_by<K: Kernel, T: Copy>(
        &self,
        mut departures: impl Iterator<Item = Departure<T>>,
        tile: Option<&Tile>,
        mut ended: impl FnMut(T, Outcome<S>),
    ) {
        let mut wave: Vec<Traveller<S, T>> = Vec::with_capacity(WAVE);
        let mut hits = [None; WAVE];
        // Travellers under way; those of them whose ray did not leave the device.
        let (mut alive, mut met) = ([0; WAVE], [0; WAVE]);
        loop {
            wave.clear();
            while wave.len() < WAVE
                && let Some(Departure { origin, direction, random, tag }) = departures.next()
            {
                alive[wave.len()] = wave.len();
                wave.push(Traveller { path: Path::new(origin, direction), random, tag });
            }
            let mut n_alive = wave.len();
            if n_alive == 0 {
                return;
            }
            while n_alive > 0 {
                let (mut n_met, mut n_left) = (0, 0);
                for i in 0..n_alive {
                    let k = alive[i];
                    // SAFETY: passed on to the caller.
                    let hit = unsafe { self.bvh.closest_by::<K>(&wave[k].path.ray) };
                    hits[k] = hit;
                    // Written to both lists and kept in one: a branch would be guessed wrong half the time.
                    met[n_met] = k;
                    alive[n_left] = k;
                    let stays = hit.is_some() | tile.is_some();
                    n_met += usize::from(stays);
                    n_left += usize::from(!stays);
                }
                for &k in &alive[..n_left] {
                    let Traveller { path, tag, .. } = &wave[k];
                    ended(*tag, Outcome::Left(path.ray.direction, path.weight));
                }
                n_alive = 0;
                for &k in &met[..n_met] {
                    let Traveller { path, random, tag } = &mut wave[k];
                    match self.advance(path, hits[k], tile, random) {
                        Some(outcome) => ended(*tag, outcome),
                        None => {
                            alive[n_alive] = k;
                            n_alive += 1;
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use bsdftree_device::Device;

    use super::*;

    const COUNT: u64 = 3 * WAVE as u64 + 17;

    fn departures(device: &Device) -> Vec<Departure<u64>> {
        let [low, high] = device.bounds().unwrap();
        let start = |tag| {
            let mut random = Random::new(5, 0, tag);
            let [x, y, a, b] = [(); 4].map(|()| random.next_f64());
            let direction = DVec3::new(a - 0.5, b - 0.5, -0.5).normalize();
            let origin = low + DVec3::new(x, y, 1.0) * (high - low) - direction * 1e-6;
            Departure { origin, direction, random, tag }
        };
        (0..COUNT).map(start).collect()
    }

    #[test]
    fn a_path_of_a_wave_ends_as_it_does_alone_to_the_bit() {
        for (spec, tiled) in [("blinds", false), ("sawtooth", true), ("prism:transmittance=0.5", true)] {
            let device = Device::from_spec(spec).unwrap();
            let tile = device
                .tile
                .filter(|_| tiled)
                .map(|[min, max]| Tile::new(crate::Aperture { min: min.to_array(), max: max.to_array() }));
            let built = Scene::<DVec3>::new(&device).unwrap();
            for simd in [Simd::Portable, Simd::Avx2] {
                let Some(bvh) = built.bvh.clone().with_simd(simd) else { continue };
                let scene = Scene {
                    bvh,
                    materials: built.materials.clone(),
                    is_plain: built.is_plain,
                    volumes: built.volumes.clone(),
                    faults: built.faults.clone(),
                };
                let departures = departures(&device);
                let mut ends = vec![None; departures.len()];
                scene.follow_all(departures.iter().cloned(), tile.as_ref(), |tag, outcome| {
                    assert_eq!(ends[tag as usize].replace(outcome), None);
                });
                for (Departure { origin, direction, mut random, .. }, end) in departures.into_iter().zip(ends)
                {
                    let alone = built.follow(origin, direction, tile.as_ref(), &mut random);
                    assert_eq!(end, Some(alone), "{spec} {simd:?}");
                }
            }
        }
    }
}
