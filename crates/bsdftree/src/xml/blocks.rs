//! The data blocks: which band, which component, and their values.

use std::sync::Arc;

use super::basis::Bases;
use super::document::Node;
use super::error::{Fault, XmlError, excerpt};
use super::header::short_text;
use super::matrix_text::{Layout, matrix, numbers};
use super::number::Negatives;
use super::repair::Repairs;
use super::tree_text;
use crate::bsdf::{Band, Bsdf, Component, Part, Scattering};
use crate::klems::Basis;
use crate::tree::Rank;

/// The band that colour belongs to.
const VISIBLE: &str = "Visible";

/// How the file lays out its data.
#[derive(Clone, Copy)]
enum Structure {
    Tree(Rank),
    Matrix(Layout),
}

/// What a block's values are.
#[derive(Clone, PartialEq)]
enum Channel {
    /// Luminance, or a band's one value.
    Band(String),
    /// u′ and v′ of a tree, X and Z of a matrix: index into a component's chroma.
    Chroma(usize),
}

/// What a block is about.
enum Direction {
    Part(Part),
    Absorbed,
    Unknown,
}

/// The data while it is being collected.
struct Blocks {
    structure: Structure,
    bases: Bases,
    bsdf: Bsdf,
    chroma: [[Option<(Scattering, usize)>; 2]; 4],
}

/// All bands of a layer.
pub(super) fn bands(layer: Node<'_>, repairs: &mut Repairs) -> Result<Vec<Band>, XmlError> {
    let definition = layer.need("DataDefinition", "it says how the data is laid out; add it")?;
    let structure = structure(definition, repairs)?;
    let bases = Bases::new(definition, repairs)?;
    let mut blocks = Blocks { structure, bases, bsdf: Bsdf::default(), chroma: Default::default() };
    for data in layer.all("WavelengthData") {
        let channel = channel(data, structure, repairs)?;
        let mut any = false;
        for block in data.all("WavelengthDataBlock") {
            any = true;
            blocks.read(block, channel.as_ref(), repairs)?;
        }
        if !any {
            repairs.repair(data.offset(), "<WavelengthData> without a WavelengthDataBlock", "it ignored")?;
        }
    }
    blocks.add_chroma(repairs)?;
    if blocks.bsdf.bands.is_empty() {
        let advice = "the file has no component of a BSDF; export it again";
        let fault = Fault::Missing { parent: "Layer".into(), element: "WavelengthData", advice };
        return Err(XmlError::new(layer.offset(), fault));
    }
    Ok(blocks.bsdf.bands)
}

fn structure(definition: Node<'_>, repairs: &mut Repairs) -> Result<Structure, XmlError> {
    const EXPECTED: &str = "Columns, Rows, TensorTree3 or TensorTree4";
    let node = definition.need("IncidentDataStructure", "give Columns, Rows, TensorTree3 or TensorTree4")?;
    let name = short_text(node, repairs)?;
    Ok(match name.to_ascii_lowercase().as_str() {
        "tensortree3" => Structure::Tree(Rank::Three),
        "tensortree4" => Structure::Tree(Rank::Four),
        "columns" => Structure::Matrix(Layout::Columns),
        "rows" => Structure::Matrix(Layout::Rows),
        _ => {
            let found = excerpt(name.as_bytes());
            let fault = Fault::Unexpected { what: "IncidentDataStructure", found, expected: EXPECTED.into() };
            return Err(XmlError::new(node.offset(), fault));
        }
    })
}

/// The channel of a `WavelengthData`; none if it has no place in a BSDF of this structure.
fn channel(data: Node<'_>, structure: Structure, repairs: &mut Repairs) -> Result<Option<Channel>, XmlError> {
    let name = match data.child("Wavelength") {
        Some(node) => short_text(node, repairs)?,
        None => String::new(),
    };
    if name.is_empty() {
        repairs.repair(data.offset(), "<WavelengthData> without a Wavelength", "it taken as Visible")?;
        return Ok(Some(Channel::Band(VISIBLE.into())));
    }
    let is = |other: &str| name.eq_ignore_ascii_case(other);
    let chroma = |index, for_tree| {
        let is_tree = matches!(structure, Structure::Tree(_));
        (is_tree == for_tree).then_some(Channel::Chroma(index))
    };
    let channel = match () {
        () if is(VISIBLE) => Some(Channel::Band(VISIBLE.into())),
        () if is("CIE-u") => chroma(0, true),
        () if is("CIE-v") => chroma(1, true),
        () if is("CIE-X") => chroma(0, false),
        () if is("CIE-Z") => chroma(1, false),
        () => Some(Channel::Band(name.clone())),
    };
    if channel.is_none() {
        let found =
            format!("{name} data: trees are coloured by CIE-u and CIE-v, matrices by CIE-X and CIE-Z");
        repairs.repair(data.offset(), found, "it left out")?;
    }
    Ok(channel)
}

impl Blocks {
    fn read(
        &mut self,
        block: Node<'_>,
        channel: Option<&Channel>,
        repairs: &mut Repairs,
    ) -> Result<(), XmlError> {
        let Some(channel) = channel else { return Ok(()) };
        let Some(part) = part(block, repairs)? else { return Ok(()) };
        let scattering = self.scattering(block, repairs)?;
        let replaces = match channel {
            Channel::Band(name) => {
                let component = Component::grey(scattering);
                self.bsdf.band_mut(name).insert(part, component).is_some()
            }
            Channel::Chroma(k) => {
                let slot = &mut self.chroma[part as usize][*k];
                slot.replace((scattering, block.offset())).is_some()
            }
        };
        if replaces {
            let found = format!("a second {} of the same wavelength", part.file_name());
            repairs.repair(block.offset(), found, "it used instead of the first")?;
        }
        Ok(())
    }

