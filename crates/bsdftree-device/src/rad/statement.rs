//! Statements of a Radiance scene text: primitives, aliases and commands.
//!
//! In: text. Out: [`Statement`]s in order, with their lines. Counts are checked against what is there, so a false
//! count costs no memory. Types are checked by name only; what their arguments mean is for `shape` and `definition`.
//! Source: Radiance reference manual, "Scene Description".

use std::sync::Arc;

use super::types::{self, Class};
use super::words::{Lead, Word, Words};
use crate::error::{DeviceError, Place};

/// One statement and the line it begins on.
#[derive(Clone)]
pub(crate) struct Statement {
    pub line: u32,
    pub content: Content,
}

/// The three kinds of statement.
#[derive(Clone)]
pub(crate) enum Content {
    Primitive(Primitive),
    /// `modifier alias name reference`.
    Alias {
        modifier: String,
        name: String,
        reference: String,
    },
    /// The line after `!`.
    Command(String),
}

/// `modifier type name`, and its string and real arguments.
#[derive(Clone)]
pub(crate) struct Primitive {
    pub modifier: String,
    pub kind: String,
    pub class: Class,
    pub name: String,
    pub strings: Vec<String>,
    pub reals: Vec<f64>,
}

impl Primitive {
    /// `None` if Radiance has no such type.
    pub(crate) fn of(
        modifier: String,
        kind: String,
        name: String,
        strings: Vec<String>,
        reals: Vec<f64>,
    ) -> Option<Primitive> {
        let class = Class::of(&kind)?;
        Some(Primitive { modifier, kind, class, name, strings, reals })
    }
}

impl Statement {
    /// A primitive that stands in no file; its type must be one of Radiance's.
    pub(crate) fn made(
        line: u32,
        modifier: &str,
        kind: &str,
        name: String,
        strings: &[&str],
        reals: Vec<f64>,
    ) -> Statement {
        let strings = strings.iter().map(|&word| word.to_owned()).collect();
        let primitive = Primitive::of(modifier.to_owned(), kind.to_owned(), name, strings, reals);
        Statement { line, content: Content::Primitive(primitive.expect("a type of Radiance")) }
    }
}

impl Statement {
    /// Memory it takes, about.
    pub(super) fn bytes(&self) -> u64 {
        let own = size_of::<Statement>() as u64;
        own + match &self.content {
            Content::Primitive(p) => 8 * p.reals.len() as u64 + 64 * p.strings.len() as u64 + 64,
            Content::Alias { .. } => 64,
            Content::Command(command) => command.len() as u64,
        }
    }
}

/// Reads all statements of a text.
pub(crate) fn parse(text: &str, file: &Arc<str>) -> Result<Vec<Statement>, DeviceError> {
    let mut reader = Reader { words: Words::new(text), file };
    let mut statements = Vec::new();
    loop {
        let (line, content) = match reader.words.lead() {
            Lead::End => return Ok(statements),
            Lead::Command(command, line) => (line, Content::Command(command)),
            Lead::Word(modifier) => (modifier.line, reader.primitive_or_alias(modifier)?),
        };
        statements.push(Statement { line, content });
    }
}

struct Reader<'a> {
    words: Words<'a>,
    file: &'a Arc<str>,
}

impl<'a> Reader<'a> {
    fn primitive_or_alias(&mut self, modifier: Word<'a>) -> Result<Content, DeviceError> {
        let modifier = modifier.text.to_owned();
        let kind = self.word("a type after the modifier")?;
        if kind.text == "alias" {
            let name = self.word("the new name after 'alias'")?.text.to_owned();
            let reference = self.word("the name that the alias stands for")?.text.to_owned();
            return Ok(Content::Alias { modifier, name, reference });
        }
        let Some(class) = Class::of(kind.text) else {
            return Err(self.unexpected(
                kind.line,
                "a Radiance type after the modifier",
                quoted(kind.text),
                types::advice(kind.text),
            ));
        };
        let kind = kind.text.to_owned();
        let name = self.word("a name after the type")?.text.to_owned();
        let of = format!("{kind} \"{name}\"");
        let strings = self.arguments(&of, "string", |text| Some(text.to_owned()))?;
        self.arguments(&of, "integer", |_| None::<()>)?;
        let reals = self.arguments(&of, "real", real)?;
        Ok(Content::Primitive(Primitive { modifier, kind, class, name, strings, reals }))
    }

    /// A count and that many arguments.
    fn arguments<T>(
        &mut self,
        of: &str,
        kind: &str,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<Vec<T>, DeviceError> {
        let word = self.word(&format!("the number of {kind} arguments of {of}"))?;
        let Ok(count) = word.text.parse::<u64>() else {
            let expected = format!("the number of {kind} arguments of {of}");
            return Err(self.unexpected(word.line, &expected, quoted(word.text), ADVICE));
        };
        // Each argument takes two bytes at least.
        let mut arguments = Vec::with_capacity((count as usize).min(self.words.bytes_left() / 2));
        for n in 1..=count {
            let expected = format_args!("{kind} argument {n} of {count} of {of}");
            let Some(word) = self.words.word() else {
                return Err(self.end(&expected.to_string()));
            };
            let Some(argument) = parse(word.text) else {
                return Err(self.unexpected(word.line, &expected.to_string(), quoted(word.text), ADVICE));
            };
            arguments.push(argument);
        }
        Ok(arguments)
    }

    fn word(&mut self, expected: &str) -> Result<Word<'a>, DeviceError> {
        self.words.word().ok_or_else(|| self.end(expected))
    }

    fn end(&self, expected: &str) -> DeviceError {
        self.unexpected(
            self.words.line(),
            expected,
            "the end of the file".to_owned(),
            "the file is cut short",
        )
    }

    fn unexpected(&self, line: u32, expected: &str, found: String, advice: &str) -> DeviceError {
        DeviceError::Unexpected {
            at: Place { file: self.file.clone(), line },
            expected: expected.to_owned(),
            found,
            advice: advice.to_owned(),
        }
    }
}

const ADVICE: &str = "check the argument counts (strings, integers: always 0, reals); \
                      comments cannot stand inside a primitive";

/// A finite decimal number; names such as `inf` are not numbers in Radiance.
pub(crate) fn real(text: &str) -> Option<f64> {
    let plain = text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E'));
    if plain { text.parse().ok().filter(|x: &f64| x.is_finite()) } else { None }
}

/// A word in quotes, shortened for messages.
pub(crate) fn quoted(text: &str) -> String {
    const LONGEST: usize = 60;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("'{}…'", &text[..end]),
        None => format!("'{text}'"),
    }
}
