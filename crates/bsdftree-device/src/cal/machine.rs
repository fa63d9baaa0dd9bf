//! Runs a [`Program`].
//!
//! Arguments of functions are delayed: each is computed when its value is first needed, in the place of its caller, and
//! kept, because Radiance's functions may end their recursion that way (`and(n, f(n - 1))`). A variable is computed once
//! per evaluation. All stacks are explicit and bounded, as is the number of operations, so no formula can exhaust the
//! thread's stack or run for ever.
//!
//! Faults: a division by 0, a power or library function without a finite result. Their value is 0 and they are counted,
//! as in Radiance, whose renderer then leaves the pattern or material out ("compute error").

use super::builtin::{self, Builtin};
use super::error::{CalError, CalProblem};
use super::inputs::Inputs;
use super::program::{Named, Op, Program};
use super::scratch::{Argument, Limits, Record, Scratch, Variable, What};
use crate::error::Place;

/// No call around: outside of functions.
const NOWHERE: u32 = u32::MAX;

/// The value of the code that begins at `pc`. [`Scratch::begin`] must have been called for this program; what is known
/// of variables stays known, so that several formulas can share them.
pub(super) fn run<I: Inputs + ?Sized>(
    program: &Program,
    pc: u32,
    inputs: &I,
    scratch: &mut Scratch,
) -> Result<f64, CalError> {
    let limits = scratch.limits();
    scratch.values.clear();
    scratch.records.clear();
    Machine { program, inputs, scratch, limits, pc, here: NOWHERE, base: 0, n: 0 }.run()
}

struct Machine<'a, I: ?Sized> {
    program: &'a Program,
    inputs: &'a I,
    scratch: &'a mut Scratch,
    limits: Limits,
    pc: u32,
    /// The record of the present call.
    here: u32,
    /// The first argument and the number of arguments of the present call.
    base: u32,
    n: u16,
}

