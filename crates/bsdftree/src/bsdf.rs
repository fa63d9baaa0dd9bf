//! The whole BSDF: four components, in one or more spectral bands, with what the file says of the device.

use std::sync::Arc;

use thiserror::Error;

use crate::direction::{Direction, Side};
use crate::klems::{Matrix, MatrixLobe};
use crate::tree::{Rank, Tree, TreeLobe};

/// One function of incident and exitant direction: a tree or a matrix.
#[derive(Clone, Debug)]
pub enum Scattering {
    /// Variable resolution.
    Tree(Arc<Tree>),
    /// Fixed patches.
    Matrix(Arc<Matrix>),
}

impl From<Tree> for Scattering {
    fn from(tree: Tree) -> Scattering {
        Scattering::Tree(Arc::new(tree))
    }
}

impl From<Matrix> for Scattering {
    fn from(matrix: Matrix) -> Scattering {
        Scattering::Matrix(Arc::new(matrix))
    }
}

/// One of the four parts of a BSDF, named as WINDOW's XML names it: its *Front* is the outside (−Z).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// From outside back to outside.
    ReflectionFront,
    /// From the room back to the room.
    ReflectionBack,
    /// From outside into the room.
    TransmissionFront,
    /// From the room to outside.
    TransmissionBack,
}

impl Part {
    /// All four, in the order of the file format's documentation.
    pub const ALL: [Part; 4] =
        [Part::ReflectionFront, Part::ReflectionBack, Part::TransmissionFront, Part::TransmissionBack];

    /// The part that carries light from one side to another.
    pub fn between(incident: Side, exitant: Side) -> Part {
        match (incident, exitant) {
            (Side::Back, Side::Back) => Part::ReflectionFront,
            (Side::Front, Side::Front) => Part::ReflectionBack,
            (Side::Back, Side::Front) => Part::TransmissionFront,
            (Side::Front, Side::Back) => Part::TransmissionBack,
        }
    }

    /// The side that light comes from.
    pub fn incident_side(self) -> Side {
        match self {
            Part::ReflectionFront | Part::TransmissionFront => Side::Back,
            Part::ReflectionBack | Part::TransmissionBack => Side::Front,
        }
    }

    /// Whether light leaves on the side it came from.
    pub fn is_reflection(self) -> bool {
        matches!(self, Part::ReflectionFront | Part::ReflectionBack)
    }

    /// The side that light leaves to.
    pub fn exitant_side(self) -> Side {
        if self.is_reflection() { self.incident_side() } else { self.incident_side().opposite() }
    }

    /// `WavelengthDataDirection` in the file.
    pub fn file_name(self) -> &'static str {
        match self {
            Part::ReflectionFront => "Reflection Front",
            Part::ReflectionBack => "Reflection Back",
            Part::TransmissionFront => "Transmission Front",
            Part::TransmissionBack => "Transmission Back",
        }
    }

    /// The same with an underscore, for programs: `reflection_front`.
    pub fn key(self) -> &'static str {
        match self {
            Part::ReflectionFront => "reflection_front",
            Part::ReflectionBack => "reflection_back",
            Part::TransmissionFront => "transmission_front",
            Part::TransmissionBack => "transmission_back",
        }
    }
}

/// Luminance, and the two functions that add colour to it.
#[derive(Clone, Debug)]
pub struct Component {
    /// Y, or the one value of a band \[1/sr\].
    pub luminance: Scattering,
    /// Trees: CIE 1976 u′ and v′. Matrices: X and Z \[1/sr\].
    pub chroma: Option<[Scattering; 2]>,
}

impl Component {
    /// A component without colour.
    pub fn grey(luminance: Scattering) -> Component {
        Component { luminance, chroma: None }
    }

    /// Luminance, and chroma if it has colour.
    pub fn functions(&self) -> impl Iterator<Item = &Scattering> {
        std::iter::once(&self.luminance).chain(self.chroma.iter().flatten())
    }
}

