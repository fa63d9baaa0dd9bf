//! Names and what they stand for.
//!
//! A name is kept with its scope behind it: `size` of file `tiles.cal` is ``size`tiles``. A name is looked for in the
//! present scope first and then outwards; a leading backquote asks for the present scope only, a trailing one for the
//! name exactly as it is written. A name that is nowhere yet gets an entry without definition in the present scope.
//! That a use is tied to what is known when it is read, and not to what a later line of the same file defines, is so in
//! Radiance.

use super::builtin::Builtin;
use super::tree::Definition;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// All names of a context.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Table {
    ids: BTreeMap<Arc<str>, u32>,
    entries: Vec<Entry>,
}

/// One name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    /// With its scope.
    pub name: Arc<str>,
    pub definition: Option<Arc<Definition>>,
    /// The library function of this name; a definition hides it.
    pub builtin: Option<Builtin>,
}

impl Table {
    pub(super) fn entry(&self, id: u32) -> &Entry {
        &self.entries[id as usize]
    }

    /// The entry that `name` means in `scope`, if there is one.
    pub(super) fn find(&self, name: &str, scope: &str) -> Option<u32> {
        let mut level = 0;
        while let Some(qualified) = qualified(name, scope, level) {
            if let Some(&id) = self.ids.get(qualified.as_ref()) {
                return Some(id);
            }
            level += 1;
        }
        None
    }

    /// The entry that `name` means in `scope`, made if there is none.
    pub(super) fn link(&mut self, name: &str, scope: &str) -> u32 {
        if let Some(id) = self.find(name, scope) {
            return id;
        }
        match Builtin::by_name(name) {
            Some(_) => self.exactly(name),
            None => self.local(name, scope),
        }
    }

    /// The entry of a definition of `name` in `scope`, made if there is none.
    pub(super) fn local(&mut self, name: &str, scope: &str) -> u32 {
        let name = qualified(name, scope, 0).unwrap_or(Cow::Borrowed(name));
        self.exactly(&name)
    }

    /// Sets what a name stands for.
    pub(super) fn define(&mut self, id: u32, definition: Definition) {
        self.entries[id as usize].definition = Some(Arc::new(definition));
    }

    fn exactly(&mut self, name: &str) -> u32 {
        if let Some(&id) = self.ids.get(name) {
            return id;
        }
        let id = self.entries.len() as u32;
        let name: Arc<str> = name.into();
        self.ids.insert(name.clone(), id);
        self.entries.push(Entry { builtin: Builtin::by_name(&name), name, definition: None });
        id
    }
}

/// `name` in the scope `level` steps outwards from `scope`; `None` where there is nothing further out to look at.
fn qualified<'a>(name: &'a str, scope: &str, level: usize) -> Option<Cow<'a, str>> {
    let is_local = name.starts_with('`');
    let name = name.strip_prefix('`').unwrap_or(name);
    if let Some(global) = name.strip_suffix('`') {
        return (level == 0).then_some(Cow::Borrowed(global));
    }
    if is_local && level > 0 {
        return None;
    }
    // A scope is "" or "`inner`outer".
    let scope = match level {
        0 => scope,
        _ => {
            let start = scope.match_indices('`').map(|(at, _)| at).chain([scope.len()]).nth(level)?;
            if scope.is_empty() { return None } else { &scope[start..] }
        }
    };
    Some(if scope.is_empty() { Cow::Borrowed(name) } else { Cow::Owned(format!("{name}{scope}")) })
}

/// The scope of a function file, from its name, as in Radiance: without `.cal`, what cannot stand in a name replaced.
pub(super) fn scope_of_file(file: &str) -> String {
    let stem = file.strip_suffix(".cal").filter(|stem| !stem.is_empty()).unwrap_or(file);
    scope_named(stem)
}

/// "`name", or "" for the outermost scope.
pub(super) fn scope_named(name: &str) -> String {
    let name = name.trim_start_matches('`').trim_end_matches('`');
    if name.is_empty() {
        return String::new();
    }
    let allowed = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '.' | '`');
    std::iter::once('`').chain(name.chars().map(|c| if allowed(c) { c } else { '_' })).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(name: &str, scope: &str) -> Vec<String> {
        (0..).map_while(|level| qualified(name, scope, level)).map(Cow::into_owned).collect()
    }

    #[test]
    fn names_are_looked_for_from_the_inside_out() {
        assert_eq!(levels("a", ""), ["a"]);
        assert_eq!(levels("a", "`f"), ["a`f", "a"]);
        assert_eq!(levels("a", "`f`g"), ["a`f`g", "a`g", "a"]);
    }

    #[test]
    fn backquotes_keep_a_name_local_or_global() {
        assert_eq!(levels("`a", "`f"), ["a`f"]);
        assert_eq!(levels("a`", "`f"), ["a"]);
        assert_eq!(levels("a`g", "`f"), ["a`g`f", "a`g"]);
    }

    #[test]
    fn a_file_is_a_scope() {
        assert_eq!(scope_of_file("lib/my tiles.cal"), "`lib_my_tiles");
        assert_eq!(scope_of_file("."), "`.");
        assert_eq!(scope_named(""), "");
    }
}
