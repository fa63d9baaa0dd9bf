//! The command line of Radiance's `xform`.
//!
//! In: the words after `xform`. Out: the files it names and the copies it makes of them. `-f` is expanded before, see
//! `command`. Source: Radiance manual page `xform`; identifiers of copies as its 2025 release prints them:
//! `name.1.0.2.id`, first the line number in each argument file, then the index in each array. Without `-n` the name
//! is `i` after argument files, else `a`.

use super::transform::{Steps, Transform, Wrong};

/// What an `xform` command does.
#[derive(Clone, Debug, Default)]
pub(super) struct Xform {
    names: Vec<String>,
    /// `-m`: the modifier for all surfaces.
    pub modifier: Option<String>,
    /// `-I`: whether surfaces are turned over.
    pub invert: bool,
    /// `-c` was not given: commands in a file run in that file's directory.
    pub in_file_directory: bool,
    steps: Steps,
    argument_lines: Vec<u64>,
    /// The scene files.
    pub files: Vec<String>,
}

/// One of the copies that an `xform` command makes.
pub(super) struct Copy {
    /// What stands before the identifiers, with its dots; may be empty.
    pub prefix: String,
    pub transform: Transform,
}

impl Xform {
    /// A command that only includes files, as `cat` does: they are not run in their own directories.
    pub(super) fn cat(files: &[String]) -> Self {
        Xform { files: files.to_vec(), ..Xform::default() }
    }

    /// Reads the words after `xform`, to which the given lines of argument files have led.
    pub(super) fn parse(words: &[String], argument_lines: &[u64]) -> Result<Self, Wrong> {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let mut xform =
            Xform { in_file_directory: true, argument_lines: argument_lines.to_vec(), ..Xform::default() };
        let mut at = 0;
        while let used @ 1.. = xform.option(&words[at..])? {
            at += used;
        }
        while let used @ 1.. = xform.steps.take(&words[at..])? {
            at += used;
        }
        let files = &words[at..];
        if let Some(first) = files.first().filter(|word| word.starts_with('-')) {
            let expected =
                "an option of xform (first -n -m -I -c -f, then -t -rx -ry -rz -s -mx -my -mz -i -a)";
            return Err(Wrong::new(expected, Some(first)));
        }
        xform.files = files.iter().map(|&file| file.to_owned()).collect();
        Ok(xform)
    }

    /// Takes one of the options that stand before the transformation; 0 if there is none.
    fn option(&mut self, words: &[&str]) -> Result<usize, Wrong> {
        let value = || match words.get(1) {
            Some(word) => Ok((*word).to_owned()),
            None => Err(Wrong::new(format!("a name after {}", words[0]), None)),
        };
        match words.first() {
            Some(&"-n") => self.names.push(value()?),
            Some(&"-m") => self.modifier = Some(value()?),
            Some(&"-I") => {
                self.invert = true;
                return Ok(1);
            }
            Some(&"-c") => {
                self.in_file_directory = false;
                return Ok(1);
            }
            // Expands commands, which is the default.
            Some(&"-e") => return Ok(1),
            _ => return Ok(0),
        }
        Ok(2)
    }

    /// How many copies it makes; `None` if they cannot be counted.
    pub(super) fn n_copies(&self) -> Option<u64> {
        self.steps.copies().try_fold(1, u64::checked_mul)
    }

    /// Copy `k` of [`Self::n_copies`]; the last array varies fastest.
    pub(super) fn copy(&self, k: u64) -> Copy {
        let counts: Vec<u64> = self.steps.copies().collect();
        let mut indices = vec![0; counts.len()];
        let mut rest = k;
        for (index, count) in indices.iter_mut().zip(&counts).rev() {
            (*index, rest) = (rest % count, rest / count);
        }
        Copy { prefix: self.prefix(&indices), transform: self.steps.copy(&indices) }
    }

    fn prefix(&self, indices: &[u64]) -> String {
        let numbers: Vec<u64> = self.argument_lines.iter().chain(indices).copied().collect();
        let mut names = self.names.iter();
        let mut prefix = match names.next() {
            Some(name) => format!("{name}."),
            None if !self.argument_lines.is_empty() => "i".to_owned(),
            None if !numbers.is_empty() => "a".to_owned(),
            None => String::new(),
        };
        numbers.iter().for_each(|number| prefix += &format!("{number}."));
        names.for_each(|name| prefix += &format!("{name}."));
        prefix
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn parse(text: &str) -> Result<Xform, Wrong> {
        Xform::parse(&super::super::words::split(text), &[])
    }

    #[test]
    fn last_array_varies_fastest() {
        let xform = parse("-n x -n y -a 2 -t 1 0 0 -a 3 -t 0 1 0 -i 1 -s 2 f").unwrap();
        assert_eq!(xform.n_copies(), Some(6));
        let copy = xform.copy(5);
        assert_eq!(copy.prefix, "x.1.2.y.");
        assert_eq!(copy.transform.point(DVec3::ZERO), DVec3::new(2.0, 4.0, 0.0));
        assert_eq!(xform.copy(3).prefix, "x.1.0.y.");
        assert_eq!(parse("-a 4 f").unwrap().copy(3).prefix, "a3.");
        assert_eq!(parse("f").unwrap().copy(0).prefix, "");
    }

    #[test]
    fn options_come_before_the_transformation() {
        assert!(parse("-t 1 0 0 -n late f").unwrap_err().found == "'-n'");
        assert!(parse("-n").unwrap_err().expected == "a name after -n");
        let xform = parse("-I -c -e -m red -mx a b").unwrap();
        assert!(xform.invert && !xform.in_file_directory);
        assert_eq!((xform.modifier.as_deref(), xform.files.len()), (Some("red"), 2));
    }

    #[test]
    fn uncountable_arrays_are_none() {
        assert_eq!(parse("-a 1e19 -a 1e19 f").unwrap().n_copies(), None);
    }
}
