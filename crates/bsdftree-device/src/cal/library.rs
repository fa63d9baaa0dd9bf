//! Calls of library functions, in code.
//!
//! `if` and `select` become jumps, so that only what is chosen is computed. A library function whose name is passed as
//! an argument gets code of its own for each number of arguments with which parameters are called.

use super::builtin::Builtin;
use super::compile::{Compiler, Part};
use super::error::CalProblem;
use super::inputs::Uses;
use super::program::{Named, Op, PassedName};
use super::tree::{Body, NodeId};
use crate::error::Place;
use std::sync::Arc;

/// The arguments of a library function.
#[derive(Clone, Copy)]
pub(super) enum Arguments<'b> {
    Nodes(&'b Arc<Body>, &'b [NodeId]),
    /// As many parameters of the present function.
    Parameters(u16),
}

impl Arguments<'_> {
    fn len(self) -> usize {
        match self {
            Arguments::Nodes(_, nodes) => nodes.len(),
            Arguments::Parameters(n) => n.into(),
        }
    }
}

impl Compiler<'_> {
    pub(super) fn library_call(&mut self, builtin: Builtin, arguments: Arguments, place: &Place) {
        let n = arguments.len();
        match builtin {
            Builtin::If => {
                self.argument(builtin, arguments, 0, place);
                let branch = self.reserve();
                self.argument(builtin, arguments, 1, place);
                let jump = self.reserve();
                self.program.code[branch] = Op::Branch(self.here());
                self.argument(builtin, arguments, 2, place);
                self.program.code[jump] = Op::Jump(self.here());
            }
            Builtin::Select => {
                self.argument(builtin, arguments, 0, place);
                let select = self.reserve();
                let table: Vec<usize> = (1..n).map(|_| self.reserve()).collect();
                let mut ends = vec![];
                for (at, &jump) in table.iter().enumerate() {
                    self.program.code[jump] = Op::Jump(self.here());
                    self.argument(builtin, arguments, at + 1, place);
                    ends.push(self.reserve());
                }
                let end = self.here();
                self.program.code[select] = Op::Select { n: (n - 1) as u16, end };
                ends.into_iter().for_each(|jump| self.program.code[jump] = Op::Jump(end));
            }
            Builtin::Max | Builtin::Min => {
                self.argument(builtin, arguments, 0, place);
                for at in (1..n).rev() {
                    self.argument(builtin, arguments, at, place);
                    self.op(if builtin == Builtin::Max { Op::Maximum } else { Op::Minimum });
                }
            }
            _ => {
                (0..builtin.n_needed()).for_each(|at| self.argument(builtin, arguments, at, place));
                self.placed(place.clone());
                if builtin == Builtin::Arg {
                    self.dependencies.uses(self.part, Uses::of_arguments());
                    self.op(Op::RealArgument);
                } else {
                    self.op(Op::Library(builtin));
                }
            }
        }
    }

    /// Argument `at` of a library function; code that fails if it was not given.
    fn argument(&mut self, builtin: Builtin, arguments: Arguments, at: usize, place: &Place) {
        match arguments {
            _ if at >= arguments.len() => {
                let problem = CalProblem::TooFewArguments {
                    function: builtin.name().into(),
                    needed: at + 1,
                    given: arguments.len(),
                };
                self.fail(place, problem);
            }
            Arguments::Nodes(body, nodes) => self.node(body, nodes[at]),
            Arguments::Parameters(_) => self.op(Op::Parameter(at as u16)),
        }
    }

    /// Makes library functions callable for which names were passed.
    pub(super) fn library_functions_for_names(&mut self) {
        for name in 0..self.program.names.len() {
            let PassedName { function, builtin, undefined, .. } = &self.program.names[name];
            let (None, Some(builtin), place) = (*function, *builtin, undefined.at.clone()) else { continue };
            for n in self.called_with.clone() {
                let function = self.library_function(builtin, n, &place);
                self.dependencies.needs(Part::Name(name as u32), Part::Function(function));
                self.program.names[name].by_count.push((n, function));
            }
        }
    }

    /// A function of `n` parameters that calls a library function with them.
    pub(super) fn library_function(&mut self, builtin: Builtin, n: u16, place: &Place) -> u32 {
        let function = self.program.functions.len() as u32;
        let pc = self.here();
        self.program.functions.push(Named { pc, name: builtin.name().into(), at: place.clone() });
        self.part = Part::Function(function);
        self.library_call(builtin, Arguments::Parameters(n), place);
        self.op(Op::Return);
        function
    }
}
