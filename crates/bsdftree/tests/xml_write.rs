//! What is written reads back exactly, and is laid out as Radiance lays it out.

mod xml_text;

use std::sync::Arc;

use bsdftree::klems::Ring;
use bsdftree::tree::{Slot, TreeBuilder};
use bsdftree::xml::{Strictness, WriteError, parse_tree, read, read_file, write, write_file};
use bsdftree::{Basis, Bsdf, Component, Geometry, Header, LengthUnit, Matrix, Part, Rank, Scattering, Tree};
use xml_text::assert_same_bsdf;

fn written(bsdf: &Bsdf) -> String {
    let mut text = Vec::new();
    write(bsdf, &mut text).unwrap_or_else(|error| panic!("{error}"));
    String::from_utf8(text).unwrap()
}

fn assert_survives(bsdf: &Bsdf) -> String {
    let text = written(bsdf);
    let (again, repairs) =
        read(text.as_bytes(), Strictness::Strict).unwrap_or_else(|e| panic!("{e}\n{text:.1000}"));
    assert!(repairs.is_empty(), "{repairs:?}");
    assert_same_bsdf(bsdf, &again);
    text
}

fn grey(scattering: Scattering) -> Bsdf {
    let mut bsdf = Bsdf::default();
    bsdf.band_mut("Visible").insert(Part::ReflectionBack, Component::grey(scattering));
    bsdf
}

/// A root whose last child is a node of leaves and whose others are leaves.
fn two_levels(rank: Rank) -> Tree {
    let mut builder = TreeBuilder::new(rank);
    let n = rank.n_children();
    let leaves: Vec<Slot> = (0..n).map(|k| Slot::leaf(k as f32 + 0.5)).collect();
    let mut children = vec![Slot::leaf(0.0); n];
    children[n - 1] = builder.node(&leaves).unwrap();
    children[1] = Slot::leaf(7.0);
    let root = builder.node(&children).unwrap();
    Tree::new(builder.finish(root))
}

fn values(text: &str) -> &str {
    let (_, rest) = text.split_once("<ScatteringData>\n").unwrap();
    rest.split_once("\t\t\t</ScatteringData>").unwrap().0
}

#[test]
fn grids_and_branches_have_their_own_orders() {
    let text = assert_survives(&grey(Scattering::from(two_levels(Rank::Three))));
    // Child k of a branch has bit i of k as its half along dimension i; a grid has dimension 0 slowest.
    let expected = "{\n { 0 }\n { 7 }\n { 0 }\n { 0 }\n { 0 }\n { 0 }\n { 0 }\n\
                    \x20{ 0.5 4.5 2.5 6.5 1.5 5.5 3.5 7.5 }\n}\n";
    assert_eq!(values(&text), expected);
    assert_survives(&grey(Scattering::from(two_levels(Rank::Four))));
}

#[test]
fn a_uniform_tree_is_one_value() {
    let text = assert_survives(&grey(Scattering::from(Tree::uniform(Rank::Four, 0.3125))));
    assert_eq!(values(&text), "{ 0.3125 }\n");
}

#[test]
fn every_value_survives() {
    let extremes = [0.0, f32::MIN_POSITIVE, 1e-45, f32::MAX, 1.0 / 3.0, 16_777_216.0, 1e-7, 123_456.79];
    // Not from a grid: those refuse values that only mistakes have.
    let mut builder = TreeBuilder::new(Rank::Three);
    let root = builder.node(&extremes.map(Slot::leaf)).unwrap();
    assert_survives(&grey(Scattering::from(Tree::new(builder.finish(root)))));
}

#[test]
fn the_deepest_tree_survives() {
    let mut builder = TreeBuilder::new(Rank::Four);
    let mut slot = Slot::leaf(1.0);
    for level in 0..bsdftree::tree::MAX_LOG2_RES {
        let mut children = [Slot::leaf(0.25); 16];
        children[level as usize] = slot;
        slot = builder.node(&children).unwrap();
    }
    assert_survives(&grey(Scattering::from(Tree::new(builder.finish(slot)))));
}

