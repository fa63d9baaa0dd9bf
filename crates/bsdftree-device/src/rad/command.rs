//! Commands of a scene file (`!xform …`), which are understood and never given to a shell.
//!
//! In: the line after `!`. Out: the programs of its pipe, each a list of words. Understood are `xform`, `cat` of files, `echo`,
//! `replmarks` and the generators (`genbox …`), also in a pipe (`genbox a b 1 1 1 | xform -rz 90`); any other program must have
//! been allowed. `-f` of `xform` puts each line of a file in its place.

use std::path::Path;

use super::files::{self, Files};
use super::statement::quoted;
use super::words;
use super::xform::Xform;
use crate::error::{DeviceError, Place};
use crate::generators;

/// Longest pipe, and deepest nesting of argument files.
const DEEPEST: usize = 32;

/// Most lines that argument files may expand to in one command.
const MOST_LINES: usize = 1_000_000;

/// Programs of a pipe: the first makes the scene, each further one transforms it.
pub(super) fn pipe(command: &str, allowed: &[String], at: &Place) -> Result<Vec<Vec<String>>, DeviceError> {
    let unsupported = |what: String, advice: &str| DeviceError::Unsupported {
        at: at.clone(),
        what,
        advice: advice.to_owned(),
    };
    let mut programs = vec![Vec::new()];
    for token in tokens(command) {
        match token {
            Ok(word) => programs.last_mut().expect("begins with one program").push(word),
            Err('|') => programs.push(Vec::new()),
            Err(sign) => {
                let what = format!("'{sign}' in the command '!{}'", shortened(command));
                return Err(unsupported(what, "no shell is run: write plain words or quote the sign"));
            }
        }
    }
    if programs.len() > DEEPEST {
        return Err(unsupported(format!("a pipe of {} programs", programs.len()), "make it shorter"));
    }
    for (k, program) in programs.iter().enumerate() {
        match program.first().map(String::as_str) {
            Some("xform" | "replmarks") => {}
            Some(name) if k == 0 && (matches!(name, "cat" | "echo") || generators::is_known(name)) => {}
            Some(name) if allowed.iter().any(|known| known == name) => {}
            Some(name) => {
                let what = format!("command {}", quoted(name));
                let advice = if k > 0 {
                    "after '|' there can be xform, replmarks and allowed programs only".to_owned()
                } else {
                    let known: Vec<&str> = generators::names().collect();
                    format!(
                        "no program but xform, cat, echo, replmarks, {} is understood; allow this one by its name \
                         (--allow-command {name}) if you trust the file, or put what it prints into a file and name that",
                        known.join(", ")
                    )
                };
                return Err(unsupported(what, &advice));
            }
            None => {
                return Err(DeviceError::Unexpected {
                    at: at.clone(),
                    expected: "a command after '!' and '|'".to_owned(),
                    found: "nothing".to_owned(),
                    advice: String::new(),
                });
            }
        }
    }
    Ok(programs)
}

/// A word as it stands in a command.
pub(crate) fn command_word(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-+.,:=@%_/~^".contains(c);
    match () {
        () if !word.is_empty() && word.chars().all(is_plain) => word.to_owned(),
        () if !word.contains('"') => format!("\"{word}\""),
        () => format!("'{}'", word.replace('\'', "_")),
    }
}

/// Words of a command line, quotes removed, or the shell's signs that stand outside quotes.
fn tokens(command: &str) -> Vec<Result<String, char>> {
    let mut tokens = Vec::new();
    let mut word: Option<String> = None;
    let mut quote: Option<char> = None;
    for c in command.chars() {
        match (quote, c) {
            (Some(open), _) if c == open => quote = None,
            (Some(_), _) => word.get_or_insert_default().push(c),
            (None, '"' | '\'') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, _) if c.is_ascii_whitespace() => tokens.extend(word.take().map(Ok)),
            (None, '|' | ';' | '&' | '<' | '>' | '`' | '$' | '(' | ')' | '*' | '?' | '[' | '\\') => {
                tokens.extend(word.take().map(Ok));
                tokens.push(Err(c));
            }
            (None, _) => word.get_or_insert_default().push(c),
        }
    }
    tokens.extend(word.map(Ok));
    tokens
}

fn shortened(command: &str) -> String {
    command.chars().take(60).collect::<String>().trim().to_owned()
}

/// What a program of a pipe does: one `xform`, or one for each line of its argument files.
pub(super) fn understand(
    program: &[String],
    directory: &Path,
    files: &Files,
    at: &Place,
) -> Result<Vec<Xform>, DeviceError> {
    let words = program.get(1..).unwrap_or_default();
    if program.first().is_some_and(|name| name == "cat") {
        return Ok(vec![Xform::cat(words)]);
    }
    let mut commands = Vec::new();
    Expansion { directory, files, at, n_lines: 0, commands: &mut commands }.expand(words, &[])?;
    Ok(commands)
}

/// Puts the lines of argument files in the place of `-f file`, one command for each.
struct Expansion<'a> {
    directory: &'a Path,
    files: &'a Files,
    at: &'a Place,
    n_lines: usize,
    commands: &'a mut Vec<Xform>,
}

impl Expansion<'_> {
    fn expand(&mut self, words: &[String], lines: &[u64]) -> Result<(), DeviceError> {
        let Some(k) = words.iter().position(|word| word == "-f") else {
            let xform = Xform::parse(words, lines).map_err(|wrong| DeviceError::Unexpected {
                at: self.at.clone(),
                expected: wrong.expected,
                found: wrong.found,
                advice: "correct the xform command".to_owned(),
            })?;
            self.commands.push(xform);
            return Ok(());
        };
        if lines.len() >= DEEPEST {
            return Err(self.too_many("argument files inside each other", DEEPEST));
        }
        let name = words.get(k + 1).ok_or_else(|| DeviceError::Unexpected {
            at: self.at.clone(),
            expected: "a file name after -f".to_owned(),
            found: "the end of the command".to_owned(),
            advice: String::new(),
        })?;
        let path = self.files.find(name, self.directory, self.at)?;
        let text = files::read(&path, Some(self.at))?;
        let argument_lines = text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
        for (number, line) in argument_lines.enumerate() {
            self.n_lines += 1;
            if self.n_lines > MOST_LINES {
                return Err(self.too_many("lines of argument files", MOST_LINES));
            }
            let inserted = words::split(line);
            let skip = inserted.first().is_some_and(|word| word == "xform" || word == "!xform") as usize;
            let expanded = [&words[..k], &inserted[skip..], &words[k + 2..]].concat();
            self.expand(&expanded, &[lines, &[number as u64]].concat())?;
        }
        Ok(())
    }

    fn too_many(&self, what: &'static str, limit: usize) -> DeviceError {
        DeviceError::TooLarge { at: self.at.clone(), what, limit: limit as u64 }
    }
}
