//! Radiance's function language: `.cal` files, and the formulas that primitives of a scene contain.
//!
//! In: text ([`Context::load`], [`Context::define`]) and formulas ([`Context::compile`], [`Context::function`]). Out: an
//! [`Expression`] or [`Function`] that any number of threads may evaluate, given what a ray supplies ([`Inputs`]), or an
//! error with file and line. The value depends on nothing else, and no formula can run for ever or exhaust a stack.
//!
//! Source: the reference manual of Radiance, section 2.4 "Auxiliary files", and the manual pages of `rcalc` and `icalc`;
//! every rule below was tried on `rcalc` and `rtrace`.
//!
//! ```
//! use bsdftree_device::cal::Context;
//!
//! let mut context = Context::rayinit();
//! context.enter_file("tiles.cal");
//! context.load("{ A1: size } tile(x) = floor(x / A1);\nchecks = if(mod(tile(Px) + tile(Py), 2) - .5, .2, .8);", "tiles.cal")?;
//! let checks = context.compile("checks")?;
//! assert!(checks.uses().position() && !checks.uses().direction());
//! # struct At([f64; 3]);
//! # impl bsdftree_device::cal::Inputs for At {
//! #     fn channel(&self, n: u32) -> f64 { if (7..10).contains(&n) { self.0[n as usize - 7] } else { 0.0 } }
//! #     fn argument(&self, n: u32) -> f64 { if n == 0 { 1.0 } else { 0.1 } }
//! # }
//! assert_eq!(checks.evaluate(&At([0.05, 0.12, 0.0]))?, 0.2);
//! # Ok::<(), bsdftree_device::cal::CalError>(())
//! ```
//!
//! # What Radiance does, and so do we
//! * A division by 0 and a power or library function whose result is not finite (`sqrt(-1)`, `log(0)`) have the value 0,
//!   and are counted ([`Scratch::faults`]); Radiance's renderer leaves out a pattern whose function has any. Builds of
//!   Radiance that were compiled for speed before exactness give NaN or infinity instead for all but the division.
//!   Sums and products may overflow to infinity.
//! * `if(c, a, b)` is `a` if c > 0; what is not taken is not computed. `select(n, a, b, …)` rounds n, is the number of
//!   choices for 0, and a fault beyond them. Arguments of functions are computed when first needed, once.
//! * A name that a definition takes as parameter may be called in it; pass a function by its name.
//! * `:` defines a constant: uses that follow take its value at once. Variables defined by `=` are computed once per
//!   evaluation, and uses follow redefinitions.
//! * A dividend, factor or base that is the constant 0 makes the result 0 without a look at the other operand.
//! * More arguments than a function has parameters are ignored; fewer are an error once one is needed.
//!
//! # Deviations
//! * After a fault the value may differ: in Radiance every library function around it is 0 as well.
//! * `NxP`, `CrP` and `DxA` and their like are known everywhere; Radiance knows them in the materials that set them.
//! * A `:` definition that depends on the ray is computed anew for each ray; Radiance keeps the value of the first one.
//! * `x / 49` is divided, where Radiance multiplies by a rounded 1/49, so that floor(49/49) is 1 here and 0 there.
//! * A variable that is defined by itself is an error; Radiance takes a value from before.
//! * Names longer than 127 characters are an error; Radiance cuts them off. So are numbers beyond 1.8e308 and `$0`.
//! * Parentheses nest 200 deep, a function has 100 parameters, an evaluation ends within ten million operations and 50 000
//!   calls within calls; Radiance goes on until its memory or stack is used up.
//! * `fprism_val`, a ray tracer for one kind of prism inside Radiance's library, is not there.
//!
//! Modules in the order in which data flows: `scan`, `tree`, `table`, `parse` (with `fold`), `compile` (with `library`,
//! `uses`), `program`, `machine` (with `scratch`, `builtin`, `noise`), `expression`, `context`.

mod builtin;
mod compile;
mod context;
mod error;
mod expression;
mod fold;
mod inputs;
mod library;
mod machine;
mod noise;
mod parse;
mod program;
pub mod rayinit;
mod scan;
mod scratch;
mod table;
#[cfg(test)]
mod tests;
mod tree;
mod uses;

pub use context::Context;
pub use error::{CalError, CalProblem};
pub use expression::{Expression, Expressions, Function};
pub use inputs::{Inputs, Uses};
pub use scratch::Scratch;