#[test]
fn a_node_of_equal_leaves_stays_a_node() {
    let mut builder = TreeBuilder::new(Rank::Three);
    let root = builder.node(&[Slot::leaf(2.0); 8]).unwrap();
    let text = assert_survives(&grey(Scattering::from(Tree::new(builder.finish(root)))));
    assert_eq!(values(&text), "{ 2 2 2 2 2 2 2 2 }\n");
    assert_eq!(parse_tree(values(&text).as_bytes(), Rank::Three).unwrap().arena().n_leaves(), 8);
}

fn ramp(incident: &Arc<Basis>, exitant: &Arc<Basis>) -> Matrix {
    let n = incident.n_patches() * exitant.n_patches();
    let values = (0..n).map(|k| k as f32 * 0.001).collect();
    Matrix::new(Arc::clone(incident), Arc::clone(exitant), values).unwrap()
}

#[test]
fn matrices_over_any_bases_survive() {
    let ring = |a, b, n_phi| Ring { bounds_deg: [a, b], n_phi };
    let mine = Basis::new("Mine & <yours>", vec![ring(0.0, 10.1, 1), ring(10.1, 90.0, 3)]).unwrap();
    let bases = [Basis::full(), Basis::half(), Basis::half_73(), Basis::quarter(), mine];
    for incident in bases.map(Arc::new) {
        let text = assert_survives(&grey(Scattering::from(ramp(&incident, &Arc::new(Basis::quarter())))));
        assert!(text.contains("<IncidentDataStructure>Columns</IncidentDataStructure>"));
        let first_line = values(&text).lines().next().unwrap().split_whitespace().count();
        assert_eq!(first_line, incident.n_patches(), "a line has a value for each incident patch");
        assert_eq!(values(&text).lines().count(), 41, "there is a line for each exitant patch");
    }
    let split = Arc::new(Basis::quarter().subdivided(2).unwrap());
    assert_survives(&grey(Scattering::from(ramp(&split, &split))));
}

#[test]
fn colour_and_bands_survive() {
    let mut bsdf = grey(Scattering::from(two_levels(Rank::Four)));
    let uniform = |value| Scattering::from(Tree::uniform(Rank::Four, value));
    bsdf.bands[0].component_mut(Part::ReflectionBack).unwrap().chroma = Some([uniform(0.2), uniform(0.47)]);
    bsdf.bands[0].insert(Part::TransmissionFront, Component::grey(uniform(0.1)));
    for (name, value) in [("Solar", 0.3), ("632.8", 0.4)] {
        bsdf.band_mut(name).insert(Part::TransmissionBack, Component::grey(uniform(value)));
    }
    let text = assert_survives(&bsdf);
    for wavelength in [
        "unit=\"Integral\">Visible<",
        "unit=\"Integral\">CIE-u<",
        "unit=\"Integral\">CIE-v<",
        "unit=\"Integral\">Solar<",
        "unit=\"Nanometer\">632.8<",
    ] {
        assert!(text.contains(wavelength), "{wavelength} is not in the file");
    }
    let quarter = Arc::new(Basis::quarter());
    let mut bsdf = grey(Scattering::from(ramp(&quarter, &quarter)));
    let chroma = [(); 2].map(|()| Scattering::from(ramp(&quarter, &quarter)));
    bsdf.bands[0].component_mut(Part::ReflectionBack).unwrap().chroma = Some(chroma);
    assert_survives(&bsdf);
}

#[test]
fn headers_survive() {
    let mut bsdf = grey(Scattering::from(Tree::uniform(Rank::Three, 1.0)));
    let units = [
        LengthUnit::Meter,
        LengthUnit::Foot,
        LengthUnit::Inch,
        LengthUnit::Centimeter,
        LengthUnit::Millimeter,
    ];
    for unit in units {
        bsdf.header = Header {
            name: "A & B <C> \"D\" 'E' ]]> 窓".into(),
            manufacturer: "x".repeat(20),
            thickness: Some(17.3 * unit.meters()),
            width: Some(1e-9 * unit.meters()),
            height: None,
            unit,
            properties: vec![
                ("DeviceType".into(), "Film".into()),
                ("EmissivityFront".into(), "0.84 < 1 & > 0".into()),
                ("AERC-Acceptance_1.0".into(), "@".into()),
            ],
            geometry: Some(Geometry { mgf: "# a < b && c\n\to \"x\"\r\n  \n".into(), unit }),
            provenance: vec![
                "genBSDF -n 4 +geom meter --x---y -\\- -\\\\- \\ -- a-".into(),
                "-leading".into(),
                "<Name>not markup</Name> &amp; two\nlines".into(),
            ],
        };
        let text = assert_survives(&bsdf);
        for comment in text.split("<!--").skip(1) {
            assert!(!comment.split_once("-->").unwrap().0.contains("--"), "{comment}");
        }
    }
}

