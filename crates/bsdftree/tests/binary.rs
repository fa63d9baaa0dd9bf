//! Files in binary: real ones and random trees come back to the last bit; damaged and forged ones are refused or answer, without harm.

mod common;
mod xml_text;

use std::path::Path;
use std::sync::Arc;

use bsdftree::binary::{Packing, is_binary, open, read, write, write_file};
use bsdftree::check::{Tolerance, check};
use bsdftree::file;
use bsdftree::xml::{self, Strictness};
use bsdftree::{Band, Basis, Bsdf, Component, Geometry, Lobes, Matrix, Part, Rank, Scattering, Tree};
use bsdftree_testing::{READABLE, real_file};
use common::{Random, random_tree};
use xml_text::assert_same_bsdf;

const PACKINGS: [Packing; 3] = [Packing::Raw, Packing::Packed(1), Packing::Packed(22)];

fn bytes(bsdf: &Bsdf, packing: Packing) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(bsdf, packing, &mut bytes).unwrap();
    bytes
}

fn as_xml(bsdf: &Bsdf) -> Vec<u8> {
    let mut text = Vec::new();
    xml::write(bsdf, &mut text).unwrap();
    text
}

/// All that a BSDF can have: both ranks, matrices over two bases, colour, bands, a whole header.
fn everything() -> Bsdf {
    let mut random = Random(7);
    let mut bsdf = Bsdf::default();
    let header = &mut bsdf.header;
    (header.name, header.manufacturer) = ("Blende & <Söhne>".into(), "µ\n".into());
    (header.thickness, header.width) = (Some(0.1 + 0.2), Some(f64::MIN_POSITIVE));
    header.unit = bsdftree::LengthUnit::Inch;
    header.properties = vec![("ThermalConductivity".into(), "0.9".into()), ("x-1.y_2".into(), String::new())];
    header.provenance = vec!["made".into(), String::new(), "-- twice --".into()];
    header.geometry = Some(Geometry { mgf: "m steel =\n".repeat(50), unit: bsdftree::LengthUnit::Foot });
    let mut tree = |rank| Scattering::from(random_tree(rank, 3, &mut random));
    let grey = |function| Component { luminance: function, chroma: None };
    let visible = bsdf.band_mut("Visible");
    let colored =
        Component { luminance: tree(Rank::Four), chroma: Some([tree(Rank::Four), tree(Rank::Four)]) };
    visible.insert(Part::TransmissionFront, colored);
    visible.insert(Part::ReflectionBack, grey(tree(Rank::Three)));
    visible.insert(Part::ReflectionFront, grey(Tree::uniform(Rank::Three, 0.1).into()));
    let (full, quarter) = (Arc::new(Basis::quarter()), Arc::new(Basis::quarter().subdivided(2).unwrap()));
    let values = (0..full.n_patches() * quarter.n_patches()).map(|k| (k % 91) as f32 * 1e-3).collect();
    let matrix = Matrix::new(full, quarter, values).unwrap();
    bsdf.band_mut("NIR").insert(Part::TransmissionBack, grey(matrix.into()));
    bsdf.bands.push(Band::new("450"));
    bsdf
}

/// Asks everything that can be asked.
fn ask(bsdf: &Bsdf) {
    let mut random = Random(3);
    let n = 70;
    let directions: Vec<_> = (0..2 * n)
        .map(|k| random.direction().map(|c| if k % 3 == 0 { -c } else { c }))
        .chain([[0.0, 0.0, 1.0], [f64::NAN; 3]])
        .collect();
    let (incident, exitant) = directions.split_at(n);
    let (incident, exitant) = (incident, &exitant[..n]);
    let u: Vec<f64> = (0..n).map(|_| random.unit()).collect();
    for band in &bsdf.bands {
        let mut values = vec![0.0; n];
        band.eval_many(incident, exitant, &mut values);
        for k in 0..n {
            let single = band.eval(incident[k], exitant[k]);
            assert_eq!(single.to_bits(), values[k].to_bits());
            band.eval_xyz(incident[k], exitant[k]);
            band.projected_solid_angle(incident[k], exitant[k]);
            band.projected_solid_angle_range(incident[k], Lobes::All);
            band.pdf(incident[k], exitant[k], Lobes::All);
            band.sample(incident[k], u[k], Some(u[n - 1 - k]), Lobes::Transmission);
        }
        let mut samples = vec![band.sample(incident[0], 0.5, None, Lobes::All); n];
        band.sample_many(incident, &u, None, Lobes::All, &mut samples);
        band.components().flat_map(|(_, component)| component.functions()).for_each(|function| {
            function.lambertian();
            if let Scattering::Tree(tree) = function {
                assert!(tree.leaves().count() <= tree.arena().n_leaves());
                tree.to_grid(2);
                tree.merged();
            }
        });
    }
    check(bsdf, Tolerance::default());
    let (verified, written) = (bsdf.verify(), write(bsdf, Packing::Raw, &mut Vec::new()));
    assert_eq!(verified.is_ok(), written.is_ok());
}