    fn scattering(&self, block: Node<'_>, repairs: &mut Repairs) -> Result<Scattering, XmlError> {
        let data = block.need("ScatteringData", "the component has no values; export it again")?;
        if let Some(second) = block.all("ScatteringData").nth(1) {
            repairs.repair(second.offset(), "a second ScatteringData in one block", "the first used")?;
        }
        let mut negatives = Negatives::default();
        let (text, base) = data.data()?;
        let scattering = match self.structure {
            Structure::Tree(rank) => {
                check_tree_basis(block, repairs)?;
                Scattering::from(tree_text::parse(&text, base, rank, &mut negatives)?)
            }
            Structure::Matrix(layout) => {
                let [incident, exitant] = ["ColumnAngleBasis", "RowAngleBasis"];
                let incident = self.basis(block, incident, repairs)?;
                let exitant = self.basis(block, exitant, repairs)?;
                let values = numbers(&text, base, &mut negatives)?;
                Scattering::from(matrix(values, [&incident, &exitant], layout, data.offset())?)
            }
        };
        negatives.reported(repairs)?;
        Ok(scattering)
    }

    fn basis(
        &self,
        block: Node<'_>,
        element: &'static str,
        repairs: &mut Repairs,
    ) -> Result<Vec<Arc<Basis>>, XmlError> {
        match (block.child(element), self.bases.only()) {
            (None, Some(only)) => {
                let remedy = format!("it taken as {}, the only one defined", only[0].name());
                repairs.repair(block.offset(), format!("a block without {element}"), remedy)?;
                Ok(only)
            }
            _ => self.bases.named(block.need(element, "name the angle basis of the data")?, repairs),
        }
    }

    /// Puts colour to the luminance that it belongs to.
    fn add_chroma(&mut self, repairs: &mut Repairs) -> Result<(), XmlError> {
        let names = match self.structure {
            Structure::Tree(_) => ["CIE-u", "CIE-v"],
            Structure::Matrix(_) => ["CIE-X", "CIE-Z"],
        };
        for part in Part::ALL {
            let [first, second] = std::mem::take(&mut self.chroma[part as usize]);
            let (pair, offset) = match (first, second) {
                (None, None) => continue,
                (Some((_, offset)), None) => (Err(format!("{} without {}", names[0], names[1])), offset),
                (None, Some((_, offset))) => (Err(format!("{} without {}", names[1], names[0])), offset),
                (Some((first, offset)), Some((second, _))) => (Ok([first, second]), offset),
            };
            let visible = self.bsdf.bands.iter_mut().find(|band| band.name == VISIBLE);
            let component = visible.and_then(|band| band.component_mut(part));
            let problem = match (pair, component) {
                (Err(problem), _) => problem,
                (Ok(_), None) => format!("{} and {} without Visible", names[0], names[1]),
                (Ok(chroma), Some(component)) => {
                    if chroma.iter().all(|c| c.has_domain_of(&component.luminance)) {
                        component.chroma = Some(chroma);
                        continue;
                    }
                    format!("{} or {} with other angle bases than Visible", names[0], names[1])
                }
            };
            repairs.repair(offset, format!("{}: {problem}", part.file_name()), "the colour left out")?;
        }
        Ok(())
    }
}

/// The component that a block holds; none if it is none of a BSDF's.
fn part(block: Node<'_>, repairs: &mut Repairs) -> Result<Option<Part>, XmlError> {
    let name = match block.child("WavelengthDataDirection") {
        Some(node) => short_text(node, repairs)?,
        None => String::new(),
    };
    let words: Vec<String> = name.split_whitespace().map(str::to_ascii_lowercase).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let direction = match words.as_slice() {
        ["transmission", "front"] => Direction::Part(Part::TransmissionFront),
        ["transmission", "back"] => Direction::Part(Part::TransmissionBack),
        ["reflection", "front"] => Direction::Part(Part::ReflectionFront),
        ["reflection", "back"] => Direction::Part(Part::ReflectionBack),
        ["transmission"] => {
            let found = "direction `Transmission` without a side";
            repairs.repair(
                block.offset(),
                found,
                "it taken as Transmission Back, for light from both sides",
            )?;
            Direction::Part(Part::TransmissionBack)
        }
        ["absorbed", "front" | "back"] => Direction::Absorbed,
        _ => Direction::Unknown,
    };
    match direction {
        Direction::Part(part) => return Ok(Some(part)),
        Direction::Absorbed => repairs.note(block.offset(), format!("{name}: no scattering, not kept")),
        Direction::Unknown => {
            let expected = "Transmission or Reflection, Front or Back";
            let found = format!("direction `{}`; expected {expected}", excerpt(name.as_bytes()));
            repairs.repair(block.offset(), found, "the block ignored")?;
        }
    }
    Ok(None)
}

fn check_tree_basis(block: Node<'_>, repairs: &mut Repairs) -> Result<(), XmlError> {
    const BASIS: &str = "LBNL/Shirley-Chiu";
    let Some(node) = block.child("AngleBasis") else {
        return repairs.repair(
            block.offset(),
            "a tree without an AngleBasis",
            format!("it taken as {BASIS}"),
        );
    };
    let name = short_text(node, repairs)?;
    if name.eq_ignore_ascii_case(BASIS) {
        return Ok(());
    }
    let found = excerpt(name.as_bytes());
    let fault = Fault::Unexpected { what: "the AngleBasis of a tree", found, expected: BASIS.into() };
    Err(XmlError::new(node.offset(), fault))
}
