//! From text to definitions and formulas.
//!
//! Grammar, as in Radiance's calculator library: a file is `name = e;`, `name : e;`, `name(p, …) = e;` or
//! `name(p, …) : e;`, any number of them; the last `;` may be missing. In an expression `+ -` bind weakest, then `* /`,
//! then `^` (to the right), then one sign, so that `-2^2` is 4. Uses of a `:` definition whose arguments are constants
//! take the value it has where they stand; so do library functions of constants. Nesting and size are bounded.

use super::builtin;
use super::error::{CalError, CalProblem};
use super::fold;
use super::scan::Scanner;
use super::table::Table;
use super::tree::{Body, Callee, Definition, Kind, Node, NodeId, Operator};
use crate::error::Place;
use std::sync::Arc;

/// How deep parentheses, calls and powers may nest: an unoptimised build needs less than 1 MiB of stack for that.
const MAX_NESTING: usize = 200;
/// Largest text.
const MAX_BYTES: usize = 64 << 20;
/// Most parameters of a function, and most arguments of a call through one, whose code is made for each function passed.
const MAX_PARAMETERS: usize = 100;
/// Most arguments of a call.
const MAX_ARGUMENTS: usize = 4096;

/// Where a text stands: what its names mean, which channels it may use, and its place in a file.
pub(super) struct Setting<'s> {
    pub scope: &'s str,
    pub n_channels: u32,
    /// Whether `$1 = …` may stand there.
    pub has_outputs: bool,
    pub place: &'s Place,
}

/// Reads definitions into `table`.
pub(super) fn definitions(table: &mut Table, text: &str, setting: &Setting) -> Result<(), CalError> {
    let mut parser = Parser::new(table, text, setting)?;
    while parser.scan.peek().is_some() {
        if !parser.scan.take(b';')? {
            parser.statement()?;
        }
    }
    Ok(())
}

/// The name under which `$n` is kept; no other name looks like it.
pub(super) fn output_name(n: u32) -> String {
    format!("${n}")
}

/// Reads one expression; names that nobody knows get an entry in `table`.
pub(super) fn expression(table: &mut Table, text: &str, setting: &Setting) -> Result<Body, CalError> {
    let mut parser = Parser::new(table, text, setting)?;
    let root = parser.sum()?;
    match parser.scan.peek() {
        None => Ok(parser.body(root)),
        Some(_) => {
            Err(parser.scan.unexpected("an operator or the end of the expression", "give one expression"))
        }
    }
}

struct Parser<'a, 't> {
    scan: Scanner<'a>,
    table: &'t mut Table,
    scope: &'t str,
    n_channels: u32,
    has_outputs: bool,
    /// Of the function that is being defined.
    parameters: Vec<&'a str>,
    nodes: Vec<Node>,
    arguments: Vec<NodeId>,
    depth: usize,
    budget: fold::Budget,
}

impl<'a, 't> Parser<'a, 't> {
    fn new(table: &'t mut Table, text: &'a str, setting: &'t Setting) -> Result<Self, CalError> {
        let scan = Scanner::new(text, setting.place)?;
        if text.len() > MAX_BYTES {
            return Err(scan.too_large(
                "bytes of text",
                MAX_BYTES,
                "split it, or put its numbers into a data file",
            ));
        }
        Ok(Parser {
            scan,
            table,
            scope: setting.scope,
            n_channels: setting.n_channels,
            has_outputs: setting.has_outputs,
            parameters: vec![],
            nodes: vec![],
            arguments: vec![],
            depth: 0,
            budget: fold::Budget::default(),
        })
    }

    fn statement(&mut self) -> Result<(), CalError> {
        if self.scan.peek() == Some(b'$') && self.has_outputs {
            return self.output();
        }
        if !self.scan.at_name() {
            let advice = match self.scan.peek() {
                Some(b'$') => "outputs such as '$1 = …' belong to rcalc: define a variable",
                Some(b'_' | b'0'..=b'9') => "a name begins with a letter",
                _ => "write definitions such as 'a = 1;', 'pi : 3.14;' or 'f(x) = x*x;'",
            };
            return Err(self.scan.unexpected("the name of a definition", advice));
        }
        let at = self.scan.place();
        let name = self.scan.name()?;
        let n_parameters = if self.scan.peek() == Some(b'(') { Some(self.parameter_list()?) } else { None };
        let is_constant = self.scan.peek() == Some(b':');
        if !is_constant && self.scan.peek() != Some(b'=') {
            return Err(self.scan.unexpected(format!("'=' or ':' after '{name}'"), "define it by '='"));
        }
        let body = self.defined_as(name)?;
        let id = self.table.local(name, self.scope);
        self.table.define(id, Definition { n_parameters, is_constant, body, at });
        self.parameters.clear();
        Ok(())
    }

