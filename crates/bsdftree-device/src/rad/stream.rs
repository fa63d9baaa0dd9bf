//! What the programs of a pipe print, as statements.
//!
//! In: programs that end with one that makes statements by itself (a generator, `echo`, `replmarks`, an allowed
//! program). Out: their sources, in order.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::files::{self, Files, Source};
use super::process::{self, Allowance};
use super::statement::{Statement, quoted};
use crate::error::{DeviceError, Place};
use crate::generators::{self, Environment, Marks};
use crate::options::ReadOptions;

/// What tells programs and where they run from all others.
pub(super) fn key(programs: &[Vec<String>], directory: &Path) -> PathBuf {
    let programs: Vec<String> = programs.iter().map(|words| words.join(" ")).collect();
    directory.join(format!("!{}", programs.join(" | ")))
}

/// Most memory of a statement that a generator makes, for the limit on how many it makes \[byte\].
const STATEMENT: u64 = 512;

/// Where programs are run.
pub(super) struct Maker<'a> {
    pub options: &'a ReadOptions,
    pub files: &'a mut Files,
    pub directory: &'a Path,
    pub at: &'a Place,
}

impl Maker<'_> {
    /// What the last of these programs makes of what the others make.
    pub(super) fn sources(&mut self, programs: &[Vec<String>]) -> Result<Vec<Rc<Source>>, DeviceError> {
        let Some((last, inner)) = programs.split_last() else { return Ok(Vec::new()) };
        let name = last.first().map_or("", String::as_str);
        match name {
            "xform" => Err(self.unsupported(
                "what xform makes as the input of another program",
                "put xform after it, or xform the file that it reads",
            )),
            "cat" => self.open(&last[1..]),
            "echo" => {
                let text = last[1..].join(" ");
                Ok(vec![Rc::new(Source::of(&text, &self.name(last), self.directory.to_owned())?)])
            }
            "replmarks" => self.replace_marks(&last[1..], inner),
            _ if generators::is_known(name) => {
                let statements = self.with_environment(|environment| generators::run(last, environment))?;
                Ok(vec![self.source(&self.at.file, statements)])
            }
            _ => {
                let output = self.output(programs)?;
                let text = String::from_utf8(output)
                    .unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into());
                Ok(vec![Rc::new(Source::of(&text, &self.name(last), self.directory.to_owned())?)])
            }
        }
    }

    fn open(&mut self, names: &[String]) -> Result<Vec<Rc<Source>>, DeviceError> {
        let mut sources = Vec::new();
        for name in names {
            let path = self.files.find(name, self.directory, self.at)?;
            sources.push(self.files.open(&path, Some(self.at))?.1);
        }
        Ok(sources)
    }

    fn replace_marks(
        &mut self,
        words: &[String],
        inner: &[Vec<String>],
    ) -> Result<Vec<Rc<Source>>, DeviceError> {
        let marks = self.with_environment(|environment| Marks::parse(words, environment))?;
        let sources = match (marks.files.is_empty(), inner.is_empty()) {
            (false, true) => self.open(&marks.files)?,
            (true, false) => self.sources(inner)?,
            (true, true) => return Err(self.unexpected("a file for replmarks to read", "none")),
            (false, false) => {
                return Err(self.unexpected("no file after '| replmarks'", &quoted(&marks.files[0])));
            }
        };
        let mut replaced = Vec::new();
        for source in sources {
            let statements =
                self.with_environment(|environment| marks.apply(&source.statements, environment))?;
            replaced.push(self.source(&source.name, statements));
        }
        Ok(replaced)
    }

    /// What an allowed program prints.
    fn output(&mut self, programs: &[Vec<String>]) -> Result<Vec<u8>, DeviceError> {
        let Some((last, inner)) = programs.split_last() else { return Ok(Vec::new()) };
        let is_allowed = |words: &Vec<String>| self.options.allowed_commands.contains(&words[0]);
        if !inner.iter().all(is_allowed) {
            return Err(self.unsupported(
                "what is not made by a program as the input of an allowed program",
                "let that program read a file",
            ));
        }
        let input = if inner.is_empty() { None } else { Some(self.output(inner)?) };
        let limits = &self.options.limits;
        let allowance = Allowance { time: limits.command_time, bytes: limits.bytes.min(files::LARGEST) };
        process::run(last, self.directory, input, &allowance).map_err(|reason| DeviceError::Program {
            at: self.at.clone(),
            command: last.join(" "),
            reason,
        })
    }

    fn with_environment<T>(
        &self,
        run: impl FnOnce(&Environment) -> Result<T, DeviceError>,
    ) -> Result<T, DeviceError> {
        let find = |name: &str| self.files.find(name, self.directory, self.at);
        let limits = &self.options.limits;
        run(&Environment {
            at: self.at,
            read: &|name| files::read(&find(name)?, Some(self.at)),
            is_file: &|name| find(name).is_ok(),
            limit: limits.surfaces.min(limits.bytes / STATEMENT),
            most_steps: limits.operations,
        })
    }

    fn source(&self, name: &std::sync::Arc<str>, statements: Vec<Statement>) -> Rc<Source> {
        Rc::new(Source { name: name.clone(), directory: self.directory.to_owned(), statements })
    }

    /// The name of what a program prints, for messages.
    fn name(&self, words: &[String]) -> String {
        format!("{}: output of {}", self.at, quoted(&words.join(" ")))
    }

    fn unsupported(&self, what: &str, advice: &str) -> DeviceError {
        let (what, advice) = (what.to_owned(), advice.to_owned());
        DeviceError::Unsupported { at: self.at.clone(), what, advice }
    }

    fn unexpected(&self, expected: &str, found: &str) -> DeviceError {
        let (expected, found) = (expected.to_owned(), found.to_owned());
        DeviceError::Unexpected { at: self.at.clone(), expected, found, advice: String::new() }
    }
}
