//! Symmetry, and what it tells of which way is up.
//!
//! Most devices are mirrored left to right: blinds, slats, fabrics. One that is mirrored top to bottom but not left to right may lie on
//! its side, or be made of upright slats: that is a guess, and said as one. If one component is mirrored left to right and
//! another top to bottom, they were turned against each other. A device upside down is as symmetric as it was: data does not tell.

use super::pairs::{difference, draw, mean};
use super::{Finding, Kind, Motion, Severity};
use crate::bsdf::{Component, Part, Scattering};
use crate::tree::Rank;

/// Below this a mirrored component is as it was, but for noise.
const ALIKE: f64 = 0.25;
/// Above this it is another.
const OTHER: f64 = 0.15;

/// How much a component changes when the device is moved: flux-weighted means of |a − b|/(a + b).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Symmetry {
    /// The component.
    pub part: Part,
    /// Mirrored left to right.
    pub left_right: f64,
    /// Mirrored top to bottom.
    pub top_bottom: f64,
    /// Turned by 90°.
    pub quarter_turn: f64,
}

impl Symmetry {
    /// Whether it is mirrored left to right only, or top to bottom only.
    fn axis(&self) -> Option<Axis> {
        let [x, y] = [self.left_right, self.top_bottom];
        match () {
            () if y > OTHER && x < ALIKE * y => Some(Axis::LeftRight),
            () if x > OTHER && y < ALIKE * x => Some(Axis::TopBottom),
            () => None,
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Axis {
    LeftRight,
    TopBottom,
}

/// Of a component; `None` if its kind of data or its darkness makes it symmetric.
pub(super) fn symmetry(component: &Component, part: Part) -> Option<Symmetry> {
    let function = &component.luminance;
    if matches!(function, Scattering::Tree(tree) if tree.rank() == Rank::Three) {
        return None;
    }
    let pairs = draw(function, part);
    let change = |motion: Motion| {
        mean(&pairs, |pair| {
            difference(pair.value, function.eval(motion.of(pair.incident), motion.of(pair.exitant), false))
        })
    };
    (!pairs.is_empty()).then(|| Symmetry {
        part,
        left_right: change(Motion::MirrorX),
        top_bottom: change(Motion::MirrorY),
        quarter_turn: change(Motion::QuarterTurn),
    })
}

pub(super) fn finding(symmetries: &[Symmetry]) -> Option<Finding> {
    let of = |axis| symmetries.iter().find(|s| s.axis() == Some(axis));
    match (of(Axis::LeftRight), of(Axis::TopBottom)) {
        (Some(a), Some(b)) => {
            let message = format!(
                "{} is mirrored left to right ({:.0} % change), {} top to bottom ({:.0} %): one of them is turned by 90°",
                a.part.file_name(),
                100.0 * a.left_right,
                b.part.file_name(),
                100.0 * b.top_bottom,
            );
            let advice =
                "turn one of them: Bsdf.select(), then `bsdftree convert --rotate 90` and `bsdftree merge`";
            Some(
                Finding::new(Kind::Orientation, Severity::Warning, message, advice)
                    .of(b.part)
                    .by(b.left_right),
            )
        }
        (None, Some(b)) => {
            let message = format!(
                "a guess: in {} mirroring top to bottom changes {:.0} %, left to right {:.0} %, so slats or grooves run upright, or the \
                 device lies on its side",
                b.part.file_name(),
                100.0 * b.top_bottom,
                100.0 * b.left_right,
            );
            let advice = "compare with the device; `bsdftree convert --rotate 90` turns it";
            Some(Finding::new(Kind::Orientation, Severity::Note, message, advice).of(b.part).by(b.left_right))
        }
        _ => None,
    }
}
