//! Files for the tests: small ones made of parts.
#![allow(dead_code)]

use bsdftree::xml::{Repair, Severity, Strictness, XmlError, read};
use bsdftree::{Bsdf, Component, Matrix, Scattering, Tree};

pub const VISIBLE: &str = r#"<Wavelength unit="Integral">Visible</Wavelength>"#;
pub const SHIRLEY_CHIU: &str = "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>";
pub const KLEMS_FULL: &str =
    "<ColumnAngleBasis>LBNL/Klems Full</ColumnAngleBasis><RowAngleBasis>LBNL/Klems Full</RowAngleBasis>";

/// The whole file around the children of its layer.
pub fn file_of_layer(layer: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<WindowElement xmlns=\"http://windows.lbl.gov\">\
         <WindowElementType>System</WindowElementType>\n<FileType>BSDF</FileType>\n<Optical><Layer>{layer}</Layer>\
         </Optical></WindowElement>\n"
    )
}

/// A file of one structure, with blocks.
pub fn file(structure: &str, blocks: &str) -> String {
    file_of_layer(&format!(
        "<DataDefinition><IncidentDataStructure>{structure}</IncidentDataStructure></DataDefinition>\n{blocks}"
    ))
}

/// One `WavelengthData` with one block.
pub fn block(wavelength: &str, direction: &str, basis: &str, data: &str) -> String {
    format!(
        "<WavelengthData>{wavelength}<WavelengthDataBlock>\
         <WavelengthDataDirection>{direction}</WavelengthDataDirection>{basis}\
         <ScatteringData>{data}</ScatteringData></WavelengthDataBlock></WavelengthData>\n"
    )
}

/// A file with one visible tree.
pub fn tree_file(structure: &str, tree: &str) -> String {
    file(structure, &block(VISIBLE, "Reflection Back", SHIRLEY_CHIU, tree))
}

pub fn strict(text: &str) -> Result<Bsdf, XmlError> {
    read(text.as_bytes(), Strictness::Strict).map(|(bsdf, _)| bsdf)
}

/// Read in repair mode: what was repaired, notes left out.
pub fn repaired(text: &str) -> Result<(Bsdf, Vec<Repair>), XmlError> {
    let (bsdf, mut repairs) = read(text.as_bytes(), Strictness::Repair)?;
    repairs.retain(|repair| repair.severity == Severity::Repair);
    Ok((bsdf, repairs))
}

pub fn tree(scattering: &Scattering) -> &Tree {
    match scattering {
        Scattering::Tree(tree) => tree,
        Scattering::Matrix(_) => panic!("a tree is expected"),
    }
}

pub fn matrix(scattering: &Scattering) -> &Matrix {
    match scattering {
        Scattering::Matrix(matrix) => matrix,
        Scattering::Tree(_) => panic!("a matrix is expected"),
    }
}

/// Same values in the same structure.
pub fn assert_same_scattering(a: &Scattering, b: &Scattering) {
    match (a, b) {
        (Scattering::Tree(a), Scattering::Tree(b)) => {
            assert_eq!(a.rank(), b.rank());
            assert!(a.leaves().eq(b.leaves()), "the trees differ");
        }
        (Scattering::Matrix(a), Scattering::Matrix(b)) => {
            assert_eq!(a.incident(), b.incident());
            assert_eq!(a.exitant(), b.exitant());
            assert_eq!(a.values(), b.values());
        }
        _ => panic!("a tree against a matrix"),
    }
}

/// Same header, bands, components, structure and values.
pub fn assert_same_bsdf(a: &Bsdf, b: &Bsdf) {
    assert_eq!(a.header, b.header);
    assert_eq!(a.bands.len(), b.bands.len());
    for (a, b) in a.bands.iter().zip(&b.bands) {
        assert_eq!(a.name, b.name);
        assert!(a.components().map(|(part, _)| part).eq(b.components().map(|(part, _)| part)));
        for ((_, a), (_, b)) in a.components().zip(b.components()) {
            assert_same_component(a, b);
        }
    }
}

fn assert_same_component(a: &Component, b: &Component) {
    assert_same_scattering(&a.luminance, &b.luminance);
    assert_eq!(a.chroma.is_some(), b.chroma.is_some());
    for (a, b) in a.chroma.iter().flatten().zip(b.chroma.iter().flatten()) {
        assert_same_scattering(a, b);
    }
}
