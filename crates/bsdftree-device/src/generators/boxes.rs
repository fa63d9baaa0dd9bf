//! `genbox`: a box, plain, bevelled or rounded.
//!
//! Corners are lettered, and names of parts are the letters of their corners in order; so a part is described by its
//! name. A letter stands for a corner of the box, its place in the alphabet from the first of its set giving the side in x
//! (1), y (2) and z (4): digits from `0` for the box itself; from `c`, `k` and `M` for the corners of the faces across y, x and
//! z when edges are cut off; from `s` for the centres of rounded corners. Deviation: smooth strips, which are rectangles, are
//! all cut along the same diagonal, where Radiance's choice hangs on rounding.

use glam::{DVec3, dvec3};

use super::arguments::Arguments;
use super::output::Output;
use super::rounded::Rounded;
use super::{Environment, Names};
use crate::error::DeviceError;

const PLAIN: [&str; 6] = ["1540", "4620", "2310", "3267", "5137", "6457"];
const FACES: [&str; 6] = ["dhgc", "oqmk", "OPNM", "feij", "plnr", "SQRT"];
const BEVELS: [&str; 20] = [
    "NdcM", "kmOM", "cgok", "QSqo", "TjiS", "emqi", "efPO", "jrnf", "lNPn", "prTR", "hdlp", "QghR", "Mck",
    "dNl", "Ome", "ogQ", "Siq", "pRh", "fnP", "Trj",
];
pub(super) const EDGES: [&str; 12] = ["st", "sw", "su", "vt", "vu", "vz", "xt", "xw", "xz", "yu", "yw", "yz"];

/// Segments of a rounded corner that is made of polygons, if nothing is said.
const SEGMENTS: u64 = 32;

/// A box, its edges cut off or rounded by `cut`.
pub(super) struct Block {
    pub names: Names,
    pub size: DVec3,
    /// Whether normals face inward: then everything is reflected in the middle.
    pub inverted: bool,
    pub cut: f64,
}

pub(super) fn generate(
    arguments: &mut Arguments,
    _: &Environment,
    output: &mut Output,
) -> Result<(), DeviceError> {
    let names = Names::take(arguments)?;
    let mut size = || arguments.number_that("a size above 0", |x| x > 0.0);
    let size = dvec3(size()?, size()?, size()?);
    let mut block = Block { names, size, inverted: false, cut: 0.0 };
    let (mut is_round, mut n_segments, mut is_smooth) = (false, 1, false);
    while let Some(option) = arguments.next() {
        match option {
            "-i" => block.inverted = true,
            "-s" => is_smooth = true,
            "-n" => n_segments = arguments.count("a number of segments of at least 1", 1)?,
            "-b" | "-r" => {
                let half = 0.5 * size.min_element();
                let what = "a length above 0, up to half the smallest size,";
                block.cut = arguments.number_that(what, |r| r > 0.0 && r <= half)?;
                is_round = option == "-r";
            }
            other => return Err(arguments.unknown(other)),
        }
    }
    if is_round && block.inverted && n_segments == 1 {
        n_segments = SEGMENTS;
    }
    if is_round && n_segments > 2 {
        // Each corner has 4^levels triangles, each edge 2^levels strips.
        let log2 = n_segments.checked_next_power_of_two().map_or(63, u64::trailing_zeros);
        output.expect(1u64.checked_shl(2 * log2 + 4).unwrap_or(u64::MAX))?;
        return Rounded { block: &block, log2, is_smooth }.generate(output);
    }
    match (block.cut > 0.0, is_round) {
        (false, _) => block.polygons(&PLAIN, output),
        (true, false) => {
            block.polygons(&FACES, output)?;
            block.polygons(&BEVELS, output)
        }
        (true, true) => {
            block.polygons(&FACES, output)?;
            block.tubes_and_balls(output)
        }
    }
}

impl Block {
    fn polygons(&self, faces: &[&str], output: &mut Output) -> Result<(), DeviceError> {
        for face in faces {
            output.polygon(
                &self.names.modifier,
                self.names.part(face),
                face.bytes().map(|c| self.corner(c)),
            )?;
        }
        Ok(())
    }

    /// The faces of a box with its edges cut off, under other names.
    pub fn face(&self, index: usize) -> [DVec3; 4] {
        let mut letters = FACES[index].bytes();
        std::array::from_fn(|_| letters.next().map_or(DVec3::ZERO, |c| self.corner(c)))
    }

    fn tubes_and_balls(&self, output: &mut Output) -> Result<(), DeviceError> {
        let modifier = &self.names.modifier;
        for edge in EDGES {
            let ends = [edge.as_bytes()[0], edge.as_bytes()[1]].map(|c| self.corner(c));
            output.cylinder(modifier, self.names.part(edge), ends, self.cut)?;
        }
        for letter in b's'..=b'z' {
            let name = self.names.part(letter as char);
            output.sphere(modifier, name, self.corner(letter), self.cut)?;
        }
        Ok(())
    }

    /// Where the corner with this letter is.
    fn corner(&self, letter: u8) -> DVec3 {
        let c = self.cut;
        let (index, inset) = match letter {
            b'0'..=b'7' => (letter - b'0', DVec3::ZERO),
            b'c'..=b'j' => (letter - b'c', dvec3(c, 0.0, c)),
            b'k'..=b'r' => (letter - b'k', dvec3(0.0, c, c)),
            b'M'..=b'T' => (letter - b'M', dvec3(c, c, 0.0)),
            _ => (letter - b's', DVec3::splat(c)),
        };
        self.inside(index, inset)
    }

    /// The point this far inside the corner with this index, along each axis.
    pub fn inside(&self, index: u8, inset: DVec3) -> DVec3 {
        let far = |axis: usize| (index >> axis & 1 == 1) != self.inverted;
        DVec3::from_array(std::array::from_fn(|axis| match far(axis) {
            true => self.size[axis] - inset[axis],
            false => inset[axis],
        }))
    }
}