/// The four components of one spectral band; any may be absent.
#[derive(Clone, Debug)]
pub struct Band {
    /// `Visible`, `Solar`, `NIR`, … or a wavelength in nm, as in the file.
    pub name: String,
    components: [Option<Component>; 4],
}

impl Band {
    /// A band without components.
    pub fn new(name: impl Into<String>) -> Band {
        Band { name: name.into(), components: [const { None }; 4] }
    }

    /// A component as it is in the file.
    pub fn component(&self, part: Part) -> Option<&Component> {
        self.components[part as usize].as_ref()
    }

    /// The same, to be changed.
    pub fn component_mut(&mut self, part: Part) -> Option<&mut Component> {
        self.components[part as usize].as_mut()
    }

    /// Puts a component in; gives back the one it replaces.
    pub fn insert(&mut self, part: Part, component: Component) -> Option<Component> {
        self.components[part as usize].replace(component)
    }

    /// Takes a component out.
    pub fn remove(&mut self, part: Part) -> Option<Component> {
        self.components[part as usize].take()
    }

    /// The components that are there.
    pub fn components(&self) -> impl Iterator<Item = (Part, &Component)> {
        Part::ALL.into_iter().filter_map(|part| Some((part, self.component(part)?)))
    }

    /// The same, to be changed.
    pub fn components_mut(&mut self) -> impl Iterator<Item = &mut Component> {
        self.components.iter_mut().flatten()
    }

    /// What answers for light from one side to another, and whether it must be reversed: an absent transmission is the
    /// other one with incident and exitant directions swapped; an absent reflection is black.
    pub fn answering(&self, incident: Side, exitant: Side) -> Option<(&Component, bool)> {
        let part = Part::between(incident, exitant);
        match self.component(part) {
            Some(component) => Some((component, false)),
            None if part.is_reflection() => None,
            None => self.component(Part::between(exitant, incident)).map(|component| (component, true)),
        }
    }
}

/// A unit of length, as the file names it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LengthUnit {
    /// Metre.
    #[default]
    Meter,
    /// 0.3048 m.
    Foot,
    /// 0.0254 m.
    Inch,
    /// 0.01 m.
    Centimeter,
    /// 0.001 m.
    Millimeter,
}

impl LengthUnit {
    /// Its length \[m\].
    pub fn meters(self) -> f64 {
        match self {
            LengthUnit::Meter => 1.0,
            LengthUnit::Foot => 0.3048,
            LengthUnit::Inch => 0.0254,
            LengthUnit::Centimeter => 0.01,
            LengthUnit::Millimeter => 0.001,
        }
    }

    /// Its name in the file.
    pub fn file_name(self) -> &'static str {
        match self {
            LengthUnit::Meter => "meter",
            LengthUnit::Foot => "foot",
            LengthUnit::Inch => "inch",
            LengthUnit::Centimeter => "centimeter",
            LengthUnit::Millimeter => "millimeter",
        }
    }

    /// The unit of a name in any case.
    pub fn from_name(name: &str) -> Option<LengthUnit> {
        use LengthUnit::*;
        [Meter, Foot, Inch, Centimeter, Millimeter]
            .into_iter()
            .find(|u| u.file_name().eq_ignore_ascii_case(name.trim()))
    }
}

/// What the file says of the device. Lengths in metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Header {
    /// Name of the product.
    pub name: String,
    /// Its maker.
    pub manufacturer: String,
    /// Extent along Z, X and Y \[m\], if given.
    pub thickness: Option<f64>,
    /// Extent along X \[m\].
    pub width: Option<f64>,
    /// Extent along Y \[m\].
    pub height: Option<f64>,
    /// The unit in which the file gives them.
    pub unit: LengthUnit,
    /// What else the file says of the material, by element: `DeviceType` unless it is `Other`, `ThermalConductivity`,
    /// `EmissivityFront` and the like, as text. Names are letters, digits, `_`, `-` and `.`, a letter first.
    pub properties: Vec<(String, String)>,
    /// Geometry as MGF text with its unit, if the file holds it.
    pub geometry: Option<Geometry>,
    /// How it was made: comments before the root element, one an entry.
    pub provenance: Vec<String>,
}

