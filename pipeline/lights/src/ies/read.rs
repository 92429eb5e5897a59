//! LM-63 files to tables.

use super::web::{IesProfile, Photometry};
use crate::error::LightError;

/// Largest file that is read: the longest published ones have below 1 MB.
const MOST_BYTES: usize = 16 << 20;

impl IesProfile {
    /// Reads a file's bytes. What comes before the `TILT=` line is version and keywords, which
    /// change no light.
    ///
    /// # Errors
    /// [`LightError::Ies`] with the line.
    pub fn from_bytes(bytes: &[u8]) -> Result<IesProfile, LightError> {
        if bytes.len() > MOST_BYTES {
            return fault(
                1,
                format!("{} bytes; at most {MOST_BYTES} are read", bytes.len()),
            );
        }
        let text = String::from_utf8_lossy(bytes);
        let mut lines = text.lines().enumerate();
        let tilt = lines.find_map(|(at, line)| {
            let value = line.trim().strip_prefix("TILT")?.trim_start();
            Some((at + 1, value.strip_prefix('=')?.trim().to_ascii_uppercase()))
        });
        let Some((line, tilt)) = tilt else {
            return fault(1, "no line `TILT=`: not an IES profile");
        };
        let mut numbers = Numbers {
            words: lines
                .flat_map(|(at, line)| {
                    let split = |c: char| c == ',' || c.is_ascii_whitespace();
                    let words = line.split(split).filter(|word| !word.is_empty());
                    words.map(move |word| (at + 1, word))
                })
                .collect(),
            at: 0,
            line,
        };
        match tilt.as_str() {
            "NONE" => {}
            "INCLUDE" => skip_tilt(&mut numbers)?,
            _ => return fault(line, "TILT names a file; TILT=NONE or TILT=INCLUDE is read"),
        }
        let edition = text.lines().next().unwrap_or_default();
        profile(&mut numbers, edition.contains("LM-63-2019"))
    }
}

/// The tilt of a lamp changes its output, which the file's intensities already contain for
/// the position that they were measured in.
fn skip_tilt(numbers: &mut Numbers) -> Result<(), LightError> {
    numbers.next("lamp to luminaire geometry")?;
    let pairs = numbers.count("number of tilt angles")?;
    numbers.list("tilt angles", pairs)?;
    numbers.list("tilt factors", pairs)?;
    Ok(())
}

/// What follows the tilt. LM-63-2019 has the file's generation type, which is no factor, where
/// editions up to 1995 have the ballast-lamp photometric factor (2002: reserved, 1).
fn profile(numbers: &mut Numbers, factor_is_generation: bool) -> Result<IesProfile, LightError> {
    for what in ["number of lamps", "lumens per lamp"] {
        numbers.next(what)?;
    }
    let multiplier = numbers.next("candela multiplier")?;
    let vertical = numbers.count("number of vertical angles")?;
    let horizontal = numbers.count("number of horizontal angles")?;
    let photometry = match numbers.next("photometric type")? {
        1.0 => Photometry::C,
        2.0 => Photometry::B,
        3.0 => Photometry::A,
        other => {
            let message = format!("photometric type {other}; 1 (C), 2 (B) or 3 (A) is read");
            return fault(numbers.line, message);
        }
    };
    for what in ["units type", "width", "length", "height"] {
        numbers.next(what)?;
    }
    let ballast = numbers.next("ballast factor")?;
    let photometric = numbers.next("ballast-lamp photometric factor")?;
    numbers.next("input watts")?;
    let factor = if factor_is_generation {
        multiplier * ballast
    } else {
        multiplier * ballast * photometric
    };
    let vertical = numbers.list("vertical angles", vertical)?.to_vec();
    let horizontal = numbers.list("horizontal angles", horizontal)?.to_vec();
    let line = numbers.line;
    let candela = numbers.list("candela values", vertical.len() * horizontal.len())?;
    let candela = candela.iter().map(|&value| value * factor).collect();
    IesProfile::new(photometry, vertical, horizontal, candela)
        .map_err(|message| LightError::Ies { line, message })
}

/// The numbers after the `TILT=` line, one after another.
struct Numbers<'a> {
    words: Vec<(usize, &'a str)>,
    at: usize,
    /// Line of the last number read.
    line: usize,
}

impl Numbers<'_> {
    fn next(&mut self, what: &str) -> Result<f32, LightError> {
        let Some(&(line, word)) = self.words.get(self.at) else {
            return fault(
                self.line,
                format!("the file ends where the {what} should be"),
            );
        };
        (self.line, self.at) = (line, self.at + 1);
        match word.parse::<f32>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => {
                let word: String = word.chars().take(24).collect();
                fault(
                    line,
                    format!("`{word}` where the {what} should be: no finite number"),
                )
            }
        }
    }

    /// A number of entries, each of which takes a word that the file must still have.
    fn count(&mut self, what: &str) -> Result<usize, LightError> {
        let value = self.next(what)?;
        let left = self.words.len() - self.at;
        if value.fract() != 0.0 || value < 1.0 || value > left as f32 {
            let message = format!("{what} {value}; from 1 to the {left} numbers that follow");
            return fault(self.line, message);
        }
        Ok(value as usize)
    }

    fn list(&mut self, what: &str, count: usize) -> Result<Vec<f32>, LightError> {
        let left = self.words.len() - self.at;
        if count > left {
            let message = format!("{count} {what} are announced, but {left} numbers follow");
            return fault(self.line, message);
        }
        (0..count).map(|_| self.next(what)).collect()
    }
}

fn fault<T>(line: usize, message: impl Into<String>) -> Result<T, LightError> {
    Err(LightError::Ies {
        line,
        message: message.into(),
    })
}
