//! What a strict reader takes, what it refuses, and what repair mode makes of that.

mod xml_text;

use bsdftree::xml::{Severity, Strictness, read};
use bsdftree::{Bsdf, LengthUnit, Part};
use xml_text::{
    KLEMS_FULL, SHIRLEY_CHIU, VISIBLE, assert_same_bsdf, block, file, file_of_layer, matrix, repaired,
    strict, tree, tree_file,
};

const GRID: &str = "{ 1 2 3 4 5 6 7 8 }";

fn grid_values(bsdf: &Bsdf, part: Part) -> Vec<f32> {
    tree(&bsdf.band("Visible").unwrap().component(part).unwrap().luminance).to_grid(1)
}

fn assert_reads_as_grid(text: &[u8]) {
    let (bsdf, repairs) = read(text, Strictness::Strict).unwrap_or_else(|e| panic!("{e}"));
    assert!(repairs.is_empty(), "{repairs:?}");
    assert_eq!(grid_values(&bsdf, Part::ReflectionBack), [1., 2., 3., 4., 5., 6., 7., 8.]);
}

/// A strict reader refuses with `found`; repair mode lists it once, with `remedy`.
fn assert_repaired(text: &str, found: &str, remedy: &str) -> Bsdf {
    let error = strict(text).expect_err("a strict reader must refuse this").to_string();
    assert!(error.contains(found) && error.contains(remedy), "{error}");
    assert!(error.contains("repair mode"), "{error}");
    let (bsdf, repairs) = repaired(text).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(repairs.len(), 1, "{repairs:?}");
    assert!(repairs[0].what.contains(found) && repairs[0].what.contains(remedy), "{}", repairs[0]);
    bsdf
}

#[test]
fn harmless_variants_read_strictly() {
    let plain = tree_file("TensorTree3", GRID);
    assert_reads_as_grid(plain.as_bytes());
    assert_reads_as_grid(plain.replace('\n', "\r\n").as_bytes());
    assert_reads_as_grid(format!("\u{FEFF}{plain}").as_bytes());
    assert_reads_as_grid(format!("Recover using: genBSDF -recover /tmp/x\n{plain}").as_bytes());
    assert_reads_as_grid(plain.replace("TensorTree3", " tensortree3 ").as_bytes());
    assert_reads_as_grid(plain.replace("Visible", "visible").as_bytes());
    assert_reads_as_grid(plain.replace("Reflection Back", " reflection  BACK\n").as_bytes());
    assert_reads_as_grid(plain.replace("LBNL/Shirley-Chiu", "lbnl/shirley-chiu").as_bytes());
    assert_reads_as_grid(
        plain.replace("<WindowElement ", "<!DOCTYPE WindowElement>\n<WindowElement ").as_bytes(),
    );
    assert_reads_as_grid(plain.replace("<?xml version=\"1.0\"?>\n", "").as_bytes());
}

#[test]
fn separators_are_space_or_comma() {
    for grid in [
        "{1,2,3,4,5,6,7,8}",
        "{1, 2, 3, 4, 5, 6, 7, 8,}",
        "{ 1 , 2 3\t4\n5\r\n6, 7 8 },",
        "{+1 2.0 3e0 .4e1 5. 0.6E+1 700e-2 8.000000000000000000000000000000}",
        // The same as branches: the other order.
        "{{1}{5}{3}{7},{2} , {6},{4},{8},}",
    ] {
        assert_reads_as_grid(tree_file("TensorTree3", grid).as_bytes());
    }
}

#[test]
fn comments_and_cdata_inside_data_are_not_data() {
    for grid in [
        "<!-- { 9 -->{ 1 2 3 4<!-- 99 --> 5 6 7 8 }<!-- } -->",
        "<![CDATA[{ 1 2 3 4 5 6 7 8 }]]>",
        "{ 1 2 <![CDATA[3 4]]> 5<!--a--><!--b--> 6 7 8 }",
    ] {
        assert_reads_as_grid(tree_file("TensorTree3", grid).as_bytes());
    }
}

