//! Pictures that a scene names and that cannot be read.

use crate::Warning;
use std::path::Path;

/// Pictures named in the warning; the rest are counted.
const NAMED: usize = 100;

/// The names of pictures that cannot be read, each with the reason.
#[derive(Default)]
pub(crate) struct LostPictures(Vec<(String, String)>);

impl LostPictures {
    /// Notes a picture, once a name.
    pub(crate) fn add(&mut self, name: &str, reason: impl std::fmt::Display) {
        if !self.has(name) {
            self.0.push((name.to_owned(), reason.to_string()));
        }
    }

    /// Whether the picture was noted before.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.0.iter().any(|(known, _)| known == name)
    }

    /// One warning that names them all, with the `albedo` that colours are read as.
    pub(crate) fn warning(&self, source: &Path, albedo: f32) -> Option<Warning> {
        let count = self.0.len();
        if count == 0 {
            return None;
        }
        let named: Vec<String> = self
            .0
            .iter()
            .take(NAMED)
            .map(|(name, reason)| format!("{name} ({reason})"))
            .collect();
        let more = match count.saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let pictures = if count == 1 { "picture" } else { "pictures" };
        let message = format!(
            "{count} {pictures} cannot be read: {}{more}; a colour is read as {albedo} in its \
             place, other maps are left out; put the files beside the scene",
            named.join(", ")
        );
        Some(Warning {
            place: source.display().to_string(),
            message,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_are_named_once() {
        let mut lost = LostPictures::default();
        assert_eq!(lost.warning(Path::new("a.obj"), 0.7), None);
        for i in 0..102 {
            lost.add(&format!("{i}.png"), "gone");
            lost.add(&format!("{i}.png"), "gone");
        }
        let warning = lost.warning(Path::new("a.obj"), 0.7).unwrap();
        let starts = "102 pictures cannot be read: 0.png (gone), 1.png (gone), ";
        assert!(warning.message.starts_with(starts), "{}", warning.message);
        assert!(
            warning
                .message
                .contains(" and 2 more; a colour is read as 0.7")
        );
    }
}
