//! Lines of OBJ and MTL files.

use std::io::{self, BufRead, Read};

/// Statements with the numbers of their (first) lines: comments, blank lines and the
/// backslashes of continued lines are gone.
pub(super) fn statements(text: &str) -> impl Iterator<Item = (u32, String)> {
    let mut lines = (1_u32..).zip(text.lines());
    std::iter::from_fn(move || {
        loop {
            let (number, line) = lines.next()?;
            let mut statement = without_comment(line).to_owned();
            while statement.ends_with('\\') {
                statement.pop();
                let Some((_, next)) = lines.next() else { break };
                statement.push(' ');
                statement.push_str(without_comment(next));
            }
            if !statement.trim().is_empty() {
                return Some((number, statement.trim().to_owned()));
            }
        }
    })
}

/// A comment runs from `#`, at the start or after a blank, to the line's end; a name may
/// have one inside.
fn without_comment(line: &str) -> &str {
    let is_start = |&(at, _): &(usize, &str)| {
        line.get(..at)
            .is_some_and(|before| before.is_empty() || before.ends_with(char::is_whitespace))
    };
    let comment = line.match_indices('#').find(is_start);
    let end = comment.map_or(line.len(), |(at, _)| at);
    line.get(..end).unwrap_or(line).trim_end()
}

/// Hands text to `tobj` and counts the lines that it takes.
pub(super) struct Reader<'a> {
    lines: &'a [u32],
    rest: &'a [u8],
    read: usize,
}

impl<'a> Reader<'a> {
    /// At the start of `text`, whose lines have these numbers in the file.
    pub(super) fn new(text: &'a str, lines: &'a [u32]) -> Self {
        Self {
            lines,
            rest: text.as_bytes(),
            read: 0,
        }
    }

    /// The file's line of the last line read.
    pub(super) fn line(&self) -> u32 {
        let last = self.read.checked_sub(1);
        let line = last.and_then(|last| self.lines.get(last));
        line.copied().unwrap_or(0)
    }
}

impl Read for Reader<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.rest.read(buffer)?;
        let read = buffer.get(..count).unwrap_or(&[]);
        self.read += read.iter().filter(|&&byte| byte == b'\n').count();
        Ok(count)
    }
}

impl BufRead for Reader<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        Ok(self.rest)
    }

    fn consume(&mut self, count: usize) {
        let (read, rest) = self.rest.split_at(count.min(self.rest.len()));
        self.read += read.iter().filter(|&&byte| byte == b'\n').count();
        self.rest = rest;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_are_joined_and_stripped() {
        let text = "# c\n\n v 1 \\\n 2 3 # d\r\no a#b\n";
        let got: Vec<_> = statements(text).collect();
        assert_eq!(got, [(3, "v 1   2 3".to_owned()), (5, "o a#b".to_owned())]);
    }

    #[test]
    fn the_reader_names_the_line_of_what_it_has_read() {
        let mut reader = Reader::new("a\nb\nc\n", &[3, 7, 9]);
        assert_eq!(reader.line(), 0);
        let mut line = String::new();
        reader.read_line(&mut line).unwrap();
        reader.read_line(&mut line).unwrap();
        assert_eq!((line.as_str(), reader.line()), ("a\nb\n", 7));
        reader.read_to_string(&mut line).unwrap();
        assert_eq!(reader.line(), 9);
    }
}
