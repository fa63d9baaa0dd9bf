//! Values of constants where a formula is read.
//!
//! A name defined by `:` whose value needs no ray, and a call of a library function or of one defined by `:` with
//! constant arguments, become numbers at once, so that a later definition does not change them. Deviation: where
//! Radiance would take the value of the first ray, or stop because something is not defined yet, nothing is folded and
//! the value is computed when it is needed.

use super::compile::Compiler;
use super::machine;
use super::scratch::Scratch;
use super::table::Table;
use super::tree::{Body, Callee, Kind, Node, NodeId};
use std::sync::Arc;

/// How much work one text may cause by being read, in operations.
pub(super) struct Budget(usize);

impl Default for Budget {
    fn default() -> Self {
        Budget(10_000_000)
    }
}

/// Largest cost of one constant, in operations.
const MAX_COST: usize = 100_000;

/// The value of a name or call, if it is a constant.
pub(super) fn constant(
    table: &Table,
    nodes: &[Node],
    arguments: &[NodeId],
    kind: Kind,
    budget: &mut Budget,
) -> Option<f64> {
    match kind {
        Kind::Name(id) => {
            let definition = table.entry(id).definition.as_deref()?;
            if !definition.is_constant || definition.n_parameters.is_some() {
                return None;
            }
            match definition.body.kind(definition.body.root) {
                Kind::Number(value) => Some(value),
                _ => evaluated(table, definition.body.clone(), budget),
            }
        }
        Kind::Call { callee: Callee::Name(id), first, n } => {
            let list = &arguments[first as usize..][..usize::from(n)];
            let list: Vec<Node> = list.iter().map(|&at| nodes[at as usize]).collect();
            let is_constant = |node: &Node| match node.kind {
                Kind::Number(_) => true,
                Kind::Name(id) => is_constant_function(table, id),
                _ => false,
            };
            (is_constant_function(table, id) && list.iter().all(is_constant))
                .then(|| evaluated(table, Arc::new(call_of(id, list)), budget))?
        }
        _ => None,
    }
}

fn is_constant_function(table: &Table, id: u32) -> bool {
    let entry = table.entry(id);
    match &entry.definition {
        Some(definition) => definition.n_parameters.is_some() && definition.is_constant,
        None => entry.builtin.is_some(),
    }
}

/// The formula that calls `function` with these arguments.
fn call_of(function: u32, mut nodes: Vec<Node>) -> Body {
    let n = nodes.len() as u16;
    let root = NodeId::from(n);
    nodes.push(Node { kind: Kind::Call { callee: Callee::Name(function), first: 0, n }, line: 0 });
    Body { nodes, arguments: (0..root).collect(), root, file: "".into() }
}

/// The value, if it needs nothing from outside, is no fault and comes within reason.
fn evaluated(table: &Table, body: Arc<Body>, budget: &mut Budget) -> Option<f64> {
    let max_ops = budget.0.min(MAX_COST);
    if max_ops == 0 {
        return None;
    }
    let program = Compiler::new(table, max_ops).link(&[body]);
    budget.0 = budget.0.saturating_sub(program.code.len());
    let entry = &program.entries[0];
    if program.is_cut || !entry.uses.is_empty() {
        return None;
    }
    let mut scratch = Scratch::with_max_steps(max_ops);
    scratch.begin(&program);
    let value = machine::run(&program, entry.pc, &(), &mut scratch);
    budget.0 = budget.0.saturating_sub(scratch.steps());
    value.ok().filter(|value| value.is_finite() && scratch.faults() == 0)
}
