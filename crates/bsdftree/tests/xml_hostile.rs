//! Files that are damaged or made to harm: each is refused, at a place, saying what was found and expected.

mod xml_text;

use bsdftree::Rank;
use bsdftree::xml::{Strictness, XmlError, parse_tree, read, read_file};
use xml_text::{KLEMS_FULL, SHIRLEY_CHIU, VISIBLE, block, file, tree_file};

const GRID: &str = "{ 1 2 3 4 5 6 7 8 }";

/// Refused in both modes with a message that holds all of `parts`.
fn refused(bytes: &[u8], parts: &[&str]) -> XmlError {
    for strictness in [Strictness::Repair, Strictness::Strict] {
        let error = read(bytes, strictness).expect_err("this must be refused");
        let message = error.to_string();
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
        assert!(message.len() < 400, "{message}");
        assert!(error.offset <= bytes.len() as u64 && error.line >= 1);
        if strictness == Strictness::Strict {
            return error;
        }
    }
    unreachable!()
}

/// As [`refused`], at the place of `at`.
fn refused_at(text: &str, at: &str, parts: &[&str]) {
    let error = refused(text.as_bytes(), parts);
    let offset = text.find(at).unwrap_or_else(|| panic!("`{at}` is not in the text"));
    assert_eq!(error.offset as usize, offset, "{error}");
    assert_eq!(error.line as usize, 1 + text[..offset].matches('\n').count(), "{error}");
}

fn tree_refused(tree: &str, at: &str, parts: &[&str]) {
    refused_at(&tree_file("TensorTree3", tree), at, parts);
}

#[test]
fn what_is_no_text_is_refused() {
    refused(b"", &["empty"]);
    refused(b" \r\n\t", &["empty"]);
    refused(b"\xEF\xBB\xBF", &["empty"]);
    refused(b"plain text", &["no markup"]);
    refused(b"a < b < 3", &["no markup"]);
    let text = tree_file("TensorTree3", GRID);
    let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    refused(&little, &["UTF-16"]);
    refused(&big, &["UTF-16"]);
    refused(&[&b"\xFF\xFE"[..], &little].concat(), &["UTF-16", "convert"]);
    refused(b"\x7FELF\x02\x01\x01\0\0\0", &["binary"]);
    refused(&text.replace('4', "\0").into_bytes(), &["zero byte"]);
    refused(b"<!-- nothing else -->", &["no XML element"]);
    refused(b"{ 1 }", &["no markup"]);
}

#[test]
fn a_file_of_something_else_is_refused() {
    refused(b"<html><body/></html>", &["root element is `html`", "expected WindowElement"]);
    let text = tree_file("TensorTree3", GRID);
    refused_at(
        &text.replace("<FileType>BSDF", "<FileType>Non-BSDF"),
        "<FileType>",
        &["`Non-BSDF`", "expected BSDF"],
    );
    refused_at(
        &text.replace("TensorTree3", "TensorTree5"),
        "<IncidentDataStructure>",
        &["`TensorTree5`", "Columns, Rows"],
    );
    refused(b"<WindowElement/>", &["<WindowElement> has no <Optical>"]);
    refused(b"<WindowElement><Optical/></WindowElement>", &["<Optical> has no <Layer>"]);
    refused(
        b"<WindowElement><Optical><Layer/></Optical></WindowElement>",
        &["<Layer> has no <DataDefinition>"],
    );
    refused(file("TensorTree3", "").as_bytes(), &["no component"]);
    let block = block(VISIBLE, "Reflection Back", SHIRLEY_CHIU, GRID);
    let empty = block.replace(&format!("<ScatteringData>{GRID}</ScatteringData>"), "");
    refused_at(&file("TensorTree3", &empty), "<WavelengthDataBlock>", &["has no <ScatteringData>"]);
    refused_at(
        &text.replace("LBNL/Shirley-Chiu", "LBNL/Klems Full"),
        "<AngleBasis>",
        &["`LBNL/Klems Full`", "expected LBNL/Shirley-Chiu"],
    );
}