#[test]
fn blocks_may_share_a_wavelength_element() {
    let two = |direction: &str, data: &str| {
        format!(
            "<WavelengthDataBlock><WavelengthDataDirection>{direction}</WavelengthDataDirection>{SHIRLEY_CHIU}\
             <ScatteringData>{data}</ScatteringData></WavelengthDataBlock>"
        )
    };
    let blocks = two("Reflection Back", GRID) + &two("Transmission Back", "{ 0.5 }");
    let text = file("TensorTree3", &format!("<WavelengthData>{VISIBLE}{blocks}</WavelengthData>"));
    let bsdf = strict(&text).unwrap();
    assert_eq!(grid_values(&bsdf, Part::ReflectionBack)[7], 8.0);
    assert_eq!(grid_values(&bsdf, Part::TransmissionBack), [0.5; 8]);
}

#[test]
fn names_resolve_entities_and_encodings() {
    let layer = |name: &str| {
        let material = format!("<Material><Name>{name}</Name></Material>");
        tree_file("TensorTree3", GRID).replace("<DataDefinition>", &format!("{material}<DataDefinition>"))
    };
    let name = |text: &str| strict(text).unwrap().header.name;
    assert_eq!(name(&layer(" A &amp; B &lt;&#67;&gt;<!-- no --><![CDATA[ & <D>]]> ")), "A & B <C> & <D>");
    assert_eq!(name(&layer("Fenêtre 窓")), "Fenêtre 窓");

    let latin1 = |text: &str| -> Vec<u8> { text.chars().map(|c| c as u8).collect() };
    let declared = layer("Fenêtre").replace("version=\"1.0\"", "version=\"1.0\" encoding=\"ISO-8859-1\"");
    let (bsdf, repairs) = read(&latin1(&declared), Strictness::Strict).unwrap();
    assert_eq!((bsdf.header.name.as_str(), repairs.len()), ("Fenêtre", 0));

    let undeclared = latin1(&layer("Fenêtre"));
    let error = read(&undeclared, Strictness::Strict).unwrap_err();
    assert_eq!(undeclared[error.offset as usize], 0xEA, "{error}");
    let (bsdf, repairs) = read(&undeclared, Strictness::Repair).unwrap();
    assert_eq!(bsdf.header.name, "Fenêtre");
    assert_eq!(undeclared[repairs[0].offset as usize], 0xEA);

    let bsdf = assert_repaired(&layer("Hunter & Douglas"), "`&` that begins no entity", "taken as it stands");
    assert_eq!(bsdf.header.name, "Hunter & Douglas");
}

#[test]
fn transmission_without_a_side_is_transmission_back() {
    let text = tree_file("TensorTree3", GRID).replace("Reflection Back", "Transmission");
    let bsdf = assert_repaired(&text, "`Transmission` without a side", "Transmission Back");
    assert_eq!(grid_values(&bsdf, Part::TransmissionBack)[1], 2.0);
}

#[test]
fn negative_values_are_counted_and_become_zero() {
    let bsdf =
        assert_repaired(&tree_file("TensorTree3", "{ 1 -2 3 -0 5 6 -7e-9 8 }"), "2 negative values", "as 0");
    assert_eq!(grid_values(&bsdf, Part::ReflectionBack), [1., 0., 3., 0., 5., 6., 0., 8.]);
    let data = vec!["-1"; 145 * 145].join(" ");
    let text = file("Columns", &block(VISIBLE, "Reflection Back", KLEMS_FULL, &data));
    assert_repaired(&text, "21025 negative values", "as 0");
    // Negative zero is zero, nothing to repair.
    assert!(strict(&tree_file("TensorTree3", "{ -0.0 }")).is_ok());
}

