//! What the file says of the device: the layer, its material and its geometry.

use super::document::{Document, Node};
use super::error::{Fault, XmlError, excerpt};
use super::repair::Repairs;
use crate::bsdf::{Geometry, Header, LengthUnit};

/// Longest name \[byte\].
pub(super) const MAX_NAME: usize = 4096;

const NO_DATA: &str = "the file holds no optical data; export it from WINDOW or genBSDF again";

/// The layer that holds the data.
pub(super) fn layer<'d>(document: &'d Document<'d>, repairs: &mut Repairs) -> Result<Node<'d>, XmlError> {
    let root = document.root();
    let wrong = |node: Node<'_>, what, found: &str, expected: &str| {
        let fault = Fault::Unexpected { what, found: excerpt(found.as_bytes()), expected: expected.into() };
        Err(XmlError::new(node.offset(), fault))
    };
    if root.name() != "WindowElement" {
        return wrong(root, "the root element", root.name(), "WindowElement, as in a BSDF file");
    }
    if let Some(node) = root.child("FileType") {
        let file_type = short_text(node, repairs)?;
        if !file_type.eq_ignore_ascii_case("BSDF") {
            return wrong(node, "FileType", &file_type, "BSDF");
        }
    }
    let optical = root.need("Optical", NO_DATA)?;
    let others = optical.all("Layer").skip(1).count();
    if let Some(second) = optical.all("Layer").nth(1) {
        repairs.repair(
            second.offset(),
            format!("{others} more layers after the first"),
            "only the first read",
        )?;
    }
    optical.need("Layer", NO_DATA)
}

/// Name, maker, size, geometry and provenance.
pub(super) fn header(
    layer: Node<'_>,
    provenance: Vec<String>,
    repairs: &mut Repairs,
) -> Result<Header, XmlError> {
    let mut header = Header { provenance, ..Header::default() };
    if let Some(material) = layer.child("Material") {
        read_material(material, &mut header, repairs)?;
    }
    if let Some(geometry) = layer.child("Geometry") {
        header.geometry = read_geometry(geometry, repairs)?;
    }
    Ok(header)
}

fn read_material(material: Node<'_>, header: &mut Header, repairs: &mut Repairs) -> Result<(), XmlError> {
    for (name, text) in [("Name", &mut header.name), ("Manufacturer", &mut header.manufacturer)] {
        if let Some(node) = material.child(name) {
            *text = short_text(node, repairs)?;
        }
    }
    let mut first_unit = None;
    for (name, length) in
        [("Thickness", &mut header.thickness), ("Width", &mut header.width), ("Height", &mut header.height)]
    {
        if let Some(node) = material.child(name) {
            let unit = unit(node, repairs)?;
            *length = read_length(node, repairs)?.map(|value| value * unit.meters());
            first_unit = first_unit.or(Some(unit));
        }
    }
    header.unit = first_unit.unwrap_or_default();
    read_properties(material, header, repairs)
}

/// What stands there as plain text. `DeviceType` is `Other` in nearly every file.
fn read_properties(material: Node<'_>, header: &mut Header, repairs: &mut Repairs) -> Result<(), XmlError> {
    for node in material.children().filter(|node| Header::is_property(node.name())) {
        let is_plain = !node.has_attributes() && node.children().next().is_none();
        let text = if is_plain { node.text(repairs)?.trim().to_owned() } else { String::new() };
        let is_first = header.properties.iter().all(|(name, _)| name != node.name());
        if !is_plain || !is_first || text.len() > MAX_NAME {
            let found = format!("of <Material>, not kept: {}", excerpt(node.name().as_bytes()));
            repairs.note(node.offset(), found);
        } else if !text.is_empty() && (node.name(), text.as_str()) != ("DeviceType", "Other") {
            header.properties.push((node.name().to_owned(), text));
        }
    }
    Ok(())
}

