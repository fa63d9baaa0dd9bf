//! Variable-resolution BSDFs: tensor trees and Klems matrices, evaluated, sampled, checked, read and written.
//!
//! What enters: WINDOW 6 XML ([`xml`]), grids ([`Tree::from_grid`]), matrices ([`Matrix::new`]). What leaves: values, samples,
//! densities and totals for directions ([`Band`]), findings ([`check`]), and XML. Directions are unit vectors `[x, y, z]` away from
//! the surface, the incident one too; +Z is the front, the room. Values are \[1/sr\] without a cosine. Everything is thread-safe.
//!
//! ```
//! use bsdftree::xml::{self, Strictness};
//! use bsdftree::direction::direction_from_polar;
//! use bsdftree::{Bsdf, Component, Lobes, Part, Rank, Tree};
//!
//! // Twice as bright towards +X as towards −X.
//! let values: Vec<f32> = (0..16).map(|k| if k >> 1 & 1 == 1 { 0.2 } else { 0.1 }).collect();
//! let mut bsdf = Bsdf::default();
//! let tree = Tree::from_grid(Rank::Four, &values)?;
//! bsdf.band_mut("Visible").insert(Part::ReflectionBack, Component::grey(tree.into()));
//!
//! let mut text = Vec::new();
//! xml::write(&bsdf, &mut text)?;
//! let (bsdf, repairs) = xml::read(&text, Strictness::Strict)?;
//! assert!(repairs.is_empty());
//!
//! let visible = bsdf.band("Visible").expect("written above");
//! let incident = direction_from_polar(0.5, 1.6);
//! assert_eq!(visible.eval(incident, [0.6, 0.0, 0.8]), f64::from(0.2f32));
//! assert!((visible.hemispherical(incident, Lobes::All) - 0.15 * std::f64::consts::PI).abs() < 1e-8);
//! let sample = visible.sample(incident, 0.25, None, Lobes::All);
//! assert_eq!(sample.pdf, visible.pdf(incident, sample.exitant, Lobes::All));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | Radiance's BSDF library | here |
//! |---|---|
//! | `SDloadFile`, `SDfreeBSDF` | [`file::read`]: XML ([`xml`]) or the binary twin ([`binary`]); dropping the [`Bsdf`] |
//! | `SDevalBSDF` | [`Band::eval`], [`Band::eval_xyz`] |
//! | `SDsampBSDF` | [`Band::sample`], with its density [`Band::pdf`] |
//! | `SDdirectHemi` | [`Band::hemispherical`] |
//! | `SDmultiSamp` | numbers of yours: stratified ones give stratified directions |
//! | `SDcacheFile`, `SDfreeCache` | the [`Bsdf`] itself: read it once, share it between threads |
//! | one call for each pair | [`Band::eval_many`], [`Band::sample_many`] and the like, many times as fast |
//! | `SDsizeBSDF` | [`Band::projected_solid_angle`], for many pairs [`Band::projected_solid_angle_many`], [`Band::projected_solid_angle_range`] |
//! | the extracted Lambertian part | [`Scattering::lambertian`] |

mod shared;
pub mod direction;
pub mod square;
pub mod hilbert;
mod cumulative;
pub mod tree;
pub mod klems;
pub mod color;
pub mod locus;
pub mod bsdf;
pub mod cell;
pub mod query;
mod many;
pub mod convert;
pub mod reduce;
pub mod peaks;
pub mod check;
pub mod repair;

mod whole_file;
pub mod radiance_matrix;
pub mod xml;
pub mod binary;
pub mod file;

pub use bsdf::{Band, Bsdf, Component, Damage, Geometry, Header, LengthUnit, Part, Scattering};
pub use cell::Cell;
pub use direction::{Direction, Side};
pub use klems::{Basis, Matrix};
pub use query::{Lobes, Sample};
pub use tree::{Rank, Tree};
