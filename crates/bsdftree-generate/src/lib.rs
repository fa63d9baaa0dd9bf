//! Ray-traces a device into a variable-resolution BSDF.
//!
//! What enters: a [`Device`](bsdftree_device::Device) and [`Options`]. What leaves: a [`Bsdf`](bsdftree::Bsdf) and a [`Report`].
//! Invariant: the result is a function of device and options alone, the same bits for any number of threads.
//!
//! ```
//! use bsdftree::{Lobes, Rank};
//! use bsdftree_device::Device;
//! use bsdftree_generate::{Layout, Options, Progress, generate};
//!
//! let mirror = Device::from_spec("mirror:reflectance=0.9")?;
//! let options = Options { samples: 64, ..Options::new(Layout::Tree { rank: Rank::Three, log2_res: 4 }) };
//! let (bsdf, report) = generate(&mirror, &options, &Progress::default())?;
//! let visible = bsdf.band("Visible").expect("generated");
//! assert!((visible.hemispherical([0.0, 0.6, 0.8], Lobes::Reflection) - 0.9).abs() < 1e-6);
//! assert_eq!(report.paths, 2 * 8 * 64);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod random;
pub mod scatter;
pub mod bvh;
pub mod tile;
pub mod path;
pub mod layout;
pub mod tally;
mod reciprocity;
mod guard;
mod reduce;
mod klems;
pub mod progress;
pub mod options;
pub mod generate;

pub use generate::{GenerateError, Report, generate};
pub use layout::Layout;
pub use options::{Aperture, Options, Sides};
pub use progress::Progress;
