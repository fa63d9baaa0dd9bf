//! From parsed formulas to a program: everything they reach, names resolved, no look-up left for evaluation.
//!
//! Invariants: each variable and each function is compiled once, so a program is no larger than the text that it comes
//! from; jumps go forward, so only calls, variables and delayed arguments can make an evaluation long; a name without
//! definition becomes an operation that fails, because a formula may stand in a branch that is never taken.

use super::builtin::Builtin;
use super::error::{CalError, CalProblem};
use super::inputs::Uses;
use super::library::Arguments;
use super::program::{Entry, Named, Op, PassedName, Program};
use super::table::Table;
use super::tree::{Body, Callee, Kind, NodeId, Operator};
use super::uses::Dependencies;
use crate::error::Place;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

/// Makes one program.
pub(super) struct Compiler<'t> {
    table: &'t Table,
    max_ops: usize,
    pub(super) program: Program,
    variables: BTreeMap<u32, u32>,
    functions: BTreeMap<u32, u32>,
    names: BTreeMap<u32, u32>,
    /// Numbers of arguments with which parameters are called.
    pub(super) called_with: BTreeSet<u16>,
    queue: VecDeque<Job>,
    /// Which part of the program uses what; parts are entries, variables, functions and passed names.
    pub(super) dependencies: Dependencies<Part>,
    pub(super) part: Part,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Part {
    Entry(u32),
    Variable(u32),
    Function(u32),
    Name(u32),
}

/// Code that is still to be made.
enum Job {
    Part(Part, Arc<Body>),
    /// The value of a passed name.
    NameValue(u32, u32, Place),
    /// A delayed argument of the part, and the operation that passes it.
    Lazy(Part, Arc<Body>, NodeId, usize),
}

/// Arguments of at most so many nodes, without anything that could fail, are computed at once rather than delayed.
const MAX_EAGER: usize = 8;

impl<'t> Compiler<'t> {
    /// `max_ops` bounds the size; a program that is cut because of it must not be run.
    pub(super) fn new(table: &'t Table, max_ops: usize) -> Self {
        Compiler {
            table,
            max_ops,
            program: Program::default(),
            variables: BTreeMap::new(),
            functions: BTreeMap::new(),
            names: BTreeMap::new(),
            called_with: BTreeSet::new(),
            queue: VecDeque::new(),
            dependencies: Dependencies::default(),
            part: Part::Entry(0),
        }
    }

    /// The program whose entries are these formulas.
    pub(super) fn link(mut self, formulas: &[Arc<Body>]) -> Program {
        for (at, body) in formulas.iter().enumerate() {
            self.program.entries.push(Entry::default());
            self.queue.push_back(Job::Part(Part::Entry(at as u32), body.clone()));
        }
        self.finish()
    }

    /// The program whose entry calls a function with `n` values; `None` if there is no such function.
    pub(super) fn link_function(mut self, id: u32, n: u16, at: &Place) -> Option<Program> {
        let entry = self.table.entry(id);
        let is_user = entry.definition.as_ref().is_some_and(|definition| definition.n_parameters.is_some());
        let function = match entry.builtin {
            _ if is_user => self.function(id),
            Some(builtin) => self.library_function(builtin, n, at),
            None => return None,
        };
        let pc = self.program.code.len() as u32;
        self.part = Part::Entry(0);
        self.dependencies.needs(self.part, Part::Function(function));
        self.program.entries.push(Entry { pc, ..Entry::default() });
        self.op(Op::Call { function, n });
        self.op(Op::Return);
        Some(self.finish())
    }

    fn finish(mut self) -> Program {
        while let Some(job) = self.queue.pop_front() {
            if self.program.code.len() > self.max_ops {
                self.program.is_cut = true;
                return self.program;
            }
            self.job(job);
        }
        self.library_functions_for_names();
        let uses = self.dependencies.resolve();
        let of = |part| uses.get(&part).copied().unwrap_or_default();
        for (at, entry) in self.program.entries.iter_mut().enumerate() {
            entry.uses = of(Part::Entry(at as u32));
        }
        self.program.variable_uses =
            (0..self.program.variables.len()).map(|at| of(Part::Variable(at as u32))).collect();
        self.program
    }