#[test]
fn lengths_are_written_as_short_as_they_were() {
    let mut bsdf = grey(Scattering::from(Tree::uniform(Rank::Three, 1.0)));
    for k in 1..2000u32 {
        bsdf.header.unit = LengthUnit::Millimeter;
        bsdf.header.thickness = Some(f64::from(k) * 0.001);
        assert!(
            written(&bsdf).contains(&format!("<Thickness unit=\"Millimeter\">{k}</Thickness>")),
            "{k} mm"
        );
    }
}

#[test]
fn control_characters_become_spaces() {
    let mut bsdf = grey(Scattering::from(Tree::uniform(Rank::Three, 1.0)));
    bsdf.header.name = "a\u{0}b\u{1b}c".into();
    bsdf.header.provenance = vec!["d\u{7}e".into()];
    let (again, _) = read(written(&bsdf).as_bytes(), Strictness::Strict).unwrap();
    assert_eq!((again.header.name.as_str(), again.header.provenance[0].as_str()), ("a b c", "d e"));
}

#[test]
fn what_no_file_can_hold_is_refused() {
    let refused = |bsdf: &Bsdf| write(bsdf, &mut Vec::new()).unwrap_err();
    assert!(matches!(refused(&Bsdf::default()), WriteError::Empty));
    let uniform = |rank, value| Scattering::from(Tree::uniform(rank, value));
    let mut mixed = grey(uniform(Rank::Three, 1.0));
    mixed.band_mut("Solar").insert(Part::ReflectionBack, Component::grey(uniform(Rank::Four, 1.0)));
    assert!(matches!(refused(&mixed), WriteError::MixedStructures("TensorTree3", "TensorTree4")));
    assert!(matches!(refused(&grey(uniform(Rank::Three, f32::INFINITY))), WriteError::NotFinite(_)));
    let halves = [Basis::half(), Basis::half_73()].map(Arc::new);
    assert!(matches!(
        refused(&grey(Scattering::from(ramp(&halves[0], &halves[1])))),
        WriteError::AmbiguousBasis(_)
    ));
}

#[test]
fn files_are_replaced_whole_or_not_at_all() {
    let folder = std::env::temp_dir().join(format!("bsdftree-write-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("a.xml");
    let good = grey(Scattering::from(two_levels(Rank::Three)));
    write_file(&good, &path).unwrap();
    let message = write_file(&Bsdf::default(), &path).unwrap_err().to_string();
    assert!(message.contains("a.xml: the BSDF has no component"), "{message}");
    assert_same_bsdf(&read_file(&path, Strictness::Strict).unwrap().0, &good);
    write_file(&grey(Scattering::from(Tree::uniform(Rank::Three, 1.0))), &path).unwrap();
    assert_eq!(read_file(&path, Strictness::Strict).unwrap().0.bands[0].components().count(), 1);
    let names: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["a.xml"], "a temporary file is left over");
    assert!(
        write_file(&good, folder.join("no/such/folder.xml")).unwrap_err().to_string().contains("no/such")
    );
    std::fs::remove_dir_all(&folder).unwrap();
}

#[cfg(unix)]
#[test]
fn links_and_devices_stay_what_they_are() {
    let good = grey(Scattering::from(Tree::uniform(Rank::Three, 0.25)));
    let folder = std::env::temp_dir().join(format!("bsdftree-links-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (file, link) = (folder.join("file.xml"), folder.join("link.xml"));
    std::fs::write(&file, "old").unwrap();
    std::os::unix::fs::symlink(&file, &link).unwrap();
    write_file(&good, &link).unwrap();
    assert!(link.symlink_metadata().unwrap().is_symlink());
    assert_eq!(std::fs::read_to_string(&file).unwrap(), written(&good));
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2, "no temporary file is left");
    write_file(&good, "/dev/null").unwrap();
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
    std::fs::remove_dir_all(&folder).unwrap();
}