    /// `$n = e`
    fn output(&mut self) -> Result<(), CalError> {
        let at = self.scan.place();
        self.scan.advance()?;
        let name = output_name(self.channel_number()?);
        if self.scan.peek() != Some(b'=') {
            return Err(self.scan.unexpected(format!("'=' after '{name}'"), "define it by '='"));
        }
        let body = self.defined_as(&name)?;
        let id = self.table.local(&name, "");
        self.table.define(id, Definition { n_parameters: None, is_constant: false, body, at });
        Ok(())
    }

    /// What stands behind `=` or `:`, and the end of the statement.
    fn defined_as(&mut self, name: &str) -> Result<Arc<Body>, CalError> {
        self.scan.advance()?;
        let root = self.sum()?;
        if self.scan.peek().is_some() && !self.scan.take(b';')? {
            let advice = format!("end the definition of '{name}' by ';'");
            return Err(self.scan.unexpected("an operator or ';'", advice));
        }
        Ok(Arc::new(self.body(root)))
    }

    fn parameter_list(&mut self) -> Result<u16, CalError> {
        loop {
            self.scan.advance()?;
            if !self.scan.at_name() {
                return Err(self.scan.unexpected("the name of a parameter", "a name begins with a letter"));
            }
            let before = self.scan.place();
            let name = self.scan.name()?;
            if name.contains('`') {
                let problem = CalProblem::Unexpected {
                    expected: "the name of a parameter".into(),
                    found: format!("'{name}'"),
                    advice: "a parameter has no backquote".into(),
                };
                return Err(CalError::new(&before, problem));
            }
            if self.parameters.len() == MAX_PARAMETERS {
                return Err(self.scan.too_large("parameters", MAX_PARAMETERS, "use fewer"));
            }
            self.parameters.push(name);
            if self.scan.peek() != Some(b',') {
                break;
            }
        }
        if !self.scan.take(b')')? {
            return Err(self.scan.unexpected("',' or ')' after a parameter", "close the list by ')'"));
        }
        Ok(self.parameters.len() as u16)
    }

    /// `product + product - …`
    fn sum(&mut self) -> Result<NodeId, CalError> {
        self.depth += 1;
        if self.depth > MAX_NESTING {
            let advice = "define parts of it under names of their own";
            return Err(self.scan.too_large("levels of parentheses, calls and powers", MAX_NESTING, advice));
        }
        let mut left = self.product()?;
        while let Some(sign @ (b'+' | b'-')) = self.scan.peek() {
            self.scan.advance()?;
            let right = self.product()?;
            left = self.binary(if sign == b'+' { Operator::Add } else { Operator::Subtract }, left, right);
        }
        self.depth -= 1;
        Ok(left)
    }

    /// `power * power / …`
    fn product(&mut self) -> Result<NodeId, CalError> {
        let mut left = self.power()?;
        while let Some(sign @ (b'*' | b'/')) = self.scan.peek() {
            self.scan.advance()?;
            let divisor_at = self.scan.place();
            let right = self.power()?;
            if sign == b'/' && self.number(right) == Some(0.0) {
                let problem = CalProblem::Unexpected {
                    expected: "a divisor other than 0".into(),
                    found: "the constant 0".into(),
                    advice: "divide by something else".into(),
                };
                return Err(CalError::new(&divisor_at, problem));
            }
            left = self.binary(if sign == b'*' { Operator::Multiply } else { Operator::Divide }, left, right);
        }
        Ok(left)
    }

    /// `signed ^ power`
    fn power(&mut self) -> Result<NodeId, CalError> {
        let base = self.signed()?;
        if !self.scan.take(b'^')? {
            return Ok(base);
        }
        self.depth += 1;
        if self.depth > MAX_NESTING {
            return Err(self.scan.too_large(
                "levels of powers",
                MAX_NESTING,
                "define parts under names of their own",
            ));
        }
        let exponent = self.power()?;
        self.depth -= 1;
        Ok(self.binary(Operator::Power, base, exponent))
    }

    fn signed(&mut self) -> Result<NodeId, CalError> {
        if self.scan.take(b'-')? {
            let operand = self.primary()?;
            return Ok(match self.kind(operand) {
                Kind::Number(value) => self.node(Kind::Number(-value)),
                Kind::Negate(inner) => inner,
                _ => self.node(Kind::Negate(operand)),
            });
        }
        self.scan.take(b'+')?;
        self.primary()
    }

