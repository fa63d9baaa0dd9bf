//! Words of a Radiance scene text, with line numbers.
//!
//! In: text. Out: words, comments skipped, commands as one line. A word is a run of non-white characters, or is
//! quoted by `"` or `'`. Comments and commands begin only where a statement may begin, as in Radiance; a `#` inside a
//! primitive is an ordinary character. A command continues over lines that end with a backslash.

/// Position in a text.
pub(super) struct Words<'a> {
    text: &'a str,
    at: usize,
    line: u32,
}

/// What a statement begins with.
pub(super) enum Lead<'a> {
    /// The text is over.
    End,
    /// The line after `!`, and its line number.
    Command(String, u32),
    /// The first word of a primitive or alias.
    Word(Word<'a>),
}

/// A word and its line.
pub(super) struct Word<'a> {
    /// Without its quotes.
    pub text: &'a str,
    /// Where it begins, counted from 1.
    pub line: u32,
}

impl<'a> Words<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Words { text: text.strip_prefix('\u{feff}').unwrap_or(text), at: 0, line: 1 }
    }

    /// The current line.
    pub(super) fn line(&self) -> u32 {
        self.line
    }

    /// How many bytes are left: no count in the text can honestly exceed it.
    pub(super) fn bytes_left(&self) -> usize {
        self.text.len() - self.at
    }

    /// Skips comments and begins a statement.
    pub(super) fn lead(&mut self) -> Lead<'a> {
        loop {
            self.skip_white();
            match self.text.as_bytes().get(self.at) {
                None => return Lead::End,
                Some(b'#') => self.at += self.rest_of_line().len(),
                Some(b'!') => {
                    let line = self.line;
                    self.at += 1;
                    return Lead::Command(self.command(), line);
                }
                // Not the end, so there is a word.
                Some(_) => return self.word().map_or(Lead::End, Lead::Word),
            }
        }
    }

    /// The next word, `None` at the end of the text.
    pub(super) fn word(&mut self) -> Option<Word<'a>> {
        self.skip_white();
        let line = self.line;
        let rest = &self.text[self.at..];
        let first = rest.chars().next()?;
        let (word, used) = if first == '"' || first == '\'' {
            let inside = &rest[1..];
            let end = inside.find(first).unwrap_or(inside.len());
            (&inside[..end], (end + 2).min(rest.len()))
        } else {
            let end = rest.find(is_white).unwrap_or(rest.len());
            (&rest[..end], end)
        };
        self.line += rest[..used].bytes().filter(|&b| b == b'\n').count() as u32;
        self.at += used;
        Some(Word { text: word, line })
    }

    fn command(&mut self) -> String {
        let mut command = String::new();
        loop {
            let part = self.rest_of_line();
            self.at += part.len();
            let part = part.strip_suffix('\r').unwrap_or(part);
            let Some(continued) = part.strip_suffix('\\') else {
                command.push_str(part);
                return command;
            };
            command.push_str(continued);
            if self.at < self.text.len() {
                self.at += 1;
                self.line += 1;
            }
        }
    }

    fn rest_of_line(&self) -> &'a str {
        let rest = &self.text[self.at..];
        &rest[..rest.find('\n').unwrap_or(rest.len())]
    }

    fn skip_white(&mut self) {
        for &byte in &self.text.as_bytes()[self.at..] {
            if !is_white(byte as char) {
                break;
            }
            self.line += u32::from(byte == b'\n');
            self.at += 1;
        }
    }
}

/// White space of C's locale, so that the same words are seen as in Radiance.
fn is_white(c: char) -> bool {
    matches!(c, ' ' | '\t' | '\n' | '\r' | '\x0b' | '\x0c')
}

/// Splits a command or an argument line into words, quotes removed.
pub(super) fn split(line: &str) -> Vec<String> {
    let mut words = Words::new(line);
    std::iter::from_fn(|| words.word().map(|w| w.text.to_owned())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_know_their_lines() {
        let mut words = Words::new("# head\n\nvoid plastic \"a b\"\n'c\nd' e#f");
        let Lead::Word(first) = words.lead() else { panic!("a word leads") };
        assert_eq!((first.text, first.line), ("void", 3));
        let rest: Vec<_> = std::iter::from_fn(|| words.word()).map(|w| (w.text.to_owned(), w.line)).collect();
        assert_eq!(rest, [("plastic".into(), 3), ("a b".into(), 3), ("c\nd".into(), 4), ("e#f".into(), 5)]);
    }

    #[test]
    fn commands_continue_after_a_backslash() {
        let mut words = Words::new("!xform a \\\r\n  b\nnext");
        let Lead::Command(command, 1) = words.lead() else { panic!("a command leads") };
        assert_eq!(command, "xform a \\\r  b".replace("\\\r", ""));
        let Lead::Word(word) = words.lead() else { panic!("a word follows") };
        assert_eq!((word.text, word.line), ("next", 3));
    }

    #[test]
    fn unfinished_quotes_and_commands_end_with_the_text() {
        let mut words = Words::new("\"abc");
        assert_eq!(words.word().unwrap().text, "abc");
        assert!(words.word().is_none());
        let mut words = Words::new("!abc \\");
        let Lead::Command(command, _) = words.lead() else { panic!("a command leads") };
        assert_eq!(command, "abc ");
        assert!(matches!(words.lead(), Lead::End));
    }
}