impl Header {
    /// Whether a property may have this name in a file: an element's, and none that has a field of its own.
    pub fn is_property(name: &str) -> bool {
        const OWN: [&str; 5] = ["Name", "Manufacturer", "Thickness", "Width", "Height"];
        let legal = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
        name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(legal) && !OWN.contains(&name)
    }
}

/// Device geometry inside the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// MGF text.
    pub mgf: String,
    /// Its unit of length.
    pub unit: LengthUnit,
}

/// A BSDF with all that its file holds.
#[derive(Clone, Debug, Default)]
pub struct Bsdf {
    /// What the file says of the device.
    pub header: Header,
    /// Spectral bands; `Visible` is the one that is asked by default.
    pub bands: Vec<Band>,
}

impl Bsdf {
    /// The band of a name, in any case.
    pub fn band(&self, name: &str) -> Option<&Band> {
        self.bands.iter().find(|b| b.name.eq_ignore_ascii_case(name))
    }

    /// The band of a name, made if there is none.
    pub fn band_mut(&mut self, name: &str) -> &mut Band {
        let found = self.bands.iter().position(|b| b.name.eq_ignore_ascii_case(name));
        let index = found.unwrap_or_else(|| {
            self.bands.push(Band::new(name));
            self.bands.len() - 1
        });
        &mut self.bands[index]
    }

    /// The same BSDF, whose luminance trees answer with ramps in their leaves instead of steps ([`Tree::smooth`]): values, samples,
    /// densities and totals. Matrices, u′ and v′ stay constant over their cells, so that the light of each colour is kept too, and what is
    /// written to a file stays what it is. `None` if it has no tree.
    pub fn smooth(&self) -> Option<Bsdf> {
        let mut bsdf = self.clone();
        for (band, steps) in bsdf.bands.iter_mut().zip(&self.bands) {
            for (part, component) in steps.components() {
                let Scattering::Tree(tree) = &component.luminance else { continue };
                // With the ramps that it has already.
                let so_far = band.clone();
                let other = so_far.answering(part.incident_side(), part.exitant_side().opposite());
                let beside = |incident: Direction| {
                    other.map_or(0.0, |(other, reversed)| other.luminance.hemispherical(incident, reversed))
                };
                let ramps = Component { luminance: tree.smooth_beside(&beside).into(), ..component.clone() };
                band.insert(part, ramps);
            }
        }
        bsdf.is_smooth().then_some(bsdf)
    }

    /// Whether it answers with ramps in the leaves of its trees.
    pub fn is_smooth(&self) -> bool {
        let mut components = self.bands.iter().flat_map(Band::components);
        components.any(|(_, c)| matches!(&c.luminance, Scattering::Tree(tree) if tree.is_smooth()))
    }

    /// Looks through all values of a file that was opened without doing so ([`binary::open`](crate::binary::open)). Queries answer
    /// in any case; where links of a tree are damaged, sums and samples are black.
    ///
    /// # Errors
    /// The first fault found.
    pub fn verify(&self) -> Result<(), Damage> {
        self.bands.iter().try_for_each(Band::verify)
    }
}

/// Values of a file that was opened without looking at them are not those that were written.
#[derive(Clone, Debug, Error, PartialEq)]
#[error(
    "byte {offset}: found {found} in {part} of the band {band}; the file is damaged, so copy or make it again",
    part = part.file_name()
)]
pub struct Damage {
    /// Bytes of the file before the first fault.
    pub offset: u64,
    /// What is there.
    pub found: String,
    /// The component that it belongs to.
    pub part: Part,
    /// The band of that.
    pub band: String,
}

impl Band {
    /// Looks through all values of a file that was opened without doing so, as [`Bsdf::verify`] does.
    ///
    /// # Errors
    /// The first fault found.
    pub fn verify(&self) -> Result<(), Damage> {
        for (part, component) in self.components() {
            for function in component.functions() {
                if let Some((offset, found)) = function.fault() {
                    return Err(Damage { offset, found, part, band: self.name.clone() });
                }
            }
        }
        Ok(())
    }
}

