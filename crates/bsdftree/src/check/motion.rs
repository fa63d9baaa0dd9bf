//! Motions of a device about its normal that are exact in trees and in most angle bases, and what they make of directions and functions.

use crate::bsdf::Scattering;
use crate::convert::{Mirror, mirrored, permuted, quarter_turned};
use crate::direction::Direction;
use crate::klems::Matrix;
use crate::tree::Rank;

/// What becomes of a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Nothing.
    Stay,
    /// It is turned by 180° about the normal.
    HalfTurn,
    /// Left and right change places.
    MirrorX,
    /// Up and down change places.
    MirrorY,
    /// It is turned by 90°, from +X to +Y.
    QuarterTurn,
    /// It is turned back by 90°, from +Y to +X.
    QuarterBack,
}

impl Motion {
    /// All that change something.
    pub const ALL: [Motion; 5] =
        [Motion::HalfTurn, Motion::MirrorX, Motion::MirrorY, Motion::QuarterTurn, Motion::QuarterBack];

    /// Where a direction goes; it keeps its side.
    pub fn of(self, [x, y, z]: Direction) -> Direction {
        match self {
            Motion::Stay => [x, y, z],
            Motion::HalfTurn => [-x, -y, z],
            Motion::MirrorX => [-x, y, z],
            Motion::MirrorY => [x, -y, z],
            Motion::QuarterTurn => [-y, x, z],
            Motion::QuarterBack => [y, -x, z],
        }
    }

    /// The motion that undoes it.
    pub fn inverse(self) -> Motion {
        match self {
            Motion::QuarterTurn => Motion::QuarterBack,
            Motion::QuarterBack => Motion::QuarterTurn,
            other => other,
        }
    }

    /// What it does, as in “as if turned by 180°”.
    pub fn name(self) -> &'static str {
        match self {
            Motion::Stay => "left as it is",
            Motion::HalfTurn => "turned by 180° about the normal",
            Motion::MirrorX => "mirrored left to right",
            Motion::MirrorY => "mirrored top to bottom",
            Motion::QuarterTurn => "turned by 90° about the normal, right to up",
            Motion::QuarterBack => "turned by 90° about the normal, up to right",
        }
    }

    /// The function of the moved device: f′(i, o) = f(M⁻¹i, M⁻¹o).
    pub(crate) fn moved(self, function: &Scattering) -> Scattering {
        match self {
            Motion::Stay => function.clone(),
            Motion::HalfTurn => quarter_turned(function, 2),
            Motion::MirrorX => mirrored(function, Mirror::X),
            Motion::MirrorY => mirrored(function, Mirror::Y),
            Motion::QuarterTurn => quarter_turned(function, 1),
            Motion::QuarterBack => quarter_turned(function, 3),
        }
    }

    /// f′(i, o) = f(Mi, o), for what undoes itself. `None` where data knows no such motion: quarter turns, and rank 3, unless by 180°.
    pub(crate) fn incident_moved(self, function: &Scattering) -> Option<Scattering> {
        let (x, y) = match self {
            Motion::Stay => return Some(function.clone()),
            Motion::HalfTurn => (1, 1),
            Motion::MirrorX => (1, 0),
            Motion::MirrorY => (0, 1),
            Motion::QuarterTurn | Motion::QuarterBack => return None,
        };
        match function {
            Scattering::Tree(tree) => {
                // Bits of the number of a child are dimensions; isotropic data has the exitant direction relative to the incident one.
                let flipped = match (tree.rank(), self) {
                    (Rank::Four, _) => x | y << 1,
                    (Rank::Three, Motion::HalfTurn) => 0b110,
                    (Rank::Three, _) => return None,
                };
                Some(permuted(tree, &|k| k ^ flipped).into())
            }
            Scattering::Matrix(matrix) => {
                let basis = matrix.incident();
                let moved = |k: usize| {
                    let [x, y] = basis.disk_point(k, 0.5, 0.5);
                    basis.patch(self.of([x, y, (1.0 - x * x - y * y).max(0.0).sqrt()]))
                };
                let n = matrix.exitant().n_patches();
                let row = |k: usize| &matrix.values()[moved(k) * n..][..n];
                let values = (0..basis.n_patches()).flat_map(|k| row(k).iter().copied()).collect();
                let made = Matrix::new(basis.clone(), matrix.exitant().clone(), values);
                Some(made.expect("rows of a matrix that is right").into())
            }
        }
    }
}
