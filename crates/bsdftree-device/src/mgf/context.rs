//! Named contexts: colours, materials and vertices each have a current one, which entities change.
//!
//! In: `c`, `m` or `v` with no name (a new unnamed one), a name (that one again), `name =` (a new one), `name = template`
//! (a copy). Out: the current one, and any by name. `name = name` is that one again, as in MGF's parser.

use std::collections::HashMap;

use super::entity::Entity;
use crate::error::{DeviceError, Place};
use crate::rad::quoted;

/// Contexts of one kind.
pub(super) struct Contexts<T> {
    kind: &'static str,
    slots: HashMap<Box<str>, usize>,
    /// The unnamed one, then the named ones.
    values: Vec<T>,
    current: usize,
    /// Of the current one.
    name: Option<Box<str>>,
}

impl<T: Clone + Default> Contexts<T> {
    pub(super) fn new(kind: &'static str) -> Self {
        let values = vec![T::default()];
        Contexts { kind, slots: HashMap::new(), values, current: 0, name: None }
    }

    /// What an entity `c`, `m` or `v` does. Whether the current context is a new one.
    pub(super) fn enter(&mut self, entity: &Entity<'_>) -> Result<bool, DeviceError> {
        entity.count(0..=3, "nothing, a name, 'name =' or 'name = template'")?;
        if entity.arguments.is_empty() {
            (self.current, self.name) = (0, None);
            self.values[0] = T::default();
            return Ok(true);
        }
        let name = entity.name(0)?;
        if let Some(&word) = entity.arguments.get(1).filter(|&&word| word != "=") {
            return Err(entity.unexpected("'=' after the name", quoted(word), ""));
        }
        let template = entity.arguments.get(2).copied();
        let again = entity.arguments.len() == 1 || template == Some(name);
        if again {
            self.current = self.slot(name, &entity.at)?;
        } else {
            let value = match template {
                Some(template) => self.values[self.slot(template, &entity.at)?].clone(),
                None => T::default(),
            };
            self.current = *self.slots.entry(name.into()).or_insert(self.values.len());
            if self.current == self.values.len() {
                self.values.push(value);
            } else {
                self.values[self.current] = value;
            }
        }
        self.name = Some(name.into());
        Ok(!again)
    }

    pub(super) fn current(&self) -> &T {
        &self.values[self.current]
    }

    pub(super) fn current_mut(&mut self) -> &mut T {
        &mut self.values[self.current]
    }

    /// The name of the current one, `None` for the unnamed.
    pub(super) fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// The one of a name.
    pub(super) fn get(&self, name: &str, at: &Place) -> Result<&T, DeviceError> {
        Ok(&self.values[self.slot(name, at)?])
    }

    fn slot(&self, name: &str, at: &Place) -> Result<usize, DeviceError> {
        let (kind, at) = (self.kind, at.clone());
        self.slots.get(name).copied().ok_or_else(|| DeviceError::Undefined {
            at,
            kind,
            name: name.to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn enter(contexts: &mut Contexts<u32>, words: &[&str]) -> Result<bool, String> {
        let at = Place { file: "t".into(), line: 1 };
        contexts.enter(&Entity { keyword: "c", arguments: words, at }).map_err(|e| e.to_string())
    }

    #[test]
    fn templates_are_copied_and_names_come_back() {
        let mut contexts = Contexts::new("colour");
        assert_eq!(enter(&mut contexts, &["a", "="]), Ok(true));
        *contexts.current_mut() = 1;
        assert_eq!(enter(&mut contexts, &["b", "=", "a"]), Ok(true));
        *contexts.current_mut() += 1;
        assert_eq!(enter(&mut contexts, &["a"]), Ok(false));
        assert_eq!((*contexts.current(), contexts.name()), (1, Some("a")));
        assert_eq!(enter(&mut contexts, &["b", "=", "b"]), Ok(false));
        assert_eq!(*contexts.current(), 2);
        assert_eq!(enter(&mut contexts, &["b", "="]), Ok(true));
        assert_eq!(*contexts.current(), 0);
        assert_eq!(enter(&mut contexts, &[]), Ok(true));
        assert_eq!((*contexts.current(), contexts.name()), (0, None));
    }

    #[test]
    fn unknown_names_and_templates_are_errors() {
        let mut contexts = Contexts::<u32>::new("colour");
        for (words, part) in [
            (&["a"][..], "t:1: colour 'a' is not defined"),
            (&["a", "=", "a"], "colour 'a' is not defined"),
            (&["b", "=", "a"], "colour 'a' is not defined"),
            (&["a", "a"], "expected '=' after the name, found 'a'"),
            (&["="], "a name as argument 1 of 'c'"),
            (&["a", "=", "b", "c"], "found 4 arguments"),
        ] {
            let message = enter(&mut contexts, words).unwrap_err();
            assert!(message.contains(part), "{message}");
        }
        // What failed left nothing behind.
        assert!(enter(&mut contexts, &["b"]).is_err());
    }
}