fn read_length(node: Node<'_>, repairs: &mut Repairs) -> Result<Option<f64>, XmlError> {
    let text = short_text(node, repairs)?;
    if text.is_empty() {
        return Ok(None);
    }
    let length = text.parse::<f64>().ok().filter(|length| length.is_finite() && *length >= 0.0);
    if length.is_none() {
        let found = format!("<{}> is `{}`, not a length", node.name(), excerpt(text.as_bytes()));
        repairs.repair(node.offset(), found, "it left out")?;
    }
    Ok(length)
}

fn unit(node: Node<'_>, repairs: &mut Repairs) -> Result<LengthUnit, XmlError> {
    let Some(name) = node.attribute("unit")? else { return Ok(LengthUnit::Meter) };
    if name.trim().is_empty() {
        return Ok(LengthUnit::Meter);
    }
    if let Some(unit) = LengthUnit::from_name(&name) {
        return Ok(unit);
    }
    let found = format!(
        "the unit of <{}> is `{}`, none of meter, foot, inch, centimeter, millimeter",
        node.name(),
        excerpt(name.as_bytes())
    );
    repairs.repair(node.offset(), found, "it taken as meter")?;
    Ok(LengthUnit::Meter)
}

fn read_geometry(node: Node<'_>, repairs: &mut Repairs) -> Result<Option<Geometry>, XmlError> {
    not_kept(node, &["MGFblock"], repairs);
    let mut blocks = node.all("MGFblock");
    let Some(block) = blocks.next() else { return Ok(None) };
    let format = node.attribute("format")?.unwrap_or_default();
    if !["", "mgf"].contains(&format.trim().to_ascii_lowercase().as_str()) {
        let found = format!("geometry in the format `{}` instead of MGF", excerpt(format.as_bytes()));
        repairs.repair(node.offset(), found, "it left out")?;
        return Ok(None);
    }
    if let Some(second) = blocks.next() {
        repairs.repair(second.offset(), "a second MGFblock", "it left out")?;
    }
    let unit = unit(block, repairs)?;
    let mgf = block.text(repairs)?;
    Ok((!mgf.trim().is_empty()).then_some(Geometry { mgf, unit }))
}

/// Notes the children of an element that are not kept.
fn not_kept(node: Node<'_>, kept: &[&str], repairs: &mut Repairs) {
    const ENOUGH: usize = 12;
    let others: Vec<&str> =
        node.children().map(Node::name).filter(|name| !kept.contains(name)).take(ENOUGH).collect();
    if !others.is_empty() {
        let others: Vec<String> = others.iter().map(|name| excerpt(name.as_bytes())).collect();
        repairs.note(node.offset(), format!("of <{}>, not kept: {}", node.name(), others.join(", ")));
    }
}

/// The trimmed text of an element that holds a name or a number.
pub(super) fn short_text(node: Node<'_>, repairs: &mut Repairs) -> Result<String, XmlError> {
    let mut text = node.text(repairs)?;
    if text.trim().len() > MAX_NAME {
        return Err(XmlError::new(node.offset(), Fault::Limit { what: "bytes in a name", limit: MAX_NAME }));
    }
    if text.trim().len() < text.len() {
        text = text.trim().to_owned();
    }
    Ok(text)
}

/// A comment as provenance: the writer puts a backslash between two hyphens, which a comment may not hold.
pub(super) fn provenance(comment: &str) -> String {
    let mut text = String::with_capacity(comment.len());
    let mut rest = comment.trim();
    while let Some(hyphen) = rest.find("-\\") {
        let escaped = &rest[hyphen + 1..];
        let n = escaped.len() - escaped.trim_start_matches('\\').len();
        text.push_str(&rest[..=hyphen]);
        let keep = if escaped[n..].starts_with('-') { n - 1 } else { n };
        text.push_str(&escaped[..keep]);
        rest = &escaped[n..];
    }
    text.push_str(rest);
    text.replace("\r\n", "\n")
}
