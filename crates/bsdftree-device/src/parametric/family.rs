//! What a family of parametric devices is, and how a text such as `blinds:depth=0.05,angle=30` chooses one of it.
//!
//! In: text. Out: [`Values`] with every parameter of the family within its range.

use std::collections::HashMap;

use crate::device::Device;

/// A family of devices that differ by their parameters.
#[derive(Debug)]
pub struct Family {
    /// What the text begins with.
    pub name: &'static str,
    /// One line on what it is.
    pub summary: &'static str,
    /// How the parameters lie in it, in ASCII.
    pub drawing: &'static str,
    /// Its parameters, in the order for help.
    pub parameters: &'static [Parameter],
    /// Makes the device, or says why these values do not fit together.
    pub(super) build: fn(&Values) -> Result<Device, String>,
}

/// A parameter of a family.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// What stands before `=`.
    pub name: &'static str,
    /// `m`, `deg`, `1/m`, or empty for a plain number or a word.
    pub unit: &'static str,
    /// Default and range.
    pub domain: Domain,
    /// One line on what it means.
    pub meaning: &'static str,
}

/// The values that a parameter may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Domain {
    /// A number between limits, which are allowed themselves.
    Number {
        /// If it is not given.
        default: f64,
        /// Least value.
        least: f64,
        /// Greatest value.
        most: f64,
    },
    /// One of some words; the first is the default.
    Word(&'static [&'static str]),
}

impl Domain {
    /// A length from 1 µm to 100 m.
    pub(super) const fn length(default: f64) -> Domain {
        Domain::Number { default, least: 1e-6, most: 100.0 }
    }

    /// A length from 0 to 100 m.
    pub(super) const fn length_or_zero(default: f64) -> Domain {
        Domain::Number { default, least: 0.0, most: 100.0 }
    }

    /// A fraction from 0 to 1.
    pub(super) const fn fraction(default: f64) -> Domain {
        Domain::Number { default, least: 0.0, most: 1.0 }
    }
}

impl Parameter {
    /// The default as text.
    pub fn default_text(&self) -> String {
        match self.domain {
            Domain::Number { default, .. } => default.to_string(),
            Domain::Word(words) => words[0].to_owned(),
        }
    }

    /// The range as text, for help and messages.
    pub fn range_text(&self) -> String {
        match self.domain {
            Domain::Number { least, most, .. } => format!("{least} to {most}"),
            Domain::Word(words) => words.join(" or "),
        }
    }

    fn parse(&self, text: &str) -> Result<Value, String> {
        let wrong = || {
            let unit = if self.unit.is_empty() { String::new() } else { format!(" [{}]", self.unit) };
            format!("{} must be {}{unit}, not '{text}'", self.name, self.range_text())
        };
        match self.domain {
            Domain::Number { least, most, .. } => {
                let number = text.parse::<f64>().ok().filter(|x| (least..=most).contains(x));
                number.map(Value::Number).ok_or_else(wrong)
            }
            Domain::Word(words) => {
                words.iter().find(|&&word| word == text).map(|word| Value::Word(word)).ok_or_else(wrong)
            }
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Value {
    Number(f64),
    Word(&'static str),
}

/// A value for each parameter of a family.
#[derive(Debug)]
pub(super) struct Values(HashMap<&'static str, Value>);

impl Values {
    /// Reads `name=value,name=value`; what is not given has its default.
    pub(super) fn parse(parameters: &'static [Parameter], text: &str) -> Result<Self, String> {
        let defaults = parameters.iter().map(|p| match p.domain {
            Domain::Number { default, .. } => (p.name, Value::Number(default)),
            Domain::Word(words) => (p.name, Value::Word(words[0])),
        });
        let mut values: HashMap<&'static str, Value> = defaults.collect();
        let mut given: Vec<&str> = Vec::new();
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let Some((name, value)) = part.split_once('=') else {
                return Err(format!("'{part}' is not of the form parameter=value"));
            };
            let name = name.trim();
            let Some(parameter) = parameters.iter().find(|p| p.name == name) else {
                let names: Vec<&str> = parameters.iter().map(|p| p.name).collect();
                return Err(format!("it has no parameter '{name}'; its parameters are {}", names.join(", ")));
            };
            if given.contains(&name) {
                return Err(format!("{name} is given twice"));
            }
            given.push(name);
            values.insert(parameter.name, parameter.parse(value.trim())?);
        }
        Ok(Values(values))
    }

    /// The value of a parameter that is a number.
    pub(super) fn number(&self, name: &str) -> f64 {
        match self.0.get(name) {
            Some(&Value::Number(number)) => number,
            _ => unreachable!("{name} is declared as a number by its family"),
        }
    }

    /// The value of a parameter that is a word.
    pub(super) fn word(&self, name: &str) -> &'static str {
        match self.0.get(name) {
            Some(&Value::Word(word)) => word,
            _ => unreachable!("{name} is declared as a word by its family"),
        }
    }

    /// How many times `period` fits into `length`, at least once.
    pub(super) fn n_fit(&self, length: &str, period: &str) -> Result<usize, String> {
        // Enough for any device, and quick to build.
        const MOST: f64 = 100_000.0;
        let n = (self.number(length) / self.number(period) + 1e-9).floor();
        if n < 1.0 {
            return Err(format!("{length} must be at least {period}"));
        }
        if n > MOST {
            return Err(format!("{length} holds {n} times {period}; at most {MOST} are allowed"));
        }
        Ok(n as usize)
    }
}
