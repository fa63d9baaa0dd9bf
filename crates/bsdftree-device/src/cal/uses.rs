//! What parts of a program depend on, through whatever they call.

use super::inputs::Uses;
use std::collections::BTreeMap;

/// What each part uses by itself, and which parts need it.
pub(super) struct Dependencies<P> {
    uses: BTreeMap<P, Uses>,
    needed_by: BTreeMap<P, Vec<P>>,
}

impl<P> Default for Dependencies<P> {
    fn default() -> Self {
        Dependencies { uses: BTreeMap::new(), needed_by: BTreeMap::new() }
    }
}

impl<P: Copy + Ord> Dependencies<P> {
    /// Notes that `part` uses an input itself.
    pub(super) fn uses(&mut self, part: P, uses: Uses) {
        self.uses.entry(part).or_default().add(uses);
    }

    /// Notes that `part` may need `other`.
    pub(super) fn needs(&mut self, part: P, other: P) {
        self.needed_by.entry(other).or_default().push(part);
    }

    /// What each part uses, directly or not; parts that use nothing may be missing.
    pub(super) fn resolve(mut self) -> BTreeMap<P, Uses> {
        for users in self.needed_by.values_mut() {
            users.sort_unstable();
            users.dedup();
        }
        let mut changed: Vec<P> = self.uses.keys().copied().collect();
        while let Some(part) = changed.pop() {
            let uses = self.uses[&part];
            for &user in self.needed_by.get(&part).into_iter().flatten() {
                let known = self.uses.entry(user).or_default();
                let before = *known;
                known.add(uses);
                if *known != before {
                    changed.push(user);
                }
            }
        }
        self.uses
    }
}
