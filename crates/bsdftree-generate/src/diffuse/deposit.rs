//! Light from incident cells, laid down at sites by walks without diffuse scattering.
//!
//! In: incident cells. Out: per cell and site, the mean light sent out for light that comes from the cell, and the mean light
//! that arrives, weighted as it is on its way back. Lost on no walk: what the walks leave by is told to the caller.

use std::ops::Range;

use bsdftree::Side;
use glam::DVec3;

use super::sites::Sites;
use super::walk::{Lobes, Meeting, walk};
use crate::entrance::Entrance;
use crate::layout::Layout;
use crate::path::{Outcome, Scene};
use crate::random::{N_REPLICATES, Start, Stratified};
use crate::scatter::Spectrum;
use crate::tile::Tile;

/// Keeps the random numbers of walks apart from those of paths of the same seed.
const WALKS: u64 = 0x77_616c_6b73;
const REST: u64 = 0x7265_7374;

/// What walks need to know.
pub(crate) struct Walker<'a, S> {
    pub scene: &'a Scene<S>,
    pub sites: &'a Sites,
    pub entrance: &'a Entrance,
    pub tile: Option<&'a Tile>,
    pub layout: &'a Layout,
    pub seed: u64,
    /// Whether walks start from evenly spread points, or else from independent ones.
    pub stratified: bool,
}

/// Sums over the walks of an incident cell, by site.
#[derive(Clone, Debug)]
pub(crate) struct Deposits<S> {
    sent: Vec<S>,
    arrived: Vec<S>,
    walks: u64,
}

/// Means over the walks of an incident cell, by channel and site.
#[derive(Clone, Debug, Default)]
pub(crate) struct Row {
    /// Light sent out from a site, as a fraction of the light that comes from the cell.
    pub sent: Vec<f32>,
    /// Light that arrives, divided by the squared index of the medium there.
    pub arrived: Vec<f32>,
}

impl<S: Spectrum> Deposits<S> {
    pub fn new(sites: &Sites) -> Self {
        Deposits { sent: vec![S::BLACK; sites.len()], arrived: vec![S::BLACK; sites.len()], walks: 0 }
    }

    fn add(&mut self, sites: &Sites, meeting: &Meeting<S>, [sent, arrived]: [f64; 2]) {
        let front = sites.find(meeting.hit.position, meeting.facing);
        self.sent[front] = self.sent[front] + meeting.arrived * meeting.albedo[0] * sent;
        self.arrived[front] = self.arrived[front] + meeting.arrived * (meeting.reversal * arrived);
        if meeting.albedo[1] != S::BLACK {
            let back = sites.find(meeting.hit.position, -meeting.facing);
            self.sent[back] = self.sent[back] + meeting.arrived * meeting.albedo[1] * sent;
        }
    }

    /// The means, after which nothing is left.
    pub fn drain(&mut self) -> Row {
        let scale = 1.0 / self.walks.max(1) as f64;
        let mean = |sums: &[S]| {
            (0..S::CHANNELS).flat_map(|k| sums.iter().map(move |s| (s.channel(k) * scale) as f32)).collect()
        };
        let row = Row { sent: mean(&self.sent), arrived: mean(&self.arrived) };
        self.sent.fill(S::BLACK);
        self.arrived.fill(S::BLACK);
        self.walks = 0;
        row
    }
}

