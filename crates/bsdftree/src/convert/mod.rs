//! One BSDF from another: matrices from trees, trees from matrices and functions, turned, mirrored, merged and stacked.
//!
//! In: a [`Bsdf`] of any kind, all bands and components, coloured or not. Out: another, over an angle basis ([`Bsdf::to_klems`]), as
//! trees ([`Bsdf::to_tree`], [`Bsdf::from_function`]), of the device in another position ([`Bsdf::turned`]), of several ([`merge()`], [`stack()`]). Values are means by projected solid angle over cells and patches, from the area that they share, cut out
//! exactly: nothing is sampled, and totals are kept. What detail is lost is [`relative_l1`].
//!
//! Source: Radiance's bsdf2klems and bsdf2ttree, which sample.

mod asker;
mod distance;
mod function;
mod grow;
mod isotropic;
mod matrix;
mod merge;
mod operator;
mod overlap;
mod polygon;
mod refine;
mod rows;
mod scout;
mod stack;
mod absorptance;
mod symmetry;
mod tree;
mod xyz;

use std::sync::Arc;

use thiserror::Error;

pub use absorptance::{Absorptance, layer_absorptances};
pub use distance::{L1, relative_l1};
pub use function::FunctionError;
pub(crate) use grow::squared_radii;
pub use merge::merge;
pub use stack::{MAX_STACK_LOG2_RES, StackDomain, default_domain, stack};
pub use symmetry::Mirror;
pub(crate) use symmetry::{mirrored, permuted, quarter_turned};
pub use xyz::from_channels;
pub(crate) use xyz::{channels, combined};

use crate::bsdf::{Band, Bsdf, Component, Part, Scattering};
use crate::klems::Basis;
use crate::tree::{Rank, TreeError};

/// Finest resolution of a tree that is made: 2^10 cells per axis.
pub const MAX_LOG2_RES: u32 = overlap::MAX_LEVEL;

/// What cannot be converted.
#[derive(Debug, Error)]
pub enum ConvertError {
    /// A tree that cannot be built.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// A resolution that is not to be had.
    #[error("a resolution of 2^{0} cells per axis; expected 2^1 to 2^{MAX_LOG2_RES}")]
    Resolution(u32),
    /// A tolerance that is none.
    #[error("a tolerance of {0}; expected a relative error in [0, 1)")]
    Tolerance(f64),
    /// A turn by what is no angle.
    #[error("a turn by {0} rad; expected a finite angle")]
    Azimuth(f64),
    /// Nothing to stack or merge.
    #[error("no BSDFs; expected one or more")]
    NoLayers,
    /// Layers that know nothing of the same light.
    #[error("the layers have no spectral band in common; see their bands by `bsdftree info`")]
    NoCommonBand,
    /// A resolution at which trees are not stacked.
    #[error("trees are not stacked at 2^{0} cells per axis; expected 2^1 to 2^{MAX_STACK_LOG2_RES}")]
    StackResolution(u32),
    /// Layers that keep light between them for ever.
    #[error(
        "light between two layers never leaves: they reflect all of it; check their energy by `bsdftree check`"
    )]
    Trapped,
    /// Values that cannot be.
    #[error("{0}")]
    Values(String),
    /// Functions of different kinds.
    #[error("{part} of {place} is {found}, what comes before is {expected}: convert one of them first")]
    Kinds {
        /// Which BSDF.
        place: String,
        /// Which component.
        part: &'static str,
        /// What it is.
        found: String,
        /// What the others are.
        expected: String,
    },
    /// A component that is there twice.
    #[error("{part} of the band {band} is in {place} and in one before it: choose which one to take")]
    Twice {
        /// Which BSDF.
        place: String,
        /// Which component.
        part: &'static str,
        /// Its band.
        band: String,
    },
    /// A tree of one rank from one of the other.
    #[error(
        "a tree of rank {from} does not become one of rank {}; convert it to a Klems basis first, or generate it anew",
        7 - from
    )]
    Ranks {
        /// 3 or 4.
        from: usize,
    },
}

/// What a tree is to be like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeOptions {
    /// 3 for isotropic functions, 4 for any.
    pub rank: Rank,
    /// At most 2^log2_res cells per axis, 1 to [`MAX_LOG2_RES`].
    pub log2_res: u32,
    /// Relative L1 error that joining cells may add, in \[0, 1); 0 joins equal values only.
    pub tolerance: f64,
}

impl TreeOptions {
    fn validated(self) -> Result<TreeOptions, ConvertError> {
        if !(1..=MAX_LOG2_RES).contains(&self.log2_res) {
            return Err(ConvertError::Resolution(self.log2_res));
        }
        if !(0.0..1.0).contains(&self.tolerance) {
            return Err(ConvertError::Tolerance(self.tolerance));
        }
        Ok(self)
    }
}

impl Bsdf {
    /// The BSDF as matrices over an angle basis, incident and exitant.
    ///
    /// # Errors
    /// If the colour of its trees does not fit together in memory.
    pub fn to_klems(&self, basis: &Arc<Basis>) -> Result<Bsdf, ConvertError> {
        self.mapped(|component| xyz::mapped(component, |f| Ok(Scattering::Matrix(matrix::matrix(f, basis)))))
    }

    /// The BSDF as trees. An isotropic one (rank 3) has both transmissions, since Radiance samples none that it must reverse.
    ///
    /// # Errors
    /// If the options are out of range, or a tree is of the other rank.
    pub fn to_tree(&self, options: &TreeOptions) -> Result<Bsdf, ConvertError> {
        let TreeOptions { rank, log2_res, tolerance } = options.validated()?;
        let convert = |f: &Scattering| Ok(tree::tree(f, rank, log2_res, tolerance)?.into());
        let mut bsdf = self.mapped(|component| xyz::mapped(component, convert))?;
        if rank == Rank::Three {
            for (band, made) in self.bands.iter().zip(&mut bsdf.bands) {
                for part in [Part::TransmissionFront, Part::TransmissionBack] {
                    let Some(other) = absent_transmission(band, part) else { continue };
                    let Some(reversed) = reversed(other) else { continue };
                    made.insert(part, xyz::mapped(&reversed, convert)?);
                }
            }
        }
        Ok(bsdf)
    }

    /// A copy with every component replaced.
    fn mapped(
        &self,
        f: impl Fn(&Component) -> Result<Component, ConvertError>,
    ) -> Result<Bsdf, ConvertError> {
        let mut bsdf = Bsdf { header: self.header.clone(), bands: Vec::new() };
        for band in &self.bands {
            let mut made = Band::new(&band.name);
            for (part, component) in band.components() {
                made.insert(part, f(component)?);
            }
            bsdf.bands.push(made);
        }
        Ok(bsdf)
    }
}

/// The transmission that answers for one that is absent.
fn absent_transmission(band: &Band, part: Part) -> Option<&Component> {
    match band.answering(part.incident_side(), part.exitant_side()) {
        Some((component, true)) => Some(component),
        _ => None,
    }
}

/// Matrices for light going the other way.
fn reversed(component: &Component) -> Option<Component> {
    let reversed = |f: &Scattering| match f {
        Scattering::Matrix(matrix) => Some(Scattering::from(matrix.reversed())),
        Scattering::Tree(_) => None,
    };
    let luminance = reversed(&component.luminance)?;
    let chroma = match &component.chroma {
        None => None,
        Some([a, b]) => Some([reversed(a)?, reversed(b)?]),
    };
    Some(Component { luminance, chroma })
}
