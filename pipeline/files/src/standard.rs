//! Standard output and error, where a closed or full one ends the program with a message or with
//! nothing, and the standard library's macros would panic.

use std::fmt::Arguments;
use std::io::Write;

/// Writes to standard output, or ends the program with exit code 1: what it was asked for cannot be
/// said.
pub fn print_or_end(text: Arguments, end: &str) {
    let mut out = std::io::stdout().lock();
    let written = out
        .write_fmt(text)
        .and_then(|()| out.write_all(end.as_bytes()))
        .and_then(|()| out.flush());
    if let Err(error) = written {
        print_error(format_args!(
            "rrf: standard output cannot be written: {error}"
        ));
        std::process::exit(1);
    }
}

/// Writes a line to standard error, if that is possible.
pub fn print_error(text: Arguments) {
    let mut err = std::io::stderr().lock();
    let _ = err.write_fmt(text).and_then(|()| err.write_all(b"\n"));
}