#[test]
fn every_truncation_is_refused() {
    let text = tree_file("TensorTree3", GRID);
    let end = text.find("</WindowElement>").unwrap();
    for length in 0..end + "</WindowElement".len() {
        refused(&text.as_bytes()[..length], &[]);
    }
    refused(
        &text.as_bytes()[..text.find("7 8").unwrap()],
        &["the file ends inside <ScatteringData>", "truncated"],
    );
    refused(&text.as_bytes()[..end], &["the file ends inside <WindowElement>"]);
}

#[test]
fn broken_markup_is_refused() {
    let text = tree_file("TensorTree3", GRID);
    refused(text.replace("</Layer>", "</Later>").as_bytes(), &["not well-formed", "Layer"]);
    refused(text.replace("</Layer>", "").as_bytes(), &["not well-formed"]);
    refused((text.clone() + "<again/>").as_bytes(), &["second root element"]);
    refused_at(&text.replace("3 4", "3 <b>4</b>"), "<b>", &["markup inside text", "ScatteringData"]);
    refused_at(&text.replace("3 4", "3 &four;"), "&four;", &["a reference inside the data", "`&four;"]);
}

#[test]
fn entities_are_never_expanded() {
    let mut bomb =
        String::from("<?xml version=\"1.0\"?>\n<!DOCTYPE WindowElement [<!ENTITY a \"0 0 0 0 0 0 0 0 0 0\">");
    for (name, inner) in ('b'..='j').zip('a'..) {
        bomb += &format!("<!ENTITY {name} \"{}\">", format!("&{inner};").repeat(10));
    }
    let text = tree_file("TensorTree3", "{ &j; }").replace("<?xml version=\"1.0\"?>\n", &(bomb + "]>\n"));
    refused_at(&text, "<!DOCTYPE", &["declares entities", "delete the DOCTYPE"]);
    let external = tree_file("TensorTree3", GRID).replace(
        "<WindowElement ",
        "<!DOCTYPE x [<!ENTITY e SYSTEM \"file:///etc/passwd\">]><WindowElement ",
    );
    refused(external.as_bytes(), &["declares entities"]);
}

#[test]
fn deep_nesting_is_refused() {
    let elements = tree_file("TensorTree3", &("<a>".repeat(1_000_000) + &"</a>".repeat(1_000_000)));
    refused(elements.as_bytes(), &["more than 32 elements inside each other"]);
    let braces = "{".repeat(1_000_000);
    let text = tree_file("TensorTree3", &braces);
    let error = refused(text.as_bytes(), &["subdivided more than 15 times"]);
    assert_eq!(error.offset as usize, text.find('{').unwrap() + 15);
    refused(
        tree_file("TensorTree4", &(braces.clone() + "1" + &"}".repeat(1_000_000))).as_bytes(),
        &["more than 15 times"],
    );
    assert!(parse_tree(braces.as_bytes(), Rank::Four).is_err());
}

#[test]
fn a_grid_at_the_bottom_counts_as_depth() {
    // 15 branches, then a grid of 2 per axis: 16 subdivisions.
    let mut tree = String::from("{ 1 2 3 4 5 6 7 8 }");
    for _ in 0..15 {
        tree = format!("{{{tree}{}}}", "{0}".repeat(7));
    }
    refused(tree_file("TensorTree3", &tree).as_bytes(), &["subdivided more than 15 times"]);
}

#[test]
fn endless_repetition_is_refused() {
    let many = tree_file("TensorTree3", GRID).replace("</Layer>", &("<a/>".repeat(1 << 20) + "</Layer>"));
    refused(many.as_bytes(), &["more than 131072 elements"]);
    let comments = "<!--a-->".repeat(1 << 16) + &tree_file("TensorTree3", GRID);
    refused(comments.as_bytes(), &["more than 4096 comments"]);
    let attributes: String = (0..100_000).map(|k| format!(" a{k}=\"\"")).collect();
    refused(
        tree_file("TensorTree3", GRID).replace("<Layer>", &format!("<Layer{attributes}>")).as_bytes(),
        &["bytes in one tag"],
    );
}