#[test]
fn what_radiance_drops_silently_is_refused_or_listed() {
    let extra = |block: &str| tree_file("TensorTree3", GRID).replace("</Layer>", &format!("{block}</Layer>"));
    let other =
        |wavelength: &str, direction: &str| extra(&block(wavelength, direction, SHIRLEY_CHIU, "{ 0.5 }"));
    assert_repaired(&other(VISIBLE, "Sideways"), "direction `Sideways`", "ignored");
    assert_repaired(&other(VISIBLE, ""), "direction ``", "ignored");
    let bsdf = assert_repaired(
        &other(VISIBLE, "Reflection Back"),
        "a second Reflection Back",
        "instead of the first",
    );
    assert_eq!(grid_values(&bsdf, Part::ReflectionBack), [0.5; 8]);
    let bsdf = assert_repaired(&other("", "Transmission Back"), "without a Wavelength", "Visible");
    assert_eq!(grid_values(&bsdf, Part::TransmissionBack), [0.5; 8]);
    assert_repaired(
        &extra("<WavelengthData></WavelengthData>")
            .replace("<WavelengthData></", &format!("<WavelengthData>{VISIBLE}</")),
        "without a WavelengthDataBlock",
        "ignored",
    );
    let layer = "</Layer><Layer><DataDefinition/></Layer><Layer/>";
    assert_repaired(
        &tree_file("TensorTree3", GRID).replace("</Layer>", layer),
        "2 more layers",
        "only the first",
    );
    assert_repaired(
        &tree_file("TensorTree3", GRID).replace(SHIRLEY_CHIU, ""),
        "without an AngleBasis",
        "Shirley-Chiu",
    );
    assert_repaired(&(tree_file("TensorTree3", GRID) + "garbage"), "`garbage` outside the root", "ignored");
    let twice = format!("<ScatteringData>{GRID}</ScatteringData>");
    assert_repaired(
        &tree_file("TensorTree3", GRID).replace(&twice, &twice.repeat(2)),
        "a second ScatteringData",
        "first",
    );
}

#[test]
fn absorbed_directions_are_noted() {
    let absorbed = block(VISIBLE, "Absorbed Front", KLEMS_FULL, "0.1 0.2");
    let text = tree_file("TensorTree3", GRID).replace("</Layer>", &format!("{absorbed}</Layer>"));
    let (bsdf, repairs) = read(text.as_bytes(), Strictness::Strict).unwrap();
    assert_eq!(bsdf.bands[0].components().count(), 1);
    assert_eq!((repairs.len(), repairs[0].severity), (1, Severity::Note));
    assert!(repairs[0].to_string().contains("Absorbed Front"), "{}", repairs[0]);
    assert_eq!(repairs[0].line as usize, text[..repairs[0].offset as usize].lines().count());
}

#[test]
fn lengths_have_the_units_of_the_file() {
    let with = |material: &str| {
        let material = format!("<Material>{material}</Material><DataDefinition>");
        tree_file("TensorTree3", GRID).replace("<DataDefinition>", &material)
    };
    let header = |material: &str| strict(&with(material)).unwrap().header;
    let inch =
        header("<Thickness unit=\"INCH\"> 2 </Thickness><Width unit=\"foot\">1</Width><Height>3</Height>");
    assert_eq!([inch.thickness, inch.width, inch.height], [Some(0.0508), Some(0.3048), Some(3.0)]);
    assert_eq!(inch.unit, LengthUnit::Inch);
    assert_eq!(header("<Thickness unit=\"meter\"></Thickness>").thickness, None);
    assert_repaired(&with("<Thickness unit=\"furlong\">1</Thickness>"), "`furlong`", "taken as meter");
    assert_repaired(&with("<Width unit=\"meter\">wide</Width>"), "`wide`, not a length", "left out");
    assert_repaired(&with("<Width unit=\"meter\">-1</Width>"), "`-1`, not a length", "left out");
    assert_repaired(&with("<Width unit=\"meter\">nan</Width>"), "`nan`, not a length", "left out");
}

#[test]
fn plain_properties_of_the_material_are_kept() {
    let material = "<Material><Name>n</Name><DeviceType>Film</DeviceType><TIR> 0.1 </TIR><EmissivityBack/>\
                    <TIR>0.2</TIR><Color unit=\"x\">1</Color><Layers><Layer>2</Layer></Layers></Material>";
    let text =
        tree_file("TensorTree3", GRID).replace("<DataDefinition>", &format!("{material}<DataDefinition>"));
    let (bsdf, notes) = read(text.as_bytes(), Strictness::Strict).unwrap();
    let kept = [("DeviceType", "Film"), ("TIR", "0.1")].map(|(name, text)| (name.into(), text.into()));
    assert_eq!(bsdf.header.properties, kept);
    let notes: Vec<String> = notes.iter().map(ToString::to_string).collect();
    for name in ["TIR", "Color", "Layers"] {
        assert!(notes.iter().any(|note| note.ends_with(&format!("not kept: {name}"))), "{name}: {notes:?}");
    }
}

