//! Words of pbrt text, with their places.
//!
//! The text has quoted strings, brackets, `#` comments to the line's end, and runs of
//! anything else: numbers, directives, `true` and `false`.

use super::fault::{Place, Read, fault};
use std::borrow::Cow;

/// Kind of a token.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind<'a> {
    /// A directive, number or Boolean.
    Word(&'a str),
    /// A quoted string, without its quotes, escapes resolved.
    Quoted(Cow<'a, str>),
    /// `[`
    Open,
    /// `]`
    Close,
}

impl std::fmt::Display for Kind<'_> {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Kind::Word(word) => write!(out, "`{}`", shortened(word)),
            Kind::Quoted(text) => write!(out, "\"{}\"", shortened(text)),
            Kind::Open => write!(out, "`[`"),
            Kind::Close => write!(out, "`]`"),
        }
    }
}

/// The first characters of a text, control characters made visible, for messages.
pub(super) fn shortened(text: &str) -> String {
    const LONGEST: usize = 40;
    let mut short: String = text
        .chars()
        .take(LONGEST)
        .flat_map(|c| {
            if c.is_control() {
                c.escape_default().collect()
            } else {
                vec![c]
            }
        })
        .collect();
    if text.chars().nth(LONGEST).is_some() {
        short.push_str("...");
    }
    short
}

/// A token and its place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token<'a> {
    pub place: Place,
    pub kind: Kind<'a>,
}

/// The tokens of one file.
pub(super) struct Tokens<'a> {
    rest: &'a str,
    place: Place,
    peeked: Option<Token<'a>>,
}

impl<'a> Tokens<'a> {
    /// Starts at the beginning of a text.
    pub fn new(text: &'a str, file: u32) -> Self {
        Self {
            rest: text.strip_prefix('\u{feff}').unwrap_or(text),
            place: Place {
                file,
                line: 1,
                column: 1,
            },
            peeked: None,
        }
    }

    /// Where the next character stands: after the last token, the file's end.
    pub fn here(&self) -> Place {
        self.peeked.as_ref().map_or(self.place, |token| token.place)
    }

    /// The next token, or `None` at the end of the text.
    pub fn next(&mut self) -> Read<Option<Token<'a>>> {
        if let Some(token) = self.peeked.take() {
            return Ok(Some(token));
        }
        self.skip_blanks_and_comments();
        let place = self.place;
        let Some(first) = self.rest.chars().next() else {
            return Ok(None);
        };
        let kind = match first {
            '[' | ']' => {
                self.take(1);
                if first == '[' {
                    Kind::Open
                } else {
                    Kind::Close
                }
            }
            '"' => Kind::Quoted(self.quoted(place)?),
            _ => {
                let end = self.rest.find(ends_word).unwrap_or(self.rest.len());
                Kind::Word(self.take(end))
            }
        };
        Ok(Some(Token { place, kind }))
    }

    /// The next token, left in place.
    pub fn peek(&mut self) -> Read<Option<&Token<'a>>> {
        if self.peeked.is_none() {
            self.peeked = self.next()?;
        }
        Ok(self.peeked.as_ref())
    }

    /// The next token, which `what` needs.
    pub fn require(&mut self, what: &str) -> Read<Token<'a>> {
        match self.next()? {
            Some(token) => Ok(token),
            None => fault(
                self.place,
                format!("the file ends where {what} should follow; is it truncated?"),
            ),
        }
    }

    /// The next token, which must be a quoted string.
    pub fn string(&mut self, what: &str) -> Read<(String, Place)> {
        let token = self.require(what)?;
        match token.kind {
            Kind::Quoted(text) => Ok((text.into_owned(), token.place)),
            other => fault(
                token.place,
                format!("expected {what} in quotes, found {other}"),
            ),
        }
    }

    /// `count` numbers, in brackets or not.
    pub fn numbers<const N: usize>(&mut self, what: &str) -> Read<[f64; N]> {
        let bracketed = matches!(
            self.peek()?,
            Some(Token {
                kind: Kind::Open,
                ..
            })
        );
        if bracketed {
            self.next()?;
        }
        let mut values = [0.0; N];
        for value in &mut values {
            let token = self.require(what)?;
            *value = number(&token, what)?;
        }
        if bracketed {
            let token = self.require("`]`")?;
            if token.kind != Kind::Close {
                return fault(
                    token.place,
                    format!(
                        "expected `]` after the {N} numbers of {what}, found {}",
                        token.kind
                    ),
                );
            }
        }
        Ok(values)
    }

    /// Takes `bytes` bytes (a boundary of characters), moving the place along.
    fn take(&mut self, bytes: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(bytes);
        for c in taken.chars() {
            if c == '\n' {
                self.place.line += 1;
                self.place.column = 1;
            } else {
                self.place.column += 1;
            }
        }
        self.rest = rest;
        taken
    }

    fn skip_blanks_and_comments(&mut self) {
        loop {
            let blank = self
                .rest
                .find(|c: char| !c.is_ascii_whitespace())
                .unwrap_or(self.rest.len());
            self.take(blank);
            if !self.rest.starts_with('#') {
                return;
            }
            let comment = self.rest.find(['\n', '\r']).unwrap_or(self.rest.len());
            self.take(comment);
        }
    }

    /// A quoted string; the opening quote is next.
    fn quoted(&mut self, place: Place) -> Read<Cow<'a, str>> {
        let mut escaped = false;
        let mut after_backslash = false;
        for (at, c) in self.rest.char_indices().skip(1) {
            match c {
                '\n' => return fault(place, "this string has no closing quote on its line"),
                _ if after_backslash => after_backslash = false,
                '\\' => {
                    after_backslash = true;
                    escaped = true;
                }
                '"' => {
                    let whole = self.take(at + 1);
                    let inner = whole.get(1..at).unwrap_or_default();
                    return if escaped {
                        unescape(inner, place)
                    } else {
                        Ok(Cow::Borrowed(inner))
                    };
                }
                _ => {}
            }
        }
        fault(place, "the file ends inside this string; is it truncated?")
    }
}

fn ends_word(c: char) -> bool {
    c.is_ascii_whitespace() || matches!(c, '"' | '[' | ']' | '#')
}

fn unescape(inner: &str, place: Place) -> Read<Cow<'_, str>> {
    let mut text = String::with_capacity(inner.len());
    let mut chars = inner.chars();
    while let Some(c) = chars.next() {
        if c != '\\' {
            text.push(c);
            continue;
        }
        text.push(match chars.next() {
            Some('n') => '\n',
            Some('t') => '\t',
            Some('r') => '\r',
            Some('b') => '\u{8}',
            Some('f') => '\u{c}',
            Some(c @ ('\\' | '\'' | '"')) => c,
            other => {
                return fault(place, format!("unknown escape {other:?} in a string"));
            }
        });
    }
    Ok(Cow::Owned(text))
}

/// A token as a finite number. Rust's `nan` and `inf` are words here, not numbers.
pub(super) fn number(token: &Token<'_>, what: &str) -> Read<f64> {
    let Kind::Word(word) = token.kind else {
        return fault(
            token.place,
            format!("expected a number for {what}, found {}", token.kind),
        );
    };
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => fault(
            token.place,
            format!("{} in {what} is not a finite number", token.kind),
        ),
        Err(_) => fault(
            token.place,
            format!("expected a number for {what}, found {}", token.kind),
        ),
    }
}
