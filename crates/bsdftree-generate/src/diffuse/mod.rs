//! Reuse of diffuse vertices: light that meets a diffuse surface forgets where it came from.
//!
//! What leaves a device is what was never diffused, f_spec, and what was. The second part factorises over sites s, patches of
//! surface on one side each:
//!
//! C(i, o) = Σ_s \[P_i (I − K)⁻¹\](s) · 𝒜 A_o(s) / (π a_s)
//!
//! with walks that are never diffused:
//! * P_i(s): light of incident cell i that is diffused for the first time and sent out from s (albedo included), as a
//!   fraction of the light through the aperture of area 𝒜. A walk lays it down wherever it meets a diffuse surface, on
//!   both sides if that is translucent, and goes on by what is not diffuse.
//! * K(s, s′): light sent out from s′ for unit light sent out from s, which starts evenly over s, cosine-distributed.
//! * A_o(s): light that arrives at s, for light sent back from exitant cell o, over n²: since basic radiance L/n² keeps
//!   along a ray and reflectance is the same both ways, unit light sent out from s, whose radiance is 1/(π a_s), leaves into o by
//!   the fraction Ω 𝒜 A_o(s) / (π a_s), Ω being the projected solid angle of o. A way that is not reciprocal carries the ratio
//!   (`reversal`).
//!
//! What is kept: a site sends out light evenly over its area. So C is the diffuse part but for how light varies within
//! patches, which `partition` keeps small, and what that is off is for full paths to correct, C being their control variate.
//! Two replicates P¹A², P²A¹ are independent in P and A, so that their mean is right on the diagonal too, and their
//! difference tells the variance, K's included.
//!
//! Few sites do: with 20 to 60 of them blinds and grooves that repeat are wrong by 4e-4 of their light, all pairs of directions
//! summed up. More sites are noisier: of n walks from each cell and m sites, the error of a pair of cells is about √m/n.
//!
//! Source: instant radiosity's reuse of vertices (A. Keller, SIGGRAPH 1997) and bidirectional path tracing; the projection onto
//! patches is Galerkin radiosity's (H. Zatz, SIGGRAPH 1993). Deviation: directions at both ends, nothing in between is drawn.

mod deposit;
mod interreflection;
mod model;
mod partition;
mod pilot;
mod points;
mod residual;
mod reuse;
mod sites;
mod spread;
mod walk;
#[cfg(test)]
mod tests;

pub(crate) use deposit::{Deposits, Row as Laid, Walker};
pub(crate) use model::{Model, SideRows};
pub(crate) use reuse::{Reuse, mean_of};
#[cfg(test)]
use {
    deposit::Row,
    model::{MAX_LOG2, model_layout},
    sites::{Fineness, Sites},
};