#[test]
fn geometry_in_another_format_is_refused() {
    let with = |geometry: &str| {
        tree_file("TensorTree3", GRID).replace("<DataDefinition>", &format!("{geometry}<DataDefinition>"))
    };
    let geometry = strict(&with(
        "<Geometry format=\"mgf\"><MGFblock unit=\"Millimeter\">o a &lt; b\n</MGFblock></Geometry>",
    ));
    let geometry = geometry.unwrap().header.geometry.unwrap();
    assert_eq!((geometry.mgf.as_str(), geometry.unit), ("o a < b\n", LengthUnit::Millimeter));
    let bsdf = assert_repaired(
        &with("<Geometry format=\"STEP\"><MGFblock>x</MGFblock></Geometry>"),
        "`STEP`",
        "left out",
    );
    assert_eq!(bsdf.header.geometry, None);
}

#[test]
fn tree_colour_is_u_and_v() {
    let channel = |name: &str, data: &str| {
        block(&format!("<Wavelength>{name}</Wavelength>"), "Reflection Back", SHIRLEY_CHIU, data)
    };
    // In any order, each with its own subdivision.
    let blocks = [
        channel("CIE-v", "{ 0.47 }"),
        channel("cie-U", "{ .1 .2 .1 .2 .1 .2 .1 .2 }"),
        channel("Visible", GRID),
    ];
    let bsdf = strict(&file("TensorTree3", &blocks.concat())).unwrap();
    assert_eq!(bsdf.bands.len(), 1);
    let [u, v] = bsdf.bands[0].component(Part::ReflectionBack).unwrap().chroma.as_ref().unwrap();
    assert_eq!(tree(u).to_grid(1)[..2], [0.1, 0.2]);
    assert_eq!(tree(v).to_grid(0), [0.47]);

    let without_v = file("TensorTree3", &blocks[1..].concat());
    let bsdf = assert_repaired(&without_v, "CIE-u without CIE-v", "colour left out");
    assert!(bsdf.bands[0].component(Part::ReflectionBack).unwrap().chroma.is_none());
    let without_u = file("TensorTree3", &[&blocks[0][..], &blocks[2]].concat());
    assert_repaired(&without_u, "CIE-v without CIE-u", "colour left out");
    let without_y = file("TensorTree3", &(blocks[..2].concat() + &channel("Solar", GRID)));
    assert_repaired(&without_y, "CIE-u and CIE-v without Visible", "colour left out");
    let x = file("TensorTree3", &(blocks[2].clone() + &channel("CIE-X", GRID)));
    assert_repaired(&x, "CIE-X data: trees are coloured by CIE-u", "left out");
}

#[test]
fn matrix_colour_is_x_and_z_over_the_bases_of_y() {
    let channel = |name: &str, basis: &str, n: usize, value: &str| {
        let bases = format!(
            "<ColumnAngleBasis>LBNL/Klems {basis}</ColumnAngleBasis><RowAngleBasis>LBNL/Klems {basis}</RowAngleBasis>"
        );
        let data = vec![value; n * n].join(" ");
        block(&format!("<Wavelength>{name}</Wavelength>"), "Reflection Back", &bases, &data)
    };
    let y = channel("Visible", "Quarter", 41, "0.2");
    let z = channel("CIE-Z", "Quarter", 41, "0.3");
    let text = file("Columns", &[y.clone(), channel("CIE-X", "Quarter", 41, "0.1"), z.clone()].concat());
    let bsdf = strict(&text).unwrap();
    let chroma = bsdf.bands[0].component(Part::ReflectionBack).unwrap().chroma.as_ref().unwrap();
    assert_eq!(chroma.each_ref().map(|c| matrix(c).values()[0]), [0.1, 0.3]);
    let other = file("Columns", &[y.clone(), channel("CIE-X", "Full", 145, "0.1"), z].concat());
    assert_repaired(&other, "other angle bases than Visible", "colour left out");
    assert_repaired(&file("Columns", &(y + &channel("CIE-u", "Quarter", 41, "1"))), "CIE-u data", "left out");
}