#[test]
fn over_long_names_are_refused() {
    let long = "x".repeat(1 << 20);
    let text = tree_file("TensorTree3", GRID);
    let name = |element: &str| {
        let material = format!("<Material><{element}>{long}</{element}></Material><DataDefinition>");
        text.replace("<DataDefinition>", &material)
    };
    for element in ["Name", "Manufacturer", "Thickness"] {
        refused_at(&name(element), &format!("<{element}>"), &["more than 4096 bytes in a name"]);
    }
    refused(text.replace("LBNL/Shirley-Chiu", &long).as_bytes(), &["bytes in a name"]);
    refused(text.replace("TensorTree3", &long).as_bytes(), &["bytes in a name"]);
    refused(text.replace("Visible", &long).as_bytes(), &["bytes in a name"]);
    refused(text.replace("Reflection Back", &long).as_bytes(), &["bytes in a name"]);
    refused(text.replace("WindowElement", &long).as_bytes(), &["bytes in one tag"]);
    let unit = format!("<Material><Width unit=\"{long}\">1</Width></Material><DataDefinition>");
    refused(text.replace("<DataDefinition>", &unit).as_bytes(), &["bytes in one tag"]);
}

#[test]
fn numbers_that_are_none_are_refused() {
    for (number, problem) in [
        ("nan", "a BSDF is finite"),
        ("-NaN", "a BSDF is finite"),
        ("inf", "a BSDF is finite"),
        ("-infinity", "a BSDF is finite"),
        ("1e999", "over the largest value"),
        ("-1e999", "over the largest value"),
        ("1e39", "over the largest value"),
        ("3.5e38", "over the largest value"),
        ("0x10", "something follows"),
        ("1.2.3", "something follows"),
        ("4e", "something follows"),
        ("1;2", "something follows"),
        ("five", "it is not one"),
        ("-", "it is not one"),
        ("1e99999999999999999999", "over the largest value"),
    ] {
        let tree = GRID.replace('4', number).replace("{ 1", "{ 9\n\n");
        tree_refused(&tree, &format!("{number} 5"), &["where a number is expected", problem]);
    }
    let data = vec!["0.1"; 21024].join(" ") + "\nNaN";
    refused_at(
        &file("Columns", &block(VISIBLE, "Reflection Back", KLEMS_FULL, &data)),
        "NaN",
        &["`NaN`", "finite"],
    );
    assert!(parse_tree(b"{ 3.4028235e38 }", Rank::Three).is_ok(), "the largest value is a number");
    assert_eq!(parse_tree(b"{ 1e-999 }", Rank::Three).unwrap().minimum(), 0.0);
}

#[test]
fn wrong_counts_are_refused() {
    tree_refused("{ 1 2 3 4 5 6 7 }", "{ 1", &["7 values in a node", "expected 1, 8, 64, 512 …", "rank 3"]);
    tree_refused("{ 1 2 3 4 5 6 7 8 9 }", "{ 1", &["9 values in a node"]);
    tree_refused("{ }", "{ }", &["0 values in a node"]);
    tree_refused("{ 1 2 }", "{ 1", &["2 values in a node"]);
    tree_refused("{{1}{2}{3}{4}{5}{6}{7}}", "{{1", &["7 children in a node", "expected 8, as rank 3 has"]);
    tree_refused("{{1}{2}{3}{4}{5}{6}{7}{8}{9}}", "{{1", &["more than 8 children"]);
    let sixteen = "{ 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 }";
    tree_refused(sixteen, "{ 1", &["16 values in a node", "rank 3"]);
    assert!(parse_tree(sixteen.as_bytes(), Rank::Four).is_ok());
    for n in [0, 21024, 21026] {
        let data = vec!["1"; n].join(" ");
        let text = file("Columns", &block(VISIBLE, "Reflection Back", KLEMS_FULL, &data));
        refused_at(&text, "<ScatteringData>", &[&format!("{n} values in the matrix"), "expected 21025"]);
    }
}