    fn primary(&mut self) -> Result<NodeId, CalError> {
        match self.scan.peek() {
            Some(b'(') => {
                self.scan.advance()?;
                let inner = self.sum()?;
                if !self.scan.take(b')')? {
                    return Err(self.scan.unexpected("an operator or ')'", "close the parenthesis by ')'"));
                }
                Ok(inner)
            }
            Some(b'$') => self.channel(),
            Some(b'0'..=b'9' | b'.') => {
                let value = self.scan.number()?;
                Ok(self.node(Kind::Number(value)))
            }
            _ if self.scan.at_name() => self.named(),
            _ => {
                let advice = match self.scan.peek() {
                    Some(b'-' | b'+') => {
                        "one sign at most: put the second one with its operand into parentheses"
                    }
                    Some(b')') => "a call has at least one argument, and parentheses are not empty",
                    _ => "complete the formula",
                };
                Err(self.scan.unexpected("a number, a name, '$', '(' or a sign", advice))
            }
        }
    }

    fn channel(&mut self) -> Result<NodeId, CalError> {
        self.scan.advance()?;
        let n = self.channel_number()?;
        Ok(self.node(if n > self.n_channels { Kind::NoChannel(n) } else { Kind::Channel(n) }))
    }

    fn channel_number(&mut self) -> Result<u32, CalError> {
        let before = self.scan.unexpected("the number of a channel after '$'", "write $1, $2, …");
        self.scan.digits()?.parse().ok().filter(|&n| n > 0).ok_or(before)
    }

    /// A parameter, a variable, or a call.
    fn named(&mut self) -> Result<NodeId, CalError> {
        let line = self.scan.line();
        let name = self.scan.name()?;
        let callee = match self.parameters.iter().position(|&parameter| parameter == name) {
            Some(at) => Callee::Parameter(at as u16),
            None => Callee::Name(self.table.link(name, self.scope)),
        };
        let kind = if self.scan.peek() == Some(b'(') {
            let (first, n) = self.argument_list(name, callee)?;
            Kind::Call { callee, first, n }
        } else {
            match callee {
                Callee::Parameter(at) => Kind::Parameter(at),
                Callee::Name(id) => Kind::Name(id),
            }
        };
        let folded = fold::constant(self.table, &self.nodes, &self.arguments, kind, &mut self.budget);
        Ok(self.node_at(folded.map_or(kind, Kind::Number), line))
    }

    fn argument_list(&mut self, function: &str, callee: Callee) -> Result<(u32, u16), CalError> {
        let (limit, what) = match callee {
            Callee::Name(_) => (MAX_ARGUMENTS, "arguments of a call"),
            Callee::Parameter(_) => (MAX_PARAMETERS, "arguments of a call through a parameter"),
        };
        let mut list = vec![];
        loop {
            self.scan.advance()?;
            if list.len() == limit {
                return Err(self.scan.too_large(what, limit, "use fewer, or a data file"));
            }
            list.push(self.sum()?);
            if self.scan.peek() != Some(b',') {
                break;
            }
        }
        if !self.scan.take(b')')? {
            let advice = format!("close the call of '{function}' by ')'");
            return Err(self.scan.unexpected("an operator, ',' or ')'", advice));
        }
        let first = self.arguments.len() as u32;
        self.arguments.extend_from_slice(&list);
        Ok((first, list.len() as u16))
    }

    /// A binary operation, folded where its value is known, whatever the other operand is, as Radiance does.
    fn binary(&mut self, operator: Operator, left: NodeId, right: NodeId) -> NodeId {
        use Operator::*;
        match (operator, self.number(left), self.number(right)) {
            (_, Some(a), Some(b)) => {
                let value = match operator {
                    Add => a + b,
                    Subtract => a - b,
                    Multiply => a * b,
                    Divide => a / b,
                    Power => builtin::power(a, b),
                };
                if value.is_finite() {
                    return self.node(Kind::Number(value));
                }
            }
            (Multiply | Divide | Power, Some(0.0), _) => return left,
            (Multiply, _, Some(0.0)) => return right,
            (Power, Some(1.0), _) => return left,
            (Power, _, Some(1.0)) => return left,
            (Power, _, Some(0.0)) => return self.node(Kind::Number(1.0)),
            _ => {}
        }
        self.node(Kind::Binary(operator, left, right))
    }

    fn number(&self, id: NodeId) -> Option<f64> {
        match self.kind(id) {
            Kind::Number(value) => Some(value),
            _ => None,
        }
    }

    fn kind(&self, id: NodeId) -> Kind {
        self.nodes[id as usize].kind
    }

    fn node(&mut self, kind: Kind) -> NodeId {
        self.node_at(kind, self.scan.line())
    }

    fn node_at(&mut self, kind: Kind, line: u32) -> NodeId {
        self.nodes.push(Node { kind, line });
        (self.nodes.len() - 1) as NodeId
    }

    /// The nodes read since the last body.
    fn body(&mut self, root: NodeId) -> Body {
        let nodes = std::mem::take(&mut self.nodes);
        let arguments = std::mem::take(&mut self.arguments);
        Body { nodes, arguments, root, file: self.scan.file().clone() }
    }
}
