//! The words after a program's name.

use crate::error::{DeviceError, Place};
use crate::rad::{quoted, real};

/// Words that are taken one by one.
pub(super) struct Arguments<'a> {
    program: &'a str,
    usage: &'a str,
    words: &'a [String],
    place: &'a Place,
}

impl<'a> Arguments<'a> {
    pub fn new(program: &'a str, usage: &'a str, words: &'a [String], place: &'a Place) -> Self {
        Arguments { program, usage, words, place }
    }

    /// The next word, if there is one.
    pub fn next(&mut self) -> Option<&'a str> {
        let (first, rest) = self.words.split_first()?;
        self.words = rest;
        Some(first)
    }

    /// The next word, without taking it.
    pub fn peek(&self) -> Option<&'a str> {
        self.words.first().map(String::as_str)
    }

    /// The next word, which stands for `what`.
    pub fn word(&mut self, what: &str) -> Result<&'a str, DeviceError> {
        self.next().ok_or_else(|| self.unexpected(what, None))
    }

    pub fn number(&mut self, what: &str) -> Result<f64, DeviceError> {
        let word = self.next();
        word.and_then(real).ok_or_else(|| self.unexpected(what, word))
    }

    /// A number that `is_right`.
    pub fn number_that(&mut self, what: &str, is_right: impl Fn(f64) -> bool) -> Result<f64, DeviceError> {
        let word = self.peek();
        match self.number(what)? {
            number if is_right(number) => Ok(number),
            _ => Err(self.unexpected(what, word)),
        }
    }

    /// A whole number, fractions cut off as in Radiance.
    pub fn count(&mut self, what: &str, least: u64) -> Result<u64, DeviceError> {
        self.number_that(what, |x| x >= least as f64).map(|x| x as u64)
    }

    /// What is wrong with a word, or that there is none.
    pub fn unexpected(&self, expected: &str, found: Option<&str>) -> DeviceError {
        DeviceError::Unexpected {
            at: self.place.clone(),
            expected: format!("{expected} for {}", self.program),
            found: found.map_or_else(|| "the end of the command".to_owned(), quoted),
            advice: format!("usage: {} {}", self.program, self.usage),
        }
    }

    /// An option that is not one.
    pub fn unknown(&self, option: &str) -> DeviceError {
        if option == "-o" {
            return DeviceError::Unsupported {
                at: self.place.clone(),
                what: format!("OBJ output of {}", self.program),
                advice: "leave out -o, or run it yourself and give the OBJ file as a device".to_owned(),
            };
        }
        self.unexpected("an option or nothing", Some(option))
    }
}