/// Opened from a file, if it is one.
fn opened(folder: &Path, bytes: &[u8]) -> Result<Bsdf, String> {
    let path = folder.join("a.bsdft");
    // A new file, so that no map of the old one is touched.
    let _ = std::fs::remove_file(&path);
    std::fs::write(&path, bytes).unwrap();
    open(&path).map_err(|error| error.to_string())
}

#[test]
fn all_of_a_bsdf_comes_back_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let all = everything();
    for packing in PACKINGS {
        let bytes = bytes(&all, packing);
        assert!(is_binary(&bytes));
        assert_same_bsdf(&all, &read(&bytes).unwrap());
        let mapped = opened(folder.path(), &bytes).unwrap();
        mapped.verify().unwrap();
        assert_same_bsdf(&all, &mapped);
        assert_eq!(self::bytes(&mapped, packing), bytes, "written again, it is the same file");
    }
    assert_same_bsdf(&Bsdf::default(), &read(&bytes(&Bsdf::default(), Packing::Raw)).unwrap());
}

#[test]
fn real_files_come_back_to_the_last_bit_and_are_smaller() {
    let folder = tempfile::tempdir().unwrap();
    for path in READABLE.iter().filter_map(|path| real_file(path)) {
        let (bsdf, _) = xml::read_file(&path, Strictness::Strict).unwrap();
        let text = as_xml(&bsdf);
        let mut sizes = Vec::new();
        for packing in [Packing::Raw, Packing::Packed(3), Packing::SMALL] {
            let twin = folder.path().join("twin.BSDFT");
            file::write(&bsdf, &twin, packing).unwrap();
            let (again, repairs) = file::read(&twin, Strictness::Strict).unwrap();
            assert!(repairs.is_empty());
            again.verify().unwrap();
            assert_same_bsdf(&bsdf, &again);
            assert!(as_xml(&again) == text, "{}", path.display());
            sizes.push(std::fs::metadata(&twin).unwrap().len());
        }
        assert!(sizes[2] <= sizes[1] && sizes[1] <= sizes[0], "{}: {sizes:?}", path.display());
    }
}

#[test]
fn mapped_files_answer_as_those_in_memory_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let all = everything();
    let mapped = opened(folder.path(), &bytes(&all, Packing::Raw)).unwrap();
    let mut random = Random(11);
    for (a, b) in all.bands.iter().zip(&mapped.bands) {
        for _ in 0..2000 {
            let [i, o] = [random.direction(), random.direction()];
            let (i, u) = (if random.unit() < 0.5 { i } else { i.map(|c| -c) }, random.unit());
            assert_eq!(a.eval(i, o), b.eval(i, o));
            assert_eq!(a.sample(i, u, None, Lobes::All), b.sample(i, u, None, Lobes::All));
            assert_eq!(a.hemispherical(i, Lobes::All), b.hemispherical(i, Lobes::All));
        }
    }
    ask(&mapped);
}

#[test]
fn a_mapped_tree_outlives_its_bsdf_and_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let all = everything();
    let mapped = opened(folder.path(), &bytes(&all, Packing::Raw)).unwrap();
    let component = mapped.bands[0].component(Part::ReflectionBack).unwrap().luminance.clone();
    drop(mapped);
    folder.close().unwrap();
    xml_text::assert_same_scattering(
        &component,
        &all.bands[0].component(Part::ReflectionBack).unwrap().luminance,
    );
}

#[test]
fn truncated_files_are_refused_wherever_they_end() {
    let folder = tempfile::tempdir().unwrap();
    for packing in [Packing::Raw, Packing::Packed(3)] {
        let whole = bytes(&everything(), packing);
        for end in (0..whole.len()).step_by(7).chain([whole.len() - 1]) {
            let message = read(&whole[..end]).unwrap_err().to_string();
            assert!(message.contains("expected"), "{message}");
            if end % 49 == 0 {
                let message = opened(folder.path(), &whole[..end]).unwrap_err();
                assert!(end == 0 || message.contains("expected"), "{message}");
            }
        }
        let longer = [&whole[..], &[0; 64]].concat();
        assert!(read(&longer).unwrap_err().to_string().contains("expected"));
    }
}

