//! The one place that prints: a closed or full standard output ends the program with a message,
//! and a closed standard error with nothing, where the standard library's macros would panic.

use std::fmt::Arguments;
use std::io::Write;

/// Writes to standard output, or ends the program: what it was asked for cannot be said.
pub fn out(text: Arguments, end: &str) {
    let mut out = std::io::stdout().lock();
    let written = out
        .write_fmt(text)
        .and_then(|()| out.write_all(end.as_bytes()))
        .and_then(|()| out.flush());
    if let Err(error) = written {
        err(format_args!(
            "rrf: standard output cannot be written: {error}"
        ));
        std::process::exit(1);
    }
}

/// Writes a line to standard error, if that is possible.
pub fn err(text: Arguments) {
    let mut err = std::io::stderr().lock();
    let _ = err.write_fmt(text).and_then(|()| err.write_all(b"\n"));
}

macro_rules! println {
    ($($text:tt)*) => { $crate::print::out(format_args!($($text)*), "\n") };
}

macro_rules! print {
    ($($text:tt)*) => { $crate::print::out(format_args!($($text)*), "") };
}

macro_rules! eprintln {
    ($($text:tt)*) => { $crate::print::err(format_args!($($text)*)) };
}