    fn job(&mut self, job: Job) {
        let pc = self.program.code.len() as u32;
        match job {
            Job::Part(part, body) => {
                self.part = part;
                match part {
                    Part::Entry(at) => self.program.entries[at as usize].pc = pc,
                    Part::Variable(at) => self.program.variables[at as usize].pc = pc,
                    Part::Function(at) => self.program.functions[at as usize].pc = pc,
                    Part::Name(_) => {}
                }
                self.node(&body, body.root);
            }
            Job::NameValue(name, id, place) => {
                self.part = Part::Name(name);
                self.program.names[name as usize].value_pc = pc;
                self.variable(id, &place);
            }
            Job::Lazy(part, body, node, passed_at) => {
                self.part = part;
                self.program.code[passed_at] = Op::PassLazy(pc);
                self.node(&body, node);
            }
        }
        self.op(Op::Return);
    }

    pub(super) fn node(&mut self, body: &Arc<Body>, id: NodeId) {
        // Long sums lean to the left: their depth must not become recursion.
        let mut leftmost = id;
        let mut right = vec![];
        while let Kind::Binary(operator, left, operand) = body.kind(leftmost) {
            right.push((operator, operand));
            leftmost = left;
        }
        self.operand(body, leftmost);
        for (operator, operand) in right.into_iter().rev() {
            self.node(body, operand);
            self.op(match operator {
                Operator::Add => Op::Add,
                Operator::Subtract => Op::Subtract,
                Operator::Multiply => Op::Multiply,
                Operator::Divide => Op::Divide,
                Operator::Power => Op::Power,
            });
        }
    }

    fn operand(&mut self, body: &Arc<Body>, id: NodeId) {
        match body.kind(id) {
            Kind::Number(value) => self.op(Op::Number(value)),
            Kind::Channel(n) => {
                self.dependencies.uses(self.part, Uses::of_channel(n));
                self.op(Op::Channel(n));
            }
            Kind::NoChannel(channel) => self.fail(&body.place(id), CalProblem::NoChannel { channel }),
            Kind::Parameter(at) => {
                self.placed(body.place(id));
                self.op(Op::Parameter(at));
            }
            Kind::Name(name) => self.variable(name, &body.place(id)),
            Kind::Negate(inner) => {
                self.node(body, inner);
                self.op(Op::Negate);
            }
            Kind::Binary(..) => self.node(body, id),
            Kind::Call { callee, first, n } => {
                let nodes = &body.arguments[first as usize..][..usize::from(n)];
                self.call(callee, body, nodes, &body.place(id));
            }
        }
    }

    fn call(&mut self, callee: Callee, body: &Arc<Body>, nodes: &[NodeId], place: &Place) {
        let n = nodes.len() as u16;
        match callee {
            Callee::Parameter(parameter) => {
                nodes.iter().for_each(|&node| self.pass(body, node));
                self.called_with.insert(n);
                self.placed(place.clone());
                self.op(Op::CallParameter { parameter, n });
            }
            Callee::Name(id) => {
                let entry = self.table.entry(id);
                if entry.definition.as_ref().is_some_and(|definition| definition.n_parameters.is_some()) {
                    let function = self.function(id);
                    self.dependencies.needs(self.part, Part::Function(function));
                    nodes.iter().for_each(|&node| self.pass(body, node));
                    self.op(Op::Call { function, n });
                } else if let Some(builtin) = entry.builtin {
                    self.library_call(builtin, Arguments::Nodes(body, nodes), place);
                } else {
                    self.fail(place, self.undefined_function(id));
                }
            }
        }
    }

    /// Code that puts an argument where a function finds it.
    fn pass(&mut self, body: &Arc<Body>, node: NodeId) {
        match body.kind(node) {
            Kind::Number(value) => self.op(Op::PassNumber(value)),
            Kind::Parameter(at) => {
                self.placed(body.place(node));
                self.op(Op::PassParameter(at));
            }
            Kind::Name(id) => {
                let name = self.passed_name(id, body.place(node));
                self.dependencies.needs(self.part, Part::Name(name));
                self.op(Op::PassName(name));
            }
            _ if is_eager(body, node, &mut MAX_EAGER.clone()) => {
                self.node(body, node);
                self.op(Op::PassValue);
            }
            _ => {
                self.queue.push_back(Job::Lazy(self.part, body.clone(), node, self.program.code.len()));
                self.op(Op::PassLazy(0));
            }
        }
    }