/// A small file: a tree, a matrix, text.
fn small() -> Bsdf {
    let mut bsdf = Bsdf::default();
    bsdf.header.name = "small".into();
    let values: Vec<f32> = (0..64).map(|k| k as f32 * 0.01).collect();
    let visible = bsdf.band_mut("Visible");
    visible
        .insert(Part::ReflectionBack, Component::grey(Tree::from_grid(Rank::Three, &values).unwrap().into()));
    let rings = [(0.0, 40.0, 1), (40.0, 90.0, 3)]
        .map(|(lower, upper, n_phi)| bsdftree::klems::Ring { bounds_deg: [lower, upper], n_phi });
    let basis = Arc::new(Basis::new("two rings", rings.to_vec()).unwrap());
    let matrix = Matrix::new(Arc::clone(&basis), basis, (0..16).map(|k| k as f32 * 0.02).collect()).unwrap();
    visible.insert(Part::TransmissionFront, Component::grey(matrix.into()));
    bsdf
}

/// The checksums of preamble and head made right again, as an attacker would.
fn forged(mut bytes: Vec<u8>) -> Vec<u8> {
    let number = |bytes: &[u8], at: usize| u64::from_le_bytes(*bytes[at..].first_chunk().unwrap());
    let length = number(&bytes, 16) as usize;
    if let Some(head) = bytes.get(64..64usize.saturating_add(length)) {
        let crc = crc32fast::hash(head).to_le_bytes();
        bytes[40..44].copy_from_slice(&crc);
    }
    let crc = crc32fast::hash(&bytes[..44]).to_le_bytes();
    bytes[44..48].copy_from_slice(&crc);
    bytes
}

#[test]
fn no_flipped_byte_is_read_as_another_bsdf() {
    for packing in [Packing::Raw, Packing::Packed(3)] {
        let good = small();
        let whole = bytes(&good, packing);
        for k in 0..whole.len() {
            for flip in [0x01, 0x80, 0xFF] {
                let mut bytes = whole.clone();
                bytes[k] ^= flip;
                if let Ok(bsdf) = read(&bytes) {
                    // Bytes that only fill up.
                    assert_same_bsdf(&good, &bsdf);
                    assert_eq!(whole[k], 0, "byte {k}");
                }
            }
        }
    }
}

/// A reflection of noise that is the same for light that goes back, and the same noise without that.
fn reciprocal_and_not() -> [Bsdf; 2] {
    let mut random = Random(17);
    let n = 8usize;
    let noise: Vec<f32> = (0..n.pow(4)).map(|_| 0.1 + random.unit() as f32).collect();
    // i·n² + o, either of which is a pair of coordinates; back it is 1 − o, 1 − i.
    let back = |k: usize| (n * n - 1 - k % (n * n)) * n * n + (n * n - 1 - k / (n * n));
    let mean: Vec<f32> = (0..noise.len()).map(|k| 0.5 * (noise[k] + noise[back(k)])).collect();
    [mean, noise].map(|values| {
        let mut bsdf = Bsdf::default();
        let tree = Tree::from_grid(Rank::Four, &values).unwrap();
        bsdf.band_mut("Visible").insert(Part::ReflectionBack, Component::grey(tree.into()));
        bsdf
    })
}

#[test]
fn what_is_reciprocal_takes_half_the_room() {
    let [mean, noise] = reciprocal_and_not().map(|bsdf| {
        let bytes = bytes(&bsdf, Packing::SMALL);
        assert_same_bsdf(&bsdf, &read(&bytes).unwrap());
        bytes
    });
    assert_eq!(mean[8], 2, "the version that has predicted values");
    assert!(10 * mean.len() < 6 * noise.len(), "{} of {}", mean.len(), noise.len());
}

#[test]
fn forged_predictions_are_refused_or_answer() {
    let [bsdf, _] = reciprocal_and_not();
    let whole = bytes(&bsdf, Packing::Packed(3));
    for k in (0..whole.len()).step_by(13) {
        let mut bytes = whole.clone();
        bytes[k] ^= 0x55;
        assert!(read(&bytes).is_err() || whole[k] == 0);
        let _ = read(&forged(bytes));
    }
    // All forms of its values, in bytes that are raw: before their length, their checksum and two parts that are none.
    let head = u64::from_le_bytes(*whole[24..].first_chunk().unwrap()) as usize;
    let raw = bytes(&bsdf, Packing::Raw);
    for form in 0..=255 {
        let mut bytes = raw.clone();
        bytes[64 + head - 15] = form;
        assert_eq!(read(&forged(bytes)).is_ok(), form == 0, "form {form}");
    }
}

#[test]
fn forged_files_are_refused_or_answer() {
    let folder = tempfile::tempdir().unwrap();
    let whole = bytes(&small(), Packing::Raw);
    let mut n_answered = 0;
    for k in 0..whole.len() {
        for flip in [0x01, 0x10, 0x80, 0xFF] {
            let mut bytes = whole.clone();
            bytes[k] ^= flip;
            let bytes = forged(bytes);
            let _ = read(&bytes);
            if let Ok(bsdf) = opened(folder.path(), &bytes) {
                ask(&bsdf);
                n_answered += 1;
            }
        }
    }
    assert!(n_answered > 1000, "{n_answered}");
}

