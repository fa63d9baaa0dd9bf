//! Values as text: the shortest digits that read back as the same `f32`.

use std::io::{self, Write};

use super::matrix_text::transposed;
use crate::klems::Matrix;
use crate::tree::{Arena, Content, Slot, Tree};

/// Text that is collected and written in large pieces.
struct Text<'a, W> {
    collected: Vec<u8>,
    out: &'a mut W,
}

impl<'a, W: Write> Text<'a, W> {
    /// Written when this long \[byte\].
    const PIECE: usize = 1 << 16;

    fn new(out: &'a mut W) -> Text<'a, W> {
        Text { collected: Vec::with_capacity(2 * Self::PIECE), out }
    }

    fn line(&mut self, indent: usize, text: &[u8]) {
        self.indent(indent);
        self.collected.extend_from_slice(text);
        self.collected.push(b'\n');
    }

    fn indent(&mut self, spaces: usize) {
        const SPACES: [u8; 16] = [b' '; 16];
        self.collected.extend_from_slice(&SPACES[..spaces.min(SPACES.len())]);
    }

    #[inline]
    fn number(&mut self, value: f32) {
        let mut buffer = zmij::Buffer::new();
        let digits = buffer.format_finite(value).as_bytes();
        let digits = digits.strip_suffix(b".0").unwrap_or(digits);
        // A copy of fixed length, of which what is too much is written over: the shortest digits are never longer.
        let mut text = [b' '; 17];
        match digits.len() {
            n @ 8..=16 => {
                text[n - 7..n + 1].copy_from_slice(&digits[n - 8..]);
                text[1..9].copy_from_slice(&digits[..8]);
            }
            n => text[1..n + 1].copy_from_slice(digits),
        }
        self.collected.extend_from_slice(&text);
        self.collected.truncate(self.collected.len() - 16 + digits.len());
    }

    /// Writes what was collected, if that is much.
    fn pass_on(&mut self) -> io::Result<()> {
        match self.collected.len() < Self::PIECE {
            true => Ok(()),
            false => self.finish(),
        }
    }

    fn finish(&mut self) -> io::Result<()> {
        self.out.write_all(&self.collected)?;
        self.collected.clear();
        Ok(())
    }
}

/// A tree: a node whose children are all leaves as a grid on one line, others as indented branches.
pub(super) fn write_tree(tree: &Tree, out: &mut impl Write) -> io::Result<()> {
    let mut text = Text::new(out);
    write_slot(tree.arena(), tree.arena().root(), 0, &mut text)?;
    text.finish()
}

/// No deeper than a tree is: 15.
fn write_slot(arena: &Arena, slot: Slot, depth: usize, text: &mut Text<'_, impl Write>) -> io::Result<()> {
    let mut grid = [0.0; 16];
    match slot.content() {
        Content::Leaf(value) => write_grid(&[value], depth, text),
        Content::Node(node) => match as_grid(arena.children(node), &mut grid) {
            Some(grid) => write_grid(grid, depth, text),
            None => {
                text.line(depth, b"{");
                for &child in arena.children(node) {
                    write_slot(arena, child, depth + 1, text)?;
                }
                text.line(depth, b"}");
                Ok(())
            }
        },
    }
}

fn write_grid(grid: &[f32], depth: usize, text: &mut Text<'_, impl Write>) -> io::Result<()> {
    text.indent(depth);
    text.collected.push(b'{');
    grid.iter().for_each(|&value| text.number(value));
    text.collected.extend_from_slice(b" }\n");
    text.pass_on()
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
    let mut text = Text::new(out);
    for line in transposed(matrix.values(), matrix.exitant().n_patches()).chunks_exact(n_incident) {
        line.iter().for_each(|&value| text.number(value));
        text.collected.push(b'\n');
        text.pass_on()?;
    }
    text.finish()
}
