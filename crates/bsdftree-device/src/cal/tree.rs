//! A parsed formula: nodes in one arena, names already linked to entries of the [`super::table::Table`].

use crate::error::Place;
use std::sync::Arc;

/// Index of a node in its [`Body`].
pub(super) type NodeId = u32;

/// One node and the line it stands in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    pub kind: Kind,
    pub line: u32,
}

/// What a node is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Number(f64),
    /// `$n`
    Channel(u32),
    /// `$n` beyond the channels that there are.
    NoChannel(u32),
    /// A parameter of the function whose body this is, counted from 0.
    Parameter(u16),
    /// A name, by its entry.
    Name(u32),
    Negate(NodeId),
    Binary(Operator, NodeId, NodeId),
    /// Arguments are `n` entries of [`Body::arguments`] from `first` on.
    Call {
        callee: Callee,
        first: u32,
        n: u16,
    },
}

/// What is called.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Callee {
    /// A name, by its entry.
    Name(u32),
    /// What was passed for a parameter.
    Parameter(u16),
}

/// A binary operator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

/// A formula.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Body {
    pub nodes: Vec<Node>,
    pub arguments: Vec<NodeId>,
    pub root: NodeId,
    /// The file whose lines the nodes have.
    pub file: Arc<str>,
}

impl Body {
    pub(super) fn kind(&self, id: NodeId) -> Kind {
        self.nodes[id as usize].kind
    }

    pub(super) fn place(&self, id: NodeId) -> Place {
        Place { file: self.file.clone(), line: self.nodes[id as usize].line }
    }
}

/// What a name stands for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Definition {
    /// `None` for a variable, the number of parameters for a function.
    pub n_parameters: Option<u16>,
    /// Defined with `:`, so that later uses take the value it has now.
    pub is_constant: bool,
    pub body: Arc<Body>,
    pub at: Place,
}
