//! The formulas of a command, in Radiance's function language, with what `-e` and `-f` define.
//!
//! What all formulas of a command may compute is bounded, so that no command runs for ever.

use super::Environment;
use super::arguments::Arguments;
use super::output::TooMany;
use crate::cal::{Context, Function, Scratch};
use crate::error::{DeviceError, Place};

/// What the generators know beside the library functions.
const STANDARD: &str = "PI : 3.14159265358979323846;
    bezier(p1, p2, p3, p4, t) = p1*(1 + t*(-3 + t*(3 - t))) + p2*3*t*(1 + t*(-2 + t)) + p3*3*t*t*(1 - t) + p4*t*t*t;
    bspline(pp, p0, p1, pn, t) = pp*(1/6 + t*(-.5 + t*(.5 - t/6))) + p0*(2/3 + t*t*(-1 + .5*t))
        + p1*(1/6 + t*(.5 + t*(.5 - .5*t))) + pn*t*t*t/6;";

/// Definitions so far.
pub(super) struct Functions {
    context: Context,
}

impl Functions {
    pub fn new() -> Self {
        let mut context = Context::new();
        context.define(STANDARD).expect("our own definitions are right");
        Functions { context }
    }

    /// Takes `-e` or `-f` with what follows; false if the option is another.
    pub fn option(
        &mut self,
        option: &str,
        arguments: &mut Arguments,
        environment: &Environment,
    ) -> Result<bool, DeviceError> {
        match option {
            "-e" => self.context.load_at(arguments.word("definitions after -e")?, environment.at)?,
            "-f" => {
                let file = arguments.word("a file after -f")?;
                let text = (environment.read)(file)?;
                self.context.load(&text, file)?;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// A number of at least 1 by a constant formula, rounded as Radiance rounds it.
    pub fn count(
        &self,
        formula: &str,
        what: &str,
        arguments: &Arguments,
        environment: &Environment,
    ) -> Result<u64, DeviceError> {
        let value = self.context.compile_at(formula, environment.at)?.evaluate(&())?;
        match (value + 0.5) as u64 {
            0 => Err(arguments.unexpected(&format!("{what}, at least 1"), Some(formula))),
            count => Ok(count),
        }
    }

    /// Whether there is a function of this name.
    pub fn has(&self, function: &str) -> bool {
        self.context.n_parameters(function).is_some()
    }

    /// Formulas of these variables.
    pub fn compile(
        &self,
        formulas: &[&str],
        variables: &[&str],
        environment: &Environment,
    ) -> Result<Curve, DeviceError> {
        let mut context = self.context.clone();
        let functions = formulas.iter().enumerate().map(|(k, formula)| {
            let text = format!("formula_{k}_of_command({}) = {formula};", variables.join(", "));
            context.load_at(&text, environment.at)?;
            Ok(context.function_at(&format!("formula_{k}_of_command"), variables.len(), environment.at)?)
        });
        let functions = functions.collect::<Result<Vec<Function>, DeviceError>>()?;
        let values = vec![0.0; functions.len()];
        Ok(Curve {
            functions,
            values,
            most_steps: environment.most_steps,
            n_steps: 0,
            at: environment.at.clone(),
        })
    }
}

/// Formulas that are evaluated together.
pub(super) struct Curve {
    functions: Vec<Function>,
    values: Vec<f64>,
    most_steps: u64,
    n_steps: u64,
    at: Place,
}

impl Curve {
    /// Their values.
    pub fn at(&mut self, parameters: &[f64]) -> Result<&[f64], DeviceError> {
        for (value, function) in self.values.iter_mut().zip(&self.functions) {
            let mut scratch = Scratch::default();
            *value = function.call_in(parameters, &(), &mut scratch)?;
            self.n_steps += scratch.steps() as u64;
            if self.n_steps > self.most_steps {
                return Err(TooMany::Operations.error(&self.at, self.most_steps));
            }
        }
        Ok(&self.values)
    }
}
