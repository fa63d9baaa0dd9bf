//! Surfaces from entities.
//!
//! In: `f`, `fh`, `sph`, `cyl`, `cone`, `ring`, `torus`, `prism` and the vertices that have names. Out: [`Piece`]s, or what is wrong with
//! the arguments: what mgf2rad refuses is refused.

use glam::DVec3;

use super::context::Contexts;
use super::entity::Entity;
use super::piece::{self, Piece, Vertex};
use crate::error::DeviceError;
use crate::rad::quoted;

/// The surfaces of an entity, and what stands for their kind in names.
pub(super) fn pieces(
    entity: &Entity<'_>,
    named: &Contexts<Vertex>,
) -> Result<(&'static str, Vec<Piece>), DeviceError> {
    let vertex = |k: usize| named.get(entity.arguments[k], &entity.at).copied();
    let all = |words: &[&str]| -> Result<Vec<Vertex>, DeviceError> {
        words.iter().map(|name| named.get(name, &entity.at).copied()).collect()
    };
    Ok(match entity.keyword {
        "sph" => {
            entity.count(2..=2, "a vertex and a radius")?;
            let piece = Piece::Sphere { center: vertex(0)?.point, radius: entity.number(1, "a radius")? };
            ("s", vec![piece])
        }
        "cyl" => {
            entity.count(3..=3, "a vertex, a radius and a vertex")?;
            let (ends, radius) = ([vertex(0)?.point, vertex(2)?.point], entity.number(1, "a radius")?);
            ("cy", vec![Piece::Cone { ends, radii: [radius; 2] }])
        }
        "cone" => {
            entity.count(4..=4, "a vertex and a radius for each end")?;
            let ends = [vertex(0)?.point, vertex(2)?.point];
            let radii = [entity.number(1, "a radius")?, entity.number(3, "a radius")?];
            if radii[0] * radii[1] < 0.0 || radii == [0.0; 2] {
                return Err(bad_radii(entity, "two radii of the same sign, not both 0", radii));
            }
            ("c", vec![Piece::Cone { ends, radii }])
        }
        "ring" | "torus" => {
            entity.count(3..=3, "a vertex with a normal and two radii")?;
            let Vertex { point: center, normal } = vertex(0)?;
            if normal == DVec3::ZERO {
                let found = format!("no normal at vertex {}", quoted(entity.arguments[0]));
                return Err(entity.unexpected("a vertex with a normal", found, "add 'n' to the vertex"));
            }
            let radii = [entity.number(1, "a radius")?, entity.number(2, "a radius")?];
            match entity.keyword {
                "ring" if radii[0] >= 0.0 && radii[1] > radii[0] => {
                    ("r", vec![Piece::Ring { center, normal, radii }])
                }
                "ring" => return Err(bad_radii(entity, "0 ≤ inner radius < outer radius", radii)),
                _ => {
                    let pieces = piece::torus(center, normal, radii);
                    let expected = "an outer radius farther from 0 than the inner, on the same side";
                    ("torus", pieces.ok_or_else(|| bad_radii(entity, expected, radii))?)
                }
            }
        }
        "prism" => {
            entity.count(4.., "at least three vertices and a length")?;
            let (last, names) = (entity.arguments.len() - 1, entity.arguments);
            let length = entity.number(last, "a length")?;
            if length == 0.0 {
                return Err(entity.unexpected("a length other than 0", quoted(names[last]), ""));
            }
            let pieces = piece::prism(&all(&names[..last])?, length);
            let found = || "vertices on one line".to_owned();
            ("f", pieces.ok_or_else(|| entity.unexpected("a base with an area", found(), ""))?)
        }
        "fh" => ("f", face_with_holes(entity, named)?),
        _ => {
            entity.count(3.., "at least three vertices")?;
            ("f", vec![piece::face(&all(entity.arguments)?)])
        }
    })
}

fn face_with_holes(entity: &Entity<'_>, named: &Contexts<Vertex>) -> Result<Vec<Piece>, DeviceError> {
    let mut loops: Vec<Vec<Vertex>> = vec![Vec::new()];
    for (k, &word) in entity.arguments.iter().enumerate() {
        match loops.last_mut() {
            Some(vertices) if !word.starts_with('-') => {
                vertices.push(*named.get(word, &entity.at)?);
            }
            // A last '-' is the end only.
            _ if k + 1 == entity.arguments.len() => {}
            _ => loops.push(Vec::new()),
        }
    }
    if let Some(short) = loops.iter().find(|vertices| vertices.len() < 3) {
        let found = short.len().to_string();
        return Err(entity.unexpected("at least three vertices in the face and in each hole", found, ""));
    }
    let holes: Vec<&[Vertex]> = loops[1..].iter().map(Vec::as_slice).collect();
    if holes.is_empty() {
        Ok(vec![piece::face(&loops[0])])
    } else {
        Ok(piece::face_with_holes(&loops[0], &holes))
    }
}

fn bad_radii(entity: &Entity<'_>, expected: &str, [a, b]: [f64; 2]) -> DeviceError {
    entity.unexpected(expected, format!("{a} and {b}"), "")
}
