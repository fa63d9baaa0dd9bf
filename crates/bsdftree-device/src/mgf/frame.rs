//! Where things are put, and what they are called: the transformations and names around an entity.
//!
//! In: `xf` and `o`, with and without arguments. Out: the total transformation to metres and the prefix of names, `a.b.` for what is in
//! object b of object a. An `xf` with arrays (`-a`) is walked again for each copy, in an object named after it: `a0.2` is copy 0 of the
//! first array and 2 of the second, as mgf2rad names it. Both kinds nest to a bounded depth.

use super::entity::{Entity, unexpected};
use crate::error::{DeviceError, Place};
use crate::rad::{Steps, Transform, Wrong, overflow, too_large};

/// What `xf` opened.
struct Frame {
    /// Without what is around it.
    steps: Steps,
    /// Of each array.
    counts: Vec<u64>,
    /// The copy that is being walked.
    indices: Vec<u64>,
    /// To metres.
    total: Transform,
    /// Line after the `xf`.
    start: usize,
    at: Place,
}

/// A name that `o` or an array gave.
struct Name {
    text: String,
    of_array: bool,
}

/// The frames and names that are open.
pub(super) struct Frames {
    base: Transform,
    frames: Vec<Frame>,
    names: Vec<Name>,
    prefix: String,
    limit: usize,
    /// Most copies of one array.
    most_copies: u64,
}

impl Frames {
    /// `base` takes the file's unit to metres.
    pub(super) fn new(base: Transform, limit: usize, most_copies: u64) -> Self {
        Frames { base, frames: Vec::new(), names: Vec::new(), prefix: String::new(), limit, most_copies }
    }

    /// To metres.
    pub(super) fn transform(&self) -> &Transform {
        self.frames.last().map_or(&self.base, |frame| &frame.total)
    }

    /// What stands before names of surfaces, with its last dot.
    pub(super) fn prefix(&self) -> &str {
        &self.prefix
    }

    /// How many transformations are open.
    pub(super) fn depth(&self) -> usize {
        self.frames.len()
    }

    /// Where the innermost transformation was opened, if more than so many are open.
    pub(super) fn left_open(&self, depth: usize) -> Option<&Place> {
        self.frames.get(depth..)?.last().map(|frame| &frame.at)
    }

    /// `o`, with or without a name.
    pub(super) fn object(&mut self, entity: &Entity<'_>) -> Result<(), DeviceError> {
        entity.count(0..=1, "a name, or nothing at the end of an object")?;
        if !entity.arguments.is_empty() {
            let text = entity.name(0)?.to_owned();
            return self.push_name(Name { text, of_array: false }, &entity.at);
        }
        match self.names.pop() {
            Some(name) if !name.of_array => {
                self.name_changed();
                Ok(())
            }
            _ => Err(entity.unexpected(
                "'o' and a name before 'o' that ends it",
                "no open object".to_owned(),
                "",
            )),
        }
    }

    /// `xf` with arguments, or those of an include; `start` is the line to walk again for copies.
    pub(super) fn open(&mut self, words: &[&str], start: usize, at: &Place) -> Result<(), DeviceError> {
        if self.frames.len() >= self.limit {
            return Err(too_large(at, "transformations inside each other", self.limit as u64));
        }
        let steps = steps(words).map_err(|Wrong { expected, found }| unexpected(at, &expected, found, ""))?;
        let counts: Vec<u64> = steps.copies().collect();
        match counts.iter().try_fold(1, |product: u64, &n| product.checked_mul(n)) {
            Some(copies) if copies <= self.most_copies => {}
            _ => return Err(too_large(at, "copies", self.most_copies)),
        }
        let indices = vec![0; counts.len()];
        if !counts.is_empty() {
            self.push_name(Name { text: array_name(&indices), of_array: true }, at)?;
        }
        let total = self.total(&steps, &indices, self.frames.len(), at)?;
        self.frames.push(Frame { steps, counts, indices, total, start, at: at.clone() });
        Ok(())
    }

    /// The end of the innermost transformation: the line to go on with if there is another copy.
    pub(super) fn close(&mut self, at: &Place) -> Result<Option<usize>, DeviceError> {
        let Some(mut frame) = self.frames.pop() else {
            return Err(unexpected(
                at,
                "'xf' with a transformation before 'xf' that ends it",
                "none".to_owned(),
                "",
            ));
        };
        if frame.counts.is_empty() {
            return Ok(None);
        }
        match self.names.pop() {
            Some(name) if name.of_array => self.name_changed(),
            _ => {
                let found = "an object that was begun inside".to_owned();
                return Err(unexpected(at, "the end of all objects before the array ends", found, "add 'o'"));
            }
        }
        if !step(&mut frame.indices, &frame.counts) {
            return Ok(None);
        }
        self.push_name(Name { text: array_name(&frame.indices), of_array: true }, at)?;
        frame.total = self.total(&frame.steps, &frame.indices, self.frames.len(), at)?;
        let start = frame.start;
        self.frames.push(frame);
        Ok(Some(start))
    }

    fn total(
        &self,
        steps: &Steps,
        indices: &[u64],
        depth: usize,
        at: &Place,
    ) -> Result<Transform, DeviceError> {
        let outer = depth.checked_sub(1).map_or(&self.base, |k| &self.frames[k].total);
        let total = steps.copy(indices).then(outer);
        if total.is_finite() { Ok(total) } else { Err(overflow("a transformation", at)) }
    }

    fn push_name(&mut self, name: Name, at: &Place) -> Result<(), DeviceError> {
        // Arrays have names too.
        if self.names.len() >= 2 * self.limit {
            return Err(too_large(at, "objects inside each other", 2 * self.limit as u64));
        }
        self.names.push(name);
        self.name_changed();
        Ok(())
    }

    fn name_changed(&mut self) {
        self.prefix = self.names.iter().map(|name| format!("{}.", name.text)).collect();
    }
}

fn steps(words: &[&str]) -> Result<Steps, Wrong> {
    let mut steps = Steps::default();
    let mut at = 0;
    while at < words.len() {
        match steps.take(&words[at..])? {
            0 => return Err(Wrong::new("one of -t -rx -ry -rz -s -mx -my -mz -i -a", Some(words[at]))),
            used => at += used,
        }
    }
    Ok(steps)
}

/// The next copy, the last array varying fastest; whether there is one.
fn step(indices: &mut [u64], counts: &[u64]) -> bool {
    for (index, count) in indices.iter_mut().zip(counts).rev() {
        *index += 1;
        if *index < *count {
            return true;
        }
        *index = 0;
    }
    false
}

fn array_name(indices: &[u64]) -> String {
    let numbers: Vec<String> = indices.iter().map(u64::to_string).collect();
    format!("a{}", numbers.join("."))
}
