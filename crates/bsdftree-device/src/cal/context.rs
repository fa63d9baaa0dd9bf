//! Definitions, and what is compiled against them.

use super::compile::Compiler;
use super::error::{CalError, CalProblem};
use super::expression::{Expression, Expressions, Function};
use super::parse::{self, Setting};
use super::rayinit;
use super::table::{self, Table};
use crate::error::Place;
use std::sync::{Arc, OnceLock};

/// Definitions of variables and functions, in a scope. A clone is cheap, and goes its own way from then on.
///
/// All files of a renderer share one set of names, each file having its own scope: see [`Context::enter_file`].
#[derive(Clone, Debug, PartialEq)]
pub struct Context {
    table: Arc<Table>,
    scope: Arc<str>,
    n_channels: u32,
    has_outputs: bool,
}

impl Default for Context {
    fn default() -> Self {
        Context::new()
    }
}

impl Context {
    /// Library functions only, as `rcalc` has it: any channel may be used, and `$1 = …;` defines an output.
    pub fn new() -> Self {
        Context { table: Arc::default(), scope: "".into(), n_channels: u32::MAX, has_outputs: true }
    }

    /// Library functions and the standard names of a renderer; a ray has the channels of [`rayinit`].
    pub fn rayinit() -> Self {
        static STANDARD: OnceLock<Context> = OnceLock::new();
        let standard = STANDARD.get_or_init(|| {
            let mut context = Context::new();
            context.load(rayinit::DEFINITIONS, "standard names").expect("our own definitions are right");
            context.n_channels = rayinit::N_NUMBERED;
            context.has_outputs = false;
            context
        });
        standard.clone()
    }

    /// Makes the scope of a function file the present one: new definitions belong to it, names are looked for there
    /// first and then among the global ones. `""` is the global scope.
    ///
    /// The scope of `lib/tiles.cal` is `lib_tiles`, as in Radiance; its `size` can be had from anywhere as
    /// ``size`lib_tiles``.
    pub fn enter_file(&mut self, file: &str) {
        self.scope = table::scope_of_file(file).into();
    }

    /// Makes a scope the present one, by its name; `""` is the global scope.
    pub fn enter(&mut self, scope: &str) {
        self.scope = table::scope_named(scope).into();
    }

    /// Adds the definitions of a function file, under the name that errors give it. On an error nothing is added.
    ///
    /// # Errors
    /// What is not as the grammar asks for, with its line.
    pub fn load(&mut self, text: &str, file: &str) -> Result<(), CalError> {
        self.load_at(text, &Place { file: file.into(), line: 1 })
    }

    /// Adds definitions such as `a = 1; f(x) = a*x;`. On an error nothing is added.
    ///
    /// # Errors
    /// As [`Context::load`].
    pub fn define(&mut self, text: &str) -> Result<(), CalError> {
        self.load(text, "definition")
    }

    /// Adds definitions from a text that begins at a place of some other file.
    ///
    /// # Errors
    /// As [`Context::load`].
    pub fn load_at(&mut self, text: &str, place: &Place) -> Result<(), CalError> {
        let mut table = Table::clone(&self.table);
        parse::definitions(&mut table, text, &self.setting(place))?;
        self.table = Arc::new(table);
        Ok(())
    }

    /// Compiles a formula; a name alone is one.
    ///
    /// A name without definition is an error only when an evaluation comes to it, as in Radiance;
    /// [`Expression::problems`] has them all.
    ///
    /// # Errors
    /// What is not as the grammar asks for.
    pub fn compile(&self, expression: &str) -> Result<Expression, CalError> {
        self.compile_at(expression, &Place { file: "expression".into(), line: 1 })
    }

    /// As [`Context::compile`], for a formula that stands at a place of some file.
    ///
    /// # Errors
    /// As [`Context::compile`].
    pub fn compile_at(&self, expression: &str, place: &Place) -> Result<Expression, CalError> {
        let mut table = Table::clone(&self.table);
        let body = Arc::new(parse::expression(&mut table, expression, &self.setting(place))?);
        Ok(Expression::new(Compiler::new(&table, usize::MAX).link(&[body])))
    }

    /// Compiles the formula of output `$n`; `None` if there is no such output.
    pub fn output(&self, n: u32) -> Option<Expression> {
        let id = self.table.find(&parse::output_name(n), "")?;
        let body = self.table.entry(id).definition.as_ref()?.body.clone();
        Some(Expression::new(Compiler::new(&self.table, usize::MAX).link(&[body])))
    }

    /// Compiles formulas that are evaluated together.
    ///
    /// # Errors
    /// As [`Context::compile`].
    pub fn compile_all<'e>(
        &self,
        expressions: impl IntoIterator<Item = &'e str>,
        place: &Place,
    ) -> Result<Expressions, CalError> {
        let mut table = Table::clone(&self.table);
        let bodies: Result<Vec<_>, _> = expressions
            .into_iter()
            .map(|text| parse::expression(&mut table, text, &self.setting(place)).map(Arc::new))
            .collect();
        Ok(Expressions::new(Compiler::new(&table, usize::MAX).link(&bodies?)))
    }

    /// Compiles the function of this name, to be called with `n` numbers. It may have fewer parameters; one that needs
    /// more fails when it is called.
    ///
    /// # Errors
    /// If there is no such function.
    pub fn function(&self, name: &str, n: usize) -> Result<Function, CalError> {
        self.function_at(name, n, &Place { file: "function".into(), line: 1 })
    }

    /// As [`Context::function`], for a name that stands at a place of some file.
    ///
    /// # Errors
    /// As [`Context::function`].
    pub fn function_at(&self, name: &str, n: usize, place: &Place) -> Result<Function, CalError> {
        let mut table = Table::clone(&self.table);
        let id = table.link(name, &self.scope);
        let program = Compiler::new(&table, usize::MAX).link_function(id, n as u16, place);
        program.map(|program| Function::new(program, n)).ok_or_else(|| {
            let advice = "define it in the function file, or correct its name".into();
            CalError::new(place, CalProblem::Undefined { kind: "function", name: name.into(), advice })
        })
    }

    /// How many parameters the function of this name has; `None` if there is no such function. For a library function,
    /// how many arguments it needs at least.
    pub fn n_parameters(&self, name: &str) -> Option<usize> {
        let Some(id) = self.table.find(name, &self.scope) else {
            return super::builtin::Builtin::by_name(name).map(|builtin| builtin.n_needed());
        };
        let entry = self.table.entry(id);
        match entry.definition.as_deref().and_then(|definition| definition.n_parameters) {
            Some(n) => Some(n.into()),
            None => entry.builtin.map(|builtin| builtin.n_needed()),
        }
    }

    /// Whether a variable of this name is defined.
    pub fn is_variable(&self, name: &str) -> bool {
        let id = self.table.find(name, &self.scope);
        let definition = id.and_then(|id| self.table.entry(id).definition.as_deref());
        definition.is_some_and(|definition| definition.n_parameters.is_none())
    }

    fn setting<'s>(&'s self, place: &'s Place) -> Setting<'s> {
        Setting { scope: &self.scope, n_channels: self.n_channels, has_outputs: self.has_outputs, place }
    }
}