impl Scattering {
    /// The BSDF \[1/sr\], no cosine; which sides the directions lie on does not matter here. `reversed`: light that this
    /// function has going from `exitant` to `incident`.
    pub fn eval(&self, incident: Direction, exitant: Direction, reversed: bool) -> f64 {
        let (from, to) = if reversed { (exitant, incident) } else { (incident, exitant) };
        match self {
            Scattering::Tree(tree) => tree.eval(from, to),
            Scattering::Matrix(matrix) => matrix.eval(from, to),
        }
    }

    /// [`Scattering::eval`] for many pairs.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn eval_many(
        &self,
        incident: &[Direction],
        exitant: &[Direction],
        reversed: bool,
        values: &mut [f64],
    ) {
        let (from, to) = if reversed { (exitant, incident) } else { (incident, exitant) };
        match self {
            Scattering::Tree(tree) => tree.eval_many(from, to, values),
            Scattering::Matrix(matrix) => {
                assert!(from.len() == to.len() && from.len() == values.len(), "a value for each pair");
                let pairs = from.iter().zip(to).zip(values);
                pairs.for_each(|((&from, &to), value)| *value = matrix.eval(from, to));
            }
        }
    }

    /// [`Scattering::projected_solid_angle`] for many pairs.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn projected_solid_angle_many(
        &self,
        incident: &[Direction],
        exitant: &[Direction],
        reversed: bool,
        angles: &mut [f64],
    ) {
        match self {
            Scattering::Tree(tree) => {
                let (from, to) = if reversed { (exitant, incident) } else { (incident, exitant) };
                tree.projected_solid_angle_many(from, to, angles);
            }
            Scattering::Matrix(matrix) => {
                assert!(
                    incident.len() == exitant.len() && exitant.len() == angles.len(),
                    "an angle for each pair"
                );
                let each = exitant.iter().zip(angles);
                each.for_each(|(&exitant, angle)| *angle = matrix.projected_solid_angle(exitant, reversed));
            }
        }
    }

    /// [`Scattering::hemispherical`] for many incident directions.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn hemispherical_many(&self, incident: &[Direction], reversed: bool, totals: &mut [f64]) {
        match self {
            Scattering::Tree(tree) => tree.hemispherical_many(incident, reversed, totals),
            Scattering::Matrix(matrix) => {
                assert_eq!(incident.len(), totals.len(), "a total for each incident direction");
                let each = incident.iter().zip(totals);
                each.for_each(|(&incident, total)| *total = matrix.lobe(incident, reversed).total());
            }
        }
    }

    /// Samples of [`Scattering::lobe`] for many incident directions: points of the exitant disk and values \[1/sr\], 0 where the
    /// lobe is black.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn sample_many(
        &self,
        incident: &[Direction],
        reversed: bool,
        u: &[f64],
        v: Option<&[f64]>,
        sampled: &mut [([f64; 2], f64)],
    ) {
        match self {
            Scattering::Tree(tree) => tree.sample_many(incident, reversed, u, v, sampled),
            Scattering::Matrix(matrix) => {
                assert!(incident.len() == u.len() && u.len() == sampled.len(), "a sample for each direction");
                for (k, sampled) in sampled.iter_mut().enumerate() {
                    let found = matrix.lobe(incident[k], reversed).sample(u[k], v.map(|v| v[k]));
                    *sampled = found.unwrap_or_default();
                }
            }
        }
    }

    /// The function for one incident direction.
    pub fn lobe(&self, incident: Direction, reversed: bool) -> Lobe<'_> {
        match self {
            Scattering::Tree(tree) => Lobe::Tree(tree.lobe(incident, reversed)),
            Scattering::Matrix(matrix) => Lobe::Matrix(matrix.lobe(incident, reversed)),
        }
    }

    /// Directional-hemispherical total.
    pub fn hemispherical(&self, incident: Direction, reversed: bool) -> f64 {
        match self {
            Scattering::Tree(tree) => tree.hemispherical(incident, reversed),
            Scattering::Matrix(matrix) => matrix.lobe(incident, reversed).total(),
        }
    }

    /// Projected solid angle \[sr\] of the cell that holds the exitant direction.
    pub fn projected_solid_angle(&self, incident: Direction, exitant: Direction, reversed: bool) -> f64 {
        match self {
            Scattering::Tree(tree) if reversed => tree.projected_solid_angle(exitant, incident),
            Scattering::Tree(tree) => tree.projected_solid_angle(incident, exitant),
            Scattering::Matrix(matrix) => matrix.projected_solid_angle(exitant, reversed),
        }
    }

    /// Smallest and largest projected solid angle \[sr\] of the exitant cells that an incident direction meets.
    pub fn projected_solid_angle_range(&self, incident: Direction, reversed: bool) -> [f64; 2] {
        match self {
            Scattering::Tree(tree) => tree.projected_solid_angle_range(incident, reversed),
            Scattering::Matrix(matrix) => matrix.projected_solid_angle_range(reversed),
        }
    }

    /// The Lambertian part: the reflectance or transmittance of the smallest value, taken everywhere.
    ///
    /// Radiance extracts it only where it is above 1 % and, for trees, below 150 %; so do we (0 otherwise).
    pub fn lambertian(&self) -> f64 {
        let (minimum, cap) = match self {
            Scattering::Tree(tree) => (tree.minimum(), 1.5),
            Scattering::Matrix(matrix) => (matrix.minimum(), f64::INFINITY),
        };
        let rho = f64::from(minimum) * std::f64::consts::PI;
        if rho > 0.01 && rho < cap { rho } else { 0.0 }
    }

    /// Whether both are trees of one rank, or matrices over the same bases.
    pub fn has_domain_of(&self, other: &Scattering) -> bool {
        match (self, other) {
            (Scattering::Tree(a), Scattering::Tree(b)) => a.rank() == b.rank(),
            (Scattering::Matrix(a), Scattering::Matrix(b)) => {
                a.incident() == b.incident() && a.exitant() == b.exitant()
            }
            _ => false,
        }
    }

    /// What is wrong with values of a file that was opened without looking at them, and at which byte.
    pub fn fault(&self) -> Option<(u64, String)> {
        match self {
            Scattering::Tree(tree) => tree.arena().fault(),
            Scattering::Matrix(matrix) => matrix.fault(),
        }
    }

    /// Number of values held.
    pub fn n_values(&self) -> usize {
        match self {
            Scattering::Tree(tree) => tree.arena().n_leaves(),
            Scattering::Matrix(matrix) => matrix.values().len(),
        }
    }

    /// Memory of the values \[byte\].
    pub fn n_bytes(&self) -> usize {
        match self {
            Scattering::Tree(tree) => tree.arena().n_bytes(),
            Scattering::Matrix(matrix) => std::mem::size_of_val(matrix.values()),
        }
    }

    /// `IncidentDataStructure` in the file.
    pub fn file_structure(&self) -> &'static str {
        match self {
            Scattering::Tree(tree) if tree.rank() == Rank::Three => "TensorTree3",
            Scattering::Tree(_) => "TensorTree4",
            Scattering::Matrix(_) => "Columns",
        }
    }
}

/// A function for one incident direction: where the light goes.
pub enum Lobe<'a> {
    /// Of a tree.
    Tree(TreeLobe<'a>),
    /// Of a matrix.
    Matrix(MatrixLobe<'a>),
}

impl Lobe<'_> {
    /// Directional-hemispherical total.
    #[inline]
    pub fn total(&self) -> f64 {
        match self {
            Lobe::Tree(lobe) => lobe.total(),
            Lobe::Matrix(lobe) => lobe.total(),
        }
    }

    /// A point of the exitant disk, chosen in proportion to BSDF × projected solid angle, and the BSDF there \[1/sr\]; `None`
    /// where it is black.
    #[inline]
    pub fn sample(&self, u: f64, v: Option<f64>) -> Option<([f64; 2], f64)> {
        match self {
            Lobe::Tree(lobe) => lobe.sample(u, v),
            Lobe::Matrix(lobe) => lobe.sample(u, v),
        }
    }
}