#[test]
fn wavelengths_are_bands() {
    let band = |wavelength: &str, value: &str| {
        block(wavelength, "Reflection Back", SHIRLEY_CHIU, &format!("{{{value}}}"))
    };
    let blocks = [
        band("<Wavelength unit=\"Nanometer\">550.5</Wavelength>", "1"),
        band("<Wavelength unit=\"Integral\">NIR</Wavelength>", "2"),
        band("<Wavelength unit=\"Integral\">Solar</Wavelength>", "3"),
    ];
    let bsdf = strict(&file("TensorTree4", &blocks.concat())).unwrap();
    assert_eq!(bsdf.bands.iter().map(|b| b.name.as_str()).collect::<Vec<_>>(), ["550.5", "NIR", "Solar"]);
}

/// Rings, each as lower bound, upper bound, number of patches.
fn definition(name: &str, rings: &[(f64, f64, &str)]) -> String {
    let ring = |(lower, upper, n): &(f64, f64, &str)| {
        format!(
            "<AngleBasisBlock><Theta>0</Theta><nPhis>{n}</nPhis><ThetaBounds><LowerTheta>{lower}</LowerTheta>\
             <UpperTheta>{upper}</UpperTheta></ThetaBounds></AngleBasisBlock>"
        )
    };
    let rings: String = rings.iter().map(ring).collect();
    format!("<AngleBasis><AngleBasisName>{name}</AngleBasisName>{rings}</AngleBasis>")
}

fn defined(definitions: &str, bases: [&str; 2], n_values: usize) -> String {
    let bases = format!(
        "<ColumnAngleBasis>{}</ColumnAngleBasis><RowAngleBasis>{}</RowAngleBasis>",
        bases[0], bases[1]
    );
    let data = (0..n_values).map(|k| k.to_string()).collect::<Vec<_>>().join(" ");
    file_of_layer(&format!(
        "<DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure>{definitions}</DataDefinition>{}",
        block(VISIBLE, "Reflection Back", &bases, &data)
    ))
}

#[test]
fn bases_of_the_file_are_used() {
    let definitions = definition("Mine", &[(0., 30., "1"), (30., 90., "3")])
        + &definition("LBNL/Klems Quarter", &[(0., 9., "1"), (9., 90., "4")]);
    let text = defined(&definitions, ["mine", "LBNL/Klems Quarter"], 20);
    let (bsdf, notes) = read(text.as_bytes(), Strictness::Strict).unwrap();
    let matrix = matrix(&bsdf.bands[0].component(Part::ReflectionBack).unwrap().luminance);
    assert_eq!([matrix.incident().n_patches(), matrix.exitant().n_patches()], [4, 5]);
    assert_eq!(matrix.values()[..6], [0., 4., 8., 12., 16., 1.]);
    assert_eq!(notes.len(), 1);
    assert!(notes[0].what.contains("LBNL/Klems Quarter is used"), "{}", notes[0]);

    let twice = definitions.clone() + &definition("Mine", &[(0., 90., "4")]);
    assert_repaired(
        &defined(&twice, ["Mine", "Mine"], 16),
        "a second, different definition of Mine",
        "the first used",
    );
    let one = definition("Mine", &[(0., 30., "1"), (30., 90., "3")]);
    let text = defined(&one, ["Mine", "Mine"], 16).replace("<RowAngleBasis>Mine</RowAngleBasis>", "");
    assert_repaired(&text, "without RowAngleBasis", "taken as Mine, the only one");
}

#[test]
fn half_basis_is_told_by_the_number_of_values() {
    for (n, rings) in [(73, 12), (77, 12)] {
        let bsdf = strict(&defined("", ["LBNL/Klems Half"; 2], n * n)).unwrap();
        let matrix = matrix(&bsdf.bands[0].component(Part::ReflectionBack).unwrap().luminance);
        assert_eq!([matrix.incident().n_patches(), matrix.exitant().n_patches()], [n, n]);
        assert_eq!(matrix.incident().rings()[2].n_phi, rings);
    }
    let error = strict(&defined("", ["LBNL/Klems Half"; 2], 5000)).unwrap_err().to_string();
    assert!(error.contains("5000 values") && error.contains("5329 or 5621 or 5929"), "{error}");
}

#[test]
fn repair_mode_reads_good_files_the_same() {
    let text = tree_file("TensorTree3", GRID);
    let (again, repairs) = repaired(&text).unwrap();
    assert!(repairs.is_empty());
    assert_same_bsdf(&strict(&text).unwrap(), &again);
}