#[test]
fn links_that_lead_anywhere_do_no_harm_and_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(5);
    let tree = random_tree(Rank::Four, 4, &mut random);
    let n_slots = tree.arena().n_nodes() * 16;
    let mut bsdf = Bsdf::default();
    bsdf.band_mut("Visible").insert(Part::ReflectionBack, Component::grey(tree.into()));
    let whole = bytes(&bsdf, Packing::Raw);
    let first = whole.len() - 4 * n_slots;
    for round in 0..200 {
        let mut bytes = whole.clone();
        for _ in 0..=round % 20 {
            let slot = (random.unit() * n_slots as f64) as usize;
            let link = match round % 3 {
                // Round and round, within, and far outside.
                0 => 0,
                1 => (random.unit() * n_slots as f64 / 16.0) as u32,
                _ => random.bits() as u32 >> 1,
            };
            bytes[first + 4 * slot..][..4].copy_from_slice(&(link | 1 << 31).to_le_bytes());
        }
        let mapped = opened(folder.path(), &bytes).unwrap();
        let damage = mapped.verify().unwrap_err();
        assert!(damage.offset >= first as u64 && damage.to_string().contains("Reflection Back"), "{damage}");
        ask(&mapped);
        assert!(check(&mapped, Tolerance::default()).bands[0].findings[0].message.contains("damaged"));
        let message = read(&bytes).unwrap_err().to_string();
        assert!(message.contains("checksum"), "{message}");
    }
}

#[test]
fn values_that_no_bsdf_has_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let whole = bytes(&small(), Packing::Raw);
    for wrong in [f32::NAN, f32::INFINITY, -1.0] {
        let mut bytes = whole.clone();
        // The last value of the matrix, which is the last section: 16 values fill a line.
        let end = bytes.len();
        bytes[end - 4..].copy_from_slice(&wrong.to_le_bytes());
        let mapped = opened(folder.path(), &bytes).unwrap();
        let damage = mapped.verify().unwrap_err();
        assert_eq!(damage.offset, end as u64 - 4);
        assert!(damage.found.contains("not a finite number"), "{damage}");
        ask(&mapped);
        assert!(write_file(&mapped, Packing::Raw, folder.path().join("b.bsdft")).is_err());
        assert!(!folder.path().join("b.bsdft").exists());
        assert!(xml::write(&mapped, &mut Vec::new()).unwrap_err().to_string().contains("damaged"));
    }
}

#[test]
fn what_grows_out_of_proportion_is_refused_and_never_written() {
    // A grid of zeros that nobody merged.
    let depth = 7;
    let mut builder = bsdftree::tree::TreeBuilder::new(Rank::Four);
    let zeros = vec![0.0; 1 << 24];
    let inside = builder.grid(&zeros, 6).unwrap();
    let mut children = [bsdftree::tree::Slot::leaf(1.0); 16];
    children[3] = inside;
    let root = builder.node(&children).unwrap();
    let tree = Tree::new(builder.finish(root));
    assert_eq!(tree.arena().log2_res(), depth);
    let mut bsdf = Bsdf::default();
    for (k, part) in Part::ALL.into_iter().enumerate() {
        // Four of 70 MB, beyond what a reader grants a small file.
        bsdf.band_mut(&format!("{}", 400 + k)).insert(part, Component::grey(tree.clone().into()));
    }
    let packed = bytes(&bsdf, Packing::Packed(3));
    assert!(packed.len() > 64 << 20, "one is written raw: {}", packed.len());
    assert_same_bsdf(&bsdf, &read(&packed).unwrap());
}

#[test]
fn other_files_and_versions_are_refused_with_what_to_do() {
    let message = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
    assert!(message(b"").contains("empty"));
    assert!(message(b"<?xml version=\"1.0\"?>").contains("check that this is a .bsdft file"));
    let mut newer = bytes(&small(), Packing::Raw);
    newer[8] = 3;
    assert!(message(&newer).contains("found version 3; expected version 1 or 2"), "{}", message(&newer));
    let text: Vec<u8> = bytes(&small(), Packing::Raw).into_iter().filter(|&b| b != b'\r').collect();
    assert!(message(&text).contains("transferred as text"));
    let error = file::read("/nonexistent/a.bsdft", Strictness::Strict).unwrap_err();
    assert!(error.to_string().contains("/nonexistent/a.bsdft"), "{error}");
    assert!(error.io().is_some());
}
