//! A model of a device, and the same from plain paths.

use std::path::Path;

use bsdftree::{Part, Side};
use bsdftree_device::{Device, Unit};
use glam::DVec3;
use rayon::prelude::*;

use super::super::*;
use crate::entrance::Entrance;
use crate::layout::Layout;
use crate::options::Aperture;
use crate::path::{Outcome, Scene};
use crate::random::{N_REPLICATES, Stratified};
use crate::scatter::Spectrum;
use crate::tile::Tile;

pub const SIDES: [Side; 2] = [Side::Front, Side::Back];

pub fn rad(text: &str) -> Device {
    Device::parse_rad(text, "test.rad", Path::new("."), Unit::Meter).unwrap()
}

pub struct Setup<S> {
    pub device: Device,
    pub scene: Scene<S>,
    pub tile: Option<Tile>,
    pub entrance: Entrance,
    pub layout: Layout,
}

/// A model, and light never diffused: per side, incident cell and exitant cell of both sides (reflected, then transmitted), f.
pub struct Modelled<S> {
    pub model: Model<S>,
    pub specular: [Vec<f64>; 2],
}

impl<S: Spectrum> Setup<S> {
    pub fn new(device: Device, tiled: bool, layout: Layout) -> Self {
        let [min, max] = if tiled { device.tile.unwrap() } else { device.bounds().unwrap() };
        Self::through(device, tiled, layout, Aperture { min: min.to_array(), max: max.to_array() })
    }

    pub fn through(device: Device, tiled: bool, layout: Layout, aperture: Aperture) -> Self {
        let tile = tiled.then(|| Tile::new(aperture));
        let scene = Scene::new(&device).unwrap();
        let entrance = Entrance::new(&device, &aperture, tile.as_ref());
        Setup { scene, tile, entrance, layout, device }
    }

    pub fn sites(&self, fineness: Fineness) -> Sites {
        Sites::build(&self.scene, &self.device, &self.entrance, self.tile.as_ref(), fineness, 7).unwrap()
    }

    fn walker<'a>(&'a self, sites: &'a Sites, seed: u64) -> Walker<'a, S> {
        Walker {
            scene: &self.scene,
            sites,
            entrance: &self.entrance,
            tile: self.tile.as_ref(),
            layout: &self.layout,
            seed,
            stratified: true,
        }
    }

    pub fn model(&self, fineness: Fineness, walks: u64, exchanged: u64) -> Modelled<S> {
        self.model_at(&self.sites(fineness), walks, exchanged)
    }

    pub fn model_at(&self, sites: &Sites, walks: u64, exchanged: u64) -> Modelled<S> {
        let walker = self.walker(sites, 11);
        let n = self.layout.n_exitant();
        let mut specular = [vec![0.0; 2 * n * n], vec![0.0; 2 * n * n]];
        let rows = [0, 1].map(|k| {
            let side = SIDES[k];
            let rows: Vec<[Row; 2]> = specular[k]
                .par_chunks_mut(2 * n)
                .enumerate()
                .map(|(cell, out)| {
                    let mut deposits = Deposits::new(sites);
                    [0, 1].map(|replicate| {
                        walker.walk_cell(side, cell, 0..walks, replicate, &mut deposits, |disk, d, w| {
                            let exit = self.layout.exitant_cell(disk, [d.x, d.y]) as usize;
                            let reflected = Side::of(d.to_array()) == side;
                            out[exit + if reflected { 0 } else { n }] +=
                                w.luminance() / (2.0 * walks as f64 * self.layout.exitant_area(exit));
                        });
                        deposits.drain()
                    })
                })
                .collect();
            let [a, b]: [Vec<Row>; 2] = [0, 1].map(|r| rows.iter().map(|row| row[r].clone()).collect());
            Some([a, b])
        });
        let model = Model::new(&walker, &self.layout, rows, exchanged);
        Modelled { model, specular }
    }

    /// Rows of a side alone.
    pub fn rows(&self, sites: &Sites, side: Side, walks: u64, seed: u64) -> SideRows {
        let walker = self.walker(sites, seed);
        let rows: Vec<[Row; 2]> = (0..self.layout.n_incident())
            .into_par_iter()
            .map(|cell| {
                let mut deposits = Deposits::new(sites);
                [0, 1].map(|replicate| {
                    walker.walk_cell(side, cell, 0..walks, replicate, &mut deposits, |_, _, _| {});
                    deposits.drain()
                })
            })
            .collect();
        [0, 1].map(|r| rows.iter().map(|row| row[r].clone()).collect())
    }

    pub fn exchanged(&self, sites: &Sites, rows: [Option<SideRows>; 2], walks: u64, seed: u64) -> Model<S> {
        let walker = self.walker(sites, seed);
        Model::new(&walker, &self.layout, rows, walks)
    }

    /// f and its variance from plain paths, per incident cell and exitant cell of both sides.
    pub fn plain(&self, side: Side, paths: u64) -> [Vec<f64>; 2] {
        let n = self.layout.n_exitant();
        let rows: Vec<[Vec<f64>; 2]> = (0..n)
            .into_par_iter()
            .map(|cell| {
                let stream = (cell as u64) << 1 | u64::from(side == Side::Back);
                let mut stratified = Stratified::new(5, stream);
                let mut batches = vec![vec![0.0; 2 * n]; N_REPLICATES];
                for sample in 0..paths {
                    let mut start = stratified.start(5, stream, sample);
                    let [u, v] = start.incident;
                    let disk = self.layout.incident_disk(cell, u, v);
                    let direction = DVec3::from_array(side.opposite().direction_from_disk(disk));
                    let ray = self.entrance.through_aperture(side, direction, start.origin);
                    let out = self.scene.follow(ray.origin, direction, self.tile.as_ref(), &mut start.random);
                    if let Outcome::Left(d, w) = out {
                        let exit = self.layout.exitant_cell(disk, [d.x, d.y]) as usize;
                        let reflected = Side::of(d.to_array()) == side;
                        batches[sample as usize % N_REPLICATES][exit + if reflected { 0 } else { n }] +=
                            w.luminance() / (paths as f64 * self.layout.exitant_area(exit));
                    }
                }
                let sum = (0..2 * n).map(|k| batches.iter().map(|b| b[k]).sum::<f64>()).collect::<Vec<_>>();
                let m = N_REPLICATES as f64;
                let variance = (0..2 * n).map(|k| {
                    m / (m - 1.0) * batches.iter().map(|b| (b[k] - sum[k] / m).powi(2)).sum::<f64>()
                });
                let variance = variance.collect();
                [sum, variance]
            })
            .collect();
        [0, 1].map(|k| rows.iter().flat_map(|row| row[k].iter().copied()).collect())
    }

    /// Model and never-diffused light together, as [`plain`](Self::plain) gives them.
    pub fn total(&self, modelled: &Modelled<S>, side: Side) -> Vec<f64> {
        let n = self.layout.n_exitant();
        let mut f = modelled.specular[usize::from(side == Side::Back)].clone();
        for (k, exitant) in [side, side.opposite()].into_iter().enumerate() {
            let mean = self.mean(modelled, Part::between(side, exitant));
            for (i, row) in mean.chunks_exact(n).enumerate() {
                (0..n).for_each(|o| f[(2 * i + k) * n + o] += f64::from(row[o]));
            }
        }
        f
    }

    /// The mean of both estimates of a part, in its first channel.
    pub fn mean(&self, modelled: &Modelled<S>, part: Part) -> Vec<f32> {
        let [a, b] = modelled.model.estimates(part, 0).unwrap();
        a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect()
    }
}
