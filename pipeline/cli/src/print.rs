//! Macros in the standard library's place: a closed or full standard output ends the program with a
//! message, a closed standard error with nothing, where those would panic.

/// A number with four digits, as messages show it.
pub fn short(x: f32) -> String {
    let rounded = format!("{x:.3e}");
    rounded.parse::<f64>().map_or(rounded, |x| x.to_string())
}

macro_rules! println {
    ($($text:tt)*) => { rrf_files::print_or_end(format_args!($($text)*), "\n") };
}

macro_rules! print {
    ($($text:tt)*) => { rrf_files::print_or_end(format_args!($($text)*), "") };
}

macro_rules! eprintln {
    ($($text:tt)*) => { rrf_files::print_error(format_args!($($text)*)) };
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn four_digits_are_shown() {
        let shown = [-0.799_999_95, 1234.56, 1e-7, 0.0, f32::NAN].map(short);
        assert_eq!(shown, ["-0.8", "1235", "0.0000001", "0", "NaN"]);
    }
}
