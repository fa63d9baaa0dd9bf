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

/// Where the light from one direction goes.
pub struct TreeLobe<'a>(Inner<'a>);

enum Inner<'a> {
    /// With its total.
    Rank4(SliceRef<'a>, f64),
    /// With its total, and cosine and sine of the azimuth that exitant directions are turned by.
    Rank3(SliceRef<'a>, f64, [f64; 2]),
    /// With the azimuth of the incident direction.
    Rank3Reverse(Arc<Rank3Reverse>, f64),
}

impl Tree {
    /// The tree for light from `incident`; reversed: for light that this tree has arriving from everywhere and leaving to
    /// `incident`.
    pub fn lobe(&self, incident: Direction, reversed: bool) -> TreeLobe<'_> {
        let forward = || {
            let cell = self.incident_cell(incident);
            (self.slices.slice(&self.arena, cell), self.total(cell))
        };
        TreeLobe(match (self.rank(), reversed) {
            (Rank::Four, false) => {
                let (slice, total) = forward();
                Inner::Rank4(slice, total)
            }
            (Rank::Four, true) => return self.reversed().lobe(incident, false),
            (Rank::Three, false) => {
                let (slice, total) = forward();
                Inner::Rank3(slice, total, azimuth(incident))
            }
            (Rank::Three, true) => {
                let slice = self.rank3_reverse(incident[0].hypot(incident[1]).min(1.0));
                Inner::Rank3Reverse(slice, incident[1].atan2(incident[0]))
            }
        })
    }
}

impl TreeLobe<'_> {
    /// Directional-hemispherical total.
    #[inline]
    pub fn total(&self) -> f64 {
        match &self.0 {
            Inner::Rank4(_, total) | Inner::Rank3(_, total, _) => *total,
            Inner::Rank3Reverse(slice, _) => slice.total(),
        }
    }

    /// A point of the exitant disk chosen in proportion to the projected-solid-angle-weighted BSDF, and the BSDF there
    /// \[1/sr\]; `None` where it is black. One number in \[0, 1), or two.
    pub fn sample(&self, u: f64, v: Option<f64>) -> Option<([f64; 2], f64)> {
        match &self.0 {
            Inner::Rank4(slice, _) => {
                let (square, value) = slice.sample(u, v)?;
                Some((disk_from_square(square), value))
            }
            Inner::Rank3(slice, _, azimuth) => {
                let (square, value) = slice.sample(u, v)?;
                Some((turned(disk_from_square(square), *azimuth), value))
            }
            Inner::Rank3Reverse(slice, phi) => slice.sample(phi - PI, u, v),
        }
    }
}