#[test]
fn misplaced_braces_are_refused() {
    tree_refused("{ 1 } 2", "2<", &["found `2`", "expected nothing after the last brace"]);
    tree_refused("{ 1 } }", "}<", &["found `}`", "nothing after"]);
    tree_refused("{ 1 2 3 4 5 6 7 8", "</Scat", &["the end of the data", "a number or `}`"]);
    tree_refused("{{1}{2}{3}{4}{5}{6}{7}{8}", "</Scat", &["the end of the data", "expected `}`"]);
    tree_refused("{{1}{2}{3}", "</Scat", &["the end of the data", "expected `{`"]);
    tree_refused("1 2 3", "1 2 3", &["found `1`", "expected `{`"]);
    tree_refused("", "</Scat", &["the end of the data", "expected `{`"]);
    tree_refused("{ 1 {2} }", "{2}", &["found `{`", "began with numbers"]);
    tree_refused("{{1} 2 {3}}", "2 {3}", &["found `2`", "expected `{`"]);
    tree_refused("{,1}", ",1}", &["found `,`"]);
    tree_refused("{1,,2}", ",2}", &["found `,`"]);
    assert!(parse_tree(b"", Rank::Three).unwrap_err().to_string().contains("empty"));
}

#[test]
fn claims_cost_no_memory() {
    let definition = |n: &str| {
        format!(
            "<AngleBasis><AngleBasisName>Big</AngleBasisName><AngleBasisBlock><nPhis>{n}</nPhis><ThetaBounds>\
             <LowerTheta>0</LowerTheta><UpperTheta>90</UpperTheta></ThetaBounds></AngleBasisBlock></AngleBasis>"
        )
    };
    let with = |n: &str| {
        let bases = "<ColumnAngleBasis>Big</ColumnAngleBasis><RowAngleBasis>Big</RowAngleBasis>";
        file("Columns", &block(VISIBLE, "Reflection Back", bases, "1 2 3"))
            .replace("</DataDefinition>", &format!("{}</DataDefinition>", definition(n)))
    };
    refused(with("1000000000").as_bytes(), &["`Big`", "over 65536 patches"]);
    refused(with("99999999999999999999").as_bytes(), &["nPhis is a whole number"]);
    refused(with("-1").as_bytes(), &["nPhis is a whole number"]);
    refused(with("2.5").as_bytes(), &["`2.5`", "nPhis is a whole number"]);
    refused(with("many").as_bytes(), &["`many`", "not a finite number"]);
    refused(with("0").as_bytes(), &["`Big`", "no patches"]);
    // 17 GB, if it were believed.
    refused(with("65536").as_bytes(), &["3 values in the matrix", "expected 4294967296 for Big by Big"]);
    refused(with("8").replace("90</Upper", "80</Upper").as_bytes(), &["`Big`", "ends at 80"]);
    refused(with("8").replace("90</Upper", "nan</Upper").as_bytes(), &["`nan`", "not a finite number"]);
}

/// As many as the bound on elements lets through: each is looked up among all others.
#[test]
fn many_bands_read_in_bounded_time() {
    let band =
        |k: usize| block(&format!("<Wavelength>{k}</Wavelength>"), "Reflection Back", SHIRLEY_CHIU, "{1}");
    let n = (1 << 17) / 6 - 2;
    let text = file("TensorTree3", &(0..n).map(band).collect::<String>());
    let (bsdf, repairs) = read(text.as_bytes(), Strictness::Strict).unwrap();
    assert_eq!((bsdf.bands.len(), repairs.len()), (n, 0));
}

#[test]
fn unknown_bases_are_refused() {
    let bases = "<ColumnAngleBasis>LBNL/Klems Full</ColumnAngleBasis><RowAngleBasis>Tregenza</RowAngleBasis>";
    let text = file("Columns", &block(VISIBLE, "Reflection Back", bases, "1"));
    refused_at(&text, "<RowAngleBasis>", &["`Tregenza`", "LBNL/Klems Full", "DataDefinition"]);
    let none = file("Columns", &block(VISIBLE, "Reflection Back", "", "1"));
    refused_at(&none, "<WavelengthDataBlock>", &["has no <ColumnAngleBasis>"]);
}

#[test]
fn errors_of_files_name_them() {
    let message = read_file("no/such/file.xml", Strictness::Strict).unwrap_err().to_string();
    assert!(message.starts_with("no/such/file.xml: cannot be read: "), "{message}");
    let path = std::env::temp_dir().join(format!("bsdftree-empty-{}.xml", std::process::id()));
    std::fs::write(&path, "").unwrap();
    let message = read_file(&path, Strictness::Strict).unwrap_err().to_string();
    std::fs::remove_file(&path).unwrap();
    assert!(
        message.starts_with(&format!("{}: line 1, byte 0: the file is empty", path.display())),
        "{message}"
    );
}
