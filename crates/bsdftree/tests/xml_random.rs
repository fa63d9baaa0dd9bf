//! Random trees in random spelling, random bytes, and damaged real files.

mod xml_text;

use bsdftree::xml::{Strictness, parse_tree, read, write};
use bsdftree::{Bsdf, Component, Part, Rank, Scattering, Tree};
use bsdftree_testing::real_file;
use proptest::prelude::*;
use xml_text::{assert_same_bsdf, tree_file};

/// A tree as the test understands it.
#[derive(Clone, Debug)]
enum Plain {
    Leaf(f32),
    /// Values of 2^log2 cells per axis, dimension 0 slowest.
    Grid(u32, Vec<f32>),
    Branch(Vec<Plain>),
}

impl Plain {
    fn print(&self, separators: &mut impl Iterator<Item = &'static str>, text: &mut String) {
        text.push('{');
        match self {
            Plain::Leaf(value) => *text += &format!("{value}"),
            Plain::Grid(_, values) => {
                for value in values {
                    *text += &format!("{value:e}{}", separators.next().unwrap());
                }
            }
            Plain::Branch(children) => {
                for child in children {
                    child.print(separators, text);
                    *text += separators.next().unwrap();
                }
            }
        }
        text.push('}');
    }

    /// The value at a place of the unit cube.
    fn value(&self, place: &[f64]) -> f32 {
        match self {
            Plain::Leaf(value) => *value,
            Plain::Grid(log2, values) => {
                let n = (1usize << log2) as f64;
                values[place.iter().fold(0, |index, x| (index << log2) + (x * n) as usize)]
            }
            Plain::Branch(children) => {
                let child = place.iter().enumerate().map(|(i, &x)| usize::from(x >= 0.5) << i).sum::<usize>();
                let inside: Vec<f64> = place.iter().map(|x| (x * 2.0).fract()).collect();
                children[child].value(&inside)
            }
        }
    }
}

fn value() -> impl Strategy<Value = f32> {
    prop_oneof![
        Just(0.0f32),
        0.0f32..2.0,
        any::<f32>().prop_map(|v| if v.is_finite() { v.abs() } else { 1.0 })
    ]
}

fn plain(rank: Rank) -> impl Strategy<Value = Plain> {
    let d = rank.dimensions() as u32;
    let grid = move |log2: u32| {
        prop::collection::vec(value(), 1usize << (d * log2)).prop_map(move |values| Plain::Grid(log2, values))
    };
    let leaf = prop_oneof![4 => value().prop_map(Plain::Leaf), 2 => grid(1), 1 => grid(2)];
    leaf.prop_recursive(3, 200, 16, move |child| {
        prop::collection::vec(child, rank.n_children()).prop_map(Plain::Branch)
    })
}

fn same_values(plain: &Plain, rank: Rank, separators: &[&'static str]) -> Result<(), TestCaseError> {
    let mut text = String::new();
    plain.print(&mut separators.iter().copied().cycle(), &mut text);
    let tree = parse_tree(text.as_bytes(), rank).map_err(|error| TestCaseError::fail(error.to_string()))?;
    for leaf in tree.leaves() {
        let edge = 0.5f64.powi(leaf.level as i32);
        let centre: Vec<f64> =
            leaf.cell[..rank.dimensions()].iter().map(|&c| (f64::from(c) + 0.5) * edge).collect();
        prop_assert_eq!(leaf.value, plain.value(&centre));
    }
    let mut bsdf = Bsdf::default();
    bsdf.band_mut("Visible").insert(Part::TransmissionBack, Component::grey(Scattering::from(tree)));
    let mut file = Vec::new();
    write(&bsdf, &mut file).unwrap();
    assert_same_bsdf(&bsdf, &read(&file, Strictness::Strict).unwrap().0);
    Ok(())
}

fn separators() -> impl Strategy<Value = Vec<&'static str>> {
    prop::collection::vec(prop::sample::select(vec![" ", ",", "\n", ", ", "\r\n\t", " , "]), 1..8)
}

/// Never a panic, whatever is read; what is read can be written and read again.
fn assert_safe(bytes: &[u8]) {
    for strictness in [Strictness::Strict, Strictness::Repair] {
        if let Ok((bsdf, _)) = read(bytes, strictness) {
            let mut text = Vec::new();
            write(&bsdf, &mut text).unwrap_or_else(|error| panic!("{error}"));
            let (again, _) = read(&text, Strictness::Strict).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(bsdf.header, again.header);
        }
    }
    for rank in [Rank::Three, Rank::Four] {
        let _ = parse_tree(bytes, rank).map(|tree: Tree| tree.minimum());
    }
}

/// Pieces of which files and their breakages are made.
const PIECES: &[&str] = &[
    "<",
    ">",
    "</",
    "/>",
    "<!--",
    "-->",
    "<![CDATA[",
    "]]>",
    "<!DOCTYPE x>",
    "<?",
    "?>",
    "&amp;",
    "&",
    "{",
    "}",
    "{ 1 }",
    "1e999",
    "nan",
    "-1",
    ",",
    " ",
    "\0",
    "\u{FEFF}",
    "é",
    "<Layer>",
    "</Layer>",
    "</ScatteringData>",
    "unit=\"\"",
    "\"",
];

fn damaged(text: &[u8], edits: &[(prop::sample::Index, usize, usize)]) -> Vec<u8> {
    let mut text = text.to_vec();
    for &(at, remove, piece) in edits {
        let at = at.index(text.len() + 1);
        let end = (at + remove).min(text.len());
        text.splice(at..end, PIECES[piece].bytes());
    }
    text
}

fn edits() -> impl Strategy<Value = Vec<(prop::sample::Index, usize, usize)>> {
    prop::collection::vec((any::<prop::sample::Index>(), 0usize..30, 0..PIECES.len()), 1..4)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn rank_3_trees_read_to_their_values(tree in plain(Rank::Three), separators in separators()) {
        same_values(&tree, Rank::Three, &separators)?;
    }

    #[test]
    fn rank_4_trees_read_to_their_values(tree in plain(Rank::Four), separators in separators()) {
        same_values(&tree, Rank::Four, &separators)?;
    }

    #[test]
    fn arbitrary_bytes_are_safe(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        assert_safe(&bytes);
    }

    #[test]
    fn arbitrary_pieces_are_safe(pieces in prop::collection::vec(0..PIECES.len(), 0..60)) {
        let text: String = pieces.iter().map(|&k| PIECES[k]).collect();
        assert_safe(text.as_bytes());
        assert_safe(tree_file("TensorTree3", &text).as_bytes());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn damaged_real_files_are_safe(edits in edits()) {
        for path in ["radiance/testBSDF.xml", "ignis/simple_tensor_d2_refl.xml", "bsdfxmlparser/2011-SA1-Small-TabSeparated.XML"] {
            let Some(path) = real_file(path) else { return Ok(()) };
            assert_safe(&damaged(&std::fs::read(path).unwrap(), &edits));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn damaged_large_files_are_safe(edits in edits()) {
        for path in ["radiance/sawtooth.xml", "pyradiance/blindsT3.xml", "frads/ec60.xml"] {
            let Some(path) = real_file(path) else { return Ok(()) };
            assert_safe(&damaged(&std::fs::read(path).unwrap(), &edits));
        }
    }
}