impl<I: Inputs + ?Sized> Machine<'_, I> {
    fn run(mut self) -> Result<f64, CalError> {
        loop {
            let op = self.program.code[self.pc as usize];
            self.pc += 1;
            self.scratch.steps += 1;
            if self.scratch.steps > self.limits.steps {
                return Err(self.endless("operations", self.limits.steps, None));
            }
            match op {
                Op::Number(value) => self.push(value),
                Op::Channel(n) => self.push(self.inputs.channel(n)),
                Op::Parameter(at) => self.parameter(at)?,
                Op::Variable(at) => match self.scratch.variables[at as usize] {
                    Variable::Known(value) => self.push(value),
                    Variable::Unknown => {
                        let variable = &self.program.variables[at as usize];
                        self.scratch.variables[at as usize] = Variable::Pending;
                        self.enter(What::Variable(at), variable.pc, NOWHERE, (0, 0))?;
                    }
                    Variable::Pending => {
                        let Named { name, at, .. } = &self.program.variables[at as usize];
                        return Err(CalError::new(at, CalProblem::Circular { name: name.to_string() }));
                    }
                },
                Op::Negate => {
                    let value = self.pop();
                    self.push(-value);
                }
                Op::Add => self.binary(|a, b| a + b),
                Op::Subtract => self.binary(|a, b| a - b),
                Op::Multiply => self.binary(|a, b| a * b),
                Op::Divide => {
                    let (b, a) = (self.pop(), self.pop());
                    // Only the divisor 0 is a fault; overflow is not.
                    if b == 0.0 { self.fault() } else { self.push(a / b) }
                }
                Op::Power => {
                    let (b, a) = (self.pop(), self.pop());
                    self.push_checked(builtin::power(a, b));
                }
                Op::Maximum => {
                    let (b, a) = (self.pop(), self.pop());
                    self.push_checked(if a < b { b } else { a });
                }
                Op::Minimum => {
                    let (b, a) = (self.pop(), self.pop());
                    self.push_checked(if a > b { b } else { a });
                }
                Op::Library(builtin) => self.library(builtin),
                Op::RealArgument => self.real_argument()?,
                Op::Branch(target) => {
                    // Not a number is not above 0.
                    let holds = self.pop() > 0.0;
                    if !holds {
                        self.pc = target;
                    }
                }
                Op::Jump(target) => self.pc = target,
                Op::Select { n, end } => self.select(n, end),
                Op::PassNumber(value) => self.scratch.arguments.push(Argument::Value(value)),
                Op::PassValue => {
                    let value = self.pop();
                    self.scratch.arguments.push(Argument::Value(value));
                }
                Op::PassParameter(at) => self.pass_parameter(at)?,
                Op::PassName(name) => self.scratch.arguments.push(Argument::Name(name)),
                Op::PassLazy(code) => self.scratch.arguments.push(Argument::Lazy(code, self.here)),
                Op::Call { function, n } => self.call(function, n)?,
                Op::CallParameter { parameter, n } => {
                    let function = self.passed_function(parameter, n)?;
                    self.call(function, n)?;
                }
                Op::Return => {
                    if let Some(value) = self.leave() {
                        return Ok(value);
                    }
                }
                Op::Fail(problem) => return Err(self.program.problems[problem as usize].clone()),
            }
        }
    }

    fn push(&mut self, value: f64) {
        self.scratch.values.push(value);
    }

    fn pop(&mut self) -> f64 {
        // Code is made so that each operation finds its operands.
        self.scratch.values.pop().unwrap_or(0.0)
    }

    fn binary(&mut self, operation: impl Fn(f64, f64) -> f64) {
        let (b, a) = (self.pop(), self.pop());
        self.push(operation(a, b));
    }

    fn fault(&mut self) {
        self.scratch.faults += 1;
        self.push(0.0);
    }

    fn push_checked(&mut self, value: f64) {
        if value.is_finite() { self.push(value) } else { self.fault() }
    }

    fn library(&mut self, builtin: Builtin) {
        let values = &mut self.scratch.values;
        let first = values.len() - builtin.n_needed();
        let value = builtin.value(&values[first..]).unwrap_or(f64::NAN);
        values.truncate(first);
        self.push_checked(value);
    }

    fn real_argument(&mut self) -> Result<(), CalError> {
        let n = rounded(self.pop());
        let given = self.inputs.argument(0);
        if n < 1 {
            self.push(given);
        } else if f64::from(n) > given {
            let problem = CalProblem::MissingArgument { needed: n, given: given as u32 };
            return Err(CalError::new(&self.place(), problem));
        } else {
            self.push(self.inputs.argument(n));
        }
        Ok(())
    }

    fn select(&mut self, n: u16, end: u32) {
        let index = self.pop();
        let rounded = rounded(index);
        if index < -0.5 || rounded > u32::from(n) {
            self.fault();
            self.pc = end;
        } else if rounded == 0 {
            self.push(n.into());
            self.pc = end;
        } else {
            self.pc += rounded - 1;
        }
    }

    /// Position of a parameter's argument.
    fn argument_at(&self, at: u16) -> Result<u32, CalError> {
        if at < self.n {
            return Ok(self.base + u32::from(at));
        }
        let problem = CalProblem::TooFewArguments {
            function: self.present_function().to_owned(),
            needed: usize::from(at) + 1,
            given: self.n.into(),
        };
        Err(CalError::new(&self.place(), problem))
    }

    fn parameter(&mut self, at: u16) -> Result<(), CalError> {
        let mut position = self.argument_at(at)?;
        if let Argument::Same(other) = self.scratch.arguments[position as usize] {
            position = other;
        }
        match self.scratch.arguments[position as usize] {
            Argument::Value(value) => self.push(value),
            Argument::Lazy(code, call) => {
                let (base, n) = self.extent(call);
                self.enter(What::Lazy(position), code, call, (base, n))?;
            }
            Argument::Name(name) => {
                self.enter(What::Name, self.program.names[name as usize].value_pc, NOWHERE, (0, 0))?;
            }
            Argument::Same(_) => unreachable!("arguments that are passed on point at where they come from"),
        }
        Ok(())
    }

    fn pass_parameter(&mut self, at: u16) -> Result<(), CalError> {
        let position = self.argument_at(at)?;
        let passed = match self.scratch.arguments[position as usize] {
            Argument::Lazy(..) => Argument::Same(position),
            Argument::Same(other) => match self.scratch.arguments[other as usize] {
                value @ Argument::Value(_) => value,
                _ => Argument::Same(other),
            },
            known => known,
        };
        self.scratch.arguments.push(passed);
        Ok(())
    }

    /// The function that was passed for a parameter and is called with `n` arguments.
    fn passed_function(&mut self, parameter: u16, n: u16) -> Result<u32, CalError> {
        let position = self.argument_at(parameter)?;
        let Argument::Name(name) = self.scratch.arguments[position as usize] else {
            let problem = CalProblem::NotAFunction {
                function: self.present_function().to_owned(),
                parameter: usize::from(parameter) + 1,
            };
            return Err(CalError::new(&self.place(), problem));
        };
        let name = &self.program.names[name as usize];
        let by_count =
            || name.by_count.binary_search_by_key(&n, |&(n, _)| n).ok().map(|at| name.by_count[at].1);
        name.function.or_else(by_count).ok_or_else(|| name.undefined.clone())
    }

    fn call(&mut self, function: u32, n: u16) -> Result<(), CalError> {
        let base = self.scratch.arguments.len() as u32 - u32::from(n);
        let pc = self.program.functions[function as usize].pc;
        self.enter(What::Call(function), pc, self.scratch.records.len() as u32, (base, n))
    }

    /// Goes to other code, to come back here.
    fn enter(&mut self, what: What, pc: u32, call: u32, (base, n): (u32, u16)) -> Result<(), CalError> {
        if self.scratch.records.len() >= self.limits.depth {
            return Err(self.endless("calls within calls", self.limits.depth, Some(what)));
        }
        if self.scratch.values.len().max(self.scratch.arguments.len()) > self.limits.waiting {
            return Err(self.endless("values that wait", self.limits.waiting, Some(what)));
        }
        let (own_base, own_n) = if let What::Call(_) = what { (base, n) } else { (0, 0) };
        self.scratch.records.push(Record { what, pc: self.pc, outer: self.here, base: own_base, n: own_n });
        (self.pc, self.here, self.base, self.n) = (pc, call, base, n);
        Ok(())
    }

    /// Comes back from other code; the value of everything, if that was the outermost one.
    fn leave(&mut self) -> Option<f64> {
        let value = self.scratch.values.last().copied().unwrap_or(0.0);
        let Some(record) = self.scratch.records.pop() else { return Some(value) };
        match record.what {
            What::Call(_) => self.scratch.arguments.truncate(record.base as usize),
            What::Lazy(position) => self.scratch.arguments[position as usize] = Argument::Value(value),
            What::Name => {}
            What::Variable(at) => self.scratch.variables[at as usize] = Variable::Known(value),
        }
        (self.pc, self.here) = (record.pc, record.outer);
        (self.base, self.n) = self.extent(record.outer);
        None
    }

    /// The first argument and the number of arguments of a call.
    fn extent(&self, call: u32) -> (u32, u16) {
        match self.scratch.records.get(call as usize) {
            Some(record) => (record.base, record.n),
            None => (0, 0),
        }
    }

    fn present_function(&self) -> &str {
        match self.scratch.records.get(self.here as usize) {
            Some(&Record { what: What::Call(function), .. }) => {
                &self.program.functions[function as usize].name
            }
            _ => "",
        }
    }

    /// The place of the present operation.
    fn place(&self) -> Place {
        self.program
            .place(self.pc - 1)
            .cloned()
            .unwrap_or_else(|| Place { file: "expression".into(), line: 1 })
    }

    #[cold]
    fn endless(&self, what: &'static str, limit: usize, entered: Option<What>) -> CalError {
        let innermost =
            entered.into_iter().chain(self.scratch.records.iter().rev().map(|record| record.what));
        let named = innermost.into_iter().find_map(|what| match what {
            What::Call(function) => Some(&self.program.functions[function as usize]),
            What::Variable(at) => Some(&self.program.variables[at as usize]),
            What::Lazy(_) | What::Name => None,
        });
        let (name, at) = match named {
            Some(Named { name, at, .. }) => (name.to_string(), at.clone()),
            None => ("the expression".into(), self.place()),
        };
        CalError::new(&at, CalProblem::Endless { name, what, limit })
    }
}

/// To the nearest whole number, halves upwards; 0 for what is below 1/2 or not a number.
fn rounded(x: f64) -> u32 {
    (x + 0.5) as u32
}
