//! Arguments of function and data modifiers to [`Field`]s.
//!
//! In: a primitive and where it stands. Out: a field in the device's coordinates, or the [`Problem`] a surface using it runs
//! into. String arguments are, in this order: functions or formulas, data files or a picture, the function file, coordinates, and a
//! transformation that moves the functions' coordinates to the scene's; words before that which nothing asks for are
//! left out with a notice, as in Radiance. Source: Radiance's reference manual; where each type has which argument is said there.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use super::library::{Functions, Library, Standing};
use super::problem::Problem;
use super::statement::Primitive;
use super::transform::{self, Transform};
use crate::cal::CalError;
use crate::error::DeviceError;
use crate::field::{Call, DataArray, Field, File, Formulas, LobeFunction, Origin, Source, Space};

/// Reads the arguments of one primitive.
pub(super) struct FieldReader<'a> {
    pub p: &'a Primitive,
    pub standing: &'a Standing<'a>,
    /// From the scene's coordinates to the device's \[m\].
    pub to: &'a Transform,
    /// The scene's unit \[m\].
    pub unit: f64,
    pub library: &'a mut Library,
    /// What would stop a ray that needs it.
    pub doubts: &'a RefCell<Vec<String>>,
}

/// How many functions, data files (or a picture) and which file a type of modifier names, after `skipped` other arguments.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    pub skipped: usize,
    pub n_functions: usize,
    pub n_data: usize,
    pub picture: bool,
    /// What the arguments are, for messages.
    pub expected: &'static str,
}

impl Layout {
    /// Number of the argument that names the function file.
    pub(super) fn file(&self) -> usize {
        self.skipped + self.n_functions + self.n_data
    }

    /// An error if there are fewer string arguments than the type needs.
    pub(super) fn check(&self, p: &Primitive, standing: &Standing) -> Result<(), DeviceError> {
        let n_coordinates = if self.picture { 2 } else { usize::from(self.n_data > 0) };
        if p.strings.len() > self.file() + n_coordinates {
            return Ok(());
        }
        Err(DeviceError::Unexpected {
            at: standing.at.clone(),
            expected: format!("string arguments {} of {} \"{}\"", self.expected, p.kind, p.name),
            found: p.strings.len().to_string(),
            advice: String::new(),
        })
    }
}

