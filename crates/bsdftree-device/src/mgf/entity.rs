//! One entity: its keyword, its arguments and what is wrong with them.
//!
//! In: the words of a line. Out: arguments as numbers and names, or an error with the line, what was found and what was
//! expected. Deviation from mgf2rad: a name may be any word that does not begin with `=` or `-`, since rad2mgf writes
//! names that begin with digits, which mgf2rad then refuses.

use std::ops::RangeBounds;

use crate::error::{DeviceError, Place};
use crate::rad::{quoted, real};

/// A line, in words.
pub(super) struct Entity<'a> {
    pub keyword: &'a str,
    pub arguments: &'a [&'a str],
    pub at: Place,
}

impl Entity<'_> {
    /// An error unless the number of arguments is in the range.
    pub(super) fn count(&self, range: impl RangeBounds<usize>, expected: &str) -> Result<(), DeviceError> {
        if range.contains(&self.arguments.len()) {
            return Ok(());
        }
        let found = match self.arguments.len() {
            1 => "1 argument".to_owned(),
            n => format!("{n} arguments"),
        };
        Err(self.unexpected(&format!("{expected} after '{}'", self.keyword), found, ""))
    }

    /// Argument `k` as a number.
    pub(super) fn number(&self, k: usize, what: &str) -> Result<f64, DeviceError> {
        self.number_within(k, .., what)
    }

    /// Argument `k` as a number in a range.
    pub(super) fn number_within(
        &self,
        k: usize,
        range: impl RangeBounds<f64>,
        what: &str,
    ) -> Result<f64, DeviceError> {
        let word = self.arguments.get(k).copied();
        word.and_then(real).filter(|x| range.contains(x)).ok_or_else(|| {
            let found = word.map_or_else(|| "the end of the line".to_owned(), quoted);
            self.unexpected(&format!("{what} as argument {} of '{}'", k + 1, self.keyword), found, "")
        })
    }

    /// Three numbers from argument 0 on.
    pub(super) fn triple(&self, what: &str) -> Result<[f64; 3], DeviceError> {
        self.count(3..=3, what)?;
        Ok([self.number(0, "a number")?, self.number(1, "a number")?, self.number(2, "a number")?])
    }

    /// Argument `k` as a name to be given.
    pub(super) fn name(&self, k: usize) -> Result<&str, DeviceError> {
        let word = self.arguments[k];
        if word.starts_with(['=', '-']) {
            return Err(self.unexpected(
                &format!("a name as argument {} of '{}'", k + 1, self.keyword),
                quoted(word),
                "names begin with a letter",
            ));
        }
        Ok(word)
    }

    pub(super) fn unexpected(&self, expected: &str, found: String, advice: &str) -> DeviceError {
        unexpected(&self.at, expected, found, advice)
    }
}

pub(super) fn unexpected(at: &Place, expected: &str, found: String, advice: &str) -> DeviceError {
    DeviceError::Unexpected {
        at: at.clone(),
        expected: expected.to_owned(),
        found,
        advice: advice.to_owned(),
    }
}
