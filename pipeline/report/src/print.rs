//! Macros in the standard library's place, which would panic where nothing can be printed.

macro_rules! println {
    ($($text:tt)*) => { rrf_files::print_or_end(format_args!($($text)*), "\n") };
}

macro_rules! eprintln {
    ($($text:tt)*) => { rrf_files::print_error(format_args!($($text)*)) };
}
