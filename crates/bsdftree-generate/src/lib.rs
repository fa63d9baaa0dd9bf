//! Ray-traces a device into a variable-resolution BSDF.
//!
//! What enters: a [`Device`](bsdftree_device::Device) and [`Options`]. What leaves: a [`Bsdf`](bsdftree::Bsdf), its standard errors and a [`Report`].
//! Invariant: the result is a function of device and options alone, the same bits for any number of threads.
//!
//! ```
//! use bsdftree::{Lobes, Rank};
//! use bsdftree_device::Device;
//! use bsdftree_generate::{Layout, Options, Progress, generate};
//!
//! let mirror = Device::from_spec("mirror:reflectance=0.9")?;
//! let options = Options { samples: 64, ..Options::new(Layout::Tree { rank: Rank::Three, log2_res: 4 }) };
//! let generated = generate(&mirror, &options, &Progress::default())?;
//! let visible = generated.bsdf.band("Visible").expect("generated");
//! assert!((visible.hemispherical([0.0, 0.6, 0.8], Lobes::Reflection) - 0.9).abs() < 1e-6);
//! assert_eq!(generated.report.paths, 2 * 8 * 64);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod random;
pub mod spectra;
pub mod scatter;
pub mod bvh;
pub mod tile;
pub mod path;
pub mod layout;
pub mod tally;
pub mod bands;
pub mod options;
mod fold;
mod entrance;
mod diffuse;
mod reciprocity;
mod pyramid;
mod reduce;
mod errors;
mod totals;
mod guard;
mod correction;
pub mod schedule;
pub mod progress;
mod estimate;
mod counts;
mod checkpoint;
mod count;
mod geometry;
pub mod generate;
mod each_band;

pub use bands::{Band, BandError};
pub use checkpoint::CheckpointError;
pub use each_band::generate_bands;
pub use generate::{BandReport, GenerateError, Generated, Report, generate};
pub use layout::Layout;
pub use options::{Aperture, Options, Sides};
pub use progress::{Progress, Resumed};
pub use schedule::Stop;
pub use totals::Totals;
