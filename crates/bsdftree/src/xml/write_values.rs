//! Values as text: the shortest digits that read back as the same `f32`.

use std::io::{self, Write};

use super::matrix_text::transposed;
use crate::klems::Matrix;
use crate::tree::{Arena, Content, Slot, Tree};

/// A tree: a node whose children are all leaves as a grid on one line, others as indented branches.
pub(super) fn write_tree(tree: &Tree, out: &mut impl Write) -> io::Result<()> {
    write_slot(tree.arena(), tree.arena().root(), 0, out)
}

/// No deeper than a tree is: 15.
fn write_slot(arena: &Arena, slot: Slot, depth: usize, out: &mut impl Write) -> io::Result<()> {
    write!(out, "{:depth$}{{", "")?;
    match slot.content() {
        Content::Leaf(value) => write_number(value, out)?,
        Content::Node(node) => {
            let mut grid = [0.0; 16];
            if let Some(grid) = as_grid(arena.children(node), &mut grid) {
                for &value in grid {
                    write_number(value, out)?;
                }
            } else {
                writeln!(out)?;
                for &child in arena.children(node) {
                    write_slot(arena, child, depth + 1, out)?;
                }
                return writeln!(out, "{:depth$}}}", "");
            }
        }
    }
    writeln!(out, " }}")
}

/// Leaves in grid order, dimension 0 slowest: the child's number with its bits reversed.
fn as_grid<'a>(children: &[Slot], grid: &'a mut [f32; 16]) -> Option<&'a [f32]> {
    let bits = children.len().ilog2();
    for (k, child) in children.iter().enumerate() {
        let Content::Leaf(value) = child.content() else { return None };
        grid[(k.reverse_bits() >> (usize::BITS - bits)) & 15] = value;
    }
    Some(&grid[..children.len()])
}

/// A matrix: a line for each exitant patch, as `Columns` has it.
pub(super) fn write_matrix(matrix: &Matrix, out: &mut impl Write) -> io::Result<()> {
    let n_incident = matrix.incident().n_patches();
    for line in transposed(matrix.values(), matrix.exitant().n_patches()).chunks_exact(n_incident) {
        for &value in line {
            write_number(value, out)?;
        }
        writeln!(out)?;
    }
    Ok(())
}

fn write_number(value: f32, out: &mut impl Write) -> io::Result<()> {
    let mut buffer = zmij::Buffer::new();
    let digits = buffer.format_finite(value);
    out.write_all(b" ")?;
    out.write_all(digits.strip_suffix(".0").unwrap_or(digits).as_bytes())
}
