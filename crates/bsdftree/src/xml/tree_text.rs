//! Trees from nested braces.
//!
//! `tree = '{' ( 2^rank trees | 2^(rank·k) numbers, k ≥ 0 ) '}'`. Branches count their children with dimension 0 as the least
//! significant bit; grids count their values with dimension 0 slowest: opposite orders, as Radiance has them. Nesting
//! is kept on a stack no deeper than a tree can be, so no text can exhaust the program's own.

use super::error::{Fault, XmlError};
use super::number::{Cursor, Negatives};
use crate::tree::{MAX_LOG2_RES, Rank, Slot, Tree, TreeBuilder, TreeError};

/// A branch whose children are being read.
struct Branch {
    children: [Slot; 16],
    n: usize,
    offset: usize,
}

/// The tree in a text that stands at `base` in the file.
pub(super) fn parse(
    text: &[u8],
    base: usize,
    rank: Rank,
    negatives: &mut Negatives,
) -> Result<Tree, XmlError> {
    let mut cursor = Cursor::new(text, base);
    let mut builder = TreeBuilder::with_capacity(rank, most_nodes(text, rank));
    let mut open: Vec<Branch> = Vec::new();
    let mut values = Vec::new();
    loop {
        let offset = open_brace(&mut cursor)?;
        if cursor.peek() == Some(b'{') {
            if open.len() as u32 == MAX_LOG2_RES {
                return Err(XmlError::new(offset, Fault::Tree(TreeError::TooDeep)));
            }
            open.push(Branch { children: [Slot::leaf(0.0); 16], n: 0, offset });
            continue;
        }
        let grid = grid(&mut cursor, &mut values, rank, &mut builder, negatives, offset)?;
        if let Some(root) = close(&mut cursor, &mut open, grid, rank, &mut builder)? {
            return match cursor.peek() {
                None => Ok(Tree::new(builder.finish(root))),
                Some(_) => Err(brace(&mut cursor, "nothing after the last brace")),
            };
        }
    }
}

/// How many nodes a text may have at most, unless it has grids of more than one node: there is a brace for each. Nor are there more
/// than its values, of two bytes at least, fill.
fn most_nodes(text: &[u8], rank: Rank) -> usize {
    let n_braces = memchr::memchr_iter(b'{', text).count();
    n_braces.min(text.len() / 2 / (rank.n_children() - 1) + 1)
}

/// Puts a finished subtree into its branch, and each branch that it completes into the next. Gives back the root when that
/// is complete.
fn close(
    cursor: &mut Cursor<'_>,
    open: &mut Vec<Branch>,
    mut slot: Slot,
    rank: Rank,
    builder: &mut TreeBuilder,
) -> Result<Option<Slot>, XmlError> {
    let n_children = rank.n_children();
    loop {
        cursor.separator();
        let Some(branch) = open.last_mut() else { return Ok(Some(slot)) };
        branch.children[branch.n] = slot;
        branch.n += 1;
        let complete = branch.n == n_children;
        match cursor.peek() {
            Some(b'}') if !complete => return Err(wrong_children(branch, rank)),
            Some(b'{') if complete => return Err(wrong_children(branch, rank)),
            Some(b'}') => {}
            _ if complete => return Err(brace(cursor, "`}`")),
            _ => return Ok(None),
        }
        slot = builder
            .node(&branch.children[..n_children])
            .map_err(|error| XmlError::new(branch.offset, Fault::Tree(error)))?;
        open.pop();
        cursor.skip();
    }
}

fn open_brace(cursor: &mut Cursor<'_>) -> Result<usize, XmlError> {
    match cursor.peek() {
        Some(b'{') => {
            let offset = cursor.offset();
            cursor.skip();
            Ok(offset)
        }
        _ => Err(brace(cursor, "`{`")),
    }
}

/// The numbers up to the closing brace, as a subtree.
fn grid(
    cursor: &mut Cursor<'_>,
    values: &mut Vec<f32>,
    rank: Rank,
    builder: &mut TreeBuilder,
    negatives: &mut Negatives,
    offset: usize,
) -> Result<Slot, XmlError> {
    values.clear();
    loop {
        cursor.plain_numbers(values);
        match cursor.peek() {
            Some(b'}') => break,
            Some(b'{') => return Err(brace(cursor, "a number or `}` in a node that began with numbers")),
            None => return Err(brace(cursor, "a number or `}`")),
            Some(_) => values.push(cursor.number(negatives)?),
        }
    }
    cursor.skip();
    if let &[value] = values.as_slice() {
        return Ok(Slot::leaf(value));
    }
    let (n, d) = (values.len(), rank.dimensions());
    if !n.is_power_of_two() || !(n.ilog2() as usize).is_multiple_of(d) {
        let [first, second, third] = [1, 2, 3].map(|k| 1usize << (d * k));
        let expected = format!("1, {first}, {second}, {third} … of them, as rank {d} has");
        return Err(XmlError::new(
            offset,
            Fault::WrongCount { found: format!("{n} values in a node"), expected },
        ));
    }
    builder.grid(values, n.ilog2() / d as u32).map_err(|error| XmlError::new(offset, Fault::Tree(error)))
}

fn brace(cursor: &mut Cursor<'_>, expected: &'static str) -> XmlError {
    let offset = cursor.offset();
    XmlError::new(offset, Fault::Brace { found: cursor.found(), expected })
}

fn wrong_children(branch: &Branch, rank: Rank) -> XmlError {
    let (n, d) = (rank.n_children(), rank.dimensions());
    let found = if branch.n < n {
        format!("{} children in a node", branch.n)
    } else {
        format!("more than {n} children in a node")
    };
    XmlError::new(branch.offset, Fault::WrongCount { found, expected: format!("{n}, as rank {d} has") })
}