impl<S: Spectrum> Walker<'_, S> {
    /// The start of walk `sample` of a stream, of which `points` are the even ones.
    #[inline]
    pub fn start(&self, points: &mut Stratified, seed: u64, stream: u64, sample: u64) -> Start {
        match self.stratified {
            true => points.start(seed, stream, sample),
            false => Start::independent(seed, stream, sample),
        }
    }

    /// Walks from an incident cell of the layout in one of [`N_REPLICATES`] scramblings. Tells `left` the incident point of the
    /// disk, the direction and the weight of each that leaves; returns how many did not end.
    pub fn walk_cell(
        &self,
        side: Side,
        cell: usize,
        walks: Range<u64>,
        replicate: usize,
        deposits: &mut Deposits<S>,
        mut left: impl FnMut([f64; 2], DVec3, S),
    ) -> u64 {
        let stream = (cell as u64) << 1 | u64::from(side == Side::Back);
        let seed = self.seed ^ WALKS;
        let mut stratified = Stratified::new(seed, stream);
        let outermost = f64::from(u8::from(self.entrance.is_outermost(side)));
        let mut lost = 0;
        deposits.walks += walks.end - walks.start;
        self.walk_rest(side, cell, &walks, replicate, deposits);
        for k in walks {
            let mut start =
                self.start(&mut stratified, seed, stream, k * N_REPLICATES as u64 + replicate as u64);
            let [u, v] = start.incident;
            let disk = self.layout.incident_disk(cell, u, v);
            let direction = DVec3::from_array(side.opposite().direction_from_disk(disk));
            let mut follow = |ray, shares| {
                walk(self.scene, self.tile, Lobes::Specular, (ray, None), &mut start.random, |meeting| {
                    deposits.add(self.sites, &meeting, shares);
                })
            };
            match follow(self.entrance.through_aperture(side, direction, start.origin), [1.0, outermost]) {
                Outcome::Left(exitant, weight) => left(disk, exitant, weight),
                Outcome::Absorbed => {}
                Outcome::Lost => lost += 1,
            }
        }
        lost
    }

    /// Light back into the device beside the aperture: only arrives.
    fn walk_rest(
        &self,
        side: Side,
        cell: usize,
        walks: &Range<u64>,
        replicate: usize,
        deposits: &mut Deposits<S>,
    ) {
        let toward = |u, v| {
            let disk = self.layout.incident_disk(cell, u, v);
            DVec3::from_array(side.opposite().direction_from_disk(disk))
        };
        let Some(every) = self.entrance.sparsity(side, toward(0.5, 0.5)) else { return };
        let rest =
            walks.start.div_ceil(every)..walks.end.div_ceil(every).max(walks.start.div_ceil(every) + 1);
        let share = (walks.end - walks.start) as f64 / (rest.end - rest.start) as f64;
        let stream = (cell as u64) << 1 | u64::from(side == Side::Back);
        let seed = self.seed ^ REST;
        let mut stratified = Stratified::new(seed, stream);
        let rims = rims(self.layout, cell);
        for k in rest {
            let mut start =
                self.start(&mut stratified, seed, stream, k * N_REPLICATES as u64 + replicate as u64);
            let [(u, by_u), (v, by_v)] = [0, 1].map(|k| rims[k].crowded(start.incident[k]));
            let direction = toward(u, v);
            if let Some((ray, flux)) = self.entrance.through_rest(side, direction, start.origin) {
                walk(self.scene, self.tile, Lobes::Specular, (ray, None), &mut start.random, |meeting| {
                    deposits.add(self.sites, &meeting, [0.0, flux * share * by_u * by_v]);
                });
            }
        }
    }
}

/// Which end of a coordinate of an incident cell is at grazing incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rim {
    Neither,
    Lower,
    Upper,
}

fn rims(layout: &Layout, cell: usize) -> [Rim; 2] {
    let grazes = |u: f64, v: f64| {
        let [x, y] = layout.incident_disk(cell, u, v);
        x * x + y * y > 1.0 - 1e-9
    };
    let rim = |ends: [bool; 2]| match ends {
        [true, false] => Rim::Lower,
        [false, true] => Rim::Upper,
        _ => Rim::Neither,
    };
    [rim([grazes(0.0, 0.5), grazes(1.0, 0.5)]), rim([grazes(0.5, 0.0), grazes(0.5, 1.0)])]
}

impl Rim {
    /// A coordinate drawn more often towards the rim, with what its weight takes for it: the flux through an upright face goes
    /// there as the inverse root of the distance from the rim, which is just taken off.
    fn crowded(self, u: f64) -> (f64, f64) {
        match self {
            Rim::Neither => (u, 1.0),
            Rim::Lower => (u * u, 2.0 * u),
            Rim::Upper => (1.0 - (1.0 - u).powi(2), 2.0 * (1.0 - u)),
        }
    }
}