impl FieldReader<'_> {
    /// A field of `N` numbers, and what the user should know.
    pub(super) fn field<const N: usize>(
        &mut self,
        layout: Layout,
    ) -> Result<(Field<N>, Option<String>), Rc<Problem>> {
        let functions = self.functions(layout)?;
        let names = &self.p.strings[layout.skipped..];
        let (source, used) = if layout.picture {
            let picture = self.library.picture(&names[layout.n_functions], self.standing)?;
            let coordinates = self.formulas(&functions, layout.file() + 1, 2)?;
            let calls = self.calls(&functions, &names[..N], 3)?;
            (Source::Picture { functions: calls, picture, coordinates }, layout.file() + 3)
        } else if layout.n_data > 0 {
            let data = self.data::<N>(&names[layout.n_functions..][..N])?;
            let n = data[0].dimensions().len();
            let coordinates = self.formulas(&functions, layout.file() + 1, n)?;
            let calls = self.calls(&functions, &names[..N], N)?;
            (Source::Data { functions: calls, data, coordinates }, layout.file() + 1 + n)
        } else {
            (Source::Formulas(self.formulas(&functions, layout.skipped, N)?), layout.file() + 1)
        };
        let (space, notice) = self.space(&functions, used)?;
        Ok((Field { space, source }, notice))
    }

    /// The directional function of `plasfunc` and the like.
    pub(super) fn lobe(&mut self, layout: Layout) -> Result<(LobeFunction, Option<String>), Rc<Problem>> {
        let functions = self.functions(layout)?;
        let strings = &self.p.strings;
        let mut used = layout.file() + 1;
        let data = match layout.n_data {
            0 => None,
            _ => {
                let array = self.library.data(&strings[1], self.standing)?;
                let n = array.dimensions().len();
                let names = strings.get(used..used + n).ok_or_else(|| self.too_few_coordinates(n))?;
                used += n;
                let calls = names.iter().map(|name| self.call(&functions, name, 4));
                Some((array, calls.collect::<Result<Vec<_>, _>>()?))
            }
        };
        let function = self.call(&functions, &strings[0], if data.is_some() { 5 } else { 4 })?;
        let (space, notice) = self.space(&functions, used)?;
        Ok((LobeFunction { space, function, data }, notice))
    }

    /// The definitions of the function file.
    pub(super) fn functions(&mut self, layout: Layout) -> Result<Rc<Functions>, Rc<Problem>> {
        self.library.functions(&self.p.strings[layout.file()], self.standing)
    }

    /// `n` formulas from string argument `first` on.
    pub(super) fn formulas(
        &self,
        functions: &Functions,
        first: usize,
        n: usize,
    ) -> Result<Formulas, Rc<Problem>> {
        let words = self.p.strings.get(first..first + n).ok_or_else(|| self.too_few_coordinates(n))?;
        let expressions = functions.context.compile_all(words.iter().map(String::as_str), self.standing.at);
        let expressions = expressions.map_err(|e| self.failed(e.to_string()))?;
        self.doubt(expressions.problems());
        Ok(Formulas { texts: words.iter().map(|word| Arc::from(&**word)).collect(), expressions })
    }

    /// A function that is called with `n` numbers.
    pub(super) fn call(&self, functions: &Functions, name: &str, n: usize) -> Result<Call, Rc<Problem>> {
        let function = functions.context.function_at(name, n, self.standing.at);
        let function =
            function.map_err(|e| self.failed(format!("{e} (function file '{}')", functions.file.path)))?;
        self.doubt(function.problems());
        Ok(Call { name: name.into(), function, takes_all: true })
    }

    /// Functions that are called with all `n` numbers of a place; of those of colours, one with fewer parameters is called with
    /// its own number.
    fn calls<const N: usize>(
        &self,
        functions: &Functions,
        names: &[String],
        n: usize,
    ) -> Result<[Call; N], Rc<Problem>> {
        let call = |name: &String| {
            let n_parameters = functions.context.n_parameters(name).unwrap_or(n);
            let takes_all = N == 1 || self.p.kind == "texdata" || n_parameters >= n;
            let call = self.call(functions, name, if takes_all { n } else { 1 })?;
            Ok(Call { takes_all, ..call })
        };
        let calls = names.iter().map(call).collect::<Result<Vec<_>, Rc<Problem>>>()?;
        Ok(calls.try_into().expect("N names"))
    }

    fn data<const N: usize>(&mut self, names: &[String]) -> Result<[Arc<DataArray>; N], Rc<Problem>> {
        let data = names.iter().map(|name| self.library.data(name, self.standing));
        let data = data.collect::<Result<Vec<_>, _>>()?;
        let n = data[0].dimensions().len();
        if let Some(other) = data.iter().position(|d| d.dimensions().len() != n) {
            let expected = format!("data files of the same number of dimensions for {}", self.name());
            let found =
                format!("{n} in '{}' and {} in '{}'", names[0], data[other].dimensions().len(), names[other]);
            return Err(Rc::new(Problem::value(self.standing.at, expected, found)));
        }
        Ok(data.try_into().expect("N names"))
    }

    /// Coordinates of the functions, after the transformation among the string arguments from `used` on.
    pub(super) fn space(
        &self,
        functions: &Functions,
        used: usize,
    ) -> Result<(Arc<Space>, Option<String>), Rc<Problem>> {
        let rest = self.p.strings.get(used..).unwrap_or_default();
        let n_extra = rest.iter().take_while(|word| !word.starts_with('-')).count();
        let own = transform::single(&rest[n_extra..]).map_err(|wrong| {
            let expected = format!("{} in {}", wrong.expected, self.name());
            Rc::new(Problem::value(self.standing.at, expected, wrong.found))
        })?;
        let space = self.space_of(functions.file.clone(), &own)?;
        let notice = (n_extra > 0).then(|| {
            let words = rest[..n_extra].join(" ");
            format!("string arguments that nothing asks for are left out: {}", super::quoted(&words))
        });
        Ok((space, notice))
    }

    /// Coordinates that a transformation moves to the scene's, for what is in a file.
    pub(super) fn space_of(&self, file: File, own: &Transform) -> Result<Arc<Space>, Rc<Problem>> {
        let total = own.then(self.to);
        if !total.is_finite() {
            let expected = format!("a transformation within the range of numbers in {}", self.name());
            return Err(Rc::new(Problem::value(self.standing.at, expected, "an overflow")));
        }
        let arguments = self.p.reals.clone().into();
        let space = Space::new(self.origin(), file, arguments, total.affine(), total.scale, self.unit);
        Ok(Arc::new(space))
    }

    fn doubt(&self, problems: &[CalError]) {
        let mut doubts = self.doubts.borrow_mut();
        for problem in problems {
            let doubt = format!("generation will fail if a ray needs this: {problem}");
            if !doubts.contains(&doubt) {
                doubts.push(doubt);
            }
        }
    }

    fn origin(&self) -> Origin {
        let Primitive { kind, name, .. } = self.p;
        Origin { kind: (&**kind).into(), name: (&**name).into(), at: self.standing.at.clone() }
    }

    fn too_few_coordinates(&self, n: usize) -> Rc<Problem> {
        let expected = format!("{n} coordinates after the function file of {}", self.name());
        Rc::new(Problem::value(self.standing.at, expected, "fewer string arguments"))
    }

    pub(super) fn failed(&self, reason: String) -> Rc<Problem> {
        Rc::new(Problem::failed(self.standing.at, format!("{}: {reason}", self.name())))
    }

    pub(super) fn name(&self) -> String {
        format!("{} \"{}\"", self.p.kind, self.p.name)
    }
}
