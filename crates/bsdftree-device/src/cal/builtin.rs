//! Library functions: their names, how many arguments they need, and the values of those that are plain mathematics.
//!
//! Source: what `rcalc` and `rtrace` offer. A result that is not finite (`sqrt(-1)`, `log(0)`, `exp(1000)`) becomes 0,
//! and counts as a fault. Underflow to 0 is no fault, unlike in some builds of Radiance.

use super::noise;

/// A function that needs no definition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Builtin {
    Acos,
    Arg,
    Asin,
    Atan,
    Atan2,
    Ceil,
    Cos,
    Erf,
    Erfc,
    Exp,
    Floor,
    Fnoise3,
    Hermite,
    If,
    Log,
    Log10,
    Max,
    Min,
    Noise3,
    Noise3x,
    Noise3y,
    Noise3z,
    Rand,
    Select,
    Sin,
    Sqrt,
    Tan,
}

use Builtin::*;

/// By name, in the order of the alphabet.
const NAMES: [(&str, Builtin); 27] = [
    ("acos", Acos),
    ("arg", Arg),
    ("asin", Asin),
    ("atan", Atan),
    ("atan2", Atan2),
    ("ceil", Ceil),
    ("cos", Cos),
    ("erf", Erf),
    ("erfc", Erfc),
    ("exp", Exp),
    ("floor", Floor),
    ("fnoise3", Fnoise3),
    ("hermite", Hermite),
    ("if", If),
    ("log", Log),
    ("log10", Log10),
    ("max", Max),
    ("min", Min),
    ("noise3", Noise3),
    ("noise3x", Noise3x),
    ("noise3y", Noise3y),
    ("noise3z", Noise3z),
    ("rand", Rand),
    ("select", Select),
    ("sin", Sin),
    ("sqrt", Sqrt),
    ("tan", Tan),
];

impl Builtin {
    pub(super) fn by_name(name: &str) -> Option<Self> {
        NAMES.binary_search_by_key(&name, |&(name, _)| name).ok().map(|at| NAMES[at].1)
    }

    pub(super) fn name(self) -> &'static str {
        NAMES[self as usize].0
    }

    /// How many arguments its value always needs. More may be given.
    pub(super) fn n_needed(self) -> usize {
        match self {
            Atan2 => 2,
            Noise3 | Noise3x | Noise3y | Noise3z | Fnoise3 => 3,
            Hermite => 5,
            // `if` needs its condition; its branches are asked for when they are taken.
            _ => 1,
        }
    }

    /// The value for exactly [`Builtin::n_needed`] arguments (any number for `min` and `max`), not yet checked for being
    /// finite; `None` for `if`, `select` and `arg`, which are no plain functions of numbers.
    pub(super) fn value(self, x: &[f64]) -> Option<f64> {
        Some(match (self, x) {
            (If | Select | Arg, _) => return None,
            (Acos, &[x]) => libm::acos(x),
            (Asin, &[x]) => libm::asin(x),
            (Atan, &[x]) => libm::atan(x),
            (Atan2, &[y, x]) => libm::atan2(y, x),
            (Ceil, &[x]) => x.ceil(),
            (Cos, &[x]) => libm::cos(x),
            (Erf, &[x]) => libm::erf(x),
            (Erfc, &[x]) => libm::erfc(x),
            (Exp, &[x]) => libm::exp(x),
            (Floor, &[x]) => x.floor(),
            (Log, &[x]) => libm::log(x),
            (Log10, &[x]) => libm::log10(x),
            (Rand, &[x]) => noise::rand(x),
            (Sin, &[x]) => libm::sin(x),
            (Sqrt, &[x]) => x.sqrt(),
            (Tan, &[x]) => libm::tan(x),
            (Fnoise3, &[x, y, z]) => noise::fractal([x, y, z]),
            (Noise3x, &[x, y, z]) => noise::slope([x, y, z], 0),
            (Noise3y, &[x, y, z]) => noise::slope([x, y, z], 1),
            (Noise3z, &[x, y, z]) => noise::slope([x, y, z], 2),
            (Noise3, &[x, y, z]) => noise::smooth([x, y, z]),
            (Hermite, &[p0, p1, r0, r1, t]) => noise::hermite(p0, p1, r0, r1, t),
            (Max, &[first, ref rest @ ..]) => {
                rest.iter().rev().fold(first, |a, &b| if a < b { b } else { a })
            }
            (Min, &[first, ref rest @ ..]) => {
                rest.iter().rev().fold(first, |a, &b| if a > b { b } else { a })
            }
            _ => return None,
        })
    }
}

/// `a ^ b`, not yet checked for being finite.
pub(super) fn power(a: f64, b: f64) -> f64 {
    // The exponents that files use most need no logarithm.
    if b == 2.0 { a * a } else { libm::pow(a, b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_function_is_found_by_its_name() {
        for (name, builtin) in NAMES {
            assert_eq!(Builtin::by_name(name), Some(builtin));
            assert_eq!(builtin.name(), name);
        }
        assert_eq!(Builtin::by_name("sinh"), None);
    }

    #[test]
    fn every_plain_function_has_a_value_for_the_arguments_it_needs() {
        for (name, builtin) in NAMES {
            let is_plain = !matches!(builtin, If | Select | Arg);
            assert_eq!(builtin.value(&vec![0.5; builtin.n_needed()]).is_some(), is_plain, "{name}");
        }
    }
}
