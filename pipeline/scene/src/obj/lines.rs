//! Lines of OBJ and MTL files.

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_are_joined_and_stripped() {
        let text = "# c\n\n v 1 \\\n 2 3 # d\r\no a#b\n";
        let got: Vec<_> = statements(text).collect();
        assert_eq!(got, [(3, "v 1   2 3".to_owned()), (5, "o a#b".to_owned())]);
    }
}
