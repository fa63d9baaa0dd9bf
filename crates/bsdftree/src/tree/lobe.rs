//! A tree for one incident direction: its total, and samples of it.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::direction::Direction;
use crate::square::disk_from_square;
use crate::tree::Tree;
use crate::tree::arena::Rank;
use crate::tree::cache::SliceRef;
use crate::tree::coordinates::{azimuth, turned};
use crate::tree::reverse::Rank3Reverse;
use crate::tree::slice::Slice;
use crate::tree::smooth::SmoothLobe;

/// Where the light from one direction goes.
pub struct TreeLobe<'a>(Inner<'a>);

enum Inner<'a> {
    /// With its total, and cosine and sine of the azimuth that exitant directions are turned by, if they are.
    Constant(SliceRef<'a, Slice>, f64, Option<[f64; 2]>),
    /// By itself, so that the others stay small.
    Smooth(Box<SmoothLobe<'a>>),
    /// With the azimuth of the incident direction.
    Rank3Reverse(Arc<Rank3Reverse>, f64),
}

impl Tree {
    /// The tree for light from `incident`; reversed: for light that this tree has arriving from everywhere and leaving to
    /// `incident`.
    pub fn lobe(&self, incident: Direction, reversed: bool) -> TreeLobe<'_> {
        let azimuth = match (self.rank(), reversed) {
            (Rank::Four, true) => return self.reversed().lobe(incident, false),
            (Rank::Three, true) => {
                let slice = self.rank3_reverse(incident[0].hypot(incident[1]).min(1.0));
                return TreeLobe(Inner::Rank3Reverse(slice, incident[1].atan2(incident[0])));
            }
            (Rank::Four, false) => None,
            (Rank::Three, false) => Some(azimuth(incident)),
        };
        TreeLobe(match &self.smooth {
            None => {
                let cell = self.incident_cell(incident);
                Inner::Constant(self.slice(cell), self.total(cell), azimuth)
            }
            Some(smooth) => {
                let incident = self.incident_coordinates(incident);
                Inner::Smooth(Box::new(smooth.lobe(&self.arena, incident, azimuth)))
            }
        })
    }
}

impl TreeLobe<'_> {
    /// Directional-hemispherical total.
    #[inline]
    pub fn total(&self) -> f64 {
        match &self.0 {
            Inner::Constant(_, total, _) => *total,
            Inner::Smooth(lobe) => lobe.total(),
            Inner::Rank3Reverse(slice, _) => slice.total(),
        }
    }

    /// A point of the exitant disk chosen in proportion to the projected-solid-angle-weighted BSDF, and the BSDF there
    /// \[1/sr\]; `None` where it is black. One number in \[0, 1), or two.
    pub fn sample(&self, u: f64, v: Option<f64>) -> Option<([f64; 2], f64)> {
        match &self.0 {
            Inner::Constant(slice, _, azimuth) => {
                let (square, value) = slice.sample(u, v)?;
                let disk = disk_from_square(square);
                Some((azimuth.map_or(disk, |azimuth| turned(disk, azimuth)), value))
            }
            Inner::Smooth(lobe) => lobe.sample(u, v),
            Inner::Rank3Reverse(slice, phi) => slice.sample(phi - PI, u, v),
        }
    }
}