    fn variable(&mut self, id: u32, place: &Place) {
        let table = self.table;
        let entry = table.entry(id);
        match &entry.definition {
            Some(definition) if definition.n_parameters.is_none() => {
                if is_short(self.table, &definition.body) {
                    return self.operand(&definition.body, definition.body.root);
                }
                let variable = *self.variables.entry(id).or_insert_with(|| {
                    let at = self.program.variables.len() as u32;
                    self.program.variables.push(Named {
                        pc: 0,
                        name: entry.name.clone(),
                        at: definition.at.clone(),
                    });
                    self.queue.push_back(Job::Part(Part::Variable(at), definition.body.clone()));
                    at
                });
                self.dependencies.needs(self.part, Part::Variable(variable));
                self.op(Op::Variable(variable));
            }
            _ => {
                let is_function = entry.definition.is_some() || entry.builtin.is_some();
                let advice = if is_function {
                    "it is a function: call it with its arguments"
                } else {
                    "define it in the function file, or correct its name"
                };
                let problem = CalProblem::Undefined {
                    kind: "variable",
                    name: entry.name.to_string(),
                    advice: advice.into(),
                };
                self.fail(place, problem);
            }
        }
    }

    /// The number of a function with a definition.
    fn function(&mut self, id: u32) -> u32 {
        let entry = self.table.entry(id);
        let Some(definition) = &entry.definition else { unreachable!("only called for definitions") };
        *self.functions.entry(id).or_insert_with(|| {
            let at = self.program.functions.len() as u32;
            self.program.functions.push(Named { pc: 0, name: entry.name.clone(), at: definition.at.clone() });
            self.queue.push_back(Job::Part(Part::Function(at), definition.body.clone()));
            at
        })
    }

    /// The number of a name that is passed as an argument, whether for its value or as a function.
    fn passed_name(&mut self, id: u32, place: Place) -> u32 {
        if let Some(&name) = self.names.get(&id) {
            return name;
        }
        let name = self.program.names.len() as u32;
        self.names.insert(id, name);
        let entry = self.table.entry(id);
        let is_user = entry.definition.as_ref().is_some_and(|definition| definition.n_parameters.is_some());
        let function = is_user.then(|| self.function(id));
        if let Some(function) = function {
            self.dependencies.needs(Part::Name(name), Part::Function(function));
        }
        let undefined = CalError::new(&place, self.undefined_function(id));
        let passed =
            PassedName { value_pc: 0, function, builtin: entry.builtin, by_count: vec![], undefined };
        self.program.names.push(passed);
        self.queue.push_back(Job::NameValue(name, id, place));
        name
    }

    pub(super) fn undefined_function(&self, id: u32) -> CalProblem {
        let entry = self.table.entry(id);
        let advice = if entry.definition.is_some() {
            "it is a variable: use it without arguments"
        } else {
            "define it in the function file, or correct its name"
        };
        CalProblem::Undefined { kind: "function", name: entry.name.to_string(), advice: advice.into() }
    }

    pub(super) fn fail(&mut self, place: &Place, problem: CalProblem) {
        self.op(Op::Fail(self.program.problems.len() as u32));
        self.program.problems.push(CalError::new(place, problem));
    }

    /// Notes where the next operation stands, for its errors.
    pub(super) fn placed(&mut self, place: Place) {
        self.program.places.push((self.here(), place));
    }

    pub(super) fn here(&self) -> u32 {
        self.program.code.len() as u32
    }

    pub(super) fn reserve(&mut self) -> usize {
        self.op(Op::Jump(0));
        self.program.code.len() - 1
    }

    pub(super) fn op(&mut self, op: Op) {
        self.program.code.push(op);
    }
}

/// Whether a variable's formula costs less than to look its value up: a number, a channel, `arg(n)`.
fn is_short(table: &Table, body: &Body) -> bool {
    match body.kind(body.root) {
        Kind::Number(_) | Kind::Channel(_) => true,
        Kind::Call { callee: Callee::Name(id), first, n: 1 } => {
            let entry = table.entry(id);
            let is_arg = entry.definition.is_none() && entry.builtin == Some(Builtin::Arg);
            is_arg && matches!(body.kind(body.arguments[first as usize]), Kind::Number(_))
        }
        _ => false,
    }
}

/// Whether an argument is short and cannot fail, so that it may be computed even if it is never used.
fn is_eager(body: &Body, node: NodeId, left: &mut usize) -> bool {
    let Some(fewer) = left.checked_sub(1) else { return false };
    *left = fewer;
    match body.kind(node) {
        Kind::Number(_) | Kind::Channel(_) => true,
        Kind::Negate(inner) => is_eager(body, inner, left),
        Kind::Binary(Operator::Add | Operator::Subtract | Operator::Multiply, a, b) => {
            is_eager(body, a, left) && is_eager(body, b, left)
        }
        _ => false,
    }
}
