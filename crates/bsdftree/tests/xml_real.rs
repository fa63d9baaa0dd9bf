//! Real files of other people.

mod xml_text;

use bsdftree::xml::{Severity, Strictness, parse_tree, read_file, write};
use bsdftree::{Part, Rank};
use bsdftree_testing::{READABLE, real_file};
use xml_text::{assert_same_bsdf, matrix, tree};

#[test]
fn whole_files_read_strictly() {
    for path in READABLE.iter().filter_map(|path| real_file(path)) {
        let (_, repairs) = read_file(&path, Strictness::Strict).unwrap_or_else(|error| panic!("{error}"));
        assert!(repairs.iter().all(|r| r.severity == Severity::Note), "{repairs:?}");
    }
}

#[test]
fn truncated_matrices_are_refused_even_in_repair_mode() {
    for name in ["2011-SA1-Small-CommaSeparated.XML", "2011-SA1-Small-TabSeparated.XML"] {
        let Some(path) = real_file(&format!("bsdfxmlparser/{name}")) else { return };
        for strictness in [Strictness::Strict, Strictness::Repair] {
            let message = read_file(&path, strictness).unwrap_err().to_string();
            assert!(message.contains(name), "{message}");
            assert!(message.contains("line 107"), "{message}");
            assert!(message.contains("found 4 values in the matrix; expected 21025"), "{message}");
        }
    }
}

#[test]
fn real_files_survive_writing_exactly() {
    for path in READABLE.iter().filter_map(|path| real_file(path)) {
        let (first, _) = read_file(&path, Strictness::Strict).unwrap();
        let mut text = Vec::new();
        write(&first, &mut text).unwrap();
        let (second, repairs) = bsdftree::xml::read(&text, Strictness::Strict)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(repairs.is_empty(), "{}: {repairs:?}", path.display());
        assert_same_bsdf(&first, &second);
        let mut again = Vec::new();
        write(&second, &mut again).unwrap();
        assert!(text == again, "{} is not written the same way twice", path.display());
    }
}

/// Record n of `cnt 256 | rcalc -e '$1=floor(sin(PI/256*recno)*40)'`, counted from 1.
fn formula(record: usize) -> f64 {
    ((std::f64::consts::PI / 256.0 * record as f64).sin() * 40.0).floor()
}

/// rttree_reduce reads the 4 × 8 × 8 cells with d0 < ½ of an 8³ grid, d0 slowest, and makes each leaf the mean of its cells.
#[test]
fn leaves_are_where_the_closed_formula_puts_them() {
    let Some(text) = real_file("radiance/ttree.txt") else { return };
    let tree = parse_tree(&std::fs::read(text).unwrap(), Rank::Three).unwrap();
    let mut finest = 0;
    for leaf in tree.leaves() {
        let edge = 8usize >> leaf.level;
        let [x, y, z] = [0, 1, 2].map(|i| leaf.cell[i] as usize * edge);
        let cells = (0..edge.pow(3)).map(|k| [x + k / edge / edge, y + k / edge % edge, z + k % edge]);
        let value = |[x, y, z]: [usize; 3]| if x < 4 { formula(64 * x + 8 * y + z + 1) } else { 0.0 };
        let mean = cells.map(value).sum::<f64>() / edge.pow(3) as f64;
        // The file has seven digits.
        assert!((f64::from(leaf.value) - mean).abs() <= 1e-5, "{leaf:?}: the formula gives {mean}");
        finest += usize::from(edge == 1);
    }
    assert_eq!(tree.arena().log2_res(), 3);
    // The four grids of the file: only they tell one grid order from another.
    assert_eq!(finest, 32);
}

#[test]
fn a_tree_in_a_file_is_the_raw_tree() {
    let (Some(text), Some(file)) = (real_file("radiance/ttree.txt"), real_file("radiance/testBSDF.xml"))
    else {
        return;
    };
    let raw = parse_tree(&std::fs::read(text).unwrap(), Rank::Three).unwrap();
    let (bsdf, _) = read_file(file, Strictness::Strict).unwrap();
    let component = bsdf.bands[0].component(Part::ReflectionBack).unwrap();
    assert!(tree(&component.luminance).leaves().eq(raw.leaves()));
}

#[test]
fn line_before_the_declaration_is_kept_as_provenance() {
    let Some(path) = real_file("pyradiance/blindsT3.xml") else { return };
    let (bsdf, _) = read_file(path, Strictness::Strict).unwrap();
    let provenance = &bsdf.header.provenance;
    assert!(provenance[0].starts_with("Recover using: /home/hksline/radiance/bin/genBSDF"), "{provenance:?}");
    assert!(provenance[1].starts_with("Created by: genBSDF -n 16 -c 10000"), "{provenance:?}");
}

#[test]
fn device_is_read_with_its_units() {
    let Some(path) = real_file("radiance/sawtooth.xml") else { return };
    let (bsdf, _) = read_file(path, Strictness::Strict).unwrap();
    assert_eq!(bsdf.header.unit, bsdftree::LengthUnit::Millimeter);
    assert_eq!(
        [bsdf.header.thickness, bsdf.header.width, bsdf.header.height],
        [Some(0.002), Some(0.24), Some(0.24)]
    );
    assert_eq!(bsdf.header.geometry, None);
    let Some(path) = real_file("frads/blinds30.xml") else { return };
    let geometry = read_file(path, Strictness::Strict).unwrap().0.header.geometry.unwrap();
    assert_eq!(geometry.unit, bsdftree::LengthUnit::Meter);
    assert!(geometry.mgf.starts_with("xf -t -0.000000 -0.000000 0\n"), "{}", &geometry.mgf[..40]);
    assert!(geometry.mgf.ends_with("xf\n"), "the MGF text is cut off");
}

/// Values of the text itself: the first line is the first exitant patch, the first column the first incident one.
#[test]
fn lines_of_columns_are_exitant_patches() {
    let Some(path) = real_file("radiance/sawtooth.xml") else { return };
    let (bsdf, _) = read_file(path, Strictness::Strict).unwrap();
    let matrix = matrix(&bsdf.bands[0].component(Part::ReflectionBack).unwrap().luminance);
    let value = |incident: usize, exitant: usize| matrix.values()[incident * 145 + exitant];
    assert_eq!([value(0, 0), value(1, 0), value(2, 0)], [6.997e-2, 4.196e-2, 2.815e-2]);
    assert_eq!([value(0, 1), value(1, 1)], [1.269e-1, 1.119e-1]);
}

#[test]
fn solar_is_a_band_of_its_own() {
    let Some(path) = real_file("frads/ec60.xml") else { return };
    let (bsdf, _) = read_file(path, Strictness::Strict).unwrap();
    let parts = |band: &str| bsdf.band(band).unwrap().components().map(|(part, _)| part).collect::<Vec<_>>();
    assert_eq!(parts("visible"), [Part::TransmissionFront, Part::TransmissionBack]);
    assert_eq!(parts("solar"), [Part::ReflectionBack, Part::TransmissionFront]);
}
